-- ylm's path tracer against Blender's Cycles in the room of examples/scenes/room.lua.
--
--     for s in 1 2 3 4 5 6; do blender -b --python spec/bench/cycles.py -- out/cycles_$s.exr 160 120 128 $s; done
--     ylm run spec/bench/cycles_compare.lua out/cycles_*.exr
--
-- The variance of Cycles is that among its files. Pixels that show lamps, and their neighbours, are left out: Blender's camera
-- sees its lamps otherwise. Prints z2, the means and where they differ; writes out/cycles.png: both, and their difference.

local ylm = require "ylm"

local scene = assert(ylm.load "examples/scenes/room.lua")
local files = {}
for i, name in ipairs(arg) do files[i] = assert(ylm.load(name)) end
assert(#files >= 2, "two files of Cycles at least")
local size = files[1].size
local ours, report = assert(scene:pathtrace { size = size, samples = 512 })

local theirs = ylm.image { size = size, layers = { { "radiance", 3 }, { "variance", 3 } } }
local mean, variance = theirs:layer "radiance", theirs:layer "variance"
local pixels = {}
for i, file in ipairs(files) do pixels[i] = ylm.array(file:layer(), "double") end
pixels = ylm.stack(pixels)
mean[{}] = pixels:mean(1)
variance[{}] = ((pixels - pixels:mean(1)) ^ 2):sum(1) / (#files * (#files - 1))

local emitter, mask = ours:layer "emitter", ylm.zeros({ size[2], size[1] }, "float")
local function shows_lamp(x, y)
  for v = math.max(1, y - 1), math.min(size[2], y + 1) do
    for u = math.max(1, x - 1), math.min(size[1], x + 1) do
      if emitter:get(v, u, 1) > 0 then return true end
    end
  end
  return false
end
for y = 1, size[2] do
  for x = 1, size[1] do mask:set(y, x, shows_lamp(x, y) and 0 or 1) end
end

--- Means of both over the masked pixels of some meshes (nil: all), green.
local function means(keep)
  local a, b, n, va = 0, 0, 0, 0
  for y = 1, size[2] do
    for x = 1, size[1] do
      if mask:get(y, x) > 0 and (not keep or keep(x, y)) then
        a, b, n = a + ours:layer():get(y, x, 2), b + mean:get(y, x, 2), n + 1
        va = va + variance:get(y, x, 2) + ours:layer "variance":get(y, x, 2)
      end
    end
  end
  return a / n, b / n, math.sqrt(va) / n, n
end
local function print_means(name, keep)
  local a, b, e, n = means(keep)
  print(("%-24s ylm %.5f  Cycles %.5f  ratio %.4f +- %.4f  (%d pixels)"):format(name, a, b, a / b, e / b, n))
end

local m = ours:compare(theirs, { variance = true, mask = mask })
print(("noise of ylm %.2f %%; z2 %.3f, largest block %.3f at %d, %d; psnr %.1f dB"):format(100 * report.noise, m.z2, m.z2_block,
  m.block[1], m.block[2], m.psnr))
local position = ours:layer "position"
local function near(at, radius)
  return function(x, y)
    local d2 = 0
    for a = 1, 3 do d2 = d2 + (position:get(y, x, a) - at[a]) ^ 2 end
    return math.abs(math.sqrt(d2) - radius) < 0.01
  end
end
local rough, fine = near({ -0.45, 0.4, -0.3 }, 0.4), near({ 0.15, 0.2, 0.45 }, 0.2)
print_means "all pixels"
print_means("sphere of alpha 0.3", rough)
print_means("sphere of alpha 0.1", fine)
print_means("matte surfaces", function(x, y) return not rough(x, y) and not fine(x, y) end)

local matte = ylm.zeros({ size[2], size[1] }, "float")
for y = 1, size[2] do
  for x = 1, size[1] do matte:set(y, x, mask:get(y, x) > 0 and not rough(x, y) and not fine(x, y) and 1 or 0) end
end
local mm = ours:compare(theirs, { variance = true, mask = matte })
print(("matte surfaces alone: z2 %.3f, largest block %.3f"):format(mm.z2, mm.z2_block))

local off = {}
for y = 1, size[2] do
  off[y] = {}
  for x = 1, size[1] do
    local a, b = ours:layer():get(y, x, 2), mean:get(y, x, 2)
    off[y][x] = mask:get(y, x) > 0 and b > 0 and (a - b) / b or 0
  end
end
local picture = ylm.figure {
  rows = { {
    { image = ours, tone = "hable", exposure = 1, caption = "ylm, 512 samples" },
    { image = theirs, tone = "hable", exposure = 1, caption = "Blender 3.4, Cycles" },
    { values = off, caption = "their relative difference" },
  } },
  bar = { range = { -0.2, 0.2 }, map = "coolwarm", label = "(ylm - Cycles) / Cycles" },
}
local ok, message = picture:save "out/cycles.png"
print(ok and "wrote out/cycles.png" or message)
