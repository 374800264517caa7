-- Frames under one lamp that moves, its bounce by virtual lights merged of particles: milliseconds of processor time of each
-- part, one thread, median and least of the frames. A room with a knot, 10,000 particles, some 2,000 lights.
--
--     build/ylm run spec/bench/virtual_frames.lua [frames]

local ylm = require "ylm"

ylm.on_warning(false)
local threads, frames = 1, tonumber(arg[1] or 7)
local white = ylm.matte { albedo = { 0.74, 0.70, 0.66 } }
local geometry = {
  ylm.box { bounds = { { -3, -2, -3 }, { 3, 2, 3 } }, material = ylm.matte { albedo = { 0.62, 0.6, 0.55 } } },
  ylm.knot { p = 2, q = 3, radius = 1.2, minor = 0.5, tube = 0.25, divide = { 150, 40 }, material = white },
}

local function scene_of(frame)
  local turn = 0.02 * frame
  return ylm.scene "frames" { geometry = geometry,
    camera = ylm.camera { from = { 0, 0.5, 2.9 }, at = { 0, 0, 0 }, fov = 70 },
    lights = ylm.sphere_light { at = { 2 * math.cos(turn), 1.2, 2 * math.sin(turn) }, radius = 0.15, radiance = 30 } }
end

local still = scene_of(0)
local view = assert(still:prepare { size = { 400, 250 }, samples = 1, threads = threads })
local first = select(2, assert(still:virtual_lights { merge = 2000, particles = 10000 }))
print(("%d shading points, %d lights of cells of %g, %d frames"):format(view.stats.points, first.lights, first.merged.cell,
  frames))
print(("%-44s %9s %9s"):format("ms", "median", "least"))

local order, parts = {}, {}
local function note(name, seconds)
  if not parts[name] then order[#order + 1], parts[name] = name, {} end
  table.insert(parts[name], 1000 * seconds)
end

local function timed(name, f, ...)
  local start = os.clock()
  local a, b = f(...)
  note(name, os.clock() - start)
  return assert(a, b), b
end

local bounds = { { -3, -2, -3 }, { 3, 2, 3 } }
for frame = 1, frames do
  local scene = scene_of(frame)
  timed("the scene with its lamp elsewhere", require "ylm.trace".trace, "frames", scene)
  local lights = timed("particles, merged, and their radii", scene.virtual_lights, scene,
    { merge = 2000, particles = 10000, cell = first.merged.cell, threads = threads })
  local far, near = timed("split", lights.split, lights, {})
  local grid = timed("far part: bake of 15 x 10 x 15 cells", ylm.bake,
    ylm.uniform_grid { bounds = bounds, cells = { 15, 10, 15 }, lmax = 4 }, far, { threads = threads })
  timed("grid and near part at the points", view.render, view,
    { grid = grid, near_lights = near, layers = false, threads = threads })
  timed("direct light alone", view.render, view, { light_samples = 1, layers = false, threads = threads })
  timed("instead: with the bounce, far parts in levels", view.render, view,
    { light_samples = 1, layers = false, threads = threads, bounced = lights })
  timed("instead: each light at each point", view.gather, view, { lights = lights, layers = false, threads = threads })
  timed("instead: those of 4 x 4 pixels", view.gather, view,
    { lights = lights, subset = "interleaved", layers = false, threads = threads })
  timed("  with a ray to each", view.gather, view,
    { lights = lights, subset = "interleaved", shadows = "centre", layers = false, threads = threads })
end
for _, name in ipairs(order) do
  local list = parts[name]
  table.sort(list)
  print(("%-44s %9.1f %9.1f"):format(name, list[math.floor((#list + 1) / 2)], list[1]))
end
