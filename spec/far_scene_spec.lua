--- Scenes far from the origin: pictures, paths, links, probes, bodies and files are as good as at the origin.

local ylm = require "ylm"
local core = require "ylm.c.core"
local emit = require "ylm.emit"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local warning = require "ylm.warning"

if not pcall(require, "ylm.c.scene") then return end

local OFFSETS = long({ 5e6 }, { 1e3, 1e4, 1e5, 1e6, 5e6, 1e7 })
local SIZE = { 24, 18 }

--- A place of the scene, moved by the offset along one axis, against it along another, by half of it along the third.
local function at(o, x, y, z) return { x + o, y - o, z + o / 2 } end

local function lamps(o)
  return {
    ylm.sphere_light { at = at(o, -0.5, 1, 0.5), radius = 0.125, radiance = 10 },
    ylm.disk_light { at = at(o, 0.5, 1.5, 0), normal = { 0, -1, 0 }, radius = 0.25, radiance = { 1, 2, 3 } },
    ylm.textured_light { corner = at(o, -1, 0.5, 1), u = { 0.5, 0, 0 }, v = { 0, 0.5, 0 },
      image = { { 1, 2 }, { 4, 8 } } },
  }
end

--- A floor, a wall and a box: places in eighths, which stay what they are at every offset in double.
local function geometry(o)
  return {
    ylm.quad { corner = at(o, -1, 0, 1), u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 4,
      material = ylm.matte { albedo = 0.7 } },
    ylm.quad { corner = at(o, -1, 0, -1), u = { 2, 0, 0 }, v = { 0, 2, 0 }, divide = 4,
      material = ylm.matte { albedo = { 0.8, 0.2, 0.2 } } },
    ylm.box { bounds = { at(o, -0.25, 0, -0.25), at(o, 0.25, 0.5, 0.25) }, divide = 2,
      material = ylm.ggx { alpha = 0.5, f0 = 0.5 } },
  }
end

local function scene(o, lights)
  return ylm.scene "far" {
    camera = ylm.camera { from = at(o, 1.5, 1, 1.75), at = at(o, 0, 0.5, 0), fov = 50 },
    geometry = geometry(o), lights = lights or lamps(o), links = ylm.links { spacing = 0.1, rays = 64 },
  }
end

local function points(o)
  local list = {}
  for i = 1, 16 do list[i] = at(o, i / 16 - 0.875, 0.25 + i / 32, 0.875 - i / 16) end
  return list
end

--- The root mean square of a - b, relative to that of a.
local function apart(a, b)
  local none = core.array_convert(a, "double") * 0
  local norm = core.array_distance(core.array_convert(a, "double"), none)
  local away = core.array_distance(core.array_convert(a, "double"), core.array_convert(b, "double"))
  return away / math.max(norm, 1e-30)
end

--- f(scene, offset) -> array, at the offsets and at 0, is the same but for rounding.
local function assert_same(f, most, make)
  make = make or scene
  local near = assert(f(make(0), 0))
  for _, o in ipairs(OFFSETS) do
    local far = assert(f(make(o), o))
    assert.same(near.shape, far.shape)
    local d = apart(near, far)
    assert.is_true(d <= (most or 1e-5), ("%g apart at an offset of %g"):format(d, o))
  end
end

local function picture(f)
  return function(s, o)
    local image, message = f(s, o)
    return image and image:layer "radiance", message
  end
end

describe("far from the origin", function()
  local said
  setup(function()
    said = {}
    ylm.on_warning(function(message) said[#said + 1] = message end)
  end)
  teardown(function() ylm.on_warning() end)

  it("pictures are the same: by rays, with bounces, by paths", function()
    local with_spot = function(o)
      local list = lamps(o)
      list[4] = ylm.spot_light { at = at(o, 0.75, 1.25, 0.5), to = at(o, 0.25, 0, 0.5), intensity = 2, angle = 30 }
      list[5] = ylm.sun_light { direction = { 1, 2, 3 }, irradiance = 1 }
      return scene(o, list)
    end
    assert_same(picture(function(s) return s:render { size = SIZE, samples = 2, bounces = 0 } end), 1e-3, with_spot)
    assert_same(picture(function(s) return s:render { size = SIZE, samples = 2, bounces = "all" } end), 1e-3, with_spot)
    assert_same(picture(function(s) return s:render { size = SIZE, samples = 2, ambient = "rays", bounces = 0 } end), 1e-3)
    assert_same(picture(function(s) return s:pathtrace { size = SIZE, samples = 16 } end), 1e-3, with_spot)
    for _, message in ipairs(said) do assert.is_nil(message:find "from 0") end
  end)

  it("pictures are the same: by virtual lights and their rivals", function()
    for _, rival in ipairs { false, { "vpl" }, { "vsl" }, { "vsgl" } } do
      assert_same(picture(function(s)
        local lights = assert(s:virtual_lights { count = 100, seed = 2 })
        return assert(s:prepare { size = SIZE }):render { by = "none", bounced = lights, rival = rival or nil }
      end), 1e-4)
    end
    assert_same(function(s, o)
      return (ylm.light_field(3, assert(s:virtual_lights { count = 100, seed = 2 }), points(o), { dtype = "float" }))
    end)
  end)

  it("pictures are the same: by far parts of virtual lights in a grid and near parts at shading points", function()
    assert_same(picture(function(s, o)
      local far, near = assert(s:virtual_lights { count = 100, seed = 2 }):split { core = 4 }
      local view = assert(s:prepare { size = SIZE, samples = 1 })
      local grid = assert(ylm.bake(ylm.uniform_grid { lmax = 3, cells = { 6, 6, 6 },
        bounds = { at(o, -1.125, -0.125, -1.125), at(o, 1.125, 2.125, 1.125) } }, far))
      return view:render { grid = grid, near_lights = near }
    end), 1e-4)
  end)

  it("grids of a room's light are the same, and so are pictures by them", function()
    for _, quantity in ipairs(long({ "all" }, { "direct", "indirect", "all" })) do
      local probes, stats = ylm.adaptive_grid { lmax = 2, depth = 3, tolerance = 0.1 }, {}
      assert_same(picture(function(s, o)
        local grid = assert(s:bake { quantity = quantity, probes = probes, judge = long("field", "paths") })
        stats[o] = grid.stats
        return s:render { size = SIZE, samples = 2, grid = grid }
      end), 1e-3)
      for _, o in ipairs(OFFSETS) do
        assert.equal(stats[0].points, stats[o].points)
        local part = long(1e-3, 3e-3) -- single paths of a judge by paths part by rounding
        assert.near(stats[0].error, stats[o].error, part * stats[0].error)
      end
    end
  end)

  it("probes, gathered light and its noise are the same", function()
    assert_same(function(s, o) return (assert(s:probe { points = points(o), samples = 32, lmax = 2 })) end)
    local function field(s) -- without guides: rounding moves places from one cluster of theirs to the next
      return assert(assert(s:links { spacing = 0.25 }):radiosity(nil, { bounces = "all", guides = false }):field {})
    end
    assert_same(function(s, o) return (ylm.light_field(2, field(s), points(o))) end)
    assert_same(function(s, o) return field(s):validity(points(o)) end)
    assert_same(function(s, o) return ylm.array { field(s):noise { points = points(o), lmax = 2 }, 0 } end, 1e-4)
  end)

  it("shading points, hits and elements keep their places in double", function()
    for _, o in ipairs(OFFSETS) do
      local near = assert(scene(0):prepare { size = SIZE, samples = 1 })
      local far = assert(scene(o):prepare { size = SIZE, samples = 1 })
      local a, b = near:points().position, far:points().position
      assert.same({ "float", "double" }, { a.dtype, b.dtype })
      assert.is_true((core.array_distance(core.array_convert(a, "double"), b - at(o, 0, 0, 0))) < 1e-5)
      local x, y = near:hit(12, 10), far:hit(12, 10)
      for i = 1, 3 do assert.near(x.position[i], y.position[i] - at(o, 0, 0, 0)[i], 1e-6) end
    end
  end)

  it("bodies hide light and are drawn where they stand", function()
    local cube = ylm.box { bounds = { { -0.125, -0.125, -0.125 }, { 0.125, 0.125, 0.125 } } }
    local hides = ylm.occluder { geometry = cube }
    local function shade(o)
      return ylm.shadowed { lights = lamps(o)[1], casters = { one = ylm.caster { hides = hides,
        at = at(o, -0.25, 0.75, 0.375), surface = cube } } }
    end
    assert_same(function(_, o) return (ylm.light_field(4, shade(o), points(o))) end)
    assert_same(picture(function(s, o)
      local seen = shade(o)
      local grid = assert(ylm.bake(ylm.uniform_grid { lmax = 3, cells = { 6, 6, 6 },
        bounds = { at(o, -1.125, -0.125, -1.125), at(o, 1.125, 2.125, 1.125) } }, seen))
      local view = assert(s:prepare { size = SIZE, samples = 1, visibility = "transfer", lmax = 3 })
      return view:render { grid = grid, bodies = seen }
    end), 1e-4)
  end)

  it("files keep their places: links, virtual lights, scenes", function()
    local folder = scratch.new()
    for _, o in ipairs(OFFSETS) do
      local s = scene(o)
      local links = assert(s:links { spacing = 0.25 })
      assert(links:save(folder.path .. "/far.links"))
      assert(s:links { file = folder.path .. "/far.links" })
      local taken, message = pcall(function() return scene(0):links { file = folder.path .. "/far.links" } end)
      assert.is_false(taken)
      assert.matches("are of another scene", message)
      local lights = assert(s:virtual_lights { count = 20, seed = 2 })
      assert(emit.write(lights, folder.path .. "/far.ply"))
      assert.matches("property double x", folder:read "far.ply")
      assert((s:save(folder.path .. "/far.glb")))
      local back = assert(ylm.load(folder.path .. "/far.glb"))
      for i = 1, 3 do assert.near(s.camera.from[i], back.camera.from[i], 1e-9 * o) end
    end
    folder:remove()
  end)
end)

describe("large and small", function()
  --- A closed room of which all lengths are multiplied by k.
  local function room(k)
    local function place(x, y, z) return { k * x, k * y, k * z } end
    local white = ylm.matte { albedo = 0.6 }
    return ylm.scene "room" {
      camera = ylm.camera { from = place(-1.5, 1.5, 1.5), at = place(0.5, 0.5, -0.5), fov = 60 },
      geometry = { ylm.box { bounds = { place(-2, 0, -2), place(2, 3, 2) }, material = white },
        ylm.box { bounds = { place(0.25, 0, -0.5), place(0.75, 0.5, 0) }, material = white } },
      lights = { ylm.sphere_light { at = place(-0.5, 2, 0.5), radius = k / 4, radiance = 10 },
        ylm.textured_light { corner = place(-1, 2.5, -1), u = { k, 0, 0 }, v = { 0, 0, k }, image = { { 5 } } } },
    }
  end

  local said, before
  setup(function()
    said = {}
    before = ylm.on_warning(function(message) said[#said + 1] = message end)
  end)
  teardown(function() ylm.on_warning(before) end)

  it("scenes have one light", function()
    local function paths(k)
      local image, report = room(k):pathtrace { size = SIZE, samples = 16 }
      assert.same({}, report.warnings)
      return image:layer "radiance"
    end
    local near = paths(1)
    for _, power in ipairs { -26, 29 } do
      local d = apart(near, paths(2 ^ power))
      assert.is_true(d <= 1e-3, ("%g apart at 2^%d"):format(d, power))
    end
  end)

  it("scenes beyond what rays keep are said, once, with what to change", function()
    for power, words in pairs { [-28] = "2.4e-08 across, and rays lose light below 3e-08: multiply its lengths",
      [30] = "6.9e+09 across, and rays lose light above 6e+09: divide its lengths" } do
      local huge = room(2 ^ power)
      said = {}
      warning.silently(huge.pathtrace, huge, { size = SIZE, samples = 1 }) -- as a page's poster is made
      assert.same({}, said)
      for _ = 1, 2 do
        local _, report = huge:pathtrace { size = SIZE, samples = 1 }
        assert.equal('scene "room": its geometry is ' .. words, report.warnings[1])
      end
      assert.same({ 'scene "room": its geometry is ' .. words }, said)
    end
  end)
end)
