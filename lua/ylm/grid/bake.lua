--- ylm.bake, and grid:update, which follows lights that move.

local array = require "ylm.array"
local boxes = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"
local light = require "ylm.light"
local progress = require "ylm.progress"
local set = require "ylm.grid.set"
local unmet = require "ylm.grid.unmet"

local bake = {}

local methods, open = grid_object.methods, grid_object.open

--- The box around points, at least a thousandth as wide as it is long. Extent 0 in all axes is refused.
local function bounds_of(points)
  local lo, hi = core.grid_bounds(points)
  local largest = math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3])
  if largest <= 0 then return nil end
  for i = 1, 3 do
    local missing = largest * 1e-3 - (hi[i] - lo[i])
    if missing > 0 then lo[i], hi[i] = lo[i] - missing / 2, hi[i] + missing / 2 end
  end
  return { lo, hi }
end

--- An array [n][6] as points [n][3] and normals [n][3] of length 1. Or nil, message, code.
local function split(given)
  local points, normals, bad = check.result("bake", core.grid_split((array.rows(3, "bake", "occupied", given, 6))))
  if not points then return nil, normals, bad end
  if bad then return check.bad(3, "bake", "occupied: row %d has no normal: a finite vector of some length expected", bad) end
  return points, normals
end

--- True for an array [n][6], or a list of such rows.
local function has_normals(x)
  if core.type(x) == "ylm.array" then return #x.shape == 2 and x.shape[2] == 6 end
  return type(x) == "table" and type(x[1]) == "table" and #x[1] == 6
end

--- The shading points that a bake on `device` is to serve: an array of the host's, or of a device's memory; nil: everywhere;
-- and, where they come with some, their normals and halves of the distances to the next surfaces. Or nil, message, code.
-- `jumps`: normals of triangles are wanted, not of shading.
local function shading_points(x, device, jumps)
  if x == nil then return nil end
  local points, normals, limits = x, nil, nil
  if core.type(x) == "ylm.view" then
    local message, code
    points, message, code = getmetatable(x).__positions(x, "bake", device)
    if not points then return nil, message, code end
    if device:name() == nil then
      normals, limits, code = getmetatable(x).__normals(x, "bake", jumps)
      if not normals then return nil, limits, code end
      if normals.dtype ~= points.dtype then normals = core.array_convert(normals, points.dtype) end
    end
  elseif has_normals(x) then
    local code
    points, normals, code = split(x)
    if not points then return nil, normals, code end
  end
  points = device:points(3, "bake", "occupied", points)
  if not points then
    return check.bad(3, "bake", "device: occupied is in a device's memory: name the device, or download it")
  end
  if points.shape[1] == 0 then return check.bad(3, "bake", "occupied: at least one point expected") end
  return points, normals, limits
end

--- The mesh of a mesh or a shape, else nil.
local function mesh_of(x)
  if core.type(x) == "ylm.mesh" then return x end
  local mesh = type(x) == "table" and form.kind(x) and rawget(x, "mesh")
  return core.type(mesh) == "ylm.mesh" and mesh or nil
end

--- The meshes of the option `geometry`, a list.
local function meshes_of(x)
  local list = mesh_of(x) and { x } or x
  if type(list) ~= "table" or core.type(list) or form.kind(list) or #list == 0 then
    return check.bad(3, "bake", "geometry must be a mesh, a shape or a list of them, got %s", check.describe(x))
  end
  local meshes = {}
  for i, entry in ipairs(list) do
    meshes[i] = mesh_of(entry)
    if not meshes[i] then
      return check.bad(3, "bake", "geometry[%d] must be a mesh or a shape, got %s", i, check.describe(entry))
    end
  end
  return meshes
end

--- The meshes whose surfaces a bake is to serve; nil where it is to serve points, or everything.
local function surfaces(o)
  if o.occupied == nil and o.geometry == nil then return nil end
  if type(o.occupied) == "string" and o.occupied ~= "surfaces" then
    return check.bad(3, "bake", "occupied must be 'surfaces' or points, got %s", check.describe(o.occupied))
  end
  if o.occupied == "surfaces" and o.geometry == nil then
    return check.bad(3, "bake", "occupied = 'surfaces' needs geometry = a mesh, a shape or a list of them")
  end
  if o.geometry == nil then return nil end
  if o.occupied ~= nil and o.occupied ~= "surfaces" then
    return check.bad(3, "bake", "geometry is for occupied = 'surfaces', occupied gives points: leave one out")
  end
  return meshes_of(o.geometry)
end

--- The box of meshes, a little larger; nil where they have no extent.
local function bounds_of_meshes(meshes)
  local lo, hi = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  for _, mesh in ipairs(meshes) do
    local vertices, _, low, high = core.mesh_info(mesh)
    for i = 1, vertices > 0 and 3 or 0 do
      lo[i], hi[i] = math.min(lo[i], low[i]), math.max(hi[i], high[i])
    end
  end
  if not (math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3]) > 0) then return nil end
  return boxes.padded(lo, hi)
end

--- The bounds of a grid: its own, those given, else those of meshes or of points that are the host's.
local function bounds(description, given, points)
  local there = core.type(points) == "ylm.gpu_array"
  local box = description.bounds or given
  if not box and type(points) == "table" then box = bounds_of_meshes(points) end
  if not box and points and not there and type(points) ~= "table" then box = bounds_of(points) end
  if box then return box end
  if there then return check.bad(1, "bake", "no bounds: give them in the grid, points in a device's memory are not looked at") end
  return check.bad(1, "bake", "no bounds: give them in the grid, or geometry or occupied points that span a box")
end

--- Points a little off their surfaces: 1e-4 of the longest edge of a box. Or nil, message, code.
local function aside(points, normals, box)
  local longest = math.max(box[2][1] - box[1][1], box[2][2] - box[1][2], box[2][3] - box[1][3])
  return check.result("bake", core.grid_aside(points, normals, 1e-4 * longest))
end

--- The light field to be asked: fields that are known to some noise settle that first. Or nil, message, code.
local function settled(field, description, occupied, normals, box, o)
  local settle = core.type(field) and core.type(field) ~= "ylm.array" and getmetatable(field).__for_bake
  if not settle then return field end
  if normals then
    local message, code
    occupied, message, code = aside(occupied, normals, box)
    if not occupied then return nil, message, code end
  end
  return settle(field, { lmax = description.lmax, tolerance = description.tolerance, bounds = box,
    points = core.type(occupied) == "ylm.array" and occupied or nil, seed = o.seed, threads = o.threads, progress = o.progress })
end

local bake_options = {
  { "occupied", "any", optional = true,
    about = "'surfaces': voxels that the triangles of geometry meet, where the tolerance holds by area; or shading points "
      .. "[n][3], where it holds at them, or [n][6] with their normals; or those of a prepared view. Other voxels are not "
      .. "subdivided. Default: 'surfaces' "
      .. "with geometry, else every voxel; with device also a gpu_array, and a view's points are copied there once" },
  { "geometry", "any", optional = true,
    about = "what occupied = 'surfaces' is about: a mesh, a shape (quad, sphere, mesh ...) or a list of them" },
  { "bounds", "bounds", optional = true, about = "where the description has none" },
  { "quantity", "choice", of = core.choices "quantity", optional = true,
    about = "what a field that is a function holds; other fields know it. 'lights': light that nothing occludes (default); "
      .. "'direct': light of lamps and sky with shadows; 'indirect': what surfaces send back; 'all': both" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of the choice of held-out points" },
  { "like", "object", of = "ylm.grid", optional = true,
    about = "a grid that ylm.bake made of much the same light, by a tolerance: its bake goes on. Its knowledge of errors "
      .. "is taken over, and 256 fresh points verify instead of 2048 and more; stats are about those of the last 2048 points "
      .. "that bakes in a row compared. For frames of lights or casters that move" },
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

--- The quantity that a light field holds, and whether it jumps at surfaces.
function bake.quantity(n, name, packed, given)
  if type(packed) == "function" then return given or "lights", given ~= nil and given ~= "lights" end
  local quantity, jumps = core.field_quantity(packed)
  if given and given ~= quantity then
    return check.bad(n, name, "quantity: this light field holds %s, not %s: leave it out", quantity, given)
  end
  return quantity, jumps
end

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

describe "bake" {
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

--- Remembers what a grid was baked from, and with which sums_tolerance.
local function remember(g, packed, sums_tolerance)
  local own = core.own(g)
  own.lights = type(packed) ~= "function" and light.followed(packed) and packed or nil
  own.sums_tolerance = sums_tolerance
end

--- bake.bake of light whose fingerprints are known, or nil.
function bake.of_scene(description, lights, given, prints)
  local kind = form.kind(description)
  if kind ~= "adaptive_grid" and kind ~= "uniform_grid" then
    return check.bad(1, "bake", "an adaptive_grid or a uniform_grid expected, got %s", check.describe(description))
  end
  local o = of_team(description, form.options(3, "bake", bake_options, given))
  o.progress = progress.long(o.progress)
  local fault = o.like and check.grid_fault(o.like)
  if fault then return check.bad(3, "bake", "like: %s", fault) end
  if description.dynamic and o.sums_tolerance then
    return check.bad(3, "bake", "a grid with dynamic = true sums its lights exactly: leave sums_tolerance out")
  end
  local packed, failed, why = lights
  if form.kind(lights) == "virtual_lights" and lights.profile == "near" then
    return check.bad(2, "bake", "near lights are gathered where they are needed, with near:irradiance; bake the far ones")
  end
  if type(lights) ~= "function" then
    packed, failed, why = light.field(2, "bake", lights)
    if not packed then return nil, failed, why end
  end
  local of_body, tally = bake.of_body(packed), light.tally(packed)
  local body
  if type(packed) ~= "function" then
    packed, failed, why = light.joined(packed)
    if not packed then return nil, failed, why end
  end
  if of_body then
    o, body, failed = of_body.__for_grid(packed, description, o)
    if not o then return nil, body, failed end
  end
  if description.dynamic and not light.followed(packed) then
    return check.bad(2, "bake", "a grid with dynamic = true follows sphere lights and flat lights, this is baked from %s: "
      .. "bake that into a second grid, or leave dynamic out", light.other(packed))
  end
  local asked = devices.of(o.device)
  asked:check_bake(description, packed)
  local quantity, jumps = bake.quantity(3, "bake", packed, o.quantity)
  local occupied, normals, limits = surfaces(o), nil, nil
  if not occupied then
    occupied, normals, limits = shading_points(o.occupied, devices.of(o.device or packed), jumps)
    if not occupied and normals then return nil, normals, limits end
  end
  local measure = measure_of(description, jumps, normals or type(occupied) == "table")
  local box = bounds(description, o.bounds, occupied)
  packed, failed, why = settled(packed, description, occupied, normals, box, o)
  if not packed then return nil, failed, why end
  local reach = core.type(packed) and core.type(packed) ~= "ylm.array" and getmetatable(packed).__reach
  local in_bricks = set.check_bake(description, o, given, jumps)
  local cells = description.cells or { 1, 1, 1 }
  local object, made
  object, made, failed = asked:lights(3, "bake", packed, o, light.within)
  if not object then return nil, made, failed end
  local wanted = {
    kind = kind, lmax = description.lmax, depth = description.depth or 0, cells = cells,
    bounds = { box[1][1], box[1][2], box[1][3], box[2][1], box[2][2], box[2][3] },
    channels = description.channels, metric_channels = description.metric_channels, metric = description.metric,
    threshold = description.threshold or -1, tolerance = description.tolerance or 0,
    continuous = description.continuous, dynamic = description.dynamic,
    measure = measure, quantity = quantity, normals = normals, limits = limits,
    team = o.team and o.team.handle,
    reach = reach and reach(packed) or nil, bias = description.bias or jumps and 1 or 0,
    floor = floor_of(description, quantity, measure), body = body, like = o.like,
    prints = prints,
  }
  local baked, stages, code
  if in_bricks then
    baked, stages, code = set.bake(wanted, object, occupied, o, in_bricks)
  else
    baked, stages, code = devices.of(object):bake(wanted, object, occupied, o)
  end
  if made then object:close() end
  if not baked or in_bricks then return baked, stages, code end
  local own = core.own(baked)
  own.stages, own.shadow = stages, tally()
  remember(baked, packed, o.sums_tolerance)
  unmet.warn(baked)
  light.heed(packed, description.lmax)
  return baked
end

--- Remembers the lights of a grid that was refreshed.
function bake.refreshed(g, packed) remember(g, packed) end

--- The lights that a grid was baked from, if that was in this program and they were lights; for pictures.
function bake.lights_of(g)
  local lights = core.owned(g, "lights")
  return lights and (core.type(lights) ~= "ylm.lights" or core.lights_count(lights)) and lights or nil
end

--- The metatable of a body's visibility, else nil.
function bake.of_body(x)
  local meta = core.type(x) and core.type(x) ~= "ylm.array" and getmetatable(x)
  return meta and meta.__for_grid and meta or nil
end

local update_options = {
  { "tolerance", "number", min = 0, optional = true,
    about = "points whose light changed by less than this, relative to the field, are not updated; 0 updates every point. "
      .. "Default: an eighth of the grid's tolerance, 0.001 where it has none" },
  form.threads, form.progress,
}

describe "grid:update" {
  about = "Follows lights that moved, changed, appeared or vanished: only what they change beyond the tolerance is "
    .. "baked again, and the octree is refined and merged to suit. The grid must have been made with dynamic = true.",
  arguments = {
    { "lights", "light|list", "all lights as they are now, of any kind; {}: darkness; those that did not change are "
      .. "recognised by their place in the list, else by their content" },
    { "options?", "table", "see the options" },
  },
  options = update_options,
  returns = { { "report", "table", "also grid.stats.update: lights that changed, points brought up to date, exact: of "
    .. "these with all lights, skipped: within the tolerance, added, removed, pairs, seconds, field_seconds, "
    .. "tree_seconds, rebaked, updates; with a tolerance met, error, confidence, verified, limited and warning: of the "
    .. "whole grid as it is, see grid.stats" } },
  errors = "raises on bad arguments, a grid that is not dynamic, and from the progress function of a call that reads the "
    .. "grid; nil, message, code where memory or max_points are "
    .. "exceeded; nil, 'cancelled', 'ECANCELLED' where progress returns false: the grid is then as it was, or it "
    .. "says that it is spent and refuses all but close: where memory ran out twice in the last step",
  example = [[
local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 10 } end
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, dynamic = true },
  { lamp(0), lamp(1) })
local report = grid:update { lamp(0), lamp(1.2) }
assert(report.lights == 1 and report.points > 0)]],
}
function methods.update(g, lights, given)
  open(g, "update")
  local o = form.options(2, "update", update_options, given)
  local object = light.field(1, "update", lights)
  local followed = light.followed(object)
  if not followed then
    return check.bad(1, "update", "a dynamic grid follows sphere lights and flat lights, got %s: bake that into a second "
      .. "grid", light.other(object))
  end
  if not core.grid_form(g).dynamic then
    return check.fail("update: this grid does not follow lights: make it with dynamic = true (a loaded grid never does)")
  end
  local report, message, code = check.result("update", core.grid_update(g, object, o.tolerance or -1,
    o.threads or 0, progress.of(o.progress)))
  if report == nil then return nil, message, code end
  core.own(g).lights = object
  unmet.warn(g)
  report.warning = g.stats.update.warning
  return report
end

return bake
