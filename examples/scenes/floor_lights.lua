-- A knot over a floor at night, lit by 2516 small lamps in a phyllotaxis spiral.
--
--     ylm render examples/scenes/floor_lights.lua -o floor_lights.exr
--
-- Lamp k of the spiral (Vogel 1979) stands k golden angles round, at a distance that grows with the root
-- of k. Three of four float as a canopy over the knot, the others are lanterns above the floor, and every
-- 37th has sunk until it nearly touches the floor. Metres, degrees, W sr^-1 m^-2; y is up.

local count, golden = 2516, math.pi * (3 - math.sqrt(5))
local night  = matte { albedo = { 0.55, 0.55, 0.58 } }
local copper = matte { albedo = { 0.74, 0.70, 0.66 } }

-- A hue of 0 .. 1 as a soft colour: three cosines a third of a turn apart.
local function hue(t)
  local function band(shift) return 0.5 + 0.48 * math.cos(2 * math.pi * (t - shift)) end
  return { band(0.02), band(0.30), band(0.62) }
end

local lamps = {}
for k = 1, count do
  local t = k / count
  local r = 5.0 * math.sqrt(t)
  local height, radius, power = 3.15 - 0.9 * t + 0.10 * math.sin(7 * k * golden), 0.022, 4.2
  if k % 37 == 0 and r > 1.2 then height, radius, power = 0.055, 0.032, 12
  elseif k % 4 == 0 and r > 1.4 then height, radius, power = 0.28 + 0.08 * math.sin(3 * k * golden), 0.022, 5 end
  local c = hue(0.04 + 0.70 * t)
  lamps[k] = sphere_light {
    at       = { r * math.cos(k * golden), height, r * math.sin(k * golden) },
    radius   = radius,
    radiance = { power * c[1], power * c[2], power * c[3] },
  }
end

return scene "Floor lights" {
  camera   = camera { from = { 3.9, 1.85, 5.4 }, at = { 0, 1.15, 0 }, fov = 48 },
  geometry = {
    quad { corner = { -5.5, 0, 5.5 }, u = { 11, 0, 0 }, v = { 0, 0, -11 }, divide = 128, material = night },
    knot { at = { 0, 1.25, 0 }, p = 2, q = 3, radius = 0.75, minor = 0.38, tube = 0.21, divide = { 1400, 110 },
           material = copper },
  },
  lights   = lamps,
  probes   = adaptive_grid { lmax = 4, depth = 9, tolerance = 0.01 },
}
