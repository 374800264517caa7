--- Direct light by transfer vectors that are given: view:transfer's, or others. Surfaces reflect as matte ones.

local check = require "ylm.check"
local core = require "ylm.c.core"
local light = require "ylm.light"
local lmax_of = require "ylm.sh.args".lmax_of
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"
local progress = require "ylm.progress"

local vectors = { name = "vectors", called = 'by = "vectors"', alone = true }

vectors.options = {}
vectors.view_options = {
  { "vectors", "array", optional = true, shelf = "experiments",
    about = "transfer vectors of the view's points, float [n][3][(lmax+1)^2] or [n][(lmax+1)^2]. Light is asked at every point, "
      .. "so that vectors without bounces know any light, and vectors with bounces distant light" },
  options.lights_field,
}

function vectors.wants(o, p) return p ~= nil and o.vectors ~= nil end

--- The vectors as a float array, and their lmax.
local function given_vectors(name, p, value)
  if value == nil then return check.bad(1, name, "field 'vectors' is missing (view:transfer makes them)") end
  local shape, dtype = core.array_info(value)
  local n, lmax = p.stats.points, lmax_of(shape[#shape])
  if shape[1] ~= n or #shape < 2 or #shape > 3 or #shape == 3 and shape[2] ~= 3 or not lmax then
    return check.fail("%s: vectors must be [%d][3][(lmax+1)^2] or [%d][(lmax+1)^2], got %s", name, n, n,
      table.concat(shape, "x"))
  end
  return dtype == "float" and value or core.array_convert(value, "float"), lmax
end

function vectors.prepare(name, p, o)
  local x, message, code = { lights = p.traced.lights }, nil, nil
  x.vectors, x.lmax = given_vectors(name, p, o.vectors)
  if o.lights ~= nil then x.lights, message, code = light.field(1, name, o.lights) end
  if not x.lights then return nil, message, code end
  local report = pictures.new_report(p)
  report.visibility, o.taken = "vectors", x
  return p, report
end

function vectors.radiance(name, p, o, report)
  local start, x = core.seconds(), o.taken
  local radiance, pairs, code = check.result(name, p.lib.shade_by_vectors(p.view, x.vectors, x.lmax, x.lights, o.threads,
    progress.resolve(o.progress)))
  if not radiance then return nil, pairs, code end
  report.pairs = pairs
  return radiance, core.seconds() - start
end

function vectors.report(p, _, report, image)
  pictures.sign(image, p, "vectors", report, { pairs = ("%.0f"):format(report.pairs) })
end

return vectors
