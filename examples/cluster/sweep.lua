-- A sweep that many processes share: points and errors of a grid, by its tolerance and by the number of lamps.
--
--     mpirun -n 8 ylm run examples/cluster/sweep.lua          (or without mpirun: the same table)
--     ylm run examples/cluster/sweep.lua sweep.journal        (results are kept there; a second run goes on)

local ylm = require "ylm"

local team = ylm.team()

local cases = {}
for _, lamps in ipairs { 1, 4, 16 } do
  for _, tolerance in ipairs { 0.1, 0.05 } do cases[#cases + 1] = { lamps = lamps, tolerance = tolerance } end
end

--- The grid of some lamps over a floor.
local function run(case)
  local at, floor = {}, {}
  for i = 1, case.lamps do at[i] = { math.cos(i * 2.4) * 0.9, 0.3, math.sin(i * 2.4) * 0.9 } end
  for i = 0, 16 do for j = 0, 16 do floor[#floor + 1] = { i / 8 - 1, 0, j / 8 - 1 } end end
  local grid, message = ylm.bake(
    ylm.adaptive_grid { bounds = { { -1, -0.5, -1 }, { 1, 0.5, 1 } }, lmax = 3, depth = 5, tolerance = case.tolerance },
    ylm.sphere_lights { at = at, radius = 0.05, radiance = 10 }, { occupied = floor, threads = 1 })
  if not grid then return nil, message end
  return { points = grid.stats.points, error = grid.stats.error }
end

local results = assert(team:each(cases, run, { journal = arg and arg[1] }))
if team.rank == 1 then
  for i, r in ipairs(results) do
    print(("%3d lamps to %.2f: %5d points, error %.3f"):format(cases[i].lamps, cases[i].tolerance, r.points, r.error))
  end
end
