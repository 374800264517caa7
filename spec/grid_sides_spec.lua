--- Grids that know walls: sides, the light at places on them, files; and adaptive_grid { measure = "irradiance" }.

local core = require "ylm.c.core"
local ylm = require "ylm"
local long = require "spec.support.long"
local irradiance = require "spec.support.irradiance"
local turned = require "spec.support.turned"
local walls = require "spec.support.walls"

local box = walls.box

--- A description with what a case changes.
local function adaptive(changes)
  local form = { bounds = box, lmax = 1, depth = 4, tolerance = 0.05 }
  for name, value in pairs(changes or {}) do form[name] = value end
  return ylm.adaptive_grid(form)
end

--- A wall beyond the box on all sides, and a scene of it.
local wall = ylm.quad { corner = { -2, -2, walls.height }, u = { 4, 0, 0 }, v = { 0, 4, 0 } }
local walled = ylm.scene "a wall" { geometry = { wall }, lights = walls.lamp }

describe("measure", function()
  it("is of coefficients by default for lights, and of irradiance where light jumps at surfaces", function()
    local lit = ylm.bake(adaptive(), walls.lamp, { occupied = walls.points(8) })
    assert.equal("coefficients", lit.measure)
    assert.equal("lights", lit.quantity)
    assert.is_false(lit.sides)
    local shadowed = ylm.bake(adaptive(), walls.field, { occupied = walls.points(8), quantity = "direct" })
    assert.equal("irradiance", shadowed.measure)
    assert.equal("irradiance", shadowed.stats.measure)
    assert.equal("direct", shadowed.quantity)
    assert.is_false(shadowed.sides) -- nobody tells where its walls are
  end)

  it("says the error of irradiance at every occupied point, against an independent sum", function()
    local rows = walls.points(13) -- fewer than are held out: all of them judge
    local grid = ylm.bake(adaptive { measure = "irradiance" }, walls.lamp, { occupied = rows })
    local points, normals = {}, {}
    for i, row in ipairs(rows) do
      points[i], normals[i] = { row[1], row[2], row[3] }, { row[4], row[5], row[6] }
    end
    local errors = irradiance.errors(grid:sample(points), ylm.light_field(1, walls.lamp, points), normals)
    local largest, failed = 0, 0
    for _, e in ipairs(errors) do
      largest = math.max(largest, e)
      if e > 0.05 then failed = failed + 1 end
    end
    assert.equal(1, grid.stats.confidence)
    assert.is_true(math.abs(grid.stats.largest_error - largest) < 1e-4 * largest + 1e-6)
    assert.equal(failed, grid.stats.failed)
    assert.is_true(grid.stats.met)
  end)

  it("is of what a camera sees, of more points than are held out", function()
    local seen = ylm.scene "a wall that is seen" { geometry = { wall }, lights = walls.lamp,
      camera = ylm.camera { from = { 0.3, 0.2, walls.height + 3 }, at = { 0, 0, walls.height }, up = { 0, 1, 0 }, fov = 40 } }
    local grid = assert(seen:bake { occupied = "camera", size = { 64, 48 }, samples = 1, quantity = "direct", judge = "field",
      probes = ylm.adaptive_grid { lmax = 1, depth = 4, tolerance = 0.02 } })
    assert.is_true(grid.sides)
    assert.is_true(grid.stats.verified >= 2048)
  end)

  it("takes normals of surfaces, of both of their sides", function()
    local grid = ylm.bake(adaptive { tolerance = 0.1 }, walls.field, { geometry = wall, quantity = "direct", scene = walled })
    assert.equal("irradiance", grid.measure)
    assert.is_true(grid.sides)
    assert.is_true(grid.stats.met, tostring(grid.stats.warning))
  end)

  it("does not depend on threads", function()
    local one = ylm.bake(adaptive(), walls.field, { occupied = walls.points(9), quantity = "all", threads = 1 })
    local three = ylm.bake(adaptive(), walls.field, { occupied = walls.points(9), quantity = "all", threads = 3 })
    assert.equal(core.grid_encode(one), core.grid_encode(three))
  end)
end)

--- Light that is linear on each side of a plane through the box, of degree 0: f(points, ..) and its value at a point of a side.
local function two_sided(normal, height)
  local function value(p, above)
    return above and 8 + p[1] - 0.5 * p[2] + 0.25 * p[3] or 0.5 + 0.05 * p[1] + 0.02 * p[2] - 0.03 * p[3]
  end
  local slope = { [true] = { 1, -0.5, 0.25 }, [false] = { 0.05, 0.02, -0.03 } }
  local function is_above(p) return p[1] * normal[1] + p[2] * normal[2] + p[3] * normal[3] > height end
  return function(points)
    local n = #points
    local L, dL = ylm.zeros({ n, 1, 1 }, points.dtype), ylm.zeros({ n, 1, 1, 3 }, points.dtype)
    for i = 1, n do
      local p = points[i]
      local above = is_above(p)
      L:set(i, 1, 1, value(p, above))
      for a = 1, 3 do dL:set(i, 1, 1, a, slope[above][a]) end
    end
    return L, dL
  end, value
end

--- n places of a wall within the box, on both of its sides in turn: points, normals.
local function places_of(normal, u, v, height, n)
  local points, normals, k = {}, {}, 0
  while #points < n do
    k = k + 1
    local x, y, inside, p = 4 * (k * 0.618034 % 1) - 2, 4 * (k * 0.754878 % 1) - 2, true, {}
    for a = 1, 3 do
      p[a] = height * normal[a] + x * u[a] + y * v[a]
      inside = inside and math.abs(p[a]) < 0.95
    end
    if inside then
      local side = #points % 2 * 2 - 1
      points[#points + 1], normals[#points + 1] = p, { side * normal[1], side * normal[2], side * normal[3] }
    end
  end
  return points, normals
end

--- A quad through a wall's plane, beyond the box.
local function quad_of(normal, u, v, height)
  local corner = {}
  for a = 1, 3 do corner[a] = height * normal[a] - 3 * u[a] - 3 * v[a] end
  return ylm.quad { corner = corner, u = { 6 * u[1], 6 * u[2], 6 * u[3] }, v = { 6 * v[1], 6 * v[2], 6 * v[3] } }
end

local uniform = ylm.uniform_grid { bounds = walls.box, cells = { 5, 4, 6 }, lmax = 0, channels = "luminance" }

describe("sides", function()
  it("keep light that is linear on each side of a wall, at 20 turns: no part of one side's reaches the other", function()
    for i = 1, 20 do
      local height, normal, u, v = 0.03, turned(i)
      local field, value = two_sided(normal, height)
      local scene = ylm.scene "a wall" { geometry = { quad_of(normal, u, v, height) }, lights = walls.lamp }
      local grid = ylm.bake(uniform, field, { quantity = "indirect", scene = scene })
      local points, normals = places_of(normal, u, v, height, 60)
      for _, seen in ipairs { scene, false } do
        local L = grid:sample(points, { normals = normals, scene = seen or nil })
        for k, p in ipairs(points) do
          local wanted = value(p, normals[k][1] * normal[1] + normals[k][2] * normal[2] + normals[k][3] * normal[3] > 0)
          assert.is_true(math.abs(L:get(k, 1, 1) - wanted) < 1e-5 * 8, ("turn %d, place %d, %s: %.6f, %.6f"):format(i, k,
            seen and "by rays" or "by pieces", L:get(k, 1, 1), wanted))
        end
      end
    end
  end)

  it("change no number where there are no walls", function()
    local far = ylm.scene "far away" { geometry = { ylm.quad { corner = { 50, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } } },
      lights = walls.lamp }
    local function light(points, lmax) return ylm.light_field(lmax, walls.lamp, points, { derivatives = 1 }) end
    local form = ylm.uniform_grid { bounds = walls.box, cells = { 5, 4, 6 }, lmax = 2 }
    local plain, with = ylm.bake(form, light), ylm.bake(form, light, { quantity = "indirect", scene = far })
    assert.is_true(with.sides)
    assert.equal(0, with.stats.parts)
    local points, _ = places_of({ 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, 0.2, 50)
    local a, b = plain:sample(points, { interpolation = "linear" }), with:sample(points)
    for i = 1, #points do
      for k = 1, 9 do assert.is_true(math.abs(a:get(i, 2, k) - b:get(i, 2, k)) < 1e-6 * a:get(i, 2, 1)) end
    end
  end)

  it("of thin walls are as good as of thick ones: down to a thousandth of a voxel", function()
    for _, thick in ipairs { 0.2, 0.02, 2e-4 } do
      local slab = ylm.box { bounds = { { -2, -2, walls.height - thick }, { 2, 2, walls.height } } }
      local scene = ylm.scene "a slab" { geometry = { slab }, lights = walls.lamp }
      local field, value = two_sided({ 0, 0, 1 }, walls.height - thick / 2)
      local grid = ylm.bake(uniform, field, { quantity = "indirect", scene = scene })
      local points, normals = places_of({ 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, walls.height, 40)
      for i = 1, 40 do if normals[i][3] < 0 then points[i][3] = points[i][3] - thick end end
      local L = grid:sample(points, { normals = normals, scene = scene })
      for i, p in ipairs(points) do
        assert.is_true(math.abs(L:get(i, 1, 1) - value(p, normals[i][3] > 0)) < 1e-4, thick)
      end
    end
  end)

  it("keep a tolerance beside a wall of one quad", function()
    local grid = ylm.bake(adaptive(), walls.field, { occupied = walls.points(16), quantity = "direct", scene = walled })
    assert.is_true(grid.stats.met, tostring(grid.stats.warning))
    assert.is_true(grid.stats.points < 700, grid.stats.points)
  end)

  it("are the same for any number of threads, and in files", function()
    local o = { occupied = walls.points(9), quantity = "all", scene = walled }
    local bytes
    for threads = 1, 3 do
      o.threads = threads
      local grid = ylm.bake(adaptive(), walls.field, o)
      bytes = bytes or core.grid_encode(grid)
      assert.equal(bytes, core.grid_encode(grid))
    end
    local grid, loaded = ylm.bake(adaptive(), walls.field, o), core.grid_decode(bytes)
    assert.equal(bytes, core.grid_encode(loaded))
    for _, name in ipairs { "points", "parts", "ghosts", "crossed_leaves" } do
      assert.equal(grid.stats[name], loaded.stats[name], name)
    end
    assert.is_true(loaded.sides)
    local points, normals = places_of({ 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, walls.height, 50)
    local q = { normals = normals, scene = walled }
    assert.same(grid:sample(points, q):totable(), loaded:sample(points, q):totable())
    grid:update(function(p, lmax, channels) -- twice the light at the same points, ghosts too
      local L, dL, lambda = walls.field(p, lmax, channels)
      return L * 2, dL * 2, lambda
    end)
    local once, twice = loaded:sample(points, q), grid:sample(points, q)
    for i = 1, #points do assert.near(2 * once:get(i, 1, 1), twice:get(i, 1, 1), 1e-5 * twice:get(i, 1, 1)) end
    assert.is_false(grid.stats.met)
  end)

  it("end at a budget of points, and say so", function()
    local o = { occupied = walls.points(24), quantity = "direct", scene = walled }
    local before = ylm.on_warning(false)
    local grid = ylm.bake(adaptive { tolerance = 0.004, points = 700, depth = 6 }, walls.field, o)
    ylm.on_warning(before)
    assert.is_true(grid.stats.points > 500 and grid.stats.points <= 770, grid.stats.points)
    assert.is_true(grid.stats.spent)
    assert.truthy(grid.stats.warning:find("its points are spent; leave points out", 1, true), grid.stats.warning)
    local ok, message = pcall(ylm.bake, adaptive { points = 300 }, walls.lamp)
    assert.is_false(ok)
    assert.truthy(message:find("points are a budget beside a tolerance of grids with sides", 1, true), message)
  end)

  it("of damaged files are refused", function()
    local bytes = core.grid_encode(ylm.bake(adaptive { depth = 3 }, walls.field, { occupied = walls.points(4), quantity = "all",
      scene = walled }))
    local random = 7
    for _ = 1, 60 do
      random = random * 16807 % 2147483647
      local at = 65 + random % (#bytes - 65)
      local broken = bytes:sub(1, at - 1) .. string.char((bytes:byte(at) + 1) % 256) .. bytes:sub(at + 1)
      local grid, message = core.grid_decode(broken)
      assert.is_nil(grid)
      assert.is_string(message)
    end
  end)

  it("are asked for by normals, and by what a scene sees; others are told apart by name", function()
    local grid = ylm.bake(uniform, (two_sided({ 0, 0, 1 }, walls.height)), { quantity = "indirect", scene = walled })
    local lamps = ylm.bake(ylm.uniform_grid { bounds = walls.box, cells = 2, lmax = 1 }, walls.lamp)
    local p = { { 0.1, 0.2, walls.height } }
    local function refuses(says, g, o)
      local ok, message = pcall(g.sample, g, p, o)
      assert.is_false(ok)
      assert.truthy(message:find(says, 1, true), message)
    end
    refuses('normals and scene are for a grid with sides, this one of "lights" light has none', lamps,
      { normals = { { 0, 0, 1 } } })
    refuses("normals: row 1 is not finite", grid, { normals = { { 0, 0 / 0, 1 } } })
    refuses("normals: one for each of 1 points expected, got 2", grid, { normals = { { 0, 0, 1 }, { 0, 0, 1 } } })
    refuses("scene: a scene or a prepared view expected", grid, { scene = "walls" })
    local above, none = grid:sample(p, { normals = { { 0, 0, 3 } } }), grid:sample(p, { normals = { { 0, 0, 0 } } })
    assert.is_true(above:get(1, 1, 1) > 7)
    assert.is_true(none:get(1, 1, 1) == above:get(1, 1, 1) or none:get(1, 1, 1) < 1)
  end)

  it("of meshes that are no solid bodies end, with finite light", function()
    local function mesh(vertices, triangles) return ylm.mesh { vertices = vertices, triangles = triangles } end
    local function strip(n, wide)
      local vertices, triangles = {}, {}
      for i = 0, n do
        vertices[#vertices + 1], vertices[#vertices + 2] = { 2 * i / n - 1, 0.1, -0.8 }, { 2 * i / n - 1, 0.1 + wide, 0.9 }
        if i > 0 then
          triangles[#triangles + 1], triangles[#triangles + 2] = { 2 * i - 1, 2 * i, 2 * i + 1 }, { 2 * i, 2 * i + 2, 2 * i + 1 }
        end
      end
      return mesh(vertices, triangles)
    end
    local quad = { { -0.7, -0.7, 0.03 }, { 0.7, -0.7, 0.03 }, { 0.7, 0.7, 0.03 }, { -0.7, 0.7, 0.03 } }
    local fan = {}
    for k = 0, 6 do fan[#fan + 1] = { math.cos(k), math.sin(k), 0.4 - 0.1 * k } end
    fan[#fan + 1], fan[#fan + 2] = { 0, 0, -0.9 }, { 0, 0, 0.9 }
    local hostile = {
      hole = mesh(quad, { { 1, 2, 3 } }), twice = mesh(quad, { { 1, 2, 3 }, { 1, 3, 4 }, { 1, 2, 3 }, { 3, 2, 1 } }),
      needles = strip(60, 1e-4), point = mesh({ quad[1], quad[2], quad[3], { 0.1, 0.1, 0.1 } }, { { 4, 4, 4 }, { 1, 2, 3 } }),
      ["non-manifold"] = mesh(fan, { { 8, 9, 1 }, { 8, 9, 2 }, { 8, 9, 3 }, { 8, 9, 4 }, { 8, 9, 5 }, { 8, 9, 6 }, { 8, 9, 7 } }),
      ["inside out"] = mesh({ { -0.8, -0.8, -0.8 }, { 0.8, -0.7, -0.7 }, { 0, 0.8, -0.6 }, { 0, 0, 0.7 } },
        { { 1, 2, 3 }, { 1, 4, 2 }, { 2, 4, 3 }, { 3, 4, 1 } }),
    }
    local points, normals = places_of({ 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, 0.03, 60)
    for name, shape in pairs(hostile) do
      local scene = ylm.scene(name) { geometry = { shape }, lights = walls.lamp }
      local before = ylm.on_warning(false)
      local grid = assert(ylm.bake(adaptive { depth = 3, tolerance = 0.3 }, walls.field, { geometry = shape, bounds = walls.box,
        quantity = "all", scene = scene }), name)
      ylm.on_warning(before)
      for _, seen in ipairs { scene, false } do
        local L = grid:sample(points, { normals = normals, scene = seen or nil })
        for i = 1, #points do assert.is_true(math.abs(L:get(i, 1, 1)) < 100, name) end
      end
      assert.is_string(core.grid_encode(grid))
    end
  end)

  it("of a room promise irradiance, and paths judge it", function()
    local room = ylm.scene "a room" { lights = ylm.sphere_light { at = { 0, 0.4, 0 }, radius = 0.15, radiance = 20 },
      geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.15 } },
        ylm.box { bounds = { { -0.06, -0.99, -0.5 }, { 0.06, 0.2, 0.99 } }, material = ylm.matte { albedo = 0.15 } } } }
    local links = room:links { spacing = 0.3, rays = 32 }
    local probes = ylm.adaptive_grid { lmax = 2, depth = 2, tolerance = 0.3 }
    local before = ylm.on_warning(false)
    local grid = assert(room:bake { quantity = "indirect", links = links, probes = probes })
    local stats = grid.stats
    if long(false, true) then
      local by_field = assert(room:bake { quantity = "indirect", links = links, probes = probes, judge = "field" })
      assert.equal(core.grid_encode(by_field):len(), core.grid_encode(grid):len())
      assert.is_nil(by_field.stats.paths)
      assert.equal(by_field.stats.error, stats.paths.field_error)
      assert.equal(by_field.stats.met, stats.paths.field_met)
    end
    ylm.on_warning(before)
    assert.equal(stats.error <= 0.3, stats.met)
    assert.is_true(stats.verified > 1500 and stats.failed >= stats.paths.undecided)
    -- other paths, at places that judged: as many exceed the error as it says
    local rows, points, normals = core.grid_judges(grid), {}, {}
    for i = 1, 150 do
      points[i] = { rows:get(i, 1), rows:get(i, 2), rows:get(i, 3) }
      normals[i] = { rows:get(i, 4), rows:get(i, 5), rows:get(i, 6) }
    end
    local E = room:probe { points = points, normals = normals, samples = 256, reflections = { 1, "all" }, seed = 77 }
    local L, mean, above = grid:sample(points, { normals = normals, scene = room }), 0, 0
    for i = 1, 150 do mean = mean + E:get(i, 2) / 150 end
    for i = 1, 150 do
      local e = irradiance.at(L, i, normals[i])[2]
      if math.abs(e - E:get(i, 2)) > (stats.error + 0.1) * math.max(mean, E:get(i, 2)) then above = above + 1 end
    end
    assert.is_true(above <= 4, above)
  end)

  it("are given up where progress says so", function()
    local given_up, last = 0, 8
    for most = 1, last do
      local calls = 0
      local grid, message, code = ylm.bake(adaptive(), walls.field, { occupied = walls.points(16), quantity = "direct",
        scene = walled, progress = function() calls = calls + 1 return calls < most end })
      if not grid then
        given_up = given_up + 1
        assert.same({ "cancelled", "ECANCELLED" }, { message, code })
      end
    end
    assert.is_true(given_up > 0)
  end)
end)
