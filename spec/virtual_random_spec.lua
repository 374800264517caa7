-- Virtual lights by 200 seeds: any lights at any points add up, turn with the scene, and go with the square of its size.

local random = require "spec.support.random"
local with = require "spec.support.with"
local ylm = require "ylm"

local SEEDS, LMAX, POINTS = 200, 4, 3
local SIZE = POINTS * 3 * (LMAX + 1) ^ 2
local profiles = { "gauss", "cap", "point" }

--- A direction, of length 1.
local function direction(next)
  local z, t = 2 * next() - 1, 2 * math.pi * next()
  local r = math.sqrt(1 - z * z)
  return { r * math.cos(t), r * math.sin(t), z }
end

--- Some lights of one profile and degree, and points, by a seed.
local function case(seed)
  local next = random.spread(seed)
  local n, degree = 1 + math.floor(3 * next()), math.floor(4 * next())
  local l = { at = {}, normal = {}, radius = {}, shift = {}, emission = {}, profile = profiles[1 + math.floor(3 * next())] }
  for i = 1, n do
    l.at[i] = { next() - 0.5, next() - 0.5, next() - 0.5 }
    l.normal[i] = next() < 0.2 and { 0, 0, 0 } or direction(next)
    l.radius[i], l.shift[i] = 0.05 + 0.4 * next(), next() < 0.5 and 0 or next()
    l.emission[i] = {}
    for c = 1, 3 do
      l.emission[i][c] = {}
      for k = 1, (degree + 1) ^ 2 do l.emission[i][c][k] = next() - 0.3 end
    end
  end
  local points = {}
  for i = 1, POINTS do points[i] = { 3 * (next() - 0.5), 3 * (next() - 0.5), 3 * (next() - 0.5) } end
  return l, points, next
end

local function field(l, points)
  return ylm.light_field(LMAX, ylm.virtual_lights(l), points, { dtype = "double" })
end

--- Asserts that a = b, relative to the largest number of b; profiles that jump may do so at one place of many.
local function same(a, b, seed, what)
  local x, y, most, off = a:reshape { SIZE }, b:reshape { SIZE }, 0, 0
  for k = 1, SIZE do
    most, off = math.max(most, math.abs(y:get(k))), math.max(off, math.abs(x:get(k) - y:get(k)))
  end
  assert.is_true(off <= 1e-11 * most, ("seed %d, %s: %g of %g"):format(seed, what, off, most))
end

local function times(t, c)
  local out = {}
  for k, v in ipairs(t) do out[k] = type(v) == "table" and times(v, c) or v * c end
  return out
end

describe("any virtual lights", function()
  it("are linear: twice the emission, and one light after the other", function()
    for seed = 1, SEEDS do
      local l, x = case(seed)
      local whole = field(l, x)
      same(field(with(l, { emission = times(l.emission, 2) }), x), whole * 2, seed, "twice")
      local sum
      for i = 1, #l.at do
        local one = field({ at = { l.at[i] }, normal = { l.normal[i] }, radius = l.radius[i], shift = l.shift[i],
          emission = { l.emission[i] }, profile = l.profile }, x)
        sum = sum and sum + one or one
      end
      same(sum, whole, seed, "one by one")
    end
  end)

  it("turn with the scene", function()
    for seed = 1, SEEDS do
      local l, x, next = case(seed)
      local R = ylm.sh.rotation(LMAX, { zyz = { 6 * next(), 3 * next(), 6 * next() } }, { dtype = "double" })
      local m = R.matrix
      local function turn(list)
        local out = {}
        for i, v in ipairs(list) do
          out[i] = {}
          for k = 1, 3 do out[i][k] = m[k][1] * v[1] + m[k][2] * v[2] + m[k][3] * v[3] end
        end
        return out
      end
      local turned = ylm.virtual_lights(with(l, { at = turn(l.at), normal = turn(l.normal),
        emission = ylm.sh.rotate(ylm.array(l.emission, "double"), R) }))
      same(ylm.light_field(LMAX, turned, turn(x), { dtype = "double" }), ylm.sh.rotate(field(l, x), R), seed, "turned")
    end
  end)

  it("go with the square of the scene's size", function()
    for seed = 1, SEEDS do
      local l, x, next = case(seed)
      local c = 2 ^ (8 * next() - 4)
      same(field(with(l, { at = times(l.at, c), radius = times(l.radius, c) }), times(x, c)) * (c * c), field(l, x), seed,
        "size " .. c)
    end
  end)
end)
