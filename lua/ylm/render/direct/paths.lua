--- The path tracer: pictures with light of any number of reflections, and the light that arrives at points.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local display = require "ylm.display"
local form = require "ylm.form"
local image = require "ylm.image"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local show = require "ylm.show"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local paths = {}

local BATCH, MOST_SAMPLES = core.limits.path_batch, core.limits.path_samples
local MOST_ORDER = 2 ^ 30
local VIEW_SAMPLES = 16 -- of the layers beside the radiance, at most

-- Options ------------------------------------------------------------------------------

local function is_order(x) return check.is_integer(x) and x >= 0 and x <= MOST_ORDER end

function form.types.bounces(x)
  if x == "all" or is_order(x) then return x end
  return nil, "a number of reflections after direct light, 0, 1, 2 .., or 'all'"
end

--- { first, last }, last "all" for no end; comes out with -1 for that.
function form.types.reflections(x)
  if type(x) == "table" and #x == 2 and is_order(x[1]) then
    if x[2] == "all" or x[2] == math.huge then return { x[1], -1 } end
    if is_order(x[2]) and x[2] >= x[1] then return { x[1], x[2] } end
  end
  return nil, "{ first, last }, first <= last, from 0 on, last also 'all'"
end

local estimate = {
  { "bounces", "bounces", optional = true,
    about = "reflections after direct light: 0 is direct light alone; default 'all', until they end by themselves" },
  { "strategy", "choice", of = { "both", "lights", "material" }, default = "both",
    about = "rays that find light: to lamps and by material, weighed by the balance heuristic; or one kind alone, to compare" },
  { "error", "number", above = 0, optional = true, about = "ends once the noise, report.noise, is at most this" },
  { "seconds", "number", above = 0, optional = true, unit = "s", about = "ends after so long, which makes results depend on it" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
}

local pathtrace_options = options.list({
  options.view_fields[1],
  { "samples", "integer", min = 1, max = MOST_SAMPLES, default = 256,
    about = "camera rays per pixel, in batches of 16, of which there are two at least" },
  { "reflections", "reflections", optional = true,
    about = "instead of bounces, { first, last }: 0 lamps that are seen, 1 direct light, 2 the first bounce; last also 'all'" },
}, estimate, {
  { "resume", "object", of = "ylm.image", optional = true,
    about = "an image of an earlier call, or loaded from its .exr, of the same scene with the same options but for samples: "
      .. "goes on from there" },
}, options.layer_fields, display.fields, options.common)

local probe_options = options.list({
  { "points", "any", about = "array [n][3] or list: where light arrives, scene units" },
  { "normals", "any", optional = true, about = "array [n][3] or list: asks for the irradiance of surfaces instead" },
  { "lmax", "integer", min = 0, max = core.limits.path_lmax, default = 4, about = "highest degree" },
  { "samples", "integer", min = 1, max = MOST_SAMPLES, default = 4096,
    about = "paths from each point, in batches of 16, of which there are two at least" },
  { "reflections", "reflections", optional = true,
    about = "instead of bounces, { first, last }: 0 straight from lamps, 1 the first bounce; last also 'all'" },
}, estimate, options.common)

--- The orders that options ask for, first and last or -1; `direct`: of direct light.
local function orders(name, o, direct)
  if o.bounces and o.reflections then
    return check.bad(1, name, "bounces and reflections say the same: leave one out")
  end
  if o.reflections then return o.reflections[1], o.reflections[2] end
  if o.bounces == nil or o.bounces == "all" then return 0, -1 end
  return 0, o.bounces + direct
end

-- Pictures -----------------------------------------------------------------------------

--- All that an image that goes on must have in common, as its metadata say it.
local function identity(s, p, o, first, last)
  local c, b, numbers = s.camera, s.background or { 0, 0, 0 }, {}
  local geometry, materials, lights = p.lib.scene_print(p.traced.handle)
  for _, v in ipairs { c.from, c.at, c.up, { c.fov } } do
    for _, x in ipairs(v) do numbers[#numbers + 1] = ("%.9g"):format(x) end
  end
  return { method = "pathtrace", scene = s.name or "", seed = ("%.17g"):format(o.seed), strategy = o.strategy,
    reflections = ("%d %s"):format(first, last < 0 and "all" or ("%d"):format(last)), camera = table.concat(numbers, " "),
    ["print.geometry"] = geometry, ["print.materials"] = materials, ["print.lights"] = lights,
    background = ("%.9g %.9g %.9g"):format(b[1], b[2], b[3]) }
end

--- Raises where an image that goes on has the fingerprints of another scene; says where it has none.
local function check_prints(s, texts, known)
  local bare = {}
  for _, part in ipairs { "geometry", "materials", "lights" } do
    local print = texts["print." .. part]
    if print and print ~= known["print." .. part] then
      return check.fail("pathtrace: resume: the image was made with other %s than scene %q has now: give the scene as it was, "
        .. "or begin anew", part, s.name or "?")
    end
    if not print then bare[#bare + 1] = part end
  end
  if texts.background and texts.background ~= known.background then
    return check.fail("pathtrace: resume: the image's background is '%s', this is '%s'", check.short(texts.background),
      known.background)
  end
  if #bare > 0 then
    warning.say(s, "resume", "pathtrace: resume: the image has no fingerprint of its %s: whether they are those of scene %q is "
      .. "not known", table.concat(bare, ", "), s.name or "?")
  end
end

--- Raises unless image `from` can go on as options ask; the samples it has.
local function check_resumed(s, from, o, known)
  local _, channels = from:layers()
  for _, layer in ipairs { "radiance", "radiance_rest", "variance" } do
    if channels[layer] ~= 3 then
      return check.fail("pathtrace: resume: the image has no layer %s of 3 channels, as images of pathtrace have", layer)
    end
  end
  if from.size[1] ~= o.size[1] or from.size[2] ~= o.size[2] then
    return check.fail("pathtrace: resume: an image of %dx%d expected, got %dx%d", o.size[1], o.size[2], from.size[1],
      from.size[2])
  end
  local texts = from.metadata()
  for _, key in ipairs { "method", "scene", "camera", "seed", "strategy", "reflections" } do
    if texts[key] ~= known[key] then
      return check.fail("pathtrace: resume: the image's %s is '%s', this is '%s'", key, check.short(texts[key] or ""),
        check.short(known[key]))
    end
  end
  check_prints(s, texts, known)
  local samples = tonumber(texts.samples)
  if not samples or samples % BATCH ~= 0 or not (samples >= 0 and samples <= MOST_SAMPLES) then
    return check.fail("pathtrace: resume: the image's samples are '%s', a multiple of %d expected",
      check.short(texts.samples or ""), BATCH)
  end
  return samples
end

--- The image that paths are added to, with what image o.resume holds; or nil, message, code.
local function canvas(lib, o)
  local out, message, code = image.image { size = o.size,
    layers = { { "radiance", 3 }, { "variance", 3 }, { "samples", 1 }, { "radiance_rest", 3 } } }
  if not out then return nil, message, code end
  if o.resume then
    for _, layer in ipairs { "radiance", "variance", "radiance_rest" } do
      check.result("pathtrace", lib.path_copy(o.resume:layer(layer), out:layer(layer)))
    end
  end
  return out
end

local function add_stats(report, stats)
  report.samples, report.noise, report.ended = stats.samples, stats.noise, stats.ended
  report.absorbed, report.lost, report.paths = stats.absorbed, stats.lost, stats.paths
  report.rays = { primary = report.rays and report.rays.primary, nearest = stats.nearest, lamps = stats.lamps,
    shadow = stats.shadow }
end

--- Where nothing can shine, the sentence that says so.
local function darkness(s)
  if #s.lights == 0 then return ("scene %q has no lights: no light arrives anywhere"):format(s.name or "?") end
end

--- Fields of reports about paths.
local report_text = "samples (whole batches); noise: the mean over pixels (points) of the standard error relative to the value; "
  .. "ended: 'samples', 'error' or 'seconds'; paths; rays: nearest, lamps, shadow; absorbed: paths that normals of vertices "
  .. "sent below a surface; lost: contributions that were no finite numbers; note where there are no lights"

describe "scene:pathtrace" {
  about = "Renders a scene by paths of any length: an unbiased picture, with its variance, that judges all others.",
  arguments = { { "options?", "table", "" } },
  options = pathtrace_options,
  returns = {
    { "image", "image", "radiance; variance, of these means; samples; radiance_rest, what floats cut off, to go on from" },
    { "report", "table", options.report_text .. report_text },
  },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local image, report = scene:pathtrace { size = { 32, 18 }, samples = 32, bounces = 1 }
assert(image:layer "variance" and report.noise < 1)
local finer = scene:pathtrace { size = { 32, 18 }, samples = 64, bounces = 1, resume = image }
assert(finer.metadata.samples == "64")]],
  source = "Kajiya 1986; Veach & Guibas 1995",
}
function paths.pathtrace(s, given)
  tracing.check_scene("pathtrace", s)
  local o = form.options(1, "pathtrace", pathtrace_options, given)
  o.progress = progress.long(o.progress)
  local first, last = orders("pathtrace", o, 1)
  local view, message, code = views.prepare("pathtrace", s, { size = o.size, samples = math.min(o.samples, VIEW_SAMPLES),
    seed = o.seed, share = 1.5, shading = "pixel", visibility = "rays", lmax = 0, threads = o.threads })
  if not view then return nil, message, code end
  local p = views.open("pathtrace", view)
  tracing.check_bodies("pathtrace", p.traced)
  pictures.check_truth("pathtrace", p, o)
  local known = identity(s, p, o, first, last)
  local done = o.resume and check_resumed(s, o.resume, o, known) or 0
  local start, report = core.seconds(), pictures.new_report(p)
  report.note = darkness(s) or report.note
  local out
  out, message, code = canvas(p.lib, o)
  if not out then return nil, message, code end
  local live, bar = display.begin(s, o, "pathtrace"), progress.resolve(o.progress)
  if live then
    bar = live.progress(bar, function() return { display.layer_of(out, "radiance", 3, true) } end)
  end
  local stats
  stats, message, code = check.result("pathtrace", p.lib.path_image(p.traced.handle, {
    camera = views.camera_numbers(s), width = o.size[1], height = o.size[2], background = s.background or { 0, 0, 0 },
    mean = out:layer "radiance", rest = out:layer "radiance_rest", variance = out:layer "variance", done = done,
    samples = o.samples, first = first, last = last, strategy = o.strategy, error = o.error, seconds = o.seconds,
    seed = o.seed, threads = o.threads, progress = bar }))
  if not stats then return nil, message, code end
  out:fill(1, 1, o.size[1], o.size[2], stats.samples, { layer = "samples" })
  local ok
  ok, message, code = pictures.picture("pathtrace", p, function() return true end, { out = out, layers = o.layers,
    truth = o.truth, threads = o.threads })
  if not ok then return nil, message, code end
  add_stats(report, stats)
  pictures.finish(report, start, stats.seconds)
  pictures.sign(out, p, "pathtrace", report, { noise = stats.noise and ("%.4g"):format(stats.noise) })
  known.samples = ("%.0f"):format(stats.samples)
  for key, value in pairs(known) do out.metadata[key] = value end
  if live then live.finish(out, report) end
  view:close()
  return out, report
end

-- Probes -------------------------------------------------------------------------------

describe "scene:probe" {
  about = "The light that arrives at points, by paths: what grids and probes are judged by.",
  arguments = { { "options", "table", "points are needed" } },
  options = probe_options,
  returns = {
    { "c", "array", "double [n][3][(lmax+1)^2], coefficients of the radiance that arrives; with normals the irradiance [n][3]" },
    { "variance", "array", "of these means, of the same shape" },
    { "report", "table", report_text .. "; seconds" },
  },
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local c, variance, report = scene:probe { points = { { 0, 0.5, 1 } }, lmax = 2, samples = 256 }
assert(c.shape[3] == 9 and variance:get(1, 1, 1) > 0 and report.samples == 256)
local E = scene:probe { points = { { 0, 0, 1 } }, normals = { { 0, 1, 0 } }, samples = 256, bounces = 0 }
assert(E:get(1, 1) > 0)]],
  source = "Kajiya 1986; Veach & Guibas 1995",
}
function paths.probe(s, given)
  tracing.check_scene("probe", s)
  local o = form.options(1, "probe", probe_options, given)
  o.progress = progress.long(o.progress)
  local first, last = orders("probe", o, 0)
  local points, normals = array.places(1, "probe", o.points), nil
  if o.normals then
    normals = array.rows(1, "probe", "normals", o.normals, 3, "float")
    if #normals ~= #points or #normals.shape ~= #points.shape and #points > 1 then
      return check.bad(1, "probe", "normals: one for each of %d points expected, got %d", #points, #normals)
    end
  end
  local t, message, code = tracing.trace("probe", s)
  if not t then return nil, message, code end
  tracing.check_bodies("probe", t)
  local c, variance, stats = check.result("probe", t.lib.path_probe(t.handle, {
    points = points, normals = normals, lmax = o.lmax, samples = o.samples, first = first, last = last,
    strategy = o.strategy, error = o.error, seconds = o.seconds, seed = o.seed, threads = o.threads,
    progress = progress.resolve(o.progress) }))
  if not c then return nil, variance, stats end
  local report = show.report { note = darkness(s), seconds = stats.seconds }
  add_stats(report, stats)
  return c, variance, report
end

return paths
