--- The binding of libylm_vulkan.so, opened when it is first needed, and the methods of its objects.

local check = require "ylm.check"
local core = require "ylm.c.core"
local library = require "ylm.library"
local memory = require "ylm.memory"

local binding = {}

local INSTALL = "computing on a GPU needs libylm_vulkan: install glslc and libvulkan-dev and run make again (%s)"

--- Type -> its methods, which are there before the binding is loaded.
local types = {}
local furnished = false

--- Gives a type of the binding its methods and fields.
function binding.methods(name, methods) types[name] = methods end

local function furnish()
  furnished = true
  for name, methods in pairs(types) do
    local metatable = core.metatable(name)
    for key, method in pairs(methods) do metatable[key] = method end
    memory.publish(metatable)
  end
end

--- The binding, or nil, message, "EMISSING" | "ENOMEM".
function binding.open()
  local c, message, code = library.open("vulkan", INSTALL)
  if not c then return nil, message, code end
  if not furnished then furnish() end
  return c
end

--- The binding where there is an object of its own already.
function binding.bound() return assert(binding.open()) end

--- The binding for an open device, in the function `name`; raises if it is closed. Or nil, message, code where it is lost.
function binding.use(name, gpu)
  local c = binding.bound()
  local ok, message, code = check.result(name, c.gpu_state(gpu))
  if not ok then return nil, message, code end
  return c
end

return binding
