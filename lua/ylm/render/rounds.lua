--- Pictures by rays with a noise that is wanted: a pilot, then rays where the noise is.
--
-- The pilot has two estimates of direct light, and two of light along links. Half of their difference, over the pixels around
-- one, is its noise. Counts of rays go as the noise of a pixel over the root of what a ray costs (Neyman 1934), and are as small
-- as leaves the noise that is wanted. Rays behind the pilot, in two halves, are added to its light with a weight that tiles of
-- 32 x 32 pixels share: a weight that knew the light of a point would make means too small. Tiles with little noise have none.
-- The halves say which noise is left.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local denoise = require "ylm.render.denoise"
local noises = require "ylm.render.noise"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local steady = require "ylm.render.steady"
local tracing = require "ylm.trace"
local warning = require "ylm.warning"

local rounds = {}

local SET = 32                              -- links of a set
local PILOT = { rays = 8, sets = 2, links = SET } -- of a half; of both; of a set
local FILTERED = { rays = 6, sets = 2, links = 12 } -- where noise is filtered
local LARGE, MANY = { rays = 4, sets = 2, links = 20 }, 2 ^ 19 -- of pictures of so many pixels, of which a filter takes more
local MOST = { rays = 8192, sets = 512 }    -- of a half; of both
local LEAST = { rays = 2, sets = 2 }
local STEP = 1000003                        -- from one seed to the next
local AIM, SLACK = 0.95, noises.SLACK -- times the noise that is wanted: at which counts aim, and up to which it is reached
local WIDE, STEPS = 40, 40                   -- factors of counts are looked for from 2^-WIDE to 2^WIDE, by halves
local CAP, FEW = 4, 2e7 -- times the pilot's rays, and rays, of which the larger is the most where nobody says a noise

local EDGE = 60 -- the most rays of a half behind the pilot at edges of shadows
local GUIDED = 16 -- shadow rays of a point by which the guides' pilot is sized; of a large picture half of them

rounds.fields = {
  { "noise", "number", min = 0.001, max = 1, optional = true,
    about = "by rays: the noise that the picture may have, root mean square over its pixels, each relative to the mean of 9 x 9 "
      .. "pixels around it: a pilot chooses counts of shadow rays and links pixel by pixel, and light_samples and rays are left "
      .. "out. report.noise and the layer noise say what was reached. A picture that is cancelled behind its pilot is what "
      .. "the pilot made, and report.ended is cancelled. Of bounces by links" },
  { "denoise", "choice", of = { "auto", "none", "oidn" }, optional = true,
    about = "by rays: 'auto', where noise is above `noise`, or 0.03, light of matte surfaces and wide lobes is fitted to that of "
      .. "points around, as far as two halves of the rays find it alike; direct light and light that bounces apart, without "
      .. "albedo. Where no counts are given, more rays follow where noise is left. The layer raw is without a filter; "
      .. "report.denoise says what rays at random pixels find changed. 'oidn': the finished picture is filtered by Intel's Open "
      .. "Image Denoise, which has to be installed; report.noise is that of the layer raw. Default: 'auto' with noise, else "
      .. "'none'" },
  { "time_limit", "number", above = 0, optional = true, unit = "s", shelf = "experiments",
    about = "with noise, or by paths: ends after about so long, which makes results depend on it; with noise a pilot and 64 "
      .. "links a shading point are the least" },
}

--- Is a picture by these options made of two halves of rays?
function rounds.wants(o) return o.noise ~= nil or o.denoise == "auto" or o.denoise == "oidn" end

--- Raises where options do not go with a noise that is wanted.
local function check_noise(name, o, given)
  if o.time_limit and not o.noise then
    return check.fail("%s: by rays, time_limit is of pictures with a noise that is wanted: give noise too", name)
  end
  for _, other in ipairs { "tolerance", "variance", "light_samples", "rays" } do
    if given[other] ~= nil and given[other] ~= false and (o.noise or other == "tolerance" or other == "variance") then
      return check.fail(o.noise and "%s: noise chooses counts of rays, and %s is given: leave one out"
        or "%s: denoise is of pictures whose noise is not asked for, and %s is given: leave one out", name, other)
    end
  end
end

--- Raises where no noise can be chosen or filtered for such a picture; settles how rays are counted.
function rounds.check(name, o, given)
  if o.noise and not o.denoise then o.denoise = "auto" end
  if o.time_limit and not o.noise then return check_noise(name, o, given) end
  if not rounds.wants(o) then return end
  check_noise(name, o, given)
  local word = o.noise and "noise" or "denoise"
  if o.shading == "vertices" then
    return check.fail("%s: %s is of what camera rays hit: shading = 'pixel'", name, word)
  end
  if o.reflected and o.reflected.record.name == "virtual" then
    return check.fail("%s: %s is of light that bounces along links or from a grid: leave bounced out, or give what scene:links, "
      .. "t:radiosity, scene:surface_grid or scene:bake returned", name, word)
  end
  o.by_hand = not o.noise and (given.light_samples or given.rays or given.samples) ~= nil
  o.halves = true -- sets of links are found for each half; none is kept
end

--- Whether a filter that is not ylm's own is there, before any ray is traced: true; or nil, message, code.
function rounds.ready(name, o)
  if o.denoise ~= "oidn" then return true end
  local lib, message, code = tracing.library()
  if not lib then return nil, message, code end
  return check.result(name, lib.shade_oidn())
end

--- Arrays of zeros for points and pixels of a view.
local function room(p, o)
  local n, size = p.stats.points, o.size
  local function points(...) return assert(array.zeros({ n, ... }, "float")) end
  local function pixels(channels) return assert(array.zeros({ size[2], size[1], channels }, "float")) end
  return points, pixels
end

--- Fills the picture of a viewer with the light so far, of both halves.
local function show(x)
  if not x.casting.into then return end
  local all = (x.direct[1] + (x.direct[2] or x.direct[1])) / 2
  if x.links then all = all + (x.links[1] + x.links[2]) / 2 end
  if x.steady then all = all + x.steady end
  x.casting.into[{ { 1, x.p.stats.points } }] = all
end

--- Direct light of points by `rays` of them, and the count of shadow rays; or nil, message, code. `into`: where the light goes.
local function cast(x, rays, number, told, into)
  local c = x.casting
  local found, count, code = check.result(x.name, x.p.lib.shade_raycast(x.p.view, { light_samples = x.pilot.rays, rays = rays,
    shadows = c.shadows, spread = true, seed = c.seed + STEP * number, threads = c.threads, progress = told, lit = c.lit,
    guide = c.guide, into = into }))
  if found then x.report.rays.shadow = (x.report.rays.shadow or 0) + count end
  return found, count, code
end

--- Two estimates of direct light and two along links, in `x.direct`, `x.links`; rays of a half and sets are numbers of points.
-- True, or nil, message, code.
local function estimate(x, rays, sets, round)
  local c = x.casting
  x.direct, x.links = {}, nil
  for half = 1, 2 do
    local found, count, code = cast(x, rays, 2 * round + half, c.progress, round == 0 and half == 1 and c.into or nil)
    if not found then return nil, count, code end
    x.direct[half] = rawequal(found, c.into) and found:clone() or found
    if round == 0 then show(x) end
  end
  local b = steady.links(x.o)
  if not b then return true end
  x.links = { x.points(3), x.points(3) }
  local count, message, code = check.result(x.name, x.p.lib.shade_gather_sets(x.p.view, { transfer = b.lit.links, lit = b.lit,
    targets = x.targets, links = x.pilot.links, sets = sets, all = x.p.options.gloss == "matte", first = x.links[1],
    second = x.links[2], seed = c.seed + STEP * (round + 7), threads = c.threads, progress = c.progress }))
  if not count then return nil, message, code end
  x.sets = (x.sets or 0) + count
  show(x)
  return true
end

--- The picture of the values of points.
local function resolved(x, values)
  return assert(check.result(x.name, x.p.lib.shade_resolve(x.p.view, values, nil, false, x.casting.threads, nil)))
end

--- The noise of direct light and of links around each pixel, relative to all light there.
local function noise_of(x)
  local d, l = { resolved(x, x.direct[1]), resolved(x, x.direct[2]) }, nil
  local all = (d[1] + d[2]) / 2
  if x.links then
    l = { resolved(x, x.links[1]), resolved(x, x.links[2]) }
    all = all + (l[1] + l[2]) / 2
  end
  if x.steady then all = all + resolved(x, x.steady) end
  local function around(pair)
    return check.result(x.name, x.p.lib.shade_noise_around(x.p.view, pair[1], pair[2], all, x.casting.threads, x.pixels(1)))
  end
  return around(d), l and around(l) or x.pixels(1)
end

--- Noise that is left, of all light: [h][w][1] in x.left, and its root mean square.
local function look_at(x)
  x.noise = { noise_of(x) }
  local d, l = x.noise[1], x.noise[2]
  x.left = ((d * d + l * l) ^ 0.5)
  x.lit = x.left:not_equal(0):sum()
  return x.lit > 0 and math.sqrt((x.left * x.left):sum() / x.lit) or 0
end

--- Plans direct light (kind 1) or links (2) behind the pilot, by a factor of counts: the squared noise of all pixels, and rays
-- of a half or sets of a point; these and the pilot's weights go into arrays that are given.
local function plan(x, kind, factor, rays, weight)
  local name = kind == 1 and "rays" or "sets"
  local square, mean = check.result(x.name, x.p.lib.shade_plan(x.p.view, { noise = x.noise[kind],
    factor = factor / math.sqrt(x.cost[kind]), unit = x.pilot[name], least = LEAST[name], most = MOST[name], rays = rays,
    weight = weight }))
  return assert(square, mean), mean
end

--- Noise and cost of counts that are with the pilot's `factor` times the noise of a pixel over the root of the cost.
local function weigh(x, factor)
  if x.lit == 0 then return 0, 0 end
  local square, rays = plan(x, 1, factor)
  local cost, more, sets = rays / x.pilot.rays * x.cost[1], 0, 0
  if x.links then more, sets = plan(x, 2, factor) end
  return math.sqrt((square + more) / x.lit), cost + sets / x.pilot.sets * x.cost[2]
end

--- The factor of counts: the smallest that leaves the noise that is wanted, or whose cost is at most `budget`.
local function choose(x, budget)
  local low, high = -WIDE, WIDE
  for _ = 1, STEPS do
    local middle = (low + high) / 2
    local noise, cost = weigh(x, 2 ^ middle)
    if noise > AIM * x.wanted and cost < budget then low = middle else high = middle end
  end
  return 2 ^ high
end

--- The mean over shading points, 0 where there are none.
local function mean_of(x, a) return x.p.stats.points > 0 and a:mean() or 0 end

--- Shadow rays of a point, on average.
local function samples_of(x) return 2 * (mean_of(x, x.rays) + (x.edges or 0)) end

--- The report of a picture that has not ended.
local function so_far(x, reached)
  return { noise = reached, noise_before = x.raw and x.before, light_samples = samples_of(x) }
end

--- The cause that kept a picture from its noise, and the advice that a line gives.
local function cause_of(x, reached, seconds)
  if x.unseen then
    return "filter", ("the filter errs by more than its halves show: noise = %.3g or more pixels leave less"):format(
      x.wanted ^ 2 / reached)
  end
  if x.capped then
    return "most rays", ("noise = %g asks for as many rays as it takes, about %.0f s"):format(x.wanted,
      math.ceil(seconds * (reached / x.wanted) ^ 2))
  end
  if x.timed then
    return "time_limit", ("time_limit = %.0f would reach it"):format(math.ceil(seconds * (reached / x.wanted) ^ 2))
  end
  if x.most then return "most rays", "counts of rays are at their most; more camera rays leave less" end
  return "pilot", ("the pilot met less noise than there is: noise = %.3g asks for more rays"):format(x.wanted ^ 2 / reached)
end

--- One line about what was reached.
local function say(x, reached, seconds)
  local report = x.report
  report.noise, report.ended = reached, x.cancelled and "cancelled" or x.o.by_hand and "samples" or "noise"
  local left_to_oidn = x.o.denoise == "oidn" and not x.o.noise
  if x.cancelled or x.o.by_hand or left_to_oidn or reached <= SLACK * x.wanted then return end
  local ended, advice = cause_of(x, reached, seconds)
  report.ended = ended
  report.warnings[#report.warnings + 1] = warning.say(x.p.scene, "noise", "scene %q: noise is %.1f %% of the light around a "
    .. "pixel, %.1f %% was wanted: %s", x.p.scene.name or "?", 100 * reached, 100 * x.wanted, advice)
end

--- Noise with a part that halves do not see, in the map of it too.
local function add(x, reached, unseen)
  local all = math.sqrt(reached ^ 2 + unseen ^ 2)
  if reached > 0 then x.left = x.left * (all / reached) end
  x.unseen = unseen > 0 and reached <= SLACK * x.wanted
  return all
end

--- The picture as it is, to be taken again.
local function keep(x)
  local kept = {}
  for _, key in ipairs { "direct", "links", "noise", "raw", "before", "left", "lit", "rays", "own" } do
    kept[key] = x[key] or false
  end
  return kept
end

local function restore(x, kept) for key, value in pairs(kept) do x[key] = value or nil end end

local function copies(pair) return { pair[1]:clone(), pair[2]:clone() } end

--- More shadow rays at edges of shadows, where a filter finds few points alike: those of a half where the other one says so, so
-- that means stay as they are. They take about a second. True, or nil, message, code.
local function sharpen(x)
  local c, direct = x.casting, {}
  for half = 1, 2 do
    local other, rays = 3 - half, x.points(1)
    local all = x.direct[other]
    if x.links then all = all + x.links[other] end
    if x.steady then all = all + x.steady end
    local mean = assert(check.result(x.name, x.p.lib.shade_edge_rays(x.p.view, x.direct[other], all, x.pilot.rays, EDGE,
      c.threads, rays)))
    direct[half] = x.direct[half]
    if mean > 0 then
      local found, count, code = cast(x, rays, 10 + half, x.interrupts)
      if not found then return nil, count, code end
      direct[half] = direct[half] + (found - direct[half]) * (rays / (rays + x.pilot.rays))
      x.edges = (x.edges or 0) + mean / 2
    end
  end
  x.direct = direct
  return true
end

--- Noise that is left behind a round, after a filter where it is above the one that is wanted and the filter leaves less; or nil,
-- message, code.
local function settle(x, round)
  local reached = look_at(x)
  local filtered = x.o.denoise == "auto" and reached > x.wanted
  x.before, x.raw = reached, nil
  if filtered and round == 0 and not x.o.by_hand then
    local ok, why, kind = sharpen(x)
    if not ok then return nil, why, kind end
  end
  if round == 0 then x.unfiltered = { direct = x.direct, links = x.links } end
  if not filtered then return reached end
  local kept = keep(x)
  x.direct, x.links = copies(x.direct), x.links and copies(x.links)
  local raw, message, code = denoise.filter(x)
  if not raw then return nil, message, code end
  x.raw = raw
  local after = look_at(x)
  if after >= reached then restore(x, kept) end
  show(x)
  return math.min(after, reached)
end

local function is_large(p) return p.options.size[1] * p.options.size[2] >= MANY end

--- Shadow rays of a point by which the pilot of a picture's guide is sized.
function rounds.guided(p) return is_large(p) and GUIDED / 2 or GUIDED end

--- Shadow rays of a half, links of a set, and sets, before any noise is known.
local function pilot_of(p, o)
  if not o.by_hand then return o.denoise == "none" and PILOT or is_large(p) and LARGE or FILTERED end
  local links = o.rays or 64 * options.multiple(p.options)
  local set = math.min(SET, math.max(4, 4 * math.floor(links / 8)))
  return { rays = math.max(1, math.floor(o.light_samples / 2 + 0.5)), links = set,
    sets = math.max(2, math.floor(links / set + 0.5)) }
end

--- The cost of another round, at most: what time or a cap leaves of it. Sets x.timed, x.capped.
local function budget_of(x, seconds, start)
  local left = x.o.time_limit and math.max(0, x.o.time_limit - (core.seconds() - start) - x.report.seconds.primary)
  local pilot = x.cost[1] + (x.links and x.cost[2] or 0)
  x.timed, x.capped = left ~= nil, x.o.noise == nil
  if left then return pilot * left / math.max(seconds, 1e-3) end
  return x.capped and math.max(CAP * pilot, FEW / math.max(x.p.stats.points, 1)) or math.huge
end

--- Says which counts were chosen, and how long they take.
local function announce(x, factor, reached, seconds)
  local _, cost = weigh(x, factor)
  local part = cost / (x.cost[1] + (x.links and x.cost[2] or 0))
  progress.say(x.casting.progress, part * seconds,
    "noise is %.1f %%, %.1f %% wanted: %.0f more shadow rays%s a point take about %s", 100 * reached,
    100 * x.wanted, 2 * mean_of(x, x.rays), x.links and (" and %.0f links"):format(x.pilot.links * mean_of(x, x.own)) or "",
    progress.clock(part * seconds))
end

--- Adds the light of the pilot to that of rays behind it, with weights [points][1] of direct light and of links.
local function add_pilot(x, pilot, weights)
  for half = 1, 2 do
    local function mixed(a, b, w) return b + (a - b) * w end
    x.direct[half] = mixed(pilot.direct[half], x.direct[half], weights[1])
    if x.links then x.links[half] = mixed(pilot.links[half], x.links[half], weights[2]) end
  end
end

--- Rays where noise is, added to those of the pilot. True, or nil, message, code.
local function another(x, reached, seconds, start)
  local factor = choose(x, budget_of(x, seconds, start))
  local short = weigh(x, factor) > x.wanted
  x.timed, x.capped = x.timed and short, x.capped and short
  x.most = weigh(x, 2 ^ WIDE) > x.wanted
  local pilot, weights = x.unfiltered, { x.points(1), x.points(1) }
  x.unfiltered, x.rays, x.own = nil, x.points(), x.points()
  plan(x, 1, factor, x.rays, weights[1])
  if x.links then plan(x, 2, factor, x.own, weights[2]) end
  announce(x, factor, reached, seconds)
  local ok, message, code = estimate(x, x.rays, x.own, 1)
  if not ok then return nil, message, code end
  add_pilot(x, pilot, weights)
  x.rays = x.rays + x.pilot.rays
  return true
end

--- The noise that another round leaves; or nil, message, code. An interrupt of the command-line tool, which is raised, cancels.
local function try(x, reached, seconds, start)
  local function round()
    local ok, message, code = another(x, reached, seconds, start)
    if not ok then return nil, message, code end
    return settle(x, 1)
  end
  local fine, better, message, code = pcall(round)
  if fine then return better, message, code end
  if not core.process_interrupted() or not tostring(better):find("interrupted!", 1, true) then error(better, 0) end
  return nil, "interrupted", "ECANCELLED"
end

--- As `try`, or where it is cancelled the picture is the one before.
local function refine(x, reached, seconds, start)
  local kept = keep(x)
  local better, message, code = try(x, reached, seconds, start)
  if better or code ~= "ECANCELLED" then return better, message, code end
  restore(x, kept)
  x.cancelled, x.casting.progress = true, nil -- an interrupt stays one
  show(x)
  return reached
end

--- Is the pilot the picture? Its counts are even, and of light without a filter they are chosen by noise.
local function is_enough(x, reached)
  if x.o.by_hand or x.o.denoise == "oidn" and not x.o.noise then return true end
  return x.o.denoise == "auto" and reached <= SLACK * x.wanted
end

--- Elements that send light to the points of a picture, in x.targets, where links are to be aimed. True, or nil, message, code.
local function aim(x)
  local b, c = steady.links(x.o), x.casting
  if not b or not x.o.guides then return true end
  local targets, stats, code = check.result(x.name, x.p.lib.shade_targets(x.p.view, b.lit.links, b.lit, c.seed + STEP * 5,
    c.threads, c.progress))
  if targets == nil then return nil, stats, code end
  if not targets then return true end
  x.targets = targets
  x.report.targets, x.report.rays.targets = stats.groups, stats.rays
  x.report.seconds.targets = stats.seconds
  return true
end

--- Direct light of the points of p; light that bounces is left in o.reflected.gathered. Or nil, message, code. now(report) shows
-- the picture so far, where somebody watches.
function rounds.radiance(name, p, o, report, casting, now)
  local start = core.seconds()
  local x = { name = name, p = p, o = o, report = report, casting = casting, wanted = o.noise or noises.WANTED }
  x.pilot, x.interrupts = pilot_of(p, o), o.live and o.live.interrupts and casting.progress
  x.points, x.pixels = room(p, o)
  x.rays, x.own = x.points() + x.pilot.rays, x.points() + x.pilot.sets
  local reached, ok, message, code
  x.steady, message, code = steady.light(name, p, o)
  if x.steady == nil then return nil, message, code end
  ok, message, code = aim(x)
  if ok then ok, message, code = estimate(x, x.rays, x.own, 0) end
  if ok then reached, message, code = settle(x, 0) end
  if not reached then return nil, message, code end
  local seconds = core.seconds() - start
  x.cost = { 2 * x.pilot.rays, x.pilot.links * x.pilot.sets }
  if not is_enough(x, reached) then
    if now then now(so_far(x, reached)) end
    reached, message, code = refine(x, reached, seconds, start)
    if not reached then return nil, message, code end
  end
  local took = core.seconds() - start
  report.light_samples = samples_of(x)
  report.noise_before = x.raw and x.before
  if x.links then
    o.reflected.gathered = ((x.links[1] + x.links[2]) / 2)
    report.rays.sets = x.sets
  elseif x.steady then o.reflected.gathered = x.steady end
  o.noise_left, o.raw = x.left, x.raw
  local direct = ((x.direct[1] + x.direct[2]) / 2)
  local all = o.reflected and direct + o.reflected.gathered or direct
  if x.links then
    report.elements_noise, message, code = denoise.of_elements(x, all)
    if report.elements_noise == nil then return nil, message, code end
    report.elements_noise = report.elements_noise or nil
  end
  if x.raw then
    local unseen
    unseen, message, code = denoise.judge(x, all)
    if not unseen then return nil, message, code end
    reached = add(x, reached, unseen)
    o.noise_left = x.left
  end
  say(x, reached, took)
  return direct, core.seconds() - start
end

--- Adds the layers noise and raw.
function rounds.report(p, o, report, image)
  image:add("noise", 1)
  p.lib.path_copy(o.noise_left, image:layer "noise")
  image.metadata.noise = ("%.4g"):format(report.noise)
  if not o.raw then return end
  image.metadata.denoise, image.metadata.noise_before = "auto", ("%.4g"):format(report.noise_before)
  image:add("raw", 3)
  assert(check.result("render", p.lib.shade_compose(p.view, o.raw, p.scene.background or { 0, 0, 0 }, o.threads or 0,
    image:layer "raw")))
end

return rounds
