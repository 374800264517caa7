--- Light that bounces from a surface grid: no ray is traced for it.

local check = require "ylm.check"
local core = require "ylm.c.core"
local objects = require "ylm.transfer.object"
local surfaces = require "ylm.render.surfaces"
local warning = require "ylm.warning"

local way = { name = "surfaces", called = "bounced = a surface grid", options = {} }

function way.wants(o) return core.type(o.bounced) == "ylm.surface_grid" end

function way.settle(name, o)
  local m = surfaces.opened(name, o.bounced)
  if o.bounces ~= nil then
    return check.fail("%s: bounces are those of the surface grid that bounced names: leave one out", name)
  end
  if m.quantity ~= "indirect" and o.direct.name ~= "none" then
    return check.fail("%s: the surface grid holds direct light already, quantity = %q: give by = 'none' to a view, or make one "
      .. "of 'indirect'", name, m.quantity)
  end
  return { surfaces = o.bounced }
end

function way.prepare(name, p, o)
  local m = surfaces.opened(name, o.reflected.surfaces)
  if not objects.alike(p.traced, m.traced) then
    return check.fail("%s: the surface grid is of other geometry, that of scene %q: make one of the view's scene "
      .. "(scene:surface_grid)", name, m.scene.name or "?")
  end
  return true
end

function way.radiance(name, p, o, start)
  local E, message, code = check.result(name, p.lib.shade_surfaces(p.view, o.reflected.surfaces, o.threads or 0))
  if not E then return nil, message, code end
  local out
  out, message, code = check.result(name, p.lib.shade_reflect(p.view, E))
  if not out then return nil, message, code end
  if not start then return out end
  return check.result(name, p.lib.shade_add(out, start))
end

function way.report(p, _, report)
  local n = p.traced.glossy
  if n == 0 then return end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss bounced", "scene %q: %s: use scene:pathtrace, or bounced "
    .. "= 'links'", p.scene.name or "?", n == 1
    and "1 mesh is glossy: a surface grid's light meets it as a matte one of its mean albedo"
    or n .. " meshes are glossy: a surface grid's light meets them as matte ones of their mean albedo")
end

return way
