-- Probes for engines beside three.js' own: ten scenes, judged by paths at 500 places of surfaces.
--
--     make bench BENCH=rivals         build/ylm run spec/bench/rivals.lua [scene: a pattern] [folder]
--
-- Truths and what three.js' bakes answered are kept in the folder (default out/rivals), since both take minutes; a seconds column
-- has those of the run that made them. The box of a lattice is wider than the grid where surfaces face out of it, since three.js
-- lights nothing else. YLM_BENCH_SECONDS bounds the paths of a scene (default 60). Bytes are those of the halves
-- that an engine holds, 3 x 9 numbers a probe and what pads three.js' atlas, without base64.

local places = require "spec.support.surface_places"
local probe_reader = require "spec.support.probe_reader"
local reader = require "spec.support.engine_reader"
local three = require "spec.bench.rivals.three"
local truths = require "spec.bench.rivals.truth"
local ylm = require "ylm"

local pattern, folder = arg[1] or "", arg[2] or "out/rivals"
local seconds_most = tonumber(os.getenv "YLM_BENCH_SECONDS") or 60
local TOLERANCE, BOUNCES, CUBE = 0.1, 4, 16
local PARTS = { 6, 12 } -- of the mean extent of a box: cells of the lattices
local BOTH = {} -- the second one also

ylm.on_warning(false)
os.execute("mkdir -p '" .. folder:gsub("'", "'\\''") .. "'")

local function within(box, p) return box and places.within(box, p) end

--- Numbers of a table's row, of irradiance E [n][3] beside a truth.
local function judged(entry, truth, E)
  local mean, n, square, leak, dark, errors = 0, 0, 0, 0, 0, {}
  for i, p in ipairs(truth.points) do
    if not within(entry.closed, p) then mean, n = mean + truths.luminance(truth.E[i]), n + 1 end
  end
  mean = mean / n
  for i, p in ipairs(truth.points) do
    local got, wanted = truths.luminance(E[i]), truths.luminance(truth.E[i])
    if within(entry.closed, p) then leak, dark = leak + got / mean, dark + 1
    else
      square = square + ((got - wanted) / mean) ^ 2 / n
      errors[#errors + 1] = math.abs(got - wanted) / math.max(wanted, mean)
    end
  end
  table.sort(errors)
  return { rms = math.sqrt(square), q90 = errors[math.ceil(0.9 * #errors)], q99 = errors[math.ceil(0.99 * #errors)],
    leak = dark > 0 and leak / dark or nil }
end

local function say(name, r, bytes, seconds)
  print(("| %s | %.1f %% | %.1f %% | %.1f %% | %s | %s | %s |"):format(name, 100 * r.rms, 100 * r.q90, 100 * r.q99,
    r.leak and ("%.3f %%"):format(100 * r.leak) or "", bytes and ("%.1f kB"):format(bytes / 1000) or "",
    seconds and ("%.0f"):format(seconds) or ""))
  io.stdout:flush()
end

--- The cells of a box, about `parts` along its mean extent.
local function cells_of(box, parts)
  local h, cells = 0, {}
  for a = 1, 3 do h = h + (box[2][a] - box[1][a]) / 3 / parts end
  for a = 1, 3 do cells[a] = math.max(2, math.floor((box[2][a] - box[1][a]) / h + 0.5)) end
  return cells
end

local function atlas_bytes(cells) return 56 * cells[1] * cells[2] * (cells[3] + 2) end

--- Answers of three.js' own bake at the truth's places, and its seconds: from the folder, or baked. Or nil, why not.
local function by_three(entry, scene, truth, box, cells)
  local path = ("%s/three-%s-%s.npy"):format(folder, entry.name, table.concat(cells, "x"))
  local file = io.open(path)
  if file then
    file:close()
    local rows = assert(ylm.load(path)):totable()
    return rows, table.remove(rows)[1]
  end
  local why = three.lacks()
  if why then return nil, why end
  local read, seconds = three.bake(scene, { lo = box[1], hi = box[2], cells = cells }, BOUNCES, CUBE)
  if not read then return nil, seconds end
  local rows = read(truth.points, truth.normals)
  rows[#rows + 1] = { seconds, 0, 0 }
  assert(ylm.array(rows, "float"):save(path))
  return rows, table.remove(rows)[1]
end

--- ylm's exports at the bytes of a lattice.
local function by_ylm(entry, scene, truth, grid, cells)
  local name = os.tmpname()
  local path = name .. ".three.json"
  for _, fitted in ipairs { false, true } do
    local began = os.clock()
    local o = { cells = cells, scene = fitted and scene or nil }
    local raw = atlas_bytes(cells)
    local report = assert(grid:export(path, o))
    local function size()
      local sum = 0
      for _, g in ipairs(report.grids) do sum = sum + atlas_bytes(g.cells) end
      return sum
    end
    while fitted and size() > raw do -- grids that walls part have more layers that are there twice
      local smaller = {}
      for a = 1, 3 do smaller[a] = o.cells[a] > 2 and o.cells[a] - (o.cells[a] >= math.max(o.cells[1], o.cells[2], o.cells[3])
        and 1 or 0) or 2 end
      o.cells = smaller
      report = assert(grid:export(path, o))
    end
    say(("ylm, %s, %s%s"):format(fitted and "fitted" or "sampled", table.concat(o.cells, " x "),
      #report.grids > 1 and (" in %d grids"):format(#report.grids) or ""),
      judged(entry, truth, reader.of(path).read(truth.points, truth.normals)), size(), os.clock() - began)
  end
  os.remove(path)
  os.remove(name)
end

--- ylm's bricks, in the bytes of a lattice and in a quarter of them.
local function by_bricks(entry, scene, truth, grid, bytes)
  local name = os.tmpname()
  local path = name .. ".ylmp"
  for _, most in ipairs { bytes, bytes / 4 } do
    local began = os.clock()
    local report, why = grid:export(path, { scene = scene, bytes = most })
    if report then
      local file = assert(io.open(path, "rb"))
      local look, E = probe_reader.of(file:read "*a"), {}
      file:close()
      for i, p in ipairs(truth.points) do E[i] = look(p, truth.normals[i]) end
      say(("ylm, bricks, %d and %d points"):format(report.bricks, report.probes), judged(entry, truth, E), report.bytes,
        os.clock() - began)
    else print("| ylm, bricks | " .. why .. " | | | | | |") end
  end
  os.remove(path)
  os.remove(name)
end

--- The grid itself, in few bytes, and seconds of its bake.
local function grid_of(entry, scene, truth)
  local path, began = folder .. "/" .. entry.name .. ".ylm", os.time()
  local file = io.open(path)
  local grid
  if file then
    file:close()
    grid, began = assert(ylm.load(path)), nil
  else
    grid = assert(scene:bake { quantity = entry.quantity, progress = false,
      probes = ylm.adaptive_grid { lmax = 2, tolerance = TOLERANCE, bounds = entry.box } })
    assert(grid:save(path))
  end
  local small = os.tmpname()
  local _, report = assert(grid:save(small .. ".ylm", { step = 0.05 }))
  local read = assert(ylm.load(small .. ".ylm"))
  say(("ylm's grid, tolerance %g, few bytes"):format(TOLERANCE),
    judged(entry, truth, read:irradiance(truth.points, truth.normals, { scene = read.sides and scene or nil }):totable()),
    report.bytes, began and os.time() - began)
  os.remove(small .. ".ylm")
  os.remove(small)
  return grid
end

local function run(entry)
  local scene = entry.make(ylm)
  local box = entry.box or places.box_of(scene)
  local truth = truths.of(entry, scene, folder, seconds_most)
  print(("\n%s, %s light; noise of the truth %.1f %%\n"):format(entry.name, entry.quantity, 100 * truth.noise))
  print "| probes | rms | 90 % | 99 % | leak | bytes | seconds |\n| --- | --- | --- | --- | --- | --- | --- |"
  local grid = grid_of(entry, scene, truth)
  for k = 1, BOTH[entry.name] and 2 or 1 do
    local cells = cells_of(box, PARTS[k])
    box = assert(grid:export(folder .. "/box.npy", { cells = cells, scene = scene, offset = 0.5 })).grids[1].bounds
    local E, seconds = by_three(entry, scene, truth, box, cells)
    local name = "three.js, " .. table.concat(cells, " x ")
    if E then say(name, judged(entry, truth, E), atlas_bytes(cells), seconds)
    else print(("| %s | %s | | | | | |"):format(name, seconds)) end
    by_ylm(entry, scene, truth, grid, cells)
    by_bricks(entry, scene, truth, grid, atlas_bytes(cells))
  end
end

for _, entry in ipairs(require "spec.bench.rivals.scenes") do if entry.name:find(pattern) then run(entry) end end
