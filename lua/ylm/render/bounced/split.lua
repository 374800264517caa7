--- Sums of virtual lights in pictures by parts: far parts of merged lights from voxels, near parts at each shading point.

local check = require "ylm.check"
local core = require "ylm.c.core"
local light = require "ylm.light"
local progress = require "ylm.progress"
local sh = require "ylm.sh"
local virtual_light = require "ylm.light.virtual"
local warning = require "ylm.warning"

local split = {}

-- Costs of a picture, in nanoseconds of one thread: a pair of a light and a shading point, a pair nearby, a corner of a
-- voxel, a light's merging, a shading point besides.
local PAIR, NEAR, CORNER, LIGHT, POINT = 2, 2.2, 12000, 300, 200
local FEW = 5e7 -- pairs that need no parts
-- Of a core of R spacings of n lights: so many times R^2 are near; corners of voxels of x cores are so many times n/(x R)^2.
local NEAR_PAIRS, CORNERS = 3.2, 4
local SPACINGS, LEAST_CORE, MOST_CORE = 0.4, 3.4, 12 -- R is this times (n 10^6/points)^(1/4), within these
-- Voxels and cells of merged lights, over the core: of a tolerance of 2 %, by the root of the tolerance; least ones.
local VOXEL, MERGE, FINEST, UNMERGED, MOST = 0.45, 0.35, 0.05, 0.06, 0.7
local ROOM = 4e5 -- corners of voxels, some 1.3 kB each, that finer voxels may have
local DEGREE = 8 -- of the clamped cosine, at most
local JUDGES, LEAST, JUDGED = 256, 64, 1e8 -- points that judge, and pairs that these may be

split.fields = {
  { "sums", "choice", of = { "auto", "all", "split" }, default = "auto",
    about = "'all': each light at each shading point; 'split': far parts of merged lights from voxels of several levels, near "
      .. "parts at each point; 'auto': the cheaper one, where surfaces are matte, lights of profile gauss, and nothing shadows "
      .. "them" },
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
  if p.traced.glossy > 0 and p.options.gloss ~= "matte" then return "surfaces are glossy" end
  if b.options.zonal or b.options.window or (b.options.horizon or "none") ~= "none" or b.options.subset ~= "all"
    or b.options.lmax > core.limits.lmax then
    return "zonal, window, horizon, subset and degrees above " .. core.limits.lmax .. " are of single lights"
  end
  return nil
end

--- The core for a picture of so many points, in scene units and in spacings of lights.
local function core_of(lights, scene, points)
  local spacing = virtual_light.spacing(lights, virtual_light.area_of(scene))
  local wanted = math.max(LEAST_CORE, math.min(MOST_CORE, SPACINGS * (lights.count * 1e6 / math.max(1, points)) ^ 0.25))
  local size = math.max(wanted * spacing, 1.01 * lights.radius.max)
  return size, size / math.max(spacing, 1e-300)
end

--- Nanoseconds of both ways.
local function costs(count, points, spacings)
  local corners = CORNERS * count / (VOXEL * spacings) ^ 2
  local pairs_nearby = math.min(count / 2, NEAR_PAIRS * spacings ^ 2)
  return points * count * PAIR, corners * CORNER + count * LIGHT + points * (pairs_nearby * NEAR + POINT)
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
  local _, spacings = core_of(b.lights, p.scene, points)
  local all, parts = costs(count, points, spacings)
  return parts < all / 2
end

-- Sums and their judge ---------------------------------------------------------------------

--- Positions and normals of all shading points of p: float arrays [n][3]; or nil, message, code.
local function places(name, p)
  local points, message, code = check.result(name, p.lib.shade_positions(p.view))
  if not points then return nil, message, code end
  local normals
  normals, message, code = check.result(name, p.lib.shade_normals(p.view, false))
  if not normals then return nil, message, code end
  return points, normals
end

--- Numbers of some of n points, spread over all, for so many lights.
local function judges(n, count)
  local list = {}
  for k = 1, math.min(n, math.max(LEAST, math.min(JUDGES, math.floor(JUDGED / math.max(1, count))))) do
    list[k] = math.floor((k * 0.6180339887498949 % 1) * n) + 1
  end
  return list
end

local function rows_of(a, list)
  local rows = {}
  for k, i in ipairs(list) do rows[k] = { a:get(i, 1), a:get(i, 2), a:get(i, 3) } end
  return rows
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

--- Irradiance by all lights at points that judge: { list =, [k] = { r, g, b }, mean = }; or nil, message, code.
local function truth(o, b, points, normals)
  local list = judges(#points, b.lights.count)
  local t, mean, lmax = { list = list, mean = 0 }, 0, b.options.lmax
  if #list == 0 then return t end
  local L, message, code = light.light_field(lmax, b.lights, rows_of(points, list), { threads = o.threads })
  if not L then return nil, message, code end
  local cosines
  cosines, message, code = cosines_of(lmax, rows_of(normals, list))
  if not cosines then return nil, message, code end
  local all = irradiance(L, cosines)
  for k = 1, #list do
    t[k] = { all(k, 1), all(k, 2), all(k, 3) }
    mean = mean + t[k][1] + t[k][2] + t[k][3]
  end
  t.mean = mean / (3 * #list)
  return t
end

--- The root mean square error of irradiance E beside truth t, over its mean.
local function judge(E, t)
  local square = 0
  for k, i in ipairs(t.list) do
    for c = 1, 3 do square = square + (E:get(i, c) - t[k][c]) ^ 2 end
  end
  return t.mean > 0 and math.sqrt(square / (3 * #t.list)) / t.mean or 0
end

--- Irradiance at all points by one part of b.lights, with b.voxel and b.merge, and facts; or nil, message, code.
local function sum(name, o, b, points, normals, part, onto)
  local E, facts, code = check.result(name, core.lights_virtual_irradiance(b.lights.lights, points, normals, { core = b.core,
    voxel = b.voxel, merge = b.merge < UNMERGED and 0 or b.merge, lmax = math.min(DEGREE, b.options.lmax), part = part,
    onto = onto, threads = o.threads, progress = progress.resolve(o.progress) }))
  if not E then return nil, facts, code end
  local s = b.parts
  s.split, s.bake = s.split + facts.sorting + facts.merging, s.bake + facts.baking
  s.far, s.near = s.far + facts.far, s.near + facts.near
  return E, facts
end

--- Makes b.irradiance of the points of p by far and near parts of b.lights. Voxels become finer and
-- cells of merged lights smaller until b.error keeps the tolerance; b.parts are the seconds of each
-- step. True, or nil, message, code.
function split.ready(name, p, o, b)
  local points, normals, code = places(name, p)
  if not points then return nil, normals, code end
  local spacings
  b.core, spacings = core_of(b.lights, p.scene, #points)
  b.of, b.parts, b.tries = p.view, { split = 0, bake = 0, judge = 0, far = 0, near = 0 }, 0
  local start = core.seconds()
  local t, message
  t, message, code = truth(o, b, points, normals)
  if not t then return nil, message, code end
  b.parts.judge = core.seconds() - start
  local fine = math.min(MOST / VOXEL, math.sqrt(b.options.tolerance / 0.02))
  local finest = spacings > 0 and math.max(FINEST, math.sqrt(CORNERS * b.lights.count / ROOM) / spacings) or FINEST
  b.voxel, b.merge = math.max(VOXEL * fine, finest), MERGE * fine
  local close
  close, b.facts, code = sum(name, o, b, points, normals, "near")
  if not close then return nil, b.facts, code end
  repeat
    b.irradiance, b.far, code = sum(name, o, b, points, normals, "far", close)
    if not b.irradiance then return nil, b.far, code end
    b.error, b.tries = judge(b.irradiance, t), b.tries + 1
    local finer = math.max(0.5, math.min(0.8, 0.9 * math.sqrt(b.options.tolerance / b.error)))
    local done = b.error <= b.options.tolerance or b.voxel <= finest or b.far.corners > ROOM * finer ^ 2
    if not done then
      b.voxel, b.merge = math.max(finest, b.voxel * finer), b.merge * finer
    end
  until done
  return true
end

--- Radiance of the shading points by both, a new array; or nil, message, code.
function split.radiance(name, p, o, b)
  if b.of ~= p.view or not b.irradiance then
    local ok, message, code = split.ready(name, p, o, b)
    if not ok then return nil, message, code end
  end
  local out = b.irradiance
  b.irradiance, b.facts.rays = nil, 0
  return check.result(name, p.lib.shade_reflect(p.view, out))
end

--- Completes report.virtual, and says what does not hold.
function split.report(p, b, report)
  local r = report.virtual
  local x = b.far
  r.core, r.error, r.tolerance, r.seconds = b.core, b.error, b.options.tolerance, b.parts
  r.grid = { points = x.corners, voxels = x.cells, levels = x.levels, bytes = x.bytes, edge = b.voxel * b.core }
  r.merged = { lights = x.merged, cell = x.cell, pairs = x.far_pairs }
  r.tries = b.tries
  if b.error <= b.options.tolerance then return end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "virtual split", "scene %q: far and near parts of virtual lights "
    .. "miss %.2g of the irradiance that all bring, more than the tolerance of %.2g: give sums = 'all', or tolerance = %.2g",
    p.scene.name or "?", b.error, b.options.tolerance, b.error * 1.1)
end

return split
