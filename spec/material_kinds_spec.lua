-- Materials of every kind: what holds of any reflectance, asked of each row of spec/support/material_rows.lua, and what is a
-- kind's own, against its formula.

local by_kernels = require "spec.support.by_kernels"
local long = require "spec.support.long"
local ylm = require "ylm"
local fits = require "ylm.material.abc_fits"
local material = require "ylm.material"

local rows = require "spec.support.material_rows" (ylm)

local views = { { 0.6, 0, 0.8 }, { 0.3, -0.9, 0.3162277660168379 } }

--- Directions above the surface: array, list, and the solid angle of each. Densities jump at the height of the view.
local function hemisphere(wo, n)
  local list, weights, view = {}, {}, math.acos(wo[3])
  for _, part in ipairs { { 0, view }, { view, math.pi / 2 } } do
    local rows_here = math.ceil(n * (part[2] - part[1]) / (math.pi / 2))
    local half = (part[2] - part[1]) / rows_here / 2
    for i = 1, rows_here do
      local angle = part[1] + (2 * i - 1) * half
      local z, r = math.cos(angle), math.sin(angle)
      local weight = (math.cos(angle - half) - math.cos(angle + half)) * math.pi / n
      for k = 1, 2 * n do
        local turn = (k - 0.5) / n * math.pi
        list[#list + 1], weights[#weights + 1] = { r * math.cos(turn), r * math.sin(turn), z }, weight
      end
    end
  end
  return { array = ylm.array(list), list = list, weights = weights }
end

local around = {}
for i, wo in ipairs(views) do around[i] = hemisphere(wo, 64) end

--- n rows of three numbers that fill the cube.
local function numbers(n)
  local u = {}
  for i = 1, n do u[i] = { (i * 0.8191725133961645) % 1, (i * 0.6710436067037893) % 1, (i * 0.5497004779019703) % 1 } end
  return ylm.array(u, "float")
end

local many = numbers(3000)

local RANDOM, random = 2000, {}
math.randomseed(7)
for i = 1, RANDOM do
  random[i] = {}
  for k = 1, 3 do random[i][k] = math.min(math.random(), 0.9999999) end
end
random = ylm.array(random, "float")

--- Pairs of directions above the surface.
local function pairs_above(n)
  local a, b = {}, {}
  for i = 1, n do
    for k, list in ipairs { a, b } do
      local z, turn = (0.02 + i * (k == 1 and 0.8566748838545029 or 0.7338918566271260)) % 0.98 + 0.02,
        i * (k == 1 and 0.6287067210378087 or 0.5385972572236101) * 2 * math.pi
      local r = math.sqrt(1 - z * z)
      list[i] = { r * math.cos(turn), r * math.sin(turn), z }
    end
  end
  return a, b
end

--- All numbers of an array, as a list.
local function flat(a) return a:reshape({ a.shape[1] * (a.shape[2] or 1) }):totable() end

--- The cell of a direction among 8 x 16.
local function cell(d)
  local z, turn = math.min(7, math.floor(8 * d[3])), math.floor((math.atan2 or math.atan)(d[2], d[1]) / math.pi * 8 + 8)
  return 16 * z + turn % 16 + 1
end

describe("materials of each kind", function()
  for _, row in ipairs(rows) do
    local name, m = row[1], row[2]

    it("reflect alike in both directions, never less than nothing and never more than comes: " .. name, function()
      local facts = m:check()
      assert(facts.reciprocity <= (row.reciprocity or 1e-4), facts.reciprocity)
      assert(facts.energy <= (row.energy or 1) + 1e-3, facts.energy)
      assert(facts.negative == 0 and facts.least >= 0)
    end)

    it("are sampled by a density that integrates to 1, with weights f cos / density: " .. name, function()
      for v, wo in ipairs(views) do
        local all, sum = around[v], 0
        for i, p in ipairs(m:pdf(all.array, wo):totable()) do sum = sum + p * all.weights[i] end
        assert.near(1, sum, row.integral or 2e-3)
        local wi, weight, pdf = m:sample(wo, many)
        local f, p = m:eval(wi, wo):totable(), m:pdf(wi, wo):totable()
        local w, q, d, mean = weight:totable(), pdf:totable(), wi:totable(), { 0, 0, 0 }
        for i = 1, #q do
          assert(math.abs(p[i] - q[i]) <= 2e-3 * q[i] + 1e-6, "density")
          for c = 1, 3 do
            mean[c] = mean[c] + w[i][c] / #q
            if q[i] > 0 then
              local wanted = f[i][c] * d[i][3] / q[i]
              assert(math.abs(w[i][c] - wanted) <= 2e-3 * wanted + 1e-6, "weight")
            end
          end
        end
        -- Their mean is the albedo, by another quadrature too.
        local albedo = { 0, 0, 0 }
        for i, value in ipairs(m:eval(all.array, wo):totable()) do
          for c = 1, 3 do albedo[c] = albedo[c] + value[c] * all.list[i][3] * all.weights[i] end
        end
        local azimuth = math.deg((math.atan2 or math.atan)(wo[2], wo[1]))
        local said = m:albedo(wo[3], { azimuth = azimuth }):totable()[1]
        for c = 1, 3 do
          assert.near(albedo[c], mean[c], row.integral or 3e-3)
          assert.near(albedo[c], said[c], row.integral or 1e-3)
        end
      end
    end)

    it("have samples that follow it: " .. name, function()
      for v, wo in ipairs(views) do
        local all, expected, counted = around[v], {}, {}
        for i = 1, 128 do expected[i], counted[i] = 0, 0 end
        for i, p in ipairs(m:pdf(all.array, wo):totable()) do
          local k = cell(all.list[i])
          expected[k] = expected[k] + p * all.weights[i]
        end
        for _, d in ipairs((m:sample(wo, random)):totable()) do
          local k = cell(d)
          counted[k] = counted[k] + 1
        end
        local chi2, cells, rest, left = 0, -1, 0, 0
        for i = 1, 128 do
          local e = expected[i] * RANDOM
          if e < 8 then rest, left = rest + e, left + counted[i]
          else chi2, cells = chi2 + (counted[i] - e) ^ 2 / e, cells + 1 end
        end
        if rest > 8 then chi2, cells = chi2 + (left - rest) ^ 2 / rest, cells + 1 end
        assert(cells <= 0 or chi2 <= cells + 5 * math.sqrt(2 * cells) + 3, ("chi2 %g of %d"):format(chi2, cells))
      end
    end)

    it("are dark from below and towards below, whatever one asks: " .. name, function()
      local up, down = { 0.3, 0.2, 0.9 }, { 0.3, 0.2, -0.9 }
      for _, p in ipairs { { up, down }, { down, up }, { down, down } } do
        assert.same({ 0, 0, 0 }, m:eval(p[1], p[2]):totable())
        assert.equal(0, m:pdf(p[1], p[2]))
      end
      local _, weight, pdf = m:sample(down, { { 0.5, 0.5, 0.5 } })
      assert.same({ { 0, 0, 0 } }, weight:totable())
      assert.same({ 0 }, pdf:totable())
    end)
  end

  it("have finite values at the edges: the normal, grazing, numbers 0 and nearly 1", function()
    local edges, u = { { 0, 0, 1 }, { 1, 0, 1e-6 }, { -1, 0, 1e-6 }, { 0, 1, 1e-3 }, { 1, 0, 1e-30 } }, {}
    for i = 0, 7 do
      u[i + 1] = { i % 2 * 0.99999994, math.floor(i / 2) % 2 * 0.99999994, math.floor(i / 4) * 0.99999994 }
    end
    local materials = { ylm.ggx { alpha = 1e-3, f0 = 1 }, ylm.ggx { alpha = 1e-3, f0 = 0, base = 1 },
      ylm.phong { exponent = 1e5 },
      ylm.phong { exponent = 0, specular = 1, base = 0 }, ylm.abc { kd = 0, a = 0, b = 0, c = 0, ior = 1 } }
    for _, row in ipairs(rows) do materials[#materials + 1] = row[2] end
    for _, m in ipairs(materials) do
      for _, wo in ipairs(edges) do
        local wi, weight, pdf = m:sample(wo, u)
        for _, a in ipairs { wi, weight, pdf, m:eval(wi, wo), m:pdf(wi, wo), m:eval(edges, wo) } do
          for _, x in ipairs(flat(a)) do
            assert(x == x and math.abs(x) < math.huge, tostring(m))
          end
        end
      end
    end
  end)

  it("are computed alike by each kernel set", function()
    local program = [[
      local ylm = require "ylm"
      local a, b, u = {}, {}, {}
      for i = 1, 37 do
        local z = (i * 0.61) % 0.97 + 0.03
        a[i] = { math.cos(i), math.sin(i), z }
        b[i] = { math.cos(2.3 * i), math.sin(2.3 * i), (i * 0.37) % 0.97 + 0.03 }
        u[i] = { (i * 0.819) % 1, (i * 0.671) % 1, (i * 0.549) % 1 }
      end
      for _, row in ipairs(require "spec.support.material_rows" (ylm)) do
        local wi, weight, pdf = row[2]:sample(b, u)
        for _, x in ipairs { row[2]:eval(a, b), row[2]:pdf(a, b), wi, weight, pdf } do
          for _, v in ipairs(x:reshape({ x.shape[1] * (x.shape[2] or 1) }):totable()) do print(("%.9g"):format(v)) end
        end
      end]]
    local plain
    for _, isa in ipairs(ylm.info().kernels) do -- the reference first
      local list = by_kernels(isa, program)
      plain = plain or list
      assert.equal(#rows * 37 * (3 + 1 + 3 + 3 + 1), #list)
      for i, x in ipairs(list) do
        assert(math.abs(x - plain[i]) <= 2e-3 * math.abs(plain[i]) + 2e-5, ("%s, number %d: %g, plain %g"):format(isa, i, x,
          plain[i]))
      end
    end
  end)

  it("answer for one pair, for many, and for many with one, into arrays that are given", function()
    local m = ylm.ggx { alpha = 0.4 }
    local a, b = pairs_above(5)
    local f, one = m:eval(a, b), m:eval(a[3], b[3])
    for c = 1, 3 do assert.equal(f:get(3, c), one:get(c)) end
    assert.equal(m:eval(a, { b[2] }):get(4, 1), m:eval(a[4], b[2]):get(1))
    assert.equal(m:eval(a[4], b):get(2, 1), m:eval(a[4], b[2]):get(1))
    assert.equal(m:pdf(a, b):get(3), m:pdf(a[3], b[3]))
    local out = ylm.zeros({ 5, 3 }, "float")
    assert.equal(out, m:eval(a, b, { out = out }))
    assert.same(f:totable(), out:totable())
    local scaled = {}
    for i, d in ipairs(a) do scaled[i] = { 7 * d[1], 7 * d[2], 7 * d[3] } end
    for i = 1, 5 do assert.near(f:get(i, 1), m:eval(scaled, b):get(i, 1), 1e-5 * f:get(i, 1)) end
    assert.same({ 0, 3 }, m:eval({}, {}).shape)
  end)

  it("do not change, and say their fields", function()
    local m = ylm.ggx { alpha = { 0.1, 0.2 }, f0 = { 1, 0.5, 0 } }
    assert.same({ 0.1, 0.2 }, m.alpha)
    assert.same({ 1, 0.5, 0 }, m.f0)
    assert.is_true(m.compensate)
    assert.matches("^ylm%.ggx { alpha = {[%d., ]+}, f0 = {[%d., ]+}, base = ", tostring(m))
    local ok, message = pcall(function() m.alpha = 1 end)
    assert(not ok and message:find "cannot set 'alpha'", message)
    assert.same({ 0.5, 0.5, 0.5 }, ylm.matte {}.albedo)
    assert.same({ { 0.5, 0.5, 0.5 } }, ylm.matte {}:albedo(1):totable())
  end)
end)

describe("ggx", function()
  it("has the albedos of the published quadrature, F = 1, at 0, 45, 75 degrees and on average", function()
    for alpha, wanted in pairs {
      [1] = { 0.3069, 0.3768, 0.5906, 0.4091 }, [0.7] = { 0.5037, 0.5413, 0.6921, 0.5663 },
      [0.5] = { 0.6878, 0.6828, 0.7614, 0.7002 }, [0.35] = { 0.8337, 0.8037, 0.8089, 0.8103 },
      [0.25] = { 0.9158, 0.8862, 0.8393, 0.8823 }, [0.18] = { 0.9583, 0.9383, 0.8669, 0.9284 },
      [0.125] = { 0.9811, 0.9707, 0.9020, 0.9598 }, [0.09] = { 0.9907, 0.9854, 0.9345, 0.9765 } } do
      local m = ylm.ggx { alpha = alpha, f0 = 1, compensate = false }
      local a = m:albedo { 1, math.cos(math.rad(45)), math.cos(math.rad(75)) }
      for i = 1, 3 do assert.near(wanted[i], a:get(i, 2), 4e-4) end
      assert.near(wanted[4], material.albedo("spec", m)[1], 4e-4)
    end
  end)

  it("is D G F / (4 cos cos) with height-correlated shadowing", function()
    local ax, ay, f0 = 0.2, 0.6, 0.3
    local m = ylm.ggx { alpha = { ax, ay }, f0 = f0, compensate = false }
    local function lambda(w) return (math.sqrt(1 + (ax ^ 2 * w[1] ^ 2 + ay ^ 2 * w[2] ^ 2) / w[3] ^ 2) - 1) / 2 end
    local a, b = pairs_above(300)
    local f = m:eval(a, b)
    for i = 1, #a do
      local h, length = {}, 0
      for k = 1, 3 do
        h[k] = a[i][k] + b[i][k]
        length = length + h[k] ^ 2
      end
      length = math.sqrt(length)
      local c = length / 2
      local D = 1 / (math.pi * ax * ay * ((h[1] / ax) ^ 2 + (h[2] / ay) ^ 2 + h[3] ^ 2) ^ 2 / length ^ 4)
      local wanted = (f0 + (1 - f0) * (1 - c) ^ 5) * D / (4 * a[i][3] * b[i][3] * (1 + lambda(a[i]) + lambda(b[i])))
      assert.near(wanted, f:get(i, 1), 2e-5 * wanted)
    end
  end)

  it("returns all light where f0 is 1, or the base is, within 2e-3: isotropic furnaces", function()
    local u = numbers(4096)
    for _, alpha in ipairs { 0.01, 0.1, 0.3, 1 } do
      for _, m in ipairs { ylm.ggx { alpha = alpha, f0 = 1 }, ylm.ggx { alpha = alpha, f0 = { 0.04, 0.5, 0.95 }, base = 1 } } do
        for _, z in ipairs { 1, 0.5, 0.1 } do
          local _, weight = m:sample({ math.sqrt(1 - z * z), 0, z }, u)
          local sum = { 0, 0, 0 }
          for _, w in ipairs(weight:totable()) do for c = 1, 3 do sum[c] = sum[c] + w[c] / 4096 end end
          for c = 1, 3 do assert.near(1, sum[c], 2e-3) end
        end
      end
    end
  end)

  it("says in check what its compensation misses where it is anisotropic", function()
    local little, much = ylm.ggx { alpha = { 0.1, 0.4 }, f0 = 1 }:check(), ylm.ggx { alpha = { 0.1, 0.9 }, f0 = 1 }:check()
    assert(math.max(little.energy - 1, 1 - little.least) < 0.1 and math.max(much.energy - 1, 1 - much.least) > 0.2)
    assert.is_false(much.isotropic)
  end)

  it("mirrors: light leaves 180 degrees from where it comes, wide across the direction of the larger alpha", function()
    local m = ylm.ggx { alpha = 0.05, f0 = 1 }
    local best, at = 0, nil
    for i, f in ipairs(m:eval(around[1].array, { 0.6, 0, 0.8 }):totable()) do
      if f[1] > best then best, at = f[1], around[1].list[i] end
    end
    assert.near(-0.6, at[1], 0.05)
    assert.near(0, at[2], 0.05)
    local brushed = ylm.ggx { alpha = { 0.1, 0.4 }, f0 = 1, compensate = false }
    local f = brushed:eval({ { 0.4, 0, 0.9165 }, { 0, 0.4, 0.9165 } }, { 0, 0, 1 })
    assert(f:get(2, 1) > 3 * f:get(1, 1))
  end)

  it("needs degrees as its roughness says", function()
    for alpha, wanted in pairs { [1] = { 4, 4, 6 }, [0.5] = { 3, 4, 9 }, [0.25] = { 7, 9, 23 },
      [long(0.25, 0.125)] = long({ 7, 9, 23 }, { 15, 19, 51 }) } do
      local d = ylm.ggx { alpha = alpha, f0 = 1, compensate = false }:degrees { error = 0.1, most = long(24, 60) }
      assert.equal(18, #d)
      for i, k in ipairs { 1, 10, 16 } do assert.equal(wanted[i], d[k]) end
    end
    assert.equal(math.huge, ylm.ggx { alpha = 0.125 }:degrees { error = 0.1, most = 20 }[18])
    for _, l in ipairs(ylm.matte {}:degrees { error = 0.11, most = long(24, 60) }) do assert.equal(2, l) end
  end)
end)

describe("phong", function()
  it("reflects specular + base along the normal, and is their lobe", function()
    local m = ylm.phong { exponent = 30, specular = 0.4, base = 0.3 }
    assert.near(0.7, m:albedo(1):get(1, 1), 5e-4)
    local a, b = pairs_above(200)
    local f = m:eval(a, b)
    for i = 1, #a do
      local c = -a[i][1] * b[i][1] - a[i][2] * b[i][2] + a[i][3] * b[i][3]
      local wanted = 0.3 / math.pi + 0.4 * 32 / (2 * math.pi) * math.max(0, c) ^ 30
      assert.near(wanted, f:get(i, 1), 1e-5 * wanted)
    end
  end)
end)

describe("abc", function()
  it("is its formula", function()
    local kd, a_, b_, c_, ior = 0.1, 5.976665, 192.19989, 1.5733, 1.483582
    local m = ylm.abc { kd = kd, a = a_, b = b_, c = c_, ior = ior, scale = 2 }
    local a, b = pairs_above(200)
    local f = m:eval(a, b)
    for i = 1, #a do
      local h, length = {}, 0
      for k = 1, 3 do
        h[k] = a[i][k] + b[i][k]
        length = length + h[k] ^ 2
      end
      length = math.sqrt(length)
      local cosine, up = length / 2, h[3] / length
      local t = math.sqrt(ior ^ 2 - 1 + cosine ^ 2)
      local F = (((cosine - t) / (cosine + t)) ^ 2 + ((ior ^ 2 * cosine - t) / (ior ^ 2 * cosine + t)) ^ 2) / 2
      local G = math.min(1, 2 * up * a[i][3] / cosine, 2 * up * b[i][3] / cosine)
      local wanted = 2 * (kd / math.pi + F * G * a_ / (1 + b_ * (1 - up)) ^ c_ / (math.pi * a[i][3] * b[i][3]))
      assert.near(wanted, f:get(i, 1), 5e-5 * wanted)
    end
  end)

  it("has the 100 published fits, as printed", function()
    local n = 0
    for _, fit in pairs(fits) do
      assert.equal(9, #fit)
      n = n + 1
    end
    assert.equal(100, n)
    assert.near(0.13, material.albedo("spec", ylm.abc { fit = "chrome" })[1], 0.005)
    local paint = ylm.abc { fit = "gold-metallic-paint" }
    assert.near(0.22, paint:albedo(1):get(1, 1), 0.005)
    assert.same({ 53.738525, 1.51173, 9.031934 }, { paint.b, paint.c, paint.ior })
  end)
end)

describe("pictures of glossy surfaces", function()
  local function scene(m)
    return ylm.scene "gloss" {
      camera = ylm.camera { from = { 0, 3, 0.1 } },
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = m },
        ylm.box { material = ylm.matte {} } },
      lights = ylm.sphere_light { at = { 0, 3, 2 }, radius = 0.2 },
    }
  end

  it("say that they do not show it", function()
    local before = ylm.on_warning(false)
    local _, report = scene(ylm.ggx {}):render { by = "sum", size = { 8, 4 }, samples = 1, gloss = "matte" }
    ylm.on_warning(before)
    local said = table.concat(report.warnings, "\n")
    assert.truthy(said:find("1 mesh is glossy: transfer vectors shade it as a matte one of its mean albedo", 1, true), said)
  end)

  it("are refused by devices, by the mesh and its kind", function()
    local view = scene(ylm.ggx {}):prepare { size = { 8, 4 }, samples = 1, visibility = "none", lmax = 0 }
    local none, message = require "ylm.c.scene".shade_materials(view)
    assert.is_nil(none)
    assert.equal("a device shades matte surfaces only: mesh 1 is ggx", message)
  end)

  it("need texture coordinates where alpha has two values", function()
    local s = scene(ylm.ggx {})
    s.geometry[2] = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
      material = ylm.ggx { alpha = { 0.1, 0.2 } } }
    local ok, message = pcall(s.render, s, { by = "sum", size = { 8, 4 } })
    assert(not ok and message:find("alpha = {a, b} needs uvs: mesh 2 has none", 1, true), message)
  end)
end)
