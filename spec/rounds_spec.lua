--- Pictures by rays with a noise that is wanted, and camera rays that multiply other rays.

local views = require "ylm.render.view"
local ylm = require "ylm"

--- A wall across from a window, lit by sky and sun through it; no edge is in sight.
local function wall()
  local white = ylm.matte { albedo = 0.6 }
  local function slab(lo, hi) return ylm.box { bounds = { lo, hi }, material = white } end
  return ylm.scene "a wall" {
    camera = ylm.camera { from = { 0.5, 1.1, 1.2 }, at = { 0, 0.9, -2 }, fov = 34 },
    geometry = { slab({ -2, -0.1, -2 }, { 2, 0, 2 }), slab({ -2, 0, -2.1 }, { 2, 2, -2 }), slab({ -2, 2, -2 }, { 2, 2.1, 2 }),
      slab({ 2, 0, -2 }, { 2.1, 2, 2 }), slab({ -2.1, 0, -2 }, { -2, 2, 2 }), slab({ -2, 0, 2 }, { 2, 0.9, 2.1 }),
      slab({ -2, 0.9, 2 }, { -0.6, 2, 2.1 }) },
    lights = { ylm.sun_light { direction = { 0.6, 1.2, 2 }, irradiance = 20 },
      ylm.environment_light { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = { 0.6, 1.2, 2 }, luminance = 2 } } },
  }
end

local SIZE = { 48, 27 }

describe("a noise that is wanted", function()
  local scene, links
  local before

  setup(function()
    before = ylm.on_warning(false)
    scene = wall()
    links = scene:links({ spacing = 0.5, rays = 64 }):radiosity() -- light on elements is the same in all pictures
  end)

  teardown(function() ylm.on_warning(before) end)

  local function render(more)
    local o = { size = SIZE, samples = 4, bounced = links }
    for key, x in pairs(more) do o[key] = x end
    return assert(scene:render(o))
  end

  --- As `render`, without a filter.
  local function raw(more)
    more.denoise = "none"
    return render(more)
  end

  --- The root mean square difference of two pictures over the square root of 2, relative to their mean.
  local function difference(a, b)
    local d, m = a:layer "radiance" - b:layer "radiance", a:layer("radiance"):mean()
    return math.sqrt((d * d):mean() / 2) / m
  end

  it("is reached, and is what pictures with other seeds show", function()
    for _, noise in ipairs { 0.08, 0.05 } do
      local a, report = raw { noise = noise }
      local b = raw { noise = noise, seed = 5 }
      assert.is_true(report.noise < 1.15 * noise and report.noise > 0.6 * noise, ("%.3f is left"):format(report.noise))
      assert.are.equal("noise", report.ended)
      local found = difference(a, b)
      assert.is_true(found < 1.5 * report.noise and found > 0.6 * report.noise, ("%.3f is seen"):format(found))
      assert.is_true(math.abs(a:layer("noise"):mean() / report.noise - 1) < 0.3)
    end
  end)

  it("leaves means unbiased: eight pictures beside one of many rays", function()
    local mean, square, SEEDS = 0, 0, 8
    for seed = 1, SEEDS do
      local image = raw { noise = 0.2, seed = 11 * seed }
      local x = image:layer("radiance"):mean()
      mean, square = mean + x / SEEDS, square + x * x / SEEDS
    end
    local truth = render({ light_samples = 1024, rays = 1024 }):layer("radiance"):mean()
    local error = math.sqrt((square - mean * mean) / (SEEDS - 1))
    assert.is_true(math.abs(mean - truth) < 3 * error + 2e-3 * truth,
      ("%.5f, not %.5f, a standard error of %.5f"):format(mean, truth, error))
  end)

  it("leaves little more than as many rays everywhere do, the pilot's included, where noise is even as here", function()
    local a, report = raw { noise = 0.08 }
    local b = raw { noise = 0.08, seed = 5 }
    local even = { light_samples = math.ceil(report.light_samples), rays = 4 * math.ceil(report.rays.links / report.points / 4) }
    local c = render(even)
    even.seed = 5
    local d = render(even)
    local of = difference(a, b) / difference(c, d)
    assert.is_true(of < 1.35, ("%.3f"):format(of))
  end)

  it("plans rays behind a pilot for tiles with noise, and weighs it by tiles", function()
    local p = views.open("spec", scene:prepare { size = { 64, 32 }, samples = 1 })
    local n, noise = p.stats.points, ylm.zeros({ 32, 64, 1 }, "float")
    for y = 1, 32 do
      for x = 1, 64 do noise:set(y, x, 1, x > 32 and 0.01 or y > 16 and 0.1 or 0.04875) end
    end
    local rays, weight = ylm.zeros({ n }, "float"), ylm.zeros({ n, 1 }, "float")
    local square, mean = p.lib.shade_plan(p.view, { noise = noise, factor = 40, unit = 4, least = 2, most = 9, rays = rays,
      weight = weight })
    local of_tile = 1 / (40 * math.sqrt((0.1 ^ 2 + 0.04875 ^ 2) / 2)) -- one over the counts of the left tile, with the pilot's
    local counts, weights, sum = {}, {}, 0
    for i = 1, n do
      counts[rays:get(i)], sum = (counts[rays:get(i)] or 0) + 1, sum + rays:get(i)
      weights[("%.6f"):format(weight:get(i, 1))] = true
    end
    assert.same({ [0] = 1024, [4] = 512, [9] = 512 }, counts)     -- 40 x 0.04875 - 1 pilots of 4 rays; 12 are more than the most
    assert.same({ ["1.000000"] = true, [("%.6f"):format(of_tile)] = true }, weights)
    assert.is_true(math.abs(mean - sum / n) < 1e-9)
    local function left(k) return of_tile ^ 2 + (1 - of_tile) ^ 2 / k end
    local wanted = 1024 * 0.01 ^ 2 + 512 * (0.04875 ^ 2 * left(1) + 0.1 ^ 2 * left(9 / 4))
    assert.is_true(math.abs(square / wanted - 1) < 1e-6, ("%g, not %g"):format(square, wanted))
  end)

  it("of elements is what other seeds of their light show", function()
    local t, said, sum, square, SEEDS = links.links, 0, nil, nil, 8
    local view = scene:prepare { size = SIZE, samples = 4, links = t, rays = 256 }
    for seed = 1, SEEDS do
      local lit = t:radiosity(scene.lights, { seed = seed })
      local light = view:render({ by = "none", bounced = lit }):layer "radiance"
      sum, square = sum and sum + light or light, square and square + light * light or light * light
      local _, report = raw { noise = 0.3, bounced = lit }
      said = said + report.elements_noise ^ 2 / SEEDS
    end
    local mean = render({ light_samples = 256 }):layer("radiance"):mean()
    local seen = math.sqrt((square / SEEDS - (sum / SEEDS) ^ 2):mean() * SEEDS / (SEEDS - 1)) / mean
    assert.is_true(seen > 0 and math.abs(math.log(math.sqrt(said) / seen)) < math.log(1.6),
      ("%.4f is said, %.4f is seen"):format(math.sqrt(said), seen))
    local _, report = raw { noise = 0.3, bounced = t:radiosity(scene.lights, { light_samples = 8 }) } -- one place of each
    assert.is_nil(report.elements_noise)
  end)

  it("is the same for any number of threads", function()
    local one, three = raw { noise = 0.1, threads = 1 }, raw { noise = 0.1, threads = 3 }
    assert.are.equal(0, one:compare(three).max)
  end)

  it("is of direct light alone where nothing bounces", function()
    local _, report = scene:render { size = SIZE, samples = 4, bounces = 0, noise = 0.1, denoise = "none" }
    assert.is_true(report.noise < 0.13 and report.rays.links == nil)
  end)

  it("is that of the pilot where the next round is cancelled", function()
    local rounds, last = 0, nil
    local image, report = render { noise = 0.004, progress = { function(_, _, stage)
      if stage == "raycast" and last ~= "raycast" then rounds = rounds + 1 end
      last = stage
      return rounds < 2 -- the halves of a round follow each other
    end, every = 1e-6 } }
    assert.are.equal("cancelled", report.ended)
    assert.is_true(report.noise > 0.004 and image:layer("radiance"):mean() > 0)
  end)

  it("says where time ended before it was reached", function()
    local _, report = raw { noise = 0.002, time_limit = 0.05 }
    assert.are.equal("time_limit", report.ended)
    assert.is_true(report.noise > 0.002 and #report.warnings >= 1)
  end)

  it("is none where the camera sees nothing", function()
    local empty = ylm.scene "empty" { camera = scene.camera, geometry = {}, lights = scene.lights }
    for _, o in ipairs { { noise = 0.01 }, { noise = 0.01, time_limit = 1 }, { noise = 0.01, bounces = 0 } } do
      o.size = SIZE
      local _, report = assert(empty:render(o))
      assert.equal("the camera sees no geometry: nothing to shade", report.note)
      assert.same({ 0, 0, 0 }, { report.noise, report.light_samples, report.points })
    end
  end)

  it("is of surfaces that gloss too", function()
    local shiny = ylm.scene "a shiny wall" { camera = scene.camera, lights = scene.lights,
      geometry = { scene.geometry[1], ylm.quad { corner = { -1, 0, -1.9 }, u = { 2, 0, 0 }, v = { 0, 2, 0 },
        material = ylm.ggx { alpha = 0.3, f0 = 0.9 } } } }
    local own = shiny:links({ spacing = 0.5, rays = 64 }):radiosity()
    local function picture(o)
      o.size, o.bounced = { 32, 18 }, own
      return (assert(shiny:render(o)))
    end
    local a, b = picture { noise = 0.05, denoise = "none" }, picture { light_samples = 512, rays = 256 }
    assert.is_true(difference(a, b) < 0.1, ("%.3f"):format(difference(a, b)))
    assert.is_true(math.abs(a:layer("radiance"):mean() / b:layer("radiance"):mean() - 1) < 0.02)
  end)

  it("refuses what does not go with it, and names it", function()
    for text, o in pairs {
      ["light_samples is given"] = { noise = 0.1, light_samples = 4 },
      ["rays is given"] = { noise = 0.1, rays = 64 },
      ["tolerance is given"] = { noise = 0.1, tolerance = 0.1 },
      ["variance is given"] = { noise = 0.1, variance = true },
      ["give noise too"] = { time_limit = 1 },
      ["noise must be"] = { noise = 0 },
      ["shading = 'pixel'"] = { noise = 0.1, shading = "vertices" },
      ["leave bounced out"] = { noise = 0.1, bounced = "virtual" },
      ["noise is for"] = { noise = 0.1, by = "sum" },
    } do
      local ok, message = pcall(render, o)
      assert.is_false(ok)
      assert.is_truthy(tostring(message):find(text, 1, true), text .. ": " .. tostring(message))
    end
  end)
end)

describe("rays of a pixel", function()
  it("start from all over it where their noise is told: edges of shadows are those of paths", function()
    local before, white = ylm.on_warning(false), ylm.matte { albedo = 0.6 }
    local scene = ylm.scene "an edge" {
      camera = ylm.camera { from = { 0, 3, 0.01 }, at = { 0, 0, 0 }, fov = 12 },
      geometry = { ylm.box { bounds = { { -2, -0.1, -2 }, { 3, 0, 2 } }, material = white },
        ylm.box { bounds = { { -3, 0.5, -3 }, { -0.55, 0.52, 3 } }, material = white,
          rotate = { axis = { 0, 1, 0 }, angle = 10 } } },
      lights = { ylm.sun_light { direction = { -1, 1, 0 }, irradiance = 20 } },
    }
    local o = { size = { 16, 12 }, samples = 64, bounces = 0 }
    local paths = assert(scene:pathtrace(o)):layer "radiance":totable()
    local function apart(more) -- from paths, where they see an edge
      o.light_samples, o.denoise = 64, more
      local rows, sum, n = assert(scene:render(o)):layer "radiance":totable(), 0, 0
      for y, row in ipairs(paths) do
        for x, c in ipairs(row) do
          if c[1] > 0.3 and c[1] < 2.4 then sum, n = sum + ((rows[y][x][1] - c[1]) / 2.7) ^ 2, n + 1 end
        end
      end
      return math.sqrt(sum / n), n
    end
    local found, n = apart "auto"
    assert.is_true(n >= 6 and found < 0.1, ("%.3f over %d pixels"):format(found, n))
    assert.is_true(apart() > 0.2)
    ylm.on_warning(before)
  end)
end)

describe("rays to lamps", function()
  it("light wide and narrow lobes as paths do", function()
    local before = ylm.on_warning(false)
    local materials = { ylm.ggx { alpha = 0.25, f0 = 0.04, base = 0.6 }, ylm.ggx { alpha = { 0.2, 0.5 }, f0 = 0.5 },
      ylm.phong { exponent = 10, specular = 0.3, base = 0.4 }, ylm.ggx { alpha = 0.05, f0 = 0.6 } }
    for k, m in ipairs(materials) do
      local scene = ylm.scene "a plate" {
        camera = ylm.camera { from = { 0, 1.2, 1.6 }, at = { 0, 0, 0 }, fov = 40 },
        geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = m },
          ylm.box { bounds = { { -0.8, 0.3, -0.5 }, { -0.5, 0.35, 0.5 } } } },
        lights = { ylm.sphere_light { at = { -1, 1.2, -0.4 }, radius = 0.1, radiance = 40 },
          ylm.disk_light { at = { 0.8, 1.5, -1.2 }, normal = { 0, -1, 0.4 }, radius = 0.5, radiance = 3 } },
      }
      local o = { size = { 24, 16 }, samples = 16, bounces = 0 }
      local function means(image) -- of the two halves
        local all = image:layer "radiance"
        return { all[{ { 1, 8 }, { 1, 24 } }]:mean(), all[{ { 9, 16 }, { 1, 24 } }]:mean() }
      end
      o.light_samples = 96
      local found = means(assert(scene:render(o)))
      o.light_samples, o.samples, o.bounces = nil, 512, 0
      local truth = means(assert(scene:pathtrace(o)))
      for h = 1, 2 do
        assert.is_true(math.abs(found[h] / truth[h] - 1) < 0.02, ("material %d: %.4f, not %.4f"):format(k, found[h], truth[h]))
      end
    end
    ylm.on_warning(before)
  end)
end)

describe("more camera rays", function()
  it("multiply rays to lamps and links, unless their numbers are given or every sample is shaded", function()
    local before, scene = ylm.on_warning(false), wall()
    local links = scene:links { spacing = 0.5, rays = 64 }
    local function report(o)
      o.size, o.bounced = { 16, 9 }, links
      local _, r = assert(scene:render(o))
      return r
    end
    local usual, more = report {}, report { samples = 64 }
    assert.are.same({ 32, 64, 128, 256 }, { usual.light_samples, usual.links, more.light_samples, more.links })
    assert.is_true(more.rays.links > 3.5 * usual.rays.links and more.bounced_noise < 0.7 * usual.bounced_noise)
    local given = report { samples = 64, light_samples = 8, rays = 16 }
    assert.are.same({ 8, 16 }, { given.light_samples, given.links })
    local all = report { samples = 64, share = 0 }
    assert.are.same({ 32, 64 }, { all.light_samples, all.links })
    ylm.on_warning(before)
  end)
end)
