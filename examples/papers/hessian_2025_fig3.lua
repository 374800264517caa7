-- Iwasaki & Dobashi 2025, Fig. 3: components of the Hessian of SH coefficients of one sphere light on a
-- square. Ours (Eq. 15) stand beside finite differences of the coefficients themselves, and ten times their difference.
--
--     lua examples/papers/hessian_2025_fig3.lua [--out DIR] [--n PIXELS]
--
-- The paper prints "H_2^7" in the second row, which cannot exist (|m| <= l): H_7^2 is meant.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "../common.lua")
local option = common.options { out = "out", n = 256 }
local out, n, lmax = option.out, option.n, 7

local lamp = ylm.sphere_light { at = { 0.2, 1, 0.3 }, radius = 0.4, radiance = 1 }

--- The square from (0.5, 0, 0.5) at the top left to (-0.5, 0, -0.5), moved by `shift`.
local function square(shift)
  local points = {}
  for row = 0, n - 1 do
    for column = 0, n - 1 do
      points[#points + 1] = { 0.5 - column / (n - 1) + shift[1], shift[2], 0.5 - row / (n - 1) + shift[3] }
    end
  end
  return ylm.array(points, "double")
end

--- Coefficient `index` at the shifted square, [n*n].
local function coefficient(index, shift)
  local L = ylm.light_field(lmax, lamp, square(shift), { channels = "luminance", dtype = "double" })
  return L[{ {}, 1, index }]
end

--- Second derivative along axis a (1 to 3) by the five-point formula, error of order step^4.
local function difference(index, a, step)
  local sum = 0
  for k, weight in pairs { [-2] = -1 / 12, [-1] = 4 / 3, [0] = -5 / 2, [1] = 4 / 3, [2] = -1 / 12 } do
    local shift = { 0, 0, 0 }
    shift[a] = k * step
    sum = sum + weight * coefficient(index, shift) / step ^ 2
  end
  return sum
end

--- n*n numbers as rows.
local function rows_of(list) return list:reshape { n, n } end

local _, _, hessians = ylm.light_field(lmax, lamp, square { 0, 0, 0 },
  { derivatives = 2, channels = "luminance", dtype = "double" })

local rows = {}
print(("%-22s %12s %22s %22s"):format("component", "largest", "largest |difference|", "relative to largest"))
for _, case in ipairs {
  { name = "∂²/∂x² of L(6, −3)", l = 6, m = -3, component = 1, axis = 1 },
  { name = "∂²/∂z² of L(7, 2)", l = 7, m = 2, component = 6, axis = 3 },
} do
  local index = ylm.sh.index(case.l, case.m)
  local ours, finite = hessians[{ {}, 1, index, case.component }], difference(index, case.axis, 2e-3)
  local largest = ours:abs():max()
  local wrong = 10 * (ours - finite):abs() / largest
  local worst = wrong:max() * largest / 10
  ours, finite = ours / largest, finite / largest
  print(("%-22s %12.4g %22.3g %22.3g"):format(case.name, largest, worst, worst / largest))
  rows[#rows + 1] = {
    { values = rows_of(ours), caption = case.name .. ", analytic" },
    { values = rows_of(finite), caption = "finite differences of L" },
    { values = rows_of(wrong), caption = ("10 x |difference|, at most %.1e"):format(10 * worst / largest) },
  }
end
common.save(ylm.figure {
  rows = rows,
  bar = { range = { -1, 1 }, map = "coolwarm", label = "normalised by the largest" },
  title = "Hessian of SH coefficients of a sphere light",
  caption = "Sphere light of radius 0.4 at (0.2, 1, 0.3), seen from the square (0.5, 0, 0.5) to (-0.5, 0, -0.5). "
    .. "Finite differences: five points, step 0.002, double.",
}, out .. "hessian_2025_fig3.png")
print("The paper's pictures of the difference, scaled by ten, are black: no figure is printed there.")
