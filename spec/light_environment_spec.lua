-- Distant light from all around: closed forms, pictures, grids that follow it, what refuses it.

local core = require "ylm.c.core"
local ylm = require "ylm"
local gpu = require "spec.support.gpu"
local relative = require "spec.support.vectors".relative
local ways = require "spec.support.ways"

local points = { { 0, 0, 0 }, { 3, -2, 1 }, { 1e6, 0, 5 } }

local function rows()
  local c = {}
  for channel = 1, 3 do
    c[channel] = {}
    for i = 1, 9 do c[channel][i] = i == 1 and 4 or math.sin(3 * i + channel) / 4 end
  end
  return c
end

--- The radiance of coefficients in a direction, as rays see it.
local function seen(c, d)
  local value = ylm.sh.reconstruct(c, d)
  return math.max(0, value)
end

local function scene_with(lights, background)
  return ylm.scene "sky" {
    camera = ylm.camera { from = { 0, 0, 3 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 60 },
    geometry = ylm.quad { corner = { -0.3, -0.3, 0 }, u = { 0.6, 0, 0 }, v = { 0, 0.6, 0 },
      material = ylm.matte { albedo = 0.5 } },
    lights = lights, background = background,
  }
end

describe("ylm.environment_light", function()
  it("of one radiance has sqrt(4 pi) of it, at every point and of every degree", function()
    local sky = ylm.environment_light { radiance = { 1, 2, 3 }, scale = 2 }
    for _, lmax in ipairs { 0, 4, 100 } do
      local L, dL, ddL, report = ylm.light_field(lmax, sky, points, { derivatives = 2, metric = "rgb", dtype = "double" })
      for i = 1, #points do
        for c = 1, 3 do
          assert.is_near(4 * c * math.sqrt(math.pi), L:get(i, c, 1), 1e-14 * 40)
          for k = 2, math.min(9, (lmax + 1) ^ 2) do assert.equal(0, L:get(i, c, k)) end
        end
        assert.is_near(4 * math.sqrt(14 * math.pi), report.norm[i], 1e-12)
      end
      for _, zero in ipairs { dL, ddL, report.lambda, report.inside } do
        assert.equal(0, (select(3, core.array_distance(zero, zero))))
      end
      assert.equal(3, report.pairs)
    end
  end)

  it("has the coefficients that it is given, of any convention, in one channel or three", function()
    local c = rows()
    local L = ylm.light_field(2, ylm.environment_light { coefficients = c }, points, { dtype = "double" })
    for i = 1, 3 do assert(relative(L[i], ylm.array(c)) < 1e-15) end
    local grey = ylm.light_field(2, ylm.environment_light { coefficients = c[2], scale = 3 }, points[1], { dtype = "double" })
    for channel = 1, 3 do for k = 1, 9 do assert.is_near(3 * c[2][k], grey:get(channel, k), 1e-15 * 12) end end
    local other = ylm.sh.convert(ylm.array(c), "sn3d")
    local same = ylm.light_field(2, ylm.environment_light { coefficients = other }, points[1], { dtype = "double" })
    assert(relative(same, ylm.array(c)) < 1e-14)
    local low = ylm.light_field(1, ylm.environment_light { coefficients = c }, points[1], { dtype = "double" })
    for channel = 1, 3 do for k = 1, 4 do assert.equal(c[channel][k], low:get(channel, k)) end end
  end)

  it("projects an image", function()
    local image = ylm.image { size = { 32, 16 }, layers = { { "radiance", 3 } } }
    local texels = {}
    for y = 1, 16 do
      texels[y] = {}
      for x = 1, 32 do texels[y][x] = { x / 32, y / 16, x * y / 512 } end
    end
    core.array_fill(image:layer(), texels)
    local L = ylm.light_field(3, ylm.environment_light { image = image, up = "y", lmax = 5 }, points[1], { dtype = "double" })
    assert(relative(L, ylm.sh.project(3, image, { up = "y" })) < 1e-14)
  end)

  it("adds to other lights, in any order", function()
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.3, radiance = 5 }
    local skies = { ylm.environment_light { radiance = 0.25 }, ylm.environment_light { coefficients = rows() } }
    local x = { { 0.2, 0.1, 0.4 } }
    local sum = ylm.light_field(2, lamp, x, { dtype = "double" }):totable()
    for _, sky in ipairs(skies) do
      local L = ylm.light_field(2, sky, x, { dtype = "double" })
      for c = 1, 3 do for k = 1, 9 do sum[1][c][k] = sum[1][c][k] + L:get(1, c, k) end end
    end
    local together = ylm.light_field(2, { skies[1], lamp, { skies[2] } }, x, { dtype = "double" })
    assert(relative(together, ylm.array(sum)) < 1e-15)
  end)

  it("is baked in one voxel, since nothing changes", function()
    local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 4, channels = "rgb",
      tolerance = 0.01 }, ylm.environment_light { coefficients = rows() })
    assert.equal(8, grid.stats.points)
    assert.is_true(grid.stats.met)
    assert(relative(grid:sample { { 0.3, 0.2, 0.1 } }[1], ylm.array(rows())) < 1e-6)
  end)

  it("is followed by grids: colour, coefficients, coming and going", function()
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.3, radiance = 5 }
    local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = 2, channels = "rgb",
      dynamic = true }
    local c = rows()
    c[1][4] = -1
    local grid = ylm.bake(form, { lamp, ylm.environment_light { radiance = 0.5 } })
    for _, sky in ipairs { { ylm.environment_light { radiance = { 0.5, 0.4, 0.7 } } },
      { ylm.environment_light { coefficients = rows() } }, { ylm.environment_light { coefficients = c } }, {},
      { ylm.environment_light { radiance = 2 }, lamp } } do
      local lights = { lamp, sky }
      assert(grid:update(lights, { tolerance = 0 }).lights > 0)
      local fresh = ylm.bake(form, lights)
      local x = { { 0.3, 0.2, 0.1 }, { -0.9, 0.5, 0 } }
      assert(relative(grid:sample(x), fresh:sample(x)) < 2e-6)
    end
  end)

  it("lights what sees the sky: irradiance of the cosine, by harmonics and by rays", function()
    local c = rows()
    for _, sky in ipairs { ylm.environment_light { radiance = 2 }, ylm.environment_light { coefficients = c } } do
      local scene = scene_with(sky)
      local o = { size = { 9, 9 }, samples = 1, visibility = "none", lmax = 2 }
      local L = ylm.light_field(2, sky, { { 0, 0, 0 } }, { dtype = "double" })
      local by_light = scene:render(ways.sum(o)):layer():totable()[5][5]
      local by_rays = scene:render { bounces = 0, size = { 9, 9 }, samples = 1, light_samples = 4096 }:layer():totable()[5][5]
      for channel = 1, 3 do
        local T = L[1][channel]:totable()
        for k = 1, 9 do T[k] = T[k] * core.sh_cosine_factor((ylm.sh.degree(k))) end
        local E = ylm.sh.reconstruct(T, { 0, 0, 1 })
        assert.is_near(0.5 * E / math.pi, by_light[channel], 1e-5)
        assert.is_near(by_light[channel], by_rays[channel], 0.01 * by_light[channel])
      end
    end
  end)

  it("is seen where nothing is hit, unless the scene has a background", function()
    local c = rows()
    local sky = ylm.environment_light { coefficients = c }
    local o = { size = { 3, 3 }, samples = 1, visibility = "none", lmax = 2, layers = true }
    local t = math.tan(math.rad(30))
    local image = scene_with(sky):render(ways.sum(o))
    local corner = image:layer():totable()[1][1]
    for channel = 1, 3 do
      local least, most = math.huge, -math.huge
      for _, at in ipairs { { -1, 1 }, { -1 / 3, 1 / 3 }, { -1, 1 / 3 }, { -1 / 3, 1 } } do -- somewhere in that pixel
        local value = seen(c[channel], { t * at[1], t * at[2], -1 })
        least, most = math.min(least, value), math.max(most, value)
      end
      assert(corner[channel] >= least - 0.02 and corner[channel] <= most + 0.02)
    end
    assert.equal(1, image:layer "emitter":get(1, 1, 1))
    local black = scene_with(sky, 0):render(ways.sum(o))
    assert.same({ 0, 0, 0 }, black:layer():totable()[1][1])
    assert.equal(0, black:layer "emitter":get(1, 1, 1))
  end)

  it("is refused by devices, by name", function()
    local device = gpu.open()
    local ok, message = pcall(device.lights, device,
      { ylm.environment_light { radiance = 1 }, ylm.sphere_light { at = { 0, 2, 0 } } })
    assert.is_false(ok)
    assert.truthy(tostring(message):find("a device sums no lights of kind 'environment'", 1, true), message)
  end)
end)
