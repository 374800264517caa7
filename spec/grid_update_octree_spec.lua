--- grid:update: the octree that an update leaves, its corners in lights and its continuity.

local core = require "ylm.c.core"
local light = require "ylm.light"
local grids = require "spec.support.grids"
local long = require "spec.support.long"
local moving = require "spec.support.moving"

local SEED = moving.seed
local bake, update, lamp, lamps = moving.bake, moving.update, moving.lamp, moving.lamps
local worst, difference = moving.worst, moving.difference
local descriptions, everywhere, occupied, faces = moving.descriptions, moving.everywhere, moving.occupied, moving.faces

describe("the octree after grid:update", function()
  it("fills corners that a lamp moves over, and takes them back behind it", function()
    for i, d in ipairs(descriptions) do
      local seen, grid = 0, bake(d, { lamp(-0.9, 0, 0.01, 0.22), lamp(0.3, 0.8, 0) }, true)
      for k = 1, i == 2 and 12 or long(6, 12) do
        local lights = { lamp(-0.9 + 0.15 * k, 0.002 * k, 0.01, 0.22), lamp(0.3, 0.8, 0) }
        update(grid, lights, { tolerance = 0 })
        local fresh = bake(d, lights)
        seen = seen + grid.stats.invalid
        if not d.tolerance then
          assert.equal(fresh.stats.invalid, grid.stats.invalid)
          assert.is_true(worst(grid:sample(everywhere), fresh:sample(everywhere)) < 2e-5)
        end
      end
      assert.is_true(seen > 0, d.name)
    end
  end)

  it("splits where a lamp comes and merges where it has gone", function()
    local d = descriptions[2]
    local function lights(x) return { lamp(x, 0.08, 0.3), lamp(0, 3, 0, 0.5) } end
    local grid = bake(d, lights(-0.7), true)
    local function levels()
      return grid:locate { -0.7, 0.013, 0.3 }.level, grid:locate { 0.7, 0.013, 0.3 }.level
    end
    local left, right = levels()
    assert.is_true(left > right)
    local report = update(grid, lights(0.7))
    assert.is_true(report.added > 0 and report.removed > 0)
    left, right = levels()
    assert.is_true(left < right)
    assert.equal(bake(d, lights(0.7)).stats.leaves, grid.stats.leaves)
  end)

  it("has no jumps across faces afterwards", function()
    local d = descriptions[2]
    local grid = bake(d, lamps(0), true)
    for k = 1, 5 do update(grid, lamps(0.2 * k)) end
    local low, high = grids.across(grid, 4000, SEED)
    local e = worst(grid:sample(low), grid:sample(high))
    assert.is_true(e <= 2e-6, e)
  end)

  it("makes continuity anew only around points that came or went: what it is when made anew everywhere", function()
    local changes = 0
    for _, d in ipairs { descriptions[2], descriptions[4], descriptions[5] } do
      local near, whole = bake(d, lamps(0), true), bake(d, lamps(0), true)
      for k = 1, long(5, 12) do
        local lights = lamps(0.11 * k + (k % 4 == 0 and 1 or 0))
        local report = update(near, lights)
        local field = light.field(1, "update", lights)
        assert(core.grid_update(whole, field, -1, 1, nil, true))
        changes = changes + report.added + report.removed
        assert.equal(whole.stats.points, near.stats.points)
        assert.equal(whole.stats.interpolated, near.stats.interpolated)
        assert.equal(whole.stats.continuity, near.stats.continuity)
        for _, p in ipairs { everywhere, occupied, faces } do
          local a, da = near:sample(p, { derivatives = 1 })
          local b, db = whole:sample(p, { derivatives = 1 })
          assert.equal(0, (core.array_distance(a, b)), d.name)
          assert.equal(0, (core.array_distance(da, db)), d.name)
        end
      end
    end
    assert.is_true(changes > long(400, 1000), changes) -- else nothing has been tested
  end)

  it("gives the same whatever the number of threads", function()
    for _, d in ipairs(descriptions) do
      local made = {}
      for threads = 1, 3 do
        made[threads] = bake(d, lamps(0), true)
        for k = 1, 6 do update(made[threads], lamps(0.1 * k), { threads = threads }) end
      end
      assert.equal(0, difference(made[1], made[2]))
      assert.equal(0, difference(made[1], made[3]))
    end
  end)
end)
