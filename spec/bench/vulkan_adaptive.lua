-- Adaptive grids with a threshold and with a tolerance, on every Vulkan device and by the processor: seconds of their stages
-- side by side. A floor and a sphere of 2 x 10^5 shading points, 1000 lamps over them, lmax 4, rgb, depth 7.
--
--     make bench-vulkan
--
-- The device's stages are of its timestamps, upload and download of the host's clock; "the rest" is what the host waits
-- and does beside them. The processor uses all of its threads.

local bench_lamps = require "spec.bench.lamps"
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local LIGHTS, POINTS, TIMES = quick and 100 or 1000, 200000, quick and 1 or 3

local random = bench_lamps.random
local lamps = bench_lamps.over_floor(LIGHTS, 0.3)

local occupied = ylm.zeros({ POINTS, 3 }, "float")
for i = 1, POINTS do
  local x, y, z = 4 * random() - 2, 0, 4 * random() - 2
  if i % 4 == 0 then
    local c, turn = 2 * random() - 1, 2 * math.pi * random()
    local s = 0.5 * math.sqrt(1 - c * c)
    x, y, z = s * math.cos(turn), 0.5 + 0.5 * c, s * math.sin(turn)
  end
  occupied:set(i, 1, x)
  occupied:set(i, 2, y)
  occupied:set(i, 3, z)
end
local bounds = { { -2, -0.5, -2 }, { 2, 3.5, 2 } }
local forms = {
  { "threshold 1.2", ylm.adaptive_grid { bounds = bounds, lmax = 4, depth = 7, metric = "relative", threshold = 1.2 } },
  { "tolerance 0.01", ylm.adaptive_grid { bounds = bounds, lmax = 4, depth = 7, tolerance = 0.01 } },
}

--- The grid's seconds by stage, of the fastest of some bakes; the first, which compiles, left out.
local function fastest(form, lights, stages_of, gpu)
  local best
  for i = 0, TIMES do
    if gpu then bench_lamps.wake(gpu) end
    local grid = assert(ylm.bake(form, lights, { occupied = occupied }))
    local stages = stages_of(grid.stats)
    stages.all, stages.grid = grid.stats.seconds, grid.stats
    if i > 0 and (not best or stages.all < best.all) then best = stages end
    grid:close()
  end
  return best
end

local function by_processor(s)
  return { occupancy = s.occupancy_seconds, points = s.lattice_seconds, sums = s.field_seconds,
    residuals = s.residual_seconds, continuity = s.continuity_seconds }
end

local SUMS = { "clearing", "lights", "adding", "coefficients", "metric" }

local function on_device(s)
  local function of(name) return s.stages[name] and s.stages[name].seconds or 0 end
  local out = { occupancy = of "occupancy", points = of "points", sums = 0, crossing = of "crossing",
    subdivide = of "subdivide", copies = of "upload" + of "download", residuals = of "residuals",
    continuity = s.continuity_seconds + of "continuity" }
  for _, name in ipairs(SUMS) do out.sums = out.sums + of(name) end
  return out
end

local COLUMNS = { "occupancy", "points", "sums", "crossing", "subdivide", "copies", "residuals", "continuity" }

local function row(name, stages)
  local cells, rest = {}, stages.all
  for i, column in ipairs(COLUMNS) do
    local x = stages[column]
    cells[i] = x and ("%10.2f"):format(x * 1e3) or (" "):rep(9) .. "-"
    rest = rest - (x or 0)
  end
  print(("%-28.28s %s %9.2f %9.1f"):format(name, table.concat(cells, " "), rest * 1e3, stages.all * 1e3))
end

--- The traffic of a bake, and of the first sampling of points that are on the device.
local function traffic(gpu, form, lights)
  local points = gpu:array(occupied)
  local before = gpu.stats
  local grid = assert(ylm.bake(form, lights, { occupied = occupied }))
  local baked = gpu.stats
  assert(grid:sample(points, { device = gpu }))
  local function mib(now, was) return (now - was) / 2 ^ 20 end
  print(("%28s %.2f MiB up, %.2f down in a bake, %.2f up to sample it there; rows are %.2f"):format("",
    mib(baked.uploaded, before.uploaded), mib(baked.downloaded, before.downloaded), mib(gpu.stats.uploaded, baked.uploaded),
    (grid.stats.points + grid.stats.interpolated) * 4 * 3 * 25 * 4 / 2 ^ 20))
  grid:close()
  points:close()
end

local devices, message = ylm.vulkan.devices()
if not devices then return print("no Vulkan device: " .. message) end
for _, f in ipairs(forms) do
  local name, form = f[1], f[2]
  local here = fastest(form, lamps, by_processor)
  print(("An adaptive grid, %s: %d shading points, %d lights, %d grid points, %d cells, milliseconds"):format(name, POINTS,
    LIGHTS, here.grid.points, here.grid.cells))
  print((" "):rep(28) .. "  occupancy     points       sums   crossing  subdivide     copies  residuals continuity  the rest"
    .. "       all")
  row("this processor", here)
  for i, device in ipairs(devices) do
    if device.usable then
      local gpu, why = ylm.vulkan.open { device = i }
      if gpu then
        local lights = gpu:lights(lamps)
        local there = fastest(form, lights, on_device, gpu)
        assert(math.abs(there.grid.points - here.grid.points) <= 0.01 * here.grid.points)
        row(gpu.name, there)
        traffic(gpu, form, lights)
        gpu:close()
      else print(device.name .. ": " .. why) end
    end
  end
end
