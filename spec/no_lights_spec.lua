--- Darkness: an empty list of lights stands wherever lights stand, and is black.

local core = require "ylm.c.core"
local ylm = require "ylm"
local device = require "spec.support.gpu"

local box = { { -1, -1, -1 }, { 1, 1, 1 } }
local points = { { 0, 0.3, 0 }, { 0.5, -0.2, 0.1 }, { -0.9, 0.9, 0.4 } }
local black = { { 0, 0, 0 }, { 0, 0, 0 } }

local function texture(method)
  return ylm.textured_light { corner = { -1, 2, 0 }, u = { 2, 0, 0 }, v = { 0, 1, 0 }, image = black, method = method }
end

local nothing = {
  ["an empty list"] = {},
  ["sphere_lights of empty tables"] = ylm.sphere_lights { at = {}, radius = {}, radiance = {} },
  ["sphere_lights of empty arrays"] = ylm.sphere_lights { at = ylm.zeros({ 0, 3 }, "double"),
    radius = ylm.zeros({ 0 }, "double"), radiance = ylm.zeros({ 0, 3 }, "double") },
  ["lists of nothing"] = { {}, ylm.sphere_lights { at = {} }, { {} } },
  ["a black image as spheres"] = texture "spheres",
}

local grids = {
  uniform = function(dynamic) return ylm.uniform_grid { bounds = box, cells = 3, lmax = 2, dynamic = dynamic } end,
  ["by a relative threshold"] = function(dynamic)
    return ylm.adaptive_grid { bounds = box, depth = 4, lmax = 2, threshold = 1, dynamic = dynamic }
  end,
  ["by an absolute threshold of 0"] = function(dynamic)
    return ylm.adaptive_grid { bounds = box, depth = 4, lmax = 3, threshold = 0, metric = "absolute", dynamic = dynamic }
  end,
  ["by a tolerance"] = function(dynamic)
    return ylm.adaptive_grid { bounds = box, depth = 4, lmax = 2, tolerance = 0.01, dynamic = dynamic }
  end,
}

--- The largest absolute number in an array.
local function largest(a)
  local _, _, norm = core.array_distance(a, a)
  return norm
end

local function assert_dark(...)
  for i = 1, select("#", ...) do assert.equal(0, largest((select(i, ...)))) end
end

describe("no lights", function()
  for name, lights in pairs(nothing) do
    it("have a light field, all zero: " .. name, function()
      for _, tolerance in ipairs { false, 0.01 } do
        local L, dL, ddL, report = ylm.light_field(3, lights, points, { derivatives = 2, metric = "rgb",
          tolerance = tolerance or nil })
        assert.same({ 3, 3, 16 }, L.shape)
        assert.same({ 3, 3, 16, 3 }, dL.shape)
        assert.same({ 3, 3, 16, 6 }, ddL.shape)
        assert_dark(L, dL, ddL, report.lambda, report.norm, report.inside)
        assert.equal(0, report.pairs)
      end
    end)
  end

  it("have a light field where a black image has exact parts, too", function()
    local L, _, ddL = ylm.light_field(2, { texture "exact", {} }, points, { derivatives = 2 })
    assert.same({ 3, 3, 9 }, L.shape)
    assert_dark(L, ddL)
    assert.equal(0, texture "exact".count)
  end)

  it("are a neutral element of a list of lights", function()
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radiance = { 3, 2, 1 } }
    local list = { {}, lamp }
    for _, lights in pairs(nothing) do list[#list + 1] = lights end
    local alone, together = ylm.light_field(3, lamp, points), ylm.light_field(3, list, points)
    assert.equal(0, (core.array_distance(alone, together)))
  end)

  for name, make in pairs(grids) do
    it("bake to a grid with nothing in it, which is sampled and saved: " .. name, function()
      for _, dynamic in ipairs { false, true } do
        local grid = assert(ylm.bake(make(dynamic), {}, { occupied = points }))
        assert.equal(grid.kind == "uniform" and 3 or 1, grid.stats.leaves)
        assert.equal(0, grid.stats.pairs)
        if grid.tolerance then assert.is_true(grid.stats.met and grid.stats.error == 0) end
        local c, dc = grid:sample(points, { derivatives = 1 })
        assert.same({ 3, 3, (grid.lmax + 1) ^ 2 }, c.shape)
        assert_dark(c, dc, grid:points().value)
        local file = os.tmpname() .. ".ylm"
        assert(grid:save(file))
        assert_dark((ylm.load(file):sample(points)))
        os.remove(file)
      end
    end)

    it("put all lamps of a dynamic grid out, and it can be lit again: " .. name, function()
      local function lamp(x) return ylm.sphere_light { at = { x, 1.4, 0 }, radius = 0.1, radiance = { 10, 8, 6 } } end
      local grid = assert(ylm.bake(make(true), { lamp(0) }, { occupied = points }))
      for _, step in ipairs { { {}, 1 }, { {}, 0 }, { { lamp(1), lamp(0.3) }, 2 }, { { lamp(0.3) }, 1 },
        { ylm.sphere_lights { at = {} }, 1 }, { lamp(-1), 1 } } do
        local report = assert(grid:update(step[1], { tolerance = 0 }))
        assert.equal(step[2], report.lights)
        if grid.tolerance and report.verified > 0 then assert.is_true(report.met) end
        local fresh = ylm.bake(make(false), step[1], { occupied = points })
        if not grid.tolerance then assert.equal(fresh.stats.leaves, grid.stats.leaves) end
        if fresh.stats.pairs == 0 then
          assert_dark(grid:sample(points), grid:points().value, grid:points().lambda)
        else
          local here, there = grid:sample(points), fresh:sample(points)
          local _, off, norm = core.array_distance(here, there)
          assert.is_true(off <= (grid.tolerance or 2e-5) * norm, off / norm)
        end
      end
    end)
  end

  it("leave no noise behind where a lamp far brighter than the rest goes out", function()
    for name, make in pairs(grids) do
      local function lamps(bright)
        return { ylm.sphere_light { at = { 0, 2, 0 }, radiance = bright },
          ylm.sphere_light { at = { 1.5, 2, 0 }, radiance = 1e-3 }, ylm.sphere_light { at = { -1, 2, 1 }, radiance = 0 } }
      end
      local grid = assert(ylm.bake(make(true), lamps(1e4), { occupied = points }))
      assert(grid:update(lamps(0)))
      local _, off, norm = core.array_distance(grid:sample(points), (ylm.light_field(grid.lmax, lamps(0), points)))
      local _, most = core.array_distance(ylm.bake(make(false), lamps(0), { occupied = points }):sample(points),
        (ylm.light_field(grid.lmax, lamps(0), points)))
      assert.is_true(off <= 1e-4 * norm + 1.1 * most, ("%s: %g of %g"):format(name, off / norm, most / norm))
    end
  end)

  it("are a scene: baked, rendered, traced and viewed", function()
    local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 4 }
    for name, lights in pairs(nothing) do
      local scene = ylm.scene "dark" { camera = ylm.camera { from = { 0, 1.2, 2.6 }, at = { 0, 0, 0 }, fov = 45 },
        geometry = { floor }, lights = lights, probes = ylm.adaptive_grid { depth = 3, lmax = 2 } }
      local grid = assert(scene:bake())
      local size = { 16, 12 }
      local pictures = { scene:render { grid = grid, size = size }, scene:render { by = "sum", size = size },
        (scene:render { bounces = 0, size = size, light_samples = 2 }) }
      assert.equal(3, #pictures, name)
      local prepared = assert(scene:prepare { size = size, samples = 1, transfer_samples = 4, visibility = "transfer" })
      pictures[4] = prepared:render { grid = grid, lamps = {} }
      for _, picture in ipairs(pictures) do assert_dark(picture:layer "radiance") end
    end
  end)

  it("are viewed as nothing", function()
    local grid = ylm.bake(grids.uniform(false), {})
    assert.truthy(ylm.view { grid, lights = {} })
  end)
end)

describe("a body that has been closed", function()
  it("is named where light is to pass the caster that hides it", function()
    local body = ylm.occluder { radius = 1 }
    local caster = ylm.caster { hides = body, at = { 0, 0, 0 } }
    body:close()
    for _, take in ipairs { function() ylm.shadowed { lights = {}, casters = { ball = caster } } end,
      function() ylm.visibility(2, { ball = caster }, points) end } do
      local ok, message = pcall(take)
      assert.is_false(ok)
      assert.matches("^spec/no_lights_spec.lua:%d+: .*the occluder that caster 'ball' hides has been closed", message)
    end
  end)
end)

describe("what is no list of lights", function()
  local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
  local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } }
  local scene = ylm.scene "floor" { camera = ylm.camera { from = { 0, 1.2, 2.6 }, at = { 0, 0, 0 } }, geometry = floor,
    lights = lamp }
  local t = scene:links { rays = 4, spacing = 2 }
  local lit, view = t:radiosity(), scene:prepare { size = { 4, 3 }, samples = 1 }
  local function grid(dynamic) return ylm.bake(grids.uniform(dynamic), lamp) end
  local takes = {
    light_field = function(lights) return ylm.light_field(0, lights, points) end,
    radiosity = function(lights) return t:radiosity(lights) end,
    ["radiosity:update"] = function(lights) return lit:update(lights) end,
    bake = function(lights) return ylm.bake(grids.uniform(false), lights) end,
    ["scene:bake"] = function(lights)
      return scene:bake { quantity = "lights", lights = lights, probes = grids.uniform(false) }
    end,
    update = function(lights) return grid(true):update(lights) end,
    ["grid:update of points"] = function(lights) return grid(false):update(lights) end,
    render = function(lights) return view:render { lights = lights } end,
    shadowed = function(lights) return ylm.shadowed { lights = lights, casters = ylm.sphere_casters { at = { { 0, 1, 0 } },
      radius = 0.1 } } end,
    sampled_light = function(lights) return ylm.sampled_light { lights = lights, at = { { 0, 0, 0 } } } end,
  }

  for name, take in pairs(takes) do
    it("is refused by " .. name .. ": options in the place of lights, and lists with holes", function()
      for wrong, words in pairs { [{ bounces = 1 }] = "no entry 'bounces'", [{ lamp, { treads = 1 } }] = "no entry 'treads'",
        [{ lamp, nil, lamp }] = "light 2 of the list is nil", [{ [0] = lamp }] = "no entry 0" } do
        local ok, message = pcall(take, wrong)
        assert.is_false(ok)
        assert.truthy(message:find(words, 1, true), message)
      end
    end)
  end

  it("names the file that could not be read in the place of a light", function()
    local ok, message = pcall(ylm.light_field, 0, { ylm.load "no such file" }, points)
    assert.is_false(ok)
    assert.truthy(message:find("light 1 of the list is nil: no such file", 1, true), message)
  end)

  it("is said once where it is an empty list, and never of a scene without lights", function()
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message:match "^%S+" end)
    local ok, why = pcall(function()
      local dark = ylm.scene "dark" { geometry = floor }
      dark:links({ rays = 4, spacing = 2 }):radiosity(dark.lights)
      dark:bake { quantity = "lights", probes = grids.uniform(false) }
      assert.same({}, said)
      for _ = 1, 2 do
        ylm.sampled_light { lights = { {} }, at = { { 0, 0, 0 } } }
        view:render { lights = {} }
      end
    end)
    ylm.on_warning(before)
    assert(ok, why)
    assert.same({ "sampled_light:", "render:" }, said)
  end)
end)

describe("no lights on a device", function()
  local gpu = device.here()
  if not gpu then return end

  it("have a light field, all zero, by every method", function()
    local there = assert(gpu:lights {})
    assert.equal(0, there.count)
    for _, lights in ipairs { {}, there } do
      for _, method in ipairs { "merged", "forward", "reversed" } do
        local o = { device = gpu, derivatives = 2, metric = "rgb", method = lights ~= there and method or nil }
        local L, dL, ddL, report = ylm.light_field(3, lights, points, o)
        assert.same({ 3, 3, 16 }, L.shape)
        assert_dark(L, dL, ddL, report.lambda, report.norm, report.inside)
      end
      local L = ylm.light_field(20, lights, points, { device = gpu, dtype = "double" })
      assert.same({ 3, 3, 441 }, L.shape)
      assert_dark(L)
    end
    there:close()
  end)

  it("bake to the cells that the processor makes, and are sampled", function()
    for name, make in pairs(grids) do
      local here = ylm.bake(make(false), {}, { occupied = points })
      local there = assert(ylm.bake(make(false), {}, { occupied = points, device = gpu }))
      assert.equal(here.stats.leaves, there.stats.leaves, name)
      assert.equal(here.stats.points, there.stats.points, name)
      assert_dark(there:sample(points), (there:sample(points, { device = gpu })))
    end
  end)
end)
