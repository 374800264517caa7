-- Virtual lights at every shading point by their harmonics, as points, as spheres; closed forms and the judge.

local gathered = require "spec.support.gathered"
local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local grey = ylm.matte { albedo = 0.5 }
local lamp = ylm.sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 100 }

--- A closed box of side 2, seen from inside towards the middle of a wall.
local function room(lights, camera)
  return ylm.scene "a room" { geometry = { ylm.box { scale = 2, material = grey } }, lights = lights or lamp,
    camera = camera or ylm.camera { from = { 0.9, 0, 0 }, at = { -1, 0, 0 }, fov = 35 } }
end

--- Floor of side 2 seen from above, nothing else.
local function ground()
  return ylm.scene "a floor" { lights = lamp, camera = ylm.camera { from = { 0, 3, 0.01 }, at = { 0, 0, 0 }, fov = 30 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = grey } }
end

local function one_light(options)
  return ylm.virtual_lights(with({ at = { { 0.2, 1, 0.1 } }, normal = { { 0.6, -0.8, 0 } }, radius = 0.3,
    intensity = { 3, 2, 1 } }, options or {}))
end

local function mean(a)
  local sum, n = 0, a.shape[1] * a.shape[2]
  for i = 1, a.shape[1] do for j = 1, a.shape[2] do sum = sum + a:get(i, j, 2) end end
  return sum / n
end

--- The largest difference of two layers over the largest number of the second.
local function apart(a, b)
  local far, most = 0, 0
  for i = 1, a.shape[1] do
    for j = 1, a.shape[2] do
      for c = 1, 3 do
        far, most = math.max(far, math.abs(a:get(i, j, c) - b:get(i, j, c))), math.max(most, math.abs(b:get(i, j, c)))
      end
    end
  end
  return far / most
end

--- Radiance that leaves a view's shading points by paths of two reflections, and the variance of that, [n][3].
local function judged(view, samples)
  local lib = require "ylm.trace".library()
  local a, variance = lib.shade_judge(view, { samples = samples, first = 2, last = 2, seed = 1 })
  return a, variance
end

--- Radiance of the shading points, [n][3], where each is a pixel.
local function at_points(view, lights, options)
  local layer = gathered(view, lights, options)
  return layer:reshape { layer.shape[1] * layer.shape[2], 3 }
end

local function mean_of(a)
  local sum = 0
  for i = 1, #a do sum = sum + a:get(i, 2) / #a end
  return sum
end

describe("harmonics at shading points", function()
  --- Radiance by coefficients of the light field, in double.
  local function by_coefficients(view, lights, lmax)
    local p = view:points()
    local L = ylm.light_field(lmax, lights, p.position:clone "double", { dtype = "double" })
    local Y = ylm.sh.eval(lmax, p.normal:clone "double", { dtype = "double" })
    local A = ylm.sh.convolve and { math.pi, 2 * math.pi / 3, math.pi / 4, 0, -math.pi / 24, 0, math.pi / 64 }
    local rows = {}
    for i = 1, p.position.shape[1] do
      rows[i] = { 0, 0, 0 }
      for c = 1, 3 do
        for l = 0, lmax do
          for m = -l, l do
            local k = ylm.sh.index(l, m)
            rows[i][c] = rows[i][c] + A[l + 1] * L:get(i, c, k) * Y:get(i, k) * 0.5 / math.pi
          end
        end
      end
    end
    return rows
  end

  local view
  setup(function() view = ground():prepare { size = { 5, 4 }, samples = 1, share = 0 } end)

  for _, case in ipairs { { profile = "gauss" }, { profile = "cap" }, { profile = "point" }, { radius = 1.5 },
    { radius = 1.5, profile = "cap" }, { shift = 0.4 }, { normal = { { 0, 0, 0 } } }, { emission = true } } do
    local words = {}
    for key, value in pairs(case) do words[#words + 1] = key .. " " .. tostring(value) end
    it("are the coefficients of the light field, with " .. table.concat(words, ", "), function()
      local given = with({}, case)
      if case.emission then
        given.emission, given.intensity = { { {}, {}, {} } }, nil
        for c = 1, 3 do for k = 1, 9 do given.emission[1][c][k] = math.sin(c + 2 * k) + (k == 1 and 4 or 0) end end
      end
      local source = { at = { { 0.2, 1, 0.1 } }, normal = { { 0.6, -0.8, 0 } }, radius = 0.3, intensity = { 3, 2, 1 } }
      if case.emission then source.intensity = nil end
      for key, value in pairs(given) do source[key] = value end
      local lights = ylm.virtual_lights(source)
      for _, lmax in ipairs { 0, 2, 4, 6 } do
        local rows, got, k, most = by_coefficients(view, lights, lmax), gathered(view, lights, { lmax = lmax }), 0, 0
        for i = 1, #rows do most = math.max(most, math.abs(rows[i][1])) end
        assert.is_true(most > 0)
        for i = 1, got.shape[1] do
          for j = 1, got.shape[2] do
            k = k + 1
            for c = 1, 3 do assert.is_true(math.abs(got:get(i, j, c) - rows[k][c]) < 4e-6 * most) end
          end
        end
      end
    end)
  end

  it("add up, far and near parts too", function()
    local lights = room():virtual_lights { count = 300, radius = 0.05 }
    local inside = room():prepare { size = { 8, 6 }, samples = 1 }
    local far, near = lights:split { core = 0.4 }
    local whole, a, b = gathered(inside, lights), gathered(inside, far), gathered(inside, near)
    local worst = 0
    for i = 1, 6 do
      for j = 1, 8 do
        worst = math.max(worst, math.abs(a:get(i, j, 1) + b:get(i, j, 1) - whole:get(i, j, 1)) / whole:get(i, j, 1))
      end
    end
    assert.is_true(worst < 2e-5, worst)
  end)

  it("are damped by a window, and at the horizon", function()
    local lights = one_light()
    local plain = gathered(view, lights, { lmax = 4 })
    local flat = gathered(view, lights, { lmax = 4, window = { "hann", 1 } }) -- degree 0 alone
    assert.is_true(apart(flat, gathered(view, lights, { lmax = 0 })) < 1e-6)
    assert.is_true(apart(gathered(view, lights, { lmax = 4, horizon = "paper" }), plain) < 1e-6) -- high above
    local low = one_light { at = { { 0.2, -0.1, 0.1 } }, normal = { { 0, 1, 0 } } }
    assert.is_true(mean(gathered(view, low, { horizon = "paper" })) < 0.5 * mean(gathered(view, low)))
    assert.is_true(mean(gathered(view, low, { horizon = "gate" })) == mean(gathered(view, low)))
    local lower = one_light { at = { { 0.2, -0.5, 0.1 } }, normal = { { 0, 1, 0 } } }
    assert.equal(0, mean(gathered(view, lower, { horizon = "gate" })))
  end)
end)

describe("points", function()
  it("give rho Phi/(4 pi R^2) everywhere in an integrating sphere, whatever lights there are", function()
    local at, normal, intensity, R = {}, {}, {}, 1.5
    for i = 1, 40 do
      local z, t = math.cos(i * i), i * 2.4
      local r = math.sqrt(1 - z * z)
      local n = { r * math.cos(t), r * math.sin(t), z }
      at[i], normal[i] = { R * n[1], R * n[2], R * n[3] }, { -n[1], -n[2], -n[3] }
      intensity[i] = i % 7 / math.pi
    end
    local Phi = 0
    for i = 1, 40 do Phi = Phi + i % 7 end
    local scene = ylm.scene "a ball" { geometry = ylm.sphere { radius = R, material = grey },
      camera = ylm.camera { from = { 0, 0, 0 }, at = { 1, 0, 0 }, fov = 60 } }
    local view = scene:prepare { size = { 12, 8 }, samples = 1, shading = "vertices" } -- vertices lie on the sphere
    local lights = ylm.virtual_lights { at = at, normal = normal, intensity = intensity, profile = "point" }
    local got, wanted = gathered(view, lights, { method = "vpl", clamp = "none" }), Phi / (4 * math.pi * R * R) * 0.5 / math.pi
    for i = 1, 8 do for j = 1, 12 do assert.is_true(math.abs(got:get(i, j, 1) / wanted - 1) < 1e-4) end end
  end)

  it("are bounded by 1/d^2, by the geometry term, or by all but the light", function()
    local scene = ground()
    scene.camera = ylm.camera { from = { 0, 3, 0 }, at = { 0, 0, 0 }, up = { 0, 0, -1 }, fov = 0.01 }
    local view = scene:prepare { size = { 1, 1 }, samples = 1 }
    local lights = ylm.virtual_lights { at = { { 0, 0.1, 0 } }, normal = { { 0, -1, 0 } }, radius = 0.5, intensity = 1 }
    local function radiance(options) return mean(gathered(view, lights, with({ method = "vpl" },
      options))) / (0.5 / math.pi) end
    local function near(a, b) assert.is_true(math.abs(a / b - 1) < 2e-2, a .. " " .. b) end
    near(radiance { clamp = "none" }, 100)
    near(radiance { clamp = "distance", limit = 7 }, 7)
    near(radiance { clamp = "geometry", limit = 7 }, 7)
    near(radiance { clamp = "whole", limit = 7 }, 7 / (0.5 / math.pi))
    near(radiance {}, 1 / 0.5 ^ 2) -- the default limit
    near(radiance { limit = 1000 }, 100)
  end)

  it("have the mean of paths of two reflections, unbounded and with shadows", function()
    local scene = room()
    scene = ylm.scene "a room" { camera = scene.camera, lights = lamp,
      geometry = { scene.geometry, ylm.box { at = { -0.3, -0.6, 0.2 }, scale = 0.5, material = grey } } }
    local view = scene:prepare { size = { 6, 4 }, samples = 1, share = 0 }
    local truth, variance = judged(view, 4096)
    local sum, square, n, points = {}, {}, 12, #truth
    local clamped, mended = 0, 0
    for seed = 1, n do
      local lights = scene:virtual_lights { count = 100, seed = seed }
      local a = at_points(view, lights, { method = "vpl", clamp = "none", shadows = "centre" })
      local o = { method = "vpl", limit = 0.3, shadows = "centre", seed = seed }
      clamped = clamped + mean_of(at_points(view, lights, o)) / n
      mended = mended + mean_of(at_points(view, lights, with(o, { compensate = 16 }))) / n
      for k = 1, points do
        local x = a:get(k, 2)
        sum[k], square[k] = (sum[k] or 0) + x, (square[k] or 0) + x * x
      end
    end
    local z2, all = 0, 0
    for k = 1, points do
      local m = sum[k] / n
      local of = (square[k] / n - m * m) / (n - 1)
      z2 = z2 + (m - truth:get(k, 2)) ^ 2 / (of + variance:get(k, 2)) / points
      all = all + m / points
    end
    assert.is_true(z2 < 2.5, z2) -- points share lights: docs/virtual.md has many seeds
    local wanted = mean_of(truth)
    assert.is_true(math.abs(all / wanted - 1) < 0.02, all / wanted)
    assert.is_true(clamped < 0.95 * all, clamped / all)
    assert.is_true(math.abs(mended / wanted - 1) < 0.02, mended / wanted)
  end)
end)

describe("spheres", function()
  it("are points where they are far, by any strategy", function()
    local view = ground():prepare { size = { 4, 3 }, samples = 1 }
    for _, strategy in ipairs { "cone", "mis" } do
      local off = {}
      for i, r in ipairs { 0.2, 0.1 } do
        local lights = one_light { radius = r }
        local points = gathered(view, lights, { method = "vpl", clamp = "none" })
        off[i] = apart(gathered(view, lights, { method = "vsl", samples = 2000, strategy = strategy }), points)
      end
      assert.is_true(off[1] < 0.3 * 0.2 ^ 2 * 4 and off[2] < 0.3 * 0.1 ^ 2 * 4 + 1e-4, off[1] .. " " .. off[2])
    end
  end)

  it("have one mean by all strategies, within their radius too", function()
    local view = ground():prepare { size = { 3, 2 }, samples = 1 }
    local lights = one_light { at = { { 0.1, 0.3, 0 } }, normal = { { 0.6, 0.8, 0 } }, radius = 1.2 }
    local by = {}
    for _, strategy in ipairs { "cone", "receiver", "mis" } do
      by[strategy] = gathered(view, lights, { method = "vsl", samples = 8000, strategy = strategy })
    end
    assert.is_true(mean(by.cone) > 0)
    assert.is_true(apart(by.receiver, by.cone) < 8e-3, apart(by.receiver, by.cone))
    assert.is_true(apart(by.mis, by.cone) < 8e-3, apart(by.mis, by.cone))
  end)
end)

describe("more lights", function()
  it("come to what paths find", function()
    local scene = room()
    local view = scene:prepare { size = { 6, 4 }, samples = 1, share = 0 }
    local truth = judged(view, 4096)
    local off = {}
    for i, n in ipairs { 128, 2048 } do
      local sum = 0
      for seed = 1, 3 do
        local got = at_points(view, (scene:virtual_lights { count = n, seed = seed }), { lmax = 8 })
        for k = 1, #truth do sum = sum + (got:get(k, 2) / truth:get(k, 2) - 1) ^ 2 / 3 / #truth end
      end
      off[i] = math.sqrt(sum)
    end
    assert.is_true(off[2] < 0.06 and off[2] < 0.8 * off[1], off[1] .. " " .. off[2])
  end)
end)

describe("bounces by virtual lights", function()
  local scene = room()
  local options = { size = { 6, 4 }, samples = 1, layers = false }
  local function rendered(more)
    local image, report = scene:render(with(options, more))
    return assert(image, report):layer "radiance", report
  end

  it("are direct light and the light of scene:virtual_lights, with the picture's seed", function()
    local direct = rendered { bounces = 0 }
    local all, report = rendered { bounced = (scene:virtual_lights { count = 50 }), virtual = { shadows = "centre" } }
    local view = scene:prepare { size = { 6, 4 }, samples = 1 }
    local alone = gathered(view, (scene:virtual_lights { count = 50 }), { shadows = "centre" })
    for i = 1, 4 do
      for j = 1, 6 do
        local sum = direct:get(i, j, 1) + alone:get(i, j, 1)
        assert.is_true(math.abs(all:get(i, j, 1) - sum) < 1e-6 * sum)
      end
    end
    assert.equal("virtual", report.bounced)
    assert.equal(1, report.bounces)
    assert.equal(50, report.virtual.lights)
    assert.equal(0, #report.warnings)
    assert.is_true(apart(rendered { bounced = (scene:virtual_lights { count = 50 }) }, all) < 1e-6) -- nothing is in the way
  end)

  it("are of lamps that view:render is given", function()
    local view = scene:prepare { size = { 6, 4 }, samples = 1 }
    local twice = ylm.sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 200 }
    local o = { bounced = "virtual", bounces = 1, layers = false }
    local one = view:render(o):layer "radiance"
    local two = view:render(with(o, { lights = twice })):layer "radiance"
    assert.is_true(math.abs(two:get(2, 3, 1) / one:get(2, 3, 1) - 2) < 1e-4)
  end)

  it("are none where bounces = 0, and say that they pass walls", function()
    local _, report = rendered { bounces = 0, bounced = "virtual" }
    assert.equal(0, report.bounces)
    _, report = rendered { bounced = (scene:virtual_lights { count = 5 }) }
    assert.matches("shine through walls", report.warnings[1])
  end)

  it("refuse what is no option of theirs", function()
    refused("no field 'shadow'", function() rendered { bounced = "virtual",
      virtual = { shadow = 3 } } end)
    refused("reflected 64 times at most", function() rendered { bounces = 65, bounced = "virtual" } end)
    refused("bounces are those of the virtual lights", function()
      rendered { bounces = 2, bounced = (scene:virtual_lights { count = 5 }) }
    end)
    refused("bounced must be 'links', 'virtual'", function() rendered { bounced = "lines" } end)
  end)
end)

describe("pictures of virtual lights", function()
  it("makes the same picture whatever the number of threads, and counts pairs and rays", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 9, 7 }, samples = 1 }, scene:virtual_lights { count = 70 }
    for _, o in ipairs { { method = "vsl" }, { method = "vpl", compensate = 4 }, { shadows = "centre" } } do
      local first, report = gathered(view, lights, with(o, { threads = 1 }))
      assert.same(first:totable(), gathered(view, lights, with(o, { threads = 3 })):totable())
      assert.equal(70 * view.stats.points, report.virtual.pairs)
      assert.is_true((report.rays.virtual > 0) == (o.method ~= "vsl"))
    end
  end)

  it("gives darkness where there are no lights", function()
    local none = ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }
    local view = ground():prepare { size = { 3, 2 }, samples = 1 }
    for _, method in ipairs { "hvl", "vpl", "vsl" } do assert.equal(0, mean(gathered(view, none, { method = method }))) end
  end)

  it("counts a point at a shading point as nothing", function()
    local view = ground():prepare { size = { 1, 1 }, samples = 1, share = 0 }
    local p = view:points().position:totable()
    local lights = ylm.virtual_lights { at = p, intensity = 1, profile = "point" }
    assert.equal(0, mean(gathered(view, lights, { method = "vpl", clamp = "none" })))
    assert.equal(0, mean(gathered(view, lights)))
  end)

  it("says in one line that lights shine through walls, and how surfaces gloss", function()
    local scene = ylm.scene "gloss" { lights = lamp, camera = room().camera,
      geometry = ylm.box { scale = 2, material = ylm.ggx { alpha = 0.4, f0 = 0.3 } } }
    local view = scene:prepare { size = { 2, 2 }, samples = 1 }
    local _, r = view:render { by = "none", bounced = one_light() }
    assert.matches("shine through walls: %S+ %% of their light here passes them.*: shadows = 'centre'", r.warnings[1])
    assert.equal(1, #r.warnings)
    local matte = scene:prepare { size = { 2, 2 }, samples = 1, visibility = "none", gloss = "matte" }
    _, r = matte:render { by = "none", bounced = one_light() }
    assert.matches("1 mesh is glossy: virtual lights shade it as a matte one", r.warnings[2])
    _, r = view:render { by = "none", bounced = one_light(), virtual = { shadows = "centre" } }
    assert.equal(0, #r.warnings)
  end)

  it("refuses what is another method's, and what no method knows", function()
    local view, lights = ground():prepare { size = { 2, 2 }, samples = 1 }, one_light()
    local function says(pattern, o) refused(pattern, function() view:render(ways.virtual(with({ lights = lights }, o))) end) end
    says("lmax is of harmonics, which rival = 'vpl' has none of", { method = "vpl", lmax = 4 })
    refused("samples is of scene:prepare", function() view:render { by = "none", bounced = lights, samples = 4 } end)
    says("samples must be an integer >= 1", { method = "vsl", samples = 0 })
    says("limit is of a clamp", { method = "vpl", clamp = "none", limit = 3 })
    says("compensate finds what a clamp takes away", { method = "vpl", clamp = "none", compensate = 3 })
    says("compensate needs lights that scene:virtual_lights made", { method = "vpl", compensate = 3 })
    says("window", { window = { "no such", 3 } })
    says("shadows must be one of 'none', 'centre'", { shadows = "all" })
    refused("and nothing bounces", function() view:render { by = "none" } end)
    local bare = ylm.virtual_lights { at = { { 0, 1, 0 } }, intensity = 1, profile = "point" }
    refused("limit is needed: the lights have no radius", function() view:render { by = "none", bounced = bare,
      rival = { "vpl" } } end)
    refused("light 1 has no radius", function() view:render { by = "none", bounced = bare, rival = { "vsl" } } end)
    local _, near = one_light():split { core = 1 }
    refused("which only harmonics know", function() view:render { by = "none", bounced = near, rival = { "vsl" } } end)
  end)

  it("ends where progress says so", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 64, 48 }, samples = 1 }, scene:virtual_lights { count = 3000 }
    local image, message, code = view:render { by = "none", bounced = lights, threads = 1,
      progress = function() return false end }
    assert.same({ nil, "cancelled", "ECANCELLED" }, { image, message, code })
  end)
end)
