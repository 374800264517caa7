--- A wall of one quad, and light that jumps there: fields for grids of shadowed light.

local ylm = require "ylm"

local walls = {}

walls.box = { { -1.1, -1.1, -1 }, { 1.1, 1.1, 1.2 } }
walls.height = 0.03
walls.dark = 0.1 -- light below the wall, as a part of that without it
walls.lamp = ylm.sphere_light { at = { 0.2, 0.1, 1.3 }, radius = 0.1, radiance = { 10, 8, 6 } }

--- The light of a lamp, above the wall; a part of it below.
function walls.field(points, lmax, channels)
  local L, dL, _, report = ylm.light_field(lmax, walls.lamp, points, { derivatives = 1, metric = "luminance",
    channels = channels == 3 and "rgb" or "luminance" })
  local n = #points
  local weight = points[{ {}, { 3, 3 } }]:less(walls.height) * (walls.dark - 1) + 1
  return L * weight:reshape { n, 1, 1 }, dL * weight:reshape { n, 1, 1, 1 }, report.lambda * weight:reshape { n }
end

--- n x n points of the wall with normals, of its sides in turn.
function walls.points(n)
  local rows = {}
  for i = 1, n do
    for j = 1, n do
      rows[#rows + 1] = { 2 * (i - 0.49) / n - 1, 2 * (j - 0.49) / n - 1, walls.height, 0, 0, (i + j) % 2 * 2 - 1 }
    end
  end
  return rows
end

--- A linear field of degree 0, and its value at a point.
function walls.linear_at(p) return 2 + 0.5 * p[1] - 0.25 * p[2] + p[3] end

function walls.linear(points)
  local L, dL = ylm.zeros({ #points, 1, 1 }, points.dtype), ylm.zeros({ #points, 1, 1, 3 }, points.dtype)
  for i = 1, #points do
    L[i][1][1] = walls.linear_at(points[i])
    dL[i][1][1][1], dL[i][1][1][2], dL[i][1][1][3] = 0.5, -0.25, 1
  end
  return L, dL
end

return walls
