-- Iwasaki & Dobashi 2025, Fig. 10: grid points, bake time and image errors against the absolute error
-- threshold, for the two lamps, on log-log axes.
--
--     lua examples/papers/hessian_2025_fig10.lua [--out DIR] [--depth N] [--samples N] [--width N] [--height N]
--
-- The paper says that points and time fall linearly in log-log, and that halving the threshold halves MAPE
-- and MAE (slope 1). The slopes printed here are least-squares fits over all thresholds that the depth allows.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "../common.lua")
local option = common.options { out = "out", depth = 9, samples = 4, width = 1024, height = 768 }
local out = option.out

local scene = assert(ylm.load(here .. "../scenes/two_lamps.lua"))
local size = { option.width, option.height }
local view = assert(scene:prepare { size = size, samples = option.samples, shading = "vertices",
  visibility = "transfer" })
local truth = assert(view:render { by = "sum" })
local mask = common.surface_mask(ylm, truth)

local columns = { "threshold", "points", "seconds", "mse", "mae", "mape", "psnr" }
local data = {}
for _, name in ipairs(columns) do data[name] = {} end

local put = common.table { { "E_abs <=", "%9.4g" }, { "points", "%9s" }, { "ms", "%8.2f" }, { "MSE", "%9.2e" },
  { "MAE", "%9.2e" }, { "MAPE %", "%8.4f" }, { "PSNR dB", "%7.1f" } }
local threshold = 19.2
while threshold > 0.03 do
  local grid = assert(scene:bake { occupied = view,
    probes = ylm.adaptive_grid { lmax = 4, depth = option.depth, metric = "absolute", threshold = threshold } })
  local image = assert(view:render { grid = grid, layers = false })
  local error, stats = image:compare(truth, { mask = mask }), grid.stats
  local row = { threshold = threshold, points = stats.points, seconds = stats.seconds, mse = error.mse, mae = error.mae,
    mape = error.mape, psnr = error.psnr }
  for _, name in ipairs(columns) do table.insert(data[name], row[name]) end
  put { threshold, common.thousands(stats.points), stats.seconds * 1e3, error.mse, error.mae, error.mape, error.psnr }
  threshold = threshold / 2
end

print "\nSlopes in log-log (paper: points and time straight lines, MAPE and MAE 1):"
for _, name in ipairs { "points", "seconds", "mse", "mae", "mape" } do
  print(("  %-8s ~ threshold ^ %.2f"):format(name, common.slope(data.threshold, data[name])))
end
local halving = 2 ^ common.slope(data.threshold, data.mape)
print(("Halving the threshold divides MAPE by %.2f here; the paper reports 2."):format(halving))

local function plot(name, label)
  return ylm.plot { x = data.threshold, y = data[name], log = true, x_label = "threshold of E_abs", y_label = label,
    size = { 640, 480 } }
end
local pictures = {}
for _, what in ipairs {
  { "points", "grid points" }, { "seconds", "bake [s]" }, { "mape", "MAPE [%]" }, { "mae", "MAE" },
} do
  local p = plot(what[1], what[2])
  common.save(p, out .. "hessian_2025_fig10_" .. what[1] .. ".png")
  pictures[#pictures + 1] = { image = p, caption = ("slope %.2f"):format(common.slope(data.threshold, data[what[1]])) }
end
common.save(ylm.figure { rows = { { pictures[1], pictures[2] }, { pictures[3], pictures[4] } },
  title = "Two lamps: cost and error against the threshold" }, out .. "hessian_2025_fig10.png")
