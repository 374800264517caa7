--- The device that Vulkan specs run on.
--
--     describe("lights on a device", function()
--       local gpu = device.here()
--       if not gpu then return end

local busted = require "busted"
local ylm = require "ylm"

local gpu = {}

--- The number of the device to open: one in software where there is one, so that results do not depend on the machine.
-- Without any: nil, message.
function gpu.choose()
  local devices, missing = ylm.vulkan.devices()
  if not devices then return nil, missing end
  local chosen = 1
  for i, d in ipairs(devices) do if d.type == "cpu" and d.usable then chosen = i end end
  return chosen
end

--- Opens the chosen device with these options of ylm.vulkan.open.
function gpu.open(options)
  local o = { device = gpu.choose() }
  for k, v in pairs(options or {}) do o[k] = v end
  return assert(ylm.vulkan.open(o))
end

--- Closes a device that was opened with validation, which must have had nothing to say.
function gpu.close_silent(open)
  open:close()
  assert(open.messages == 0 and open.message == "", open.message)
end

--- The chosen device's number; without any nil, and a pending spec.
local function present()
  local chosen, missing = gpu.choose()
  if not chosen then busted.pending("no Vulkan device: " .. missing) end
  return chosen
end

--- In a describe block: a function that opens devices as gpu.open does, with validation unless said otherwise, which are
-- closed after each spec. Without any: nil, and a pending spec.
function gpu.each()
  if not present() then return nil end
  local opened = {}
  busted.after_each(function()
    for _, open in ipairs(opened) do gpu.close_silent(open) end
    opened = {}
  end)
  return function(options)
    options = options or {}
    if options.validate == nil then options.validate = true end
    local open = gpu.open(options)
    opened[#opened + 1] = open
    return open
  end
end

--- In a describe block: its device, opened with validation and closed behind it. Without any: nil, and a pending spec.
function gpu.here()
  if not present() then return nil end
  local open = gpu.open { validate = true }
  busted.teardown(function() gpu.close_silent(open) end)
  return open
end

return gpu
