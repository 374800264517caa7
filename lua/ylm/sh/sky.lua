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

local sky_options = {
  { "kind", "choice", of = { "overcast", "clear", "partly cloudy" }, default = "overcast", about = "CIE standard sky" },
  { "zenith", "vector", default = { 0, 0, 1 }, about = "up" },
  { "sun", "vector", optional = true,
    about = "towards the sun; 'clear' and 'partly cloudy' need it, above the horizon" },
  { "luminance", "number", min = 0, default = 1, about = "at the zenith" },
  { "nodes", "integer", min = 4, max = 2000, default = 96,
    about = "of the quadrature over the upper half; overcast skies need none" },
}

--- The luminance of a sky as a function of direction, relative to the zenith's.
local function sky_function(o, zenith, sun)
  local function dot(a, x, y, z) return a[1] * x + a[2] * y + a[3] * z end
  if o.kind == "overcast" then
    return function(x, y, z)
      local c = dot(zenith, x, y, z)
      return c > 0 and o.luminance * (1 + 2 * c) / 3 or 0
    end
  end
  local clear = o.kind == "clear"
  local a, b, k, scattering, e = 0.526, 5, -1.5, 0, -0.8
  if clear then a, b, k, scattering, e = 0.91, 10, -3, 0.45, -0.32 end
  local S = math.acos(math.max(-1, math.min(1, dot(zenith, sun[1], sun[2], sun[3]))))
  local function glow(g) return a + b * math.exp(k * g) + scattering * math.cos(g) ^ 2 end
  local scale = o.luminance / (glow(S) * (1 - math.exp(e)))
  return function(x, y, z)
    local c = dot(zenith, x, y, z)
    if c <= 0 then return 0 end
    local g = math.acos(math.max(-1, math.min(1, dot(sun, x, y, z))))
    return scale * glow(g) * (1 - math.exp(e / c))
  end
end

--- Coefficients [1][count] of what shines from above the horizon alone, by a rule for that half.
local function above(lmax, f, zenith, nodes)
  local d, w = core.sh_rule(nodes, 2 * nodes, 0, 1)
  if not d then return check.result("sky", nil, w, "ENOMEM") end
  -- the half above z, turned so that z is the zenith (a reflection serves as well)
  local h = { zenith[1], zenith[2], zenith[3] - 1 }
  local hh = h[1] ^ 2 + h[2] ^ 2 + h[3] ^ 2
  local directions, values = core.array_totable(d), {}
  for i, v in ipairs(directions) do
    if hh > 0 then
      local t = 2 * (v[1] * h[1] + v[2] * h[2] + v[3] * h[3]) / hh
      v[1], v[2], v[3] = v[1] - t * h[1], v[2] - t * h[2], v[3] - t * h[3]
    end
    values[i] = { f(v[1], v[2], v[3]) }
  end
  return project.of_samples(lmax, (array.array(directions)), w, (array.array(values)))
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
  local zenith, sun = unit(o.zenith), o.sun and unit(o.sun)
  if o.kind ~= "overcast" then
    if not sun then return check.bad(2, "sky", "a %s sky needs sun = {x, y, z}", o.kind) end
    if sun[1] * zenith[1] + sun[2] * zenith[2] + sun[3] * zenith[3] <= 0 then
      return check.bad(2, "sky", "the sun must be above the horizon")
    end
  end
  local f = sky_function(o, zenith, sun)
  if o.kind == "overcast" then return zonal.zonal(overcast(lmax, o.luminance), zenith), f, { method = "closed form" } end
  local c, message, code = above(lmax, f, zenith, o.nodes)
  if not c then return nil, message, code end
  local rough
  rough, message, code = above(lmax, f, zenith, math.floor(0.7 * o.nodes))
  if not rough then return nil, message, code end
  args.held("sky", c)
  return core.array_reshape(c, { (lmax + 1) ^ 2 }), f,
    { method = "quadrature", samples = 2 * o.nodes ^ 2, error = project.distance(c, rough) }
end

return sky
