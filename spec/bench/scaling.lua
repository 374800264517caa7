-- How the time of a sum of sphere lights grows: with lights, points, lmax and threads, as plots.
--
--     make bench BENCH=scaling        writes out/bench/scaling_*.png and prints what they show
--
-- Least processor time of several runs of one thread; where threads share the work, least wall time.

local ylm = require "ylm"
local core = require "ylm.c.core"
local light = require "ylm.light"

local folder = (arg and arg[1] or "out/bench") .. "/"
local quick = os.getenv "BENCH" == "quick"
os.execute(("mkdir -p '%s'"):format(folder))

local state = 7
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

local function places(n, lo, hi)
  local t = {}
  for i = 1, n do t[i] = { lo + (hi - lo) * random(), lo + (hi - lo) * random(), lo + (hi - lo) * random() } end
  return t
end

local function lamps(n)
  local radius, radiance = {}, {}
  for i = 1, n do radius[i], radiance[i] = 0.02, { 1, 2, 3 } end
  return light.pack(1, "bench", ylm.sphere_lights { at = places(n, -1, 1), radius = radius, radiance = radiance })
end

--- Seconds of one evaluation.
local function time(lights, points, lmax, o)
  local clock = o.wall and core.seconds or os.clock
  local count, c = (lmax + 1) ^ 2, o.channels == "rgb" and 3 or 1
  local out = { ylm.zeros({ #points, c, count }, "float") }
  if o.derivatives > 0 then out[2] = ylm.zeros({ #points, c, count, 3 }, "float") end
  if o.derivatives > 1 then out[3] = ylm.zeros({ #points, c, count, 6 }, "float") end
  local options = { derivatives = o.derivatives, channels = o.channels, out = out, threads = o.threads or 1,
    tolerance = o.tolerance }
  local best, spent = math.huge, 0
  if o.tolerance then assert(ylm.light_field(lmax, lights, points, options)) end -- makes the tree
  while spent < (quick and 0.01 or 0.15) do
    local t, repeats = clock(), 0
    repeat
      assert(ylm.light_field(lmax, lights, points, options))
      repeats = repeats + 1
    until clock() - t > 0.004
    t = clock() - t
    best, spent = math.min(best, t / repeats), spent + t
  end
  return best
end

local forms = {
  { label = "value", derivatives = 0, channels = "luminance" },
  { label = "gradient", derivatives = 1, channels = "luminance" },
  { label = "Hessian", derivatives = 2, channels = "luminance" },
  { label = "RGB, gradient", derivatives = 1, channels = "rgb" },
}

--- Measures y(x) for each form, prints it, plots it. A form may have x of its own.
local function plot(name, title, xs, axis, y_axis, measure, shown)
  local series = {}
  print(title)
  for _, form in ipairs(shown or forms) do
    local y, words = {}, {}
    for i, x in ipairs(form.x or xs) do
      y[i] = measure(x, form)
      words[i] = ("%.3g"):format(y[i])
    end
    series[#series + 1] = { x = form.x or xs, y = y, label = form.label, colour = form.colour, dash = form.dash }
    print(("  %-24s %s"):format(form.label, table.concat(words, "  ")))
  end
  local drawn = ylm.plot { title = title, series = series, x_label = axis.label, x_log = axis.log or false,
    y_label = y_axis.label, y_log = y_axis.log or false, y_range = y_axis.range, legend = axis.legend }
  local saved, message = drawn:save(folder .. "scaling_" .. name .. ".png")
  if not saved then print("  no picture: " .. tostring(message)) end
end

local few = ylm.array(places(32, 2, 3), "float")
plot("lights", "Time per point against lights (lmax 4, float, one thread)",
  { 1, 10, 100, 1000, 10000, 100000 }, { label = "lights", log = true },
  { label = "microseconds per point", log = true },
  function(n, form) return time(lamps(n), few, 4, form) / 32 * 1e6 end)

-- Lights fill a cube, points a floor through its middle as densely as a picture's do.
local floor, side = {}, quick and 32 or 128
for i = 0, side * side - 1 do floor[i + 1] = { 2 * (i % side) / side - 1, 2 * math.floor(i / side) / side - 1, 0 } end
floor = ylm.array(floor, "float")
local thousands = { 1000, 10000, 100000 }
if not quick then thousands[4] = 1000000 end
local blue, red = { 0.00, 0.45, 0.70 }, { 0.84, 0.37, 0.00 }
plot("many_lights", "Time per point of a floor among lights (lmax 4, RGB, one thread)", thousands,
  { label = "lights", log = true, legend = "bottom right" }, { label = "microseconds per point", log = true },
  function(n, form)
    collectgarbage()
    return time(lamps(n), floor, 4, form) / (side * side) * 1e6
  end, {
    { label = "value, exact", derivatives = 0, channels = "rgb", x = { 1000, 10000 }, colour = blue, dash = "dashed" },
    { label = "value, tolerance 0.01", derivatives = 0, channels = "rgb", tolerance = 0.01, colour = blue },
    { label = "gradient, exact", derivatives = 1, channels = "rgb", x = { 1000, 10000 }, colour = red, dash = "dashed" },
    { label = "gradient, tolerance 0.01", derivatives = 1, channels = "rgb", tolerance = 0.01, colour = red },
  })

local some = lamps(2516)
plot("points", "Time of 2516 lights against points (lmax 4, float, one thread)",
  { 1, 4, 16, 64, 256, 1024 }, { label = "points", log = true }, { label = "milliseconds", log = true },
  function(n, form) return time(some, ylm.array(places(n, 2, 3), "float"), 4, form) * 1e3 end)

local degrees = {}
for l = 0, 30, quick and 5 or 1 do degrees[#degrees + 1] = l end
local middling = lamps(500)
plot("lmax", "Time per light-point pair against lmax (float, one thread)", degrees, { label = "lmax" },
  { label = "nanoseconds per pair" },
  function(lmax, form) return time(middling, few, lmax, form) / 32 / 500 * 1e9 end)

local counts, most = {}, ylm.info().threads
for n = 1, most do counts[n] = n end
local many = ylm.array(places(quick and 512 or 2048, 2, 3), "float")
if most > 1 then
  local one = {}
  plot("threads", "Speed-up by threads (2516 lights, lmax 4, float; wall time)", counts, { label = "threads" },
    { label = "times as fast as one thread", range = { 0, most + 0.2 } },
    function(n, form)
      local t = time(some, many, 4, { derivatives = form.derivatives, channels = form.channels, threads = n, wall = true })
      one[form] = one[form] or t
      return one[form] / t
    end)
end
