-- Adaptive grids of virtual lights on the surfaces that they lie on, by what their tolerance is of: coefficients or irradiance;
-- and sums of lights to a tolerance.
--
--     lua examples/papers/hvl_tolerance.lua [--room cornell] [--scene FILE] [--lights 2000] [--depth 7] [--width 96] [--quick]
--
-- Writes hvl_tolerance.png. "found" is the error of irradiance at shading points that no bake saw, of far parts with their
-- near parts. Errors are root mean square, relative to the mean. Coefficients below the horizon of a lit floor jump where
-- irradiance does not.
-- Rooms: cornell, atrium, table_room.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { room = "cornell", scene = "", lights = 2000, depth = 7, width = 96, out = "out", quick = false }
local quick = option.quick
local width, depth = quick and 12 or option.width, quick and 3 or option.depth
local clock = require "ylm.c.core".seconds
ylm.on_warning(false)

local scene = rooms.given(option.scene, option.room, { detail = quick and 0.3 or 1 })
local count = quick and 100 or option.lights
local lights = assert(scene:virtual_lights { count = count, particles = 10 * count })
local far, near = lights:split {}
local view = assert(scene:prepare { size = { width, width }, samples = 1, visibility = "none" })
local other = assert(scene:prepare { size = { width + 7, width + 7 }, samples = 1, visibility = "none" }):points()
local held = rooms.some(other, quick and 100 or 2000)
local truth = rooms.irradiance(ylm.light_field(4, lights, held.position), held.normal)
print(("%d lights, spacing about %.3f, core %.3f; depth %d"):format(lights.count, lights.radius.mean * math.sqrt(math.pi) / 1.5,
  far.core,
  depth))

local row = common.table { { "lights", "%-6s" }, { "tolerance of", "%-13s" }, { "tolerance", "%9.3f" }, { "points", "%8d" },
  { "seconds", "%7.2f" }, { "error", "%7.4f" }, { "met", "%-3s" }, { "found, %", "%8.2f" } }
local series = {}
for _, case in ipairs { { "whole", lights, "coefficients" }, { "whole", lights, "irradiance" }, { "far", far, "coefficients" },
  { "far", far, "irradiance" } } do
  local s = { x = {}, y = {}, label = ("%s, %s"):format(case[1], case[3]) }
  for _, tolerance in ipairs(quick and { 0.1 } or { 0.2, 0.1, 0.05, 0.02, 0.01 }) do
    local start = clock()
    local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = 4, depth = depth, tolerance = tolerance, measure = case[3] }, case[2],
      { occupied = view }))
    local seconds = clock() - start
    local E = rooms.irradiance(grid:sample(held.position), held.normal)
    if case[1] == "far" then E = E + near:irradiance(held.position, held.normal) end
    local found = 100 * rooms.rms(E, truth)
    row { case[1], case[3], tolerance, grid.stats.points, seconds, grid.stats.error, grid.stats.met and "yes" or "no", found }
    s.x[#s.x + 1], s.y[#s.y + 1] = grid.stats.points, found
  end
  series[#series + 1] = s
end
print "Why: whole lights bend on the scale of their radius between lights; whatever the measure, voxels shrink to that. Far"
print "parts bend on the scale of the core. A tolerance of irradiance takes fewer points than one of coefficients where errors"
print "are alike."

-- Sums to a tolerance ------------------------------------------------------------------------------

local _, _, _, exact = ylm.light_field(4, lights, held.position)
local tree = common.table { { "sum to", "%6.3f" }, { "pairs of all", "%12.3f" }, { "median", "%7.3f" }, { "99 %", "%6.3f" },
  { "99.9 %", "%6.3f" }, { "most", "%6.3f" } }
local L0 = ylm.array(ylm.light_field(4, lights, held.position), "double")
local norms = (L0 ^ 2):sum(2, 3):sqrt()
local scale = norms:clamp(norms:mean())
for _, tolerance in ipairs { 0.1, 0.01, 0.001 } do
  local L, _, _, report = ylm.light_field(4, lights, held.position, { tolerance = tolerance })
  local list = (((L - L0) ^ 2):sum(2, 3):sqrt() / scale / tolerance):totable()
  table.sort(list)
  local function q(p) return list[math.max(1, math.ceil(p * #list))] end
  tree { tolerance, report.pairs / exact.pairs, q(0.5), q(0.99), q(0.999), list[#list] }
end
print "Errors of coefficients over the tolerance, relative to their norm or its mean, whichever is larger."
if not quick then
  common.save(ylm.plot { title = "Grids of virtual lights, by what a tolerance is of", series = series, log = true,
    x_label = "points of the grid",
    y_label = "error of irradiance, % of the mean", legend = "bottom left",
    caption = ("%d lights, tolerances 0.2 to 0.01, depth %d; far parts with their near parts."):format(lights.count, depth) },
    option.out .. "hvl_tolerance.png")
end
