--- Flat lights of one radiance: ylm.polygon_light, ylm.disk_light.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local pack = require "ylm.light.pack"
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

--- The corners of a flat light: of a disk 64 on its rim.
local function outline(l)
  if l.vertices then return l.vertices end
  local c, u, v, rim = l.axes[1], l.axes[2], l.axes[3], {}
  for i = 1, 64 do
    local a, b = math.cos(math.pi * i / 32), math.sin(math.pi * i / 32)
    rim[i] = { c[1] + a * u[1] + b * v[1], c[2] + a * u[2] + b * v[2], c[3] + a * u[3] + b * v[3] }
  end
  return rim
end

--- How polygons and disks become records of csrc/light/flat/kind.c, disks with spread of lobe.c.
local as_light = {
  photometric = true,
  kind = function(l)
    if (l.spread or 0) > 0 then return "lobe" end
    return l.method == "exact" and "polygon" or "polygon_as_sphere"
  end,
  record = function(l, out)
    local h = l.horizon or { 0, 0, 0 }
    pack.append(out, l.radiance, h)
    out[#out + 1] = l.vertices and #l.vertices or 0
    for _, v in ipairs(l.vertices or l.axes) do pack.append(out, v) end
    if (l.spread or 0) > 0 then out[#out + 1] = l.spread end
  end,
  outline = outline,
  gltf = function(w, l)
    if (l.spread or 0) > 0 then w:leave_out "spread of disks, in extras.ylm, which other programs do not read" end
    w:flat(l, outline(l))
  end,
}

polygon.polygon_light = form.define("polygon_light", {
  shelf = "everyday",
  numbers = 256,
  about = "A planar convex polygon that emits the same radiance to both sides.",
  fields = {
    { "vertices", "any", unit = "scene units",
      about = "3 to " .. check.limit_text(core.limits.polygon_vertices)
        .. " points in order, in one plane: a list or an array [n][3]" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2", about = "number or {r, g, b}; may be negative" },
    method_field,
    { "horizon", "vector", optional = true,
      about = "cut off what lies below the plane across it through each shading point, in light fields and for rays "
        .. "(pictures show the whole)" },
    pack.photometric,
  },
  build = function(values, fail)
    local vertices = points_of(values.vertices)
    if not vertices then
      return fail(("vertices must be three or more points {x, y, z}, got %s"):format(check.describe(values.vertices)))
    end
    values.vertices = vertices
    return pack.finish("polygon_light", values, fail)
  end,
  light = as_light,
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
  shelf = "everyday",
  numbers = 256,
  about = "A disk that emits the same radiance to both sides, or with spread more of it along its normal. With spread it has no "
    .. "light field: rays find its light, in scene:render, raycast and pathtrace; radiosity and scene:virtual_lights bounce it.",
  fields = {
    { "at", "point", unit = "scene units", about = "centre" },
    { "normal", "vector", about = "across the disk" },
    { "radius", "number", above = 0, max = core.limits.extent, default = 0.1, unit = "scene units" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2",
      about = "number or {r, g, b}; may be negative; with spread that along the normal" },
    { "spread", "number", min = 0, max = 1000, default = 0,
      about = "n: the radiance is multiplied by cos^n of the angle to the normal, on both sides; 0: the same in all directions" },
    { "method", "choice", of = { "exact", "sphere" }, default = "exact",
      about = "exact: integrals along the rim, to 1e-12 (no closed form off the axis); sphere: as of polygon_light" },
    { "horizon", "vector", optional = true, about = "as of polygon_light" },
    pack.photometric,
  },
  build = function(values, fail)
    if values.spread > 0 and values.method ~= "exact" then
      return fail "method is of light fields, and with spread there is none"
    end
    local u, v = polygon.frame(values.normal)
    local r = values.radius
    values.axes = { values.at, { r * u[1], r * u[2], r * u[3] }, { r * v[1], r * v[2], r * v[3] } }
    return pack.finish("disk_light", values, fail)
  end,
  light = as_light,
  example = "disk_light { at = {0, 2, 0}, normal = {0, -1, 0}, radius = 0.3, radiance = 20 }",
})

return polygon
