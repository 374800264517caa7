-- Paths of any length: a room with its noise, a furnace in which a sphere vanishes, ten spheres of more and more roughness.
--
--     ylm run examples/11_paths.lua [--out DIR] [--width N] [--samples N]
--
-- Writes paths.png, paths_furnace.png and paths_spheres.png, and prints what direct light alone lacks.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 320, samples = 256 }

-- A room: direct light, all bounces, and how far its pixels may be off ---------------------------------

local room = assert(ylm.load(here .. "scenes/room.lua"))
local size = { option.width, math.floor(option.width * 0.75) }
local direct = assert(room:pathtrace { size = size, samples = option.samples, bounces = 0 })
local all, report = assert(room:pathtrace { size = size, samples = option.samples })

--- Standard error of each pixel relative to it; of black pixels 0.
local function relative(image)
  local mean, error = common.luminance(image:layer "radiance"), common.luminance(image:layer "variance":sqrt())
  return error * mean:greater(0) / (mean + mean:equal(0))
end

local function sum(image) return common.luminance(image:layer()):sum() end

print(("direct light is %.0f %% of the picture; noise %.2f %%, %.1f s"):format(100 * sum(direct) / sum(all), 100 * report.noise,
  report.seconds.total))
common.save(ylm.figure {
  rows = { {
    { image = direct, tone = "hable", exposure = 1, caption = "direct light (bounces = 0)" },
    { image = all, tone = "hable", exposure = 1, caption = ("all bounces, %d samples"):format(option.samples) },
    { values = relative(all), caption = "standard error over radiance" },
  } },
  bar = { range = { 0.01, 1 }, log = true, label = "relative standard error" },
}, option.out .. "paths.png")

-- Furnaces: what reflects everything cannot be seen under a uniform sky ---------------------------------

--- A sphere of a material under a sky of 1.
local function furnace(material)
  return assert(ylm.scene "furnace" {
    camera = ylm.camera { from = { 0, 0, 4 }, at = { 0, 0, 0 }, fov = 40 },
    geometry = { ylm.sphere { radius = 1, divide = { 256, 128 }, material = material } },
    lights = { ylm.environment_light { radiance = 1 } },
  }:pathtrace { size = { 160, 160 }, samples = option.samples })
end

local furnaces = {
  { "matte, albedo 0.8", ylm.matte { albedo = 0.8 } },
  { "matte, albedo 1", ylm.matte { albedo = 1 } },
  { "ggx, alpha 0.8, f0 1, single scattering", ylm.ggx { alpha = 0.8, f0 = 1, compensate = false } },
  { "the same, compensated", ylm.ggx { alpha = 0.8, f0 = 1, compensate = true } },
}
local items = {}
for i, row in ipairs(furnaces) do
  items[i] = { image = furnace(row[2]), tone = "srgb", exposure = -0.5, caption = row[1] }
end
common.save(ylm.figure { rows = { items } }, option.out .. "paths_furnace.png")

-- Ten spheres, alpha 0.05 to 1 ------------------------------------------------------------------------

local ground = ylm.matte { albedo = 0.3 }
local spheres = { ylm.quad { corner = { -30, 0, 12 }, u = { 60, 0, 0 }, v = { 0, 0, -30 }, material = ground } }
for i = 0, 9 do
  spheres[#spheres + 1] = ylm.sphere { at = { 2.1 * (i - 4.5), 0.95, 0 }, radius = 0.95, divide = { 192, 96 },
    material = ylm.ggx { alpha = 0.05 * 20 ^ (i / 9), f0 = { 0.95, 0.8, 0.55 } } }
end
local row = ylm.scene "ten spheres" {
  camera = ylm.camera { from = { 0, 5, 26 }, at = { 0, 0.8, 0 }, fov = 9.6 },
  geometry = spheres,
  lights = {
    ylm.environment_light { radiance = { 0.25, 0.32, 0.45 } },
    ylm.polygon_light { vertices = { { -9, 7, 2 }, { 9, 7, 2 }, { 9, 7, 4 }, { -9, 7, 4 } }, radiance = 4 },
  },
}
local image = assert(row:pathtrace { size = { 2 * option.width, math.floor(0.4 * option.width) }, samples = option.samples })
common.save(ylm.figure { rows = { { { image = image, tone = "hable", exposure = 1.5,
  caption = "GGX, alpha from 0.05 to 1 in equal ratios, under a sky and a flat lamp as long as the row" } } } },
  option.out .. "paths_spheres.png")
