--- Ambient occlusion: option ambient of pictures. Surfaces near a point darken it, wherever light comes from.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"
local warning = require "ylm.warning"

local ambient = { name = "ambient", called = "ambient" }

ambient.options = {
  { "ambient", "choice", of = { "ssao", "rays" }, optional = true, shelf = "experiments",
    about = "multiplies the radiance of surfaces by the part of even light that nothing within ambient_radius keeps from them "
      .. "(layer ambient): 'ssao': by 16 samples of the picture, which knows what the camera sees; 'rays': by 128 rays. It "
      .. "stands in for shadows where light has none, and is not the scene's light" },
  { "ambient_radius", "distance", optional = true, shelf = "experiments", unit = "scene units",
    about = "how far ambient looks; default: a twentieth of the diagonal of the scene's bounding box" },
}

function ambient.wants(o) return o.ambient ~= nil or o.ambient_radius ~= nil end

--- Finds o.openness [points] of a prepared view.
function ambient.prepare(name, p, o)
  if not o.ambient then
    return check.fail("%s: ambient_radius is for ambient = 'ssao' or 'rays': name one, or leave it out", name)
  end
  if p.options.shading == "vertices" then
    return check.fail("%s: ambient is of what camera rays hit: shading = 'pixel' in scene:prepare", name)
  end
  local start = core.seconds()
  local radius = o.ambient_radius or box.diagonal(p.traced.lo, p.traced.hi) / 20
  if radius == 0 then radius = 1 end
  local open, message, code = check.result(name, p.lib.shade_ambient(p.view, o.ambient == "rays", radius, o.threads or 0,
    progress.resolve(o.progress)))
  if not open then return nil, message, code end
  o.openness, o.ambient_radius, o.ambient_seconds = open, radius, core.seconds() - start
  return true
end

--- The radiance [points][3] times the openness; or nil, message, code.
function ambient.radiance(name, p, o, radiance)
  return check.result(name, p.lib.shade_darken(radiance, o.openness))
end

function ambient.report(p, o, report, image)
  report.ambient = { method = o.ambient, radius = o.ambient_radius }
  report.seconds.ambient = o.ambient_seconds
  report.seconds.total = report.seconds.total + o.ambient_seconds
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "ambient", "%s",
    ("scene %q: ambient = %q darkens surfaces by what is within %.3g of them, wherever light comes from: that is not the scene's "
      .. 'light; leave it out, by = "rays" and bounces have the scene\'s'):format(p.scene.name or "?", o.ambient,
        o.ambient_radius))
  local m = image.metadata
  m.ambient, m.ambient_radius = o.ambient, ("%.6g"):format(o.ambient_radius)
  return true
end

return ambient
