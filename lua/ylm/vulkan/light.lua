--- Lights in a device's memory: gpu:lights, and what the option `device` of other functions does with lights.

local binding = require "ylm.vulkan.binding"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local light = require "ylm.light"
local reference = require "ylm.describe"

local vulkan_light = {}

local methods = {}
vulkan_light.methods = methods

reference.object "gpu_lights" {
  about = "Lights in a device's memory; stands wherever lights stand.",
  methods = methods,
  fields = {
    { "count", "integer", "lights" },
    { "method", "string", "how they are summed" },
    { "stages", "table", "what was done so far: by stage { seconds, longest (dispatch), dispatches }; upload and download "
      .. "by the host's clock" },
  },
}

local bound = binding.bound

local NO_OTHERS = "a device sums sphere, polygon, disk and textured lights; no others"

--- A packed object, argument `n` of `name`, if it is a set of lights.
local function lights_of(n, name, packed)
  if light.followed(packed) then return packed end
  return check.bad(n, name, NO_OTHERS .. (light.other(packed) == "virtual lights" and ", and here are virtual lights" or ""))
end

--- The gpu of lights that are on one.
function vulkan_light.gpu_of(lights) return core.owned(lights, "gpu") end

--- Lights -> the object on the device.
local function create(name, gpu, packed, method)
  local c, message, code = binding.use(name, gpu)
  if not c then return nil, message, code end
  local lights
  lights, message, code = check.result(name, c.gpu_lights_create(gpu, packed, method))
  if not lights then return nil, message, code end
  core.own(lights).gpu = gpu
  return lights
end

local lights_options = {
  { "method", "choice", shelf = "comparison", of = core.choices "sums", default = "merged",
    about = "merged moments, or the product rule for each light (lmax <= 8, for comparison): all orders m at once, or "
      .. "one after the other; exact flat lights are only summed with merged" },
}

describe "gpu:lights" {
  about = "Copies lights to the device's memory, for light_field and bake, which then compute there. Exact flat lights are "
    .. "summed in double.",
  arguments = {
    { "lights", "light|list", "sphere, polygon, disk and textured lights" },
    { "options?", "table", "see the options" },
  },
  options = lights_options,
  returns = { { "lights", "gpu_lights", "or nil, message, code: 'ENOMEM', 'ELIMIT', 'EDEVICE', 'EMISSING' (exact flat "
    .. "lights on a device without float64)" } },
  errors = "raises on other lights, and where the device has been closed",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then
  local lamps = gpu:lights(ylm.sphere_light { at = { 0, 2, 0 } })
  assert(#ylm.light_field(2, lamps, { { 0, 0, 0 } }) == 1 and lamps.count == 1)
end]],
  source = "Mezieres et al. 2022, Sec. 5.1 (reversed), Eqs. 24-28 (flat lights); Iwasaki & Dobashi 2025, Eqs. 6, 15",
}
function vulkan_light.lights(gpu, lights, given)
  if core.type(gpu) ~= "ylm.gpu" then
    return check.fail("lights: a gpu expected before the colon, got %s", check.describe(gpu))
  end
  local o = form.options(2, "lights", lights_options, given)
  local packed = light.pack(1, "lights", lights)
  return create("lights", gpu, lights_of(1, "lights", packed), o.method)
end

--- The object with a light field on the gpu, and whether it was made for this call. `name` is the
-- function that asks, with the option `method` (argument `n`).
function vulkan_light.on(gpu, n, name, object, method)
  if core.type(object) == "ylm.gpu_lights" then
    if not bound().gpu_lights_on(object, gpu) then return check.bad(n, name, "device: the lights are on another") end
    if method and method ~= object.method then return check.bad(n, name, "method: gpu:lights has chosen it") end
    return object
  end
  local lights, message, code = create(name, gpu, lights_of(2, name, object), method or "merged")
  if not lights then return nil, message, code end
  return lights, true
end

--- Times by stage of lights on a device, less what they were before.
function vulkan_light.times(object, before)
  local times = bound().gpu_lights_times(object)
  for stage, t in pairs(times) do
    local b = before and before[stage]
    if b then t.seconds, t.dispatches = t.seconds - b.seconds, t.dispatches - b.dispatches end
  end
  return times
end

--- Are these lights of a device to be used still?
function vulkan_light.is_open(lights) return bound().gpu_lights_info(lights) ~= nil end

describe "gpu_lights:close" {
  about = "Gives back the memory at once.",
  arguments = {},
  returns = {},
  errors = "raises from the progress function of a call that uses the lights",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then gpu:lights(ylm.sphere_light { at = { 0, 2, 0 } }):close() end]],
}
function methods.close(lights)
  if core.type(lights) ~= "ylm.gpu_lights" then
    return check.fail("close: gpu_lights expected before the colon, got %s", check.describe(lights))
  end
  check.result("close", bound().gpu_lights_close(lights))
end

function methods.__index(lights, key)
  if methods[key] then return methods[key] end
  local count, method = bound().gpu_lights_info(lights)
  if not count then return check.fail("gpu_lights: the lights have been closed") end
  if key == "count" then return count end
  if key == "method" then return method end
  if key == "stages" then return bound().gpu_lights_times(lights) end
end

function methods.__newindex(_, key)
  return check.fail("gpu_lights: cannot set %s", check.describe(key))
end

function methods.__tostring(lights)
  local count, method = bound().gpu_lights_info(lights)
  return count and ("ylm.gpu_lights %d, %s"):format(count, method) or "ylm.gpu_lights (closed)"
end

binding.methods("ylm.gpu_lights", methods)

return vulkan_light
