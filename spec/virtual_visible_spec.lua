-- virtual_lights:visible(scene): lights with the shadows of surfaces, as a light field.

local core = require "ylm.c.core"
local refused = require "spec.support.raises"
local relative = require "spec.support.vectors".relative
local ylm = require "ylm"

local block = ylm.box { at = { 0, 0, 0 }, scale = { 1, 1, 0.1 } }
local scene = ylm.scene "a block" { geometry = block }

--- Lights over the block and beside it, every other one without a normal; degree 0 or 2.
local function lights_of(n, degree, more)
  local o = { at = {}, normal = {}, emission = {}, radius = 0.05 }
  math.randomseed(4)
  for i = 1, n do
    o.at[i] = { 3 * math.random() - 1.5, 3 * math.random() - 1.5, 1 }
    o.normal[i] = i % 2 == 0 and { 0, 0, -1 } or { 0, 0, 0 }
    o.emission[i] = {}
    for c = 1, 3 do
      o.emission[i][c] = { 1 + c }
      for q = 2, (degree + 1) ^ 2 do o.emission[i][c][q] = math.random() - 0.5 end
    end
  end
  for key, value in pairs(more or {}) do o[key] = value end
  return ylm.virtual_lights(o), o
end

--- The lights of `o` that x sees past the block, whose half sizes are 0.5, 0.5, 0.05.
local function seen(o, x)
  local few = { at = {}, normal = {}, emission = {}, radius = o.radius, profile = o.profile }
  for i, y in ipairs(o.at) do
    local from, to = 0, 1 -- of the way from x to y within the block's three slabs
    for a, half in ipairs { 0.5, 0.5, 0.05 } do
      local d = y[a] - x[a]
      local s, t = (-half - x[a]) / d, (half - x[a]) / d
      from, to = math.max(from, math.min(s, t)), math.min(to, math.max(s, t))
    end
    if from >= to then
      local k = #few.at + 1
      few.at[k], few.normal[k], few.emission[k] = y, o.normal[i], o.emission[i]
    end
  end
  return ylm.virtual_lights(few), #few.at
end

describe("virtual_lights:visible", function()
  it("sums the lights that a point sees, with their derivatives, of any profile and degree", function()
    for _, case in ipairs { { 0 }, { 2 }, { 0, "cap" }, { 0, "point" } } do
      local lights, o = lights_of(60, case[1], { profile = case[2] })
      local field, some = lights:visible(scene), 0
      for _, x in ipairs { { 0.1, -0.2, -0.7 }, { 0.9, 0.3, -1.1 }, { 0.3, 0.1, 0.4 } } do
        local few, n = seen(o, x)
        some = some + (n > 0 and n < 60 and 1 or 0)
        local q = { dtype = "double", derivatives = 2 }
        local a, b = { ylm.light_field(4, field, { x }, q) }, { ylm.light_field(4, few, { x }, q) }
        for k = 1, 3 do assert(relative(a[k], b[k]) < 1e-12) end
      end
      assert.equal(2, some)
    end
  end)

  it("is the lights themselves where nothing is between, and darkness behind a wall", function()
    local lights = lights_of(50, 0)
    local field = lights:visible(scene)
    local above = { { 0.2, 0.3, 0.5 }, { -0.7, 0.1, 0.7 }, { 0, 0, 0.0501 } }
    assert(relative(ylm.light_field(3, field, above), ylm.light_field(3, lights, above)) < 1e-6)
    local wall = ylm.scene "a wall" { geometry = ylm.quad { corner = { -9, -9, 0 }, u = { 18, 0, 0 }, v = { 0, 18, 0 } } }
    assert(core.array_within(ylm.light_field(3, lights:visible(wall), { { 0, 0, -1 }, { 2, 0, -3 } }), 0))
    assert(core.array_within(ylm.light_field(3, ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }:visible(wall),
      { { 0, 0, 1 } }), 0))
  end)

  it("is what pictures by virtual lights sum with shadows = 'centre'", function()
    local room = ylm.scene "a floor" { geometry = { block, ylm.quad { corner = { -2, -2, -1 }, u = { 4, 0, 0 }, v = { 0, 4, 0 },
      material = ylm.matte { albedo = 1 } } }, camera = ylm.camera { from = { 0, -3, 0.5 }, at = { 0, 0, -1 }, fov = 60 } }
    local lights = lights_of(40, 0)
    local view = assert(room:prepare { size = { 12, 8 }, samples = 1 })
    local image = assert(view:render { by = "none", bounced = lights, virtual = { shadows = "centre" } })
    local points = view:points()
    local L = ylm.light_field(4, lights:visible(room), points.position)
    local E, compared = ylm.sh.irradiance(L, { 0, 0, 1 }), 0
    local position, radiance = image:layer "position":totable(), image:layer():totable()
    for i, x in ipairs(points.position:totable()) do
      if points.normal:get(i, 3) > 0.9 and x[3] < -0.9 then
        for y = 1, 8 do
          for k = 1, 12 do
            if position[y][k][1] == x[1] and position[y][k][2] == x[2] then
              assert.is_near(E:get(i, 2) / math.pi, radiance[y][k][2], 2e-4 * E:get(i, 2) + 1e-6)
              compared = compared + 1
            end
          end
        end
      end
    end
    assert.is_true(compared > 10, compared)
  end)

  it("has the same bits whatever the threads, counts pairs, and ends where progress says so", function()
    local field = lights_of(300, 0):visible(scene)
    local points = {}
    for i = 1, 200 do points[i] = { math.sin(i), math.cos(2 * i), math.sin(3 * i) } end
    local one, _, _, report = ylm.light_field(3, field, points, { threads = 1 })
    assert.equal(0, (core.array_distance(one, (ylm.light_field(3, field, points, { threads = 3 })))))
    assert.is_true(report.pairs > 1000 and report.pairs < 300 * 200)
    assert.same({ nil, "cancelled", "ECANCELLED" }, { ylm.light_field(3, field, points, { threads = 1,
      progress = function() return false end }) })
  end)

  it("stands beside other lights, is baked, and its grid is indirect light of pictures", function()
    local lights = lights_of(40, 0)
    local field, lamp = lights:visible(scene), ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.1, radiance = 5 }
    local x = { { 0.1, 0.3, -0.7 } }
    local both = ylm.light_field(2, { field, lamp }, x, { dtype = "double" })
    local sum = ylm.light_field(2, field, x, { dtype = "double" }) + ylm.light_field(2, lamp, x, { dtype = "double" })
    assert(relative(both, sum) < 1e-12)
    local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1.05 }, { 1, 1, 0.95 } }, cells = 8, lmax = 2 }, field))
    assert.equal("indirect", (core.field_quantity(grid)))
    local room = ylm.scene "lit" { geometry = { block, ylm.quad { corner = { -1, -1, -1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } } },
      lights = lamp, camera = ylm.camera { from = { 0, -2, 0.5 }, at = { 0, 0, -1 } } }
    local view = assert(room:prepare { size = { 6, 4 }, samples = 1 })
    local direct, more = assert(view:render {}), assert(view:render { bounced = grid })
    assert.is_true(more:layer():sum() > direct:layer():sum())
    refused("rays, which see nothing of a ylm.visible", function() view:render { lights = field } end)
  end)

  it("keeps scene and lights, and says what it is and that it is closed", function()
    local field = lights_of(3, 0):visible(scene)
    collectgarbage()
    collectgarbage()
    assert.equal('ylm.visible: 3 virtual lights with the shadows of scene "a block"', tostring(field))
    assert.equal(scene, field.scene)
    assert.equal(3, field.lights.count)
    refused("cannot set 'lights'", function() field.lights = 1 end)
    field:close()
    field:close()
    assert.equal("ylm.visible (closed)", tostring(field))
    refused("closed", function() ylm.light_field(1, field, { { 0, 0, 1 } }) end)
  end)

  it("refuses what is no scene, near parts, and points that are not finite", function()
    local lights = lights_of(3, 0)
    refused("a scene expected, got nil", function() lights:visible() end)
    refused("a scene expected, got a table", function() lights:visible {} end)
    local _, near = lights:split { core = 1 }
    refused("near parts are summed where they are needed", function() near:visible(scene) end)
    refused("virtual lights expected before the colon", function() lights.visible(scene, scene) end)
    refused("row 2 is not finite", function() ylm.light_field(1, lights:visible(scene), { { 0, 0, 1 }, { 0 / 0, 0, 0 } }) end)
    refused("range of float", function()
      ylm.light_field(1, ylm.virtual_lights { at = { { 0, 0, 1 } }, radius = 1e-9, intensity = 1e300 }:visible(scene),
        { { 0, 0, 2 } })
    end)
  end)
end)
