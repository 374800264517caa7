--- ylm.bake: where grids refine, what they promise, and that a bake leaves nothing behind.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"

local SEED, box, lamp, lamps, occupied = grids.seed, grids.box, grids.lamp, grids.lamps, grids.occupied
local errors, quantile, analytic = grids.errors, grids.quantile, grids.analytic

describe("ylm.bake: properties", function()
  it("keeps what it had while its arrays grow beyond some megabytes", function()
    local n = 17 -- 18^3 points of 1280 bytes: pages that move, where smaller arrays are copied
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = n, lmax = 4 }, lamps)
    local points = grid:points()
    local exact = ylm.light_field(4, lamps, points.position, { dtype = "float" })
    local e = errors(points.value, exact)
    assert.equal((n + 1) ^ 3, #points.position)
    assert.is_true(quantile(e, 0.99) < 1e-5, quantile(e, 0.99))
  end)

  it("evaluates each corner once, whole levels in one batch", function()
    local seen, batches = {}, 0
    local field = analytic(function(x) return x, 1, 0, 0 end, function() return 1 end)
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 4, threshold = 0 }, function(points, ...)
      batches = batches + 1
      for i = 1, #points do
        local key = ("%.9g %.9g %.9g"):format(points:get(i, 1), points:get(i, 2), points:get(i, 3))
        assert(not seen[key], key)
        seen[key] = true
      end
      return field(points, ...)
    end, { occupied = occupied })
    local n = 0
    for _ in pairs(seen) do n = n + 1 end
    assert.equal(grid.stats.points, n)
    assert.equal(5, batches)
  end)

  it("stops at unoccupied voxels, and says where they answer for points", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 4, threshold = 0 }, lamp,
      { occupied = occupied })
    local cells = grid:cells()
    for i = 1, #cells.level do
      if cells.leaf[i] == 1 and cells.occupied[i] == 1 then assert.equal(4, cells.level[i]) end
      if cells.leaf[i] == 0 then assert.equal(1, cells.occupied[i]) end
      if cells.occupied[i] == 1 then assert.equal(1, cells.baked[i]) end
    end
    local _, _, report = grid:sample(occupied)
    assert.equal(0, report.unbaked)
    assert.equal(0, report.outside)
    local c
    c, _, report = grid:sample { { 0.9, -0.9, 0.9 }, { 5, 0, 0 } }
    assert.equal(1, report.outside)
    assert.is_true(report.unbaked >= 1)
    assert.is_true(core.array_finite(c))
    c = grid:sample({ { 0.9, -0.9, 0.9 }, { 5, 0, 0 } }, { outside = "nan" })
    assert.is_true(core.array_finite(c[1]))
    assert.is_false(core.array_finite(c[2]))
  end)

  it("bakes only the shading voxels of a uniform grid, and answers beside them from the nearest", function()
    local all = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 4, 6, 8 }, lmax = 1 }, lamp)
    assert.equal(5 * 7 * 9, all.stats.points)
    local some = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 4, 6, 8 }, lmax = 1 }, lamp,
      { occupied = occupied })
    assert.is_true(some.stats.points < all.stats.points)
    assert.equal(0, core.array_distance(all:sample(occupied), some:sample(occupied)))
    assert.is_nil(some:locate { 0.9, -0.9, 0.9 })
    local c, _, report = some:sample { { 0.9, -0.9, 0.9 } }
    assert.equal(1, report.unbaked)
    assert.is_true(core.array_finite(c))
  end)

  it("leaves the metric out where it is not wanted, and keeps the same coefficients", function()
    local one = ylm.sphere_light { at = { 0.3, 1.4, 0.2 }, radius = 0.1, radiance = 3 }
    local function bake(of)
      return ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = 2,
        metric_channels = of }, one)
    end
    local with, without = bake "luminance", bake "none"
    assert.equal(0, core.array_distance(with:points().value, without:points().value))
    assert.is_true(with:cells().error:get(1) > 0)
    local unknown = without:cells().error:get(1)
    assert.is_true(unknown ~= unknown)
    local name = os.tmpname() .. ".ylm"
    assert(without:save(name))
    assert.equal("none", assert(ylm.load(name)).metric_channels)
    os.remove(name)
  end)

  it("refines voxels that a light's surface crosses, and fills corners inside of lights", function()
    local ball = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.4 }
    local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1.1, -1, -1 }, { 1, 1.2, 1 } }, lmax = 2, depth = 5,
      threshold = 1e9 },
      ball, { occupied = { { 0.4, 0, 0 }, { 0, 0.41, 0 } } })
    assert.equal(5, grid:locate({ 0.4, 0, 0 }).level)
    assert.is_true(grid.stats.invalid > 0)
    local points, invalid = grid:points(), 0
    for i = 1, #points.invalid do
      if points.invalid[i] == 1 then
        invalid = invalid + 1
        assert.is_true(points.value[i][1][1] ~= 1 / 0)
      end
    end
    assert.equal(grid.stats.invalid, invalid)
    local c = grid:sample { 0.401, 0, 0 }
    local exact = ylm.light_field(2, ball, { 0.401, 0, 0 })
    local _, d, norm = core.array_distance(c, exact)
    assert.is_true(d < 0.3 * norm, d / norm) -- filled first-order: near, where a jump would be 100 %
  end)

  for _, tolerance in ipairs { 0.1, 0.01, 0.001 } do
    it("keeps the tolerance " .. tolerance .. " at 99 % of the shading points", function()
      local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 10, tolerance = tolerance }, lamps,
        { occupied = occupied })
      local e = errors(grid:sample(occupied), ylm.light_field(4, lamps, occupied, { dtype = "float" }))
      assert.is_true(grid.stats.met)
      assert.is_true(grid.stats.error <= tolerance and grid.stats.error > 0)
      assert.is_true(quantile(e, 0.99) <= tolerance, quantile(e, 0.99))
      assert.is_true(quantile(e, 0.99) > tolerance / 10, "wasteful: " .. quantile(e, 0.99))
    end)
  end

  it("says where the depth did not suffice for the tolerance", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 2, tolerance = 1e-3 }, lamps,
      { occupied = occupied })
    assert.is_false(grid.stats.met)
    assert.is_true(grid.stats.limited)
    assert.is_true(grid.stats.error > 1e-3)
  end)

  it("is bit-identical whatever the number of threads", function()
    local made = {}
    for threads = 1, 3 do
      made[threads] = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, tolerance = 0.01 }, lamps,
        { occupied = occupied, threads = threads })
    end
    for threads = 2, 3 do
      assert.equal(0, core.array_distance(made[1]:points().value, made[threads]:points().value))
      assert.equal(0, core.array_distance(made[1]:cells().corners, made[threads]:cells().corners))
      local a = made[1]:sample(occupied, { threads = 1 })
      assert.equal(0, core.array_distance(a, made[threads]:sample(occupied, { threads = threads })))
    end
  end)

  it("can be cancelled and leaves nothing behind", function()
    local function resident()
      local file = io.open("/proc/self/statm")
      if not file then return 0 end
      local _, pages = file:read("*n", "*n")
      file:close()
      return pages * 4096
    end
    local function cancelled(stop)
      local calls = 0
      local grid, message, code = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, threshold = 1 },
        lamps,
        { occupied = occupied, progress = function()
          calls = calls + 1
          return calls < stop
        end })
      assert.is_nil(grid)
      assert.equal("cancelled", message)
      assert.equal("ECANCELLED", code)
    end
    -- Resident memory moves by megabytes with what the allocator keeps; what leaks grows without end.
    local most = { 0, 0 }
    for half = 1, 2 do
      for _ = 1, 4 do
        for i = 1, 60 do cancelled(1 + i % 7) end
        collectgarbage()
        collectgarbage()
        most[half] = math.max(most[half], resident())
      end
    end
    local each = (most[2] - most[1]) / 240
    assert.is_true(each < 32768, ("%.0f bytes more per cancelled bake"):format(each))
  end)

  it("reports progress", function()
    local stages, last = {}, nil
    ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.01 }, lamps, { occupied = occupied,
      progress = function(done, total, stage)
        assert(done <= total)
        if stage ~= last then stages[#stages + 1], last = stage, stage end
      end })
    assert.equal("level 0", stages[1])
    assert.is_true(table.concat(stages, " "):find("verifying") ~= nil)
  end)
end)

describe("ylm.bake: agreement", function()
  --- The paper's Sec. 5.1 in so many words: leaves and points of the adaptive grid.
  local function by_the_book(depth, threshold, points)
    local lattice, n, leaves = {}, 0, 0
    local size = 2 ^ depth
    local taken = {}
    for i = 1, #points do
      local c = {}
      for a = 1, 3 do c[a] = math.min(size - 1, math.floor((points:get(i, a) + 1) / 2 * size)) end
      for level = depth, 0, -1 do
        taken[("%d %d %d %d"):format(level, c[1], c[2], c[3])] = true
        for a = 1, 3 do c[a] = math.floor(c[a] / 2) end
      end
    end
    local function metric(x, y, z)
      local key = ("%d %d %d"):format(x, y, z)
      if not lattice[key] then
        n = n + 1
        local _, _, _, r = ylm.light_field(4, lamps, { 2 * x / size - 1, 2 * y / size - 1, 2 * z / size - 1 },
          { metric = "luminance", channels = "luminance" })
        lattice[key] = r.lambda[1] / r.norm[1]
      end
      return lattice[key]
    end
    local function visit(level, x, y, z)
      local edge, sum = 2 ^ (depth - level), 0
      if not taken[("%d %d %d %d"):format(level, x, y, z)] then
        leaves = leaves + 1
        return
      end
      for k = 0, 7 do
        sum = sum + metric((x + k % 2) * edge, (y + math.floor(k / 2) % 2) * edge, (z + math.floor(k / 4)) * edge)
      end
      local diagonal2 = 3 * (2 * edge / size) ^ 2
      local crossed = false
      local lo = { 2 * x * edge / size - 1, 2 * y * edge / size - 1, 2 * z * edge / size - 1 }
      for _, l in ipairs(lamps) do
        local near, far = 0, 0
        for a = 1, 3 do
          local low, high = lo[a] - l.at[a], lo[a] + 2 * edge / size - l.at[a]
          near = near + math.max(low, -high, 0) ^ 2
          far = far + math.max(math.abs(low), math.abs(high)) ^ 2
        end
        crossed = crossed or (near <= l.radius ^ 2 and far >= l.radius ^ 2)
      end
      if level < depth and (sum / 8 * diagonal2 / 2 > threshold or crossed) then
        for k = 0, 7 do
          visit(level + 1, 2 * x + k % 2, 2 * y + math.floor(k / 2) % 2, 2 * z + math.floor(k / 4))
        end
      else
        leaves = leaves + 1
      end
    end
    visit(0, 0, 0, 0)
    return n, leaves
  end

  it("refines as the paper's algorithm does, voxel by voxel", function()
    local few = grids.shading_points(400, SEED)
    local n, leaves = by_the_book(5, 4, few)
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, metric = "relative", threshold = 4 },
      lamps,
      { occupied = few })
    assert.equal(n, grid.stats.points)
    assert.equal(leaves, grid.stats.leaves)
  end)
end)
