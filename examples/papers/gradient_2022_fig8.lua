-- Mezieres et al. 2022 (gradient), Fig. 8: a matte figure and a glossy body under 242 lights. Pictures are (a) by rays to the
-- lights, (b) by spherical harmonics at every pixel, (c) by an 8^3 grid; and the error of (b) by the number of bands.
--
--     lua examples/papers/gradient_2022_fig8.lua [--out DIR] [--size 400] [--samples 100] [--quick]
--
-- Writes gradient_2022_fig8.png. --samples is the paper's "100 importance samples for each light"; rays here go to lights as each
-- matters to a point, 16 times so many in two pictures, without shadows, as there. Two, so that their noise adds nothing to
-- errors: e^2 = mean of (b - a1) (b - a2). Meshes stand in for Buddha and Armadillo,
-- whose scene, lights and material are not published. The paper's picture has no numbers but those of Tables 3 and 4.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, scenes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")

local option = common.options { out = "out", size = 400, samples = 100, quick = false }
local out, quick = option.out, option.quick
local size = quick and { 20, 20 } or { option.size, option.size }
local alpha = 0.35
local glossy = ylm.ggx { alpha = alpha, f0 = { 0.55, 0.62, 0.7 } }

ylm.on_warning(false) -- of light that passes occluders: the paper has no shadows either
local scene = scenes.pair(quick and 12 or 160, glossy, (scenes.dome(242, 20, 0.1, 4, 0.2, 0.65)))

--- A prepared view of `bands` bands.
local function prepare(bands)
  return assert(scene:prepare { size = size, samples = quick and 1 or 4, lmax = bands - 1, visibility = "none", gloss = "sh" })
end

-- Masks: pixels of the glossy body, and all others that surfaces fill.
local first = prepare(5)
local rays = { by = "rays", visibility = "none", light_samples = quick and 64 or 8 * option.samples }
local truth, told = first:render(rays)
rays.seed = 2
local a1, a2 = truth:layer():clone(), first:render(rays):layer()
local body = ylm.scene "body" { camera = scene.camera, geometry = scene.geometry[3] }
local covered = body:prepare({ size = size, samples = quick and 1 or 4, visibility = "none", lmax = 0 }):render { by = "sum" }
local bodies, surface = covered:layer "coverage"[{ {}, {}, 1 }], common.surface_mask(ylm, truth)
local glosses, rest = surface * bodies:greater(0.999), surface * bodies:less_equal(0)

--- Root mean square error of an image over that of the rays, in percent; noise of the rays adds nothing to it.
local function error_of(image, mask)
  local p, u, v = image:layer():select(mask), a1:select(mask), a2:select(mask)
  return 100 * math.sqrt(math.max(0, ((p - u) * (p - v)):sum()) / (u * v):sum())
end

print(("%d x %d, %s shading points; twice %d rays from each: %.1f s"):format(size[1], size[2],
  common.thousands(told.points), rays.light_samples, 2 * told.seconds.light))
print(("GGX alpha %g; %% is rms of the difference over rms; MAE x 1000 where the largest value is 1"):format(alpha))
local row = common.table { { "bands", "%5d" }, { "seconds", "%7.2f" }, { "by grid", "%7.2f" }, { "matte: b - a %", "%14.2f" },
  { "gloss: b - a %", "%14.2f" }, { "slice, 45 deg %", "%15.2f" }, { "c - b, MAE x 1000", "%17.4f" }, { "paper", "%6.3f" },
  { "ratio", "%6.3f" } }
local slices = glossy:table { lmax = quick and 5 or 20 }
local shown = {}
for _, bands in ipairs(quick and { 5 } or { 5, 9, 15, 21 }) do
  local view = bands == 5 and first or prepare(bands)
  local b, how = view:render { by = "sum" }
  local grid = scene:bake { probes = ylm.uniform_grid { cells = 7, lmax = bands - 1, metric_channels = "none" },
    quantity = "lights",
    occupied = "everywhere" }
  local c, fast = view:render { grid = grid }
  local matte, gloss = error_of(b, rest), error_of(b, glosses)
  local m = c:compare(b, { mask = common.surface_mask(ylm, truth) })
  local between = 1000 * m.mae / m.peak
  row { bands, how.seconds.light, fast.seconds.light, matte, gloss,
    100 * slices:missed(bands - 1, { math.sqrt(0.5), 0, math.sqrt(0.5) }):get(1), between, bands == 5 and 0.192 or nil,
    bands == 5 and between / 0.192 or nil }
  if bands == 5 or bands == 15 then shown[#shown + 1] = { b = b, c = c, bands = bands, gloss = gloss } end
end
print "Why they differ. matte: the cosine has little beyond degree 2. gloss: the slice is cut at the bands, as the paper says of"
print "  its Armadillo; light from all around hides most of what a slice misses. c - b: lamps are 3.7 m away here, voxels 0.6 m;"
print "  an 8^3 grid errs as lamps are near, and the paper's layout is not published."

truth:layer()[{}] = (a1 + a2) / 2 -- the picture shows both
local peak = truth:compare(truth, { mask = rest }).peak
local exposure, scale = -math.log(peak) / math.log(2), 5
local function picture(image, caption) return { image = image, tone = "srgb", exposure = exposure, caption = caption } end
local rows = { { picture(truth, "(a) rays"),
  picture(shown[1].b, "(b) 5 bands, every pixel"), picture(shown[1].c,
  "(c) 5 bands, 8³ grid") } }
local function values(a, b, more) return common.error_values(a:difference(b, { scale = (more or 1) * scale / peak })) end
local bar = { range = { 0, 1 }, map = "magma", label = ("%d × |difference| / largest value"):format(scale) }
rows[2] = { { values = values(shown[#shown].b, truth), caption = ("(b) of %d bands - (a)"):format(shown[#shown].bands) },
  { values = values(shown[1].b, truth), caption = "(b) - (a)" }, { values = values(shown[1].c, shown[1].b, 1000),
    caption = "(c) - (b), 1000 times as bright" } }
common.save(ylm.figure { title = "A matte and a glossy body under 242 lights, without shadows", rows = rows, bar = bar,
  caption = ("Meshes made here, GGX of alpha %g. Harmonics lose most on the glossy body: %.0f %% (rms) at 5 bands. "
    .. "Speckles are the rays' noise."):format(
    alpha, shown[1].gloss) }, out .. "gradient_2022_fig8.png")
