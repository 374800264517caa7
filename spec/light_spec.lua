local ylm = require "ylm"
local numbers = require "spec.support.random"
local core = require "ylm.c.core"
local light = require "ylm.light"

local pi, sqrt = math.pi, math.sqrt

--- Sums of a build for sanitizers round otherwise: -O1 contracts other products.
local build = os.getenv "YLM_BUILD" or ""
local ROUNDING = (build:find "/asan$" or build:find "/threads$") and 1.15 or 1

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
local relative = require "spec.support.vectors".relative

local random, random_points = numbers.spread, numbers.points

local known = require "spec.support.lights"
local random_lights, lone_lights = known.random, known.lone

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

  describe("properties", function()
    local options = { derivatives = 2, channels = "luminance", dtype = "double" }
    local lamps = { ylm.sphere_light { at = { 1, 2, -1 }, radius = 0.7, radiance = 3 },
      ylm.sphere_light { at = { -2, 0.5, 1 }, radius = 0.2, radiance = { 1, 2, -1 } } }

    it("add up: the field of two lights is the sum of their fields", function()
      local points = random_points(20, 3, 11)
      local both = { ylm.light_field(4, lamps, points, options) }
      local one = { ylm.light_field(4, lamps[1], points, options) }
      local two = { ylm.light_field(4, { lamps[2] }, points, options) }
      for k = 1, 3 do
        local a, b, c = both[k]:totable(), one[k]:totable(), two[k]:totable()
        local function add(x, y)
          if type(x) == "number" then return x + y end
          local t = {}
          for i = 1, #x do t[i] = add(x[i], y[i]) end
          return t
        end
        assert.is_true(relative(ylm.array(a), ylm.array(add(b, c))) < 1e-14)
      end
    end)

    it("have gradients and Hessians that central differences confirm", function()
      local step, x = 1e-4, { 0.3, -0.2, 0.6 }
      local _, dL, ddL = ylm.light_field(5, lamps, x, options)
      for axis = 1, 3 do
        local from, to = { x[1], x[2], x[3] }, { x[1], x[2], x[3] }
        from[axis], to[axis] = from[axis] - step, to[axis] + step
        local a, da = ylm.light_field(5, lamps, from, options)
        local b, db = ylm.light_field(5, lamps, to, options)
        local place = { { 1, 2, 3 }, { 2, 4, 5 }, { 3, 5, 6 } }
        for i = 1, 36 do
          assert.near((b:get(1, i) - a:get(1, i)) / (2 * step), dL:get(1, i, axis), 1e-6)
          for other = 1, 3 do
            assert.near((db:get(1, i, other) - da:get(1, i, other)) / (2 * step),
              ddL:get(1, i, place[axis][other]), 1e-5)
          end
        end
      end
    end)

    it("report lambda, the norm of the Hessians' largest eigenvalues, and the norm of the coefficients", function()
      -- A field along one axis has Hessians diag(a, a, b) for m = 0: eigenvalues are on the diagonal.
      local lamp = ylm.sphere_light { at = { 0, 0, 2 }, radius = 0.5, radiance = 1 }
      local L, _, ddL, report = ylm.light_field(0, lamp, { { 0, 0, 0 } },
        { derivatives = 2, channels = "luminance", dtype = "double", metric = "luminance" })
      local largest = math.max(math.abs(ddL:get(1, 1, 1, 1)), math.abs(ddL:get(1, 1, 1, 6)))
      assert.near(largest, report.lambda[1], 1e-14)
      assert.near(L:get(1, 1, 1), report.norm[1], 1e-15)
      assert.equal(1, report.pairs)
    end)

    it("are finite in, on and at the centre of a light, and say so", function()
      local lamp = ylm.sphere_light { at = { 1, 1, 1 }, radius = 0.5, radiance = 2 }
      local points = { { 1, 1, 1 }, { 1.2, 1, 1 }, { 1.5, 1, 1 }, { 1, 1, 3 } }
      for _, isa in ipairs(ylm.info().kernels) do
        for _, dtype in ipairs { "double", "float" } do
          local L, dL, ddL, report = light.evaluate("spec", 3, light.pack(1, "spec", lamp), ylm.array(points, dtype),
            { derivatives = 2, channels = "rgb", metric = "rgb" }, isa)
          for i = 1, 3 do
            assert.near(2 * sqrt(4 * pi), L:get(i, 1, 1), 1e-6)
            for k = 2, 16 do assert.equal(0, L:get(i, 1, k)) end
            assert.equal(0, report.lambda[i])
          end
          local zero = ylm.zeros { 16, 3 }
          assert.equal(0, (core.array_distance(dL[1][1], zero)))
          assert.equal(0, (core.array_distance(ddL[2][2], ylm.zeros { 16, 6 })))
          assert.same({ 1, 1, 1, 0 }, report.inside:totable())
        end
      end
    end)

    it("emit nothing with a radius of 0, wherever the point", function()
      local lamp = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0, radiance = 5 }
      local L, dL, _, report = ylm.light_field(2, lamp, { { 0, 0, 0 }, { 1, 0, 0 } }, { derivatives = 1 })
      assert.equal(0, (core.array_distance(L, ylm.zeros { 2, 3, 9 })))
      assert.equal(0, (core.array_distance(dL, ylm.zeros { 2, 3, 9, 3 })))
      assert.same({ 0, 0 }, report.inside:totable())
    end)

    it("give the same bits whatever the number of threads and the other points of the batch", function()
      local many = random_lights(300, 4, 3)
      for _, dtype in ipairs { "float", "double" } do
        local points = ylm.array(random_points(333, 4, 5), dtype)
        local one = { ylm.light_field(4, many, points, { derivatives = 2, threads = 1 }) }
        local two = { ylm.light_field(4, many, points, { derivatives = 2, threads = 3 }) }
        for k = 1, 3 do assert.equal(0, (core.array_distance(one[k], two[k]))) end
        for i = 1, 333, 37 do
          local L = ylm.light_field(4, many, ylm.array(points[i], dtype), { derivatives = 2 })
          assert.equal(0, (core.array_distance(L, one[1][i])))
        end
      end
    end)

    it("tell which boxes their surfaces cross, by a tree as light by light", function()
      local n, next = 300, random(17)
      local at, radii, boxes = random_points(n, 4, 9), {}, {}
      for i = 1, n do radii[i] = i <= 3 and 1.5 or 0.02 + 0.1 * next() end
      local function crossed(box)
        for i = 1, n do
          local near, far = 0, 0
          for a = 1, 3 do
            local below, above = box[a] - at[i][a], at[i][a] - box[3 + a]
            near = near + math.max(below, above, 0) ^ 2
            far = far + math.min(below, above) ^ 2
          end
          if near <= radii[i] ^ 2 and radii[i] ^ 2 <= far then return 1 end
        end
        return 0
      end
      for i, low in ipairs(random_points(500, 4, 10)) do
        local edge = i % 5 * 0.1
        boxes[i] = { low[1], low[2], low[3], low[1] + edge, low[2] + edge, low[3] + edge }
      end
      local flags = core.field_crosses(ylm.sphere_lights { at = at, radius = radii }.lights, ylm.array(boxes))
      local hits = 0
      for i = 1, #boxes do
        assert.equal(crossed(boxes[i]), flags[i])
        hits = hits + flags[i]
      end
      assert.is_true(hits > 50 and hits < 450)
    end)

    it("sum 1e5 lights in float to 1e-5", function()
      local many, points = random_lights(1e5, 4, 7), random_points(8, 4, 8)
      for _, x in ipairs(points) do x[1] = x[1] + 4.5 end -- beside the lights; see below
      points = ylm.array(points, "float")
      local o = { derivatives = 2, channels = "luminance" }
      local packed = light.pack(1, "spec", many)
      local a = { light.evaluate("spec", 4, packed, points, o) }
      local b = { light.evaluate("spec", 4, packed, ylm.array(points, "double"), o) }
      for k = 1, 3 do assert.is_true(relative(a[k], b[k]) < 1e-5) end
    end)

    it("sum 1e5 lights in float to 1e-5 among them too", function()
      -- Inputs are exact in float: rounding a position to it moves a light beside the point by more than 1e-5.
      local function exact(x) return math.floor(x * 1048576 + 0.5) / 1048576 end
      local next, radii, at = random(23), {}, random_points(1e5, 4, 21)
      for i = 1, 1e5 do
        radii[i] = exact(0.01 + 0.04 * next())
        for a = 1, 3 do at[i][a] = exact(at[i][a]) end
      end
      local packed = light.pack(1, "spec", ylm.sphere_lights { at = at, radius = radii, radiance = 1 })
      local points = ylm.array(random_points(8, 3, 22), "float")
      local o = { derivatives = 2, channels = "luminance" }
      local a = { light.evaluate("spec", 4, packed, points, o) }
      local b = { light.evaluate("spec", 4, packed, ylm.array(points, "double"), o) }
      for k = 1, 3 do assert.is_true(relative(a[k], b[k]) < 1e-5) end
    end)

    it("write where `out` says, and stop where progress returns false", function()
      local out = { ylm.zeros({ 2, 3, 4 }, "float"), ylm.zeros({ 2, 3, 4, 3 }, "float") }
      local points = { { 0, 0, 0 }, { 1, 0, 1 } }
      local L, dL = ylm.light_field(1, lamps, points, { derivatives = 1, out = out })
      local M = ylm.light_field(1, lamps, points)
      assert.equal(out[1], L)
      assert.equal(out[2], dL)
      assert.equal(0, (core.array_distance(L, M)))
      local nothing, message, code = ylm.light_field(1, lamps, points, { progress = function() return false end })
      assert.is_nil(nothing)
      assert.equal("cancelled", message)
      assert.equal("ECANCELLED", code)
    end)
  end)

  describe("agreement", function()
    for _, isa in ipairs(ylm.info().kernels) do
      it("follow the reference vectors: " .. isa, function()
        for _, c in ipairs(vectors()) do
          local lamps = light.pack(1, "spec", ylm.sphere_light { at = c.at, radius = c.radius, radiance = 1 })
          local L, dL, ddL = light.evaluate("spec", c.lmax, lamps, ylm.array({ c.x }, "double"),
            { derivatives = 2, channels = "luminance" }, isa)
          local bound = 1e-13 + 1e-15 * closeness(c.x, c.at, c.radius)
          assert.is_true(relative(L, ylm.array(c.value)) < bound)
          assert.is_true(relative(dL, ylm.array(c.gradient)) < bound)
          assert.is_true(relative(ddL, ylm.array(c.hessian)) < bound)
        end
      end)

      if isa ~= "reference" then
        it("keep the accuracy of float and double from d/r 1.001 to 1e4, at every lmax: " .. isa, function()
          for _, lmax in ipairs { 0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 13, 20, 31 } do
            for _, case in ipairs(lone_lights(lmax + 1)) do
              local o = { derivatives = 2, channels = "luminance", metric = "luminance" }
              local packed, x = light.pack(1, "spec", case.lamp), ylm.array({ case.x }, "double")
              local truth = { light.evaluate("spec", lmax, packed, x, o, "reference") }
              local double = { light.evaluate("spec", lmax, packed, x, o, isa) }
              local float = { light.evaluate("spec", lmax, packed, ylm.array(x, "float"), o, isa) }
              for k = 1, 3 do
                assert.is_true(relative(float[k], truth[k]) < 4e-6 + 1.5e-7 * case.closeness)
                assert.is_true(relative(double[k], truth[k]) < 1e-13 + 1e-15 * case.closeness)
              end
              for _, name in ipairs { "lambda", "norm" } do
                assert.is_true(relative(double[4][name], truth[4][name]) < 1e-13 + 1e-15 * case.closeness)
              end
            end
          end
        end)

        it("keep the accuracy of float in all directions, the poles' neighbourhood included: " .. isa, function()
          for _, lmax in ipairs { 4, 8, 10, 11, 13, 16, 20, 25, 31 } do
            for _, ratio in ipairs { 1.001, 1.1, 10, 1e4, 1e6 } do
              local next, at = random(lmax), {}
              for i = 1, 60 do
                -- on the axis, within 0.6, 6 and 17 degrees of it, anywhere
                local flat, high = ({ 0, 0.02, 0.2, 0.6, 1 })[i % 5 + 1], next() - 0.5
                if flat < 1 then high = high + (high < 0 and -1 or 1) end
                at[i] = { flat * (next() - 0.5), flat * (next() - 0.5), high }
              end
              local points = ylm.array(at, "float")
              local packed = light.pack(1, "spec", ylm.sphere_light { at = { 0, 0, 0 }, radius = 1 / 1024, radiance = 1 })
              local exact = ylm.array(points, "double")
              for i = 1, 60 do -- at `ratio` radii
                local d = sqrt(exact:get(i, 1) ^ 2 + exact:get(i, 2) ^ 2 + exact:get(i, 3) ^ 2) * 1024 / ratio
                for a = 1, 3 do points:set(i, a, points:get(i, a) / d) end
              end
              exact = ylm.array(points, "double")
              local o = { derivatives = 2, channels = "luminance" }
              local truth = { light.evaluate("spec", lmax, packed, exact, o, "reference") }
              local float = { light.evaluate("spec", lmax, packed, points, o, isa) }
              local bound = ROUNDING * (4e-6 + 1.5e-7 * ratio / (ratio - 1))
              for k = 1, 3 do
                for i = 1, 60 do assert.is_true(relative(float[k][i], truth[k][i]) < bound) end
              end
            end
          end
        end)

        it("keep lambda's digits where two eigenvalues are almost alike: " .. isa, function()
          -- Six lamps around the point along turned axes: at lmax 0 eigenvalues of about 3.6, 3.6 (1 - gap), -2.8.
          local turns = random_points(40, 1, 1)
          local worst, dworst = 0, 0
          for _, gap in ipairs { 0, 1e-12, 1e-8, 1e-5, 1e-3 } do
            for i, turn in ipairs(turns) do
              local frame, lamps = ylm.sh.rotation(0, { axis = turn, angle = i }).matrix, {}
              for k = 1, 3 do
                local x, y, z = frame[1][k], frame[2][k], frame[3][k]
                for side = -4, 4, 8 do
                  lamps[#lamps + 1] = ylm.sphere_light { at = { side * x, side * y, side * z }, radius = 0.5,
                    radiance = k == 3 and 0.2 or k == 2 and 1 + gap or 1 }
                end
              end
              local packed = light.pack(1, "spec", lamps)
              local o = { derivatives = 2, channels = "luminance", metric = "luminance" }
              local function lambda(dtype, kernels)
                return (select(4, light.evaluate("spec", 0, packed, ylm.zeros({ 1, 3 }, dtype), o, kernels))).lambda[1]
              end
              local truth = lambda("double", "reference")
              assert.is_true(truth > 1e-4)
              worst = math.max(worst, math.abs(lambda("float", isa) / truth - 1))
              dworst = math.max(dworst, math.abs(lambda("double", isa) / truth - 1))
            end
          end
          assert.is_true(worst < 4e-6, worst)
          assert.is_true(dworst < 1e-14, dworst)
        end)

        it("agrees with the reference for all channels, derivatives and metrics: " .. isa, function()
          local packed = light.pack(1, "spec", random_lights(17, 4, 2))
          local points = random_points(19, 4, 1)
          for _, dtype in ipairs { "float", "double" } do
            local p, bound = ylm.array(points, dtype), dtype == "float" and 2e-5 or 1e-12
            for derivatives = 0, 2 do
              for _, channels in ipairs { "rgb", "luminance" } do
                for _, metric in ipairs { false, "rgb", "luminance" } do
                  for _, lmax in ipairs { 1, 4, 11 } do
                    local o = { derivatives = derivatives, channels = channels, metric = metric or nil }
                    local a = { light.evaluate("spec", lmax, packed, p, o, isa) }
                    local b = { light.evaluate("spec", lmax, packed, p, o, "reference") }
                    for k = 1, derivatives + 1 do assert.is_true(relative(a[k], b[k]) < bound) end
                    for _, name in ipairs(metric and { "lambda", "norm" } or {}) do
                      assert.is_true(relative(a[4][name], b[4][name]) < bound)
                    end
                    assert.equal(0, (core.array_distance(a[4].inside, b[4].inside)))
                  end
                end
              end
            end
          end
        end)
      end
    end
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
