--- Regular lattices of the light of a field in L2, as engines keep them: halves, R11G11B10F with bytes, ZH3; their bytes and the
-- irradiance that they say.

local ylm = require "ylm"

local lattices = {}

local COUNT = 9
local COSINE = { math.pi, 2 * math.pi / 3, 2 * math.pi / 3, 2 * math.pi / 3, math.pi / 4, math.pi / 4, math.pi / 4, math.pi / 4,
  math.pi / 4 }
local LUMINANCE = { 0.2126, 0.7152, 0.0722 }

--- Irradiance [n][3] by coefficients f(i, channel, k) of light at n normals.
function lattices.irradiance(f, normals)
  local Y, out = ylm.sh.eval(2, ylm.array(normals)), {}
  for i = 1, #normals do
    local e = { 0, 0, 0 }
    for k = 1, COUNT do
      local w = COSINE[k] * Y:get(i, k)
      for c = 1, 3 do e[c] = e[c] + w * f(i, c, k) end
    end
    out[i] = e
  end
  return out
end

--- The mean of the rows around a point that are known; nil: none is.
local function mean_around(rows, known, cells, i)
  local step, sum, n = { 1, cells[1] + 1, (cells[1] + 1) * (cells[2] + 1) }, { {}, {}, {} }, 0
  local at = { (i - 1) % step[2], math.floor((i - 1) / step[2]) % (cells[2] + 1), math.floor((i - 1) / step[3]) }
  for near = 0, 26 do
    local other, inside = i, true
    for a = 1, 3 do
      local d = math.floor(near / 3 ^ (a - 1)) % 3 - 1
      inside = inside and at[a] + d >= 0 and at[a] + d <= cells[a]
      other = other + d * step[a]
    end
    if inside and known[other] then
      n = n + 1
      for c = 1, 3 do for k = 1, COUNT do sum[c][k] = (sum[c][k] or 0) + rows[other][c][k] end end
    end
  end
  for c = 1, 3 do for k = 1, n > 0 and COUNT or 0 do sum[c][k] = sum[c][k] / n end end
  return n > 0 and sum or nil
end

--- Points in walls take the mean of the points around them that are in none, as engines do, in three rounds.
local function fill(rows, cells, validity)
  local known = {}
  for i = 1, #rows do known[i] = validity[i] > 0.5 end
  for _ = 1, 3 do
    local more = {}
    for i = 1, #rows do more[i] = not known[i] and mean_around(rows, known, cells, i) or nil end
    for i, row in pairs(more) do rows[i], known[i] = row, true end
  end
end

local INSET = 0.02 -- scene units, of the outermost points from the box, whose faces are walls

--- A lattice of a spacing in a box: rows [point][channel][k] of the field.
function lattices.of(field, around, spacing)
  local cells, size, points, box = {}, {}, {}, { {}, {} }
  for a = 1, 3 do box[1][a], box[2][a] = around[1][a] + INSET, around[2][a] - INSET end
  for a = 1, 3 do
    cells[a] = math.max(1, math.floor((box[2][a] - box[1][a]) / spacing + 0.5))
    size[a] = (box[2][a] - box[1][a]) / cells[a]
  end
  for z = 0, cells[3] do
    for y = 0, cells[2] do
      for x = 0, cells[1] do
        points[#points + 1] = { box[1][1] + x * size[1], box[1][2] + y * size[2], box[1][3] + z * size[3] }
      end
    end
  end
  points = ylm.array(points, "double")
  local value, rows = assert(ylm.light_field(2, field, points)), {}
  for i = 1, #points do
    local row = {}
    for c = 1, 3 do
      row[c] = {}
      for k = 1, COUNT do row[c][k] = value:get(i, c, k) end
    end
    rows[i] = row
  end
  fill(rows, cells, field:validity(points))
  return { box = box, cells = cells, size = size, rows = rows }
end

--- A number above 0 rounded to so many bits behind its first.
local function rounded(x, bits)
  if not (x > 0) then return 0 end
  local unit = 2 ^ (math.floor(math.log(x) / math.log(2)) - bits)
  return math.floor(x / unit + 0.5) * unit
end

local function signed(x, bits) return x < 0 and -rounded(-x, bits) or rounded(x, bits) end

--- The largest that a coefficient of light of mean coefficient 1 can be: light from one direction.
local MOST = { 1, math.sqrt(3), math.sqrt(3), math.sqrt(3), 1.9365, 1.9365, 2.2361, 1.9365, 1.9365 }

--- The degree 2 of a row as lobes about the axis of its luminance's degree 1: what ZH3 keeps is one number a channel.
local function by_axis(row)
  local function lum(k) return LUMINANCE[1] * row[1][k] + LUMINANCE[2] * row[2][k] + LUMINANCE[3] * row[3][k] end
  local axis = { -lum(4), -lum(2), lum(3) } -- of the convention: Y(1, -1 .. 1) are -y, z, -x
  local length = math.sqrt(axis[1] ^ 2 + axis[2] ^ 2 + axis[3] ^ 2)
  if length == 0 then axis, length = { 0, 0, 1 }, 1 end
  local Y, square, out = ylm.sh.eval(2, ylm.array { { axis[1] / length, axis[2] / length, axis[3] / length } }), 0, {}
  for k = 5, 9 do square = square + Y:get(1, k) ^ 2 end
  for c = 1, 3 do
    local dot = 0
    for k = 5, 9 do dot = dot + row[c][k] * Y:get(1, k) / square end
    out[c] = { row[c][1], row[c][2], row[c][3], row[c][4] }
    for k = 5, 9 do out[c][k] = signed(dot, 10) * Y:get(1, k) end
  end
  return out
end

--- Layouts: { name, bytes a point, what a row is read as }.
lattices.layouts = {
  { "L2 in halves", 54, function(row)
    local out = {}
    for c = 1, 3 do
      out[c] = {}
      for k = 1, COUNT do out[c][k] = signed(row[c][k], 10) end
    end
    return out
  end },
  { "R11G11B10F and 24 bytes", 28, function(row)
    local out = {}
    for c = 1, 3 do
      local mean = rounded(row[c][1], c == 3 and 5 or 6)
      out[c] = { mean }
      for k = 2, COUNT do
        local x = mean > 0 and row[c][k] / mean / MOST[k] or 0
        out[c][k] = mean * MOST[k] * math.floor(127 * math.max(-1, math.min(1, x)) + 0.5) / 127
      end
    end
    return out
  end },
  { "ZH3 in halves", 30, function(row)
    local out = by_axis(row)
    for c = 1, 3 do for k = 1, 4 do out[c][k] = signed(out[c][k], 10) end end
    return out
  end },
}

--- Irradiance at places with normals, from the eight points around each, linearly; by: a layout.
function lattices.look(lattice, by, places, normals)
  local read, at = {}, {}
  local function row(i)
    read[i] = read[i] or by[3](lattice.rows[i])
    return read[i]
  end
  for n, p in ipairs(places) do
    local base, t = {}, {}
    for a = 1, 3 do
      local x = (p[a] - lattice.box[1][a]) / lattice.size[a]
      base[a] = math.max(0, math.min(lattice.cells[a] - 1, math.floor(x)))
      t[a] = math.max(0, math.min(1, x - base[a]))
    end
    local sum = {}
    for c = 1, 3 do sum[c] = { 0, 0, 0, 0, 0, 0, 0, 0, 0 } end
    for corner = 0, 7 do
      local w, index, stride = 1, 1, 1
      for a = 1, 3 do
        local upper = math.floor(corner / 2 ^ (a - 1)) % 2
        w = w * (upper == 1 and t[a] or 1 - t[a])
        index, stride = index + stride * (base[a] + upper), stride * (lattice.cells[a] + 1)
      end
      local r = row(index)
      for c = 1, 3 do for k = 1, COUNT do sum[c][k] = sum[c][k] + w * r[c][k] end end
    end
    at[n] = sum
  end
  return lattices.irradiance(function(i, c, k) return at[i][c][k] end, normals)
end

return lattices
