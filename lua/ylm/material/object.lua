--- Materials of all kinds in Lua: objects that do not change, with methods that ask C.
--
-- A kind's form has `metatable = object.metatable()`, `build = object.builder "KIND"` and
-- `material`, a function of the checked fields. `material` returns the numbers that describe the
-- material, as csrc/material/KIND.c takes them. Of a table it returns C's object besides; where
-- that cannot be made: nil, message, code.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local show = require "ylm.show"

local object = {}

--- The methods of materials; lua/ylm/material/methods.lua fills them.
object.methods = {}

-- A material's own table has values, the form's; numbers; made: C's object, once it is needed.

--- The fields of a material as the form has checked them; nil of what is none.
local function values_of(m) return core.owned(m, "values") end

--- A colour that stands in a field named as a method is called as that method: matte's albedo.
local function callable(value, method)
  return setmetatable({ value[1], value[2], value[3] }, { __call = function(_, ...) return method(...) end })
end

--- A method, or a field as the form has checked it.
local function index(m, key)
  local method, value = object.methods[key], values_of(m)[key]
  if method and type(value) == "table" and #value == 3 then return callable(value, method) end
  if method ~= nil then return method end
  return value
end

--- The metatable of a kind.
function object.metatable()
  return {
    __index = index,
    __newindex = function(_, key)
      return check.fail("material: cannot set %s: a material does not change, make another", check.describe(key))
    end,
    __tostring = function(m)
      local kind = form.kind(m)
      return show.form("ylm." .. kind, form.defined[kind].fields, function(name) return values_of(m)[name] end)
    end,
  }
end

--- The function that makes a material of checked fields, or returns nil, message, code.
function object.builder(kind)
  return function(values, fail)
    local definition = form.defined[kind]
    local numbers, made, code = definition.material(values, fail)
    local good, message = numbers, made
    if numbers and not made then good, message, code = core.material_check(kind, numbers) end
    if not good then
      if core.status(code) == "caller" then return fail(message) end
      return nil, message, code
    end
    local m = setmetatable({}, definition.metatable)
    local own = core.own(m)
    own.values, own.numbers, own.made = values, numbers, made
    return m
  end
end

--- Is it a material?
function object.is(m) return type(m) == "table" and values_of(m) ~= nil end

--- The numbers that describe a material.
function object.numbers(m) return core.own(m).numbers end

--- The material as C asks it what it does with light; nil, message, code. `name`: the function that raises.
function object.made(name, m)
  local own = core.own(m)
  local message, code
  if not own.made then own.made, message, code = check.result(name, core.material_create(form.kind(m), own.numbers)) end
  return own.made, message, code
end

return object
