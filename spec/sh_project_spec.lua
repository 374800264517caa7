local core = require "ylm.c.core"
local ylm = require "ylm"

local pi = math.pi

local relative = require "spec.support.vectors".relative

--- Sets of spec/data/projections.txt: { kind =, u =, a =, b =, c = 36 numbers }.
local function reference()
  local list, by_key = {}, {}
  for line in io.lines "spec/data/projections.txt" do
    local kind, rest = line:match "^(%l+) (.*)"
    if kind then
      local n = {}
      for w in rest:gmatch "%S+" do n[#n + 1] = tonumber(w) end
      local key = ("%s %g %g %g %g %g"):format(kind, n[1], n[2], n[3], n[4], n[5])
      local set = by_key[key]
      if not set then
        local length = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
        set = { kind = kind, u = length > 0 and { n[1] / length, n[2] / length, n[3] / length }, a = n[4], b = n[5],
          c = {} }
        by_key[key], list[#list + 1] = set, set
      end
      set.c[n[6] * (n[6] + 1) + n[7] + 1] = n[8]
    end
  end
  return list
end

--- The function of a set.
local function function_of(set)
  local u = set.u
  if set.kind == "overcast" then
    return function(x, y, z)
      local c = u[1] * x + u[2] * y + u[3] * z
      return c > 0 and (1 + 2 * c) / 3 or 0
    end
  elseif set.kind == "cosine" then return function(x, y, z) return math.max(0, u[1] * x + u[2] * y + u[3] * z) end
  elseif set.kind == "lobe" then
    return function(x, y, z) return math.max(0, set.a * (u[1] * x + u[2] * y + u[3] * z) - set.b) end
  end
  return function(x, y, z) -- Green 2003: the "-3" belongs inside
    local theta, phi = math.acos(math.max(-1, math.min(1, z))), (math.atan2 or math.atan)(y, x)
    return math.max(0, 5 * math.cos(theta) - 4) + math.max(0, -4 * math.sin(theta - pi) * math.cos(phi - 2.5) - 3)
  end
end

describe("ylm.sh.project", function()
  it("gives back the coefficients of what is a sum of basis functions, one and three channels", function()
    local c = {}
    for i = 1, 25 do c[i] = (i * 7 % 11 - 5) / 5 end
    local function f(x, y, z) return ylm.sh.reconstruct(c, { x, y, z }) end
    local got, report = ylm.sh.project(4, f, { samples = 200 })
    assert(relative(got, ylm.array(c)) < 1e-13)
    assert.equal("quadrature", report.method)
    local rgb = ylm.sh.project(2, function(x, y, z) return x, y * y, 3 * z end)
    assert.same({ 3, 9 }, rgb.shape)
    assert.is_near(-math.sqrt(4 * pi / 3), rgb:get(1, 4), 1e-13)
    assert.is_near(3 * math.sqrt(4 * pi / 3), rgb:get(3, 3), 1e-13)
  end)

  it("agrees with the reference projections within the error that it reports", function()
    local seen = 0
    for _, set in ipairs(reference()) do
      local c, report = ylm.sh.project(5, function_of(set), { samples = 20000 })
      local _, difference = core.array_distance(c, ylm.array(set.c))
      assert(difference < 0.02 and difference < 3 * report.error + 1e-12,
        ("%s: off by %g, reported %g"):format(set.kind, difference, report.error))
      seen = seen + 1
    end
    assert(seen >= 10)
  end)

  it("by montecarlo is reproducible, within its standard error, and better by jitter than 1/sqrt n", function()
    local function f(x, y, z) return math.max(0, z) + 0.3 * x * y end
    local exact = ylm.sh.project(3, f, { samples = 200000 })
    local a, report = ylm.sh.project(3, f, { method = "montecarlo", samples = 20000, seed = 5 })
    local b = ylm.sh.project(3, f, { method = "montecarlo", samples = 20000, seed = 5 })
    local other = ylm.sh.project(3, f, { method = "montecarlo", samples = 20000, seed = 6 })
    assert.equal(0, (core.array_distance(a, b)))
    assert(core.array_distance(a, other) > 0)
    local _, difference = core.array_distance(a, exact)
    assert(difference < 4 * report.error, ("%g against %g"):format(difference, report.error))
    assert.equal(16, #report.standard_error)
    -- the integral of f Y_00 by random samples would be off by its deviation over sqrt n
    assert(report.standard_error[1] < 0.2 * 0.4 * math.sqrt(4 * pi) / math.sqrt(20000))
  end)

  it("sees a horizon on a coordinate plane as well by many samples as by few: no node lies on it", function()
    for axis = 1, 3 do
      local exact = { [0] = math.sqrt(pi), math.sqrt(3 * pi) / 2 }     -- of the half above: degrees 0 and 1
      local index = ({ 4, 2, 3 })[axis]                                -- of x, y, z
      local sign = axis == 3 and 1 or -1
      local function above(...) return (select(axis, ...)) >= 0 and 1 or 0 end
      for _, samples in ipairs { 1, 98, 2048, 5000, 12800, 25000 } do
        local c, report = ylm.sh.project(1, above, { samples = samples })
        local text = ("axis %d, %d samples: %.2e"):format(axis, samples, report.error)
        assert.is_near(exact[0], c[1], 1e-13, text)
        assert(math.abs(c[index] - sign * exact[1]) < 4 / math.max(32, samples), text)
        assert(report.error < 8 / math.max(32, samples), text)
        assert.equal(0, math.sqrt(report.samples / 2) % 2)
        assert(report.samples >= math.min(samples, 32) and math.abs(report.samples - samples) < 35 + samples / 20)
      end
    end
  end)

  it("reproduces the example of Green 2003: 10,000 jittered samples, four bands", function()
    local green
    for _, set in ipairs(reference()) do if set.kind == "green" then green = set end end
    local c, report = ylm.sh.project(3, function_of(green), { method = "montecarlo", samples = 10000 })
    assert(math.abs(report.samples - 10000) < 300)
    local printed = { 0.39925, -0.21075, 0.28687, 0.28277, -0.31530, -0.00040, 0.13159, 0.00098, [10] = nil }
    for i = 1, 8 do assert.is_near(printed[i], c[i], 0.02) end
    for i = 1, 16 do assert.is_near(green.c[i], c[i], 0.01) end
  end)

  it("takes samples with weights, and without", function()
    local d, w = core.sh_rule(8, 16, -1, 1)
    local values = {}
    for i, v in ipairs(d:totable()) do values[i] = v[1] * v[3] end
    local c = ylm.sh.project(2, { directions = d, values = values, weights = w })
    assert.is_near(-math.sqrt(4 * pi / 15), c[8], 1e-14)
    local plain = ylm.sh.project(0, { directions = { { 0, 0, 1 }, { 0, 0, -3 } }, values = { { 1, 2, 3 }, { 3, 4, 5 }
      } })
    for ch = 1, 3 do assert.is_near((ch + 1) * math.sqrt(4 * pi), plain:get(ch, 1), 1e-14) end
  end)

  for _, mapping in ipairs { "latlong", "angular", "cube" } do
    it("projects images: " .. mapping, function()
      local size = ({ latlong = { 128, 64 }, angular = { 128, 128 }, cube = { 32, 192 } })[mapping]
      for _, up in ipairs { "z", "y" } do
        local image = ylm.image { size = size, layers = { { "radiance", 3 } } }
        local directions = image:directions { mapping = mapping, up = up }
        local rows, list = {}, directions:totable()
        for y = 1, size[2] do
          rows[y] = {}
          for x = 1, size[1] do
            local d = list[(y - 1) * size[1] + x]
            rows[y][x] = { 1 + d[1], d[2] * d[3], d[3] }
          end
        end
        core.array_fill(image:layer "radiance", rows)
        local c, report = ylm.sh.project(2, image, { mapping = mapping, up = up })
        assert.same({ 3, 9 }, c.shape)
        assert.equal("pixels", report.method)
        local wanted = ylm.sh.project(2, function(x, y, z) return 1 + x, y * z, z end)
        assert(relative(c, wanted) < 2e-3, mapping .. " " .. relative(c, wanted))
        -- the estimate is of the worst channel, and neither blind nor absurd
        local worst = 0
        for ch = 1, 3 do
          local _, difference = core.array_distance(c[ch], wanted[ch])
          worst = math.max(worst, difference)
        end
        assert(report.error > 0.5 * worst and report.error < 10 * worst + 1e-3, ("%s %g %g"):format(mapping, report.error, worst))
        -- through files: half a byte's exponent in .hdr, float in .exr
        for _, ending in ipairs { ".exr", ".hdr" } do
          local name = os.tmpname()
          os.remove(name)
          -- .hdr holds no negative numbers: two more everywhere
          for row = 1, size[2] do
            for column = 1, size[1] do
              local d = list[(row - 1) * size[1] + column]
              rows[row][column] = { 3 + d[1], 2 + d[2] * d[3], 2 + d[3] }
            end
          end
          core.array_fill(image:layer "radiance", rows)
          assert(image:save(name .. ending))
          local back = assert(ylm.load(name .. ending))
          os.remove(name .. ending)
          local direct = ylm.sh.project(2, image, { mapping = mapping, up = up })
          local got = ylm.sh.project(2, back, { mapping = mapping, up = up })
          assert(relative(got, direct) < (ending == ".hdr" and 5e-3 or 1e-6), ending .. relative(got, direct))
        end
      end
    end)
  end

  it("estimates the error of random samples: within four standard errors, each coefficient", function()
    local directions, values = {}, {}
    local d = core.sh_samples(100, 11, 1)
    for i, v in ipairs(d:totable()) do
      directions[i], values[i] = v, math.max(0, v[3]) + 0.3 * v[1] * v[2]
    end
    local c, report = ylm.sh.project(3, { directions = directions, values = values })
    local exact = ylm.sh.project(3, function(x, y, z) return math.max(0, z) + 0.3 * x * y end, { samples = 200000 })
    assert.equal("samples", report.method)
    for i = 1, 16 do assert(math.abs(c[i] - exact[i]) < 4 * report.standard_error[i] + 1e-4) end
    -- as 1/sqrt(n): the deviation of f Y_00 is about 0.35
    assert(report.error > 0.01 and report.error < 0.2)
  end)

  it("writes where it is told, reports, and stops when told to", function()
    local calls, out = 0, ylm.zeros({ 9 }, "float")
    local function f(_, _, z) return z end
    local c = ylm.sh.project(2, f, { out = out, dtype = "float", samples = 5000, progress = function(done, total, stage)
      calls = calls + 1
      assert(done <= total and stage == "evaluate")
    end })
    assert.equal(out, c)
    assert.is_near(math.sqrt(4 * pi / 3), out[3], 1e-6)
    assert(calls > 3)
    for _, method in ipairs { "quadrature", "montecarlo" } do
      local none, message, code = ylm.sh.project(2, f, { method = method, progress = function() return false end })
      assert.same({ nil, "cancelled", "ECANCELLED" }, { none, message, code })
    end
    local image = ylm.image { size = { 256, 128 }, layers = { { "radiance", 1 } } }
    assert.same({ nil, "cancelled", "ECANCELLED" }, { ylm.sh.project(2, image, { progress = function() return false end }) })
  end)
end)

describe("ylm.sh.zonal, .cap, .convolve", function()
  it("turn symmetric functions: a cap about any direction is the cap about z, rotated", function()
    local c, z = ylm.sh.cap(8, { 0, 0, 1 }, 0.7)
    for l = 0, 8 do assert.is_near(z[l + 1], c[l * (l + 1) + 1], 1e-15) end
    local turned = ylm.sh.rotate(c, { axis = { 1, 0, 0 }, angle = 0.9 })
    local direction = { 0, -math.sin(0.9), math.cos(0.9) }
    assert(relative(ylm.sh.cap(8, direction, 0.7), turned) < 1e-14)
    assert(relative(ylm.sh.zonal(z, direction), turned) < 1e-14)
  end)

  it("have the closed form that Green's synth_light prints to four bands", function()
    for _, t in ipairs { 1e-4, 0.1, 0.8, 1.5, 2.5, pi } do
      local _, z = ylm.sh.cap(3, { 0, 0, 1 }, t)
      local c, s2 = math.cos(t), math.sin(t) ^ 2
      assert.is_near(1.772453851 * (1 - c), z[1], 1e-8)
      assert.is_near(1.534990062 * s2, z[2], 1e-8)
      assert.is_near(1.98166365 * (c - c ^ 3), z[3], 1e-8)
      assert.is_near(2.930920062 * (1 - c ^ 4) - 3.517104075 * s2, z[4], 1e-8)
    end
    local _, small = ylm.sh.cap(3, { 0, 0, 1 }, 1e-6) -- no cancellation
    for l = 0, 3 do
      assert.is_near(1, small[l + 1] / (pi * 1e-12 * math.sqrt((2 * l + 1) / (4 * pi))), 1e-10)
    end
  end)

  it("convolve as the rotated kernel integrates: with the cosine, irradiance", function()
    local z = {}
    for l = 0, 4 do z[l + 1] = core.sh_cosine_factor(l) * math.sqrt((2 * l + 1) / (4 * pi)) end
    local c = {}
    for i = 1, 25 do c[i] = math.sin(i) end
    assert(relative(ylm.sh.convolve(c, z), ylm.sh.convert(c, "ylm irradiance")) < 1e-15)
  end)
end)

describe("ylm.sh.irradiance", function()
  it("has the factors and values of the reference, to degrees 2, 4 and 8 and by the quadratic form", function()
    local seen = 0
    for line in io.lines "spec/data/irradiance.txt" do
      local n = {}
      for w in line:gmatch "%S+" do n[#n + 1] = tonumber(w) end
      if line:match "^A %d" then assert.is_near(n[2], core.sh_cosine_factor(n[1]), 1e-15)
      elseif line:match "^E" then
        seen = seen + 1
        local lamp = ylm.sphere_light { at = { n[5], n[6], n[7] }, radius = n[8], radiance = 1 }
        local L = ylm.light_field(8, lamp, { n[2], n[3], n[4] }, { channels = "luminance", dtype = "double" })[1]
        local normal = { n[9], n[10], n[11] }
        for i, lmax in ipairs { 2, 4, 8 } do
          local E = ylm.sh.irradiance(ylm.sh.resize(L, lmax), normal)
          assert.is_near(n[12 + i], E, 1e-12 * math.abs(n[12 + i]) + 1e-15)
        end
        assert.is_near(n[13], ylm.sh.irradiance(L, normal, { method = "quadratic" }), 1e-12)
      end
    end
    assert(seen > 20)
  end)

  it("of zonal light is the 2x2 form of the virtual lights' appendix B", function()
    local d = { 0.36, 0.48, 0.8 }
    local c, z = ylm.sh.cap(2, d, 0.9)
    local normals = { { 0, 0, 1 }, { 0.6, 0, -0.8 }, { 0, 1, 0 } }
    local E = ylm.sh.irradiance(c, normals)
    local cosines = {}
    for i, n in ipairs(normals) do cosines[i] = n[1] * d[1] + n[2] * d[2] + n[3] * d[3] end
    local by_cosine = ylm.sh.zonal_irradiance(z, cosines)
    for i = 1, 3 do assert.is_near(E[i], by_cosine[i], 1e-14) end
    -- the printed constants
    local L = z:totable()
    assert.is_near(by_cosine[1],
      0.743125 * L[3] * 0.64 + 2 * 0.511664 * L[2] * 0.8 + 0.886227 * L[1] - 0.247708 * L[3], 1e-5)
  end)
end)

describe("ylm.sh.sky", function()
  it("is the reference's overcast sky, for any zenith", function()
    local seen = 0
    for _, set in ipairs(reference()) do
      if set.kind == "overcast" then
        local c, f, report = ylm.sh.sky(5, { zenith = set.u })
        assert(relative(c, ylm.array(set.c)) < 1e-14)
        assert.equal("closed form", report.method)
        assert(relative(ylm.sh.project(5, f, { samples = 20000 }), c) < 1e-2)
        seen = seen + 1
      end
    end
    assert(seen >= 2)
  end)

  it("is brightest about the sun, and turns with it", function()
    for _, kind in ipairs { "clear", "partly cloudy" } do
      local c, f = ylm.sh.sky(4, { kind = kind, sun = { 1, 0, 1 }, luminance = 5 })
      assert.is_near(5, f(0, 0, 1), 1e-12)
      assert(f(math.sqrt(0.5), 0, math.sqrt(0.5)) > f(-math.sqrt(0.5), 0, math.sqrt(0.5)))
      assert.equal(0, f(0, 0, -1))
      -- the error that it reports covers what a much finer rule says
      local coarse, _, report = ylm.sh.sky(8, { kind = kind, sun = { 1, 0, 1 }, luminance = 5, nodes = 24 })
      local _, off = core.array_distance(coarse, (ylm.sh.sky(8, { kind = kind, sun = { 1, 0, 1 }, luminance = 5,
        nodes = 90 })))
      assert(off < 2 * report.error and report.error < 0.05, ("%s %g %g"):format(kind, off, report.error))
      local turned = ylm.sh.sky(4, { kind = kind, sun = { 0, 1, 1 }, luminance = 5 })
      assert(relative(ylm.sh.rotate(c, { axis = { 0, 0, 1 }, angle = pi / 2 }), turned) < 1e-3)
      local y_up = ylm.sh.sky(4, { kind = kind, zenith = { 0, 3, 0 }, sun = { 1, 1, 0 }, luminance = 5 })
      assert(relative(ylm.sh.convert(ylm.sh.convert(c, "ylm x,z,-y"), "ylm"), c) < 1e-14)
      assert(relative(ylm.sh.rotate(c, { axis = { 1, 0, 0 }, angle = -pi / 2 }), y_up) < 1e-3)
    end
  end)

  it("has Green's clear sky: the formula at a direction", function()
    local _, f = ylm.sh.sky(2, { kind = "clear", sun = { 1, 0, 1 }, luminance = 1 })
    local theta, S = math.acos(0.8), pi / 4
    local gamma = math.acos(0.6 * math.sqrt(0.5) + 0.8 * math.sqrt(0.5))
    local wanted = (0.91 + 10 * math.exp(-3 * gamma) + 0.45 * math.cos(gamma) ^ 2) * (1 - math.exp(-0.32 / math.cos(theta)))
      / ((0.91 + 10 * math.exp(-3 * S) + 0.45 * math.cos(S) ^ 2) * (1 - math.exp(-0.32)))
    assert.is_near(wanted, f(0.6, 0, 0.8), 1e-12)
  end)
end)

describe("ylm.sh.window", function()
  it("keeps the mean and multiplies each degree by its formula", function()
    local c = {}
    for i = 1, 16 do c[i] = 1 end
    local s = math.sin(pi / 4) / (pi / 4)
    for name, f in pairs { hann = 0.5 * (1 + math.cos(pi / 4)), lanczos = s, sinc = s ^ 4,
      gaussian = math.exp(-pi ^ 2 / 32) } do
      local w = ylm.sh.window(c, name, 4)
      assert.equal(1, w[1])
      for k = 2, 4 do assert.is_near(f, w[k], 1e-15) end
    end
    assert.equal(0, ylm.sh.window(c, "hann", 2)[16])
  end)
end)

describe("ylm.sh.dering", function()
  it("reaches the minimum with the widest window and says what that cost", function()
    local c = ylm.sh.cap(6, { 0, 0, 1 }, 0.5)
    local before
    for _, minimum in ipairs { -0.03, -0.02, -0.012 } do
      local smooth, report = ylm.sh.dering(c, { minimum = minimum, window = "hann" })
      assert.is_true(report.reached)
      assert(report.minimum >= minimum and report.minimum < minimum + 1e-3)
      assert(relative(smooth, ylm.sh.window(c, "hann", report.width)) < 1e-15)
      if before then assert(report.energy_lost > before.energy_lost and report.contrast_lost > before.contrast_lost) end
      before = report
    end
    local same, report = ylm.sh.dering(c, { minimum = -1 })
    assert.is_nil(report.width)
    assert.equal(0, report.energy_lost)
    assert.equal(0, (core.array_distance(same, c)))
  end)
end)

describe("ylm.sh.summary", function()
  it("names convention, lmax, coefficients and the energy of each degree", function()
    local text, energy = ylm.sh.summary(ylm.sh.convert({ 3, 0, 4, 0 }, "ylm irradiance"))
    assert.matches("^ylm irradiance, lmax 1, %[4%] double\n", text)
    assert.equal(2, #energy)
    assert.matches("l 1", text)
  end)
end)
