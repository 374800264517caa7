-- A driver whose functions fail, one after the other: what calls say, and that everything goes on.

local binding = require "ylm.c.vulkan"
local core = require "ylm.c.core"
local ylm = require "ylm"
local device = require "spec.support.gpu"
local long = require "spec.support.long"

describe("a driver that fails", function()
  local chosen, missing = device.choose()
  if not chosen then pending("no Vulkan device: " .. missing) return end

  local points = { { 1, 2, 3 }, { -1, 0.5, 0.25 }, { 0, 0, -2 } }

  --- Work that needs a pipeline which no other i needs: on a device, or by the processor.
  local function work(i, gpu)
    return ylm.sh.eval((i - 1) % 5, points, { derivatives = math.floor((i - 1) / 5) % 3, solid = i > 15, device = gpu })
  end

  local function right(i, result)
    local _, e = core.array_distance(result, (work(i)))
    assert(e <= 1e-5, e)
  end

  --- Breaks the driver's functions in turn; calls after(gpu, i, name) with each mended again. Returns how many calls failed.
  local function each(open, how, code, after)
    local failures, i, gpu = 0, 1, nil
    while true do
      gpu = open(gpu)
      local name = binding.gpu_break(gpu, i, how)
      if not name then break end
      local result, message, says = work(i, gpu)
      if result then right(i, result) -- by a device that did not need the function
      else
        failures = failures + 1
        assert.equal(code, says, name)
        assert(#message > 0)
        right(i, (work(i)))
      end
      binding.gpu_break(gpu, i, "none")
      after(gpu, i, name, result == nil)
      i = i + 1
    end
    device.close_silent(gpu)
    return failures
  end

  for _, staging in ipairs { false, true } do
    local where = staging and ", with staging memory" or ""
    local function fresh() return device.open { validate = true, staging = staging } end

    for how, code in pairs { memory = "ENOMEM", unknown = (not staging or long(false, true)) and "EDEVICE" or nil } do
      it(("says %s and works again afterwards%s"):format(code, where), function()
        local failures = each(function(gpu) return gpu or fresh() end, how, code, function(gpu, i, name)
          local result, message = work(i, gpu)
          assert(result, ("%s: %s"):format(name, message))
          right(i, result)
        end)
        assert(failures >= 14, failures)
      end)
    end

    local lost = long(not staging, true) and it or function() end
    lost("says EDEVICE from the moment the device is lost" .. where, function()
      local failures = each(function(gpu)
        if gpu then device.close_silent(gpu) end
        return fresh()
      end, "lost", "EDEVICE", function(gpu, i, name, failed)
        local result, message, code = work(i, gpu)
        assert(failed == (result == nil), name)
        if failed then
          assert.equal("EDEVICE", code)
          assert(message:find "was lost" and message:find "open it again", message)
        end
      end)
      assert(failures >= 14, failures)
    end)
  end

  it("lights and grids on a device are of use after it ran out of memory", function()
    local gpu = device.open { validate = true }
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.25, radiance = { 1, 2, 3 } }
    local here = ylm.light_field(2, lamp, points)
    local there = gpu:lights(lamp)
    local i, failures = 1, 0
    while binding.gpu_break(gpu, i, "memory") do
      local L, _, code = ylm.light_field(2, there, points)
      if not L then
        failures = failures + 1
        assert.equal("ENOMEM", code)
      end
      binding.gpu_break(gpu, i, "none")
      L = assert(ylm.light_field(2, there, points))
      local _, e = core.array_distance(L, here)
      assert(e <= 1e-5, e)
      i = i + 1
    end
    assert(failures >= 6, failures)
    there:close()
    device.close_silent(gpu)
  end)
end)
