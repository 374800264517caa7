--- Prepared views: everything that does not depend on how the light is known: camera rays, shading points, occlusion rays,
-- transfer vectors. Views are made once and rendered as often as one likes, so that methods are compared on the very same
-- points.

require "ylm.array" -- the methods of the arrays that are returned
local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local window = require "ylm.sh.window"
local show = require "ylm.show"

local views = {}

--- The noise at which rays are enough, and the most rays, without transfer_samples: see options.vector_fields.
local NOISE, MOST_SAMPLES = 0.02, 2048

local DEGREES = core.limits.material_table_lmax + 1 -- of slices

local GIVEN_SAMPLES = core.limits.light_samples -- the most that transfer_samples may be

require "ylm.describe".object "view" {
  about = "The part of a scene that one camera sees, prepared (scene:prepare) to be shaded: by rays to its lamps, or with "
    .. "transfer vectors by any light field. The drawings of ylm.view { .. } have bars, window, show and save alone.",
  fields = {
    { "stats", "table", "points, hits, pixels, primary_rays, occlusion_rays, scene_seconds, primary_seconds, "
      .. "transfer_seconds, bytes; transfer_samples, noise as in a report" },
    { "options", "table", "what it was made with" },
    { "scene", "scene", "of what" },
  },
}

--- Methods of the userdata "ylm.view"; what it was made of stands in its own table.
local prepared = tracing.library() and core.metatable "ylm.view" or {}
local made = setmetatable({}, {
  __index = function(_, view) return core.owned(view, "made") end,
  __newindex = function(_, view, m) core.own(view).made = m end,
})
views.methods, views.made = prepared, made

prepared.__index = function(view, key)
  local m = made[view]
  if m and (key == "stats" or key == "options" or key == "scene") then return m[key] end
  return rawget(prepared, key)
end

prepared.__newindex = function(_, key)
  return check.fail("view: cannot set %s: a prepared view does not change", check.describe(key))
end

prepared.__tostring = function(view)
  local m = made[view]
  if not m or m.closed then return "ylm.view (closed)" end
  return ("ylm.view of %q: %dx%d, %d shading points"):format(m.scene.name or "?", m.options.size[1],
    m.options.size[2], m.stats.points)
end

--- The prepared view before the colon with all about it: { view, scene, traced, lib, stats, options }.
function views.open(name, view)
  if core.type(view) ~= "ylm.view" then
    return check.fail("%s: a prepared view expected before the colon, got %s", name, check.describe(view))
  end
  if made[view].closed then return check.fail("%s: the prepared view has been closed", name) end
  return setmetatable({ view = view }, { __index = made[view] })
end

--- Where a prepared view asks for light, [n][3] float: an array, or the copy in a device's memory, made where there is none
-- and kept; an array too where the device has no room for it. Or nil, message, code.
function prepared.__positions(view, name, device) return device:positions(name, views.open(name, view)) end

--- The normals of these points, [n][3] float, on the side that is seen: of triangles (flat), or of shading. Or nil, message,
-- code.
function prepared.__normals(view, name, flat)
  local p = views.open(name, view)
  return check.result(name, p.lib.shade_normals(p.view, flat))
end

--- The surfaces of the view's scene. Or nil, message, code.
function prepared.__walls(view, name) return tracing.walls(name, views.open(name, view).scene) end

--- The camera of a scene, or another, as C takes it: from, at, up, fov.
function views.camera_numbers(s, camera)
  local c = camera or s.camera
  return { c.from[1], c.from[2], c.from[3], c.at[1], c.at[2], c.at[3], c.up[1], c.up[2], c.up[3], c.fov }
end

--- Makes the view that options `o` (with samples = camera rays per pixel) describe, whose visibility has been settled.
function views.prepare(name, s, o)
  if not (o.camera or s.camera) then return check.fail("%s: scene %q has no camera", name, s.name or "?") end
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  local visibility = o.visibility
  local distance = o.occlusion_distance
  if not distance and o.self then distance = math.huge
  elseif not distance then
    distance = box.diagonal(t.lo, t.hi) / 10
    if distance == 0 then distance = 1 end
  end
  local at_vertices = o.vectors_at == "vertices" or o.shading == "vertices"
  local rays = o.transfer_samples or at_vertices and 256 or 128
  local light = not o.transfer_samples and #s.lights > 0 and visibility == "transfer" and t.lights or nil
  local view
  view, message, code = check.result(name, t.lib.shade_view(t.handle, {
    camera = views.camera_numbers(s, o.camera), width = o.size[1], height = o.size[2], samples = o.samples,
    lmax = o.lmax, shading = o.shading == "vertices" and "vertex" or "pixel",
    visibility = visibility == "transfer" and (at_vertices and "vertex" or "pixel") or visibility,
    transfer_samples = rays,
    occlusion_distance = distance, share = o.share, seed = o.seed,
    threads = o.threads, progress = progress.resolve(o.progress), light = light, noise = NOISE,
    most_samples = MOST_SAMPLES, pixels = o.pixels, gloss = o.gloss or "matte", gloss_error = o.gloss_error,
    below_dark = o.below == "dark",
    window = o.window and window.factors(o.window, o.window_width or o.lmax + 1, DEGREES - 1) or nil,
    fine = not o.coarse and (visibility == "rays" or o.gloss ~= "matte"), keep = o.relight == "light" or o.relight == "material",
    all_vertices = o.relight == "all", self = o.self }))
  if not view then return nil, message, code end
  local stats = show.report(t.lib.shade_stats(view))
  stats.scene_seconds = t.seconds
  if visibility ~= "transfer" then stats.transfer_samples = nil end
  made[view] = { scene = s, traced = t, lib = t.lib, stats = stats,
    options = { size = o.size, samples = o.samples, seed = o.seed, lmax = o.lmax, share = o.share,
      camera = o.camera or s.camera,
      shading = o.shading, visibility = visibility, self = o.self,
      gloss = o.gloss, gloss_error = o.gloss_error, relight = o.relight,
      transfer_samples = visibility ~= "rays" and (stats.transfer_samples or rays) or nil,
      occlusion_distance = visibility ~= "rays" and distance or nil } }
  return view
end

--- The sentence about a view whose chosen number of rays leaves more noise than it was chosen for; nil: it does not.
function views.loud(p)
  local noise, rays = p.stats.noise, p.stats.transfer_samples
  if not noise or noise <= NOISE then return nil end
  local enough = 2 ^ math.ceil(math.log(rays * (noise / NOISE) ^ 2) / math.log(2))
  local advice = enough <= GIVEN_SAMPLES and ("set transfer_samples = %d"):format(enough)
    or 'too little of the sky is seen for such rays, use by = "rays" (ylm render --by rays)'
  return ("scene %q: %d occlusion rays from each shading point leave a noise of %.1f %%, more than %g %%: %s"):format(
    p.scene.name or "?", rays, 100 * noise, 100 * NOISE, advice)
end

--- The lmax that options leave open.
function views.default_lmax(s, grid)
  if grid and check.is_integer(grid.lmax) then return grid.lmax end
  if s.probes and check.is_integer(s.probes.lmax) then return s.probes.lmax end
  return 4
end

--- Is it a grid, or another object with a light field?
function views.check_grid(name, grid)
  if grid == nil then
    return check.fail("%s: field 'grid' is missing (scene:bake() makes one; by = 'sum' needs none)", name)
  end
  local fault = check.grid_fault(grid)
  if fault then return check.fail("%s: %s", name, fault) end
  if core.type(grid) == "ylm.lights" and not core.lights_count(grid) then
    return check.fail("%s: the lights have been closed", name)
  end
  if core.has_field(grid) then return grid end
  return check.fail("%s: grid must be a grid (scene:bake() makes one), got %s", name, check.describe(grid))
end

return views
