-- Scenes rendered with a grid on a device, against the processor. On Mesa's lavapipe, where there is no other device.

local ylm = require "ylm"
local device = require "spec.support.gpu"
local floor = require "spec.support.floor_scene"

describe("ylm.vulkan", function()
  local open = device.each()
  if not open then return end
  local binding = require "ylm.c.vulkan"

  describe("scene:render", function()
    if not pcall(require, "ylm.c.scene") then return end

    local function scene(channels) return floor { channels = channels } end

    it("gives the CPU's image, for rgb and luminance grids, of all interpolations", function()
      local gpu = open()
      for _, channels in ipairs { "rgb", "luminance" } do
        local s = scene(channels)
        local grid = assert(s:bake())
        local o = { grid = grid, size = { 40, 30 }, samples = 1 }
        for _, interpolation in ipairs { "hermite", "linear" } do
          o.interpolation, o.device = interpolation, nil
          local image, report = s:render(o)
          o.device = gpu
          local there, other = assert(s:render(o))
          local a, b = image:layer(), there:layer()
          local n, largest, most = 40 * 30 * 3, 0, 0
          local x, y = a:reshape({ n }):totable(), b:reshape({ n }):totable()
          for i = 1, n do
            largest, most = math.max(largest, math.abs(x[i])), math.max(most, math.abs(x[i] - y[i]))
          end
          assert(largest > 0.1 and most <= 1e-5 * largest, most / largest)
          assert.equal(report.outside, other.outside)
          assert.equal(report.unbaked, other.unbaked)
          assert(other.stages.shade.seconds > 0)
        end
      end
    end)

    it("is refused far from the origin", function()
      local gpu, o = open(), 5e6
      local s = ylm.scene "far" { geometry = ylm.quad { corner = { o, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } },
        camera = ylm.camera { from = { o + 0.5, 2, -0.5 }, at = { o + 0.5, 0, -0.5 }, up = { 1, 0, 0 } } }
      local grid = assert(ylm.bake(
        ylm.uniform_grid { lmax = 2, cells = { 2, 2, 2 }, bounds = { { o, -1, -2 }, { o + 2, 1, 0 } } },
        ylm.sphere_light { at = { o, 2, 0 }, radiance = 1 }))
      local ok, image, message = pcall(s.render, s, { grid = grid, size = { 8, 8 }, samples = 1, device = gpu })
      assert.matches("the scene lies far from the origin", tostring(ok and message or image))
    end)

    it("keeps a view's points on the device between frames", function()
      local gpu, s = open(), scene "rgb"
      local grid, view = assert(s:bake()), assert(s:prepare { size = { 40, 30 }, samples = 1, visibility = "transfer" })
      grid:to(gpu)
      local o = { grid = grid, device = gpu, layers = false }
      local first = assert(view:render(o))
      local before = gpu.stats.uploaded
      local image, report = assert(view:render(o))
      assert.equal(before, gpu.stats.uploaded)
      assert(report.stages.upload == nil and report.stages.sort.seconds >= 0)
      assert.equal(0, (select(2, require "ylm.c.core".array_distance(image:layer(), first:layer()))))
    end)

    it("refuses fields that are no grid, and passes a lost device on", function()
      local gpu, s = open(), scene "rgb"
      local lamp = ylm.sphere_light { at = { 0, 1, 0 } }
      local ok, message = pcall(s.render, s, { grid = lamp, device = gpu, size = { 8, 8 }, samples = 1 })
      assert(not ok and message:find("grid must be a grid", 1, true), tostring(message))
      local dark = function(points)
        return ylm.zeros({ #points, 3, 1 }, "double"), ylm.zeros({ #points, 3, 1, 3 }, "double")
      end
      local direct = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 0,
        metric_channels = "none" }, dark, { quantity = "direct" })
      local view = s:prepare { size = { 8, 8 }, samples = 1 }
      for says, call in pairs {
        ['device is for by = "grid"'] = function()
          s:render { device = gpu, size = { 8, 8 }, samples = 1, bounces = 0 }
        end,
        ['device is for by = "grid", and this picture is by = "rays"'] = function() view:render { device = gpu } end,
        ['device: it shades grids of lights by transfer vectors, this one holds "direct": leave device out'] = function()
          s:render { grid = direct, device = gpu, size = { 8, 8 }, samples = 1 }
        end,
      } do
        ok, message = pcall(call)
        assert(not ok and message:find(says, 1, true), tostring(message))
      end
      local grid = assert(s:bake())
      binding.gpu_lose(gpu)
      local image, code
      image, message, code = s:render { grid = grid, device = gpu, size = { 8, 8 }, samples = 1 }
      assert(image == nil and code == "EDEVICE" and message:find("was lost", 1, true))
    end)
  end)
end)
