--- Grids for engines: the light at the middles of equal cells, as textures that others read.
--
-- ambient cubes in KTX2 (Bevy), three.js's atlas of probes in JSON, numbers in .npy for others.

local array = require "ylm.array"
local bake = require "ylm.grid.bake"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local object = require "ylm.grid.object"
local sh = require "ylm.sh"
local warning = require "ylm.warning"

local methods, open = object.methods, object.open

local BURIED = 4               -- flag of samples in bodies
local HALVED = 0.5             -- points of less validity lie in bodies, or behind walls
local MOST_CELLS = 256         -- along the longest axis, where a tolerance chooses
local MOST_PROBES = 2 ^ 20
local HELD_OUT = 4096          -- points that the error is measured at
local QUANTILE = 0.99
local LMAX = 2                 -- of probes in engines
local TOLERANCE = 0.05

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

--- The middles of cells, x fastest, as an array [nz ny nx][3].
local function middles(g, cells)
  local lo, extent = extents(g)
  local list = {}
  for z = 1, cells[3] do
    for y = 1, cells[2] do
      for x = 1, cells[1] do
        list[#list + 1] = { lo[1] + extent[1] * (x - 0.5) / cells[1], lo[2] + extent[2] * (y - 0.5) / cells[2],
          lo[3] + extent[3] * (z - 0.5) / cells[3] }
      end
    end
  end
  return array.array(list, "float")
end

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
  if g.sides then
    local flags = select(4, g:sample(positions, { flags = true }))
    for i = 1, #flags do flags:set(i, flags:get(i) >= BURIED and 0 or 1) end
    return flags
  end
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

--- Bytes of the numbers of a file of that kind.
local function bytes_of(kind, cells, g, o)
  local n = cells[1] * cells[2] * cells[3]
  if kind == "cube" then return 48 * n end
  if kind == "three" then return math.ceil((56 * cells[1] * cells[2] * (cells[3] + 2) + n) * 4 / 3) end
  return n * (g.channels == 3 and 3 or 1) * ((o.lmax or LMAX) + 1) ^ 2 * (o.dtype == "float16" and 2 or 4)
end

--- The coarsest numbers of cells whose error is at most `tolerance`, and that error; the finest tried where none is, of
-- those that are not too_large(cells). Or nil, message, code.
local function choose(g, judge, tolerance, too_large)
  local n, below, cells = 2, 1, cells_of(g, 2)
  local found, message, code = error_of(g, judge, cells)
  while found and found > tolerance and n < MOST_CELLS do
    local more = math.min(MOST_CELLS, math.ceil(1.5 * n))
    local finer = cells_of(g, more)
    if too_many(finer) or too_large(finer) then break end
    below, n, cells = n, more, finer
    found, message, code = error_of(g, judge, cells)
  end
  if not found then return nil, message, code end
  local met = found <= tolerance
  while met and n - below > 1 do
    local middle = math.floor((n + below) / 2)
    local coarser = cells_of(g, middle)
    local less, failed, why = error_of(g, judge, coarser)
    if not less then return nil, failed, why end
    if less <= tolerance then n, found, cells = middle, less, coarser else below = middle end
  end
  return cells, found
end

-- Files ----------------------------------------------------------------------------------------

--- Bytes of an unsigned integer, the least first.
local function little(x, bytes)
  local list = {}
  for i = 1, bytes do
    list[i] = string.char(x % 256)
    x = math.floor(x / 256)
  end
  return table.concat(list)
end

local function halves(list) return array.array(list, "float16"):bytes() end

--- One level of a texture of halves, red green blue alpha, as KTX 2.0. `data` is its texels; `pairs` are sorted by key.
local function ktx2(width, height, depth, data, pairs_of_words)
  local samples = {}
  for i, channel in ipairs { 0, 1, 2, 15 } do                     -- signed floats from -1 to 1 and beyond
    samples[i] = little(16 * (i - 1), 2) .. string.char(15, channel + 0xC0) .. little(0, 4) .. little(0xBF800000, 4)
      .. little(0x3F800000, 4)
  end
  local block = little(0, 4) .. little(2, 2) .. little(24 + 16 * 4, 2)  -- Khronos' basic descriptor
    .. string.char(1, 1, 1, 0)                                    -- RGBA, BT.709, linear, straight alpha
    .. little(0, 4) .. string.char(8, 0, 0, 0, 0, 0, 0, 0) .. table.concat(samples)
  local descriptor = little(4 + #block, 4) .. block
  local words = {}
  for i, pair in ipairs(pairs_of_words) do
    local text = pair[1] .. "\0" .. pair[2] .. "\0"
    words[i] = little(#text, 4) .. text .. ("\0"):rep(-#text % 4)
  end
  words = table.concat(words)
  local first = 80 + 24                                           -- header and index, one level
  local gap = -(first + #descriptor + #words) % 8
  local at = first + #descriptor + #words + gap
  return "\171KTX 20\187\r\n\26\n" .. little(97, 4) .. little(2, 4)   -- R16G16B16A16_SFLOAT, two bytes a number
    .. little(width, 4) .. little(height, 4) .. little(depth, 4) .. little(0, 4) .. little(1, 4) .. little(1, 4) .. little(0, 4)
    .. little(first, 4) .. little(#descriptor, 4) .. little(first + #descriptor, 4) .. little(#words, 4) .. little(0, 8)
    .. little(0, 8) .. little(at, 8) .. little(#data, 8) .. little(#data, 8) .. descriptor .. words .. ("\0"):rep(gap) .. data
end

local function numbers(list)
  local words = {}
  for i, x in ipairs(list) do words[i] = ("%.9g"):format(x) end
  return table.concat(words, ",")
end

--- Ambient cubes as Bevy reads them: (nx, 2 ny, 3 nz) texels; alpha is validity.
local function cubes(g, cells, c, validity)
  local rows, list = exported("cube", c):totable(), {}
  for axis = 1, 3 do
    for z = 1, cells[3] do
      for side = 0, 1 do                                          -- faces that look along the axis first
        for y = 1, cells[2] do
          for x = 1, cells[1] do
            local i = ((z - 1) * cells[2] + y - 1) * cells[1] + x
            for channel = 1, 3 do list[#list + 1] = (rows[i][channel] or rows[i][1])[axis + 3 * side] end
            list[#list + 1] = validity[i]
          end
        end
      end
    end
  end
  return ktx2(cells[1], 2 * cells[2], 3 * cells[3], halves(list), {
    { "KTXwriter", "ylm " .. (core.info()) },
    { "ylm.bounds", numbers(g.bounds[1]) .. "," .. numbers(g.bounds[2]) } })
end

--- The atlas of three.js' LightProbeGrid: seven volumes of four numbers above each other, each with a copy of its first and
-- last slice.
local function atlas(g, cells, c, validity)
  if c.shape[2] == 1 then c = array.stack({ c, c, c }, 2):reshape { #c, 3, c.shape[3] } end
  local rows, list = sh.convert(c, "three.js"):totable(), {}
  for volume = 0, 6 do
    for slice = 0, cells[3] + 1 do
      local z = math.max(1, math.min(cells[3], slice))
      for y = 1, cells[2] do
        for x = 1, cells[1] do
          local row = rows[((z - 1) * cells[2] + y - 1) * cells[1] + x]
          for k = 4 * volume, 4 * volume + 3 do
            list[#list + 1] = k < 27 and row[math.floor(k / 3) + 1][k % 3 + 1] or 0
          end
        end
      end
    end
  end
  local bytes = {}
  for i = 1, #validity do bytes[i] = string.char(math.floor(255 * math.max(0, math.min(1, validity[i])) + 0.5)) end
  return ('{"type":"LightProbeGrid","generator":"ylm %s","convention":"three.js","min":[%s],"max":[%s],'
    .. '"resolution":[%s],"atlas":{"width":%d,"height":%d,"depth":%d,"format":"RGBA","numbers":"half","data":"%s"},'
    .. '"validity":"%s"}\n'):format((core.info()), numbers(g.bounds[1]), numbers(g.bounds[2]), numbers(cells), cells[1],
    cells[2], 7 * (cells[3] + 2), core.page_base64(halves(list)), core.page_base64(table.concat(bytes)))
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
    about = "the coarsest cells are taken whose error is at most this at 99 % of held-out points; default " .. TOLERANCE },
  { "cells", "export_cells", optional = true, about = "instead: { nx, ny, nz }" },
  { "bytes", "number", above = 0, optional = true, about = "that the numbers of the file take at most: bounds the cells that are "
    .. "chosen, and refuses those that are given; default: 2^20 probes" },
  { "anyway", "boolean", default = false, about = "true: writes the file also where the tolerance is not met" },
  { "lmax", "integer", min = 0, max = 20, optional = true, about = "of .npy, default 2; probes of three.js have 2" },
  { "dering", "boolean", default = false,
    about = "damps all probes by the one window that leaves no direction of any below 0; its cost is in the report" },
  { "dtype", "choice", of = { "float16", "float" }, default = "float", about = "of .npy" },
  { "points", "any", optional = true, unit = "scene units",
    about = "array [n][3]: where the error is measured; default: 4,096 places in voxels that hold surfaces or points, "
    .. "without those in bodies and behind walls" },
}

local kinds = { ["%.ktx2$"] = "cube", ["%.three%.json$"] = "three", ["%.npy$"] = "npy" }

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
    .. "'.ktx2' ambient cubes (irradiance over pi at six faces, alpha: validity) as Bevy reads them, '.three.json' the atlas of "
    .. "three.js' LightProbeGrid (degree 2, radiance, halves, base64), '.npy' coefficients [nz][ny][nx][channels][(lmax+1)^2]. "
    .. "Axes stay as they are.",
  arguments = { { "path", "string", "ends in .ktx2, .three.json or .npy" }, { "options?", "table", "" } },
  options = options,
  returns = { { "report", "table", "cells; probes; error: 99 % of the held-out points keep it (relative L2 distance of what is "
    .. "exported from the grid's own); met, with a tolerance; validity, array [nz ny nx]: 1 less the part that is in bodies; "
    .. "dering: the window's report; bytes; warning, where the tolerance is not met" } },
  errors = "raises on another ending and bad options; nil, message, code where the file cannot be written or memory runs out; "
    .. "nil, message, 'ELIMIT' where the tolerance is not met (nothing is written then), or bytes is too few",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 10 }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 2 }, lamp)
local name = os.tmpname() .. ".ktx2"
local report = assert(grid:export(name, { cells = { 3, 3, 3 } }))
assert(report.probes == 27 and report.error < 0.5)
os.remove(name)]],
  source = "Mitchell, McTaggart, Green 2006 (ambient cubes)",
}
function methods.export(g, path, given)
  open(g, "export")
  local kind
  for pattern, name in pairs(kinds) do
    if type(path) == "string" and path:lower():find(pattern) and not path:find "%z" then kind = name end
  end
  if not kind then
    return check.bad(1, "export", "a path ending in .ktx2, .three.json or .npy expected, got %s", check.describe(path))
  end
  local o = form.options(2, "export", options, given)
  if o.tolerance and o.cells then return check.fail "export: either tolerance or cells, not both" end
  if o.lmax and kind ~= "npy" then return check.fail "export: lmax is of .npy: probes of engines have degree 2" end
  local lmax = kind == "cube" and g.lmax or o.lmax or LMAX
  local good, message, code = core.file_probe(path)
  if not good then return nil, message, code end
  local points = o.points and array.points(2, "export", o.points, "float") or held_out(g)
  if #points == 0 then return check.bad(2, "export", "points: at least one expected") end
  local judge, tolerance = judge_of(g, kind, lmax, points), o.tolerance or TOLERANCE
  local cells, found = o.cells
  local function too_large(picked) return o.bytes and bytes_of(kind, picked, g, o) > o.bytes end
  local least = cells or cells_of(g, 2)
  if too_large(least) then
    return nil, ("export: %d x %d x %d cells take %.0f bytes, and bytes = %.0f: give more"):format(least[1], least[2], least[3],
      bytes_of(kind, least, g, o), o.bytes), "ELIMIT"
  end
  if cells then
    if too_many(cells) then
      return check.bad(2, "export", "cells: at most %d probes, got %d x %d x %d", MOST_PROBES, cells[1], cells[2], cells[3])
    end
    found, message, code = error_of(g, judge, cells)
    if not found then return nil, message, code end
  else
    cells, found, code = choose(g, judge, tolerance, too_large)
    if not cells then return nil, found, code end
  end
  local positions = middles(g, cells)
  local c, validity = sh.resize(g:sample(positions), lmax), validity_of(g, positions)
  local report = { cells = cells, probes = #positions, error = found, validity = validity }
  if o.dering then
    c, report.dering = sh.dering(c)
    if report.dering.width then
      found, message, code = error_of(g, judge, cells, report.dering.width)
      if not found then return nil, message, code end
      report.error = found
    end
  end
  if not o.cells then
    report.met = found <= tolerance
    local sentence = not report.met and unmet_by(report, tolerance, o)
    if sentence and not o.anyway then return nil, sentence .. ", or anyway = true to write it; nothing was written", "ELIMIT" end
    report.warning = sentence and warning.say(g, "export", "%s", sentence) or nil
  end
  local ok
  if kind == "npy" then
    local shape = { cells[3], cells[2], cells[1], c.shape[2], c.shape[3] }
    ok, message, code = array.array(c, o.dtype):reshape(shape):save(path)
    report.bytes = report.probes * c.shape[2] * c.shape[3] * (o.dtype == "float16" and 2 or 4)
  else
    local bytes = (kind == "cube" and cubes or atlas)(g, cells, c, validity)
    report.bytes = #bytes
    ok, message, code = core.file_save(path, bytes)
  end
  if not ok then return nil, message, code end
  return report
end
