--- ylm.sh.sky: standard skies, projected.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local project = require "ylm.sh.project"
local unit = require "ylm.vector".unit
local zonal = require "ylm.sh.zonal"

local sky = {}

local pi = math.pi

--- The fields that describe a sky.
local fields = {
  { "kind", "choice", of = core.choices "cie_sky", default = "overcast", about = "CIE standard sky" },
  { "zenith", "vector", default = { 0, 0, 1 }, about = "up: the pole of spherical harmonics, where environment_light's is y" },
  { "sun", "vector", optional = true,
    about = "towards the sun; 'clear' and 'partly cloudy' need it, above the horizon" },
  { "luminance", "number", min = 0, default = 1, about = "at the zenith" },
}

--- The fields of a sky over scenes, whose up is y.
sky.scene_fields = { fields[1], { "zenith", "vector", default = { 0, 1, 0 }, about = "up" }, fields[3], fields[4] }

local sky_options = { fields[1], fields[2], fields[3], fields[4],
  { "nodes", "integer", min = 4, max = 2000, default = 96,
    about = "of the quadrature over the upper half; overcast skies need none" },
}

--- The sky of checked fields, with directions of length 1, as core.sky_luminance takes it; fail(message) raises.
function sky.settle(o, fail)
  local s = { kind = o.kind, zenith = unit(o.zenith), sun = o.sun and unit(o.sun), luminance = o.luminance }
  if s.kind == "overcast" then return s end
  if not s.sun then return fail(("a %s sky needs sun = {x, y, z}"):format(s.kind)) end
  if s.sun[1] * s.zenith[1] + s.sun[2] * s.zenith[2] + s.sun[3] * s.zenith[3] <= 0 then
    return fail "the sun must be above the horizon"
  end
  return s
end

--- Coefficients [1][count] of a sky, by a rule for the half above the horizon.
local function above(lmax, s, nodes)
  local zenith = s.zenith
  local d, w = core.sh_rule(nodes, 2 * nodes, 0, 1)
  if not d then return check.result("sky", nil, w, "ENOMEM") end
  -- the half above z, turned so that z is the zenith (a reflection serves as well)
  local h = { zenith[1], zenith[2], zenith[3] - 1 }
  local hh = h[1] ^ 2 + h[2] ^ 2 + h[3] ^ 2
  local directions = core.array_totable(d)
  for _, v in ipairs(directions) do
    if hh > 0 then
      local t = 2 * (v[1] * h[1] + v[2] * h[2] + v[3] * h[3]) / hh
      v[1], v[2], v[3] = v[1] - t * h[1], v[2] - t * h[2], v[3] - t * h[3]
    end
  end
  local turned = array.array(directions)
  local values, message, code = core.sky_luminance(s, turned)
  if not values then return nil, message, code end
  return project.of_samples(lmax, turned, w, values)
end

--- Zonal coefficients of (1 + 2 cos theta)/3 above the horizon: integrals of P_l and of t P_l over 0 .. 1.
local function overcast(lmax, luminance)
  local p, z = zonal.legendre(lmax, 0), {}
  for l = 0, lmax do
    local mean = l == 0 and 1 or (p[l - 1] - p[l + 1]) / (2 * l + 1)
    z[l + 1] = luminance * math.sqrt(pi * (2 * l + 1)) / 3 * (mean + core.sh_cosine_factor(l) / pi)
  end
  return z
end

--- Coefficients [(lmax+1)^2] of a settled sky, and a report; nil, message, code.
function sky.coefficients(lmax, s, nodes)
  if s.kind == "overcast" then return zonal.zonal(overcast(lmax, s.luminance), s.zenith), { method = "closed form" } end
  local c, message, code = above(lmax, s, nodes)
  if not c then return nil, message, code end
  local rough
  rough, message, code = above(lmax, s, math.floor(0.7 * nodes))
  if not rough then return nil, message, code end
  args.held("sky", c)
  return core.array_reshape(c, { (lmax + 1) ^ 2 }),
    { method = "quadrature", samples = 2 * nodes ^ 2, error = project.distance(c, rough) }
end

describe "sh.sky" {
  about = "The coefficients of a CIE sky over the horizon: overcast, clear or partly cloudy, with the position of the sun.",
  arguments = { { "lmax", "integer", "highest degree" }, { "options?", "table", "see the options" } },
  options = sky_options,
  returns = {
    { "c", "array", "[(lmax+1)^2], in the unit of the zenith's luminance" },
    { "sky", "function", "the luminance itself, f(x, y, z) of a unit direction" },
    { "report", "table", "method: 'closed form' (overcast) or 'quadrature', whose error is estimated by a rule of half as "
      .. "many points: samples, error (of the norm)" },
  },
  errors = "raises where a sky needs a sun above the horizon and has none",
  example = [[
local c, sky = ylm.sh.sky(4, { kind = "clear", zenith = { 0, 1, 0 }, sun = { 1, 1, 0 }, luminance = 8 })
assert(math.abs(sky(0, 1, 0) - 8) < 1e-12 and sky(0, -1, 0) == 0 and #c == 25)]],
  source = "Green 2003, \"Creating Light Sources\" (skies of the CIE; cos theta in 'partly cloudy', misprinted there)",
}
function sky.sky(lmax, options)
  check.integer(1, "sky", "lmax", lmax, 0, core.limits.sh_lmax)
  local o = form.options(2, "sky", sky_options, options)
  local s = sky.settle(o, function(message) return check.bad(2, "sky", "%s", message) end)
  local c, report, code = sky.coefficients(lmax, s, o.nodes)
  if not c then return nil, report, code end
  return c, function(x, y, z) return core.sky_luminance(s, x, y, z) end, report
end

return sky
