--- Tolerances that a grid does not meet: the sentence that says so, with its cause and what to change.

local core = require "ylm.c.core"
local warning = require "ylm.warning"

local unmet = {}

local FALL = 4     -- powers of 2 by which errors of fourth order fall from level to level,
local FALL_WALLS = 1 -- and those beside walls, in grids with sides: with the edges of voxels, about
local WALLS_MORE = 2 -- levels beyond which that is no promise: edges of shadows stay

--- x rounded up to two digits, so that it is met.
function unmet.rounded_up(x)
  local unit = 10 ^ (math.floor(math.log(x) / math.log(10)) - 1)
  return ("%.2g"):format(math.ceil(x / unit - 1e-9) * unit)
end

--- "tolerance = 0.02", which is met; nil where the error has no bound: there is light in the grid where all is dark.
local function looser(error) return error < math.huge and "tolerance = " .. unmet.rounded_up(error) or nil end

--- "depth = 7", at which errors would be within the tolerance; nil where no grid is that deep, or walls
-- would take many levels.
local function deeper(depth, error, tolerance, sides)
  local fall = sides and FALL_WALLS or FALL
  local more = error < math.huge and math.ceil(math.log(error / tolerance) / math.log(2) / fall) or 1
  local wanted = depth + math.max(1, more)
  if sides and more > WALLS_MORE then return nil end
  return wanted <= core.limits.grid_depth and ("depth = %d (errors fall about %s a level)"):format(wanted,
    sides and "by half" or "16 times") or nil
end

--- "; set depth = 7 or tolerance = 0.02", of those that are known.
local function set(...)
  local words = {}
  for i = 1, select("#", ...) do words[#words + 1] = (select(i, ...)) end -- nil: not known
  return words[1] and "; set " .. table.concat(words, " or ") or ""
end

--- That walls are the cause, of a grid with sides; else nothing.
local function beside_walls(s) return s.crossed_leaves and ", and beside walls light bends within voxels" or "" end

--- Another way to hold the light of a scene with walls.
local function instead(s) return s.crossed_leaves and "; light on surfaces (scene:surface_grid) takes fewer numbers" or "" end

--- Why an error is above the tolerance, and what to change, where voxels end at the grid's depth.
local function too_shallow(depth, s)
  return ("voxels end at depth %d"):format(depth) .. beside_walls(s)
    .. set(deeper(depth, s.error, s.tolerance, s.crossed_leaves), looser(s.error)) .. instead(s)
end

--- That paths leave places undecided, where the others keep a tolerance; nil where they do not.
function unmet.undecided(s, paths)
  if s.failed - paths.undecided > 0.005 * s.verified then return nil end
  return ("%d of %d places are undecided by the paths"):format(paths.undecided, s.verified)
end

--- Why paths say that a tolerance is not met which the grid keeps against its own light field.
local function against_paths(s, paths)
  local undecided = unmet.undecided(s, paths)
  if undecided then return undecided .. set(looser(s.error)) end
  return "the light field itself is that far from the paths; make links of a smaller spacing" .. set(looser(s.error))
end

--- Why a bake's tolerance is not met, and what to change. The sum of lights is no smoother than its own tolerance.
local function cause_of(s, form, lights, paths)
  if s.verified == 0 then return "all its surfaces face out of its bounds, where no light is known; set larger bounds" end
  if lights and lights > s.tolerance then
    return ("lights are summed to sums_tolerance = %.3g, voxels end at depth %d"):format(lights, form.depth)
      .. set(("sums_tolerance = %.2g, then depth,"):format(s.tolerance), looser(s.error))
  end
  if paths and paths.field_met then return against_paths(s, paths) end
  if s.spent then
    return "its points are spent; leave points out" .. (looser(s.error) and ", or set " .. looser(s.error) or "")
  end
  if s.limited then return too_shallow(form.depth, s) end
  return ("%d rounds of refinement end above it"):format(s.rounds) .. beside_walls(s) .. set(looser(s.error)) .. instead(s)
end

--- "bake: tolerance 0.01 is not met, 99 % of the points keep 0.02: ".
local function begin(what, tolerance, error)
  return ("%s: tolerance %.3g is not met, 99 %% of the points keep %s: "):format(what, tolerance,
    error < math.huge and ("%.3g"):format(error) or "no bound")
end

--- Why the tolerance is not met after an update, and what to change.
local function cause_after_update(s, form)
  if s.limited then return too_shallow(form.depth, s) end
  return "its refinement ends above it" .. set(looser(s.error)) .. ", or bake anew"
end

--- The sentence of a bake, or of the last update; nil where its tolerance is met, or there is none.
local function sentence_of(s, form, lights, paths)
  if s.met ~= false then return nil end
  if s.error ~= s.error then
    return ("grid: it was updated with octree = 'keep', and nobody has looked whether tolerance %.3g is kept: octree = 'follow' "
      .. "keeps it"):format(s.tolerance)
  end
  return begin(s.update and "update" or "bake", s.tolerance, s.error)
    .. (s.update and cause_after_update(s, form) or cause_of(s, form, lights, paths))
end

--- The stats of a grid with what it does not keep: stats.warning, stats.update.warning.
function unmet.stats(g)
  local stats, form = core.grid_stats(g), core.grid_form(g)
  local paths = core.owned(g, "paths")
  stats.warning = sentence_of(stats, form, core.owned(g, "sums_tolerance"), paths)
  if paths then stats.paths = paths end
  if stats.update then stats.update.warning = stats.warning end
  return stats
end

--- Says of a grid what it does not keep, of its bake and of its updates once each; returns a list of these sentences.
function unmet.warn(g)
  if core.type(g) ~= "ylm.grid" then return {} end
  local stats = unmet.stats(g)
  if not stats.warning then return {} end
  return { (warning.say(g, stats.update and "update" or "bake", "%s", stats.warning)) }
end

return unmet
