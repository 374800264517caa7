-- Virtual lights without shadows say how much of their light passes walls.

local ylm = require "ylm"

describe("virtual lights without shadows", function()
  --- The report of a picture of a room, with a wall between camera and lamp or without, and what was said.
  local function render(wall, shadows)
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    local white = ylm.matte { albedo = 0.7 }
    local scene = ylm.scene "Two halves" {
      camera = ylm.camera { from = { -0.9, 0, 0.1 }, at = { 0, 0, 0 }, fov = 90 },
      geometry = { ylm.box { scale = 2, material = white },
        wall and ylm.quad { corner = { 0.1, -1, -1 }, u = { 0, 2, 0 }, v = { 0, 0, 2 }, material = white } or nil },
      lights = ylm.sphere_light { at = { 0.7, 0, 0 }, radius = 0.1, radiance = 30 },
    }
    local _, report = assert(scene:render { size = { 16, 9 }, samples = 1, light_samples = 1,
      bounced = (scene:virtual_lights { count = 200 }), virtual = { shadows = shadows } })
    ylm.on_warning(before)
    return report, said
  end

  it("say which part of their light passes walls", function()
    local report, said = render(true)
    assert(report.passing > 0.95, report.passing)
    assert(#said == 1 and said[1]:find "virtual lights shine through walls: %d+ %% of their light here passes them", said[1])
    local open = render(false)
    assert(open.passing < 0.02, open.passing)
    assert.is_nil(render(true, "centre").passing)
  end)
end)

describe("report.glossy.noise", function()
  it("says what it is of", function()
    local scene = ylm.scene "A ball" {
      camera = ylm.camera { from = { 0, 1, 4 } },
      geometry = ylm.sphere { divide = 8, material = ylm.ggx { alpha = 0.2 } },
      lights = ylm.sphere_light { at = { 3, 4, 3 }, radius = 1, radiance = 30 },
    }
    local grid = scene:bake { probes = ylm.uniform_grid { cells = 2, lmax = 2 } }
    local _, report = assert(scene:render { grid = grid, visibility = "none", size = { 8, 8 }, samples = 1, gloss = "rays" })
    assert(report.glossy.noise and report.glossy.noise_of:find "^the mesh that has most", report.glossy.noise_of)
  end)
end)
