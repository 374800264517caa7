-- Noise and time of pictures by rays to the lamps, by the number of shadow rays; the same pictures by transfer vectors.
--
--     make bench BENCH=rays              build/ylm run spec/bench/rays.lua [width height]
--
-- Noise is that of docs/math.md, "Shading": the root mean square deviation of a pixel relative to its luminance plus a tenth of
-- the mean. Pixels are those that show light on surfaces, from two pictures of the same view. Times are of all threads.

local ylm = require "ylm"

local size = { tonumber(arg[1] or 320), tonumber(arg[2] or 180) }
local counts = { 4, 8, 16, 32, 64 }

--- The deviation of one of two pictures of a view.
local function noise(first, second)
  local weights = { 0.2126, 0.7152, 0.0722 }
  local a, b = (ylm.array(first:layer(), "double") * weights):sum(3), (ylm.array(second:layer(), "double") * weights):sum(3)
  local lit = a:not_equal(b) -- lamps and background are the same in both, and so is darkness
  a, b = a:select(lit), b:select(lit)
  local both = (a + b) / 2
  return math.sqrt((((a - b) / (both + both:mean() / 10)) ^ 2):mean() / 2)
end

print(("%d x %d, 16 samples a pixel, %d threads"):format(size[1], size[2], ylm.info().threads))
print(("%-14s %7s %9s %15s %9s %15s"):format("scene", "points", "rays", "noise %", "light s", "picture s"))
for _, name in ipairs { "floor_lights", "two_rooms", "two_lamps", "room", "window" } do
  local scene = assert(ylm.load("examples/scenes/" .. name .. ".lua"))
  local view = assert(scene:prepare { size = size })
  local rest = view.stats.primary_seconds + view.stats.transfer_seconds
  for _, n in ipairs(counts) do
    local first, report = view:render { light_samples = n, layers = false }
    local second = view:render { by = "rays", light_samples = n, layers = false, seed = 77 }
    local light = report.seconds.light
    print(("%-14s %7d %9d %15.2f %9.3f %15.3f"):format(name, view.stats.points, n, 100 * noise(first, second), light,
      light + rest))
  end
  if scene.probes then
    local before = ylm.on_warning(false)
    local _, report = scene:render { size = size, visibility = "transfer", layers = false }
    ylm.on_warning(before)
    local s = report.seconds
    print(("%-14s %7d %9d %15s %9.3f %15s"):format(name, report.points, report.transfer_samples, ("by transfer %.2f"):format(
      100 * report.noise), s.light, ("%.3f and a bake"):format(s.light + s.primary + s.transfer)))
  end
end
