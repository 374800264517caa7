-- A room as a glTF file, and back: lamps and panels as another program sees them, and one lamp moved.
--
--     ylm run examples/16_gltf.lua [--out DIR] [--width N] [--samples N] [--exposure STOPS]
--
-- Leaves gltf_room.glb and gltf_room.png in out/, and prints how much the pictures differ. The second room has lost
-- extras.ylm, as a file of another program: its lamp is a point of so many candela, its panel a surface that emits.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 256, samples = 9, exposure = 1 }

local scene = assert(ylm.load(here .. "scenes/room.lua"))
local path = option.out .. "gltf_room.glb"
local _, notes = assert(scene:save(path))
for _, note in ipairs(notes) do print(note) end
local same = assert(ylm.load(path))

-- Names of the same length keep the file's chunks where they are.
local file = assert(io.open(path, "rb"))
local bytes = file:read "*a":gsub('"ylm":{', '"YLM":{')
file:close()
local stranger = option.out .. "gltf_stranger.glb"
file = assert(io.open(stranger, "wb"))
file:write(bytes)
file:close()
local other = assert(ylm.load(stranger, { lamp_radius = 0.1 }))
os.remove(stranger)
for _, note in ipairs(other.report.notes) do print(note) end
local moved = ylm.scene "moved" { like = other, moved = { { at = { 0.6, 0.9, 0.5 } } } }

local function picture(s)
  return (assert(s:render { bounces = 0, size = { option.width, option.width }, samples = option.samples,
    light_samples = 24, seed = 1 }))
end

local first = picture(scene)
local images = { picture(same), picture(ylm.scene "other" { like = other, camera = scene.camera }),
  picture(ylm.scene "moved" { like = moved, camera = scene.camera }) }
local captions = { "the room, saved and read", "without extras.ylm", "its lamp moved" }
local panels = {}
for i, image in ipairs(images) do
  local d = image:layer() - first:layer()
  print(("%-26s root of the mean square difference: %.3f of the mean"):format(captions[i],
    math.sqrt((d * d):mean()) / first:layer():mean()))
  panels[i] = { image = image, tone = "hable", exposure = option.exposure, caption = captions[i] }
end
common.save(ylm.figure { rows = { panels } }, option.out .. "gltf_room.png")
