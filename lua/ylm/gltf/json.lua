--- JSON as Lua values, and Lua values as JSON: extras.ylm of glTF files, and what ylm writes itself.

local shared = require "ylm.json"

local json = {}

-- Reading ----------------------------------------------------------------------------------

local constants = { ["true"] = true, ["false"] = false }

local value

local function list(s, at)
  local out = {}
  at = s:match("^%[%s*()", at)
  while s:sub(at, at) ~= "]" do
    out[#out + 1], at = value(s, at)
    at = s:match("^%s*,?%s*()", at)
  end
  return out, at + 1
end

local function text(s, at)
  local from, to = s:find('^"[^"\\]*"', at)
  if not from then error "json: a plain string expected" end
  return s:sub(from + 1, to - 1), to + 1
end

local function object(s, at)
  local out = {}
  at = s:match("^{%s*()", at)
  while s:sub(at, at) ~= "}" do
    local key, colon = text(s, at)
    out[key], at = value(s, s:match("^%s*:%s*()", colon))
    at = s:match("^%s*,?%s*()", at)
  end
  return out, at + 1
end

function value(s, at)
  local first = s:sub(at, at)
  if first == "{" then return object(s, at) end
  if first == "[" then return list(s, at) end
  if first == '"' then return text(s, at) end
  local word, after = s:match("^([%w%.%+%-]+)()", at)
  if not word then error "json: a value expected" end
  if constants[word] ~= nil then return constants[word], after end
  return tonumber(word), after
end

--- The value of a text that is known to be JSON; nil where strings in it have escapes.
function json.read(s)
  local ok, out = pcall(value, s, 1)
  return ok and out or nil
end

-- Writing -----------------------------------------------------------------------------------

--- A number to `digits`, the same under every locale.
function json.number(x, digits)
  return ((("%%.%dg"):format(digits)):format(x):gsub(",", "."))
end

--- A value: lists, { key, value, key, value, .. } of json.object, strings, booleans, numbers with 17 digits.
function json.write(x)
  if type(x) == "string" then return shared.quoted(x) end
  if type(x) == "number" then return json.number(x, 17) end
  if type(x) ~= "table" then return tostring(x) end
  local out = {}
  if x.keys then
    for i = 1, #x.keys, 2 do out[#out + 1] = shared.quoted(x.keys[i]) .. ":" .. json.write(x.keys[i + 1]) end
    return "{" .. table.concat(out, ",") .. "}"
  end
  for i, y in ipairs(x) do out[i] = json.write(y) end
  return "[" .. table.concat(out, ",") .. "]"
end

--- An object whose entries keep this order: json.object("a", 1, "b", 2); entries of nil are left out.
function json.object(...)
  local keys = {}
  for i = 1, select("#", ...), 2 do
    local key, x = select(i, ...)
    if x ~= nil then keys[#keys + 1], keys[#keys + 2] = key, x end
  end
  return { keys = keys }
end

return json
