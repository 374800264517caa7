-- Profiles of virtual lights near a lit floor: what a wall that stands on it receives, and what a grid makes of it.
--
--     lua examples/papers/hvl_profiles.lua [--floors 20] [--out out] [--quick]
--
-- Writes hvl_profiles.png. No --scene is read: truth is a closed form.
-- 400 matte lights stand on a jittered 20 x 20 grid of spacing 1 and shine up; the wall rises from the
-- floor's edge. Mezieres & Paulin 2022 have profile "cap", and H (Eq. 22) beside it, which takes lights near the receiver's
-- horizon away. Points have no profile; clamped ones are bounded by 1/r^2. The truth is a floor of the same flux everywhere, in
-- closed form. Lights have radius k spacings, as discs of k = 1.5/sqrt(pi) times the area they stand for would; degree 4.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { floors = 20, out = "out", scene = "", quick = false }
rooms.no_scene(option.scene, "truth is a closed form of the floor that is made here: hvl_methods takes a scene")
local quick, floors = option.quick, option.quick and 2 or option.floors
local SIDE, LMAX = 20, 4

local seed = 1
local function random() -- Park & Miller 1988
  seed = seed * 16807 % 2147483647
  return seed / 2147483647
end

--- Places of lights, one in each square of the floor 0 .. 20 x -10 .. 10, y = 0.
local function floor_of_lights()
  local at, normal = {}, {}
  for i = 0, SIDE - 1 do
    for k = 0, SIDE - 1 do
      at[#at + 1], normal[#normal + 1] = { i + random(), 0, k + random() - SIDE / 2 }, { 0, 1, 0 }
    end
  end
  return at, normal
end

--- Irradiance of a point (0, h, z) of the wall by the floor of radiance 1 (Lambert: sum of angles of edges times cosines).
local function truth(h, z)
  local corners = { { 0, -SIDE / 2 - z }, { SIDE, -SIDE / 2 - z }, { SIDE, SIDE / 2 - z }, { 0, SIDE / 2 - z } }
  local sum = 0
  for i, a in ipairs(corners) do
    local b = corners[i % 4 + 1]
    local p, q = { a[1], -h, a[2] }, { b[1], -h, b[2] }
    local cx = p[2] * q[3] - p[3] * q[2]
    local cross = math.sqrt(cx ^ 2 + (p[3] * q[1] - p[1] * q[3]) ^ 2 + (p[1] * q[2] - p[2] * q[1]) ^ 2)
    local dot = p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
    if cross > 0 then sum = sum + cx / cross * (math.atan2 or math.atan)(cross, dot) end
  end
  return math.abs(sum) / 2
end

--- The paper's Eq. 22 for a cap of half-angle a whose middle has cosine c to the normal.
local function paper_horizon(c, a)
  local lo, hi = math.pi / 2 - a, math.pi / 2 + a
  local x = (hi - math.min(math.max(math.acos(c), lo), hi)) / (2 * a)
  return 3 * x * x - 2 * x * x * x
end

-- Over the height of the wall --------------------------------------------------------------------

local heights = { 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3 }
local points, normals = {}, {}
for i, h in ipairs(heights) do points[i], normals[i] = { 0, h, 0 }, { 1, 0, 0 } end

local methods = {} -- name, what a floor gives at the heights
local function harmonics(name, profile, k)
  local radius = k -- spacings
  methods[#methods + 1] = { name, function(at, normal)
    local lights = ylm.virtual_lights { at = at, normal = normal, radius = radius, intensity = 1, profile = profile }
    local L = ylm.light_field(LMAX, lights, points, { channels = "luminance", dtype = "double" })
    local E = ylm.sh.irradiance(L, normals[1])
    local list = {}
    for i = 1, #heights do list[i] = E:get(i, 1) end
    return list
  end }
end

local function exactly(name, weight)
  methods[#methods + 1] = { name, function(at)
    local list = {}
    for i, h in ipairs(heights) do
      local sum = 0
      for _, y in ipairs(at) do
        local d2 = y[1] ^ 2 + h ^ 2 + y[3] ^ 2
        local d = math.sqrt(d2)
        sum = sum + weight(y[1] / d, h / d, d2) -- cosines at the wall and at the light
      end
      list[i] = sum
    end
    return list
  end }
end

local K = 1.5
exactly("points", function(c, e, d2) return c * e / d2 end)
exactly("points, clamped", function(c, e, d2) return math.min(c * e / d2, 1 / K ^ 2) end)
exactly("cap, Eq. 22, cosine", function(c, e, d2)
  if d2 <= K * K then return c * e / K ^ 2 * paper_horizon(c, math.pi / 2) end
  return c * e / d2 * paper_horizon(c, math.asin(K / math.sqrt(d2)))
end)
harmonics("cap", "cap", K)
harmonics("gauss", "gauss", K)
harmonics("cap, k = 1", "cap", 1)
harmonics("gauss, k = 1", "gauss", 1)

local sums = {}
for m = 1, #methods do
  sums[m] = {}
  for i = 1, #heights do sums[m][i] = { 0, 0 } end
end
for _ = 1, floors do
  local at, normal = floor_of_lights()
  for m, method in ipairs(methods) do
    for i, E in ipairs(method[2](at, normal)) do
      local ratio = E / truth(heights[i], 0)
      sums[m][i][1], sums[m][i][2] = sums[m][i][1] + ratio / floors, sums[m][i][2] + (ratio - 1) ^ 2 / floors
    end
  end
end

local columns = { { "irradiance / truth at height", "%-28s" } }
for _, i in ipairs { 1, 2, 3, 4, 6, 8, 10 } do columns[#columns + 1] = { tostring(heights[i]), "%5.3f" } end
columns[#columns + 1] = { "rms", "%5.3f" }
local row = common.table(columns)
local series = {}
for m, method in ipairs(methods) do
  local cells, square = { method[1] }, 0
  for _, i in ipairs { 1, 2, 3, 4, 6, 8, 10 } do cells[#cells + 1] = sums[m][i][1] end
  series[m] = { x = heights, y = {}, label = method[1] }
  for i = 1, #heights do
    square = square + sums[m][i][2] / #heights
    series[m].y[i] = sums[m][i][1]
  end
  cells[#cells + 1] = math.sqrt(square)
  row(cells)
end
print(("%d floors; rms over heights and floors. Heights in spacings of lights."):format(floors))
print "gauss is dark near the edge and never too bright; cap is, above half a radius, which offsets its deficit in the mean. With"
print "Eq. 22 the receiver's cosine counts twice near its horizon: the overshoot goes, and so does light that is right."

-- Grids ---------------------------------------------------------------------------------------------

--- Root mean square of a Hermite cubic's error over a vertical line of heights lo .. hi, relative to the norm, voxels of size h.
local function hermite(lights, lo, hi, h)
  local n = math.max(1, math.floor((hi - lo) / h + 0.5))
  local knots, between, step = {}, {}, (hi - lo) / n
  for i = 0, n do knots[i + 1] = { 2.2, lo + step * i, 0.3 } end
  local PER = 7
  for i = 0, n - 1 do
    for k = 1, PER do between[#between + 1] = { 2.2, lo + step * (i + k / (PER + 1)), 0.3 } end
  end
  local o = { channels = "luminance", dtype = "double", derivatives = 1 }
  local L, dL = ylm.light_field(LMAX, lights, knots, o)
  local T = ylm.light_field(LMAX, lights, between, { channels = "luminance", dtype = "double" })
  local Q, t = (LMAX + 1) ^ 2, {}
  for k = 1, PER do t[k] = k / (PER + 1) end
  t = ylm.array(t):reshape { 1, PER, 1 }
  local function of_knots(values) return values[{ 1, n }]:reshape { n, 1, Q }, values[{ 2, n + 1 }]:reshape { n, 1, Q } end
  local L0, L1 = of_knots(L)
  local d0, d1 = of_knots(step * dL[{ {}, {}, {}, 2 }])
  local value = (2 * t ^ 3 - 3 * t ^ 2 + 1) * L0 + (t ^ 3 - 2 * t ^ 2 + t) * d0 + (3 * t ^ 2 - 2 * t ^ 3) * L1
    + (t ^ 3 - t ^ 2) * d1                                            -- [voxels][PER][Q]
  T = T:reshape { n, PER, Q }
  return math.sqrt(((value - T) ^ 2):sum() / (T ^ 2):sum())
end

local at, normal = floor_of_lights()
for i, p in ipairs(at) do at[i] = { p[1] - 8, 0, p[3] } end -- lines stand well within the floor
print ""
local grid_row = common.table { { "voxels: relative error, heights", "%-32s" }, { "r", "%8.1e" }, { "r/2", "%8.1e" }, { "r/4",
  "%8.1e" },
  { "r/8", "%8.1e" }, { "r/16", "%8.1e" }, { "order", "%5.1f" } }
local R = 1.5
for _, case in ipairs { { "cap", 0.1, 0.6 }, { "gauss", 0.1, 0.6 }, { "cap", 0.6, 2 }, { "gauss", 0.6, 2 } } do
  local lights = ylm.virtual_lights { at = at, normal = normal, radius = R, intensity = 1, profile = case[1] }
  local cells = { ("%s, %g r to %g r"):format(case[1], case[2], case[3]) }
  for i, part in ipairs { 1, 2, 4, 8, 16 } do cells[i + 1] = hermite(lights, case[2] * R, case[3] * R, R / part) end
  cells[7] = math.log(cells[4] / cells[6]) / math.log(4)
  grid_row(cells)
end
print "A cap has a kink where a light is one radius away: cubics gain little from smaller voxels. gauss has all derivatives."

if not quick then
  common.save(ylm.plot { title = "A wall on a floor of 400 virtual lights", series = series, x_log = true, y_range = { 0.2, 1.3 },
    x_label = "height over the floor, spacings of lights", y_label = "irradiance / that of an even floor",
    caption = ("Mean of %d floors; radius 1.5 spacings but where k = 1. Cap and Eq. 22: Mezieres & Paulin 2022."):format(floors),
    legend = "bottom right" }, option.out .. "hvl_profiles.png")
end
