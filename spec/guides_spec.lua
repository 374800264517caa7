--- Shadow rays that know what is seen: guides of pictures by rays.

local closed = require "spec.support.closed_rooms"
local long = require "spec.support.long"
local window_room = dofile "spec/support/window_room.lua"
local ylm = require "ylm"

local SIZE, SEEDS = { 72, 40 }, long(20, 40)

--- A floor and a wall in a box with a window, under a sky of tiles, a sun and two lamps, one of them behind a screen.
local function court()
  local white = ylm.matte { albedo = 0.7 }
  local function slab(lo, hi) return ylm.box { bounds = { lo, hi }, material = white } end
  return ylm.scene "a court" {
    camera = ylm.camera { from = { -1.6, 1.5, 1.6 }, at = { 0.4, 0.5, -0.4 }, fov = 70 },
    geometry = { slab({ -2, -0.1, -2 }, { 2, 0, 2 }), slab({ -2, 0, -2.1 }, { 2, 2, -2 }), slab({ -2, 2, -2 }, { 2, 2.1, 2 }),
      slab({ 2, 0, -2 }, { 2.1, 1, 2 }), slab({ 2, 1, 0 }, { 2.1, 2, 2 }), slab({ -2.1, 0, -2 }, { -2, 2, 2 }),
      slab({ -0.5, 0, -0.2 }, { -0.45, 0.9, 0.6 }) },
    lights = { ylm.sun_light { direction = { 2, 1.2, 0.2 }, irradiance = 20 },
      ylm.environment_light { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = { 2, 1.2, 0.2 }, luminance = 2 } },
      ylm.sphere_light { at = { -1, 0.5, 0.2 }, radius = 0.08, radiance = 12 },
      ylm.sphere_light { at = { 0.8, 1.7, -1 }, radius = 0.05, radiance = 15 } },
  }
end

--- n places of the court's floor, and their normals.
local function floor_of(n)
  local points, normals = {}, {}
  for k = 1, n do
    points[k] = { -1.9 + 3.8 * (k * 0.618 % 1), 1e-3, -1.9 + 3.8 * k / n }
    normals[k] = { 0, 1, 0 }
  end
  return points, normals
end

local function luminance(c) return 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end

--- Means over n arrays render(seed), SEEDS where n is left out, [..][3], from seed `first` on, and the variances of these means:
-- rows of rows.
local function many(first, render, n)
  local mean, square
  n = n or SEEDS
  for seed = first, first + n - 1 do
    local x = render(seed)
    if #x.shape == 2 then x = x:reshape { 1, x.shape[1], 3 } end
    mean, square = mean and mean + x or x + 0, square and square + x * x or x * x
  end
  mean = mean / n
  return mean:totable(), ((square / n - mean * mean) / (n - 1)):totable()
end

--- The squared differences of two means over their variances, both summed over pixels: 1 where they are of one picture.
local function z2_of(a, a_variance, b, b_variance)
  local apart, variance, n = 0, 0, 0
  for y, row in ipairs(a) do
    for x, c in ipairs(row) do
      local v = a_variance[y][x][2] + b_variance[y][x][2]
      apart, variance, n = apart + (c[2] - b[y][x][2]) ^ 2, variance + v, n + (v > 0 and 1 or 0)
    end
  end
  return apart / variance, n
end

--- Luminances of a picture, their mean, and their means over blocks of 8 x 8 pixels.
local function blocks(image)
  local rows, mean, n, block = image:layer("radiance"):totable(), 0, 0, {}
  for y, row in ipairs(rows) do
    for x, c in ipairs(row) do
      local k = 1000 * math.floor(y / 8) + math.floor(x / 8)
      row[x] = luminance(c)
      block[k] = block[k] or { 0, 0 }
      block[k][1], block[k][2] = block[k][1] + row[x], block[k][2] + 1
      mean, n = mean + row[x], n + 1
    end
  end
  return rows, mean / n, block
end

--- The sum of squared differences of a picture to the truth, each relative to the mean around it and a tenth of the whole.
local function noise_of(image, truth, whole, block)
  local sum = 0
  for y, row in ipairs(image:layer("radiance"):totable()) do
    for x, c in ipairs(row) do
      local near = block[1000 * math.floor(y / 8) + math.floor(x / 8)]
      sum = sum + ((luminance(c) - truth[y][x]) / (near[1] / near[2] + whole / 10)) ^ 2
    end
  end
  return sum
end

describe("guides of shadow rays", function()
  local view

  setup(function()
    view = court():prepare { size = SIZE, samples = 1 }
  end)

  local function guided(seed, more)
    local o = { bounces = 0, light_samples = 16, seed = seed }
    for key, x in pairs(more or {}) do o[key] = x end
    return view:render(o)
  end

  it("keep every pixel unbiased: z^2 within 1 +- 0.15 over " .. SEEDS
    .. " seeds, beside as many others without guides", function()
    local function render(guides)
      return function(seed) return guided(seed, { light_samples = 4, guides = guides }):layer "radiance" end
    end
    local a, a_variance = many(1, render(true))
    local b, b_variance = many(1 + SEEDS, render(false))
    local z2, n = z2_of(a, a_variance, b, b_variance)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n > 2500, ("z^2 is %.3f over %d pixels"):format(z2, n))
  end)

  it("keep pictures by paths unbiased: as above", function()
    local scene = court()
    local function render(guides)
      return function(seed)
        return scene:pathtrace({ size = { 24, 16 }, samples = 16, guides = guides, seed = seed, layers = false }):layer "radiance"
      end
    end
    local a, a_variance = many(1, render(true))
    local b, b_variance = many(1 + SEEDS, render(false))
    local z2, n = z2_of(a, a_variance, b, b_variance)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n > 300, ("z^2 is %.3f over %d pixels"):format(z2, n))
  end)

  it("keep light on elements, and on texels by their guide, unbiased: as above", function()
    local links = court():links { spacing = 0.4, rays = 4, lmax = 0 }
    local function elements(guides)
      return function(seed)
        local lit = links:radiosity(nil, { bounces = 0, light_samples = 8, guides = guides, seed = seed })
        assert.are.equal(guides, lit.stats.guides ~= nil and lit.stats.guide_rays > 0)
        local map = lit:lightmap { mesh = 1, size = { 24, 24 }, part = "direct", rays = 4, light_samples = 4, seed = seed,
          gutter = 0 }
        local texels = map:layer("irradiance"):reshape { 24 * 24, 3 }
        local all = lit:irradiance "direct"
        lit:close()
        return ylm.stack { all[{ { 1, 576 } }], texels }
      end
    end
    local a, a_variance = many(1, elements(true))
    local b, b_variance = many(1 + SEEDS, elements(false))
    local z2, n = z2_of(a, a_variance, b, b_variance)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n > 600, ("z^2 is %.3f over %d places"):format(z2, n))
  end)

  it("keep irradiance at points unbiased: as above over 40 seeds", function()
    local scene, points, normals = court(), floor_of(256)
    local function probe(guides)
      return function(seed)
        local E, _, report = scene:probe { points = points, normals = normals, samples = 32, bounces = 1, guides = guides,
          seed = seed }
        assert.are.equal(guides, report.guides ~= nil)
        return E
      end
    end
    local a, a_variance = many(1, probe(true), 40)
    local b, b_variance = many(41, probe(false), 40)
    local z2, n = z2_of(a, a_variance, b, b_variance)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n > 200, ("z^2 is %.3f over %d points"):format(z2, n))
  end)

  it("are kept for more estimates of a scene, unbiased and the same for any number of threads, and refused by another", function()
    local probe, scene = require "ylm.render.probe", court()
    local points, normals = floor_of(256)
    local function by(guides, seed, threads)
      return assert(probe.kept(scene,
        { points = points, normals = normals, samples = 32, seed = seed, threads = threads }, guides))
    end
    local lib = require("ylm.trace").trace("probe", scene).lib
    local guides = lib.path_guides()
    local _, _, first = by(guides, 1)
    local _, _, second = by(guides, 2)
    assert.is_true(first.rays.guides > 0 and second.guides == first.guides and second.rays.guides == 0)
    assert.same(by(guides, 3, 1):totable(), by(guides, 3, 2):totable())
    local a, a_variance = many(11, function(seed) return (by(guides, seed)) end)
    local b, b_variance = many(111, function(seed) return (by(nil, seed)) end)
    local z2, n = z2_of(a, a_variance, b, b_variance)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n > 200, ("z^2 is %.3f over %d points"):format(z2, n))
    assert.has_error(function() probe.kept(court(), { points = points, normals = normals, samples = 32 }, guides) end)
  end)

  it("keep bounced light as in closed form, a lamp off the centre of a sphere: z^2 within 1 +- 0.15 over as many seeds",
    function()
    local scene, points, normals, truth = closed.globe(ylm, 400)
    local a, variance = many(1, function(seed)
      local E, _, report = scene:probe { points = points, normals = normals, samples = 32, reflections = { 1, "all" },
        seed = seed }
      assert.is_true(report.guides > 0)
      return E
    end)
    local known, none = { {} }, { {} }
    for k in ipairs(points) do known[1][k], none[1][k] = { truth, truth, truth }, { 0, 0, 0 } end
    local z2, n = z2_of(a, variance, known, none)
    assert.is_true(math.abs(z2 - 1) <= 0.15 and n == 400, ("z^2 is %.3f over %d points"):format(z2, n))
  end)

  it("leave less noise in pictures by paths for as many rays, the pilot's included, where a window is small", function()
    local small = dofile "spec/support/interiors.lua"(ylm)[2][2]
    local cost = { [true] = 0, [false] = 0 }
    for guides in pairs(cost) do
      local image, report = small:pathtrace { size = { 48, 27 }, samples = 64, guides = guides, layers = false }
      local rays = report.rays
      assert.are.equal(guides, report.guides ~= nil)
      cost[guides] = image:layer "variance":mean() * (rays.nearest + rays.lamps + rays.shadow + (rays.guides or 0))
    end
    local gain = cost[false] / cost[true]
    assert.is_true(gain > 1.5, ("1 / variance / rays grows by %.2f"):format(gain))
  end)

  it("choose directions at surfaces that gloss little, and keep their light", function()
    local room = window_room(ylm, function(o) return ylm.ggx { alpha = 0.25, f0 = 0.04, base = o.albedo } end)
    local sums = {}
    for k, guides in ipairs { true, false } do
      local image = assert(room:pathtrace { size = { 64, 36 }, samples = 128, guides = guides })
      local mean, variance, n = image:layer "radiance", image:layer "variance", 64 * 36
      sums[k] = { mean:sum() / (3 * n), math.sqrt(variance:sum() / 3) / n }
    end
    local ours, usual = sums[1], sums[2]
    local error = math.sqrt(ours[2] ^ 2 + usual[2] ^ 2)
    assert(error < 0.007 * usual[1], error / usual[1])
    assert(math.abs(ours[1] - usual[1]) < 3.5 * error, (ours[1] - usual[1]) / error)
    assert(ours[2] ^ 2 < 0.8 * usual[2] ^ 2, (ours[2] / usual[2]) ^ 2)
  end)

  it("leave less noise for as many rays, the pilot's included", function()
    local room = window_room(ylm):prepare { size = { 112, 63 }, samples = 1 }
    local known, whole, block = blocks(room:render { bounces = 0, light_samples = 1024, seed = 7 })
    local cost = { [true] = 0, [false] = 0 }
    for guides in pairs(cost) do
      local image, report = room:render { bounces = 0, guides = guides, light_samples = 32, seed = 2 }
      cost[guides] = noise_of(image, known, whole, block) * (report.rays.shadow + (report.rays.guides or 0))
    end
    local gain = cost[false] / cost[true]
    assert.is_true(gain > 3.2, ("1 / variance / rays grows by %.2f"):format(gain))
  end)

  it("are the same for any number of threads", function()
    local one, three = guided(3, { threads = 1 }), guided(3, { threads = 3 })
    assert.are.equal(0, one:compare(three).max)
    local function paths(threads)
      return (court():pathtrace { size = { 30, 20 }, samples = 32, threads = threads, layers = false })
    end
    assert.are.equal(0, paths(1):compare(paths(3)).max)
    local links = court():links { spacing = 0.5, rays = 4, lmax = 0 }
    local function elements(n) return links:radiosity(nil, { bounces = 0, threads = n }):irradiance() end
    local d = elements(1) - elements(3)
    assert.are.equal(0, (d * d):sum())
  end)

  it("are told of in the report, and left out where one lamp shines or nothing shades", function()
    local _, report = guided(1)
    assert.is_true(report.guides >= 1 and report.rays.guides > 0)
    _, report = guided(1, { visibility = "none" })
    assert.is_nil(report.guides)
    _, report = guided(1, { lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 9 } })
    assert.is_nil(report.guides)
  end)

  it("shine alike where lamps are worth whole rays: closed form of two lamps above a floor", function()
    local h, r, radiance = 2, 0.1, 30
    local scene = ylm.scene "two lamps" {
      camera = ylm.camera { from = { 0, 1.5, 0.01 }, at = { 0, 0, 0 }, fov = 2 },
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = ylm.matte { albedo = 0.5 } } },
      lights = { ylm.sphere_light { at = { 0, h, 0 }, radius = r, radiance = radiance },
        ylm.sphere_light { at = { 1, 1, 0 }, radius = r, radiance = radiance } },
    }
    local image, report = scene:render { size = { 4, 4 }, samples = 1, bounces = 0, light_samples = 64 }
    local E = math.pi * radiance * r * r * (1 / h ^ 2 + math.sqrt(0.5) / 2)
    assert.is_true(report.guides >= 1)
    local c = image:layer("radiance"):totable()[2][2]
    assert.is_true(math.abs(c[1] / (0.5 * E / math.pi) - 1) < 0.01)
  end)

  it("let paths end where no light is: a closed room whose lamp is in a box", function()
    local scene = ylm.scene "dark" {
      camera = ylm.camera { from = { 0, 0, 0 }, at = { 0, 0, -1 } },
      geometry = { ylm.box { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, material = ylm.matte { albedo = 1 } },
        ylm.box { bounds = { { 0.5, 0.5, 0.5 }, { 0.7, 0.7, 0.7 } } } },
      lights = { ylm.sphere_light { at = { 0.6, 0.6, 0.6 }, radius = 0.05, radiance = 9 } },
    }
    local image, report = scene:pathtrace { size = { 8, 6 }, samples = 32, layers = false }
    assert.is_true(image:layer "radiance":sum() == 0 and report.guides > 0)
  end)

  it("leave light whose square no float holds as it is", function()
    local function mean(radiance)
      local scene = ylm.scene "bright" {
        camera = ylm.camera { from = { 0, 0, 0 }, at = { 0, 0, -1 } },
        geometry = { ylm.box { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, material = ylm.matte { albedo = 0.7 } } },
        lights = { ylm.sphere_light { at = { 0.6, 0.6, 0.6 }, radius = 0.1, radiance = radiance } },
      }
      local image, report = scene:pathtrace { size = { 32, 18 }, samples = 64, layers = false }
      assert.is_true(report.guides > 0)
      return ylm.array(image:layer "radiance", "double"):mean() / radiance
    end
    local truth = mean(1)
    for _, radiance in ipairs { 1e18, 3e19, 1e25, 1e36 } do
      assert.is_true(math.abs(mean(radiance) / truth - 1) < 0.02, ("%g"):format(radiance))
    end
  end)

  it("refuse what is neither true nor false", function()
    assert.has_error(function() guided(1, { guides = "yes" }) end)
    local scene = court()
    assert.has_error(function() scene:links({ spacing = 2, rays = 4, lmax = 0 }):radiosity(nil, { guides = 1 }) end)
    assert.has_error(function() scene:probe { points = { { 0, 1, 0 } }, guides = "yes" } end)
  end)
end)
