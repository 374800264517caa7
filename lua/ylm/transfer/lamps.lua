--- Lamps that derivatives are known of, as C takes them: spheres, and lamps with a photometry.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local vector = require "ylm.vector"

local lamps = {}

--- Codes of ylm_light_opening.
local codes = {}
for i, name in ipairs(core.choices "opening") do codes[name] = i - 1 end

local kinds = {}

--- Numbers of a lamp: opening, place, axis, C0, half sizes, scale, the name of its table; and the scale at full power.
function kinds.photometric_light(l)
  local per = 1 / (l.efficacy or 1)
  return { opening = l.shape, at = l.at, axis = l.axis, across = l.across, half = l.half, scale = l.scale,
    table = core.owned(l.photometry, "facts").name, full = { per * l.rgb[1], per * l.rgb[2], per * l.rgb[3] },
    flux = l.photometry.lumens * per, by_colour = per * l.dim, dim = l.dim, turn = l.turn }
end

function kinds.sphere_light(l)
  local area, c = math.pi * l.radius ^ 2, l.radiance
  local scale = { area * c[1], area * c[2], area * c[3] }
  local flux = 4 * math.pi * vector.luminance(scale)
  return { opening = "sphere", at = l.at, axis = { 0, -1, 0 }, across = { 1, 0, 0 }, half = { l.radius, l.radius }, scale = scale,
    table = 0, full = scale, flux = flux, by_colour = area, dim = 1 }
end

local function flatten(lights, list)
  if type(lights) ~= "table" then list[#list + 1] = lights
  elseif form.kind(lights) then list[#list + 1] = lights
  else for i = 1, #lights do flatten(lights[i], list) end end
  return list
end

--- The lamps of lights, a list of descriptions; raises where a light is of a kind without derivatives.
function lamps.list(name, lights)
  local list = {}
  for i, l in ipairs(flatten(lights, {})) do
    local describe = kinds[type(l) == "table" and form.kind(l) or ""]
    if not describe then
      return check.fail("%s: derivatives = true is for lists of sphere_light and photometric_light; light %d is %s", name, i,
        type(l) == "table" and form.kind(l) and "a " .. form.kind(l) or check.describe(l))
    end
    list[i] = describe(l)
    list[i].light = l
    if form.kind(l) == "sphere_light" and not (l.radius > 0) then
      return check.fail("%s: light %d has the radius 0: it emits nothing, and has no derivatives", name, i)
    end
  end
  return list
end

--- Double [n][16] of such descriptions.
function lamps.rows(list)
  local rows = {}
  for i, l in ipairs(list) do
    rows[i] = { codes[l.opening], l.at[1], l.at[2], l.at[3], l.axis[1], l.axis[2], l.axis[3], l.across[1], l.across[2],
      l.across[3], l.half[1], l.half[2], l.scale[1], l.scale[2], l.scale[3], l.table }
  end
  if #rows == 0 then return array.zeros({ 0, 16 }, "double") end
  return array.array(rows, "double")
end

--- Derivatives by the direction of length 1 that a lamp looks in, and by its turn, degrees, from those by turns about x, y, z.
-- C0 stays where ylm.photometric_light has it: across +x, or +z of lamps that look along x.
function lamps.by_direction(l, turn)
  local a = l.axis
  local by_turn = -(turn[1] * a[1] + turn[2] * a[2] + turn[3] * a[3])
  local out = vector.cross(turn, a)
  if l.turn then
    local across, tilt = vector.across(a)
    local side = vector.cross(across, a)
    for i = 1, 3 do out[i] = out[i] - by_turn * tilt * side[i] end
  end
  return out, by_turn * math.pi / 180
end

--- Is a lamp's shadow one whose derivative by its place is known?
function lamps.has_rim(l) return l.opening ~= "point" end

return lamps
