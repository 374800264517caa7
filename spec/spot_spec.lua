-- ylm.spot_light: its light by rays, by paths, by radiosity and by virtual lights; refusals of what wants spherical harmonics.

local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"

local grey = ylm.matte { albedo = 0.5 }
local spot = { at = { 0, 2, 0 }, to = { 0, 0, 0 }, angle = 60, blend = 0, intensity = { 6, 4, 2 } }

local function floor(light)
  return ylm.scene "a floor" { lights = light, camera = ylm.camera { from = { 0, 4, 0.01 }, at = { 0, 0, 0 }, fov = 40 },
    geometry = ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = grey } }
end

--- Radiance of a floor of albedo 0.5 at p under a spot, by hand.
local function wanted(light, p)
  local v, d2 = {}, 0
  for a = 1, 3 do
    v[a] = p[a] - light.at[a]
    d2 = d2 + v[a] ^ 2
  end
  local cosine = -v[2] / math.sqrt(d2) -- to the axis and at the floor
  local outer, inner = math.cos(math.rad(light.angle / 2)), math.cos(math.rad(light.angle / 2 * (1 - light.blend)))
  local t = math.max(0, math.min(1, (cosine - outer) / math.max(inner - outer, 1e-9)))
  return light.intensity[1] * t * t * (3 - 2 * t) * cosine / d2 * 0.5 / math.pi
end

describe("spot_light", function()
  it("brings intensity cos/d^2 within its cone, fading at the rim", function()
    for _, blend in ipairs { 0, 0.5 } do
      local light = with(spot, { blend = blend })
      local view = floor(ylm.spot_light(light)):prepare { size = { 15, 11 }, samples = 1, share = 0 }
      local position, got, k, lit = view:points().position, view:render({ by = "rays", light_samples = 1,
        layers = false }):layer(), 0, 0
      for i = 1, 11 do
        for j = 1, 15 do
          k = k + 1
          local x = wanted(light, { position:get(k, 1), position:get(k, 2), position:get(k, 3) })
          assert.is_true(math.abs(got:get(i, j, 1) - x) < 1e-4 * (x + 0.1), ("%g, wanted %g"):format(got:get(i, j, 1), x))
          if x > 0 then lit = lit + 1 end
        end
      end
      assert.is_true(lit > 50 and lit < 165, lit)
    end
  end)

  it("is what paths find, by any strategy that aims at lamps, with its shadows", function()
    local scene = floor { ylm.spot_light(spot), ylm.sphere_light { at = { 1, 1, 0 }, radius = 0.2, radiance = 1 } }
    scene = ylm.scene "shadows" { lights = scene.lights, camera = scene.camera,
      geometry = { scene.geometry, ylm.box { at = { 0.3, 0.7, 0 }, scale = 0.3, material = grey } } }
    local function mean(image)
      local sum = 0
      for i = 1, 12 do for j = 1, 16 do sum = sum + image:layer():get(i, j, 2) / 192 end end
      return sum
    end
    local o = { size = { 16, 12 }, samples = 64, bounces = 0, layers = false }
    local rays = mean(scene:render { bounces = 0, size = { 16, 12 }, samples = 64, light_samples = 16, layers = false })
    for _, strategy in ipairs { "both", "lights" } do
      local paths = mean(scene:pathtrace(with(o, { strategy = strategy })))
      assert.is_true(math.abs(paths / rays - 1) < 0.02, paths / rays)
    end
    assert.is_true(mean(scene:pathtrace(with(o, { strategy = "material" }))) < 0.5 * rays)
    local all = mean(scene:pathtrace(with(o, { bounces = 1, samples = 256 })))
    local radiosity = mean(scene:render { size = { 16, 12 }, samples = 16, bounces = 1, rays = 256, layers = false })
    assert.is_true(math.abs(radiosity / all - 1) < 0.03, radiosity / all)
  end)

  it("sends particles of its power", function()
    for _, blend in ipairs { 0, 0.6 } do
      local light = with(spot, { blend = blend })
      local _, r = floor(ylm.spot_light(light)):virtual_lights { count = 2000 }
      local outer, inner = math.cos(math.rad(30)), math.cos(math.rad(30 * (1 - blend)))
      local power = 6 * 2 * math.pi * (1 - (outer + inner) / 2)
      assert.is_true(math.abs(r.power.emitted[1] / power - 1) < 0.01, r.power.emitted[1] / power)
      assert.equal(0, r.power.lost[1])
    end
  end)

  it("leaves a light for each texel of a grid, of its solid angle's power and footprint", function()
    local light = ylm.spot_light(with(spot, { angle = 80 }))
    local lights, r = floor(light):virtual_lights { distribution = "grid", count = 40 * 40, scale = 1 }
    local power = 6 * 2 * math.pi * (1 - math.cos(math.rad(40)))
    assert.is_true(math.abs(r.power.emitted[1] / power - 1) < 0.01, r.power.emitted[1] / power)
    assert.equal(1600, r.particles)
    local _, _, radius = lights:arrays()
    local area = 0
    for i = 1, #radius do area = area + math.pi * radius:get(i) ^ 2 end
    assert.is_true(math.abs(area / (math.pi * (2 * math.tan(math.rad(40))) ^ 2) - 1) < 0.02, area) -- the disc that is lit
    assert.is_true(math.abs(lights.power[1] / r.power.reflected[1] - 1) < 1e-6)
    refused("other lamps too", function()
      floor({ light, ylm.sphere_light { at = { 0, 1, 0 } } }):virtual_lights { distribution = "grid" }
    end)
  end)

  it("has the paper's radii on a grid, which cover more than a footprint", function()
    local side = 20
    local light = ylm.spot_light(with(spot, { angle = 90 }))
    local function covered(radius)
      local lights, r = floor(light):virtual_lights { distribution = "grid", count = side * side, radius = radius, scale = 1 }
      local _, _, radii = lights:arrays()
      local area = 0
      for i = 1, #radii do area = area + math.pi * radii:get(i) ^ 2 end
      return area, lights, r, radii
    end
    local once = covered "footprint"
    local two, lights, _, radii = covered "angle"
    local at = lights:arrays()
    for i = 1, #radii, 37 do
      local d = math.sqrt((at:get(i, 1) - spot.at[1]) ^ 2 + (at:get(i, 2) - spot.at[2]) ^ 2 + (at:get(i, 3) - spot.at[3]) ^ 2)
      assert.is_true(math.abs(radii:get(i) / (d * math.tan(math.sqrt(2) * math.pi / 2 / side)) - 1) < 1e-5)
    end
    local one = covered "neighbours"
    assert.is_true(two / once > 5.5 and two / once < 7, two / once)
    assert.is_true(one / once > 3.8 and one / once < 5.2, one / once)
    -- texels of a small grid, by hand: each has three neighbours at like ways
    local _, _, three = covered "neighbours"
    assert.is_true(three.radius.cut == 0)
    side = 2
    local _, corners, _, alike = covered "neighbours"
    local place = corners:arrays()
    local function apart(i, j)
      return math.sqrt((place:get(i, 1) - place:get(j, 1)) ^ 2 + (place:get(i, 3) - place:get(j, 3)) ^ 2)
    end
    for i = 1, 4 do
      local mean = 0
      for j = 1, 4 do mean = mean + apart(i, j) / 3 end
      assert.is_true(math.abs(alike:get(i) / mean - 1) < 1e-4)
    end
  end)

  it("has r1 and r2 of 3 x 3 texels as Eqs. 23 to 26 have them by hand", function()
    local light = ylm.spot_light(with(spot, { angle = 50, to = { 0.3, 0, 0.2 } }))
    local scene = floor(light)
    local function of(rule)
      local lights = scene:virtual_lights { distribution = "grid", count = 9, radius = rule, scale = 1 }
      local at, _, radius = lights:arrays()
      return at:totable(), radius:totable()
    end
    local function apart(p, q) return math.sqrt((p[1] - q[1]) ^ 2 + (p[2] - q[2]) ^ 2 + (p[3] - q[3]) ^ 2) end
    local at, r1 = of "neighbours"
    local _, r2 = of "angle"
    assert.equal(9, #at) -- row by row
    for i = 1, 9 do
      local way, sum, weights = apart(at[i], spot.at), 0, 0
      assert.is_near(1, r2[i] / (way * math.tan(math.sqrt(2) * math.rad(50) / 3)), 1e-5)
      for k = 1, 9 do
        local x, y = (k - 1) % 3 - (i - 1) % 3, math.floor((k - 1) / 3) - math.floor((i - 1) / 3)
        if k ~= i and math.abs(x) <= 1 and math.abs(y) <= 1 then
          local w = 1 / (math.abs(way - apart(at[k], spot.at)) + 1e-3 * way)
          sum, weights = sum + w * apart(at[i], at[k]), weights + w
        end
      end
      assert.is_near(1, r1[i] / (sum / weights), 1e-4)
    end
  end)

  it("has no light field: what wants one refuses it by name", function()
    local light = ylm.spot_light(spot)
    refused("a spot_light has no size, and no spherical harmonics", function() ylm.light_field(2, light, { { 0, 0, 0 } }) end)
    local scene = floor(light)
    refused("a spot_light has no size", function() scene:bake { probes = ylm.uniform_grid { cells = { 2, 2, 2 },
      lmax = 1 } } end)
    refused("a spot_light has no size", function() scene:render { by = "sum", size = { 4, 3 } } end)
    refused("a spot_light has no size", function() scene:links({ rays = 16 }):radiosity():field { quantity = "direct" } end)
  end)

  it("refuses what is wrong", function()
    refused("at and to are the same", function() ylm.spot_light(with(spot, { to = { 0, 2, 0 } })) end)
    refused("angle must be a number > 0 and <= 360", function() ylm.spot_light(with(spot, { angle = 0 })) end)
    refused("blend must be a number >= 0 and <= 1", function() ylm.spot_light(with(spot, { blend = 2 })) end)
    refused("field 'to' is missing", function() ylm.spot_light { at = { 0, 0, 0 } } end)
  end)
end)
