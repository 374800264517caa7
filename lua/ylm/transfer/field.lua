--- Light fields of what surfaces send to points in space: radiosity:field, and the methods of what it returns.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"

local methods = objects.gather

local LEAST, MOST = core.limits.gather_least, core.limits.gather_most -- cells along an edge of the cube of directions
local PER_CELL = 12       -- rays for each n^2: six faces, and about as many again where light changes
local DEFAULT = 16
local PLACES = 64         -- at which noise is measured
local BASES = { 8, 12, 16, 24, 32, 48, 64 } -- that rays = "auto" tries
local PARTS = { indirect = 1, direct = 2, all = 3 }

require "ylm.describe".object "gather" {
  about = "The light that surfaces send to points in space, as a light field (radiosity:field).",
  fields = {
    { "stats", "table", "points, rays, shadow_rays so far; invalid: points in bodies; bytes that are remembered" },
    { "rays", "integer|string", "about so many from a point, or 'auto'" },
    { "radiosity", "radiosity", "of which light" },
    { "scene", "scene", "of what" },
  },
}

function form.types.rays_of_field(x)
  local least, most = PER_CELL * LEAST ^ 2, PER_CELL * MOST ^ 2
  if x == "auto" or check.is_integer(x) and x >= least and x <= most then return x end
  return nil, ("'auto' or an integer from %d to %d"):format(least, most)
end

--- Options of fields but their quantity.
objects.field_options = {
  { "rays", "rays_of_field", default = "auto",
    about = "about so many from a point: a cube of cells, and more where the light of neighbours differs. 'auto' takes as "
      .. "many as the tolerance of the bake that asks wants, 3072 where there is none" },
  { "tolerance", "number", above = 0, optional = true,
    about = "of rays = 'auto' and of shadow rays; default: that of the bake that asks, 0.03 where there is none" },
  { "contrast", "number", min = 0, default = 0.2,
    about = "cells are split where the light of neighbours differs by more than this part of the mean" },
  { "derivatives", "choice", of = core.choices "gather_derivatives", default = "points",
    about = "gradients by the borders of cells, which move with the nearer surface, or by hit points that stay, less the mean "
      .. "light; Hessians are by cells (docs/bouncing.md compares them)" },
  { "remember", "boolean", default = false,
    about = "keep what each point sees, some 24 KB each: asked again there after lit:update, the field traces nothing" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of shadow rays" },
}

local options = {
  { "quantity", "choice", of = { "lights", "direct", "indirect", "all" }, default = "indirect",
    about = "'indirect' is what surfaces send back; 'direct' light of lamps and the sky with shadows; 'all' both; 'lights', "
      .. "which nothing occludes, is of scene:field" },
}
for _, field in ipairs(objects.field_options) do options[#options + 1] = field end

--- Cells along an edge for about so many rays.
local function base_of(rays)
  local n = math.floor(math.sqrt(rays / PER_CELL) + 0.5)
  return math.max(LEAST, math.min(MOST, n))
end

--- A field of `lit` with so many cells along an edge, or nil, message, code.
local function create(name, lit, of, o, base, rays, tolerance)
  local handle, message, code = check.result(name, of.lib.gather_create(lit, { base = base, levels = 2, contrast = o.contrast,
    spacing = 0, parts = PARTS[o.quantity], derivatives = o.derivatives, tolerance = tolerance, remember = o.remember,
    seed = o.seed, lamps = of.lit_by and of.lit_by.handle }))
  if not handle then return nil, message, code end
  core.own(handle).made = { radiosity = lit, of = of, scene = of.scene, lib = of.lib, quantity = o.quantity, rays = rays,
    base = base, options = o, lamps = of.lit_by, chosen = {} }
  core.between(lit, handle).is_field = true
  return handle
end

--- Places, float [n][3], at random within the rows of an array or within bounds {min, max}.
local function places_in(points, box, seed)
  local state, list = seed % 65521 + 1, {}
  local function random()
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
  for i = 1, PLACES do
    if points then
      local row, p = math.floor(random() * points.shape[1]) + 1, {}
      for a = 1, 3 do p[a] = core.array_get(points, row, a) end
      list[i] = p
    else
      list[i] = {}
      for a = 1, 3 do list[i][a] = box[1][a] + (box[2][a] - box[1][a]) * random() end
    end
  end
  return array.places(1, "bake", list)
end

--- How exactly a field knows the light at places; nil, message, code.
local function noise_at(name, field, m, places, lmax, threads, show)
  return check.result(name, m.lib.gather_noise(field, places, lmax, threads or 0, show))
end

--- The first two digits of a number, rounded up.
local function rounded_up(x)
  local unit = 10 ^ (math.floor(math.log(x) / math.log(10)) - 1)
  return math.ceil(x / unit) * unit
end

--- Raises where light that is known to `noise` with so many cells along an edge cannot keep a tolerance.
local function refuse(name, base, noise, tolerance)
  if tolerance >= 2 * noise then return end
  local rays, most = rounded_up(PER_CELL * base ^ 2 * (2 * noise / tolerance) ^ 2), PER_CELL * MOST ^ 2
  return check.fail("%s: tolerance %g: the gathered light is known to %.2g (%s)", name, tolerance, noise,
    rays <= most and ("rays = %d would reach %g"):format(rays, tolerance)
    or ("rays = %d, the most, would not reach %g"):format(most, tolerance))
end

--- A field like that of `m` with as few rays as know the light at places to half of a tolerance; nil, message, code.
local function choose(name, m, places, lmax, tolerance, o)
  local show = progress.resolve(o.progress)
  for i, base in ipairs(BASES) do
    local field, message, code = create(name, m.radiosity, m.of, m.options, base, PER_CELL * base ^ 2, tolerance)
    if not field then return nil, message, code end
    local noise
    noise, message, code = noise_at(name, field, objects.made(field), places, lmax, o.threads, show)
    if not noise then return nil, message, code end
    if noise < tolerance / 2 or i == #BASES then
      refuse(name, base, noise, tolerance)
      objects.made(field).noise = noise
      return field
    end
    objects.close(field, m.lib.gather_close)
  end
end

--- The field that a bake is to ask in place of one; nil, message, code. `request`: lmax, tolerance or nil, points [n][3] or
-- more, or nil, bounds, seed, threads, progress.
function methods.__for_bake(field, request)
  local m = objects.open_gather("bake", field)
  if not request.tolerance then return field end
  local places = places_in(request.points, request.bounds, request.seed)
  if m.rays == "auto" then return choose("bake", m, places, request.lmax, request.tolerance, request) end
  local noise, message, code = noise_at("bake", field, m, places, request.lmax, request.threads,
    progress.resolve(request.progress))
  if not noise then return nil, message, code end
  refuse("bake", m.base, noise, request.tolerance)
  return field
end

--- The surfaces of the field's scene. Or nil, message, code.
function methods.__walls(field, name)
  return check.result(name, objects.open_gather(name, field).lib.gather_walls(field))
end

local room = [[
local scene = ylm.scene "a box and a lamp" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
}
local lit = scene:links({ spacing = 0.5, rays = 64 }):radiosity()
]]

describe "radiosity:field" {
  about = "The light that surfaces send to points in space, as a light field: ylm.light_field and ylm.bake take it. The "
    .. "radiosity itself has the field of the defaults.",
  arguments = { { "options?", "table", "see the options" } },
  options = options,
  returns = { { "field", "gather", "field:noise(), field:validity(points); field.stats" } },
  errors = "raises on a bad option, and where the quantity has direct light that is no lights; nil, message, code where memory "
    .. "runs out",
  example = room .. [[
local L = ylm.light_field(2, lit:field { rays = 768 }, { { 0.3, 0.2, 0 } })
assert(L:get(1, 1, 1) > 0)]],
  source = "Jarosz et al. 2008; Schwarzhaupt et al. 2012",
}
function objects.radiosity.field(lit, given)
  local of = objects.open_radiosity("field", lit)
  local o = form.options(1, "field", options, given)
  if o.quantity == "lights" then
    return check.fail "field: quantity = 'lights' is light that no surface meets: scene:field { quantity = 'lights' } has it"
  end
  if o.quantity ~= "indirect" and not of.lit_by then
    return check.fail("field: quantity = '%s' is for lights that rays can be sent to: this radiosity was lit by another light "
      .. "field", o.quantity)
  end
  local base = o.rays == "auto" and DEFAULT or base_of(o.rays)
  local field, message, code = create("field", lit, of, o, base, o.rays, o.tolerance or 0.03)
  if not field then return nil, message, code end
  if o.rays ~= "auto" or not o.tolerance then return field end
  local places = places_in(nil, { of.of.traced.lo, of.of.traced.hi }, o.seed)
  return choose("field", objects.made(field), places, 4, o.tolerance, {})
end

--- Bakes of a radiosity ask its default field.
function objects.radiosity.__for_bake(lit, request)
  local of = objects.open_radiosity("bake", lit)
  if not of.default then
    local field, message, code = lit:field()
    if not field then return nil, message, code end
    of.default = field
  end
  return methods.__for_bake(of.default, request)
end

--- Direct light of all fields of a radiosity, after its lights have changed: true, or nil, message, code.
function objects.relit(lit, of)
  for _, field in ipairs(core.partners(lit)) do
    local m = objects.made(field)
    if of.lit_by and not m.closed and m.lamps ~= of.lit_by then
      local ok, message, code = check.result("update", m.lib.gather_lamps(field, of.lit_by.handle))
      if not ok then return nil, message, code end
      m.lamps = of.lit_by
    end
  end
  return true
end

local noise_options = {
  { "points", "any", optional = true, about = "places [n][3] to look at; default: 64 at random in the scene's bounding box" },
  { "lmax", "integer", min = 0, max = core.limits.transfer_lmax, default = 4, about = "highest degree that counts" },
  form.threads, form.progress,
}

describe "gather:noise" {
  about = "How exactly a field knows the light: its coefficients against those with four times the rays. ylm.bake refuses a "
    .. "tolerance below twice of it.",
  arguments = { { "options?", "table", "see the options" } },
  options = noise_options,
  returns = { { "noise", "number", "the 95 % quantile of the errors, each relative to the norm of the light there, or to the "
    .. "mean norm where that is more" } },
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = room .. "assert(lit:field({ rays = 768 }):noise { lmax = 2 } < 0.2)",
}
function methods.noise(field, given)
  local m = objects.open_gather("noise", field)
  local o = form.options(1, "noise", noise_options, given)
  local places
  if o.points ~= nil then places = array.places(1, "noise", o.points)
  else places = places_in(nil, { m.of.of.traced.lo, m.of.of.traced.hi }, 1) end
  return noise_at("noise", field, m, places, o.lmax, o.threads, progress.resolve(o.progress))
end

describe "gather:validity" {
  about = "Which points are not in bodies: 1 less the share of directions that see sides of closed meshes that reflect "
    .. "nothing. Grids fill points below 0.5 from their neighbours.",
  arguments = { { "points", "array|table", "[n][3] or one point" }, { "options?", "table", "threads" } },
  options = { form.threads },
  returns = { { "validity", "array", "[n], or a number for one point" } },
  errors = "raises on bad points; nil, message, code where memory runs out",
  example = room .. "assert(lit:field():validity { 0, 0, 0 } == 1)",
}
function methods.validity(field, points, given)
  local m = objects.open_gather("validity", field)
  local o = form.options(2, "validity", { form.threads }, given)
  local x, single = array.places(1, "validity", points)
  local validity, message, code = check.result("validity", m.lib.gather_validity(field, x, o.threads or 0))
  if not validity then return nil, message, code end
  return single and validity[1] or validity
end

describe "gather:close" {
  about = "Frees the memory of a field now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no gathered field",
  example = room .. "lit:field():close()",
}
function methods.close(field)
  if core.type(field) ~= "ylm.gather" then
    return check.fail("close: a gathered field expected before the colon, got %s", check.describe(field))
  end
  objects.close(field, objects.made(field).lib.gather_close)
end

--- field.stats is counted anew each time that it is read.
local index = methods.__index
function methods.__index(field, key)
  local m = objects.made(field)
  if key == "stats" and m and not m.closed then
    local stats = m.lib.gather_stats(field)
    stats.noise = m.noise
    return stats
  end
  return index(field, key)
end

memory.publish(methods)
memory.publish(objects.radiosity)

return methods
