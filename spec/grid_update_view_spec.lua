--- Pictures of grids that follow moving lights.

local ylm = require "ylm"
local grids = require "spec.support.grids"
local moving = require "spec.support.moving"

local update, lamp, canopy = moving.update, moving.lamp, moving.canopy
local box = grids.box

describe("view:render of a grid that was updated", function()
  local camera = ylm.camera { from = { 0, 1.2, 2.6 }, at = { 0, 0, 0 }, fov = 45 }
  local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8 }
  local stage = ylm.scene "stage" { camera = camera, geometry = { floor }, lights = {} }
  local size = { 64, 48 }

  local function prepare(scene)
    return assert(scene:prepare { size = size, samples = 4, transfer_samples = 8, visibility = "transfer" })
  end

  it("samples only what changed, and shows what a new view shows", function()
    local view = prepare(stage)
    local points = view:points().position
    for _, make in ipairs { function()
      return ylm.adaptive_grid { bounds = box, depth = 6, tolerance = 0.02, dynamic = true }
    end, function() return ylm.uniform_grid { bounds = box, cells = 6, lmax = 4, dynamic = true } end } do
      local lights = canopy(200)
      local grid = ylm.bake(make(), lights, { occupied = points, threads = 1 })
      local partly = 0
      for k = 1, 6 do
        lights[7] = lamp(-0.6 + 0.02 * k, 0.1, 0.5, 0.02, { 3, 2, 4 })
        update(grid, lights)
        for _, how in ipairs { "hermite", "hermite", "linear" } do
          local image, report = view:render { grid = grid, interpolation = how, layers = false }
          local truth, all = prepare(stage):render { grid = grid, interpolation = how, layers = false }
          assert.equal(0, image:compare(truth).max)
          assert.equal(report.points, all.fresh)
          assert.equal(all.outside, report.outside)
          assert.equal(all.unbaked, report.unbaked)
          if report.fresh > 0 and report.fresh < report.points then partly = partly + 1 end
        end
        assert.equal(0, select(2, view:render { grid = grid, interpolation = "linear", layers = false }).fresh)
        view:render { grid = grid, layers = false } -- so that the next frame finds Hermite's
      end
      assert.is_true(partly > 0)
    end
  end)

  it("writes again the picture it is given", function()
    local view, lights = prepare(stage), canopy(50)
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, lights, { threads = 1 })
    local first = view:render { grid = grid, layers = false }
    lights[3] = lamp(0.2, 0.2, 0.3)
    update(grid, lights)
    local second = view:render { grid = grid, layers = false, lamps = lights, out = first }
    assert.equal(first, second)
    assert.equal(0, second:compare((prepare(stage):render { grid = grid, layers = false, lamps = lights })).max)
    assert.same({ "radiance" }, (second:layers()))
    local names = view:render({ grid = grid, out = second }):layers()
    assert.same((view:render { grid = grid }):layers(), names)
    for _, wrong in ipairs { ylm.image { size = { 64, 47 } }, 7, ylm.image { size = size, layers = { { "radiance", 1 } } } } do
      local ok, message = pcall(view.render, view, { grid = grid, out = wrong })
      assert.is_false(ok)
      assert.truthy(message:find "out: ", message)
    end
  end)

  it("takes another grid for another, and a closed one for none", function()
    local view = prepare(stage)
    local function bake_one(x)
      return ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, { lamp(x, 0.6, 0) },
        { threads = 1 })
    end
    local a, b = bake_one(0), bake_one(0.3)
    local first = view:render { grid = a, layers = false }
    local second = view:render { grid = b, layers = false }
    assert.equal(0, second:compare((prepare(stage):render { grid = b, layers = false })).max)
    assert.is_true(first:compare(second).max > 1e-3)
    a:close()
    assert.has_error(function() view:render { grid = a } end)
  end)

  it("draws lamps where they are now, as rays would", function()
    local lights = { lamp(0.3, 0.3, 0.2, 0.2, 2), lamp(-0.5, 0.15, -0.5, 0.15, { 3, 1, 0.5 }), lamp(0, -0.4, 0, 0.3, 9),
      lamp(-0.2, 0.5, 0.5, 0.05, 4), lamp(0, 1.2, 4, 0.1, 5) } -- one below the floor, one behind the camera
    local traced = ylm.scene "traced" { camera = camera, geometry = { floor }, lights = lights }
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, lights, { threads = 1 })
    local view = assert(stage:prepare { size = size, samples = 64, transfer_samples = 8, visibility = "transfer" })
    local drawn = view:render { grid = grid, layers = false, lamps = lights }
    local truth = assert(traced:prepare { size = size, samples = 64, transfer_samples = 8, visibility = "transfer" })
      :render { grid = grid, layers = false }
    local report = drawn:compare(truth)
    local bare = view:render { grid = grid, layers = false }:compare(truth)
    assert.is_true(report.mae < 0.02, report.mae)
    assert.is_true(bare.mae > 10 * report.mae, bare.mae)
  end)
end)
