-- Ambient occlusion: option ambient of pictures.
local ylm = require "ylm"

local lamp = ylm.sphere_light { at = { 1, 50, 20 }, radius = 1, radiance = { 3000, 2000, 1000 } }
local floor = ylm.quad { corner = { 0, 0, 20 }, u = { 40, 0, 0 }, v = { 0, 0, -40 } }
local wall = ylm.quad { corner = { 0, 0, 20 }, u = { 0, 0, -40 }, v = { 0, 40, 0 } }
local view = { size = { 48, 36 }, samples = 1, light_samples = 1, bounces = 0 }

local function with(more)
  local out = {}
  for k, x in pairs(view) do out[k] = x end
  for k, x in pairs(more) do out[k] = x end
  return out
end

local function scene(geometry, name)
  return ylm.scene(name or "ambient") { camera = ylm.camera { from = { 4, 4, 6 }, at = { 0.6, 0, 0 }, fov = 30 },
    geometry = geometry,
    lights = lamp }
end

local corner = scene({ floor, wall }, "corner")

--- Mean and root mean square of the layer ambient less its closed form, where that is below 1. Of even light, a wall at the
-- distance d from a point keeps what passes the segment of the unit disc beyond c = d/radius: (acos c - c sqrt(1 - c^2)) / pi.
local function errors(image, radius)
  local a, place, normal = image:layer "ambient":totable(), image:layer "position":totable(), image:layer "normal":totable()
  local sum, squares, n = 0, 0, 0
  for y, row in ipairs(place) do
    for x, p in ipairs(row) do
      local c = math.max(0, normal[y][x][2] > 0.5 and p[1] or p[2]) / radius
      if c < 1 then
        local d = a[y][x][1] - 1 + (math.acos(c) - c * math.sqrt(1 - c * c)) / math.pi
        sum, squares, n = sum + d, squares + d * d, n + 1
      end
    end
  end
  assert.is_true(n > 100)
  return sum / n, math.sqrt(squares / n)
end

local function same(a, b, layer)
  local x, y = a:layer(layer):totable(), b:layer(layer):totable()
  for j = 1, #x do
    for i = 1, #x[1] do
      for c = 1, #x[1][1] do if x[j][i][c] ~= y[j][i][c] then return false end end
    end
  end
  return true
end

describe("ambient", function()
  local before
  before_each(function() before = ylm.on_warning(false) end)
  after_each(function() ylm.on_warning(before) end)

  it("is 1 on a plane, to the last bit", function()
    for _, how in ipairs { "ssao", "rays" } do
      local image = scene(floor):render(with { ambient = how, ambient_radius = 2, samples = 4 })
      for _, row in ipairs(image:layer "ambient":totable()) do
        for _, v in ipairs(row) do assert.equal(1, v[1]) end
      end
    end
  end)

  it("has the closed form in a corner: by rays within their noise, by the picture within a tenth", function()
    local mean, rms = errors(corner:render(with { ambient = "rays", ambient_radius = 1.5 }), 1.5)
    assert.is_true(math.abs(mean) < 0.002 and rms < 0.015, mean .. " " .. rms)
    mean, rms = errors(corner:render(with { ambient = "ssao", ambient_radius = 1.5 }), 1.5)
    assert.is_true(math.abs(mean) < 0.06 and rms < 0.1, mean .. " " .. rms)
  end)

  it("multiplies the radiance of surfaces, of a picture by rays and by a grid, and not that of lamps", function()
    local lit = ylm.scene "lamp in sight" { camera = corner.camera, geometry = { floor, wall }, background = { 0.25, 0.5, 1 },
      lights = { lamp, ylm.sphere_light { at = { 0.8, 0.5, 0 }, radius = 0.2, radiance = 7 } } }
    local grid = lit:bake { probes = ylm.uniform_grid { cells = 2, lmax = 1 }, quantity = "lights", occupied = "everywhere" }
    local seen = { size = view.size, samples = 1, lmax = 1 }
    local byrays = lit:prepare(seen)
    seen.visibility = "none"
    local bygrid = lit:prepare(seen)
    for _, case in ipairs { { byrays, { light_samples = 4 } }, { bygrid, { grid = grid } } } do
      local plain = case[1]:render(case[2])
      case[2].ambient, case[2].ambient_radius = "ssao", 1
      local dark = case[1]:render(case[2])
      local a, p, q = dark:layer "ambient":totable(), plain:layer():totable(), dark:layer():totable()
      local darker, lamps = 0, 0
      for y, row in ipairs(p) do
        for x, v in ipairs(row) do
          local factor = a[y][x][1]
          if v[1] == 7 then factor, lamps = 1, lamps + 1 end
          if factor < 0.9 then darker = darker + 1 end
          for c = 1, 3 do assert.near(v[c] * factor, q[y][x][c], 1e-6 * math.max(1, v[c])) end
        end
      end
      assert.is_true(darker > 20 and lamps > 5)
    end
  end)

  it("is the same by any number of threads", function()
    for _, how in ipairs { "ssao", "rays" } do
      local first = corner:render(with { ambient = how, threads = 1, samples = 2 })
      for _, threads in ipairs { 2, 7 } do
        local other = corner:render(with { ambient = how, threads = threads, samples = 2 })
        assert.is_true(same(first, other, "ambient") and same(first, other, "radiance"))
      end
    end
  end)

  it("says that it is not the scene's light, and how it was made", function()
    local image, report = corner:render(with { ambient = "ssao" })
    assert.equal("ssao", report.ambient.method)
    assert.is_true(report.ambient.radius > 1 and report.seconds.ambient > 0 and report.seconds.total > report.seconds.ambient)
    assert.matches('ambient = "ssao" darkens surfaces by what is within .* that is not the scene\'s light', report.warnings[1])
    assert.equal("ssao", image.metadata.ambient)
    local plain, none = corner:render(view)
    assert.is_nil(none.ambient)
    assert.is_false(pcall(plain.layer, plain, "ambient"))
  end)

  it("sees nothing where the radius is below a pixel", function()
    for _, row in ipairs(corner:render(with { ambient = "ssao", ambient_radius = 1e-3 }):layer "ambient":totable()) do
      for _, v in ipairs(row) do assert.equal(1, v[1]) end
    end
  end)

  it("is cancelled", function()
    local image, _, code = corner:render(with { ambient = "rays", progress = function(_, _,
      stage) return stage ~= "ambient" end })
    assert.is_nil(image)
    assert.equal("ECANCELLED", code)
  end)

  it("refuses a radius alone, vertices, a tolerance, and what is no radius", function()
    assert.has_error(function() corner:render(with { ambient_radius = 1 }) end,
      "render: ambient_radius is for ambient = 'ssao' or 'rays': name one, or leave it out")
    assert.has_error(function() corner:render(with { ambient = "ssao", shading = "vertices" }) end,
      "render: ambient is of what camera rays hit: shading = 'pixel' in scene:prepare")
    assert.has_error(function() corner:render { ambient = "ssao", tolerance = 0.1, bounces = 0 } end,
      "render: tolerance is of the scene's light, which ambient is not: leave one out")
    for _, radius in ipairs { 0, -1, 0 / 0 } do
      local ok, message = pcall(corner.render, corner, with { ambient = "ssao", ambient_radius = radius })
      assert.is_false(ok)
      assert.matches("ambient_radius must be a number > 0", message)
    end
    assert.matches("ambient must be one of 'ssao', 'rays', got 'hbao'",
      select(2, pcall(corner.render, corner, with { ambient = "hbao" })))
    assert.is_truthy(corner:render(with { ambient = "rays", ambient_radius = math.huge }))
    assert.is_truthy(corner:render(with { ambient = "ssao", ambient_radius = math.huge }))
  end)
end)
