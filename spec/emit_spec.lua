-- scene:virtual_lights: particles from lamps and skies, their power, and the lights that they leave.

local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore

local LUMINANCE = { 0.2126, 0.7152, 0.0722 }
local grey = ylm.matte { albedo = 0.5 }
local lamp = ylm.sphere_light { at = { 0.3, -0.2, 0.1 }, radius = 0.1, radiance = { 10, 8, 6 } }
local FLUX = 4 * math.pi ^ 2 * 0.1 ^ 2 -- of a lamp of radiance 1

local function room(lights, material)
  return ylm.scene "a room" { geometry = { ylm.box { scale = 2, material = material or grey } }, lights = lights or lamp }
end
local floor = { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = grey }
local function ground(lights) return ylm.scene "a floor" { geometry = ylm.quad(floor), lights = lights } end

local function near(wanted, got, tolerance, what)
  assert.is_true(math.abs(got - wanted) <= tolerance * math.abs(wanted), ("%s: %.9g, wanted %.9g"):format(what or "", got,
    wanted))
end

local function luminance(c) return LUMINANCE[1] * c[1] + LUMINANCE[2] * c[2] + LUMINANCE[3] * c[3] end

--- All numbers of lights.
local function numbers(lights)
  local all = {}
  for i, a in ipairs { lights:arrays() } do all[i] = a:totable() end
  return all
end

describe("particles", function()
  it("carry the lamps' power, which lands or is lost, and is reflected by albedo", function()
    local lights, r = room():virtual_lights { count = 1000 }
    assert.equal(1000, lights.count)
    assert.same({ 1000 }, r.bounces)
    for c, radiance in ipairs { 10, 8, 6 } do
      near(FLUX * radiance, r.power.emitted[c], 1e-6, "emitted")
      near(r.power.emitted[c], r.power.landed[c] + r.power.lost[c], 1e-6, "landed and lost")
      near(0.5 * r.power.landed[c], r.power.reflected[c], 1e-6, "reflected")
      near(r.power.reflected[c], lights.power[c], 1e-6, "of the lights")
      assert.equal(0, r.power.lost[c])
    end
  end)

  it("leave the scene where it is open", function()
    local _, r = ground(ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 1 }):virtual_lights { count = 4000 }
    -- the solid angle of a square of side 2, seen from 1 above its middle, is 4 asin(1/2)
    near(4 * math.asin(0.5) / (4 * math.pi), r.power.landed[1] / r.power.emitted[1], 0.02)
    near(r.power.emitted[1], r.power.landed[1] + r.power.lost[1], 1e-6)
  end)

  it("come from flat lamps on both sides, from textured ones, and from one side where they have a horizon", function()
    local square = { vertices = { { -0.5, 0, -0.5 }, { 0.5, 0, -0.5 }, { 0.5, 0, 0.5 }, { -0.5, 0, 0.5 } }, radiance = 2 }
    local _, r = room(ylm.polygon_light(square)):virtual_lights { count = 500 }
    near(2 * math.pi * 2, r.power.emitted[1], 1e-6, "square")
    _, r = room(ylm.disk_light { at = { 0, 0, 0 }, radius = 0.5, normal = { 0, 1, 0.3 }, radiance = 2 }):virtual_lights {
      count = 500 }
    near(2 * math.pi * 2 * math.pi * 0.25, r.power.emitted[1], 1e-6, "disk")
    square.horizon = { 0, -1, 0 }
    _, r = room(ylm.polygon_light(square)):virtual_lights { count = 500 }
    near(math.pi * 2, r.power.emitted[1], 1e-6, "one side")
    _, r = room(ylm.polygon_light(with(square, { horizon = { 0.6, 0.8, 0 } }))):virtual_lights { count = 4000 }
    near(math.pi * 2, r.power.emitted[1], 0.02, "a tilted horizon")
    local image = ylm.image { size = { 2, 1 }, layers = { { "radiance", 3 } } }
    image:layer "radiance":set(1, 1, 1, 4)
    _, r = room(ylm.textured_light { corner = { -0.5, 0, 0.5 }, u = { 1, 0, 0 }, v = { 0, 0, -1 }, image = image })
      :virtual_lights { count = 1000 }
    near(2 * math.pi * 2, r.power.emitted[1], 0.02, "texture: half of it shines")
  end)

  it("come from suns and skies, as wide as the scene", function()
    local _, r = ground(ylm.sun_light { direction = { 0, 1, 0 }, irradiance = 3 }):virtual_lights { count = 4000 }
    near(3 * 4, r.power.landed[1], 0.02, "sun")
    _, r = ground(ylm.environment_light { radiance = 1 }):virtual_lights { count = 4000 }
    near(2 * math.pi * 4, r.power.landed[1], 0.04, "sky, on both sides")
  end)

  it("are reflected until they end: rho/(1 - rho) of the power in a closed white room, within 3 sigma", function()
    local scene, sum, square, n = room(), 0, 0, 16
    for seed = 1, n do
      local _, r = scene:virtual_lights { count = 400, bounces = "all", seed = seed }
      local x = r.power.reflected[2] / (8 * FLUX)
      sum, square = sum + x, square + x * x
      assert.is_true(#r.bounces > 5)
    end
    local mean = sum / n
    local sigma = math.sqrt((square / n - mean * mean) / (n - 1))
    assert.is_true(math.abs(mean - 1) < 3 * sigma and sigma < 0.02, ("%g, sigma %g"):format(mean, sigma))
  end)

  it("make the same lights whatever the number of threads", function()
    local scene, first = room(), nil
    for _, threads in ipairs { 1, 2, 7 } do
      local all = numbers((scene:virtual_lights { count = 700, particles = 2000, bounces = 3, threads = threads }))
      first = first or all
      assert.same(first, all)
    end
  end)

  it("keep their numbers while a lamp moves", function()
    local places = {}
    for i, x in ipairs { 0, 1e-3 } do
      local scene = room(ylm.sphere_light { at = { x, 0, 0 }, radius = 0.1, radiance = 1 })
      places[i] = scene:virtual_lights({ count = 300 }):arrays():totable()
    end
    local far = 0
    for i, p in ipairs(places[1]) do
      local q = places[2][i]
      if math.abs(p[1] - q[1]) + math.abs(p[2] - q[2]) + math.abs(p[3] - q[3]) > 0.02 then far = far + 1 end
    end
    assert.is_true(far < 6, far) -- that meet another wall
  end)

  it("land on the side that they come from, and never below the triangle", function()
    local at, normal = room():virtual_lights({ count = 200 }):arrays()
    for i = 1, #at do
      local inward = 0
      for a = 1, 3 do inward = inward - at:get(i, a) * normal:get(i, a) end
      assert.is_true(math.abs(inward - 1) < 1e-5)
    end
    local bent = ylm.mesh { vertices = { { -1, 0, 1 }, { 1, 0, 1 }, { 0, 0, -1 } }, triangles = { { 1, 2, 3 } },
      normals = { { 0.9, -0.4, 0 }, { 0.9, -0.4, 0 }, { 0.9, -0.4, 0 } } }
    local scene = ylm.scene "bent" { geometry = bent, lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 1 } }
    local lights, r = scene:virtual_lights { count = 200 }
    local _, turned = lights:arrays()
    assert.is_true(r.turned > 0)
    for i = 1, #turned do assert.is_true(turned:get(i, 2) > 0.3) end
  end)
end)

describe("lights of more landings than are wanted", function()
  it("are chosen by power, each for the same share of it", function()
    local scene = ylm.scene "two greys" { lights = lamp,
      geometry = { ylm.box { scale = 2, material = grey }, ylm.quad(with(floor, { material = ylm.matte { albedo = 0.1 } })) } }
    local lights, r = scene:virtual_lights { count = 100, particles = 3000, bounces = 2 }
    assert.is_true(lights.count <= 100 and lights.count > 90)
    near(luminance(r.power.reflected), luminance(lights.power), 1e-6)
    local _, _, _, e = lights:arrays()
    local share = luminance(r.power.reflected) / 100
    for i = 1, #e do
      local c = { e:get(i, 1, 1), e:get(i, 2, 1), e:get(i, 3, 1) }
      local times = luminance(c) * math.pi / math.sqrt(4 * math.pi) / share
      assert.is_true(math.abs(times - math.floor(times + 0.5)) < 1e-5, times)
    end
  end)
end)

describe("radii", function()
  it("are those of discs that share a surface evenly, times scale", function()
    local _, r = ground(ylm.sun_light { direction = { 0, 1, 0 } }):virtual_lights { count = 3000, scale = 1 }
    local even = math.sqrt(4 / math.pi / r.lights)
    assert.is_true(math.abs(r.radius.median / even - 1) < 0.12, r.radius.median / even)
    assert.is_true(r.radius.max <= 4 * r.radius.median * (1 + 1e-12) and r.radius.min > 0)
  end)

  it("are by the tenth light within 60 degrees and d/2 of the tangent plane", function()
    local lights = ylm.scene "a ball in a room" { lights = lamp,
      geometry = { ylm.box { scale = 2, material = grey }, ylm.sphere { at = { -0.4, -0.5, 0 }, radius = 0.3, material = grey } },
    }:virtual_lights { count = 400, scale = 1 }
    local all = numbers(lights)
    local at, normal, radius = all[1], all[2], all[3]
    local wanted = {}
    for i, x in ipairs(at) do
      local list = {}
      for j, y in ipairs(at) do
        local d2, up, facing = 0, 0, 0
        for a = 1, 3 do
          local v = y[a] - x[a]
          d2, up, facing = d2 + v * v, up + v * normal[i][a], facing + normal[i][a] * normal[j][a]
        end
        if j ~= i and facing >= 0.5 and up * up <= 0.25 * d2 then list[#list + 1] = d2 end
      end
      table.sort(list)
      wanted[i] = math.sqrt(list[10] / 10)
    end
    local sorted = { unpack(wanted) }
    table.sort(sorted)
    for i, r in ipairs(wanted) do near(math.min(r, 4 * sorted[201]), radius[i], 1e-5, "light " .. i) end
  end)

  it("take no neighbours from behind a wall or around a corner", function()
    local thin = ylm.scene "sheets" { lights = ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.1, radiance = 1 },
      geometry = { ylm.quad(floor), ylm.quad(with(floor, { corner = { -1, -1e-3, 1 } })) } }
    local one = ground(thin.lights):virtual_lights { count = 500 }
    assert.same(numbers(one), numbers((thin:virtual_lights { count = 500 })))
  end)

  it("are a length that is given, or the paper's angle", function()
    local _, r = room():virtual_lights { count = 50, radius = 0.25 }
    assert.same({ 0.25, 0.25, 0.25 }, { r.radius.min, r.radius.median, r.radius.max })
    _, r = room():virtual_lights { count = 400, radius = "angle" }
    assert.is_true(r.radius.median > 0.08 and r.radius.median < 0.16, r.radius.median) -- about 1.2 m times 2/sqrt(400)
  end)
end)

describe("scene:virtual_lights", function()
  it("says why there is no light", function()
    local function note(scene, options)
      local lights, r = scene:virtual_lights(options or { count = 20 })
      assert.equal(0, lights.count)
      return r.note
    end
    assert.matches("no lamps that shine", note(ylm.scene "dark" { geometry = ylm.box {} }))
    assert.matches("no lamps that shine", note(room(ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 0 })))
    assert.matches("no surface", note(ylm.scene "empty" { lights = lamp }))
    assert.matches("20 left the scene", note(ground(ylm.disk_light { at = { 9, 0, 0 }, normal = { 1, 0, 0 }, radius = 1e-3,
      radiance = 1 })))
    assert.matches("black", note(room(lamp, ylm.matte { albedo = 0 })))
    assert.equal("bounces = 0: no indirect light", note(room(), { bounces = 0 }))
  end)

  it("says that glossy surfaces send light on as matte ones where they are told to", function()
    local said = {}
    local before = ylm.on_warning(function(text) said[#said + 1] = text end)
    local _, r = room(lamp, ylm.ggx { alpha = 0.3, f0 = 0.5 }):virtual_lights { count = 20, degree = 0 }
    ylm.on_warning(before)
    assert.equal(20, r.glossy)
    assert.matches("glossy surfaces, which send light on as matte ones", r.warnings[1])
    assert.same(said, r.warnings)
  end)

  it("says how much is under way where nearly nothing is absorbed", function()
    local before = ylm.on_warning(false)
    local _, r = room(lamp, ylm.matte { albedo = 1 }):virtual_lights { particles = 200, count = 10, bounces = "all" }
    ylm.on_warning(before)
    assert.matches("still under way after 64 reflections", r.warnings[1])
    assert.is_true(r.power.going[1] > 0)
  end)

  it("refuses what is wrong", function()
    local scene = room()
    refused("particles %(10%) must be at least as many as count", function()
      scene:virtual_lights { count = 20, particles = 10 }
    end)
    refused("count must be an integer >= 1", function() scene:virtual_lights { count = 0 } end)
    refused("bounces must be a number of reflections, 0 to 64", function() scene:virtual_lights { bounces = 65 } end)
    refused("radius must be 'density', 'angle', 'footprint', 'neighbours', or a length above 0", function()
      scene:virtual_lights { radius = -1 }
    end)
    refused("radius must be", function() scene:virtual_lights { radius = 0 / 0 } end)
    refused("scale must be a number > 0", function() scene:virtual_lights { scale = 0 } end)
    refused("profile must be one of 'gauss', 'cap', 'point'", function() scene:virtual_lights { profile = "near" } end)
  end)

  it("ends where progress says so", function()
    local lights, message, code = room():virtual_lights { count = 100000, threads = 1, progress = function() return false end }
    assert.same({ nil, "cancelled", "ECANCELLED" }, { lights, message, code })
  end)
end)

describe("ylm emit", function()
  it("writes lights as points of a PLY file", function()
    local lights = room():virtual_lights { count = 60 }
    local folder = scratch.new()
    assert(require "ylm.emit".write(lights, folder.path .. "/lights.ply"))
    local text = folder:read "lights.ply"
    folder:remove()
    assert.matches("^ply\nformat binary_little_endian 1.0\n", text)
    assert.matches("element vertex 60\n", text)
    assert.equal(60 * 43, #text - (select(2, text:find "end_header\n")))
  end)
end)
