-- Light that bounces in a room lit from behind a screen. Pictures are by direct light alone, with a grid of indirect light, with
-- light gathered pixel by pixel along links, and by paths. Printed: how far each is from the paths, and how long it took.
--
--     ylm run examples/12_bouncing_light.lua [--out DIR] [--width N] [--samples N] [--tolerance X]
--
-- Writes bouncing_light.png and bouncing_light_grids.png (where the grids of indirect and of direct light err: VTK).
-- Metres, degrees, W sr^-1 m^-2; y is up.

local ylm = require "ylm"
local core = require "ylm.c.core"

local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")
local option = common.options { out = "out", width = 320, samples = 128, tolerance = 0.1 }
local size = { option.width, math.floor(option.width * 0.7) }

local white = ylm.matte { albedo = 0.78 }
local function wall(lo, hi, material) return ylm.box { bounds = { lo, hi }, material = material or white } end

local scene = ylm.scene "A room with a screen" {
  camera = ylm.camera { from = { 0.3, 1.35, 4.3 }, at = { 0.02, 0.98, 0 }, fov = 38 },
  geometry = {
    wall({ -2.3, -0.3, -2.3 }, { 2.3, 0, 2 }, ylm.matte { albedo = { 0.62, 0.55, 0.46 } }), -- floor
    wall({ -2.3, 2.2, -2.3 }, { 2.3, 2.5, 2 }), -- ceiling
    wall({ -2.3, 0, -2.3 }, { 2.3, 2.2, -2 }), -- the back
    wall({ -2.3, 0, -2 }, { -2, 2.2, 2 }, ylm.matte { albedo = { 0.75, 0.22, 0.1 } }), -- left
    wall({ 2, 0, -2 }, { 2.3, 2.2, 2 }, ylm.matte { albedo = { 0.1, 0.35, 0.5 } }), -- right
    wall({ -1.15, 0, -1 }, { -0.95, 1.75, 0.9 }), -- the screen
    ylm.knot { at = { 0.15, 1.0, -0.1 }, p = 2, q = 3, radius = 0.36, minor = 0.16, tube = 0.1, divide = { 240, 24 },
      rotate = { axis = { 0, 1, 0 }, angle = 20 }, material = ylm.matte { albedo = { 0.8, 0.78, 0.72 } } },
    ylm.box { bounds = { { -0.2, 0, -0.45 }, { 0.5, 0.42, 0.25 } }, divide = 4,
      material = ylm.matte { albedo = { 0.75, 0.6, 0.2 } } },
    ylm.sphere { at = { 1.25, 0.3, -0.7 }, scale = 0.3, divide = { 48, 24 },
      material = ylm.matte { albedo = { 0.3, 0.5, 0.25 } } },
  },
  lights = {
    ylm.sphere_light { at = { -1.5, 1.2, 0.1 }, radius = 0.14, radiance = { 60, 52, 42 } },
    ylm.sphere_light { at = { 1.55, 1.95, -1.5 }, radius = 0.07, radiance = { 14, 16, 20 } },
  },
}

-- Four pictures ------------------------------------------------------------------------------

local shared = { size = size, samples = 8, light_samples = 48 }
local with = common.adding_to(shared)

--- Results of make(), and its seconds behind the first.
local function timed(make)
  local start = core.seconds()
  local a, b, c = make()
  if a == nil then error(tostring(b), 0) end
  return a, core.seconds() - start, b, c
end

local direct, direct_seconds = timed(function() return scene:render(with { bounces = 0 }) end)
local lit, lit_seconds = timed(function() return scene:links({ spacing = 0.1, rays = 128 }):radiosity() end)
print(("%d elements: links and %d bounces in %.1f s; balance %.1e"):format(lit.links.stats.elements, lit.stats.bounces,
  lit_seconds, lit.stats.balance))
local gathered, gathered_seconds = timed(function() return scene:render(with { bounced = lit }) end)

local view = assert(scene:prepare { size = size, samples = 1 })
local form = { lmax = 2, tolerance = option.tolerance, depth = 5,
  bounds = { { -2.2, -0.2, -2.2 }, { 2.2, 2.4, 2.2 } } } -- the outermost probes lie in the walls, and are filled from inside
local grid, grid_seconds = timed(function() return ylm.bake(ylm.adaptive_grid(form), lit, { occupied = view }) end)
print(("indirect light: %d probes in %.1f s, tolerance %g %s"):format(grid.stats.points, grid_seconds, option.tolerance,
  grid.stats.met and "met" or "not met"))
local by_grid, by_grid_seconds = timed(function() return scene:render(with { bounced = grid }) end)
local truth, truth_seconds = timed(function() return scene:pathtrace { size = size, samples = option.samples } end)

local row = common.table { { "picture", "%-34s" }, { "seconds", "%7.1f" }, { "PSNR dB", "%7.1f" }, { "relmse", "%9.2e" } }
local pictures = {
  { "direct light", direct, direct_seconds },
  { "and a grid of indirect light", by_grid, by_grid_seconds + lit_seconds + grid_seconds },
  { "and light gathered along links", gathered, gathered_seconds + lit_seconds },
  { "paths", truth, truth_seconds },
}

local wanted = common.luminance(truth:layer())

--- Differences of luminance from the paths, relative to the mean of these.
local function differences(image) return (common.luminance(image:layer()) - wanted) / wanted:mean() end

local above, below = {}, {}
for i, p in ipairs(pictures) do
  local m = i < #pictures and assert(p[2]:compare(truth)) or {}
  row { p[1], p[3], m.psnr, m.relmse }
  above[i] = { image = p[2], tone = "hable", exposure = 2, caption = ("%s, %.1f s"):format(p[1], p[3]) }
  if m.psnr then below[i] = { values = differences(p[2]), caption = ("%.1f dB"):format(m.psnr) } end
end
below[#pictures] = { values = differences(truth), caption = ("%d paths a pixel"):format(option.samples) }

common.save(ylm.figure {
  title = "A room lit from behind a screen",
  rows = { above, below },
  bar = { range = { -0.5, 0.5 }, map = "coolwarm", label = "difference from paths, of the mean luminance" },
  caption = "Above: pictures and their seconds on two cores, links and bakes included. Below: luminance less that of paths.",
}, option.out .. "bouncing_light.png")

-- Where the grids err ------------------------------------------------------------------------

local lamps = assert(ylm.bake(ylm.adaptive_grid(form), lit:field { quantity = "direct" }, { occupied = view }))
local function volume(g, name)
  return ylm.view { g, scene = scene, opacity = 0.25, quantity = "error", volume = true, levels = { occupied = true },
    title = ("%s: %d probes"):format(name, g.stats.points) }
end
common.save(ylm.figure {
  title = "Error of the octree's leaves by their Hessians",
  rows = { { { image = volume(grid, "indirect light") }, { image = volume(lamps, "direct light with shadows") } } },
}, option.out .. "bouncing_light_grids.png")
