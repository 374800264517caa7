-- Virtual lights: the model against vectors and closed forms, sets, refusals.

local core = require "ylm.c.core"
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

  local origin = { { 0, 0, 0 } }
  local function double(lmax, l, x)
    return ylm.light_field(lmax, l, ylm.array(x, "double"), { derivatives = 2, channels = "luminance" })
  end

  it("is a sphere light outside of a cap, and a point in the limit", function()
    local ball = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.3, radiance = 2 / (math.pi * 0.09) }
    local cap = ylm.virtual_lights { at = origin, radius = 0.3, intensity = 2, profile = "cap" }
    local a, b = { double(6, cap, { { 0.3, 0.5, -0.2 } }) }, { double(6, ball, { { 0.3, 0.5, -0.2 } }) }
    for k = 1, 3 do assert(relative(a[k], b[k]) < 1e-14) end
    local x = { { 0.6, 0, 0.8 } }
    local point = (double(4, ylm.virtual_lights { at = origin, intensity = 1, profile = "point" }, x))
    for _, profile in ipairs { "gauss", "cap" } do
      local errors = {}
      for i, r in ipairs { 0.02, 0.01 } do
        local L = double(4, ylm.virtual_lights { at = origin, radius = r, intensity = 1, profile = profile }, x)
        errors[i] = relative(L, point)
      end
      assert.is_near(4, errors[1] / errors[2], 0.01)
    end
  end)

  it("makes a floor of lights that shines on a ceiling by pi and on a wall by half of that", function()
    local at, normal, intensity, rings, last = {}, {}, {}, 160, 0.01
    for i = 1, rings do
      local r = 0.01 * 10 ^ (4.5 * i / rings)
      local area, middle = math.pi * (r * r - (i > 1 and last * last or 0)) / 24, math.sqrt((r * r + last * last) / 2)
      for j = 1, 24 do
        local phi = 2 * math.pi * (j + 0.5 * (i % 2)) / 24
        at[#at + 1] = { middle * math.cos(phi), middle * math.sin(phi), 0 }
        normal[#at], intensity[#at] = { 0, 0, 1 }, area
      end
      last = r
    end
    local floor = ylm.virtual_lights { at = at, normal = normal, intensity = intensity, profile = "point" }
    local L = ylm.light_field(4, floor, { 0, 0, 1 }, { dtype = "double", channels = "luminance" })
    local E = ylm.sh.irradiance(L, { { 0, 0, -1 }, { 1, 0, 0 } })
    assert.is_near(math.pi, E:get(1, 1), 0.03)
    assert.is_near(math.pi / 2, E:get(1, 2), 0.03)
    assert.is_near(2 * math.pi / math.sqrt(4 * math.pi), L:get(1, 1), 0.02)
    assert.is_near(-math.pi * math.sqrt(3 / (4 * math.pi)), L:get(1, 3), 0.02)
  end)

  it("sends 31/32 of its flux at lmax 4, and 17/16 at lmax 2, through a surface that faces it", function()
    local one = ylm.virtual_lights { at = origin, normal = { { 0, 0, 1 } }, intensity = 1, profile = "point" }
    for lmax, share in pairs { [4] = 0.96875, [2] = 1.0625 } do
      local L, sum = double(lmax, one, { { 0, 0, 2 } }):totable()[1][1], 0
      for l = 0, lmax do -- L is along -z
        local a = l == 0 and math.pi or l == 1 and 2 * math.pi / 3 or l == 2 and math.pi / 4 or l == 4 and -math.pi / 24 or 0
        sum = sum + a * L[l * l + l + 1] * math.sqrt((2 * l + 1) / (4 * math.pi)) * (-1) ^ l
      end
      assert.is_near(share / 4, sum, 1e-14)
    end
  end)

  it("is linear, obeys Laplace, is nothing in its own plane", function()
    local e = { 1, 0.3, -0.2, 0.5 }
    local function of(scale, profile)
      local b = {}
      for k = 1, 4 do b[k] = scale * e[k] end
      return ylm.virtual_lights { at = origin, normal = { { 0, 0, 1 } }, radius = 0.2, emission = { { b, b, b } },
        profile = profile }
    end
    local x = { { 0.2, 0.4, 0.7 } }
    local L, whole = double(4, of(1), x), double(4, of(3), x)
    for k = 1, 25 do assert.is_near(3 * L:get(1, 1, k), whole:get(1, 1, k), 1e-14) end
    assert(relative((double(4, { of(1), of(2) }, x)), whole) < 1e-14)
    assert(core.array_within(ylm.light_field(4, of(1), { { 1, 2, 0 } }), 0))
    local far, near = of(3):split { core = 0.7 }
    local parts, all = { double(4, { far, near }, x) }, { double(4, of(3), x) }
    for k = 1, 3 do assert(relative(parts[k], all[k]) < 1e-13) end
    local point = ylm.virtual_lights { at = origin, intensity = 1, profile = "point" }
    local value, _, H = double(4, point, x)
    for l = 0, 4 do
      for m = -l, l do
        local k = l * (l + 1) + m + 1
        local trace = H:get(1, 1, k, 1) + H:get(1, 1, k, 4) + H:get(1, 1, k, 6)
        assert.is_near((l + 2) * (1 - l) * value:get(1, 1, k) / 0.69, trace, 1e-13)
      end
    end
  end)

  --- Lights and points in the unit cube, by math.random as it is seeded.
  local function cloud(n, points)
    local at, normal, intensity, x, N = {}, {}, {}, {}, {}
    for i = 1, math.max(n, points) do
      at[i] = { math.random(), math.random(), math.random() }
      normal[i] = i % 2 == 0 and { 0, 0.6, 0.8 } or { 0, 0, -1 }
      intensity[i] = { math.random(), 1, 2 }
    end
    for i = 1, points do
      x[i], N[i] = { math.random(), math.random(), math.random() }, i % 2 == 0 and { 0, 1, 0 } or { 0.6, 0, -0.8 }
    end
    for i = n + 1, #at do at[i], normal[i], intensity[i] = nil, nil, nil end
    return { at = at, normal = normal, intensity = intensity, radius = 0.02 }, x, N
  end

  it("sums near parts as their field does, as far as they reach", function()
    math.randomseed(8)
    local l, x, N = cloud(40, 70)
    local _, near = ylm.virtual_lights(l):split { core = 1.2 }
    local L, wanted = near:near_field(4, x), ylm.light_field(4, near, x)
    assert(relative(L, wanted) < 4e-6)
    local E, Y = near:irradiance(x, N):totable(), ylm.sh.eval(4, ylm.array(N)):totable()
    local a = { math.pi, 2 * math.pi / 3, math.pi / 4, 0, -math.pi / 24 }
    for i, row in ipairs(wanted:totable()) do
      local sum = 0
      for k = 1, 25 do sum = sum + a[math.floor(math.sqrt(k - 0.5)) + 1] * row[1][k] * Y[i][k] end
      assert.is_near(sum, E[i][1], 2e-5 * (1 + math.abs(sum)))
    end
    -- what is farther than 1.6 cores counts as nothing
    local _, small = ylm.virtual_lights(l):split { core = 0.15 }
    local found = small:near_field(2, x)
    for i = 1, 70, 9 do
      local inside = { at = {}, normal = {}, intensity = {}, radius = 0.02 }
      for k, p in ipairs(l.at) do
        if (p[1] - x[i][1]) ^ 2 + (p[2] - x[i][2]) ^ 2 + (p[3] - x[i][3]) ^ 2 < 0.24 ^ 2 then
          local n = #inside.at + 1
          inside.at[n], inside.normal[n], inside.intensity[n] = p, l.normal[k], l.intensity[k]
        end
      end
      local _, few = ylm.virtual_lights(inside):split { core = 0.15 }
      local own = ylm.light_field(2, few, x[i])
      for k = 1, 9 do assert.is_near(own:get(2, k), found:get(i, 2, k), 1e-4) end
    end
    local auto = ylm.virtual_lights(l):split()
    assert.is_near(2 * 0.02 * math.sqrt(math.pi) / 1.5, auto.core, 1e-12)
  end)

  it("turns as the scene does", function()
    math.randomseed(9)
    local R = { { 1 / 3, -2 / 3, 2 / 3 }, { 2 / 3, -1 / 3, -2 / 3 }, { 2 / 3, 2 / 3, 1 / 3 } }
    local b, x, n = {}, { 0.5, -0.4, 0.9 }, { 0.6, 0, 0.8 }
    for k = 1, 9 do b[k] = math.random() - 0.5 end
    local function of(normal, e)
      return ylm.virtual_lights { at = origin, normal = { normal }, radius = 0.3, emission = { { e, e, e } } }
    end
    local c = ylm.sh.rotate(ylm.array(b), R):totable()
    local turned = ylm.sh.rotate(double(4, of(n, b), { x })[1][1], R)
    local function turn(v)
      local out = {}
      for i = 1, 3 do out[i] = R[i][1] * v[1] + R[i][2] * v[2] + R[i][3] * v[3] end
      return out
    end
    assert(relative(double(4, of(turn(n), c), { turn(x) })[1][1], turned) < 1e-13)
  end)

  it("is baked by grids, and drawn by transfer vectors", function()
    local lights = ylm.virtual_lights { at = { { 0, 0, 2 } }, normal = { { 0, 0, -1 } }, radius = 0.3, intensity = 5 }
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, 0 }, { 1, 1, 1 } }, cells = { 8, 8, 8 }, lmax = 3 }, lights)
    local x = { { 0.1, 0.2, 0.3 } }
    assert(relative(grid:sample(x), ylm.light_field(3, lights, x)) < 1e-3)
    local floor = ylm.quad { corner = { -1, -1, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    local scene = ylm.scene "s" { geometry = floor, lights = lights,
      camera = ylm.camera { from = { 2, 2, 2 }, at = { 0, 0, 0 } } }
    local image = assert(scene:render { by = "sum", size = { 16, 9 }, samples = 1, lmax = 3, visibility = "transfer" })
    local sum = 0
    for _, row in ipairs(image:layer("radiance"):totable()) do for _, p in ipairs(row) do sum = sum + p[1] end end
    assert(sum > 0)
    for _, name in ipairs { "pathtrace", "render" } do
      local good, message = pcall(scene[name], scene, { size = { 16, 9 }, samples = 1 })
      assert.equal(false, good)
      assert.truthy(message:find("virtual lights have no body, so rays see nothing of them", 1, true), message)
    end
  end)

  it("refuses what is wrong with a sentence that names field and light", function()
    local function said(given, wanted)
      local l = { at = { { 0, 0, 0 }, { 1, 0, 0 } }, radius = 0.1, intensity = 1 }
      for k, v in pairs(given) do l[k] = v ~= "none" and v or nil end
      local good, message = pcall(ylm.virtual_lights, l)
      assert.equal(false, good)
      assert.truthy(message:find(wanted, 1, true), message)
    end
    local nan = 0 / 0
    said({ radius = { 0.1, 0 } }, "light 2: radius must be above 0 for profile 'gauss'; profile 'point' has none")
    said({ radius = "none" }, "field 'radius' is missing: profile 'gauss' has one")
    said({ radius = { 0.1, -1 } }, "light 2: radius must be 0 to 1e+15, got -1")
    said({ radius = { 0.1, nan } }, "light 2: radius must be")
    said({ radius = { 1, 2, 3 } }, "radius must be a number, or one for each of the 2 lights")
    said({ at = { { 0, 0, 0 }, { 1e16, 0, 0 } } }, "light 2: its place is not finite, or beyond 1e+15")
    said({ normal = { { 0, 0, 1 }, { 0, 0, 2 } } }, "light 2: its normal must have length 1, or be 0")
    said({ normal = { { 0, 0, 1 } } }, "normal must be [2][3] numbers, one for each light")
    said({ shift = 2 }, "light 1: shift must be 0 to 1, got 2")
    said({ intensity = { 1, nan } }, "light 2: its emission is not finite")
    said({ intensity = "none" }, "give one of intensity and emission")
    said({ emission = { { { 1 }, { 1 }, { 1 } } } }, "give one of intensity and emission, not both")
    said({ intensity = "none", emission = { { 1, 2 } } }, "emission must be [2][3][(degree+1)^2] numbers, degree 0 to 8")
    said({ profile = "far" }, "profile must be one of 'gauss', 'cap', 'point'")
    local l = ylm.virtual_lights { at = origin, radius = 0.1, intensity = 1 }
    local function fails(f, wanted)
      local good, message = pcall(f)
      assert.equal(false, good)
      assert.truthy(message:find(wanted, 1, true), message)
    end
    fails(function() l:split { core = 0.1 } end, "light 1: core must be above the radius: core 0.1, radius 0.1")
    fails(function() l:split { core = 0 } end, "core must be a number > 0, or 'auto'")
    local far, near = l:split { core = 1 }
    fails(function() far:split {} end, "lights of profile 'gauss' are split, and these are 'far'")
    fails(function() l:irradiance({ { 0, 0, 0 } }, { { 0, 0, 1 } }) end, "the near part of split lights is gathered")
    fails(function() near:irradiance({ { 0, 0, 0 } }, { { 0, 0, 1 }, { 0, 0, 1 } }) end, "one normal for each of 1 points")
    fails(function() near:irradiance({ { 0, 0, 0 } }, { { 0, 0, 1e30 } }) end, "normal 1 must have length 1, its length is 1e+30")
    fails(function() l:split { core = 1e300 } end, "core of profile 'far' must be above 0 and at most 1e+15")
    far, near = ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }:split()
    assert.equal(0, far.count + near:irradiance({ { 0, 0, 0 } }, { { 0, 0, 1 } }):get(1, 1))
    far, near = l:split { core = 1 }
    local box = { { -1, -1, -1 }, { 1, 1, 1 } }
    fails(function() ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2 }, near) end, "near lights are gathered")
    fails(function() ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, dynamic = true }, l) end,
      "follows sphere lights and flat lights, this is baked from virtual lights")
  end)
end)
