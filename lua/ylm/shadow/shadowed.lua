--- Light behind bodies: ylm.shadowed.

local caster = require "ylm.shadow.caster"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local geometry = require "ylm.geometry" -- defines form.types.rotation
local light = require "ylm.light"
local memory = require "ylm.memory"
local numbers = require "ylm.light.numbers"
local occluder = require "ylm.shadow.occluder"
local reference = require "ylm.describe"
local warning = require "ylm.warning"

local describe = reference.describe

local shadowed = {}

local doubles, matrix_of, matrices = caster.doubles, caster.matrix_of, caster.matrices
local made, one_each, spread = occluder.made, caster.one_each, caster.spread

reference.object "shadowed" {
  about = "Light behind casters, a light field; from the constructor of that name.",
  fields = { { "count", "integer", "how many casters" },
    { "stats", "table", "of all questions so far: { points, casters, products, factors, seconds }; casters that counted, over "
      .. "all points; products of light and casters; factors that were multiplied at directions, a layer of bodies being one" } },
}

local shadoweds = core.metatable "ylm.shadowed"

--- The parts that shadowed light was made of.
local function about_of(object) return core.owned(object, "about") end

local kinds = { caster = true, casters = true, sphere_casters = true }

--- Sentences about groups of casters whose grids are known to fewer degrees than lmax, said of `object` once.
local function heed(object, groups, lmax)
  local list = {}
  for i, group in ipairs(groups) do
    local facts = group.caster.facts
    if facts and facts[1] < lmax then
      list[#list + 1] = warning.say(object, "degree " .. i, "shadowed: caster%s is known to lmax %d, and light of lmax %d is "
        .. "multiplied by it, so that its shadow is as soft as at lmax %d: bake its grid with lmax = %d",
        group.name and (" '%s'"):format(group.name) or (" %d"):format(i), facts[1], lmax, facts[1], lmax)
    end
  end
  return list
end

--- Sentences about what shadowed light does not keep at lmax, said once; for lua/ylm/light and lua/ylm/grid.
function shadoweds.__heed(s, lmax)
  local of = about_of(s)
  local list = heed(s, of and of.list or {}, lmax)
  for _, sentence in ipairs(of and of.lights and light.heed(of.lights, lmax) or {}) do list[#list + 1] = sentence end
  return list
end

--- The object whose stats count what is asked of shadowed light; nil once closed. For lua/ylm/light.
function shadoweds.__counted(s)
  local of = about_of(s)
  local whole = of and of.of or s
  return core.shadowed_look(whole) and whole
end

--- Groups of casters, in order: of lists first, then by name. fail(message) raises.
local function groups_of(given, fail)
  local groups = {}
  local function add(name, c)
    local kind = form.kind(c)
    if kinds[kind] then
      if c.hides ~= nil and not pcall(core.field_quantity, c.hides) then
        return fail(("casters: the %s that caster%s hides has been closed"):format((core.type(c.hides):gsub("^ylm%.", "")),
          name and (" '%s'"):format(name) or ""))
      end
      groups[#groups + 1] = { name = name, caster = c }
    elseif kind == nil and type(c) == "table" then
      for i = 1, #c do add(nil, c[i]) end
    else
      return fail(("casters: a caster, casters or sphere_casters expected%s, got %s"):format(
        name and (" as '%s'"):format(name) or "", kind and "a " .. kind or check.describe(c)))
    end
  end
  if kinds[form.kind(given)] then
    add(nil, given)
    return groups
  end
  if type(given) ~= "table" or form.kind(given) then
    return fail("casters must be a caster or a table of casters, got " .. check.describe(given))
  end
  local names = {}
  for i = 1, #given do add(nil, given[i]) end
  for name in pairs(given) do if type(name) == "string" then names[#names + 1] = name end end
  table.sort(names)
  for _, name in ipairs(names) do
    if not kinds[form.kind(given[name])] then
      return fail(("casters: a caster expected as '%s', got %s"):format(name, check.describe(given[name])))
    end
    add(name, given[name])
  end
  return groups
end

--- One array of n rows from those of all groups.
local function joined(groups, field, n, width)
  local out = assert(core.array_zeros(width > 1 and { n, width } or { n }, "double"))
  local list = {}
  for g, group in ipairs(groups) do
    for _, row in ipairs(core.array_totable(group.caster.places[field])) do
      list[#list + 1] = field == "body" and g * 65536 + row or row
    end
  end
  if n > 0 then core.array_fill(out, list) end
  return out
end

--- Are several spheres of a group one body?
local function has_union(groups)
  for _, group in ipairs(groups) do
    local body, seen = group.caster.hides == nil and core.array_totable(group.caster.places.body) or {}, {}
    for _, b in ipairs(body) do
      if seen[b] then return true end
      seen[b] = true
    end
  end
  return false
end

--- The object of C for lights and groups of casters; nil, message, code.
local function create(packed, groups, o)
  local hides, place, facts, which, n, body = {}, {}, {}, {}, 0, 0
  for _, group in ipairs(groups) do
    local c = group.caster
    group.first = n
    n = n + c.count
    body = body + 1
    local at = 0
    if c.hides ~= nil then
      if not place[c] then
        hides[#hides + 1], facts[#facts + 1] = c.hides, c.facts
        place[c] = #hides
      end
      at = place[c]
    end
    for _ = 1, c.count do which[#which + 1] = at end
  end
  return core.shadowed_create { lights = packed, hides = hides, facts = doubles({ #facts, 7 }, facts),
    which = doubles({ n }, which), at = joined(groups, "at", n, 3), rotation = joined(groups, "rotation", n, 9),
    scale = joined(groups, "scale", n, 1), body = joined(groups, "body", n, 1), product = o.product,
    rule = o.rule or (has_union(groups) and 6 or 3),
    cull = o.cull, layers = o.layers, exp = o.exp, terms = o.terms }
end

--- Fields of ylm.shadowed and options of ylm.visibility.
local products = {
  { "product", "choice", of = core.choices "shadow_product", default = "rule",
    about = "'rule': at directions of one rule, whatever the number of casters; 'accurate': of a rule that is exact, for 15 "
      .. "casters at most; 'recursive': two factors at a time, cut off at lmax; 'exp': exponentials of sums of logarithms, "
      .. "of spheres alone, lmax at most 20 (all but the first to compare with)" },
  { "rule", "number", min = 2, max = 12, optional = true,
    about = "degree of that rule, times lmax; of 'rule' alone. Default 3, and 6 where several spheres are one body" },
  { "cull", "number", min = 0, max = 1, default = 1e-3,
    about = "casters that change a visibility by less than this, over their number, are left out; 0: none" },
  { "layers", "boolean", optional = true,
    about = "casters that do not overlap, seen from a point, are summed, and are one factor; default: with 'rule' alone" },
  { "exp", "choice", of = core.choices("sh_exp", "HYB"), optional = true,
    about = "of 'exp': 'PS' its series, which diverges for bodies that look large; 'OL' a line; 'HYB', the default, a line of a "
      .. "part, squared until it is the whole" },
  { "terms", "integer", min = 1, max = core.limits.sh_exp_terms, optional = true, about = "of 'PS', default 9" },
}

--- Options of products, settled; fail(message) raises.
local function settle(o, fail)
  if o.layers == nil then o.layers = o.product == "rule" end
  if o.exp and o.product ~= "exp" then return fail(("exp is of product 'exp', not of '%s': leave one out"):format(o.product)) end
  o.exp = o.exp or "HYB"
  if o.terms and not (o.product == "exp" and o.exp == "PS") then return fail "terms are of exp = 'PS': leave them out" end
  o.terms = o.terms or 9
  return o
end

local function build_shadowed(values, fail)
  settle(values, fail)
  local packed, message, code = light.field(1, "shadowed", values.lights)
  if not packed then return nil, message, code end
  if core.field_quantity(packed) == "visibility" then
    return fail "lights: a visibility is no light: it belongs into casters, as hides of a caster"
  end
  local groups = groups_of(values.casters, fail)
  local object
  object, message, code = made(fail, create(packed, groups, values))
  if not object then return nil, message, code end
  local of = { groups = {}, count = 0, still = 0, bodies = {}, list = groups, lights = packed }
  for _, group in ipairs(groups) do
    of.count = of.count + group.caster.count
    if not group.name then of.still = of.count end
    if group.caster.surface then
      of.bodies[#of.bodies + 1] = { surface = group.caster.surface, first = group.first, count = group.caster.count }
    end
    if group.name then of.groups[group.name] = { first = group.first, count = group.caster.count,
      spheres = group.caster.hides == nil } end
  end
  core.own(object).about = of
  return object
end

shadowed.shadowed = form.define("shadowed", {
  numbers = 1e5,
  about = "Lights behind bodies that may move, as a light field: ylm.light_field and ylm.bake take it, and grids that are baked "
    .. "from it are rendered. A lamp is hidden by casters that are nearer than it; light without a place, of environments and "
    .. "other light fields, by all. It has count, the number of casters, move() and close().",
  fields = {
    { "lights", "any", about = "a light, a list of lights, or what has a light field" },
    { "casters", "any", about = "a caster, or a table of casters; those with names can be moved, others stand still" },
    products[1], products[2], products[3], products[4], products[5], products[6],
  },
  build = build_shadowed,
  example = [[
local ball = ylm.caster { hides = ylm.occluder { radius = 0.5 }, at = { 0, 1, 0 } }
local lamp = ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.3, radiance = 10 }
local shade = ylm.shadowed { lights = lamp, casters = { ball = ball } }
local dark = ylm.light_field(4, shade, { 0, 0, 0 }):totable()
shade:move { ball = { at = { 3, 1, 0 } } }
local lit = ylm.light_field(4, shade, { 0, 0, 0 }):totable()
assert(lit[1][1] > 3 * math.abs(dark[1][1]))]],
  source = "Zhou et al. 2005; Xin et al. 2021; docs/shadow_fields.md",
})

--- A list of lights, packed, as light behind no body: the metric of bakes. For lua/ylm/light.
function shadoweds.__join(packed) return shadowed.shadowed { lights = packed, casters = {} } end

--- The record of an open object; raises.
local function opened(name, s)
  local of = about_of(s)
  if core.type(s) ~= "ylm.shadowed" then
    return check.fail("%s: shadowed light expected before the colon, got %s", name, check.describe(s))
  end
  if not of or of.closed then return check.fail("%s: the shadowed light has been closed", name) end
  return of
end

function shadoweds.__index(s, key)
  if key == "count" and about_of(s) then return about_of(s).count end
  if key == "stats" and about_of(s) and not about_of(s).of then return core.shadowed_look(s) end
  return rawget(shadoweds, key)
end

function shadoweds.__tostring(s)
  local of = about_of(s)
  if not of or of.closed then return "ylm.shadowed (closed)" end
  return ("ylm.shadowed: light behind %d casters"):format(of.count)
end

local move_fields = {
  { "at", "any", optional = true }, { "rotation", "any", optional = true }, { "scale", "any", optional = true },
}

--- Arrays of a group of one caster.
local function one_place(values, fail)
  local out = {}
  if values.at ~= nil then
    local at, wanted = form.types.point(values.at)
    if not at then return fail("at must be " .. wanted) end
    out.at = doubles({ 1, 3 }, { at })
  end
  if values.rotation ~= nil then
    local r, wanted = form.types.rotation(values.rotation)
    if not r then return fail("rotation must be " .. wanted) end
    out.rotation = doubles({ 1, 9 }, { matrix_of(r) })
  end
  if values.scale ~= nil then
    local s, wanted = form.types.caster_scale(values.scale)
    if not s then return fail("scale must be " .. wanted) end
    out.scale = doubles({ 1 }, { s })
  end
  return out
end

--- Arrays of a group of n casters.
local function many_places(values, n, fail)
  local out = {}
  if values.at ~= nil then
    local function fits(s) return #s == 2 and s[1] == n and s[2] == 3 end
    out.at = numbers("at", values.at, ("[%d][3] numbers"):format(n), fits, fail)
  end
  if values.rotation ~= nil then out.rotation = matrices(values, n, fail) end
  if values.scale ~= nil then
    out.scale = spread(numbers("scale", values.scale, ("a number or %d of them"):format(n), one_each(n), fail), n)
  end
  return out
end

describe "shadowed:move" {
  about = "Puts casters elsewhere. Grids that were baked before stay as they are.",
  arguments = { { "places", "table", "by the names of casters: { name = { at =, rotation =, scale = } } as of caster "
    .. "or casters; what is left out stays. Of sphere_casters scale are the radii" } },
  returns = { { "shadowed", "shadowed", "the same" } },
  errors = "raises on a name that no caster has and on bad places: nothing is moved then of that name; nil, message, code where "
    .. "memory runs out",
  example = [[
local shade = ylm.shadowed { lights = ylm.environment_light { radiance = 1 },
  casters = { ball = ylm.caster { hides = ylm.occluder { radius = 1 } } } }
shade:move { ball = { at = { 0, 2, 0 }, scale = 0.5 } }]],
}
function shadoweds.move(s, places)
  local of = opened("move", s)
  if type(places) ~= "table" or form.kind(places) then
    return check.bad(1, "move", "a table of places by name expected, got %s", check.describe(places))
  end
  local names, known = {}, {}
  for name in pairs(of.groups) do known[#known + 1] = name end
  for name in pairs(places) do
    if not of.groups[name] then
      local guess = type(name) == "string" and check.guess(name, known)
      return check.bad(1, "move", "no caster has the name %s%s", check.describe(name),
        guess and (" (did you mean '%s'?)"):format(guess) or "")
    end
    names[#names + 1] = name
  end
  table.sort(names)
  for _, name in ipairs(names) do
    local group = of.groups[name]
    local function fail(message) return check.bad(1, "move", "%s: %s", name, message) end
    if type(places[name]) ~= "table" then return fail("a table { at =, rotation =, scale = } expected") end
    local values = form.check(move_fields, places[name], fail)
    local arrays = group.count == 1 and one_place(values, fail) or many_places(values, group.count, fail)
    local ok, message, code = check.result("move", core.shadowed_move(s, group.first, group.count, arrays.at, arrays.rotation,
      arrays.scale))
    if not ok then return nil, message, code end
  end
  return s
end

--- Bodies with a surface, in order: { surface = list of geometry, at, rotation {9 numbers}, scale, number from 0 on }; nil,
-- message, code.
function shadowed.bodies(name, s)
  local list = {}
  for _, body in ipairs(opened(name, s).bodies) do
    for i = body.first, body.first + body.count - 1 do
      local at, rotation, scale = check.result(name, core.shadowed_caster(s, i))
      if not at then return nil, rotation, scale end
      list[#list + 1] = { surface = body.surface, at = at, rotation = rotation, scale = scale, number = i }
    end
  end
  return list
end

--- Light behind all casters but number i, from 0 on; nil, message, code.
function shadowed.beside(name, s, i)
  return check.result(name, core.shadowed_without(s, i, 1))
end

describe "shadowed:without" {
  about = "The light that some casters let through, a light field. Without a caster by name it is that of the surface of this "
    .. "body, which stands in its own shadow otherwise. Without those that have no name it is light for surfaces that stand "
    .. "still and know them by transfer vectors. It follows the casters, and lasts as long as the shadowed light is open.",
  arguments = { { "name?", "string", "of a caster, or of casters, all of which are left out; nil: casters without a name" } },
  returns = { { "light", "shadowed", "a light field" } },
  errors = "raises on a name that no caster has; nil, message, code where memory runs out",
  example = [[
local shade = ylm.shadowed { lights = ylm.environment_light { radiance = 1 },
  casters = { ball = ylm.caster { hides = ylm.occluder { radius = 1 } } } }
local L = ylm.light_field(2, shade:without "ball", { 1, 0, 0 })
assert(math.abs(L:get(1, 1) - math.sqrt(4 * math.pi)) < 1e-6)]],
}
function shadoweds.without(s, name)
  local of = opened("without", s)
  local group = name == nil and { first = 0, count = of.still } or of.groups[name]
  if of.of then return check.fail "without: light without some casters is left as it is: ask the shadowed light that it is of" end
  if not group then return check.bad(1, "without", "no caster has the name %s", check.describe(name)) end
  local object, message, code = check.result("without", core.shadowed_without(s, group.first, group.count))
  if not object then return nil, message, code end
  core.own(object).about = { groups = {}, bodies = {}, count = about_of(s).count - group.count, of = s }
  return object
end

--- Three rows of four numbers that place a body.
local function matrix_of_place(b)
  local m = {}
  for i = 1, 3 do
    m[i] = { b.at[i] }
    for k = 3, 1, -1 do table.insert(m[i], 1, b.scale * b.rotation[3 * (i - 1) + k]) end
  end
  return m
end

describe "shadowed:surfaces" {
  about = "The surfaces of casters where they stand now, as geometry: a scene with them has true shadows by rays.",
  arguments = {},
  returns = { { "geometry", "table", "a list of meshes, for the geometry of a scene" } },
  errors = "raises on what is no shadowed light; nil, message, code where memory runs out",
  example = [[
local block = ylm.box {}
local body = ylm.caster { hides = ylm.occluder { geometry = block }, surface = block, at = { 0, 1, 0 } }
local shade = ylm.shadowed { lights = ylm.environment_light { radiance = 1 }, casters = { body = body } }
local still = ylm.scene "still" { geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
  shade:surfaces() }, lights = ylm.environment_light { radiance = 1 } }
assert(#still.geometry == 2)]],
}
function shadoweds.surfaces(s)
  local list, message, code = shadowed.bodies("surfaces", s)
  if not list then return nil, message, code end
  local out = {}
  for _, body in ipairs(list) do
    for _, part in ipairs(body.surface) do
      local m, entry = part.mesh
      entry, message, code = geometry.mesh { vertices = m:vertices(), triangles = m:triangles(), normals = m:normals(),
        uvs = m:uvs(), matrix = matrix_of_place(body), material = part.material, occludes = part.occludes }
      if not entry then return nil, message, code end
      out[#out + 1] = entry
    end
  end
  return out
end

describe "shadowed:close" {
  about = "Frees the memory of shadowed light now rather than at the next collection.",
  arguments = {}, returns = {}, errors = "raises on what is none",
  example = "ylm.shadowed({ lights = {}, casters = {} }):close()",
}
function shadoweds.close(s)
  if core.type(s) ~= "ylm.shadowed" then
    return check.fail("close: shadowed light expected before the colon, got %s", check.describe(s))
  end
  local of = about_of(s)
  check.result("close", core.shadowed_close(s))
  core.own(s).about = { closed = true, count = of and of.count, of = of and of.of }
end

memory.publish(shadoweds)

shadowed.groups_of, shadowed.create, shadowed.settle = groups_of, create, settle
shadowed.heed, shadowed.products = heed, products

return shadowed
