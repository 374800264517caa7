-- Virtual lights in pictures: a Cornell box with one bounce of them beside paths; the same few lights by all methods; a corner
-- from near; grids of whole lights and of their far parts; what lights send over a glossy floor; a lamp that moves.
--
--     ylm run examples/13_virtual_lights.lua [--out DIR] [--only NAME] [--width N] [--samples N] [--lights N] [--few N]
--
-- Writes virtual_lights.png, virtual_lights_methods.png, virtual_lights_corner.png, virtual_lights_grids.png,
-- virtual_lights_lobes.png and virtual_lights_moving.png; --only bounce, methods, corner, grids, lobes or moving writes one.
-- Coverage and time over the number of lights are pictures of examples/papers/hvl_2022_fig8.lua and hvl_many.lua.
-- Metres, degrees, W sr^-1 m^-2; y is up.

local ylm = require "ylm"
local core = require "ylm.c.core"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "common.lua"), dofile(here .. "papers/hvl_scenes.lua")
local option = common.options { out = "out", only = "", width = 280, samples = 256, lights = 2000, few = 100 }
local size = { option.width, option.width }
local parts = {} -- name -> what writes the picture

--- Results of make(), and its seconds behind the first.
local function timed(make)
  local start = core.seconds()
  local a, b, c = make()
  if a == nil then error(tostring(b), 0) end
  return a, core.seconds() - start, b, c
end


--- Differences of luminance of two images, relative to the mean of the second; their root mean square. Pixels that show some of
-- a lamp are left out.
local function differences(image, truth, lamp)
  local wanted = common.luminance(truth:layer())
  local values = (common.luminance(image:layer()) - wanted) / wanted:mean()
  if lamp then values = values * lamp[{ {}, {}, 1 }]:less_equal(0) end
  return values, math.sqrt((values ^ 2):mean())
end

local function shown(image, words, exposure)
  return { image = image, tone = "hable", exposure = exposure or 1.5, caption = words }
end

local shared = { size = size, samples = 8, light_samples = 32 }
local with = common.adding_to(shared)
local box = rooms.cornell {}

-- One bounce ---------------------------------------------------------------------------------

function parts.bounce()
  local direct, direct_seconds = timed(function() return box:render(with { bounces = 0 }) end)
  local emitted
  local bounced, bounced_seconds, report = timed(function()
    local lights
    lights, emitted = assert(box:virtual_lights { count = option.lights })
    return box:render(with { bounced = lights, virtual = { shadows = "centre" } })
  end)
  local truth, truth_seconds = timed(function() return box:pathtrace { size = size, samples = option.samples, bounces = 1 } end)
  local values, rms = differences(bounced, truth, direct:layer "emitter")
  local power = emitted.power
  print(("%d lights, %.1f million pairs; of %.2f W (red) that the lamp emits, %.2f W land and %.2f W are reflected"):format(
    report.virtual.lights, report.virtual.pairs / 1e6, power.emitted[1], power.landed[1], power.reflected[1]))
  print(("root mean square of the difference: %.3f of the mean luminance"):format(rms))
  common.save(ylm.figure {
    title = "A Cornell box with one bounce",
    rows = { { shown(direct, ("direct light, %.1f s"):format(direct_seconds)),
      shown(bounced, ("and %d virtual lights, %.1f s"):format(report.virtual.lights, bounced_seconds)),
      shown(truth, ("paths of one bounce, %.1f s"):format(truth_seconds)),
      { values = values, caption = "virtual lights less paths" } } },
    bar = { range = { -0.5, 0.5 }, map = "coolwarm", label = "difference, of the mean luminance" },
    caption = ("Rays to the middles of lights. Seconds on two cores. Root mean square difference %.3f of the mean."):format(rms),
  }, option.out .. "virtual_lights.png")
end

-- Few lights by each method ---------------------------------------------------------

--- Pictures of a view's bounce by `list` of { name, lights, options }, with their errors in captions.
local function compared(view, truth, list, exposure, lamp)
  local row = common.table { { "method", "%-24s" }, { "ns a pair", "%9.1f" }, { "rms", "%7.3f" } }
  local items = {}
  for i, m in ipairs(list) do
    local o = m[3]
    o.by, o.bounced, o.virtual, o.layers = "none", m[2], { shadows = "centre", sums = not o.rival and "all" or nil }, false
    local image, facts = view:render(o)
    if not image then error(facts, 0) end
    local _, off = differences(image, truth, lamp)
    row { m[1], facts.virtual.ns_per_pair, off }
    items[i] = shown(image, ("%s: %.2f"):format(m[1], off), exposure)
  end
  return items
end

--- A light's place as a small lamp, to be drawn.
local function dots(lights, radius)
  local lit = {}
  local at, _, _, emission = lights:arrays()
  for i = 1, #at do
    local c = {}
    for k = 1, 3 do c[k] = math.max(0, emission:get(i, k, 1)) * 100 end
    lit[i] = ylm.sphere_light { at = { at:get(i, 1), at:get(i, 2), at:get(i, 3) }, radius = radius, radiance = c }
  end
  return lit
end

function parts.methods()
  local view = assert(box:prepare { size = size, samples = 4 })
  local o = { count = option.few, particles = 20 * option.few }
  local few = assert(box:virtual_lights(o))
  local many = assert(box:virtual_lights { count = 20 * option.few })
  o.profile = "cap"
  local caps = assert(box:virtual_lights(o))
  local bounce = assert(box:pathtrace { size = size, samples = 4 * option.samples, reflections = { 2, 2 } })
  local lit = assert(view:render { lamps = dots(few, 0.014) })
  local items = compared(view, bounce, {
    { "points", few, { rival = { "vpl", clamp = "none" } } },
    { "points, clamped", few, { rival = { "vpl" } } },
    { "clamped, compensated", few, { rival = { "vpl", compensate = 8 } } },
    { "spheres", few, { rival = { "vsl" } } },
    { "Gaussians", many, { rival = { "vsgl", groups = option.few } } },
    { "harmonics, cap", caps, {} },
    { "harmonics, gauss", few, {} },
  }, 3, lit:layer "emitter")
  common.save(ylm.figure {
    title = ("The bounce of light by %d virtual lights"):format(few.count),
    rows = { { items[1], items[2], items[3] },
      { items[4], items[5], shown(lit, ("direct light and the %d lights"):format(few.count), 0.7) },
      { items[6], items[7], shown(bounce, "paths", 3) } },
    caption = "Numbers: root mean square difference from paths, of the mean luminance. All have rays to the middles of lights. "
      .. "Each Gaussian stands for 20 lights.",
  }, option.out .. "virtual_lights_methods.png")
end

-- A corner from near -------------------------------------------------------------------------

function parts.corner()
  local white = ylm.matte { albedo = { 0.75, 0.68, 0.58 } }
  local corner = ylm.scene "a corner" {
    camera = ylm.camera { from = { 0.05, 0.34, 0.8 }, at = { -1, 0.17, 0 }, fov = 36 },
    geometry = { ylm.quad { corner = { -1, 0, 1.5 }, u = { 3, 0, 0 }, v = { 0, 0, -3 }, material = white },
      ylm.quad { corner = { -1, 0, 1.5 }, u = { 0, 0, -3 }, v = { 0, 2, 0 }, material = white } },
    lights = ylm.spot_light { at = { -0.9, 3, 0 }, to = { 0.3, 0, 0 }, angle = 50, intensity = 12 }, -- it misses the wall
  }
  local view = assert(corner:prepare { size = size, samples = 4 })
  local function lights(profile) return assert(corner:virtual_lights { distribution = "grid", count = 400,
    profile = profile }) end
  local gauss, cap = lights "gauss", lights "cap"
  local truth = assert(corner:pathtrace { size = size, samples = 4 * option.samples, reflections = { 2, 2 } })
  local items = compared(view, truth, {
    { "points", gauss, { rival = { "vpl", clamp = "none" } } }, { "points, clamped", gauss, { rival = { "vpl" } } },
    { "spheres", cap, { rival = { "vsl" } } }, { "harmonics, cap", cap, {} }, { "harmonics, gauss", gauss, {} },
  }, 3)
  items[6] = shown(truth, "paths", 3)
  common.save(ylm.figure { title = ("A wall over a lit floor, from near: its bounce by %d virtual lights"):format(gauss.count),
    rows = { { items[1], items[2], items[3] }, { items[4], items[5], items[6] } },
    caption = "The floor gets no light from itself. Within half a spacing of the corner no profile is right: more lights "
      .. "are for that. Numbers: root mean square difference from paths, of the mean.",
  }, option.out .. "virtual_lights_corner.png")
end

-- Grids of whole lights and of far parts -------------------------------------------------------------------

function parts.grids()
  local lights = assert(box:virtual_lights { count = option.lights, particles = 20 * option.lights })
  local far = lights:split {}
  local view = assert(box:prepare { size = size, samples = 1 })
  local items = {}
  for i, case in ipairs { { "whole lights", lights }, { "far parts", far } } do
    local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = 4, depth = 6, tolerance = 0.02, measure = "irradiance" }, case[2],
      { occupied = view }))
    local s = grid.stats
    print(("%-12s core %.3f m, %s points, error %.4f (tolerance 0.02)%s"):format(case[1], far.core, common.thousands(s.points),
      s.error, s.met and "" or ", not met"))
    items[#items + 1] = { image = ylm.view { grid, quantity = "level", boxes = { occupied = true, shrink = 0.06 }, range = { 2,
      6 },
      camera = box.camera, bar = i == 2, frame = false, background = "white", size = { i == 2 and 620 or 520, 520 } },
      caption = ("%s: %s points, error %.1f %%"):format(case[1], common.thousands(s.points), 100 * s.error) }
  end
  common.save(ylm.figure { title = ("Adaptive grids of %d virtual lights, tolerance 2 %% of irradiance"):format(lights.count),
    rows = { items }, caption = ("Voxels that hold shading points, to depth 6. Far parts have a core of %.2f m; the rest "
      .. "is summed at the points."):format(far.core) }, option.out .. "virtual_lights_grids.png")
end

-- Lobes of lights ----------------------------------------------------------------------------------------

function parts.lobes()
  local floor = ylm.ggx { alpha = 0.3, f0 = { 0.95, 0.7, 0.35 } }
  local room = ylm.scene "a glossy floor" {
    camera = ylm.camera { from = { 0.4, 1.5, 3.1 }, at = { 0.1, 0.3, 0 }, fov = 44 },
    geometry = { ylm.quad { corner = { -1.6, 0, 1.2 }, u = { 3.2, 0, 0 }, v = { 0, 0, -2.4 }, material = floor },
      ylm.quad { corner = { -1.6, 0, -1.2 }, u = { 3.2, 0, 0 }, v = { 0, 1.4, 0 },
        material = ylm.matte { albedo = { 0.35, 0.5, 0.65 } } } },
    lights = ylm.spot_light { at = { -1.6, 1.5, 0.9 }, to = { 0.1, 0.1, -0.5 }, angle = 62, intensity = 10 },
  }
  local lights, report = assert(room:virtual_lights { distribution = "grid", count = 64, degree = 8 })
  local at, normal, _, emission = lights:arrays()
  local around, rings, directions = 48, 24, {}
  for k = 0, rings do
    for i = 0, around do
      local v, u = math.pi * k / rings, 2 * math.pi * i / around
      directions[#directions + 1] = { math.sin(v) * math.cos(u), math.cos(v), math.sin(v) * math.sin(u) }
    end
  end
  directions = ylm.array(directions)
  local basis = ylm.sh.eval(lights.degree, directions)               -- [directions][coefficients]
  local triangles = {}
  for k = 0, rings - 1 do
    for i = 1, around do
      local a = k * (around + 1) + i
      triangles[#triangles + 1] = { a, a + 1, a + around + 2 }
      triangles[#triangles + 1] = { a, a + around + 2, a + around + 1 }
    end
  end
  local weights = { 0.2126, 0.7152, 0.0722 }                         -- of luminance
  local meshes, sent, largest = {}, {}, 0                            -- sent: intensities [directions][3] of each light
  for i = 1, lights.count do
    local cosine = (directions * normal[i]):sum { axis = 2, keep = true }:clamp(0)
    local series = (emission[i]:reshape { 1, 3, basis.shape[2] } * basis:reshape { #basis, 1, basis.shape[2] }):sum(3)
    sent[i] = (cosine * series):clamp(0)
    largest = math.max(largest, (sent[i] * weights):sum(2):max())
  end
  for i = 1, lights.count do
    local radius = 0.02 + 0.5 / largest * (sent[i] * weights):sum { axis = 2, keep = true }
    local top = ylm.stack({ sent[i][{ {}, 1 }]:clamp(sent[i][{ {}, 2 }]), sent[i][{ {}, 3 }] }):max(1):clamp(1e-9)
    meshes[i] = { ylm.mesh { vertices = at[i] + radius * directions, triangles = triangles },
      colours = sent[i] / top:reshape { #top, 1 } }
  end
  local picture = ylm.view { scene = room, meshes = meshes, size = { 540, 360 }, bar = false, frame = false,
    background = "white" }
  local direct = assert(room:render { size = { 540, 360 }, samples = 8, gloss = "rays", bounces = 0 })
  print(("%d lights of degree %d; their slices miss %.0f %% of what the floor sends"):format(lights.count, lights.degree,
    100 * report.slices.missed))
  common.save(ylm.figure { title = "What virtual lights send over a glossy floor", rows = { { { image = direct,
    tone = "hable",
    exposure = 1, caption = "direct light" }, { image = picture, caption = "intensity of each light by direction" } } },
    caption = ("GGX of alpha 0.3, fitted slices of degree %d; the wall is matte and sends a cosine."):format(lights.degree) },
    option.out .. "virtual_lights_lobes.png")
end

-- A lamp that moves ------------------------------------------------------------------------------------------

function parts.moving()
  local above, below = {}, {}
  local small = { math.floor(0.72 * size[1]), math.floor(0.72 * size[2]) }
  for i = 0, 4 do
    local t = i / 4
    local scene = rooms.cornell { lamp = "spot", to = { 1.3 * (2 * t - 1), 0.55, -0.35 } }
    local view = assert(scene:prepare { size = small, samples = 4 })
    local lights, report = assert(scene:virtual_lights { count = option.lights / 2 })
    local bounce, facts = assert(view:render { by = "none", bounced = lights, virtual = { shadows = "centre" },
      layers = false })
    local all = assert(view:render { layers = false, bounced = view.scene:virtual_lights { count = option.lights / 2 },
      virtual = { shadows = "centre" } })
    print(("frame %d: %d lights, %.0f ms emission, %.0f ms gathering"):format(i + 1, lights.count,
      1000 * (report.seconds.trace + report.seconds.radius), 1000 * facts.seconds.bounced))
    above[i + 1], below[i + 1] = shown(all, nil, 1.5), shown(bounce, nil, 3)
  end
  common.save(ylm.figure { title = "A lamp that moves: colour that bleeds from walls", rows = { above, below },
    caption = "Above direct light and one bounce, below the bounce alone. A particle keeps its random numbers: lights move "
      .. "with the lamp and do not flicker." }, option.out .. "virtual_lights_moving.png")
end

for _, name in ipairs { "bounce", "methods", "corner", "grids", "lobes", "moving" } do
  if option.only == "" or option.only == name then parts[name]() end
end
if option.only ~= "" and not parts[option.only] then error("--only: no picture " .. option.only, 0) end
