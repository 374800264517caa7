--- Pictures by rays without most of their noise: the filter, and what rays of their own say of it.

local by_kernels = require "spec.support.by_kernels"
local ylm = require "ylm"

local SIZE = { 160, 90 }

--- A room with a lamp behind a post: soft and hard shadows, a textured floor, a ball.
local function room(ball, walls)
  local white, red = walls or ylm.matte { albedo = 0.7 }, ylm.matte { albedo = { 0.6, 0.1, 0 } }
  return ylm.scene "a post" {
    camera = ylm.camera { from = { 0, 1.2, 1.9 }, at = { 0, 0.7, -1 }, fov = 60 },
    geometry = { ylm.box { bounds = { { -2, 0, -2 }, { 2, 2.5, 2 } }, material = white },
      ylm.box { bounds = { { -0.1, 0, -0.6 }, { 0.1, 1.4, -0.4 } }, material = red },
      ylm.sphere { radius = 0.3, at = { 0.8, 0.31, -0.5 }, divide = { 32, 16 }, material = ball or white } },
    lights = { ylm.sphere_light { at = { -0.9, 1.8, 0.2 }, radius = 0.15, radiance = 20 },
      ylm.disk_light { at = { 1.4, 2.4, -1.2 }, normal = { 0, -1, 0 }, radius = 0.3, radiance = 4 } },
  }
end

describe("a filter of noise", function()
  local before, scene, links, exact
  setup(function()
    before, scene = ylm.on_warning(false), room()
    links = scene:links({ spacing = 0.25, rays = 64 }):radiosity()
    local report
    exact, report = scene:render { size = SIZE, samples = 4, bounced = links, light_samples = 256, rays = 512, denoise = "auto" }
    assert(exact and not report.denoise)
  end)
  teardown(function() ylm.on_warning(before) end)

  --- A picture of few rays; false in `more` leaves an option out.
  local function render(more)
    local o = { size = SIZE, samples = 4, bounced = links, light_samples = 4, rays = 16 }
    for key, x in pairs(more or {}) do o[key] = x or nil end
    return assert(scene:render(o))
  end

  --- The root mean square distance of layers from the exact picture, and of their mean, over the mean.
  local function distance(image, layer)
    local d, mean = image:layer(layer) - exact:layer "radiance", exact:layer("radiance"):mean()
    return math.sqrt((d * d):mean()) / mean, d:mean() / mean
  end

  --- Adds the sums of an array [h][w][3] over blocks of 32 x 32 pixels to `sums`.
  local function add_blocks(a, sums)
    for y, row in ipairs(a:totable()) do
      for x, c in ipairs(row) do
        local k = 100 * math.floor((y - 1) / 32) + math.floor((x - 1) / 32)
        sums[k] = (sums[k] or 0) + c[1] + c[2] + c[3]
      end
    end
  end

  it("leaves a small part of it, and the mean of the picture and of its blocks", function()
    local image, report = render { denoise = "auto" }
    local raw, filtered = distance(image, "raw"), distance(image, "radiance")
    assert.is_true(filtered < 0.45 * raw, ("%.4f of %.4f"):format(filtered, raw))
    local sum, of_raw, after = 0, {}, {}
    for seed = 1, 4 do
      local found = render { denoise = "auto", seed = seed }
      sum = sum + (select(2, distance(found, "radiance")) - select(2, distance(found, "raw"))) / 4
      add_blocks(found:layer "raw", of_raw)
      add_blocks(found:layer "radiance", after)
    end
    assert.is_true(math.abs(sum) < 0.001, ("a bias of %.4f"):format(sum))
    for k, x in pairs(of_raw) do
      assert.is_true(math.abs(after[k] / x - 1) < 0.003, ("block %d: %.4f"):format(k, after[k] / x - 1))
    end
    assert.is_true(report.noise < 0.5 * report.noise_before)
    assert.are.equal("samples", report.ended)
  end)

  it("is judged by rays of their own", function()
    local image, report = render { denoise = "auto" }
    local d, noise = report.denoise, image:layer "noise"
    local all = math.sqrt((noise * noise):sum() / noise:not_equal(0):sum())
    assert.near(report.noise, all, 1e-3 * all)
    assert.is_true(d.unseen >= 0 and d.unseen < report.noise, ("%.4f of %.4f"):format(d.unseen, report.noise))
    assert.is_true(d.pixels > 1000 and d.z2 > 0.5 and d.z2 < 2.5, ("z2 is %.2f"):format(d.z2))
    assert.is_true(math.abs(d.bias) < 4 * d.uncertainty + 0.003, ("a bias of %.4f +- %.4f"):format(d.bias, d.uncertainty))
  end)

  it("keeps the picture as it is where noise is small", function()
    local same, report = render { denoise = "auto", light_samples = 512, rays = 512, size = { 48, 27 } }
    assert.is_true(report.noise <= 0.03 and report.denoise == nil, ("%.3f"):format(report.noise))
    local _, layers = same:layers()
    assert.is_nil(layers.raw)
  end)

  it("chooses counts where none are given, and reaches 3 %", function()
    local image, report = render { denoise = "auto", light_samples = false, rays = false, samples = false }
    local _, bias = distance(image, "radiance")
    assert.is_true(report.noise < 0.033 and math.abs(bias) < 0.02, ("%.3f, %.4f"):format(report.noise, bias))
    assert.are.equal("noise", report.ended)
  end)

  it("is the same for any number of threads", function()
    local one, three = render { denoise = "auto", threads = 1 }, render { denoise = "auto", threads = 3 }
    assert.are.equal(0, one:compare(three).max)
  end)

  it("takes the noise of wide lobes, which rays to lamps and links light by their counts", function()
    local plastic = room(nil, ylm.ggx { alpha = 0.25, f0 = 0.04, base = 0.7 })
    local own = plastic:links({ spacing = 0.5, rays = 64 }):radiosity()
    local function picture(more)
      more.size, more.samples, more.bounced = { 64, 36 }, 4, own
      return assert(plastic:render(more))
    end
    local truth = picture { light_samples = 512, rays = 512 }
    local few, report = picture { light_samples = 4, rays = 16, denoise = "auto" }
    local function apart(layer)
      local d = few:layer(layer) - truth:layer "radiance"
      return math.sqrt((d * d):mean()) / truth:layer("radiance"):mean()
    end
    local raw, filtered = apart "raw", apart "radiance"
    assert.is_true(filtered < 0.55 * raw, ("%.4f of %.4f"):format(filtered, raw))
    assert.is_true(report.rays.shadow < 6 * report.points, ("%d rays of %d points"):format(report.rays.shadow, report.points))
    local _, wanted = picture { noise = 0.04 }
    assert.is_true(wanted.noise < 0.045, ("%.4f is left"):format(wanted.noise))
  end)

  it("leaves surfaces with narrow lobes as they are", function()
    local shiny = room(ylm.ggx { alpha = 0.3, f0 = 0.9 })
    local own = shiny:links({ spacing = 0.5, rays = 32 }):radiosity()
    local image = assert(shiny:render { size = { 64, 36 }, samples = 1, bounced = own, light_samples = 8, rays = 16,
      denoise = "auto" })
    local d = image:layer "radiance" - image:layer "raw"
    local ball = image:layer("position")
    local on, off = 0, 0
    for y = 1, 36 do
      for x = 1, 64 do
        local r = math.sqrt((ball:get(y, x, 1) - 0.8) ^ 2 + (ball:get(y, x, 2) - 0.31) ^ 2 + (ball:get(y, x, 3) + 0.5) ^ 2)
        local change = math.abs(d:get(y, x, 1))
        if math.abs(r - 0.3) < 0.02 and image:layer("coverage"):get(y, x, 1) == 1 then on = math.max(on, change)
        else off = math.max(off, change) end
      end
    end
    assert.is_true(on == 0 and off > 0, ("%g, %g"):format(on, off))
  end)

  --- A view of a floor from above, its library, and its number of points.
  local function floor()
    local array, views = require "ylm.array", require "ylm.render.view"
    local flat = ylm.scene "a floor" { camera = ylm.camera { from = { 0, 3, 0.01 }, at = { 0, 0, 0 } },
      geometry = { ylm.box { bounds = { { -5, -0.1, -5 }, { 5, 0, 5 } }, material = ylm.matte { albedo = 0.5 } } } }
    local view = flat:prepare { size = { 48, 48 }, samples = 1 }
    local p = views.open("spec", view)
    return view, p.lib, p.stats.points, function(f)
      local a = array.zeros({ p.stats.points, 3 }, "float")
      for i = 1, p.stats.points do for c = 1, 3 do a:set(i, c, f(i)) end end
      return a
    end, array
  end

  it("leaves no spot of light that one ray in thousands met", function()
    local view, lib, n, light = floor()
    local random = require "spec.support.random".from(3)
    local at = 24 * 48 + 24
    for _, case in ipairs { { false, 400, 1 }, { true, 12, 12 } } do -- direct light of one half; light that bounces, of both
      local function half(spot) return light(function(i) return i == at and spot or 0.8 + 0.4 * random() end) end
      local a, b = half(case[2]), half(case[3])
      local sum = a:sum() + b:sum()
      assert(lib.shade_denoise(view, { first = a, second = b, all = (a + b) / 2, bounced = case[1], noise = 0.01, threads = 1 }))
      local most = 0
      for i = 1, n do most = math.max(most, a:get(i, 1), b:get(i, 1)) end
      assert.is_true(most < 1.6, tostring(case[1]) .. " " .. most)
      assert.near(1, (a:sum() + b:sum()) / sum, 0.01)
    end
  end)

  it("has rays of its own at edges of shadows, and nowhere else", function()
    local view, lib, n, light, array = floor()
    local random = require "spec.support.random".from(5)
    local lit = light(function(i) return ((i - 1) % 48 < 20 and 1 or 0.05) * (0.9 + 0.2 * random()) end)
    local rays = array.zeros({ n }, "float")
    local mean = assert(lib.shade_edge_rays(view, lit, lit, 4, 60, 1, rays))
    assert.near(mean, rays:mean(), 1e-4)
    for i = 1, n do
      local off = math.abs((i - 1) % 48 - 19.5)
      assert.are.equal(off < 2, rays:get(i) >= 4, i)
      assert.is_true(rays:get(i) <= 60 and (off < 3 or rays:get(i) == 0))
    end
    local even = light(function() return 1 end)
    assert.are.equal(0, lib.shade_edge_rays(view, even, even, 4, 60, 1, rays))
    assert.is_nil(lib.shade_edge_rays(view, array.zeros({ n }, "float"), even, 4, 60, 1, rays))
  end)

  it("is alike by every instruction set", function()
    local program = [[
      local array, views, ylm = require "ylm.array", require "ylm.render.view", require "ylm"
      local random = require "spec.support.random".from(11)
      local scene = ylm.scene "balls" { camera = ylm.camera { from = { 0, 2, 3 } },
        geometry = { ylm.box { bounds = { { -2, -0.1, -2 }, { 2, 0, 2 } } },
          ylm.sphere { radius = 0.7, at = { 0, 0.7, 0 }, divide = { 32, 16 },
            material = ylm.matte { albedo = { 0.5, 0.2, 0 } } } } }
      local view = scene:prepare { size = { 61, 35 }, samples = 4 }
      local p = views.open("spec", view)
      local half, x = {}, p.stats.points
      for h = 1, 2 do
        half[h] = array.zeros({ x, 3 }, "float")
        for i = 1, x do for c = 1, 3 do half[h]:set(i, c, (i % 7 == 0 and 3 or 1) + random()) end end
      end
      assert(p.lib.shade_denoise(view, { first = half[1], second = half[2], all = (half[1] + half[2]) / 2, bounced = false,
        noise = 0.01, threads = 1 }))
      for i = 1, x do for h = 1, 2 do print(half[h]:get(i, 1)) end end
    ]]
    local want
    for _, isa in ipairs(ylm.info().kernels) do
      local got = by_kernels(isa, program)
      assert.is_true(#got > 1000, isa)
      want = want or got
      for i = 1, #want do assert.near(want[i], got[i], 1e-3 * want[i], isa .. " " .. i) end
    end
  end)

  it("is refused where it does not fit, and says why", function()
    for text, o in pairs {
      ["tolerance is given"] = { denoise = "auto", tolerance = 0.1, light_samples = false, rays = false },
      ["variance is given"] = { denoise = "auto", variance = true },
      ["shading = 'pixel'"] = { denoise = "auto", shading = "vertices" },
      ["denoise is of light that bounces along links"] = { denoise = "auto", bounced = "virtual", rays = false },
      ["denoise must be"] = { denoise = "all" },
    } do
      local ok, message = pcall(render, o)
      assert.is_false(ok, text)
      assert.is_truthy(tostring(message):find(text, 1, true), text .. ": " .. tostring(message))
    end
  end)
end)
