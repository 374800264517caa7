-- Light from samples: the blend and its derivatives, samples, limits, what does not see it.

local core = require "ylm.c.core"
local ylm = require "ylm"
local differences = require "spec.support.derivatives".errors
local at = require "spec.support.derivatives".at
local scratch = require "spec.support.scratch"
local relative = require "spec.support.vectors".relative

local places = { { 0, 0, 0 }, { 1, 0.2, -0.1 }, { -0.4, 0.9, 0.3 }, { 0.3, -0.5, 0.8 } }
local lamp = ylm.sphere_light { at = { 0.5, 0.4, 2 }, radius = 0.2, radiance = { 3, 2, 1 } }
local function sampled(power, lmax) return ylm.sampled_light { at = places, lights = lamp, power = power, lmax = lmax } end

describe("ylm.sampled_light", function()
  it("is the mean of the samples by 1/distance^power", function()
    local x = { 0.2, 0.3, 0.4 }
    for _, power in ipairs { 2, 3.5, 10 } do
      local wanted, all = {}, 0
      for _, p in ipairs(places) do
        local d = math.sqrt((x[1] - p[1]) ^ 2 + (x[2] - p[2]) ^ 2 + (x[3] - p[3]) ^ 2)
        local u = d ^ -power
        all = all + u
        for k, v in ipairs(ylm.light_field(3, lamp, p, { dtype = "double" })[1]:totable()) do
          wanted[k] = (wanted[k] or 0) + u * v
        end
      end
      for k = 1, #wanted do wanted[k] = wanted[k] / all end
      local L = ylm.light_field(3, sampled(power), x, { dtype = "double" })
      assert(relative(L[1], ylm.array(wanted)) < 1e-14, power)
    end
  end)

  it("is each sample's own light there, at rest", function()
    for _, power in ipairs { 2, 2.5, 10, 100 } do
      for i, p in ipairs(places) do
        local L, dL, ddL = ylm.light_field(4, sampled(power), p, { dtype = "double", derivatives = 2 })
        assert.equal(0, relative(L, ylm.light_field(4, lamp, places, { dtype = "double" })[i]))
        assert(core.array_within(dL, 0), power)
        assert.equal(power > 2, core.array_within(ddL, 0))
      end
    end
  end)

  it("has the derivatives that differences find, at samples, near them and far away", function()
    for _, power in ipairs { 2, 3, 10 } do
      local light = sampled(power)
      for _, x in ipairs { { 0.4, 0.1, 0.2 }, { 0.15, 0.1, 0.2 }, { 0.3, 0.35, 0.05 }, { 5, -4, 7 } } do
        local first, second = differences(3, light, x, 1e-3 * math.max(0.05, math.abs(x[1])))
        assert(first < 1e-7 and second < 1e-7, ("%g: %g %g"):format(power, first, second))
      end
    end
    -- with power 2 it bends at the samples themselves: second differences of the value
    local H, h = at(3, sampled(2), places[1])[3], 1e-4
    local function value(x) return at(3, sampled(2), x)[1] end
    local here, left, right = value(places[1]), value { -h, 0, 0 }, value { h, 0, 0 }
    for k = 1, 16 do
      assert.is_near((left[k] - 2 * here[k] + right[k]) / h ^ 2, H[k][1], 1e-3 * math.abs(H[1][1]))
    end
  end)

  it("keeps its digits a hair's breadth from a sample", function()
    local light, x = sampled(10), { 1e-12, 2e-12, -1e-12 }
    local near = at(3, light, x)
    for k = 1, 16 do
      assert.is_near(at(3, light, places[1])[1][k], near[1][k], 1e-15)
      for a = 1, 3 do assert.is_near(0, near[2][k][a], 1e-80) end
      for a = 1, 6 do assert.is_near(0, near[3][k][a], 1e-60) end
    end
  end)

  it("takes coefficients, of three channels or grey, of any convention", function()
    local c = ylm.light_field(2, lamp, places, { dtype = "double" })
    local x = { { 0.1, 0.2, 0.3 }, { 1, 1, 1 } }
    local wanted = ylm.light_field(2, sampled(10), x, { dtype = "double" })
    local light = ylm.sampled_light { at = ylm.array(places), coefficients = c }
    assert(relative(ylm.light_field(2, light, x, { dtype = "double" }), wanted) < 1e-15)
    assert.equal("sampled_light of 4 places, lmax 2", tostring(light))
    local other = ylm.sampled_light { at = places, coefficients = ylm.sh.convert(c, "n3d") }
    assert(relative(ylm.light_field(2, other, x, { dtype = "double" }), wanted) < 1e-15)
    local rows = {}
    for i = 1, #places do rows[i] = c[i][1]:totable() end
    local grey = ylm.light_field(2, ylm.sampled_light { at = places, coefficients = rows }, x, { dtype = "double" })
    for i = 1, 2 do
      for channel = 1, 3 do assert(relative(grey[i][channel], wanted[i][1]) < 1e-15) end
    end
  end)

  it("adds up with lights, is baked by grids, and is the same for any number of threads", function()
    local light, x = sampled(10), ylm.zeros { 300, 3 }
    for i = 1, 300 do x:set(i, 1, (i % 7) / 5 - 0.4) x:set(i, 2, (i % 11) / 9) end
    local o = { dtype = "double", threads = 1, derivatives = 2, metric = "rgb" }
    local L, _, H, report = ylm.light_field(3, { light, lamp }, x, o)
    local own, lamps = ylm.light_field(3, light, x, o), ylm.light_field(3, lamp, x, o)
    for i = 1, 300, 37 do
      for k = 1, 16 do assert.is_near(own:get(i, 2, k) + lamps:get(i, 2, k), L:get(i, 2, k), 1e-15) end
    end
    o.threads = 7
    local again, _, bend, told = ylm.light_field(3, { light, lamp }, x, o)
    assert.equal(0, relative(again, L) + relative(bend, H) + relative(told.lambda, report.lambda))
    local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -0.2, -0.2, -0.2 }, { 0.6, 0.6, 0.6 } }, lmax = 3,
      channels = "luminance", tolerance = 0.01 }, light)
    local p = { { 0.1, 0.2, 0.3 }, { 0.5, 0.4, 0.1 } }
    local asked = { channels = "luminance", dtype = "double" }
    local wanted = ylm.light_field(3, light, p, asked)
    assert(relative(ylm.array(grid:sample(p), "double"), wanted) < 0.02)
  end)

  it("is part of scene files, within their limits", function()
    local folder = scratch.new()
    local function scene(light, limits)
      local text = ('return scene "s" { geometry = sphere {}, lights = %s }'):format(light)
      return ylm.load(folder:write("s.lua", text), limits)
    end
    local loaded = assert(scene [[
      sampled_light { at = { { 0, 1, 0 }, { 1, 0, 0 } }, lights = sphere_light { at = { 0, 3, 0 } } }]])
    assert.equal("sampled_light of 2 places, lmax 4", tostring(loaded.lights[1] or loaded.lights))
    local text = [[sampled_light { at = { { 0, 1, 0 } }, lmax = 60, lights = sphere_light { at = { 0, 3, 0 } } }]]
    local none, message = scene(text, { numbers = 1000 })
    folder:remove()
    assert.is_nil(none)
    assert.truthy(message:find("more than 1000 numbers in one scene file", 1, true), message)
  end)
end)
