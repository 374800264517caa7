-- Green 2003, Figs. 11, 13, 14, 15: a white cup under a hemisphere of light by transfer vectors of 25 coefficients: without
-- shadows, with shadows, with light that surfaces send on; a place with the surfaces that it sees; light by bounce.
--
--     lua examples/papers/gritty_2003_transfer.lua [--out DIR] [--quick]
--
-- Writes gritty_2003_transfer.png and gritty_2003_bounces.png; prints energy by bounce, seconds by stage, and how far the
-- picture with all bounces is from paths under the same light.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick
local size = quick and { 80, 60 } or { 480, 360 }
local around, links, samples = quick and 24 or 72, quick and 64 or 128, quick and 32 or 64
local pi = math.pi

-- The scene ---------------------------------------------------------------------------

--- A surface of revolution about y: the profile { radius, height } runs so that its left is outside.
local function lathe(profile, material)
  local vertices, triangles = {}, {}
  for _, p in ipairs(profile) do
    for i = 0, around - 1 do
      local u = 2 * pi * i / around
      vertices[#vertices + 1] = { p[1] * math.cos(u), p[2], p[1] * math.sin(u) }
    end
  end
  for k = 0, #profile - 2 do
    for i = 0, around - 1 do
      local a, b = k * around + i + 1, k * around + (i + 1) % around + 1
      if profile[k + 1][1] > 0 then triangles[#triangles + 1] = { a, a + around, b } end
      if profile[k + 2][1] > 0 then triangles[#triangles + 1] = { b, a + around, b + around } end
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, material = material }
end

--- The profile through places { radius, height } with `n` steps between two of them.
local function fine(places, n)
  local list = {}
  for i = 1, #places - 1 do
    local a, b = places[i], places[i + 1]
    for k = 0, n - 1 do list[#list + 1] = { a[1] + (b[1] - a[1]) * k / n, a[2] + (b[2] - a[2]) * k / n } end
  end
  list[#list + 1] = places[#places]
  return list
end

--- A handle: a tube along an arc in the plane z = 0, whose ends are in the wall of the cup.
local function handle(material)
  local vertices, triangles, along, across = {}, {}, around, math.floor(around / 3)
  for i = 0, along do
    local t = math.rad(-105 + 210 * i / along)
    local x, y = 0.46 + 0.26 * math.cos(t), 0.52 + 0.26 * math.sin(t)
    for k = 0, across - 1 do
      local u = 2 * pi * k / across
      local r = 0.045 * math.cos(u)
      vertices[#vertices + 1] = { x + r * math.cos(t), y + r * math.sin(t), 0.07 * math.sin(u) }
    end
  end
  for i = 0, along - 1 do
    for k = 0, across - 1 do
      local a, b = i * across + k + 1, i * across + (k + 1) % across + 1
      triangles[#triangles + 1] = { a, b, a + across }
      triangles[#triangles + 1] = { b, b + across, a + across }
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, material = material, sides = "front" }
end

local white = ylm.matte { albedo = { 0.86, 0.85, 0.83 } }
local steps = quick and 3 or 8
local cup = fine({ { 0, 0.1 }, { 0.3, 0.1 }, { 0.42, 0.25 }, { 0.5, 0.55 }, { 0.53, 0.9 }, { 0.49, 0.9 }, { 0.46, 0.56 },
  { 0.38, 0.27 }, { 0.28, 0.16 }, { 0, 0.16 } }, steps)
local saucer = fine({ { 0, 0.02 }, { 0.5, 0.02 }, { 0.95, 0.14 }, { 0.97, 0.17 }, { 0.5, 0.06 }, { 0, 0.06 } }, steps)
local sky = ylm.environment_light { coefficients = ylm.sh.cap(4, { 0, 1, 0 }, pi / 2) } -- a hemisphere of radiance 1, 5 bands

local scene = ylm.scene "a cup" {
  camera = ylm.camera { from = { 1.5, 2.3, 3.1 }, at = { 0.12, 0.32, 0 }, fov = 36 },
  geometry = {
    lathe(cup, white), handle(white), lathe(saucer, white),
    ylm.quad { corner = { -4, 0, 4 }, u = { 8, 0, 0 }, v = { 0, 0, -8 }, divide = quick and 24 or 64, sides = "front",
      material = ylm.matte { albedo = { 0.75, 0.24, 0.1 } } },
    ylm.sphere { at = { -0.75, 0.3, 0.95 }, scale = 0.3, divide = { around, around / 2 },
      material = ylm.matte { albedo = { 0.15, 0.55, 0.12 } } },
    ylm.box { bounds = { { 1.02, 0, -0.75 }, { 1.52, 0.7, -0.25 } }, divide = quick and 6 or 14,
      material = ylm.matte { albedo = { 0.1, 0.25, 0.7 } } },
  },
  background = { 0.6, 0.6, 0.62 },
  lights = sky,
}

-- Links, vectors, pictures ---------------------------------------------------------------

local t = assert(scene:links { spacing = quick and 0.3 or 0.15, rays = quick and 64 or 128, lmax = 4 })
local view = assert(scene:prepare { size = size, samples = quick and 2 or 4, lmax = 4, visibility = "none" })
print(("%d elements, %d links of each: %.1f s; %d shading points"):format(t.stats.elements, t.stats.links, t.stats.seconds,
  view.stats.points))

local row = common.table { { "", "%-34s" }, { "vectors s", "%9.2f" }, { "picture s", "%9.3f" }, { "irradiance", "%10.4f" } }
local clock = require "ylm.c.core".seconds

--- Mean luminance of a picture's surfaces.
local function brightness(image)
  return common.luminance(image:layer()):select(image:layer "coverage":greater(0.99)):mean()
end

--- A picture by vectors that make() returns, and what it took.
local function shade(name, make)
  local start = clock()
  local T = assert(make())
  local made = clock() - start
  local image, report = assert(view:render { vectors = T })
  row { name, made, report.seconds.light, brightness(image) * pi }
  return image
end

local unshadowed = shade("Fig. 11: without shadows", function() return view:transfer() end)
local shadowed = shade("Fig. 13: shadows", function() return view:transfer { links = t, bounces = 0, rays = links } end)
local all = shade("Fig. 15: shadows and bounces", function() return view:transfer { links = t, rays = links } end)

local start = clock()
local truth = assert(scene:pathtrace { size = size, samples = samples })
local m = assert(all:compare(truth))
print(("paths, %d a pixel, %.1f s: the picture with all bounces is %.1f dB from theirs; mean %+.2f %%"):format(samples,
  clock() - start, m.psnr, 100 * (brightness(all) / brightness(truth) - 1)))

-- Fig. 14: one place, and the surfaces that it sees ------------------------------------------

--- Where a place is in the picture: x, y in pixels.
local function project(p)
  local c = scene.camera
  local function unit(v)
    local l = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
    return { v[1] / l, v[2] / l, v[3] / l }
  end
  local function cross(a, b) return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] } end
  local f = unit { c.at[1] - c.from[1], c.at[2] - c.from[2], c.at[3] - c.from[3] }
  local r = unit(cross(f, c.up))
  local u = cross(r, f)
  local d, x, y, z = { p[1] - c.from[1], p[2] - c.from[2], p[3] - c.from[3] }, 0, 0, 0
  for i = 1, 3 do x, y, z = x + d[i] * r[i], y + d[i] * u[i], z + d[i] * f[i] end
  local scale = size[2] / 2 / math.tan(math.rad(c.fov) / 2)
  return size[1] / 2 + scale * x / z, size[2] / 2 - scale * y / z
end

local e, list = t:elements(), t:hits()
local function place(i) return { e.centre:get(i, 1), e.centre:get(i, 2), e.centre:get(i, 3) } end
local A, least = 1, math.huge -- the element nearest to the place under the cup's side that faces the saucer
for i = 1, #e.area do
  local d = 0
  for k, x in ipairs { 0.25, 0.33, 0.38 } do d = d + (e.centre:get(i, k) - x) ^ 2 end
  if e.mesh:get(i) == 1 and e.normal:get(i, 2) < 0 and d < least then A, least = i, d end
end

local drawing = ylm.image { size = size }
local layer = drawing:layer()
layer[{}] = 0.25 * shadowed:layer()
local x0, y0 = project(place(A))
local seen = {}
for i = 1, list.shape[2] do
  local j = list:get(A, i)
  if j <= #e.area and not seen[j] then
    seen[j] = true
    local x1, y1 = project(place(j))
    local n = math.ceil(math.max(math.abs(x1 - x0), math.abs(y1 - y0), 1) * 2)
    for k = 0, n do
      local x, y = math.floor(x0 + (x1 - x0) * k / n) + 1, math.floor(y0 + (y1 - y0) * k / n) + 1
      if x >= 1 and x <= size[1] and y >= 1 and y <= size[2] then
        for c = 1, 3 do layer:set(y, x, c, e.albedo:get(j, c) * (0.35 + 0.65 * k / n)) end
      end
    end
  end
end

-- Light by bounce ------------------------------------------------------------------------------

local L, area = ylm.light_field(4, sky, { 0, 0, 0 }), e.area:sum()

--- Mean irradiance of all elements, by channel, with that many bounces.
local function irradiance(bounces)
  local T = assert(t:vectors { bounces = bounces })
  return ((T * L):sum(3) * e.area:reshape { #e.area, 1 }):sum(1) / area
end

print "mean irradiance that each bounce adds (red, green, blue), and the part of all light that it is:"
local total, last, series = irradiance "all", { 0, 0, 0 }, {
  { label = "red", colour = { 0.8, 0.1, 0.05 } }, { label = "green", colour = { 0.1, 0.55, 0.1 } },
  { label = "blue", colour = { 0.1, 0.25, 0.8 } } }
for k = 0, quick and 3 or 8 do
  local now = irradiance(k)
  local added = {}
  for c = 1, 3 do
    added[c], last[c] = now[c] - last[c], now[c]
    series[c].x, series[c].y = series[c].x or {}, series[c].y or {}
    series[c].x[k + 1], series[c].y[k + 1] = k, added[c] / total[c]
  end
  print(("  %d  %.5f %.5f %.5f   %8.4f %% %8.4f %% %8.4f %%"):format(k, added[1], added[2], added[3], 100 * added[1] / total[1],
    100 * added[2] / total[2], 100 * added[3] / total[3]))
end

common.save(ylm.figure {
  title = "Diffuse transfer by 25 coefficients (Green 2003, Figs. 11, 13, 15, 14)",
  rows = { {
    { image = unshadowed, tone = "srgb", exposure = -0.3, caption = "Fig. 11: unshadowed" },
    { image = shadowed, tone = "srgb", exposure = -0.3, caption = "Fig. 13: shadowed" },
  }, {
    { image = all, tone = "srgb", exposure = -0.3, caption = "Fig. 15: interreflected" },
    { image = drawing, tone = "srgb", exposure = -0.3, caption = "Fig. 14: a place and its links" },
  } },
  caption = ("One hemisphere of light. %d elements with %d links each; %d links at a shading point."):format(t.stats.elements,
    t.stats.links, links),
}, out .. "gritty_2003_transfer.png")
common.save(ylm.plot { series = series, y_log = true, legend = "top right", title = "Light by bounce",
  x_label = "reflections after direct light", y_label = "part of the mean irradiance" }, out .. "gritty_2003_bounces.png")
