--- grid:save and ylm.load of grids.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bytes = require "spec.support.grid_bytes"
local grids = require "spec.support.grids"
local random = require "spec.support.random"
local shell = require "spec.support.scratch"

local box, lamp, lamps, occupied = grids.box, grids.lamp, grids.lamps, grids.occupied

local everywhere = random.points_in(3000, { -1.05, -1.05, -1.05 }, { 1.05, 1.05, 1.05 }, 3)

--- The lamps, the first of which has moved.
local function lamps_at(step)
  local moved = { lamps[1], lamps[2], lamps[3] }
  moved[1] = ylm.sphere_light { at = { 0.1 + 0.05 * step, 0.2, 0.2 }, radius = 0.05, radiance = { 10, 8, 6 } }
  return moved
end

describe("grid files", function()
  local function scratch(name) return os.tmpname() .. name end
  local grid_file = require "ylm.grid"

  -- stats of a bake, or of memory, which files lack
  local of_the_bake = { bytes = true, update = true, confidence = true, failed = true, crossed = true }

  local function same(a, b)
    for _, pair in ipairs { { a:points(), b:points() }, { a:cells(), b:cells() } } do
      for name, array in pairs(pair[1]) do
        if name ~= "error" and name ~= "residual" then assert.equal(0, (core.array_distance(array, pair[2][name])),
          name) end
      end
    end
    assert.equal(0, core.array_distance(a:sample(occupied), b:sample(occupied)))
    -- the time of a bake is known to the grid that was baked only
    for key, value in pairs(a.stats) do
      if key:find "seconds" then assert.is_nil(b.stats[key], key)
      elseif key == "warning" then assert.equal(value:match ":.*", b.stats[key]:match ":.*") -- of an update, of a bake
      elseif not of_the_bake[key] and value == value then
        assert.equal(value, b.stats[key], key)
      end
    end
  end

  local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.02 }, lamps,
    { occupied = occupied })

  --- Asserts that two grids hold the same points and voxels and give the same samples, to the bit, however they are sampled.
  local function identical(a, b)
    same(a, b)
    for _, how in ipairs { "hermite", "taylor", "linear" } do
      local x, dx = a:sample(everywhere, { interpolation = how, derivatives = 1 })
      local y, dy = b:sample(everywhere, { interpolation = how, derivatives = 1 })
      assert.equal(0, core.array_distance(x, y), how)
      assert.equal(0, core.array_distance(dx, dy), how)
    end
  end

  it("keep everything to the bit, interpolated points included", function()
    local path = scratch ".ylm"
    assert(grid.stats.interpolated > 100 and grid.stats.invalid > 0)
    assert.is_true(grid:save(path))
    identical(grid, assert(grid_file.load(path)))
    local file = assert(io.open(path, "rb"))
    assert.equal(grid_file.magic, file:read(8))
    file:close()
    local uniform = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 3, 2, 5 }, lmax = 1 }, lamp,
      { occupied = occupied })
    assert.is_true(uniform:save(path))
    identical(uniform, assert(grid_file.load(path)))
    os.remove(path)
  end)

  it("keep what a dynamic grid is after updates", function()
    local moved = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 4, tolerance = 0.05, dynamic = true }, lamps,
      { occupied = occupied })
    for step = 1, 3 do assert(moved:update(lamps_at(step))) end
    local loaded = core.grid_decode(core.grid_encode(moved))
    identical(moved, loaded)
    assert.is_false(loaded.dynamic)
  end)

  it("hold evaluated points to the bit under another kernel set, interpolated ones up to rounding", function()
    local folder = shell.new()
    finally(function() folder:remove() end)
    local program = folder:write("load.lua", [[
local folder = ...
local grid = assert(require "ylm".load(folder .. "/grid.ylm"))
assert(require "ylm".info().kernel == "reference")
assert(grid:points().value:save(folder .. "/value.npy"))]])
    assert(grid:save(folder.path .. "/grid.ylm"))
    local out, code = shell.capture(("YLM_ISA=reference YLM_LUA=%s LUA_PATH= LUA_CPATH= %s run %s %s"):format(
      os.getenv "YLM_LUA" or "lua5.4", shell.quote((os.getenv "YLM_BUILD" or "build") .. "/ylm"), shell.quote(program),
      shell.quote(folder.path)))
    assert.equal(0, code, out)
    local here, there, n = grid:points().value, assert(ylm.load(folder.path .. "/value.npy")), grid.stats.points
    for i = 1, n, 17 do assert.equal(0, core.array_distance(here[i], there[i])) end
    local _, distance, norm = core.array_distance(there, here)
    assert(distance <= 1e-6 * norm, distance / norm)
  end)

  it("are equal bytes where grids are equal, whatever the number of threads", function()
    local first
    for threads = 1, 3 do
      local again = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 4, tolerance = 0.05 }, lamps,
        { occupied = occupied, threads = threads })
      first = first or core.grid_encode(again)
      assert(first == core.grid_encode(again), threads .. " threads")
      assert(first == core.grid_encode(core.grid_decode(first)))
    end
  end)

  it("hold evaluated points' rows once, and of an interpolated point 8 bytes", function()
    local file = bytes.open(core.grid_encode(grid))
    local stats = grid.stats
    assert.equal(8 * stats.interpolated, file.section.births.size)
    assert.equal(4 * 4 * 32 * stats.points + 64, file.section.rows.size) -- lmax 2, rgb: 27 floats, padded to 32
    for i, s in ipairs(file) do
      assert.equal(0, s.offset % 64)
      assert(#s.data > 1e4 or s.crc == bytes.crc(s.data), s.name)
      assert(i == #file or s.offset + s.size <= file[i + 1].offset)
    end
    assert.equal("995dc9bbdf1939fa", (bytes.crc "123456789":reverse():gsub(".", function(c)
      return ("%02x"):format(c:byte()) end)))
  end)

  it("have the same checksum by tables and by products of the processor", function()
    local text = ("spherical harmonics, "):rep(40)
    for _, n in ipairs { 0, 1, 15, 16, 127, 128, 129, 143, 144, 255, 256, 257, 383, 384, 400, 511, 512, 777 } do
      local sum = bytes.crc(text:sub(1, n)):reverse():gsub(".", function(c) return ("%02x"):format(c:byte()) end)
      assert.equal(sum, core.team_crc(text:sub(1, n)), n .. " bytes")
    end
  end)

  it("of another version or byte order are refused", function()
    local u32 = bytes.u32
    local text = core.grid_encode(ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 0 }, lamp))
    for code, head in pairs { EVERSION = text:sub(1, 12) .. u32(1), EFORMAT = text:sub(1, 8) .. u32(0x04030201) .. u32(2) } do
      assert.equal(code, select(3, core.grid_decode(head .. text:sub(#head + 1))))
    end
  end)

  it("are written for ParaView too", function()
    local path = scratch ".vtu"
    assert.is_true(grid:save(path))
    local file = assert(io.open(path, "rb"))
    assert.is_truthy(file:read(200):find("UnstructuredGrid", 1, true))
    file:close()
    os.remove(path)
    assert.is_nil((grid:save "/no/such/folder/grid.vtu"))
  end)

  it("are what ylm.load knows by content", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    same(grid, assert(ylm.load(path)))
    os.remove(path)
  end)

  it("refuse every truncation and every flipped bit", function()
    local small = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 0, channels = "luminance" }, lamp)
    assert.equal(0, core.grid_accepted_damage(core.grid_encode(small)))
    local octree = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 1, threshold = 0,
      channels = "luminance" }, lamp)
    assert.equal(0, core.grid_accepted_damage(core.grid_encode(octree)))
  end)

  --- A field whose values and gradients are exact in float, with a metric that refines half of the box.
  local halves = grids.analytic(function(x, y, z)
    return x * x + y - 0.5 * z, 2 * x, 1, -0.5
  end, function(x) return x < 0 and 8 or 0.25 end)

  --- The bytes of a continuous octree, to be forged. Some of its voxels hold no shading points.
  local whole = core.grid_encode(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 3, threshold = 1,
    metric = "absolute", channels = "luminance" },
    halves, { occupied = ylm.array { { -0.1, -0.6, -0.9 }, { 0.3, -0.5, -0.4 } } }))
  local function forge() return bytes.open(whole) end

  it("skip sections that they do not know, and refuse those they would have to", function()
    local plain = core.grid_decode(forge():seal())
    local more = core.grid_decode(forge():add("bodies", "lights", false, 3):add("later.than-this_1", "", false):seal())
    identical(plain, more)
    local g, message, code = core.grid_decode(forge():add("mortar", bytes.u64(7), true):seal())
    assert.is_nil(g)
    assert.equal("EVERSION", code)
    assert.truthy(message:find("needs its section 'mortar'", 1, true), message)
    local newer = forge()
    newer.version = 3
    g, message, code = core.grid_decode(newer:seal())
    assert.is_nil(g)
    assert.equal("EVERSION", code)
    assert.truthy(message:find("version 3", 1, true), message)
    -- stats may be missing
    local bare = forge()
    table.remove(bare, 2)
    assert.equal(0, core.grid_decode(bare:seal()).stats.pairs)
  end)

  describe("that were forged", function()
    local u32, u64, nan, infinity = bytes.u32, bytes.u64, "\0\0\192\127", "\0\0\128\127"
    local NONE = 2 ^ 32 - 1
    local origin, child, corner, level, flags, detail = 0, 12, 20, 60, 61, 62 -- of a cell
    local function cell(i, field) return 64 * i + field end

    --- Asserts that the file is refused, for a reason that says `why`.
    local function refused(file, why)
      local g, message, code = core.grid_decode(type(file) == "string" and file or file:seal())
      assert.is_nil(g, why)
      assert(code == "EFORMAT" or code == "ECHECKSUM", tostring(code))
      assert(message:find(why, 1, true), message .. ", not " .. why)
    end

    it("are refused where the body or the floor is no number", function()
      for name, case in pairs { body = { 40, "body: a finite place" }, floor = { 8, "floor: a number of at least 0" } } do
        local f = forge():add(name, ("\255"):rep(case[1]), false)
        f.section[name].record = case[1]
        refused(f, case[2])
      end
    end)

    it("are refused where sections are out of order, of odd names or missing", function()
      local f = forge()
      f[3].offset_ = 576
      refused(f, "place of a section")
      f = forge()
      f[4].offset_ = f[4].offset + 1
      refused(f, "place of a section")
      for _, size in ipairs { 2 ^ 53, 1e9 } do
        f = forge()
        f[9].size_ = size
        refused(f, "place of a section")
        f[9].size_, f[9].offset_ = nil, size * 64
        refused(f, "place of a section")
      end
      refused(forge():add("lambda", "", false), "two sections of one name")
      refused(forge():add("Rows", "", false), "name of a section")
      refused(forge():add("", "", false), "name of a section")
      refused(forge():add("a\0b", "", false), "name of a section")
      refused(forge():add(("a"):rep(24), "", false), "name of a section")
      for i = 1, 9 do
        local g = forge()
        if i ~= 2 then
          table.remove(g, i)
          refused(g, i == 9 and "size of a section" or "section")
        end
        g = forge()
        g[i].data = g[i].data .. ("\0"):rep(8)
        refused(g, "section")
        g = forge()
        g[i].record = g[i].record + 1
        refused(g, "section")
      end
      local text = forge():seal()
      refused(text:sub(1, 777) .. "x" .. text:sub(779), "between sections")
      local many = forge()
      for i = 1, 300 do many:add("s" .. i, "", false) end
      refused(many, "number of sections")
    end)

    it("are refused where counts do not fit together", function()
      local counts = 104 -- in form: cells, octree's, points, evaluated
      for i, n in ipairs { 48, 50, 81, 31 } do refused(forge():put("form", counts + 8 * (i - 1), u64(n)), "") end
      for i = 0, 3 do
        for _, n in ipairs { 0, 2 ^ 32 - 1, 2 ^ 32, 2 ^ 53 } do
          refused(forge():put("form", counts + 8 * i, u64(n)), "not a valid grid")
        end
      end
      local f = forge():put("form", counts + 16, u64(32 + 32 * 104 + 1)) -- more than continuity makes
      f.section.births.data = ("\1\0\0\0\1\0\0\0"):rep(32 * 104 + 1)
      refused(f, "its counts")
      refused(forge():put("form", 24, u32(0)), "its counts") -- interpolated points without continuity
      refused(forge():put("form", 0, u32(2)), "kind")
      refused(forge():put("form", 4, u32(256)), "lmax")
      refused(forge():put("form", 16, u32(17)), "depth")
      refused(forge():put("form", 40, ("\0"):rep(6) .. "\248\127"), "bounds")
      refused(forge():put("form", 88, ("\0"):rep(6) .. "\248\127"), "threshold")
    end)

    it("are refused where cells are no octree", function()
      refused(forge():put("cells", cell(0, child), u32(0)), "children")
      refused(forge():put("cells", cell(1, child), u32(1)), "children")
      refused(forge():put("cells", cell(1, child), u32(48)), "children")
      refused(forge():put("cells", cell(1, child), u32(NONE)), "children")
      refused(forge():put("cells", cell(3, child), u32(9)), "") -- two parents
      refused(forge():put("cells", cell(0, origin), u32(1)), "root")
      refused(forge():put("cells", cell(0, level), "\1"), "root")
      refused(forge():put("cells", cell(5, level), "\9"), "two parents")
      refused(forge():put("cells", cell(5, origin), u32(1)), "")
      refused(forge():put("cells", cell(0, corner), u32(NONE)), "root's corners")
      refused(forge():put("cells", cell(1, corner), u32(82)), "corners")
      refused(forge():put("cells", cell(1, corner), u32(5)), "corners")
      refused(forge():put("cells", cell(3, detail), "\9\0"), "detail")
      refused(forge():put("cells", cell(30, flags), "\1"), "children")
    end)

    it("are refused where a leaf has a side and the grid has none", function()
      local last = cell(48, flags)
      local was = forge().section.cells.data:byte(last + 1)
      refused(forge():put("cells", last, string.char(was + 64)), "the number of its sides")
    end)

    it("are refused where points are not numbers or nowhere", function()
      refused(forge():put("lattice", 0, u32(9)), "place")
      refused(forge():put("lattice", 0, u32(NONE)), "place")
      refused(forge():put("lambda", 8, nan), "metric")
      refused(forge():put("norm", 8, nan), "metric")
      refused(forge():put("flags", 3, "\2"), "flags")
      for _, x in ipairs { nan, infinity } do
        refused(forge():put("rows", 128, x), "coefficients")
        refused(forge():put("rows", 156, x), "coefficients") -- of the padding
        local size = forge().section.rows.size -- the reader looks at 256 bytes at a time, then at the rest
        for at = 256, 512, 60 do refused(forge():put("rows", at, x), "coefficients") end
        for at = size - 256, size - 4, 36 do refused(forge():put("rows", at, x), "coefficients") end
      end
      local largest = "\255\255\127\127"
      refused(forge():put("rows", 0, largest:rep(32 * 32)), "coefficients") -- interpolated ones overflow
    end)

    it("are refused where interpolated points come from themselves, from later ones or from nowhere", function()
      local f = forge()
      local births = f.section.births.data
      for _, place in ipairs { 27, NONE } do
        refused(forge():put("births", 4, u32(place)), "where a point is interpolated")
      end
      for _, c in ipairs { 49, NONE, 3 } do -- cell 3 has no data
        refused(forge():put("births", 0, u32(c)), "where a point is interpolated")
      end
      refused(forge():put("births", 0, u32(20)), "where a point is interpolated") -- of the finest level
      refused(forge():put("births", 4, u32(births:byte(5) == 1 and 3 or 1)), "corners") -- another place
      refused(forge():put("births", 4, u32(0)), "corners") -- its corner
      -- the first interpolated point comes from a cell that has it for a corner
      local last = 8 * (#births / 8 - 1)
      refused(forge():put("births", 0, births:sub(last + 1, last + 4)), "from itself")
    end)
  end)

  it("refuse what is no grid, in words", function()
    local path = scratch ".ylm"
    local file = assert(io.open(path, "wb"))
    file:write("P6 3 3 255 something else")
    file:close()
    local g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EFORMAT", code)
    assert.is_true(message:find("not a grid file", 1, true) ~= nil)
    os.remove(path)
    g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_true(message:find(path, 1, true) ~= nil)
    g, message, code = grid_file.load("/")
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_string(message)
  end)

  it("refuse a file that is cut off or longer than it should be", function()
    local path, text = scratch ".ylm", whole
    for _, length in ipairs { 8, 31, 32, 63, 64, 639, 640, 5000, #text - 1, #text + 1 } do
      local file = assert(io.open(path, "wb"))
      file:write((text .. "x"):sub(1, length))
      file:close()
      local g, message, code = ylm.load(path)
      assert.is_nil(g)
      assert.equal("ECHECKSUM", code, message)
    end
    os.remove(path)
  end)

  it("keep the old file where the new one cannot be written", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    local ok, message, code = grid:save("/proc/ylm.ylm")
    assert.is_nil(ok)
    assert.is_string(message)
    assert.equal("EIO", code)
    assert(grid_file.load(path))
    os.remove(path)
  end)
end)
