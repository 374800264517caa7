-- A bake larger than memory in bricks, samples of it, and its files as one: what each takes, and the most memory held.
--
--     ylm run spec/bench/bricks_large.lua FOLDER.ylmd bake|pack|sample [DEPTH [PLACES]]  -- depth 10: 10^7 points, 15 GB of files
--
-- 100 lights, lmax 4 in RGB, one thread, cache = "256 MB"; more than 700 MB resident are an error (spec/bricks runs it).

local core = require "ylm.c.core"
local ylm = require "ylm"

local MOST = 700 -- MB
local folder, what, depth, places = arg[1], arg[2], tonumber(arg[3] or 10), tonumber(arg[4] or 1e7)
local box = { { -1, -1, -1 }, { 1, 1, 1 } }

--- MB that this process has held at most; nil where the system does not tell.
local function resident()
  local file = io.open "/proc/self/status"
  if not file then return end
  local kb = file:read("*a"):match "VmHWM:%s+(%d+)"
  file:close()
  return kb and tonumber(kb) / 1024
end

local function bake()
  local at = {}
  for i = 1, 100 do
    local t = i * 2.399963
    at[i] = { 1.6 * math.cos(t), 1.6 * (2 * i / 101 - 1), 1.6 * math.sin(t) }
  end
  local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = depth, threshold = 0, bricks = 3 },
    ylm.sphere_lights { at = at, radius = 0.02, radiance = 3 },
    { geometry = ylm.sphere { radius = 0.95, divide = { 256, 128 } }, folder = folder, threads = 1 }))
  local s = grid.stats
  return ("%.0f points, %.0f interpolated, %d bricks, %.2f GB of files"):format(s.points, s.interpolated, s.bricks,
    s.file_bytes / 1e9)
end

--- Places along a spiral on the sphere: neighbours in the list are near each other only from turn to turn.
local function sample()
  local grid = assert(ylm.load(folder, { cache = "256 MB" }))
  local slice, sampling, outside = math.min(1e5, places), 0, 0
  local p, out = ylm.zeros({ slice, 3 }, "float"), ylm.zeros({ slice, 3, 25 }, "float")
  for first = 0, places - 1, slice do
    for i = 1, slice do
      local k = first + i
      local y, t = 2 * k / (places + 1) - 1, k * 2.399963
      local r = 0.95 * math.sqrt(math.max(0, 1 - y * y))
      p:set(i, 1, r * math.cos(t))
      p:set(i, 2, 0.95 * y)
      p:set(i, 3, r * math.sin(t))
    end
    local begun = core.seconds()
    local _, _, report = assert(grid:sample(p, { out = out, threads = 1 }))
    sampling, outside = sampling + core.seconds() - begun, outside + report.outside
  end
  assert(outside == 0)
  return ("%d places, %.1f s of them sampling, %d reads of %d bricks"):format(places, sampling, grid.stats.reads,
    grid.stats.bricks)
end

--- One file of all bricks, which is removed.
local function pack()
  local grid, path = assert(ylm.load(folder)), folder:gsub("d$", "")
  assert(grid:save(path))
  local file = assert(io.open(path, "rb"))
  local bytes = file:seek "end"
  file:close()
  os.remove(path)
  return ("one file of %.2f GB"):format(bytes / 1e9)
end

local begun = core.seconds()
local told = (what == "bake" and bake or what == "pack" and pack or sample)()
local held = resident()
print(("%s: %s, %.1f s, %s MB resident at most"):format(what, told, core.seconds() - begun,
  held and ("%.0f"):format(held) or "?"))
assert(not held or held <= MOST, "more than 700 MB resident")
