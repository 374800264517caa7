-- Two rooms with a closed wall between them; 18 lamps hang in the left one, the right one is dark.
--
--     ylm render examples/scenes/two_rooms.lua -o two_rooms.exr
--
-- The front is open, for the camera alone: every straight line from a lamp into the right room meets the wall.
-- Shading by SH transfer (--visibility transfer) lets the light pass it; docs/math.md, "Shading", says why and by how much.
-- Metres, degrees, W sr^-1 m^-2; y is up.

local plaster = matte { albedo = { 0.74, 0.72, 0.68 } }
local boards  = matte { albedo = { 0.55, 0.40, 0.26 } }
local brick   = matte { albedo = { 0.62, 0.30, 0.20 } }
local glaze   = matte { albedo = { 0.45, 0.60, 0.66 } }

local width, height, depth, thick = 3.2, 2.6, 4, 0.2 -- of a room, and of the wall
local left, right = -thick / 2 - width, thick / 2 + width

local lamps = {}
for row = 0, 2 do
  for column = 0, 2 do
    for _, y in ipairs { 1.1, 1.8 } do
      lamps[#lamps + 1] = sphere_light { at = { -2.6 + column, y, -1.2 + 1.2 * row }, radius = 0.05,
                                         radiance = { 42, 33, 22 } }
    end
  end
end

--- Bodies that stand in both rooms, about their middle x.
local function furniture(x)
  return {
    box { bounds = { { x - 1.1, 0, -1.4 }, { x - 0.4, 0.7, -0.7 } }, divide = 24, material = brick },
    sphere { at = { x + 0.7, 0.45, 0.2 }, radius = 0.45, divide = 64, material = glaze },
  }
end

return scene "Two rooms" {
  camera   = camera { from = { 0, 1.45, 8.2 }, at = { 0, 1.2, 0 }, fov = 36 },
  geometry = {
    quad { corner = { left, 0, depth / 2 }, u = { right - left, 0, 0 }, v = { 0, 0, -depth }, divide = 96, material = boards },
    quad { corner = { left, height, -depth / 2 }, u = { right - left, 0, 0 }, v = { 0, 0, depth }, divide = 96,
           material = plaster },
    quad { corner = { left, 0, -depth / 2 }, u = { right - left, 0, 0 }, v = { 0, height, 0 }, divide = 96, material = plaster },
    quad { corner = { left, 0, depth / 2 }, u = { 0, 0, -depth }, v = { 0, height, 0 }, divide = 48, material = plaster },
    quad { corner = { right, 0, -depth / 2 }, u = { 0, 0, depth }, v = { 0, height, 0 }, divide = 48, material = plaster },
    box { bounds = { { -thick / 2, 0, -depth / 2 }, { thick / 2, height, depth / 2 } }, divide = 48, material = plaster },
    furniture(left + width / 2), furniture(right - width / 2),
  },
  lights   = lamps,
  probes   = adaptive_grid { lmax = 4, depth = 7, tolerance = 0.02 },
}
