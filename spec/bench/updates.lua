-- Random updates of all kinds of change on dynamic grids that promise a tolerance, each with a fresh bake beside: how often
-- `met` is said of a grid in which more than 1 % of 4000 other occupied points fail, what fails, points and seconds.
--
--     build/ylm run spec/bench/updates.lua [seeds] [steps] [first seed]

local updates = require "spec.support.random_updates"
local ylm = require "ylm"

ylm.on_warning(function() end) -- the table counts what is not met

local seeds, steps, first = tonumber(arg[1] or 40), tonumber(arg[2] or 40), tonumber(arg[3] or 1)
local JUDGES = 4000

local function counts() return { met = 0, wrong = 0, unmet = 0, kept = 0, points = 0, seconds = 0, failing = {} } end
local updated, fresh, by_name = counts(), counts(), {}

--- Counts what was said of a grid, and whether it is so.
local function count(c, stats, seconds, failing)
  if stats.met then
    c.met = c.met + 1
    if failing > 0.01 then c.wrong = c.wrong + 1 end
    c.failing[#c.failing + 1] = failing
  else
    c.unmet = c.unmet + 1
    if failing <= 0.01 then c.kept = c.kept + 1 end
  end
  c.points, c.seconds = c.points + stats.points, c.seconds + seconds
end

for seed = first, first + seeds - 1 do
  updates.run(seed, steps, JUDGES, function(x)
    local c = by_name[x.name] or counts()
    by_name[x.name] = c
    count(updated, x.grid.stats, x.report.seconds, x.failing)
    count(c, x.grid.stats, x.report.seconds, x.failing)
    count(fresh, x.fresh.stats, x.fresh.stats.seconds,
      updates.failing(updates.errors(x.scene, x.fresh, x.judges), x.scene.tolerance))
  end)
end

local function quantile(list, q)
  table.sort(list)
  return 100 * (list[math.max(1, math.ceil(q * #list))] or 0)
end

print(("%d sequences of %d updates; a grid fails at more than 1 %% of %d points"):format(seeds, steps, JUDGES))
print "                 met  of these fail  not met  of these keep it   failing points of met grids, %      points  seconds"
print "                                                                     50 %    90 %    99 %    all"
local function line(name, c)
  local n = c.met + c.unmet
  print(("%-15s %4d %14d %8d %17d %12.2f %7.2f %7.2f %7.2f %11.0f %8.4f"):format(name, c.met, c.wrong, c.unmet, c.kept,
    quantile(c.failing, 0.5), quantile(c.failing, 0.9), quantile(c.failing, 0.99), quantile(c.failing, 1), c.points / n,
    c.seconds / n))
end
line("updates", updated)
line("fresh bakes", fresh)
local names = {}
for name in pairs(by_name) do names[#names + 1] = name end
table.sort(names)
for _, name in ipairs(names) do line("  " .. name, by_name[name]) end
