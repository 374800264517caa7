--- grid:update of grids that are not dynamic: a grid's points in another light.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local walls = require "spec.support.walls"

local box, lamps, occupied = grids.box, grids.lamps, grids.occupied

--- Each kind of grid, of the lamps.
local kinds = {
  adaptive = function(lights)
    return ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.02 }, lights, { occupied = occupied })
  end,
  threshold = function(lights)
    return ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, threshold = 0.3 }, lights, { occupied = occupied })
  end,
  uniform = function(lights)
    return ylm.bake(ylm.uniform_grid { bounds = box, lmax = 2, cells = { 3, 4, 5 }, channels = "luminance" }, lights)
  end,
  ["uniform, without metric"] = function(lights)
    return ylm.bake(ylm.uniform_grid { bounds = box, lmax = 1, cells = 4, metric_channels = "none" }, lights,
      { occupied = occupied })
  end,
}

local moved = { lamps[1], ylm.sphere_light { at = { -0.3, 0.4, 0.1 }, radius = 0.05, radiance = { 3, 9, 4 } } }

describe("grid:update { octree = 'keep' }", function()
  for name, make in pairs(kinds) do
    it("gives the same bytes with the lights of the bake: " .. name, function()
      local grid = make(lamps)
      local before = core.grid_encode(grid)
      local report = grid:update(lamps)
      assert.equal(grid.stats.points, report.points)
      assert.equal(before, core.grid_encode(grid))
    end)
  end

  it("gives the same bytes whatever the number of threads, and back again", function()
    local grid, other = kinds.adaptive(lamps), kinds.adaptive(lamps)
    local before = core.grid_encode(grid)
    local points = grid:points()
    grid:update(moved, { threads = 1 })
    other:update(moved, { threads = 3 })
    assert.equal(core.grid_encode(grid), core.grid_encode(other))
    assert.is_true(core.array_distance(points.value, grid:points().value) > 0.01)
    assert.equal(0, (core.array_distance(points.position, grid:points().position)))
    grid:update(lamps)
    assert.equal(0, (core.array_distance(points.value, grid:points().value)))
    assert.equal(#before, #core.grid_encode(grid))
  end)

  it("is the bake of the other lights where the octree is the same", function()
    local grid, wanted = kinds.uniform(lamps), kinds.uniform(moved)
    grid:update(moved)
    assert.equal(0, (core.array_distance(wanted:points().value, grid:points().value)))
    assert.equal(0, (core.array_distance(wanted:points().invalid, grid:points().invalid)))
    assert.equal(0, (core.array_distance(wanted:sample(occupied), grid:sample(occupied))))
    assert.equal(wanted.stats.invalid, grid.stats.invalid)
  end)

  it("keeps no promise that nobody looked at", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = walls.box, lmax = 1, depth = 4, tolerance = 0.1 }, walls.lamp,
      { occupied = walls.points(8) })
    assert.is_true(grid.stats.met)
    grid:update(moved)
    assert.is_false(grid.stats.met)
    assert.is_true(grid.stats.error ~= grid.stats.error)
    assert.truthy(grid.stats.warning:find("octree = 'keep'", 1, true), grid.stats.warning)
  end)

  it("takes what the other field holds, as files do", function()
    local grid = kinds.uniform(lamps)
    assert.equal("lights", grid.quantity)
    grid:update(walls.field, { quantity = "all" })
    assert.equal("all", grid.quantity)
    assert.equal("all", core.grid_decode(core.grid_encode(grid)).quantity)
    local copy = ylm.bake(ylm.uniform_grid { bounds = box, lmax = 1, cells = 2 }, grid)
    assert.equal("all", copy.quantity)
    grid:update(lamps)
    assert.equal("lights", grid.quantity)
  end)

  it("leaves the grid as it was where it is cancelled, or where the field fails", function()
    local grid = kinds.adaptive(lamps)
    local before, steps = core.grid_encode(grid), 0
    local report, message, code = grid:update(moved, { progress = function(done, total, stage)
      steps = steps + 1
      assert.is_true(done <= total)
      assert.equal("evaluating", stage)
      return steps < 2
    end })
    assert.is_nil(report)
    assert.equal("cancelled", message)
    assert.equal("ECANCELLED", code)
    assert.equal(before, core.grid_encode(grid))
    local ok, raised = pcall(grid.update, grid, function() error "no light today" end)
    assert.is_false(ok)
    assert.truthy(tostring(raised):find("no light today", 1, true))
    assert.equal(before, core.grid_encode(grid))
    assert.equal("lights", grid.quantity)
  end)

  it("works on a grid that was loaded", function()
    local grid = kinds.adaptive(lamps)
    local loaded = core.grid_decode(core.grid_encode(grid))
    loaded:update(lamps)
    assert.equal(core.grid_encode(grid), core.grid_encode(loaded))
  end)
end)

describe("points().validity", function()
  it("is 0 in lights, 1 elsewhere, and between for points that are interpolated", function()
    local grid = kinds.adaptive(lamps)
    local points, invalid = grid:points(), 0
    for i = 1, #points.validity do
      local v = points.validity[i]
      if points.interpolated[i] == 0 then assert.equal(1 - points.invalid[i], v)
      else assert.is_true(v >= 0 and v <= 1) end
      invalid = invalid + points.invalid[i]
    end
    assert.is_true(invalid > 0)
  end)
end)
