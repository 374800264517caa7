--- Tools of the specs of grid:update: grids of every kind, lights that move, and fresh bakes of them.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local numbers = require "spec.support.random"

local moving = {}

local box, errors = grids.box, grids.errors

moving.seed = 20251123

--- Shading points on a floor.
local function floor_points(n, seed)
  local r, t = numbers.minimal(seed), {}
  for i = 1, n do t[i] = { 2 * r() - 1, 0.013, 2 * r() - 1 } end
  return ylm.array(t, "double")
end

--- Points on the faces of small voxels, where data of more than one voxel meet.
local function face_points(n, seed)
  local r, t = numbers.minimal(seed), {}
  for i = 1, n do
    t[i] = { 2 * r() - 1, 0.3 * r(), 2 * r() - 1 }
    for axis = 1, 3 do
      if r() < 0.4 then t[i][axis] = math.floor(t[i][axis] * 64) / 64 end
    end
  end
  return ylm.array(t, "double")
end

moving.faces, moving.everywhere = face_points(3000, moving.seed), numbers.points_in(3000, box[1], box[2], moving.seed)
moving.occupied = floor_points(3000, moving.seed)
local everywhere, occupied = moving.everywhere, moving.occupied

--- The largest relative error of rows.
function moving.worst(a, b)
  local e = errors(a, b)
  return e[#e]
end

--- A small sphere light.
function moving.lamp(x, y, z, radius, radiance)
  return ylm.sphere_light { at = { x, y, z }, radius = radius or 0.05, radiance = radiance or { 10, 8, 6 } }
end

--- Lamps that stand, and one that circles low over the floor.
function moving.lamps(t)
  return {
    moving.lamp(-0.5, 0.3, 0.4),
    moving.lamp(0.5 * math.cos(t), 0.1 + 0.08 * math.sin(3 * t), 0.5 * math.sin(t)),
    moving.lamp(0.2, 0.9, 0, 0.1, { 3, 9, 20 }),
    moving.lamp(0.6, 0.5, -0.3), moving.lamp(0.3, 3, 2, 0.5), moving.lamp(-2, 3, 1, 0.4),
  }
end

--- Many lamps under the ceiling, so that one of them is little of the light.
function moving.canopy(n)
  local all = {}
  for k = 1, n do
    local r, a = 1.5 * math.sqrt(k / n), 2.4 * k
    all[k] = moving.lamp(r * math.cos(a), 0.7, r * math.sin(a), 0.02, { 3, 2 + k % 3, 4 })
  end
  return all
end

moving.descriptions = {
  { name = "uniform", make = function(dynamic)
    return ylm.uniform_grid { bounds = box, cells = 6, lmax = 3, dynamic = dynamic }
  end },
  { name = "by a threshold", make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 4, depth = 5, threshold = 5, dynamic = dynamic }
  end },
  { name = "luminance by an absolute threshold", luminance = true, make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 3, depth = 5, threshold = 0.2, metric = "absolute",
      channels = "luminance", dynamic = dynamic }
  end },
  { name = "by a threshold of rgb", make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, threshold = 2, metric_channels = "rgb",
      dynamic = dynamic }
  end },
  { name = "by a tolerance", tolerance = 0.01, make = function(dynamic)
    return ylm.adaptive_grid { bounds = box, lmax = 4, depth = 7, tolerance = 0.01, dynamic = dynamic }
  end },
}

--- The grid of a description for the shading points.
function moving.bake(d, lights, dynamic)
  return assert(ylm.bake(d.make(dynamic), lights, { occupied = occupied, threads = 1 }))
end

--- grid:update, on one thread unless told otherwise: the grids are small, the machine may be busy.
function moving.update(grid, lights, options)
  local o = { threads = 1 }
  for name, value in pairs(options or {}) do o[name] = value end
  return grid:update(lights, o)
end

--- Coefficients at the shading points without any grid.
function moving.exact(d, lights)
  return (ylm.light_field(moving.bake(d, lights).lmax, lights, occupied,
    { channels = d.luminance and "luminance" or "rgb", dtype = "float" }))
end

--- The largest difference of what two grids hold and sample; 0: they are the same.
function moving.difference(a, b)
  local pa, pb = a:points(), b:points()
  if #pa.position ~= #pb.position then return math.huge end
  local d = 0
  for _, name in ipairs { "position", "value", "gradient" } do
    d = math.max(d, (core.array_distance(pa[name], pb[name])))
  end
  local ca, cb = a:cells { added = true }, b:cells { added = true }
  if #ca.level ~= #cb.level then return math.huge end
  for _, name in ipairs { "origin", "level", "leaf", "corners" } do
    d = math.max(d, (core.array_distance(ca[name], cb[name])))
  end
  return math.max(d, (core.array_distance(a:sample(everywhere), b:sample(everywhere))))
end

return moving
