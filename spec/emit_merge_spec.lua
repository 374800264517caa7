-- scene:virtual_lights { merge = }: many particles, few lights, the same power; and lights of lamps that move.

local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local grey = ylm.matte { albedo = { 0.7, 0.5, 0.3 } }
local eye = ylm.camera { from = { 0.9, 0, 0.9 }, at = { -1, -0.5, -1 }, fov = 70 }

--- A box with a ball in it, lit from `at`.
local function room(at, material)
  return ylm.scene "a room" { camera = eye,
    geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
      ylm.sphere { at = { -0.3, -0.6, -0.3 }, radius = 0.4, material = material or grey } },
    lights = ylm.sphere_light { at = at or { 0.3, 0.7, 0.1 }, radius = 0.1, radiance = { 10, 8, 6 } } }
end

local function near(wanted, got, tolerance, what)
  assert.is_true(math.abs(got - wanted) <= tolerance * math.abs(wanted), ("%s: %.9g, wanted %.9g"):format(what or "", got,
    wanted))
end

local function numbers(lights)
  local all = {}
  for i, a in ipairs { lights:arrays() } do all[i] = a:totable() end
  return all
end

local function gathered(scene, lights)
  local view = scene:prepare { size = { 16, 10 }, samples = 1, gloss = "matte" }
  return assert(view:render { by = "none", bounced = lights, layers = false }):layer "radiance"
end

--- The root mean square of a difference over that of `b`.
local function apart(a, b)
  local off, all = 0, 0
  for i = 1, a.shape[1] do
    for j = 1, a.shape[2] do
      for c = 1, 3 do off, all = off + (a:get(i, j, c) - b:get(i, j, c)) ^ 2, all + b:get(i, j, c) ^ 2 end
    end
  end
  return math.sqrt(off / all)
end

describe("merged lights", function()
  it("have the power that all landings reflect, colour by colour, and no more lights than are wanted", function()
    for _, o in ipairs { { merge = 40 }, { merge = true, count = 300 }, { merge = 300, bounces = 2 } } do
      local lights, r = room():virtual_lights(with(o, { particles = 8000 }))
      for c = 1, 3 do near(r.power.reflected[c], lights.power[c], 1e-6, "colour " .. c) end
      assert.is_true(lights.count <= (o.count or o.merge) and lights.count > 0.4 * (o.count or o.merge), lights.count)
      assert.equal(lights.count, r.lights)
      local landings = 0
      for _, n in ipairs(r.bounces) do landings = landings + n end
      assert.equal(landings, r.merged.landings)
    end
    local _, r = room():virtual_lights { merge = 100 }
    assert.equal(5000, r.particles)
  end)

  it("are sums on flat surfaces, with the normal of these and no shift", function()
    local floor = ylm.scene "a floor" { geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 },
      material = grey }, lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 1 } }
    local lights, r = floor:virtual_lights { merge = 50, particles = 4000 }
    local at, normal, radius, _, shift = lights:arrays()
    assert.is_true(lights.count > 25)
    for i = 1, lights.count do
      assert.is_true(math.abs(at:get(i, 2)) < 1e-6 and math.abs(normal:get(i, 2) - 1) < 1e-12)
      assert.equal(0, shift:get(i))
    end
    -- a square of side h has the spread h^2/6
    near(r.merged.cell * 1.5 * math.sqrt(1 / 3), r.radius.median, 0.15, "radius")
    assert.is_true(radius:get(1) > 0)
  end)

  it("stand for curved surfaces by shifts: power, and the mean of directions", function()
    local ball = ylm.scene "a ball" { geometry = ylm.sphere { radius = 1, material = grey },
      lights = ylm.environment_light { radiance = 1 } }
    local lights, r = ball:virtual_lights { merge = 30, particles = 6000 }
    local _, normal, _, emission, shift = lights:arrays()
    local most = 0
    for i = 1, lights.count do
      local s, I = shift:get(i), emission:get(i, 1, 1) / math.sqrt(4 * math.pi)
      most = math.max(most, s)
      -- the mean of directions, by power, over that of Lambert's law: (1 - s/2) is the mean of normals' length
      local n, rings = { normal:get(i, 1), normal:get(i, 2), normal:get(i, 3) }, 400
      local power, along = 0, 0
      for k = 1, rings do
        local z = -1 + 2 * (k - 0.5) / rings
        local E = math.max(0, s + z) * I * 2 * math.pi * 2 / rings
        power, along = power + E, along + E * z
      end
      near(2 / 3 * (1 - s / 2), along / power, 1e-3, "light " .. i)
      near(1, n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2, 1e-12, "normal")
    end
    assert.is_true(most > 0.05 and most < 0.5, most)
    near(r.power.reflected[2], lights.power[2], 1e-6)
  end)

  it("of glossy surfaces are fitted, and keep the power", function()
    local scene = room(nil, ylm.ggx { alpha = 0.5, f0 = { 0.9, 0.6, 0.3 } })
    local lights, r = scene:virtual_lights { merge = 60, particles = 3000, degree = 2 }
    assert.equal(2, lights.degree)
    for c = 1, 3 do near(r.power.reflected[c], lights.power[c], 1e-6, "colour " .. c) end
    local all = gathered(scene, (scene:virtual_lights { particles = 3000, degree = 2 }))
    assert.is_true(apart(gathered(scene, lights), all) < 0.12)
  end)

  it("come nearer to all particles' light than as many that are chosen", function()
    local scene = room()
    local truth = gathered(scene, (scene:virtual_lights { count = 20000, seed = 7 }))
    local merged = apart(gathered(scene, (scene:virtual_lights { merge = 300, particles = 20000 })), truth)
    local chosen = apart(gathered(scene, (scene:virtual_lights { count = 300, particles = 20000 })), truth)
    assert.is_true(merged < 0.7 * chosen and merged < 0.06, merged .. " " .. chosen)
  end)

  it("of a bulge are above it: rays to them meet no surface of their own", function()
    local function scene(albedo)
      return ylm.scene "a ball in a box" { camera = eye, lights = room().lights,
        geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = albedo } },
          ylm.sphere { at = { 0.1, -0.3, 0.1 }, radius = 0.4, material = grey } } }
    end
    local view = scene(0.5):prepare { size = { 16, 10 }, samples = 1 }
    for _, n in ipairs { 20, 60, 200 } do
      local lights, sums = scene(0):virtual_lights { merge = n, particles = 20000 }, {}
      for k, shadows in ipairs { "none", "centre" } do
        local layer = view:render({ by = "none", bounced = lights, virtual = { shadows = shadows },
          layers = false }):layer "radiance"
        sums[k] = 0
        for i = 1, 10 do for j = 1, 16 do sums[k] = sums[k] + layer:get(i, j, 2) end end
      end
      assert.is_true(sums[2] > 0.95 * sums[1], n .. " " .. sums[2] / sums[1])
    end
  end)

  it("are the same lights whatever the number of threads", function()
    local scene, first = room(), nil
    for _, threads in ipairs { 1, 2, 7 } do
      local all = numbers((scene:virtual_lights { merge = 100, particles = 3000, bounces = 2, threads = threads }))
      first = first or all
      assert.same(first, all)
    end
  end)

  it("are of cells that are given, however many there are", function()
    local lights, r = room():virtual_lights { merge = true, particles = 4000, cell = 0.25 }
    assert.equal(0.25, r.merged.cell)
    assert.is_true(lights.count > 200 and lights.count < 1500, lights.count)
    local one = room():virtual_lights { merge = 1, particles = 500 }
    assert.is_true(one.count <= 6)
  end)

  it("refuse what contradicts itself", function()
    local scene = room()
    local function says(pattern, o) refused(pattern, function() scene:virtual_lights(o) end) end
    says("merge = 5 and count = 6 say the same", { merge = 5, count = 6 })
    says("merge must be true, false, or a number of lights", { merge = "all" })
    says("merge must be", { merge = 0 })
    says("cell is of lights that are merged: merge = true", { cell = 1 })
    says("cell must be a number > 0", { merge = true, cell = 0 })
    says("cell must be at least 1e%-09, 1e%-9 of the farthest surface from the origin", { merge = true, cell = 1e-12 })
    says("particles %(10%) must be at least as many as count", { merge = 20, particles = 10 })
    says("merge is of particles", { merge = true, distribution = "grid" })
  end)
end)

describe("lights of a lamp that moves", function()
  local steps = {}
  setup(function() for k = 0, 3 do steps[k + 1] = room { 0.3 + 0.01 * k, 0.7, 0.1 } end end)

  it("go with it, all but few that come to meet another surface", function()
    local before, jumps, moved = nil, 0, 0
    for _, scene in ipairs(steps) do
      local at = scene:virtual_lights({ particles = 2000 }):arrays():totable()
      for i, p in ipairs(before or {}) do
        local d = math.sqrt((p[1] - at[i][1]) ^ 2 + (p[2] - at[i][2]) ^ 2 + (p[3] - at[i][3]) ^ 2)
        if d > 0.15 then jumps = jumps + 1 else moved = moved + d end
      end
      before = at
    end
    assert.is_true(jumps < 0.02 * 6000, jumps)
    assert.is_true(moved / 6000 > 0.002 and moved / 6000 < 0.03, moved / 6000)
  end)

  it("change a picture as the lamp does, not as other particles would", function()
    for _, o in ipairs { { count = 500 }, { merge = 200, particles = 20000, cell = 0.35 } } do
      local a = gathered(steps[1], (steps[1]:virtual_lights(o)))
      local step = apart(gathered(steps[2], (steps[2]:virtual_lights(o))), a)
      local other = apart(gathered(steps[2], (steps[2]:virtual_lights(with(o, { seed = 2 })))), a)
      assert.is_true(step < 0.5 * other, step .. " " .. other)
    end
  end)

  it("are what examples/14_moving_bounce.lua shows", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/14_moving_bounce.lua --out %s --width 36 --height 24 --samples 1 "
      .. "--frames 3 --particles 8000 --lights 200"):format(os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    local picture = folder:read "bounce_03.png"
    folder:remove()
    assert.equal(0, status, out)
    local own, others = out:match "jitter ([%d.]+) %%, with other particles ([%d.]+) %%"
    assert.is_true(tonumber(own) < 0.6 * tonumber(others), out)
    assert.equal("\137PNG", picture:sub(1, 4))
  end)
end)
