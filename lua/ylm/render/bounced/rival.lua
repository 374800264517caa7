--- Pictures by virtual lights, each asked at each shading point: view:gather.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local emit = require "ylm.emit"
local form = require "ylm.form"
local near = require "ylm.render.near"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"
local views = require "ylm.render.view"
local warning = require "ylm.warning"
local window = require "ylm.sh.window"

local gather = {}

local TILE, MOST_TILE = 4, 16
local LOOKED, RAYED = { 32, 18 }, 2000 -- pixels and lights by which light that passes walls is measured
local LMAX, ZONAL_LMAX, LIMIT_LMAX, SAMPLES, GROUPS = 4, 14, 100, 25, 400

--- Options of one method, which others refuse.
local own = {
  hvl = {
    { "lmax", "integer", min = 0, max = LIMIT_LMAX, optional = true,
      about = "'hvl': highest degree, default " .. LMAX .. ", with zonal " .. ZONAL_LMAX .. "; 60 where surfaces gloss" },
    { "zonal", "boolean", optional = true,
      about = "'hvl': lobes of surfaces that gloss are circular about an axis, above a matte base, and cost as much as a matte "
        .. "surface; default false" },
    { "window", "any", optional = true,
      about = "'hvl': { name, width } of sh.window, which damps what the receiver weighs light with" },
    { "horizon", "choice", of = { "none", "paper", "gate" }, optional = true,
      about = "'hvl': of lights near the receiver's horizon, 'paper' takes a smooth part away, 'gate' drops those wholly below; "
        .. "default 'none'" },
  },
  vpl = {
    { "clamp", "choice", of = { "none", "distance", "geometry", "whole" }, optional = true,
      about = "'vpl': what limit bounds: 1/d^2, the geometry term c c/d^2, or this times the receiver's albedo/pi; "
        .. "default 'geometry'" },
    { "limit", "number", above = 0, optional = true, about = "'vpl': default 1/r^2, r the median of the lights' radii" },
    { "compensate", "integer", min = 0, max = core.limits.light_samples, optional = true,
      about = "'vpl': rays of a point that find what the clamp takes away, of lights of scene:virtual_lights; default 0" },
  },
  vsl = {
    { "samples", "integer", min = 1, max = core.limits.light_samples, optional = true,
      about = "'vsl': directions to a light, times 1 - the cosine of its half angle, at least 4; of 'receiver' all; default "
        .. SAMPLES },
    { "strategy", "choice", of = { "cone", "receiver", "mis" }, optional = true,
      about = "'vsl': directions in the light's cone, by the receiver's cosine, or both and the light's, weighed; default "
        .. "'mis'" },
  },
}

own.vsgl = {
  { "groups", "integer", min = 1, optional = true,
    about = "'vsgl': groups of lights, parted where they are widest in place and direction; default " .. GROUPS
      .. ", or as many as lights" },
}

local gather_options = options.list({
  { "lights", "object", of = "virtual_lights", about = "scene:virtual_lights has the scene's" },
  { "method", "choice", of = { "hvl", "vpl", "vsl", "vsgl" }, default = "hvl",
    about = "harmonics of the lights' profile, points, spheres, or groups of lights as spherical Gaussians" },
}, own.hvl, own.vpl, own.vsl, own.vsgl, {
  { "shadows", "choice", of = { "none", "centre" }, default = "none",
    about = "'centre': a ray from each point to each light; 'none': they shine through walls" },
  { "subset", "choice", of = { "all", "interleaved", "stochastic" }, default = "all",
    about = "lights that a point asks: 'interleaved', those of its place in a tile of pixels, and then the mean over such a "
      .. "tile, of points on the same mesh whose normals are within 20 degrees; 'stochastic', bright ones, and others by "
      .. "chance, which then count for more: the mean over seeds is that of all" },
  { "tile", "integer", min = 2, max = MOST_TILE, optional = true,
    about = "'interleaved': pixels a side, of which each asks one light of tile^2; default " .. TILE },
  { "alpha", "number", above = 0, optional = true, unit = "W m^-2",
    about = "'stochastic': a light that gives more, shadows aside, is kept; one that gives b, with the chance b/alpha; "
      .. "default: by which points keep about 64 lights" },
  { "seed", "integer", min = 0, max = core.limits.seed, optional = true,
    about = "of vsl, compensate and 'stochastic'; default: that of the view" },
}, options.layer_fields, options.common)

--- Raises where options are another method's.
local function refuse_others(o)
  for method, fields in pairs(own) do
    for _, field in ipairs(fields) do
      if method ~= o.method and o[field[1]] ~= nil then
        return check.fail("gather: %s is for method = '%s', this is '%s': leave it out", field[1], method, o.method)
      end
    end
  end
end

--- The factors of a window by degree, or nil.
local function factors(o)
  local w = o.window
  if w == nil then return nil end
  if type(w) == "string" then w = { w } end
  if type(w) ~= "table" or type(w[1]) ~= "string" then
    return check.bad(1, "gather", "window: { name, width } of sh.window expected, got %s", check.describe(o.window))
  end
  local ones, list = {}, {}
  for k = 1, (o.lmax + 1) ^ 2 do ones[k] = 1 end
  local c = window.window(array.array(ones, "double"), w[1], w[2])
  for l = 0, o.lmax do list[l + 1] = c:get(l * l + l + 1) end
  return list
end

--- 1 over the square of the median radius.
local function default_limit(lights)
  local _, _, radius = core.lights_virtual_arrays(lights.lights)
  local sorted = core.array_totable(radius)
  table.sort(sorted)
  local r = sorted[math.floor(#sorted / 2) + 1]
  if #sorted == 0 then return 1 end
  if r > 0 and 1 / r ^ 2 < math.huge then return 1 / r ^ 2 end
  return check.fail("gather: limit is needed: the lights have %s to find one by",
    r > 0 and ("too small a radius (%g)"):format(r) or "no radius")
end

--- Settles the options that one method has.
local function settle(p, o)
  refuse_others(o)
  for name, subset in pairs { tile = "interleaved", alpha = "stochastic" } do
    if o[name] and o.subset ~= subset then
      return check.fail("gather: %s is for subset = '%s', this is '%s': leave it out", name, subset, o.subset)
    end
  end
  if o.subset ~= "all" and o.method == "vsgl" then
    return check.fail("gather: subset = '%s' is of single lights, method = 'vsgl' asks all of its groups", o.subset)
  end
  if o.subset == "interleaved" then o.tile = o.tile or TILE end
  if o.lights.profile ~= "point" and o.lights.profile ~= "gauss" and o.lights.profile ~= "cap" and o.method ~= "hvl" then
    return check.fail("gather: lights of profile '%s' are parts of lights, which only method = 'hvl' knows", o.lights.profile)
  end
  if o.method == "hvl" then o.lmax = o.lmax or o.zonal and ZONAL_LMAX or LMAX
  elseif o.method == "vpl" then
    o.clamp, o.compensate = o.clamp or "geometry", o.compensate or 0
    if o.clamp ~= "none" then o.limit = o.limit or default_limit(o.lights)
    elseif o.limit then return check.fail "gather: limit is of a clamp, clamp is 'none': leave it out" end
    if o.compensate > 0 then
      if o.clamp == "none" then
        return check.fail "gather: compensate finds what a clamp takes away, clamp is 'none': leave it out"
      end
      local made = emit.made[o.lights]
      if not made or made.scene ~= p.scene then
        return check.fail("gather: compensate needs lights that scene:virtual_lights made of the view's scene, whose lamps it "
          .. "asks")
      end
      o.bounces = made.bounces
    end
  elseif o.method == "vsgl" then
    if o.groups and o.groups > o.lights.count then
      return check.fail("gather: groups (%d) must be at most the %d lights", o.groups, o.lights.count)
    end
    o.groups = math.min(o.groups or GROUPS, o.lights.count)
  else o.samples, o.strategy = o.samples or SAMPLES, o.strategy or "mis" end
end

--- Radiance of the shading points of a view by options that are settled, and the report of C; nil, message, code.
function gather.radiance(name, p, o)
  return check.result(name, p.lib.shade_virtual(p.view, o.lights.lights, {
    method = o.method, lmax = o.lmax or 0, window = factors(o), horizon = o.horizon, clamp = o.clamp, limit = o.limit,
    compensate = o.compensate, bounces = math.max(1, o.bounces or 1), samples = o.samples, strategy = o.strategy,
    shadows = o.shadows == "centre",
    groups = o.groups, zonal = o.zonal, matte = p.options.gloss == "matte", subset = o.subset, tile = o.tile,
    alpha = o.alpha, seed = o.seed or p.options.seed, threads = o.threads or 0,
    progress = progress.resolve(o.progress) }))
end

--- View -> the part of its virtual lights' light that passes walls, by the lights.
local passing_of = setmetatable({}, { __mode = "k" })

--- The part of the light of virtual lights in a view that surfaces would stop: by the mean light of LOOKED shading points of a
-- small picture, with and without rays to at most RAYED lights; nil where nobody knows.
local function passing(p, lights, threads)
  local known = passing_of[p.view]
  if known and known.lights == lights then return known.part end
  if lights.profile == "near" or lights.count == 0 or not p.options.camera then return nil end
  local small = views.prepare("gather", p.scene, { camera = p.options.camera, size = LOOKED, samples = 1, seed = p.options.seed,
    share = 0, shading = "pixel", visibility = "rays", lmax = 0, coarse = true, gloss = "matte", threads = threads })
  if not small then return nil end
  local q, sums = views.open("gather", small), {}
  local subset = lights.count > RAYED and "stochastic" or "all"
  for i, shadows in ipairs { "none", "centre" } do
    local radiance = gather.radiance("gather", q, { lights = lights, method = "hvl", lmax = LMAX, shadows = shadows,
      subset = subset, alpha = subset ~= "all" and RAYED / lights.count or nil, threads = threads })
    sums[i] = radiance and radiance:sum() or 0
  end
  small:close()
  local part = sums[1] > 0 and math.max(0, 1 - sums[2] / sums[1]) or nil
  passing_of[p.view] = { lights = lights, part = part }
  return part
end

--- Adds to report.warnings the promises that pictures by virtual lights do not keep.
function gather.say(p, shadows, report, lights, threads)
  local list = report.warnings
  if shadows ~= "centre" then
    report.passing = passing(p, lights, threads)
    near.say_walls(p, report, report.passing)
  end
  local n = p.traced.glossy
  if n == 0 or p.options.gloss ~= "matte" then return end
  list[#list + 1] = warning.say(p.scene, "gloss gathered", n == 1
    and "scene %q: 1 mesh is glossy: virtual lights shade it as a matte one of its mean albedo"
    or "scene %q: " .. n .. " meshes are glossy: virtual lights shade them as matte ones of their mean albedo",
    p.scene.name or "?")
end

describe "prepared:gather" {
  about = "The light of virtual lights on a prepared view, each light asked at each shading point: by their harmonics, and by "
    .. "the methods that are their rivals, on the same lights. There is no direct light in it, and no lamp in sight.",
  arguments = { { "options", "table", "lights are needed" } },
  options = gather_options,
  returns = { { "image", "image", "" }, { "report", "table", options.report_text .. "method, lights, pairs, "
    .. "ns_per_pair; rays.shadow; limit, where a clamp has one; groups, of 'vsgl'; singular: pairs of a shading point and a "
    .. "light without size at its place, which count as nothing; subset; of 'stochastic' alpha, and kept: lights of a point "
    .. "in the mean; without shadows passing: the part of the light that passes walls" } },
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local lights = scene:virtual_lights { count = 50 }
local view = scene:prepare { size = { 32, 18 }, samples = 1 }
local image, report = view:gather { lights = lights }
assert(report.pairs == lights.count * view.stats.points)
assert(view:gather { lights = lights, method = "vpl", clamp = "distance", limit = 4 })]],
  source = "Mezieres & Paulin 2022; Keller 1997; Kollig & Keller 2004; Hasan et al. 2009; Tokuyoshi 2015",
}
function views.methods.gather(view, given)
  local p = views.open("gather", view)
  local o = form.options(1, "gather", gather_options, given)
  pictures.check_truth("gather", p, o)
  settle(p, o)
  local start = core.seconds()
  local report = pictures.new_report(p)
  local radiance, facts, code = gather.radiance("gather", p, o)
  if not radiance then return nil, facts, code end
  report.method, report.lights, report.limit, report.visibility = o.method, o.lights.count, o.limit, o.shadows
  report.pairs, report.rays.shadow, report.singular = facts.pairs, facts.rays, facts.singular
  report.groups = o.method == "vsgl" and facts.lights or nil
  report.ns_per_pair = facts.pairs > 0 and 1e9 * facts.seconds / facts.pairs or 0
  report.subset = o.subset
  if o.subset == "stochastic" then
    report.alpha, report.kept = facts.alpha, facts.kept / math.max(1, p.stats.points)
  end
  gather.say(p, o.shadows, report, o.lights, o.threads)
  local out, message
  out, message, code = pictures.picture("gather", p, function(layer)
    return check.result("gather", p.lib.shade_resolve(p.view, radiance, nil, false, o.threads or 0, layer))
  end, o)
  if not out then return nil, message, code end
  pictures.finish(report, start, facts.seconds)
  pictures.sign(out, p, "gather " .. o.method, report, { lights = o.lights.count, shadows = o.shadows, limit = o.limit,
    profile = o.lights.profile, light_degree = o.lmax, subset = o.subset, tile = o.tile, alpha = report.alpha })
  return out, report
end

return gather
