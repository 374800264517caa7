-- Green 2003, "Local Lighting" (after Sloan et al. 2002): lamps near a head, known at 6, 8 and 32 places of it and blended
-- between these by 1/distance^10, beside a grid of probes and the lamps themselves.
--
--     lua examples/papers/gritty_2003_local.lua [--out DIR] [--quick]
--
-- Writes gritty_2003_local.png and prints errors against the lamps asked at every shading point. All pictures have the same
-- transfer vectors, with the head's shadows on itself and without bounces: bounces would light it by light of other places.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick
local size = quick and { 48, 60 } or { 320, 400 }
local clock = require "ylm.c.core".seconds

-- A head: a sphere with bumps ---------------------------------------------------------------

local bumps = { -- direction, height, width across and along
  { { 0, -0.08, 1 }, 0.24, 0.13, 0.24 }, { { 0, -0.2, 1 }, 0.1, 0.2, 0.1 }, -- nose
  { { 0.34, 0.16, 0.9 }, -0.1, 0.18, 0.14 }, { { -0.34, 0.16, 0.9 }, -0.1, 0.18, 0.14 }, -- eyes
  { { 0.32, 0.13, 0.9 }, 0.055, 0.09, 0.09 }, { { -0.32, 0.13, 0.9 }, 0.055, 0.09, 0.09 },
  { { 0.32, 0.38, 0.88 }, 0.07, 0.25, 0.09 }, { { -0.32, 0.38, 0.88 }, 0.07, 0.25, 0.09 }, -- brows
  { { 0, -0.5, 0.88 }, 0.06, 0.25, 0.08 }, { { 0, -0.565, 0.85 }, -0.06, 0.24, 0.035 }, { { 0, -0.65, 0.8 }, 0.06, 0.2, 0.07 },
  { { 0, -1.0, 0.75 }, 0.13, 0.28, 0.2 }, -- chin
  { { 1, -0.05, -0.1 }, 0.13, 0.12, 0.22 }, { { -1, -0.05, -0.1 }, 0.13, 0.12, 0.22 }, -- ears
  { { 0.75, -0.3, 0.55 }, -0.05, 0.3, 0.3 }, { { -0.75, -0.3, 0.55 }, -0.05, 0.3, 0.3 }, -- cheeks
}
for _, b in ipairs(bumps) do
  local d = b[1]
  local l = math.sqrt(d[1] ^ 2 + d[2] ^ 2 + d[3] ^ 2)
  b.u, b.v = (math.atan2 or math.atan)(d[1], d[3]), math.asin(d[2] / l)
end

local function radius(u, v)
  local r = 1
  for _, b in ipairs(bumps) do
    local du = (u - b.u + math.pi) % (2 * math.pi) - math.pi
    local a, c = du * math.cos(v) / b[3], (v - b.v) / b[4]
    r = r + b[2] * math.exp(-(a * a + c * c))
  end
  return r
end

local function head()
  local around, rings = quick and 64 or 320, quick and 40 or 200
  local vertices, triangles = {}, {}
  for k = 0, rings do
    local v = math.pi * (k / rings - 0.5)
    for i = 0, around - 1 do
      local u = 2 * math.pi * i / around
      local r = radius(u, v)
      vertices[#vertices + 1] = { 0.78 * r * math.cos(v) * math.sin(u), 1.05 * r * math.sin(v),
        0.9 * r * math.cos(v) * math.cos(u) }
    end
  end
  for k = 0, rings - 1 do
    for i = 0, around - 1 do
      local a, b = k * around + i + 1, k * around + (i + 1) % around + 1
      if k > 0 then triangles[#triangles + 1] = { a, b, b + around } end
      if k < rings - 1 then triangles[#triangles + 1] = { a, b + around, a + around } end
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, material = ylm.matte { albedo = { 0.8, 0.76, 0.7 } } }
end

local lamps = {
  ylm.sphere_light { at = { 1.25, 0.75, 1.1 }, radius = 0.18, radiance = { 14, 8, 3 } },
  ylm.sphere_light { at = { -1.35, -0.2, 0.75 }, radius = 0.15, radiance = { 3, 9, 16 } },
  ylm.sphere_light { at = { 0.1, -1.5, 1.2 }, radius = 0.1, radiance = { 12, 2, 8 } },
}

local scene = ylm.scene "a head" {
  camera = ylm.camera { from = { 0.7, 0.35, 4.6 }, at = { 0, -0.05, 0 }, fov = 33 },
  geometry = head(), lights = lamps,
}

--- n vertices of the head as far apart as they go: each is the farthest from those before.
local function spread(n)
  local points, places = scene.geometry[1].mesh:vertices(), {}
  local far, at = nil, 1
  for k = 1, n do
    places[k] = points[at]
    local square = ((points - places[k]) ^ 2):sum(2)
    far = far and far:clamp(nil, square) or square
    local best = far:max()
    at = 1
    while far[at] < best do at = at + 1 end
  end
  return ylm.stack(places)
end

-- Pictures ------------------------------------------------------------------------------------

local t = assert(scene:links { rays = 4, lmax = 4 })
local view = assert(scene:prepare { size = size, samples = quick and 2 or 4, lmax = 4, visibility = "none" })
local T = assert(view:transfer { links = t, bounces = 0, rays = quick and 64 or 256 })
local truth, report = view:render { vectors = T }
print(("%d shading points, lmax 4; lamps asked at each: %.3f s"):format(view.stats.points, report.seconds.light))

local row = common.table { { "light", "%-30s" }, { "probes", "%6d" }, { "asked s", "%8.4f" }, { "shading s", "%9.3f" },
  { "PSNR dB", "%8.1f" }, { "relmse", "%9.2e" } }
local pictures, differences = { false }, { false } -- of the lamps at every point

local function try(name, caption, make)
  local start = clock()
  local light, probes = make()
  local asked = clock() - start
  local image, how = assert(view:render { vectors = T, lights = light })
  local m = assert(image:compare(truth))
  row { name, probes, asked, how.seconds.light, m.psnr, m.relmse }
  local values = common.luminance(image:layer()) - common.luminance(truth:layer())
  pictures[#pictures + 1] = { image = image, tone = "srgb", exposure = 0.6, caption = caption }
  differences[#differences + 1] = { values = values, caption = ("%.1f dB"):format(m.psnr) }
  return m.psnr
end

local function sampled(n)
  return function() return ylm.sampled_light { at = spread(n), lights = lamps, lmax = 4, power = 10 }, n end
end

try("one sample (distant light)", "1 sample", function()
  return ylm.sampled_light { at = { { 0, 0, 0 } }, lights = lamps, lmax = 4 }, 1
end)
for _, n in ipairs { 6, 8, 32 } do try(("%d samples, power 10"):format(n), n .. " samples", sampled(n)) end
try("32 samples, power 3", "32 samples, power 3", function()
  return ylm.sampled_light { at = spread(32), lights = lamps, lmax = 4, power = 3 }, 32
end)
try("uniform grid, 3 x 3 x 3 cells", "grid, 64 probes", function()
  local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { { -1, -1.3, -1.2 }, { 1, 1.3, 1.3 } }, cells = 3, lmax = 4,
    channels = "rgb" }, lamps))
  return grid, grid.stats.points
end)
try("adaptive grid, tolerance 0.1", "adaptive grid", function()
  local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = 4, tolerance = 0.1, channels = "rgb" }, lamps, { occupied = view }))
  return grid, grid.stats.points
end)

local rows = { {}, {} } -- 6 and 32 samples, the uniform grid, the adaptive grid
for i, k in ipairs { 3, 5, 7, 8 } do rows[1][i], rows[2][i] = pictures[k], differences[k] end
common.save(ylm.figure {
  title = "Local lighting from a few samples (Green 2003), and from grids",
  rows = rows, bar = { range = { -0.3, 0.3 }, map = "coolwarm", label = "difference of luminance" },
  caption = "Above: pictures by the same transfer vectors, without bounces. Below: their differences from the lamps asked at "
    .. "every point.",
}, out .. "gritty_2003_local.png")
