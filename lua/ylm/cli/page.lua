--- ylm page scene.lua -o room.html

local core = require "ylm.c.core"
local lit_scene = require "ylm.cli.lit_scene"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local TOLERANCE = 0.05 -- of a bake that nobody asked for otherwise
local LIGHT_TOLERANCE = 0.1
local PRECISIONS = { half = true, float = true, byte = true, few = true }

--- The probes to bake: those of the scene, with the tolerance and depth of the command line.
local function probes_of(ylm, scene, given)
  local own = scene.probes
  if own and not given.tolerance and not given.depth then
    if own.bricks then
      status.stop(status.usage, "page: the scene's probes are in bricks, and a page holds a whole grid: leave bricks out of them")
    end
    return own
  end
  return ylm.adaptive_grid { lmax = own and own.lmax or 4, channels = own and own.channels or "rgb",
    bounds = own and own.bounds, tolerance = given.tolerance or own and own.tolerance or TOLERANCE,
    depth = given.depth or own and own.depth }
end

--- Refuses a grid in bricks: a page is one file.
local function check_whole(path)
  if not path:lower():find "%.ylmd/*$" then return end
  status.stop(status.usage, "page: %s is a grid in bricks, and a page holds a whole one: ylm pack makes a file of it", path)
end

--- Do walls stand around the surfaces of a scene: does a tenth of their area see less than half of the sky?
local function has_walls(ylm, scene, given)
  local triangles = 0
  for _, g in ipairs(scene.geometry) do triangles = triangles + #g.mesh:triangles() end
  local links = status.need(scene:links { max_elements = math.max(8192, 2 * triangles), rays = 4, threads = given.threads })
  local sky = status.need(links:radiosity(ylm.environment_light { radiance = 1 },
    { bounces = 0, light_samples = 8, guides = false, threads = given.threads }))
  local area, E, all, within = links:elements().area, sky:irradiance(), 0, 0
  for i = 1, #area do
    all = all + area:get(i)
    within = within + (E:get(i, 1) < math.pi / 2 and area:get(i) or 0)
  end
  return within > 0.1 * all
end

--- The scene's light with walls, shadows and bounces; nil where the grid has them, where no surface throws shadows, where no
-- walls stand around them and --light does not ask, or where --lamps asks for none.
local function light_of(ylm, scene, grid, given)
  if given.lamps or not scene or #scene.geometry == 0 or grid.quantity ~= "lights" then return nil end
  if not given.light and not has_walls(ylm, scene, given) then return nil end
  return (status.need(scene:bake { quantity = "all", threads = given.threads, progress = report.progress(given),
    probes = ylm.adaptive_grid { lmax = 2, tolerance = LIGHT_TOLERANCE, depth = given.depth } }))
end

local function load_grid(ylm, path) return status.need_kind("ylm.grid", "a grid", path, ylm.load(path)) end

--- The grid of a page and its scene, which a grid alone has not.
local function things_of(ylm, given)
  local path = given[1]
  check_whole(path)
  check_whole(given.grid or "")
  if path:lower():find "%.ylm$" then
    if given.grid then status.stop(status.usage, "page: %s is a grid already: leave --grid out, or name a scene", path) end
    for _, name in ipairs { "tolerance", "depth", "quantity" } do
      if given[name] then status.stop(status.usage, "page: --%s is of a bake, %s is baked: leave it out", name, path) end
    end
    return load_grid(ylm, path)
  end
  if given.grid and (given.tolerance or given.depth or given.quantity) then
    status.stop(status.usage, "page: --%s is of a bake, --grid is baked: leave one out",
      given.depth and "depth" or given.tolerance and "tolerance" or "quantity")
  end
  local scene = status.load_scene(path)
  if given.grid then return load_grid(ylm, given.grid), scene end
  return status.need(scene:bake { probes = probes_of(ylm, scene, given), threads = given.threads, quantity = given.quantity,
    occupied = #scene.geometry > 0 and "surfaces" or "everywhere", progress = report.progress(given) }), scene
end

local of_grids = { "grid", "depth", "lamps", "light", "precision", "tone", "size", "no-poster", "dering" }

--- Bakes a lightmap and writes its page.
local function write_lightmap(given)
  for _, name in ipairs(of_grids) do
    if given[name] ~= nil then
      status.stop(status.usage, "page: --%s is of a grid: leave it out beside --lightmap", name)
    end
  end
  if given.quantity == "lights" then
    status.stop(status.usage, "page: --quantity of a lightmap is all (default), indirect or direct, got 'lights'")
  end
  local light = status.need(lit_scene.with_surfaces(given[1]):lightmap { tolerance = given.tolerance, texels = given.texels,
    quantity = given.quantity, threads = given.threads, progress = report.progress(given) })
  local _, facts = status.need(light:save(given.output, { title = given.title, exposure = given.exposure,
    limit = given.limit }))
  local stats = light.stats
  local results = { bytes = facts.bytes, width = stats.width, height = stats.height, charts = stats.charts, error = stats.error,
    met = stats.met }
  report.print(given, results, report.names(results, { "bytes", "width", "height", "charts", "error" }))
  return status.of_warnings(given, { stats.warning })
end

return {
  summary = "a grid and its scene as one HTML file that browsers show without a network",
  usage = "SCENE.lua | GRID.ylm -o PAGE.html\n       ylm page SCENE.lua | MESH.obj --lightmap -o PAGE.html",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the page (.html)" },
    { "grid", "-g", "FILE", "a grid baked before; default: the scene's probes are baked on its surfaces" },
    { "lightmap", nil, nil, "the surfaces, lit by a lightmap, instead of a grid; of a file of triangles too" },
    { "texels", nil, "N", "of --lightmap, at most" },
    { "tolerance", nil, "N", "of the bake, instead of the scene's probes'; default 0.05 where the scene has none" },
    { "depth", nil, "N", "of the bake, and of that of the scene's light: the finest level" },
    { "quantity", nil, "NAME", "of the bake: lights (default), which nothing occludes, direct, indirect or all" },
    { "light", nil, nil, "show the scene's light, with walls, shadows and bounces; default where walls stand around surfaces" },
    { "lamps", nil, nil, "show the lamps' light alone: no bake of the scene's" },
    { "precision", nil, "NAME", "few (default): rounded, a fifteenth of half or less; half, float, or byte: 0.63 of half" },
    { "title", nil, "TEXT", "default: the scene's name" },
    { "exposure", nil, "N", "at first, in stops" },
    { "tone", nil, "NAME", "tone curve at first: srgb (default), linear, reinhard, hable, aces" },
    { "size", "-s", "WxH", "of the poster, which is seen where the page cannot be drawn" },
    { "no-poster", nil, nil, "none is rendered" },
    { "dering", nil, "N", "width of the window against light below zero, in degrees, 0: none; default: chosen where needed" },
    { "limit", nil, "N", "bytes of the file, default 32e6: a larger one is refused" },
    { "strict", nil, nil, "exit status 6 where a warning is given; the page is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "page: -o FILE says where the page goes") end
    status.need_output("page", given.output, "html")
    if given.precision and not PRECISIONS[given.precision] then
      status.stop(status.usage, "page: --precision is few, half, float or byte, got '%s'", given.precision)
    end
    if given.lightmap then return write_lightmap(given) end
    if given.texels then status.stop(status.usage, "page: --texels is of --lightmap") end
    if given.light and given.lamps then status.stop(status.usage, "page: --light and --lamps: leave one out") end
    local grid, scene = things_of(ylm, given)
    local poster
    if given["no-poster"] then poster = false end
    local began = core.seconds()
    local light = light_of(ylm, scene, grid, given)
    local took = core.seconds() - began
    local _, made = status.need(grid:save(given.output, { scene = scene, light = light, title = given.title,
      precision = given.precision, exposure = given.exposure, tone = given.tone, size = given.size, poster = poster,
      limit = given.limit, dering = status.dering("page", given.dering), threads = given.threads }))
    local stats = grid.stats
    local results = { bytes = made.bytes, poster = made.poster, points = stats.points, cells = stats.cells,
      triangles = made.triangles, sections = made.sections, warnings = made.warnings, met = stats.met,
      light = made.light }
    if light then results.light.seconds = took end
    report.print(given, results, report.names(results, { "bytes", "points", "cells", "triangles", "light" }))
    local all = { stats.warning, light and light.stats.warning }
    for _, sentence in ipairs(made.warnings) do all[#all + 1] = sentence end
    return status.of_warnings(given, all)
  end,
}
