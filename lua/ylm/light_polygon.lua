--- Lights that are no spheres: ylm.polygon_light, ylm.disk_light, ylm.textured_light.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"

local polygon = {}

local pi = math.pi

--- A list of three or more points from a table or an array; nil if it is none.
local function points_of(value)
  if core.type(value) == "ylm.array" then
    local shape, _, _, is_open = core.array_info(value)
    if not is_open or #shape ~= 2 or shape[2] ~= 3 then return nil end
    value = core.array_totable(value)
  end
  if type(value) ~= "table" or #value < 3 then return nil end
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

--- What rays see of flat lights: triangles [t][9], disks [d][7], radiances [t+d][3], double arrays.
function polygon.patches(lights)
  local triangles, disks, radiances, later = {}, {}, {}, {}
  for _, l in ipairs(lights) do
    local v = l.vertices
    for i = 2, v and #v - 1 or 0 do
      local t = {}
      for _, p in ipairs { v[1], v[i], v[i + 1] } do for k = 1, 3 do t[#t + 1] = p[k] end end
      triangles[#triangles + 1] = t
      radiances[#radiances + 1] = l.radiance
    end
    if not v then
      local n = l.normal
      local length = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
      disks[#disks + 1] = { l.at[1], l.at[2], l.at[3], l.radius, n[1] / length, n[2] / length, n[3] / length }
      later[#later + 1] = l.radiance
    end
  end
  for _, c in ipairs(later) do radiances[#radiances + 1] = c end
  local function pack_rows(rows, width)
    local a = assert(core.array_zeros({ #rows, width }, "double"))
    if #rows > 0 then core.array_fill(a, rows) end
    return a
  end
  return pack_rows(triangles, 9), pack_rows(disks, 7), pack_rows(radiances, 3)
end

polygon.polygon_light = form.define("polygon_light", {
  about = "A planar convex polygon that emits the same radiance to both sides.",
  fields = {
    { "vertices", "any", unit = "scene units",
      about = "3 to 64 points in order, in one plane: a list or an array [n][3]" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2", about = "number or {r, g, b}; may be negative" },
    method_field,
    { "horizon", "vector", optional = true,
      about = "cut off what lies below the plane across it through each shading point" },
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
  local length = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
  local x, y, z = n[1] / length, n[2] / length, n[3] / length
  local s = z < 0 and -1 or 1
  local a = -1 / (s + z)
  local b = x * y * a
  return { 1 + s * x * x * a, s * b, -s * x }, { b, s + y * y * a, -y }
end

polygon.disk_light = form.define("disk_light", {
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

-- Textures -----------------------------------------------------------------------------------

--- Splits texels x0 .. x1, y0 .. y1 (one-based) until each part is of one colour to the tolerance, and at most
-- `wide` by `high` texels.
local function merge(texels, x0, y0, x1, y1, tolerance, wide, high, emit)
  local sum, n, lo, hi = { 0, 0, 0 }, 0, { 1e300, 1e300, 1e300 }, { -1e300, -1e300, -1e300 }
  for y = y0, y1 do
    for x = x0, x1 do
      local t = texels[y][x]
      n = n + 1
      for c = 1, 3 do
        local v = t[c] or t[1]
        sum[c] = sum[c] + v
        lo[c], hi[c] = math.min(lo[c], v), math.max(hi[c], v)
      end
    end
  end
  local spread = math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3])
  -- parts of strange proportions would make bad spheres
  local long = math.max((x1 - x0 + 1) / (y1 - y0 + 1), (y1 - y0 + 1) / (x1 - x0 + 1))
  local small = x1 - x0 + 1 <= wide and y1 - y0 + 1 <= high
  if (spread <= tolerance and long <= 2 and small) or n == 1 then
    return emit(x0, y0, x1, y1, { sum[1] / n, sum[2] / n, sum[3] / n })
  end
  local mx, my = math.floor((x0 + x1) / 2), math.floor((y0 + y1) / 2)
  local split_x, split_y = x1 > x0 and (x1 - x0) * 2 >= y1 - y0, y1 > y0 and (y1 - y0) * 2 >= x1 - x0
  merge(texels, x0, y0, split_x and mx or x1, split_y and my or y1, tolerance, wide, high, emit)
  if split_x then merge(texels, mx + 1, y0, x1, split_y and my or y1, tolerance, wide, high, emit) end
  if split_y then merge(texels, x0, my + 1, split_x and mx or x1, y1, tolerance, wide, high, emit) end
  if split_x and split_y then merge(texels, mx + 1, my + 1, x1, y1, tolerance, wide, high, emit) end
end

polygon.textured_light = form.define("textured_light", {
  about = "A parallelogram with an image, as spheres: one for each texel, or for each group of similar texels (a quadtree).",
  fields = {
    { "corner", "point", unit = "scene units", about = "the image's bottom left" },
    { "u", "vector", unit = "scene units", about = "to its bottom right" },
    { "v", "vector", unit = "scene units", about = "to its top left" },
    { "image", "object", of = "ylm.image", about = "its first layer is radiance" },
    { "scale", "number", default = 1, about = "multiplies the image" },
    { "tolerance", "number", min = 0, default = 0,
      about = "texels this near in every channel, times the largest value, "
      .. "become one; 0 merges equal ones only" },
    { "largest", "number", above = 0, max = 1, default = 1 / 8,
      about = "most of the image's width and height that one sphere may stand for: a large sphere is near in front "
      .. "of the image, and wrong there" },
  },
  build = function(values, fail)
    local layer = values.image:layer()
    local texels, shape = core.array_totable(layer), core.array_info(layer)
    local h, w = shape[1], shape[2]
    if w * h > 2 ^ 22 then return fail(("image must have at most 2^22 texels, got %dx%d"):format(w, h)) end
    local finite = core.array_finite(layer)
    if not finite then return fail("image must be finite") end
    if #shape == 2 or shape[3] == 1 then
      for _, row in ipairs(texels) do
        for x, t in ipairs(row) do row[x] = type(t) == "table" and t or { t } end
      end
    end
    local u, v, corner = values.u, values.v, values.corner
    local nx, ny, nz = u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1]
    local area = math.sqrt(nx * nx + ny * ny + nz * nz)
    if area == 0 then return fail("u and v must not be parallel") end
    local largest = 0
    for _, row in ipairs(texels) do
      for _, t in ipairs(row) do for c = 1, #t do largest = math.max(largest, math.abs(t[c])) end end
    end
    local at, radius, radiance = {}, {}, {}
    local wide, high = math.max(1, values.largest * w), math.max(1, values.largest * h)
    merge(texels, 1, 1, w, h, values.tolerance * largest, wide, high, function(x0, y0, x1, y1, colour)
      if colour[1] == 0 and colour[2] == 0 and colour[3] == 0 then return end
      local s, t = (x0 - 1 + x1) / (2 * w), 1 - (y0 - 1 + y1) / (2 * h)
      local k = #at + 1
      at[k] = { corner[1] + s * u[1] + t * v[1], corner[2] + s * u[2] + t * v[2], corner[3] + s * u[3] + t * v[3] }
      radius[k] = math.sqrt(area * (x1 - x0 + 1) * (y1 - y0 + 1) / (w * h) / pi)
      radiance[k] = { colour[1] * values.scale, colour[2] * values.scale, colour[3] * values.scale }
    end)
    if #at == 0 then return fail("the image is black") end
    return require("ylm.light").sphere_lights { at = at, radius = radius, radiance = radiance }
  end,
  example = [[
(function()
  local image = ylm.image { size = { 4, 2 }, layers = { { "radiance", 3 } } }
  image:fill(1, 1, 4, 2, { 1, 2, 3 })
  local lights = ylm.textured_light { corner = { 0, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 1, 0 }, image = image, largest = 1 }
  assert(lights.count == 1)
  return lights
end)()]],
})

return polygon
