--- Bounces of light on the elements of a scene: links:radiosity, and the methods of what it returns.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local image = require "ylm.image"
local lamplight = require "ylm.transfer.lamplight"
local lamps = require "ylm.transfer.lamps"
local light = require "ylm.light"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"

local methods = objects.radiosity

local CLOSE = 0.02 -- the part of direct light from lamps nearer than two elements' lengths of which a note is made

require "ylm.describe".object "radiosity" {
  about = "Light on the elements of a scene: direct light, and all its bounces (links:radiosity).",
  fields = {
    { "stats", "table", "bounces that were summed; closed: whether the rest was added as a geometric series; residual: what "
      .. "one more "
      .. "bounce would change, relative; shrink: the change by the last bounce over the one before; emitted, absorbed, "
      .. "escaped: W "
      .. "{r, g, b}, direct light on elements, what they keep, what leaves the scene; balance: what is missing between these, "
      .. "relative; elements_error: half of what elements of twice the spacing would change of the light that bounces, root mean "
      .. "square over its mean, an estimate of the error that these leave, as it was when the radiosity was made; "
      .. "rays: shadow rays; guides, guide_rays: clusters of elements by which they were guided, and rays of the pilot; "
      .. "with derivatives rim_rays: those of them to rims, and partly: the part of pairs of element and lamp that are partly in "
      .. "shadow; direct_seconds, solve_seconds, seconds" },
    { "links", "links", "of which elements" },
    { "scene", "scene", "of what" },
    { "notes", "string[]", "what is known to be missed, or nil" },
  },
}

function form.types.bounces_summed(x)
  local most = core.limits.transfer_bounces
  if x == "all" or check.is_integer(x) and x >= 0 and x <= most then return x end
  return nil, ("a number of reflections after direct light, an integer from 0 to %d, or 'all'"):format(most)
end

local options = {
  { "direct", "choice", of = { "rays", "field" }, optional = true,
    about = "how light first arrives: by shadow rays to lamps (default for lights), or from coefficients at the elements' "
      .. "centres, "
      .. "times their transfer vectors (default for other light fields: no rays, but no shadow of what is nearer than a lamp)" },
  { "light_samples", "integer", min = 1, max = core.limits.transfer_links, default = 16, about = "shadow rays of an element" },
  { "guides", "boolean", default = true, shelf = "experiments",
    about = "shadow rays learn from a pilot which lamps and parts of the sky elements see, as those of places, texels and "
      .. "surface grids that these elements light; links of these learn which elements send light: no bias, less noise; false: "
      .. "they do not" },
  { "derivatives", "boolean", default = false,
    about = "each light is looked at by itself: light_samples rays of an element to each, and what radiosity:importance needs "
      .. "is kept, 64 bytes an element and lamp" },
  { "bytes", "memory", default = 2 ^ 30,
    about = "of derivatives: what is kept at most, for elements as for each of the receivers; of more, importance:derivatives "
      .. "traces the same rays again" },
  { "rim", "integer", min = 0, max = core.limits.transfer_links, default = 8,
    about = "of derivatives: rays of an element to the rim of a lamp that it sees in part, even; 0: shadows are held" },
  { "bounces", "bounces_summed", default = "all", about = "reflections after direct light: 0 is direct light alone" },
  { "residual", "number", above = 0, max = 1, default = 1e-3,
    about = "the change at which 'all' bounces end, relative to the light that has bounced" },
  { "closure", "boolean", default = true, about = "'all' bounces: the rest is added as the geometric series of the last change" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of shadow rays" },
  form.threads,
  form.progress,
}

--- Where the light comes from: { traced } for rays, { field } else; nil, message, code.
local function source(name, m, lights, direct)
  if core.has_field(lights) and core.type(lights) ~= "ylm.lights" then
    if direct == "rays" then
      return check.fail("%s: direct = 'rays' is for lights; %s has coefficients alone: direct = 'field'", name,
        check.describe(lights))
    end
    return { field = light.field(1, name, lights) }
  end
  local traced, message, code = objects.traced_again(name, m)
  if not traced then return nil, message, code end
  if lights ~= nil and lights ~= m.scene.lights then
    traced, message, code = tracing.relight(name, traced, lights)
    if not traced then return nil, message, code end
  end
  local is_set = core.type(traced.lights) == "ylm.lights"
  if direct == "rays" and not is_set then
    return check.fail("%s: direct = 'rays' is for lights; %s has coefficients alone: direct = 'field'", name,
      light.other(traced.lights))
  end
  if direct == "field" or not is_set then return { field = traced.lights } end
  tracing.check_bodies(name, traced, "direct = 'field' takes their coefficients, without shadows")
  return { traced = traced }
end

--- The degree that direct light of a field is asked to: that of the transfer vectors, or the field's own below it.
local function lmax_of(m, field)
  local known = core.type(field) == "ylm.grid" and field.lmax or math.huge
  return math.min(m.of.stats.lmax, known)
end

--- Raises where a field that is to be direct light holds bounces already.
local function check_quantity(name, field, bounces)
  local held = core.field_quantity(field)
  if (held == "all" or held == "indirect") and bounces ~= 0 then
    return check.fail("%s: %s holds light that has bounced (quantity %q): give lights or a grid of quantity = 'direct', or "
      .. "bounces = 0",
      name, check.describe(field), held)
  end
end

--- Direct light anew: where it comes from, as above; or nil, message, code.
local function illuminate(name, lit, m, lights, o, show)
  local from, message, code = source(name, m.of, lights, o.direct)
  if not from then return nil, message, code end
  local done
  if from.field then check_quantity(name, from.field, o.bounces) end
  if from.field then done, message, code = check.result(name, m.lib.radiosity_field(lit, from.field, lmax_of(m, from.field),
    o.threads, show))
  else
    done, message, code = check.result(name, m.lib.radiosity_rays(lit, from.traced.handle, o.light_samples, o.guides,
      o.seed, o.threads, show))
  end
  if not done then return nil, message, code end
  return from
end

--- Direct light of each lamp by itself: the lamps and what they light; or nil, message, code.
local function lamp_by_lamp(name, lit, m, lights, o, show)
  local traced, message, code = objects.traced_again(name, m.of)
  if not traced then return nil, message, code end
  local list = lamps.list(name, lights == nil and m.scene.lights or lights)
  if lights ~= nil and lights ~= m.scene.lights then
    traced, message, code = tracing.relight(name, traced, lights)
    if not traced then return nil, message, code end
  end
  local made
  made, message, code = lamplight.create(name, m, nil, traced, list, { light_samples = o.light_samples, rim = o.rim,
    seed = o.seed, bytes = o.bytes, threads = o.threads, progress = show })
  if not made then return nil, message, code end
  m.lib.radiosity_set(lit, made:direct())
  return { traced = traced, lamps = list, lamplight = made }
end

--- Bounces as C takes them.
local function count_of(bounces) return bounces == "all" and -1 or bounces end

local function add_notes(m)
  local notes = {}
  for _, sentence in ipairs(m.of.notes or {}) do notes[#notes + 1] = sentence end
  if m.stats.close > CLOSE then
    notes[#notes + 1] = ("scene %q: %.0f %% of the direct light comes from lamps that are nearer to a surface than two "
      .. "elements are long: "
      .. "its spots are blurred over elements; less than spacing = %.3g shows them"):format(m.scene.name or "?",
      100 * m.stats.close, m.of.stats.spacing / 2)
  end
  m.notes = #notes > 0 and notes or nil
end

--- Direct light and its bounces: lit, or nil, message, code.
local function light_up(name, lit, m, lights, o)
  local start, show = core.seconds(), progress.resolve(o.progress)
  local from, message, code = (o.derivatives and lamp_by_lamp or illuminate)(name, lit, m, lights, o, show)
  if not from then return nil, message, code end
  local stats
  stats, message, code = check.result(name, m.lib.radiosity_solve(lit, count_of(o.bounces), o.residual, o.closure,
    o.threads, show))
  if not stats then return nil, message, code end
  stats.seconds = core.seconds() - start
  if from.lamplight then
    local of = from.lamplight:stats()
    stats.rays, stats.rim_rays, stats.direct_seconds = of.rays + of.rim_rays, of.rim_rays, of.seconds
    stats.partly = of.pairs > 0 and of.partly / of.pairs or 0
  end
  stats.elements_error = m.stats and m.stats.elements_error
  m.stats, m.from, m.lit_by = stats, from, from.traced
  add_notes(m)
  return lit
end

local one_box = [[
local scene = ylm.scene "a box and a lamp" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
}
local t = scene:links { spacing = 0.5, rays = 64 }
]]

describe "links:radiosity" {
  about = "Light on the elements of a scene: direct light, and its bounces as sums over links.",
  arguments = { { "lights?", "any", "lights, or any object with a light field; default: the scene's lights" }, { "options?",
    "table", "" } },
  options = options,
  returns = { { "lit", "radiosity", "lit:irradiance(), lit:leaving(), lit:update(lights); lit.stats" } },
  errors = "raises on a bad option, a scene whose geometry has changed, and bounces that do not converge (albedo 1 in a "
    .. "closed scene); "
    .. "nil, message, code: memory, cancelled",
  example = one_box .. [[
local lit = t:radiosity()
local emitted, absorbed = lit.stats.emitted[1], lit.stats.absorbed[1]
assert(math.abs(absorbed / emitted - 1) < 0.01) -- nothing leaves a closed box]],
  source = "Goral et al. 1984",
}
function objects.links.radiosity(t, lights, given)
  local of = objects.open_links("radiosity", t)
  local o = form.options(2, "radiosity", options, given)
  o.progress = progress.long(o.progress)
  if o.derivatives and (o.light_samples % 2 == 1 or o.light_samples < 4 or o.rim % 2 == 1) then
    return check.fail("radiosity: derivatives = true wants even light_samples from 4 on, and an even rim, got %d and %d",
      o.light_samples, o.rim)
  end
  if o.derivatives and o.direct then return check.fail "radiosity: derivatives = true has its own rays: leave direct out" end
  local lit, message, code = check.result("radiosity", of.lib.radiosity_create(t))
  if not lit then return nil, message, code end
  local m = { of = of, links = t, scene = of.scene, lib = of.lib, elements = of.stats.elements, options = o }
  local done
  done, message, code = light_up("radiosity", lit, m, lights, o)
  if not done then return nil, message, code end
  core.own(lit).made = m
  local change
  change, message, code = check.result("radiosity", of.lib.radiosity_coarse(lit, count_of(o.bounces), o.residual, o.closure,
    o.threads or 0))
  if not change then return nil, message, code end
  m.stats.elements_error = change / 2
  return lit
end

--- Light of `lit`, constant on groups of up to four elements, which are those of twice the spacing: a radiosity of its
-- links, whose stats are those of `lit`; or nil, message, code.
function objects.coarse(lit)
  local m = objects.open_radiosity("coarse", lit)
  local o = m.options
  local out, message, code = check.result("coarse", m.lib.radiosity_create(m.links))
  if not out then return nil, message, code end
  local done
  done, message, code = check.result("coarse", m.lib.radiosity_coarse(lit, count_of(o.bounces), o.residual, o.closure,
    o.threads or 0, out))
  if not done then return nil, message, code end
  local copy = {}
  for key, value in pairs(m) do copy[key] = value end
  copy.closed = nil
  core.own(out).made = copy
  return out
end

describe "radiosity:update" {
  about = "Lights the elements anew: direct light and bounces, without tracing links. Options are those that it was made with.",
  arguments = { { "lights?", "any", "as links:radiosity takes; default: the scene's lights as they are now" } },
  returns = { { "lit", "radiosity", "itself" } },
  errors = "as links:radiosity; what was known before stays where it fails or is cancelled",
  example = one_box .. [[
local lit = t:radiosity()
lit:update(ylm.sphere_light { at = { 0.5, 0, 0 }, radius = 0.1, radiance = 20 })
assert(lit.stats.bounces > 0)]],
}
function methods.update(lit, lights)
  local m = objects.open_radiosity("update", lit)
  local done, message, code = light_up("update", lit, m, lights, m.options)
  if done then done, message, code = objects.relit(lit, m) end
  if not done then return nil, message, code end
  return lit
end

describe "radiosity:irradiance" {
  about = "The irradiance of the elements, all bounces included.",
  arguments = { { "part?", "string", "'all' (default), or 'direct': light that comes straight from lamps" } },
  returns = { { "E", "array", "float [n][3], W m^-2" } },
  errors = "raises on another part; nil, message, code where memory runs out",
  example = one_box .. [[
local lit = t:radiosity()
assert(lit:irradiance():get(1, 1) > lit:irradiance "direct":get(1, 1))]],
}
function methods.irradiance(lit, part)
  local m = objects.open_radiosity("irradiance", lit)
  if part ~= nil and part ~= "all" and part ~= "direct" then
    return check.bad(1, "irradiance", "'all' or 'direct' expected, got %s", check.describe(part))
  end
  return check.result("irradiance", m.lib.radiosity_values(lit, part == "direct" and "direct" or "irradiance"))
end

describe "radiosity:leaving" {
  about = "The radiance that leaves the elements, the same in all directions: albedo times irradiance over pi.",
  arguments = {},
  returns = { { "L", "array", "float [n][3], W sr^-1 m^-2" } },
  errors = "raises on what is no radiosity; nil, message, code where memory runs out",
  example = one_box .. [[
assert(t:radiosity():leaving().shape[1] == t.stats.elements)]],
}
function methods.leaving(lit)
  local m = objects.open_radiosity("leaving", lit)
  return check.result("leaving", m.lib.radiosity_values(lit, "leaving"))
end

describe "radiosity:elements" {
  about = "The elements: links:elements of its links.",
  arguments = {},
  returns = { { "elements", "table", "as links:elements" } },
  errors = "raises on what is no radiosity; nil, message, code where memory runs out",
  example = one_box .. [[
assert(#t:radiosity():elements().area == t.stats.elements)]],
}
function methods.elements(lit)
  return objects.links.elements(objects.open_radiosity("elements", lit).links)
end

describe "radiosity:save" {
  about = "Writes the elements as triangles of a PLY file: irradiance and that of direct light per face, in W m^-2, and "
    .. "colours of "
    .. "corners for viewers.",
  arguments = { { "path", "string", "the file, NAME.ply" } },
  returns = { { "ok", "boolean", "true, or nil, message, 'EIO'" } },
  errors = "raises on what is no name of a .ply file; nil, message, code: files, memory",
  example = one_box .. [[
local name = os.tmpname() .. ".ply"
assert(t:radiosity():save(name))
assert(#ylm.mesh({ file = name }).mesh == t.stats.elements)
os.remove(name)]],
}
function methods.save(lit, path)
  local m = objects.open_radiosity("save", lit)
  if type(path) ~= "string" or path:find("%z") or not path:lower():find "%.ply$" then
    return check.bad(1, "save", "a file name that ends in .ply expected, got %s", check.describe(path))
  end
  return check.result("save", m.lib.radiosity_write(lit, path))
end

local map_options = {
  { "mesh", "integer", min = 1, about = "place in scene.geometry; it must have texture coordinates" },
  { "size", "texels", default = { 256, 256 }, unit = "texels", about = "{ width, height }" },
  { "part", "choice", of = { "all", "direct", "indirect" }, default = "all", about = "direct light, what surfaces send, or "
    .. "both" },
  { "side", "choice", of = core.choices "side", optional = true, about = "default: the one that has elements, else the front" },
  { "rays", "links", default = 128, about = "rays of each texel, by which elements light it" },
  { "light_samples", "integer", min = 1, max = core.limits.transfer_links, default = 32, about = "shadow rays of each texel" },
  { "gutter", "integer", min = 0, max = 64, default = 2,
    about = "texels around the mesh's that take their neighbours' mean, so that a filter finds no black" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all rays" },
  form.threads,
  form.progress,
}

function form.types.texels(x)
  local function good(n) return check.is_integer(n) and n >= 1 and n <= 16384 end
  if type(x) == "table" and #x == 2 and good(x[1]) and good(x[2]) then return { x[1], x[2] } end
  return nil, "{ width, height }, integers from 1 to 16384"
end

--- Argument `mesh` of radiosity:lightmap: its texture coordinates.
local function uvs_of(m, number)
  local g = m.scene.geometry[number]
  if not g then return check.fail("lightmap: mesh = %.0f: the scene has %d pieces of geometry", number, #m.scene.geometry) end
  return core.mesh_uvs(g.mesh) or check.fail("lightmap: %s has no texture coordinates (uvs)",
    tracing.mesh_text(m.scene, number))
end

describe "radiosity:lightmap" {
  about = "The irradiance of one mesh as a picture by its texture coordinates: each texel is lit by shadow rays and by the "
    .. "elements "
    .. "that its own rays hit.",
  arguments = { { "options", "table", "mesh is needed" } },
  options = map_options,
  returns = { { "image", "image", "layers irradiance, W m^-2, and coverage, 1 where the middle of a texel is on the mesh and "
    .. "in no body; "
    .. "image:save 'x.exr'" }, { "report", "table", "texels: how many are covered; overlaps: those that more than one "
    .. "triangle has; "
    .. "seconds" } },
  errors = "raises on a bad option and a mesh without texture coordinates; nil, message, code: memory, cancelled",
  example = one_box .. [[
local image = t:radiosity():lightmap { mesh = 1, size = { 16, 16 }, rays = 32 }
assert(image:layer "coverage":get(8, 8, 1) == 1 and image:layer "irradiance":get(8, 8, 1) > 0)]],
}
function methods.lightmap(lit, given)
  local m = objects.open_radiosity("lightmap", lit)
  local o = form.options(1, "lightmap", map_options, given)
  o.progress = progress.long(o.progress)
  local uvs, start = uvs_of(m, o.mesh), core.seconds()
  local out, message, code = image.image { size = o.size, layers = { { "irradiance", 3 }, { "coverage", 1 } } }
  if not out then return nil, message, code end
  local direct = o.part ~= "indirect"
  local overlaps
  overlaps, message, code = check.result("lightmap", m.lib.radiosity_map(lit, { mesh = o.mesh, side = o.side, uvs = uvs,
    out = out:layer "irradiance", coverage = out:layer "coverage", indirect = o.part ~= "direct",
    scene = direct and m.from.traced and m.from.traced.handle or nil, field = direct and m.from.field or nil,
      lmax = lmax_of(m, m.from.field), links = o.rays,
    light_samples = o.light_samples, gutter = o.gutter, seed = o.seed, threads = o.threads,
    progress = progress.resolve(o.progress) }))
  if not overlaps then return nil, message, code end
  local texels = 0
  for _, row in ipairs(out:layer("coverage"):totable()) do for _, c in ipairs(row) do texels = texels + c[1] end end
  return out, { texels = texels, overlaps = overlaps, seconds = core.seconds() - start }
end

describe "radiosity:close" {
  about = "Frees the memory of a radiosity now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no radiosity",
  example = one_box .. "t:radiosity():close()",
}
function methods.close(lit)
  if core.type(lit) ~= "ylm.radiosity" then
    return check.fail("close: a radiosity expected before the colon, got %s", check.describe(lit))
  end
  objects.close(lit, objects.made(lit).lib.radiosity_close)
end

memory.publish(methods)

return methods
