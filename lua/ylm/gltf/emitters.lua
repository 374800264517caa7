--- Surfaces that emit, as polygon lights: triangles of one plane and one emission are joined to convex polygons.

local core = require "ylm.c.core"
local polygon = require "ylm.light.polygon"
local vector = require "ylm.vector"

local emitters = {}

local MOST = core.limits.polygon_vertices
local FLAT = 1e-4 -- largest sine between planes that are joined
local DARK = 1e-3 -- of the brightest: darker triangles stay surfaces
local TRIANGLES = 200000

-- Emission of triangles ----------------------------------------------------------------------

--- Where a coordinate is looked up, from 0 to 1.
local folds = {
  ["repeat"] = function(x) return x - math.floor(x) end,
  clamp = function(x) return math.max(0, math.min(1, x)) end,
  mirror = function(x)
    x = x - 2 * math.floor(x / 2)
    return x > 1 and 2 - x or x
  end,
}

--- Texels of the first layer of an image: f(u, v) -> r, g, b, v upwards; `wraps` of u and v.
local function sampler(image, wraps)
  local fold_u, fold_v = folds[wraps[1]], folds[wraps[2]]
  local layer = core.image_layer(image)
  local shape = core.array_info(layer)
  local height, width, channels = shape[1], shape[2], shape[3]
  return function(u, v)
    local x = math.min(width - 1, math.floor(fold_u(u) * width))
    local y = math.min(height - 1, math.floor((1 - fold_v(v)) * height))
    local r = core.array_get(layer, y + 1, x + 1, 1)
    if channels < 3 then return r, r, r end
    return r, core.array_get(layer, y + 1, x + 1, 2), core.array_get(layer, y + 1, x + 1, 3)
  end
end

--- Barycentric places at which textures are looked up: 15 points of a triangle.
local places = {}
for i = 0, 4 do
  for j = 0, 4 - i do places[#places + 1] = { (i + 1 / 3) / 5, (j + 1 / 3) / 5 } end
end

--- The emission of each triangle { r, g, b }; the texture's mean over it where there is one.
local function emissions(m, triangles, uvs, texel)
  local out = {}
  for i, t in ipairs(triangles) do
    if not texel then out[i] = m.emission
    else
      local a, b, c, sum = uvs[t[1]], uvs[t[2]], uvs[t[3]], { 0, 0, 0 }
      for _, p in ipairs(places) do
        local w = 1 - p[1] - p[2]
        local red, green, blue = texel(a[1] * w + b[1] * p[1] + c[1] * p[2], a[2] * w + b[2] * p[1] + c[2] * p[2])
        sum[1], sum[2], sum[3] = sum[1] + red, sum[2] + green, sum[3] + blue
      end
      out[i] = { m.emission[1] * sum[1] / #places, m.emission[2] * sum[2] / #places, m.emission[3] * sum[3] / #places }
    end
  end
  return out
end

local function largest(c) return math.max(c[1], c[2], c[3]) end

-- Joining ----------------------------------------------------------------------------------------

--- Numbers of vertices by their places.
local function welder()
  local numbers, points = {}, {}
  return function(p)
    local key = ("%.9g %.9g %.9g"):format(p[1], p[2], p[3])
    if not numbers[key] then
      points[#points + 1] = p
      numbers[key] = #points
    end
    return numbers[key]
  end, points
end

local minus, dot = vector.minus, vector.dot

--- The ring of corners without those on straight edges; nil where it is not convex about `normal`.
local function convex(ring, points, normal)
  local out, n = {}, #ring
  for i = 1, n do
    local a, b, c = points[ring[(i - 2) % n + 1]], points[ring[i]], points[ring[i % n + 1]]
    local u, v = minus(b, a), minus(c, b)
    local turn, size = dot(vector.cross(u, v), normal), vector.length(u) * vector.length(v)
    if turn < -1e-6 * size then return nil end
    if turn > 1e-6 * size then out[#out + 1] = ring[i]
    elseif dot(u, v) <= 0 then return nil end
  end
  return #out >= 3 and #out <= MOST and out or nil
end

--- Polygon p and q, which have the edge a -> b of p in common, as one ring; nil where they share more.
local function joined(p, q, a, b)
  local ring, n, m = {}, #p.ring, #q.ring
  local i, j = nil, nil
  for k = 1, n do if p.ring[k] == b then i = k end end
  for k = 1, m do if q.ring[k] == a then j = k end end
  for k = 0, n - 1 do ring[#ring + 1] = p.ring[(i + k - 1) % n + 1] end -- from b around to a
  for k = 1, m - 2 do ring[#ring + 1] = q.ring[(j + k - 1) % m + 1] end -- from behind a to before b
  local seen = {}
  for _, corner in ipairs(ring) do
    if seen[corner] then return nil end
    seen[corner] = true
  end
  return ring
end

local function edge(a, b) return a .. " " .. b end

local function register(edges, p)
  for k, a in ipairs(p.ring) do edges[edge(a, p.ring[k % #p.ring + 1])] = p end
end

--- Joins the polygon with a neighbour: the new one, or nil.
local function join_one(p, edges, points)
  for k, a in ipairs(p.ring) do
    local b = p.ring[k % #p.ring + 1]
    local q = edges[edge(b, a)]
    if q and q ~= p and not q.gone and q.emission == p.emission and dot(p.normal, q.normal) > 0
      and vector.length(vector.cross(p.normal, q.normal)) < FLAT then
      local ring = joined(p, q, a, b)
      ring = ring and convex(ring, points, p.normal)
      if ring then
        p.gone, q.gone = true, true
        return { ring = ring, normal = p.area >= q.area and p.normal or q.normal, area = p.area + q.area, emission = p.emission }
      end
    end
  end
end

--- Polygons of triangles; `points` are their corners.
local function join(list, points)
  local edges, done = {}, {}
  for _, p in ipairs(list) do register(edges, p) end
  local i = 1
  while i <= #list do
    local p = list[i]
    local new = not p.gone and join_one(p, edges, points)
    if new then
      list[#list + 1] = new
      register(edges, new)
    end
    i = i + 1
  end
  for _, p in ipairs(list) do if not p.gone then done[#done + 1] = p end end
  return done
end

--- Is every edge of the triangles there twice, in opposite directions?
local function is_closed(rings)
  local count = {}
  for _, ring in ipairs(rings) do
    for k = 1, 3 do
      local a, b = ring[k], ring[k % 3 + 1]
      count[edge(a, b)] = (count[edge(a, b)] or 0) + 1
    end
  end
  for key, n in pairs(count) do
    local a, b = key:match "^(%d+) (%d+)$"
    if n ~= 1 or count[edge(b, a)] ~= 1 then return false end
  end
  return true
end

-- Pieces ----------------------------------------------------------------------------------------

--- The polygons of a piece of material `m` as { vertices, radiance, area }, and the triangles that are dark; nothing where
-- there are too many triangles. `image`: of the emission, or nil.
local function of_piece(piece, m, image, wraps)
  local mesh = piece.mesh
  if #mesh > TRIANGLES then return nil end
  local positions, triangles = core.array_totable(mesh:vertices()), core.array_totable(mesh:triangles())
  local uvs = image and mesh:uvs() and core.array_totable(mesh:uvs())
  local emission = emissions(m, triangles, uvs, uvs and sampler(image, wraps))
  local brightest, list, rings, dark = 0, {}, {}, {}
  for _, e in ipairs(emission) do brightest = math.max(brightest, largest(e)) end
  local number, points = welder()
  for i, t in ipairs(triangles) do
    local ring = { number(positions[t[1]]), number(positions[t[2]]), number(positions[t[3]]) }
    rings[i] = ring
    local a, b, c = points[ring[1]], points[ring[2]], points[ring[3]]
    local u, v = minus(b, a), minus(c, a)
    local across = vector.cross(u, v)
    local length = vector.length(across)
    if largest(emission[i]) <= DARK * brightest then dark[#dark + 1] = t
    elseif length > 1e-9 * (dot(u, u) + dot(v, v)) then
      list[#list + 1] = { ring = ring, normal = vector.unit(across), area = length / 2, emission = emission[i] }
    end
  end
  local closed = is_closed(rings)
  local half = closed and 0.5 or 1
  local out = {}
  for _, p in ipairs(join(list, points)) do
    local vertices = {}
    for k, corner in ipairs(p.ring) do vertices[k] = points[corner] end
    out[#out + 1] = { vertices = vertices, area = p.area,
      radiance = { half * p.emission[1], half * p.emission[2], half * p.emission[3] } }
  end
  return out, dark, closed
end

--- The piece with these triangles only; nil, message, code.
local function part(piece, triangles)
  local t = require "ylm.array".array(triangles, "double")
  local mesh, message, code = core.mesh_from(piece.mesh:vertices(), t, piece.mesh:normals(),
    piece.mesh:uvs(), piece.mesh:colours())
  if not mesh then return nil, message, code end
  local copy = {}
  for key, x in pairs(piece) do copy[key] = x end
  copy.mesh = mesh
  return setmetatable(copy, getmetatable(piece))
end

local function power(p) return p.area * vector.luminance(p.radiance) end

--- Lights of the pieces that emit, { piece =, m =, image =, wraps = } each: polygon lights, and the surfaces that stay. The
-- `most` most powerful are kept; note(sentence, ...) takes what is lost. Or nil, message, code.
function emitters.convert(pieces, most, scale, note)
  local all, stay, open, closed, large = {}, {}, 0, 0, 0
  for _, e in ipairs(pieces) do
    local polygons, dark, is_whole = of_piece(e.piece, e.m, e.image, e.wraps)
    if not polygons then
      large = large + 1
      stay[#stay + 1] = e.piece
    else
      for _, p in ipairs(polygons) do all[#all + 1] = p end
      if is_whole then closed = closed + 1 elseif not e.m.both_sides then open = open + 1 end
      if #dark > 0 then
        local left, message, code = part(e.piece, dark)
        if not left then return nil, message, code end
        stay[#stay + 1] = left
      end
    end
  end
  local total, kept, out = 0, 0, {}
  for i, p in ipairs(all) do p.place, total = i, total + power(p) end
  table.sort(all, function(a, b) local x, y = power(a), power(b) return x > y or x == y and a.place < b.place end)
  for i = 1, math.min(most, #all) do
    local p = all[i]
    local ok, made = pcall(polygon.polygon_light, { vertices = p.vertices,
      radiance = { scale * p.radiance[1], scale * p.radiance[2], scale * p.radiance[3] } })
    if ok and made then
      kept = kept + power(p)
      out[#out + 1] = made
    elseif not ok and (type(made) ~= "string" or not made:find("polygon_light: ", 1, true)) then error(made, 0) end
  end
  local lost = total > 0 and math.max(0, 1 - kept / total) or 0
  if lost > 1e-6 then note("%d of %d polygons that emit are kept: %.3g %% of the power is lost", #out, #all, 100 * lost) end
  if open > 0 then note("surfaces that emit to both sides, and to one in the file: %d", open) end
  if closed > 0 then
    note("closed surfaces that emit, with half of the radiance, which is exact where they are convex: %d", closed)
  end
  if large > 0 then note("surfaces of more than %d triangles, whose emission is left out: %d", TRIANGLES, large) end
  return out, stay, lost
end

return emitters
