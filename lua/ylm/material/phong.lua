--- Phong's lobe about the mirror direction.

local form = require "ylm.form"
local object = require "ylm.material.object"

local phong = form.define("phong", {
  about = "A matte base and a lobe about the mirror direction (Lafortune & Willems 1994); base + specular is at most 1.",
  fields = {
    { "exponent", "number", min = 0, max = 1e5, default = 40, about = "of the cosine from the mirror direction" },
    { "specular", "colour", min = 0, max = 1, default = 0.4, about = "reflected by the lobe along the normal" },
    { "base", "colour", min = 0, max = 1, default = 0.3, about = "albedo of the matte part" },
  },
  material = function(m)
    local s, b = m.specular, m.base
    return { m.exponent, s[1], s[2], s[3], b[1], b[2], b[3] }
  end,
  numbers = 64,
  metatable = object.metatable(),
  build = object.builder "phong",
  example = "phong { exponent = 100, specular = 0.4, base = { 0.3, 0.1, 0.05 } }",
})

return phong
