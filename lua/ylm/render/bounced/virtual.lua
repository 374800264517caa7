--- Light that bounces by virtual lights: each is asked at each shading point, or far and near parts where that is cheaper.

local check = require "ylm.check"
local core = require "ylm.c.core"
local emit = require "ylm.emit"
local form = require "ylm.form"
local near = require "ylm.render.near"
local progress = require "ylm.progress"
local rival = require "ylm.render.bounced.rival"
local split = require "ylm.render.bounced.split"
local views = require "ylm.render.view"
local warning = require "ylm.warning"
local windows = require "ylm.render.window"

local virtual = { name = "virtual", called = "bounced = 'virtual'" }

local LMAX, ZONAL_LMAX, LIMIT_LMAX = 4, 14, 100
local TILE, MOST_TILE = 4, 16
local LOOKED, RAYED = { 32, 18 }, 2000 -- pixels and lights by which light that passes walls is measured
local MOST = core.limits.emit_bounces

-- Options ------------------------------------------------------------------------------------

--- Options of harmonics, which rivals refuse.
local harmonics = {
  { "lmax", "integer", min = 0, max = LIMIT_LMAX, optional = true,
    about = "highest degree, default " .. LMAX .. ", with zonal " .. ZONAL_LMAX .. "; 60 where surfaces are glossy" },
  { "zonal", "boolean", optional = true,
    about = "lobes of glossy surfaces are circular about an axis, above a matte base, and cost as much as a matte surface; "
      .. "default false" },
  { "window", "any", optional = true,
    about = "{ name, width } of sh.window, which damps what the receiver weighs light with" },
  { "horizon", "choice", of = core.choices "horizon", optional = true,
    about = "of lights near the receiver's horizon, 'paper' takes a smooth part away, 'gate' drops those wholly below; "
      .. "default 'none'" },
  split.fields[1], split.fields[2],
}

local sum_fields = {
  { "shadows", "choice", of = { "none", "centre" }, default = "none",
    about = "'centre': a ray from each point to each light; 'none': they shine through walls" },
  { "subset", "choice", of = core.choices "subset", default = "all",
    about = "lights that a point asks: 'interleaved', those of its place in a tile of pixels, and then the mean over such a "
      .. "tile, of points on the same mesh whose normals are within 20 degrees; 'stochastic', bright ones, and others by "
      .. "chance, which then count for more: the mean over seeds is that of all" },
  { "tile", "integer", min = 2, max = MOST_TILE, optional = true,
    about = "'interleaved': pixels a side, of which each asks one light of tile^2; default " .. TILE },
  { "alpha", "number", above = 0, optional = true, unit = "W m^-2",
    about = "'stochastic': a light that gives more, shadows aside, is kept; one that gives b, with the chance b/alpha; "
      .. "default: by which points keep about 64 lights" },
}
for _, field in ipairs(harmonics) do sum_fields[#sum_fields + 1] = field end

virtual.options = {
  { "virtual", "table", optional = true, fields = sum_fields, shelf = "experiments",
    about = "how virtual lights are summed: a table of the fields below" },
}
virtual.view_options = { rival.field }

--- Settles how lights are summed: the table of the option virtual, checked; `x`: the rival, or nil.
local function sum_of(name, given, x)
  local own = form.options(1, name .. ": virtual", sum_fields, given)
  for key, subset in pairs { tile = "interleaved", alpha = "stochastic" } do
    if own[key] and own.subset ~= subset then
      return check.fail("%s: virtual: %s is for subset = '%s', this is '%s': leave it out", name, key, subset, own.subset)
    end
  end
  if own.subset == "interleaved" then own.tile = own.tile or TILE end
  for _, field in ipairs(x and harmonics or {}) do
    if type(given) == "table" and given[field[1]] ~= nil then
      return check.fail("%s: virtual: %s is of harmonics, which rival = '%s' has none of: leave one out", name, field[1],
        x.method)
    end
  end
  if not x then own.lmax = own.lmax or own.zonal and ZONAL_LMAX or LMAX end
  return own
end

function virtual.wants(o) return o.bounced == "virtual" or form.kind(o.bounced) == "virtual_lights" end

function virtual.settle(name, o, s, bounces)
  local x = rival.settle(name, o.rival)
  local own = sum_of(name, o.virtual, x)
  rival.check_subset(name, x, own)
  if o.bounced ~= "virtual" then
    if o.bounces ~= nil then
      return check.fail("%s: bounces are those of the virtual lights that bounced names: leave one out", name)
    end
    local made = emit.made(o.bounced)
    return { lights = o.bounced, bounces = made and made.bounces or "those of the lights", options = own, rival = x, scene = s,
      emitted = made and made.report }
  end
  if bounces ~= "all" and bounces > MOST then
    return check.fail("%s: particles are reflected %d times at most: bounces must be 0 to %d or 'all', got %.0f", name, MOST,
      MOST, bounces)
  end
  if bounces == 0 then return nil end
  return { bounces = bounces, options = own, rival = x, scene = s }
end

-- Sums ---------------------------------------------------------------------------------------

--- Radiance of the shading points of a view by options that are settled, and the report of C; nil, message, code.
function virtual.sum(name, p, o)
  local x = o.rival or {}
  return check.result(name, rival.ask(p, o.lights.lights, {
    method = x.method or "hvl", lmax = o.lmax or 0, window = windows.factors(name, o), horizon = o.horizon, clamp = x.clamp,
    limit = x.limit, compensate = x.compensate, bounces = math.max(1, o.bounces or 1), samples = x.samples,
    strategy = x.strategy, shadows = o.shadows == "centre", groups = x.groups, zonal = o.zonal,
    matte = p.options.gloss == "matte", subset = o.subset, tile = o.tile, alpha = o.alpha, seed = o.seed or p.options.seed,
    threads = o.threads or 0, progress = progress.resolve(o.progress) }))
end

--- Makes the lights of o.reflected, and their parts where these are summed.
function virtual.prepare(name, p, o)
  local b, start = o.reflected, core.seconds()
  if not b.lights then
    local own = form.options(1, name, emit.fields, {})
    own.bounces = b.bounces == "all" and MOST or b.bounces
    own.seed, own.threads, own.progress = p.options.seed, o.threads, o.progress
    local lights, report, code = emit.lights(name, p.scene, own, o.lit)
    if not lights then return nil, report, code end
    b.lights, b.emitted = lights, report
  end
  if b.rival then rival.ready(name, p, b) end
  b.split = not b.rival and split.is_wanted(name, p, b)
  if b.split then
    local ok, message, code = split.ready(name, p, o, b)
    if not ok then return nil, message, code end
  end
  b.prepared = core.seconds() - start
  return true
end

function virtual.radiance(name, p, o, start)
  local b, own = o.reflected, { seed = o.seed, threads = o.threads, progress = o.progress }
  local out, facts, code
  if b.split then out, facts, code = split.radiance(name, p, o, b)
  else
    for key, value in pairs(b.options) do own[key] = value end
    own.lights, own.rival, own.bounces = b.lights, b.rival, b.rival and b.rival.bounces
    out, facts, code = virtual.sum(name, p, own)
    b.facts = out and facts
  end
  if not out then return nil, facts, code end
  if not start then return out end
  return check.result(name, p.lib.shade_add(out, start))
end

-- The report ---------------------------------------------------------------------------------

--- The part of the light of virtual lights in a view that surfaces would stop: by the mean light of LOOKED shading points of a
-- small picture, with and without rays to at most RAYED lights; nil where nobody knows.
local function passing(name, p, lights, threads)
  local known = core.owned(p.view, "passing") -- of the virtual lights that were asked of last
  if known and known.lights == lights then return known.part end
  if lights.profile == "near" or lights.count == 0 or not p.options.camera then return nil end
  local small = views.prepare(name, p.scene, { camera = p.options.camera, size = LOOKED, samples = 1, seed = p.options.seed,
    share = 0, shading = "pixel", visibility = "rays", lmax = 0, coarse = true, gloss = "matte", threads = threads })
  if not small then return nil end
  local q, sums = views.open(name, small), {}
  local subset = lights.count > RAYED and "stochastic" or "all"
  for i, shadows in ipairs { "none", "centre" } do
    local radiance = virtual.sum(name, q, { lights = lights, lmax = LMAX, shadows = shadows,
      subset = subset, alpha = subset ~= "all" and RAYED / lights.count or nil, threads = threads })
    sums[i] = radiance and radiance:sum() or 0
  end
  small:close()
  local part = sums[1] > 0 and math.max(0, 1 - sums[2] / sums[1]) or nil
  core.own(p.view).passing = { lights = lights, part = part }
  return part
end

--- Adds to report.warnings the promises that pictures by virtual lights do not keep.
local function say(name, p, o, report)
  local list, b, n = report.warnings, o.reflected, p.traced.glossy
  if b.options.shadows ~= "centre" then
    report.passing = passing(name, p, b.lights, o.threads)
    near.say_walls(p, report, report.passing)
  end
  if n == 0 or p.options.gloss ~= "matte" then return end
  list[#list + 1] = warning.say(p.scene, "gloss gathered", n == 1
    and "scene %q: 1 mesh is glossy: virtual lights shade it as a matte one of its mean albedo"
    or "scene %q: " .. n .. " meshes are glossy: virtual lights shade them as matte ones of their mean albedo",
    p.scene.name or "?")
end

function virtual.report(p, o, report, image)
  local b = o.reflected
  local own, facts, m = b.options, b.facts, image.metadata
  report.virtual = { lights = b.lights.count, pairs = facts.pairs, shadows = own.shadows, emitted = b.emitted,
    sums = b.split and "split" or "all", subset = own.subset, singular = facts.singular }
  local r = report.virtual
  r.ns_per_pair = facts.pairs > 0 and facts.seconds and 1e9 * facts.seconds / facts.pairs or nil
  if own.subset == "stochastic" then r.alpha, r.kept = facts.alpha, facts.kept / math.max(1, p.stats.points) end
  if b.split then split.report(p, b, report) end
  if b.rival then rival.report(b, r, facts) end
  report.rays.virtual = facts.rays
  for _, sentence in ipairs(b.emitted and b.emitted.warnings or {}) do report.warnings[#report.warnings + 1] = sentence end
  say("render", p, o, report)
  m.virtual_lights, m.virtual_shadows, m.profile = b.lights.count, own.shadows, b.lights.profile
  m.rival, m.limit, m.light_degree = b.rival and b.rival.method, b.rival and b.rival.limit, own.lmax
  m.subset, m.tile, m.alpha = own.subset ~= "all" and own.subset or nil, own.tile, r.alpha
end

return virtual
