-- Devices and their work. On Mesa's lavapipe, where there is no other device.

local device = require "spec.support.gpu"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local devices = ylm.vulkan.devices()
local build = os.getenv "YLM_BUILD" or "build"

--- Runs a Lua script in another process with that environment; what it prints, and its exit code.
local function run(environment, text)
  return scratch.capture(("env %s %s -e %s"):format(environment, os.getenv "YLM_LUA" or "lua5.4", scratch.quote(text)))
end

describe("ylm.vulkan without a driver", function()
  local function code_of(environment)
    local out, status = run(environment, [[
      local ylm = require "ylm"
      local gpu, message, code = ylm.vulkan.open()
      local devices, message2, code2 = ylm.vulkan.devices()
      assert(not gpu and not devices and message == message2 and code == code2)
      assert(#ylm.sh.eval(1, { 0, 0, 1 }) == 4) -- the CPU's path is as it was
      io.write(code, ": ", message)]])
    assert(status == 0, out)
    return out
  end

  it("says so, and what to install", function()
    if not scratch.shell("test -f " .. scratch.quote(build .. "/lib/libylm_vulkan.so")) then pending "not built" end
    local out = code_of "VK_ICD_FILENAMES=/nonexistent.json VK_DRIVER_FILES=/nonexistent.json"
    assert.truthy(out:find("^EMISSING: there is no Vulkan driver; install a Vulkan driver %(Debian: mesa%-vulkan%-drivers"), out)
  end)

  it("nor a loader says so too", function()
    if not scratch.shell("test -f " .. scratch.quote(build .. "/lib/libylm_vulkan.so")) then pending "not built" end
    local out = code_of "YLM_VULKAN_LIBRARY=/nonexistent/libvulkan.so"
    assert.truthy(out:find("^EMISSING: there is no Vulkan loader: /nonexistent/libvulkan.so cannot be opened"), out)
    out = code_of "YLM_VULKAN_LIBRARY=libm.so.6"
    assert.truthy(out:find("^EMISSING: libm.so.6 is no Vulkan loader"), out)
  end)

  it("nor the library itself says what to install to build it", function()
    local out, status = run("", [[
      package.preload["ylm.c.vulkan"] = function() error("libylm_vulkan.so: cannot open shared object file", 0) end
      local gpu, message, code = require "ylm".vulkan.open()
      assert(gpu == nil)
      io.write(code, ": ", message)]])
    assert.equal(0, status, out)
    assert.truthy(out:find("^EMISSING: computing on a GPU needs libylm_vulkan: install glslc and libvulkan%-dev"), out)
  end)
end)

describe("ylm.vulkan", function()
  local open = device.each()
  if not open then return end
  local chosen = device.choose()
  local binding = require "ylm.c.vulkan"

  describe("devices", function()
    it("are listed with what they can do", function()
      for _, d in ipairs(devices) do
        assert(#d.name > 0 and d.vulkan:find "^%d+%.%d+%.%d+$")
        assert(({ discrete = 1, integrated = 1, virtual = 1, cpu = 1, other = 1 })[d.type])
        assert(type(d.float64) == "boolean" and d.group_size >= 128 and d.bind_bytes >= 2 ^ 27 - 256)
      end
    end)

    it("are opened by number, by part of the name in any case, and by default", function()
      local name = devices[chosen].name
      local gpu = open()
      assert.equal(name, gpu.name)
      assert.equal(devices[chosen].type, gpu.type)
      assert.equal(devices[chosen].memory_bytes, gpu.limits.memory_bytes)
      assert.truthy(tostring(gpu):find(name, 1, true))
      local part = open { device = name:sub(1, 5):upper() }
      assert.equal(name:sub(1, 5), part.name:sub(1, 5))
      local default = assert(ylm.vulkan.open())
      assert.truthy(#default.name > 0)
      default:close()
    end)

    it("are opened and closed as often as one likes", function() -- a driver that was loaded anew each time ended at the 28th
      for _ = 1, 40 do
        local gpu, why = ylm.vulkan.open { device = chosen }
        assert(gpu, why)
        gpu:close()
      end
    end)

    it("that are not there are refused: a number at the caller's line, a name with those there are", function()
      local ok, message = pcall(ylm.vulkan.open, { device = #devices + 1 })
      assert(not ok and message:find(("open: there are %d devices, no number %d"):format(#devices, #devices + 1), 1, true),
        message)
      local gpu, says, code = ylm.vulkan.open { device = "no such device" }
      assert.is_nil(gpu)
      assert.equal("EMISSING", code)
      assert.truthy(says:find("no such device", 1, true) and says:find(devices[chosen].name, 1, true), says)
    end)

    it("are asked for validation by the environment too", function()
      local out, status = run("YLM_VULKAN_VALIDATION=1 VK_LAYER_PATH=/nonexistent", [[
        local gpu, message, code = require "ylm".vulkan.open()
        io.write(gpu and "opened" or code .. ": " .. message)]])
      assert.equal(0, status)
      assert.truthy(out:find("^EMISSING: the Vulkan validation layer is not installed"), out)
    end)

    it("hear what the validation layer says", function()
      -- an array that outlives its device without our knowing cannot be made: so a bad use of the interface is
      local gpu = device.open { validate = true }
      assert.equal(0, gpu.messages)
      binding.gpu_blunder(gpu)
      assert(gpu.messages >= 1 and #gpu.message > 20, gpu.message)
      gpu:close()
    end)
  end)

  describe("work", function()
    it("is cut into slices that are short, and says how it goes", function()
      local gpu = open()
      binding.gpu_spin(gpu, 1, 1) -- compiles
      local seen, last = 0, -1
      local times, sum = binding.gpu_spin(gpu, 1001, 2000, function(done, total, stage)
        assert(done >= last and done <= total and stage == "spin")
        last, seen = done, seen + 1
      end)
      assert.equal(1001 * 64 * 16, sum)
      assert.equal(10000, last)
      assert(seen >= 1 and times.spin.dispatches > 3)
      assert(times.spin.longest <= times.spin.seconds)
    end)

    it("is cancelled between slices; an error of the progress function is raised again", function()
      local gpu = open()
      local calls = 0
      local times, message, code = binding.gpu_spin(gpu, 20000, 5000, function()
        calls = calls + 1
        return false
      end)
      assert(times == nil and code == "ECANCELLED" and message == "cancelled" and calls == 1)
      local ok, raised = pcall(binding.gpu_spin, gpu, 20000, 5000, function() error("enough", 0) end)
      assert(not ok and raised == "enough")
      local _, sum = binding.gpu_spin(gpu, 3, 10)
      assert.equal(3 * 64 * 16, sum)
    end)

    it("does not let its device be closed", function()
      local gpu = open()
      local ok, message
      binding.gpu_spin(gpu, 2000, 2000, function() ok, message = pcall(gpu.close, gpu) end)
      assert(ok == false and message:find("in use", 1, true), tostring(message))
    end)

    it("on a lost device is nil, message, EDEVICE; the CPU's path goes on", function()
      local gpu = open()
      local there = gpu:array { 1, 2, 3 }
      binding.gpu_lose(gpu)
      for _, f in ipairs {
        function() return there:download() end, function() return gpu:array { 1 } end,
        function() return gpu:peak() end,
      } do
        local nothing, message, code = f()
        assert(nothing == nil and code == "EDEVICE" and message:find("was lost; open it again", 1, true))
      end
      assert.equal(4, #ylm.sh.eval(1, { 0, 0, 1 }))
      there:close()
    end)
  end)
end)
