--- Tools of the specs of grids: a box, lamps, shading points, analytic fields, and errors of rows.

local core = require "ylm.c.core"
local ylm = require "ylm"
local random = require "spec.support.random".minimal

local grids = {}

grids.seed = 20251121
grids.box = { { -1, -1, -1 }, { 1, 1, 1 } }

--- Sorted relative errors |a_i - b_i| / |b_i| of rows.
function grids.errors(a, b)
  local e = {}
  for i = 1, #a do
    local _, d, norm = core.array_distance(a[i], b[i])
    e[i] = d / norm
  end
  table.sort(e)
  return e
end

--- The value that a part q of sorted numbers does not exceed.
function grids.quantile(sorted, q) return sorted[math.ceil(q * #sorted)] end

--- An analytic field from f(x, y, z) -> value, dx, dy, dz of its first coefficient (others are 0).
function grids.analytic(f, lambda)
  return function(points, lmax, channels)
    local n, count = #points, (lmax + 1) ^ 2
    local value, gradient = ylm.zeros { n, channels, count }, ylm.zeros { n, channels, count, 3 }
    local metric = ylm.zeros { n }
    for i = 1, n do
      local v, dx, dy, dz = f(points:get(i, 1), points:get(i, 2), points:get(i, 3))
      for c = 1, channels do
        value:set(i, c, 1, v)
        gradient:set(i, c, 1, 1, dx)
        gradient:set(i, c, 1, 2, dy)
        gradient:set(i, c, 1, 3, dz)
      end
      metric[i] = lambda and lambda(points:get(i, 1), points:get(i, 2), points:get(i, 3)) or 0
    end
    return value, gradient, metric
  end
end

grids.lamp = ylm.sphere_light { at = { 0.1, 0.3, 0.2 }, radius = 0.1, radiance = { 10, 8, 6 } }
grids.lamps = {
  ylm.sphere_light { at = { 0.1, 0.2, 0.2 }, radius = 0.05, radiance = { 10, 8, 6 } },
  ylm.sphere_light { at = { -0.7, 0.1, -0.5 }, radius = 0.05, radiance = { 2, 8, 20 } },
  ylm.sphere_light { at = { 0.5, 3, -2 }, radius = 0.5, radiance = 4 },
}

--- n pairs of points on the two sides of faces between voxels of different levels: two double arrays [n][3]. Raises
--- where an adaptive grid has too few of them.
function grids.across(grid, n, seed)
  local cells, r, eps = grid:cells(), random(seed), 2 ^ -40
  local low, high, tries = {}, {}, 0
  while #low < n do
    tries = tries + 1
    assert(tries < 4e6, "hardly any voxels of different levels meet")
    local i = math.floor(r() * #cells.level) + 1
    if cells.leaf[i] == 1 then
      local axis = math.floor(r() * 3) + 1
      local p, q = {}, {}
      for a = 1, 3 do
        p[a] = cells.origin:get(i, a) + cells.size:get(i, a) * r()
        q[a] = p[a]
      end
      local side = cells.origin:get(i, axis)
      p[axis], q[axis] = side + eps, side - eps
      if side > -1 and grid:locate(q).level ~= cells.level[i] then low[#low + 1], high[#high + 1] = q, p end
    end
  end
  return ylm.array(low, "double"), ylm.array(high, "double")
end

--- Shading points on a floor and on a ball.
function grids.shading_points(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do
    if i % 3 > 0 then t[i] = { 2 * r() - 1, 0.013, 2 * r() - 1 }
    else
      local z, phi = 2 * r() - 1, 2 * math.pi * r()
      local s = math.sqrt(1 - z * z)
      t[i] = { 0.4 * s * math.cos(phi) - 0.3, 0.45 + 0.4 * s * math.sin(phi), 0.4 * z + 0.3 }
    end
  end
  return ylm.array(t, "double")
end

grids.occupied = grids.shading_points(6000, grids.seed)

return grids
