--- Raising errors where they teach: at the caller's line, naming what was wrong.
--
-- The caller is the nearest function on the stack that is not part of ylm, so
-- stack levels are not counted. A caller's mistake raises; what the world does
-- (a file, a driver, memory) is returned as nil, message, code.

local core = require "ylm.c.core"

local check = {}

local here = debug.getinfo(1, "S").source:match("^(.*[/\\])check%.lua$") or "@?"

--- Is the function at this stack level one of ylm's own?
local function is_ours(info)
  return info.what == "C" or info.what == "tail" or info.source:sub(1, #here) == here
end

--- Raises `message` at the line of the nearest caller outside of ylm.
function check.fail(message, ...)
  if select("#", ...) > 0 then message = message:format(...) end
  local level = 2
  while true do
    local info = debug.getinfo(level, "Sf")
    if not info or info.func == check.boundary then error(message, 0) end
    if not is_ours(info) then error(message, level) end
    level = level + 1
  end
end

--- "file:line: " of the nearest caller outside of ylm.
function check.position()
  local _, where = pcall(check.fail, "")
  return where
end

--- The function below which no caller is looked for: set while a scene file runs.
check.boundary = false

--- Raises "bad argument #n to 'name' (message)".
function check.bad(n, name, message, ...)
  if select("#", ...) > 0 then message = message:format(...) end
  return check.fail(("bad argument #%d to '%s' (%s)"):format(n, name, message))
end

--- Passes a C function's results on, raising if they are nil, message, code of a caller's mistake.
function check.result(name, first, message, code, ...)
  if first == nil and type(code) == "string" and core.status(code) == "caller" then
    return check.fail("%s: %s", name, message)
  end
  return first, message, code, ...
end

--- A text for messages: what is longer than 40 bytes is cut between two characters.
function check.short(text)
  if #text <= 40 then return text end
  return text:sub(1, 37):gsub("[\192-\255][\128-\191]*$", "") .. "..."
end

--- A limit of C as messages say it, the same under every Lua: "1e15", "65536", "2^22".
function check.limit_text(x)
  for bits = 20, 53 do
    if x == 2 ^ bits then return "2^" .. bits end
  end
  return (("%g"):format(x):gsub("e%+", "e"))
end

--- Why a grid cannot be used; nil where it can, or is none.
function check.grid_fault(grid)
  local is_open, updating, spent = core.grid_is_open(grid)
  if spent then return "the grid is spent: memory ran out while it was updated, bake it anew" end
  if updating then return "the grid is being updated" end
  if is_open == false then return "the grid has been closed" end
end

--- Argument `n` of `name` as a device (ylm/device/init.lua); raises unless it is a gpu.
function check.device(n, name, gpu)
  if core.type(gpu) ~= "ylm.gpu" then return check.bad(n, name, "a gpu expected, got %s", check.describe(gpu)) end
  return getmetatable(gpu).__device(gpu)
end

--- A number in words; NaN without the sign that C's library may write.
function check.number_text(x, format)
  if x ~= x then return "nan" end
  return format and format:format(x) or tostring(x)
end

--- A value in words, for messages: "a table", "{1, 0}", "nil", "-1", "'text'", "an array of 2x3".
function check.describe(value)
  local t = type(value)
  if t == "number" then return check.number_text(value) end
  if t == "boolean" or t == "nil" then return tostring(value) end
  if t == "string" then return "'" .. check.short(value) .. "'" end
  if t == "table" and getmetatable(value) == nil and #value > 0 and #value <= 4 then
    local words = {}
    for _, x in ipairs(value) do if type(x) == "number" then words[#words + 1] = check.number_text(x, "%.14g") end end
    if #words == #value then return "{" .. table.concat(words, ", ") .. "}" end
  end
  local object = core.type(value)
  if object == "ylm.array" then
    local shape, _, _, is_open = core.array_info(value)
    return is_open and "an array of " .. table.concat(shape, "x") or "a closed array"
  end
  return object and ("a " .. object) or ("a " .. t)
end

--- Nested tables where the value is an array that is open; else the value as it is.
function check.plain(value)
  if core.type(value) == "ylm.array" and select(4, core.array_info(value)) then return core.array_totable(value) end
  return value
end

--- The candidate that a misspelt name most likely meant, or nil. Candidates that are no text are passed over.
function check.guess(name, candidates)
  local best, bound = nil, math.max(1, math.floor(#name / 3)) + 1
  for _, candidate in ipairs(candidates) do
    local d = type(candidate) == "string" and check.edit_distance(name, candidate) or math.huge
    if d < bound then best, bound = candidate, d end
  end
  return best
end

--- Number of insertions, deletions, substitutions and swaps of neighbours between two words; infinite where their
-- lengths alone say that one is not the other misspelt.
function check.edit_distance(a, b)
  if math.abs(#a - #b) > 4 or #a > 64 then return math.huge end
  local before, last = {}, {}
  for j = 0, #b do last[j] = j end
  for i = 1, #a do
    local row = { [0] = i }
    for j = 1, #b do
      local cost = a:byte(i) == b:byte(j) and 0 or 1
      row[j] = math.min(last[j] + 1, row[j - 1] + 1, last[j - 1] + cost)
      if i > 1 and j > 1 and a:byte(i) == b:byte(j - 1) and a:byte(i - 1) == b:byte(j) then
        row[j] = math.min(row[j], before[j - 2] + 1)
      end
    end
    before, last = last, row
  end
  return last[#b]
end

--- Nil for a name that a table of public functions lacks (`what`: "", "sh." ...), or raises where it is one of
-- `names` misspelt: a program may ask for what another version has. Names that begin with _ are asked for by tools.
function check.no_name(what, name, names)
  local guess = type(name) == "string" and not name:find "^_" and check.guess(name, names)
  if guess then return check.fail("no ylm.%s%s (did you mean '%s'?)", what, check.short(name), guess) end
end

--- A finite number?
function check.is_number(x)
  return type(x) == "number" and x == x and x ~= math.huge and x ~= -math.huge
end

function check.is_integer(x)
  return check.is_number(x) and x == math.floor(x)
end

--- Argument `n` as an integer in lo .. hi (either may be nil).
function check.integer(n, name, what, x, lo, hi)
  if check.is_integer(x) and (not lo or x >= lo) and (not hi or x <= hi) then return x end
  local range = lo and hi and (" from %d to %d"):format(lo, hi) or lo and (" >= %d"):format(lo) or ""
  return check.bad(n, name, "%s must be an integer%s, got %s", what, range, check.describe(x))
end

return check
