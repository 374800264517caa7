-- A grid in bricks beside the same grid in memory: time and points of its bake, speed of its samples. One thread; ratios are of
-- the processor's time.
--
--     make bench BENCH=bricks
--
-- Samples are as many as evaluated points, on the surface that was baked for, sorted by place. A cache of 1 MB holds no brick:
-- each is read from the page cache of the system once in every pass. The last bricks are as large as `brick_points` lets them be.

local core = require "ylm.c.core"
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local folder = (os.getenv "TMPDIR" or "/tmp") .. "/ylm_bench_bricks.ylmd"
local at = {}
for i = 1, 100 do
  local t = i * 2.399963
  at[i] = { 1.6 * math.cos(t), 1.6 * (2 * i / 101 - 1), 1.6 * math.sin(t) }
end
local lights = ylm.sphere_lights { at = at, radius = 0.02, radiance = 3 }
local ball = ylm.sphere { radius = 0.95, divide = { 256, 128 } }

--- Seconds by the clock, of the processor, and what f returns.
local function timed(f)
  local begun, processor = core.seconds(), os.clock()
  local result = assert(f())
  return core.seconds() - begun, os.clock() - processor, result
end

local function grid_of(bricks)
  return ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 4, depth = quick and 5 or 8, threshold = 0,
    bricks = bricks }
end

--- n points of the ball, those of each voxel of level 5 together.
local function places(n)
  local list = {}
  for k = 1, n do
    local y, t = 2 * k / (n + 1) - 1, k * 2.399963
    local r = math.sqrt(1 - y * y)
    local p = { 0.95 * r * math.cos(t), 0.95 * y, 0.95 * r * math.sin(t), key = 0, k = k }
    for level = 1, 5 do
      for a = 3, 1, -1 do p.key = 2 * p.key + math.floor((p[a] + 1) * 2 ^ (level - 1)) % 2 end
    end
    list[k] = p
  end
  table.sort(list, function(a, b)
    if a.key ~= b.key then return a.key < b.key end
    return a.k < b.k
  end)
  local out = ylm.zeros({ n, 3 }, "float")
  for i, p in ipairs(list) do for a = 1, 3 do out:set(i, a, p[a]) end end
  return out
end

print "| grid | points | interpolated | bricks | bake s | processor s | ratio | points ratio |"
print "| --- | --: | --: | --: | --: | --: | --: | --: |"
local seconds, processor, whole = timed(function() return ylm.bake(grid_of(), lights, { geometry = ball, threads = 1 }) end)
print(("| in memory | %d | %d | - | %.2f | %.2f | - | - |"):format(whole.stats.points, whole.stats.interpolated, seconds,
  processor))
local set
for _, bricks in ipairs { { 3 }, { 2 }, { 1, 2 ^ 17 } } do
  local level, most = bricks[1], bricks[2]
  if set then set:close() end
  local took, busy
  took, busy, set = timed(function()
    return ylm.bake(grid_of(level), lights, { geometry = ball, threads = 1, folder = folder, fresh = true, brick_points = most,
      cache = "1 MB" })
  end)
  print(("| bricks of level %d | %d | %d | %d | %.2f | %.2f | %.2f | %.3f |"):format(level, set.stats.points,
    set.stats.interpolated, set.stats.bricks, took, busy, busy / processor, set.stats.points / whole.stats.points))
end

local points = places(whole.stats.points)
local slice = 50000
local out = ylm.zeros({ slice, 3, 25 }, "float")
local function sample(grid)
  local n = #points
  return timed(function()
    for first = 1, n, slice do
      local p = points[{ first, math.min(first + slice - 1, n) }]
      assert(grid:sample(p, { out = #p == slice and out or nil, threads = 1 }))
    end
    return true
  end)
end
print "\n| samples of | points | s | processor s | M points a second | speed |"
print "| --- | --: | --: | --: | --: | --: |"
local best, least = { 1 / 0, 1 / 0 }, { 1 / 0, 1 / 0 }
local reads = set.stats.reads
for _ = 1, 5 do -- in turn
  for i, grid in ipairs { whole, set } do
    local clock, busy = sample(grid)
    best[i], least[i] = math.min(best[i], clock), math.min(least[i], busy)
  end
end
for i, name in ipairs { "the grid in memory", "its bricks, read each time" } do
  print(("| %s | %d | %.3f | %.3f | %.2f | %.2f |"):format(name, #points, best[i], least[i], 1e-6 * #points / least[i],
    least[1] / least[i]))
end
print(("\n%d files read in each pass over %d bricks, %.2f GB"):format((set.stats.reads - reads) / 5, set.stats.bricks,
  set.stats.file_bytes / 1e9))
set:close()
os.execute("rm -r '" .. folder .. "'")
