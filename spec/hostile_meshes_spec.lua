-- Meshes that are no solid bodies: scene:surface_grid and grids with sides end, with light that is finite, or refuse by name.

local ylm = require "ylm"
local quietly = require "spec.support.quietly"
local hostile = require "spec.support.hostile_meshes"
local long = require "spec.support.long"

local lamp = ylm.sphere_light { at = { 0.3, 0.9, 0.6 }, radius = 0.1, radiance = 10 }
local grey = ylm.matte { albedo = 0.5 }
local alone = {}
for name in pairs(hostile.meshes) do alone[#alone + 1] = name end
table.sort(alone)

--- A mesh of a scene; `more`: fields beside vertices and triangles.
local function mesh(shape, more)
  local form = { vertices = shape.vertices, triangles = shape.triangles, material = grey }
  for key, value in pairs(more or {}) do form[key] = value end
  return ylm.mesh(form)
end

local function is_light(x) return x >= 0 and x < math.huge end

--- Bakes a surface grid of a scene and checks its numbers.
local function light_surfaces(name, scene, quantity)
  local light = quietly(function()
    return assert(scene:surface_grid { tolerance = 0.5, judge = "field", corners = 100, rays = 16, quantity = quantity,
      links = scene:links { spacing = 1, rays = 16 } })
  end)
  local corners, values = light:rectangles()
  for i = 1, light.stats.rectangles do
    for c = 1, 4 do
      for k = 1, 3 do
        assert.is_true(is_light(values:get(i, c, k)), name)
        assert.is_true(math.abs(corners:get(i, c, k)) < math.huge, name)
      end
    end
  end
  assert.is_true(light.stats.error >= 0 and is_light(light.stats.rms), name)
  return light
end

local function lamps(points, lmax, channels)
  local L, dL, _, report = ylm.light_field(lmax, lamp, points, { derivatives = 1, metric = "luminance",
    channels = channels == 3 and "rgb" or "luminance" })
  return L, dL, report.lambda
end

--- Bakes a grid with sides of a scene's meshes, and checks the light at some places.
local function light_space(name, scene, probes)
  local grid = quietly(function()
    return assert(ylm.bake(probes, lamps, { geometry = scene.geometry, bounds = { { -2, -2, -2 }, { 2, 2, 2 } },
      quantity = "all", scene = scene }))
  end)
  local points, normals = {}, {}
  for i = 1, 60 do
    points[i], normals[i] = { math.sin(7 * i), math.sin(5 * i), math.sin(3 * i) }, { math.cos(i), math.sin(i), 0 }
  end
  for _, seen in ipairs { scene, false } do
    local L = grid:sample(points, { normals = normals, scene = seen or nil })
    for i = 1, #points do assert.is_true(math.abs(L:get(i, 1, 1)) < 100, name) end
  end
  return grid
end

--- A room with all hostile meshes in it, or with the named one alone.
local function room(only)
  local geometry = { ylm.box { scale = 4, material = grey } }
  for k, name in ipairs(alone) do
    if not only or only == name then
      geometry[#geometry + 1] = mesh(hostile.meshes[name], { at = only and { 0, 0, 0 }
        or { k % 3 - 1, math.floor(k / 3) % 3 - 1, 0.3 * k % 1 - 0.5 } })
    end
  end
  return ylm.scene "a room of hostile meshes" { geometry = geometry, lights = lamp }
end

describe("meshes that are no solid bodies", function()
  it("get finite light on their surfaces", function()
    light_surfaces("all", room(), "indirect")
    for _, name in ipairs(long({ "point" }, alone)) do
      for _, geometry in ipairs { room(name).geometry, { mesh(hostile.meshes[name]) } } do
        light_surfaces(name, ylm.scene(name) { geometry = geometry, lights = lamp }, "all")
      end
    end
  end)

  it("get finite light in grids with sides", function()
    light_space("all", room(), ylm.adaptive_grid { lmax = 2, depth = 4, tolerance = 0.3 })
    for _, name in ipairs(long({}, alone)) do
      light_space(name, room(name), ylm.uniform_grid { lmax = 1, cells = 6 })
    end
  end)

  it("of very many triangles in one voxel end in little time and memory", function()
    local many = mesh(hostile.cluster(long(6000, 1000000)), { sides = "front" })
    local scene = ylm.scene "a cluster" { geometry = { ylm.box { scale = 4, material = grey }, many }, lights = lamp }
    local light = light_surfaces("cluster", scene, "indirect")
    assert.is_true(light.stats.charts <= 18, light.stats.charts)
    local grid = light_space("cluster", scene, ylm.uniform_grid { lmax = 1, cells = 6 })
    assert.is_true(grid.stats.points < 3000, grid.stats.points)
  end)

  it("as large as floats go have corners all the same", function()
    local huge = { vertices = {}, triangles = { { 1, 3, 2 }, { 1, 4, 3 }, { 1, 2, 5 } } }
    for i, v in ipairs { { -1, 0, -1 }, { 1, 0, -1 }, { 1, 0, 1 }, { -1, 0, 1 }, { 0, 1, 0 } } do
      huge.vertices[i] = { 1e37 * v[1], 1e37 * v[2], 1e37 * v[3] }
    end
    local scene = ylm.scene "huge" { geometry = mesh(huge), lights = ylm.environment_light { radiance = 1 } }
    local light = quietly(function()
      return assert(scene:surface_grid { tolerance = 0.5, judge = "field", quantity = "all", corners = 100 })
    end)
    local _, values = light:rectangles()
    for i = 1, light.stats.rectangles do
      for c = 1, 4 do assert.is_true(is_light(values:get(i, c, 1))) end
    end
  end)

  it("are refused by name where a vertex is no number", function()
    for _, x in ipairs { 0 / 0, math.huge, -math.huge, 1e39 } do
      local ok, message = pcall(ylm.mesh, { vertices = { { 0, 0, 0 }, { x, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } })
      assert.is_false(ok)
      assert.truthy(message:find("mesh", 1, true) and message:find("is not finite", 1, true), message)
    end
    local ok, message = pcall(ylm.mesh, { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 4 } } })
    assert.is_false(ok)
    assert.truthy(message:find "4", message)
  end)
end)
