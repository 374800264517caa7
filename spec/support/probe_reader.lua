--- '.ylmp' as docs/engines.md describes it, in plain Lua: reader.of(text) -> look(point, normal) -> irradiance { red, green,
--- blue }. Nothing of ylm is used.

local reader = {}

--- An unsigned integer of so many bytes, the low one first, from offset `at`.
local function integer(text, at, bytes)
  local x = 0
  for i = bytes, 1, -1 do x = x * 256 + text:byte(at + i) end
  return x
end

local function signed(x, bits) return x >= 2 ^ (bits - 1) and x - 2 ^ bits or x end

local function double(text, at)
  local low, high = integer(text, at, 4), integer(text, at + 4, 4)
  local sign, exponent, mantissa = high >= 2 ^ 31 and -1 or 1, math.floor(high / 2 ^ 20) % 2048, high % 2 ^ 20 * 2 ^ 32 + low
  if exponent == 0 then return sign * mantissa * 2 ^ -1074 end
  return sign * (1 + mantissa * 2 ^ -52) * 2 ^ (exponent - 1023)
end

--- An integer of so many bits from bit `from` after offset `at`, the low bit first.
local function bits_of(text, at, from, bits)
  local x = 0
  for i = bits - 1, 0, -1 do
    local bit = from + i
    x = 2 * x + math.floor(text:byte(at + math.floor(bit / 8) + 1) / 2 ^ (bit % 8)) % 2
  end
  return x
end

local function header(text)
  assert(text:sub(1, 8) == "\137YLMP\r\n\26" and integer(text, 8, 4) == 1 and integer(text, 24, 4) == #text)
  local h = { lo = {}, hi = {}, roots = {} }
  for a = 1, 3 do
    h.lo[a], h.hi[a] = double(text, 24 + 8 * a), double(text, 48 + 8 * a)
    h.roots[a] = integer(text, 76 + 4 * a, 4)
  end
  for i, name in ipairs { "cells", "several", "bricks", "points" } do h[name] = integer(text, 88 + 4 * i, 4) end
  h.lmax, h.bits, h.index = text:byte(109), text:byte(110), text:byte(111)
  return h
end

local function up4(n) return math.ceil(n / 4) * 4 end

--- Leaves and split cells by their number, and where the bricks begin.
local function tree(text, h)
  local cells, next_child, brick = {}, h.roots[1] * h.roots[2] * h.roots[3], 0
  local at = 112 + up4(h.cells)
  for i = 0, h.cells - 1 do
    local parts = text:byte(113 + i)
    local cell = { parts = parts }
    if parts == 255 then cell.child, next_child = next_child, next_child + 8
    else cell.brick, brick = brick, brick + parts end
    if parts > 1 and parts < 255 then
      local n = text:byte(at + 1)
      cell.planes, cell.part = {}, {}
      for k = 1, n do
        local from = at + 1 + 5 * (k - 1)
        cell.planes[k] = { signed(integer(text, from, 1), 8), signed(integer(text, from + 1, 1), 8),
          signed(integer(text, from + 2, 1), 8), signed(integer(text, from + 3, 2), 16) }
      end
      for side = 0, 2 ^ n - 1 do cell.part[side] = bits_of(text, at + 1 + 5 * n, 4 * side, 4) end
      at = at + 1 + 5 * n + 2 ^ n / 2
    end
    cells[i] = cell
  end
  return cells, 112 + up4(at - 112)
end

local function leaf(h, cells, u)
  local low, i, stride = {}, 0, 1
  for a = 1, 3 do
    low[a] = math.max(0, math.min(h.roots[a] - 1, math.floor(u[a])))
    i, stride = i + stride * low[a], stride * h.roots[a]
  end
  local cell, edge = cells[i], 1
  while cell.child do
    local k = 0
    edge = edge / 2
    for a = 1, 3 do
      if u[a] >= low[a] + edge then low[a], k = low[a] + edge, k + 2 ^ (a - 1) end
    end
    cell = cells[cell.child + k]
  end
  return cell, low, edge
end

local function basis(n)
  local x, y, z = n[1], n[2], n[3]
  return { 1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y }
end

function reader.of(text)
  local h = header(text)
  local cells, bricks = tree(text, h)
  local points, count = bricks + up4(8 * h.index * h.bricks), (h.lmax + 1) ^ 2
  local size = math.ceil((16 + 3 * count * h.bits) / 8)
  local function number(point, j)
    local at = points + size * point
    return signed(bits_of(text, at + 2, h.bits * j, h.bits), h.bits) * 2 ^ ((integer(text, at, 2) - 32768) / 512)
  end
  return function(p, n)
    local u, q, thick = {}, {}, 0
    for a = 1, 3 do u[a] = math.max(0, math.min(1, (p[a] - h.lo[a]) / (h.hi[a] - h.lo[a]))) * h.roots[a] end
    local _, _, edge = leaf(h, cells, u)
    for a = 1, 3 do thick = thick + 3 / 16 * edge * math.abs(n[a]) * (h.hi[a] - h.lo[a]) / h.roots[a] end
    for a = 1, 3 do q[a] = u[a] + thick * n[a] / (h.hi[a] - h.lo[a]) * h.roots[a] end
    local cell, low
    cell, low, edge = leaf(h, cells, q)
    local E, Y = { 0, 0, 0 }, basis(n)
    if cell.parts == 0 then return E end
    local side = 0
    for k, plane in ipairs(cell.planes or {}) do
      local height = 0
      for a = 1, 3 do height = height + plane[a] / 127 * (q[a] - low[a]) / edge end
      if height >= plane[4] / 8192 then side = side + 2 ^ (k - 1) end
    end
    local brick = cell.brick + (cell.part and cell.part[side] or 0)
    for corner = 0, 7 do
      local w = 1
      for a = 1, 3 do
        local t = math.max(0, math.min(1, (u[a] - low[a]) / edge))
        w = w * (math.floor(corner / 2 ^ (a - 1)) % 2 == 1 and t or 1 - t)
      end
      local point = integer(text, bricks + h.index * (8 * brick + corner), h.index)
      for j = 0, w > 0 and 3 * count - 1 or -1 do
        E[j % 3 + 1] = E[j % 3 + 1] + w * Y[math.floor(j / 3) + 1] * number(point, j)
      end
    end
    for c = 1, 3 do E[c] = math.max(0, E[c]) end
    return E
  end
end

return reader
