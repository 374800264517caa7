-- Refusals of computing on a device: see spec/refusals_spec.lua. Nothing here needs a driver.

local objects = require "ylm.describe".objects

local rows = require "spec.support.refused"

--- A method of an object that only a device makes.
local function method(object, name)
  return function(...) return objects[object].methods[name](...) end
end

return {
  ["vulkan.devices"] = rows(
    function(ylm) return ylm.vulkan.devices(1) end, "no argument expected, got 1"),
  ["vulkan.open"] = rows(
    function(ylm) return ylm.vulkan.open("lavapipe") end, "a table of options expected, got 'lavapipe'",
    function(ylm) return ylm.vulkan.open { devices = 1 } end, "no field 'devices' %(did you mean 'device'%?%)",
    function(ylm) return ylm.vulkan.open { device = 0 } end, "device must be a number from 1, or part of a device's name, got 0",
    function(ylm) return ylm.vulkan.open { device = 1.5 } end, "device must be",
    function(ylm) return ylm.vulkan.open { device = "" } end, "device must be",
    function(ylm) return ylm.vulkan.open { validate = 1 } end, "validate must be true or false"),
  ["gpu:array"] = rows(
    function() return method("gpu", "array")({}, { 1 }) end, "a gpu expected before the colon, got a table"),
  ["gpu:peak"] = rows(
    function() return method("gpu", "peak")(nil) end, "a gpu expected before the colon, got nil"),
  ["gpu:close"] = rows(
    function() return method("gpu", "close")("x") end, "a gpu expected before the colon, got 'x'"),
  ["gpu:lights"] = rows(
    function(ylm) return method("gpu", "lights")({}, ylm.sphere_light { at = { 0, 0, 0 } }) end,
      "a gpu expected before the colon, got a table"),
  ["gpu_lights:close"] = rows(
    function() return method("gpu_lights", "close")(nil) end, "gpu_lights expected before the colon, got nil"),
  ["gpu_array:download"] = rows(
    function(ylm) return method("gpu_array", "download")(ylm.zeros { 2 }) end, "a gpu_array expected before the colon, got an array of 2"),
  ["gpu_array:close"] = rows(
    function() return method("gpu_array", "close")(1) end, "a gpu_array expected before the colon, got 1"),
  ["gpu_grid:close"] = rows(
    function() return method("gpu_grid", "close")({}) end, "a gpu_grid expected before the colon, got a table"),
  ["grid:to"] = rows(
    function(ylm)
      local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 0 },
        ylm.sphere_light { at = { 0, 2, 0 } })
      return grid:to()
    end, "a gpu expected, got nil"),
  ["array:to"] = rows(
    function(ylm) return ylm.zeros({ 2 }):to(1) end, "a gpu expected, got 1",
    function(ylm) return ylm.zeros({ 2 }):to() end, "a gpu expected, got nil",
    function(ylm)
      local a = ylm.zeros { 2 }
      a:close()
      return a:to()
    end, "to: the array has been closed"),
}
