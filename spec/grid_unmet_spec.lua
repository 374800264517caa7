-- Tolerances that are not met: one line says so, with the cause and what to change.
local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local ylm = require "ylm"

local box = { { -1, -1, -1 }, { 1, 1, 1 } }
local occupied = {}
for i = 1, 600 do occupied[i] = { math.sin(12.9 * i), 0.6 * math.sin(7.1 * i), math.cos(3.3 * i) } end

local function lamp(x, y) return ylm.sphere_light { at = { x or 0.3, y or 1.4, 0.2 }, radius = 0.1, radiance = 10 } end

local function probes(depth, tolerance, dynamic)
  return ylm.adaptive_grid { bounds = box, lmax = 3, depth = depth, tolerance = tolerance, dynamic = dynamic }
end

--- A scene with these probes, and a view of it where nothing is in shadow.
local function scene(description)
  return ylm.scene "floor" {
    camera = ylm.camera { from = { 0, 2, 3 } }, lights = { lamp() }, probes = description,
    geometry = { ylm.quad { corner = { -1, -0.9, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
  }
end
local small = { size = { 32, 18 }, samples = 2 }

describe("a tolerance that is not met", function()
  local said, before
  before_each(function()
    said = {}
    before = ylm.on_warning(function(line) said[#said + 1] = line end)
  end)
  after_each(function() ylm.on_warning(before) end)

  it("is said in one line that names a depth and a tolerance that are met", function()
    local grid = ylm.bake(probes(2, 1e-3), lamp(), { occupied = occupied })
    assert.is_false(grid.stats.met)
    assert.same({ grid.stats.warning }, said)
    local depth, tolerance = said[1]:match("^bake: tolerance 0.001 is not met, 99 %% of the points keep 0%.%d+: voxels end at "
      .. "depth 2; set depth = (%d+) %(errors fall about 16 times a level%) or tolerance = (0%.%d+)$")
    assert(depth, said[1])
    for _, better in ipairs { probes(tonumber(depth), 1e-3), probes(2, tonumber(tolerance)) } do
      local stats = ylm.bake(better, lamp(), { occupied = occupied }).stats
      assert.is_true(stats.met)
      assert.is_nil(stats.warning)
    end
    assert.equal(1, #said)
  end)

  it("names no depth that no grid has", function()
    local grid = ylm.bake(probes(1, 1e-25), lamp(), { occupied = occupied })
    assert.truthy(grid.stats.warning:find(": voxels end at depth 1; set tolerance = [%d.]+$"), grid.stats.warning)
  end)

  it("has no tolerance to name where the grid has light in the dark", function()
    local half = ylm.disk_light { at = { 0, 0.5, 0 }, normal = { 1, 0, 0 }, radius = 0.3, radiance = 10, horizon = { 0, -1, 0 } }
    local grid = ylm.bake(probes(2, 0.01), half, { occupied = occupied })
    assert.equal(math.huge, grid.stats.error)
    assert.equal("bake: tolerance 0.01 is not met, 99 % of the points keep no bound: voxels end at depth 2; set depth = 3 "
      .. "(errors fall about 16 times a level)", grid.stats.warning)
  end)

  it("says that light bends beside walls, and names no depth far below", function()
    local s = ylm.scene "a body on a floor" { lights = lamp(0.3, 0.4),
      geometry = { ylm.quad { corner = { -1, -0.9, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
        ylm.box { bounds = { { -0.2, -0.9, -0.2 }, { 0.1, -0.3, 0.3 } } } } }
    local function warning(tolerance)
      s.probes = ylm.adaptive_grid { bounds = box, lmax = 1, depth = 2, tolerance = tolerance }
      return assert(s:bake { quantity = "direct", judge = "field", progress = false }).stats.warning
    end
    local begin = ": voxels end at depth 2, and beside walls light bends within voxels; set "
    local ends = "tolerance = [%d.]+; light on surfaces %(scene:surface_grid%) takes fewer numbers$"
    local near, far = warning(0.7), warning(0.01)
    assert.truthy(near:find(begin .. "depth = [34] %(errors fall about by half a level%) or " .. ends), near)
    assert.truthy(far:find(begin .. ends), far)
  end)

  it("names the tolerance of the lights where that is the larger one", function()
    local at = {}
    for i = 1, 4000 do at[i] = { 2 * math.sin(1.7 * i) * (i % 97) / 97, 1.5 + i % 13 / 13, 2 * math.cos(1.3 * i) } end
    local grid = ylm.bake(probes(3, 1e-3), ylm.sphere_lights { at = at, radius = 0.02 },
      { occupied = occupied, sums_tolerance = 0.05 })
    assert.is_false(grid.stats.met)
    assert.truthy(grid.stats.warning:find(": lights are summed to sums_tolerance = 0.05, voxels end at depth 3; set "
      .. "sums_tolerance = 0.001, then depth, or tolerance = ", 1, true), grid.stats.warning)
  end)

  it("is said once of a grid, and stands in the report of each picture by it, also when it was loaded", function()
    local s = scene(probes(1, 1e-4))
    local grid = s:bake { occupied = "camera", size = small.size, samples = small.samples }
    assert.same({ grid.stats.warning }, said)
    local view = s:prepare(with(small, { visibility = "transfer" }))
    for _ = 1, 2 do assert.same(said, select(2, view:render { grid = grid }).warnings) end
    assert.equal(1, #said)
    assert.same({ grid.stats.warning }, select(2, s:render(with(small, { visibility = "transfer" }))).warnings) -- of its own bake
    assert.equal(2, #said)
    local folder = scratch.new()
    assert(grid:save(folder.path .. "/grid.ylm"))
    local loaded = ylm.load(folder.path .. "/grid.ylm")
    folder:remove()
    assert.equal(2, #said)
    assert.same({ grid.stats.warning }, select(2, view:render { grid = loaded }).warnings)
    assert.equal(3, #said)
  end)

  it("is said of an update", function()
    local grid = ylm.bake(probes(3, 0.02, true), lamp(0.3, 4), { occupied = occupied })
    assert.same({}, said)
    local report = grid:update(lamp(0.3, 0.7))
    assert.is_false(report.met)
    assert.same({ report.warning }, said)
    assert.equal(report.warning, grid.stats.update.warning)
    assert.truthy(report.warning:find("^update: tolerance 0.02 is not met, 99 %% of the points keep "
      .. "0%.%d+: voxels end at depth 3; set depth = [4-9] "), report.warning)
    grid:update(lamp(0.3, 4))
    assert.is_nil(grid.stats.update.warning)
  end)

  it("is no matter of grids without one, nor of those that meet it", function()
    for _, description in ipairs { probes(6, 0.05), ylm.uniform_grid { bounds = box, cells = 2, lmax = 3 },
      ylm.adaptive_grid { bounds = box, lmax = 3, depth = 1, threshold = 1e-9 } } do
      assert.is_nil(ylm.bake(description, lamp(), { occupied = occupied }).stats.warning)
    end
    assert.same({}, said)
  end)
end)
