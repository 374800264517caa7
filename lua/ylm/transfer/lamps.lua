--- Lamps that derivatives are known of, as C takes them: spheres, disks, polygons, spots, suns, and lamps with a photometry. Of
-- all other lights derivatives by level and colour are known.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local vector = require "ylm.vector"

local lamps = {}

local SINE = 1 - 1e-9 -- of half the angle of a sun, at most
local STEP = 1e-9     -- of the cosine, over which light of a spot without blend ends

--- Codes of ylm_lamp_shape.
local codes = {}
for i, name in ipairs(core.choices "lamp_shape") do codes[name] = i - 1 end

local dot, minus, times = vector.dot, vector.minus, vector.times

--- Numbers of a lamp whose light is a field of it times `unit`: shape, place, axis, C0, half sizes, scale, and its flux where
-- that of scale 1 is `flux`.
local function of_colour(colour, unit, flux, l)
  l.scale, l.full, l.by_colour, l.dim, l.table = times(colour, unit), times(colour, unit), unit, 1, 0
  l.flux = flux * vector.luminance(l.scale)
  l.axis = l.axis or { 0, -1, 0 }
  l.across = l.across or vector.across(l.axis)
  l.half = l.half or { 0, 0 }
  return l
end

local kinds = {}

--- Numbers of a lamp: shape, place, axis, C0, half sizes, scale, the name of its table; and the scale at full power.
function kinds.photometric_light(l)
  local per = 1 / (l.efficacy or 1)
  return { shape = l.shape, at = l.at, axis = l.axis, across = l.across, half = l.half, scale = l.scale,
    table = core.owned(l.photometry, "facts").name, full = times(l.rgb, per), flux = l.photometry.lumens * per,
    by_colour = per * l.dim, by_channels = per, dim = l.dim, turn = l.turn }
end

function kinds.sphere_light(l)
  return of_colour(l.radiance, math.pi * l.radius ^ 2, 4 * math.pi,
    { shape = "sphere", at = l.at, across = { 1, 0, 0 }, half = { l.radius, l.radius } })
end

function kinds.disk_light(l)
  if l.horizon then return nil end
  local power = 1 + l.spread
  return of_colour(l.radiance, math.pi * l.radius ^ 2, 4 * math.pi / (power + 1),
    { shape = "disk", at = l.at, axis = vector.unit(l.normal), half = { l.radius, l.radius }, power = power })
end

function kinds.polygon_light(l)
  if l.horizon then return nil end
  local flat = lamps.outline(l.vertices)
  local corners = {}
  for i, v in ipairs(l.vertices) do
    local x = minus(v, flat.at)
    corners[i] = { dot(x, flat.across), dot(x, vector.cross(flat.across, flat.axis)) }
  end
  return of_colour(l.radiance, flat.area, 2 * math.pi,
    { shape = "polygon", at = flat.at, axis = flat.axis, across = flat.across, half = { 1, 1 }, power = 1, corners = corners })
end

function kinds.spot_light(l)
  local outer, inner = math.cos(math.rad(l.angle / 2)), math.cos(math.rad(l.angle / 2 * (1 - l.blend)))
  return of_colour(l.intensity, 1, 2 * math.pi * (1 - (inner + outer) / 2),
    { shape = "point", at = l.at, axis = vector.unit(minus(l.to, l.at)),
      cone = { outer, math.max(inner, outer + STEP) } })
end

function kinds.sun_light(l)
  local half = math.rad(l.angle / 2)
  local sine = math.min(math.sin(half), SINE)
  return of_colour(l.irradiance, 1, 0, { shape = "sun", at = { 0, 0, 0 }, axis = vector.unit(l.direction), half = { sine, sine },
    by_factor = half * math.cos(half) })
end

--- The middle, normal, area and a direction in the plane of a convex polygon.
function lamps.outline(vertices)
  local a, normal, area, at = vertices[1], { 0, 0, 0 }, 0, { 0, 0, 0 }
  for i = 2, #vertices - 1 do
    local b, c = vertices[i], vertices[i + 1]
    local n = vector.cross(minus(b, a), minus(c, a))
    local part = vector.length(n) / 2
    area = area + part
    for k = 1, 3 do normal[k], at[k] = normal[k] + n[k], at[k] + part * (a[k] + b[k] + c[k]) / 3 end
  end
  local axis = vector.unit(normal)
  return { at = times(at, 1 / area), axis = axis, across = vector.across(axis), area = area }
end

--- A light of which level and colour alone are known: skies, images, light fields that rays see.
local function other(l)
  return { other = true, scale = { 1, 1, 1 }, full = { 1, 1, 1 }, by_colour = 1, dim = 1, flux = 0, axis = { 0, -1, 0 },
    half = { 0, 0 }, kind = type(l) == "table" and form.kind(l) or core.type(l) }
end

local function flatten(lights, list)
  if type(lights) ~= "table" then list[#list + 1] = lights
  elseif form.kind(lights) then list[#list + 1] = lights
  else for i = 1, #lights do flatten(lights[i], list) end end
  return list
end

--- The lamps of lights, a list of descriptions; raises where one is no light.
function lamps.list(name, lights)
  local list = {}
  for i, l in ipairs(flatten(lights, {})) do
    local kind = type(l) == "table" and form.kind(l) or core.type(l)
    local as_light = type(l) == "table" and form.defined[kind] and form.defined[kind].light
    if not as_light and kind ~= "ylm.lights" then
      return check.fail("%s: derivatives = true is for lamps and skies; light %d is %s", name, i,
        type(l) == "table" and kind and "a " .. kind or check.describe(l))
    end
    list[i] = kinds[kind] and kinds[kind](l) or other(l)
    list[i].light = l
    if kind == "sphere_light" and not (l.radius > 0) then
      return check.fail("%s: light %d has the radius 0: it emits nothing, and has no derivatives", name, i)
    end
  end
  return list
end

--- Double [n][20] of such descriptions without others, and [m][2] of the corners of all polygons.
function lamps.rows(list)
  local rows, corners = {}, {}
  for _, l in ipairs(list) do
    if not l.other then
      local cone = l.cone or { 0, 0 }
      rows[#rows + 1] = { codes[l.shape], l.at[1], l.at[2], l.at[3], l.axis[1], l.axis[2], l.axis[3], l.across[1], l.across[2],
        l.across[3], l.half[1], l.half[2], l.scale[1], l.scale[2], l.scale[3], l.table, l.power or 0, cone[1], cone[2],
        l.corners and #l.corners or 0 }
      for _, c in ipairs(l.corners or {}) do corners[#corners + 1] = c end
    end
  end
  local function of(list_of, width)
    if #list_of == 0 then return array.zeros({ 0, width }, "double") end
    return array.array(list_of, "double")
  end
  return of(rows, 20), of(corners, 2)
end

--- Derivatives by the direction of length 1 that a lamp looks in, and by its turn, degrees, from those by turns about x, y, z.
-- C0 stays where ylm.photometric_light has it: across +x, or +z of lamps that look along x.
function lamps.by_direction(l, turn)
  local a = l.axis
  local by_turn = -dot(turn, a)
  local out = vector.cross(turn, a)
  if l.turn then
    local across, tilt = vector.across(a)
    local side = vector.cross(across, a)
    for i = 1, 3 do out[i] = out[i] - by_turn * tilt * side[i] end
  end
  return out, by_turn * math.pi / 180
end

--- Is a lamp's shadow one whose derivative by its place is known?
function lamps.has_rim(l) return l.shape ~= "point" end

return lamps
