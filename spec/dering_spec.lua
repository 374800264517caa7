-- Light below zero in pictures by coefficients: the window, the report of it; sides of walls leave none.

local scratch = require "spec.support.scratch"
local ylm = require "ylm"

describe("a picture by a grid of all light of a room with sun, lmax 2", function()
  local scene, grid, with_sides
  setup(function()
    local white = ylm.matte { albedo = 0.7 }
    local function wall(corner, u, v) return ylm.quad { corner = corner, u = u, v = v, divide = 4, material = white } end
    scene = ylm.scene "Sunny room" {
      camera = ylm.camera { from = { -1.7, 1.5, 1.3 }, at = { 0.6, 0.9, -0.6 }, fov = 70 },
      geometry = {
        wall({ -2, 0, 1.5 }, { 4, 0, 0 }, { 0, 0, -3 }), wall({ -2, 2.6, -1.5 }, { 4, 0, 0 }, { 0, 0, 3 }),
        wall({ -2, 0, -1.5 }, { 4, 0, 0 }, { 0, 2.6, 0 }), wall({ 2, 0, 1.5 }, { -4, 0, 0 }, { 0, 2.6, 0 }),
        wall({ -2, 0, 1.5 }, { 0, 0, -3 }, { 0, 2.6, 0 }),
        wall({ 2, 0, -1.5 }, { 0, 0, 3 }, { 0, 0.9, 0 }), wall({ 2, 2.1, -1.5 }, { 0, 0, 3 }, { 0, 0.5, 0 }),
        wall({ 2, 0.9, -1.5 }, { 0, 0, 0.8 }, { 0, 1.2, 0 }), wall({ 2, 0.9, 0.7 }, { 0, 0, 0.8 }, { 0, 1.2, 0 }),
        ylm.box { at = { -0.6, 0.4, -0.5 }, scale = { 0.5, 0.8, 0.5 }, material = white },
      },
      lights = { ylm.sun_light { direction = { 1, 0.9, 0.25 }, irradiance = 20 } },
      probes = ylm.uniform_grid { cells = { 8, 6, 6 }, lmax = 2 }, links = ylm.links { spacing = 0.3, rays = 64 },
    }
    local sun = scene.lights[1] or scene.lights
    grid = assert(ylm.bake(scene.probes, function(p, lmax, channels) -- the sun alone, which rings, and no walls
      local L, dL, _, report = ylm.light_field(lmax, sun, p, { derivatives = 1, metric = "luminance",
        channels = channels == 3 and "rgb" or "luminance" })
      return L, dL, report.lambda
    end, { quantity = "all", geometry = scene.geometry }))
    with_sides = assert(scene:bake { quantity = "all" })
  end)

  it("has none of its light below zero where the grid knows the walls", function()
    local _, report = scene:render { grid = with_sides, size = { 48, 36 }, samples = 1, layers = false }
    assert(report.dering.before <= 0.001 and report.dering.after == 0, report.dering.before)
  end)

  --- The picture, its report, the part of its light below zero and what was said.
  local function render(options)
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    options.grid, options.size, options.samples, options.layers = grid, { 48, 36 }, 1, false
    local image, report = assert(scene:render(options))
    ylm.on_warning(before)
    local radiance = image:layer "radiance"
    local below = -radiance:clamp(-math.huge, 0):sum()
    return image, report, below / (radiance:clamp(0, math.huge):sum() + below), said
  end

  it("has at most 0.1 % of its light below zero, and says what it had before, once", function()
    local image, report, below, said = render {}
    local found = report.dering
    assert(found.before > 0.001 and found.after <= 0.001 and found.width > 0 and below < 0.0015, below)
    assert(#said == 1 and said[1]:find "%% of the picture's light was below zero, since harmonics of degree 2 ring: a window",
      said[1])
    assert.equal(said[1], report.warnings[#report.warnings])
    assert(#select(4, render {}) == 0)
    local plain = render { dering = false }
    local truth = assert(scene:pathtrace { size = { 48, 36 }, samples = 64, layers = false })
    local mine, others = image:compare(truth).mse, plain:compare(truth).mse
    assert(mine <= others, mine .. " " .. others)
  end)

  it("has a window of a width that is given, or none", function()
    local _, report, below = render { dering = false }
    assert(report.dering.width == nil and report.dering.before == report.dering.after and below > 0.001)
    local _, narrow = render { dering = 1.5 }
    assert(narrow.dering.width == 1.5 and narrow.dering.after < 0.0005)
    for _, bad in ipairs { 0, -1, "yes", 0 / 0 } do
      local ok, message = pcall(scene.render, scene, { grid = grid, dering = bad })
      assert(not ok and message:find "dering must be", message)
    end
  end)

  it("is as its page shows it: the cosine's degrees are damped", function()
    local folder = scratch.new()
    local function cosine(options)
      options.scene, options.poster = scene, false
      local path = folder.path .. "/a.html"
      local _, report = assert(grid:save(path, options))
      local file = assert(io.open(path))
      local text = file:read "*a"
      file:close()
      return tonumber(text:match '"cosine":%[[^,]+,([^,]+)'), report
    end
    local damped, report = cosine {}
    local plain = cosine { dering = false }
    folder:remove()
    assert(math.abs(plain / (2 * math.pi / 3) - 1) < 1e-6, plain)
    assert(damped < plain and report.dering.after <= 0.001 and report.warnings[1]:find "below zero")
  end)
end)

describe("pictures whose light is not below zero", function()
  it("have the bits that they have without a window", function()
    local scene = ylm.scene "a floor" {
      camera = ylm.camera { from = { 0, 3, 4 } },
      geometry = ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
      lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 },
    }
    local grid = scene:bake { probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 } }
    local a, report = scene:render { grid = grid, size = { 16, 9 }, samples = 1, visibility = "none" }
    local b = scene:render { grid = grid, size = { 16, 9 }, samples = 1, visibility = "none", dering = false }
    assert(report.dering.before <= 0.001 and report.dering.width == nil and #report.warnings <= 1)
    assert.equal(a:layer("radiance"):bytes(), b:layer("radiance"):bytes())
  end)
end)
