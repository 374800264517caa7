--- The numbers that a Lua program prints by the kernels `isa`, in a process of its own: a list.

local scratch = require "spec.support.scratch"

return function(isa, program)
  local folder, list = scratch.new(), {}
  local path = folder:write("program.lua", program)
  local out, status = scratch.capture(("YLM_ISA=%s %s %s"):format(isa, os.getenv "YLM_LUA" or "lua", path))
  folder:remove()
  assert(status == 0, isa .. ": " .. out)
  for word in out:gmatch "%S+" do list[#list + 1] = assert(tonumber(word), word) end
  return list
end
