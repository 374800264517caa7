--- Light by paths of any length: unbiased pictures, with their variance, that judge all others.

local check = require "ylm.check"
local core = require "ylm.c.core"
local display = require "ylm.display"
local estimates = require "ylm.render.estimates"
local image = require "ylm.image"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local paths = { name = "paths", called = 'by = "paths"', alone = true, MOST_SAMPLES = estimates.MOST_SAMPLES }

local BATCH, MOST_SAMPLES = core.limits.path_batch, estimates.MOST_SAMPLES
local VIEW_SAMPLES = 16 -- of the layers beside the radiance, at most

paths.options = {}
paths.scene_options = options.list({
  options.view_fields[1],
  { "samples", "integer", min = 1, max = MOST_SAMPLES, default = 256,
    about = "camera rays per pixel, in batches of 16, of which there are two at least" },
  options.view_fields[3],
  { "reflections", "reflections", optional = true, shelf = "experiments",
    about = "by paths, instead of bounces, { first, last }: 0 lamps that are seen, 1 direct light, 2 the first bounce; last also "
      .. "'all'" },
  options.guides,
}, estimates.options, {
  { "resume", "object", of = "ylm.image", optional = true, shelf = "experiments",
    about = "by paths: an image of an earlier call, or loaded from its .exr, of the same scene with the same options but for "
      .. "samples: goes on from there" },
})

function paths.wants() return false end

--- All that an image that goes on must have in common, as its metadata say it.
local function identity(s, p, o, first, last)
  local c, b, numbers = s.camera, s.background or { 0, 0, 0 }, {}
  local geometry, materials, lights = p.lib.scene_print(p.traced.handle)
  for _, v in ipairs { c.from, c.at, c.up, { c.fov } } do
    for _, x in ipairs(v) do numbers[#numbers + 1] = ("%.9g"):format(x) end
  end
  return { method = "paths", scene = s.name or "", seed = ("%.17g"):format(o.seed), strategy = o.strategy,
    reflections = ("%d %s"):format(first, last < 0 and "all" or ("%d"):format(last)), camera = table.concat(numbers, " "),
    guides = o.guides and "pilot" or "none",
    ["print.geometry"] = geometry, ["print.materials"] = materials, ["print.lights"] = lights,
    background = ("%.9g %.9g %.9g"):format(b[1], b[2], b[3]) }
end

--- Raises where an image that goes on has the fingerprints of another scene; says where it has none.
local function check_prints(name, s, texts, known)
  local bare = {}
  for _, part in ipairs { "geometry", "materials", "lights" } do
    local print = texts["print." .. part]
    if print and print ~= known["print." .. part] then
      return check.fail("%s: resume: the image was made with other %s than scene %q has now: give the scene as it was, "
        .. "or begin anew", name, part, s.name or "?")
    end
    if not print then bare[#bare + 1] = part end
  end
  if texts.background and texts.background ~= known.background then
    return check.fail("%s: resume: the image's background is '%s', this is '%s'", name, check.short(texts.background),
      known.background)
  end
  if #bare > 0 then
    warning.say(s, "resume", "%s: resume: the image has no fingerprint of its %s: whether they are those of scene %q is "
      .. "not known", name, table.concat(bare, ", "), s.name or "?")
  end
end

--- Raises unless image `from` can go on as options ask; the samples it has.
local function check_resumed(name, s, from, o, known)
  local _, channels = from:layers()
  for _, layer in ipairs { "radiance", "radiance_rest", "variance" } do
    if channels[layer] ~= 3 then
      return check.fail("%s: resume: the image has no layer %s of 3 channels, as images of pathtrace have", name, layer)
    end
  end
  if from.size[1] ~= o.size[1] or from.size[2] ~= o.size[2] then
    return check.fail("%s: resume: an image of %dx%d expected, got %dx%d", name, o.size[1], o.size[2], from.size[1],
      from.size[2])
  end
  local texts = from.metadata()
  for _, key in ipairs { "method", "scene", "camera", "seed", "strategy", "reflections", "guides" } do
    local had = texts[key] or key == "guides" and "none" or ""
    if had ~= known[key] then
      return check.fail("%s: resume: the image's %s is '%s', this is '%s'", name, key, check.short(had), check.short(known[key]))
    end
  end
  check_prints(name, s, texts, known)
  local samples = tonumber(texts.samples)
  if not samples or samples % BATCH ~= 0 or not (samples >= 0 and samples <= MOST_SAMPLES) then
    return check.fail("%s: resume: the image's samples are '%s', a multiple of %d expected", name,
      check.short(texts.samples or ""), BATCH)
  end
  return samples
end

--- The image that paths are added to, with what image o.resume holds; or nil, message, code.
local function canvas(name, lib, o)
  local out, message, code = image.image { size = o.size,
    layers = { { "radiance", 3 }, { "variance", 3 }, { "samples", 1 }, { "radiance_rest", 3 } } }
  if not out then return nil, message, code end
  if o.resume then
    for _, layer in ipairs { "radiance", "variance", "radiance_rest" } do
      check.result(name, lib.path_copy(o.resume:layer(layer), out:layer(layer)))
    end
  end
  return out
end

function paths.settle(_, _, o)
  o.taken = { samples = o.samples }
  o.samples, o.share, o.shading, o.visibility, o.lmax = math.min(o.samples, VIEW_SAMPLES), 1.5, "pixel", "rays", 0
end

function paths.prepare(name, p, o)
  tracing.check_bodies(name, p.traced)
  local x, s, report = o.taken, p.scene, pictures.new_report(p)
  x.first, x.last = estimates.orders(name, o, 1)
  x.known = identity(s, p, o, x.first, x.last)
  x.done = o.resume and check_resumed(name, s, o.resume, o, x.known) or 0
  report.note = estimates.darkness(s) or report.note
  local message, code
  o.out, message, code = canvas(name, p.lib, o)
  if not o.out then return nil, message, code end
  return p, report
end

--- The mean over lit pixels of the root of summed variances over the norm, as C has it.
local function noise_of(out)
  local mean, variance = out:layer "radiance", out:layer "variance"
  local norm, sum = (mean * mean):sum(3), variance:sum(3)
  local lit = norm:not_equal(0)
  local n = lit:sum()
  return n > 0 and ((sum / (norm + (1 - lit))) ^ 0.5 * lit):sum() / n or 0
end

--- Paths until there are enough: their stats; or nil, message, code. An interrupt of the command-line tool, which is raised,
-- leaves what there is, of two batches at least.
local function trace(name, p, o, bar)
  local out, x, s, start = o.out, o.taken, p.scene, core.seconds()
  local fine, stats, message, code = pcall(function()
    return check.result(name, p.lib.path_image(p.traced.handle, {
      camera = views.camera_numbers(s), width = o.size[1], height = o.size[2], background = s.background or { 0, 0, 0 },
      mean = out:layer "radiance", rest = out:layer "radiance_rest", variance = out:layer "variance",
      counts = out:layer "samples", done = x.done, samples = x.samples, first = x.first, last = x.last, strategy = o.strategy,
      error = o.tolerance, seconds = o.time_limit, guides = o.guides, seed = o.seed, threads = o.threads, progress = bar }))
  end)
  if fine then return stats, message, code end
  local samples = out:layer("samples"):get(1, 1, 1)
  if not core.process_interrupted() or not tostring(stats):find("interrupted!", 1, true) or samples < 2 * BATCH then
    error(stats, 0)
  end
  return { samples = samples, noise = noise_of(out), ended = "cancelled", seconds = core.seconds() - start,
    paths = samples * o.size[1] * o.size[2], absorbed = 0, lost = 0, clusters = 0 }
end

--- Writes the layers of o.out by paths.
function paths.radiance(name, p, o, report)
  local out, bar = o.out, progress.resolve(o.progress)
  if o.live then
    bar = o.live.progress(bar, function() return { display.layer_of(out, "radiance", 3, true) } end)
  end
  local stats, message, code = trace(name, p, o, bar)
  if not stats then return nil, message, code end
  o.taken.stats = stats
  estimates.add_stats(report, stats)
  return function() return true end, stats.seconds
end

function paths.report(p, o, report, out)
  local x = o.taken
  pictures.sign(out, p, "paths", report, { noise = x.stats.noise and ("%.4g"):format(x.stats.noise) })
  x.known.samples = ("%.0f"):format(x.stats.samples)
  for key, value in pairs(x.known) do out.metadata[key] = value end
end

return paths
