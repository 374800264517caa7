--- Methods that virtual lights are compared with, on the same lights: points, spheres, and groups of spherical Gaussians.

local check = require "ylm.check"
local core = require "ylm.c.core"
local emit = require "ylm.emit"
local form = require "ylm.form"
local library = require "ylm.library"

local rival = {}

local SAMPLES, GROUPS = 25, 400

--- Options by method.
local own = {
  vpl = {
    { "clamp", "choice", of = core.choices "clamp", default = "geometry",
      about = "what limit bounds: 1/d^2, the geometry term c c/d^2, or this times the receiver's albedo/pi" },
    { "limit", "number", above = 0, optional = true, about = "default 1/r^2, r the median of the lights' radii" },
    { "compensate", "integer", min = 0, max = core.limits.light_samples, default = 0,
      about = "rays of a point that find what the clamp takes away, of lights of scene:virtual_lights" },
  },
  vsl = {
    { "samples", "integer", min = 1, max = core.limits.light_samples, default = SAMPLES,
      about = "directions to a light, times 1 - the cosine of its half angle, at least 4; of 'receiver' all" },
    { "strategy", "choice", of = core.choices "sphere_strategy", default = "mis",
      about = "directions in the light's cone, by the receiver's cosine, or both and the light's, weighed" },
  },
  vsgl = {
    { "groups", "integer", min = 1, optional = true,
      about = "groups of lights, parted where they are widest in place and direction; default " .. GROUPS
        .. ", or as many as lights" },
  },
}

local method_field = { 1, "choice", of = { "vpl", "vsl", "vsgl" },
  about = "points, spheres, or groups of lights as spherical Gaussians" }

--- Rows for help: the method, then the fields of each.
local rows = { method_field }
for _, method in ipairs(method_field.of) do
  for _, field in ipairs(own[method]) do
    local row = {}
    for key, value in pairs(field) do row[key] = value end
    row.about = ("'%s': %s"):format(method, field.about)
    rows[#rows + 1] = row
  end
end

rival.field = { "rival", "table", optional = true, fields = rows, shelf = "comparison",
  about = "of virtual lights: another method than harmonics of their profile, { 'vpl', clamp =, limit =, compensate = }, "
    .. "{ 'vsl', samples =, strategy = } or { 'vsgl', groups = }" }

--- The rival of the option, { method =, .. }, or nil; raises where it is none.
function rival.settle(name, given)
  if given == nil then return nil end
  local method, rest = given[1], {}
  if form.kind(given) or not own[method] then
    local guess = type(method) == "string" and check.guess(method, method_field.of)
    return check.bad(1, name, "rival must be { 'vpl' | 'vsl' | 'vsgl', .. }, got %s%s", check.describe(method),
      guess and (" (did you mean '%s'?)"):format(guess) or "")
  end
  for key, value in pairs(given) do
    if key ~= 1 then
      for other, fields in pairs(own) do
        for _, field in ipairs(fields) do
          if field[1] == key and other ~= method and not (method == "vsl" and key == "samples") then
            return check.fail("%s: rival: %s is for '%s', this is '%s': leave it out", name, key, other, method)
          end
        end
      end
      rest[key] = value
    end
  end
  local x = form.options(1, name .. ": rival", own[method], rest)
  x.method = method
  if x.clamp == "none" and x.limit then
    return check.fail("%s: rival: limit is of a clamp, clamp is 'none': leave it out", name)
  end
  if x.clamp == "none" and x.compensate > 0 then
    return check.fail("%s: rival: compensate finds what a clamp takes away, clamp is 'none': leave it out", name)
  end
  return x
end

--- Raises where the subset of a sum is none of a rival's.
function rival.check_subset(name, x, sum)
  if x and x.method == "vsgl" and sum.subset ~= "all" then
    return check.fail("%s: virtual: subset = '%s' is of single lights, rival = 'vsgl' asks all of its groups", name, sum.subset)
  end
end

--- 1 over the square of the median radius.
local function default_limit(name, lights)
  local _, _, radius = core.lights_virtual_arrays(lights.lights)
  local sorted = core.array_totable(radius)
  table.sort(sorted)
  local r = sorted[math.floor(#sorted / 2) + 1]
  if #sorted == 0 then return 1 end
  if r > 0 and 1 / r ^ 2 < math.huge then return 1 / r ^ 2 end
  return check.fail("%s: rival: limit is needed: the lights have %s to find one by", name,
    r > 0 and ("too small a radius (%g)"):format(r) or "no radius")
end

--- Settles b.rival by b.lights, the virtual lights of a picture of p.
function rival.ready(name, p, b)
  local x, lights = b.rival, b.lights
  if lights.profile ~= "point" and lights.profile ~= "gauss" and lights.profile ~= "cap" then
    return check.fail("%s: rival: lights of profile '%s' are parts of lights, which only harmonics know", name, lights.profile)
  end
  if x.method == "vpl" then
    if x.clamp ~= "none" then x.limit = x.limit or default_limit(name, lights) end
    if x.compensate == 0 then return end
    local made = emit.made(lights)
    if not made or made.scene ~= p.scene then
      return check.fail("%s: rival: compensate needs lights that scene:virtual_lights made of the view's scene, whose lamps it "
        .. "asks", name)
    end
    x.bounces = made.bounces
  elseif x.method == "vsgl" then
    if x.groups and x.groups > lights.count then
      return check.fail("%s: rival: groups (%d) must be at most the %d lights", name, x.groups, lights.count)
    end
    x.groups = math.min(x.groups or GROUPS, lights.count)
  end
end

--- The answer of C about lights; methods that answer EMISSING are those of libylm_rival, which is loaded first.
function rival.ask(p, ...)
  local radiance, facts, code = p.lib.shade_virtual(p.view, ...)
  if code ~= "EMISSING" then return radiance, facts, code end
  local binding, message
  binding, message, code = library.rival_binding()
  if not binding then return nil, message, code end
  p.lib.shade_rivals(binding.many())
  return p.lib.shade_virtual(p.view, ...)
end

--- Completes report.virtual.
function rival.report(b, r, facts)
  r.rival, r.limit = b.rival.method, b.rival.limit
  r.groups = b.rival.method == "vsgl" and facts.lights or nil
end

return rival
