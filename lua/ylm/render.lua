--- Pictures of scenes: what bake, prepare, render, reference and raycast of a scene do.
--
-- Everything that does not depend on how the light is known (camera rays, shading points,
-- occlusion rays, transfer vectors) is a "prepared" view; it is made once and rendered as often
-- as one likes, so that methods are compared on the very same points.

require "ylm.array" -- the methods of the arrays that are returned
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.reference".describe
local form = require "ylm.form"
local image = require "ylm.image"
local light = require "ylm.light"
local material = require "ylm.material"
local progress = require "ylm.progress"

require "ylm.reference".object "prepared" {
  about = "What one camera sees of a scene, with transfer vectors, ready to be shaded by any light field.",
  fields = {
    { "stats", "table", "points, hits, pixels, primary_rays, occlusion_rays, scene_seconds, primary_seconds, "
      .. "transfer_seconds, bytes" },
    { "options", "table", "what it was made with" },
    { "scene", "scene", "of what" },
  },
}

local render = {}

--- The library that traces rays, or nil, message, "EMISSING".
local function library()
  local ok, lib = pcall(require, "ylm.c.scene")
  if ok then return lib end
  return nil, "rendering needs libylm_scene with Embree 3 (Debian: libembree-dev libopenexr-dev libpng-dev, then "
    .. "make): " .. tostring(lib):match("^[^\n]*"), "EMISSING"
end

-- Options ---------------------------------------------------------------------------

local common = {
  { "threads", "integer", min = 1, max = 1024, optional = true, about = "default: YLM_THREADS or all cores" },
  { "progress", "progress", optional = true,
    about = "called as f(done, total, stage), returning false cancels; true draws a bar" },
}

local function list(...)
  local all = {}
  for _, fields in ipairs { ... } do
    for _, field in ipairs(fields) do all[#all + 1] = field end
  end
  return all
end

function form.types.image_size(x)
  local function good(n) return check.is_integer(n) and n >= 1 and n <= 65536 end
  if type(x) == "table" and #x == 2 and good(x[1]) and good(x[2]) then return { x[1], x[2] } end
  return nil, "{ width, height }, integers from 1 to 65536"
end

--- A positive number, infinity included.
function form.types.distance(x)
  if type(x) == "number" and x > 0 then return x end
  return nil, "a number > 0 (math.huge: no end)"
end

local function view_fields(samples)
  return {
    { "size", "image_size", default = { 1280, 720 }, unit = "pixels", about = "{ width, height }" },
    { samples, "integer", min = 1, max = 1024, default = 16, about = "camera rays per pixel, stratified" },
    { "seed", "integer", min = 0, max = 2 ^ 32, default = 1, about = "of all random numbers" },
    { "share", "number", min = 0, default = 1.5, unit = "pixel widths",
      about = "samples of a pixel that hit one mesh this near to each other, normals within 10 degrees, "
        .. "are shaded as one; 0: every sample is shaded" },
  }
end

local transfer_fields = {
  { "shading", "choice", of = { "pixel", "vertex" }, default = "pixel",
    about = "shade what camera rays hit, or the vertices of the triangles they hit (colours are interpolated)" },
  { "visibility", "choice", of = { "pixel", "vertex", "none" }, optional = true,
    about = "occlusion rays from every shading point, from the vertices (transfer vectors are interpolated), "
      .. "or no occlusion; default: as shading" },
  { "transfer_samples", "integer", min = 1, max = 65536, optional = true,
    about = "occlusion rays per transfer vector; default 128, and 256 from vertices" },
  { "occlusion_distance", "distance", optional = true, unit = "scene units",
    about = "how far occlusion rays reach; default: a tenth of the diagonal of the scene's bounding box" },
  { "lmax", "integer", min = 0, max = 100, optional = true,
    about = "highest degree of light and transfer; default: the grid's, the probes', or 4" },
}

local layer_fields = {
  { "layers", "boolean", default = true,
    about = "also normal, position, depth, albedo, coverage, emitter, and of a grid level and error" },
  { "truth", "object", of = "ylm.image", optional = true,
    about = "an image of the same size: adds the layer true_error, |radiance - truth|" },
}

local grid_fields = {
  { "grid", "any", optional = true, about = "what scene:bake or ylm.bake returned" },
  { "interpolation", "choice", of = { "hermite", "taylor", "linear" }, default = "hermite",
    about = "of the grid" },
  { "device", "gpu", optional = true,
    about = "a gpu of ylm.vulkan.open samples the grid, shades and filters; report.stages has its times" },
}

-- Of the bake that a render without a grid makes first.
local baked_fields = { light.tolerance_option "light_tolerance" }

local reference_fields = {
  { "dtype", "choice", of = { "float", "double" }, default = "float", about = "in which light is summed" },
  light.tolerance_option "light_tolerance",
}

local ray_fields = {
  { "samples", "integer", min = 1, max = 65536, default = 64, about = "shadow rays per shading point" },
  { "shadows", "boolean", default = true, about = "false: nothing occludes" },
}

-- Scenes as the library wants them ------------------------------------------------------

local function check_scene(name, s)
  if form.kind(s) == "scene" then return s end
  return check.fail("%s: a scene expected before the colon, got %s", name, check.describe(s))
end

--- Lights of a scene as one "ylm.lights", darkness where there are none.
local function pack_lights(name, lights)
  if #lights > 0 then return light.pack(1, name, lights) end
  local function none(...) return assert(core.array_zeros({ 0, ... }, "double")) end
  return check.result(name, core.lights_create(none(3), none(), none(3)))
end

--- Do two lists hold the same things?
local function same(a, b)
  if #a ~= #b then return false end
  for i = 1, #a do if a[i] ~= b[i] then return false end end
  return true
end

--- Flat list of all that tracing depends on.
local function ingredients(s)
  local parts = {}
  local function add(x) parts[#parts + 1] = x == nil and false or x end
  for _, g in ipairs(s.geometry) do
    local m = g.material or material.default
    add(g.mesh); add(g.occludes ~= false)
    for c = 1, 3 do add(m.albedo[c]) end
  end
  add("lights")
  for _, l in ipairs(s.lights) do
    add(l)
    if form.kind(l) == "sphere_light" then
      add(l.radius)
      for c = 1, 3 do add(l.at[c]); add(l.radiance[c]) end
    end
  end
  return parts
end

--- Traced scenes by scene object, as long as the scene is unchanged.
local traced = setmetatable({}, { __mode = "k" })

--- { handle, lights, bounds, seconds } of a scene; nil, message, code.
local function trace(name, s)
  local lib, message, code = library()
  if not lib then return nil, message, code end
  local parts, known = ingredients(s), traced[s]
  if known and same(known.parts, parts) then return known end
  local start = core.seconds()
  local meshes, albedos, occludes = {}, {}, {}
  for i, g in ipairs(s.geometry) do
    meshes[i], albedos[i], occludes[i] = g.mesh, (g.material or material.default).albedo, g.occludes ~= false
  end
  local lights
  lights, message, code = pack_lights(name, s.lights)
  if not lights then return nil, message, code end
  local at, radius, radiance = light.arrays(lights)
  if not at then return nil, radius, radiance end
  local handle
  handle, message, code = check.result(name, lib.shade_scene(meshes, albedos, occludes, at, radius, radiance,
    light.patches(lights)))
  if not handle then return nil, message, code end
  local lo, hi = lib.shade_bounds(handle)
  local new = { parts = parts, handle = handle, lights = lights, lo = lo, hi = hi, lib = lib,
    seconds = core.seconds() - start }
  traced[s] = new
  return new
end

local function diagonal(t)
  local d = 0
  for i = 1, 3 do d = d + (t.hi[i] - t.lo[i]) ^ 2 end
  return math.sqrt(d)
end

--- The box of a scene's geometry, a little larger, so that no rounded point is outside and none is flat.
local function bounds_of(t)
  local pad, lo, hi = 1e-4 * diagonal(t), {}, {}
  if pad == 0 then pad = 1 end
  for i = 1, 3 do lo[i], hi[i] = t.lo[i] - pad, t.hi[i] + pad end
  return { lo, hi }
end

-- Prepared views ----------------------------------------------------------------------------

--- Methods of the userdata "ylm.prepared"; what it was made of stands in `made`.
local prepared = library() and core.metatable "ylm.prepared" or {}
local made = setmetatable({}, { __mode = "k" })

prepared.__index = function(view, key)
  local m = made[view]
  if m and (key == "stats" or key == "options" or key == "scene") then return m[key] end
  return rawget(prepared, key)
end

prepared.__newindex = function(_, key)
  return check.fail("prepared: cannot set %s: a prepared view does not change", check.describe(key))
end

prepared.__tostring = function(view)
  local m = made[view]
  if not m or m.closed then return "ylm.prepared (closed)" end
  return ("ylm.prepared view of %q: %dx%d, %d shading points"):format(m.scene.name or "?", m.options.size[1],
    m.options.size[2], m.stats.points)
end

--- The prepared view before the colon with all about it: { view, scene, traced, lib, stats, options }.
local function open(name, view)
  if core.type(view) ~= "ylm.prepared" then
    return check.fail("%s: a prepared view expected before the colon, got %s", name, check.describe(view))
  end
  if made[view].closed then return check.fail("%s: the prepared view has been closed", name) end
  return setmetatable({ view = view }, { __index = made[view] })
end

--- Makes the view that options `o` (with samples = camera rays per pixel) describe.
local function prepare(name, s, o)
  if not s.camera then return check.fail("%s: scene %q has no camera", name, s.name or "?") end
  local t, message, code = trace(name, s)
  if not t then return nil, message, code end
  local c = s.camera
  local visibility = o.visibility or o.shading
  local distance = o.occlusion_distance
  if not distance then
    distance = diagonal(t) / 10
    if distance == 0 then distance = 1 end
  end
  local rays = o.transfer_samples or (visibility == "vertex" or o.shading == "vertex") and 256 or 128
  local view
  view, message, code = check.result(name, t.lib.shade_view(t.handle,
    { c.from[1], c.from[2], c.from[3], c.at[1], c.at[2], c.at[3], c.up[1], c.up[2], c.up[3], c.fov },
    o.size[1], o.size[2], o.samples, o.lmax, o.shading == "vertex", visibility, rays, distance, o.share,
    o.seed, o.threads or 0, progress.resolve(o.progress)))
  if not view then return nil, message, code end
  local stats = t.lib.shade_stats(view)
  stats.scene_seconds = t.seconds
  made[view] = { scene = s, traced = t, lib = t.lib, stats = stats,
    options = { size = o.size, samples = o.samples, seed = o.seed, lmax = o.lmax, share = o.share,
      shading = o.shading, visibility = visibility, transfer_samples = rays, occlusion_distance = distance } }
  return view
end

--- The lmax that options leave open.
local function default_lmax(s, grid)
  if grid and check.is_integer(grid.lmax) then return grid.lmax end
  if s.probes and check.is_integer(s.probes.lmax) then return s.probes.lmax end
  return 4
end

--- Is it a grid, or another object with a light field?
local function check_grid(name, grid)
  if grid == nil then
    return check.fail("%s: field 'grid' is missing (scene:bake() makes one; scene:reference needs none)", name)
  end
  if core.grid_is_open(grid) == false then return check.fail("%s: the grid has been closed", name) end
  if core.type(grid) == "ylm.lights" and not core.lights_count(grid) then
    return check.fail("%s: the lights have been closed", name)
  end
  if core.has_field(grid) then return grid end
  return check.fail("%s: grid must be a grid (scene:bake() makes one), got %s", name, check.describe(grid))
end

-- Pictures ------------------------------------------------------------------------------------

--- Writes the layer radiance from that of shading points [points][3], o.lamps drawn over it.
local function compose(name, p, radiance, o, layer)
  local lib, view, threads = p.lib, p.view, o.threads or 0
  assert(check.result(name, lib.shade_compose(view, radiance, p.scene.background or { 0, 0, 0 }, threads, layer)))
  if not o.lamps then return true end
  local at, radius, emitted = light.arrays(light.pack(1, name, o.lamps))
  return assert(check.result(name, lib.shade_draw_lamps(view, threads, layer, at, radius, emitted)))
end

--- An image with the layers asked for; `radiance` [points][3], or what writes that layer: function(layer) -> true.
local function picture(name, p, radiance, o, cells)
  local layers = { { "radiance", 3 } }
  if o.layers then
    for _, l in ipairs { { "normal", 3 }, { "position", 3 }, { "depth", 1 }, { "albedo", 3 }, { "coverage", 1 },
      { "emitter", 1 } } do layers[#layers + 1] = l end
    if cells then
      layers[#layers + 1] = { "level", 1 }
      layers[#layers + 1] = { "error", 1 }
    end
  end
  if o.truth then layers[#layers + 1] = { "true_error", 3 } end
  local lib, view, threads = p.lib, p.view, o.threads or 0
  local out, message, code = image.image { size = p.options.size, layers = layers }
  if not out then return nil, message, code end
  local function done(...) return assert(check.result(name, ...)) end
  local ok
  if type(radiance) == "function" then ok, message, code = radiance(out:layer "radiance")
  else ok, message, code = compose(name, p, radiance, o, out:layer "radiance") end
  if not ok then return nil, message, code end
  if o.layers then
    for _, layer in ipairs { "normal", "position", "depth", "albedo", "coverage", "emitter" } do
      done(lib.shade_layer(view, layer, threads, out:layer(layer)))
    end
    if cells then
      done(lib.shade_resolve(view, cells.level, nil, true, threads, out:layer "level"))
      done(lib.shade_resolve(view, cells.error, nil, true, threads, out:layer "error"))
    end
  end
  if o.truth then render.true_error(out, o.truth) end
  return out
end

local convention = "real orthonormal, Condon-Shortley phase, index l(l+1)+m"

--- Writes how an image came about into its metadata.
local function sign(out, p, method, report, extra)
  local m, o = out.metadata, p.options
  m.software, m.version = "ylm", (core.info())
  m.scene, m.method = p.scene.name or "", method
  m.lmax, m.convention = o.lmax, convention
  m.samples, m.seed, m.shading, m.visibility = o.samples, o.seed, o.shading, o.visibility
  m.transfer_samples, m.occlusion_distance = o.transfer_samples, tostring(o.occlusion_distance)
  m.points, m.seconds = report.points, report.seconds.total
  for key, value in pairs(extra or {}) do if value ~= nil then m[key] = tostring(value) end end
end

--- The report that all methods begin with; seconds.light is that of asking for light and shading.
local function new_report(p)
  local st = p.stats
  return {
    note = st.points == 0 and "the camera sees no geometry: nothing to shade" or nil,
    points = st.points, hits = st.hits, pixels = st.pixels, bytes = st.bytes,
    rays = { primary = st.primary_rays, occlusion = st.occlusion_rays },
    seconds = { scene = st.scene_seconds, primary = st.primary_seconds, transfer = st.transfer_seconds },
  }
end

--- Completes times: layers since `start` without light; total of everything that this picture needed.
local function finish(report, start, light_seconds)
  local s = report.seconds
  s.light = light_seconds
  s.image = core.seconds() - start - light_seconds
  s.total = s.scene + s.primary + s.transfer + s.light + s.image
  return report
end

describe "true_error" {
  about = "Adds to an image the layer true_error: |radiance - truth's radiance|, per channel.",
  arguments = { { "image", "image", "" }, { "truth", "image", "of the same size, e.g. from scene:reference" } },
  returns = { { "image", "image", "the first argument" } },
  errors = "raises where the sizes differ or a layer is missing",
  example = [[
local a, b = ylm.image { size = { 4, 2 } }, ylm.image { size = { 4, 2 } }
a:layer():set(1, 1, 1, 0.5)
assert(ylm.true_error(a, b):layer "true_error":get(1, 1, 1) == 0.5)]],
}
function render.true_error(picked, truth)
  for n, x in ipairs { picked or false, truth or false } do
    if core.type(x) ~= "ylm.image" then
      return check.bad(n, "true_error", "an image expected, got %s", check.describe(x))
    end
  end
  local a, b = picked.size, truth.size
  if a[1] ~= b[1] or a[2] ~= b[2] then
    return check.bad(2, "true_error", "an image of %dx%d expected, got %dx%d", a[1], a[2], b[1], b[2])
  end
  local lib, message, code = library()
  if not lib then return nil, message, code end
  local _, channels = picked:layers()
  local out
  if channels.true_error then out = picked:layer "true_error"
  else
    out, message, code = picked:add("true_error", 3)
    if not out then return nil, message, code end
  end
  assert(check.result("true_error", lib.shade_difference(picked:layer "radiance", truth:layer "radiance", out)))
  return picked
end

local function check_truth(name, p, o)
  if not o.truth then return end
  local size = o.truth.size
  if size[1] ~= p.options.size[1] or size[2] ~= p.options.size[2] then
    return check.fail("%s: truth must be an image of %dx%d, got %dx%d", name, p.options.size[1], p.options.size[2],
      size[1], size[2])
  end
end

--- Radiance of a view under a dynamic grid: only what changed since the last time is sampled.
local function shade_again(name, p, o, bar)
  local m = made[p.view]
  if not m.memory then
    local memory, message, code = check.result(name, p.lib.shade_memory(p.view))
    if not memory then return nil, message, code end
    m.radiance, message, code = core.array_zeros({ p.stats.points, 3 }, "float")
    if not m.radiance then return nil, message, code end
    m.memory = memory
  end
  return check.result(name, p.lib.shade_grid_again(p.view, m.memory, o.grid, o.interpolation, o.threads or 0, bar,
    m.radiance))
end

--- Levels and errors of the grid's cells at shading points, where layers are asked for; false, message, code.
local function cells_of(p, o)
  if not o.layers then return nil end
  local level, error = p.lib.shade_grid_cells(p.view, o.grid, o.threads or 0)
  if not level then return false, error, "ENOMEM" end
  return { level = level, error = error }
end

--- Renders a prepared view by a grid on a device: an image, or with download = false a gpu_array [height][width][3].
local function by_device(name, p, o)
  local start, report, bar = core.seconds(), new_report(p), progress.resolve(o.progress)
  local device = require "ylm.vulkan_image"
  local function write(picture_of)
    local done, message, code = device.render(name, p, o, picture_of, bar, compose)
    if not done then return nil, message, code end
    report.outside, report.unbaked, report.stages, report.seconds.light = done.outside, done.unbaked, done.stages, done.seconds
    return true
  end
  local out, message, code
  if o.download == false then
    out, message, code = device.room(name, p, o)
    if not out then return nil, message, code end
    local ok
    ok, message, code = write(out)
    if not ok and out ~= o.out then out:close() end
    if not ok then return nil, message, code end
    return out, finish(report, start, report.seconds.light)
  end
  local cells
  cells, message, code = cells_of(p, o)
  if cells == false then return nil, message, code end
  out, message, code = picture(name, p, write, o, cells)
  if not out then return nil, message, code end
  finish(report, start, report.seconds.light)
  sign(out, p, "grid", report, { interpolation = o.interpolation, grid_points = o.grid.stats.points })
  return out, report
end

--- Renders a prepared view by a grid, or any object with a light field.
local function by_grid(name, p, o)
  check_truth(name, p, o)
  if o.device then
    if core.type(o.grid) ~= "ylm.grid" then
      return check.bad(1, name, "device: a baked grid expected, got %s", check.describe(o.grid))
    end
    if o.out and o.download ~= false then
      return check.bad(1, name, "out: a picture that comes back is a new image; download = false writes an array")
    end
    return by_device(name, p, o)
  end
  if o.download == false or o.out then
    return check.bad(1, name, "%s: name the device that the picture is to stay on", o.out and "out" or "download")
  end
  local start, grid, lib = core.seconds(), o.grid, p.lib
  local bar, threads = progress.resolve(o.progress), o.threads or 0
  local report, cells = new_report(p), nil
  local radiance, outside, unbaked, seconds
  if core.type(grid) == "ylm.grid" and lib.shade_grid then
    if grid.dynamic then
      radiance, outside, unbaked, seconds, report.fresh = shade_again(name, p, o, bar)
    else
      radiance, outside, unbaked, seconds =
        check.result(name, lib.shade_grid(p.view, grid, o.interpolation, threads, bar))
    end
    if not radiance then return nil, outside, unbaked end
    report.outside, report.unbaked = outside, unbaked
    cells, outside, unbaked = cells_of(p, o)
    if cells == false then return nil, outside, unbaked end
  else
    radiance, report.pairs, seconds = check.result(name, lib.shade_field(p.view, grid, "float", threads, bar))
    if not radiance then return nil, report.pairs, seconds end
    seconds = core.seconds() - start
  end
  local out, message, code = picture(name, p, radiance, o, cells)
  if not out then return nil, message, code end
  finish(report, start, seconds)
  local stats = type(grid.stats) == "table" and grid.stats or {}
  sign(out, p, "grid", report, { interpolation = o.interpolation, grid = tostring(grid), tolerance = grid.tolerance,
    threshold = grid.threshold, grid_points = stats.points, grid_seconds = stats.seconds, outside = outside,
    unbaked = unbaked })
  return out, report
end

--- Renders a prepared view with the lights' own coefficients at every shading point.
local function by_lights(name, p, o)
  check_truth(name, p, o)
  local start = core.seconds()
  local report = new_report(p)
  local lights, message, code = light.within(name, p.traced.lights, o.light_tolerance, o.threads)
  if not lights then return nil, message, code end
  local radiance, pairs
  radiance, pairs, code = check.result(name, p.lib.shade_field(p.view, lights, o.dtype, o.threads or 0,
    progress.resolve(o.progress)))
  if not radiance then return nil, pairs, code end
  local seconds = core.seconds() - start
  report.pairs = pairs
  local out
  out, message, code = picture(name, p, radiance, o)
  if not out then return nil, message, code end
  finish(report, start, seconds)
  sign(out, p, "reference", report, { dtype = o.dtype, light_tolerance = o.light_tolerance, pairs = ("%.0f"):format(pairs) })
  return out, report
end

--- Renders a prepared view by sampling the lamps.
local function by_rays(name, p, o)
  check_truth(name, p, o)
  local start = core.seconds()
  local report = new_report(p)
  local radiance, rays, code = check.result(name, p.lib.shade_raycast(p.view, o.samples, o.shadows,
    o.seed or p.options.seed, o.threads or 0, progress.resolve(o.progress)))
  if not radiance then return nil, rays, code end
  local seconds = core.seconds() - start
  report.rays.shadow = rays
  local out, message
  out, message, code = picture(name, p, radiance, o)
  if not out then return nil, message, code end
  finish(report, start, seconds)
  sign(out, p, "raycast", report, { shadow_rays = o.samples, shadows = o.shadows })
  return out, report
end

-- Methods of prepared views --------------------------------------------------------------------

local prepare_options = list(view_fields "samples", transfer_fields, common)
local prepared_render = list(grid_fields, {
  { "lamps", "any", optional = true,
    about = "sphere lights to draw that are not in the prepared scene, because they move" },
  { "download", "boolean", default = true,
    about = "false: a picture made on the device stays there, as a gpu_array [height][width][3] of radiance" },
  { "out", "any", optional = true, about = "with download = false: the gpu_array to be written and returned" },
}, layer_fields, common)
local prepared_reference = list(reference_fields, layer_fields, common)
local prepared_raycast = list(ray_fields, {
  { "seed", "integer", min = 0, max = 2 ^ 32, optional = true, about = "default: that of the view" },
}, layer_fields, common)

local one_lamp = [[
local scene = ylm.scene "one lamp" {
  camera = ylm.camera { from = { 0, 3, 4 } },
  geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
}
]]

local report_text = "note (where nothing is to be shaded), "
  .. "seconds (by stage: scene, primary, transfer, light, image; total), rays, points, hits, pixels; "

describe "scene:prepare" {
  about = "Traces a camera's rays and the visibility of what they hit, once, for any number of renderings.",
  arguments = { { "options?", "table", "" } },
  options = prepare_options,
  returns = { { "view", "prepared", "view:render, view:reference, view:raycast, view:points; view.stats, .options" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
local image, report = view:reference()
assert(image.size[1] == 32 and report.points == view.stats.points)]],
  source = "Iwasaki & Dobashi 2025, Sec. 6.2",
}
function render.prepare(s, given)
  check_scene("prepare", s)
  local o = form.options(1, "prepare", prepare_options, given)
  o.lmax = o.lmax or default_lmax(s)
  return prepare("prepare", s, o)
end

describe "prepared:render" {
  about = "Shades a prepared view by a grid. Only sampling and shading are done, report.seconds.light says how long. "
    .. "Of a grid made with dynamic = true only what grid:update changed since the last time is sampled.",
  arguments = { { "options", "table", "grid is needed" } },
  options = prepared_render,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "outside, unbaked: shading points; "
    .. "of a dynamic grid fresh: those that were sampled" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
local lights = ylm.sphere_lights { at = { { 0, 1, 0 } }, radius = 0.1, radiance = 50 }
local image = view:render { grid = lights.lights }     -- anything that has a light field
assert(image:layer "radiance":get(9, 16, 1) > 0)]],
}
function prepared.render(view, given)
  local p = open("render", view)
  local o = form.options(1, "render", prepared_render, given)
  check_grid("render", o.grid)
  return by_grid("render", p, o)
end

describe "prepared:reference" {
  about = "Shades a prepared view with the lights' coefficients at every shading point: no interpolation.",
  arguments = { { "options?", "table", "" } },
  options = prepared_reference,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "pairs: light x point evaluations" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
assert(view:reference { dtype = "double" })]],
}
function prepared.reference(view, given)
  local p = open("reference", view)
  return by_lights("reference", p, form.options(1, "reference", prepared_reference, given))
end

describe "prepared:raycast" {
  about = "Shades a prepared view by rays to the lamps: no spherical harmonics, no occlusion_distance.",
  arguments = { { "options?", "table", "" } },
  options = prepared_raycast,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "rays.shadow" } },
  errors = "raises on a bad option; nil, message, code where memory runs out or it is cancelled",
  example = one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 4 }
assert(view:raycast { samples = 16 })]],
  source = "Shirley, Wang, Zimmerman 1996",
}
function prepared.raycast(view, given)
  local p = open("raycast", view)
  return by_rays("raycast", p, form.options(1, "raycast", prepared_raycast, given))
end

describe "prepared:points" {
  about = "Where a prepared view asks for light.",
  arguments = {},
  returns = { { "points", "table",
    "position [n][3], normal [n][3], albedo [n][3], object [n]: place in scene.geometry" } },
  errors = "raises on what is no prepared view; nil, message, code where memory runs out",
  example = one_lamp .. [[
local points = scene:prepare({ size = { 32, 18 }, samples = 1 }):points()
assert(points.position.shape[2] == 3 and points.object:get(1) == 1)]],
}
function prepared.points(view)
  local p = open("points", view)
  local position, normal, albedo, object = p.lib.shade_points(p.view)
  if not position then return nil, normal, albedo end
  return { position = position, normal = normal, albedo = albedo, object = object }
end

describe "prepared:transfer" {
  about = "The transfer vectors of a prepared view: SH coefficients of cosine times visibility.",
  arguments = {},
  returns = { { "T", "array", "float [n][(lmax+1)^2]; radiance is albedo / pi times its product with light" } },
  errors = "raises on what is no prepared view; nil, message, code where memory runs out",
  example = one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 1, lmax = 2 }
assert(view:transfer().shape[2] == 9)]],
}
function prepared.transfer(view)
  local p = open("transfer", view)
  return check.result("transfer", p.lib.shade_transfer(p.view))
end

describe "prepared:close" {
  about = "Frees the memory of a prepared view now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no prepared view",
  example = one_lamp .. 'scene:prepare({ size = { 32, 18 }, samples = 1 }):close()',
}
function prepared.close(view)
  if core.type(view) ~= "ylm.prepared" then
    return check.fail("close: a prepared view expected before the colon, got %s", check.describe(view))
  end
  check.result("close", made[view].lib.shade_close_view(view))
  made[view].closed = true
end

-- Methods of scenes -------------------------------------------------------------------------------

local bake_options = list(view_fields "samples", {
  { "probes", "object", of = { "adaptive_grid", "uniform_grid" }, optional = true, about = "instead of the scene's" },
  { "occupied", "any", default = "camera",
    about = "the shading points: 'camera' (what its rays hit), 'vertices' (all of them), 'everywhere', "
      .. "a prepared view, or an array [n][3]" },
  { "shading", "choice", of = { "pixel", "vertex" }, default = "pixel",
    about = "with 'camera': what rays hit, or the vertices of the triangles they hit" },
  light.tolerance_option "light_tolerance",
}, common)

--- The shading points that a bake is to serve, as an array; nil: everywhere. Else false, message, code.
local function occupied_points(s, t, o)
  local x = o.occupied
  if x == "everywhere" then return nil end
  if x == "vertices" then return t.lib.shade_vertices(t.handle) end
  if core.type(x) == "ylm.prepared" then return t.lib.shade_positions(open("bake", x).view) end
  if core.type(x) == "ylm.array" then return x end
  if x ~= "camera" then
    return check.fail("bake: occupied must be 'camera', 'vertices', 'everywhere', a prepared view or an array, got %s",
      check.describe(x))
  end
  local view, message, code = prepare("bake", s, { size = o.size, samples = o.samples, seed = o.seed, share = o.share,
    shading = o.shading, visibility = "none", transfer_samples = 1, lmax = 0, threads = o.threads,
    progress = o.progress })
  if not view then return false, message, code end
  local points = t.lib.shade_positions(view)
  view:close()
  return points
end

describe "scene:bake" {
  about = "Bakes a scene's probes: a grid of its lights for the points that its camera sees.",
  arguments = { { "options?", "table", "the view's default to those of scene:render" } },
  options = bake_options,
  returns = { { "grid", "grid", "bounds default to the box around the geometry" } },
  errors = "raises where there are no probes, no lights or a bad option; nil, message, code: memory, cancelled",
  example = one_lamp .. [[
local probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 }
local grid = scene:bake { probes = probes, size = { 32, 18 }, samples = 4 }
assert(grid.stats.points > 0)]],
}
function render.bake(s, given)
  check_scene("bake", s)
  local o = form.options(1, "bake", bake_options, given)
  local probes = o.probes or s.probes
  if not probes then
    return check.fail("bake: scene %q has no probes (probes = adaptive_grid { ... })", s.name or "?")
  end
  local t, message, code = trace("bake", s)
  if not t then return nil, message, code end
  local points
  points, message, code = occupied_points(s, t, o)
  if points == false then return nil, message, code end
  if points and #points == 0 then
    local seen = o.occupied == "camera" or core.type(o.occupied) == "ylm.prepared"
    return check.fail("bake: no shading points: %s",
      seen and "the camera sees no geometry (occupied = 'everywhere' needs none)"
        or "occupied is empty")
  end
  return require("ylm.grid").bake(probes, t.lights, { occupied = points, bounds = bounds_of(t), threads = o.threads,
    progress = o.progress, light_tolerance = o.light_tolerance })
end

local render_options = list(view_fields "samples", transfer_fields, grid_fields, baked_fields, layer_fields, common)

describe "scene:render" {
  about = "Renders a scene by a grid (default: scene:bake of what the camera sees).",
  arguments = { { "options?", "table", "" } },
  options = render_options,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "outside, unbaked: shading points" } },
  errors = "raises on a bad option, no camera, neither grid nor probes; nil, message, code: memory, cancelled",
  example = one_lamp .. [[
local grid = scene:bake { probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 }, size = { 32, 18 } }
local image, report = scene:render { grid = grid, size = { 32, 18 }, samples = 4 }
assert(image:layer "level" and report.seconds.light)]],
  source = "Iwasaki & Dobashi 2025, Sec. 6.2",
}
function render.render(s, given)
  check_scene("render", s)
  local o = form.options(1, "render", render_options, given)
  if not (o.grid == nil and s.probes) then check_grid("render", o.grid) end
  if o.grid and o.light_tolerance then
    return check.fail "render: light_tolerance is for baking the scene's probes, this grid is baked: leave one out"
  end
  o.lmax = o.lmax or default_lmax(s, o.grid)
  local view, message, code = prepare("render", s, o)
  if not view then return nil, message, code end
  if not o.grid and made[view].stats.points == 0 then
    o.grid = made[view].traced.lights -- no grid can be baked for no points; no point will ask what light there is
  elseif not o.grid then
    o.grid, message, code = render.bake(s, { occupied = view, threads = o.threads, progress = o.progress,
      light_tolerance = o.light_tolerance })
    if not o.grid then return nil, message, code end
  end
  return by_grid("render", open("render", view), o)
end

local reference_options = list(view_fields "samples", transfer_fields, reference_fields, layer_fields, common)

describe "scene:reference" {
  about = "Renders a scene with the lights' coefficients at every shading point: what an exact grid would give.",
  arguments = { { "options?", "table", "" } },
  options = reference_options,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "pairs: light x point evaluations" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = one_lamp .. "assert(scene:reference { size = { 32, 18 }, samples = 4 })",
}
function render.reference(s, given)
  check_scene("reference", s)
  local o = form.options(1, "reference", reference_options, given)
  o.lmax = o.lmax or default_lmax(s)
  local view, message, code = prepare("reference", s, o)
  if not view then return nil, message, code end
  return by_lights("reference", open("reference", view), o)
end

local raycast_options = list(view_fields "pixel_samples", ray_fields, layer_fields, common)

describe "scene:raycast" {
  about = "Renders a scene by rays to the lamps, chosen by what they would bring: what spherical harmonics lose shows.",
  arguments = { { "options?", "table", "" } },
  options = raycast_options,
  returns = { { "image", "image", "" }, { "report", "table", report_text .. "rays.shadow" } },
  errors = "raises on a bad option or a scene without camera; nil, message, code: memory, cancelled",
  example = one_lamp .. "assert(scene:raycast { size = { 32, 18 }, pixel_samples = 4, samples = 8 })",
  source = "Shirley, Wang, Zimmerman 1996",
}
function render.raycast(s, given)
  check_scene("raycast", s)
  local o = form.options(1, "raycast", raycast_options, given)
  local rays = o.samples
  o.samples, o.lmax, o.shading, o.visibility = o.pixel_samples, 0, "pixel", "none"
  local view, message, code = prepare("raycast", s, o)
  if not view then return nil, message, code end
  o.samples = rays
  return by_rays("raycast", open("raycast", view), o)
end

return render
