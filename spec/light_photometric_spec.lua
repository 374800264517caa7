-- ylm.photometric_light: its light field against lights that are known in closed form, its light by rays and particles.

local core = require "ylm.c.core"
local errors = require("spec.support.derivatives").errors
local refused = require "spec.support.raises"
local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local ylm = require "ylm"

local cosine = ylm.photometry { cosine = 1, lumens = 1000 }
local even = ylm.photometry { intensity = function() return 50 end }
--- A wide beam, stronger along C0, with some light above the lamp.
local wide = ylm.photometry { lumens = 3000, intensity = function(g, c)
  local up = 0.1 * math.sin(g) ^ 2
  return up + math.exp(-((g - 0.8) / 0.5) ^ 2) * (1 + 0.5 * math.cos(c) ^ 2) * (1 + math.cos(g)) ^ 2
end }

local function lamp(p, opening, more)
  return ylm.photometric_light(with({ photometry = p, at = { 0.1, 2, 0 }, opening = opening }, more or {}))
end

local points = { { 0, 0, 0 }, { 1, 0.5, 0.7 }, { 0.3, 1.8, 0.1 }, { -30, -5, 20 } }

--- The largest relative difference of coefficients, gradients and Hessians.
local function apart(a, b)
  local worst = {}
  local first = { ylm.light_field(5, a, points, { derivatives = 2, dtype = "double" }) }
  local second = { ylm.light_field(5, b, points, { derivatives = 2, dtype = "double" }) }
  for k = 1, 3 do
    local x, y, size = first[k]:totable(), second[k]:totable(), 0
    worst[k] = 0
    local function walk(u, v, f)
      if type(u) == "number" then return f(u, v) end
      for i = 1, #u do walk(u[i], v[i], f) end
    end
    for i = 1, #points do
      local d = 0
      size = 0
      walk(x[i], y[i], function(u, v) d, size = d + (u - v) ^ 2, size + v * v end)
      worst[k] = math.max(worst[k], math.sqrt(d / size))
    end
  end
  return worst
end

describe("photometric_light", function()
  it("is the even sphere, disk and polygon of a table that they have", function()
    local down = { 0, -1, 0 }
    local cases = {
      { lamp(even, { shape = "sphere", radius = 0.1 }),
        ylm.sphere_light { at = { 0.1, 2, 0 }, radius = 0.1, radiance = 50 / (math.pi * 0.01) } },
      { lamp(cosine, { shape = "disk", radius = 0.2 }),
        ylm.disk_light { at = { 0.1, 2, 0 }, normal = down, radius = 0.2, radiance = cosine.peak / (math.pi * 0.04) } },
      { lamp(cosine, { shape = "rectangle", size = { 0.6, 0.2 } }), ylm.polygon_light { radiance = cosine.peak / 0.12,
        vertices = { { -0.2, 2, -0.1 }, { 0.4, 2, -0.1 }, { 0.4, 2, 0.1 }, { -0.2, 2, 0.1 } } } } }
    for i, case in ipairs(cases) do
      local worst = apart(case[1], case[2])
      local most = i == 1 and { 1e-12, 1e-12, 1e-12 } or { 1e-8, 1e-7, 3e-6 }
      for k = 1, 3 do assert.is_true(worst[k] < most[k], ("%d, order %d: %g"):format(i, k - 1, worst[k])) end
    end
  end)

  it("has the derivatives of its field", function()
    for _, opening in ipairs { { shape = "sphere", radius = 0.1 }, { shape = "disk", radius = 0.2 },
      { shape = "rectangle", size = { 0.6, 0.2 } } } do
      local l = lamp(wide, opening, { to = { 0.5, 0, 0.3 }, turn = 40 })
      for i = 1, 3 do -- beside the table's angles, where third derivatives jump
        local x = { 1.5 * math.sin(3 * i), 0.3 + 0.2 * i, math.cos(5 * i) }
        local gradient, hessian = errors(3, l, x, 1e-5)
        assert.is_true(gradient < 1e-8 and hessian < 1e-8, ("%s, %d: %g, %g"):format(opening.shape, i, gradient, hessian))
      end
    end
  end)

  it("sends I cos/d^2 from afar, whichever its opening", function()
    for _, opening in ipairs { { shape = "sphere", radius = 0.01 }, { shape = "disk", radius = 0.01 },
      { shape = "rectangle", size = { 0.02, 0.01 } } } do
      local l = lamp(wide, opening, { turn = 25, dim = 0.5 })
      local x = { 2.1, -1, 1.5 }
      local v = { x[1] - 0.1, x[2] - 2, x[3] }
      local d = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
      local s, c = math.sin(math.rad(25)), math.cos(math.rad(25))
      -- C0 is +x turned towards C90, which is C0 x axis: -z of a lamp that looks down.
      local I = 0.5 * wide:intensity { (c * v[1] - s * v[3]) / d, (-s * v[1] - c * v[3]) / d, -v[2] / d }
      local L = ylm.light_field(0, l, x, { dtype = "double" })
      assert.is_true(math.abs(L:get(2, 1) / (I / d ^ 2 / math.sqrt(4 * math.pi)) - 1) < 1e-4, opening.shape)
    end
  end)

  it("shines the same for any number of threads, alone or among others, in float near double", function()
    local list = { lamp(wide), lamp(cosine, { shape = "disk", radius = 0.3 }), ylm.photometric_light { photometry = wide,
      at = { 2, 2, 1 }, temperature = 3000 } }
    local one = ylm.light_field(4, list, points, { dtype = "double", threads = 1 })
    local two = ylm.light_field(4, list, points, { dtype = "double", threads = 2 })
    assert.same(one:totable(), two:totable())
    local narrow = ylm.light_field(4, list, points)
    for i = 1, #points do
      local sum = 0
      for _, l in ipairs(list) do sum = sum + ylm.light_field(4, l, points[i], { dtype = "double" }):get(1, 1) end
      assert.is_true(math.abs(one:get(i, 1, 1) - sum) < 1e-12 * sum)
      assert.is_true(math.abs(narrow:get(i, 1, 1) - sum) < 1e-6 * sum)
    end
  end)

  it("sends its lumens to walls, by rays and as particles", function()
    for _, opening in ipairs { { shape = "sphere", radius = 0.1 }, { shape = "disk", radius = 0.2 },
      { shape = "rectangle", size = { 0.4, 0.2 } }, "point" } do
      local scene = ylm.scene "a ball" { geometry = ylm.sphere { radius = 2, material = ylm.matte { albedo = 0.5 } },
        lights = lamp(wide, opening, { at = { 0, 0, 0 } }) }
      local links = scene:links { spacing = 0.5, rays = 4 }
      local E, elements, flux = links:radiosity(nil, { bounces = 0, light_samples = 16 }):irradiance(), links:elements(), 0
      for i = 1, #E do flux = flux + elements.area:get(i) * E:get(i, 2) end
      assert.is_true(math.abs(flux / 3000 - 1) < 0.01, flux)
      local _, _, _, emission = scene:virtual_lights { count = 2000, bounces = 1, seed = 2 }:arrays()
      local power = 0
      for i = 1, #emission do power = power + math.pi * emission:get(i, 2, 1) / math.sqrt(4 * math.pi) / 0.5 end
      assert.is_true(math.abs(power / 3000 - 1) < 1e-3, power)
    end
  end)

  it("is seen by paths as its field is, and by the camera", function()
    local l = lamp(wide, { shape = "disk", radius = 0.1 }, { to = { 0.3, 0, 0.2 } })
    local scene = ylm.scene "a lamp" { lights = l, camera = ylm.camera { from = { 0.1, 0, 0 }, at = { 0.1, 2, 0.001 }, fov = 20 },
      geometry = ylm.quad { corner = { -9, -5, 9 }, u = { 18, 0, 0 }, v = { 0, 0, -18 }, material = ylm.matte { albedo = 0 } } }
    local at = { { 0, 0, 0 }, { 1.5, 0.3, 0.7 } }
    local c = scene:probe { points = at, lmax = 2, samples = 4096, bounces = 0, seed = 3 }
    local L = ylm.light_field(2, l, at)
    for i = 1, 2 do
      for k = 1, 9 do assert.is_true(math.abs(c:get(i, 2, k) - L:get(i, 2, k)) < 0.02 * L:get(i, 2, 1)) end
    end
    local seen = scene:render { size = { 9, 9 }, bounces = 0, samples = 16, by = "rays" }:layer():get(5, 5, 2)
    local way = { 0, -2, 0 }
    local axis = { 0.2 / math.sqrt(4.08), -2 / math.sqrt(4.08), 0.2 / math.sqrt(4.08) }
    local cos = (way[2] * axis[2]) / 2
    local radiance = ylm.light_field(0, l, { 0.1, 0, 0 }, { dtype = "double" }):get(2, 1) * math.sqrt(4 * math.pi)
    assert.is_true(math.abs(seen / (radiance / (math.pi * 0.01 * cos / 4)) - 1) < 0.01, seen)
  end)

  it("keeps a grid up to date while lamps move", function()
    local form = { lmax = 2, depth = 3, threshold = 0.1, bounds = { { -1, 0, -1 }, { 1, 1, 1 } }, metric = "relative" }
    local function lamps(x) return { lamp(wide), ylm.photometric_light { photometry = cosine, at = { x, 2, 0 } } } end
    local grid = ylm.bake(ylm.adaptive_grid(with(form, { dynamic = true })), lamps(0))
    grid:update(lamps(0.7))
    local fresh = ylm.bake(ylm.adaptive_grid(form), lamps(0.7))
    local a, b = grid:sample { { 0.3, 0.4, 0.2 } }, fresh:sample { { 0.3, 0.4, 0.2 } }
    assert.is_true(math.abs(a:get(1, 1, 1) / b:get(1, 1, 1) - 1) < 1e-5)
  end)

  it("stays when its photometry has been collected", function()
    local l = ylm.light_field
    local packed = core.lights_create and ylm.scene "kept" { lights = ylm.photometric_light {
      photometry = ylm.photometry { cosine = 3, lumens = 77 }, at = { 0, 1, 0 } } }
    for _ = 1, 3 do collectgarbage() end
    assert.is_true(l(0, packed.lights, { 0, 0, 0 }):get(1, 1) > 0)
  end)

  it("has a colour of luminance 1, by number or temperature", function()
    local function scale(o) return lamp(cosine, "auto", o).scale end
    for _, o in ipairs { { colour = { 1, 0, 0 } }, { colour = 0.2 }, { temperature = 2700 }, { temperature = 6504 } } do
      local s = scale(o)
      assert.is_true(math.abs(0.2126 * s[1] + 0.7152 * s[2] + 0.0722 * s[3] - 1) < 1e-9)
    end
    local white = scale { temperature = 6504 } -- D65 is the white of Rec. 709
    for c = 1, 3 do assert.is_true(math.abs(white[c] - 1) < 0.01, white[c]) end
    local warm = scale { temperature = 2700 }
    assert.is_true(warm[1] > 1.4 and warm[3] < 0.4)
    assert.matches("beyond Rec. 709", lamp(cosine, "auto", { temperature = 1200 }).notes[2])
  end)

  it("stands in no scene with lights in watts", function()
    local watts = ylm.sphere_light { at = { 0, 1, 0 }, radiance = 3 }
    local function scene(...)
      local list = { ... }
      return function() return ylm.scene "both" { lights = list } end
    end
    refused("light 2 is photometric %(lm, cd%), light 1 is in watts", scene(watts, lamp(wide)))
    refused("light 1 is photometric", function() ylm.light_field(0, { lamp(wide), watts }, { 0, 0, 0 }) end)
    scene(lamp(wide), ylm.sphere_light { at = { 0, 1, 0 }, photometric = true })()
    local tame = lamp(wide, "auto", { efficacy = 100 })
    scene(watts, tame)()
    assert.is_true(math.abs(tame.scale[1] - 0.01) < 1e-12)
    assert.equal(3000, math.floor(tame.lumens + 0.5))
  end)

  it("may be in a stranger's scene, with a file of its folder alone", function()
    local folder = scratch.new()
    assert(wide:save(folder.path .. "/wide.ies"))
    local function load(file)
      return ylm.load(folder:write("scene.lua", ([[
        return scene "a room" { lights = photometric_light { photometry = photometry { file = %q }, at = { 0, 2,
          0 } } }]]):format(file)))
    end
    assert.equal(1, #assert(load "wide.ies").lights)
    for _, name in ipairs { "/etc/passwd", "../wide.ies", "missing.ies" } do
      local scene, message = load(name)
      assert.is_nil(scene, message)
    end
    folder:remove()
  end)

  it("is what a glTF file names by EXT_lights_ies, along -z of its node, C0 along x", function()
    local folder = scratch.new()
    assert(wide:save(folder.path .. "/wide.ies"))
    local function load(light)
      return ylm.load(folder:write("lamps.gltf", ([[{"asset": {"version": "2.0"}, "scene": 0,
        "extensionsRequired": ["EXT_lights_ies"], "extensions": {"EXT_lights_ies": {"lights": [%s]}},
        "scenes": [{"nodes": [0]}], "nodes": [{"translation": [1, 2, 3],
        "rotation": [-0.70710678, 0, 0, 0.70710678], "extensions": {"EXT_lights_ies": {"light": 0, "multiplier": 2,
        "color": [1, 0.5, 0.25]}}}]}]]):format(light)))
    end
    local scene = assert(load '{"uri": "wide.ies"}')
    local l, same = scene.lights[1], ylm.photometric_light { photometry = wide, at = { 1, 2, 3 }, dim = 2,
      opening = { shape = "sphere", radius = 0.05 } }
    local x = { 1.7, 0.4, 2.2 }
    local got, wanted = ylm.light_field(3, l, x), ylm.light_field(3, same, x)
    for k = 1, 16 do -- red is the multiplier alone
      assert.is_true(math.abs(got:get(1, k) - wanted:get(1, k)) < 1e-4 * math.abs(wanted:get(1, 1)), k)
      assert.is_true(math.abs(got:get(3, k) - 0.25 * wanted:get(3, k)) < 1e-4 * math.abs(wanted:get(1, 1)), k)
    end
    folder:write("bad.ies", "no lamp")
    assert.matches("photometric lamps left out", table.concat(assert(load '{"uri": "bad.ies"}').report.notes, "; "))
    for _, uri in ipairs { '{"uri": "../wide.ies"}', "{}", '{"uri": "missing.ies"}' } do assert.is_nil((load(uri))) end
    folder:remove()
  end)

  it("refuses what it cannot be", function()
    local function made(o) return function() return assert(ylm.photometric_light(with({ photometry = wide, at = { 0, 0, 0 } },
      o))) end end
    refused("at and to are the same", made { to = { 0, 0, 0 } })
    refused("opening must be 'auto', 'point' or", made { opening = "square" })
    refused("opening: a rectangle has size", made { opening = { shape = "rectangle", radius = 1 } })
    refused("opening: a disk has a radius", made { opening = { shape = "disk" } })
    refused("size must be two numbers above 0", made { opening = { shape = "rectangle", size = { 1, 0 } } })
    refused("colour or temperature, not both", made { colour = 1, temperature = 3000 })
    refused("colour must not be black", made { colour = 0 })
    refused("temperature must be a number", made { temperature = 200 })
    refused("dim must be a number", made { dim = -1 })
    refused("photometry must be a photometry", made { photometry = 3 })
    refused("has no size, and so no light field", function() assert(ylm.light_field(0, lamp(wide, "point"), { 0, 0, 0 })) end)
  end)
end)
