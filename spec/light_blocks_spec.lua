local ylm = require "ylm"
local numbers = require "spec.support.random"
local core = require "ylm.c.core"

local side = 128 -- enough points for blocks

--- Uniform lights, or all of the light in a cluster above the floor; and the same for the odd ones.
local function lights_of(kind)
  local next, at, radius = numbers.spread(31), {}, {}
  for i = 1, 12000 do
    at[i] = { next(), next(), next() }
    radius[i] = kind == "cluster" and 1e-4 or 0.004
    if kind == "cluster" and i % 8 == 0 then
      at[i] = { 0.52 + 0.002 * next(), 0.47 + 0.002 * next(), 0.35 + 0.002 * next() }
      radius[i] = 0.004
    end
  end
  return ylm.sphere_lights { at = at, radius = radius, radiance = { 1, 1.5, 2 } }
end

--- Points on a floor, on a line, in one place, or in the cube.
local function points_of(kind, dtype)
  local next, p = numbers.spread(5), {}
  for i = 0, side * side - 1 do
    local x, y = (i % side + 0.5) / side, (math.floor(i / side) + 0.5) / side
    p[i + 1] = kind == "floor" and { x, y, 0.3 } or kind == "line" and { 0.3, i / side / side, 0.4 }
      or kind == "place" and { 0.3, 0.6, 0.4 } or { next(), next(), next() }
  end
  return ylm.array(p, dtype or "float"), p
end

--- The largest errors of values and gradients at every 331st point, in parts of the norm.
local function worst(lights, points, rows, tolerance, lmax, dtype)
  local tree = { ylm.light_field(lmax, lights, points, { derivatives = 1, tolerance = tolerance }) }
  local some, at = {}, {}
  for i = 1, #rows, 331 do
    some[#some + 1], at[#at + 1] = rows[i], i
  end
  local exact = { ylm.light_field(lmax, lights, ylm.array(some, dtype or "float"), { derivatives = 1 }) }
  local most = { 0, 0 }
  for j, i in ipairs(at) do
    for k = 1, 2 do
      local _, d, norm = core.array_distance(tree[k][i], exact[k][j])
      assert.is_true(d == d)
      most[k] = math.max(most[k], d / norm)
    end
  end
  return most[1] / tolerance, most[2] / tolerance, tree
end

describe("blocks of points that share what is far", function()
  for _, scene in ipairs { "uniform", "cluster" } do
    it("keep the tolerance wherever points are: lights " .. scene, function()
      local lights = lights_of(scene)
      for _, set in ipairs { "floor", "line", "place", "cube" } do
        for _, dtype in ipairs(set == "floor" and { "float", "double" } or { "float" }) do
          local points, rows = points_of(set, dtype)
          local value, gradient = worst(lights, points, rows, 1e-2, 4, dtype)
          assert(value <= 1, ("%s, %s: values %.3g of the tolerance"):format(set, dtype, value))
          assert(gradient <= 1, ("%s, %s: gradients %.3g of the tolerance"):format(set, dtype, gradient))
        end
      end
    end)
  end

  it("keep the tolerance at other lmax and tolerances", function()
    local lights, points, rows = lights_of "uniform", points_of "floor"
    for _, o in ipairs { { 1, 1e-2 }, { 8, 1e-1 }, { 2, 1e-3 } } do
      local value, gradient = worst(lights, points, rows, o[2], o[1])
      assert(value <= 1 and gradient <= 1, ("lmax %d: %.3g %.3g"):format(o[1], value, gradient))
    end
  end)

  it("sum fewer lights than packets by themselves", function()
    local lights, points, rows = lights_of "uniform", points_of "floor"
    local few = {}
    for i = 1, 4096 do few[i] = rows[i] end
    local o = { derivatives = 1, tolerance = 1e-2 }
    local _, _, _, block = ylm.light_field(4, lights, points, o)
    local _, _, _, alone = ylm.light_field(4, lights, ylm.array(few, "float"), o)
    assert.is_true(block.pairs / #rows < 0.8 * alone.pairs / #few)
  end)

  it("give the same bits whatever the threads", function()
    local lights, points = lights_of "uniform", points_of "floor"
    local o = { derivatives = 1, tolerance = 1e-2, threads = 1 }
    local one = { ylm.light_field(3, lights, points, o) }
    o.threads = 2
    local two = { ylm.light_field(3, lights, points, o) }
    for k = 1, 2 do assert.equal(0, (core.array_distance(one[k], two[k]))) end
    assert.equal(one[4].pairs, two[4].pairs)
  end)
end)
