-- Probes for engines beside rivals: ten scenes, judged by paths at 500 places of surfaces.
--
--     make bench BENCH=rivals         build/ylm run spec/bench/rivals.lua [scene: a pattern] [folder]
--
-- A first table has light that answers anywhere: grids of ylm, of three.js and of EEVEE. A second one has light at the 500
-- places alone: Cycles, Radiance, POV-Ray, and ylm's paths. Truths and answers of rivals are kept in the folder (default
-- out/rivals) by a hash of the scene, since both take minutes, and the grid by the scene's name. A program that fails in a
-- scene, or takes more than 600 processor seconds, is one line. Seconds are those of processors. Where surfaces face out of the
-- scene's box, three.js is also baked in a wider one, since it lights nothing outside. YLM_BENCH_SECONDS bounds the paths of a
-- scene (default 60).
-- Bytes are those of the halves that an engine holds, 3 x 9 numbers a probe and what pads three.js' atlas, without base64.
-- SCENE.tsv in the folder has all rows, and SCENE.seen.*.npy what the scene's camera sees: spec/bench/rivals/draw.lua draws
-- charts and pictures of them.

local blender = require "spec.bench.rivals.blender"
local places = require "spec.support.surface_places"
local plain = require "spec.bench.rivals.plain"
local probe_reader = require "spec.support.probe_reader"
local reader = require "spec.support.engine_reader"
local seen_places = require "spec.bench.rivals.seen"
local three = require "spec.bench.rivals.three"
local truths = require "spec.bench.rivals.truth"
local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore
local pattern, folder = arg[1] or "", arg[2] or "out/rivals"
local seconds_most = tonumber(os.getenv "YLM_BENCH_SECONDS") or 60
local TOLERANCE, BOUNCES, CUBE = 0.1, { 4, 12 }, 16
local PARTS = { 6, 12 } -- of the mean extent of a box: cells of the lattices
local BOTH = {} -- the second one also
local AT_PLACES = { blender.cycles, require "spec.bench.rivals.radiance", require "spec.bench.rivals.povray" }
local SAMPLES = { 4096, 512 } -- of ylm's paths at places

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

local rows -- of charts

local function say(entry, name, r, bytes, seconds, kind, pictured)
  print(("| %s | %.1f %% | %.1f %% | %.1f %% | %s | %s | %s |"):format(name, 100 * r.rms, 100 * r.q90, 100 * r.q99,
    r.leak and ("%.3f %%"):format(100 * r.leak) or "", bytes and ("%.1f kB"):format(bytes / 1000) or "",
    seconds and ("%.1f"):format(seconds) or ""))
  io.stdout:flush()
  rows:write(table.concat({ entry.name, kind or name, r.rms, r.q99, r.leak or "", bytes or "", seconds or "",
    pictured and 1 or 0 }, "\t"), "\n")
end

local function say_not(name, why) print(("| %s | %s | | | | | |"):format(name, why)) end

--- The cells of a box, about `parts` along its mean extent.
local function cells_of(box, parts)
  local h, cells = 0, {}
  for a = 1, 3 do h = h + (box[2][a] - box[1][a]) / 3 / parts end
  for a = 1, 3 do cells[a] = math.max(2, math.floor((box[2][a] - box[1][a]) / h + 0.5)) end
  return cells
end

local function atlas_bytes(cells) return 56 * cells[1] * cells[2] * (cells[3] + 2) end

--- Calls f: a row that fails is one line, and the others follow.
local function attempt(name, f, ...)
  local fine, why = pcall(f, ...)
  if not fine then say_not(name, "failed: " .. tostring(why):match "[^\n]*") end
end

--- Answers at n places, processor seconds and bytes: from the folder, by the hash of the scene, or by run(). Or nil, why not.
local function kept(truth, n, name, run)
  local path = ("%s/%s-%d-%s.npy"):format(folder, truth.head, n, (name:gsub("[^%w]+", "_")))
  local file = io.open(path)
  if file then
    file:close()
    local E = assert(ylm.load(path)):totable()
    local last = table.remove(E)
    return E, last[1], last[2] > 0 and last[2] or nil
  end
  local E, seconds, bytes = run()
  if not E then return nil, seconds end
  assert(#E == n, #E .. " answers")
  E[#E + 1] = { seconds, bytes or 0, 0 }
  assert(ylm.array(E, "double"):save(path))
  table.remove(E)
  return E, seconds, bytes
end

--- The row of a rival.
local function by_rival(entry, truth, name, kind, run)
  local E, seconds, bytes = kept(truth, #truth.points, name, run)
  if E then say(entry, name, judged(entry, truth, E), bytes, seconds, kind) else say_not(name, seconds) end
end

--- The row of a rival that answers anywhere, by run(points, normals), and, with `pictured`, what the camera sees of its light.
local function by_probes(entry, truth, seen, name, kind, pictured, run)
  attempt(name, function()
    local points, normals = truth.points, truth.normals
    if pictured then points, normals = seen.all_points, seen.all_normals end
    local E, seconds, bytes = kept(truth, #points, name, function() return run(points, normals) end)
    if not E then return say_not(name, seconds) end
    say(entry, name, judged(entry, truth, E), bytes, seconds, kind, pictured)
    if pictured then seen:keep(kind, E) end
  end)
end

local function named(name, cells, bounces) return ("%s, %s, %d bounces"):format(name, table.concat(cells, " x "), bounces) end

--- three.js in the boxes, from the one that its picture is of to the others.
local function by_three(entry, scene, truth, seen, boxes, cells)
  local why = three.lacks()
  if why then return say_not("three.js", why) end
  for k, box in ipairs(boxes) do
    for i, bounces in ipairs(BOUNCES) do
      by_probes(entry, truth, seen, named("three.js", cells, bounces) .. (k > 1 and ", wider box" or ""), "three.js",
        k == 1 and i == #BOUNCES, function(points, normals)
          local read, seconds = three.bake(scene, { lo = box[1], hi = box[2], cells = cells }, bounces, CUBE)
          if not read then return nil, seconds end
          return read(points, normals), seconds, atlas_bytes(cells)
        end)
    end
  end
end

local function by_eevee(entry, scene, truth, seen, box, cells)
  local why = blender.eevee.lacks()
  if why then return say_not("EEVEE", why) end
  for i, bounces in ipairs(BOUNCES) do
    by_probes(entry, truth, seen, named("EEVEE", cells, bounces), "EEVEE", i == #BOUNCES, function(points, normals)
      return blender.eevee.run(plain.of(scene), points, normals, entry.quantity,
        { box = box, cells = cells, bounces = bounces, cube = 64 })
    end)
  end
end

--- Rivals that answer at places alone, and ylm's paths there.
local function at_places(entry, scene, truth)
  for _, rival in ipairs(AT_PLACES) do
    local why = rival.lacks()
    for _, setting in ipairs(why and {} or rival.settings) do
      local name = rival.name .. ", " .. setting.name
      attempt(name, by_rival, entry, truth, name, rival.name:match "[^,]+", function()
        return rival.run(plain.of(scene), truth.points, truth.normals, entry.quantity, setting)
      end)
    end
    if why then say_not(rival.name, why) end
  end
  for _, samples in ipairs(SAMPLES) do
    local name = ("ylm, %d paths a place"):format(samples)
    attempt(name, by_rival, entry, truth, name, "ylm, paths", function()
      local began = os.clock()
      local E, why = scene:probe { points = truth.points, normals = truth.normals, samples = samples, seed = 7, progress = false,
        reflections = { entry.quantity == "all" and 0 or 1, "all" } }
      if not E then return nil, why end
      return E:totable(), os.clock() - began, 12 * #truth.points
    end)
  end
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
    say(entry, ("ylm, %s, %s%s"):format(fitted and "fitted" or "sampled", table.concat(o.cells, " x "),
      #report.grids > 1 and (" in %d grids"):format(#report.grids) or ""),
      judged(entry, truth, reader.of(path).read(truth.points, truth.normals)), size(), os.clock() - began,
      fitted and "ylm, fitted" or "ylm, sampled")
  end
  os.remove(path)
  os.remove(name)
end

--- ylm's bricks, in the bytes of a lattice and in a quarter of them.
local function by_bricks(entry, scene, truth, seen, grid, bytes)
  local name = os.tmpname()
  local path = name .. ".ylmp"
  for _, most in ipairs { bytes, bytes / 4 } do
    local began = os.clock()
    local report, why = grid:export(path, { scene = scene, bytes = most })
    if report then
      local file = assert(io.open(path, "rb"))
      local look, E = probe_reader.of(file:read "*a"), {}
      file:close()
      for i, p in ipairs(seen.all_points) do E[i] = look(p, seen.all_normals[i]) end
      if most == bytes then seen:keep("ylm, .ylmp", E) end
      say(entry, ("ylm, bricks, %d and %d points"):format(report.bricks, report.probes), judged(entry, truth, E), report.bytes,
        os.clock() - began, "ylm, bricks", most == bytes)
    else say_not("ylm, bricks", why) end
  end
  os.remove(path)
  os.remove(name)
end

--- The grid itself, in few bytes, and processor seconds of its bake, which stand beside it.
local function grid_of(entry, scene, truth)
  local path = folder .. "/" .. entry.name .. ".ylm"
  local file = io.open(path .. ".seconds")
  local grid, seconds
  if file then
    seconds = tonumber(file:read "*a")
    file:close()
    grid = assert(ylm.load(path))
  else
    local began = os.clock()
    grid = assert(scene:bake { quantity = entry.quantity, progress = false,
      probes = ylm.adaptive_grid { lmax = 2, tolerance = TOLERANCE, bounds = entry.box } })
    seconds = os.clock() - began
    assert(grid:save(path))
    file = assert(io.open(path .. ".seconds", "w"))
    file:write(seconds)
    file:close()
  end
  local small = os.tmpname()
  local _, report = assert(grid:save(small .. ".ylm", { step = 0.05 }))
  local read = assert(ylm.load(small .. ".ylm"))
  say(entry, ("ylm's grid, tolerance %g, few bytes"):format(TOLERANCE),
    judged(entry, truth, read:irradiance(truth.points, truth.normals, { scene = read.sides and scene or nil }):totable()),
    report.bytes, seconds, "ylm's grid")
  os.remove(small .. ".ylm")
  os.remove(small)
  return grid
end

--- Do two boxes differ by less than 1 cm?
local function are_near(a, b)
  for k = 1, 2 do for i = 1, 3 do if math.abs(a[k][i] - b[k][i]) > 0.01 then return false end end end
  return true
end

local HEAD = "| %s | rms | 90 %% | 99 %% | leak | bytes | seconds |\n| --- | --- | --- | --- | --- | --- | --- |"

local function run(entry)
  local scene = entry.make(ylm)
  local box = entry.box or places.box_of(scene)
  local truth = truths.of(entry, scene, folder, seconds_most)
  print(("\n%s, %s light; noise of the truth %.1f %%\n"):format(entry.name, entry.quantity, 100 * truth.noise))
  rows = assert(io.open(("%s/%s.tsv"):format(folder, entry.name), "w"))
  print(HEAD:format "probes, anywhere")
  local grid, seen = grid_of(entry, scene, truth), seen_places.of(entry, scene, truth, folder)
  for k = 1, BOTH[entry.name] and 2 or 1 do
    local cells = cells_of(box, PARTS[k])
    local wide = assert(grid:export(folder .. "/box.npy", { cells = cells, scene = scene, offset = 0.5 })).grids[1].bounds
    by_three(entry, scene, truth, seen, are_near(box, wide) and { box } or { box, wide }, cells)
    by_eevee(entry, scene, truth, seen, box, cells)
    attempt("ylm, lattices", by_ylm, entry, scene, truth, grid, cells)
    attempt("ylm, bricks", by_bricks, entry, scene, truth, seen, grid, atlas_bytes(cells))
  end
  print("\n" .. HEAD:format "at the places alone")
  at_places(entry, scene, truth)
  rows:close()
end

for _, rival in ipairs { three, unpack(AT_PLACES) } do
  if not rival.lacks() then print(rival.name .. ": " .. (rival.version() or "version unknown")) end
end
for _, entry in ipairs(require "spec.bench.rivals.scenes") do
  if entry.name:find(pattern) then attempt(entry.name, run, entry) end
end
