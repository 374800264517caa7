--- The device that Vulkan specs of light run on.

local ylm = require "ylm"

local gpu = {}

--- The number of the device to open: one in software where there is one. Without any: nil, message.
function gpu.choose()
  local devices, missing = ylm.vulkan.devices()
  if not devices then return nil, missing end
  local chosen = 1
  for i, d in ipairs(devices) do if d.type == "cpu" and d.usable then chosen = i end end
  return chosen
end

--- Closes a device that was opened with validation, which must have had nothing to say.
function gpu.close_silent(open)
  open:close()
  assert(open.messages == 0 and open.message == "", open.message)
end

return gpu
