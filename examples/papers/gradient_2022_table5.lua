-- Mezieres et al. 2022 (gradient), Table 5: coefficients and gradients on an 8^3 grid, interpolation and shading, and the same
-- without a grid, by number of bands, under 512 lights.
--
--     lua examples/papers/gradient_2022_table5.lua [--size 480] [--threads 0] [--quick]
--
-- Milliseconds, beside the paper's (1920 x 1080 on an RTX-2080); --size is the width of a picture of that shape, --threads 0
-- means all. Perseverance's mesh is not published: a cart of boxes and rings stands in, with coats of GGX over paint.
-- Times of pictures are compared as nanoseconds of a shading point; the paper's are of a pixel.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, scenes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")

local option = common.options { size = 480, threads = 0, quick = false }
local quick, threads = option.quick, option.threads > 0 and option.threads or nil
local width = quick and 64 or option.size
local clock = require "ylm.c.core".seconds

local case = scenes.list[3]
local scene = scenes.make(case, quick and 12 or 48)
local size = { width, math.floor(width * 1080 / 1920) }
local printed = { -- bands: evaluation, interpolation, reference; ms
  [5] = { 1.39, 7.65, 45.25 }, [6] = { 1.87, 8.90, 53.77 }, [7] = { 2.43, 26.14, 77.18 }, [8] = { 3.07, 55.57, 98.79 },
  [9] = { 3.35, 132.29, 148.04 },
}

--- Milliseconds of f.
local function best(runs, f) return common.best(clock, quick and 1 or runs, f) end

ylm.on_warning(false) -- the paper's pictures have no shadows either: visibility = "none"
local row = common.table { { "bands", "%5d" }, { "grid, ms", "%8.2f" }, { "paper", "%5.2f" }, { "ratio", "%5.2f" },
  { "interp., ns", "%11.1f" }, { "paper", "%5.1f" }, { "ratio", "%5.1f" }, { "reference, ns", "%13.0f" }, { "paper", "%5.1f" },
  { "ratio", "%5.1f" }, { "speed-up", "%8.1f" }, { "paper", "%5.1f" }, { "ratio", "%5.1f" }, { "MAE x 1000", "%10.3f" } }
local first, last, points
for _, bands in ipairs(quick and { 5, 6 } or { 5, 6, 7, 8, 9 }) do
  local lmax, p = bands - 1, printed[bands]
  local view = assert(scene:prepare { size = size, samples = 1, lmax = lmax, visibility = "none", gloss = "sh",
    threads = threads })
  points = view.stats.points
  local probes, grid = ylm.uniform_grid { cells = 7, lmax = lmax, metric_channels = "none" }
  local evaluation = best(15, function() grid = scene:bake { probes = probes, quantity = "lights", occupied = "everywhere",
    threads = threads } end)
  local picture, truth
  local interpolation = best(4, function()
    local report
    picture, report = view:render { grid = grid, threads = threads }
    return report.seconds.light
  end)
  local reference = best(4, function()
    local report
    truth, report = view:render { by = "sum", threads = threads }
    return report.seconds.light
  end)
  local m = picture:compare(truth, { mask = common.surface_mask(ylm, truth) })
  local speed, theirs = reference / (evaluation + interpolation), p[3] / (p[1] + p[2])
  local ours_i, ours_r, pixel = 1e6 * interpolation / points, 1e6 * reference / points, 1e6 / (1920 * 1080)
  row { bands, evaluation, p[1], evaluation / p[1], ours_i, p[2] * pixel, ours_i / p[2] / pixel, ours_r, p[3] * pixel,
    ours_r / p[3] / pixel, speed, theirs, speed / theirs, 1000 * m.mae / m.peak }
  first, last = first or { interpolation, reference, p[2], p[3] }, { interpolation, reference, p[2], p[3], bands }
end
print(("interpolation grows %.1f times from 5 to %d bands (the paper's %.1f times), the reference %.1f times (%.1f)"):format(
  last[1] / first[1], last[5], last[3] / first[3], last[2] / first[2], last[4] / first[4]))
print(("%d x %d, %s shading points, %s threads. Why they differ:"):format(size[1], size[2], common.thousands(points),
  threads or "all"))
print "  grid: two cores and merged moments of all lights, beside a graphics card that sums them one by one."
print "  interp., reference: the card has some 3,000 lanes, a core 8 or 16."
print "  growth: interpolation here is bound by arithmetic, which grows as the 25 to 81 coefficients; the paper's by reads of"
print "    textures, which do not fit any more from 7 bands on. So more bands do not eat the speed-up here."
