--- Sums of virtual lights in pictures by parts: the far part of all from a grid, the near part of some at each shading point.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local devices = require "ylm.device"
local grids = require "ylm.grid"
local light = require "ylm.light"
local near = require "ylm.render.near"
local progress = require "ylm.progress"
local sh = require "ylm.sh"
local virtual_light = require "ylm.light.virtual"
local warning = require "ylm.warning"

local split = {}

-- Costs of a picture, in nanoseconds of one thread: a pair of a light and a shading point, a pair nearby, a point of a grid for
-- each light, summed by a tree, a shading point besides.
local PAIR, NEAR, GRID, POINT = 2, 3, 10, 100
local FEW = 5e7 -- pairs that need no grid
-- Of a core of R spacings: R^2 times this are near; grid points at voxels of R/x are so many times x^2 count/R^2, over the share
-- of surfaces that are lit.
local NEAR_PAIRS, GRID_POINTS = 7.2, 0.9
local VOXELS, GROWTH, FINEST = 1.25, 0.6, 8 -- x of a tolerance of 2 %, its power of the tolerance, the most
local PLAIN = 50 -- times the tolerance: the relative metric below which voxels stay large
local JUDGES, LEAST, JUDGED = 256, 32, 2e7 -- points that judge, and pairs that these may be

split.fields = {
  { "sums", "choice", of = { "auto", "all", "split" }, default = "auto",
    about = "'all': each light at each shading point; 'split': far parts of lights from a grid, near parts at each point "
      .. "(lights:split); 'auto': the cheaper one, where surfaces are matte, lights of profile gauss, and nothing shadows them" },
  { "tolerance", "number", min = 1e-4, max = 1, default = 0.02,
    about = "of 'split': root mean square error of irradiance at shading points, relative to its mean; judged "
      .. "(report.virtual.error)" },
}

--- The reason why lights cannot be split in a picture of p; nil: they can.
local function hindrance(p, b)
  if b.options.shadows ~= "none" then return "shadows = 'centre' asks each light" end
  if b.lights.profile ~= "gauss" then
    return ("lights of profile 'gauss' are split, and these are '%s'"):format(b.lights.profile)
  end
  if p.traced.glossy > 0 and p.options.gloss ~= "matte" then return "surfaces gloss" end
  return nil
end

--- Nanoseconds of both ways.
local function costs(count, points, spacings, share)
  local far = GRID_POINTS * VOXELS ^ 2 * count / (share * spacings ^ 2) * count * GRID
  local pairs_nearby = math.min(count / 2, NEAR_PAIRS * spacings ^ 2)
  return points * count * PAIR, far + points * (pairs_nearby * NEAR + POINT)
end

--- Is a picture of p to be made of far and near parts of b.lights? Raises where that is asked for and cannot be.
function split.is_wanted(name, p, b)
  local how = b.options.sums or "all"
  if how == "all" then return false end
  local fault = hindrance(p, b)
  if how == "split" then
    return fault and check.fail("%s: sums = 'split': %s: leave sums out", name, fault) or true
  end
  local count, points = b.lights.count, p.stats.points
  if fault or count * points < FEW then return false end
  local _, share = virtual_light.spacing(b.lights, virtual_light.area_of(p.scene))
  local all, parts = costs(count, points, virtual_light.spacings(count, points, share), share)
  return parts < all / 2
end

-- Baking -------------------------------------------------------------------------------------

--- The grid of b.far for voxels of core/x, and its seconds; or nil, message, code.
local function bake(p, o, b, x)
  local start, bounds = core.seconds(), box.padded(p.traced.lo, p.traced.hi)
  local widest = 0
  for a = 1, 3 do widest = math.max(widest, bounds[2][a] - bounds[1][a]) end
  local depth = math.max(1, math.ceil(math.log(widest * x / b.far.core) / math.log(2) - 0.1))
  local tolerance = math.max(core.limits.tolerance_least, b.options.tolerance / 4)
  local probes = grids.adaptive_grid { bounds = bounds, lmax = b.options.lmax, depth = math.min(depth, core.limits.grid_depth),
    threshold = PLAIN * b.options.tolerance }
  local grid, message, code = grids.bake(probes, b.far, { occupied = p.view, threads = o.threads, progress = o.progress,
    light_tolerance = math.min(tolerance, core.limits.tolerance_most) })
  if not grid then return nil, message, code end
  b.depth = depth
  return grid, core.seconds() - start
end

--- Positions and normals of some shading points of p, spread over all: tables [n][3]; or nil, message, code.
local function judges(name, p, count)
  local n = math.max(LEAST, math.min(JUDGES, math.floor(JUDGED / math.max(1, count))))
  local all, message, code = check.result(name, p.lib.shade_positions(p.view))
  if not all then return nil, message, code end
  local normals
  normals, message, code = check.result(name, p.lib.shade_normals(p.view, false))
  if not normals then return nil, message, code end
  local points, directions = {}, {}
  for k = 1, math.min(n, #all) do
    local i = math.floor((k * 0.6180339887498949 % 1) * #all) + 1
    points[k] = { all:get(i, 1), all:get(i, 2), all:get(i, 3) }
    directions[k] = { normals:get(i, 1), normals:get(i, 2), normals:get(i, 3) }
  end
  return points, directions
end

--- Irradiance by coefficients L [n][3][..] at points with normals: function(i, c); `cosines` are of these.
local function irradiance(L, cosines)
  local rows = L:totable()
  return function(i, c)
    local sum, row, weights = 0, rows[i][c], cosines[i]
    for k = 1, #weights do sum = sum + weights[k] * row[k] end
    return sum
  end
end

--- Coefficients of the clamped cosine about normals, tables [n][..]; or nil, message, code.
local function cosines_of(lmax, normals)
  local Y, message, code = sh.eval(lmax, normals)
  if not Y then return nil, message, code end
  local rows = Y:totable()
  for _, row in ipairs(rows) do
    for l = 0, lmax do
      local factor = core.sh_cosine_factor(l)
      for k = l * l + 1, (l + 1) ^ 2 do row[k] = row[k] * factor end
    end
  end
  return rows
end

--- The root mean square error of irradiance by b.grid and b.near, over the mean of what all lights bring; or nil, message, code.
local function judge(name, p, o, b)
  local points, normals, code = judges(name, p, b.lights.count)
  if not points then return nil, normals, code end
  if #points == 0 then return 0 end
  local lmax, options = b.options.lmax, { threads = o.threads }
  local whole, message
  whole, message, code = light.light_field(lmax, b.lights, points, options)
  if not whole then return nil, message, code end
  local far, nearby
  far, message, code = b.grid:sample(points, options)
  if not far then return nil, message, code end
  nearby, message, code = b.near:near_field(lmax, points, options)
  if not nearby then return nil, message, code end
  local cosines
  cosines, message, code = cosines_of(lmax, normals)
  if not cosines then return nil, message, code end
  local all, some, others = irradiance(whole, cosines), irradiance(far, cosines), irradiance(nearby, cosines)
  local square, mean = 0, 0
  for i = 1, #points do
    for c = 1, 3 do
      local e = all(i, c)
      square, mean = square + (some(i, c) + others(i, c) - e) ^ 2, mean + e
    end
  end
  local n = 3 * #points
  return mean > 0 and math.sqrt(square / n) / (mean / n) or 0
end

--- Makes b.grid, b.near of b.lights, and b.parts, the seconds of each step: true, or nil, message, code.
function split.ready(name, p, o, b)
  local start = core.seconds()
  local far, close, code = b.lights:split { core = "auto", scene = p.scene, points = math.max(1, p.stats.points) }
  if not far then return nil, close, code end
  b.far, b.near, b.parts = far, close, { split = core.seconds() - start, bake = 0, judge = 0 }
  local x = math.min(FINEST, VOXELS * (0.02 / b.options.tolerance) ^ GROWTH)
  while true do
    local seconds, message
    b.grid, seconds, code = bake(p, o, b, x)
    if not b.grid then return nil, seconds, code end
    start = core.seconds()
    b.error, message, code = judge(name, p, o, b)
    if not b.error then return nil, message, code end
    b.parts.bake, b.parts.judge = b.parts.bake + seconds, b.parts.judge + core.seconds() - start
    if b.error <= b.options.tolerance or x >= FINEST then return true end
    x = math.min(FINEST, 2 * x)
  end
end

--- Radiance of the shading points by both, a new array; or nil, message, code.
function split.radiance(name, p, o, b)
  local start = core.seconds()
  local out, facts, code = devices.of(nil):shade(name, p, { grid = b.grid, weight = "cosine", threads = o.threads,
    interpolation = "hermite" }, progress.resolve(o.progress))
  if not out then return nil, facts, code end
  b.parts.far = core.seconds() - start
  out, facts, code = near.add(name, p, b.near, "cosine", b.options.lmax, o, out)
  if not out then return nil, facts, code end
  b.parts.near = facts.seconds
  b.facts = { pairs = facts.pairs, rays = 0 }
  return out
end

--- Completes report.virtual, and says what does not hold.
function split.report(p, b, report)
  local r = report.virtual
  r.core, r.error, r.tolerance, r.seconds = b.near.core, b.error, b.options.tolerance, b.parts
  r.grid = { points = b.grid.stats.points, levels = b.grid.stats.levels, bytes = b.grid.stats.bytes }
  if b.error <= b.options.tolerance then return end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "virtual split", "scene %q: far and near parts of virtual lights "
    .. "miss %.2g of the irradiance that all bring, more than the tolerance of %.2g: give sums = 'all', or tolerance = %.2g",
    p.scene.name or "?", b.error, b.options.tolerance, b.error * 1.1)
end

return split
