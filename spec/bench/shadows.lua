-- Light behind bodies: points a second behind eight cubes, from grids and in closed form, by product; products of many factors;
-- irradiance of a floor under eight cubes against rays.
--
--     make bench BENCH=shadows
--
-- Each cube counts at each point (cull = 0). Least processor time of several runs of one thread, elapsed time of two.

local boxes = require "spec.support.boxes"
local core = require "ylm.c.core"
local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore

local quick = os.getenv "BENCH" == "quick"
local POINTS, BODIES, DEPTH = quick and 2000 or 20000, 8, quick and 7 or 10

local state = 7
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- Least seconds of f() by a clock.
local function time(f, clock)
  local best, spent = math.huge, 0
  while spent < (quick and 0.01 or 1) do
    local start = clock()
    assert(f())
    local t = clock() - start
    best, spent = math.min(best, t), spent + t
  end
  return best
end

local function print_row(...) print(("| %s |"):format(table.concat({ ... }, " | "))) end

local points = {}
for i = 0, POINTS - 1 do points[i + 1] = { (i % 160) / 40 - 2, math.floor(i / 160) / 31.25 - 2, 0 } end
points = ylm.array(points, "float")

local at, turns = {}, {}
for i = 1, BODIES do
  local phi = 2 * math.pi * i / BODIES
  at[i] = { 1.8 * math.cos(phi), 1.8 * math.sin(phi), 0.9 + 0.1 * (i % 3) }
  turns[i] = { math.cos(0.3 * i), math.sin(0.3 * i), 0.2, 0.1 }
end

local cube = ylm.occluder { geometry = ylm.box { scale = 0.6 } }
local sky = ylm.environment_light { sky = { kind = "clear", sun = { 1, 0.3, 0.8 } } }

print(("Points behind %d cubes, thousands a second, %d points on a floor, light of a sky; one thread, and two."):format(BODIES,
  POINTS))
print()
print_row("n", "cubes", "product", "luminance", "rgb", "luminance with gradients", "luminance, two threads")
print_row("--:", "---", "---", "--:", "--:", "--:", "--:")
for _, lmax in ipairs { 4, 9, 14 } do
  local grid = ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = DEPTH, tolerance = 0.03, channels = "luminance" }, cube)
  for _, case in ipairs { { "grid", "rule", true }, { "grid", "rule", false }, { "grid", "recursive", false },
    { "grid", "accurate", false },
    { "closed form", "rule", true } } do
    local shade = ylm.shadowed { lights = sky, cull = 0, product = case[2], layers = case[3],
      casters = { ylm.casters { hides = case[1] == "grid" and grid or cube, at = at, rotation = turns } } }
    local row = { tostring(lmax + 1), case[1], case[2] .. (case[3] and ", layers" or "") }
    for _, o in ipairs { { channels = "luminance" }, { channels = "rgb" }, { channels = "luminance", derivatives = 1 },
      { channels = "luminance", threads = 2 } } do
      o.threads = o.threads or 1
      local clock = o.threads > 1 and core.seconds or os.clock
      local seconds = time(function() return ylm.light_field(lmax, shade, points, o) end, clock)
      row[#row + 1] = ("%.0f"):format(POINTS / seconds / 1e3)
    end
    print_row(unpack(row))
  end
  print_row(tostring(lmax + 1), ("its grid: %d points, %.1f MB, error %.2g"):format(grid.stats.points, grid.stats.bytes / 2 ^ 20,
    grid.stats.error), "", "", "", "", "")
end

print()
print(("Products of %d factors, float, 1000 rows, 1 thread, ns a product."):format(BODIES))
print()
print_row("n", "rule = 3", "recursive", "exact")
print_row("--:", "--:", "--:", "--:")
for _, lmax in ipairs { 4, 9, 14 } do
  local factors = {}
  for k = 1, BODIES do
    local rows = {}
    for i = 1, 1000 do rows[i] = ylm.sh.cap(lmax, { random() - 0.5, random() - 0.5, random() - 0.5 }, 0.3):totable() end
    factors[k] = ylm.array(rows, "float")
  end
  local row = { tostring(lmax + 1) }
  for _, o in ipairs { { rule = 3 }, { method = "recursive" }, { method = "quadrature" } } do
    o.threads = 1
    factors[BODIES + 1] = o
    row[#row + 1] = ("%.0f"):format(time(function() return ylm.sh.product(unpack(factors)) end, os.clock) * 1e6)
  end
  print_row(unpack(row))
end

-- Against rays ----------------------------------------------------------------------------------

local PLACES, SIDE = 48, 150 -- places on the floor, and rays along a side of a square of them

local sh = ylm.sh
local smooth = { math.sqrt(4 * math.pi), 0.3, 0.5, -0.4, 0.2, 0.1, -0.2, 0.15, 0.1 } -- coefficients of the light

local bodies, scale, places = { at = {}, turn = {}, matrix = {} }, {}, {}
for i = 1, BODIES do
  local phi, r = 2 * math.pi * i / BODIES, 0.6 + 1.4 * random()
  bodies.at[i] = { r * math.cos(phi), r * math.sin(phi), 0.7 + 0.9 * random() }
  bodies.turn[i] = { random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5 }
  bodies.matrix[i], scale[i] = boxes.matrix(bodies.turn[i]), 0.35 + 0.3 * random()
end
for i = 1, PLACES do places[i] = { 4 * random() - 2, 4 * random() - 2, 0 } end

--- Does a ray from p along w meet cube i?
local function meets(i, p, w)
  local half = scale[i] / 2
  return boxes.meets({ half, half, half }, bodies.at[i], bodies.matrix[i], p, w)
end

local rays = boxes.rays(SIDE)
local light = sh.reconstruct(smooth, rays):totable()

--- Irradiance at a place by rays, behind the first n cubes.
local function irradiance(p, n)
  local sum = 0
  for k, w in ipairs(rays) do
    local free = true
    for i = 1, n do
      if meets(i, p, w) then
        free = false
        break
      end
    end
    if free then sum = sum + light[k] end
  end
  return sum / #rays * math.pi
end

local open, truth = irradiance(places[1], 0), {}
for i, p in ipairs(places) do truth[i] = irradiance(p, BODIES) end
local unit = ylm.occluder { geometry = ylm.box {} }

print()
print(("Irradiance behind %d cubes at %d places of a floor: rms distance from %d rays a place, %% of the unshadowed.")
  :format(BODIES, PLACES, #rays))
print()
print_row("n", "rule, layers", "rule", "accurate", "recursive")
print_row("--:", "--:", "--:", "--:", "--:")
for _, lmax in ipairs { 4, 9, 14 } do
  local row = { tostring(lmax + 1) }
  for _, case in ipairs { { "rule", true }, { "rule", false }, { "accurate", false }, { "recursive", false } } do
    local shade = ylm.shadowed { lights = ylm.environment_light { coefficients = sh.resize(smooth, lmax) }, product = case[1],
      layers = case[2], casters = ylm.casters { hides = unit, at = bodies.at, rotation = bodies.turn, scale = scale } }
    local L, sum = ylm.light_field(lmax, shade, places, { channels = "luminance", dtype = "double" }):totable(), 0
    for i = 1, PLACES do sum = sum + ((sh.irradiance(L[i][1], { 0, 0, 1 }) - truth[i]) / open) ^ 2 end
    row[#row + 1] = ("%.3f"):format(100 * math.sqrt(sum / PLACES))
  end
  print_row(unpack(row))
end
