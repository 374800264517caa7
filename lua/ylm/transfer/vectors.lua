--- Transfer vectors with bounces, of light that is the same everywhere: links:vectors.

local check = require "ylm.check"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"

require "ylm.transfer.form" -- what links are
require "ylm.transfer.radiosity" -- what bounces are

local vectors = {}

vectors.stats_text = "bounces, closed, residual, shrink as of a radiosity, for the elements' vectors; seconds"

--- Options of bounces, which views have too.
vectors.options = {
  { "bounces", "bounces_summed", default = "all", about = "reflections after direct light: 0 is direct light alone" },
  { "residual", "number", above = 0, max = 1, default = 1e-3, about = "the relative change at which 'all' bounces end" },
  { "closure", "boolean", default = true, about = "'all' bounces: the rest is added as the geometric series of the last change" },
  form.threads,
  form.progress,
}

--- The elements' vectors with that many bounces (-1: all), as C keeps them, and their statistics; nil, message, code.
local function solve(name, t, m, bounces, o, show)
  local rows, stats, code = check.result(name, m.lib.transfer_vectors(t, bounces, o.residual, o.closure, o.threads, show))
  if rows == nil then return nil, stats, code end
  return rows, stats
end

--- The elements' vectors that arrive elsewhere with o.bounces, one bounce less (false where that is
-- none), and their statistics; or nil, message, code.
function vectors.arriving(name, t, m, o, show)
  if o.bounces == 0 then return false, { bounces = 0, closed = false, residual = 0, shrink = 0, seconds = 0 } end
  return solve(name, t, m, o.bounces == "all" and -1 or o.bounces - 1, o, show)
end

local fields = { { "object", "integer", min = 1, optional = true,
  about = "a place in scene.geometry: vectors of its vertices, means of those of the elements around each, by area" } }
for _, field in ipairs(vectors.options) do fields[#fields + 1] = field end

describe "links:vectors" {
  about = "Transfer vectors of the elements, or of the vertices of a part of the geometry, with bounces: irradiance is their "
    .. "product with coefficients of light that is the same everywhere (a sky, a sun). Lamps in a room are not: see "
    .. "links:radiosity.",
  arguments = { { "options?", "table", "" } },
  options = fields,
  returns = {
    { "T", "array", "float [n][3][(lmax+1)^2], lmax that of the links" },
    { "stats", "table", vectors.stats_text },
  },
  errors = "raises on a bad option, and on bounces that do not converge (albedo 1 in a closed scene); nil, message, code: "
    .. "memory, cancelled",
  example = [[
local scene = ylm.scene "a bowl" { geometry = ylm.sphere { divide = 8, material = ylm.matte { albedo = 0.5 } } }
local t = scene:links { rays = 16, lmax = 2 }
local T = t:vectors { bounces = 1 }
assert(T.shape[1] == t.stats.elements and T.shape[2] == 3 and T.shape[3] == 9)
assert(#t:vectors { object = 1 } == #scene.geometry[1].mesh:vertices())]],
  source = "Green 2003, \"Diffuse Interreflected Transfer\"; Sloan et al. 2002",
}
function objects.links.vectors(t, given)
  local m = objects.open_links("vectors", t)
  local o = form.options(1, "vectors", fields, given)
  if o.object and o.object > #m.scene.geometry then
    return check.bad(1, "vectors", "object must be from 1 to %d, the parts of scene.geometry, got %.0f", #m.scene.geometry,
      o.object)
  end
  local rows, stats, code = solve("vectors", t, m, o.bounces == "all" and -1 or o.bounces, o, progress.resolve(o.progress))
  if not rows then return nil, stats, code end
  local T, message
  if o.object then
    T, message, code = check.result("vectors", m.lib.transfer_vectors_of(t, rows, o.object))
  else
    T, message, code = check.result("vectors", m.lib.transfer_vectors_rows(t, rows))
  end
  if not T then return nil, message, code end
  return T, stats
end

return vectors
