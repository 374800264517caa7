local ylm = require "ylm"
local core = require "ylm.c.core"
local vectors = require "spec.support.vectors"

local seed = tonumber(os.getenv("YLM_SEED") or "") or 20250811

--- n random points: directions of lengths 0.01 to 100, every fifth within 1e-6 .. 1e-1 of a pole.
local function random_points(n, dtype)
  math.randomseed(seed)
  local points = {}
  for i = 1, n do
    local x, y, z = math.random() * 2 - 1, math.random() * 2 - 1, math.random() * 2 - 1
    if i % 5 == 0 then
      local near = 10 ^ (-6 + 5 * math.random())
      x, y, z = near * x, near * y, i % 2 == 0 and 1 or -1
    end
    local length = 10 ^ (4 * math.random() - 2) / math.sqrt(x * x + y * y + z * z)
    points[i] = { x * length, y * length, z * length }
  end
  return ylm.array(points, dtype or "double")
end

--- Largest error of each order: of every degree relative to the largest of its degree, over all points.
local function errors(lmax, got, wanted)
  local worst = {}
  for k = 1, #got do worst[k] = core.sh_error(lmax, got[k], wanted[k]) end
  return worst
end

local function all_below(worst, bound, what)
  for k = 1, #worst do
    assert(worst[k] <= bound, ("%s: derivatives of order %d are off by %.3g (bound %.3g, seed %d)")
      :format(what, k - 1, worst[k], bound, seed))
  end
end

describe("ylm.sh.eval", function()
  describe("convention", function()
    it("has Y(1,-1), Y(1,0), Y(1,1) as sqrt(3/4pi) times -y, z, -x", function()
      local c = math.sqrt(3 / (4 * math.pi))
      local Y = ylm.sh.eval(1, { 0.48, -0.6, 0.64 })
      local wanted = { math.sqrt(1 / (4 * math.pi)), 0.6 * c, 0.64 * c, -0.48 * c }
      for i = 1, 4 do assert.is_near(wanted[i], Y[i], 1e-15) end
    end)

    it("has indices l(l+1)+m, one-based", function()
      assert.equals(1, ylm.sh.index(0, 0))
      for i = 1, 400 do
        local l, m = ylm.sh.degree(i)
        assert.equals(i, ylm.sh.index(l, m))
      end
      assert.equals(1002001, ylm.sh.index(1000, 1000))
      assert.equals(25, ylm.sh.count(4))
    end)

    it("gives one row for one vector, and nothing for no vectors", function()
      assert.same({ 9 }, ylm.sh.eval(2, { 0, 0, 1 }).shape)
      local Y, dY, ddY = ylm.sh.eval(2, { { 0, 0, 1 } }, { derivatives = 2 })
      assert.same({ 1, 9 }, Y.shape)
      assert.same({ 1, 9, 3 }, dY.shape)
      assert.same({ 1, 9, 6 }, ddY.shape)
      assert.same({ 0, 9 }, ylm.sh.eval(2, {}).shape)
      assert.equals("ylm", Y.convention)
    end)

    it("takes its type from the points, double for tables, or as asked", function()
      assert.equals("double", ylm.sh.eval(1, { 0, 0, 1 }).dtype)
      assert.equals("float", ylm.sh.eval(1, ylm.array({ 0, 0, 1 }, "float")).dtype)
      assert.equals("float", ylm.sh.eval(1, { 0, 0, 1 }, { dtype = "float" }).dtype)
    end)

    it("writes into arrays given as out", function()
      local Y, dY = ylm.zeros { 1, 4 }, ylm.zeros { 1, 4, 3 }
      local a, b = ylm.sh.eval(1, { { 0, 0, 2 } }, { derivatives = 1, out = { Y, dY } })
      assert(rawequal(a, Y) and rawequal(b, dY))
      assert.is_near(math.sqrt(3 / (4 * math.pi)), Y:get(1, 3), 1e-15)
    end)
  end)

  describe("properties", function()
    it("obeys the addition theorem at random directions, to lmax 150", function()
      local p = random_points(40)
      for _, lmax in ipairs { 4, 20, 60, 150 } do
        local Y = ylm.sh.eval(lmax, p):totable()
        for i = 1, #Y do
          local k = 0
          for l = 0, lmax do
            local sum = 0
            for _ = -l, l do k = k + 1; sum = sum + Y[i][k] ^ 2 end
            assert.is_near(1, sum * 4 * math.pi / (2 * l + 1), 5e-14 * (l + 4),
              ("l %d, point %d, seed %d"):format(l, i, seed))
          end
        end
      end
    end)

    it("has gradients across v, of squared sum l(l+1)(2l+1)/(4 pi |v|^2)", function()
      local p, lmax = random_points(20), 12
      local _, dY = ylm.sh.eval(lmax, p, { derivatives = 1 })
      local points, g = p:totable(), dY:totable()
      for i = 1, #g do
        local v, k = points[i], 0
        local d2 = v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2
        for l = 0, lmax do
          local sum = 0
          for _ = -l, l do
            k = k + 1
            local a = g[i][k]
            sum = sum + a[1] ^ 2 + a[2] ^ 2 + a[3] ^ 2
            assert.is_near(0, v[1] * a[1] + v[2] * a[2] + v[3] * a[3], 1e-12)
          end
          local wanted = l * (l + 1) * (2 * l + 1) / (4 * math.pi) / d2
          assert.is_near(0, (sum - wanted) / (wanted + 1e-300), 1e-12)
        end
      end
    end)

    it("has Hessians with trace -l(l+1) Y/|v|^2 and H v = -gradient", function()
      local p, lmax = random_points(20), 12
      local Y, dY, ddY = ylm.sh.eval(lmax, p, { derivatives = 2 })
      local points, y, g, h = p:totable(), Y:totable(), dY:totable(), ddY:totable()
      for i = 1, #h do
        local v = points[i]
        local d = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
        for k = 1, #h[i] do
          local l, b, a = ylm.sh.degree(k), h[i][k], g[i][k]
          local scale = 1e-13 * (l + 1) ^ 2.5
          assert.is_near(-l * (l + 1) * y[i][k], (b[1] + b[4] + b[6]) * d * d, scale)
          assert.is_near(-a[1] * d, (b[1] * v[1] + b[2] * v[2] + b[3] * v[3]) * d, scale)
          assert.is_near(-a[2] * d, (b[2] * v[1] + b[4] * v[2] + b[5] * v[3]) * d, scale)
          assert.is_near(-a[3] * d, (b[3] * v[1] + b[5] * v[2] + b[6] * v[3]) * d, scale)
        end
      end
    end)

    it("does not depend on the length of the vector, from 1e-30 to 1e30, in float too", function()
      for _, dtype in ipairs { "double", "float" } do
        local wanted = ylm.sh.eval(8, { 0.5, -0.25, 0.75 }, { dtype = dtype })
        for _, s in ipairs { 2 ^ -100, 2 ^ -60, 2 ^ 10, 2 ^ 60, 2 ^ 100 } do
          local got = ylm.sh.eval(8, { 0.5 * s, -0.25 * s, 0.75 * s }, { dtype = dtype })
          assert((core.array_distance(got, wanted)) < (dtype == "float" and 1e-6 or 1e-14))
        end
      end
      local extremes = {
        { 1e-30, 0, 0 }, { 0, 1e30, 0 }, { 1e-300, 1e-300, -1e-300 }, { 1e300, 0, 1e300 }, { 5e-324, 0, 0 },
      }
      assert(core.array_finite(ylm.sh.eval(20, extremes)))
      local _, dY, ddY = ylm.sh.eval(4, { { 0, 0, 1e30 }, { 1e-30, 0, 0 } }, { derivatives = 2 })
      assert(core.array_finite(dY) and core.array_finite(ddY))
    end)

    it("stays finite at high degree: float to 200, double to 1000, poles and their surroundings included", function()
      local points = {
        { 0, 0, 1 }, { 0, 0, -1 }, { 1, 0, 0 }, { 1e-8, 0, 1 }, { 1e-3, 1e-3, -1 }, { 0.1, 0, 1 }, { 1, 2, 3 },
      }
      for _, lmax in ipairs { 60, 128, 129, 200 } do
        for _, a in ipairs { ylm.sh.eval(lmax, points, { dtype = "float", derivatives = 2 }) } do
          assert(core.array_finite(a))
        end
      end
      for _, a in ipairs { ylm.sh.eval(150, points, { derivatives = 2 }) } do assert(core.array_finite(a)) end
      local Y = ylm.sh.eval(1000, { { 0, 0, 1 }, { 1, 2, 3 } })
      assert(core.array_finite(Y))
      for l = 0, 1000, 100 do
        assert.is_near(math.sqrt((2 * l + 1) / (4 * math.pi)), Y:get(1, ylm.sh.index(l, 0)), 1e-9)
      end
    end)

    it("gives solid harmonics that satisfy Laplace's equation and v.grad = l S", function()
      local p, lmax = random_points(20), 8
      local S, dS, ddS = ylm.sh.eval(lmax, p, { derivatives = 2, solid = true })
      local points, s, g, h = p:totable(), S:totable(), dS:totable(), ddS:totable()
      for i = 1, #s do
        local v = points[i]
        local d = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
        for k = 1, #s[i] do
          local l, a, b = ylm.sh.degree(k), g[i][k], h[i][k]
          local scale = 1e-12 * d ^ l * (l + 1) ^ 2
          assert.is_near(0, (b[1] + b[4] + b[6]) * d * d, scale)
          assert.is_near(l * s[i][k], v[1] * a[1] + v[2] * a[2] + v[3] * a[3], scale)
        end
      end
    end)

    it("gives the same bits whatever the number of threads, and per point whatever the batch", function()
      local p = random_points(3001)
      for _, options in ipairs { { 5, 2 }, { 9, 1 }, { 11, 2 } } do
        local lmax, k = options[1], options[2]
        local one = { ylm.sh.eval(lmax, p, { derivatives = k, threads = 1 }) }
        local many = { ylm.sh.eval(lmax, p, { derivatives = k, threads = 7 }) }
        local alone = { ylm.sh.eval(lmax, p[3001], { derivatives = k }) }
        for i = 1, k + 1 do
          assert.equals(0, (core.array_distance(one[i], many[i])))
          assert.equals(0, (core.array_distance(one[i][3001], alone[i])))
        end
      end
    end)

    it("reports progress and is cancelled by it", function()
      local p, calls = random_points(20000), 0
      local Y, message, code = ylm.sh.eval(10, p, { progress = function(done, total)
        calls = calls + 1
        assert(done <= total and total == 20000)
        return false
      end })
      assert.equals(1, calls)
      assert(Y == nil and message == "cancelled" and code == "ECANCELLED")
    end)
  end)

  describe("agreement", function()
    for _, kernel in ipairs(ylm.info().kernels) do
      it("with the reference vectors to 1e-13, poles and unnormalised vectors included: " .. kernel, function()
        for _, set in ipairs(vectors.sh "spec/data/sh_basis.txt") do
          all_below(vectors.compare(set, { ylm.sh.eval(set.lmax, set.points, { derivatives = 2, kernel = kernel }) }),
            1e-13, "lmax " .. set.lmax)
        end
      end)

      it("with the reference vectors of degrees 20 and 40 to 1e-12: " .. kernel, function()
        for _, set in ipairs(vectors.sh "spec/data/sh_basis_high.txt") do
          all_below(vectors.compare(set, { ylm.sh.eval(set.lmax, set.points, { derivatives = 2, kernel = kernel }) }),
            1e-12, "lmax " .. set.lmax)
        end
      end)

      it("with the reference vectors of solid harmonics, origin included: " .. kernel, function()
        for _, set in ipairs(vectors.sh "spec/data/solid.txt") do
          local results = { ylm.sh.eval(set.lmax, set.points, { derivatives = 2, solid = true, kernel = kernel }) }
          all_below(vectors.compare(set, results), 1e-13, "lmax " .. set.lmax)
        end
      end)

      it("with the reference kernel, every lmax to 13, then 20, 40: " .. kernel, function()
        local double = random_points(101)
        local float = ylm.array(double, "float")
        local rounded = ylm.array(float, "double")
        for _, lmax in ipairs { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 20, 40 } do
          for k = 0, lmax <= 13 and 2 or 1 do
            for _, solid in ipairs { false, true } do
              local judge = { ylm.sh.eval(lmax, double, { derivatives = k, solid = solid, kernel = "reference" }) }
              local got = { ylm.sh.eval(lmax, double, { derivatives = k, solid = solid, kernel = kernel }) }
              all_below(errors(lmax, got, judge), 1e-13 * math.max(1, lmax / 12) ^ 2, "double lmax " .. lmax)
              if not solid or lmax <= 8 then -- |v|^lmax has to be a float
                judge = { ylm.sh.eval(lmax, rounded, { derivatives = k, solid = solid, kernel = "reference" }) }
                got = { ylm.sh.eval(lmax, float, { derivatives = k, solid = solid, kernel = kernel }) }
                all_below(errors(lmax, got, judge), 4e-6 * math.max(1, lmax / 20), "float lmax " .. lmax)
              end
            end
          end
        end
      end)
    end

    local function away_from_poles(n)
      local points = {}
      for _, p in ipairs(random_points(n):totable()) do
        if p[1] ^ 2 + p[2] ^ 2 > 1e-2 * p[3] ^ 2 then points[#points + 1] = p end
      end
      return ylm.array(points)
    end

    for method, limits in pairs { polynomial = { 6, 2 }, direct = { 12, 1 }, sloan = { 12, 1 }, scd = { 12, 2 } } do
      it("of the method '" .. method .. "' with ours, away from the poles", function()
        local p = away_from_poles(100)
        local ours = { ylm.sh.eval(limits[1], p, { derivatives = limits[2] }) }
        all_below(errors(limits[1], { ylm.sh.eval(limits[1], p, { derivatives = limits[2], method = method }) }, ours),
          1e-11, method)
        all_below(errors(4, { ylm.sh.eval(4, p, { derivatives = limits[2], method = method, dtype = "float" }) },
          { ylm.sh.eval(4, p, { derivatives = limits[2], dtype = "float" }) }), 1e-5, method)
      end)
    end

    it("of methods in angles with ours, at the poles: values yes, derivatives are not numbers", function()
      local wanted = ylm.sh.eval(4, { 0, 0, 1 })
      for _, method in ipairs { "direct", "sloan", "scd" } do
        local Y, dY = ylm.sh.eval(4, { 0, 0, 1 }, { derivatives = 1, method = method })
        assert((core.array_distance(Y, wanted)) < 1e-15)
        assert(not core.array_finite(dY))
      end
      local _, dY, ddY = ylm.sh.eval(4, { 0, 0, -3 }, { derivatives = 2, method = "polynomial" })
      assert(core.array_finite(dY) and core.array_finite(ddY))
    end)
  end)
end)

describe("ylm.sh.reconstruct", function()
  it("is the sum of coefficients times basis functions, for rows of coefficients and points", function()
    local p = random_points(70)
    math.randomseed(seed)
    local c = {}
    for r = 1, 3 do c[r] = {} for k = 1, 36 do c[r][k] = math.random() - 0.5 end end
    local f, Y = ylm.sh.reconstruct(c, p), ylm.sh.eval(5, p):totable()
    assert.same({ 3, 70 }, f.shape)
    for r = 1, 3 do
      for i = 1, 70 do
        local sum = 0
        for k = 1, 36 do sum = sum + c[r][k] * Y[i][k] end
        assert.is_near(sum, f:get(r, i), 1e-14)
      end
    end
  end)

  it("gives a number for one row and one point, a list of rows for one point", function()
    assert.is_near(1 / math.sqrt(4 * math.pi), ylm.sh.reconstruct({ 1 }, { 0, 3, 0 }), 1e-16)
    assert.same({ 2 }, ylm.sh.reconstruct({ { 1 }, { 2 } }, { 0, 3, 0 }).shape)
    assert.same({ 2, 1 }, ylm.sh.reconstruct({ { 1 }, { 2 } }, { { 0, 3, 0 } }).shape)
    assert.equals("float", ylm.sh.reconstruct(ylm.array({ { 1 } }, "float"), { { 0, 3, 0 } }).dtype)
  end)
end)
