-- Prepared views without shading: layers, surfaces and lamps under a pixel; views from other cameras.

local core = require "ylm.c.core"
local ylm = require "ylm"

local lamps = {
  ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.3, radiance = { 3, 2, 1 } },
  ylm.sphere_light { at = { 0.1, 1, -1 }, radius = 0.3, radiance = 5 },
  ylm.sphere_light { at = { 0, -1, 0 }, radius = 0.3, radiance = 7 }, -- below the floor
}

local function scene(camera)
  return ylm.scene "look" {
    camera = camera,
    geometry = {
      ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 }, divide = 4 },
      ylm.box { bounds = { { -1, 0, -1.5 }, { 1, 1.6, -1.2 } } },
    },
  }
end

local front = ylm.camera { from = { 0, 1, 4 }, at = { 0, 0.8, 0 } }
local aside = ylm.camera { from = { 2, 2, 3 }, at = { 0, 0.3, 0 }, fov = 50 }
local size = { 48, 36 }
local options = { size = size, samples = 4, visibility = "none", lmax = 1, transfer_samples = 4 }

local function with(more)
  local all = {}
  for _, list in ipairs { options, more } do for k, v in pairs(list) do all[k] = v end end
  return all
end

--- The pixels of two arrays, which are the same to the bit.
local function same(a, b) return assert.equal(0, (a - b):abs():max()) end

describe("a prepared view", function()
  local view = scene(front):prepare(options)

  it("has the layers of its pictures without shading", function()
    local image = view:render { grid = ylm.sphere_lights { at = { { 0, 1, 0 } } }.lights }
    for _, name in ipairs { "position", "normal", "albedo", "coverage", "emitter" } do
      same(view:layer(name), image:layer(name))
    end
    local object, depth = view:layer "object", view:layer "depth"
    for y = 1, size[2], 5 do
      for x = 1, size[1], 5 do
        local hit = view:hit(x, y)
        assert.equal(hit and hit.object or 0, object:get(y, x, 1))
        assert.equal(hit == nil, depth:get(y, x, 1) == math.huge)
        assert.equal(depth:get(y, x, 1), image:layer "depth":get(y, x, 1))
      end
    end
  end)

  it("knows the surface in a pixel", function()
    local seen = {}
    for y = 1, size[2] do
      local hit = view:hit(24, y)
      if hit then
        local p = hit.position
        if hit.object == 1 then assert(math.abs(p[2]) < 1e-6 and math.abs(hit.normal[2] - 1) < 1e-6)
        else assert(math.abs(p[3] + 1.2) < 1e-6 or math.abs(p[2] - 1.6) < 1e-6) end
        local f, length = { 0, -0.2, -4 }, math.sqrt(16.04)
        local depth = ((p[1]) * f[1] + (p[2] - 1) * f[2] + (p[3] - 4) * f[3]) / length
        assert(math.abs(depth - hit.depth) < 1e-5)
        seen[hit.object] = true
      end
    end
    assert(seen[1] and seen[2])
  end)

  it("finds the lamp under a place: the nearest one, none that surfaces hide", function()
    local index, away, depth = view:lamp_at(lamps, 24.5, 14)
    assert(index == 1 and away == 0 and math.abs(depth - 4) < 0.02, depth)
    assert.equal(nil, view:lamp_at(lamps, 2, 2))
    local near, pixels = view:lamp_at(lamps, 35, 14, 20)
    assert(near == 2 and pixels > 2 and pixels < 20, pixels)
    assert.equal(nil, (view:lamp_at({ lamps[3] }, 24, 30, 5)))
    assert.equal(nil, (view:lamp_at({}, 24, 30, 5)))
  end)

  it("finds one of 100,000 lamps at once", function()
    local at = ylm.zeros({ 1e5, 3 }, "double")
    at = at + 50
    at:set(77777, 1, 0) at:set(77777, 2, 1) at:set(77777, 3, 0)
    local many = ylm.sphere_lights { at = at, radius = 0.2, radiance = 1 }
    assert.equal(77777, (view:lamp_at(many, 24, 14, 4)))
  end)

  it("writes depth with lamps in front of it", function()
    local depth = ylm.zeros({ size[2], size[1] }, "float")
    local grid = ylm.sphere_lights { at = { { 0, 1, 0 } } }.lights
    assert(view:render { grid = grid, lamps = lamps, depth = depth, layers = false })
    local plain = view:layer "depth"
    assert(math.abs(depth:get(14, 24) - 3.7) < 0.02, depth:get(14, 24))
    local nearer = 0
    for y = 1, size[2] do
      for x = 1, size[1] do
        assert(depth:get(y, x) <= plain:get(y, x, 1))
        if depth:get(y, x) < plain:get(y, x, 1) then nearer = nearer + 1 end
      end
    end
    assert(nearer > 30 and nearer < 60, nearer)
  end)

  it("is made from another camera as of a scene that has it", function()
    local other = scene(front):prepare(with { camera = aside })
    local own = scene(aside):prepare(options)
    for _, name in ipairs { "position", "object", "coverage" } do same(other:layer(name), own:layer(name)) end
    assert.equal(other.options.camera, aside)
    assert(scene():prepare(with { camera = aside }))
  end)

  it("refuses what it cannot tell, by name", function()
    local function says(text, f, ...)
      local good, message = pcall(f, ...)
      assert(not good and tostring(message):find(text, 1, true), message)
    end
    says("depth, position, normal, albedo, coverage, emitter, object expected, got 'x'", view.layer, view, "x")
    says("a pixel's column from 1 to 48 expected, got 49", view.hit, view, 49, 1)
    says("a pixel's row from 1 to 36 expected, got 0", view.hit, view, 1, 0)
    says("a pixel's column from 1 to 48 expected, got 1.5", view.hit, view, 1.5, 1)
    says("a finite number expected", view.lamp_at, view, lamps, 0 / 0, 1)
    says("pixels >= 0 expected, got -1", view.lamp_at, view, lamps, 1, 1, -1)
    says("sphere lights expected", view.lamp_at, view, nil, 1, 1)
    local grid = ylm.sphere_lights { at = { { 0, 1, 0 } } }.lights
    says("depth", view.render, view, { grid = grid, depth = ylm.zeros({ 3, 3 }, "float") })
    says("depth", view.render, view, { grid = grid, depth = ylm.zeros({ size[2], size[1] }, "double") })
    says("no camera", function() return scene():prepare(options) end)
    local closed = scene(front):prepare(options)
    closed:close()
    for _, name in ipairs { "layer", "hit", "lamp_at" } do says("closed", closed[name], closed, "depth", 1, 1) end
  end)
end)

describe("progress with every", function()
  it("is called more often, and may be a table in every function", function()
    local points = ylm.zeros({ 200000, 3 }, "float") + 1
    local lamp = ylm.sphere_light { at = { 0, 5, 0 } }
    local function calls(every)
      local n = 0
      local function count() n = n + 1 end
      assert(ylm.light_field(8, lamp, points, { threads = 1, progress = every and { count, every = every } or count }))
      return n
    end
    assert(calls(1e-4) > calls(nil))
  end)

  it("cancels, and is refused where it is no such table", function()
    local points = ylm.zeros({ 20000, 3 }, "float") + 1
    local _, message, code = ylm.light_field(2, ylm.sphere_light { at = { 0, 5, 0 } }, points,
      { progress = { function() return false end, every = 1e-3 } })
    assert.equal("ECANCELLED", code, message)
    for _, bad in ipairs { { print, every = 0 }, { print, every = "1" }, { every = 1 }, { print, every = 1e9 } } do
      local good, text = pcall(ylm.light_field, 2, ylm.sphere_light { at = { 0, 5, 0 } }, points, { progress = bad })
      assert(not good and text:find "every", text)
    end
    assert(core.seconds() > 0)
  end)
end)
