--- Light behind bodies: ylm.occluder, caster, casters, sphere_casters, shadowed, visibility.
--
-- A caster is data: of (what hides light, nil for spheres), count, and double arrays at [n][3], rotation [n][9], scale [n],
-- body [n]. ylm.shadowed joins the casters of all groups into one list.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local reference = require "ylm.describe"
local form = require "ylm.form"
local library = require "ylm.library"
require "ylm.grid" -- defines grid.body
local light = require "ylm.light"
local memory = require "ylm.memory"
local numbers = require "ylm.light.numbers"
local warning = require "ylm.warning"

local describe = reference.describe

local geometry = require "ylm.geometry" -- defines form.types.rotation

local shadow = {}

local EXTENT = core.limits.extent
local IDENTITY = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }
local PI = math.pi

-- Bodies --------------------------------------------------------------------------------------

reference.object "occluder" {
  about = "The visibility around a body, a light field; from the constructor of that name.",
  fields = { { "radius", "number", "of a sphere around the body" }, { "area", "number", "the mean of its projections' areas" },
    { "rays", "integer", "of a body by rays, else nil" } },
}

local occluders = core.metatable "ylm.occluder"

--- The mesh of a mesh or a shape, else nil.
local function mesh_of(x)
  if core.type(x) == "ylm.mesh" then return x end
  local mesh = type(x) == "table" and form.kind(x) and rawget(x, "mesh")
  return core.type(mesh) == "ylm.mesh" and mesh or nil
end

--- An object that C makes for a form, or nil, message, code; fail(message) raises.
local function made(fail, object, message, code)
  if object == nil and core.status(code) == "caller" then return fail(message) end
  return object, message, code
end

local BY_RAYS = "bodies by rays need libylm_scene with Embree 3 or 4 (Debian 12 and 13: apt install libembree-dev, then make): %s"

--- { rays, near } of an occluder: rays of one that is known by rays, where the nearest receivers are; nil once closed.
local function how_of(occluder) return core.owned(occluder, "how") end

--- The object of a closed mesh: exact, or by rays.
local function build_mesh(values, mesh, fail)
  if not values.rays then return made(fail, core.occluder_solid(mesh)) end
  local tracer, message, code = library.open("scene", BY_RAYS)
  if not tracer then return nil, message, code end
  return made(fail, tracer.occlusion_create(mesh, values.rays))
end

--- The object, and where its nearest receivers are.
local function remember(values, object, message, code)
  if not object then return nil, message, code end
  core.own(object).how = { rays = values.rays, near = values.near }
  return object
end

local function build_occluder(values, fail)
  if values.rays and values.geometry == nil then return fail "rays are of geometry: a sphere is known exactly" end
  if values.geometry ~= nil then
    if values.radius then return fail "radius is of a sphere: give geometry or radius, not both" end
    if values.at then return fail "at is of a sphere: geometry is where its vertices are" end
    local mesh = mesh_of(values.geometry)
    if not mesh then return fail("geometry must be a mesh or a shape, got " .. check.describe(values.geometry)) end
    return remember(values, build_mesh(values, mesh, fail))
  end
  if not values.radius then return fail "give geometry, a closed convex mesh, or radius, of a sphere" end
  local at = values.at or { 0, 0, 0 }
  return remember(values, made(fail, core.occluder_sphere(at[1], at[2], at[3], values.radius)))
end

shadow.occluder = form.define("occluder", {
  numbers = 1e5,
  about = "The visibility around one body, as a light field: 1 from where light reaches a point, 0 from where the body "
    .. "is. Exact for spheres and convex solids, with gradients and Hessians; by rays for other closed meshes, with gradients. "
    .. "It is no light: ylm.caster puts it in the way of lights, ylm.bake remembers it. It has radius, of a sphere around the "
    .. "body, area, the mean of its projections, rays, noise() and close().",
  fields = {
    { "geometry", "any", optional = true, unit = "scene units",
      about = "a closed mesh or shape in the body's frame; without rays it is convex, of at most 4096 triangles" },
    { "radius", "number", above = 0, max = EXTENT, optional = true, unit = "scene units", about = "of a sphere instead" },
    { "at", "point", optional = true, unit = "scene units", about = "centre of the sphere, default {0, 0, 0}" },
    { "rays", "integer", min = 4, max = 1024, optional = true,
      about = "geometry of any shape, by rays: so many along a right angle, twice as many across a body that is seen within "
        .. "one; 64 is a good number. Parts that look thinner than the distance of two rays may be missed" },
    { "near", "number", above = 0, max = 1, default = 0.02, unit = "radii",
      about = "how near to the surface the places are that a bake of it serves" },
  },
  build = build_occluder,
  example = "occluder { radius = 0.5 }",
  source = "Zhou et al. 2005",
})

--- The sphere around a body and its mean area: at, radius, area; nil once closed.
local function body_of(occluder)
  local x, y, z, radius, area = core.occluder_body(occluder)
  if x then return { x, y, z }, radius, area end
end

function occluders.__index(o, key)
  if key == "radius" then return (select(2, body_of(o))) end
  if key == "area" then return (select(3, body_of(o))) end
  if key == "rays" then return (how_of(o) or {}).rays end
  return rawget(occluders, key)
end

function occluders.__tostring(o)
  local _, radius = body_of(o)
  return radius and ("ylm.occluder of radius %g"):format(radius) or "ylm.occluder (closed)"
end

-- Grids of bodies reach so many radii where nobody says; their tolerance holds at so many places. The noise of rays is
-- measured at so many, and a tolerance is so many times the noise, or more.
local REACH, PLACES, LOOKS, QUIET = 20, 20000, 16, 2

--- Places around a body, from `near` radii off its surface to a distance: float [n][3]; nil, message, code.
local function places_around(o, near, far, n)
  local _, radius = body_of(o)
  local exact = not how_of(o).rays -- near of a convex body is a part of the way from its middle to its surface
  return check.result("occluder", core.occluder_places(o, exact and near or near * radius, far, n))
end

describe "occluder:noise" {
  about = "The error of the values of a body by rays, as a part of the function 1: half of the largest distance to those by half "
    .. "of the rays, at 16 places around the body.",
  arguments = { { "lmax", "integer", "highest degree, 0 to 100" }, { "options?", "table", "see the options" } },
  options = { form.threads },
  returns = { { "noise", "number", "0 of a body that is known exactly" } },
  errors = "raises on bad arguments and a body that has been closed; nil, message, code: memory",
  example = [[
local body = ylm.occluder { geometry = ylm.box {} }
assert(body:noise(4) == 0)]],
}
function occluders.noise(o, lmax, given)
  if core.type(o) ~= "ylm.occluder" then
    return check.fail("noise: an occluder expected before the colon, got %s", check.describe(o))
  end
  check.integer(1, "noise", "lmax", lmax, 0, core.limits.sh_product_lmax)
  local options = form.options(2, "noise", { form.threads }, given)
  local _, radius = body_of(o)
  if not radius then return check.fail("noise: the occluder has been closed") end
  if not how_of(o).rays then return 0 end
  local places, message, code = places_around(o, how_of(o).near, REACH * radius, LOOKS)
  if not places then return nil, message, code end
  return check.result("noise", library.open("scene", BY_RAYS).occlusion_noise(o, lmax, places, options.threads or 0))
end

--- Refuses a tolerance that is below the noise of rays; nil, message, code.
local function check_noise(o, description)
  if not description.tolerance then return true end
  local noise, message, code = o:noise(description.lmax)
  if not noise then return nil, message, code end
  if description.tolerance >= QUIET * noise then return true end
  return check.bad(1, "bake", "tolerance %g is below the noise of rays here, %.2g: rays = %d may do, or tolerance = %.2g",
    description.tolerance, noise, math.min(1024, math.ceil(how_of(o).rays * QUIET * noise / description.tolerance)),
    QUIET * noise * 1.05)
end

--- Options of a bake of a body, for lua/ylm/grid/bake.lua: bounds and places where nobody says.
function occluders.__for_grid(o, description, given)
  local at, radius, area = body_of(o)
  if description.channels == "rgb" then
    return check.bad(1, "bake", "a visibility has no colour: channels = 'luminance' in the grid")
  end
  if not at then return check.bad(2, "bake", "the occluder has been closed") end
  local quiet, message, code = check_noise(o, description)
  if not quiet then return nil, message, code end
  local options, box = {}, description.bounds or given.bounds
  for key, value in pairs(given) do options[key] = value end
  if not box then
    local r = REACH * radius
    box = { { at[1] - r, at[2] - r, at[3] - r }, { at[1] + r, at[2] + r, at[3] + r } }
    options.bounds = box
  end
  if given.occupied == nil and given.geometry == nil and description.depth then
    local far = math.huge
    for a = 1, 3 do far = math.min(far, at[a] - box[1][a], box[2][a] - at[a]) end
    options.occupied, message, code = places_around(o, how_of(o).near, math.max(far, 2 * radius), PLACES)
    if not options.occupied then return nil, message, code end
  end
  return options, { at[1], at[2], at[3], radius, area }
end

describe "occluder:close" {
  about = "Frees the memory of a body now rather than at the next collection.",
  arguments = {}, returns = {}, errors = "raises on what is no body",
  example = "ylm.occluder({ radius = 1 }):close()",
}
function occluders.close(o)
  if core.type(o) ~= "ylm.occluder" then
    return check.fail("close: an occluder expected before the colon, got %s", check.describe(o))
  end
  check.result("close", core.occluder_close(o))
end

-- Casters -------------------------------------------------------------------------------------

--- The mean area of the projections of a body that a grid was baked from, by what it hides at places along a spiral inside
-- its bounds.
local function area_of(grid, centre, far)
  local places, sum, n = {}, 0, 128
  for i = 1, n do
    local z, phi = 1 - (2 * i - 1) / n, 2.39996322972865332 * i -- the golden angle
    local s = math.sqrt(1 - z * z)
    local w = { s * math.cos(phi), s * math.sin(phi), z }
    places[i] = { centre[1] + 0.9 * far * w[1], centre[2] + 0.9 * far * w[2], centre[3] + 0.9 * far * w[3] }
  end
  local c, message, code = grid:sample(places)
  if not c then return nil, message, code end
  for i = 1, n do
    local open = c:get(i, 1, 1) / math.sqrt(4 * PI) -- part of all directions
    sum = sum + 4 * PI * (1 - open) * (0.9 * far) ^ 2
  end
  return math.max(sum / n, 1e-12 * far ^ 2)
end

--- Facts about a grid of visibilities for C: { lmax, centre, radius, far, area }; fail raises; nil, message, code.
local function facts_of_grid(values, fail)
  local grid = values.hides
  local body = grid.body
  local centre, radius, area = { 0, 0, 0 }, values.radius, nil
  if body and not values.radius then centre, radius, area = body.at, body.radius, body.area end
  if not radius then
    return fail "radius is missing: this grid does not know how large its body is (of a sphere around it, in its frame)"
  end
  local far, box = math.huge, grid.bounds
  for a = 1, 3 do far = math.min(far, centre[a] - box[1][a], box[2][a] - centre[a]) end
  if not (far > radius) then
    return fail(("the grid's bounds end %.3g from the body's middle, within its radius of %.3g"):format(far, radius))
  end
  if not area then
    local message, code
    area, message, code = area_of(grid, centre, far)
    if not area then return nil, message, code end
  end
  return { grid.lmax, centre[1], centre[2], centre[3], radius, far, area }
end

--- Facts about any light field that a caster may have.
local function facts_of(values, fail)
  local hides, kind = values.hides, core.type(values.hides)
  if kind == "ylm.grid" then
    local fault = check.grid_fault(hides)
    if fault then return fail("hides: " .. fault) end
  end
  local known, quantity = pcall(core.field_quantity, hides)
  if not core.has_field(hides) then
    return fail("hides must be an occluder, or a grid that was baked from one, got " .. check.describe(hides))
  end
  if not known then return fail("hides: the " .. kind:gsub("^ylm%.", "") .. " has been closed") end
  if quantity ~= "visibility" then
    return fail(("hides must be a visibility, and this %s holds %s: bake ylm.occluder"):format((kind:gsub("^ylm%.", "")),
      quantity))
  end
  if kind == "ylm.grid" then return facts_of_grid(values, fail) end
  if kind ~= "ylm.occluder" then return fail("hides must be an occluder or a grid, got " .. check.describe(hides)) end
  local at, radius = body_of(hides)
  return { core.limits.sh_product_lmax, at[1], at[2], at[3], values.radius or radius, 0, 0 }
end

--- A double array of this shape from a table of numbers, row by row.
local function doubles(shape, list)
  local a = assert(core.array_zeros(shape, "double"))
  if #list > 0 then core.array_fill(a, list) end
  return a
end

local function one_number(_, scale)
  if type(scale) == "table" or core.type(scale) == "ylm.array" then
    return nil, "one number: shear is not a rotation"
  end
end

function form.types.caster_scale(x)
  if check.is_number(x) and x > 0 then return x end
  local _, wanted = one_number(nil, x)
  return nil, wanted or "a number > 0"
end

--- Nine numbers, row by row, of rotations in order of application.
local function matrix_of(rotation)
  local r = IDENTITY
  for _, one in ipairs(rotation or {}) do
    local m, out = core.mesh_rotation(one.axis, math.rad(one.angle)), {}
    for i = 0, 2 do
      for j = 1, 3 do
        local sum = 0
        for k = 1, 3 do sum = sum + m[4 * i + k] * r[3 * (k - 1) + j] end
        out[3 * i + j] = sum
      end
    end
    r = out
  end
  return r
end

--- The surfaces of a shape or a list of shapes, a flat list; fail(message) raises.
local function surfaces_of(x, fail)
  local out = {}
  local function add(entry)
    if mesh_of(entry) == nil or core.type(entry) == "ylm.mesh" then
      return fail("surface must be a shape (box, sphere, mesh ...) or a list of them, got " .. check.describe(entry))
    end
    for _, part in ipairs(entry.parts or { entry }) do out[#out + 1] = part end
  end
  if type(x) ~= "table" or form.kind(x) then add(x)
  else for i = 1, #x do add(x[i]) end end
  if #out == 0 then return fail "surface: an empty list" end
  return out
end

local function finish(values, name, fail)
  if values.surface ~= nil then values.surface = surfaces_of(values.surface, fail) end
  if values.hides ~= nil then
    local message, code
    values.facts, message, code = facts_of(values, fail)
    if not values.facts then return nil, message, code end
  end
  return setmetatable(values, form.defined[name].metatable)
end

shadow.caster = form.define("caster", {
  numbers = 64,
  about = "A body in the way of light, for ylm.shadowed.",
  fields = {
    { "hides", "any", about = "an occluder, or a grid that was baked from one; many casters may share it" },
    { "at", "point", default = { 0, 0, 0 }, unit = "scene units", about = "where the origin of the body's frame stands" },
    { "rotation", "rotation", optional = true, unit = "degrees", about = "{ axis =, angle = }, or a list of such" },
    { "scale", "caster_scale", default = 1, about = "one factor: larger bodies of the same shape" },
    { "radius", "number", above = 0, max = EXTENT, optional = true, unit = "scene units",
      about = "of a sphere about the origin of the body's frame that holds it. Default: of the body; grids remember it" },
    { "surface", "any", optional = true,
      about = "a shape or a list of shapes in the body's frame: view:render { bodies = shade } draws them" },
  },
  build = function(values, fail)
    values.count = 1
    values.places = { at = doubles({ 1, 3 }, { values.at }), rotation = doubles({ 1, 9 }, { matrix_of(values.rotation) }),
      scale = doubles({ 1 }, { values.scale }), body = doubles({ 1 }, { 0 }) }
    return finish(values, "caster", fail)
  end,
  metatable = { __tostring = function(c) return ("caster at {%g, %g, %g}"):format(c.at[1], c.at[2], c.at[3]) end },
  example = "caster { hides = occluder { radius = 0.5 }, at = { 0, 1, 0 } }",
})

local function one_each(n)
  return function(s) return #s == 1 and (s[1] == 1 or s[1] == n) end
end

--- n numbers from a double array of n or one.
local function spread(a, n)
  if a.shape[1] == n then return a end
  local list = {}
  for i = 1, n do list[i] = a:get(1) end
  return doubles({ n }, list)
end

--- Rotations [n][9] from quaternions [n][4] or one.
local function matrices(values, n, fail)
  local rows = {}
  if not values.rotation then
    for i = 1, n do rows[i] = IDENTITY end
    return doubles({ n, 9 }, rows)
  end
  local q, shape = numbers("rotation", values.rotation, "quaternions {w, x, y, z} [n][4], or one", function(s)
    return #s == 1 and s[1] == 4 or #s == 2 and s[2] == 4 and s[1] == n
  end, fail)
  local list = core.array_totable(q)
  for i = 1, n do
    local w = #shape == 1 and list or list[i]
    local a, b, c, d = w[1], w[2], w[3], w[4]
    local length2 = a * a + b * b + c * c + d * d
    if not (length2 > 0 and length2 < math.huge) then return fail(("rotation: quaternion %d has no length"):format(i)) end
    local s = 2 / length2
    rows[i] = { 1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c),
      s * (b * c + a * d), 1 - s * (b * b + d * d), s * (c * d - a * b),
      s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c) }
  end
  return doubles({ n, 9 }, rows)
end

--- Centres [n][3] and n.
local function places_of(values, fail)
  local at, shape = numbers("at", values.at, "[n][3] numbers", function(s)
    return #s == 1 and s[1] == 0 or #s == 2 and s[2] == 3
  end, fail)
  local n = shape[1]
  if n > core.limits.casters then return fail(("at: at most %d casters expected, got %d"):format(core.limits.casters, n)) end
  form.take_numbers({ 12, n }, fail)
  return at, n
end

shadow.casters = form.define("casters", {
  about = "Many bodies of one shape in the way of light, for ylm.shadowed.",
  fields = {
    { "hides", "any", about = "as of caster" },
    { "at", "any", unit = "scene units", about = "[n][3], 65535 at most" },
    { "rotation", "any", optional = true, about = "quaternions {w, x, y, z} of any length but 0: [n][4], or one" },
    { "scale", "any", default = 1, about = "[n] factors, or one" },
    { "radius", "number", above = 0, max = EXTENT, optional = true, unit = "scene units", about = "as of caster" },
    { "surface", "any", optional = true,
      about = "as of caster" },
  },
  build = function(values, fail)
    local at, n = places_of(values, fail)
    local scale = numbers("scale", values.scale, ("a number or one for each of the %d casters: shear is not a rotation")
      :format(n), one_each(n), fail)
    values.places = { at = at, rotation = matrices(values, n, fail), scale = spread(scale, n), body = doubles({ n }, {}) }
    values.count = n
    return finish(values, "casters", fail)
  end,
  metatable = { __tostring = function(c) return ("%d casters"):format(c.count) end },
  example = "casters { hides = occluder { radius = 0.5 }, at = { {0, 1, 0}, {2, 1, 0} } }",
})

shadow.sphere_casters = form.define("sphere_casters", {
  about = "Spheres in the way of light, for ylm.shadowed. They are evaluated at the directions of the product's rule; spheres "
    .. "of one body hide what any of them hides, however they overlap.",
  fields = {
    { "at", "any", unit = "scene units", about = "[n][3] centres, 65535 at most" },
    { "radius", "any", unit = "scene units", about = "[n] numbers > 0, or one" },
    { "body", "any", default = 1, about = "[n] integers from 1 on, or one: equal ones are one body" },
  },
  build = function(values, fail)
    local at, n = places_of(values, fail)
    local radius = numbers("radius", values.radius, ("a number or one for each of the %d spheres"):format(n), one_each(n), fail)
    local body = numbers("body", values.body, ("an integer or one for each of the %d spheres"):format(n), one_each(n), fail)
    for i = 1, #body do
      local b = body:get(i)
      if not check.is_integer(b) or b < 1 or b > 2 ^ 31 then return fail(("body %d must be an integer from 1 on"):format(i)) end
    end
    local rows = {}
    for i = 1, n do rows[i] = IDENTITY end
    values.places = { at = at, rotation = doubles({ n, 9 }, rows), scale = spread(radius, n), body = spread(body, n) }
    values.count = n
    return finish(values, "sphere_casters", fail)
  end,
  metatable = { __tostring = function(c) return ("%d sphere casters"):format(c.count) end },
  example = "sphere_casters { at = { {0, 1, 0}, {0, 1.5, 0} }, radius = { 0.5, 0.3 } }",
})

-- Light behind them ---------------------------------------------------------------------------

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

shadow.shadowed = form.define("shadowed", {
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
function shadoweds.__join(packed) return shadow.shadowed { lights = packed, casters = {} } end

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
function shadow.bodies(name, s)
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
function shadow.beside(name, s, i)
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
  local list, message, code = shadow.bodies("surfaces", s)
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

-- Visibility ----------------------------------------------------------------------------------

local visibility_options = {
  { "derivatives", "integer", min = 0, max = 1, default = 0, about = "1: gradients too" },
  products[1], products[2], products[3], products[4], products[5], products[6],
  { "dtype", "choice", of = core.choices "dtype", optional = true,
    about = "element type; that of the points where they are an array, else float" },
  form.threads, form.progress,
}

describe "visibility" {
  about = "The part of all directions that casters leave open at points, as spherical harmonics: what ylm.shadowed multiplies "
    .. "light by.",
  arguments = {
    { "lmax", "integer", "highest degree, 0 to 100" },
    { "casters", "caster|table", "a caster, or a table of casters" },
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "options?", "table", "see the options" },
  },
  options = visibility_options,
  returns = { { "V", "array", "[n][(lmax+1)^2]; without casters sqrt(4 pi) in Y(0,0)" },
    { "dV", "array", "[n][(lmax+1)^2][3] with respect to the point, or nil" } },
  errors = "raises on bad arguments; nil, message, code: memory, cancelled",
  example = [[
local ball = ylm.caster { hides = ylm.occluder { radius = 1 }, at = { 0, 2, 0 } }
local V = ylm.visibility(4, ball, { 0, 0, 0 })
assert(math.abs(V[1] / math.sqrt(4 * math.pi) - (1 + math.cos(math.pi / 6)) / 2) < 1e-6)]],
  source = "Zhou et al. 2005; docs/shadow_fields.md",
}
function shadow.visibility(lmax, casters, points, given)
  check.integer(1, "visibility", "lmax", lmax, 0, core.limits.sh_product_lmax)
  local o = settle(form.options(4, "visibility", visibility_options, given), function(message)
    return check.bad(4, "visibility", "%s", message)
  end)
  local function fail(message) return check.bad(2, "visibility", "%s", message) end
  local groups = groups_of(casters, fail)
  local one, message, code = light.field(2, "visibility", require "ylm.light.environment".environment_light { radiance = 1 })
  if not one then return nil, message, code end
  local object
  object, message, code = made(fail, create(one, groups, o))
  if not object then return nil, message, code end
  local dtype = o.dtype or array.type_of(points, "float")
  local p, single = array.points(3, "visibility", points, dtype)
  local V, dV, why = light.evaluate("visibility", lmax, object, p, { derivatives = o.derivatives, channels = "luminance",
    threads = o.threads, progress = o.progress })
  if V == nil then return nil, dV, why end
  check.result("visibility", core.shadowed_close(object))
  heed(groups, groups, lmax)
  local n, count = #p, (lmax + 1) ^ 2
  if single then return core.array_reshape(V, { count }), dV and core.array_reshape(dV, { count, 3 }) end
  return core.array_reshape(V, { n, count }), dV and core.array_reshape(dV, { n, count, 3 })
end

memory.publish(occluders)
memory.publish(shadoweds)

return shadow
