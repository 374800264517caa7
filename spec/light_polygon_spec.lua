-- Polygon lights: coefficients and derivatives, judged by reference vectors, solid angles and differences.

local ylm = require "ylm"
local known = require "spec.support.derivatives"
local field, derivatives, against_differences = known.field, known.at, known.errors
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
