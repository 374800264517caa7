--- The grids of spec/data/grid_1_*.ylm, which were written by the writer of version 1.

local ylm = require "ylm"
local grids = require "spec.support.grids"

local old = {}

--- A field whose values and gradients are exact in float, with a metric that refines half of the box.
local field = grids.analytic(function(x, y, z)
  return x * x + y - 0.5 * z, 2 * x, 1, -0.5
end, function(x) return x < 0 and 8 or 0.25 end)

--- A continuous octree; some of its voxels hold no shading points.
function old.octree()
  return ylm.bake(ylm.adaptive_grid { bounds = grids.box, lmax = 1, depth = 3, threshold = 1, metric = "absolute",
    channels = "luminance" },
    field, { occupied = ylm.array { { -0.1, -0.6, -0.9 }, { 0.3, -0.5, -0.4 } } })
end

--- A lattice of 3 x 1 x 2 voxels, of which one holds data.
function old.lattice()
  return ylm.bake(ylm.uniform_grid { bounds = grids.box, cells = { 3, 1, 2 }, lmax = 0 }, field,
    { occupied = ylm.array { { 0.1, 0, 0.9 } } })
end

return old
