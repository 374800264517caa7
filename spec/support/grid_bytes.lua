--- Grid files of version 2 taken apart, changed and sealed again with checksums that fit: forged files.
--
--     local file = bytes.open(core.grid_encode(grid))
--     file:put("cells", 12, bytes.u32(1))      -- from byte 12 of the section
--     file.section.births.required = false
--     core.grid_decode(file:seal())

local bytes = {}
bytes.__index = bytes

--- A whole number as `size` bytes, lowest first.
local function little(x, size)
  local out = {}
  for i = 1, size do out[i], x = string.char(x % 256), math.floor(x / 256) end
  return table.concat(out)
end
function bytes.u32(x) return little(x, 4) end
function bytes.u64(x) return little(x, 8) end

local function number(text, at, size)
  local x = 0
  for i = size, 1, -1 do x = x * 256 + text:byte(at + i) end
  return x
end

--- a xor b of bytes, by their nibbles: Lua 5.1 has no such operator.
local nibbles = {}
for a = 0, 15 do
  for b = 0, 15 do
    local x, bit = 0, 1
    for i = 0, 3 do
      if math.floor(a / 2 ^ i) % 2 ~= math.floor(b / 2 ^ i) % 2 then x = x + bit end
      bit = bit * 2
    end
    nibbles[16 * a + b] = x
  end
end
local function xor(a, b)
  local low, high = a % 16, b % 16
  return 16 * nibbles[16 * ((a - low) / 16) + (b - high) / 16] + nibbles[16 * low + high]
end

--- Byte -> the eight bytes (lowest first) that it adds to the remainder of CRC-64/XZ.
local steps = {}
for i = 0, 255 do
  local c = { i, 0, 0, 0, 0, 0, 0, 0 }
  for _ = 1, 8 do
    local odd, carry = c[1] % 2 == 1, 0
    for k = 8, 1, -1 do
      local low = c[k] % 2
      c[k], carry = (c[k] - low) / 2 + 128 * carry, low
    end
    if odd then
      for k, p in ipairs { 0x42, 0x0F, 0x87, 0xD7, 0x95, 0x57, 0x6C, 0xC9 } do c[k] = xor(c[k], p) end
    end
  end
  steps[i] = c
end

--- The checksum of a string, as its eight bytes.
function bytes.crc(text)
  local c = { 255, 255, 255, 255, 255, 255, 255, 255 }
  for i = 1, #text do
    local step = steps[xor(c[1], text:byte(i))]
    for k = 1, 7 do c[k] = xor(c[k + 1], step[k]) end
    c[8] = step[8]
  end
  for k = 1, 8 do c[k] = string.char(xor(c[k], 255)) end
  return table.concat(c)
end

--- The sections of a file, by name and in order.
function bytes.open(text)
  local file = setmetatable({ version = number(text, 12, 4), section = {} }, bytes)
  for i = 1, number(text, 24, 4) do
    local at = 64 * i
    local s = { name = text:sub(at + 1, at + 24):match "^%Z*", offset = number(text, at + 24, 8),
      size = number(text, at + 32, 8), record = number(text, at + 40, 4), required = number(text, at + 44, 4) == 1,
      crc = text:sub(at + 49, at + 56) }
    s.data = text:sub(s.offset + 1, s.offset + s.size)
    s.summed = s.data
    file[i], file.section[s.name] = s, s
  end
  return file
end

--- Replaces the bytes of a section from `at` (0: its first) on.
function bytes:put(name, at, text)
  local s = self.section[name]
  s.data = s.data:sub(1, at) .. text .. s.data:sub(at + #text + 1)
  return self
end

--- Adds a section at the end, or before section `place`.
function bytes:add(name, data, required, place)
  local s = { name = name, data = data, required = required, record = 1 }
  table.insert(self, place or #self + 1, s)
  self.section[name] = s
  return self
end

local function padded(text, bound) return text .. ("\0"):rep(-#text % bound) end

--- The bytes of the file, its sections where they belong; fields `offset_`, `size_` of a section are taken as they are.
function bytes:seal()
  local body, entries, at = {}, {}, 64 + 64 * #self
  for i, s in ipairs(self) do
    local data = i < #self and padded(s.data, 64) or s.data
    if s.data ~= s.summed then s.crc, s.summed = bytes.crc(s.data), s.data end
    entries[i] = s.name .. ("\0"):rep(24 - #s.name) .. bytes.u64(s.offset_ or at) .. bytes.u64(s.size_ or #s.data)
      .. bytes.u32(s.record) .. bytes.u32(s.required and 1 or 0) .. s.crc .. bytes.u64(0)
    body[i], at = data, at + #data
  end
  local head = "\137YLMgrid" .. bytes.u32(0x01020304) .. bytes.u32(self.version) .. bytes.u64(at) .. bytes.u32(#self)
  head = padded(head, 56)
  local listed = table.concat(entries)
  return head .. bytes.crc(head .. listed) .. listed .. table.concat(body)
end

return bytes
