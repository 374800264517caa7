--- ylm.bake, in five steps: what light, where, measured how, baked by whom, remembered.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local field = require "ylm.field"
local form = require "ylm.form"
local light = require "ylm.light"
local progress = require "ylm.progress"
local set = require "ylm.grid.set"
local small = require "ylm.grid.small"
local unmet = require "ylm.grid.unmet"
local where = require "ylm.grid.where"

local bake = {}

local AIM = 0.75 -- of its tolerance, for which a grid is refined that paths will judge: they see the field's error too

local bake_options = {
  { "occupied", "any", optional = true,
    about = "'surfaces': voxels that the triangles of geometry meet, where the tolerance holds by area; or shading points "
      .. "[n][3], where it holds at them, or [n][6] with their normals; or those of a prepared view. Other voxels are not "
      .. "subdivided. Default: 'surfaces' "
      .. "with geometry, else every voxel; with device also a gpu_array, and a view's points are copied there once" },
  { "geometry", "any", optional = true,
    about = "what occupied = 'surfaces' is about: a mesh, a shape (quad, sphere, mesh ...) or a list of them" },
  { "bounds", "bounds", optional = true, about = "where the description has none" },
  { "within", "bounds", optional = true, about = "of occupied = 'surfaces': a tolerance is of the surfaces in this box. Default: "
    .. "in the bounds" },
  { "quantity", "choice", of = core.choices "quantity", optional = true,
    about = "what a field that is a function holds; other fields know it. 'lights': light that nothing occludes (default); "
      .. "'direct': light of lamps and sky with shadows; 'indirect': what surfaces send back; 'all': both" },
  { "scene", "any", optional = true, shelf = "experiments",
    about = "where a function holds light that jumps at surfaces: the scene whose surfaces these are. Voxels that they cross "
      .. "then hold the light of each side; fields of scenes know their surfaces" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of the choice of held-out points" },
  { "max_points", "integer", min = 8, max = core.limits.grid_points, default = 2 ^ 24, about = "nil, message, 'ELIMIT' beyond" },
  light.tolerance_option "sums_tolerance",
  { "folder", "path", optional = true, about = "a path name.ylmd: the grid is baked in bricks, which are files in it. A bake "
    .. "that was interrupted goes on where it was; one that is finished is opened" },
  { "fresh", "boolean", default = false, about = "with folder: begins anew whatever is in the folder" },
  { "brick_points", "integer", min = 512, max = 2 ^ 24, optional = true, about = "with folder: a brick with more evaluated "
    .. "points than this is given up for its eight children; 65536 where it is left out" },
  { "brick_seconds", "number", above = 0, optional = true, unit = "s", about = "with folder: bricks have fewer points where one "
    .. "thread is foreseen to take longer for them, at 0.18 ns for each light, point and coefficient, counted in the levels "
    .. "above; 30 where brick_points is left out too. It bounds what a bake that is ended loses" },
  { "time_limit", "number", above = 0, optional = true, unit = "s",
    about = "with folder: no brick is begun that would take longer than this since "
    .. "the call; nil, 'not finished ..', 'ELIMIT' then, and a call again goes on" },
  set.cache_option,
  form.threads, form.progress,
  { "team", "object", of = "team", optional = true,
    about = "ylm.team(): each of its processes evaluates a part of the points, and all have the grid that one would bake, to the "
      .. "bit; the progress function of the first is called. Points in blocks of 8192 where light is summed by a tree. Not "
      .. "with device, or dynamic = true" },
  { "device", "gpu", optional = true,
    about = "lights are summed there, grids refined there (with a tolerance by the processor, from what the device "
      .. "measures); the grid stays there, for device = gpu of grid:sample and scene:render; grid.stats.stages says how "
      .. "long that took" },
}

--- Refuses a team beside what one process does; options of a process that is not the first: it tells nobody.
local function of_team(description, o)
  if not o.team then return o end
  if o.device ~= nil then
    return check.bad(3, "bake", "team: the processes of a team bake on processors: leave device or team out")
  end
  if description.dynamic then
    return check.bad(3, "bake", "team: a grid with dynamic = true is followed by one process: leave one out")
  end
  if o.team.rank > 1 then o.progress = false end
  return o
end

--- The options of a bake, checked against its description.
local function options_of(description, given)
  local kind = form.kind(description)
  if kind ~= "adaptive_grid" and kind ~= "uniform_grid" then
    return check.bad(1, "bake", "an adaptive_grid or a uniform_grid expected, got %s", check.describe(description))
  end
  local o = of_team(description, form.options(3, "bake", bake_options, given))
  o.progress = progress.long(o.progress)
  if description.dynamic and o.sums_tolerance then
    return check.bad(3, "bake", "a grid with dynamic = true sums its lights exactly: leave sums_tolerance out")
  end
  return o
end

-- The light ----------------------------------------------------------------------------

--- The light that is baked: { field, quantity, jumps (at surfaces), body (of a visibility), tally }, and options, which a body
-- completes. Or nil, message, code.
local function what_light(description, lights, o)
  if form.kind(lights) == "virtual_lights" and lights.profile == "near" then
    return check.bad(2, "bake", "near lights are gathered where they are needed, with near:irradiance; bake the far ones")
  end
  local f, message, code = field.of(2, "bake", lights)
  if not f then return nil, message, code end
  local what = { tally = f:tally() }
  local is_body = f:answers "__for_grid"
  f, message, code = f:joined()
  if not f then return nil, message, code end
  if is_body then
    o, what.body, code = f:for_grid(description, o)
    if not o then return nil, what.body, code end
  end
  if description.dynamic and not f:followed() then
    return check.bad(2, "bake", "a grid with dynamic = true follows sphere lights and flat lights, this is baked from %s: "
      .. "bake that into a second grid, or leave dynamic out", f:other())
  end
  devices.of(o.device):check_bake(description, f.object)
  what.field, what.quantity, what.jumps = f, f:quantity(3, "bake", o.quantity)
  return what, o
end

-- Measured how ---------------------------------------------------------------------------

--- The measure of a tolerance: that of the description, else that of the field. Raises where there are no normals for it.
local function measure_of(description, jumps, normals)
  if not description.tolerance then return "coefficients" end
  local wanted = description.measure
  if wanted == "irradiance" and not normals then
    return check.bad(3, "bake", "irradiance needs normals: occupied = a view, 'camera' or an array [n][6]")
  end
  return wanted or (jumps and normals and not description.dynamic and "irradiance") or "coefficients"
end

--- The norm below which errors are not relative: of visibilities that of the function 1.
local function floor_of(description, quantity, measure)
  if not description.tolerance or measure ~= "coefficients" or description.dynamic then return 0 end
  return description.floor or quantity == "visibility" and math.sqrt(4 * math.pi) or 0
end

--- The field that is asked: fields that are known to some noise settle it for the tolerance first. Or nil, message, code.
local function settled(f, description, place, o)
  local occupied = place.points
  if place.normals and f:answers "__for_bake" then
    local aside, message, code = where.aside(occupied, place.normals, place.bounds)
    if not aside then return nil, message, code end
    occupied = aside
  end
  return f:for_bake { lmax = description.lmax, tolerance = description.tolerance, bounds = place.bounds,
    points = core.type(occupied) == "ylm.array" and occupied or nil, seed = o.seed, threads = o.threads, progress = o.progress }
end

--- The surfaces at which light jumps: those of the field, or of the option `scene`; nil where nobody tells. Or nil, message,
-- code.
local function walls_of(f, o)
  if o.scene ~= nil then return field.walls_of_scene(3, "bake", o.scene) end
  return f:walls()
end

--- All that C is told of a bake. `prints`, `like`: as of bake.of_scene.
local function form_of(description, o, what, place, prints, like, judged_later)
  local box = place.bounds
  return {
    kind = form.kind(description), lmax = description.lmax, depth = description.depth or 0,
    cells = description.cells or { 1, 1, 1 },
    bounds = { box[1][1], box[1][2], box[1][3], box[2][1], box[2][2], box[2][3] },
    channels = description.channels,
    metric_channels = place.walls and description.tolerance and "none" or description.metric_channels,
    metric = description.metric,
    threshold = description.threshold or -1, tolerance = description.tolerance or 0,
    continuous = description.continuous, dynamic = description.dynamic,
    measure = place.measure, quantity = what.quantity, normals = place.normals,
    team = o.team and o.team.handle,
    sides = place.walls ~= nil, walls = place.walls, budget = description.points,
    aim = judged_later and AIM or nil, squares = judged_later == "squares",
    within = o.within and { o.within[1][1], o.within[1][2], o.within[1][3], o.within[2][1], o.within[2][2], o.within[2][3] },
    floor = floor_of(description, what.quantity, place.measure), body = what.body, like = like,
    prints = prints,
  }
end

-- Baked by whom ----------------------------------------------------------------------------

--- The grid, or the set of bricks, that a device or the processor bakes, and times by stage; or nil, message, code.
local function baked_by(wanted, f, place, o, in_bricks)
  local object, made, code = devices.of(o.device):lights(3, "bake", f.object, o, light.within)
  if not object then return nil, made, code end
  local occupied = place.meshes or place.points
  local function bake_it()
    if in_bricks then return set.bake(wanted, object, occupied, o, in_bricks) end
    return devices.of(object):bake(wanted, object, occupied, o)
  end
  local baked, stages
  baked, stages, code = bake_it()
  if made then object:close() end
  return baked, stages, code
end

-- Remembered ---------------------------------------------------------------------------------

--- The options of a bake that hold for another one in other light.
local function kept_options(given)
  local options = {}
  for _, name in ipairs { "occupied", "geometry", "bounds", "within", "scene", "seed", "max_points", "sums_tolerance",
    "device" } do
    options[name] = given and given[name]
  end
  return options
end

--- Remembers what a grid was baked from, and says what it does not keep.
local function remember(g, description, given, o, what, f, stages, judged_later)
  local own = core.own(g)
  own.stages, own.shadow = stages, what.tally()
  own.lights, own.sums_tolerance = f:followed() and f.object, o.sums_tolerance
  own.recipe = not description.dynamic and { description = description, options = kept_options(given) } or nil
  if not judged_later then unmet.warn(g) end
  f:heed(description.lmax)
  return g
end

--- { description, options } of the bake of a grid that was made in this program and is not dynamic; else nil.
function bake.recipe(g) return core.owned(g, "recipe") end

--- Remembers the lights that a dynamic grid has followed.
function bake.followed(g, f) core.own(g).lights = f.object end

--- Remembers the lights of a grid after other light came to its points.
function bake.refreshed(g, f)
  local own = core.own(g)
  own.lights, own.sums_tolerance = f:followed() and f.object, nil
end

--- All that is known of a grid's bake is known of g.
function bake.keep(g, other)
  local own, theirs = core.own(g), core.own(other)
  for _, name in ipairs { "stages", "shadow", "lights", "sums_tolerance", "recipe" } do own[name] = theirs[name] end
end

--- Makes g what another grid is, which is closed; all that is known of that one is known of g.
function bake.take(g, other)
  bake.keep(g, other)
  return check.result("update", core.grid_take(g, other))
end

--- The lights that a grid was baked from, if that was in this program and they were lights; for pictures.
function bake.lights_of(g)
  local lights = core.owned(g, "lights")
  return lights and (core.type(lights) ~= "ylm.lights" or core.lights_count(lights)) and lights or nil
end

describe "bake" {
  shelf = "everyday",
  about = "Evaluates a light field at the points of a grid: each corner of a voxel once, level by level.",
  arguments = {
    { "description", "adaptive_grid|uniform_grid", "what grid" },
    { "lights", "light|list|function", "a light, a list of lights, what has a light field (a grid too), or an analytic "
      .. "field f(points, lmax, channels) -> values [n][channels][count], gradients [..][3], lambda [n] or nil" },
    { "options?", "table", "see the options" },
  },
  options = bake_options,
  returns = { { "grid", "grid|grid_set", "grid.stats says what was done, and with a tolerance the error that was measured; "
    .. "a warning says a tolerance that is not met" } },
  errors = "raises on bad arguments; nil, message, code where memory or max_points are exceeded; "
    .. "nil, 'cancelled', 'ECANCELLED' where progress returns false; nil, message, code where a device fails",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = { 10, 8, 6 } }
local floor = {}
for i = 0, 8 do for j = 0, 8 do floor[#floor + 1] = { i / 4 - 1, 0, j / 4 - 1 } end end
local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 3,
  tolerance = 0.01 },
  lamp, { occupied = floor })
assert(grid.stats.met and grid.stats.error <= 0.01)]],
  source = "Iwasaki & Dobashi 2025, Sec. 5.1",
}
function bake.bake(description, lights, given) return bake.of_scene(description, lights, given) end

--- One bake of what is described.
local function bake_once(description, lights, given, prints, like, judged_later)
  local o = options_of(description, given)
  local what, code, place, f, message
  what, o, code = what_light(description, lights, o)
  if not what then return nil, o, code end
  place, message, code = where.needed(description, o, what.field.object, what.jumps)
  if not place then return nil, message, code end
  place.measure = measure_of(description, what.jumps, place.normals or place.meshes)
  f, message, code = settled(what.field, description, place, o)
  if not f then return nil, message, code end
  if what.jumps then
    place.walls, message, code = walls_of(f, o)
    if message then return nil, message, code end
  end
  if description.points and not place.walls then -- the caller bakes again, to another tolerance
    if not description.free then
      return check.bad(1, "bake", "points are a budget beside a tolerance of grids with sides, of light with shadows or bounces: "
        .. "leave tolerance or points out")
    end
    description = small.with_tolerance(description, description.tolerance)
  end
  local in_bricks = set.check_bake(description, o, given, what.jumps)
  local baked, stages
  baked, stages, code = baked_by(form_of(description, o, what, place, prints, like, judged_later), f, place, o, in_bricks)
  if not baked or in_bricks then return baked, stages, code end
  return remember(baked, description, given, o, what, f, stages, judged_later)
end

--- The grid that takes so many bytes, judged and remembered as it is decoded.
local function bake_bytes(description, lights, given, prints, judged_later)
  local g, bytes, report = small.bake_bytes(description, given or {}, function(wanted)
    return bake_once(wanted, lights, given, prints, nil, true)
  end)
  if not g then return nil, bytes, report end
  local other, message, code = small.decoded(g, bytes)
  if not other then return nil, message, code end
  bake.keep(other, g)
  core.grid_close(g)
  if not judged_later then unmet.warn(other) end
  return other
end

--- bake.bake of light whose fingerprints are known, or nil, that goes on from what the grid `like` has learnt, or nil.
-- judged_later: the caller judges it by something else, and warns; "squares": by squared errors over the light.
function bake.of_scene(description, lights, given, prints, like, judged_later)
  local is_free = form.kind(description) == "adaptive_grid" and description.free
  if is_free and description.bytes then return bake_bytes(description, lights, given, prints, judged_later) end
  local function once(wanted, later) return bake_once(wanted, lights, given, prints, like, later) end
  local g, message, code = once(description, judged_later or is_free)
  if not g or not is_free or core.type(g) ~= "ylm.grid" or core.grid_form(g).sides then return g, message, code end
  g, message, code = small.bake_points(description, g, function(wanted) return once(wanted, true) end)
  if g and not judged_later then unmet.warn(g) end
  return g, message, code
end

return bake
