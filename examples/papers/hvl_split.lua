-- Virtual lights on the surface that is shaded, baked whole and as a far part: errors by the size of voxels.
--
--     lua examples/papers/hvl_split.lua [--points 400] [--out out] [--quick]
--
-- Writes hvl_split.png. No --scene is read: lights are made here, at known places.
-- A lit floor of 400 lights, spacing 1, alone and with a lit wall of 400 that rises from it. Far parts
-- have a core R of 3 spacings. Errors of uniform grids, root mean square over points of the floor, relative: of irradiance, and
-- of coefficients (all 25, of luminance). Whole lights have no smaller error with smaller voxels: one-sided cosines are kinks
-- along the surface, and points of the floor lie between lights.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { points = 400, out = "out", scene = "", quick = false }
rooms.no_scene(option.scene, "floor and wall are made here, and their lights with them: hvl_tolerance takes a scene")
local quick = option.quick
local count = quick and 30 or option.points
local SIDE, R, LMAX = 20, 3, 4

local seed = 1
local function random() -- Park & Miller 1988
  seed = seed * 16807 % 2147483647
  return seed / 2147483647
end

local at, normal = {}, {}
for i = 0, SIDE - 1 do
  for k = 0, SIDE - 1 do
    at[#at + 1], normal[#normal + 1] = { i + random() - SIDE / 2, 0, k + random() - SIDE / 2 }, { 0, 1, 0 }
  end
end
for i = 0, SIDE - 1 do
  for k = 0, SIDE - 1 do
    at[#at + 1], normal[#normal + 1] = { -SIDE / 2, i + random(), k + random() - SIDE / 2 }, { 1, 0, 0 }
  end
end
local both = ylm.virtual_lights { at = at, normal = normal, radius = 1.5 / math.sqrt(math.pi), intensity = 1 }

--- Points of the floor where x is lo .. lo + width.
local function places(lo, width)
  local p, n = {}, {}
  for i = 1, count do p[i], n[i] = { lo + width * random(), 0, 6 * random() - 3 }, { 0, 1, 0 } end
  return ylm.array(p, "float"), ylm.array(n, "float")
end

--- Root mean square errors of a grid of `baked` at points, relative to those of `whole`: irradiance (with `near`), coefficients.
local function errors(baked, near, whole, points, normals, h, lo, width)
  local cells = { math.floor(width / h + 1.5), 2, math.floor(6 / h + 1.5) }
  local low = { lo - h / 3, -h / 2, -3 - h / 3 } -- faces of voxels are not the floor
  local box = { low, { low[1] + cells[1] * h, low[2] + cells[2] * h, low[3] + cells[3] * h } }
  local o = { channels = "luminance" }
  local grid = assert(ylm.bake(ylm.uniform_grid { bounds = box, cells = cells, lmax = LMAX, channels = "luminance",
    metric_channels = "none" }, baked))
  local got = ylm.array(grid:sample(points), "double")
  local truth, all = ylm.light_field(LMAX, baked, points, o), ylm.light_field(LMAX, whole, points, o)
  local E, wanted = ylm.sh.irradiance(got, { 0, 1, 0 }), ylm.array(ylm.sh.irradiance(all, { 0, 1, 0 }), "double")
  if near then E = E + near:irradiance(points, normals)[{ {}, { 1, 1 } }] end
  return math.sqrt(((E - wanted) ^ 2):sum() / (wanted ^ 2):sum()),
    math.sqrt(((got - truth) ^ 2):sum() / (ylm.array(all, "double") ^ 2):sum()), grid.stats.points
end

local columns = { { "error, %", "%-46s" } }
local parts = quick and { 1, 4 } or { 1, 2, 4, 8, 16 }
for _, k in ipairs(parts) do columns[#columns + 1] = { k == 1 and "R" or "R/" .. k, "%6.2f" } end
local row = common.table(columns)
local series = {}
for _, case in ipairs {
  { "wall and floor", both, both, -SIDE / 2 + 0.05, 6 }, -- name, lights, truth, points from x on, as wide
  { "floor under a ceiling", nil, nil, -3, 6 },
} do
  local lights = case[2]
  if not lights then -- lights of the floor itself send nothing to it: 400 lights over it make the light, those below the noise
    local p, n = {}, {}
    for i, y in ipairs(at) do
      if i > SIDE * SIDE then break end
      p[i], n[i] = y, { 0, 1, 0 }
    end
    for i = 1, SIDE * SIDE do p[#p + 1], n[#n + 1] = { at[i][3], 8, at[i][1] }, { 0, -1, 0 } end
    lights = ylm.virtual_lights { at = p, normal = n, radius = 1.5 / math.sqrt(math.pi), intensity = 1 }
  end
  local far, near = lights:split { core = R }
  local points, normals = places(case[4], case[5])
  for _, which in ipairs { { "whole", lights }, { "far part", far, near } } do
    local E, C = { ("%s, %s: irradiance"):format(case[1], which[1]) }, { ("%s, %s: coefficients"):format(case[1], which[1]) }
    local s = { x = {}, y = {}, label = E[1] }
    local t = { x = {}, y = {}, label = C[1], dash = "dashed" }
    for i, k in ipairs(parts) do
      local e, c = errors(which[2], which[3], lights, points, normals, R / k, case[4], case[5])
      E[i + 1], C[i + 1] = 100 * e, 100 * c
      s.x[i], s.y[i], t.x[i], t.y[i] = R / k, 100 * e, R / k, 100 * c
    end
    row(E)
    row(C)
    if case[2] then series[#series + 1], series[#series + 2] = s, t end
  end
end
print(("%d points; R = %d spacings of the lights, radius %.2f; degree %d."):format(count, R, 1.5 / math.sqrt(math.pi), LMAX))
print "Coefficients of a lit floor jump where irradiance does not: light from just below the horizon leaks nothing through the"
print "cosine. So a tolerance of irradiance (measure = 'irradiance') is what a bake on lit surfaces is to be judged by."
if not quick then
  common.save(ylm.plot { title = "A lit floor under a lit wall, 800 virtual lights, in grids", series = series, log = true,
    x_label = "voxel, spacings of the lights", y_label = "error, %, root mean square", legend = "bottom right", y_range = { 0.08,
      120 },
    caption = "Whole lights gain nothing from smaller voxels. Far parts do; what is near is summed at the points." },
    option.out .. "hvl_split.png")
end
