--- Random numbers in 0 .. 1, equal under every Lua, and points made of them.

local ylm = require "ylm"

local random = {}

--- Park and Miller's generator, from its seed as it is.
function random.minimal(seed)
  local x = seed % 2147483647
  return function()
    x = x * 16807 % 2147483647
    return x / 2147483647
  end
end

--- Park and Miller's generator with their later multiplier; the seed is spread first, so that small ones serve.
function random.spread(seed)
  local state = seed * 7919 % 2147483647
  return function()
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
end

--- n points {x, y, z} in a cube of the given edge about the origin, by random.spread.
function random.points(n, edge, seed)
  local next, points = random.spread(seed), {}
  for i = 1, n do points[i] = { (next() - 0.5) * edge, (next() - 0.5) * edge, (next() - 0.5) * edge } end
  return points
end

--- n points in the box from lo to hi as a double array, by random.minimal.
function random.points_in(n, lo, hi, seed)
  local r, t = random.minimal(seed), {}
  for i = 1, n do
    t[i] = { lo[1] + (hi[1] - lo[1]) * r(), lo[2] + (hi[2] - lo[2]) * r(), lo[3] + (hi[3] - lo[3]) * r() }
  end
  return ylm.array(t, "double")
end

return random
