--- Tables as print and tostring show them: reports with a line for each field, forms as they are written.

local text = require "ylm.text"

local show = {}

local SHOWN, DEEPEST = 6, 4

local words

--- Up to SHOWN entries of a list, then how many there are.
local function list_words(x, depth)
  local out = {}
  for i = 1, math.min(#x, SHOWN) do out[i] = words(x[i], depth) end
  if #x > SHOWN then out[#out + 1] = ("... (%d in all)"):format(#x) end
  return "{" .. table.concat(out, ", ") .. "}"
end

--- The names of a table that are strings, sorted.
local function names_of(t)
  local names = {}
  for name in pairs(t) do if type(name) == "string" then names[#names + 1] = name end end
  table.sort(names)
  return names
end

--- A value in words: numbers with six digits, objects by their own words.
function words(x, depth)
  if type(x) == "number" then
    if x ~= x then return "nan" end
    return x == math.floor(x) and math.abs(x) < 1e15 and ("%d"):format(x) or ("%.6g"):format(x)
  end
  if type(x) == "string" then return text.shown(x) end
  if type(x) == "function" then return "a function" end
  local meta = type(x) == "table" and getmetatable(x)
  if type(x) ~= "table" or type(meta) == "table" and meta.__tostring then return text.shown(tostring(x)) end
  if depth >= DEEPEST then return "{...}" end
  local names, out = names_of(x), {}
  if #names == 0 then return list_words(x, depth + 1) end
  for i, name in ipairs(names) do out[i] = ("%s = %s"):format(text.shown(name), words(x[name], depth + 1)) end
  return "{ " .. table.concat(out, ", ") .. " }"
end

--- A table with a line for each field that is a string, sorted: "name   value".
function show.fields(t)
  local names, width, out = names_of(t), 0, {}
  for _, name in ipairs(names) do width = math.max(width, #name) end
  for i, name in ipairs(names) do out[i] = ("%-" .. width .. "s  %s"):format(text.shown(name), words(t[name], 1)) end
  return table.concat(out, "\n")
end

local report = { __tostring = show.fields }

--- The table itself, which print and tostring now show field by field; nil stays nil.
function show.report(t)
  if type(t) == "table" and getmetatable(t) == nil then setmetatable(t, report) end
  return t
end

--- 'kind { name = value, ... }' of the fields of a form that an object has, in their order; get(name) is the value of one.
function show.form(kind, fields, get)
  local out = {}
  for _, field in ipairs(fields) do
    local value = get(field[1])
    if value ~= nil then out[#out + 1] = ("%s = %s"):format(field[1], words(value, 1)) end
  end
  return kind .. " { " .. table.concat(out, ", ") .. " }"
end

return show
