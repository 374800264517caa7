--- Arrays in a device's memory: gpu:array, array:to, and their methods.

local array = require "ylm.array"
local binding = require "ylm.vulkan.binding"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local reference = require "ylm.describe"

local arrays = {}
local methods = {}

reference.object "gpu_array" {
  about = "Dense numbers in a device's memory.",
  methods = methods,
  fields = {
    { "shape", "integer[]", "its extents" },
    { "dtype", "string", "'float' or 'double'" },
    { "seconds", "number", "that the upload took" },
  },
}

local bound = binding.bound

--- An array in the device's memory; argument `n` of `name` is the array to copy.
function arrays.upload(gpu, n, name, values)
  if core.type(values) ~= "ylm.array" then values = array.array(values)
  elseif not select(4, core.array_info(values)) then return check.bad(n, name, "the array has been closed") end
  local copy, seconds, code = check.result(name, bound().gpu_upload(gpu, values))
  if not copy then return nil, seconds, code end
  core.own(copy).seconds = seconds
  return copy
end

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
function methods.download(a, given)
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
function methods.close(a)
  if core.type(a) ~= "ylm.gpu_array" then open_array(a, "close") end
  check.result("close", bound().gpu_array_close(a))
end

function methods.__index(a, key)
  local method = methods[key]
  if method then return method end
  local shape, dtype = bound().gpu_array_info(a)
  if key == "shape" then return shape end
  if key == "dtype" then return dtype end
  if key == "seconds" then return core.owned(a, "seconds") end
end

function methods.__newindex(_, key)
  return check.fail("gpu_array: cannot set %s: download it", check.describe(key))
end

function methods.__tostring(a)
  local shape, dtype, _, is_open = bound().gpu_array_info(a)
  return ("ylm.gpu_array %s %s%s"):format(dtype, table.concat(shape, "x"), is_open and "" or " (closed)")
end

binding.methods("ylm.gpu_array", methods)

return arrays
