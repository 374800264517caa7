--- Geometry of scenes: quads, spheres, boxes, tori, knots and meshes, as triangles.
--
-- A constructor's result is a table of its kind ("quad", ...) with the fields mesh (a "ylm.mesh"),
-- material and occludes.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local material = require "ylm.material"
local memory = require "ylm.memory"
local mtl = require "ylm.material.mtl"
local show = require "ylm.show"
local text = require "ylm.text"
local unwrap = require "ylm.geometry.unwrap"
local warning = require "ylm.warning"

local geometry = {}

-- Transforms: first scale, then rotate, then at; `matrix` instead of the three ----------

function form.types.scale(x)
  if check.is_number(x) and x ~= 0 then return { x, x, x } end
  local v = form.types.point(x)
  if v and v[1] ~= 0 and v[2] ~= 0 and v[3] ~= 0 then return v end
  return nil, "a number or {x, y, z}, none of them zero"
end

--- One rotation: { axis = {x, y, z}, angle = degrees }; or several of them, in order of application.
local function one_rotation(x)
  if type(x) ~= "table" then return nil end
  for key in pairs(x) do if key ~= "axis" and key ~= "angle" then return nil end end
  local axis = x.axis and form.types.vector(x.axis)
  return axis and check.is_number(x.angle) and { axis = axis, angle = x.angle } or nil
end

function form.types.rotation(x)
  local wanted = "{ axis = {x, y, z}, angle = degrees }, or a list of such"
  if type(x) ~= "table" then return nil, wanted end
  if #x == 0 then x = { x } end
  local all = {}
  for i = 1, #x do
    all[i] = one_rotation(x[i])
    if not all[i] then return nil, wanted end
  end
  return all
end

--- Three rows of four numbers.
function form.types.matrix(x)
  local wanted = "three rows of four numbers, y = A x + b"
  x = check.plain(x)
  if type(x) ~= "table" or (#x ~= 3 and #x ~= 4) then return nil, wanted end
  local flat = {}
  for i = 1, 3 do
    if type(x[i]) ~= "table" or #x[i] ~= 4 then return nil, wanted end
    for j = 1, 4 do
      if not check.is_number(x[i][j]) then return nil, wanted end
      flat[#flat + 1] = x[i][j]
    end
  end
  return flat
end

--- Product of two affine transforms of twelve numbers: a after b.
local function compose(a, b)
  local r = {}
  for i = 0, 2 do
    for j = 1, 4 do
      local sum = j == 4 and a[4 * i + 4] or 0
      for k = 1, 3 do sum = sum + a[4 * i + k] * b[4 * (k - 1) + j] end
      r[4 * i + j] = sum
    end
  end
  return r
end

local function placement(values, fail)
  local moved = values.at or values.rotate or values.scale
  if values.matrix then
    if moved then return fail "matrix stands instead of at, rotate and scale, not beside them" end
    return values.matrix
  end
  if not moved then return nil end
  local s = values.scale or { 1, 1, 1 }
  local m = { s[1], 0, 0, 0, 0, s[2], 0, 0, 0, 0, s[3], 0 }
  for _, r in ipairs(values.rotate or {}) do m = compose(core.mesh_rotation(r.axis, math.rad(r.angle)), m) end
  if values.at then m = compose({ 1, 0, 0, values.at[1], 0, 1, 0, values.at[2], 0, 0, 1, values.at[3] }, m) end
  return m
end

local common = {
  { "at", "point", optional = true, unit = "scene units", about = "where the origin moves, after rotate" },
  { "rotate", "rotation", optional = true, unit = "degrees",
      about = "{ axis =, angle = }, or a list of such; after scale" },
  { "scale", "scale", optional = true, about = "a factor, or one for each axis" },
  { "matrix", "matrix", optional = true, about = "three rows of four numbers, instead of at, rotate, scale" },
  { "material", "object", of = material.kinds, what = "a material", optional = true,
    about = "reflectance: matte { albedo = 0.75 }" },
  { "occludes", "boolean", default = true, about = "whether it casts shadows" },
  { "sides", "choice", of = core.choices "sides", optional = true,
    about = "which sides reflect to other surfaces (scene:links); front: from which the corners of triangles run "
      .. "counter-clockwise" },
}

--- Moves all meshes of an entry: true, or nil, message, code.
local function place(name, entry, transform)
  local meshes = { entry.mesh }
  for _, list in ipairs { entry.parts or {}, entry.emitters or {} } do
    for _, part in ipairs(list) do if part.mesh ~= entry.mesh then meshes[#meshes + 1] = part.mesh end end
  end
  for _, mesh in ipairs(transform and meshes or {}) do
    local ok, message, code = check.result(name, core.mesh_transform(mesh, transform))
    if not ok then return nil, message, code end
  end
  return true
end

--- Raises where a part has a texture and no place to look it up at.
local function check_texture(part, fail)
  if part.material and material.texture(part.material) and not core.mesh_uvs(part.mesh) then
    return fail(("%s has a texture, and the mesh no texture coordinates (uvs; of an OBJ file vt)"):format(
      part.name and "material '" .. text.shown(check.short(part.name)) .. "'" or "the material"))
  end
end

--- Says what was made of the materials of a file, and warns of what is missing.
local function tell(entry, set, emitting)
  local notes = set.notes
  if emitting > 0 then
    local triangles = 0
    for _, part in ipairs(entry.emitters) do triangles = triangles + #part.mesh end
    notes[#notes + 1] = ("%s: %s of materials with Ke emit%s light to both sides as polygon lights, instead of surfaces"):format(
      text.shown(set.file), triangles == 1 and "1 triangle" or triangles .. " triangles", triangles == 1 and "s" or "")
  end
  entry.notes = #notes > 0 and notes or nil
  for i, sentence in ipairs(set.warnings) do warning.say(entry, i, "%s", sentence) end
end

--- Puts the parts of a file into its entry: one surface has its material, several are listed.
local function add_parts(entry, parts, set, fail)
  if form.budget then form.budget("numbers", 64 * (#parts - 1), fail) end
  local surfaces, emitters = {}, {}
  for _, part in ipairs(parts) do
    local list = part.emission and emitters or surfaces
    list[#list + 1] = setmetatable({ mesh = part.mesh, name = part.name, material = part.material, emission = part.emission,
      occludes = entry.occludes, sides = entry.sides }, getmetatable(entry))
  end
  if #parts == 1 and #surfaces == 1 then entry.material, entry.name = surfaces[1].material, surfaces[1].name
  else entry.parts, entry.emitters = surfaces, #emitters > 0 and emitters or nil end
  tell(entry, set, #emitters)
end

--- The mesh of an entry, of flat shapes without subdivision; nil, message, code. Textures and colours of vertices keep theirs.
function geometry.plain(entry)
  local plain = core.owned(entry, "plain") -- how it is made without subdivision, where that is the same surface
  if not plain or entry.material and material.texture(entry.material) or core.mesh_colours(entry.mesh) then return entry.mesh end
  local mesh, message, code = plain.make()
  if not mesh then return nil, message, code end
  if plain.transform then
    local ok
    ok, message, code = core.mesh_transform(mesh, plain.transform)
    if not ok then return nil, message, code end
  end
  return mesh
end

--- Defines a shape: `make(values, fail)` returns a mesh (of a file also what parts_of_file returns), or nil, message, code;
-- `triangles(values)` says beforehand how many there will be (scene files are bounded by it).
local function shape(name, definition)
  local fields = definition.fields
  for _, field in ipairs(common) do fields[#fields + 1] = field end
  local make = definition.make
  definition.make = nil
  definition.metatable = { __kind = name, __tostring = function(x)
    local parts = { { "mesh" }, { "name" }, { "material" }, { "occludes" }, { "sides" }, { "parts" } }
    return show.form(name, parts, function(field) return rawget(x, field) end)
  end }
  definition.numbers = 64
  definition.build = function(values, fail)
    local transform = placement(values, fail)
    local mesh, parts, set = check.result(name, make(values, fail)) -- or nil, message, code
    if not mesh then return nil, parts, set end
    local entry = setmetatable({ mesh = mesh, material = values.material, occludes = values.occludes,
      sides = values.sides }, definition.metatable)
    if parts then add_parts(entry, parts, set, fail) end
    if definition.plain then core.own(entry).plain = { make = definition.plain(values), transform = transform } end
    local ok, message, code = place(name, entry, transform)
    if not ok then return nil, message, code end
    for _, part in ipairs(entry.parts or { entry }) do check_texture(part, fail) end
    return entry
  end
  geometry[name] = form.define(name, definition)
end

--- `divide`: an integer, or one for each of the two directions.
function form.types.divisions(x)
  if check.is_integer(x) and x >= 1 then return { x, x } end
  if type(x) == "table" and #x == 2 and check.is_integer(x[1]) and check.is_integer(x[2])
    and x[1] >= 1 and x[2] >= 1 then
    return { x[1], x[2] }
  end
  return nil, "an integer >= 1, or two of them"
end

shape("quad", {
  shelf = "everyday",
  about = "A parallelogram corner + s u + t v, s and t from 0 to 1; it faces along u x v.",
  fields = {
    { "corner", "point", unit = "scene units", about = "one corner" },
    { "u", "vector", unit = "scene units", about = "one side" },
    { "v", "vector", unit = "scene units", about = "the other side" },
    { "divide", "divisions", default = 1, about = "quads along u and v" },
  },
  triangles = function(v) return 2 * v.divide[1] * v.divide[2] end,
  make = function(q)
    return core.mesh_quad(q.corner, q.u, q.v, q.divide[1], q.divide[2])
  end,
  plain = function(q)
    local corner, u, v = q.corner, q.u, q.v
    return function() return core.mesh_quad(corner, u, v, 1, 1) end
  end,
  example = "quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 64 }",
})

shape("sphere", {
  shelf = "everyday",
  about = "A sphere about the origin (move it with at); its poles lie on the z axis.",
  fields = {
    { "radius", "number", above = 0, default = 1, unit = "scene units", about = "" },
    { "divide", "divisions", default = { 64, 32 }, about = "segments around, and from pole to pole" },
  },
  triangles = function(v) return 2 * v.divide[1] * v.divide[2] end,
  make = function(s) return core.mesh_sphere(s.radius, s.divide[1], s.divide[2]) end,
  example = "sphere { at = { 0, 1, 0 }, radius = 0.5 }",
})

shape("box", {
  shelf = "everyday",
  about = "A box between two corners.",
  fields = {
    { "bounds", "bounds", default = { { -0.5, -0.5, -0.5 }, { 0.5, 0.5, 0.5 } }, unit = "scene units",
      about = "lower and upper corner" },
    { "divide", "integer", min = 1, default = 1, about = "quads along each edge" },
  },
  triangles = function(v) return 12 * v.divide * v.divide end,
  make = function(b) return core.mesh_box(b.bounds[1], b.bounds[2], b.divide) end,
  plain = function(b)
    local lo, hi = b.bounds[1], b.bounds[2]
    return function() return core.mesh_box(lo, hi, 1) end
  end,
  example = "box { bounds = { { -1, 0, -1 }, { 1, 2, 1 } } }",
})

shape("torus", {
  about = "A ring about the z axis.",
  fields = {
    { "radius", "number", above = 0, default = 1, unit = "scene units",
      about = "from the axis to the middle of the tube" },
    { "tube", "number", above = 0, follows = { "radius", 0.25 }, unit = "scene units", about = "radius of the tube" },
    { "divide", "divisions", default = { 128, 64 }, about = "segments around the axis, and around the tube" },
  },
  triangles = function(v) return 2 * v.divide[1] * v.divide[2] end,
  make = function(t) return core.mesh_torus(t.radius, t.tube, t.divide[1], t.divide[2]) end,
  example = "torus { at = { 0, 0.6, 0 }, radius = 0.5, tube = 0.2 }",
})

shape("knot", {
  about = "A tube along the (p, q) torus knot: p times around the z axis, q times around the torus' own tube.",
  fields = {
    { "p", "integer", min = 1, max = 64, default = 2, about = "without a common divisor with q" },
    { "q", "integer", min = 1, max = 64, default = 3, about = "" },
    { "radius", "number", above = 0, default = 1, unit = "scene units", about = "of the torus that the knot lies on" },
    { "minor", "number", above = 0, follows = { "radius", 0.4 }, unit = "scene units", about = "of that torus' tube" },
    { "tube", "number", above = 0, follows = { "radius", 0.15 }, unit = "scene units",
      about = "radius of the knot's own tube" },
    { "divide", "divisions", default = { 512, 32 },
      about = "segments along the knot, and across its tube; 2 x their product triangles" },
  },
  triangles = function(v) return 2 * v.divide[1] * v.divide[2] end,
  make = function(k) return core.mesh_knot(k.p, k.q, k.radius, k.minor, k.tube, k.divide[1], k.divide[2]) end,
  example = "knot { p = 2, q = 3, radius = 1, minor = 0.4, tube = 0.15, divide = { 3000, 64 } }",
})

--- A mesh from arrays, or nil where the fields are not all there.
local function mesh_of_arrays(values)
  local vertices = array.points(1, "mesh", values.vertices)
  local triangles = array.rows(1, "mesh", "triangles", values.triangles, 3)
  local normals = values.normals ~= nil and array.rows(1, "mesh", "normals", values.normals, 3)
  local uvs = values.uvs ~= nil and array.rows(1, "mesh", "uvs", values.uvs, 2)
  local colours = values.colours ~= nil and array.rows(1, "mesh", "colours", values.colours, 3)
  return core.mesh_from(vertices, triangles, normals or nil, uvs or nil, colours or nil, values.crease or 180)
end

--- The parts of an OBJ file that names materials, { mesh =, material =, emission = }, and the set of these; nothing where it
-- names no library; or nil, message, code.
local function parts_of_file(values, libraries, groups, fail)
  if #libraries == 0 then return nil end
  local set, message, code = mtl.open(libraries, values.file)
  if not set then return nil, message, code end
  local parts = {}
  for i, group in ipairs(set.known and groups or { {} }) do
    local found = {}
    if group.name then
      found, message, code = set:find(group.name, group.line, fail)
      if not found then return nil, message, code end
    end
    parts[i] = { mesh = group.mesh, name = group.name, material = found.material, emission = found.emission }
  end
  set:finish()
  return parts, set
end

local CREASE = 40 -- degrees, of files

--- Reads a file: its mesh, and what parts_of_file returns, unless the scene gives the material; or nil, message, code.
local function mesh_of_file(values, fail)
  local mesh, libraries, groups = core.mesh_read_parts(values.file, form.budget and form.budget "file_size" or 0,
    values.crease or CREASE)
  if not mesh then return nil, libraries, groups end
  if values.material or not libraries then return mesh end
  local parts, set, code = parts_of_file(values, libraries, groups, fail)
  if not parts and set then return nil, set, code end
  return mesh, parts, set
end

shape("mesh", {
  shelf = "everyday",
  about = "Triangles from an OBJ or PLY file, or from arrays. Normals are computed where there are none. Of an OBJ file that "
    .. "names materials (mtllib, usemtl) parts is a list of geometry, one for each, emitters are the parts that emit, which "
    .. "scenes turn into polygon lights, and notes says what was not read; material = overrules all of it.",
  fields = {
    { "file", "string", optional = true, about = ".obj or .ply, recognised by content" },
    { "vertices", "any", optional = true, unit = "scene units", about = "[n][3], with triangles, instead of file" },
    { "triangles", "any", optional = true, about = "[m][3] one-based indices of vertices" },
    { "normals", "any", optional = true, about = "[n][3]" },
    { "uvs", "any", optional = true, about = "[n][2], texture coordinates: u to the right, v upwards" },
    { "crease", "number", optional = true, min = 0, max = 180, unit = "degrees", about = "where normals are computed: triangles "
      .. "that meet at a larger angle have an edge, whose vertices are split; 180: smooth everywhere. Default: 40 of files, "
      .. "whose smoothing groups go before it, 180 of arrays, whose vertices stay as they are" },
    { "colours", "any", optional = true, about = "[n][3], linear, 0 to 1: they multiply what the material reflects" },
  },
  triangles = function(v) return type(v.triangles) == "table" and #v.triangles or 0 end,
  make = function(values, fail)
    if values.file then
      if values.vertices or values.triangles then return fail "give file, or vertices and triangles, not both" end
      if #values.file == 0 or values.file:find("%z") then return fail "file must be a file name" end
      return mesh_of_file(values, fail)
    end
    if not (values.vertices and values.triangles) then
      return fail "field 'file' is missing (or vertices and triangles)"
    end
    return mesh_of_arrays(values)
  end,
  example = "mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }",
})

require "ylm.describe".object "mesh" {
  about = "Triangles; #mesh is their number. The geometry that ylm.quad, ylm.mesh ... return has it as its field mesh.",
  fields = {
    { "bounds", "table", "{ {x0, y0, z0}, {x1, y1, z1} }" },
    { "area", "number", "of all triangles" },
  },
}

-- The object: "ylm.mesh" ---------------------------------------------------------------

local methods = core.metatable "ylm.mesh"

local function open(x, name)
  if core.type(x) ~= "ylm.mesh" then
    return check.fail("%s: a mesh expected before the colon, got %s", name, check.describe(x))
  end
  return core.mesh_info(x)
end

methods.__index = function(x, key)
  if key == "bounds" then
    local _, _, lo, hi = open(x, "bounds")
    return { lo, hi }
  elseif key == "area" then return (select(5, open(x, "area"))) end
  return rawget(methods, key)
end

methods.__tostring = function(x)
  local vertices, triangles = core.mesh_info(x)
  return ("ylm.mesh %d vertices, %d triangles"):format(vertices, triangles)
end

methods.__len = function(x) return (select(2, open(x, "#"))) end

local made = "local ball = ylm.sphere { radius = 2, divide = { 8, 4 } }.mesh\n"

describe "mesh:vertices" {
  about = "The vertices' positions, sharing the mesh's memory.",
  arguments = {},
  returns = { { "positions", "array", "float [n][3]" } },
  errors = "raises on what is not a mesh",
  example = made .. "assert(#ball:vertices() == 45 and ball.bounds[2][3] == 2)",
}
function methods.vertices(x)
  open(x, "vertices")
  return (core.mesh_vertices(x))
end

describe "mesh:normals" {
  about = "The vertices' unit normals, sharing the mesh's memory.",
  arguments = {},
  returns = { { "normals", "array", "float [n][3]" } },
  errors = "raises on what is not a mesh",
  example = made .. "assert(ball:normals().shape[2] == 3)",
}
function methods.normals(x)
  open(x, "normals")
  return (core.mesh_normals(x))
end

describe "mesh:uvs" {
  about = "The vertices' texture coordinates, sharing the mesh's memory; nil where there are none.",
  arguments = {},
  returns = { { "uvs", "array", "float [n][2], or nil" } },
  errors = "raises on what is not a mesh",
  example = made .. "assert(ball:uvs().shape[2] == 2)",
}
function methods.uvs(x)
  open(x, "uvs")
  return (core.mesh_uvs(x))
end

describe "mesh:colours" {
  about = "The vertices' colours, linear, sharing the mesh's memory; nil where there are none.",
  arguments = {},
  returns = { { "colours", "array", "float [n][3], or nil" } },
  errors = "raises on what is not a mesh",
  example = [[
local m = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
  colours = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } }
assert(m.mesh:colours():get(2, 2) == 1)]],
}
function methods.colours(x)
  open(x, "colours")
  return (core.mesh_colours(x))
end

describe "mesh:triangles" {
  about = "The triangles as one-based indices of vertices.",
  arguments = {},
  returns = { { "triangles", "array", "int32 [m][3], a copy" } },
  errors = "raises on what is not a mesh",
  example = made .. "assert(#ball:triangles() == #ball)",
}
function methods.triangles(x)
  open(x, "triangles")
  return check.result("triangles", core.mesh_triangles(x))
end

describe "mesh:save" {
  shelf = "everyday",
  about = "Writes the mesh as binary PLY.",
  arguments = { { "path", "string", "ends in .ply" } },
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending; nil, message, code where the file cannot be written",
  example = made .. [[
local name = os.tmpname() .. ".ply"
assert(ball:save(name))
os.remove(name)]],
}
function methods.save(x, path)
  open(x, "save")
  if type(path) ~= "string" or not path:lower():find("%.ply$") or path:find("%z") then
    return check.bad(1, "save", "a file name that ends in .ply expected, got %s", check.describe(path))
  end
  return check.result("save", core.mesh_write(x, path))
end

function methods.unwrap(x, given)
  open(x, "unwrap")
  return unwrap.unwrap(x, given)
end

memory.publish(methods)

return geometry
