--- grid:sample: exactness, order and continuity of the interpolation.

local core = require "ylm.c.core"
local ylm = require "ylm"
local by_kernels = require "spec.support.by_kernels"
local grids = require "spec.support.grids"
local points_in = require "spec.support.random".points_in

local SEED, box, lamp, lamps, occupied = grids.seed, grids.box, grids.lamp, grids.lamps, grids.occupied
local errors, quantile, analytic = grids.errors, grids.quantile, grids.analytic

--- Largest difference between samples and f.
local function worst(grid, points, f, options)
  local c, most = grid:sample(points, options), 0
  for i = 1, #points do
    local v = f(points:get(i, 1), points:get(i, 2), points:get(i, 3))
    most = math.max(most, math.abs(c:get(i, 1, 1) - v))
  end
  return most
end

describe("grid:sample: properties", function()
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

  it("is continuous across levels, and no less accurate for it", function()
    local made = {}
    for _, on in ipairs { true, false } do
      made[on] = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, metric = "relative", threshold = 3,
        continuous = on }, lamps, { occupied = occupied })
    end
    assert.equal(made[true].stats.points, made[false].stats.points)
    local low, high = grids.across(made[true], 10000, SEED)
    assert.equal(10000, #low)
    local function largest(grid)
      local a, b = grid:sample(low), grid:sample(high)
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

  it("samples the same in any order of the points", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 6, threshold = 2 }, lamps,
      { occupied = occupied })
    local forward = grid:sample(occupied)
    for i = 1, #occupied, 97 do
      assert.equal(0, core.array_distance(forward[i], grid:sample(occupied[i])))
    end
  end)

  it("says with flags = true which points were outside, which unbaked", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 1, depth = 5, threshold = 2 }, lamps,
      { occupied = occupied })
    local points = points_in(3000, { -1.2, -1.2, -1.2 }, { 1.2, 1.2, 1.2 }, SEED)
    local _, _, report, flags = grid:sample(points, { flags = true })
    local outside, unbaked = 0, 0
    for i = 1, #points do
      local out, without = flags[i] % 2, math.floor(flags[i] / 2)
      local alone = select(3, grid:sample(points[i]))
      assert(out == alone.outside and without == alone.unbaked, i)
      outside, unbaked = outside + out, unbaked + without
    end
    assert(outside == report.outside and unbaked == report.unbaked and outside > 500 and unbaked > 500)
    local out = { nil, ylm.zeros({ 3000, 3, 4, 3 }), ylm.zeros { 3000 } }
    local _, _, _, again = grid:sample(points, { flags = true, threads = 2, derivatives = 1, dtype = "double", out = out })
    assert.equal(out[3], again)
    assert.equal(0, core.array_distance(again, ylm.array(flags, "double")))
    _, _, _, again = grid:sample(points, { flags = true, threads = 1, out = { [2] = ylm.zeros({ 3000 }, "float") } })
    assert.equal(0, core.array_distance(again, flags))
    assert.equal(3, (select(4, grid:sample({ 5, -0.9, 0.9 }, { flags = true }))))
    assert.equal(0, (select(4, grid:sample(occupied[1], { flags = true }))))
    assert.is_nil((select(4, grid:sample(points))))
  end)
end)

describe("grid:sample: agreement", function()
  it("samples alike with every kernel set", function()
    local program = [[
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
]]
    local want
    for _, isa in ipairs(ylm.info().kernels) do
      local got = by_kernels(isa, program)
      assert.equal(48, #got, isa)
      want = want or got
      for i = 1, #want do assert.near(want[i], got[i], 2e-4 * (1 + math.abs(want[i])), isa .. " " .. i) end
    end
  end)
end)
