-- Frames of a room whose lamps all move, bounces included: 50,000 elements, 640 x 470 shading points with 64 links, direct
-- light at the points by 4 shadow rays each, with the 2,516 lamps of examples/scenes/floor_lights.lua and with one.
-- Milliseconds of each part, wall time: median and least of the frames; frames a second.
--
--     build/ylm run spec/bench/frames.lua [threads] [frames]

local ylm = require "ylm"
local core = require "ylm.c.core"

local threads, frames = tonumber(arg[1] or 2), tonumber(arg[2] or 12)
local demo = assert(ylm.load "examples/scenes/floor_lights.lua")

local room = {
  ylm.box { bounds = { { -5.6, -0.001, -5.6 }, { 5.6, 3.8, 5.6 } }, material = ylm.matte { albedo = { 0.62, 0.6, 0.55 } } },
  ylm.knot { at = { 0, 1.25, 0 }, p = 2, q = 3, radius = 0.75, minor = 0.38, tube = 0.21, divide = { 350, 28 },
    material = ylm.matte { albedo = { 0.74, 0.70, 0.66 } } },
}

--- Lamps of a frame: all circle round the axis, each its own way; or one that does.
local function circling(count)
  local at, radius, radiance = {}, {}, {}
  for i = 1, count do
    local lamp = count == 1 and { at = { 2, 2.4, 0 }, radius = 0.12, radiance = { 60, 50, 36 } } or demo.lights[i]
    at[i], radius[i], radiance[i] = lamp.at, lamp.radius, lamp.radiance
  end
  local now = ylm.array(at, "double")
  radius, radiance = ylm.array(radius, "double"), ylm.array(radiance, "double")
  return function(frame)
    for i = 1, count do
      local p, turn = at[i], 0.02 * frame * (i % 2 == 0 and 1 or -1)
      local c, s = math.cos(turn), math.sin(turn)
      now:set(i, 1, c * p[1] - s * p[3])
      now:set(i, 3, s * p[1] + c * p[3])
    end
    return ylm.sphere_lights { at = now, radius = radius, radiance = radiance }
  end
end

--- Median and least of a list.
local function summary(list)
  table.sort(list)
  return list[math.floor((#list + 1) / 2)], list[1]
end

local function row(name, list) print(("%-46s %9.1f %9.1f"):format(name, summary(list))) end

local stage = ylm.scene "frames" { camera = demo.camera, geometry = room, lights = {} }
local t = assert(stage:links { spacing = 0.262, rays = 128, lmax = 0 })
local view = assert(stage:prepare { size = { 640, 470 }, samples = 1, rays = 64, links = t })
print(("%d elements, %d shading points, %d links of each, %d threads, %d frames"):format(t.stats.elements, view.stats.points,
  view.stats.links, threads, frames))

local order = { "lamps", "relight and E0", "solve", "shadow rays", "gather", "image", "frame" }

local function by_rays(count)
  local lamps = circling(count)
  local lit = assert(t:radiosity(lamps(0), { light_samples = 4, threads = threads }))
  local parts, picture = {}, nil
  for _, name in ipairs(order) do parts[name] = {} end
  for frame = 1, frames do
    local start = core.seconds()
    local now = lamps(frame)
    local moved = core.seconds()
    lit:update(now)
    local image, report = assert(view:render { bounced = lit, light_samples = 4, layers = false, threads = threads, lamps = now,
      out = picture })
    picture = image
    local s, all = report.seconds, core.seconds() - start
    local ms = { lamps = moved - start, ["relight and E0"] = lit.stats.seconds - lit.stats.solve_seconds,
      solve = lit.stats.solve_seconds, ["shadow rays"] = s.light, gather = s.bounced, image = s.image, frame = all }
    for name, x in pairs(ms) do table.insert(parts[name], 1000 * x) end
  end
  print(("\n%d lamps, all move: 4 shadow rays a point%17s %9s"):format(count, "median ms", "least ms"))
  for _, name in ipairs(order) do row(name, parts[name]) end
  local median, least = summary(parts.frame)
  print(("%-46s %9.1f %9.1f"):format("frames a second", 1000 / median, 1000 / least))
end

by_rays(#demo.lights)
by_rays(1)
