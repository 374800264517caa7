--- Light that bounces along links: rays from shading points to surfaces, traced once, whose light is gathered without rays.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local noises = require "ylm.render.noise"
local objects = require "ylm.transfer.object"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local links = { name = "links", called = "bounced = 'links'" }

local RAYS, MOST = 64, core.limits.transfer_bounces
links.OWN = 32 -- of an element, where a picture cuts surfaces itself: its points gather the light of many elements
local SET, APART = 32, 7000003 -- links of a set; from the seed of links that are kept to that of sets

links.options = {
  { "rays", "links", optional = true, shelf = "experiments",
    about = "of a shading point, to surfaces, a multiple of 4: traced once, whose light is then gathered without rays; default "
      .. "64 where light bounces, 2 bytes each, 4 from 65,536 elements on" },
}

--- Options of prepared views.
links.prepare_fields = options.list(links.options, {
  { "links", "object", of = "ylm.links", optional = true,
    about = "what scene:links returned, to whose elements rays go; default: one with its defaults, but for 32 rays of "
      .. "an element, where bounces are wanted" },
})

-- Links ------------------------------------------------------------------------------------

--- The links that options or the view's links name, or a new one; or nil, message, code.
local function links_of(p, o)
  local known = views.made[p.view].links
  local t = o.links or known and known.links
  if t then return t end
  local form = p.scene.link_options
  return p.scene:links { lmax = 0, rays = form and form.rays or links.OWN, seed = p.options.seed, threads = o.threads,
    progress = o.progress }
end

--- Finds the links of a prepared view to the elements of t (nil: as above), or keeps those that it has: true, or nil,
-- message, code.
function links.link(name, p, t, o)
  local m, count, handle, message, code = views.made[p.view], o.rays
  if not t then
    t, message, code = links_of(p, o)
    if not t then return nil, message, code end
  end
  objects.check_scene(name, t, p.scene)
  objects.of_view(name, p, t)
  local known = m.links
  if known and known.links == t and (count == nil or known.count == count) then return true end
  count = count or RAYS
  handle, message, code = check.result(name, p.lib.shade_links(p.view, t, count, p.options.seed, o.threads or 0,
    progress.resolve(o.progress), p.options.gloss == "matte" and "matte" or "both"))
  if not handle then return nil, message, code end
  local stats = p.lib.shade_links_stats(handle)
  m.links = { handle = handle, links = t, count = count, stats = stats }
  m.stats.links, m.stats.link_rays, m.stats.link_bytes, m.stats.link_seconds = count, stats.rays, stats.bytes, stats.seconds
  return true
end

--- Links of those points of a view that gloss to the elements of t, kept: { handle =, links =, count =, stats = }; or nil,
-- message, code.
local function link_glossy(name, p, t, o)
  local m = views.made[p.view]
  local known = m.links or m.gloss_links
  if known and known.links == t and (o.rays == nil or known.count == o.rays) then return known end
  objects.of_view(name, p, t)
  local count = o.rays or RAYS
  local handle, message, code = check.result(name, p.lib.shade_links(p.view, t, count, p.options.seed, o.threads or 0,
    progress.resolve(o.progress), "gloss"))
  if not handle then return nil, message, code end
  m.gloss_links = { handle = handle, links = t, count = count, stats = p.lib.shade_links_stats(handle) }
  return m.gloss_links
end

--- Light on the elements of links for b.bounces reflections after direct light, the last at the shading points: b.lit,
-- or nil, message, code.
local function shine(p, o, b)
  local t, message, code = links_of(p, o)
  if not t then return nil, message, code end
  b.lit, message, code = t:radiosity(o.lights or p.scene.lights, { bounces = b.bounces == "all" and "all" or b.bounces - 1,
    seed = p.options.seed, threads = o.threads, progress = o.progress })
  return b.lit, message, code
end

--- Light of o.links's elements for glossy points: { lit =, links = }; or nil, message, code.
function links.elements(name, p, o)
  objects.check_scene(name, o.links, p.scene)
  local lit, message, code = shine(p, o, { bounces = "all" })
  if not lit then return nil, message, code end
  local found
  found, message, code = link_glossy(name, p, o.links, o)
  if not found then return nil, message, code end
  return { lit = lit, links = found }
end

-- The way ------------------------------------------------------------------------------------

function links.wants(o)
  local x, kind = o.bounced, core.type(o.bounced)
  return x == nil or x == "links" or kind == "ylm.links" or kind == "ylm.radiosity"
end

function links.settle(name, o, s, bounces)
  local x, kind = o.bounced, core.type(o.bounced)
  if kind == "ylm.radiosity" then
    if o.bounces ~= nil then
      return check.fail("%s: bounces are those of the radiosity that bounced names: leave one out", name)
    end
    return { lit = x, bounces = objects.open_radiosity(name, x).options.bounces }
  end
  if kind == "ylm.links" then
    objects.check_scene(name, x, s)
    o.links = x
  end
  if bounces ~= "all" and bounces > MOST then
    return check.bad(1, name, "bounces must be an integer from 0 to %d, or 'all', got %.0f", MOST, bounces)
  end
  return bounces ~= 0 and { bounces = bounces } or nil
end

function links.prepare(name, p, o)
  local b, start = o.reflected, core.seconds()
  if not b.lit then
    local lit, message, code = shine(p, o, b)
    if not lit then return nil, message, code end
  elseif o.links and o.links ~= b.lit.links then
    return check.fail("%s: bounced is of other links than the option links: leave links out", name)
  end
  if not o.halves then
    local ok, message, code = links.link(name, p, b.lit.links, o)
    if not ok then return nil, message, code end
  end
  b.prepared = core.seconds() - start
  return true
end

--- Sets of links beside those that are kept, as camera rays are more than usual; they are found anew for each picture.
local function more_sets(p, o)
  if o.rays or p.traced.glossy > 0 or p.options.shading == "vertices" then return 0 end
  local count = views.made[p.view].links.count
  return math.max(0, math.floor((options.multiple(p.options) - 1) * count / SET))
end

--- Adds the light of `more` sets of links to that of those that are kept, `own`, each link alike. Or nil, message, code.
local function add_sets(name, p, o, own, more)
  local n, count = p.stats.points, views.made[p.view].links.count
  local first, second = array.zeros({ n, 3 }, "float"), array.zeros({ n, 3 }, "float")
  local seed = (o.seed or p.options.seed) + APART
  local rays, message, code = check.result(name, p.lib.shade_gather_sets(p.view, { transfer = views.made[p.view].links.links,
    lit = o.reflected.lit, links = SET, sets = array.zeros({ n }, "float") + more, first = first, second = second, seed = seed,
    threads = o.threads or 0, progress = progress.resolve(o.progress) }))
  if not rays then return nil, message, code end
  o.reflected.more = more
  local half = math.ceil(more / 2)
  return (own * count + first * (half * SET) + second * ((more - half) * SET)) / (count + more * SET)
end

function links.radiance(name, p, o, start)
  local b = o.reflected
  local more = more_sets(p, o)
  local kept = start
  if more > 0 then start = nil end
  local all, message, code = check.result(name, p.lib.shade_gather(p.view, views.made[p.view].links.handle, b.lit, start,
    o.threads or 0, progress.resolve(o.progress)))
  if not all then return nil, message, code end
  if more > 0 then
    all, message, code = add_sets(name, p, o, all, more)
    if not all then return nil, message, code end
    start = kept
    if start then all = p.lib.shade_add(all, start) end
  end
  if b.unasked and start then b.share = 1 - start:sum() / math.max(all:sum(), 1e-300) end
  return all
end

--- Says that links are few for what is bright, and what to change; `noise` is that of a pixel.
local function say_noise(p, report, count, noise)
  local enough = math.min(core.limits.transfer_links, 64 * math.ceil(noises.enough(count, noise) / 64))
  local left = noise * math.sqrt(count / enough)
  local advice = left <= noises.LOUD and ("set rays = %d for %.0f %%, or a tolerance"):format(enough, 100 * left)
    or "few of them meet what is bright; set a tolerance, which chooses camera rays too"
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "links", "scene %q: %d links of a shading point leave a noise of "
    .. "%.0f %% in the light that bounces: %s", p.scene.name or "?", count, 100 * noise, advice)
end

--- Says what bounced light lacks where surfaces are glossy.
local function say_gloss(p, report)
  local n = p.traced.glossy
  if n == 0 then return end
  local one, what = n == 1, n == 1 and "1 mesh is glossy: " or n .. " meshes are glossy: "
  if p.options.gloss == "matte" then
    what = what .. (one and "bounced light meets it as a matte one of its mean albedo"
      or "bounced light meets them as matte ones of their mean albedo")
  else
    what = what .. (one and "it sends light to others as a matte one of its mean albedo"
      or "they send light to others as matte ones of their mean albedo")
      .. ", no highlights in reflections, no caustics: scene:pathtrace has them"
  end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss bounced", "scene %q: %s", p.scene.name or "?", what)
end

function links.report(p, o, report)
  local m, b = views.made[p.view], o.reflected
  report.elements, report.balance = b.lit.links.stats.elements, b.lit.stats.balance
  report.elements_error = b.lit.stats.elements_error
  if b.gathered then
    report.rays.links, report.rays.sets = report.rays.sets, nil
    say_gloss(p, report)
    return
  end
  local more = SET * (b.more or 0)
  report.links, report.rays.links = m.links.count + more, m.links.stats.rays + more * p.stats.points
  report.bounced_noise = p.lib.shade_gather_noise(m.links.handle, b.lit) * math.sqrt(m.links.count / report.links)
  local noise = noises.of_pixel(p, report.bounced_noise)
  local whole = noise * (b.share or 1) -- of bounces that nobody asked for, beside all light
  if whole > noises.LOUD and not o.tolerance then say_noise(p, report, report.links, noise) end
  report.rays.gloss_links = m.links.stats.glossy
  say_gloss(p, report)
end

return links
