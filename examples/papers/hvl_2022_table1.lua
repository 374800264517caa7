-- Mezieres & Paulin 2022 (harmonics virtual lights), Table 1: time of gathering, by number of lights and bands of the
-- convolution; emission of three bands.
--
--     lua examples/papers/hvl_2022_table1.lua [--width 320] [--threads 0] [--scene FILE] [--quick]
--
-- Nanoseconds of a pair of a light and a shading point, beside the paper's: milliseconds of 1280 x 1024 pixels on its card.
-- The atrium stands in for the teaser's. "sum" are the N^2 coefficients of light at a shading point, the paper's work but for
-- one dot product a pixel; "zonal" is irradiance at a view's points, which needs no harmonics (Appendix B, exactly). --threads 0
-- means all.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")

local option = common.options { width = 320, threads = 0, scene = "", quick = false }
local quick, threads = option.quick, option.threads > 0 and option.threads or nil
local clock = require "ylm.c.core".seconds
ylm.on_warning(false)

local printed = { -- lights: ms at 3, 5, 7, 9 bands
  [64] = { 6.6, 7.8, 10.3, 18.6 }, [196] = { 19.8, 23.5, 30.4, 56.1 }, [400] = { 41.0, 48.6, 62.7, 115.3 },
}
local PIXELS = 1280 * 1024
local width = quick and 40 or option.width
local scene = rooms.given(option.scene, "atrium", { detail = quick and 0.3 or 1 })
local view = assert(scene:prepare { size = { width, math.floor(0.8 * width) }, samples = 1, visibility = "none",
  threads = threads })
local points = view:points().position

--- `n` of the scene's lights, of profile cap, and the same with emissions of three bands.
local function lights_of(n)
  local some = assert(scene:virtual_lights { count = n, particles = 20 * n, profile = "cap", threads = threads })
  local at, normal, radius, emission = some:arrays()
  local rows = emission[{ {}, {}, { 1, 1 } }] * { 1, 0.1, -0.05, 0.08, 0.02, 0.03, -0.04, 0.01, 0.02 }
  return some, ylm.virtual_lights { at = at, normal = normal, radius = radius, emission = rows, profile = "cap" }
end

local runs = quick and 1 or 6
local row = common.table { { "lights", "%6d" }, { "bands", "%5d" }, { "sum, ns", "%8.3f" }, { "paper", "%6.3f" }, { "ratio",
  "%5.1f" },
  { "degree 0, ns", "%12.3f" }, { "zonal, ns", "%9.3f" } }
local sums = {}
for _, n in ipairs(quick and { 64, 400 } or { 64, 196, 400 }) do
  local plain, lights = lights_of(n)
  sums[n] = {}
  for i, bands in ipairs { 3, 5, 7, 9 } do
    if not quick or i % 2 == 0 then
      local into
      local function ns(which)
        local ms = common.best(clock, runs, function()
          into = assert(ylm.light_field(bands - 1, which, points, { threads = threads, out = into }))
        end)
        return 1e6 * ms / (which.count * #points)
      end
      local sum, theirs = ns(lights), 1e6 * printed[n][i] / (n * PIXELS)
      local zonal = math.huge
      for _ = 1, runs do
        local _, report = assert(view:render { by = "none", bounced = plain, virtual = { lmax = bands - 1, sums = "all" },
          threads = threads, layers = false })
        zonal = math.min(zonal, report.virtual.ns_per_pair)
      end
      sums[n][bands] = sum
      row { n, bands, sum, theirs, sum / theirs, ns(plain), zonal }
    end
  end
end
print(("9 over 5 bands: %.2f times (the paper's 2.37 with 400 lights; coefficients 3.24)"):format(sums[400][9] / sums[400][5]))
print(("a pair with 400 lights beside one with 64, 5 bands: %.2f times (the paper's 1.00): linear in lights"):format(
  sums[400][5] / sums[64][5]))
print(("%s points, %s threads. Why they differ:"):format(common.thousands(#points), threads or "all"))
print "  ratio: the card has 2,944 lanes at 1.5 GHz, a core 8 or 16, and it writes the coefficients of each point to memory."
print "  zonal: a product for each band instead of N^2 for each channel; lights are taken 512 at a time, so that 64 cost as many."
