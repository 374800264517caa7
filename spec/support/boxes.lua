--- Boxes that turn, and rays to them, for benches of shadows.

local boxes = {}

--- Nine numbers, row by row, of a quaternion.
function boxes.matrix(q)
  local a, b, c, d = q[1], q[2], q[3], q[4]
  local s = 2 / (a * a + b * b + c * c + d * d)
  return { 1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c), s * (b * c + a * d), 1 - s * (b * b + d * d),
    s * (c * d - a * b), s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c) }
end

--- Does a ray from p along w meet the box of half sizes h, of a body at `at` turned by the matrix r?
function boxes.meets(h, at, r, p, w)
  local from, to = 0, math.huge
  for k = 1, 3 do
    local o = r[k] * (p[1] - at[1]) + r[3 + k] * (p[2] - at[2]) + r[6 + k] * (p[3] - at[3])
    local along = r[k] * w[1] + r[3 + k] * w[2] + r[6 + k] * w[3]
    local a, b = (-h[k] - o) / along, (h[k] - o) / along
    from, to = math.max(from, math.min(a, b)), math.min(to, math.max(a, b))
  end
  return from < to
end

--- side^2 directions about z, as many for each cosine.
function boxes.rays(side)
  local rays = {}
  for i = 0, side - 1 do
    for j = 0, side - 1 do
      local u, phi = (i + 0.5) / side, 2 * math.pi * (j + 0.5) / side
      rays[#rays + 1] = { math.sqrt(u) * math.cos(phi), math.sqrt(u) * math.sin(phi), math.sqrt(1 - u) }
    end
  end
  return rays
end

return boxes
