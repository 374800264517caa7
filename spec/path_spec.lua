-- The path tracer: closed forms, strategies that must agree, what stops it and what it goes on from.
-- `make check-long` asks the closed forms for a tenth of the noise, 0.2 %.

local floor_of_lamps = require "spec.support.floor_of_lamps"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local closed = require "spec.support.closed_rooms"

--- Raises unless the estimate is within three of its standard errors, and those below a part of the truth.
local function near(estimate, error, truth, noise, what)
  assert.is_true(error <= noise * truth, ("%s: noise %.2g of it"):format(what, error / truth))
  assert.is_true(math.abs(estimate - truth) <= 3 * error + 3e-4 * truth,
    ("%s: %.6g, not %.6g: %.1f standard errors"):format(what, estimate, truth, (estimate - truth) / error))
end

local function room()
  local white, red = ylm.matte { albedo = 0.7 }, ylm.matte { albedo = { 0.6, 0.1, 0.1 } }
  return ylm.scene "room" {
    camera = ylm.camera { from = { 0, 1, 2.9 }, at = { 0, 1, 0 }, fov = 42 },
    geometry = {
      ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = white },
      ylm.quad { corner = { -1, 0, -1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, material = white },
      ylm.quad { corner = { -1, 0, 1 }, u = { 0, 0, -2 }, v = { 0, 2, 0 }, material = red },
      ylm.box { bounds = { { 0.1, 0, -0.3 }, { 0.6, 0.7, 0.2 } }, material = white },
    },
    lights = {
      ylm.sphere_light { at = { -0.4, 1.2, 0.2 }, radius = 0.25, radiance = { 5, 4, 3 } },
      ylm.polygon_light { radiance = 3,
        vertices = { { -0.2, 1.8, -0.9 }, { 0.6, 1.8, -0.9 }, { 0.6, 1.8, 0 }, { -0.2, 1.8, 0 } } },
    },
  }
end

local small = { 32, 18 }

describe("scene:probe", function()
  for _, case in ipairs(closed.cases) do
    it("finds " .. case.name, function()
      local estimate, error, truth = case.measure(ylm, long(case.samples, case.long))
      near(estimate, error, truth, long(0.02, 0.002), case.name)
    end)
  end

  it("knows how likely each way to find a lamp is: they agree inside of lamps, behind others, on horizons", function()
    local lights = {
      ylm.sphere_light { at = { 0, 0, 0 }, radius = 1, radiance = 1 },
      ylm.sphere_light { at = { 0, 1.5, 0 }, radius = 0.5, radiance = 2 },
      ylm.sphere_light { at = { 0, 4, 0 }, radius = 1, radiance = 3 }, -- behind it
      ylm.disk_light { at = { 0, 0, 2 }, normal = { 0, 0, 1 }, radius = 1, radiance = 1 },
      ylm.polygon_light { vertices = { { 2, -0.5, -1 }, { 2, 1, -1 }, { 2, 0, 1 } }, radiance = 4 },
      ylm.sun_light { direction = { 1, 1, 1 }, angle = 20, irradiance = 2 },
    }
    local scene = ylm.scene "lamps" { lights = lights }
    for _, points in ipairs { { { 0, 0.2, 0.1 } }, { { 0, 2.4, 0.3 } } } do
      for _, normals in ipairs { false, { { 0, 1, 0 } }, { { 0.6, 0, 0.8 } } } do
        local found = {}
        for i, strategy in ipairs { "lights", "material", "both" } do
          local c, v = scene:probe { points = points, normals = normals or nil, lmax = 1, samples = 16384, strategy = strategy,
            seed = i, bounces = 0 }
          found[i] = normals and { c:get(1, 1), v:get(1, 1) } or { c:get(1, 1, 1), v:get(1, 1, 1) }
        end
        for i = 2, 3 do
          local off = (found[i][1] - found[1][1]) / math.sqrt(found[i][2] + found[1][2] + 1e-12)
          assert.is_true(math.abs(off) < 4, ("strategy %d is %.1f standard errors off"):format(i, off))
        end
      end
    end
  end)

  it("chooses among 5,000 lamps without bias", function()
    local at, radius, truth = floor_of_lamps(5000, 2)
    local scene = ylm.scene "many" { lights = { ylm.sphere_lights { at = at, radius = radius, radiance = 1 } } }
    for _, strategy in ipairs { "lights", "both" } do
      local E, v = scene:probe { points = { { 0, 0, 0 } }, normals = { { 0, 1, 0 } }, samples = 32768, bounces = 0,
        strategy = strategy }
      near(E:get(1, 1), math.sqrt(v:get(1, 1)), truth, 0.02, strategy)
    end
  end)

  it("gives coefficients that agree with the lights' own, where nothing occludes", function()
    local lights = { ylm.sphere_light { at = { 1, 0.5, 0.3 }, radius = 0.3, radiance = { 3, 2, 1 } } }
    local scene = ylm.scene "free" { lights = lights }
    local c, v = scene:probe { points = { { 0, 0, 0 } }, lmax = 3, samples = 4096 }
    local L = ylm.light_field(3, lights, { { 0, 0, 0 } }, { channels = "rgb", dtype = "double" })
    for k = 1, 3 do
      for i = 1, 16 do
        assert.is_true(math.abs(c:get(1, k, i) - L:get(1, k, i)) <= 4 * math.sqrt(v:get(1, k, i)) + 1e-5)
      end
    end
  end)
end)

describe("scene:pathtrace", function()
  local scene = room()

  it("finds the same picture by lights, by material and by both, which has the least noise", function()
    local images, noise = {}, {}
    for i, strategy in ipairs { "both", "lights", "material" } do
      local image, report = scene:pathtrace { size = small, samples = 256, strategy = strategy, seed = i }
      images[i], noise[i] = image, report.noise
    end
    for i = 1, 3 do
      for k = i + 1, 3 do
        local m = images[i]:compare(images[k], { variance = true })
        assert.is_true(math.abs(m.z2 - 1) <= 0.15, ("%d, %d: z2 is %.3f"):format(i, k, m.z2))
        assert.is_true(m.z2_block < 2 and m.z2_block >= m.z2)
      end
    end
    assert.is_true(noise[1] <= math.sqrt(1.1) * math.min(noise[2], noise[3]))
  end)

  it("tells pictures apart that are not the same", function()
    local a = scene:pathtrace { size = small, samples = 256, bounces = 0, layers = false }
    local b = scene:pathtrace { size = small, samples = 256, bounces = 1, layers = false, seed = 2 }
    assert.is_true(a:compare(b, { variance = true }).z2 > 3)
  end)

  it("shows the direct light that rays to the lamps show", function()
    local size = { 24, 14 }
    local a = scene:pathtrace { size = size, samples = 512, reflections = { 1, 1 }, layers = false, seed = 21 }
    local b, report = scene:render { bounces = 0, size = size, samples = 512, share = 0, light_samples = 4, variance = true,
      seed = 205 }
    local emitter, mask = b:layer "emitter", ylm.zeros({ size[2], size[1] }, "float")
    local variance = a:layer "variance"
    for y = 1, size[2] do -- pixels that show lamps differ: order 0 is theirs
      for x = 1, size[1] do
        local lamp = emitter:get(y, x, 1) > 0
        for dy = -1, 1 do
          for dx = -1, 1 do
            local u, v = x + dx, y + dy
            if u >= 1 and u <= size[1] and v >= 1 and v <= size[2] then lamp = lamp or emitter:get(v, u, 1) > 0 end
          end
        end
        mask:set(y, x, lamp and 0 or variance:get(y, x, 1) > 0 and 1 or 0)
      end
    end
    local m = a:compare(b, { variance = true, mask = mask })
    -- the variance of 16 batches with successive seeds is itself uncertain: z2 was 0.8 to 2.1 for five other seeds
    assert.is_true(math.abs(m.z2 - 1) <= 0.3 and m.pixels > 100, ("z2 is %.3f over %d pixels"):format(m.z2, m.pixels))
    assert.is_true(report.rays.shadow > 0 and b:layer "samples":get(1, 1, 1) == 512)
  end)

  it("adds up: orders of reflection to all, lamps to both", function()
    local function mean(s, o)
      o.size, o.samples, o.layers = small, 128, false
      local image = s:pathtrace(o)
      local sum, variance, x, v = 0, 0, image:layer "radiance", image:layer "variance"
      for y = 1, small[2] do
        for c = 1, small[1] do sum, variance = sum + x:get(y, c, 2), variance + v:get(y, c, 2) end
      end
      return sum, variance
    end
    local all, va = mean(scene, { bounces = 2 })
    local sum, vs = 0, 0
    for order = 0, 3 do
      local m, v = mean(scene, { reflections = { order, order }, seed = 2 + order })
      sum, vs = sum + m, vs + v
    end
    assert.is_true(math.abs(all - sum) <= 4 * math.sqrt(va + vs), ("%g is not %g"):format(all, sum))
    local one, two = room(), room()
    table.remove(one.lights, 1)
    table.remove(two.lights, 2)
    local E, v = {}, {}
    for i, s in ipairs { scene, one, two } do -- where pictures hide lamps behind one another, surfaces see both
      local e, variance = s:probe { points = { { 0, 0, 0.3 } }, normals = { { 0, 1, 0 } }, samples = 4096, seed = i }
      E[i], v[i] = e:get(1, 1), variance:get(1, 1)
    end
    assert.is_true(math.abs(E[2] + E[3] - E[1]) <= 4 * math.sqrt(v[1] + v[2] + v[3]))
  end)

  it("is the same, bit for bit, by 1, 2 and 7 threads", function()
    local images = {}
    for i, threads in ipairs { 1, 2, 7 } do
      images[i] = scene:pathtrace { size = small, samples = 48, threads = threads, layers = false }
    end
    for i = 2, 3 do
      for _, layer in ipairs { "radiance", "radiance_rest", "variance" } do
        assert.are.equal(0, images[i]:compare(images[1], { layer = layer }).max)
      end
    end
  end)

  it("goes on from a file, bit for bit as in one run", function()
    local folder = scratch.new()
    local name = folder.path .. "/part.exr"
    local o = { size = small, samples = 48, bounces = 2, layers = false }
    assert(scene:pathtrace(o):save(name))
    o.samples = 112
    local whole = scene:pathtrace(o)
    o.resume = assert(ylm.load(name))
    folder:remove()
    local resumed, report = scene:pathtrace(o)
    assert.are.equal(112, report.samples)
    assert.are.equal("112", resumed.metadata.samples)
    for _, layer in ipairs { "radiance", "variance", "radiance_rest", "samples" } do
      assert.are.equal(0, resumed:compare(whole, { layer = layer }).max)
    end
  end)

  it("goes on from an image of its own scene alone, and names what differs", function()
    local function chamber(o)
      return ylm.scene "room" { camera = ylm.camera { from = { 0, 0, 2 }, at = { 0, 0, 0 } }, background = o.background,
        geometry = ylm.box { scale = o.scale or 1, occludes = o.occludes,
          material = o.material or ylm.matte { albedo = 0.5 } },
        lights = o.lights or ylm.sphere_light { at = { 0, 2, 0 }, radiance = 3 } }
    end
    local o = { size = { 4, 3 }, samples = 32, bounces = 1, layers = false }
    local image = chamber({}):pathtrace(o)
    o.resume, o.samples = image, 48
    assert.are.equal("48", chamber({}):pathtrace(o).metadata.samples)
    local panorama = ylm.image { size = { 4, 2 }, layers = { { "radiance", 3 } } }
    for _, case in ipairs { { "other geometry", { scale = 1.001 } }, { "other geometry", { occludes = false } },
      { "other materials", { material = ylm.matte { albedo = { 0.5, 0.5, 0.51 } } } },
      { "other materials", { material = ylm.ggx { alpha = 0.5 } } },
      { "other lights", { lights = ylm.sphere_light { at = { 0, 2, 0 }, radiance = 3.001 } } },
      { "other lights", { lights = ylm.environment_light { image = panorama } } },
      { "other lights", { lights = ylm.spot_light { at = { 0, 2, 0 }, to = { 0, 0, 0 } } } },
      { "background is '0 0 0', this is '1 1 1'", { background = 1 } } } do
      local ok, message = pcall(function() return chamber(case[2]):pathtrace(o) end)
      assert.is_false(ok, case[1])
      assert.matches("resume: the image.*" .. case[1], message)
    end
    for _, part in ipairs { "geometry", "materials", "lights" } do image.metadata["print." .. part] = nil end
    local said
    local before = ylm.on_warning(function(line) said = line end)
    local ok, again = pcall(function() return chamber({}):pathtrace(o) end)
    ylm.on_warning(before)
    assert(ok, again)
    assert.matches("no fingerprint of its geometry, materials, lights", said)
  end)

  it("ends at a wanted noise, after some time, or when it is told to", function()
    local image, report = scene:pathtrace { size = small, samples = 65536, bounces = 0, tolerance = 0.1, layers = false }
    assert.are.equal("tolerance", report.ended)
    assert.is_true(report.noise <= 0.1 and report.samples < 65536 and image.metadata.samples == tostring(report.samples))
    local _, late = scene:pathtrace { size = small, samples = 2 ^ 24, time_limit = 0.05, layers = false }
    assert.are.equal("time_limit", late.ended)
    local calls = 0
    local none, message, code = scene:pathtrace { size = small, samples = 65536, progress = function(done, total)
      calls = calls + 1
      assert(done <= total)
      return calls < 3
    end }
    assert.is_nil(none)
    assert.are.equal("cancelled", message)
    assert.are.equal("ECANCELLED", code)
  end)

  it("is black without lights, and says so", function()
    local image, report = ylm.scene "dark" { camera = scene.camera, geometry = scene.geometry }:pathtrace { size = { 8, 6 },
      samples = 1 }
    assert.are.equal(0, image:layer():get(3, 4, 1))
    assert.matches("no lights", report.note)
    assert.are.equal(32, report.samples) -- two batches
  end)

  it("leaves out a mesh that does not occlude, but shows it", function()
    local function lit(occludes)
      local s = ylm.scene "veil" {
        camera = ylm.camera { from = { 0, 1, 4 }, at = { 0, 1, 0 } },
        geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
          ylm.quad { corner = { -1, 1, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, occludes = occludes } },
        lights = { ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.2, radiance = 5 } },
      }
      local E = s:probe { points = { { 0, 0, 0 } }, normals = { { 0, 1, 0 } }, samples = 256 }
      return E:get(1, 1)
    end
    assert.is_true(lit(true) == 0 and lit(false) > 0.1)
  end)
end)
