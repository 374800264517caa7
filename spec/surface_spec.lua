-- Where light arrives at surfaces and where rays start: at the point itself, and off its own triangle by that triangle's
-- rounding. Nothing else in the scene changes it. `make check-long` has more places, sizes and directions.

local long = require "spec.support.long"
local with = require "spec.support.with"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local pi = math.pi
local one = { size = { 1, 1 } }

--- v turned about an axis, degrees, and moved.
local turned = { axis = { 1, 2, -0.7 }, angle = 37 }
local function turn(v, by, at)
  local a, x, y, z = math.rad(by.angle), by.axis[1], by.axis[2], by.axis[3]
  local length = math.sqrt(x * x + y * y + z * z)
  x, y, z = x / length, y / length, z / length
  local c, s, d = math.cos(a), math.sin(a), x * v[1] + y * v[2] + z * v[3]
  local p = { v[1] * c + (y * v[3] - z * v[2]) * s, v[2] * c + (z * v[1] - x * v[3]) * s, v[3] * c + (x * v[2] - y * v[1]) * s }
  for k, axis in ipairs { x, y, z } do p[k] = p[k] + axis * d * (1 - c) + (at and at[k] or 0) end
  return p
end

--- How many of the first n numbers are not 0.
local function lit(n, get)
  local count = 0
  for i = 1, n do if get(i) ~= 0 then count = count + 1 end end
  return count
end

describe("light at a surface", function()
  --- A lamp 0.05 above a floor of this width, and something small at this distance.
  local function scene(width, far)
    return ylm.scene "near" {
      camera = ylm.camera { from = { 0.01, 0.03, 0 }, at = { 0.01, 0, 0 }, up = { 1, 0, 0 }, fov = 0.01 },
      geometry = {
        ylm.quad { corner = { -width / 2, 0, width / 2 }, u = { width, 0, 0 }, v = { 0, 0, -width },
          material = ylm.matte { albedo = 1 } },
        ylm.box { bounds = { { far, 0, 0 }, { far + 1e-3, 1e-3, 1e-3 } } },
      },
      lights = { ylm.sphere_light { at = { 0, 0.05, 0 }, radius = 0.005, radiance = 1 } },
    }
  end
  --- The irradiance at x, 0, z.
  local function truth(x, z) return pi * 0.005 ^ 2 * 0.05 / (x * x + 0.05 ^ 2 + z * z) ^ 1.5 end

  local measures = {
    ["the path tracer at points"] = function(s)
      return (s:probe { points = { { 0.01, 0, 0 } }, normals = { { 0, 1, 0 } }, samples = 1024, bounces = 0,
        strategy = "lights" }:get(1, 1))
    end,
    ["the path tracer's picture"] = function(s)
      return pi * s:pathtrace(with(one, { samples = 512, bounces = 0, strategy = "lights" })):layer "radiance":get(1, 1, 1)
    end,
    ["the picture by rays"] = function(s)
      return pi * s:render(ways.rays(with(one, { samples = 1, light_samples = 64 }))):layer "radiance":get(1, 1, 1)
    end,
    ["the lightmap"] = function(s, width)
      if width > 1 then return truth(0.01, 0) end
      local E = s:links({ spacing = 0.1, rays = 8 }):radiosity(nil, { bounces = 0 }):lightmap { mesh = 1, size = { 20, 20 },
        rays = 8, light_samples = 64 }
      return E:layer "irradiance":get(10, 12, 1) * truth(0.01, 0) / truth(0.015, 0.005)
    end,
  }
  for way, measure in pairs(measures) do
    it("is 0.1 % of the closed form for a lamp 0.05 above a floor, whatever is 20, 100 or 500 away: " .. way, function()
      for _, width in ipairs { 0.2, 1000 } do
        for _, far in ipairs { 20, 100, 500 } do
          local off = measure(scene(width, far), width) / truth(0.01, 0) - 1
          assert.is_true(math.abs(off) < 1e-3, ("floor %g, thing at %g: off by %.2g"):format(width, far, off))
        end
      end
    end)
  end

  it("is found by rays that the material chooses as by those to lamps, close to a large floor", function()
    local at = { points = { { 0.01, 0, 0 } }, normals = { { 0, 1, 0 } }, bounces = 0 }
    local s = ylm.scene "close" {
      geometry = scene(1000, 500).geometry,
      lights = { ylm.sphere_light { at = { 0, 0.05, 0 }, radius = 0.04, radiance = 1 } },
    }
    local E, v = {}, {}
    for i, strategy in ipairs { "lights", "material", "both" } do
      E[i], v[i] = s:probe(with(at, { strategy = strategy, samples = long(16384, 524288), seed = i }))
    end
    for i = 2, 3 do
      local error = math.sqrt(v[i]:get(1, 1) + v[1]:get(1, 1))
      local off = math.abs(E[i]:get(1, 1) - E[1]:get(1, 1))
      assert.is_true(error < 0.01 * E[1]:get(1, 1) and off < 4 * error, ("%.3g of it, %.1f errors"):format(off / E[1]:get(1, 1),
        off / error))
    end
  end)
end)

describe("links of a scene", function()
  it("count a fifth between squares of 0.1 and 0.01 at right angles, to 2e-4, with a box 50 away", function()
    for _, e in ipairs { 0.1, 0.01 } do
      local t = ylm.scene "squares" {
        geometry = {
          ylm.quad { corner = { 0, 0, 0 }, u = { e, 0, 0 }, v = { 0, 0, -e }, sides = "front" },
          ylm.quad { corner = { 0, 0, -e }, u = { e, 0, 0 }, v = { 0, e, 0 }, sides = "front" },
          ylm.box { at = { 50, 0, 0 }, scale = 0.01 * e },
        },
      }:links { spacing = e / 8, rays = long(512, 4096), lmax = 0 }
      local elements, links, of, n, squares = t:elements(), t:hits(), {}, 0, 0
      for i = 1, #elements.area do of[i] = elements.mesh:get(i) end
      for i = 1, #of do
        squares = squares + (of[i] <= 2 and 1 or 0)
        for k = 1, of[i] <= 2 and links.shape[2] or 0 do n = n + (of[links:get(i, k)] == 3 - of[i] and 1 or 0) end
      end
      local part = n / squares / links.shape[2]
      assert.is_true(math.abs(part - 0.20004) < 2e-4, ("side %g: %.5f"):format(e, part))
    end
  end)
end)

describe("a closed box", function()
  local size = { 1, 0.5, 0.3 }
  --- The box under a white sky, moved and turned, seen from its middle towards a corner.
  local function box(far, by)
    local at = { far, 0.7 * far, -0.3 * far }
    return ylm.scene "shut" {
      camera = ylm.camera { from = at, at = turn({ 0.5 * size[1], -0.5 * size[2], 0.5 * size[3] }, by, at), fov = 90 },
      geometry = { ylm.box { bounds = { { -0.5 * size[1], -0.5 * size[2], -0.5 * size[3] },
        { 0.5 * size[1], 0.5 * size[2], 0.5 * size[3] } }, rotate = by, at = at, material = ylm.matte { albedo = 1 } } },
      lights = { ylm.environment_light { radiance = 1 }, ylm.sphere_light { at = { far, 3 + far, -0.3 * far }, radius = 0.3,
        radiance = 1e6 } },
    }, at
  end
  --- Points on the floor, `gap` off its edges and corners, and their normals.
  local function edges(gap, by, at, n)
    local points, normals = {}, {}
    for i = 1, n do
      local t, wall = (i * 0.618034) % 1 - 0.5, 0.5 - gap
      local p = i % 5 == 0 and { wall, -0.5, -wall } or i % 2 == 0 and { wall, -0.5, t } or { t, -0.5, wall }
      points[i] = turn({ p[1] * size[1], p[2] * size[2], p[3] * size[3] }, by, at)
      normals[i] = turn({ 0, 1, 0 }, by)
    end
    return points, normals
  end
  local straight = { axis = { 0, 1, 0 }, angle = 0 }

  it("is dark in its edges and corners, near and far from the origin, after any number of bounces", function()
    for _, by in ipairs { straight, turned } do
      for _, far in ipairs(long({ 0, 1000 }, { 0, 10, 1000 })) do
        local s, at = box(far, by)
        for _, gap in ipairs(long({ 0, 1e-6, 1e-3 }, { 0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3 })) do
          local points, normals = edges(gap, by, at, long(25, 400))
          local E = s:probe { points = points, normals = normals, samples = long(16, 256), bounces = 4 }
          assert.equal(0, lit(#points, function(i) return E:get(i, 1) end), ("%g away, gap %g"):format(far, gap))
        end
        local picture = s:pathtrace { size = { 32, 32 }, samples = long(8, 256), bounces = 16 }:layer "radiance"
        assert.equal(0, lit(1024, function(i) return picture:get(1 + math.floor((i - 1) / 32), 1 + (i - 1) % 32, 1) end))
      end
    end
  end)
end)

describe("a surface", function()
  local shapes = {
    sphere = function(k, more) return ylm.sphere(with({ radius = k, divide = { 48, 24 } }, more)) end,
    plane = function(k, more)
      return ylm.quad(with({ corner = { -k, 0, k }, u = { 2 * k, 0, 0 }, v = { 0, 0, -2 * k }, divide = 3 }, more))
    end,
    slivers = function(k, more)
      local vertices, triangles = { { 0, 0, 0 } }, {}
      for i = 1, 300 do
        vertices[i + 1] = { k * math.sin(i * pi / 150), 0, k * math.cos(i * pi / 150) }
        triangles[i] = { 1, i + 1, i % 300 + 2 }
      end
      return ylm.mesh(with({ vertices = vertices, triangles = triangles }, more))
    end,
  }
  it("does not shade itself, from sizes of 1e-4 to 1e4, up to 1,000 of its sizes away, under a low lamp", function()
    for name, shape in pairs(shapes) do
      for _, k in ipairs(long({ 1e-4, 1e4 }, { 1e-4, 0.01, 1, 100, 1e4 })) do
        for _, far in ipairs { 0, 1000 } do
          for height = long(far > 0 and 2 or 1, 1), 2 do
            local at = { far * k, 0.3 * far * k, -0.7 * far * k }
            local up = height == 1 and { 0.1, 1, 0.2 } or { 1, 0.02, 0.3 }
            local s = ylm.scene "lit" {
              camera = ylm.camera { from = { at[1] + 0.1 * k, at[2] + 4 * k, at[3] + 0.3 * k }, at = at, fov = 35,
                up = { 1, 0, 0 } },
              geometry = { shape(k, { at = at, rotate = { axis = { 1, 0.3, 0.2 }, angle = 1 } }) },
              lights = { ylm.sun_light { direction = up, angle = 0.1, irradiance = 1 } },
            }
            local size = { 32, 32 }
            local a = s:render({ bounces = 0, size = size, samples = 1, light_samples = 2 }):layer "radiance"
            local b = s:render({ by = "rays", bounces = 0, size = size, samples = 1, light_samples = 2,
              visibility = "none" }):layer "radiance"
            assert.is_true(b:get(16, 16, 1) > 0)
            assert.equal(0, lit(32 * 32, function(i)
              local y, x = 1 + math.floor((i - 1) / 32), 1 + (i - 1) % 32
              return a:get(y, x, 1) - b:get(y, x, 1)
            end), ("%s of size %g, %g away, lamp %d"):format(name, k, far, height))
          end
        end
      end
    end
  end)
end)
