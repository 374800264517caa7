--- Pixels and places: the camera of a live window, and planes that a pointer drags in.
--
-- A picture has width and height in pixels, places in it are measured from its upper left corner. Cameras are plain tables
-- { from, at, up, fov }, whose vectors are not changed in place.

local vector = require "ylm.vector"

local space = {}

local function plus(a, b, t) return { a[1] + t * b[1], a[2] + t * b[2], a[3] + t * b[3] } end
local minus, dot = vector.minus, vector.dot
space.plus, space.minus, space.dot = plus, minus, dot

--- The axes of a camera and half the height and width that it sees at distance 1.
function space.frame(camera, width, height)
  local forward = vector.unit(minus(camera.at, camera.from))
  local right = vector.unit(vector.cross(forward, vector.unit(camera.up)))
  local tall = math.tan(math.rad(camera.fov) / 2)
  return { from = camera.from, forward = forward, right = right, up = vector.cross(right, forward), tall = tall,
    wide = tall * width / height, width = width, height = height }
end

--- The direction in which place x, y is seen; its product with forward is 1.
function space.direction(f, x, y)
  local d = plus(f.forward, f.right, (2 * x / f.width - 1) * f.wide)
  return plus(d, f.up, (1 - 2 * y / f.height) * f.tall)
end

--- The place where p is seen, and its depth; nil behind the camera.
function space.project(f, p)
  local to = minus(p, f.from)
  local z = dot(to, f.forward)
  if not (z > 0) then return nil end
  return (dot(to, f.right) / z / f.wide + 1) / 2 * f.width, (1 - dot(to, f.up) / z / f.tall) / 2 * f.height, z
end

--- The place at x, y and that depth.
function space.at_depth(f, x, y, z) return plus(f.from, space.direction(f, x, y), z) end

--- How far p is moved so that it stays in front of the camera, nearer than `least` never, and within `reach` of `middle`.
function space.held(f, p, least, middle, reach)
  local away = minus(p, middle)
  local length = vector.length(away)
  if not (length <= reach) then p = plus(middle, away, reach / math.max(length, 1e-300)) end
  local z = dot(minus(p, f.from), f.forward)
  if z < least then p = plus(p, f.forward, least - z) end
  return p
end

--- The place under x, y of what is dragged from p: "facing" in the plane that faces the camera, "along" on the line along
-- `up`, "across" in the plane across `up`. nil where the plane is not seen there.
function space.dragged(f, way, p, up, x, y)
  local d = space.direction(f, x, y)
  if way == "facing" then return plus(f.from, d, dot(minus(p, f.from), f.forward)) end
  up = vector.unit(up)
  local to = minus(p, f.from)
  if way == "across" then
    local steep = dot(d, up)
    local t = dot(to, up) / steep
    if steep == 0 or not (t > 0) or t == math.huge then return nil end
    return plus(f.from, d, t)
  end
  -- On the line, the place nearest to the ray.
  local dd, du = dot(d, d), dot(d, up)
  local slope = dd - du * du
  if slope < 1e-12 * dd then return nil end
  return plus(p, up, (dot(d, to) * du - dot(to, up) * dd) / slope)
end

--- The camera turned about what it looks at by a pointer that moved dx, dy pixels.
function space.turned(camera, dx, dy, height)
  local up = vector.unit(camera.up)
  local arm = minus(camera.from, camera.at)
  local length = vector.length(arm)
  local high = math.asin(math.max(-1, math.min(1, dot(arm, up) / length)))
  local flat = plus(arm, up, -dot(arm, up))
  if vector.length(flat) < 1e-9 * length then flat = vector.cross(up, { up[2], up[3], up[1] }) end
  local a = vector.unit(flat)
  local b = vector.cross(up, a)
  local turn, most = -math.pi * dx / height, math.rad(89)
  high = math.max(-most, math.min(most, high + math.pi * dy / height))
  local across = plus({ 0, 0, 0 }, a, math.cos(turn))
  across = plus(across, b, math.sin(turn))
  local from = plus(plus(camera.at, across, length * math.cos(high)), up, length * math.sin(high))
  return { from = from, at = camera.at, up = camera.up, fov = camera.fov }
end

--- The camera shifted so that what it looks at follows the pointer.
function space.shifted(camera, dx, dy, width, height)
  local f = space.frame(camera, width, height)
  local z = vector.length(minus(camera.at, camera.from))
  local by = plus(plus({ 0, 0, 0 }, f.right, -2 * dx / width * f.wide * z), f.up, 2 * dy / height * f.tall * z)
  return { from = plus(camera.from, by, 1), at = plus(camera.at, by, 1), up = camera.up, fov = camera.fov }
end

--- The camera nearer to what it looks at by that many notches, not nearer than `least`, not farther than `most`.
function space.nearer(camera, notches, least, most)
  local arm = minus(camera.from, camera.at)
  local length = vector.length(arm)
  local new = math.max(least, math.min(most, length * 0.9 ^ notches))
  return { from = plus(camera.at, arm, new / length), at = camera.at, up = camera.up, fov = camera.fov }
end

--- The camera that looks at p from where it stands.
function space.looking_at(camera, p)
  local to = minus(p, camera.from)
  local up = vector.unit(camera.up)
  if not (vector.length(vector.cross(vector.unit(to), up)) > 1e-6) then return camera end
  return { from = camera.from, at = p, up = camera.up, fov = camera.fov }
end

return space
