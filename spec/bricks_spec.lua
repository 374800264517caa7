--- Grids in bricks: the samples of one bake, the same files whoever bakes them, going on after an end, and refusals.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local kills = require "spec.support.kills"
local long = require "spec.support.long"
local random = require "spec.support.random".minimal
local scratch = require "spec.support.scratch"

local box = grids.box
-- One lamp covers corners of bricks, so that points in it are filled from several of them.
local lamps = {
  ylm.sphere_light { at = { 0.1, 0.02, 0 }, radius = 0.3, radiance = { 10, 8, 6 } },
  ylm.sphere_light { at = { -0.7, 0.1, -0.5 }, radius = 0.05, radiance = { 2, 8, 20 } },
  ylm.sphere_light { at = { 0.5, 3, -2 }, radius = 0.5, radiance = 4 },
}

--- Random points, half of them on faces of voxels of a level.
local function places(n, level, seed)
  local r, points, edges = random(seed), ylm.zeros({ n, 3 }, "double"), 2 ^ level
  for i = 1, n do
    local x = { r(), r(), r() }
    local axis = 1 + i % 3
    if i % 2 == 0 then x[axis] = math.floor(x[axis] * (edges + 1)) / edges end
    for a = 1, 3 do points:set(i, a, box[1][a] + x[a] * (box[2][a] - box[1][a])) end
  end
  return points
end

--- A description, with more fields.
local function described(more)
  local d = { bounds = box, lmax = 2, depth = 5, threshold = 0.1 }
  for k, v in pairs(more or {}) do d[k] = v end
  return ylm.adaptive_grid(d)
end

describe("a grid in bricks", function()
  local folder
  before_each(function() folder = scratch.new "/dev/shm" end) -- each file is written through to the disk
  after_each(function() folder:remove() end)

  local function to(name) return folder.path .. "/" .. (name or "grid.ylmd") end

  --- All files but the lock, with their sums.
  local function sums(name)
    return scratch.capture(("cd %s && find . -type f | LC_ALL=C sort | xargs cksum"):format(scratch.quote(to(name))))
  end

  --- Saves a set as packed.ylm, which is, byte by byte, the file of the set's grid in memory.
  local function assert_packed(set)
    assert(set:save(folder.path .. "/packed.ylm"))
    local whole = assert(core.grid_set_pack(set, 1))
    assert(core.grid_write(whole, folder.path .. "/whole.ylm"))
    core.grid_close(whole)
    assert.is_true(folder:read "packed.ylm" == folder:read "whole.ylm")
  end

  for name, case in pairs {
    ["everywhere"] = { bricks = 1 },
    ["along a floor"] = { bricks = 2, depth = 6, occupied = true },
    ["with jumps between levels"] = { bricks = 2, continuous = false, occupied = true },
    ["after giving up what grew too large"] = { bricks = 1, points = 600 },
  } do
    it("samples as one bake does, to the bit: " .. name, function()
      local occupied = case.occupied and grids.occupied or nil
      local more = { depth = case.depth, threshold = case.threshold, continuous = case.continuous }
      local one = assert(ylm.bake(described(more), lamps, { occupied = occupied }))
      more.bricks = case.bricks
      local set = assert(ylm.bake(described(more), lamps, { occupied = occupied, folder = to(), brick_points = case.points }))
      local points = places(4000, case.bricks + 1, grids.seed)
      local a, da, of_one = one:sample(points, { derivatives = 1 })
      local b, db, of_set = set:sample(points, { derivatives = 1 })
      assert.equal(0, core.array_distance(a, b))
      assert.equal(0, core.array_distance(da, db))
      assert.same({ of_one.outside, of_one.unbaked }, { of_set.outside, of_set.unbaked })
      assert.is_true(set.stats.bricks > 8 ^ case.bricks / 8)
      if case.points then assert.is_true(set.stats.bricks > 8) end
      -- As one file, too: written brick by brick, it is that of the grid in memory.
      local packed = folder.path .. "/packed.ylm"
      assert_packed(set)
      local grid = ylm.load(packed)
      assert.equal(0, core.array_distance(a, (grid:sample(points))))
      assert.same({ one.stats.points, one.stats.cells, one.stats.interpolated, one.stats.invalid },
        { grid.stats.points, grid.stats.cells, grid.stats.interpolated, grid.stats.invalid })
    end)
  end

  it("has the same files whatever the number of threads", function()
    assert(ylm.bake(described { bricks = 2 }, lamps, { folder = to "one.ylmd", threads = 1, brick_points = 1000 }))
    assert(ylm.bake(described { bricks = 2 }, lamps, { folder = to "two.ylmd", threads = 2, brick_points = 1000 }))
    assert.equal(sums "one.ylmd", sums "two.ylmd")
  end)

  it("has fewer points in a brick where they are foreseen to take longer than brick_seconds", function()
    local forms = {}
    for i, options in ipairs { { brick_points = 512 }, { brick_seconds = 1e-9 }, { brick_points = 65536, brick_seconds = 1e9 },
      {} } do
      options.folder, options.fresh = to(), true
      assert(ylm.bake(described { bricks = 1, lmax = 0, depth = 3 }, lamps, options))
      forms[i] = folder:read "grid.ylmd/form"
    end
    assert.equal(forms[1], forms[2])
    assert.equal(forms[3], forms[4])
    assert.not_equal(forms[1], forms[3])
  end)

  if long(false, true) then
    local tool = require "spec.support.tool"
    it("is drawn by examples/cluster/bricks_picture.lua", function()
      local out, status = scratch.capture(("%s run examples/cluster/bricks_picture.lua --quick --out %s"):format(tool.command,
        scratch.quote(folder.path .. "/picture")))
      assert(status == 0 and out:find "%d+ points in %d+ bricks", out)
    end)
  end

  it("goes on where it was, to the same files, and opens what is finished", function()
    local description = described { bricks = 1 }
    assert(ylm.bake(description, lamps, { folder = to "whole.ylmd" }))
    local grid, message, code
    for stop = 2, 14, 3 do
      local seen = 0
      grid, message, code = ylm.bake(description, lamps, { folder = to(), threads = 1, progress = function(_, _, stage)
        if stage ~= "level 0" and stage ~= "top" then seen = seen + 1 end
        return seen < stop * 3
      end })
      if grid then break end
      assert.equal("ECANCELLED", code, message)
      local loaded, why, kind = ylm.load(to())
      assert.is_nil(loaded)
      assert.matches("has not finished", why)
      assert.equal("EIO", kind)
    end
    grid = grid or assert(ylm.bake(description, lamps, { folder = to() }))
    assert.equal(sums "whole.ylmd", sums())
    local again = assert(ylm.bake(description, lamps, { folder = to() }))
    assert.equal(grid.stats.points, again.stats.points)
  end)

  it("keeps a tolerance, of points, of surfaces and everywhere, and says so", function()
    for _, o in ipairs { {}, { occupied = grids.occupied }, { geometry = ylm.sphere { radius = 0.8 } } } do
      local one = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.05 }, grids.lamps, o)
      o.folder, o.fresh = to(), true
      local set = assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.05, bricks = 1 },
        grids.lamps, o))
      assert.equal(one.stats.met, set.stats.met)
      assert.is_true(set.stats.verified > 1000 and set.stats.error <= 0.05, set.stats.error)
      assert.is_true(set.stats.points < 3 * one.stats.points, set.stats.points)
      assert_packed(set)
    end
  end)

  it("is packed where bricks are leaves, split for continuity alone, as it is or in few bytes", function()
    local set = assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 5, tolerance = 0.3, bricks = 3 }, lamps,
      { folder = to(), occupied = grids.occupied }))
    local leaves, added = 0, 0
    for i = 1, set.stats.bricks do
      local stats = core.grid_file_look(core.grid_set_file(set, i)).stats
      if stats.cells == 1 then leaves, added = leaves + 1, added + stats.continuity end
    end
    assert.is_true(leaves > 10 and leaves < set.stats.bricks and added > 0, leaves)
    assert_packed(set)
    assert(set:save(to "few.ylmd", { step = 0.01 }))
    assert_packed(ylm.load(to "few.ylmd"))
  end)

  it("leaves no file where packing is broken off, or a brick is another bake's", function()
    local set = assert(ylm.bake(described { bricks = 1 }, lamps, { folder = to() }))
    local calls = 0
    local ok, message, code = set:save(to "all.ylm", { progress = function() calls = calls + 1 return calls < 12 end })
    assert.same({ nil, "cancelled", "ECANCELLED" }, { ok, message, code })
    assert(calls == 12)
    local other = assert(ylm.bake(described { bricks = 1, threshold = 0.2 }, lamps, { folder = to "other.ylmd" }))
    local from, brick = core.grid_set_file(other, 3), core.grid_set_file(set, 3)
    os.execute(("cp %s %s"):format(scratch.quote(from), scratch.quote(brick)))
    ok, message, code = set:save(to "all.ylm")
    assert.is_nil(ok)
    assert.equal("EFORMAT", code, message)
    assert.is_nil(io.open(to "all.ylm"))
  end)

  it("has the same files with sums_tolerance, whatever the number of threads and the bricks that were there", function()
    local r, at = random(grids.seed), {}
    for i = 1, 500 do at[i] = { 2 * r() - 1, 1.2 + r(), 2 * r() - 1 } end
    local many = ylm.sphere_lights { at = at, radius = 0.02, radiance = 5 }
    local function bake(name, threads)
      return ylm.bake(described { depth = 4, bricks = 1, threshold = 0.02 }, many,
        { folder = to(name), sums_tolerance = 0.02, threads = threads })
    end
    local grid = assert(bake("one.ylmd", 1))
    assert(bake("two.ylmd", 2))
    assert.equal(sums "one.ylmd", sums "two.ylmd")
    -- No jumps at faces of bricks, though their points on these differ within the tolerance.
    local eps, worst = 1e-9, 0
    for _ = 1, 200 do
      local y, z = 1.9 * r() - 0.95, 1.9 * r() - 0.95
      local c = grid:sample { { -eps, y, z }, { eps, y, z } }
      local _, d, norm = core.array_distance(c[1], c[2])
      worst = math.max(worst, d / norm)
    end
    assert.is_true(worst < 1e-6, worst)
  end)

  --- A program that bakes in a folder; its text is the sum of its files.
  local function program(threads)
    return folder:write("bake.lua", ([[
      local ylm = require "ylm"
      local lamps = ylm.sphere_lights { at = { { 0.1, 0.02, 0 }, { -0.7, 0.1, -0.5 } }, radius = { 0.2, 0.05 }, radiance = 4 }
      assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 6, threshold = 0.3,
        bricks = 2 }, lamps, { folder = arg[1], threads = %d, brick_points = 600 }))
    ]]):format(threads))
  end

  it("ends with the same files after kills at random moments, and does nothing again that was done", function()
    local run, r = program(2), random(grids.seed)
    local lua = scratch.quote(os.getenv "YLM_LUA" or "lua5.4")
    local function bake(name, before)
      return ("%s %s %s %s"):format(before or "", lua, scratch.quote(run), scratch.quote(to(name)))
    end
    local begin = core.seconds()
    local out, status = scratch.capture(bake "whole.ylmd")
    assert(status == 0, out)
    local whole, wanted = core.seconds() - begin, sums "whole.ylmd"
    local killed, most, tries = 0, long(2, 20), 0
    while killed < most do
      scratch.shell("rm -rf " .. scratch.quote(to()))
      local before, of_folder = {}, 0
      repeat -- up to four kills of a bake
        local moment, now, n = 0.02 + r() * whole
        out, status = scratch.capture(bake(nil, ("timeout -s KILL %.3f"):format(moment)))
        assert(status == 0 or status == 137, out)
        now, n = kills.committed(to())
        if status == 137 then
          killed, of_folder = killed + 1, of_folder + 1
          assert.is_nil(kills.done_again(before, now))
          kills.say("kill %d of %d: the process, %.2f s after its start (a bake takes %.2f s); %d files of bricks committed",
            killed, most, moment, whole, n)
        end
        before, tries = now, tries + 1
        assert(tries < 10 * most, "kills come too late")
      until status == 0 or of_folder == 4 or killed == most
      out, status = scratch.capture(bake())
      assert(status == 0, out)
      assert.equal(wanted, sums()) -- nothing is left over either
    end
  end)

  it("says that the disk is full, and goes on when it is not", function()
    local run = program(1)
    local lua = scratch.quote(os.getenv "YLM_LUA" or "lua5.4")
    local command = ("%s %s %s"):format(lua, scratch.quote(run), scratch.quote(to()))
    local out, status = scratch.capture("trap '' XFSZ; ulimit -f 100; " .. command)
    assert.is_true(status ~= 0)
    assert.matches("cannot be written: File too large", out)
    out, status = scratch.capture(command)
    assert(status == 0, out)
    assert(ylm.load(to()))
    assert.equal("", (scratch.capture("find " .. scratch.quote(to()) .. " -name '*unfinished*'")))
  end)

  it("keeps no more bricks in memory than the cache holds", function()
    assert(ylm.bake(described { bricks = 2 }, lamps, { folder = to() }))
    local all, few = ylm.load(to()), ylm.load(to(), { cache = "2 MB" })
    local points = places(2000, 3, grids.seed)
    local a, b = all:sample(points), few:sample(points)
    assert.equal(0, core.array_distance(a, b))
    assert.is_true(few.stats.held <= 2 * 2 ^ 20 and all.stats.held > 4 * 2 ^ 20, few.stats.held)
    assert.equal(all.stats.bricks, all.stats.reads)
    few:sample(points)
    assert.is_true(few.stats.reads > few.stats.bricks)
  end)

  it("is a light field, and a brick alone is a grid of its box", function()
    local one = ylm.bake(described(), lamps)
    local set = ylm.bake(described { bricks = 1 }, lamps, { folder = to() })
    local points = places(500, 2, grids.seed)
    for _, channels in ipairs { "rgb", "luminance" } do
      local a = ylm.light_field(2, one, points, { channels = channels, derivatives = 1 })
      local b = ylm.light_field(2, set, points, { channels = channels, derivatives = 1 })
      assert.equal(0, core.array_distance(a, b))
    end
    local tool = ("env YLM_LUA=%s %s/ylm "):format(scratch.quote(os.getenv "YLM_LUA" or "lua5.4"), os.getenv "BUILD" or "build")
    local out, status = scratch.capture(("%sinfo --json %s && %spack %s -o %s"):format(tool, to(), tool, to(), to "all.ylm"))
    assert(status == 0, out)
    assert.matches('"kind":%s*"adaptive grid in bricks"', out)
    assert.equal(one.stats.points, ylm.load(to "all.ylm").stats.points)
    local brick = assert(ylm.load(to() .. "/07/7.ylm"))
    local inside, outside = { { 0.5, 0.5, 0.5 } }, { { -0.5, 0.5, 0.5 } }
    assert.equal(0, core.array_distance(one:sample(inside), brick:sample(inside)))
    local _, _, report = brick:sample(outside)
    assert.equal(1, report.outside)
    assert.is_nil((set:sample(inside, { progress = function() return false end })))
    local asked
    local seen = set:sample(inside, { progress = function() -- may use the grid's light meanwhile
      asked = asked or ylm.light_field(2, set, inside)
      return true
    end })
    assert.equal(0, core.array_distance(seen, asked))
    set:close()
    assert.has_error(function() set:sample(inside) end, "sample: the grid has been closed")
  end)

  it("refuses a folder of another bake, and says what differs", function()
    local function bake(more, of, options)
      options = options or {}
      options.folder = to()
      local ok, message = pcall(ylm.bake, described(more), of or lamps, options)
      return ok, message
    end
    assert.is_true((bake { bricks = 1 }))
    for word, again in pairs {
      threshold = { { bricks = 1, threshold = 0.06 } }, bricks = { { bricks = 2 } }, lmax = { { bricks = 1, lmax = 1 } },
      lights = { { bricks = 1 }, lamps[1] }, occupied = { { bricks = 1 }, nil, { occupied = grids.occupied } },
      brick_points = { { bricks = 1 }, nil, { brick_points = 512 } },
    } do
      local ok, message = bake(again[1], again[2], again[3])
      assert.is_false(ok)
      assert.matches("another bake, which differs in '" .. word .. "'", message)
    end
    assert.is_true((bake({ bricks = 2 }, nil, { fresh = true })))
    scratch.shell("mkdir " .. to "other.ylmd" .. " && touch " .. to "other.ylmd/thesis.tex")
    local _, message = pcall(ylm.bake, described { bricks = 1 }, lamps, { folder = to "other.ylmd" })
    assert.matches("not a folder of a grid in bricks %(it has thesis.tex%)", message)
    assert.is_truthy(folder:read "other.ylmd/thesis.tex")
    for _, name in ipairs { "form", "index" } do folder:write("other.ylmd/" .. name, "of a thesis") end
    _, message = pcall(ylm.bake, described { bricks = 1 }, lamps, { folder = to "other.ylmd", fresh = true })
    assert.matches("not a folder of a grid in bricks %(its file form is no bake's%)", message)
    assert.equal("of a thesis", folder:read "other.ylmd/index")
  end)

  it("refuses to go on with other kernels, and a folder that may not be written, and leaves both as they were", function()
    local kernel = ylm.info().kernel
    if kernel == "reference" then return pending "there are no other kernels here" end
    local prefix = ""
    if scratch.capture "id -u" :find "^0" then
      prefix = "setpriv --bounding-set=-dac_override,-dac_read_search "
      if not scratch.shell(prefix .. "true 2>/dev/null") then return pending "root cannot be held to permissions here" end
    end
    local script = scratch.quote(folder:write("small.lua", [[
      local ylm = require "ylm"
      print(pcall(ylm.bake, ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 0, depth = 3, threshold = 0.5,
        bricks = 1 }, ylm.sphere_light { at = { 0, 3, 0 } }, { folder = arg[1] }))]]))
    local function bake(words, name)
      return (scratch.capture(("%s %s %s %s"):format(words, os.getenv "YLM_LUA" or "lua5.4", script, scratch.quote(to(name)))))
    end
    assert.matches("^true\tylm.grid_set", bake("env"))
    local before = sums()
    local says = "it was begun with the kernels K, sums by reference differ in the last bit: set YLM_ISA=K, or begin anew"
    assert.matches((says:gsub("K", kernel)), bake "env YLM_ISA=reference")
    assert.equal(before, sums())
    scratch.shell("mkdir " .. scratch.quote(to "shut") .. " && chmod 555 " .. scratch.quote(to "shut"))
    local out = bake(prefix, "shut/grid.ylmd")
    assert.matches("shut/grid.ylmd", out)
    assert.matches("Permission denied", out)
    assert.is_nil((io.open(to "shut/grid.ylmd")))
  end)

  it("refuses a second bake in a folder while one is at work", function()
    local message, code
    assert(ylm.bake(described { bricks = 1 }, lamps, { folder = to(), threads = 1, progress = function(_, _, stage)
      if not message and stage == "bricks" then
        local _
        _, message, code = ylm.bake(described { bricks = 1 }, lamps, { folder = to() })
      end
      return true
    end }))
    assert.matches("another bake is at work here, process %d+ of .- since %d", message)
    assert.equal("EBUSY", code)
  end)

  it("tells damage", function()
    assert(ylm.bake(described { bricks = 1 }, lamps, { folder = to() }))
    for name, code in pairs { ["index"] = "ECHECKSUM", ["top.ylm"] = "ECHECKSUM", ["07/7.ylm"] = "ECHECKSUM" } do
      local text = folder:read("grid.ylmd/" .. name)
      local middle = math.floor(#text / 2)
      local flipped = text:sub(1, middle) .. string.char((text:byte(middle + 1) + 1) % 256) .. text:sub(middle + 2)
      for _, bad in ipairs { flipped, text:sub(1, middle) } do
        folder:write("grid.ylmd/" .. name, bad)
        local set, message, kind = ylm.load(to())
        if set then set, message, kind = set:sample { { 0.5, 0.5, 0.5 } } end
        assert.is_nil(set)
        assert.equal(code, kind, message)
        if name == "index" then assert.matches("bake anew, with fresh = true %(ylm bake %-%-fresh%)$", message) end
      end
      folder:write("grid.ylmd/" .. name, text)
    end
    os.remove(to "grid.ylmd/07/7.ylm")
    local _, message, kind = ylm.load(to()):sample { { 0.5, 0.5, 0.5 } }
    assert.equal("EIO", kind)
    assert.matches("07/7.ylm", message)
  end)

  it("bakes a brick anew whose points for neighbours are damaged", function()
    local function bake(last)
      return ylm.bake(described { bricks = 1, lmax = 0, depth = 3 }, lamps, { folder = to(), threads = 1,
        progress = last and function(_, _, stage) return stage ~= last end })
    end
    local name = "grid.ylmd/07/7.b"
    assert.same({ nil, "cancelled", "ECANCELLED" }, { bake "joining" })
    local text = folder:read(name)
    folder:write(name, text:sub(1, 600) .. ("x"):rep(#text - 600))
    local _, message, code = bake()
    assert.equal("ECHECKSUM", code)
    assert.matches("7.b: the file is damaged.*bake again, or all anew, with fresh = true %(ylm bake %-%-fresh%)", message)
    assert(bake())
  end)

  it("refuses what is not baked in bricks", function()
    local function fails(words, ...)
      local ok, message = pcall(ylm.bake, ...)
      assert.is_false(ok)
      assert.matches(words, message)
    end
    fails("folder: a path name.ylmd expected", described { bricks = 1 }, lamps, { folder = to "grid.ylm" })
    fails("say which, folder = 'name.ylmd'", described { bricks = 1 }, lamps)
    fails("cache is of a grid in bricks", described(), lamps, { cache = "1 GB" })
    fails("'256 MB'", described { bricks = 1 }, lamps, { folder = to(), cache = "much" })
    fails("an adaptive_grid", ylm.uniform_grid { bounds = box, cells = 4 }, lamps, { folder = to() })
    fails("at least 3", described { depth = 2 }, lamps, { folder = to() })
    assert.has_error(function() described { bricks = 4 } end)
    local ok, words = pcall(described, { bricks = 1, dynamic = true })
    assert(not ok and words:find("bricks: a grid that follows lights is not baked in bricks", 1, true), words)
    fails("a grid that follows lights is not baked in bricks: leave folder out", described { dynamic = true }, lamps,
      { folder = to() })
    assert.is_nil((io.open(to())))
    local _, message, code = ylm.load(to())
    assert.equal("EIO", code)
    assert.matches("grid.ylmd", message)
  end)
end)
