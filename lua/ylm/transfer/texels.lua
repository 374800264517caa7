--- The middles of a lightmap's texels on a mesh: places, normals and areas, by its texture coordinates.

local check = require "ylm.check"
local core = require "ylm.c.core"
local vector = require "ylm.vector"

local texels = {}

local minus = vector.minus

--- Calls visit(column, row, u, v) for texels whose middles are in a triangle of corners x, y in texels; u, v: weights of its
-- second and third corner.
local function inside(x, y, w, h, visit)
  local area = (x[2] - x[1]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[1])
  if area == 0 or area ~= area then return end
  local function span(c, n)
    return math.max(1, math.ceil(math.min(c[1], c[2], c[3]) + 0.5)), math.min(n, math.floor(math.max(c[1], c[2], c[3]) + 0.5))
  end
  local left, right = span(x, w)
  local top, bottom = span(y, h)
  for row = top, bottom do
    for column = left, right do
      local a, b = column - 0.5 - x[1], row - 0.5 - y[1]
      local u, v = (a * (y[3] - y[1]) - (x[3] - x[1]) * b) / area, ((x[2] - x[1]) * b - a * (y[2] - y[1])) / area
      if u >= 0 and v >= 0 and u + v <= 1 then visit(column, row, u, v) end
    end
  end
end

--- Points, normals, areas and numbers (from 1, row by row from the top) of the texels of mesh `number` of a scene, w x h of them;
-- each texel once. `back`: of its back.
function texels.of(scene, number, w, h, back)
  local g = scene.geometry[number]
  local uvs = g and core.mesh_uvs(g.mesh)
  if not uvs then return check.fail("receivers: mesh = %d with size wants texture coordinates (uvs), and has none", number) end
  local vertices, triangles = core.array_totable(g.mesh:vertices()), core.array_totable(g.mesh:triangles())
  local at, found, points, normals, areas, numbers = core.array_totable(uvs), {}, {}, {}, {}, {}
  for _, t in ipairs(triangles) do
    local p, x, y = { vertices[t[1]], vertices[t[2]], vertices[t[3]] }, {}, {}
    for k = 1, 3 do x[k], y[k] = at[t[k]][1] * w, (1 - at[t[k]][2]) * h end
    local cross = vector.cross(minus(p[2], p[1]), minus(p[3], p[1]))
    local length = vector.length(cross)
    local across = math.abs((x[2] - x[1]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[1]))
    if length > 0 and across > 0 then
      local sign = (back and -1 or 1) / length
      inside(x, y, w, h, function(column, row, u, v)
        local i = (row - 1) * w + column
        if found[i] then return end
        found[i] = true
        local n, place = #points + 1, {}
        for a = 1, 3 do place[a] = (1 - u - v) * p[1][a] + u * p[2][a] + v * p[3][a] end
        points[n], normals[n] = place, { sign * cross[1], sign * cross[2], sign * cross[3] }
        areas[n], numbers[n] = length / across, i
      end)
    end
  end
  if #points == 0 then return check.fail("receivers: no texel of %d x %d has its middle on mesh %d", w, h, number) end
  return points, normals, areas, numbers
end

return texels
