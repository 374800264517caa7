local ylm = require "ylm"
local core = require "ylm.c.core"
local lib = require "ylm.c.scene"
local light = require "ylm.light"
local spread = require("spec.support.random").spread

local none = {}

--- Lights as the library takes them; {x, y, z, radius} are spheres.
local function packed(lamps)
  local lights = {}
  for i, l in ipairs(lamps or none) do
    lights[i] = l[4] and ylm.sphere_light { at = { l[1], l[2], l[3] }, radius = l[4], radiance = 1 } or l
  end
  return light.set(assert(light.pack(1, "spec", lights)))
end

--- A traced scene of geometry and lights.
local function traced(geometry, lamps)
  local meshes, materials, occludes = {}, {}, {}
  for i, g in ipairs(geometry) do
    meshes[i], materials[i], occludes[i] = g.mesh, core.material_create("matte", { 1, 1, 1 }), g.occludes
  end
  return assert(lib.scene_create(meshes, materials, occludes, packed(lamps), false, {}))
end

--- Rays { origin, direction, far } as the array that scene_trace takes.
local function rays(list)
  local rows = {}
  for i, r in ipairs(list) do
    rows[i] = { r[1][1], r[1][2], r[1][3], r[2][1], r[2][2], r[2][3], 0, r[3] or 1e30 }
  end
  return ylm.array(rows, "float")
end

local function floor(fields)
  local f = { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } }
  for k, v in pairs(fields or none) do f[k] = v end
  return ylm.quad(f)
end

describe("tracing", function()
  it("finds the nearest triangle with its distance, weights and winding normal, from either side", function()
    local s = traced { floor(), floor { at = { 0, 1, 0 } } }
    local hits = lib.scene_trace(s, rays { { { 0.2, 5, 0.3 }, { 0, -2, 0 } }, { { 0.2, -3, 0.3 }, { 0, 1, 0 } } })
    assert.same({ 2, 1 }, { hits:get(1, 1), hits:get(2, 1) })
    assert.near(2, hits:get(1, 3), 1e-6)
    assert.near(3, hits:get(2, 3), 1e-6)
    for i = 1, 2 do
      local n = { hits:get(i, 6), hits:get(i, 7), hits:get(i, 8) }
      assert.is_true(n[2] > 0 and n[1] == 0 and n[3] == 0)
    end
    -- The hit's place from the weights of the corners.
    local mesh = floor { at = { 0, 1, 0 } }.mesh
    local t, v = mesh:triangles()[hits:get(1, 2)], mesh:vertices()
    local u, w = hits:get(1, 4), hits:get(1, 5)
    local weights, p = { 1 - u - w, u, w }, { 0, 0, 0 }
    for k = 1, 3 do for a = 1, 3 do p[a] = p[a] + weights[k] * v:get(t[k], a) end end
    assert.near(0.2, p[1], 1e-6)
    assert.near(1, p[2], 1e-6)
    assert.near(0.3, p[3], 1e-6)
  end)

  it("sees lamps, and they occlude nothing", function()
    local s = traced({ floor() }, { { 0, 2, 0, 0.5 }, { 0.4, 1, 0, 0.1 } })
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 } }, { { 0.4, 1.4, 0 }, { 0, -1, 0 } }, { { 0.9, 5, 0 }, { 0, -1, 0 } } }
    local hits = lib.scene_trace(s, r)
    assert.same({ -1, -1, 1 }, { hits:get(1, 1), hits:get(2, 1), hits:get(3, 1) })
    assert.same({ 1, 2 }, { hits:get(1, 2), hits:get(2, 2) })
    assert.near(2.5, hits:get(1, 3), 1e-5)
    local down = { 0, -1, 0 }
    local up = rays { { { 0, 0.1, 0 }, { 0, 1, 0 } }, { { 0, 5, 0 }, down, 4.9 }, { { 0, 5, 0 }, down, 5.1 } }
    assert.same({ 0, 0, 1 }, lib.scene_trace(s, up, "occlusion"):totable())
  end)

  it("sees what does not occlude, and lets light through it", function()
    local s = traced { floor { occludes = false, at = { 0, 1, 0 } }, floor() }
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 }, 4.5 }, { { 0, 5, 0 }, { 0, -1, 0 }, 5.5 } }
    assert.equal(1, lib.scene_trace(s, r):get(1, 1))
    assert.same({ 0, 1 }, lib.scene_trace(s, r, "occlusion"):totable())
  end)

  it("misses everything in an empty scene", function()
    local s = traced {}
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 } } }
    assert.equal(0, lib.scene_trace(s, r):get(1, 1))
    assert.same({ 0 }, lib.scene_trace(s, r, "occlusion"):totable())
    assert.same({ { 0, 0, 0 }, { 0, 0, 0 } }, { lib.scene_bounds(s) })
  end)

  it("knows the box around all meshes", function()
    local lo, hi = lib.scene_bounds(traced({ floor(), floor { at = { 3, 1, 0 } } }, { { 9, 9, 9, 1 } }))
    assert.same({ { -1, 0, -1 }, { 4, 1, 1 } }, { lo, hi })
  end)
end)

--- The distance at which a ray enters a sphere, or leaves it if it starts inside; nil: it misses. Then whether it grazes.
local function met_sphere(l, o, d)
  local along, d2, r2 = 0, 0, l[4] ^ 2
  for a = 1, 3 do
    along = along + (l[a] - o[a]) * d[a]
    d2 = d2 + (l[a] - o[a]) ^ 2
  end
  local aside = d2 - along ^ 2
  if aside > r2 then return nil, aside < 1.001 * r2 end
  local half = math.sqrt(r2 - aside)
  local t = d2 <= r2 and along + half or along - half
  return t >= 0 and t or nil, aside > 0.999 * r2
end

--- As met_sphere, of triangles {p, q, r} and disks { at =, radius =, normal = } that lie across x, for rays along x.
local function met_flat(l, o)
  local at = l.at or l[1]
  local function edge(p, q) return (q[2] - p[2]) * (o[3] - p[3]) - (q[3] - p[3]) * (o[2] - p[2]) end
  local inside
  if l.at then
    inside = (at[2] - o[2]) ^ 2 + (at[3] - o[3]) ^ 2 < l.radius ^ 2
  else
    local a, b, c = edge(l[1], l[2]), edge(l[2], l[3]), edge(l[3], l[1])
    inside = (a > 0 and b > 0 and c > 0) or (a < 0 and b < 0 and c < 0)
  end
  return inside and at[1] >= o[1] and at[1] - o[1] or nil
end

--- All lamps that one ray meets, asked for n at a time: lists of distances and lamps.
local function meetings(s, ray, n)
  local distances, lamps, calls = {}, {}, 0
  repeat
    local d, l = lib.scene_lamps(s, ray, n, distances[#distances], lamps[#lamps])
    for i = 1, #d do
      distances[#distances + 1], lamps[#lamps + 1] = d[i], l[i]
    end
    calls = calls + 1
    assert(#d <= n and calls < 10000)
  until #d < n
  return distances, lamps
end

describe("tracing to occluders", function()
  it("passes lamps and what does not occlude", function()
    local s = traced({ floor { occludes = false, at = { 0, 1, 0 } }, floor() }, { { 0, 2, 0, 0.5 } })
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 } }, { { 0, 5, 0 }, { 0, 1, 0 } }, { { 0, 5, 0 }, { 0, -1, 0 }, 4.5 } }
    local hits = lib.scene_trace(s, r, "nearest")
    assert.same({ 2, 0, 0 }, { hits:get(1, 1), hits:get(2, 1), hits:get(3, 1) })
    assert.near(5, hits:get(1, 3), 1e-6)
    assert.same({ -1, -1 }, { lib.scene_trace(s, r):get(1, 1), lib.scene_trace(s, r):get(3, 1) })
  end)

  it("has hits where occlusion rays are blocked, and those of all rays without lamps in the way, alike or not", function()
    local geometry, random = {}, spread(7)
    local function at() return { random() * 4 - 2, random() * 4 - 2, random() * 4 - 2 } end
    local function to_a_lamp(from) return { 0.6 + 0.1 * random() - from[1] / 4, 3 - from[2], 0.4 - from[3] / 4 } end
    for i = 1, 40 do geometry[i] = ylm.sphere { at = at(), radius = 0.2, divide = { 8, 6 } } end
    local s = traced(geometry)
    for _, alike in ipairs { false, true } do
      local list, count = {}, 0
      for i = 1, 1000 do
        local from = at()
        list[i] = { from, alike and to_a_lamp(from) or at(), alike and 1 or 3 }
      end
      local r = rays(list)
      local nearest, first, blocked = lib.scene_trace(s, r, "nearest"), lib.scene_trace(s, r), lib.scene_trace(s, r, "occlusion")
      for i = 1, 1000 do
        for k = 1, blocked:get(i) == 1 and 8 or 3 do assert.equal(first:get(i, k), nearest:get(i, k)) end
        assert.equal(blocked:get(i), nearest:get(i, 1) > 0 and 1 or 0)
        count = count + blocked:get(i)
      end
      assert.is_true(count > 100 and count < 900, count)
    end
  end)
end)

describe("the lamps that a ray meets", function()
  it("are those of brute force, hundreds that overlap, however many are asked for at a time", function()
    local random = spread(3)
    local o, d = { -3, 0.013, 0.007 }, { 1, 0, 0 }
    local spheres, triangles, disks, lights, expected = {}, {}, {}, {}, {}
    local function near() return { random() * 8 - 4, random(), random() - 0.5 } end
    while #spheres < 400 do
      local p = near()
      local l = { p[1], p[2], p[3], 0.02 + random() }
      local _, grazes = met_sphere(l, o, d)
      if not grazes then spheres[#spheres + 1] = l end
    end
    for i = 1, 100 do
      local x = random() * 8 - 4
      local function corner() return { x, random() - 0.5, random() - 0.5 } end
      triangles[i] = { corner(), corner(), corner() }
      disks[i] = { at = near(), radius = 0.1 + random(), normal = { i % 2 * 2 - 1, 0, 0 }, radiance = 1 }
    end
    for _, l in ipairs(spheres) do lights[#lights + 1] = l end
    for _, l in ipairs(triangles) do lights[#lights + 1] = ylm.polygon_light { vertices = l, radiance = 1 } end
    for _, l in ipairs(disks) do lights[#lights + 1] = ylm.disk_light(l) end
    for i, l in ipairs(spheres) do expected[i] = (met_sphere(l, o, d)) end
    for i, l in ipairs(triangles) do expected[#spheres + i] = met_flat(l, o) end
    for i, l in ipairs(disks) do expected[#spheres + #triangles + i] = met_flat(l, o) end
    local wanted = 0
    for _ in pairs(expected) do wanted = wanted + 1 end
    assert.is_true(wanted > 200)

    local s, ray = traced({}, lights), rays { { o, d } }
    local all, numbers = meetings(s, ray, 1024)
    assert.equal(wanted, #numbers)
    for i, lamp in ipairs(numbers) do
      assert.near(expected[lamp] or -1, all[i], 1e-5)
      assert.is_true(i == 1 or all[i] > all[i - 1] or (all[i] == all[i - 1] and lamp > numbers[i - 1]))
    end
    for _, n in ipairs { 1, 3, 16, 17, 300 } do
      local some, these = meetings(s, ray, n)
      assert.same(all, some)
      assert.same(numbers, these)
    end
  end)

  it("stand at one distance by the dozen, each reported once", function()
    local lights = {}
    for i = 1, 50 do lights[i] = { 2, 0, 0, 0.5 } end
    for i = 51, 90 do lights[i] = ylm.disk_light { at = { 1.5, 0, 0 }, normal = { 1, 0, 0 }, radius = 1, radiance = 1 } end
    local distances, lamps = meetings(traced({}, lights), rays { { { 0, 0, 0 }, { 1, 0, 0 } } }, 16)
    assert.equal(90, #lamps)
    for i = 1, 90 do assert.same({ 1.5, i }, { distances[i], lamps[i] }) end
  end)

  it("are spheres where they are entered, or left from inside, once", function()
    local lights = { { 0, 0, 0, 2 }, { 1, 0, 0, 0.25 }, { 4, 0, 0, 1 }, { -3, 0, 0, 0.5 }, { 1000, 0, 0, 2000 } }
    local s = traced({}, lights)
    local distances, lamps = meetings(s, rays { { { 0, 0, 0 }, { 1, 0, 0 } } }, 1)
    assert.same({ 2, 1, 3, 5 }, lamps)
    for i, t in ipairs { 0.75, 2, 3, 3000 } do assert.near(t, distances[i], 1e-6 * t) end
    -- of a direction of length 2: distances in lengths of it
    assert.near(0.375, meetings(s, rays { { { 0, 0, 0 }, { 2, 0, 0 } } }, 3)[1], 1e-6)
  end)

  it("end where the ray ends, and no mesh hides them", function()
    local s = traced({ floor() }, { { 0, 2, 0, 0.5 }, { 0, -2, 0, 0.5 } })
    local function count(far) return #meetings(s, rays { { { 0, 5, 0 }, { 0, -1, 0 }, far } }, 16) end
    assert.same({ 0, 1, 1, 2 }, { count(2.4), count(2.6), count(6.4), count(6.6) })
    assert.equal(0, #meetings(traced { floor() }, rays { { { 0, 5, 0 }, { 0, -1, 0 } } }, 16))
  end)

  it("are the first hits of camera rays where nothing else is", function()
    local random, lights, list = spread(11), {}, {}
    local function at() return { random() * 4 - 2, random() * 4 - 2, random() * 4 - 2 } end
    for i = 1, 200 do
      local p = at()
      lights[i] = i % 2 == 0 and { p[1], p[2], p[3], 0.05 + 0.2 * random() }
        or ylm.disk_light { at = p, normal = at(), radius = 0.3, radiance = 1 }
    end
    local s = traced({}, lights)
    for i = 1, 500 do
      local p, q = at(), at()
      local d = math.sqrt(q[1] ^ 2 + q[2] ^ 2 + q[3] ^ 2)
      list[i] = { p, { q[1] / d, q[2] / d, q[3] / d } }
    end
    local hits, met = lib.scene_trace(s, rays(list)), 0
    for i, r in ipairs(list) do
      local distances, lamps = lib.scene_lamps(s, rays { r }, 1)
      assert.equal(hits:get(i, 1) == -1, lamps[1] ~= nil)
      if lamps[1] then
        assert.near(hits:get(i, 3), distances[1], 1e-4)
        assert.equal(hits:get(i, 2), lamps[1])
        met = met + 1
      end
    end
    assert.is_true(met > 200)
  end)
end)

describe("a traced scene with other lamps", function()
  local ray = rays { { { 0.2, 5, 0.3 }, { 0, -1, 0 } } }

  --- Rays from all around, and lamps that they meet.
  local function many(seed)
    local random, lamps, list = spread(seed), {}, {}
    local function at() return { random() * 4 - 2, random() * 4 - 2, random() * 4 - 2 } end
    for i = 1, 100 do
      local p = at()
      lamps[i] = i % 3 > 0 and { p[1], p[2], p[3], 0.05 + 0.2 * random() }
        or ylm.disk_light { at = p, normal = at(), radius = 0.3, radiance = i }
    end
    for i = 1, 500 do list[i] = { at(), at() } end
    return lamps, rays(list)
  end

  it("is what a scene of the same meshes and those lamps is", function()
    local geometry = { ylm.sphere { radius = 0.7, divide = { 16, 12 } }, floor { at = { 0, 1, 0 }, occludes = false }, floor() }
    local before, lamps, list = many(5), many(6)
    local moved, made = assert(lib.scene_relight(traced(geometry, before), packed(lamps), false)), traced(geometry, lamps)
    assert.same(lib.scene_trace(made, list, "occlusion"):totable(), lib.scene_trace(moved, list, "occlusion"):totable())
    local lit = 0
    for _, kind in ipairs { "first", "nearest" } do
      local a, b = lib.scene_trace(made, list, kind), lib.scene_trace(moved, list, kind)
      for i = 1, 500 do
        for k = 1, a:get(i, 1) > 0 and 8 or 3 do assert.equal(a:get(i, k), b:get(i, k)) end
        lit = lit + (a:get(i, 1) < 0 and 1 or 0)
      end
    end
    assert.is_true(lit > 50)
    assert.same({ lib.scene_bounds(made) }, { lib.scene_bounds(moved) })
    assert.same(lib.scene_vertices(made):totable(), lib.scene_vertices(moved):totable())
    local sphere = { { 2, 2, 2 }, { -0.5, -0.5, -0.5 } }
    assert.same({ lib.scene_lamps(made, rays { sphere }, 16) }, { lib.scene_lamps(moved, rays { sphere }, 16) })
    local u = {}
    for i = 1, 200 do u[i] = { (i - 0.5) / 200, i * 0.754877 % 1, i * 0.569840 % 1 } end
    u = ylm.array(u, "double")
    assert.same(lib.chooser_sample(made, { 0, 0.1, 0.9 }, { 0, 1, 0 }, u):totable(),
      lib.chooser_sample(moved, { 0, 0.1, 0.9 }, { 0, 1, 0 }, u):totable())
  end)

  it("leaves the first as it was, and needs it no longer", function()
    local first = traced({ floor() }, { { 0.2, 2, 0.3, 0.5 } })
    local second = assert(lib.scene_relight(first, packed { { 0.2, 3, 0.3, 0.5 } }, false))
    local third = assert(lib.scene_relight(second, packed {}, false))
    assert.near(2.5, lib.scene_trace(first, ray):get(1, 3), 1e-5)
    lib.scene_close(first)
    assert.near(1.5, lib.scene_trace(second, ray):get(1, 3), 1e-5)
    lib.scene_close(second)
    assert.equal(1, lib.scene_trace(third, ray):get(1, 1))
    assert.near(5, lib.scene_trace(third, ray):get(1, 3), 1e-5)
  end)

  it("shares the tables of a sky that is still there", function()
    local pixels, rows = ylm.image { size = { 512, 256 } }, {}
    for y = 1, 256 do
      rows[y] = {}
      for x = 1, 512 do rows[y][x] = { 1, y, x } end
    end
    core.array_fill(pixels:layer(), rows)
    local sky = ylm.environment_light { image = pixels, up = "y", lmax = 2 }
    local down, up = ylm.array({ { 0, -1, 0 }, { 0, 1, 0 }, { 0.6, 0.8, 0 } }, "float"), { 0, 1, 0 }
    local function seconds(make)
      local start = core.seconds()
      local made = assert(make())
      return core.seconds() - start, made
    end
    local first = traced({ floor() }, { { 0.2, 2, 0.3, 0.5 }, sky })
    local slow, made = seconds(function() return traced({ floor() }, { { 0.2, 3, 0.3, 0.5 }, sky }) end)
    local set = packed { { 0.2, 3, 0.3, 0.5 }, sky }
    local fast, moved = math.huge, nil
    for _ = 1, 5 do
      local time, one = seconds(function() return lib.scene_relight(first, set, false) end)
      fast, moved = math.min(fast, time), one
    end
    assert.is_true(fast < slow / 4, ("%.4f s, %.4f made anew"):format(fast, slow))
    lib.scene_close(first)
    assert.same(lib.chooser_sky(made, { 0, 1, 0 }, up, down):totable(), lib.chooser_sky(moved, { 0, 1, 0 }, up, down):totable())
    assert.same(lib.chooser_sky(made, { 0, 1, 0 }, nil, down):totable(), lib.chooser_sky(moved, { 0, 1, 0 }, nil, down):totable())
    local other = assert(lib.scene_relight(moved, packed { { 0.2, 3, 0.3, 0.5 }, ylm.environment_light { radiance = 7 } }, false))
    assert.near(7, lib.chooser_sky(other, { 0, 1, 0 }, nil, down):get(1, 2), 1e-5)
  end)

  it("is made by a scene whose lights alone have changed, of one whose meshes have not", function()
    local tracing = require "ylm.trace"
    local quad = floor { divide = 256 }
    local lamp = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 1 }
    local s = ylm.scene "moving" { geometry = { quad }, lights = { lamp } }
    local created, relit = 0, 0
    local create, relight = lib.scene_create, lib.scene_relight
    lib.scene_create = function(...) created = created + 1 return create(...) end
    lib.scene_relight = function(...) relit = relit + 1 return relight(...) end
    finally(function() lib.scene_create, lib.scene_relight = create, relight end)
    local one = assert(tracing.trace("spec", s))
    assert.equal(one, tracing.trace("spec", s))
    lamp.at = { 0.2, 2, 0.3 }
    local two = assert(tracing.trace("spec", s))
    assert.same({ 1, 1 }, { created, relit })
    assert.near(2.9, lib.scene_trace(two.handle, ray):get(1, 3), 1e-5)
    s.geometry[1] = floor { at = { 0, 4, 0 } }
    assert.near(1, lib.scene_trace(assert(tracing.trace("spec", s)).handle, ray):get(1, 3), 1e-5)
    assert.same({ 2, 1 }, { created, relit })
  end)
end)
