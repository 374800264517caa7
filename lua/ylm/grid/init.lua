--- Grids of light-field coefficients: their descriptions, ylm.adaptive_grid and ylm.uniform_grid.
--
-- ylm.bake and the methods of a grid are in grid/*.lua, by subject; all of them are loaded from here.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"

local grid = {}

local DEFAULT_TOLERANCE = 0.01

local bounds_field = { "bounds", "bounds", optional = true, unit = "scene units",
  about = "corners {min, max}; default: those of the geometry or of the occupied points" }
local lmax_field = { "lmax", "integer", min = 0, max = core.limits.lmax, default = 4, about = "highest degree" }
local channels_field = { "channels", "choice", of = core.choices("channels", "rgb"), default = "rgb",
  about = "what is baked: three linear channels, or one" }

local dynamic_field = { "dynamic", "boolean", default = false,
  about = "keeps what grid:update needs to follow sphere and flat lights point by point: Hessians, "
    .. "lights, where light is needed" }

grid.adaptive_grid = form.define("adaptive_grid", {
  shelf = "everyday",
  about = "An octree of voxels that subdivides where its interpolation would be wrong and light is needed. "
    .. "tolerance promises an error; threshold reproduces the paper's metric. Without either, tolerance is 0.01.",
  fields = {
    bounds_field, lmax_field,
    { "depth", "integer", min = 0, max = core.limits.grid_depth, default = 6,
      about = "finest level N: 2^N voxels along each axis" },
    { "tolerance", "number", above = 0, optional = true,
      about = "relative L2 error that 99 % of the occupied points keep, of surfaces 99 % of the area; verified after "
        .. "bakes and updates, see stats.met" },
    { "points", "integer", min = 64, max = core.limits.grid_points, optional = true,
      about = "evaluated points at most. With sides, beside a tolerance: refinement ends at about so many, and stats.spent says "
        .. "so. Else instead of a tolerance: the least error that so many points have, by up to four bakes" },
    { "bytes", "memory", optional = true,
      about = "instead of a tolerance: the least error in a file of so many bytes, a number or '2 MB', by up to four bakes. The "
        .. "grid is what its file decodes to (grid.small), and grid:save without options writes that file" },
    { "measure", "choice", of = core.choices "measure", optional = true,
      about = "what tolerance is of: 'coefficients', the distance of all of them relative to their norm; 'irradiance', the "
        .. "irradiance of occupied points with normals, relative to itself or, where that is more, to its mean over "
        .. "the occupied points, in the worst channel. Default: 'irradiance' where light jumps at surfaces (quantity is not "
        .. "'lights') and normals are known, else 'coefficients'" },
    { "floor", "number", min = 0, optional = true,
      about = "of a tolerance of coefficients: a norm that is smaller counts as this one, so that darkness is not refined "
        .. "without end. Default: sqrt(4 pi), the norm of the function 1, of visibilities, else 0" },
    { "metric", "choice", of = core.choices("metric", "relative"), default = "relative",
      about = "the Hessian's error metric that threshold is compared with" },
    { "threshold", "number", min = 0, optional = true, about = "voxels above it are subdivided" },
    { "metric_channels", "choice", of = core.choices "channels", default = "luminance",
      about = "what the metric is of" },
    channels_field,
    { "continuous", "boolean", default = true, about = "no jumps between voxels of different levels" },
    { "bricks", "integer", min = 1, max = core.limits.grid_depth - 2, optional = true,
      about = "bakes in bricks, the subtrees below the voxels of this level (at most depth - 2), each a file of the folder "
        .. "that ylm.bake's option to names: for grids that do not fit into memory. Default: 3 where there is such a folder, "
        .. "else none" },
    dynamic_field,
  },
  build = function(values, fail)
    if values.tolerance and values.threshold then
      return fail("either tolerance or threshold, not both: a tolerance chooses where to subdivide itself")
    end
    if values.metric_channels == "rgb" and values.channels ~= "rgb" then
      return fail("metric_channels = 'rgb' needs channels = 'rgb'")
    end
    if values.bricks and values.bricks > values.depth - 2 then
      return fail(("bricks = %d: at most depth - 2, which is %d"):format(values.bricks, values.depth - 2))
    end
    if values.bricks and values.dynamic then
      return fail("bricks: a grid that follows lights is not baked in bricks; leave dynamic or bricks out")
    end
    if values.points and values.threshold then
      return fail("points end refinement by a tolerance: give one, or leave points out")
    end
    if values.bytes then
      for _, name in ipairs { "tolerance", "threshold", "points", "bricks" } do
        if values[name] then return fail(("bytes choose the error: leave %s out"):format(name)) end
      end
      if values.dynamic then return fail("bytes: a grid that follows lights is saved as it is; leave dynamic or bytes out") end
    end
    if values.measure and values.threshold then
      return fail("measure is what a tolerance is of: give a tolerance, or leave measure out")
    end
    if values.measure == "irradiance" and values.dynamic then
      return fail("measure = 'irradiance': a dynamic grid keeps a tolerance of coefficients; leave dynamic or measure out")
    end
    if (values.floor or 0) > 0 and (values.threshold or values.measure == "irradiance" or values.dynamic) then
      return fail("floor is of a tolerance of coefficients, of grids that follow no lights: leave floor out")
    end
    values.free = not values.threshold and not values.tolerance and (values.points or values.bytes) and true or nil
    if not values.threshold and not values.tolerance then values.tolerance = DEFAULT_TOLERANCE end
    return setmetatable(values, form.defined.adaptive_grid.metatable)
  end,
  example = "adaptive_grid { bounds = { {-2, 0, -2}, {2, 3, 2} }, lmax = 4, depth = 6, tolerance = 0.01 }",
  source = "Iwasaki & Dobashi 2025, Sec. 5",
})

--- Voxels along each axis: one number for all, or three.
function form.types.cells(x)
  local most = core.limits.grid_side
  local wanted = ("voxels along each axis: an integer or three, 1 to %d each"):format(most)
  if check.is_integer(x) then x = { x, x, x } end
  if type(x) ~= "table" or #x ~= 3 then return nil, wanted end
  for i = 1, 3 do
    if not check.is_integer(x[i]) or x[i] < 1 or x[i] > most then return nil, wanted end
  end
  return { x[1], x[2], x[3] }
end

grid.uniform_grid = form.define("uniform_grid", {
  shelf = "everyday",
  about = "A lattice of equal voxels.",
  fields = {
    bounds_field, lmax_field,
    { "cells", "cells", about = "voxels along each axis: a number, or {nx, ny, nz}" },
    channels_field,
    { "metric_channels", "choice", of = core.choices "metric_channels", default = "luminance",
      about = "what the metric is of; none: faster to bake, and cells() knows no errors" },
    { "metric", "choice", of = core.choices("metric", "relative"), default = "relative",
      about = "of the errors that cells() reports" },
    dynamic_field,
  },
  build = function(values, fail)
    if values.metric_channels == "rgb" and values.channels ~= "rgb" then
      return fail("metric_channels = 'rgb' needs channels = 'rgb'")
    end
    if values.cells[1] * values.cells[2] * values.cells[3] > core.limits.grid_cells then
      return fail("cells are too many: at most " .. check.limit_text(core.limits.grid_cells) .. " in all")
    end
    return setmetatable(values, form.defined.uniform_grid.metatable)
  end,
  example = "uniform_grid { bounds = { {-2, 0, -2}, {2, 3, 2} }, cells = { 8, 8, 8 }, lmax = 4 }",
})

local bake = require "ylm.grid.bake"
grid.bake, grid.bake_scene, grid.lights_of = bake.bake, bake.of_scene, bake.lights_of

require "ylm.grid.update"
require "ylm.grid.sample"
require "ylm.grid.look"
require "ylm.grid.export"

local file = require "ylm.grid.file"
local set = require "ylm.grid.set"
require "ylm.memory".publish(core.metatable "ylm.grid")
require "ylm.memory".publish(core.metatable "ylm.grid_set")
grid.open_set = set.open
grid.magic, grid.load = file.magic, file.load

return grid
