--- grid:refresh: the points of a grid in another light.

local bake = require "ylm.grid.bake"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"
local light = require "ylm.light"
local progress = require "ylm.progress"

local methods, open = grid_object.methods, grid_object.open

local refresh_options = {
  { "quantity", "choice", of = core.choices "quantity", optional = true,
    about = "what a field that is a function holds; other fields know it" },
  form.threads, form.progress,
}

describe "grid:refresh" {
  about = "Evaluates a light field anew at all points of the grid: lights that changed, or another field. The octree stays what "
    .. "it was. Points in lights or bodies are filled from their neighbours, and the points that only continuity needs "
    .. "follow. Nothing measures the errors anew: where the light is not what it was, stats.met is false and stats.error is "
    .. "not a number. Lights that are summed exactly, and that the grid was baked from, give the same grid to the bit.",
  arguments = {
    { "lights", "light|list|function", "what ylm.bake takes: any light field" },
    { "options?", "table", "see the options" },
  },
  options = refresh_options,
  returns = { { "report", "table", "points: evaluated; seconds" } },
  errors = "raises on bad arguments, and on a grid with dynamic = true, which has grid:update; nil, message, code where "
    .. "memory runs out or the field fails; nil, 'cancelled', 'ECANCELLED' where progress returns false: the grid is "
    .. "then as it was",
  example = [[
local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 10 } end
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4 }, lamp(0))
local before = grid:sample { 0, 0, 0 }
local report = grid:refresh(lamp(1))
assert(report.points == 125 and grid:sample({ 0, 0, 0 })[1][1] < before[1][1])]],
}
function methods.refresh(g, lights, given)
  open(g, "refresh")
  local o = form.options(2, "refresh", refresh_options, given)
  if core.grid_form(g).dynamic then
    return check.fail("refresh: a grid with dynamic = true follows its lights by grid:update")
  end
  local packed, failed, code = lights
  if type(lights) ~= "function" then
    packed, failed, code = light.field(1, "refresh", lights)
    if not packed then return nil, failed, code end
  end
  if packed == g then return check.bad(1, "refresh", "a grid cannot be refreshed from itself") end
  local quantity = bake.quantity(2, "refresh", packed, o.quantity)
  local points, seconds
  points, seconds, code = check.result("refresh", core.grid_refresh(g, packed, quantity, o.threads or 0,
    progress.of(o.progress)))
  if not points then return nil, seconds, code end
  devices.forgetting(g)()
  bake.refreshed(g, packed)
  return { points = points, seconds = seconds }
end
