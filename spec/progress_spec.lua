local progress = require "ylm.progress"

local check = require "ylm.check"
local core = require "ylm.c.core"
local ylm = require "ylm"

--- A stream that gathers what is written.
local function gathering()
  local out = {}
  return { write = function(_, ...) for _, s in ipairs { ... } do out[#out + 1] = s end end, flush = function() end },
    function() return table.concat(out) end
end

describe("progress", function()
  local lamp = ylm.sphere_light { at = { 0, 2, 0 } }

  --- An array of 20000 points, none of them zero.
  local function points(dtype)
    local a = ylm.zeros({ 20000, 3 }, dtype)
    for i = 1, 20000 do a:set(i, 1, 1) end
    return a
  end

  it("cannot close what the running call uses, whichever call it is", function()
    local a, out = points "double", ylm.zeros({ 20000, 121 }, "double")
    local cube = { { -1, -1, -1 }, { 1, 1, 1 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = cube, cells = 2, lmax = 2 }, lamp)
    local f = points "float"
    for name, call in pairs {
      points = function() return ylm.sh.eval(10, a, { progress = function() a:close() end }) end,
      out = function() return ylm.sh.eval(10, a, { out = out, progress = function() out:close() end }) end,
      light_field = function() return ylm.light_field(4, lamp, f, { progress = function() f:close() end }) end,
      sampled = function() return grid:sample(f, { progress = function() grid:close() end }) end,
      nested = function()
        return ylm.light_field(4, lamp, f, { progress = function()
          grid:sample(f, { progress = function() f:close() end })
        end })
      end,
      after_nested = function()
        return ylm.light_field(4, lamp, f, { progress = function()
          grid:sample(f, { progress = function() end })
          f:close()
        end })
      end,
    } do
      local good, message = pcall(call)
      assert(not good and tostring(message):find("spec.progress_spec.lua:%d+: close: the object is in use by a call"),
        name .. ": " .. tostring(message))
    end
    for _, x in ipairs { a, out, grid, f } do x:close() end -- allowed again
    assert.is_false(pcall(a.get, a, 1, 1))
  end)

  it("cannot change what the running call uses, whichever call it is", function()
    local cube = { { -1, -1, -1 }, { 1, 1, 1 } }
    local function description(dynamic) return ylm.uniform_grid { bounds = cube, cells = 2, lmax = 2, dynamic = dynamic } end
    local grid, twin = ylm.bake(description(true), lamp), ylm.bake(description(true), lamp)
    local moved, axes = { ylm.sphere_light { at = { 0.4, 2, 0 } } }, ylm.array({ { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, "float")
    local f, a, y = points "float", points "double", ylm.zeros({ 20000, 9 }, "double")
    local view = assert((ylm.scene "one" { camera = ylm.camera { from = { 0, 1, 3 }, at = { 0, 0, 0 }, fov = 40 },
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 2 } }, lights = {} })
      :prepare { size = { 64, 48 }, samples = 4, transfer_samples = 4, visibility = "transfer", lmax = 2 })
    local function update() return grid:update(moved) end
    local function render(on) return view:render { grid = grid, layers = false, progress = on } end
    for name, call in pairs {
      sampled = function() return grid:sample(f, { progress = update }) end,
      baked = function() return ylm.bake(description(), grid, { progress = update }) end,
      evaluated = function() return ylm.light_field(2, grid, f, { progress = update }) end,
      rendered = function() return render(update) end,
      nested = function()
        return grid:sample(f, { progress = function() ylm.light_field(2, lamp, f, { progress = update }) end })
      end,
      result = function()
        return ylm.sh.eval(2, a, { out = y, progress = function() ylm.sh.eval(2, a, { out = y }) end })
      end,
      row_of_points = function()
        return ylm.light_field(2, lamp, f, { progress = function()
          ylm.sh.reconstruct(ylm.array({ 1 }, "float"), axes, { out = f[1] })
        end })
      end,
      memory_of_view = function() return render(function() render() end) end,
    } do
      local good, message = pcall(call)
      assert(not good and tostring(message):find("spec.progress_spec.lua:%d+: %a+: the object is in use by a call"),
        name .. ": " .. tostring(message))
    end
    assert.is_nil(grid.stats.update)
    update() -- allowed again
    twin:update(moved)
    assert.equal(0, (core.array_distance(grid:sample(f), twin:sample(f))))
  end)

  it("passes on whatever its function raises", function()
    local a, thing = points "double", {}
    for name, call in pairs {
      eval = function(f) return ylm.sh.eval(4, a, { progress = f }) end,
      light_field = function(f) return ylm.light_field(2, lamp, a, { derivatives = 2, progress = f }) end,
      bake = function(f)
        return ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 2,
          threshold = 1e-3 }, lamp, { occupied = { { 0, 0, 0 } }, progress = f })
      end,
    } do
      local good, raised = pcall(call, function() error(thing) end)
      assert(not good and rawequal(raised, thing), name .. ": " .. check.describe(raised))
    end
  end)
end)

describe("progress bars", function()
  it("are made of true only; functions stay what they are", function()
    local f = function() end
    assert.equal(f, progress.resolve(f))
    assert.is_nil(progress.resolve(nil))
    assert.is_nil(progress.resolve(false))
    assert.equal("function", type(progress.resolve(true)))
  end)

  it("write a line per stage and tenths into a log", function()
    local stream, text = gathering()
    local log, seconds, now = progress.log(stream), core.seconds, 0
    core.seconds = function() return now end
    finally(function() core.seconds = seconds end)
    for i = 0, 1000 do
      now = 0.007 * i
      assert.is_true(log(i, 1000, "level 1"))
    end
    log(1000, 1000, "level 1")
    log(3, 10, "level 2")
    log(1, 2, "verifying")
    log(2, 2, "verifying")
    log(1, 2, "verifying")
    assert.equal("level 1      10 20 30 40 50 60 70 80 90 100 %  0:07\nlevel 2      10 20 30\n"
      .. "verifying    10 20 30 40 50 60 70 80 90 100 %  0:00\n", text())
    assert.is_false(text():find "\r" ~= nil)
  end)

  it("are silent in a log on stages that come again, unless they last", function()
    local stream, text = gathering()
    local log, seconds, now = progress.log(stream), core.seconds, 0
    core.seconds = function() return now end
    for _ = 1, 3 do
      for _, stage in ipairs { "level 1", "level 2", "verifying" } do
        log(1, 2, stage)
        log(2, 2, stage)
      end
    end
    log(1, 4, "level 2")
    now = 15
    log(1, 2, "level 2")
    log(2, 2, "level 2")
    core.seconds = seconds
    local line = "%-12s 10 20 30 40 50 60 70 80 90 100 %%  0:%02d\n"
    assert.equal(line:format("level 1", 0) .. line:format("level 2", 0) .. line:format("verifying", 0)
      .. line:format("level 2", 15), text())
  end)

  --- A bar, its text, and a function that sets the clock which it reads.
  local function timed(patience)
    local stream, written = gathering()
    local seconds, now = core.seconds, 100
    core.seconds = function() return now end
    finally(function() core.seconds = seconds end)
    return progress.bar(stream, patience), written, function(t) now = 100 + t end
  end

  it("show how much is done, and keep one line per stage that lasts", function()
    local bar, written, at = timed()
    for i = 0, 10 do
      at(i)
      assert.is_true(bar(i, 10, "bake"))
    end
    bar(10, 10, "bake")
    local text = written()
    assert.truthy(text:find("bake         %[" .. ("="):rep(30) .. "%] 100 %%  0:10\n"), text)
    assert.truthy(text:find("\rbake         [===============>              ]  50 %  0:05", 1, true), text)
    assert.equal(1, select(2, text:gsub("\n", "")))
    assert.equal("x            [===============>              ]  50 %  1:01:01", progress.line(5, 10, "x", 3661))
  end)

  it("share a line among stages that are short, before the next that lasts, or at the end", function()
    local bar, written, at = timed()
    for k = 0, 2 do
      at(k / 10)
      bar(1, 2, "links")
      bar(2, 2, "links")
      bar(3, 3, "direct")
    end
    assert.equal("", written())
    for k = 1, 3 do
      at(k)
      bar(k, 3, "paths")
    end
    local first, second = written():match "^([^\r]*)\n\r(.*)$"
    assert.equal("links (3 times), direct (3 times)  0:00", first)
    assert.truthy(second:find "%] 100 %%  0:02\n$", second)
    bar(1, 1, "image")
    progress.leave()
    assert.truthy(written():find "\nimage  0:00\n$", written())
  end)

  it("begin anew where a stage comes again, and end the line of one that did not reach its end", function()
    local bar, written, at = timed()
    for k = 0, 1 do
      at(10 * k)
      bar(0, 2, "paths")
      at(10 * k + 4)
      bar(1, 2, "paths")
      at(10 * k + 8)
      bar(2, 2, "paths")
    end
    assert.equal(2, select(2, written():gsub("100 %%  0:08\n", "")))
    at(20)
    bar(0, 2, "bounces")
    at(22)
    bar(1, 2, "bounces")
    bar(1, 2, "next")
    assert.truthy(written():find "bounces.*100 %%  0:02\n", written())
  end)

  it("are drawn from two seconds on where nobody asks, on a terminal, and are left out by false", function()
    local is_terminal, getenv = core.is_terminal, os.getenv
    finally(function()
      core.is_terminal = is_terminal
      rawset(os, "getenv", getenv)
    end)
    core.is_terminal = function() return false end
    assert.is_nil(progress.long(nil))
    core.is_terminal = function() return true end
    rawset(os, "getenv", function(name) return name ~= "YLM_PROGRESS" and getenv(name) or nil end)
    assert.equal("function", type(progress.long(nil)))
    assert.is_false(progress.long(false))
    assert.is_nil(progress.resolve(false))
    rawset(os, "getenv", function(name) return name == "YLM_PROGRESS" and "no" or getenv(name) end)
    assert.is_nil(progress.long(nil))
    local bar, written, at = timed(2)
    bar(0, 4, "baking")
    at(1.9)
    bar(1, 4, "baking")
    assert.equal("", written())
    at(2.1)
    bar(2, 4, "baking")
    assert.truthy(written():find "50 %%  0:02$", written())
  end)

  it("say a line of their own where the work is long enough, and functions of others do not", function()
    local bar, written = timed(2)
    progress.say(bar, 1, "short")
    progress.say(function() end, 10, "theirs")
    assert.equal("", written())
    progress.say(bar, 10, "%d rays", 7)
    assert.equal("ylm: 7 rays\n", written())
    assert.is_true(progress.speaks(bar) and not progress.speaks(print) and not progress.speaks(nil))
  end)

  it("go to the end where bounces are fewer than could be known", function()
    local scene = ylm.scene "a box" { geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 } }
    local t, done, total = scene:links { spacing = 1, rays = 16 }, nil, nil
    t:radiosity(nil, { progress = function(a, b, stage) if stage == "bounces" then done, total = a, b end end })
    assert.is_true(done == total)
    t:vectors { progress = function(a, b, stage) if stage == "bounces" then done, total = a, b end end }
    assert.is_true(done == total)
  end)
end)

describe("names of stages", function()
  --- The names in the sources, with the file of each.
  local function in_sources()
    local found = {}
    local function note(name, file) if #name > 0 and not name:find "[%%]" then found[name] = file end end
    local pipe = assert(io.popen "find csrc -name '*.c'")
    for file in pipe:lines() do
      if not file:find "csrc/vulkan/" and not file:find "csrc/lua/" then
        local handle = assert(io.open(file))
        local text = handle:read("*a"):gsub("%s+", " ")
        handle:close()
        for call in text:gmatch "ylm_parallel(%b())" do note(call:match '"([^"]*)" ?%)$' or "", file) end
        for call in text:gmatch "ylm_report(%b())" do note(call:match '"([^"]*)" ?%)$' or "", file) end
        for name in text:gmatch 'stage = "([^"]*)"' do note(name, file) end
        for name in text:gmatch 'path_kind kind = {"([^"]*)"' do note(name, file) end
      end
    end
    pipe:close()
    return found
  end

  it("are never empty, in bakes of light that takes long either", function()
    local scene = ylm.scene "a box" { geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
      links = ylm.links { spacing = 0.4, rays = 32 }, probes = ylm.adaptive_grid { lmax = 1, depth = 1, tolerance = 0.5 } }
    local count, nameless = 0, 0
    assert(scene:bake { quantity = "all", bounces = 1, progress = function(_, _, stage)
      count, nameless = count + 1, nameless + ((stage or "") == "" and 1 or 0)
    end })
    assert.is_true(count > 3)
    assert.equal(0, nameless)
  end)

  it("are explained in ylm help progress, all of them", function()
    local text = require("ylm.help").text "progress"
    local known, count = {}, 0
    for _, row in ipairs(progress.stages) do known[row[1]] = row[2] end
    for name, file in pairs(in_sources()) do
      count = count + 1
      assert(known[name], ("stage %q of %s is not explained"):format(name, file))
      assert.truthy(text:find(name, 1, true))
    end
    assert.is_true(count > 30, count)
  end)
end)
