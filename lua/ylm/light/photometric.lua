--- Lamps with a photometric table: ylm.photometric_light.

local check = require "ylm.check"
local colours = require "ylm.photometry.colour"
local core = require "ylm.c.core"
local form = require "ylm.form"
local pack = require "ylm.light.pack"
local photometry = require "ylm.photometry"
local vector = require "ylm.vector"

local photometric = {}

local POINT = 0.05 -- scene units: the radius of a point that has a light field

--- Codes of csrc/light/photometric/lamp.h.
local codes = { sphere = 0, disk = 1, rectangle = 2 }

--- Shape and half sizes of the opening; notes about it go to a list.
local function opening_of(values, notes, fail)
  local shape, size
  if values.opening == "point" then return "point", { 0, 0 } end
  if values.opening == "auto" then
    local facts = core.owned(values.photometry, "facts")
    shape, size = facts.opening, facts.size
    if shape == "point" then
      notes[#notes + 1] = ("the file's point is taken as a sphere of radius %g"):format(POINT)
      return "sphere", { POINT, POINT }
    end
  elseif type(values.opening) == "table" then
    shape, size = photometry.opening("opening", values.opening, fail)
    if shape == "point" then return "point", { 0, 0 } end
  else
    return fail(("opening must be 'auto', 'point' or { shape =, radius = | size = }, got %s"):format(
      check.describe(values.opening)))
  end
  return shape, { size[1] / 2, size[2] / 2 }
end

--- The direction of C0: +x, or +z of a lamp that looks along x, across the axis, turned towards C90.
local function across_of(axis, turn)
  local a = vector.across(axis)
  local side, c, s = vector.cross(a, axis), math.cos(math.rad(turn)), math.sin(math.rad(turn))
  return { c * a[1] + s * side[1], c * a[2] + s * side[2], c * a[3] + s * side[3] }
end

--- The turn, degrees, of a lamp with this axis whose C0 looks across it, both of length 1.
function photometric.turn_of(axis, across)
  local a = vector.across(axis)
  local side = vector.cross(a, axis)
  local function along(b) return across[1] * b[1] + across[2] * b[2] + across[3] * b[3] end
  return math.deg((math.atan2 or math.atan)(along(side), along(a))) -- luacheck: ignore 143
end

--- The colour of luminance 1.
local function colour_of(values, notes, fail)
  if values.colour and values.temperature then return fail "give colour or temperature, not both" end
  if values.temperature then
    local rgb, clipped = colours.of_temperature(values.temperature)
    if clipped then
      notes[#notes + 1] = ("light of %g K is beyond Rec. 709: its negative channel is 0"):format(values.temperature)
    end
    return rgb
  end
  if not values.colour then return { 1, 1, 1 } end
  return colours.of_luminance_one(values.colour) or fail "colour must not be black"
end

local function build(values, fail)
  local notes = {}
  local shape, half = opening_of(values, notes, fail)
  local to = values.to or { values.at[1], values.at[2] - 1, values.at[3] }
  local way = { to[1] - values.at[1], to[2] - values.at[2], to[3] - values.at[3] }
  local length = vector.length(way)
  if not (length > 0 and length < math.huge) then return fail "at and to are the same" end
  local axis = vector.unit(way)
  local rgb, scale = colour_of(values, notes, fail), values.dim / (values.efficacy or 1)
  values.shape, values.half, values.axis, values.across = shape, half, axis, across_of(axis, values.turn)
  values.scale = { scale * rgb[1], scale * rgb[2], scale * rgb[3] }
  values.rgb = rgb
  values.lumens = values.dim * values.photometry.lumens
  values.photometric = not values.efficacy
  values.notes = #notes > 0 and notes or nil
  return pack.finish("photometric_light", values, fail)
end

photometric.photometric_light = form.define("photometric_light", {
  shelf = "everyday",
  numbers = 256,
  about = "A lamp whose intensity by direction is a photometry's: a file of its maker. Its opening sends that intensity, spread "
    .. "evenly over its area: far away it is the file, near by the opening. Its numbers are lm and cd: results are lx and "
    .. "cd/m^2, and all lamps of a scene are to be photometric. It has lumens, and notes.",
  fields = {
    { "photometry", "object", of = "photometry" },
    { "at", "point", unit = "scene units", about = "the middle of the opening, m for sizes of files" },
    { "to", "point", optional = true, unit = "scene units",
      about = "a place on its axis, gamma = 0; default: straight down, -y" },
    { "turn", "number", min = -360, max = 360, default = 0, unit = "degrees",
      about = "about the axis, from C0 towards C90; at 0 C0 looks along +x, +z where the axis does" },
    { "dim", "number", min = 0, max = 1e6, default = 1, about = "multiplies" },
    { "colour", "colour", min = 0, optional = true, about = "linear Rec. 709, scaled to luminance 1; default white" },
    { "temperature", "number", min = 1000, max = 25000, optional = true, unit = "K",
      about = "colour of a black body, from 4000 of daylight" },
    { "opening", "any", default = "auto",
      about = "auto: the file's; { shape = 'sphere' | 'disk', radius = }, { shape = 'rectangle', size = { along C0, along "
        .. "C90 } }; point: no size and no light field, rays find it" },
    { "efficacy", "number", above = 0, max = 683, optional = true, unit = "lm/W",
      about = "takes the lamp into a scene of W: lumens are divided by it" },
    { "name", "string", optional = true },
  },
  build = build,
  light = {
    kind = function(l) return l.shape == "point" and "photometric_point" or "photometric" end,
    record = function(l, out)
      pack.append(out, l.scale)
      out[#out + 1] = core.owned(l.photometry, "facts").name
      out[#out + 1] = codes[l.shape] or 0
      pack.append(out, l.at, l.axis, l.across)
      out[#out + 1], out[#out + 2] = l.half[1], l.half[2]
    end,
    photometric = true,
  },
  example = [[
photometric_light { photometry = photometry { cosine = 1, lumens = 3600 }, at = { 0, 2.8, 0 }, temperature = 4000 }]],
})

return photometric
