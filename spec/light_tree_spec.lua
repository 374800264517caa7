local tree_errors = require "spec.support.tree_errors"
local ylm = require "ylm"
local numbers = require "spec.support.random"
local core = require "ylm.c.core"
local ways = require "spec.support.ways"

-- Scenes, in the unit cube -----------------------------------------------------------------

local random = numbers.spread

--- Light i of each kind of scene: place, radius, radiance.
local kinds = {}
function kinds.uniform(next) return { next(), next(), next() }, 0.01, { 1, 1.5, 2 } end
function kinds.clustered(next, i)
  local seed = random(i % 40 + 2)
  seed()
  local function near() return seed() + 0.02 * (next() + next() + next() - 1.5) end
  return { near(), near(), near() }, 0.004, { next(), next(), next() }
end
kinds["wall-mounted"] = function(next, i)
  local at = { next(), next(), next() }
  at[i % 3 + 1] = i % 2 == 0 and 0.999 or 0.001
  return at, 0.006, { 1, 0.8, 0.5 }
end
kinds["mixed-radius"] = function(next) return { next(), next(), next() }, 0.0005 * 200 ^ next(), { 1, 1, 1 } end
kinds.coloured = function(next) return { next(), next(), next() }, 0.01, { next() ^ 2, next() ^ 2, next() ^ 2 } end
function kinds.negative(next, i)
  local at, sign = { next(), next(), next() }, next() < 0.5 and -1 or 1
  at[2] = i % 2 == 0 and 0.98 or at[2]
  return at, 0.001 * 20 ^ next(), { sign * next(), sign * next(), (next() < 0.3 and -sign or sign) * next() }
end

local n_lights = 9000
local packed = {}

--- Lights of a kind, and those with the absolute values of their radiance.
local function scene(kind, n)
  local key = kind .. (n or "")
  if packed[key] then return packed[key].given, packed[key].positive end
  local next, at, radius, radiance, absolute = random(#kind + 4), {}, {}, {}, {}
  for i = 1, n or n_lights do
    at[i], radius[i], radiance[i] = kinds[kind](next, i)
    absolute[i] = {}
    for c = 1, 3 do absolute[i][c] = math.abs(radiance[i][c]) end
  end
  packed[key] = { given = ylm.sphere_lights { at = at, radius = radius, radiance = radiance },
    positive = ylm.sphere_lights { at = at, radius = radius, radiance = absolute } }
  return packed[key].given, packed[key].positive
end

--- Half the points anywhere, half on a floor.
local function places(n, dtype)
  local next, p = random(99), {}
  for i = 1, n do p[i] = { next(), i % 2 == 0 and 0.02 or next(), next() } end
  return ylm.array(p, dtype or "float")
end

-- Errors -----------------------------------------------------------------------------------

local errors, check_errors, field = tree_errors.of, tree_errors.check, tree_errors.field

local all = { derivatives = 2, channels = "rgb", metric = "luminance" }

describe("a tree of lights", function()
  describe("convention", function()
    it("is not used for a few hundred lights, which are summed exactly", function()
      local few = scene("uniform", 500)
      local points = places(40)
      local exact = { ylm.light_field(3, few, points, { derivatives = 2 }) }
      local tree = { ylm.light_field(3, few, points, { derivatives = 2, tolerance = 0.1 }) }
      for k = 1, 3 do assert.equal(0, (core.array_distance(exact[k], tree[k]))) end
      assert.equal(40 * 500, tree[4].pairs)
      assert.equal(0, core.lights_tree_bytes(few.lights))
    end)

    it("sums fewer lights the larger the tolerance, and is exact without", function()
      local lights, points = scene("uniform"), places(400)
      local last = 1
      for _, tolerance in ipairs { 1e-3, 1e-2, 1e-1 } do
        local _, _, _, report = ylm.light_field(3, lights, points, { tolerance = tolerance })
        assert.is_true(report.pairs < 0.9 * last * 400 * n_lights)
        last = report.pairs / (400 * n_lights)
      end
      local _, _, _, report = ylm.light_field(3, lights, points)
      assert.equal(400 * n_lights, report.pairs)
    end)

    it("is made once and kept by the lights", function()
      local lights, points = scene("uniform", 4000), places(2)
      ylm.light_field(1, lights, points, { tolerance = 0.1 })
      local bytes = core.lights_tree_bytes(lights.lights)
      assert.is_true(bytes > 100 * 4000 and bytes < 1000 * 4000)
      ylm.light_field(1, lights, points, { tolerance = 0.01 })
      assert.equal(bytes, core.lights_tree_bytes(lights.lights))
    end)
  end)

  describe("error", function()
    for _, kind in ipairs { "uniform", "clustered", "wall-mounted", "mixed-radius", "coloured", "negative" } do
      it("stays within the tolerance in value, gradient, Hessian and lambda: " .. kind, function()
        local lights, positive = scene(kind)
        local n = 600
        local points = places(n)
        local exact, whole = field(3, lights, points, all), field(3, positive, points, all)
        for _, tolerance in ipairs { 1e-1, 1e-2, 1e-3 } do
          local tree = field(3, lights, points, all, tolerance)
          assert.is_true(tree[4].pairs < exact[4].pairs)
          check_errors(errors(tree, exact, whole, n), tolerance, ("%s, %g"):format(kind, tolerance))
          assert.equal(0, (core.array_distance(tree[4].inside, exact[4].inside)))
        end
      end)
    end

    it("stays within the tolerance at other lmax", function()
      for _, lmax in ipairs { 0, 1, 6, 11 } do
        local n = lmax > 4 and 150 or 400
        local lights, points = scene("mixed-radius"), places(n)
        local exact = field(lmax, lights, points, all)
        local tree = field(lmax, lights, points, all, 1e-1)
        assert.is_true(tree[4].pairs < exact[4].pairs)
        check_errors(errors(tree, exact, exact, n), 1e-1, "lmax " .. lmax)
      end
    end)

    it("stays within the tolerance whatever is asked for", function()
      local lights, n = scene("clustered"), 60
      local points = places(n)
      for derivatives = 0, 2 do
        for _, channels in ipairs { "rgb", "luminance" } do
          for _, metric in ipairs { false, "rgb", "luminance" } do
            local o = { derivatives = derivatives, channels = channels, metric = metric or nil }
            local exact, tree = field(2, lights, points, o), field(2, lights, points, o, 1e-2)
            assert.is_true(tree[4].pairs < exact[4].pairs)
            check_errors(errors(tree, exact, exact, n), 1e-2, ("%d %s %s"):format(derivatives, channels, metric))
          end
        end
      end
    end)

    it("stays within the tolerance in any unit of length, and far away", function()
      local next, at, far = random(5), {}, {}
      for i = 1, 4000 do at[i] = { next(), next(), next() } end
      for i = 1, 60 do far[i] = { 100 * next(), 3 + 1000 * next(), next() } end
      for _, unit in ipairs { 1e-9, 1e-5, 1, 1e3, 1e9 } do
        local function scaled(list)
          local out = {}
          for i, p in ipairs(list) do out[i] = { unit * p[1], unit * p[2], unit * p[3] } end
          return out
        end
        local lights = ylm.sphere_lights { at = scaled(at), radius = 0.01 * unit, radiance = 1 }
        for _, points in ipairs { scaled(places(60):totable()), scaled(far) } do
          -- squares of Hessians leave float's range at the largest and the smallest
          for _, dtype in ipairs { "double", math.abs(math.log(unit)) < 12 and "float" or nil } do
            local p = ylm.array(points, dtype)
            local exact, tree = field(3, lights, p, all), field(3, lights, p, all, 1e-2)
            assert.is_true(tree[4].pairs < exact[4].pairs)
            check_errors(errors(tree, exact, exact, 60), 1e-2, ("unit %g, %s"):format(unit, dtype))
          end
        end
      end
    end)

    it("stays within the tolerance for lights in one place, on a line, on a plane, and dark ones", function()
      local next = random(8)
      local places_of = {
        ["one place"] = function() return { 0.5, 0.5, 0.5 } end,
        ["a line"] = function() return { next(), 0.5, 0.3 } end,
        ["a plane"] = function() return { next(), next(), 0.3 } end,
        ["dark"] = function() return { next(), next(), next() } end,
      }
      for name, place in pairs(places_of) do
        local at, radius, radiance = {}, {}, {}
        for i = 1, 5000 do
          at[i], radius[i], radiance[i] = place(), i % 7 == 0 and 0 or 0.003, name == "dark" and i % 2 or 1
        end
        local lights = ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
        local points = places(200)
        local exact, tree = field(4, lights, points, all), field(4, lights, points, all, 1e-2)
        assert.is_true(tree[4].pairs < exact[4].pairs)
        check_errors(errors(tree, exact, exact, 200), 1e-2, name)
      end
    end)

    it("is that of the sphere lights where polygons are among the lights", function()
      local lights, points = scene("uniform"), places(50)
      local window = ylm.polygon_light { vertices = { { 0, 2, 0 }, { 1, 2, 0 }, { 1, 2, 1 } }, radiance = 3 }
      local exact = { ylm.light_field(2, { lights, window }, points, { derivatives = 1 }) }
      local tree = { ylm.light_field(2, { lights, window }, points, { derivatives = 1, tolerance = 1e-2 }) }
      assert.is_true(tree[4].pairs < exact[4].pairs)
      check_errors(errors(tree, exact, exact, 50), 1e-2, "with a polygon")
    end)
  end)

  describe("properties", function()
    it("gives the same bits whatever the threads and the order of points", function()
      local lights = scene("negative")
      for _, dtype in ipairs { "float", "double" } do
        local points = places(77, dtype)
        local o = { derivatives = 2, tolerance = 1e-2, threads = 1 }
        local one = { ylm.light_field(3, lights, points, o) }
        o.threads = 3
        local three = { ylm.light_field(3, lights, points, o) }
        local turned, rows = {}, points:totable()
        for i = 1, 77 do turned[i] = rows[78 - i] end
        local back = { ylm.light_field(3, lights, ylm.array(turned, dtype), o) }
        for k = 1, 3 do
          assert.equal(0, (core.array_distance(one[k], three[k])))
          for i = 1, 77 do assert.equal(0, (core.array_distance(one[k][i], back[k][78 - i]))) end
        end
      end
    end)

    it("keeps the tolerance for points alone, in dense packets, far apart, and all in one place", function()
      local lights, positive = scene("wall-mounted", 12000)
      local next, sets = random(17), { alone = { { 0.3, 0.02, 0.4 } }, dense = {}, apart = {}, same = {}, line = {} }
      for i = 1, 200 do
        sets.dense[i] = { 0.4 + 0.02 * next(), 0.02, 0.5 + 0.02 * next() }
        sets.apart[i] = { i % 2 + 0.4 * next(), next(), 40 * next() - 20 }
        sets.same[i] = { 0.7, 0.1, 0.6 }
        sets.line[i] = { 0.5, 0.5, i / 200 }
      end
      for name, set in pairs(sets) do
        for _, dtype in ipairs { "float", "double" } do
          local points = ylm.array(set, dtype)
          local exact, whole = field(3, lights, points, all), field(3, positive, points, all)
          local tree = field(3, lights, points, all, 1e-2)
          assert.is_true(tree[4].pairs < exact[4].pairs, name)
          check_errors(errors(tree, exact, whole, #set), 1e-2, name .. ", " .. dtype)
        end
      end
      local tree = field(3, lights, ylm.array(sets.same, "float"), all, 1e-2)
      for i = 2, 200 do assert.equal(0, (core.array_distance(tree[1][1], tree[1][i]))) end
    end)

    it("keeps the tolerance for points far apart among very many lights, which walk by themselves", function()
      local lights, positive = scene("negative", 60000)
      local n = 40
      for _, lmax in ipairs { 0, 3, 11 } do
        for _, dtype in ipairs { "float", "double" } do
          local points = places(lmax > 10 and 17 or n, dtype)
          local exact, whole = field(lmax, lights, points, all), field(lmax, positive, points, all)
          for _, tolerance in ipairs { 1e-1, 1e-2 } do
            local tree = field(lmax, lights, points, all, tolerance)
            assert.is_true(tree[4].pairs < exact[4].pairs / 3)
            check_errors(errors(tree, exact, whole, #points), tolerance, ("lmax %d, %s"):format(lmax, dtype))
          end
        end
      end
    end)

    it("gives such points the same bits whatever the threads", function()
      local lights, points = scene("negative", 60000), places(50)
      local o = { derivatives = 2, tolerance = 1e-2, threads = 1 }
      local one = { ylm.light_field(3, lights, points, o) }
      o.threads = 3
      local three = { ylm.light_field(3, lights, points, o) }
      for k = 1, 3 do assert.equal(0, (core.array_distance(one[k], three[k]))) end
      assert.equal(one[4].pairs, three[4].pairs)
    end)

    it("sums hardly more for packets of dense points than for each by itself", function()
      local lights, points = scene("uniform"), {}
      for i = 1, 256 do points[i] = { 0.5 + 0.05 * (i % 16) / 16, 0.02, 0.5 + 0.05 * math.ceil(i / 16) / 16 } end
      local dense = field(3, lights, ylm.array(points, "float"), all, 1e-2)
      local alone = field(3, lights, ylm.array({ points[1] }, "float"), all, 1e-2)
      assert.is_true(dense[4].pairs < 1.6 * 256 * alone[4].pairs)
    end)

    it("sums few proxies, which have the third moments of lights of equal colours and of those on walls", function()
      local most = { uniform = 1900, ["wall-mounted"] = 950 }
      for kind, pairs_a_point in pairs(most) do
        local lights, points = scene(kind, 60000), places(40)
        local _, _, _, report = ylm.light_field(3, lights, points, { derivatives = 1, tolerance = 1e-2 })
        assert.is_true(report.pairs < 40 * pairs_a_point, kind)
      end
    end)

    it("sees nothing but light in and on a light, and says so", function()
      local at = {}
      local next = random(3)
      for i = 1, 3000 do at[i] = { 10 + next(), next(), next() } end
      at[1] = { 0, 0, 0 }
      local lights = ylm.sphere_lights { at = at, radius = 0.01, radiance = 2 }
      local points = ylm.array({ { 0, 0, 0 }, { 0.005, 0, 0 }, { 0.02, 0, 0 } }, "float")
      local exact, tree = field(2, lights, points, all), field(2, lights, points, all, 1e-2)
      assert.same({ 1, 1, 0 }, tree[4].inside:totable())
      check_errors(errors(tree, exact, exact, 3), 1e-2, "inside")
    end)

    it("stops where progress returns false", function()
      local nothing, message, code = ylm.light_field(2, scene("uniform"), places(500),
        { tolerance = 1e-2, progress = function() return false end })
      assert.is_nil(nothing)
      assert.equal("cancelled", message)
      assert.equal("ECANCELLED", code)
    end)
  end)

  describe("kernels", function()
    for _, isa in ipairs(ylm.info().kernels) do
      it("agree: " .. isa, function()
        local lights, positive = scene("negative", 3000)
        local n = isa == "reference" and 4 or 100
        local points = places(n)
        local exact, whole = field(2, lights, points, all), field(2, positive, points, all)
        local tree = field(2, lights, points, all, 1e-2, isa)
        check_errors(errors(tree, exact, whole, n), 1e-2, isa)
        if isa == "reference" then assert.equal(n * 3000, tree[4].pairs) end
        if isa ~= "reference" then
          local p = ylm.array(points, "double")
          check_errors(errors(field(2, lights, p, all, 1e-2, isa), field(2, lights, p, all), whole, n), 1e-2, isa)
        end
      end)
    end
  end)

  describe("bakes", function()
    local lights = scene("wall-mounted")
    local box = { { 0, 0, 0 }, { 1, 1, 1 } }

    it("into uniform grids with fewer pairs, to the tolerance", function()
      local form = ylm.uniform_grid { bounds = { { 0.1, 0.1, 0.1 }, { 0.9, 0.9, 0.9 } }, cells = 6, lmax = 2 }
      local exact, tree = ylm.bake(form, lights), ylm.bake(form, lights, { sums_tolerance = 1e-2 })
      assert.is_true(tree.stats.pairs < 0.3 * exact.stats.pairs)
      local a, b = tree:points(), exact:points()
      check_errors(errors({ a.value, a.gradient, nil, { lambda = a.lambda } },
        { b.value, b.gradient, nil, { lambda = b.lambda } },
        { b.value, b.gradient, nil, { lambda = b.lambda } }, #a.value), 1e-2, "a uniform grid")
    end)

    it("into adaptive grids that keep their own tolerance, and knows the lights for pictures", function()
      local form = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.05 }
      local occupied = {}
      for i = 0, 6 do for j = 0, 6 do occupied[#occupied + 1] = { 0.3 + i / 15, 0.5, 0.3 + j / 15 } end end
      local grid = ylm.bake(form, lights, { sums_tolerance = 5e-3, occupied = occupied })
      assert.is_true(grid.stats.met)
      local L = ylm.light_field(2, lights, occupied)
      local sampled = grid:sample(occupied)
      local e = errors({ sampled, nil, nil, {} }, { L, nil, nil, {} }, { L, nil, nil, {} }, #occupied)
      assert.is_true(e[1][math.floor(0.98 * #occupied)] < 0.06)
      assert.equal(n_lights, core.lights_count(require "ylm.grid".lights_of(grid)))
    end)
  end)

  describe("scenes", function()
    local lights = scene("wall-mounted")
    local function room()
      return ylm.scene "many lamps" {
        camera = ylm.camera { from = { 0.5, 0.6, -1 }, at = { 0.5, 0.2, 0.5 } },
        geometry = { ylm.quad { corner = { 0, 0.02, 1 }, u = { 1, 0, 0 }, v = { 0, 0, -1 }, divide = 8 } },
        lights = { lights },
        probes = ylm.uniform_grid { cells = 4, lmax = 2 },
      }
    end
    local view = { size = { 32, 18 }, samples = 1, visibility = "none" }

    it("are rendered and baked with fewer pairs, and look the same", function()
      local s = room()
      local exact, e = s:render(ways.sum(view))
      view.sums_tolerance = 1e-2
      local tree, t = s:render(ways.sum(view))
      assert.is_true(t.pairs < 0.5 * e.pairs)
      assert.is_true(tree:compare(exact).mape < 1)
      assert.equal("0.01", tree.metadata.sums_tolerance)
      assert.is_true(s:bake({ sums_tolerance = 1e-2 }).stats.pairs
        < 0.5 * s:bake().stats.pairs)
      assert(s:render(view))
      local ok, message = pcall(s.render, s, { grid = s:bake(), sums_tolerance = 1e-2 })
      assert.is_false(ok)
      assert.truthy(message:find("this grid is baked: leave one out", 1, true))
    end)
  end)

  describe("refusals", function()
    local lamp = ylm.sphere_light { at = { 0, 1, 0 } }
    for text, value in pairs { ["0"] = 0, ["-1"] = -1, nan = 0 / 0, inf = math.huge, ["0.6"] = 0.6, ["1e-9"] = 1e-9,
      text = "1e-2" } do
      it("of a tolerance of " .. text, function()
        local ok, message = pcall(ylm.light_field, 1, lamp, { 0, 0, 0 }, { tolerance = value })
        assert.is_false(ok)
        assert.truthy(message:find("tolerance must be a number >= 1e%-06 and <= 0.5"), message)
        ok, message = pcall(ylm.bake, ylm.uniform_grid { cells = 1, bounds = { { 0, 0, 0 }, { 1, 1, 1 } } }, lamp,
          { sums_tolerance = value })
        assert.is_false(ok)
        assert.truthy(message:find("sums_tolerance must be a number >= 1e%-06 and <= 0.5"), message)
      end)
    end
  end)
end)
