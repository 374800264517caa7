--- Judges texture coordinates that mesh:unwrap made: charts(flat, report) -> nil, or a sentence about what is wrong.
--
-- Independent of how they are made: pairs of triangles by separating lines, texels by bilinear look-ups at places drawn.

local SMALL = 2e-3 -- texels that coordinates of floats may be off by

--- The corners of all triangles in texels, and their charts.
local function corners(flat, report)
  local uvs, triangles, out = flat.uvs:totable(), flat.mesh:triangles():totable(), {}
  local charts = flat.charts:totable()
  for i, t in ipairs(triangles) do
    local one = { chart = charts[i], number = i }
    for k = 1, 3 do one[k] = { uvs[t[k]][1] * report.width, (1 - uvs[t[k]][2]) * report.height } end
    out[i] = one
  end
  return out
end

--- How deep two triangles are in each other: the least of the overlaps along the normals of their edges.
local function depth(a, b)
  local least = math.huge
  for _, t in ipairs { a, b } do
    for k = 1, 3 do
      local p, q = t[k], t[k % 3 + 1]
      local nx, ny = q[2] - p[2], p[1] - q[1]
      local length = math.sqrt(nx * nx + ny * ny)
      if length > 0 then
        local lo, hi = { math.huge, math.huge }, { -math.huge, -math.huge }
        for j, of in ipairs { a, b } do
          for c = 1, 3 do
            local x = (of[c][1] * nx + of[c][2] * ny) / length
            lo[j], hi[j] = math.min(lo[j], x), math.max(hi[j], x)
          end
        end
        least = math.min(least, math.min(hi[1], hi[2]) - math.max(lo[1], lo[2]))
      end
    end
  end
  return least
end

--- A sentence where a coordinate is outside of the square, or a chart's triangle is turned over.
local function wrong_triangle(list, report)
  for _, t in ipairs(list) do
    for k = 1, 3 do
      local x, y = t[k][1], t[k][2]
      if not (x >= 0 and y >= 0 and x <= report.width and y <= report.height) then
        return ("triangle %d: corner %d at %g, %g is outside"):format(t.number, k, x, y)
      end
    end
    local twice = (t[2][1] - t[1][1]) * (t[3][2] - t[1][2]) - (t[3][1] - t[1][1]) * (t[2][2] - t[1][2])
    if t.chart > 0 and twice > SMALL then return ("triangle %d is turned over, by %g"):format(t.number, twice) end
  end
end

--- A sentence where two triangles lie over each other.
local function overlap(list)
  for i = 1, #list do
    for j = i + 1, #list do
      if list[i].chart > 0 and list[j].chart > 0 then
        local d = depth(list[i], list[j])
        if d > SMALL then return ("triangles %d and %d overlap by %g texels"):format(i, j, d) end
      end
    end
  end
end

--- A sentence where look-ups in two charts read one texel.
local function shared(list, report)
  local owner = {}
  local function read(t, x, y)
    local a, b = math.floor(x - 0.5), math.floor(y - 0.5)
    for k = 0, 3 do
      local i, j = a + k % 2, b + math.floor(k / 2)
      local weight = (1 - math.abs(x - 0.5 - i)) * (1 - math.abs(y - 0.5 - j))
      if weight > SMALL then
        local texel = j * report.width + i
        owner[texel] = owner[texel] or t.chart
        if owner[texel] ~= t.chart then
          return ("charts %d and %d share texel %d, %d"):format(t.chart, owner[texel], i, j)
        end
      end
    end
  end
  for _, t in ipairs(list) do
    for i = 0, t.chart > 0 and 4 or -1 do
      for j = 0, 4 - i do
        local u, v = i / 4, j / 4
        local wrong = read(t, t[1][1] + u * (t[2][1] - t[1][1]) + v * (t[3][1] - t[1][1]),
          t[1][2] + u * (t[2][2] - t[1][2]) + v * (t[3][2] - t[1][2]))
        if wrong then return wrong end
      end
    end
  end
end

return function(flat, report)
  local list = corners(flat, report)
  return wrong_triangle(list, report) or overlap(list) or shared(list, report)
end
