-- Grids in few bytes beside other forms of the same light: bytes, the error in all at 99 % of the places, its median, seconds.
--
--     make bench BENCH=bytes        prints the tables and writes out/bench/bytes.png
--
-- Errors of the first table are those at the bakes' held-out places, which neither bake nor rounding has seen; "fresh" are
-- 4096 other places of the floor. Regular lattices are L2, and their errors are within L2. Two rooms are judged by paths.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local random = require "spec.support.random"

local out = (arg and arg[1] or "out/bench") .. "/"
os.execute(("mkdir -p '%s'"):format(out))

local floor_lights = assert(ylm.load "examples/scenes/floor_lights.lua")
local two_lamps = assert(ylm.load "examples/scenes/two_lamps.lua")

--- Places on the floor of floor_lights.
local function floor_places(n)
  local r, t = random.from(77), {}
  for i = 1, n do t[i] = { 11 * r() - 5.5, 0, 11 * r() - 5.5 } end
  return ylm.array(t, "double")
end
local fresh = floor_places(4096)

--- Relative errors of rows, sorted; the 99 % quantile and the median.
local function quantiles(value, exact)
  local e = grids.errors(value, exact)
  return grids.quantile(e, 0.99), grids.quantile(e, 0.5)
end

local exact = {}
local function fresh_error(grid)
  exact[grid.lmax] = exact[grid.lmax] or assert(ylm.light_field(grid.lmax, floor_lights.lights, fresh, { dtype = "float" }))
  return quantiles(grid:sample(fresh), exact[grid.lmax])
end

--- A bake, with its processor seconds.
local function bake(scene, form, occupied)
  local t = os.clock()
  local grid = assert(scene:bake { probes = ylm.adaptive_grid(form), occupied = occupied, threads = 1, progress = false })
  return grid, os.clock() - t
end

--- The file of a grid in few bytes, what it decodes to, its report; processor seconds of one thread.
local function pack(grid, how)
  local t = os.clock()
  local bytes, report = assert(core.grid_encode_small(grid, how.tolerance or 0, how.bytes or 0, how.step or 0, 1))
  local encoded = os.clock() - t
  t = os.clock()
  local read = assert(core.grid_decode(bytes))
  return bytes, read, report, encoded, os.clock() - t
end

print "few bytes: tolerance in all; bytes; bytes a point; 99 % and median at held-out places; 99 % at fresh ones;"
print "  seconds of bake, encoding (the search included) and decoding, one thread"
local function row(name, scene, form, tolerance, occupied)
  local grid, seconds = bake(scene, form, occupied)
  local raw = #core.grid_encode(grid)
  local bytes, read, report, encoded, decoded = pack(grid, { tolerance = tolerance })
  local has_fresh = scene == floor_lights and occupied == "surfaces" and not form.measure
  print(("  %-35s %6.4f %9d %6.1f   %.4f %.4f  %s   %5.2f %5.2f %5.2f   1/%d of %.1f MB"):format(name, tolerance, #bytes,
    #bytes / grid.stats.points, report.error, report.median, has_fresh and ("%.4f"):format((fresh_error(read))) or "  -   ",
    seconds, encoded, decoded, math.floor(raw / #bytes + 0.5), raw / 1e6))
  read:close()
  return grid, #bytes, report
end
row("floor_lights, camera", floor_lights, { lmax = 4, depth = 9, tolerance = 0.01 }, 0.01, "camera"):close()
row("floor_lights, camera, baked to .006", floor_lights, { lmax = 4, depth = 9, tolerance = 0.006 }, 0.01, "camera"):close()
row("floor_lights, surfaces", floor_lights, { lmax = 4, depth = 9, tolerance = 0.006 }, 0.01, "surfaces"):close()
row("two_lamps, surfaces", two_lamps, { lmax = 4, depth = 7, tolerance = 0.006 }, 0.01, "surfaces"):close()
row("floor_lights, irradiance", floor_lights, { lmax = 4, depth = 9, tolerance = 0.01, measure = "irradiance" }, 0.0125,
  "surfaces"):close()
row("floor_lights, lmax 8", floor_lights, { lmax = 8, depth = 9, tolerance = 0.014 }, 0.02, "surfaces"):close()
local small, small_bytes, small_report = row("floor_lights, lmax 2", floor_lights, { lmax = 2, depth = 9, tolerance = 0.012 },
  0.02, "surfaces")
small:close()

-- Rows that are decoded a second: 50 runs of the sums in memory, without reading the file.
do
  local grid = bake(floor_lights, { lmax = 4, depth = 9, tolerance = 0.01 }, "surfaces")
  local bytes, read, _, _, first = pack(grid, { tolerance = 0.014 })
  local best, plain = first, math.huge
  local whole = core.grid_encode(grid)
  for _ = 1, 5 do
    local t = os.clock()
    assert(core.grid_decode(bytes)):close()
    best = math.min(best, os.clock() - t)
    t = os.clock()
    assert(core.grid_decode(whole)):close()
    plain = math.min(plain, os.clock() - t)
  end
  local rows = grid.stats.points * 4 * grid.channels * (grid.lmax + 1) ^ 2 * 4 / 1e6
  print(("decoding, one thread: %.0f MB of rows in %.3f s, continuity and interpolated points included; %.3f s beyond reading "
    .. "the same grid as it is: %.0f MB/s"):format(rows, best, best - plain, rows / math.max(best - plain, 1e-3)))
  grid:close()
  read:close()
end

local low, high = { -5.50158, -0.0265304, -5.50158 }, { 5.50158, 2.52653, 5.50158 }

--- Voxels of a lattice that surfaces of floor_lights meet.
local function met_by_surfaces(cells)
  local grid = assert(floor_lights:bake { probes = ylm.uniform_grid { bounds = { low, high }, cells = cells, lmax = 0,
    channels = "luminance", metric_channels = "none" }, occupied = "surfaces", progress = false })
  local n = grid.stats.leaves
  grid:close()
  return n
end

-- Folders of bricks, each of which is read alone, beside one file at the same step.
do
  local folder = os.tmpname()
  os.remove(folder)
  for level = 2, 3 do
    local name = ("%s-%d.ylmd"):format(folder, level)
    local set = assert(floor_lights:bake { probes = ylm.adaptive_grid { lmax = 4, depth = 9, tolerance = 0.01, bricks = level },
      occupied = "surfaces", folder = name, progress = false })
    local _, many = assert(set:save(name .. "-few.ylmd", { step = 0.0022 }))
    local _, one = assert(set:save(name .. "-few.ylm", { step = 0.0022 }))
    print(("bricks of floor_lights: %d of %.0f points: %d bytes, %.2f times those of one file, %d; rounding %.4f and %.4f")
      :format(set.stats.bricks, set.stats.points / set.stats.bricks, many.bytes, many.bytes / one.bytes, one.bytes,
        many.rounding, one.rounding))
    os.execute(("rm -r %s %s-few.ylmd %s-few.ylm"):format(name, name, name))
  end
end

-- Other forms of the same light, at the same fresh places, in L2.
print "regular lattices of L2 in halves; those of bricks have only bricks of 4 x 4 x 4 that surfaces meet"
local places = fresh
local l2 = assert(ylm.light_field(2, floor_lights.lights, places, { dtype = "float" }))
for _, n in ipairs { 64, 128, 256, 512 } do
  local cells = { n, math.ceil(n * 15 / 64), n }
  local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { low, high }, cells = cells, lmax = 2, metric_channels = "none" },
    floor_lights.lights, { occupied = places }))
  local q99, median = quantiles(grid:sample(places, { interpolation = "linear" }), l2)
  local points = (cells[1] + 1) * (cells[2] + 1) * (cells[3] + 1)
  local bricks = met_by_surfaces { math.ceil(cells[1] / 4), math.ceil(cells[2] / 4), math.ceil(cells[3] / 4) }
  print(("  %3d x %3d x %3d: %11d bytes, in bricks %9d: 99 %% %.3f, median %.4f; 28 bytes a voxel (R11G11B10F and 24 "
    .. "bytes) %9d; ZH3 (15 halves) %10d"):format(cells[1], cells[2], cells[3], points * 54, bricks * 64 * 54, q99,
    median, bricks * 64 * 28, points * 30))
  grid:close()
end
print(("  few bytes, lmax 2, all surfaces: %d bytes: 99 %% %.4f, median %.4f"):format(small_bytes, small_report.error,
  small_report.median))

-- Error over bytes: three bakes, rounded more and more, and what a number of bytes ends with.
print "error in all over bytes: bakes to a tolerance, rounded by steps, and bake { bytes = n }"
local series = {}
for _, tolerance in ipairs { 0.006, 0.015, 0.04 } do
  local grid = bake(floor_lights, { lmax = 4, depth = 9, tolerance = tolerance }, "surfaces")
  local x, y, text = {}, {}, {}
  for i, step in ipairs { 0.0015, 0.003, 0.006, 0.012, 0.024 } do
    local bytes, read, report = pack(grid, { step = step })
    read:close()
    x[i], y[i], text[i] = #bytes / 1e6, report.error, ("%.3f MB %.4f"):format(#bytes / 1e6, report.error)
  end
  series[#series + 1] = { label = ("baked to %g"):format(tolerance), x = x, y = y }
  print(("  baked to %-6g %s"):format(tolerance, table.concat(text, "  ")))
  grid:close()
end
local bx, by, said = {}, {}, {}
for i, bytes in ipairs { 300e3, 600e3, 1200e3 } do
  local grid = assert(floor_lights:bake { probes = ylm.adaptive_grid { lmax = 4, depth = 9, bytes = bytes },
    occupied = "surfaces", progress = false })
  bx[i], by[i], said[i] = bytes / 1e6, grid.small.error, ("%.1f MB %.4f"):format(bytes / 1e6, grid.small.error)
  grid:close()
end
series[#series + 1] = { label = "bake { bytes = n }", x = bx, y = by }
print("  bytes = n       " .. table.concat(said, "  "))
if ylm.plot then
  local drawn = ylm.plot { title = "Error in all over bytes: floor_lights, surfaces, lmax 4, RGB", series = series,
    x_label = "MB", y_label = "error at 99 % of the surface", x_log = true, y_log = true, legend = "top right" }
  assert(drawn:save(out .. "bytes.png"))
end

require "spec.support.bytes_in_rooms" ()
