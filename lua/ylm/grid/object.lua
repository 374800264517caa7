--- The start of every method of a grid: the metatable, its fields, open and closed.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local unmet = require "ylm.grid.unmet"
local show = require "ylm.show"

local object = {}

local methods = core.metatable "ylm.grid"
object.methods = methods

--- Options of every way to sample a grid.
object.sampling = {
  interpolation = { "interpolation", "choice", of = core.choices "interpolation", default = "hermite",
    about = "cubic Hermite (fourth order), the corners' first-order expansions, or trilinear" },
  derivatives = { "derivatives", "integer", min = 0, max = 1, default = 0, about = "1: also the interpolant's gradient" },
  outside = { "outside", "choice", of = core.choices "outside", default = "clamp",
    about = "points outside of the bounds: those of the nearest point inside, or NaN" },
  dtype = { "dtype", "choice", of = core.choices "dtype", default = "float", about = "of the results" },
}

--- All that Lua keeps of a grid, the fields of core.own(grid); closing drops them. With a device it has `copy`, which lies there.
object.own = {
  path = "the file that it was loaded from, of a grid in bricks the folder",
  lights = "the lights that it was baked from, where these were lights",
  sums_tolerance = "with which it was baked",
  stages = "times by stage of the device that it was baked on",
  recipe = "description and options of its bake, by which its octree follows other light",
  shadow = "what light behind bodies took, where it was baked from such light",
  paths = "what paths say of its promise: { undecided, least, rms, paths, seconds, field_met, field_error }",
  said = "topics of warnings about it",
  partners = "devices that have a copy",
  few = "the bytes of its file, where it was baked for a number of bytes",
}

require "ylm.describe".object "grid" {
  about = "A baked grid of probes. The fields of its description can be read from it. The cells of a uniform grid are "
    .. "grid.resolution, since grid:cells() are the voxels themselves.",
  fields = {
    { "kind", "string", "'adaptive' or 'uniform'" },
    { "resolution", "table", "{ nx, ny, nz }: voxels along each axis, of an adaptive grid those of its finest level" },
    { "bounds", "table", "{ lowest, highest }, scene units" },
    { "lmax", "integer", "of the coefficients" },
    { "channels", "integer", "1 luminance, 3 rgb" },
    { "metric_channels", "string", "what the error metric is of" },
    { "quantity", "string", "what it holds: 'lights' (light that nothing occludes), 'direct' (with shadows), 'indirect', 'all' "
      .. "or 'visibility'" },
    { "sides", "boolean", "whether voxels that walls cross hold the light of each side, as light with shadows has it" },
    { "floor", "number", "the least norm that errors are relative to, where the tolerance has one" },
    { "body", "table", "of visibilities: { at, radius, area } of the body, a sphere around it and the mean of its projections' "
      .. "areas" },
    { "prints", "table", "of scene:bake: fingerprints of what the light depends on, 'lights' and, where surfaces cast shadows "
      .. "or send light back, 'geometry' and 'materials'; nil where nobody told them, as after other light" },
    { "dynamic", "boolean", "whether grid:update follows lights" },
    { "small", "table", "of a grid that is from a file of few bytes: its report, as of grid:save; else nil" },
    { "depth", "integer", "finest level of an adaptive grid; its metric, continuous, and tolerance with its "
      .. "measure, or threshold likewise" },
    { "stats", "table", "points, cells, leaves, levels, pairs, invalid, bytes, ...; with a tolerance met: at least 99 % "
      .. "of the occupied points keep it, error: a bound of their 99 % quantile, both with this confidence (1: all points were "
      .. "compared; nil in a loaded grid), verified: the random points that judge, limited: not met because of the depth, "
      .. "failed: of these points, those above the tolerance; with sides crossed_leaves, their parts, ghosts (of the points, "
      .. "those that stand for corners which no part sees), joined; measure: what error is of; "
      .. "warning: a sentence, where it is not met; "
      .. "seconds, of which field_seconds in the light field, occupancy_, lattice_, residual_ and continuity_seconds in "
      .. "parts of the bake, verify_seconds (field included) to verify (a loaded grid has none: files hold no times); baked "
      .. "on a device stages: by name { seconds, longest, dispatches }; baked from shadowed light shadow: what its stats count, "
      .. "of this bake" },
  },
}

--- The grid, where it is one that can be used; raises in the name of the method otherwise.
function object.open(g, name)
  local fault = check.grid_fault(g)
  if fault and not (name == "close" and select(3, core.grid_is_open(g))) then return check.fail("%s: %s", name, fault) end
  if core.grid_is_open(g) == nil then
    return check.fail("%s: a grid expected before the colon, got %s", name, check.describe(g))
  end
  return g
end

describe "grid:close" {
  about = "Frees the memory now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is not a grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp):close()]],
}
function methods.close(g)
  object.open(g, "close")
  local forget = devices.forgetting(g)
  check.result("close", core.grid_close(g))
  forget()
end

methods.__index = function(g, key)
  local method = rawget(methods, key)
  if method ~= nil or type(key) ~= "string" then return method end
  object.open(g, key)
  if key == "stats" then
    local stats = unmet.stats(g)
    stats.stages, stats.shadow = core.owned(g, "stages"), core.owned(g, "shadow")
    return show.report(stats)
  end
  if key == "small" then return core.grid_small(g) end
  return core.grid_form(g)[key]
end

methods.__newindex = function(_, key)
  return check.fail("grid: cannot set %s: only grid:update changes a grid", check.describe(key))
end

methods.__tostring = function(g)
  local is_open, updating, spent = core.grid_is_open(g)
  if not is_open then return "ylm.grid (closed)" end
  if spent then return "ylm.grid (spent)" end
  if updating then return "ylm.grid (being updated)" end
  local f, s = core.grid_form(g), core.grid_stats(g)
  return ("ylm.grid %s lmax %d %s, %d points, %d leaves"):format(f.kind, f.lmax, f.channels == 3
    and "rgb" or "luminance",
    s.points, s.leaves)
end

return object
