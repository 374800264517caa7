-- Xin et al. 2021, Table 1: relative L2 error of the recursive approximation, by SH order n and k.
--
--     lua examples/papers/products_2021_table1.lua [--groups 100000]
--
-- Groups of k-1 functions with random coefficients to n = 20, cut to each n; a group's error is the norm of recursive
-- minus exact coefficients over the norm of the exact ones. The paper draws coefficients uniformly from [-1, 1]. Its
-- numbers are not the mean error of that ("mean"), nor the sum of squared differences over the sum of squares
-- ("squares"), which is nearer; for k = 4, 5, 6 they are to 0.02 the mean error of coefficients from [0, 1] ("positive"), whose
-- products gather around one direction. For k = 7 "squares" comes as near, for k = 8 nothing does. Another order of the
-- multiplications does not (a balanced tree: within 0.02 of the chain). Errors against the approximation's norm, over the
-- sum of both norms, of L1 or of the largest coefficient do not. Medians, ratios of mean or root mean square norms, equal
-- factors and other ranges do not. Coefficients that fall as 1/(l+1) or 1/sqrt(2l+1), or have a large or positive mean, do
-- not.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local groups = common.options({ groups = 100000 }).groups
local unpack = table.unpack or unpack -- luacheck: ignore

local orders = { 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20 }
local printed = {
  [4] = { 0.21, 0.22, 0.23, 0.23, 0.23, 0.24, 0.23, 0.24, 0.25, 0.24, 0.25, 0.24, 0.24 },
  [5] = { 0.35, 0.36, 0.35, 0.35, 0.34, 0.35, 0.35, 0.35, 0.35, 0.35, 0.34, 0.34, 0.35 },
  [6] = { 0.49, 0.51, 0.52, 0.52, 0.52, 0.52, 0.51, 0.51, 0.51, 0.51, 0.51, 0.51, 0.52 },
  [7] = { 0.67, 0.65, 0.66, 0.68, 0.68, 0.67, 0.69, 0.67, 0.68, 0.69, 0.69, 0.67, 0.68 },
  [8] = { 0.87, 0.88, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88 },
}
local BLOCK, FOURIER = 1000, 100 -- groups at a time; groups that the Fourier method is tried on

local function multiply(factors, options)
  local list = { unpack(factors) }
  list[#list + 1] = options
  return (ylm.sh.product(unpack(list)))
end

--- The first n rows of an array.
local function first(a, n) return a[{ 1, n }] end

--- Adds one block's errors to the sums: of errors, of squared differences, of squares.
local function add(sums, error, norms)
  sums[1] = sums[1] + error:sum()
  sums[2] = sums[2] + ((error * norms) ^ 2):sum()
  sums[3] = sums[3] + (norms ^ 2):sum()
end

--- Sums by order for groups of k-1 functions with coefficients from `low` to 1; the largest error of the Fourier method.
local function measure(k, low)
  local sums, worst, done = {}, 0, 0
  for i = 1, #orders do sums[i] = { 0, 0, 0 } end
  while done < groups do
    local rows = math.min(BLOCK, groups - done)
    local pool = {}
    for f = 1, k - 1 do pool[f] = ylm.sh.random(rows, 19, { seed = k * 10000000 + done + f, low = low }) end
    for i, n in ipairs(orders) do
      local factors = {}
      for f = 1, k - 1 do factors[f] = ylm.sh.resize(pool[f], n - 1) end
      local exact = multiply(factors, { method = "quadrature" })
      add(sums[i], ylm.sh.relative_error(multiply(factors, { method = "recursive" }), exact))
      if done == 0 and low < 0 then -- the paper's exact method, in float as there, on some of the groups
        local some = math.min(rows, FOURIER)
        local few = {}
        for f = 1, k - 1 do few[f] = first(factors[f], some) end
        local own = multiply(few, { method = "fourier", dtype = "float" })
        worst = math.max(worst, ylm.sh.relative_error(ylm.array(own, "double"), first(exact, some)):max())
      end
    end
    done = done + rows
  end
  return sums, worst
end

local function line(label, value)
  local words = { ("%-17s"):format(label) }
  for i = 1, #orders do words[#words + 1] = ("%6.2f"):format(value(i)) end
  return table.concat(words)
end

--- Root mean square of a row's distance from the printed one.
local function distance(k, value)
  local sum = 0
  for i = 1, #orders do sum = sum + (value(i) - printed[k][i]) ^ 2 end
  return math.sqrt(sum / #orders)
end

local head = { ("%-17s"):format "order n" }
for _, n in ipairs(orders) do head[#head + 1] = ("%6d"):format(n) end
print(("%d groups"):format(groups))
print(table.concat(head) .. "   off by")
for k = 4, 8 do
  local even, worst = measure(k, -1)
  local positive = measure(k, 0)
  print(line(("k = %d  paper"):format(k), function(i) return printed[k][i] end))
  for _, reading in ipairs {
    { "  mean", function(i) return even[i][1] / groups end },
    { "  squares", function(i) return even[i][2] / even[i][3] end },
    { "  positive", function(i) return positive[i][1] / groups end },
  } do
    print(line("     " .. reading[1], reading[2]) .. ("%9.3f"):format(distance(k, reading[2])))
  end
  print(("       Fourier method, float: at most %.1e of %d groups (paper: < 1e-6)"):format(worst,
    math.min(FOURIER, BLOCK, groups)))
end
