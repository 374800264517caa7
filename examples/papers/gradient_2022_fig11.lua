-- Mezieres et al. 2022 (gradient), Fig. 11: five captured materials under 800 lights, by an 8^3 grid, beside rays to the lights.
--
--     lua examples/papers/gradient_2022_fig11.lua [--material DIR] [--bands 9] [--size 960] [--out DIR] [--quick]
--
-- Writes gradient_2022_fig11.png. --material names a folder with RGL's files (Dupuy & Jakob 2018), cm_toxic_green_rgb.bsdf and
-- so on (docs/material_files.md says where they are published); a material whose file is not there has a stand-in, which is not
-- measured and is called so in the table and under the picture. Knots stand in for the statue.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, scenes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")

local option = common.options { material = "", bands = 9, size = 960, out = "out", quick = false }
local out, quick = option.out, option.quick
local width = quick and 64 or option.size
local size = { width, math.floor(width * 735 / 1920) }
local lmax = quick and 2 or option.bands - 1
local clock = require "ylm.c.core".seconds

--- The file of a material in the folder --material; nil: there is none.
local function file_of(name)
  if option.material == "" then return nil end
  local path = ("%s/%s_rgb.bsdf"):format(option.material, name)
  local file = io.open(path, "rb")
  if file then file:close() end
  return file and path
end

ylm.on_warning(false) -- of light that passes occluders: the paper has no shadows either
print(("tables of %d bands; a slice seen from 45 degrees misses so much of its norm"):format(lmax + 1))
local row = common.table { { "paper's material", "%-20s" }, { "here", "%-41s" }, { "seconds", "%7.2f" }, { "KB", "%7.1f" },
  { "missed %", "%8.1f" }, { "bands for 10 %", "%14s" } }
local materials, captions, measured = {}, {}, 0
for i, m in ipairs(scenes.captured) do
  local path = file_of(m[1])
  if path then materials[i], measured = ylm.rgl { file = path }, measured + 1
  elseif quick and i == 5 then materials[i] = ylm.phong { exponent = 6, specular = 0.4, base = 0.2 } -- takes no second to make
  else materials[i] = m[3]() end
  captions[i] = path and m[1] or m[2]
  local start = clock()
  local t = assert(materials[i]:table { lmax = lmax })
  local degrees = not quick and materials[i]:degrees { error = 0.1 }[10] or math.huge
  row { m[1], path and "measured" or ("stand-in, not measured: %s"):format(m[2]), clock() - start, t.bytes / 1000,
    100 * t:missed(lmax, { math.sqrt(0.5), 0, math.sqrt(0.5) }):get(1), degrees < math.huge and degrees + 1 or "-" }
end

local scene = scenes.row(quick and 10 or 96, materials, (scenes.dome(800, 34, 0.1, 5.2, 0.2, 0.55)))
local view = assert(scene:prepare { size = size, samples = quick and 1 or 4, lmax = lmax, visibility = "none", gloss = "sh" })
local grid = scene:bake { probes = ylm.uniform_grid { cells = 7, lmax = lmax, metric_channels = "none" }, quantity = "lights",
  occupied = "everywhere" }
local picture, fast = view:render { grid = grid }
local truth, slow = view:render { by = "sum" }
local rays, cast = view:render { by = "rays", visibility = "none", light_samples = quick and 16 or 256 }

local mask = common.surface_mask(ylm, truth)
local m = picture:compare(truth, { mask = mask })
local speed, theirs = slow.seconds.light / fast.seconds.light, 133.01 / 28.56
print(("%d x %d, %s shading points of 800 lights: by the grid %.2f s, at every pixel %.2f s: %.1f times (the paper's %.1f; "
  .. "ratio %.2f)"):format(
  size[1], size[2], common.thousands(view.stats.points), fast.seconds.light, slow.seconds.light, speed, theirs, speed / theirs))
print(("MAE x 1000 of the grid against every pixel: %.4f (the paper's 0.0340; ratio %.2f)"):format(1000 * m.mae / m.peak,
  1000 * m.mae / m.peak / 0.0340))
local black = ylm.image { size = size }
print(("against rays: %.1f %% (rms of the difference over rms, the rays' noise included)"):format(
  100 * picture:compare(rays, { mask = mask }).rmse / black:compare(rays, { mask = mask }).rmse))
print "Why they differ. times: sums over lights at every pixel are slow on two cores, a grid is not. MAE: the lights' layout and"
print "  distance are not published. Materials: 9 bands hold lobes of roughness 0.35 and more; the first one's needs ten."

local peak = rays:compare(rays, { mask = mask }).peak
local exposure = 0.5 - math.log(peak) / math.log(2)
local function shown(image, caption) return { image = image, caption = caption, tone = "srgb", exposure = exposure } end
common.save(ylm.figure {
  title = measured == 5 and "Captured materials under 800 lights" or "Five materials under 800 lights",
  rows = { { shown(picture, ("harmonics of %d bands, by an 8³ grid: %.2f s"):format(lmax + 1, fast.seconds.light)) },
    { shown(rays, ("256 rays to the lights, without shadows: %.0f s"):format(cast.seconds.light)) } },
  caption = ("From left to right: %s. %s"):format(table.concat(captions, ", "),
    measured == 5 and "Files of RGL (Dupuy & Jakob 2018)."
    or ("%s stand-ins for the paper's captured materials and are not measured."):format(
      measured == 0 and "All are" or "Names without an underscore are")),
}, out .. "gradient_2022_fig11.png")
