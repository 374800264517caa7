-- Lamps that fly through the scene of 2516 lamps: the grid follows, every frame is sampled and shaded anew.
--
--     ylm run examples/04_moving_lights.lua                           12 small frames and a contact sheet in out/
--     ylm run examples/04_moving_lights.lua --width 1024 --height 768 --lamps 1 --frames 60
--
-- Surfaces that the camera sees, and their occlusion, are found once (scene:prepare of the scene without lamps); a frame is
--   grid:update   only what the lamps' motion changes beyond the tolerance is baked again,
--   view:render   only shading points of voxels that changed are sampled; lamps are drawn where they are in this frame.
-- --lamps is how many of the lanterns fly. With --device, the name or number of a GPU, it sums lights and shades, and every
-- frame is baked from nothing instead of updated.
-- Leaves in out/: moving_01.png, ... and moving.png, the contact sheet. Times are printed by stage.

local ylm = require "ylm"
local core = require "ylm.c.core"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 480, height = 360, samples = 4, frames = 12, lamps = 3, step = 0.2,
  tolerance = 0.02, depth = 9, exposure = 2.6, rays = 128, device = "", nopictures = false }
local out = option.out
local size = { option.width, option.height }

--- Stops with the message of a call that failed.
local function good(x, message, code)
  if x == nil then error(("%s (%s)"):format(message, code or "?"), 0) end
  return x, message
end

local device = option.device ~= "" and good(ylm.vulkan.open { device = tonumber(option.device) or option.device }) or nil

local scene = assert(ylm.load(here .. "scenes/floor_lights.lua"))

-- The lamps as arrays: those that fly are the first lanterns of the spiral, taken from their places ----------

local colours = { { 90, 38, 8 }, { 10, 45, 90 }, { 75, 10, 60 }, { 20, 80, 25 }, { 70, 60, 30 } }
local at, radius, radiance, flying = {}, {}, {}, {}
for i, lamp in ipairs(scene.lights) do
  local c = lamp.radiance
  at[i], radius[i] = lamp.at, lamp.radius
  radiance[i] = { 0.35 * c[1], 0.35 * c[2], 0.35 * c[3] } -- so that the flying ones are seen to light the scene
  if lamp.at[2] < 1 and #flying < option.lamps then
    flying[#flying + 1] = i
    radiance[i], radius[i] = colours[(#flying - 1) % #colours + 1], 0.03
  end
end
at, radius, radiance = ylm.array(at, "double"), ylm.array(radius, "double"), ylm.array(radiance, "double")

--- All lamps in a frame: those that fly go round the knot, half of them each way, and bob up and down.
local function lamps(frame)
  for n, i in ipairs(flying) do
    local r = 1.45 + 0.3 * (n % 3)
    local angle = 2 * math.pi * n / #flying + (n % 2 == 0 and -1 or 1) * option.step * frame / r
    at:set(i, 1, r * math.cos(angle))
    at:set(i, 2, 0.40 + 0.2 * math.sin(n + 2 * angle))
    at:set(i, 3, r * math.sin(angle))
  end
  return ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
end

-- Once --------------------------------------------------------------------------------------------

local started = core.seconds()
local stage = ylm.scene(scene.name) { camera = scene.camera, geometry = scene.geometry, lights = {} }
local view = good(stage:prepare { size = size, samples = option.samples, transfer_samples = option.rays,
  visibility = "transfer" })
local prepared = core.seconds() - started
local around = { { -5.51, -0.01, -5.51 }, { 5.51, 2.6, 5.51 } } -- the floor and the knot
local probes = ylm.adaptive_grid { bounds = around, lmax = 4, depth = option.depth, tolerance = option.tolerance,
  dynamic = not device }
local grid = good(ylm.bake(probes, lamps(0), { occupied = view, device = device }))
local stats = grid.stats
print(("%d x %d, %s shading points: %.1f s; %s grid points for %s lamps: %.2f s"):format(size[1], size[2],
  common.thousands(view.stats.points), prepared, common.thousands(stats.points), common.thousands(#scene.lights), stats.seconds))

-- Frame by frame ----------------------------------------------------------------------------------

local row = common.table { { "frame", "%5d" }, { "points", "%7d" }, { "new", "%5d" }, { "dropped", "%7d" },
  { "sampled %", "%9.1f" }, { "error", "%7.4f" }, { "update ms", "%9.1f" }, { "shade ms", "%8.1f" },
  { "image ms", "%8.1f" }, { "cpu ms", "%7.1f" } }
local sum, frames, shown = { update = 0, shade = 0, image = 0, cpu = 0 }, 0, {}
local spare -- a picture that no one needs, to be written again
for frame = 1, option.frames do
  local clock, now = os.clock(), lamps(frame)
  local report
  if device then
    grid:close()
    grid = good(ylm.bake(probes, now, { occupied = view, device = device }))
    report = grid.stats
  else
    report = good(grid:update(now))
  end
  local picture, rendered = good(view:render { grid = grid, lamps = now, layers = false, device = device, out = spare })
  local cpu = 1e3 * (os.clock() - clock)
  local update, shade, composed = 1e3 * report.seconds, 1e3 * rendered.seconds.light, 1e3 * rendered.seconds.image
  local fresh = 100 * (rendered.fresh or rendered.points) / rendered.points
  row { frame, report.points, report.added, report.removed, fresh, report.error, update, shade, composed, cpu }
  if frame > 1 then -- the first shades everything
    frames = frames + 1
    sum.update, sum.shade, sum.image = sum.update + update, sum.shade + shade, sum.image + composed
    sum.cpu = sum.cpu + cpu
  end
  spare = picture
  if not option.nopictures then
    good(picture:save(("%smoving_%02d.png"):format(out, frame), { exposure = option.exposure, tone = "hable" }))
    if (frame - 1) % math.max(1, math.floor(option.frames / 6)) == 0 and #shown < 6 then
      shown[#shown + 1], spare = { picture, frame }, nil
    end
  end
end
if frames > 0 then
  local all = (sum.update + sum.shade + sum.image) / frames
  print(("a frame: update %.1f + sample and shade %.1f + image %.1f = %.1f ms, %.1f frames per second; "
    .. "%.1f ms of processor time"):format(sum.update / frames, sum.shade / frames, sum.image / frames, all, 1e3 / all,
    sum.cpu / frames))
end

-- The contact sheet ---------------------------------------------------------------------------------

if #shown > 0 then
  local columns, gap = math.min(3, #shown), 4
  local rows = math.ceil(#shown / columns)
  local sheet = good(ylm.image { size = { columns * (size[1] + gap) - gap, rows * (size[2] + gap) - gap } })
  sheet:fill(1, 1, sheet.size[1], sheet.size[2], { 0.02, 0.02, 0.02 })
  for k, each in ipairs(shown) do
    local x, y = (k - 1) % columns * (size[1] + gap) + 1, math.floor((k - 1) / columns) * (size[2] + gap) + 1
    sheet:paste(each[1], x, y)
    sheet:text(x + 8, y + size[2] - 26, ("frame %d"):format(each[2]), { scale = 2, colour = 0.4 })
  end
  good(sheet:save(out .. "moving.png", { exposure = option.exposure, tone = "hable" }))
  print(("%smoving.png and %d frames: %.0f s"):format(out, option.frames, core.seconds() - started))
end
