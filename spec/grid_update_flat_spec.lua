--- grid:update of flat lights: polygons, disks, images, alone and beside spheres.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local long = require "spec.support.long"
local moving = require "spec.support.moving"
local random = require "spec.support.random".minimal

local bake, update, lamp, exact = moving.bake, moving.update, moving.lamp, moving.exact
local worst, difference = moving.worst, moving.difference
local descriptions, everywhere, occupied = moving.descriptions, moving.everywhere, moving.occupied
local errors, quantile, box = grids.errors, grids.quantile, grids.box

--- A rectangle about a centre, turned about z and x; `o` has more fields of polygon_light.
local function panel(x, y, z, size, turn, tilt, o)
  local c, s, ct, st = math.cos(turn or 0), math.sin(turn or 0), math.cos(tilt or 0), math.sin(tilt or 0)
  local function corner(u, v)
    local px, py, pz = u * c, u * s, v
    return { x + px, y + py * ct - pz * st, z + py * st + pz * ct }
  end
  local light = { vertices = { corner(-size, -size), corner(size, -size), corner(size, size), corner(-size, size) },
    radiance = { 10, 8, 6 } }
  for name, value in pairs(o or {}) do light[name] = value end
  return ylm.polygon_light(light)
end

local function disk(x, y, z, radius, o)
  local light = { at = { x, y, z }, normal = { 0.3, -1, 0.2 }, radius = radius, radiance = { 3, 9, 20 } }
  for name, value in pairs(o or {}) do light[name] = value end
  return ylm.disk_light(light)
end

--- Lights of every kind: some that stand, and some that move by the time t.
local kinds = {
  { name = "polygons", make = function(t)
    return { panel(-0.5, 0.6, 0.4, 0.1), panel(0.5 * math.cos(t), 0.25, 0.5 * math.sin(t), 0.06, 0.3, 0.2),
      panel(0.2, 1.4, 0, 0.3, 3 * t, t), panel(0.6, 0.9, -0.3, 0.05) }
  end },
  { name = "disks", make = function(t)
    return { disk(-0.5, 0.6, 0.4, 0.1), disk(0.5 * math.cos(t), 0.2, 0.5 * math.sin(t), 0.06), disk(0.2, 1.4, 0, 0.4) }
  end },
  { name = "flat lights by spheres", make = function(t)
    local o = { method = "sphere" }
    return { panel(-0.5, 0.6, 0.4, 0.1, 0, 0, o), panel(0.5 * math.cos(t), 0.4, 0.5 * math.sin(t), 0.06, 0.3, 0.2, o),
      disk(0.2, 1.4 - 0.1 * t, 0, 0.2, o) }
  end },
  { name = "flat lights below a horizon", make = function(t)
    local o = { horizon = { 0, 1, 0 } }
    return { panel(-0.5, 0.6, 0.4, 0.1, 0, 1.2, o), panel(0.5 * math.cos(t), 0.05, 0.5 * math.sin(t), 0.06, 0.3, 1, o),
      disk(0.2, 0.9, 0, 0.2, { horizon = { 0, 1, 0.2 + 0.1 * t } }) }
  end },
  { name = "lights of all kinds", make = function(t)
    local a, b = math.cos(t), math.sin(t)
    return { lamp(-0.5, 0.4, 0.4), panel(0.5 * a, 0.3, 0.5 * b, 0.06, t), disk(0.4 * b, 0.8, 0.4 * a, 0.1),
      lamp(0.6, 0.5 + 0.1 * b, -0.3),
      panel(0.2, 1.2, 0, 0.2, 0.4, 1, { method = "sphere" }), panel(-0.6, 0.7, 0.1, 0.1, 1, 1.3, { horizon = { 0, 1, 0 } }) }
  end },
}

--- Panels under the ceiling, so that one of them is little of the light.
local function ceiling(n, o)
  local all = {}
  for k = 1, n do
    local r, a = 1.5 * math.sqrt(k / n), 2.4 * k
    local more = { radiance = { 3, 2 + k % 3, 4 } }
    for name, value in pairs(o or {}) do more[name] = value end
    all[k] = panel(r * math.cos(a), 0.8, r * math.sin(a), 0.02, 0.2 * (k % 5), 0.3 * (k % 3), more)
  end
  return all
end

describe("grid:update of flat lights", function()
  for _, kind in ipairs(kinds) do
    it("is a fresh bake without a tolerance of its own: " .. kind.name, function()
      for i, d in ipairs(descriptions) do
        if i < 3 or i == 5 or kind == kinds[#kinds] then
          local grid = bake(d, kind.make(0), true)
          for k = 1, long(kind == kinds[#kinds] and 2 or 1, 3) do
            local now = kind.make(0.2 * k)
            local report = assert(update(grid, now, { tolerance = 0 }))
            assert.is_true(report.lights > 0 and not report.rebaked and report.skipped == 0)
            if d.tolerance then -- 256 points decide: one time in four they let 1.1 % of points pass, not 1 %
              local e = quantile(errors(grid:sample(occupied), exact(d, now)), 0.985)
              assert.is_true(e <= d.tolerance, e)
            else
              local fresh = bake(d, now)
              assert.equal(fresh.stats.points, grid.stats.points)
              assert.equal(fresh.stats.leaves, grid.stats.leaves)
              assert.equal(fresh.stats.invalid, grid.stats.invalid)
              local e = worst(grid:sample(everywhere), fresh:sample(everywhere))
              assert.is_true(e < 2e-5, ("%s: %g"):format(d.name, e))
            end
          end
        end
      end
    end)
  end

  it("is within its tolerance of the same voxels baked anew, wherever a light goes and however it turns", function()
    local d, updates = descriptions[1], long(8, 30)
    for _, o in ipairs { {}, { method = "sphere" }, { horizon = { 0, 1, 0 } } } do
      local r, skipped, lights = random(moving.seed), 0, ceiling(250, o)
      local tolerance = o.horizon and 0.1 or 0.02 -- of what a horizon cuts little is known
      local grid = bake(d, lights, true)
      for k = 1, updates do
        local i = math.floor(4 * r()) + 1
        local x, y, z, turn, tilt = 2 * r() - 1, 0.05 + 0.9 * r(), 2 * r() - 1, 6 * r(), 6 * r()
        local old = lights[i].vertices
        if k % 2 == 0 then -- a small step, through the plane of points too
          x, y, z = old[1][1] + 0.1 * (r() - 0.5), old[1][2] + 0.1 * (r() - 0.5), old[1][3] + 0.1 * (r() - 0.5)
        end
        local more = { radiance = { 3 * r(), 2, 4 } }
        for name, value in pairs(o) do more[name] = value end
        lights[i] = panel(x, y, z, 0.02, k % 4 == 0 and 0 or turn, k % 4 == 0 and 0 or tilt, more)
        skipped = skipped + update(grid, lights, { tolerance = tolerance }).skipped
        local e = worst(grid:sample(occupied), bake(d, lights):sample(occupied))
        assert.is_true(e <= tolerance, ("%s, update %d: %g"):format(o.method or o.horizon and "horizon" or "exact", k, e))
      end
      assert.is_true(skipped > long(0, 50), skipped)
    end
  end)

  it("asks only for what changed, of one of many panels", function()
    local d = descriptions[2]
    local lights, skipped = ceiling(200), 0
    local grid = bake(d, lights, true)
    local pairs_of_bake = grid.stats.pairs
    for k = 1, 6 do
      lights[17] = panel(0.3 + 0.01 * k, 0.6, 0.1, 0.02, 0.2, 0.1)
      local report = update(grid, lights)
      assert.equal(1, report.lights)
      assert.is_true(report.pairs < 0.25 * pairs_of_bake, report.pairs / pairs_of_bake)
      skipped = skipped + report.skipped
    end
    assert.is_true(skipped > 0)
    local e = errors(grid:sample(occupied), bake(d, lights):sample(occupied))
    assert.is_true(quantile(e, 0.99) <= 1e-3, quantile(e, 0.99))
  end)

  it("knows that points below a large panel are not near it", function()
    local d = descriptions[2]
    local function lights(x) return { panel(x, 0.95, 0, 0.6, 0.01, 0.02), lamp(0.5, 0.6, 0) } end
    local grid = bake(d, lights(0), true)
    local report = update(grid, lights(0.05))
    assert.is_true(report.points > 0.5 * grid.stats.points, report.points)
    assert.is_true(report.exact < 0.1 * report.points, report.exact .. " of " .. report.points)
    assert.is_true(worst(grid:sample(occupied), bake(d, lights(0.05)):sample(occupied)) < 1e-3)
  end)

  it("does not drift where a panel creeps, each step below the tolerance", function()
    local d, lights = descriptions[2], ceiling(100)
    local grid = bake(d, lights, true)
    for k = 1, 60 do
      lights[40] = panel(-0.4 + 0.005 * k, 0.5, 0.2, 0.02, 0.3, 0.4)
      update(grid, lights)
    end
    local e = quantile(errors(grid:sample(occupied), bake(d, lights):sample(occupied)), 0.99)
    assert.is_true(e <= 1e-3, e)
  end)

  local small = {
    { name = "uniform", make = function(dynamic)
      return ylm.uniform_grid { bounds = box, cells = 6, lmax = 3, dynamic = dynamic }
    end },
    { name = "by a threshold", make = function(dynamic)
      return ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, threshold = 5, dynamic = dynamic }
    end },
    { name = "by a tolerance", tolerance = 0.02, updates = long(20, 1000), make = function(dynamic)
      return ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.02, dynamic = dynamic }
    end },
  }
  for _, d in ipairs(small) do
    local updates = d.updates or long(150, 1000)
    it(("is right after %d updates of all kinds of lights: grid %s"):format(updates, d.name), function()
      local r, lights = random(moving.seed), ceiling(24)
      local kept = { {}, { method = "sphere" }, { horizon = { 0, 1, 0 } } }
      for _ = 1, 12 do lights[#lights + 1] = lamp(2 * r() - 1, 0.7, 2 * r() - 1, 0.03) end
      local function any()
        local x, y, z = 2.4 * r() - 1.2, 0.15 + 0.8 * r(), 2.4 * r() - 1.2
        local kind, o = r(), kept[math.floor(3 * r()) + 1]
        if kind < 0.3 then return lamp(x, y, z, 0.02, { 3, 2, 4 }) end
        if kind < 0.5 then return disk(x, y, z, 0.03, o) end
        return panel(x, y, z, 0.03, 6 * r(), 6 * r(), o)
      end
      local grid = bake(d, lights, true)
      for k = 1, updates do
        local kind, i = r(), math.floor(r() * 5) + 1
        if kind < 0.85 then lights[i] = any()
        elseif kind < 0.93 and #lights < 36 then table.insert(lights, math.floor(r() * #lights) + 1, any())
        elseif #lights > 30 then table.remove(lights, math.floor(r() * #lights) + 1) end
        local report = assert(update(grid, lights))
        assert.is_true(report.lights <= 1 and not report.rebaked, k)
      end
      if d.tolerance then
        local e = quantile(errors(grid:sample(occupied), exact(d, lights)), 0.99)
        assert.is_true(e <= d.tolerance, e)
      else
        local e = quantile(errors(grid:sample(occupied), bake(d, lights):sample(occupied)), 0.99)
        assert.is_true(e <= 1e-3, e)
        assert.equal(0, update(grid, lights).pairs)
      end
    end)
  end

  it("knows lights by their place, else by their content, and a light by all that it is made of", function()
    local lights = { panel(0, 0.5, 0, 0.1), lamp(0.3, 0.8, 0), disk(-0.4, 0.7, 0.2, 0.1), panel(0.5, 0.6, 0, 0.1) }
    local grid = bake(descriptions[1], lights, true)
    assert.equal(0, update(grid, lights).lights)
    assert.equal(0, update(grid, { lights[4], lights[3], lights[2], lights[1] }).lights)
    assert.equal(1, update(grid, { lights[4], lights[3], lights[2] }).lights)
    assert.equal(1, update(grid, { panel(0.1, 0.5, 0, 0.1), lights[4], lights[3], lights[2] }).lights)
    for _, o in ipairs { { radiance = { 10, 8, 7 } }, { method = "sphere" }, { horizon = { 0, 1, 0 } },
      { horizon = { 0, 1, 1 } } } do
      local report = update(grid, { panel(0.1, 0.5, 0, 0.1, 0, 0, o), lights[4], lights[3], lights[2] }, { tolerance = 0 })
      assert.equal(1, report.lights)
      assert.is_true(report.points > 0)
    end
    local now = { lamp(0.1, 0.5, 0, 0.1), lights[4], lights[3], lights[2] }
    update(grid, now, { tolerance = 0 })
    assert.is_true(worst(grid:sample(everywhere), bake(descriptions[1], now):sample(everywhere)) < 2e-5)
  end)

  for _, method in ipairs { "exact", "spheres" } do
    it("finds the parts of an image that changed: method " .. method, function()
      local image = {}
      for y = 1, 8 do
        image[y] = {}
        for x = 1, 8 do image[y][x] = { 1 + (3 * x + 5 * y) % 7, 1 + x, 1 + y } end
      end
      local function screen()
        return { ylm.textured_light { corner = { -0.8, 0.5, -0.9 }, u = { 1.6, 0, 0 }, v = { 0, 0.9, 0 }, image = image,
          method = method }, lamp(0.3, 0.9, 0.5) }
      end
      local d = descriptions[2]
      local grid = bake(d, screen(), true)
      assert.equal(0, update(grid, screen()).lights)
      image[3][5] = { 9, 9, 9 }
      assert.equal(1, update(grid, screen(), { tolerance = 0 }).lights)
      image[6][2], image[6][3] = { 0, 0, 0 }, { 0, 0, 0 } -- dark texels are no parts
      assert.equal(2, update(grid, screen(), { tolerance = 0 }).lights)
      assert.is_true(worst(grid:sample(everywhere), bake(d, screen()):sample(everywhere)) < 2e-5)
    end)
  end

  it("is taken back where it is cancelled", function()
    local make = kinds[#kinds].make
    for _, d in ipairs(long({ descriptions[2], descriptions[5] }, { descriptions[1], descriptions[2], descriptions[5] })) do
      local grid, twin = bake(d, make(0), true), bake(d, make(0), true)
      for stop = 1, 8 do
        local calls = 0
        local done = update(grid, make(0.3 * stop), { progress = function()
          calls = calls + 1
          return calls < stop
        end })
        if done then update(twin, make(0.3 * stop)) end
        assert.equal(0, difference(grid, twin))
      end
      update(grid, make(1), { tolerance = 0 })
      update(twin, make(1), { tolerance = 0 })
      assert.equal(0, difference(grid, twin))
    end
  end)

  it("gives the same whatever the number of threads, and is saved as it is", function()
    local make = kinds[#kinds].make
    for _, d in ipairs(descriptions) do
      local one, three = bake(d, make(0), true), bake(d, make(0), true)
      for k = 1, long(2, 4) do
        update(one, make(0.1 * k))
        update(three, make(0.1 * k), { threads = 3 })
      end
      assert.equal(0, difference(one, three))
    end
    local grid, name = bake(descriptions[2], make(0), true), os.tmpname() .. ".ylm"
    update(grid, make(0.3))
    assert(grid:save(name))
    local loaded = assert(ylm.load(name))
    os.remove(name)
    assert.equal(0, (core.array_distance(grid:sample(everywhere), loaded:sample(everywhere))))
  end)

  it("comes and goes: from darkness, through spheres, and out", function()
    for _, d in ipairs(descriptions) do
      local grid = bake(d, {}, true)
      for _, now in ipairs { { panel(0, 0.5, 0, 0.1) }, { panel(0, 0.5, 0, 0.1), lamp(0.5, 0.8, 0) }, { lamp(0.5, 0.8, 0) },
        { disk(0.5, 0.8, 0, 0.1) }, {} } do
        assert.equal(1, update(grid, now, { tolerance = 0 }).lights)
        if not d.tolerance and #now > 0 then
          assert.is_true(worst(grid:sample(everywhere), bake(d, now):sample(everywhere)) < 2e-5)
        end
      end
      assert.equal(0, select(3, core.array_distance(grid:sample(occupied), grid:sample(occupied))))
    end
  end)

  it("makes pictures anew only where something changed", function()
    local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8 }
    local stage = ylm.scene "stage" { camera = ylm.camera { from = { 0, 1.2, 2.6 }, at = { 0, 0, 0 }, fov = 45 },
      geometry = { floor }, lights = {} }
    local function prepare()
      return assert(stage:prepare { size = { 48, 32 }, samples = 2, transfer_samples = 8, visibility = "transfer" })
    end
    local view, lights, partly = prepare(), ceiling(200), 0
    local grid = ylm.bake(ylm.adaptive_grid { bounds = box, depth = 5, tolerance = 0.04, dynamic = true }, lights,
      { occupied = view:points().position, threads = 1 })
    view:render { grid = grid, layers = false }
    for k = 1, 4 do
      lights[7] = panel(-0.6 + 0.02 * k, 0.1, 0.5, 0.02, 0.1, 0, { radiance = { 3, 2, 4 } })
      update(grid, lights)
      local image, report = view:render { grid = grid, layers = false }
      assert.equal(0, image:compare((prepare():render { grid = grid, layers = false })).max)
      if report.fresh > 0 and report.fresh < report.points then partly = partly + 1 end
    end
    assert.is_true(partly > 0)
  end)
end)
