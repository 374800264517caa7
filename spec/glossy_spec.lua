-- Glossy surfaces, shaded by spherical harmonics: gloss = "sh".
local by_kernels = require "spec.support.by_kernels"
local core = require "ylm.c.core"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local function unit(v)
  local l = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
  return { v[1] / l, v[2] / l, v[3] / l }
end

local function view(degrees, azimuth)
  local t, a = math.rad(degrees), math.rad(azimuth or 0)
  return { math.sin(t) * math.cos(a), math.sin(t) * math.sin(a), math.cos(t) }
end

local function scaled(v, s) return { s * v[1], s * v[2], s * v[3] } end

local one = { size = { 1, 1 }, samples = 1 }
local function with(more, base)
  local out = {}
  for k, x in pairs(base or one) do out[k] = x end
  for k, x in pairs(more or {}) do out[k] = x end
  return out
end

--- A small square at 0 whose normal is z and whose tangent x, seen from `eye`.
local function element(material, eye, lights, more)
  local geometry = { ylm.quad { corner = { -5e-4, -5e-4, 0 }, u = { 1e-3, 0, 0 }, v = { 0, 1e-3, 0 }, material = material } }
  for _, g in ipairs(more or {}) do geometry[#geometry + 1] = g end
  return ylm.scene "element" { camera = ylm.camera { from = scaled(eye, 0.1), at = { 0, 0, 0 }, up = { 0, 1, 0.01 }, fov = 0.01 },
    geometry = geometry, lights = lights }
end

local function pixel(image)
  local r, g, b = image:layer "radiance":get(1, 1, 1), image:layer "radiance":get(1, 1, 2), image:layer "radiance":get(1, 1, 3)
  return { r, g, b }
end

--- The radiance towards `eye` under a lamp of radiance 1 in direction d whose half angle has the sine `sine`, by Gauss's rule
-- over its cap.
local function by_quadrature(m, eye, d, sine)
  local directions, weights = core.sh_rule(24, 48, math.sqrt(1 - sine * sine), 1)
  local a = unit(math.abs(d[3]) < 0.9 and { d[2], -d[1], 0 } or { 0, d[3], -d[2] })
  local b = { d[2] * a[3] - d[3] * a[2], d[3] * a[1] - d[1] * a[3], d[1] * a[2] - d[2] * a[1] }
  local wi, w = {}, weights:totable()
  for i, x in ipairs(directions:totable()) do
    wi[i] = {}
    for c = 1, 3 do wi[i][c] = x[1] * a[c] + x[2] * b[c] + x[3] * d[c] end
  end
  local f, sum = m:eval(ylm.array(wi), eye):totable(), { 0, 0, 0 }
  for i, x in ipairs(wi) do
    for c = 1, 3 do sum[c] = sum[c] + w[i] * f[i][c] * math.max(0, x[3]) end
  end
  return sum
end

local gold = ylm.ggx { alpha = 0.5, f0 = { 1, 0.78, 0.34 } }

--- Spheres, or other shapes, under one lamp.
local function scene(geometry, lights)
  return ylm.scene "glossy" { camera = ylm.camera { from = { 0, 0.5, 4 }, at = { 0, 0, 0 }, fov = 35 }, geometry = geometry,
    lights = lights or { ylm.sphere_light { at = { 3, 4, 3 }, radius = 1, radiance = { 30, 20, 10 } } } }
end

local picture = { size = { 24, 24 }, samples = 4 }

--- The root mean square of a - b, relative to that of b, less b's noise where its variance is given.
local function distance(a, b, variance)
  local x, y, v, d, n = a:layer "radiance":totable(), b:layer "radiance":totable(), variance and variance:totable(), 0, 0
  for j = 1, #x do
    for i = 1, #x[1] do
      for c = 1, 3 do d, n = d + (x[j][i][c] - y[j][i][c]) ^ 2 - (v and v[j][i][c] or 0), n + y[j][i][c] ^ 2 end
    end
  end
  return math.sqrt(math.max(0, d) / n)
end

--- Do two pictures have equal bits?
local function same(a, b)
  local x, y = a:layer "radiance":totable(), b:layer "radiance":totable()
  for j = 1, #x do
    for i = 1, #x[1] do
      for c = 1, 3 do if x[j][i][c] ~= y[j][i][c] then return false end end
    end
  end
  return true
end

describe("gloss = 'sh'", function()
  it("shades by f cos over the cap of a lamp", function()
    for _, case in ipairs { { view(0), view(20, 90) }, { view(30, 50), view(25, 200) }, { view(50, 250), view(40, 110) } } do
      local eye, d = case[1], case[2]
      local image = element(gold, eye, { ylm.sphere_light { at = d, radius = 0.3, radiance = 1 } })
        :render(ways.sum(with { lmax = 8, visibility = "none", gloss = "sh" }))
      local got, truth = pixel(image), by_quadrature(gold, eye, d, 0.3)
      for c = 1, 3 do assert.near(1, got[c] / truth[c], 0.03) end
    end
  end)

  it("shades a table of a matte material as transfer vectors shade the material, of floats and doubles", function()
    local o = with({ lmax = 6, visibility = "none", share = 0 }, picture)
    local matte = scene { ylm.sphere { material = ylm.matte { albedo = { 0.3, 0.5, 0.2 } } } }:render(ways.sum(o))
    local tabled = scene { ylm.sphere { material = ylm.phong { exponent = 1, specular = 0, base = { 0.3, 0.5, 0.2 } } } }
    for _, dtype in ipairs { "float", "double" } do
      assert.is_true(distance(tabled:render(ways.sum(with({ gloss = "sh", dtype = dtype }, o))), matte) < 1e-4)
    end
  end)

  it("takes nothing away where nothing occludes, to the last bit", function()
    local floor = scene { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = gold } }
    local open = floor:render(ways.sum(with({ lmax = 4, visibility = "none", gloss = "sh" }, picture)))
    assert.is_true(same(open, floor:render(ways.sum(with({ lmax = 4, visibility = "transfer", gloss = "sh" }, picture)))))
  end)

  it("agrees with paths of one reflection on a sphere", function()
    local s = scene { ylm.sphere { material = ylm.ggx { alpha = 0.5, f0 = { 1, 0.8, 0.3 } } } }
    local o = { size = picture.size, samples = 64, lmax = 8, visibility = "none" }
    local image, report = s:render(ways.sum(with({ gloss = "sh" }, o)))
    local truth = s:pathtrace { size = picture.size, samples = 256, reflections = { 1, 1 } }
    local error = distance(image, truth, truth:layer "variance")
    assert.is_true(error < 0.02, tostring(error))
    assert.is_true(3 * error < distance(s:render(ways.sum(with({ gloss = "matte" }, o))), truth))
    assert.equal("sh", report.gloss)
    assert.is_true(report.gloss_bytes > 0 and report.seconds.gloss > 0 and report.seconds.gloss <= report.seconds.transfer)
    local _, again = s:render(ways.sum(with({ gloss = "sh" }, o))) -- the material keeps its table
    assert.is_true(again.gloss_bytes == report.gloss_bytes and again.seconds.gloss < 0.2 * report.seconds.gloss)
  end)

  it("knows along and across of a material that has two roughnesses", function()
    local function sphere(alpha)
      return scene { ylm.sphere { material = ylm.ggx { alpha = alpha, f0 = 0.9, compensate = false } } }
    end
    local s = sphere { 0.4, 0.9 }
    local truth = s:render(ways.rays(with({ light_samples = 256 }, picture)))
    assert.is_true(distance(s:render(ways.sum(with({ lmax = 6, visibility = "none", gloss = "sh" }, picture))), truth) < 0.06)
    assert.is_true(distance(sphere { 0.9, 0.4 }:render(ways.rays(with({ light_samples = 256 }, picture))), truth) > 0.3)
  end)

  it("keeps what occluders stop from a floor", function()
    local floor = ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = gold }
    local s = scene({ floor, ylm.sphere { at = { 0, -0.5, -0.8 }, scale = 0.5 } },
      { ylm.sphere_light { at = { 0, 2.5, -5 }, radius = 1.5, radiance = 10 } })
    local truth = s:render(ways.rays(with({ light_samples = 64 }, picture)))
    local o = with({ lmax = 8, transfer_samples = 256, occlusion_distance = math.huge, gloss = "sh" }, picture)
    local shadows = distance(s:render(ways.sum(with({ visibility = "transfer" }, o))), truth)
    o.transfer_samples, o.occlusion_distance = nil, nil
    local none = distance(s:render(ways.sum(with({ visibility = "none" }, o))), truth)
    assert.is_true(shadows < 0.015 and none > 0.05, shadows .. " " .. none)
  end)

  it("shades what occluders shadow alike by each kernel set, in one pass or in two", function()
    require "ylm.c.scene"
    local program = [[
      local ylm = require "ylm"
      for _, light in ipairs { ylm.sphere_light { at = { 1, 3, -1 }, radius = 1, radiance = { 5, 6, 7 } },
        ylm.sun_light { direction = { 1, 3, -1 }, angle = 20, irradiance = { 3, 4, 5 } } } do
        local s = ylm.scene "kernels" { camera = ylm.camera { from = { 0, 1.5, 3 }, at = { 0, 0, 0 }, fov = 40 }, geometry = {
          ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 },
            material = ylm.ggx { alpha = 0.5, f0 = { 1, 0.78, 0.34 } } }, ylm.sphere { scale = 0.7 } }, lights = { light } }
        for _, lmax in ipairs { 2, 7 } do
          local image = s:render { by = "sum", size = { 7, 5 }, samples = 1, lmax = lmax, visibility = "transfer",
            transfer_samples = 32, gloss = "sh", threads = 1 }
          for _, row in ipairs(image:layer "radiance":totable()) do
            for _, p in ipairs(row) do print(("%.9g %.9g %.9g"):format(p[1], p[2], p[3])) end
          end
        end
      end]]
    local plain
    for _, isa in ipairs(ylm.info().kernels) do -- the reference first
      local list = by_kernels(isa, program)
      plain = plain or list
      assert.equal(4 * 7 * 5 * 3, #list)
      for i, x in ipairs(list) do
        assert(math.abs(x - plain[i]) <= 2e-5 * (math.abs(plain[i]) + 0.1), ("%s, number %d: %g, plain %g"):format(isa, i, x,
          plain[i]))
      end
    end
  end)

  it("is the same by any number of threads, and by vertices near the same", function()
    local s = scene { ylm.sphere { material = gold }, ylm.sphere { at = { 0.9, 0.9, 0.4 }, scale = 0.3,
      material = ylm.phong { exponent = 4, specular = 0.5, base = { 0.1, 0.2, 0.4 } } } }
    local o = with({ lmax = 4, visibility = "transfer", transfer_samples = 32, gloss = "sh" }, picture)
    local first = s:render(ways.sum(with({ threads = 1 }, o)))
    for _, threads in ipairs { 2, 7 } do assert.is_true(same(first, s:render(ways.sum(with({ threads = threads }, o))))) end
    assert.is_true(distance(s:render(ways.sum(with({ shading = "vertices", transfer_samples = 256 }, o))), first) < 0.1)
  end)

  it("shades by grids: of lights with the view's visibility, of direct light without", function()
    local s = scene { ylm.sphere { material = gold } }
    local probes = ylm.uniform_grid { cells = { 6, 6, 6 }, lmax = 6, bounds = { { -1.2, -1.2, -1.2 }, { 1.2, 1.2, 1.2 } } }
    local exact = s:render(ways.sum(with({ lmax = 6, visibility = "none", gloss = "sh" }, picture)))
    local lights = s:bake { quantity = "lights", probes = probes }
    local own = with({ grid = lights, visibility = "none", gloss = "sh", dering = false }, picture)
    assert.is_true(distance(s:render(own), exact) < 0.02)
    local direct = s:bake { quantity = "direct", probes = probes }
    local image, report = s:render(with({ grid = direct, gloss = "sh" }, picture))
    assert.is_true(distance(image, exact) < 0.08)
    assert.is_true(distance((s:render(with({ grid = direct, gloss = "matte" }, picture))), exact) > 0.2)
    assert.is_true(report.visibility == "grid" and report.gloss == "sh")
    local view_ = s:prepare(with({ gloss = "sh" }, picture))
    assert.is_true(same(image, (view_:render { grid = direct })))
    assert.is_true(view_.options.gloss == "sh" and view_.stats.glossy > 0)
  end)

  it("changes nothing where it is not asked for", function()
    local s = scene { ylm.sphere { material = gold } }
    local o = with({ lmax = 3, visibility = "none", gloss = "matte" }, picture)
    local image, report = s:render(ways.sum(o))
    assert.is_true(same(image, (s:prepare(o):render { by = "sum" })))
    assert.equal("matte", report.gloss)
    assert.equal(1, #report.warnings)
    local matte = scene { ylm.sphere {} }
    local a, b = matte:render(ways.sum(with({ gloss = "sh" }, o)))
    assert.is_true(same(a, (matte:render(ways.sum(o)))))
    assert.is_nil(b.gloss)
  end)

  it("leaves points to rays by the part of their slices that lmax misses, all, some or none of them", function()
    local s = scene { ylm.sphere { material = ylm.ggx { alpha = 0.6, f0 = 0.9 } },
      ylm.sphere { at = { 0.9, 0.9, 0.4 }, scale = 0.3 } }
    local o = with({ lmax = 8, visibility = "transfer", transfer_samples = 64, share = 0 }, picture)
    local function shot(more) return s:render(ways.sum(with(more, o))) end
    local rays, by_rays = shot { gloss = "rays", light_samples = 16 }
    local sh, by_sh = shot { gloss = "sh" }
    local auto, report = shot { light_samples = 16, gloss_error = { 0.03, 0.06 } }
    assert.equal("auto", report.gloss)
    local found = report.glossy
    assert.is_true(found.sh > 0 and found.rays > 0 and found.sh + found.rays > found.points)
    assert.is_true(found.missed > 0 and found.missed < 0.06 and by_sh.glossy.missed > found.missed)
    assert.same({ found.points, 0, found.points, 0 }, { by_rays.glossy.points, by_rays.glossy.sh, by_rays.glossy.rays,
      by_sh.glossy.rays })
    assert.is_true(report.rays.gloss < by_rays.rays.gloss and by_sh.rays.gloss == 0)
    assert.is_true(by_rays.rays.occlusion < by_sh.rays.occlusion) -- whom rays alone shade needs no visibility
    local w, a, b = auto:layer "gloss":totable(), auto:layer "radiance":totable(), sh:layer "radiance":totable()
    for y = 1, #w do
      for x = 1, #w[1] do
        local k = w[y][x][1]
        if k == 0 then assert.equal(b[y][x][1], a[y][x][1]) end
        assert.is_true(k >= 0 and k <= 1)
      end
    end
    assert.is_true(distance(auto, rays) < distance(sh, rays))
    assert.is_true(same(sh, (shot { gloss_error = { 10, 11 } })))
    assert.is_true(same(rays, (shot { gloss_error = { 0, 1e-9 }, light_samples = 16 })))
    local matte = scene { ylm.sphere {} }
    assert.is_true(same(matte:render(ways.sum(o)), (matte:render(ways.sum(with({ gloss = "matte" }, o))))))
  end)

  it("finds highlights smaller than a pixel, by as many rays as their noise needs", function()
    local s = scene({ ylm.sphere { material = ylm.ggx { alpha = 0.1, f0 = 0.9 } } },
      { ylm.sphere_light { at = { 3, 4, 3 }, radius = 0.3, radiance = 300 } })
    local truth = s:pathtrace { size = picture.size, samples = 512, reflections = { 1, 1 } }
    local image, report = s:render { by = "sum", size = picture.size, samples = 16, lmax = 4, visibility = "none" }
    assert.is_true(distance(image, truth, truth:layer "variance") < 0.05)
    assert.is_true(report.glossy.noise <= 0.015 and report.glossy.light_samples >= 32)
    assert.is_true(report.glossy.sh == 0 and #report.warnings == 0)
    assert.is_true(distance(s:render { size = picture.size, samples = 16, bounces = 0 }, truth) < 0.08)
  end)

  it("keeps light from below out with below = 'dark', and damps degrees with a window", function()
    local floor = ylm.quad { corner = { -2, -0.5, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 },
      material = ylm.ggx { alpha = 0.2, f0 = 0.9 } }
    local s = scene({ floor }, { ylm.sphere_light { at = { 0, -4, 0 }, radius = 2.5, radiance = 30 } })
    local o = with({ lmax = 4, visibility = "transfer", transfer_samples = 16, gloss = "sh" }, picture)
    local function brightest(more)
      local most = 0
      for _, row in ipairs(s:render(ways.sum(with(more, o))):layer "radiance":totable()) do
        for _, p in ipairs(row) do most = math.max(most, math.abs(p[1])) end
      end
      return most
    end
    assert.is_true(brightest { below = "dark" } < 0.9 * brightest {}, brightest { below = "dark" } .. " " .. brightest {})
    local ball = scene { ylm.sphere { material = gold } }
    local function shot(more) return (ball:render(ways.sum(with(more, with({ visibility = "none", lmax = 4 }, o))))) end
    assert.is_true(same(shot {}, shot { window = "gaussian", window_width = 1e9 }))
    assert.is_true(distance(shot { window = "hann", window_width = 1 }, shot { lmax = 0 }) < 0.01)
    for message, more in pairs {
      ["window is for glossy surfaces in harmonics, gloss = 'auto' or 'sh': leave it"] = { gloss = "rays", window = "hann" },
      ["below = 'dark' is a visibility: name visibility = 'transfer', or"] = { below = "dark", visibility = "none" },
      ["window_width is of a window: name one ('hann'), or leave it out"] = { window_width = 3 },
      ["gloss_error must be two numbers, 0 <= first < second"] = { gloss = "auto", gloss_error = { 0.3, 0.1 } },
      ["gloss_error is for gloss = 'auto', gloss is \"sh\": leave one out"] = { gloss_error = { 0.1, 0.3 } },
      ["light_samples is for by = 'rays', and for glossy surfaces"] = { light_samples = 4 },
      ["gloss = 'rays': rays start at what camera rays hit: shading = 'pixel'"] = { gloss = "rays", shading = "vertices" },
    } do
      local ok, said = pcall(ball.render, ball, ways.sum(with(more, o)))
      assert(not ok and said:find(message, 1, true), said)
    end
  end)

  it("says where rays are wanted and have no lamps, and what harmonics then miss", function()
    local s = scene { ylm.sphere { material = ylm.ggx { alpha = 0.1, f0 = 0.9 } } }
    local probes = ylm.uniform_grid { cells = 2, lmax = 4, bounds = { { -1.2, -1.2, -1.2 }, { 1.2, 1.2, 1.2 } } }
    local grid = s:bake { quantity = "lights", probes = probes }
    local _, report = s:render(with({ grid = grid, visibility = "none", light_samples = 16 }, picture))
    assert.is_true(report.glossy.rays > 0 and #report.warnings <= 1) -- of occlusion
    local unknown = ylm.bake(probes, function(points, lmax, channels)
      local shape = { #points, channels, (lmax + 1) ^ 2 }
      return ylm.zeros(shape, "double"), ylm.zeros({ shape[1], shape[2], shape[3], 3 }, "double")
    end)
    local before = ylm.on_warning(false)
    _, report = s:render(with({ grid = unknown, visibility = "none" }, picture))
    ylm.on_warning(before)
    assert.equal(0, report.glossy.rays)
    assert.matches("harmonics of degree 4 miss %d+ %% of the lobes of glossy surfaces: the lamps behind the grid are not",
      table.concat(report.warnings, "\n"))
    local ok, said = pcall(s.render, s, with({ grid = unknown, visibility = "none", gloss = "rays" }, picture))
    assert(not ok and said:find("the lamps behind the grid are not known (it was loaded, or holds other light)", 1, true), said)
  end)

  it("is cancelled while tables are made, and made again", function()
    local s = scene { ylm.sphere { material = ylm.phong { exponent = 3 } } }
    local o, stages = with({ lmax = 1, visibility = "none", gloss = "sh" }, picture), {}
    o.progress = function(_, _, stage)
      stages[stage] = true
      return stage ~= "table"
    end
    local v, _, code = s:prepare(o)
    assert.is_nil(v)
    assert.equal("ECANCELLED", code)
    assert.is_true(stages.table)
    o.progress = nil
    assert.is_true(s:prepare(o).stats.gloss_bytes > 0)
  end)

  it("refuses degrees beyond its tables, and transfer vectors of what has none", function()
    local s = scene { ylm.sphere { material = gold } }
    assert.has_error(function() s:prepare(with { gloss = "ray" }) end, "bad argument #1 to 'prepare' (gloss must be one of "
      .. "'matte', 'sh', 'auto', 'rays' (did you mean 'rays'?), got 'ray')")
    assert.has_error(function() s:render { size = { 8, 4 }, gloss = "sh", bounces = 0 } end, 'render: gloss is for a grid (by = '
      .. '"grid"), and this picture is by rays: name one that fits, or leave gloss out')
    local ok, message = pcall(s.prepare, s, with({ lmax = 61, visibility = "none", gloss = "sh" }, picture))
    assert.is_false(ok)
    assert.matches("tables of degree 0 to 60, here is light of degree 61: lower lmax, or set gloss = 'rays' or 'matte'", message)
    local v = s:prepare(with { lmax = 2, visibility = "transfer", gloss = "sh" })
    assert.has_error(function() v:transfer() end,
      'transfer: glossy surfaces have no transfer vectors but as matte ones: prepare with gloss = "matte"')
  end)
end)
