-- Ten spheres from a mirror's polish to chalk's: what harmonics of degree 4, 8 and 14 show of them, what rays mend, the truth.
--
--     ylm run examples/08_glossy.lua [--out DIR] [--width N] [--samples N] [--quick]
--
-- Writes glossy.png, the row of spheres, and glossy_error.png and glossy_degrees.png, curves over roughness. Prints the error
-- against paths of one reflection, sphere by sphere, beside the part of a slice's norm that the degree misses.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 1000, samples = 256, rays = 0, quick = false }
local rays = option.rays > 0 and option.rays or nil -- light samples of gloss = "auto"; nil: chosen by their noise
local degrees = option.quick and { 4 } or { 4, 8, 14 }
local alphas = option.quick and { 0.5, 1 } or { 0.05, 0.07, 0.1, 0.14, 0.19, 0.27, 0.38, 0.53, 0.73, 1 }
local size = { option.width, math.floor(0.115 * option.width) }

-- The row -------------------------------------------------------------------------------------

local STEP = 1.12
local spheres = {}
for i, alpha in ipairs(alphas) do
  spheres[i] = ylm.sphere { at = { STEP * (i - (#alphas + 1) / 2), 0, 0 }, radius = 0.5, divide = { 256, 128 },
    material = ylm.ggx { alpha = alpha, f0 = { 0.95, 0.64, 0.54 } } }
end
local row = ylm.scene "ten spheres" {
  camera = ylm.camera { from = { 0, 1.5, 24 }, at = { 0, 0, 0 }, fov = 3.1 },
  geometry = spheres,
  lights = {
    ylm.sphere_light { at = { -5, 6, 9 }, radius = 1.6, radiance = { 16, 15, 13 } },
    ylm.sphere_light { at = { 7, 2.5, 4 }, radius = 0.4, radiance = { 50, 80, 130 } },
    ylm.environment_light { sky = { zenith = { 0, 1, 0 }, luminance = 0.35 }, lmax = 14 },
  },
}

--- The errors of common.errors at the pixels that sphere k alone covers (nil: any sphere).
local function errors(image, truth, k)
  return common.errors(image, truth, k and function(at)
    local place = at[{ {}, {}, 1 }] / STEP + #alphas / 2 + 1
    return place:greater_equal(k) * place:less(k + 1)
  end)
end

--- The part of its slices that a material's degree misses, over a sphere's disk: root mean square, in percent.
local function missed(material, lmax)
  local t, views = assert(material:table { lmax = lmax }), {}
  for i = 1, 200 do views[i] = { math.sqrt((i - 0.5) / 200), 0, math.sqrt(1 - (i - 0.5) / 200) } end
  return 100 * math.sqrt((t:missed(lmax, views) ^ 2):mean())
end

local camera = { size = size, samples = 16 }
local function with(more)
  for name, value in pairs(camera) do more[name] = value end
  more.occlusion_distance = 1000
  return more
end

ylm.on_warning(false) -- gloss = "sh" says what the table shows
local truth, judged = assert(row:pathtrace { size = size, samples = option.quick and 64 or 4 * option.samples,
  reflections = { 0, 1 } })
print(("truth: %d paths a pixel, noise %.1f %%, %.0f s"):format(truth.metadata.samples, 100 * judged.noise,
  judged.seconds.total))

local columns = { { "", "%-18s" }, { "all", "%5.1f" } }
for i, alpha in ipairs(alphas) do columns[i + 2] = { ("%g"):format(alpha), "%5.1f" } end
local print_row = common.table(columns)
local measured, slices, rows = {}, {}, {}

--- Prints what a picture misses, all of it and by sphere; returns the latter.
local function judge(image, label)
  local all, all95 = errors(image, truth)
  local rms, quantile = { label, all }, { "  95 %", all95 }
  local by_sphere = {}
  for k = 1, #alphas do
    rms[k + 2], quantile[k + 2] = errors(image, truth, k)
    by_sphere[k] = rms[k + 2]
  end
  print_row(rms)
  print_row(quantile)
  return by_sphere
end

--- A row of the figure.
local function show(image, caption)
  rows[#rows + 1] = { { image = image, tone = "hable", exposure = 1.2, caption = caption } }
end

local last, report
for _, lmax in ipairs(degrees) do
  local line = { ("slices, lmax %d"):format(lmax) }
  slices[lmax] = {}
  for k, s in ipairs(spheres) do
    slices[lmax][k] = missed(s.material, lmax)
    line[k + 2] = slices[lmax][k]
  end
  print_row(line)
  local sh = assert(row:render(with { by = "sum", lmax = lmax, gloss = "sh" }))
  measured[lmax] = judge(sh, ("sh, lmax %d"):format(lmax))
  show(sh, ('gloss = "sh", lmax = %d'):format(lmax))
  last, report = assert(row:render(with { by = "sum", lmax = lmax, gloss = "auto", light_samples = rays }))
  judge(last, ("auto, lmax %d"):format(lmax))
  print(("  %.0f of %.0f points by rays, %d light samples, noise %.1f %%; %.1f s, of these rays %.1f s"):format(
    report.glossy.rays, report.glossy.points, report.glossy.light_samples, 100 * (report.glossy.noise or 0),
    report.seconds.total, report.seconds.gloss_rays))
end
show(last, ('gloss = "auto" (default), lmax = %d: rays where harmonics miss more than 1 to 3 %% of a lobe'):format(
  degrees[#degrees]))
show(truth, ("paths of one reflection, %d a pixel"):format(truth.metadata.samples))
rows[#rows + 1] = { { values = last:layer "gloss"[{ {}, {}, 1 }], caption = "share of rays in auto: layer gloss" } }
common.save(ylm.figure { rows = rows, bar = { range = { 0, 1 }, label = "share of rays" },
  title = "GGX, alpha 0.05 to 1, under two lamps and an overcast sky" }, option.out .. "glossy.png")

-- Curves --------------------------------------------------------------------------------------

local palette = { { 0.75, 0.25, 0.20 }, { 0.85, 0.60, 0.15 }, { 0.15, 0.45, 0.70 } }
local series = {}
for i, lmax in ipairs(degrees) do
  series[#series + 1] = { x = alphas, y = slices[lmax], label = ("slices, lmax %d"):format(lmax), colour = palette[i],
    marker = "none" }
  series[#series + 1] = { x = alphas, y = measured[lmax], label = ("pictures by harmonics, lmax %d"):format(lmax),
    colour = palette[i], width = 0, marker = "circle", marker_size = 10 }
end
common.save(ylm.plot { series = series, log = true, x_label = "alpha", y_label = "missed, % of the root mean square",
  title = "What a degree misses of a sphere of GGX", legend = "bottom left" }, option.out .. "glossy_error.png")

series = {}
for i, angle in ipairs { 0, 45, 75 } do
  series[i] = { x = {}, y = {}, label = ("seen %d° from the normal"):format(angle), colour = palette[i] }
end
for _, alpha in ipairs(alphas) do
  local degree = ylm.ggx { alpha = alpha, f0 = 1 }:degrees { error = 0.1, most = option.quick and 12 or 60 }
  for i, k in ipairs { 1, 10, 16 } do
    local x, y = series[i].x, series[i].y
    if degree[k] < math.huge then x[#x + 1], y[#y + 1] = alpha, degree[k] end
  end
end
common.save(ylm.plot { series = series, log = true, x_label = "alpha", y_label = "lmax", legend = "bottom left",
  title = "lmax at which a slice of GGX misses 10 % of its norm" }, option.out .. "glossy_degrees.png")
