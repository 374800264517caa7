-- A bake in bricks by processes: 4,000 lights, 64 bricks. Alone, on all threads, then shared:
--
--     make bench BENCH=team
--     mpirun -n 2 build/ylm run spec/bench/team.lua

local core = require "ylm.c.core"
local random = require "spec.support.random".minimal(1)
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local team = ylm.team()
local at = {}
for i = 1, quick and 100 or 4000 do at[i] = { 2 * random() - 1, 1.2 + random(), 2 * random() - 1 } end
local lights = ylm.sphere_lights { at = at, radius = 0.002, radiance = 1 }
local folder = (os.getenv "TMPDIR" or "/tmp") .. "/ylm_bench_team.ylmd" -- of all processes

local begin = core.seconds()
local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, depth = quick and 4 or 6, lmax = 4,
  threshold = 1e-5, bricks = 2 }, lights, { to = folder, fresh = true, team = team }))
if team.rank == 1 then
  print "| processes | points | bricks | seconds |"
  print "| --: | --: | --: | --: |"
  print(("| %d | %d | %d | %.2f |"):format(team.size, grid.stats.points, grid.stats.bricks, core.seconds() - begin))
  grid:close()
  os.execute("rm -r '" .. folder .. "'")
end
