--- Triangles for specs of grids that are baked from surfaces: random points on them, and which boxes they meet, by clipping.

local ylm = require "ylm"
local random = require "spec.support.random".minimal

local surfaces = {}

--- The triangles of a shape or a list of shapes: { { {x, y, z}, {x, y, z}, {x, y, z} }, ... }.
function surfaces.triangles(geometry)
  local list = geometry.mesh and { geometry } or geometry
  local out = {}
  for _, shape in ipairs(list) do
    local vertices = shape.mesh:vertices():totable()
    for _, t in ipairs(shape.mesh:triangles():totable()) do
      out[#out + 1] = { vertices[t[1]], vertices[t[2]], vertices[t[3]] }
    end
  end
  return out
end

local function cross(t)
  local p, q, r, n = t[1], t[2], t[3], {}
  for a = 1, 3 do
    local b, c = a % 3 + 1, (a + 1) % 3 + 1
    n[a] = (q[b] - p[b]) * (r[c] - p[c]) - (q[c] - p[c]) * (r[b] - p[b])
  end
  return n
end

function surfaces.area(t)
  local n = cross(t)
  return math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2) / 2
end

--- n random points on triangles, uniform by area, as a float array, and the triangle of each.
function surfaces.points(triangles, n, seed)
  local sum, all, r, points, which = {}, 0, random(seed), {}, {}
  for i, t in ipairs(triangles) do
    all = all + surfaces.area(t)
    sum[i] = all
  end
  for i = 1, n do
    local u, lo, hi = r() * all, 1, #sum
    while lo < hi do
      local middle = math.floor((lo + hi) / 2)
      if sum[middle] > u then hi = middle else lo = middle + 1 end
    end
    local t, f, g, p = triangles[lo], math.sqrt(r()), r(), {}
    for a = 1, 3 do p[a] = (1 - f) * t[1][a] + f * ((1 - g) * t[2][a] + g * t[3][a]) end
    points[i], which[i] = p, lo
  end
  return ylm.array(points, "float"), which
end

--- The part of a polygon where side * p[axis] <= side * at.
local function cut(polygon, axis, side, at)
  local out = {}
  for i, p in ipairs(polygon) do
    local q = polygon[i % #polygon + 1]
    local here, there = side * (at - p[axis]), side * (at - q[axis])
    if here >= 0 then out[#out + 1] = p end
    if (here >= 0) ~= (there >= 0) then
      local t, x = here / (here - there), {}
      for a = 1, 3 do x[a] = p[a] + t * (q[a] - p[a]) end
      x[axis] = at
      out[#out + 1] = x
    end
  end
  return out
end

--- Whether a triangle meets the box lo .. hi, faces included, by clipping it to the box.
function surfaces.meets(triangle, lo, hi)
  local polygon = triangle
  for axis = 1, 3 do polygon = cut(cut(polygon, axis, 1, hi[axis]), axis, -1, lo[axis]) end
  return #polygon > 0
end

return surfaces
