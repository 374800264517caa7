--- Materials: data only, no scene knows them and they know no scene.

local form = require "ylm.form"

local material = {}

material.matte = form.define("matte", {
  about = "A matte (Lambertian) surface: light leaves it alike in every direction.",
  fields = {
    { "albedo", "colour", min = 0, max = 1, default = 0.5,
      about = "reflected over incident flux, a number or linear Rec. 709 {r, g, b}" },
  },
  example = "matte { albedo = { 0.63, 0.06, 0.05 } }",
})

--- The material of geometry that names none.
material.default = material.matte {}

return material
