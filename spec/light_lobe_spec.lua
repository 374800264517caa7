-- ylm.disk_light { spread = n }: radiance as the cosine to the power n, by rays, paths, links and particles, against quadrature.

local refused = require "spec.support.raises"
local with = require "spec.support.with"
local ylm = require "ylm"

local grey = ylm.matte { albedo = 0.5 }
local lobe = { at = { 0.2, 1.5, 0 }, normal = { -0.3, -1, 0.1 }, radius = 0.3, radiance = { 6, 4, 2 }, spread = 5 }

local function floor(light)
  return ylm.scene "a floor" { lights = light, camera = ylm.camera { from = { 0, 1.2, 0.01 }, at = { 0, 0, 0 }, fov = 60 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = grey } }
end

--- The red irradiance of a floor (y is up) at p, by the midpoint rule over the disk.
local function irradiance(light, p)
  local u, v = require "ylm.light.polygon".frame(light.normal)
  local n, length, sum, side = light.normal, 0, 0, 12
  for a = 1, 3 do length = length + n[a] ^ 2 end
  for i = 1, side do
    local r = light.radius * math.sqrt((i - 0.5) / side)
    for k = 1, side do
      local c, s, way, d2, facing = math.cos(2 * math.pi * k / side), math.sin(2 * math.pi * k / side), {}, 0, 0
      for a = 1, 3 do
        way[a] = light.at[a] + r * (c * u[a] + s * v[a]) - p[a]
        d2, facing = d2 + way[a] ^ 2, facing + way[a] * n[a]
      end
      local cosine = math.abs(facing) / math.sqrt(d2 * length)
      sum = sum + cosine ^ (light.spread + 1) * math.max(0, way[2]) / d2 ^ 1.5
    end
  end
  return light.radiance[1] * sum * math.pi * light.radius ^ 2 / side ^ 2
end

--- The mean of the red channel, and of quadrature at the middle of each pixel of a floor that fills the picture.
local function means(light, image, view)
  local position, got, wanted, k = view:points().position, 0, 0, 0
  for i = 1, 9 do
    for j = 1, 12 do
      k = k + 1
      got = got + image:get(i, j, 1)
      wanted = wanted + irradiance(light, { position:get(k, 1), position:get(k, 2), position:get(k, 3) }) * 0.5 / math.pi
    end
  end
  return got / 108, wanted / 108
end

describe("disk_light { spread = }", function()
  for _, light in ipairs { lobe, with(lobe, { spread = 40 }), with(lobe, { spread = 0.5, normal = { 0, 1, 0 } }) } do
    local name = (" with n = %g"):format(light.spread)
    local scene = floor(ylm.disk_light(light))

    it("lights a floor as quadrature has it, by rays" .. name, function()
      local view = scene:prepare { size = { 12, 9 }, samples = 1, share = 0 }
      local got, wanted = means(light, view:render({ light_samples = 256, layers = false }):layer(), view)
      assert.is_true(math.abs(got / wanted - 1) < 0.005, got / wanted)
    end)

    it("and by paths, whether they aim at lamps or meet them" .. name, function()
      local view = scene:prepare { size = { 12, 9 }, samples = 1, share = 0 }
      local _, wanted = means(light, view:render({ light_samples = 1, layers = false }):layer(), view)
      for strategy, within in pairs { both = 0.02, lights = 0.02, material = 0.06 } do
        local got = means(light, scene:pathtrace({ size = { 12, 9 }, samples = 256, bounces = 0, strategy = strategy,
          layers = false }):layer(), view)
        assert.is_true(math.abs(got / wanted - 1) < within, strategy .. " " .. got / wanted)
      end
    end)

    it("and by links: elements have its irradiance" .. name, function()
      local lit = scene:links({ rays = 16, spacing = 0.1, sides = "front" }):radiosity(nil, { light_samples = 64 })
      local centres, E = lit:elements().centre, lit:irradiance "direct"
      local got, wanted = 0, 0
      for i = 1, #centres do
        local p = { centres:get(i, 1), centres:get(i, 2), centres:get(i, 3) }
        got, wanted = got + E:get(i, 1), wanted + irradiance(light, p)
      end
      assert.is_true(math.abs(got / wanted - 1) < 0.02, got / wanted)
    end)

    it("sends particles of its power" .. name, function()
      local _, r = scene:virtual_lights { count = 4000 }
      local power = 6 * 2 * math.pi * 0.09 * 2 * math.pi / (light.spread + 2)
      assert.is_true(math.abs(r.power.emitted[1] / power - 1) < 0.002, r.power.emitted[1] / power)
    end)
  end

  it("has the particles land where its light falls", function()
    local lights = floor(ylm.disk_light(with(lobe, { spread = 20 }))):virtual_lights { count = 5000 }
    local at, _, _, power = lights:arrays()
    local near, all, wanted, whole = 0, 0, 0, 0
    local function inside(x, z) return x ^ 2 + z ^ 2 < 0.16 end
    for i = 1, #at do
      local p = power:get(i, 1, 1)
      all = all + p
      if inside(at:get(i, 1), at:get(i, 3)) then near = near + p end
    end
    for i = 0, 39 do
      for k = 0, 39 do
        local x, z = (i + 0.5) / 20 - 1, (k + 0.5) / 20 - 1
        local e = irradiance(with(lobe, { spread = 20 }), { x, 0, z })
        whole = whole + e
        if inside(x, z) then wanted = wanted + e end
      end
    end
    assert.is_true(math.abs(near / all / (wanted / whole) - 1) < 0.04, near / all / (wanted / whole))
  end)

  it("is seen brightest along its normal", function()
    local light = with(lobe, { at = { 0, 0, 0 }, normal = { 0, 0, 2 }, radius = 1 })
    for _, angle in ipairs { 0, 30, 70, 150 } do
      local a = math.rad(angle)
      local scene = ylm.scene "a disk" { lights = ylm.disk_light(light), geometry = ylm.box { at = { 0, 90, 0 } },
        camera = ylm.camera { from = { 9 * math.sin(a), 0, 9 * math.cos(a) }, at = { 0, 0, 0 }, fov = 0.05 } }
      for _, image in ipairs { scene:render { bounces = 0, size = { 1, 1 }, layers = false },
        (scene:pathtrace { size = { 1, 1 }, samples = 16, layers = false }) } do
        local wanted = 6 * math.abs(math.cos(a)) ^ 5
        assert.is_true(math.abs(image:layer():get(1, 1, 1) - wanted) < 1e-3 * wanted, image:layer():get(1, 1, 1))
      end
    end
  end)

  it("keeps to its horizon, and is drawn from a tree among many", function()
    local many = {}
    for i = 1, 100 do
      many[i] = ylm.disk_light(with(lobe, { at = { (i % 20) / 10 - 1, 1.5, i / 50 - 1 }, radius = 0.02, spread = i % 3 }))
    end
    local o = { size = { 12, 9 }, samples = 64, bounces = 0, layers = false }
    local one, two = floor(many):pathtrace(o):layer(), floor(many):render({ bounces = 0, size = { 12, 9 }, samples = 64,
      light_samples = 16, layers = false }):layer()
    local a, b = one:mean(), two:mean()
    assert.is_true(math.abs(a / b - 1) < 0.02, a / b)
    local cut = ylm.disk_light(with(lobe, { horizon = { 0, -1, 0 } }))
    local dark = floor(cut):render { bounces = 0, size = { 4, 3 }, layers = false }
    assert.equal(0, dark:layer():max())
  end)

  it("of 0 is a disk as ever", function()
    local function of(light) return (ylm.light_field(3, ylm.disk_light(light), { { 0, 0, 0 } })) end
    assert.is_true(of(with(lobe, { spread = 0 })):same(of { at = lobe.at, normal = lobe.normal, radius = lobe.radius,
      radiance = lobe.radiance }))
  end)

  it("has no light field: what wants one refuses it by name", function()
    local light, why = ylm.disk_light(lobe), "a disk_light with spread has no light field"
    refused(why, function() ylm.light_field(2, light, { { 0, 0, 0 } }) end)
    local scene = floor(light)
    refused(why, function() scene:bake { probes = ylm.uniform_grid { cells = { 2, 2, 2 }, lmax = 1 } } end)
    refused(why, function() scene:render { by = "sum", size = { 4, 3 } } end)
    refused(why, function() scene:links({ rays = 16 }):radiosity():field { quantity = "direct" } end)
  end)

  it("refuses what is wrong", function()
    refused("spread must be a number >= 0 and <= 1000", function() ylm.disk_light(with(lobe, { spread = -1 })) end)
    refused("method is of light fields", function() ylm.disk_light(with(lobe, { method = "sphere" })) end)
  end)
end)
