--- Flat lights of one radiance: ylm.polygon_light, ylm.disk_light.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local vector = require "ylm.vector"

local polygon = {}

--- More corners than a polygon may have, which says so itself.
local MOST = 1000

--- A list of three or more points from a table or an array; nil if it is none.
local function points_of(value)
  if core.type(value) == "ylm.array" then
    local shape, _, _, is_open = core.array_info(value)
    if not is_open or #shape ~= 2 or shape[2] ~= 3 then return nil end
    value = core.array_totable(value)
  end
  if type(value) ~= "table" or #value < 3 or #value > MOST then return nil end
  local list = {}
  for i, p in ipairs(value) do
    local good = form.types.point(p)
    if not good then return nil end
    list[i] = good
  end
  return list
end

local method_field = { "method", "choice", of = { "exact", "sphere" }, default = "exact",
  about = "exact: integrals along the edges; sphere: a sphere of the same area times |cos gamma|" }

--- The packed object of polygons { vertices, radiance }, all of one method and horizon.
local function pack(name, list, method, horizon, fail)
  local sides, vertices, radiance = {}, {}, {}
  for i, p in ipairs(list) do
    sides[i] = p.vertices and #p.vertices or 0
    for _, v in ipairs(p.vertices or p.axes) do vertices[#vertices + 1] = v end
    radiance[i] = p.radiance
  end
  local v, c = assert(core.array_zeros({ #vertices, 3 }, "double")), assert(core.array_zeros({ #list, 3 }, "double"))
  core.array_fill(v, vertices)
  core.array_fill(c, radiance)
  local h
  if horizon then
    h = assert(core.array_zeros({ 3 }, "double"))
    core.array_fill(h, horizon)
  end
  local object, message, code = core.polygons_create(sides, v, c, method == "exact", h)
  if object then return object end
  if core.status(code) == "caller" then return fail((message:gsub("^polygon 1", "it"))) end
  return check.result(name, nil, message, code)
end

--- Appends to `out` one object for all flat lights of the same method and horizon; message, code on failure.
function polygon.join(name, lights, out)
  local groups, order = {}, {}
  for _, l in ipairs(lights) do
    local h = l.horizon
    local key = h and ("%s %.17g %.17g %.17g"):format(l.method, h[1], h[2], h[3]) or l.method
    if not groups[key] then
      groups[key] = {}
      order[#order + 1] = groups[key]
    end
    table.insert(groups[key], l)
  end
  for _, group in ipairs(order) do
    if #group == 1 then
      out[#out + 1] = group[1].field
    else
      local object, message, code = pack(name, group, group[1].method, group[1].horizon, check.fail)
      if not object then return message, code end
      out[#out + 1] = object
    end
  end
end

local function emission(c, horizon)
  local h = horizon or { 0, 0, 0 }
  return { c[1], c[2], c[3], h[1], h[2], h[3] }
end

--- The surfaces of flat lights that rays see: triangles [t][9], disks [d][7], radiances and horizons (0: none) [t+d][6],
-- double arrays. The last triangles are those of textures, at most `tiles` a side; of textures there is a list too:
-- { texels, {corner, u, v}, scale, triangles }.
function polygon.patches(lights, tiles)
  local triangles, disks, radiances, textured, later = {}, {}, {}, {}, {}
  for _, l in ipairs(lights) do
    if form.kind(l) == "textured_light" then textured[#textured + 1] = l end
  end
  for _, l in ipairs(lights) do
    local v = l.vertices
    for i = 2, v and #v - 1 or 0 do
      local t = {}
      for _, p in ipairs { v[1], v[i], v[i + 1] } do for k = 1, 3 do t[#t + 1] = p[k] end end
      triangles[#triangles + 1] = t
      radiances[#radiances + 1] = emission(l.radiance, l.horizon)
    end
    if form.kind(l) == "disk_light" then
      local n = vector.unit(l.normal)
      disks[#disks + 1] = { l.at[1], l.at[2], l.at[3], l.radius, n[1], n[2], n[3] }
      later[#later + 1] = emission(l.radiance, l.horizon)
    end
  end
  for i, l in ipairs(textured) do
    local corners, means = require("ylm.light.textured").tiles(l, tiles)
    for k, t in ipairs(corners) do
      triangles[#triangles + 1], radiances[#radiances + 1] = t, emission(means[k], l.horizon)
    end
    textured[i] = { l.texels, l.frame, l.scale, #corners }
  end
  for _, c in ipairs(later) do radiances[#radiances + 1] = c end
  local function pack_rows(rows, width)
    local a = assert(core.array_zeros({ #rows, width }, "double"))
    if #rows > 0 then core.array_fill(a, rows) end
    return a
  end
  return pack_rows(triangles, 9), pack_rows(disks, 7), pack_rows(radiances, 6), textured
end

polygon.polygon_light = form.define("polygon_light", {
  numbers = 256,
  about = "A planar convex polygon that emits the same radiance to both sides.",
  fields = {
    { "vertices", "any", unit = "scene units",
      about = "3 to 64 points in order, in one plane: a list or an array [n][3]" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2", about = "number or {r, g, b}; may be negative" },
    method_field,
    { "horizon", "vector", optional = true,
      about = "cut off what lies below the plane across it through each shading point, in light fields and for rays "
        .. "(pictures show the whole)" },
  },
  build = function(values, fail)
    local vertices = points_of(values.vertices)
    if not vertices then
      return fail(("vertices must be three or more points {x, y, z}, got %s"):format(check.describe(values.vertices)))
    end
    values.vertices = vertices
    values.field = pack("polygon_light", { values }, values.method, values.horizon, fail)
    return setmetatable(values, form.defined.polygon_light.metatable)
  end,
  example = "polygon_light { vertices = { {-1, 2, -1}, {1, 2, -1}, {0, 2, 1} }, radiance = {10, 8, 6} }",
})

--- Two unit vectors at right angles to n and to each other.
function polygon.frame(n)
  n = vector.unit(n)
  local x, y, z = n[1], n[2], n[3]
  local s = z < 0 and -1 or 1
  local a = -1 / (s + z)
  local b = x * y * a
  return { 1 + s * x * x * a, s * b, -s * x }, { b, s + y * y * a, -y }
end

polygon.disk_light = form.define("disk_light", {
  numbers = 256,
  about = "A disk that emits the same radiance to both sides.",
  fields = {
    { "at", "point", unit = "scene units", about = "centre" },
    { "normal", "vector", about = "across the disk" },
    { "radius", "number", above = 0, max = 1e15, default = 0.1, unit = "scene units" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2", about = "number or {r, g, b}; may be negative" },
    { "method", "choice", of = { "exact", "sphere" }, default = "exact",
      about = "exact: integrals along the rim, to 1e-12 (no closed form off the axis); sphere: as of polygon_light" },
    { "horizon", "vector", optional = true, about = "as of polygon_light" },
  },
  build = function(values, fail)
    local u, v = polygon.frame(values.normal)
    local r = values.radius
    values.axes = { values.at, { r * u[1], r * u[2], r * u[3] }, { r * v[1], r * v[2], r * v[3] } }
    values.field = pack("disk_light", { values }, values.method, values.horizon, fail)
    return setmetatable(values, form.defined.disk_light.metatable)
  end,
  example = "disk_light { at = {0, 2, 0}, normal = {0, -1, 0}, radius = 0.3, radiance = 20 }",
})

return polygon
