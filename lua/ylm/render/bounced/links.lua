--- Light that bounces, in pictures: gathered along links of the shading points, or from a grid of it.

local check = require "ylm.check"
local core = require "ylm.c.core"
local dering = require "ylm.render.dering"
local devices = require "ylm.device"
local near = require "ylm.render.near"
local noises = require "ylm.render.noise"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local virtual = require "ylm.render.virtual"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"

local indirect = {}

local LINKS, MOST = 64, core.limits.transfer_bounces

local transfer_field = { "transfer", "object", of = "ylm.transfer", optional = true,
  about = "what scene:transfer returned; default: one with its defaults, where bounces are wanted" }

--- Options of views.
indirect.link_fields = {
  { "links", "links", optional = true,
    about = "of a shading point: rays to surfaces, traced once, whose light is then gathered without rays; default 64 where "
      .. "bounces are wanted, 4 bytes each" },
  transfer_field,
}

--- Options of pictures.
indirect.bounce_fields = {
  { "bounces", "bounces", optional = true,
    about = "reflections after direct light, a number or 'all', gathered pixel by pixel; default 0, which the report says" },
  { "indirect", "any", optional = true,
    about = "instead of bounces: what t:radiosity returned, gathered pixel by pixel; a grid of it, or of indirect light; "
      .. "with near, a grid of the far parts of virtual lights. "
      .. "'virtual', or { method = 'virtual', count =, particles =, radius =, scale =, profile =, "
      .. "merge =, cell =, degree =, conserve =, lights =, lmax =, shadows =, "
      .. "sums = 'auto' | 'all' | 'split', tolerance = }: bounces, 1 by default, by virtual lights "
      .. "(scene:virtual_lights), each asked at each shading point, or by far and near parts where that is cheaper; or such "
      .. "lights" },
}

-- Bounces that are wanted ------------------------------------------------------------------------

--- Settles o.bounced, nil or { by = "gather" | "grid" | "virtual", bounces =, lit =, grid =, add = }, from bounces and indirect.
local function settle(name, o)
  local x = o.indirect
  local b
  if virtual.is_wanted(x) then
    b = virtual.settle(name, x, o)
  elseif x ~= nil and o.bounces ~= nil then
    return check.fail("%s: bounces and indirect say the same: leave one out", name)
  elseif x == nil then
    local bounces = o.bounces or 0
    if bounces ~= "all" and bounces > MOST then
      return check.bad(1, name, "bounces must be an integer from 0 to %d, or 'all', got %.0f", MOST, bounces)
    end
    b = bounces ~= 0 and { by = "gather", bounces = bounces } or nil
  elseif core.type(x) == "ylm.radiosity" then
    b = { by = "gather", lit = x, bounces = objects.open_radiosity(name, x).options.bounces }
  elseif core.has_field(x) and (visibility.quantity(x) == "indirect" or o.near and visibility.quantity(x) == "lights") then
    b = { by = "grid", grid = x }
  else
    return check.fail("%s: indirect must be what t:radiosity returned, a grid of it or 'virtual', got %s%s",
      name, check.describe(x), core.has_field(x) and " of " .. visibility.quantity(x) or "")
  end
  if not b then return end
  local held = o.grid ~= nil and visibility.quantity(o.grid)
  if held == "all" or held == "indirect" then
    return check.fail("%s: the grid holds bounces already: leave bounces and indirect out, or bake parts = 'direct'", name)
  end
  devices.of(o.device):check_rays(name)
  b.add, o.bounced = indirect.add, b
end

--- Settles o.bounced, as above, and o.near, of a picture of `scene`. A transfer is looked at even where nothing bounces.
function indirect.settle(name, o, scene)
  if o.transfer then objects.check_scene(name, o.transfer, scene) end
  settle(name, o)
  near.settle(name, o)
end

-- Links ------------------------------------------------------------------------------------

--- The transfer that options or the view's links name, or a new one; or nil, message, code.
local function transfer_of(p, o)
  local known = views.made[p.view].links
  local t = o.transfer or known and known.transfer
  if t then return t end
  return p.scene:transfer { lmax = 0, seed = p.options.seed, threads = o.threads, progress = o.progress }
end

--- Finds the links of a prepared view to the elements of t (nil: as above), or keeps those that it has: true, or nil,
-- message, code.
function indirect.link(name, p, t, o)
  local m, count, handle, message, code = views.made[p.view], o.links
  if not t then
    t, message, code = transfer_of(p, o)
    if not t then return nil, message, code end
  end
  objects.check_scene(name, t, p.scene)
  objects.of_view(name, p, t)
  local known = m.links
  if known and known.transfer == t and (count == nil or known.count == count) then return true end
  count = count or LINKS
  handle, message, code = check.result(name, p.lib.shade_links(p.view, t, count, p.options.seed, o.threads or 0,
    progress.resolve(o.progress), p.options.gloss == "matte" and "matte" or "both"))
  if not handle then return nil, message, code end
  local stats = p.lib.shade_links_stats(handle)
  m.links = { handle = handle, transfer = t, count = count, stats = stats }
  m.stats.links, m.stats.link_rays, m.stats.link_bytes, m.stats.link_seconds = count, stats.rays, stats.bytes, stats.seconds
  return true
end

--- Links of those points of a view that gloss to the elements of t, kept: { handle =, transfer =, count =, stats = }; or nil,
-- message, code.
local function link_glossy(name, p, t, o)
  local m = views.made[p.view]
  local known = m.links or m.gloss_links
  if known and known.transfer == t and (o.links == nil or known.count == o.links) then return known end
  objects.of_view(name, p, t)
  local count = o.links or LINKS
  local handle, message, code = check.result(name, p.lib.shade_links(p.view, t, count, p.options.seed, o.threads or 0,
    progress.resolve(o.progress), "gloss"))
  if not handle then return nil, message, code end
  m.gloss_links = { handle = handle, transfer = t, count = count, stats = p.lib.shade_links_stats(handle) }
  return m.gloss_links
end

--- Light on the elements of a transfer for b.bounces reflections after direct light, the last at the shading points: b.lit,
-- or nil, message, code.
local function shine(p, o, b)
  local t, message, code = transfer_of(p, o)
  if not t then return nil, message, code end
  b.lit, message, code = t:radiosity(o.lights or p.scene.lights, { bounces = b.bounces == "all" and "all" or b.bounces - 1,
    seed = p.options.seed, threads = o.threads, progress = o.progress })
  return b.lit, message, code
end

--- Light of o.transfer's elements for points that gloss: { lit =, links = }; or nil, message, code.
function indirect.elements(name, p, o)
  objects.check_scene(name, o.transfer, p.scene)
  local lit, message, code = shine(p, o, { bounces = "all" })
  if not lit then return nil, message, code end
  local links
  links, message, code = link_glossy(name, p, o.transfer, o)
  if not links then return nil, message, code end
  return { lit = lit, links = links }
end

--- Is it the light of a grid that points which gloss need harmonics for, and rays?
local function glosses(p) return p.traced.glossy > 0 and p.options.gloss ~= "matte" end

--- Elements for the light of a grid that bounces, where a transfer is given. True, or nil, message, code.
local function ready_grid(name, p, o, b, start)
  local by = p.options.gloss
  if not glosses(p) or by == "sh" then return true end
  if not o.transfer then
    if by ~= "rays" then return true end
    return check.fail("%s: gloss = 'rays': rays find light on elements: give transfer = scene:transfer {}, or gloss = 'sh'", name)
  end
  local elements, message, code = indirect.elements(name, p, o)
  if not elements then return nil, message, code end
  b.elements, b.prepared = elements, core.seconds() - start
  return true
end

--- Makes what o.bounced needs: links of the view, and light on the elements. True, or nil, message, code.
function indirect.ready(name, p, o)
  local b, start = o.bounced, core.seconds()
  if not b then return true end
  if b.by == "virtual" then return virtual.ready(name, p, o) end
  if b.by == "grid" then return ready_grid(name, p, o, b, start) end
  if not b.lit then
    local lit, message, code = shine(p, o, b)
    if not lit then return nil, message, code end
  elseif o.transfer and o.transfer ~= b.lit.transfer then
    return check.fail("%s: indirect is of another transfer than the option transfer: leave transfer out", name)
  end
  local ok, message, code = indirect.link(name, p, b.lit.transfer, o)
  if not ok then return nil, message, code end
  b.prepared = core.seconds() - start
  return true
end

--- Other lamps than the view's: o.lit, traced, from o.lights, or those that light o.indirect. True, or nil, message, code.
function indirect.relight(name, p, o)
  if o.lights ~= nil and (o.grid ~= nil or p.options.visibility ~= "rays") then
    return check.fail("%s: lights shine by rays, here is a grid: leave one out", name)
  end
  if o.lights ~= nil then
    local lit, message, code = tracing.relight(name, p.traced, o.lights)
    if not lit then return nil, message, code end
    tracing.check_bodies(name, lit)
    o.lit = lit
  elseif o.bounced and o.bounced.lit then
    o.lit = objects.radiosities[o.bounced.lit].lit_by
  end
  return true
end

-- Light --------------------------------------------------------------------------------------

--- The remedy where a grid's degree is too low for lobes.
indirect.BEYOND = "give transfer = scene:transfer {}, whose elements rays find, bake a higher lmax, or use scene:pathtrace"

--- Rays of points that gloss where the degree of the grid that bounces are from is too low, in place. True, or nil, message,
-- code.
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

--- Radiance of shading points with light that bounces added, a new array; or nil, message, code.
function indirect.add(name, p, o, radiance)
  local b, start = o.bounced, core.seconds()
  local bar, threads = progress.resolve(o.progress), o.threads or 0
  local out, message, code
  if b.by == "gather" then
    out, message, code = check.result(name, p.lib.shade_gather(p.view, views.made[p.view].links.handle, b.lit, radiance,
      threads, bar))
  elseif b.by == "virtual" then
    out, message, code = virtual.radiance(name, p, o)
    if out then out, message, code = check.result(name, p.lib.shade_add(out, radiance)) end
  else
    out, message, code = dering.shade(devices.of(nil), name, p, { grid = b.grid, weight = "cosine", bias = o.bias,
      threads = threads, interpolation = o.interpolation or "hermite", dering = o.dering }, bar)
    b.bias, b.dering = out and message.bias, out and message.dering
    if out and glosses(p) then
      local ok, failed, why = blend(name, p, o, b, out)
      if not ok then return nil, failed, why end
    end
    if out and o.near then
      local ok
      ok, message, code = near.add(name, p, o.near, "cosine", near.degree(p, b.grid), o, out)
      if not ok then return nil, message, code end
      b.nearby = message
    end
    if out then out, message, code = check.result(name, p.lib.shade_add(out, radiance)) end
  end
  if not out then return nil, message, code end
  b.seconds = core.seconds() - start
  return out
end

--- Says that links are few for what is bright, and what to change; `noise` is that of a pixel.
local function say_noise(p, report, count, noise)
  local enough = math.min(core.limits.transfer_links, 64 * math.ceil(noises.enough(count, noise) / 64))
  local left = noise * math.sqrt(count / enough)
  local advice = left <= noises.LOUD and ("set links = %d for %.0f %%, or a tolerance"):format(enough, 100 * left)
    or "few of them meet what is bright; set a tolerance, which chooses camera rays too"
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "links", "scene %q: %d links of a shading point leave a noise of "
    .. "%.0f %% in the light that bounces: %s", p.scene.name or "?", count, 100 * noise, advice)
end

--- Says of a picture by a grid of bounces how far its degree is too low for lobes; where as matte ones, that too.
local function say_grid(p, report, b, what, one)
  if not b.found then
    return what .. (one and "a grid's bounced light meets it as a matte one of its mean albedo"
      or "a grid's bounced light meets them as matte ones of their mean albedo")
  end
  report.indirect_glossy = { sh = b.found.sh, rays = b.found.rays, missed = b.found.missed }
  if b.elements then report.rays.gloss_links = b.elements.links.stats.rays end
  if b.found.missed <= (p.options.gloss == "sh" and 0.1 or p.options.gloss_error[2]) then return nil end
  return ("%sharmonics of degree %d miss %.0f %% of %s lobes in bounced light: %s"):format(what, b.lmax, 100 * b.found.missed,
    one and "its" or "their", indirect.BEYOND)
end

--- Says what bounced light lacks where surfaces gloss.
local function say_gloss(p, report, b)
  local n = p.traced.glossy
  if n == 0 then return end
  local line
  local one, what = n == 1, n == 1 and "1 mesh is glossy: " or n .. " meshes are glossy: "
  if b.by == "grid" then line = say_grid(p, report, b, what, one)
  elseif p.options.gloss == "matte" then
    line = what .. (one and "bounced light meets it as a matte one of its mean albedo"
      or "bounced light meets them as matte ones of their mean albedo")
  else
    line = what .. (one and "it sends light to others as a matte one of its mean albedo"
      or "they send light to others as matte ones of their mean albedo")
      .. ", no highlights in reflections, no caustics: scene:pathtrace has them"
  end
  if not line then return end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss bounced", "scene %q: %s", p.scene.name or "?", line)
end

--- Completes report and metadata of a picture by its bounces.
function indirect.report(p, o, report, image)
  local b = o.bounced
  if not b then
    local held = o.grid ~= nil and visibility.quantity(o.grid)
    report.bounces = (held == "all" or held == "indirect") and "those of the grid" or 0
    if core.type(image) == "ylm.image" then image.metadata.bounces = tostring(report.bounces) end
    if report.bounces == 0 then report.omits = 'light that bounces (bounces = 0; bounces = "all" has it)' end
    if held == "indirect" then report.omits = "direct light (scene:render { indirect = grid } has it)" end
    return
  end
  report.bounces = b.by == "grid" and "those of the grid" or b.bounces
  report.bias = report.bias or b.bias
  if b.dering then dering.report(p, { grid = b.grid, dering = o.dering }, report, b.dering) end
  report.indirect, image.metadata.bounces = b.by, tostring(report.bounces)
  local seconds = report.seconds
  seconds.bounces, seconds.indirect = b.prepared, b.seconds
  seconds.image = seconds.image - b.seconds
  seconds.total = seconds.total + (b.prepared or 0)
  if b.by == "gather" then
    local m = views.made[p.view]
    report.links, report.rays.links = m.links.count, m.links.stats.rays
    report.indirect_noise = p.lib.shade_gather_noise(m.links.handle, b.lit)
    local noise = noises.of_pixel(p, report.indirect_noise)
    if noise > noises.LOUD and not o.tolerance then say_noise(p, report, m.links.count, noise) end
    report.rays.gloss_links = m.links.stats.glossy
    report.elements, report.balance = b.lit.transfer.stats.elements, b.lit.stats.balance
    report.elements_error = b.lit.stats.elements_error
  end
  if b.by == "virtual" then virtual.report(p, o, report) else say_gloss(p, report, b) end
end

return indirect
