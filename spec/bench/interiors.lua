-- Noise of the direct light of a room that is lit through a window, with guides and without.
--
--     make bench BENCH=interiors         build/ylm run spec/bench/interiors.lua [width height]
--
-- Noise is the root mean square difference of a pixel's luminance to that of 2,048 shadow rays of the same shading points,
-- relative to the mean of all light, bounces included, over 9 x 9 pixels around it. Efficiency is 1 / noise^2 / rays, the pilot's
-- rays included, relative to that without guides.

local ylm = require "ylm"
local room = dofile "spec/support/window_room.lua"(ylm)

local size = { tonumber(arg[1] or 192), tonumber(arg[2] or 108) }
local SEEDS, REACH = 3, 4

local function luminance(c) return 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end

local function luminances(image)
  local rows = image:layer("radiance"):totable()
  for _, row in ipairs(rows) do
    for x, c in ipairs(row) do row[x] = luminance(c) end
  end
  return rows
end

--- Means around each pixel.
local function around(rows)
  local out = {}
  for y = 1, size[2] do
    out[y] = {}
    for x = 1, size[1] do
      local sum, n = 0, 0
      for v = math.max(1, y - REACH), math.min(size[2], y + REACH) do
        for u = math.max(1, x - REACH), math.min(size[1], x + REACH) do sum, n = sum + rows[v][u], n + 1 end
      end
      out[y][x] = sum / n
    end
  end
  return out
end

ylm.on_warning(false)
local view = assert(room:prepare { size = size, samples = 4 })
local truth = luminances(view:render { bounces = 0, light_samples = 2048, seed = 99 })
local mean = around(luminances(room:render { size = size, samples = 4, light_samples = 256, rays = 128 }))
local covered = view:layer("coverage"):totable()

--- The noise of direct light, and rays of a picture.
local function measure(guides, light_samples)
  local square, n, rays = 0, 0, 0
  for seed = 1, SEEDS do
    local image, report = view:render { bounces = 0, guides = guides, light_samples = light_samples, seed = seed }
    rays = rays + (report.rays.shadow + (report.rays.guides or 0)) / SEEDS
    for y, row in ipairs(luminances(image)) do
      for x, l in ipairs(row) do
        if covered[y][x][1] > 0.99 then square, n = square + ((l - truth[y][x]) / mean[y][x]) ^ 2, n + 1 end
      end
    end
  end
  return math.sqrt(square / n), rays
end

print(("a room with a window, clear sky and sun: %d x %d, 4 samples, %d shading points"):format(size[1], size[2],
  view.stats.points))
print(("%7s %8s %9s %9s %11s"):format("guides", "rays a", "rays", "noise", "efficiency"))
print(("%7s %8s %9s %9s %11s"):format("", "point", "", "%", ""))
for _, light_samples in ipairs { 16, 32, 64 } do
  local cost
  for _, guides in ipairs { false, true } do
    local noise, rays = measure(guides, light_samples)
    cost = cost or noise ^ 2 * rays
    print(("%7s %8d %9.0f %9.2f %11.2f"):format(guides and "yes" or "no", light_samples, rays, 100 * noise,
      cost / (noise ^ 2 * rays)))
  end
end
