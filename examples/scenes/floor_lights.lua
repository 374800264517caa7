-- A knot over a floor at night, lit by 2516 small lamps in a phyllotaxis spiral.
--
--     ylm render examples/scenes/floor_lights.lua -o floor_lights.exr
--
-- Lamp k of the spiral (Vogel 1979) stands k golden angles round, at a distance that grows with the root
-- of k. Three of four float as a canopy over the knot, the others are lanterns above the floor. Every
-- 37th lamp has sunk until it nearly touches the floor. Metres, degrees, W sr^-1 m^-2; y is up.

local count, golden = 2516, math.pi * (3 - math.sqrt(5))
local night  = matte { albedo = { 0.55, 0.55, 0.58 } }
local copper = matte { albedo = { 0.74, 0.70, 0.66 } }

-- From amber over rose and violet to blue as t goes from 0 to 1.
local palette = { { 1, 0.60, 0.22 }, { 1, 0.34, 0.30 }, { 0.72, 0.26, 0.85 }, { 0.20, 0.42, 1 }, { 0.14, 0.72, 1 } }
local function colour(t)
  local x = t * (#palette - 1)
  local i = math.min(math.floor(x), #palette - 2)
  local a, b, c = palette[i + 1], palette[i + 2], {}
  for k = 1, 3 do c[k] = a[k] + (b[k] - a[k]) * (x - i) end
  return c
end

local lamps = {}
for k = 1, count do
  local t = k / count
  local r = 5.0 * math.sqrt(t)
  local height, radius, power = 3.15 - 0.9 * t + 0.10 * math.sin(7 * k * golden), 0.030, 2.4
  if k % 37 == 0 and r > 1.2 then height, radius, power = 0.05, 0.034, 8
  elseif k % 4 == 0 and r > 1.4 then height, radius, power = 0.28 + 0.08 * math.sin(3 * k * golden), 0.026, 3.6 end
  local c = colour(math.sqrt(t))
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
