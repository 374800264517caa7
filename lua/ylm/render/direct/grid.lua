--- Direct light by a grid, or any object with a light field: of lights, under transfer vectors; of others as it is held.

local baking = require "ylm.render.bake"
local check = require "ylm.check"
local coefficients = require "ylm.render.coefficients"
local core = require "ylm.c.core"
local dering = require "ylm.render.dering"
local devices = require "ylm.device"
local gloss = require "ylm.render.gloss"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local prints = require "ylm.render.prints"
local progress = require "ylm.progress"
local relight = require "ylm.render.relight"
local unmet = require "ylm.grid.unmet"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"

local grid = { name = "grid", called = 'by = "grid"' }

grid.options = options.list(options.grid_fields, dering.fields, near.fields, { options.light_samples }, options.bounce_fields,
  { options.element_field })
grid.scene_options = options.list(options.view_fields, options.prepare_fields, gloss.fields, { options.sums_field })
grid.view_options = options.list(relight.fields, relight.method_fields, {
  { "download", "boolean", default = true, shelf = "experiments",
    about = "false: a picture made on the device stays there, as a gpu_array [height][width][3] of radiance" },
})

function grid.wants(o, p)
  if o.grid ~= nil then return true end
  local v = p and p.options.visibility or not p and o.visibility
  return v ~= nil and v ~= false and v ~= "rays"
end

function grid.settle(name, s, o, given)
  if o.grid ~= nil then views.check_grid(name, o.grid) end
  gloss.settle(name, o, given, s, visibility.settle_picture(name, o, given or {}))
  if o.grid == nil and not s.probes then views.check_grid(name, nil) end
  if o.grid and o.sums_tolerance then
    return check.fail("%s: sums_tolerance is for baking the scene's probes, this grid is baked: leave one out", name)
  end
  o.bakes, o.lmax = o.grid == nil, o.lmax or views.default_lmax(s, o.grid)
end

--- The grid of the scene's probes for what a view sees; or nil, message, code.
local function baked(p, o)
  if p.stats.points == 0 then return p.traced.lights end -- no point will ask what light there is
  return baking.bake(p.scene, { quantity = "lights", occupied = p.view, threads = o.threads, progress = o.progress,
    sums_tolerance = o.sums_tolerance })
end

function grid.prepare(name, p, o)
  local message, code
  if o.bakes then
    o.grid, message, code = baked(p, o)
    if not o.grid then return nil, message, code end
  end
  views.check_grid(name, o.grid)
  if o.light_samples and not gloss.takes_samples(p) then
    return check.fail("%s: light_samples is for pictures by rays to the lamps, here is a grid: leave one out", name)
  end
  o.weight, o.nearby = visibility.weight(name, p, o.grid, o.near_lights), near.of_grid(o)
  if o.method == "zonal" then
    return check.fail("%s: zonal lobes are summed lamp by lamp, without a grid: by = 'sum', method = 'zonal'", name)
  end
  local changed, report, ok
  changed, message, code = relight.of(name, p, o)
  if not changed then return nil, message, code end
  devices.of(o.device):check_picture(name, o)
  report, message, code = coefficients.begin(name, changed, o)
  if not report then return nil, message, code end
  for _, sentence in ipairs(unmet.warn(o.grid)) do report.warnings[#report.warnings + 1] = sentence end
  ok, message, code = gloss.ready(name, changed, o, o.grid)
  if not ok then return nil, message, code end
  o.shade = dering.shade
  return changed, report
end

--- The writer of a picture, function(layer), which completes the report: the device shades and filters in one.
function grid.radiance(name, p, o, report)
  local device, bar = devices.of(o.device), progress.resolve(o.progress)
  return function(layer)
    local done, message, code = device:picture(name, p, o, layer, bar, pictures.compose)
    if not done then return nil, message, code end
    report.outside, report.unbaked, report.stages = done.outside, done.unbaked, done.stages
    dering.report(p, o, report, done.dering or dering.of_device(o, layer))
    report.pairs, report.fresh, report.seconds.light = done.pairs, done.fresh, done.seconds
    return true
  end
end

function grid.report(p, o, report, image, before)
  coefficients.finish(p, o, report, core.type(image) == "ylm.image" and before or nil)
  if core.type(image) ~= "ylm.image" then return end
  local g, kind = o.grid, core.type(o.grid)
  local stats = type(g.stats) == "table" and g.stats or {}
  pictures.sign(image, p, "grid", report, { interpolation = o.interpolation, grid = kind == "ylm.grid" and tostring(g) or kind,
    tolerance = g.tolerance, threshold = g.threshold, grid_points = stats.points, outside = report.outside,
    unbaked = report.unbaked, device = devices.of(o.device):name() })
end

--- The radiance of a prepared view's shading points under o.grid, and a report; or nil, message, code.
function grid.points(name, p, o)
  views.check_grid(name, o.grid)
  o.weight = visibility.weight(name, p, o.grid)
  if o.method == "zonal" then
    return check.fail("%s: zonal lobes are summed lamp by lamp, without a grid: by = 'sum', method = 'zonal'", name)
  end
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

return grid
