-- One lamp of the 2516 of examples/scenes/floor_lights.lua moves 2 cm a frame, 1024 x 768, 4 samples a pixel, lmax 4, rgb,
-- depth 9: grid:update, sampling and shading, and the image, whose memory is used again; then one of 100 exact polygon
-- lights over the same floor. Wall time is of all threads.
-- Processor time is of as many frames on one thread: compare it on a machine that is busy.
--
--     build/ylm run spec/bench/moving.lua [threads] [frames]

local ylm = require "ylm"

local threads, frames = tonumber(arg[1] or 2), tonumber(arg[2] or 24)
local scene = assert(ylm.load "examples/scenes/floor_lights.lua")

--- The lamps of the scene as arrays, times a factor; the first lantern's index.
local function arrays(factor)
  local at, radius, radiance, lantern = {}, {}, {}, nil
  for i, lamp in ipairs(scene.lights) do
    local c = lamp.radiance
    at[i], radius[i] = lamp.at, lamp.radius
    radiance[i] = { factor * c[1], factor * c[2], factor * c[3] }
    if lamp.at[2] < 1 and not lantern then lantern = i end
  end
  return ylm.array(at, "double"), ylm.array(radius, "double"), ylm.array(radiance, "double"), lantern
end

--- Lamps of a frame: number i of the scene steps aside.
local function step_aside(i)
  local at, radius, radiance = arrays(1)
  local x = at:get(i, 1)
  return function(frame)
    at:set(i, 1, x + 0.02 * frame)
    return ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
  end
end

--- Lamps of a frame: a bright lantern flies round the knot, as in examples/04_moving_lights.lua.
local function fly()
  local at, radius, radiance, i = arrays(0.35)
  radius:set(i, 0.03)
  for c = 1, 3 do radiance:set(i, c, ({ 90, 38, 8 })[c]) end
  return function(frame)
    local angle = -0.02 * frame / 1.75
    at:set(i, 1, 1.75 * math.cos(angle))
    at:set(i, 2, 0.40 + 0.2 * math.sin(1 + 2 * angle))
    at:set(i, 3, 1.75 * math.sin(angle))
    return ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
  end
end

--- Lights of a frame: panels of 10 x 10 cm under the ceiling, one of which moves below the others.
local function slide(n)
  local function panel(x, y, z)
    return ylm.polygon_light { radiance = { 9, 8, 6 },
      vertices = { { x - 0.05, y, z - 0.05 }, { x + 0.05, y, z - 0.05 }, { x + 0.05, y, z + 0.05 }, { x - 0.05, y, z + 0.05 } } }
  end
  local all = {}
  for k = 1, n do
    local r, a = 5 * math.sqrt(k / n), 2.4 * k
    all[k] = panel(r * math.cos(a), 2.4, r * math.sin(a))
  end
  return function(frame)
    all[7] = panel(-1 + 0.02 * frame, 1.2, 1.5)
    return all
  end
end

local stage = ylm.scene(scene.name) { camera = scene.camera, geometry = scene.geometry, lights = {} }
local view = assert(stage:prepare { size = { 1024, 768 }, samples = 4, transfer_samples = 32, visibility = "transfer" })
local points = view:points().position

--- Milliseconds of a frame by stage, wall and processor time together: mean over frames 2 .. n of one thread or several.
--- `flat` lamps shine, but only spheres are drawn over a prepared view.
local function run(lamps, tolerance, n, on, flat)
  local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -5.51, -0.01, -5.51 }, { 5.51, 2.6, 5.51 } }, lmax = 4,
    depth = 9, tolerance = tolerance, dynamic = true }, lamps(0), { occupied = points }))
  local sum, picture = { update = 0, light = 0, image = 0, cpu = 0, least = math.huge, points = 0, fresh = 0 }, nil
  for frame = 1, n + 1 do
    local now, clock = lamps(frame), os.clock()
    local report = assert(grid:update(now, { threads = on }))
    local image, rendered = assert(view:render { grid = grid, lamps = not flat and now or nil, layers = false, threads = on,
      out = picture })
    picture = image
    local cpu, s = os.clock() - clock, rendered.seconds
    if frame > 1 then
      sum.update, sum.light, sum.image = sum.update + report.seconds, sum.light + s.light, sum.image + s.image
      sum.cpu, sum.points, sum.fresh = sum.cpu + cpu, sum.points + report.points, sum.fresh + rendered.fresh / #points
      sum.least = math.min(sum.least, report.seconds + s.light + s.image)
    end
  end
  for key, x in pairs(sum) do if key ~= "least" then sum[key] = x / n end end
  return sum
end

print(("moving lamps: %d shading points, %d frames, %d threads"):format(#points, frames, threads))
print "lamp                   points  shaded %  update ms  shade ms  image ms  frame ms  (least)  frames/s  one thread ms"
for _, case in ipairs { { "canopy, number 401", step_aside(401), 0.01 }, { "floor, number 740", step_aside(740), 0.01 },
  { "bright lantern", fly(), 0.02 }, { "one panel of 100", slide(100), 0.02, true } } do
  local lamps, tolerance, flat = case[2], case[3], case[4]
  local one, all = run(lamps, tolerance, math.ceil(frames / 3), 1, flat), run(lamps, tolerance, frames, threads, flat)
  local frame = all.update + all.light + all.image
  print(("%-20s %8.0f %9.1f %10.1f %9.1f %9.1f %9.1f  (%5.1f) %9.1f %14.1f"):format(case[1], all.points, 100 * all.fresh,
    1e3 * all.update, 1e3 * all.light, 1e3 * all.image, 1e3 * frame, 1e3 * all.least, 1 / frame, 1e3 * one.cpu))
end
