--- One knob: a picture with a tolerance chooses elements, links, shadow rays and camera rays, and judges itself.
--
-- A cheap picture comes first. Some hundred pixels, half of them drawn by its light, are rendered with ever finer means. Noise
-- is the difference of two estimates with random numbers of their own, the error of elements that to groups of four of them.
-- The error of camera rays is that from 256 of them, each with its own shading point, in direct light and bounced. The whole
-- picture is made once, with the means found. Other pixels are drawn by its light, and by its distance from the cheap one.
-- Paths through camera rays of their own say how far these very pixels are off. The picture's error is that distance by the
-- inverse probabilities of the pixels, the noise of the paths taken off.

local check = require "ylm.check"
local core = require "ylm.c.core"
local array = require "ylm.array"
local box = require "ylm.box"
local progress = require "ylm.progress"
local transfers = require "ylm.transfer.object"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local knob = {}

local PIXELS, JUDGED = 512, { 512, 2048 } -- by which means are chosen, and which are judged; more where so few leave doubt
-- The cheap picture.
local CHEAP = { samples = 4, share = 1.5, light_samples = 4, links = 8 }
-- Parts of the tolerance that each cause may have; their squares add up to 0.7.
local SHARE = { pixels = 0.45, direct = 0.35, links = 0.35, elements = 0.5 }
-- Where it begins (spacing: of the diagonal), and ends.
local FIRST = { light_samples = 16, links = 64, spacing = 1 / 32 }
local MOST = { light_samples = 1024, links = 1024, elements = core.limits.transfer_elements, bytes = 2 ^ 31 }
local POINT = 110 -- bytes of a shading point without its links
-- Camera rays of a pixel, and which of them are shaded as one, the cheapest first; the last judges the others.
local RAYS = { { 16, 1.5 }, { 64, 1.5 }, { 16, 0 }, { 32, 0 }, { 64, 0 }, { 128, 0 }, { 256, 0 } }
local ELEMENT = { links = 128, least = 32, light_samples = 16 } -- `least` of the finest, of which a pixel sees more
-- The judge's paths, two from each of their camera rays. `pilot` of a pixel tell its noise, by which an estimate has `samples` of
-- it, or up to `parts` times as many. The verdict is by `first` to `most` estimates; if `anew` do not suffice, all are
-- forgotten but the noise that they tell, and estimates have `larger` times as many paths.
local ROUND = { pilot = 64, samples = 16, parts = 16, first = 4, anew = 16, larger = 4, most = 512 }
local KNOWN = 0.1 -- of the squared tolerance: the judge is precise enough
local MATTERS = 0.5 -- the least part of paths' noise in the doubt that more of them may end
-- The bound on pixels that were not drawn is that of Maurer and Pontil 2009, Theorem 4, at a confidence of 95 %: of `TERM`
-- standard errors, and RANGE times the largest part of the sum that a pixel has, of those that may be missed. Noise makes the
-- largest of many larger: NOISY standard errors of a part are taken off.
local TERM, RANGE, NOISY = math.sqrt(2 * math.log(2 / 0.05)), 7 / 3 * math.log(2 / 0.05), 2

knob.fields = {
  { "tolerance", "number", min = 0.001, max = 1, optional = true,
    about = "of the picture, the root mean square error relative to its mean, edges included: chooses elements, rays, "
      .. "light_samples and samples where they are not given, judges itself by paths, and says whether it is met (report.met, "
      .. ".error)" },
}

-- Trials ----------------------------------------------------------------------------------

--- A function whose failures, nil, message, code, end the trial: it raises them as a table, which knob.choose catches.
local function need(...)
  local first, message, code = ...
  if first == nil or first == false then error({ trial = true, message, code }, 0) end
  return ...
end

--- The prepared view of `pixels`, of the chosen pixels, or of all, with its points a pixel.
local function look(x, samples, share, seed, pixels)
  local o = x.o
  local view = need(views.prepare(x.name, x.scene, { size = o.size, samples = samples, seed = seed or o.seed, share = share,
    shading = "pixel", visibility = "rays", lmax = 0, threads = o.threads, progress = o.progress, pixels = pixels or x.pixels }))
  local p = views.open(x.name, view)
  return { p = p, view = view, density = p.stats.points / (x.pixels and #x.pixels or o.size[1] * o.size[2]) }
end

--- Radiance of direct light at the points of a view v, by random numbers of seed + k.
local function direct(x, v, rays, k)
  return (need(check.result(x.name, x.lib.shade_raycast(v.view, { light_samples = rays, shadows = true,
    seed = x.o.seed + k, threads = x.threads, progress = x.bar }))))
end

--- Radiance `start` with gathered light added, by links of seed + k.
local function gather(x, v, lit, count, start, k)
  if not lit then return start end
  local links = need(check.result(x.name, x.lib.shade_links(v.view, lit.links, count, x.o.seed + k, x.threads, x.bar,
    x.o.gloss == "matte" and "matte" or "both")))
  return need(check.result(x.name, x.lib.shade_gather(v.view, links, lit, start, x.threads, x.bar)))
end

--- Estimates { view, radiance, again } of two views.
local function compare(x, a, b)
  return need(check.result(x.name, x.lib.shade_compare(a, b, nil, x.weight)))
end

--- The picture [h][w][3] of radiance of a view, where no lamp is drawn and nothing is behind surfaces.
local function resolve(x, v, radiance)
  return need(check.result(x.name, x.lib.shade_resolve(v.view, radiance, nil, false, x.threads)))
end

--- 1 for pixels of a view in which no lamp is in sight, else 0.
local function unlit(x, v)
  return need(check.result(x.name, x.lib.shade_layer(v.view, "emitter", x.threads))):equal(0)
end

--- Pixels in which a lamp is in sight have no weight: they show it, and not what is behind it.
local function hide_lamps(x, v)
  local seen = unlit(x, v):reshape { #x.weights }:totable()
  for i, w in ipairs(x.weights) do x.weights[i] = seen[i] * w end
  x.weight = array.array(x.weights, "double")
end

--- Chooses pixels by one picture or two.
local function draw(x, count, seed, light, again)
  local pixels, weights = x.lib.shade_draw(light, again, count, seed)
  x.pixels, x.weights = need(check.result(x.name, pixels, weights))
end

--- The root mean square difference of two estimates by a view, relative to the mean of the picture.
local function difference(x, v, a, b)
  return x.mean > 0 and math.sqrt(compare(x, { v.view, a }, { v.view, b }).square) / x.mean or 0
end

--- The next power of two of a number n of shadow rays that are to lower an error to `aim`: it falls as n^(-2/3).
local function more(n, error, aim)
  return n * 2 ^ math.max(1, math.min(4, math.ceil(math.log(error / aim) / math.log(2) * 1.5)))
end

--- Elements of a spacing, halved so often, and the light on them; nil where there are no bounces. Each time there are four times
-- as many, of half as many links.
local function light_elements(x, spacing, halved)
  if x.bounces == 0 then return nil end
  local o = x.o
  local rays = math.max(ELEMENT.least, ELEMENT.links / 2 ^ halved)
  local t = o.links or need(x.scene:links { spacing = spacing, rays = rays, lmax = 0, seed = o.seed,
    threads = o.threads, progress = o.progress })
  return need(t:radiosity(x.scene.lights, { light_samples = ELEMENT.light_samples,
    bounces = x.bounces == "all" and "all" or x.bounces - 1, seed = o.seed, threads = o.threads, progress = o.progress }))
end

--- Numbers of a shading point, of which a pixel has `density`.
local function per_point(light_samples, links, density)
  return math.max(1, math.ceil(light_samples / density)), math.max(4, 4 * math.ceil(links / density / 4))
end

--- The cheap picture, and pixels by its light.
local function begin(x)
  local v = look(x, CHEAP.samples, CHEAP.share)
  x.unlit = unlit(x, v)
  x.cheap = array.array(resolve(x, v, gather(x, v, x.lit, CHEAP.links, direct(x, v, CHEAP.light_samples, 2), 2)) * x.unlit,
    "float")
  v.view:close()
  draw(x, PIXELS, x.o.seed, x.cheap)
end

--- The mean of the picture.
local function rough(x)
  local v = x.first
  local all = gather(x, v, x.lit, FIRST.links, direct(x, v, 2 * FIRST.light_samples, 0), 0)
  x.mean = compare(x, { v.view, all }, { v.view, all }).mean
end

--- Two estimates by a view, with some 64 shadow rays and 256 links a pixel.
local function outlines(x, v)
  local rays, links = per_point(64, 256, v.density)
  local function one(k) return gather(x, v, x.lit, links, direct(x, v, rays, k), k) end
  return { v.view, one(0), one(1) }
end

--- Camera rays that leave little of the edges of surfaces and shadows.
local function choose_rays(x)
  local pixels, fine = x.o.size[1] * x.o.size[2], outlines(x, look(x, RAYS[#RAYS][1], 0))
  local best = math.huge
  for i, rays in ipairs(RAYS) do
    local samples, share = x.given.samples or rays[1], x.given.share or rays[2]
    local v = look(x, samples, share)
    if i > 1 and v.density * pixels * (POINT + 256) > MOST.bytes then break end
    local square = compare(x, outlines(x, v), fine).square
    local error = math.sqrt(math.max(0, square)) / x.mean
    if error < best then
      best, x.causes.pixels, x.density = error, error, v.density
      x.chosen.samples, x.chosen.share = samples, share
    end
    v.view:close()
    if error <= SHARE.pixels * x.tolerance or x.given.samples and x.given.share then break end
  end
  fine[1]:close()
end

--- Shadow rays enough.
local function choose_light_samples(x)
  local c, v, aim = x.chosen, x.final, SHARE.direct * x.tolerance
  while true do
    local a = direct(x, v, c.light_samples, 0)
    x.causes.direct = difference(x, v, a, direct(x, v, c.light_samples, 1)) / math.sqrt(2)
    if x.causes.direct <= aim or x.given.light_samples or c.light_samples >= MOST.light_samples then return end
    c.light_samples = math.min(MOST.light_samples, more(c.light_samples, x.causes.direct, aim))
  end
end

--- Half of what elements of twice the spacing would change of the pixels.
local function element_error(x)
  local v, coarse = x.first, need(transfers.coarse(x.lit))
  local change = difference(x, v, gather(x, v, x.lit, FIRST.links, nil, 0), gather(x, v, coarse, FIRST.links, nil, 0))
  coarse:close()
  return change / 2
end

--- Elements small enough: groups of them would change little. Links that are given stay.
local function choose_elements(x)
  local c, aim, halved = x.chosen, SHARE.elements * x.tolerance, 0
  while true do
    c.spacing, c.elements = x.lit.links.stats.spacing, x.lit.links.stats.elements
    x.causes.elements = element_error(x)
    if x.causes.elements <= aim or x.o.links or 4 * c.elements > MOST.elements then return end
    local before = x.lit
    halved = halved + 1
    x.lit = light_elements(x, c.spacing / 2, halved)
    before:close()
    before.links:close()
  end
end

--- Links enough.
local function choose_links(x)
  local c, v, causes, aim = x.chosen, x.final, x.causes, SHARE.links * x.tolerance
  local points = math.max(1, x.o.size[1] * x.o.size[2] * v.density)
  local most = math.max(4, math.min(MOST.links, 4 * math.floor(MOST.bytes / 16 / points)))
  while true do
    local a = gather(x, v, x.lit, c.links, nil, 0)
    causes.links = difference(x, v, a, gather(x, v, x.lit, c.links, nil, 1)) / math.sqrt(2)
    if causes.links <= aim or x.given.rays or c.links >= most then return end
    local times = 1.1 * (causes.links / aim) ^ (4 / 3) -- it falls as n^(-3/4), or a little less
    c.links = math.min(most, 4 * math.ceil(c.links / 4 * math.min(16, math.max(1.25, times))))
  end
end

--- Channels of the chosen pixels, one after the other: of the picture [h][w][3], or where that has light of virtual lights, which
-- is not judged, of direct light in their view v.
local function channels_of(x, v, picture)
  if x.virtual then
    return resolve(x, v, direct(x, v, x.chosen.light_samples, 0)):reshape { 3 * #x.pixels }:totable()
  end
  local out, width = {}, picture.shape[2]
  for _, number in ipairs(x.pixels) do
    local row, column = math.floor(number / width) + 1, number % width + 1
    for c = 1, 3 do out[#out + 1] = picture:get(row, column, c) end
  end
  return out
end

--- An estimate of the radiance of `pixels`, an array [n][3], by so many paths of each, and its variance.
local function ask_paths(x, pixels, samples)
  x.judged.estimates = x.judged.estimates + 1
  local seed = (x.o.seed + 101 * x.judged.estimates) % core.limits.seed
  local v = look(x, math.max(ROUND.samples, samples / 2), 0, seed, pixels)
  local mean, variance, rays = need(check.result(x.name, x.lib.shade_judge_pixels(v.view, { samples = samples, first = 1,
    last = x.bounces == "all" and -1 or x.bounces + 1, guides = true, single = true, kept = x.guides, seed = seed,
    threads = x.threads, progress = x.bar })))
  v.view:close()
  x.judged.rays, x.judged.samples = x.judged.rays + rays, x.judged.samples + samples * #pixels
  return mean, variance
end

--- Groups of pixels, each with the paths of an estimate: { paths, pixels, which }. They have least noise of the verdict for all
-- their paths, as far as `variance`, a list of three of each pixel, tells, of estimates of one number of paths.
local function groups_of(x, variance, size)
  local share, total, groups, list = {}, 0, {}, {}
  for i, w in ipairs(x.weights) do
    local v = variance[3 * i - 2] + variance[3 * i - 1] + variance[3 * i]
    share[i] = (w ^ 0.5 * v) ^ (2 / 3)
    total = total + share[i]
  end
  for i, s in ipairs(share) do
    local parts = 1
    while parts < ROUND.parts and s * #share > 1.5 * parts * total do parts = 2 * parts end
    local g = groups[parts] or { paths = parts * size, pixels = {}, which = {} }
    groups[parts] = g
    g.pixels[#g.pixels + 1], g.which[#g.which + 1] = x.pixels[i], i
  end
  for parts = 1, ROUND.parts do list[#list + 1] = groups[parts] end
  return list
end

--- Adds an estimate of the pixels to sums and sums of squares of their channels.
local function add_estimate(x, groups, sum, squares)
  for _, g in ipairs(groups) do
    local mean = ask_paths(x, g.pixels, g.paths)
    for n, i in ipairs(g.which) do
      for c = 1, 3 do
        local at, m = 3 * (i - 1) + c, mean:get(n, c)
        sum[at], squares[at] = (sum[at] or 0) + m, (squares[at] or 0) + m * m
      end
    end
  end
end

--- The variance of one path of each channel, by k estimates.
local function variance_of_path(groups, sum, squares, k)
  local v = {}
  for _, g in ipairs(groups) do
    for _, i in ipairs(g.which) do
      for c = 3 * i - 2, 3 * i do v[c] = g.paths * math.max(0, squares[c] / k - (sum[c] / k) ^ 2) end
    end
  end
  return v
end

--- Of a pixel whose channels begin at i: its squared distance from the mean of k estimates, the variance of that, which the
-- differences of the estimates tell, and the mean.
local function pixel_distance(a, sum, squares, k, i)
  local e, known, mean = 0, 0, 0
  for c = i, i + 2 do
    local m = sum[c] / k
    local v = math.max(0, squares[c] / k - m * m) / (k - 1)
    local d = (a[c] - m) ^ 2 - v
    e, known, mean = e + d / 3, known + (4 * math.max(0, d) * v + 2 * v * v) / 3, mean + m / 3
  end
  return e, known, mean
end

--- Sums over pixels that were drawn with probability 1/w, of the terms e: the variance of their sum of w e (Hajek 1964).
local function variance_of(e, w)
  local part, whole, count, sum = 0, 0, 0, 0
  for i = 1, #e do
    local loose = w[i] > 1 and 1 - 1 / w[i] or 0
    part, whole = part + loose * w[i] * e[i], whole + loose
    if loose > 0 then count = count + 1 end
  end
  if count < 2 then return 0 end
  for i = 1, #e do
    if w[i] > 1 then sum = sum + (1 - 1 / w[i]) * (w[i] * e[i] - part / whole) ^ 2 end
  end
  return sum * count / (count - 1)
end

--- The squared relative distance of pixels `a` from the mean of k estimates, which are known by their sums and sums of
-- squares: { square, its standard error u, the part of that by the noise of paths, missed }: what pixels that were not drawn may
-- add, if the error of none is larger for its probability than the largest that was drawn.
local function distance(x, a, sum, squares, k)
  local w, e, total, n, noise, square, most, loose = x.weights, {}, 0, 0, 0, 0, 0, 0
  local own = 0 -- of paths alone
  for i = 1, #w do
    local known, mean
    e[i], known, mean = pixel_distance(a, sum, squares, k, 3 * i - 2)
    if x.shown[i] then n = n + w[i] end
    total, square, noise, own = total + w[i] * mean, square + w[i] * e[i], noise + w[i] * known, own + w[i] ^ 2 * known
    if w[i] > 1 then loose, most = loose + 1, math.max(most, w[i] * (e[i] - NOISY * math.sqrt(known))) end
  end
  local scale = 1 / math.max(n, 1) / math.max((total / math.max(n, 1)) ^ 2, 1e-300)
  most = math.max(most, square / math.max(#w, 1)) -- the mean
  return { square = square * scale, u = math.sqrt(variance_of(e, w) + noise) * scale, noise = math.sqrt(own) * scale,
    missed = most * loose / math.max(1, loose - 1) * scale }
end

--- Which pixels show surfaces: list of true or false, and their number.
local function surfaces(x, v)
  local shown, count = {}, 0
  for i, row in ipairs(need(check.result(x.name, x.lib.shade_layer(v.view, "coverage", x.threads))):totable()) do
    shown[i] = row[1][1] > 0 and x.weights[i] > 0
    if shown[i] then count = count + 1 end
  end
  return shown, count
end

--- The part by which the squared error may be larger, at a confidence of 95 %.
local function bound(found) return TERM * found.u + RANGE * found.missed end

--- The picture's own pixels in a list, a, without those in which a lamp is in sight.
local function judged_pixels(x, seen)
  local v = look(x, x.chosen.samples, x.chosen.share)
  local all, a, pixels, weights, shown = channels_of(x, v, seen), {}, {}, {}, {}
  hide_lamps(x, v)
  local surface, count = surfaces(x, v)
  v.view:close()
  for i, w in ipairs(x.weights) do
    if w > 0 then
      local n = #pixels + 1
      pixels[n], weights[n], shown[n] = x.pixels[i], w, surface[i]
      for c = 1, 3 do a[3 * (n - 1) + c] = all[3 * (i - 1) + c] end
    end
  end
  x.pixels, x.weights, x.shown, x.judged.pixels = pixels, weights, shown, count
  return a
end

--- Whether this distance from paths settles whether the tolerance is kept, or is known well enough.
local function settles(x, found)
  local limit, least = x.tolerance ^ 2, math.max(found.square, x.noise)
  if math.abs(least - limit) > bound(found) then return true end
  return found.u <= KNOWN * limit and TERM * found.u <= RANGE * found.missed
end

--- The distance of the picture's own pixels from the path tracer, which traces more paths until it is settled, or the noise of
-- paths is too little of what is not known.
local function ask_judge(x, a)
  local sum, squares, size = {}, {}, ROUND.samples
  local _, variance = ask_paths(x, x.pixels, ROUND.pilot)
  local groups = groups_of(x, variance:reshape { 3 * #x.pixels }:totable(), size)
  local k, check_at = 0, ROUND.first
  while true do
    k = k + 1
    add_estimate(x, groups, sum, squares)
    if k == check_at then
      local found = distance(x, a, sum, squares, k)
      if settles(x, found) or TERM * found.noise < MATTERS * bound(found) or k >= ROUND.most then return found end
      check_at = math.ceil(1.5 * k)
      if size == ROUND.samples and check_at > ROUND.anew then
        size = ROUND.larger * size
        groups, sum, squares = groups_of(x, variance_of_path(groups, sum, squares, k), size), {}, {}
        k, check_at = 0, ROUND.first
      end
    end
  end
end

-- The report -------------------------------------------------------------------------------

local function percent(share) return (share < 0.1 and "%.2g %%" or "%.0f %%"):format(100 * share) end

--- The largest cause and its remedy; where causes that are known are too small to be it: glossy surfaces, or small parts.
local function cause_of(x, error)
  local c, worst, sum = x.chosen, nil, 0
  for _, name in ipairs { "elements", "links", "direct", "pixels" } do
    sum = sum + (x.causes[name] or 0) ^ 2
    if x.causes[name] and (not worst or x.causes[name] > x.causes[worst]) then worst = name end
  end
  if x.bounces ~= 0 and math.sqrt(sum) < error / 2 then
    return x.glossy > 0 and (x.o.gloss == "matte" and "bounced light meets glossy surfaces as matte ones: leave gloss out"
        or "glossy surfaces send bounced light to others as matte ones: use scene:pathtrace")
      or "elements meet light that changes faster than they are fine: give bounced = scene:links { spacing = .. }"
  end
  local share = percent(math.min(x.causes[worst], error))
  if worst == "pixels" then
    return ("%s come from edges of surfaces and shadows, at %d camera rays a pixel: set samples = %d, share = 0"):format(share,
      c.samples, math.min(core.limits.camera_samples, 4 * c.samples))
  elseif worst == "direct" then
    return ("%s come from %d shadow rays a point: set light_samples = %d"):format(share, c.light_samples, 4 * c.light_samples)
  elseif worst == "links" then
    return ("%s come from %d links a point: set rays = %d"):format(share, c.links,
      math.min(core.limits.transfer_links, 4 * c.links))
  end
  return ("%s come from %d elements of spacing %.3g: give bounced = scene:links { spacing = %.2g }"):format(share,
    c.elements, c.spacing, c.spacing / 2)
end

--- The verdict on a picture that is so far from paths. Noise that two estimates have shown is the least error.
local function verdict(x, found)
  local error, u = math.sqrt(math.max(0, found.square, x.noise)), found.u
  local most = math.sqrt(error ^ 2 + bound(found))
  local out = { tolerance = x.tolerance, error = error, met = error <= x.tolerance, causes = x.causes,
    judged = { pixels = x.judged.pixels, samples = x.judged.samples, rays = x.judged.rays, sure = true,
      uncertainty = math.sqrt(error ^ 2 + u) - error, most = most, seconds = x.seconds } }
  if not out.met then
    out.judged.sure = error ^ 2 - out.tolerance ^ 2 > bound(found)
    out.warning = ("scene %q: tolerance %.3g is not met, the error is %.2g: %s, or set tolerance = %.2g"):format(
      x.scene.name or "?", x.tolerance, error, cause_of(x, error), error * 1.1)
  elseif most > x.tolerance then
    out.judged.sure = false
    out.warning = ("scene %q: tolerance %.3g is met as far as %d paths of each of %d pixels can tell: the error is %.2g, and "
      .. "may be %.2g; set tolerance = %.2g, or compare with scene:pathtrace"):format(x.scene.name or "?", x.tolerance,
      x.judged.samples, x.judged.pixels, error, most, 1.1 * most)
  end
  return out
end

--- Seconds of a path of every pixel that is judged.
local function path_seconds(x)
  ask_paths(x, x.pixels, ROUND.pilot) -- learns guides
  local start = core.seconds()
  ask_paths(x, x.pixels, ROUND.pilot)
  x.judged.rays, x.judged.samples, x.judged.estimates = 0, 0, 0 -- the judge has random numbers of its own, said or not
  return (core.seconds() - start) / ROUND.pilot * JUDGED[1] / #x.pixels
end

--- Says what was chosen, and how long the picture and its judge take, as far as some pixels and paths tell.
local function announce(x)
  local c, start = x.chosen, core.seconds()
  local v = look(x, c.samples, c.share)
  gather(x, v, x.lit, c.links, direct(x, v, c.light_samples, 0), 0)
  v.view:close()
  local picture = (core.seconds() - start) * x.o.size[1] * x.o.size[2] / #x.pixels
  local seconds = path_seconds(x)
  local least, most = (ROUND.pilot + ROUND.first * ROUND.samples) * seconds, ROUND.most * ROUND.larger * ROUND.samples * seconds
  progress.say(x.bar, picture + least, "tolerance %.3g chooses %d camera rays a pixel (share %g), %d shadow rays"
    .. "%s; the picture takes about %s, to judge it %s to %s", x.tolerance, c.samples, c.share, c.light_samples,
    x.lit and (", %d links, %d elements"):format(c.links, c.elements) or "", progress.clock(picture),
    progress.clock(least), progress.clock(most))
end

--- Chooses means.
local function choose(x)
  x.lit = light_elements(x, x.chosen.spacing, 0)
  begin(x)
  x.first = look(x, RAYS[1][1], RAYS[1][2])
  hide_lamps(x, x.first)
  rough(x)
  if x.mean <= 0 then return end
  choose_rays(x)
  local c, given = x.chosen, x.given
  x.final = look(x, c.samples, c.share)
  c.light_samples, c.links = per_point(FIRST.light_samples, FIRST.links, x.final.density)
  c.light_samples, c.links = given.light_samples or c.light_samples, given.rays or c.links
  choose_light_samples(x)
  if x.lit then
    choose_elements(x)
    choose_links(x)
  end
  for _, name in ipairs { "pixels", "direct", "links" } do x.noise = x.noise + (x.causes[name] or 0) ^ 2 end
  if progress.speaks(x.bar) then announce(x) end
end

--- Judges the picture `seen` [h][w][3], of surfaces alone.
local function judge(x, seen)
  local found = { square = 0, u = 0, missed = 0, noise = 0 }
  if x.mean <= 0 then return verdict(x, found) end
  local light = array.array(seen * x.unlit, "float")
  for i, count in ipairs(JUDGED) do
    x.judged.samples = 0
    draw(x, count, (x.o.seed + i) % core.limits.seed, light, x.cheap)
    local a = judged_pixels(x, seen)
    if x.judged.pixels == 0 then break end
    found = ask_judge(x, a)
    x.judged.samples = math.floor(x.judged.samples / #x.pixels + 0.5)
    if settles(x, found) or #x.pixels < 0.9 * count then break end
  end
  return verdict(x, found)
end

--- Results of a trial f(x, ...), which takes its seconds to others of x; or nil, message, code.
local function try(f, x, ...)
  local start = core.seconds()
  local ok, found = pcall(f, x, ...)
  x.seconds = x.seconds + core.seconds() - start
  if ok then return found or true end
  if type(found) == "table" and found.trial then return nil, found[1], found[2] end
  error(found, 0)
end

--- Chooses what options leave open: { lit, chosen }, for knob.judge; or nil, message, code. `given` are the options
-- as the caller wrote them: what stands there is kept.
function knob.choose(name, s, o, given)
  local chosen, by = { spacing = FIRST.spacing }, o.reflected and o.reflected.record.name
  local bounces = by == "links" and o.reflected.bounces or 0
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  chosen.light_samples, chosen.links = given.light_samples or FIRST.light_samples, given.rays or FIRST.links
  chosen.samples, chosen.share = given.samples or RAYS[1][1], given.share or RAYS[1][2]
  if not o.links and s.link_options and s.link_options.spacing and bounces ~= 0 then
    o.links, message, code = s:links { seed = o.seed, threads = o.threads, progress = o.progress } -- as the scene says
    if not o.links then return nil, message, code end
  end
  chosen.spacing = FIRST.spacing * math.max(box.diagonal(t.lo, t.hi), 1e-30)
  local x = { name = name, scene = s, o = o, lib = t.lib, glossy = t.glossy, bounces = bounces, virtual = by == "virtual",
    tolerance = o.tolerance, threads = o.threads or 0, bar = progress.resolve(o.progress), chosen = chosen, causes = {},
    noise = 0, seconds = 0, judged = { rays = 0, pixels = 0, samples = 0, estimates = 0 }, guides = t.lib.path_guides(),
    given = { samples = given.samples, share = given.share, light_samples = given.light_samples,
      rays = given.rays } }
  local ok
  ok, message, code = try(choose, x)
  if not ok then return nil, message, code end
  return { lit = x.lit, chosen = chosen, trial = x }
end

--- Judges the picture that was made as knob.choose has `found`: its verdict, or nil, message, code. `seen` [h][w][3] are
-- its surfaces alone.
function knob.judge(found, seen)
  local x = found.trial
  local v, message, code = try(judge, x, seen)
  if not v then return nil, message, code end
  v.judged.seconds = x.seconds
  if v.warning then warning.say(x.scene, "tolerance", "%s", v.warning) end
  return v
end

--- Completes report and metadata of a picture by its tolerance.
local function report_of(found, v, report, image)
  local c, m = found.chosen, image.metadata
  report.tolerance, report.met, report.error = v.tolerance, v.met, v.error
  report.chosen = { samples = c.samples, share = c.share, light_samples = c.light_samples, rays = v.causes.links and c.links,
    spacing = v.causes.links and c.spacing, elements = c.elements }
  report.causes, report.judged = v.causes, v.judged
  report.seconds.judge = v.judged.seconds
  report.seconds.total = report.seconds.total + v.judged.seconds
  if v.warning then report.warnings[#report.warnings + 1] = v.warning end
  m.tolerance, m.error, m.met = ("%.3g"):format(v.tolerance), ("%.3g"):format(v.error), tostring(v.met)
end

--- Raises where a tolerance judges no such picture.
local function check_judged(name, o)
  if o.ambient or o.ambient_radius then
    return check.fail("%s: tolerance is of the scene's light, which ambient is not: leave one out", name)
  end
  if o.shading == "vertices" then
    return check.fail("%s: tolerance is judged at what camera rays hit: shading = 'pixel'", name)
  end
  if not o.shadows then return check.fail("%s: tolerance is of the scene's light, shadows too: leave visibility out", name) end
  local b = o.reflected
  if b and (b.lit or b.grid) then
    return check.fail("%s: tolerance chooses how light that bounces is found: leave bounced out, or give links or 'virtual'",
      name)
  end
end

--- The picture of scene:render that keeps o.tolerance, and says whether it does; how() makes one. Or nil, message, code.
function knob.picture(name, s, o, given, how)
  check_judged(name, o)
  local b = o.reflected
  local by_virtual = b and b.record.name == "virtual" -- direct light alone is judged
  local found, message, code = knob.choose(name, s, o, given)
  if not found then return nil, message, code end
  local c = found.chosen
  o.seen, message, code = array.zeros({ o.size[2], o.size[1], 3 }, "float")
  if not o.seen then return nil, message, code end
  o.light_samples, o.rays, o.samples, o.share, o.lmax = c.light_samples, c.links, c.samples, c.share, 0
  if by_virtual then b.options.tolerance = math.min(b.options.tolerance or 1, o.tolerance)
  elseif b then b.lit, o.links = found.lit, nil end
  local image, report, judged
  image, report, code = how()
  if not image then return nil, report, code end
  judged, message, code = knob.judge(found, o.seen)
  if not judged then return nil, message, code end
  report_of(found, judged, report, image)
  if by_virtual then
    report.warnings[#report.warnings + 1] = warning.say(s, "tolerance virtual", "scene %q: tolerance is judged in direct light; "
      .. "of virtual lights it bounds the sum (report.virtual.error), not what their number leaves: scene:pathtrace tells",
      s.name or "?")
  end
  return image, report
end

return knob
