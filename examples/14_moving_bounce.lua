-- A lamp that moves, and its bounce in every frame: particles, merged into lights that stay where they are.
--
--     ylm run examples/14_moving_bounce.lua                           8 frames in out/
--     ylm run examples/14_moving_bounce.lua --width 960 --height 600 --frames 120 --lights 2000
--
-- A particle keeps its random numbers and the cells of merged lights stay, so that light changes as the lamp does. Behind each
-- frame stand the change of its bounce from the last one and the jitter of three frames: the difference of the middle one from
-- the mean of its neighbours. Beside it stands that of frames which each have particles of their own (seed): they flicker.
-- Leaves in out/: bounce_01.png, ...

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 240, height = 150, samples = 4, frames = 8, lights = 400, particles = 20000,
  exposure = 0.5 }

ylm.on_warning(false) -- the room is convex but for the ball: light that passes it is little
local function wall(corner, u, v, colour)
  return ylm.quad { corner = corner, u = u, v = v, material = ylm.matte { albedo = colour } }
end
local white, red, green = { 0.75, 0.73, 0.7 }, { 0.65, 0.06, 0.05 }, { 0.1, 0.45, 0.1 }

--- The room with these lamps.
local function room(lights)
  return ylm.scene "a lamp that moves" {
    camera = ylm.camera { from = { 0, 1, 3.4 }, at = { 0, 0.9, 0 }, fov = 40 },
    geometry = {
      wall({ -1, 0, 1 }, { 2, 0, 0 }, { 0, 0, -2 }, white), wall({ -1, 2, 1 }, { 2, 0, 0 }, { 0, 0, -2 }, white),
      wall({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }, white), wall({ -1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }, red),
      wall({ 1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }, green),
      ylm.sphere { at = { 0.25, 0.4, -0.2 }, radius = 0.4, material = ylm.matte { albedo = white } },
    },
    lights = lights,
  }
end

local function lamp_of(frame)
  local x = math.sin(2 * math.pi * frame / 120)
  return ylm.sphere_light { at = { -0.55 + 0.3 * x, 1.2 + 0.4 * x, 0.2 }, radius = 0.06, radiance = 90 }
end

--- The root mean square over the picture of f(i, j), over that of layer b.
local function part(b, f)
  local off, all = 0, 0
  for i = 1, b.shape[1], 3 do
    for j = 1, b.shape[2], 3 do off, all = off + f(i, j) ^ 2, all + b:get(i, j, 2) ^ 2 end
  end
  return 100 * math.sqrt(off / all)
end
local function change(a, b) return part(b, function(i, j) return a:get(i, j, 2) - b:get(i, j, 2) end) end
local function jitter(list, k)
  local a, b, c = list[k - 2], list[k - 1], list[k]
  return part(b, function(i, j) return b:get(i, j, 2) - (a:get(i, j, 2) + c:get(i, j, 2)) / 2 end)
end

-- Surfaces in sight are found once, without a lamp.
local view = assert(room {}:prepare { size = { option.width, option.height }, samples = option.samples })
local cell
local same, other = {}, {} -- bounces by frame, of particles that stay and of others in each
for frame = 1, option.frames do
  local lamp = lamp_of(frame)
  local scene = room(lamp)
  local function bounce(seed)
    local lights, report = scene:virtual_lights { merge = option.lights, particles = option.particles, cell = cell, seed = seed }
    cell = cell or report.merged.cell
    return lights, assert(view:render { by = "none", bounced = lights, layers = false }):layer "radiance"
  end
  local lights
  lights, same[frame] = bounce(1)
  other[frame] = select(2, bounce(1 + frame))
  print(("frame %2d: %d lights%s%s"):format(frame, lights.count,
    frame > 1 and (", changed by %.2f %%"):format(change(same[frame], same[frame - 1])) or "",
    frame > 2 and (", jitter %.2f %%, with other particles %.2f %%"):format(jitter(same, frame), jitter(other, frame)) or ""))
  local image = assert(view:render { lights = lamp, bounced = lights })
  assert(image:save(("%s/bounce_%02d.png"):format(option.out, frame), { exposure = option.exposure }))
end
