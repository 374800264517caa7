-- Iwasaki & Dobashi 2025, Table 1: mean square error of the SH Hessian, ours against the
-- spherical-coordinate derivatives (SCD), by lmax up to 16, poles and their surroundings included.
--
--     ylm run examples/papers/hessian_2025_table1.lua
--
-- Truth is the scalar double reference kernel at the same directions (the specs hold it to 1e-13 of
-- 50-digit vectors). Each method is run in float and in double. An entry of SCD that is not finite, as
-- on the poles themselves, is counted apart: a mean with it would not be a number.

local ylm = require "ylm"

local count, seed = 10000, 20250811

--- 10,000 random directions, then the poles and a ring of directions at each of three distances from them.
local function directions()
  local list = {}
  local state = seed
  local function uniform() -- Park & Miller 1988, so that every Lua draws the same numbers
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
  for i = 1, count do
    local z, phi = 2 * uniform() - 1, 2 * math.pi * uniform()
    local s = math.sqrt(1 - z * z)
    list[i] = { s * math.cos(phi), s * math.sin(phi), z }
  end
  for _, z in ipairs { 1, -1 } do
    list[#list + 1] = { 0, 0, z }
    for _, distance in ipairs { 1e-2, 1e-4, 1e-6 } do
      for k = 0, 7 do
        list[#list + 1] = { distance * math.cos(k * math.pi / 4), distance * math.sin(k * math.pi / 4), z }
      end
    end
  end
  return ylm.array(list, "float")
end

--- Mean square difference over the finite entries, and how many entries are not finite.
local function mean_square(a, truth)
  local sum, n, bad = 0, 0, 0
  local x, y = a:reshape { #a * a.shape[2] * 6 }:totable(), truth
  for i = 1, #x do
    local d = x[i] - y[i]
    if d == d and d ~= math.huge and d ~= -math.huge then sum, n = sum + d * d, n + 1 else bad = bad + 1 end
  end
  return sum / n, bad
end

local points = directions()
local exact = ylm.array(points, "double")
print(("Mean square error of the Hessian, %d directions (x 1e-3 as the paper prints it)"):format(#points))
print(("%4s  %12s %12s  %12s %12s  %10s"):format("lmax", "ours float", "SCD float", "ours double", "SCD double",
  "SCD bad"))
for lmax = 2, 16, 2 do
  local _, _, truth = ylm.sh.eval(lmax, exact, { derivatives = 2, kernel = "reference" })
  truth = truth:reshape { #points * ylm.sh.count(lmax) * 6 }:totable()
  local row, bad = {}, 0
  for _, dtype in ipairs { "float", "double" } do
    for _, method in ipairs { "solid", "scd" } do
      local _, _, H = ylm.sh.eval(lmax, ylm.array(points, dtype), { derivatives = 2, method = method })
      local mse, not_finite = mean_square(H, truth)
      row[#row + 1], bad = mse * 1e3, bad + not_finite
      H:close()
    end
  end
  print(("%4d  %12.3g %12.3g  %12.3g %12.3g  %10d"):format(lmax, row[1], row[2], row[3], row[4], bad))
end
print "The paper prints 0 for its method at every lmax, and for SCD errors that grow from lmax 2 on (Table 1)."
