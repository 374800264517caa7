--- Light that bounces by virtual lights: indirect = "virtual" of pictures.

local check = require "ylm.check"
local core = require "ylm.c.core"
local emit = require "ylm.emit"
local form = require "ylm.form"
local gather = require "ylm.render.gather"
local split = require "ylm.render.split"

local virtual = {}

local fields = {
  { "method", "choice", of = { "virtual" }, about = "" },
  { "lights", "object", of = "virtual_lights", optional = true, about = "instead of those that particles leave" },
  { "lmax", "integer", min = 0, max = core.limits.lmax, default = 4, about = "highest degree" },
  { "shadows", "choice", of = { "none", "centre" }, default = "none", about = "as of view:gather" },
}
for _, list in ipairs { split.fields, emit.fields } do
  for _, field in ipairs(list) do fields[#fields + 1] = field end
end

--- Does the option `indirect` ask for virtual lights?
function virtual.is_wanted(x)
  return x == "virtual" or type(x) == "table" and form.kind(x) == nil and x.method ~= nil
    or form.kind(x) == "virtual_lights"
end

--- The entry o.bounced by lights that are given, with options.
local function given_lights(name, lights, given, o)
  if o.bounces ~= nil then
    return check.fail("%s: bounces and indirect say the same: leave one out", name)
  end
  for _, field in ipairs(emit.fields) do
    if given[field[1]] ~= nil then
      return check.fail("%s: %s is of lights that are made, here are lights: leave one out", name, field[1])
    end
  end
  local made = emit.made[lights]
  return { by = "virtual", lights = lights, bounces = made and made.bounces or "those of the lights",
    options = form.options(1, name, fields, given) }
end

--- The entry o.bounced of options that ask for them: { by = "virtual", bounces =, options =, lights = }.
function virtual.settle(name, x, o)
  if form.kind(x) == "virtual_lights" then return given_lights(name, x, { method = "virtual" }, o) end
  if type(x) == "table" and form.kind(x.lights) == "virtual_lights" then return given_lights(name, x.lights, x, o) end
  local bounces = o.bounces or 1
  if bounces ~= "all" and bounces > 64 then
    return check.fail("%s: particles are reflected 64 times at most: bounces must be 0 to 64 or 'all', got %.0f", name, bounces)
  end
  local own = form.options(1, name, fields, x == "virtual" and { method = "virtual" } or x)
  if bounces == 0 then return nil end
  return { by = "virtual", bounces = bounces, options = own }
end

--- Makes the lights of o.bounced: true, or nil, message, code.
function virtual.ready(name, p, o)
  local b, start = o.bounced, core.seconds()
  if not b.lights then
    local own = {}
    for key, value in pairs(b.options) do own[key] = value end
    own.bounces = b.bounces == "all" and 64 or b.bounces
    own.seed, own.threads, own.progress = p.options.seed, o.threads, o.progress
    local lights, report, code = emit.lights(name, p.scene, own, o.lit)
    if not lights then return nil, report, code end
    b.lights, b.emitted = lights, report
  end
  b.split = split.is_wanted(name, p, b)
  if b.split then
    local ok, message, code = split.ready(name, p, o, b)
    if not ok then return nil, message, code end
  end
  b.prepared = core.seconds() - start
  return true
end

--- Their radiance at the shading points, a new array; or nil, message, code.
function virtual.radiance(name, p, o)
  local b = o.bounced
  if b.split then return split.radiance(name, p, o, b) end
  local out, facts, code = gather.radiance(name, p, { lights = b.lights, method = "hvl", lmax = b.options.lmax,
    shadows = b.options.shadows, threads = o.threads, progress = o.progress })
  b.facts = out and facts
  return out, facts, code
end

--- Completes a picture's report.
function virtual.report(p, o, report)
  local b = o.bounced
  report.virtual = { lights = b.lights.count, pairs = b.facts.pairs, shadows = b.options.shadows, emitted = b.emitted,
    sums = b.split and "split" or "all" }
  if b.split then split.report(p, b, report) end
  report.rays.virtual = b.facts.rays
  for _, sentence in ipairs(b.emitted and b.emitted.warnings or {}) do report.warnings[#report.warnings + 1] = sentence end
  gather.say(p, b.options.shadows, report, b.lights, o.threads)
end

return virtual
