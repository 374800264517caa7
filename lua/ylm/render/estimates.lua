--- Estimates by paths, of pictures and probes: options, orders of reflections, reports.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local options = require "ylm.render.options"

local estimates = {}

local MOST_ORDER = 2 ^ 30
estimates.MOST_SAMPLES = core.limits.path_samples

local function is_order(x) return check.is_integer(x) and x >= 0 and x <= MOST_ORDER end

function form.types.bounces(x)
  if x == "all" or is_order(x) then return x end
  return nil, "a number of reflections after direct light, 0, 1, 2 .., or 'all'"
end

--- { first, last }, last "all" for no end; comes out with -1 for that.
function form.types.reflections(x)
  if type(x) == "table" and #x == 2 and is_order(x[1]) then
    if x[2] == "all" or x[2] == math.huge then return { x[1], -1 } end
    if is_order(x[2]) and x[2] >= x[1] then return { x[1], x[2] } end
  end
  return nil, "{ first, last }, first <= last, from 0 on, last also 'all'"
end

--- Parts of a budget that pictures and probes have.
estimates.options = {
  options.bounce_fields[1],
  { "strategy", "choice", of = core.choices "path_strategy", default = "both", shelf = "experiments",
    about = "by paths: rays that find light: to lamps and by material, weighed by the balance heuristic; or one kind alone, to "
      .. "compare" },
  { "tolerance", "number", above = 0, optional = true, about = "ends once the noise, report.noise, is at most this" },
  { "time_limit", "number", above = 0, optional = true, unit = "s", shelf = "experiments",
    about = "by paths: ends after so long, which makes results depend on it" },
}

--- The orders that options ask for, first and last or -1; `direct`: of direct light.
function estimates.orders(name, o, direct)
  if o.bounces and o.reflections then
    return check.bad(1, name, "bounces and reflections say the same: leave one out")
  end
  if o.reflections then return o.reflections[1], o.reflections[2] end
  if o.bounces == nil or o.bounces == "all" then return 0, -1 end
  return 0, o.bounces + direct
end

--- Options by the words of C for what ended an estimate.
local ended = { error = "tolerance", seconds = "time_limit" }

--- Completes a report by what C says of paths.
function estimates.add_stats(report, stats)
  report.samples, report.noise, report.ended = stats.samples, stats.noise, ended[stats.ended] or stats.ended
  report.absorbed, report.lost, report.paths = stats.absorbed, stats.lost, stats.paths
  report.rays = { primary = report.rays and report.rays.primary, nearest = stats.nearest, lamps = stats.lamps,
    shadow = stats.shadow, guides = stats.clusters > 0 and stats.guides or nil }
  report.guides = stats.clusters > 0 and stats.clusters or nil
end

--- Where nothing can shine, the sentence that says so.
function estimates.darkness(s)
  if #s.lights == 0 then return ("scene %q has no lights: no light arrives anywhere"):format(s.name or "?") end
end

return estimates
