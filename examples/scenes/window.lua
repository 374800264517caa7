-- A stained glass window, a textured light of 48 by 64 texels: its colours on the floor, on a wall and on a knot.
--
--     ylm render examples/scenes/window.lua --visibility transfer -o window.exr
--     ylm render examples/scenes/window.lua --light-samples 128 -o rays.exr
--
-- Metres, degrees, W sr^-1 m^-2; y is up.

local lead, red, gold, blue, green = { 0, 0, 0 }, { 1.4, 0.05, 0.03 }, { 1.4, 0.8, 0.1 }, { 0.06, 0.2, 1.5 },
  { 0.06, 0.8, 0.15 }
local sky = { 0.18, 0.3, 0.5 }

--- The colour of the glass at (x, y), from -1 to 1: a rose over two lancets.
local function glass(x, y)
  local r, turn = math.sqrt(0.64 * x * x + (y - 0.32) ^ 2), 4 * math.atan2(y - 0.32, 0.8 * x) / math.pi
  if math.abs(x) > 0.94 or math.abs(y) > 0.95 then return lead end
  if r < 0.15 then return gold end
  if r < 0.58 then
    if turn % 1 < 0.08 or r < 0.19 or r > 0.54 then return lead end
    return turn % 2 < 1 and red or blue
  end
  if y > -0.24 then return r < 0.62 and lead or sky end
  if y > -0.3 or math.abs(x) < 0.04 then return lead end
  return x < 0 and green or gold
end

local rows = {}
for j = 1, 64 do
  rows[j] = {}
  for i = 1, 48 do rows[j][i] = glass((2 * i - 49) / 48, (65 - 2 * j) / 64) end
end

local stone = matte { albedo = { 0.75, 0.72, 0.66 } }

return scene "Window" {
  camera   = camera { from = { 2.4, 1.9, 3.4 }, at = { -0.2, 1.05, -0.6 }, fov = 44 },
  geometry = {
    quad { corner = { -2, 0, 2.5 }, u = { 4.5, 0, 0 }, v = { 0, 0, -4 }, divide = 96, material = stone },
    quad { corner = { -2, 0, -1.5 }, u = { 4.5, 0, 0 }, v = { 0, 3, 0 }, divide = 96, material = stone },
    quad { corner = { -2, 0, 2.5 }, u = { 0, 0, -4 }, v = { 0, 3, 0 }, divide = 96, material = stone },
    knot { at = { 1.35, 0.62, -0.55 }, radius = 0.36, minor = 0.18, tube = 0.1, divide = { 400, 32 },
           material = matte { albedo = 0.85 } },
  },
  lights   = textured_light { corner = { -1.2, 0.3, -1.45 }, u = { 2, 0, 0 }, v = { 0, 2.5, 0 }, image = rows, scale = 2,
                              method = "exact" },
  probes   = adaptive_grid { lmax = 6, depth = 6, tolerance = 0.03 },
}
