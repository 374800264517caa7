--- Libraries that are loaded when they are first used: image files, rays, pictures, GPUs, methods to compare with.

local memory = require "ylm.memory"

local library = {}

--- Messages of dynamic loaders where memory runs out.
local exhausted = { "not enough memory", "[Cc]annot allocate memory", "failed to map", "cannot map", "out of memory",
  "cannot create shared object descriptor" }

--- Why a module did not load, in a line: "libembree3.so.3: cannot open shared object file: ...".
local function reason(raised)
  local text = memory.message(raised) or tostring(raised)
  return text:match "^error loading module[^\n]*\n%s*([^\n]*)" or text:match "^([^\n]-):?\n" or text
end

--- The binding ylm.c.NAME; or nil, message, "ENOMEM" | "EMISSING". `advice` has a %s for the reason.
function library.open(name, advice)
  local ok, binding = pcall(require, "ylm.c." .. name)
  if ok then return binding end
  memory.forget_marks()
  local why = reason(binding)
  for _, words in ipairs(exhausted) do
    if why:find(words) or memory.message(binding) then
      return nil, ("libylm_%s cannot be loaded: memory ran out (%s)"):format(name, why), "ENOMEM"
    end
  end
  return nil, advice:format(why), "EMISSING"
end

--- Functions that modules further down the ladder call, by the modules that define them: lua/ylm/init.lua fills the table.
library.later = {}

local RIVAL = "this method, kept for comparison, needs libylm_rival: run make (or make install) again (%s)"

--- The binding of libylm_rival, ylm.c.rival; or nil, message, code.
function library.rival_binding() return library.open("rival", RIVAL) end

--- f(...), a function of ylm.c.core. Where it answers EMISSING, its method is one of libylm_rival, which is loaded first.
function library.rival(f, ...)
  local a, b, c = f(...)
  if c ~= "EMISSING" then return a, b, c end
  local binding, message, code = library.rival_binding()
  if not binding then return nil, message, code end
  return f(...)
end

return library
