-- Work that processes share, beside one process of two threads: a bake in bricks, a bake whose light is divided, a sweep, and the
-- start itself. mpirun starts the processes, each with one thread.
--
--     make bench BENCH=team
--
-- Rows of a table run in turn, three times; the least time of each is kept. "speed" is relative to the first row.

local core = require "ylm.c.core"
local mpi = require "spec.support.mpi"
local random = require "spec.support.random".minimal(1)
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local folder = (os.getenv "TMPDIR" or "/tmp") .. "/ylm_bench_team.ylmd" -- of all processes
local box = { { -1, -1, -1 }, { 1, 1, 1 } }

local function lamps(n)
  local at = ylm.zeros({ n, 3 }, "double")
  for i = 1, n do for k = 1, 3 do at:set(i, k, k == 2 and 1.2 + random() or 2 * random() - 1) end end
  return ylm.sphere_lights { at = at, radius = 0.002, radiance = 1 }
end

--- Work of a case: the same number of additions everywhere.
local function add(n)
  local sum = 0
  for i = 1, n do sum = sum + i % 7 end
  return sum
end

-- Rows: a function that a process calls, which returns seconds and what the row tells besides.
local rows = {}

function rows.nothing() return 0, "" end

function rows.bricks(team, begin)
  local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = box, depth = quick and 4 or 6, lmax = 4, threshold = 1e-5,
    bricks = 2 }, lamps(quick and 100 or 4000), { folder = folder, fresh = true, team = team }))
  return core.seconds() - begin, ("%d points, %d bricks"):format(grid.stats.points, grid.stats.bricks)
end

function rows.divided(team, begin)
  local cells = quick and 8 or 20
  local grid = assert(ylm.bake(ylm.uniform_grid { bounds = box, lmax = 4, cells = { cells, cells, cells } },
    lamps(quick and 1000 or 100000), { team = team }))
  return core.seconds() - begin, ("%d points"):format(grid.stats.points)
end

function rows.sweep(team, begin)
  local n = tonumber(arg[2])
  local cases = {}
  for i = 1, 100 do cases[i] = i end
  assert(team:each(cases, function(i) return { i, add(n) } end))
  return core.seconds() - begin, "100 cases"
end

if arg and arg[1] then
  local team = ylm.team()
  local seconds, told = rows[arg[1]](team, core.seconds())
  if team.rank == 1 then io.write(("%.6f %s\n"):format(seconds, told)) end
  os.exit(0, true)
end

-- The table -----------------------------------------------------------------------------------

local refused = mpi.missing()
if refused then
  print(refused)
  return
end

--- Seconds by the clock of a command, those that it tells, and what else it does.
local function run(words, processes, threads)
  local tool = (os.getenv "BUILD" or "build") .. "/ylm"
  local command = ("%s run spec/bench/team.lua %s"):format(tool, words)
  if processes > 1 then
    command = ("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_vader_single_copy_mechanism=none "
      .. "OMPI_MCA_rmaps_base_oversubscribe=1 mpirun -q --bind-to none -x YLM_THREADS=%d -n %d %s"):format(threads, processes,
      command)
  else
    command = ("YLM_THREADS=%d %s"):format(threads, command)
  end
  local begin = core.seconds()
  local pipe = assert(io.popen(command))
  local text = pipe:read "*a"
  pipe:close()
  local whole = core.seconds() - begin
  local seconds, told = text:match "^([%d.]+) ([^\n]*)"
  assert(seconds, text)
  return whole, tonumber(seconds), told
end

local shapes = { { 1, 2 }, { 2, 1 }, { 4, 1 } }

local function compare(title, words, only)
  local least, whole, told = {}, {}, nil
  for _ = 1, quick and 1 or 3 do
    for i, shape in ipairs(only or shapes) do
      local all, seconds, text = run(words, shape[1], shape[2])
      least[i], whole[i], told = math.min(least[i] or seconds, seconds), math.min(whole[i] or all, all), text
    end
  end
  for i, shape in ipairs(only or shapes) do
    print(("| %s | %d | %d | %.2f | %.2f | %.2f |"):format(title .. ": " .. told, shape[1], shape[2], whole[i], least[i],
      least[1] / least[i]))
  end
  return whole, least
end

local header = "| work | processes | threads of each | s with the start | s | speed |\n| --- | --: | --: | --: | --: | --: |"
print(header)
compare("a bake in bricks", "bricks")
compare("a divided bake, 100,000 lights exactly", "divided")
os.execute("rm -rf '" .. folder .. "'")

-- A case of a sweep takes as long as this process needs for it, alone.
local n, alone = 1e6, 0
for _ = 1, 2 do -- the first time it is compiled
  local begin = core.seconds()
  add(n)
  alone = core.seconds() - begin
end
n = math.floor(n * (quick and 0.01 or 0.2) / alone)
local _, sweep = compare("a sweep", ("sweep %.0f"):format(n), { { 1, 1 }, { 2, 1 }, { 4, 1 } })
print(("\nA sweep by 4 processes takes %.3f of half the time of one."):format(sweep[3] / (sweep[1] / 2)))

local starts = {}
for _ = 1, quick and 1 or 5 do
  for i, shape in ipairs { { 1, 1 }, { 2, 1 }, { 4, 1 } } do
    local whole = run("nothing", shape[1], shape[2])
    starts[i] = math.min(starts[i] or whole, whole)
  end
end
print(("Start and end of a program that does nothing: %.2f s alone, %.2f s more by mpirun -n 2, %.2f s more by mpirun -n 4."
  ):format(starts[1], starts[2] - starts[1], starts[3] - starts[1]))
