-- A room of matte walls with a matte box, two spheres of metal, a sphere lamp and a flat one.
--
--     ylm pathtrace examples/scenes/room.lua -o room.exr -n 256
--
-- Metres, degrees, W sr^-1 m^-2; y is up. spec/bench/cycles.py has the same room for Blender.

local white = matte { albedo = 0.75 }

return scene "Room" {
  camera   = camera { from = { 0, 1, 3.4 }, at = { 0, 1, 0 }, fov = 40 },
  geometry = {
    quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = white },
    quad { corner = { -1, 2, -1 }, u = { 2, 0, 0 }, v = { 0, 0, 2 }, material = white },
    quad { corner = { -1, 0, -1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, material = white },
    quad { corner = { -1, 0, 1 }, u = { 0, 0, -2 }, v = { 0, 2, 0 }, material = matte { albedo = { 0.6, 0.1, 0.08 } } },
    quad { corner = { 1, 0, -1 }, u = { 0, 0, 2 }, v = { 0, 2, 0 }, material = matte { albedo = { 0.1, 0.45, 0.12 } } },
    box { bounds = { { 0.2, 0, -0.5 }, { 0.7, 0.6, 0 } }, material = white },
    sphere { at = { -0.45, 0.4, -0.3 }, radius = 0.4, divide = { 192, 96 },
             material = ggx { alpha = 0.3, f0 = 1, compensate = false } },
    sphere { at = { 0.15, 0.2, 0.45 }, radius = 0.2, divide = { 192, 96 },
             material = ggx { alpha = 0.1, f0 = 1, compensate = false } },
  },
  lights   = {
    polygon_light { vertices = { { -0.35, 1.8, -0.35 }, { 0.35, 1.8, -0.35 }, { 0.35, 1.8, 0.35 }, { -0.35, 1.8, 0.35 } },
                    radiance = 8 },
    sphere_light { at = { -0.6, 1.2, 0.4 }, radius = 0.1, radiance = { 20, 14, 8 } },
  },
}
