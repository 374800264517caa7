--- Compute on a graphics processor: ylm.vulkan.devices, ylm.vulkan.open, and what is kept in its memory.
--
-- libylm_vulkan.so is loaded when it is first needed; it opens libvulkan itself.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local library = require "ylm.library"
local memory = require "ylm.memory"
local reference = require "ylm.describe"
local grid_methods = require "ylm.vulkan.grid".methods

local vulkan = {}

--- Methods of ylm.gpu and ylm.gpu_array; they are there before the binding is loaded.
local gpu_methods, array_methods = {}, {}

local limits = { "float64", "int64", "timestamps", "subgroup", "binds", "group_size", "groups", "shared_bytes",
  "bind_bytes", "allocation_bytes", "memory_bytes" }

reference.object "gpu" {
  about = "An open device. What lies in its memory keeps it open, unless it is closed.",
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
reference.object "gpu_array" {
  about = "Dense numbers in a device's memory.",
  methods = array_methods,
  fields = {
    { "shape", "integer[]", "its extents" },
    { "dtype", "string", "'float' or 'double'" },
    { "seconds", "number", "that the upload took" },
  },
}

gpu_methods.lights = require "ylm.vulkan.light".lights

local INSTALL = "computing on a GPU needs libylm_vulkan: install glslc and libvulkan-dev and run make again (%s)"

--- Array in the device's memory -> seconds that its upload took.
local upload_seconds = setmetatable({}, { __mode = "k" })

local furnished = false

--- Gives the binding's object types their methods and fields.
local function furnish()
  furnished = true
  local types = { ["ylm.gpu"] = gpu_methods, ["ylm.gpu_array"] = array_methods,
    ["ylm.gpu_lights"] = require "ylm.vulkan.light".methods, ["ylm.gpu_grid"] = grid_methods }
  for name, methods in pairs(types) do
    local metatable = core.metatable(name)
    for key, method in pairs(methods) do metatable[key] = method end
    memory.publish(metatable)
  end
end

--- The binding of libylm_vulkan.so, or nil, message, "EMISSING" | "ENOMEM".
function vulkan.__binding()
  local binding, message, code = library.open("vulkan", INSTALL)
  if not binding then return nil, message, code end
  if not furnished then furnish() end
  return binding
end

--- The binding where there is an object of its own already.
local function bound() return assert(vulkan.__binding()) end

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
  local binding, message, code = vulkan.__binding()
  if not binding then return nil, message, code end
  return check.result("devices", binding.gpu_devices())
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
  local binding, message, code = vulkan.__binding()
  if not binding then return nil, message, code end
  local index = type(o.device) == "number" and o.device or nil
  return check.result("open", binding.gpu_open(index, not index and o.device or nil, o.validate, o.staging))
end

-- Devices -----------------------------------------------------------------------------

local function is_gpu(g, name)
  if core.type(g) ~= "ylm.gpu" then
    return check.fail("%s: a gpu expected before the colon, got %s", name, check.describe(g))
  end
  return g
end

--- Argument `n` of function `name`: the binding for an open device, or nil, message, code (lost); raises if closed.
function vulkan.__use(n, name, gpu)
  if core.type(gpu) ~= "ylm.gpu" then return check.bad(n, name, "a gpu expected, got %s", check.describe(gpu)) end
  local binding = bound()
  local ok, message, code = check.result(name, binding.gpu_state(gpu))
  if not ok then return nil, message, code end
  return binding
end

--- An array in the device's memory; argument `n` of `name` is the array to copy.
local function upload(gpu, n, name, values)
  if core.type(values) ~= "ylm.array" then values = require "ylm.array".array(values)
  elseif not select(4, core.array_info(values)) then return check.bad(n, name, "the array has been closed") end
  local copy, seconds, code = check.result(name, bound().gpu_upload(gpu, values))
  if not copy then return nil, seconds, code end
  upload_seconds[copy] = seconds
  return copy
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
  return upload(gpu, 1, "array", values)
end

--- array:to(gpu).
function vulkan.__to(array, gpu)
  if core.type(gpu) ~= "ylm.gpu" then return check.bad(1, "to", "a gpu expected, got %s", check.describe(gpu)) end
  return upload(gpu, 1, "to", array)
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
  local binding = bound()
  if key == "stats" then return binding.gpu_used(gpu) end
  if key == "messages" then return (binding.gpu_messages(gpu)) end
  if key == "message" then return (select(2, binding.gpu_messages(gpu))) end
  local info = binding.gpu_info(gpu)
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

-- Arrays --------------------------------------------------------------------------------

local function open_array(a, name)
  if core.type(a) ~= "ylm.gpu_array" then
    return check.fail("%s: a gpu_array expected before the colon, got %s", name, check.describe(a))
  end
  if not select(4, bound().gpu_array_info(a)) then return check.fail("%s: the array has been closed", name) end
  return a
end

local download_options = { { "out", "array", optional = true, about = "the array to be written and returned" } }

describe "gpu_array:download" {
  about = "Copies the array from the device's memory.",
  arguments = { { "options?", "table", "see the options" } },
  options = download_options,
  returns = {
    { "a", "array", "of the same shape and type; or nil, message, code: 'ENOMEM', 'EDEVICE'" },
    { "seconds", "number", "that it took" },
  },
  errors = "raises where the array or its device has been closed, and where out is of another shape or type",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then
  local a, seconds = gpu:array({ 1, 2, 3 }):download()
  assert(#a == 3 and seconds >= 0)
end]],
}
function array_methods.download(a, given)
  open_array(a, "download")
  local o = form.options(1, "download", download_options, given)
  if o.out and not select(4, core.array_info(o.out)) then
    return check.bad(1, "download", "out: the array has been closed")
  end
  if o.out then check.result("download", core.array_is_free(o.out)) end
  return check.result("download", bound().gpu_download(a, o.out))
end

describe "gpu_array:close" {
  about = "Gives back the memory at once.",
  arguments = {},
  returns = {},
  errors = "raises from the progress function of a call that uses the array",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then gpu:array({ 1, 2, 3 }):close() end]],
}
function array_methods.close(a)
  if core.type(a) ~= "ylm.gpu_array" then open_array(a, "close") end
  check.result("close", bound().gpu_array_close(a))
end

function array_methods.__index(a, key)
  local method = array_methods[key]
  if method then return method end
  local shape, dtype = bound().gpu_array_info(a)
  if key == "shape" then return shape end
  if key == "dtype" then return dtype end
  if key == "seconds" then return upload_seconds[a] end
end

function array_methods.__newindex(_, key)
  return check.fail("gpu_array: cannot set %s: download it", check.describe(key))
end

function array_methods.__tostring(a)
  local shape, dtype, _, is_open = bound().gpu_array_info(a)
  return ("ylm.gpu_array %s %s%s"):format(dtype, table.concat(shape, "x"), is_open and "" or " (closed)")
end

return memory.publish(vulkan)
