--- Grids of scenes: where their light is needed, and what they hold.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local grids = require "ylm.grid"
local light = require "ylm.light"
local objects = require "ylm.transfer.object"
local options = require "ylm.render.options"
local prints = require "ylm.render.prints"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local transfer = require "ylm.transfer"
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

--- The quantity that a bake of a scene holds where nobody says.
local function default_parts() return "lights" end

--- Reflections on elements for `bounces` of them before the light of a grid; raises where there is no light to hold.
local function reflections(o)
  if o.parts == "direct" then return 0 end
  if o.bounces == nil or o.bounces == "all" then return "all" end
  if o.bounces > 0 then return o.bounces - 1 end
  if o.parts == "all" then return 0 end
  return check.fail "bake: bounces = 0 is direct light alone, parts = 'indirect' would be dark: bounces = 1, 2 .. or 'all'"
end

--- The light field that is baked: the scene's lights, or light with shadows and bounces; or nil, message, code.
local function field_of(s, t, o)
  if o.lights ~= nil then return o.lights end
  if o.parts == "lights" then return t.lights end
  local n = reflections(o)
  local direct = o.parts == "direct" or o.bounces == 0
  local links, lit, message, code = o.transfer
  if not links then
    links, message, code = transfer.of_scene(s, { links = direct and 4 or nil, lmax = 0, threads = o.threads,
      progress = o.progress })
    if not links then return nil, message, code end
  end
  lit, message, code = links:radiosity(s.lights, { bounces = n, light_samples = direct and 1 or nil, threads = o.threads,
    progress = o.progress })
  if not lit then return nil, message, code end
  return lit:field { parts = direct and "direct" or o.parts }
end

--- The fingerprints of the light that is baked; nil of light that options name, which need not be the scene's.
local function prints_of(t, o)
  if o.lights ~= nil then return nil end
  return prints.of(t, o.bounces == 0 and "direct" or o.parts)
end

--- Raises where options of gathered light stand beside others that have no use for it.
local function check_parts(s, o, probes)
  if o.bounces and o.parts ~= "indirect" and o.parts ~= "all" then
    return check.fail "bake: bounces are of parts = 'indirect' or 'all': name one, or leave bounces out"
  end
  if o.transfer then
    if o.parts == "lights" then
      return check.fail "bake: transfer is for parts = 'direct', 'indirect' or 'all': name one, or leave transfer out"
    end
    objects.check_scene("bake", o.transfer, s)
  end
  if o.parts == "lights" then return end
  if o.lights ~= nil then
    return check.fail("bake: lights are baked as parts = 'lights', these are %q: leave one out", o.parts)
  end
  for _, name in ipairs { "device", "sums_tolerance" } do
    if o[name] then
      return check.fail("bake: %s is for parts = 'lights', these are %q: leave %s out", name, o.parts, name)
    end
  end
  if probes.dynamic then
    return check.fail("bake: a dynamic grid follows lights, parts = 'lights', these are %q (grid:refresh follows a field)",
      o.parts)
  end
  reflections(o)
end

local bake_options = options.list(options.view_fields, {
  { "probes", "object", of = core.choices "grid_form", optional = true, about = "instead of the scene's" },
  { "parts", "choice", of = { "lights", "direct", "indirect", "all" }, optional = true,
    about = "what the grid holds: 'lights', light that nothing occludes (default); 'direct', light of lamps and sky with "
      .. "shadows; 'indirect', what surfaces send back; 'all', both" },
  { "lights", "any", optional = true, about = "instead of the scene's, of parts = 'lights': lights or what has a light field, as "
    .. "in ylm.bake; of virtual lights the far parts (lights:split)" },
  { "bounces", "bounces", optional = true, about = "of 'indirect' and 'all': reflections after direct light, default 'all'" },
  { "transfer", "object", of = "ylm.transfer", optional = true,
    about = "of 'direct', 'indirect' and 'all': what scene:transfer returned; default: one with its defaults" },
  { "occupied", "any", default = "surfaces",
    about = "where light is needed: 'surfaces' (the whole geometry), 'camera' (what its rays hit: size, samples, share and "
      .. "shading are about them), 'vertices' (all of them), 'everywhere', a prepared view, or an array [n][3], with device "
      .. "also a gpu_array" },
  { "shading", "choice", of = { "pixel", "vertices" }, default = "pixel",
    about = "with 'camera': what rays hit, or the vertices of the triangles they hit" },
  light.tolerance_option "sums_tolerance",
  { "folder", "path", optional = true, about = "a folder, name.ylmd, that the grid is baked into in bricks, as in ylm.bake; with "
    .. "fresh, seconds" },
  { "fresh", "boolean", default = false, about = "with folder: begins anew whatever is in the folder" },
  { "time_limit", "number", above = 0, optional = true, unit = "s", about = "with folder: no brick is begun that would take longer" },
  { "team", "object", of = "team", optional = true, about = "ylm.team(), of ylm.bake; every process prepares the light field" },
  { "device", "gpu", optional = true, about = "bakes there, as ylm.bake does; a prepared view's points are copied there once" },
}, options.common)

describe "scene:bake" {
  about = "Bakes a scene's probes: a grid of its light for the surfaces of its geometry, or for what its camera sees.",
  arguments = { { "options?", "table", "the camera's default to those of scene:render" } },
  options = bake_options,
  returns = { { "grid", "grid", "bounds default to the box around the geometry; probes on its sides that are walls see from "
    .. "within" } },
  errors = "raises where there are no probes or a bad option; nil, message, code: memory, cancelled",
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
  if not probes then
    return check.fail("bake: scene %q has no probes (probes = adaptive_grid { ... })", s.name or "?")
  end
  check_camera_options(given, o)
  o.parts = o.parts or default_parts(s, o, probes)
  check_parts(s, o, probes)
  local t, message, code = tracing.trace("bake", s)
  if not t then return nil, message, code end
  local where, own, why = occupied(s, t, o)
  if where == false then return nil, own, why end
  check_points(where)
  local field, grid
  field, message, code = field_of(s, t, o)
  if field then
    grid, message, code = grids.bake_scene(probes, field, { occupied = where,
      geometry = where == "surfaces" and s.geometry or nil,
      bounds = box.padded(t.lo, t.hi), seed = o.seed, threads = o.threads, progress = o.progress,
      sums_tolerance = o.sums_tolerance, device = o.device, team = o.team, folder = o.folder,
      fresh = o.fresh, time_limit = o.time_limit }, prints_of(t, o))
  end
  if own then where:close() end
  return grid, message, code
end

return bake
