--- The methods of prepared views.

local ambient = require "ylm.render.ambient"
local bodies = require "ylm.render.bodies"
local check = require "ylm.check"
local core = require "ylm.c.core"
local dering = require "ylm.render.dering"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local gloss = require "ylm.render.gloss"
local indirect = require "ylm.render.indirect"
local light = require "ylm.light"
local memory = require "ylm.memory"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local outputs = require "ylm.outputs"
local relight = require "ylm.render.relight"
local shading = require "ylm.render.shade"
local views = require "ylm.render.view"

local prepared = views.methods

local prepared_render = options.list(options.grid_fields, dering.fields, near.fields, options.direct_fields, relight.fields,
  relight.method_fields,
  indirect.bounce_fields, indirect.link_fields, {
  { "lights", "any", optional = true,
    about = "lights that shine instead of the scene's, by rays: they may move; default with indirect = lit: those of lit" },
  { "lamps", "any", optional = true,
    about = "sphere lights to draw that are not in the prepared scene, because they move" },
  { "depth", "array", optional = true,
    about = "float [height][width]: takes the layer depth, and in front of it that of lamps which cover more than half of a "
      .. "pixel" },
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

--- Raises where the option depth is no float array of the view's size.
local function check_depth(p, o)
  local size = p.options.size
  if o.depth then outputs.of(1, "render: depth", o.depth, "float", { { size[2], size[1] } }) end
end

--- Writes into o.depth how far surfaces and o.lamps are; true, or nil, message, code.
local function write_depth(p, o)
  if not o.depth then return true end
  local threads = o.threads or 0
  local ok, message, code = check.result("render", p.lib.shade_layer(p.view, "depth", threads, o.depth))
  if not ok or not o.lamps then return ok, message, code end
  return check.result("render", p.lib.shade_lamp_depth(p.view, threads, o.depth, light.lamps("render", o.lamps)))
end

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
  check_depth(p, o)
  local ok, message, code = indirect.relight("render", p, o)
  if not ok then return nil, message, code end
  local image, report
  image, report, code = shading.picture("render", p, o)
  if not image then return nil, report, code end
  ok, message, code = write_depth(p, o)
  if not ok then return nil, message, code end
  return image, report
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

local layer_names = { "depth", "position", "normal", "albedo", "coverage", "emitter", "object" }

describe "prepared:layer" {
  about = "Surfaces that a prepared view sees, without shading them: a layer of its pictures. Numbers of a pixel are means "
    .. "over its surfaces; object is the place in scene.geometry of what has most of the pixel, 0 where nothing is seen.",
  arguments = { { "name", "string", table.concat(layer_names, ", ") } },
  returns = { { "pixels", "array", "float [height][width][channels]; depth along the view axis, infinite where nothing is "
    .. "seen" } },
  errors = "raises on another name; nil, message, code where memory runs out",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 1 }
assert(view:layer "object":get(9, 16, 1) == 1)]],
}
function prepared.layer(view, name)
  local p = views.open("layer", view)
  for _, known in ipairs(layer_names) do
    if name == known then return check.result("layer", p.lib.shade_layer(p.view, name, 0)) end
  end
  return check.bad(1, "layer", "%s expected, got %s", table.concat(layer_names, ", "), check.describe(name))
end

describe "prepared:hit" {
  about = "The surface that has most of a pixel.",
  arguments = { { "x", "integer", "column, from 1" }, { "y", "integer", "row, from 1: the top" } },
  returns = { { "hit?", "table", "position, normal {x, y, z}, object: place in scene.geometry, depth along the view axis; nil "
    .. "where nothing is seen" } },
  errors = "raises where there is no such pixel",
  example = options.one_lamp .. [[
local hit = scene:prepare({ size = { 32, 18 }, samples = 1 }):hit(16, 9)
assert(hit.object == 1 and math.abs(hit.normal[2] - 1) < 1e-6)]],
}
function prepared.hit(view, x, y)
  local p = views.open("hit", view)
  for n, i in ipairs { x or false, y or false } do
    if not check.is_integer(i) or i < 1 or i > p.options.size[n] then
      return check.bad(n, "hit", "a pixel's %s from 1 to %d expected, got %s", n == 1 and "column" or "row", p.options.size[n],
        check.describe(i))
    end
  end
  return p.lib.shade_hit(p.view, x - 1, y - 1)
end

describe "prepared:lamp_at" {
  about = "The lamp near a place of the picture: that whose rim is nearest, of several under it the nearest to the camera. "
    .. "Lamps behind surfaces are not found.",
  arguments = { { "lamps", "table", "sphere lights, as the option lamps of view:render" },
    { "x", "number", "pixels from the left; 0.5 is the middle of the first column" },
    { "y", "number", "pixels from the top" },
    { "reach?", "number", "how many pixels the rim may be away; default 0: the place lies on the lamp" } },
  returns = { { "index?", "integer", "place among the spheres; nil where there is none" },
    { "away?", "number", "pixels from the rim, 0 inside" }, { "depth?", "number", "of its middle, along the view axis" } },
  errors = "raises on lamps that are no spheres and numbers that are not finite; nil, message, code where memory runs out",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 1 }
assert(view:lamp_at(scene.lights, 16, 1, 100) == 1)]],
}
function prepared.lamp_at(view, lamps, x, y, reach)
  local p = views.open("lamp_at", view)
  for n, value in ipairs { x or false, y or false, reach or 0 } do
    if not check.is_number(value) or value ~= value or value - value ~= 0 or n == 3 and value < 0 then
      return check.bad(n + 1, "lamp_at", "%s expected, got %s", n == 3 and "pixels >= 0" or "a finite number",
        check.describe(value))
    end
  end
  if lamps == nil then return check.bad(1, "lamp_at", "sphere lights expected, got nil") end
  local packed = light.lamps("lamp_at", lamps)
  local index, away, depth = check.result("lamp_at", p.lib.shade_lamp_at(p.view, packed, x, y, reach or 0))
  if not index then return nil, away, depth end
  if index == 0 then return nil end
  return index, away, depth
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
  local m = views.made[view]
  check.result("close", m.lib.shade_close_view(view))
  m.closed, views.made[view] = true, m
end

require "ylm.render.gather"
require "ylm.render.vectors"
memory.publish(prepared)

return prepared
