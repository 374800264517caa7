-- The gathered field: light that surfaces send to points in space, with gradient and Hessian.

local ylm = require "ylm"
local scenes = require "ylm.c.scene"

local sqrt, pi = math.sqrt, math.pi

--- A room 2 x 2 x 2 with a sphere in it.
local function room(spacing, extra)
  local geometry = { ylm.box { scale = 2, sides = "back" },
    ylm.sphere { at = { 0.15, -0.1, -0.2 }, radius = 0.35, divide = { 32, 16 } } }
  for _, g in ipairs(extra or {}) do geometry[#geometry + 1] = g end
  local camera = ylm.camera { from = { 0.8, 0.8, 0.8 }, at = { 0, 0, 0 } }
  return ylm.scene "a room with a sphere" { geometry = geometry, camera = camera }:links { spacing = spacing, rays = 4 }
end

--- A radiosity whose elements send out radiance f(x, y, z, mesh) -> r, g, b.
local function glow(t, f)
  local lit = t:radiosity({}, { bounces = 0 })
  local e = t:elements()
  local E, albedo, centre, mesh = {}, e.albedo:totable(), e.centre:totable(), e.mesh:totable()
  for i, c in ipairs(centre) do
    local rgb = { f(c[1], c[2], c[3], mesh[i]) }
    for k = 1, 3 do rgb[k] = rgb[k] * pi / albedo[i][k] end
    E[i] = rgb
  end
  assert(scenes.radiosity_set(lit, ylm.array(E, "float")))
  assert(scenes.radiosity_solve(lit, 0, 1e-3, false, 1, nil))
  return lit
end

local function pattern(x, y, z, mesh)
  if mesh == 2 then return 0.2, 0.2, 0.2 end
  local p = 1 + 0.6 * math.sin(3 * x + 1) * math.cos(2.5 * y) + 0.5 * math.sin(4 * z + x)
  return p, 0.6 * p + (x > 0.99 and 0.4 * p or 0), 1.5 - p / 2
end

local patterned
local function the_room()
  patterned = patterned or glow(room(0.08), pattern)
  return patterned
end

local POINTS = { { -0.5, 0.4, 0.3 }, { 0.55, 0.5, 0.2 }, { -0.45, -0.5, 0.1 }, { 0.1, 0.4, 0.55 }, { -0.3, 0.1, -0.5 },
  { 0.6, -0.55, 0.45 }, { 0.1, 0.55, -0.4 }, { -0.6, -0.1, 0.55 } }

local function flat(a)
  local out = {}
  local function walk(x) if type(x) == "table" then for _, y in ipairs(x) do walk(y) end else out[#out + 1] = x end end
  walk(a:totable())
  return out
end

local function moved(points, axis, by)
  local out = {}
  for i, p in ipairs(points) do
    out[i] = { p[1], p[2], p[3] }
    out[i][axis] = p[axis] + by
  end
  return out
end

--- Norm of a - b relative to that of b.
local function apart(a, b)
  local d, n = 0, 0
  for i = 1, #b do d, n = d + (a[i] - b[i]) ^ 2, n + b[i] ^ 2 end
  return sqrt(d / n)
end

describe("radiosity:field", function()
  it("is uniform light, whose derivatives are exactly 0, where all surfaces are alike", function()
    local lit = glow(room(0.2), function() return 0.7, 0.5, 0.25 end)
    for _, derivatives in ipairs { "cells", "points" } do
      local L, dL, ddL, report = ylm.light_field(4, lit:field { rays = 768, derivatives = derivatives }, POINTS,
        { derivatives = 2, metric = "rgb" })
      for i = 1, #POINTS do
        assert.near(0.7 * sqrt(4 * pi), L:get(i, 1, 1), 1e-5)
        assert.near(0.25 * sqrt(4 * pi), L:get(i, 3, 1), 1e-5)
        for k = 2, 25 do assert.near(0, L:get(i, 1, k), 2e-4) end
        assert.equal(0, report.lambda:get(i))
      end
      for _, x in ipairs(flat(dL)) do assert.equal(0, x) end
      for _, x in ipairs(flat(ddL)) do assert.equal(0, x) end
    end
  end)

  it("is known in closed form in the middle of a globe: degree by degree for a lamp off it", function()
    local a, e, r, rho = 0.4, 10, 0.1, 0.5
    local scene = ylm.scene "globe" {
      geometry = { ylm.sphere { radius = 1, divide = { 96, 48 }, material = ylm.matte { albedo = rho } } },
      lights = ylm.sphere_light { at = { 0, 0, a }, radius = r, radiance = e },
    }
    local lit = scene:links({ spacing = 0.1, rays = 64 }):radiosity(nil, { light_samples = 8 })
    local L = ylm.light_field(3, lit, { 0, 0, 0 })
    local scale = rho * e * r * r
    for l = 0, 3 do
      local truth = scale * (l + 1) * a ^ l * sqrt(4 * pi / (2 * l + 1))
      if l == 0 then truth = truth + sqrt(4 * pi) * scale * rho / (1 - rho) end
      assert.near(truth, L:get(2, l * (l + 1) + 1), 0.015 * scale * sqrt(4 * pi))
      for m = 1, l do assert.near(0, L:get(2, l * (l + 1) + 1 + m), 0.01 * scale) end
    end
    local middle = scene:links({ spacing = 0.1, rays = 64 })
      :radiosity(ylm.sphere_light { at = { 0, 0, 0 }, radius = r, radiance = e }, { light_samples = 8 })
    local V, dV = ylm.light_field(2, middle, { 0, 0, 0 }, { derivatives = 1, channels = "luminance" })
    assert.near(2 * scale * sqrt(4 * pi), V:get(1, 1), 0.01 * scale)
    for _, x in ipairs(flat(dV)) do assert.near(0, x, 0.02 * V:get(1, 1)) end
  end)

  it("agrees with paths off the middle (z2)", function()
    local scene = ylm.scene "two bodies" {
      geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = { 0.6, 0.5, 0.4 } } },
        ylm.sphere { at = { 0.3, -0.4, 0 }, radius = 0.3, material = ylm.matte { albedo = 0.3 } } },
      lights = ylm.sphere_light { at = { -0.4, 0.3, 0.2 }, radius = 0.15, radiance = 10 },
    }
    local points = { { 0.1, 0.3, 0.4 }, { -0.5, -0.4, -0.3 } }
    local lit = scene:links({ spacing = 0.08, rays = 64 }):radiosity(nil, { light_samples = 16 })
    local L = flat(ylm.light_field(2, lit, points))
    local truth, variance = scene:probe { points = points, lmax = 2, samples = 2048, reflections = { 1, 30 } }
    local c, v, sum, n = flat(truth), flat(variance), 0, 0
    local norm = 0
    for i = 1, 27 do norm = norm + c[i] ^ 2 end
    for i = 1, #c do sum, n = sum + (L[i] - c[i]) ^ 2 / (v[i] + 5e-6 * norm), n + 1 end -- the field's own noise: 0.2 %
    assert(sum / n < 2, sum / n)
  end)

  it("has the gradient of its own values, and Hessians that follow their second differences", function()
    local lit, h, lmax = the_room(), 0.1, 2
    local count = (lmax + 1) ^ 2
    local o = { channels = "luminance", dtype = "double" }
    for _, case in ipairs { { "cells", 0.25 }, { "points", 0.35 } } do
      local field = lit:field { rays = 12288, derivatives = case[1], contrast = 0.1 }
      local L, dL, ddL = ylm.light_field(lmax, field, POINTS, { channels = "luminance", dtype = "double", derivatives = 2 })
      local here, gradient, hessian, dg, dh = flat(L), flat(dL), flat(ddL), {}, {}
      for axis = 1, 3 do
        local up, down = flat(ylm.light_field(lmax, field, moved(POINTS, axis, h), o)),
          flat(ylm.light_field(lmax, field, moved(POINTS, axis, -h), o))
        for i = 1, #here do
          dg[3 * (i - 1) + axis] = (up[i] - down[i]) / (2 * h)
          dh[3 * (i - 1) + axis] = (up[i] + down[i] - 2 * here[i]) / h ^ 2
        end
      end
      assert(#here == #POINTS * count)
      assert(apart(gradient, dg) < case[2], case[1] .. apart(gradient, dg))
      local ab, aa, bb = 0, 0, 0
      for i = 1, #here do
        for axis, place in ipairs { 1, 4, 6 } do
          local a, b = hessian[6 * (i - 1) + place], dh[3 * (i - 1) + axis]
          ab, aa, bb = ab + a * b, aa + a * a, bb + b * b
        end
      end
      assert(ab / sqrt(aa * bb) > 0.9, ab / sqrt(aa * bb))
    end
  end)

  it("is interpolated twice as well with its gradients, 0.4 apart", function()
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -0.85, 0.45, -0.85 }, { 0.75, 0.85, -0.05 } }, cells = { 4, 1, 2 },
      lmax = 2 }, function(p, lmax, channels) -- whose walls nobody knows: points with slopes
        local L, dL, _, report = ylm.light_field(lmax, the_room():field { rays = 6144 }, p, { derivatives = 1,
          metric = "luminance", channels = channels == 3 and "rgb" or "luminance" })
        return L, dL, report.lambda
      end)
    local points = {}
    for i = 0, 5 do for j = 0, 2 do points[#points + 1] = { -0.7 + 0.25 * i, 0.6 + 0.05 * j, -0.15 - 0.3 * j } end end
    local truth = flat(ylm.light_field(2, the_room():field { rays = 12288 }, points))
    local hermite, linear = apart(flat((grid:sample(points))), truth),
      apart(flat((grid:sample(points, { interpolation = "linear" }))), truth)
    assert(2 * hermite < linear, hermite .. " " .. linear)
  end)

  it("does not depend on threads, nor on which points are asked together", function()
    for _, derivatives in ipairs { "cells", "points" } do
      local field = the_room():field { rays = 1536, derivatives = derivatives }
      local function ask(points, threads)
        local L, dL, ddL = ylm.light_field(3, field, points, { derivatives = 2, threads = threads })
        return { flat(L), flat(dL), flat(ddL) }
      end
      local all = ask(POINTS, 1)
      assert.same(all, ask(POINTS, 2))
      assert.same(all, ask(POINTS, 7))
      local third = ask({ POINTS[3] }, 1)
      for k = 1, 3 do
        for i, x in ipairs(third[k]) do assert.equal(all[k][2 * #third[k] + i], x) end
      end
    end
  end)

  it("gives luminance, metric and types as other fields do", function()
    local field = the_room():field { rays = 768 }
    local L, dL, ddL, report = ylm.light_field(2, field, POINTS, { derivatives = 2, metric = "luminance", dtype = "double" })
    local Y, dY, ddY = ylm.light_field(2, field, POINTS, { derivatives = 2, channels = "luminance", dtype = "double" })
    local rgb = select(4, ylm.light_field(2, field, POINTS, { channels = "luminance", metric = "rgb" }))
    local weights = { 0.2126, 0.7152, 0.0722 }
    for i = 1, #POINTS do
      local norm, norm3 = 0, 0
      for k = 1, 9 do
        local y = 0
        for c = 1, 3 do
          y = y + weights[c] * L:get(i, c, k)
          norm3 = norm3 + L:get(i, c, k) ^ 2
        end
        assert.near(y, Y:get(i, 1, k), 1e-5)
        norm = norm + y * y
        for a = 1, 6 do
          local h = 0
          for c = 1, 3 do h = h + weights[c] * ddL:get(i, c, k, a) end
          assert.near(h, ddY:get(i, 1, k, a), 1e-3)
          if a < 4 then
            local g = 0
            for c = 1, 3 do g = g + weights[c] * dL:get(i, c, k, a) end
            assert.near(g, dY:get(i, 1, k, a), 1e-4)
          end
        end
      end
      assert.near(sqrt(norm), report.norm:get(i), 1e-4)
      assert.near(sqrt(norm3), rgb.norm:get(i), 1e-4)
      assert(rgb.lambda:get(i) > report.lambda:get(i) and report.lambda:get(i) > 0)
    end
    assert.near(L:get(2, 3, 4), ylm.light_field(2, field, POINTS):get(2, 3, 4), 1e-6)
  end)

  it("traces nothing for points that it remembers, whatever the light has become", function()
    local lit = glow(room(0.2), pattern)
    for _, derivatives in ipairs { "cells", "points" } do
      local field, plain = lit:field { rays = 768, remember = true, derivatives = derivatives },
        lit:field { rays = 768, derivatives = derivatives }
      local o = { derivatives = 2 }
      local before = flat(select(3, ylm.light_field(2, field, POINTS, o)))
      local rays = field.stats.rays
      assert(rays > 0 and field.stats.bytes > 8 * rays * 0.9)
      assert.same(before, flat(select(3, ylm.light_field(2, plain, POINTS, o))))
      assert.same(before, flat(select(3, ylm.light_field(2, field, POINTS, o))))
      assert.equal(rays, field.stats.rays)
      local L = ylm.light_field(0, field, POINTS):get(1, 2, 1)
      local E = lit:irradiance()
      for i = 1, E.shape[1] do for c = 1, 3 do E:set(i, c, 2 * E:get(i, c)) end end
      assert(scenes.radiosity_set(lit, E) and scenes.radiosity_solve(lit, 0, 1e-3, false, 1, nil))
      assert.near(2 * L, ylm.light_field(0, field, POINTS):get(1, 2, 1), 1e-5)
      assert.equal(rays, field.stats.rays)
    end
  end)

  it("says which points are in bodies", function()
    local field = the_room():field { rays = 768 }
    assert.equal(0, field:validity { 0.15, -0.1, -0.2 })
    assert.equal(1, field:validity { 0.7, 0.7, 0.7 })
    local report = select(4, ylm.light_field(1, field, { { 0.15, -0.1, -0.2 }, { 0.7, 0.7, 0.7 } }))
    assert.same({ 1, 0 }, report.inside:totable())
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -0.15, -0.4, -0.5 }, { 0.45, 0.2, 0.1 } }, cells = 2, lmax = 1 }, field)
    assert.equal(0, grid.stats.invalid) -- corners in the sphere are seen by no part
    assert(grid.stats.ghosts >= 7, grid.stats.ghosts)
  end)

  it("is baked to a tolerance that its own noise allows, else says how many rays would", function()
    local lit, bounds = the_room(), { { -0.8, 0.3, -0.8 }, { 0.8, 0.8, 0.8 } }
    local o = { occupied = {} }
    for i = 1, 24 do o.occupied[i] = { math.sin(7 * i) * 0.7, 0.55 + 0.2 * math.cos(5 * i), math.sin(3 * i) * 0.7 } end
    local function bake(tolerance, rays)
      return pcall(ylm.bake, ylm.adaptive_grid { bounds = bounds, lmax = 2, depth = 2, tolerance = tolerance },
        lit:field { rays = rays }, o)
    end
    local ok, message = bake(0.02, 768)
    local noise, rays = tostring(message):match(
      "bake: tolerance 0.02: the gathered light is known to ([%d.]+) %(rays = (%d+) would reach 0.02%)")
    assert(not ok and noise, message)
    assert(tonumber(noise) > 0.01 and tonumber(rays) > 768)
    assert(bake(0.02, tonumber(rays)))
    ok, message = bake(1e-4, 768)
    assert(not ok and message:find("rays = 49152, the most, would not reach 0.0001", 1, true), message)
    local grid = ylm.bake(ylm.adaptive_grid { bounds = bounds, lmax = 2, depth = 3, tolerance = 0.05 }, lit, o)
    assert(grid.stats.met and grid.stats.error <= 0.05 and grid.quantity == "indirect")
    local lamp, field = ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.05 }, lit:field { rays = 192 }
    for _, list in ipairs { { field, lamp }, { lamp, field } } do
      local both = ylm.bake(ylm.uniform_grid { bounds = bounds, cells = 1, lmax = 1 }, list)
      assert.equal("all", both.quantity)                           -- a picture adds no lamps to it
    end
  end)

  describe("of direct light", function()
    local floor = ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } }
    local lamps = { ylm.sphere_light { at = { 0.2, 1.5, 0 }, radius = 0.2, radiance = { 10, 8, 6 } },
      ylm.polygon_light { vertices = { { 1, 1, 1 }, { 1.4, 1, 1 }, { 1.4, 1.1, 1.4 }, { 1, 1.1, 1.4 } }, radiance = 5 },
      ylm.disk_light { at = { -1, 1, 0.5 }, normal = { 1, -1, 0 }, radius = 0.2, radiance = 8 },
      ylm.sun_light { direction = { 1, 2, 0.5 }, angle = 5, irradiance = { 2, 1, 1 } } }

    local function lit_scene(geometry, lights, o)
      local scene = ylm.scene "lamps" { geometry = geometry, lights = lights }
      local t = assert(scene:links { spacing = o and o.spacing or 0.5, rays = 4 })
      return assert(t:radiosity(nil, { bounces = 0, light_samples = 2 }))
    end

    it("is that of the lamps themselves, with gradients and Hessians, where nothing is in the way", function()
      local points = { { 0, 0, 0 }, { -0.5, 0.4, 0.8 } }
      local field = lit_scene({ floor }, lamps):field { quantity = "direct", rays = 192 }
      local o = { derivatives = 2, dtype = "double" }
      local ours, theirs = { ylm.light_field(4, field, points, o) }, { ylm.light_field(4, lamps, points, o) }
      for k = 1, 3 do assert(apart(flat(ours[k]), flat(theirs[k])) < 1e-5, k) end
      local Y, dY, ddY = ylm.light_field(4, field, points, { derivatives = 2, channels = "luminance" })
      local metric = select(4, ylm.light_field(4, field, points, { metric = "luminance" }))
      local own = { ylm.light_field(4, lamps, points, { derivatives = 2, channels = "luminance", metric = "luminance" }) }
      for k, x in ipairs { Y, dY, ddY } do assert(apart(flat(x), flat(own[k])) < 1e-5) end
      assert(apart(flat(metric.lambda), flat(own[4].lambda)) < 1e-5)
      assert.equal(3 * 2 * 5 * 4, field.stats.shadow_rays) -- 3 times 2 points, 5 lamps (2 triangles), 4 rays
    end)

    it("is exactly uniform under a uniform sky, and half of it over an endless floor", function()
      local sky = ylm.environment_light { radiance = { 1, 2, 3 } }
      local field = lit_scene({ ylm.quad { corner = { 40, 40, 40 }, u = { 1e-3, 0, 0 }, v = { 0, 1e-3, 0 } } }, sky)
        :field { quantity = "all", rays = 192 }
      local L, dL, ddL = ylm.light_field(4, field, { { 0.3, 0.2, -0.1 } }, { derivatives = 2 })
      assert.near(2 * sqrt(4 * pi), L:get(1, 2, 1), 1e-4)
      for _, x in ipairs(flat(dL)) do assert.equal(0, x) end
      for _, x in ipairs(flat(ddL)) do assert.equal(0, x) end
      local wide = lit_scene({ ylm.quad { corner = { -9e3, -1, 9e3 }, u = { 1.8e4, 0, 0 }, v = { 0, 0, -1.8e4 } } }, sky,
        { spacing = 1e3 }):field { quantity = "direct", rays = 768 }
      assert.near(sqrt(4 * pi) / 2, ylm.light_field(0, wide, { 0, 0, 0 }):get(1, 1), 0.01)
    end)

    it("has the shadows of paths, with and without bounces (z2)", function()
      local grey = ylm.matte { albedo = 0.6 }
      local geometry = { ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = grey },
        ylm.sphere { at = { 0.1, 0.8, 0 }, radius = 0.25, divide = { 48, 24 } } }
      local scene = ylm.scene "shadows" { geometry = geometry, lights = lamps }
      local lit = scene:links({ spacing = 0.1, rays = 32 }):radiosity()
      local points = { { 0, 0, 0 }, { 0.6, 0, 0.1 }, { -0.2, 0.2, -0.2 }, { 0.1, 0.8, 0.6 } }
      for parts, reflections in pairs { direct = { 0, 0 }, all = { 0, 20 } } do
        local field = lit:field { quantity = parts, rays = 3072 }
        local L = flat(ylm.light_field(1, field, points))
        local truth, variance = scene:probe { points = points, lmax = 1, samples = 1024, reflections = reflections }
        local c, v, sum, norm = flat(truth), flat(variance), 0, 0
        for i = 1, #c do norm = norm + c[i] ^ 2 / #points end
        for i = 1, #c do sum = sum + (L[i] - c[i]) ^ 2 / (v[i] + 4e-5 * norm) end -- 2 % over all coefficients
        assert(sum / #c < 1.5, parts .. sum / #c)
      end
    end)

    it("takes many lamps in groups, within the tolerance of their shadows", function()
      local many = {}
      for i = 1, 400 do
        many[i] = ylm.sphere_light { at = { math.sin(i) * 1.5, 1 + 0.3 * math.cos(7 * i), math.cos(3 * i) * 1.5 }, radius = 0.03,
          radiance = 20 }
      end
      local wall = ylm.quad { corner = { 0.3, -1, 2 }, u = { 0, 4, 0 }, v = { 0, 0, -4 } }
      local scene = ylm.scene "many" { geometry = { floor, wall }, lights = many }
      local field = scene:links({ spacing = 1, rays = 4 }):radiosity(nil, { light_samples = 1, bounces = 0 })
        :field { quantity = "direct", rays = 192, tolerance = 0.02 }
      local points = { { -0.5, 0, 0 }, { 0.8, 0.3, 0.2 } }
      local L = flat(ylm.light_field(2, field, points))
      for i, side in ipairs { -1, 1 } do -- a wall between the lamps on both sides
        local seen = {}
        for _, lamp in ipairs(many) do if (lamp.at[1] - 0.3) * side > 0.03 then seen[#seen + 1] = lamp end end
        local part, truth = {}, flat(ylm.light_field(2, seen, { points[i] }))
        for k = 1, 27 do part[k] = L[27 * (i - 1) + k] end
        assert(apart(part, truth) < 0.05, apart(part, truth))
      end
      assert(field.stats.shadow_rays <= 2 * 256)
    end)

    it("follows lights that change", function()
      local lit = lit_scene({ floor }, lamps[1])
      local field = lit:field { quantity = "direct", rays = 192 }
      local before = ylm.light_field(0, field, { 0, 0, 0 }):get(2, 1)
      lit:update(ylm.sphere_light { at = { 0.2, 1.5, 0 }, radius = 0.2, radiance = { 20, 16, 12 } })
      assert.near(2 * before, ylm.light_field(0, field, { 0, 0, 0 }):get(2, 1), 1e-5)
    end)
  end)

  describe("within the walls of a room, whose box is the grid's", function()
    local white = ylm.matte { albedo = 0.7 }
    local function wall(lo, hi) return ylm.box { bounds = { lo, hi }, material = white } end
    local function quad(corner, u, v) return ylm.quad { corner = corner, u = u, v = v, material = white } end
    local rooms = {
      ["thick walls"] = { wall({ -1.3, -0.3, -1.3 }, { 1.3, 0, 1.3 }), wall({ -1.3, 2, -1.3 }, { 1.3, 2.3, 1.3 }),
        wall({ -1.3, 0, -1.3 }, { 1.3, 2, -1 }), wall({ -1.3, 0, 1 }, { 1.3, 2, 1.3 }), wall({ -1.3, 0, -1 }, { -1, 2, 1 }),
        wall({ 1, 0, -1 }, { 1.3, 2, 1 }) },
      ["walls of one quad"] = { quad({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 0, 2 }), quad({ -1, 2, -1 }, { 2, 0, 0 }, { 0, 0, 2 }),
        quad({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }), quad({ -1, 0, 1 }, { 2, 0, 0 }, { 0, 2, 0 }),
        quad({ -1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }), quad({ 1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }) },
    }

    for name, geometry in pairs(rooms) do
      it("has the indirect light of pixels: " .. name, function()
        local scene = ylm.scene "a room" {
          camera = ylm.camera { from = { 0.7, 1, 0.7 }, at = { -1, 0.7, -1 }, fov = 70 }, geometry = geometry,
          lights = { ylm.sphere_light { at = { 0, 1.6, 0 }, radius = 0.1, radiance = 40 } },
          probes = name == "thick walls" and ylm.adaptive_grid { lmax = 0, tolerance = 0.8, depth = 2 }
            or ylm.uniform_grid { lmax = 1, cells = { 4, 4, 4 } },
          links = ylm.links { spacing = 0.4, rays = 32 },
        }
        local lit = scene:links({ spacing = 0.4, rays = 32 }):radiosity()
        local grid = scene:bake { quantity = "indirect", judge = "field" }
        assert.is_true(grid.kind == "uniform" or grid.stats.verified > 0)
        local function mean(indirect)
          local image = scene:render { size = { 16, 12 }, samples = 1, light_samples = 1, bounced = indirect,
            bounces = not indirect and 0 or nil, layers = false }
          local sum = 0
          for y = 1, 12 do for x = 1, 16 do sum = sum + image:layer "radiance":get(y, x, 2) end end
          return sum
        end
        local direct = mean(nil)
        assert.near(1, (mean(grid) - direct) / (mean(lit) - direct), 0.15)
      end)
    end

    it("is in one call what links, radiosity and field are", function()
      local scene = ylm.scene "a room" { geometry = ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
        lights = ylm.sphere_light { at = { 0, 0.3, 0 }, radius = 0.1, radiance = 10 },
        links = ylm.links { spacing = 0.3, rays = 64 } }
      local places = { { 0.3, 0.2, 0 }, { -0.4, -0.5, 0.6 } }
      local function at(field) return ylm.light_field(2, field, places):totable() end
      local links = scene:links { spacing = 0.3, rays = 64, lmax = 0 }
      local lit = links:radiosity(scene.lights, { bounces = 1 })
      local short = scene:field { quantity = "all", bounces = 2, rays = 768 }
      assert.same(at(lit:field { quantity = "all", rays = 768 }), at(short))
      assert.same(at(short), at(scene:field { quantity = "all", bounces = 2, rays = 768, links = links }))
      assert.equal(scene, short.scene)
      assert.same(at(scene.lights), at(scene:field()))
    end)
  end)
end)
