--- Pictures of scenes: what bake, prepare, render, pathtrace and probe of a scene do.

require "ylm.render.prepared" -- the methods of what prepare returns
local baking = require "ylm.render.bake"
local bounces = require "ylm.render.bounces"
local choose = require "ylm.render.choose"
local describe = require "ylm.describe".describe
local display = require "ylm.display"
local form = require "ylm.form"
local gloss = require "ylm.render.gloss"
local judge = require "ylm.render.judge"
local lightmaps = require "ylm.render.lightmap"
local links = require "ylm.render.bounced.links"
local make = require "ylm.render.make"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local probes = require "ylm.render.probe"
local progress = require "ylm.progress"
local relight = require "ylm.render.relight"
local reports = require "ylm.render.reports"
local surfaces = require "ylm.render.surfaces"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"

local render = { bake = baking.bake, surface_grid = surfaces.surface_grid, lightmap = lightmaps.lightmap,
  true_error = pictures.true_error, probe = probes.probe, judge = judge.judge }

local prepare_options = options.list(options.view_fields, {
  { "camera", "object", of = "camera", optional = true,
    about = "another one than the scene's; what was traced of the scene is used again" },
}, options.prepare_fields, gloss.fields, relight.prepare_fields,
  links.prepare_fields,
  options.common)

describe "scene:prepare" {
  shelf = "everyday",
  about = "Traces a camera's rays, and with visibility = 'transfer' the transfer vectors of what they hit, once, for any number "
    .. "of renderings.",
  arguments = { { "options?", "table", "" } },
  options = prepare_options,
  returns = { { "view", "view", "view:render, view:points, view:layer, view:hit, view:lamp_at; view.stats, .options" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
local image, report = view:render()                           -- by rays to the lamps
assert(image.size[1] == 32 and report.points == view.stats.points)
local papers = scene:prepare { size = { 32, 18 }, samples = 4, visibility = "transfer" }
assert(papers:render { by = "sum" })]],
  source = "Iwasaki & Dobashi 2025, Sec. 6.2",
}
function render.prepare(s, given)
  tracing.check_scene("prepare", s)
  local o = form.options(1, "prepare", prepare_options, given)
  o.progress = progress.long(o.progress)
  relight.settle("prepare", o, given or {})
  visibility.settle("prepare", o, given or {}, o.relight and "transfer" or "rays")
  gloss.settle("prepare", o, given, s)
  o.lmax = o.lmax or views.default_lmax(s)
  local view, message, code = views.prepare("prepare", s, o)
  if not view or not (o.rays or o.links) then return view, message, code end
  local ok
  ok, message, code = links.link("prepare", views.open("prepare", view), o.links, o)
  if not ok then return nil, message, code end
  return view
end

--- Options of every picture of a scene.
local last = options.list(options.layer_fields, display.fields, options.common)

local render_options = choose.fields("scene", { choose.by("rays", "grid", "sum", "paths"), options.view_fields[1],
  options.view_fields[3] }, last, choose.direct, choose.bounced, choose.over)
local render_common = options.names({ render_options[1] }, last)

local pathtrace_options = options.list(choose.direct.paths.scene_options, last)

--- make() while a viewer shows what it makes, or one that o.live already is.
local function shown(s, o, how, make_it)
  o.live = o.live or display.begin(s, o, how)
  local picture, report, code = make_it()
  if picture and o.live then o.live.finish(picture, report) end
  return picture, report, code
end

--- The picture of a scene by ways that are chosen, and its report; or nil, message, code.
local function picture(name, s, o, given)
  local function how()
    local view, message, code = views.prepare(name, s, o)
    if not view then return nil, message, code end
    local p, ok = views.open(name, view), true
    if not o.tolerance then ok, message, code = bounces.relight(name, p, o) end
    if not ok then return nil, message, code end
    local image, report
    image, report, code = make.picture(name, p, o)
    if image then view:close() end
    return image, report, code
  end
  return shown(s, o, o.direct.name, function()
    if o.direct.make then return o.direct.make(name, s, o, given, how) end
    return how()
  end)
end

describe "scene:render" {
  shelf = "everyday",
  about = "Renders a scene, by default by rays to its lamps, whose shadows are true, and with all light that bounces: no probes "
    .. "are needed. By a grid, lights are shaded by transfer vectors, as is the grid that visibility = 'transfer' bakes for what "
    .. "the camera sees; the report says how much light of theirs is not the scene's. The sum of all lights is the reference of "
    .. "such pictures; paths judge all others.",
  arguments = { { "options?", "table", "" } },
  options = render_options,
  returns = { { "image", "image", "" }, { "report", "table", reports.text } },
  report = reports.fields,
  errors = "raises on a bad option, an option that the chosen ways have no use for, no camera, by = 'grid' with neither grid nor "
    .. "probes; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local image, report = scene:render { size = { 32, 18 }, samples = 4 }
assert(report.visibility == "rays" and report.rays.shadow > 0 and report.bounces == "all")
local grid = scene:bake { probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 } }
image, report = scene:render { grid = grid, size = { 32, 18 }, samples = 4 }
assert(image:layer "level" and report.visibility == "transfer")
assert(scene:render { by = "sum", size = { 32, 18 }, samples = 4 })]],
  source = "Iwasaki & Dobashi 2025, Sec. 6.2; Shirley, Wang, Zimmerman 1996",
}
function render.render(s, given) return render.watched(s, given) end

--- The links of an element where a picture cuts surfaces itself.
render.LINKS_OF_ELEMENT = links.OWN

--- As scene:render. `watch`: { now(image, report) } is called with the picture of a pilot, which is written again by the next.
function render.watched(s, given, watch)
  tracing.check_scene("render", s)
  local o = form.options(1, "render", render_options, given)
  o.live = watch and display.watch(watch)
  o.progress = progress.long(o.progress)
  o.direct = choose.direct_of(o)
  bounces.settle("render", o, s, true)
  choose.check("render", "scene", render_options, render_common, o, given)
  o.direct.settle("render", s, o, given or {})
  return picture("render", s, o, given or {})
end

describe "scene:pathtrace" {
  shelf = "everyday",
  about = "Renders a scene by paths of any length: an unbiased picture, with its variance, that judges all others. It is "
    .. "scene:render { by = 'paths' }.",
  arguments = { { "options?", "table", "" } },
  options = pathtrace_options,
  returns = {
    { "image", "image", "radiance; variance, of these means; samples; radiance_rest, what floats cut off, to go on from" },
    { "report", "table", reports.text },
  },
  report = reports.fields,
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local image, report = scene:pathtrace { size = { 32, 18 }, samples = 32, bounces = 1 }
assert(image:layer "variance" and report.noise < 1)
local finer = scene:pathtrace { size = { 32, 18 }, samples = 64, bounces = 1, resume = image }
assert(finer.metadata.samples == "64")]],
  source = "Kajiya 1986; Veach & Guibas 1995",
}
function render.pathtrace(s, given)
  tracing.check_scene("pathtrace", s)
  local o = form.options(1, "pathtrace", pathtrace_options, given)
  o.progress, o.direct = progress.long(o.progress), choose.direct.paths
  o.direct.settle("pathtrace", s, o)
  return picture("pathtrace", s, o, given or {})
end

return render
