-- Adaptive grids with a threshold, refined level by level on a device, against the processor's. On Mesa's lavapipe,
-- where there is no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local long = require "spec.support.long"
local numbers = require "spec.support.random"
local with = require "spec.support.with"

local points_in = numbers.points_in

local box, floor = bakes.box, bakes.floor(400)

local lamps = bakes.lamps(40, { dark = true })

describe("an adaptive grid refined on a device", function()
  local gpu = device.here()
  if not gpu then return end

  local function description(o)
    return ylm.adaptive_grid(with({ bounds = box, lmax = 2, depth = 4, threshold = 0.5 }, o))
  end

  --- The grid by the processor and on the device `on`.
  local function both(o, lights, occupied, on)
    return bakes.both(description(o), lights, { occupied = occupied }, on or gpu, "subdivide")
  end

  local function same(...)
    local here, there = both(...)
    bakes.same(here, there)
    return here, there
  end

  describe("has the processor's cells and points, in their order", function()
    for depth = 0, 8 do
      it("at depth " .. depth, function()
        local here = same({ depth = depth, threshold = 0.05, lmax = 1 }, lamps, floor)
        assert(here.stats.levels == depth + 1 or depth > 5)
      end)
    end

    for _, lmax in ipairs(long({ 0, 3, 10 }, { 0, 3, 7, 10 })) do
      it("at lmax " .. lmax, function() same({ lmax = lmax, depth = 3 }, lamps, floor) end)
    end

    it("with the absolute metric, and with that of rgb", function()
      same({ metric = "absolute", threshold = 0.05 }, lamps, floor)
      same({ metric_channels = "rgb" }, lamps, floor)
      same({ metric_channels = "rgb", metric = "absolute", threshold = 0.05 }, lamps, floor)
      same({ channels = "luminance" }, lamps, floor)
    end)

    it("under one light, lights that do not shine, ten thousand", function()
      same({}, ylm.sphere_light { at = { 0.3, 0.1, -1.2 }, radius = 0.1, radiance = { 1, 2, 3 } }, floor)
      local here = same({ threshold = 0 }, ylm.sphere_light { at = { 0, 0, 0 }, radius = 0 }, floor)
      assert.equal(1, here.stats.cells)
      same({ depth = 3, threshold = 5 }, bakes.lamps(10000, { dark = true, size = 0.01 }), floor)
    end)

    it("under flat lights approximated by spheres, whose surfaces voxels are tested against, and mixed ones", function()
      local disk = ylm.disk_light { at = { 0.1, -0.9, 0 }, normal = { 0.1, 1, 0.2 }, radius = 0.3, radiance = { 1, 2, 3 },
        method = "sphere" }
      local triangle = ylm.polygon_light { vertices = { { -0.9, -0.3, 0.4 }, { -0.5, -0.95, 0.4 }, { -0.7, -0.7, 0.9 } },
        radiance = { 3, 1, 2 }, method = "sphere" }
      -- in its plane a flat light's Hessian is singular and rounding decides about errors: surfaces alone split here
      local here, there = both({ metric = "absolute", threshold = 1e30 }, { disk, triangle }, floor)
      bakes.same(here, there, 1e30)
      assert(here.stats.levels == 5)
      here, there = both({ metric = "absolute", threshold = 1e30 }, { disk, lamps, triangle,
        ylm.sphere_light { at = { 0.6, -1, 0.5 }, radius = 0.1, radiance = 1 } }, floor)
      bakes.same(here, there, 1e30)
      assert(here.stats.invalid > 0)
      -- spheres in planes of the lattice, and many
      local disks, r = {}, numbers.minimal(17)
      for i = 1, 1100 do
        local on_lattice = i < 60
        local function place() return on_lattice and math.floor(16 * r()) / 8 - 1 or 2 * r() - 1 end
        disks[i] = ylm.disk_light { at = { place(), place(), place() }, normal = { 0, 1, i % 3 }, method = "sphere",
          radius = on_lattice and 0.125 * (1 + i % 2) or 0.001 + 0.01 * r(), radiance = 1 }
      end
      here, there = both({ metric = "absolute", threshold = 1e30, depth = 5, lmax = 0 }, disks, floor)
      for _, key in ipairs { "crossed", "level", "origin" } do
        assert.equal(0, (select(2, core.array_distance(there:cells()[key], here:cells()[key]))), key)
      end
      assert(here.stats.cells > 500 and there.stats.stages.crossing.dispatches >= 5)
    end)

    it("where every voxel is occupied", function()
      local here = same({ depth = 3, threshold = 0.1 }, lamps)
      assert(here.stats.levels == 4 and here.stats.occupied == here.stats.leaves)
    end)

    it("where lights' surfaces cross voxels and corners lie in lights", function()
      local big = ylm.sphere_lights { at = { { 0.1, -0.9, 0 }, { -1, -1, -1 }, { 0.7, -1, 0.6 } },
        radius = { 0.5, 0.25, 0.01 }, radiance = { 1, 2, 3 } }
      local here = same({ threshold = 100 }, big, floor)
      assert(here.stats.invalid > 5 and here.stats.levels == 5)
      -- all of the grid in a light
      here = same({ threshold = 0 }, ylm.sphere_light { at = { 0, 0, 0 }, radius = 2, radiance = 1 }, floor)
      assert.equal(8, here.stats.invalid)
      -- surfaces in planes of the lattice: they touch voxels' faces
      same({ threshold = 100, depth = 5 }, ylm.sphere_lights { at = { { 0, -1, 0 }, { 0.5, -0.5, 0.25 } },
        radius = { 0.25, 0.125 }, radiance = { 1, 1 } }, floor)
    end)

    it("in boxes that are no cubes, far from the origin, small, and with points outside", function()
      local here = same({ bounds = { { -2, -1, -0.25 }, { 1, 0, 1 } } }, lamps, floor)
      assert(here.stats.outside > 0)
      local far = points_in(300, { 10000, -5000, 7 }, { 10003, -4999, 9 }, 3)
      local two = ylm.sphere_lights { at = { { 10001, -4999.5, 6.5 }, { 10002, -5001, 8 } }, radius = { 0.1, 0.2 },
        radiance = { 1, 2 } }
      same({ bounds = { { 10000, -5000, 7 }, { 10003, -4999, 9 } }, threshold = 0.02 }, two, far)
      local tiny = points_in(300, { 0, 0, 0 }, { 1e-6, 1e-6, 2e-6 }, 3)
      same({ bounds = { { 0, 0, 0 }, { 1e-6, 1e-6, 2e-6 } } },
        ylm.sphere_light { at = { 1e-6, 5e-7, -1e-6 }, radius = 2e-7, radiance = 1 }, tiny)
      here = same({}, lamps, ylm.array({ { 5, 5, 5 }, { -9, 0, 0 }, { 0, 1e300, 0 } }, "double"))
      assert.equal(3, here.stats.outside)
      same({}, lamps, ylm.array({ { 5, 5, 5 }, { -9, 0, 0 }, { 0, 1e30, 0 } }, "float"))
    end)

    it("where points lie on faces of voxels, and next to them by one bit, as float and as double", function()
      local bounds = { { -0.3, -1, 0 }, { 0.9, 1.7, 1e-3 } }
      for _, dtype in ipairs { "float", "double" } do
        local at, bit = {}, dtype == "float" and 2 ^ -23 or 2 ^ -52
        for i = 0, 64 do
          for k = -1, 1 do
            local p = {}
            for a = 1, 3 do
              local x = bounds[1][a] + (bounds[2][a] - bounds[1][a]) * ((i * (2 * a - 1)) % 65) / 64
              p[a] = x == 0 and k * 1e-30 or x * (1 + k * bit)
            end
            at[#at + 1] = p
          end
        end
        local here = same({ bounds = bounds, depth = 6, threshold = 0, lmax = 0, continuous = false },
          ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.1, radiance = 1 }, ylm.array(at, dtype))
        assert(here.stats.levels == 7 and here.stats.outside > 0)
      end
    end)

    it("where there are many points", function()
      same({ depth = 6, threshold = 2, lmax = 0 }, lamps, points_in(20000, { -1, -1, -1 }, { 1, 1, 1 }, 5))
      local at = ylm.zeros({ 1100000, 3 }, "float") -- they come to the device in parts
      for i = 1, 30 do for a = 1, 3 do at:set(#at - 37 * i, a, math.sin(i * a)) end end
      same({ threshold = 0.05, lmax = 0 }, lamps, at)
    end)

    it("at depth 16, along few points", function()
      local here = same({ bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, depth = 16, threshold = 0, lmax = 0 },
        ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.1, radiance = 1 },
        { { 1, 1, 1 }, { 0, 0, 0 }, { 0.3, 0.7, 0.1 }, { 0.3, 0.7, 0.1 + 2 ^ -16 }, { 0.99999, 1, 0 } })
      assert.equal(17, here.stats.levels)
    end)

    it("from product-rule sums too", function()
      local d = description { lmax = 1 }
      local here = assert(ylm.bake(d, lamps, { occupied = floor }))
      bakes.same(here, assert(ylm.bake(d, gpu:lights(lamps, { method = "forward" }), { occupied = floor })))
    end)

    it("on a device that does not compute in double, and by way of staging memory", function()
      local own = device.open { staging = true, validate = true }
      require "ylm.c.vulkan".gpu_shrink(own, 0, 0, 0, true)
      same({}, lamps, floor, own)
      same({ threshold = 100 }, ylm.sphere_light { at = { 0.1, -0.9, 0 }, radius = 0.5, radiance = 1 }, floor, own)
      device.close_silent(own)
    end)

    it("but where the threshold is the error of a cell, within 1e-4", function()
      local first = ylm.bake(description {}, lamps, { occupied = floor })
      local errors = {}
      for _, c in pairs((bakes.cells_of(first))) do
        if c.error == c.error and c.error > 0 then errors[#errors + 1] = c.error end
      end
      table.sort(errors)
      for _, q in ipairs { 0.2, 0.5, 0.8 } do
        local threshold = errors[math.ceil(q * #errors)]
        local here, there = both({ threshold = threshold }, lamps, floor)
        local n, close = bakes.same_cells(here, there, threshold)
        assert(n > 50 and close <= 2, ("%d cells, %d near the threshold"):format(n, close))
        if close == 0 then bakes.same(here, there) end
      end
    end)
  end)

  describe("is", function()
    it("the same to the bit each time, in small passes too", function()
      local d = description { threshold = 0.05, lmax = 4 }
      local first = assert(ylm.bake(d, lamps, { occupied = floor, device = gpu }))
      for _ = 1, 3 do assert(bakes.identical(first, assert(ylm.bake(d, lamps, { occupied = floor, device = gpu })))) end
      local own = device.open()
      require "ylm.c.vulkan".gpu_shrink(own, 0, 400 * 1024, 0) -- some hundred points a pass
      assert(bakes.identical(first, assert(ylm.bake(d, lamps, { occupied = floor, device = own }))))
      require "ylm.c.vulkan".gpu_shrink(own, 0, 2048, 0)
      local none, message, code = ylm.bake(d, lamps, { occupied = floor, device = own })
      assert(none == nil and code == "ELIMIT", message)
      own:close()
    end)

    it("a grid like others: timed by stage, saved, loaded, sampled", function()
      local grid = assert(ylm.bake(description {}, lamps, { occupied = floor, device = gpu }))
      for _, stage in ipairs { "occupancy", "points", "lights", "adding", "coefficients", "metric", "crossing",
        "subdivide" } do
        assert(grid.stats.stages[stage].seconds > 0 and grid.stats.stages[stage].dispatches >= 1, stage)
      end
      for _, copy in ipairs { "upload", "download" } do assert(grid.stats.stages[copy].seconds > 0, copy) end
      assert(grid.stats.seconds > grid.stats.field_seconds and grid.stats.occupancy_seconds > 0)
      local path = os.tmpname() .. ".ylm"
      assert(grid:save(path))
      local loaded = assert(ylm.load(path))
      os.remove(path)
      assert(bakes.identical(grid, loaded))
      assert(grid:sample(floor, { device = gpu }))
    end)

    it("refused where it needs more points than max_points", function()
      local needs = ylm.bake(description {}, lamps, { occupied = floor }).stats.points
      assert(ylm.bake(description {}, lamps, { occupied = floor, device = gpu, max_points = needs }))
      local o = { occupied = floor, device = gpu, max_points = needs - 1 }
      local none, message, code = ylm.bake(description {}, lamps, o)
      assert.is_nil(none)
      assert.same({ ("the grid needs more than %d points"):format(needs - 1), "ELIMIT" }, { message, code })
      o.device = nil
      assert.same({ message, code }, { select(2, ylm.bake(description {}, lamps, o)) })
    end)

    it("the processor's where there is a tolerance, or kernels see few buffers", function()
      local own = device.open()
      require "ylm.c.vulkan".gpu_shrink(own, 0, 0, 8)
      local d = description {}
      local one = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
      bakes.same(assert(ylm.bake(d, lamps, { occupied = floor })), one)
      assert(one.stats.stages.lights and not one.stats.stages.subdivide)
      own:close()
      local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 2, tolerance = 0.1 }, lamps,
        { occupied = floor, device = gpu }))
      assert(grid.stats.stages.lights and not grid.stats.stages.subdivide)
    end)
  end)

  describe("when it cannot be finished", function()
    --- Bakes on `own` after `prepare`, expects nothing but a failure, and nothing left of it. Returns message, code.
    local function failed(own, o)
      collectgarbage()
      collectgarbage()
      local arrays = own.stats.arrays
      o.occupied, o.device = floor, own
      local none, message, code = ylm.bake(description {}, lamps, o)
      assert.is_nil(none)
      assert.equal(arrays, own.stats.arrays)
      return message, code
    end

    it("is cancelled in whatever stage progress says so; it counts up within each", function()
      local stages, last, before = {}, nil, 0
      assert(ylm.bake(description {}, lamps, { occupied = floor, device = gpu, progress = function(done, total, stage)
        assert(done <= total)
        if stage ~= last then stages[#stages + 1], before = stage, 0 end
        assert(done / total >= before)
        last, before = stage, done / total
      end }))
      assert.same({ "occupancy", "level 0", "level 1", "level 2", "level 3", "level 4", "download" }, stages)
      for _, where in ipairs(stages) do
        local message, code = failed(gpu, { progress = function(_, _, stage) return stage ~= where end })
        assert.same({ "cancelled", "ECANCELLED" }, { message, code }, where)
      end
    end)

    it("for want of memory says so, gives back what it took, and the device goes on working", function()
      local own = device.open { validate = true }
      local shrink, whole = require "ylm.c.vulkan".gpu_shrink, own.limits.memory_bytes
      local codes, good, first = {}, 0, nil
      for k = 8, 24 do
        shrink(own, 2 ^ k, 0, 0)
        local grid, message, code = ylm.bake(description {}, lamps, { occupied = floor, device = own })
        if grid then
          good, first = good + 1, first or grid -- with less memory, data are brought to the host more often
          assert(bakes.identical(first, grid))
          grid:to(own):close()
        else codes[code] = message end
        collectgarbage()
        collectgarbage()
        assert.equal(0, own.stats.arrays)
      end
      assert(good >= 1 and codes.ENOMEM and next(codes) == "ENOMEM" and next(codes, "ENOMEM") == nil)
      assert(codes.ENOMEM:find("MiB of memory"), codes.ENOMEM)
      shrink(own, whole, 0, 0)
      same({}, lamps, floor, own)
      device.close_silent(own)
    end)

    it("for a device that is lost, says so", function()
      local own = device.open()
      local n = 0
      local message, code = failed(own, { progress = function()
        n = n + 1
        if n == 4 then require "ylm.c.vulkan".gpu_lose(own) end
      end })
      assert(code == "EDEVICE" and message:find("was lost"), message)
      own:close()
    end)
  end)

  describe("while it is made", function()
    --- Calls f with a progress function that calls `again`, which must raise `says`; f raises that then.
    local function refused(says, f, again)
      local ok, message = pcall(f, function() again() end)
      assert(not ok and tostring(message):find(says), message)
    end

    it("lets nobody use the lights and copies that it uses, nor close the device", function()
      local there = gpu:lights(lamps)
      local function bake(progress)
        return ylm.bake(description {}, there, { occupied = floor, progress = progress })
      end
      local function field(progress) return ylm.light_field(2, there, floor, { progress = progress }) end
      local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 2 }, lamps)
      local function sample(progress) return grid:sample(floor, { device = gpu, progress = progress }) end
      for _, f in ipairs { bake, field } do
        refused("the lights are in use by a call that has not returned", f, bake)
        refused("the lights are in use by a call that has not returned", f, field)
        refused("in use by a call that has not returned", f, function() gpu:close() end)
        refused("in use by a call that has not returned", f, function() there:close() end)
      end
      refused("the grid's copy is in use by a call that has not returned", sample, sample)
      assert(bake() and field() and sample())
    end)

    it("is refused where lights have no kernels", function()
      local ok, message = pcall(function()
        return (ylm.bake(description { lmax = 11 }, gpu:lights(lamps, { method = "forward" }), { occupied = floor }))
      end)
      assert(not ok and message:find("^spec/vulkan_octree_spec.lua:%d+: bake: lmax must be 0 .. 8 "), message)
    end)
  end)

  describe("does not keep the device busy", function()
    it("for longer than 50 ms at a time, once kernels are compiled", function()
      if not gpu.limits.timestamps then pending("the device measures no times") return end
      -- the least of several runs: other programs have this machine's processors too
      local many, d = bakes.lamps(10000, { dark = true, size = 0.01 }), description { lmax = 4, depth = 3, threshold = 5 }
      local longest
      for _ = 1, 12 do
        local there = gpu:lights(many)
        assert(ylm.bake(d, there, { occupied = floor }))
        local first = not longest
        longest = longest or {}
        for stage, t in pairs(there.stages) do
          if t.dispatches > 0 and not first then longest[stage] = math.min(longest[stage] or math.huge, t.longest) end
        end
        there:close()
        local most = 0
        for _, seconds in pairs(longest) do most = math.max(most, seconds) end
        if not first and most <= 0.05 then return end
      end
      for stage, seconds in pairs(longest) do
        assert(seconds <= 0.05, ("a dispatch of '%s' takes %.0f ms"):format(stage, seconds * 1e3))
      end
    end)
  end)
end)
