-- A room under an overcast sky by default settings, beside Blender's Cycles for as many processor seconds: FLIP and noise, each
-- to a reference of its own renderer.
--
--     ylm run spec/bench/cycles_interior.lua FOLDER [width height samples of Cycles' reference]
--
-- The room is spec/support/interiors.lua's "overcast" (spec/bench/cycles_interior.py). ylm's picture is that of `ylm render`:
-- its noise is filtered. Its reference has 512 shadow rays and links of another seed and no filter, that of Cycles the
-- portal. Cycles has as many samples as fit into ylm's seconds, by those of a trial. Noise is the root mean square of a
-- pixel's difference in luminance, relative to the light of 9 x 9 pixels around it, with what the reference leaves.

local ylm = require "ylm"

local folder, size = arg[1], { tonumber(arg[2] or 480), tonumber(arg[3] or 270) }
local EXACT, TRIAL, REACH = tonumber(arg[4] or 2048), 8, 4
local scene = dofile "spec/support/interiors.lua"(ylm)[2][2]

ylm.on_warning(false)
assert(scene:save(folder .. "/room.glb"))

--- A picture by Cycles, and its processor seconds.
local function cycles(samples, seed, portal)
  local out = ("%s/cycles_%d_%d_%d.exr"):format(folder, samples, seed, portal)
  local pipe = assert(io.popen(("blender -b --python-exit-code 1 --python spec/bench/cycles_interior.py -- %s/room.glb %s %d %d "
    .. "%d %d %d 2>&1"):format(folder, out, size[1], size[2], samples, seed, portal)))
  local text = pipe:read "*a"
  pipe:close()
  local seconds = assert(text:match "PROCESSOR ([%d.]+)", text)
  return assert(ylm.load(out)), tonumber(seconds)
end

local function luminances(image)
  local rows = image:layer("radiance"):totable()
  for _, row in ipairs(rows) do
    for x, c in ipairs(row) do row[x] = 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end
  end
  return rows
end

--- Noise of an image beside its reference.
local function noise_of(image, exact)
  local a, b, square, n = luminances(image), luminances(exact), 0, 0
  for y = 1, size[2] do
    for x = 1, size[1] do
      local mean, k = 0, 0
      for v = math.max(1, y - REACH), math.min(size[2], y + REACH) do
        for u = math.max(1, x - REACH), math.min(size[1], x + REACH) do mean, k = mean + b[v][u], k + 1 end
      end
      if mean > 0 then square, n = square + ((a[y][x] - b[y][x]) * k / mean) ^ 2, n + 1 end
    end
  end
  return math.sqrt(square / n)
end

--- Radiance alone.
local function plain(image)
  local out = ylm.image { size = size }
  out:paste(image, 1, 1, { from = "radiance" })
  return out
end

local function line(name, image, exact, seconds, samples)
  image, exact = plain(image), plain(exact)
  print(("%-24s %7.1f %8s %8.2f %7.3f %9.4f"):format(name, seconds, samples, 100 * noise_of(image, exact),
    image:compare(exact, { flip = "hdr" }).flip, image:layer():mean()))
  assert(image:save(("%s/%s.png"):format(folder, (name:gsub("%W+", "_"))), { exposure = "auto" }))
end

print(("%-24s %7s %8s %8s %7s %9s"):format("picture", "CPU s", "samples", "noise %", "FLIP", "mean"))
local start = os.clock()
local ours = assert(scene:render { size = size, denoise = "auto", progress = false })
local seconds = os.clock() - start
line("ylm render", ours, assert(scene:render { size = size, light_samples = 512, rays = 512, seed = 5, progress = false }),
  seconds, "16")
local exact = cycles(EXACT, 77, 1)
for portal = 0, 1 do
  local _, trial = cycles(TRIAL, 1, portal)
  local samples = math.max(1, math.floor(TRIAL * seconds / trial + 0.5))
  local image, took = cycles(samples, 2, portal)
  line(portal == 1 and "Cycles with a portal" or "Cycles", image, exact, took, ("%d"):format(samples))
end
