-- Ten thousand lamps and more, to a tolerance: error against speed, and time against the number of lights.
--
--     lua examples/06_many_lights.lua [--out DIR] [--count 30000] [--most 100000]
--
-- Writes many_lights_error.png and many_lights_number.png, and prints what they show. Processor time of one thread.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")

local options = common.options { out = "out", count = 30000, most = 100000 }

--- Random numbers in 0 .. 1, equal on every machine (Lehmer).
local state = 12345
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- n lamps of fixed power in all, in a unit room: a third anywhere, a third on the walls, a third in strings.
local function lamps(n)
  local at, radiance = ylm.zeros({ n, 3 }, "double"), ylm.zeros({ n, 3 }, "double")
  for i = 1, n do
    local p = { random(), random(), random() }
    if i % 3 == 1 then p[1 + i % 2 * 2] = random() < 0.5 and 0.002 or 0.998
    elseif i % 3 == 2 then
      local string = i % 20
      p[2] = 0.9 - 0.3 * math.sin(3.14 * p[1]) + 0.005 * p[2]
      p[3] = string / 20 + 0.005 * p[3]
    end
    for a = 1, 3 do at:set(i, a, p[a]) radiance:set(i, a, 0.4 + 0.6 * random()) end
  end
  return ylm.sphere_lights { at = at, radius = 0.1 / math.sqrt(n), radiance = radiance }
end

-- A floor and a wall, as dense as a bake's points: what lies together is summed together.
local points, side = {}, 36
for i = 0, side ^ 2 - 1 do
  local x, y = (i % side + 0.5) / side, (math.floor(i / side) + 0.5) / side
  points[#points + 1] = { x, 0.01, y }
  points[#points + 1] = { x, y, 0.4 }
end

--- Coefficients and gradients (lmax 4, rgb) at the points, and microseconds a point: the least of three.
local function field(lights, tolerance)
  local least, L, dL = math.huge, nil, nil
  for _ = 1, 3 do
    local start = os.clock()
    L, dL = ylm.light_field(4, lights, points, { derivatives = 1, threads = 1, tolerance = tolerance })
    least = math.min(least, os.clock() - start)
  end
  return 1e6 * least / #points, L, dL
end

--- |a - b| / |b| of each point.
local function distances(a, b)
  local axes = { axis = #b.shape == 3 and { 2, 3 } or { 2, 3, 4 } }
  return (((a - b) ^ 2):sum(axes) / (b ^ 2):sum(axes)):sqrt()
end

--- Of each point's error the median and the largest.
local function errors(a, b)
  local e = distances(a, b):totable()
  table.sort(e)
  return e[math.ceil(#e / 2)], e[#e]
end

local function save(plot, name) common.save(plot, options.out .. name) end

-- Error against speed -------------------------------------------------------------------------------

local n = options.count
local many = lamps(n)
local exact_time, exact, exact_gradient = field(many)
print(("%s lamps, lmax 4, rgb, coefficients and gradients; exact: %.0f us a point"):format(common.thousands(n),
  exact_time))
local row = common.table { { "tolerance", "%g" }, { "us a point", "%.1f" }, { "faster", "%.1f" },
  { "value: median", "%.1e" }, { "largest", "%.1e" }, { "gradient: median", "%.1e" }, { "largest", "%.1e" } }
local speed, of_value, of_gradient, promised = {}, {}, {}, {}
for i, tolerance in ipairs { 0.3, 0.1, 0.03, 0.01, 0.003, 0.001 } do
  local time, L, dL = field(many, tolerance)
  local value, value_most = errors(L, exact)
  local gradient, gradient_most = errors(dL, exact_gradient)
  row { tolerance, time, exact_time / time, value, value_most, gradient, gradient_most }
  speed[i], of_value[i], of_gradient[i], promised[i] = exact_time / time, value_most, gradient_most, tolerance
end
save(ylm.plot { log = true, title = ("%s lamps: error against speed"):format(common.thousands(n)),
  x_label = "times as fast as the exact sum", legend = "top left",
  y_label = ("error, largest of %d points"):format(#points),
  series = { { x = speed, y = promised, label = "tolerance", dash = "dashed" },
    { x = speed, y = of_gradient, label = "gradient" }, { x = speed, y = of_value, label = "value" } } },
  "many_lights_error.png")

-- Time against the number of lights -----------------------------------------------------------------

local numbers, series = {}, { { label = "exact", dash = "dashed", x = {}, y = {} }, { label = "tolerance 0.01", y = {} },
  { label = "tolerance 0.1", y = {} } }
row = common.table { { "lamps", "%s" }, { "exact, us", "%.1f" }, { "0.01", "%.1f" }, { "0.1", "%.1f" } }
n = 1000
while n <= options.most do
  many = lamps(n)
  local k = #numbers + 1
  numbers[k] = n
  if n <= 1e5 then series[1].x[k], series[1].y[k] = n, (field(many)) end
  series[2].y[k], series[3].y[k] = (field(many, 1e-2)), (field(many, 1e-1))
  row { common.thousands(n), series[1].y[k], series[2].y[k], series[3].y[k] }
  n = n * 10
end
series[2].x, series[3].x = numbers, numbers
save(ylm.plot { log = true, title = "Lamps of fixed power in a room", x_label = "number of lamps",
  y_label = "microseconds per point, one thread", legend = "top left", series = series }, "many_lights_number.png")
