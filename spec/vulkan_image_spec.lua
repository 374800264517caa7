-- Pictures made on a device: shading points filtered into pixels, lamps drawn over them, whole frames. On Mesa's lavapipe,
-- where there is no other device.

local core = require "ylm.c.core"
local support = require "spec.support.gpu"
local ylm = require "ylm"
local scene = require "spec.support.floor_scene"

describe("ylm.vulkan pictures", function()
  if not pcall(require, "ylm.c.scene") then
    it("are filtered", function() pending "no Embree" end)
    return
  end
  local gpu = support.here()
  if not gpu then return end
  local binding = require "ylm.c.vulkan"

  --- Are they the same within 1e-5 of the largest number?
  local function same(a, b, bound)
    local largest, most = core.array_distance(a, ylm.zeros(a.shape, "float")), core.array_distance(a, b)
    assert(largest > 0.01 and most <= (bound or 1e-5) * largest, most / largest)
  end

  --- The picture of a prepared view by the processor and by a device, compared.
  local function compare(view, o, bound, device)
    o.layers, o.dering = false, false
    local here = assert(view:render(o))
    o.device = device or gpu
    local there, report = assert(view:render(o))
    o.device = nil
    same(here:layer(), there:layer(), bound)
    return there, report
  end

  local flying = ylm.sphere_lights {
    at = { { 0.1, 0.5, 0.9 }, { -0.2, 0.5, 0.8 }, { 0, 0.35, -0.5 }, { 0.12, 0.52, 0.6 }, { 0, 5, 9 }, { 0.6, 0.05, 0.2 },
      { -0.9, 1.1, 0.3 } },
    radius = { 0.05, 0.004, 0.2, 0.08, 0.1, 0.1, 0.15 },
    radiance = { { 3, 2, 1 }, { 30, 2, 1 }, { 1, 2, 9 }, { 0, 5, 1 }, { 9, 9, 9 }, { 2, 2, 2 }, { 4, 4, 0 } },
  }

  it("are the CPU's: one sample and several, odd sizes, lamps and background in sight", function()
    local s = scene()
    local grid = assert(s:bake())
    for _, case in ipairs { { { 40, 30 }, 1 }, { { 37, 23 }, 5 }, { { 1, 1 }, 16 }, { { 131, 1 }, 2 }, { { 3, 67 }, 4 } } do
      local view = assert(s:prepare { size = case[1], samples = case[2], transfer_samples = 16, visibility = "transfer" })
      local _, report = compare(view, { grid = grid })
      assert(report.stages.filter.dispatches > 0 and report.stages.download.seconds >= 0)
    end
  end)

  it("say what is below zero, and refuse a window, which the processor alone has", function()
    local s = scene()
    local dark = ylm.sphere_light { at = { 0.3, 0.8, 0.4 }, radius = 0.1, radiance = -20 } -- below zero for certain
    local grid = assert(s:bake { lights = { dark, ylm.sphere_light { at = { -0.5, 0.8, -0.4 }, radius = 0.1, radiance = 20 } } })
    local view = assert(s:prepare { size = { 40, 30 }, transfer_samples = 16, visibility = "transfer" })
    local image, report = assert(view:render { grid = grid, device = gpu })
    local x = image:layer()
    local negative, positive = -x:clamp(-math.huge, 0):sum(), x:clamp(0, math.huge):sum()
    assert.near(negative / (negative + positive), report.dering.before, 1e-6)
    assert(report.dering.before > 1e-3, report.dering.before)
    assert.matches("a device has no window against it", table.concat(report.warnings, "\n"))
    local ok, message = pcall(view.render, view, { grid = grid, device = gpu, dering = 3 })
    assert(not ok and message:find("no window against light below zero", 1, true), message)
  end)

  it("are the CPU's where vertices are shaded", function()
    local s = scene { channels = "luminance" }
    local grid = assert(s:bake())
    for samples = 1, 3, 2 do
      compare(assert(s:prepare { size = { 41, 31 }, samples = samples, shading = "vertices", transfer_samples = 16,
        visibility = "transfer" }),
        { grid = grid, lamps = flying })
    end
  end)

  it("show the background alone where the camera sees nothing", function()
    local s = scene()
    local grid = assert(s:bake())
    local away = ylm.scene "nothing" { camera = ylm.camera { from = { 0, 3, 0 }, at = { 0, 4, 0.1 }, fov = 30 },
      background = { 0.2, 0.1, 0.4 }, geometry = s.geometry, lights = s.lights }
    local view = assert(away:prepare { size = { 9, 7 }, samples = 2, visibility = "transfer" })
    assert.equal(0, view.stats.points)
    compare(view, { grid = grid })
  end)

  it("have lamps drawn over them, behind and before surfaces and one another, in double and in float", function()
    local narrow = support.open { validate = true }
    binding.gpu_shrink(narrow, 0, 0, 0, true)
    for device, bound in pairs { [gpu] = 1e-5, [narrow] = 5e-4 } do
      local s = scene()
      local grid = assert(s:bake())
      for _, case in ipairs { { { 150, 110 }, 1 }, { { 61, 47 }, 4 } } do
        local view = assert(s:prepare { size = case[1], samples = case[2], transfer_samples = 16, visibility = "transfer" })
        local _, report = compare(view, { grid = grid, lamps = flying }, bound, device)
        assert(report.stages.lamps.dispatches > 0)
      end
    end
    support.close_silent(narrow)
  end)

  it("are the CPU's where points are many: groups of one cell, of few, of many", function()
    local s = ylm.scene "floor" {
      camera = ylm.camera { from = { 0, 1, 0.01 }, at = { 0, 0, 0 }, fov = 60 },
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
      lights = scene().lights,
    }
    local view = assert(s:prepare { size = { 151, 120 }, samples = 1, visibility = "none" })
    assert(view.stats.points > 256 * 64)
    for _, cells in ipairs { { 1, 1, 1 }, { 5, 1, 6 }, { 90, 1, 80 } } do
      local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { { -1, -0.1, -1 }, { 1, 0.1, 1 } }, cells = cells, lmax = 4,
        metric_channels = "none" }, s.lights))
      for _, interpolation in ipairs { "hermite", "taylor", "linear" } do
        compare(view, { grid = grid, interpolation = interpolation })
      end
    end
  end)

  it("have all layers of the CPU's images", function()
    local s = scene()
    local o = { grid = assert(s:bake()), size = { 20, 15 }, samples = 2, transfer_samples = 16 }
    local here = assert(s:render(o))
    o.truth, o.device = here, gpu
    local there, report = assert(s:render(o))
    for _, name in ipairs { "normal", "position", "albedo", "coverage", "emitter", "level" } do
      assert.equal(0, (core.array_distance(here:layer(name), there:layer(name))))
    end
    local worst = core.array_distance(there:layer "true_error", ylm.zeros({ 15, 20, 3 }, "float"))
    assert(worst < 1e-3 and report.seconds.light > 0 and there.metadata.method == "grid")
    assert.equal(here.metadata.grid, there.metadata.grid)
    assert.equal(gpu.name, there.metadata.device)
    o.layers, o.truth = false, nil
    local view = assert(s:prepare { size = o.size, samples = 2, transfer_samples = 16, visibility = "transfer" })
    local again = ylm.image { size = o.size }
    assert.equal(again, (assert(view:render { grid = o.grid, device = gpu, layers = false, out = again })))
    same(here:layer(), again:layer())
  end)

  it("stay on the device if asked for, in arrays that are written again", function()
    local s = scene()
    local grid = assert(s:bake())
    local view = assert(s:prepare { size = { 50, 40 }, samples = 3, transfer_samples = 16, visibility = "transfer" })
    local here = assert(view:render { grid = grid, layers = false, lamps = flying })
    local o = { grid = grid, device = gpu, download = false, lamps = flying }
    local picture, report = assert(view:render(o))
    assert.same({ 40, 50, 3 }, picture.shape)
    assert(report.seconds.light > 0 and report.stages.download == nil)
    same(here:layer(), picture:download())
    o.out, o.lamps = picture, nil
    local before = gpu.stats
    assert.equal(picture, (view:render(o)))
    local after = gpu.stats
    assert.equal(before.uploaded, after.uploaded)
    assert(after.downloaded - before.downloaded <= 12) -- counts
    same(assert(view:render { grid = grid, layers = false }):layer(), picture:download())
  end)

  it("come back alone: a frame's bytes are its lamps and its pixels", function()
    local s = scene()
    local grid = assert(s:bake())
    local view = assert(s:prepare { size = { 64, 48 }, samples = 4, transfer_samples = 16, visibility = "transfer" })
    local o = { grid = grid, device = gpu, layers = false, lamps = flying }
    assert(view:render(o))
    local before, _, report = gpu.stats, assert(view:render(o))
    local after = gpu.stats
    assert(view.stats.points > 64 * 48 / 4)
    assert(after.downloaded - before.downloaded <= 64 * 48 * 12 + 12, after.downloaded - before.downloaded)
    -- at most every disc of 96 bytes, in every tile of 8 x 8 pixels with 4 bytes each, and the tiles
    assert(after.uploaded - before.uploaded <= 7 * 96 + 8 * 6 * (7 * 4 + 16), after.uploaded - before.uploaded)
    assert(report.stages.upload.seconds >= 0)
  end)

  it("are frames whose lights move: lights and cells go up, the grid's rows and the picture come down", function()
    local s = scene()
    local view = assert(s:prepare { size = { 64, 48 }, samples = 2, visibility = "none", lmax = 4 })
    local at = {}
    for i = 1, 200 do at[i] = { math.sin(i), 0.2 + i / 200, math.cos(i) } end
    local bounds = { { -1.1, -0.1, -1.1 }, { 1.1, 1.1, 1.1 } }
    local points = view:points().position
    for _, form in ipairs { ylm.uniform_grid { bounds = bounds, cells = 7, lmax = 4, metric_channels = "none" },
      ylm.adaptive_grid { bounds = bounds, lmax = 4, depth = 3, threshold = 2 } } do
      local occupied = form.threshold and points or nil
      for frame = 1, 2 do
        at[1] = { 0.3 * frame, 0.5, 0.2 }
        local lamps = ylm.sphere_lights { at = at, radius = 0.02, radiance = { 1, 2, 3 } }
        local before = gpu.stats
        local grid = assert(ylm.bake(form, lamps, { occupied = occupied, device = gpu }))
        local there = assert(view:render { grid = grid, device = gpu, layers = false })
        local after, grid_bytes = gpu.stats, grid:to(gpu).bytes
        local up, down = after.uploaded - before.uploaded, after.downloaded - before.downloaded
        if frame == 2 then
          local cells = grid.stats.cells
          -- 64 bytes a light at most, 64 a cell, 12 a shading point that occupies; counts and the like
          assert(up <= 200 * 64 + 100 * cells + (occupied and 12 * #points or 0) + 8192, up)
          -- rows, 64 bytes a voxel and 20 a point beside, the picture
          assert(down <= 64 * 48 * 12 + 1.1 * grid_bytes + 65536, down)
          assert(grid_bytes > 4 * up, grid_bytes)
          same(assert(view:render { grid = ylm.bake(form, lamps, { occupied = occupied }), layers = false }):layer(),
            there:layer())
        end
      end
    end
  end)

  it("have the host answer where the grid has nothing", function()
    local own, s = support.open { validate = true, staging = true }, scene()
    local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { { -1.1, -0.1, -1.1 }, { 1.1, 1.1, 1.1 } }, cells = 6, lmax = 2 },
      s.lights, { occupied = { { -0.9, 0, -0.9 }, { 0.4, 0.1, 0.3 } } }))
    local view = assert(s:prepare { size = { 40, 30 }, samples = 2, transfer_samples = 16, visibility = "transfer", lmax = 3 })
    local _, report = compare(view, { grid = grid, lamps = flying }, nil, own)
    assert(report.unbaked > 100, report.unbaked)
    support.close_silent(own)
  end)

  it("are filtered by the host where the device has no room for them", function()
    local own, s = support.open { validate = true }, scene()
    local grid = assert(s:bake())
    local view = assert(s:prepare { size = { 80, 60 }, samples = 2, transfer_samples = 16, visibility = "transfer" })
    local n = view.stats.points
    grid:to(own)
    -- room for points, transfer vectors, albedo, and what a pass needs; not for 20 bytes a pixel
    binding.gpu_shrink(own, own.stats.bytes + n * (3 + 16 + 3) * 4 + 40 * n + 16384, 0, 0, false)
    local nothing, message, code = view:render { grid = grid, device = own, download = false }
    assert(nothing == nil and code == "ENOMEM" and message:find("memory", 1, true), tostring(message))
    local _, report = compare(view, { grid = grid, lamps = flying }, nil, own)
    assert(report.stages.filter == nil)
    support.close_silent(own)
  end)

  it("can be cancelled, and refuse arrays that do not fit", function()
    local own, s = support.open { validate = true }, scene()
    local grid = assert(s:bake())
    local view = assert(s:prepare { size = { 30, 20 }, samples = 1, transfer_samples = 16, visibility = "transfer" })
    local o = { grid = grid, device = own, layers = false, progress = function() return false end }
    local image, message, code = view:render(o)
    assert(image == nil and message == "cancelled" and code == "ECANCELLED")
    local stages = {}
    o.progress = function(_, _, stage) stages[stage] = true end
    assert(view:render(o))
    assert(stages.filter, "progress")
    o.progress = function() view:render { grid = grid, device = own, layers = false } end
    local ok
    ok, message = pcall(view.render, view, o)
    assert(not ok and message:find("in use", 1, true), tostring(message))
    local function refused(says, options)
      ok, message = pcall(view.render, view, options)
      assert(not ok and message:find(says, 1, true), tostring(message))
    end
    refused("name the device", { grid = grid, download = false })
    for _, d in ipairs { false, own } do
      local disk = ylm.disk_light { at = { 0, 1, 0 }, normal = { 0, 1, 0 }, radius = 1 }
      refused("lamps: sphere lights expected", { grid = grid, device = d or nil, layers = false,
        lamps = { ylm.sphere_light { at = { 0, 1, 0 } }, disk } })
    end
    refused("out", { grid = grid, device = own, out = own:array { 1 } })
    refused("must be a float array of 20x30x3", { grid = grid, device = own, download = false, out = own:array { 1 } })
    refused("a gpu_array expected", { grid = grid, device = own, download = false, out = ylm.zeros { 20, 30, 3 } })
    refused("truth needs an image on the host", { grid = grid, device = own, download = false,
      truth = view:render { grid = grid } })
    binding.gpu_lose(own)
    image, message, code = view:render { grid = grid, device = own, download = false }
    assert(image == nil and code == "EDEVICE" and message:find("was lost", 1, true))
    support.close_silent(own)
  end)

  it("refuse entries out of order and points that there are not", function()
    local function entries(first, point)
      return { first = ylm.array(first, "double"), shown = ylm.zeros({ 2, 4 }, "float"), weight = ylm.zeros({ 2 }, "float"),
        depth = ylm.zeros({ 2 }, "float"), camera = ylm.zeros({ 10 }, "double"),
        point = point and ylm.array(point, "double"), part = point and ylm.zeros({ 2, 3 }, "float") }
    end
    local function refused(says, code_, points, e)
      local picture, message, code = binding.gpu_picture_create(gpu, 2, 1, points, e)
      assert(picture == nil and code == code_ and message:find(says, 1, true), tostring(message))
    end
    assert(binding.gpu_picture_create(gpu, 2, 1, 2, entries { 0, 1, 2 }))
    refused("number 2 is 0", "EINVAL", 2, entries { 0, 2, 0 })
    refused("number 1 is 3", "EINVAL", 2, entries { 0, 3, 2 })
    refused("number 0 is -1", "EINVAL", 2, entries { -1, 1, 2 })
    refused("number 1 is ", "EINVAL", 2, entries { 0, 0 / 0, 2 })
    refused("have 1 entries", "EINVAL", 2, entries { 0, 1, 1 })
    refused("points", "ESHAPE", 1, entries { 0, 1, 2 })
    refused("number 4 is 7", "EINVAL", 7, entries({ 0, 1, 2 }, { { 0, 1, 2 }, { 3, 7, 6 } }))
  end)
end)
