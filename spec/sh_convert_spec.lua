local core = require "ylm.c.core"
local ylm = require "ylm"

local pi = math.pi

--- Coefficients 1 .. n.
local function counting(n)
  local c = {}
  for i = 1, n do c[i] = i * (i % 3 == 0 and -1 or 1) / 7 end
  return c
end

--- The function that coefficients of ylm stand for, at a direction.
local function value(c, v) return ylm.sh.reconstruct(c, v) end

local directions = { { 0.36, 0.48, 0.8 }, { -0.6, 0, 0.8 }, { 0.48, -0.64, -0.6 }, { 0, 1, 0 } }

--- Y without phase from explicit formulas to l = 3, in the order l(l+1)+m+1 (the table of docs/conventions.md).
local function plain_basis(v)
  local x, y, z = v[1], v[2], v[3]
  local s = math.sqrt
  return { s(1 / (4 * pi)), s(3 / (4 * pi)) * y, s(3 / (4 * pi)) * z, s(3 / (4 * pi)) * x,
    s(15 / (4 * pi)) * x * y, s(15 / (4 * pi)) * y * z, s(5 / (16 * pi)) * (3 * z * z - 1), s(15 / (4 * pi)) * x * z,
    s(15 / (16 * pi)) * (x * x - y * y),
    s(35 / (32 * pi)) * y * (3 * x * x - y * y), s(105 / (4 * pi)) * x * y * z, s(21 / (32 * pi)) * y * (5 * z * z - 1),
    s(7 / (16 * pi)) * z * (5 * z * z - 3), s(21 / (32 * pi)) * x * (5 * z * z - 1),
    s(105 / (16 * pi)) * z * (x * x - y * y), s(35 / (32 * pi)) * x * (x * x - 3 * y * y) }
end

local function dot(a, b)
  local sum = 0
  for i = 1, #a do sum = sum + a[i] * b[i] end
  return sum
end

describe("ylm.sh.convert", function()
  it("to 'plain': no Condon-Shortley phase, the formulas of the table to l = 3", function()
    local c = counting(16)
    local p = ylm.sh.convert(c, "plain")
    assert.equal("plain", p.convention)
    for _, v in ipairs(directions) do assert.is_near(value(c, v), dot(p:totable(), plain_basis(v)), 1e-14) end
    -- sphericart: l = 1 is sqrt(3/4pi) (y, z, x)
    assert.equal("plain", ylm.sh.convert(c, "sphericart").convention)
  end)

  it("to 'n3d' and 'sn3d': a plane wave of ambisonics has the signals 1, sqrt 3 y, .. and 1, y, z, x", function()
    local v = directions[1]
    local wave = ylm.sh.eval(3, v) -- a delta in direction v
    local n3d, sn3d = ylm.sh.convert(wave, "n3d"):totable(), ylm.sh.convert(wave, "sn3d"):totable()
    local x, y, z = v[1], v[2], v[3]
    for i, wanted in ipairs { 1, y, z, x, math.sqrt(3) * x * y, math.sqrt(3) * y * z, 0.5 * (3 * z * z - 1),
      math.sqrt(3) * x * z, math.sqrt(3) / 2 * (x * x - y * y), math.sqrt(5 / 8) * y * (3 * x * x - y * y) } do
      assert.is_near(wanted, sn3d[i], 1e-14)
    end
    for i, wanted in ipairs { 1, math.sqrt(3) * y, math.sqrt(3) * z, math.sqrt(3) * x, math.sqrt(15) * x * y } do
      assert.is_near(wanted, n3d[i], 1e-14)
    end
  end)

  it("to 'scipy': f = sum of a sph_harm(m, l), with Y(1,1) = -sqrt(3/8pi) (x + iy)", function()
    local c = counting(9)
    local a = ylm.sh.convert(c, "scipy")
    assert.same({ 9, 2 }, a.shape)
    for _, v in ipairs(directions) do
      local x, y, z = v[1], v[2], v[3]
      local s1, s2 = math.sqrt(3 / (8 * pi)), math.sqrt(15 / (32 * pi))
      local Y = { { math.sqrt(1 / (4 * pi)), 0 }, { s1 * x, -s1 * y }, { math.sqrt(3 / (4 * pi)) * z, 0 }, { -s1 * x,
        -s1 * y },
        { s2 * (x * x - y * y), -2 * s2 * x * y }, { 2 * s2 * x * z, -2 * s2 * y * z },
        { math.sqrt(5 / (16 * pi)) * (3 * z * z - 1), 0 }, { -2 * s2 * x * z, -2 * s2 * y * z },
        { s2 * (x * x - y * y), 2 * s2 * x * y } }
      local re, im = 0, 0
      for i = 1, 9 do
        local ar, ai = a:get(i, 1), a:get(i, 2)
        re, im = re + ar * Y[i][1] - ai * Y[i][2], im + ar * Y[i][2] + ai * Y[i][1]
      end
      assert.is_near(value(c, v), re, 1e-14)
      assert.is_near(0, im, 1e-14)
    end
  end)

  it("to 'unity': SHAr .. SHC give irradiance/pi, with the constants that Sloan printed in 2008", function()
    local rgb = { counting(9), counting(9), { 9, 8, 7, 6, 5, 4, 3, 2, 1 } }
    local u = ylm.sh.convert(rgb, "unity"):totable()
    assert.equal(7, #u)
    -- Stupid SH Tricks, A10: fC0 .. fC4 with a basis that has the phase, as ours
    local c, root = rgb[3], math.sqrt(pi)
    local C0, C1, C2, C3 = 1 / (2 * root), math.sqrt(3) / (3 * root), math.sqrt(15) / (8 * root),
      math.sqrt(5) / (16 * root)
    local A = { -C1 * c[4], -C1 * c[2], C1 * c[3], C0 * c[1] - C3 * c[7] }
    local B = { C2 * c[5], -C2 * c[6], 3 * C3 * c[7], -C2 * c[8] }
    for i = 1, 4 do
      assert.is_near(A[i], u[3][i], 1e-15)
      assert.is_near(B[i], u[6][i], 1e-15)
    end
    assert.is_near(0.5 * C2 * c[9], u[7][3], 1e-15)
    -- what Unity's shader computes from them
    local E = ylm.sh.convert(rgb, "ylm irradiance")
    for _, v in ipairs(directions) do
      local x, y, z = v[1], v[2], v[3]
      local shaded = dot(u[1], { x, y, z, 1 }) + dot(u[4], { x * y, y * z, z * z, z * x }) + u[7][1] * (x * x - y * y)
      assert.is_near(value(E[1], v) / pi, shaded, 1e-14)
    end
  end)

  it("to 'three.js' and 'filament': channels last, the constants of their sources", function()
    local rgb = { counting(9), counting(9), { 9, 8, 7, 6, 5, 4, 3, 2, 1 } }
    local t, f = ylm.sh.convert(rgb, "three.js"), ylm.sh.convert(rgb, "filament")
    assert.same({ 9, 3 }, t.shape)
    local E = ylm.sh.convert(rgb, "ylm irradiance")[3]
    for _, v in ipairs(directions) do
      local x, y, z = v[1], v[2], v[3]
      local function channel(a) local list = {} for i = 1, 9 do list[i] = a:get(i, 3) end return list end
      -- SphericalHarmonics3.getAt and .getIrradianceAt, whose constants have six digits
      local basis = { 0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y, 1.092548 * y * z,
        0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y) }
      assert.is_near(value(rgb[3], v), dot(channel(t), basis), 3e-5)
      local irradiance = { 0.886227, 2 * 0.511664 * y, 2 * 0.511664 * z, 2 * 0.511664 * x, 2 * 0.429043 * x * y,
        2 * 0.429043 * y * z, 0.743125 * z * z - 0.247708, 2 * 0.429043 * x * z, 0.429043 * (x * x - y * y) }
      assert.is_near(value(E, v), dot(channel(t), irradiance), 3e-5)
      -- Irradiance_SphericalHarmonics of Filament's shaders
      local polynomials = { 1, y, z, x, y * x, y * z, 3 * z * z - 1, z * x, x * x - y * y }
      assert.is_near(value(E, v) / pi, dot(channel(f), polynomials), 1e-14)
    end
  end)

  it("to irradiance: by pi, 2pi/3, pi/4, 0, -pi/24", function()
    local c = ylm.sh.convert({ 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0 },
      "ylm irradiance")
    for l, wanted in ipairs { pi, 2 * pi / 3, pi / 4, 0, -pi / 24 } do
      assert.is_near(wanted, c[(l - 1) * l + 1], 1e-15)
    end
  end)

  it("turns axes: 'x,-z,y' are the axes of a world whose z is our y", function()
    local c = ylm.sh.eval(4, { 0.36, 0.48, 0.8 }) -- a lobe looking there
    local turned = ylm.sh.convert(c, "ylm x,-z,y") -- its coordinates there: x, -z, y
    local _, difference = core.array_distance(turned, ylm.sh.eval(4, { 0.36, -0.8, 0.48 }))
    assert(difference < 1e-15)
    local left = ylm.sh.convert(c, "plain x,y,-z") -- a left-handed world
    _, difference = core.array_distance(ylm.sh.convert(ylm.sh.eval(4, { 0.36, 0.48, -0.8 }), "plain"), left)
    assert(difference < 1e-15)
  end)

  it("comes back from every convention, in both types", function()
    local names = { "plain", "n3d", "sn3d", "scipy", "unity", "three.js", "filament", "plain irradiance", "ylm y,z,x",
      "sn3d irradiance -z,x,-y", "unity x,y,-z", "scipy -x,-y,-z", "e3nn", "e3nn-component x,-y,z",
      "e3nn-norm irradiance", "3dgs", "3dgs z,x,y" }
    local rgb = ylm.array { { counting(9), counting(9), { 9, 8, 7, 6, 5, 4, 3, 2, 1 } } }
    for _, name in ipairs(names) do
      local there = ylm.sh.convert(rgb, name)
      assert.equal(name, there.convention)
      assert(core.array_distance(ylm.sh.convert(there, "ylm"), rgb) < 1e-14, name)
      for _, other in ipairs(names) do
        assert(core.array_distance(ylm.sh.convert(ylm.sh.convert(there, other), "ylm"), rgb) < 1e-14, name .. " "
          .. other)
      end
      local f = ylm.sh.convert(ylm.sh.convert(ylm.array(rgb, "float"), name), "ylm")
      assert.equal("float", f.dtype)
      assert(core.array_distance(f, rgb) < 2e-6, name)
    end
  end)

  it("to 'mrtrix' and 'dipy': even degrees, in MRtrix's order and in Descoteaux's", function()
    local c = counting(25)
    local m, d = ylm.sh.convert(c, "mrtrix"), ylm.sh.convert(c, "dipy")
    assert.same({ 15 }, m.shape)
    for l = 0, 4, 2 do
      for k = -l, l do
        local i = l * (l + 1) / 2 + k + 1
        assert.equal(c[ylm.sh.index(l, k)], m[i])
        assert.equal(c[ylm.sh.index(l, -k)], d[i])
      end
    end
    local back = ylm.sh.convert(m, "dipy"):totable()
    assert.same(d:totable(), back)
    assert.equal(0, ylm.sh.convert(d, "ylm")[3]) -- degree 1 is not there
    for wrong, says in pairs { [16] = "even degrees" } do
      local ok, message = pcall(ylm.sh.convert, counting(wrong), "mrtrix")
      assert.is_false(ok)
      assert.matches(says, message)
    end
    assert.has_error(function() ylm.sh.convert(counting(10), "ylm", { from = "dipy" }) end)
    assert.has_error(function() ylm.sh.resize(m, 2) end)
    assert.has_error(function() ylm.sh.convert(counting(9), "3dgs") end)
  end)

  it("knows second names: sphericart, sph_harm_y, lovr", function()
    for name, system in pairs { sphericart = "plain", sph_harm_y = "scipy" } do
      assert.equal(system, ylm.sh.convert(counting(9), name).convention)
    end
    assert.equal("filament", ylm.sh.convert({ counting(9), counting(9), counting(9) }, "lovr").convention)
    local _, message = pcall(ylm.sh.convert, counting(9), "e3n")
    assert.matches("did you mean 'e3nn'", message)
  end)

  it("is remembered by clones, views and copies of another type", function()
    local c = ylm.sh.convert({ { 1, 2, 3, 4 } }, "sn3d")
    for _, a in ipairs { c:clone(), c[1], c:reshape { 4 }, ylm.array(c, "float") } do assert.equal("sn3d",
      a.convention) end
  end)

  it("refuses to mix: what takes ylm's coefficients names the convention that came", function()
    local c = ylm.sh.convert({ 1, 2, 3, 4 }, "plain")
    local ok, message = pcall(ylm.sh.rotate, c, { zyz = { 0, 0, 1 } })
    assert.is_false(ok)
    assert.matches("convention 'plain': convert them to 'ylm' first", message)
    assert.has_error(function() ylm.sh.reconstruct(c, { 0, 0, 1 }) end)
    assert.has_error(function() ylm.sh.reconstruct({ 1, 0 / 0, 0, 0 }, { 0, 0, 1 }) end)
  end)
end)

describe("ylm.sh.resize", function()
  it("cuts and extends", function()
    assert.same({ { 1 }, { 5 } }, ylm.sh.resize({ { 1, 2, 3, 4 }, { 5, 6, 7, 8 } }, 0):totable())
    assert.same({ 1, 2, 3, 4, 0, 0, 0, 0, 0 }, ylm.sh.resize({ 1, 2, 3, 4 }, 2):totable())
  end)
end)
