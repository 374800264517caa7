--- Materials of every kind, each a row that spec/material_kinds_spec.lua asks the same questions:
-- { name, material, reciprocity = largest relative difference (1e-4), energy = largest albedo (1), integral =
-- what the coarse quadrature of the spec makes of sharp lobes (2e-3) }.

return function(ylm)
  return {
    { "matte", ylm.matte { albedo = { 0.9, 0.5, 0 } } },
    { "ggx, rough", ylm.ggx { alpha = 1, f0 = { 1, 0.5, 0.04 }, compensate = false } },
    { "ggx, smooth", ylm.ggx { alpha = 0.12, f0 = 0.9, compensate = false } },
    { "ggx, compensated", ylm.ggx { alpha = 0.6, f0 = { 1, 0.78, 0.34 } } },
    { "ggx over a base", ylm.ggx { alpha = 0.3, f0 = 0.04, base = { 0.8, 0.4, 0.1 } } },
    { "ggx, anisotropic", ylm.ggx { alpha = { 0.12, 0.5 }, f0 = 0.8, compensate = false }, integral = 6e-3 },
    { "phong", ylm.phong { exponent = 30, specular = { 0.6, 0.3, 0 }, base = { 0.4, 0.2, 0.1 } } },
    { "phong, a lobe of all", ylm.phong { exponent = 1, specular = 1, base = 0 } },
    { "abc, metallic paint", ylm.abc { fit = "gold-metallic-paint" } },
    { "abc, white paint", ylm.abc { fit = "white-diffuse-bball" } },
  }
end
