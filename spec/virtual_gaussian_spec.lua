-- rival = { "vsgl" } of pictures by virtual lights: groups of them as spherical Gaussians; report.virtual.singular.

local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- One shading point of a floor, at (0, 0, 0), seen from above; its material.
local function point(material)
  return ylm.scene "a floor" { camera = ylm.camera { from = { 0, 2, 0.5 }, at = { 0, 0, 0 }, fov = 0.01 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = material or
    ylm.matte { albedo = 1 } } }:prepare { size = { 1, 1 }, samples = 1 }
end

local function radiance(view, lights, options)
  local image, report = view:render(ways.virtual(with({ lights = lights, layers = false, method = "vsgl" }, options or {})))
  return assert(image, report):layer "radiance":get(1, 1, 2), report
end

--- Integral of L(w') f(w') max(0, w'.y) over directions, of a group with these numbers at place m.
local function integral(m, s, axis, sharp, f)
  local d2 = dot(m, m)
  local d, sum, n = math.sqrt(d2), 0, 90
  local w, area = { m[1] / d, m[2] / d, m[3] / d },
    sharp > 0 and 2 * math.pi * (1 - math.exp(-2 * sharp)) / sharp or 4 * math.pi
  for i = 1, n do
    for j = 1, 2 * n do
      local z, t = (i - 0.5) / n, (j - 0.5) / n * math.pi
      local r = math.sqrt(1 - z * z)
      local v = { r * math.cos(t), z, r * math.sin(t) }
      sum = sum + math.exp(d2 / s ^ 2 * (dot(v, w) - 1)) * math.exp(sharp * (-dot(v, axis) - 1)) * z * (f and f(v) or 1)
    end
  end
  return sum * math.pi / n / n / (2 * math.pi * s ^ 2 * area)
end

local LOBE = 0.57493
local SHARP = LOBE * (3 - LOBE ^ 2) / (1 - LOBE ^ 2)

describe("groups of lights", function()
  it("send all of their power through a large sphere", function()
    local R, n, sum, points = 40, 60, 0, 0
    local view = ylm.scene "a ball" { geometry = ylm.sphere { radius = R, material = ylm.matte { albedo = 1 } },
      camera = ylm.camera { from = { 0, 0, 0 }, at = { 1, 0, 0 }, fov = 10 } }:prepare { size = { 1, 1 }, samples = 1 }
    for i = 1, n do
      local z, t = 1 - 2 * (i - 0.5) / n, i * 2.39996
      local r = math.sqrt(1 - z * z)
      local normal = { r * math.cos(t), r * math.sin(t), z }
      local lights = ylm.virtual_lights { at = { { 0, 0, 0 }, { 0.3, 0, 0.2 } }, normal = { normal, normal }, radius = 0.1,
        intensity = { 1, 0.5 } }
      sum = sum + radiance(view, lights, { groups = 1 }) / n
      points = points + radiance(view, lights, { method = "vpl", clamp = "none" }) / n
    end
    assert.is_true(math.abs(sum * math.pi * 4 * math.pi * R * R / (1.5 * math.pi) - 1) < 0.02, sum / points)
    assert.is_true(math.abs(sum / points - 1) < 0.02, sum / points)
  end)

  it("are the integral of two lobes over the clamped cosine", function()
    local view = point()
    for _, case in ipairs { { { 0.2, 1, 0.1 }, { 0.6, -0.8, 0 }, 0.3 }, { { 0.5, 0.3, 0 }, { -0.8, -0.6, 0 }, 0.8 },
      { { 1, 0.1, 0.5 }, { -1, 0, 0 }, 0.6 } } do
      local m, axis, r = case[1], case[2], case[3]
      local lights = ylm.virtual_lights { at = { m }, normal = { axis }, radius = r, intensity = 1 }
      local wanted = integral(m, r / 2, axis, SHARP) -- of power pi, albedo/pi
      local got = radiance(view, lights)
      assert.is_true(math.abs(got / wanted - 1) < 0.03, got .. " " .. wanted)
    end
  end)

  it("are parted where they are widest, to single lights", function()
    local at, normal = {}, {}
    for i = 1, 64 do
      at[i] = { math.sin(i * 1.7), 0.6 + 0.4 * math.cos(i * 2.3), math.sin(i * i) }
      normal[i] = { 0, i % 2 == 0 and -1 or 0, i % 2 == 0 and 0 or 1 }
    end
    local lights = ylm.virtual_lights { at = at, normal = normal, radius = 0.2, intensity = 1 }
    local view, off = point(), {}
    local exact = radiance(view, lights, { groups = 64 })
    local sum = 0
    for i = 1, 64 do
      sum = sum + radiance(view, ylm.virtual_lights { at = { at[i] }, normal = { normal[i] }, radius = 0.2, intensity = 1 })
    end
    assert.is_true(math.abs(exact / sum - 1) < 1e-4)
    for k, n in ipairs { 1, 4, 16, 32 } do
      local got, report = radiance(view, lights, { groups = n })
      assert.equal(n, report.virtual.groups)
      assert.equal(n * view.stats.points, report.virtual.pairs)
      off[k] = math.abs(got / exact - 1)
    end
    assert.is_true(off[4] < off[1] and off[4] < 0.1, table.concat(off, " "))
    -- the same lights at one place: no way to part them
    local one = ylm.virtual_lights { at = { { 0, 1, 0 }, { 0, 1, 0 } }, normal = { { 0, -1, 0 }, { 0, -1, 0 } }, radius = 0.1,
      intensity = 1 }
    local _, report = radiance(view, one, { groups = 2 })
    assert.equal(1, report.virtual.groups)
    assert.equal(0, (radiance(view, ylm.virtual_lights { at = {}, radius = 1, intensity = 1 })))
  end)

  it("light glossy surfaces by a lobe of f's power and mean direction", function()
    local material = ylm.ggx { alpha = 0.4, f0 = 1 }
    local view = point(material)
    local wo = { 0, 2 / math.sqrt(4.25), 0.5 / math.sqrt(4.25) }
    for _, m in ipairs { { 0, 1, -0.25 }, { 0.3, 1, -0.5 } } do -- in the mirror's direction, and beside it
      local d = math.sqrt(dot(m, m))
      local axis = { -m[1] / d, -m[2] / d, -m[3] / d }
      local lights = ylm.virtual_lights { at = { m }, normal = { axis }, radius = 0.4, intensity = 1 }
      local function f(v) return material:eval({ { v[1], -v[3], v[2] } }, { { wo[1], -wo[3], wo[2] } }):get(1, 2) end
      local wanted, coarse = 0, 24
      local w, s = { m[1] / d, m[2] / d, m[3] / d }, 0.2
      for i = 1, coarse do
        for j = 1, 2 * coarse do
          local z, t = (i - 0.5) / coarse, (j - 0.5) / coarse * math.pi
          local r = math.sqrt(1 - z * z)
          local v = { r * math.cos(t), z, r * math.sin(t) }
          wanted = wanted + math.exp(d * d / s ^ 2 * (dot(v, w) - 1)) * math.exp(SHARP * (-dot(v, axis) - 1)) * z * f(v)
        end
      end
      wanted = wanted * math.pi / coarse ^ 2 / (2 * math.pi * s ^ 2 * 2 * math.pi * (1 - math.exp(-2 * SHARP)) / SHARP) * math.pi
      local got = radiance(view, lights)
      assert.is_true(math.abs(got / wanted - 1) < 0.25, got .. " " .. wanted) -- GGX has longer tails than a Gaussian
    end
  end)

  it("are at most as many as lights, and of this method alone", function()
    local view = point()
    local lights = ylm.virtual_lights { at = { { 0, 1, 0 } }, radius = 0.1, intensity = 1 }
    refused("groups %(5%) must be at most the 1 lights", function() radiance(view, lights, { groups = 5 }) end)
    refused("groups must be an integer >= 1", function() radiance(view, lights, { groups = 0 }) end)
    refused("groups is for 'vsgl', this is 'vpl'", function()
      view:render { by = "none", bounced = lights, rival = { "vpl", groups = 1 } }
    end)
  end)
end)

describe("lights at shading points", function()
  it("are counted where they have no size", function()
    local view = point()
    local p = view:points().position:totable()
    local places = { p[1], { 0, 1, 0 }, p[1] }
    local _, report = view:render { by = "none", bounced = ylm.virtual_lights { at = places, intensity = 1,
      profile = "point" } }
    assert.equal(2, report.virtual.singular)
    local soft = ylm.virtual_lights { at = places, intensity = 1, radius = 0.1 }
    _, report = view:render { by = "none", bounced = soft }
    assert.equal(0, report.virtual.singular)
    _, report = view:render { by = "none", bounced = soft, rival = { "vpl" } }
    assert.equal(2, report.virtual.singular)
  end)
end)
