local core = require "ylm.c.core"
local ylm = require "ylm"

local seed = tonumber(os.getenv "YLM_SEED") or 20261121

local vectors = require "spec.support.vectors"
local random_vectors, relative = vectors.random, vectors.relative

--- Records of spec/data/products.txt: { n =, factors = {..}, exact = row, truncated = row or nil }.
local function reference()
  local list, by_id = {}, {}
  for line in io.lines "spec/data/products.txt" do
    local letter, rest = line:match "^([FTR]) (.*)"
    if letter then
      local words = {}
      for w in rest:gmatch "%S+" do words[#words + 1] = w end
      local id, row = words[1], {}
      for i = 6, #words do row[#row + 1] = tonumber(words[i]) end
      local set = by_id[id]
      if not set then
        set = { n = tonumber(words[3]), kind = words[2], factors = {} }
        by_id[id], list[#list + 1] = set, set
      end
      if letter == "F" then set.factors[tonumber(words[5])] = row
      elseif letter == "T" then set.exact = row
      else set.truncated = row end
    end
  end
  return list
end

local unpack = table.unpack or unpack -- luacheck: ignore

--- product(factors..., options)
local function multiply(factors, options)
  local list = { unpack(factors) }
  list[#list + 1] = options
  return ylm.sh.product(unpack(list))
end

describe("ylm.sh.product", function()
  before_each(function() math.randomseed(seed) end)

  it("is the product of the functions, where its degree fits: z times z", function()
    local z = ylm.sh.resize({ 0, 0, math.sqrt(4 * math.pi / 3), 0 }, 2)
    for _, v in ipairs { { 0, 0, 1 }, { 0.6, 0, 0.8 }, { 1, 0, 0 } } do
      assert.is_near(v[3] ^ 2, ylm.sh.reconstruct(ylm.sh.product(z, z), v), 1e-14)
    end
  end)

  it("of a function and 1 is the function", function()
    local c, one = random_vectors(3, 6), ylm.sh.resize({ math.sqrt(4 * math.pi) }, 6)
    assert(relative(ylm.sh.product(c, one), c) < 1e-14)
  end)

  it("holds the integrals of three basis functions: the reference's list, and no others to l = 5", function()
    local wanted = {}
    for line in io.lines "spec/data/gaunt.txt" do
      local n = {}
      for w in line:gmatch "%S+" do n[#n + 1] = tonumber(w) end
      if line:match "^%d" and #n == 10 then wanted[#wanted + 1] = n end
    end
    assert(#wanted > 600)
    local function unit(k, lmax)
      local c = {}
      for i = 1, (lmax + 1) ^ 2 do c[i] = i == k + 1 and 1 or 0 end
      return c
    end
    local sum = 0
    for _, n in ipairs(wanted) do
      local lmax = math.max(n[4], n[6], n[8])
      local method = lmax <= 5 and "gaunt" or "quadrature"
      local c = ylm.sh.product(unit(n[1], lmax), unit(n[2], lmax), { method = method })
      assert.is_near(n[10], c[n[3] + 1], 1e-14)
      -- ordered triples of the list to l = 5, in the plan's count of i <= j, any k
      if lmax <= 5 then
        local i, j, k = n[1], n[2], n[3]
        sum = sum + ((i == j and j == k) and 1 or (i == j or j == k) and 2 or 3)
      end
    end
    assert.equal(sum, (select(2, ylm.sh.product_method(5, 2, "gaunt"))))
  end)

  for _, method in ipairs { "auto", "quadrature", "fourier", "gaunt", "brute", "list" } do
    it("agrees with the reference vectors, double to 1e-13 and float to 1e-6, by method " .. method, function()
      local seen = 0
      for _, set in ipairs(reference()) do
        local k = #set.factors
        local combinations, top = set.n ^ (2 * k), math.floor((k + 1) / 2) * (set.n - 1)
        if (method ~= "gaunt" or top <= 30) and (method ~= "brute" or combinations <= 70000)
          and (method ~= "list" or k == 2 and set.n <= 8) then
          seen = seen + 1
          local exact = ylm.array(set.exact)
          local c = multiply(set.factors, { method = method })
          assert(relative(c, exact) < 1e-13, ("n %d k %d: %g"):format(set.n, k, relative(c, exact)))
          local f = multiply(set.factors, { method = method, dtype = "float" })
          assert.equal("float", f.dtype)
          assert(relative(f, exact) < 3e-6, ("n %d k %d: %g"):format(set.n, k, relative(f, exact)))
        end
      end
      assert(seen >= (method == "list" and 2 or 4))
    end)
  end

  it("agrees with the reference's recursive approximation, whatever its steps are done by", function()
    for _, set in ipairs(reference()) do
      if set.truncated then
        for _, inner in ipairs { "auto", "gaunt", "fourier", "quadrature" } do
          local c = multiply(set.factors, { method = "recursive", inner = inner })
          assert(relative(c, ylm.array(set.truncated)) < 1e-13, set.n)
        end
      end
    end
  end)

  it("carries sparse tables through as many factors as reach degree 30", function()
    for _, case in ipairs { { 3, 15 }, { 4, 9 }, { 5, 6 }, { 6, 4 }, { 7, 3 }, { 16, 1 } } do
      local k, lmax = case[1], case[2]
      local factors = {}
      for i = 1, k do factors[i] = random_vectors(1, lmax) end
      local q = multiply(factors, { method = "quadrature" })
      assert(relative(multiply(factors, { method = "gaunt" }), q) < 1e-12, k .. " factors, seed " .. seed)
      assert(relative(multiply(factors, { method = "gaunt", dtype = "float" }), q) < 1e-5, k .. " factors, seed " .. seed)
    end
  end)

  it("agrees between its methods to n = 20, and with a rule for more factors", function()
    for _, lmax in ipairs { 10, 12, 15, 19 } do
      local a, b = random_vectors(1, lmax), random_vectors(1, lmax)
      local q = ylm.sh.product(a, b, { method = "quadrature" })
      assert(relative(ylm.sh.product(a, b, { method = "fourier" }), q) < 1e-13, "seed " .. seed)
      local one = ylm.sh.resize({ math.sqrt(4 * math.pi) }, lmax)
      assert(relative(ylm.sh.product(a, b, one, one, { method = "quadrature" }), q) < 1e-13, "seed " .. seed)
      assert(relative(ylm.sh.product(ylm.array(a, "float"), (ylm.array(b, "float"))), q) < 1e-5, "seed " .. seed)
    end
  end)

  for _, lmax in ipairs { 0, 1, 2, 3, 4, 5, 6, 7, 9, 11, 14, 19 } do
    it("multiplies batches as it does single rows, lmax " .. lmax, function()
      for _, dtype in ipairs { "float", "double" } do
        local tolerance = dtype == "float" and 1e-6 or 1e-14
        local n = lmax > 11 and 25 or 70
        local a, b, c = random_vectors(n, lmax, dtype), random_vectors(n, lmax, dtype), random_vectors(1, lmax, dtype)
        local all = ylm.sh.product(a, b, c, { threads = 1 })
        assert.equal(0, (core.array_distance(all, ylm.sh.product(a, b, c, { threads = 2 }))))
        for _, r in ipairs { 1, 16, 25, 33, 64, 65, 70 } do
          if r > n then break end
          local one = ylm.sh.product(a[r], b[r], c[1], { method = "quadrature" })
          assert(relative(all[r], one) < tolerance * 10, "seed " .. seed)
        end
        for _, rows in ipairs { 1, 3, 7, n } do -- two factors, batches that do not fill the lanes
          local x, y = random_vectors(rows, lmax, dtype), random_vectors(rows, lmax, dtype)
          local pairs_ = ylm.sh.product(x, y)
          for r = 1, rows, 3 do
            local one = ylm.sh.product(x[r], y[r], { method = "fourier" })
            assert(relative(pairs_[r], one) < tolerance * 10, "seed " .. seed)
          end
        end
      end
    end)
  end

  it("broadcasts, keeps the type asked for, and writes where it is told", function()
    local a = random_vectors(6, 2):reshape { 2, 3, 9 }
    local b = random_vectors(1, 2, "float")[1]
    local c = ylm.sh.product(a, b)
    assert.same({ 2, 3, 9 }, c.shape)
    assert.equal("double", c.dtype)
    local out = ylm.zeros({ 2, 3, 9 }, "float")
    assert.equal(out, ylm.sh.product(b, a, { out = out, dtype = "float" }))
    assert(relative(out, c) < 1e-6)
  end)

  it("reports progress, stops when told to, and keeps its factors open meanwhile", function()
    local a, last = random_vectors(300, 5), nil
    local whole = ylm.sh.product(a, a, { progress = function(done, total, stage) last = { done, total, stage } end })
    assert.same({ 300, 300, "product" }, last)
    assert.equal(0, (core.array_distance(whole, (ylm.sh.product(a, a)))))
    assert.same({ nil, "cancelled", "ECANCELLED" }, { ylm.sh.product(a, a, { progress = function() return false end }) })
    assert.has_error(function() ylm.sh.product(a, a, { progress = function() a:close() end }) end)
    local M = ylm.sh.product_matrix(a[1], 5)
    assert.same({ nil, "cancelled", "ECANCELLED" },
      { ylm.sh.apply(M, a, { progress = function() return false end }) })
  end)

  it("tells the time of its stages", function()
    local a = random_vectors(50, 7)
    local _, seconds = ylm.sh.product(a, a, { method = "fourier", stages = true })
    assert.equal(3, #seconds)
    assert(seconds[1] > 0 and seconds[2] > 0 and seconds[3] > 0)
  end)
end)

describe("ylm.sh.product_matrix", function()
  it("multiplies by its function; of Y(2,2) at lmax 4 it has the entries of Green's Fig. 9", function()
    math.randomseed(seed)
    local y22 = { 0, 0, 0, 0, 0, 0, 0, 0, 1 }
    local M = ylm.sh.product_matrix(y22, 4)
    local nonzero = 0
    for i = 1, 25 do
      for j = 1, 25 do
        if math.abs(M:get(i, j)) > 1e-12 then nonzero = nonzero + 1 end
        assert.equal(M:get(i, j), M:get(j, i))
      end
    end
    -- counted from the integrals of the reference with k = (2, 2)
    local wanted = 0
    for line in io.lines "spec/data/gaunt.txt" do
      local n = {}
      for w in line:gmatch "%S+" do n[#n + 1] = tonumber(w) end
      if line:match "^%d" and math.max(n[4], n[6], n[8]) <= 4 then
        local others = {}
        for q = 1, 3 do if n[q] == 8 then others[#others + 1] = q end end
        if #others > 0 then
          local a, b = n[others[1] % 3 + 1], n[(others[1] + 1) % 3 + 1]
          wanted = wanted + (a == b and 1 or 2)
        end
      end
    end
    assert.equal(wanted, nonzero)
    local c = random_vectors(3, 4)
    assert(relative(ylm.sh.apply(M, c), ylm.sh.product(c, ylm.sh.resize(y22, 4))) < 1e-14)
  end)

  it("is applied to batches of any number of rows", function()
    math.randomseed(seed)
    for _, lmax in ipairs { 0, 1, 3, 5, 8 } do
      local b = random_vectors(1, lmax)[1]
      for _, dtype in ipairs { "float", "double" } do
        local M = ylm.sh.product_matrix(b, lmax, { dtype = dtype })
        for _, rows in ipairs { 1, 7, 8, 70 } do
          local c = random_vectors(rows, lmax, dtype)
          assert(relative(ylm.sh.apply(M, c, { threads = 2 }), ylm.sh.product(c, ylm.array(b, dtype)))
            < (dtype == "float" and 2e-6 or 1e-13), "seed " .. seed)
        end
      end
    end
  end)

  it("applies one matrix of any shape, and one to each of many vectors", function()
    math.randomseed(seed)
    local function matrices(...)
      local shape, count = { ... }, 1
      for _, extent in ipairs(shape) do count = count * extent end
      local flat = {}
      for i = 1, count do flat[i] = 2 * math.random() - 1 end
      return ylm.array(flat):reshape(shape), flat
    end
    --- Row `row` of `flat` matrices axb times the vector at `from` of `v`, number k.
    local function wanted(flat, b, row, v, from)
      local s = 0
      for i = 1, b do s = s + flat[row * b + i] * v[from + i] end
      return s
    end
    local apply, n, a, b = ylm.sh.apply, 5, 9, 25
    local one, entries = matrices(a, b)
    local square, corners = matrices(9, 9) -- not symmetric
    local c, v = matrices(n, 3, b)
    local small, w = matrices(n, 9)
    local many, all = matrices(n, a, b)
    local channels, each = matrices(n, 3, a, b)
    local function near(x, y) assert.is_near(x, y, 1e-12) end
    for i = 0, n - 1 do
      for k = 0, a - 1 do
        near(wanted(corners, 9, k, w, 9 * i), apply(square, small):get(i + 1, k + 1))
        near(wanted(all, b, i * a + k, v, 0), apply(many, c[1][1]:clone()):get(i + 1, k + 1))
        near(wanted(all, b, i * a + k, v, (3 * i + 1) * b), apply(many, c):get(i + 1, 2, k + 1))
        for r = 0, 2 do
          near(wanted(entries, b, k, v, (3 * i + r) * b), apply(one, c):get(i + 1, r + 1, k + 1))
          local row = (3 * i + r) * a + k
          near(wanted(each, b, row, v, (3 * i + r) * b), apply(channels, c):get(i + 1, r + 1, k + 1))
          near(wanted(each, b, row, v, r * b), apply(channels, c[1]:clone()):get(i + 1, r + 1, k + 1))
          near(wanted(each, b, row, v, 0), apply(channels, c[1][1]:clone()):get(i + 1, r + 1, k + 1))
        end
      end
    end
    local f = apply(ylm.array(channels, "float"), ylm.array(c, "float"), { threads = 2 })
    assert(relative(ylm.array(f, "double"), apply(channels, c)) < 1e-6)
    assert.same({ nil, "cancelled", "ECANCELLED" }, { apply(many, c, { progress = function() return false end }) })
  end)

  it("takes functions of higher degree than the vectors, which matter up to twice their lmax", function()
    math.randomseed(seed)
    local b, c = random_vectors(1, 9), random_vectors(5, 3)
    local M = ylm.sh.product_matrix(b[1], 3)
    local wide = ylm.sh.product(ylm.sh.resize(c, 9), b)
    assert(relative(ylm.sh.apply(M, c), ylm.sh.resize(wide, 3)) < 1e-13)
    assert(relative(ylm.sh.product_matrix(ylm.sh.resize(b[1], 6), 3), M) < 1e-14)
    local f = ylm.sh.product_matrix(b[1], 3, { dtype = "float" })
    assert(relative(ylm.sh.apply(f, ylm.array(c, "float")), ylm.sh.resize(wide, 3)) < 1e-5)
  end)
end)
