-- Xin et al. 2021, Table 1: relative L2 error of the recursive approximation, by SH order n and k.
--
--     lua examples/papers/products_2021_table1.lua [groups, 1000]
--
-- Groups of k-1 functions with coefficients uniform in [-1, 1] to n = 20, cut to each n, as in the
-- paper, which took 100,000 groups. The paper does not say which mean it prints: ours are the mean of the
-- groups' relative errors, and the sum of all squared differences over the sum of all squares, which is nearer.

local ylm = require "ylm"

local groups = tonumber(arg and arg[1]) or 1000
local unpack = table.unpack or unpack -- luacheck: ignore

local orders = { 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20 }
local printed = {
  [4] = { 0.21, 0.22, 0.23, 0.23, 0.23, 0.24, 0.23, 0.24, 0.25, 0.24, 0.25, 0.24, 0.24 },
  [5] = { 0.35, 0.36, 0.35, 0.35, 0.34, 0.35, 0.35, 0.35, 0.35, 0.35, 0.34, 0.34, 0.35 },
  [6] = { 0.49, 0.51, 0.52, 0.52, 0.52, 0.52, 0.51, 0.51, 0.51, 0.51, 0.51, 0.51, 0.52 },
  [7] = { 0.67, 0.65, 0.66, 0.68, 0.68, 0.67, 0.69, 0.67, 0.68, 0.69, 0.69, 0.67, 0.68 },
  [8] = { 0.87, 0.88, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88 },
}

local head = { "order n    " }
for _, n in ipairs(orders) do head[#head + 1] = ("%5d"):format(n) end
print(table.concat(head))
for k = 4, 8 do
  local sums, differences, squares, worst = {}, {}, {}, 0
  for i = 1, #orders do sums[i], differences[i], squares[i] = 0, 0, 0 end
  local done = 0
  while done < groups do
    local rows = math.min(200, groups - done)
    local pool = {}
    for f = 1, k - 1 do pool[f] = ylm.sh.random(rows, 19, { seed = k * 100000 + done + f }) end
    for i, n in ipairs(orders) do
      local factors = {}
      for f = 1, k - 1 do factors[f] = ylm.sh.resize(pool[f], n - 1) end
      factors[k] = { method = "quadrature" }
      local exact = ylm.sh.product(unpack(factors))
      factors[k] = { method = "recursive" }
      local error, norms = ylm.sh.relative_error((ylm.sh.product(unpack(factors))), exact)
      for r = 1, rows do
        sums[i] = sums[i] + error[r]
        differences[i] = differences[i] + (error[r] * norms[r]) ^ 2
        squares[i] = squares[i] + norms[r] ^ 2
      end
      if i <= 4 then
        factors[k] = { method = "fourier", dtype = "float" }
        local own = ylm.sh.relative_error(ylm.array(ylm.sh.product(unpack(factors)), "double"), exact)
        for r = 1, rows do worst = math.max(worst, own[r]) end
      end
    end
    done = done + rows
  end
  local ours, ratio, theirs = { ("k = %d  mean"):format(k) }, { "    squares" }, { "      paper" }
  for i = 1, #orders do
    ours[#ours + 1] = ("%5.2f"):format(sums[i] / groups)
    ratio[#ratio + 1] = ("%5.2f"):format(differences[i] / squares[i])
    theirs[#theirs + 1] = ("%5.2f"):format(printed[k][i])
  end
  print(table.concat(ours))
  print(table.concat(ratio))
  print(table.concat(theirs) .. ("   (Fourier method, float, n <= 6: at most %.0e)"):format(worst))
end
