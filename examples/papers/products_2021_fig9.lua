-- Xin et al. 2021, Fig. 9: shadow fields and SHEXP behind bodies that are spheres, beside paths.
--
--     lua examples/papers/products_2021_fig9.lua [--out DIR] [--size 320] [--paths 1024] [--spheres 14] [--n 10] [--quick]
--
-- Writes products_2021_fig9.png. A floor is shaded at every shading point behind all spheres: by the exact product ("Our
-- acc."), two at a time ("Our recur."), by one rule (ylm's default), at probes, and by exponentials of sums of logarithms (Ren
-- et al. 2006). Errors are of the floor, root mean square in % of that without spheres, the noise of paths taken away. The
-- paper gives no errors for its Fig. 9, nor how many spheres it has: it says that SHEXP's "visual differences are still large"
-- and that its own method is "consistently faster" there (5.7 and 9.4 frames a second at n = 10, 2.1 and 4.3 at n = 15, 73,753
-- vertices, Table 2).

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common, shadows = dofile(here .. "../common.lua"), dofile(here .. "shadows_2021.lua")

local option = common.options { out = "out", size = 320, paths = 1024, spheres = 14, n = 0, threads = 2, quick = false }
local quick = option.quick
ylm.on_warning(false)

local line = common.table { { "n", "%3d" }, { "method", "%-20s" }, { "rms error %", "%11.3g" }, { "over one rule", "%13.3g" },
  { "seconds", "%8.3f" }, { "points", "%8d" }, { "probes", "%7d" } }
local rows = {}
for _, n in ipairs(quick and { 4 } or option.n > 0 and { option.n } or { 5, 10, 15 }) do
  local case = shadows.balls(quick and 4 or option.spheres)
  case.apart = true
  local pictures, errors, results = shadows.compare(case, { n = n, size = quick and { 24, 18 } or { option.size,
    math.floor(0.75 * option.size) }, samples = quick and 1 or 4, paths = quick and 32 or option.paths, rays = 64,
    threads = option.threads, depth = quick and 4 or 8 })
  local base
  for _, r in ipairs(results) do if r[1] == "one rule" then base = r[2] end end
  for _, r in ipairs(results) do line { n, r[1], r[2], r[2] and r[2] / base, r[3], r[4], r[5] } end
  if n > 5 or quick then
    pictures[1].caption = ("n = %d: "):format(n) .. pictures[1].caption
    rows[#rows + 1] = pictures
    rows[#rows + 1] = errors
  end
end
common.save(ylm.figure { title = "Shadows of spheres: products and exponentials beside paths", rows = rows },
  option.out .. "products_2021_fig9.png")
print "Seconds are of light at all shading points, of probes the bake too. The paper's are of a graphics card. Its Fig. 9 has"
print "no errors to stand beside these. PS diverges for spheres that look large at n = 15."
