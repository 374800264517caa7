-- Noise of interiors: of the direct light of a room that is lit through a window, with guides and without, and of paths; of
-- pictures of five rooms by default counts, before and after a filter, beside paths that take as long.
--
--     make bench BENCH=interiors         build/ylm run spec/bench/interiors.lua [width height]
--
-- Noise is the root mean square difference of a pixel's luminance to that of 2,048 shadow rays of the same shading points,
-- relative to the mean of all light, bounces included, over 9 x 9 pixels around it. Efficiency is 1 / noise^2 / rays, the
-- pilot's rays included, relative to that without guides; of paths by their variance, that of green, and by processor
-- seconds, too. Pictures of five rooms are compared with two of RAYS shadow rays and links at the same shading points and
-- elements: their noise, after the filter that of all seeds; the bias of their mean over SEEDS seeds; what the filter
-- changed of blocks of 32 x 32 pixels, root mean square and at worst, beside the sums of the raw pictures, which are
-- unbiased; and FLIP.

local ylm = require "ylm"
local room = dofile "spec/support/window_room.lua"(ylm)

local size = { tonumber(arg[1] or 192), tonumber(arg[2] or 108) }
local SEEDS, REACH, RAYS, BLOCK, PATHS = 3, 4, 256, 32, 128

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

--- The mean variance of a picture by paths, relative to the light around each pixel, and its rays.
local function vary(scene, guides, middle)
  local start = os.clock()
  local image, report = assert(scene:pathtrace { size = size, samples = PATHS, guides = guides })
  local seconds = os.clock() - start
  local sum, n, rays, variance = 0, 0, report.rays, image:layer("variance"):totable()
  for y, row in ipairs(middle) do
    for x, l in ipairs(row) do
      if l > 0 then sum, n = sum + variance[y][x][2] / l ^ 2, n + 1 end
    end
  end
  return sum / n, rays.nearest + rays.lamps + rays.shadow + (rays.guides or 0), seconds
end

--- A line about paths with guides and without.
local function line_of_paths(name, scene)
  local middle = around(luminances(scene:pathtrace { size = size, samples = PATHS, seed = 7 }))
  local before, cost, seconds = vary(scene, false, middle)
  local after, more, longer = vary(scene, true, middle)
  print(("%-9s %8.2f %8.2f %11.2f %11.2f"):format(name, 100 * math.sqrt(before), 100 * math.sqrt(after),
    before * cost / (after * more), before * seconds / (after * longer)))
end

--- Sums over blocks of an image's luminance.
local function blocks(rows)
  local out = {}
  for y, row in ipairs(rows) do
    for x, l in ipairs(row) do
      local k = math.floor((y - 1) / BLOCK) * 1000 + math.floor((x - 1) / BLOCK)
      out[k] = (out[k] or 0) + l
    end
  end
  return out
end

--- The difference of sums from the raw ones, relative to the exact ones: root mean square over blocks, and the largest.
local function block_bias(sums, raw, exact)
  local square, n, worst = 0, 0, 0
  for k, x in pairs(exact) do
    if x > 0 then
      local apart = (sums[k] - raw[k]) / x
      square, n, worst = square + apart ^ 2, n + 1, math.max(worst, math.abs(apart))
    end
  end
  return math.sqrt(square / n), worst
end

--- Luminance of surfaces: pixels that show a lamp or the sky are 0.
local function seen(image, layer, hidden)
  local rows = image:layer(layer):totable()
  for y, row in ipairs(rows) do
    for x, c in ipairs(row) do row[x] = hidden[y][x] and 0 or luminance(c) end
  end
  return rows
end

--- The noise of rows, relative to the light of surfaces around, by two exact pictures whose own noise cancels in the mean.
local function noise_of(rows, x)
  local square, n = 0, 0
  for y, row in ipairs(rows) do
    for k, l in ipairs(row) do
      local middle = x.middle[y][k] / x.part[y][k]
      if not x.hidden[y][k] and middle > 0 then
        square, n = square + (l - x.halves[1][y][k]) * (l - x.halves[2][y][k]) / middle ^ 2, n + 1
      end
    end
  end
  return math.sqrt(math.max(0, square / n))
end

--- Pixels of an image that do not show surfaces alone.
local function hidden_in(image)
  local cover, lamps, out = image:layer("coverage"):totable(), image:layer("emitter"):totable(), {}
  for y, row in ipairs(cover) do
    out[y] = {}
    for x, c in ipairs(row) do out[y][x] = c[1] < 0.99 or lamps[y][x][1] > 0 end
  end
  return out
end

local function line_of(name, scene)
  local half = ylm.zeros({ size[2], size[1] }, "float") + 0.5
  local lit = scene:links({ lmax = 0 }):radiosity()
  local function exactly(seed)
    return assert(scene:render { size = size, bounced = lit, light_samples = RAYS, rays = RAYS, seed = seed })
  end
  local best, again = exactly(98), exactly(99)
  local hidden = hidden_in(best)
  local x = { hidden = hidden, halves = { seen(best, "radiance", hidden), seen(again, "radiance", hidden) }, part = {} }
  best:paste(again, 1, 1, { mask = half })
  local exact, sums = seen(best, "radiance", hidden), { raw = {}, radiance = {} }
  for y, row in ipairs(hidden) do
    x.part[y] = {}
    for k, out in ipairs(row) do x.part[y][k] = out and 0 or 1 end
  end
  x.middle, x.part = around(exact), around(x.part)
  local noise, flip, says, seconds, z2, whole = { raw = 0, radiance = 0 }, { raw = 0, radiance = 0 }, 0, 0, 0, 0
  local exact_sums = blocks(exact)
  for _, sum in pairs(exact_sums) do whole = whole + sum end
  for seed = 1, SEEDS do
    local image, report = assert(scene:render { size = size, bounced = lit, denoise = "auto", seed = seed })
    says, seconds = says + report.noise / SEEDS, seconds + report.seconds.light / SEEDS
    z2 = z2 + (report.denoise and report.denoise.z2 or 0) / SEEDS
    for layer in pairs(noise) do
      local rows = seen(image, report.denoise and layer or "radiance", hidden)
      noise[layer] = noise[layer] + noise_of(rows, x) ^ 2 / SEEDS
      for k, sum in pairs(blocks(rows)) do sums[layer][k] = (sums[layer][k] or 0) + sum / SEEDS end
      local shown = ylm.image { size = size }
      shown:paste(image, 1, 1, { from = report.denoise and layer or "radiance" })
      flip[layer] = flip[layer] + shown:compare(best, { flip = "hdr" }).flip / SEEDS
    end
  end
  local total = 0
  for _, sum in pairs(sums.radiance) do total = total + sum end
  local paths = assert(scene:pathtrace { size = size, time_limit = seconds, samples = 65536 })
  local changed, worst = block_bias(sums.radiance, sums.raw, exact_sums)
  local of_paths = noise_of(seen(paths, "radiance", hidden), x)
  print(("%-9s %7.1f %7.2f %7.2f %5.2f %8.2f %8.2f %8.2f %8.3f %7.3f %9.1f %7.3f"):format(name, 100 * math.sqrt(noise.raw),
    100 * math.sqrt(noise.radiance), 100 * says, z2, 100 * (total / whole - 1), 100 * changed, 100 * worst, flip.raw,
    flip.radiance,
    100 * of_paths, paths:compare(best, { layer = "radiance", flip = "hdr" }).flip))
end

local rooms = dofile "spec/support/interiors.lua"(ylm)
print(("\npaths, %d of a pixel: noise without guides and with, efficiency by rays and by time"):format(PATHS))
print(("%-9s %8s %8s %11s %11s"):format("scene", "no %", "yes %", "by rays", "by time"))
for _, x in ipairs(rooms) do line_of_paths(x[1], x[2]) end

print(("\npictures by default counts: %d x %d, 16 samples, %d seeds, beside twice %d rays and links a point; paths of equal "
  .. "seconds"):format(size[1], size[2], SEEDS, RAYS))
print(("%-9s %7s %7s %7s %5s %8s %8s %8s %8s %7s %9s %7s"):format("scene", "noise", "noise", "says", "z2", "bias", "blocks",
  "worst", "FLIP", "FLIP", "noise", "FLIP"))
print(("%-9s %7s %7s %7s %5s %8s %8s %8s %8s %7s %9s %7s"):format("", "raw %", "%", "%", "", "%", "%", "%", "raw", "",
  "paths %", "paths"))
for _, x in ipairs(rooms) do line_of(x[1], x[2]) end
