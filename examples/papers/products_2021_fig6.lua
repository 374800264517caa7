-- Xin et al. 2021, Figs. 6 and 1 (a): glossy relighting, light and material both changed, beside a path-traced truth.
--
--     lua examples/papers/products_2021_fig6.lua [--out DIR] [--size 320] [--paths 256] [--quick]
--
-- Writes products_2021_fig6.png. Each scene is prepared once (camera rays, visibility of every shading point) and shaded under
-- two environments with two sets of materials: view:render { grid =, materials = }. Products are by quadrature; the same by
-- Fourier series differs by rounding ("Fourier"). Truth is direct light by paths, reflections = { 1, 1 }, of the same materials
-- under the same environment, cut at the same order: errors are those of slices and visibility cut at n, of products cut at n,
-- and of 512 occlusion rays a point. The paper's scenes, lights and materials are not published, and its figures print no
-- errors: bodies here stand in for Lucy (n = 10), Dragon & Bunny and Plants & Teapot (n = 15).

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common, shapes = dofile(here .. "../common.lua"), dofile(here .. "scenes_2022.lua")

local option = common.options { out = "out", size = 320, paths = 256, quick = false }
local quick = option.quick
local size = quick and { 16, 12 } or { option.size, math.floor(0.75 * option.size) }
local detail = quick and 10 or 120
ylm.on_warning(false)

local function metal(alpha, f0) return ylm.ggx { alpha = alpha, f0 = f0 } end
local function lacquer(alpha, base) return ylm.ggx { alpha = alpha, f0 = 0.08, base = base } end
local gold, copper, steel = { 1, 0.78, 0.34 }, { 0.96, 0.64, 0.54 }, { 0.56, 0.57, 0.58 }

--- Leaves around a stem: a cone of triangles, bent.
local function plant(at, leaves, material)
  local v, t = {}, {}
  for i = 1, leaves do
    local a, up = i * 2.39996, 0.35 + 0.65 * i / leaves
    for k = 0, 6 do
      local s = k / 6
      local r, h = 0.1 + 0.75 * s * (1.2 - 0.5 * up), up * (1.1 * s + 0.1) - 0.75 * s * s
      local half = 0.13 * math.sin(math.pi * (0.1 + 0.88 * s))
      for side = -1, 1, 2 do
        v[#v + 1] = { r * math.cos(a) - side * half * math.sin(a), h, r * math.sin(a) + side * half * math.cos(a) }
      end
      if k > 0 then
        local n = #v
        t[#t + 1], t[#t + 2] = { n - 3, n - 2, n - 1 }, { n - 2, n, n - 1 }
      end
    end
  end
  return ylm.mesh { vertices = v, triangles = t, material = material, at = at }
end

local function ground(material)
  return ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 }, material = material }
end

local cases = {
  { name = "(6a) in place of Lucy", n = 10, camera = { from = { 0.4, 1.5, 4.4 }, at = { 0, 0.8, 0 }, fov = 32 },
    geometry = function(m) return { ground(m[1]), shapes.figure(detail, m[2]) } end,
    materials = { { lacquer(0.5, { 0.25, 0.05, 0.04 }), metal(0.45, gold) },
      { metal(0.6, steel), lacquer(0.4, { 0.05, 0.25, 0.18 }) } } },
  { name = "(6b) in place of Dragon & Bunny", n = 15, camera = { from = { 0.2, 1.7, 4.6 }, at = { 0, 0.65, 0 }, fov = 34 },
    geometry = function(m)
      return { ground(m[1]), ylm.knot { at = { -0.75, 0.8, 0 }, scale = 0.5, divide = { 6 * detail, math.floor(detail / 3) },
        material = m[2] },
        shapes.beast(detail, m[3], { at = { 0.85, 0.68, 0.2 }, scale = 0.9 }) }
    end,
    materials = { { lacquer(0.45, { 0.3, 0.3, 0.32 }), metal(0.3, copper), metal(0.4, steel) },
      { metal(0.5, steel), lacquer(0.35, { 0.05, 0.2, 0.05 }), metal(0.35, gold) } } },
  { name = "(1a) in place of Plants & Teapot", n = 15, camera = { from = { 0, 1.9, 4.4 }, at = { 0, 0.5, 0 }, fov = 34 },
    geometry = function(m)
      return { ground(m[1]), plant({ -0.95, 0, -0.3 }, 26, m[2]), plant({ 1.0, 0, -0.2 }, 18, m[3]),
        ylm.torus { at = { 0.05, 0.34, 0.5 }, radius = 0.4, tube = 0.2, divide = { 2 * detail, detail },
          rotate = { axis = { 1, 0, 0 }, angle = 80 }, material = m[4] } }
    end,
    materials = { { lacquer(0.4, { 0.35, 0.22, 0.12 }), lacquer(0.4, { 0.04, 0.22, 0.03 }), lacquer(0.3, { 0.1, 0.3, 0.02 }),
        metal(0.35, gold) },
      { lacquer(0.5, { 0.06, 0.08, 0.2 }), metal(0.35, copper), metal(0.45, copper), metal(0.45, steel) } } },
}

--- A bump about the direction d.
local function lobe(x, y, z, d, sharp)
  return math.exp(sharp * ((x * d[1] + y * d[2] + z * d[3]) / math.sqrt(d[1] ^ 2 + d[2] ^ 2 + d[3] ^ 2) - 1))
end

--- Two environments: a sun through haze over a blue sky; two coloured windows at night.
local function sky(x, y, z)
  local sun, up = 9 * lobe(x, y, z, { 1, 0.9, 0.6 }, 14), math.max(0, y)
  return 0.12 + 0.35 * up + sun, 0.14 + 0.45 * up + 0.9 * sun, 0.18 + 0.65 * up + 0.7 * sun
end
local function night(x, y, z)
  local warm, cold = 6 * lobe(x, y, z, { -1, 0.5, 0.5 }, 12), 4 * lobe(x, y, z, { 1, 0.7, -0.4 }, 10)
  return 0.05 + warm + 0.4 * cold, 0.05 + 0.6 * warm + 0.6 * cold, 0.07 + 0.25 * warm + cold
end
local lights = { sky, night }

local function root(x) return math.sqrt(x:compare(ylm.image { size = x.size }).mse) end

local line = common.table { { "scene", "%-34s" }, { "n", "%3d" }, { "light, material", "%15d" }, { "rms error %", "%11.1f" },
  { "noise of truth %", "%16.1f" }, { "FLIP", "%6.3f" }, { "Fourier", "%8.0e" }, { "relit in s", "%10.2f" },
  { "paths s", "%8.1f" } }
local rows = {}
for number, case in ipairs(cases) do
  if quick and number == 2 then break end
  local n = quick and 5 or case.n
  local camera = ylm.camera(case.camera)
  --- Without light for views: skies in sight would stay those of the scene that they are prepared of.
  local function scene(k, light)
    return ylm.scene(case.name) { camera = camera, geometry = case.geometry(case.materials[k]), lights = { light } }
  end
  local view
  for k = 1, 2 do
    local light = ylm.environment_light { coefficients = ylm.sh.project(n - 1, lights[k]) }
    view = view or assert(scene(k):prepare { relight = "material", size = size, samples = quick and 1 or 4, lmax = n - 1,
      occlusion_distance = math.huge, transfer_samples = quick and 32 or 512 })
    local o = { grid = light, materials = case.materials[k], layers = true }
    local image, report = assert(view:render(o))
    o.product = "fourier"
    local fourier = quick and image or assert(view:render(o))
    local truth, told = scene(k, light):pathtrace { size = size, samples = quick and 32 or option.paths, reflections = { 1, 1 } }
    local mask = common.surface_mask(ylm, image)
    local c = image:compare(truth, { mask = mask, flip = "hdr" })
    local norm = truth:compare(ylm.image { size = size }, { mask = mask }).rmse
    line { case.name, n, k, 100 * c.rmse / norm, 100 * told.noise, c.flip, fourier:compare(image).rmse / root(image),
      report.seconds.light, told.seconds.total }
    local exposure = -math.log(4 * norm) / math.log(2) + 0.5
    local function shown(x, caption) return { image = x, caption = caption, exposure = exposure, tone = "srgb" } end
    rows[#rows + 1] = { shown(image, ("%s, n = %d, light and material %d"):format(case.name, n, k)),
      shown(truth, "paths, direct light"),
      shown(image:difference(truth, { scale = 4 }), ("4 x difference: %.1f %%"):format(100 * c.rmse / norm)) }
  end
end
common.save(ylm.figure { title = "Glossy relighting: light and material change, visibility is kept", rows = rows },
  option.out .. "products_2021_fig6.png")
print "Errors are over pixels that surfaces fill, relative to their root mean square; noise of the truth is part of them. Sharp"
print "edges of visibility are cut at n as slices are: the ringing that the paper's pictures show too."
