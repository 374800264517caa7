-- From a scene script to a light grid, an image and a Hessian error volume: the whole path at once.
--
--     ylm run examples/01_floor_lights.lua                       (or: make demo)
--     ylm run examples/01_floor_lights.lua --mesh bunny.obj      a mesh instead of the knot
--
-- Bakes the lamps of examples/scenes/floor_lights.lua into an adaptive grid and renders with it. The grid is compared with
-- uniform grids and with the lights' own coefficients at every shading point. The program leaves in out/:
-- floor_lights.exr and .png, overview.png, comparison.png, hessian_error.png, gradients.png, lobes.png, tolerance.png,
-- grid.vtu. The table is Table 2 of Iwasaki & Dobashi 2025 for this scene.

local ylm = require "ylm"
local core = require "ylm.c.core"
local started = core.seconds()

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { mesh = "", out = "out", width = 1280, height = 720, samples = 9, tolerance = 0.01,
  exposure = 1.9, quiet = false, nopictures = false }
local out = option.out
local progress = not option.quiet or nil
local size, tone, exposure = { option.width, option.height }, "hable", option.exposure

local unpack = table.unpack or unpack -- luacheck: ignore 113

local function say(...) print(("\n" .. select(1, ...)):format(select(2, ...))) end

-- The scene ------------------------------------------------------------------------

--- The scene file, with a mesh of the user's in place of the knot: as large as it, standing on the floor.
local function load()
  local scene = assert(ylm.load(here .. "scenes/floor_lights.lua"))
  if option.mesh == "" then return scene end
  local lo, hi = unpack(assert(ylm.load(option.mesh)).bounds)
  local scale = 2.3 / math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3])
  scene.geometry[2] = ylm.mesh {
    file = option.mesh, scale = scale, material = scene.geometry[2].material,
    at = { -scale * (lo[1] + hi[1]) / 2, -scale * lo[2] + 0.005, -scale * (lo[3] + hi[3]) / 2 },
  }
  return scene
end

local scene = load()
local triangles = 0
for _, shape in ipairs(scene.geometry) do triangles = triangles + #shape.mesh:triangles() end
say("%s: %s triangles, %s lamps, %d x %d pixels, %d samples each", scene.name, common.thousands(triangles),
  common.thousands(#scene.lights), size[1], size[2], option.samples)

-- Everything that does not depend on how light is known is done once: all pictures share their points.
local view = assert(scene:prepare { size = size, samples = option.samples, visibility = "transfer", progress = progress })
local points = view:points().position
print(("%s shading points, %s occlusion rays: %.1f s"):format(common.thousands(#points),
  common.thousands(view.stats.occlusion_rays), view.stats.primary_seconds + view.stats.transfer_seconds))

-- The truth and the picture -----------------------------------------------------------

local function bake(probes, with)
  local fields = { probes = probes, occupied = view }
  for key, value in pairs(with or {}) do fields[key] = value end
  return assert(scene:bake(fields))
end

local truth, truth_report = view:render { by = "sum", progress = progress }
local mask = common.surface_mask(ylm, truth)

local function adaptive(fields)
  fields.lmax = 4
  return ylm.adaptive_grid(fields)
end

-- Uniform grids are baked as in earlier work: coefficients and gradients, no Hessian metric.
local function uniform(n) return ylm.uniform_grid { cells = n, lmax = 4, metric_channels = "none" } end

-- Cost is pairs x ns per pair: times of 20 ms are noise on a shared machine. The ns are measured here, once
-- for each of the two kernels: the least of seven bakes of 17^3 points, in turns.
local nanoseconds = { metric = math.huge, gradient = math.huge }
for i = 1, 14 do
  local name = i % 2 == 0 and "metric" or "gradient"
  local probes = ylm.uniform_grid { cells = 16, lmax = 4, metric_channels = name == "metric" and "luminance" or "none" }
  local stats = bake(probes, { occupied = "everywhere" }).stats
  nanoseconds[name] = math.min(nanoseconds[name], 1e9 * stats.field_seconds / stats.pairs)
end

--- Seconds of summing over lights for a grid's points.
local function cost(grid)
  return 1e-9 * grid.stats.pairs * (grid.metric_channels == "none" and nanoseconds.gradient or nanoseconds.metric)
end

--- One row of the table: renders with the grid and compares with the truth.
local rows = {}
local function try(name, depth, grid, keep)
  local image, report = assert(view:render { grid = grid, layers = keep or false, truth = keep and truth or nil })
  local error = image:compare(truth, { mask = mask })
  local row = { name = name, depth = depth, grid = grid, image = image, error = error, light = report.seconds.light }
  rows[#rows + 1] = row
  if not keep then row.grid = nil end
  row.points, row.pairs, row.seconds, row.cost = grid.stats.points, grid.stats.pairs, grid.stats.seconds, cost(grid)
  return row
end

local ours = try(("adaptive, tolerance %g"):format(option.tolerance), scene.probes.depth,
  bake(adaptive { depth = scene.probes.depth, tolerance = option.tolerance }, { progress = progress }), true)
local grid = ours.grid

-- Table 2 -------------------------------------------------------------------------------

for n = 3, 6 do
  local cells = 2 ^ n
  local everywhere = bake(uniform(cells), { occupied = "everywhere" })
  local all = try(("uniform %d^3, all voxels"):format(cells), n, everywhere, n == 4)
  local some = try(("uniform %d^3, shading voxels"):format(cells), n, bake(uniform(cells)))
  if n == 4 then rows.uniform16 = all end
  rows.last_uniform = some
end

--- How many points a uniform grid of n^3 has in shading voxels: counted by baking next to nothing.
local function uniform_points(n)
  return bake(ylm.uniform_grid { cells = n, lmax = 0, channels = "luminance", metric_channels = "none" }).stats.points
end

--- The uniform grid (shading voxels only) that costs what `row` costs, by ns per pair measured here.
local function equal_cost_uniform(row)
  local per_point = rows.last_uniform.cost / rows.last_uniform.points
  local n = common.nearest(4, 400, row.cost / per_point, uniform_points)
  return try(("uniform %d^3, shading, equal cost"):format(n), math.log(n) / math.log(2), bake(uniform(n)), true)
end

--- The adaptive grid of the paper's metric that costs no more than `row`, with the smallest threshold of the
-- greatest depth. (Voxels that a lamp's surface crosses are always refined, so a depth has a least cost.)
local function equal_cost_adaptive(row)
  for depth = 9, 3, -1 do
    local function baked(threshold)
      local g = bake(adaptive { depth = depth, metric = "relative", threshold = threshold })
      if cost(g) <= row.cost then return g end
      g:close()
    end
    local cheapest = baked(1e6)
    if cheapest then
      cheapest:close()
      local threshold, g = 8, nil
      while not g and threshold < 1e6 do
        threshold = threshold * 1.15
        g = baked(threshold)
      end
      if g then return try(("adaptive, E_rel <= %.3g"):format(threshold), depth, g, true) end
    end
  end
  error("no adaptive grid is as cheap as " .. row.name)
end

local rival = equal_cost_uniform(ours)
local cheap = equal_cost_adaptive(rows.uniform16)

say("Table 2 of the paper for this scene. Peak of PSNR %.3g; MAPE where the truth exceeds %.2g; lamps and night masked",
  ours.error.peak, ours.error.floor)
local put = common.table { { "grid", "%-36s" }, { "N", "%4.1f" }, { "points", "%9s" }, { "Mpairs", "%8.1f" },
  { "cost ms", "%8.0f" }, { "bake ms", "%8.0f" },
  { "shade ms", "%8.0f" }, { "MSE", "%9.2e" }, { "PSNR dB", "%7.1f" }, { "MAE", "%9.2e" },
  { "MAPE %", "%7.3f" } }
for _, r in ipairs(rows) do
  put { r.name, r.depth, common.thousands(r.points), r.pairs / 1e6, r.cost * 1e3, r.seconds * 1e3, r.light * 1e3,
    r.error.mse, r.error.psnr, r.error.mae, r.error.mape }
end
put { "reference: every shading point", nil, common.thousands(#points), truth_report.pairs / 1e6, nil, nil,
  truth_report.seconds.light * 1e3 }
print(("ns per pair: %.2f with the Hessian metric (adaptive), %.2f with gradients alone (uniform); RGB, %d threads"):format(
  nanoseconds.metric, nanoseconds.gradient, ylm.info().threads))
print(("tolerance %g: at 99 %% of held-out shading points the error is at most %.2g (%s)"):format(option.tolerance,
  grid.stats.error, grid.stats.met and "kept" or "not kept: depth " .. scene.probes.depth .. " is too little"))

io.stdout:flush()

-- Files -----------------------------------------------------------------------------------

assert(ours.image:save(out .. "floor_lights.exr"))
assert(ours.image:save(out .. "floor_lights.png", { tone = tone, exposure = exposure }))
assert(grid:save(out .. "grid.vtu"))
if option.nopictures then return end

-- Pictures ----------------------------------------------------------------------------------

say "Pictures"
-- The canopy would hide what is below it: pictures of the grid show the lamps near the floor, from above.
local low = {}
for _, lamp in ipairs(scene.lights) do
  if lamp.at[2] < 0.5 then low[#low + 1] = lamp end
end
local above = ylm.camera { from = { 6.2, 6.4, 9.0 }, at = { 0, 0.45, 0 }, fov = 38 }
local solid = { { mesh = scene.geometry[2].mesh, colour = { 0.80, 0.80, 0.82 } } }

local function save(picture, name) common.save(picture, out .. name) end

--- A view of the grid from above, or by the scene's own camera.
local function from_above(fields)
  fields[1], fields.camera, fields.meshes, fields.size = grid, above, solid, size
  return ylm.view(fields)
end

local function from_camera(fields)
  fields[1], fields.camera, fields.meshes, fields.lights, fields.size = grid, scene.camera, solid, low, size
  return ylm.view(fields)
end

local errors = { 1e-2, 10 }
save(from_above { quantity = "error", volume = true, slices = { axis = "y", at = 0 }, levels = true, lights = low,
  range = errors, log = true, title = "Hessian error of the adaptive grid",
  caption = ("Relative Hessian error of each leaf, lmax 4; slice on the floor; %s points, tolerance %g"):format(
    common.thousands(ours.points), option.tolerance) }, "hessian_error.png")
save(from_above { glyphs = true, lights = low, title = "Gradient of the light field",
  caption = "Arrows: gradient of L₀₀ (luminance) at points of the grid; dots: lamps near the floor" }, "gradients.png")
save(from_above { lobes = { count = 300 }, title = "What the probes remember",
  caption = "Luminance by direction at points of the grid, lmax 4: orange positive, blue negative" }, "lobes.png")

-- Requested tolerance against the error measured at held-out points, over three decades.
local asked, measured, counts = {}, {}, {}
for _, tolerance in ipairs { 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001 } do
  local g = bake(adaptive { depth = 12, tolerance = tolerance })
  asked[#asked + 1], measured[#measured + 1], counts[#counts + 1] = tolerance, g.stats.error, g.stats.points
  g:close()
end
save(ylm.plot { series = { { x = asked, y = measured, label = "measured at held-out shading points" } },
  diagonal = "requested", log = true, x_label = "requested tolerance", y_label = "99 % quantile of the relative error",
  title = "A tolerance on lighting error",
  caption = ("%s to %s grid points"):format(common.thousands(counts[1]), common.thousands(counts[#counts])) },
  "tolerance.png")

-- One image wiping through render, wireframe and error volume; below it crops at equal cost.
local panels = {
  ours.image,
  from_camera { levels = true, bar = false },
  from_camera { quantity = "error", volume = true, slices = { axis = "y", at = 0 }, range = errors, log = true,
    bar = false, frame = false },
}
local w, h = size[1], size[2]
local crop = { math.floor(0.30 * w), math.floor(0.60 * h), math.floor(0.25 * w), math.floor(0.25 * h) }

--- The largest channel of |image - truth| inside the crop, as numbers [h][w].
local function error_values(image)
  return common.error_values(image:difference(truth):crop(crop[1] + 1, crop[2] + 1, crop[3], crop[4]))
end

local function caption(name, r)
  return ("%s\n%.0f ms, %.1f Mpairs, %.1f dB"):format(name, r.cost * 1e3, r.pairs / 1e6, r.error.psnr)
end

local function shown(image, text)
  return { image = image, crop = crop, tone = tone, exposure = exposure, caption = text }
end

local function wipe(mark)
  return { wipe = panels, at = { 0.5, 0.7 }, labels = { "render", "octree levels", "Hessian error" }, tone = tone,
    exposure = exposure, mark = mark }
end
save(ylm.figure { rows = { { wipe() } }, margin = 0, width = size[1] }, "overview.png")

save(ylm.figure {
  rows = {
    { wipe(crop) },
    {
      shown(rows.uniform16.image, caption("uniform 16³", rows.uniform16)),
      shown(cheap.image, caption("adaptive, equal cost", cheap)),
      shown(ours.image, caption(("adaptive, tolerance %g"):format(option.tolerance), ours)),
      shown(truth, ("reference\n%.0f ms, %.1f Mpairs"):format(truth_report.seconds.light * 1e3,
        truth_report.pairs / 1e6)),
    },
    {
      { values = error_values(rows.uniform16.image), caption = "error of uniform 16³" },
      { values = error_values(cheap.image), caption = "error of adaptive, equal cost" },
      { values = error_values(ours.image), caption = "error within tolerance" },
      { values = error_values(rival.image), caption = caption("error of uniform at the cost of the tolerance", rival) },
    },
  },
  bar = { range = { 1e-5, 1e-1 }, log = true, map = "magma", label = "|radiance - reference|", unit = "W sr⁻¹ m⁻²" },
  width = size[1] + 48,
  title = "Remembering the light of 2516 lamps",
}, "comparison.png")
print(("done in %.0f s"):format(core.seconds() - started))
