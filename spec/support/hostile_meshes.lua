--- Meshes that are no solid bodies, each within a box of edge 1 about the origin: name -> { vertices, triangles }; and
-- cluster(n): n triangles at random within a cube of edge 0.1.

local random = require "spec.support.random"

local meshes = {}

local quad = { { -0.5, 0, -0.5 }, { 0.5, 0, -0.5 }, { 0.5, 0, 0.5 }, { -0.5, 0, 0.5 } }

meshes.hole = { vertices = quad, triangles = { { 1, 3, 2 } } }
meshes.twice = { vertices = quad, triangles = { { 1, 2, 3 }, { 1, 3, 4 }, { 1, 2, 3 }, { 3, 2, 1 }, { 1, 2, 4 } } }
meshes.point = { vertices = { { 0, 0, 0 }, { 0, 0, 0 }, { 0.5, 0, 0 }, { 0.25, 0, 0 } },
  triangles = { { 1, 1, 1 }, { 1, 2, 3 }, { 1, 3, 4 } } }
meshes["inside out"] = { vertices = { { -0.5, -0.5, -0.5 }, { 0.5, -0.4, -0.4 }, { 0, 0.5, -0.4 }, { 0, 0, 0.5 } },
  triangles = { { 1, 2, 3 }, { 1, 4, 2 }, { 2, 4, 3 }, { 3, 4, 1 } } }

local needles = { vertices = {}, triangles = {} }
for i = 0, 60 do
  needles.vertices[2 * i + 1], needles.vertices[2 * i + 2] = { i / 60 - 0.5, 0, -0.5 }, { i / 60 - 0.5, 1e-4, 0.5 }
  if i > 0 then
    needles.triangles[2 * i - 1], needles.triangles[2 * i] = { 2 * i - 1, 2 * i, 2 * i + 1 }, { 2 * i, 2 * i + 2, 2 * i + 1 }
  end
end
needles.vertices[#needles.vertices + 1] = { 0, 1e-7, 0 }
needles.triangles[#needles.triangles + 1] = { 1, 121, #needles.vertices }
meshes.needles = needles

local fan = { vertices = { { 0, -0.5, 0 }, { 0, 0.5, 0 } }, triangles = {} }
for k = 0, 6 do
  fan.vertices[k + 3] = { 0.5 * math.cos(k), 0.4 - 0.1 * k, 0.5 * math.sin(k) }
  fan.triangles[k + 1] = { 1, 2, k + 3 }
end
meshes["non-manifold"] = fan

local function cluster(n)
  local draw, vertices, triangles = random.minimal(5), {}, {}
  for i = 1, n do
    local c = { 0.1 * draw() - 0.05, 0.1 * draw() - 0.05, 0.1 * draw() - 0.05 }
    for k = 1, 3 do
      vertices[3 * i - 3 + k] = { c[1] + 0.01 * draw() - 0.005, c[2] + 0.01 * draw() - 0.005, c[3] + 0.01 * draw() - 0.005 }
    end
    triangles[i] = { 3 * i - 2, 3 * i - 1, 3 * i }
  end
  return { vertices = vertices, triangles = triangles }
end

return { meshes = meshes, cluster = cluster }
