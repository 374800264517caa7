local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local seed = tonumber(os.getenv "YLM_SEED") or 20261123
local state = seed % 65521 + 1
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- n places on a square floor y = 0 of an edge.
local function floor(n, edge)
  local list = {}
  for i = 1, n do list[i] = { edge * (random() - 0.5), 0, edge * (random() - 0.5) } end
  return ylm.array(list, "float")
end

local ball = ylm.occluder { radius = 0.5 }
local sky = ylm.environment_light { sky = { kind = "clear", sun = { 1, 0.8, 0.3 } } }
local box = { { -2, -0.1, -2 }, { 2, 3.9, 2 } }

local function probes(tolerance)
  return ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, tolerance = tolerance or 0.05, channels = "luminance" }
end

--- The part of places whose light in the grid is off by more than the tolerance.
local function missing(grid, field, places, tolerance)
  local e = ylm.sh.relative_error(grid:sample(places), ylm.light_field(4, field, places, { channels = "luminance" })):totable()
  local failed = 0
  for _, x in ipairs(e) do if (type(x) == "table" and x[1] or x) > tolerance then failed = failed + 1 end end
  return failed / #e
end

describe("grid:update { octree = 'follow' }", function()
  local shade = ylm.shadowed { lights = sky, casters = { ball = ylm.caster { hides = ball, at = { 0, 0.8, 0 } } } }
  local lit = floor(3000, 3.6)
  local follow = { octree = "follow" }

  it("follows casters that move, at its tolerance, with fewer evaluations", function()
    local grid = ylm.bake(probes(), shade, { occupied = lit })
    local first = grid.stats.pairs
    for frame = 1, 6 do
      shade:move { ball = { at = { 0.1 * frame, 0.8, 0.05 * frame } } }
      local report, s = grid:update(shade, follow), grid.stats
      assert.is_true(s.met and s.error <= 0.05 and s.verified > 1900 and s.confidence > 0.98)
      assert.same({ s.points, s.error, s.pairs }, { report.points, report.error, report.pairs })
      assert.is_true(s.pairs < first)
      assert(missing(grid, shade, floor(800, 3.6), 0.05) <= 0.02, "seed " .. seed)
    end
    shade:move { ball = { at = { 0, 0.8, 0 } } }
  end)

  it("is the same whatever the threads, and refines anew where the light is another", function()
    local one, two = ylm.bake(probes(), shade, { occupied = lit }), ylm.bake(probes(), shade, { occupied = lit })
    one:update(shade, { octree = "follow", threads = 1 })
    two:update(shade, { octree = "follow", threads = 3 })
    local places = floor(50, 3.6)
    assert.same(one:sample(places):totable(), two:sample(places):totable())
    assert.equal(one.stats.error, two.stats.error)
    local other = ylm.shadowed { lights = ylm.sphere_light { at = { 0, 1.5, 0 }, radius = 0.1, radiance = 50 },
      casters = { ball = ylm.caster { hides = ball, at = { 0, 0.8, 0 }, scale = 0.4 } } }
    one:update(other, follow)
    assert(missing(one, other, floor(800, 3.6), 0.05) <= 0.03, "seed " .. seed)
  end)

  it("takes all places where there are few, and others where they are named", function()
    local few = floor(100, 3.6)
    local grid = ylm.bake(probes(), shade, { occupied = few })
    grid:update(shade, follow)
    assert.equal(100, grid.stats.verified)
    assert.equal(1, grid.stats.confidence)
    grid:update(shade, { octree = "follow", occupied = floor(60, 3.6) })
    assert.equal(60, grid.stats.verified)
  end)

  it("gives a grid of a threshold the voxels of a bake, and keeps those of a uniform one", function()
    local form = ylm.adaptive_grid { bounds = box, lmax = 4, depth = 3, threshold = 0.1 }
    local grid = ylm.bake(form, sky, { occupied = lit })
    grid:update(shade, follow)
    assert(core.grid_encode(ylm.bake(form, shade, { occupied = lit })) == core.grid_encode(grid))
    local uniform = ylm.uniform_grid { bounds = box, cells = 2, lmax = 4, channels = "luminance" }
    grid = ylm.bake(uniform, sky)
    grid:update(shade, follow)
    assert.equal(0, (core.array_distance(ylm.bake(uniform, shade):points().value, grid:points().value)))
  end)

  it("leaves the grid as it was where it is cancelled, and fields that hold it follow", function()
    local grid = ylm.bake(probes(), shade, { occupied = lit })
    local before = core.grid_encode(grid)
    local report, _, code = grid:update(shade, { octree = "follow", progress = function() return false end })
    assert.is_nil(report)
    assert.equal("ECANCELLED", code)
    assert(before == core.grid_encode(grid))
    local both = ylm.shadowed { lights = grid, casters = {} }
    grid:update(sky, follow)
    local x = { { 0.1, 0.3, 0.2 } }
    assert.same(grid:sample(x):totable(), ylm.light_field(4, both, x, { channels = "luminance" }):totable())
  end)

  it("refuses grids that were loaded, and other measures, and says why", function()
    local start = ylm.bake(probes(), shade, { occupied = lit })
    local folder = scratch.new()
    start:save(folder.path .. "/bodies.ylm")
    local again = assert(ylm.load(folder.path .. "/bodies.ylm"))
    folder:remove()
    assert.error_matches(function() again:update(shade, follow) end,
      "update: octree = 'follow' needs to know where light is needed, which files do not hold")
    start:close()
    assert.error_matches(function() start:update(shade, follow) end, "the grid has been closed")
  end)
end)

describe("scene:prepare { visibility = \"self\" }", function()
  local wall = ylm.quad { corner = { -1, 0, -0.5 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
  local ground = ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 } }
  local bowl = ylm.torus { at = { 1.5, 0.3, 0.8 }, radius = 0.5, tube = 0.2, divide = { 32, 16 } }
  local function view(visibility, geometry)
    return assert(ylm.scene "self" { camera = ylm.camera { from = { 0, 2, 4 } }, geometry = geometry, lights = sky }
      :prepare { size = { 24, 18 }, samples = 1, lmax = 4, visibility = visibility, transfer_samples = 64,
        occlusion_distance = math.huge })
  end
  local even = ylm.environment_light { radiance = 1 }
  local function radiance(v) return v:render { grid = even, layers = false }:layer "radiance":totable() end

  it("has the shadows of a surface on itself, and no others", function()
    local all, own = view("transfer", { ground, wall, bowl }), view("self", { ground, wall, bowl })
    local none = radiance(view("none", { ground, wall, bowl }))
    local a, b = radiance(all), radiance(own)
    local object, darker, same, inside = own:points().object, 0, 0, 0
    assert.equal("self", select(2, own:render { grid = even, layers = false }).visibility)
    assert.is_true(#object > 100)
    for i = 1, #a do
      for j = 1, #a[i] do
        darker = darker + (a[i][j][1] < b[i][j][1] - 1e-4 and 1 or 0)
        same = same + (math.abs(b[i][j][1] - none[i][j][1]) < 1e-5 and 1 or 0)
        inside = inside + (b[i][j][1] < none[i][j][1] - 0.01 and 1 or 0)
      end
    end
    assert.is_true(darker > 20, darker)            -- the wall darkens the floor, by rays that meet all
    assert.is_true(same > 200 and inside > 2, ("%d same, %d in a shadow of their own"):format(same, inside))
  end)

  it("is \"transfer\" of a scene of one surface, to the bit", function()
    assert.same(radiance(view("transfer", bowl)), radiance(view("self", bowl)))
  end)
end)

-- Bodies in pictures -----------------------------------------------------------------------------------

local cube = ylm.box { scale = 0.8, divide = 5, material = ylm.matte { albedo = { 0.7, 0.3, 0.2 } } }
local solid = ylm.occluder { geometry = ylm.box { scale = 0.8 } }
local lamp = ylm.sphere_light { at = { 1.5, 3, 1 }, radius = 0.5, radiance = 15 }
local even = ylm.environment_light { radiance = 0.5 }

local function room(geometry)
  return ylm.scene "floor" { camera = ylm.camera { from = { 0, 2, 4 }, at = { 0, 0.5, 0 }, fov = 40 },
    geometry = { ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 } }, geometry or {} },
    lights = { lamp, even } }
end

local function shaded(more)
  local casters = { cube = ylm.caster { hides = solid, surface = cube, at = { 0, 0.8, 0 },
    rotation = { axis = { 1, 2, 0.5 }, angle = 35 } } }
  for name, c in pairs(more or {}) do casters[name] = c end
  return ylm.shadowed { lights = { lamp, even }, casters = casters }
end

local size = { 40, 30 }
local function prepared(scene)
  return assert(scene:prepare { size = size, samples = 4, lmax = 7, visibility = "transfer", transfer_samples = 16 })
end

--- The root mean square difference of two pictures, over the mean of the second.
local function apart(a, b)
  local off, mean, n = 0, 0, 0
  local x, y = a:layer "radiance":totable(), b:layer "radiance":totable()
  for i = 1, #x do
    for j = 1, #x[i] do
      for c = 1, 3 do off, mean, n = off + (x[i][j][c] - y[i][j][c]) ^ 2, mean + y[i][j][c], n + 1 end
    end
  end
  return math.sqrt(off / n) / (mean / n)
end

describe("shadowed:without", function()
  it("is light behind the other casters, to the bit, where they stand now", function()
    local other = ylm.caster { hides = ball, at = { 1, 0.7, 0.3 } }
    local shade, alone = shaded { other = other }, ylm.shadowed { lights = { lamp, even }, casters = { other = other } }
    local rest, places = shade:without "cube", floor(40, 3)
    local options = { derivatives = 1, dtype = "double" }
    for _ = 1, 2 do
      local L, dL = ylm.light_field(5, rest, places, options)
      local M, dM = ylm.light_field(5, alone, places, options)
      assert.same(M:totable(), L:totable())
      assert.same(dM:totable(), dL:totable())
      assert.equal(1, rest.count)
      shade:move { other = { at = { -1, 0.9, 0 } } }
      alone:move { other = { at = { -1, 0.9, 0 } } }
    end
  end)

  it("without a name has no casters that stand still", function()
    local still = ylm.caster { hides = ball, at = { 1, 0.7, 0.3 } }
    local moving = ylm.caster { hides = ball, at = { 0, 0.7, 0 } }
    local both = ylm.shadowed { lights = even, casters = { still, moving = moving } }
    local one, places = ylm.shadowed { lights = even, casters = { moving } }, floor(20, 3)
    assert.same(ylm.light_field(4, one, places):totable(), ylm.light_field(4, both:without(), places):totable())
  end)

  it("ends with the shadowed light, and refuses names that there are not", function()
    local shade = shaded()
    local rest = shade:without "cube"
    assert.error_matches(function() shade:without "cub" end, "no caster has the name 'cub'")
    assert.error_matches(function() rest:without "cube" end, "ask the shadowed light that it is of")
    assert.error_matches(function() rest:move { cube = {} } end, "no caster has the name 'cube'")
    shade:close()
    assert.error_matches(function() ylm.light_field(2, rest, { 0, 0, 0 }) end, "closed")
  end)
end)

describe("view:render { bodies = shade }", function()
  it("has bodies and their shadows as rays have them", function()
    local shade = shaded()
    local view = prepared(room())
    local image, report = assert(view:render { grid = shade, bodies = shade, layers = false })
    local truth = room(shade:surfaces()):render { bounces = 0, size = size, samples = 4, light_samples = 64, layers = false }
    local e = apart(image, truth)
    assert(e < 0.09, ("%g"):format(e))
    assert.equal(1, report.bodies.count)
    assert.equal(216, report.bodies.vertices)
    assert.is_true(report.bodies.rays > 500 and report.bodies.seconds.light > 0)
    assert.equal(report.points + report.bodies.vertices, report.shadow.points)
    assert.is_true(report.shadow.casters > 0 and report.shadow.products > 0 and report.shadow.seconds > 0)
    shade:move { cube = { at = { 0.6, 1.1, -0.3 }, scale = 0.7, rotation = { axis = { 0, 1, 0 }, angle = 80 } } }
    local moved = apart(view:render { grid = shade, bodies = shade, layers = false },
      room(shade:surfaces()):render { bounces = 0, size = size, samples = 4, light_samples = 64, layers = false })
    assert(moved < 0.09, ("%g"):format(moved))
  end)

  it("hides bodies behind surfaces, and draws none that is out of sight", function()
    local wall = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    local shade, view = shaded(), prepared(room(wall))
    local empty = view:render { grid = shade, layers = false }
    assert.equal(0, apart(view:render { grid = shade, bodies = shade, layers = false }, empty))
    shade:move { cube = { at = { 0, 1, 30 } } }
    empty = view:render { grid = shade, layers = false }
    assert.equal(0, apart(view:render { grid = shade, bodies = shade, layers = false }, empty))
  end)

  it("shows a body that turns in even light as it shows the same body at rest, turned", function()
    local turned = ylm.box { scale = { 0.8, 0.5, 0.3 }, divide = 4, rotate = { axis = { 0, 1, 0 }, angle = 90 } }
    local still = ylm.caster { hides = ball, surface = turned, at = { 0, 0.9, 0 } }
    local moving = ylm.caster { hides = ball, surface = ylm.box { scale = { 0.8, 0.5, 0.3 }, divide = 4 }, at = { 0, 0.9, 0 },
      rotation = { axis = { 0, 1, 0 }, angle = 90 } }
    local view = prepared(room())
    local a = ylm.shadowed { lights = even, casters = { still } }
    local b = ylm.shadowed { lights = even, casters = { moving } }
    local e = apart(view:render { grid = a, bodies = a, layers = false }, view:render { grid = b, bodies = b, layers = false })
    assert(e < 0.005, ("%g"):format(e))
  end)

  it("is the same whatever the threads", function()
    local shade, view = shaded(), prepared(room())
    assert.equal(0, apart(view:render { grid = shade, bodies = shade, layers = false, threads = 1 },
      view:render { grid = shade, bodies = shade, layers = false, threads = 3 }))
  end)

  it("refuses what has no bodies, and surfaces that are none", function()
    local view, shade = prepared(room()), shaded()
    assert.error_matches(function() view:render { grid = shade, bodies = 3 } end, "bodies")
    local rest = shade:without "cube"
    assert(view:render { grid = rest, bodies = rest, layers = false }) -- no bodies are drawn
    assert.error_matches(function() room():prepare { size = { 4, 4 } }:render { lights = { shade } } end,
      "by rays, which see nothing of a ylm.shadowed")
    shade:close()
    assert.error_matches(function() view:render { grid = even, bodies = shade } end, "closed")
    assert.error_matches(function() ylm.caster { hides = ball, surface = 3 } end, "surface must be a shape")
    assert.error_matches(function() ylm.caster { hides = ball, surface = {} } end, "surface: an empty list")
    assert.error_matches(function() ylm.casters { hides = ball, surface = { ball }, at = {} } end, "surface must be a shape")
  end)
end)
