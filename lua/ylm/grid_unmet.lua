--- Tolerances that a grid does not meet: the sentence that says so, with its cause and what to change.

local core = require "ylm.c.core"
local warning = require "ylm.warning"

local unmet = {}

local DEEPEST = 16 -- of adaptive_grid
local FALL = 4     -- powers of 2 by which errors of fourth order fall from level to level

--- Grid -> the light_tolerance that it was baked with, in this program.
local light_tolerance = setmetatable({}, { __mode = "k" })

--- x rounded up to two digits, so that it is met.
local function rounded_up(x)
  local unit = 10 ^ (math.floor(math.log(x) / math.log(10)) - 1)
  return ("%.2g"):format(math.ceil(x / unit - 1e-9) * unit)
end

--- The depth at which errors of fourth order would be within the tolerance; nil where no grid is that deep.
local function depth_wanted(depth, error, tolerance)
  local more = math.ceil(math.log(error / tolerance) / math.log(2) / FALL)
  local wanted = depth + math.max(1, more)
  return wanted <= DEEPEST and wanted or nil
end

--- What to change where voxels end at the grid's depth.
local function deeper(depth, error, tolerance)
  local wanted = depth_wanted(depth, error, tolerance)
  return ("voxels end at depth %d; set %stolerance = %s"):format(depth,
    wanted and ("depth = %d (errors fall about 16 times a level) or "):format(wanted) or "", rounded_up(error))
end

--- Why a bake's tolerance is not met, and what to change. The sum of lights is no smoother than its own tolerance.
local function cause_of(s, form, lights)
  if lights and lights > s.tolerance then
    return ("lights are summed to light_tolerance = %.3g, voxels end at depth %d; set light_tolerance = %.2g, then depth, "
      .. "or tolerance = %s"):format(lights, form.depth, s.tolerance, rounded_up(s.error))
  end
  if s.limited then return deeper(form.depth, s.error, s.tolerance) end
  return ("%d rounds of refinement end above it; set tolerance = %s"):format(s.rounds, rounded_up(s.error))
end

--- The sentence of a bake; nil where its tolerance is met, or there is none.
local function of_bake(s, form, lights)
  if s.met ~= false then return nil end
  return ("bake: tolerance %.3g is not met, 99 %% of the points keep %.3g: %s"):format(s.tolerance, s.error,
    cause_of(s, form, lights))
end

--- The sentence of an update with this report.
local function of_update(u, s, form)
  if u.met ~= false then return nil end
  local cause = s.levels > form.depth and deeper(form.depth, u.error, s.tolerance)
    or ("bake anew or set tolerance = %s"):format(rounded_up(u.error))
  return ("update: tolerance %.3g is not met, 99 %% of the points in voxels that changed keep %.3g: %s"):format(s.tolerance,
    u.error, cause)
end

--- Remembers with which light_tolerance a grid was baked.
function unmet.remember(g, tolerance) light_tolerance[g] = tolerance end

--- The stats of a grid with what it does not keep: stats.warning, stats.update.warning.
function unmet.stats(g)
  local stats, form = core.grid_stats(g), core.grid_form(g)
  stats.warning = of_bake(stats, form, light_tolerance[g])
  if stats.update then stats.update.warning = of_update(stats.update, stats, form) end
  return stats
end

--- Says of a grid what it does not keep, of its bake and of its updates once each; returns a list of these sentences.
function unmet.warn(g)
  local out = {}
  if core.type(g) ~= "ylm.grid" then return out end
  local stats = unmet.stats(g)
  local function say(topic, sentence)
    if sentence then out[#out + 1] = warning.say(g, topic, "%s", sentence) end
  end
  say("bake", stats.warning)
  say("update", stats.update and stats.update.warning)
  return out
end

return unmet
