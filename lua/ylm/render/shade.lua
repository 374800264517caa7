--- Renders prepared views: by a grid, by the lights themselves, by rays to the lamps.

local check = require "ylm.check"
local core = require "ylm.c.core"
local light = require "ylm.light"
local progress = require "ylm.progress"
local occlusion = require "ylm.render.occlusion"
local pictures = require "ylm.render.picture"
local unmet = require "ylm.grid.unmet"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local shading = {}

--- Radiance of a view under a dynamic grid: only what changed since the last time is sampled.
local function shade_again(name, p, o, bar)
  local m = views.made[p.view]
  if not m.memory then
    local memory, message, code = check.result(name, p.lib.shade_memory(p.view))
    if not memory then return nil, message, code end
    m.radiance, message, code = core.array_zeros({ p.stats.points, 3 }, "float")
    if not m.radiance then return nil, message, code end
    m.memory = memory
  end
  return check.result(name, p.lib.shade_grid_again(p.view, m.memory, o.grid, o.interpolation, o.threads or 0, bar,
    m.radiance))
end

--- Levels and errors of the grid's cells at shading points, where layers are asked for; false, message, code.
local function cells_of(p, o)
  if not o.layers then return nil end
  local level, error = p.lib.shade_grid_cells(p.view, o.grid, o.threads or 0)
  if not level then return false, error, "ENOMEM" end
  return { level = level, error = error }
end

--- Writes into the metadata of a picture by a grid, or another light field, how it came about.
local function sign(out, p, o, report)
  local grid = o.grid
  local stats = type(grid.stats) == "table" and grid.stats or {}
  local kind = core.type(grid)
  pictures.sign(out, p, "grid", report, { interpolation = o.interpolation,
    grid = kind == "ylm.grid" and tostring(grid) or kind, tolerance = grid.tolerance,
    threshold = grid.threshold, grid_points = stats.points, outside = report.outside,
    unbaked = report.unbaked, device = o.device and o.device.name })
end

--- The report of a picture by transfer vectors, with what it does not keep: its own warnings and those of o.grid; or nil,
-- message, code.
local function shortcomings(name, p, o)
  local report = pictures.new_report(p)
  local ok, message, code = occlusion.report(name, p, o, report)
  if not ok then return nil, message, code end
  local loud = views.loud(p)
  if loud then report.warnings[#report.warnings + 1] = warning.say(p.scene, "noise", "%s", loud) end
  for _, sentence in ipairs(unmet.warn(o.grid)) do report.warnings[#report.warnings + 1] = sentence end
  return report
end

--- Renders a prepared view by a grid on a device: an image, or with download = false a gpu_array [height][width][3].
local function by_device(name, p, o)
  local report, failed, why = shortcomings(name, p, o)
  if not report then return nil, failed, why end
  local start, bar = core.seconds(), progress.resolve(o.progress)
  local device = require "ylm.vulkan.image"
  local function write(picture_of)
    local done, message, code = device.render(name, p, o, picture_of, bar, pictures.compose)
    if not done then return nil, message, code end
    report.outside, report.unbaked, report.stages, report.seconds.light = done.outside, done.unbaked, done.stages, done.seconds
    return true
  end
  local out, message, code
  if o.download == false then
    out, message, code = device.room(name, p, o)
    if not out then return nil, message, code end
    local ok
    ok, message, code = write(out)
    if not ok and out ~= o.out then out:close() end
    if not ok then return nil, message, code end
    return out, pictures.finish(report, start, report.seconds.light)
  end
  local cells
  cells, message, code = cells_of(p, o)
  if cells == false then return nil, message, code end
  out, message, code = pictures.picture(name, p, write, o, cells)
  if not out then return nil, message, code end
  pictures.finish(report, start, report.seconds.light)
  sign(out, p, o, report)
  return out, report
end

--- Renders a prepared view by a grid, or any object with a light field.
function shading.by_grid(name, p, o)
  pictures.check_truth(name, p, o)
  if o.device then
    if core.type(o.grid) ~= "ylm.grid" then
      return check.bad(1, name, "device: a baked grid expected, got %s", check.describe(o.grid))
    end
    return by_device(name, p, o)
  end
  if o.download == false then
    return check.bad(1, name, "download: name the device that the picture is to stay on")
  end
  local report, failed, why = shortcomings(name, p, o)
  if not report then return nil, failed, why end
  local start, grid, lib = core.seconds(), o.grid, p.lib
  local bar, threads, cells = progress.resolve(o.progress), o.threads or 0, nil
  local radiance, outside, unbaked, seconds
  if core.type(grid) == "ylm.grid" and lib.shade_grid then
    if grid.dynamic then
      radiance, outside, unbaked, seconds, report.fresh = shade_again(name, p, o, bar)
    else
      radiance, outside, unbaked, seconds =
        check.result(name, lib.shade_grid(p.view, grid, o.interpolation, threads, bar))
    end
    if not radiance then return nil, outside, unbaked end
    report.outside, report.unbaked = outside, unbaked
    cells, outside, unbaked = cells_of(p, o)
    if cells == false then return nil, outside, unbaked end
  else
    radiance, report.pairs, seconds = check.result(name, lib.shade_field(p.view, grid, "float", threads, bar))
    if not radiance then return nil, report.pairs, seconds end
    seconds = core.seconds() - start
  end
  local out, message, code = pictures.picture(name, p, radiance, o, cells)
  if not out then return nil, message, code end
  pictures.finish(report, start, seconds)
  sign(out, p, o, report)
  return out, report
end

--- Renders a prepared view with the lights' own coefficients at every shading point.
function shading.by_lights(name, p, o)
  pictures.check_truth(name, p, o)
  local report, failed, why = shortcomings(name, p, o)
  if not report then return nil, failed, why end
  local start = core.seconds()
  local lights, message, code = light.within(name, p.traced.lights, o.light_tolerance, o.threads)
  if not lights then return nil, message, code end
  local radiance, pairs
  radiance, pairs, code = check.result(name, p.lib.shade_field(p.view, lights, o.dtype, o.threads or 0,
    progress.resolve(o.progress)))
  if not radiance then return nil, pairs, code end
  local seconds = core.seconds() - start
  report.pairs = pairs
  local out
  out, message, code = pictures.picture(name, p, radiance, o)
  if not out then return nil, message, code end
  pictures.finish(report, start, seconds)
  pictures.sign(out, p, "reference", report, { dtype = o.dtype, light_tolerance = o.light_tolerance,
    pairs = ("%.0f"):format(pairs) })
  return out, report
end

--- Renders a prepared view by sampling the lamps.
function shading.by_rays(name, p, o)
  pictures.check_truth(name, p, o)
  local start = core.seconds()
  local report = pictures.new_report(p)
  local radiance, rays, code = check.result(name, p.lib.shade_raycast(p.view, o.samples, o.shadows,
    o.seed or p.options.seed, o.threads or 0, progress.resolve(o.progress)))
  if not radiance then return nil, rays, code end
  local seconds = core.seconds() - start
  report.rays.shadow = rays
  local out, message
  out, message, code = pictures.picture(name, p, radiance, o)
  if not out then return nil, message, code end
  pictures.finish(report, start, seconds)
  pictures.sign(out, p, "raycast", report, { shadow_rays = o.samples, shadows = o.shadows })
  return out, report
end

return shading
