--- Values as JSON.

local json = {}

local DEEPEST = 32

local escapes = { ['"'] = '\\"', ["\\"] = "\\\\", ["\n"] = "\\n", ["\r"] = "\\r", ["\t"] = "\\t" }

--- A string in quotes.
function json.quoted(s)
  return '"' .. s:gsub('[%c"\\]', function(c) return escapes[c] or ("\\u%04x"):format(c:byte()) end) .. '"'
end

--- Strings by `quoted`, numbers by `number`, booleans, lists, and tables with string keys (sorted); all else is null.
function json.write(x, number, quoted, depth)
  depth = depth or 0
  local t = type(x)
  if t == "number" then return number(x) end
  if t == "string" then return quoted(x) end
  if t == "boolean" then return tostring(x) end
  if t ~= "table" or depth > DEEPEST then return "null" end
  local out = {}
  if #x > 0 or next(x) == nil then
    for i = 1, #x do out[i] = json.write(x[i], number, quoted, depth + 1) end
    return "[" .. table.concat(out, ",") .. "]"
  end
  local keys = {}
  for key in pairs(x) do keys[#keys + 1] = tostring(key) end
  table.sort(keys)
  for i, key in ipairs(keys) do out[i] = quoted(key) .. ":" .. json.write(x[key], number, quoted, depth + 1) end
  return "{" .. table.concat(out, ",") .. "}"
end

return json
