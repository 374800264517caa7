-- How much of a picture's light is not the scene's, since visibility is by direction: what reports, warnings and files say.
local lib = require "ylm.c.scene"
local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local huge = math.huge

--- A floor 2 wide under one lamp of radius 0.1 at height 1, `more` beside it, seen from above.
local function floor(more, fields)
  return ylm.scene "floor" (with({
    camera = ylm.camera { from = { 0, 6, 0.01 }, fov = 25 },
    geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 8 }, more },
    lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = { 30, 20, 10 } } },
  }, fields or {}))
end

--- A ceiling at height y, 20 wide, that the camera does not see (it looks from below it).
local function ceiling(y)
  return ylm.quad { corner = { -10, y, -10 }, u = { 20, 0, 0 }, v = { 0, 0, 20 } }
end
local below = { camera = ylm.camera { from = { 0, 0.4, 0.01 }, fov = 100 } }

local size = { size = { 40, 30 }, samples = 2, transfer_samples = 16, visibility = "transfer" }

--- Calls f and returns the lines that it says beside its results.
local function listening(f)
  local said = {}
  local before = ylm.on_warning(function(line) said[#said + 1] = line end)
  local ok, image, report = pcall(f)
  ylm.on_warning(before)
  assert(ok, image)
  return said, image, report
end

local function report_of(scene, options)
  return select(3, listening(function() return scene:render(ways.sum(with(size, options))) end))
end

--- Luminance of the surfaces in a picture.
local function surfaces(image)
  local radiance, emitter, sum = image:layer():totable(), image:layer "emitter":totable(), 0
  for y, row in ipairs(radiance) do
    for x, p in ipairs(row) do
      if emitter[y][x][1] == 0 then sum = sum + 0.2126 * p[1] + 0.7152 * p[2] + 0.0722 * p[3] end
    end
  end
  return sum
end

describe("light that passes occluders", function()
  it("is none, silently, where nothing is in the way, nothing occludes, or no lamp is", function()
    local wall = ylm.quad { corner = { -1, 0, 0.3 }, u = { 2, 0, 0 }, v = { 0, 0.9, 0 }, occludes = false }
    for what, scene in pairs { open = floor(), unoccluding = floor(wall), dark = floor(nil, { lights = {} }),
      empty = ylm.scene "empty" { camera = ylm.camera { from = { 0, 0, 1 } } } } do
      local said, image, report = listening(function() return scene:render(ways.sum(size)) end)
      local o = report.occlusion
      assert.same({ 0, 0, 0, 0 }, { o.passing, o.missing, o.passing_error, o.missing_error }, what)
      assert.same({}, said)
      assert.same({}, report.warnings)
      assert.equal("0", image.metadata.light_passing)
      assert.equal("0", image.metadata.light_missing)
    end
  end)

  it("is all of it under a ceiling below the lamp, beyond the occlusion distance", function()
    local scene = floor(ceiling(0.8), below)
    local said, image, report = listening(function() return scene:render(ways.sum(with(size,
      { occlusion_distance = 0.3 }))) end)
    local o = report.occlusion
    assert.same({ 1, 0, 0, 0 }, { o.passing, o.passing_error, o.missing, o.missing_error })
    assert.equal("1", image.metadata.light_passing)
    assert.same({ 'scene "floor": 100 % of the picture\'s light passes through occluders: occluders count by direction, up to '
      .. "occlusion_distance = 0.3 wherever the lamp is; set a longer one or use by = \"rays\" (ylm render --by rays), "
      .. "whose shadows are true" }, said)
    assert.same(said, report.warnings)
    assert.same({}, (listening(function() return scene:render(ways.sum(size)) end))) -- once a scene
  end)

  it("is missing under a ceiling above the lamp, within the occlusion distance", function()
    local o = report_of(floor(ceiling(1.4), below), { occlusion_distance = huge })
    assert.same({ 0, 0, 1, 0 }, { o.occlusion.passing, o.occlusion.passing_error, o.occlusion.missing,
      o.occlusion.missing_error })
    assert.truthy(o.warnings[1]:find("100 % of the scene's light is missing: ", 1, true))
    assert.truthy(o.warnings[1]:find("set a shorter one", 1, true))
  end)

  it("is what rays to the lamps find, without shadows", function()
    local scene = floor(ylm.sphere { at = { 0.2, 0.3, 0.1 }, radius = 0.25 })
    local rays = { size = { 80, 60 }, samples = 4, light_samples = 32 }
    local true_part = surfaces(scene:render(ways.rays(rays))) / surfaces(scene:render(ways.rays(with(rays,
      { shadows = false }))))
    for _, shading in ipairs { "pixel", "vertices" } do
      local r = report_of(scene, { visibility = "none", shading = shading, size = { 80, 60 }, samples = 4 })
      local o = r.occlusion
      assert.equal(0, o.missing)
      assert.is_true(o.passing_error > 0 and o.passing_error < 0.2 * o.passing, tostring(o.passing_error))
      if shading == "pixel" then assert.near(1 - true_part, o.passing, 3 * o.passing_error) end
      assert.truthy(r.warnings[1]:find('visibility = "none" has no shadows; set visibility = "transfer" or use by = "rays"', 1,
        true))
    end
  end)

  it("is that of every kind of lamp", function()
    local plank = ylm.box { bounds = { { -0.4, 0.35, -0.3 }, { 0.3, 0.4, 0.2 } } }
    local above = { corner = { -0.3, 1, -0.3 }, u = { 0.6, 0, 0 }, v = { 0, 0, 0.6 } }
    local horizon = { horizon = { 0.2, 1, 0 } }
    for what, lamp in pairs {
      polygon = ylm.polygon_light(with({ vertices = { { -0.3, 1, -0.3 }, { 0.3, 1, -0.3 }, { 0, 1.2, 0.4 } } }, horizon)),
      disk = ylm.disk_light(with({ at = { 0, 1, 0 }, normal = { 0.2, 1, 0 }, radius = 0.3, radiance = { 4, 1, 2 } }, horizon)),
      texture = ylm.textured_light(with(above, { image = { { { 1, 0, 0 }, { 0, 0, 0 } }, { { 0, 0, 0 }, { 4, 8, 1 } } },
        method = "exact" })),
    } do
      local scene = floor(plank, { lights = { lamp } })
      local rays = { size = { 40, 30 }, samples = 4, light_samples = 32 }
      local true_part = surfaces(scene:render(ways.rays(rays))) / surfaces(scene:render(ways.rays(with(rays,
        { shadows = false }))))
      local o = report_of(scene, { visibility = "none", size = { 40, 30 }, samples = 4 }).occlusion
      assert.near(1 - true_part, o.passing, 3 * o.passing_error, what)
      assert.is_true(o.passing > 0.02, what)
    end
  end)

  it("is the same of pictures by a device", function()
    if not require "spec.support.gpu".choose() then pending "no Vulkan device" end
    local gpu = require "spec.support.gpu".open()
    local scene = floor(ceiling(0.8), below)
    local view = scene:prepare(with(size, { occlusion_distance = 0.3 }))
    local grid = scene:bake { probes = ylm.uniform_grid { cells = 2, lmax = 2 }, occupied = view }
    local said, image, report = listening(function() return view:render { grid = grid, device = gpu } end)
    assert.equal(1, report.occlusion.passing)
    assert.same(said, report.warnings)
    assert.equal("1", image.metadata.light_passing)
    gpu:close()
  end)

  it("depends on the seed within its standard error, and not on the threads", function()
    local scene = floor(ylm.sphere { at = { 0.2, 0.3, 0.1 }, radius = 0.25 })
    local all = {}
    for seed = 1, 8 do
      local view = scene:prepare(with(size, { seed = seed, occlusion_distance = 0.4, size = { 120, 90 } }))
      local one, four = lib.shade_occlusion(view, 200, 8, 1), lib.shade_occlusion(view, 200, 8, 4)
      one.seconds, four.seconds = nil, nil
      assert.same(one, four)
      all[seed] = one
      assert.equal(200, one.points)
      assert.is_true(one.rays <= 2 * 8 * 200 and one.rays > 8 * 200)
    end
    for _, share in ipairs { "passing", "missing" } do
      local mean, error = 0, 0
      for _, o in ipairs(all) do mean, error = mean + o[share] / 8, error + o[share .. "_error"] / 8 end
      for seed, o in ipairs(all) do
        assert(math.abs(o[share] - mean) <= 3 * error + 1e-12, ("%s of seed %d: %g, mean %g, error %g"):format(share, seed,
          o[share], mean, error))
      end
    end
  end)

  it("of two rooms is all that the dark one shows: they are measured, said and saved", function()
    local scene = assert(ylm.load "examples/scenes/two_rooms.lua")
    local function right(image) -- the dark room's part of the surfaces' light
      local half = image:crop(image.size[1] / 2 + 1, 1, image.size[1] / 2, image.size[2])
      return surfaces(half) / surfaces(image)
    end
    local small = { size = { 96, 54 }, samples = 4 }
    local image, report
    local said = listening(function()
      image, report = scene:render(ways.sum(small))
      return image
    end)
    assert.equal(1, #said)
    assert.same(said, report.warnings)
    local o = report.occlusion
    assert.is_true(o.passing > 0.1 and o.missing < 0.01)
    assert.near(right(image), o.passing, 3 * o.passing_error + 0.02) -- harmonics blur some of it
    assert.equal(0, right(scene:render { bounces = 0, size = small.size, samples = 4, light_samples = 4 }))
    local long = report_of(scene, with(small, { occlusion_distance = 3 }))
    assert.is_true(long.occlusion.missing > 0.2 and long.occlusion.passing > 0.05)
    assert.truthy(long.warnings[1]:find(" passes through occluders and %d+ %% of the scene's light is missing: "))
    assert.is_nil(long.warnings[1]:find(" set a ", 1, true))
  end)

  it("is what examples/07_two_rooms.lua shows", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/07_two_rooms.lua --out %s --width 96 --samples 1 --rays 4"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    local picture = folder:read "two_rooms.png"
    folder:remove()
    assert.equal(0, status, out)
    assert.truthy(out:find "\n +3 +%d+%.%d +%d%.%d +[23]%d%.%d +%d%.%d +0%.[67]", out)
    if pcall(require, "ylm.c.vtk") then assert.equal("\137PNG", picture:sub(1, 4)) end
  end)

  it("is measured once a view, and reported by every method with transfer vectors", function()
    local scene = floor(ceiling(0.8), below)
    local view = scene:prepare(with(size, { occlusion_distance = 0.3 }))
    local grid = scene:bake { probes = ylm.uniform_grid { cells = 2, lmax = 2 }, occupied = view }
    local _, first = view:render { grid = grid }
    local _, second = view:render { by = "sum" }
    assert.same(first.occlusion, second.occlusion)
    assert.same(first.warnings, second.warnings)
    assert.equal(first.occlusion.seconds, second.seconds.occlusion)
    local image, rays = view:render { by = "rays", light_samples = 4 }
    assert.is_nil(rays.occlusion)
    assert.is_nil(image.metadata.light_passing)
    assert.same({}, rays.warnings)
    assert.equal(1, select(2, scene:render(with(size, { occlusion_distance = 0.3, grid = grid }))).occlusion.passing)
  end)
end)
