-- Shading points in a device's memory, that bakes there take where they lie. On Mesa's lavapipe, where there is no other
-- device.

local binding = require "ylm.c.vulkan"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local long = require "spec.support.long"
local numbers = require "spec.support.random"

local box = { { -1, -1, -1 }, { 1, 1, 1 } }
local lamps = bakes.lamps(40, { floor = true })

describe("shading points in a device's memory", function()
  local gpu = device.here()
  if not gpu then return end

  local function description(o)
    local d = { bounds = box, lmax = 2, depth = 4 }
    for k, v in pairs(o) do d[k] = v end
    return d.cells and ylm.uniform_grid { bounds = d.bounds, lmax = d.lmax, cells = d.cells } or ylm.adaptive_grid(d)
  end

  --- A bake of these points, the host's or there, and how many bytes it uploaded.
  local function bake(d, on, points)
    local before = on.stats.uploaded
    local grid = assert(ylm.bake(d, lamps, { occupied = points, device = on }))
    return grid, on.stats.uploaded - before
  end

  --- Bakes of the host's points and of the same there are the same to the bit; the second uploads the points less.
  local function same(o, points, on)
    on = on or gpu
    local there = on:array(points)
    local d = description(o)
    local here, all = bake(d, on, points)
    local grid, less = bake(d, on, there)
    assert(bakes.identical(here, grid))
    for _, key in ipairs { "outside", "points", "tested", "error", "rounds" } do
      local a, b = here.stats[key], grid.stats[key]
      assert(a == b or a ~= a and b ~= b, key)
    end
    local bytes = #points * 3 * (points.dtype == "double" and 8 or 4)
    there:close()
    return grid, all - less, bytes
  end

  local function points_of(n, dtype) return ylm.array(numbers.points_in(n, { -1.1, -1, -1 }, { 1, -0.9, 1 }, 7), dtype) end

  for _, dtype in ipairs { "float", "double" } do
    describe("of type " .. dtype, function()
      it("make the grid of the host's points by a threshold, and are not uploaded", function()
        for _, depth in ipairs { 0, 4, 9 } do
          local grid, less, bytes = same({ depth = depth, threshold = 0.5, lmax = 1 }, points_of(3000, dtype))
          assert.equal(bytes, less)
          assert(grid.stats.outside > 0)
        end
      end)

      it("make uniform grids", function()
        local _, less, bytes = same({ cells = { 5, 9, 7 } }, points_of(3000, dtype))
        assert.equal(bytes, less)
      end)

      it("make grids by a tolerance: all are held out, or some", function()
        for n, depth in pairs { [300] = 4, [3000] = long(7, 9) } do
          local grid, less, bytes = same({ depth = depth, tolerance = 0.05, lmax = 1 }, points_of(n, dtype))
          assert(grid.stats.verified > 0.9 * math.min(n, 2048) and grid.stats.stages.occupancy.dispatches > depth)
          -- of the points none; of those held out, which they are
          assert(less > 0.5 * bytes - 4 * 2048 * grid.stats.rounds)
        end
      end)

      it("are named where they are not finite", function()
        local points = points_of(3000, dtype)
        for bad, value in pairs { [2] = 0 / 0, [17] = math.huge, [2999] = -math.huge } do
          local some = points:clone()
          some:set(3000, 1, 1 / 0)
          some:set(bad, 2, value)
          local there = gpu:array(some)
          for _, o in ipairs { { threshold = 1 }, { tolerance = 0.1 }, { cells = 4 } } do
            local ok, message = pcall(ylm.bake, description(o), lamps, { occupied = there, device = gpu })
            assert(not ok and message:find(("occupied: point %d is not finite"):format(bad), 1, true), message)
          end
        end
      end)
    end)
  end

  it("are taken in parts, where kernels see fewer of them", function()
    local points, r = ylm.zeros({ long(1500000, 3000000), 3 }, "float"), numbers.minimal(5)
    for i = 1, #points, 997 do for a = 1, 3 do points:set(i, a, 2 * r() - 1) end end
    local own = device.open { validate = true }
    binding.gpu_shrink(own, 0, long(17, 30) * 2 ^ 20, 0)
    same({ tolerance = 0.1, lmax = 0 }, points, own)
    same({ threshold = 1, lmax = 0 }, points, own)
    device.close_silent(own)
  end)

  it("are brought to the host, where kernels see too few buffers for the octree, and for lattices too long for them", function()
    local own, points = device.open(), points_of(500, "float")
    local there = own:array(points)
    local d = ylm.uniform_grid { bounds = box, lmax = 0, cells = { 70000, 1, 1 } }
    assert(bakes.identical(bake(d, own, points), (bake(d, own, there))))
    binding.gpu_shrink(own, 0, 0, 8)
    for _, o in ipairs { { threshold = 0.5 }, { tolerance = 0.05 }, { cells = 4 } } do
      assert(bakes.identical(bake(description(o), own, points), (bake(description(o), own, there))))
    end
    own:close()
  end)

  it("are refused by the processor, by other devices, closed, of other shapes, and without bounds", function()
    local there, other = gpu:array(points_of(30, "float")), device.open()
    local function refused(pattern, o, options)
      local ok, message = pcall(function() return (ylm.bake(description(o), lamps, options)) end)
      assert(not ok and message:find("^spec/vulkan_points_spec.lua:%d+: ") and message:find(pattern, 1, true), message)
    end
    local threshold = { threshold = 1 }
    refused("device: occupied is in a device's memory: name the device, or download it", threshold, { occupied = there })
    for _, o in ipairs { threshold, { tolerance = 0.1 }, { cells = 4 } } do
      refused("another device", o, { occupied = there, device = other })
    end
    refused("occupied must be [n][3] on a device", threshold, { occupied = gpu:array { 1, 2, 3 }, device = gpu })
    refused("at least one point", threshold, { occupied = gpu:array(ylm.zeros({ 0, 3 }, "float")), device = gpu })
    local ok, message = pcall(ylm.bake, ylm.adaptive_grid { threshold = 1 }, lamps, { occupied = there, device = gpu })
    assert(not ok and message:find("no bounds: give them in the grid", 1, true), message)
    ok, message = pcall(ylm.bake, description(threshold), lamps, { occupied = there, device = gpu,
      progress = function() there:close() end })
    assert(not ok and tostring(message):find("in use by a call that has not returned"), message)
    there:close()
    refused("occupied: the array has been closed", threshold, { occupied = there, device = gpu })
    other:close()
  end)

  it("are found to lie in voxels by the processor where the device has no memory for that", function()
    local own, d = device.open { validate = true }, description { tolerance = 0.05 }
    local points = points_of(60000, "float")
    local here = assert(ylm.bake(d, lamps, { occupied = points }))
    binding.gpu_shrink(own, 0, 60000 * 12 - 1, 0) -- a kernel does not see all of them
    local grid = bake(d, own, points)
    assert(math.abs(here.stats.points - grid.stats.points) <= 0.01 * here.stats.points)
    local there = own:array(points)
    local none, message, code = ylm.bake(d, lamps, { occupied = there, device = own })
    assert(none == nil and code == "ELIMIT" and not message:find "needs more than", message)
    there:close()
    grid:close()
    device.close_silent(own)
  end)

  it("say so when the occupancy of a tolerance is cancelled", function()
    local there = gpu:array(points_of(3000, "float"))
    for _, points in ipairs { there, points_of(3000, "float") } do
      local none, message, code = ylm.bake(description { tolerance = 0.05 }, lamps, { occupied = points, device = gpu,
        progress = function(_, _, stage) return stage ~= "occupancy" end })
      assert.same({ nil, "cancelled", "ECANCELLED" }, { none, message, code })
    end
  end)

  it("are of use after the driver failed", function()
    local own = device.open { validate = true }
    local points = points_of(400, "float")
    local there, failures = own:array(points), 0
    for _, o in ipairs { { threshold = 0.5, depth = 3, lmax = 0 }, { tolerance = 0.1, depth = 3, lmax = 0 } } do
      local d, i = description(o), 1
      local right = bake(d, own, points)
      while binding.gpu_break(own, i, "memory") do
        local grid, _, code = ylm.bake(d, lamps, { occupied = there, device = own })
        if not grid then
          failures = failures + 1
          assert.equal("ENOMEM", code)
        end
        binding.gpu_break(own, i, "none")
        assert(bakes.identical(right, (bake(d, own, there))))
        i = i + long(2, 1)
      end
    end
    assert(failures >= long(5, 10), failures)
    there:close()
    collectgarbage()
    collectgarbage()
    device.close_silent(own)
  end)

  describe("of a prepared view", function()
    local scene = ylm.scene "two walls" {
      camera = ylm.camera { from = { 0, 1, 3 }, at = { 0, 0, 0 }, fov = 50 },
      geometry = { ylm.quad { corner = { -1, -1, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
        ylm.sphere { at = { 0, -0.6, 0 }, radius = 0.4 } },
      lights = { ylm.sphere_light { at = { 0.5, 1, 0.5 }, radius = 0.1, radiance = { 10, 8, 6 } } },
      probes = ylm.adaptive_grid { lmax = 2, depth = 4, threshold = 1 },
    }

    it("are copied once, for bakes and pictures", function()
      local view = assert(scene:prepare { size = { 64, 48 }, samples = 2, transfer_samples = 8,
        visibility = "transfer", lmax = 2 })
      local d, lights = description { threshold = 0.5 }, gpu:lights(lamps)
      local function run(occupied)
        local before = gpu.stats.uploaded
        local grid = assert(ylm.bake(d, lights, { occupied = occupied }))
        return grid, gpu.stats.uploaded - before
      end
      local bytes = 12 * view.stats.points
      run(view:points().position) -- what sums need is copied
      local here, all = run(view:points().position)
      local first, once = run(view)
      local second, less = run(view)
      assert(bakes.identical(here, first) and bakes.identical(here, second))
      assert.same({ all, all - bytes }, { once, less })
      local before = gpu.stats.uploaded
      assert(view:render { grid = second, device = gpu, layers = false })
      local drawn = gpu.stats.uploaded - before
      local fresh = assert(scene:prepare { size = { 64, 48 }, samples = 2, transfer_samples = 8,
        visibility = "transfer", lmax = 2 })
      before = gpu.stats.uploaded
      assert(fresh:render { grid = second, device = gpu, layers = false })
      assert.equal(bytes, gpu.stats.uploaded - before - drawn)
      before = gpu.stats.uploaded
      assert(bakes.identical(here, assert(ylm.bake(d, lights, { occupied = fresh }))))
      assert(gpu.stats.uploaded - before < all - bytes + 1000)
      assert(bakes.identical(assert(ylm.bake(d, lamps, { occupied = view })),
        assert(ylm.bake(d, lamps, { occupied = view:points().position }))))
    end)

    it("serve scene:bake, with its device too", function()
      local view = assert(scene:prepare { size = { 32, 24 }, samples = 2, transfer_samples = 8,
        visibility = "transfer", lmax = 2 })
      local here = assert(scene:bake { occupied = view })
      local there = assert(scene:bake { occupied = view, device = gpu })
      bakes.same(here, there)
      assert(there.stats.stages.subdivide and not here.stats.stages)
      local again = assert(scene:bake { occupied = gpu:array(view:points().position), device = gpu })
      assert(bakes.identical(there, again))
      local away = ylm.scene "nothing" { camera = ylm.camera { from = { 0, 3, 0 }, at = { 0, 4, 0.1 }, fov = 30 },
        geometry = scene.geometry, lights = scene.lights, probes = scene.probes }
      local none = assert(away:prepare { size = { 8, 8 }, samples = 1 })
      local ok, message = pcall(away.bake, away, { occupied = none, device = gpu })
      assert(not ok and message:find("no shading points: the camera sees no geometry", 1, true), message)
      ok, message = pcall(ylm.bake, description { threshold = 1 }, lamps, { occupied = none, device = gpu })
      assert(not ok and message:find("at least one point", 1, true), message)
      view:close()
      ok, message = pcall(ylm.bake, description { threshold = 1 }, lamps, { occupied = view, device = gpu })
      assert(not ok and message:find("the prepared view has been closed", 1, true), message)
    end)
  end)
end)
