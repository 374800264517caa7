--- Every generated file of the tree: { path, module, argument }, one line each.
-- `module` returns a function(argument) -> text, or a table with such a function `text`.
-- `make gen` writes them, `make gen-check` compares.

local targets = {}

for _, form in ipairs { "plain", "stable" } do
  targets[#targets + 1] = { "csrc/sh/gen/sh_" .. form .. ".h", "ylm.codegen.sh_low", form }
end
targets[#targets + 1] = { "csrc/sh/gen/sh_table.h", "ylm.codegen.sh_table", 24 }
for lmax = 0, 10 do
  local path = "csrc/light/moments/gen/moments_" .. lmax
  targets[#targets + 1] = { path .. ".h", "ylm.codegen.moments", { lmax } }
  for _, dtype in ipairs { "float", "double" } do
    targets[#targets + 1] = { path .. "_" .. dtype .. ".isa.c", "ylm.codegen.moments", { lmax, dtype } }
  end
end
targets[#targets + 1] = { "csrc/light/virtual/gen/degrees.h", "ylm.codegen.virtual" }
for _, dtype in ipairs { "float", "double" } do
  targets[#targets + 1] = { "csrc/light/virtual/gen/straight_" .. dtype .. ".isa.c", "ylm.codegen.virtual", dtype }
end
targets[#targets + 1] = { "csrc/light/flat/gen/gauss.c", "ylm.codegen.gauss" }
targets[#targets + 1] = { "csrc/rival/gen/polynomial.h", "ylm.codegen.polynomial", 6 }
targets[#targets + 1] = { "csrc/sh/gen/rotate_quarters.h", "ylm.codegen.rotate" }
targets[#targets + 1] = { "csrc/sh/gen/gaunt_low.h", "ylm.codegen.gaunt" }
targets[#targets + 1] = { "shaders/gen/sh.glsl", "ylm.codegen.sh_shader", { lmax = 4, solid = false } }
targets[#targets + 1] = { "shaders/gen/sh_solid.glsl", "ylm.codegen.sh_shader", { lmax = 4, solid = true } }

targets[#targets + 1] = { "shaders/gen/recurrence.glsl", "ylm.codegen.recurrence", "shader" }
targets[#targets + 1] = { "csrc/sh/gen/recurrence.h", "ylm.codegen.recurrence", "lanes" }

targets[#targets + 1] = { "shaders/gen/light.glsl", "ylm.codegen.light", "shader" }
targets[#targets + 1] = { "csrc/light/moments/gen/light.h", "ylm.codegen.light", "lanes" }
targets[#targets + 1] = { "csrc/light/moments/gen/recurrences.h", "ylm.codegen.light", "macros" }

targets[#targets + 1] = { "shaders/gen/jet.glsl", "ylm.codegen.jet", "shader" }
targets[#targets + 1] = { "csrc/light/flat/gen/jet.h", "ylm.codegen.jet", "double" }

targets[#targets + 1] = { "shaders/gen/crossing.glsl", "ylm.codegen.crossing", "double_shader" }
targets[#targets + 1] = { "csrc/light/flat/gen/crossing.h", "ylm.codegen.crossing", "c" }
targets[#targets + 1] = { "shaders/gen/compensation.glsl", "ylm.codegen.compensation", "shader" }
targets[#targets + 1] = { "csrc/light/moments/gen/compensation.h", "ylm.codegen.compensation", "kernel" }
targets[#targets + 1] = { "shaders/gen/cells.glsl", "ylm.codegen.cells", "shader" }
targets[#targets + 1] = { "csrc/grid/gen/cells.h", "ylm.codegen.cells", "c" }
targets[#targets + 1] = { "shaders/gen/layout.glsl", "ylm.codegen.layout", "shader" }
targets[#targets + 1] = { "csrc/vulkan/gen/layout.h", "ylm.codegen.layout", "c" }
targets[#targets + 1] = { "shaders/gen/material.glsl", "ylm.codegen.material", "shader" }
targets[#targets + 1] = { "csrc/material/gen/material.h", "ylm.codegen.material", "c" }
targets[#targets + 1] = { "csrc/material/gen/albedo.c", "ylm.codegen.albedo" }
targets[#targets + 1] = { "shaders/gen/picture.glsl", "ylm.codegen.picture", "shader" }
targets[#targets + 1] = { "csrc/shade/gen/picture.h", "ylm.codegen.picture", "c" }
targets[#targets + 1] = { "shaders/gen/rim.glsl", "ylm.codegen.rim", "shader" }
targets[#targets + 1] = { "csrc/light/flat/gen/rim.h", "ylm.codegen.rim", "kernel" }

targets[#targets + 1] = { "shaders/gen/eigenvalue.glsl", "ylm.codegen.eigenvalue", "glsl" }
targets[#targets + 1] = { "csrc/light/moments/gen/eigenvalue.h", "ylm.codegen.eigenvalue", "c" }
targets[#targets + 1] = { "shaders/gen/interpolation.glsl", "ylm.codegen.interpolation", "glsl" }
targets[#targets + 1] = { "csrc/grid/gen/interpolation.h", "ylm.codegen.interpolation", "element" }
targets[#targets + 1] = { "shaders/gen/moments.glsl", "ylm.codegen.moments_glsl", 10 }
targets[#targets + 1] = { "shaders/gen/product.glsl", "ylm.codegen.product_glsl", 8 }
for _, language in ipairs { "glsl", "hlsl", "wgsl" } do
  targets[#targets + 1] = { "shaders/gen/probes." .. language, "ylm.codegen.probes", language }
end
targets[#targets + 1] = { "package/three/shader.js", "ylm.codegen.probes", "js" }
targets[#targets + 1] = { "package/three/probes.js", "ylm.codegen.probes", "reader" }
targets[#targets + 1] = { "lua/ylm/page/gen/probes.lua", "ylm.codegen.probes", "lua" }
targets[#targets + 1] = { "lua/ylm/page/gen/functions.lua", "ylm.codegen.page", 8 }

return targets
