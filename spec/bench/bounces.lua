-- Pictures with all bounces by one knob against the path tracer, on three scenes (spec/support/bounce_scenes.lua).
--
--     build/ylm run spec/bench/bounces.lua [width] [tolerance] [samples of the judge] [scene] [threads]
--
-- error: sqrt(max(0, mean((a-b)^2 - va))) / mean over pixels without lamps, b the judge and va its variance; +: with one standard
-- error of that mean it is so much more. says, +: what the knob says, and by how much it may be more. block: the largest
-- difference of means over 16 x 9 pixels, where the judge knows them to 0.5 %. paths: seconds that the path tracer takes to an
-- error as small, its variance falling as 1/samples; ratio: to all seconds of the picture, and to those after its judge.

local ylm = require "ylm"
local scenes = dofile "spec/support/bounce_scenes.lua"

local width, tolerance, samples = tonumber(arg[1] or 160), tonumber(arg[2] or 0.01), tonumber(arg[3] or 1024)
local only, threads = tonumber(arg[4] or 0), tonumber(arg[5] or 2)
local size = { width, math.floor(width * 9 / 16) }

local function numbers(image, layer) return ylm.array(image:layer(layer), "double") end

--- Sums over the pixels of a rectangle that show no lamp: error, mean, noise of the judge, all channels; means of a and b.
local function compare(t, x0, y0, x1, y1)
  local part = { { y0, y1 }, { x0, x1 } }
  local dark = t.lamp[part]:equal(0):reshape { y1 - y0 + 1, x1 - x0 + 1 }
  local p, q, v = t.a[part]:select(dark), t.b[part]:select(dark), t.v[part]:select(dark)
  local n = 3 * #p
  if n == 0 then return nil end
  local excess = ((p - q) ^ 2 - v):sum(2) -- of each pixel
  local more, variance, a, b = excess:sum(), v:sum(), p:mean(), q:mean()
  local found = math.max(0, more / n)
  local known = math.sqrt(math.max(0, (excess ^ 2):sum() - more ^ 2 * 3 / n)) / n -- of `found`, by pixels
  return { error = math.sqrt(found) / b, more = (math.sqrt(found + known) - math.sqrt(found)) / b,
    noise = math.sqrt(variance / n) / b, bias = a / b - 1, known = math.sqrt(variance) / n / b }
end

--- The largest bias of a block that the judge knows to 0.5 %, and how many of these there are.
local function worst_block(t)
  local worst, count = 0, 0
  for y = 1, size[2] - 8, 9 do
    for x = 1, size[1] - 15, 16 do
      local found = compare(t, x, y, x + 15, y + 8)
      if found and found.known < 0.005 then worst, count = math.max(worst, math.abs(found.bias)), count + 1 end
    end
  end
  return worst, count
end

print(("%dx%d, tolerance %g, judge of %d samples, %d threads"):format(size[1], size[2], tolerance, samples, threads))
local HEAD, ROW = "%-26s %7s %6s %7s %6s %6s %8s %7s %8s %8s %9s %7s %7s",
  "%-26s %6.2f%% %5.2f%% %6.2f%% %5.2f%% %6s %7.2f%% %7d %8.1f %8.1f %9.1f %7.1f %7.1f"
print(HEAD:format("scene", "error", "+", "says", "+", "met", "block", "blocks", "s", "s judge", "s paths", "ratio", "after"))
for i, case in ipairs(scenes) do
  if only == 0 or only == i then
    local scene = case.make(ylm)
    local image, report = assert(scene:render { size = size, bounces = "all", tolerance = tolerance, threads = threads })
    local truth, judge = assert(scene:pathtrace { size = size, samples = samples, reflections = { 1, "all" },
      layers = false, threads = threads })
    local t = { a = numbers(image, "radiance"), b = numbers(truth, "radiance"), v = numbers(truth, "variance"),
      lamp = numbers(image, "emitter") }
    local all = compare(t, 1, 1, size[1], size[2])
    local block, blocks = worst_block(t)
    local seconds = judge.seconds.total * (all.noise / math.max(all.error, 1e-9)) ^ 2
    local own = report.seconds.total - report.seconds.judge
    local met = report.judged.sure and tostring(report.met) or "maybe"
    print(ROW:format(case.name, 100 * all.error, 100 * all.more, 100 * report.error, 100 * report.judged.uncertainty, met,
      100 * block, blocks, report.seconds.total, report.seconds.judge, seconds, seconds / report.seconds.total,
      seconds / own))
    local c, causes = report.chosen, report.causes
    print(("  chosen: %d camera rays, share %g, %d shadow rays, %d links, %d elements; pixels %.2f%%, direct %.2f%%, "
      .. "links %.2f%%, elements %.2f%%; judge's noise %.2f%%, knob's paths %d"):format(c.samples, c.share, c.light_samples,
      c.rays or 0, c.elements or 0, 100 * causes.pixels, 100 * causes.direct, 100 * causes.links, 100 * (causes.elements or 0),
      100 * all.noise, report.judged.samples))
  end
end
