-- Mezieres et al. 2022 (gradient), Table 4 (with Fig. 12), Figs. 16 and 17: pictures under a square light that is cut into
-- triangles. A sphere, or a sphere times |cos gamma|, replaces each; the exact triangles are the truth.
--
--     lua examples/papers/gradient_2022_table4.lua [--out DIR] [--quick]
--
-- The paper's pictures show an Armadillo and a Buddha (288, 512, 800 lights) and a white room (722) on a GPU; its
-- scenes, lights and material are not published. Here: a knot and a ball in a corner of a room, as many
-- triangles (2 n^2 of a square), 5 bands, no visibility as there. All surfaces are diffuse. Magnitudes, not digits, can
-- therefore be compared: MAE of radiance, times 1000, where the largest value is 1. Bare spheres are off by about
-- 1 - |cos gamma|, which is the layout's and nothing else's; the factor's gain is what the paper claims ("two orders").
-- "interp." is an 8^3 grid, by Hermite, against exact triangles in the same grid.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, triangles = dofile(here .. "../common.lua"), dofile(here .. "triangles_2022.lua")
local scenes = dofile(here .. "scenes_2022.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick
local size = quick and { 40, 30 } or { 240, 180 }
ylm.on_warning(false) -- of light that passes occluders: the paper's pictures have no shadows either

--- 2 nx ny triangles of a square of edge 1.6 above the corner, facing down and towards it, as corners.
local function square(nx, ny)
  return triangles.cut(nx, ny, function(s, t) return { -0.8 + 1.6 * s, 2.3 + 0.5 * t, 0.2 + 1.5 * t } end)
end

local white, red = ylm.matte { albedo = 0.7 }, ylm.matte { albedo = { 0.6, 0.2, 0.1 } }
local geometry = {
  ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -3.5 }, material = white },
  ylm.quad { corner = { -2, 0, -1.5 }, u = { 4, 0, 0 }, v = { 0, 3, 0 }, material = white },
  ylm.knot { at = { -0.5, 0.62, 0 }, scale = 0.3, material = red },
  ylm.sphere { at = { 0.75, 0.4, 0.2 }, radius = 0.4, material = white },
}

local probes = ylm.uniform_grid { cells = { 7, 7, 7 }, lmax = 4 }

--- The picture without interpolation and, with `grid`, the one by an 8^3 grid; of other shapes than those above.
local function pictures(list, method, lmax, grid, radiance, shapes)
  local scene = ylm.scene "square of triangles" {
    camera = ylm.camera { from = { 0.3, 1.3, 3.4 }, at = { 0, 0.6, 0 }, fov = 42 },
    geometry = shapes or geometry, lights = triangles.lights(list, method, radiance or 3), probes = probes,
  }
  local view = scene:prepare { size = size, samples = quick and 1 or 4, lmax = lmax, visibility = "none", gloss = "sh" }
  local exact = view:render { by = "sum", layers = false }
  return exact, grid and (view:render { grid = scene:bake { occupied = "everywhere" }, layers = false })
end

--- 1000 times the mean absolute error where the largest value of the truth is 1.
local function mae(image, truth)
  local m = image:compare(truth)
  return 1000 * m.mae / m.peak
end

-- First block: glossy surfaces, under spheres. Truth is the slice f cos of GGX, to 5 bands, times coefficients of light at
-- every pixel.
print "Table 4, spheres: MAE x 1000 against coefficients at every pixel (paper's figure behind; ratio)"
print "  lights            ZH approx.                interp.      ZH / interp.     the glossy body alone: ZH, interp."

--- 1000 times the mean absolute errors of the zonal rival and of an 8^3 grid, over all surfaces and over object `glossy`.
local function block(scene, glossy)
  local view = assert(scene:prepare { size = size, samples = 1, lmax = 4, visibility = "none", gloss = "sh" })
  local truth, object = assert(view:render { by = "sum" }), view:points().object:totable()
  local picture = assert(view:render { grid = scene:bake { occupied = "everywhere", quantity = "lights" } })
  local rough = assert(view:render { by = "sum", method = "zonal" })
  local body, k = truth:layer "coverage":totable(), 0
  for _, line in ipairs(body) do
    for x, shown in ipairs(line) do
      if shown[1] > 0 then k = k + 1 end -- one sample a pixel: one point
      line[x] = shown[1] > 0 and object[k] == glossy and 1 or 0
    end
  end
  local all, one = common.surface_mask(ylm, truth), ylm.array(body, "float")
  local peak = truth:compare(truth, { mask = all }).peak
  local function error(image, mask) return 1000 * image:compare(truth, { mask = mask }).mae / peak end
  return error(rough, all), error(picture, all), error(rough, one), error(picture, one)
end

local coat = ylm.ggx { alpha = 0.35, f0 = { 0.5, 0.6, 0.7 } }
local metal = { geometry[1], geometry[2], ylm.knot { at = { -0.5, 0.62, 0 }, scale = 0.3, material = coat }, geometry[4] }
local printed_spheres = { [288] = { 1.866, 0.192 }, [512] = { 1.865, 0.192 }, [800] = { 1.865, 0.193 }, [722] = { 1.54, 0.079 } }
for _, n in ipairs(quick and { 288 } or { 288, 512, 800, 722 }) do
  local scene
  if n ~= 722 then scene = scenes.pair(quick and 12 or 64, coat, (scenes.dome(n, 20, 0.1, 4, 0.2, 0.65)))
  else
    scene = ylm.scene "white room" { camera = ylm.camera { from = { 0.3, 1.3, 3.4 }, at = { 0, 0.6, 0 }, fov = 42 },
      lights = triangles.lights(square(19, 19), "bare", 3), geometry = metal, probes = probes }
  end
  local z, g, zg, gg = block(scene, 3)
  local p = printed_spheres[n]
  print(("%8d %9.3f (%.3f; %6.2f) %9.3f (%.3f; %6.2f) %8.1f (%.1f) %22.3f %9.3f"):format(n, z, p[1], z / p[1], g, p[2],
    g / p[2],
    z / g, p[1] / p[2], zg, gg))
end
print "  ZH approx.: misses the cosine over the lobe's width and, here, what is not symmetric of the slice; the paper's lobe is"
print "  symmetric in its truth too. As there, the number of lights changes nothing. Means are over pixels that show surfaces."
print "  interp.: an 8^3 grid errs as lamps are near, in voxels; the paper's are nearer than this dome."
local printed = {
  [288] = { 15.86, 0.096, 15.93, 0.215 }, [512] = { 15.76, 0.068, 15.83, 0.165 },
  [800] = { 15.67, 0.121, 15.75, 0.174 }, [722] = { 62.08, 0.129, 62.13, 0.176 },
}

print "Table 4: MAE x 1000 against exact triangles (paper's figure behind)"
print "  lights           spheres   triangles approx.    spheres interp.    approx. interp."
for _, n in ipairs(quick and { 4 } or { 12, 16, 20, 19 }) do
  local list = square(n, n)
  local truth, truth_grid = pictures(list, "exact", 4, true)
  local bare, bare_grid = pictures(list, "bare", 4, true)
  local rough, rough_grid = pictures(list, "sphere", 4, true)
  local row = { mae(bare, truth), mae(rough, truth), mae(bare_grid, truth_grid), mae(rough_grid, truth_grid) }
  local p = printed[#list] or {}
  for i = 1, 4 do row[i] = ("%9.3f (%s)"):format(row[i], p[i] and ("%.3f"):format(p[i]) or "-") end
  print(("%8d %s"):format(#list, table.concat(row, " ")))
  if n == 19 or quick then
    local exposure = -math.log(truth:compare(truth).peak) / math.log(2)
    local function shown(image, caption) return { image = image, caption = caption, exposure = exposure, tone = "srgb" } end
    common.save(ylm.figure {
      title = ("A square light of %d triangles"):format(#list),
      rows = { { shown(truth, "exact triangles"),
        shown(bare:difference(truth, { scale = 100 }), "spheres: 100 × |difference|"),
        shown(rough:difference(truth, { scale = 100 }), "spheres × |cos γ|: 100 × |difference|") } },
    }, out .. "gradient_2022_fig12.png")
  end
end

print "Fig. 16: 36 triangles, by bands: MAE x 1000 of the approximation (the paper: about the same from 5 to 9 bands)"
print "             matte    a knot of metal, GGX of alpha 0.35"
local few = square(6, 3)
for bands = 1, quick and 3 or 9 do
  local truth, rough = pictures(few, "exact", bands - 1), pictures(few, "sphere", bands - 1)
  local shiny, dull
  if not quick or bands == 3 then
    shiny, dull = pictures(few, "exact", bands - 1, nil, nil, metal), pictures(few, "sphere", bands - 1, nil, nil, metal)
  end
  print(("%3d bands %9.3f %9s"):format(bands, mae(rough, truth), shiny and ("%.3f"):format(mae(dull, shiny)) or "-"))
end

-- Fig. 17: narrow triangles of one area, and large ones; below each ten times the error.
print "Fig. 17: one triangle, 5 bands: MAE x 1000 of the approximation"
local narrow, large = {}, {}
for _, stretch in ipairs { 1, 4, 16 } do
  narrow[#narrow + 1] = { ("%d : 1"):format(stretch), triangles.stretched(0.3, stretch, 0, 1.9, 0.6), 5 }
end
for _, edge in ipairs { 0.4, 0.8, 1.6 } do
  large[#large + 1] = { ("edge %.1f"):format(edge), triangles.equilateral(edge, 0, 1.9, 0.5), 0.7 / edge ^ 2 }
end
local w, h, gap = size[1], size[2], 6
local black = ylm.image { size = size }
local sheet = ylm.image { size = { 3 * (w + gap) - gap, 4 * (h + gap) - gap } }
sheet:fill(1, 1, sheet.size[1], sheet.size[2], 1)
for row, cases in ipairs { narrow, large } do
  for column, case in ipairs(cases) do
    local truth = pictures({ case[2] }, "exact", 4, false, case[3])
    local rough = pictures({ case[2] }, "sphere", 4, false, case[3])
    print(("%10s %9.3f"):format(case[1], mae(rough, truth)))
    local x, y, peak = 1 + (column - 1) * (w + gap), 1 + (2 * row - 2) * (h + gap), truth:compare(truth).peak
    sheet:paste(truth:difference(black, { scale = 1.2 / peak }), x, y)
    sheet:paste(rough:difference(truth, { scale = 12 / peak }), x, y + h + gap)
    if not quick then
      sheet:text(x + 8, y + 8, case[1], { scale = 2, colour = 1 })
      sheet:text(x + 8, y + h + gap + 8, "10 x error", { scale = 2, colour = 1 })
    end
  end
end
common.save(sheet, out .. "gradient_2022_fig17.png", { tone = "srgb" })
