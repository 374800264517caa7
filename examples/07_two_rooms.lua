-- Light that passes a closed wall: two rooms by SH transfer and by rays, and what occlusion_distance makes of them.
--
--     ylm run examples/07_two_rooms.lua [--out DIR] [--width N] [--samples N] [--rays N] [--exposure STOPS]
--
-- Leaves two_rooms.png in out/, and prints for several distances how much of the picture's light passes occluders and how much
-- of the scene's is missing: as the report of every rendering measures it, and as the picture's own pixels have it.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 640, samples = 4, rays = 256, exposure = 1.7 }

local scene = assert(ylm.load(here .. "scenes/two_rooms.lua"))
scene.camera = ylm.camera { from = scene.camera.from, at = scene.camera.at, fov = 28 } -- the rooms fill the picture
local size = { option.width, math.floor(option.width * 0.45) }
local small = { math.floor(option.width / 2), math.floor(option.width * 0.225) }

--- Luminance of surfaces in the left and in the right half of a picture, the wall's edge between them.
local function halves(image)
  local light = common.luminance(image:layer()) * common.surface_mask(ylm, image)
  local width = light.shape[2]
  local middle = math.floor(width / 2)
  return light[{ {}, { 1, middle } }]:sum(), light[{ {}, { middle + 1, width } }]:sum()
end

-- Distances against rays to the lamps -----------------------------------------------------------------

local left = halves(assert(scene:render { bounces = 0, size = small, samples = option.samples, light_samples = 16 }))
local row = common.table { { "occlusion_distance", "%18s" }, { "passing %", "%9.1f" }, { "+-", "%4.1f" },
  { "missing %", "%9.1f" }, { "+-", "%4.1f" }, { "left / true", "%11.3f" }, { "right / all", "%11.3f" } }
local function try(name, distance)
  local image, report = assert(scene:render { by = "sum", size = small, samples = option.samples, occlusion_distance = distance })
  local l, r = halves(image)
  local o = report.occlusion
  row { name or ("%g"):format(distance), 100 * o.passing, 100 * o.passing_error, 100 * o.missing, 100 * o.missing_error,
    l / left, r / (l + r) }
end
try("default"); try(nil, 0.5); try(nil, 1.5); try(nil, 2); try(nil, 3); try(nil, 5)

-- The picture ---------------------------------------------------------------------------------------

local image = assert(scene:render { size = size, samples = option.samples, visibility = "transfer",
  transfer_samples = 2 * option.rays })
local truth = assert(scene:render { size = size, samples = option.samples, light_samples = option.rays,
  bounces = 0 })
common.save(ylm.figure {
  rows = { {
    { image = image, tone = "hable", exposure = option.exposure, caption = 'visibility = "transfer": light passes the wall' },
    { image = truth, tone = "hable", exposure = option.exposure,
      caption = 'visibility = "rays", the default: the right room is dark' },
  } },
}, option.out .. "two_rooms.png")
