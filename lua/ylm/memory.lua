--- Memory that runs out: an error inside of ylm, nil, message, "ENOMEM" of every public function.
--
-- Bindings raise where memory of C runs out, as Lua does where its own does. No line of ylm goes on with what was not made.
-- Public functions catch both. A public function that ylm itself calls catches nothing.

local core = require "ylm.c.core"

local memory = {}

--- The message of an error that says that memory ran out; nil of any other.
function memory.message(raised)
  if raised == "not enough memory" then return "memory ran out" end
  return core.no_memory(raised)
end

--- Files of ylm whose loading was cut short can be loaded again: Lua 5.1 keeps a mark in their place, and refuses.
function memory.forget_marks()
  for name, value in pairs(package.loaded) do
    if type(value) ~= "table" and name:find "^ylm%." then package.loaded[name] = nil end
  end
end

--- Passes the results of pcall on, in place of memory that ran out nil, message, code.
local function results(ok, ...)
  if ok then return ... end
  local message = memory.message((...))
  if message then
    memory.forget_marks()
    return nil, message, "ENOMEM"
  end
  error((...), 0)
end

--- Results of pcall, unless memory ran out: that error goes on.
local function others(ok, ...)
  if not ok and memory.message((...)) then error((...), 0) end
  return ok, ...
end

--- pcall for what else may be raised.
function memory.pcall(f, ...) return others(pcall(f, ...)) end

--- f(...), or nil, message, "ENOMEM": for callers that can do without.
function memory.attempt(f, ...) return results(pcall(f, ...)) end

--- Does a public function run, and no function of the user that it has called?
local within = false

local function leave(...)
  within = false
  return results(...)
end

--- `f` as users call it.
function memory.public(f)
  if type(f) ~= "function" or core.owned(f, "public") then return f end
  local function public(...)
    if within then return f(...) end
    within = true
    return leave(pcall(f, ...))
  end
  core.own(public).public = true
  return public
end

local function enter(before, ...)
  within = before
  return ...
end

--- The user's function `f` as ylm calls it: what it calls of ylm is public.
function memory.users(f)
  return function(...)
    local before = within
    within = false
    return enter(before, f(...))
  end
end

--- Makes the functions of a table public: all but metamethods and those named in `but`. Returns it.
function memory.publish(methods, but)
  for name, f in pairs(methods) do
    if type(name) == "string" and not name:find "^_" and not (but and but[name]) then methods[name] = memory.public(f) end
  end
  return methods
end

return memory
