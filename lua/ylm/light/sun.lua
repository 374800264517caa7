--- Suns: ylm.sun_light.

local form = require "ylm.form"
local pack = require "ylm.light.pack"

local sun = {}

sun.sun_light = form.define("sun_light", {
  shelf = "everyday",
  about = "A disc of one radiance, infinitely far away: the same at every point, seen where nothing is hit.",
  fields = {
    { "direction", "vector", about = "towards the sun" },
    { "angle", "number", min = 0.001, max = 180, default = 0.53, unit = "degrees", about = "across the disc" },
    { "irradiance", "colour", default = 1, unit = "W m^-2",
      about = "on a surface that faces it: number or {r, g, b}, linear Rec. 709; may be negative" },
    pack.photometric,
  },
  build = pack.build "sun_light",
  light = {
    kind = "sun",
    photometric = true,
    record = function(l, out)
      pack.append(out, l.irradiance, l.direction)
      out[#out + 1] = l.angle
    end,
    gltf = function(w, l)
      local d = l.direction
      w:punctual { type = "directional", along = { -d[1], -d[2], -d[3] }, light = l.irradiance,
        extras = { "angle", l.angle, "direction", d, "irradiance", l.irradiance } }
    end,
  },
  example = "sun_light { direction = {1, 2, 0.5}, irradiance = {3, 2.9, 2.7} }",
})

return sun
