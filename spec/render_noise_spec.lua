-- How many occlusion rays a transfer vector gets where nobody says: by the noise that they leave.

local with = require "spec.support.with"
local ylm = require "ylm"
local ways = require "spec.support.ways"

if not pcall(require, "ylm.c.scene") then
  describe("noise", function() it("is measured", function() pending "scenes are not built in" end) end)
  return
end

local small = { size = { 64, 48 }, samples = 1, share = 0, lmax = 4, occlusion_distance = math.huge,
  visibility = "transfer" }

--- A plate over a floor, in a beam: half of the picture is in its half-shadow.
local function shaded(lights)
  return ylm.scene "plate" {
    camera = ylm.camera { from = { 0, 4, 0.01 }, at = { 0, 0, 0 }, fov = 40 },
    geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
      ylm.quad { corner = { -0.2, 0.5, 0.6 }, u = { 2, 0, 0 }, v = { 0, 0, -1.2 } } },
    lights = lights or { ylm.sphere_light { at = { 2.5, 2, 0 }, radius = 0.1, radiance = 50 } },
  }
end

local function open_floor()
  return ylm.scene "open" {
    camera = ylm.camera { from = { 0, 4, 0.01 }, at = { 0, 0, 0 }, fov = 40 },
    geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
    lights = { ylm.sphere_light { at = { 2.5, 2, 0 }, radius = 0.1, radiance = 50 } },
  }
end

--- Luminance of the shading points.
local function luminances(s, options)
  local view = assert(s:prepare(with(small, options)))
  local L = ylm.light_field(4, s.lights, view:points().position, { channels = "luminance" }):totable()
  local out = {}
  for i, T in ipairs(view:transfer():totable()) do
    out[i] = 0
    for k = 1, #T do out[i] = out[i] + T[k] * L[i][1][k] end
  end
  return out, view.stats
end

--- The deviation that docs promise, against far more rays.
local function deviation(got, truth)
  local mean, sum = 0, 0
  for i = 1, #truth do mean = mean + math.abs(truth[i]) / #truth end
  for i = 1, #truth do sum = sum + ((got[i] - truth[i]) / (math.abs(truth[i]) + mean / 10)) ^ 2 end
  return math.sqrt(sum / #truth)
end

describe("occlusion rays", function()
  it("are doubled until the noise is at most 2 %, which the report says", function()
    local s = shaded()
    local _, report = assert(s:render(ways.sum(with(small, { layers = false }))))
    assert.is_true(report.transfer_samples > 128, tostring(report.transfer_samples))
    assert.is_true(report.noise > 0 and report.noise <= 0.02, tostring(report.noise))
    local truth = luminances(s, { transfer_samples = 2048 })
    local chosen, stats = luminances(s, {})
    assert.equal(report.transfer_samples, stats.transfer_samples)
    local few, many = deviation(luminances(s, { transfer_samples = 128 }), truth), deviation(chosen, truth)
    assert.is_true(few > 0.02, tostring(few))
    assert.is_true(many < 0.03 and many < 2 * stats.noise and many > stats.noise / 2, ("%g, measured %g"):format(many,
      stats.noise))
  end)

  it("are 128 where these are enough", function()
    local view = assert(open_floor():prepare(small))
    assert.equal(128, view.stats.transfer_samples)
    assert.equal(0, view.stats.noise)
    assert.equal(128, view.options.transfer_samples)
  end)

  it("are as many as somebody asks for; then, without lights or visibility no noise is measured", function()
    local given = assert(shaded():prepare(with(small, { transfer_samples = 77, visibility = "transfer" })))
    assert.equal(77, given.stats.transfer_samples)
    assert.is_nil(given.stats.noise)
    assert.equal(given.stats.points * 77, given.stats.occlusion_rays)
    local dark = assert(shaded({}):prepare(small))
    assert.equal(128, dark.stats.transfer_samples)
    assert.is_nil(dark.stats.noise)
    local free = assert(shaded():prepare(with(small, { visibility = "none" })))
    assert.is_nil(free.stats.noise)
    assert.is_nil(free.stats.transfer_samples)
  end)

  it("that leave more noise than they are chosen for are warned of, with a number that is enough or the way without", function()
    --- A floor that sees the lamp through a slit `wide`.
    local function slit(wide)
      return ylm.scene "slit" {
        camera = ylm.camera { from = { 0, 0.9, 0.01 }, at = { 0, 0, 0 }, fov = 60 },
        geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
          ylm.quad { corner = { -9, 1, 9 }, u = { 9 - wide / 2, 0, 0 }, v = { 0, 0, -18 } },
          ylm.quad { corner = { wide / 2, 1, 9 }, u = { 9 - wide / 2, 0, 0 }, v = { 0, 0, -18 } } },
        lights = { ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.1, radiance = 50 } },
      }
    end
    local function warned(wide)
      local _, report = assert(slit(wide):render(ways.sum(with(small, { lmax = 2, layers = false }))))
      return table.concat(report.warnings, "\n"), report.noise
    end
    assert.is_truthy(warned(0.1):find "2048 occlusion rays from each shading point leave a noise of %d+%.%d %%, more than 2 %%: "
      and warned(0.1):find "set transfer_samples = %d+")
    assert.is_truthy(warned(0.02):find 'too little of the sky is seen for such rays, use by = "rays"')
    local clear, noise = warned(4)
    assert.is_true(noise <= 0.02 and not clear:find "noise", clear)
  end)

  it("are the same whatever the number of threads", function()
    local function noise(threads) return assert(shaded():prepare(with(small, { threads = threads }))).stats.noise end
    assert.equal(noise(1), noise(2))
  end)
end)
