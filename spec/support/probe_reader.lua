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
  assert(text:sub(1, 8) == "\137YLMP\r\n\26" and integer(text, 8, 4) == 2)
  assert(integer(text, 12, 4) == 116 and integer(text, 24, 4) == #text)
  local h = { lo = {}, hi = {}, roots = {} }
  for a = 1, 3 do
    h.lo[a], h.hi[a] = double(text, 24 + 8 * a), double(text, 48 + 8 * a)
    h.roots[a] = integer(text, 76 + 4 * a, 4)
  end
  for i, name in ipairs { "cells", "several", "bricks", "points" } do h[name] = integer(text, 88 + 4 * i, 4) end
  h.lmax, h.bits, h.name = text:byte(109), text:byte(110), text:byte(111)
  h.names = integer(text, 112, 4)
  return h
end

local function up4(n) return math.ceil(n / 4) * 4 end

--- Leaves and split cells by their number, and where the bricks begin.
local function tree(text, h)
  local cells, up, next_child, brick = {}, {}, h.roots[1] * h.roots[2] * h.roots[3], 0
  local at = 116 + up4(h.cells)
  for i = 0, h.cells - 1 do
    local parts = text:byte(117 + i)
    local cell, of = { parts = parts, edge = 1 }, up[i] -- low corner and edge in roots
    cell.low = { i % h.roots[1], math.floor(i / h.roots[1]) % h.roots[2], math.floor(i / h.roots[1] / h.roots[2]) }
    if of then
      cell.edge = of.edge / 2
      for a = 1, 3 do cell.low[a] = of.low[a] + math.floor((i - of.child) / 2 ^ (a - 1)) % 2 * cell.edge end
    end
    if parts == 255 then
      for k = 0, 7 do up[next_child + k] = cell end
      cell.child, next_child = next_child, next_child + 8
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
  return cells, up4(at)
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

local BESIDE = { 0, 0, 2, 0, 4, 4, 6 } -- a corner's number without its lowest bit

--- The points of bricks' corners, [brick][corner] from 0: a number, or a list of those that it is the mean of; and where
--- points begin.
local function corners(text, h, cells, at)
  local last, list, read, names, means = {}, {}, 0, at + up4(h.bricks), {}
  local function name()
    read = read + 1
    return bits_of(text, names, (read - 1) * h.name, h.name)
  end
  local function point(n) return n < h.points and n or assert(means[n - h.points - 1]) end
  local function named()
    local n = name()
    if n ~= h.points and n ~= h.points + 1 then return point(n) end
    local mean = {}
    for i = 1, n == h.points and 2 or 4 do mean[i] = point(name()) end
    means[#means + 1] = mean
    return mean
  end
  for i = 0, #cells do
    local cell = cells[i]
    for b = 0, cell.brick and cell.parts - 1 or -1 do
      local brick = cell.brick + b
      local mask = text:byte(at + brick + 1)
      list[brick] = {}
      for k = 0, 7 do
        local x = {}
        for a = 1, 3 do x[a] = cell.low[a] + math.floor(k / 2 ^ (a - 1)) % 2 * cell.edge end
        local place = table.concat(x, " ")
        local own = place .. " " .. b
        local p = math.floor(mask / 2 ^ k) % 2 == 1 and named()
          or assert(last[own] or last[place] or list[brick][BESIDE[k]])
        list[brick][k], last[place], last[own] = p, p, p
      end
    end
  end
  assert(read == h.names)
  return list, names + up4(math.ceil(h.names * h.name / 8))
end

function reader.of(text)
  local h = header(text)
  local cells, masks = tree(text, h)
  local count = (h.lmax + 1) ^ 2
  local bricks, points = corners(text, h, cells, masks)
  local size = math.ceil((16 + 3 * count * h.bits) / 8)
  local function number(point, j)
    local at = points + size * point
    return signed(bits_of(text, at + 2, h.bits * j, h.bits), h.bits) * 2 ^ ((integer(text, at, 2) - 32768) / 512)
  end
  local function add(E, w, Y, point)
    if type(point) == "table" then
      for _, p in ipairs(point) do add(E, w / #point, Y, p) end
      return
    end
    for j = 0, 3 * count - 1 do E[j % 3 + 1] = E[j % 3 + 1] + w * Y[math.floor(j / 3) + 1] * number(point, j) end
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
    local found = { cell = cell, low = low, edge = edge, at = u, roots = h.roots, bounds = { h.lo, h.hi } }
    if cell.parts == 0 then return E, found end
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
      if w > 0 then add(E, w, Y, bricks[brick][corner]) end
    end
    for c = 1, 3 do E[c] = math.max(0, E[c]) end
    return E, found
  end
end

return reader
