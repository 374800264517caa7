--- Pages as the specs read them: a second decoder of what lua/ylm/page writes, which shares nothing with the viewer.

local browser = require "spec.support.browser"
local codec = require "ylm.c.codec"
local json = require "spec.support.json"
local scratch = require "spec.support.scratch"

local page = {}

local sizes = { u8 = 1, i8 = 1, u16 = 2, i16 = 2, f16 = 2, u32 = 4, f32 = 4 }

--- A number from its bytes, lowest first.
local function number(kind, bytes)
  local x = 0
  for i = #bytes, 1, -1 do x = x * 256 + bytes[i] end
  local bits = 8 * #bytes
  if kind == "f16" or kind == "f32" then
    local mantissa, exponents = kind == "f16" and 10 or 23, kind == "f16" and 32 or 256
    local sign = x >= 2 ^ (bits - 1) and -1 or 1
    local rest = x % 2 ^ (bits - 1)
    local e, m = math.floor(rest / 2 ^ mantissa), rest % 2 ^ mantissa
    local least = 2 - exponents / 2
    if e == 0 then return sign * m * 2 ^ (least - mantissa) end
    if e == exponents - 1 then return m > 0 and 0 / 0 or sign * math.huge end
    return sign * (1 + m / 2 ^ mantissa) * 2 ^ (e - 1 + least)
  end
  if kind:sub(1, 1) == "i" and x >= 2 ^ (bits - 1) then x = x - 2 ^ bits end
  return x
end

--- The numbers of a section, row by row, as a flat list.
local function numbers_of(section, bytes)
  local size = sizes[section.type]
  local n = section.shape[1] * section.shape[2]
  if section.coding:find "zlib" then bytes = assert(codec.inflate(bytes, n * size)) end
  assert(#bytes == n * size, section.name)
  local columns, list, before = section.shape[2], {}, {}
  local delta = section.coding:find "delta"
  for i = 1, n do
    local raw, carry = {}, 0
    for b = 1, size do
      local x = bytes:byte((b - 1) * n + i) + carry
      if delta and i > columns then x = x + before[(i - 1) % columns + 1][b] end
      raw[b], carry = x % 256, math.floor(x / 256)
    end
    before[(i - 1) % columns + 1] = raw
    list[i] = number(section.type, raw)
  end
  return list
end

--- { text, meta, sections: name -> list of numbers } of a page.
function page.read(path)
  local text = scratch.text(path)
  local meta = json.read(text:match '<script id="meta" type="application/json">(.-)</script>')
  local blob, at, sections = browser.decoded(text:match '<script id="data" type="text/plain">(.-)</script>'), 1, {}
  for _, section in ipairs(meta.sections) do
    sections[section.name] = numbers_of(section, blob:sub(at, at + section.bytes - 1))
    at = at + section.bytes
  end
  return { text = text, meta = meta, sections = sections, left = #blob - at + 1 }
end

--- The leaf at lattice coordinates, zero-based, and the cell whose corners are interpolated there.
local function leaf_at(p, at)
  local cells, meta, cell, whole = p.sections.cells, p.meta, 0, nil
  local q = {}
  for a = 1, 3 do q[a] = math.min(math.max(math.floor(at[a]), 0), meta.resolution[a] - 1) end
  if meta.kind == "uniform" then
    cell = p.sections.table[(q[3] * meta.resolution[2] + q[2]) * meta.resolution[1] + q[1] + 1]
    return cell, cell
  end
  while true do
    local level = cells[12 * cell + 2] % 256
    local flags = math.floor(cells[12 * cell + 2] / 65536)
    if math.floor(cells[12 * cell + 2] / 256) % 2 == 1 then whole = cell end
    if cells[12 * cell + 1] == 0 or math.floor(flags / 64) % 2 == 1 then return cell, whole end
    local edge, octant = 2 ^ (meta.depth - level - 1), 0
    for a = 3, 1, -1 do octant = 2 * octant + math.floor(q[a] / edge) % 2 end
    cell = cells[12 * cell + 1] + octant
  end
end

--- { lowest = , edge = } of a cell in lattice coordinates.
local function box_of(p, cell)
  local w, u, c = p.sections.cells[12 * cell + 2], p.sections.cells[12 * cell + 3], p.sections.cells[12 * cell + 4]
  return { lowest = { u % 65536, math.floor(u / 65536), c % 65536 },
    edge = p.meta.kind == "uniform" and 1 or 2 ^ (p.meta.depth - w % 256) }
end

--- The cell of the part of a leaf that a surface at lattice coordinates sees; nil: none. And whether it was not in front.
local function part_at(p, leaf, at, normal)
  local sides, from, box, meta = p.sections.sides, p.sections.cells[12 * leaf + 1], box_of(p, leaf), p.meta
  local first, parts = sides[from + 1], sides[from + 2]
  if parts < 2 then return parts == 1 and first or nil end
  local function part_of(piece) return math.floor(sides[from + 3 + math.floor(piece / 8)] / 16 ^ (piece % 8)) % 16 end
  local thick, front = 0, {}
  for a = 1, 3 do thick = thick + 0.75 / 4 * math.abs(normal[a]) * meta.unit[a] * box.edge end
  for _, way in ipairs { 1, 1.7, 0.5 } do
    local piece = 0
    for a = 3, 1, -1 do
      local x = (at[a] - box.lowest[a]) / box.edge + way * thick * normal[a] / (meta.unit[a] * box.edge)
      if way == 1 then front[a] = x end
      piece = 6 * piece + math.min(math.max(math.floor(4 * x) + 1, 0), 5)
    end
    if part_of(piece) ~= 15 then return first + part_of(piece) end
  end
  local best, least = nil, math.huge
  for piece = 0, 215 do
    local d = 0
    for a = 1, 3 do
      local x = (math.floor(piece / 6 ^ (a - 1)) % 6 - 0.5) / 4
      d = d + ((x - front[a]) * meta.unit[a] * box.edge) ^ 2
    end
    if part_of(piece) ~= 15 and d < least then best, least = part_of(piece), d end
  end
  return first + best, true
end

--- Coefficients [channels * count] that a page of a grid with sides has at a place on a surface, where no cell that continuity
-- alone needs is on the way; a list, or nil, and whether the part was the nearest one's.
function page.light(p, place, normal)
  local meta, at, out = p.meta, {}, {}
  for a = 1, 3 do at[a] = (place[a] - meta.bounds[a]) / meta.unit[a] end
  local leaf, cell = leaf_at(p, at)
  local near
  if math.floor(p.sections.cells[12 * leaf + 2] / 65536 / 64) % 2 == 1 then cell, near = part_at(p, leaf, at, normal) end
  if not cell then return nil end
  local box, width = box_of(p, cell), meta.channels * (meta.lmax + 1) ^ 2
  for i = 1, width do out[i] = 0 end
  for k = 0, 7 do
    local weight, point = 2 ^ -meta.exponent, p.sections.cells[12 * cell + 5 + k]
    if point >= meta.counts.evaluated then return nil end
    for a = 1, 3 do
      local t = math.min(math.max((at[a] - box.lowest[a]) / box.edge, 0), 1)
      weight = weight * (math.floor(k / 2 ^ (a - 1)) % 2 == 1 and t or 1 - t)
    end
    for i = 1, width do out[i] = out[i] + weight * p.sections.rows[4 * (point * width + i - 1) + 1] end
  end
  return out, near
end

return page
