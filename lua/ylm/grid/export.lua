--- grid:export: the light at the middles of equal cells, or in the grid's own leaves, for engines; sampled, or fitted to what
-- they read at surfaces.

local array = require "ylm.array"
local bake = require "ylm.grid.bake"
local bricks = require "ylm.grid.probes"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local engine = require "ylm.grid.engine"
local files = require "ylm.grid.engine_file"
local fitted = require "ylm.grid.fitted"
local form = require "ylm.form"
local object = require "ylm.grid.object"
local places = require "ylm.grid.places"
local sh = require "ylm.sh"
local warning = require "ylm.warning"

local methods, open = object.methods, object.open

local HALVED = 0.5             -- points of less validity lie in bodies, or behind walls
local MOST_CELLS = 256         -- along the longest axis, where a tolerance chooses
local MOST_PROBES = 2 ^ 20
local HELD_OUT = 4096          -- points that the error is measured at
local QUANTILE = 0.99
local LMAX = 2                 -- of probes in engines
local TOLERANCE = 0.05
local MOST_GRIDS = 6           -- of three.js' probes, which walls part
local WORDS = 300              -- bytes of a grid of three.js beside its numbers

local FACES = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { -1, 0, 0 }, { 0, -1, 0 }, { 0, 0, -1 } }

-- Places -----------------------------------------------------------------------------------

local function extents(g)
  local lo, hi = g.bounds[1], g.bounds[2]
  return lo, { hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3] }
end

--- Numbers of cells along the axes, `n` along the longest; engines interpolate between two at least.
local function cells_of(g, n)
  local _, extent = extents(g)
  local longest = math.max(extent[1], extent[2], extent[3])
  local cells = {}
  for i = 1, 3 do cells[i] = math.max(2, math.floor(n * extent[i] / longest + 0.5)) end
  return cells
end

--- Cells of the grid's bounds, as a lattice of ylm.grid.engine.
local function lattice(g, cells) return { lo = g.bounds[1], hi = g.bounds[2], cells = cells } end

--- The validity of the probes around p, by their weights there; nil where p is in no voxel.
local function validity_at(g, known, p)
  local cell = g:locate(p)
  local sum, weight = 0, 0
  for k = 1, cell and #cell.corners or 0 do
    local row = cell.corners[k]
    if row > 0 then
      local w = 1
      for a = 1, 3 do
        local t = math.max(0, math.min(1, (p[a] - cell.origin[a]) / cell.size[a]))
        w = w * (math.floor((k - 1) / 2 ^ (a - 1)) % 2 == 1 and t or 1 - t)
      end
      sum, weight = sum + w * known[row], weight + w
    end
  end
  return weight > 0 and sum / weight or nil
end

--- The validity at points, array [n]: 1 less the part of each that lies in bodies.
local function validity_of(g, positions)
  if g.sides then return places.unburied(g, positions) end
  local known, all = g:points().validity, true
  for i = 1, #known do all = all and known[i] == 1 end
  local list = {}
  for i = 1, #positions do
    list[i] = all and 1
      or validity_at(g, known, { positions:get(i, 1), positions:get(i, 2), positions:get(i, 3) }) or 1
  end
  return array.array(list, "float")
end

--- Points that lie in the open; all of them where none does.
local function in_the_open(g, points)
  local validity, kept = validity_of(g, points), {}
  for i = 1, #validity do
    if validity[i] >= HALVED then kept[#kept + 1] = { points:get(i, 1), points:get(i, 2), points:get(i, 3) } end
  end
  return kept[1] and array.array(kept, "float") or points
end

--- Points where light is needed, equally dense on surfaces: voxels that hold them count by the squares of their sizes. The
-- same for the same grid.
local function held_out(g)
  local cells = g:cells()
  local leaf, occupied, size, origin = cells.leaf, cells.occupied, cells.size, cells.origin
  local sums, rows, total = {}, {}, 0
  for i = 1, #leaf do
    if leaf[i] == 1 and occupied[i] == 1 then
      total = total + (size:get(i, 1) * size:get(i, 2) * size:get(i, 3)) ^ (2 / 3)
      rows[#rows + 1], sums[#sums + 1] = i, total
    end
  end
  local points, k = {}, 1
  for i = 1, HELD_OUT do
    local wanted = (i - 0.5) / HELD_OUT * total
    while sums[k] < wanted and k < #sums do k = k + 1 end
    local p = {}
    for a, step in ipairs { 0.8191725133961645, 0.6710436067037893, 0.5497004779019703 } do -- Roberts 2018, R3
      p[a] = origin:get(rows[k], a) + (i * step) % 1 * size:get(rows[k], a)
    end
    points[i] = p
  end
  return in_the_open(g, array.array(points, "float"))
end

--- Points moved into the box of the outermost middles, as engines clamp them.
local function clamped(points, box)
  local list = points:totable()
  for _, p in ipairs(list) do
    for a = 1, 3 do p[a] = math.max(box[1][a], math.min(box[2][a], p[a])) end
  end
  return array.array(list, "float")
end

-- Numbers of files ---------------------------------------------------------------------------

--- Numbers that a file has of coefficients c [n][channels][count]: of cubes the irradiance at six faces over pi.
local function exported(kind, c)
  if kind ~= "cube" then return c end
  return sh.irradiance(c, FACES) / math.pi
end

--- Points at which the error of an export is measured, and the numbers of the grid there: { points, truth, kind, lmax }.
local function judge_of(g, kind, lmax, points)
  return { points = points, truth = exported(kind, sh.resize(g:sample(points), lmax)), kind = kind, lmax = lmax }
end

--- The error that 99 % of a judge's points keep where light between middles is interpolated along
-- the axes; or nil, message, code. A window of `width`, where given, damps the light.
local function error_of(g, judge, cells, width)
  local lo, extent = extents(g)
  local box = { {}, {} }
  local between = {}
  for a = 1, 3 do
    local h = extent[a] / cells[a]
    box[1][a], box[2][a], between[a] = lo[a] + h / 2, lo[a] + extent[a] - h / 2, cells[a] - 1
  end
  local coarse, message, code = bake.bake(form.defined.uniform_grid.construct { bounds = box, cells = between,
    lmax = judge.lmax, channels = g.channels == 3 and "rgb" or "luminance", metric_channels = "none" }, g)
  if not coarse then return nil, message, code end
  local c = coarse:sample(clamped(judge.points, box), { interpolation = "linear" })
  coarse:close()
  if width then c = sh.window(c, "hann", width) end
  local errors = sh.relative_error(exported(judge.kind, c), judge.truth):totable()
  table.sort(errors)
  return errors[math.ceil(QUANTILE * #errors)]
end

local function too_many(cells) return cells[1] * cells[2] * cells[3] > MOST_PROBES end

--- Bytes of the numbers of a lattice in a file of that kind.
local function bytes_of(kind, cells, g, o)
  local n = cells[1] * cells[2] * cells[3]
  if kind == "cube" then return 48 * n end
  if kind == "three" then return math.ceil((56 * cells[1] * cells[2] * (cells[3] + 2) + n) * 4 / 3) + WORDS end
  return n * (g.channels == 3 and 3 or 1) * ((o.lmax or LMAX) + 1) ^ 2 * (o.dtype == "float16" and 2 or 4)
end

--- The coarsest numbers of cells whose error(cells) is at most `tolerance`, and that error; the finest tried where none is, of
-- those that are not too_large(cells). Or nil, message, code.
local function choose(g, error, tolerance, too_large)
  local n, below, cells = 2, 1, cells_of(g, 2)
  local found, message, code = error(cells)
  while found and found > tolerance and n < MOST_CELLS do
    local more = math.min(MOST_CELLS, math.ceil(1.5 * n))
    local finer = cells_of(g, more)
    if too_many(finer) or too_large(finer) then break end
    below, n, cells = n, more, finer
    found, message, code = error(cells)
  end
  if not found then return nil, message, code end
  local met = found <= tolerance
  while met and n - below > 1 do
    local middle = math.floor((n + below) / 2)
    local coarser = cells_of(g, middle)
    local less, failed, why = error(coarser)
    if not less then return nil, failed, why end
    if less <= tolerance then n, found, cells = middle, less, coarser else below = middle end
  end
  return cells, found
end

--- The finest cells whose file takes at most `bytes`: size(cells) is what it takes, foreseen(cells) what one lattice would. Or
-- nil, message, code.
local function finest(g, size, foreseen, bytes)
  local n, cells = 2, cells_of(g, 2)
  local more, message, code = size(cells)
  if not more then return nil, message, code end
  more = more / foreseen(cells)
  while n < MOST_CELLS and more * foreseen(cells_of(g, n + 1)) <= bytes and not too_many(cells_of(g, n + 1)) do n = n + 1 end
  while n > 2 do                                                  -- walls that part a lattice cost some
    local taken
    taken, message, code = size(cells_of(g, n))
    if not taken then return nil, message, code end
    if taken <= bytes then break end
    n = n - 1
  end
  return cells_of(g, n)
end

-- The method -------------------------------------------------------------------------------------

function form.types.export_cells(x)
  local good = type(x) == "table" and #x == 3
  for i = 1, good and 3 or 0 do good = good and check.is_integer(x[i]) and x[i] >= 2 and x[i] <= 4096 end
  if good then return { x[1], x[2], x[3] } end
  return nil, "{ nx, ny, nz }, integers from 2 to 4096"
end

local options = {
  { "tolerance", "number", above = 0, optional = true,
    about = "the coarsest cells are taken whose error is at most this at 99 % of held-out places; default " .. TOLERANCE },
  { "cells", "export_cells", optional = true, about = "instead: { nx, ny, nz }" },
  { "bytes", "number", above = 0, optional = true, about = "that the numbers of the file take at most: without tolerance the "
    .. "finest cells that fit are taken; with it, or with cells, it bounds them. Default: 2^20 probes" },
  { "scene", "any", optional = true, about = "whose surfaces the light falls on: the numbers are then fitted, by least squares, "
    .. "to the irradiance that the engine's own look-up has there, and error is that of irradiance at 4,096 other places" },
  { "anyway", "boolean", default = false, about = "true: writes the file also where the tolerance is not met" },
  { "lmax", "integer", min = 0, max = 20, optional = true, about = "of .npy, default 2; of .ylmp 1 or 2, default 1 where a scene "
    .. "and bytes or a tolerance are given, else 2; probes of three.js have 2" },
  { "bits", "integer", min = 6, max = 16, optional = true, about = "of .ylmp: of a number of a point, default 10" },
  { "offset", "number", min = 0, max = 2, optional = true, unit = "cells", about = "of .npy, with scene: how far off the "
    .. "surface, along the normal, the engine looks up; default 0" },
  { "grids", "integer", min = 1, max = 16, optional = true, about = "of .three.json, with scene: at most so many grids beside "
    .. "each other, cut where walls are; three.js takes one for each pixel. Default " .. MOST_GRIDS },
  { "dering", "boolean", default = false,
    about = "damps all probes by the one window that leaves no direction of any below 0; its cost is in the report" },
  { "dtype", "choice", of = { "float16", "float" }, default = "float", about = "of .npy" },
  { "points", "any", optional = true, unit = "scene units",
    about = "array [n][3], without scene: where the error is measured; default: 4,096 places in voxels that hold surfaces or "
    .. "points, without those in bodies and behind walls" },
  form.threads,
}

local kinds = { ["%.ktx2$"] = "cube", ["%.three%.json$"] = "three", ["%.npy$"] = "npy", ["%.ylmp$"] = "ylmp" }

--- Why the tolerance of an export is not met, and what to change.
local function unmet_by(report, tolerance, o)
  local c, looser = report.cells, 10 ^ (math.floor(math.log(report.error) / math.log(10)) - 1)
  local cause = report.dering and report.dering.width and "the window of dering damps light"
    or o.bytes and ("cells end at bytes = %.0f, or at %d probes"):format(o.bytes, MOST_PROBES)
    or ("cells end at %d along an axis, or %d probes"):format(MOST_CELLS, MOST_PROBES)
  return ("export: tolerance %g is not met by %d x %d x %d cells, 99 %% of the points keep %.3g: %s; set tolerance = %.2g, or "
    .. "cells = { nx, ny, nz }"):format(tolerance, c[1], c[2], c[3], report.error, cause,
    math.ceil(report.error / looser) * looser)
end

describe "grid:export" {
  shelf = "everyday",
  about = "Writes the grid's light at the middles of equal cells of its bounds, for engines that interpolate along the axes: "
    .. "'.ylmp' the grid's own leaves in few bytes, which walls part (ylm's look-up for shaders), "
    .. "'.ktx2' ambient cubes (irradiance over pi at six faces, alpha: validity) as Bevy reads them, '.three.json' the atlas of "
    .. "three.js' LightProbeGrid (degree 2, radiance, halves, base64), '.npy' coefficients [nz][ny][nx][channels][(lmax+1)^2]. "
    .. "Axes stay as they are. With scene, the numbers are those with which the engine errs least at the scene's surfaces.",
  arguments = { { "path", "string", "ends in .ylmp, .ktx2, .three.json or .npy" }, { "options?", "table", "" } },
  options = options,
  returns = { { "report", "table", "cells: of the bounds; grids: { bounds, cells } of each that was written; probes; error: "
    .. "99 % of the held-out points keep it: with scene, of irradiance at surfaces, relative to the larger of the place's and "
    .. "the mean; else the relative L2 distance of what is exported from the grid's own; met, with a tolerance; validity, array "
    .. "[nz ny nx] of the first grid: 1 less the part that is in bodies; "
    .. "with scene surfaces: { rms over the mean, error, leak: the mean of places with less than 1 % of the mean over it, or "
    .. "nil, worst: { at, normal, error, wanted, read: luminance }, places }; "
    .. "dering: the window's report; bytes; of .ylmp bricks, lmax, bits, and no cells and validity; warning, where the tolerance "
    .. "is not met" } },
  errors = "raises on another ending and bad options; nil, message, code where the file cannot be written or memory runs out; "
    .. "nil, message, 'ELIMIT' where the tolerance is not met (nothing is written then), or bytes is too few; 'EDOMAIN' where no "
    .. "surface of the scene is within the grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 10 }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 2 }, lamp)
local name = os.tmpname() .. ".ktx2"
local report = assert(grid:export(name, { cells = { 3, 3, 3 } }))
assert(report.probes == 27 and report.error < 0.5)
os.remove(name)]],
  source = "Mitchell, McTaggart, Green 2006 (ambient cubes)",
}

--- The kind of file that a path ends in; raises on others.
local function kind_of(path)
  for pattern, name in pairs(kinds) do
    if type(path) == "string" and path:lower():find(pattern) and not path:find "%z" then return name end
  end
  return check.bad(1, "export", "a path ending in .ylmp, .three.json, .ktx2 or .npy expected, got %s", check.describe(path))
end

local function options_of(kind, given)
  local o = form.options(2, "export", options, given)
  if o.scene ~= nil and form.kind(o.scene) ~= "scene" then
    return check.bad(2, "export", "scene: a scene expected, got %s", check.describe(o.scene))
  end
  if o.tolerance and o.cells then return check.fail "export: either tolerance or cells, not both" end
  if kind == "ylmp" then return bricks.check(o) end
  if o.bits then return check.fail "export: bits are of .ylmp: leave them out" end
  if o.lmax and kind ~= "npy" then return check.fail "export: lmax is of .npy and .ylmp: probes of engines have degree 2" end
  if o.grids and (kind ~= "three" or o.scene == nil) then
    return check.fail "export: grids is of .three.json with a scene: other engines take one"
  end
  if o.offset and (kind ~= "npy" or o.scene == nil) then
    return check.fail "export: offset is of .npy with a scene: other files have their engine's"
  end
  if o.scene ~= nil and (o.points or o.dering) then
    return check.fail("export: with a scene, places are those of its surfaces, and probes are fitted as they are read: leave "
      .. (o.points and "points" or "dering") .. " out")
  end
  return o
end

--- Coefficients of a grid's light at the middles of a lattice, and validity. Or nil, message, code.
local function light_at(g, lmax, at)
  local positions = engine.middles(at)
  local c, message, code = g:sample(positions)
  if not c then return nil, message, code end
  return sh.resize(c, lmax), validity_of(g, positions)
end

--- Numbers that are sampled at the middles of a lattice, [n][channels][numbers], and validity. Or nil, message, code.
local function sampled(g, kind, lmax, at)
  local c, validity, code = light_at(g, lmax, at)
  if not c then return nil, validity, code end
  return array.array(exported(kind, c), "float"), validity
end

--- Sampled numbers: error(cells), made(cells) -> { grids: { lattice, probes, validity }, dering, error }.
local function sampler(g, kind, lmax, o)
  local points = o.points and array.points(2, "export", o.points, "float") or held_out(g)
  if #points == 0 then return check.bad(2, "export", "points: at least one expected") end
  local judge = judge_of(g, kind, lmax, points)
  local function error(cells) return error_of(g, judge, cells) end
  local function made(cells)
    local at, m = lattice(g, cells), {}
    local c, validity, code = light_at(g, lmax, at)
    if not c then return nil, validity, code end
    if o.dering then
      local message
      c, m.dering = sh.dering(c)
      if m.dering.width then
        m.error, message, code = error_of(g, judge, cells, m.dering.width)
        if not m.error then return nil, message, code end
      end
    end
    m.grids = { { lattice = at, probes = exported(kind, c), validity = validity } }
    return m
  end
  return error, made
end

--- error and made, of numbers that are fitted to the surfaces of a scene; made(cells).judged.
local function fitter(g, kind, lmax, o)
  local made = fitted.maker { lo = g.bounds[1], hi = g.bounds[2], threads = o.threads or 0,
    most = o.grids or kind == "three" and MOST_GRIDS or 1,
    reader = kind == "cube" and engine.cube or engine.coefficients(lmax, kind == "three" and 0.5 or o.offset or 0),
    rounded = (kind ~= "npy" or o.dtype == "float16") and fitted.halved or function(probes) return probes end,
    sample = function(at) return sampled(g, kind, lmax, at) end,
    places = function(n, seed) return places.draw("export", places.of_grid(g, o.scene), o.scene, n, seed) end }
  return function(cells)
    local m, message, code = made(cells)
    if not m then return nil, message, code end
    return m.judged.error
  end, made
end

--- Writes numbers of probes; the bytes, or nil, message, code.
local function write(path, kind, m, dtype)
  if kind == "npy" then
    local c, cells = m.grids[1].probes, m.grids[1].lattice.cells
    local shape = { cells[3], cells[2], cells[1], c.shape[2], c.shape[3] }
    local ok, message, code = array.array(c, dtype):reshape(shape):save(path)
    if not ok then return nil, message, code end
    return c.shape[1] * c.shape[2] * c.shape[3] * (dtype == "float16" and 2 or 4)
  end
  local bytes = kind == "cube" and files.cubes(m.grids[1]) or files.three(m.grids)
  local ok, message, code = core.file_save(path, bytes)
  if not ok then return nil, message, code end
  return #bytes
end

--- The report's lattices: { bounds, cells } of each, and the sum of their probes.
local function lattices_of(m)
  local grids, probes = {}, 0
  for k, grid in ipairs(m.grids) do
    local l = grid.lattice
    grids[k] = { bounds = { l.lo, l.hi }, cells = l.cells }
    probes = probes + l.cells[1] * l.cells[2] * l.cells[3]
  end
  return grids, probes
end

function methods.export(g, path, given)
  open(g, "export")
  local kind = kind_of(path)
  local o = options_of(kind, given)
  local lmax = kind == "cube" and g.lmax or o.lmax or LMAX
  local good, message, code = core.file_probe(path)
  if not good then return nil, message, code end
  if kind == "ylmp" then
    return bricks.export(g, path, o, function()
      return o.points and array.points(2, "export", o.points, "float") or held_out(g)
    end, TOLERANCE)
  end
  local error, make = (o.scene ~= nil and fitter or sampler)(g, kind, lmax, o)
  local cells, tolerance = o.cells, o.tolerance or TOLERANCE
  local function foreseen(picked) return bytes_of(kind, picked, g, o) end
  --- The bytes of the lattices that cells become.
  local function size(picked)
    if o.scene == nil then return foreseen(picked) end
    local m, why, failed = make(picked)
    if not m then return nil, why, failed end
    local sum = 0
    for _, grid in ipairs(m.grids) do sum = sum + foreseen(grid.lattice.cells) end
    return sum
  end
  local function too_large(picked) return o.bytes and (size(picked) or 0) > o.bytes end
  local least = cells or cells_of(g, 2)
  if too_large(least) then
    return nil, ("export: %d x %d x %d cells take %.0f bytes, and bytes = %.0f: give more"):format(least[1], least[2], least[3],
      size(least), o.bytes), "ELIMIT"
  end
  if cells and too_many(cells) then
    return check.bad(2, "export", "cells: at most %d probes, got %d x %d x %d", MOST_PROBES, cells[1], cells[2], cells[3])
  end
  if not cells and o.bytes and not o.tolerance then
    cells, message, code = finest(g, size, foreseen, o.bytes)
    if not cells then return nil, message, code end
  end
  local found
  if cells then
    found, message, code = error(cells)
    if not found then return nil, message, code end
  else
    cells, found, code = choose(g, error, tolerance, too_large)
    if not cells then return nil, found, code end
  end
  local m
  m, message, code = make(cells)
  if not m then return nil, message, code end
  local report = { cells = cells, error = m.error or found, validity = m.grids[1].validity, dering = m.dering,
    surfaces = m.judged }
  report.grids, report.probes = lattices_of(m)
  if not o.cells and (o.tolerance or not o.bytes) then
    report.met = report.error <= tolerance
    local sentence = not report.met and unmet_by(report, tolerance, o)
    if sentence and not o.anyway then return nil, sentence .. ", or anyway = true to write it; nothing was written", "ELIMIT" end
    report.warning = sentence and warning.say(g, "export", "%s", sentence) or nil
  end
  report.bytes, message, code = write(path, kind, m, o.dtype)
  if not report.bytes then return nil, message, code end
  return report
end
