-- Irradiance by many virtual lights: near parts light by light, far parts of merged lights from levels of voxels.

local core = require "ylm.c.core"
local random = require "spec.support.random"
local ylm = require "ylm"

--- n places on the walls of a box of half edge 1 and on a ball in it, and normals.
local function places(n, seed)
  local r, at, normal = random.spread(seed), {}, {}
  for i = 1, n do
    if i % 4 == 0 then
      local z, turn = 2 * r() - 1, 2 * math.pi * r()
      local across = math.sqrt(1 - z * z)
      normal[i] = { across * math.cos(turn), across * math.sin(turn), z }
      at[i] = { 0.3 * normal[i][1] - 0.2, 0.3 * normal[i][2], 0.3 * normal[i][3] + 0.1 }
    else
      local a, side = i % 3, i % 2 * 2 - 1
      at[i], normal[i] = { 2 * r() - 1, 2 * r() - 1, 2 * r() - 1 }, { 0, 0, 0 }
      at[i][a + 1], normal[i][a + 1] = -side, side
    end
  end
  return at, normal
end

local COUNT = 20000
local P, N = places(700, 5)
local points, normals = ylm.array(P, "float"), ylm.array(N, "float")
local options = { core = 0.15, voxel = 0.45, merge = 0.35, lmax = 4 }

local function lights_of(more, n)
  local at, normal = places(n or COUNT, 3)
  local o = { at = at, normal = normal, radius = 0.05 }
  for key, value in pairs(more) do o[key] = value end
  return ylm.virtual_lights(o)
end

--- By levels, and facts.
local function levels(lights, change)
  local o = {}
  for key, value in pairs(options) do o[key] = value end
  for key, value in pairs(change or {}) do o[key] = value end
  return core.lights_virtual_irradiance(lights.lights, points, normals, o)
end

--- The root mean square error of E beside what all lights bring, over its mean.
local function missed(lights, E)
  local L = ylm.light_field(4, lights, points)
  local square, sum = 0, 0
  for i = 1, #points do
    local e = ylm.sh.irradiance(L[i], N[i])
    for c = 1, 3 do square, sum = square + (E:get(i, c) - e:get(c)) ^ 2, sum + e:get(c) end
  end
  return math.sqrt(square * 3 * #points) / sum
end

describe("irradiance by levels", function()
  it("is what all lights bring, to less than a percent, with many times fewer lights at a corner", function()
    local lights = lights_of { intensity = { 3, 2, 1 } }
    local E, x = levels(lights)
    assert.is_true(missed(lights, E) < 0.003)
    assert.is_true(x.levels > 1 and x.merged < COUNT / 5 and x.far_pairs < x.corners * COUNT / 5)
    assert.is_true(x.cells > 0 and x.bytes > x.corners * 1200 and x.pairs < #points * COUNT / 5)
    assert.is_near(0.35 * 0.15, x.cell, 1e-12)
    local wide = levels(lights, { voxel = 0.9, merge = 0.7 })
    assert.is_true(missed(lights, wide) > 2 * missed(lights, E))
  end)

  it("is its near part and its far part, and does not depend on threads by a bit", function()
    local lights = lights_of({ intensity = 1 }, 2000)
    local all = levels(lights, { threads = 3 })
    local near = levels(lights, { part = "near" })
    local far, x = levels(lights, { part = "far", onto = near, threads = 1 })
    assert.same(all:totable(), far:totable())
    assert.equal(0, x.pairs)
    local _, split = lights:split { core = options.core }
    assert.same(split:irradiance(points, normals):totable(), near:totable())
  end)

  it("takes lights of any degree, shift and sign, and those that shine all around", function()
    local r, b, shift = random.spread(9), {}, {}
    for i = 1, 2000 do
      b[i], shift[i] = {}, i % 2 * 0.4
      for c = 1, 3 do
        b[i][c] = { 3 * r() }
        for k = 2, 9 do b[i][c][k] = r() - 0.5 end
      end
    end
    local glossy = lights_of({ emission = ylm.array(b, "double"), shift = ylm.array(shift, "double") }, 2000)
    assert.is_true(missed(glossy, (levels(glossy))) < 0.002)
    local shifted = lights_of({ intensity = 1, shift = ylm.array(shift, "double") }, 2000)
    assert.is_true(missed(shifted, (levels(shifted))) < 0.002)
    local at = places(2000, 3)
    local round = ylm.virtual_lights { at = at, radius = 0.05, intensity = { 1, 0.5, -0.2 } }
    assert.is_true(missed(round, (levels(round))) < 0.03) -- of a mean that is less by what is below zero
  end)

  it("has darkness for no lights, nothing for no points, and one point in one voxel", function()
    local none = ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }
    assert.equal(0, select(2, levels(none)).corners)
    assert.same({ 0, 0, 0 }, levels(none)[1]:totable())
    local lights = lights_of({ intensity = 1 }, 100)
    local empty = ylm.zeros({ 0, 3 }, "float")
    assert.equal(0, #core.lights_virtual_irradiance(lights.lights, empty, empty, options))
    local one, way = ylm.array({ P[1] }, "float"), ylm.array({ N[1] }, "float")
    local E = core.lights_virtual_irradiance(lights.lights, one, way, options)
    local truth = ylm.sh.irradiance(ylm.light_field(4, lights, P[1]), N[1])
    assert.is_near(truth:get(1), E:get(1, 1), 0.02 * truth:get(1))
  end)

  it("refuses what cannot be", function()
    local lights = lights_of({ intensity = 1 }, 50)
    local function said(change, text)
      local E, message = levels(lights, change)
      assert.is_nil(E)
      assert.matches(text, message)
    end
    said({ core = 0.04 }, "light 1: core must be above the radius: core 0.04, radius 0.05")
    said({ voxel = 0 }, "voxel must be above 0, merge 0 .. 1: got 0, 0.35")
    said({ merge = 2 }, "merge 0 .. 1: got 0.45, 2")
    said({ lmax = 9 }, "lmax must be 0 .. 8, got 9")
    local far = lights:split { core = 1 }
    local _, message = levels(far)
    assert.matches("lights of profile 'gauss' are split, and these are 'far'", message)
    local wide = ylm.array({ { 0, 0, 0 }, { 1e9, 0, 0 } }, "float")
    _, message = core.lights_virtual_irradiance(lights.lights, wide, ylm.array({ N[1], N[2] }, "float"), options)
    assert.matches("points are too far apart for voxels of 0.0675", message)
    _, message = core.lights_virtual_irradiance(lights.lights, ylm.array({ { 0 / 0, 0, 0 } }, "float"),
      normals[{ 1, 1 }], options)
    assert.matches("point 1 is not finite", message)
  end)
end)
