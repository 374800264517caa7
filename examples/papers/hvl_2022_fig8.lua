-- Mezieres & Paulin 2022 (harmonics virtual lights), Fig. 8: how 400 and 100 lights cover what the lamp shines on, by the rule of
-- their radius: 0.25 for all, r1 (Eq. 23), r2 (Eqs. 24-26), and two of ylm's, by footprint and by density.
--
--     lua examples/papers/hvl_2022_fig8.lua [--width 200] [--scene FILE] [--out out] [--quick]
--
-- Writes hvl_2022_fig8.png. A Cornell box of 2 m stands in for the paper's room; the scene needs a spot_light. "times" is the
-- area of all discs over that of the texels they stand for; "uncovered" the part of the lit pixels in no disc, "overlap" the
-- discs over a lit pixel in the mean. A disc covers points within its radius whose normal is within 60 degrees of its own.
-- Factors (k) are 1.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { width = 200, scene = "", out = "out", quick = false }
local quick = option.quick
local width = quick and 32 or option.width
local size = { width, width }
ylm.on_warning(false)

local scene = rooms.given(option.scene, "cornell", { lamp = "spot" })
local view = assert(scene:prepare { size = size, samples = 1 })
local direct = assert(view:render {})
local radiance, position, normal = direct:layer():totable(), direct:layer "position":totable(), direct:layer "normal":totable()
local lit = {} -- { row, column, position, normal }
for y = 1, size[2] do
  for x = 1, size[1] do
    local c = radiance[y][x]
    if c[1] + c[2] + c[3] > 0 then lit[#lit + 1] = { y, x, position[y][x], normal[y][x] } end
  end
end

--- The colour of a pixel under n discs; nil: not lit.
local function colour(n)
  if not n then return { 0.1, 0.1, 0.1 } end
  if n == 0 then return { 0.85, 0.2, 0.1 } end
  local t = math.min(1, (n - 1) / 9)
  return { 0.88 - 0.85 * t, 0.93 - 0.75 * t, 0.98 - 0.5 * t }
end

--- Discs over each lit pixel as a picture, the uncovered part of them, and the mean overlap.
local function coverage(at, n, radius)
  local map, bare, sum = {}, 0, 0
  for y = 1, size[2] do
    map[y] = {}
    for x = 1, size[1] do map[y][x] = colour() end
  end
  for _, p in ipairs(lit) do
    local q, m, over = p[3], p[4], 0
    for i, a in ipairs(at) do
      local dx, dy, dz = a[1] - q[1], a[2] - q[2], a[3] - q[3]
      if dx * dx + dy * dy + dz * dz < radius[i] ^ 2 and n[i][1] * m[1] + n[i][2] * m[2] + n[i][3] * m[3] > 0.5 then
        over = over + 1
      end
    end
    map[p[1]][p[2]] = colour(over)
    sum = sum + over / #lit
    if over == 0 then bare = bare + 1 / #lit end
  end
  return map, 100 * bare, sum
end

local function squares(radius)
  local sum = 0
  for _, r in ipairs(radius) do sum = sum + r * r end
  return sum
end

local row = common.table { { "radius", "%-16s" }, { "lights", "%6d" }, { "median", "%6.3f" }, { "largest", "%7.3f" }, { "times",
  "%6.2f" },
  { "uncovered, %", "%12.1f" }, { "overlap", "%7.2f" } }
local rows = {}
for i, count in ipairs { 400, 100 } do
  local at, facing
  local function radii(rule)
    local lights = assert(scene:virtual_lights { distribution = "grid", count = count, radius = rule,
      scale = type(rule) == "string" and 1 or nil })
    local a, n, radius = lights:arrays()
    at, facing = a:totable(), n:totable()
    return radius:totable()
  end
  local footprint = radii "footprint"
  rows[i] = {}
  for _, rule in ipairs { { "0.25", radii(0.25) }, { "r1, Eq. 23", radii "neighbours" }, { "r2, Eq. 26", radii "angle" },
    { "footprint", footprint }, { "density", radii "density" } } do
    local map, bare, overlap = coverage(at, facing, rule[2])
    local sorted = {}
    for k, r in ipairs(rule[2]) do sorted[k] = r end
    table.sort(sorted)
    row { rule[1], #at, sorted[math.ceil(#sorted / 2)], sorted[#sorted], squares(rule[2]) / squares(footprint), bare, overlap }
    rows[i][#rows[i] + 1] = { image = ylm.array(map), caption = ("%s: %.0f %% bare, %.1f over"):format(rule[1], bare, overlap) }
  end
end
print(("%d lit pixels. Sets of equal numbers of lights stand at the same places."):format(#lit))
print "r1 and r2 cover the same surface several times over, and more where the light falls askew; footprint once, by"
print "construction, with some bare corners of texels: its default factor is 1.5. A fixed radius suits one number of lights."
if not quick then
  common.save(ylm.figure { title = "What discs of virtual lights cover, by the rule of their radius", rows = rows,
    caption = "Above 400 lights, below 100, factors 1. Grey: not lit by the lamp; red: bare; light to dark blue: 1 to 10 discs. "
      .. "After Mezieres & Paulin 2022, Fig. 8." },
    option.out .. "hvl_2022_fig8.png")
end
