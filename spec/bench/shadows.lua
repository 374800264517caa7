-- Light behind bodies: points a second behind eight cubes, from grids and in closed form, by product; products of many factors.
--
--     make bench BENCH=shadows
--
-- Each cube counts at each point (cull = 0). Least processor time of several runs of one thread.

local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore

local POINTS, BODIES = 20000, 8

local state = 7
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- Least seconds of f().
local function time(f)
  local best, spent = math.huge, 0
  while spent < 1 do
    local start = os.clock()
    assert(f())
    local t = os.clock() - start
    best, spent = math.min(best, t), spent + t
  end
  return best
end

local function print_row(...) print(("| %s |"):format(table.concat({ ... }, " | "))) end

local points = {}
for i = 1, POINTS do points[i] = { 4 * random() - 2, 4 * random() - 2, 0 } end
points = ylm.array(points, "float")

local at, turns = {}, {}
for i = 1, BODIES do
  local phi = 2 * math.pi * i / BODIES
  at[i] = { 1.8 * math.cos(phi), 1.8 * math.sin(phi), 0.9 + 0.1 * (i % 3) }
  turns[i] = { math.cos(0.3 * i), math.sin(0.3 * i), 0.2, 0.1 }
end

local cube = ylm.occluder { geometry = ylm.box { scale = 0.6 } }
local sky = ylm.environment_light { sky = { kind = "clear", sun = { 1, 0.3, 0.8 } } }

print(("Points behind %d cubes, thousands a second and thread, %d points on a floor, light of a sky."):format(BODIES, POINTS))
print()
print_row("n", "cubes", "product", "luminance", "rgb", "luminance with gradients")
print_row("--:", "---", "---", "--:", "--:", "--:")
for _, lmax in ipairs { 4, 9, 14 } do
  local grid = ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = 10, tolerance = 0.03, channels = "luminance" }, cube)
  for _, case in ipairs { { "grid", "rule", true }, { "grid", "rule", false }, { "grid", "recursive", false },
    { "grid", "accurate", false },
    { "closed form", "rule", true } } do
    local shade = ylm.shadowed { lights = sky, cull = 0, product = case[2], layers = case[3],
      casters = { ylm.casters { hides = case[1] == "grid" and grid or cube, at = at, rotation = turns } } }
    local row = { tostring(lmax + 1), case[1], case[2] .. (case[3] and ", layers" or "") }
    for _, o in ipairs { { channels = "luminance" }, { channels = "rgb" }, { channels = "luminance", derivatives = 1 } } do
      o.threads = 1
      row[#row + 1] = ("%.0f"):format(POINTS / time(function() return ylm.light_field(lmax, shade, points, o) end) / 1e3)
    end
    print_row(unpack(row))
  end
  print_row(tostring(lmax + 1), ("its grid: %d points, %.1f MB, error %.2g"):format(grid.stats.points, grid.stats.bytes / 2 ^ 20,
    grid.stats.error), "", "", "", "")
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
    row[#row + 1] = ("%.0f"):format(time(function() return ylm.sh.product(unpack(factors)) end) * 1e6)
  end
  print_row(unpack(row))
end
