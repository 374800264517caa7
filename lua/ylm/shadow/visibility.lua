--- The visibility of directions past bodies: ylm.visibility.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"
local occluder = require "ylm.shadow.occluder"
local reference = require "ylm.describe"
local shadowed = require "ylm.shadow.shadowed"

local describe = reference.describe

local visibility = {}

local products = shadowed.products

local visibility_options = {
  { "derivatives", "integer", min = 0, max = 1, default = 0, about = "1: gradients too" },
  products[1], products[2], products[3], products[4], products[5], products[6],
  { "dtype", "choice", of = core.choices "dtype", optional = true,
    about = "element type; that of the points where they are an array, else float" },
  form.threads, form.progress,
}

describe "visibility" {
  about = "The part of all directions that casters leave open at points, as spherical harmonics: what ylm.shadowed multiplies "
    .. "light by.",
  arguments = {
    { "lmax", "integer", "highest degree, 0 to 100" },
    { "casters", "caster|table", "a caster, or a table of casters" },
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "options?", "table", "see the options" },
  },
  options = visibility_options,
  returns = { { "V", "array", "[n][(lmax+1)^2]; without casters sqrt(4 pi) in Y(0,0)" },
    { "dV", "array", "[n][(lmax+1)^2][3] with respect to the point, or nil" } },
  errors = "raises on bad arguments; nil, message, code: memory, cancelled",
  example = [[
local ball = ylm.caster { hides = ylm.occluder { radius = 1 }, at = { 0, 2, 0 } }
local V = ylm.visibility(4, ball, { 0, 0, 0 })
assert(math.abs(V[1] / math.sqrt(4 * math.pi) - (1 + math.cos(math.pi / 6)) / 2) < 1e-6)]],
  source = "Zhou et al. 2005; docs/shadow_fields.md",
}
function visibility.visibility(lmax, casters, points, given)
  check.integer(1, "visibility", "lmax", lmax, 0, core.limits.sh_product_lmax)
  local o = shadowed.settle(form.options(4, "visibility", visibility_options, given), function(message)
    return check.bad(4, "visibility", "%s", message)
  end)
  local function fail(message) return check.bad(2, "visibility", "%s", message) end
  local groups = shadowed.groups_of(casters, fail)
  local one, message, code = light.field(2, "visibility", require "ylm.light.environment".environment_light { radiance = 1 })
  if not one then return nil, message, code end
  local object
  object, message, code = occluder.made(fail, shadowed.create(one, groups, o))
  if not object then return nil, message, code end
  local dtype = o.dtype or array.type_of(points, "float")
  local p, single = array.points(3, "visibility", points, dtype)
  local V, dV, why = light.evaluate("visibility", lmax, object, p, { derivatives = o.derivatives, channels = "luminance",
    threads = o.threads, progress = o.progress })
  if V == nil then return nil, dV, why end
  check.result("visibility", core.shadowed_close(object))
  shadowed.heed(groups, groups, lmax)
  local n, count = #p, (lmax + 1) ^ 2
  if single then return core.array_reshape(V, { count }), dV and core.array_reshape(dV, { count, 3 }) end
  return core.array_reshape(V, { n, count }), dV and core.array_reshape(dV, { n, count, 3 })
end

return visibility
