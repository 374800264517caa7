-- Xin et al. 2021, Fig. 4: time of products of k-1 functions, k = 4, 6, 8, by SH order n, and the
-- Fourier method's three stages.
--
--     lua examples/papers/products_2021_fig4.lua [--out DIR] [--quick]
--
-- brute: all integrals of k basis functions (the paper's "traditional brute-force"); traditional:
-- recursive with Gaunt sums; recursive: with the Fourier method; Fourier: exact; quadrature: ours, exact.
-- One thread, float, microseconds per product.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick
local unpack = table.unpack or unpack -- luacheck: ignore

local methods = {
  { "brute", { method = "brute" } },
  { "traditional", { method = "recursive", inner = "gaunt" } },
  { "recursive", { method = "recursive", inner = "fourier" } },
  { "Fourier", { method = "fourier" } },
  { "quadrature", { method = "quadrature" } },
}

local function time(factors, options, rows)
  local list = { unpack(factors) }
  list[#list + 1] = { method = options.method, inner = options.inner, threads = 1 }
  local ok = pcall(ylm.sh.product, unpack(list))
  if not ok then return nil end -- brute force has limits
  local best = math.huge
  for _ = 1, quick and 1 or 3 do
    local t, repeats = os.clock(), 0
    repeat
      ylm.sh.product(unpack(list))
      repeats = repeats + 1
    until os.clock() - t > (quick and 0.002 or 0.01)
    best = math.min(best, (os.clock() - t) / repeats / rows)
  end
  return best * 1e6
end

--- The least seconds of each of the Fourier method's stages of some runs.
local function stages_of(factors)
  local list, least = { unpack(factors) }, { math.huge, math.huge, math.huge }
  list[#list + 1] = { method = "fourier", stages = true }
  for _ = 1, quick and 1 or 5 do
    local _, s = ylm.sh.product(unpack(list))
    for k = 1, 3 do least[k] = math.min(least[k], s[k]) end
  end
  return least
end

for _, k in ipairs { 4, 6, 8 } do
  print(("k = %d: %d factors"):format(k, k - 1))
  print "  n       brute  traditional   recursive     Fourier  quadrature   Fourier's stages"
  local series = {}
  for i, m in ipairs(methods) do series[i] = { x = {}, y = {}, label = m[1] } end
  local stages = {}
  for i, name in ipairs { "to Fourier series", "convolution", "back" } do
    stages[i] = { x = {}, y = {}, label = name }
  end
  for n = 3, 20, quick and 4 or 1 do
    local rows = math.max(1, math.floor(400 / n ^ 2))
    local factors = {}
    for i = 1, k - 1 do factors[i] = ylm.sh.random(rows, n - 1, { seed = i, dtype = "float" }) end
    local line = ("%3d"):format(n)
    for i, m in ipairs(methods) do
      -- its tables grow as n^(2k-2): only where they are made in moments
      local t = (m[1] ~= "brute" or n ^ (2 * k - 2) <= (quick and 7000 or 70000)) and time(factors, m[2], rows)
      if t then
        table.insert(series[i].x, n)
        table.insert(series[i].y, t)
      end
      line = line .. (t and ("%12.2f"):format(t) or ("%12s"):format "-")
    end
    local s = stages_of(factors)
    local total = s[1] + s[2] + s[3]
    for i = 1, 3 do
      table.insert(stages[i].x, n)
      table.insert(stages[i].y, s[i] / rows * 1e6)
    end
    print(("%s %8.0f %% %3.0f %% %3.0f %%"):format(line, 100 * s[1] / total, 100 * s[2] / total, 100 * s[3] / total))
  end
  local drawn = {}
  for _, s in ipairs(series) do if #s.x > 1 then drawn[#drawn + 1] = s end end
  for _, picture in ipairs {
    { "products_2021_fig4_k%d.png", drawn, "Products of %d functions", "microseconds, one thread, float" },
    { "products_2021_fig4_stages_k%d.png", stages, "Stages of the Fourier method, %d functions", "microseconds" },
  } do
    common.save(ylm.plot { series = picture[2], y_log = true, title = picture[3]:format(k - 1),
      x_label = "SH order n", y_label = picture[4] }, out .. picture[1]:format(k))
  end
end
