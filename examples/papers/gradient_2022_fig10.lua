-- Mezieres et al. 2022 (gradient), Fig. 10: time of a picture by the number of lights, with an 8^3 grid and without: spheres,
-- triangles, spheres times |cos gamma| for triangles, and the zonal rival, which knows no grid.
--
--     lua examples/papers/gradient_2022_fig10.lua [--out DIR] [--size 240] [--threads 0] [--quick]
--
-- Writes gradient_2022_fig10.png. The paper prints a plot and no numbers: who is below whom, and where lines cross, is compared.
-- The scene of Fig. 8, lit by a square of 2 n^2 triangles; --threads 0: all.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, scenes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")
local triangles, zonal = dofile(here .. "triangles_2022.lua"), dofile(here .. "zonal_2022.lua")

local option = common.options { out = "out", size = 240, threads = 0, quick = false }
local out, quick, threads = option.out, option.quick, option.threads > 0 and option.threads or nil
local size = quick and { 16, 16 } or { option.size, option.size }
local glossy = ylm.ggx { alpha = 0.35, f0 = { 0.5, 0.6, 0.7 } }
local clock = require "ylm.c.core".seconds
local lmax = 4

ylm.on_warning(false) -- of light that passes occluders: the paper's pictures have no shadows either

--- Milliseconds of f, the best of three, or of as many as half a second holds; f may return seconds that it knows.
local function best(f)
  local least, all, n = math.huge, 0, 0
  repeat
    local start = clock()
    local seconds = f() or clock() - start
    least, all, n = math.min(least, seconds), all + clock() - start, n + 1
  until quick or n >= 3 and all > 0.5 or n >= 100
  return 1000 * least
end

--- Milliseconds by a grid and without, and by the zonal rival where `list` is that of sphere lights.
local function times(lights, list)
  local scene = scenes.pair(quick and 12 or 96, glossy, lights)
  local view = assert(scene:prepare { size = size, samples = 1, lmax = lmax, visibility = "none", gloss = "sh",
    threads = threads })
  local probes, grid = ylm.uniform_grid { cells = 7, lmax = lmax, metric_channels = "none" }
  local by_grid = best(function()
    grid = scene:bake { probes = probes, quantity = "lights", occupied = "everywhere", threads = threads }
  end) + best(function() return select(2, view:render { grid = grid, threads = threads, layers = false }).seconds.light end)
  local without = best(function() return select(2, view:render { by = "sum", threads = threads,
    layers = false }).seconds.light end)
  if not list then return by_grid, without, nil, view.stats.points end
  local rough = zonal.shader(view, list, { ylm.matte { albedo = 0.7 }, ylm.matte { albedo = 0.7 }, glossy }, lmax, threads)
  return by_grid, without, rough and best(function() rough() end), view.stats.points
end

local row = common.table { { "lights", "%6d" }, { "spheres: grid", "%13.1f" }, { "without", "%8.1f" }, { "zonal", "%8.1f" },
  { "triangles: grid", "%15.1f" }, { "without", "%8.1f" }, { "|cos|: grid", "%11.1f" }, { "without", "%8.1f" } }
local kinds = { { "spheres, grid" }, { "spheres" }, { "spheres, zonal" }, { "triangles, grid" }, { "triangles" },
  { "spheres × |cos γ|, grid" }, { "spheres × |cos γ|" } }
local counts, points, last = {}, 0, nil
for i, n in ipairs(quick and { 2, 3 } or { 5, 10, 16, 20 }) do
  local list = triangles.cut(n, n, function(s, t) return { -1.5 + 3 * s, 3.2, -1.5 + 3 * t } end)
  local bare, lamps = triangles.lights(list, "bare", 3), { at = {}, radiance = {} }
  for k, l in ipairs(bare) do lamps.at[k], lamps.radius, lamps.radiance[k] = l.at, l.radius, { 3, 3, 3 } end
  local cells = { #list }
  cells[2], cells[3], cells[4], points = times(bare, lamps)
  cells[5], cells[6] = times(triangles.lights(list, "exact", 3))
  cells[7], cells[8] = times(triangles.lights(list, "sphere", 3))
  row(cells)
  counts[i], last = #list, cells
  for k = 1, 7 do kinds[k][i + 1] = cells[k + 1] end
end
print(("milliseconds; %d x %d, %s shading points, %s threads"):format(size[1], size[2], common.thousands(points),
  threads or "all"))
print(("at %d lights a grid is %.1f times as fast for spheres, %.1f for triangles, %.1f for spheres times |cos gamma|"):format(
  last[1], last[3] / last[2], last[6] / last[5], last[8] / last[7]))
print "Why they differ. As there: pictures by a grid grow little with the lights, pictures without as their number, and"
print "  triangles are the dearest. Not as there: the zonal rival is no cheap substitute. It is a plain loop in"
print "  doubles over lamps, each with its own lobe; the lamps' moments are summed at once here, in vectors of points."

local series, colours = {}, { { 0.1, 0.4, 0.8 }, { 0.1, 0.4, 0.8 }, { 0.5, 0.5, 0.5 }, { 0.85, 0.3, 0.1 }, { 0.85, 0.3, 0.1 },
  { 0.2, 0.6, 0.3 }, { 0.2, 0.6, 0.3 } }
for k, kind in ipairs(kinds) do
  local y = {}
  for i = 1, #counts do y[i] = kind[i + 1] end
  if #y == #counts then
    series[#series + 1] = { x = counts, y = y, label = kind[1], colour = colours[k], width = 2,
      dash = kind[1]:find "grid" and "dashed" or "solid", marker = k == 3 and "diamond" or "circle" }
  end
end
common.save(ylm.plot { series = series, title = ("Time of a picture of %s points, 5 bands"):format(common.thousands(points)),
  x_label = "lights", y_label = "ms", log = true,
  y_range = { 1, 1e6 }, size = { 900, 620 }, legend = "top left" }, out .. "gradient_2022_fig10.png")
