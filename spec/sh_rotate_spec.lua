local core = require "ylm.c.core"
local ylm = require "ylm"

local seed = tonumber(os.getenv "YLM_SEED") or 20261121

--- Rotations of spec/data/rotation.txt: { matrix =, kind =, blocks = { [l] = rows } }.
local function reference()
  local list
  local sets = {}
  for line in io.lines "spec/data/rotation.txt" do
    local words = {}
    for w in line:gmatch "%S+" do words[#words + 1] = w end
    if words[1] == "Q" then
      local n = {}
      for i = 4, #words do n[#n + 1] = tonumber(words[i]) end
      list = { kind = words[3], quaternion = { n[1], n[2], n[3], n[4] },
        matrix = { { n[5], n[6], n[7] }, { n[8], n[9], n[10] }, { n[11], n[12], n[13] } }, blocks = {} }
      sets[#sets + 1] = list
    elseif words[1] == "M" then
      local l, row = tonumber(words[3]), {}
      for i = 5, #words do row[#row + 1] = tonumber(words[i]) end
      list.blocks[l] = list.blocks[l] or {}
      table.insert(list.blocks[l], row)
    end
  end
  return sets
end

local vectors = require "spec.support.vectors"
local relative = vectors.relative

local function random_vectors(...)
  math.randomseed(seed)
  return vectors.random(...)
end

--- The 24 rotations of the cube, as matrices of whole numbers.
local function cube_rotations()
  local list = {}
  for _, p in ipairs { { 1, 2, 3, 1 }, { 2, 3, 1, 1 }, { 3, 1, 2, 1 }, { 1, 3, 2, -1 }, { 2, 1, 3, -1 }, { 3, 2, 1, -1 } } do
    for _, x in ipairs { 1, -1 } do
      for _, y in ipairs { 1, -1 } do
        local m = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }
        m[1][p[1]], m[2][p[2]], m[3][p[3]] = x, y, x * y * p[4]
        list[#list + 1] = m
      end
    end
  end
  return list
end

--- A cube rotation as people write it: rounded angles, axes and quaternions of unit length.
local function descriptions(m)
  local atan2 = math.atan2 or math.atan -- luacheck: ignore 143
  local trace = m[1][1] + m[2][2] + m[3][3]
  local angle = math.acos((trace - 1) / 2)
  local axis = { m[3][2] - m[2][3], m[1][3] - m[3][1], m[2][1] - m[1][2] }
  if trace == 3 then axis = { 0, 0, 1 } end
  if trace == -1 then
    -- R + I is twice the axis times itself
    for j = 1, 3 do
      local column = { m[1][j], m[2][j], m[3][j] }
      column[j] = column[j] + 1
      if column[j] > 0 then axis = column end
    end
  end
  local n = math.sqrt(axis[1] ^ 2 + axis[2] ^ 2 + axis[3] ^ 2)
  local unit, quaternion = {}, { math.cos(angle / 2) }
  for i = 1, 3 do unit[i], quaternion[i + 1] = axis[i] / n, math.sin(angle / 2) * axis[i] / n end
  local zyz = { atan2(m[2][3], m[1][3]), math.acos(m[3][3]), atan2(m[3][2], -m[3][1]) }
  if m[3][3] ~= 0 then zyz = { atan2(m[3][3] * m[2][1], m[3][3] * m[1][1]), math.acos(m[3][3]), 0 } end
  -- by axis and angle, as a matrix with the rounding of sine and cosine in it
  local c, s, rounded = math.cos(angle), math.sin(angle), {}
  for i = 1, 3 do
    rounded[i] = {}
    for j = 1, 3 do
      local k = 6 - i - j
      local cross = i == j and 0 or ((j - i) % 3 == 1 and -1 or 1) * unit[k]
      rounded[i][j] = (1 - c) * unit[i] * unit[j] + (i == j and c or 0) + s * cross
    end
  end
  return { axis = { axis = axis, angle = angle }, unit = { axis = unit, angle = angle },
    quaternion = { quaternion = quaternion }, zyz = { zyz = zyz }, matrix = rounded }
end

describe("ylm.sh.rotate", function()
  it("turns functions as R turns vectors: a lobe along z, turned about x by 90 degrees, looks along -y", function()
    local c = ylm.sh.rotate(ylm.sh.eval(3, { 0, 0, 1 }), { axis = { 1, 0, 0 }, angle = math.pi / 2 })
    assert(relative(c, ylm.sh.eval(3, { 0, -1, 0 })) < 1e-15)
  end)

  it("takes matrices, axes, quaternions and ZYZ angles of the same rotation", function()
    local c = random_vectors(2, 5)
    local a, b, g = 0.3, 1.1, -0.7
    local wanted = ylm.sh.rotate(ylm.sh.rotate(ylm.sh.rotate(c, { axis = { 0, 0, 1 }, angle = g }),
      { axis = { 0, 2, 0 }, angle = b }), { axis = { 0, 0, 1 }, angle = a })
    assert(relative(ylm.sh.rotate(c, { zyz = { a, b, g } }), wanted) < 1e-14)
    local q = { 0.5, -0.1, 0.7, 0.2 }
    local n = math.sqrt(q[1] ^ 2 + q[2] ^ 2 + q[3] ^ 2 + q[4] ^ 2)
    local by_axis = ylm.sh.rotate(c, { axis = { q[2], q[3], q[4] }, angle = 2 * math.acos(q[1] / n) })
    local by_quaternion = ylm.sh.rotate(c, { quaternion = q })
    assert(relative(by_axis, by_quaternion) < 1e-14)
    local object = ylm.sh.rotation(5, { quaternion = q })
    assert(relative(ylm.sh.rotate(c, ylm.array(object.matrix)), by_quaternion) < 1e-14)
    assert(relative(ylm.sh.rotate(c, object), by_quaternion) < 1e-14)
  end)

  it("rotates back exactly for quarter turns and identity", function()
    local c = random_vectors(1, 8)
    local same = ylm.sh.rotate(c, { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } })
    assert.equal(0, (core.array_distance(same, c)))
    local back = c
    for _ = 1, 4 do back = ylm.sh.rotate(back, { axis = { 0, 0, 1 }, angle = math.pi / 2 }) end
    assert.equal(0, (core.array_distance(back, c)))
    for _ = 1, 2 do back = ylm.sh.rotate(back, { axis = { 1, 0, 0 }, angle = math.pi }) end
    for _ = 1, 2 do back = ylm.sh.rotate(back, { axis = { 0, 1, 0 }, angle = math.pi }) end
    assert.equal(0, (core.array_distance(back, c)))
    -- the turns that exchange z with another axis hold roots: exact is the nearest double of each
    local e = ylm.sh.rotation(2, { axis = { 1, 0, 0 }, angle = math.pi / 2 }):block(2):totable()
    assert.same({ 0, 0, 0, 1, 0 }, e[1])
    assert.same({ 0, -1, 0, 0, 0 }, e[2])
    assert.same({ 0, 0, -0.5, 0, -math.sqrt(0.75) }, e[3])
  end)

  it("knows the cube's 24 rotations from matrices, axes, quaternions and ZYZ angles", function()
    local list = cube_rotations()
    assert.equal(24, #list)
    for _, m in ipairs(list) do
      local exact = ylm.sh.rotation(8, m)
      assert.same(m, exact.matrix)
      for kind, r in pairs(descriptions(m)) do
        local same = ylm.sh.rotation(8, r)
        assert.same(m, same.matrix, kind)
        for l = 0, 8 do assert.same(exact:block(l):totable(), same:block(l):totable()) end
      end
      -- degree 1 is m itself, of (-y, z, -x)
      local block, axis, sign = exact:block(1), { 2, 3, 1 }, { -1, 1, -1 }
      for i = 1, 3 do
        for j = 1, 3 do assert.equal(sign[i] * sign[j] * m[axis[i]][axis[j]], block:get(i, j)) end
      end
    end
  end)

  it("comes back after four quarter turns about any axis, to 6 units in the last place of the largest", function()
    for dtype, unit in pairs { double = 2 ^ -52, float = 2 ^ -23 } do
      for _, lmax in ipairs { 3, 6, 12 } do
        local c = random_vectors(20, lmax, dtype)
        for _, axis in ipairs { { 1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 } } do
          local r = ylm.sh.rotation(lmax, { axis = axis, angle = math.pi / 2 }, { dtype = dtype })
          local one, all = c[1], c
          for _ = 1, 4 do one, all = ylm.sh.rotate(one, r), ylm.sh.rotate(all, r) end
          assert((core.array_distance(one, c[1])) <= 6 * unit, "seed " .. seed)
          assert((core.array_distance(all, c)) <= 6 * unit, "seed " .. seed)
        end
      end
    end
  end)

  it("has the roots and zeros of quarter turns to the last place, to degree 128", function()
    local r = ylm.sh.rotation(128, { axis = { 1, 0, 0 }, angle = math.pi / 2 })
    for _, l in ipairs { 1, 2, 5, 8, 31, 64, 128 } do
      -- its entries (q, +-l) are sqrt of a binomial distribution, down to 2^-l
      local block, p = r:block(l), 1
      for k = 1, l do p = p * (2 * k - 1) / (2 * k) end
      for q = 0, l do
        local seen = 0
        for _, at in ipairs { { q, l }, { q, -l }, { -q, l }, { -q, -l } } do
          seen = math.max(seen, math.abs(block:get(l + 1 + at[1], l + 1 + at[2])))
        end
        assert.is_near(1, seen / math.sqrt((q == 0 and 2 or 4) * p), 1e-14)
        p = p * (l - q) / (l + q + 1)
      end
    end
    -- zeros that no symmetry asks for
    for _, at in ipairs { { 8, 2, 6 }, { 8, 6, 2 }, { 11, 4, 8 }, { 32, 4, 30 } } do
      local l, block = at[1], r:block(at[1])
      for _, s in ipairs { { 1, 1 }, { 1, -1 }, { -1, 1 }, { -1, -1 } } do
        assert.equal(0, block:get(l + 1 + s[1] * at[2], l + 1 + s[2] * at[3]))
      end
    end
  end)

  it("turns the basis as eval does, to degree 128", function()
    local p = { 0.36, -0.48, 0.8 }
    local r = ylm.sh.rotation(128, { quaternion = { 0.7, -0.4, 0.3, 0.6 } })
    local moved = {}
    for i = 1, 3 do moved[i] = r.matrix[i][1] * p[1] + r.matrix[i][2] * p[2] + r.matrix[i][3] * p[3] end
    local error = relative(ylm.sh.rotate(ylm.sh.eval(128, p), r), ylm.sh.eval(128, moved))
    assert(error < 1e-13, error)
  end)

  it("is orthogonal and composes, to degree 60", function()
    local lmax = 60
    local c = random_vectors(3, lmax)
    local r1, r2 = { quaternion = { 0.3, 0.8, -0.2, 0.4 } }, { quaternion = { -0.6, 0.1, 0.5, 0.9 } }
    local m1, m2 = ylm.sh.rotation(lmax, r1), ylm.sh.rotation(lmax, r2)
    local product = {}
    for i = 1, 3 do
      product[i] = {}
      for j = 1, 3 do
        product[i][j] = 0
        for k = 1, 3 do product[i][j] = product[i][j] + m2.matrix[i][k] * m1.matrix[k][j] end
      end
    end
    local twice, once = ylm.sh.rotate(ylm.sh.rotate(c, m1), m2), ylm.sh.rotate(c, product)
    assert(relative(twice, once) < 1e-13, relative(twice, once))
    local inverse = { quaternion = { 0.3, -0.8, 0.2, -0.4 } }
    assert(relative(ylm.sh.rotate(ylm.sh.rotate(c, r1), inverse), c) < 1e-13)
    local M = m1:block(60):totable()
    local worst = 0
    for i = 1, 121, 7 do
      for j = 1, 121 do
        local sum = i == j and -1 or 0
        for k = 1, 121 do sum = sum + M[i][k] * M[j][k] end
        worst = math.max(worst, math.abs(sum))
      end
    end
    assert(worst < 1e-13, worst)
  end)

  it("stays accurate where an angle vanishes: turns by 1e-3 .. 1e-12 about x, next to half turns", function()
    local lmax = 20
    local c = random_vectors(1, lmax)
    for _, angle in ipairs { 1e-3, 1e-6, 1e-9, 1e-12, math.pi - 1e-9, math.pi + 1e-5 } do
      local r = { axis = { 0.6, 0.8, 0 }, angle = angle }
      assert(relative(ylm.sh.rotate(c, r), ylm.sh.rotate(c, r, { method = "reference" })) < 1e-13, angle)
    end
  end)

  it("agrees with the reference vectors to 1e-14, one at a time and by blocks", function()
    for _, set in ipairs(reference()) do
      local object = ylm.sh.rotation(6, set.matrix)
      for l = 0, 6 do
        assert(relative(object:block(l), ylm.array(set.blocks[l])) < 1e-14, set.kind)
      end
      local unit = {}
      for k = 1, 49 do
        unit[k] = {}
        for i = 1, 49 do unit[k][i] = i == k and 1 or 0 end
      end
      local one = ylm.sh.rotate(unit[49], { quaternion = set.quaternion })
      for q = 1, 13 do assert.is_near(set.blocks[6][q][13], one[36 + q], 1e-14) end
      local all = ylm.sh.rotate(unit, set.matrix)
      for q = 1, 13 do assert.is_near(set.blocks[6][q][1], all:get(37, 36 + q), 1e-14) end
    end
  end)

  for _, lmax in ipairs { 0, 1, 2, 3, 4, 5, 6, 7, 9, 15, 16, 19, 33, 60 } do
    it("agrees with the recurrence of Ivanic & Ruedenberg at lmax " .. lmax .. ", in both types", function()
      local r = { quaternion = { 0.7, -0.4, 0.3, 0.6 } }
      local c = random_vectors(7, lmax)
      local wanted = ylm.sh.rotate(c, r, { method = "reference" })
      local single = ylm.array(c, "float")
      assert(relative(ylm.sh.rotate(c[3], r), wanted[3]) < 1e-13)
      assert(relative(ylm.sh.rotate(single[3], r), wanted[3]) < 1e-6)
      assert(relative(ylm.sh.rotate(c, ylm.sh.rotation(lmax, r)), wanted) < 1e-13)
      assert(relative(ylm.sh.rotate(single, ylm.sh.rotation(lmax, r, { dtype = "float" })), wanted) < 1e-6)
    end)
  end

  for _, rows in ipairs { 1, 3, 4, 31, 32, 33, 70 } do
    it("rotates batches of " .. rows .. " as it does single rows, exact turns too, in place as well", function()
      for _, dtype in ipairs { "float", "double" } do
        local lmax = 23
        local c = random_vectors(rows, lmax, dtype)
        for _, r in ipairs { { quaternion = { 0.7, -0.4, 0.3, 0.6 } }, { axis = { 0, 0, 1 }, angle = 0.3 },
          { axis = { 1, 0, 0 }, angle = math.pi }, { axis = { 1, 0, 0 }, angle = -math.pi / 2 },
          { axis = { 1, 1, 1 }, angle = 2 * math.pi / 3 } } do
          local all = ylm.sh.rotate(c, ylm.sh.rotation(lmax, r, { dtype = dtype }), { threads = 1 })
          for i = 1, rows, 7 do
            local wanted = ylm.sh.rotate(ylm.array(c[i], "double"), r, { method = "reference" })
            assert(relative(all[i], wanted) < (dtype == "float" and 1e-6 or 1e-13), "seed " .. seed)
          end
          local same = c:clone()
          ylm.sh.rotate(same, ylm.sh.rotation(lmax, r, { dtype = dtype }), { out = same })
          assert.equal(0, (core.array_distance(same, all)))
        end
      end
    end)
  end

  it("does not depend on the number of threads and writes where it is told", function()
    local c = random_vectors(1000, 4, "float")
    local r = ylm.sh.rotation(4, { zyz = { 1, 2, 3 } }, { dtype = "float" })
    local out = ylm.zeros({ 1000, 25 }, "float")
    assert.equal(out, ylm.sh.rotate(c, r, { threads = 2, out = out }))
    assert.equal(0, (core.array_distance(out, ylm.sh.rotate(c, r, { threads = 1 }))))
  end)

  it("reports progress, and stops when told to", function()
    local c = random_vectors(600, 4)
    local object = ylm.sh.rotation(4, { zyz = { 1, 2, 3 } })
    for _, r in ipairs { object, { zyz = { 1, 2, 3 } } } do
      local last
      ylm.sh.rotate(c, r, { progress = function(done, total, stage) last = { done, total, stage } end })
      assert.same({ 600, 600, "rotate" }, last)
      assert.same({ nil, "cancelled", "ECANCELLED" }, { ylm.sh.rotate(c, r, { progress = function() return false end }) })
    end
    assert.same({ nil, "cancelled", "ECANCELLED" },
      { ylm.sh.convert(c, "plain", { progress = function() return false end }) })
    assert.same({ nil, "cancelled", "ECANCELLED" },
      { ylm.sh.reconstruct(c, ylm.array { { 1, 2, 3 }, { 0, 0, 1 } }, { progress = function() return false end }) })
  end)

  it("keeps shape, type and convention", function()
    local c = ylm.sh.convert(ylm.array({ { { 1, 2, 3, 4 } } }, "float"), "ylm irradiance")
    local turned = ylm.sh.rotate(c, { zyz = { 0, 1, 0 } })
    assert.same({ 1, 1, 4 }, turned.shape)
    assert.equal("float", turned.dtype)
    assert.equal("ylm irradiance", turned.convention)
  end)

  describe("with a rotation for each row", function()
    local function random_quaternions(n)
      local list = {}
      for i = 1, n do
        local q = {}
        for k = 1, 4 do q[k] = 2 * math.random() - 1 end
        list[i] = q
      end
      return list
    end

    --- Frames [n][3][3] of quaternions, an identity and turns that leave z or turn it over, or turn by little.
    local function frames(n, dtype)
      local list = {}
      for i, q in ipairs(random_quaternions(n)) do
        if i % 7 == 1 then q = ({ { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 0, 0, 1 }, { 1, 1e-4, 0, 0 }, { 1, 0, 0, 1 },
          { 0, 1, 1e-5, 0 }, { 1, 1, 0, 0 } })[(i - 1) / 7 % 7 + 1] end
        list[i] = ylm.sh.rotation(0, { quaternion = q }).matrix
      end
      return ylm.array(list, dtype), list
    end

    --- The largest distance of rows relative to their norm.
    local function worst(got, expected)
      local most = 0
      for i = 1, #got do most = math.max(most, relative(ylm.array(got[i]:totable()), expected[i])) end
      return most
    end

    for _, case in ipairs { { 0, 1 }, { 1, 70 }, { 4, 131 }, { 6, 17 }, { 7, 33 }, { 9, 40 }, { 14, 65 }, { 20, 50 },
      { 60, 9 } } do
      it(("turns %d rows of degree %d as one by one, in both types"):format(case[2], case[1]), function()
        local lmax, n = case[1], case[2]
        for dtype, limit in pairs { double = 1e-13, float = lmax > 20 and 5e-6 or 2e-6 } do
          local c = random_vectors(n, lmax, dtype)
          local r = frames(n, dtype)
          local got, expected = ylm.sh.rotate(c, r), {}
          for i = 1, n do
            expected[i] = ylm.sh.rotate(ylm.array(c[i]:totable()), ylm.sh.rotation(lmax, r[i]:totable()))
          end
          assert.is_true(worst(got, expected) <= limit)
        end
      end)
    end

    it("turns the rows of one frame alike, in place too, whatever the number of threads", function()
      local n, lmax = 300, 5
      local rows, r = {}, frames(n, "float")
      for i = 1, n do rows[i] = random_vectors(3, lmax, "float"):totable() end
      local c = ylm.array(rows, "float")
      local got = ylm.sh.rotate(c, r, { threads = 1 })
      assert.same({ n, 3, 36 }, got.shape)
      local second = {}
      for i = 1, n do second[i] = rows[i][2] end
      local alone = ylm.sh.rotate(ylm.array(second, "float"), r)
      for i = 1, n do assert.equal(0, (core.array_distance(alone[i], got[i][2]))) end
      ylm.sh.rotate(c, r, { threads = 2, out = c })
      assert.equal(0, (core.array_distance(c, got)))
    end)

    it("names the row whose frame is no rotation", function()
      local r, list = frames(40, "double")
      local c = random_vectors(40, 2)
      r:set(33, 2, 2, 5)
      assert.error_matches(function() ylm.sh.rotate(c, r) end, "rotation 33 is none: its columns must be orthonormal to 0.001")
      list[12] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, -1 } }
      assert.error_matches(function() ylm.sh.rotate(c, ylm.array(list)) end, "rotation 12 is none")
      list[3][1][1] = 0 / 0
      assert.error_matches(function() ylm.sh.rotate(c, ylm.array(list)) end, "rotation 3 is none")
      assert.error_matches(function() ylm.sh.rotate(random_vectors(7, 2), r) end, "40 rotations, 7 rows")
      assert.error_matches(function() ylm.sh.rotate(random_vectors(40, 61), r) end, "lmax up to 60 expected")
    end)

    it("is as orthonormal as its frames: those that are off by 1e-4 keep the norm", function()
      local r = frames(20, "double")
      local c = random_vectors(20, 4)
      for i = 1, 20 do r:set(i, 1, 1, r:get(i, 1, 1) + 1e-4) end
      local got = ylm.sh.rotate(c, r)
      local function norm(a)
        local sum = 0
        for _, x in ipairs(a:totable()) do sum = sum + x * x end
        return math.sqrt(sum)
      end
      for i = 1, 20 do assert.near(1, norm(got[i]) / norm(c[i]), 1e-12) end
    end)
  end)
end)
