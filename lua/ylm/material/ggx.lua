--- Surfaces of GGX microfacets: metals, and coats over a base.

local form = require "ylm.form"
local object = require "ylm.material.object"

function form.types.roughness(x, field)
  if type(x) == "table" and getmetatable(x) == nil and #x == 2 then
    local a, b = form.types.number(x[1], field), form.types.number(x[2], field)
    if a and b then return { a, b } end
  elseif form.types.number(x, field) then return { x, x } end
  return nil, ("a number from %g to %g, or two of them: along the tangent and across it"):format(field.min, field.max)
end

local ggx = form.define("ggx", {
  shelf = "everyday",
  about = "A surface of GGX microfacets, height-correlated, with Schlick's Fresnel term; a base shines through it.",
  fields = {
    { "alpha", "roughness", min = 1e-3, max = 1, default = 0.3,
      about = "roughness; two numbers: along the direction in which texture coordinates u grow, and across it" },
    { "f0", "colour", min = 0, max = 1, default = 0.9, about = "reflected along the normal, linear Rec. 709" },
    { "base", "colour", min = 0, max = 1, default = 0, about = "albedo of what lies below; the sum stays reciprocal" },
    { "compensate", "boolean", default = true,
      about = "whether light that is lost between microfacets comes back: with f0 = 1 all light is reflected" },
  },
  material = function(m)
    local f, b = m.f0, m.base
    return { m.alpha[1], m.alpha[2], f[1], f[2], f[3], b[1], b[2], b[3], m.compensate and 1 or 0 }
  end,
  numbers = 640,
  directed = "alpha = {a, b}",
  metatable = object.metatable(),
  build = object.builder "ggx",
  example = "ggx { alpha = 0.3, f0 = { 1, 0.78, 0.34 } }",
})

return ggx
