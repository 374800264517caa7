-- Memory: bytes per point of grids of about 10^5 points and per shading point of a prepared view. Bytes are those that they
-- count (grid.stats.bytes) and those by which the process grows; with the argument `big` a bake of 10^6 points under
-- 10^4 lights, with its peak, processor time and calls of progress. lmax 4, rgb. Resident memory is read from /proc, so on Linux.
--
--     build/ylm run spec/bench/memory.lua [big [threads]]

local ylm = require "ylm"

local MIB = 2 ^ 20

--- Bytes of the line `name` of /proc/self/status; nil elsewhere.
local function status(name)
  local file = io.open "/proc/self/status"
  if not file then return nil end
  local kib = file:read("*a"):match(name .. ":%s*(%d+)")
  file:close()
  return tonumber(kib) * 1024
end

local function resident()
  collectgarbage()
  collectgarbage()
  return status "VmRSS"
end

--- n small lamps in a box of 4 x 2 x 4, the same every time.
local function lamps(n)
  local at, x = {}, 4321
  local function random()
    x = x * 48271 % 2147483647
    return x / 2147483647
  end
  for i = 1, n do at[i] = { 4 * random() - 2, 2 * random(), 4 * random() - 2 } end
  return ylm.sphere_lights { at = at, radius = 0.01, radiance = { 3, 2, 1 } }
end

local box = { { -2, 0, -2 }, { 2, 2, 2 } }
local grown = {} -- what was measured stays, so that the next is not made of its pages

--- Makes something, and prints how much the process has grown for each of its `n` points, and what it counts itself.
local function measure(name, make, points, counted)
  local before = resident()
  local made = make()
  local after, n = resident(), points(made)
  grown[#grown + 1] = made
  print(("%-46s %8d points  counted %s  resident %s bytes each"):format(name, n,
    counted and ("%6.0f"):format(counted(made) / n) or "     -",
    after and ("%6.0f"):format((after - before) / n) or "not known"))
end

local function evaluated(grid) return grid.stats.points end
local function bytes(grid) return grid.stats.bytes end

local function per_point()
  local few = lamps(20)
  for _, dynamic in ipairs { false, true } do
    local kind = dynamic and ", dynamic" or ""
    measure("uniform grid, 45^3 voxels" .. kind, function()
      return assert(ylm.bake(ylm.uniform_grid { bounds = box, cells = 45, lmax = 4, dynamic = dynamic }, few))
    end, evaluated, bytes)
    measure("adaptive grid, tolerance 0.005" .. kind, function()
      return assert(ylm.bake(ylm.adaptive_grid { bounds = box, depth = 6, tolerance = 0.005, dynamic = dynamic }, few))
    end, function(grid) return grid.stats.points + grid.stats.interpolated end, bytes)
  end
  local scene = assert(ylm.load "examples/scenes/floor_lights.lua")
  local stage = ylm.scene(scene.name) { camera = scene.camera, geometry = scene.geometry, lights = {} }
  -- the traced scene is not the view's
  assert(stage:prepare { size = { 8, 8 }, samples = 1, transfer_samples = 1, visibility = "transfer" })
  measure("prepared view, 480 x 270, 4 samples a pixel", function()
    return assert(stage:prepare { size = { 480, 270 }, samples = 4, transfer_samples = 4, visibility = "transfer" })
  end, function(view) return #view:points().position end)
end

local function big(threads)
  local calls, many = 0, lamps(10000)
  local begin, clock = os.time(), os.clock()
  local grid = assert(ylm.bake(ylm.uniform_grid { bounds = box, cells = 99, lmax = 4 }, many, { threads = threads,
    progress = function() calls = calls + 1 end }))
  local seconds = os.clock() - clock
  print(("%d points, %d lights, %.3g pairs: %.1f s of processor time (%.1f ns a pair), %d s on the clock"):format(
    grid.stats.points, 10000, grid.stats.pairs, seconds, 1e9 * seconds / grid.stats.pairs, os.time() - begin))
  local peak = status "VmHWM"
  print(("peak %s MiB, the grid %.0f MiB, %d calls of progress"):format(peak and ("%.0f"):format(peak / MIB) or "not known",
    grid.stats.bytes / MIB, calls))
end

if arg[1] == "big" then big(tonumber(arg[2])) else per_point() end
