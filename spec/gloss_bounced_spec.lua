-- Light that bounces, met by glossy surfaces: rays that their materials choose, into the elements of a transfer.
local long = require "spec.support.long"
local ylm = require "ylm"

local pi = math.pi

local function with(more, base)
  local o = {}
  for k, v in pairs(base) do o[k] = v end
  for k, v in pairs(more) do o[k] = v end
  return o
end

local function radiance(image) return image:layer "radiance":totable() end

--- The mean over pixels, [3].
local function mean(image)
  local sum, n = { 0, 0, 0 }, 0
  for _, row in ipairs(radiance(image)) do
    for _, p in ipairs(row) do
      n = n + 1
      for c = 1, 3 do sum[c] = sum[c] + p[c] end
    end
  end
  return { sum[1] / n, sum[2] / n, sum[3] / n }
end

--- How many numbers of two pictures differ.
local function different(a, b)
  local x, y, n = radiance(a), radiance(b), 0
  for i, row in ipairs(x) do
    for k, p in ipairs(row) do
      for c = 1, 3 do if p[c] ~= y[i][k][c] then n = n + 1 end end
    end
  end
  return n
end

--- sqrt(mean((a - b)^2 - variance of b)) over the root mean square of b, of layers "radiance".
local function error_of(a, b)
  local x, y, v, d, n = radiance(a), radiance(b), b:layer "variance":totable(), 0, 0
  for i, row in ipairs(y) do
    for k, p in ipairs(row) do
      for c = 1, 3 do d, n = d + (x[i][k][c] - p[c]) ^ 2 - v[i][k][c], n + p[c] ^ 2 end
    end
  end
  return math.sqrt(math.max(0, d) / n)
end

-- A round room with a lamp in its middle: all of its wall sends RADIANCE.
local RHO, LAMP, SMALL = 0.5, 0.1, 1e-3
local SENT = RHO / pi * (pi * 10 * LAMP ^ 2) / (1 - RHO)

--- A small square in it that is seen at `degrees` from its normal.
local function globe(material, degrees, more)
  local t, x = math.rad(degrees), { 0.2, 0, -0.5 }
  local geometry = { ylm.sphere { radius = 1, divide = { 64, 32 }, material = ylm.matte { albedo = RHO } },
    ylm.quad(with({ corner = { x[1] - SMALL, -SMALL, x[3] }, u = { 2 * SMALL, 0, 0 }, v = { 0, 2 * SMALL, 0 },
      material = material }, more or {})) }
  return ylm.scene "globe" {
    geometry = geometry, lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = LAMP, radiance = 10 },
    links = ylm.links { spacing = 0.2, rays = 64 },
    camera = ylm.camera { from = { x[1] + 0.2 * math.sin(t), 0, x[3] + 0.2 * math.cos(t) }, at = x, fov = 0.1 },
  }
end

local few = { size = { 8, 8 }, samples = 1, rays = 64 }

--- Light that bounces alone, [3].
local function bounced(scene, o)
  local all = mean((scene:render(with({ bounces = "all" }, o))))
  local direct = mean((scene:render { size = o.size, samples = o.samples, bounces = 0 }))
  return { all[1] - direct[1], all[2] - direct[2], all[3] - direct[3] }
end

local ggx = ylm.ggx { alpha = 0.3, f0 = 0.7, base = 0.1 }

local few_points = { size = { 16, 9 }, samples = 1, rays = 16 }
local function of(t) return with({ links = t }, few_points) end

--- A room with coloured walls and a body, what bounces in it, and a prepared view of 16 x 9 points.
local function room(material)
  local scene = ylm.scene "room" {
    camera = ylm.camera { from = { 0, 1.2, 2.8 }, at = { 0, 0.3, 0 }, fov = 45 },
    geometry = { ylm.box { bounds = { { -1.5, 0, -1.5 }, { 1.5, 2, 3 } }, material = ylm.matte { albedo = { 0.6, 0.6, 0.7 } } },
      ylm.quad { corner = { -1.4, 0.01, 1.4 }, u = { 2.8, 0, 0 }, v = { 0, 0, -2.8 }, divide = 12,
        material = material, sides = "front" },
      ylm.quad { corner = { -1.49, 0.02, 1.4 }, u = { 0, 0, -2.8 }, v = { 0, 1.9, 0 },
        material = ylm.matte { albedo = { 0.7, 0.1, 0.1 } } },
    },
    lights = { ylm.sphere_light { at = { 0.3, 1.6, 0.3 }, radius = 0.2, radiance = { 15, 14, 12 } } },
  }
  local lit = scene:links({ spacing = 0.15, rays = 64 }):radiosity()
  return scene, lit, scene:prepare(of(lit.links))
end

describe("bounced light on glossy surfaces", function()
  it("is the reflectance towards the camera where it comes from everywhere alike", function()
    local cases = {
      { ylm.ggx { alpha = 0.1, f0 = { 1, 0.78, 0.34 } }, 50 },
      { ylm.ggx { alpha = 0.5, f0 = 0.04, base = { 0.2, 0.5, 0.7 } }, 30 },
      { ylm.phong { exponent = 30, specular = 0.4, base = 0.3 }, 20 }, { ylm.ggx { alpha = { 0.1, 0.4 }, f0 = 0.7 }, 60 },
      { ylm.abc { fit = "gold-metallic-paint" }, 40 },
    }
    for i, case in ipairs(cases) do
      local t = math.rad(case[2])
      local truth = case[1]:albedo({ math.cos(t) }):totable()[1]
      local got = bounced(globe(case[1], case[2]), few)
      for c = 1, 3 do assert.near(1, got[c] / SENT / truth[c], 0.03, ("case %d, channel %d"):format(i, c)) end
    end
  end)

  it("follows lamps without a ray, as a picture made anew, whatever the number of threads", function()
    local scene, lit, view = room(ggx)
    local first = view:render { bounced = lit }
    local lamps = { ylm.sphere_light { at = { -0.6, 1.6, 0.9 }, radius = 0.1, radiance = { 5, 20, 40 } } }
    lit:update(lamps)
    local image, report = view:render { bounced = lit, threads = 1 }
    assert.is_true(different(first, image) > 0)
    assert.equal(view.stats.points * 16, report.rays.links)
    assert.is_true(report.rays.gloss_links > 0 and report.rays.gloss_links < report.rays.links)
    assert.is_true(report.bounced_noise > 0)
    local again = scene:prepare(of(lit.links))
    for _, threads in ipairs { 2, 7 } do
      assert.equal(0, different(image, (again:render { bounced = lit, threads = threads })))
    end
  end)

  it("changes no bit of what is matte", function()
    local scene, lit = room(ggx)
    local function picture(gloss) return scene:render(with({ bounced = lit, gloss = gloss }, few_points)) end
    local rays, matte = picture(), picture "matte"
    local a, b, n, changed, kept = radiance(rays), radiance(matte), rays:layer "normal":totable(), 0, 0
    for i, row in ipairs(a) do
      for k, p in ipairs(row) do
        local same = p[1] == b[i][k][1] and p[2] == b[i][k][2] and p[3] == b[i][k][3]
        if n[i][k][2] > 0.99 then changed = changed + (same and 0 or 1)
        else
          kept = kept + 1
          assert.is_true(same)
        end
      end
    end
    assert.is_true(changed > 30 and kept > 30)
  end)

  it("agrees with paths", function()
    local scene, lit = room(ylm.ggx { alpha = 0.15, f0 = 0.7 })
    local truth = scene:pathtrace { size = { 16, 9 }, samples = 1024, layers = false, reflections = { 1, "all" } }
    local error = error_of(scene:render { size = { 16, 9 }, samples = 64, light_samples = 64, bounced = lit, rays = 64 }, truth)
    assert.is_true(error < 0.05, tostring(error))
  end)

  it("is that of pixels at vertices, turned as their tangents", function()
    local materials = { ggx }
    for i = 1, long(0, 1) do materials[1 + i] = ylm.ggx { alpha = { 0.2, 0.6 }, f0 = 0.8 } end -- whose table takes seconds
    for _, material in ipairs(materials) do
      local scene, lit = room(material)
      local o = { size = { 16, 9 }, samples = 4, rays = 64, visibility = "none", lmax = 0 }
      local function by(shading)
        local view = scene:prepare(with({ shading = shading, links = lit.links }, o))
        local grid = ylm.sphere_lights { at = { { 0, 9, 0 } }, radius = 0.1, radiance = 0 }.lights
        local image, sum = view:render { grid = grid, bounced = lit }, 0
        for i, row in ipairs(image:layer "normal":totable()) do
          for k, n in ipairs(row) do if n[2] > 0.99 then sum = sum + image:layer "radiance":get(i, k, 1) end end
        end
        return sum
      end
      local vertices, pixels = by "vertices", by "pixel"
      assert.near(1, vertices / pixels, 0.05)
    end
  end)
end)

-- Fields and grids of light that bounces -------------------------------------------------------

--- A round room's picture of `material` by the light `make(lit)`, less what it is without: in parts of RADIANCE, [3]; report.
local function by_field(material, degrees, make, o)
  local scene = globe(material, degrees)
  local t = scene:links { spacing = 0.2, rays = 64 }
  local light = make(t:radiosity())
  local given = with({ bounced = light, links = o and o.rays and t or nil, gloss = o and o.gloss }, few)
  local image, report = scene:render(given)
  for i = #report.warnings, 1, -1 do -- noise of direct light is not the subject here
    if report.warnings[i]:find "in direct light" then table.remove(report.warnings, i) end
  end
  local all, direct = mean(image), mean((scene:render { size = few.size, samples = few.samples, bounces = 0 }))
  local out = {}
  for c = 1, 3 do out[c] = (all[c] - direct[c]) / SENT end
  return out, report
end

local function field(lit) return lit:field { rays = 768 } end

local function baked(lit)
  return ylm.bake(ylm.uniform_grid { bounds = { { -0.5, -0.5, -0.7 }, { 0.5, 0.5, 0.3 } }, cells = 2, lmax = 3 }, field(lit))
end

describe("light of a field that bounces, on glossy surfaces", function()
  it("is F . L: the reflectance where it comes from everywhere alike", function()
    local m = ylm.ggx { alpha = 0.5, f0 = { 0.9, 0.6, 0.2 }, base = 0.05 }
    local truth = m:albedo({ math.cos(math.rad(35)) }):totable()[1]
    for _, make in ipairs { field, baked } do
      local got, report = by_field(m, 35, make, { gloss = "sh" })
      for c = 1, 3 do assert.near(1, got[c] / truth[c], 0.03) end
      assert.equal("those of the grid", report.bounces)
      assert.is_true(report.bounced_glossy.sh > 0 and report.bounced_glossy.rays == 0)
    end
  end)

  it("goes to rays where its degree is too low and links are there, else one line says so", function()
    local m = ylm.ggx { alpha = 0.05, f0 = { 0.9, 0.6, 0.2 } }
    local truth = m:albedo({ math.cos(math.rad(35)) }):totable()[1]
    local got, report = by_field(m, 35, baked, { rays = true })
    for c = 1, 3 do assert.near(1, got[c] / truth[c], 0.03) end
    assert.is_true(report.bounced_glossy.rays > 0 and report.bounced_glossy.sh == 0 and report.rays.gloss_links > 0)
    assert.same({}, report.warnings)
    report = select(2, by_field(m, 35, baked))
    assert.equal(1, #report.warnings)
    assert.matches("harmonics of degree 3 miss %d+ %% of its lobes in bounced light: give links", report.warnings[1])
    report = select(2, by_field(m, 35, baked, { gloss = "matte" }))
    assert.matches("a grid's bounced light meets it as a matte one of its mean albedo", report.warnings[1])
  end)

  it("meets points by rays to lamps and elements under a grid of all light", function()
    local scene, lit = room(ylm.ggx { alpha = 0.1, f0 = 0.7 })
    local probes = ylm.uniform_grid { bounds = { { -1.45, 0.02, -1.45 }, { 1.45, 1.95, 1.5 } }, cells = { 6, 4, 6 }, lmax = 3 }
    local o, size = { samples = 16, share = 0 }, { 16, 9 }
    local truth = scene:pathtrace { size = size, samples = 1024, layers = false, reflections = { 0, "all" } }
    local grid = ylm.bake(probes, lit:field { quantity = "all", rays = 384 })
    local function error(more) return error_of(scene:render(with({ grid = grid, size = size }, with(more, o))), truth) end
    local rays, harmonics, matte = error { links = lit.links }, error {}, error { gloss = "matte" }
    assert.is_true(rays < 0.6 * harmonics and harmonics < matte, ("%.3f %.3f %.3f"):format(rays, harmonics, matte))
  end)

  it("refuses rays without links, and what shades nothing", function()
    local scene, lit = room(ggx)
    local o = { size = { 16, 9 }, samples = 1 }
    for _, case in ipairs {
      { { bounced = field(lit), gloss = "rays" }, "gloss = 'rays': rays find light on elements: give links" },
      { { grid = field(lit), gloss = "rays" }, "or give links = scene:links {}, whose elements rays find" },
      { { bounces = 1, gloss = "sh" }, "gloss is for a grid" }, { { gloss = "matte", bounces = 0 }, "gloss is for a grid" },
      { { bounced = field(lit), links = room(ggx):links { spacing = 0.5, rays = 4 } }, "this is another" },
    } do
      assert.error_matches(function() scene:render(with(case[1], o)) end, case[2])
    end
  end)
end)
