--- Grids in few bytes: options of grid:save and grid_set:save, and what ylm.bake does for a number of bytes or points.

local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"

local small = {}

local PART = 0.55      -- of the error in all that interpolation takes where bytes are best spent
local NEAR = 0.15      -- of that part: near enough
local BAKES = 4        -- at most, for a number of bytes or points
local FIRST = 0.01     -- the tolerance of the first
local KEPT = 0.72      -- of its tolerance, that bakes err by
local POINTS_FALL = 0.6 -- points grow as tolerance^-POINTS_FALL
local LOOSEST, TIGHTEST = 0.5, 1e-4

small.options = {
  { "tolerance", "number", above = 0, max = 0.5, optional = true,
    about = ".ylm: few bytes: points are rounded, and 99 % of the light that is decoded is within this of the exact light, as "
      .. "the tolerance of a bake: interpolation and rounding in all. .html of precision 'few': likewise; default: rounding "
      .. "adds about a quarter to the grid's own error" },
  { "bytes", "memory", optional = true, about = ".ylm: few bytes: at most so many, a number or '2 MB', with the least error" },
  { "step", "number", min = 1e-7, max = 1, optional = true, shelf = "experiments",
    about = ".ylm: few bytes: the step of rounding, relative to the light's norm at each point" },
}

--- Whether options ask for few bytes; raises where they ask twice.
function small.is_asked(argument, name, o)
  local asked = 0
  for _, key in ipairs { "tolerance", "bytes", "step" } do asked = asked + (o[key] ~= nil and 1 or 0) end
  if asked > 1 then return check.bad(argument, name, "one of tolerance, bytes and step: they all choose the rounding") end
  return asked == 1
end

local function count(report, bytes, points)
  report.bytes, report.points, report.bytes_per_point = bytes, points, bytes / points
  return report
end

--- The bytes of a file and its report, or nil, message, code.
function small.encode(name, g, o)
  local bytes, report, code = core.grid_encode_small(g, o.tolerance or 0, o.bytes or 0, o.step or 0, o.threads or 0,
    progress.of(o.progress))
  bytes, report, code = check.result(name, bytes, report, code)
  if not bytes then return nil, report, code end
  return bytes, count(report, #bytes, core.grid_stats(g).points)
end

--- Writes a grid in bricks as a folder of few bytes: true and a report, or nil, message, code.
function small.save_set(name, set, path, o)
  local bytes, report, code = core.grid_set_write_small(set, (path:gsub("/+$", "")), o.tolerance or 0, o.bytes or 0, o.step or 0,
    o.threads or 0, progress.of(o.progress))
  bytes, report, code = check.result(name, bytes, report, code)
  if not bytes then return nil, report, code end
  return true, count(report, bytes, set.stats.points)
end

--- Writes a grid in few bytes: true and a report, or nil, message, code.
function small.save(name, g, path, o)
  local bytes, report, code = small.encode(name, g, o)
  if not bytes then return nil, report, code end
  local ok, message, why = check.result(name, core.file_save(path, bytes))
  if not ok then return nil, message, why end
  report.sections = {}
  local look = core.grid_file_look(path) -- nil: somebody has taken the file away
  for _, s in ipairs(look and look.sections or {}) do report.sections[s.name] = s.bytes end
  return true, report
end

--- The file that a grid is to the bit, in few bytes; nil: there is none.
function small.file_of(g)
  local few = core.owned(g, "few")
  return few and core.grid_small(g) and core.grid_restate(few, g) or nil
end

-- Budgets -----------------------------------------------------------------------------------

function small.with_tolerance(description, tolerance)
  local copy = {}
  for key, value in pairs(description) do copy[key] = value end
  copy.tolerance, copy.bytes, copy.points, copy.free = math.max(TIGHTEST, math.min(LOOSEST, tolerance)), nil, nil, nil
  return setmetatable(copy, getmetatable(description))
end

--- A description that asks for a number of bytes instead of an error.
function small.with_bytes(description, bytes)
  local copy = small.with_tolerance(description, FIRST)
  copy.bytes, copy.free, copy.threshold = bytes, true, nil
  return copy
end

--- The grid that readers of its file will have.
function small.decoded(g, bytes)
  local other, message, code = check.result("bake", core.grid_decode(bytes))
  if not other then return nil, message, code end
  core.grid_inherit(other, g)
  core.own(other).few = bytes
  return other
end

--- The tolerance after one whose bake errs by `before` and, in so many bytes, by `error` in all; nil: it is near enough.
local function next_tolerance(tolerance, before, error)
  local wanted = PART * error
  if math.abs(before / wanted - 1) < NEAR then return nil end
  return math.max(tolerance / 4, math.min(4 * tolerance, wanted / KEPT))
end

--- Bakes to the least error within a number of bytes: bake(description) -> grid, or nil, message, code.
function small.bake_bytes(description, o, bake)
  local tolerance, best, best_bytes, best_report = description.tolerance or FIRST, nil, nil, nil
  for _ = 1, BAKES do
    local g, message, code = bake(small.with_tolerance(description, tolerance))
    if not g then return nil, message, code end
    local bytes, report, why = small.encode("bake", g, { bytes = description.bytes, threads = o.threads, progress = o.progress })
    if not bytes and why ~= "ELIMIT" then return nil, report, why end
    local is_best = bytes and (not best or report.error < best_report.error)
    if is_best then
      if best then core.grid_close(best) end
      best, best_bytes, best_report = g, bytes, report
    else
      core.grid_close(g)
    end
    local after
    if bytes then
      after = next_tolerance(tolerance, report.before, report.error)
    else
      after = 3 * tolerance
    end
    if not after or after == tolerance or (tolerance >= LOOSEST and after > tolerance) then break end
    tolerance = after
    if best and not is_best then break end
  end
  if not best then
    return nil, ("bake: bytes = %.0f are too few for this grid at a tolerance of %g"):format(description.bytes, tolerance),
      "ELIMIT"
  end
  return best, best_bytes, best_report
end

--- Bakes to at most so many points, of light without walls, from a first grid: bake(description) -> grid, or nil, message,
-- code.
function small.bake_points(description, g, bake)
  local tolerance, best, fine, coarse = description.tolerance, nil, 0, math.huge
  for i = 1, BAKES do
    local message, code
    if i > 1 then g, message, code = bake(small.with_tolerance(description, tolerance)) end
    if not g then return nil, message, code end
    local points = core.grid_stats(g).points
    local fits = points <= description.points
    if fits then
      if best then core.grid_close(best) end
      best, coarse = g, math.min(coarse, tolerance)
      if points > 0.95 * description.points then break end
    else
      core.grid_close(g)
      fine = math.max(fine, tolerance)
    end
    local after = tolerance * (points / (0.97 * description.points)) ^ (1 / POINTS_FALL)
    if not (after > fine and after < coarse) then
      after = coarse < math.huge and math.sqrt(math.max(fine, coarse / 16) * coarse) or 3 * tolerance
    end
    if (fits and tolerance <= TIGHTEST) or (not fits and tolerance >= LOOSEST) then break end
    tolerance = after
  end
  if not best then
    return nil, ("bake: points = %d are too few for this grid at a tolerance of %g"):format(description.points, tolerance),
      "ELIMIT"
  end
  return best
end

return small
