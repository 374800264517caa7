-- Glossy surfaces under every kind of light field, by harmonics, against paths of one reflection.
local ylm = require "ylm"
local ways = require "spec.support.ways"

local SIZE, LMAX = { 16, 16 }, 8

--- A ball under lights.
local function ball(lights)
  return ylm.scene "ball" { camera = ylm.camera { from = { 0, 0.5, 4 }, at = { 0, 0, 0 }, fov = 30 }, lights = lights,
    geometry = { ylm.sphere { material = ylm.ggx { alpha = 0.5, f0 = { 1, 0.8, 0.3 }, base = 0.02 } } } }
end

--- sqrt(mean((a - b)^2 - variance of b)) over the root mean square of b, where the ball is seen.
local function error_of(a, b)
  local x, y, v = a:layer "radiance":totable(), b:layer "radiance":totable(), b:layer "variance":totable()
  local seen, d, n = a:layer "coverage":totable(), 0, 0
  for i, row in ipairs(y) do
    for k, p in ipairs(row) do
      for c = 1, seen[i][k][1] == 1 and 3 or 0 do
        d, n = d + (x[i][k][c] - p[c]) ^ 2 - v[i][k][c], n + p[c] ^ 2
      end
    end
  end
  return math.sqrt(math.max(0, d) / n)
end

local function square(at, half)
  return { { at[1] - half, at[2], at[3] - half }, { at[1] + half, at[2], at[3] - half }, { at[1] + half, at[2], at[3] + half },
    { at[1] - half, at[2], at[3] + half } }
end

local function stripes()
  local image = ylm.image { size = { 8, 8 }, layers = { { "radiance", 3 } } }
  for x = 1, 8 do image:fill(x, 1, 1, 8, { 4 + 3 * (x % 2), 5, 9 - x }) end
  return image
end

local sphere = ylm.sphere_light { at = { 2, 3, 3 }, radius = 1, radiance = { 6, 5, 4 } }
local sun = ylm.sun_light { direction = { 1, 2, 2 }, irradiance = 3, angle = 30 }
local few = { 1, 0.2, 0.6, -0.3, 0.1, 0.05, -0.1, 0.05, 0.1 }
for k = #few + 1, (LMAX + 1) ^ 2 do few[k] = 0 end
local sky = ylm.environment_light { coefficients = few }
local fields = {
  { "a sphere", { sphere } }, { "a polygon", { ylm.polygon_light { vertices = square({ 1, 4, 2 }, 1), radiance = 6 } } },
  { "a disk", { ylm.disk_light { at = { -1, 3, 3 }, normal = { 0.3, -1, -0.8 }, radius = 1.2, radiance = { 3, 4, 6 } } } },
  { "a textured light", { ylm.textured_light { image = stripes(), corner = { 0, 4, 3 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } } },
  { "a sun", { sun } }, { "a sky", { sky } }, { "their sum", { sphere, sun, sky } },
}

describe("glossy surfaces, by harmonics", function()
  for _, case in ipairs(fields) do
    it("are those of paths under " .. case[1], function()
      local s = ball(case[2])
      local truth = s:pathtrace { size = SIZE, samples = 512, reflections = { 1, 1 }, layers = false }
      local image, report = s:render { by = "sum", size = SIZE, samples = 64, lmax = LMAX, visibility = "none", gloss = "sh" }
      local error, missed = error_of(image, truth), report.glossy.missed
      assert.is_true(error < missed + 0.01, ("%.4f, slices miss %.4f"):format(error, missed))
    end)
  end

  it("are those of exact coefficients under uniform and adaptive grids", function()
    local s = ball(fields[7][2])
    local o = { size = SIZE, samples = 4, lmax = LMAX, visibility = "none", gloss = "sh" }
    local exact = s:render(ways.sum(o))
    local bounds = { { -1.1, -1.1, -1.1 }, { 1.1, 1.1, 1.1 } }
    exact:add("variance", 3)
    for _, probes in ipairs { ylm.uniform_grid { bounds = bounds, cells = 6, lmax = LMAX },
      ylm.adaptive_grid { bounds = bounds, lmax = LMAX, depth = 4, tolerance = 0.02 } } do
      o.grid = s:bake { probes = probes, quantity = "lights" }
      assert.is_true(error_of(s:render(o), exact) < 0.01)
    end
  end)
end)
