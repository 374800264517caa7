-- Links or virtual lights: one bounce in a Cornell box, standing, with a lamp that moves, and with a glossy floor; error
-- beside paths, and time before the first frame and of each.
--
--     lua examples/papers/hvl_links.lua [--width 64] [--samples 512] [--frames 3] [--scene FILE] [--quick]
--
-- Errors are root mean square, relative to the mean of the bounce, over pixels off edges. The noise of the truth (--samples
-- paths a pixel) is taken off. Seconds are those of the processor, all threads together. "before" is what stays while lamps move:
-- elements and links of the scene and of the view. "frame" is light on elements and along links, or particles, lights and their
-- sums.
-- "virtual, rays" has a ray from each point to each light; else far parts are from a grid, near parts summed at each point, and
-- beside the glossy floor all lights at each point. --scene stands in place of the box; its lamps do not move, and its
-- floor is what it is.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { width = 64, samples = 512, frames = 3, scene = "", quick = false }
local quick = option.quick
local width, samples, frames = quick and 12 or option.width, quick and 16 or option.samples, quick and 2 or option.frames
local size, clock = { width, width }, os.clock
ylm.on_warning(false)

local geometry = {} -- by floor: meshes are shared, so that scenes of moved lamps are traced at once

--- The room with its lamp at x, z; floor: a material, nil for white paint.
local function room(x, z, floor)
  local made = rooms.cornell { floor = floor }
  local key = floor or "white"
  geometry[key] = geometry[key] or made.geometry
  local function at(dx, dz) return { x + dx, 1.98, z + dz } end
  return ylm.scene "Cornell box" {
    camera = made.camera, geometry = geometry[key],
    lights = ylm.polygon_light { vertices = { at(-0.25, -0.25), at(0.25, -0.25), at(0.25, 0.25), at(-0.25, 0.25) },
      radiance = { 17, 14, 9 }, horizon = { 0, 1, 0 } },
  }
end

local row = common.table { { "scene", "%-14s" }, { "method", "%-24s" }, { "before, s", "%9.2f" }, { "frame, s", "%8.2f" },
  { "rms, %", "%7.1f" }, { "worst frame, %", "%14.1f" } }

local ways = {}
for _, links in ipairs(quick and { 16 } or { 64, 256 }) do ways[#ways + 1] = { name = "links, " .. links, rays = links } end
for _, count in ipairs(quick and { 50 } or { 1000, 10000 }) do
  ways[#ways + 1] = { name = ("virtual, %s"):format(common.thousands(count)), count = count, sums = "split" }
  if count <= 1000 then
    ways[#ways + 1] = { name = ("virtual, rays, %s"):format(common.thousands(count)), count = count, shadows = "centre" }
  end
end

--- One bounce of a view under the lamps of s, as an array of radiances: the difference of pictures with it and without; and its
-- processor seconds, likewise. make(): options of such a picture.
local function bounce(view, s, make)
  local o = { lights = s.lights, light_samples = quick and 1 or 16 }
  local start = clock()
  local direct = assert(view:render(o))
  local plain = clock() - start
  start = clock()
  for key, value in pairs(make()) do o[key] = value end
  local image = assert(view:render(o))
  return image:layer() - direct:layer(), clock() - start - plain
end

--- A row for each way: frames of one geometry.
local function compare(name, scenes, glossy)
  local judges, wanted, lamp = {}, {}, nil
  for i, s in ipairs(scenes) do
    local truth = assert(s:pathtrace { size = size, samples = samples, reflections = { 2, 2 } })
    local image = assert(s:render { size = size, samples = 4, light_samples = 1, bounces = 0 })
    judges[i], wanted[i] = rooms.judge(image, truth), truth:layer()
    lamp = lamp or image:layer "emitter"[{ {}, {}, { 1, 1 } }]:greater(0) -- which the view shows in each frame
  end
  for _, way in ipairs(ways) do
    local start, links = clock(), nil
    if way.links then links = assert(scenes[1]:links { rays = quick and 4 or nil, lmax = 0 }) end
    local view = assert(scenes[1]:prepare { size = size, samples = 4, links = links, rays = way.links })
    local before, spent, square, worst = clock() - start, 0, 0, 0
    for i, s in ipairs(scenes) do
      local image, seconds = bounce(view, s, function()
        if way.links then return { bounced = assert(links:radiosity(s.lights, { bounces = 0 })) } end
        return { bounced = assert(s:virtual_lights { count = way.count }),
          virtual = { shadows = way.shadows, sums = not glossy and way.sums or nil } }
      end)
      image = image * (1 - lamp) + wanted[i] * lamp
      local e = judges[i](image)
      spent, square, worst = spent + seconds, square + e ^ 2, math.max(worst, e)
    end
    row { name, way.name, before, spent / #scenes, 100 * math.sqrt(square / #scenes), 100 * worst }
  end
end

if option.scene ~= "" then
  compare("standing", { rooms.given(option.scene) }, true)
  return
end
compare("standing", { room(0, 0) })
local path = {}
for i = 1, frames do
  local angle = 2 * math.pi * i / frames
  path[i] = room(0.6 * math.cos(angle), 0.6 * math.sin(angle))
end
compare("lamp moves", path)
compare("floor glosses", { room(0, 0, ylm.ggx { alpha = 0.3, f0 = 0.9 }) }, true)

print "Why: links know every wall, and their error is that of elements; virtual lights without rays to them pass the blocks,"
print "whatever their number. What a glossy floor sends to others links send as a matte one, virtual lights as fitted slices."
