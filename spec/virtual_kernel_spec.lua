-- Kernels of virtual lights: each instruction set agrees with the reference.

local array = require "ylm.array"
local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"

--- n lights of a degree by math.random as it is seeded; near points, some without a normal.
local function lights(n, degree, profile)
  local at, normal, radius, shift, emission = {}, {}, {}, {}, {}
  local function number() return 2 * math.random() - 1 end
  for i = 1, n do
    at[i], radius[i], shift[i], emission[i] = { number(), number(), number() }, 0.02 + 0.2 * math.random(), math.random(), {}
    local x, y, z = number(), number(), number()
    local length = math.sqrt(x * x + y * y + z * z)
    normal[i] = i % 5 == 0 and { 0, 0, 0 } or { x / length, y / length, z / length }
    for c = 1, 3 do
      emission[i][c] = {}
      for k = 1, (degree + 1) ^ 2 do emission[i][c][k] = number() end
    end
  end
  local split = profile == "far" or profile == "near"
  local all = ylm.virtual_lights { at = at, normal = normal, radius = radius, shift = shift, emission = emission,
    profile = split and "gauss" or profile }
  if not split then return all end
  local far, near = all:split { core = 0.6 }
  return profile == "far" and far or near
end

local function points(n, dtype)
  local p = {}
  for i = 1, n do p[i] = { 2.4 * math.random() - 1.2, 2.4 * math.random() - 1.2, 2.4 * math.random() - 1.2 } end
  return (array.points(1, "spec", p, dtype))
end

--- The error of all points, relative to the norm of their results.
local function error_of(a, b)
  local _, difference, norm = core.array_distance(a, b)
  return difference / norm
end

local wants = {
  { derivatives = 0, channels = "rgb" }, { derivatives = 1, channels = "rgb" }, { derivatives = 2, channels = "rgb" },
  { derivatives = 0, channels = "luminance" }, { derivatives = 2, channels = "luminance", metric = "rgb" },
  { derivatives = 1, channels = "rgb", metric = "luminance" }, { derivatives = 0, channels = "rgb", metric = "rgb" },
  { derivatives = 1, channels = "luminance" }, { derivatives = 0, channels = "luminance", metric = "luminance" },
  { derivatives = 1, channels = "rgb", metric = "luminance", rough = true },
  { derivatives = 0, channels = "rgb", metric = "luminance", rough = true },
  { derivatives = 2, channels = "rgb", metric = "luminance", rough = true },
  { derivatives = 1, channels = "rgb", metric = "rgb", rough = true },
}

--- Asserts that the kernels of each instruction set agree with the reference on this query.
local function agree(l, lmax, p, want, most, what)
  local b = { light.evaluate("spec", lmax, l.lights, p, want, "reference") }
  for _, isa in ipairs(ylm.info().kernels) do
    local a = { light.evaluate("spec", lmax, l.lights, p, want, isa) }
    for k = 1, want.derivatives + 1 do
      local e = error_of(a[k], b[k])
      assert(e < most, ("%s %s lmax %d, derivatives %d of %d, %s: %g"):format(isa, what, lmax, k - 1, want.derivatives,
        want.channels, e))
    end
    for _, name in ipairs(want.metric and { "lambda", "norm" } or {}) do
      local e = error_of(a[4][name], b[4][name])
      assert(e < most, ("%s %s lmax %d %s of %s: %g"):format(isa, what, lmax, name, want.metric, e))
    end
  end
end

describe("kernels of virtual lights", function()
  it("agree with the reference, of every instruction set, profile, degree and want", function()
    math.randomseed(3)
    for i, profile in ipairs { "gauss", "cap", "point", "far", "near" } do
      for _, degree in ipairs { 0, 1, 2, 5, 8 } do
        local l = lights(5, degree, profile)
        for k = (i + degree) % 5 + 1, #wants, 5 do
          local lmax = (i + degree + 2 * k) % 6
          agree(l, lmax, points(5, "double"), wants[k], 1e-12, profile .. " " .. degree)
          agree(l, lmax, points(5, "float"), wants[k], 2e-5, profile .. " " .. degree)
        end
      end
    end
  end)

  it("agree with it of lmax up to 12, and of any number of lights", function()
    math.randomseed(4)
    local l = lights(9, 2, "gauss")
    for lmax = 0, 12, 3 do
      agree(l, lmax, points(5, "double"), wants[2], 1e-12, "gauss 2")
      agree(l, lmax, points(5, "float"), wants[2], 2e-5, "gauss 2")
    end
    for _, n in ipairs { 1, 8, 9, 129 } do
      agree(lights(n, 0, "gauss"), 2, points(3, "float"), wants[2], 1e-5, "gauss 0")
    end
    for lmax = 7, 8 do agree(lights(9, 0, "far"), lmax, points(5, "float"), wants[10], 2e-5, "far 0") end
  end)

  it("give a point the same whatever is beside it", function()
    math.randomseed(6)
    local l, p = lights(300, 2, "far"), points(40, "float")
    local all = { ylm.light_field(4, l, p, { derivatives = 2 }) }
    for _, i in ipairs { 1, 17, 40 } do
      local one = { ylm.light_field(4, l, p[i], { derivatives = 2 }) }
      for k = 1, 3 do
        local _, e = core.array_distance(all[k][i], one[k])
        assert.equal(0, e)
      end
    end
  end)
end)
