--- Coefficients between a grid's points: grid:sample, and grid:to for a device's memory.

local check = require "ylm.check"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"

local methods, open, sampling = grid_object.methods, grid_object.open, grid_object.sampling

local sample_options = {
  sampling.interpolation, sampling.derivatives, sampling.outside, sampling.dtype,
  { "flags", "boolean", default = false, about = "also which points were outside or unbaked; not with device" },
  form.threads,
  { "device", "gpu", optional = true,
    about = "interpolates there, in float, with the copy of grid:to(gpu), made where there is none; new results are where "
      .. "the points are; report.stages" },
  { "out", "any", optional = true, about = "an array, or a list of them, shaped and typed like the results, which they take; "
    .. "with device also in its memory" },
  form.progress,
}

describe "grid:sample" {
  shelf = "everyday",
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
    { "flags", "array", "[n], with flags = true: 1 for a point outside, 2 for an unbaked one, 3 for both, else 0" },
  },
  errors = "raises on bad arguments; nil, 'cancelled', 'ECANCELLED' where progress returns false",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1 }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 2 }, lamp)
local c, dc, report = grid:sample({ { 0, 0, 0 }, { 5, 0, 0 } }, { derivatives = 1 })
assert(c.shape[3] == 9 and dc.shape[4] == 3 and report.outside == 1)
local _, _, _, flags = grid:sample({ { 0, 0, 0 }, { 5, 0, 0 } }, { flags = true })
assert(flags[1] == 0 and flags[2] == 1)]],
}
function methods.sample(g, points, given)
  open(g, "sample")
  local o = form.options(2, "sample", sample_options, given)
  local device = devices.of(o.device)
  local p, single = device:points(1, "sample", "points", points)
  if not p then
    return check.bad(2, "sample", "device: points are in a device's memory: name the device, or download them")
  end
  local shape = { p.shape[1], g.channels, (g.lmax + 1) ^ 2 }
  return device:sample(g, p, o, { shape, o.derivatives > 0 and { shape[1], shape[2], shape[3], 3 } or nil }, single)
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
  open(g, "to")
  return check.device(1, "to", gpu):grid(g)
end
