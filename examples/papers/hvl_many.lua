-- Many virtual lights: time and error of all lights at all points, of sums to a tolerance, and of far parts baked with near parts
-- summed, over the number of lights.
--
--     lua examples/papers/hvl_many.lua [--room atrium] [--scene FILE] [--most 100000] [--width 480] [--tolerance 0.02]
--         [--depth 9] [--out out] [--quick]
--
-- Writes hvl_many.png. Processor seconds, all threads together, of a picture of a million shading points, behind emission: of
-- those measured on a view of --width pixels, sums at points are scaled, bakes are not. "every light" and sums to a tolerance
-- are measured at some 1,000 points where lights are more than 1,000. Errors are root mean square, relative to the mean, beside
-- every light at 1,000 points: of irradiance, and no noise of the lights is in them. Rooms: cornell, atrium, table_room.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { room = "atrium", scene = "", most = 100000, width = 480, tolerance = 0.02, depth = 9, out = "out",
  quick = false }
local quick = option.quick
local width = quick and 24 or option.width
local clock = os.clock -- of the processor, all threads together: others that run beside do not count
ylm.on_warning(false)

local scene = rooms.given(option.scene, option.room, { detail = quick and 0.3 or 1 })
local view = assert(scene:prepare { size = { width, math.floor(0.75 * width) }, samples = 1, visibility = "none" })
local few = assert(scene:prepare { size = { quick and 8 or 36, quick and 6 or 27 }, samples = 1, visibility = "none" })
local held = few:points()
local MILLION = 1e6
local count = #view:points().position
print(("%s triangles, %s shading points; a bake's tolerance %g of irradiance"):format(common.thousands(rooms.triangles(scene)),
  common.thousands(count), option.tolerance))

local row = common.table { { "lights", "%9s" }, { "emission", "%8.3f" }, { "every", "%9.3f" }, { "sum to 0.01", "%11.3f" },
  { "pairs of all", "%12.4f" }, { "bake", "%7.3f" }, { "points", "%8d" }, { "near", "%7.3f" }, { "split", "%8.3f" },
  { "error, %", "%8.2f" } }
local every, summed, split = { x = {}, y = {}, label = "every light" }, { x = {}, y = {}, label = "sums to 0.01" },
  { x = {}, y = {}, label = "far parts baked, near parts summed" }
local function put(s, x, y) s.x[#s.x + 1], s.y[#s.y + 1] = x, y end

local n = 100
while n <= (quick and 1000 or option.most) do
  local start = clock()
  local lights = assert(scene:virtual_lights { count = n, particles = 2 * n })
  local emission = clock() - start
  local brute = n > 1000 and few or view
  start = clock()
  assert(brute:gather { lights = lights, layers = false })
  local all = (clock() - start) * MILLION / #brute:points().position
  local truth = rooms.irradiance(ylm.light_field(4, lights, held.position), held.normal)
  start = clock()
  local _, _, _, sums = ylm.light_field(4, lights, held.position, { tolerance = 0.01 })
  local sum = (clock() - start) * MILLION / #held.position
  local less = sums.pairs / (lights.count * #held.position)

  local far, near = lights:split { scene = scene, points = MILLION }
  start = clock()
  local grid = assert(scene:bake { lights = far, occupied = view, probes = ylm.adaptive_grid { lmax = 4, depth = quick and 3
    or option.depth, tolerance = option.tolerance, measure = "irradiance" } })
  local bake = clock() - start
  local best = math.huge
  for _ = 1, quick and 1 or 3 do
    start = clock()
    assert(view:render { grid = grid, near = near, layers = false })
    best = math.min(best, clock() - start)
  end
  local shade = best * MILLION / count
  local E = rooms.irradiance(grid:sample(held.position), held.normal)
  rooms.add(E, near:irradiance(held.position, held.normal))
  row { common.thousands(lights.count), emission, all, less < 0.99 and sum or nil, less < 0.99 and less or nil, bake,
    grid.stats.points,
    shade, bake + shade, 100 * rooms.rms(E, truth) }
  put(every, lights.count, all)
  if less < 0.99 then put(summed, lights.count, sum) end
  put(split, lights.count, bake + shade)
  n = 10 * n
end
if #split.x > 1 then
  print(("time over lights grows as their power: every light %.2f, split %.2f"):format(common.slope(every.x, every.y),
    common.slope(split.x, split.y)))
end
print "Every light costs a pair for each point. A bake asks lights at its own points, whose number grows little with that of"
print "lights, as cores shrink; near parts reach 1.6 cores, so that a point has some tens to hundreds of them whatever the"
print "number."
if not quick then
  common.save(ylm.plot { title = "A picture of a million points under many virtual lights",
    series = #summed.x > 0 and { every, summed, split } or { every, split }, log = true, x_label = "virtual lights",
    y_label = "processor seconds, behind emission", legend = "top left",
    caption = ("%s; grids to a tolerance of %g of irradiance."):format(option.scene == "" and option.room:gsub("_",
      " ") or option.scene,
      option.tolerance) }, option.out .. "hvl_many.png")
end
