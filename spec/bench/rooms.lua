-- Grids of light that jumps at walls, and surface grids, beside paths: five scenes with walls and the three of bounce_scenes.
--
--     build/ylm run spec/bench/rooms.lua [scene: a pattern] [seed] [folder of truths] [all | truth | fine | again] [rows]
--
-- `make bench BENCH=rooms` runs it without arguments: all scenes, seeds 1 to 3, the rows of tolerance 0.1, in hours. Rows are
-- patterns too, such as "^surfaces 0.1" or "^uniform 0.25$|^adaptive 0.1$"; if a scene is named, the default is all of them.
--
-- Each seed has 2,000 places of surfaces and their irradiance by paths, which are kept in the folder, so that several libraries
-- are judged by the same truth. "truth" makes these alone; called again it adds paths. YLM_BENCH_SECONDS bounds the paths of a
-- call (default 100). With YLM_BENCH_LABEL = a word, what grids answered at the places is kept beside the truth, and "again"
-- judges that without a bake. "fine" keeps the light there of a gathered field of 49,152 rays to degree 8, whose elements have
-- another seed: a truth without noise, for quantiles below the paths' noise, but with the elements' error. How far it is from the
-- paths is printed.

local places = require "spec.support.surface_places"
local ylm = require "ylm"

local PLACES, OFF = 2000, places.OFF
local RAYS, LMAX, PILOT, WANTED = 1728, 2, 1024, 0.003
local MOST = 30000                                     -- points of adaptive grids whose look-up knows no walls
local LUMINANCE = { 0.2126, 0.7152, 0.0722 }
local FINE, FINE_LMAX = 49152, 8
local COSINE = { [0] = math.pi, 2 * math.pi / 3, math.pi / 4, 0, -math.pi / 24, 0, math.pi / 64, 0, -math.pi / 128 }

local SEEDS = 3
local pattern, seed, folder = arg[1] or "", tonumber(arg[2]), arg[3] or "out/rooms"
local truth_alone, judged_again, fine_alone = arg[4] == "truth", arg[4] == "again", arg[4] == "fine"
local rows_wanted = arg[5] or (arg[1] and "." or "[es] 0%.1") -- "adaptive 0.1" and "surfaces 0.1"
local first_seed, last_seed = seed or 1, seed or SEEDS
local label = os.getenv "YLM_BENCH_LABEL"
local seconds_most = tonumber(os.getenv "YLM_BENCH_SECONDS") or 100

ylm.on_warning(false)

local entries = {}
for _, entry in ipairs(require "spec.support.walled_scenes") do entries[#entries + 1] = entry end
for _, entry in ipairs(require "spec.support.bounce_scenes") do
  entries[#entries + 1] = { name = entry.name, make = entry.make, quantity = "indirect" }
end

--- Is a row asked for?
local function is_wanted(name)
  for row in rows_wanted:gmatch "[^|]+" do
    if name:find(row) then return true end
  end
  return false
end

local function lum(c) return LUMINANCE[1] * c[1] + LUMINANCE[2] * c[2] + LUMINANCE[3] * c[3] end

-- The library ------------------------------------------------------------------

--- Does grid:sample take normals, and so know sides of walls?
local function knows_sides()
  pcall(require, "ylm.grid.sample")
  local entry = require "ylm.describe".entries["grid:sample"]
  for _, option in ipairs(entry and entry.options or {}) do if option[1] == "normals" then return true end end
  return false
end
local SIDED = knows_sides()

--- Floats a channel of the grid's points; tables of sides are not in it. Grids with sides keep values, others gradients too.
local function numbers(grid)
  return grid.stats.points * (SIDED and grid.sides and 1 or 4) * (grid.lmax + 1) ^ 2
end

--- Bytes of the file of a grid over its channels.
local function bytes(grid, channels, ending)
  local name = os.tmpname()
  local path = name .. ending
  local ok, size = grid:save(path), nil
  local f = ok and io.open(path, "rb")
  if f then
    size = f:seek "end"
    f:close()
  end
  os.remove(path)
  os.remove(name)
  return size and size / channels
end

--- Irradiance [n][3] by coefficients [n][3][count] of light and normals.
local function shaded(c, normals)
  local count = c.shape[3]
  local lmax = math.floor(math.sqrt(count) + 0.5) - 1
  local Y, out = ylm.sh.eval(lmax, ylm.array(normals)), {}
  for i = 1, #normals do
    local e = { 0, 0, 0 }
    for l = 0, lmax do
      for k = l * l + 1, (l + 1) ^ 2 do
        local w = COSINE[l] * Y:get(i, k)
        for channel = 1, 3 do e[channel] = e[channel] + w * c:get(i, channel, k) end
      end
    end
    out[i] = e
  end
  return out
end

--- Look-ups in a grid: { name, f(points, normals) -> irradiance }.
local function lookups(grid, scene)
  --- Options of grid:sample: a grid without sides takes none.
  local function by(more)
    return function(points, normals)
      return shaded(assert(grid:sample(points, more and { normals = normals, scene = more.scene })), normals)
    end
  end
  if not grid.sides then return { { "no sides", by(nil) } } end
  return { { "by ray", by { scene = scene } }, { "by bits", by {} } }
end

-- Truth --------------------------------------------------------------------------------------

--- Adds paths to a truth: E [n][3], V [n][3], its variance, and N [n], paths of a place (0: none yet). Places take as many as a
-- standard error of WANTED times the mean wants, all fewer where that would last longer than seconds_most. Returns their number.
local function add_paths(entry, scene, truth)
  local reflections = { entry.quantity == "all" and 0 or 1, "all" }
  local points, E, V, N, total, calls = truth.points, truth.E, truth.V, truth.N, 0, 0
  truth.rounds = truth.rounds + 1
  local function trace(which, samples)
    local p, n = {}, {}
    for k, i in ipairs(which) do p[k], n[k] = points[i], truth.normals[i] end
    calls = calls + 1
    local e, v, report = scene:probe { points = p, normals = n, samples = samples, reflections = reflections, progress = false,
      seed = 100000 * seed + 100 * truth.rounds + calls }
    if not e then error(v) end
    for k, i in ipairs(which) do
      local a, b = N[i] / (N[i] + samples), samples / (N[i] + samples)
      for c = 1, 3 do E[i][c], V[i][c] = a * E[i][c] + b * e:get(k, c), a * a * V[i][c] + b * b * v:get(k, c) end
      N[i] = N[i] + samples
    end
    total = total + report.paths
    return report.seconds
  end
  local all, missing, mean = {}, false, 0
  for i = 1, #points do all[i], missing = i, missing or N[i] == 0 end
  if missing then
    for i = 1, #points do E[i], V[i], N[i] = { 0, 0, 0 }, { 0, 0, 0 }, 0 end
  end
  local pilot = { {}, {}, {} }
  for i = 1, #points do
    pilot[1][i], pilot[2][i], pilot[3][i] = { E[i][1], E[i][2], E[i][3] }, { V[i][1], V[i][2], V[i][3] }, N[i]
  end
  local seconds = trace(all, PILOT)
  for i = 1, #points do mean = mean + lum(E[i]) / #points end
  local most, needs, sum = PILOT * #points * seconds_most / seconds, {}, 0
  local function wanted(factor)
    sum = 0
    for i = 1, #points do
      local v = 0 -- channels share their paths: standard errors are added
      for c = 1, 3 do v = v + LUMINANCE[c] * math.sqrt(V[i][c]) end
      local x = N[i] * ((v / (WANTED * factor * mean)) ^ 2 - 1)
      needs[i] = x <= PILOT and 0 or math.min(21, math.floor(math.log(x) / math.log(2) + 0.5))
      sum = sum + (needs[i] > 0 and 2 ^ needs[i] or 0)
    end
  end
  local factor = 1
  wanted(factor)
  while sum > most do
    factor = factor * 1.03
    wanted(factor)
  end
  for level = 10, 21 do
    local which = {}
    for i = 1, #points do if needs[i] == level then which[#which + 1] = i end end
    for _, i in ipairs(which) do E[i], V[i], N[i] = pilot[1][i], pilot[2][i], pilot[3][i] end -- not by chance
    if #which > 0 then trace(which, 2 ^ level) end
  end
  return total
end

local function slug(name) return (name:gsub("[^%w]+", "_")) end

local FIELDS = 13

--- Reads a truth; nil where there is none. Raises where it is of another scene.
local function read_truth(path, head)
  local file = io.open(path)
  if not file then return nil end
  local truth, first = { points = {}, normals = {}, E = {}, V = {}, N = {}, rounds = 1 }, file:read "*l"
  if first ~= head then error(("%s is of another scene: '%s', wanted '%s'"):format(path, first, head)) end
  for line in file:lines() do
    local x, i = {}, #truth.points + 1
    for word in line:gmatch "%S+" do x[#x + 1] = tonumber(word) end
    if #x == 1 then truth.rounds = x[1]
    elseif #x >= FIELDS - 1 then
      truth.points[i], truth.normals[i] = { x[1], x[2], x[3] }, { x[4], x[5], x[6] }
      truth.E[i], truth.V[i], truth.N[i] = { x[7], x[8], x[9] }, { x[10], x[11], x[12] }, x[13] or 0
    end
  end
  file:close()
  return truth
end

local function write_truth(path, head, truth)
  local file = assert(io.open(path .. ".part", "w"))
  file:write(head, "\n", truth.rounds, "\n")
  for i = 1, #truth.points do
    local row = {}
    for _, list in ipairs { truth.points, truth.normals, truth.E, truth.V } do
      for k = 1, 3 do row[#row + 1] = ("%.9g"):format(list[i][k]) end
    end
    row[#row + 1] = ("%d"):format(truth.N[i])
    file:write(table.concat(row, " "), "\n")
  end
  file:close()
  assert(os.rename(path .. ".part", path))
end

--- { points, normals, E, V, N, rounds } of a scene: from the folder, or by paths; "truth" adds paths to what the folder has.
local function truth_of(entry, scene, field)
  local path = ("%s/%s.%d.txt"):format(folder, slug(entry.name), seed)
  local area, count = 0, 0
  for _, g in ipairs(scene.geometry) do area, count = area + g.mesh.area, count + #g.mesh end
  local head = ("ylm rooms 1: %s, %d triangles, area %.4f, %s"):format(entry.name, count, area, entry.quantity)
  local truth = read_truth(path, head)
  if truth and not truth_alone then return truth end
  local began = os.time()
  if not truth then
    truth = { E = {}, V = {}, N = {}, rounds = 0 }
    truth.points, truth.normals = places.draw(scene, field(), PLACES, seed)
    for i = 1, #truth.points do truth.N[i] = 0 end
  end
  local total = add_paths(entry, scene, truth)
  write_truth(path, head, truth)
  print(("  round %d: %.0f million paths, %d s"):format(truth.rounds, total / 1e6, os.time() - began))
  return truth
end

--- The light of a fine field at the places, [n][3]: made where `make`, else that of the folder or nil.
local function fine_of(entry, scene, truth, make)
  local path, E = ("%s/%s.%d.fine"):format(folder, slug(entry.name), seed), {}
  if make then
    local lit = assert(assert(scene:links { rays = 256, seed = 2 }):radiosity(nil, { light_samples = 64, seed = 2 }))
    local field = assert(lit:field { rays = FINE, quantity = entry.quantity, tolerance = 0.01 })
    E = shaded(assert(ylm.light_field(FINE_LMAX, field, truth.points)), truth.normals)
    local file = assert(io.open(path, "w"))
    for _, e in ipairs(E) do file:write(("%.7g %.7g %.7g\n"):format(e[1], e[2], e[3])) end
    file:close()
    return E
  end
  local file = io.open(path)
  if not file then return nil end
  for line in file:lines() do
    local a, b, c = line:match "^(%S+) (%S+) (%S+)$"
    E[#E + 1] = { tonumber(a), tonumber(b), tonumber(c) }
  end
  file:close()
  return E
end

-- Judge --------------------------------------------------------------------------------------

local function quantile(list, q)
  table.sort(list)
  return list[math.max(1, math.ceil(q * #list))]
end

--- Means and noise of a truth; sealed: the rows of places in the sealed room.
local function measure(truth, entry)
  local n, noise, good = #truth.E, 0, 0
  truth.mean, truth.channel, truth.sealed = 0, { 0, 0, 0 }, {}
  truth.error = {}
  for i = 1, n do
    truth.mean = truth.mean + lum(truth.E[i]) / n
    for c = 1, 3 do
      truth.channel[c] = truth.channel[c] + truth.E[i][c] / n
      truth.error[i] = (truth.error[i] or 0) + LUMINANCE[c] * math.sqrt(truth.V[i][c])
    end
    if entry.sealed and places.within(entry.sealed, truth.points[i]) then truth.sealed[#truth.sealed + 1] = i end
  end
  for i = 1, n do
    local se = truth.error[i] / truth.mean
    noise = noise + se ^ 2 / n
    if se < WANTED then good = good + 1 / n end
  end
  truth.noise = math.sqrt(noise)
  truth.good = good
end

--- Errors of irradiance E [n][3] at the places, as a row of the table.
local function judge(truth, E)
  local n = #truth.E
  local square, apart, channels, sealed, brightest, fine = 0, {}, {}, 0, 0, {}
  for i = 1, n do
    local a, b = lum(E[i]), lum(truth.E[i])
    square = square + ((a - b) / truth.mean) ^ 2 / n
    apart[i] = math.abs(a - b) / math.max(b, truth.mean)
    if truth.fine then fine[i] = math.abs(a - lum(truth.fine[i])) / math.max(lum(truth.fine[i]), truth.mean) end
    channels[i] = 0
    for c = 1, 3 do
      local m = math.max(truth.E[i][c], truth.channel[c])
      channels[i] = math.max(channels[i], math.abs(E[i][c] - truth.E[i][c]) / m)
    end
  end
  for _, i in ipairs(truth.sealed) do
    local x = math.abs(lum(E[i])) / truth.mean
    sealed, brightest = sealed + x / #truth.sealed, math.max(brightest, x)
  end
  local row = ("%7.4f %7.4f | %7.4f %7.4f | %7.4f %7.4f"):format(math.sqrt(square),
    math.sqrt(math.max(0, square - truth.noise ^ 2)), quantile(apart, 0.9), quantile(apart, 0.99), quantile(channels, 0.9),
    quantile(channels, 0.99))
  if truth.fine then row = row .. (" | %7.4f %7.4f"):format(quantile(fine, 0.9), quantile(fine, 0.99)) end
  if #truth.sealed > 0 then row = row .. (" | %.6f %.6f"):format(sealed, brightest) end
  return row
end

--- Prints rows of answers that were kept.
local function judge_again(path, truth)
  local rows, kept = {}, assert(io.open(path), "nothing was kept: " .. path)
  for line in kept:lines() do
    local words, a, b, c = line:match "^# (.*)$", line:match "^(%S+) (%S+) (%S+)$"
    if words then rows[#rows + 1] = { words, {} }
    else table.insert(rows[#rows][2], { tonumber(a), tonumber(b), tonumber(c) }) end
  end
  kept:close()
  for _, row in ipairs(rows) do
    print(("  %s%s"):format(row[1], row[2][1] and " | " .. judge(truth, row[2]) or ""))
  end
end

-- Rows -----------------------------------------------------------------------------------------

--- All that is baked: { name, description, options of the bake }.
local function cases(scene)
  local box, list = places.box_of(scene), {}
  for _, h in ipairs { 0.35, 0.25, 0.18 } do
    local cells = {}
    for a = 1, 3 do cells[a] = math.max(1, math.floor((box[2][a] - box[1][a]) / h + 0.5)) end
    list[#list + 1] = { ("uniform %.2f"):format(h), ylm.uniform_grid { lmax = LMAX, cells = cells } }
  end
  for _, tolerance in ipairs { 0.1, 0.05 } do
    if SIDED then
      list[#list + 1] = { ("adaptive %g"):format(tolerance), ylm.adaptive_grid { lmax = LMAX, tolerance = tolerance } }
    else
      for depth = 6, 4, -1 do
        list[#list + 1] = { ("adaptive %g, depth %d"):format(tolerance, depth),
          ylm.adaptive_grid { lmax = LMAX, tolerance = tolerance, depth = depth }, { max_points = MOST },
          depth = depth, instead = depth < 6 and ("adaptive %g, depth %d"):format(tolerance, depth + 1) }
      end
    end
  end
  return list
end

--- Rows of a grid in few bytes, which are those of all channels: rounded to a step, and looked up as it is decoded.
local function in_few_bytes(name, grid, scene, truth, say)
  local path = os.tmpname() .. ".ylm"
  for _, step in ipairs { 0.02, 0.05 } do
    local _, report = assert(grid:save(path, { step = step }))
    local read = assert(ylm.load(path))
    local way = lookups(read, scene)[1]
    say(("%-32s %12d bytes in all, rounding %.3f"):format(name .. ", few bytes, step " .. step, report.bytes, report.rounding),
      way[2](truth.points, truth.normals))
    read:close()
  end
  os.remove(path)
end

local function now() return os.time() end

--- Rows of surface grids, judged by the elements' light or by paths. Places lie on their surfaces there.
local function by_surfaces(scene, entry, truth, links, say)
  local points = {}
  for i, p in ipairs(truth.points) do
    local n = truth.normals[i]
    points[i] = { p[1] - OFF * n[1], p[2] - OFF * n[2], p[3] - OFF * n[3] }
  end
  for _, tolerance in ipairs { 0.2, 0.1, 0.05 } do
    for _, by in ipairs { "field", "paths" } do
      local name, began = ("surfaces %g, %s"):format(tolerance, by), now()
      if is_wanted(name) then
        local light = assert(scene:surface_grid { tolerance = tolerance, quantity = entry.quantity, links = links, judge = by,
          seed = seed, progress = false })
        local s, E = light.stats, {}
        local seconds = now() - began
        local e = assert(light:irradiance(points, truth.normals))
        for i = 1, #points do E[i] = { e:get(i, 1), e:get(i, 2), e:get(i, 3) } end
        say(("%-22s %7d %9.0f %7.1f %9.0f %5s %6s %4d"):format(name, s.rectangles, s.corners, s.rays / 1e6,
          bytes(light, 3, ".surfaces"), tostring(s.met), ("%.3f"):format(s.error), seconds), E)
        light:close()
      end
    end
  end
end

local function run(entry)
  local scene = entry.make(ylm)
  local lit
  local function field()
    lit = lit or assert(assert(scene:links { rays = 256 }):radiosity(nil, { light_samples = 64 }))
    return assert(lit:field { rays = RAYS, quantity = entry.quantity })
  end
  print(("%s, seed %d, %s"):format(entry.name, seed, entry.quantity))
  local truth = truth_of(entry, scene, field)
  measure(truth, entry)
  print(("  %d places, mean %.4g; standard errors over it: rms %.4f, below %g at %.0f %%; sealed: %d places"):format(#truth.E,
    truth.mean, truth.noise, WANTED, 100 * truth.good, #truth.sealed))
  io.stdout:flush()
  truth.fine = fine_of(entry, scene, truth, fine_alone)
  if truth.fine then print(("  %-77s | %s"):format("the fine field", judge(truth, truth.fine))) end
  if truth_alone or fine_alone then return end
  print(("  %-22s %7s %9s %7s %9s %5s %6s %4s | %7s %7s | %7s %7s | %7s %7s%s%s"):format("grid", "points", "numbers", "rays/M",
    "B/channel", "met", "error", "s", "rms", "less se", "90 %", "99 %", "ch 90 %", "ch 99 %",
    truth.fine and " | fine 90    99 %" or "", entry.sealed and " | sealed   most" or ""))
  local path = label and ("%s/%s.%d.%s.rows"):format(folder, slug(entry.name), seed, label)
  if judged_again then return judge_again(assert(path, "YLM_BENCH_LABEL names what is judged again"), truth) end
  local kept = path and assert(io.open(path, "w"))
  --- Prints and keeps a row: words, and the irradiance E at the places, or nil.
  local function say(words, E)
    print(("  %s%s"):format(words, E and " | " .. judge(truth, E) or ""))
    io.stdout:flush()
    if not kept then return end
    kept:write("# ", words, "\n")
    for _, e in ipairs(E or {}) do kept:write(("%.7g %.7g %.7g\n"):format(e[1], e[2], e[3])) end
    kept:flush()
  end
  local itself = field()
  say(("%-22s %54s"):format("the field, " .. RAYS .. " rays", ""),
    shaded(assert(ylm.light_field(LMAX, itself, truth.points)), truth.normals))
  local failed, limited = {}, math.huge
  for _, case in ipairs(cases(scene)) do
    local name, description, options = case[1], case[2], case[3] or {}
    local wanted = is_wanted(name) and (not case.instead or failed[case.instead])
    if wanted and case.depth and case.depth >= limited then -- a larger tolerance was refused there
      failed[name] = true
    elseif wanted then
      local f, began = field(), now()
      options.geometry, options.occupied, options.progress = scene.geometry, "surfaces", false
      local ok, grid, message = pcall(ylm.bake, description, f, options)
      if ok and grid then
        local s, size = grid.stats, bytes(grid, grid.channels, ".ylm")
        local seconds = now() - began
        for _, way in ipairs(lookups(grid, scene, f)) do
          say(("%-22s %7d %9.0f %7.1f %9.0f %5s %6s %4d"):format(name .. (SIDED and ", " .. way[1] or ""), s.points,
            numbers(grid), f.stats.rays / 1e6, size or 0, s.met == nil and "" or tostring(s.met),
            s.error and ("%.3f"):format(s.error) or "", seconds), way[2](truth.points, truth.normals))
        end
        if is_wanted(name .. ", few bytes") and pcall(require, "ylm.grid.small") then -- libraries of before have none
          in_few_bytes(name, grid, scene, truth, say)
        end
        grid:close()
      else
        local why = tostring(ok and message or grid):gsub("^.-: ", "", 1):sub(1, 160)
        say(("%-22s %.1f M rays, %d s: refused: %s"):format(name, f.stats.rays / 1e6, now() - began, why))
        failed[name] = ok -- a limit, not a refusal: fewer levels may do
        limited = ok and case.depth or limited
      end
      f:close()
    end
  end
  if scene.surface_grid then by_surfaces(scene, entry, truth, lit.links, say) end
  if kept then kept:close() end
end

os.execute("mkdir -p '" .. folder:gsub("'", "'\\''") .. "'")
for number = first_seed, last_seed do
  seed = number
  for _, entry in ipairs(entries) do if entry.name:find(pattern) then run(entry) end end
end
