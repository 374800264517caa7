local ylm = require "ylm"
local core = require "ylm.c.core"
local light = require "ylm.light"

local pi, sqrt = math.pi, math.sqrt

--- The lights of spec/data/sphere_light.txt: { x, at, radius, lmax, value, gradient, hessian }.
local function vectors()
  local cases, last = {}, nil
  for line in io.lines("spec/data/sphere_light.txt") do
    if line:sub(1, 1) ~= "#" then
      local t = {}
      for word in line:gmatch("%S+") do t[#t + 1] = tonumber(word) end
      local key = table.concat(t, " ", 1, 7)
      if key ~= last then
        last = key
        cases[#cases + 1] = { x = { t[1], t[2], t[3] }, at = { t[4], t[5], t[6] }, radius = t[7], lmax = 8,
          value = {}, gradient = {}, hessian = {} }
      end
      local c = cases[#cases]
      c.value[#c.value + 1] = t[10]
      c.gradient[#c.gradient + 1] = { t[11], t[12], t[13] }
      c.hessian[#c.hessian + 1] = { t[14], t[15], t[16], t[17], t[18], t[19] }
    end
  end
  return cases
end

--- d / r of one light and a point.
local function closeness(x, at, r)
  local d = sqrt((x[1] - at[1]) ^ 2 + (x[2] - at[2]) ^ 2 + (x[3] - at[3]) ^ 2)
  return d / (d - r)
end

--- The L2 norm of a-b relative to that of b.
local function relative(a, b)
  local _, e, n = core.array_distance(a, b)
  return e / n
end

describe("sphere lights", function()
  describe("convention", function()
    it("give pi times sin^2 and the signs of Y_1m for light from +x, +y, +z", function()
      for axis, index in ipairs { 4, 2, 3 } do
        local at = { 0, 0, 0 }
        at[axis] = 2
        local L = ylm.light_field(1, ylm.sphere_light { at = at, radius = 1, radiance = 1 }, { 0, 0, 0 },
          { channels = "luminance", dtype = "double" })
        local sign = axis == 3 and 1 or -1
        assert.near(sign * sqrt(3 / (4 * pi)) * pi / 4, L:get(1, index), 1e-14)
        assert.near(2 * pi * (1 - sqrt(0.75)) / sqrt(4 * pi), L:get(1, 1), 1e-14)
      end
    end)

    it("keep rgb apart and weigh luminance by Rec. 709", function()
      local lamp = ylm.sphere_light { at = { 1, 2, 3 }, radius = 0.5, radiance = { 1, 2, 3 } }
      local rgb = ylm.light_field(2, lamp, { 0, 0, 0 }, { dtype = "double" })
      local lum = ylm.light_field(2, lamp, { 0, 0, 0 }, { dtype = "double", channels = "luminance" })
      assert.same({ 3, 9 }, rgb.shape)
      assert.same({ 1, 9 }, lum.shape)
      for i = 1, 9 do
        local r = rgb:get(1, i)
        assert.near(2 * r, rgb:get(2, i), 1e-15)
        assert.near(3 * r, rgb:get(3, i), 1e-15)
        assert.near((0.2126 + 2 * 0.7152 + 3 * 0.0722) * r, lum:get(1, i), 1e-14)
      end
    end)
  end)

  describe("agreement", function()
    it("follow the reference vectors by the product rule", function()
      for _, c in ipairs(vectors()) do
        local lamps = light.pack(1, "spec", ylm.sphere_light { at = c.at, radius = c.radius, radiance = 1 })
        local L, dL, ddL = light.evaluate("spec", c.lmax, lamps, ylm.array({ c.x }, "double"),
          { derivatives = 2, channels = "luminance" }, "reference")
        local bound = 1e-13 + 1e-15 * closeness(c.x, c.at, c.radius)
        assert.is_true(relative(L, ylm.array(c.value)) < bound)
        assert.is_true(relative(dL, ylm.array(c.gradient)) < bound)
        assert.is_true(relative(ddL, ylm.array(c.hessian)) < bound)
      end
    end)
  end)

  describe("refusals", function()
    for name, cases in pairs(dofile "spec/support/refusals/light.lua") do
      it("of " .. name .. " teach", function()
        for i, case in ipairs(cases) do
          local ok, result, message = pcall(case.call, ylm)
          if ok then ok, result = result ~= nil, message end
          assert.is_false(ok, ("case %d of %s was accepted"):format(i, name))
          assert.truthy(tostring(result):find(case.says), ("case %d of %s: %s"):format(i, name, tostring(result)))
        end
      end)
    end
  end)
end)
