-- Suns: closed forms, pictures, grids that follow them, what refuses them.

local core = require "ylm.c.core"
local ylm = require "ylm"
local gpu = require "spec.support.gpu"
local relative = require "spec.support.vectors".relative

local points = { { 0, 0, 0 }, { 300, -2, 1 } }
local towards = { 0.3, 0.9, 0.2 }

describe("ylm.sun_light", function()
  it("is a cap of the radiance that makes the irradiance", function()
    for _, angle in ipairs { 0.53, 10, 90, 180 } do
      for _, lmax in ipairs { 0, 4, 40 } do
        local half = math.rad(angle / 2)
        local L = ylm.light_field(lmax, ylm.sun_light { direction = towards, angle = angle, irradiance = { 2, 1, -3 } }, points,
          { dtype = "double" })
        local cap = ylm.sh.cap(lmax, towards, half):totable()
        for c, irradiance in ipairs { 2, 1, -3 } do
          local wanted = {}
          for k = 1, #cap do wanted[k] = cap[k] * irradiance / (math.pi * math.sin(half) ^ 2) end
          -- caps are differences of Legendre polynomials, which cancel where they are small
          assert(relative(L[2][c], ylm.array(wanted)) < (angle < 1 and 1e-9 or 1e-13), angle)
        end
      end
    end
  end)

  it("is a sphere light far away, and keeps its digits where it is a point", function()
    local d, half = 1e6, math.rad(0.265)
    local n = math.sqrt(0.3 ^ 2 + 0.9 ^ 2 + 0.2 ^ 2)
    local far = ylm.sphere_light { at = { 0.3 * d / n, 0.9 * d / n, 0.2 * d / n }, radius = d * math.sin(half),
      radiance = 1 / (math.pi * math.sin(half) ^ 2) }
    local o = { dtype = "double" }
    assert(relative(ylm.light_field(20, ylm.sun_light { direction = towards }, points[1], o),
      ylm.light_field(20, far, points[1], o)) < 1e-10)
    local Y = ylm.sh.eval(8, { towards }, { dtype = "double" })
    local point = ylm.light_field(8, ylm.sun_light { direction = towards, angle = 0.001 }, points[1], o)
    assert(relative(point[1], Y[1]) < 1e-8)
  end)

  it("makes its irradiance on what faces it, by rays too, and half of it at 60 degrees", function()
    for _, normal in ipairs { { 0, 0, 1, 1 }, { math.sqrt(0.75), 0, 0.5, 0.5 } } do
      local scene = ylm.scene "sun" {
        camera = ylm.camera { from = { 0, 0, 3 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 10 },
        geometry = ylm.quad { corner = { -normal[3], -1, normal[1] }, u = { 2 * normal[3], 0, -2 * normal[1] }, v = { 0, 2, 0 },
          material = ylm.matte { albedo = 0.5 } },
        lights = ylm.sun_light { direction = { 0, 0, 2 }, irradiance = { 4, 2, 1 } },
      }
      local image = scene:render { bounces = 0, size = { 3, 3 }, samples = 1, light_samples = 64 }:layer():totable()[2][2]
      for c, irradiance in ipairs { 4, 2, 1 } do
        assert.is_near(0.5 / math.pi * irradiance * normal[4], image[c], 1e-4 * irradiance)
      end
    end
  end)

  it("is in the shade behind what occludes, and seen as a disc where nothing is hit", function()
    local scene = ylm.scene "sun" {
      camera = ylm.camera { from = { 0, 0, 3 }, at = { 0, 0, -1 }, up = { 0, 1, 0 }, fov = 20 },
      geometry = { ylm.quad { corner = { -1, -1, -1 }, u = { 1, 0, 0 }, v = { 0, 2, 0 } },
        ylm.quad { corner = { -2, -2, 5 }, u = { 2.5, 0, 0 }, v = { 0, 4, 0 } } },
      lights = { ylm.sun_light { direction = { 0, 0, 1 }, irradiance = 3 },
        ylm.sun_light { direction = { math.sin(math.rad(5)), 0, -math.cos(math.rad(5)) }, angle = 4, irradiance = 2 } },
    }
    local image = scene:render { bounces = 0, size = { 41, 41 }, samples = 4, layers = true, light_samples = 64 }
    local rgb = image:layer():totable()
    assert.same({ 0, 0, 0 }, rgb[21][11]) -- on the left, the first sun is behind the camera's quad
    local radiance = 2 / (math.pi * math.sin(math.rad(2)) ^ 2)
    assert.is_near(radiance, rgb[21][31][1], 1e-3 * radiance)
    assert.same({ 0, 0, 0 }, rgb[2][31])
  end)

  it("is followed by grids", function()
    local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = 3, channels = "rgb",
      dynamic = true }
    local function sun(x, irradiance) return ylm.sun_light { direction = { x, 1, 0 }, irradiance = irradiance } end
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.3, radiance = 5 }
    local grid = ylm.bake(form, { lamp, sun(0, 1) })
    for _, now in ipairs { sun(0.3, 1), sun(0.3, { 2, 1, 0 }), ylm.environment_light { radiance = 0.1 } } do
      assert.equal(1, grid:update({ lamp, now }, { tolerance = 0 }).lights)
      local x = { { 0.3, 0.2, 0.1 } }
      assert(relative(grid:sample(x), ylm.bake(form, { lamp, now }):sample(x)) < 2e-6)
    end
    local grey = grid:update({ lamp, ylm.environment_light { radiance = 0.1000001 } })
    assert.equal(0, grey.points) -- within the tolerance: skipped
    assert(grey.skipped > 0)
  end)

  it("is refused by devices, by name", function()
    local device = gpu.open()
    local ok, message = pcall(device.lights, device, ylm.sun_light { direction = towards })
    assert.is_false(ok)
    assert.truthy(tostring(message):find("a device sums no lights of kind 'sun'", 1, true), message)
    assert.equal(16, core.array_info(ylm.light_field(3, ylm.sun_light { direction = towards }, { { 0, 0, 0 } }))[3])
  end)
end)
