--- Glossy surfaces in pictures by coefficients of light: by harmonics, by rays, or as matte ones.
--
--     light                   gloss    shades such surfaces
--     lamps, by coefficients  auto     by harmonics where their lobes are wide enough for lmax, else by rays (default)
--                             sh       by harmonics
--                             rays     by rays to the lamps
--     direct, indirect, all   auto     by harmonics; with links by rays where lmax is too low, to lamps and elements
--                             sh       by harmonics
--                             rays     by these rays, with links
--     any                     matte    as matte ones of their mean albedo

local beyond = require "ylm.render.bounced.grid".BEYOND
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local grids = require "ylm.grid"
local light = require "ylm.light"
local links = require "ylm.render.bounced.links"
local material = require "ylm.material"
local progress = require "ylm.progress"
local options = require "ylm.render.options"
local tracing = require "ylm.trace"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"
local window = require "ylm.sh.window"

local gloss = {}

-- Options ------------------------------------------------------------------------------------

--- The part of a slice's norm that harmonics may miss: below the first they shade alone, above the second rays do.
gloss.BAND = { 0.01, 0.03 }

function form.types.gloss_error(x)
  if type(x) == "table" and #x == 2 and type(x[1]) == "number" and type(x[2]) == "number" and x[1] >= 0 and x[1] < x[2]
    and x[2] < math.huge then return { x[1], x[2] } end
  return nil, "two numbers, 0 <= first < second"
end

--- Options of views.
gloss.fields = {
  { "gloss", "choice", of = core.choices "gloss", optional = true,
    about = "where coefficients of light shade glossy surfaces, 'auto' (default): by harmonics of f cos, times visibility, "
      .. "to lmax, and by rays to the lamps where lmax is too low for a lobe (under a grid of direct, indirect or all light with "
      .. "links = scene:links {}, whose elements rays find); 'sh', 'rays': by one of them alone; 'matte': as matte ones of "
      .. "their mean albedo, bounces too" },
  { "gloss_error", "gloss_error", shelf = "experiments", default = gloss.BAND,
    about = "'auto': the part of a lobe's norm that lmax misses (material:degrees) up to which harmonics shade alone, and from "
      .. "which on rays do; mixed between" },
  { "below", "choice", of = { "mirror", "dark" }, default = "mirror", shelf = "experiments",
    about = "visibility below a glossy surface, for its product with f cos in harmonics: the mirror image of that above, "
      .. "or none, which costs accuracy, and keeps light from below out of lobes that lmax is far too low for" },
  { "window", "choice", of = window.names, optional = true, shelf = "experiments",
    about = "damps degrees of f cos in harmonics against ringing, as ylm.sh.window; lobes become wider" },
  { "window_width", "number", above = 0, optional = true, unit = "degrees l", shelf = "experiments",
    about = "of window; default lmax + 1" },
}

--- The noise that rays may leave where nobody says how many they are, and the most of them.
local NOISE, MOST_SAMPLES = 0.01, 16384
--- The noise that is said aloud.
local LOUD_NOISE = 0.02
--- The quantity that report.glossy.noise is.
local NOISE_OF = "the mesh that has most: error of its radiance, root mean square over that of the radiance"

--- Is a surface of the scene anything but matte?
local function is_glossy(s)
  for _, g in ipairs(s.geometry) do
    if g.material and material.glossy(g.material) then return true end
  end
  return false
end

--- Settles o.gloss, o.visibility being settled. `held`: what the grid of a picture holds, false without a grid, nil where
-- there may be one later.
function gloss.settle(name, o, given, s, held)
  local by_rays = o.visibility == "rays" and held == false
  local bounced = o.reflected ~= nil
  if by_rays and (o.gloss == "sh" and not (bounced and o.reflected.grid) or o.gloss == "matte" and not bounced) then
    return check.fail('%s: gloss is for a grid (by = "grid"), and this picture is by rays: name one that fits, or '
      .. "leave gloss out", name)
  end
  if held and held ~= "lights" and o.gloss == "rays" and not o.links then
    return check.fail("%s: gloss = 'rays': rays find light of lamps, the grid holds %s light: gloss = 'sh', or leave the grid "
      .. "out, or give links = scene:links {}, whose elements rays find", name,
      held == "all" and "direct and indirect" or held)
  end
  if type(given) == "table" and given.gloss_error and o.gloss and o.gloss ~= "auto" then
    return check.fail("%s: gloss_error is for gloss = 'auto', gloss is %q: leave one out", name, o.gloss)
  end
  if by_rays and not bounced then o.gloss = nil else o.gloss = o.gloss or "auto" end
  gloss.check_harmonics(name, o, given, by_rays and not bounced)
  if o.gloss == "rays" and o.shading == "vertices" and not by_rays and is_glossy(s) then
    return check.fail("%s: gloss = 'rays': rays start at what camera rays hit: shading = 'pixel'", name)
  end
  if o.light_samples and not by_rays and not (is_glossy(s) and (o.gloss == "auto" or o.gloss == "rays")) then
    return check.fail("%s: light_samples is for by = 'rays', and for glossy surfaces: leave it out", name)
  end
end

--- Raises where options about harmonics are given and no glossy surface is shaded by them.
function gloss.check_harmonics(name, o, given, by_rays)
  if type(given) ~= "table" then return end
  local harmonics = not by_rays and (o.gloss == "auto" or o.gloss == "sh")
  for _, field in ipairs { "below", "window", "gloss_error" } do
    if given[field] ~= nil and not harmonics then
      return check.fail("%s: %s is for glossy surfaces in harmonics, gloss = 'auto' or 'sh': leave it out", name, field)
    end
  end
  if o.below == "dark" and o.visibility ~= "transfer" then
    return check.fail("%s: below = 'dark' is a visibility: name visibility = 'transfer', or leave it out", name)
  end
  if o.window_width and not o.window then
    return check.fail("%s: window_width is of a window: name one ('hann'), or leave it out", name)
  end
end

--- Do light_samples count in pictures of a prepared view by coefficients of light?
function gloss.takes_samples(p)
  local by = p.options.gloss
  return p.traced.glossy > 0 and (by == "auto" or by == "rays")
end

-- Lamps --------------------------------------------------------------------------------------

--- The lamps that a field is the light of, as a set; nil: not known, or not of lamps alone.
local function lamps_of(field)
  local lights = core.type(field) == "ylm.grid" and grids.lights_of(field) or field
  return light.followed(lights)
end

--- The traced scene of these lamps; nil: that of the view. Or false, message, code.
local function traced_with(name, p, lights)
  if lights == p.traced.lights then return nil end
  local known = core.owned(p.view, "relit") -- lights that its scene was traced with last, and the scene
  if known and known.lights == lights then return known.handle end
  local lit, message, code = tracing.relight(name, p.traced, lights)
  if not lit then return false, message, code end
  core.own(p.view).relit = { lights = lights, handle = lit.handle }
  return lit.handle
end

-- Pictures -----------------------------------------------------------------------------------

--- The reason why rays shade nothing in a picture that might want them; nil: they do.
local function hindrance(p, o, field)
  if p.options.shading == "vertices" then return "rays start at pixels, shading is 'vertices'" end
  if o.weight == "cosine" then
    if o.nearby then return "rays find no virtual lights" end
    local gathered = visibility.quantity(field) == "direct" and o.reflected and o.reflected.lit
    return not (o.links or gathered) and "a grid's light that knows its shadows shades without rays" or nil
  end
  if not lamps_of(field) then
    return core.type(field) == "ylm.grid" and "the lamps behind the grid are not known (it was loaded, or holds other light)"
      or "the light is not of lamps alone that rays find (virtual lights and spots are none of them)"
  end
  return nil
end

--- Rays for light that knows its shadows: to the lamps of the scene for direct light, to elements for what bounces. True, or
-- nil, message, code.
local function aim_beyond(name, p, o, x, held)
  local message, code
  if held ~= "indirect" then
    x.samples, x.noise = o.light_samples or options.LIGHT_SAMPLES, not o.light_samples and NOISE or nil
    x.lit = o.lit and o.lit.handle
  end
  if held ~= "direct" then
    x.elements, message, code = links.elements(name, p, o)
    if not x.elements then return nil, message, code end
  end
  return true
end

--- Rays to the lamps that a field is the light of. True, or nil, message, code.
local function aim_at_lamps(name, p, o, x, field)
  local message, code
  x.samples, x.noise = o.light_samples or options.LIGHT_SAMPLES, not o.light_samples and NOISE or nil
  x.lit, message, code = traced_with(name, p, lamps_of(field))
  if x.lit == false then return nil, message, code end
  return true
end

--- Makes o.glossy ready, what a picture needs to know of glossy surfaces, where it has some: { by =, add =, share =, .. }.
-- `field`: the light that shades. True, or nil, message, code.
function gloss.ready(name, p, o, field)
  local by = p.options.gloss or "matte"
  o.glossy = nil
  if p.traced.glossy == 0 or by == "matte" then return true end
  local held = core.type(field) == "ylm.grid" and field.lmax or p.options.lmax
  local x = { by = by, add = gloss.add, lmax = o.weight == "cosine" and held or math.min(p.options.lmax, held) }
  if by ~= "sh" then
    x.hindrance, x.beyond = hindrance(p, o, field), o.weight == "cosine" and p.options.shading ~= "vertices"
    if x.hindrance and by == "rays" then
      return check.fail("%s: gloss = 'rays': %s: prepare the view with gloss = 'sh'", name, x.hindrance)
    end
    if not x.hindrance then
      local ok, message, code
      if o.weight == "cosine" then ok, message, code = aim_beyond(name, p, o, x, visibility.quantity(field))
      else ok, message, code = aim_at_lamps(name, p, o, x, field) end
      if not ok then return nil, message, code end
    end
  end
  o.glossy = x
  return true
end

--- Radiance of shading points with rays where harmonics are too few, in place; or nil, message, code.
function gloss.add(name, p, o, radiance)
  local x, threads, bar = o.glossy, o.threads or 0, progress.resolve(o.progress)
  local share, found, code, more
  if x.samples or not x.elements then
    share, found, code = check.result(name, p.lib.shade_blend(p.view, radiance, { weight = o.weight, lmax = x.lmax,
      light_samples = x.samples or 0, noise = x.noise, most_samples = x.noise and MOST_SAMPLES,
      shadows = p.options.visibility ~= "none", seed = p.options.seed, threads = threads, progress = bar, lit = x.lit }))
    if not share then return nil, found, code end
  end
  if x.elements then
    local e = x.elements
    share, more, code = check.result(name, p.lib.shade_blend_links(p.view, radiance, { links = e.links.handle, lit = e.lit,
      lmax = x.lmax, share = share, threads = threads, progress = bar }))
    if not share then return nil, more, code end
    if found then found.seconds = found.seconds + more.seconds
    else
      found, more.traced = more, 0
    end
  end
  x.share, x.found = share, found
  return radiance
end

local LOUD = 0.1 -- the part of lobes that 'sh' may miss without a word

--- Says that harmonics miss more than was wanted, why, and what to change.
local function say_missed(p, report, x, missed)
  local advice = x.by == "sh" and "set gloss = 'auto', whose rays find these, or a higher lmax"
    or x.beyond and beyond or x.hindrance .. "; set a higher lmax, or by = 'rays'"
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss missed", "scene %q: harmonics of degree %d miss %.0f %% of "
    .. "the lobes of glossy surfaces: %s", p.scene.name or "?", x.lmax, 100 * missed, advice)
end

--- Says that rays at their most leave more noise than is promised, and what to do.
local function say_noise(p, report, found)
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss noise", "scene %q: up to %d light samples, as many as are "
    .. "chosen, leave a noise of %.0f %% in a glossy mesh, its highlights being smaller than pixels: widen its lobe or the "
    .. "lamp, or set a larger size", p.scene.name or "?", MOST_SAMPLES, 100 * found.noise)
end

--- Says in the report how coefficients of light shade glossy surfaces: where as matte ones, in a sentence too.
function gloss.announce(p, report)
  local n = p.traced.glossy
  if n == 0 then return end
  report.gloss = p.options.gloss or "matte"
  if report.gloss ~= "matte" then return end
  local what = report.visibility == "grid" and "a grid's light shades " or "transfer vectors shade "
  local sentence = n == 1 and "1 mesh is glossy: " .. what .. "it as a matte one of its mean albedo"
    or n .. " meshes are glossy: " .. what .. "them as matte ones of their mean albedo"
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "gloss", "scene %q: " .. sentence, p.scene.name or "?")
end

--- Completes the report of a picture: points and rays, and the lobes that harmonics miss.
function gloss.report(p, o, report)
  local x = o.glossy
  if not x or not x.found then return end
  local stats, found, seconds = p.lib.shade_stats(p.view), x.found, report.seconds
  report.gloss_bytes, seconds.gloss, report.bytes = stats.gloss_bytes, stats.gloss_seconds, stats.bytes
  report.glossy = { points = stats.glossy, sh = found.sh, rays = found.rays, missed = found.missed,
    light_samples = found.light_samples, noise = found.noise, noise_of = found.noise and NOISE_OF or nil }
  report.rays.gloss, seconds.gloss_rays = found.traced, found.seconds
  if x.elements then report.rays.gloss_links = x.elements.links.stats.rays end
  seconds.image = seconds.image - found.seconds
  if found.missed > (x.by == "sh" and LOUD or p.options.gloss_error[2]) then say_missed(p, report, x, found.missed) end
  if found.noise and found.noise > LOUD_NOISE then say_noise(p, report, found) end
end

return gloss
