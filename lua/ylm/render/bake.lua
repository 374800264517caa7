--- Grids of scenes: where their light is needed, and what they hold.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local grids = require "ylm.grid"
local light = require "ylm.light"
local options = require "ylm.render.options"
local prints = require "ylm.render.prints"
local promise = require "ylm.render.promise"
local progress = require "ylm.progress"
local surfaces = require "ylm.render.surfaces"
local tracing = require "ylm.trace"
local transfer = require "ylm.transfer"
local unmet = require "ylm.grid.unmet"
local views = require "ylm.render.view"

local bake = {}

-- Where light is needed ---------------------------------------------------------------

--- Raises where options that are about the camera alone are given and would be ignored.
local function check_camera_options(given, o)
  if o.occupied == "camera" or type(given) ~= "table" then return end
  for _, name in ipairs { "size", "samples", "share", "shading" } do
    if given[name] ~= nil then
      return check.fail("bake: %s is about the camera's rays: give occupied = 'camera' too, or leave it out", name)
    end
  end
end

--- The option `occupied` of ylm.bake, nil for everywhere; true where it is to be closed after the bake. Or false, message,
-- code.
local function occupied(s, t, o)
  local x = o.occupied
  if x == "everywhere" then return nil end
  if x == "surfaces" then
    if #s.geometry > 0 then return x end
    return check.fail("bake: scene %q has no geometry, so no surfaces (occupied = 'everywhere' needs none)", s.name or "?")
  end
  if x == "vertices" then return t.lib.scene_vertices(t.handle) end
  if core.type(x) == "ylm.view" then return views.open("bake", x).view end
  if core.type(x) == "ylm.array" or core.type(x) == "ylm.gpu_array" then return x end
  if x ~= "camera" then
    return check.fail("bake: occupied must be 'surfaces', 'camera', 'vertices', 'everywhere', a prepared view or an array, "
      .. "got %s", check.describe(x))
  end
  local view, message, code = views.prepare("bake", s, { size = o.size, samples = o.samples, seed = o.seed, share = o.share,
    shading = o.shading, visibility = "rays", lmax = 0, coarse = true, threads = o.threads, progress = o.progress })
  if not view then return false, message, code end
  return view, true
end

--- Raises where a view or an array has no points.
local function check_points(points)
  if core.type(points) == "ylm.view" and views.made[points].stats.points == 0 then
    return check.fail "bake: no shading points: the camera sees no geometry (occupied = 'everywhere' needs none)"
  end
  if core.type(points) == "ylm.array" and #points == 0 then
    return check.fail "bake: no shading points: occupied is empty"
  end
end

-- The light that is held ----------------------------------------------------------------

--- The light field that is baked: the scene's lights, or light with shadows and bounces; or nil, message, code.
local function field_of(s, t, o)
  if o.lights ~= nil then return o.lights end
  if o.quantity == "lights" then return t.lights end
  return transfer.fields.gathered("bake", s, o)
end

--- The fingerprints of the light that is baked; nil of light that options name, which need not be the scene's.
local function prints_of(t, o)
  if o.lights ~= nil then return nil end
  return prints.of(t, o.bounces == 0 and "direct" or o.quantity)
end

--- Raises where options of gathered light stand beside others that have no use for it.
local function check_quantity(s, o, probes)
  transfer.fields.check("bake", s, o)
  if o.quantity == "lights" then return end
  if o.lights ~= nil then
    return check.fail("bake: lights are baked as quantity = 'lights', this is %q: leave one out", o.quantity)
  end
  for _, name in ipairs { "device", "sums_tolerance" } do
    if o[name] then
      return check.fail("bake: %s is for quantity = 'lights', this is %q: leave %s out", name, o.quantity, name)
    end
  end
  if probes.dynamic then
    return check.fail("bake: a dynamic grid follows lights, quantity = 'lights', this is %q (grid:update brings other fields to "
      .. "grids without dynamic = true)", o.quantity)
  end
end

--- Options of scene:bake that hold where there are no probes: those of the light on surfaces.
local OF_SURFACES = { "quantity", "bounces", "links", "judge", "seed", "threads", "progress" }

--- The light on the surfaces of a scene that has no probes.
local function on_surfaces(s, given)
  if #s.geometry == 0 then
    return check.fail("bake: scene %q has neither probes (probes = adaptive_grid { ... }) nor surfaces", s.name or "?")
  end
  local o, known = {}, {}
  for _, name in ipairs(OF_SURFACES) do known[name] = true end
  for name, value in pairs(given or {}) do
    if not known[name] or value == "lights" and name == "quantity" then
      return check.fail("bake: %s is of probes, and scene %q has none, so that its surfaces are baked: give probes = "
        .. "adaptive_grid { ... }, or leave it out", name == "quantity" and "quantity = 'lights'" or name, s.name or "?")
    end
    o[name] = value
  end
  return surfaces.surface_grid(s, o)
end

local bake_options = options.list(options.view_fields, {
  { "probes", "object", of = core.choices "grid_form", optional = true,
    about = "instead of the scene's. Without any the light on the scene's surfaces is baked, as scene:surface_grid finds it: "
      .. "quantity ('indirect' by default), bounces, links, judge, seed, threads and progress are then the options" },
  transfer.fields.quantity,
  { "lights", "any", optional = true, about = "instead of the scene's, of quantity = 'lights': lights or what has a light "
    .. "field, as in ylm.bake; of virtual lights the far parts (lights:split)" },
  transfer.fields.bounces, transfer.fields.links,
  { "judge", "choice", of = { "paths", "field" }, default = "paths", shelf = "experiments",
    about = "what a tolerance on irradiance is judged by, in a grid with sides: paths, up to 16384 from each of 2048 places; or "
      .. "the light field that was baked, whose own error is not seen" },
  { "occupied", "any", default = "surfaces",
    about = "where light is needed: 'surfaces' (the whole geometry), 'camera' (what its rays hit: size, samples, share and "
      .. "shading are about them), 'vertices' (all of them), 'everywhere', a prepared view, or an array [n][3], with device "
      .. "also a gpu_array" },
  { "within", "bounds", optional = true,
    about = "with occupied = 'surfaces': a tolerance is of the surfaces in this box. Default: what stands on grounds, where the "
      .. "camera is in that: connected triangles that lie flat and are far wider than all else" },
  { "shading", "choice", of = { "pixel", "vertices" }, default = "pixel",
    about = "with 'camera': what rays hit, or the vertices of the triangles they hit" },
  light.tolerance_option "sums_tolerance",
  { "folder", "path", optional = true, about = "a folder, name.ylmd, that the grid is baked into in bricks, as in ylm.bake; with "
    .. "fresh, time_limit" },
  { "fresh", "boolean", default = false, about = "with folder: begins anew whatever is in the folder" },
  { "time_limit", "number", above = 0, optional = true, unit = "s",
    about = "with folder: no brick is begun that would take longer" },
  { "team", "object", of = "team", optional = true, about = "ylm.team(), of ylm.bake; every process prepares the light field" },
  { "device", "gpu", optional = true, about = "bakes there, as ylm.bake does; a prepared view's points are copied there once" },
}, options.common)

describe "scene:bake" {
  shelf = "everyday",
  about = "Bakes a scene's probes: a grid of its light for the surfaces of its geometry, or for what its camera sees. Of a scene "
    .. "without probes the light on its surfaces is baked: scene:surface_grid.",
  arguments = { { "options?", "table", "the camera's default to those of scene:render" } },
  options = bake_options,
  returns = { { "grid", "grid|surface_grid", "bounds default to the box around the geometry; surface_grid: of a scene without "
    .. "probes" } },
  errors = "raises where there are neither probes nor geometry, or on a bad option; nil, message, code: memory, cancelled",
  example = options.one_lamp .. [[
local probes = ylm.uniform_grid { cells = { 4, 4, 4 }, lmax = 2 }
local grid = scene:bake { probes = probes }
local seen = scene:bake { probes = probes, occupied = "camera", size = { 32, 18 }, samples = 4 }
assert(grid.stats.points >= seen.stats.points)]],
}
function bake.bake(s, given)
  tracing.check_scene("bake", s)
  local o = form.options(1, "bake", bake_options, given)
  o.progress = progress.long(o.progress)
  local probes = o.probes or s.probes
  if not probes then return on_surfaces(s, given) end
  check_camera_options(given, o)
  check_quantity(s, o, probes)
  local t, message, code = tracing.trace("bake", s)
  if not t then return nil, message, code end
  local where, own, why = occupied(s, t, o)
  if where == false then return nil, own, why end
  check_points(where)
  local field, grid
  local by_paths = o.judge == "paths" and o.lights == nil and o.quantity ~= "lights"
  field, message, code = field_of(s, t, o)
  local within = o.within
  if field and not within and where == "surfaces" then
    within, message, code = tracing.without_grounds("bake", s)
    if code then field = nil end
  end
  if field then
    grid, message, code = grids.bake_scene(probes, field, { occupied = where,
      geometry = where == "surfaces" and s.geometry or nil,
      bounds = box.padded(t.lo, t.hi), within = within, seed = o.seed, threads = o.threads, progress = o.progress,
      sums_tolerance = o.sums_tolerance, device = o.device, team = o.team, folder = o.folder,
      fresh = o.fresh, time_limit = o.time_limit }, prints_of(t, o), nil, by_paths)
  end
  if grid and by_paths and core.type(grid) == "ylm.grid" then
    local judged
    judged, message, code = promise.judge(s, grid, o)
    if judged then unmet.warn(grid) else grid = nil end
  end
  if own then where:close() end
  return grid, message, code
end

return bake
