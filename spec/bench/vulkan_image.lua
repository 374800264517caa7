-- Frames of an image on every Vulkan device: bake + sample + shade at 1920 x 1080 under 1793 lights, lmax 4, rgb, 8^3
-- grid: what Mezieres et al. 2022 show in their Fig. 1 (RTX 2080: bake 5.30 ms, interpolation 6.73 ms, 77 frames a second).
--
--     make bench-vulkan
--
-- Points, transfer vectors and albedo stay on the device between frames. Times are of the device's timestamps; the copy of
-- radiance to the host stands apart, and what the host does is left out.

local bench_lamps = require "spec.bench.lamps"
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local LIGHTS, FRAMES = 1793, quick and 2 or 5
local full, small = { 1920, 1080 }, { 192, 108 } -- small: quick, and for drivers in software

local lamps = bench_lamps.over_floor(LIGHTS, 1)
local scene = ylm.scene "bench" {
  camera = ylm.camera { from = { 0, 1.6, 2.6 }, at = { 0, 0.1, 0 }, fov = 60 },
  geometry = { ylm.quad { corner = { -4, 0, 4 }, u = { 8, 0, 0 }, v = { 0, 0, -8 } },
    ylm.sphere { at = { 0, 0.4, 0 }, radius = 0.4 } },
  lights = lamps,
}
local form = ylm.uniform_grid { bounds = { { -4.1, -0.1, -4.1 }, { 4.1, 0.9, 4.1 } }, cells = 7, lmax = 4,
  metric_channels = "none" }

--- Seconds of all stages together but copies.
local function sum(stages)
  local seconds = 0
  for name, s in pairs(stages) do
    if name ~= "upload" and name ~= "download" then seconds = seconds + s.seconds end
  end
  return seconds
end

local function bench(gpu, size)
  local prepared = assert(scene:prepare { size = size, samples = 1, visibility = "none" })
  local there = gpu:lights(lamps)
  local best
  for i = 0, FRAMES do
    local grid = assert(ylm.bake(form, there))
    local _, report = assert(prepared:render { grid = grid, device = gpu, layers = false })
    local s = report.stages
    local frame = { bake = sum(grid.stats.stages), sample = sum(s), locate = s.locate.seconds, sort = s.sort.seconds,
      shade = s.shade.seconds, copy = s.download.seconds }
    frame.total = frame.bake + frame.sample
    if i > 0 and (not best or frame.total < best.total) then best = frame end
  end
  print(("%-36s %d x %d: bake %8.2f ms, locate %7.2f, sort %7.2f, sample + shade %8.2f: %7.2f frames a second; copy %.2f ms")
    :format(gpu.name, size[1], size[2], best.bake * 1e3, best.locate * 1e3, best.sort * 1e3, best.shade * 1e3,
      1 / best.total, best.copy * 1e3))
end

local devices, message = ylm.vulkan.devices()
if not devices then return print("no Vulkan device: " .. message) end
print(("Frames under %d lights (2022, 1920 x 1080: bake 5.30 ms, interpolation 6.73 ms, 77 frames a second)"):format(
  LIGHTS))
for i, device in ipairs(devices) do
  if device.usable then
    local gpu, why = ylm.vulkan.open { device = i }
    if gpu then bench(gpu, (quick or gpu.type == "cpu") and small or full) else print(device.name .. ": " .. why) end
  end
end
