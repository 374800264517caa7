--- The methods of prepared views.

local bounces = require "ylm.render.bounces"
local check = require "ylm.check"
local choose = require "ylm.render.choose"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local gloss = require "ylm.render.gloss"
local light = require "ylm.light"
local make = require "ylm.render.make"
local memory = require "ylm.memory"
local options = require "ylm.render.options"
local relight = require "ylm.render.relight"
local reports = require "ylm.render.reports"
local views = require "ylm.render.view"

local prepared = views.methods

local render_first = { choose.by("rays", "grid", "sum", "vectors", "none") }
local render_last = options.list({
  { "out", "any", optional = true, shelf = "experiments",
    about = "an image of an earlier call, to be written again and returned: its memory is there; "
      .. "with download = false the gpu_array" },
}, options.layer_fields, options.common)
local render_options = choose.fields("view", render_first, render_last, choose.direct, choose.bounced, choose.over)
local render_common = options.names(render_first, render_last)
local render_names = options.names(render_options)
local settled = options.names(options.view_fields, options.prepare_fields, gloss.fields)

--- Raises where an option is one that the view was prepared with.
local function check_settled(given)
  for name in pairs(type(given) == "table" and given or {}) do
    if settled[name] and not render_names[name] then
      return check.bad(1, "render", "%s is of scene:prepare, and the view has it already: leave it out", name)
    end
  end
end

local radiance_options = options.list(options.grid_fields, relight.fields, relight.method_fields, options.common)

describe "view:render" {
  shelf = "everyday",
  about = "Shades a prepared view: by a grid, or one that was prepared with visibility = 'rays' by rays to its lamps. "
    .. "report.seconds.light says how long sampling and shading took. Of a grid made with dynamic = true only what grid:update "
    .. "changed since the last time is sampled. A grid of lights needs the view's transfer vectors, as a sum does; others hold "
    .. "their shadows. Nothing bounces unless bounces or bounced are given.",
  arguments = { { "options?", "table", "grid is needed where the view has transfer vectors" } },
  options = render_options,
  returns = { { "image", "image", "" }, { "report", "table", reports.text } },
  report = reports.fields,
  errors = "raises on a bad option, and one that the chosen ways have no use for; nil, message, code where memory runs out or it "
    .. "is cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4, visibility = "transfer" }
local lights = ylm.sphere_lights { at = { { 0, 1, 0 } }, radius = 0.1, radiance = 50 }
local image = view:render { grid = lights.lights }                            -- anything that has a light field
assert(image:layer "radiance":get(9, 16, 1) > 0)
assert(view:render { by = "sum", dtype = "double" })                          -- the reference of grids
assert(scene:prepare { size = { 32, 18 } }:render { light_samples = 4 })      -- by rays
local T = view:transfer { links = scene:links { rays = 16 } }
image = view:render { vectors = T, lights = ylm.environment_light { radiance = 1 } }
assert(image:layer "radiance":get(9, 16, 1) > 0)
local bright = scene:virtual_lights { count = 50 }
local _, report = view:render { by = "none", bounced = bright }               -- light that bounces alone
assert(report.virtual.pairs == bright.count * view.stats.points)
assert(view:render { by = "none", bounced = bright, rival = { "vpl", clamp = "distance", limit = 4 } })]],
  source = "Green 2003; Sloan et al. 2002; Mezieres & Paulin 2022; Keller 1997; Kollig & Keller 2004; Hasan et al. 2009; "
    .. "Tokuyoshi 2015",
}
function prepared.render(view, given)
  local p = views.open("render", view)
  check_settled(given)
  local o = form.options(1, "render", render_options, given)
  o.direct = choose.direct_of(o, p)
  bounces.settle("render", o, p.scene)
  choose.check("render", "view", render_options, render_common, o, given)
  relight.check("render", o)
  local ok, message, code = bounces.relight("render", p, o)
  if not ok then return nil, message, code end
  return make.picture("render", p, o)
end

describe "view:radiance" {
  about = "The radiance of a prepared view's shading points, without a picture: the colours of vertices for who draws them, of "
    .. "views prepared with relight = 'all' those of all vertices (view:points).",
  arguments = { { "options", "table", "grid is needed" } },
  options = radiance_options,
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
  local o = form.options(1, "radiance", radiance_options, given)
  relight.check("radiance", o)
  return choose.direct.grid.points("radiance", p, o)
end

describe "view:points" {
  shelf = "everyday",
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

describe "view:layer" {
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

describe "view:hit" {
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

describe "view:lamp_at" {
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

describe "view:close" {
  about = "Frees the memory of a prepared view now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no prepared view",
  example = options.one_lamp .. 'scene:prepare({ size = { 32, 18 }, samples = 1 }):close()',
}
function prepared.close(view)
  if core.type(view) ~= "ylm.view" then
    return check.fail("close: a prepared view expected before the colon, got %s", check.describe(view))
  end
  local m = views.made[view]
  check.result("close", m.lib.shade_close_view(view))
  m.closed, views.made[view] = true, m
end

require "ylm.render.vectors"
memory.publish(prepared)

return prepared
