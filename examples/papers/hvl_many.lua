-- Many virtual lights: time and error of all lights at all points, and of far parts in voxels with near parts summed, over the
-- number of lights.
--
--     lua examples/papers/hvl_many.lua [--room atrium] [--scene FILE] [--most 100000] [--width 1160] [--tolerance 0.02]
--         [--out out] [--quick]
--
-- Writes hvl_many.png. Processor seconds, all threads together, of the bounce in a picture of --width pixels (1160: a million),
-- behind emission, which stands beside them: twice those of spec/bench/virtual_pictures.lua, which halves them for two threads.
-- Each particle is a light and glossy surfaces are matte, as there. "all" of more than 1,000 lights is measured at 1,000
-- points and scaled. "error" is what scene:render judges: of irradiance, root mean square over its mean, beside all lights; no
-- noise of the lights is in it.
-- Rooms: cornell, atrium, table_room.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { room = "atrium", scene = "", most = 100000, width = 1160, tolerance = 0.02, out = "out",
  quick = false }
local quick = option.quick
local width = quick and 24 or option.width
local clock = os.clock -- of the processor, all threads together: others that run beside do not count
ylm.on_warning(false)

local scene = rooms.given(option.scene, option.room, { detail = quick and 0.3 or 1 })
local function prepared(w)
  return assert(scene:prepare { size = { w, math.floor(0.75 * w + 0.5) }, samples = 1, gloss = "matte" })
end
local view, few = prepared(width), prepared(quick and 8 or 36)
local points, some = view.stats.points, few.stats.points
print(("%s triangles, %s shading points; tolerance %g of irradiance"):format(common.thousands(rooms.triangles(scene)),
  common.thousands(points), option.tolerance))

--- Processor seconds of f, and its results.
local function timed(f)
  local start = clock()
  local a, b = f()
  if a == nil then error(b, 0) end
  return clock() - start, a, b
end

local row = common.table { { "lights", "%9s" }, { "emission", "%8.3f" }, { "all", "%9.3f" }, { "split", "%8.3f" },
  { "times faster", "%12.1f" }, { "core", "%6.3f" }, { "grid points", "%11d" }, { "near pairs a point", "%18.1f" },
  { "error, %", "%8.2f" } }
local all, split = { x = {}, y = {}, label = "all lights at all points" }, { x = {}, y = {},
  label = "far parts in voxels, near parts summed" }
local direct = timed(function() return view:render { layers = false } end)
local n = 100
while n <= (quick and 1000 or option.most) do
  local o = { count = n }
  local emission, lights = timed(function() return scene:virtual_lights(o) end)
  local which, scaled = n > 1000 and few or view, n > 1000 and points / some or 1
  local whole = timed(function()
    return which:render { by = "none", bounced = lights, virtual = { sums = "all" }, layers = false }
  end) * scaled
  local seconds, _, report = timed(function()
    return view:render { bounced = assert(scene:virtual_lights(o)), virtual = { sums = "split", tolerance = option.tolerance },
      layers = false }
  end)
  local v, parts = report.virtual, math.max(1e-3, seconds - direct - emission)
  row { common.thousands(lights.count), emission, whole, parts, whole / parts, v.core, v.grid.points, v.pairs / points,
    100 * v.error }
  all.x[#all.x + 1], all.y[#all.y + 1] = lights.count, whole
  split.x[#split.x + 1], split.y[#split.y + 1] = lights.count, parts
  n = 10 * n
end
print(("time over lights grows as their power: all %.2f, split %.2f"):format(common.slope(all.x, all.y),
  common.slope(split.x, split.y)))
print "All lights cost a pair for each point. Far parts lie in voxels, of merged lights. Near parts are summed one by one."
print "Cores shrink as lights grow in number, so that a point has some tens to hundreds of them nearby."
if not quick then
  common.save(ylm.plot { title = "One bounce of many virtual lights", series = { all, split }, log = true,
    x_label = "virtual lights",
    y_label = "processor seconds, behind emission", legend = "top left",
    caption = ("%s, %s shading points; far parts to a tolerance of %g of irradiance."):format(option.scene == ""
      and option.room:gsub("_", " ") or option.scene, common.thousands(points), option.tolerance) }, option.out .. "hvl_many.png")
end
