--- scene:field: the light of a scene as a field, in one call for links, radiosity and what is gathered of it.

local check = require "ylm.check"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local light = require "ylm.light"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"

local fields = {}

--- The option that says what light a field or a grid of a scene holds.
fields.quantity = { "quantity", "choice", of = { "lights", "direct", "indirect", "all" }, default = "lights",
  about = "'lights', light that nothing occludes; 'direct', light of lamps and sky with shadows; 'indirect', what surfaces send "
    .. "back; 'all', both" }

fields.bounces = { "bounces", "bounces_summed", optional = true,
  about = "of 'indirect' and 'all': reflections after direct light, default 'all'" }

fields.links = { "links", "object", of = "ylm.links", optional = true,
  about = "of 'direct', 'indirect' and 'all': what scene:links returned; default: one with its defaults" }

--- Reflections on elements for o.bounces of them before the light of a field; raises where there is no light to hold.
local function reflections(name, o)
  if o.quantity == "direct" then return 0 end
  if o.bounces == nil or o.bounces == "all" then return "all" end
  if o.bounces > 0 then return o.bounces - 1 end
  if o.quantity == "all" then return 0 end
  return check.fail("%s: bounces = 0 is direct light alone, quantity = 'indirect' would be dark: bounces = 1, 2 .. or 'all'",
    name)
end

--- Raises where options about light from surfaces stand beside a quantity that has none.
function fields.check(name, s, o)
  if o.bounces and o.quantity ~= "indirect" and o.quantity ~= "all" then
    return check.fail("%s: bounces are of quantity = 'indirect' or 'all': name one, or leave bounces out", name)
  end
  if o.links then
    if o.quantity == "lights" then
      return check.fail("%s: links are for quantity = 'direct', 'indirect' or 'all': name one, or leave links out", name)
    end
    objects.check_scene(name, o.links, s)
  end
  if o.quantity ~= "lights" then reflections(name, o) end
end

--- The light of the scene `s` on elements, by options that fields.check has seen; `seed` of shadow rays, nil: the default;
-- `lights`: others than the scene's. Direct light alone needs few rays of them. Or nil, message, code.
function fields.radiosity(name, s, o, seed, lights)
  local n, direct = reflections(name, o), fields.is_direct(o)
  local links, message, code = o.links
  if not links then
    links, message, code = s:links { rays = direct and 4 or nil, lmax = 0, threads = o.threads, progress = o.progress }
    if not links then return nil, message, code end
  end
  return links:radiosity(lights or s.lights, { bounces = n, light_samples = direct and 1 or nil, seed = seed, threads = o.threads,
    progress = o.progress })
end

--- Is it direct light alone that options ask for?
function fields.is_direct(o) return o.quantity == "direct" or o.bounces == 0 end

--- Light of the scene `s` from its surfaces, by options that fields.check has seen; `more`: further options of radiosity:field.
-- Or nil, message, code.
function fields.gathered(name, s, o, more)
  local lit, message, code = fields.radiosity(name, s, o)
  if not lit then return nil, message, code end
  local given = { quantity = fields.is_direct(o) and "direct" or o.quantity }
  for _, field in ipairs(more or {}) do given[field[1]] = o[field[1]] end
  return lit:field(given)
end

local options = { fields.quantity, fields.bounces, fields.links }
for _, field in ipairs(objects.field_options) do options[#options + 1] = field end
options[#options + 1] = form.threads
options[#options + 1] = form.progress

describe "scene:field" {
  shelf = "everyday",
  about = "The light of a scene as a light field, which ylm.light_field and ylm.bake take. For light from surfaces it makes "
    .. "links (scene:links), the radiosity of the scene's lights, and its field. Who lights the same surfaces more than once "
    .. "makes the links, and names them.",
  arguments = { { "options?", "table", "see the options" } },
  options = options,
  returns = { { "field", "lights|gather", "of quantity = 'lights' the scene's lights, else as radiosity:field; "
    .. "field.radiosity" } },
  errors = "raises on a bad option; nil, message, code: too many elements (ELIMIT), memory, cancelled",
  example = [[
local scene = ylm.scene "a box and a lamp" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
  links = ylm.links { spacing = 0.5, rays = 16 },
}
local field = scene:field { quantity = "indirect", bounces = 2, rays = 768 }
assert(ylm.light_field(2, field, { { 0.3, 0.2, 0 } }):get(1, 1, 1) > 0)]],
  source = "Goral et al. 1984",
}
function fields.of_scene(s, given)
  if form.kind(s) ~= "scene" then return check.fail("field: a scene expected before the colon, got %s", check.describe(s)) end
  local o = form.options(1, "field", options, given)
  o.progress = progress.long(o.progress)
  fields.check("field", s, o)
  if o.quantity ~= "lights" then return fields.gathered("field", s, o, objects.field_options) end
  for _, field in ipairs(objects.field_options) do
    if given and given[field[1]] ~= nil then
      return check.fail("field: %s is for quantity = 'direct', 'indirect' or 'all': name one, or leave %s out", field[1],
        field[1])
    end
  end
  return light.field(1, "field", s.lights)
end

return fields
