-- The promise of scene:surface_grid, at places that no judge has seen, and by many seeds of the judge. `make check-long
-- LONG=long` takes 10,000 places of four scenes, and 200 seeds.

local ylm = require "ylm"
local quietly = require "spec.support.quietly"
local long = require "spec.support.long"
local promise = require "spec.support.surface_promise"
local judged = require "spec.support.judged_places"
local rule = require "ylm.render.promise"
local scenes = require "spec.support.walled_scenes"

local PROMISED = 0.01

local function room()
  return ylm.scene "a parted room" { lights = ylm.sphere_light { at = { 0.5, 0.4, 0 }, radius = 0.15, radiance = 20 },
    geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
      ylm.box { bounds = { { -0.04, -0.99, -0.99 }, { 0.04, 0.3, 0.6 } }, material = ylm.matte { albedo = 0.6 } } } }
end

--- The answers of a surface grid at places.
local function answers(light, places)
  local E, told = light:irradiance(ylm.array(places.points), ylm.array(places.normals, "float")), {}
  for i = 1, #places.points do told[i] = { E:get(i, 1), E:get(i, 2), E:get(i, 3) } end
  return told
end

describe("the promise of a surface grid", function()
  local scene = room()
  local links = scene:links { rays = 64, spacing = long(0.25, 0.15) }

  it("is refuted by as many false ones as the binomial distribution says", function()
    assert.equal(6, promise.allowed(200, 0.01)) -- 7 or more: 0.5 %, 6 or more: 1.6 %
    assert.equal(1, promise.allowed(10, 0.01))
    assert.equal(0, promise.allowed(1, 0.01))
  end)

  --- Checks a grid that paths have judged at n places of its own.
  local function holds(name, s, of, quantity, tolerance, n, most)
    local light = quietly(function()
      return assert(s:surface_grid { tolerance = tolerance, quantity = quantity, links = of })
    end)
    assert.is_true(light.stats.met, ("%s: %g"):format(name, light.stats.error))
    local places = promise.draw(light, of:radiosity(), n, 4242)
    local failed, open = promise.hold(s, places, quantity, tolerance, 256, most)
    assert.equal(n, #places.points)
    assert.is_true(failed <= promise.allowed(n, PROMISED), ("%s: %d of %d places fail"):format(name, failed, n))
    assert.is_true(failed + #open <= math.max(0.02, PROMISED) * n, ("%s: %d are hidden by noise"):format(name, #open))
  end

  it("holds at places that no judge has seen", function()
    holds("a parted room", scene, links, "indirect", long(0.5, 0.2), long(200, 10000), long(1024, 65536))
    for _, entry in ipairs(long({}, scenes)) do
      if entry.name == "rooms" or entry.name == "court" or entry.name == "ball" then
        local s = entry.make(ylm)
        holds(entry.name, s, s:links { rays = 256 }, entry.quantity, 0.1, 10000, 65536)
      end
    end
  end)

  it("is false for as few seeds of its judge as its confidence says", function()
    local tolerance, seeds = long(0.3, 0.1), long(2, 200)
    local function baked(seed)
      return quietly(function()
        return assert(scene:surface_grid { tolerance = tolerance, links = links, judge = "field", seed = seed })
      end)
    end
    local lit, said, wrong = links:radiosity(nil, { light_samples = 64 }), 0, {}
    local first = baked(1)
    local places = promise.draw(first, lit, long(200, 4000), 777)
    promise.by_elements(places, lit, "indirect", long(768, 12288))
    for seed = 1, seeds do
      local light = seed == 1 and first or baked(seed)
      local share = promise.share(places, tolerance, answers(light, places))
      if light.stats.met then said = said + 1 end
      if light.stats.met and share > PROMISED then wrong[#wrong + 1] = seed end
      light:close()
    end
    assert.is_true(said >= seeds / 2, ("%d of %d keep it"):format(said, seeds))
    assert.is_true(#wrong <= promise.allowed(seeds, PROMISED), ("false for seeds %s"):format(table.concat(wrong, " ")))
  end)

  it("allows as many failures as its confidence says, of places that are kept falsely once in ten", function()
    assert.same({ -1, 0, 8, 23 }, { rule.allowed(500), rule.allowed(600), rule.allowed(2048), rule.allowed(4096) })
    local random, falsely, n = math.random, 0, long(4000, 100000)
    math.randomseed(5)
    for _ = 1, n do -- a place that misses by nothing: a random walk, looked at whenever its steps have doubled
      local sum, steps, kept = 0, 0, false
      for look = 8, 16 do
        local more = 2 ^ look - steps
        local normal = math.sqrt(-2 * math.log(1 - random())) * math.cos(2 * math.pi * random())
        sum, steps = sum + math.sqrt(more) * normal, 2 ^ look
        kept = kept or sum < -rule.sure_to_keep(steps) * math.sqrt(steps)
      end
      falsely = falsely + (kept and 1 or 0)
    end
    local share, spread = falsely / n, math.sqrt(0.1 * 0.9 / n)
    assert.is_true(share < 0.1 + 2.6 * spread and share > 0.05, share)
  end)

  it("is false as seldom where paths are noisy, and is given where all places keep it", function()
    local seeds, n, false_ones = long(4, 200), long(600, 2048), 0
    for seed = 1, seeds do
      if judged(seed, n, PROMISED, 0.2).error <= 0.2 then false_ones = false_ones + 1 end
    end
    assert.is_true(false_ones <= promise.allowed(seeds, 0.01), false_ones)
    local said = judged(1, n, 0, 0.2)
    assert.is_true(said.error <= 0.2 and said.least <= said.error, said.error)
    assert.is_true(said.paths < 2048 * n, said.paths) -- they end where they may
  end)

  it("is not given where few places can be judged", function()
    local vertices, triangles = {}, {}
    for i = 0, 59 do -- cards that cover each other
      for _, c in ipairs { { -0.4, -0.4 }, { 0.4, -0.4 }, { 0.4, 0.4 }, { -0.4, 0.4 } } do
        vertices[#vertices + 1] = { c[1], 1e-4 * i, c[2] }
      end
      triangles[2 * i + 1], triangles[2 * i + 2] = { 4 * i + 1, 4 * i + 2, 4 * i + 3 }, { 4 * i + 1, 4 * i + 3, 4 * i + 4 }
    end
    local cards = ylm.scene "cards" { lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 20 },
      geometry = ylm.mesh { vertices = vertices, triangles = triangles, crease = 1 } }
    local light = quietly(function()
      return assert(cards:surface_grid { tolerance = 0.5, judge = "field", quantity = "all", corners = 16,
        links = cards:links { rays = 16, spacing = 0.5 } })
    end)
    assert.is_true(light.stats.verified > 0 and light.stats.verified < 459, light.stats.verified)
    assert.is_false(light.stats.met)
    assert.equal(math.huge, light.stats.error)
    assert.truthy(light.stats.warning:find "too few to judge by")
  end)
end)
