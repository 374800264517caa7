-- How long a bake in bricks takes on many processes: a model, its pieces measured here, and what it says of clusters.
--
--     ylm run examples/cluster/model.lua [--quick] [--out DIR]   the pieces, and predictions
--     mpirun -n 2 ylm run examples/cluster/model.lua [..]  and a bake by 2 processes beside what the model says of it
--
-- Model: seconds(P) = max(compute, write), for P processes of one thread,
--     compute = (N (1 + r) (f + o) + s N / B) / P + t L + ((f + o) B + s) / 2     write = b N / w
-- N points, L lights, B points of a brick. Measured: f seconds of the light field a point, o all else a point, s of a brick's
-- files (mostly fsync, of the disk here), t of building the tree a light, b bytes a point. Assumed: r, points that several
-- bricks evaluate, 3 % at 65536 a brick; w, the file system's bytes a second; that processes do not slow one another down; that
-- half a brick's time passes while the last ones end.

local ylm = require "ylm"
local core = require "ylm.c.core"

local quick, out = false, "out"
for i, word in ipairs(arg or {}) do
  if word == "--quick" then quick = true end
  if word == "--out" then out = arg[i + 1] end
end
local team = ylm.team()

local seed = 1
local function random()
  seed = seed * 16807 % 2147483647
  return seed / 2147483647
end

local function lamps(n)
  seed = n -- the same lamps in every process
  local at = ylm.zeros({ n, 3 }, "double")
  for i = 1, n do for k = 1, 3 do at:set(i, k, k == 2 and 0.6 + random() or 2 * random() - 1) end end
  return ylm.sphere_lights { at = at, radius = 0.002, radiance = 100 / n }
end

local function timed(f)
  local begun = core.seconds()
  local result = f()
  return core.seconds() - begun, result
end

local function say(...) if team.rank == 1 then print((...):format(select(2, ...))) end end

-- The pieces, by the first process; the others wait, and hear them ---------------------------

local box = { { -1, -1, -1 }, { 1, 1, 1 } }

--- Seconds a point of the light of n lamps, and of building their tree a lamp.
local function field(n, tolerance)
  local lights, points = lamps(n), ylm.zeros({ quick and 64 or 4096, 3 }, "float")
  for i = 1, #points do for k = 1, 3 do points:set(i, k, 2 * random() - 1) end end
  local function ask(p) return assert(ylm.light_field(4, lights, p, { derivatives = 1, tolerance = tolerance, threads = 1 })) end
  local first = timed(function() return ask(points[{ 1, 64 }]) end) -- builds the tree
  local seconds = timed(function() return ask(points) end)
  return seconds / #points, math.max(0, first - 64 * seconds / #points) / n
end

--- A grid in bricks of some lamps, baked anew; nil for `to`: whole.
local function bake(to, n, shared)
  return assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = quick and 5 or 6, threshold = quick and 0.4 or 0.1,
    bricks = to and 2 or nil }, lamps(n), { folder = to, fresh = to ~= nil, threads = 1, team = shared }))
end

local FEW = 20
local pieces = {}
if team.rank == 1 then
  local many = quick and 2000 or 100000
  pieces.exact = field(many) / many
  pieces.near, pieces.tree = field(many, 0.01)
  pieces.many = many
  local whole = bake(nil, FEW)
  local seconds, grid = timed(function() return bake(out .. "/model-1.ylmd", FEW) end)
  pieces.points, pieces.bytes, pieces.bricks = grid.stats.points, grid.stats.file_bytes / grid.stats.points, grid.stats.bricks
  pieces.again, pieces.one = grid.stats.points / whole.stats.points - 1, seconds
  pieces.point = whole.stats.seconds / whole.stats.points
  pieces.other = (whole.stats.seconds - whole.stats.field_seconds) / whole.stats.points
  pieces.files = math.max(0, seconds - pieces.point * pieces.points) / pieces.bricks
  whole:close()
end

say("measured here, one thread, lmax 4, RGB:")
if team.rank == 1 then
  say("  a light and a point, exactly       %8.2f ns", 1e9 * pieces.exact)
  say("  a point of %6d lights to 1 %%    %8.2f us", pieces.many, 1e6 * pieces.near)
  say("  a light in the making of the tree  %8.2f us", 1e6 * pieces.tree)
  say("  all else, a point                  %8.2f us", 1e6 * pieces.other)
  say("  files of a brick                   %8.2f ms   (a bake in %d bricks, %d points, %.2f s)", 1e3 * pieces.files,
    pieces.bricks, pieces.points, pieces.one)
  say("  points that bricks evaluate again  %8.2f %%    (bricks of %.0f points; 2 to 3 %% where they have 65536)",
    100 * pieces.again, pieces.points / pieces.bricks)
  say("  bytes of files, a point            %8.0f", pieces.bytes)
end

-- A bake by all processes, beside the model -------------------------------------------------

--- Seconds of p processes, and their efficiency; `n` points, f seconds of light a point, `start` seconds before the first.
local function model(n, f, start, p, again, brick)
  local point = f + pieces.other
  local compute = (n * (1 + again) * point + pieces.files * n / brick) / p + start + (point * brick + pieces.files) / 2
  local write = pieces.bytes * n / 20e9
  return math.max(compute, write), n * point / p / compute, write > compute
end

if team.size > 1 then
  local calls = 100
  local cases = {}
  for i = 1, calls do cases[i] = i end
  local hand = timed(function() return assert(team:each(cases, function(i) return i end)) end) / calls
  local seconds = timed(function() return bake(out .. "/model-all.ylmd", FEW, team) end)
  if team.rank == 1 then
    local foreseen = pieces.one / team.size + pieces.one / pieces.bricks / 2
    say("measured by %d processes: %.2f s; the model says %.2f s (efficiency %.2f)", team.size, seconds, foreseen,
      pieces.one / seconds / team.size)
    say("  a case handed out by process 1, with its result: %.2f ms", 1e3 * hand)
  end
end

-- Clusters --------------------------------------------------------------------------------------

if team.rank == 1 then
  say("model, on such processors, 20 GB/s of files, bricks of 65536 points with 3 %% twice:")
  local tasks = {
    { "10^9 points, 10^6 lights to 1 %", 1e9, pieces.near, 1e6 * pieces.tree, 65536 },
    { "10^8 points, 10^6 lights to 1 %", 1e8, pieces.near, 1e6 * pieces.tree, 65536 },
    { "10^7 points, 10^6 lights exactly, bricks of 6400", 1e7, 1e6 * pieces.exact, 0, 6400 },
  }
  for _, task in ipairs(tasks) do
    say("  %s", task[1])
    for _, p in ipairs { 16, 256, 1024 } do
      local seconds, efficiency, writes = model(task[2], task[3], task[4], p, 0.03, task[5])
      say("    %5d processes  %9.0f s  efficiency %3.0f %%%s", p, seconds, 100 * efficiency, writes and "  (files bound)" or "")
    end
  end
end
