--- ylm.sphere_set: spheres in place of a body.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local progress = require "ylm.progress"
local warning = require "ylm.warning"

local sets = {}

--- The mesh of a mesh or a shape, else nil.
local function mesh_of(x)
  if core.type(x) == "ylm.mesh" then return x end
  local mesh = type(x) == "table" and form.kind(x) and rawget(x, "mesh")
  return core.type(mesh) == "ylm.mesh" and mesh or nil
end

-- Parts of a body's volume that its spheres may miss or add, and points of the lattice in it, before a sentence says so.
local MISSED, POINTS = 0.3, 2000

--- The sentence about spheres that do not stand for their body, in a list; nil where they do.
local function shortfall(mesh, k, report)
  local points, missed = report.volume / report.step ^ 3, (report.outside + report.uncovered) / report.volume
  if points < POINTS then
    return { warning.say(mesh, "lattice", "sphere_set: only %.0f points of the lattice are in the body, whose parts are small "
      .. "beside the space between them: make spheres of each part by itself", points) }
  elseif missed > MISSED then
    return { warning.say(mesh, "missed", "sphere_set: %d spheres miss or add %.0f %% of the body's volume: more of them (count) "
      .. "come nearer, but for thin plates, which spheres cannot fill", k, 100 * missed) }
  end
end

local options = {
  { "count", "integer", min = 1, max = core.limits.sphere_set, default = 64, about = "the most spheres" },
  form.progress,
}

describe "sphere_set" {
  about = "Spheres, whose union comes near to a body: the largest ones in it first, which then move and grow where less of the "
    .. "body is left out, or less is added to it. ylm.sphere_casters takes them.",
  arguments = { { "geometry", "mesh|quad|sphere|box|torus|knot", "a closed mesh, or a shape that has one" },
    { "options?", "table", "see the options" } },
  options = options,
  returns = { { "at", "array", "[k][3] centres, scene units; k is less than count where fewer cover the body" },
    { "radius", "array", "[k]" },
    { "report", "table", "{ volume, outside, uncovered, step }: of the body; of spheres outside of it; of the body outside of "
      .. "spheres, all by points of a lattice that are step apart; warnings: a sentence where these are many" } },
  errors = "raises on a mesh that is open, encloses no volume or is too thin for the lattice, and on bad options; nil, message, "
    .. "code: memory, cancelled",
  example = [[
local at, radius, report = ylm.sphere_set(ylm.torus { radius = 1, tube = 0.3 }, { count = 24 })
assert(#radius <= 24 and report.outside + report.uncovered < 0.3 * report.volume)
local V = ylm.visibility(4, ylm.sphere_casters { at = at, radius = radius }, { 0, 0, 2 })]],
  source = "Wang et al. 2006, the error alone; docs/shadow_fields.md",
}
function sets.sphere_set(geometry, given)
  local mesh = mesh_of(geometry)
  if not mesh then
    return check.bad(1, "sphere_set", "geometry must be a mesh or a shape, got %s", check.describe(geometry))
  end
  local o = form.options(2, "sphere_set", options, given)
  local at, message, code = core.array_zeros({ o.count, 3 }, "double")
  if not at then return nil, message, code end
  local radius
  radius, message, code = core.array_zeros({ o.count }, "double")
  if not radius then return nil, message, code end
  local k, volume, outside, uncovered, step = check.result("sphere_set",
    core.mesh_sphere_set(mesh, o.count, at, radius, progress.of(o.progress)))
  if not k then return nil, volume, outside end
  local report = { volume = volume, outside = outside, uncovered = uncovered, step = step }
  report.warnings = shortfall(mesh, k, report)
  if k == o.count then return at, radius, report end
  return at[{ 1, k }], radius[{ 1, k }], report
end

return sets
