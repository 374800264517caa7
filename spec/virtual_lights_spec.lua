-- Virtual lights: the model against vectors and closed forms, sets, refusals.

local ylm = require "ylm"
local derivatives = require "spec.support.derivatives"
local relative = require "spec.support.vectors".relative

--- The lights of the vectors: { profile, at, normal, radius, shift, core, emission, point, L, dL, ddL }.
local function vectors()
  local lights = {}
  for line in io.lines "spec/data/virtual_lights.txt" do
    local what, rest = line:match "^(%a+) (.*)"
    local n = {}
    for word in (rest or ""):gmatch "%S+" do n[#n + 1] = tonumber(word) end
    if what == "light" then
      lights[#lights + 1] = { profile = rest:match "%a+", at = { n[1], n[2], n[3] }, normal = { n[4], n[5], n[6] },
        radius = n[7], shift = n[8], core = n[9] }
    elseif what then lights[#lights][what] = n end
  end
  return lights
end

local function make(l)
  local profile = l.profile == "far" and "gauss" or l.profile
  local lights = ylm.virtual_lights { at = { l.at }, normal = l.normal and { l.normal }, radius = l.radius, shift = l.shift or 0,
    emission = { { l.emission, l.emission, l.emission } }, profile = profile }
  return l.profile == "far" and lights:split { core = l.core } or lights
end

local function flat(a)
  local list = {}
  for _, row in ipairs(a:totable()) do
    for _, x in ipairs(type(row) == "table" and row or { row }) do list[#list + 1] = x end
  end
  return ylm.array(list)
end

describe("ylm.virtual_lights", function()
  it("agrees with the reference vectors to 1e-12 in double and 4e-6 in float, with gradients and Hessians", function()
    local lights = vectors()
    assert.equal(12, #lights)
    for i, l in ipairs(lights) do
      for dtype, most in pairs { double = 1e-12, float = 4e-6 } do
        local L, dL, ddL = ylm.light_field(4, make(l), ylm.array(l.point, dtype), { derivatives = 2, channels = "luminance" })
        local of = { L, dL, ddL }
        for k, name in ipairs { "L", "dL", "ddL" } do
          local e = relative(flat(of[k][1]), ylm.array(l[name]))
          assert(e < most, ("light %d, %s, %s %s: %g"):format(i, l.profile, dtype, name, e))
        end
      end
    end
  end)

  it("has the derivatives that differences find: no normal, behind, within its radius, near it and at it", function()
    local e = { 2, 0.3, -0.4, 0.5, 0.1, 0.2, -0.3, 0.4, 0.6 }
    for _, profile in ipairs { "gauss", "far", "near", "cap", "point" } do
      local l = { profile = profile == "near" and "far" or profile, at = { 0.1, -0.2, 0.3 }, radius = 0.25, core = 0.75,
        emission = e }
      local all = make(l)
      l.normal, l.shift = { 0.6, 0, 0.8 }, 0.25
      local lights = make(l)
      if profile == "near" then
        l.profile = "gauss"
        lights = select(2, make(l):split { core = 0.75 })
      end
      for _, x in ipairs { { 0.4, 0.5, 0.9 }, { 0.2, -0.25, 0.42 }, { 0.17, -0.2, 0.28 } } do
        local _, second = derivatives.errors(3, lights, x, 1e-3)
        local first = derivatives.errors(3, all, x, 1e-3)
        assert(first < 2e-7 and second < 2e-6, ("%s at %g: %g %g"):format(profile, x[1], first, second))
      end
      local behind = derivatives.at(3, lights, { -1, -0.2, -1 })
      for k = 1, 16 do assert.equal(0, behind[1][k]) end
    end
    for _, x in ipairs { { 0.1, -0.2, 0.3 }, { 0.1 + 1e-12, -0.2, 0.3 } } do
      local here = derivatives.at(2, make { profile = "gauss", at = { 0.1, -0.2, 0.3 }, radius = 0.5, emission = { 1 } }, x)
      assert.is_near(8 / 0.25 / math.sqrt(4 * math.pi) / math.sqrt(4 * math.pi), here[1][1], 1e-9)
      for k = 2, 9 do assert.equal(0, here[1][k]) end
    end
  end)

  it("sends the power that its intensity integrates to", function()
    local at, n = { { 0, 0, 0 } }, { { 0, 0, 1 } }
    local matte = ylm.virtual_lights { at = at, normal = n, radius = 1, intensity = { 1, 2, 3 } }
    local round = ylm.virtual_lights { at = at, radius = 1, intensity = 1 }
    local shifted = ylm.virtual_lights { at = at, normal = n, radius = 1, intensity = 1, shift = 1 }
    assert.is_near(2 * math.pi, matte.power[2], 1e-14)
    assert.is_near(4 * math.pi, round.power[1], 1e-14)
    assert.is_near(4 * math.pi, shifted.power[1], 1e-14)
    -- by a sum over directions
    math.randomseed(5)
    local directions, weights = {}, {}
    for i = 1, 200 do
      for j = 1, 24 do
        local z, phi = -1 + (i - 0.5) / 100, 2 * math.pi * j / 24
        local r = math.sqrt(1 - z * z)
        directions[#directions + 1] = { r * math.cos(phi), r * math.sin(phi), z }
      end
    end
    local Y, normal = ylm.sh.eval(8, ylm.array(directions, "double")), { 0.48, 0.6, 0.64 }
    for _, s in ipairs { 0, 0.4, 1 } do
      local b, sum = {}, 0
      for k = 1, 81 do b[k] = math.random() - 0.5 end
      for i, u in ipairs(directions) do
        local c = s + normal[1] * u[1] + normal[2] * u[2] + normal[3] * u[3]
        weights[i] = 4 * math.pi / #directions * math.max(0, c)
      end
      for i, row in ipairs(Y:totable()) do
        for k = 1, 81 do sum = sum + weights[i] * b[k] * row[k] end
      end
      local lights = ylm.virtual_lights { at = at, normal = { normal }, radius = 1, shift = s, emission = { { b, b, b } } }
      assert.is_near(sum, lights.power[1], 5e-3)
    end
  end)

  it("tells what it is made of", function()
    local lights = ylm.virtual_lights { at = { { 0, 1, 2 }, { 3, 4, 5 } }, normal = { { 0, 0, 1.0005 }, { 0, 0, 0 } },
      radius = { 0.5, 0.25 }, intensity = { { 1, 2, 3 }, { 4, 5, 6 } }, shift = { 0, 0.5 } }
    local at, normal, radius, emission, shift = lights:arrays()
    assert.same({ { 0, 1, 2 }, { 3, 4, 5 } }, at:totable())
    assert.same({ { 0, 0, 1 }, { 0, 0, 0 } }, normal:totable())
    assert.same({ 0.5, 0.25 }, radius:totable())
    assert.same({ 0, 0.5 }, shift:totable())
    assert.is_near(5 * math.sqrt(4 * math.pi), emission:get(2, 2, 1), 1e-14)
    assert.equal("2 virtual lights of degree 0, profile gauss", tostring(lights))
    assert.equal(2, lights.count)
    assert.equal(0, ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }.count)
  end)
end)
