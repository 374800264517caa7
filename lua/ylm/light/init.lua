--- Light fields: ylm.light_field. Lights themselves are in the files that lua/ylm/light/kinds.lua lists.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local outputs = require "ylm.outputs"
local progress = require "ylm.progress"
local show = require "ylm.show"

local light = {}

for name, f in pairs(require "ylm.light.pack") do light[name] = f end

-- To a tolerance ------------------------------------------------------------------------

--- The option that says how exactly lights are summed, by the name it has here.
function light.tolerance_option(name)
  return { name, "number", min = core.limits.tolerance_least, max = core.limits.tolerance_most, optional = true,
    about = "relative error at 99.9 % of points (of derivatives: relative to theirs) when many spheres or virtual lights are "
      .. "summed by trees; default: exact sums. Ignored on a device, which always sums exactly. Virtual lights miss 0.001 and "
      .. "gradients in rooms of many small parts: docs/virtual.md, 'Many'" }
end

--- A packed object to a tolerance (nil: as it is): its sphere lights and its virtual lights are summed by trees, which they keep;
-- all others as ever, those of a device too: it sums all lights, which is within any tolerance.
function light.within(name, object, tolerance, threads)
  if not tolerance or core.type(object) ~= "ylm.lights" then return object end
  if not select(4, core.lights_count(object)) then return object end
  local cut, message, code = check.result(name, core.light_cut(object, tolerance, threads or 0))
  if cut then core.own(cut).parts = light.parts(object) end
  return cut, message, code
end

--- Sentences about what sums of virtual lights within a tolerance keep, or nil: all is kept. The figures are those of
-- docs/virtual.md, "Many". Exact sums have a pair for each light and point.
local function kept(object, o, points, pairs_summed)
  if not o.tolerance or o.device or core.type(object) ~= "ylm.lights" then return nil end
  local count, _, _, _, has_virtual = core.lights_count(object)
  if not has_virtual or core.lights_tree_bytes(object) == 0 or pairs_summed >= points * count then return nil end
  local list = {}
  if o.tolerance < 0.01 then
    list[#list + 1] = ("values of 10^5 and more virtual lights miss the tolerance %g: of 10^5 by at most 3.5 times at 99.9 %% of "
      .. "points, of 10^6 at 8 to 19 %% of points, by at most 5 times"):format(o.tolerance)
  end
  if o.derivatives > 0 then
    list[#list + 1] = ("derivatives of virtual lights in rooms of many small parts are within %g at 92 to 99 %% of points, and "
      .. "within %.2g at 99.9 %%; with a light a thousand times as strong as the others, within %.2g. Without a tolerance sums "
      .. "are exact"):format(o.tolerance, 8.1 * o.tolerance, 53 * o.tolerance)
  end
  return #list > 0 and list or nil
end

-- ylm.light_field ------------------------------------------------------------------------

--- Options of light.evaluate and ylm.light_field.
local options = {
  { "derivatives", "integer", min = 0, max = 2, default = 0, about = "0 coefficients, 1 and gradients, 2 and Hessians" },
  { "channels", "choice", of = core.choices("channels", "rgb"), default = "rgb", about = "three linear channels, or one" },
  { "metric", "choice", of = core.choices "channels", optional = true,
    about = "also report.lambda (norm of the Hessians' largest eigenvalues) and report.norm, of these channels; they end "
      .. "at the largest number of their type" },
  { "dtype", "choice", of = core.choices "dtype", optional = true,
    about = "element type; that of the points where they are an array, else float" },
  light.tolerance_option "tolerance",
  form.threads,
  { "out", "any", optional = true, about = "an array, or a list of them, shaped and typed like the results, which they take" },
  form.progress,
  { "device", "gpu", optional = true, about = "lights are summed there; gpu:lights copies them once" },
  { "method", "choice", shelf = "comparison", of = core.choices "sums", optional = true,
    about = "on a device: merged moments (default), or the papers' product rule for comparison, see gpu:lights" },
}

--- The field of any object that has one (lights, grids) at points [n][3]: what ylm.light_field does.
-- `given` is what the points were made from, with which `out` may share no memory either. `isa` names a kernel set, for
-- specs and benchmarks, and `rough` has the metric as bakes to a tolerance want it. With `narrow` points are of double, and
-- results of float.
function light.evaluate(name, lmax, object, points, o, isa, given, narrow)
  local channels, shapes = o.channels == "rgb" and 3 or 1, {}
  for i = 0, o.derivatives do shapes[i + 1] = { #points, channels, (lmax + 1) ^ 2, i > 0 and 3 * i or nil } end
  local dtype = narrow and "float" or points.dtype
  local out1, out2, out3 = outputs.of(4, name, o.out, dtype, shapes, given or points)
  local L, dL, ddL, lambda, norm, inside, pairs = devices.of(object):evaluate(name, object, points, {
    lmax = lmax, channels = o.channels, derivatives = o.derivatives, metric = o.metric, threads = o.threads,
    progress = progress.of(o.progress), value = out1, gradient = out2, hessian = out3, isa = isa,
    rough = o.rough, narrow = narrow })
  if L == nil then return nil, dL, ddL end
  local warnings = light.heed(object, lmax)
  return L, dL, ddL, { lambda = lambda, norm = norm, inside = inside, pairs = pairs,
    warnings = #warnings > 0 and warnings or nil }
end

--- Calls f(object, metatable) for a light field that is an object, or for those that a set of lights holds.
local function each_field(object, f)
  local meta = core.type(object) and core.type(object) ~= "ylm.array" and getmetatable(object)
  if meta then f(object, meta) end
  for _, part in ipairs(light.parts(object) or {}) do each_field(part, f) end
end

--- Sentences about what a light field does not keep at a degree, said once.
function light.heed(object, lmax)
  local list = {}
  each_field(object, function(field, meta)
    for _, sentence in ipairs(meta.__heed and meta.__heed(field, lmax) or {}) do list[#list + 1] = sentence end
  end)
  return list
end

--- A light field that has the metric of bakes: a list of lights with light behind bodies in it has one as one such light. Or
-- nil, message, code.
function light.joined(object)
  for _, part in ipairs(light.parts(object) or {}) do
    local join = getmetatable(part).__join
    if join then return join(object) end
  end
  return object
end

--- A function that tells what light fields behind bodies have multiplied since now, as shadowed.stats; nil: there are none.
function light.tally(...)
  local first, list = {}, {}
  for i = 1, select("#", ...) do
    each_field((select(i, ...)), function(field, meta)
      local of = meta.__counted and meta.__counted(field)
      if of and not first[of] then first[of], list[#list + 1] = core.shadowed_look(of), of end
    end)
  end
  return function()
    local sum
    for _, of in ipairs(list) do
      for name, value in pairs(core.shadowed_look(of) or {}) do
        sum = sum or { points = 0, casters = 0, products = 0, factors = 0, seconds = 0 }
        sum[name] = sum[name] + value - first[of][name]
      end
    end
    return sum
  end
end

describe "light_field" {
  shelf = "everyday",
  about = "The sum of all lights at points: coefficients, gradients and Hessians with respect to the point.",
  arguments = {
    { "lmax", "integer", "highest degree, 0 to 100" },
    { "lights", "light|list", "a light, a list of lights (an empty one is darkness, and said), or what has a light field" },
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "options?", "table", "see the options" },
  },
  options = options,
  returns = {
    { "L", "array", "[n][channels][(lmax+1)^2], W m^-2 sr^-1/2" },
    { "dL", "array", "[n][channels][(lmax+1)^2][3], or nil" },
    { "ddL", "array", "[n][channels][(lmax+1)^2][6], or nil: xx xy xz yy yz zz" },
    { "report", "table", "inside [n]: 1 in or on a light, else 0; pairs: evaluations; with metric lambda, norm [n]; "
      .. "warnings: what is not kept, or nil; kept: sentences about what sums of virtual lights within a tolerance keep, where "
      .. "that is less than the tolerance says, or nil" },
  },
  errors = "raises on bad arguments, and where a result is beyond the range of its type, naming the point (radiance 1e300 in "
    .. "float); nil, 'cancelled', 'ECANCELLED' where progress returns false; nil, message, code where a device fails",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = { 10, 8, 6 } }
local L, dL = ylm.light_field(4, lamp, { { 0, 0, 0 }, { 1, 0, 0 } }, { derivatives = 1 })
assert(#L == 2 and L.shape[2] == 3 and L.shape[3] == 25 and dL.shape[4] == 3)]],
  source = "Iwasaki & Dobashi 2025, Eqs. 2-8, 15-20",
}
function light.light_field(lmax, lights, points, given)
  check.integer(1, "light_field", "lmax", lmax, 0, core.limits.lmax)
  local o = form.options(4, "light_field", options, given)
  local object, made, code = light.field(2, "light_field", lights)
  if not object then return nil, made, code end
  local whole = object
  object, made, code = devices.of(o.device):lights(4, "light_field", object, o, light.within)
  if not object then return nil, made, code end
  local dtype = o.dtype
  if not dtype then dtype = array.type_of(points, "float") end
  local p, single = array.points(3, "light_field", points, dtype)
  local narrow = dtype == "float" and array.type_of(points) ~= "float" and devices.of(object).narrows and core.points_far(p)
  if narrow then p = array.points(3, "light_field", points, "double") end
  local L, dL, ddL, report = light.evaluate("light_field", lmax, object, p, o, nil, points, narrow)
  if report then report.kept = kept(whole, o, #p, report.pairs) end
  if made then object:close() end
  show.report(report)
  if L == nil or not single then return L, dL, ddL, report end
  return L[1], dL and dL[1], ddL and ddL[1], report
end

return light
