-- Spherical harmonics evaluated on a device, against the processor's. On Mesa's lavapipe, where there is no other device.

local ylm = require "ylm"
local device = require "spec.support.gpu"

describe("ylm.vulkan", function()
  local open = device.each()
  if not open then return end
  local binding = require "ylm.c.vulkan"

  describe("sh.eval", function()
    local core = require "ylm.c.core"

    --- n points of all lengths, the poles and their neighbourhood first.
    local function points(n, dtype)
      local rows, seed = { { 0, 0, 2 }, { 0, 0, -0.5 }, { 1e-4, -1e-4, 1 }, { 1e-5, 0, -1 } }, 11
      local function random()
        seed = seed * 16807 % 2147483647
        return seed / 2147483647 * 2 - 1
      end
      for i = #rows + 1, n do rows[i] = { random(), random(), random() } end
      for i = #rows, n + 1, -1 do rows[i] = nil end
      if n == 0 then return ylm.zeros({ 0, 3 }, dtype) end
      return ylm.array(rows, dtype)
    end

    local bound = { float = 1e-5, double = 1e-12 }

    --- Fails unless the device's results are those of the CPU in double at the same points.
    local function compare(gpu, lmax, n, dtype, options)
      local p = points(n, dtype)
      options.device = gpu
      local got = { assert(ylm.sh.eval(lmax, p, options)) }
      options.device = nil
      local wanted = { ylm.sh.eval(lmax, ylm.array(p, "double"), options) }
      assert.equal(#wanted, #got)
      for k = 1, #wanted do
        assert.equal(dtype, got[k].dtype)
        assert.same(wanted[k].shape, got[k].shape)
        local e = core.sh_error(lmax, got[k], wanted[k])
        assert(e <= bound[dtype], ("lmax %d, %d points, %s, order %d: %g"):format(lmax, n, dtype, k - 1, e))
      end
    end

    it("agrees with the CPU for lmax 0 to 10, values, gradients and Hessians, in float", function()
      local gpu = open()
      for lmax = 0, 10 do compare(gpu, lmax, 65 + lmax, "float", { derivatives = 2 }) end
    end)

    it("agrees with the CPU in double, of solid harmonics, of high degrees, and in sizes of all kinds", function()
      local gpu = open()
      if not gpu.limits.float64 then pending "the device has no float64" end
      compare(gpu, 3, 64, "double", { derivatives = 2 })
      compare(gpu, 6, 1, "double", { derivatives = 1 })
      compare(gpu, 2, 129, "double", { derivatives = 1, solid = true })
      compare(gpu, 9, 63, "float", { derivatives = 2, solid = true })
      compare(gpu, 0, 10007, "float", { derivatives = 0 })
      compare(gpu, 31, 3, "double", { derivatives = 2 })
      compare(gpu, 4, 0, "float", { derivatives = 2 })
      local Y = ylm.sh.eval(1, { 0, 0, 3 }, { device = gpu })
      assert.is_near(math.sqrt(3 / (4 * math.pi)), Y[3], 1e-15)
    end)

    it("goes in passes where results are many, and can be cancelled", function()
      local gpu = open()
      local before = gpu.stats.submissions
      compare(gpu, 20, 4000, "float", { derivatives = 2 }) -- 71 MB
      assert(gpu.stats.submissions > before + 1)
      local done = -1
      local Y, message, code = ylm.sh.eval(20, points(4000, "float"), { device = gpu, derivatives = 2,
        progress = function(d, total)
          assert(d >= done and d <= total)
          done = d
          return false
        end })
      assert(Y == nil and message == "cancelled" and code == "ECANCELLED")
      assert.equal(0, gpu.stats.arrays)
    end)

    it("refuses what the CPU refuses, and what a device cannot do", function()
      local gpu = open()
      local function says(text, ...)
        local ok, message = pcall(ylm.sh.eval, ...)
        assert(not ok and message:find(text, 1, true), tostring(message))
      end
      says("point 2 is zero: it has no direction", 2, { { 0, 0, 1 }, { 0, 0, 0 } }, { device = gpu })
      says("row 1 is not finite", 2, { { 0, 0 / 0, 1 } }, { device = gpu })
      says("too long: |v|^60 overflows", 60, { { 0, 0, 1e10 } }, { device = gpu, solid = true })
      says("too short: derivatives overflow", 2, { { 0, 0, 1e-300 } }, { device = gpu, derivatives = 2 })
      says("float on a device goes to lmax 128", 129, { { 0, 0, 1 } }, { device = gpu, dtype = "float" })
      says("device goes with method 'solid'", 2, { { 0, 0, 1 } }, { device = gpu, method = "sloan" })
      says("device must be an open device", 2, { { 0, 0, 1 } }, { device = 1 })
      binding.gpu_lose(gpu)
      local Y, message, code = ylm.sh.eval(1, { 0, 0, 1 }, { device = gpu })
      assert(Y == nil and code == "EDEVICE" and message:find("was lost", 1, true))
      local closed = open()
      closed:close()
      says("the device has been closed", 1, { 0, 0, 1 }, { device = closed })
    end)
  end)
end)
