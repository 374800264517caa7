--- Files of measured materials that nobody has measured: RGL's tensors from arrays, constant ones, and those of GGX, whose
-- truth is a formula.

local files = {}

-- Numbers as bytes ---------------------------------------------------------------------

--- A whole number as n bytes, little-endian.
local function whole(x, n)
  local out = {}
  for i = 1, n do
    out[i] = string.char(x % 256)
    x = math.floor(x / 256)
  end
  return table.concat(out)
end

--- A number as a float, by hand: for Luas without string.pack.
local function float_by_hand(x)
  local sign = x < 0 and 2 ^ 31 or 0
  x = math.abs(x)
  if x ~= x then return whole(0x7fc00000, 4) end
  if x == math.huge then return whole(sign + 0x7f800000, 4) end
  if x < 2 ^ -126 then return whole(sign, 4) end
  local mantissa, exponent = math.frexp(x) -- luacheck: ignore 143
  return whole(sign + (exponent + 126) * 2 ^ 23 + math.floor((2 * mantissa - 1) * 2 ^ 23 + 0.5), 4)
end

local pack = string.pack -- luacheck: ignore 143

--- A list of numbers as floats.
local function floats(list)
  local out = {}
  for i, x in ipairs(list) do out[i] = pack and pack("<f", x) or float_by_hand(x) end
  return table.concat(out)
end

-- Tensor files ---------------------------------------------------------------------------

local type_numbers = { u8 = 1, f32 = 10, f64 = 11 }

--- The bytes of a tensor file of fields { name, type, shape, numbers or text }. `damage(field, i)` may return the offset and
-- the shape that the header says instead of the true ones.
function files.tensor(fields, damage)
  local header, at = 18, 0
  for _, field in ipairs(fields) do header = header + 13 + #field[1] + 8 * #field[3] end
  local out, data = { "tensor_file\0\1\0", whole(#fields, 4) }, {}
  local start = math.ceil(header / 8) * 8
  for i, field in ipairs(fields) do
    local text = type(field[4]) == "string" and field[4] or floats(field[4])
    local offset, shape
    if damage then offset, shape = damage(field, i) end
    shape = shape or field[3]
    out[#out + 1] = whole(#field[1], 2) .. field[1] .. whole(#shape, 2) .. whole(type_numbers[field[2]] or field[2], 1)
      .. whole(offset or start + at, 8)
    for _, extent in ipairs(shape) do out[#out + 1] = whole(extent, 8) end
    text = text .. ("\0"):rep(-#text % 8)
    data[i], at = text, at + #text
  end
  return table.concat(out) .. ("\0"):rep(start - header) .. table.concat(data)
end

--- The fields of an RGL file: tables by name, with `size` (of vndf) and `fine` (of luminance and rgb).
local function rgl_fields(t)
  local p, n, a, r = #t.phi_i, #t.theta_i, t.size, t.fine
  return {
    { "description", "u8", { 9 }, "synthetic" },
    { "phi_i", "f32", { p }, t.phi_i },
    { "theta_i", "f32", { n }, t.theta_i },
    { "ndf", "f32", { #t.ndf / a, a }, t.ndf },
    { "sigma", "f32", { #t.sigma / a, a }, t.sigma },
    { "vndf", "f32", { p, n, a, a }, t.vndf },
    { "luminance", "f32", { p, n, r, r }, t.luminance },
    { "rgb", "f32", { p, n, 3, r, r }, t.rgb },
    { "jacobian", "u8", { 1 }, "\1" },
  }
end

local function constant(n, x)
  local out = {}
  for i = 1, n do out[i] = x end
  return out
end

--- The angles from 0 to `last`.
local function angles(n, first, last)
  local out = {}
  for i = 1, n do out[i] = n > 1 and first + (last - first) * (i - 1) / (n - 1) or first end
  return out
end

--- Tables of ones, and of colours { r, g, b }: f cos = colour / 4.
function files.constant_fields(colour, size, thetas)
  size, thetas = size or 4, thetas or 2
  local rgb = {}
  for _ = 1, thetas do
    for c = 1, 3 do for _ = 1, size * size do rgb[#rgb + 1] = colour[c] end end
  end
  return rgl_fields { phi_i = { 0 }, theta_i = angles(thetas, 0, math.pi / 2), size = size, fine = size,
    ndf = constant(size * size, 1), sigma = constant(size * size, 1), vndf = constant(thetas * size * size, 1),
    luminance = constant(thetas * size * size, 1), rgb = rgb }
end

-- GGX, as the tables know it ---------------------------------------------------------------

local ggx = {}
files.ggx = ggx

--- The distribution of normals; a: { along x, along y }.
function ggx.d(a, m)
  local s = (m[1] / a[1]) ^ 2 + (m[2] / a[2]) ^ 2 + m[3] ^ 2
  return 1 / (math.pi * a[1] * a[2] * s * s)
end

function ggx.lambda(a, w)
  return (math.sqrt(1 + ((a[1] * w[1]) ^ 2 + (a[2] * w[2]) ^ 2) / w[3] ^ 2) - 1) / 2
end

--- Schlick's reflectance.
function ggx.fresnel(f0, cosine) return f0 + (1 - f0) * (1 - cosine) ^ 5 end

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- f of GGX with shadowing and masking apart, as a product of both.
function ggx.f(a, f0, wi, wo)
  local m = { wi[1] + wo[1], wi[2] + wo[2], wi[3] + wo[3] }
  local length = math.sqrt(dot(m, m))
  for i = 1, 3 do m[i] = m[i] / length end
  return ggx.fresnel(f0, length / 2) * ggx.d(a, m)
    / (4 * wi[3] * wo[3] * (1 + ggx.lambda(a, wi)) * (1 + ggx.lambda(a, wo)))
end

local function direction(theta, phi)
  return { math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta) }
end
files.direction = direction

--- Calls f(theta, phi) at the nodes of the square, rows of azimuth from -pi, as a list of its values.
local function over_square(size, rows, f)
  local out = {}
  for y = 0, rows - 1 do
    local phi = rows > 1 and (2 * y / (rows - 1) - 1) * math.pi or 0
    for x = 0, size - 1 do out[#out + 1] = f((x / (size - 1)) ^ 2 * math.pi / 2, phi) end
  end
  return out
end

--- The place in the square { x, y } that a share of the density lies before; density: [size][size].
local function warp(density, size)
  local function at(x, y) return density[y * size + x + 1] end
  local function integrals(n, value)
    local sums = { [0] = 0 }
    for i = 1, n - 1 do sums[i] = sums[i - 1] + (value(i - 1) + value(i)) / 2 end
    return sums
  end
  --- The place where the integral, times `share` of all, is reached.
  local function reached(n, sums, value, share)
    local wanted, i = share * sums[n - 1], 0
    while i < n - 2 and sums[i + 1] <= wanted do i = i + 1 end
    local a, b, x = value(i), value(i + 1), wanted - sums[i]
    local root = a + math.sqrt(math.max(0, a * a - 2 * x * (a - b)))
    return i, root > 0 and math.min(1, 2 * x / root) or 0
  end
  local rows, row_sums = {}, {}
  for y = 0, size - 1 do
    rows[y] = integrals(size, function(x) return at(x, y) end)
    row_sums[y] = rows[y][size - 1]
  end
  local function whole_row(y) return row_sums[y] end
  local all = integrals(size, whole_row)
  local function line_at(v)
    local y, ty = reached(size, all, whole_row, v)
    local function value(x) return (1 - ty) * at(x, y) + ty * at(x, y + 1) end
    return (y + ty) / (size - 1), value, integrals(size, value)
  end
  --- The places for shares of x, at one share v of y.
  return function(v, n, f)
    local y, value, sums = line_at(v)
    for k = 0, n - 1 do
      local x, tx = reached(size, sums, value, k / (n - 1))
      f((x + tx) / (size - 1), y)
    end
  end
end

--- Adds a slice of visible normals for the eye at (theta, phi), and what is left of GGX at the places they warp to.
local function add_slice(t, o, theta, phi)
  local a, c = o.alpha, direction(theta, phi)
  local around = o.isotropic and phi or 0
  local seen = over_square(o.size, o.size, function(theta_m, phi_m)
    local m, u = direction(theta_m, phi_m + around), math.sqrt(theta_m * 2 / math.pi)
    return math.max(0, dot(c, m)) * ggx.d(a, m) / (c[3] * (1 + ggx.lambda(a, c))) * 2 * math.pi ^ 2 * u * math.sin(theta_m)
  end)
  for _, x in ipairs(seen) do t.vndf[#t.vndf + 1] = x end
  local places, left = warp(seen, o.size), {}
  for k = 0, o.fine - 1 do
    places(k / (o.fine - 1), o.fine, function(x, y)
      local m = direction(x * x * math.pi / 2, (2 * y - 1) * math.pi + around)
      local cosine = dot(c, m)
      local z = 2 * cosine * m[3] - c[3]
      local out = { 2 * cosine * m[1] - c[1], 2 * cosine * m[2] - c[2], math.max(z, 1e-3) }
      left[#left + 1] = cosine > 0 and z > -0.2 and ggx.fresnel(o.f0, cosine) / (1 + ggx.lambda(a, out)) or 0
    end)
  end
  for _, x in ipairs(left) do t.luminance[#t.luminance + 1] = x + 1e-4 end
  for _ = 1, 3 do for _, x in ipairs(left) do t.rgb[#t.rgb + 1] = x end end
end

--- The fields of GGX: alpha a number or { along x, along y }, f0, thetas and phis (1: isotropic) of the eye, `size` of vndf,
-- `fine` of luminance and rgb, `first` and `last` azimuth.
function files.ggx_fields(o)
  o.isotropic = o.phis == 1
  if type(o.alpha) == "number" then o.alpha = { o.alpha, o.alpha } end
  local t = { phi_i = angles(o.phis, o.first or -math.pi, o.last or math.pi), size = o.size, fine = o.fine, vndf = {},
    luminance = {}, rgb = {}, theta_i = angles(o.thetas, 0, 0.49 * math.pi) }
  if o.isotropic then t.phi_i = { 0 } end
  t.ndf = over_square(o.size, o.size, function(theta, phi) return ggx.d(o.alpha, direction(theta, phi)) end)
  t.sigma = over_square(o.size, o.size, function(theta, phi)
    local w = direction(math.min(theta, 0.4999 * math.pi), phi)
    return w[3] * (1 + ggx.lambda(o.alpha, w))
  end)
  for _, phi in ipairs(t.phi_i) do
    for _, theta in ipairs(t.theta_i) do add_slice(t, o, theta, phi) end
  end
  return rgl_fields(t)
end

--- Writes bytes to a file.
function files.write(path, bytes)
  local file = assert(io.open(path, "wb"))
  file:write(bytes)
  file:close()
  return path
end

return files
