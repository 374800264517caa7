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
    local log = progress.log(stream)
    for i = 0, 1000 do assert.is_true(log(i, 1000, "level 1")) end
    log(1000, 1000, "level 1")
    log(3, 10, "level 2")
    log(1, 2, "verifying")
    log(2, 2, "verifying")
    log(1, 2, "verifying")
    assert.equal("level 1      10 20 30 40 50 60 70 80 90 100 %  0:00\nlevel 2      10 20 30\n"
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

  it("show how much is done, and keep one line per stage", function()
    local stream, written = gathering()
    local bar = progress.bar(stream)
    for i = 0, 10 do assert.is_true(bar(i, 10, "bake")) end
    bar(10, 10, "bake")
    bar(0, 0, "empty")
    local text = written()
    assert.truthy(text:find("bake         %[" .. ("="):rep(30) .. "%] 100 %%  0:00\n"), text)
    assert.equal(2, select(2, text:gsub("\n", "")))
    assert.equal("x            [===============>              ]  50 %  1:01:01", progress.line(5, 10, "x", 3661))
  end)
end)
