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

return page
