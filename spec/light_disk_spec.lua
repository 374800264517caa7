-- Disk lights: caps, limits of polygons, horizons, derivatives.

local ylm = require "ylm"
local known = require "spec.support.derivatives"
local field, derivatives, against_differences = known.field, known.at, known.errors
local relative = require "spec.support.vectors".relative

describe("ylm.disk_light", function()
  it("seen along its axis is a cap", function()
    for _, d in ipairs { 1e-3, 0.1, 2, 30, 1e3, 1e6 } do
      for _, lmax in ipairs { 4, 40 } do
        local light = ylm.disk_light { at = { 0, 0, d }, normal = { 0, 0, -3 }, radius = 0.7 }
        local L = field(lmax, light, ylm.array({ { 0, 0, 0 } }, "double"), 0)
        local cap = ylm.sh.cap(lmax, { 0, 0, 1 }, math.atan(0.7 / d))
        assert(relative(L, cap) < 1e-13, relative(L, cap))
      end
    end
  end)

  it("is what regular polygons inside and outside of it tend to", function()
    local x, n = { 0.4, 0.3, -0.2 }, 64
    local L = derivatives(6, ylm.disk_light { at = { 0, 0, 1 }, normal = { 0, 0, 1 }, radius = 0.8 }, x)
    local function ring(r)
      local v = {}
      for i = 1, n do v[i] = { r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n), 1 } end
      return derivatives(6, ylm.polygon_light { vertices = v }, x)
    end
    local inner, outer = ring(0.8), ring(0.8 / math.cos(math.pi / n))
    assert(inner[1][1] < L[1][1] and L[1][1] < outer[1][1])
    for k = 1, 49 do -- areas of n-gons are off by 1/3 and 2/3 of their difference, to fourth order in 1/n
      assert.is_near((2 * outer[1][k] + inner[1][k]) / 3, L[1][k], 1e-5)
      for q = 1, 6 do assert.is_near((2 * outer[3][k][q] + inner[3][k][q]) / 3, L[3][k][q], 1e-3) end
    end
  end)

  it("cut in two by horizons is the sum of its halves, values and derivatives", function()
    for _, d in ipairs { 1, 0.1, 1e-3 } do
      local at = { at = { 0.2, d, 0 }, normal = { 0.1, 1, 0.3 }, radius = 0.7 }
      local parts = {}
      for i, up in ipairs { { 1, 0.2, 0.3 }, { -1, -0.2, -0.3 } } do
        parts[i] = derivatives(8, ylm.disk_light { at = at.at, normal = at.normal, radius = at.radius, horizon = up },
          { 0, 0, 0 })
      end
      local whole = derivatives(8, ylm.disk_light(at), { 0, 0, 0 })
      for k = 1, 81 do
        assert.is_near(whole[1][k], parts[1][1][k] + parts[2][1][k], 1e-13)
        for a = 1, 3 do assert.is_near(whole[2][k][a], parts[1][2][k][a] + parts[2][2][k][a], 1e-12 / d) end
        for q = 1, 6 do assert.is_near(whole[3][k][q], parts[1][3][k][q] + parts[2][3][k][q], 1e-12 / d ^ 2) end
      end
    end
  end)

  describe("has gradients and Hessians that are the derivatives of what they derive, to 1e-8", function()
    local cases = {
      { "on its axis", { 0, 0, 0 }, 5e-3 }, { "beside it", { 0.4, 0.2, 0.3 }, 5e-3 },
      { "close to its face", { 0.1, 1.9, 0.3 }, 1e-3 }, { "close to its rim", { 0.7, 1.99, 0 }, 8e-5 },
      { "closest to its rim", { 0.7, 1.9999, 0 }, 8e-7 }, { "far off", { 30, -100, 20 }, 0.5 },
      { "at lmax 30", { 0.4, 0.2, 0.3 }, 1e-3, 30 }, { "farther off", { 3e3, -1e4, 2e3 }, 50 },
      { "cut by a horizon", { 0.1, 0.2, 0.3 }, 4e-3, 4, { 0.5, 0.1, 0.2 } },
    }
    for _, case in ipairs(cases) do
      it(case[1], function()
        local light = ylm.disk_light { at = { 0, 2, 0 }, normal = { 0, 1, 0 }, radius = 0.7, horizon = case[5] }
        local g, h = against_differences(case[4] or 4, light, case[2], case[3])
        assert(g < 1e-8 and h < 1e-8, ("gradient %.1e, Hessian %.1e"):format(g, h))
      end)
    end
  end)

  it("marks points on it", function()
    local light = ylm.disk_light { at = { 0, 2, 0 }, normal = { 0, 1, 0 }, radius = 0.5 }
    local _, _, _, report = ylm.light_field(1, light, { { 0, 2, 0 }, { 0.3, 2, 0.3 }, { 0.6, 2, 0 }, { 0, 1, 0 } })
    assert.same({ 1, 1, 0, 0 }, report.inside:totable())
  end)
end)
