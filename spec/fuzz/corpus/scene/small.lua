return scene "a" {
  camera = camera { from = { 0, 2, 5 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 40 },
  geometry = { mesh { file = "a.obj", material = matte { albedo = 0.5 } }, box { size = { 1, 1, 1 } } },
  lights = { sphere_light { at = { 0, 3, 0 }, radius = 0.5, radiance = { 1, 1, 1 } } },
  probes = uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 4, cells = { 4, 4, 4 } },
}
