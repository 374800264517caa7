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

--- Park and Miller's generator with their later multiplier, from its state.
function random.from(state)
  return function()
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
end

--- random.from; the seed is spread first, so that small ones serve.
function random.spread(seed) return random.from(seed * 7919 % 2147483647) end

--- n points {x, y, z} from `near` to `far` from the origin, by a generator.
function random.around(next, n, near, far)
  local list = {}
  for i = 1, n do
    local z, phi, r = 2 * next() - 1, 2 * math.pi * next(), near + (far - near) * next()
    local s = math.sqrt(1 - z * z)
    list[i] = { r * s * math.cos(phi), r * s * math.sin(phi), r * z }
  end
  return list
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
