--- Triangle lights of the examples on Mezieres et al. 2022: loaded with dofile by gradient_2022_triangles.lua and
-- gradient_2022_table4.lua.

local ylm = require "ylm"

local triangles = {}

--- 2 nx ny triangles of a square; place(s, t), from 0 to 1, is its surface.
function triangles.cut(nx, ny, place)
  local list = {}
  for i = 0, nx - 1 do
    for j = 0, ny - 1 do
      local function p(a, b) return place((i + a) / nx, (j + b) / ny) end
      list[#list + 1] = { p(0, 0), p(1, 0), p(0, 1) }
      list[#list + 1] = { p(1, 0), p(1, 1), p(0, 1) }
    end
  end
  return list
end

--- The sphere that replaces a triangle: its centroid and area.
local function bare(v, radiance)
  local at, u, w = {}, {}, {}
  for a = 1, 3 do
    at[a] = (v[1][a] + v[2][a] + v[3][a]) / 3
    u[a], w[a] = v[2][a] - v[1][a], v[3][a] - v[1][a]
  end
  local n = { u[2] * w[3] - u[3] * w[2], u[3] * w[1] - u[1] * w[3], u[1] * w[2] - u[2] * w[1] }
  local area = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2) / 2
  return ylm.sphere_light { at = at, radius = math.sqrt(area / math.pi), radiance = radiance }
end

--- Lights for a list of triangles: "exact", "sphere" (times |cos gamma|, Eq. 26) or "bare" (the sphere alone).
function triangles.lights(list, method, radiance)
  local out = {}
  for i, v in ipairs(list) do
    out[i] = method == "bare" and bare(v, radiance)
      or ylm.polygon_light { vertices = v, method = method, radiance = radiance }
  end
  return out
end

--- A triangle of this area, `stretch` times as long as that of two equal sides, level and above (x, y, z).
function triangles.stretched(area, stretch, x, y, z)
  local h = math.sqrt(2 * area / stretch)
  return { { x - h * stretch / 2, y, z }, { x + h * stretch / 2, y, z }, { x, y, z + h } }
end

--- An equilateral triangle, level, its edge at z.
function triangles.equilateral(edge, x, y, z)
  return { { x - edge / 2, y, z }, { x + edge / 2, y, z }, { x, y, z + edge * math.sqrt(3) / 2 } }
end

return triangles
