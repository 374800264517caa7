-- Iwasaki & Dobashi 2025, Table 1: mean square error of the SH Hessian, ours against the
-- spherical-coordinate derivatives (SCD), by lmax up to 16, in double and in float.
--
--     lua examples/papers/hessian_2025_table1.lua [--count DIRECTIONS] [--singles DIRECTIONS]
--
-- Truth is the scalar double reference kernel at the same directions (the specs hold it to 1e-13 of
-- 50-digit vectors). The paper measures at random directions and says that SCD "provides errors even for
-- low-order SHs", "unstable around the poles": errors are printed for random directions and for rings at
-- 1e-2, 1e-4 and 1e-6 of the poles apart. SCD in float are the generated formulas (lua/ylm/codegen/scd.lua)
-- with every sum, product, quotient and root rounded to float, at --singles of the random directions.
-- Entries that are not finite, those of SCD at the poles, are counted apart: a mean with them is no number.
--
-- Results (x 1e-3, lmax 2 to 16): at random directions SCD in float errs by 1.5e-11 to 1.3e-7, no more than
-- ours: rounding alone. Within 1e-2 of the poles it errs by 0.09 to 6.5, 2 to 0.5 % of the values, where ours
-- errs by 1.4e-12 to 4.2e-8; in double by 6e-19 to 6e-17. The claim holds near the poles in float, and at the
-- poles, where SCD is not finite; it does not hold at random directions, or in double.

local ylm = require "ylm"
local scd = require "ylm.codegen.scd"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option, seed, HIGHEST = common.options { count = 10000, singles = 500 }, 20250811, 16

--- `count` random directions in float.
local function random_directions(count)
  local list, state = {}, seed
  local function uniform() -- Park & Miller 1988, so that every Lua draws the same numbers
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
  for i = 1, count do
    local z, phi = 2 * uniform() - 1, 2 * math.pi * uniform()
    local s = math.sqrt(1 - z * z)
    list[i] = { s * math.cos(phi), s * math.sin(phi), z }
  end
  return ylm.array(list, "float")
end

--- The poles and a ring of directions at each of three distances from them, in float.
local function polar_directions()
  local list = {}
  for _, z in ipairs { 1, -1 } do
    list[#list + 1] = { 0, 0, z }
    for _, distance in ipairs { 1e-2, 1e-4, 1e-6 } do
      for k = 0, 7 do
        local angle = (k + 0.3) * math.pi / 4
        list[#list + 1] = { distance * math.cos(angle), distance * math.sin(angle), z }
      end
    end
  end
  return ylm.array(list, "float")
end

-- Float arithmetic ---------------------------------------------------------------------

--- x rounded to the nearest float: the part of a double that is left when 29 bits are split off (after Veltkamp).
local function round(x)
  local size = math.abs(x)
  if x ~= x or size == math.huge or size == 0 then return x end
  if size < 2 ^ -126 then return math.floor(x * 2 ^ 149 + 0.5) * 2 ^ -149 end
  local c = x * 536870913 -- 2^29 + 1
  x = c - (c - x)
  return math.abs(x) < 2 ^ 128 and x or x * math.huge
end

local single = {}
local function float(x) return setmetatable({ round(x) }, single) end
local function value(x) return type(x) == "number" and round(x) or x[1] end
function single.__add(a, b) return float(value(a) + value(b)) end
function single.__sub(a, b) return float(value(a) - value(b)) end
function single.__mul(a, b) return float(value(a) * value(b)) end
function single.__div(a, b) return float(value(a) / value(b)) end
function single.__unm(a) return float(-a[1]) end

--- Hessians of SCD in float at the first n directions, rows of [(HIGHEST+1)^2 * 6].
local function scd_in_float(directions, n)
  local rows = {}
  for i = 1, n do
    local at = { x = directions:get(i, 1), y = directions:get(i, 2), z = directions:get(i, 3) }
    local d = round(math.sqrt(round(round(at.x * at.x + at.y * at.y) + at.z * at.z)))
    local g = { constant = float, sqrt = function(a) return float(math.sqrt(a[1])) end,
      variable = function(name) return float(at[name] / d) end }
    rows[i] = {}
    for _, out in ipairs(scd.build(g, HIGHEST, { derivatives = 2 })) do
      if out.array == "ddY" then rows[i][out.index + 1] = round(round(out.node[1] / d) / d) end
    end
  end
  return ylm.array(rows)
end

-- The table ------------------------------------------------------------------------------

--- Hessians at unit vectors along the directions, rows of [(HIGHEST+1)^2 * 6].
local function hessians(directions, options)
  options.derivatives = 2
  local _, _, H = ylm.sh.eval(HIGHEST, directions, options)
  return H:reshape { #directions, ylm.sh.count(HIGHEST) * 6 }
end

--- Root mean square of the entries up to a degree: how large they are.
local function magnitude(truth, lmax)
  return math.sqrt((truth[{ {}, { 1, ylm.sh.count(lmax) * 6 } }] ^ 2):mean())
end

--- Mean square difference over the finite entries up to a degree, in 1e-3, and how many entries are not finite.
local function mean_square(rows, truth, lmax)
  local entries = { 1, ylm.sh.count(lmax) * 6 }
  local d = rows[{ {}, entries }] - truth[{ { 1, #rows }, entries }]
  local finite = d:abs():less(math.huge)
  local n = finite:sum()
  return 1e3 * (d:select(finite) ^ 2):sum() / n, d.shape[1] * d.shape[2] - n
end

local function try(name, directions)
  local exact = ylm.array(directions, "double")
  local singles = math.min(#directions, option.singles)
  local truth = hessians(exact, { kernel = "reference" })
  local theirs, theirs_float = hessians(exact, { method = "scd" }), scd_in_float(directions, singles)
  local ours, ours_float = hessians(exact, { method = "solid" }), hessians(directions, { method = "solid" })
  print(("Mean square error of the Hessian x 1e-3, %d %s (SCD in float: %d)"):format(#directions, name, singles))
  print(("%4s  %12s %12s %12s %12s  %16s %12s"):format("lmax", "SCD", "SCD, float", "ours", "ours, float",
    "SCD, not finite", "rms of truth"))
  for lmax = 2, HIGHEST, 2 do
    local double, bad = mean_square(theirs, truth, lmax)
    print(("%4d  %12.3g %12.3g %12.3g %12.3g  %16d %12.3g"):format(lmax, double, (mean_square(theirs_float, truth, lmax)),
      (mean_square(ours, truth, lmax)), (mean_square(ours_float, truth, lmax)), bad, magnitude(truth, lmax)))
  end
end

try("random directions", random_directions(option.count))
try("directions at and near the poles", polar_directions())
print "The paper prints 0 for its method at every lmax up to 16, and errors for SCD from low lmax on; its numbers"
print "(x 1e-3) did not survive the conversion of the paper to text, so that they cannot be printed beside ours."
