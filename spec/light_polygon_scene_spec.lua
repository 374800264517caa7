-- Flat lights in grids, scenes, pictures and scene files.

local ylm = require "ylm"
local relative = require "spec.support.vectors".relative

describe("ylm.polygon_light", function()
  it("goes into grids, beside spheres", function()
    local lights = { ylm.polygon_light { vertices = { { -0.5, 1.9, -0.5 }, { 0.5, 1.9, -0.5 }, { 0, 1.9, 0.6 } },
      radiance = 5 },
      ylm.sphere_light { at = { 0.8, 1.5, 0 }, radius = 0.1, radiance = 20 } }
    local bounds = { { -1, 0, -1 }, { 1, 1, 1 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = { 8, 8, 8 }, lmax = 3 }, lights)
    local x = { { 0.1, 0.3, 0.2 }, { -0.4, 0.55, 0.7 } }
    local c = grid:sample(x)
    assert(relative(c, ylm.light_field(3, lights, x)) < 1e-3)
    local adaptive = ylm.bake(ylm.adaptive_grid { bounds = bounds, depth = 3, lmax = 3, threshold = 0.2,
      metric = "absolute" },
      lights, { occupied = x })
    assert(adaptive.stats.points > 8)
  end)

  it("goes into scenes: baked, rendered, referenced and ray cast", function()
    local scene = ylm.scene "a room under a triangle" {
      camera = ylm.camera { from = { 0, 1, 3 }, at = { 0, 0.2, 0 } },
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
      lights = { ylm.polygon_light { vertices = { { -1, 2, -1 }, { 1, 2, -1 }, { 0, 2, 1 } } },
        ylm.sphere_light { at = { 0.5, 1, 0 }, radius = 0.1, radiance = 20 } },
      probes = ylm.uniform_grid { bounds = { { -1, -0.5, -1 }, { 1, 1, 1 } }, cells = { 6, 6, 6 }, lmax = 3 },
    }
    local grid = scene:bake()
    local image = scene:render { grid = grid, size = { 24, 16 } }
    local truth = scene:render { by = "sum", size = { 24, 16 }, lmax = 3 }
    assert(image:compare(truth).rmse < 0.05 * image:compare(truth).peak)
    assert(scene:render { bounces = 0, size = { 8, 8 }, light_samples = 1 })
  end)

  describe("and disk_light in pictures", function()
    --- A floor under a square, a small triangle far up and a tilted disk.
    local function floor(more)
      local scene = {
        camera = ylm.camera { from = { 0, 3, 0.01 }, at = { 0, 0, 0 }, fov = 60 },
        geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
        lights = {
          ylm.polygon_light { vertices = { { -0.9, 0.3, -0.9 }, { -0.5, 0.3, -0.9 }, { -0.5, 0.3, -0.5 },
            { -0.9, 0.3, -0.5 } }, radiance = { 3, 2, 1 } },
          ylm.polygon_light { vertices = { { 10, 60, 0 }, { 12, 60, 0 }, { 10, 60, 2 } }, radiance = 900 },
          ylm.disk_light { at = { 0.6, 0.4, 0.6 }, normal = { 1, 2, 0 }, radius = 0.3, radiance = { 0.5, 1, 2 } },
        },
      }
      for k, v in pairs(more or {}) do scene[k] = v end
      return ylm.scene "floor" (scene)
    end

    it("are sampled without bias: rays without shadows bring what high degrees give", function()
      local scene, size = floor(), { 16, 16 }
      local rays = scene:render { by = "rays", bounces = 0, size = size, light_samples = 1024, samples = 1, visibility = "none" }
      local truth = scene:render { by = "sum", size = size, samples = 1, lmax = 30, visibility = "none" }
      local a, b = rays:layer():totable(), truth:layer():totable()
      local sum_a, sum_b = { 0, 0, 0 }, { 0, 0, 0 }
      for y = 1, 16 do
        for x = 1, 16 do
          for c = 1, 3 do
            sum_a[c], sum_b[c] = sum_a[c] + a[y][x][c], sum_b[c] + b[y][x][c]
            assert.is_near(b[y][x][c], a[y][x][c], 0.02 * math.max(b[y][x][c], 0.2))
          end
        end
      end
      for c = 1, 3 do assert.is_near(1, sum_a[c] / sum_b[c], 2e-3) end
    end)

    it("are drawn as emitters from both sides, in every kind of picture", function()
      local probes = ylm.uniform_grid { cells = { 2, 2, 2 }, lmax = 1, bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }
      for _, side in ipairs { 1, -1 } do
        local scene = floor { camera = ylm.camera { from = { -0.7, 0.3 + side, -0.7 }, at = { -0.7, 0.3, -0.7 },
          up = { 0, 0, 1 }, fov = 10 }, geometry = {}, probes = probes }
        local size = { 4, 4 }
        for _, image in ipairs { scene:render { bounces = 0, size = size, samples = 1, light_samples = 64 },
          scene:render { by = "sum", size = size, samples = 1 },
          (scene:render { size = size, samples = 1, grid = scene:bake { occupied = "everywhere" } }) } do
          assert.equal(1, image:layer "emitter":get(2, 2, 1))
          assert.equal(3, image:layer():get(2, 2, 1))
          assert.equal(1, image:layer():get(2, 2, 3))
        end
      end
      local disk = floor { camera = ylm.camera { from = { 1.1, 1.4, 0.6 }, at = { 0.6, 0.4, 0.6 }, fov = 10 } }
      assert.equal(2, disk:render { bounces = 0, size = { 2, 2 }, samples = 1, light_samples = 64 }:layer():get(1, 1, 3))
    end)

    it("are cut at their horizon for rays too", function()
      local up = { 0, 0.8, 0.6 }
      local lights = {
        ylm.polygon_light { vertices = { { -0.9, 0.1, -0.9 }, { -0.9, 0.1, 0.9 }, { -0.9, 1, 0.9 }, { -0.9, 1, -0.9 } },
          horizon = up, radiance = { 3, 2, 1 } },
        ylm.disk_light { at = { 0.6, 0.5, -0.4 }, normal = { 1, 0, 0 }, radius = 0.4, radiance = { 1, 2, 3 }, horizon = up },
      }
      local scene, size = floor { lights = lights }, { 12, 12 }
      local rays = scene:render { by = "rays", bounces = 0, size = size, light_samples = 1024, samples = 1, visibility = "none" }
      local truth = scene:render { by = "sum", size = size, samples = 1, lmax = 30, visibility = "none" }
      local whole = floor { lights = { ylm.polygon_light { vertices = lights[1].vertices, radiance = 3 } } }
        :render { by = "rays", bounces = 0, size = size, light_samples = 1024, samples = 1, visibility = "none" }
      local a, b, c, covered = rays:layer():totable(), truth:layer():totable(), whole:layer():totable(),
        rays:layer "coverage"
      local less = 0
      for y = 1, 12 do
        for x = 1, 12 do
          if covered:get(y, x, 1) == 1 then
            for k = 1, 3 do assert.is_near(b[y][x][k], a[y][x][k], 0.06 * math.max(b[y][x][k], 0.3)) end
            if a[y][x][1] < 0.9 * c[y][x][1] then less = less + 1 end
          end
        end
      end
      assert(less >= 10, less)
    end)

    it("throw shadows, but not those of the wall that they hang on", function()
      local light = ylm.polygon_light { vertices = { { -0.2, 1, -0.2 }, { 0.2, 1, -0.2 }, { 0.2, 1, 0.2 },
        { -0.2, 1, 0.2 } }, radiance = 10 }
      local function brightness(lid)
        local geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } }
        if lid then
          geometry[2] = ylm.quad { corner = { -0.5, lid, 0.5 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } }
        end
        local image = floor { geometry = geometry, lights = { light },
          camera = ylm.camera { from = { 0.3, 0.2, 0 }, at = { 0, 0, 0 }, fov = 5 } }
          :render { bounces = 0, size = { 4, 4 }, light_samples = 64, samples = 1 }
        return image:layer():get(2, 2, 1)
      end
      assert.equal(0, brightness(0.5))
      assert.is_near(1, brightness(1) / brightness(), 1e-4)
      assert.is_near(1, brightness(1.5) / brightness(), 1e-4)
    end)
  end)

  it("and disk_light stand in scene files, bake to a tolerance there and are shown", function()
    local folder = require("spec.support.scratch").new()
    local path = folder:write("flat.lua", [[
return scene "flat" {
  camera = camera { from = { 0, 1, 3 }, at = { 0, 0.2, 0 } },
  geometry = { quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
  lights = {
    polygon_light { vertices = { { -1, 2, -1 }, { 1, 2, -1 }, { 0, 2, 1 } }, radiance = 3, horizon = { 0, 1, 0 } },
    disk_light { at = { 0.5, 1, 0 }, normal = { 1, 0, 0 }, radius = 0.2 },
  },
  probes = adaptive_grid { lmax = 3, depth = 5, tolerance = 0.02 },
}]])
    local scene = assert(ylm.load(path))
    local grid = assert(scene:bake())
    assert(grid.stats.error <= 0.02, grid.stats.error)
    local truth = scene:render { by = "sum", size = { 32, 24 }, samples = 1, lmax = 3 }
    local image = scene:render { grid = grid, size = { 32, 24 }, samples = 1 }
    assert(image:compare(truth).rmse < 0.01 * image:compare(truth).peak)
    if require("ylm.picture").vtk() then
      for _, what in ipairs { { scene = scene, lights = true }, { lights = scene.lights[2] }, { lights = scene.lights } } do
        what.size = { 160, 160 }
        local picture = folder.path .. "/lights.png"
        assert(ylm.view(what):save(picture))
        local lit = 0
        for _, row in ipairs(ylm.load(picture):layer():totable()) do
          for _, p in ipairs(row) do if p[3] > 0.3 then lit = lit + 1 end end
        end
        assert(lit > 20, lit)
      end
    end
    folder:remove()
  end)
end)
