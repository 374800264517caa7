--- Grids of light-field coefficients: ylm.adaptive_grid, ylm.uniform_grid, ylm.bake, and their methods.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"
local describe = require "ylm.reference".describe
local outputs = require "ylm.outputs"

local device_lights = require "ylm.vulkan_light"

local grid = {}
local methods = core.metatable "ylm.grid"

require "ylm.reference".object "grid" {
  about = "A baked grid of probes. What it was described with can be read from it, but for the cells of a uniform "
    .. "grid, since grid:cells() are the voxels themselves: they are grid.resolution.",
  fields = {
    { "kind", "string", "'adaptive' or 'uniform'" },
    { "resolution", "table", "{ nx, ny, nz }: voxels along each axis, of an adaptive grid those of its finest level" },
    { "bounds", "table", "{ lowest, highest }, scene units" },
    { "lmax", "integer", "of the coefficients" },
    { "channels", "integer", "1 luminance, 3 rgb" },
    { "metric_channels", "string", "what the error metric is of" },
    { "dynamic", "boolean", "whether grid:update follows lights" },
    { "depth", "integer", "finest level of an adaptive grid; its metric, continuous, and tolerance or threshold likewise" },
    { "stats", "table", "points, cells, leaves, levels, pairs, invalid, bytes, ...; with a tolerance met and error; "
      .. "seconds, of which field_seconds in the light field, occupancy_, lattice_, residual_ and continuity_seconds in "
      .. "parts of the bake (0 in a loaded grid), verify_seconds (field included) to verify; baked on a device stages: by name "
      .. "{ seconds, longest, dispatches }" },
  },
}

-- Descriptions -------------------------------------------------------------------

local KIND = { adaptive_grid = 0, uniform_grid = 1 }
local METRIC_CHANNELS = { none = 0, luminance = 1, rgb = 3 }
local METRIC = { absolute = 0, relative = 1 }
local DEFAULT_TOLERANCE = 0.01

local bounds_field = { "bounds", "bounds", optional = true, unit = "scene units",
  about = "corners {min, max}; default: those of the occupied points (of a scene: its geometry)" }
local lmax_field = { "lmax", "integer", min = 0, max = 100, default = 4, about = "highest degree" }
local channels_field = { "channels", "choice", of = { "rgb", "luminance" }, default = "rgb",
  about = "what is baked: three linear channels, or one" }

local dynamic_field = { "dynamic", "boolean", default = false,
  about = "keeps what grid:update needs to follow lights that move: Hessians, shading points, lights" }

grid.adaptive_grid = form.define("adaptive_grid", {
  about = "An octree of voxels that subdivides where its interpolation would be wrong and shading points are. "
    .. "tolerance promises an error; threshold reproduces the paper's metric. Without either, tolerance is 0.01.",
  fields = {
    bounds_field, lmax_field,
    { "depth", "integer", min = 0, max = 16, default = 6, about = "finest level N: 2^N voxels along each axis" },
    { "tolerance", "number", above = 0, optional = true,
      about = "relative L2 error that 99 % of the occupied points keep; verified after the bake, see stats" },
    { "metric", "choice", of = { "relative", "absolute" }, default = "relative",
      about = "the Hessian's error metric that threshold is compared with" },
    { "threshold", "number", min = 0, optional = true, about = "voxels above it are subdivided" },
    { "metric_channels", "choice", of = { "luminance", "rgb" }, default = "luminance",
      about = "what the metric is of" },
    channels_field,
    { "continuous", "boolean", default = true, about = "no jumps between voxels of different levels" },
    dynamic_field,
  },
  build = function(values, fail)
    if values.tolerance and values.threshold then
      return fail("either tolerance or threshold, not both: a tolerance chooses where to subdivide itself")
    end
    if values.metric_channels == "rgb" and values.channels ~= "rgb" then
      return fail("metric_channels = 'rgb' needs channels = 'rgb'")
    end
    if not values.threshold and not values.tolerance then values.tolerance = DEFAULT_TOLERANCE end
    return setmetatable(values, form.defined.adaptive_grid.metatable)
  end,
  example = "adaptive_grid { bounds = { {-2, 0, -2}, {2, 3, 2} }, lmax = 4, depth = 6, tolerance = 0.01 }",
  source = "Iwasaki & Dobashi 2025, Sec. 5",
})

--- Voxels along each axis: one number for all, or three.
function form.types.cells(x)
  local wanted = "voxels along each axis: an integer or three, 1 to 1048576 each"
  if check.is_integer(x) then x = { x, x, x } end
  if type(x) ~= "table" or #x ~= 3 then return nil, wanted end
  for i = 1, 3 do
    if not check.is_integer(x[i]) or x[i] < 1 or x[i] > 2 ^ 20 then return nil, wanted end
  end
  return { x[1], x[2], x[3] }
end

grid.uniform_grid = form.define("uniform_grid", {
  about = "A lattice of equal voxels.",
  fields = {
    bounds_field, lmax_field,
    { "cells", "cells", about = "voxels along each axis: a number, or {nx, ny, nz}" },
    channels_field,
    { "metric_channels", "choice", of = { "luminance", "rgb", "none" }, default = "luminance",
      about = "what the metric is of; none: faster to bake, and cells() knows no errors" },
    { "metric", "choice", of = { "relative", "absolute" }, default = "relative",
      about = "of the errors that cells() reports" },
    dynamic_field,
  },
  build = function(values, fail)
    if values.metric_channels == "rgb" and values.channels ~= "rgb" then
      return fail("metric_channels = 'rgb' needs channels = 'rgb'")
    end
    if values.cells[1] * values.cells[2] * values.cells[3] > 2 ^ 31 then
      return fail("cells are too many: at most 2^31 in all")
    end
    return setmetatable(values, form.defined.uniform_grid.metatable)
  end,
  example = "uniform_grid { bounds = { {-2, 0, -2}, {2, 3, 2} }, cells = { 8, 8, 8 }, lmax = 4 }",
})

-- Baking --------------------------------------------------------------------------

--- The box around points, at least a thousandth as wide as it is long. Extent 0 in all axes is refused.
local function bounds_of(points)
  local lo, hi = core.grid_bounds(points)
  local largest = math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3])
  if largest <= 0 then return nil end
  for i = 1, 3 do
    local missing = largest * 1e-3 - (hi[i] - lo[i])
    if missing > 0 then lo[i], hi[i] = lo[i] - missing / 2, hi[i] + missing / 2 end
  end
  return { lo, hi }
end

local bake_options = {
  { "occupied", "any", optional = true,
    about = "shading points [n][3]: voxels without any are not subdivided; default: every voxel is occupied" },
  { "bounds", "bounds", optional = true, about = "where the description has none" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of the choice of held-out points" },
  { "max_points", "integer", min = 8, max = 2 ^ 32 - 2, default = 2 ^ 24, about = "nil, message, 'ELIMIT' beyond" },
  light.tolerance_option "light_tolerance",
  { "threads", "integer", min = 1, max = 1024, optional = true, about = "default: YLM_THREADS or all cores" },
  { "progress", "progress", optional = true, about = "called as f(done, total, stage); returning false cancels" },
  { "device", "gpu", optional = true,
    about = "sphere lights, and flat ones with method = 'sphere', are summed there, grids refined there (with a "
      .. "tolerance by the processor, from what the device measures); the grid stays there, for device = gpu of "
      .. "grid:sample and scene:render; grid.stats.stages says how long that took" },
}

--- Grid -> times by stage of the device that it was baked on.
local stages_of = setmetatable({}, { __mode = "k" })

--- Grid -> the lights it was baked from.
local baked_from = setmetatable({}, { __mode = "k" })

describe "bake" {
  about = "Evaluates a light field at the points of a grid: each corner of a voxel once, level by level.",
  arguments = {
    { "description", "adaptive_grid|uniform_grid", "what grid" },
    { "lights", "light|list|function", "a light, a list of lights, what has a light field (a grid too), or an analytic "
      .. "field f(points, lmax, channels) -> values [n][channels][count], gradients [..][3], lambda [n] or nil" },
    { "options?", "table", "see the options" },
  },
  options = bake_options,
  returns = { { "grid", "grid", "grid.stats says what was done, and with a tolerance the error that was measured" } },
  errors = "raises on bad arguments; nil, message, code where memory or max_points are exceeded; "
    .. "nil, 'cancelled', 'ECANCELLED' where progress returns false; nil, message, code where a device fails",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = { 10, 8, 6 } }
local floor = {}
for i = 0, 8 do for j = 0, 8 do floor[#floor + 1] = { i / 4 - 1, 0, j / 4 - 1 } end end
local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 3,
  tolerance = 0.01 },
  lamp, { occupied = floor })
assert(grid.stats.met and grid.stats.error <= 0.01)]],
  source = "Iwasaki & Dobashi 2025, Sec. 5.1",
}
function grid.bake(description, lights, given)
  local kind = form.kind(description)
  if not KIND[kind] then
    return check.bad(1, "bake", "an adaptive_grid or a uniform_grid expected, got %s", check.describe(description))
  end
  local o = form.options(3, "bake", bake_options, given)
  if description.dynamic and o.light_tolerance then
    return check.bad(3, "bake", "a grid with dynamic = true sums its lights exactly: leave light_tolerance out")
  end
  local packed, object, failed, why = lights, lights
  if type(lights) ~= "function" then
    packed, failed, why = light.field(2, "bake", lights)
    if not packed then return nil, failed, why end
    object, failed, why = light.within("bake", packed, o.light_tolerance, o.threads)
    if not object then return nil, failed, why end
  end
  if description.dynamic and core.type(object) ~= "ylm.lights" then
    return check.bad(2, "bake", "a grid with dynamic = true follows sphere lights, this is baked from %s: bake that into "
      .. "a second grid, or leave dynamic out", light.other(object))
  end
  local occupied
  if o.occupied ~= nil then
    occupied = array.points(3, "bake", o.occupied)
    if #occupied == 0 then return check.bad(3, "bake", "occupied: at least one point expected") end
  end
  local box = description.bounds or o.bounds or (occupied and bounds_of(occupied))
  if not box then
    return check.bad(1, "bake", "no bounds: give them in the grid, or occupied points that span a box")
  end
  local cells = description.cells or { 1, 1, 1 }
  local progress = o.progress and require "ylm.progress".of(o.progress) or nil
  local on, made = object, nil
  if o.device then
    if o.light_tolerance then
      return check.bad(3, "bake", "light_tolerance: a device sums all lights; leave one out")
    end
    if type(object) == "function" then return check.bad(3, "bake", "device: a device sums sphere lights, and no functions") end
    if description.dynamic then
      return check.bad(3, "bake", "device: a dynamic grid follows its lights on the processor")
    end
    on, made, failed = device_lights.on(3, "bake", object, o)
    if not on then return nil, made, failed end
  end
  local before = device_lights.times(on)
  local bake = device_lights.baker(on) or core.grid_bake
  local baked, message, code = check.result("bake", bake({
    kind = KIND[kind], lmax = description.lmax, depth = description.depth or 0, cells = cells,
    bounds = { box[1][1], box[1][2], box[1][3], box[2][1], box[2][2], box[2][3] },
    channels = description.channels == "rgb" and 3 or 1,
    metric_channels = METRIC_CHANNELS[description.metric_channels],
    metric = METRIC[description.metric],
    threshold = description.threshold or -1, tolerance = description.tolerance or 0,
    continuous = description.continuous and 1 or 0, dynamic = description.dynamic and 1 or 0,
  }, on, occupied, o.seed, o.threads or 0, o.max_points, progress))
  if baked == nil then
    if made then on:close() end
    return nil, message, code
  end
  stages_of[baked] = device_lights.times(on, before)
  device_lights.keep(on, baked, message)
  if made then on:close() end
  if core.type(packed) == "ylm.lights" then baked_from[baked] = packed end
  return baked
end

--- The lights that a grid was baked from, if that was in this program and they were lights; for pictures.
function grid.lights_of(g)
  local lights = baked_from[g]
  return lights and core.lights_count(lights) and lights or nil
end

-- Methods ---------------------------------------------------------------------------

local function open(g, name)
  local is_open, updating = core.grid_is_open(g)
  if updating then return check.fail("%s: the grid is being updated", name) end
  if is_open then return g end
  if is_open == nil then
    return check.fail("%s: a grid expected before the colon, got %s", name, check.describe(g))
  end
  return check.fail("%s: the grid has been closed", name)
end

local update_options = {
  { "tolerance", "number", min = 0, optional = true,
    about = "what is left as it is may be off by this, relative to the field; 0: nothing is left. "
      .. "Default: an eighth of the grid's tolerance, 0.001 where it has none" },
  { "threads", "integer", min = 1, max = 1024, optional = true, about = "default: YLM_THREADS or all cores" },
  { "progress", "progress", optional = true, about = "called as f(done, total, stage); returning false cancels" },
}

describe "grid:update" {
  about = "Follows lights that moved, changed, appeared or vanished: only what they change beyond the tolerance is "
    .. "baked again, and the octree is refined and merged to suit. The grid must have been made with dynamic = true.",
  arguments = {
    { "lights", "light|list", "all lights as they are now; those that did not change are recognised by their place "
      .. "in the list, else by their content" },
    { "options?", "table", "see the options" },
  },
  options = update_options,
  returns = { { "report", "table", "also grid.stats.update: lights that changed, points brought up to date, exact: of "
    .. "these with all lights, skipped: within the tolerance, added, removed, pairs, seconds, field_seconds, "
    .. "tree_seconds, rebaked, updates; with a tolerance verified, error and met, of held-out points in voxels that "
    .. "changed" } },
  errors = "raises on bad arguments and a grid that is not dynamic; nil, message, code where memory or max_points are "
    .. "exceeded; nil, 'cancelled', 'ECANCELLED' where progress returns false: the grid is then as it was",
  example = [[
local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 10 } end
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, dynamic = true },
  { lamp(0), lamp(1) })
local report = grid:update { lamp(0), lamp(1.2) }
assert(report.lights == 1 and report.points > 0)]],
}
function methods.update(g, lights, given)
  open(g, "update")
  local o = form.options(2, "update", update_options, given)
  local object = light.field(1, "update", lights)
  if core.type(object) ~= "ylm.lights" then
    return check.bad(1, "update", "a dynamic grid follows sphere lights, got %s: bake that into a second grid",
      light.other(object))
  end
  if not core.grid_form(g).dynamic then
    return check.fail("update: this grid does not follow lights: make it with dynamic = true (a loaded grid never does)")
  end
  local progress = o.progress and require "ylm.progress".of(o.progress) or nil
  local report, message, code = check.result("update", core.grid_update(g, object, o.tolerance or -1, o.threads or 0,
    progress))
  if report == nil then return nil, message, code end
  baked_from[g] = object
  return report
end

local INTERPOLATION = { hermite = 0, taylor = 1, linear = 2 }

local sample_options = {
  { "interpolation", "choice", of = { "hermite", "taylor", "linear" }, default = "hermite",
    about = "cubic Hermite (fourth order), the corners' first-order expansions, or trilinear" },
  { "derivatives", "integer", min = 0, max = 1, default = 0, about = "1: also the interpolant's gradient" },
  { "outside", "choice", of = { "clamp", "nan" }, default = "clamp",
    about = "points outside of the bounds: those of the nearest point inside, or NaN" },
  { "dtype", "choice", of = { "float", "double" }, default = "float", about = "of the results" },
  { "threads", "integer", min = 1, max = 1024, optional = true, about = "default: YLM_THREADS or all cores" },
  { "device", "gpu", optional = true,
    about = "interpolates there, in float, with the copy of grid:to(gpu), made where there is none; new results are where "
      .. "the points are; report.stages" },
  { "out", "any", optional = true, about = "an array, or a list of two, shaped and typed like the results, which they take; "
    .. "with device also in its memory" },
  { "progress", "progress", optional = true, about = "called as f(done, total, stage); returning false cancels" },
}

describe "grid:sample" {
  about = "Interpolates coefficients at points. Fastest where neighbours in the array are neighbours in space.",
  arguments = {
    { "points", "array|table|gpu_array", "[n][3] or one point, scene units; with device also an array in its memory, whose "
      .. "numbers are not checked" },
    { "options?", "table", "see the options" },
  },
  options = sample_options,
  returns = {
    { "c", "array", "[n][channels][(lmax+1)^2]; a gpu_array where the points or out are" },
    { "dc", "array", "[n][channels][(lmax+1)^2][3], the same, or nil" },
    { "report", "table", "outside: points outside of the bounds; unbaked: points in voxels without data of their own, "
      .. "which the nearest evaluated ancestor (uniform: voxel) answers for; seconds" },
  },
  errors = "raises on bad arguments; nil, 'cancelled', 'ECANCELLED' where progress returns false",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1 }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 2 }, lamp)
local c, dc, report = grid:sample({ { 0, 0, 0 }, { 5, 0, 0 } }, { derivatives = 1 })
assert(c.shape[3] == 9 and dc.shape[4] == 3 and report.outside == 1)]],
}
function methods.sample(g, points, given)
  open(g, "sample")
  local o = form.options(2, "sample", sample_options, given)
  local on_device, p, single = core.type(points) == "ylm.gpu_array", points, false
  if on_device then require "ylm.vulkan_grid".check_points(points, o)
  else p, single = array.points(1, "sample", points) end
  local shape = { on_device and points.shape[1] or #p, g.channels, (g.lmax + 1) ^ 2 }
  local shapes = { shape, o.derivatives > 0 and { shape[1], shape[2], shape[3], 3 } or nil }
  local out1, out2
  if o.device then out1, out2 = require "ylm.vulkan_grid".outputs(2, "sample", o.out, shapes) end
  if not (out1 or out2) then out1, out2 = outputs.of(2, "sample", o.out, o.dtype, shapes, points) end
  local progress = o.progress and require "ylm.progress".of(o.progress) or nil
  if o.device then
    local c, dc, report = require "ylm.vulkan_grid".sample(g, p, o, INTERPOLATION[o.interpolation], out1, out2, progress)
    if c and single and core.type(c) == "ylm.array" and not out1 then c, dc = c[1], dc and dc[1] end
    return c, dc, report
  end
  local c, dc, outside, unbaked, seconds = check.result("sample", core.grid_sample(g, p, INTERPOLATION[o.interpolation],
    o.derivatives, o.outside == "nan", o.dtype, o.threads or 0, progress, out1, out2))
  if c == nil then return nil, dc, outside end
  if single and not out1 then c, dc = c[1], dc and dc[1] end
  return c, dc, { outside = outside, unbaked = unbaked, seconds = seconds }
end

describe "grid:to" {
  about = "Copies the grid's coefficients, gradients and cells to a device's memory, where grid:sample uses them by "
    .. "device = gpu. Where there is a copy, as after a bake with device = gpu, that is returned; after an update a new one.",
  arguments = { { "gpu", "gpu", "of ylm.vulkan.open" } },
  returns = { { "copy", "gpu_grid", "or nil, message, code: 'ELIMIT' (more data than a kernel sees), 'ENOMEM', 'EDEVICE'" } },
  errors = "raises where the grid or the device has been closed",
  example = [[
local gpu = ylm.vulkan.open()
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 },
  ylm.sphere_light { at = { 0, 2, 0 } })
if gpu then
  assert(grid:to(gpu).bytes > 0)
  local c, _, report = grid:sample({ { 0, 0, 0 } }, { device = gpu })
  assert(c.shape[3] == 4 and report.stages.sample.seconds >= 0)
end]],
}
function methods.to(g, gpu)
  return require "ylm.vulkan_grid".to(open(g, "to"), gpu)
end

describe "grid:points" {
  about = "Everything that the grid keeps at its points, as arrays: evaluated points first, then those that only "
    .. "continuity needs.",
  arguments = {},
  returns = { { "points", "table", "position [n][3], value [n][channels][count], gradient [n][channels][count][3], "
    .. "lambda [n], norm [n], invalid [n] (1: in a light, filled from neighbours), interpolated [n]" } },
  errors = "raises on a closed grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local points = grid:points()
assert(#points.position == 27 and points.value.shape[3] == 4)]],
}
function methods.points(g)
  return core.grid_points(open(g, "points"))
end

local cells_options = {
  { "added", "boolean", default = false, about = "also the cells that only continuity needs, after the others" },
}

describe "grid:cells" {
  about = "The voxels as arrays: parents before children, eight children in a row.",
  arguments = { { "options?", "table", "see the options" } },
  options = cells_options,
  returns = { { "cells", "table", "origin [n][3], size [n][3], level [n] (0 is the root), error [n] (the metric; NaN "
    .. "where unknown), residual [n] (relative error measured at the centre; NaN where not), leaf [n], occupied [n], "
    .. "baked [n], crossed [n] (by a light's surface), added [n], corners [n][8] (rows of points(); 0: none)" } },
  errors = "raises on a closed grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
assert(#grid:cells().origin == 8 and grid.resolution[1] == 2)]],
}
function methods.cells(g, given)
  open(g, "cells")
  local o = form.options(1, "cells", cells_options, given)
  return core.grid_cells(g, o.added)
end

describe "grid:locate" {
  about = "The cell that holds a point, with everything it knows. Cells are half-open, the last ones closed.",
  arguments = { { "p", "table|array", "{x, y, z}, scene units" } },
  returns = { { "cell", "table",
    "index (a row of cells()), origin, size, level, error, residual, leaf, occupied, baked, "
    .. "crossed, outside (p is outside of the bounds: the cell of the nearest point inside), corners (rows of "
    .. "points()); nil where a uniform grid has no data" } },
  errors = "raises on what is not a point",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local cell = grid:locate { 0.5, 0.5, 0.5 }
assert(cell.index == 8 and cell.origin[1] == 0 and not cell.outside)]],
}
function methods.locate(g, p)
  open(g, "locate")
  local point, wanted = form.types.point(p)
  if not point then return check.bad(1, "locate", "%s expected, got %s", wanted, check.describe(p)) end
  return core.grid_locate(g, point[1], point[2], point[3], false)
end

local save_options = {
  { "byte_order", "choice", of = { "native", "swapped" }, default = "native",
    about = "of a .ylm file; readers take both" },
}

describe "grid:save" {
  about = "Writes the grid; the ending chooses the format. An existing file is replaced whole or not at all.",
  arguments = {
    { "path", "string", ".ylm (everything, checksummed; ylm.load reads it), .vtu (for ParaView)" },
    { "options?", "table", "see the options" },
  },
  options = save_options,
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending; nil, message, code where the file cannot be written",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local name = os.tmpname() .. ".ylm"
assert(grid:save(name))
os.remove(name)]],
}
function methods.save(g, path, given)
  open(g, "save")
  if type(path) ~= "string" or path == "" or path:find("%z") then
    return check.bad(1, "save", "a path expected, got %s", check.describe(path))
  end
  local o = form.options(2, "save", save_options, given)
  local ending = path:lower():match("%.(%w+)$")
  if ending == "ylm" then return check.result("save", core.grid_write(g, path, o.byte_order == "swapped")) end
  if ending == "vtu" then return require "ylm.view_file".save_vtu(g, path) end
  return check.bad(1, "save", "a path ending in .ylm or .vtu expected, got %s", check.describe(path))
end

describe "grid:close" {
  about = "Frees the memory now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is not a grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp):close()]],
}
function methods.close(g)
  open(g, "close")
  check.result("close", core.grid_close(g))
  local there = package.loaded["ylm.vulkan_grid"]
  if there then there.forget(g) end
end

methods.__index = function(g, key)
  local method = rawget(methods, key)
  if method ~= nil or type(key) ~= "string" then return method end
  open(g, key)
  if key == "stats" then
    local stats = core.grid_stats(g)
    stats.stages = stages_of[g]
    return stats
  end
  return core.grid_form(g)[key]
end

methods.__newindex = function(_, key)
  return check.fail("grid: cannot set %s: only grid:update changes a grid", check.describe(key))
end

methods.__tostring = function(g)
  local is_open, updating = core.grid_is_open(g)
  if not is_open then return "ylm.grid (closed)" end
  if updating then return "ylm.grid (being updated)" end
  local f, s = core.grid_form(g), core.grid_stats(g)
  return ("ylm.grid %s lmax %d %s, %d points, %d leaves"):format(f.kind, f.lmax, f.channels == 3
    and "rgb" or "luminance",
    s.points, s.leaves)
end

-- What ylm.load uses -------------------------------------------------------------------

--- The first bytes of a grid file.
grid.magic = "\137YLMgrid"

--- A grid from a file: nil, message, code where it cannot be read.
function grid.load(path)
  return check.result("load", core.grid_read(path))
end

return grid
