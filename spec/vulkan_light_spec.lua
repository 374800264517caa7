-- Sums over sphere lights on a device, against those of the processor. On Mesa's lavapipe, where there is no other device.

local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"
local numbers = require "spec.support.random"
local device = require "spec.support.gpu"
local fields = require "spec.support.fields"
local long = require "spec.support.long"

local sqrt = math.sqrt
local random, random_points = numbers.spread, numbers.points

local known = require "spec.support.lights"
local function random_lights(n, edge, seed) return known.random(n, edge, seed, 7) end

describe("lights on a device", function()
  local gpu = device.here()
  if not gpu then return end

  local function agree(...) return fields.agree(gpu, ...) end

  --- 101 points, one of them in a light, one at its centre.
  local lamps = random_lights(150, 4, 5)
  local big = ylm.sphere_light { at = { 0.5, 0.25, -0.5 }, radius = 0.375, radiance = { 2, 1, 0.5 } }
  local lights = { lamps, big }
  local points = random_points(99, 3, 6)
  points[100], points[101] = { 0.5, 0.25, -0.5 }, { 0.625, 0.25, -0.5 }
  local few = { points[1], points[2], points[3], points[4], points[100], points[101] }

  describe("agreement", function()
    for _, lmax in ipairs(long({ 0, 2, 10 }, { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 })) do
      it(("to 1e-5 in float with gradients at lmax %d, in and out of lights"):format(lmax), function()
        local there = agree(lmax, lights, points, { derivatives = 1, channels = "luminance" }, 1e-5)
        assert.equal(1, there[4].inside:get(100))
        assert.equal(1, there[4].inside:get(101))
        assert.near(sqrt(4 * math.pi) * (2 * 0.2126 + 0.7152 + 0.5 * 0.0722), there[1]:get(100, 1, 1), 1)
      end)
    end

    for _, lmax in ipairs(long({ 4, 10 }, { 0, 4, 10 })) do
      it(("to 1e-5 in float with Hessians and the metric at lmax %d"):format(lmax), function()
        agree(lmax, lights, points, { derivatives = 2, channels = "luminance", metric = "luminance" }, 1e-5)
      end)
    end

    for _, lmax in ipairs(long({ 11 }, { 11, 15, 20 })) do
      it(("to 1e-5 in float with Hessians and the metric, by loops, at lmax %d"):format(lmax), function()
        local there = agree(lmax, lights, few, { derivatives = 2, channels = "luminance", metric = "luminance" }, 1e-5)
        assert.equal(1, there[4].inside:get(5))
        assert.near(sqrt(4 * math.pi) * (2 * 0.2126 + 0.7152 + 0.5 * 0.0722), there[1]:get(5, 1, 1), 1)
      end)
    end

    it("by loops, of values alone, of gradients, of rgb, of the metric of rgb", function()
      if long(false, true) then agree(12, lights, points, { channels = "luminance" }, 1e-5) end
      agree(long(11, 13), lights, few, { derivatives = 1, metric = "luminance" }, 1e-5)
      agree(11, lights, few, { metric = "rgb" }, 1e-5)
    end)

    it("at lmax 40, where a column of Hessians takes more than one group", function()
      agree(40, lights, { points[1], points[2] }, { derivatives = 2, channels = "luminance" }, 1e-5)
    end)

    it("by loops to 1e-12 in double", function()
      if not gpu.limits.float64 then pending "the device does not compute in double" end
      agree(15, lights, few, { derivatives = 2, dtype = "double", channels = "luminance", metric = "luminance" }, 1e-12)
      if long(true, false) then return end
      agree(20, lights, few, { derivatives = 1, dtype = "double", channels = "luminance" }, 1e-12)
    end)

    it("of rgb, with the metric of luminance or of rgb", function()
      for _, metric in ipairs { "luminance", "rgb" } do
        agree(3, lights, points, { derivatives = 1, metric = metric }, 1e-5)
        agree(3, lights, points, { metric = metric }, 1e-5)
      end
      agree(3, lights, points, { derivatives = 2, metric = "luminance" }, 1e-5)
    end)

    it("to 1e-12 in double", function()
      if not gpu.limits.float64 then pending "the device does not compute in double" end
      agree(3, lights, points, { derivatives = 2, dtype = "double", metric = "luminance" }, 1e-12)
      agree(8, lights, points, { derivatives = 1, dtype = "double", channels = "luminance" }, 1e-12)
    end)

    for _, method in ipairs(long({ "forward" }, { "forward", "reversed" })) do
      it("of the product rule with loops " .. method, function()
        agree(2, lights, points, { derivatives = 2, metric = "luminance", method = method }, 1e-5)
        agree(long(2, 4), lights, points, { derivatives = 1, channels = "luminance", method = method }, 1e-5)
        if long(false, true) then agree(3, lights, points, { channels = "luminance", method = method }, 1e-5) end
        if gpu.limits.float64 then
          agree(2, lights, points, { derivatives = 2, channels = "luminance", dtype = "double", method = method }, 1e-12)
        end
      end)
    end

    it("of ten thousand lights, of one, and of lights that are all of radius 0", function()
      agree(2, random_lights(10000, 6, 8), random_points(65, 2, 9), { derivatives = 1, channels = "luminance" }, 1e-5)
      agree(2, big, points, { derivatives = 1, channels = "luminance" }, 1e-5)
      local there = agree(2, ylm.sphere_lights { at = { { 0, 0, 0 }, { 1, 0, 0 } }, radius = 0 }, points,
        { derivatives = 1, channels = "luminance" }, 0)
      assert.equal(0, there[1]:get(3, 1, 1))
      assert.equal(0, there[4].pairs)
    end)

    it("of any number of points, none included", function()
      for _, n in ipairs { 1, 2, 63, 64, 65, 129 } do
        agree(2, lamps, random_points(n, 3, n), { derivatives = 1, channels = "luminance" }, 1e-5)
      end
      local none = ylm.zeros({ 0, 3 }, "float")
      local L, dL = ylm.light_field(2, lamps, none, { derivatives = 1, device = gpu })
      assert.same({ 0, 3, 9 }, L.shape)
      assert.same({ 0, 3, 9, 3 }, dL.shape)
    end)

    it("of more points than go into one pass", function()
      agree(2, big, ylm.array(random_points(70000, 4, 4), "float"), { derivatives = 1 }, 2e-5)
    end)

    it("near a light's surface and far away, against double, as accurate as the processor's float", function()
      for _, case in ipairs(known.lone(17)) do
        local lamp, x = case.lamp, case.x
        local o = { derivatives = 2, channels = "luminance", device = gpu }
        local there = { ylm.light_field(4, lamp, { x }, o) }
        local truth = { light.evaluate("light_field", 4, light.pack(2, "light_field", lamp), ylm.array({ x }, "double"),
          { derivatives = 2, channels = "luminance" }, "reference") }
        for k = 1, 3 do
          local e = fields.worst(ylm.array(there[k]:totable(), "double"), truth[k])
          local bound = 4e-6 + 1.5e-7 * case.closeness
          assert(e <= bound, ("d/r %g, %d derivatives: %g > %g"):format(case.ratio, k - 1, e, bound))
        end
      end
    end)
  end)

  describe("agreement of flat lights", function()
    --- Triangles with method = "sphere", negative ones too, and a disk.
    local next, triangles = random(31), {}
    for i = 1, 40 do
      local at, vertices = { 4 * next(), 4 * next(), 4 * next() }, {}
      for k = 1, 3 do
        vertices[k] = { at[1] - 2 + 0.3 * next(), at[2] - 2 + 0.3 * next(), at[3] - 2 + 0.3 * next() }
      end
      triangles[i] = ylm.polygon_light { vertices = vertices, method = "sphere", radiance = { next(), next(), next() - 0.1 } }
    end
    local disk = ylm.disk_light { at = { 0.5, 0.25, -0.5 }, normal = { 0, 1, 2 }, radius = 0.375, radiance = { 2, 1, 0.5 },
      method = "sphere" }
    local flat, mixed = { triangles, disk }, { lamps, triangles, disk }

    for _, lmax in ipairs(long({ 3 }, { 0, 1, 3, 4 })) do -- kernels of 3 are compiled for the metric of rgb too
      it(("to 1e-5 in float with Hessians and the metric at lmax %d, in and out of lights"):format(lmax), function()
        local there = agree(lmax, flat, points, { derivatives = 2, channels = "luminance", metric = "luminance" }, 1e-5)
        assert.equal(1, there[4].inside:get(100))
        assert.equal(0, there[4].inside:get(1))
      end)
    end

    it("to 1e-5 of values alone, and with gradients to lmax " .. long(5, 10), function()
      agree(3, flat, points, { channels = "luminance" }, 1e-5)
      if long(false, true) then agree(3, flat, points, { derivatives = 1 }, 1e-5) end
      agree(long(5, 10), flat, points, { derivatives = 1, channels = "luminance" }, 1e-5)
    end)

    it("by loops above: Hessians and the metric, gradients, values; and (make check-long) in double", function()
      agree(11, mixed, few, { derivatives = 2, channels = "luminance", metric = "luminance" }, 1e-5)
      if long(false, true) then agree(15, flat, few, { derivatives = 1, channels = "luminance" }, 1e-5) end
      if long(false, true) then agree(20, flat, few, { channels = "luminance" }, 1e-5) end
      if long(false, gpu.limits.float64) then
        agree(11, mixed, few, { derivatives = 2, channels = "luminance", dtype = "double" }, 1e-12)
      end
    end)

    it("to 1e-12 in double", function()
      if not gpu.limits.float64 then pending "the device does not compute in double" end
      agree(3, mixed, points, { derivatives = 2, dtype = "double", metric = "luminance" }, 1e-12)
    end)

    it("beside spheres, of rgb, with the metric of luminance or of rgb", function()
      agree(3, mixed, points, { derivatives = 1, metric = "luminance" }, 1e-5)
      agree(3, mixed, points, { derivatives = 1, metric = "rgb" }, 1e-5)
    end)

    for _, method in ipairs(long({ "reversed" }, { "forward", "reversed" })) do
      it("of the product rule with loops " .. method, function()
        agree(2, mixed, points, { derivatives = 2, channels = "luminance", metric = "luminance", method = method }, 1e-5)
        agree(long(2, 4), flat, points, { derivatives = 1, channels = "luminance", method = method }, 1e-5)
        if long(false, gpu.limits.float64) then
          agree(1, flat, points, { derivatives = 2, channels = "luminance", dtype = "double", method = method }, 1e-12)
        end
      end)
    end

    it("of one triangle, gradients being those of values that are near", function()
      local one, x, h = triangles[1], { 0.3, -0.2, 0.4 }, 1e-4
      if not gpu.limits.float64 then pending "the device does not compute in double" end
      local there = gpu:lights(one)
      local function value(a, d)
        local p = { x[1], x[2], x[3] }
        p[a] = p[a] + d
        return ylm.light_field(2, there, { p }, { channels = "luminance", dtype = "double" })
      end
      local _, dL = ylm.light_field(2, there, { x }, { channels = "luminance", dtype = "double", derivatives = 1 })
      for a = 1, 3 do
        local up, down = value(a, h), value(a, -h)
        for k = 1, 9 do
          assert.near((up:get(1, 1, k) - down:get(1, 1, k)) / (2 * h), dL:get(1, 1, k, a), 1e-8)
        end
      end
      there:close()
    end)

    it("in objects that stand for lights and count them all, and in bakes", function()
      local there = gpu:lights(mixed)
      assert.equal(150 + 41, there.count)
      local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = long(1, 2) }
      local a, b = assert(ylm.bake(form, there)), assert(ylm.bake(form, mixed))
      assert.same(b.stats.points, a.stats.points)
      assert.equal(b.stats.pairs, a.stats.pairs)
      assert(fields.worst(a:sample(points), b:sample(points)) <= 1e-5)
      local adaptive = ylm.adaptive_grid { bounds = form.bounds, lmax = 1, depth = 3, threshold = 3 }
      a, b = assert(ylm.bake(adaptive, there)), assert(ylm.bake(adaptive, mixed))
      assert.equal(b.stats.cells, a.stats.cells)
      assert(a.stats.cells > 9 and a.stats.cells < 585)
      there:close()
    end)
  end)

  describe("properties", function()
    it("a point's result does not depend on the others", function()
      local o = { derivatives = 1, device = gpu }
      local all = { ylm.light_field(3, lamps, points, o) }
      local one = { ylm.light_field(3, lamps, points[77], o) }
      for k = 1, 2 do
        local _, e = core.array_distance(all[k][77], one[k])
        assert.equal(0, e)
      end
    end)

    it("lights stay in the device's memory in an object that stands for lights", function()
      local there = gpu:lights(lights)
      assert.equal(151, there.count)
      assert.equal("merged", there.method)
      local a = ylm.light_field(2, there, points)
      assert.equal(0, (select(2, core.array_distance(a, (ylm.light_field(2, lights, points, { device = gpu }))))))
      local before = there.stages.lights.dispatches
      ylm.light_field(2, there, points, { device = gpu, method = "merged" })
      assert(there.stages.lights.dispatches > before and there.stages.lights.seconds > 0)
      local arrays = gpu.stats.arrays
      there:close()
      assert(gpu.stats.arrays < arrays)
      assert.equal("ylm.gpu_lights (closed)", tostring(there))
      there:close()
    end)

    it("memory of a call's own lights is given back when it returns", function()
      -- Finalisers of other specs' objects run a collection late, and free more.
      local function collect() for _ = 1, 6 do collectgarbage() end end
      collect()
      local arrays = gpu.stats.arrays
      ylm.light_field(2, lights, points, { device = gpu })
      assert.equal(arrays, gpu.stats.arrays)
      assert.has_error(function() ylm.light_field(101, lights, points, { device = gpu }) end)
      collect()
      assert.equal(arrays, gpu.stats.arrays)
    end)

    it("progress counts points, and cancels", function()
      local many, where = random_lights(10000, 6, 8), ylm.array(random_points(2000, 2, 9), "float")
      local last, calls = 0, 0
      local L = ylm.light_field(2, many, where, { channels = "luminance", device = gpu, progress = function(done, total, stage)
        assert(done >= last and done <= total and total == 2000 and stage == "lights")
        last, calls = done, calls + 1
      end })
      assert(L and calls >= 1 and last == 2000)
      local none, message, code = ylm.light_field(2, many, where, { device = gpu, progress = function() return false end })
      assert.is_nil(none)
      assert.same({ "cancelled", "ECANCELLED" }, { message, code })
    end)

    it("lights cannot be closed by a progress function of a call that uses them", function()
      local there, ok, says = gpu:lights(lamps), nil, nil
      assert(ylm.light_field(2, there, points, { progress = function() ok, says = pcall(there.close, there) end }))
      assert(ok == false and says:find "in use", says)
      there:close()
    end)
  end)

  describe("refusals", function()
    local function refused(says, f, ...)
      local ok, message = pcall(f, ...)
      assert(not ok and message:find(says), message)
      assert(message:find("^spec/vulkan_light_spec.lua:%d+: "), message)
    end

    it("degrees beyond those that there are kernels for", function()
      refused("lmax must be an integer from 0 to 100, got 101", function()
        return (ylm.light_field(101, lamps, points, { device = gpu }))
      end)
      refused("lmax must be 0 .. 8 for lights on a device with this method, got 9", function()
        return (ylm.light_field(9, lamps, points, { device = gpu, method = "reversed" }))
      end)
    end)

    it("what is no light, points that are none", function()
      local there = gpu:lights(big)
      refused("a device sums sphere, polygon, disk and textured lights; no others", function()
        return (gpu:lights { there, big })
      end)
      refused("a device sums sphere, polygon, disk and textured lights; no others", function()
        return (ylm.light_field(2, { there, big }, points, { device = gpu }))
      end)
      there:close()
      refused("row 2 is not finite", function()
        return (ylm.light_field(2, big, { { 0, 0, 0 }, { 0, 0 / 0, 0 } }, { device = gpu }))
      end)
      refused("point 1 is beyond 1e%+15", function()
        return (ylm.light_field(2, big, { { 0, 1e16, 0 } }, { device = gpu }))
      end)
    end)

    it("a method without a device, lights of another device, closed lights, what is no device", function()
      refused("method: a choice for computing on a device", function()
        return (ylm.light_field(2, big, points, { method = "merged" }))
      end)
      local there, other = gpu:lights(big), device.open()
      refused("device: the lights are on another", function()
        return (ylm.light_field(2, there, points, { device = other }))
      end)
      refused("method: gpu:lights has chosen it", function()
        return (ylm.light_field(2, there, points, { device = gpu, method = "forward" }))
      end)
      refused("method: gpu:lights has chosen it", function()
        return (ylm.light_field(2, there, points, { method = "merged" }))
      end)
      there:close()
      refused("the lights have been closed", function() return (ylm.light_field(2, there, points)) end)
      refused("the lights have been closed", function() return there.count end)
      refused("device must be an open device", function() return (ylm.light_field(2, big, points, { device = 1 })) end)
      other:close()
      refused("closed", function() return (ylm.light_field(2, big, points, { device = other })) end)
    end)

    it("a device that was lost, in words; the processor goes on", function()
      local own = device.open()
      local there = own:lights(big)
      require "ylm.c.vulkan".gpu_lose(own)
      for _, lost in ipairs { there, big } do
        local L, message, code = ylm.light_field(2, lost, points, { device = own })
        assert(L == nil and code == "EDEVICE" and #message > 0, tostring(message))
      end
      assert(ylm.light_field(2, big, points))
      own:close()
    end)
  end)
end)
