local core = require "ylm.c.core"
local ylm = require "ylm"

local function relative(a, b)
  local _, difference, norm = core.array_distance(a, b)
  return difference / norm
end

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
      assert(relative(b[k + 1], a[k + 1]) < (k == 2 and 1e-5 or 1e-12), k)
    end
  end)

  it("has Hessians that are the derivative of its gradients, exact and approximated", function()
    for _, method in ipairs { "exact", "sphere" } do
      local light = ylm.polygon_light { vertices = triangle, method = method }
      local x, h = { 0.3, -0.4, 0.2 }, 1e-4
      local L, dL, ddL = field(4, light, x, 2)
      local plus, minus = {}, {}
      for a = 1, 3 do
        local p, q = { x[1], x[2], x[3] }, { x[1], x[2], x[3] }
        p[a], q[a] = p[a] + h, q[a] - h
        plus[a], minus[a] = { field(4, light, p, 1) }, { field(4, light, q, 1) }
      end
      local order = { { 1, 1 }, { 1, 2 }, { 1, 3 }, { 2, 2 }, { 2, 3 }, { 3, 3 } }
      for k = 1, 25 do
        for a = 1, 3 do
          assert.is_near((plus[a][1]:get(1, k) - minus[a][1]:get(1, k)) / (2 * h), dL:get(1, k, a), 1e-6)
        end
        for i, ab in ipairs(order) do
          assert.is_near((plus[ab[1]][2]:get(1, k, ab[2]) - minus[ab[1]][2]:get(1, k, ab[2])) / (2 * h),
            ddL:get(1, k, i), 2e-6)
        end
      end
      assert.equal(25, L.shape[2])
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
    local below = ylm.polygon_light { vertices = { { 1, -1, -2 }, { 1, 1, -2 }, { 1, 0, -1 } }, horizon = { 0, 0, 1 } }
    local nothing = field(3, below, x, 0)
    for k = 1, 16 do assert.equal(0, nothing:get(1, k)) end
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

  it("goes into scenes: baked, rendered and referenced; rays are refused in words", function()
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
    local ok, message = pcall(function() return scene:raycast { size = { 8, 8 }, samples = 1 } end)
    assert.is_false(ok)
    assert.matches("polygon and disk lights need bake or reference", message)
  end)

  it("marks points on it, and gives the field of half the sphere there", function()
    local light = ylm.polygon_light { vertices = { { -1, 0, -1 }, { 1, 0, -1 }, { 0, 0, 1 } } }
    local L, dL, _, report = ylm.light_field(2, light, { { 1, 0, -1 }, { 0, 1, 0 } }, { derivatives = 1,
      channels = "luminance" })
    assert.same({ 1, 0 }, report.inside:totable())
    assert.is_near(math.sqrt(math.pi), L:get(1, 1, 1), 1e-6)
    assert.equal(0, dL:get(1, 1, 1, 1))
  end)
end)

describe("ylm.disk_light", function()
  it("seen along its axis is a cap, but for the corners of its polygon", function()
    local light = ylm.disk_light { at = { 0, 0, 2 }, normal = { 0, 0, -3 }, radius = 0.7 }
    local L = field(4, light, { 0, 0, 0 }, 0)
    local cap = ylm.sh.cap(4, { 0, 0, 1 }, math.atan(0.35))
    assert(relative(L, cap) < 1e-3, relative(L, cap))
  end)
end)

describe("ylm.textured_light", function()
  it("makes a sphere of each texel, of its area and colour, row 1 at the top", function()
    local image = ylm.image { size = { 2, 2 }, layers = { { "radiance", 3 } } }
    core.array_fill(image:layer(), { { { 1, 0, 0 }, { 0, 2, 0 } }, { { 0, 0, 3 }, { 4, 4, 4 } } })
    local lights = ylm.textured_light { corner = { 0, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, image = image }
    assert.equal(4, lights.count)
    local at, radius, radiance = require("ylm.light").arrays(lights.lights)
    local seen = {}
    for i = 1, 4 do
      assert.is_near(math.sqrt(1 / math.pi), radius[i], 1e-15)
      seen[("%g %g"):format(at:get(i, 1), at:get(i, 2))] = { radiance:get(i, 1), radiance:get(i, 2), radiance:get(i,
        3) }
    end
    assert.same({ 1, 0, 0 }, seen["0.5 1.5"])
    assert.same({ 0, 2, 0 }, seen["1.5 1.5"])
    assert.same({ 0, 0, 3 }, seen["0.5 0.5"])
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
        tolerance = tolerance }
    end
    local merged = make(0.1)
    assert.equal(2, merged.count)
    assert(make(0).count > 16)
    local _, radius, radiance = require("ylm.light").arrays(merged.lights)
    local sum = 0
    for i = 1, 2 do sum = sum + math.pi * radius[i] ^ 2 * radiance:get(i, 1) end
    assert.is_near(2 * power, sum, 1e-6)
  end)
end)
