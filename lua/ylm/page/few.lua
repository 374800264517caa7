--- Grids of pages in few bytes: the file that the viewer decodes, and the grid that it is.

local check = require "ylm.check"
local core = require "ylm.c.core"
local small = require "ylm.grid.small"

local few = {}

local PER_STEP = 0.416   -- of rounding's 99 %: times the root of a row's width, as csrc/grid/small/search.c
local PART = 0.95        -- of the grid's own error, that rounding errs by: about a quarter more in all
local UNKNOWN = 0.01     -- the error of a grid that does not say it
local FINEST, COARSEST = 1e-6, 0.05

--- Why a grid cannot be decoded by the viewer; nil: it can.
local function lacks(grid)
  if grid.dynamic then return "a grid that follows lights is written as it is" end
end

local function step_of(grid)
  local error, width = grid.stats.error, grid.lmax + 1
  if not (error and error > 0 and error < 1) then error = UNKNOWN end
  local step = PART * error / (PER_STEP * width * (grid.channels == 3 and 1.7320508 or 1))
  return math.max(FINEST, math.min(COARSEST, step))
end

--- The file of a grid: bytes and its report, or nil, message, code.
local function encoded(grid, o)
  local bytes = not o.tolerance and small.file_of(grid)
  if bytes then return bytes, core.grid_small(grid) end
  return small.encode("save", grid, { tolerance = o.tolerance, step = not o.tolerance and step_of(grid) or nil,
    threads = o.threads })
end

--- Settles the precision: "few" where nothing is said and the grid can be so written. Raises where it cannot.
function few.settle(grid, o)
  local why = lacks(grid)
  if o.tolerance and o.precision and o.precision ~= "few" then
    return check.bad(2, "save", "tolerance is of precision = 'few': leave one out")
  end
  if why and (o.precision == "few" or o.tolerance) then
    return check.bad(2, "save", "precision = 'few': %s: 'half', 'float' or 'byte'", why)
  end
  o.precision = o.precision or (why and "half" or "few")
end

--- The grid that a page in few bytes shows, with { parts = bytes by name, report = , errors = the grid of estimated errors };
-- or nil, message, code.
function few.of(grid, o)
  local bytes, report, code = encoded(grid, o)
  if not bytes then return nil, report, code end
  local shown, message
  shown, message, code = check.result("save", core.grid_decode(bytes))
  if not shown then return nil, message, code end
  local parts
  parts, message, code = check.result("save", core.grid_small_parts(bytes))
  if not parts then return nil, message, code end
  return shown, { parts = parts, report = report, errors = grid }
end

return few
