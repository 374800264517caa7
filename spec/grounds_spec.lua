-- Grounds: a room that stands on a wide plane has elements and a promise of its own size.

local core = require "ylm.c.core"
local promise = require "spec.support.surface_promise"
local raises = require "spec.support.raises"
local scratch = require "spec.support.scratch"
local tracing = require "ylm.trace"
local ylm = require "ylm"

local ROOM, WIDE = { { -2, 0, -1.5 }, { 2, 3, 1.5 } }, 40
local DIAGONAL = math.sqrt(4 ^ 2 + 3 ^ 2 + 3 ^ 2)

local function ground(y) return ylm.quad { corner = { -WIDE / 2, y, WIDE / 2 }, u = { WIDE, 0, 0 }, v = { 0, 0, -WIDE } } end

--- A room, seen from a place, and surfaces around it.
local function scene(from, others)
  local list = { ylm.box { bounds = ROOM, sides = "back" } }
  for _, g in ipairs(others or { ground(-0.05) }) do list[#list + 1] = g end
  return ylm.scene "a room on a ground" { geometry = list, camera = ylm.camera { from = from, at = { 0, 1, 0 } },
    lights = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 10 }, links = ylm.links { rays = 4 } }
end

local INSIDE = { 1, 1.5, 0.5 }

describe("grounds", function()
  it("leave the elements of a room their size, where the camera is in it", function()
    local t = scene(INSIDE):links()
    assert.near(DIAGONAL / 100, t.stats.spacing, 1e-6)
    local _, alone = pcall(function() return scene(INSIDE, {}):links() end)
    local ours, theirs, of_ground = t:elements(), alone:elements(), 0
    for i = 1, #ours.area do of_ground = of_ground + (ours.mesh[i] == 2 and 1 or 0) end
    assert.equal(#theirs.area, #ours.area - of_ground)
    -- a hundredth of the diagonal of all: triangles with sides of 40 and 56.6, both sides
    local all = math.sqrt(2 * WIDE ^ 2 + 3.05 ^ 2)
    assert.equal(2 * 2 * math.ceil(math.sqrt(2) * WIDE / (all / 100) - 1e-6) ^ 2, of_ground)
  end)

  it("are none where the camera looks from outside, and where they are not flat or not far wider", function()
    local function spacing(...) return scene(...):links().stats.spacing end
    assert.near(math.sqrt(2 * WIDE ^ 2 + 3.05 ^ 2) / 100, spacing { 8, 4, 8 }, 1e-6)
    local dome = ylm.sphere { radius = 20, divide = { 16, 8 }, sides = "back" }
    assert.near(math.sqrt(3 * WIDE ^ 2) / 100, spacing(INSIDE, { dome }), 0.01)
    local narrow = ylm.quad { corner = { -3, -0.05, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 } }
    assert.near(math.sqrt(2 * 6 ^ 2 + 3.05 ^ 2) / 100, spacing(INSIDE, { narrow }), 1e-6)
  end)

  it("may consist of several parts, and keep a spacing that is given", function()
    local tiles = {}
    for i = 0, 3 do
      tiles[i + 1] = ylm.quad { corner = { -WIDE / 2 + WIDE / 2 * (i % 2), -0.05, WIDE / 2 * math.floor(i / 2) },
        u = { WIDE / 2, 0, 0 }, v = { 0, 0, -WIDE / 2 } }
    end
    assert.near(DIAGONAL / 100, scene(INSIDE, tiles):links().stats.spacing, 1e-6)
    local e = scene(INSIDE):links { spacing = 1 }:elements()
    for i = 1, #e.area do assert.is_true(e.area[i] <= 0.5) end
  end)

  it("are known to links that are read", function()
    local folder = scratch.new()
    local s, path = scene(INSIDE), folder.path .. "/room.links"
    local t = s:links()
    assert(t:save(path))
    local read = assert(s:links { file = path })
    assert.equal(t.stats.elements, read.stats.elements)
    folder:remove()
  end)

  it("count in the promise of light on surfaces as the largest face of what stands there", function()
    local s = scene(INSIDE)
    local links = s:links { spacing = 0.5, rays = 16 }
    local lit = links:radiosity()
    local light = assert(s:surface_grid { links = links, quantity = "direct",
      tolerance = 0.5, judge = "field", progress = false })
    local points, on_ground = promise.draw(light, lit, 600, 1).points, 0
    local n = #points
    assert.is_true(n > 500)
    for i = 1, n do on_ground = on_ground + (points[i][2] < -0.04 and 1 or 0) end
    -- both sides of the ground, 4 x 3 each, and one of the room's 2 (4 x 3 + 3 x 3 + 4 x 3)
    local share = 2 * 12 / (2 * 12 + 66)
    assert.near(share, on_ground / n, 4 * math.sqrt(share * (1 - share) / n))
  end)

  it("do not count in a grid's promise", function()
    local s = scene(INSIDE)
    local within = tracing.without_grounds("spec", s)
    assert.is_nil((tracing.without_grounds("spec", scene { 8, 4, 8 })))
    local links = s:links { spacing = 0.5, rays = 16 }
    local probes = ylm.adaptive_grid { lmax = 1, depth = 2, tolerance = 0.5 }
    local function farthest(o)
      o.probes, o.quantity, o.judge, o.links = probes, "indirect", "field", links
      local rows, far = core.grid_judges((s:bake(o))), 0
      for i = 1, #rows do for k = 1, 3 do far = math.max(far, math.abs(rows:get(i, k))) end end
      return far
    end
    assert.is_true(farthest {} <= within[2][2] + 1e-6)
    assert.is_true(farthest { within = { { -WIDE, -1, -WIDE }, { WIDE, 4, WIDE } } } > WIDE / 3)
    assert.has_error(function() ylm.bake(probes, ylm.sphere_light { at = { 0, 9, 0 } }, { geometry = s.geometry,
      within = { { 0, 0, 0 } } }) end)
    raises("within: the box lies outside of the grid's bounds", function()
      farthest { within = { { 90, 0, 0 }, { 91, 1, 1 } } }
    end)
  end)
end)
