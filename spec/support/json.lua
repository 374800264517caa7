--- JSON of the specs: a value from text, and text of strings, numbers, booleans, lists and tables with string keys.

local json = {}

local unescaped = { b = "\b", f = "\f", n = "\n", r = "\r", t = "\t", ['"'] = '"', ["\\"] = "\\", ["/"] = "/" }

--- A code point as UTF-8.
local function utf8_of(c)
  if c < 0x80 then return string.char(c) end
  if c < 0x800 then return string.char(0xc0 + math.floor(c / 64), 0x80 + c % 64) end
  return string.char(0xe0 + math.floor(c / 4096), 0x80 + math.floor(c / 64) % 64, 0x80 + c % 64)
end

local value

local function fault(text, at, wanted)
  error(("JSON: %s expected at byte %d: %s"):format(wanted, at, text:sub(at, at + 30)), 0)
end

local function blank(text, at) return text:find("[^ \t\r\n]", at) or #text + 1 end

local function string_at(text, at)
  local out, i = {}, at + 1
  while true do
    local stop = text:find('["\\]', i) or fault(text, at, "the end of a string")
    out[#out + 1] = text:sub(i, stop - 1)
    if text:byte(stop) == 34 then return table.concat(out), stop + 1 end
    local c = text:sub(stop + 1, stop + 1)
    if c == "u" then
      out[#out + 1] = utf8_of(tonumber(text:sub(stop + 2, stop + 5), 16))
      i = stop + 6
    else
      out[#out + 1] = unescaped[c] or fault(text, stop, "an escape")
      i = stop + 2
    end
  end
end

--- Entries up to `close`; take(at) reads one and returns where it ends.
local function entries(text, at, close, take)
  at = blank(text, at + 1)
  if text:sub(at, at) == close then return at + 1 end
  while true do
    at = blank(text, take(at))
    local c = text:sub(at, at)
    if c == close then return at + 1 end
    if c ~= "," then fault(text, at, "',' or '" .. close .. "'") end
    at = blank(text, at + 1)
  end
end

function value(text, at)
  at = blank(text, at)
  local c = text:sub(at, at)
  if c == '"' then return string_at(text, at) end
  if c == "[" then
    local list, n = {}, 0
    return list, entries(text, at, "]", function(i)
      n = n + 1
      local x, stop = value(text, i)
      list[n] = x
      return stop
    end)
  end
  if c == "{" then
    local map = {}
    return map, entries(text, at, "}", function(i)
      local key, stop = string_at(text, i)
      stop = blank(text, stop)
      local x
      x, stop = value(text, stop + 1)
      map[key] = x
      return stop
    end)
  end
  for word, x in pairs { ["true"] = true, ["false"] = false, null = false } do
    if text:sub(at, at + #word - 1) == word then
      if word == "null" then x = nil end
      return x, at + #word
    end
  end
  local number = text:match("^%-?[%d.eE+-]+", at) or fault(text, at, "a value")
  return tonumber(number), at + #number
end

--- The value of a text.
function json.read(text) return (value(text, 1)) end

--- The text of a value.
function json.write(x)
  if type(x) == "string" then
    return '"' .. x:gsub('[%c"\\]', function(c) return ("\\u%04x"):format(c:byte()) end) .. '"'
  end
  if type(x) ~= "table" then return type(x) == "number" and ("%.14g"):format(x) or tostring(x) end
  local out = {}
  if #x > 0 then
    for i, y in ipairs(x) do out[i] = json.write(y) end
    return "[" .. table.concat(out, ",") .. "]"
  end
  for key, y in pairs(x) do out[#out + 1] = json.write(key) .. ":" .. json.write(y) end
  return "{" .. table.concat(out, ",") .. "}"
end

return json
