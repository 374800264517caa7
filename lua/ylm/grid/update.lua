--- grid:update: a grid in other light.

local bake = require "ylm.grid.bake"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local field = require "ylm.field"
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"
local progress = require "ylm.progress"
local unmet = require "ylm.grid.unmet"

local methods, open = grid_object.methods, grid_object.open

local update_options = {
  { "octree", "choice", of = { "follow", "keep" }, optional = true,
    about = "'follow' splits and merges voxels to suit the new light (default with dynamic = true); 'keep' evaluates the points "
      .. "that there are (default of other grids)" },
  { "tolerance", "number", min = 0, optional = true,
    about = "with dynamic = true: points whose light changed by less than this, relative to the field, are not updated; 0 "
      .. "updates every point. Default: an eighth of the grid's tolerance, 0.001 where it has none" },
  { "occupied", "any", optional = true,
    about = "of octree = 'follow' without dynamic = true: where light is needed from now on, as of ylm.bake; default: where it "
      .. "was" },
  { "quantity", "choice", of = core.choices "quantity", optional = true,
    about = "what a field that is a function holds; other fields know it" },
  form.threads, form.progress,
}

--- Raises where an option has no use.
local function refuse(o, name, why)
  if o[name] ~= nil then return check.bad(2, "update", "%s %s: leave it out", name, why) end
end

--- A dynamic grid after its lights have changed: the report, or nil, message, code.
local function follow_lights(g, lights, o)
  refuse(o, "quantity", "is of grids without dynamic = true, which other fields may fill")
  refuse(o, "occupied", "is of grids without dynamic = true, which know no places where light is needed")
  if o.octree == "keep" then
    return check.bad(2, "update", "octree: a grid with dynamic = true follows its lights: 'follow', or leave it out")
  end
  local f, message, code = field.of(1, "update", lights)
  if not f then return nil, message, code end
  if not f:followed() then
    return check.bad(1, "update", "a dynamic grid follows sphere lights and flat lights, got %s: bake that into a second "
      .. "grid", f.is_function and "a function" or f:other())
  end
  local report
  report, message, code = check.result("update", core.grid_update(g, f.object, o.tolerance or -1, o.threads or 0,
    progress.of(o.progress)))
  if report == nil then return nil, message, code end
  bake.followed(g, f)
  unmet.warn(g)
  report.warning = g.stats.update.warning
  return report
end

--- The points of a grid in another light, its voxels as they are: the report, or nil, message, code.
local function evaluate_points(g, lights, o)
  refuse(o, "occupied", "is of octree = 'follow': the points stay")
  local f, message, code = field.of(1, "update", lights)
  if not f then return nil, message, code end
  if f.object == g then return check.bad(1, "update", "a grid cannot be updated from itself") end
  local quantity = f:quantity(2, "update", o.quantity)
  local points, seconds
  points, seconds, code = check.result("update", core.grid_refresh(g, f.object, quantity, o.threads or 0,
    progress.of(o.progress)))
  if not points then return nil, seconds, code end
  devices.forgetting(g)()
  bake.refreshed(g, f)
  return { points = points, seconds = seconds }
end

--- The options of the bake that g is to become.
local function options_of(g, recipe, o)
  local options = { bounds = g.bounds, quantity = o.quantity, threads = o.threads, progress = o.progress }
  for name, value in pairs(recipe.options) do options[name] = options[name] or value end
  if o.occupied ~= nil then options.occupied, options.geometry = o.occupied, nil end
  return options
end

--- A grid that is baked again, from what it has learnt of errors: the report, or nil, message, code.
local function bake_again(g, lights, o)
  local recipe = bake.recipe(g)
  if not recipe then
    return check.fail("update: octree = 'follow' needs to know where light is needed, which files do not hold: bake the grid in "
      .. "this program, or keep the octree")
  end
  local known = recipe.description.tolerance and recipe.options.device == nil and g or nil
  local made, message, code = bake.of_scene(recipe.description, lights, options_of(g, recipe, o), nil, known)
  if not made then return nil, message, code end
  devices.forgetting(g)()
  local taken
  taken, message, code = bake.take(g, made)
  if not taken then return nil, message, code end
  local s = g.stats
  return { points = s.points, pairs = s.pairs, seconds = s.seconds, field_seconds = s.field_seconds, met = s.met, error = s.error,
    confidence = s.confidence, verified = s.verified, limited = s.limited, warning = s.warning }
end

describe "grid:update" {
  shelf = "everyday",
  about = "Brings other light to a grid: lights that moved, changed, appeared or vanished, or another field. A grid made with "
    .. "dynamic = true bakes only what they change beyond the tolerance, and its octree follows. Of other grids octree = 'keep' "
    .. "evaluates all points anew: points in lights or bodies are filled from their neighbours, and nothing measures the errors "
    .. "anew, so where the light is not what it was stats.met is false and stats.error is not a number. octree = 'follow' bakes "
    .. "them again. With a tolerance the bake goes on: its knowledge of errors is taken over, 256 fresh points verify instead of "
    .. "2048 and more, and stats are about those of the last 2048 points that bakes in a row compared.",
  arguments = {
    { "lights", "light|list|function", "all lights as they are now. With dynamic = true those of any kind that it follows; {}: "
      .. "darkness; those that did not change are recognised by their place in the list, else by their content. Of other grids "
      .. "any light field" },
    { "options?", "table", "see the options" },
  },
  options = update_options,
  returns = { { "report", "table", "points: evaluated; seconds. With dynamic = true also grid.stats.update: lights that changed, "
    .. "points brought up to date, exact: of "
    .. "these with all lights, skipped: within the tolerance, added, removed, pairs, seconds, field_seconds, "
    .. "tree_seconds, rebaked, updates; with a tolerance met, error, confidence, verified, limited and warning: of the "
    .. "whole grid as it is, see grid.stats" } },
  errors = "raises on bad arguments, on octree = 'follow' of a grid that was loaded, and from the progress function of a call "
    .. "that reads the grid; nil, message, code where memory or max_points are "
    .. "exceeded or the field fails; nil, 'cancelled', 'ECANCELLED' where progress returns false: the grid is then as it was, "
    .. "or a dynamic one says that it is spent and refuses all but close: where memory ran out twice in the last step",
  example = [[
local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 10 } end
local bounds = { { -1, -1, -1 }, { 1, 1, 1 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 4, dynamic = true }, { lamp(0), lamp(1) })
local report = grid:update { lamp(0), lamp(1.2) }
assert(report.lights == 1 and report.points > 0)
local other = ylm.bake(ylm.adaptive_grid { bounds = bounds, depth = 3, tolerance = 0.05 }, lamp(0))
assert(other:update(lamp(0.2), { octree = "follow" }).points > 0)
assert(other:update(lamp(1)).points == other.stats.points)]],
}
function methods.update(g, lights, given)
  open(g, "update")
  local o = form.options(2, "update", update_options, given)
  local f = core.grid_form(g)
  if f.dynamic then return follow_lights(g, lights, o) end
  refuse(o, "tolerance", "is of grids with dynamic = true")
  if o.octree == "follow" and f.kind == "adaptive" then return bake_again(g, lights, o) end
  return evaluate_points(g, lights, o)
end
