--- Materials as shapes, to be drawn: lobes as meshes, slices as curves.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local object = require "ylm.material.object"
local vector = require "ylm.vector"

local methods = object.methods

local function open(name, m)
  if not object.is(m) then return check.fail("%s: a material expected before the colon, got %s", name, check.describe(m)) end
  return object.made(name, m)
end

local view_options = {
  { "angle", "number", min = 0, max = 90, default = 45, unit = "degrees", about = "of the direction that light leaves to, from "
    .. "the normal" },
  { "azimuth", "number", min = -360, max = 360, default = 0, unit = "degrees", about = "of that direction, from the tangent" },
  { "cosine", "boolean", default = true, about = "f wi.z, the light that a direction brings; else f" },
}

--- The direction of a view.
local function view_of(o)
  local angle, turn = math.rad(o.angle), math.rad(o.azimuth)
  return { math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn), math.max(math.cos(angle), 1e-6) }
end

--- Values [n] of { r, g, b } at a list of directions; nil, message, code.
local function values_at(name, made, list, o)
  local f, message, code = check.result(name, core.material_eval(made, array.array(list), array.array { view_of(o) }))
  if not f then return nil, message, code end
  local out = core.array_totable(f)
  for i, d in ipairs(list) do
    if o.cosine then for c = 1, 3 do out[i][c] = out[i][c] * math.max(0, d[3]) end end
  end
  return out
end

local slice_options = { { "count", "integer", min = 2, max = 100000, default = 361, about = "points of the curve" } }
for _, option in ipairs(view_options) do slice_options[#slice_options + 1] = option end

describe "material:slice" {
  about = "The reflectance in the plane of the normal and of a direction that light leaves to: a curve for ylm.plot.",
  arguments = { { "options?", "table", "" } },
  options = slice_options,
  returns = { { "angles", "array", "[count], degrees: of where light comes from, -90 to 90; the mirror direction is at -angle" },
    { "values", "array", "[count][3], sr^-1" } },
  errors = "raises on a bad option; nil, message, code: memory",
  example = [[
local angles, values = ylm.ggx { alpha = 0.2 }:slice { angle = 30, count = 181 }
assert(angles:get(1) == -90 and values:get(61, 1) > values:get(121, 1))]],
}
function methods.slice(m, given)
  local made, message, code = open("slice", m)
  if not made then return nil, message, code end
  local o = form.options(1, "slice", slice_options, given)
  local angles, list, turn = {}, {}, math.rad(o.azimuth)
  for i = 1, o.count do
    angles[i] = -90 + 180 * (i - 1) / (o.count - 1)
    local s, z = math.sin(math.rad(angles[i])), math.cos(math.rad(angles[i]))
    list[i] = { s * math.cos(turn), s * math.sin(turn), z }
  end
  local values
  values, message, code = values_at("slice", made, list, o)
  if not values then return nil, message, code end
  return array.array(angles), array.array(values)
end

local lobe_options = {
  { "divide", "integer", min = 8, max = 500, default = 80, about = "rows of directions about the mirror direction" },
  { "scale", "number", above = 0, optional = true, about = "length per sr^-1; default: the largest value is 1 long" },
}
for _, option in ipairs(view_options) do lobe_options[#lobe_options + 1] = option end

--- Directions about the mirror direction of a view, rows close together near it: list, columns a row.
local function around_mirror(o)
  local v, columns, list = view_of(o), 2 * o.divide, {}
  local axis = { -v[1], -v[2], v[3] }
  local across = math.abs(axis[3]) < 0.9 and { 0, 0, 1 } or { 1, 0, 0 }
  local a = vector.unit(vector.cross(across, axis))
  local b = vector.cross(axis, a)
  for i = 0, o.divide do
    local polar = math.pi * (i / o.divide) ^ 2
    local s, z = math.sin(polar), math.cos(polar)
    for k = 0, columns - 1 do
      local x, y = s * math.cos(2 * math.pi * k / columns), s * math.sin(2 * math.pi * k / columns)
      local d = {}
      for c = 1, 3 do d[c] = x * a[c] + y * b[c] + z * axis[c] end
      list[#list + 1] = d
    end
  end
  return list, columns
end

--- Triangles of a closed strip of rows of vertices, from 1.
local function strips(rows, columns)
  local list = {}
  for i = 0, rows - 1 do
    for k = 0, columns - 1 do
      local a, b = i * columns + k + 1, i * columns + (k + 1) % columns + 1
      list[#list + 1] = { a, a + columns, b }
      list[#list + 1] = { b, a + columns, b + columns }
    end
  end
  return list
end

--- Unit normals of vertices, of the triangles about them.
local function normals_of(vertices, triangles)
  local list = {}
  for i = 1, #vertices do list[i] = { 0, 0, 0 } end
  for _, t in ipairs(triangles) do
    local p, q, r = vertices[t[1]], vertices[t[2]], vertices[t[3]]
    local n = vector.cross({ q[1] - p[1], q[2] - p[2], q[3] - p[3] }, { r[1] - p[1], r[2] - p[2], r[3] - p[3] })
    for _, v in ipairs(t) do for c = 1, 3 do list[v][c] = list[v][c] + n[c] end end
  end
  for _, n in ipairs(list) do
    local length = vector.length(n)
    if length == 0 then n[3] = 1 else for c = 1, 3 do n[c] = n[c] / length end end
  end
  return list
end

describe "material:lobe" {
  about = "The reflectance as a mesh for ylm.view: a vertex stands in each direction that light comes from, as far from the "
    .. "origin as the luminance of f wi.z is large. z is the surface's normal, x its tangent.",
  arguments = { { "options?", "table", "" } },
  options = lobe_options,
  returns = { { "mesh", "mesh", "" } },
  errors = "raises on a bad option; nil, message, code: memory",
  example = [[
local lobe = ylm.ggx { alpha = 0.3 }:lobe { angle = 0 }
assert(math.abs(lobe.bounds[2][3] - 1) < 1e-3)]],
}
function methods.lobe(m, given)
  local made, message, code = open("lobe", m)
  if not made then return nil, message, code end
  local o = form.options(1, "lobe", lobe_options, given)
  local list, columns = around_mirror(o)
  local largest, values = 0
  values, message, code = values_at("lobe", made, list, o)
  if not values then return nil, message, code end
  for i, v in ipairs(values) do
    values[i] = vector.luminance(v)
    largest = math.max(largest, values[i])
  end
  local scale = o.scale or largest > 0 and 1 / largest or 1
  for i, d in ipairs(list) do for c = 1, 3 do d[c] = d[c] * values[i] * scale end end
  local triangles = strips(o.divide, columns)
  return check.result("lobe", core.mesh_from(array.array(list), array.array(triangles), array.array(normals_of(list, triangles))))
end

return methods
