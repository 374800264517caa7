--- The promise of a room's light in grids and on surfaces: irradiance at 99 % of the surface by area, judged by paths.
--
-- A place whose error is d with a standard error s keeps X where d + z s < X m, m the larger of its irradiance and the mean, and
-- misses it where d - 2.6 s > X m. Its paths are doubled until then, and those of places that miss X where these are few.
-- Undecided places count as failed: noise can only make the verdict worse. Few paths may all miss what is bright, and then claim
-- little noise: s is at least that of the median place with as many paths, of those that are lit. A place that both call black
-- is so.
--
-- A place that misses X by nothing is looked at up to nine times, and has a chance of KEPT_FALSELY that one of them finds it
-- within X (z of `sure_to_keep`; a random walk at 256, 512 .. 65,536 steps). Failed places are therefore at least as many as
-- successes of a binomial distribution of that much less than 1 %, and the number that is allowed is by that: of 2,048 places 8.
--
-- A place is lost if it misses X, or would be undecided by all its paths without any error; few paths cannot say so of one
-- place, but of a tenth of all. Places whose error is not known yet have the spread of all places' errors, without noise: so many
-- of them are lost as would be undecided by all their paths. Once more places are lost than the promise allows, no more paths
-- change the verdict: rounds follow that cost no more than the first, for the error alone.

local array = require "ylm.array"
local core = require "ylm.c.core"
local progress = require "ylm.progress"
local probe = require "ylm.render.probe"
local sh = require "ylm.sh"
local tracing = require "ylm.trace"

local promise = {}

local FIRST, MOST = 256, 65536 -- paths of a place
local USUAL = 16384            -- paths of a place beyond which a round has at most DEAR of all paths before
local DEAR = 0.5
local SURE = 2.6               -- standard errors by which a place misses
local KEPT_FALSELY = 0.1       -- the chance of a place that misses by nothing to be found within
local PROMISED, DOUBT = 0.01, 0.01
local CHANCE = 0.01            -- of a place to be lost without being so: what is beyond SURE
local BELIEVED = 1024          -- paths of a place from which its noise is: that of fewer has long tails

--- Standard errors by which a place keeps the tolerance at so many paths: few of them know their noise badly.
local function sure_to_keep(paths) return paths < 1024 and 3 or paths < 2048 and 2.6 or 2 end
promise.sure_to_keep = sure_to_keep

local allowed_of = {} -- by the number of places

--- How many of n places may fail or be undecided: more would be likelier than DOUBT where PROMISED of the surface misses. -1: n
-- are too few.
function promise.allowed(n)
  n = math.min(n, 32768) -- of more places, those of so many: the chance of none would round to 0
  if allowed_of[n] then return allowed_of[n] end
  local share, sum, k = PROMISED * (1 - KEPT_FALSELY), 0, 0
  local term = (1 - share) ^ n
  while k <= n and sum + term <= DOUBT do
    sum, term, k = sum + term, term * (n - k) / (k + 1) * share / (1 - share), k + 1
  end
  allowed_of[n] = k - 1
  return k - 1
end

--- Irradiance of coefficients [n][3][count] on surfaces with normals, a list of lists.
local function irradiance(L, normals, lmax)
  local Y, out = sh.eval(lmax, normals), {}
  for i = 1, #L do
    local E = {}
    for c = 1, 3 do
      local sum, k = 0, 0
      for l = 0, lmax do
        local part = 0
        for _ = 1, 2 * l + 1 do
          k = k + 1
          part = part + Y:get(i, k) * L:get(i, c, k)
        end
        sum = sum + core.sh_cosine_factor(l) * part
      end
      E[c] = math.max(0, sum) -- as pictures clip it
    end
    out[i] = E
  end
  return out
end

--- The rows of an array [n][3] as lists.
function promise.lists(a)
  local rows = {}
  for i = 1, #a do rows[i] = { a:get(i, 1), a:get(i, 2), a:get(i, 3) } end
  return rows
end

--- The rows of an array that a list names, three numbers from the column `first` on.
local function rows_of(a, list, first)
  local rows = {}
  for i, row in ipairs(list) do rows[i] = { a:get(row, first), a:get(row, first + 1), a:get(row, first + 2) } end
  return rows
end

--- Adds paths of the places in `open` to their estimates e.mean, e.variance, e.paths. True, or nil, message, code.
local function add_paths(e, open, samples, seed, o)
  local points, normals = {}, {}
  for i, place in ipairs(open) do points[i], normals[i] = e.points[place], e.normals[place] end
  local E, variance, code = e.probe { points = array.array(points), normals = array.array(normals), samples = samples,
    reflections = e.reflections, seed = seed, threads = o.threads, progress = progress.resolve(o.progress) or false }
  if not E then return nil, variance, code end
  for i, place in ipairs(open) do
    local old = e.paths[place]
    local share = samples / (samples + old)
    for c = 1, 3 do
      local m, v = E:get(i, c), variance:get(i, c)
      local before = old > 0 and e.mean[place][c] or 0
      e.mean[place][c] = before + share * (m - before)
      e.variance[place][c] = (1 - share) ^ 2 * (old > 0 and e.variance[place][c] or 0) + share ^ 2 * v
    end
    e.paths[place] = old + samples
  end
  return true
end

--- The means of the paths' irradiance over all places, by channel.
local function means(e)
  local mean = { 0, 0, 0 }
  for _, m in ipairs(e.mean) do
    for c = 1, 3 do mean[c] = mean[c] + m[c] / #e.mean end
  end
  return mean
end

--- The median of a list of numbers, which is sorted then; 0 where it is empty.
local function median(list)
  table.sort(list)
  return list[math.ceil(#list / 2)] or 0
end

--- The variance of one path over m^2, in the median of the places that paths bring light to, by channel; and the noisiest
-- tenth of them, a number, where all their paths would leave it undecided.
local function spreads(e, mean, tolerance)
  local out, hopeless = {}, 0
  for c = 1, 3 do
    local all = {}
    for i = 1, #e.mean do
      local m = math.max(math.abs(e.mean[i][c]), mean[c])
      if e.variance[i][c] > 0 then all[#all + 1] = e.variance[i][c] * e.paths[i] / (m * m) end
    end
    out[c] = median(all)
    local tenth = math.floor(#all / 10)
    if sure_to_keep(MOST) * math.sqrt((all[#all - tenth] or 0) / MOST) > tolerance then hopeless = math.max(hopeless, tenth) end
  end
  return out, hopeless
end

--- The standard deviation of errors over m without noise, green, where paths bring light: by medians, which few large errors do
-- not move.
local function spread_of_errors(e, mean)
  local squares, variances = {}, {}
  for i = 1, #e.mean do
    local m = math.max(math.abs(e.mean[i][2]), mean[2])
    if m > 0 and e.variance[i][2] > 0 then
      squares[#squares + 1], variances[#variances + 1] = ((e.told[i][2] - e.mean[i][2]) / m) ^ 2, e.variance[i][2] / (m * m)
    end
  end
  return math.sqrt(math.max(0, median(squares) / 0.4549 - median(variances))) -- the median of a normal error's square
end

--- The chance that a normal error of this standard deviation is beyond x (Abramowitz & Stegun 7.1.27, to 5e-4).
local function chance_beyond(x, deviation)
  if x <= 0 then return 1 end
  local t = x / (math.sqrt(2) * math.max(deviation, 1e-30))
  return (1 + 0.278393 * t + 0.230389 * t ^ 2 + 0.000972 * t ^ 3 + 0.078108 * t ^ 4) ^ -4
end

--- Do grid and paths say that no light comes to place i?
local function is_black(e, i)
  for c = 1, 3 do
    if e.told[i][c] ~= 0 or e.mean[i][c] ~= 0 then return false end
  end
  return true
end

--- The errors of place i that are sure at least, and at most, and the noise that all its paths would leave; over m, in the worst
-- channel.
local function bounds_of(e, i, mean, spread)
  local least, most, rest, left = 0, 0, 0, sure_to_keep(MOST) * math.sqrt(e.paths[i] / MOST)
  local keep = sure_to_keep(e.paths[i])
  if is_black(e, i) then return least, most, rest end
  for c = 1, 3 do
    local m = math.max(math.abs(e.mean[i][c]), mean[c])
    local variance = math.max(e.variance[i][c], spread[c] * m * m / e.paths[i])
    local d, noise = math.abs(e.told[i][c] - e.mean[i][c]), math.sqrt(variance)
    if m > 0 then
      least, most = math.max(least, (d - SURE * noise) / m), math.max(most, (d + keep * noise) / m)
      rest = math.max(rest, left * noise / m)
    end
  end
  return least, most, rest
end

--- The value that all but the allowed number of places keep, and `more` of them; infinite where they are too few to say.
local function quantile(list, more)
  table.sort(list, function(a, b) return a > b end)
  local allowed = promise.allowed(#list)
  return allowed >= 0 and list[allowed + 1 + more] or math.huge
end

--- The verdict of the estimates: places by verdict; the error that 99 % of the surface keeps, and the least that paths do not
-- refute; the root mean square.
local function rule(e, tolerance)
  local mean, square, n = means(e), 0, #e.mean
  local spread, hopeless = spreads(e, mean, tolerance)
  local least, most, said = {}, {}, { missed = {}, open = {}, lost = 0, largest = 0 }
  local deviation = spread_of_errors(e, mean)
  for i = 1, n do
    local rest
    least[i], most[i], rest = bounds_of(e, i, mean, spread)
    local misses = least[i] > tolerance
    if misses then table.insert(said.missed, i)
    elseif most[i] > tolerance then table.insert(said.open, i) end
    if e.paths[i] >= BELIEVED and (misses or most[i] > tolerance) then
      said.lost = said.lost + (misses and 1 or chance_beyond(tolerance - rest, deviation))
    end
    local d = e.told[i][2] - e.mean[i][2]
    said.largest, square = math.max(said.largest, most[i]), square + d * d - e.variance[i][2]
  end
  said.lost = math.max(said.lost, hopeless)
  said.failed, said.error, said.least = #said.missed, quantile(most, 0), quantile(least, math.floor(CHANCE * n))
  said.rms = mean[2] > 0 and math.sqrt(math.max(0, square / n)) / mean[2] or 0
  return said
end

--- The places that take `samples` more paths each: those that are undecided, and where they are few those that miss. `had`: all
-- paths so far.
local function next_of(said, n, samples, had)
  local allowed, list = promise.allowed(n), {}
  if samples >= MOST or not said.open[1] and said.failed <= allowed then return {} end
  for _, place in ipairs(said.open) do list[#list + 1] = place end
  for _, place in ipairs(said.failed <= math.max(0, allowed) + CHANCE * n and said.missed or {}) do list[#list + 1] = place end
  table.sort(list)
  said.settled = said.lost > allowed + CHANCE * n
  if said.settled and samples * #list > FIRST * n or samples >= USUAL and samples * #list > DEAR * had then return {} end
  return list
end

--- scene:probe with guides that its first call learns for all of them; or nil, message, code.
local function of_scene(s)
  local t, message, code = tracing.trace("probe", s)
  if not t then return nil, message, code end
  local guides = t.lib.path_guides() -- nil without memory: each estimate then has its own
  return function(o) return probe.kept(s, o, guides) end
end

--- Compares irradiance `told` at places, lists of { x, y, z } and { r, g, b }, with that of paths in scene `s`, of `quantity`.
-- Paths are those of o.probe, or of scene:probe. The verdict: failed, undecided, error, least, largest, rms, paths, seconds; or
-- nil, message, code.
function promise.compare(s, points, normals, told, tolerance, quantity, o)
  local start, last, all = core.seconds(), o.bounces or "all", {}
  local e = { points = points, normals = normals, told = told, mean = {}, variance = {}, paths = {},
    reflections = quantity == "indirect" and { 1, last } or quantity == "direct" and { 0, 0 } or { 0, last } }
  local message, code
  e.probe = o.probe
  if not e.probe then e.probe, message, code = of_scene(s) end
  if not e.probe then return nil, message, code end
  for i = 1, #points do all[i], e.mean[i], e.variance[i], e.paths[i] = i, { 0, 0, 0 }, { 0, 0, 0 }, 0 end
  local samples, seed, had, list = FIRST, 1, 0, all
  local said = { failed = 0, open = {}, error = 0, least = 0, largest = 0, rms = 0 }
  while list[1] do
    local ok
    ok, message, code = add_paths(e, list, samples, 1000003 * seed + o.seed, o)
    if not ok then return nil, message, code end
    said, seed, had = rule(e, tolerance), seed + 1, had + samples * #list
    samples = seed > 2 and samples * 2 or samples
    list = next_of(said, #points, samples, had)
  end
  said.undecided, said.paths, said.seconds = #said.open, had, core.seconds() - start
  return said
end

--- Judges a grid of the light of scene `s` by paths, where points with normals have judged it by its field. The verdict is that
-- of the grid's stats. True, or nil, message, code.
function promise.judge(s, g, o)
  local rows = g.sides and g.measure == "irradiance" and core.grid_judges(g)
  if not rows then return true end
  local before, places = core.grid_stats(g), {}
  for i = 1, rows.shape[1] do places[i] = i end
  local points, normals = rows_of(rows, places, 1), rows_of(rows, places, 4)
  local L, message, code = g:sample(array.array(points), { normals = array.array(normals), scene = s, threads = o.threads })
  if not L then return nil, message, code end
  local said
  said, message, code = promise.compare(s, points, normals, irradiance(L, array.array(normals), g.lmax), g.tolerance,
    g.quantity, o)
  if not said then return nil, message, code end
  core.grid_verdict(g, #places, said.failed + said.undecided, said.error, said.largest)
  core.own(g).paths = { field_met = before.met, field_error = before.error, undecided = said.undecided, rms = said.rms,
    least = said.least, paths = said.paths, seconds = said.seconds }
  return true
end

return promise
