--- Direct light by rays to the lamps, whose shadows are true.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local display = require "ylm.display"
local gloss = require "ylm.render.gloss"
local images = require "ylm.image"
local knob = require "ylm.render.knob"
local material = require "ylm.material"
local noises = require "ylm.render.noise"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local rounds = require "ylm.render.rounds"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"

local rays = { name = "rays", called = 'by = "rays"' }

local BATCHES = 16 -- pictures that variance is that of

rays.options = options.list({ options.light_samples, options.visibility_of_rays, options.guides }, options.bounce_fields)
rays.scene_options = options.list(options.view_fields, options.shading_fields, gloss.fields, knob.fields, rounds.fields, {
  { "variance", "boolean", default = false, shelf = "experiments",
    about = "samples are cast as 16 pictures with random numbers of their own, one camera ray each at least: their mean, and "
      .. "the layer variance, that of it. Light on elements is the same in all" },
})
rays.view_options = { options.lights_field, options.seed_field }

function rays.wants() return true end

function rays.settle(name, s, o, given)
  o.shadows, o.visibility = o.visibility ~= "none", "rays"
  gloss.settle(name, o, given, s, false)
  o.lmax = views.default_lmax(s)
end

--- Do all surfaces send the same radiance in every direction?
local function is_matte(s)
  for _, g in ipairs(s.geometry) do
    if g.material and material.glossy(g.material) then return false end
  end
  return true
end

--- Raises where rays cannot shade the view p.
function rays.check(name, p)
  tracing.check_bodies(name, p.traced)
  if p.options.shading == "vertices" and not is_matte(p.scene) then
    return check.fail("%s: surfaces that are not matte are ray-cast from pixels: shading = 'pixel' in scene:prepare", name)
  end
end

function rays.prepare(_, p, o)
  if o.shadows == nil then o.shadows = o.visibility ~= "none" end
  o.light_samples = o.light_samples
    or math.min(core.limits.light_samples, math.floor(options.LIGHT_SAMPLES * options.multiple(p.options)))
  local report = pictures.new_report(p)
  report.visibility = o.shadows and "rays" or "none"
  report.light_samples = o.light_samples
  report.gloss = p.traced.glossy > 0 and "rays" or nil
  return p, report
end

--- For pictures that a viewer shows during the work: the array that rays fill, the progress that sends it, and a function that
-- sends it now, with a report.
local function live_rays(name, p, o)
  local bar = progress.resolve(o.progress)
  if not o.live then return nil, bar end
  local so_far = array.zeros({ p.stats.points, 3 }, "float")
  local sketch = images.image { size = p.options.size }
  local function picture()
    assert(check.result(name, p.lib.shade_compose(p.view, so_far, p.scene.background or { 0, 0, 0 }, o.threads or 0,
      sketch:layer "radiance")))
    return { display.layer_of(sketch, "radiance", 3, true) }, sketch
  end
  return so_far, o.live.progress(bar, picture), function(report) o.live.now(picture, report) end
end

--- The guide of a picture's rays, nil where none is wanted or there is nothing to guide; or false, message, code.
local function guide_of(name, p, o, casting, report)
  if not o.guides or not o.shadows then return nil end
  if o.halves and not o.by_hand then casting.light_samples = rounds.guided(p) end
  local guide, stats, code = check.result(name, p.lib.shade_guide(p.view, casting))
  if guide == nil then return false, stats, code end
  if not guide then return nil end
  report.guides, report.rays.guides = stats.clusters, stats.rays
  return guide
end

function rays.radiance(name, p, o, report)
  local start = core.seconds()
  local so_far, bar, now = live_rays(name, p, o)
  local casting = { light_samples = o.light_samples, shadows = o.shadows, seed = o.seed or p.options.seed,
    threads = o.threads or 0, progress = bar, lit = o.lit and o.lit.handle, into = so_far }
  local radiance, count, code
  casting.guide, count, code = guide_of(name, p, o, casting, report)
  if casting.guide == false then return nil, count, code end
  if o.halves then return rounds.radiance(name, p, o, report, casting, now) end
  radiance, count, code = check.result(name, p.lib.shade_raycast(p.view, casting))
  if not radiance then return nil, count, code end
  local seconds = core.seconds() - start
  report.rays.shadow = count
  casting.progress = nil
  local noise, message
  noise, message, code = check.result(name, p.lib.shade_raycast_noise(p.view, radiance, casting))
  if not noise then return nil, message, code end
  report.direct_noise = noise
  if not o.tolerance then noises.say_direct(p, report, o.light_samples) end
  return radiance, seconds
end

function rays.report(p, o, report, image)
  if o.halves then rounds.report(p, o, report, image) end
  pictures.sign(image, p, "rays", report, { light_samples = o.light_samples, shadows = o.shadows })
end

-- Pictures of more than one view -----------------------------------------------------------------

--- Adds layers `variance`, `samples` to the first of BATCHES pictures by how(), whose radiance becomes their mean. Those
-- behind the first are made with the next seeds.
local function in_batches(o, how)
  o.samples = math.max(1, math.floor(o.samples / BATCHES + 0.5))
  local image, report, code = how()
  if not image then return nil, report, code end
  local lib, first, layers = tracing.library(), o.seed, o.layers
  local mean, variance = image:layer "radiance", image:add("variance", 3)
  local rest = array.zeros({ o.size[2], o.size[1], 3 }, "float")
  local done, seconds = lib.path_add(mean, mean, rest, variance, 0), report.seconds
  o.layers = false
  for k = 2, BATCHES do
    o.seed = first + k - 1
    local other, facts
    other, facts, code = how()
    if not other then return nil, facts, code end
    done = lib.path_add(other:layer "radiance", mean, rest, variance, done)
    for kind, n in pairs(facts.rays) do report.rays[kind] = report.rays[kind] + n end
    for stage, x in pairs(facts.seconds) do seconds[stage] = (seconds[stage] or 0) + x end
  end
  o.seed, o.layers = first, layers
  image:add("samples", 1)
  image:fill(1, 1, o.size[1], o.size[2], o.samples * BATCHES, { layer = "samples" })
  image.metadata.samples, image.metadata.batches = o.samples * BATCHES, BATCHES
  return image, report
end

function rays.make(name, s, o, given, how)
  rounds.check(name, o, given)
  local ok, message, code = rounds.ready(name, o)
  if not ok then return nil, message, code end
  if not o.tolerance then
    if o.variance then return in_batches(o, how) end
    return how()
  end
  if o.variance then
    return check.fail("%s: variance is of samples that are given, tolerance chooses them: leave one out", name)
  end
  return knob.picture(name, s, o, given, how)
end

return rays
