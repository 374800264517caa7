--- Pictures of scenes: what bake, prepare, render, reference and raycast of a scene do.

require "ylm.render.prepared" -- the methods of what prepare returns
local array = require "ylm.array"
local ambient = require "ylm.render.ambient"
local baking = require "ylm.render.bake"
local check = require "ylm.check"
local dering = require "ylm.render.dering"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local display = require "ylm.display"
local gloss = require "ylm.render.gloss"
local indirect = require "ylm.render.indirect"
local knob = require "ylm.render.knob"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local paths = require "ylm.render.path"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local relight = require "ylm.render.relight"
local shading = require "ylm.render.shade"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"

local render = { bake = baking.bake, true_error = pictures.true_error, pathtrace = paths.pathtrace, probe = paths.probe }

local prepare_options = options.list(options.view_fields, {
  { "camera", "object", of = "camera", optional = true,
    about = "another one than the scene's; what was traced of the scene is used again" },
}, options.transfer_fields, gloss.fields, relight.prepare_fields,
  indirect.link_fields,
  options.common)

describe "scene:prepare" {
  about = "Traces a camera's rays, and with visibility = 'transfer' the transfer vectors of what they hit, once, for any number "
    .. "of renderings.",
  arguments = { { "options?", "table", "" } },
  options = prepare_options,
  returns = { { "view", "prepared", "view:render, view:reference, view:raycast, view:points, view:layer, view:hit, view:lamp_at; "
    .. "view.stats, .options" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
local image, report = view:render()                           -- by rays to the lamps
assert(image.size[1] == 32 and report.points == view.stats.points)
local papers = scene:prepare { size = { 32, 18 }, samples = 4, visibility = "transfer" }
assert(papers:reference())]],
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
  if not view or not (o.links or o.transfer) then return view, message, code end
  local ok
  ok, message, code = indirect.link("prepare", views.open("prepare", view), o.transfer, o)
  if not ok then return nil, message, code end
  return view
end

local render_options = options.list(options.view_fields, options.transfer_fields, gloss.fields,
  options.grid_fields, dering.fields,
  near.fields, options.direct_fields, indirect.bounce_fields,
  indirect.link_fields, knob.fields, options.baked_fields, ambient.fields,
    options.layer_fields,
  display.fields, options.common)

--- The grid of the scene's probes for what a view sees; or nil, message, code.
local function bake_for(s, view, o)
  if views.made[view].stats.points == 0 then
    return views.made[view].traced.lights -- no grid can be baked for no points; no point will ask what light there is
  end
  return baking.bake(s, { parts = "lights", occupied = view, threads = o.threads, progress = o.progress,
    light_tolerance = o.light_tolerance })
end

--- The picture that keeps a tolerance, and says whether it does.
local function by_tolerance(s, o, given)
  local virtual = o.bounced ~= nil and o.bounced.by == "virtual"
  for _, field in ipairs { "grid", "indirect", "visibility", "device" } do
    if given[field] ~= nil and given[field] ~= "rays" and not (virtual and field == "indirect") then
      return check.fail("render: tolerance chooses how light is found, by rays and links: leave %s out", field)
    end
  end
  if o.ambient or o.ambient_radius then
    return check.fail "render: tolerance is of the scene's light, which ambient is not: leave one out"
  end
  if o.shading == "vertex" then
    return check.fail "render: tolerance is judged at what camera rays hit: shading = 'pixel'"
  end
  local bounces = o.bounces
  if virtual then o.bounces = nil end -- direct light alone is judged
  local found, message, code = knob.choose("render", s, o, given)
  o.bounces = bounces
  if not found then return nil, message, code end
  local c, view = found.chosen
  o.seen, message, code = array.zeros({ o.size[2], o.size[1], 3 }, "float")
  if not o.seen then return nil, message, code end
  o.light_samples, o.links, o.samples, o.share, o.lmax = c.light_samples, c.links, c.samples, c.share, 0
  if virtual then o.bounced.options.tolerance = math.min(o.bounced.options.tolerance, o.tolerance)
  elseif o.bounced then o.bounced.lit, o.transfer = found.lit, nil end
  view, message, code = views.prepare("render", s, o)
  if not view then return nil, message, code end
  local image, report, verdict
  image, report, code = shading.picture("render", views.open("render", view), o)
  if not image then return nil, report, code end
  verdict, message, code = knob.judge(found, o.seen)
  if not verdict then return nil, message, code end
  knob.report(found, verdict, report, image)
  if virtual then
    report.warnings[#report.warnings + 1] = warning.say(s, "tolerance virtual", "scene %q: tolerance is judged in direct light; "
      .. "of virtual lights it bounds the sum (report.virtual.error), not what their number leaves: scene:pathtrace tells",
      s.name or "?")
  end
  return image, report
end

describe "scene:render" {
  about = "Renders a scene: by rays to its lamps, whose shadows are true (no probes are needed), or by a grid. A grid of lights "
    .. "is shaded by transfer vectors, as is the one that visibility = 'transfer' bakes for what the camera sees; the report "
    .. "says how much light of theirs is not the scene's.",
  arguments = { { "options?", "table", "" } },
  options = render_options,
  returns = { { "image", "image", "" }, { "report", "table", options.transfer_text .. "outside, unbaked: shading points" } },
  errors = "raises on a bad option, no camera, visibility = 'transfer' with neither grid nor probes; nil, message, code: memory, "
    .. "cancelled",
  example = options.one_lamp .. [[
local image, report = scene:render { size = { 32, 18 }, samples = 4 }
assert(report.visibility == "rays" and report.rays.shadow > 0)
local grid = scene:bake { probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 } }
image, report = scene:render { grid = grid, size = { 32, 18 }, samples = 4 }
assert(image:layer "level" and report.visibility == "transfer")]],
  source = "Iwasaki & Dobashi 2025, Sec. 6.2",
}
local function rendered(s, o, given)
  if o.grid ~= nil then views.check_grid("render", o.grid) end
  gloss.settle("render", o, given, s, visibility.settle_picture("render", o, given or {}))
  indirect.settle("render", o, s)
  if o.tolerance then return by_tolerance(s, o, given) end
  local probes = o.visibility ~= "rays" and o.grid == nil
  if probes and not s.probes then views.check_grid("render", nil) end
  if o.grid and o.light_tolerance then
    return check.fail "render: light_tolerance is for baking the scene's probes, this grid is baked: leave one out"
  end
  o.lmax = o.lmax or views.default_lmax(s, o.grid)
  local view, message, code = views.prepare("render", s, o)
  if not view then return nil, message, code end
  if probes then
    o.grid, message, code = bake_for(s, view, o)
    if not o.grid then return nil, message, code end
  end
  local p = views.open("render", view)
  local ok
  ok, message, code = indirect.relight("render", p, o)
  if not ok then return nil, message, code end
  return shading.picture("render", p, o)
end

--- make() while a viewer shows what it makes.
local function shown(s, o, how, make)
  o.live = display.begin(s, o, how)
  local picture, report, code = make()
  if picture and o.live then o.live.finish(picture, report) end
  return picture, report, code
end

function render.render(s, given)
  tracing.check_scene("render", s)
  local o = form.options(1, "render", render_options, given)
  o.progress = progress.long(o.progress)
  return shown(s, o, "render", function() return rendered(s, o, given) end)
end

local reference_options = options.list(options.view_fields, options.transfer_fields, gloss.fields, options.reference_fields,
  gloss.ray_fields, relight.method_fields, options.layer_fields, options.common)

describe "scene:reference" {
  about = "The reference of pictures by grids of lights, T . L: what an exact grid under transfer vectors would give. "
    .. "The lights' coefficients are summed at every shading point; visibility is 'transfer' or 'none'. It is no reference of "
    .. "the scene's shadows and bounces: these are those of scene:render, scene:raycast and scene:pathtrace.",
  arguments = { { "options?", "table", "" } },
  options = reference_options,
  returns = { { "image", "image", "" }, { "report", "table", "reference (of what it is one), " .. options.transfer_text
    .. "pairs: light x point evaluations" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. "assert(scene:reference { size = { 32, 18 }, samples = 4 })",
}
function render.reference(s, given)
  tracing.check_scene("reference", s)
  local o = form.options(1, "reference", reference_options, given)
  o.progress = progress.long(o.progress)
  visibility.settle("reference", o, given or {}, "transfer")
  gloss.settle("reference", o, given, s, "lights")
  if o.visibility == "rays" then
    return check.fail 'reference: it is T . L, visibility = "transfer" or "none": rays to the lamps are scene:render\'s'
  end
  o.lmax = o.lmax or views.default_lmax(s)
  local view, message, code = views.prepare("reference", s, o)
  if not view then return nil, message, code end
  return shading.by_lights("reference", views.open("reference", view), o)
end

local raycast_options = options.list(options.view_fields, options.ray_fields, options.noise_fields, options.layer_fields,
  display.fields, options.common)

describe "scene:raycast" {
  about = "Renders a scene by rays to the lamps, chosen by what they would bring: what spherical harmonics lose shows.",
  arguments = { { "options?", "table", "" } },
  options = raycast_options,
  returns = { { "image", "image", "" }, { "report", "table", options.report_text .. "rays.shadow" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = options.one_lamp .. "assert(scene:raycast { size = { 32, 18 }, samples = 4, light_samples = 8 })",
  source = "Shirley, Wang, Zimmerman 1996",
}
function render.raycast(s, given)
  tracing.check_scene("raycast", s)
  local o = form.options(1, "raycast", raycast_options, given)
  o.progress = progress.long(o.progress)
  o.lmax, o.shading, o.visibility = 0, "pixel", "rays"
  if o.variance then o.samples = math.max(1, math.floor(o.samples / shading.BATCHES + 0.5)) end
  local view, message, code = views.prepare("raycast", s, o)
  if not view then return nil, message, code end
  local image, report
  local function cast(picked)
    return shading.by_rays("raycast", views.open("raycast", picked), o)
  end
  image, report, code = shown(s, o, "raycast", function()
    if o.variance then return shading.in_batches("raycast", s, view, o, cast) end
    return cast(view)
  end)
  if not image then return nil, report, code end
  return image, report
end

return render
