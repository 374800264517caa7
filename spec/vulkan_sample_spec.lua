-- Grids sampled on a device, of arrays of either memory, against the processor. On Mesa's lavapipe, where there is no other
-- device.

local ylm = require "ylm"
local device = require "spec.support.gpu"
local long = require "spec.support.long"

describe("ylm.vulkan", function()
  local open = device.each()
  if not open then return end
  local binding = require "ylm.c.vulkan"

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
      binding.gpu_shrink(gpu, 0, 4 * 2 ^ 20, 0)
      local points = random_points(7000, 17, 1, "float") -- 6.8 MB of results
      local out, calls = ylm.zeros({ 7000, 3, 81 }, "float"), 0
      local c = assert(grid:sample(points, { device = gpu, out = out, progress = function() calls = calls + 1 end }))
      assert.equal(out, c)
      assert.equal(2, calls)
      assert(gpu.stats.uploaded - uploaded <= 7000 * 24)
      local wanted = grid:sample(points)
      for _, i in ipairs { 1, 2, 3499, 6900, 7000 } do assert(difference(c[i], wanted[i]) <= 1e-5) end
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

  describe("grid:to { packed }", function()
    local lamps = { ylm.sphere_light { at = { 0.3, 1.4, -0.2 }, radius = 0.1, radiance = { 10, 8, 6 } },
      ylm.sphere_light { at = { -1.2, -0.4, 0.6 }, radius = 0.2, radiance = { 1, 2, 3 } } }

    --- The largest of numbers without their signs, row by row [n].
    local function largest(a, n, width)
      local list, rows = {}, a:reshape { n, width }
      for i = 1, n do list[i] = rows[i]:abs():max() end
      return list
    end

    it("rounds values to a 1023th and slopes to a 63rd of a point's largest, in words", function()
      local gpu = open()
      for _, lmax in ipairs { 0, 4 } do
        local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = lmax }, lamps)
        local points, plain = grid:points(), grid:to(gpu).bytes
        local copy = assert(grid:to(gpu, { packed = true }))
        local n, width = #points.position, 3 * (lmax + 1) ^ 2
        assert.equal(plain - n * 16 * 8 * math.ceil(width / 8) + n * 4 * (width + 2), copy.bytes)
        assert.equal(copy, grid:to(gpu))
        local c, dc = assert(grid:sample(points.position, { device = gpu, derivatives = 1 }))
        local wanted, slopes = grid:sample(points.position, { derivatives = 1 })
        local values, steep = largest(points.value, n, width), largest(points.gradient, n, 3 * width)
        local off, off_slopes = largest(c - wanted, n, width), largest(dc - slopes, n, 3 * width)
        local most, most_slopes = 0, 0
        for i = 1, n do
          most = math.max(most, off[i] / values[i])
          most_slopes = math.max(most_slopes, off_slopes[i] / steep[i])
        end
        assert(most <= 0.5 / 1023 + 1e-5 and most > 0.2 / 1023, most)
        assert(most_slopes <= 0.5 / 63 + 1e-4 and most_slopes > 0.2 / 63, most_slopes)
        local packed = copy.packed
        assert(packed.rounding > 0 and packed.rounding < packed.largest and packed.largest < 0.2, packed.largest)
        assert(grid:to(gpu, { packed = false }).packed == nil)
      end
    end)

    it("says what it errs by: 99 % of places, and pictures", function()
      local gpu = open()
      local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8 }
      local scene = ylm.scene "s" { camera = ylm.camera { from = { 1, 1, 2 }, at = { 0, 0, 0 } }, geometry = floor,
        lights = lamps }
      local grid = ylm.bake(ylm.adaptive_grid { lmax = 2, depth = 4, tolerance = 0.05 }, lamps, { geometry = floor })
      local places, seed = {}, 7
      for i = 1, 2000 do
        seed = seed * 16807 % 2147483647
        places[i] = { seed / 2147483647 * 2 - 1, 0, i / 1000 - 1 }
      end
      local host, packed = grid:sample(places), assert(grid:to(gpu, { packed = true })).packed
      local view = assert(scene:prepare { size = { 32, 18 }, visibility = "none" })
      local picture = assert(view:render { grid = grid, device = gpu, dering = false }):layer()
      local d = grid:sample(places, { device = gpu }) - host
      local above = 0
      local squares, all = (d * d):reshape({ 2000, 27 }):sum(2), (host * host):reshape({ 2000, 27 }):sum(2)
      for i = 1, 2000 do above = above + (squares[i] > packed.rounding ^ 2 * all[i] and 1 or 0) end
      assert(above < 60, above)
      assert.near(packed.error, grid.stats.error + packed.rounding, 1e-12)
      local truth = assert(view:render { grid = grid, dering = false }):layer()
      local off = (picture - truth):abs():max() / truth:max()
      assert(off > 1e-6 and off < packed.largest, off)
    end)

    it("refuses what is no boolean", function()
      local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 0 }, lamps)
      local ok, says = pcall(grid.to, grid, open(), { packed = 1 })
      assert(not ok and says:find("packed must be", 1, true), says)
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
      local cells = long(8, 33)
      local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = cells, lmax = 8, metric_channels = "none" }, lamp)
      if cells == 8 then binding.gpu_shrink(gpu, 0, 2 ^ 20, 0) end
      local copy = assert(grid:to(gpu))
      assert(copy.bytes > gpu.limits.bind_bytes, copy.bytes)
      local n = long(4000, 40000)
      local here = some_points(n, "float")
      local there = here:to(gpu)
      local L = gpu:array(ylm.zeros({ n, 3, 81 }, "float"))
      local wanted = grid:sample(here)
      near(assert(grid:sample(there, { device = gpu, out = L })):download(), wanted)
      if cells > 8 then return end
      binding.gpu_shrink(gpu, 0, 2 ^ 18, 0)
      copy = assert(grid:to(gpu, { packed = true }))
      assert(copy.bytes > 2 ^ 19, copy.bytes)
      local _, e, norm = require "ylm.c.core".array_distance(grid:sample(there, { device = gpu, out = L }):download(), wanted)
      assert(e > 1e-4 * norm and e <= 0.01 * norm, e / norm)
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
end)
