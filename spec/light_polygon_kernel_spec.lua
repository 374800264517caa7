-- Kernels of polygon and disk lights, against the reference.

local ylm = require "ylm"
local relative = require "spec.support.vectors".relative

describe("ylm.polygon_light", function()
  describe("has kernels that agree with the reference:", function()
    local light = require "ylm.light"
    --- A convex polygon of n sides in a plane at random; deterministic.
    local state = 7
    local function random()
      state = (state * 16807) % 2147483647
      return state / 2147483647
    end
    local function polygon(n)
      local c, size = { 4 * random() - 2, 1 + random(), 4 * random() - 2 }, 0.05 + random()
      local u = { 1, 0.5 * random(), 0.3 * random() }
      local v = { -0.4 * random(), 0.1, 1 }
      local vertices = {}
      for i = 1, n do
        local a, b = size * math.cos(2 * math.pi * i / n), size * math.sin(2 * math.pi * i / n)
        vertices[i] = {}
        for k = 1, 3 do vertices[i][k] = c[k] + a * u[k] + b * v[k] end
      end
      return ylm.polygon_light { vertices = vertices, radiance = { 1 + random(), 2 * random(), -random() } }
    end
    local lights = {}
    for i = 1, 5 do lights[i] = polygon(2 + 2 * i) end
    lights[6] = ylm.polygon_light { vertices = { { -1, 3, -1 }, { 1, 3, -1 }, { 1, 3, 1 }, { -1, 3, 1 } }, radiance = 2 }
    lights[7] = ylm.disk_light { at = { 0, -2, 0 }, normal = { 0, 1, 0.2 }, radius = 0.5 }
    lights[8] = ylm.disk_light { at = { 1.5, 0.5, -1 }, normal = { -1, 0.3, 0.2 }, radius = 0.8, radiance = { 1, -2, 0.5 } }
    lights[9] = ylm.disk_light { at = { 0.2, 8, 0.1 }, normal = { 0.1, 1, 0 }, radius = 3, radiance = 0.3 }
    local packed, few = light.pack(2, "spec", lights), light.pack(2, "spec", { lights[2], lights[6], lights[9] })
    local points = {}
    for i = 1, 37 do points[i] = { 5 * random() - 2.5, 3 * random() - 1, 5 * random() - 2.5 } end
    -- on the square, in its plane, on an edge's line, at a corner, far, close
    for _, x in ipairs { { 0.2, 3, 0.1 }, { 3, 3, 0 }, { 4, 3, 1 }, { 1, 3, 1 }, { 900, 4000, 30 }, { 0.3, 3 - 1e-5, 0.2 },
      { 1e-9, 2, 0 } } do
      points[#points + 1] = x
    end
    for _, isa in ipairs(ylm.info().kernels) do
      if isa ~= "reference" then
        it(isa, function()
          for _, lmax in ipairs { 0, 1, 2, 4, 7, 20, 60 } do
            for _, dtype in ipairs { "double", "float" } do
              local chosen, some = lmax < 20 and packed or few, {}
              for i = lmax < 20 and 1 or 36, #points do some[#some + 1] = points[i] end
              local x = ylm.array(some, dtype)
              for _, o in ipairs { { 0, "rgb" }, { 1, "luminance" }, { 2, "rgb", "rgb" }, { 2, "luminance", "luminance" } } do
                if lmax < 20 or o[3] == "rgb" then
                  local options = { derivatives = o[1], channels = o[2], metric = o[3] }
                  local a = { light.evaluate("spec", lmax, chosen, x, options, isa) }
                  local b = { light.evaluate("spec", lmax, chosen, x, options, "reference") }
                  assert.same(b[4].inside:totable(), a[4].inside:totable())
                  for k = 1, o[1] + 1 do
                    local worst = 0
                    for i = 1, #some do worst = math.max(worst, relative(a[k][i], b[k][i])) end
                    -- the last point but one is 1e-5 from a face: cancellation there
                    assert(worst < (dtype == "double" and 1e-11 or 2e-6),
                      ("lmax %d %s derivative %d %s: %.1e"):format(lmax, dtype, k - 1, o[2], worst))
                  end
                  if o[3] then assert(relative(a[4].lambda, b[4].lambda) < (dtype == "double" and 1e-11 or 1e-6)) end
                end
              end
            end
          end
        end)

        it(isa .. ", whatever else is in a batch", function()
          local x = ylm.array(points, "double")
          local all = light.evaluate("spec", 4, packed, x, { derivatives = 2, channels = "rgb" }, isa):totable()
          for i = 1, #points, 5 do
            local one = light.evaluate("spec", 4, packed, ylm.array({ points[i] }, "double"),
              { derivatives = 2, channels = "rgb" }, isa)
            assert.same(all[i], one:totable()[1])
          end
        end)
      end
    end
  end)
end)
