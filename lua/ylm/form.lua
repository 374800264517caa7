--- Named tables that are checked, defaulted and explained.
--
--     local lamp = form.define("sphere_light", {
--       about  = "A sphere that emits the same radiance everywhere.",
--       fields = {
--         { "at", "point", unit = "scene units", about = "centre" },            -- no default: required
--         { "radius", "number", min = 0, default = 0.1, unit = "scene units" },
--         { "rim", "number", min = 0, follows = { "radius", 0.5 } },            -- default: half the radius, a field above it
--         { "profile", "choice", of = { "a", "b" }, optional = true },          -- absent stays nil
--       },
--       build  = function(values) return object end,
--       numbers = 256,     -- that the object holds besides its arrays: the number in a scene file is limited
--       example = "sphere_light { at = {0, 2, 0}, radius = 0.1, radiance = 5 }",
--     })
--
-- Option tables of functions are checked by the same engine: form.options.

local check = require "ylm.check"
local core = require "ylm.c.core"
local memory = require "ylm.memory"
local show = require "ylm.show"

local form = {}

--- Every form by name: `ylm help`, the scene environment and the documentation read it.
form.defined = {}
--- Their names in the order of definition.
form.names = {}
--- While a scene file runs: observer(definition, values, fail) sees checked values before they
-- are built, so that lua/ylm/sandbox.lua can bound sizes and resolve the names of files.
form.observer = nil
--- Then too: budget(what) is how much of `what` the file may still describe; budget(what, n, fail) takes n of it.
form.budget = nil
--- Then too: locate(folder, name) is the path of a file that another file in `folder` names; nil, message, code where it is
-- missing ("EIO"), too large, or not at or below the folder.
form.locate = nil
--- Then too: like(name, where) is the scene of another scene file in the folder, within what is left of the same limits;
-- `where` is the line that names it, "file:line: ". It raises where there is none.
form.like = nil

--- Takes the numbers of an array of this shape from what the file may describe, before it is made; fail(message) raises.
function form.take_numbers(shape, fail)
  if not form.budget then return end
  local n = 1
  for _, extent in ipairs(shape) do n = n * extent end
  form.budget("numbers", n, fail)
end

-- Each type: function(value, field) -> value or nil, "what is wanted". ---------

local types = {}
form.types = types

local function in_range(x, field)
  return (not field.min or x >= field.min) and (not field.max or x <= field.max)
    and (not field.above or x > field.above)
end

--- A value the same under every Lua: 2^28 is 268435456, never 2.68435456e+08.
local function text_of(x)
  return type(x) == "number" and ("%.14g"):format(x) or tostring(x)
end

local function range_text(field)
  local parts = {}
  if field.above then parts[#parts + 1] = "> " .. text_of(field.above) end
  if field.min then parts[#parts + 1] = ">= " .. text_of(field.min) end
  if field.max then parts[#parts + 1] = "<= " .. text_of(field.max) end
  return #parts > 0 and " " .. table.concat(parts, " and ") or ""
end

function types.number(x, field)
  if check.is_number(x) and in_range(x, field) then return x end
  return nil, "a number" .. range_text(field)
end

function types.integer(x, field)
  if check.is_integer(x) and in_range(x, field) then return x end
  return nil, "an integer" .. range_text(field)
end

function types.boolean(x)
  if type(x) == "boolean" then return x end
  return nil, "true or false"
end

function types.string(x)
  if type(x) == "string" then return x end
  return nil, "a string"
end

function types.path(x)
  if type(x) == "string" and #x > 0 and not x:find "%z" then return x end
  return nil, "a file name"
end

types["function"] = function(x)
  if type(x) == "function" then return x end
  return nil, "a function"
end

local MEMORY = { B = 1, KB = 1024, MB = 1024 ^ 2, GB = 1024 ^ 3, TB = 1024 ^ 4 }

--- A size of memory: bytes, or a text such as "256 MB".
function types.memory(x)
  local wanted = "a number of bytes, or a text such as '256 MB'"
  if type(x) == "string" then
    local number, unit = x:match "^%s*(%d+%.?%d*)%s*(%a+)%s*$"
    x = number and MEMORY[unit:upper()] and tonumber(number) * MEMORY[unit:upper()]
  end
  if type(x) ~= "number" or not (x >= 1 and x < 2 ^ 53) then return nil, wanted end
  return math.floor(x)
end

--- A function with the seconds between two calls of it, which can be called as one.
local timed = { __call = function(self, ...) return self[1](...) end }

function types.progress(x)
  if type(x) == "function" then return memory.users(x) end
  if x == true or x == false then return x end
  if getmetatable(x) == timed then return x end
  if type(x) == "table" and type(x[1]) == "function" then
    local every = x.every
    if type(every) == "number" and every > 0 and every <= 3600 then
      return setmetatable({ memory.users(x[1]), every = every }, timed)
    end
    return nil, "{ function, every = seconds } with every above 0 and at most 3600"
  end
  return nil, "a function(done, total, stage), { function, every = seconds } of one, true for a progress bar, or false for none"
end

function types.table(x)
  if type(x) == "table" then return x end
  return nil, "a table"
end

function types.any(x) return x end

function types.choice(x, field)
  for _, choice in ipairs(field.of) do if x == choice then return x end end
  local wanted = {}
  for i, choice in ipairs(field.of) do
    wanted[i] = type(choice) == "string" and "'" .. choice .. "'" or tostring(choice)
  end
  local guess = type(x) == "string" and check.guess(x, field.of)
  return nil, "one of " .. table.concat(wanted, ", ")
    .. (guess and (" (did you mean '%s'?)"):format(guess) or "")
end

--- Three finite numbers, from a table (or an array of shape {3}).
local function three(x)
  x = check.plain(x)
  if type(x) ~= "table" or #x ~= 3 then return nil end
  for i = 1, 3 do if not check.is_number(x[i]) then return nil end end
  return { x[1], x[2], x[3] }
end

function types.point(x) return three(x), "three numbers {x, y, z}" end

function types.vector(x)
  local v = three(x)
  if v and (v[1] ~= 0 or v[2] ~= 0 or v[3] ~= 0) then return v end
  return nil, "three numbers {x, y, z}, not all zero"
end

--- A number, or {r, g, b}; comes out as {r, g, b}.
function types.colour(x, field)
  if check.is_number(x) and in_range(x, field) then return { x, x, x } end
  local c = three(x)
  if c and in_range(c[1], field) and in_range(c[2], field) and in_range(c[3], field) then return c end
  return nil, "a number or {r, g, b}, finite" .. range_text(field)
end

--- {min, max} corners; max must exceed min in every axis.
function types.bounds(x)
  local limit = core.limits.extent
  local wanted = "{ {x0, y0, z0}, {x1, y1, z1} } with x0 < x1, y0 < y1, z0 < z1, none beyond " .. check.limit_text(limit)
  if type(x) ~= "table" or #x ~= 2 then return nil, wanted end
  local lo, hi = three(x[1]), three(x[2])
  if not (lo and hi) then return nil, wanted end
  for a = 1, 3 do
    if not (lo[a] < hi[a] and lo[a] >= -limit and hi[a] <= limit) then
      return nil, wanted .. (" (axis %d goes from %g to %g)"):format(a, lo[a], hi[a])
    end
  end
  return { lo, hi }
end

function types.gpu(x)
  if core.type(x) == "ylm.gpu" then return x end
  return nil, "an open device (ylm.vulkan.open)"
end

function types.array(x)
  if core.type(x) == "ylm.array" then return x end
  return nil, "an array (ylm.array)"
end

--- A plain list whose elements are of type `field.of`.
function types.list(x, field)
  if type(x) ~= "table" then return nil, "a list" end
  local out = {}
  for i = 1, #x do
    local value, wanted = types[field.of](x[i], field)
    if value == nil then return nil, ("a list whose element %d is %s"):format(i, wanted) end
    out[i] = value
  end
  return out
end

--- An object of ylm (`field.of` names one kind or lists several, `field.what` says what these are).
function types.object(x, field)
  local kinds = type(field.of) == "table" and field.of or { field.of }
  local kind = form.kind(x)
  for _, wanted in ipairs(kinds) do if kind == wanted then return x end end
  if field.what then return nil, ("%s (%s)"):format(field.what, table.concat(kinds, ", ")) end
  return nil, "a " .. table.concat(kinds, " or a ")
end

--- The kind of a value that a form has built ("sphere_light"), of a userdata ("ylm.grid"), or nil.
function form.kind(x)
  local object = core.type(x)
  if object then return object end
  local mt = type(x) == "table" and getmetatable(x)
  return type(mt) == "table" and mt.__kind or nil
end

-- Checking -------------------------------------------------------------------

local function field_names(fields)
  local names = {}
  for i, field in ipairs(fields) do names[i] = field[1] end
  return names
end

--- The only form that has a field of this name; nil where none or several have.
local function owner_of(name)
  local owner
  for kind, definition in pairs(form.defined) do
    for _, field in ipairs(definition.fields) do
      if field[1] == name then
        if owner then return nil end
        owner = kind
      end
    end
  end
  return owner
end

--- The words behind the name of a field that there is not: another field, or the form that has it. A name that another form
-- has is taken as misspelt only where it is off by one letter.
local function hint(name, fields)
  local names = field_names(fields)
  local guess = check.guess(name, names)
  local near = guess and check.edit_distance(name, guess) == 1
  local owner = not near and owner_of(name)
  if owner then return ("; it is a field of ylm.%s"):format(owner) end
  return guess and (" (did you mean '%s'?)"):format(guess) or "; fields are " .. table.concat(names, ", ")
end

--- The key of `given` that no field has: a name, the first in the alphabet, rather than another key; nil where there is none.
local function stranger(by_name, given)
  local first
  for key in pairs(given) do
    local before = first == nil or type(key) == "string" and (type(first) ~= "string" or key < first)
    if not by_name[key] and before then first = key end
  end
  return first
end

--- Checks `given` against `fields`; fail(message) raises. Returns a new table with defaults filled in.
local function checked(fields, given, fail)
  local by_name = {}
  for _, field in ipairs(fields) do by_name[field[1]] = field end
  local key = stranger(by_name, given)
  if type(key) == "string" then return fail(("no field %s%s"):format(check.describe(key), hint(key, fields))) end
  if key ~= nil then return fail(("unexpected entry %s: fields are given by name"):format(check.describe(key))) end
  local values = {}
  for _, field in ipairs(fields) do
    local name, value = field[1], given[field[1]]
    if value == nil then
      if field.default ~= nil then value = field.default
      elseif field.follows then value = field.follows[2] * values[field.follows[1]]
      elseif not field.optional then
        return fail(("field '%s' is missing (%s)"):format(name, field.about or field[2]))
      end
    end
    if value ~= nil then
      local good, wanted = types[field[2]](value, field)
      if good == nil then
        return fail(("%s must be %s, got %s"):format(name, wanted, check.describe(value)))
      end
      values[name] = good
    end
  end
  return values
end

--- Checks a table that is a field of another: form.check(fields, given, fail).
form.check = checked

--- The module that a source file of ylm is: "light" (ylm/light/init.lua), "light.polygon" (ylm/light/polygon.lua).
local function module_of(source)
  local path = source:match(".*ylm[/\\]([%w_/\\]+)%.lua$")
  return path and (path:gsub("[/\\]init$", ""):gsub("[/\\]", "."))
end

--- Defines a constructor that takes one named table. Returns it.
function form.define(name, definition)
  local home, before = module_of(debug.getinfo(2, "S").source), form.defined[name]
  assert(not before or before.home == home, "form defined twice: " .. name) -- a file is loaded again where memory ran out
  definition.name, definition.home = name, home
  local function construct(given)
    if type(given) ~= "table" or form.kind(given) then
      return check.fail("%s: a table of named fields expected, got %s", name, check.describe(given))
    end
    local function fail(message) return check.fail("%s: %s", name, message) end
    local values = checked(definition.fields, given, fail)
    if form.observer then form.observer(definition, values, fail) end
    if definition.build then return definition.build(values, fail) end
    return setmetatable(values, definition.metatable)
  end
  definition.metatable = definition.metatable or {}
  definition.metatable.__kind = name
  definition.metatable.__tostring = definition.metatable.__tostring or function(x)
    return show.form(name, definition.fields, function(field) return rawget(x, field) end)
  end
  definition.construct = construct
  form.defined[name] = definition
  if not before then form.names[#form.names + 1] = name end
  return construct
end

--- Options that many functions have.
form.threads = { "threads", "integer", min = 1, max = core.limits.threads, optional = true,
  about = "default: YLM_THREADS or all cores" }
form.progress = { "progress", "progress", optional = true,
  about = "called as f(done, total, stage); returning false cancels; { f, every = seconds } says how often, default 0.1; true "
    .. "draws a bar, false none (see ylm help progress)" }

--- Checks the option table that is argument `n` of function `name`; nil counts as empty.
function form.options(n, name, fields, given)
  if given == nil then given = {} end
  if type(given) ~= "table" or form.kind(given) then
    return check.bad(n, name, "a table of options expected, got %s", check.describe(given))
  end
  return checked(fields, given, function(message) return check.bad(n, name, "%s", message) end)
end

--- One field in words, for help and documentation.
function form.field_text(field)
  local parts = { field[2] == "choice" and table.concat((function()
    local t = {}
    for i, c in ipairs(field.of) do t[i] = text_of(c) end
    return t
  end)(), " | ") or field[2] == "object" and (type(field.of) == "table" and table.concat(field.of, " | ") or field.of)
    or field[2] .. range_text(field) }
  if field.unit then parts[#parts + 1] = "[" .. field.unit .. "]" end
  if field.default ~= nil and type(field.default) ~= "table" then
    parts[#parts + 1] = "default " .. text_of(field.default)
  elseif field.follows then parts[#parts + 1] = ("default %s %s"):format(text_of(field.follows[2]), field.follows[1])
  elseif field.optional then parts[#parts + 1] = "optional" end
  return table.concat(parts, " ")
end

return form
