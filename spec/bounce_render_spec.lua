-- Pictures with bounces: closed forms, the path tracer, relighting without rays, walls, reports and the one knob.
local long = require "spec.support.long"
local ylm = require "ylm"

local pi = math.pi

local function mean(image, c)
  local a, n, sum = image:layer "radiance", 0, 0
  for _, row in ipairs(a:totable()) do
    for _, p in ipairs(row) do n, sum = n + 1, sum + p[c or 2] end
  end
  return sum / n
end

--- sqrt(max(0, mean((a-b)^2 - variance of b))) / mean of b.
local function error_of(a, b)
  local x, y, v = a:layer "radiance":totable(), b:layer "radiance":totable(), b:layer "variance":totable()
  local n, square, sum = 0, 0, 0
  for i, row in ipairs(y) do
    for k, p in ipairs(row) do
      for c = 1, 3 do
        n, sum = n + 1, sum + p[c]
        square = square + (x[i][k][c] - p[c]) ^ 2 - v[i][k][c]
      end
    end
  end
  return math.sqrt(math.max(0, square / n)) / (sum / n)
end

--- How many numbers of two pictures differ.
local function different(a, b)
  local x, y, n = a:layer "radiance":totable(), b:layer "radiance":totable(), 0
  for i, row in ipairs(x) do
    for k, p in ipairs(row) do
      for c = 1, 3 do if p[c] ~= y[i][k][c] then n = n + 1 end end
    end
  end
  return n
end

-- Closed forms ---------------------------------------------------------------------------------

local RADIUS, RADIANCE, RHO = 0.1, 10, 0.5

--- The inside of a sphere around a lamp, seen from beside it.
local function globe()
  return ylm.scene "globe" {
    camera = ylm.camera { from = { 0.4, 0, 0 }, at = { 1, 0.1, 0 }, fov = 60 },
    geometry = { ylm.sphere { radius = 1, divide = { 64, 32 }, material = ylm.matte { albedo = RHO } } },
    lights = { ylm.sphere_light { at = { 0, 0, 0 }, radius = RADIUS, radiance = RADIANCE } },
  }
end

describe("a picture with bounces", function()
  it("is rho/pi E / (1 - rho) inside of a sphere, and what n bounces add up to", function()
    local scene = globe()
    local t = scene:links { spacing = 0.2, rays = 64 }
    local E = pi * RADIANCE * RADIUS ^ 2
    for bounces, sum in pairs { [0] = 1, [1] = 1 + RHO, [2] = 1 + RHO + RHO ^ 2, all = 1 / (1 - RHO) } do
      local image, report = scene:render { size = { 16, 9 }, samples = 1, bounces = bounces,
        bounced = bounces ~= 0 and t or nil }
      assert.near(1, mean(image) / (RHO / pi * E * sum), 0.01)
      assert.equal(bounces, report.bounces)
      assert.equal(bounces == 0, report.omits ~= nil)
    end
  end)

  it("is 1 where an albedo of 1 stands under a sky of 1", function()
    local scene = ylm.scene "furnace" {
      camera = ylm.camera { from = { 0, -4, 1 }, up = { 0, 0, 1 }, fov = 30 },
      geometry = { ylm.knot { p = 2, q = 3, radius = 1, minor = 0.4, tube = 0.2, divide = { 200, 16 },
        material = ylm.matte { albedo = 1 } } },
      lights = { ylm.environment_light { radiance = 1 } }, links = ylm.links { spacing = 0.2, rays = 128 },
    }
    local image = scene:render { size = { 24, 18 }, samples = 4, light_samples = 32, bounces = "all" }
    assert.near(1, mean(image), 0.01)
  end)
end)

-- A room -----------------------------------------------------------------------------------------

local function lamp(x, radiance)
  return ylm.sphere_light { at = { x, 1.7, 1.3 }, radius = 0.1, radiance = radiance or { 30, 25, 20 } }
end

local function room(lights, more)
  local geometry = {
    ylm.box { bounds = { { -1.5, 0, -1.5 }, { 1.5, 2, 1.5 } }, material = ylm.matte { albedo = { 0.7, 0.6, 0.5 } } },
    ylm.box { bounds = { { -0.4, 0.001, -0.9 }, { 0.2, 0.8, -0.3 } }, material = ylm.matte { albedo = { 0.2, 0.3, 0.6 } } },
  }
  for _, g in ipairs(more or {}) do geometry[#geometry + 1] = g end
  return ylm.scene "room" { camera = ylm.camera { from = { 0.9, 1.2, 1.3 }, at = { 0, 0.6, -0.5 }, fov = 60 },
    geometry = geometry, lights = lights or { lamp(-0.5) }, links = ylm.links { spacing = 0.15, rays = 64 } }
end

local SMALL = { size = { 32, 18 }, samples = 4 }

local function with(more)
  local o = {}
  for k, v in pairs(SMALL) do o[k] = v end
  for k, v in pairs(more) do o[k] = v end
  return o
end

describe("gathered light", function()
  it("is that of paths, pixel by pixel", function()
    local scene = room()
    local truth = scene:pathtrace { size = SMALL.size, samples = 256, layers = false, reflections = { 1, "all" } }
    local image = scene:render(with { bounces = "all", samples = 64, rays = 512, light_samples = 64,
      bounced = scene:links { spacing = 0.1, rays = 64 } })
    assert.is_true(error_of(image, truth) < 0.04)
    assert.is_true(error_of(scene:render(with { light_samples = 64, bounces = 0 }), truth) > 0.2)
  end)

  it("follows lamps without a ray, as a picture made anew, whatever the number of threads", function()
    local before, after = { lamp(-0.5) }, { lamp(0.6, { 5, 20, 40 }) }
    local scene = room(before)
    local t = scene:links { spacing = 0.4, rays = 32 }
    local view = scene:prepare(with { rays = 32, links = t })
    assert.equal(32, view.stats.links)
    assert.equal(4 * 32 * view.stats.points, view.stats.link_rays * 4)
    assert.is_true(view.stats.link_bytes >= view.stats.link_rays * 2 and view.stats.link_bytes < view.stats.link_rays * 3)
    local lit = t:radiosity()
    local first = view:render { bounced = lit }
    lit:update(after)
    local image, report = view:render { bounced = lit, threads = 1 }
    local anew = room(after)
    local again = anew:render(with { bounces = "all", rays = 32, bounced = anew:links { spacing = 0.4, rays = 32 } })
    assert.equal(0, different(again, image))
    assert.is_false(mean(first) == mean(image))
    assert.equal("links", report.bounced)
    for _, threads in ipairs { 2, 7 } do
      local other = view:render { bounced = lit, threads = threads, lights = after }
      assert.equal(0, different(image, other))
    end
  end)
end)

-- Walls --------------------------------------------------------------------------------------------

--- A lamp in the left of two rooms with a wall between them; the camera is in the left or in the right one.
local function two_rooms(wall, side)
  return ylm.scene "two rooms" { camera = ylm.camera { from = { 1.8 * side, 1.2, 1.2 }, at = { side, 0.8, -0.5 }, fov = 70 },
    geometry = { ylm.box { bounds = { { -2, 0, -1.5 }, { 2, 2, 1.5 } }, material = ylm.matte { albedo = 0.6 } }, wall },
    lights = { lamp(-0.8) }, links = ylm.links { spacing = 0.1, rays = 64 } }
end

describe("a wall", function()
  local walls = {
    quad = ylm.quad { corner = { 0, 0, 1.5 }, u = { 0, 0, -3 }, v = { 0, 2, 0 }, material = ylm.matte { albedo = 0.6 } },
    box = ylm.box { bounds = { { -0.05, 0.0001, -1.4999 }, { 0.05, 1.9999, 1.4999 } }, material = ylm.matte { albedo = 0.6 } },
  }
  for name, wall in pairs(walls) do
    it("of a " .. name .. " lets less than 1 % of the light through", function()
      local bright = mean((two_rooms(wall, -1):render(with { bounces = "all" })))
      local dark = mean((two_rooms(wall, 1):render(with { bounces = "all" })))
      assert.is_true(dark < 0.01 * bright)
    end)
  end
end)

-- The knob -----------------------------------------------------------------------------------------

describe("a tolerance of a picture", function()
  it("chooses, judges and says so", function()
    local image, report = room():render { size = { 26, 14 }, bounces = "all", tolerance = 0.08 }
    assert.is_true(report.met)
    assert.is_true(report.error <= 0.08 and report.judged.pixels > 300)
    assert.is_true(report.judged.sure and report.judged.uncertainty < 0.02 and #report.warnings == 0)
    assert.equal(report.chosen.rays, report.links)
    assert(report.judged.samples % 1 == 0 and report.judged.samples >= 128) -- in the mean of pixels
    assert.equal("true", image.metadata.met)
  end)

  it("judges the very pixels of the picture, its own noise included", function()
    local scene = room()
    local truth = scene:pathtrace { size = { 16, 9 }, samples = 512, layers = false, reflections = { 1, "all" } }
    local before = ylm.on_warning(false)
    for _, means in ipairs(long({ {} }, { {}, { samples = 4, rays = 4, light_samples = 4 } })) do
      local image, report = scene:render { size = { 16, 9 }, bounces = "all", tolerance = 0.001, samples = means.samples or 1,
        rays = means.rays or 16, light_samples = means.light_samples or 1 }
      assert.is_false(report.met)
      assert.near(1, report.error / error_of(image, truth), 0.1)
    end
    ylm.on_warning(before)
  end)

  it("that is met as far as is known is said to be so", function()
    local before = ylm.on_warning(false)
    local _, report = room():render { size = { 4, 2 }, bounces = "all", tolerance = 0.01, seed = 4 }
    local _, missed = room():render { size = { 4, 2 }, bounces = "all", tolerance = 0.01, seed = 5 }
    ylm.on_warning(before)
    assert.same({ true, false }, { report.met, missed.met })
    assert.same({ false, false }, { report.judged.sure, missed.judged.sure })
    assert.matches("tolerance 0.01 is met as far as %d+ paths of each of %d pixels can tell: the error is 0.00%d+, and may be "
      .. "0.0", report.warnings[1])
  end)

  it("that is not met is said with cause and remedy", function()
    local said = {}
    local before = ylm.on_warning(function(m) said[#said + 1] = m end)
    local _, report = room():render { size = { 32, 18 }, tolerance = 0.001, samples = 1, light_samples = 1, bounces = 0 }
    ylm.on_warning(before)
    assert.is_false(report.met)
    assert.equal(1, #said)
    assert.matches("tolerance 0.001 is not met, the error is .*: .* set .* or set tolerance = ", said[1])
    assert.same(said, report.warnings)
  end)
end)

describe("bounces of a picture", function()
  it("say why links cannot be made, and know a scene that has changed, and light that rays do not see", function()
    local scene = globe()
    local few = { size = { 4, 4 }, samples = 1 }
    scene.link_options = ylm.links { spacing = 1e-9 }
    local image, message, code = scene:render { size = few.size, samples = 1, bounces = "all" }
    assert.is_nil(image)
    assert.matches("spacing = 1e%-09 would make", message)
    assert.equal("ELIMIT", code)
    scene.link_options = nil
    local lit = scene:links({ spacing = 0.4, rays = 16 }):radiosity()
    assert.error_matches(function() scene:prepare(few):render { lights = { lit } } end, "see nothing of a ylm.radiosity")
    assert.error_matches(function() scene:render { bounces = 1e9 } end, "from 0 to 1000000")
    scene.geometry[1] = ylm.sphere { radius = 2, divide = { 16, 8 } }
    assert.error_matches(function() scene:render { size = few.size, samples = 1, bounced = lit } end, "of other geometry")
    lit:close()
    assert.error_matches(function() ylm.light_field(2, lit, { 0, 0, 0 }) end, "the radiosity has been closed")
  end)

  it("go by links where links are asked for by name", function()
    local scene = room()
    local plain, report = scene:render(with { bounces = 1 })
    local named, other = scene:render(with { bounces = 1, bounced = "links" })
    assert(report.bounces == 1 and other.bounces == 1)
    assert(plain:compare(named).max == 0)
  end)

  it("are all of a scene's where nobody says how many, and none where 0 is named", function()
    local scene = room()
    local all, report = scene:render(with { bounces = "all" })
    local plain, other = scene:render(with {})
    assert(report.bounces == "all" and other.bounces == "all" and other.bounced == "links")
    assert(plain:compare(all).max == 0)
    local _, none = scene:render(with { bounces = 0 })
    assert(none.bounces == 0 and none.omits)
  end)

  it("refuse options that contradict each other, naming the field", function()
    local scene = room()
    local lit = scene:links { spacing = 1, rays = 4 }:radiosity()
    for _, case in ipairs {
      { { bounces = -1 }, "bounces must be a number of reflections" }, { { rays = 5 }, "rays must be a multiple of 4" },
      { { bounces = 1, bounced = lit }, "leave one out" }, { { bounced = "lit" }, "bounced must be" },
      { { tolerance = 0 }, "tolerance must be" }, { { tolerance = 0.1, bounced = lit }, "leave bounced out" },
      { { tolerance = 0.1, shading = "vertices" }, "shading = 'pixel'" },
      { { bounced = room():links({ spacing = 1, rays = 4 }):radiosity() }, "the links are of scene" },
      { { bounced = room():links { spacing = 1, rays = 4 }, bounces = 0 }, "render: the links are of scene" },
        -- bounces or not
    } do
      local ok, message = pcall(scene.render, scene, with(case[1]))
      assert.is_false(ok)
      assert.matches(case[2], message, 1, true)
    end
    lit:close()
    assert.matches("closed", select(2, pcall(scene.render, scene, with { bounced = lit })))
    local shut = scene:links { spacing = 1, rays = 4 }
    shut:close()
    assert.matches("render: the links have been closed", select(2, pcall(scene.render, scene, with { bounced = shut })))
  end)

  it("take their links in a bake as in a picture", function()
    local scene = room()
    local t = scene:links { spacing = 0.5, rays = 16 }
    local probes = ylm.uniform_grid { bounds = { { -0.4, 0.3, -0.4 }, { 0.4, 0.9, 0.4 } }, cells = 1, lmax = 1 }
    local function light(o)
      o.probes, o.occupied = probes, "everywhere"
      return scene:bake(o):sample { { 0.1, 0.5, 0.2 } }
    end
    local own = ylm.bake(probes, t:radiosity():field { quantity = "indirect" }):sample { { 0.1, 0.5, 0.2 } }
    local given = light { quantity = "indirect", links = t }
    assert.equal(0, (given - own):abs():max())
    assert(given:get(1, 1, 1) > 0 and (light { quantity = "direct", links = t } - given):abs():max() > 0)
    for _, case in ipairs {
      { { links = t }, "bake: links are for quantity = 'direct', 'indirect' or 'all'" },
      { { quantity = "all", links = room():links { spacing = 1, rays = 4 } }, "bake: the links are of scene" },
    } do
      local ok, message = pcall(light, case[1])
      assert.is_false(ok)
      assert.matches(case[2], message, 1, true)
    end
    t:close()
    assert.matches("bake: the links have been closed", select(2, pcall(light, { quantity = "all", links = t })))
  end)

  it("says the noise of its links, and warns where they miss what is bright", function()
    local function lit_by(height, radius, radiance)
      return ylm.scene "a room" { camera = ylm.camera { from = { 0, 1.2, 1.8 }, at = { 0, 0.9, 0 } },
        geometry = { ylm.box { bounds = { { -2, 0, -2 }, { 2, 2.5, 2 } } } },
        links = ylm.links { spacing = 0.15, rays = 32 },
        lights = { ylm.sphere_light { at = { 0, height, 0 }, radius = radius, radiance = radiance } } }
    end
    local function picture(scene, links)
      return select(2, scene:render { size = { 24, 16 }, samples = 1, bounces = "all", rays = links, layers = false })
    end
    local calm, hot = picture(lit_by(1.3, 0.2, 10), 256), picture(lit_by(0.1, 0.05, 200))
    assert.equal(0, #calm.warnings)
    assert.is_true(calm.bounced_noise > 0 and calm.bounced_noise < 0.05)
    assert.is_true(hot.bounced_noise > 0.25)
    assert.matches("64 links of a shading point leave a noise of %d+ %% in the light that bounces: few of them meet what is "
      .. "bright", hot.warnings[1])
    local more = picture(lit_by(0.1, 0.05, 200), 1024)
    assert.is_true(more.bounced_noise < hot.bounced_noise / 2)
  end)

  it("warns from 5 % on by default, and the links that it names leave no more than 2 %", function()
    local scene = ylm.scene "a room" { camera = ylm.camera { from = { 0, 1.2, 1.8 }, at = { 0, 0.9, 0 } },
      geometry = { ylm.box { bounds = { { -2, 0, -2 }, { 2, 2.5, 2 } } } },
      links = ylm.links { spacing = 0.15, rays = 32 },
      lights = { ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.2, radiance = 10 } } }
    local function picture(links)
      return select(2, scene:render { size = { 24, 16 }, samples = 1, bounces = "all", rays = links, layers = false })
    end
    local by_default = picture()
    assert.is_true(by_default.bounced_noise > 0.05 and by_default.bounced_noise < 0.25, by_default.bounced_noise)
    local enough = by_default.warnings[1]:match "64 links of a shading point leave a noise of %d+ %% in the light that bounces: "
      and tonumber(by_default.warnings[1]:match "set rays = (%d+) for 2 %%, or a tolerance")
    local quiet = picture(enough)
    assert.same({}, quiet.warnings)
    assert.is_true(quiet.bounced_noise < 0.02, quiet.bounced_noise)
  end)
end)

describe("direct light of a picture", function()
  local function plate(radius)
    return ylm.scene "plate" { camera = ylm.camera { from = { 0, 2, 3 }, at = { 0, 0, 0 } },
      geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
        ylm.box { bounds = { { -0.5, 0.3, -0.5 }, { 0.5, 0.4, 0.5 } } } },
      lights = { ylm.sphere_light { at = { 0, 2.5, 4.5 }, radius = radius, radiance = 10 } } }
  end

  it("says its noise, that to a picture by far more shadow rays", function()
    local scene = plate(0.8)
    local view = scene:prepare { size = { 48, 27 }, samples = 1, share = 0 }
    local few, report = view:render { light_samples = 4, layers = false }
    local many = ylm.array((view:render { light_samples = 4096, layers = false }):layer "radiance", "double")
    local seen = view.stats.points / view.stats.pixels
    local square = ((ylm.array(few:layer "radiance", "double") - many) ^ 2):mean() / seen
    assert.near(1, report.direct_noise / (math.sqrt(square) / (many:mean() / seen)), 0.25)
    local grid = scene:bake { probes = ylm.uniform_grid { cells = 1, lmax = 1 } }
    assert.is_nil(select(2, scene:render { size = { 8, 6 }, samples = 1, grid = grid }).direct_noise)
  end)

  it("warns where shadow rays leave more than 5 %, and names how many leave 2 %", function()
    local function picture(rays)
      return select(2, plate(0.8):render { size = { 48, 27 }, samples = 1, light_samples = rays, layers = false, bounces = 0 })
    end
    local few = picture(1)
    local enough = tonumber(few.warnings[1]:match
      "1 shadow rays of a shading point leave a noise of %d+ %% in direct light: set light_samples = (%d+) for 2 %%")
    local many = picture(enough)
    assert.is_true(few.direct_noise > 0.05 and many.direct_noise < 0.022, many.direct_noise)
    assert.equal(0, #many.warnings)
  end)
end)
