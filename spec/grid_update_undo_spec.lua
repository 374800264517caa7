--- grid:update: what is taken back, refused, saved and counted.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local moving = require "spec.support.moving"

local bake, update, lamp, lamps = moving.bake, moving.update, moving.lamp, moving.lamps
local worst, difference = moving.worst, moving.difference
local descriptions, everywhere, occupied = moving.descriptions, moving.everywhere, moving.occupied
local box = grids.box

describe("grid:update", function()
  it("leaves the grid as it was when it is cancelled or fails", function()
    for _, d in ipairs(descriptions) do
      local grid, twin = bake(d, lamps(0), true), bake(d, lamps(0), true)
      for k = 1, 3 do
        update(grid, lamps(0.1 * k))
        update(twin, lamps(0.1 * k))
      end
      for stop = 1, 6 do
        local calls = 0
        local ok, message, code = update(grid, lamps(0.7), { progress = function()
          calls = calls + 1
          return calls < stop
        end })
        if ok == nil then
          assert.equal("cancelled", message)
          assert.equal("ECANCELLED", code)
          assert.equal(0, difference(grid, twin))
          assert.equal(3, grid.stats.update.updates)
        else
          update(twin, lamps(0.7))
          assert.equal(0, difference(grid, twin))
          update(grid, lamps(0.3))
          update(twin, lamps(0.3))
        end
      end
      assert.has_error(function() update(grid, lamps(0.8), { progress = function() error "mine" end }) end)
      update(grid, lamps(0.9))
      update(twin, lamps(0.9))
      assert.is_true(worst(grid:sample(everywhere), twin:sample(everywhere)) < 1e-3)
    end
    local limited = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 6, threshold = 2, dynamic = true }
    local grid = ylm.bake(limited, { lamp(0, 5, 0, 0.5) }, { occupied = occupied, max_points = 300 })
    local before = grid:sample(everywhere)
    local ok, message, code = update(grid, { lamp(0, 0.1, 0), lamp(0, 5, 0, 0.5) })
    assert.is_nil(ok)
    assert.equal("ELIMIT", code)
    assert.truthy(message:find "300 points")
    assert.equal(0, (core.array_distance(before, grid:sample(everywhere))))
  end)

  it("cannot be disturbed from its own progress function", function()
    local grid, said = bake(descriptions[2], lamps(0), true), {}
    update(grid, lamps(0.4), { progress = function()
      for _, f in ipairs { function() return grid:sample { { 0, 0, 0 } } end, function() return grid:close() end,
        function() return update(grid, lamps(0.2)) end, function() return grid.stats end, function() return grid.lmax end } do
        local _, message = pcall(f)
        said[#said + 1] = tostring(message)
      end
      assert.equal("ylm.grid (being updated)", tostring(grid))
    end })
    assert.is_true(#said >= 3)
    for _, message in ipairs(said) do
      assert.truthy(message:find "^[^:]*grid_update_undo_spec.lua:%d+: .*being updated" or message:find "in use", message)
    end
    assert.is_true(worst(grid:sample(everywhere), bake(descriptions[2], lamps(0.4)):sample(everywhere)) < 1e-3)
  end)

  it("is not saved: a loaded grid does not follow lights", function()
    local name = os.tmpname() .. ".ylm"
    local grid = bake(descriptions[2], lamps(0), true)
    update(grid, lamps(0.3))
    assert(grid:save(name))
    local loaded = assert(ylm.load(name))
    os.remove(name)
    assert.is_true(grid.dynamic)
    assert.is_false(loaded.dynamic)
    assert.equal(0, (core.array_distance(grid:sample(everywhere), loaded:sample(everywhere))))
    assert.error_matches(function() loaded:update(lamps(0.4), { octree = "follow" }) end, "which files do not hold")
  end)

  it("counts what it keeps among the grid's bytes", function()
    local d = descriptions[2]
    assert.is_true(bake(d, lamps(0), true).stats.bytes > bake(d, lamps(0)).stats.bytes * 1.2)
  end)
end)
