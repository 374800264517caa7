-- Prepared views that are shaded again: other light, other materials, another camera; methods to compare with.
local core = require "ylm.c.core"
local ylm = require "ylm"

local gold = ylm.ggx { alpha = 0.5, f0 = { 1, 0.78, 0.34 } }
local blue = ylm.phong { exponent = 4, specular = 0.5, base = { 0.1, 0.2, 0.4 } }

local function scene(ball, floor, small, camera)
  return ylm.scene "relit" {
    camera = camera or ylm.camera { from = { 0, 0.5, 4 }, at = { 0, 0, 0 }, fov = 35 },
    geometry = {
      ylm.sphere { material = ball or gold },
      ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = floor or ylm.matte { albedo = 0.5 } },
      ylm.sphere { at = { 1.2, 0, 0.7 }, scale = 0.4, material = small or blue },
    },
    lights = { ylm.sphere_light { at = { 3, 4, 3 }, radius = 1, radiance = { 30, 20, 10 } } },
  }
end

local lamp = ylm.sphere_lights { at = { { -3, 4, 1 } }, radius = 1, radiance = 20 }.lights
local other = ylm.sphere_lights { at = { { 1, 4, 3 } }, radius = 0.5, radiance = 40 }.lights

local function with(more)
  local o = { size = { 24, 18 }, samples = 4, share = 0, lmax = 5, visibility = "transfer", transfer_samples = 32, gloss = "sh",
    occlusion_distance = 10 }
  for k, x in pairs(more or {}) do o[k] = x end
  return o
end

--- Options of views without occluders.
local function open(more)
  local o = { size = { 24, 18 }, samples = 4, share = 0, lmax = 5, visibility = "none", gloss = "sh" }
  for k, x in pairs(more or {}) do o[k] = x end
  return o
end

--- The largest difference of two pictures' radiance, and the root mean square of it relative to b.
local function apart(a, b)
  local c = a:compare(b)
  return c.max, c.rmse / math.sqrt(b:compare(ylm.image { size = b.size }).mse)
end

describe("scene:prepare { relight = 'light' }", function()
  it("keeps products: other light costs a dot product, and pictures have the bits of others'", function()
    local s = scene()
    local fresh, kept = s:prepare(with()), s:prepare(with { relight = "light" })
    for i, light in ipairs { lamp, other, lamp } do
      local image, report = kept:render { grid = light }
      assert.equal(0, (apart(image, (fresh:render { grid = light }))))
      local t = report.stages
      assert.is_true(t.dot > 0 and t.light > 0)
      if i == 1 then assert.is_true(t.rows > 0 and t.rotation > 0 and t.product > 0)
      else assert.same({ 0, 0, 0 }, { t.rows, t.rotation, t.product }) end
    end
    assert.equal(0, (apart((kept:render { by = "sum" }), (fresh:render { by = "sum" }))))
  end)

  it("has pictures under light that all points share, which others make without products, to rounding", function()
    local s, sky = scene(), { ylm.sun_light { direction = { 1, 2, 2 }, angle = 20, irradiance = { 3, 2, 1 } },
      ylm.environment_light { radiance = { 0.5, 0.6, 0.7 } } }
    for _, lmax in ipairs { 1, 9, 14 } do
      for _, visibility in ipairs { "transfer", "none" } do
        local more = { lmax = lmax, visibility = visibility, size = { 12, 9 } }
        local fresh = s:prepare(with(more))
        more.relight = "light"
        local _, error = apart((fresh:render { grid = sky }), (s:prepare(with(more)):render { grid = sky }))
        assert.is_true(error < 2e-6, ("lmax %d, %s: %.2g"):format(lmax, visibility, error))
        if lmax > 3 and visibility == "transfer" then assert.is_true(error > 0) end -- two paths, not one
      end
    end
  end)

  it("is gloss = 'sh' by transfer vectors, unless told otherwise", function()
    local v = scene():prepare { size = { 4, 3 }, samples = 1, lmax = 2, relight = "light" }
    assert.same({ "sh", "transfer", "light" }, { v.options.gloss, v.options.visibility, v.options.relight })
  end)
end)

describe("view:render { materials = .. }", function()
  it("shades other materials of the same and of another kind, as a view of a scene that has them", function()
    local v = scene():prepare(with { relight = "material" })
    local ball, floor = ylm.phong { exponent = 6, specular = 0.7 }, ylm.matte { albedo = { 0.2, 0.3, 0.4 } }
    local small = ylm.ggx { alpha = 0.6, f0 = 0.5 }
    local image, report = v:render { grid = lamp, materials = { ball, floor, small } }
    local truth = scene(ball, floor, small):prepare(with()):render { grid = lamp }
    assert.equal(0, (apart(image, truth)))
    assert.is_true(report.stages.product > 0)
    image, report = v:render { grid = lamp, materials = { ball, floor, small } }
    assert.equal(0, (apart(image, truth)))
    assert.equal(0, report.stages.product)
    assert.equal(0, (apart((v:render { grid = lamp }), (scene():prepare(with()):render { grid = lamp }))))
  end)

  it("makes a glossy surface matte, by its visibility alone", function()
    local matte = ylm.matte { albedo = 0.6 }
    local image = scene():prepare(with { relight = "material", transfer_samples = 128 })
      :render { grid = lamp, materials = { [3] = matte } }
    local truth = scene(nil, nil, matte):prepare(with { transfer_samples = 128 }):render { grid = lamp }
    local _, error = apart(image, truth)
    assert.is_true(error < 0.02, tostring(error))
  end)

  it("changes freely where the light knows its shadows, or nothing occludes", function()
    local v = scene():prepare(open { relight = "material" })
    local image = v:render { grid = lamp, materials = { [2] = blue } }
    local truth = scene(nil, blue):prepare(open()):render { grid = lamp }
    assert.equal(0, (apart(image, truth)))
  end)

  it("refuses what a prepared view cannot become, by name", function()
    local v = scene():prepare(with { relight = "material" })
    assert.has_error(function() v:render { grid = lamp, materials = { [2] = gold } } end, "render: mesh 2 is matte in the "
      .. "prepared view, which keeps its visibility times the cosine: it cannot become ggx, prepare the view with a material "
      .. "that glosses")
    assert.has_error(function() v:render { grid = lamp, materials = { ylm.ggx { alpha = { 0.3, 0.6 } } } } end,
      "render: mesh 1 cannot become ggx with two roughnesses: the prepared view has isotropic materials alone, and no tangents, "
      .. "prepare it with one that has them")
    assert.has_error(function() v:render { grid = lamp, materials = { [4] = gold } } end,
      "bad argument #1 to 'render' (materials: places in scene.geometry expected, 1 to 3, got 4)")
    assert.has_error(function() v:render { grid = lamp, materials = { 0.5 } } end,
      "bad argument #1 to 'render' (materials: [1] must be a material, got 0.5)")
    assert.has_error(function() v:render { grid = lamp, materials = { gold }, bounces = 1 } end,
      "render: light that bounces is "
      .. "that of the scene's materials and camera: leave bounces and bounced out")
    assert.has_error(function() v:render { grid = lamp, camera = v.scene.camera } end,
      "render: another camera sees other shading points: prepare the view with relight = 'all'")
    local still = scene():prepare(with { relight = "light" })
    assert.has_error(function() still:render { grid = lamp, materials = { gold } } end,
      "render: materials change in views that are prepared with relight = 'material' or 'all', here it is \"light\"")
    assert.has_error(function() scene():prepare(with { relight = "light", gloss = "matte" }) end,
      "prepare: relight = \"light\" "
      .. "is of glossy surfaces by spherical harmonics: gloss = 'sh', or leave gloss out")
    assert.has_error(function() scene():prepare(with { relight = "all", shading = "pixel" }) end,
      "prepare: relight = 'all' shades vertices, which every camera sees: shading = 'vertices', or leave shading out")
  end)
end)

describe("scene:prepare { relight = 'all' }", function()
  local moved = ylm.camera { from = { 1, 1.5, 4 }, at = { 0, 0, 0 }, fov = 35 }

  it("moves the camera over the same vertices", function()
    local v = scene():prepare(with { relight = "all" })
    assert.equal(#v:points().position, v.stats.points)
    local there = scene(nil, nil, nil, moved):prepare(with { relight = "all" })
    local image, report = v:render { grid = lamp, camera = moved }
    assert.equal(0, (apart(image, (there:render { grid = lamp }))))
    assert.is_true(report.stages.rows > 0)
    local before = v:render { grid = lamp }
    assert.is_true(apart(image, before) > 0.01)
    local few = scene(nil, nil, nil, moved):prepare(open { shading = "vertices" })
    assert.is_true(few.stats.points < v.stats.points)
    local all = scene():prepare(open { relight = "all" })
    local _, error = apart((all:render { grid = lamp, camera = moved }), (few:render { grid = lamp }))
    assert.is_true(error < 1e-6, tostring(error))
  end)

  it("gives the radiance of its vertices alone, with all that changes", function()
    local v = scene():prepare(with { relight = "all" })
    local all = { grid = other, camera = moved, materials = { blue } }
    local colours, report = v:radiance(all)
    assert.same({ v.stats.points, 3 }, colours.shape)
    assert.is_true(report.stages.product > 0 and report.points == v.stats.points)
    local there = scene(blue, nil, nil, moved):prepare(with { relight = "all" })
    assert.equal(0, (core.array_distance(colours, (there:radiance { grid = other }))))
    all.threads = 7
    assert.equal(0, (core.array_distance(colours, (v:radiance(all)))))
  end)

  it("refuses a camera that sees a side whose vertices are not there", function()
    local v = scene():prepare(with { relight = "all" })
    local below = ylm.camera { from = { 0, -3, 0.1 } }
    assert.has_error(function() v:render { grid = lamp, camera = below } end,
      "render: the camera sees mesh 2 from within, where "
      .. "the prepared view has no vertices: prepare it with a camera that sees this side too")
  end)

  it("is told when memory is given back", function()
    local v = scene():prepare(with { relight = "all" })
    v:radiance { grid = lamp, camera = moved }
    v:close()
    assert.has_error(function() v:radiance { grid = lamp } end, "radiance: the prepared view has been closed")
  end)
end)

describe("methods to compare with", function()
  it("multiply slices and visibility to the same picture", function()
    local v = scene():prepare(with())
    local image = v:render { grid = lamp }
    for _, product in ipairs { "list", "fourier", "gaunt", "quadrature" } do
      local _, error = apart((v:render { grid = lamp, product = product }), image)
      assert.is_true(error < 1e-5, product .. " " .. error)
    end
  end)

  it("take the nearest of 90 rows, or zonal lobes, whose error is larger", function()
    local v = scene():prepare(open())
    local image = v:render { by = "sum" }
    local _, nearest = apart((v:render { by = "sum", method = "nearest" }), image)
    local _, zonal = apart((v:render { by = "sum", method = "zonal" }), image)
    assert.is_true(nearest > 1e-4 and nearest < 0.01, tostring(nearest))
    assert.is_true(zonal > 0.05 and zonal < 0.4, tostring(zonal))
  end)

  it("have zonal lobes agree with slices where the lamp is straight above what is seen straight on", function()
    local s = ylm.scene "above" { camera = ylm.camera { from = { 0, 0, 2 }, up = { 0, 1, 0 }, fov = 0.1 },
      geometry = { ylm.quad { corner = { -1, -1, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, material = gold } },
      lights = { ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.8, radiance = 1 } } }
    local v = s:prepare { size = { 2, 2 }, samples = 1, lmax = 8, visibility = "none", gloss = "sh" }
    local _, error = apart((v:render { by = "sum", method = "zonal" }), (v:render { by = "sum" }))
    assert.is_true(error < 0.03, tostring(error))
  end)

  it("are refused where they do not fit", function()
    local v = scene():prepare(with())
    assert.has_error(function() v:render { grid = lamp, method = "zonal" } end,
      "render: zonal lobes are summed lamp by lamp, without a grid: by = 'sum', method = 'zonal'")
    assert.has_error(function() v:render { by = "rays", product = "list" } end, "render: product is for by = \"grid\" or by = "
      .. "\"sum\", and this picture is by = \"rays\": name one that fits, or leave product out")
    local matte = scene():prepare(with { gloss = "matte" })
    assert.has_error(function() matte:render { grid = lamp, product = "list" } end,
      "render: product is of glossy surfaces by spherical harmonics: prepare the view with gloss = 'sh'")
    local flat = ylm.scene "flat" { camera = ylm.camera { from = { 0, 0, 2 }, up = { 0, 1, 0 } },
      geometry = { ylm.sphere { material = gold } }, lights = { ylm.environment_light { radiance = 1 } } }
    assert.has_error(function()
      flat:prepare { size = { 2, 2 }, samples = 1, lmax = 1, visibility = "none", gloss = "sh" }:render { by = "sum",
        method = "zonal" }
    end, "render: zonal lobes are summed over sphere lights, and the scene has others: method = 'table' takes all")
  end)
end)
