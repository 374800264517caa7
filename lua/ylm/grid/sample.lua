--- Coefficients between a grid's points: grid:sample, and grid:to for a device's memory.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local engine = require "ylm.grid.engine"
local field = require "ylm.field"
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"

local methods, open, sampling = grid_object.methods, grid_object.open, grid_object.sampling

--- Normals and surfaces of a look-up in a grid with sides, in place of o.normals and o.scene. True, or nil, message, code.
local function settle_sides(g, o, points)
  if o.normals == nil and o.scene == nil then return true end
  if devices.of(o.device):name() then
    return check.bad(2, "sample", "device: it knows no sides: leave device, or normals and scene, out")
  end
  if not g.sides then
    return check.bad(2, "sample", "normals and scene are for a grid with sides, this one of %q light has none: leave them out",
      g.quantity)
  end
  if o.normals ~= nil then
    local unit, bad, code = check.result("sample", core.grid_unit((array.rows(2, "sample", "normals", o.normals, 3))))
    if not unit then return nil, bad, code end
    if bad then return check.bad(2, "sample", "normals: row %d is not finite", bad) end
    o.normals = unit
    if o.normals.shape[1] ~= points.shape[1] then
      return check.bad(2, "sample", "normals: one for each of %d points expected, got %d", points.shape[1], o.normals.shape[1])
    end
  end
  if o.scene ~= nil then
    local walls, message, code = field.walls_of_scene(2, "sample", o.scene)
    if not walls then return nil, message, code end
    o.walls = walls
  end
  return true
end

local sample_options = {
  sampling.interpolation, sampling.derivatives, sampling.outside, sampling.dtype,
  { "normals", "any", optional = true, about = "of a grid with sides (grid.sides): [n][3] of the surfaces that the points "
    .. "lie on, to the side that is seen. The look-up then is that side's" },
  { "scene", "any", optional = true, about = "of a grid with sides: the scene whose surfaces it knows, or a prepared view of it. "
    .. "A ray from each point then finds what the point sees; without it the pieces of the voxel tell, 1/4 of its edge wide" },
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
    { "flags", "array", "[n], with flags = true: 1 for a point outside, 2 for an unbaked one, 4 for one in a body (of a grid "
      .. "with sides), their sum, or 0" },
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
  local ok, message, code = settle_sides(g, o, p)
  if not ok then return nil, message, code end
  local shape = { p.shape[1], g.channels, (g.lmax + 1) ^ 2 }
  return device:sample(g, p, o, { shape, o.derivatives > 0 and { shape[1], shape[2], shape[3], 3 } or nil }, single)
end

local irradiance_options = {
  { "scene", "any", optional = true, about = "of a grid with sides, as of grid:sample: a ray from each point finds its side" },
  form.threads, form.progress,
}

describe "grid:irradiance" {
  shelf = "everyday",
  about = "The irradiance of surfaces by the grid's light, as pictures take it from there. Below 0 it is 0.",
  arguments = {
    { "points", "array|table", "[n][3], on surfaces, scene units" },
    { "normals", "array|table", "[n][3], of any length but 0, to the side that is seen" },
    { "options?", "table", "see the options" },
  },
  options = irradiance_options,
  returns = { { "E", "array", "float [n][channels], W m^-2" }, { "report", "table", "as of grid:sample" } },
  errors = "raises on bad arguments; nil, 'cancelled', 'ECANCELLED' where progress returns false",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 10 }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 4 }, lamp)
local E = grid:irradiance({ { 0, 0, 0 } }, { { 0, 1, 0 } })
assert(math.abs(E:get(1, 1) / (10 * math.pi * 0.1 ^ 2 / 2 ^ 2) - 1) < 0.05)]],
  source = "Ramamoorthi & Hanrahan 2001, Eqs. 11-13",
}
function methods.irradiance(g, points, normals, given)
  open(g, "irradiance")
  local o = form.options(3, "irradiance", irradiance_options, given)
  local p = array.rows(1, "irradiance", "points", points, 3)
  local n = array.rows(2, "irradiance", "normals", normals, 3)
  if #p ~= #n then return check.bad(2, "irradiance", "normals: one for each of %d points expected, got %d", #p, #n) end
  local c, report, code
  c, report, code = g:sample(p, { normals = g.sides and n or nil, scene = g.sides and o.scene or nil, threads = o.threads,
    progress = o.progress })
  if not c then return nil, report, code end
  local basis = engine.coefficients(g.lmax, 0).basis(n)
  return (c * basis:reshape { #p, 1, basis.shape[2] }):sum(3):clamp(0), code
end

local to_options = {
  { "packed", "boolean", optional = true, about = "whether a coefficient with its slopes is a word: 11 bits of the point's "
    .. "largest value, 7 bits of its largest slope each; a quarter of the memory. Default: the copy that there is, else not. "
    .. "copy.packed says what it errs by" },
}

describe "grid:to" {
  about = "Copies the grid's coefficients, gradients and cells to a device's memory, where grid:sample uses them by "
    .. "device = gpu. Where there is a copy, as after a bake with device = gpu, that is returned; after an update a new one.",
  arguments = { { "gpu", "gpu", "of ylm.vulkan.open" }, { "options", "table optional", "see below" } },
  options = to_options,
  returns = { { "copy", "gpu_grid", "or nil, message, code: 'ELIMIT' (more data than a kernel sees), 'EDOMAIN' (packed: light "
    .. "that is not finite), 'ENOMEM', 'EDEVICE'" } },
  errors = "raises where the grid or the device has been closed, and on bad options",
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
function methods.to(g, gpu, options)
  open(g, "to")
  local device = check.device(1, "to", gpu)
  return device:grid(g, form.options(2, "to", to_options, options))
end
