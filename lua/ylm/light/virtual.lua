--- Virtual lights: ylm.virtual_lights.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local numbers = require "ylm.light.numbers"

local virtual = {}

local DEGREE = 8

--- A set of virtual lights as an object.
function virtual.wrap(lights)
  local values = core.lights_virtual_info(lights)
  values.lights = lights
  return setmetatable(values, form.defined.virtual_lights.metatable)
end

-- Fields ---------------------------------------------------------------------------------

--- A field of one number or n as a double array.
local function each(name, value, n, fail)
  if value == nil then return nil end
  return (numbers(name, value, ("a number, or one for each of the %d lights"):format(n), function(s)
    return #s == 1 and (s[1] == 1 or s[1] == n)
  end, fail))
end

local function rows_of(name, value, wanted, n, fail)
  return numbers(name, value, wanted, function(s)
    return #s == 2 and s[2] == 3 and s[1] == n or n == 0 and #s == 1 and s[1] == 0
  end, fail)
end

local function intensity(value, n, fail)
  return (numbers("intensity", value, ("a number, {r, g, b}, or one for each of the %d lights"):format(n), function(s)
    return #s == 1 and (s[1] == 1 or s[1] == 3 or s[1] == n) or #s == 2 and s[1] == n and s[2] == 3
  end, fail))
end

--- The degree of emissions of this shape, or nil.
local function degree_of(shape, n)
  if #shape ~= 3 or shape[1] ~= n or shape[2] ~= 3 then return nil end
  for k = 0, DEGREE do if shape[3] == (k + 1) ^ 2 then return k end end
end

local function emission(value, n, fail)
  local a, shape = numbers("emission", value, ("[%d][3][(degree+1)^2] numbers, degree 0 to %d"):format(n, DEGREE),
    function(s) return degree_of(s, n) end, fail)
  local convention = select(3, core.array_info(a))
  if convention ~= 0 then a = require "ylm.sh.convert".convert(a, "ylm") end
  return a, degree_of(shape, n)
end

local function build(values, fail)
  if (values.intensity == nil) == (values.emission == nil) then
    return fail("give one of intensity and emission" .. (values.emission ~= nil and ", not both" or ""))
  end
  if values.radius == nil and values.profile ~= "point" then
    return fail(("field 'radius' is missing: profile '%s' has one; profile = 'point' has none"):format(values.profile))
  end
  local at, shape = numbers("at", values.at, "[n][3] numbers", function(s)
    return #s == 1 and s[1] == 0 or #s == 2 and s[2] == 3
  end, fail)
  local n = shape[1]
  if form.budget then form.budget("virtual_lights", n, fail) end
  form.take_numbers({ 5, n }, fail) -- besides the arrays that are given
  local normal = values.normal ~= nil
    and rows_of("normal", values.normal, ("[%d][3] numbers, one for each light"):format(n), n, fail) or nil
  local sent, degree
  if values.emission ~= nil then
    sent, degree = emission(values.emission, n, fail)
  else
    sent = intensity(values.intensity, n, fail)
  end
  local lights, message, code = core.lights_virtual(at, normal, each("radius", values.radius, n, fail),
    each("shift", values.shift, n, fail), degree, sent, values.profile)
  if lights then return virtual.wrap(lights) end
  if core.status(code) == "caller" then return fail(message) end
  return check.result("virtual_lights", nil, message, code)
end

-- Methods --------------------------------------------------------------------------------

local methods = {}

local function open(l, name)
  if form.kind(l) ~= "virtual_lights" then
    return check.fail("%s: virtual lights expected before the colon, got %s", name, check.describe(l))
  end
  return l
end

describe "virtual_lights:arrays" {
  about = "Returns the arrays that the lights are made of, for scripts and files.",
  arguments = {},
  returns = {
    { "at", "array", "[n][3], scene units" },
    { "normal", "array", "[n][3], of length 1; 0: emits all around" },
    { "radius", "array", "[n], scene units" },
    { "emission", "array", "[n][3][(degree+1)^2], W sr^-1, without the cosine, in world axes" },
    { "shift", "array", "[n]" },
  },
  errors = "nil, message, 'ENOMEM' where memory runs out",
  example = [[
local lights = ylm.virtual_lights { at = { { 0, 0, 0 } }, normal = { { 0, 0, 1 } }, radius = 0.2, intensity = 3 }
local at, normal, radius, emission = lights:arrays()
assert(#at == 1 and normal:get(1, 3) == 1 and radius:get(1) == 0.2)
assert(math.abs(emission:get(1, 1, 1) - 3 * math.sqrt(4 * math.pi)) < 1e-12)]],
}
function methods:arrays()
  open(self, "arrays")
  return check.result("arrays", core.lights_virtual_arrays(self.lights))
end

--- Types of options: a number above 0, or "auto".
function form.types.core(x)
  if x == "auto" or check.is_number(x) and x > 0 then return x end
  return nil, "a number > 0, or 'auto'"
end

local POINTS = 1000000 -- shading points of a picture
-- Cost of the far parts of n lights at a grid point, as pairs of a near light and a shading point: this times n.
local EVALUATION = 0.3

--- The core of far and near parts in spacings of n lights, 2 to 12, so that in a picture both cost about the same. `share`: the
-- part of surfaces that lights lie on; a grid covers all of them.
function virtual.spacings(count, points, share)
  return math.max(2, math.min(12, (2 * EVALUATION * count ^ 2 / (points * (share or 1))) ^ 0.25))
end

--- The distance of lights from the next ones, and their share of an area (nil: of all). A spacing follows from radii: lights that
-- particles left have radii of 1.5/sqrt(pi) spacings (scale = 1.5). The spacing is at most
-- sqrt(area/count), if all of the area is lit.
function virtual.spacing(l, area)
  local spacing = l.radius.mean * math.sqrt(math.pi) / 1.5
  if not area then return spacing, 1 end
  return math.min(spacing, math.sqrt(area / l.count)), math.min(1, math.max(1e-3, l.count * spacing ^ 2 / area))
end

--- The core that is chosen.
local function auto_core(l, area, points)
  if l.count == 0 then return 1 end
  local spacing, share = virtual.spacing(l, area)
  return math.max(virtual.spacings(l.count, points, share) * spacing, 1.01 * l.radius.max)
end

--- The area of a scene's surfaces; nil where it has none.
function virtual.area_of(s)
  if form.kind(s) ~= "scene" then
    return check.bad(1, "split", "scene: a scene expected, got %s", check.describe(s))
  end
  local area = 0
  for _, g in ipairs(s.geometry) do area = area + g.mesh.area end
  return area > 0 and area or nil
end

local split_options = {
  { "core", "core", default = "auto", unit = "scene units",
    about = "how far a light is near: above the largest radius (below two of them far is hardly smoother than the whole), some "
      .. "3 spacings of the lights; 'auto': 2 to 12 spacings by the numbers of lights and points" },
  { "scene", "any", optional = true,
    about = "of 'auto': the scene whose surfaces the lights lie on; a spacing, which the mean radius says, is at most that of "
      .. "lights all over their area" },
  { "points", "integer", min = 1, max = 2 ^ 53, default = POINTS, about = "of 'auto': shading points of a picture" },
}

describe "virtual_lights:split" {
  about = "Two sets of lights whose sum these lights are: a far part that is smooth on the scale of `core`, which is baked, "
    .. "and a near part that ends at 1.6 cores, which is summed where it is needed. Lights of profile gauss. The power of the "
    .. "whole is far's: from afar near sends none.",
  arguments = { { "options?", "table", "core, scene, points" } },
  options = split_options,
  returns = { { "far", "virtual_lights", "" }, { "near", "virtual_lights", "" } },
  errors = "raises on lights of another profile and on a core that is too small; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local lights = ylm.virtual_lights { at = { { 0, 0, 0 } }, radius = 0.2, intensity = 3 }
local far, near = lights:split { core = 1 }
assert(far.core == 1 and near.profile == "near")]],
}
function methods:split(given)
  open(self, "split")
  local o = form.options(1, "split", split_options, given)
  if self.profile ~= "gauss" then
    return check.fail("split: lights of profile 'gauss' are split, and these are '%s'", self.profile)
  end
  if o.core ~= "auto" and (o.scene ~= nil or given.points ~= nil) then
    return check.bad(1, "split", "%s is of core = 'auto', core is %g: leave one out", o.scene ~= nil and "scene" or "points",
      o.core)
  end
  local area = o.scene ~= nil and virtual.area_of(o.scene) or nil
  local size = o.core == "auto" and auto_core(self, area, o.points) or o.core
  local far, near, code = core.lights_virtual_split(self.lights, size)
  if far then return virtual.wrap(far), virtual.wrap(near) end
  return check.result("split", nil, near, code)
end

local near_options = {
  { "lmax", "integer", min = 0, max = core.limits.lmax, default = 4, about = "of the clamped cosine" },
  form.threads,
}

describe "virtual_lights:irradiance" {
  about = "Irradiance by the near parts of lights (lights:split) at points with normals: what sampling a grid of the far "
    .. "parts lacks. Lights beyond 1.6 cores count as nothing.",
  arguments = {
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "normals", "array|table", "as many, of length 1" },
    { "options?", "table", "see the options" },
  },
  options = near_options,
  returns = { { "E", "array", "float [n][3], W m^-2, linear Rec. 709; of one point [3]" } },
  errors = "raises on lights of another profile and on points that are not finite; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local lights = ylm.virtual_lights { at = { { 0, 0, 1 } }, normal = { { 0, 0, -1 } }, radius = 0.2, intensity = 3 }
local far, near = lights:split { core = 1 }
local E = near:irradiance({ { 0, 0, 0.5 } }, { { 0, 0, 1 } })
assert(E:get(1, 1) > 0)]],
}
function methods:irradiance(points, normals, given)
  open(self, "irradiance")
  local o = form.options(3, "irradiance", near_options, given)
  if self.profile ~= "near" then
    return check.fail("irradiance: the near part of split lights is gathered, and these are '%s'", self.profile)
  end
  local p, single = array.points(1, "irradiance", points, "float")
  local n = array.points(2, "irradiance", normals, "float", "normals")
  if #n ~= #p then return check.bad(2, "irradiance", "one normal for each of %d points expected, got %d", #p, #n) end
  local out, message, code = core.array_zeros({ #p, 3 }, "float")
  if out then
    local good
    good, message, code = core.lights_virtual_near(self.lights, o.lmax, p, n, o.threads or 0, out)
    out = good and out
  end
  if not out then return check.result("irradiance", nil, message, code) end
  return single and out[1] or out
end

describe "virtual_lights:near_field" {
  about = "Coefficients of the near parts of lights (lights:split) at points, which are added to those that a grid of the far "
    .. "parts has. Lights beyond 1.6 cores count as nothing.",
  arguments = {
    { "lmax", "integer", "highest degree, 0 to 100" },
    { "points", "array|table", "[n][3], scene units" },
    { "options?", "table", "threads" },
  },
  options = { form.threads },
  returns = { { "L", "array", "float [n][3][(lmax+1)^2], W m^-2 sr^-1/2" } },
  errors = "raises on lights of another profile and on points that are not finite; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local lights = ylm.virtual_lights { at = { { 0, 0, 1 } }, normal = { { 0, 0, -1 } }, radius = 0.2, intensity = 3 }
local far, near = lights:split { core = 1 }
assert(near:near_field(2, { { 0, 0, 0.5 } }):get(1, 1, 1) > 0)]],
}
function methods:near_field(lmax, points, given)
  open(self, "near_field")
  check.integer(1, "near_field", "lmax", lmax, 0, core.limits.lmax)
  local o = form.options(3, "near_field", { form.threads }, given)
  if self.profile ~= "near" then
    return check.fail("near_field: the near part of split lights is gathered, and these are '%s'", self.profile)
  end
  local p = array.points(2, "near_field", points, "float")
  local out, message, code = core.array_zeros({ #p, 3, (lmax + 1) ^ 2 }, "float")
  if out then
    local good
    good, message, code = core.lights_virtual_near(self.lights, lmax, p, nil, o.threads or 0, out)
    out = good and out
  end
  return check.result("near_field", out or nil, message, code)
end

describe "virtual_lights:visible" {
  about = "These lights with the shadows of a scene's surfaces, as a light field: a ray goes from each point to the middle of "
    .. "each light that faces it. ylm.light_field and ylm.bake take it. Derivatives are those of the lights that a point "
    .. "sees; a shadow's edge is a step between points, which adaptive grids find by their tolerance.",
  arguments = { { "scene", "scene", "its geometry, as it is now; its lights do not count" } },
  returns = { { "field", "visible", "its grids hold light of quantity 'indirect': view:render { bounced = grid }" } },
  errors = "raises on what is no scene, and on near parts; nil, message, code: memory, 'EMISSING' without the library that "
    .. "traces rays",
  example = [[
local scene = ylm.scene "a wall" { geometry = ylm.quad { corner = { -1, -1, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } } }
local lights = ylm.virtual_lights { at = { { 0, 0, 1 } }, radius = 0.2, intensity = 3 }
local L = ylm.light_field(2, lights:visible(scene), { { 0, 0, 2 }, { 0, 0, -2 } })
assert(L:get(1, 1, 1) > 0 and L:get(2, 1, 1) == 0)]],
  source = "Mezieres & Paulin 2022, Sec. 5.1",
}
--- A scene is there only where lua/ylm/scene/init.lua has been loaded, which loads what makes the field.
function methods:visible(scene)
  open(self, "visible")
  if form.kind(scene) ~= "scene" then return check.bad(1, "visible", "a scene expected, got %s", check.describe(scene)) end
  return virtual.with_shadows(self, scene)
end

virtual.virtual_lights = form.define("virtual_lights", {
  numbers = 256,
  about = "Many small lights that send different light in different directions, as surfaces do that reflect. They are a "
    .. "light field: they have no body, so rays do not see them, and nothing shadows them. Each sends its intensity times "
    .. "max(0, shift + normal . direction). They have count, degree, profile and power {r, g, b}, the flux in W.",
  fields = {
    { "at", "any", unit = "scene units", about = "[n][3], places; empty: darkness" },
    { "normal", "any", optional = true, about = "[n][3] of length 1, or 0 for light all around; without it all are such" },
    { "radius", "any", optional = true, unit = "scene units",
      about = "[n] numbers, or one for all: within it a light is soft; 'point' has none" },
    { "intensity", "any", optional = true, unit = "W sr^-1",
      about = "[n][3] linear Rec. 709 or [n], or a number or {r, g, b} for all (so three numbers for three lights are a colour), "
        .. "along the normal; may be negative" },
    { "emission", "any", optional = true, unit = "W sr^-1",
      about = "[n][3][(degree+1)^2] instead of intensity: its coefficients, degree 0 to 8, in world axes, without the cosine" },
    { "profile", "choice", of = { "gauss", "cap", "point" }, default = "gauss",
      about = "how light falls off: smooth everywhere; as a sphere light outside of its radius; as 1/distance^2" },
    { "shift", "any", default = 0, about = "[n] numbers or one, 0 to 1: of lights that stand for surfaces of several normals" },
  },
  build = build,
  light = { moved = false },
  metatable = { __index = memory.publish(methods), __tostring = function(l)
    return ("%d virtual lights of degree %d, profile %s"):format(l.count, l.degree, l.profile)
  end },
  example = [[
local lights = ylm.virtual_lights { at = { { 0, 0, 0 }, { 1, 0, 0 } }, normal = { { 0, 0, 1 }, { 0, 0, 1 } },
  radius = 0.2, intensity = { 3, 2, 1 } }
assert(lights.count == 2 and math.abs(lights.power[1] - 6 * math.pi) < 1e-12)
local L = ylm.light_field(4, lights, { { 0, 0, 1 } })
assert(L:get(1, 1, 1) > 0)]],
  source = "Mezieres & Paulin 2022, Secs. 3 and 5",
})

return virtual
