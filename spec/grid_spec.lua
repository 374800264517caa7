local core = require "ylm.c.core"
local ylm = require "ylm"
local numbers = require "spec.support.random"

local SEED = 20251121

local random, points_in = numbers.minimal, numbers.points_in

local box = { { -1, -1, -1 }, { 1, 1, 1 } }

--- Sorted relative errors |a_i - b_i| / |b_i| of rows.
local function errors(a, b)
  local e = {}
  for i = 1, #a do
    local _, d, norm = core.array_distance(a[i], b[i])
    e[i] = d / norm
  end
  table.sort(e)
  return e
end

local function quantile(sorted, q) return sorted[math.ceil(q * #sorted)] end

--- An analytic field from f(x, y, z) -> value, dx, dy, dz of its first coefficient (others are 0).
local function analytic(f, lambda)
  return function(points, lmax, channels)
    local n, count = #points, (lmax + 1) ^ 2
    local value, gradient = ylm.zeros { n, channels, count }, ylm.zeros { n, channels, count, 3 }
    local metric = ylm.zeros { n }
    for i = 1, n do
      local v, dx, dy, dz = f(points:get(i, 1), points:get(i, 2), points:get(i, 3))
      for c = 1, channels do
        value:set(i, c, 1, v)
        gradient:set(i, c, 1, 1, dx)
        gradient:set(i, c, 1, 2, dy)
        gradient:set(i, c, 1, 3, dz)
      end
      metric[i] = lambda and lambda(points:get(i, 1), points:get(i, 2), points:get(i, 3)) or 0
    end
    return value, gradient, metric
  end
end

--- Largest difference between samples and f.
local function worst(grid, points, f, options)
  local c, most = grid:sample(points, options), 0
  for i = 1, #points do
    local v = f(points:get(i, 1), points:get(i, 2), points:get(i, 3))
    most = math.max(most, math.abs(c:get(i, 1, 1) - v))
  end
  return most
end

local lamp = ylm.sphere_light { at = { 0.1, 0.3, 0.2 }, radius = 0.1, radiance = { 10, 8, 6 } }
local lamps = {
  ylm.sphere_light { at = { 0.1, 0.2, 0.2 }, radius = 0.05, radiance = { 10, 8, 6 } },
  ylm.sphere_light { at = { -0.7, 0.1, -0.5 }, radius = 0.05, radiance = { 2, 8, 20 } },
  ylm.sphere_light { at = { 0.5, 3, -2 }, radius = 0.5, radiance = 4 },
}

--- Shading points on a floor and on a ball.
local function shading_points(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do
    if i % 3 > 0 then t[i] = { 2 * r() - 1, 0.013, 2 * r() - 1 }
    else
      local z, phi = 2 * r() - 1, 2 * math.pi * r()
      local s = math.sqrt(1 - z * z)
      t[i] = { 0.4 * s * math.cos(phi) - 0.3, 0.45 + 0.4 * s * math.sin(phi), 0.4 * z + 0.3 }
    end
  end
  return ylm.array(t, "double")
end

local occupied = shading_points(6000, SEED)

describe("ylm.bake: convention", function()
  it("keeps at the corners what the reference vectors say", function()
    local light, corners, inner = nil, {}, {}
    for line in io.lines("spec/data/hermite_grid.txt") do
      local tag, rest = line:match("^(%u) (.*)")
      local row = {}
      for word in (rest or ""):gmatch("%S+") do row[#row + 1] = tonumber(word) end
      if tag == "S" then light = row elseif tag == "C" then corners[#corners + 1] = row
      elseif tag == "P" then inner[#inner + 1] = row end
    end
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 3,
      channels = "luminance" }, ylm.sphere_light { at = { light[1], light[2], light[3] }, radius = light[4] })
    local points = grid:points()
    local row = {}
    for i = 1, 8 do
      row[("%g %g %g"):format(points.position:get(i, 1), points.position:get(i, 2), points.position:get(i, 3))] = i
    end
    for _, c in ipairs(corners) do
      local i, k = row[("%g %g %g"):format(c[1], c[2], c[3])], ylm.sh.index(c[4], c[5])
      assert.near(c[6], points.value:get(i, 1, k), 1e-6)
      for a = 1, 3 do assert.near(c[6 + a], points.gradient:get(i, 1, k, a), 1e-6) end
    end
    local norm = points.norm[1]
    for _, p in ipairs(inner) do -- interpolated across the whole voxel: a few percent
      local c = grid:sample { p[1], p[2], p[3] }
      assert.near(p[6], c:get(1, ylm.sh.index(p[4], p[5])), 0.05 * norm)
    end
  end)

  it("has half-open cells, the last ones closed, for occupancy and locate alike", function()
    local function cell_of(p)
      local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 3, threshold = 0 }, lamp,
        { occupied = { p } })
      local cell = grid:locate(p)
      assert.is_true(cell.leaf and cell.occupied and cell.baked)
      assert.equal(3, cell.level)
      return cell.origin
    end
    assert.same({ 0, 0, 0 }, cell_of { 0, 0, 0 })
    assert.same({ -0.25, 0.75, -1 }, cell_of { -1e-12, 1, -1 })
    assert.same({ 0.75, 0.75, 0.75 }, cell_of { 1, 1, 1 })
    assert.same({ 0.75, -1, 0.75 }, cell_of { 7, -9, 1 }) -- outside: the nearest
  end)

  it("numbers cells and points from 1, levels from 0, parents before children", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 2, threshold = 0 }, lamp)
    local cells = grid:cells()
    assert.equal(1 + 8 + 64, #cells.level)
    assert.equal(0, cells.level[1])
    assert.same({ -1, -1, -1 }, cells.origin[1]:totable())
    assert.same({ 2, 2, 2 }, cells.size[1]:totable())
    assert.equal(125, grid.stats.points)
    assert.equal(64, grid.stats.leaves)
    assert.equal(3, grid.stats.levels)
    assert.equal(125, grid.stats.pairs)
  end)
end)

describe("a grid's fields", function()
  it("are what it was described with; resolution is the voxels along each axis", function()
    local u = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 2, 3, 4 }, lmax = 1, channels = "luminance" }, lamp)
    local a = ylm.bake(ylm.adaptive_grid { bounds = box, depth = 3, lmax = 2, threshold = 50 }, lamp)
    assert.same({ 2, 3, 4 }, u.resolution)
    assert.same({ 8, 8, 8 }, a.resolution)
    assert.same({ "uniform", 1, 1, "adaptive", 2, 3, 3, 50 },
      { u.kind, u.lmax, u.channels, a.kind, a.lmax, a.channels, a.depth, a.threshold })
    assert.same(box, u.bounds)
    assert.equal(24, #u:cells().level)
    assert.is_nil(u.depth)
  end)
end)

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

  it("is exact for cubics and for trilinear functions", function()
    local function cubic(x, y, z)
      return 1 + x - 2 * y + z * z - x * x * y + 0.5 * z ^ 3 + x * y * z + y * y * y - x * z * z,
        1 - 2 * x * y + y * z - z * z, -2 - x * x + x * z + 3 * y * y, 2 * z + 1.5 * z * z + x * y - 2 * x * z
    end
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, 0, 1 }, { 1, 3, 2 } }, cells = { 2, 3, 1 }, lmax = 1 },
      analytic(cubic))
    local points = points_in(500, { -1, 0, 1 }, { 1, 3, 2 }, SEED)
    assert.is_true(worst(grid, points, cubic) < 1e-4)
    local _, slopes = grid:sample(points, { derivatives = 1, dtype = "double" })
    for i = 1, #points do
      local _, dx, dy, dz = cubic(points:get(i, 1), points:get(i, 2), points:get(i, 3))
      assert.near(dx, slopes:get(i, 3, 1, 1), 2e-4)
      assert.near(dy, slopes:get(i, 3, 1, 2), 2e-4)
      assert.near(dz, slopes:get(i, 3, 1, 3), 2e-4)
    end
  end)

  it("converges by the fourth order with Hermite, by the second with Taylor and linear", function()
    local points = points_in(400, { -1, -1, -1 }, { 1, 1, 1 }, SEED)
    local far = ylm.sphere_light { at = { 1.5, 2, 0.5 }, radius = 0.5 }
    local exact = ylm.light_field(4, far, points, { channels = "luminance" })
    local order = {}
    for _, how in ipairs { "hermite", "taylor", "linear" } do
      local e = {}
      for k, cells in ipairs { 4, 8 } do
        local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = cells, lmax = 4, channels = "luminance" }, far)
        e[k] = quantile(errors(grid:sample(points, { interpolation = how, dtype = "double" }), exact), 0.9)
      end
      order[how] = math.log(e[1] / e[2]) / math.log(2)
    end
    assert.is_true(order.hermite > 3.5, "hermite " .. order.hermite)
    assert.is_true(order.taylor > 1.6 and order.taylor < 2.6, "taylor " .. order.taylor)
    assert.is_true(order.linear > 1.6 and order.linear < 2.6, "linear " .. order.linear)
  end)

  it("gives the interpolant's own gradient", function()
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 3, lmax = 2 }, lamp)
    local p, h = { 0.4, -0.35, 0.61 }, 1e-3
    for _, how in ipairs { "hermite", "taylor", "linear" } do
      local o = { interpolation = how, dtype = "double", derivatives = 1 }
      local _, slope = grid:sample(p, o)
      for a = 1, 3 do
        local q, r = { p[1], p[2], p[3] }, { p[1], p[2], p[3] }
        q[a], r[a] = q[a] + h, r[a] - h
        local up, down = grid:sample(q, o), grid:sample(r, o)
        for k = 1, 9 do
          assert.near((up:get(2, k) - down:get(2, k)) / (2 * h), slope:get(2, k, a), 2e-3)
        end
      end
    end
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

  it("is continuous across levels, and no less accurate for it", function()
    local made = {}
    for _, on in ipairs { true, false } do
      made[on] = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, metric = "relative", threshold = 3,
        continuous = on }, lamps, { occupied = occupied })
    end
    assert.equal(made[true].stats.points, made[false].stats.points)
    local cells, r = made[true]:cells(), random(SEED)
    local low, high, n, tries = {}, {}, 0, 0
    local eps = 2 ^ -40
    while n < 10000 and tries < 4e6 do
      tries = tries + 1
      local i = math.floor(r() * #cells.level) + 1
      if cells.leaf[i] == 1 then
        local axis = math.floor(r() * 3) + 1
        local p, q = {}, {}
        for a = 1, 3 do
          p[a] = cells.origin:get(i, a) + cells.size:get(i, a) * r()
          q[a] = p[a]
        end
        local side = cells.origin:get(i, axis)
        p[axis], q[axis] = side + eps, side - eps
        if side > -1 and made[true]:locate(q).level ~= cells.level[i] then
          n = n + 1
          low[n], high[n] = q, p
        end
      end
    end
    assert.equal(10000, n)
    local function largest(grid)
      local a, b = grid:sample(ylm.array(low, "double")), grid:sample(ylm.array(high, "double"))
      local e = errors(a, b)
      return e[#e]
    end
    assert.is_true(largest(made[true]) <= 2e-6, largest(made[true]))
    assert.is_true(largest(made[false]) >= 1e-3, largest(made[false]))
    local exact = ylm.light_field(4, lamps, occupied, { dtype = "float" })
    local on, off = errors(made[true]:sample(occupied), exact), errors(made[false]:sample(occupied), exact)
    assert.is_true(on[#on] <= off[#off], ("largest error %g, %g without"):format(on[#on], off[#off]))
    for _, part in ipairs { 0.5, 0.9, 0.99 } do
      assert.is_true(quantile(on, part) <= quantile(off, part) * 1.0001)
    end
    local sum_on, sum_off = 0, 0
    for i = 1, #on do sum_on, sum_off = sum_on + on[i], sum_off + off[i] end
    assert.is_true(sum_on <= sum_off)
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

  it("samples the same in any order of the points", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 6, threshold = 2 }, lamps,
      { occupied = occupied })
    local forward = grid:sample(occupied)
    for i = 1, #occupied, 97 do
      assert.equal(0, core.array_distance(forward[i], grid:sample(occupied[i])))
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
    local few = shading_points(400, SEED)
    local n, leaves = by_the_book(5, 4, few)
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, metric = "relative", threshold = 4 },
      lamps,
      { occupied = few })
    assert.equal(n, grid.stats.points)
    assert.equal(leaves, grid.stats.leaves)
  end)

  it("samples alike with every kernel set", function()
    local script = os.tmpname()
    local file = assert(io.open(script, "w"))
    file:write([[
local ylm, core = require "ylm", require "ylm.c.core"
local lamp = ylm.sphere_light { at = { 1.5, 2, 0.5 }, radius = 0.5 }
local p, n = {}, 0
for i = 0, 9 do for j = 0, 9 do n = n + 1 p[n] = { i / 5 - 0.9, 0.1 * j - 0.4, (i * j % 7) / 4 - 0.8 } end end
for _, o in ipairs { { 4, "rgb" }, { 2, "luminance" }, { 7, "rgb" }, { 0, "luminance" } } do
  local g = ylm.bake(ylm.uniform_grid { bounds = { {-1,-1,-1}, {1,1,1} }, cells = 3, lmax = o[1], channels = o[2] },
    lamp)
  for _, how in ipairs { "hermite", "taylor", "linear" } do
    local c, dc = g:sample(p, { interpolation = how, derivatives = 1, dtype = "double" })
    for _, a in ipairs { c, dc } do
      a = a:reshape { #a * math.floor((function() local k = 1 for i = 2,
        #a.shape do k = k * a.shape[i] end return k end)()) }
      local s, w = 0, 0
      for i = 1, #a do s, w = s + a[i] * math.cos(i), w + a[i] * a[i] end
      print(("%.4e %.4e"):format(s / math.sqrt(w), w))
    end
  end
end
]])
    file:close()
    local want
    for _, isa in ipairs(ylm.info().kernels) do
      local pipe = assert(io.popen(("YLM_ISA=%s %s %s"):format(isa, os.getenv("YLM_LUA") or "lua", script)))
      local got = {}
      for word in pipe:read("*a"):gmatch("%S+") do got[#got + 1] = assert(tonumber(word), word) end
      pipe:close()
      assert.equal(48, #got, isa)
      want = want or got
      for i = 1, #want do assert.near(want[i], got[i], 2e-4 * (1 + math.abs(want[i])), isa .. " " .. i) end
    end
    os.remove(script)
  end)

  it("is a light field itself", function()
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 3 }, lamp)
    local p = points_in(50, box[1], box[2], SEED)
    local c, dc = grid:sample(p, { derivatives = 1, dtype = "double" })
    local L, dL, _, report = ylm.light_field(3, grid, p, { derivatives = 1, dtype = "double", metric = "luminance" })
    assert.equal(0, core.array_distance(c, L))
    assert.equal(0, core.array_distance(dc, dL))
    assert.is_true(report.lambda[1] > 0 and report.norm[1] > 0)
    local grey = ylm.light_field(1, grid, p, { channels = "luminance", dtype = "double" })
    assert.near(0.2126 * L:get(1, 1, 2) + 0.7152 * L:get(1, 2, 2) + 0.0722 * L:get(1, 3, 2), grey:get(1, 1, 2), 1e-6)
    local again = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 3 }, grid)
    local d, _, norm = core.array_distance(grid:points().value, again:points().value)
    assert.is_true(d < 1e-5 * norm)
  end)
end)

describe("grid files", function()
  local function scratch(name) return os.tmpname() .. name end
  local grid_file = require "ylm.grid"

  local function same(a, b)
    for _, pair in ipairs { { a:points(), b:points() }, { a:cells(), b:cells() } } do
      for name, array in pairs(pair[1]) do
        if name ~= "error" and name ~= "residual" then assert.equal(0, (core.array_distance(array, pair[2][name])),
          name) end
      end
    end
    assert.equal(0, core.array_distance(a:sample(occupied), b:sample(occupied)))
    -- where the time of a bake went is known to the grid that was baked only
    local lost = { bytes = true, occupancy_seconds = true, lattice_seconds = true, residual_seconds = true,
      continuity_seconds = true }
    for key, value in pairs(a.stats) do
      if not lost[key] and value == value then assert.equal(value, b.stats[key], key) end
    end
  end

  local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.02 }, lamps,
    { occupied = occupied })

  it("keep everything, in either byte order", function()
    local path = scratch ".ylm"
    for _, order in ipairs { "native", "swapped" } do
      assert.is_true(grid:save(path, { byte_order = order }))
      same(grid, assert(grid_file.load(path)))
    end
    local file = assert(io.open(path, "rb"))
    assert.equal(grid_file.magic, file:read(8))
    file:close()
    os.remove(path)
    local uniform = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 3, 2, 5 }, lmax = 1 }, lamp,
      { occupied = occupied })
    assert.is_true(uniform:save(path))
    same(uniform, assert(grid_file.load(path)))
    os.remove(path)
  end)

  it("are written for ParaView too", function()
    local path = scratch ".vtu"
    assert.is_true(grid:save(path))
    local file = assert(io.open(path, "rb"))
    assert.is_truthy(file:read(200):find("UnstructuredGrid", 1, true))
    file:close()
    os.remove(path)
    assert.is_nil((grid:save "/no/such/folder/grid.vtu"))
  end)

  it("are what ylm.load knows by content", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    same(grid, assert(ylm.load(path)))
    os.remove(path)
  end)

  it("refuse every truncation and every flipped bit", function()
    for _, swapped in ipairs { false, true } do
      local small = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 0, channels = "luminance" }, lamp)
      assert.equal(0, core.grid_accepted_damage(core.grid_encode(small, swapped)))
    end
    local octree = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 1, threshold = 0,
      channels = "luminance" }, lamp)
    assert.equal(0, core.grid_accepted_damage(core.grid_encode(octree, false)))
  end)

  it("refuse what is no grid, in words", function()
    local path = scratch ".ylm"
    local file = assert(io.open(path, "wb"))
    file:write("P6 3 3 255 something else")
    file:close()
    local g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EFORMAT", code)
    assert.is_true(message:find("not a grid file", 1, true) ~= nil)
    os.remove(path)
    g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_true(message:find(path, 1, true) ~= nil)
    g, message, code = grid_file.load("/")
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_string(message)
  end)

  it("keep the old file where the new one cannot be written", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    local ok, message, code = grid:save("/proc/ylm.ylm")
    assert.is_nil(ok)
    assert.is_string(message)
    assert.equal("EIO", code)
    assert(grid_file.load(path))
    os.remove(path)
  end)
end)

