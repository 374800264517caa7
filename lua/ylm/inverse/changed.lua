--- Lights with other numbers: what of each kind may vary, and how a change of it becomes a light.
--
-- A change is { at, axis, turn, dim, channels, temperature, factor }, each as it is to be; at and axis are always there. Lumens
-- stay where the size changes.

local form = require "ylm.form"
local lamps = require "ylm.transfer.lamps"
local pack = require "ylm.light.pack"
local vector = require "ylm.vector"

local changed = {}

local DARK = 1e-6 -- the least level of lights of which level and colour alone are known: their light tells their derivative

local times = vector.times

local function ahead(c) return { c.at[1] + c.axis[1], c.at[2] + c.axis[2], c.at[3] + c.axis[3] } end

--- The colour of a field by channels, by a level, and by a size that holds lumens.
local function coloured(colour, c)
  return times(c.channels or times(colour, c.dim or 1), 1 / (c.factor or 1) ^ 2)
end

local kinds = {}

function kinds.photometric_light(l, c)
  local fresh = { at = c.at, to = ahead(c), turn = c.turn, dim = c.dim, temperature = c.temperature }
  if c.factor then
    local w = { c.factor * l.half[1], c.factor * l.half[2] }
    fresh.opening = l.shape == "rectangle" and { shape = "rectangle", size = { 2 * w[1], 2 * w[2] } }
      or { shape = l.shape, radius = w[1] }
  end
  if c.channels then
    fresh.dim = vector.luminance(c.channels)
    fresh.colour = fresh.dim > 0 and c.channels or { 1, 1, 1 }
  end
  return fresh, c.channels and "temperature" or c.temperature and "colour" or nil
end

function kinds.sphere_light(l, c)
  return { at = c.at, radius = l.radius * (c.factor or 1), radiance = coloured(l.radiance, c) }
end

function kinds.disk_light(l, c)
  return { at = c.at, normal = c.axis, radius = l.radius * (c.factor or 1), radiance = coloured(l.radiance, c) }
end

--- A vector turned as the unit vector a is turned to b, by the shortest way.
local function turned(v, a, b)
  local w = vector.cross(a, b)
  local once = vector.cross(w, v)
  local twice, over = vector.cross(w, once), 1 / (1 + vector.dot(a, b))
  return { v[1] + once[1] + over * twice[1], v[2] + once[2] + over * twice[2], v[3] + once[3] + over * twice[3] }
end

function kinds.polygon_light(l, c, from)
  local vertices = {}
  for i, v in ipairs(l.vertices) do
    local arm = turned(times(vector.minus(v, from.at), c.factor or 1), from.axis, c.axis)
    vertices[i] = { c.at[1] + arm[1], c.at[2] + arm[2], c.at[3] + arm[3] }
  end
  return { vertices = vertices, radiance = coloured(l.radiance, c) }
end

function kinds.spot_light(l, c) return { to = ahead(c), intensity = coloured(l.intensity, c) } end

function kinds.sun_light(l, c)
  return { direction = c.axis, angle = math.min(180, l.angle * (c.factor or 1)), irradiance = c.channels
    or times(l.irradiance, c.dim or 1) }
end

function kinds.environment_light(l, c) return { scale = l.scale * math.max(c.dim or 1, DARK) } end

--- Fields that may vary, by kind; of photometric lights all.
local may = {
  sphere_light = { position = true, dim = true, colour = true, size = true },
  disk_light = { position = true, direction = true, dim = true, colour = true, size = true },
  polygon_light = { position = true, direction = true, dim = true, colour = true, size = true },
  spot_light = { direction = true, dim = true, colour = true },
  sun_light = { direction = true, dim = true, colour = true, size = true },
  environment_light = { dim = true },
}

local fields = { sphere_light = "radiance", disk_light = "radiance", polygon_light = "radiance", spot_light = "intensity",
  sun_light = "irradiance" }

--- Why `what` of a light may not vary: the end of a sentence; nil: it may. `lamp`: its description.
function changed.why_not(what, lamp)
  local kind = form.kind(lamp.light) or "a set of lights"
  if kind ~= "photometric_light" and not (may[kind] and may[kind][what]) then
    if kind == "spot_light" and what == "position" then return "is a point: the shadow of a point has no derivative" end
    return ("is a %s, whose %s does not vary"):format(kind, what)
  end
  if lamp.other and what ~= "dim" then return ("has a horizon, and its %s does not vary"):format(what) end
  if lamp.shape == "point" and (what == "position" or what == "size") then
    return "is a point: give it an opening, the shadow of a point has no derivative"
  end
end

--- The channels of a light as they are: of dim times colour, of radiance, irradiance or intensity; nil: it has none.
function changed.channels(light)
  local kind = form.kind(light)
  if kind == "photometric_light" then return times(light.rgb, light.dim) end
  return fields[kind] and light[fields[kind]]
end

--- Its level: dim, or 1: what its channels are multiplied by.
function changed.level(light) return form.kind(light) == "photometric_light" and light.dim or 1 end

--- The least level at which a light's derivative by it is known from its light.
function changed.least_level(lamp) return lamp.other and DARK or 0 end

--- The light that is `lamp`, a description of lamps.list, but for a change.
function changed.light(lamp, c)
  local fresh, without = kinds[form.kind(lamp.light)](lamp.light, c, lamp)
  return pack.moved(lamp.light, fresh, without)
end

--- A change that changes nothing.
function changed.none(lamp)
  local at, axis = lamp.at or { 0, 0, 0 }, lamp.axis
  return { at = { at[1], at[2], at[3] }, axis = { axis[1], axis[2], axis[3] } }
end

--- The lamps of lights as lamps.list has them.
function changed.lamps(lights) return lamps.list("inverse_lighting", lights) end

--- The middles of those lights that have one.
function changed.places(lights)
  local out = {}
  for _, l in ipairs(changed.lamps(lights)) do if l.at and l.shape ~= "sun" then out[#out + 1] = l.at end end
  return out
end

return changed
