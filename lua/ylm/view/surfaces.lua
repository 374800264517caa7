--- The layer of a view that shows a surface grid: its scene's surfaces in the colours of its rectangles.
--
-- Triangles are cut into small ones, each in the colour of the rectangle that its middle lies on. Borders of rectangles are as
-- fine as these.

local array = require "ylm.array"
local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local numbers = require "ylm.view.numbers"

local surfaces = {}

local LEAST, MOST = 4000, 120000 -- small triangles, about
local PIXELS = 8                 -- of the picture for each
local GOLDEN = 0.618033988749895
local NONE = { 0.3, 0.3, 0.32 }   -- of places that no rectangle has

--- A colour of a rectangle: neighbours by number differ much.
local function colour_of(number)
  if number == 0 then return NONE end
  local c, hue = {}, number * GOLDEN % 1
  for a = 1, 3 do c[a] = 0.15 + 0.65 * (0.5 + 0.5 * math.cos(2 * math.pi * (hue + a / 3))) end
  return c
end

--- The colours of charts by their numbers.
local function colours_of(v)
  local map, least, most, log = numbers.scale_of(v.charts_scale)
  return core.array_totable(core.figure_colours(v.charts_values, v.theme.background, map, least, most, log))
end

--- All triangles of a scene: { corner, two edges, normal of length 1, longest edge }.
local function triangles_of(scene)
  local list, area = {}, 0
  for _, part in ipairs(scene.geometry) do
    local v, t = core.array_totable(part.mesh:vertices()), core.array_totable(part.mesh:triangles())
    for _, rows in ipairs(t) do
      local a, b, c = v[rows[1]], v[rows[2]], v[rows[3]]
      local T = { a = a, u = {}, v = {}, n = {}, longest = 0 }
      local square = { 0, 0, 0 }
      for x = 1, 3 do
        T.u[x], T.v[x] = b[x] - a[x], c[x] - a[x]
        square[1], square[2], square[3] = square[1] + T.u[x] ^ 2, square[2] + T.v[x] ^ 2, square[3] + (c[x] - b[x]) ^ 2
      end
      T.longest = math.sqrt(math.max(square[1], square[2], square[3]))
      for x = 1, 3 do
        local y, z = x % 3 + 1, (x + 1) % 3 + 1
        T.n[x] = T.u[y] * T.v[z] - T.u[z] * T.v[y]
      end
      local length = math.sqrt(T.n[1] ^ 2 + T.n[2] ^ 2 + T.n[3] ^ 2)
      if length > 0 then
        for x = 1, 3 do T.n[x] = T.n[x] / length end
        list[#list + 1], area = T, area + length / 2
      end
    end
  end
  return list, area
end

--- The length of the edges of about so many small triangles; needles do not make them many more.
local function edge_of(list, area, wanted)
  local edge, parts = math.sqrt(2 * area / wanted), math.huge
  while parts > math.max(4 * wanted, 2 * #list) do
    parts = 0
    for _, T in ipairs(list) do parts = parts + math.ceil(T.longest / edge) ^ 2 end
    edge = 1.5 * edge
  end
  return edge / 1.5
end

--- Small triangles: corners, three rows each; their middles; normals.
local function cut(list, edge)
  local corners, middles, normals = {}, {}, {}
  local function add(T, n, ...)
    local at, middle = { ... }, { 0, 0, 0 }
    for k = 1, 5, 2 do
      local p = {}
      for x = 1, 3 do
        p[x] = T.a[x] + (at[k] * T.u[x] + at[k + 1] * T.v[x]) / n
        middle[x] = middle[x] + p[x] / 3
      end
      corners[#corners + 1] = p
    end
    middles[#middles + 1], normals[#normals + 1] = middle, T.n
  end
  for _, T in ipairs(list) do
    local n = math.max(1, math.ceil(T.longest / edge))
    for i = 0, n - 1 do
      for k = 0, n - 1 - i do
        add(T, n, i, k, i + 1, k, i, k + 1)
        if i + k < n - 1 then add(T, n, i + 1, k, i + 1, k + 1, i, k + 1) end
      end
    end
  end
  return corners, middles, normals
end

--- The rectangles of places, a list of numbers: of the normals' side, else of the other.
local function rectangles_of(light, middles, normals)
  local points, turned, found = array.array(middles), {}, {}
  for i, n in ipairs(normals) do turned[i] = { -n[1], -n[2], -n[3] } end
  for _, side in ipairs { normals, turned } do
    local E, of, code = light:irradiance(points, array.array(side, "float"))
    if not E then drawing.run(nil, of, code) end
    local list = core.array_totable(of)
    for i = 1, #middles do if (found[i] or 0) == 0 then found[i] = list[i] end end
  end
  return found
end

--- Rows of three numbers as an array of doubles.
local function rows(list)
  local a, message, code = core.array_zeros({ #list, 3 }, "double")
  if not a then drawing.run(nil, message, code) end
  core.array_fill(a, list)
  return a
end

function surfaces.fill(stage, v)
  local light = v.surfaces
  local list, area = triangles_of(light.scene)
  if #list == 0 then return end
  local wanted = math.min(MOST, math.max(LEAST, v.size[1] * v.size[2] / PIXELS))
  local corners, middles, normals = cut(list, edge_of(list, area, wanted))
  local colours, index, of_chart = {}, {}, v.charts and v.charts ~= "number" and colours_of(v)
  for i, number in ipairs(rectangles_of(light, middles, normals)) do
    local c = of_chart and (of_chart[number] or NONE) or colour_of(number)
    for k = 1, 3 do colours[3 * i - 3 + k] = c end
    index[i] = { 3 * i - 2, 3 * i - 1, 3 * i }
  end
  local shape = core.shape(3)
  drawing.run(core.shape_mesh(shape, rows(corners), nil, rows(colours), rows(index), 1))
  drawing.surface(stage, shape, { specular = 0 })
end

return surfaces
