-- Light behind bodies that are hard for spherical harmonics: thin, concave, touching, on the floor. Irradiance of the floor
-- beside rays, and probes of the shadowed light.
--
--     make bench BENCH=shadow_bodies
--
-- All bodies are made of boxes, so that rays are counted in closed form. Crosses are no convex solids: they are known by rays.

local boxes = require "spec.support.boxes"
local ylm = require "ylm"

local sh = ylm.sh
local quick = os.getenv "BENCH" == "quick"
local BODIES, PLACES, SIDE, RAYS = 8, quick and 4 or 48, quick and 20 or 150, quick and 32 or 64
local TOLERANCE = 0.05
local smooth = { math.sqrt(4 * math.pi), 0.3, 0.5, -0.4, 0.2, 0.1, -0.2, 0.15, 0.1 } -- coefficients of the light

local random = require "spec.support.random".from(7)

local rays = boxes.rays(SIDE)
local light = sh.reconstruct(smooth, rays):totable()

--- A closed mesh of boxes of half sizes.
local function mesh(list)
  local positions, triangles = {}, {}
  for _, h in ipairs(list) do
    local m = ylm.box { bounds = { { -h[1], -h[2], -h[3] }, { h[1], h[2], h[3] } } }
    local first = #positions
    for _, p in ipairs(m.mesh:vertices():totable()) do positions[#positions + 1] = p end
    for _, t in ipairs(m.mesh:triangles():totable()) do
      triangles[#triangles + 1] = { t[1] + first, t[2] + first, t[3] + first }
    end
  end
  return ylm.mesh { vertices = positions, triangles = triangles }
end

--- Places of eight bodies, turned: { at, turn }.
local function scattered(height)
  local at, turn = {}, {}
  for i = 1, BODIES do
    local phi, r = 2 * math.pi * i / BODIES, 0.6 + 1.4 * random()
    at[i] = { r * math.cos(phi), r * math.sin(phi), height or 0.7 + 0.9 * random() }
    turn[i] = height and { 1, 0, 0, random() } or { random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5 }
  end
  return at, turn
end

--- Eight cubes in pairs that share a face.
local function pairs_of_cubes(size)
  local at, turn = scattered()
  for i = 2, BODIES, 2 do
    local m = boxes.matrix(turn[i - 1])
    at[i] = { at[i - 1][1] + size * m[1], at[i - 1][2] + size * m[4], at[i - 1][3] + size * m[7] }
    turn[i] = turn[i - 1]
  end
  return at, turn
end

local function case(name, list, at, turn) return { name = name, boxes = list, at = at, turn = turn } end
local cube, bar = { { 0.25, 0.25, 0.25 } }, { { 0.45, 0.09, 0.09 }, { 0.09, 0.45, 0.09 }, { 0.09, 0.09, 0.45 } }
local cases = {
  case("cubes", cube, scattered()),
  case("plates, 1 : 30", { { 0.45, 0.45, 0.015 } }, scattered()),
  case("crosses of three bars, by rays", bar, scattered()),
  case("cubes that touch, in pairs", cube, pairs_of_cubes(0.5)),
  case("cubes that stand on the floor", cube, scattered(0.25)),
}

print(("Irradiance behind %d bodies at %d places of a floor: rms distance from %d rays a place, %% of the unshadowed.")
  :format(BODIES, PLACES, #rays))
print(("Probes: those of shadowed light over the floor, n = 10, tolerance %g, bodies from grids."):format(TOLERANCE))
print()
print "| bodies | n = 5 | n = 10 | n = 15 | probes | largest error at 99 % | met |"
print "| --- | --: | --: | --: | --: | --: | --- |"

for _, c in ipairs(cases) do
  local turned, places, truth, open = {}, {}, {}, 0
  for i = 1, BODIES do turned[i] = boxes.matrix(c.turn[i]) end
  --- Is the place inside of a body that stands there?
  local function covered(p)
    for i = 1, BODIES do
      for _, h in ipairs(c.boxes) do
        local above = boxes.meets(h, c.at[i], turned[i], { p[1], p[2], 1e-9 }, { 0, 0, 1 })
        if above and c.at[i][3] <= h[3] + 1e-9 then return true end
      end
    end
  end
  while #places < PLACES do
    local p = { 4 * random() - 2, 4 * random() - 2, 0 }
    if not covered(p) then places[#places + 1] = p end
  end
  for k = 1, #rays do open = open + light[k] end
  open = open / #rays * math.pi
  for n, p in ipairs(places) do
    local sum = 0
    for k, w in ipairs(rays) do
      local free = true
      for i = 1, BODIES do
        for _, h in ipairs(c.boxes) do free = free and not boxes.meets(h, c.at[i], turned[i], p, w) end
      end
      if free then sum = sum + light[k] end
    end
    truth[n] = sum / #rays * math.pi
  end
  local shape = mesh(c.boxes)
  local body = ylm.occluder { geometry = shape, rays = #c.boxes > 1 and RAYS or nil }
  local row = { c.name }
  for _, lmax in ipairs { 4, 9, 14 } do
    local shade = ylm.shadowed { lights = ylm.environment_light { coefficients = sh.resize(smooth, lmax) },
      casters = ylm.casters { hides = body, at = c.at, rotation = c.turn } }
    local L, sum = ylm.light_field(lmax, shade, places, { channels = "luminance", dtype = "double" }):totable(), 0
    for i = 1, PLACES do sum = sum + ((sh.irradiance(L[i][1], { 0, 0, 1 }) - truth[i]) / open) ^ 2 end
    row[#row + 1] = ("%.2f"):format(100 * math.sqrt(sum / PLACES))
  end
  local field = assert(ylm.bake(ylm.adaptive_grid { lmax = 9, depth = quick and 5 or 9, tolerance = 0.05,
    channels = "luminance" }, body))
  local shade = ylm.shadowed { lights = ylm.environment_light { coefficients = sh.resize(smooth, 9) },
    casters = ylm.casters { hides = field, at = c.at, rotation = c.turn } }
  local floor, side = {}, quick and 30 or 150
  for x = 0, side do
    for y = 0, side do
      local p = { 5 * x / side - 2.5, 5 * y / side - 2.5, 0 }
      if not covered(p) then floor[#floor + 1] = p end
    end
  end
  local probes = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -2.6, -2.6, -0.1 }, { 2.6, 2.6, 5.1 } }, lmax = 9,
    depth = quick and 5 or 9, tolerance = TOLERANCE, channels = "luminance" }, shade, { occupied = ylm.array(floor, "float") }))
  row[#row + 1] = ("%d"):format(probes.stats.points)
  row[#row + 1] = ("%.3f"):format(probes.stats.error)
  row[#row + 1] = probes.stats.met and "yes" or "no"
  print("| " .. table.concat(row, " | ") .. " |")
end
