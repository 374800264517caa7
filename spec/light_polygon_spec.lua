local ylm = require "ylm"

local relative = require "spec.support.vectors".relative

--- Polygons of spec/data/polygon_light.txt: { kind =, x =, vertices =, value = {36}, gradient = {36 x 3} }.
local function reference()
  local list = {}
  for line in io.lines "spec/data/polygon_light.txt" do
    local letter, rest = line:match "^([PC]) (.*)"
    if letter then
      local words = {}
      for w in rest:gmatch "%S+" do words[#words + 1] = w end
      if letter == "P" then
        local n = {}
        for i = 4, #words do n[#n + 1] = tonumber(words[i]) end
        local set = { kind = words[2], x = { n[1], n[2], n[3] }, vertices = {}, value = {}, gradient = {} }
        for k = 4, #n, 3 do table.insert(set.vertices, { n[k], n[k + 1], n[k + 2] }) end
        list[#list + 1] = set
      else
        local set, l, m = list[#list], tonumber(words[2]), tonumber(words[3])
        local k = l * (l + 1) + m + 1
        set.value[k] = tonumber(words[4])
        set.gradient[k] = { tonumber(words[5]), tonumber(words[6]), tonumber(words[7]) }
      end
    end
  end
  return list
end

local function field(lmax, light, x, derivatives)
  return ylm.light_field(lmax, light, x, { derivatives = derivatives, channels = "luminance", dtype = "double" })
end

--- Value, gradient and Hessian at x in double, each as a flat table.
local function derivatives(lmax, light, x)
  local list = { ylm.light_field(lmax, light, ylm.array({ x }, "double"), { derivatives = 2, channels = "luminance" }) }
  for k = 1, 3 do list[k] = list[k]:totable()[1][1] end
  return list
end

--- The relative errors of gradient and Hessian against sixth-order differences of value and gradient at step h.
local function against_differences(lmax, light, x, h)
  local here, weights = derivatives(lmax, light, x), { 45 / 60, -9 / 60, 1 / 60 }
  local error, norm = { 0, 0 }, { 0, 0 }
  local place = { { 1, 2, 3 }, { 2, 4, 5 }, { 3, 5, 6 } }
  for a = 1, 3 do
    local near = {}
    for s = -3, 3 do
      local p = { x[1], x[2], x[3] }
      p[a] = p[a] + s * h
      near[s] = derivatives(lmax, light, p)
    end
    local function difference(get)
      local d = 0
      for s = 1, 3 do d = d + weights[s] * (get(near[s]) - get(near[-s])) / h end
      return d
    end
    for k = 1, (lmax + 1) ^ 2 do
      error[1] = error[1] + (here[2][k][a] - difference(function(n) return n[1][k] end)) ^ 2
      norm[1] = norm[1] + here[2][k][a] ^ 2
      for b = 1, 3 do
        local H = here[3][k][place[a][b]]
        error[2] = error[2] + (H - difference(function(n) return n[2][k][b] end)) ^ 2
        norm[2] = norm[2] + H ^ 2
      end
    end
  end
  return math.sqrt(error[1] / norm[1]), math.sqrt(error[2] / norm[2])
end

local triangle = { { -0.5, 1, -0.3 }, { 0.7, 1.2, -0.2 }, { 0.1, 1.5, 0.6 } }

describe("ylm.polygon_light", function()
  it("is its solid angle in the first coefficient, for either winding and from either side", function()
    local octant = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }
    local turned = { { 0, 0, 1 }, { 0, 1, 0 }, { 1, 0, 0 } }
    local wanted = math.pi / 2 * math.sqrt(1 / (4 * math.pi))
    for _, v in ipairs { octant, turned } do
      local L = field(2, ylm.polygon_light { vertices = v }, { 0, 0, 0 }, 0)
      assert.is_near(wanted, L:get(1, 1), 1e-15)
    end
    local light = ylm.polygon_light { vertices = { { -1, -1, 1 }, { 1, -1, 1 }, { 1, 1, 1 }, { -1, 1, 1 } } }
    assert.is_near(4 * math.pi / 6 * math.sqrt(1 / (4 * math.pi)), field(0, light, { 0, 0, 0 }, 0):get(1, 1), 1e-14)
    assert.is_near(field(0, light, { 0, 0, 0 }, 0):get(1, 1), field(0, light, { 0, 0, 2 }, 0):get(1, 1), 1e-14)
  end)

  it("agrees with the reference vectors, values and gradients", function()
    local seen = 0
    for _, set in ipairs(reference()) do
      local L, dL = field(5, ylm.polygon_light { vertices = set.vertices }, set.x, 1)
      -- small polygons are differences of large numbers
      local tolerance = set.kind == "far_small" and 1e-9 or 1e-12
      assert(relative(L, ylm.array(set.value)) < tolerance, set.kind .. " value " .. relative(L, ylm.array(set.value)))
      assert(relative(dL, ylm.array(set.gradient)) < tolerance,
        set.kind .. " gradient " .. relative(dL, ylm.array(set.gradient)))
      seen = seen + 1
    end
    assert(seen > 15)
  end)

  it("adds up: a polygon is the sum of the triangles it is cut into", function()
    local quad = { { -1, 1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { -1, 1, 1 } }
    local whole = ylm.polygon_light { vertices = quad, radiance = { 1, 2, 3 } }
    local parts = { ylm.polygon_light { vertices = { quad[1], quad[2], quad[3] }, radiance = { 1, 2, 3 } },
      ylm.polygon_light { vertices = { quad[1], quad[3], quad[4] }, radiance = { 1, 2, 3 } } }
    local x = { { 0.2, 0.3, 0.1 }, { 3, -1, 2 } }
    for k = 0, 2 do
      local a = { ylm.light_field(9, whole, x, { derivatives = 2, dtype = "double" }) }
      local b = { ylm.light_field(9, parts, x, { derivatives = 2, dtype = "double" }) }
      assert(relative(b[k + 1], a[k + 1]) < 1e-12, k)
    end
  end)

  describe("has gradients and Hessians that are the derivatives of what they derive, to 1e-9", function()
    local quad = { { -1, 1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { -1, 1, 1 } }
    local wall = { { 1, -1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { 1, -1, 1 } }
    local sliver = { { -1, 1, 0 }, { 1, 1, 0 }, { 1, 1, 1e-4 } }
    local polygon = ylm.polygon_light
    local cases = {
      { "before a triangle", { vertices = triangle }, { 0.3, -0.4, 0.2 }, 1e-2 },
      { "by the sphere method", { vertices = triangle, method = "sphere" }, { 0.3, -0.4, 0.2 }, 1e-2 },
      { "at lmax 20", { vertices = triangle }, { 0.3, -0.4, 0.2 }, 3e-3, 20 },
      { "behind it", { vertices = triangle }, { 0.1, 2.4, 0.2 }, 1e-2 },
      { "close to its face", { vertices = triangle }, { 0.1, 1.2, 0.03 }, 4e-4 },
      { "close to an edge", { vertices = quad }, { 1.02, 0.99, 0.3 }, 2e-4 },
      { "on an edge's line, beyond it", { vertices = quad }, { 2.5, 0.9, 1 }, 1e-3 },
      { "nearly in its plane", { vertices = quad }, { 3.5, 0.99, 0.2 }, 1e-4 },
      { "where a sliver is seen", { vertices = sliver }, { 0.2, -0.3, 0.4 }, 5e-3 },
      { "far off", { vertices = triangle }, { 3, -10, 2 }, 5e-2 },
      { "farther off", { vertices = triangle }, { 30, -100, 20 }, 0.5 },
      { "very far off", { vertices = triangle }, { 3e4, -1e5, 2e4 }, 500 },
      { "where a horizon cuts it", { vertices = wall, horizon = { 0, 0, 1 } }, { 0.1, 0.2, 0.2 }, 5e-3 },
      { "where a slanting horizon cuts it", { vertices = wall, horizon = { 0.3, 0.5, 1 } }, { 0.1, 0.2, 0.2 }, 5e-3 },
      { "close to a face that a horizon cuts", { vertices = quad, horizon = { 1, 0.2, 0.3 } }, { 0.1, 0.9, 0.2 }, 1e-3 },
    }
    for _, case in ipairs(cases) do
      it(case[1], function()
        local g, h = against_differences(case[5] or 4, polygon(case[2]), case[3], case[4])
        assert(g < 1e-9 and h < 1e-9, ("gradient %.1e, Hessian %.1e"):format(g, h))
      end)
    end
  end)

  it("by the sphere method is Eqs. 24-26 of Mezieres et al. 2022", function()
    local light = ylm.polygon_light { vertices = triangle, method = "sphere" }
    local x = { 0.1, -0.5, 0.4 }
    local p = {}
    for a = 1, 3 do p[a] = (triangle[1][a] + triangle[2][a] + triangle[3][a]) / 3 end
    local u, v = {}, {}
    for a = 1, 3 do u[a], v[a] = triangle[2][a] - triangle[1][a], triangle[3][a] - triangle[1][a] end
    local n = { u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1] }
    local area2 = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
    local d = { p[1] - x[1], p[2] - x[2], p[3] - x[3] }
    local cosine = math.abs(n[1] * d[1] + n[2] * d[2] + n[3] * d[3]) / area2 / math.sqrt(d[1] ^ 2 + d[2] ^ 2 + d[3] ^ 2)
    local sphere = ylm.sphere_light { at = p, radius = math.sqrt(area2 / (2 * math.pi)), radiance = 1 }
    local S, L = field(4, sphere, x, 0), field(4, light, x, 0)
    for k = 1, 25 do assert.is_near(S:get(1, k) * cosine, L:get(1, k), 1e-14) end
  end)

  it("far away, approximation and exact polygon meet", function()
    local exact = ylm.polygon_light { vertices = triangle }
    local rough = ylm.polygon_light { vertices = triangle, method = "sphere" }
    local before = 1
    for _, d in ipairs { 3, 10, 30 } do
      local x = { 0.3 * d, -d, 0.2 * d }
      local difference = relative(field(4, rough, x, 0), field(4, exact, x, 0))
      assert(difference < before)
      before = difference
    end
    assert(before < 2e-3, before)
  end)

  it("is cut at the horizon: what is above, and its gradient with the horizon's motion", function()
    local quad = { { 1, -1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { 1, -1, 1 } }
    local cut = ylm.polygon_light { vertices = quad, horizon = { 0, 0, 1 } }
    local upper = ylm.polygon_light { vertices = { { 1, -1, 0.2 }, { 1, 1, 0.2 }, { 1, 1, 1 }, { 1, -1, 1 } } }
    local x = { 0.1, 0.2, 0.2 }
    assert(relative(field(6, cut, x, 0), field(6, upper, x, 0)) < 1e-13)
    local h = 1e-4
    local _, dL = field(4, cut, x, 1)
    for a = 1, 3 do
      local p, q = { x[1], x[2], x[3] }, { x[1], x[2], x[3] }
      p[a], q[a] = p[a] + h, q[a] - h
      local P, Q = field(4, cut, p, 0), field(4, cut, q, 0)
      for k = 1, 25 do assert.is_near((P:get(1, k) - Q:get(1, k)) / (2 * h), dL:get(1, k, a), 1e-6) end
    end
    local down = ylm.polygon_light { vertices = quad, horizon = { 0, 0, -1 } }
    local whole, above, rest = derivatives(6, ylm.polygon_light { vertices = quad }, x), derivatives(6, cut, x),
      derivatives(6, down, x)
    for k = 1, 49 do -- what two horizons keep is the whole, their motion cancels
      assert.is_near(whole[1][k], above[1][k] + rest[1][k], 1e-14)
      for q = 1, 6 do assert.is_near(whole[3][k][q], above[3][k][q] + rest[3][k][q], 1e-13) end
    end
    local below = ylm.polygon_light { vertices = { { 1, -1, -2 }, { 1, 1, -2 }, { 1, 0, -1 } }, horizon = { 0, 0, 1 } }
    local nothing = field(3, below, x, 0)
    for k = 1, 16 do assert.equal(0, nothing:get(1, k)) end
  end)

  describe("has kernels that agree with the reference:", function()
    local light = require "ylm.light"
    --- A convex polygon of n sides in a plane at random; deterministic.
    local state = 7
    local function random()
      state = (state * 16807) % 2147483647
      return state / 2147483647
    end
    local function polygon(n)
      local c, size = { 4 * random() - 2, 1 + random(), 4 * random() - 2 }, 0.05 + random()
      local u = { 1, 0.5 * random(), 0.3 * random() }
      local v = { -0.4 * random(), 0.1, 1 }
      local vertices = {}
      for i = 1, n do
        local a, b = size * math.cos(2 * math.pi * i / n), size * math.sin(2 * math.pi * i / n)
        vertices[i] = {}
        for k = 1, 3 do vertices[i][k] = c[k] + a * u[k] + b * v[k] end
      end
      return ylm.polygon_light { vertices = vertices, radiance = { 1 + random(), 2 * random(), -random() } }
    end
    local lights = {}
    for i = 1, 5 do lights[i] = polygon(2 + 2 * i) end
    lights[6] = ylm.polygon_light { vertices = { { -1, 3, -1 }, { 1, 3, -1 }, { 1, 3, 1 }, { -1, 3, 1 } }, radiance = 2 }
    lights[7] = ylm.disk_light { at = { 0, -2, 0 }, normal = { 0, 1, 0.2 }, radius = 0.5 }
    lights[8] = ylm.disk_light { at = { 1.5, 0.5, -1 }, normal = { -1, 0.3, 0.2 }, radius = 0.8, radiance = { 1, -2, 0.5 } }
    lights[9] = ylm.disk_light { at = { 0.2, 8, 0.1 }, normal = { 0.1, 1, 0 }, radius = 3, radiance = 0.3 }
    local packed, few = light.pack(2, "spec", lights), light.pack(2, "spec", { lights[2], lights[6], lights[9] })
    local points = {}
    for i = 1, 37 do points[i] = { 5 * random() - 2.5, 3 * random() - 1, 5 * random() - 2.5 } end
    -- on the square, in its plane, on an edge's line, at a corner, far, close
    for _, x in ipairs { { 0.2, 3, 0.1 }, { 3, 3, 0 }, { 4, 3, 1 }, { 1, 3, 1 }, { 900, 4000, 30 }, { 0.3, 3 - 1e-5, 0.2 },
      { 1e-9, 2, 0 } } do
      points[#points + 1] = x
    end
    for _, isa in ipairs(ylm.info().kernels) do
      if isa ~= "reference" then
        it(isa, function()
          for _, lmax in ipairs { 0, 1, 2, 4, 7, 20, 60 } do
            for _, dtype in ipairs { "double", "float" } do
              local chosen, some = lmax < 20 and packed or few, {}
              for i = lmax < 20 and 1 or 36, #points do some[#some + 1] = points[i] end
              local x = ylm.array(some, dtype)
              for _, o in ipairs { { 0, "rgb" }, { 1, "luminance" }, { 2, "rgb", "rgb" }, { 2, "luminance", "luminance" } } do
                if lmax < 20 or o[3] == "rgb" then
                  local options = { derivatives = o[1], channels = o[2], metric = o[3] }
                  local a = { light.evaluate("spec", lmax, chosen, x, options, isa) }
                  local b = { light.evaluate("spec", lmax, chosen, x, options, "reference") }
                  assert.same(b[4].inside:totable(), a[4].inside:totable())
                  for k = 1, o[1] + 1 do
                    local worst = 0
                    for i = 1, #some do worst = math.max(worst, relative(a[k][i], b[k][i])) end
                    -- the last point but one is 1e-5 from a face: cancellation there
                    assert(worst < (dtype == "double" and 1e-11 or 2e-6),
                      ("lmax %d %s derivative %d %s: %.1e"):format(lmax, dtype, k - 1, o[2], worst))
                  end
                  if o[3] then assert(relative(a[4].lambda, b[4].lambda) < (dtype == "double" and 1e-11 or 1e-6)) end
                end
              end
            end
          end
        end)

        it(isa .. ", whatever else is in a batch", function()
          local x = ylm.array(points, "double")
          local all = light.evaluate("spec", 4, packed, x, { derivatives = 2, channels = "rgb" }, isa):totable()
          for i = 1, #points, 5 do
            local one = light.evaluate("spec", 4, packed, ylm.array({ points[i] }, "double"),
              { derivatives = 2, channels = "rgb" }, isa)
            assert.same(all[i], one:totable()[1])
          end
        end)
      end
    end
  end)

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
    local truth = scene:reference { size = { 24, 16 }, lmax = 3 }
    assert(image:compare(truth).rmse < 0.05 * image:compare(truth).peak)
    assert(scene:raycast { size = { 8, 8 }, samples = 1 })
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
      local rays = scene:raycast { size = size, samples = 1024, pixel_samples = 1, shadows = false }
      local truth = scene:reference { size = size, samples = 1, lmax = 30, visibility = "none" }
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
        for _, image in ipairs { scene:raycast { size = size, pixel_samples = 1 },
          scene:reference { size = size, samples = 1 },
          (scene:render { size = size, samples = 1, grid = scene:bake { occupied = "everywhere" } }) } do
          assert.equal(1, image:layer "emitter":get(2, 2, 1))
          assert.equal(3, image:layer():get(2, 2, 1))
          assert.equal(1, image:layer():get(2, 2, 3))
        end
      end
      local disk = floor { camera = ylm.camera { from = { 1.1, 1.4, 0.6 }, at = { 0.6, 0.4, 0.6 }, fov = 10 } }
      assert.equal(2, disk:raycast { size = { 2, 2 }, pixel_samples = 1 }:layer():get(1, 1, 3))
    end)

    it("are cut at their horizon for rays too", function()
      local up = { 0, 0.8, 0.6 }
      local lights = {
        ylm.polygon_light { vertices = { { -0.9, 0.1, -0.9 }, { -0.9, 0.1, 0.9 }, { -0.9, 1, 0.9 }, { -0.9, 1, -0.9 } },
          horizon = up, radiance = { 3, 2, 1 } },
        ylm.disk_light { at = { 0.6, 0.5, -0.4 }, normal = { 1, 0, 0 }, radius = 0.4, radiance = { 1, 2, 3 }, horizon = up },
      }
      local scene, size = floor { lights = lights }, { 12, 12 }
      local rays = scene:raycast { size = size, samples = 1024, pixel_samples = 1, shadows = false }
      local truth = scene:reference { size = size, samples = 1, lmax = 30, visibility = "none" }
      local whole = floor { lights = { ylm.polygon_light { vertices = lights[1].vertices, radiance = 3 } } }
        :raycast { size = size, samples = 1024, pixel_samples = 1, shadows = false }
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
          :raycast { size = { 4, 4 }, samples = 64, pixel_samples = 1 }
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
    local scene = assert(ylm.load_scene(path))
    local grid = assert(scene:bake { size = { 32, 24 }, samples = 1 })
    assert(grid.stats.error <= 0.02, grid.stats.error)
    local truth = scene:reference { size = { 32, 24 }, samples = 1, lmax = 3 }
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

  it("marks points on it, and gives the field of half the sphere there", function()
    local light = ylm.polygon_light { vertices = { { -1, 0, -1 }, { 1, 0, -1 }, { 0, 0, 1 } } }
    local on = { { 1, 0, -1 }, { 0, 0, 0 }, { 0.5, 0, -1 }, { 0.5, 0, 0 }, { 0, 1, 0 }, { 2, 0, 0 } }
    local L, dL, ddL, report = ylm.light_field(2, light, on, { derivatives = 2, channels = "luminance" })
    assert.same({ 1, 1, 1, 1, 0, 0 }, report.inside:totable())
    for i = 1, 4 do
      assert.is_near(math.sqrt(math.pi), L:get(i, 1, 1), 1e-6)
      for k = 1, 9 do
        assert.equal(0, dL:get(i, 1, k, 1))
        assert.equal(0, ddL:get(i, 1, k, 4))
      end
    end
    for k = 1, 9 do -- edge-on, and not on it: nothing
      assert.equal(0, L:get(6, 1, k))
      assert.equal(0, dL:get(6, 1, k, 2))
    end
  end)

  it("keeps its relative accuracy however far it is", function()
    local light = ylm.polygon_light { vertices = triangle }
    for _, d in ipairs { 20, 30, 100, 350, 400, 1e3, 1e5 } do
      local x = { 0.3 * d, -d, 0.2 * d }
      -- a similar triangle, an eighth of everything
      local small = {}
      for i, v in ipairs(triangle) do small[i] = { v[1] / 8, v[2] / 8, v[3] / 8 } end
      local a = derivatives(4, light, x)
      local b = derivatives(4, ylm.polygon_light { vertices = small }, { x[1] / 8, x[2] / 8, x[3] / 8 })
      for k = 1, 25 do
        assert(math.abs(a[1][k] - b[1][k]) <= 1e-12 * a[1][1])
        for q = 1, 6 do assert(math.abs(a[3][k][q] - b[3][k][q] / 64) <= 1e-11 * a[1][1] / d ^ 2) end
      end
      -- seen from so far it is a point of its projected area
      local u, v, y, r2 = {}, {}, {}, 0
      for q = 1, 3 do
        u[q], v[q] = triangle[2][q] - triangle[1][q], triangle[3][q] - triangle[1][q]
        y[q] = (triangle[1][q] + triangle[2][q] + triangle[3][q]) / 3 - x[q]
        r2 = r2 + y[q] ^ 2
      end
      local n = { u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1] }
      local angle = math.abs(n[1] * y[1] + n[2] * y[2] + n[3] * y[3]) / 2 / r2 ^ 1.5
      assert.is_near(1, a[1][1] / (angle / math.sqrt(4 * math.pi)), 2 / d ^ 2 + 1e-15 * d)
    end
  end)

  it("is the sum of parts that are small enough to be summed over their area", function()
    local function parts(p, q, r, depth, out)
      if depth == 0 then
        out[#out + 1] = ylm.polygon_light { vertices = { p, q, r } }
        return out
      end
      local function mean(u, v) return { (u[1] + v[1]) / 2, (u[2] + v[2]) / 2, (u[3] + v[3]) / 2 } end
      local a, b, c = mean(p, q), mean(q, r), mean(r, p)
      parts(p, a, c, depth - 1, out)
      parts(a, q, b, depth - 1, out)
      parts(c, b, r, depth - 1, out)
      return parts(a, b, c, depth - 1, out)
    end
    local whole = ylm.polygon_light { vertices = triangle }
    for distance, depth in pairs { [15] = 5, [50] = 3, [150] = 2 } do
      local some = parts(triangle[1], triangle[2], triangle[3], depth, {})
      local x = ylm.array({ { 0.1 * distance, -distance, 0.3 * distance }, { distance, 0.2, 0.9 * distance } }, "double")
      local a, b = { ylm.light_field(4, whole, x, { derivatives = 2 }) }, { ylm.light_field(4, some, x, { derivatives = 2 }) }
      for k = 1, 3 do assert(relative(a[k], b[k]) < 1e-12, ("%d: %.1e"):format(distance, relative(a[k], b[k]))) end
    end
  end)

  it("meets the boxes that its face meets, for grids to refine there", function()
    local function cells(z, occupied)
      local light = ylm.polygon_light { vertices = { { 0.1, 0.1, z }, { 0.9, 0.1, z }, { 0.1, 0.15, z } } }
      local grid = ylm.bake(ylm.adaptive_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, depth = 4, lmax = 1,
        threshold = 1e9, metric = "absolute" }, light, { occupied = occupied })
      return grid.stats.cells
    end
    -- cells that the face crosses refine whatever the threshold; those of its bounding sphere do not
    for _, z in ipairs { 0.52, 0.5 } do
      assert.equal(9, cells(z, { { 0.3, 0.6, z } }))
      assert.equal(33, cells(z, { { 0.3, 0.12, z } }))
    end
  end)

  it("refuses what is no convex polygon", function()
    local star, nan = {}, 0 / 0
    for i = 0, 4 do star[i + 1] = { math.cos(i * 4 * math.pi / 5), math.sin(i * 4 * math.pi / 5), 0 } end
    local many = {}
    for i = 1, 65 do many[i] = { math.cos(i * math.pi / 33), math.sin(i * math.pi / 33), 0 } end
    local bad = {
      ["it is not planar"] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0.1 }, { 0, 1, 0 } },
      ["it has no area"] = { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 2, 2 } },
      ["it is not convex"] = { { 0, 0, 0 }, { 2, 0, 0 }, { 0.5, 0.5, 0 }, { 0, 2, 0 } },
      ["it crosses itself"] = star,
      ["it: 3 to 64 vertices expected, got 65"] = many,
      ["it is beyond 1e%+15"] = { { 0, 0, 0 }, { 1e16, 0, 0 }, { 0, 1, 0 } },
      ["vertices must be three or more points"] = { { 0, 0, 0 }, { 1, 0, 0 } },
      ["vertices must be three or more points {x, y, z}"] = { { 0, 0, 0 }, { 1, nan, 0 }, { 0, 1, 0 } },
    }
    for wanted, vertices in pairs(bad) do
      local ok, message = pcall(ylm.polygon_light, { vertices = vertices })
      assert(not ok and tostring(message):find(wanted), wanted .. " <> " .. tostring(message))
    end
    -- a bow tie has no consistent turn, and a polygon may repeat a vertex
    assert.is_false((pcall(ylm.polygon_light, { vertices = { { 0, 0, 0 }, { 1, 1, 0 }, { 1, 0, 0 }, { 0, 1, 0 } } })))
    assert(ylm.polygon_light { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } } })
  end)
end)

describe("ylm.disk_light", function()
  it("seen along its axis is a cap", function()
    for _, d in ipairs { 1e-3, 0.1, 2, 30, 1e3, 1e6 } do
      for _, lmax in ipairs { 4, 40 } do
        local light = ylm.disk_light { at = { 0, 0, d }, normal = { 0, 0, -3 }, radius = 0.7 }
        local L = field(lmax, light, ylm.array({ { 0, 0, 0 } }, "double"), 0)
        local cap = ylm.sh.cap(lmax, { 0, 0, 1 }, math.atan(0.7 / d))
        assert(relative(L, cap) < 1e-13, relative(L, cap))
      end
    end
  end)

  it("is what regular polygons inside and outside of it tend to", function()
    local x, n = { 0.4, 0.3, -0.2 }, 64
    local L = derivatives(6, ylm.disk_light { at = { 0, 0, 1 }, normal = { 0, 0, 1 }, radius = 0.8 }, x)
    local function ring(r)
      local v = {}
      for i = 1, n do v[i] = { r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n), 1 } end
      return derivatives(6, ylm.polygon_light { vertices = v }, x)
    end
    local inner, outer = ring(0.8), ring(0.8 / math.cos(math.pi / n))
    assert(inner[1][1] < L[1][1] and L[1][1] < outer[1][1])
    for k = 1, 49 do -- areas of n-gons are off by 1/3 and 2/3 of their difference, to fourth order in 1/n
      assert.is_near((2 * outer[1][k] + inner[1][k]) / 3, L[1][k], 1e-5)
      for q = 1, 6 do assert.is_near((2 * outer[3][k][q] + inner[3][k][q]) / 3, L[3][k][q], 1e-3) end
    end
  end)

  it("cut in two by horizons is the sum of its halves, values and derivatives", function()
    for _, d in ipairs { 1, 0.1, 1e-3 } do
      local at = { at = { 0.2, d, 0 }, normal = { 0.1, 1, 0.3 }, radius = 0.7 }
      local parts = {}
      for i, up in ipairs { { 1, 0.2, 0.3 }, { -1, -0.2, -0.3 } } do
        parts[i] = derivatives(8, ylm.disk_light { at = at.at, normal = at.normal, radius = at.radius, horizon = up },
          { 0, 0, 0 })
      end
      local whole = derivatives(8, ylm.disk_light(at), { 0, 0, 0 })
      for k = 1, 81 do
        assert.is_near(whole[1][k], parts[1][1][k] + parts[2][1][k], 1e-13)
        for a = 1, 3 do assert.is_near(whole[2][k][a], parts[1][2][k][a] + parts[2][2][k][a], 1e-12 / d) end
        for q = 1, 6 do assert.is_near(whole[3][k][q], parts[1][3][k][q] + parts[2][3][k][q], 1e-12 / d ^ 2) end
      end
    end
  end)

  describe("has gradients and Hessians that are the derivatives of what they derive, to 1e-8", function()
    local cases = {
      { "on its axis", { 0, 0, 0 }, 5e-3 }, { "beside it", { 0.4, 0.2, 0.3 }, 5e-3 },
      { "close to its face", { 0.1, 1.9, 0.3 }, 1e-3 }, { "close to its rim", { 0.7, 1.99, 0 }, 8e-5 },
      { "closest to its rim", { 0.7, 1.9999, 0 }, 8e-7 }, { "far off", { 30, -100, 20 }, 0.5 },
      { "at lmax 30", { 0.4, 0.2, 0.3 }, 1e-3, 30 }, { "farther off", { 3e3, -1e4, 2e3 }, 50 },
      { "cut by a horizon", { 0.1, 0.2, 0.3 }, 4e-3, 4, { 0.5, 0.1, 0.2 } },
    }
    for _, case in ipairs(cases) do
      it(case[1], function()
        local light = ylm.disk_light { at = { 0, 2, 0 }, normal = { 0, 1, 0 }, radius = 0.7, horizon = case[5] }
        local g, h = against_differences(case[4] or 4, light, case[2], case[3])
        assert(g < 1e-8 and h < 1e-8, ("gradient %.1e, Hessian %.1e"):format(g, h))
      end)
    end
  end)

  it("marks points on it", function()
    local light = ylm.disk_light { at = { 0, 2, 0 }, normal = { 0, 1, 0 }, radius = 0.5 }
    local _, _, _, report = ylm.light_field(1, light, { { 0, 2, 0 }, { 0.3, 2, 0.3 }, { 0.6, 2, 0 }, { 0, 1, 0 } })
    assert.same({ 1, 1, 0, 0 }, report.inside:totable())
  end)
end)
