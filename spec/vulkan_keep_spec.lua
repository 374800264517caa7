-- The copy of a grid that a bake on a device leaves there, and that is not uploaded again. On Mesa's lavapipe, where there is
-- no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local numbers = require "spec.support.random"

local box, floor = bakes.box, bakes.floor(400)
local everywhere = numbers.points_in(3000, { -1, -1, -1 }, { 1, 1, 1 }, 8)

local lamps = bakes.lamps(40, { floor = true })

describe("a grid baked on a device", function()
  local gpu = device.here()
  if not gpu then return end
  local own

  local kinds = {
    ["with a threshold"] = ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, threshold = 0.5 },
    ["with a threshold, not continuous"] = ylm.adaptive_grid { bounds = box, lmax = 3, depth = 4, threshold = 0.5,
      continuous = false },
    ["with a tolerance"] = ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, tolerance = 0.01 },
    ["that is uniform"] = ylm.uniform_grid { bounds = box, cells = { 5, 6, 7 }, lmax = 4 },
    ["that is uniform and knows no metric"] = ylm.uniform_grid { bounds = box, cells = 6, lmax = 2, metric_channels = "none" },
  }

  --- The largest distance of two arrays' rows, relative to the largest row.
  local function near(a, b, bound)
    local _, e, norm = core.array_distance(b, a)
    assert(e <= bound * norm, e / norm)
  end

  --- Samples agree with those of the processor from the same grid.
  local function agrees(grid, on)
    for _, at in ipairs { floor, everywhere } do
      local a, da = grid:sample(at, { derivatives = 1 })
      local b, db = assert(grid:sample(at, { derivatives = 1, device = on }))
      near(a, b, 1e-5)
      near(da, db, 2e-5)
    end
  end

  for name, d in pairs(kinds) do
    describe(name, function()
      it("is sampled without being uploaded", function()
        local grid = assert(ylm.bake(d, lamps, { occupied = floor, device = gpu }))
        assert(grid.stats.invalid > 0)
        assert(not d.continuous or grid.stats.interpolated > 100)
        local there = gpu:array(floor)
        local uploaded = gpu.stats.uploaded
        local c = assert(grid:sample(there, { device = gpu }))
        assert.equal(uploaded, gpu.stats.uploaded)
        local copy = grid:to(gpu)
        assert(copy.bytes > grid.stats.points * 1000 / 25 * (grid.lmax + 1) ^ 2 and copy.seconds == 0)
        assert.equal(uploaded, gpu.stats.uploaded)
        near((grid:sample(floor)), (c:download()), 1e-5)
        agrees(grid, gpu)
      end)

      it("holds what the copy of the finished grid holds", function()
        local grid = assert(ylm.bake(d, lamps, { occupied = floor, device = gpu }))
        local kept = { grid:sample(everywhere, { derivatives = 1, device = gpu }) }
        local bytes = grid:to(gpu).bytes
        grid:to(gpu):close()
        local again = { grid:sample(everywhere, { derivatives = 1, device = gpu }) }
        assert.equal(bytes, grid:to(gpu).bytes)
        near(again[1], kept[1], 1e-6)
        near(again[2], kept[2], 1e-5)
        assert.same({ again[3].outside, again[3].unbaked }, { kept[3].outside, kept[3].unbaked })
      end)

      it("uploads less than its coefficients in all", function()
        local there = gpu:lights(lamps)
        ylm.bake(d, there, { occupied = floor, device = gpu }) -- makes tables of the sums
        local before = gpu.stats.uploaded
        local grid = assert(ylm.bake(d, there, { occupied = floor, device = gpu }))
        local rows = (grid.stats.points + grid.stats.interpolated) * 4 * 3 * (grid.lmax + 1) ^ 2 * 4
        local rest = #grid:cells { added = true }.origin * 64 + grid.stats.interpolated * 12
          + grid.stats.invalid * 4 * 4 * (3 * (grid.lmax + 1) ^ 2 + 8) * (1 + (grid.stats.rounds or 0))
          + grid.stats.points * (8 + 52) + 400 * 64 * (grid.stats.rounds or 0) -- keys and probes
        local uploaded = gpu.stats.uploaded - before
        assert(uploaded < rest + 20000 and uploaded < rows / 2, ("%d bytes; the rows have %d"):format(uploaded, rows))
      end)
    end)
  end

  local d = kinds["with a threshold"]

  it("goes on from lights that lie there, without naming the device", function()
    local grid = assert(ylm.bake(d, gpu:lights(lamps), { occupied = floor }))
    local there = gpu:array(floor)
    local uploaded = gpu.stats.uploaded
    assert(grid:sample(there, { device = gpu }))
    assert.equal(uploaded, gpu.stats.uploaded)
  end)

  it("gives its memory back when it is closed or forgotten, and survives the device", function()
    own = device.open { validate = true }
    local grid = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
    collectgarbage()
    collectgarbage()
    assert(own.stats.arrays > 0)
    grid:close()
    assert.equal(0, own.stats.arrays)
    grid = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
    assert(grid.stats.points > 0)
    grid = nil -- luacheck: ignore
    for _ = 1, 3 do collectgarbage() end
    assert.equal(0, own.stats.arrays)
    grid = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
    device.close_silent(own)
    assert(#grid:sample(floor) == 400)
    assert(not pcall(grid.sample, grid, floor, { device = own }))
    grid:close()
  end)

  it("does not stay where there is no room for it, and is uploaded then", function()
    own = device.open { validate = true }
    local whole, here = own.limits.memory_bytes, ylm.bake(d, lamps, { occupied = floor })
    local rows = (here.stats.points + here.stats.interpolated) * 4 * 80 * 4
    -- rows may take a quarter of the memory: they come to the host as often as there is no room
    require "ylm.c.vulkan".gpu_shrink(own, 3 * rows, 0, 0)
    local grid = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
    collectgarbage()
    collectgarbage()
    assert.equal(0, own.stats.arrays)
    require "ylm.c.vulkan".gpu_shrink(own, whole, 0, 0)
    agrees(grid, own)
    grid:to(own):close()
    device.close_silent(own)
  end)

  it("lies in as many parts as kernels see", function()
    own = device.open { validate = true }
    local here = ylm.bake(d, lamps, { occupied = floor })
    local rows = (here.stats.points + here.stats.interpolated) * 4 * 80 * 4
    require "ylm.c.vulkan".gpu_shrink(own, 0, rows / 3, 0)
    local grid = assert(ylm.bake(d, lamps, { occupied = floor, device = own }))
    local there = own:array(floor)
    local uploaded = own.stats.uploaded
    assert(grid:sample(there, { device = own }))
    assert.equal(uploaded, own.stats.uploaded)
    agrees(grid, own)
    grid:to(own):close()
    there:close()
    device.close_silent(own)
  end)
end)
