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

describe("ylm.bake { like = grid }", function()
  local shade = ylm.shadowed { lights = sky, casters = { ball = ylm.caster { hides = ball, at = { 0, 0.8, 0 } } } }
  local lit = floor(3000, 3.6)

  it("follows casters that move, at its tolerance, with fewer evaluations", function()
    local first = ylm.bake(probes(), shade, { occupied = lit })
    local grid = first
    for frame = 1, 6 do
      shade:move { ball = { at = { 0.1 * frame, 0.8, 0.05 * frame } } }
      grid = ylm.bake(probes(), shade, { occupied = lit, like = grid })
      local s = grid.stats
      assert.is_true(s.met and s.error <= 0.05 and s.verified > 1900 and s.confidence > 0.98)
      assert.is_true(s.pairs < first.stats.pairs)
      assert(missing(grid, shade, floor(800, 3.6), 0.05) <= 0.02, "seed " .. seed)
    end
    shade:move { ball = { at = { 0, 0.8, 0 } } }
  end)

  it("is the same whatever the threads, and refines anew where the light is another", function()
    local start = ylm.bake(probes(), shade, { occupied = lit })
    local one = ylm.bake(probes(), shade, { occupied = lit, like = start, threads = 1 })
    local two = ylm.bake(probes(), shade, { occupied = lit, like = start, threads = 3 })
    local places = floor(50, 3.6)
    assert.same(one:sample(places):totable(), two:sample(places):totable())
    assert.equal(one.stats.error, two.stats.error)
    local other = ylm.shadowed { lights = ylm.sphere_light { at = { 0, 1.5, 0 }, radius = 0.1, radiance = 50 },
      casters = { ball = ylm.caster { hides = ball, at = { 0, 0.8, 0 }, scale = 0.4 } } }
    local grid = ylm.bake(probes(), other, { occupied = lit, like = start })
    assert(missing(grid, other, floor(800, 3.6), 0.05) <= 0.03, "seed " .. seed)
  end)

  it("takes all places where there are few", function()
    local few = floor(100, 3.6)
    local start = ylm.bake(probes(), shade, { occupied = few })
    local grid = ylm.bake(probes(), shade, { occupied = few, like = start })
    assert.equal(100, grid.stats.verified)
    assert.equal(1, grid.stats.confidence)
  end)

  it("refuses grids that have learnt nothing, or of something else, and says which", function()
    local start = ylm.bake(probes(), shade, { occupied = lit })
    local function refused(pattern, description, options)
      assert.error_matches(function() assert(ylm.bake(description, shade, options)) end, pattern)
    end
    local threshold = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 4, depth = 3, threshold = 0.1 }, shade,
      { occupied = lit })
    refused("like: a grid expected that ylm.bake made by a tolerance", probes(), { occupied = lit, like = threshold })
    refused("like: is for grids with a tolerance", ylm.uniform_grid { bounds = box, cells = 2, lmax = 4,
      channels = "luminance" }, { like = start })
    refused("like: a grid of the same lmax, channels and measure expected", ylm.adaptive_grid { bounds = box, lmax = 3, depth = 4,
      tolerance = 0.1, channels = "luminance" }, { occupied = lit, like = start })
    refused("like", probes(), { occupied = lit, like = 3 })
    start:save "build/shadow_bodies_spec.ylm"
    local again = assert(ylm.load "build/shadow_bodies_spec.ylm")
    os.remove "build/shadow_bodies_spec.ylm"
    refused("like: a grid expected that ylm.bake made", probes(), { occupied = lit, like = again })
    start:close()
    refused("like", probes(), { occupied = lit, like = start })
  end)
end)
