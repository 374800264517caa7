local by_kernels = require "spec.support.by_kernels"
local ways = require "spec.support.ways"
-- Transfer vectors, shading by light fields, and the ray-cast truth they are held against.
local ylm = require "ylm"
require "ylm.array"
local core = require "ylm.c.core"
local lib = require "ylm.c.scene"

local pi, sqrt = math.pi, math.sqrt

--- Records of spec/data/irradiance.txt: lights over plane elements.
local function records()
  local elements = {}
  for line in io.lines "spec/data/irradiance.txt" do
    local t = {}
    for word in line:gmatch "%S+" do t[#t + 1] = tonumber(word) or word end
    if t[1] == "E" then
      elements[#elements + 1] = { kind = t[2], x = { t[3], t[4], t[5] }, y = { t[6], t[7], t[8] }, r = t[9],
        n = { t[10], t[11], t[12] }, value = t[13], sh = { [2] = t[14], [4] = t[15], [8] = t[16] } }
    end
  end
  return elements
end

local function cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function unit(v)
  local d = sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
  return { v[1] / d, v[2] / d, v[3] / d }
end

local function along(p, d, t) return { p[1] + t * d[1], p[2] + t * d[2], p[3] + t * d[3] } end

--- A scene of one small white square at x with normal n, seen from straight above through one tiny pixel.
local function element(x, n, lights, more)
  local u = unit(cross(n, math.abs(n[1]) < 0.5 and { 1, 0, 0 } or { 0, 1, 0 }))
  local v = cross(n, u)
  local h = 1e-3
  local corner = along(along(x, u, -h / 2), v, -h / 2)
  local geometry = { ylm.quad { corner = corner, u = { u[1] * h, u[2] * h, u[3] * h },
    v = { v[1] * h, v[2] * h, v[3] * h }, material = ylm.matte { albedo = 1 } } }
  for _, g in ipairs(more or {}) do geometry[#geometry + 1] = g end
  return ylm.scene "element" {
    camera = ylm.camera { from = along(x, n, 0.01), at = x, up = u, fov = 0.01 },
    geometry = geometry, lights = lights,
  }
end

--- Radiance of the one pixel.
local function pixel(image)
  return (image:layer "radiance":get(1, 1, 1))
end

local one_pixel = { size = { 1, 1 }, samples = 1 }

local with = require "spec.support.with"

--- A lit floor with a box on it.
local function small_scene()
  return ylm.scene "small" {
    camera = ylm.camera { from = { 2, 3, 4 }, at = { 0, 0.3, 0 }, fov = 40 },
    geometry = {
      ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 16,
        material = ylm.matte { albedo = { 0.8, 0.6, 0.4 } } },
      ylm.sphere { at = { 0, 0.5, 0 }, radius = 0.5 },
    },
    lights = {
      ylm.sphere_light { at = { -0.9, 0.3, 0.8 }, radius = 0.1, radiance = { 40, 30, 18 } },
      ylm.sphere_light { at = { 1.2, 0.8, -0.4 }, radius = 0.2, radiance = { 10, 16, 30 } },
    },
  }
end

describe("the clamped cosine", function()
  it("is the transfer vector of a surface that nothing shadows: A Y(n)", function()
    local n = unit { 0.3, 0.8, -0.5 }
    local view = element({ 0, 0, 0 }, n, {}):prepare(with(one_pixel, { visibility = "none", lmax = 6 }))
    local Y, a = ylm.sh.eval(6, { n }), core.material_transfer("matte", 6)
    local wanted = ylm.zeros { 1, 49 }
    for l = 0, 6 do
      for m = -l, l do
        local i = ylm.sh.index(l, m)
        wanted:set(1, i, a:get(l + 1) * Y:get(1, i))
      end
    end
    assert.is_true(core.array_distance(view:transfer(), wanted) < 2e-6)
  end)
end)

describe("transfer vectors", function()
  --- Transfer of an element with normal z in the middle of `geometry`.
  local function transfer(geometry, options)
    local s = element({ 0, 0, 0 }, { 0, 0, 1 }, {}, geometry)
    local all = { lmax = 4, occlusion_distance = math.huge, visibility = "transfer" }
    return s:prepare(with(one_pixel, with(all, options or {}))):transfer()
  end

  --- A square wall at distance x, as wide and high as it takes.
  local function wall(x)
    return ylm.quad { corner = { x, -1e3, 0 }, u = { 0, 2e3, 0 }, v = { 0, 0, 1e3 } }
  end

  it("are exact where nothing occludes, whatever the number of rays", function()
    local exact = transfer({}, { visibility = "none" })
    assert.is_true(core.array_distance(transfer({}, { transfer_samples = 3 }), exact) < 1e-6)
  end)

  it("vanish inside of a closed box", function()
    local box = ylm.box { bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }
    local _, norm = core.array_distance(transfer { box }, ylm.zeros { 1, 25 })
    assert.equal(0, norm)
  end)

  it("lose half of the hemisphere behind a wall, as quadrature says", function()
    -- A wall at x = 0.002 as high as it is far away: it hides x > 0 but for a sliver.
    local exact, steps = ylm.zeros { 1, 25 }, 400
    local sums = {}
    for i = 1, 25 do sums[i] = 0 end
    local points, weights = {}, {}
    for i = 1, steps do
      local z = (i - 0.5) / steps
      for j = 1, steps do
        local phi = pi / 2 + (j - 0.5) / steps * pi -- x < 0
        local r = sqrt(1 - z * z)
        points[#points + 1] = { r * math.cos(phi), r * math.sin(phi), z }
        weights[#weights + 1] = z * pi / steps / steps
      end
    end
    local Y = ylm.sh.eval(4, points)
    for i = 1, #points, 97 do assert.is_true(points[i][1] <= 1e-9) end
    local flat = Y:totable()
    for i, row in ipairs(flat) do for k = 1, 25 do sums[k] = sums[k] + weights[i] * row[k] end end
    for k = 1, 25 do exact:set(1, k, sums[k]) end
    local far = core.array_distance(transfer({ wall(0.002) }, { transfer_samples = 65536 }), exact)
    assert.is_true(far < 2e-3, tostring(far))
    -- Few rays: unbiased enough that the mean of many seeds comes near.
    local mean = ylm.zeros { 1, 25 }
    for seed = 1, 200 do
      local T = transfer({ wall(0.002) }, { transfer_samples = 16, seed = seed })
      for k = 1, 25 do mean:set(1, k, mean:get(1, k) + T:get(1, k) / 200) end
    end
    far = core.array_distance(mean, exact)
    assert.is_true(far < 0.02, ("seeds 1 to 200: %g"):format(far))
  end)

  it("ignore what is farther than the occlusion distance, and what does not occlude", function()
    local open = transfer({}, { visibility = "none" })
    local box = { bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }
    assert.is_true(core.array_distance(transfer({ ylm.box(box) }, { occlusion_distance = 0.9 }), open) < 1e-6)
    assert.is_true(core.array_distance(transfer { ylm.box(with(box, { occludes = false })) }, open) < 1e-6)
  end)

  it("depend on the seed and not on the number of threads", function()
    local s = small_scene()
    local function view(threads, seed)
      return s:prepare { size = { 48, 27 }, samples = 5, threads = threads, seed = seed, transfer_samples = 16,
        visibility = "transfer" }
    end
    local one, many, other = view(1, 1), view(3, 1), view(1, 2)
    assert.equal(0, (core.array_distance(one:transfer(), many:transfer())))
    assert.equal(0, (core.array_distance(one:points().position, many:points().position)))
    local few, all = one:render { by = "sum", threads = 1 }, many:render { by = "sum", threads = 3 }
    assert.equal(0, (core.array_distance(few:layer(), all:layer())))
    assert.is_true(core.array_distance(one:render { by = "sum" }:layer(), other:render { by = "sum" }:layer()) > 0)
    local a, b = one:render { by = "rays", light_samples = 4, threads = 1 }, many:render { by = "rays", light_samples = 4,
      threads = 3 }
    assert.equal(0, (core.array_distance(a:layer(), b:layer())))
  end)
end)

describe("shading", function()
  it("gives the irradiance of spec/data/irradiance.txt at lmax 2, 4, 8, unshadowed", function()
    local elements = records()
    for i = 1, #elements do
      local e = elements[i]
      local lamp = ylm.sphere_light { at = e.y, radius = e.r, radiance = 1 }
      local s = element(e.x, e.n, { lamp })
      local scale = e.r ^ 2 / ((e.x[1] - e.y[1]) ^ 2 + (e.x[2] - e.y[2]) ^ 2 + (e.x[3] - e.y[3]) ^ 2) * pi
      for _, lmax in ipairs { 2, 4, 8 } do
        local image = s:render(ways.sum(with(one_pixel, { lmax = lmax, visibility = "none" })))
        local off = math.abs(pixel(image) * pi - e.sh[lmax]) / scale
        assert.is_true(off < 1e-4, ("record %d, lmax %d: off by %g"):format(i, lmax, off))
      end
    end
  end)

  it("is the same by any object with that light field, and in double", function()
    local s = small_scene()
    local view = s:prepare { size = { 32, 18 }, samples = 4, transfer_samples = 16, visibility = "transfer" }
    local truth = view:render { by = "sum" }
    local packed = require("ylm.light").pack(1, "spec", s.lights)
    assert.equal(0, (core.array_distance(view:render({ grid = packed }):layer(), truth:layer())))
    local _, off, norm = core.array_distance(truth:layer(), view:render({ by = "sum", dtype = "double" }):layer())
    assert.is_true(off < 1e-5 * norm, tostring(off / norm))
  end)

  it("by a grid comes near the reference as the grid gets finer, and says where a grid does not reach", function()
    local s = small_scene()
    local view = s:prepare { size = { 32, 18 }, samples = 4, transfer_samples = 16, visibility = "transfer" }
    local truth, last = view:render { by = "sum" }, math.huge
    for _, n in ipairs { 4, 8, 16 } do
      local grid = assert(s:bake { probes = ylm.uniform_grid { cells = n }, occupied = view })
      local image, report = view:render { grid = grid }
      assert.equal(0, report.outside)
      assert.equal(0, report.unbaked)
      local _, off = core.array_distance(image:layer(), truth:layer())
      assert.is_true(off < last / 2, ("%d cells: %g after %g"):format(n, off, last))
      last = off
    end
    local half = ylm.bake(ylm.uniform_grid { bounds = { { -3, -1, -3 }, { 0, 2, 3 } }, cells = 2 }, s.lights)
    local _, report = view:render { grid = half }
    assert.is_true(report.outside > 0 and report.outside < view.stats.points)
  end)

  --- A field of `count` coefficients that is cubic in one axis times linear in the others; gradients by hand.
  local function cubic_field(count)
    local rng = 7
    local function random()
      rng = rng * 16807 % 2147483647
      return rng / 2147483647 - 0.5
    end
    local terms = {}
    for k = 1, 3 * count do
      terms[k] = {}
      for t, e in ipairs { { 0, 0, 0 }, { 1, 1, 1 }, { 3, 0, 0 }, { 0, 3, 1 }, { 1, 0, 2 }, { 2, 1, 1 }, { 0, 0, 3 } } do
        terms[k][t] = { random(), e }
      end
    end
    local function power(x, n) return n == 0 and 1 or x ^ n end
    return function(points)
      local value, gradient = {}, {}
      for i, p in ipairs(points:totable()) do
        value[i], gradient[i] = {}, {}
        for c = 1, 3 do
          value[i][c], gradient[i][c] = {}, {}
          for k = 1, count do
            local sum, slope = 0, { 0, 0, 0 }
            for _, term in ipairs(terms[(c - 1) * count + k]) do
              local f = { power(p[1], term[2][1]), power(p[2], term[2][2]), power(p[3], term[2][3]) }
              sum = sum + term[1] * f[1] * f[2] * f[3]
              for a = 1, 3 do
                local n = term[2][a]
                if n > 0 then
                  slope[a] = slope[a] + term[1] * n * power(p[a], n - 1) * f[a % 3 + 1] * f[(a + 1) % 3 + 1]
                end
              end
            end
            value[i][c][k], gradient[i][c][k] = sum, slope
          end
        end
      end
      return ylm.array(value), ylm.array(gradient)
    end
  end

  it("by a grid is the reference where the field is one that Hermite interpolation represents: a cubic", function()
    local s, count = small_scene(), 9
    local cubic = cubic_field(count)
    local view = s:prepare { size = { 32, 18 }, samples = 4, transfer_samples = 16, visibility = "transfer", lmax = 2 }
    local box = { { -4, -2, -4 }, { 4, 4, 4 } }
    -- One voxel is the polynomial itself: asked as a light field, point by point, it gives the reference.
    local one = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 2, metric_channels = "none" }, cubic)
    local truth = lib.shade_field(view, one, "transfer", "double", 0, nil)
    -- .. which is also albedo/pi times transfer times the polynomial.
    local p, T = view:points(), view:transfer():totable()
    local exact, albedo, rows = cubic(p.position):totable(), p.albedo:totable(), {}
    for i = 1, #exact do
      rows[i] = {}
      for c = 1, 3 do
        local sum = 0
        for k = 1, count do sum = sum + T[i][k] * exact[i][c][k] end
        rows[i][c] = sum * albedo[i][c] / pi
      end
    end
    local function near(what, picture, limit)
      local _, off, norm = core.array_distance(picture, truth)
      assert.is_true(norm > 1 and off < limit * norm, ("%s: %g"):format(what, off / norm))
    end
    near("the polynomial", ylm.array(rows, "float"), 1e-5)
    for what, grid in pairs {
      ["one voxel"] = one,
      ["of the function"] = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 3, 4, 5 }, lmax = 2,
        metric_channels = "none" }, cubic),
      ["of the voxel"] = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 7, 2, 4 }, lmax = 2,
        metric_channels = "none" }, one),
      ["adaptive"] = ylm.bake(ylm.adaptive_grid { bounds = box, depth = 2, lmax = 2, tolerance = 1e-9 }, cubic,
        { occupied = p.position }),
    } do
      assert.is_true(grid.stats.cells > 1 or what == "one voxel")
      near(what, lib.shade_grid(view, grid, "transfer", "hermite", 0, nil), 1e-5)
      local _, off, norm = core.array_distance(view:render({ grid = grid }):layer(), view:render({ grid = one }):layer())
      assert.is_true(off < 1e-5 * norm, ("%s: %g in the picture"):format(what, off / norm))
      -- .. and it is the interpolation that makes it so
      local _, linear = core.array_distance(lib.shade_grid(view, grid, "transfer", "linear", 0, nil), truth)
      assert.is_true(linear > 1e-3, what .. " by linear interpolation")
    end
  end)

  it("uses a grid of another lmax up to the smaller of the two", function()
    local s = small_scene()
    local options = { size = { 32, 18 }, samples = 2, visibility = "none" }
    local low = s:bake { probes = ylm.uniform_grid { cells = 4, lmax = 2 } }
    local high = s:bake { probes = ylm.uniform_grid { cells = 4, lmax = 5 } }
    local at2, at5 = s:prepare(with(options, { lmax = 2 })), s:prepare(with(options, { lmax = 5 }))
    local a, b = at2:render { grid = low }, at2:render { grid = high }
    local _, off, norm = core.array_distance(a:layer(), b:layer())
    assert.is_true(off < 1e-5 * norm, tostring(off / norm))
    _, off, norm = core.array_distance(at5:render({ grid = low }):layer(), a:layer())
    assert.is_true(off < 1e-5 * norm, tostring(off / norm))
  end)

  it("by the cosine alone, of light that holds its shadows, is shading where nothing occludes", function()
    local s = ylm.scene "cosine" {
      camera = ylm.camera { from = { 2, 3, 4 }, at = { 0, 0.3, 0 }, fov = 40 },
      geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 },
        material = ylm.matte { albedo = { 0.5, 0.25, 0.125 } } }, ylm.sphere { at = { 0, 0.5, 0 }, radius = 0.5 } },
      lights = { ylm.sphere_light { at = { -0.9, 1.3, 0.8 }, radius = 0.1, radiance = { 40, 30, 18 } } },
    }
    local lights = s.lights
    for _, shading in ipairs { "pixel", "vertices" } do
      local o = { size = { 32, 18 }, samples = 2, shading = shading, lmax = 4 }
      local open, rays = s:prepare(with(o, { visibility = "none" })), s:prepare(o)
      local shadowed = s:prepare(with(o, { visibility = "transfer", transfer_samples = 16, occlusion_distance = 1 }))
      assert.equal(4 * 25 * rays.stats.points, open.stats.bytes - rays.stats.bytes)
      local probes = { bounds = { { -3, -1, -3 }, { 3, 2, 3 } }, cells = 5, lmax = 4 }
      local lamps = ylm.sphere_lights { at = { { -0.9, 1.3, 0.8 } }, radius = 0.1, radiance = { { 40, 30, 18 } } }
      for _, field in ipairs { ylm.bake(ylm.uniform_grid(probes), lights), lamps.lights } do
        local function shade(view, weight)
          if core.type(field) == "ylm.grid" then return (lib.shade_grid(view, field, weight, "hermite", 0, nil)) end
          return (lib.shade_field(view, field, weight, "float", 0, nil))
        end
        local wanted = shade(open, "transfer")
        local _, _, norm = core.array_distance(wanted, wanted)
        assert.is_true(norm > 0.1)
        for _, view in ipairs { open, rays, shadowed } do
          assert.equal(0, (core.array_distance(shade(view, "cosine"), wanted)))
        end
        assert.is_true((core.array_distance(shade(shadowed, "transfer"), wanted)) > 0.01)
        local radiance, message = shade(rays, "transfer")
        assert.is_nil(radiance, message)
      end
      -- light of another degree than the view's counts up to its own
      probes.lmax = 6
      local high = ylm.bake(ylm.uniform_grid(probes), lights)
      local wanted = lib.shade_grid(s:prepare(with(o, { visibility = "none", lmax = 6 })), high, "transfer", "hermite", 0, nil)
      assert.equal(0, (core.array_distance(lib.shade_grid(rays, high, "cosine", "hermite", 0, nil), wanted)))
    end
  end)

  it("of vertices comes near that of pixels on a fine mesh", function()
    local s = ylm.scene "fine" {
      camera = ylm.camera { from = { 0, 3, 0.1 }, at = { 0, 0, 0 }, fov = 30 },
      geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 128 } },
      lights = { ylm.sphere_light { at = { 0.3, 1, 0 }, radius = 0.1, radiance = 30 } },
    }
    local options = { size = { 32, 18 }, samples = 4, layers = false }
    local pixels = s:render(ways.sum(options))
    local vertices, report = s:render(ways.sum(with(options, { shading = "vertices" })))
    local mixed = s:render(ways.sum(with(options, { vectors_at = "vertices" })))
    assert.is_true(report.points > 100)
    for _, image in ipairs { vertices, mixed } do
      local _, off, norm = core.array_distance(image:layer(), pixels:layer())
      assert.is_true(off < 2e-3 * norm, tostring(off / norm))
    end
  end)

  it("agrees between the kernels of all instruction sets", function()
    local program = [[
local ylm = require "ylm"
local s = ylm.scene "k" {
  camera = ylm.camera { from = { 2, 3, 4 }, at = { 0, 0.3, 0 }, fov = 40 },
  geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
    ylm.sphere { at = { 0, 0.5, 0 }, radius = 0.5 } },
  lights = { ylm.sphere_light { at = { -0.9, 0.3, 0.8 }, radius = 0.1, radiance = { 40, 30, 18 } },
    ylm.sphere_light { at = { 1.2, -0.1, -0.4 }, radius = 0.2, radiance = 9 } } }
for _, lmax in ipairs { 0, 2, 4, 5 } do
  local v = s:prepare { size = { 24, 14 }, samples = 3, lmax = lmax, transfer_samples = 16, visibility = "transfer" }
  local t = v:render { by = "sum" }:layer():totable()
  for _, row in ipairs(t) do for _, p in ipairs(row) do print(p[1]) print(p[2]) end end
end
for _, row in ipairs(s:render({ bounces = 0, size = { 24, 14 }, samples = 3, light_samples = 8 }):layer():totable()) do
  for _, p in ipairs(row) do print(p[1]) end
end]]
    local function run(isa)
      local numbers = by_kernels(isa, program)
      assert(#numbers == 24 * 14 * 9, isa .. ": " .. #numbers)
      return ylm.array(numbers)
    end
    local reference = run "reference"
    for _, isa in ipairs(ylm.info().kernels) do
      local _, off, norm = core.array_distance(run(isa), reference)
      assert(off < 1e-4 * norm, ("%s: %g"):format(isa, off / norm))
    end
  end)
end)

describe("ray casting", function()
  it("finds the closed form of a lamp above the horizon, and numerical integrals of one that it cuts", function()
    local elements = records()
    for i = 1, #elements do
      local e = elements[i]
      local s = element(e.x, e.n, { ylm.sphere_light { at = e.y, radius = e.r, radiance = 1 } })
      local image = s:render { by = "rays", bounces = 0, size = { 1, 1 }, samples = 1, light_samples = 4096, visibility = "none" }
      local off = math.abs(pixel(image) * pi - e.value)
      assert.is_true(off <= 5e-3 * e.value + 1e-12, ("record %d, seed 1: %g of %g"):format(i, off, e.value))
    end
  end)

  it("weighs many lamps right, and a lamp around the point", function()
    local x, n = { 0, 0, 0 }, { 0, 0, 1 }
    local lights, wanted = {}, 0
    for i = 1, 150 do
      local y, r = { i % 7 - 3, i % 5 - 2, 1 + i % 11 }, 0.02 + i % 3 * 0.1
      local d2 = y[1] ^ 2 + y[2] ^ 2 + y[3] ^ 2
      lights[i] = ylm.sphere_light { at = y, radius = r, radiance = i }
      wanted = wanted + i * pi * r * r / d2 * y[3] / sqrt(d2)
    end
    local image = element(x, n, lights):render { by = "rays", bounces = 0, size = { 1, 1 }, samples = 1, light_samples = 2048,
      visibility = "none" }
    assert.near(1, pixel(image) * pi / wanted, 2e-3)
    local around = element(x, n, { ylm.sphere_light { at = { 0, 0, 0.1 }, radius = 0.5, radiance = 3 } })
    assert.near(3, pixel(around:render { bounces = 0, size = { 1, 1 }, samples = 1, light_samples = 64 }), 1e-4)
  end)

  it("sees shadows: none in the open, all of them behind a blocker", function()
    local lamp = ylm.sphere_light { at = { 0, 0, 2 }, radius = 0.1, radiance = 1 }
    local options = { size = { 1, 1 }, samples = 1, light_samples = 64 }
    local open = element({ 0, 0, 0 }, { 0, 0, 1 }, { lamp }):render(ways.rays(options))
    assert.near(pi * 0.05 ^ 2, pixel(open) * pi, 1e-5)
    local blocker = ylm.quad { corner = { -1, -1, 1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    assert.equal(0, pixel(element({ 0, 0, 0 }, { 0, 0, 1 }, { lamp }, { blocker }):render(ways.rays(options))))
    -- A blocker behind the lamp hides nothing.
    local behind = ylm.quad { corner = { -1, -1, 3 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    assert.near(pixel(open), pixel(element({ 0, 0, 0 }, { 0, 0, 1 }, { lamp }, { behind }):render(ways.rays(options))), 1e-7)
  end)

  it("agrees with SH shading where light is of low degree", function()
    local s = small_scene()
    local view = s:prepare { size = { 32, 18 }, samples = 4, visibility = "none", lmax = 10 }
    local sh, rays = view:render { by = "sum" }, view:render { by = "rays", light_samples = 64, visibility = "none" }
    local _, off, norm = core.array_distance(sh:layer(), rays:layer())
    assert.is_true(off < 0.03 * norm, tostring(off / norm))
  end)

  it("rests while the light so far is looked at", function()
    local raycast, looks, partial = lib.shade_raycast, 0, 0
    lib.shade_raycast = function(view, casting)
      local into = raycast(view, casting) * 0
      casting.into, casting.threads, casting.light_samples = into, 2, 512
      casting.progress = { function(done, total)
        local before, start = into:clone(), core.seconds()
        while core.seconds() - start < 2e-3 do end
        assert(into:same(before), "a thread wrote")
        local lit = before:not_equal(0):sum()
        looks, partial = looks + 1, partial + (done < total and lit > 0 and 1 or 0)
      end, every = 1e-3 }
      return raycast(view, casting)
    end
    local ok, message = pcall(function() return small_scene():render { by = "rays", bounces = 0, size = { 96, 54 } } end)
    lib.shade_raycast = raycast
    assert.is_true(ok, message)
    assert.is_true(partial > 2, ("%d looks, %d at a part of the light"):format(looks, partial))
  end)
end)
