--- A scene: a floor that does not fill the picture, a sphere over it, a lamp in sight, behind them a background; its probes
-- are of `o.channels`.

local ylm = require "ylm"

return function(o)
  return ylm.scene "floor" {
    camera = ylm.camera { from = { 0.2, 1.3, 2.4 }, at = { 0, 0.3, 0 }, fov = 55 },
    background = { 0.2, 0.1, 0.4 },
    geometry = {
      ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8,
        material = ylm.matte { albedo = { 0.7, 0.5, 0.3 } } },
      ylm.sphere { at = { 0, 0.35, 0 }, radius = 0.3, material = ylm.matte { albedo = 0.6 } },
    },
    lights = { ylm.sphere_light { at = { 0.7, 0.8, 0.4 }, radius = 0.1, radiance = { 20, 15, 10 } },
      ylm.sphere_light { at = { -0.9, 0.5, 0.2 }, radius = 0.05, radiance = { 10, 20, 40 } } },
    probes = ylm.adaptive_grid { lmax = 3, depth = 3, threshold = 2, channels = o and o.channels },
  }
end
