-- Xin et al. 2021, Fig. 7: shadow fields and SHEXP behind bodies that are thin, and behind balls that overlap, beside paths.
--
--     lua examples/papers/products_2021_fig7.lua [--out DIR] [--size 320] [--paths 1024] [--spheres 96] [--quick]
--
-- Writes products_2021_fig7.png. (a) stands in for Spider & Scorpion, n = 10: legs and a tail of convex parts, exactly for
-- products; SHEXP has --spheres spheres in their place, as has ylm's union of spheres. (b) stands in for Ball & DNA, n = 15:
-- balls that overlap, the same for all methods. Errors are of the floor, root mean square in % of that without bodies, the
-- noise of paths taken away. The paper prints no errors: it says that thin antennae "cannot be well approximated using set of
-- spheres".

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common, shadows = dofile(here .. "../common.lua"), dofile(here .. "shadows_2021.lua")

local option = common.options { out = "out", size = 320, paths = 1024, spheres = 96, threads = 2, quick = false }
local quick = option.quick
ylm.on_warning(false)

local line = common.table { { "scene", "%-30s" }, { "n", "%3d" }, { "method", "%-20s" }, { "rms error %", "%11.3g" },
  { "over one rule", "%13.3g" }, { "seconds", "%8.3f" }, { "points", "%8d" }, { "probes", "%7d" } }
local rows = {}
for k, n in ipairs(quick and { 2, 4 } or { 10, 15 }) do
  local case = k == 1 and shadows.spider(quick and 24 or option.spheres) or shadows.helix(quick and 4 or 14)
  local pictures, errors, results = shadows.compare(case, { n = n, size = quick and { 12, 9 } or { option.size,
    math.floor(0.75 * option.size) }, samples = quick and 1 or 4, paths = quick and 16 or option.paths, rays = quick and 16 or 64,
    threads = option.threads, depth = quick and 2 or 9 })
  local base
  for _, r in ipairs(results) do if r[1] == "one rule" then base = r[2] end end
  for _, r in ipairs(results) do line { case.name, n, r[1], r[2], r[2] and r[2] / base, r[3], r[4], r[5] } end
  if case.report then
    print(("(a) by spheres: %.0f %% of the bodies' volume is outside of them, %.0f %% of it is added"):format(
      100 * case.report.uncovered / case.report.volume, 100 * case.report.outside / case.report.volume))
  end
  pictures[1].caption = ("(7%s), n = %d: "):format(k == 1 and "a" or "b", n) .. pictures[1].caption
  rows[#rows + 1], rows[#rows + 2] = pictures, errors
end
common.save(ylm.figure { title = "Shadows of thin bodies and of balls that overlap", rows = rows },
  option.out .. "products_2021_fig7.png")
print "Bodies that touch multiply in products, which darkens their common edges; unions have no such error, but spheres for legs."
