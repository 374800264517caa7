--- Grids: conventions of cells and points, what can be read of them, and that they are light fields.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local points_in = require "spec.support.random".points_in

local SEED, box, lamp = grids.seed, grids.box, grids.lamp

describe("a grid", function()
  it("keeps at the corners what the reference vectors say", function()
    local light, corners, inner = nil, {}, {}
    for line in io.lines("spec/data/hermite_grid.txt") do
      local tag, rest = line:match("^(%u) (.*)")
      local row = {}
      for word in (rest or ""):gmatch("%S+") do row[#row + 1] = tonumber(word) end
      if tag == "S" then light = row elseif tag == "C" then corners[#corners + 1] = row
      elseif tag == "P" then inner[#inner + 1] = row end
    end
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 3,
      channels = "luminance" }, ylm.sphere_light { at = { light[1], light[2], light[3] }, radius = light[4] })
    local points = grid:points()
    local row = {}
    for i = 1, 8 do
      row[("%g %g %g"):format(points.position:get(i, 1), points.position:get(i, 2), points.position:get(i, 3))] = i
    end
    for _, c in ipairs(corners) do
      local i, k = row[("%g %g %g"):format(c[1], c[2], c[3])], ylm.sh.index(c[4], c[5])
      assert.near(c[6], points.value:get(i, 1, k), 1e-6)
      for a = 1, 3 do assert.near(c[6 + a], points.gradient:get(i, 1, k, a), 1e-6) end
    end
    local norm = points.norm[1]
    for _, p in ipairs(inner) do -- interpolated across the whole voxel: a few percent
      local c = grid:sample { p[1], p[2], p[3] }
      assert.near(p[6], c:get(1, ylm.sh.index(p[4], p[5])), 0.05 * norm)
    end
  end)

  it("has half-open cells, the last ones closed, for occupancy and locate alike", function()
    local function cell_of(p)
      local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 3, threshold = 0 }, lamp,
        { occupied = { p } })
      local cell = grid:locate(p)
      assert.is_true(cell.leaf and cell.occupied and cell.baked)
      assert.equal(3, cell.level)
      return cell.origin
    end
    assert.same({ 0, 0, 0 }, cell_of { 0, 0, 0 })
    assert.same({ -0.25, 0.75, -1 }, cell_of { -1e-12, 1, -1 })
    assert.same({ 0.75, 0.75, 0.75 }, cell_of { 1, 1, 1 })
    assert.same({ 0.75, -1, 0.75 }, cell_of { 7, -9, 1 }) -- outside: the nearest
  end)

  it("numbers cells and points from 1, levels from 0, parents before children", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 2, threshold = 0 }, lamp)
    local cells = grid:cells()
    assert.equal(1 + 8 + 64, #cells.level)
    assert.equal(0, cells.level[1])
    assert.same({ -1, -1, -1 }, cells.origin[1]:totable())
    assert.same({ 2, 2, 2 }, cells.size[1]:totable())
    assert.equal(125, grid.stats.points)
    assert.equal(64, grid.stats.leaves)
    assert.equal(3, grid.stats.levels)
    assert.equal(125, grid.stats.pairs)
  end)
end)

describe("a grid's fields", function()
  it("are what it was described with; resolution is the voxels along each axis", function()
    local u = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 2, 3, 4 }, lmax = 1, channels = "luminance" }, lamp)
    local a = ylm.bake(ylm.adaptive_grid { bounds = box, depth = 3, lmax = 2, threshold = 50 }, lamp)
    assert.same({ 2, 3, 4 }, u.resolution)
    assert.same({ 8, 8, 8 }, a.resolution)
    assert.same({ "uniform", 1, 1, "adaptive", 2, 3, 3, 50 },
      { u.kind, u.lmax, u.channels, a.kind, a.lmax, a.channels, a.depth, a.threshold })
    assert.same(box, u.bounds)
    assert.equal(24, #u:cells().level)
    assert.is_nil(u.depth)
  end)
end)

describe("ylm.light_field of a grid", function()
  it("is what the grid samples, and can be baked again", function()
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 3 }, lamp)
    local p = points_in(50, box[1], box[2], SEED)
    local c, dc = grid:sample(p, { derivatives = 1, dtype = "double" })
    local L, dL, _, report = ylm.light_field(3, grid, p, { derivatives = 1, dtype = "double", metric = "luminance" })
    assert.equal(0, core.array_distance(c, L))
    assert.equal(0, core.array_distance(dc, dL))
    assert.is_true(report.lambda[1] > 0 and report.norm[1] > 0)
    local grey = ylm.light_field(1, grid, p, { channels = "luminance", dtype = "double" })
    assert.near(0.2126 * L:get(1, 1, 2) + 0.7152 * L:get(1, 2, 2) + 0.0722 * L:get(1, 3, 2), grey:get(1, 1, 2), 1e-6)
    local again = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 3 }, grid)
    local d, _, norm = core.array_distance(grid:points().value, again:points().value)
    assert.is_true(d < 1e-5 * norm)
  end)
end)
