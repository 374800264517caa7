-- Files of a grid of 206,151 evaluated points (lmax 4, rgb, continuous): size by section, wall and processor seconds of
-- saving and loading, and of loading the FILES that are named.
--
--     build/ylm run spec/bench/grid_file.lua [FILE ...]

local core = require "ylm.c.core"
local grid_file = require "ylm.grid.file"
local ylm = require "ylm"

--- Numbers from 0 to 1, the same every time.
local function random(seed)
  return function()
    seed = seed * 48271 % 2147483647
    return seed / 2147483647
  end
end

--- n points in {-1, 1}^3.
local function points(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do t[i] = { 2 * r() - 1, 2 * r() - 1, 2 * r() - 1 } end
  return ylm.array(t, "double")
end

--- Calls a function; prints the least wall and processor seconds of three.
local function timed(name, f)
  local wall, cpu = math.huge, math.huge
  for _ = 1, 3 do
    local t, c = core.seconds(), os.clock()
    local result = assert(f())
    wall, cpu = math.min(wall, core.seconds() - t), math.min(cpu, os.clock() - c)
    if core.type(result) == "ylm.grid" then result:close() end
  end
  print(("%-32s %6.2f s, %6.2f s of processor time"):format(name, wall, cpu))
end

local r, at, radius, radiance = random(91), {}, {}, {}
for i = 1, 60 do
  at[i], radius[i], radiance[i] = { 4 * r() - 2, 4 * r() - 2, 4 * r() - 2 }, 0.05 * (0.1 + r() ^ 4), { r(), r(), r() }
end
local lamps = ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, depth = 8, threshold = 0.15 },
  lamps, { occupied = points(600000, 7) }))
local path = os.tmpname() .. ".ylm"
timed("save", function() return grid:save(path) end)
timed("load", function() return ylm.load(path) end)
local look = assert(grid_file.look(path))
print(("%d evaluated points, %d interpolated, %.1f MB"):format(grid.stats.points, grid.stats.interpolated, look.bytes / 1e6))
for _, s in ipairs(look.sections) do print(("  %-8s %8.1f MB"):format(s.name, s.bytes / 1e6)) end
os.remove(path)
for _, name in ipairs(arg) do timed("load " .. name, function() return ylm.load(name) end) end
