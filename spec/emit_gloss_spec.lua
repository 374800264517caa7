-- scene:virtual_lights of glossy surfaces: slices fitted over the hemisphere, their power, their axes.

local refused = require "spec.support.raises"
local ylm = require "ylm"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local FROM, U = { 0.5, 1.2, 0.4 }, { 2, 0.3, 0 }
--- A tilted square under a spot, its tangent along U.
local function ground(material)
  return ylm.scene "a floor" { geometry = ylm.quad { corner = { -1, 0, 1 }, u = U, v = { 0.2, 0, -2 }, material = material },
    lights = ylm.spot_light { at = FROM, to = { 0, 0, 0 }, angle = 40, intensity = { 3, 2, 1 } } }
end

local function unit(v)
  local d = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
  return { v[1] / d, v[2] / d, v[3] / d }
end
local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- Directions above a surface, in its frame.
local above = {}
for a = 1, 8 do
  for b = 1, 16 do
    local z, t = (a - 0.5) / 8, b / 8 * math.pi
    above[#above + 1] = { math.sqrt(1 - z * z) * math.cos(t), math.sqrt(1 - z * z) * math.sin(t), z }
  end
end

--- The error of what light i sends over its norm, both of the same power.
local function error_of(material, lights, i)
  local at, normal, _, emission = lights:arrays()
  local n = { normal:get(i, 1), normal:get(i, 2), normal:get(i, 3) }
  local t, wo, wi, u = unit(U), {}, {}, {}
  local b = { n[2] * t[3] - n[3] * t[2], n[3] * t[1] - n[1] * t[3], n[1] * t[2] - n[2] * t[1] }
  local from = unit { FROM[1] - at:get(i, 1), FROM[2] - at:get(i, 2), FROM[3] - at:get(i, 3) }
  for k, w in ipairs(above) do
    wo[k], wi[k] = { dot(from, t), dot(from, b), dot(from, n) }, w
    u[k] = {}
    for a = 1, 3 do u[k][a] = w[1] * t[a] + w[2] * b[a] + w[3] * n[a] end
  end
  local f, Y = material:eval(wi, wo), ylm.sh.eval(lights.degree, u)
  local exact, sent, all, other = {}, {}, 0, 0
  for k, w in ipairs(above) do
    local sum = 0
    for q = 1, (lights.degree + 1) ^ 2 do sum = sum + emission:get(i, 1, q) * Y:get(k, q) end
    exact[k], sent[k] = f:get(k, 1) * w[3], sum * w[3]
    all, other = all + exact[k], other + sent[k]
  end
  local off, norm = 0, 0
  for k = 1, #above do
    off = off + (sent[k] / other - exact[k] / all) ^ 2
    norm = norm + (exact[k] / all) ^ 2
  end
  return math.sqrt(off / norm)
end

describe("fits over the hemisphere", function()
  -- Errors in % of white GGX without light between facets: degrees 0, 2, 4, 8.
  local table_of_errors = {
    { 0.5, 0, { 18, 2, 0.4, 0.1 } }, { 0.5, 45, { 52, 13, 4, 0.3 } }, { 0.5, 75, { 66, 34, 19, 8 } },
    { 0.25, 0, { 63, 23, 11, 2 } }, { 0.25, 45, { 84, 47, 25, 7 } }, { 0.25, 75, { 95, 76, 61, 40 } },
  }

  it("miss as much of GGX as least squares with the clamp do", function()
    for i, degree in ipairs { 0, 2, 4, 8 } do
      local fits = {}
      for _, row in ipairs(table_of_errors) do
        local alpha, angle, wanted = row[1], math.rad(row[2]), row[3][i]
        fits[alpha] = fits[alpha] or ylm.ggx { alpha = alpha, f0 = 1, compensate = false }:table { lmax = degree, fit = true,
          rows = 25, error = 0 }
        local got = 100 * fits[alpha]:missed(0, { math.sin(angle), 0, math.cos(angle) }):get(1)
        assert.is_true(math.abs(got - wanted) <= math.max(0.06, wanted < 1 and 0.05 or 0.7),
          ("alpha %g, %g degrees, degree %d: %.2f %%, wanted %g"):format(alpha, row[2], degree, got, wanted))
      end
    end
  end)

  it("have no error of matte surfaces, but the ridge's", function()
    for _, degree in ipairs { 0, 2, 4 } do
      local fit = ylm.matte { albedo = 0.5 }:table { lmax = degree, fit = true, rows = 4, error = 0 }
      assert.is_true(fit:missed(0, { 0, 0, 1 }):get(1) < 2e-3)
    end
  end)

  it("refuse what they are not", function()
    local m = ylm.ggx { alpha = 0.5, f0 = 1 }
    refused("lmax of fits is at most 8", function() m:table { lmax = 9, fit = true } end)
    refused("exclude each other", function() m:table { lmax = 2, fit = true, cosine = false } end)
  end)
end)

describe("lights of glossy surfaces", function()
  local turned = ylm.ggx { alpha = { 0.5, 0.25 }, f0 = 0.8 }

  for _, case in ipairs {
    { "metal", ylm.ggx { alpha = 0.5, f0 = { 1, 0.8, 0.3 } }, 2 }, { "sharper metal", ylm.ggx { alpha = 0.25, f0 = 1 }, 4 },
    { "varnish", ylm.ggx { alpha = 0.5, f0 = 0.04, base = { 0.6, 0.2, 0.1 } }, 2 }, { "brushed metal", turned, 4, 4 },
    { "polish", ylm.phong { exponent = 20, specular = 0.5, base = 0.3 }, 8, 8 },
  } do
    it("send the slice of their arrival, of a degree by the material: " .. case[1], function()
      local lights, r = ground(case[2]):virtual_lights { distribution = "grid", count = 4, degree = case[4] }
      assert.equal(case[3], lights.degree)
      assert.equal(case[3], r.degree)
      local worst, sum = 0, 0
      for i = 1, 4 do
        local e = error_of(case[2], lights, i)
        worst, sum = math.max(worst, e), sum + e * e / 4
      end
      assert.is_true(worst < 1.1 * r.slices.most + 3e-3, worst .. " " .. r.slices.most)
      assert.is_true(case[1] == "varnish" or worst > 0.8 * r.slices.most - 3e-3, worst .. " " .. r.slices.most)
      for c = 1, 3 do
        assert.is_true(math.abs(r.power.lights[c] / r.power.reflected[c] - 1) < 1e-6)
        assert.equal(r.power.lights[c], lights.power[c])
      end
    end)
  end

  it("come nearer with the degree", function()
    local last, material = 1, ylm.ggx { alpha = 0.35, f0 = 0.5 }
    for _, degree in ipairs { 0, 2, 6 } do
      local lights, r = ground(material):virtual_lights { distribution = "grid", count = 4, degree = degree }
      local e = error_of(material, lights, 2)
      assert.is_true(e < 0.8 * last, degree .. ": " .. e)
      last = degree == 0 and e or math.min(e, r.slices.most)
    end
    assert.is_true(last < 0.05, last)
  end)

  it("reflect what their direction does, of which fits without `conserve` keep nearly all", function()
    local material = ylm.ggx { alpha = 0.4, f0 = { 0.9, 0.5, 0.1 } }
    local lights, r = ground(material):virtual_lights { distribution = "grid", count = 1, degree = 6 }
    local at = lights:arrays()
    local wo = unit { FROM[1] - at:get(1, 1), FROM[2] - at:get(1, 2), FROM[3] - at:get(1, 3) }
    local _, normal = lights:arrays()
    local z = dot(wo, { normal:get(1, 1), normal:get(1, 2), normal:get(1, 3) })
    local wi, ratio = {}, r.power.reflected[2] / r.power.landed[2]
    for k = 1, #above do wi[k] = { math.sqrt(1 - z * z), 0, z } end
    local f, albedo = material:eval(above, wi), 0
    for k, w in ipairs(above) do albedo = albedo + f:get(k, 2) * w[3] * 2 * math.pi / #above end
    assert.is_true(math.abs(ratio / albedo - 1) < 0.02, ratio .. " " .. albedo)
    local plain, facts = ground(material):virtual_lights { distribution = "grid", count = 1, degree = 6, conserve = false }
    local kept = plain.power[2] / facts.power.reflected[2]
    assert.is_true(math.abs(kept - 1) < 0.02 and kept ~= 1, kept)
  end)

  it("stand beside those of matte surfaces, which stay as they are", function()
    local scene = ylm.scene "two" { lights = ylm.sphere_light { at = { 0, 0.3, 0 }, radius = 0.1, radiance = 5 },
      geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
        ylm.sphere { at = { 0, -0.5, 0 }, radius = 0.3, material = ylm.ggx { alpha = 0.5, f0 = 0.9 } } } }
    local lights, r = scene:virtual_lights { count = 300, threads = 1 }
    local plain = scene:virtual_lights { count = 300, degree = 0 }
    local at, _, _, e = lights:arrays()
    local as, _, _, f = plain:arrays()
    local matte = 0
    for i = 1, #at do
      local x, y, z = at:get(i, 1), at:get(i, 2) + 0.5, at:get(i, 3)
      if x * x + y * y + z * z > 0.31 ^ 2 then
        matte = matte + 1
        assert.equal(as:get(i, 1), at:get(i, 1))
        assert.is_true(math.abs(e:get(i, 1, 1) - f:get(i, 1, 1)) < 1e-12)
        for q = 2, 9 do assert.equal(0, e:get(i, 1, q)) end
      end
    end
    assert.equal(r.lights - r.glossy, matte)
    local again = scene:virtual_lights { count = 300, threads = 3 }
    assert.same(e:totable(), (select(4, again:arrays())):totable())
  end)

  it("go on by their material: power under way is that of paths", function()
    local material = ylm.ggx { alpha = 0.4, f0 = 0.7, base = 0 }
    local scene = ylm.scene "a room" { geometry = ylm.box { scale = 2, material = material },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 1 } }
    local _, one = scene:virtual_lights { count = 8000, degree = 2 }
    local _, two = scene:virtual_lights { count = 8000, degree = 2, bounces = 2 }
    local first = one.power.reflected[1] / one.power.landed[1]
    local second = two.power.reflected[1] / one.power.reflected[1] - 1
    assert.is_true(first > 0.6 and first < 0.7 and math.abs(second / first - 1) < 0.03, first .. " " .. second)
  end)

  it("say what they miss", function()
    local _, r = ground(ylm.ggx { alpha = 0.1, f0 = 1 }):virtual_lights { distribution = "grid", count = 9 }
    assert.equal(8, r.degree)
    assert.matches("of degree 8 miss %d+ %% .* come out wider", r.warnings[1])
    assert.is_true(r.slices.below > 0.05 and r.slices.unscaled == 0)
    _, r = ground(ylm.ggx { alpha = 0.25, f0 = 1 }):virtual_lights { distribution = "grid", count = 9, degree = 2 }
    assert.matches("set a higher degree", r.warnings[1])
    refused("degree must be 'auto', or an integer from 0 to 8", function()
      ground(turned):virtual_lights { degree = 9 }
    end)
  end)
end)

describe("a wall beside a glossy floor", function()
  it("has the light that paths bring there from the floor, which matte lights have not", function()
    local grey = ylm.matte { albedo = 0.6 }
    local scene = ylm.scene "a lobe" { camera = ylm.camera { from = { 0, 0.5, 2.2 }, at = { 0.5, 0.4, -0.3 }, fov = 50 },
      geometry = {
        ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = ylm.ggx { alpha = 0.35, f0 = 0.9 } },
        ylm.quad { corner = { 1, 0, 1 }, u = { 0, 0, -2 }, v = { 0, 1.5, 0 }, material = grey } },
      lights = ylm.spot_light { at = { -0.9, 0.8, 0 }, to = { 0, 0, 0 }, angle = 30, intensity = 10 } }
    local view = scene:prepare { size = { 18, 12 }, samples = 1, share = 0 }
    local truth = require "ylm.trace".library().shade_judge(view, { samples = 512, first = 2, last = 2, seed = 1 })
    local at, prepared = view:points().position, require "ylm.render.view".open("render", view)
    local off, whole = {}, {}
    for _, degree in ipairs { 0, 4 } do
      local lights = scene:virtual_lights { distribution = "grid", count = 400, degree = degree }
      local got = require "ylm.render.bounced.virtual".sum("render", prepared, { lights = lights, lmax = 8 })
      local d, all, sum, wanted = 0, 0, 0, 0
      for i = 1, #truth do
        if at:get(i, 1) > 0.99 then
          d, all = d + (got:get(i, 1) - truth:get(i, 1)) ^ 2, all + truth:get(i, 1) ^ 2
          sum, wanted = sum + got:get(i, 1), wanted + truth:get(i, 1)
        end
      end
      off[degree], whole[degree] = math.sqrt(d / all), sum / wanted
    end
    assert.is_true(whole[0] < 0.6 and math.abs(whole[4] - 1) < 0.04, whole[0] .. " " .. whole[4])
    assert.is_true(off[4] < 0.3 * off[0], off[0] .. " " .. off[4])
  end)
end)
