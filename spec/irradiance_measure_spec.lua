--- adaptive_grid { measure = "irradiance" }, and the look-up beside surfaces: bias.

local core = require "ylm.c.core"
local ylm = require "ylm"
local irradiance = require "spec.support.irradiance"
local walls = require "spec.support.walls"

local box = walls.box

--- A description with what a case changes.
local function adaptive(changes)
  local form = { bounds = box, lmax = 1, depth = 4, tolerance = 0.05 }
  for name, value in pairs(changes or {}) do form[name] = value end
  return ylm.adaptive_grid(form)
end

describe("measure", function()
  it("is of coefficients by default for lights, and of irradiance where light jumps at surfaces", function()
    local lit = ylm.bake(adaptive(), walls.lamp, { occupied = walls.points(8) })
    assert.equal("coefficients", lit.measure)
    assert.equal("lights", lit.quantity)
    assert.equal(0, lit.bias)
    local shadowed = ylm.bake(adaptive(), walls.field, { occupied = walls.points(8), quantity = "direct" })
    assert.equal("irradiance", shadowed.measure)
    assert.equal("irradiance", shadowed.stats.measure)
    assert.equal("direct", shadowed.quantity)
    assert.equal(1, shadowed.bias)
  end)

  it("says the error of irradiance at every occupied point, against an independent sum", function()
    local rows = walls.points(13) -- fewer than are held out: all of them judge
    local grid = ylm.bake(adaptive { measure = "irradiance" }, walls.lamp, { occupied = rows })
    local points, normals = {}, {}
    for i, row in ipairs(rows) do
      points[i], normals[i] = { row[1], row[2], row[3] }, { row[4], row[5], row[6] }
    end
    local errors = irradiance.errors(grid:sample(points), ylm.light_field(1, walls.lamp, points), normals)
    local largest, failed = 0, 0
    for _, e in ipairs(errors) do
      largest = math.max(largest, e)
      if e > 0.05 then failed = failed + 1 end
    end
    assert.equal(1, grid.stats.confidence)
    assert.is_true(math.abs(grid.stats.largest_error - largest) < 1e-4 * largest + 1e-6)
    assert.equal(failed, grid.stats.failed)
    assert.is_true(grid.stats.met)
  end)

  it("takes normals of surfaces, of both of their sides", function()
    local wall = ylm.quad { corner = { -1, -1, walls.height }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    local grid = ylm.bake(adaptive { tolerance = 0.1 }, walls.field, { geometry = wall, quantity = "direct" })
    assert.equal("irradiance", grid.measure)
    assert.is_true(grid.stats.met, tostring(grid.stats.warning))
  end)

  it("does not depend on threads", function()
    local one = ylm.bake(adaptive(), walls.field, { occupied = walls.points(9), quantity = "all", threads = 1 })
    local three = ylm.bake(adaptive(), walls.field, { occupied = walls.points(9), quantity = "all", threads = 3 })
    assert.equal(core.grid_encode(one), core.grid_encode(three))
  end)
end)

describe("bias", function()
  it("keeps the tolerance beside a wall of one quad, where the look-up at the points cannot", function()
    local rows = walls.points(16)
    local with = ylm.bake(adaptive(), walls.field, { occupied = rows, quantity = "direct" }).stats
    assert.is_true(with.met)
    assert.equal(0, with.crossed)
    local warnings = ylm.warnings
    ylm.warnings = false
    local without = ylm.bake(adaptive { bias = 0 }, walls.field, { occupied = rows, quantity = "direct" }).stats
    ylm.warnings = warnings
    assert.is_false(without.met)
    assert.is_true(without.failed > 0.5 * without.verified)
    assert.equal(without.failed, without.crossed)
    assert.truthy(without.warning:find("in voxels that surfaces cross, where light jumps; leave bias = 0 out", 1, true),
      without.warning)
  end)

  it("looks points up in files as in the grid", function()
    local grid = ylm.bake(adaptive { bias = 0.5 }, walls.field, { occupied = walls.points(6), quantity = "indirect" })
    local loaded = core.grid_decode(core.grid_encode(grid))
    for _, name in ipairs { "quantity", "measure", "bias", "tolerance" } do assert.equal(grid[name], loaded[name], name) end
    assert.equal(0.5, loaded.bias)
    assert.equal("indirect", loaded.quantity)
    assert.equal(core.grid_encode(grid), core.grid_encode(loaded))
  end)

  it("leaves the files of grids of lights as they were", function()
    local grid = ylm.bake(adaptive { depth = 3 }, walls.lamp)
    local bytes = core.grid_encode(grid)
    assert.is_nil(bytes:find("quantity", 1, true))
    assert.is_nil(bytes:find("measure", 1, true))
    assert.is_nil(bytes:find("validity", 1, true))
  end)

  it("carries linear light exactly from beside a wall, by half of itself at most", function()
    local linear = walls.linear
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, lmax = 0, channels = "luminance", cells = { 5, 4, 7 } }, linear,
      { quantity = "all" })
    local rows = {}
    for i = 1, 40 do
      local a, b = i * 2.4, math.cos(i)
      rows[i] = { 0.5 * math.cos(3 * a), 0.5 * math.sin(2 * a), 0.3 * b, math.cos(a) * math.sqrt(1 - b * b),
        math.sin(a) * math.sqrt(1 - b * b), b }
    end
    local value, places = core.grid_sample_biased(grid, ylm.array(rows, "float"), 1)
    for i, row in ipairs(rows) do
      local h = { 2.2 / 5, 2.2 / 4, 2.2 / 7 }
      local wanted = h[1] * math.abs(row[4]) + h[2] * math.abs(row[5]) + h[3] * math.abs(row[6])
      for a = 1, 3 do assert.is_true(math.abs(places[i][a] - row[a] - wanted * row[a + 3]) < 1e-5) end
      local there, here = walls.linear_at(places[i]), walls.linear_at(row)
      local part = math.min(1, 0.5 * math.abs(there) / math.abs(here - there))
      assert.is_true(math.abs(value[i][1][1] - there - part * (here - there)) < 1e-5)
    end
  end)
end)
