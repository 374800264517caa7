-- Derivatives of illuminance by lamps: links:receivers, radiosity:importance and its derivatives.

local long = require "spec.support.long"
local office = require "spec.support.office"
local ylm = require "ylm"

local function photometry() return ylm.photometry { cosine = 2, lumens = 3000 } end

--- A box room of albedo `rho`, with a slab in it where `slab`.
local function room(slab, rho)
  local g = { ylm.box { scale = 4, material = ylm.matte { albedo = rho or 0.5 } } }
  if slab then
    g[2] = ylm.box { bounds = { { -0.7, -1.5, -0.5 }, { -0.6, 0.4, 0.5 } }, material = ylm.matte { albedo = 0.4 } }
  end
  return ylm.scene "a room" { geometry = g, lights = ylm.sphere_light { at = { 0, 1, 0 }, photometric = true } }
end

--- A lamp by name, moved by `by` and otherwise as `more` says.
local makers = {
  disk = function(at, to, more)
    return ylm.photometric_light { photometry = photometry(), at = at, to = to, dim = more.dim, turn = more.turn,
      opening = { shape = "disk", radius = 0.2 + (more.size or 0) } }
  end,
  rectangle = function(at, to, more)
    return ylm.photometric_light { photometry = photometry(), at = at, to = to, dim = more.dim, turn = 20 + (more.turn or 0),
      opening = { shape = "rectangle", size = { 0.3, 0.5 + (more.size or 0) } } }
  end,
  sphere = function(at, to, more)
    return ylm.photometric_light { photometry = photometry(), at = at, to = to, dim = more.dim, turn = more.turn,
      opening = { shape = "sphere", radius = 0.1 + (more.size or 0) } }
  end,
}

local AT, TO = { 0.4, 1.3, 0.2 }, { 0.2, 0.3, 0.1 }

local function lamp(kind, more)
  more = more or {}
  local p = more.position or { 0, 0, 0 }
  local d = more.direction or { 0, 0, 0 }
  local at = { AT[1] + p[1], AT[2] + p[2], AT[3] + p[3] }
  local axis, length = {}, 0
  for a = 1, 3 do length = length + (TO[a] - AT[a]) ^ 2 end
  for a = 1, 3 do axis[a] = (TO[a] - AT[a]) / length ^ 0.5 + d[a] end
  return makers[kind](at, { at[1] + axis[1], at[2] + axis[2], at[3] + axis[3] }, more)
end

--- Links, receivers on a table's height, and the weighted mean under one lamp.
local function stage(scene, o)
  local t = scene:links { spacing = o.spacing or 1, rays = 32, lmax = 0 }
  local plane = { at = { 0, -1, 0 }, size = { 3, 3 }, spacing = 0.7 }
  local desk = t:receivers { plane = plane, rays = 32, light_samples = o.samples }
  local function light(lights, rim)
    return t:radiosity(lights, { derivatives = true, light_samples = o.samples, rim = rim or o.rim or 8,
      bounces = o.bounces or 6 })
  end
  local function mean(lights, rim) return light(lights, rim):importance { { desk, weights = desk.weights } } end
  return t, desk, mean, light
end

--- The derivative of f at 0, to h^4.
local function difference(f, h) return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h) end

local function near(wanted, got, within, what)
  assert.is_true(math.abs(wanted - got) <= within, ("%s: %.9g wanted, %.9g"):format(what, wanted, got))
end

describe("importance", function()
  it("is the transposed solution: h . E = lambda . E0 to 1e-12, in doubles of the same links", function()
    local scene = room(true)
    local t, _, _, light = stage(scene, { samples = 4, spacing = 2 })
    local lit = light(lamp "disk", 0)
    local hits, n, e = t:hits():totable(), t.stats.elements, t:elements()
    local albedo, E0, h, E = e.albedo:totable(), {}, {}, {}
    for i = 1, n do
      E0[i], h[i] = (i * 0.618) % 1, (i * 0.7548) % 1
      E[i] = E0[i]
    end
    for _ = 1, 6 do
      local next = {}
      for i = 1, n do
        local sum = 0
        for _, j in ipairs(hits[i]) do if j <= n then sum = sum + albedo[j][1] * E[j] end end
        next[i] = E0[i] + sum / #hits[i]
      end
      E = next
    end
    local weights, a, b = {}, 0, 0
    for i = 1, n do weights[i] = { h[i], 0, 0 } end
    local lambda = lit:importance({ elements = weights }):elements():totable()
    for i = 1, n do a, b = a + h[i] * E[i], b + lambda[i][1] * E0[i] end
    near(a, b, 1e-12 * a, "identity")
  end)

  it("weighs receivers: their weighted sum is that of direct light at them and on elements", function()
    local _, desk, mean = stage(room(true), { samples = 16 })
    local i = mean(lamp "rectangle")
    local d = i:derivatives()
    near(i.value, desk:figures(i.radiosity).mean, 1e-6 * i.value, "value")
    near(i.value, d.dim:get(1), 1e-6 * i.value, "light is proportional to dim")
    near(i.value / 3000, d.lumens:get(1), 1e-6 * i.value / 3000, "and to lumens")
    local colour = d.colour:totable()[1]
    near(i.value, colour[1] + colour[2] + colour[3], 1e-6 * i.value, "white is the sum of its channels")
  end)
end)

describe("derivatives by the lamp", function()
  it("agree with differences where nothing hides it, by place, direction, turn, size and lumens", function()
    local _, _, mean = stage(room(false), { samples = 16 })
    for kind in pairs(makers) do
      local d = mean({ lamp(kind) }):derivatives()
      local function value(more) return mean({ lamp(kind, more) }).value end
      for a = 1, 3 do
        local function along(name)
          return function(h) return value { [name] = { a == 1 and h or 0, a == 2 and h or 0, a == 3 and h or 0 } } end
        end
        near(difference(along "position", 0.03), d.position:get(1, a), 0.02, kind .. " position " .. a)
        near(difference(along "direction", 0.05), d.direction:get(1, a), 0.02, kind .. " direction " .. a)
      end
      near(difference(function(h) return value { turn = h } end, 4), d.turn:get(1), 2e-4, kind .. " turn")
      local size = kind == "rectangle" and d.size:get(1, 2) or d.radius:get(1)
      near(difference(function(h) return value { size = h } end, 0.02), size, 0.02, kind .. " size")
      near(difference(function(h) return value { dim = 1 + h } end, 0.2), d.dim:get(1), 1e-6 * d.dim:get(1), kind .. " dim")
    end
  end)

  it("by a half-plane's shadow are the chord over the disk's area", function()
    local R, high = 0.2, 2
    local plate = ylm.quad { corner = { -20, 1, -20 }, u = { 20, 0, 0 }, v = { 0, 0, 40 }, material = ylm.matte { albedo = 0 } }
    local scene = ylm.scene "an edge" { geometry = { plate }, lights = ylm.sphere_light { at = { 0, 9, 0 } } }
    local t = scene:links { spacing = 20, rays = 4, lmax = 0 }
    local r = t:receivers { points = { { 0, 0, 0 } }, rays = 4, light_samples = 1024 }
    local table_of = ylm.photometry { cosine = 0, lumens = 2 * math.pi }
    for _, s in ipairs { -0.12, 0, 0.09 } do
      local disk = ylm.photometric_light { photometry = table_of, at = { s, high, 0 }, opening = { shape = "disk", radius = R } }
      local lit = t:radiosity({ disk }, { derivatives = true, light_samples = 16, rim = 16, bounces = 0 })
      local i = lit:importance { { r, weights = { 1 } } }
      local seen = 0.5 + (math.asin(s / R) + s / R * math.sqrt(1 - s * s / R / R)) / math.pi
      near(seen, i.value * high ^ 2, 0.02, "visibility at " .. s)
      local chord = 2 * math.sqrt(R * R - s * s) / (math.pi * R * R)
      near(chord, i:derivatives().position:get(1, 1) * high ^ 2, 0.03 * chord, "its derivative at " .. s)
    end
  end)

  it("by place in an office with desks and partitions are within 3 % of differences, and count few rays and links", function()
    local lights = office.lamps(ylm)
    local t = office.scene(ylm, lights):links { spacing = 1.5, rays = 64, lmax = 0 }
    local desk = t:receivers { plane = office.desk, rays = 64 }
    local one = { lights[6] }
    local function mean(list, o)
      return t:radiosity(list, { derivatives = true, light_samples = o.samples, rim = o.rim, bounces = 5 }):importance {
        { desk, weights = desk.weights } }
    end
    local i = mean(one, { samples = 64, rim = 64 })
    local d, square, off = i:derivatives(), 0, 0
    for a = 1, 3 do
      local function at(h)
        local p = { one[1].at[1], one[1].at[2], one[1].at[3] }
        p[a] = p[a] + h
        return mean({ ylm.photometric_light { photometry = one[1].photometry, at = p, opening = one[1].opening } },
          { samples = long(256, 400), rim = 0 }).value
      end
      local wanted = (at(0.04) - at(-0.04)) / 0.08
      square, off = square + wanted ^ 2, off + (wanted - d.position:get(1, a)) ^ 2
    end
    assert.is_true(off < 0.03 ^ 2 * square, ("%.3f of the norm"):format((off / square) ^ 0.5))
    i = mean(lights, { samples = 16, rim = 8 })
    local s = i.radiosity.stats
    assert.is_true(s.rim_rays > 0 and s.rays < 1.2 * (s.rays - s.rim_rays), ("%d of %d rays"):format(s.rim_rays, s.rays))
    local forward = s.bounces * t.stats.elements * t.stats.links + desk.count * 64
    assert.is_true(i.link_reads + forward <= 2.5 * forward, "links that are read")
  end)

  it("by albedo are those of other paint", function()
    local function value(rho) return select(3, stage(room(true, rho), { samples = 16, bounces = 20 }))({ lamp "disk" }) end
    local h = 0.02
    local wanted = (value(0.5 + h).value - value(0.5 - h).value) / (2 * h)
    local d = value(0.5):derivatives { albedo = true }.mesh_albedo:totable()[1]
    near(wanted, d[1] + d[2] + d[3], 2e-3 * wanted, "albedo")
  end)

  it("say their noise, within which most of their error is, and are the same for any number of threads", function()
    local lights, t, desk = { lamp "rectangle" }, stage(room(true), {})
    local function of(samples, seed, threads)
      local lit = t:radiosity(lights, { derivatives = true, light_samples = samples, rim = samples, seed = seed, bounces = 6,
        threads = threads })
      return lit:importance({ { desk, weights = desk.weights } }):derivatives()
    end
    local truth, beyond = of(1024, 9), 0
    for seed = 1, 8 do
      local d = of(16, seed)
      for a = 1, 3 do
        local off = math.abs(d.position:get(1, a) - truth.position:get(1, a)) / d.noise.position:get(1, a)
        assert.is_true(off < 6, ("%.2g times its noise"):format(off))
        if off > 2 then beyond = beyond + 1 end
      end
    end
    assert.is_true(beyond <= 8, ("%d of 24 are off by twice their noise"):format(beyond))
    local one, three = of(16, 1, 1), of(16, 1, 3)
    for _, name in ipairs { "position", "direction", "lumens" } do
      assert.are.equal(tostring(one[name]:max()), tostring(three[name]:max()))
      assert.are.equal((one[name] - three[name]):max(), 0)
      assert.are.equal((one[name] - three[name]):min(), 0)
    end
  end)
end)

--- Lights of radiance, irradiance and intensity, moved by `more`; `factor`: of their size, lumens held.
local radiant = {}

local function coloured(more)
  local by = (1 + (more.dim or 0)) / (1 + (more.factor or 0)) ^ 2
  return { 10 * by, 6 * by, 3 * by }
end

local function placed(more)
  local p, d = more.position or { 0, 0, 0 }, more.direction or { 0, 0, 0 }
  return { AT[1] + p[1], AT[2] + p[2], AT[3] + p[3] }, { d[1], d[2] - 1, d[3] }, 1 + (more.factor or 0)
end

function radiant.disk_light(more)
  local at, axis, f = placed(more)
  return ylm.disk_light { at = at, normal = axis, radius = 0.2 * f, radiance = coloured(more), spread = 2 }
end

function radiant.polygon_light(more)
  local at, axis, f = placed(more)
  local vertices = {}
  for i, p in ipairs { { -0.2, -0.1 }, { 0.2, -0.1 }, { 0, 0.2 } } do -- level, then leaning with the normal
    local x, z = f * p[1], f * p[2]
    vertices[i] = { at[1] + x, at[2] + x * axis[1] + z * axis[3], at[3] + z }
  end
  return ylm.polygon_light { vertices = vertices, radiance = coloured(more) }
end

function radiant.spot_light(more)
  local at, axis = placed(more)
  return ylm.spot_light { at = at, to = { at[1] + axis[1], at[2] + axis[2], at[3] + axis[3] }, angle = 120, blend = 0.7,
    intensity = coloured { dim = more.dim } }
end

describe("derivatives by lights of other kinds", function()
  it("agree with differences where nothing hides them, by place, direction, size and level", function()
    local _, _, mean = stage(room(false), { samples = 16 })
    for kind, make in pairs(radiant) do
      local d = mean({ make {} }):derivatives()
      local function value(more) return mean({ make(more) }).value end
      for a = 1, 3 do
        local function along(name)
          return function(h) return value { [name] = { a == 1 and h or 0, a == 2 and h or 0, a == 3 and h or 0 } } end
        end
        near(difference(along "position", 0.03), d.position:get(1, a), 1e-3, kind .. " position " .. a)
        if a ~= 2 then near(difference(along "direction", 0.02), d.direction:get(1, a), 2e-3, kind .. " direction " .. a) end
      end
      if kind ~= "spot_light" then
        near(difference(function(h) return value { factor = h } end, 0.1), d.factor:get(1), 2e-4, kind .. " factor")
      end
      near(value {}, d.dim:get(1), 1e-6 * value {}, kind .. " dim")
      local channels = d.channels:totable()[1]
      near(value {}, 10 * channels[1] + 6 * channels[2] + 3 * channels[3], 1e-6 * value {}, kind .. " channels")
    end
    local notes = mean({ radiant.spot_light {} }):derivatives().notes
    assert.are.same({ "1 lamps are points: derivatives by their place hold their shadows" }, notes)
  end)

  it("by an edge's shadow are closed forms for suns and squares", function()
    local plate = ylm.quad { corner = { -20, 1, -20 }, u = { 20, 0, 0 }, v = { 0, 0, 40 }, material = ylm.matte { albedo = 0 } }
    local scene = ylm.scene "an edge" { geometry = { plate }, lights = ylm.sphere_light { at = { 0, 9, 0 } } }
    local t = scene:links { spacing = 20, rays = 4, lmax = 0 }
    local r = t:receivers { points = { { 0, 0, 0 } }, rays = 4, light_samples = 1024 }
    local function of(light)
      local lit = t:radiosity({ light }, { derivatives = true, light_samples = 16, rim = 16, bounces = 0 })
      local i = lit:importance { { r, weights = { 1 } } }
      return i.value, i:derivatives()
    end
    local E, d = of(ylm.sun_light { direction = { 0, 1, 0 }, angle = 4, irradiance = 3 })
    near(1.5, E, 0.01, "half a sun")
    local chord = 2 / (math.pi * math.sin(math.rad(2))) -- of a disk of its size, over its area
    near(3 * chord, d.direction:get(1, 1), 0.02 * 3 * chord, "its derivative")
    near(0, d.position:get(1, 1), 0, "it has no place")
    local square = ylm.polygon_light { radiance = 5,
      vertices = { { -0.2, 8, -0.2 }, { 0.2, 8, -0.2 }, { 0.2, 8, 0.2 }, { -0.2, 8, 0.2 } } }
    E, d = of(square)
    near(5 * 0.08 / 64, E, 0.01 * E, "half a square")
    near(5 * 0.4 / 64, d.position:get(1, 1), 0.02 * 5 * 0.4 / 64, "its width over the square of the distance")
  end)

  it("are of level and colour for skies and images, exactly, and their names are told", function()
    local plate = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = ylm.matte { albedo = 0 } }
    local sky = ylm.environment_light { radiance = { 3, 2, 1 } }
    local panel = ylm.textured_light { corner = { -1, 2, -1 }, u = { 2, 0, 0 }, v = { 0, 0, 2 }, image = { { 1, 2 }, { 4, 8 } } }
    local scene = ylm.scene "a plate" { geometry = { plate }, lights = { sky, radiant.spot_light {}, panel } }
    local t = scene:links { spacing = 1, rays = 16, lmax = 0 }
    local r = t:receivers { points = { { 0, 0.5, 0 } }, rays = 16, light_samples = 256 }
    local lit = t:radiosity(scene.lights, { derivatives = true, bounces = 0 })
    local i = lit:importance { { r, weights = { { 1, 0, 0 } } } }
    local d = i:derivatives()
    near(3 * math.pi, d.dim:get(1), 0.01 * 3 * math.pi, "by the sky's level")
    near(d.dim:get(1), d.colour:get(1, 1), 1e-12, "by its red channel")
    near(0, d.colour:get(1, 2), 0, "by its green")
    near(i.value, d.dim:get(1) + d.dim:get(2) + d.dim:get(3), 1e-5 * i.value, "the sum of all lights")
    assert.is_true(d.noise.dim:get(1) < 0.02 * d.dim:get(1) and d.noise.dim:get(3) > 0)
    assert.are.same({ "light 1, environment_light, has derivatives by level and colour alone",
      "light 3, textured_light, has derivatives by level and colour alone",
      "1 lamps are points: derivatives by their place hold their shadows" }, d.notes)
  end)

  it("trace rays again where their records are more than bytes, to the same bits", function()
    local scene = room(true)
    local lights = { radiant.disk_light {}, radiant.polygon_light {} }
    local t = scene:links { spacing = 1, rays = 32, lmax = 0 }
    local r = t:receivers { plane = { at = { 0, -1, 0 }, size = { 3, 3 }, spacing = 0.7 }, rays = 32 }
    local function of(bytes)
      local lit = t:radiosity(lights, { derivatives = true, bounces = 3, bytes = bytes })
      return lit:importance({ { r, weights = r.weights } }):derivatives()
    end
    local all, few = of "1 MB", of(2000)
    for _, name in ipairs { "position", "direction", "lumens", "factor" } do
      assert.are.same(all[name]:totable(), few[name]:totable())
    end
    assert.is_nil(all.notes)
    assert.are.same({ "records of lamps are more than bytes: their rays were traced twice" }, few.notes)
  end)
end)

describe("receivers", function()
  it("see what elements see: at their middles light is that of the elements", function()
    local scene = room(false)
    local t = scene:links { spacing = 1, rays = 256, lmax = 0 }
    local r = t:receivers { mesh = 1, rays = 1024 }
    local lit = t:radiosity({ lamp "disk" }, { derivatives = true, light_samples = 64 })
    assert.are.equal(r.count, t.stats.elements)
    local a, b = r:irradiance(lit), lit:irradiance()
    near(b:sum(), a:sum(), 0.01 * b:sum(), "all light")
    local plain = t:radiosity({ lamp "disk" }, { light_samples = 64 })
    near(a:sum(), r:irradiance(plain):sum(), 0.01 * a:sum(), "by lamps drawn at random")
  end)

  it("are the texels of a lightmap: the light is that of radiosity:lightmap", function()
    local wall = ylm.quad { corner = { -1, -1, -1.5 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, divide = 2,
      material = ylm.matte { albedo = 0.6 } }
    local scene = ylm.scene "a wall" { lights = ylm.sphere_light { at = { 0.4, 0.5, 0 }, radius = 0.2, radiance = 10 },
      geometry = { ylm.box { scale = 4, material = ylm.matte { albedo = 0.5 } }, wall } }
    local t = scene:links { spacing = 1, rays = 64, lmax = 0 }
    local r = t:receivers { mesh = 2, size = { 7, 5 }, rays = 512, light_samples = 64 }
    assert.are.same({ r.count, r.size[1], r.size[2] }, { 35, 7, 5 })
    local lit = t:radiosity(scene.lights, { derivatives = true, light_samples = 64 })
    local map, image = r:map(lit), lit:lightmap { mesh = 2, size = { 7, 5 }, rays = 512, light_samples = 256, gutter = 0 }
    local E = (image:layer "irradiance" * { 0.2126, 0.7152, 0.0722 }):sum(3)
    for row = 1, 5 do
      for column = 1, 7 do near(E:get(row, column), map:get(row, column), 0.04 * E:max(), row .. ", " .. column) end
    end
    assert.is_true(map:get(1, 5) > 1.3 * map:get(5, 1)) -- the top row first, to the right where the lamp is
  end)

  it("leave out places in bodies, and weigh the rest to 1", function()
    local t = room(true):links { spacing = 1, rays = 32, lmax = 0 }
    local r = t:receivers { plane = { at = { 0, -1, 0 }, size = { 3.9, 3.9 }, spacing = 0.08 }, rays = 16 }
    assert.is_true(r.left_out > 0 and r.count + r.left_out == r.size[1] * r.size[2])
    near(1, r.weights:sum(), 1e-12, "weights")
    assert.are.equal(r.points.shape[1], r.count)
    local lit = t:radiosity({ lamp "disk" }, { derivatives = true })
    assert.are.same(r:map(lit).shape, { r.size[2], r.size[1] })
    assert.are.equal(r:map(lit):min(), 0)
  end)

  it("of cylindrical illuminance take the mean of level directions: 1/pi of what a lamp at their height sends", function()
    local scene = ylm.scene "in the open" { geometry = { ylm.quad { corner = { -9, -9, 9 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } },
      lights = ylm.sphere_light { at = { 0, 9, 0 } } }
    local t = scene:links { spacing = 1, rays = 4, lmax = 0 }
    local r = t:receivers { points = { { 0, 0, 0 } }, quantity = "cylindrical", rays = 4 }
    local ball = ylm.sphere_light { at = { 3, 0, 0 }, radius = 0.1, radiance = 100 }
    local lit = t:radiosity({ ball }, { derivatives = true, bounces = 0 })
    local straight = math.pi * 100 * 0.1 ^ 2 / 9
    near(straight / math.pi, r:illuminance(lit):get(1), 0.06 * straight / math.pi, "of eight directions")
    local i = lit:importance { { r, weights = { 1 } } }
    near(-2 * i.value / 3, i:derivatives().position:get(1, 1), 1e-3, "falls off by the square")
  end)
end)
