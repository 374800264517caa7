--- Lamps that shadow rays are aimed at: few are weighed one by one, many are drawn from a tree (csrc/scene).

local ylm = require "ylm"
local by_kernels = require "spec.support.by_kernels"
local floor_of_lamps = require "spec.support.floor_of_lamps"
local lib = require "ylm.c.scene"
local light = require "ylm.light"
local spread = require("spec.support.random").spread
local long = require "spec.support.long"

local ALL = 2 ^ 30 -- lamps weighed one by one

--- Lights without geometry, ready to be aimed at: drawn from a tree, and weighed one by one.
local function both(lights)
  local set = light.set(assert(light.pack(1, "spec", lights)))
  local empty = assert(lib.scene_create({}, {}, {}, set, false, {}))
  return assert(lib.scene_relight(empty, set, false, 1)), assert(lib.scene_relight(empty, set, false, ALL))
end

local function direction(random)
  local z, a = 2 * random() - 1, 2 * math.pi * random()
  local s = math.sqrt(1 - z * z)
  return { s * math.cos(a), s * math.sin(a), z }
end

--- n spheres, triangles and disks, or one kind of them, in groups all over a hall, a few of them bright, some dark.
local function hall(n, seed, only, horizons)
  local random, lights, c = spread(seed), {}, nil
  for i = 1, n do
    if i % 7 == 1 then c = { 10 * random(), 6 * random(), 3 * random() } end
    local at, kind, e = {}, only or i % 3, i % 11 == 0 and 0 or 10 ^ (2 * random())
    for a = 1, 3 do at[a] = c[a] + 0.4 * (random() - 0.5) end
    if kind == 0 then
      lights[i] = ylm.sphere_light { at = at, radius = 0.01 + 0.03 * random(), radiance = e }
    elseif kind == 1 then
      local v = {}
      for k = 1, 3 do
        local d = direction(random)
        v[k] = { at[1] + 0.05 * d[1], at[2] + 0.05 * d[2], at[3] + 0.05 * d[3] }
      end
      lights[i] = ylm.polygon_light { vertices = v, radiance = e, horizon = horizons and direction(random) or nil }
    else
      lights[i] = ylm.disk_light { at = at, normal = direction(random), radius = 0.02 + 0.03 * random(), radiance = e }
    end
  end
  return lights
end

--- Which of n lights of a hall each lamp is: spheres come first, then triangles, then disks.
local function lamps_of(n)
  local list = {}
  for kind = 0, 2 do
    for i = 1, n do
      if i % 3 == kind then list[#list + 1] = i end
    end
  end
  return list
end

--- Whether any of a light is above the horizon at x with normal n.
local function rises(l, x, n)
  local function height(p) return (p[1] - x[1]) * n[1] + (p[2] - x[2]) * n[2] + (p[3] - x[3]) * n[3] end
  if l.vertices then return math.max(height(l.vertices[1]), height(l.vertices[2]), height(l.vertices[3])) > 0 end
  local m, across = l.normal, 1
  if m then across = math.sqrt(math.max(0, 1 - (m[1] * n[1] + m[2] * n[2] + m[3] * n[3]) ^ 2)) end
  return height(l.at) + across * l.radius > 0
end

--- Points of the hall with normals, the first at lamps themselves.
local function places(n, seed, lights)
  local random, rows = spread(seed), {}
  for i = 1, n do
    local at = lights and i <= 4 and lights[3 * i].at or { 10 * random(), 6 * random(), 3 * random() }
    local d = direction(random)
    rows[i] = { at[1], at[2], at[3], d[1], d[2], d[3] }
  end
  return rows
end

local function split(row) return { row[1], row[2], row[3] }, { row[4], row[5], row[6] } end

local function uniforms(n, seed)
  local random, rows = spread(seed), {}
  for i = 1, n do rows[i] = { (i - random()) / n, random(), random() } end
  return ylm.array(rows, "double")
end

--- The mean of (a - b)^2 over its variance, of rows {mean, variance of it}: 1 for unbiased estimates.
local function z2(a, b)
  local sum, n = 0, 0
  for i = 1, #a do
    if a[i][1] > 0 or b[i][1] > 0 then sum, n = sum + (a[i][1] - b[i][1]) ^ 2 / (a[i][2] + b[i][2]), n + 1 end
  end
  return sum / n, n
end

describe("lamps drawn from a tree", function()
  local lights = hall(300, 3)
  local tree, plain = both(lights)
  local rows, ordered = places(40, 5, lights), lamps_of(300)

  it("are chosen with shares whose sum is 1, but for groups of which nothing is above the horizon", function()
    local total = 0
    for i, row in ipairs(rows) do
      local x, n = split(row)
      for _, normal in ipairs { n, false } do
        local shares, sum = lib.chooser_shares(tree, x, normal or nil):totable(), 0
        for k = 1, #lights do
          local bright = lights[ordered[k]].radiance[1] > 0
          local above = bright and (not normal or rises(lights[ordered[k]], x, n))
          if not bright then assert.equal(0, shares[k]) end
          if above then assert.is_true(shares[k] > 0, ("point %d, lamp %d"):format(i, k)) end
          sum = sum + shares[k]
        end
        if not normal then assert.near(1, sum, 1e-12) end
        assert.is_true(sum < 1 + 1e-12 and sum > 0.5)
        total = total + sum
      end
    end
    assert.is_true(total / 80 > 0.98, total / 80)
  end)

  it("are chosen as often as their shares say (chi squared), and with the density that is told", function()
    local n = 8000
    for i = 1, 12 do
      local x, normal = split(rows[i])
      if i % 4 == 0 then normal = nil end
      local share, count, chosen, worst = lib.chooser_shares(tree, x, normal):totable(), {}, 0, 0
      for k = 1, #lights do count[k] = 0 end
      local u, random = {}, spread(i)
      for k = 1, n do u[k] = { random(), random(), random() } end
      for _, s in ipairs(lib.chooser_sample(tree, x, normal, ylm.array(u, "double")):totable()) do
        if s[8] <= #lights then count[s[8]] = count[s[8]] + 1 end
        if s[4] > 0 then
          chosen = chosen + 1
          worst = math.max(worst, math.abs(s[9] / s[4] - 1))
        end
      end
      assert.is_true(chosen > n / 5 and worst < 1e-3, worst)
      local chi, cells, rest, expected = 0, 0, n, n -- the last cell: rare lamps, and none
      for k = 1, #lights do
        if share[k] * n >= 5 then
          chi = chi + (count[k] - share[k] * n) ^ 2 / (share[k] * n)
          cells, rest, expected = cells + 1, rest - count[k], expected - share[k] * n
        end
      end
      if expected >= 5 then chi, cells = chi + (rest - expected) ^ 2 / expected, cells + 1 end
      local off = (chi - (cells - 1)) / math.sqrt(2 * math.max(1, cells - 1))
      assert.is_true(cells > 3 and math.abs(off) < 4.5, ("point %d: chi^2 %.1f of %d cells"):format(i, chi, cells))
    end
  end)

  it("bring what all bring that are weighed one by one: z2", function()
    local at = ylm.array(places(200, 9), "float")
    for _, samples in ipairs { 1, 4, 70 } do
      local ratio, n = z2(lib.chooser_aim(tree, at, samples, math.floor(6400 / samples), 1):totable(),
        lib.chooser_aim(plain, at, samples, 100, 2):totable())
      assert.is_true(n > 190 and ratio > 0.7 and ratio < 1.4, ("%d samples: z2 %.2f"):format(samples, ratio))
    end
  end)

  it("vary less than a hundredth of what lamps chosen by power do: medians of points", function()
    local spheres, places_of, all, total = hall(600, 4, 0), places(200, 9), {}, 0
    local of_tree = both(spheres)
    local a = lib.chooser_aim(of_tree, ylm.array(places_of, "float"), 4, 200, 1):totable()
    for _, l in ipairs(spheres) do total = total + l.radiance[1] * l.radius ^ 2 end
    for i, row in ipairs(places_of) do
      local x, n = split(row)
      local E, squares = 0, 0 -- of lamps as points
      for _, l in ipairs(spheres) do
        local v, d2, h = {}, 0, 0
        for k = 1, 3 do
          v[k] = l.at[k] - x[k]
          d2, h = d2 + v[k] ^ 2, h + v[k] * n[k]
        end
        local power = l.radiance[1] * l.radius ^ 2
        local e = h > 0 and math.pi * power * h / d2 ^ 1.5 or 0
        E = E + e
        if power > 0 then squares = squares + e * e * total / power end
      end
      all[i] = { (squares / E ^ 2 - 1) / 4, a[i][2] * 199 / a[i][1] ^ 2 }
    end
    local median = {}
    for k = 1, 2 do
      local list = {}
      for i, v in ipairs(all) do list[i] = v[k] end
      table.sort(list)
      median[k] = list[100]
    end
    assert.is_true(median[2] < median[1] / 100 and median[2] < 0.01, ("power %.4f, tree %.4f"):format(median[1], median[2]))
  end)
end)

describe("lamps drawn from a tree bring", function()
  it("the sum of closed forms: spheres above the horizon, by aim and by sample", function()
    local at, radius, truth = floor_of_lamps(3000, 1)
    local tree = both { ylm.sphere_lights { at = at, radius = radius, radiance = 1 } }
    local row = lib.chooser_aim(tree, ylm.array({ { 0, 0, 0, 0, 1, 0 } }, "float"), 16, 2000, 1):totable()[1]
    assert.is_true(math.abs(row[1] - truth) < 4 * math.sqrt(row[2]) and math.sqrt(row[2]) < 1e-3 * truth)
    local sum, samples = 0, 20000
    for _, s in ipairs(lib.chooser_sample(tree, { 0, 0, 0 }, { 0, 1, 0 }, uniforms(samples, 1)):totable()) do
      if s[4] > 0 then sum = sum + s[6] * s[2] / s[4] / samples end
    end
    assert.near(1, sum / truth, 0.01)
  end)

  it("what one square brings that they tile, from both sides; half of it above its horizon", function()
    local lights, m = {}, 24
    for i = 0, m - 1 do
      for k = 0, m - 1 do
        local x, z, w = -1 + 2 * i / m, -1 + 2 * k / m, 2 / m
        lights[#lights + 1] = { { x, 1, z }, { x + w, 1, z }, { x + w, 1, z + w }, { x, 1, z + w } }
      end
    end
    --- A square of half edge 1 at distance 1, unit radiance: 4 (X/sqrt(1+X^2)) atan(Y/sqrt(1+X^2)) 2/2, with X = Y = 1.
    local truth = 4 * math.atan(1 / math.sqrt(2)) / math.sqrt(2)
    local points = ylm.array({ { 0, 0, 0, 0, 1, 0 }, { 0, 2, 0, 0, -1, 0 } }, "float")
    for _, cut in ipairs { false, true } do
      local all = {}
      for i, v in ipairs(lights) do
        all[i] = ylm.polygon_light { vertices = v, radiance = 1, horizon = cut and { 1, 0, 0 } or nil }
      end
      for i, row in ipairs(lib.chooser_aim(both(all), points, 16, 500, 1):totable()) do
        local want = cut and truth / 2 or truth
        assert.is_true(math.abs(row[1] - want) < 4 * math.sqrt(row[2]) + 1e-4 and row[2] < (0.01 * want) ^ 2,
          ("side %d: %g, %g expected"):format(i, row[1], want))
      end
    end
  end)

  it("pi inside of a sphere, whatever else there is", function()
    local lights = {}
    for i = 1, 400 do lights[i] = ylm.sphere_light { at = { i % 10, i % 6, 2 }, radius = 0.01, radiance = 1e-9 } end
    lights[#lights + 1] = ylm.sphere_light { at = { 5, 3, 1 }, radius = 0.2, radiance = 2 }
    local rows = lib.chooser_aim(both(lights), ylm.array({ { 5, 3, 1, 0, 1, 0 }, { 5, 3.1, 1, 0, 0, 1 } }, "float"), 4, 50, 1)
    for _, row in ipairs(rows:totable()) do assert.near(2 * math.pi, row[1], 1e-4) end
  end)

  it("nothing that is not a number, at lamps themselves, of no size, of no light, far and huge", function()
    local lights = hall(300, 2)
    for i = 1, 60 do
      lights[#lights + 1] = ylm.sphere_light { at = { i, 0, 0 }, radius = i % 2 * 1e-18, radiance = 1 }
      lights[#lights + 1] = ylm.sphere_light { at = { i * 1e6, 1e7, 0 }, radius = 1e5, radiance = 1e-8 }
    end
    local rows = places(40, 3, lights)
    for i = 1, 20 do rows[20 + i] = { i, 0, 0, 0, 1, 0 } end
    local tree = both(lights)
    for _, row in ipairs(lib.chooser_aim(tree, ylm.array(rows, "float"), 8, 20, 1):totable()) do
      assert.is_true(row[1] >= 0 and row[1] < math.huge and row[2] < math.huge)
    end
    for _, row in ipairs(rows) do
      local x, sum = split(row), 0
      for _, share in ipairs(lib.chooser_shares(tree, x, nil):totable()) do sum = sum + share end
      assert.near(1, sum, 1e-12)
    end
  end)

  it("nothing where all are dark or below the horizon", function()
    local dark, below = {}, {}
    for i = 1, 300 do
      dark[i] = ylm.sphere_light { at = { i, 1, 0 }, radius = 0.1, radiance = 0 }
      below[i] = ylm.sphere_light { at = { i % 20, -1 - i / 300, i }, radius = 0.1, radiance = 1 }
    end
    local up = ylm.array({ { 0, 0, 0, 0, 1, 0 } }, "float")
    for _, lights in ipairs { dark, below } do
      local tree = both(lights)
      assert.same({ 0, 0 }, lib.chooser_aim(tree, up, 4, 4, 1):totable()[1])
      for _, share in ipairs(lib.chooser_shares(tree, { 0, 0, 0 }, { 0, 1, 0 }):totable()) do assert.equal(0, share) end
    end
  end)
end)

describe("a tree of lamps", function()
  --- Spheres on a spiral, from arrays.
  local function spiral(n)
    local at, radius = {}, {}
    for i = 1, n do
      local a, r = 2.399963 * i, 30 * math.sqrt(i / n)
      at[i], radius[i] = { r * math.cos(a), 1 + 0.5 * math.sin(i), r * math.sin(a) }, 1e-3
    end
    return { ylm.sphere_lights { at = at, radius = radius, radiance = 1 } }
  end

  it("beside a sky has the share that its light has of all", function()
    local lights = spiral(1000)
    lights[2] = ylm.environment_light { radiance = 3e-6 }
    local tree, plain = both(lights)
    local function sky(s)
      local shares = lib.chooser_shares(s, { 0, 0, 0 }, { 0, 1, 0 }):totable()
      return shares[#shares]
    end
    assert.is_true(sky(plain) > 0.02 and sky(plain) < 0.98)
    assert.near(1, sky(tree) / sky(plain), 0.1)
    local at = ylm.array({ { 0, 0, 0, 0, 1, 0 }, { 3, 0, 2, 0, 1, 0 } }, "float")
    local a, b = lib.chooser_aim(tree, at, 4, 2000, 1):totable(), lib.chooser_aim(plain, at, 4, 2000, 2):totable()
    for i = 1, 2 do assert.is_true(math.abs(a[i][1] - b[i][1]) < 4 * math.sqrt(a[i][2] + b[i][2])) end
  end)

  it("is the same for every number of threads, and pictures are", function()
    local s = ylm.scene "spiral" { geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
      camera = ylm.camera { from = { 0, 2, 5 }, at = { 0, 0, 0 } }, lights = spiral(20000) }
    local first
    for _, threads in ipairs { 1, 2, 7 } do
      local picture = assert(s:render { bounces = 0, size = { 32, 18 }, light_samples = 4,
        threads = threads }):layer("radiance"):totable()
      first = first or picture
      assert.same(first, picture)
    end
  end)

  it("holds a million lamps, and finds those near a point", function()
    local n = long(100000, 1000000)
    local tree = both(spiral(n))
    local x, up, u = { 0.5, 0.99, 0.2 }, { 0, 1, 0 }, uniforms(1000, 1)
    local near, sum = 0, 0
    for _, s in ipairs(lib.chooser_sample(tree, x, up, u):totable()) do
      if s[8] <= n / 100 then near = near + 1 end -- within 3 of the middle
      if s[4] > 0 then
        assert.near(1, s[9] / s[4], 1e-3)
        sum = sum + s[6] * s[2] / s[4] / 1000
      end
    end
    assert.is_true(near > 500, near)
    -- E = pi r^2 sum cos/d^2, a sum of which the lamps are the terms
    local truth = 0
    for i = 1, n do
      local a, r = 2.399963 * i, 30 * math.sqrt(i / n)
      local v = { r * math.cos(a) - 0.5, 0.01 + 0.5 * math.sin(i), r * math.sin(a) - 0.2 }
      local d2 = v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2
      if v[2] > 0 then truth = truth + math.pi * 1e-6 * v[2] / (d2 * math.sqrt(d2)) end
    end
    assert.near(1, sum / truth, 0.05)
  end)

  it("is weighed alike by every instruction set", function()
    local program = [[
      local ylm = require "ylm"
      local lib, light = require "ylm.c.scene", require "ylm.light"
      local lights = {}
      for i = 1, 500 do
        local p = { math.sin(i) * 3, math.cos(1.7 * i) * 2, math.sin(2.3 * i) }
        lights[i] = i % 2 == 0 and ylm.sphere_light { at = p, radius = 0.05, radiance = i % 9 }
          or ylm.disk_light { at = p, normal = { math.cos(i), 1, 0 }, radius = 0.05, radiance = i % 7 }
      end
      local scene = assert(lib.scene_create({}, {}, {}, light.set(light.pack(1, "spec", lights)), false, {}))
      for _, n in ipairs { false, { 0, 1, 0 } } do
        for _, share in ipairs(lib.chooser_shares(scene, { 0.3, -1, 0.1 }, n or nil):totable()) do print(share) end
      end
      for _, lamps in ipairs { 1, 4, 5, 70 } do -- vectors of four take few lamps and few rays
        local few = {}
        for i = 1, lamps do few[i] = lights[2 * i] end
        scene = assert(lib.scene_create({}, {}, {}, light.set(light.pack(1, "spec", few)), false, {}))
        for _, rays in ipairs { 1, 4, 5, 70 } do
          local at = ylm.array({ { 0.3, -3, 0.1, 0, 1, 0 }, { 0.1, 0.2, 0, 0.6, 0, 0.8 } }, "float")
          for _, row in ipairs(lib.chooser_aim(scene, at, rays, 1, 1):totable()) do print(row[1]) end
        end
      end
    ]]
    local want
    for _, isa in ipairs(ylm.info().kernels) do
      local got = by_kernels(isa, program)
      assert.equal(1032, #got, isa)
      want = want or got
      for i = 1, #want do assert.near(want[i], got[i], 1e-4 * want[i] + 1e-9, isa .. " " .. i) end
    end
  end)
end)

