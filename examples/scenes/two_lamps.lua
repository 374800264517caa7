-- Two lamps standing on the floor of a room, remembered by an adaptive grid.
--
--     ylm render examples/scenes/two_lamps.lua --visibility transfer -o two_lamps.exr
--
-- The arrangement of Iwasaki & Dobashi 2025, Fig. 6, with plain furniture. The walls do not occlude: a
-- ray that leaves a closed room always meets one, also on its way past a lamp.
-- Metres, degrees, W sr^-1 m^-2; y is up.

local plaster = matte { albedo = { 0.74, 0.72, 0.68 } }
local oak     = matte { albedo = { 0.52, 0.36, 0.22 } }
local cloth   = matte { albedo = { 0.22, 0.34, 0.46 } }
local red     = matte { albedo = { 0.63, 0.10, 0.07 } }
local pewter  = matte { albedo = { 0.60, 0.60, 0.62 } }

-- A box by its centre and edges.
local function block(at, size, divide, material)
  local lo, hi = {}, {}
  for i = 1, 3 do lo[i], hi[i] = at[i] - size[i] / 2, at[i] + size[i] / 2 end
  return box { bounds = { lo, hi }, divide = divide, material = material }
end

local function table_at(x, z)
  local parts = { block({ x, 0.44, z }, { 1.1, 0.05, 0.65 }, 24, oak) }
  for _, dx in ipairs { -0.48, 0.48 } do
    for _, dz in ipairs { -0.26, 0.26 } do
      parts[#parts + 1] = block({ x + dx, 0.21, z + dz }, { 0.06, 0.42, 0.06 }, 12, oak)
    end
  end
  return parts
end

return scene "Two lamps" {
  camera   = camera { from = { 2.9, 1.75, 3.4 }, at = { -0.15, 0.55, -0.1 }, fov = 44 },
  geometry = {
    quad { corner = { -2.5, 0, 2.5 }, u = { 5, 0, 0 }, v = { 0, 0, -5 }, divide = 256, material = oak },
    quad { corner = { -2.5, 0, -2.5 }, u = { 5, 0, 0 }, v = { 0, 2.6, 0 }, divide = 160, material = plaster,
           occludes = false },
    quad { corner = { -2.5, 0, 2.5 }, u = { 0, 0, -5 }, v = { 0, 2.6, 0 }, divide = 160, material = plaster,
           occludes = false },
    -- a couch along the back wall
    block({ -0.6, 0.21, -1.95 }, { 2.2, 0.42, 0.85 }, 48, cloth),
    block({ -0.6, 0.60, -2.29 }, { 2.2, 0.50, 0.18 }, 48, cloth),
    table_at(0, 0),
    torus { at = { 0.0, 0.63, 0.0 }, radius = 0.22, tube = 0.07, rotate = { axis = { 1, 0, 0 }, angle = 65 },
            divide = { 160, 60 }, material = red },
    sphere { at = { -1.75, 0.35, 0.9 }, radius = 0.35, divide = 96, material = pewter },
    knot { at = { 1.35, 0.45, -1.25 }, p = 2, q = 3, radius = 0.24, minor = 0.12, tube = 0.06,
           divide = { 480, 40 }, material = pewter },
  },
  lights   = {
    sphere_light { at = { -0.95, 0.10, 1.00 }, radius = 0.08, radiance = { 60, 42, 24 } },
    sphere_light { at = {  1.30, 0.10, 0.35 }, radius = 0.08, radiance = { 26, 38, 60 } },
  },
  probes   = adaptive_grid { lmax = 4, depth = 6, metric = "absolute", threshold = 0.15 },
}
