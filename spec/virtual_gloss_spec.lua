-- Pictures of virtual lights on glossy surfaces: slices of their materials, f itself, zonal lobes.

local by_kernels = require "spec.support.by_kernels"
local gathered = require "spec.support.gathered"
local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local materials = {
  grey = ylm.ggx { alpha = 0.5, f0 = 1 }, varnish = ylm.ggx { alpha = 0.3, f0 = 0.04, base = { 0.6, 0.3, 0.1 } },
  brushed = ylm.ggx { alpha = { 0.5, 0.35 }, f0 = { 1, 0.5, 0.2 } },
  polish = ylm.phong { exponent = 20, specular = 0.5, base = 0.3 },
}

--- A tilted floor seen from the side.
local function ground(material)
  return ylm.scene "a floor" { lights = ylm.sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 100 },
    camera = ylm.camera { from = { 0, 0.8, 1.6 }, at = { 0, 0, 0 }, fov = 50 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0.2, 0 }, v = { 0.1, 0.1, -2 }, material = material } }
end

local function some_lights(options)
  return ylm.virtual_lights(with({ at = { { 0.2, 1, 0.1 }, { -0.3, 0.4, -0.5 }, { 0.1, 0.1, 0.1 } },
    normal = { { 0.6, -0.8, 0 }, { 0, -1, 0 }, { 0, 0.8, 0.6 } }, radius = 0.3,
    intensity = { { 3, 2, 1 }, { 1, 2, 3 }, { 1, 1, 1 } } }, options or {}))
end

local function prepared(material, options)
  return ground(material):prepare(with({ size = { 9, 6 }, samples = 1, share = 0 }, options or {}))
end

--- The root mean square of a difference over that of b.
local function apart(a, b)
  local d, all = 0, 0
  for i = 1, a.shape[1] do
    for j = 1, a.shape[2] do
      for c = 1, 3 do
        d, all = d + (a:get(i, j, c) - b:get(i, j, c)) ^ 2, all + b:get(i, j, c) ^ 2
      end
    end
  end
  return math.sqrt(d / all)
end

describe("harmonics on glossy surfaces", function()
  for _, case in ipairs { { "grey", "gauss" }, { "varnish", "cap" }, { "brushed", "point" }, { "polish", "gauss" } } do
    it("are coefficients of the lights times slices turned to the world: " .. table.concat(case, ", "), function()
      local lights = some_lights { profile = case[2] }
      local by_slices = prepared(materials[case[1]], { visibility = "none", gloss = "sh", lmax = 5 })
      local wanted = by_slices:render { grid = lights, layers = false }:layer "radiance"
      local view = prepared(materials[case[1]])
      assert.is_true(apart(gathered(view, lights, { lmax = 5 }), wanted) < 2e-6)
      -- vertices, and a view by transfer vectors
      assert.is_true(apart(gathered(by_slices, lights, { lmax = 5 }), wanted) < 2e-6)
      assert.is_true(apart(gathered(prepared(materials[case[1]], { shading = "vertices" }), lights, { lmax = 5 }),
        wanted) > 1e-4)
    end)
  end

  it("are damped by windows, and at the horizon", function()
    local view, lights = prepared(materials.varnish), some_lights()
    local flat = gathered(view, lights, { lmax = 4, window = { "hann", 1 } })
    assert.is_true(apart(flat, gathered(view, lights, { lmax = 0 })) < 2e-3) -- tables of other degrees
    local plain = gathered(view, lights, { lmax = 6 })
    local low = some_lights { at = { { 0.2, -0.1, 0.1 }, { 0.2, -0.5, 0.1 }, { 0.5, -0.5, 0.1 } },
      normal = { { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 } } }
    for _, zonal in ipairs { false, true } do
      local function power(options)
        local sum, a = 0, gathered(view, low, with({ lmax = 6, zonal = zonal }, options))
        for i = 1, a.shape[1] do for j = 1, a.shape[2] do sum = sum + math.abs(a:get(i, j, 2)) end end
        return sum
      end
      assert.is_true(power { horizon = "paper" } < 0.5 * power {})
      assert.is_true(power { horizon = "gate" } < 0.9 * power {})
    end
    local high = gathered(view, some_lights { at = { { 0.2, 1, 0.1 }, { 0.2, 1.1, 0.1 }, { 0, 1, 0.4 } } }, { lmax = 6 })
    assert.is_true(apart(gathered(view, some_lights { at = { { 0.2, 1, 0.1 }, { 0.2, 1.1, 0.1 }, { 0, 1, 0.4 } } },
      { lmax = 6, horizon = "paper" }), high) < 0.05)
    assert.is_true(apart(plain, high) > 0.1)
  end)

  it("are those of plain code in double, emission of a degree too", function()
    local program = [[
      local ylm, ways = require "ylm", require "spec.support.ways"
      ylm.on_warning(false)
      local e = { {}, {} }
      for i = 1, 2 do for c = 1, 3 do e[i][c] = {} for k = 1, 25 do e[i][c][k] = math.sin(i + 2 * c + k) end end end
      for _, m in ipairs { ylm.ggx { alpha = 0.5, f0 = { 1, 0.5, 0.2 }, base = 0.1 },
        ylm.matte { albedo = 0.5 } } do
        local view = assert(ylm.scene "a floor" { camera = ylm.camera { from = { 0, 0.8, 1.6 }, at = { 0, 0, 0 }, fov = 50 },
          geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0.2, 0 }, v = { 0.1, 0.1, -2 }, material = m } }
          :prepare { size = { 3, 2 }, samples = 1, share = 0 })
        for _, profile in ipairs { "gauss", "cap" } do
          local lights = ylm.virtual_lights { at = { { 0.2, 1, 0.1 }, { -0.3, 0.4, -0.5 } }, radius = 0.3, emission = e,
            normal = { { 0.6, -0.8, 0 }, { 0, -1, 0 } }, profile = profile }
          for _, o in ipairs { { lmax = 5 }, { lmax = 5, zonal = true }, { method = "vpl", clamp = "none" },
            { method = "vsgl" }, { method = "vsl" }, { method = "vsl", strategy = "receiver" } } do
            o.lights, o.layers = lights, false
            local a = view:render(ways.virtual(o)):layer "radiance"
            for i = 1, 2 do for j = 1, 3 do for c = 1, 3 do print(("%.9g"):format(a:get(i, j, c))) end end end
          end
        end
      end]]
    local plain = by_kernels("reference", program)
    assert.equal(2 * 2 * 6 * 18, #plain)
    for _, isa in ipairs(ylm.info().kernels) do
      local fast = by_kernels(isa, program)
      for k = 1, #plain, 18 do
        local most = 0
        for i = k, k + 17 do most = math.max(most, math.abs(plain[i])) end
        for i = k, k + 17 do assert.near(plain[i], fast[i], 1e-5 * most, isa .. " " .. i) end
      end
    end
  end)

  it("are refused beyond tables, and shaded as matte where a view says so", function()
    local lights = some_lights()
    refused("tables of degree 0 to 60, lmax is 61", function() prepared(materials.grey):render { by = "none",
      bounced = lights, virtual = { lmax = 61 } } end)
    local grey = gathered(prepared(materials.grey), lights)
    local matte, report = gathered(prepared(materials.grey, { visibility = "none", gloss = "matte" }), lights)
    assert.is_true(apart(matte, grey) > 0.1)
    assert.matches("as a matte one of its mean albedo", report.warnings[2])
    local as = gathered(prepared(ylm.matte { albedo = 0.9 }), lights)
    local ratio = matte:get(3, 3, 2) / as:get(3, 3, 2)
    assert.is_true(math.abs(matte:get(5, 2, 1) / as:get(5, 2, 1) / ratio - 1) < 1e-5)
  end)
end)

describe("points and spheres on glossy surfaces", function()
  it("are f times the geometry term: harmonics of high degree come to it", function()
    local points = some_lights { profile = "point" }
    for _, name in ipairs { "grey", "polish" } do
      local view = prepared(materials[name])
      local wanted = gathered(view, points, { method = "vpl", clamp = "none" })
      assert.is_true(apart(gathered(view, points, { lmax = 14 }), wanted) < 0.02, name)
    end
    -- low degrees of a wide lobe whose tangent counts
    local view = prepared(materials.brushed)
    local wanted = gathered(view, points, { method = "vpl", clamp = "none" })
    local near = apart(gathered(view, points, { lmax = 5 }), wanted)
    assert.is_true(near < 0.12, near)
  end)

  it("are bounded, with f in the bound of all but the light", function()
    local scene = ground(materials.grey)
    scene.camera = ylm.camera { from = { 0, 3, 0 }, at = { 0, 0, 0 }, up = { 0, 0, -1 }, fov = 0.01 }
    local view = scene:prepare { size = { 1, 1 }, samples = 1 }
    local lights = ylm.virtual_lights { at = { { 0, 0.45, 0 } }, normal = { { 0, -1, 0 } }, radius = 0.5, intensity = 1 }
    local got = gathered(view, lights, { method = "vpl", clamp = "whole", limit = 0.3 }):get(1, 1, 2)
    assert.is_true(math.abs(got - 0.3) < 1e-5, got)
    local f = gathered(view, lights, { method = "vpl", clamp = "geometry", limit = 1 }):get(1, 1, 2)
    local plain = gathered(view, lights, { method = "vpl", clamp = "none" }):get(1, 1, 2)
    assert.is_true(f > 0.2 and f < 0.5 and plain > 5 * f, f .. " " .. plain)
  end)

  it("have one mean by all strategies, that of points where they are far", function()
    local view = prepared(materials.varnish, { size = { 3, 2 } })
    local by = {}
    for _, strategy in ipairs { "cone", "receiver", "mis" } do
      by[strategy] = gathered(view, some_lights(), { method = "vsl", samples = 600, strategy = strategy })
    end
    assert.is_true(apart(by.receiver, by.cone) < 0.09, apart(by.receiver, by.cone))
    assert.is_true(apart(by.mis, by.cone) < 0.03, apart(by.mis, by.cone))
    local small = some_lights { radius = 0.02 }
    assert.is_true(apart(gathered(view, small, { method = "vsl", samples = 100 }),
      gathered(view, small, { method = "vpl", clamp = "none" })) < 0.02)
  end)
end)

describe("zonal lobes", function()
  it("are coefficients on matte surfaces", function()
    local view, lights = prepared(ylm.matte { albedo = { 0.7, 0.5, 0.2 } }), some_lights()
    for _, lmax in ipairs { 4, 14 } do
      assert.is_true(apart(gathered(view, lights, { zonal = true, lmax = lmax }), gathered(view, lights,
        { lmax = lmax })) < 1e-6)
    end
  end)

  it("are near to coefficients where lobes are about circular, with 15 bands", function()
    local lights = some_lights()
    local view = prepared(materials.polish) -- circular, but for the horizon
    assert.is_true(apart(gathered(view, lights, { zonal = true }), gathered(view, lights, { lmax = 14 })) < 0.08)
    view = prepared(materials.varnish)
    assert.is_true(apart(gathered(view, lights, { zonal = true }), gathered(view, lights, { lmax = 14 })) < 0.12)
  end)
end)
