-- Uniform grids made on a device, voxels, points and light field, against the processor's. On Mesa's lavapipe, where there
-- is no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local with = require "spec.support.with"

local box, floor = bakes.box, bakes.floor(400)

local lamps = bakes.lamps(40, { dark = true, floor = true })

describe("a uniform grid made on a device", function()
  local gpu = device.here()
  if not gpu then return end

  --- The grid by the processor and on the device `on`, which must be the same.
  local function same(o, occupied, on, lights)
    local d = ylm.uniform_grid(with({ bounds = box, lmax = 2, cells = 5 }, o))
    local here, there = bakes.both(d, lights or lamps, { occupied = occupied }, on or gpu, "subdivide")
    bakes.same(here, there)
    for i = 1, 3 do assert.equal(here.resolution[i], there.resolution[i]) end
    local a, b = here:sample(floor), there:sample(floor)
    local _, e, norm = core.array_distance(b, a)
    assert(e <= 1e-5 * norm)
    return here, there
  end

  describe("has the processor's voxels and points, in their order", function()
    it("where every voxel is occupied, of all extents", function()
      for _, cells in ipairs { { 1, 1, 1 }, { 1, 7, 1 }, { 5, 4, 3 }, { 2, 2, 33 }, { 64, 1, 2 } } do
        local here = same({ cells = cells })
        assert.equal((cells[1] + 1) * (cells[2] + 1) * (cells[3] + 1), here.stats.points)
      end
    end)

    it("where shading points are, some of them outside", function()
      local here = same({ cells = { 9, 6, 7 } }, floor)
      assert(here.stats.cells < 100)
      here = same({ bounds = { { -2, -1, -0.25 }, { 1, 0, 1 } }, cells = { 3, 4, 5 } }, floor)
      assert(here.stats.outside > 0)
      same({ cells = 32 }, { { 0.3, 0.1, 0.2 } })
    end)

    it("where points lie on faces of voxels, and next to them by one bit, as float and as double", function()
      local bounds, cells = { { -0.3, -1, 0 }, { 0.9, 1.7, 1e-3 } }, { 13, 8, 21 }
      for _, dtype in ipairs { "float", "double" } do
        local at, bit = {}, dtype == "float" and 2 ^ -23 or 2 ^ -52
        for i = 0, 21 do
          for k = -1, 1 do
            local p = {}
            for a = 1, 3 do
              local n = cells[a]
              local x = bounds[1][a] + (bounds[2][a] - bounds[1][a]) * ((i * (2 * a - 1)) % (n + 1)) / n
              p[a] = x == 0 and k * 1e-30 or x * (1 + k * bit)
            end
            at[#at + 1] = p
          end
        end
        local here = same({ bounds = bounds, cells = cells, lmax = 0 }, ylm.array(at, dtype), nil,
          ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.1, radiance = 1 })
        assert(here.stats.outside > 0)
      end
    end)

    it("without the metric, with that of rgb, absolute, in luminance, at high lmax", function()
      local _, there = same({ metric_channels = "none" }, floor)
      local e = there:cells().error:get(1)
      assert(e ~= e)
      same({ metric_channels = "rgb" }, floor)
      same({ metric = "absolute" })
      same({ channels = "luminance" }, floor)
      same({ lmax = 10, cells = 2 })
    end)

    it("with points in lights", function()
      local here = same({ cells = 12 })
      assert(here.stats.invalid > 3)
    end)

    it("on a device that does not compute in double, and in passes of some hundred points", function()
      local own = device.open { staging = true, validate = true }
      require "ylm.c.vulkan".gpu_shrink(own, 0, 400 * 1024, 0, true)
      same({ cells = { 9, 8, 7 }, lmax = 4 }, nil, own)
      device.close_silent(own)
    end)
  end)

  it("is refused where it needs more points than max_points", function()
    local d = ylm.uniform_grid { bounds = box, cells = 3, lmax = 1 }
    assert(ylm.bake(d, lamps, { device = gpu, max_points = 64 }))
    assert.same({ nil, "the grid needs more than 63 points", "ELIMIT" },
      { ylm.bake(d, lamps, { device = gpu, max_points = 63 }) })
  end)

  it("has its voxels found by the processor where kernels see too little for them", function()
    local own = device.open { validate = true }
    require "ylm.c.vulkan".gpu_shrink(own, 0, 200 * 1024, 0)
    local d = ylm.uniform_grid { bounds = box, cells = { 30, 20, 11 }, lmax = 0, channels = "luminance" }
    local many = bakes.floor(7000)
    local here = ylm.bake(d, lamps, { occupied = many })
    local there = assert(ylm.bake(d, lamps, { occupied = many, device = own }))
    bakes.same(here, there)
    assert(not there.stats.stages.subdivide and there.stats.stages.points)
    there:close()
    device.close_silent(own)
  end)

  it("is cancelled in whatever stage progress says so, and gives back what it took", function()
    local d = ylm.uniform_grid { bounds = box, cells = 6, lmax = 2 }
    for _, where in ipairs { "occupancy", "baking", "download" } do
      collectgarbage()
      collectgarbage()
      local arrays, seen = gpu.stats.arrays, false
      local none, message, code = ylm.bake(d, lamps, { occupied = floor, device = gpu, progress = function(_, _, stage)
        seen = seen or stage == where
        return stage ~= where
      end })
      assert.same({ nil, "cancelled", "ECANCELLED", true }, { none, message, code, seen }, where)
      assert.equal(arrays, gpu.stats.arrays)
    end
  end)
end)
