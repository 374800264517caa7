local ylm = require "ylm"

local long = require "spec.support.long"
local randoms = require "spec.support.random"
local relative = require "spec.support.vectors".relative

local sqrt, pi = math.sqrt, math.pi
local ONE = sqrt(4 * pi)

local seed = tonumber(os.getenv "YLM_SEED") or 20261124
local random = randoms.from(seed % 65521 + 1)

--- n places at a distance from the origin.
local function around(n, near, far) return randoms.around(random, n, near, far) end

local function field(lmax, object, points, derivatives, threads)
  return ylm.light_field(lmax, object, points, { derivatives = derivatives or 0, channels = "luminance", dtype = "double",
    threads = threads, metric = derivatives and "luminance" or nil })
end

--- 1 less V, as rows.
local function hidden(V)
  local rows = {}
  for i, p in ipairs(V:totable()) do
    rows[i] = p[1]
    rows[i][1] = rows[i][1] - ONE
  end
  return ylm.array(rows, "double")
end

--- The mesh of several boxes, each { centre, scale }.
local function boxes(list)
  local corners, triangles = {}, {}
  for _, b in ipairs(list) do
    local mesh = ylm.box({ at = b[1], scale = b[2] }).mesh
    local first = #corners
    for _, p in ipairs(mesh:vertices():totable()) do corners[#corners + 1] = p end
    for _, t in ipairs(mesh:triangles():totable()) do
      triangles[#triangles + 1] = { t[1] + first, t[2] + first, t[3] + first }
    end
  end
  return ylm.mesh { vertices = corners, triangles = triangles }
end

local found, first = pcall(ylm.occluder, { geometry = ylm.box {}, rays = 4 })

describe("ylm.occluder by rays", function()
  if not found or not first then
    pending "no Embree"
    return
  end

  it("is the exact body: values and gradients, errors fall as the square of the rays", function()
    local exact = ylm.occluder { geometry = ylm.box {} }
    for _, range in ipairs { { 0.9, 1.2 }, { 1.3, 2.4 }, { 8, 10 } } do
      local points = around(12, range[1], range[2])
      local V, dV, _, known = field(9, exact, points, 1)
      local errors = {}
      for rays, most in pairs { [16] = { 0.012, 0.04 }, [64] = { 6e-4, 2e-3 } } do
        local body = ylm.occluder { geometry = ylm.box {}, rays = rays }
        local v, dv, _, report = field(9, body, points, 1)
        local e, d = relative(hidden(v), hidden(V)), relative(dv, dV)
        assert(e < most[1] and d < most[2], ("%d rays at %g: %g, %g, seed %g"):format(rays, range[1], e, d, seed))
        errors[rays] = e
        for i = 1, #points do
          local ratio = report.lambda[i] / known.lambda[i]
          assert(ratio > 0.6 and ratio < 1.6, ("lambda %g, seed %g"):format(ratio, seed))
          assert.is_near(known.norm[i], report.norm[i], 0.01)
        end
        assert.is_near(1.5, body.area, 0.01)
        assert.is_near(0.75 ^ 0.5, body.radius, 1e-6)
        assert.equal(rays, body.rays)
      end
      assert(errors[16] > 6 * errors[64], ("at %g: %g, %g, seed %g"):format(range[1], errors[16], errors[64], seed))
    end
  end)

  it("takes bodies of several parts, and bodies with holes", function()
    local a, b = { { -2, 0, 0 }, 0.6 }, { { 2, 0.2, 0 }, 0.8 }
    local both = ylm.occluder { geometry = boxes { a, b }, rays = 64 }
    local points = around(8, 0, 0.4)
    local V, dV = field(6, both, points, 1)
    local A, dA = field(6, ylm.occluder { geometry = boxes { a } }, points, 1)
    local B, dB = field(6, ylm.occluder { geometry = boxes { b } }, points, 1)
    assert(relative(hidden(V), hidden(A) + hidden(B)) < 2e-3, "seed " .. seed)
    assert(relative(dV, dA + dB) < 5e-3, "seed " .. seed)
    -- through a ring light passes; behind its tube none does
    local ring = ylm.occluder { geometry = ylm.torus { radius = 1, tube = 0.25 }, rays = 32 }
    local open = field(0, ring, { { 0, 0, 0 } }):totable()[1][1][1] / ONE
    assert(open > 0.7 and open < 0.8, tostring(open))
  end)

  it("has gradients of bodies that are not convex", function()
    local ring = ylm.occluder { geometry = ylm.torus { radius = 1, tube = 0.3 }, rays = 128 }
    local points, h = around(4, 1.6, 2.5), 0.02
    local _, dV = field(4, ring, points, 1)
    for axis = 1, 3 do
      local up, down, d = {}, {}, {}
      for i, p in ipairs(points) do
        up[i], down[i] = { p[1], p[2], p[3] }, { p[1], p[2], p[3] }
        up[i][axis], down[i][axis] = p[axis] + h, p[axis] - h
        d[i] = {}
        for k, x in ipairs(dV:totable()[i][1]) do d[i][k] = x[axis] end
      end
      local expected = (hidden(field(4, ring, up)) - hidden(field(4, ring, down))) * (0.5 / h)
      local e = relative(ylm.array(d, "double"), expected)
      assert(e < 0.03, ("%g, seed %g"):format(e, seed))
    end
  end)

  it("knows its noise: errors are about as large", function()
    local body, exact = ylm.occluder { geometry = ylm.box {}, rays = 16 }, ylm.occluder { geometry = ylm.box {} }
    local points = around(40, 0.95, 2)
    local noise, most = body:noise(9), 0
    local V, W = field(9, body, points):totable(), field(9, exact, points):totable()
    for i = 1, 40 do
      local square = 0
      for k = 1, 100 do square = square + (V[i][1][k] - W[i][1][k]) ^ 2 end
      most = math.max(most, sqrt(square) / ONE)
    end
    assert(noise > most / 3 and noise < 3 * most, ("%g, %g, seed %g"):format(noise, most, seed))
    assert.equal(0, exact:noise(9))
  end)

  it("is dark inside, whichever way its triangles turn, and the same whatever the threads", function()
    local mesh = ylm.torus({ radius = 1, tube = 0.4, divide = { 24, 12 } }).mesh
    local turned = {}
    for i, t in ipairs(mesh:triangles():totable()) do turned[i] = { t[1], t[3], t[2] } end
    local points = { { 1, 0, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, { 0, 1, 0.1 }, { 0, -1, 0 }, { 0, 0, 2 } }
    for _, geometry in ipairs { mesh, ylm.mesh { vertices = mesh:vertices(), triangles = turned } } do
      local body = ylm.occluder { geometry = geometry, rays = 12 }
      local V, dV, _, report = field(3, body, points, 1)
      local dark, sum = report.inside:totable(), 0
      for i, v in ipairs(V:totable()) do
        if dark[i] == 1 then
          sum = sum + 1
          for k = 1, 16 do assert.equal(0, v[1][k]) end
          assert.equal(0, report.lambda[i])
        end
      end
      assert.same({ 1, 0, 0, 1, 1, 0 }, dark)
      assert.equal(3, sum)
      local again = field(3, body, points, 0, 3)
      assert.same(V:totable(), again:totable())
      assert.same(dV:totable(), (select(2, field(3, body, points, 1, 1))):totable())
    end
  end)

  it("is baked: a tolerance above the noise is met, and casters take the grid", function()
    local body = ylm.occluder { geometry = boxes { { { 0, 0, 0 }, { 1, 0.5, 1 } }, { { 0.25, 0.375, 0 }, { 0.5, 0.5, 1 } } },
      rays = long(12, 32), near = 0.25 }
    local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = 2, depth = 8, tolerance = 0.08, channels = "luminance" }, body))
    assert.is_true(grid.stats.met)
    assert.equal("visibility", grid.quantity)
    assert.is_near(body.radius, grid.body.radius, 1e-6)
    local points = around(20, 1.2, 6)
    local V = field(2, grid, points)
    assert(relative(V, field(2, body, points)) < 0.08)
    local c = ylm.visibility(2, ylm.caster { hides = grid, at = { 0, 0, 1 } }, { { 0, 0, -1 } })
    assert(c:get(1, 1) < 0.99 * ONE)
  end)
end)

describe("ylm.shadowed beside the path tracer", function()
  if not long(false, found and first) then return end

  it("has the floor under eight cubes within 1, 0.3 and 0.15 % of the light without them, at n = 5, 10 and 15", function()
    local next = randoms.from(7) -- the cubes of examples/17_shadow_fields.lua
    local at, turn, scale, places, normals = {}, {}, {}, {}, {}
    for i = 1, 8 do
      local phi, r = 2 * pi * i / 8, 0.6 + 1.4 * next()
      at[i] = { r * math.cos(phi), r * math.sin(phi), 0.7 + 0.9 * next() }
      turn[i] = { next() - 0.5, next() - 0.5, next() - 0.5, next() - 0.5 }
      scale[i] = 0.35 + 0.3 * next()
    end
    for i = 1, 48 do places[i], normals[i] = { 4 * next() - 2, 4 * next() - 2, 0 }, { 0, 0, 1 } end
    local smooth = { ONE, 0.3, 0.5, -0.4, 0.2, 0.1, -0.2, 0.15, 0.1 }
    local open = ylm.sh.irradiance(ylm.array(smooth), { 0, 0, 1 })
    local function shaded(lmax)
      local sky = ylm.environment_light { coefficients = ylm.sh.resize(smooth, lmax) }
      return ylm.shadowed { lights = sky, casters = ylm.casters { hides = ylm.occluder { geometry = ylm.box {} },
        surface = ylm.box {}, at = at, rotation = turn, scale = scale } }, sky
    end
    local shade, sky = shaded(2)
    local E, variance = ylm.scene "cubes" { geometry = { shade:surfaces() }, lights = { sky } }:probe { points = places,
      normals = normals, reflections = { 0, 0 }, samples = 2 ^ 17 }
    local noise = sqrt(variance:mean()) / open
    assert(noise < 1e-3, noise) -- below all bounds
    for lmax, bound in pairs { [4] = 0.01, [9] = 0.003, [14] = 0.0015 } do
      local L, sum = field(lmax, (shaded(lmax)), places):totable(), 0
      for i = 1, 48 do sum = sum + ((ylm.sh.irradiance(L[i][1], { 0, 0, 1 }) - E:get(i, 1)) / open) ^ 2 end
      local rms = sqrt(sum / 48)
      assert(rms < bound, ("lmax %d: %g, noise %g"):format(lmax, rms, noise))
    end
  end)
end)

describe("sums of shadowed light", function()
  it("is the picture of its coefficients at every shading point, behind casters", function()
    local lamp = ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.3, radiance = 50 }
    local scene = ylm.scene "one lamp" {
      camera = ylm.camera { from = { 0, 3, 4 } },
      geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
      lights = { lamp },
    }
    local function behind(casters) return ylm.shadowed { lights = lamp, casters = casters } end
    local shade = behind { ylm.caster { hides = ylm.occluder { radius = 0.4 }, at = { 0, 1, 0 } } }
    local size = { 32, 18 }
    local plain = scene:render { by = "sum", size = size, samples = 2 }
    local same = scene:render { by = "sum", size = size, samples = 2, lights = behind {} }
    assert.equal(0, plain:compare(same).mse)
    local dark = scene:render { by = "sum", size = size, samples = 2, lights = shade }
    assert.is_true(plain:compare(dark).mse > 1e-4)
    local each = scene:render { size = size, samples = 2, grid = shade, visibility = "transfer" }
    assert.equal(0, dark:compare(each).mse)
  end)
end)
