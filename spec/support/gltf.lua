-- glTF files for specs: gltf.write(folder, name, parts) writes what specs describe in tables, as .gltf with data URIs or as .glb.

local json = require "ylm.gltf.json"

local gltf = {}

local alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"

--- Bytes as base64.
function gltf.base64(s)
  local out = {}
  for i = 1, #s, 3 do
    local a, b, c = s:byte(i, i + 2)
    local word = a * 65536 + (b or 0) * 256 + (c or 0)
    for k = 3, 0, -1 do
      local d = math.floor(word / 64 ^ k) % 64
      out[#out + 1] = (k == 1 and not b or k == 0 and not c) and "=" or alphabet:sub(d + 1, d + 1)
    end
  end
  return table.concat(out)
end

--- An integer of n bytes, little-endian.
function gltf.integer(x, n)
  local out = {}
  if x < 0 then x = x + 256 ^ n end
  for i = 1, n do out[i], x = string.char(x % 256), math.floor(x / 256) end
  return table.concat(out)
end

--- A number of 32 bits.
function gltf.float(x)
  if x == 0 then return "\0\0\0\0" end
  if x ~= x then return gltf.integer(0x7fc00000, 4) end
  if x == math.huge then return gltf.integer(0x7f800000, 4) end
  local mantissa, exponent = math.abs(x), 0
  while mantissa >= 2 do mantissa, exponent = mantissa / 2, exponent + 1 end
  while mantissa < 1 do mantissa, exponent = mantissa * 2, exponent - 1 end
  local bits = (exponent + 127) * 2 ^ 23 + math.floor((mantissa - 1) * 2 ^ 23 + 0.5)
  return gltf.integer(bits + (x < 0 and 2 ^ 31 or 0), 4)
end

local writers = {
  [5120] = function(x) return gltf.integer(x, 1) end,
  [5121] = function(x) return gltf.integer(x, 1) end,
  [5122] = function(x) return gltf.integer(x, 2) end,
  [5123] = function(x) return gltf.integer(x, 2) end,
  [5125] = function(x) return gltf.integer(x, 4) end,
  [5126] = gltf.float,
}

--- Numbers as bytes of a component type.
function gltf.bytes(component, list)
  local out = {}
  for i, x in ipairs(list) do out[i] = writers[component](x) end
  return table.concat(out)
end

--- A PNG file of 8-bit RGBA, not compressed; f(x, y) -> r, g, b, a. `there`: rows that it has in the end, or nil: all.
function gltf.png(width, height, f, there)
  local rows = {}
  for y = 1, there or height do
    rows[#rows + 1] = "\0"
    for x = 1, width do rows[#rows + 1] = string.char(f(x, y)) end
  end
  local raw, a, b = table.concat(rows), 1, 0
  for i = 1, #raw do
    a = (a + raw:byte(i)) % 65521
    b = (b + a) % 65521
  end
  local function big(x) return gltf.integer(x, 4):reverse() end
  local function xor(x, y)
    local out, bit = 0, 1
    while x > 0 or y > 0 do
      if x % 2 ~= y % 2 then out = out + bit end
      x, y, bit = math.floor(x / 2), math.floor(y / 2), 2 * bit
    end
    return out
  end
  local function chunk(name, data)
    local crc, all = 0xffffffff, name .. data
    for i = 1, #all do
      crc = xor(crc, all:byte(i))
      for _ = 1, 8 do crc = crc % 2 == 1 and xor(math.floor(crc / 2), 0xedb88320) or math.floor(crc / 2) end
    end
    return big(#data) .. name .. data .. big(0xffffffff - crc)
  end
  local stored = "\120\1\1" .. gltf.integer(#raw, 2) .. gltf.integer(65535 - #raw, 2) .. raw .. big(b * 65536 + a)
  return "\137PNG\r\n\26\n" .. chunk("IHDR", big(width) .. big(height) .. "\8\6\0\0\0") .. chunk("IDAT", stored)
    .. chunk("IEND", "")
end

--- An object of JSON from a table with names, in the order of the names.
function gltf.object(t)
  if type(t) ~= "table" or t.keys then return t end
  if #t > 0 or next(t) == nil then
    local list = {}
    for i, x in ipairs(t) do list[i] = gltf.object(x) end
    return list
  end
  local names, keys = {}, {}
  for name in pairs(t) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do keys[#keys + 1], keys[#keys + 2] = name, gltf.object(t[name]) end
  return { keys = keys }
end

--- A file whose parts are added: f:accessor("VEC3", 5126, numbers) returns its number; f:json(more), f:text(more),
-- f:binary(more) are its texts.
local methods = {}
methods.__index = methods

function gltf.new()
  return setmetatable({ data = "", views = {}, accessors = {} }, methods)
end

--- A view of these bytes; its number from 0.
function methods:view(bytes, stride)
  self.data = self.data .. ("\0"):rep(-#self.data % 4)
  self.views[#self.views + 1] = { buffer = 0, byteOffset = #self.data, byteLength = #bytes, byteStride = stride }
  self.data = self.data .. bytes
  return #self.views - 1
end

local widths = { SCALAR = 1, VEC2 = 2, VEC3 = 3, VEC4 = 4 }

--- An accessor of these numbers; its number from 0. `more`: other entries.
function methods:accessor(kind, component, list, more)
  local a = { type = kind, componentType = component, count = #list / widths[kind] }
  if #list > 0 then a.bufferView = self:view(gltf.bytes(component, list)) end
  for key, x in pairs(more or {}) do a[key] = x end
  self.accessors[#self.accessors + 1] = a
  return #self.accessors - 1
end

--- The JSON with `more` beside buffers, views and accessors. `uri`: of the buffer, or nil.
function methods:json(more, uri)
  local all = { asset = { version = "2.0" }, buffers = { { byteLength = #self.data, uri = uri } }, bufferViews = self.views,
    accessors = self.accessors }
  if #self.data == 0 then all.buffers, all.bufferViews = nil, nil end
  if #self.accessors == 0 then all.accessors = nil end
  for key, x in pairs(more or {}) do all[key] = x end
  return json.write(gltf.object(all))
end

function methods:text(more) return self:json(more, "data:application/octet-stream;base64," .. gltf.base64(self.data)) end

--- The bytes of a .glb file.
function gltf.container(text, data)
  text = text .. (" "):rep(-#text % 4)
  local chunks = gltf.integer(#text, 4) .. "JSON" .. text
  if data and #data > 0 then
    data = data .. ("\0"):rep(-#data % 4)
    chunks = chunks .. gltf.integer(#data, 4) .. "BIN\0" .. data
  end
  return "glTF" .. gltf.integer(2, 4) .. gltf.integer(12 + #chunks, 4) .. chunks
end

function methods:binary(more) return gltf.container(self:json(more), self.data) end

return gltf
