--- Direct light by the sum of all lights' own coefficients at every shading point, T . L: the reference of grids of lights.

local check = require "ylm.check"
local coefficients = require "ylm.render.coefficients"
local core = require "ylm.c.core"
local gloss = require "ylm.render.gloss"
local light = require "ylm.light"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local relight = require "ylm.render.relight"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"

local sum = { name = "sum", called = 'by = "sum"' }

--- The kind of pictures that a sum is a reference of, for its report.
sum.REFERENCE = "of grids under transfer vectors: their pictures without the error of the grid, not the scene's true shadows"

sum.options = options.list({ options.light_samples, options.dtype_field, options.sums_field, options.lights_field },
  relight.method_fields, options.bounce_fields)
sum.scene_options = options.list(options.view_fields, options.shading_fields, { options.visibility_of_sum },
  options.vector_fields, { options.lmax_field }, gloss.fields)

function sum.wants() return false end

function sum.settle(name, s, o, given)
  visibility.settle(name, o, given or {}, "transfer")
  gloss.settle(name, o, given, s, "lights")
  o.lmax = o.lmax or views.default_lmax(s)
end

--- The lights that are summed: those of o.lights, else the scene's; nil, message, code.
local function lights_for(name, p, o)
  if o.lights == nil then return p.traced.lights end
  if o.method == "zonal" then
    return check.bad(1, name, "lights: method = 'zonal' is of the scene's own lights: leave one out")
  end
  local given, message, code = light.field(1, name, o.lights)
  if not given then return nil, message, code end
  if core.field_quantity(given) == "visibility" then return check.bad(1, name, "lights: a visibility is no light") end
  return given
end

function sum.prepare(name, p, o)
  visibility.need_transfer(name, p)
  o.weight = "transfer"
  local changed, message, code = relight.of(name, p, o)
  if not changed then return nil, message, code end
  local report, ok
  report, message, code = coefficients.begin(name, changed, o)
  if not report then return nil, message, code end
  report.reference = sum.REFERENCE
  o.summed, message, code = lights_for(name, changed, o)
  if not o.summed then return nil, message, code end
  ok, message, code = gloss.ready(name, changed, o, o.summed)
  if not ok then return nil, message, code end
  return changed, report
end

function sum.radiance(name, p, o, report)
  local start, tally = core.seconds(), light.tally(o.summed)
  local lights, message, code = light.within(name, o.summed, o.sums_tolerance, o.threads)
  if not lights then return nil, message, code end
  local radiance, pairs
  radiance, pairs, code = check.result(name, p.lib.shade_field(p.view, lights, o.weight, o.dtype, o.threads or 0,
    progress.resolve(o.progress)))
  if not radiance then return nil, pairs, code end
  if o.method == "zonal" then
    local ok
    ok, message, code = relight.zonal(name, p, o, radiance)
    if not ok then return nil, message, code end
  end
  report.pairs, report.shadow = pairs, tally()
  for _, sentence in ipairs(light.heed(o.summed, p.options.lmax)) do report.warnings[#report.warnings + 1] = sentence end
  return radiance, core.seconds() - start
end

function sum.report(p, o, report, image, before)
  coefficients.finish(p, o, report, before)
  pictures.sign(image, p, "sum", report, { dtype = o.dtype, sums_tolerance = o.sums_tolerance,
    pairs = ("%.0f"):format(report.pairs) })
end

return sum
