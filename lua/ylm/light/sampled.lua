--- Light that is known at a few places: ylm.sampled_light.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"
local lmax_of = require "ylm.sh.args".lmax_of

local sampled = {}

local MOST, DEGREE = core.limits.light_places, 4

--- The places as a double array [n][3]; fails with what is wrong.
local function places_of(values, fail)
  local at = array.points(1, "sampled_light", values.at, "double")
  if #at < 1 or #at > MOST then return fail(("at: 1 to %d places expected, got %d"):format(MOST, #at)) end
  return at
end

--- Coefficients that are given, as a double array [n][3][(lmax+1)^2], and lmax; fails with what is wrong.
local function given(values, n, fail)
  local c = array.rows(1, "sampled_light", "coefficients", values.coefficients, nil, "double")
  local shape, _, convention = core.array_info(c)
  local lmax = lmax_of(shape[#shape])
  if #shape < 2 or #shape > 3 or shape[1] ~= n or #shape == 3 and shape[2] ~= 3 or not lmax or lmax > core.limits.lmax then
    return fail(("coefficients must be [%d][(lmax+1)^2] or [%d][3][(lmax+1)^2], lmax at most %d, got %s"):format(n, n,
      core.limits.lmax, table.concat(shape, "x")))
  end
  if convention ~= 0 then c = require "ylm.sh.convert".convert(c, "ylm") end
  if #shape == 3 then return c, lmax end
  local rows = core.array_totable(c)
  for i, row in ipairs(rows) do rows[i] = { row, row, row } end
  local wide, message, code = core.array_zeros({ n, 3, shape[2] }, "double")
  if not wide then return nil, message, code end
  core.array_fill(wide, rows)
  return wide, lmax
end

--- The coefficients of lights, or of any light field, at the places; their lmax. Or nil, message, code.
local function evaluated(values, at, fail)
  local lmax = values.lmax or DEGREE
  local object, message, code = light.field(1, "sampled_light", values.lights)
  if not object then return nil, message, code end
  local lights = core.type(object) == "ylm.lights" and core.lights_count(object) or 1
  form.take_numbers({ #at, math.max(lights, 3), (lmax + 1) ^ 2 }, fail)
  local c
  c, message, code = light.evaluate("sampled_light", lmax, object, at, { channels = "rgb", derivatives = 0 })
  return c, c and lmax or message, code
end

local function build(values, fail)
  if (values.lights == nil) == (values.coefficients == nil) then
    return fail("give one of lights and coefficients" .. (values.lights ~= nil and ", not both" or ""))
  end
  if values.lmax and values.coefficients ~= nil then return fail "lmax is for lights: coefficients have their own" end
  local at = places_of(values, fail)
  local c, lmax, code
  if values.lights ~= nil then
    c, lmax, code = evaluated(values, at, fail)
  else
    c, lmax, code = given(values, #at, fail)
  end
  if not c then return nil, lmax, code end
  local lights, message
  lights, message, code = core.lights_sampled(at, c, lmax, values.power)
  if not lights then
    if core.status(code) == "caller" then return fail(message) end
    return check.result("sampled_light", nil, message, code)
  end
  return setmetatable({ at = at, coefficients = c, lmax = lmax, power = values.power, count = #at, lights = lights },
    form.defined.sampled_light.metatable)
end

sampled.sampled_light = form.define("sampled_light", {
  numbers = 256,
  about = "Light that is known at a few places, and blended between them by 1/distance^power: local light for transfer "
    .. "vectors at the cost of a few places (Green 2003). It is a light field: rays see nothing of it. At a sample it is the "
    .. "sample's own light. It has at, coefficients, lmax and count.",
  fields = {
    { "at", "any", unit = "scene units",
      about = "[n][3], places of the samples, 1 to " .. check.limit_text(MOST) .. "; no two of them in one place" },
    { "lights", "any", optional = true, about = "lights, or any other light field, which is asked at the places" },
    { "coefficients", "any", optional = true, unit = "W m^-2 sr^-1/2",
      about = "[n][(lmax+1)^2] or [n][3][(lmax+1)^2] instead of lights" },
    { "lmax", "integer", min = 0, max = core.limits.lmax, optional = true,
      about = "of what lights are asked for, default 4; fields of higher degree are refused" },
    { "power", "number", min = 2, max = 100, default = 10,
      about = "the larger, the nearer the blend is to the nearest sample's light; below 2 it would have kinks" },
  },
  build = build,
  light = {},
  metatable = { __tostring = function(l)
    return ("sampled_light of %d places, lmax %d"):format(l.count, l.lmax)
  end },
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 10 }
local light = ylm.sampled_light { at = { { -1, 0, 0 }, { 1, 0, 0 } }, lights = lamp }
local here = ylm.light_field(4, light, { -1, 0, 0 })
assert(math.abs(here[1]:get(1) / ylm.light_field(4, lamp, { -1, 0, 0 })[1]:get(1) - 1) < 1e-6)]],
  source = "Green 2003, \"Local Lighting\"; Sloan et al. 2002",
})

return sampled
