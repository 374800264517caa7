-- Arrays in a device's memory: there and back, counted, closed. On Mesa's lavapipe, where there is no other device.

local ylm = require "ylm"
local device = require "spec.support.gpu"
local memory = require "ylm.memory"

describe("ylm.vulkan", function()
  local open = device.each()
  if not open then return end
  local binding = require "ylm.c.vulkan"

  describe("arrays", function()
    for _, staging in ipairs { false, true } do
      it("come back as they went" .. (staging and ", by staging memory" or ""), function()
        local gpu = open { staging = staging }
        for _, dtype in ipairs { "float", "double" } do
          for _, shape in ipairs { { 1 }, { 0, 3 }, { 7 }, { 3, 5, 2 }, { 10007, 3 }, { 1100000, 2 } } do
            local a = ylm.zeros(shape, dtype)
            local flat = a:reshape({ #a == 0 and 0 or a.shape[1] * (a.shape[2] or 1) * (a.shape[3] or 1) })
            for i = 1, #flat, 1 + math.floor(#flat / 100) do flat:set(i, i / 3) end
            if #flat > 0 then flat:set(#flat, -1) end
            local there = a:to(gpu)
            assert.same(a.shape, there.shape)
            assert.equal(dtype, there.dtype)
            assert(there.seconds >= 0)
            local back, seconds = there:download()
            assert(seconds >= 0)
            assert.same(a.shape, back.shape)
            local other = back:reshape({ #flat })
            for i = 1, #flat, 1 + math.floor(#flat / 1000) do assert.equal(flat[i], other[i]) end
            if #flat > 0 then assert.equal(-1, other[#flat]) end
            there:close()
          end
        end
        assert(gpu.stats.uploaded == gpu.stats.downloaded and gpu.stats.uploaded > 8e6)
        assert.equal(0, gpu.stats.arrays)
      end)
    end

    it("are made from tables, and downloaded into arrays that fit", function()
      local gpu = open()
      local there = gpu:array { { 1, 2 }, { 3, 4 } }
      local out = ylm.zeros({ 2, 2 })
      assert.equal(out, (there:download { out = out }))
      assert.equal(3, out:get(2, 1))
      for _, case in ipairs { { ylm.zeros({ 2, 2 }, "float"), "type" }, { ylm.zeros({ 4 }), "shape" } } do
        local ok, message = pcall(there.download, there, { out = case[1] })
        assert(not ok and message:find(case[2]), message)
      end
      local ok, message = pcall(gpu.array, gpu, 1)
      assert(not ok and message:find("a table of numbers or an array expected, got 1", 1, true), message)
    end)

    it("of many sizes share memory, whatever the order in which they go", function()
      local gpu, held, seed = open(), {}, 1
      for i = 1, 600 do
        seed = seed * 16807 % 2147483647
        local slot = seed % 60 + 1
        if held[slot] then
          local row = held[slot]:download()
          assert.equal(slot, row[1])
          assert.equal(slot, row[#row])
          held[slot]:close()
          held[slot] = nil
        else
          local a = ylm.zeros({ i * seed % 40000 + 1 }, "float")
          a:set(1, slot)
          a:set(#a, slot)
          held[slot] = a:to(gpu)
        end
      end
    end)

    it("larger than the device's memory are nil, message, ENOMEM", function()
      local gpu = open()
      local a, message, code = memory.attempt(binding.gpu_array_new, gpu,
        { math.floor(gpu.limits.memory_bytes / 4) + 2 ^ 20 }, "float")
      assert.is_nil(a)
      assert.equal("ENOMEM", code)
      assert.truthy(message:find("has %d+ MiB of memory, %d+ are needed"), message)
    end)

    it("keep their device open, and are refused once it is closed", function()
      local gpu = device.open { validate = true }
      local there = gpu:array { 1, 2, 3 }
      gpu = nil -- luacheck: ignore
      collectgarbage()
      collectgarbage()
      assert.equal(3, (there:download())[3])
      there = nil -- luacheck: ignore
      collectgarbage()
      collectgarbage()
      local again = open()
      local orphan, closed = again:array { 1, 2, 3 }, again:array { 1 }
      closed:close()
      closed:close()
      again:close()
      again:close()
      for _, f in ipairs {
        function() return orphan:download() end, function() return again:array { 1 } end,
        function() return again:peak() end, function() return ylm.zeros({ 1 }):to(again) end,
      } do
        local ok, message = pcall(f)
        assert(not ok and message:find("the device has been closed", 1, true), tostring(message))
      end
      local ok, message = pcall(closed.download, closed)
      assert(not ok and message:find("the array has been closed", 1, true), message)
      orphan:close()
    end)

    it("are collected in any order", function()
      for order = 1, 2 do
        local gpu = device.open { validate = true }
        local held = { gpu = gpu, list = {} }
        for i = 1, 20 do held.list[i] = gpu:array { i } end
        if order == 1 then held.list = nil else gpu, held.gpu = nil, nil end -- luacheck: ignore
        collectgarbage()
        collectgarbage()
        if held.gpu then assert.equal(0, held.gpu.stats.arrays) end
        gpu, held = nil, nil -- luacheck: ignore
        collectgarbage()
        collectgarbage()
      end
    end)
  end)
end)
