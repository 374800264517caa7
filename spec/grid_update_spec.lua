--- grid:update: grids that follow moving lights. What a fresh bake of the same lights gives judges all of it.

local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"
local numbers = require "spec.support.random"

local SEED = 20251123

local random = numbers.minimal

local box = { { -1, -1, -1 }, { 1, 1, 1 } }

local function points_in(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do t[i] = { 2 * r() - 1, 2 * r() - 1, 2 * r() - 1 } end
  return ylm.array(t, "double")
end

--- Shading points on a floor.
local function floor_points(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do t[i] = { 2 * r() - 1, 0.013, 2 * r() - 1 } end
  return ylm.array(t, "double")
end

--- Points on the faces of small voxels, where data of more than one voxel meet.
local function face_points(n, seed)
  local r, t = random(seed), {}
  for i = 1, n do
    t[i] = { 2 * r() - 1, 0.3 * r(), 2 * r() - 1 }
    for axis = 1, 3 do
      if r() < 0.4 then t[i][axis] = math.floor(t[i][axis] * 64) / 64 end
    end
  end
  return ylm.array(t, "double")
end

local faces = face_points(3000, SEED)
local everywhere, occupied = points_in(3000, SEED), floor_points(3000, SEED)

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

local function worst(a, b)
  local e = errors(a, b)
  return e[#e]
end

local function quantile(sorted, q) return sorted[math.ceil(q * #sorted)] end

local function lamp(x, y, z, radius, radiance)
  return ylm.sphere_light { at = { x, y, z }, radius = radius or 0.05, radiance = radiance or { 10, 8, 6 } }
end

--- Lamps that stand, and one that circles low over the floor.
local function lamps(t)
  return {
    lamp(-0.5, 0.3, 0.4),
    lamp(0.5 * math.cos(t), 0.1 + 0.08 * math.sin(3 * t), 0.5 * math.sin(t)),
    lamp(0.2, 0.9, 0, 0.1, { 3, 9, 20 }),
    lamp(0.6, 0.5, -0.3), lamp(0.3, 3, 2, 0.5), lamp(-2, 3, 1, 0.4),
  }
end

--- Many lamps under the ceiling, so that one of them is little of the light.
local function canopy(n)
  local all = {}
  for k = 1, n do
    local r, a = 1.5 * math.sqrt(k / n), 2.4 * k
    all[k] = lamp(r * math.cos(a), 0.7, r * math.sin(a), 0.02, { 3, 2 + k % 3, 4 })
  end
  return all
end

local descriptions = {
  { name = "uniform", make = function(dynamic)
    return ylm.uniform_grid { bounds = box, cells = 6, lmax = 3, dynamic = dynamic }
  end },
  { name = "by a threshold", make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, threshold = 5, dynamic = dynamic }
  end },
  { name = "luminance by an absolute threshold", luminance = true, make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 3, depth = 5, threshold = 0.2, metric = "absolute",
      channels = "luminance", dynamic = dynamic }
  end },
  { name = "by a threshold of rgb", make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, threshold = 2, metric_channels = "rgb",
      dynamic = dynamic }
  end },
  { name = "by a tolerance", tolerance = 0.01, make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, tolerance = 0.01, dynamic = dynamic }
  end },
}

local function bake(d, lights, dynamic)
  return assert(ylm.bake(d.make(dynamic), lights, { occupied = occupied, threads = 1 }))
end

--- grid:update, on one thread unless told otherwise: the grids are small, the machine may be busy.
local function update(grid, lights, options)
  local o = { threads = 1 }
  for name, value in pairs(options or {}) do o[name] = value end
  return grid:update(lights, o)
end

--- Coefficients at the shading points without any grid.
local function exact(d, lights)
  return (ylm.light_field(bake(d, lights).lmax, lights, occupied,
    { channels = d.luminance and "luminance" or "rgb", dtype = "float" }))
end

--- The largest difference of what two grids hold and sample; 0: they are the same.
local function difference(a, b)
  local pa, pb = a:points(), b:points()
  if #pa.position ~= #pb.position then return math.huge end
  local d = 0
  for _, name in ipairs { "position", "value", "gradient" } do
    d = math.max(d, (core.array_distance(pa[name], pb[name])))
  end
  local ca, cb = a:cells { added = true }, b:cells { added = true }
  if #ca.level ~= #cb.level then return math.huge end
  for _, name in ipairs { "origin", "level", "leaf", "corners" } do
    d = math.max(d, (core.array_distance(ca[name], cb[name])))
  end
  return math.max(d, (core.array_distance(a:sample(everywhere), b:sample(everywhere))))
end

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
    it("is right after 1000 updates: grid " .. d.name, function()
      local r, lights = random(SEED), canopy(60)
      local grid = bake(d, lights, true)
      for k = 1, 1000 do
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

  it("fills corners that a lamp moves over, and takes them back behind it", function()
    for _, d in ipairs(descriptions) do
      local seen, grid = 0, bake(d, { lamp(-0.9, 0, 0.01, 0.22), lamp(0.3, 0.8, 0) }, true)
      for k = 1, 12 do
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
    local cells, r = grid:cells(), random(SEED)
    local low, high, eps = {}, {}, 2 ^ -40
    while #low < 4000 do
      local i, axis = math.floor(r() * #cells.level) + 1, math.floor(r() * 3) + 1
      local p, q = {}, {}
      for a = 1, 3 do
        p[a] = cells.origin:get(i, a) + cells.size:get(i, a) * r()
        q[a] = p[a]
      end
      local side = cells.origin:get(i, axis)
      p[axis], q[axis] = side + eps, side - eps
      if cells.leaf[i] == 1 and side > -1 and grid:locate(q).level ~= cells.level[i] then
        low[#low + 1], high[#high + 1] = q, p
      end
    end
    local e = worst(grid:sample(ylm.array(low, "double")), grid:sample(ylm.array(high, "double")))
    assert.is_true(e <= 2e-6, e)
  end)

  it("makes continuity anew only around points that came or went: what it is when made anew everywhere", function()
    local changes = 0
    for _, d in ipairs { descriptions[2], descriptions[4], descriptions[5] } do
      local near, whole = bake(d, lamps(0), true), bake(d, lamps(0), true)
      for k = 1, 12 do
        local lights = lamps(0.11 * k + (k % 4 == 0 and 1 or 0))
        local report = update(near, lights)
        assert(core.grid_update(whole, light.field(1, "update", lights), -1, 1, nil, true))
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
    assert.is_true(changes > 1000, changes) -- else nothing has been tested
  end)

  it("gives the same whatever the number of threads", function()
    for _, d in ipairs(descriptions) do
      local grids = {}
      for threads = 1, 3 do
        grids[threads] = bake(d, lamps(0), true)
        for k = 1, 6 do update(grids[threads], lamps(0.1 * k), { threads = threads }) end
      end
      assert.equal(0, difference(grids[1], grids[2]))
      assert.equal(0, difference(grids[1], grids[3]))
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
      assert.truthy(message:find "^[^:]*grid_update_spec.lua:%d+: .*being updated" or message:find "in use", message)
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
    assert.has_error(function() update(loaded, lamps(0.4)) end)
  end)

  it("counts what it keeps among the grid's bytes", function()
    local d = descriptions[2]
    assert.is_true(bake(d, lamps(0), true).stats.bytes > bake(d, lamps(0)).stats.bytes * 1.2)
  end)
end)

describe("prepared:render of a grid that was updated", function()
  local camera = ylm.camera { from = { 0, 1.2, 2.6 }, at = { 0, 0, 0 }, fov = 45 }
  local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8 }
  local stage = ylm.scene "stage" { camera = camera, geometry = { floor }, lights = {} }
  local size = { 64, 48 }

  local function prepare(scene) return assert(scene:prepare { size = size, samples = 4, transfer_samples = 8 }) end

  it("samples only what changed, and shows what a new view shows", function()
    local view = prepare(stage)
    local points = view:points().position
    for _, make in ipairs { function()
      return ylm.adaptive_grid { bounds = box, depth = 6, tolerance = 0.02, dynamic = true }
    end, function() return ylm.uniform_grid { bounds = box, cells = 6, lmax = 4, dynamic = true } end } do
      local lights = canopy(200)
      local grid = ylm.bake(make(), lights, { occupied = points, threads = 1 })
      local partly = 0
      for k = 1, 6 do
        lights[7] = lamp(-0.6 + 0.02 * k, 0.1, 0.5, 0.02, { 3, 2, 4 })
        update(grid, lights)
        for _, how in ipairs { "hermite", "hermite", "linear" } do
          local image, report = view:render { grid = grid, interpolation = how, layers = false }
          local truth, all = prepare(stage):render { grid = grid, interpolation = how, layers = false }
          assert.equal(0, image:compare(truth).max)
          assert.equal(report.points, all.fresh)
          assert.equal(all.outside, report.outside)
          assert.equal(all.unbaked, report.unbaked)
          if report.fresh > 0 and report.fresh < report.points then partly = partly + 1 end
        end
        assert.equal(0, select(2, view:render { grid = grid, interpolation = "linear", layers = false }).fresh)
        view:render { grid = grid, layers = false } -- so that the next frame finds Hermite's
      end
      assert.is_true(partly > 0)
    end
  end)

  it("writes again the picture it is given", function()
    local view, lights = prepare(stage), canopy(50)
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, lights, { threads = 1 })
    local first = view:render { grid = grid, layers = false }
    lights[3] = lamp(0.2, 0.2, 0.3)
    update(grid, lights)
    local second = view:render { grid = grid, layers = false, lamps = lights, out = first }
    assert.equal(first, second)
    assert.equal(0, second:compare((prepare(stage):render { grid = grid, layers = false, lamps = lights })).max)
    assert.same({ "radiance" }, (second:layers()))
    local names = view:render({ grid = grid, out = second }):layers()
    assert.same((view:render { grid = grid }):layers(), names)
    for _, wrong in ipairs { ylm.image { size = { 64, 47 } }, 7, ylm.image { size = size, layers = { { "radiance", 1 } } } } do
      local ok, message = pcall(view.render, view, { grid = grid, out = wrong })
      assert.is_false(ok)
      assert.truthy(message:find "out: ", message)
    end
  end)

  it("takes another grid for another, and a closed one for none", function()
    local view = prepare(stage)
    local function bake_one(x)
      return ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, { lamp(x, 0.6, 0) },
        { threads = 1 })
    end
    local a, b = bake_one(0), bake_one(0.3)
    local first = view:render { grid = a, layers = false }
    local second = view:render { grid = b, layers = false }
    assert.equal(0, second:compare((prepare(stage):render { grid = b, layers = false })).max)
    assert.is_true(first:compare(second).max > 1e-3)
    a:close()
    assert.has_error(function() view:render { grid = a } end)
  end)

  it("draws lamps where they are now, as rays would", function()
    local lights = { lamp(0.3, 0.3, 0.2, 0.2, 2), lamp(-0.5, 0.15, -0.5, 0.15, { 3, 1, 0.5 }), lamp(0, -0.4, 0, 0.3, 9),
      lamp(-0.2, 0.5, 0.5, 0.05, 4), lamp(0, 1.2, 4, 0.1, 5) } -- one below the floor, one behind the camera
    local traced = ylm.scene "traced" { camera = camera, geometry = { floor }, lights = lights }
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2, dynamic = true }, lights, { threads = 1 })
    local view = assert(stage:prepare { size = size, samples = 64, transfer_samples = 8 })
    local drawn = view:render { grid = grid, layers = false, lamps = lights }
    local truth = assert(traced:prepare { size = size, samples = 64, transfer_samples = 8 })
      :render { grid = grid, layers = false }
    local report = drawn:compare(truth)
    local bare = view:render { grid = grid, layers = false }:compare(truth)
    assert.is_true(report.mae < 0.02, report.mae)
    assert.is_true(bare.mae > 10 * report.mae, bare.mae)
  end)
end)
