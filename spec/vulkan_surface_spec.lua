-- Grids of surfaces made on a device against the processor's, which finds the voxels for both. On Mesa's lavapipe, where
-- there is no other device.

local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local with = require "spec.support.with"

local box, lamps = bakes.box, bakes.lamps(20, { dark = true })
local shapes = { ylm.torus { radius = 0.6, tube = 0.2, at = { 0, -0.3, 0.1 }, divide = { 24, 12 } },
  ylm.quad { corner = { -1.5, -0.95, 1 }, u = { 2, 0.1, 0 }, v = { 0, 0, -2 } } }

describe("a grid of surfaces made on a device", function()
  local gpu = device.here()
  if not gpu then return end

  local function same(description, stage)
    local here, there = bakes.both(description, lamps, { geometry = shapes }, gpu, stage)
    bakes.same(here, there, 5e-5) -- of the metric near lamps
    assert(here.stats.outside > 0 and here.stats.outside == there.stats.outside)
    return here
  end

  local function adaptive(o)
    return ylm.adaptive_grid(with({ bounds = box, lmax = 1, depth = 4, threshold = 0.5 }, o))
  end

  it("has the processor's cells and points where a threshold decides, at every depth", function()
    for _, depth in ipairs { 0, 1, 4 } do same(adaptive { depth = depth, threshold = 0.1 }, "subdivide") end
    same(adaptive { depth = 9, threshold = 30 }, "subdivide")
  end)

  it("has the processor's voxels where it is uniform", function()
    for _, cells in ipairs { { 1, 1, 1 }, { 5, 4, 3 }, { 2, 2, 33 }, { 16, 16, 16 } } do
      same(ylm.uniform_grid { bounds = box, lmax = 1, cells = cells }, "subdivide")
    end
  end)

  it("keeps a tolerance as the processor's does, with the same held-out points", function()
    local description = ylm.adaptive_grid { bounds = box, lmax = 1, depth = 4, tolerance = 0.05 }
    local here, there = bakes.both(description, lamps, { geometry = shapes }, gpu, "residuals")
    for _, key in ipairs { "met", "rounds", "verified", "outside" } do assert.equal(here.stats[key], there.stats[key], key) end
    assert(math.abs(here.stats.points - there.stats.points) <= 0.01 * here.stats.points)
    assert(math.abs(here.stats.error - there.stats.error) <= 0.02 * here.stats.error + 1e-6)
  end)

  it("is sampled there, without flags", function()
    local grid = assert(ylm.bake(adaptive {}, lamps, { geometry = shapes, device = gpu }))
    local _, _, report = grid:sample({ { 0, -0.9, 0 }, { 0, 5, 0 } }, { device = gpu })
    assert.equal(1, report.outside)
    local ok, message = pcall(grid.sample, grid, { { 0, 0, 0 } }, { device = gpu, flags = true })
    assert(not ok and message:find("flags: the processor finds them: leave device out", 1, true), message)
  end)

  it("says what a device says of shapes beyond the bounds", function()
    local ok, message = pcall(ylm.bake, adaptive {}, lamps, { geometry = ylm.sphere { at = { 9, 9, 9 } }, device = gpu })
    assert(not ok and message:find "no triangle lies within the bounds", message)
  end)
end)
