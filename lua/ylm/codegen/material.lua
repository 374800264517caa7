--- Reflection by materials, once for C (csrc/material/gen/material.h) and once for GLSL (shaders/gen/material.glsl).

local common = require "ylm.codegen.common"

local material = {}

material.functions = {
  { about = "Radiance of a matte surface from what its transfer vector and the light's coefficients make.", text = [[
float matte_radiance(float product, float albedo) { return product * (0.31830988618379067f * albedo); }]] },
}

--- The file's text in a language of common.lua.
function material.text(name)
  return common.text(name, "material", { "What materials make of light, one function a kind." }, material.functions)
end

return material
