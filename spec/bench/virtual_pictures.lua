-- Whole pictures by many virtual lights: a million shading points of a room, two threads. Far parts lie in voxels of merged
-- lights, near parts are summed at each point; every light at every point stands beside.
--
--     build/ylm run spec/bench/virtual_pictures.lua [room] [most] [width] [least]
--
-- Rooms are those of examples/papers/hvl_scenes.lua: cornell, atrium, table_room. Steps are seconds by the clock. "processor" are
-- those of all threads together, from the lights on, and halved: two threads take them on a machine that does nothing else.
-- "every light" is measured at some 3,000 points, in processor seconds too.

local ylm = require "ylm"
local core = require "ylm.c.core"
local rooms = dofile "examples/papers/hvl_scenes.lua"

local ROOM, MOST, WIDTH = arg[1] or "atrium", tonumber(arg[2]) or 1e6, tonumber(arg[3]) or 1160
local THREADS = 2
local GOALS = { [1e4] = 0.25, [1e5] = 0.8, [1e6] = 3 }
ylm.on_warning(false)
io.stdout:setvbuf "line"

local scene = rooms[ROOM] {}
local function prepared(width)
  return assert(scene:prepare { size = { width, math.floor(0.75 * width + 0.5) }, samples = 1, gloss = "matte" })
end
local view, few = prepared(WIDTH), prepared(64)

--- Results of make() behind its processor seconds, halved, and its seconds by the clock.
local function timed(make)
  local busy, start = os.clock(), core.seconds()
  local a, b = make()
  if not a then error(b, 0) end
  return (os.clock() - busy) / THREADS, core.seconds() - start, a, b
end

local function picture(lights, sums, v)
  return timed(function()
    return (v or view):render { light_samples = 1, layers = false, threads = THREADS,
      bounced = lights, virtual = lights and { sums = sums } }
  end)
end

local plain, plain_few = picture(nil), picture(nil, nil, few) -- direct light and the image
print(("%s, %d shading points, %d threads, tolerance 0.02\n"):format(ROOM, view.stats.points, THREADS))
print("| lights | emission | split | bake | judge | far | near | clock | processor | goal | core | grid points | error, % "
  .. "| pairs a point | every light |")
print "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
local x, y, n = {}, {}, tonumber(arg[4]) or 1e4
while n <= MOST do
  local emission, _, lights = timed(function() return scene:virtual_lights { count = n, threads = THREADS } end)
  local busy, _, _, report = picture(lights, "split")
  local every = picture(lights, "all", few)
  local v = report.virtual
  local s = v.seconds
  busy = busy - plain
  every = (every - plain_few) * view.stats.points / few.stats.points
  print(("| %d | %.2f | %.3f | %.3f | %.3f | %.3f | %.3f | %.2f | %.2f | %s | %.3g | %d | %.2f | %.0f | %.0f |"):format(n,
    emission, s.split, s.bake, s.judge, s.far, s.near, s.split + s.bake + s.judge + s.far + s.near, busy, GOALS[n] or "", v.core,
    v.grid.points, 100 * v.error, v.pairs / report.points, every))
  x[#x + 1], y[#y + 1], n = math.log(n), math.log(busy), 10 * n
end
if #x > 1 then print(("\nTime grows as the power %.2f of the number of lights."):format((y[#y] - y[1]) / (x[#x] - x[1]))) end
