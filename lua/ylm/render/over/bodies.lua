--- Bodies that move in pictures of prepared views: drawn over what stands still, shaded by transfer vectors of their own.
--
-- The transfer vectors of a body's vertices know the body alone. They are found once, in its frame, and turned with it. Its light
-- is that of all other casters.

local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"
local shadow = require "ylm.shadow"
local views = require "ylm.render.view"

local bodies = { name = "bodies", called = "bodies" }

bodies.view_options = {
  { "bodies", "object", of = "ylm.shadowed", optional = true, shelf = "experiments",
    about = "shadowed light whose casters with a surface are drawn where they stand, matte: vertices in that light, behind all "
      .. "other casters, with the shadows that a body casts on itself. Of the layers radiance alone shows them; they are before "
      .. "lamps of the view" },
}

--- Any camera: a body is seen through that of the picture.
local CAMERA = { from = { 0, 0, 1 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 40 }

--- The view of a body's surface, made once for each lmax; or nil, message, code.
local function view_of(name, p, surface, o)
  local lmax = p.options.lmax
  local own = core.own(surface)
  own.views = own.views or {} -- by lmax, of the body in its frame
  if own.views[lmax] then return own.views[lmax] end
  local alone = { name = p.scene.name, camera = CAMERA, geometry = surface, lights = {}, background = { 0, 0, 0 } }
  local view, message, code = views.prepare(name, alone, { size = { 1, 1 }, samples = 1, seed = p.options.seed, share = 0,
    lmax = lmax, shading = "vertices", visibility = "transfer", occlusion_distance = math.huge,
    relight = "all", gloss = "matte", coarse = true, threads = o.threads, progress = o.progress })
  if not view then return nil, message, code end
  own.views[lmax] = view
  return view
end

--- Draws the bodies of o.bodies over `layer`; true, or nil, message, code. o.drawn is completed for the report.
function bodies.draw(name, p, o, layer)
  local start, threads, bar = core.seconds(), o.threads or 0, progress.resolve(o.progress)
  local list, message, code = shadow.bodies(name, o.bodies)
  if not list then return nil, message, code end
  local drawn, vertices = {}, 0
  for i, body in ipairs(list) do
    local view
    view, message, code = view_of(name, p, body.surface, o)
    if not view then return nil, message, code end
    local light
    light, message, code = shadow.beside(name, o.bodies, body.number)
    if not light then return nil, message, code end
    drawn[i] = { view, at = body.at, rotation = body.rotation, scale = body.scale }
    drawn[i].radiance, message, code = check.result(name, p.lib.shade_body_field(drawn[i], light, threads, bar))
    if not drawn[i].radiance then return nil, message, code end
    vertices = vertices + views.made[view].stats.points
  end
  local shaded = core.seconds()
  local rays
  rays, message, code = check.result(name, p.lib.shade_draw_bodies(p.view, threads, layer, drawn))
  if not rays then return nil, message, code end
  o.drawn = { count = #list, vertices = vertices, rays = rays, seconds = { light = shaded - start,
    image = core.seconds() - shaded } }
  return true
end

function bodies.wants(o) return o.bodies ~= nil end

--- Raises where bodies cannot be drawn.
function bodies.prepare(name, _, o)
  shadow.bodies(name, o.bodies)
  return true
end

function bodies.report(_, o, report)
  report.bodies = o.drawn
  return true
end

return bodies
