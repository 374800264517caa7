--- Two rooms of one mesh, their floors in one plane, parted by a wall of a thickness that stands at an angle: parted(ylm, at,
-- thick, slope) -> scene. The room towards -x has no lamp.

return function(ylm, at, thick, slope)
  local vertices, triangles = {}, {}
  local function prism(x) -- x[1], x[2] at z = -1, x[3], x[4] at z = 1
    local first = #vertices
    for _, y in ipairs { -1, 1 } do
      for k, z in ipairs { -1, -1, 1, 1 } do vertices[#vertices + 1] = { x[k], y, z } end
    end
    for _, q in ipairs { { 1, 3, 4, 2 }, { 5, 6, 8, 7 }, { 1, 2, 6, 5 }, { 3, 7, 8, 4 }, { 1, 5, 7, 3 }, { 2, 4, 8, 6 } } do
      triangles[#triangles + 1] = { first + q[1], first + q[2], first + q[3] }
      triangles[#triangles + 1] = { first + q[1], first + q[3], first + q[4] }
    end
  end
  prism { -1, at - slope, -1, at + slope }
  prism { at - slope + thick, 1, at + slope + thick, 1 }
  return ylm.scene "parted" { lights = ylm.sphere_light { at = { 0.75, 0.4, 0 }, radius = 0.1, radiance = 40 },
    geometry = ylm.mesh { vertices = vertices, triangles = triangles, crease = 30, sides = "both",
      material = ylm.matte { albedo = 0.5 } } }
end
