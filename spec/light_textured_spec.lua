local core = require "ylm.c.core"
local ylm = require "ylm"
local scratch = require "spec.support.scratch"

local relative = require "spec.support.vectors".relative

--- A panel 2 by 1 with these rows of texels, standing over the origin.
local function panel(image, more)
  local fields = { corner = { -1, 0.4, -0.3 }, u = { 2, 0, 0 }, v = { 0, 1, 0.2 }, image = image }
  for k, v in pairs(more or {}) do fields[k] = v end
  return ylm.textured_light(fields)
end

local window = { { { 4, 0, 0 }, { 0, 4, 0 }, { 0, 0, 4 }, { 0, 0, 0 } }, { { 1, 1, 1 }, { 0, 0, 0 }, { 2, 2, 0 }, { 0, 3, 3 } } }

describe("ylm.textured_light", function()
  --- Coefficients [point][3][count] by Gauss's rule of 4 x 4 nodes in each of 8 x 8 cells of each texel of a panel.
  -- Light below the horizon is left out; the horizon has to follow the cells.
  local function by_quadrature(lmax, texels, points, horizon)
    local nodes, weights = { 0.0694318442029737, 0.3300094782075719, 0.6699905217924281, 0.9305681557970263 },
      { 0.1739274225687269, 0.3260725774312731, 0.3260725774312731, 0.1739274225687269 }
    local cells, rows, columns = 8, #texels, #texels[1]
    local normal, area = { 0, -0.2 / math.sqrt(1.04), 1 / math.sqrt(1.04) }, 2 * math.sqrt(1.04)
    local out = {}
    for i, x in ipairs(points) do
      local directions, values, solid = {}, {}, {}
      for a = 0, columns * cells - 1 do
        for b = 0, rows * cells - 1 do
          local colour = texels[math.floor(b / cells) + 1][math.floor(a / cells) + 1]
          for j = 1, 4 do
            for k = 1, 4 do
              local s, t = (a + nodes[j]) / (columns * cells), 1 - (b + nodes[k]) / (rows * cells)
              local d = { -1 + 2 * s - x[1], 0.4 + t - x[2], -0.3 + 0.2 * t - x[3] }
              local d2 = d[1] ^ 2 + d[2] ^ 2 + d[3] ^ 2
              local cosine = math.abs(d[2] * normal[2] + d[3] * normal[3]) / math.sqrt(d2)
              local up = horizon and d[1] * horizon[1] + d[2] * horizon[2] + d[3] * horizon[3] or 1
              local n = #directions + 1
              directions[n], values[n] = d, colour
              solid[n] = up > 0 and weights[j] * weights[k] * area / (columns * rows * cells ^ 2) * cosine / d2 or 0
            end
          end
        end
      end
      out[i] = ylm.sh.project(lmax, { directions = directions, values = values, weights = solid }):totable()
    end
    return ylm.array(out)
  end

  it("is what its rectangle sends, by independent quadrature: near, grazing, and over a horizon", function()
    local image = { { { 4, 0, 0 }, { 0, 4, 1 } }, { { 1, 1, 1 }, { 2, 2, 0 } } }
    local x = { { 0.3, 0.9, 0.3 }, { -1.6, 0.95, -0.12 }, { 2, 0.9, -0.1 } } -- half a unit in front, and 5 degrees off
    for _, horizon in ipairs { false, { 1, 0, 0 } } do
      local at = horizon and { { 0, 0.9, 0.3 }, { -0.25, 1.3, -0.6 } } or x
      local wanted = by_quadrature(4, image, at, horizon)
      local seen = ylm.light_field(4, panel(image, { horizon = horizon or nil }), at, { dtype = "double" })
      assert(relative(seen, wanted) < 1e-7, relative(seen, wanted))
    end
  end)

  it("spheres: are times |cos gamma|, so that they meet the rectangle at grazing angles too", function()
    local flat = { { 1, 1, 1, 1 }, { 1, 1, 1, 1 } }
    for _, try in ipairs { { 0.3, 0.9, 0.3, 0.2 }, { 0.3, 0.9, 1.8, 0.02 }, { 4, 0.9, 0.1, 0.02 }, { 0, 5, 0.9, 0.01 } } do
      local x = { { try[1], try[2], try[3] } }
      local exact = ylm.light_field(4, panel(flat), x, { dtype = "double" })
      local e = relative(ylm.light_field(4, panel(flat, { method = "spheres" }), x, { dtype = "double" }), exact)
      assert(e < try[4], ("%g %g %g: %.2e"):format(try[1], try[2], try[3], e))
    end
  end)

  it("makes a part of each texel, of its area and colour, row 1 at the top", function()
    local image = ylm.image { size = { 2, 2 }, layers = { { "radiance", 3 } } }
    core.array_fill(image:layer(), { { { 1, 0, 0 }, { 0, 2, 0 } }, { { 0, 0, 3 }, { 4, 4, 4 } } })
    local lights = ylm.textured_light { corner = { 0, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, image = image }
    assert.equal(4, lights.count)
    local vertices, radiance = core.texture_quads(lights.texels, lights.frame, 1, 0, 1)
    local seen = {}
    for i = 1, 4 do
      for a = 1, 2 do assert.equal(1, vertices:get(4 * i - 1, a) - vertices:get(4 * i - 3, a)) end
      seen[("%g %g"):format(vertices:get(4 * i - 3, 1), vertices:get(4 * i - 3, 2))] = radiance[i]:totable()
    end
    assert.same({ 1, 0, 0 }, seen["0 1"])
    assert.same({ 0, 2, 0 }, seen["1 1"])
    assert.same({ 0, 0, 3 }, seen["0 0"])
  end)

  it("merges similar texels by a quadtree, keeping the power", function()
    local image = ylm.image { size = { 16, 8 }, layers = { { "radiance", 3 } } }
    local rows, power = {}, 0
    for y = 1, 8 do
      rows[y] = {}
      for x = 1, 16 do
        local v = x <= 8 and 1 or 2 + 0.01 * y
        rows[y][x] = { v, v, v }
        power = power + v / 128
      end
    end
    core.array_fill(image:layer(), rows)
    local function make(tolerance)
      return ylm.textured_light { corner = { 0, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 1, 0 }, image = image,
        tolerance = tolerance, largest = 1 }
    end
    local merged = make(0.1)
    assert.equal(2, merged.count)
    assert(make(0).count > 16)
    local vertices, radiance = core.texture_quads(merged.texels, merged.frame, 1, 0.1, 1)
    local sum = 0
    for i = 1, 2 do
      sum = sum + (vertices:get(4 * i - 1, 1) - vertices:get(4 * i - 3, 1))
        * (vertices:get(4 * i - 1, 2) - vertices:get(4 * i - 3, 2)) * radiance:get(i, 1)
    end
    assert.is_near(2 * power, sum, 1e-6)
  end)

  it("stays near the full set of texels, whatever the image's shape", function()
    local function texel(u, v, w, h, radiance)
      local a, b, r, t = -1 + 2 * u - 1 / w, 0.75 - 1.5 * v - 0.75 / h, 2 / w, 1.5 / h
      return ylm.polygon_light { vertices = { { a, b, 0 }, { a + r, b, 0 }, { a + r, b + t, 0 }, { a, b + t, 0 } },
        radiance = radiance }
    end
    for _, size in ipairs { { 61, 37 }, { 1, 7 }, { 5, 1 }, { 1, 1 }, { 33, 32 } } do
      local w, h = size[1], size[2]
      local image = ylm.image { size = size, layers = { { "radiance", 3 } } }
      local rows, full = {}, {}
      for y = 1, h do
        rows[y] = {}
        for x = 1, w do
          local u, v = (x - 0.5) / w, (y - 0.5) / h
          local bright = (u - 0.7) ^ 2 + (v - 0.3) ^ 2 < 0.01
          rows[y][x] = bright and { 4, 3.6, 3 } or { 0.3 + 0.4 * v, 0.4 + 0.4 * v, 0.9 }
          full[#full + 1] = texel(u, v, w, h, rows[y][x])
        end
      end
      core.array_fill(image:layer(), rows)
      local x = { { 0, 0, -1 }, { 0.7, 0.4, -1.2 }, { -0.6, -0.3, -1.5 } }
      local truth = ylm.light_field(4, full, x, { dtype = "double" })
      for _, tolerance in ipairs { 0, 0.01, 0.1 } do
        local lights = ylm.textured_light { corner = { -1, -0.75, 0 }, u = { 2, 0, 0 }, v = { 0, 1.5, 0 }, image = image,
          tolerance = tolerance }
        local e = relative(ylm.light_field(4, lights, x, { dtype = "double" }), truth)
        assert(e < 4e-3, ("%dx%d tolerance %g: %.1e"):format(w, h, tolerance, e))
        if w == 61 and tolerance == 0.1 then assert(lights.count < w * h / 5) end
      end
    end
  end)

  it("takes rows of numbers or colours, images of any channels, and files", function()
    local folder = scratch.new()
    local grey = { { 1, 2, 3, 0 }, { 0.5, 0, 0, 4 } }
    local colours = {}
    for y, row in ipairs(grey) do
      colours[y] = {}
      for x, v in ipairs(row) do colours[y][x] = { v, v, v } end
    end
    local x = { { 0.3, 0.2, 1.5 }, { -0.4, 0.6, -2 } }
    local wanted = ylm.light_field(3, panel(colours), x, { dtype = "double" })
    assert.same(wanted:totable(), ylm.light_field(3, panel(grey), x, { dtype = "double" }):totable())
    for channels = 1, 4 do
      local image = ylm.image { size = { 4, 2 }, layers = { { "radiance", channels } } }
      local texels = {}
      for y, row in ipairs(grey) do
        texels[y] = {}
        for k, v in ipairs(row) do
          texels[y][k] = ({ { v }, { v, 0.7 }, { v, v, v }, { v, v, v, 0.7 } })[channels]
        end
      end
      core.array_fill(image:layer(), texels)
      assert.same(wanted:totable(), ylm.light_field(3, panel(image), x, { dtype = "double" }):totable())
      if image:save(folder.path .. "/panel.exr") then
        local light = ylm.textured_light { corner = { -1, 0.4, -0.3 }, u = { 2, 0, 0 }, v = { 0, 1, 0.2 },
          file = folder.path .. "/panel.exr" }
        assert.same(wanted:totable(), ylm.light_field(3, light, x, { dtype = "double" }):totable())
      end
    end
    folder:remove()
  end)

  it("exact: is the sum of its texels as polygons; both methods meet far away", function()
    local quads = {}
    for y = 1, 2 do
      for x = 1, 4 do
        local function at(s, t) return { -1 + 2 * s / 4, 1.4 - t / 2, -0.1 - 0.2 * t / 2 } end
        quads[#quads + 1] = ylm.polygon_light { radiance = window[y][x],
          vertices = { at(x - 1, y), at(x, y), at(x, y - 1), at(x - 1, y - 1) } }
      end
    end
    local x = { { 0.3, 0.2, 1.5 }, { -0.4, 0.6, -0.7 }, { 3, 1, 0 } }
    local wanted = { ylm.light_field(4, quads, x, { dtype = "double", derivatives = 2 }) }
    local light = panel(window)
    local seen = { ylm.light_field(4, light, x, { dtype = "double", derivatives = 2 }) }
    for k = 1, 3 do assert(relative(seen[k], wanted[k]) < 1e-12) end
    assert.equal(6, light.count) -- black texels are left out
    local far = { { 0, -194, 970 } } -- in front
    assert(relative(ylm.light_field(4, panel(window, { method = "spheres" }), far, { dtype = "double" }),
      ylm.light_field(4, light, far, { dtype = "double" })) < 1e-3)
  end)

  it("joins spheres and polygons in lists, which are summed, drawn and told apart", function()
    local light = require "ylm.light"
    local sphere = ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.2, radiance = 9 }
    local polygon = ylm.polygon_light { vertices = { { -1, 2, -1 }, { 1, 2, -1 }, { 0, 2, 1 } } }
    local x = { { 0.3, 0.2, 1.5 }, { -0.4, 0.6, -0.7 } }
    for _, method in ipairs { "spheres", "exact" } do
      local one = panel(window, { method = method })
      local total
      for _, l in ipairs { one, sphere, polygon, one } do
        local L = ylm.light_field(3, l, x, { dtype = "double" }):totable()
        total = total or ylm.zeros { 2, 3, 16 }
        for i = 1, 2 do for c = 1, 3 do for k = 1, 16 do
          total:set(i, c, k, total:get(i, c, k) + L[i][c][k])
        end end end
      end
      assert(relative(ylm.light_field(3, { one, sphere, { polygon, one } }, x, { dtype = "double" }), total) < 1e-14)
      local packed = light.pack(1, "spec", { one, sphere, polygon, one })
      assert.same({ { 0, 3, 0 } }, (light.arrays(packed):totable()))
      local triangles, disks, radiance, textures = light.patches(packed)
      assert.same({ 1 + 2 * 16, 0, 33, 2 }, { #triangles, #disks, #radiance, #textures })
      assert.equal(0, #light.arrays(light.pack(1, "spec", one)))
      assert.equal(0, #light.arrays(light.pack(1, "spec", { one })))
    end
    assert.equal("textured_light of 4x2 texels in 6 parts", tostring(panel(window)))
  end)

  it("bakes into uniform and adaptive grids", function()
    for _, method in ipairs { "spheres", "exact" } do
      local light = panel(window, { method = method })
      local bounds = { { -1, -0.5, 0.8 }, { 1, 1, 2 } }
      local uniform = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = { 8, 8, 8 }, lmax = 3 }, light)
      local adaptive = ylm.bake(ylm.adaptive_grid { bounds = bounds, lmax = 3, depth = 5, tolerance = 0.02 }, light)
      assert(adaptive.stats.error <= 0.02, adaptive.stats.error)
      local x = { { 0.3, 0.2, 1.5 }, { -0.4, 0.6, 1.1 } }
      local truth = ylm.light_field(3, light, x)
      assert(relative(uniform:sample(x), truth) < 0.02)
      assert(relative(adaptive:sample(x), truth) < 0.02)
    end
  end)

  describe("in pictures", function()
    local function floor(light, camera)
      return ylm.scene "panel" {
        camera = camera or ylm.camera { from = { 0, 3, 2.01 }, at = { 0, 0, 0.5 }, fov = 50 },
        geometry = { ylm.quad { corner = { -1, 0, 1.5 }, u = { 2, 0, 0 }, v = { 0, 0, -1.2 } } },
        lights = { light },
      }
    end

    it("is drawn with its texels, from both sides, by rays, without interpolation and by grids", function()
      local size = { 40, 20 }
      for side = -1, 1, 2 do
        -- straight at its middle, which then fills the picture's width
        local camera = ylm.camera { from = { 0, 0.9 - 0.2 * side, -0.2 + side }, at = { 0, 0.9, -0.2 },
          up = { 0, 1, 0.2 }, fov = 2 * math.deg(math.atan(0.5 / math.sqrt(1.04))) * 1.06 }
        local scene = floor(panel(window), camera)
        scene.probes = ylm.uniform_grid { cells = { 2, 2, 2 }, lmax = 1, bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }
        for _, image in ipairs { scene:render { bounces = 0, size = size, samples = 1, light_samples = 1 },
          scene:render { by = "sum", size = size, samples = 1, transfer_samples = 1 },
          (scene:render { size = size, samples = 1, transfer_samples = 1,
            grid = scene:bake { occupied = "everywhere" } }) } do
          for y = 1, 2 do
            for x = 1, 4 do
              local column = side > 0 and x or 5 - x
              local px, py = 10 * column - 5, 10 * y - 5
              local seen = {}
              for c = 1, 3 do seen[c] = image:layer():get(py + 1, px + 1, c) end
              assert.same(window[y][x], seen, ("texel %d %d from %d"):format(x, y, side))
              assert.equal(1, image:layer "emitter":get(py + 1, px + 1, 1))
            end
          end
        end
      end
    end)

    it("is sampled without bias: rays without shadows bring what high degrees of the exact method give", function()
      local scene, size = floor(panel(window, { method = "exact", scale = 2 })), { 12, 12 }
      local rays = scene:render { by = "rays", bounces = 0, size = size, light_samples = 1024, samples = 1, visibility = "none" }
      local truth = scene:render { by = "sum", size = size, samples = 1, lmax = 30, visibility = "none" }
      local a, b, hits = rays:layer():totable(), truth:layer():totable(), rays:layer "coverage"
      local sums = { { 0, 0, 0 }, { 0, 0, 0 } }
      for y = 1, 12 do
        for x = 1, 12 do
          if hits:get(y, x, 1) == 1 then
            for c = 1, 3 do
              sums[1][c], sums[2][c] = sums[1][c] + a[y][x][c], sums[2][c] + b[y][x][c]
              assert.is_near(b[y][x][c], a[y][x][c], 0.06 * math.max(b[y][x][c], 0.1))
            end
          end
        end
      end
      for c = 1, 3 do assert.is_near(1, sums[1][c] / sums[2][c], 4e-3) end
    end)

    it("stands in scene files, from a file beside them or from rows", function()
      local folder = scratch.new()
      local image = ylm.image { size = { 4, 2 }, layers = { { "radiance", 3 } } }
      core.array_fill(image:layer(), window)
      assert(image:save(folder.path .. "/panel.exr"))
      local picture = {}
      for i, given in ipairs { "file = 'panel.exr'", "image = { { { 4, 0, 0 }, { 0, 4, 0 }, { 0, 0, 4 }, { 0, 0, 0 } }, "
        .. "{ { 1, 1, 1 }, { 0, 0, 0 }, { 2, 2, 0 }, { 0, 3, 3 } } }" } do
        local scene = assert(ylm.load(folder:write("panel.lua", [[
return scene "panel" {
  camera = camera { from = { 0, 3, 2.01 }, at = { 0, 0, 0.5 }, fov = 50 },
  geometry = { quad { corner = { -1, 0, 1.5 }, u = { 2, 0, 0 }, v = { 0, 0, -1.2 } } },
  lights = { textured_light { corner = { -1, 0.4, -0.3 }, u = { 2, 0, 0 }, v = { 0, 1, 0.2 }, ]] .. given .. [[ } },
  probes = adaptive_grid { lmax = 3, depth = 5, tolerance = 0.02 },
}]])))
        picture[i] = assert(scene:render { size = { 32, 24 }, samples = 1, transfer_samples = 16, visibility = "transfer" })
        local truth = scene:render { by = "sum", size = { 32, 24 }, samples = 1, lmax = 3, transfer_samples = 16 }
        assert(picture[i]:compare(truth).rmse < 0.01 * picture[i]:compare(truth).peak)
        if require("ylm.picture").vtk() then
          assert(ylm.view { scene = scene, lights = true, size = { 160, 120 } }:save(folder.path .. "/view.png"))
        end
      end
      assert.equal(0, picture[1]:compare(picture[2]).max)
      folder:remove()
    end)
  end)
end)
