--- Light in a live window: grids that follow lamps, prepared views of several sizes, pictures.
--
-- Functions that work return true, or nil, message, code; ECANCELLED where the progress function stopped them.

local array = require "ylm.array"
local box = require "ylm.box"
local camera_form = require "ylm.camera"
local core = require "ylm.c.core"
local form = require "ylm.form"
local grids = require "ylm.grid"
local light = require "ylm.light"
local lamps = require "ylm.live.lamps"
local render = require "ylm.render"
local scenes = require "ylm.scene"

local follow = {}
local methods = {}

--- Qualities of prepared views: camera rays of a pixel, occlusion rays of a transfer vector. 0 is while a camera turns.
local QUICK = { [0] = { samples = 1, rays = 8 }, [1] = { samples = 1, rays = 16 } }

local function scene_of(s, lights)
  return scenes.scene(s.name) { camera = s.camera, geometry = s.geometry, lights = lights,
    background = not s.sky_is_seen and s.background or nil, links = s.link_options }
end

--- Follows scene `s`. o: samples, transfer_samples, threads.
function follow.new(s, rows, others, o)
  local f = setmetatable({ scene = s, o = o, others = others, cache = lamps.cache(), views = {}, seconds = {} },
    { __index = methods })
  f.stage, f.lit = scene_of(s, others), scene_of(s, others)
  local lo, hi
  for _, part in ipairs(s.geometry) do
    local a, b = part.mesh.bounds[1], part.mesh.bounds[2]
    for k = 1, 3 do
      lo, hi = lo or { a[1], a[2], a[3] }, hi or { b[1], b[2], b[3] }
      lo[k], hi[k] = math.min(lo[k], a[k]), math.max(hi[k], b[k])
    end
  end
  f.empty = lo == nil
  if f.empty then
    local c, d = s.camera.at, 1 + math.sqrt((s.camera.at[1] - s.camera.from[1]) ^ 2 + (s.camera.at[2] - s.camera.from[2]) ^ 2
      + (s.camera.at[3] - s.camera.from[3]) ^ 2)
    lo, hi = { c[1] - d, c[2] - d, c[3] - d }, { c[1] + d, c[2] + d, c[3] + d }
  end
  f.lo, f.hi, f.diagonal = lo, hi, math.max(box.diagonal(lo, hi), 1e-6)
  local all = f:lights(rows)
  f.follows = light.followed(light.field(1, "live", all)) ~= nil
  return f
end

--- The scene's lights with lamps in these rows: a list for bakes and updates.
function methods.lights(f, rows)
  f.spheres = f.cache:light(rows)
  local all = { f.spheres }
  for i, l in ipairs(f.others) do all[i + 1] = l end
  return all
end

--- Probes like the scene's, or the default, with a tolerance or (nil) their own, in no bricks; `dynamic`: that follow lamps.
function methods.probes(f, settings, tolerance, dynamic)
  local own = f.scene.probes
  local kind = own and form.kind(own) or "adaptive_grid"
  local given = {}
  if own then
    for _, field in ipairs(form.defined[kind].fields) do given[field[1]] = own[field[1]] end
  end
  given.lmax, given.dynamic = settings.lmax, dynamic
  if kind == "uniform_grid" then return grids.uniform_grid(given) end
  given.depth, given.bricks = settings.depth, nil
  if dynamic then given.measure = nil end
  if tolerance then
    given.tolerance, given.threshold, given.metric = tolerance, nil, nil
  end
  return grids.adaptive_grid(given)
end

local function bake(f, rows, probes, progress)
  return f.lit:bake { probes = probes, quantity = "lights", lights = f:lights(rows), threads = f.o.threads, progress = progress }
end

--- Brings the grid that follows lamps up to date, or bakes it where there is none; `progress` may cancel.
function methods.update(f, rows, settings, progress)
  if f.empty then return true end
  local start = core.seconds()
  local report, message, code
  f.fine = nil
  if f.grid and f.follows then
    report, message, code = f.grid:update(f:lights(rows), { threads = f.o.threads, progress = progress })
    if not report and code ~= "ECANCELLED" then f.grid = nil end -- where it is spent
  else
    local grid
    grid, message, code = bake(f, rows, f:probes(settings, not settings.own and settings.tolerance or nil, f.follows), progress)
    report = grid
    if grid then f.grid, f.baked = grid, core.seconds() - start end
  end
  f.seconds.update = core.seconds() - start
  if not report then return nil, message, code end
  return true
end

--- Forgets the grid that follows lamps: tolerance, depth or lmax are others.
function methods.drop_grid(f) f.grid, f.fine, f.dering = nil, nil, nil end

--- Forgets prepared views: the camera, the size or lmax are others.
function methods.drop_views(f)
  f.views, f.rays, f.paths, f.dering = {}, nil, nil, nil
end

--- Bakes the grid of the picture at rest: by the probes' own tolerance, or with `tolerance` by that.
function methods.bake_fine(f, rows, settings, tolerance, progress)
  if f.empty then return true end
  local grid, message, code = bake(f, rows, f:probes(settings, tolerance, false), progress)
  if not grid then return nil, message, code end
  f.fine = grid
  return true
end

local function quality_of(f, quality)
  return QUICK[quality] or { samples = f.o.samples, rays = f.o.transfer_samples }
end

--- The scene's camera with the numbers of `c`.
local function form_of(c) return camera_form.camera { from = c.from, at = c.at, up = c.up, fov = c.fov } end

--- Prepares a view for the camera at 1/scale of w x h pixels, unless there is one of that quality or a better one.
function methods.prepare(f, camera, w, h, scale, quality, settings, progress)
  local known = f.views[scale]
  if known and known.camera == camera and known.quality >= quality then return true end
  local q, start = quality_of(f, quality), core.seconds()
  local size = { math.max(1, math.floor(w / scale + 0.5)), math.max(1, math.floor(h / scale + 0.5)) }
  local view, message, code = f.stage:prepare { camera = form_of(camera), size = size, samples = q.samples,
    transfer_samples = q.rays, visibility = "transfer", lmax = settings.lmax, threads = f.o.threads, progress = progress }
  if not view then return nil, message, code end
  f.views[scale] = { view = view, camera = camera, quality = quality, size = size,
    depth = array.zeros({ size[2], size[1] }, "float") }
  f.seconds.prepare = core.seconds() - start
  return true
end

--- The best view of the camera that there is: the scale and the view; nil where there is none.
function methods.view_of(f, camera, scale)
  for _, k in ipairs { scale or 1, 1, 2, 4 } do
    local v = f.views[k]
    if v and v.camera == camera then return k, v end
  end
end

--- Shades a view by a field of light: the picture, the view's depth written; or nil, message, code.
local function shade(f, v, field, rows, layers, spare, progress)
  f:lights(rows)
  local image, report, code = v.view:render { grid = field, lamps = f.spheres, layers = layers, depth = v.depth,
    threads = f.o.threads, out = spare, progress = progress, dering = f.dering }
  if image and report.dering then f.dering = report.dering.width end -- the window of one picture is that of the next
  return image, report, code
end

--- The picture by the grid of a view: { image, depth, size, grid }; or nil, message, code. Two images of a view take turns, so
-- that one which is broken off leaves what is shown. `layers`: an image of its own, with layers.
function methods.picture(f, v, rows, layers, progress)
  local start = core.seconds()
  local grid = f.fine or f.grid
  local field = grid or light.field(1, "live", f:lights(rows))
  local image, report, code = shade(f, v, field, rows, layers and grid ~= nil or false, not layers and v.spare or nil, progress)
  if not image then return nil, report, code end
  if not layers then v.spare, v.seen = v.seen, image end
  f.seconds.render = core.seconds() - start
  return { image = image, depth = v.depth, size = v.size, grid = grid, method = "grid", report = report }
end

--- The picture without a grid: the lights' own coefficients at every point; or nil, message, code.
function methods.reference(f, v, rows, progress)
  local image, message, code = shade(f, v, light.field(1, "live", f:lights(rows)), rows, false, nil, progress)
  if not image then return nil, message, code end
  return { image = image, depth = v.depth, size = v.size, method = "reference", lamps = rows }
end

--- How many lamps times points a reference would take.
function methods.pairs(f, v, rows) return (#rows + #f.others) * v.view.stats.points end

-- By rays and by paths -----------------------------------------------------------------------

--- Forgets pictures by rays and paths: lamps or the camera moved.
function methods.drop_rays(f) f.rays, f.paths = nil, nil end

--- Elements that light bounces from, once a window: lamps move, surfaces stay. True, or nil, message, code.
function methods.cut(f, progress)
  if f.elements or f.empty or f.o.bounces == 0 then return true end
  local own = f.scene.link_options
  local elements, message, code = f.lit:links { lmax = 0, rays = own and own.rays or render.LINKS_OF_ELEMENT,
    threads = f.o.threads, progress = progress }
  if not elements then return nil, message, code end
  f.elements = elements
  return true
end

--- A picture by rays as the window shows it.
local function of_rays(v, image, report, bounces)
  return { image = image, size = v.size, method = "rays", depth = v.depth, noise = report.noise, samples = report.light_samples,
    bounces = bounces, report = report }
end

--- The picture by rays, with all light that bounces, as scene:render makes it; so_far() is called when f.rays is the picture of
-- the pilot. One that is broken off leaves that. True, or nil, message, code.
function methods.cast(f, v, rows, progress, so_far)
  f.lit.lights, f.lit.camera = f:lights(rows), form_of(v.camera)
  local o = f.o
  local bounces = (f.empty or not f.elements) and 0 or o.bounces
  local watch = { now = function(image, report)
    f.rays = of_rays(v, image, report, bounces)
    so_far()
  end }
  local image, report, code = render.watched(f.lit, { by = "rays", size = v.size, samples = o.samples, noise = o.noise,
    light_samples = o.light_samples, denoise = o.denoise, bounced = bounces ~= 0 and f.elements or nil, bounces = bounces,
    layers = false, threads = o.threads, progress = progress }, watch)
  if not image then return nil, report, code end
  f.rays = of_rays(v, image, report, bounces)
  if report.ended == "cancelled" then return nil, "cancelled", "ECANCELLED" end
  return true
end

--- More paths of any length, added to those before; or nil, message, code.
function methods.trace(f, v, rows, samples, progress)
  f.lit.lights, f.lit.camera = f:lights(rows), form_of(v.camera)
  local p = f.paths
  local image, report, code = f.lit:pathtrace { size = v.size, samples = (p and p.samples or 0) + samples,
    resume = p and p.image or nil, threads = f.o.threads, progress = progress }
  if not image then return nil, report, code end
  f.paths = { image = image, size = v.size, method = "path", depth = v.depth, samples = (p and p.samples or 0) + samples,
    noise = report.noise }
  return true
end

--- Depths between which a camera sees the scene: nearest, farthest.
function methods.range(f, camera, least)
  local d, length, near, far = {}, 0, math.huge, -math.huge
  for a = 1, 3 do
    d[a] = camera.at[a] - camera.from[a]
    length = length + d[a] * d[a]
  end
  length = math.sqrt(length)
  for corner = 0, 7 do
    local z = 0
    for a = 1, 3 do
      local x = math.floor(corner / 2 ^ (a - 1)) % 2 == 0 and f.lo[a] or f.hi[a]
      z = z + (x - camera.from[a]) * d[a] / length
    end
    near, far = math.min(near, z), math.max(far, z)
  end
  near = math.max(least, near / 2)
  return near, math.max(2 * far, 10 * near)
end

return follow
