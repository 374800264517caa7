--- Compute on a graphics processor: ylm.vulkan.devices, ylm.vulkan.open, and what is kept in its memory.
--
-- libylm_vulkan.so is loaded when it is first needed; it opens libvulkan itself.

local arrays = require "ylm.vulkan.array"
local binding = require "ylm.vulkan.binding"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local device = require "ylm.vulkan.device"
local form = require "ylm.form"
local lights = require "ylm.vulkan.light"
local memory = require "ylm.memory"
local reference = require "ylm.describe"

local vulkan = {}

local gpu_methods = { lights = lights.lights, __device = device.of }

local limits = { "float64", "int64", "timestamps", "subgroup", "binds", "group_size", "groups", "shared_bytes",
  "bind_bytes", "allocation_bytes", "memory_bytes" }

reference.object "gpu" {
  about = "An open device. Arrays, lights and grids in its memory keep it open, unless it is closed.",
  methods = gpu_methods,
  fields = {
    { "name", "string", "as its driver calls it" },
    { "type", "string", "'discrete', 'integrated', 'virtual', 'cpu' (a driver in software) or 'other'" },
    { "driver", "string", "" },
    { "vulkan", "string", "version of the interface" },
    { "limits", "table", "float64, int64 (types it computes in), timestamps, subgroup, binds, group_size, groups, "
      .. "shared_bytes, bind_bytes (of an array as a kernel sees it: longer ones go in passes), allocation_bytes "
      .. "(the longest array), memory_bytes" },
    { "stats", "table", "arrays and bytes there are; uploaded, downloaded (bytes), upload_seconds, download_seconds, "
      .. "run_seconds, dispatches, submissions, pipelines so far" },
    { "messages", "integer", "warnings and errors of the validation layer so far" },
    { "message", "string", "the first of them, or \"\"" },
  },
}

local bound = binding.bound

describe "vulkan.devices" {
  about = "The devices that Vulkan drivers offer, as ylm.vulkan.open counts them.",
  arguments = {},
  returns = { { "devices", "table", "a list of { name, type, driver, vulkan, usable, float64, int64, memory_bytes, ... }: "
    .. "see the fields of gpu and gpu.limits; or nil, message, 'EMISSING' without a loader or a driver" } },
  errors = "the world's failures are returned",
  example = [[
for _, device in ipairs(ylm.vulkan.devices() or {}) do assert(device.name and device.type) end]],
}
function vulkan.devices(...)
  if select("#", ...) > 0 then return check.bad(1, "devices", "no argument expected, got %s", check.describe((...))) end
  local c, message, code = binding.open()
  if not c then return nil, message, code end
  return check.result("devices", c.gpu_devices())
end

--- A number of a device, from 1, or part of its name.
function form.types.device(x)
  if type(x) == "string" and x ~= "" or check.is_integer(x) and x >= 1 and x <= 1e6 then return x end
  return nil, "a number from 1, or part of a device's name"
end

local open_options = {
  { "device", "device", optional = true,
    about = "a number in ylm.vulkan.devices(), or part of a name; default: the best, discrete before integrated" },
  { "validate", "boolean", default = false,
    about = "with the Khronos validation layer, see gpu.messages; YLM_VULKAN_VALIDATION=1 says so too" },
  { "staging", "boolean", default = false, about = "copy by staging memory even where the host sees the device's" },
}

describe "vulkan.open" {
  about = "Opens a device for the option `device` of other functions.",
  arguments = { { "options?", "table", "see the options" } },
  options = open_options,
  returns = { { "gpu", "gpu", "or nil, message, code: 'EMISSING' without a loader, a driver, such a device, the "
    .. "validation layer; 'EDEVICE'; 'ENOMEM'" } },
  errors = "raises on bad options; the world's failures are returned",
  example = [[
local gpu, message = ylm.vulkan.open { device = 1 }
if gpu then
  assert(gpu.limits.memory_bytes > 0)
  gpu:close()
else assert(#message > 0) end]],
}
function vulkan.open(options)
  local o = form.options(1, "open", open_options, options)
  local c, message, code = binding.open()
  if not c then return nil, message, code end
  local index = type(o.device) == "number" and o.device or nil
  return check.result("open", c.gpu_open(index, not index and o.device or nil, o.validate, o.staging))
end

-- Devices -----------------------------------------------------------------------------

local function is_gpu(g, name)
  if core.type(g) ~= "ylm.gpu" then
    return check.fail("%s: a gpu expected before the colon, got %s", name, check.describe(g))
  end
  return g
end

describe "gpu:array" {
  about = "Copies an array to the device's memory. array:to(gpu) says the same.",
  arguments = { { "values", "array|table", "an array, or nested tables" } },
  returns = { { "copy", "gpu_array", "copy.seconds is what it took; or nil, message, code: 'ENOMEM', 'ELIMIT', 'EDEVICE'" } },
  errors = "raises on what is not an array, and where the device has been closed",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then
  local there = gpu:array(ylm.array({ { 1, 2 }, { 3, 4 } }, "float"))
  assert(there:download():get(2, 1) == 3)
end]],
}
function gpu_methods.array(gpu, values)
  is_gpu(gpu, "array")
  if core.type(values) ~= "ylm.array" and type(values) ~= "table" then
    return check.bad(1, "array", "a table of numbers or an array expected, got %s", check.describe(values))
  end
  return arrays.upload(gpu, 1, "array", values)
end

describe "gpu:peak" {
  about = "Measures what the device computes and moves at best: what benchmarks compare with.",
  arguments = {},
  returns = {
    { "operations", "number", "float operations per second; a fused multiplication and addition is two" },
    { "bytes", "number", "per second, read and written; or nil, message, code" },
  },
  errors = "raises where the device has been closed",
  example = [[
local gpu = ylm.vulkan.open()
assert(not gpu or gpu:peak() > 0)]],
}
function gpu_methods.peak(gpu)
  is_gpu(gpu, "peak")
  return check.result("peak", bound().gpu_peak(gpu))
end

describe "gpu:close" {
  about = "Gives back everything the device holds, arrays too; what uses it afterwards is refused.",
  arguments = {},
  returns = {},
  errors = "raises from the progress function of a call that the device works on",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then gpu:close() end]],
}
function gpu_methods.close(gpu)
  is_gpu(gpu, "close")
  check.result("close", bound().gpu_close(gpu))
end

function gpu_methods.__index(gpu, key)
  local method = gpu_methods[key]
  if method then return method end
  local c = bound()
  if key == "stats" then return c.gpu_used(gpu) end
  if key == "messages" then return (c.gpu_messages(gpu)) end
  if key == "message" then return (select(2, c.gpu_messages(gpu))) end
  local info = c.gpu_info(gpu)
  if key == "limits" then
    local out = {}
    for _, name in ipairs(limits) do out[name] = info[name] end
    return out
  end
  if key == "name" or key == "type" or key == "driver" or key == "vulkan" then return info[key] end
end

function gpu_methods.__newindex(_, key)
  return check.fail("gpu: cannot set %s", check.describe(key))
end

function gpu_methods.__tostring(gpu)
  return ("ylm.gpu '%s'%s"):format(gpu.name, bound().gpu_state(gpu) and "" or " (closed or lost)")
end

binding.methods("ylm.gpu", gpu_methods)

memory.publish(vulkan)

local names = {}
for name in pairs(vulkan) do names[#names + 1] = name end
table.sort(names)

return setmetatable(vulkan, { __index = function(_, name) return check.no_name("vulkan.", name, names) end })
