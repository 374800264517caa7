--- Light that bounces from a grid of indirect light, or of the far parts of virtual lights.

local check = require "ylm.check"
local core = require "ylm.c.core"
local dering = require "ylm.render.dering"
local devices = require "ylm.device"
local links = require "ylm.render.bounced.links"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"

local grid = { name = "grid", called = "bounced = a grid" }

grid.options = options.list(options.sample_fields, dering.fields, near.fields, { options.element_field }, links.options)
grid.scene_options = { options.lmax_field }

function grid.wants(o)
  local x = o.bounced
  if not core.has_field(x) or core.type(x) == "ylm.radiosity" then return false end
  local held = visibility.quantity(x)
  return held == "indirect" or o.near_lights ~= nil and held == "lights"
end

function grid.settle(name, o)
  if o.bounces ~= nil then
    return check.fail("%s: bounces are those of the grid that bounced names: leave one out", name)
  end
  return { grid = o.bounced }
end

--- Is it the light of a grid that glossy points need harmonics for, and rays?
local function has_lobes(p) return p.traced.glossy > 0 and p.options.gloss ~= "matte" end

--- Elements for glossy points, where links are given.
function grid.prepare(name, p, o)
  local by, b, start = p.options.gloss, o.reflected, core.seconds()
  if not has_lobes(p) or by == "sh" then return true end
  if not o.links then
    if by ~= "rays" then return true end
    return check.fail("%s: gloss = 'rays': rays find light on elements: give links = scene:links {}, or gloss = 'sh'", name)
  end
  local elements, message, code = links.elements(name, p, o)
  if not elements then return nil, message, code end
  b.elements, b.prepared = elements, core.seconds() - start
  return true
end

--- The remedy where a grid's degree is too low for lobes.
grid.BEYOND = "give links = scene:links {}, whose elements rays find, bake a higher lmax, or use scene:pathtrace"

--- Rays of glossy points where the grid's degree is too low, in place. True, or nil, message, code.
local function blend(name, p, o, b, radiance)
  local bar, threads, lmax = progress.resolve(o.progress), o.threads or 0, p.options.lmax
  local share, found, code
  if core.type(b.grid) == "ylm.grid" then lmax = b.grid.lmax end
  b.lmax = lmax
  if b.elements then
    share, found, code = check.result(name, p.lib.shade_blend_links(p.view, radiance, { links = b.elements.links.handle,
      lit = b.elements.lit, lmax = lmax, threads = threads, progress = bar }))
  else
    share, found, code = check.result(name, p.lib.shade_blend(p.view, radiance, { weight = "cosine", lmax = lmax,
      light_samples = 0, shadows = true, seed = p.options.seed, threads = threads, progress = bar }))
  end
  if not share then return nil, found, code end
  b.found = found
  return true
end

function grid.radiance(name, p, o, start)
  local b, bar, threads = o.reflected, progress.resolve(o.progress), o.threads or 0
  local out, message, code = dering.shade(devices.of(nil), name, p, { grid = b.grid, weight = "cosine",
    threads = threads, interpolation = o.interpolation, dering = o.dering }, bar)
  if not out then return nil, message, code end
  b.dering = message.dering
  if has_lobes(p) then
    local ok, failed, why = blend(name, p, o, b, out)
    if not ok then return nil, failed, why end
  end
  if o.near_lights then
    out, message, code = near.add(name, p, o.near_lights, "cosine", near.degree(p, b.grid), o, out)
    if not out then return nil, message, code end
    b.nearby = message
  end
  if not start then return out end
  return check.result(name, p.lib.shade_add(out, start))
end

--- Says of a picture by a grid of bounces how far its degree is too low for lobes; where they are met as matte ones, that too.
local function say_grid(p, report, b, what, one)
  if not b.found then
    return what .. (one and "a grid's bounced light meets it as a matte one of its mean albedo"
      or "a grid's bounced light meets them as matte ones of their mean albedo")
  end
  report.bounced_glossy = { sh = b.found.sh, rays = b.found.rays, missed = b.found.missed }
  if b.elements then report.rays.gloss_links = b.elements.links.stats.rays end
  if b.found.missed <= (p.options.gloss == "sh" and 0.1 or p.options.gloss_error[2]) then return nil end
  return ("%sharmonics of degree %d miss %.0f %% of %s lobes in bounced light: %s"):format(what, b.lmax, 100 * b.found.missed,
    one and "its" or "their", grid.BEYOND)
end

function grid.report(p, o, report)
  local b, n = o.reflected, p.traced.glossy
  if b.dering then dering.report(p, { grid = b.grid, dering = o.dering }, report, b.dering) end
  if n == 0 then return end
  local line = say_grid(p, report, b, n == 1 and "1 mesh is glossy: " or n .. " meshes are glossy: ", n == 1)
  if not line then return end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss bounced", "scene %q: %s", p.scene.name or "?", line)
end

return grid
