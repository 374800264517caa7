-- Pictures by far parts of virtual lights that are baked and near parts that are summed at shading points.

local refused = require "spec.support.raises"
local with = require "spec.support.with"
local ylm = require "ylm"

local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local white = ylm.matte { albedo = { 0.8, 0.5, 0.3 } }
local scene = ylm.scene "a room" {
  geometry = {
    ylm.box { scale = 2, material = white },
    ylm.box { at = { -0.3, -0.6, 0 }, scale = { 0.5, 0.8, 0.5 }, rotate = { axis = { 0, 1, 0 }, angle = 18 },
      material = ylm.matte { albedo = 0.5 } },
  },
  lights = ylm.sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 100 },
  camera = ylm.camera { from = { 0.9, 0, 0 }, at = { -1, -0.2, 0 }, fov = 60 },
}
local view = scene:prepare { size = { 40, 22 }, samples = 1 }
local lights = scene:virtual_lights { count = 300 }
local far, near = lights:split { scene = scene }
local probes = ylm.adaptive_grid { depth = 5, threshold = 1e-9 }

--- Root mean square of the difference of two pictures, over the mean of the second; all must be finite.
local function apart(a, b)
  local sum, n = 0, 0
  for _, line in ipairs(b:layer():totable()) do
    for _, p in ipairs(line) do sum, n = sum + (p[1] + p[2] + p[3]) / 3, n + 1 end
  end
  return a:compare(b).rmse / (sum / n)
end

local function rendered(v, options)
  local image, report = v:render(with({ layers = false }, options))
  return assert(image, report), report
end

describe("far and near", function()
  it("make the picture of every light at every point, where the view has no transfer vectors", function()
    local grid = scene:bake { lights = far, probes = probes, occupied = view }
    local wanted = assert(view:render { by = "none", bounced = lights, layers = false })
    local image, report = rendered(view, { grid = grid, near_lights = near })
    assert.is_true(apart(image, wanted) < 0.01, apart(image, wanted))
    assert.same({ "none", near.count, near.core }, { report.visibility, report.near.lights, report.near.core })
    assert.is_true(report.near.pairs > 0 and report.near.pairs < lights.count * report.points and report.seconds.near > 0)
    assert.matches("virtual lights shine through walls", report.warnings[1])
    assert.equal(1, #report.warnings)
    assert.is_true(apart(rendered(view, { grid = grid, near_lights = near, threads = 3 }), image) == 0)
    -- beside direct light
    local direct = rendered(view, {})
    local both = rendered(view, { bounced = grid, near_lights = near })
    assert.is_true(apart(both:difference(direct), image) < 1e-5)
    local again = assert(scene:render { grid = grid, near_lights = near, size = { 40, 22 }, samples = 1, layers = false })
    assert.is_true(apart(again, image) == 0)
  end)

  it("are multiplied by transfer vectors where a view has them", function()
    local shadowed = scene:prepare { size = { 40, 22 }, samples = 1, visibility = "transfer", transfer_samples = 64 }
    local grid = scene:bake { lights = far, probes = probes, occupied = shadowed }
    local wanted = rendered(shadowed, { grid = lights.lights })
    assert.is_true(apart(rendered(shadowed, { grid = grid, near_lights = near }), wanted) < 0.01)
    assert.is_true(apart(rendered(shadowed, { grid = grid }), wanted) > 0.03) -- without them
  end)

  it("bake to a tolerance of irradiance at what a view sees", function()
    local grid = scene:bake { lights = far, occupied = view,
      probes = ylm.adaptive_grid { depth = 6, tolerance = 0.05, measure = "irradiance" } }
    assert.is_true(grid.stats.met and grid.stats.error <= 0.05)
    assert.equal("irradiance", grid.measure)
  end)

  it("have the power of the whole in the far part, which alone shines from afar", function()
    assert.same({ lights.power, { 0, 0, 0 } }, { far.power, near.power })
  end)

  it("are split by the area of a scene and by the points of a picture", function()
    local widest = math.sqrt((24 + 2 * 0.25 + 4 * 0.4) / 300)
    local function core(spacing, options)
      local radius = 1.5 / math.sqrt(math.pi) * spacing
      local l = ylm.virtual_lights { at = lights:arrays(), radius = radius, intensity = 1 }
      return (l:split(options)).core / spacing
    end
    assert.is_near(2, core(widest / 2, { scene = scene }), 1e-9)
    assert.is_near(2, core(2 * widest), 1e-9)
    assert.is_near(1, core(2 * widest, { scene = scene }), 1e-9) -- not all over its area
    assert.is_near((2 * 0.3 * 300 ^ 2 / (1e2 / 4)) ^ 0.25, core(widest / 2, { scene = scene, points = 1e2 }), 1e-9)
    assert.is_near(12, core(0.1, { points = 1 }), 1e-9)
  end)

  it("refuse what does not fit together", function()
    local grid = scene:bake { lights = far, probes = ylm.uniform_grid { cells = 2, lmax = 1 }, occupied = view }
    refused("core must be a number > 0, or 'auto', got %-1", function() lights:split { core = -1 } end)
    refused("scene: a scene expected, got 3", function() lights:split { scene = 3 } end)
    refused("points is of core = 'auto', core is 1: leave one out", function() lights:split { core = 1, points = 5 } end)
    refused("lights of profile 'gauss' are split, and these are 'near'", function() near:split() end)
    refused("near lights lack", function() view:render { near_lights = near } end)
    refused("near_lights is the near part of lights:split, these lights are of profile 'far': that is what the grid is baked of",
      function() view:render { grid = grid, near_lights = far } end)
    refused("near_lights must be", function() view:render { grid = grid, near_lights = 3 } end)
    refused("holds lights without their shadows", function() view:render { grid = grid } end)
    refused("near lights are gathered", function() scene:bake { lights = near, probes = probes } end)
    refused("lights are baked as quantity = 'lights', this is \"all\"", function()
      scene:bake { lights = far, quantity = "all", probes = probes }
    end)
    local bounced = scene:bake { quantity = "indirect", bounces = 1, probes = ylm.uniform_grid { cells = 2, lmax = 1 },
      occupied = view }
    refused("the grid holds indirect light, no far parts of virtual lights", function()
      view:render { grid = bounced, near_lights = near }
    end)
    refused("irradiance needs normals", function()
      scene:bake { lights = far, occupied = ylm.zeros { 1, 3 },
        probes = ylm.adaptive_grid { tolerance = 0.1, measure = "irradiance" } }
    end)
  end)
end)

describe("bounced = 'virtual'", function()
  local function bounced(options, more, profile)
    return rendered(view, with({ light_samples = 1, bounced = (scene:virtual_lights { count = 300, profile = profile }),
      virtual = options }, more or {}))
  end

  it("sums by far and near parts what every light at every point brings, judges itself, and says each part's time", function()
    local all, whole = bounced { sums = "all" }
    local parts, report = bounced { sums = "split" }
    assert.is_true(apart(parts, all) < 0.02)
    assert.same({ "all", "split", "none" }, { whole.virtual.sums, report.virtual.sums, report.virtual.shadows })
    local v = report.virtual
    assert.is_true(v.error > 0 and v.error < v.tolerance and v.tolerance == 0.02)
    assert.is_true(v.grid.points > 8 and v.core > 0 and v.pairs < whole.virtual.pairs)
    for _, step in ipairs { "split", "bake", "judge", "far", "near" } do assert.is_true(v.seconds[step] >= 0, step) end
    assert.equal(1, #report.warnings)
    assert.matches("shine through walls", report.warnings[1])
    assert.is_true(apart(bounced({ sums = "split" }, { threads = 3 }), parts) == 0)
    local _, auto = bounced {} -- too few pairs to be worth a grid
    assert.equal("all", auto.virtual.sums)
  end)

  it("keeps a tolerance of its sum, or says that it does not", function()
    local _, coarse = bounced { sums = "split", tolerance = 0.1 }
    local _, fine = bounced { sums = "split", tolerance = 0.005 }
    assert.is_true(fine.virtual.error <= 0.005 and fine.virtual.error < coarse.virtual.error)
    assert.is_true(fine.virtual.grid.points > coarse.virtual.grid.points)
    local _, missed = bounced { sums = "split", tolerance = 1e-4, lmax = 14 } -- parts have degree 8
    assert.is_true(missed.virtual.error > 1e-4)
    assert.matches("far and near parts of virtual lights miss .* tolerance of 0.0001: give sums = 'all'", missed.warnings[1])
  end)

  it("is judged in direct light where a picture has a tolerance, and says so", function()
    local image, report = scene:render { size = { 40, 22 }, layers = false, tolerance = 0.2,
      bounced = scene:virtual_lights { count = 100 } }
    assert(image, report)
    assert.is_true(report.met)
    assert.matches("tolerance is judged in direct light", report.warnings[#report.warnings])
  end)

  it("takes lights that are given, with options", function()
    local image, report = rendered(view, { light_samples = 1,
      bounced = lights, virtual = { sums = "split" } })
    assert.is_true(apart(image, (bounced { sums = "split" })) == 0)
    assert.equal("split", report.virtual.sums)
    refused("bounces are those of the virtual lights", function()
      view:render { bounces = 1, bounced = lights }
    end)
  end)

  it("refuses parts that cannot be", function()
    refused("sums = 'split': shadows = 'centre' asks each light: leave sums out", function()
      bounced { sums = "split", shadows = "centre" }
    end)
    refused("sums = 'split': lights of profile 'gauss' are split, and these are 'cap'", function()
      bounced({ sums = "split" }, nil, "cap")
    end)
    refused("tolerance must be", function() bounced { tolerance = 0 } end)
    refused("sums must be one of", function() bounced { sums = "some" } end)
  end)

  it("stops where progress says so, in each step", function()
    for _, stage in ipairs { "near lights", "lights", "far lights" } do
      local image, message, code = view:render { light_samples = 1, bounced = view.scene:virtual_lights { count = 300 },
        virtual = { sums = "split" },
        progress = function(_, _, at) return at ~= stage end }
      assert.same({ nil, "cancelled", "ECANCELLED" }, { image, message, code }, stage)
    end
  end)
end)

it("radiosity and links say that they see no virtual lights, instead of leaving them out", function()
  local other = ylm.scene "b" { geometry = scene.geometry, lights = { scene.lights[1], lights }, camera = scene.camera }
  local t = other:links { spacing = 0.5, rays = 8, lmax = 2 }
  refused("virtual lights have no body, so rays see nothing of them: direct = 'field' takes their coefficients", function()
    t:radiosity()
  end)
  assert(t:radiosity(other.lights, { direct = "field" }))
  refused("virtual lights have no body", function() view:render { lights = { lights } } end)
end)
