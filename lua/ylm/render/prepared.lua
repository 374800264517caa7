--- The methods of prepared views.

local ambient = require "ylm.render.ambient"
local bodies = require "ylm.render.bodies"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local gloss = require "ylm.render.gloss"
local indirect = require "ylm.render.indirect"
local memory = require "ylm.memory"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local relight = require "ylm.render.relight"
local shading = require "ylm.render.shade"
local views = require "ylm.render.view"

local prepared = views.methods

local prepared_render = options.list(options.grid_fields, near.fields, options.direct_fields, relight.fields,
  relight.method_fields,
  indirect.bounce_fields, indirect.link_fields, {
  { "lights", "any", optional = true,
    about = "lights that shine instead of the scene's, by rays: they may move; default with indirect = lit: those of lit" },
  { "lamps", "any", optional = true,
    about = "sphere lights to draw that are not in the prepared scene, because they move" },
  { "download", "boolean", default = true,
    about = "false: a picture made on the device stays there, as a gpu_array [height][width][3] of radiance" },
  { "out", "any", optional = true,
    about = "an image of an earlier call, to be written again and returned: its memory is there; "
      .. "with download = false the gpu_array" },
}, bodies.fields, ambient.fields, options.layer_fields, options.common)
local prepared_reference = options.list(options.reference_fields, gloss.ray_fields, relight.method_fields, options.layer_fields,
  options.common)
local prepared_radiance = options.list(options.grid_fields, relight.fields, relight.method_fields, options.common)
local prepared_raycast = options.list(options.ray_fields, {
  { "seed", "integer", min = 0, max = core.limits.seed, optional = true, about = "default: that of the view" },
}, options.layer_fields, options.common)

describe "prepared:render" {
  about = "Shades a prepared view: by a grid, or one that was prepared with visibility = 'rays' by rays to its lamps. "
    .. "report.seconds.light says how long sampling and shading took. Of a grid made with dynamic = true only what grid:update "
    .. "changed since the last time is sampled. A grid of lights needs the view's transfer vectors; others hold their shadows.",
  arguments = { { "options?", "table", "grid is needed where the view has transfer vectors" } },
  options = prepared_render,
  returns = { { "image", "image", "" }, { "report", "table", options.transfer_text .. "outside, unbaked: shading points; "
    .. "of a dynamic grid fresh: those that were sampled; bodies: count, vertices, rays, seconds" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4, visibility = "transfer" }
local lights = ylm.sphere_lights { at = { { 0, 1, 0 } }, radius = 0.1, radiance = 50 }
local image = view:render { grid = lights.lights }     -- anything that has a light field
assert(image:layer "radiance":get(9, 16, 1) > 0)
assert(scene:prepare { size = { 32, 18 } }:render { light_samples = 4 })   -- by rays]],
}
function prepared.render(view, given)
  local p = views.open("render", view)
  local o = form.options(1, "render", prepared_render, given)
  indirect.settle("render", o, p.scene)
  relight.check("render", o)
  bodies.check("render", o)
  local ok, message, code = indirect.relight("render", p, o)
  if not ok then return nil, message, code end
  return shading.picture("render", p, o)
end

describe "prepared:radiance" {
  about = "The radiance of a prepared view's shading points, without a picture: the colours of vertices for who draws them, of "
    .. "views prepared with relight = 'all' those of all vertices (view:points).",
  arguments = { { "options", "table", "grid is needed" } },
  options = prepared_radiance,
  returns = { { "radiance", "array", "float [points][3]" },
    { "report", "table", "points, seconds.light, stages as of view:render" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, relight = "all", lmax = 2 }
local colours = view:radiance { grid = scene.lights[1], camera = ylm.camera { from = { 1, 3, 4 } } }
assert(colours.shape[1] == view.stats.points)]],
}
function prepared.radiance(view, given)
  local p = views.open("radiance", view)
  local o = form.options(1, "radiance", prepared_radiance, given)
  relight.check("radiance", o)
  return shading.points("radiance", p, o)
end

describe "prepared:reference" {
  about = "The reference of pictures by grids of lights under the view's transfer vectors: the lights' own coefficients at every "
    .. "shading point, no interpolation. The view is one that was prepared with visibility = 'transfer' or 'none'.",
  arguments = { { "options?", "table", "" } },
  options = prepared_reference,
  returns = { { "image", "image", "" }, { "report", "table", options.transfer_text .. "pairs: light x point evaluations" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4, visibility = "transfer" }
assert(view:reference { dtype = "double" })]],
}
function prepared.reference(view, given)
  local p = views.open("reference", view)
  return shading.by_lights("reference", p, form.options(1, "reference", prepared_reference, given))
end

describe "prepared:raycast" {
  about = "Shades a prepared view by rays to the lamps: no spherical harmonics, no occlusion_distance.",
  arguments = { { "options?", "table", "" } },
  options = prepared_raycast,
  returns = { { "image", "image", "" }, { "report", "table", options.report_text .. "rays.shadow" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
assert(view:raycast { light_samples = 16 })]],
  source = "Shirley, Wang, Zimmerman 1996",
}
function prepared.raycast(view, given)
  local p = views.open("raycast", view)
  if type(given) == "table" and given.samples ~= nil then
    return check.bad(1, "raycast", "samples are camera rays, which the view has already: shadow rays per shading point are "
      .. "light_samples")
  end
  return shading.by_rays("raycast", p, form.options(1, "raycast", prepared_raycast, given))
end

describe "prepared:points" {
  about = "Where a prepared view asks for light.",
  arguments = {},
  returns = { { "points", "table",
    "position [n][3], normal [n][3], albedo [n][3], object [n]: place in scene.geometry" } },
  errors = "raises on what is no prepared view; nil, message, code where memory runs out",
  example = options.one_lamp .. [[
local points = scene:prepare({ size = { 32, 18 }, samples = 1 }):points()
assert(points.position.shape[2] == 3 and points.object:get(1) == 1)]],
}
function prepared.points(view)
  local p = views.open("points", view)
  local position, normal, albedo, object = p.lib.shade_points(p.view)
  if not position then return nil, normal, albedo end
  return { position = position, normal = normal, albedo = albedo, object = object }
end

describe "prepared:close" {
  about = "Frees the memory of a prepared view now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no prepared view",
  example = options.one_lamp .. 'scene:prepare({ size = { 32, 18 }, samples = 1 }):close()',
}
function prepared.close(view)
  if core.type(view) ~= "ylm.prepared" then
    return check.fail("close: a prepared view expected before the colon, got %s", check.describe(view))
  end
  check.result("close", views.made[view].lib.shade_close_view(view))
  views.made[view].closed = true
end

require "ylm.render.gather"
require "ylm.render.vectors"
memory.publish(prepared)

return prepared
