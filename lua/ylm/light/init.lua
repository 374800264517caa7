--- Lights and their light fields: ylm.sphere_light, ylm.sphere_lights, ylm.light_field.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local outputs = require "ylm.outputs"
local progress = require "ylm.progress"

local light = {}

-- Results that may be asked of a field; the numbers are those of ylm_base.h.
local VALUE, GRADIENT, HESSIAN, METRIC = 1, 2, 4, 8

local EXTENT = 1e15

light.sphere_light = form.define("sphere_light", {
  about = "A sphere that emits the same radiance everywhere and in every direction.",
  fields = {
    { "at", "point", unit = "scene units", about = "centre" },
    { "radius", "number", min = 0, max = EXTENT, default = 0.1, unit = "scene units",
      about = "a radius of 0 emits nothing" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2",
      about = "number or {r, g, b}, linear Rec. 709; may be negative" },
  },
  build = function(values, fail)
    for i = 1, 3 do
      if math.abs(values.at[i]) > EXTENT then return fail("at is too far out (the limit is 1e15)") end
    end
    return setmetatable(values, form.defined.sphere_light.metatable)
  end,
  example = "sphere_light { at = {0, 2, 0}, radius = 0.1, radiance = {10, 8, 6} }",
})

-- Fields of lights as arrays ------------------------------------------------------------

--- A field's value as a double array, and its shape, once that fits(shape); `wanted` says which do, for the message.
local function numbers(name, value, wanted, fits, fail)
  if check.is_number(value) then value = { value } end
  local shape, dtype, is_open, _
  if core.type(value) == "ylm.array" then
    shape, dtype, _, is_open = core.array_info(value)
    if not is_open then return fail(name .. ": the array has been closed") end
  elseif type(value) == "table" then
    shape = { #value, type(value[1]) == "table" and #value[1] or nil }
  end
  if not shape or not fits(shape) then
    local got = shape and "an array of " .. table.concat(shape, "x")
    return fail(("%s must be %s, got %s"):format(name, wanted, got or check.describe(value)))
  end
  if dtype then return dtype == "double" and value or core.array_convert(value, "double"), shape end
  form.take_numbers(shape, fail)
  local a = core.array_zeros(shape, "double")
  local ok, where = core.array_fill(a, value)
  if not ok then return fail(("%s must be %s; element %d does not fit"):format(name, wanted, where)) end
  return a, shape
end

local function build_lights(values, fail)
  local at, shape = numbers("at", values.at, "[n][3] numbers", function(s)
    return #s == 1 and s[1] == 0 or #s == 2 and s[2] == 3
  end, fail)
  local n = shape[1]
  form.take_numbers({ 4, n }, fail) -- besides `at`, whatever radius and radiance are
  local function one_each(s) return #s == 1 and (s[1] == 1 or s[1] == n) end
  local radius = numbers("radius", values.radius, ("a number or one for each of the %d lights"):format(n), one_each, fail)
  local radiance = numbers("radiance", values.radiance,
    ("a number, {r, g, b}, or one for each of the %d lights"):format(n), function(s)
      return one_each(s) or #s == 1 and s[1] == 3 or #s == 2 and s[1] == n and s[2] == 3
    end, fail)
  local packed, message, code = core.lights_create(at, radius, radiance)
  if not packed then
    if core.status(code) == "caller" then return fail(message) end
    return nil, message, code
  end
  return setmetatable({ lights = packed, count = n }, form.defined.sphere_lights.metatable)
end

light.sphere_lights = form.define("sphere_lights", {
  about = "Many sphere lights as one object, from arrays: fast to make and to use.",
  fields = {
    { "at", "any", unit = "scene units", about = "centres: an array or table [n][3]; empty: darkness" },
    { "radius", "any", default = 0.1, unit = "scene units", about = "[n] numbers, or one for all; 0 emits nothing" },
    { "radiance", "any", default = 1, unit = "W sr^-1 m^-2",
      about = "[n][3] linear Rec. 709 or [n], or a number or {r, g, b} for all; may be negative" },
  },
  build = build_lights,
  example = "sphere_lights { at = { {0, 2, 0}, {1, 2, 0} }, radius = { 0.1, 0.2 }, radiance = 10 }",
})

--- An object that light.pack made of spheres and others -> the spheres, the others.
local spheres_of, others_of = setmetatable({}, { __mode = "k" }), setmetatable({}, { __mode = "k" })

--- Centres, radii and radiances of no lights.
local function nothing()
  local function none(...) return core.array_zeros({ 0, ... }, "double") end
  return none(3), none(), none(3)
end

--- Centres [n][3], radii [n] and radiances [n][3] of the spheres in what light.pack returned, as new double arrays.
function light.arrays(packed)
  if core.type(packed) ~= "ylm.lights" then packed = spheres_of[packed] end
  if not packed then return nothing() end
  return check.result("lights", core.lights_arrays(packed))
end

--- An object that light.pack made -> the polygons, disks and textured lights in it.
local flat_of = setmetatable({}, { __mode = "k" })

--- Of the flat lights in what light.pack returned: corners of triangles [t][9], disks [d][7] (centre, radius, normal)
-- and radiances and horizons [t+d][6], as new double arrays, and a list of textures, see polygon.patches; nil where there
-- are none.
-- Images are covered by `tiles` (8) times as many tiles.
function light.patches(packed, tiles)
  local flat = flat_of[packed]
  if flat then return require("ylm.light.polygon").patches(flat, tiles or 8) end
end

--- light.arrays of the option `lamps` of the function `name`: of spheres, since flat lights are surfaces of a scene.
function light.lamps(name, lamps)
  local packed = light.pack(1, name, lamps)
  if flat_of[packed] then
    return check.bad(1, name, "lamps: sphere lights expected; flat lights are drawn with the scene that they are prepared in")
  end
  return light.arrays(packed)
end

-- Packing ----------------------------------------------------------------------------

--- Gathers lights in order: runs of single ones become one packed object each.
local function gather(n, name, value, parts, run, depth)
  local kind = form.kind(value)
  local function flush()
    if #run.at == 0 then return end
    local at = assert(core.array_zeros({ #run.at, 3 }, "double"))
    local radius = assert(core.array_zeros({ #run.at }, "double"))
    local radiance = assert(core.array_zeros({ #run.at, 3 }, "double"))
    core.array_fill(at, run.at)
    core.array_fill(radius, run.radius)
    core.array_fill(radiance, run.radiance)
    parts[#parts + 1] = assert(check.result(name, core.lights_create(at, radius, radiance)))
    run.at, run.radius, run.radiance = {}, {}, {}
  end
  if kind == "sphere_light" then
    local k = #run.at + 1
    run.at[k], run.radius[k], run.radiance[k] = value.at, value.radius, value.radiance
  elseif kind == "sphere_lights" then
    flush()
    parts[#parts + 1] = value.lights
  elseif kind == "ylm.lights" then
    if not core.lights_count(value) then return check.bad(n, name, "the lights have been closed") end
    flush()
    parts[#parts + 1] = value
  elseif kind == "polygon_light" or kind == "disk_light" then
    parts.flat = parts.flat or {}
    table.insert(parts.flat, value)
  elseif kind == "textured_light" then
    parts.others, parts.textured = parts.others or {}, parts.textured or {}
    table.insert(parts.others, value.field)
    table.insert(parts.textured, value)
  elseif core.has_field(value) and kind ~= "ylm.grid" then
    parts.others = parts.others or {}
    table.insert(parts.others, value)
  elseif type(value) == "table" and kind == nil and depth < 32 then
    for i = 1, #value do gather(n, name, value[i], parts, run, depth + 1) end
  elseif type(value) == "table" and kind == nil then
    return check.bad(n, name, "lists of lights nest more than 32 deep; does a list hold itself?")
  else
    return check.bad(n, name, "a light or a list of lights expected, got %s",
      kind and not core.type(value) and ("a " .. kind) or check.describe(value))
  end
  if depth == 0 then flush() end
end

--- Argument `n` of `name` as one object with a light field, "ylm.lights" if all are spheres: a light, a list of them
-- (nested fine), or a packed object. An empty list is darkness.
function light.pack(n, name, lights)
  local parts, run = {}, { at = {}, radius = {}, radiance = {} }
  gather(n, name, lights, parts, run, 0)
  local others, spheres, message, code = parts.others or {}
  if parts.flat then
    message, code = require("ylm.light.polygon").join(name, parts.flat, others)
    if message then return nil, message, code end
  end
  spheres = parts[1]
  if parts[2] then
    spheres, message, code = check.result(name, core.lights_join(parts))
    if not spheres then return nil, message, code end
  end
  local result = spheres or others[1]
  if not result then return check.result(name, core.lights_create(nothing())) end
  if others[spheres and 1 or 2] then
    local fields = { spheres }
    for _, other in ipairs(others) do fields[#fields + 1] = other end
    result, message, code = check.result(name, core.light_sum(fields))
    if not result then return nil, message, code end
    spheres_of[result], others_of[result] = spheres, others
  end
  if parts.flat or parts.textured then
    local flat = {}
    for _, list in ipairs { parts.flat or {}, parts.textured or {} } do
      for _, l in ipairs(list) do flat[#flat + 1] = l end
    end
    flat_of[result] = flat
  end
  return result
end

--- The words for a light field that is not of spheres alone.
function light.other(object)
  local kinds, seen = {}, {}
  for _, l in ipairs(flat_of[object] or {}) do
    local kind = form.kind(l)
    if not seen[kind] then kinds[#kinds + 1] = kind end
    seen[kind] = true
  end
  return kinds[1] and "a " .. table.concat(kinds, ", a ") or type(object) == "function" and "a function"
    or "another light field"
end

--- Argument `n` of `name` as an open object with a light field: such an object itself, or lights packed.
function light.field(n, name, value)
  local fault = check.grid_fault(value)
  if fault then return check.bad(n, name, fault) end
  if not devices.of(value):is_open(value) then
    return check.bad(n, name, "the lights have been closed")
  end
  if core.has_field(value) and core.type(value) ~= "ylm.lights" then return value end
  return light.pack(n, name, value)
end

--- A packed object as sphere lights (or nil) and a list of other objects with a light field.
function light.parts(packed)
  if core.type(packed) == "ylm.lights" then return packed, {} end
  if others_of[packed] then return spheres_of[packed], others_of[packed] end
  return nil, { packed }
end

--- A packed object as a dynamic grid follows it: { sphere lights or false, flat lights, ... }; nil where there
-- is anything else in it.
function light.followed(packed)
  local spheres, others = light.parts(packed)
  local list = { spheres or false }
  for i, other in ipairs(others) do
    if core.type(other) ~= "ylm.polygons" then return nil end
    list[i + 1] = other
  end
  return list
end

-- To a tolerance ------------------------------------------------------------------------

--- The option that says how exactly lights are summed, by the name it has here.
function light.tolerance_option(name)
  return { name, "number", min = 1e-6, max = 0.5, optional = true,
    about = "relative error at 99.9 % of points (of derivatives: relative to theirs) when many sphere lights are summed by a "
      .. "tree; default: exact sums. Ignored on a device, which always sums exactly" }
end

--- A packed object to a tolerance (nil: as it is). Its sphere lights are summed by a tree, which they keep; others as
-- ever, those of a device too: it sums all lights, which is within any tolerance.
function light.within(name, object, tolerance, threads)
  if not tolerance then return object end
  if core.type(object) == "ylm.lights" then
    return check.result(name, core.light_cut(object, tolerance, threads or 0))
  end
  if not spheres_of[object] then return object end
  local cut, message, code = check.result(name, core.light_cut(spheres_of[object], tolerance, threads or 0))
  if not cut then return nil, message, code end
  local parts = { cut }
  for i, other in ipairs(others_of[object]) do parts[i + 1] = other end
  return check.result(name, core.light_sum(parts))
end

-- ylm.light_field ------------------------------------------------------------------------

--- Options of light.evaluate and ylm.light_field.
local options = {
  { "derivatives", "integer", min = 0, max = 2, default = 0, about = "0 coefficients, 1 and gradients, 2 and Hessians" },
  { "channels", "choice", of = { "rgb", "luminance" }, default = "rgb", about = "three linear channels, or one" },
  { "metric", "choice", of = { "luminance", "rgb" }, optional = true,
    about = "also report.lambda (norm of the Hessians' largest eigenvalues) and report.norm, of these channels; they end "
      .. "at the largest number of their type" },
  { "dtype", "choice", of = { "float", "double" }, optional = true,
    about = "element type; that of the points where they are an array, else float" },
  light.tolerance_option "tolerance",
  { "threads", "integer", min = 1, max = 1024, optional = true, about = "default: YLM_THREADS or all cores" },
  { "out", "any", optional = true, about = "an array, or a list of them, shaped and typed like the results, which they take" },
  { "progress", "progress", optional = true, about = "called as f(done, total, stage); returning false cancels" },
  { "device", "gpu", optional = true, about = "lights are summed there; gpu:lights copies them once" },
  { "method", "choice", of = { "merged", "forward", "reversed" }, optional = true,
    about = "on a device: merged moments (default), or the papers' product rule for comparison, see gpu:lights" },
}

--- The field of any object that has one (lights, grids) at points [n][3]: what ylm.light_field does.
-- `given` is what the points were made from, with which `out` may share no memory either. `isa` names a kernel set, for
-- specs and benchmarks.
function light.evaluate(name, lmax, object, points, o, isa, given)
  local want = VALUE + (o.derivatives >= 1 and GRADIENT or 0) + (o.derivatives >= 2 and HESSIAN or 0)
    + (o.metric and METRIC or 0)
  local channels, metric_channels = o.channels == "rgb" and 3 or 1, o.metric == "rgb" and 3 or 1
  local shapes = {}
  for i = 0, o.derivatives do shapes[i + 1] = { #points, channels, (lmax + 1) ^ 2, i > 0 and 3 * i or nil } end
  local out1, out2, out3 = outputs.of(4, name, o.out, points.dtype, shapes, given or points)
  local L, dL, ddL, lambda, norm, inside, pairs = devices.of(object):evaluate(name, object, lmax, points, channels, want,
    metric_channels, o.threads or 0, progress.of(o.progress), out1, out2, out3, isa)
  if L == nil then return nil, dL, ddL end
  return L, dL, ddL, { lambda = lambda, norm = norm, inside = inside, pairs = pairs }
end

describe "light_field" {
  about = "The sum of all lights at points: coefficients, gradients and Hessians with respect to the point.",
  arguments = {
    { "lmax", "integer", "highest degree, 0 to 100" },
    { "lights", "light|list", "a light, a list of lights (an empty one: darkness), or what has a light field" },
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "options?", "table", "see the options" },
  },
  options = options,
  returns = {
    { "L", "array", "[n][channels][(lmax+1)^2], W m^-2 sr^-1/2" },
    { "dL", "array", "[n][channels][(lmax+1)^2][3], or nil" },
    { "ddL", "array", "[n][channels][(lmax+1)^2][6], or nil: xx xy xz yy yz zz" },
    { "report", "table", "inside [n]: 1 in or on a light, else 0; pairs: evaluations; with metric lambda, norm [n]" },
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
  check.integer(1, "light_field", "lmax", lmax, 0, 100)
  local o = form.options(4, "light_field", options, given)
  local object, made, code = light.field(2, "light_field", lights)
  if not object then return nil, made, code end
  object, made, code = devices.of(o.device):lights(4, "light_field", object, o, light.within)
  if not object then return nil, made, code end
  local dtype = o.dtype
  if not dtype then dtype = core.type(points) == "ylm.array" and points.dtype or "float" end
  local p, single = array.points(3, "light_field", points, dtype)
  local L, dL, ddL, report = light.evaluate("light_field", lmax, object, p, o, nil, points)
  if made then object:close() end
  if L == nil or not single then return L, dL, ddL, report end
  return L[1], dL and dL[1], ddL and ddL[1], report
end

return light
