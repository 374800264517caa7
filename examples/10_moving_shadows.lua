-- Bodies that move between lights and a floor: their shadows in probes, frame by frame, and the bodies, which shade themselves.
--
--     ylm run examples/10_moving_shadows.lua                              12 small frames and a contact sheet in out/
--     ylm run examples/10_moving_shadows.lua --width 960 --height 540 --frames 60
--
-- Once: camera rays and transfer vectors of all that stands still, and a light field of what each body hides, as a grid.
-- A frame is
--   shade:move    bodies at new places,
--   grid:update   light behind them at the probes of surfaces in sight: it goes on from the last bake,
--   view:render   shading by the grid; bodies are drawn over it, each shaded by its own transfer vectors, turned with it.
-- --truth adds one frame by rays, beside which the middle frame is judged. --vertices asks for light at shading points
-- instead of probes, as the papers do at vertices.
-- Leaves in out/: shadows_01.png, ... and shadows.png, the contact sheet. Times are printed by stage.

local ylm = require "ylm"
local core = require "ylm.c.core"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 480, height = 270, samples = 4, frames = 12, lmax = 9, tolerance = 0.05,
  body = 0.03, exposure = 0.55, rays = 128, truth = false, vertices = false, nopictures = false, quick = false }
if option.quick then
  option.width, option.height, option.frames, option.lmax, option.body, option.rays = 96, 54, 2, 4, 0.1, 16
end
local size = { option.width, option.height }

--- Stops with the message of a call that failed.
local function good(x, message, code)
  if x == nil then error(("%s (%s)"):format(message, code or "?"), 0) end
  return x, message
end

-- Bodies: what they look like and what they hide ---------------------------------------------------

--- A closed mesh of n sides: a prism, or with `top` 0 a pyramid; each triangle is divided into four, `divide` times.
local function column(n, radius, height, top, divide, material)
  local vertices, triangles = { { 0, -height / 2, 0 }, { 0, height / 2, 0 } }, {}
  for i = 0, n - 1 do
    local x, z = radius * math.cos(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n)
    vertices[#vertices + 1] = { x, -height / 2, z }
    if top > 0 then vertices[#vertices + 1] = { top * x, height / 2, top * z } end
  end
  local step = top > 0 and 2 or 1
  for i = 0, n - 1 do
    local a, b = 3 + step * i, 3 + step * ((i + 1) % n)
    triangles[#triangles + 1] = { 1, a, b }
    if top > 0 then
      for _, t in ipairs { { a, a + 1, b + 1 }, { a, b + 1, b }, { 2, b + 1, a + 1 } } do triangles[#triangles + 1] = t end
    else triangles[#triangles + 1] = { 2, b, a } end
  end
  -- faces have corners of their own, so that they are flat, and are divided, since light is asked at vertices
  local flat, own = {}, {}
  local function add(a, b, c, depth)
    local function half(u, v) return { (u[1] + v[1]) / 2, (u[2] + v[2]) / 2, (u[3] + v[3]) / 2 } end
    if depth > 0 then
      local ab, bc, ca = half(a, b), half(b, c), half(c, a)
      add(a, ab, ca, depth - 1)
      add(ab, b, bc, depth - 1)
      add(ca, bc, c, depth - 1)
      return add(ab, bc, ca, depth - 1)
    end
    local first = #flat + 1
    flat[first], flat[first + 1], flat[first + 2] = a, b, c
    own[#own + 1] = { first, first + 1, first + 2 }
  end
  for _, t in ipairs(triangles) do add(vertices[t[1]], vertices[t[2]], vertices[t[3]], divide) end
  return ylm.mesh { vertices = flat, triangles = own, material = material }
end

local function paint(r, g, b) return ylm.matte { albedo = { r, g, b } } end

local red, gold, blue, green = paint(0.75, 0.22, 0.12), paint(0.85, 0.6, 0.12), paint(0.14, 0.36, 0.62), paint(0.2, 0.5, 0.24)

--- Name -> the body's surface, and the solid that hides light: the same with fewer triangles.
local bodies = {
  cube = { ylm.box { scale = 0.9, divide = 6, material = red }, ylm.box { scale = 0.9 } },
  ball = { ylm.sphere { radius = 0.5, divide = { 40, 20 }, material = paint(0.8, 0.78, 0.74) } },
  pyramid = { column(4, 0.7, 1.0, 0, 2, gold), column(4, 0.7, 1.0, 0, 0) },
  column = { column(6, 0.4, 1.4, 1, 2, blue), column(6, 0.4, 1.4, 1, 0) },
  plate = { ylm.box { scale = { 1.5, 0.18, 0.8 }, divide = 6, material = green }, ylm.box { scale = { 1.5, 0.18, 0.8 } } },
}

local started = core.seconds()
local hides, bytes = {}, 0

--- A solid's visibility as a grid.
local function remembered(shape)
  local probes = ylm.adaptive_grid { lmax = option.lmax, depth = 10, tolerance = option.body, channels = "luminance" }
  local grid = good(ylm.bake(probes, ylm.occluder { geometry = shape }))
  bytes = bytes + grid.stats.bytes
  return grid
end
for name, body in pairs(bodies) do
  hides[name] = body[2] and remembered(body[2]) or ylm.occluder { radius = 0.5 }
end
local ground, pillar = remembered(ylm.box { scale = { 12, 1, 12 } }), remembered(ylm.box { scale = { 0.5, 1.4, 0.5 } })
local fields = core.seconds() - started

--- Places in a frame; the film is a loop of 60 frames.
local function places(frame)
  local t = 2 * math.pi * frame / 60
  local function on_circle(phase, radius, height) -- at an angle of the loop
    local a = t + 2 * math.pi * phase
    return { radius * math.cos(a), height, radius * math.sin(a) }
  end
  local function spin(axis, turns, phase) return { axis = axis, angle = 360 * turns * frame / 60 + (phase or 0) } end
  return {
    cube = { at = on_circle(0, 1.5, 0.95 + 0.2 * math.sin(t)), rotation = { spin({ 1, 0.3, 0.2 }, 1, 30) } },
    ball = { at = on_circle(0.2, 1.6, 0.85 + 0.3 * math.sin(2 * t)) },
    pyramid = { at = on_circle(0.4, 1.5, 0.9), rotation = { spin({ 0, 1, 0 }, -2), { axis = { 1, 0, 1 }, angle = 20 } } },
    column = { at = on_circle(0.6, 1.6, 1.05), rotation = { spin({ 0.5, 0, 1 }, 1, 20) } },
    plate = { at = { 0.2 * math.sin(t), 1.5, 0.2 * math.cos(t) }, rotation = { spin({ 0.2, 1, 0.1 }, 1, 10) } },
  }
end

-- The scene -----------------------------------------------------------------------------------------

local clay = paint(0.72, 0.70, 0.66)
local scene = ylm.scene "Moving shadows" {
  camera = ylm.camera { from = { 0, 3.3, 6.2 }, at = { 0, 0.55, 0 }, fov = 38 },
  geometry = {
    ylm.quad { corner = { -6, 0, 6 }, u = { 12, 0, 0 }, v = { 0, 0, -12 }, material = clay },
    ylm.box { at = { -2.6, 0.7, -1.6 }, scale = { 0.5, 1.4, 0.5 }, material = clay },
    ylm.sphere { at = { 2.7, 0.45, -1.5 }, radius = 0.45, divide = { 48, 24 }, material = clay },
  },
  lights = {
    ylm.environment_light { sky = { kind = "overcast", zenith = { 0, 1, 0 } }, scale = 0.45 },
    ylm.environment_light { radiance = { 0.02, 0.05, 0.13 } },
    ylm.sphere_light { at = { 2.6, 4.6, 2.2 }, radius = 0.5, radiance = { 62, 52, 38 } },
  },
  background = { 0.35, 0.40, 0.48 },
}
-- Casters without a name stand still: bodies are in their shadow too. Surfaces that stand still know them by transfer vectors.
local casters = {
  ylm.caster { hides = ground, at = { 0, -0.501, 0 } },
  ylm.caster { hides = pillar, at = { -2.6, 0.7, -1.6 } },
  ylm.caster { hides = ylm.occluder { radius = 0.45 }, at = { 2.7, 0.45, -1.5 } },
}
for name, place in pairs(places(0)) do
  casters[name] = ylm.caster { hides = hides[name], surface = bodies[name][1], at = place.at, rotation = place.rotation }
end
local all = ylm.shadowed { lights = scene.lights, casters = casters }
local shade = all:without() -- those with a name
local view = good(scene:prepare { size = size, samples = option.samples, transfer_samples = option.rays, lmax = option.lmax,
  visibility = "transfer", occlusion_distance = 6 })
local prepared = core.seconds() - started - fields
print(("%d x %d, %s shading points: %.1f s; fields of %d solids: %.1f s, %.1f MB; lmax %d"):format(size[1], size[2],
  common.thousands(view.stats.points), prepared, 6, fields, bytes / 2 ^ 20, option.lmax))

-- Frame by frame --------------------------------------------------------------------------------------

local probes = ylm.adaptive_grid { bounds = { { -6.1, -0.1, -6.1 }, { 6.1, 6.1, 6.1 } }, lmax = option.lmax, depth = 9,
  tolerance = option.tolerance }
local row = common.table { { "frame", "%5d" }, { "probes", "%6d" }, { "error", "%7.4f" }, { "bake ms", "%8.1f" },
  { "shade ms", "%8.1f" }, { "bodies ms", "%9.1f" }, { "image ms", "%8.1f" }, { "cpu ms", "%7.1f" } }
local sum, grid, shown, judged, spare = { bake = 0, shade = 0, bodies = 0, image = 0, cpu = 0 }, nil, {}, nil, nil
local middle = math.floor(option.frames / 2)
for frame = 0, option.frames - 1 do
  local clock, begin = os.clock(), core.seconds()
  local number = frame * math.max(1, math.floor(60 / option.frames))
  all:move(places(number))
  if not option.vertices then
    if grid then good(grid:update(shade, { octree = "follow" }))
    else grid = good(ylm.bake(probes, shade, { occupied = view })) end
  end
  local baked = core.seconds()
  local picture, report = good(view:render { grid = grid or shade, bodies = all, layers = false, out = spare })
  local cpu, took = 1e3 * (os.clock() - clock), report.bodies.seconds
  local whole, bake = core.seconds() - begin, 1e3 * (baked - begin)
  local drawn, light = 1e3 * (took.light + took.image), 1e3 * report.seconds.light
  local image = 1e3 * whole - bake - light - drawn
  row { frame + 1, grid and grid.stats.points, grid and grid.stats.error, bake, light, drawn, image, cpu }
  if frame > 0 then -- the first finds the transfer vectors of the bodies
    sum.bake, sum.shade, sum.bodies = sum.bake + bake, sum.shade + light, sum.bodies + drawn
    sum.image, sum.cpu = sum.image + image, sum.cpu + cpu
  end
  spare = picture
  if not option.nopictures then
    good(picture:save(("%sshadows_%02d.png"):format(option.out, frame + 1), { exposure = option.exposure, tone = "hable" }))
  end
  if frame % math.max(1, math.floor(option.frames / 6)) == 0 and #shown < 6 or frame == middle and option.truth then
    if #shown < 6 then shown[#shown + 1] = { picture, number } end
    if frame == middle then judged = picture end
    spare = nil
  end
end
if option.frames > 1 then
  local n = option.frames - 1
  local whole = (sum.bake + sum.shade + sum.bodies + sum.image) / n
  print(("a frame: bake %.1f + shade %.1f + bodies %.1f + image %.1f = %.1f ms, %.1f frames a second; %.1f ms of processor time")
    :format(sum.bake / n, sum.shade / n, sum.bodies / n, sum.image / n, whole, 1e3 / whole, sum.cpu / n))
end

-- Beside rays -------------------------------------------------------------------------------------------

if option.truth then
  all:move(places(middle * math.max(1, math.floor(60 / option.frames))))
  local still = ylm.scene "still" { like = scene, geometry = { scene.geometry, all:surfaces() } }
  local truth = good(still:render { bounces = 0, size = size, samples = option.samples, light_samples = 256 })
  good(truth:save(option.out .. "shadows_truth.png", { exposure = option.exposure, tone = "hable" }))
  local a, b = judged:layer "radiance", truth:layer "radiance"
  local off, mean, n = 0, 0, 0
  for y = 1, size[2] do
    for x = 1, size[1] do
      for c = 1, 3 do
        off, mean, n = off + (a:get(y, x, c) - b:get(y, x, c)) ^ 2, mean + b:get(y, x, c), n + 1
      end
    end
  end
  print(("frame %d beside rays, 256 a point: rms %.1f %% of the mean radiance"):format(middle + 1,
    100 * math.sqrt(off / n) / (mean / n)))
end

-- The contact sheet ----------------------------------------------------------------------------------------

if #shown > 0 and not option.nopictures then
  local columns, gap = math.min(3, #shown), 4
  local rows = math.ceil(#shown / columns)
  local sheet = good(ylm.image { size = { columns * (size[1] + gap) - gap, rows * (size[2] + gap) - gap } })
  sheet:fill(1, 1, sheet.size[1], sheet.size[2], { 0.02, 0.02, 0.02 })
  for k, each in ipairs(shown) do
    local x, y = (k - 1) % columns * (size[1] + gap) + 1, math.floor((k - 1) / columns) * (size[2] + gap) + 1
    sheet:paste(each[1], x, y)
    sheet:text(x + 8, y + size[2] - 26, ("frame %d of 60"):format(each[2] + 1), { scale = 2, colour = 0.02 })
  end
  good(sheet:save(option.out .. "shadows.png", { exposure = option.exposure, tone = "hable" }))
  print(("%sshadows.png and %d frames: %.0f s"):format(option.out, option.frames, core.seconds() - started))
end
