-- Every option and field that is described takes any value: the call gives a result, or refuses it at the caller's line in
-- words that name the option. Nothing else is raised, from no line of the library.
--
-- Values go into the examples of the reference, at the first call that checks the options of the function in question.

local check = require "ylm.check"
local form = require "ylm.form"
local help = require "ylm.help"
local reference = require "ylm.describe"
local scratch = require "spec.support.scratch"
local ylm = help.load()

local closed = ylm.array { 1 }
closed:close()
local values = { "16", {}, { 1, 2, 3 }, true, false, 0 / 0, 1e300, -1, 1e-300, closed }

--- The options or fields to change, the name and the value to put there; nil once that is done.
local target, name_there, value_there

--- `given` with the value put there, where `fields` are the ones to change.
local function changed(fields, given)
  if fields ~= target or (given ~= nil and type(given) ~= "table") then return given end
  local copy = { [name_there] = value_there }
  for name, value in pairs(given or {}) do if name ~= name_there then copy[name] = value end end
  target = nil
  return copy
end

--- The constructors, and `ylm` with them.
local constructors = setmetatable({}, { __index = function(_, name)
  local definition = form.defined[name]
  return definition and function(given)
    local made, message, code = definition.construct(changed(definition.fields, given))
    return made, message, code -- no tail call, which would hide the line
  end
end })
local env = setmetatable({ ylm = setmetatable({}, { __index = function(_, name) return constructors[name] or ylm[name] end }) },
  { __index = function(_, name) return constructors[name] or _G[name] end })

--- Files of examples are in a folder of this spec: a refusal ends an example before it removes them.
local folder
local names_of_files = 0
env.os = setmetatable({ tmpname = function()
  names_of_files = names_of_files + 1
  return ("%s/%d"):format(folder.path, names_of_files)
end }, { __index = os })

--- An example as a function; that of a form may be one constructor call.
local function compiled(text)
  local load_text = loadstring or load -- luacheck: ignore
  local chunk = load_text(text, "=example") or assert(load_text("local made, message = " .. text, "=example"))
  if setfenv then return setfenv(chunk, env) end -- luacheck: ignore
  debug.setupvalue(chunk, 1, env)
  return chunk
end

--- Fails unless the field's type takes the value or refuses it by name; returns whether it does take it.
local function taken(field, value)
  local said
  local good = pcall(form.check, { field }, { [field[1]] = value }, function(message)
    said = message
    error(message, 0)
  end)
  assert(good or said, "the check itself raised")
  assert(good or said:find(field[1], 1, true), said)
  return good
end

--- Puts all values into one field of an example that is run for each that the field's type takes.
local function try(about, text, fields, field)
  local run = compiled(text)
  for _, value in ipairs(values) do
    local what = ("%s, %s = %s"):format(about, field[1], check.describe(value))
    local checked, takes = pcall(taken, field, value)
    assert(checked, what .. ": " .. tostring(takes))
    if takes and not (field[2] == "progress" and value == true) then
      target, name_there, value_there = fields, field[1], value
      local good, raised = pcall(run)
      target = nil
      local said = tostring(raised)
      assert(good or said:find "^example:%d+: " or said:find "options_spec%.lua:%d+: ", what .. ": " .. said)
      assert(good or not said:find("lua/ylm/", 1, true), what .. ": " .. said)
    end
  end
end

describe("options", function()
  local options = form.options
  setup(function()
    folder = scratch.new()
    form.options = function(n, name, fields, given) -- luacheck: ignore
      local values_, a, b = options(n, name, fields, changed(fields, given))
      return values_, a, b
    end
  end)
  teardown(function()
    form.options = options -- luacheck: ignore
    folder:remove()
    os.remove "16" -- a journal of team:each
  end)

  local names = {}
  for name, entry in pairs(reference.entries) do
    if type(entry.options) == "table" and #entry.options > 0 then names[#names + 1] = name end
  end
  table.sort(names)
  for _, name in ipairs(names) do
    it("of " .. name .. " take or refuse any value", function()
      local entry = reference.entries[name]
      for _, field in ipairs(entry.options) do try(name, entry.example, entry.options, field) end
    end)
  end
  for _, name in ipairs(form.names) do
    it("of the form " .. name .. " take or refuse any value", function()
      local definition = form.defined[name]
      for _, field in ipairs(definition.fields) do try(name, definition.example, definition.fields, field) end
    end)
  end
end)
