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

--- The spot whose light lands.
local spot
for _, l in ipairs(scene.lights) do spot = spot or getmetatable(l) and l.angle and l or nil end
if not spot then error("the scene needs a spot_light", 0) end

--- Distances of places from the spot, and their places in a plane at distance 1 before it.
local function seen_from(at)
  local axis, u, v = {}, {}, {}
  local n = 0
  for c = 1, 3 do
    axis[c] = spot.to[c] - spot.at[c]
    n = n + axis[c] ^ 2
  end
  for c = 1, 3 do axis[c] = axis[c] / math.sqrt(n) end
  local k = math.abs(axis[1]) < 0.6 and 1 or 2
  for c = 1, 3 do u[c] = (c == k and 1 or 0) - axis[k] * axis[c] end
  n = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2)
  for c = 1, 3 do u[c] = u[c] / n end
  for c = 1, 3 do v[c] = axis[c % 3 + 1] * u[(c + 1) % 3 + 1] - axis[(c + 1) % 3 + 1] * u[c % 3 + 1] end
  local distance, plane = {}, {}
  for i, p in ipairs(at) do
    local d, x, y, z = 0, 0, 0, 0
    for c = 1, 3 do
      local w = p[c] - spot.at[c]
      d, x, y, z = d + w * w, x + w * u[c], y + w * v[c], z + w * axis[c]
    end
    distance[i], plane[i] = math.sqrt(d), { x / z, y / z }
  end
  return distance, plane
end

--- Eq. 23: the mean distance to the eight neighbours in the picture from the lamp, those at like distances weighing more.
local function r1(at, count)
  local distance, plane = seen_from(at)
  local texel, list = 2 * math.tan(math.rad(spot.angle) / 2) / math.sqrt(count), {}
  for i, p in ipairs(at) do
    local sum, weight = 0, 0
    for k, q in ipairs(at) do
      local apart = math.sqrt((plane[i][1] - plane[k][1]) ^ 2 + (plane[i][2] - plane[k][2]) ^ 2)
      if k ~= i and apart < 1.6 * texel then
        local w = 1 / (math.abs(distance[i] - distance[k]) + 1e-3)
        sum, weight = sum + w * math.sqrt((p[1] - q[1]) ^ 2 + (p[2] - q[2]) ^ 2 + (p[3] - q[3]) ^ 2), weight + w
      end
    end
    list[i] = weight > 0 and sum / weight or 0
  end
  return list
end

--- Eqs. 24 to 26.
local function r2(at, count)
  local gamma, list = math.sqrt(2) * math.rad(spot.angle) / math.sqrt(count), {}
  for i, d in ipairs((seen_from(at))) do list[i] = d * (gamma + gamma ^ 3 / 3) end
  return list
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
    local lights = assert(scene:virtual_lights { distribution = "grid", count = count, radius = rule, scale = 1 })
    local a, n, radius = lights:arrays()
    at, facing = a:totable(), n:totable()
    return radius:totable()
  end
  local footprint = radii "footprint"
  local fixed = {}
  for k = 1, #at do fixed[k] = 0.25 end
  rows[i] = {}
  for _, rule in ipairs { { "0.25", fixed }, { "r1, Eq. 23", r1(at, count) }, { "r2, Eq. 26", r2(at, count) },
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
