--- Where a bake is told that light is needed: points, surfaces, and the bounds around them.

local array = require "ylm.array"
local boxes = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local devices = require "ylm.device"
local field = require "ylm.field"
local form = require "ylm.form"

local where = {}

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
-- and, where they come with some, their normals. Or nil, message, code.
-- `jumps`: normals of triangles are wanted, not of shading.
local function shading_points(x, device, jumps)
  if x == nil then return nil end
  local points, normals = x, nil
  if core.type(x) == "ylm.view" then
    local message, code
    points, message, code = field.ask(x, "__positions", "bake", device)
    if not points then return nil, message, code end
    if device:name() == nil then
      normals, message, code = field.ask(x, "__normals", "bake", jumps)
      if not normals then return nil, message, code end
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
  return points, normals
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
function where.bounds_of_meshes(meshes)
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
  if not box and type(points) == "table" then box = where.bounds_of_meshes(points) end
  if not box and points and not there and type(points) ~= "table" then box = bounds_of(points) end
  if box then return box end
  if there then return check.bad(1, "bake", "no bounds: give them in the grid, points in a device's memory are not looked at") end
  return check.bad(1, "bake", "no bounds: give them in the grid, or geometry or occupied points that span a box")
end

--- Where the options `o` of a bake want light: { points = , meshes = , normals = , bounds = }, of which points and
-- meshes may both be missing: everywhere. `jumps`: the light jumps at surfaces. Or nil, message, code.
function where.needed(description, o, object, jumps)
  local meshes = surfaces(o)
  local points, normals, code
  if not meshes then
    points, normals, code = shading_points(o.occupied, devices.of(o.device or object), jumps)
    if not points and normals then return nil, normals, code end
  end
  return { points = points, meshes = meshes, normals = normals,
    bounds = bounds(description, o.bounds, meshes or points) }
end

--- Points a little off their surfaces: 1e-4 of the longest edge of a box. Or nil, message, code.
function where.aside(points, normals, box)
  local longest = math.max(box[2][1] - box[1][1], box[2][2] - box[1][2], box[2][3] - box[1][3])
  return check.result("bake", core.grid_aside(points, normals, 1e-4 * longest))
end

return where
