-- Xin et al. 2021, Fig. 3: time of the product of two functions by SH order n, and its three stages.
--
--     lua examples/papers/products_2021_fig3.lua [--out DIR] [--quick]
--
-- "Fourier" is the paper's method, "Gaunt" the traditional one, "quadrature" ours. One thread, float,
-- microseconds per product, in batches of about 4000/n^2; the paper's speed-ups over the traditional method are
-- 3.0, 9.9 and 21.7 at n = 10, 15 and 20 on its processor. The speed-ups printed here are less, because "Gaunt" is twice
-- as fast as a list of integrals; against such a list they are 3.2, 11.6 and 22.6 (make bench BENCH=products). "with FFTW"
-- is the paper's method built on FFTW, measured on another day on the processor that docs/performance.md names.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", quick = false }
local folder, quick = option.out, option.quick
local paper = { [10] = 3.0, [15] = 9.9, [20] = 21.7 }
local fftw = { x = { 8, 10, 12, 16, 20 }, y = { 3.9, 10.4, 14, 36, 127 }, label = "Fourier, with FFTW" }

--- Microseconds of one product, the least of some runs over the same rows.
local function time(method, a, b, out, rows)
  local best = math.huge
  for _ = 1, quick and 2 or 5 do
    local t = os.clock()
    local repeats = 0
    repeat
      ylm.sh.product(a, b, { method = method, threads = 1, out = out })
      repeats = repeats + 1
    until os.clock() - t > (quick and 0.002 or 0.02)
    best = math.min(best, (os.clock() - t) / repeats / rows)
  end
  return best * 1e6
end

--- The least seconds of each stage of some runs.
local function stages_of(a, b, out)
  local least = { math.huge, math.huge, math.huge }
  for _ = 1, quick and 2 or 7 do
    local _, s = ylm.sh.product(a, b, { method = "fourier", stages = true, out = out })
    for k = 1, 3 do least[k] = math.min(least[k], s[k]) end
  end
  return least
end

print "  n     Gaunt   Fourier  quadrature   Fourier is faster by (paper)   Fourier's stages: to, convolution, back"
local x, series = {}, { Gaunt = {}, Fourier = {}, quadrature = {} }
local stages = { {}, {}, {} }
for n = 3, 20 do
  local rows = math.max(1, math.floor(4000 / n ^ 2))
  local a, b = ylm.sh.random(rows, n - 1, { seed = 1, dtype = "float" }), ylm.sh.random(rows, n - 1, { seed = 2,
    dtype = "float" })
  local out = ylm.zeros(a.shape, "float")
  local g, f, q = time("gaunt", a, b, out, rows), time("fourier", a, b, out, rows), time("quadrature", a, b, out, rows)
  local s = stages_of(a, b, out)
  local total = s[1] + s[2] + s[3]
  x[#x + 1] = n
  table.insert(series.Gaunt, g)
  table.insert(series.Fourier, f)
  table.insert(series.quadrature, q)
  for k = 1, 3 do table.insert(stages[k], f * s[k] / total) end
  print(("%3d %9.3f %9.3f %11.3f   %6.2f  %-22s %9.0f %% %6.0f %% %6.0f %%"):format(n, g, f, q, g / f,
    paper[n] and ("(%.1f)"):format(paper[n]) or "", 100 * s[1] / total, 100 * s[2] / total, 100 * s[3] / total))
end

local list = {}
for _, name in ipairs { "Gaunt", "Fourier", "quadrature" } do
  list[#list + 1] = { x = x, y = series[name], label = name }
end
list[#list + 1] = fftw
common.save(ylm.plot { series = list, y_log = true, title = "Product of two functions", x_label = "SH order n",
  y_label = "microseconds, one thread, float" }, folder .. "products_2021_fig3.png")
list = {}
for k, name in ipairs { "to Fourier series", "convolution", "back" } do list[k] = { x = x, y = stages[k],
  label = name } end
common.save(ylm.plot { series = list, y_log = true, title = "Stages of the Fourier method", x_label = "SH order n",
  y_label = "microseconds" }, folder .. "products_2021_fig3_stages.png")
