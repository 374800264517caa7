-- Virtual lights against what is known of them: the limit of small radii, the integrating sphere, power by kinds of lamps,
-- derivatives; and bad input, each with its sentence.

local core = require "ylm.c.core"
local refused = require "spec.support.raises"
local with = require "spec.support.with"
local ylm = require "ylm"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local origin = { { 0, 0, 0 } }
local grey = ylm.matte { albedo = 0.5 }

local function double(lmax, l, x, derivatives)
  return ylm.light_field(lmax, l, ylm.array(x, "double"), { derivatives = derivatives, channels = "luminance" })
end

describe("profiles of small radius", function()
  it("tend to the point degree by degree: as (r/d)^2 l(l+1)/8, and |(l-1)(l+2)|/8 of a cap", function()
    local x = { { 0.6, 0, 0.8 } } -- d = 1
    local point = double(6, ylm.virtual_lights { at = origin, intensity = 1, profile = "point" }, x):totable()[1][1]
    local law = { gauss = function(l) return l * (l + 1) / 8 end, cap = function(l) return math.abs((l - 1) * (l + 2)) / 8 end }
    for profile, factor in pairs(law) do
      local off = {}
      for i, r in ipairs { 2e-3, 1e-3 } do
        local L = double(6, ylm.virtual_lights { at = origin, radius = r, intensity = 1, profile = profile }, x):totable()[1][1]
        off[i] = {}
        for l = 0, 6 do
          local d, n = 0, 0
          for k = l * l + 1, (l + 1) ^ 2 do d, n = d + (L[k] - point[k]) ^ 2, n + point[k] ^ 2 end
          off[i][l] = math.sqrt(d / n) / r ^ 2
        end
      end
      for l = 0, 6 do
        local wanted = factor(l)
        assert.is_near(wanted, off[2][l], 1e-4 * wanted + 1e-7, profile .. l)
        if wanted > 0 then assert.is_near(4, 4 * off[1][l] / off[2][l], 1e-3) end -- halvings divide by four
      end
    end
  end)

  it("of gauss are the point's irradiance in open parts, and never brighter near a wall of lights", function()
    local L = double(4, ylm.virtual_lights { at = origin, normal = { { 0, 0, 1 } }, radius = 0.1, intensity = 1 },
      { { 0, 0, 3 } })
    local P = double(4, ylm.virtual_lights { at = origin, normal = { { 0, 0, 1 } }, intensity = 1, profile = "point" },
      { { 0, 0, 3 } })
    assert.is_near(P:get(1, 1, 1), L:get(1, 1, 1), 1e-4)
    assert.is_true(L:get(1, 1, 7) < P:get(1, 1, 7))
  end)
end)

describe("an integrating sphere", function()
  local R, rho, Phi = 2, 0.6, 7

  it("has L00 = sqrt(4 pi) rho Phi/(4 pi^2 R^2) in its centre, of any lights, and nothing else of even ones", function()
    local n, at, normal, some = 4000, {}, {}, {}
    for i = 1, n do
      local z, phi = 1 - (2 * i - 1) / n, i * 2.399963229728653
      local r = math.sqrt(1 - z * z)
      at[i] = { R * r * math.cos(phi), R * r * math.sin(phi), R * z }
      normal[i] = { -at[i][1] / R, -at[i][2] / R, -at[i][3] / R }
      some[i] = rho * Phi / math.pi / n * (1 + math.sin(i)) -- their sum is not rho Phi/pi
    end
    local wanted, all = math.sqrt(4 * math.pi) * rho * Phi / (4 * math.pi ^ 2 * R ^ 2), 0
    for i = 1, n do all = all + some[i] end
    local any = ylm.virtual_lights { at = at, normal = normal, intensity = some, profile = "point" }
    assert.is_near(1, double(0, any, origin):get(1, 1, 1) / (wanted * all * math.pi / (rho * Phi)), 1e-12)
    local even = ylm.virtual_lights { at = at, normal = normal, intensity = rho * Phi / math.pi / n, profile = "point" }
    local L = double(6, even, origin)
    assert.is_near(1, L:get(1, 1, 1) / wanted, 1e-12)
    for k = 2, 49 do assert.is_true(math.abs(L:get(1, 1, k)) < 2e-4 * wanted, k) end
  end)

  it("has it too of lights that a lamp in its centre leaves", function()
    local scene = ylm.scene "a ball" { geometry = ylm.sphere { radius = R, divide = { 128, 64 },
      material = ylm.matte { albedo = rho } },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.05, radiance = Phi / (4 * math.pi ^ 2 * 0.05 ^ 2) } }
    local lights, report = scene:virtual_lights { count = 10000, profile = "point" }
    assert.is_near(Phi, report.power.emitted[1], 1e-5)
    local L = double(2, lights, origin)
    local wanted = math.sqrt(4 * math.pi) * rho * Phi / (4 * math.pi ^ 2 * R ^ 2)
    assert.is_near(1, L:get(1, 1, 1) / wanted, 2e-3) -- triangles lie within the sphere
    for k = 2, 9 do assert.is_true(math.abs(L:get(1, 1, k)) < 0.02 * wanted, k) end
  end)
end)

describe("power", function()
  local image = ylm.image { size = { 2, 1 }, layers = { { "radiance", 3 } } }
  image:fill(1, 1, 1, 1, { 4, 2, 1 })
  local panorama = ylm.image { size = { 8, 4 }, layers = { { "radiance", 3 } } }
  for x = 1, 8 do for y = 1, 4 do panorama:fill(x, y, 1, 1, { x, y, 0.5 }) end end
  local corners = { { -0.3, 0.5, -0.3 }, { 0.3, 0.5, -0.3 }, { 0.3, 0.5, 0.3 }, { -0.3, 0.5, 0.3 } }
  local lamps = {
    ["a sphere"] = ylm.sphere_light { at = { 0, 0.2, 0 }, radius = 0.1, radiance = { 3, 2, 1 } },
    ["spheres of an array"] = ylm.sphere_lights { at = { { 0, 0.2, 0 }, { 0.4, 0, 0.2 } }, radius = { 0.1, 0.05 },
      radiance = { { 3, 2, 1 }, { 1, 5, 9 } } },
    ["a polygon"] = ylm.polygon_light { vertices = corners, radiance = { 3, 2, 1 } },
    ["a polygon with a horizon"] = ylm.polygon_light { vertices = corners, radiance = 3, horizon = { 0, -1, 0 } },
    ["a disk"] = ylm.disk_light { at = { 0, 0.5, 0 }, radius = 0.3, normal = { 0.6, -0.8, 0 }, radiance = { 3, 2, 1 } },
    ["a texture"] = ylm.textured_light { corner = { -0.3, 0.5, -0.3 }, u = { 0.6, 0, 0 }, v = { 0, 0, 0.6 }, image = image },
    ["a spot"] = ylm.spot_light { at = { 0, 0.8, 0 }, to = { 0.2, -1, 0 }, angle = 60, blend = 0.3, intensity = { 3, 2, 1 } },
    ["a sun"] = ylm.sun_light { direction = { 0.3, 1, 0.2 }, irradiance = { 3, 2, 1 } },
    ["a sun with a disk"] = ylm.sun_light { direction = { 0.3, 1, 0.2 }, irradiance = 2, angle = 10 },
    ["a uniform sky"] = ylm.environment_light { radiance = { 3, 2, 1 } },
    ["a sky of an image"] = ylm.environment_light { image = panorama },
    ["a sky of coefficients"] = ylm.environment_light { coefficients = { 3, 0.5, 0.2, -0.4 } },
    ["a clear sky"] = ylm.environment_light { sky = { kind = "clear", sun = { 0.3, 0.8, 0.1 }, zenith = { 0, 1, 0 } } },
    ["all of them"] = {},
  }
  for name, lamp in pairs(lamps) do if name ~= "all of them" then table.insert(lamps["all of them"], lamp) end end

  for name, lamp in pairs(lamps) do
    it("closes to 1e-6, particle by particle and bounce by bounce: " .. name, function()
      local scene = ylm.scene "an open box" { lights = lamp, geometry = {
        ylm.quad { corner = { -1, -1, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = grey },
        ylm.quad { corner = { -1, -1, -1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, material = grey } } }
      for _, o in ipairs { { particles = 600 }, { particles = 600, bounces = 3 }, { count = 40, merge = true },
        { count = 50, particles = 600 } } do
        local lights, r = scene:virtual_lights(o)
        local p = r.power
        assert.is_true(lights.count > 10 and p.emitted[1] > 0)
        local function bright(c) return 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end
        for c = 1, 3 do
          assert.is_true(math.abs(p.landed[c] + p.lost[c] - p.emitted[c]) <= 1e-6 * p.emitted[c])
          if not o.bounces then assert.is_true(math.abs(0.5 * p.landed[c] - p.reflected[c]) <= 1e-6 * p.reflected[c]) end
          if o.merge or not o.count then assert.is_true(math.abs(lights.power[c] - p.reflected[c]) <= 1e-6 * p.reflected[c]) end
        end
        assert.is_true(math.abs(bright(lights.power) - bright(p.reflected)) <= 1e-6 * bright(p.reflected))
      end
    end)
  end
end)

describe("derivatives", function()
  it("of all profiles are those that differences find, among many lights of degree 2", function()
    math.randomseed(12)
    local o = { at = {}, normal = {}, emission = {}, radius = 0.3 }
    for i = 1, 20 do
      o.at[i], o.normal[i] = { math.random(), math.random(), math.random() }, i % 2 == 0 and { 0, 0.6, 0.8 } or { 0, 0, 0 }
      local b = { 3 }
      for k = 2, 9 do b[k] = math.random() - 0.5 end
      o.emission[i] = { b, b, b }
    end
    local h, x = 1e-4, { 1.7, -0.6, 1.4 }
    for _, profile in ipairs { "gauss", "cap", "point" } do
      local lights = ylm.virtual_lights(with(o, { profile = profile }))
      local L, dL, ddL = double(4, lights, { x }, 2)
      for a = 1, 3 do
        local p, q = { x[1], x[2], x[3] }, { x[1], x[2], x[3] }
        p[a], q[a] = p[a] + h, q[a] - h
        local up, down = double(4, lights, { p, q }, 1), select(2, double(4, lights, { p, q }, 1))
        local second = ({ 1, 4, 6 })[a]
        for k = 1, 25 do
          assert.is_near((up:get(1, 1, k) - up:get(2, 1, k)) / (2 * h), dL:get(1, 1, k, a), 1e-5)
          assert.is_near((down:get(1, 1, k, a) - down:get(2, 1, k, a)) / (2 * h), ddL:get(1, 1, k, second), 1e-4)
        end
      end
      assert.is_true(L:get(1, 1, 1) > 0)
    end
  end)
end)

-- Bad input --------------------------------------------------------------------------------------

describe("virtual lights that cannot be", function()
  local nan, inf = 0 / 0, math.huge
  local two = { at = { { 0, 0, 0 }, { 1, 0, 0 } }, radius = 0.1, intensity = 1 }
  local function says(pattern, more) refused(pattern, function() ylm.virtual_lights(with(two, more)) end) end

  it("are refused where a number is not finite, or out of its range", function()
    for _, bad in ipairs { nan, inf, -inf } do
      says("light 2: its place is not finite", { at = { { 0, 0, 0 }, { 0, bad, 0 } } })
      says("light 2: radius must be 0 to", { radius = { 1, bad } })
      says("light 2: its emission is not finite", { intensity = { { 1, 1, 1 }, { 1, 1, bad } } })
      says("light 2: shift must be 0 to 1", { shift = { 0, bad } })
      says("light 2: its normal must have length 1", { normal = { { 0, 0, 1 }, { 0, 0, bad } } })
    end
    says("light 1: shift must be 0 to 1, got %-0.1", { shift = -0.1 })
    says("light 2: radius must be above 0 for profile 'cap'", { radius = { 1, 0 }, profile = "cap" })
    says("shift must be a number, or one for each of the 2 lights", { shift = { 0, 0, 0 } })
    says("intensity must be", { intensity = { 1, 2, 3, 4 } })
    says("at must be %[n%]%[3%] numbers", { at = { { 0, 0 } } })
  end)

  it("are refused of degree 9, here and where they are traced", function()
    local rows = {}
    for c = 1, 3 do
      rows[c] = {}
      for k = 1, 100 do rows[c][k] = 0 end
    end
    refused("emission must be %[1%]%[3%]%[%(degree%+1%)%^2%] numbers, degree 0 to 8", function()
      ylm.virtual_lights { at = origin, radius = 1, emission = { rows } }
    end)
    for c = 1, 3 do for k = 82, 100 do rows[c][k] = nil end end
    assert.equal(8, ylm.virtual_lights { at = origin, radius = 1, emission = { rows } }.degree)
    local scene = ylm.scene "a box" { geometry = ylm.box {}, lights = ylm.sphere_light { at = { 0, 0, 0 } } }
    refused("degree must be 'auto', or an integer from 0 to 8", function() scene:virtual_lights { degree = 9 } end)
    refused("no such degree", function()
      core.lights_virtual(ylm.zeros { 1, 3 }, nil, ylm.array { 1 }, nil, 9, ylm.zeros { 1, 3, 100 }, "gauss")
    end)
  end)

  it("are nothing at a point without size, darkness of no lights", function()
    local point = ylm.virtual_lights { at = origin, intensity = 1, profile = "point" }
    assert(core.array_within(ylm.light_field(2, point, origin, { derivatives = 1 }), 0))
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, point)
    assert(core.array_within(grid:sample(origin), 0))
    local none = ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }
    assert.same({ 0, 0, 0 }, none.power)
    assert(core.array_within(ylm.light_field(2, none, origin), 0))
  end)
end)

describe("virtual lights where they are not known", function()
  local lights = ylm.virtual_lights { at = origin, radius = 0.2, intensity = 1 }
  local box = { { -1, -1, -1 }, { 1, 1, 1 } }

  it("are refused by name: dynamic grids, views, rays", function()
    refused("this is baked from virtual lights", function()
      ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 1, dynamic = true }, lights)
    end)
    refused("virtual lights have no body to be drawn", function() ylm.view { lights = { lights } } end)
    local scene = ylm.scene "lit" { geometry = ylm.box {}, lights = lights, camera = ylm.camera { from = { 0, 0, 3 } } }
    for _, name in ipairs { "pathtrace", "render" } do
      refused("virtual lights have no body", function() scene[name](scene, { size = { 2, 2 } }) end)
    end
  end)

  it("are refused by name: devices, of bakes and of sums", function()
    local gpu = require "spec.support.gpu"
    local chosen, missing = gpu.choose()
    if not chosen then pending("no Vulkan device: " .. missing) end
    local device = gpu.open()
    refused("a device sums .*, and here are virtual lights", function() device:lights(lights) end)
    refused("virtual lights", function()
      ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 1 }, lights, { device = device })
    end)
    device:close()
  end)

  it("have no horizon in a grid, and irradiance is not measured without points and normals", function()
    local scene = ylm.scene "lit" { geometry = ylm.box { scale = 2 },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 },
      camera = ylm.camera { from = { 0.5, 0, 0 }, at = { -1, 0, 0 } } }
    local view = assert(scene:prepare { size = { 3, 2 }, samples = 1 })
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 1 }, lights)
    refused("no field 'horizon'", function() view:render { grid = grid, horizon = "paper" } end)
    local adaptive = ylm.adaptive_grid { bounds = box, lmax = 1, depth = 2, tolerance = 0.1, measure = "irradiance" }
    refused("irradiance needs normals", function() ylm.bake(adaptive, lights) end)
    refused("irradiance needs normals", function() ylm.bake(adaptive, lights, { occupied = { { 0, 0, 0.5 } } }) end)
    refused("measure", function()
      ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 1, measure = "irradiance" }, lights)
    end)
  end)
end)

describe("emission that is cancelled", function()
  it("ends in each of its steps: particles, merging, radii", function()
    local scene = ylm.scene "a box" { geometry = ylm.box { scale = 2, material = grey },
      lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 } }
    for stage, o in pairs { particles = { particles = 40000 }, radius = { particles = 40000 },
      merge = { particles = 40000, count = 20000, merge = true } } do
      local seen = false
      o.progress = function(_, _, at)
        seen = seen or at == stage
        return at ~= stage
      end
      o.threads = 1
      local lights, message, code = scene:virtual_lights(o)
      assert.is_true(seen, stage)
      assert.same({ nil, "cancelled", "ECANCELLED" }, { lights, message, code }, stage)
      assert(scene:virtual_lights { count = 10 }) -- all is as before
    end
  end)
end)
