-- Mezieres et al. 2022 (gradient), Table 1: time to evaluate the basis and its gradient, by method and band.
--
--     lua examples/papers/gradient_2022_table1.lua [--quick]
--
-- Nanoseconds for one direction (of a thousand), one thread, float, beside the printed ones. "solid" is
-- ours: Cartesian recurrences, vectorised over directions and exact at the poles.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local quick = common.options({ quick = false }).quick
local bands = { 3, 4, 5, 6, 8, 10 }
local printed = {
  polynomial = { 84.74, 115.56, 162.85, 244.87, 471.42, 864.27 },
  sloan = { 67.50, 77.43, 93.48, 113.78, 172.55, 254.23 },
  direct = { 83.92, 104.32, 130.13, 166.14, 262.52, 381.35 },
}

local rows = {}
for i = 1, 1000 do
  local z, phi = 2 * (i - 0.5) / 1000 - 1, i * 2.39996322972865
  rows[i] = { math.sqrt(1 - z * z) * math.cos(phi), math.sqrt(1 - z * z) * math.sin(phi), z }
end
local directions = ylm.array(rows, "float")

local function time(method, lmax)
  local count = (lmax + 1) ^ 2
  local out = { ylm.zeros({ 1000, count }, "float"), ylm.zeros({ 1000, count, 3 }, "float") }
  local options = { derivatives = 1, method = method, threads = 1, out = out }
  if not pcall(ylm.sh.eval, lmax, directions, options) then return nil end
  local best = math.huge
  for _ = 1, quick and 2 or 20 do
    local t, repeats = os.clock(), 0
    repeat
      ylm.sh.eval(lmax, directions, options)
      repeats = repeats + 1
    until os.clock() - t > 0.002
    best = math.min(best, (os.clock() - t) / repeats / 1000)
  end
  return best * 1e9
end

local head = { ("%-22s"):format "bands" }
for _, n in ipairs(bands) do head[#head + 1] = ("%8d"):format(n) end
print(table.concat(head))
for _, method in ipairs { "polynomial", "direct", "sloan", "solid" } do
  local ours, theirs = { ("%-22s"):format(method .. ", here") }, { ("%-22s"):format(method .. ", paper") }
  for i, n in ipairs(bands) do
    local t = time(method, n - 1)
    ours[#ours + 1] = t and ("%8.1f"):format(t) or "       -"
    if printed[method] then theirs[#theirs + 1] = ("%8.1f"):format(printed[method][i]) end
  end
  print(table.concat(ours))
  if printed[method] then print(table.concat(theirs)) end
end
