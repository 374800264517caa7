-- scene:inverse_lighting and ylm.minimise: lamps that are found for light that is asked for.

local office = require "spec.support.office"
local vary = require "ylm.inverse.vary"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local function near(wanted, got, within, what)
  assert.is_true(math.abs(wanted - got) <= within, ("%s: %.9g wanted, %.9g"):format(what, wanted, got))
end

--- Rosenbrock's function of n numbers.
local function valley(x)
  local f, g = 0, {}
  for i = 1, #x do g[i] = 0 end
  for i = 1, #x - 1 do
    local a, b = x[i + 1] - x[i] ^ 2, 1 - x[i]
    f, g[i], g[i + 1] = f + 100 * a * a + b * b, g[i] - 400 * a * x[i] - 2 * b, g[i + 1] + 200 * a
  end
  return f, g
end

local function start(n)
  local x = {}
  for i = 1, n do x[i] = i % 2 == 1 and -1.2 or 1 end
  return x
end

describe("minimise", function()
  it("finds the end of Rosenbrock's valley, and of one that bounds cut off", function()
    local x, r = ylm.minimise(valley, start(20), { evaluations = 2000, tolerance = 1e-16 })
    near(0, r.value, 1e-15, "without bounds")
    near(1, x[20], 1e-7, "its place")
    assert.are.equal(r.evaluations, #r.trace)
    x, r = ylm.minimise(valley, start(60), { evaluations = 2000, tolerance = 1e-16, upper = 0.5 })
    near(57.08965665, r.value, 1e-7, "with bounds")
    for i = 1, 60 do assert.is_true(x[i] <= 0.5) end
  end)

  it("keeps numbers at bounds where the value falls beyond, and others where their slope is 0, to 1e-8", function()
    local function bowl(x)
      local f, g = 0, {}
      for i = 1, #x do
        local d = x[i] - (i - 3)
        f, g[i] = f + i * d * d / 2, i * d
      end
      for i = 2, #x do f, g[i], g[i - 1] = f + 0.2 * x[i] * x[i - 1], g[i] + 0.2 * x[i - 1], g[i - 1] + 0.2 * x[i] end
      return f, g
    end
    local x, r = ylm.minimise(bowl, { 0, 0, 0, 0, 0 }, { lower = { -1, -1, -1, -1, -1 }, upper = { 1, 1, 1, 1, 1 } })
    local _, g = bowl(x)
    for i = 1, 5 do
      local held = x[i] == 1 and g[i] < 0 or x[i] == -1 and g[i] > 0
      assert.is_true(held or math.abs(g[i]) < 1e-8, ("%d: %g, %g"):format(i, x[i], g[i]))
    end
    assert.are.equal(r.ended, "flat")
  end)

  it("ends when it is told to, and hands on what the function says", function()
    local calls = 0
    local x, r = ylm.minimise(valley, start(4), { progress = function() calls = calls + 1 return calls < 3 end })
    assert.are.equal(r.ended, "cancelled")
    assert.is_true(#x == 4 and r.evaluations == 4)
    local ok, message, code = ylm.minimise(function() return nil, "the lamp is out", "EIO" end, { 1 })
    assert.are.same({ ok == nil, message, code }, { true, "the lamp is out", "EIO" })
    r = select(2, ylm.minimise(valley, start(4), { evaluations = 5 }))
    assert.is_true(r.ended == "evaluations" and r.evaluations == 5)
  end)
end)

--- A room with a slab in it, and lamps at these places.
local function room(places, o)
  local lights, lamp = {}, ylm.photometry { cosine = 2, lumens = 2000, watts = 20 }
  for i, at in ipairs(places) do
    lights[i] = ylm.photometric_light { photometry = lamp, at = at, name = "lamp " .. i, dim = o and o.dim,
      opening = { shape = "disk", radius = 0.1 }, to = o and o.to }
  end
  return ylm.scene "a room" { lights = lights, geometry = {
    ylm.box { bounds = { { -3, 0, -2 }, { 3, 2.8, 2 } }, material = ylm.matte { albedo = 0.5 } },
    ylm.box { bounds = { { -0.05, 0, -1 }, { 0.05, 1.4, 1 } }, material = ylm.matte { albedo = 0.4 } } } }
end

local DESK = { at = { 0, 0.75, 0 }, size = { 5, 3 } }
local BOX = { { -2.8, 0, -1.8 }, { 2.8, 2.8, 1.8 } }

--- A lamp twice as bright along C0 as across.
local function oval()
  return ylm.photometry { lumens = 2000, opening = { shape = "disk", radius = 0.1 }, intensity = function(gamma, c)
    return math.max(0, math.cos(gamma)) ^ 3 * (3 + math.cos(2 * c))
  end }
end

describe("numbers that vary", function()
  local AT, TO = { 0.4, 2.2, 0.2 }, { 0.2, 0.3, 0.1 }

  it("have the slopes of differences, for every kind of light", function()
    local lights = {
      ylm.photometric_light { photometry = oval(), at = AT, to = TO, turn = 20, temperature = 4500 },
      ylm.photometric_light { photometry = oval(), at = { -1, 2.2, 0.5 } },
      ylm.sphere_light { at = { 1, 2, 0 }, radius = 0.1, radiance = { 3e4, 2e4, 1e4 }, photometric = true },
      ylm.disk_light { at = AT, normal = { 0, -1, 0 }, radius = 0.1, radiance = { 1e4, 2e4, 1e4 }, photometric = true },
      ylm.polygon_light { vertices = { { 0, 2, 0 }, { 0.2, 2, 0 }, { 0.2, 2.1, 0.2 } }, radiance = 1e4, photometric = true },
      ylm.spot_light { at = AT, to = TO, angle = 120, blend = 0.8, intensity = 400, photometric = true },
      ylm.sun_light { direction = { 0.3, 1, 0.2 }, angle = 10, irradiance = { 300, 200, 100 }, photometric = true },
      ylm.environment_light { radiance = { 10, 20, 30 }, photometric = true },
    }
    local box = { { -2, 0, -2 }, { 2, 3, 2 } }
    local plan = vary.plan({
      { lights = 1, position = { "x" }, within = box, dim = { 0, 2 }, turn = { -90, 90 }, temperature = { 2700, 6500 },
        size = { 0.5, 2 } },
      { lights = { 2, 3 }, colour = { 0, 1e5 } }, { lights = 3, position = { "y" }, within = box, size = { 0.5, 2 } },
      { lights = 4, dim = { 0, 3 }, size = { 0.5, 2 } }, { lights = 5, direction = 60, size = { 0.5, 2 } },
      { lights = 6, direction = 60, dim = { 0, 3 } }, { lights = 7, direction = 30, dim = { 0, 2 } },
      { lights = 8, dim = { 0, 2 } } }, lights)
    local floor = ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = ylm.matte { albedo = 0.5 } }
    local t = ylm.scene "a floor" { geometry = floor, lights = lights }:links { spacing = 1, rays = 16, lmax = 0 }
    local r = t:receivers { points = { { 0, 0.3, 0 }, { 0.7, 0.3, 0.4 } }, rays = 16 }
    local x, weights = vary.starts(plan), { { 0.3, 0.5, 0.9 }, { 0.6, 0.2, 0.1 } }
    for i, n in ipairs(plan.numbers) do
      if n.name == "direction" or n.name == "size" then x[i] = x[i] + 0.1 end
    end
    local function at(y)
      local lit = t:radiosity(vary.lights(plan, y), { derivatives = true, bounces = 1 })
      return lit:importance { { r, weights = weights } }
    end
    local d, lists = at(x):derivatives(), {}
    for _, name in ipairs { "position", "direction", "turn", "dim", "colour", "channels", "factor" } do
      lists[name] = d[name]:totable()
    end
    local g = vary.gradient(plan, lists, x)
    assert.are.equal(25, #g)
    for i, n in ipairs(plan.numbers) do
      local h = 0.01 * math.max(1, x[i])
      local y = vary.starts(plan)
      for k = 1, #x do y[k] = x[k] end
      y[i] = x[i] + h
      local more = at(y).value
      y[i] = x[i] - h
      local wanted = (more - at(y).value) / (2 * h)
      near(wanted, g[i], 0.003 * math.abs(wanted) + 1e-3 / h, ("light %d, %s"):format(n.lamps[1], n.name))
    end
  end)

  it("are refused by the name of the light that does not have them", function()
    local lights = { ylm.spot_light { at = AT, to = TO, photometric = true },
      ylm.environment_light { radiance = 1, photometric = true },
      ylm.sphere_light { at = AT, photometric = true }, ylm.photometric_light { photometry = oval(), at = AT, opening = "point" },
      ylm.textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, image = { { 1 } }, photometric = true } }
    local box = { { -2, 0, -2 }, { 2, 3, 2 } }
    for _, case in ipairs {
      { { lights = 1, position = { "x" }, within = box }, "light 1 is a point: the shadow of a point has no derivative" },
      { { lights = 2, direction = 20 }, "light 2 is a environment_light, whose direction does not vary" },
      { { lights = 3, direction = 20 }, "light 3 is a sphere_light, whose direction does not vary" },
      { { lights = 3, turn = { 0, 9 } }, "light 3 has no turn: only photometric lights have one" },
      { { lights = 3, temperature = { 3000, 4000 } }, "light 3 is no photometric light, and has no temperature" },
      { { lights = 4, size = { 1, 2 } }, "light 4 is a point: give it an opening" },
      { { lights = 5, dim = { 0, 1 } }, "light 5 is a textured_light, whose dim does not vary" },
      { { lights = 4, dim = { 0, 1 }, colour = { 0, 1 } }, "colour holds the level too" },
      { { lights = 3, colour = { 0, -1 } }, "colour must be { least, most }, from 0 on" },
      { { lights = 4, temperature = { 500, 4000 } }, "temperature must be { least, most }, from 1001 to 24999" },
    } do
      local ok, message = pcall(vary.plan, { case[1] }, lights)
      assert.is_true(not ok and message:find(case[2], 1, true) ~= nil, message)
    end
    local ok, message = pcall(vary.plan, { { lights = 3, dim = { 0, 1 } }, { lights = 3, colour = { 0, 1 } } }, lights)
    assert.is_true(not ok and message:find("light 3 varies by dim and by colour: give one", 1, true) ~= nil, message)
    ok, message = pcall(vary.plan, { { lights = 3, dim = { 0, 1 } }, { dim = { 0, 1 }, lights = { 3, 4 } } }, lights)
    assert.is_true(not ok and message:find("dim of light 3 varies twice", 1, true) ~= nil, message)
  end)
end)

describe("inverse lighting", function()
  it("finds colours by a picture in colour, and the turn of an oval lamp", function()
    local scene = room { { -1, 2.5, 0 }, { 1, 2.5, 0 } }
    local rows = {} -- red on the left, blue on the right
    for r = 1, 4 do
      rows[r] = {}
      for c = 1, 8 do rows[r][c] = { 1 - (c - 0.5) / 8, 0.3, (c - 0.5) / 8 } end
    end
    local plan, r = scene:inverse_lighting { vary = { { colour = { 0, 4 } } }, judge = 0, spacing = 1, price = "none",
      targets = { { plane = DESK, image = rows, colour = true, mean = { least = 100, most = 120 } } } }
    assert.is_true(r.evaluations == 1 and r.met and r.targets[1].rms < 0.8 * r.targets[1].before.rms, tostring(r))
    local left, right = plan.lights[1].rgb, plan.lights[2].rgb
    assert.is_true(left[1] > 2 * left[3] and right[3] > 2 * right[1])
    local function turned(turn)
      return ylm.scene "turned" { geometry = scene.geometry,
        lights = ylm.photometric_light { photometry = oval(), at = { 0.5, 2.5, 0 }, turn = turn, temperature = 4000 } }
    end
    local links = turned(50):links { spacing = 1, rays = 32, lmax = 0 }
    local wanted = links:receivers({ plane = DESK, rays = 64 }):irradiance(links:radiosity(turned(50).lights,
      { derivatives = true }))
    plan, r = turned(10):inverse_lighting { price = "none", judge = 0, spacing = 1, rays = 32, receiver_rays = 64,
      vary = { { turn = { -20, 90 }, temperature = { 2700, 6500 } } },
      targets = { { plane = DESK, wanted = wanted, colour = true } } }
    assert.is_true(r.targets[1].rms < 0.02 and r.targets[1].before.rms > 0.05, tostring(r))
    near(50, plan.lights[1].turn, 2, "its turn")
    near(4000, plan.lights[1].temperature, 150, "its temperature")
  end)

  it("keeps lamps apart, and plans suns and skies by their level", function()
    local plan = room({ { -0.1, 2.5, 0 }, { 0.1, 2.5, 0 } }):inverse_lighting { judge = 0, spacing = 1, apart = 1.5,
      vary = { { position = { "x" }, within = BOX } }, targets = { { plane = DESK, mean = { least = 1 } } } }
    near(1.5, math.abs(plan.lights[2].at[1] - plan.lights[1].at[1]), 0.02, "their distance")
    local open = ylm.scene "outside" { geometry = ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
      lights = { ylm.sun_light { direction = { 0, 1, 0 }, photometric = true },
        ylm.environment_light { radiance = 1, photometric = true } } }
    local r
    plan, r = open:inverse_lighting { vary = { { lights = 1, dim = { 0, 1e5 } }, { lights = 2, dim = { 0, 1e5 } } },
      targets = { { points = { { 0, 0, 0 } }, mean = { least = 1000, most = 1010 } } }, judge = 256, spacing = 1 }
    assert.is_true(r.met and r.evaluations == 1, tostring(r))
    local folder = scratch.new()
    assert(plan:save(folder.path .. "/outside.lua"))
    local back = assert(ylm.load(folder.path .. "/outside.lua"))
    near(plan.lights[1].irradiance[1], back.lights[1].irradiance[1], 0, "the sun")
    near(plan.lights[2].scale, back.lights[2].scale, 0, "the sky")
    folder:remove()
  end)

  it("meets a mean and a uniformity by paths, from lamps that crowd, and says so", function()
    local scene = room { { -2, 2.6, -1 }, { -1.8, 2.6, 1 }, { -1.4, 2.6, -0.4 }, { -1, 2.6, 0.8 } }
    local plan, r = scene:inverse_lighting {
      vary = { { lights = "lamp", position = { "x", "z" }, within = BOX, dim = { 0, 3 } } },
      targets = { { plane = DESK, mean = { least = 300 }, uniformity = 0.6 } }, judge = 2048, spacing = 0.8 }
    local t = r.targets[1]
    assert.is_true(r.met and t.met and t.judged == "paths", tostring(r))
    assert.is_true(t.mean >= 300 and t.uniformity >= 0.6 and t.before.uniformity < 0.3)
    assert.is_true(r.evaluations <= 40 and #plan.trace == r.evaluations)
    for i, l in ipairs(plan.lights) do
      assert.is_true(l.at[1] >= -2.8 and l.at[1] <= 2.8 and l.at[3] >= -1.8 and l.at[3] <= 1.8 and l.at[2] == 2.6)
      assert.is_true(l.dim >= 0 and l.dim <= 3 and l.name == "lamp " .. i)
    end
    local E = plan.scene:probe { points = { { 1, 0.75, 0.3 } }, normals = { { 0, 1, 0 } }, samples = 256 }
    assert.is_true(E:get(1, 2) > 150)
  end)

  it("finds levels alone by one solution of each lamp, with the least light", function()
    local scene = room { { -1.5, 2.6, -1 }, { -1.5, 2.6, 1 }, { 1.5, 2.6, -1 }, { 1.5, 2.6, 1 } }
    local plan, r = scene:inverse_lighting { vary = { { dim = { 0, 2 } } }, price = "watts",
      targets = { { plane = DESK, mean = 250, name = "desks" } }, judge = 1024, spacing = 0.8 }
    assert.is_true(r.met and r.evaluations == 1, tostring(r))
    near(250, r.targets[1].mean, 8, "no more than is asked for")
    assert.are.equal(r.targets[1].name, "desks")
    near(r.watts / r.lumens, 20 / 2000, 1e-9, "watts")
    local half = plan.scene:inverse_lighting { vary = { { dim = { 0, 2 }, together = true } }, spacing = 0.8, judge = 0,
      targets = { { plane = DESK, mean = { most = 125 } } } }
    for i = 2, 4 do assert.are.equal(half.lights[i].dim, half.lights[1].dim) end
  end)

  it("finds lamps again by the light that they made, by place and by direction", function()
    local scene = room { { -1, 2.5, 0.3 }, { 1.2, 2.5, -0.5 } }
    local links = scene:links { spacing = 0.8, rays = 32, lmax = 0 }
    local desk = links:receivers { plane = DESK, rays = 64 }
    local wanted = desk:illuminance(links:radiosity(scene.lights, { derivatives = true }))
    local moved = ylm.scene "moved" { like = scene,
      moved = { [1] = { at = { -1.4, 2.5, 0 } }, [2] = { at = { 0.8, 2.5, -0.2 } } } }
    local links2 = moved:links { spacing = 0.8, rays = 32, lmax = 0 }
    local plan, r = moved:inverse_lighting { links = links2, price = "none", judge = 0, evaluations = 30,
      vary = { { position = { "x", "z" }, within = BOX } },
      targets = { { receivers = links2:receivers { plane = DESK, rays = 64 }, wanted = wanted } } }
    assert.is_true(r.targets[1].rms < 0.02 and r.targets[1].before.rms > 0.15, tostring(r))
    for i, l in ipairs(plan.lights) do
      for a = 1, 3 do near(scene.lights[i].at[a], l.at[a], 0.05, "lamp " .. i) end
    end
    local leaning = room({ { -1, 2.5, 0.3 }, { 1.2, 2.5, -0.5 } }, { to = { 0, 0, 0 } })
    plan, r = leaning:inverse_lighting { price = "none", judge = 0, evaluations = 30, spacing = 0.8, rays = 32, seed = 1,
      receiver_rays = 64, vary = { { direction = 60 } }, targets = { { plane = DESK, wanted = wanted } } }
    assert.is_true(r.targets[1].rms < 0.06 and r.targets[1].before.rms > 0.15, tostring(r))
    near(-1, plan.lights[1].axis[2], 0.05, "straight down again")
  end)

  it("says what it cannot reach, and the bounds that hold it", function()
    local scene = room { { 0, 2.6, 0 } }
    local _, r = scene:inverse_lighting { vary = { { dim = { 0, 1 } } }, targets = { { plane = DESK, mean = { least = 5000 } } },
      judge = 64, spacing = 1 }
    assert.is_false(r.met)
    assert.matches("light 1 %(lamp 1%): dim at 1", r.active[1])
    assert.is_true(#r.targets[1].hardest == 3 and r.targets[1].hardest[1].illuminance <= r.targets[1].hardest[3].illuminance)
  end)

  it("is the same for any number of threads", function()
    local function of(threads)
      local plan = room({ { -1, 2.6, 0 }, { 1, 2.6, 0 } }):inverse_lighting { threads = threads, evaluations = 4, judge = 0,
        spacing = 1, receiver_rays = 64, vary = { { position = { "x" }, within = BOX } },
        targets = { { plane = DESK, uniformity = 0.9 } } }
      return plan.lights[1].at[1]
    end
    assert.are.equal(of(1), of(3))
  end)

  it("saves a scene file that loads, with its lamps", function()
    local folder = scratch.new()
    local plan = room({ { -1, 2.6, 0 }, { 1, 2.6, 0 } }):inverse_lighting { vary = { { dim = { 0, 2 } } }, judge = 0, spacing = 1,
      targets = { { plane = DESK, mean = { least = 200 } } } }
    local ok, files = plan:save(folder.path .. "/planned.lua")
    assert.is_true(ok and #files == 3)
    local back = assert(ylm.load(folder.path .. "/planned.lua"))
    assert.are.equal(#back.lights, 2)
    for i, l in ipairs(back.lights) do
      assert.are.same(l.at, plan.lights[i].at)
      assert.are.equal(l.dim, plan.lights[i].dim)
      near(2000, l.photometry.lumens, 0.2, "its photometry")
    end
    local points = { points = { { 1, 0.75, 0.3 } }, normals = { { 0, 1, 0 } }, samples = 512 }
    near(plan.scene:probe(points):get(1, 2), back:probe(points):get(1, 2), 3, "light")
  end)

  it("draws maps before and after", function()
    local plan = room({ { -1, 2.6, 0 } }):inverse_lighting { vary = { { dim = { 0, 9 } } }, judge = 0, spacing = 1,
      targets = { { plane = DESK, mean = { least = 200 } } } }
    assert.matches("figure", tostring(plan:figure { width = 80 }))
    assert.matches("ylm.plan of \"a room\": 1 lights, met", tostring(plan))
    local moved = room({ { -1, 2.6, 0 } }):inverse_lighting { judge = 0, spacing = 1, evaluations = 3,
      vary = { { position = { "x" }, within = { { -2, 0, 0 }, { 2, 3, 0 } } } },
      targets = { { plane = DESK, mean = { least = 200 } } } }
    assert.is_true(#moved.trace > 1) -- curves have room for their words on the narrowest maps
    local folder = scratch.new()
    assert(moved:figure { width = 64 }:save(folder.path .. "/plan.png"))
    folder:remove()
  end)

  it("takes an image as what a plane shall look like, brightness aside", function()
    local scene = room { { -1, 2.6, 0 }, { 1, 2.6, 0 } }
    local _, r = scene:inverse_lighting { vary = { { dim = { 0, 2 } } }, judge = 0, spacing = 1, price = "none",
      targets = { { plane = DESK, image = { { 1, 0 } } } } }
    assert.is_true(r.targets[1].rms < r.targets[1].before.rms, tostring(r))
  end)

  it("is a command, which plans what a scene file asks for, and refuses one that names a picture's file", function()
    local folder = scratch.new()
    local run = tool.runner(folder)
    local function file(name, target)
      return scratch.quote(folder:write(name, ([[
        return scene "asked" { geometry = box { scale = 4 },
          lights = sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 100, photometric = true },
          inverse_lighting = { vary = { { dim = { 0, 9 } } },
            targets = { { plane = { at = { 0, -1, 0 }, size = { 2, 2 } }, %s } } } }
      ]]):format(target)))
    end
    local out, status, err = run("inverse_lighting " .. file("a.lua", "mean = 2") .. " --judge 64 --json -o "
      .. scratch.quote(folder.path .. "/planned.lua"))
    assert.equal(0, status, err)
    assert.matches('"met": ?true', out)
    assert.are.equal(1, #assert(ylm.load(folder.path .. "/planned.lua")).lights)
    out, status, err = run("inverse_lighting " .. file("b.lua", "image = '/etc/passwd'"))
    assert.is_true(status ~= 0 and err:find("in a scene file an image is numbers", 1, true) ~= nil, out .. err)
    out, status, err = run("inverse_lighting " .. scratch.quote(folder.path .. "/planned.lua"))
    assert.is_true(status ~= 0 and err:find("the scene has no table inverse_lighting", 1, true) ~= nil, out .. err)
    folder:remove()
  end)

  if require "spec.support.long"(false, true) then
    it("meets 500 lx and 0.6 by paths in the office with desks and partitions, within 40 evaluations", function()
      local lights = office.lamps(ylm, { box = { -5.5, 0.5, -3.5, 3.5 }, opening = { shape = "sphere", radius = 0.1 }, dim = 0.8,
        height = 2.8 })
      local _, r = office.scene(ylm, lights):inverse_lighting {
        vary = { { position = { "x", "z" }, within = { { -5.7, 0, -3.7 }, { 5.7, 3, 3.7 } }, dim = { 0, 1.5 } } },
        targets = { { plane = office.desk, mean = { least = 500 }, uniformity = 0.6 } } }
      assert.is_true(r.met and r.evaluations <= 40, tostring(r))
    end)
  end
end)
