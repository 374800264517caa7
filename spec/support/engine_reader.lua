--- Files of probes as engines read them: reader.of(path) -> { read(points, normals) -> irradiance [n][3], bytes }. Nothing of
--- ylm's exporter is used.

local ylm = require "ylm"

local reader = {}

local A = { math.pi, 2 * math.pi / 3, 2 * math.pi / 3, 2 * math.pi / 3 }
for k = 5, 9 do A[k] = math.pi / 4 end

--- The half in a text whose low byte is at `at`.
function reader.half(text, at)
  local low, high = text:byte(at, at + 1)
  local bits = low + 256 * high
  local sign, exponent, mantissa = bits >= 32768 and -1 or 1, math.floor(bits / 1024) % 32, bits % 1024
  if exponent == 0 then return sign * mantissa * 2 ^ -24 end
  return sign * (1 + mantissa / 1024) * 2 ^ (exponent - 15)
end

--- The bytes that base64 stands for.
function reader.decoded(text)
  local digits, out = {}, {}
  for i, c in ipairs { ("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"):byte(1, -1) } do digits[c] = i - 1 end
  for i = 1, #text, 4 do
    local x, pad = 0, 0
    for k = i, i + 3 do
      local d = digits[text:byte(k)]
      x, pad = 64 * x + (d or 0), pad + (d and 0 or 1)
    end
    out[#out + 1] = string.char(math.floor(x / 65536), math.floor(x / 256) % 256, x % 256):sub(1, 3 - pad)
  end
  return table.concat(out)
end

--- A place in cells of a box: the lower middle, and the part of the way to the next, along each axis.
local function between(lo, hi, cells, p, n, offset)
  local low, part = {}, {}
  for a = 1, 3 do
    local h = (hi[a] - lo[a]) / cells[a]
    local x = math.max(0, math.min(cells[a] - 1, (p[a] + offset * h * n[a] - lo[a]) / h - 0.5))
    low[a] = math.min(cells[a] - 2, math.floor(x))
    part[a] = x - low[a]
  end
  return low, part
end

--- three.js' LightProbeGrid (0.187): half a cell off the surface; the last grid that holds that place, to 1 % of a cell, answers;
-- nine coefficients, at least 0. Grids are { lo, hi, cells, probe(x, y, z) -> [27] numbers, a coefficient's channels beside each
-- other }.
function reader.three(grids)
  local function holds(g, p, n)
    for a = 1, 3 do
      local h = (g.hi[a] - g.lo[a]) / g.cells[a]
      local x = p[a] + 0.5 * h * n[a]
      if x < g.lo[a] - 0.01 * h or x > g.hi[a] + 0.01 * h then return false end
    end
    return true
  end
  local function look(g, p, n, Y)
    local low, part = between(g.lo, g.hi, g.cells, p, n, 0.5)
    local E = { 0, 0, 0 }
    for corner = 0, 7 do
      local w, at = 1, {}
      for a = 1, 3 do
        local up = math.floor(corner / 2 ^ (a - 1)) % 2
        w, at[a] = w * (up == 1 and part[a] or 1 - part[a]), low[a] + up
      end
      local v = w > 0 and g.probe(at[1], at[2], at[3])
      for k = 1, v and 9 or 0 do
        -- its functions of odd order have the other sign
        local m = k - 1 - math.floor(math.sqrt(k - 1)) * (math.floor(math.sqrt(k - 1)) + 1)
        local y = w * A[k] * Y[k] * (m % 2 == 0 and 1 or -1)
        for c = 1, 3 do E[c] = E[c] + y * v[3 * (k - 1) + c] end
      end
    end
    for c = 1, 3 do E[c] = math.max(0, E[c]) end
    return E
  end
  return function(points, normals)
    local Y = ylm.sh.eval(2, ylm.array(normals)):totable()
    local out = {}
    for i, p in ipairs(points) do
      local found
      for _, g in ipairs(grids) do if holds(g, p, normals[i]) then found = g end end
      out[i] = found and look(found, p, normals[i], Y[i]) or { 0, 0, 0 }
    end
    return out
  end
end

--- A grid of a .three.json file.
local function grid_of(text)
  --- Three numbers by name.
  local function triple(name)
    local x, y, z = text:match('"' .. name .. '":%[([^,]+),([^,]+),([^%]]+)%]')
    return { tonumber(x), tonumber(y), tonumber(z) }
  end
  local data, cells, known = reader.decoded(text:match '"data":"([^"]*)"'), triple "resolution", {}
  local function probe(x, y, z)
    local key = (z * cells[2] + y) * cells[1] + x
    if known[key] then return known[key] end
    local v = {}
    for k = 0, 26 do
      local slice = math.floor(k / 4) * (cells[3] + 2) + z + 1
      local at = 2 * (4 * ((slice * cells[2] + y) * cells[1] + x) + k % 4)
      v[k + 1] = reader.half(data, at + 1)
    end
    known[key] = v
    return v
  end
  return { lo = triple "min", hi = triple "max", cells = cells, probe = probe }
end

--- All grids of a .three.json file.
local function three_json(text)
  local grids = {}
  for one in text:gmatch '{"type":"LightProbeGrid",.-"validity":"[^"]*"}' do grids[#grids + 1] = grid_of(one) end
  return reader.three(grids)
end

function reader.of(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  return { read = three_json(text), bytes = #text }
end

return reader
