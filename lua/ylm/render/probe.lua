--- The light that arrives at points, by paths: what grids and probes are judged by.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local estimates = require "ylm.render.estimates"
local form = require "ylm.form"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local reports = require "ylm.render.reports"
local show = require "ylm.show"
local tracing = require "ylm.trace"

local probe = {}

local probe_options = options.list({
  { "points", "any", about = "array [n][3] or list: where light arrives, scene units" },
  { "normals", "any", optional = true, about = "array [n][3] or list: asks for the irradiance of surfaces instead" },
  options.view_fields[3],
  { "lmax", "integer", min = 0, max = core.limits.path_lmax, default = 4, about = "highest degree" },
  { "samples", "integer", min = 1, max = estimates.MOST_SAMPLES, default = 4096,
    about = "paths from each point, in batches of 16, of which there are two at least" },
  { "reflections", "reflections", optional = true,
    about = "instead of bounces, { first, last }: 0 straight from lamps, 1 the first bounce; last also 'all'" },
  { "guides", "boolean", default = true, shelf = "experiments",
    about = "of irradiance, with normals: rays to lamps and directions learn from a pilot what is seen from where, and how much "
      .. "light is reflected there: no bias, less noise; false: they do not" },
}, estimates.options, options.common)

describe "scene:probe" {
  shelf = "everyday",
  about = "The light that arrives at points, by paths: what grids and probes are judged by.",
  arguments = { { "options", "table", "points are needed" } },
  options = probe_options,
  returns = {
    { "c", "array", "double [n][3][(lmax+1)^2], coefficients of the radiance that arrives; with normals the irradiance [n][3]" },
    { "variance", "array", "of these means, of the same shape" },
    { "report", "table", reports.text },
  },
  report = reports.of_probe,
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local c, variance, report = scene:probe { points = { { 0, 0.5, 1 } }, lmax = 2, samples = 256 }
assert(c.shape[3] == 9 and variance:get(1, 1, 1) > 0 and report.samples == 256)
local E = scene:probe { points = { { 0, 0, 1 } }, normals = { { 0, 1, 0 } }, samples = 256, bounces = 0 }
assert(E:get(1, 1) > 0)]],
  source = "Kajiya 1986; Veach & Guibas 1995",
}
function probe.probe(s, given) return probe.kept(s, given) end

--- As scene:probe, by the guides that `kept` holds, or is to hold; nil: by its own (promise.lua).
function probe.kept(s, given, kept)
  tracing.check_scene("probe", s)
  local o = form.options(1, "probe", probe_options, given)
  o.progress = progress.long(o.progress)
  local first, last = estimates.orders("probe", o, 0)
  local points, normals = array.places(1, "probe", o.points), nil
  if o.normals then
    normals = array.rows(1, "probe", "normals", o.normals, 3, "float")
    if #normals ~= #points or #normals.shape ~= #points.shape and #points > 1 then
      return check.bad(1, "probe", "normals: one for each of %d points expected, got %d", #points, #normals)
    end
  end
  local t, message, code = tracing.trace("probe", s)
  if not t then return nil, message, code end
  tracing.check_bodies("probe", t)
  local c, variance, stats = check.result("probe", t.lib.path_probe(t.handle, {
    points = points, normals = normals, lmax = o.lmax, samples = o.samples, first = first, last = last,
    guides = o.guides and normals ~= nil, kept = kept, strategy = o.strategy, error = o.tolerance, seconds = o.time_limit,
    seed = o.seed, threads = o.threads, progress = progress.resolve(o.progress) }))
  if not c then return nil, variance, stats end
  local report = show.report { note = estimates.darkness(s), seconds = stats.seconds }
  estimates.add_stats(report, stats)
  return c, variance, report
end

return probe
