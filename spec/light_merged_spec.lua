-- Flat lights that are approximated by spheres times |cos gamma|: many of them are summed by merged moments.

local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"

local relative = require "spec.support.vectors".relative

--- A panel of 9 by 7 parts whose radiances have both signs.
local function panel()
  local rows = {}
  for y = 1, 7 do
    rows[y] = {}
    for x = 1, 9 do rows[y][x] = { math.random(), math.random() - 0.5, 3 * math.random() } end
  end
  return ylm.textured_light { corner = { -1, 0, 0 }, u = { 2, 0, 0.3 }, v = { 0, 2, 0 }, image = rows, method = "spheres" }
end

--- n points around it on both sides; the last one is inside of a part.
local function points(n)
  local list = {}
  for i = 1, n do list[i] = { 6 * math.random() - 3, 4 * math.random() - 1, 4 * math.random() - 2 } end
  list[n] = { -1 + 1 / 9, 1 / 7, 0.03 }
  return ylm.array(list)
end

describe("many flat lights as spheres", function()
  for _, isa in ipairs(ylm.info().kernels) do
    it("are what they are one by one: " .. isa, function()
      math.randomseed(3)
      local lights, x = panel(), points(37)
      for lmax = 0, 12, 2 do
        for derivatives = 0, 2 do
          local o = { derivatives = derivatives, channels = "rgb", metric = derivatives == 2 and "rgb" or nil }
          local wanted = { light.evaluate("spec", lmax, lights.lights, x, o, "reference") }
          local got = { light.evaluate("spec", lmax, lights.lights, x, o, isa) }
          for k = 1, 1 + derivatives do
            assert(relative(got[k], wanted[k]) < 1e-14, ("lmax %d, %d: %.1e"):format(lmax, k,
              relative(got[k], wanted[k])))
          end
          assert.equal(0, (core.array_distance(got[4].inside, wanted[4].inside)))
          assert.equal(1, wanted[4].inside[37])
          if o.metric then assert(relative(got[4].lambda, wanted[4].lambda) < 1e-14) end
        end
      end
    end)
  end

  it("depend on the point and the lights alone", function()
    math.randomseed(4)
    local lights, x = panel(), points(37)
    local all = ylm.light_field(4, lights, x, { derivatives = 2 })
    for _, i in ipairs { 1, 20, 37 } do
      assert.equal(0, (core.array_distance((ylm.light_field(4, lights, x[i], { dtype = "double", derivatives = 2 })), all[i])))
    end
  end)

  it("are summed as a list of polygons and disks too", function()
    local list, sum = {}, nil
    for i = 1, 6 do
      list[i] = ylm.disk_light { at = { i, 0, 2 }, normal = { 0.1 * i, 0.3, 1 }, radius = 0.1 * i, radiance = i,
        method = "sphere" }
    end
    local x = { { 0.3, 0.2, 0 }, { 2, -1, 3 } }
    for i = 1, 6 do
      local L = ylm.light_field(3, list[i], x, { dtype = "double" })
      if not sum then sum = L:clone() else
        for p = 1, 2 do for c = 1, 3 do for k = 1, 16 do sum:set(p, c, k, sum:get(p, c, k) + L:get(p, c, k)) end end end
      end
    end
    assert(relative(ylm.light_field(3, list, x, { dtype = "double" }), sum) < 1e-14)
  end)
end)
