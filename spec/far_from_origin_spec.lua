--- Lights, bakes and updates far from the origin are as good as at the origin.

local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local long = require "spec.support.long"
local random = require "spec.support.random"
local scratch = require "spec.support.scratch"

local SEED = 20251121
local OFFSETS = long({ 1e3, 1e5, 1e7 }, { 1e3, 1e4, 1e5, 5e5, 1e6, 5e6, 1e7 })

--- A number on a lattice of 2^-20, which stays one at every offset in double.
local function exact(x) return math.floor(x * 2 ^ 20 + 0.5) / 2 ^ 20 end

--- A place of the scene, moved by the offset along one axis, against it along another, by half of it along the third.
local function at(x, y, z, offset) return { exact(x) + offset, exact(y) - offset, exact(z) + offset / 2 } end

--- n places in a cube of an edge.
local function places(n, edge, seed, offset)
  local next, list = random.minimal(seed), {}
  for i = 1, n do list[i] = at((next() - 0.5) * edge, (next() - 0.5) * edge, (next() - 0.5) * edge, offset) end
  return list
end

local function spheres(n, edge, seed, offset)
  local list = {}
  for i, p in ipairs(places(n, edge, seed, offset)) do
    list[i] = ylm.sphere_light { at = p, radius = 0.05 + 0.02 * (i % 12), radiance = { 1, i % 5, 2 } }
  end
  return list
end

local function corners(o) return { at(1, 1, 2, o), at(2, 1, 2, o), at(2, 2, 2.5, o), at(1, 2, 2.5, o) } end

--- Each makes lights at an offset; `order` is that of the derivatives they have.
local kinds = {
  spheres = { make = function(o) return spheres(12, 4, SEED, o) end },
  ["a polygon"] = { make = function(o) return ylm.polygon_light { vertices = corners(o), radiance = { 3, 2, 1 } } end },
  ["a polygon as a sphere"] = { make = function(o)
    return ylm.polygon_light { vertices = corners(o), radiance = { 3, 2, 1 }, method = "sphere" }
  end },
  ["a disk"] = { make = function(o)
    return ylm.disk_light { at = at(0, 2, 1, o), normal = { 0, 1, 1 }, radius = 0.5, radiance = 2 }
  end },
  ["an image"] = { make = function(o)
    return ylm.textured_light { corner = at(1, 1, 2, o), u = { 1, 0, 0 }, v = { 0, 1, 0 }, image = { { 1, 2 }, { 4, 8 } } }
  end },
  ["virtual lights"] = { make = function(o)
    return ylm.virtual_lights { at = places(40, 4, SEED + 1, o), intensity = 1, radius = 0.25 }
  end },
  samples = { make = function(o)
    return ylm.sampled_light { at = places(5, 4, SEED + 1, o), lights = spheres(12, 4, SEED, o) }
  end },
  ["lights of several kinds"] = { make = function(o)
    local list = spheres(3, 4, SEED, o)
    list[4] = ylm.polygon_light { vertices = corners(o), radiance = { 3, 2, 1 } }
    list[5] = ylm.environment_light { radiance = { 1, 2, 3 } }
    return list
  end, sum = true },
  ["many lights, to a tolerance"] = { make = function(o) return spheres(3000, 4, SEED, o) end, tolerance = 1e-2 },
  ["lights behind bodies"] = { make = function(o)
    return ylm.shadowed { lights = spheres(3, 4, SEED, o),
      casters = { ylm.caster { hides = ylm.occluder { radius = 0.5 }, at = at(0, 0, 1.5, o) } } }
  end, order = 1, sum = true },
}

--- The error of results against others, relative to their norm.
local function error_of(a, b)
  local _, d, norm = core.array_distance(a, b)
  return d / norm
end

describe("far from the origin", function()
  for name, kind in pairs(kinds) do
    local order = kind.order or 2
    local o = { derivatives = order, channels = "rgb", dtype = "double", tolerance = kind.tolerance }

    it("light is that at the origin, in double: " .. name, function()
      local truth = { ylm.light_field(3, kind.make(0), places(40, 1.5, SEED + 2, 0), o) }
      for _, offset in ipairs(OFFSETS) do
        local got = { ylm.light_field(3, kind.make(offset), places(40, 1.5, SEED + 2, offset), o) }
        for k = 1, order + 1 do
          local e = error_of(got[k], truth[k])
          assert.is_true(e <= (kind.tolerance or 1e-9), ("%g: derivative %d is off by %g"):format(offset, k - 1, e))
        end
      end
    end)

    it("light is as accurate as at the origin, in float: " .. name, function()
      local truth = { ylm.light_field(3, kind.make(0), places(40, 1.5, SEED + 2, 0),
        { derivatives = order, channels = "rgb", dtype = "double" }) }
      local kernels = { false }
      for _, isa in ipairs((kind.sum or kind.tolerance) and {} or ylm.info().kernels) do kernels[#kernels + 1] = isa end
      for _, isa in ipairs(kernels) do
        local near
        local how = { derivatives = order, channels = "rgb", tolerance = kind.tolerance }
        for _, offset in ipairs { 0, (table.unpack or unpack)(OFFSETS) } do -- luacheck: ignore
          local points = places(40, 1.5, SEED + 2, offset)
          local got
          if isa then
            local object = light.pack(2, "spec", kind.make(offset))
            got = { light.evaluate("spec", 3, object, ylm.array(points, "double"), how, isa, nil, true) }
          else
            got = { ylm.light_field(3, kind.make(offset), points, how) }
            assert.equal("float", got[1].dtype)
          end
          for k = 1, order + 1 do got[k] = error_of(got[k], truth[k]) end
          near = near or got
          for k = 1, order + 1 do
            assert.is_true(got[k] <= math.max(3 * near[k] + 2e-6, kind.tolerance or 0),
              ("%s at %g: derivative %d is off by %g, at 0 by %g"):format(isa or "light_field", offset, k - 1, got[k], near[k]))
          end
        end
      end
    end)
  end

  -- Grids -------------------------------------------------------------------------------------------------------------

  local TOLERANCE = 0.02

  local function scene(offset, seed)
    return spheres(6, 5, seed, offset), { at(-2, -2, -2, offset), at(2, 2, 2, offset) }
  end

  --- The error that 99 % of points keep, against light in double.
  local function true_error(grid, lights, bounds)
    local n = long(500, 10000)
    local points = random.points_in(n, bounds[1], bounds[2], SEED + 3)
    local truth, _, _, report = ylm.light_field(grid.lmax, lights, points, { dtype = "double" })
    local found, outside = grid:sample(points, { dtype = "double" }), {}
    for i = 1, n do
      if report.inside[i] == 0 then
        local _, d, norm = core.array_distance(found[i], truth[i])
        outside[#outside + 1] = d / norm
      end
    end
    table.sort(outside)
    return grids.quantile(outside, 0.99)
  end

  local function described(bounds, more)
    local d = { bounds = bounds, lmax = 2, depth = 6, tolerance = TOLERANCE }
    for k, v in pairs(more or {}) do d[k] = v end
    return ylm.adaptive_grid(d)
  end

  it("bakes keep what they say, with as many probes, and so do their files", function()
    for s = 1, long(1, 20) do
      local near
      for _, offset in ipairs { 0, (table.unpack or unpack)(OFFSETS) } do -- luacheck: ignore
        local lights, bounds = scene(offset, SEED + 10 * s)
        local grid = ylm.bake(described(bounds), lights)
        local e = true_error(grid, lights, bounds)
        near = near or grid.stats
        assert.equal(near.met, grid.stats.met)
        assert.is_true(math.abs(grid.stats.points - near.points) <= 0.01 * near.points,
          ("%g: %d probes, at 0 %d"):format(offset, grid.stats.points, near.points))
        assert.is_true(e <= TOLERANCE or not grid.stats.met, ("%g: true error %g"):format(offset, e))
        if s == 1 and offset == OFFSETS[#OFFSETS] then
          local folder = scratch.new()
          local path = folder.path .. "/far.ylm"
          assert(grid:save(path))
          assert.equal(0, core.array_distance(grid:sample(random.points_in(50, bounds[1], bounds[2], 7)),
            ylm.load(path):sample(random.points_in(50, bounds[1], bounds[2], 7))))
          folder:remove()
        end
      end
    end
  end)

  it("updates keep it", function()
    for _, offset in ipairs(OFFSETS) do
      local lights, bounds = scene(offset, SEED + 10)
      local grid = ylm.bake(described(bounds, { dynamic = true }), lights)
      for k = 1, 3 do
        lights[1] = ylm.sphere_light { at = at(0.3 * k, 0.2, 0.1, offset), radius = 0.15, radiance = 2 }
        grid:update(lights)
        local e = true_error(grid, lights, bounds)
        assert.is_true(grid.stats.met and e <= TOLERANCE, ("%g: true error %g"):format(offset, e))
      end
    end
  end)

  it("grids in bricks keep it", function()
    local folder = scratch.new "/dev/shm"
    local near
    for _, offset in ipairs { 0, (table.unpack or unpack)(OFFSETS) } do -- luacheck: ignore
      local lights, bounds = scene(offset, SEED + 10)
      local set = assert(ylm.bake(described(bounds, { bricks = 1 }), lights, { folder = ("%s/%g.ylmd"):format(folder.path, offset) }))
      local e = true_error(set, lights, bounds)
      near = near or set.stats
      assert.equal(near.met, set.stats.met)
      assert.is_true(e <= TOLERANCE, ("%g: true error %g"):format(offset, e))
      set:close()
    end
    folder:remove()
  end)

  describe("a mesh", function()
    -- A quarter of a pyramid: places in eighths, which stay what they are at every offset in double.
    local pyramid = { { 0, 0, 0 }, { 1.125, 0, 0 }, { 1.125, 0.5, 0 }, { 0, 0.5, 0.375 } }
    local function moved(o)
      local list = {}
      for i, c in ipairs(pyramid) do list[i] = { c[1] + o, c[2] - o, c[3] + o / 2 } end
      return list
    end
    local folder
    setup(function() folder = scratch.new() end)
    teardown(function() folder:remove() end)

    local function obj(o)
      local lines = {}
      for i, c in ipairs(moved(o)) do lines[i] = ("v %.17g %.17g %.17g\n"):format(c[1], c[2], c[3]) end
      return folder:write("far.obj", table.concat(lines) .. "f 1 2 3\nf 1 3 4\n")
    end

    local function assert_places(o, mesh)
      local v, b = mesh:vertices(), mesh.bounds
      assert.equal("double", v.dtype)
      assert.same(moved(o), v:totable())
      assert.same({ { o, -o, o / 2 }, { o + 1.125, -o + 0.5, o / 2 + 0.375 } }, { b[1], b[2] })
    end

    it("keeps its places: of files, arrays, transforms, and through files", function()
      for _, o in ipairs { 1e3, 5e5, 5e6 } do
        local read = ylm.mesh { file = obj(o), crease = 180 }
        assert_places(o, read.mesh)
        assert_places(o, ylm.mesh { vertices = moved(o), triangles = { { 1, 2, 3 }, { 1, 3, 4 } } }.mesh)
        assert_places(o, ylm.mesh { file = obj(0), crease = 180, at = { o, -o, o / 2 } }.mesh)
        assert(read.mesh:save(folder.path .. "/far.ply"))
        assert_places(o, assert(ylm.load(folder.path .. "/far.ply")))
        local one = ylm.scene "far" { geometry = read, lights = ylm.sphere_light { at = { o, 1 - o, o / 2 }, radiance = 1 } }
        assert((one:save(folder.path .. "/far.glb")))
        assert_places(o, assert(ylm.load(folder.path .. "/far.glb")).geometry[1].mesh)
      end
    end)

    it("is near 0 where it comes back, and its shapes are those of shapes near 0", function()
      local back = ylm.mesh { file = obj(5e6), crease = 180, at = { -5e6, 5e6, -2.5e6 } }.mesh
      assert.equal("float", back:vertices().dtype)
      assert.same(pyramid, back:vertices():totable())
      local quad = ylm.quad { corner = { 5e6, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 }, divide = 4 }.mesh
      local box = ylm.box { bounds = { { 5e6, 0, 0 }, { 5e6 + 1, 1, 1 } }, divide = 2 }.mesh
      local near = ylm.box { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, divide = 2 }.mesh
      assert.equal(5e6 + 0.25, quad:vertices():get(2, 1))
      assert.equal(0, (core.array_distance(box:vertices() - { 5e6, 0, 0 }, near:vertices() + { 0, 0, 0 })))
    end)

    it("makes the same grid", function()
      local function baked(o)
        local lamps = { ylm.sphere_light { at = { o + 0.25, -o + 0.125, o / 2 + 0.5 }, radius = 0.0625, radiance = 3 } }
        return assert(ylm.bake(ylm.adaptive_grid { lmax = 2, depth = 5, tolerance = 0.05 }, lamps,
          { geometry = ylm.mesh { file = obj(o), crease = 180 } })).stats
      end
      local here, near, far = baked(0), baked(1e3), baked(5e6)
      assert.is_true(near.met and far.met)
      assert.equal(near.points, far.points)
      assert.near(near.error, far.error, 1e-4)
      assert.near(here.points, far.points, 0.2 * here.points) -- held-out points are others beyond an origin
    end)
  end)
end)
