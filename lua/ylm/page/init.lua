--- Pages: a grid, its scene and a viewer in one HTML file, for grid:save.

local check = require "ylm.check"
local core = require "ylm.c.core"
local few = require "ylm.page.few"
local form = require "ylm.form"
local functions = require "ylm.page.gen.functions"
local lookup = require "ylm.page.gen.probes"
local grid_file = require "ylm.grid.file"
local image = require "ylm.image"
local light = require "ylm.light"
local pack = require "ylm.page.pack"
require "ylm.render.dering" -- the type dering
require "ylm.render.options" -- the type image_size
local prints = require "ylm.render.prints"
local probes = require "ylm.grid.probes"
local text = require "ylm.text"
local tracing = require "ylm.trace"
local vector = require "ylm.vector"
local viewer = require "ylm.page.viewer"
local window = require "ylm.sh.window"
local warning = require "ylm.warning"

local page = {}

local MOST_LMAX = 8
local MOST_TEXELS = 2 ^ 24       -- of rows: 4096 x 4096
local MOST_LAMPS = 4096          -- of the exact picture
local MOST_VOXELS = 2 ^ 24
local LIGHT_BYTES = 2 ^ 16      -- of the scene's light
local PALETTE = 16
local LOOK = { 160, 90 }         -- pixels of a picture that only tells whether light is below zero

-- Facts ------------------------------------------------------------------------------------

--- A camera that sees a box whole: from, at, up, fov.
local function camera_of(bounds)
  local lo, hi, at, far = bounds[1], bounds[2], {}, 0
  for a = 1, 3 do
    at[a] = (lo[a] + hi[a]) / 2
    far = far + (hi[a] - lo[a]) ^ 2
  end
  far = 1.4 * math.sqrt(far)
  return { at[1] + 0.6 * far, at[2] + 0.4 * far, at[3] + 0.7 * far, at[1], at[2], at[3], 0, 1, 0, 40 }
end

local function numbers_of(camera)
  local up = vector.unit(camera.up)
  return { camera.from[1], camera.from[2], camera.from[3], camera.at[1], camera.at[2], camera.at[3], up[1], up[2], up[3],
    camera.fov }
end

--- The sphere lights of a scene as rows of seven numbers, and the number of its other lights; nil, message, code.
local function lamps_of(scene)
  local rows, others = {}, 0
  for _, one in ipairs(scene.lights) do
    local as_light = light.form_of(one)
    if not (as_light and as_light.spheres) then others = others + 1 end
  end
  if #scene.lights == 0 then return rows, others end
  local packed, message, code = light.pack(1, "save", scene.lights)
  if not packed then return nil, message, code end
  local at, radius, radiance = light.arrays(packed)
  at, radius, radiance = at:totable(), radius:totable(), radiance:totable()
  for i, r in ipairs(radius) do
    if r > 0 then
      local p, c = at[i], radiance[i]
      rows[#rows + 1] = { p[1], p[2], p[3], r, c[1], c[2], c[3] }
    end
  end
  return rows, others
end

--- Why the lamps alone do not make the light of the grid at a pixel; nil: they do.
local function no_exact(grid, scene, lamps, others)
  if not scene then return "the page knows no lamps" end
  if grid.quantity ~= "lights" then
    return ("the grid holds %s light, with shadows that the lamps alone do not make"):format(grid.quantity)
  end
  if others > 0 then return ("%d of the scene's lights are no spheres"):format(others) end
  if #lamps == 0 then return "the scene has no lamps" end
  if #lamps > MOST_LAMPS then return ("%d lamps, at most %d can be summed at every pixel"):format(#lamps, MOST_LAMPS) end
end

--- Logarithms of the least and the largest estimated error of leaves above 0.
local function range_of(grid)
  local cells = grid:cells()
  local errors, leaf, least, most = cells.error, cells.leaf, math.huge, 0
  for i = 1, #leaf do
    local x = errors[i]
    if leaf[i] == 1 and x > 0 and x < math.huge then least, most = math.min(least, x), math.max(most, x) end
  end
  if most == 0 then return { 0, 1 } end
  least = math.max(least, most * 1e-4)
  return { math.log(least), math.log(math.max(most, least * 1.001)) }
end

local function palette()
  local list = {}
  for i = 1, PALETTE do list[i] = { core.colourmap_at("viridis", (i - 1) / (PALETTE - 1)) } end
  return list
end

-- Checks -------------------------------------------------------------------------------------

--- Facts about a grid that fits into a page; nil, message, code where none of it does.
local function facts_of(grid)
  if grid.lmax > MOST_LMAX then
    return nil, ("page: lmax %d needs %d numbers a corner of a cell and channel; bake with lmax <= %d"):format(grid.lmax,
      (grid.lmax + 1) ^ 2, MOST_LMAX), "ELIMIT"
  end
  local names = { "cells", "octree", "points", "evaluated", "channels", "count", "sides", "parts", "exponent" }
  local found, facts = { core.page_facts(grid) }, {}
  for i, name in ipairs(names) do facts[name] = found[i] end
  facts.root = { found[10], found[11], found[12], found[13] }
  if not facts.exponent then return nil, "page: " .. found[10], found[11] end
  if facts.points * facts.channels * facts.count > MOST_TEXELS then
    return nil, ("page: %d points at lmax %d in %d channels are too many for a page: at most %d; bake with a coarser tolerance "
      .. "or a lower lmax"):format(facts.points, grid.lmax, facts.channels,
      math.floor(MOST_TEXELS / facts.channels / facts.count)), "ELIMIT"
  end
  local n = grid.resolution
  if grid.kind == "uniform" and n[1] * n[2] * n[3] > MOST_VOXELS then
    return nil, ("page: %d x %d x %d voxels are too many for a page: at most 2^24"):format(n[1], n[2], n[3]), "ELIMIT"
  end
  return facts
end

--- A picture of a page's scene as the page shades it, of so many camera rays, and its report; nil: the scene has none; or nil,
-- message, code.
local function picture_of(grid, o, size, samples)
  if not (o.scene and o.scene.camera and #o.scene.geometry > 0) then return nil end
  grid = o.light or grid
  return warning.silently(o.scene.render, o.scene, { grid = grid, size = size, samples = samples, gloss = "matte",
    visibility = grid.quantity == "lights" and "none" or nil, dering = o.dering, threads = o.threads })
end

--- The picture that is seen until, and where, the viewer does not run: bytes of a .png, and its report where there is one; nil,
-- report: there is no picture; or nil, message, code.
local function poster_of(grid, o)
  local seen = o.poster == nil
  local picture, report, code = picture_of(grid, o, seen and o.size or LOOK, seen and 4 or 1)
  if code and (seen or code ~= "EMISSING") then return nil, report, code end
  report = not code and report or nil
  picture = seen and picture or o.poster
  if not picture then return nil, report end
  local codec, message
  codec, message, code = image.codec()
  if not codec then return nil, message, code end
  local bytes
  bytes, message, code = codec.image_png(picture, o.tone, o.exposure)
  if not bytes then return nil, message, code end
  return bytes, report
end

-- The file -------------------------------------------------------------------------------------

local entities = { ["<"] = "&lt;", [">"] = "&gt;", ["&"] = "&amp;", ['"'] = "&quot;" }

--- Words @LIKE_THIS@ of a text replaced.
local function filled(source, words)
  return (source:gsub("@([%u_]+)@", function(word) return words[word] end))
end

local function joined(degrees, lmax)
  local out = {}
  for l = 0, lmax do out[#out + 1] = degrees[l] end
  return table.concat(out)
end

local function shaders(sources, lmax)
  local harmonics = "void harmonics(float x, float y, float z, float g, float o) {\n"
    .. joined(functions.harmonics_essl, lmax) .. "}\n"
  local list = {
    { "cells-glsl", functions.cells_essl }, { "interpolation-glsl", functions.interpolation_essl },
    { "harmonics-glsl", harmonics }, { "walk-glsl", sources["walk.glsl"] },
    { "seen-glsl", sources["seen.glsl"] }, { "buffer-fragment", sources["buffer.frag.glsl"] },
    { "surface-vertex", sources["surface.vert.glsl"] }, { "surface-fragment", sources["surface.frag.glsl"] },
    { "edge-vertex", sources["edge.vert.glsl"] }, { "flat-fragment", sources["flat.frag.glsl"] },
    { "lobe-vertex", sources["lobe.vert.glsl"] }, { "lamp-vertex", sources["lamp.vert.glsl"] },
    { "lamp-fragment", sources["lamp.frag.glsl"] }, { "resolve-vertex", sources["resolve.vert.glsl"] },
    { "resolve-fragment", sources["resolve.frag.glsl"] }, { "probes-glsl", lookup },
    { "scene-fragment", sources["scene.frag.glsl"] },
  }
  for i, one in ipairs(list) do
    list[i] = ('<script id="%s" type="text/plain">\n%s</script>'):format(one[1], one[2])
  end
  return table.concat(list, "\n")
end

--- The page's bytes; sources: the viewer's files by name.
local function html(sources, meta, data, poster, lmax)
  return filled(sources["page.html"], {
    VERSION = meta.version, TITLE = (meta.title:gsub('[<>&"]', entities)), STYLE = sources["style.css"],
    POSTER = poster and ('<img id="poster" elementtiming="poster" alt="" src="data:image/png;base64,%s">'):format(
      core.page_base64(poster)) or "",
    META = pack.json(meta), DATA = data, SHADERS = shaders(sources, lmax),
    SCRIPT = (sources["viewer.js"]:gsub("/%*@(%u+)@%*/", {
      FEW = meta.precision == "few" and sources["few.js"] or "", PROBES = meta.light and sources["probes.js"] or "",
      INTERPOLATION = functions.interpolation_js,
      HARMONICS = joined(functions.harmonics_js, lmax),
    })),
  })
end

--- Says that the grid holds light of another scene than the page's: the sentence, or nil.
local function say_prints(grid, scene)
  local t = scene and grid.prints and #scene.geometry > 0 and tracing.trace("save", scene)
  return t and prints.warn(grid, scene, t) or nil
end

--- The parts of the scene that the page leaves out, a sentence each.
local function shortcomings(grid, o, others, counts, report)
  local list, passing = {}, o.poster == nil and report.occlusion and report.occlusion.passing
  local ringing = report.dering
  if ringing and ringing.width then
    list[1] = ("page: %.2g %% of the light was below zero, since harmonics of degree %d ring: a window of width %.2f leaves "
      .. "%.2g %% (dering = false: none)"):format(100 * ringing.before, grid.lmax, ringing.width, 100 * ringing.after)
  end
  if passing and passing >= 0.01 then
    list[#list + 1] = ("page: %.0f %% of the light passes occluders, since the grid's lights have no shadows: bake quantity = "
      .. "'direct' or 'all' (ylm bake --quantity all, ylm page --grid) for these"):format(100 * passing)
  end
  if others > 0 and o.lamps then
    list[#list + 1] = ("page: %d of the scene's lights are no spheres: their light is in the grid, they are not drawn"):format(
      others)
  end
  if counts and counts.glossy > 0 then
    list[#list + 1] = ("page: %d surfaces gloss: a page shades them matte, with their mean albedo"):format(counts.glossy)
  end
  return list
end

local function stats_of(grid)
  local s = grid.stats
  return { points = s.points, cells = s.cells, tolerance = grid.tolerance, error = s.error, met = s.met,
    metric = grid.kind == "adaptive" and grid.metric or nil }
end

--- The facts of a page that do not depend on its sections.
local function meta_of(grid, facts, o, lamps, others)
  local lo, hi, n, unit, cosine = grid.bounds[1], grid.bounds[2], grid.resolution, {}, {}
  for a = 1, 3 do unit[a] = (hi[a] - lo[a]) / n[a] end
  for l = 0, grid.lmax do cosine[l + 1] = core.sh_cosine_factor(l) end
  local scene = o.scene
  return { ylm = 1, version = (core.info()), title = o.title or scene and scene.name or "Grid",
    bounds = { lo[1], lo[2], lo[3], hi[1], hi[2], hi[3] }, unit = unit, resolution = { n[1], n[2], n[3] },
    depth = grid.kind == "adaptive" and grid.depth or 0, kind = grid.kind, lmax = grid.lmax, channels = facts.channels,
    quantity = grid.quantity, sides = grid.sides,
    counts = { cells = facts.cells, parts = facts.parts, octree = facts.octree, points = facts.points,
      evaluated = facts.evaluated },
    root = facts.root, exponent = facts.exponent, precision = o.precision, cosine = cosine,
    camera = scene and scene.camera and numbers_of(scene.camera) or camera_of(grid.bounds),
    background = scene and scene.background or { 0.02, 0.02, 0.02 }, lamps = o.lamps and lamps or {},
    no_exact = no_exact(grid, scene, o.lamps and lamps or {}, others), exposure = o.exposure, tone = o.tone,
    palette = palette(), range = range_of(o.errors or grid), stats = stats_of(grid) }
end

--- Raises where options do not fit; settles them.
local function settle(given)
  local o = form.options(2, "save", grid_file.page_options, given)
  if o.scene ~= nil and not (type(o.scene) == "table" and type(o.scene.geometry) == "table" and o.scene.lights) then
    return check.bad(2, "save", "scene must be a scene, got %s", check.describe(o.scene))
  end
  if o.poster ~= nil and o.poster ~= false and core.type(o.poster) ~= "ylm.image" then
    return check.bad(2, "save", "poster must be an image, or false for none, got %s", check.describe(o.poster))
  end
  if o.light ~= nil and (core.type(o.light) ~= "ylm.grid" or o.scene == nil) then
    return check.bad(2, "save", "light must be a grid, beside a scene, got %s", check.describe(o.light))
  end
  if o.title then o.title = text.shown(o.title) end
  return o
end

local function refuse_size(bytes, o, blob)
  local rows, hints = 0, { half = "; precision = 'byte' needs about 0.6 of the light's", few = "; a larger tolerance needs less" }
  for _, name in ipairs { "rows", "values", "slopes", "points", "numbers", "bits" } do rows = rows + (blob.by_name[name] or 0) end
  hints.float = hints.half
  local hint = hints[o.precision] or ""
  return nil, ("page: %.1f MB, the limit is %.1f MB: %.1f MB of light, %.1f MB of meshes%s; bake with a coarser tolerance or a "
    .. "lower lmax, or raise limit"):format(bytes / 1e6, o.limit / 1e6, rows * 4 / 3e6, (blob.bytes - rows) * 4 / 3e6, hint),
    "ELIMIT"
end

--- The factors of the cosine's degrees, damped by the window of a picture's report.
local function damped(cosine, ringing)
  if not ringing or not ringing.width then return cosine end
  local factors, out = window.factors("hann", ringing.width, #cosine - 1), {}
  for l, x in ipairs(cosine) do out[l] = x * factors[l] end
  return out
end

--- The grid that the page shows, and how it is written, as of few.of; or nil, message, code.
local function shown_of(grid, o)
  local facts, message, code = facts_of(grid)
  if not facts then return nil, message, code end
  if o.precision ~= "few" then return grid end
  o.errors = grid
  return few.of(grid, o)
end

--- Packs and writes; true and a report, or nil, message, code.
local function write(baked, path, o)
  local grid, made, why = shown_of(baked, o)
  if not grid then return nil, made, why end
  local facts, message, code = facts_of(grid)
  if not facts then return nil, message, code end
  local sources
  sources, message, code = viewer.sources()
  if not sources then return nil, message, code end
  local lamps, others = {}, 0
  if o.scene then
    lamps, others, code = lamps_of(o.scene)
    if not lamps then return nil, others, code end
  end
  local meta, blob = meta_of(grid, facts, o, lamps, others), pack.blob()
  local counts
  pack.grid(blob, grid, facts, o.precision, made)
  if o.scene then
    meta.mesh, counts, code = pack.meshes(blob, o.scene)
    if not meta.mesh and counts then return nil, counts, code end
  end
  local made_light
  if o.light then
    local file, report, failed = probes.encode(o.light, { scene = o.scene, bytes = LIGHT_BYTES, threads = o.threads })
    if not file then return nil, report, failed end
    meta.light = true
    made_light = { bytes = #file, error = report.error, rms = report.surfaces.rms }
    blob.add("probes", "u8", { #file }, file)
  end
  if blob.bytes * 4 / 3 > o.limit then return refuse_size(blob.bytes * 4 / 3, o, blob) end
  meta.sections = blob.sections
  local poster, found
  poster, found, code = poster_of(grid, o)
  if code and code ~= "EMISSING" then return nil, found, code end
  local report = not code and found or {}
  meta.cosine = damped(meta.cosine, report.dering)
  local warnings = shortcomings(grid, o, others, counts, report)
  if code then warnings[#warnings + 1] = "page: without a poster: " .. found end
  local bytes = html(sources, meta, blob.base64(), poster, grid.lmax)
  if #bytes > o.limit then return refuse_size(#bytes, o, blob) end
  local ok
  ok, message, code = check.result("save", core.file_save(path, bytes))
  if not ok then return nil, message, code end
  for i, sentence in ipairs(warnings) do warning.say(o.scene or grid, "page " .. i, "%s", sentence) end
  warnings[#warnings + 1] = say_prints(grid, o.scene)
  return true, { bytes = #bytes, poster = poster and #poster or 0, sections = blob.by_name, warnings = warnings,
    dering = report.dering, few = made and made.report, light = made_light,
    triangles = counts and counts.triangles or 0 }
end

--- grid:save of a path that ends in .html.
function page.save(grid, path, given)
  local o = settle(given)
  few.settle(grid, o)
  local ok, message, code = core.file_probe(path)
  if not ok then return check.result("save", nil, message, code) end
  return write(grid, path, o)
end

return page
