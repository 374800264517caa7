-- Results that their element type cannot hold are refused in a sentence, never handed on.

local core = require "ylm.c.core"
local ylm = require "ylm"

local BIG, nan = 1.7e308, 0 / 0
local origin, box = { { 0, 0, 0 } }, { { -1, -1, -1 }, { 1, 1, 1 } }

local function lamp(radiance) return ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.5, radiance = radiance } end
local function disk(radiance)
  return ylm.disk_light { at = { 0, 0, 3 }, normal = { 0, 0, 1 }, radius = 3, radiance = radiance }
end

--- Calls f, which has to raise at this file's line; its message has to match.
local function refused(pattern, f, ...)
  local ok, message = pcall(f, ...)
  assert(not ok, "nothing was raised: " .. pattern)
  assert.matches("finite_spec.lua:%d+: .*" .. pattern, message)
end

describe("a light field beyond its type", function()
  it("is refused at its point, whatever the lights and however many", function()
    local points = { { 0, 0, -1e15 }, { 0, 0, 1 } } -- 1e-30 of it is left at the first
    local panel = { corner = { -1, -1, 3 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, image = { { 1 } }, scale = 1e52 }
    for _, lights in ipairs { disk(1e52), { disk(1e52), disk(1) }, ylm.textured_light(panel), lamp(1e52),
      { lamp(1e52), disk(1) } } do
      refused("light_field: the light field at point %d, %(0, 0, [-1e+5]*%), is beyond the range of float", function()
        ylm.light_field(2, lights, points)
      end)
      assert.is_true(core.array_finite((ylm.light_field(2, lights, points, { dtype = "double" }))))
    end
    local many = {}
    for i = 1, 100 do many[i] = lamp(3e38) end
    refused("light_field: the light field at point 1", function() ylm.light_field(2, many, origin) end)
    refused("light field.* at point 1", function() -- the Hessian first, or the value, as kernels round
      ylm.light_field(2, ylm.sphere_light { at = { 0, 0, 2e-20 }, radius = 1e-20 }, origin, { derivatives = 2 })
    end)
    refused("gradient at point 1.*beyond the range of double", function()
      ylm.light_field(2, ylm.sphere_light { at = { 0, 0, 1e-9 }, radius = 5e-10, radiance = 1e300 }, origin,
        { dtype = "double", derivatives = 1 })
    end)
  end)

  it("is let pass where it fits, with a metric that ends at the largest number", function()
    local L, _, _, report = ylm.light_field(2, lamp(1e30), origin, { metric = "luminance" })
    assert.is_true(core.array_finite(L))
    assert(report.norm[1] > 3.4e38 and core.array_finite(report.norm) and core.array_finite(report.lambda))
  end)

  it("is refused in grids and their updates, which stay as they were", function()
    local form = { bounds = box, lmax = 1, depth = 2, threshold = 0.1, dynamic = true }
    refused("bake: the light field at point %d+, %(.*%), is beyond", function()
      ylm.bake(ylm.adaptive_grid(form), lamp(1e300))
    end)
    refused("bake: the light field at point %d+", function()
      ylm.bake(ylm.uniform_grid { bounds = box, cells = 2, lmax = 1 }, disk(1e300))
    end)
    local grid = ylm.bake(ylm.adaptive_grid(form), lamp(1))
    local before = grid:sample(origin):totable()
    for _, lights in ipairs { lamp(1e300), disk(1e300) } do
      refused("update: the light field of these lights is beyond the range of float", function() grid:update(lights) end)
      assert.same(before, grid:sample(origin):totable())
    end
  end)

  it("is refused of a function too: values, gradients, lambda", function()
    for i, bad in ipairs { nan, 1 / 0, 1e300 } do
      for k, name in ipairs { "first", "second", "third" } do
        local function field(points, _, channels)
          local results = { ylm.zeros { #points, channels, 1 }, ylm.zeros { #points, channels, 1, 3 }, ylm.zeros { #points } }
          local place = ({ { 1, 1, 1 }, { 1, 1, 1, 1 }, { 1 } })[k]
          place[#place + 1] = bad
          results[k]:set((table.unpack or unpack)(place)) -- luacheck: ignore
          return results[1], results[2], results[3]
        end
        local ok, message = pcall(ylm.bake, ylm.adaptive_grid { bounds = box, lmax = 0, depth = 1, threshold = 1 }, field)
        assert(not ok, i .. name)
        assert.matches("the light field's " .. name .. " result at %(%-1, %-1, %-1%) is not finite", message)
      end
    end
  end)
end)

describe("coefficients beyond their type", function()
  local huge, high = {}, {}
  for i = 1, 9 do huge[i], high[i] = BIG, 1e300 end
  local calls = {
    product = function() return ylm.sh.product(high, high) end,
    rotate = function() return ylm.sh.rotate(huge, { axis = { 1, 1, 0 }, angle = 1 }) end,
    convert = function() return ylm.sh.convert(huge, "n3d") end,
    convolve = function() return ylm.sh.convolve(huge, { BIG, BIG, BIG }) end,
    zonal = function() return ylm.sh.zonal({ BIG, BIG, BIG }, { 0, 0, 1 }) end,
    reconstruct = function() return ylm.sh.reconstruct(huge, { { 1, 1, 1 }, { -1, -1, 1 } }) end,
    project = function() return ylm.sh.project(2, function() return BIG end) end,
    sky = function() return ylm.sh.sky(2, { kind = "clear", sun = { 0, 1, 1 }, luminance = 1e308, nodes = 8 }) end,
    relative_error = function() return ylm.sh.relative_error({ high }, { huge }) end,
    summary = function() return ylm.sh.summary(huge) end,
    dering = function() return ylm.sh.dering(high, { minimum = -1e308 }) end,
    random = function() return ylm.sh.random(2, 2, { high = 1e300, dtype = "float" }) end,
  }
  for name, call in pairs(calls) do
    it("are refused by " .. name, function() refused("beyond the range of %w+", call) end)
  end

  it("are refused in float where double would hold them", function()
    local c = ylm.array({ 1e30, 1e30, 1e30, 1e30 }, "float")
    refused("product: number 1 of the result is beyond the range of float", function() ylm.sh.product(c, c) end)
    refused("product: number 1 .* float", function()
      ylm.sh.product({ 1e30, 0, 0, 0 }, { 1e30, 0, 0, 0 }, { dtype = "float" })
    end)
    refused("project: number 1 .* float", function() ylm.sh.project(2, function() return 1e300 end, { dtype = "float" }) end)
  end)

  it("pass where results fit, though numbers are large", function()
    assert.equal(BIG, ylm.sh.rotate({ BIG, 0, 0, 0 }, { axis = { 0, 0, 1 }, angle = 1 })[1])
    local c = ylm.sh.random(50, 3, { low = -BIG, high = BIG })
    assert.is_true(core.array_within(c, BIG))
    assert.is_false(core.array_within(c, BIG / 2))
    local plain, scaled = ylm.sh.random(50, 3, { low = -8, high = 8 }), ylm.sh.random(50, 3, { low = -BIG, high = BIG })
    for i = 1, 50 do assert.is_near(plain:get(i, 1) / 8, scaled:get(i, 1) / BIG, 1e-15) end
  end)
end)
