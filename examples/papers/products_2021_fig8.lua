-- Xin et al. 2021, Fig. 8: shadow fields and SHEXP behind a body of detail in a hall, n = 15, beside paths.
--
--     lua examples/papers/products_2021_fig8.lua [--out DIR] [--size 320] [--paths 1024] [--spheres 128] [--mesh FILE] [--quick]
--
-- Writes products_2021_fig8.png. A knot stands in for the dragon; --mesh takes a closed mesh of your own, about 1.6 high over
-- y = 0. The body is --spheres spheres (ylm.sphere_set) for all methods; paths have the mesh, so that the spheres' own error
-- is in all numbers. Columns stand still and are in transfer vectors. The paper has 335,823 vertices here, 0.9 frames a second
-- (recursive) and prints no errors.

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common, shadows = dofile(here .. "../common.lua"), dofile(here .. "shadows_2021.lua")

local option = common.options { out = "out", size = 320, paths = 1024, spheres = 128, mesh = "", threads = 2, quick = false }
local quick = option.quick
ylm.on_warning(false)

local red = shadows.paint(0.6, 0.2, 0.12)
local body = option.mesh ~= "" and ylm.mesh { file = option.mesh, material = red }
  or ylm.knot { radius = 0.6, minor = 0.28, tube = 0.13, divide = quick and { 48, 8 } or { 400, 32 }, material = red,
    rotate = { axis = { 1, 0, 0 }, angle = 70 }, at = { 0, 0.85, 0 } }
local n = quick and 4 or 15
local case = shadows.hall(body, quick and 16 or option.spheres)
local pictures, errors, results = shadows.compare(case, { n = n, size = quick and { 20, 15 } or { option.size,
  math.floor(0.75 * option.size) }, samples = quick and 1 or 4, paths = quick and 16 or option.paths, rays = quick and 16 or 128,
  threads = option.threads, depth = quick and 3 or 9 })
local line = common.table { { "scene", "%-28s" }, { "n", "%3d" }, { "method", "%-20s" }, { "rms error %", "%11.3g" },
  { "over unions", "%11.3g" }, { "seconds", "%8.3f" }, { "points", "%8d" }, { "probes", "%7d" } }
for _, r in ipairs(results) do
  line { case.name, n, r[1], r[2], r[2] and r[2] / results[1][2], r[3], r[4], r[5] }
end
print(("%d spheres: %.1f %% of the body's volume is outside of them, %.1f %% of it is added"):format(#case.spheres.radius,
  100 * case.report.uncovered / case.report.volume, 100 * case.report.outside / case.report.volume))
pictures[1].caption = ("n = %d: "):format(n) .. pictures[1].caption
common.save(ylm.figure { title = "A body of spheres in a hall", rows = { pictures, errors } },
  option.out .. "products_2021_fig8.png")
print "The paper's dragon is not published: vertices, casters and light differ, so that seconds are no comparison. Errors are"
print "of one run, and include that of the spheres beside the body."
