-- Ren et al. 2006: spherical harmonic exponentiation beside products and unions, for spheres: errors against rays, time a sphere.
--
--     lua examples/papers/shexp_2006.lua [--side 150] [--places 48] [--quick]
--
-- First, logarithms of a circle of 45 degrees. Then irradiance of a floor at --places places behind four sets of spheres,
-- against --side^2 rays a place: "apart" are 8 small bodies, "large" 8 that overlap seen from a place, "chain" 24 spheres of
-- one body and "knot" 64 spheres in place of a mesh (ylm.sphere_set). Errors are root mean square, in % of the irradiance
-- without spheres; light has degree 2. Seconds are of one thread, 2,000 places at a time, all spheres at every place (cull =
-- 0); luminance. The paper was not at hand: numbers of its figures are missing here. Its claim that exponentials do as well as
-- products holds for small spheres and few bands; Xin et al. 2021 say that at n = 10 and 15 they do not, and so does this
-- table.

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "../common.lua")

local option = common.options { side = 150, places = 48, quick = false }
local quick = option.quick
if quick then option.side, option.places = 20, 4 end
ylm.on_warning(false)

local sh = ylm.sh
local _, zonal = sh.circle_log(3, { 0, 0, 1 }, math.rad(45))
print(("log of a circle of 45 degrees, n = 4:  %.3f %.3f %.3f %.3f"):format(
  zonal:get(1), zonal:get(2), zonal:get(3), zonal:get(4)))
print "a table by others, 44.96 degrees:        -1.309 -1.943 -1.882 -1.375"
print()

local state = 7
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

local smooth = { math.sqrt(4 * math.pi), 0.3, 0.5, -0.4, 0.2, 0.1, -0.2, 0.15, 0.1 }
local rays = {} -- as many for each cosine
for i = 0, option.side - 1 do
  for j = 0, option.side - 1 do
    local u, phi = (i + 0.5) / option.side, 2 * math.pi * (j + 0.5) / option.side
    rays[#rays + 1] = { math.sqrt(u) * math.cos(phi), math.sqrt(u) * math.sin(phi), math.sqrt(1 - u) }
  end
end
local light = sh.reconstruct(smooth, rays):totable()

--- Irradiance by rays behind spheres, and without them.
local function truth(p, at, radius)
  local sum, all, near = 0, 0, {}
  for i = 1, #at do
    local x, y, z = at[i][1] - p[1], at[i][2] - p[2], at[i][3] - p[3]
    near[i] = { x, y, z, x * x + y * y + z * z - radius[i] ^ 2 }
  end
  for k, w in ipairs(rays) do
    local free = true
    for i = 1, #near do
      local q = near[i]
      local along = q[1] * w[1] + q[2] * w[2] + q[3] * w[3]
      if along > 0 and along * along >= q[4] then
        free = false
        break
      end
    end
    all = all + light[k]
    if free then sum = sum + light[k] end
  end
  return sum / #rays * math.pi, all / #rays * math.pi
end

local sets = {}
local function add(name, at, radius, body) sets[#sets + 1] = { name, at, radius, body } end
do
  for k, name in ipairs { "apart", "large" } do
    local at, radius, body = {}, {}, {}
    for i = 1, 8 do
      local phi, r = 2 * math.pi * i / 8, 0.6 + random()
      at[i], body[i] = { r * math.cos(phi), r * math.sin(phi), (k == 1 and 0.7 or 0.9) + 0.6 * random() }, i
      radius[i] = k == 1 and 0.12 + 0.12 * random() or 0.3 + 0.3 * random()
    end
    add(name, at, radius, body)
  end
  local at, radius, body = {}, {}, {}
  for i = 1, 24 do
    local t = 2 * math.pi * i / 24
    at[i], radius[i], body[i] = { 0.9 * math.cos(t), 0.9 * math.sin(t), 1 + 0.3 * math.sin(2 * t) }, 0.22, 1
  end
  add("chain", at, radius, body)
  local a, r = ylm.sphere_set(ylm.knot { radius = 0.8, minor = 0.3, tube = 0.14, at = { 0, 0, 1.1 } }, { count = 64 })
  body = {}
  for i = 1, #r do body[i] = 1 end
  add("knot", a:totable(), r:totable(), body)
end

local places, many = {}, {}
for i = 1, option.places do places[i] = { 3 * random() - 1.5, 3 * random() - 1.5, 0 } end
for i = 1, quick and 40 or 2000 do many[i] = places[(i - 1) % #places + 1] end
many = ylm.array(many, "float")

local ball = ylm.occluder { radius = 1 }
local methods = {
  { "at directions", spheres = true }, { "one rule", { layers = false } }, { "rule 12", { layers = false, rule = 12 } },
  { "recursive", { product = "recursive" } }, { "SHEXP, PS-9", { product = "exp", exp = "PS" } },
  { "SHEXP, OL", { product = "exp", exp = "OL" } }, { "SHEXP, HYB", { product = "exp" } },
}
local line = common.table { { "spheres", "%-8s" }, { "count", "%5d" }, { "n", "%3d" }, { "method", "%-14s" },
  { "rms error %", "%11.3f" },
  { "over the first", "%14.1f" }, { "most %", "%7.2f" }, { "ns a sphere and place", "%21.0f" } }
for _, set in ipairs(sets) do
  local at, radius, want, open = set[2], set[3], {}, {}
  for i, p in ipairs(places) do want[i], open[i] = truth(p, at, radius) end
  for _, n in ipairs(quick and { 5 } or { 5, 10, 15 }) do
    local first
    for _, method in ipairs(methods) do
      local o = { lights = ylm.environment_light { coefficients = sh.resize(smooth, n - 1) }, cull = 0,
        casters = method.spheres and ylm.sphere_casters { at = at, radius = radius, body = set[4] }
          or ylm.casters { hides = ball, at = at, scale = radius } }
      for key, value in pairs(method[2] or {}) do o[key] = value end
      local shade = ylm.shadowed(o)
      local good, L = pcall(ylm.light_field, n - 1, shade, places, { channels = "luminance", threads = 1 })
      if good then
        local E, sum, most = L:totable(), 0, 0
        for i = 1, #places do
          local e = (sh.irradiance(E[i][1], { 0, 0, 1 }) - want[i]) / open[i]
          sum, most = sum + e * e, math.max(most, math.abs(e))
        end
        local rms = 100 * math.sqrt(sum / #places)
        first = first or rms
        local ms = common.best(os.clock, quick and 1 or 3, function()
          ylm.light_field(n - 1, shade, many, { channels = "luminance", threads = 1 })
        end)
        line { set[1], #at, n, method[1], rms, rms / first, 100 * most, ms * 1e6 / #many / #at }
      else
        line { set[1], #at, n, method[1] }
      end
    end
  end
end
print()
print "'at directions' are ylm.sphere_casters: the smallest value of a body's spheres at each direction, products between"
print "bodies. A product cuts each sphere off at n and darkens where spheres overlap, exponentials as well; - is a series"
print "that diverges."
