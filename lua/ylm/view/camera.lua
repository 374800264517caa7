--- The default camera of a picture.

local vector = require "ylm.vector"
local cross, dot, unit = vector.cross, vector.dot, vector.unit

local view_camera = {}

--- The axes of a view: to the right, up, towards the camera.
local function axes(towards, up)
  local z = unit(towards)
  local x = cross(unit(up), z)
  if dot(x, x) < 1e-12 then x = cross({ z[2], z[3], z[1] }, z) end
  x = unit(x)
  return x, cross(z, x), z
end

-- The part of a window that is filled; the rest is a margin.
local FILLED = 0.92

--- A camera in direction `towards` that sees, as large as fits, what reach(directions) knows: for each direction the largest
-- product with a point that is drawn. Returns it, the pixels that a unit in the middle is large, and the part of the
-- window's height that is filled.
--
-- A point is in the window where its product with the normals of the pyramid's four sides is at most the eye's.
function view_camera.fit(reach, width, height, towards, up, fov)
  fov, up = fov or 28, up or { 0, 1, 0 }
  local x, y, z = axes(towards, up)
  local ty = math.tan(math.rad(fov) / 2) * FILLED
  local tx = ty * width / height
  local function side(a, t) return { a[1] / t + z[1], a[2] / t + z[2], a[3] / t + z[3] } end
  local h = reach { side(x, tx), side(x, -tx), side(y, ty), side(y, -ty), z, { -z[1], -z[2], -z[3] } }
  local across, upright, near, middle = (h[1] + h[2]) / 2, (h[3] + h[4]) / 2, h[5], (h[5] - h[6]) / 2
  local eye = { tx * (h[1] - h[2]) / 2, ty * (h[3] - h[4]) / 2, math.max(across, upright) }
  if eye[3] - near < 1e-9 * (1 + math.abs(near)) then eye[3] = near + 1 end
  local distance = math.max(eye[3] - middle, 1e-30)
  local from, at = {}, {}
  for a = 1, 3 do
    from[a] = eye[1] * x[a] + eye[2] * y[a] + eye[3] * z[a]
    at[a] = from[a] - distance * z[a]
  end
  return { from = from, at = at, up = y, fov = fov }, height / distance, FILLED * (1 - (eye[3] - upright) / distance)
end

--- The fit for the first of several directions that fills most of the window's height, or for the last.
function view_camera.choose(reach, width, height, directions, up, fov)
  local camera, scale, filled
  for _, towards in ipairs(directions) do
    camera, scale, filled = view_camera.fit(reach, width, height, towards, up, fov)
    if filled > 0.8 then break end
  end
  return camera, scale
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
