-- Mezieres et al. 2022 (gradient), Table 3: eight scenes of 242 to 2,500 lights by an 8^3 grid of 5 bands: coefficients, with
-- gradients, interpolation and shading, ambient occlusion by the picture, beside the same without a grid.
--
--     lua examples/papers/gradient_2022_table3.lua [--out DIR] [--size 480] [--threads 0] [--quick]
--
-- Writes gradient_2022_table3.png. The paper's meshes are not ours, nor are its lights and materials: eight scenes made here
-- have its numbers of lights and its pictures' shapes (scenes_2022.lua). --size is the width of a picture; what grows with its
-- pixels, interpolation, ambient occlusion and the reference, is printed as for the paper's number of pixels. The speed-up
-- counts ambient occlusion on both sides. --threads 0: all.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, scenes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")

local option = common.options { out = "out", size = 480, threads = 0, quick = false }
local out, quick, threads = option.out, option.quick, option.threads > 0 and option.threads or nil
local lmax = 4
local clock = require "ylm.c.core".seconds

--- Milliseconds of f.
local function best(runs, f) return common.best(clock, quick and 1 or runs, f) end

ylm.on_warning(false) -- of light that passes occluders, and of ambient occlusion: the paper's pictures have both
local row = common.table { { "scene", "%-18s" }, { "lights", "%6s" }, { "", "%-7s" }, { "eval", "%6.2f" }, { "& grad",
  "%6.2f" },
  { "interp.", "%7.2f" }, { "ssao", "%6.2f" }, { "total", "%7.2f" }, { "reference", "%9.2f" }, { "speed-up", "%8.2f" },
  { "MAE x 1000", "%10.4f" } }
local names = { "eval", "grad", "interp", "ssao", "total", "reference", "speed", "mae" }
local pictures, overhead = { {}, {} }, { 0, 0 }
local cases = quick and { scenes.list[2], scenes.list[4] } or scenes.list
for i, case in ipairs(cases) do
  local scene = scenes.make(case, quick and 10 or 64)
  local width = quick and 48 or math.floor(option.size * case.size[1] / 1920)
  local size = { width, math.floor(width * case.size[2] / case.size[1]) }
  local more = case.size[1] * case.size[2] / (size[1] * size[2]) -- pixels of the paper to those here
  local view = assert(scene:prepare { size = size, samples = 1, lmax = lmax, visibility = "none", gloss = "sh",
    threads = threads })
  local probes = ylm.uniform_grid { cells = 7, lmax = lmax, metric_channels = "none" }
  local grid = scene:bake { probes = probes, quantity = "lights", occupied = "everywhere", threads = threads }
  local corners, t = grid:points().position, {}
  local function coefficients(derivatives)
    return best(60, function() ylm.light_field(lmax, scene.lights, corners, { derivatives = derivatives,
      threads = threads }) end)
  end
  t.eval, t.grad = coefficients(0), coefficients(1)
  local picture, plain, truth, report
  t.interp = more * best(4, function()
    plain, report = view:render { grid = grid, threads = threads }
    return report.seconds.light
  end)
  t.ssao = more * best(2, function()
    picture, report = view:render { grid = grid, ambient = "ssao", ambient_radius = 0.4, threads = threads }
    return report.seconds.ambient
  end)
  t.reference = more * best(2, function()
    truth, report = view:render { by = "sum", threads = threads }
    return report.seconds.light
  end)
  t.total = t.grad + t.interp + t.ssao
  t.speed = (t.reference + t.ssao) / t.total
  local mask = common.surface_mask(ylm, truth)
  local m = plain:compare(truth, { mask = mask })
  t.mae = 1000 * m.mae / m.peak
  local p, paper = case.printed, {}
  for k, name in ipairs { "eval", "grad", "interp", "ssao", "total", "reference" } do paper[name] = p[k] end
  paper.speed, paper.mae = p[6] / p[5], p[7]
  local function print_row(name, kind, values)
    local cells = { [1] = name or "", [2] = name and tostring(case.lights) or "", [3] = kind }
    for k, key in ipairs(names) do cells[3 + k] = values[key] end
    row(cells)
  end
  local ratio = {}
  for _, key in ipairs(names) do ratio[key] = t[key] / paper[key] end
  print_row(case.name, "here", t)
  print_row(nil, "paper", paper)
  print_row(nil, "ratio", ratio)
  overhead[1], overhead[2] = overhead[1] + t.grad / t.eval / #cases, overhead[2] + paper.grad / paper.eval / #cases
  local mean = ylm.image { size = size }:compare(truth, { mask = mask }).mae -- over surfaces
  local line = pictures[i <= #cases / 2 and 1 or 2]
  line[#line + 1] = { image = picture, tone = "srgb", exposure = math.log(0.22 / mean) / math.log(2),
    caption = ("%s: %d lights, %.1f ×"):format(case.name, case.lights, t.speed) }
end
print(("gradients cost %.2f times the coefficients alone, the mean of the scenes (the paper's %.2f; ratio %.2f)"):format(
  overhead[1], overhead[2], overhead[1] / overhead[2]))
print "Milliseconds. Scenes in place of the paper's, in this order:"
for _, case in ipairs(cases) do print(("  %-18s Fig. %-3s %s"):format(case.name, case.figure, case.here)) end
print "Why they differ. eval: two cores and merged moments beside a graphics card that sums light by light; triangles (White"
print "  Room) ask for a factor each. interp., ssao, reference: the card has some 3,000 lanes. speed-up: ssao on cores is no"
print "  small part of the total, and of both. MAE: means are over pixels that show surfaces, the largest value is 1; an 8^3"
print "  grid errs as lamps are near in voxels: a screen at the wall of a room is the worst, here as there."

for _, line in ipairs(pictures) do
  if #line == 0 then pictures[2] = nil end
end
common.save(ylm.figure { rows = pictures, title = "Eight scenes by an 8³ grid of 5 bands, darkened by ambient occlusion",
  width = quick and 400 or 1400,
    caption = "Scenes made here in place of the paper's, with its numbers of lights. The factor is the "
    .. "time without a grid over that with one. There are no shadows; ambient occlusion is not the scenes' light." },
  out .. "gradient_2022_table3.png")
