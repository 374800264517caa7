-- Grids baked with the sums on a device, against the processor's. On Mesa's lavapipe, where there is no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"

local cells_of, same_cells, same_points = bakes.cells_of, bakes.same_cells, bakes.same_points

local box, floor_points = bakes.box, bakes.floor(400)

--- Lights of many sizes about the box, some of radius 0, one on a corner of the lattice.
local function lamps_of(n) return bakes.lamps(n, { dark = true, corner = true }) end

describe("baking on a device", function()
  local gpu = device.here()
  if not gpu then return end

  local function both(description, lights, o) return bakes.both(description, lights, o, gpu) end

  it("is refused where rounding of positions would break the tolerance", function()
    local far = ylm.sphere_light { at = { 5e6, 5e6, 3 } }
    local description = ylm.adaptive_grid { bounds = { { 5e6, 5e6, 0 }, { 5e6 + 4, 5e6 + 4, 4 } }, tolerance = 0.05, lmax = 1 }
    local ok, message, text = pcall(ylm.bake, description, far, { device = gpu })
    assert.matches("positions to float, and 5e%+06 from the origin", tostring(ok and text or message))
    local near = ylm.adaptive_grid { bounds = { { 5e3, 5e3, 0 }, { 5e3 + 4, 5e3 + 4, 4 } },
      tolerance = 1e-4, depth = 4, lmax = 1 }
    local lamp = ylm.sphere_light { at = { 5e3, 5e3, 3 } }
    ok, message, text = pcall(ylm.bake, near, lamp, { device = gpu })
    assert.matches("too coarse for a tolerance of 0.0001", tostring(ok and text or message))
    local cells = ylm.uniform_grid { bounds = description.bounds, cells = { 16, 16, 16 }, lmax = 1 }
    ok, message, text = pcall(ylm.bake, cells, far, { device = gpu })
    assert.matches("that is 1.2 of the finest voxel", tostring(ok and text or message))
  end)

  describe("agreement with the processor", function()
    it("of a uniform grid, a light on a corner", function()
      local here, there = both(ylm.uniform_grid { bounds = box, cells = { 5, 4, 3 }, lmax = 2 }, lamps_of(40))
      assert.equal(60, (same_cells(here, there)))
      assert.equal(120, same_points(here, there, 1e-5))
      assert(here.stats.invalid >= 1)
      for _, key in ipairs { "points", "cells", "leaves", "pairs", "invalid" } do
        assert.equal(here.stats[key], there.stats[key], key)
      end
    end)

    it("of a uniform grid without the metric, where points are", function()
      local here, there = both(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, metric_channels = "none" }, lamps_of(40),
        { occupied = floor_points })
      assert.equal(16, (same_cells(here, there)))
      assert.equal(here.stats.points, same_points(here, there, 1e-5))
    end)

    for _, metric in ipairs { "relative", "absolute" } do
      it("of an adaptive grid with a threshold of the " .. metric .. " metric", function()
        local threshold = metric == "relative" and 0.5 or 0.05
        local here, there = both(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, metric = metric, threshold = threshold },
          lamps_of(40), { occupied = floor_points })
        local n, close = same_cells(here, there, threshold)
        assert(n > 200 and close <= 2, ("%d cells, %d near the threshold"):format(n, close))
        assert(same_points(here, there, 1e-5) > 100)
        if close == 0 then
          assert.equal(here.stats.points, there.stats.points)
          local a, b = here:sample(floor_points), there:sample(floor_points)
          local _, e, norm = core.array_distance(b, a)
          assert(e <= 1e-5 * norm)
        end
      end)
    end

    it("of an adaptive grid whose cells stand on the threshold: they alone may differ", function()
      -- the error of one of the processor's leaves is the threshold
      local description = { bounds = box, lmax = 2, depth = 3, threshold = 0.5 }
      local first = ylm.bake(ylm.adaptive_grid(description), lamps_of(40), { occupied = floor_points })
      local errors = {}
      for _, c in pairs((cells_of(first))) do if c.error == c.error then errors[#errors + 1] = c.error end end
      table.sort(errors)
      for _, q in ipairs { 0.3, 0.6 } do
        description.threshold = errors[math.floor(q * #errors)]
        local here, there = both(ylm.adaptive_grid(description), lamps_of(40), { occupied = floor_points })
        assert(same_cells(here, there, description.threshold) > 50)
      end
    end)

    it("of an adaptive grid with a tolerance, which it keeps", function()
      local here, there = both(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, tolerance = 0.03 }, lamps_of(40),
        { occupied = floor_points })
      local n, close = 0, 0
      local a, b = cells_of(here), cells_of(there)
      for key, x in pairs(a) do
        if b[key] then n, close = n + 1, close + (x.leaf ~= b[key].leaf and 1 or 0) end
      end
      -- a decision compares a measured residual with a quantile of others: both differ in their last digits
      assert(n > 100 and close <= 0.01 * n, ("%d of %d cells differ"):format(close, n))
      assert.equal(here.stats.met, there.stats.met)
      assert(math.abs(here.stats.error - there.stats.error) < 0.05 * here.stats.error)
    end)

    it("of an adaptive grid in rgb with the metric of rgb, from lights that lie there", function()
      local lamps = lamps_of(40)
      local description = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 3, metric_channels = "rgb", threshold = 0.5 }
      local here = assert(ylm.bake(description, lamps, { occupied = floor_points }))
      local there = assert(ylm.bake(description, gpu:lights(lamps), { occupied = floor_points }))
      assert(same_cells(here, there, 0.5) > 50)
    end)
  end)

  describe("what comes back", function()
    it("has times by stage, saves and loads, and is the same each time", function()
      local description = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 3, threshold = 0.5 }
      local a = assert(ylm.bake(description, lamps_of(40), { occupied = floor_points, device = gpu }))
      local b = assert(ylm.bake(description, lamps_of(40), { occupied = floor_points, device = gpu }))
      for _, stage in ipairs { "lights", "adding", "coefficients", "metric" } do
        assert(a.stats.stages[stage].seconds > 0 and a.stats.stages[stage].dispatches >= 1, stage)
      end
      assert(a.stats.stages.upload.seconds > 0 and a.stats.stages.download.seconds > 0)
      assert.is_nil(ylm.bake(description, lamps_of(40), { occupied = floor_points }).stats.stages)
      local _, e = core.array_distance(a:points().value, b:points().value)
      assert.equal(0, e)
      local path = os.tmpname() .. ".ylm"
      assert(a:save(path))
      local c = assert(ylm.load(path))
      os.remove(path)
      assert.equal(0, (select(2, core.array_distance(a:points().value, c:points().value))))
    end)

    it("is nothing where progress says so, where the device is lost or closed, and the memory is given back", function()
      local description = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 3, threshold = 0.5 }
      collectgarbage()
      collectgarbage()
      local arrays = gpu.stats.arrays
      local none, message, code = ylm.bake(description, lamps_of(40), { device = gpu, progress = function() return false end })
      assert.is_nil(none)
      assert.same({ "cancelled", "ECANCELLED" }, { message, code })
      assert.equal(arrays, gpu.stats.arrays)
      local own = device.open()
      require "ylm.c.vulkan".gpu_lose(own)
      none, message, code = ylm.bake(description, lamps_of(40), { device = own })
      assert(none == nil and #message > 0)
      assert.equal("EDEVICE", code)
      own:close()
      assert.has_error(function() ylm.bake(description, lamps_of(40), { device = own }) end)
    end)
  end)

  describe("refusals", function()
    local function refused(says, f)
      local ok, message = pcall(f)
      assert(not ok and message:find(says), message)
      assert(message:find("^spec/vulkan_bake_spec.lua:%d+: "), message)
    end
    local uniform = ylm.uniform_grid { bounds = box, cells = 2, lmax = 1 }

    it("fields that are no lights, degrees without kernels, a dynamic grid", function()
      refused("a device sums lights, and no functions", function()
        return (ylm.bake(uniform, function() end, { device = gpu }))
      end)
      local grid = ylm.bake(uniform, lamps_of(5))
      refused("a device sums sphere, polygon, disk and textured lights", function()
        return (ylm.bake(uniform, grid, { device = gpu }))
      end)
      refused("lmax must be 0 .. 8 for lights on a device with this method", function()
        local there = gpu:lights(lamps_of(5), { method = "forward" })
        return (ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 11 }, there))
      end)
      refused("a dynamic grid follows its lights on the processor", function()
        return (ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, dynamic = true }, lamps_of(5), { device = gpu }))
      end)
      refused("device: bricks are baked by the processor", function()
        return (ylm.bake(ylm.adaptive_grid { bounds = box, depth = 3, lmax = 1, threshold = 0.5, bricks = 1 }, lamps_of(5),
          { device = gpu, folder = "never.ylmd" }))
      end)
      refused("device must be an open device", function() return (ylm.bake(uniform, lamps_of(5), { device = "gpu" })) end)
    end)
  end)
end)
