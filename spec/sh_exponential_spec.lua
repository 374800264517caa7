local ylm = require "ylm"

local seed = tonumber(os.getenv "YLM_SEED") or 20261123
math.randomseed(seed)

local vectors = require "spec.support.vectors"
local random_vectors, relative = vectors.random, vectors.relative
local unpack = table.unpack or unpack -- luacheck: ignore

local sh, sqrt, pi = ylm.sh, math.sqrt, math.pi
local ONE = sqrt(4 * pi)

--- 1 outside of a cap about z, else 0.
local function circle(lmax, degrees)
  local c = sh.cap(lmax, { 0, 0, 1 }, math.rad(degrees)):totable()
  for i = 1, #c do c[i] = -c[i] end
  c[1] = c[1] + ONE
  return c
end

describe("ylm.sh.product by a rule", function()
  it("is exact from degree (k+1) lmax on, for rows and for one row, by each kernel set's lanes", function()
    for _, lmax in ipairs { 0, 1, 2, 4, 9, 14 } do
      for _, rows in ipairs { 1, 3, 40 } do
        local a, b, c = random_vectors(rows, lmax), random_vectors(rows, lmax), random_vectors(1, lmax)
        local exact = sh.product(a, b, c, { method = "quadrature", dtype = "double" })
        for dtype, bound in pairs { double = 1e-12, float = 1e-5 } do
          local e = relative(sh.product(a, b, c, { rule = 4, dtype = dtype }), exact)
          assert(e < bound, ("lmax %d, %d rows: %g, seed %g"):format(lmax, rows, e, seed))
        end
      end
    end
  end)

  it("multiplies visibilities of any number of bodies as the exact rule does, to what is lost anyway", function()
    for lmax, bound in pairs { [4] = 2e-2, [9] = 5e-3, [14] = 2e-3 } do
      local factors = {}
      for i = 1, 8 do
        local c = sh.cap(lmax, { math.cos(2.4 * i), math.sin(2.4 * i), 1 - i / 5 }, 0.3):totable()
        for k = 1, #c do c[k] = (k == 1 and ONE or 0) - c[k] end
        factors[i] = c
      end
      local exact = sh.product(unpack(factors))
      factors[9] = { rule = 3 }
      local e = relative(sh.product(unpack(factors)), exact)
      assert(e < bound, ("lmax %d: %g"):format(lmax, e))
      for i = 9, 24 do factors[i] = factors[(i - 1) % 8 + 1] end
      factors[25] = { rule = 3 }
      assert.equal((lmax + 1) ^ 2, #sh.product(unpack(factors)))
    end
  end)

  it("refuses other methods, stages, and more factors than without it, by a sentence", function()
    local c = { 1, 2, 3, 4 }
    local function says(words, ...)
      local good, message = pcall(sh.product, ...)
      assert.is_false(good)
      assert.is_truthy(message:find(words, 1, true), message)
    end
    says("rule is of method 'quadrature', not of 'gaunt': leave one out", c, c, { rule = 3, method = "gaunt" })
    says("stages are of a rule that is exact: leave rule out", c, c, { rule = 3, stages = true })
    says("rule must be", c, c, { rule = 0.5 })
    says("2 to 16 factors expected, got 17 (rule = 3 takes 200)", c, c, c, c, c, c, c, c, c, c, c, c, c, c, c, c, c)
  end)
end)

describe("ylm.sh.log and ylm.sh.exp", function()
  it("are those of constants", function()
    for _, x in ipairs { 0.1, 1, 7 } do
      assert.is_near(math.log(x) * ONE, sh.log({ x * ONE, 0, 0, 0 })[1], 1e-13)
      assert.is_near(math.exp(x) * ONE, sh.exp({ x * ONE, 0, 0, 0 })[1], 1e-10)
    end
  end)

  it("has the logarithm of a circle's visibility that tables of Ren et al. 2006 have, 45 degrees, lmax 3", function()
    local g = sh.log(circle(3, 45))
    for l, x in pairs { [0] = -1.314, -1.951, -1.889, -1.380 } do
      assert.is_near(x, g[sh.index(l, 0)], 1e-3)
    end
  end)

  it("turns with the function", function()
    local turn = { axis = { 1, 2, 3 }, angle = 1.1 }
    local c = circle(5, 30)
    assert.is_true(relative(sh.log(sh.rotate(c, turn)), sh.rotate(sh.log(c), turn)) < 1e-12)
  end)

  it("are inverse where the function is smooth, to 1e-6, float to 1e-5", function()
    local c = random_vectors(3, 6):totable()
    for i = 1, 3 do
      for k = 1, 49 do c[i][k] = c[i][k] * 0.02 end
      c[i][1] = c[i][1] + 1.7
    end
    c = ylm.array(c, "double")
    assert.is_true(relative(sh.exp(sh.log(c), { terms = 20 }), c) < 1e-6, "seed " .. seed)
    assert.is_true(relative(sh.exp(sh.log(c, { dtype = "float" }), { terms = 20 }), c) < 1e-5, "seed " .. seed)
  end)

  it("has a series that converges to the exponential at directions", function()
    local c = sh.resize(random_vectors(1, 2), 8):totable()[1]
    for k = 2, #c do c[k] = c[k] * 0.1 end
    local exact = sh.project(8, function(x, y, z) return math.exp(sh.reconstruct(c, { x, y, z })) end, { samples = 4000 })
    assert.is_true(relative(sh.exp(c, { terms = 12 }), exact) < 1e-6, "seed " .. seed)
  end)

  it("turns sums into products", function()
    local a, b = circle(9, 12), sh.rotate(circle(9, 15), { axis = { 1, 0, 0 }, angle = 1.2 })
    local sum = sh.log(a) + sh.log(b)
    assert.is_true(relative(sh.exp(sum, { terms = 20 }), sh.product(a, b)) < 0.05)
  end)

  it("has logarithms of circles from the block of order 0 that are those of the whole matrix", function()
    for _, x in ipairs(sh.circle_log(6, { 0, 0, 1 }, 0):totable()) do assert.is_near(0, x, 1e-14) end
    for _, degrees in ipairs { 8, 45, 90, 140 } do
      local log, zonal = sh.circle_log(6, { 0, 0, 3 }, math.rad(degrees))
      local whole = sh.log(circle(6, degrees))
      assert(relative(log, whole) < 1e-12, degrees)
      assert.is_near(whole[sh.index(3, 0)], zonal[4], 1e-12)
    end
    local turned = sh.circle_log(6, { 1, 2, 3 }, 0.5)
    assert.is_true(relative(turned, sh.zonal(select(2, sh.circle_log(6, { 0, 0, 1 }, 0.5)), { 1, 2, 3 })) < 1e-14)
  end)

  it("of lines and of squared lines are near the circles that they are of, HYB of what is small is OL to the bit", function()
    for lmax, bound in pairs { [4] = 2e-3, [9] = 2e-3, [14] = 0.03 } do
      for _, degrees in ipairs { 5, 15 } do
        local log = sh.circle_log(lmax, { 1, 2, 3 }, math.rad(degrees))
        local c = sh.cap(lmax, { 1, 2, 3 }, math.rad(degrees)) * -1 + sh.resize({ ONE }, lmax)
        local line, squared = sh.exp(log, { method = "OL" }), sh.exp(log, { method = "HYB" })
        assert(relative(line, c) < bound, ("lmax %d, %d degrees: %g"):format(lmax, degrees, relative(line, c)))
        assert.same(line:totable(), squared:totable())
        assert.is_near(c[1], line[1], 2e-6)
      end
    end
  end)

  it("stays finite by HYB and OL where the series does not converge, for many rows as for one", function()
    local rows = random_vectors(70, 5)
    for r = 1, 70, 3 do for k = 2, 36 do rows:set(r, k, 9 * rows:get(r, k)) end end
    for _, method in ipairs { "HYB", "OL" } do
      local all = sh.exp(rows, { method = method }):totable()
      for _, r in ipairs { 1, 2, 64, 70 } do
        local one = sh.exp(rows:totable()[r], { method = method })
        assert.is_true(relative(ylm.array(all[r], "double"), one) < 1e-11, "seed " .. seed)
      end
    end
  end)

  it("takes no rows, and refuses what has no logarithm, series that diverge, numbers that are none", function()
    assert.same({ 0, 4 }, sh.log(ylm.zeros { 0, 4 }).shape)
    assert.same({ 0, 4 }, sh.exp(ylm.zeros { 0, 4 }).shape)
    local function says(words, f, ...)
      local good, message = pcall(f, ...)
      assert.is_false(good)
      assert.is_truthy(message:find(words, 1, true), message)
    end
    says("log: row 2: there is no logarithm of a function that is nowhere positive", sh.log, { { 5, 0, 0, 0 }, { -1, 0, 0, 0 } })
    says("log: row 1: there is no logarithm", sh.log, { 0, 0, 0, 0 })
    says("exp: row 1: the series diverges: term 3", sh.exp, { 0, 1e3, 0, 0 })
    says("exp: number 1 of the result is beyond the range of double", sh.exp, { 1e4, 0, 0, 0 })
    says("lmax up to 20 expected, got 21", sh.log, ylm.zeros { 22 * 22 })
    says("row 1 is not finite", sh.log, { 0 / 0, 0, 0, 0 })
    says("terms must be", sh.exp, { 1 }, { terms = 0 })
    says("terms are of method 'PS': leave them out", sh.exp, { 1 }, { terms = 3, method = "OL" })
    says("lmax up to 20 expected, got 21", sh.exp, ylm.zeros { 22 * 22 }, { method = "HYB" })
    says("angle must be a number >= 0 and <= pi, got -1", sh.circle_log, 3, { 0, 0, 1 }, -1)
    says("direction must be", sh.circle_log, 3, { 0, 0, 0 }, 1)
    says("leaves nothing open", sh.circle_log, 3, { 0, 0, 1 }, pi)
    assert.same({ 0, 4 }, sh.exp(ylm.zeros { 0, 4 }, { method = "HYB" }).shape)
    says("epsilon must be", sh.log, { 1 }, { epsilon = 0 })
  end)
end)
