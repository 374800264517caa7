--- Numbers, strings, booleans, arrays, and tables of these as bytes, and back. Equal values have equal bytes.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"

local values = {}

local DEPTH = 64 -- of tables in tables

local encode

local function encode_array(a)
  local shape, dtype, _, is_open = core.array_info(a)
  if not is_open then return nil, "a closed array" end
  local bytes, convention = core.team_bytes(a)
  return ("a%s,%d,%s:"):format(dtype, convention, table.concat(shape, "x")) .. bytes
end

--- Keys in an order that depends on them alone.
local function entries_of(t, path, depth)
  local keys, of = {}, {}
  for key in pairs(t) do
    if type(key) ~= "string" and not check.is_number(key) then
      return nil, ("%s has a key that is %s"):format(path, check.describe(key))
    end
    local text = encode(key, path, depth)
    keys[#keys + 1], of[text] = text, key
  end
  table.sort(keys)
  return keys, of
end

local function encode_table(t, path, depth)
  if getmetatable(t) ~= nil then return nil, ("%s is an object"):format(path) end
  if depth > DEPTH then return nil, ("%s: tables in tables, more than %d deep; does one hold itself?"):format(path, DEPTH) end
  local keys, of = entries_of(t, path, depth)
  if not keys then return nil, of end
  local out = { "{" }
  for _, text in ipairs(keys) do
    local key = of[text]
    local name = type(key) == "string" and "." .. key or ("[%s]"):format(key)
    local value, message = encode(t[key], path .. name, depth + 1)
    if not value then return nil, message end
    out[#out + 1], out[#out + 2] = text, value
  end
  out[#out + 1] = "}"
  return table.concat(out)
end

--- The bytes of a value that messages call `path`; nil, and what is none of these kinds.
function encode(value, path, depth)
  local kind = type(value)
  if kind == "number" then
    local text = (math.type and math.type(value) == "integer" and "i%d;" or "n%.17g;"):format(value) -- luacheck: ignore 143
    return (text:gsub(",", ".")) -- the same under every locale
  end
  if kind == "string" then return ("s%d:"):format(#value) .. value end
  if kind == "boolean" then return value and "t" or "f" end
  if kind == "table" then return encode_table(value, path, depth) end
  if core.type(value) == "ylm.array" then
    local text, message = encode_array(value)
    return text, message and ("%s is %s"):format(path, message)
  end
  return nil, ("%s is %s"):format(path, check.describe(value))
end

--- The bytes of `value`, or nil and a message that calls it `name`.
function values.encode(value, name) return encode(value, name, 1) end

local decode

local function decode_table(text, at)
  local out = {}
  while text:sub(at, at) ~= "}" do
    local key, value
    key, at = decode(text, at)
    if key == nil then return nil end
    value, at = decode(text, at)
    if value == nil then return nil end
    out[key] = value
  end
  return out, at + 1
end

local function decode_array(text, at)
  local dtype, convention, extents, first = text:match("^(%l[%w]*),(%d+),([%dx]+):()", at)
  if not first then return nil end
  local shape, count = {}, 1
  for word in extents:gmatch "%d+" do shape[#shape + 1], count = tonumber(word), count * tonumber(word) end
  local a = array.zeros(shape, dtype)
  local bytes = count > 0 and #core.team_bytes(a) or 0
  return core.team_set_bytes(a, text:sub(first, first + bytes - 1), tonumber(convention)), first + bytes
end

--- A number with a decimal point, whatever the locale; C writes infinities and NaN in words.
local function number(word)
  if word:find "inf" then return word:find "^%-" and -math.huge or math.huge end
  if word:find "nan" then return 0 / 0 end
  return tonumber(word) or tonumber((word:gsub("%.", ",")))
end

--- The value whose bytes begin at `at`, and where the next begin; nil where these are none.
function decode(text, at)
  local kind = text:sub(at, at)
  if kind == "t" or kind == "f" then return kind == "t", at + 1 end
  if kind == "n" or kind == "i" then
    local word, past = text:match("^([^;]*);()", at + 1)
    local x = word and number(word)
    if x and kind == "n" and math.type then x = x + 0.0 end
    return x, past
  end
  if kind == "s" then
    local length, first = text:match("^(%d+):()", at + 1)
    if not first or first + length - 1 > #text then return nil end
    return text:sub(first, first + length - 1), first + length
  end
  if kind == "{" then return decode_table(text, at + 1) end
  if kind == "a" then return decode_array(text, at + 1) end
end

--- The value of bytes that values.encode made; nil where they are damaged.
function values.decode(text)
  local value, past = decode(text, 1)
  if past == #text + 1 then return value end
end

return values
