--- Bodies in the way of light: ylm.caster, casters, sphere_casters.
--
-- A caster is data: of (what hides light, nil for spheres), count, and double arrays at [n][3], rotation [n][9], scale [n],
-- body [n]. ylm.shadowed joins the casters of all groups into one list.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local numbers = require "ylm.light.numbers"
local occluder = require "ylm.shadow.occluder"

local EXTENT = core.limits.extent
local IDENTITY = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }
local PI = math.pi

local caster = {}

local mesh_of, body_of = occluder.mesh_of, occluder.body_of

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

caster.caster = form.define("caster", {
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

caster.casters = form.define("casters", {
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

caster.sphere_casters = form.define("sphere_casters", {
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

caster.doubles, caster.matrix_of, caster.matrices = doubles, matrix_of, matrices
caster.one_each, caster.spread = one_each, spread

return caster
