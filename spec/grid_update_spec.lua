--- grid:update: grids that follow moving lights, judged by fresh bakes of the same lights.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local long = require "spec.support.long"
local moving = require "spec.support.moving"
local random = require "spec.support.random".minimal

local SEED = moving.seed
local bake, update, lamp, lamps = moving.bake, moving.update, moving.lamp, moving.lamps
local canopy, exact, worst, difference = moving.canopy, moving.exact, moving.worst, moving.difference
local descriptions, everywhere, occupied = moving.descriptions, moving.everywhere, moving.occupied
local errors, quantile = grids.errors, grids.quantile

describe("grid:update", function()
  describe("without a tolerance of its own is a fresh bake:", function()
    for _, d in ipairs(descriptions) do
      it("grid " .. d.name, function()
        local grid = bake(d, lamps(0), true)
        for k = 1, 8 do
          local now = lamps(0.15 * k)
          local report = assert(update(grid, now, { tolerance = 0 }))
          assert.equal(1, report.lights)
          assert.equal(k, report.updates)
          assert.equal(0, report.skipped)
          local fresh = bake(d, now)
          if d.tolerance then
            local e = quantile(errors(grid:sample(occupied), exact(d, now)), 0.99)
            assert.is_true(e <= d.tolerance, e)
          else
            assert.equal(fresh.stats.points, grid.stats.points)
            assert.equal(fresh.stats.leaves, grid.stats.leaves)
            assert.equal(fresh.stats.invalid, grid.stats.invalid)
            assert.equal(fresh.stats.interpolated, grid.stats.interpolated)
            local e = worst(grid:sample(everywhere), fresh:sample(everywhere))
            assert.is_true(e < 2e-5, e)
          end
        end
      end)
    end
  end)

  it("leaves alone what changes less than the tolerance, and is within it", function()
    local lights, n = canopy(400), 400
    for _, d in ipairs(descriptions) do
      local grid = bake(d, lights, true)
      local tolerance, pairs_of_bake = (d.tolerance or 0.008) / 8, grid.stats.pairs
      local skipped, pairs = 0, 0
      for k = 1, 10 do
        lights[17] = lamp(0.3 + 0.03 * k, 0.6 - 0.02 * k, 0.1, 0.02, { 3, 4, 4 })
        local report = update(grid, lights)
        skipped, pairs = skipped + report.skipped, pairs + report.pairs
      end
      assert.is_true(skipped > 0, d.name)
      assert.is_true(pairs / 10 < 0.5 * pairs_of_bake, ("%s: %g of %g"):format(d.name, pairs / 10, pairs_of_bake))
      if d.tolerance then
        assert.is_true(quantile(errors(grid:sample(occupied), exact(d, lights)), 0.99) <= d.tolerance)
      else
        local e = errors(grid:sample(occupied), bake(d, lights):sample(occupied))
        assert.is_true(quantile(e, 0.99) <= tolerance, ("%s: %g"):format(d.name, quantile(e, 0.99)))
      end
    end
    assert.equal(n, #lights)
  end)

  it("does not drift where a light creeps, each step below the tolerance", function()
    local d = descriptions[2]
    local lights = canopy(400)
    local grid, largest = bake(d, lights, true), 0
    for k = 1, 150 do
      lights[40] = lamp(-0.4 + 0.004 * k, 0.5, 0.2, 0.02, { 3, 4, 4 })
      update(grid, lights)
      if k % 25 == 0 then
        largest = math.max(largest, quantile(errors(grid:sample(occupied), bake(d, lights):sample(occupied)), 0.99))
      end
    end
    assert.is_true(largest <= 1e-3, largest)
  end)

  for _, d in ipairs { descriptions[1], descriptions[2], descriptions[5] } do
    local updates = d.tolerance and long(75, 1000) or long(400, 1000)
    it(("is right after %d updates: grid %s"):format(updates, d.name), function()
      local r, lights = random(SEED), canopy(60)
      local grid = bake(d, lights, true)
      for k = 1, updates do
        local kind, i = r(), math.floor(r() * #lights) + 1
        if kind < 0.80 then -- a step of a walk, some of them far, low and near the floor
          local x = lights[i % 5 + 1]
          lights[i % 5 + 1] = lamp(math.max(-1.2, math.min(1.2, x.at[1] + 0.2 * (r() - 0.5))), 0.05 + 0.8 * r(),
            math.max(-1.2, math.min(1.2, x.at[3] + 0.2 * (r() - 0.5))), 0.02, { 3, 2, 4 })
        elseif kind < 0.88 then -- a lamp flares up
          local x = lights[i]
          lights[i] = lamp(x.at[1], x.at[2], x.at[3], x.radius, { 40 * r(), 3 * r(), 3 })
        elseif kind < 0.94 then
          table.insert(lights, i, lamp(2 * r() - 1, 0.7, 2 * r() - 1, 0.03))
        elseif #lights > 40 then
          table.remove(lights, i)
        end
        local report = assert(update(grid, lights))
        assert.is_true(report.lights <= 1, k .. ": " .. report.lights)
        assert.is_false(report.rebaked)
      end
      if d.tolerance then
        local e = quantile(errors(grid:sample(occupied), exact(d, lights)), 0.99)
        assert.is_true(e <= d.tolerance, e)
      else
        local e = errors(grid:sample(occupied), bake(d, lights):sample(occupied))
        assert.is_true(quantile(e, 0.99) <= 1e-3, quantile(e, 0.99))
        update(grid, lights) -- nothing changed: nothing happens
        assert.equal(0, grid.stats.update.pairs)
      end
    end)
  end

  it("knows lights by their place, else by their content", function()
    local lights = lamps(0)
    local grid = bake(descriptions[2], lights, true)
    assert.equal(0, update(grid, lights).lights)
    assert.equal(0, update(grid, { lights[6], lights[5], lights[4], lights[3], lights[2], lights[1] }).lights)
    table.insert(lights, 1, lamp(0.4, 0.3, 0.2))
    assert.equal(1, update(grid, lights).lights)
    table.remove(lights, 3)
    assert.equal(1, update(grid, lights).lights)
    lights[2] = lamp(0, 0.4, 0)
    local report = update(grid, lights, { tolerance = 0 })
    assert.equal(1, report.lights)
    assert.equal(5, report.updates)
    assert.is_true(worst(grid:sample(everywhere), bake(descriptions[2], lights):sample(everywhere)) < 2e-5)
    assert.equal(report.pairs, grid.stats.update.pairs)
    assert.is_nil(bake(descriptions[2], lights, true).stats.update)
  end)

  it("goes dark and comes back", function()
    for _, d in ipairs(descriptions) do
      local lights = lamps(1)
      local grid = bake(d, { lights[1] }, true)
      update(grid, lamp(0, 5, 0, 0.1, { 0, 0, 0 }), { tolerance = 0 })
      local _, dark = core.array_distance(grid:sample(occupied), ylm.zeros(grid:sample(occupied).shape, "float"))
      assert.is_true(dark < 1e-4, dark)
      update(grid, lights, { tolerance = 0 })
      if not d.tolerance then
        assert.is_true(worst(grid:sample(everywhere), bake(d, lights):sample(everywhere)) < 2e-5)
      end
    end
  end)

  it("bakes anew where most lights change", function()
    local lights = canopy(30)
    local grid = bake(descriptions[5], lights, true)
    for k = 1, 20 do lights[k] = lamp(0.05 * k, 0.5, -0.02 * k, 0.02) end
    local report = update(grid, lights)
    assert.is_true(report.rebaked)
    assert.equal(0, difference(grid, bake(descriptions[5], lights)))
    lights[3] = lamp(0.1, 0.3, 0.2, 0.02)
    report = update(grid, lights)
    assert.is_false(report.rebaked)
    assert.equal(2, report.updates)
  end)
end)
