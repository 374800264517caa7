--- Where a picture is seen from, if nobody said.

local view_camera = {}

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

local function cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function unit(a)
  local l = math.sqrt(dot(a, a))
  return { a[1] / l, a[2] / l, a[3] / l }
end

--- The axes of a view: to the right, up, towards the camera.
local function axes(towards, up)
  local z = unit(towards)
  local x = cross(up, z)
  if dot(x, x) < 1e-12 * dot(up, up) then x = cross({ z[2], z[3], z[1] }, z) end
  x = unit(x)
  return x, cross(z, x), z
end

--- A camera in direction `towards` that sees the box {x0 y0 z0 x1 y1 z1} as large as fits.
function view_camera.fit(box, width, height, towards, up, fov)
  fov, up = fov or 28, up or { 0, 1, 0 }
  local x, y, z = axes(towards, up)
  local at = { (box[1] + box[4]) / 2, (box[2] + box[5]) / 2, (box[3] + box[6]) / 2 }
  local ty = math.tan(math.rad(fov) / 2) * 0.92
  local tx = ty * width / height
  -- The middle of what is seen is not that of the box: balance left and right, top and bottom, twice.
  local distance
  for _ = 1, 3 do
    distance = 0
    local l, r, b, t = math.huge, -math.huge, math.huge, -math.huge
    local corners = {}
    for i = 0, 7 do
      local p = {}
      for a = 1, 3 do p[a] = box[a + 3 * (math.floor(i / 2 ^ (a - 1)) % 2)] - at[a] end
      local px, py, pz = dot(p, x), dot(p, y), dot(p, z)
      corners[#corners + 1] = { px, py, pz }
      distance = math.max(distance, math.abs(px) / tx + pz, math.abs(py) / ty + pz)
    end
    for _, c in ipairs(corners) do
      local d = distance - c[3]
      l, r = math.min(l, c[1] / d), math.max(r, c[1] / d)
      b, t = math.min(b, c[2] / d), math.max(t, c[2] / d)
    end
    for a = 1, 3 do at[a] = at[a] + distance * ((l + r) / 2 * x[a] + (b + t) / 2 * y[a]) end
  end
  if distance <= 0 then distance = 1 end
  local from = {}
  for a = 1, 3 do from[a] = at[a] + distance * z[a] end
  return { from = from, at = at, up = y, fov = fov }
end

--- Pixel coordinates (from the top left) of a point; nil behind the camera.
function view_camera.project(camera, width, height, p)
  local towards, v = {}, {}
  for a = 1, 3 do towards[a], v[a] = camera.from[a] - camera.at[a], p[a] - camera.from[a] end
  local x, y, z = axes(towards, camera.up)
  local depth = -dot(v, z)
  if depth <= 0 then return nil end
  local k = height / 2 / math.tan(math.rad(camera.fov) / 2) / depth
  return width / 2 + k * dot(v, x), height / 2 - k * dot(v, y)
end

return view_camera
