--- Lamps of glTF files as lights of ylm.

local environment = require "ylm.light.environment"
local form = require "ylm.form"
local json = require "ylm.gltf.json"
local memory = require "ylm.memory"
local photometric = require "ylm.light.photometric"
local photometry = require "ylm.photometry"
require "ylm.light.polygon" -- the forms
local spot = require "ylm.light.spot"
local sphere = require "ylm.light.sphere"
local sun = require "ylm.light.sun"
local vector = require "ylm.vector"

local lights = {}

local function largest(c) return math.max(c[1], c[2], c[3]) end

local times = vector.times

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

--- Do two directions differ by less than 1e-6?
local function along(a, b)
  a, b = vector.unit(a), vector.unit(b)
  return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] > 1 - 1e-12
end

local makers = {}

makers.point = as_sphere

function makers.spot(l, o)
  if o.spots == "sphere" then return as_sphere(l, o) end
  local d, at, extras = l.direction, l.at, l.extras and json.read(l.extras) or {}
  local outer = math.max(l.outer, 1e-3)
  local values = { at = at, to = { at[1] + d[1], at[2] + d[2], at[3] + d[3] }, angle = math.deg(2 * outer),
    blend = math.max(0, math.min(1, 1 - l.inner / outer)), intensity = times(l.intensity, o.light_scale) }
  local to, intensity = three(extras.to), three(extras.intensity)
  if to and along({ to[1] - at[1], to[2] - at[2], to[3] - at[3] }, d) then values.to = to end
  if intensity and o.light_scale == 1 and near(largest(l.intensity), largest(intensity)) then values.intensity = intensity end
  for _, name in ipairs { "angle", "blend" } do
    local x = extras[name]
    if type(x) == "number" and math.abs(x - values[name]) <= 1e-6 then values[name] = x end
  end
  return spot.spot_light(values)
end

function makers.directional(l, o)
  local extras = l.extras and json.read(l.extras) or {}
  local values = { direction = times(l.direction, -1), irradiance = times(l.intensity, o.light_scale) }
  local direction, irradiance, angle = three(extras.direction), three(extras.irradiance), extras.angle
  if direction and largest(times(direction, -1)) + largest(direction) > 0 and along(direction, values.direction) then
    values.direction = direction
  end
  if irradiance and o.light_scale == 1 and near(largest(l.intensity), largest(irradiance)) then values.irradiance = irradiance end
  if type(angle) == "number" and angle >= 0.001 and angle <= 180 then values.angle = angle end
  return sun.sun_light(values)
end

--- A photometric file of EXT_lights_ies, a point there: a sphere of the radius that points have.
function makers.profile(l, o, file)
  file.photometry = file.photometry or {}
  local p, message, code = file.photometry[l.profile]
  if not p then
    p, message, code = photometry.of_bytes(("profile %d"):format(l.profile), file.profiles[l.profile])
    if not p then return nil, message, code end
    file.photometry[l.profile] = p
  end
  local d, at = l.direction, l.at
  return photometric.photometric_light { photometry = p, at = at, to = { at[1] + d[1], at[2] + d[2], at[3] + d[3] },
    turn = photometric.turn_of(d, l.across), colour = l.intensity,
    dim = math.min(1e6, o.light_scale * vector.luminance(l.intensity)),
    opening = { shape = "sphere", radius = math.min(o.lamp_radius, 50) } }
end

--- The flat light that ylm has written as this surface, while it is where it was, and emits as it did; else nil.
function lights.of_piece(piece, extras, emission, o)
  local definition = form.defined[extras.light]
  local as_light = definition and definition.light
  if not as_light or not as_light.outline or not emission or o.light_scale ~= 1 then return nil end
  local given = {}
  for _, field in ipairs(definition.fields) do given[field[1]] = extras[field[1]] end
  local ok, made = pcall(definition.construct, given)
  if not ok or not made then return nil end
  for i = 1, 3 do
    if math.abs(made.radiance[i] - emission[i]) > 1e-6 * largest(emission) then return nil end
  end
  local lo, hi = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  for _, p in ipairs(as_light.outline(made)) do
    for i = 1, 3 do lo[i], hi[i] = math.min(lo[i], p[i]), math.max(hi[i], p[i]) end
  end
  local bounds, size = piece.mesh.bounds, 0
  for i = 1, 3 do size = math.max(size, math.abs(lo[i]), math.abs(hi[i])) end
  for i = 1, 3 do
    if math.abs(bounds[1][i] - lo[i]) > 1e-6 * size or math.abs(bounds[2][i] - hi[i]) > 1e-6 * size then return nil end
  end
  return made
end

--- The skies of extras.ylm of a scene as lights; those that are no skies, or too large, are left out with a note.
function lights.skies(list, o, note)
  local out, wrong = {}, 0
  for _, given in ipairs(type(list) == "table" and list or {}) do
    local plain = {}
    for _, name in ipairs { "radiance", "coefficients", "sky", "lmax", "scale" } do
      plain[name] = type(given) == "table" and given[name] or nil
    end
    plain.scale = (tonumber(plain.scale) or 1) * o.light_scale
    local ok, made = memory.pcall(environment.environment_light, plain)
    if ok and made then
      made.of_file = true
      out[#out + 1] = made
    else wrong = wrong + 1 end
  end
  if wrong > 0 then note("skies of extras.ylm left out, because they are none: %d", wrong) end
  return out
end

--- The lamps of a file as lights; note(sentence, ...) takes what is lost. Or nil, message, code.
function lights.convert(file, o, note)
  local out, count, range = {}, { spot = 0, point = 0, directional = 0, profile = 0 }, 0
  for _, l in ipairs(file.lamps) do
    if largest(l.intensity) > 0 then
      local made, message, code = makers[l.kind](l, o, file)
      if made then
        made.of_file = true -- its numbers go with either unit
        out[#out + 1] = made
        count[l.kind] = count[l.kind] + 1
      elseif l.kind == "profile" and code == "EFORMAT" then
        note("photometric lamps left out: %s", message)
      else
        return nil, message, code
      end
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
