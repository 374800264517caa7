--- Scenes of few elements, and sums over elements, for specs of light that bounces.

local ylm = require "ylm"

local elements = {}

local pi = math.pi

--- A part of a sphere of radius 1 about 0, seen from inside, out to the polar angle g from -z.
function elements.bowl(g, rings, albedo)
  local around, vertices, triangles = 2 * rings, {}, {}
  for k = 0, rings do
    local t = g * k / rings
    for i = 0, around - 1 do
      local u = 2 * pi * i / around
      vertices[#vertices + 1] = { math.sin(t) * math.cos(u), math.sin(t) * math.sin(u), -math.cos(t) }
    end
  end
  for k = 0, rings - 1 do
    for i = 0, around - 1 do
      local a, b = k * around + i + 1, k * around + (i + 1) % around + 1
      triangles[#triangles + 1] = { a, a + around, b + around }
      if k > 0 then triangles[#triangles + 1] = { a, b + around, b } end
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, material = ylm.matte { albedo = albedo }, sides = "front" }
end

--- A room of six quads, 2 x 2 x 2 about (0, 1, 0), that look inwards; `more` geometry and lights.
function elements.room(albedo, more, lights)
  local m = ylm.matte { albedo = albedo }
  local function wall(corner, u, v) return ylm.quad { corner = corner, u = u, v = v, material = m } end
  return ylm.scene "a room" {
    geometry = {
      wall({ -1, 0, 1 }, { 2, 0, 0 }, { 0, 0, -2 }), wall({ -1, 2, -1 }, { 2, 0, 0 }, { 0, 0, 2 }),
      wall({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }), wall({ 1, 0, 1 }, { -2, 0, 0 }, { 0, 2, 0 }),
      wall({ -1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }), wall({ 1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }), more or {},
    },
    lights = lights or ylm.sphere_light { at = { 0, 1.6, 0 }, radius = 0.1, radiance = 10 },
  }
end

--- Sum over elements of their area, times channel c of `values` [n][3] where given; of mesh `of` alone where given.
function elements.integral(e, values, c, of)
  local sum = 0
  for i = 1, #e.area do
    if not of or e.mesh:get(i) == of then sum = sum + e.area:get(i) * (values and values:get(i, c) or 1) end
  end
  return sum
end

--- The mean of channel c of `values` by area.
function elements.mean(e, values, c, of)
  return elements.integral(e, values, c, of) / elements.integral(e, nil, nil, of)
end

return elements
