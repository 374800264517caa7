--- Vectors {x, y, z} whose squares need not be representable: what is scaled to length 1, is here.

local core = require "ylm.c.core"

local vector = {}

--- The vector times a power of two that brings its largest component near 1: nothing is rounded.
local function scaled(v)
  local largest = math.max(math.abs(v[1]), math.abs(v[2]), math.abs(v[3]))
  local u = { v[1], v[2], v[3] }
  if largest < 2 ^ -1000 then -- the factor below would overflow
    for i = 1, 3 do u[i] = u[i] * 2 ^ 100 end
    largest = largest * 2 ^ 100
  end
  local factor = 2 ^ -math.floor(math.log(largest) / math.log(2) + 1)
  for i = 1, 3 do u[i] = u[i] * factor end
  return u
end

--- The vector at length 1, whatever its length; it is finite and not zero.
function vector.unit(v)
  local u = scaled(v)
  local length = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2)
  return { u[1] / length, u[2] / length, u[3] / length }
end

--- a x b.
function vector.cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

function vector.minus(a, b) return { a[1] - b[1], a[2] - b[2], a[3] - b[3] } end

function vector.times(v, k) return { k * v[1], k * v[2], k * v[3] } end

function vector.dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- The length of a vector whose square is representable.
function vector.length(v) return math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2) end

--- A unit vector across a unit axis, C0 of lamps: +x, or +z of an axis along x, less its part along the axis; and that part
-- over the rest's length.
function vector.across(axis)
  local base, rest = math.abs(axis[1]) > 0.999 and { 0, 0, 1 } or { 1, 0, 0 }, {}
  local along = vector.dot(base, axis)
  for i = 1, 3 do rest[i] = base[i] - along * axis[i] end
  return vector.unit(rest), along / vector.length(rest)
end

--- Two unit vectors that make a frame with a unit axis.
function vector.frame(axis)
  local least = 1
  for a = 2, 3 do if math.abs(axis[a]) < math.abs(axis[least]) then least = a end end
  local u = vector.unit(vector.cross(axis, { least == 1 and 1 or 0, least == 2 and 1 or 0, least == 3 and 1 or 0 }))
  return u, vector.cross(axis, u)
end

--- The luminance of a colour {r, g, b}, linear Rec. 709.
function vector.luminance(c)
  local weight = core.luminance
  return weight[1] * c[1] + weight[2] * c[2] + weight[3] * c[3]
end

return vector
