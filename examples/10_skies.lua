-- Skies: an image of a studio and two skies of the CIE light a knot; by rays, by harmonics, and the difference an eye sees.
--
--     ylm run examples/10_skies.lua [--out DIR] [--width N] [--samples N] [--rays N] [--lmax N]
--
-- Leaves skies.png in out/. Rays see the image and are aimed at its pixels; harmonics have its projection to lmax. Beside
-- them stands FLIP (Andersson et al. 2020, 2021), and the table has the mean of it.

local ylm = require "ylm"
local core = require "ylm.c.core"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 480, samples = 4, rays = 64, lmax = 6 }
local size = { option.width, math.floor(option.width * 0.625) }

--- A dark room with a grey floor, a cold window and two warm lamps, as a latitude-longitude image with y up.
local function studio(height)
  local image, rows = ylm.image { size = { 2 * height, height } }, {}
  for y = 1, height do
    rows[y] = {}
    local v = 180 * (y - 0.5) / height -- degrees from the zenith
    for x = 1, 2 * height do
      local u = 180 * (x - 0.5) / height -- degrees from -z over the left (behind the camera's picture: 180)
      local c = v > 90 and { 0.10, 0.09, 0.08 } or { 0.05 + 0.05 * v / 90, 0.06 + 0.06 * v / 90, 0.09 + 0.06 * v / 90 }
      local pane = math.abs(u - 75) < 16 and math.abs(v - 62) < 20 and math.abs(u - 75) > 1 and math.abs(v - 62) > 1
      if pane then c = { 7, 9, 12 } end
      for _, lamp in ipairs { { 235, 38, 6 }, { 300, 55, 3 } } do
        local du = (u - lamp[1]) * math.sin(math.rad(lamp[2]))
        if du * du + (v - lamp[2]) ^ 2 < lamp[3] ^ 2 then c = { 60, 40, 20 } end
      end
      rows[y][x] = c
    end
  end
  core.array_fill(image:layer(), rows)
  return image
end

local grey, clay = ylm.matte { albedo = 0.6 }, ylm.matte { albedo = { 0.78, 0.66, 0.55 } }

local function lit_by(sky)
  return ylm.scene "skies" {
    camera = ylm.camera { from = { 2.4, 1.5, 4.2 }, at = { 0, 0.95, 0 }, fov = 42 },
    geometry = {
      ylm.quad { corner = { -600, 0, 600 }, u = { 1200, 0, 0 }, v = { 0, 0, -1200 }, material = grey },
      ylm.knot { at = { 0, 1, 0 }, p = 2, q = 3, radius = 0.6, minor = 0.3, tube = 0.17, divide = { 700, 60 },
        material = clay },
    },
    lights = sky,
  }
end

local sun = { -0.9, 0.75, 0.6 }
local skies = {
  { "an image of a studio", { image = studio(128), up = "y", lmax = option.lmax }, 0 },
  { "a clear sky of the CIE", { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = sun, luminance = 0.5 },
    lmax = option.lmax },
    0 },
  { "an overcast sky of the CIE", { sky = { zenith = { 0, 1, 0 }, luminance = 1.5 }, lmax = option.lmax }, 0 },
}

local row = common.table { { "sky", "%-28s" }, { "rays s", "%7.2f" }, { "harmonics s", "%12.2f" }, { "PSNR dB", "%8.1f" },
  { "relmse", "%9.2e" }, { "flip", "%7.4f" } }
local rows = {}
for i, sky in ipairs(skies) do
  local scene, start = lit_by(ylm.environment_light(sky[2])), core.seconds()
  local truth = assert(scene:render { bounces = 0, size = size, samples = option.samples, light_samples = option.rays })
  local between = core.seconds()
  local image = assert(scene:render { by = "sum", size = size, samples = option.samples, lmax = option.lmax,
    occlusion_distance = 100 })
  local finished = core.seconds()
  local map, look = assert(image:flip(truth))
  local m = assert(image:compare(truth))
  row { sky[1], between - start, finished - between, m.psnr, m.relmse, look.mean }
  rows[i] = {
    { image = truth, tone = "hable", exposure = 1.5 + sky[3], caption = sky[1] .. ", by rays" },
    { image = image, tone = "hable", exposure = 1.5 + sky[3], caption = ("by harmonics to lmax %d"):format(option.lmax) },
    { image = map:colours { map = "magma", range = { 0, 1 } }, caption = "FLIP, 0 (black) to 1" },
  }
end
common.save(ylm.figure { rows = rows }, option.out .. "skies.png")
