-- Frames of an image on every Vulkan device: bake + sample + shade + filter at 1920 x 1080 under 1793 lights that move,
-- lmax 4, rgb: what Mezieres et al. 2022 show in their Fig. 1 (RTX 2080: bake 5.30 ms, interpolation 6.73 ms, 77 frames a
-- second). From the 8^3 grid with gradients of that paper, and from an adaptive one, refined on the device.
--
--     make bench-vulkan
--
-- The view's points stay on the device; in a frame lights travel up and the image down. Device times are of timestamps,
-- "up" and "down" of the host's clock; the frame's wall time has everything that the host does and waits for, processor time
-- that of a driver in software too. The fastest of some frames; on a driver in software one, after one that compiles.

local bench_lamps = require "spec.bench.lamps"
local core = require "ylm.c.core"
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local LIGHTS = 1793
local full, small = { 1920, 1080 }, { 192, 108 }

local lamps = bench_lamps.over_floor(LIGHTS, 1)
local scene = ylm.scene "bench" {
  camera = ylm.camera { from = { 0, 1.6, 2.6 }, at = { 0, 0.1, 0 }, fov = 60 },
  geometry = { ylm.quad { corner = { -4, 0, 4 }, u = { 8, 0, 0 }, v = { 0, 0, -8 } },
    ylm.sphere { at = { 0, 0.4, 0 }, radius = 0.4 } },
}
local bounds = { { -4.1, -0.1, -4.1 }, { 4.1, 0.9, 4.1 } }
local GRIDS = {
  { "8^3", ylm.uniform_grid { bounds = bounds, cells = 7, lmax = 4, metric_channels = "none" } },
  { "adaptive", ylm.adaptive_grid { bounds = bounds, lmax = 4, depth = 5, metric = "relative", threshold = 1.2 } },
}

--- Seconds of stages together, but of copies; and of the longest dispatch, with its stage.
local function sum(stages)
  local seconds, longest, where = 0, 0, "none"
  for name, s in pairs(stages) do
    if name ~= "upload" and name ~= "download" then
      seconds = seconds + s.seconds
      if s.longest > longest then longest, where = s.longest, name end
    end
  end
  return seconds, longest, where
end

local function of(stages, name) return stages[name] and stages[name].seconds or 0 end

--- One frame: its seconds by what they are for.
local function frame(gpu, form, prepared, occupied)
  local before, start, cpu = gpu.stats, core.seconds(), os.clock()
  local there = gpu:lights(lamps)
  local grid = assert(ylm.bake(form, there, { occupied = occupied }))
  local copy = grid:to(gpu)
  local _, report = assert(prepared:render { grid = grid, device = gpu, layers = false })
  local all, after, s = core.seconds() - start, gpu.stats, report.stages
  cpu = os.clock() - cpu
  local bake, longest, where = sum(grid.stats.stages)
  local _, other, there_too = sum(s)
  if other > longest then longest, where = other, there_too end
  local out = { points = report.points, grid_points = grid.stats.points, bake = bake, locate = of(s, "locate"),
    sort = of(s, "sort"), shade = of(s, "shade"), filter = of(s, "filter"), longest = longest, where = where,
    up = after.upload_seconds - before.upload_seconds, down = after.download_seconds - before.download_seconds,
    bytes_up = after.uploaded - before.uploaded, bytes_down = after.downloaded - before.downloaded, all = all, cpu = cpu }
  out.sample = out.locate + out.sort + out.shade
  out.device = out.bake + out.sample + out.filter
  copy:close()
  there:close()
  grid:close()
  return out
end

local function row(name, size, f)
  local function ms(x) return ("%9.2f"):format(x * 1e3) end
  print(("%-10s %4dx%-4d %8d %7d %s %s %s %s %s  %s %s %s %8.2f %8.2f   %.1f ms, %s"):format(name, size[1], size[2], f.points,
    f.grid_points, ms(f.bake), ms(f.locate + f.sort), ms(f.shade), ms(f.filter), ms(f.device), ms(f.up), ms(f.down), ms(f.all),
    1 / f.device, 1 / f.all, f.longest * 1e3, f.where))
  print(("%-10s %.2f MB up, %.2f MB down, %.0f ms of processor time"):format("", f.bytes_up / 1e6, f.bytes_down / 1e6,
    f.cpu * 1e3))
end

local function bench(gpu)
  local software = gpu.type == "cpu"
  print(("%s (%s)"):format(gpu.name, gpu.type))
  if software then print "a driver in software: its figures say nothing of a GPU" end
  local views = { assert(scene:prepare { size = small, samples = 1, visibility = "none" }) }
  views[2] = not quick and assert(scene:prepare { size = full, samples = 1, visibility = "none" }) or nil
  print("grid       picture     points  probes   bake ms loc.+sort     shade    filter    device        up      down      wall"
    .. "  fps dev.     wall   longest dispatch")
  for _, grid in ipairs(GRIDS) do
    local name, form = grid[1], grid[2]
    for i, view in ipairs(views) do
      local occupied, best = name == "adaptive" and view or nil, nil
      if grid == GRIDS[1] or i == 1 then frame(gpu, form, view, occupied) end -- compiles, and copies what stays
      for _ = 1, (quick or software) and 1 or 10 do
        bench_lamps.wake(gpu)
        local f = frame(gpu, form, view, occupied)
        if not best or f.device < best.device then best = f end
      end
      row(name, i == 1 and small or full, best)
    end
  end
  print "2022       1920x1080                      5.30 (bake)    6.73 (interpolation)                      77 (RTX 2080)"
end

local devices, message = ylm.vulkan.devices()
if not devices then return print("no Vulkan device: " .. message) end
print(("Frames under %d lights, lmax 4, rgb"):format(LIGHTS))
for i, device in ipairs(devices) do
  if device.usable then
    local gpu, why = ylm.vulkan.open { device = i }
    if gpu then
      bench(gpu)
      gpu:close()
    else print(device.name .. ": " .. why) end
  end
end
