-- Pictures: where the camera looks, layers, lamps in sight, reports, cancellation.
local ylm = require "ylm"
local core = require "ylm.c.core"

local pi, tan = math.pi, math.tan

local with = require "spec.support.with"
local ways = require "spec.support.ways"

--- A square of half-width h in the plane z = 0, seen from z = 5 with y up.
local function card(h, fov, fields)
  return ylm.scene "card" (with({
    camera = ylm.camera { from = { 0, 0, 5 }, fov = fov or 40 },
    geometry = { ylm.quad { corner = { -h, -h, 0 }, u = { 2 * h, 0, 0 }, v = { 0, 2 * h, 0 },
      material = ylm.matte { albedo = { 0.5, 0.25, 0.125 } } } },
    lights = { ylm.sphere_light { at = { 0, 0, 9 }, radius = 0.1, radiance = { 100, 200, 300 } } },
    background = { 0.25, 0.5, 0.75 },
  }, fields or {}))
end

local options = { size = { 40, 20 }, samples = 4, visibility = "none" }

local function sum(layer)
  local s = 0
  for _, row in ipairs(layer:totable()) do for _, p in ipairs(row) do s = s + p[1] end end
  return s
end

describe("a picture", function()
  it("has x to the right, row 1 at the top, and the field of view in its height", function()
    local half = 5 * tan(pi / 9) -- of the visible height at the card, fov 40
    local image = card(100):render(ways.sum(options))
    local position = image:layer "position"
    for _, p in ipairs { { 1, 1 }, { 1, 40 }, { 20, 1 }, { 11, 21 }, { 7, 33 } } do
      local x, y = ((p[2] - 0.5) / 40 * 2 - 1) * 2 * half, (1 - (p[1] - 0.5) / 20 * 2) * half
      assert.near(x, position:get(p[1], p[2], 1), half / 20)
      assert.near(y, position:get(p[1], p[2], 2), half / 20)
      assert.near(0, position:get(p[1], p[2], 3), 1e-5)
    end
    -- Depth is along the axis of view, the same all over the card.
    assert.near(5, image:layer "depth":get(1, 1, 1), 1e-4)
    assert.near(5, image:layer "depth":get(11, 21, 1), 1e-4)
    -- A card as high as the view covers its square in the middle, and what is beside it is background.
    local coverage = card(half):render(ways.sum(options)):layer "coverage"
    assert.same({ 1, 0, 1, 0 }, { coverage:get(1, 20, 1), coverage:get(1, 8, 1), coverage:get(20, 28, 1),
      coverage:get(10, 33, 1) })
    assert.near(400, sum(coverage), 8)
  end)

  it("has the layers it names, and background where nothing is", function()
    local image = card(1):render(ways.sum(options))
    assert.same({ "radiance", "normal", "position", "depth", "albedo", "coverage", "emitter" }, (image:layers()))
    assert.same({ { 0.25, 0.5, 0.75 } }, { image:layer()[1][1]:totable() })
    assert.equal(math.huge, image:layer "depth":get(1, 1, 1))
    assert.same({ 0, 0, 1 }, image:layer "normal"[10][20]:totable())
    assert.same({ 0.5, 0.25, 0.125 }, image:layer "albedo"[10][20]:totable())
    assert.same({ "radiance" }, (card(1):render(ways.sum(with(options, { layers = false }))):layers()))
    -- From behind, normals turn to the camera.
    local back = card(1, 40, { camera = ylm.camera { from = { 0, 0, -5 } } }):render(ways.sum(options))
    assert.same({ 0, 0, -1 }, back:layer "normal"[10][20]:totable())
  end)

  it("shows lamps as emitters in proportion to what they fill", function()
    local r, d, n = 0.8, 4, 200
    local s = ylm.scene "lamp" {
      camera = ylm.camera { from = { 0, 0, d }, fov = 40 },
      lights = { ylm.sphere_light { at = { 0, 0, 0 }, radius = r, radiance = { 1, 2, 4 } } },
    }
    local image = s:render { bounces = 0, size = { n, n }, samples = 9, light_samples = 1 }
    -- The silhouette's radius is that of the tangent cone.
    local a = r / math.sqrt(d * d - r * r) / tan(pi / 9)
    assert.near(pi * a * a / 4, sum(image:layer "emitter") / n / n, 1e-3)
    assert.same({ 1, 2, 4 }, image:layer()[n / 2][n / 2]:totable())
    assert.equal(0, sum(image:layer "coverage"))
  end)

  it("takes samples as camera rays by every method", function()
    local size = { 6, 4 }
    local function primary(_, report) return report.rays.primary end
    for _, by in ipairs { "sum", "rays" } do
      assert.equal(72, primary(card(1):render { by = by, size = size, samples = 3, light_samples = by == "rays" and 2 or nil }))
    end
    local view = card(1):prepare { size = size, samples = 3 }
    assert.equal(72, view.stats.primary_rays)
    assert.equal(3, view.options.samples)
    local image, report = card(1):render { bounces = 0, size = size, samples = 1, light_samples = 5 }
    assert.equal(5 * report.points, report.rays.shadow)
    assert.same({ "1", "5" }, { image.metadata.samples, image.metadata.light_samples })
  end)

  it("is lit as the closed form says: a lamp over a plane", function()
    local d, r = 9, 0.1
    local image = card(0.01, 0.05):render { by = "sum", size = { 2, 2 }, samples = 4, visibility = "none", lmax = 10 }
    -- To lmax 10 the clamped cosine is 1.01023 at its peak: the sum of A_l (2l+1) / 4pi.
    local A, peak = require("ylm.c.core").material_transfer("matte", 10), 0
    for l = 0, 10 do peak = peak + A:get(l + 1) * (2 * l + 1) / (4 * pi) end
    local E = peak * pi * (r / d) ^ 2
    local got, wanted = image:layer()[1][1]:totable(), { 0.5 * 100 * E / pi, 0.25 * 200 * E / pi, 0.125 * 300 * E / pi }
    for c = 1, 3 do assert.near(1, got[c] / wanted[c], 2e-3) end -- l(l+1)/4 sin^2 of the lamp's angle is lost
  end)

  it("is lit by rays to the lamps where nobody says how, without probes: prepared or not, by any number of threads", function()
    local s, size = card(1, 40, { probes = nil }), { 40, 20 }
    local image, report = s:render { size = size, samples = 4, bounces = 0 }
    local m = image.metadata
    assert.same({ "rays", 32, 0 }, { report.visibility, report.light_samples, report.rays.occlusion })
    assert.equal(32 * report.points, report.rays.shadow)
    assert.same({ "rays", "rays", "32" }, { m.method, m.visibility, m.light_samples })
    assert.is_nil(m.occlusion_distance)
    assert.same({}, report.warnings)
    local function same(what, other) assert.equal(0, (core.array_distance(image:layer(), other:layer())), what) end
    local view = s:prepare { size = size, samples = 4 }
    same("named", (s:render { size = size, samples = 4, visibility = "rays", light_samples = 32, threads = 1, bounces = 0 }))
    same("prepared", (view:render()))
    same("raycast", (view:render { by = "rays", light_samples = 32, threads = 3 }))
    same("written again", (view:render { out = s:render { size = size, samples = 4, light_samples = 1, bounces = 0 } }))
    -- A lamp behind the card brings nothing, what the closed form says in front of it.
    local dark = card(1, 40, { camera = ylm.camera { from = { 0, 0, -5 } } }):render { size = size, samples = 4, bounces = 0 }
    assert.same({ 0, 0, 0 }, dark:layer()[10][20]:totable())
    local p = image:layer "position"[10][20]:totable()
    local r2 = p[1] ^ 2 + p[2] ^ 2 + 81
    assert.near(0.5 * 100 * 0.01 * 9 / r2 ^ 1.5, image:layer():get(10, 20, 1), 1e-3 * image:layer():get(10, 20, 1))
    -- By vertices, of a mesh of two triangles.
    local vertices = s:render { size = size, samples = 4, shading = "vertices", bounces = 0 }
    assert.is_true(vertices:layer():get(10, 20, 1) > 0)
  end)

  it("by a grid of lights has transfer vectors, whose light that is not the scene's is said", function()
    local shelf = ylm.quad { corner = { -3, -3, 8 }, u = { 6, 0, 0 }, v = { 0, 6, 0 } }
    local s = card(1)
    s.geometry[2] = shelf
    local o = { size = { 20, 10 }, samples = 1, occlusion_distance = 0.5, transfer_samples = 8 }
    o.grid = s:bake { probes = ylm.uniform_grid { cells = 2, lmax = 2 } }
    local before = ylm.on_warning(function() end)
    local image, report = s:render(o)
    ylm.on_warning(before)
    assert.same({ "transfer", 1 }, { report.visibility, report.occlusion.passing })
    assert.truthy(report.warnings[1]:find "100 %% of the picture's light passes through occluders")
    assert.is_true(image:layer():get(5, 10, 1) > 0)
    assert.same({ 0, 0, 0 }, (s:render { size = o.size, samples = 1, bounces = 0 }):layer()[5][10]:totable())
  end)

  it("by a grid that holds its shadows is lit by the cosine alone, whatever the view knows of visibility", function()
    local s = card(1)
    s.geometry[2] = ylm.quad { corner = { -3, -3, 1 }, u = { 6, 0, 0 }, v = { 0, 6, 0 } } -- behind the camera
    s.camera = ylm.camera { from = { 0, 0, 0.9 }, fov = 40 }
    local function glow(points) -- radiance 1, 2, 4 from all around
      local rows = {}
      for i = 1, #points do rows[i] = { { 2 * math.sqrt(pi) }, { 4 * math.sqrt(pi) }, { 8 * math.sqrt(pi) } } end
      return ylm.array(rows, "double"), ylm.zeros({ #points, 3, 1, 3 }, "double")
    end
    local probes = ylm.uniform_grid { bounds = { { -4, -4, -1 }, { 4, 4, 2 } }, cells = 2, lmax = 0, metric_channels = "none" }
    local held = { lights = ylm.bake(probes, glow), direct = ylm.bake(probes, glow, { quantity = "direct" }),
      all = ylm.bake(probes, glow, { quantity = "all" }) }
    local o = { size = { 8, 6 }, samples = 1, layers = false }
    local function middle(image) return image:layer()[3][4]:totable() end
    local before = ylm.on_warning(function() end)
    for _, quantity in ipairs { "direct", "all" } do
      o.grid = held[quantity]
      local image, report = s:render(o)
      assert.same({ "grid", 0 }, { report.visibility, report.rays.occlusion })
      assert.is_nil(report.occlusion)
      assert.equal("grid", image.metadata.method)
      for _, v in ipairs { "rays", "transfer", "none" } do
        local view = s:prepare { size = o.size, samples = 1, visibility = v }
        for c, wanted in ipairs { 0.5, 0.5, 0.5 } do
          assert.near(wanted, middle(view:render { grid = o.grid })[c], 1e-5)
        end
      end
      assert.near(0.5, middle(image)[1], 1e-5)
    end
    o.grid, o.occlusion_distance = held.lights, 2
    assert.is_true(middle(s:render(o))[1] < 0.2) -- the quad before the card darkens lights
    ylm.on_warning(before)
  end)

  it("carries how it was made", function()
    local s = card(1)
    local grid = s:bake { probes = ylm.uniform_grid { cells = 2, lmax = 3 } }
    local image, report = s:render(with(options, { grid = grid }))
    local m = image.metadata
    assert.equal("3", m.lmax)
    assert.equal("card", m.scene)
    assert.equal("grid", m.method)
    assert.equal(ylm.info().version, m.version)
    assert.truthy(m.convention:find "Condon")
    assert.truthy(m.grid:find "uniform")
    assert.is_nil(m.seconds) -- a time is nothing of the image
    assert(report.seconds.total > 0)
    assert.equal(0, image:layer "level":get(10, 20, 1))
    assert.equal(40 * 20 * 4, report.rays.primary)
    local total = 0
    for name, seconds in pairs(report.seconds) do if name ~= "total" then total = total + seconds end end
    assert.near(total, report.seconds.total, 1e-9)
  end)

  it("says of an adaptive grid which level and estimated error its points have", function()
    local s = card(1)
    local view = s:prepare(with(options, { lmax = 2 }))
    local grid = s:bake { probes = ylm.adaptive_grid { depth = 4, threshold = 0.05, lmax = 2 }, occupied = view }
    local image = view:render { grid = grid, truth = view:render { by = "sum" } }
    local level, cell = image:layer "level":get(10, 20, 1), grid:locate(image:layer "position"[10][20]:totable())
    assert.is_true(math.abs(level - cell.level) <= 1)
    assert.is_true(image:layer "error":get(10, 20, 1) >= 0)
    local far = core.array_distance(image:layer "true_error", ylm.array(image:layer "true_error"))
    assert.equal(0, far)
    assert.is_true(image:layer "true_error":get(10, 20, 1) < 0.01 * image:layer():get(10, 20, 1))
  end)

  it("bakes what it needs where a scene has probes", function()
    local s = card(1, 40, { probes = ylm.uniform_grid { cells = 2, lmax = 2 } })
    local image, report = s:render(with(options, { bounces = 0 }))
    assert.equal("2", image.metadata.lmax)
    assert.equal(0, report.unbaked + report.outside)
    for _, occupied in ipairs { "surfaces", "camera", "vertices", "everywhere" } do
      assert.is_true(s:bake({ occupied = occupied }).stats.points > 0)
    end
  end)

  it("bakes what it is to hold: lights, direct light with shadows, bounces, both", function()
    local s = card(1, 40, { probes = ylm.uniform_grid { bounds = { { -1, -1, 0.1 }, { 1, 1, 1 } }, cells = 2, lmax = 2 } })
    s.geometry[2] = ylm.quad { corner = { -1, -1, 2 }, u = { 1, 0, 0 }, v = { 0, 2, 0 } } -- shades the left half of the card
    local o = { occupied = "everywhere" }
    local function bake(parts, bounces)
      o.quantity, o.bounces = parts, bounces
      local grid = assert(s:bake(o))
      return grid, grid:points().value
    end
    local lights, all_lit = bake()
    assert.equal("lights", lights.quantity)
    local direct, lit = bake "direct"
    assert.equal("direct", direct.quantity)
    local at, n = direct:points().position:totable(), 0
    for i, p in ipairs(at) do
      for c = 1, 3 do
        if p[1] > 0.5 then assert.near(all_lit:get(i, c, 1), lit:get(i, c, 1), 1e-4 * all_lit:get(i, c, 1)) end
        if p[1] < -0.5 then assert.equal(0, lit:get(i, c, 1)) end
      end
      n = n + (math.abs(p[1]) > 0.5 and 1 or 0)
    end
    assert.equal(18, n)
    local grid, back = bake "indirect"
    assert.equal("indirect", grid.quantity)
    local both
    grid, both = bake "all"
    assert.equal("all", grid.quantity)
    local sent = 0
    for i = 1, #at do
      sent = sent + back:get(i, 1, 1)
      assert.near(lit:get(i, 1, 1) + back:get(i, 1, 1), both:get(i, 1, 1), 1e-5)
    end
    assert.is_true(sent > 0)
    grid, both = bake("all", 0)
    assert.equal("direct", grid.quantity)
    assert.equal(0, (core.array_distance(both, lit)))
    o.progress = function() return false end
    assert.same({ "cancelled", "ECANCELLED" }, { select(2, s:bake(o)) })
    -- Pictures without a grid are shaded by lights.
    local _, report = s:render { size = { 8, 6 }, samples = 1, visibility = "none" }
    assert.equal("none", report.visibility)
  end)

  it("bakes for its surfaces by default, in the box of its geometry", function()
    local s = card(1, 40, { probes = ylm.adaptive_grid { depth = 4, lmax = 2 } })
    local grid, same = s:bake(), s:bake { occupied = "surfaces", seed = 1, threads = 1 }
    assert.equal(grid.stats.points, same.stats.points)
    assert.equal(0, grid.stats.outside)
    local meshes = ylm.bake(s.probes, s.lights, { geometry = s.geometry, bounds = grid.bounds })
    assert.equal(0, select(2, core.array_distance(grid:points().value, meshes:points().value)))
    assert.equal(0, (select(3, grid:sample(s.geometry[1].mesh:vertices())).unbaked))
  end)

  it("traces a changed scene anew", function()
    local s = card(1)
    local before = s:render(ways.sum(options)):layer():get(10, 20, 1)
    s.geometry[1].material = ylm.matte { albedo = 0.25 }
    assert.near(before / 2, s:render(ways.sum(options)):layer():get(10, 20, 1), 1e-6 * before)
  end)

  it("reports its stages and can be cancelled in each, leaving the floating-point mode alone", function()
    local s = card(1)
    local stages = {}
    local o = with(options, { visibility = "transfer", progress = function(_, _, stage) stages[stage] = true end })
    s:render(ways.sum(o))
    s:render { bounces = 0, size = { 40, 20 }, progress = o.progress, light_samples = 64 }
    for _, stage in ipairs { "primary rays", "transfer", "shading", "raycast" } do
      assert.is_true(stages[stage], stage)
      local function stop(_, _, at) return at ~= stage end
      local image, message, code
      if stage == "raycast" then image, message, code = s:render { bounces = 0, size = { 40, 20 }, progress = stop,
        light_samples = 64 }
      else image, message, code = s:render(ways.sum(with(o, { progress = stop }))) end
      assert.same({ "nil", "cancelled", "ECANCELLED" }, { type(image), message, code })
    end
    assert.is_false(pcall(function() s:render(ways.sum(with(o, { progress = function() error "mine" end }))) end))
    local tiny = tonumber "1e-310"
    assert.is_true(tiny * 0.5 > 0)
  end)

  it("of nothing is background", function()
    local s = ylm.scene "nothing" { camera = ylm.camera { from = { 0, 0, 5 } }, background = 0.5 }
    local image, report = s:render(ways.sum(options))
    assert.equal(0, report.points)
    assert.equal(0.5, image:layer():get(1, 1, 1))
    assert.is_true(s:render { bounces = 0, size = { 4, 2 }, light_samples = 64 } ~= nil)
  end)

  it("of a camera that looks away is background and lamps by every method, and the report says so", function()
    local s = card(1, 40, {
      camera = ylm.camera { from = { 0, 0, 5 }, at = { 0, 0, 9 } },
      lights = { ylm.sphere_light { at = { 0, 0, 9 }, radius = 0.5, radiance = { 1, 2, 3 } } },
      probes = ylm.adaptive_grid { lmax = 1, depth = 2 },
    })
    local grid = s:bake { occupied = "everywhere" }
    for what, picture in pairs {
      render = { s:render(with(options, { bounces = 0 })) }, grid = { s:render(with(options, { grid = grid })) },
      vertices = { s:render(with(options, { shading = "vertices", visibility = "transfer" })) },
      reference = { s:render(ways.sum(options)) }, raycast = { s:render { bounces = 0, size = options.size, samples = 4,
        light_samples = 64 } },
    } do
      local image, report = picture[1], picture[2]
      assert.same({ 0.25, 0.5, 0.75 }, image:layer()[1][1]:totable(), what)
      assert.same({ 1, 2, 3 }, image:layer()[10][20]:totable(), what)
      assert.equal(0, report.points, what)
      assert.equal("the camera sees no geometry: nothing to shade", report.note, what)
    end
    local _, report = card(1):render(ways.sum(options))
    assert.is_nil(report.note)
  end)
end)
