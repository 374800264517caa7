--- One knob: a picture with a tolerance chooses spacing, links, shadow rays and camera rays, and judges itself.
--
-- Some hundred pixels alone are rendered with ever finer means. Noise is the difference of two estimates with random numbers of
-- their own, the error of elements that from half their spacing. The error of camera rays is that from 256 of them, each with
-- its own shading point, in direct light and bounced. The whole picture is made once, with the means found. Paths through
-- camera rays of their own say how far these very pixels of it are off. The picture's error is that
-- distance, the noise of the paths taken off.

local check = require "ylm.check"
local core = require "ylm.c.core"
local box = require "ylm.box"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local knob = {}

local PIXELS = 512
-- Parts of the tolerance that each cause may have; their squares add up to 0.7.
local SHARE = { pixels = 0.45, direct = 0.35, links = 0.35, elements = 0.5 }
-- Where it begins (spacing: of the diagonal), and ends.
local FIRST = { light_samples = 16, links = 64, spacing = 1 / 32 }
local MOST = { light_samples = 1024, links = 1024, elements = core.limits.transfer_elements, bytes = 2 ^ 31 }
local POINT = 110 -- bytes of a shading point without its links
-- Camera rays of a pixel, and which of them are shaded as one, the cheapest first; the last judges the others.
local RAYS = { { 16, 1.5 }, { 64, 1.5 }, { 16, 0 }, { 64, 0 }, { 256, 0 } }
local ELEMENT = { links = 128, light_samples = 16 }
-- The judge's estimates of a pixel, each with camera rays of its own and so many paths from each hit, and their number.
local ROUND = { samples = 16, paths = 32, first = 2, most = 32 }
local KNOWN = 0.1 -- of the squared tolerance: the judge is precise enough

knob.fields = {
  { "tolerance", "number", min = 0.001, max = 1, optional = true,
    about = "of the picture, the root mean square error relative to its mean, edges included: chooses spacing, links, "
      .. "light_samples and samples where they are not given, judges itself by paths, and says whether it is met (report.met, "
      .. ".error)" },
}

-- Pixels ----------------------------------------------------------------------------------

--- Numbers of at most PIXELS pixels, one in each of equal rectangles, at random.
local function choose_pixels(width, height, seed)
  local columns = math.max(1, math.min(width, math.floor(math.sqrt(PIXELS * width / height))))
  local rows = math.max(1, math.min(height, math.floor(PIXELS / columns)))
  local out, state = {}, (seed * 7919 + 12345) % 2147483647
  local function random(n)
    state = (state * 16807 + 11) % 2147483647
    return math.floor(state / 2147483647 * n)
  end
  for r = 0, rows - 1 do
    for c = 0, columns - 1 do
      local x0, x1 = math.floor(c * width / columns), math.floor((c + 1) * width / columns)
      local y0, y1 = math.floor(r * height / rows), math.floor((r + 1) * height / rows)
      out[#out + 1] = (y0 + random(y1 - y0)) * width + x0 + random(x1 - x0)
    end
  end
  return out
end

-- Trials ----------------------------------------------------------------------------------

--- A function whose failures, nil, message, code, end the trial: it raises them as a table, which knob.choose catches.
local function need(...)
  local first, message, code = ...
  if first == nil or first == false then error({ trial = true, message, code }, 0) end
  return ...
end

--- The prepared view of the chosen pixels, with its points a pixel.
local function look(x, samples, share, seed)
  local o = x.o
  local view = need(views.prepare(x.name, x.scene, { size = o.size, samples = samples, seed = seed or o.seed, share = share,
    shading = "pixel", visibility = "rays", lmax = 0, threads = o.threads, progress = o.progress, pixels = x.pixels }))
  local p = views.open(x.name, view)
  return { p = p, view = view, density = p.stats.points / #x.pixels }
end

--- Radiance of direct light at the points of a view v, by random numbers of seed + k.
local function direct(x, v, rays, k)
  return (need(check.result(x.name, x.lib.shade_raycast(v.view, { light_samples = rays, shadows = true,
    seed = x.o.seed + k, threads = x.threads, progress = x.bar }))))
end

--- Radiance `start` with gathered light added, by links of seed + k.
local function gather(x, v, lit, count, start, k)
  if not lit then return start end
  local links = need(check.result(x.name, x.lib.shade_links(v.view, lit.transfer, count, x.o.seed + k, x.threads, x.bar,
    x.o.gloss == "matte" and "matte" or "both")))
  return need(check.result(x.name, x.lib.shade_gather(v.view, links, lit, start, x.threads, x.bar)))
end

--- Estimates { view, radiance, again } of two views.
local function compare(x, a, b, variance)
  return need(check.result(x.name, x.lib.shade_compare(a, b, variance)))
end

--- The root mean square difference of two estimates by a view, relative to the mean of the picture.
local function difference(x, v, a, b)
  return x.mean > 0 and math.sqrt(compare(x, { v.view, a }, { v.view, b }).square) / x.mean or 0
end

--- The next power of two of a number of samples that are to lower an error to `aim`.
local function more(n, error, aim, power)
  return n * 2 ^ math.max(1, math.min(4, math.ceil(math.log(error / aim) / math.log(2) * power)))
end

--- Elements of a spacing, and the light on them; nil where there are no bounces.
local function light_elements(x, spacing)
  if x.bounces == 0 then return nil end
  local o = x.o
  local t = o.transfer or need(x.scene:transfer { spacing = spacing, links = ELEMENT.links, lmax = 0, seed = o.seed,
    threads = o.threads, progress = o.progress })
  return need(t:radiosity(x.scene.lights, { light_samples = ELEMENT.light_samples,
    bounces = x.bounces == "all" and "all" or x.bounces - 1, seed = o.seed, threads = o.threads, progress = o.progress }))
end

--- Numbers of a shading point, of which a pixel has `density`.
local function per_point(light_samples, links, density)
  return math.max(1, math.ceil(light_samples / density)), math.max(4, 4 * math.ceil(links / density / 4))
end

--- The mean of the picture.
local function rough(x)
  local v = x.first
  local all = gather(x, v, x.lit, FIRST.links, direct(x, v, 2 * FIRST.light_samples, 0), 0)
  local found = compare(x, { v.view, all }, { v.view, all })
  x.mean, x.judged.pixels = found.mean, found.pixels
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
    if error <= SHARE.pixels * x.tolerance then break end
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
    c.light_samples = math.min(MOST.light_samples, more(c.light_samples, x.causes.direct, aim, 1.5))
  end
end

--- Elements small enough: half their spacing changes little. The half leaves at most half of that change.
local function choose_elements(x)
  local c, aim = x.chosen, SHARE.elements * x.tolerance
  if x.o.transfer then
    c.spacing, c.elements = x.o.transfer.stats.spacing, x.o.transfer.stats.elements
    return
  end
  local before = gather(x, x.first, x.lit, FIRST.links, nil, 0)
  repeat
    local coarse = x.lit
    x.lit = light_elements(x, c.spacing / 2)
    c.spacing, c.elements = c.spacing / 2, x.lit.transfer.stats.elements
    coarse:close()
    coarse.transfer:close()
    local now = gather(x, x.first, x.lit, FIRST.links, nil, 0)
    x.causes.elements, before = difference(x, x.first, before, now) / 2, now
  until x.causes.elements <= aim or 4 * c.elements > MOST.elements
end

--- Links enough.
local function choose_links(x)
  local c, v, aim = x.chosen, x.final, SHARE.links * x.tolerance
  local points = math.max(1, x.o.size[1] * x.o.size[2] * v.density)
  local most = math.max(4, math.min(MOST.links, 4 * math.floor(MOST.bytes / 16 / points)))
  while true do
    local a = gather(x, v, x.lit, c.links, nil, 0)
    x.causes.links = difference(x, v, a, gather(x, v, x.lit, c.links, nil, 1)) / math.sqrt(2)
    if x.causes.links <= aim or x.given.links or c.links >= most then return end
    c.links = math.min(most, more(c.links, x.causes.links, aim, 2))
  end
end

--- Channels of the pixels of a view v, one after the other, where no lamp is drawn.
local function pixels_of(x, v, radiance)
  local out = {}
  for _, row in ipairs(need(check.result(x.name, x.lib.shade_resolve(v.view, radiance, nil, false, x.threads))):totable()) do
    for c = 1, 3 do out[#out + 1] = row[1][c] end
  end
  return out
end

--- Estimate number k of the pixels: by paths through camera rays of its own.
local function ask_paths(x, k)
  local v = look(x, ROUND.samples, 0, (x.o.seed + 101 * k) % core.limits.seed)
  local mean, _, rays = need(check.result(x.name, x.lib.shade_judge(v.view, { samples = ROUND.paths, first = 1,
    last = x.bounces == "all" and -1 or x.bounces + 1, seed = x.o.seed + 101 * k, threads = x.threads, progress = x.bar })))
  local out = pixels_of(x, v, mean)
  v.view:close()
  x.judged.rays, x.judged.samples = x.judged.rays + rays, k * ROUND.samples * ROUND.paths
  return out
end

--- The squared relative distance of pixels `a` from the mean of k estimates, and its standard
-- error. The k estimates are known by their sums and sums of squares. The variance of their mean,
-- told by their differences, is taken off.
local function distance(x, a, sum, squares, k)
  local n, total, square, spread = math.max(1, x.judged.pixels), 0, 0, 0
  for i = 1, #a, 3 do
    local e = 0
    for c = i, i + 2 do
      local mean = sum[c] / k
      total, e = total + mean / 3, e + ((a[c] - mean) ^ 2 - (squares[c] / k - mean ^ 2) / (k - 1)) / 3
    end
    square, spread = square + e, spread + e * e
  end
  square, spread = square / n, spread / n
  local scale = 1 / math.max((total / n) ^ 2, 1e-300)
  return square * scale, math.sqrt(math.max(0, spread - square ^ 2) / n) * scale
end

--- The squared error of the picture's own pixels against the path tracer, which traces more paths until it is sure; and its
-- standard error.
local function ask_judge(x)
  local c, limit, sum, squares, k, check_at = x.chosen, x.tolerance ^ 2, {}, {}, 0, ROUND.first
  local a = pixels_of(x, x.final, gather(x, x.final, x.lit, c.links, direct(x, x.final, c.light_samples, 0), 0))
  for i = 1, #a do sum[i], squares[i] = 0, 0 end
  while true do
    k = k + 1
    local b = ask_paths(x, k)
    for i = 1, #a do sum[i], squares[i] = sum[i] + b[i], squares[i] + b[i] ^ 2 end
    if k == check_at then
      local square, u = distance(x, a, sum, squares, k)
      local least = math.max(square, x.noise)
      if u <= KNOWN * limit or math.abs(least - limit) > 3 * u or k >= ROUND.most then return square, u end
      check_at = 2 * k
    end
  end
end

-- The report -------------------------------------------------------------------------------

local function percent(share) return (share < 0.1 and "%.2g %%" or "%.0f %%"):format(100 * share) end

--- The largest cause and its remedy; where causes that are known are too small to be it: surfaces that gloss, or small parts.
local function cause_of(x, error)
  local c, worst, sum = x.chosen, nil, 0
  for _, name in ipairs { "elements", "links", "direct", "pixels" } do
    sum = sum + (x.causes[name] or 0) ^ 2
    if x.causes[name] and (not worst or x.causes[name] > x.causes[worst]) then worst = name end
  end
  if x.bounces ~= 0 and math.sqrt(sum) < error / 2 then
    return x.glossy > 0 and (x.o.gloss == "matte" and "bounced light meets surfaces that gloss as matte ones: leave gloss out"
        or "surfaces that gloss send bounced light to others as matte ones: use scene:pathtrace")
      or "elements meet light that changes faster than they are fine: give transfer = scene:transfer { spacing = .. }"
  end
  local share = percent(x.causes[worst])
  if worst == "pixels" then
    return ("%s come from edges of surfaces and shadows, at %d camera rays a pixel: set samples = %d, share = 0"):format(share,
      c.samples, math.min(core.limits.camera_samples, 4 * c.samples))
  elseif worst == "direct" then
    return ("%s come from %d shadow rays a point: set light_samples = %d"):format(share, c.light_samples, 4 * c.light_samples)
  elseif worst == "links" then
    return ("%s come from %d links a point: set links = %d"):format(share, c.links,
      math.min(core.limits.transfer_links, 4 * c.links))
  end
  return ("%s come from %d elements of spacing %.3g: give transfer = scene:transfer { spacing = %.2g }"):format(share,
    c.elements, c.spacing, c.spacing / 2)
end

--- The verdict on a picture of this squared error, known to a standard error of u. Noise that two estimates have shown is
-- the least error.
local function verdict(x, square, u, start)
  local error = math.sqrt(math.max(0, square, x.noise))
  local out = { tolerance = x.tolerance, error = error, met = error <= x.tolerance, causes = x.causes,
    judged = { pixels = x.judged.pixels, samples = x.judged.samples, rays = x.judged.rays, sure = true,
      uncertainty = math.sqrt(error ^ 2 + u) - error, seconds = core.seconds() - start } }
  if not out.met then
    out.warning = ("scene %q: tolerance %.3g is not met, the error is %.2g: %s, or set tolerance = %.2g"):format(
      x.scene.name or "?", x.tolerance, error, cause_of(x, error), error * 1.1)
  elseif error ^ 2 + 2 * u > x.tolerance ^ 2 then
    out.judged.sure = false
    local most = math.sqrt(error ^ 2 + 2 * u)
    out.warning = ("scene %q: tolerance %.3g is met as far as %d paths a pixel can tell: the error is %.2g, and may be %.2g; "
      .. "set tolerance = %.2g, or compare with scene:pathtrace"):format(x.scene.name or "?", x.tolerance, x.judged.samples,
      error, most, 1.1 * most)
  end
  return out
end

local function choose(x, start)
  x.lit = light_elements(x, x.chosen.spacing)
  x.first = look(x, RAYS[1][1], RAYS[1][2])
  rough(x)
  if x.mean <= 0 then return verdict(x, 0, 0, start) end
  choose_rays(x)
  local c, given = x.chosen, x.given
  x.final = look(x, c.samples, c.share)
  c.light_samples, c.links = per_point(FIRST.light_samples, FIRST.links, x.final.density)
  c.light_samples, c.links = given.light_samples or c.light_samples, given.links or c.links
  choose_light_samples(x)
  if x.lit then
    choose_elements(x)
    choose_links(x)
  end
  for _, name in ipairs { "pixels", "direct", "links" } do x.noise = x.noise + (x.causes[name] or 0) ^ 2 end
  local square, u = ask_judge(x)
  return verdict(x, square, u, start)
end

--- Chooses what options leave open: { lit, verdict, chosen }; or nil, message, code. `given` are the options
-- as the caller wrote them: what stands there is kept.
function knob.choose(name, s, o, given)
  local start, chosen = core.seconds(), {}
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  for key, first in pairs(FIRST) do chosen[key] = given[key] or first end
  chosen.samples, chosen.share = given.samples or given.pixel_samples or RAYS[1][1], given.share or RAYS[1][2]
  if not o.transfer and s.transfer_options and s.transfer_options.spacing and (o.bounces or 0) ~= 0 then
    o.transfer, message, code = s:transfer { seed = o.seed, threads = o.threads, progress = o.progress } -- as the scene says
    if not o.transfer then return nil, message, code end
  end
  chosen.spacing = FIRST.spacing * math.max(box.diagonal(t.lo, t.hi), 1e-30)
  local x = { name = name, scene = s, o = o, lib = t.lib, glossy = t.glossy, bounces = o.bounces or 0, tolerance = o.tolerance,
    threads = o.threads or 0, bar = progress.resolve(o.progress), chosen = chosen, causes = {}, judged = { rays = 0 }, noise = 0,
    given = { samples = given.samples or given.pixel_samples, share = given.share, light_samples = given.light_samples,
      links = given.links },
    pixels = choose_pixels(o.size[1], o.size[2], o.seed) }
  local ok, found = pcall(choose, x, start)
  if not ok then
    if type(found) == "table" and found.trial then return nil, found[1], found[2] end
    error(found, 0)
  end
  if found.warning then warning.say(s, "tolerance", "%s", found.warning) end
  return { lit = x.lit, verdict = found, chosen = chosen }
end

--- Completes report and metadata of a picture by its tolerance.
function knob.report(found, report, image)
  local v, c, m = found.verdict, found.chosen, image.metadata
  report.tolerance, report.met, report.error = v.tolerance, v.met, v.error
  report.chosen = { samples = c.samples, share = c.share, light_samples = c.light_samples, links = v.causes.links and c.links,
    spacing = v.causes.links and c.spacing, elements = c.elements }
  report.causes, report.judged = v.causes, v.judged
  report.seconds.judge = v.judged.seconds
  report.seconds.total = report.seconds.total + v.judged.seconds
  if v.warning then report.warnings[#report.warnings + 1] = v.warning end
  m.tolerance, m.error, m.met = ("%.3g"):format(v.tolerance), ("%.3g"):format(v.error), tostring(v.met)
end

return knob
