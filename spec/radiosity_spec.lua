-- Bounces: closed forms, energy, direct light, what stops them, and moving lights.

local by_kernels = require "spec.support.by_kernels"
local core = require "ylm.c.core"
local elements = require "spec.support.elements"
local long = require "spec.support.long"
local ylm = require "ylm"

local pi = math.pi

local function near(x, truth, tolerance, what)
  assert.is_true(math.abs(x - truth) <= tolerance * math.abs(truth),
    ("%s: %.6g, not %.6g: off by %.2g of it"):format(what or "value", x, truth, math.abs(x / truth - 1)))
end

--- A sphere of radius 1 around a lamp at distance a from its middle.
local function globe(albedo, a)
  return ylm.scene "globe" {
    geometry = { ylm.sphere { radius = 1, divide = { 48, 24 }, material = ylm.matte { albedo = albedo } } },
    lights = { ylm.sphere_light { at = { 0, 0, a }, radius = 0.1, radiance = 10 } },
  }
end

local cut = { spacing = 0.2, rays = 64 }
local POWER = pi * 10 * 4 * pi * 0.1 ^ 2 -- of that lamp

describe("links:radiosity", function()
  it("finds rho^k for order k in a sphere, and 1 / (1 - rho) for all", function()
    local t = globe({ 0.5, 0.75, 0.25 }, 0.4):links(cut)
    local e = t:elements()
    local direct = t:radiosity(nil, { bounces = 0 })
    local E0 = elements.integral(e, direct:irradiance(), 1)
    near(E0, POWER, 2e-3, "all of the lamp's light lands")
    local last = E0
    for k = 1, 3 do
      local E = elements.integral(e, t:radiosity(nil, { bounces = k }):irradiance(), 1)
      near(E - last, E0 * 0.5 ^ k, 5e-3, "order " .. k)
      last = E
    end
    local lit = t:radiosity()
    for c, rho in ipairs { 0.5, 0.75, 0.25 } do
      near(elements.integral(e, lit:irradiance(), c), POWER / (1 - rho), 3e-3, "channel " .. c)
    end
  end)

  it("finds what bounces in a sphere to be the same everywhere", function()
    local t = globe(0.5, 0.6):links { spacing = 0.2, rays = 256 }
    local e, lit = t:elements(), t:radiosity()
    local E, E0, area = lit:irradiance(), lit:irradiance "direct", elements.integral(t:elements())
    local bounced, sum2 = POWER / area, 0 -- rho / (1 - rho) = 1
    for i = 1, #e.area do sum2 = sum2 + (E:get(i, 1) - E0:get(i, 1) - bounced) ^ 2 end
    -- Links are 256 to each element: their mean has the deviation of E0 over the sphere / 16, stratified less.
    assert.is_true(math.sqrt(sum2 / #e.area) < 0.1 * bounced, math.sqrt(sum2 / #e.area) / bounced)
  end)

  it("finds pi (1 - s) / (1 - rho s) in a bowl under a uniform sky, by rays and by coefficients", function()
    local g, rho = 1.2, 0.5
    local s = (1 - math.cos(g)) / 2
    local sky = ylm.environment_light { radiance = 1 }
    local t = ylm.scene "bowl" { geometry = { elements.bowl(g, 24, rho) }, lights = { sky } }:links { spacing = 0.2,
      rays = 128 }
    local e = t:elements()
    for _, direct in ipairs { "rays", "field" } do
      local E = t:radiosity(sky, { direct = direct, residual = 1e-5 }):irradiance()
      near(elements.mean(e, E, 1), pi * (1 - s) / (1 - rho * s), 6e-3, direct) -- facets see a little more of the sky
    end
  end)

  it("takes direct light from grids: of lights times transfer vectors, of direct light with shadows times the cosine", function()
    local box = ylm.box { bounds = { { -0.3, 0, -0.3 }, { 0.3, 0.5, 0.3 } }, material = ylm.matte { albedo = 0.5 } }
    local room = elements.room(0.5, box)
    local t = room:links { spacing = 0.25, rays = 64, sides = "front", lmax = 4 }
    local e, rays = t:elements(), t:radiosity()
    local grid = room:bake { probes = ylm.uniform_grid { cells = { 12, 12, 12 }, lmax = 3, bounds = { { -1, 0, -1 }, { 1, 2,
      1 } } },
      quantity = "direct" }
    local lit = t:radiosity(grid)
    near(elements.mean(e, lit:irradiance(), 1), elements.mean(e, rays:irradiance(), 1), 0.15, "by a grid of direct light")
    assert.is_true(lit:lightmap({ mesh = 1, size = { 4, 4 }, rays = 16 }):layer("irradiance"):get(1, 1, 1) > 0)
    -- Lights without a ceiling above them: T0 . L, of a grid of a lower degree than the transfer vectors.
    local yard = ylm.scene "a yard" { geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
      lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 10 } } }
    local open = yard:links { spacing = 0.25, rays = 64, sides = "front" }
    local probes = ylm.bake(ylm.uniform_grid { cells = 8, lmax = 2, bounds = { { -1, -0.1, -1 }, { 1, 0.5, 1 } } }, yard.lights)
    near(open:radiosity(probes).stats.emitted[1], open:radiosity().stats.emitted[1], 0.03, "by a grid of lights")
  end)

  it("keeps account of all light: emitted is absorbed and escaped, but for the noise of links", function()
    local torus = ylm.torus { at = { 0, 0.6, 0 }, scale = 0.5, divide = { 16, 8 }, material = ylm.matte { albedo = { 0.2, 0.5,
      0.8 } } }
    local room = elements.room({ 0.8, 0.5, 0.3 }, torus)
    room.geometry[4].mesh = ylm.quad({ corner = { 0, 0, 1 }, u = { -1, 0, 0 }, v = { 0, 2, 0 } }).mesh -- half a wall is open
    local t = room:links { spacing = 0.25, rays = 64 }
    local stats = t:radiosity().stats
    local e, albedo = t:elements(), 0
    for c = 1, 3 do albedo = math.max(albedo, elements.mean(e, e.albedo, c)) end
    local bound = 3 / ((1 - albedo) * math.sqrt(t.stats.elements * 64))
    assert.is_true(stats.balance <= bound, stats.balance .. " of at most " .. bound)
    assert.is_true(stats.escaped[1] > 0.01 * stats.emitted[1])
    for c = 1, 3 do near(stats.absorbed[c] + stats.escaped[c], stats.emitted[c], bound, "channel " .. c) end
  end)

  it("ends at the residual, or adds the rest: both are what many bounces reach", function()
    local t = elements.room(0.75):links { spacing = 0.4, rays = 64, sides = "front" }
    local e = t:elements()
    local function total(o)
      local lit = t:radiosity(nil, o)
      return elements.integral(e, lit:irradiance(), 1), lit.stats
    end
    local truth = total { bounces = 80 }
    local closed, with_rest = total {}
    local open, without = total { closure = false, residual = 1e-4 }
    near(closed, truth, 1e-3, "closure")
    near(open, truth, 5e-4, "no closure")
    assert.is_true(with_rest.closed and not without.closed and with_rest.bounces < without.bounces / 3)
    assert.is_true(without.residual <= 1e-4 and without.shrink > 0.7 and without.shrink < 0.8)
    assert.equal(3, select(2, total { bounces = 3 }).bounces)
  end)

  it("adds the rest by the light that bounces: a sky on outer walls does not end it for the room within", function()
    local t = dofile "spec/support/interiors.lua"(ylm)[2][2]:links { spacing = 0.25, rays = 32, lmax = 0 }
    local e = t:elements()
    local function inside(o)
      local E, sum = t:radiosity(nil, o):irradiance(), 0
      for i = 1, e.area.shape[1] do
        local x, y, z = e.centre:get(i, 1), e.centre:get(i, 2), e.centre:get(i, 3)
        if math.abs(x) < 1.99 and y > 0.01 and y < 2.49 and math.abs(z) < 1.49 then sum = sum + e.area:get(i) * E:get(i, 2) end
      end
      return sum
    end
    near(inside {}, inside { bounces = 60 }, 5e-3, "light within")
  end)

  it("agrees with the path tracer on the walls of a room with a box in it", function()
    local box = ylm.box { bounds = { { -0.6, 0, -0.6 }, { -0.1, 0.8, -0.1 } }, material = ylm.matte { albedo = { 0.7, 0.2,
      0.1 } } }
    local room = elements.room({ 0.6, 0.7, 0.5 }, box)
    local t = room:links { spacing = long(0.15, 0.06), rays = long(128, 512), sides = "auto" }
    local e, E = t:elements(), t:radiosity(nil, { light_samples = 64 }):irradiance()
    local points, normals, found = {}, {}, { 0, 0, 0 }
    for i = 1, #e.area, math.floor(#e.area / 90) do
      local n, x = {}, {}
      for a = 1, 3 do n[a], x[a] = e.normal:get(i, a), e.centre:get(i, a) end
      if x[1] * n[1] + (x[2] - 1) * n[2] + x[3] * n[3] < -0.9 then -- of a wall's inner side
        points[#points + 1], normals[#normals + 1] = x, n
        for c = 1, 3 do found[c] = found[c] + E:get(i, c) end
      end
    end
    local truth = room:probe { points = points, normals = normals, samples = long(1024, 16384) }
    assert.is_true(#points > 20)
    for c = 1, 3 do
      local sum = 0
      for i = 1, #points do sum = sum + truth:get(i, c) end
      near(found[c], sum, long(0.02, 0.005), "channel " .. c)
    end
  end)

  it("does not depend on the number of threads", function()
    local t = elements.room(0.7):links { spacing = 0.4, rays = 32 }
    local function found(threads) return t:radiosity(nil, { threads = threads }):leaving():totable() end
    local one = found(1)
    assert.same(one, found(2))
    assert.same(one, found(7))
  end)

  it("is the same by each set of kernels, to rounding", function()
    local program = [[
      local elements = require "spec.support.elements"
      local t = assert(elements.room(0.7):links { spacing = 0.5, rays = 16 })
      local lit = t:radiosity(nil, { bounces = 4 })
      io.write(("%.9g"):format(elements.integral(t:elements(), lit:irradiance(), 1)))]]
    local values = {}
    for _, isa in ipairs(ylm.info().kernels) do values[#values + 1] = by_kernels(isa, program)[1] end
    for _, x in ipairs(values) do near(x, values[1], 1e-5, "kernels") end
    assert.equal(#ylm.info().kernels, #values)
  end)

  it("and transfer vectors are means along links: of two bytes up to 65,535 elements, of four beyond, by each kernel", function()
    local program = [[
      local ylm = require "ylm"
      local rho = { 0.3, 0.6, 0.9 }
      local function quad(y, v) return ylm.quad { corner = { 0, y, v < 0 and 1 or 0 }, u = { 1, 0, 0 }, v = { 0, 0, v },
        sides = "front", material = ylm.matte { albedo = rho } } end
      local scene = ylm.scene "two squares" { geometry = { quad(0, -1), quad(0.4, 1) },
        lights = ylm.sphere_light { at = { 0.3, 0.2, 0.4 }, radius = 0.05, radiance = 10 } }
      for _, k in ipairs { 127, 128 } do
        local t = assert(scene:links { spacing = math.sqrt(2) / (k - 0.5), rays = 4, lmax = 4 })
        local n, links, worst = t.stats.elements, t:hits(), 0
        local E0 = t:radiosity(nil, { bounces = 0, light_samples = 4 }):irradiance()
        local E = t:radiosity(nil, { bounces = 1, light_samples = 4 }):irradiance()
        local T0, T = t:vectors { bounces = 0 }, t:vectors { bounces = 1 }
        for i = 1, n, 97 do
          for c = 1, 3 do
            local light, vector = 0, 0
            for j = 1, 4 do
              local to = links:get(i, j)
              if to <= n then
                light = light + rho[c] * E0:get(to, c) / 4
                vector = vector + rho[c] * T0:get(to, c, 17) / 4
              end
            end
            worst = math.max(worst, math.abs(E:get(i, c) - E0:get(i, c) - light) / (E:get(i, c) + 1),
              math.abs(T:get(i, c, 17) - T0:get(i, c, 17) - vector))
          end
        end
        print(n, t.stats.bytes / n, worst)
      end]]
    for _, isa in ipairs(ylm.info().kernels) do
      local few, of_few, two, many, of_many, four = (table.unpack or unpack)(by_kernels(isa, program)) -- luacheck: ignore
      assert.same({ 64516, 65536 }, { few, many })
      assert.is_true(two < 2e-6 and four < 2e-6, isa .. ": " .. two .. ", " .. four)
      assert.is_true(of_few < of_many, "bytes an element")
    end
  end)

  it("of light that leaves is albedo over pi times irradiance", function()
    local t = elements.room({ 0.2, 0.4, 0.6 }):links { spacing = 1, rays = 16 }
    local lit = t:radiosity()
    for c, rho in ipairs { 0.2, 0.4, 0.6 } do near(lit:leaving():get(1, c), lit:irradiance():get(1, c) * rho / pi, 1e-6) end
  end)

  it("sees no light without lights, and nothing without geometry", function()
    local t = elements.room(0.5):links { spacing = 1, rays = 16 }
    assert.equal(0, elements.integral(t:elements(), t:radiosity({}):irradiance(), 1))
    local empty = ylm.scene "empty" { lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 1 } }:links {}
    assert.equal(0, empty:radiosity().stats.emitted[1])
  end)

  it("notes glossy surfaces, and lamps nearer than elements are long", function()
    local glossy = elements.room(0.5, ylm.sphere { at = { 0, 0.5, 0 }, scale = 0.3, material = ylm.ggx { alpha = 0.3,
      f0 = 0.9 } },
      ylm.sphere_light { at = { 0, 0.2, 0.8 }, radius = 0.02, radiance = 10 })
    local t = glossy:links { spacing = 0.5, rays = 16 }
    assert(t.notes[1]:find "1 of 7 meshes gloss")
    local notes = table.concat(t:radiosity().notes, "\n")
    assert(notes:find "1 of 7 meshes gloss" and notes:find "less than spacing = 0.25 shows them", notes)
    local plain = elements.room(0.5):links { spacing = 0.1, rays = 16 }
    assert.is_nil(plain:radiosity().notes)
  end)
end)

describe("radiosity:update", function()
  local function at(x) return ylm.sphere_light { at = { x, 1, 0 }, radius = 0.1, radiance = 10 } end

  it("gives what a new radiosity gives, of lights of the scene and others", function()
    local room = elements.room(0.6, nil, { at(0) })
    local t = room:links { spacing = 0.5, rays = 32 }
    local lit = t:radiosity()
    lit:update { at(0.5), at(-0.5) }
    assert.same(t:radiosity({ at(0.5), at(-0.5) }):leaving():totable(), lit:leaving():totable())
    room.lights[1] = at(0.25)
    lit:update()
    assert.same(t:radiosity(at(0.25)):leaving():totable(), lit:leaving():totable())
  end)

  it("leaves what was known where it is cancelled", function()
    local cancel = false
    local t = elements.room(0.6):links { spacing = 0.5, rays = 32 }
    local lit = t:radiosity(nil, { progress = function() return not cancel end })
    local before = lit:leaving():totable()
    cancel = true
    assert.same({ nil, "cancelled", "ECANCELLED" }, { lit:update(at(0.5)) })
    assert.same(before, lit:leaving():totable())
    cancel = false
    assert(lit:update(at(0.5)))
    assert.is_true(lit:leaving():get(1, 1) ~= before[1][1])
  end)
end)

describe("direct light of elements", function()
  --- A room whose wall at x = 1 has a slit, and a wall within it from floor to ceiling; the floor is of two triangles.
  local function two_rooms()
    local grey, list = ylm.matte { albedo = 0.5 }, {}
    local function add(lo, hi) list[#list + 1] = ylm.box { bounds = { lo, hi }, material = grey } end
    add({ -1.2, -1.2, -1.2 }, { 1.2, -1, 1.2 })
    add({ -1.2, 1, -1.2 }, { 1.2, 1.2, 1.2 })
    add({ -1.2, -1, -1.2 }, { 1.2, 1, -1 })
    add({ -1.2, -1, 1 }, { 1.2, 1, 1.2 })
    add({ -1.2, -1, -1 }, { -1, 1, 1 })
    add({ 1, -1, -1 }, { 1.2, 0, 1 })
    add({ 1, 0.2, -1 }, { 1.2, 1, 1 })
    add({ -0.4, -1, -1 }, { -0.38, 1, 1 })
    return ylm.scene "two rooms" { geometry = list, lights = ylm.environment_light { radiance = 1 } }
  end

  --- The elements of a list of numbers i for which is(x, y, z, normal's x, normal's y).
  local function where(e, is)
    local out = {}
    for i = 1, #e.area do
      if is(e.centre:get(i, 1), e.centre:get(i, 2), e.centre:get(i, 3), e.normal:get(i, 1), e.normal:get(i, 2)) then
        out[#out + 1] = i
      end
    end
    return out
  end

  it("is averaged with the noise of links, where pictures see elements from near, and keeps its mean", function()
    local scene = dofile "spec/support/interiors.lua"(ylm)[3][2] -- a lamp in its shade: few links meet what is bright
    local function lit(rays, light_samples)
      local links = scene:links { spacing = 0.15, rays = rays, progress = false }
      local light = assert(links:radiosity(nil, { light_samples = light_samples }))
      return links, light, core.owned(light, "made").lib
    end
    local links, light, lib = lit(64, 64)
    local _, truth = lit(256, 128)
    local e, plain, averaged = links:elements(), light:leaving(), lib.radiosity_values(light, "averaged")
    local exact, sums, n = truth:leaving(), { 0, 0, 0, 0 }, 0
    for i = 1, #e.area do
      local x, a, b, w = exact:get(i, 2), plain:get(i, 2), averaged:get(i, 2), e.area:get(i)
      if x > 0 and math.abs(e.centre:get(i, 1)) < 2.01 and math.abs(e.centre:get(i, 3)) < 1.51 then
        sums[1], sums[2] = sums[1] + w * (a / x - 1) ^ 2, sums[2] + w * (b / x - 1) ^ 2
        sums[3], sums[4], n = sums[3] + w * a, sums[4] + w * b, n + 1
      end
    end
    assert.is_true(n > 3000 and sums[2] < 0.5 ^ 2 * sums[1], ("%.3f of the noise is left"):format(math.sqrt(sums[2] / sums[1])))
    assert.is_near(1, sums[4] / sums[3], 1e-3)
    assert.same(plain:totable(), light:leaving():totable())
  end)

  it("averages its noise over neighbours, but not past a wall, and keeps its mean", function()
    local t = two_rooms():links { spacing = 0.1, rays = 4 }
    local e, E, sums = t:elements(), {}, {}
    for k, light_samples in ipairs { 16, 16, 8, 8 } do -- places of 8 rays: one cannot tell its noise
      E[k] = t:radiosity(nil, { bounces = 0, light_samples = light_samples, seed = k }):irradiance()
      sums[k] = elements.integral(e, E[k], 1)
    end
    local facing = where(e, function(x, y, z, nx) return nx > 0.9 and x > -0.39 and x < -0.37 and math.abs(z) < 0.9
      and math.abs(y) < 0.9 end)
    local dark = where(e, function(x, y, z, _, ny) return ny > 0.9 and y == -1 and x < -0.45 and x > -1 and math.abs(z) < 1 end)
    assert(#facing > 300 and #dark > 100)
    local square, mean = { 0, 0 }, 0
    for _, i in ipairs(facing) do
      for k = 1, 2 do square[k] = square[k] + (E[2 * k - 1]:get(i, 1) - E[2 * k]:get(i, 1)) ^ 2 / 2 end
      mean = mean + E[1]:get(i, 1)
    end
    -- of two places the noise would be the root of half of one's
    assert(mean > 0 and square[1] < 0.25 * square[2] / 2, square[1] / square[2])
    near(sums[1] + sums[2], sums[3] + sums[4], 0.01, "all light")
    for _, i in ipairs(dark) do assert.equal(0, E[1]:get(i, 1)) end
  end)

  it("passes no wall that ends a millimetre above the floor: elements are wider than the wall", function()
    local grey = ylm.matte { albedo = 0.7 }
    local t = ylm.scene "a closet" {
      geometry = { ylm.box { bounds = { { -1, 0, -1 }, { 1, 1.5, 1 } }, sides = "back", material = grey },
        ylm.box { bounds = { { 0.4, 0.001, -0.999 }, { 0.44, 1.499, 0.999 } }, sides = "front", material = grey } },
      lights = ylm.sphere_light { at = { -0.5, 1, 0.2 }, radius = 0.1, radiance = 10 },
    }:links { spacing = 0.1, rays = 64 }
    local e, E = t:elements(), t:radiosity():irradiance()
    local sum, area = { 0, 0 }, { 0, 0 }
    for i = 1, #e.area do
      local x = e.centre:get(i, 1)
      local k = x > 0.44 and 2 or x < 0.4 and 1
      if k then sum[k], area[k] = sum[k] + E:get(i, 1) * e.area:get(i), area[k] + e.area:get(i) end
    end
    local part = sum[2] / area[2] / (sum[1] / area[1])
    assert(part < 2e-4, part)
  end)

  it("keeps the edges of shadows", function()
    local t = ylm.scene "an edge" {
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
        ylm.quad { corner = { -1, 0.5, 1 }, u = { 1, 0, 0 }, v = { 0, 0, -2 } } },
      lights = ylm.sun_light { direction = { 0.13, 1, 0 }, irradiance = 1 },
    }:links { spacing = 0.1, rays = 16 }
    local e, E = t:elements(), t:radiosity(nil, { bounces = 0 }):irradiance "direct"
    local edge, cosine = -0.065, 1 / math.sqrt(1 + 0.13 ^ 2) -- of the shadow, which crosses elements
    local beside = where(e, function(x, y, _, _, up)
      return up > 0 and y == 0 and math.abs(x - edge) > 0.1 and math.abs(x - edge) < 0.5
    end)
    assert(#beside > 300)
    for _, i in ipairs(beside) do assert.near(e.centre:get(i, 1) > edge and cosine or 0, E:get(i, 1), 0.01) end
  end)
end)

describe("a scene's own links", function()
  it("stands for options that are not given", function()
    local s = ylm.scene "own" { geometry = ylm.box {}, links = ylm.links { spacing = 0.5, rays = 32, seed = 3 } }
    local t = s:links()
    assert.same({ 0.5, 32 }, { t.stats.spacing, t.stats.links })
    assert.equal(64, s:links({ rays = 64 }).stats.links)
  end)
end)
