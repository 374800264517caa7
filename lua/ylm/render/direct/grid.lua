--- Renders prepared views: by a grid, by the lights themselves, by rays to the lamps.

local ambient = require "ylm.render.ambient"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local dering = require "ylm.render.dering"
local devices = require "ylm.device"
local display = require "ylm.display"
local light = require "ylm.light"
local material = require "ylm.material"
local near = require "ylm.render.near"
local progress = require "ylm.progress"
local options = require "ylm.render.options"
local gloss = require "ylm.render.gloss"
local images = require "ylm.image"
local indirect = require "ylm.render.indirect"
local occlusion = require "ylm.render.occlusion"
local noises = require "ylm.render.noise"
local pictures = require "ylm.render.picture"
local prints = require "ylm.render.prints"
local relight = require "ylm.render.relight"
local tracing = require "ylm.trace"
local unmet = require "ylm.grid.unmet"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"

local shading = {}

--- Levels and errors of the grid's cells at shading points, where layers are asked for; false, message, code.
local function cells_of(p, o)
  if not o.layers or core.type(o.grid) ~= "ylm.grid" then return nil end
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
    unbaked = report.unbaked, device = devices.of(o.device):name() })
end

--- Completes the report of a picture by coefficients of light: its times and surfaces that gloss; `before`: the stages of its
-- view when it began.
local function finish(p, o, report, start, seconds, before)
  pictures.finish(report, start, seconds)
  gloss.report(p, o, report)
  if o.glossy and before then report.stages = report.stages or relight.stages(p, before) end
  return report
end

--- The report of a picture by coefficients of light, with what it does not keep: its own warnings and those of o.grid; or
-- nil, message, code.
local function shortcomings(name, p, o)
  local report = pictures.new_report(p)
  if o.weight == "cosine" then report.visibility = o.nearby and "none" or "grid"
  else
    local ok, message, code = occlusion.report(name, p, o, report)
    if not ok then return nil, message, code end
    local loud = views.loud(p)
    if loud then report.warnings[#report.warnings + 1] = warning.say(p.scene, "noise", "%s", loud) end
  end
  gloss.announce(p, report)
  for _, sentence in ipairs(unmet.warn(o.grid)) do report.warnings[#report.warnings + 1] = sentence end
  return report
end

--- The writer of a picture by o.grid on a device, function(layer) -> true, or nil, message, code; it completes the report.
local function writer(device, name, p, o, report)
  local bar = progress.resolve(o.progress)
  return function(layer)
    local done, message, code = device:picture(name, p, o, layer, bar, pictures.compose)
    if not done then return nil, message, code end
    report.outside, report.unbaked, report.stages = done.outside, done.unbaked, done.stages
    report.bias = done.bias
    dering.report(p, o, report, done.dering or dering.of_device(o, layer))
    report.pairs, report.fresh, report.seconds.light = done.pairs, done.fresh, done.seconds
    return true
  end
end

--- The picture that stays on the device, a gpu_array [height][width][3]; or nil, message, code.
local function kept(device, name, p, o, write)
  local out, message, code = device:room(name, p, o)
  if not out then return nil, message, code end
  local ok
  ok, message, code = write(out)
  if not ok and out ~= o.out then out:close() end
  if not ok then return nil, message, code end
  return out
end

--- Renders a prepared view by a grid, or any object with a light field: an image, or with download = false what stays on
-- the device.
function shading.by_grid(name, p, o)
  pictures.check_truth(name, p, o)
  o.weight, o.nearby = visibility.weight(name, p, o.grid, o.near), near.of_grid(o)
  if o.method == "zonal" then
    return check.fail("%s: zonal lobes are summed lamp by lamp, without a grid: view:reference { method = 'zonal' }", name)
  end
  local changed, problem, reason = relight.of(name, p, o)
  if not changed then return nil, problem, reason end
  p = changed
  local device = devices.of(o.device)
  device:check_picture(name, o)
  local report, failed, why = shortcomings(name, p, o)
  if not report then return nil, failed, why end
  local ready, unready, cause = gloss.ready(name, p, o, o.grid)
  if not ready then return nil, unready, cause end
  local start, before = core.seconds(), p.lib.shade_stages(p.view)
  o.shade = dering.shade
  local write = writer(device, name, p, o, report)
  local out, message, code
  if o.download == false then
    out, message, code = kept(device, name, p, o, write)
    if not out then return nil, message, code end
    return out, finish(p, o, report, start, report.seconds.light)
  end
  local cells
  cells, message, code = cells_of(p, o)
  if cells == false then return nil, message, code end
  out, message, code = pictures.picture(name, p, write, o, cells)
  if not out then return nil, message, code end
  finish(p, o, report, start, report.seconds.light, before)
  sign(out, p, o, report)
  return out, report
end

--- The radiance of a prepared view's shading points under o.grid, and a report; or nil, message, code.
function shading.points(name, p, o)
  views.check_grid(name, o.grid)
  o.weight = visibility.weight(name, p, o.grid)
  if o.method == "zonal" then return shading.by_grid(name, p, o) end -- which refuses it
  local changed, message, code = relight.of(name, p, o, true)
  if not changed then return nil, message, code end
  local start, before = core.seconds(), p.lib.shade_stages(changed.view)
  local radiance, done
  radiance, done, code = devices.of(nil):shade(name, changed, o, progress.resolve(o.progress))
  if not radiance then return nil, done, code end
  prints.say(p, o)
  local report = { points = p.stats.points, outside = done.outside, unbaked = done.unbaked,
    seconds = { light = core.seconds() - start } }
  if p.options.gloss == "sh" then report.stages = relight.stages(changed, before) end
  return radiance, report
end

--- The kind of pictures that scene:reference is a reference of, for its report.
shading.REFERENCE = "of grids under transfer vectors: their pictures without the error of the grid, not the scene's true shadows"

--- The lights that a reference sums: those of o.lights, else the scene's; nil, message, code.
local function lights_for(name, p, o)
  if o.lights == nil then return p.traced.lights end
  if o.method == "zonal" then
    return check.bad(1, name, "lights: method = 'zonal' is of the scene's own lights: leave one out")
  end
  local given, message, code = light.field(1, name, o.lights)
  if not given then return nil, message, code end
  local quantity = core.field_quantity(given)
  if quantity == "visibility" then return check.bad(1, name, "lights: a visibility is no light") end
  return given
end


--- Renders a prepared view with the lights' own coefficients at every shading point.
function shading.by_lights(name, p, o)
  pictures.check_truth(name, p, o)
  visibility.need_transfer(name, p)
  o.weight = "transfer"
  local changed, problem, reason = relight.of(name, p, o)
  if not changed then return nil, problem, reason end
  p = changed
  local report, failed, why = shortcomings(name, p, o)
  if not report then return nil, failed, why end
  report.reference = shading.REFERENCE
  local given, message, code = lights_for(name, p, o)
  if not given then return nil, message, code end
  local ready, unready, cause = gloss.ready(name, p, o, given)
  if not ready then return nil, unready, cause end
  local start, before = core.seconds(), p.lib.shade_stages(p.view)
  local lights
  lights, message, code = light.within(name, given, o.light_tolerance, o.threads)
  if not lights then return nil, message, code end
  local radiance, pairs
  local tally = light.tally(given)
  radiance, pairs, code = check.result(name, p.lib.shade_field(p.view, lights, o.weight, o.dtype,
    o.threads or 0, progress.resolve(o.progress)))
  if not radiance then return nil, pairs, code end
  if o.method == "zonal" then
    local ok
    ok, message, code = relight.zonal(name, p, o, radiance)
    if not ok then return nil, message, code end
  end
  local seconds = core.seconds() - start
  report.pairs, report.shadow = pairs, tally()
  for _, sentence in ipairs(light.heed(given, p.options.lmax)) do report.warnings[#report.warnings + 1] = sentence end
  local out
  out, message, code = pictures.picture(name, p, radiance, o)
  if not out then return nil, message, code end
  finish(p, o, report, start, seconds, before)
  pictures.sign(out, p, "reference", report, { dtype = o.dtype, light_tolerance = o.light_tolerance,
    pairs = ("%.0f"):format(pairs) })
  return out, report
end

--- Do all surfaces send the same radiance in every direction?
local function is_matte(s)
  for _, g in ipairs(s.geometry) do
    if g.material and material.glossy(g.material) then return false end
  end
  return true
end

--- For pictures that a viewer shows during the work: the array that rays fill, and the progress
-- that sends it.
local function live_rays(name, p, o)
  local bar = progress.resolve(o.progress)
  if not o.live then return nil, bar end
  local so_far = array.zeros({ p.stats.points, 3 }, "float")
  local sketch = images.image { size = p.options.size }
  return so_far, o.live.progress(bar, function()
    assert(check.result(name, p.lib.shade_compose(p.view, so_far, p.scene.background or { 0, 0, 0 }, o.threads or 0,
      sketch:layer "radiance")))
    return { display.layer_of(sketch, "radiance", 3, true) }
  end)
end

--- Renders a prepared view by sampling the lamps; `method` for the metadata, default raycast.
function shading.by_rays(name, p, o, method)
  pictures.check_truth(name, p, o)
  tracing.check_bodies(name, p.traced)
  local device = devices.of(o.device)
  device:check_rays(name)
  if o.download == false then return device:room(name, p, o) end
  if p.options.shading == "vertex" and not is_matte(p.scene) then
    return check.fail("%s: surfaces that are not matte are ray-cast from pixels: shading = 'pixel' in scene:prepare", name)
  end
  local start = core.seconds()
  local report = pictures.new_report(p)
  report.visibility = o.shadows and "rays" or "none"
  report.light_samples = o.light_samples
  report.gloss = p.traced.glossy > 0 and "rays" or nil
  local so_far, bar = live_rays(name, p, o)
  local radiance, rays, code = check.result(name, p.lib.shade_raycast(p.view, { light_samples = o.light_samples,
    shadows = o.shadows, seed = o.seed or p.options.seed, threads = o.threads or 0, progress = bar,
    lit = o.lit and o.lit.handle, into = so_far }))
  if not radiance then return nil, rays, code end
  local seconds = core.seconds() - start
  report.rays.shadow = rays
  local noise, message
  noise, message, code = check.result(name, p.lib.shade_raycast_noise(p.view, radiance, o.light_samples, o.shadows,
    o.seed or p.options.seed, o.threads or 0, o.lit and o.lit.handle))
  if not noise then return nil, message, code end
  report.direct_noise = noise
  if not o.tolerance then noises.say_direct(p, report, o.light_samples) end
  local out
  out, message, code = pictures.picture(name, p, radiance, o)
  if not out then return nil, message, code end
  pictures.finish(report, start, seconds)
  pictures.sign(out, p, method or "raycast", report, { light_samples = o.light_samples, shadows = o.shadows })
  return out, report
end

--- Direct light of a picture of a prepared view: by o.grid, or by rays to the lamps of its scene.
local function direct(name, p, o)
  if o.grid ~= nil or p.options.visibility ~= "rays" then
    views.check_grid(name, o.grid)
    if o.light_samples and not gloss.takes_samples(p) then
      return check.fail("%s: light_samples is for pictures by rays to the lamps, here is a grid: leave one out", name)
    end
    return shading.by_grid(name, p, o)
  end
  local chosen = o.light_samples == nil
  o.shadows, o.light_samples = true, o.light_samples or options.LIGHT_SAMPLES
  local image, report, code = shading.by_rays(name, p, o, "rays")
  if not image then return nil, report, code end
  if chosen then noises.say_camera(p, report, o.light_samples) end
  return image, report
end

--- The picture of a prepared view, with bounces as indirect.settle has settled them.
function shading.picture(name, p, o)
  local image, report, code
  image, report, code = indirect.ready(name, p, o)
  if not image then return nil, report, code end
  image, report, code = ambient.ready(name, p, o)
  if not image then return nil, report, code end
  local tally = light.tally(o.grid, o.bodies)
  image, report, code = direct(name, p, o)
  if not image then return nil, report, code end
  report.bodies, report.shadow = o.drawn, tally()
  indirect.report(p, o, report, image)
  for _, sentence in ipairs(prints.say(p, o)) do report.warnings[#report.warnings + 1] = sentence end
  near.report(p, o, report, image)
  ambient.report(p, o, report, image)
  return image, report
end

--- How many pictures variance is that of.
shading.BATCHES = 16

--- Adds layers `variance`, `samples` to the first of BATCHES pictures by cast(view), whose radiance becomes their mean. Views
-- behind the first are made with the next seeds.
function shading.in_batches(name, s, view, o, cast)
  local image, report, code = cast(view)
  if not image then return nil, report, code end
  local lib, first, layers = tracing.library(), o.seed, o.layers
  local mean, variance = image:layer "radiance", image:add("variance", 3)
  local rest = array.zeros({ o.size[2], o.size[1], 3 }, "float")
  local done, seconds = lib.path_add(mean, mean, rest, variance, 0), report.seconds
  o.layers, o.lmax, o.shading, o.visibility = false, 0, "pixel", "rays"
  for k = 2, shading.BATCHES do
    o.seed = first + k - 1
    local again, message
    again, message, code = views.prepare(name, s, o)
    if not again then return nil, message, code end
    local other, facts
    other, facts, code = cast(again)
    if not other then return nil, facts, code end
    done = lib.path_add(other:layer "radiance", mean, rest, variance, done)
    report.rays.primary, report.rays.shadow = report.rays.primary + facts.rays.primary, report.rays.shadow + facts.rays.shadow
    for stage, x in pairs(facts.seconds) do seconds[stage] = (seconds[stage] or 0) + x end
    again:close()
  end
  o.seed, o.layers = first, layers
  image:add("samples", 1)
  image:fill(1, 1, o.size[1], o.size[2], o.samples * shading.BATCHES, { layer = "samples" })
  image.metadata.samples, image.metadata.batches = o.samples * shading.BATCHES, shading.BATCHES
  return image, report
end

return shading
