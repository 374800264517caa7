-- Virtual lights: a Cornell box by direct light, with one bounce of 2,000 virtual lights, and by paths; and the same 100 lights
-- as points, clamped points, spheres, and by harmonics of two profiles, beside the bounce that paths find.
--
--     ylm run examples/13_virtual_lights.lua [--out DIR] [--width N] [--samples N] [--lights N] [--few N]
--
-- Writes virtual_lights.png and virtual_lights_methods.png.
-- Metres, degrees, W sr^-1 m^-2; y is up.

local ylm = require "ylm"
local core = require "ylm.c.core"

local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")
local option = common.options { out = "out", width = 280, samples = 256, lights = 2000, few = 100 }
local size = { option.width, option.width }

local white = ylm.matte { albedo = 0.74 }
local red, green = ylm.matte { albedo = { 0.63, 0.06, 0.05 } }, ylm.matte { albedo = { 0.14, 0.45, 0.09 } }
local function wall(corner, u, v, material) return ylm.quad { corner = corner, u = u, v = v, divide = 4, material = material } end
local function block(at, size3, angle)
  return ylm.box { at = at, scale = size3, rotate = { axis = { 0, 1, 0 }, angle = angle }, material = white }
end

local scene = ylm.scene "Cornell box" {
  camera = ylm.camera { from = { 0, 1, 3.6 }, at = { 0, 0.97, 0 }, fov = 37.5 },
  geometry = {
    wall({ -1, 0, 1 }, { 2, 0, 0 }, { 0, 0, -2 }, white),
    wall({ -1, 2, -1 }, { 2, 0, 0 }, { 0, 0, 2 }, white),
    wall({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }, white),
    wall({ -1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }, red),
    wall({ 1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }, green),
    block({ -0.34, 0.6, -0.3 }, { 0.58, 1.2, 0.58 }, 18),
    block({ 0.36, 0.3, 0.32 }, { 0.58, 0.6, 0.58 }, -17),
  },
  lights = {
    ylm.polygon_light { vertices = { { -0.25, 1.98, -0.25 }, { 0.25, 1.98, -0.25 }, { 0.25, 1.98, 0.25 },
      { -0.25, 1.98, 0.25 } }, radiance = { 17, 14, 9 }, horizon = { 0, 1, 0 } }, -- it shines downwards
  },
}

--- Results of make(), and its seconds behind the first.
local function timed(make)
  local start = core.seconds()
  local a, b, c = make()
  if a == nil then error(tostring(b), 0) end
  return a, core.seconds() - start, b, c
end

local function luminance(p) return 0.2126 * p[1] + 0.7152 * p[2] + 0.0722 * p[3] end

local lamp -- layer: pixels that show some of the lamp are left out of differences

--- Differences of luminance of two images, relative to the mean of the second; their root mean square.
local function differences(image, truth)
  local wanted, mean, n = truth:layer():totable(), 0, size[1] * size[2]
  for _, line in ipairs(wanted) do for _, p in ipairs(line) do mean = mean + luminance(p) / n end end
  local values, square = image:layer():totable(), 0
  for y, line in ipairs(values) do
    for x, p in ipairs(line) do
      line[x] = lamp:get(y, x, 1) > 0 and 0 or (luminance(p) - luminance(wanted[y][x])) / mean
      square = square + line[x] ^ 2 / n
    end
  end
  return values, math.sqrt(square)
end

-- One bounce ---------------------------------------------------------------------------------

local shared = { size = size, samples = 8, light_samples = 32 }
local with = common.adding_to(shared)

local direct, direct_seconds = timed(function() return scene:render(shared) end)
lamp = direct:layer "emitter"
local bounced, bounced_seconds, report = timed(function()
  return scene:render(with { bounces = 1, indirect = { method = "virtual", count = option.lights, shadows = "centre" } })
end)
local truth, truth_seconds = timed(function() return scene:pathtrace { size = size, samples = option.samples, bounces = 1 } end)
local values, rms = differences(bounced, truth)
local power = report.virtual.emitted.power
print(("%d lights, %.1f million pairs; of %.2f W (red) that the lamp emits, %.2f W land and %.2f W are reflected"):format(
  report.virtual.lights, report.virtual.pairs / 1e6, power.emitted[1], power.landed[1], power.reflected[1]))
print(("root mean square of the difference: %.3f of the mean luminance"):format(rms))

local function shown(image, words, exposure)
  return { image = image, tone = "hable", exposure = exposure or 1.5, caption = words }
end
common.save(ylm.figure {
  title = "A Cornell box with one bounce",
  rows = { { shown(direct, ("direct light, %.1f s"):format(direct_seconds)),
    shown(bounced, ("and %d virtual lights, %.1f s"):format(report.virtual.lights, bounced_seconds)),
    shown(truth, ("paths of one bounce, %.1f s"):format(truth_seconds)),
    { values = values, caption = "virtual lights less paths" } } },
  bar = { range = { -0.5, 0.5 }, map = "coolwarm", label = "difference, of the mean luminance" },
  caption = ("Rays to the middles of lights. Seconds on two cores. Root mean square difference %.3f of the mean."):format(rms),
}, option.out .. "virtual_lights.png")

-- Few lights by each method ---------------------------------------------------------

local view = assert(scene:prepare { size = size, samples = 4 })
local few = assert(scene:virtual_lights { count = option.few })
local caps = assert(scene:virtual_lights { count = option.few, profile = "cap" })
local bounce = assert(scene:pathtrace { size = size, samples = option.samples, reflections = { 2, 2 } })
local row = common.table { { "method", "%-24s" }, { "ns a pair", "%9.1f" }, { "rms", "%7.3f" } }
local rows = { {}, {} }
for i, m in ipairs {
  { "points", { lights = few, method = "vpl", clamp = "none" } },
  { "points, clamped", { lights = few, method = "vpl" } },
  { "clamped, compensated", { lights = few, method = "vpl", compensate = 8 } },
  { "spheres", { lights = few, method = "vsl" } },
  { "harmonics, cap", { lights = caps, method = "hvl" } },
  { "harmonics, gauss", { lights = few, method = "hvl" } },
} do
  m[2].shadows, m[2].layers = "centre", false
  local image, facts = view:gather(m[2])
  if not image then error(facts, 0) end
  local _, off = differences(image, bounce)
  row { m[1], facts.ns_per_pair, off }
  local list = rows[i <= 3 and 1 or 2]
  list[#list + 1] = shown(image, ("%s: %.2f"):format(m[1], off), 3)
end
rows[2][4] = shown(bounce, "paths", 3)
local lit = {}
local at, _, _, emission = few:arrays()
for i = 1, #at do
  local c = {}
  for k = 1, 3 do c[k] = emission:get(i, k, 1) * 100 end
  lit[i] = ylm.sphere_light { at = { at:get(i, 1), at:get(i, 2), at:get(i, 3) }, radius = 0.014, radiance = c }
end
rows[1][4] = shown(assert(view:render { lamps = lit, layers = false }), ("direct light and the %d lights"):format(few.count), 0.7)
common.save(ylm.figure {
  title = ("The bounce of light by %d virtual lights"):format(few.count),
  rows = rows,
  caption = "Numbers: root mean square difference from paths, of the mean luminance. All have rays to the middles of lights.",
}, option.out .. "virtual_lights_methods.png")
