--- Places of a scene's surfaces by area, and the box around its geometry.

local random = require "spec.support.random"

local places = {}

local OFF, AIR, LIFT = 1e-3, 0.02, 0.015

--- All triangles of a scene: { a, b, c, u, v, n (of length 1), lo, hi }, sums of their areas.
local function triangles_of(scene)
  local list, sums, sum = {}, {}, 0
  for _, g in ipairs(scene.geometry) do
    local v, t = g.mesh:vertices(), g.mesh:triangles()
    for i = 1, #t do
      local p = {}
      for k = 1, 3 do
        local row = t:get(i, k)
        p[k] = { v:get(row, 1), v:get(row, 2), v:get(row, 3) }
      end
      local T = { a = p[1], u = {}, v = {}, n = {}, lo = {}, hi = {} }
      for x = 1, 3 do
        T.u[x], T.v[x] = p[2][x] - p[1][x], p[3][x] - p[1][x]
        T.lo[x], T.hi[x] = math.min(p[1][x], p[2][x], p[3][x]), math.max(p[1][x], p[2][x], p[3][x])
      end
      for x = 1, 3 do
        local y, z = x % 3 + 1, (x + 1) % 3 + 1
        T.n[x] = T.u[y] * T.v[z] - T.u[z] * T.v[y]
      end
      local length = math.sqrt(T.n[1] ^ 2 + T.n[2] ^ 2 + T.n[3] ^ 2)
      if length > 0 then
        for x = 1, 3 do T.n[x] = T.n[x] / length end
        sum = sum + length / 2
        list[#list + 1], sums[#sums + 1] = T, sum
      end
    end
  end
  return list, sums
end

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
local function cross(a, b) return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] } end

--- Is there a triangle within `far` of p along d? By the method of Moeller and Trumbore.
local function blocked(triangles, p, d, far)
  local lo, hi = {}, {}
  for x = 1, 3 do lo[x], hi[x] = math.min(p[x], p[x] + far * d[x]), math.max(p[x], p[x] + far * d[x]) end
  for i = 1, #triangles do
    local T = triangles[i]
    local l, h = T.lo, T.hi
    if l[1] <= hi[1] and h[1] >= lo[1] and l[2] <= hi[2] and h[2] >= lo[2] and l[3] <= hi[3] and h[3] >= lo[3] then
      local q = cross(d, T.v)
      local det = dot(T.u, q)
      if math.abs(det) > 1e-12 then
        local w = { p[1] - T.a[1], p[2] - T.a[2], p[3] - T.a[3] }
        local r = cross(w, T.u)
        local s, t, far_off = dot(w, q) / det, dot(d, r) / det, dot(T.v, r) / det
        if s >= 0 and t >= 0 and s + t <= 1 and far_off > 0 and far_off < far then return true end
      end
    end
  end
  return false
end

function places.within(box, p)
  for a = 1, 3 do if p[a] < box[1][a] or p[a] > box[2][a] then return false end end
  return true
end

--- The box around a scene's geometry.
function places.box_of(scene)
  local box = { { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge } }
  for _, g in ipairs(scene.geometry) do
    for a = 1, 3 do
      box[1][a], box[2][a] = math.min(box[1][a], g.mesh.bounds[1][a]), math.max(box[2][a], g.mesh.bounds[2][a])
    end
  end
  return box
end

--- `count` places by area: points, a little off their surface, and normals. Left out are sides in bodies and outside of rooms,
-- places with less than AIR above them, and places outside of `box`: by default that of the geometry, where grids end.
function places.draw(scene, field, count, seed, box)
  local triangles, sums = triangles_of(scene)
  box = box or places.box_of(scene)
  local draw, points, normals = random.minimal(7919 * seed + 12345), {}, {}
  for _ = 1, 100 do draw() end
  while #points < count do
    local p, n = {}, {}
    for i = 1, count do
      local wanted, low, high = draw() * sums[#sums], 1, #sums
      while low < high do
        local middle = math.floor((low + high) / 2)
        if sums[middle] < wanted then low = middle + 1 else high = middle end
      end
      local T, s, t, side = triangles[low], draw(), draw(), draw() < 0.5 and 1 or -1
      if s + t > 1 then s, t = 1 - s, 1 - t end
      p[i], n[i] = {}, {}
      for x = 1, 3 do
        n[i][x] = side * T.n[x]
        p[i][x] = T.a[x] + s * T.u[x] + t * T.v[x] + OFF * n[i][x]
      end
    end
    local above = {} -- validity of a place as near as OFF is that of its triangle's other side
    for i = 1, count do above[i] = { p[i][1] + LIFT * n[i][1], p[i][2] + LIFT * n[i][2], p[i][3] + LIFT * n[i][3] } end
    local validity = field:validity(above)
    for i = 1, count do
      if #points < count and places.within(box, p[i]) and validity[i] > 0.9 and not blocked(triangles, p[i], n[i], AIR) then
        points[#points + 1], normals[#normals + 1] = p[i], n[i]
      end
    end
  end
  return points, normals
end

places.OFF = OFF

return places
