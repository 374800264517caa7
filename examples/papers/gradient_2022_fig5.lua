-- Mezieres et al. 2022 (gradient), Fig. 5: gradients of a basis function and of a light's coefficient as
-- pictures, by two ways, and their difference.
--
--     lua examples/papers/gradient_2022_fig5.lua [--out DIR] [--quick]
--
-- (l, m) = (6, 3). Columns are theta, rows phi; r, g, b are the components of the gradient, 0.5 is zero.
-- Top: explicit polynomials against the (theta, phi) recurrences ("Sloan's like"). Bottom: a sphere light at
-- distance 2 of radius 0.5: the analytic form with explicit polynomials against the moments that ylm sums.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick
local size = quick and 32 or 256
local l, m = 6, 3
local index = ylm.sh.index(l, m)

local directions = {}
for y = 1, size do
  for x = 1, size do
    local theta, phi = (x - 0.5) / size * math.pi, (y - 0.5) / size * 2 * math.pi
    directions[#directions + 1] = { math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta) }
  end
end

--- The gradients of coefficient `index` from [n][count][3].
local function pick(dY)
  local list = {}
  for i = 1, size * size do
    list[i] = { dY:get(i, index, 1), dY:get(i, index, 2), dY:get(i, index, 3) }
  end
  return list
end

--- Three numbers a pixel, list[i], as a picture of value(list[i][c]).
local function image_of(list, value, caption)
  local image = ylm.image { size = { size, size }, layers = { { "radiance", 3 } } }
  local layer = image:layer "radiance"
  for y = 1, size do
    for x = 1, size do
      local v = list[(y - 1) * size + x]
      for c = 1, 3 do layer:set(y, x, c, value(v[c])) end
    end
  end
  return { image = image, tone = "linear", caption = caption }
end

--- Saves a, b and 1e15 times their difference beside each other; returns the largest difference.
local function picture(what, a, b, names, scale, name)
  local difference, worst = {}, 0
  for i, p in ipairs(a) do
    difference[i] = {}
    for c = 1, 3 do
      difference[i][c] = math.abs(p[c] - b[i][c])
      worst = math.max(worst, difference[i][c])
    end
  end
  local function shown(x) return 0.5 + x / scale / 2 end
  common.save(ylm.figure {
    title = ("Gradient of %s, (l, m) = (%d, %d)"):format(what, l, m),
    rows = { { image_of(a, shown, names[1]), image_of(b, shown, names[2]),
      image_of(difference, function(x) return 1e15 * x / scale end, "10¹⁵ × |difference|") } },
    caption = ("Across: θ from 0 to π; down: φ from 0 to 2π. Red, green, blue: x, y, z; grey is 0, white and black ±%.3g.")
      :format(scale),
  }, out .. name)
  return worst
end

local _, polynomial = ylm.sh.eval(l, directions, { derivatives = 1, method = "polynomial" })
local _, recurrence = ylm.sh.eval(l, directions, { derivatives = 1, method = "sloan" })
local _, solid = ylm.sh.eval(l, directions, { derivatives = 1 })
local a, b, c = pick(polynomial), pick(recurrence), pick(solid)
local largest = 0
for _, v in ipairs(a) do for k = 1, 3 do largest = math.max(largest, math.abs(v[k])) end end
print(("basis gradient: polynomials and recurrences differ by at most %.1e (picture: 1e15 times); largest component %.2f")
  :format(picture("the basis", a, b, { "explicit polynomials", "(θ, φ) recurrences, Sloan's like" }, largest,
    "gradient_2022_fig5_basis.png"), largest))
local difference = 0
for i, v in ipairs(a) do for k = 1, 3 do difference = math.max(difference, math.abs(v[k] - c[i][k])) end end
print(("basis gradient: polynomials and solid harmonics differ by at most %.1e"):format(difference))

-- The coefficient is F(d) Y(v/d), v the light's place seen from the point: F and F' from the explicit P_6, the basis
-- from its explicit polynomials, put together by the product rule.
local distance, radius = 2, 0.5
local lamp = ylm.sphere_light { at = { 0, 0, 0 }, radius = radius, radiance = 1 }
local h = math.sqrt(distance ^ 2 - radius ^ 2)
local alpha = h / distance
local P = (231 * alpha ^ 6 - 315 * alpha ^ 4 + 105 * alpha ^ 2 - 5) / 16
local dP = (1386 * alpha ^ 5 - 1260 * alpha ^ 3 + 210 * alpha) / 16
local F = 2 * math.pi * radius ^ 2 / distance ^ 2 * dP / (l * (l + 1))
local dF = -2 * math.pi * P * radius ^ 2 / (distance ^ 2 * h)
local points = {}
for i, d in ipairs(directions) do points[i] = { -distance * d[1], -distance * d[2], -distance * d[3] } end
local _, dL = ylm.light_field(l, lamp, points, { derivatives = 1, channels = "luminance", dtype = "double" })
local Y = ylm.sh.eval(l, directions, { method = "polynomial" })
local ours, explicit = {}, {}
for i, d in ipairs(directions) do
  ours[i] = { dL:get(i, 1, index, 1), dL:get(i, 1, index, 2), dL:get(i, 1, index, 3) }
  explicit[i] = {}
  for k = 1, 3 do explicit[i][k] = -(F * a[i][k] / distance + dF * d[k] * Y:get(i, index)) end
end
largest = 0
for _, v in ipairs(ours) do for k = 1, 3 do largest = math.max(largest, math.abs(v[k])) end end
print(("light's gradient: explicit polynomials and moments differ by at most %.1e (picture: 1e15 times); largest %.3f")
  :format(picture("a light's coefficient", explicit, ours, { "explicit polynomials", "moments, as ylm sums" }, largest,
    "gradient_2022_fig5_light.png"), largest))
