--- Lamps of glTF files as lights of ylm.

local form = require "ylm.form"
local json = require "ylm.gltf.json"
local spot = require "ylm.light.spot"
local sphere = require "ylm.light.sphere"
local sun = require "ylm.light.sun"

local lights = {}

local function largest(c) return math.max(c[1], c[2], c[3]) end

local function times(c, k) return { c[1] * k, c[2] * k, c[3] * k } end

local function near(a, b) return math.abs(a - b) <= 1e-6 * math.abs(b) end

--- Three numbers of extras, or nil.
local function three(x) return form.types.point(x) and x or nil end

--- A sphere of the same intensity, I = pi r^2 L. Radius and radiance that ylm has written hold while the intensity is theirs.
local function as_sphere(l, o)
  local extras = l.extras and json.read(l.extras) or {}
  local radius, given = tonumber(extras.radius), three(extras.radiance)
  if radius and radius >= 0 and radius <= 1e15 and given and o.light_scale == 1
    and near(largest(l.intensity), math.pi * radius * radius * largest(given)) then
    return sphere.sphere_light { at = l.at, radius = radius, radiance = given }
  end
  radius = radius and radius > 0 and radius <= 1e15 and radius or o.lamp_radius
  return sphere.sphere_light { at = l.at, radius = radius,
    radiance = times(l.intensity, o.light_scale / (math.pi * radius * radius)) }
end

local makers = {}

makers.point = as_sphere

function makers.spot(l, o)
  if o.spots == "sphere" then return as_sphere(l, o) end
  local d, at = l.direction, l.at
  local outer = math.max(l.outer, 1e-3)
  return spot.spot_light { at = at, to = { at[1] + d[1], at[2] + d[2], at[3] + d[3] }, angle = math.deg(2 * outer),
    blend = math.max(0, math.min(1, 1 - l.inner / outer)), intensity = times(l.intensity, o.light_scale) }
end

function makers.directional(l, o)
  return sun.sun_light { direction = times(l.direction, -1), irradiance = times(l.intensity, o.light_scale) }
end

--- The lamps of a file as lights; note(sentence, ...) takes what is lost. Or nil, message, code.
function lights.convert(file, o, note)
  local out, count, range = {}, { spot = 0, point = 0, directional = 0 }, 0
  for _, l in ipairs(file.lamps) do
    if largest(l.intensity) > 0 then
      local made, message, code = makers[l.kind](l, o)
      if not made then return nil, message, code end
      out[#out + 1] = made
      count[l.kind] = count[l.kind] + 1
    end
    if l.range then range = range + 1 end
  end
  if count.spot > 0 then
    note(o.spots == "sphere" and "spots that shine all around, as spheres: %d"
      or "spots: %d; rays find their light, probes do not (spots = 'sphere' makes spheres of them)", count.spot)
  end
  if range > 0 then note("lamps whose range is ignored: %d", range) end
  return out
end

return lights
