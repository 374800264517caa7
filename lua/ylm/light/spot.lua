--- Spots: ylm.spot_light.

local form = require "ylm.form"
local pack = require "ylm.light.pack"

local spot = {}

spot.spot_light = form.define("spot_light", {
  shelf = "everyday",
  about = "A light of one place that shines into a cone. It has no size, and so no light field: rays find its light, in "
    .. "scene:render by rays and by paths; radiosity and scene:virtual_lights bounce it. It is not seen.",
  fields = {
    { "at", "point", unit = "scene units" },
    { "to", "point", unit = "scene units", about = "a place on the cone's axis" },
    { "angle", "number", above = 0, max = 360, default = 90, unit = "degrees", about = "of the whole cone" },
    { "blend", "number", min = 0, max = 1, default = 0.15,
      about = "the part of the angle, from its rim, over which light fades, as a smooth step of the cosine" },
    { "intensity", "colour", default = 1, unit = "W sr^-1",
      about = "within the cone: number or {r, g, b}, linear Rec. 709" },
    pack.photometric,
  },
  build = pack.build "spot_light",
  light = {
    kind = "spot",
    photometric = true,
    record = function(l, out)
      pack.append(out, l.intensity, l.at)
      for i = 1, 3 do out[#out + 1] = l.to[i] - l.at[i] end
      out[#out + 1] = l.angle
      out[#out + 1] = l.blend
    end,
    gltf = function(w, l)
      local c, outer = l.intensity, math.rad(l.angle / 2)
      if math.min(c[1], c[2], c[3]) < 0 or l.angle > 180 then
        return w:leave_out "spots of more than 180 degrees, or negative, left out"
      end
      -- Equal angles are refused by validators.
      local inner = math.min(outer * (1 - l.blend), outer * (1 - 1e-9))
      w:punctual { type = "spot", at = l.at, along = { l.to[1] - l.at[1], l.to[2] - l.at[2], l.to[3] - l.at[3] }, light = c,
        cone = { inner, outer }, extras = { "angle", l.angle, "blend", l.blend, "to", l.to, "intensity", c } }
    end,
  },
  example = "spot_light { at = {0, 3, 0}, to = {0, 0, 0}, angle = 60, intensity = {10, 8, 6} }",
})

return spot
