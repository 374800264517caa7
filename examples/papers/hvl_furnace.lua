-- Virtual lights in an integrating sphere, where truth is a closed form: what each method makes of it.
--
--     lua examples/papers/hvl_furnace.lua [--lights 2000] [--width 64] [--quick]
--
-- No --scene is read: truth is a closed form.
-- A sphere of radius 1 and albedo rho is around a lamp of flux Phi. Between any two of its places cos cos/d^2 is 1/4. Any set of
-- points, wherever they are, therefore gives the irradiance rho Phi/(4 pi) everywhere, and all bounces 1/(1 - rho) times that:
-- unclamped points (Keller 1997) have no error here. Spheres and profiles have one, of the light of their surroundings of one
-- radius. "even" are lights that stand on the sphere by arrays, "traced" those of scene:virtual_lights on a sphere of triangles.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { lights = 2000, width = 64, scene = "", quick = false }
rooms.no_scene(option.scene, "truth is the closed form of a sphere: hvl_methods takes a scene")
local quick = option.quick
local count, width = quick and 100 or option.lights, quick and 12 or option.width
ylm.on_warning(false)

local RHO, FLUX = 0.6, 4 * math.pi ^ 2 * 0.1 ^ 2 * 10 -- of the lamp below
local wanted = RHO * FLUX / (4 * math.pi)

-- Lights by arrays ---------------------------------------------------------------------------

--- n places of a unit sphere, evenly (Fibonacci's spiral, turned), and normals to its middle.
local function even(n, turn)
  local at, normal = {}, {}
  for i = 1, n do
    local z, phi = 1 - (2 * i - 1) / n, i * 2.399963229728653 + turn
    local r = math.sqrt(1 - z * z)
    at[i] = { r * math.cos(phi), r * math.sin(phi), z }
    normal[i] = { -at[i][1], -at[i][2], -at[i][3] }
  end
  return at, normal
end

local at, normal = even(count, 0)
local points, normals = even(quick and 20 or 200, 1)
local intensity = RHO * FLUX / (count * math.pi)

--- Mean and root mean square of values/wanted - 1, in percent.
local function spread(values)
  local error = values / wanted - 1
  return 100 * error:mean(), 100 * math.sqrt((error ^ 2):mean())
end

print(("albedo %.1f, flux %.3f W: irradiance of one bounce %.4f W/m^2, of all %.4f"):format(RHO, FLUX, wanted,
  wanted / (1 - RHO)))
local row = common.table { { "even lights", "%-22s" }, { "mean - 1, %", "%10.4f" }, { "rms, %", "%9.4f" } }
do
  local list = {}
  for i, p in ipairs(points) do
    local sum = 0
    for k, y in ipairs(at) do
      local v = { y[1] - p[1], y[2] - p[2], y[3] - p[3] }
      local d2 = v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2
      local c = v[1] * normals[i][1] + v[2] * normals[i][2] + v[3] * normals[i][3]
      local e = -(v[1] * normal[k][1] + v[2] * normal[k][2] + v[3] * normal[k][3])
      sum = sum + math.max(0, c) * math.max(0, e) / (d2 * d2)
    end
    list[i] = sum * intensity
  end
  row { "points, cosines exact", spread(ylm.array(list)) }
end
for _, profile in ipairs { "point", "cap", "gauss" } do
  for _, lmax in ipairs(profile == "point" and { 2, 4, 8 } or { 4, 8 }) do
    local radius = 1.5 * math.sqrt(4 * math.pi / count) / math.sqrt(math.pi)
    local lights = ylm.virtual_lights { at = at, normal = normal, radius = profile ~= "point" and radius or nil,
      intensity = intensity, profile = profile }
    local L, list = ylm.light_field(lmax, lights, points, { channels = "luminance", dtype = "double" }), {}
    local E = ylm.sh.irradiance(L, normals)
    for i = 1, #points do list[i] = E:get(i, 1, i) end
    local mean, rms = spread(ylm.array(list))
    row { ("%s, lmax %d"):format(profile, lmax), mean, rms }
  end
end
do -- at the middle
  local lights = ylm.virtual_lights { at = at, normal = normal, intensity = intensity, profile = "point" }
  local L = ylm.light_field(4, lights, { 0, 0, 0 }, { channels = "luminance", dtype = "double" })
  local first, rest = L:get(1, 1), 0
  for k = 2, 25 do rest = math.max(rest, math.abs(L:get(1, k))) end
  print(("at the middle: L00 over sqrt(4 pi) rho Phi/(4 pi^2) less 1: %.1e; the largest of the others over L00: %.1e"):format(
    first / (math.sqrt(4 * math.pi) * RHO * FLUX / (4 * math.pi ^ 2)) - 1, rest / first))
end

-- Lights that are traced ------------------------------------------------------------------------

local scene = ylm.scene "integrating sphere" {
  camera = ylm.camera { from = { 0.1, 0.2, 0.1 }, at = { -1, 0.2, 0.1 }, fov = 100 },
  geometry = ylm.sphere { radius = 1, divide = quick and { 32, 16 } or { 192, 96 }, material = ylm.matte { albedo = RHO } },
  lights = ylm.sphere_light { at = { 0.3, 0.2, 0.1 }, radius = 0.1, radiance = 10 },
}
local view = assert(scene:prepare { size = { width, width }, samples = 1, visibility = "none" })
local n = #view:points().position
local traced = common.table { { "traced lights", "%-26s" }, { "lights", "%6d" }, { "mean - 1, %", "%10.2f" }, { "rms, %",
  "%7.2f" } }

local function try(name, lights, o)
  o.by, o.bounced, o.layers = "none", lights, false
  local image = assert(view:render(o))
  local mean, rms = spread(ylm.array(image:layer()[{ {}, {}, 1 }], "double") * (math.pi / RHO / (o.factor or 1)))
  traced { name, lights.count, mean, rms }
end

local one, report = assert(scene:virtual_lights { count = count })
local caps = assert(scene:virtual_lights { count = count, profile = "cap" })
try("points", one, { rival = { "vpl", clamp = "none" } })
try("points, clamped", one, { rival = { "vpl" } })
try("clamped, compensated", one, { rival = { "vpl", compensate = quick and 2 or 16 } })
try("spheres", one, { rival = { "vsl" } })
try("harmonics, cap", caps, { virtual = { sums = "all" } })
try("harmonics, gauss", one, { virtual = { sums = "all" } })
if not quick then
  for _, more in ipairs { 500, 8000, 32000 } do
    try("harmonics, gauss, lmax 8", (assert(scene:virtual_lights { count = more })), { virtual = { lmax = 8, sums = "all" } })
  end
end
print(("power, W: emitted %.3f, landed %.3f, reflected %.3f = rho of it"):format(report.power.emitted[1], report.power.landed[1],
  report.power.reflected[1]))
local _, all = assert(scene:virtual_lights { count = 20 * count, bounces = "all" })
print(("all bounces reflect %.4f of the lamp's power; rho/(1 - rho) is %.4f"):format(
  all.power.reflected[1] / all.power.emitted[1], RHO / (1 - RHO)))
print(("%s points. Triangles lie within the sphere: cosines of points near them are not those of the sphere."):format(
  common.thousands(n)))
print "Harmonics: lights at the horizon are seen under an angle r/d, and weighed by a smooth cosine where the true one has a"
print "kink: the error falls as the radius, the root of the number of lights. Spheres leave out what is below the horizon, and"
print "are dark."
