--- Matte surfaces.

local form = require "ylm.form"
local object = require "ylm.material.object"

local matte = form.define("matte", {
  about = "A matte (Lambertian) surface: light leaves it alike in every direction.",
  fields = {
    { "albedo", "colour", min = 0, max = 1, default = 0.5,
      about = "reflected over incident flux, a number or linear Rec. 709 {r, g, b}" },
  },
  material = function(m) return m.albedo end,
  metatable = object.metatable(),
  build = object.builder "matte",
  example = "matte { albedo = { 0.63, 0.06, 0.05 } }",
})

return matte
