-- Devices, their memory and their work. On Mesa's lavapipe, where there is no other device.

local device = require "spec.support.gpu"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local devices, missing = ylm.vulkan.devices()
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
  if not devices then
    it("computes", function() pending("no Vulkan device: " .. missing) end)
    return
  end

  local chosen, opened = device.choose(), {}

  local function open(options)
    options = options or {}
    if options.validate == nil then options.validate = true end
    local gpu = device.open(options)
    opened[#opened + 1] = gpu
    return gpu
  end

  after_each(function()
    for _, gpu in ipairs(opened) do device.close_silent(gpu) end
    opened = {}
  end)

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
      local a, message, code = binding.gpu_array_new(gpu, { math.floor(gpu.limits.memory_bytes / 4) + 2 ^ 20 }, "float")
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

  describe("grid:sample", function()
    local lamps = { ylm.sphere_light { at = { 0.3, 1.4, -0.2 }, radius = 0.1, radiance = { 10, 8, 6 } },
      ylm.sphere_light { at = { -1.2, -0.4, 0.6 }, radius = 0.2, radiance = { 1, 2, 3 } } }
    local bounds = { { -1, -1, -1 }, { 1, 1, 1.5 } }

    local function random_points(n, seed, reach, dtype)
      local rows = {}
      local function random()
        seed = seed * 16807 % 2147483647
        return (seed / 2147483647 * 2 - 1) * reach
      end
      for i = 1, n do rows[i] = { random(), random(), random() } end
      rows[1] = { -1, -1, -1 }
      if n > 1 then rows[2] = { 1, 1, 1.5 } end
      if n > 2 then rows[3] = { 0, 0.5, 0.25 } end
      return ylm.array(rows, dtype)
    end

    --- The largest difference relative to the largest value; NaN must meet NaN.
    local function difference(a, b)
      assert.same(b.shape, a.shape)
      local n = 1
      for _, extent in ipairs(b.shape) do n = n * extent end
      local x, y = a:reshape({ n }):totable(), b:reshape({ n }):totable()
      local largest, most = 0, 0
      for i = 1, n do
        if y[i] ~= y[i] then assert(x[i] ~= x[i], "NaN is missing at " .. i)
        else
          largest = math.max(largest, math.abs(y[i]))
          local d = math.abs(x[i] - y[i])
          assert(d == d, "NaN at " .. i)
          most = math.max(most, d)
        end
      end
      return largest > 0 and most / largest or most
    end

    local function compare(gpu, grid, points, options)
      options.derivatives = options.derivatives or 1
      local c, dc, report = grid:sample(points, options)
      options.device = gpu
      local gc, gdc, there = grid:sample(points, options)
      assert(gc, gdc)
      local e = difference(gc, c)
      assert(e <= 1e-5, "values: " .. e)
      assert.equal(c.dtype, gc.dtype)
      if dc then
        e = difference(gdc, dc)
        assert(e <= 1e-5, "gradients: " .. e)
      end
      assert.equal(report.outside, there.outside)
      assert.equal(report.unbaked, there.unbaked)
      assert(#points == 0 or there.stages.sample.seconds >= 0 and there.seconds > 0)
    end

    it("agrees with the CPU on uniform grids, inside and outside", function()
      local gpu = open()
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = { 3, 4, 5 }, lmax = 4 }, lamps)
      for _, interpolation in ipairs { "hermite", "taylor", "linear" } do
        compare(gpu, grid, random_points(301, 3, 1.3, "double"), { interpolation = interpolation })
      end
      compare(gpu, grid, random_points(100, 5, 1.6, "float"), { outside = "nan" })
      compare(gpu, grid, random_points(1, 5, 1, "double"), { derivatives = 0, dtype = "double" })
      compare(gpu, grid, ylm.zeros { 0, 3 }, {})
      assert(gpu.stats.arrays > 0)
      local one = grid:sample({ 0, 0, 0 }, { device = gpu })
      assert.same({ 3, 25 }, one.shape)
    end)

    it("agrees with the CPU on adaptive grids of all kinds", function()
      local gpu = open()
      local floor = {}
      for i = 0, 15 do for j = 0, 15 do floor[#floor + 1] = { i / 7.5 - 1, -0.6, j / 7.5 - 1 } end end
      local points = random_points(1501, 9, 1.2, "double")
      for _, o in ipairs { { tolerance = 0.02, continuous = true }, { threshold = 1, continuous = true },
        { threshold = 1, continuous = false } } do
        local grid = ylm.bake(ylm.adaptive_grid { bounds = bounds, lmax = 2, depth = 5, tolerance = o.tolerance,
          threshold = o.threshold, continuous = o.continuous, channels = "luminance" }, lamps, { occupied = floor })
        assert(grid.stats.levels > 3)
        compare(gpu, grid, points, {})
        compare(gpu, grid, ylm.array(floor, "float"), { derivatives = 0, interpolation = "linear" })
      end
    end)

    it("agrees on uniform grids with empty voxels, whose nearest voxel the host finds", function()
      local gpu = open()
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 6, lmax = 1 }, lamps,
        { occupied = { { -0.9, -0.9, -0.9 }, { 0.4, 0.1, 0.3 } } })
      compare(gpu, grid, random_points(500, 13, 1.2, "double"), {})
    end)

    it("uses the copy of grid:to, goes in passes, and can be cancelled", function()
      local gpu = open { staging = true }
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 2, lmax = 8 }, lamps)
      local copy = grid:to(gpu)
      assert(copy.bytes > 27 * 4 * 3 * 81 * 4 - 1 and copy.seconds >= 0)
      local uploaded = gpu.stats.uploaded
      local points = random_points(70000, 17, 1, "float") -- 68 MB of results
      local out, calls = ylm.zeros({ 70000, 3, 81 }, "float"), 0
      local c = assert(grid:sample(points, { device = gpu, out = out, progress = function() calls = calls + 1 end }))
      assert.equal(out, c)
      assert.equal(2, calls)
      assert(gpu.stats.uploaded - uploaded <= 70000 * 24)
      local wanted = grid:sample(points)
      for _, i in ipairs { 1, 2, 34999, 69000, 70000 } do assert(difference(c[i], wanted[i]) <= 1e-5) end
      local nothing, message, code = grid:sample(points, { device = gpu, progress = function() return false end })
      assert(nothing == nil and message == "cancelled" and code == "ECANCELLED")
      assert.equal(copy, grid:to(gpu)) -- it is the grid as it is
      copy:close()
      copy:close()
      assert(grid:sample({ { 0, 0, 0 } }, { device = gpu }))
      local ok, says = pcall(grid.sample, grid, { { 0, 0, 0 } }, { device = gpu, dtype = "double",
        out = ylm.zeros({ 1, 3, 81 }) })
      assert(not ok and says:find("results are float", 1, true), says)
      binding.gpu_lose(gpu)
      nothing, message, code = grid:sample(points, { device = gpu })
      assert(nothing == nil and code == "EDEVICE" and message:find("was lost", 1, true))
      grid:close()
      ok, says = pcall(grid.to, grid, gpu)
      assert(not ok and says:find("the grid has been closed", 1, true), says)
    end)
  end)

  describe("grid:sample of arrays on the device", function()
    local lamp = ylm.sphere_light { at = { 0.3, 1.4, -0.2 }, radius = 0.1, radiance = { 10, 8, 6 } }
    local bounds = { { -1, -1, -1 }, { 1, 1, 1 } }
    local function some_points(n, dtype)
      local rows, seed = {}, 77
      local function random()
        seed = seed * 16807 % 2147483647
        return seed / 2147483647 * 2.4 - 1.2
      end
      for i = 1, n do rows[i] = { random(), random(), random() } end
      return ylm.array(rows, dtype)
    end
    local function near(a, b)
      local _, e, n = require "ylm.c.core".array_distance(a, b)
      assert(e <= 1e-6 * n, e / n)
    end

    it("leaves results there; nothing travels but what is asked for", function()
      local gpu = open()
      for _, dtype in ipairs(gpu.limits.float64 and { "float", "double" } or { "float" }) do
        local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = { 4, 3, 5 }, lmax = 3 }, lamp)
        local here = some_points(1000, dtype)
        local there = here:to(gpu)
        grid:to(gpu)
        local before, c, dc, report = gpu.stats, grid:sample(there, { device = gpu, derivatives = 1 })
        assert(c, dc)
        local after = gpu.stats
        assert.equal(before.uploaded, after.uploaded)
        assert(after.downloaded - before.downloaded <= 12) -- counts
        assert(report.stages.upload == nil and report.stages.download == nil and report.stages.sort.seconds >= 0)
        local wanted, slopes, plain = grid:sample(here, { derivatives = 1 })
        assert.same(wanted.shape, c.shape)
        assert.equal("float", c.dtype)
        near(c:download(), wanted)
        near(dc:download(), slopes)
        assert.equal(plain.outside, report.outside)
        -- arrays of the host take results of points on the device, and the other way round
        local out = ylm.zeros({ 1000, 3, 16 }, "float")
        assert.equal(out, (grid:sample(there, { device = gpu, out = out })))
        near(out, wanted)
        assert.equal(c, (grid:sample(here, { device = gpu, out = c, interpolation = "linear" })))
        near(c:download(), (grid:sample(here, { interpolation = "linear" })))
        assert.equal(dc, (select(2, grid:sample(here, { device = gpu, out = { c, dc }, derivatives = 1 }))))
        near(dc:download(), slopes)
      end
    end)

    it("has the host answer where it has to", function()
      local gpu = open()
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 6, lmax = 1 }, lamp,
        { occupied = { { -0.9, -0.9, -0.9 }, { 0.4, 0.1, 0.3 } } })
      local here = some_points(300, "float")
      local c = assert(grid:sample(here:to(gpu), { device = gpu }))
      near(c:download(), (grid:sample(here)))
    end)

    it("goes in passes, and reads data in parts where a kernel does not see all of them", function()
      local gpu = open()
      if gpu.limits.bind_bytes > 2 ^ 28 then pending "this device sees more than is tried here" end
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 33, lmax = 8, metric_channels = "none" }, lamp)
      local copy = assert(grid:to(gpu))
      assert(copy.bytes > gpu.limits.bind_bytes, copy.bytes)
      local here = some_points(40000, "float")
      local there = here:to(gpu)
      local L = gpu:array(ylm.zeros({ 40000, 3, 81 }, "float"))
      near(assert(grid:sample(there, { device = gpu, out = L })):download(), (grid:sample(here)))
      copy:close()
    end)

    it("refuses arrays of other shapes and devices, closed ones, results in double", function()
      local gpu, other = open(), assert(ylm.vulkan.open { device = 1 })
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 2, lmax = 1 }, lamp)
      local there = some_points(10, "float"):to(gpu)
      local function refused(says, points, o)
        local ok, message = pcall(grid.sample, grid, points, o)
        assert(not ok and message:find(says, 1, true), message)
      end
      refused("name the device", there, {})
      refused("points must be [n][3]", gpu:array { 1, 2, 3 }, { device = gpu })
      refused("another device", there, { device = other })
      refused("results are float", there, { device = gpu, dtype = "double" })
      refused("out[1] must be a float array of 10x3x4", there, { device = gpu, out = there })
      refused("out must be an array", some_points(10, "float"), { out = there })
      refused("must be on the device as the others are", there,
        { device = gpu, derivatives = 1, out = { gpu:array(ylm.zeros({ 10, 3, 4 }, "float")), ylm.zeros { 1 } } })
      there:close()
      refused("the array has been closed", there, { device = gpu })
      other:close()
    end)
  end)

  describe("scene:render", function()
    if not pcall(require, "ylm.c.scene") then return end

    local function scene(channels)
      return ylm.scene "floor" {
        camera = ylm.camera { from = { 0.2, 1.3, 2.4 }, at = { 0, 0.2, 0 }, fov = 45 },
        geometry = {
          ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8,
            material = ylm.matte { albedo = { 0.7, 0.5, 0.3 } } },
          ylm.sphere { at = { 0, 0.35, 0 }, radius = 0.3, material = ylm.matte { albedo = 0.6 } },
        },
        lights = { ylm.sphere_light { at = { 0.7, 0.8, 0.4 }, radius = 0.1, radiance = { 20, 15, 10 } },
          ylm.sphere_light { at = { -0.9, 0.5, 0.2 }, radius = 0.05, radiance = { 10, 20, 40 } } },
        probes = ylm.adaptive_grid { lmax = 3, depth = 3, threshold = 2, channels = channels },
      }
    end

    it("gives the CPU's image, for rgb and luminance grids, of all interpolations", function()
      local gpu = open()
      for _, channels in ipairs { "rgb", "luminance" } do
        local s = scene(channels)
        local grid = assert(s:bake())
        local o = { grid = grid, size = { 40, 30 }, samples = 1 }
        for _, interpolation in ipairs { "hermite", "linear" } do
          o.interpolation, o.device = interpolation, nil
          local image, report = s:render(o)
          o.device = gpu
          local there, other = assert(s:render(o))
          local a, b = image:layer(), there:layer()
          local n, largest, most = 40 * 30 * 3, 0, 0
          local x, y = a:reshape({ n }):totable(), b:reshape({ n }):totable()
          for i = 1, n do
            largest, most = math.max(largest, math.abs(x[i])), math.max(most, math.abs(x[i] - y[i]))
          end
          assert(largest > 0.1 and most <= 1e-5 * largest, most / largest)
          assert.equal(report.outside, other.outside)
          assert.equal(report.unbaked, other.unbaked)
          assert(other.stages.shade.seconds > 0)
        end
      end
    end)

    it("keeps a view's points on the device between frames", function()
      local gpu, s = open(), scene "rgb"
      local grid, view = assert(s:bake()), assert(s:prepare { size = { 40, 30 }, samples = 1 })
      grid:to(gpu)
      local o = { grid = grid, device = gpu, layers = false }
      local first = assert(view:render(o))
      local before = gpu.stats.uploaded
      local image, report = assert(view:render(o))
      assert.equal(before, gpu.stats.uploaded)
      assert(report.stages.upload == nil and report.stages.sort.seconds >= 0)
      assert.equal(0, (select(2, require "ylm.c.core".array_distance(image:layer(), first:layer()))))
    end)

    it("refuses fields that are no grid, and passes a lost device on", function()
      local gpu, s = open(), scene "rgb"
      local lamp = ylm.sphere_light { at = { 0, 1, 0 } }
      local ok, message = pcall(s.render, s, { grid = lamp, device = gpu, size = { 8, 8 }, samples = 1 })
      assert(not ok and message:find("grid must be a grid", 1, true), tostring(message))
      local grid = assert(s:bake())
      binding.gpu_lose(gpu)
      local image, code
      image, message, code = s:render { grid = grid, device = gpu, size = { 8, 8 }, samples = 1 }
      assert(image == nil and code == "EDEVICE" and message:find("was lost", 1, true))
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
