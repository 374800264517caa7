--- One knob: a picture with a tolerance chooses spacing, links, shadow rays and camera rays, and judges itself.
--
-- Some hundred pixels alone are rendered with ever finer means. Noise is the difference of two estimates with random numbers of
-- their own, the error of elements that from half their spacing. The whole picture is made once, with the means found, and
-- its error is what the path tracer says of these pixels, its noise taken off.

local check = require "ylm.check"
local core = require "ylm.c.core"
local box = require "ylm.box"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local knob = {}

local PIXELS = 512
-- Parts of the tolerance that each cause may have; their squares add up to 0.66.
local SHARE = { edges = 0.4, direct = 0.35, links = 0.35, elements = 0.5 }
-- Where it begins (spacing: of the diagonal), and ends.
local FIRST = { samples = 16, light_samples = 16, links = 64, spacing = 1 / 32 }
local MOST = { samples = 256, light_samples = 1024, links = 1024, elements = 2 ^ 20, bytes = 2 ^ 30 }
local ELEMENT = { links = 128, light_samples = 16 }
local JUDGE_FIRST, JUDGE_MOST = 256, 4096 -- paths from each point
local KNOWN = 0.36 -- of the squared tolerance: the judge is precise enough

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

--- The view with `samples` camera rays a pixel and the part of it that is judged.
local function look(x)
  if x.view then
    x.part = nil
    x.view:close()
  end
  local o = x.o
  x.view = need(views.prepare(x.name, x.scene, { size = o.size, samples = x.chosen.samples, seed = o.seed, share = o.share,
    shading = "pixel", visibility = "rays", lmax = 0, threads = o.threads, progress = o.progress }))
  x.p = views.open(x.name, x.view)
  x.lib = x.p.lib
  x.part = need(check.result(x.name, x.lib.shade_part(x.view, x.pixels)))
end

--- Radiance of direct light at the part's points, by random numbers of seed + k.
local function direct(x, k)
  return (need(check.result(x.name, x.lib.shade_raycast(x.part, x.chosen.light_samples, true, x.o.seed + k, x.threads, x.bar))))
end

--- Radiance `start` with gathered light added, by links of seed + k.
local function gather(x, lit, start, k)
  if not lit then return start end
  local links = need(check.result(x.name, x.lib.shade_links(x.part, lit.transfer, x.chosen.links, x.o.seed + k, x.threads,
    x.bar)))
  return need(check.result(x.name, x.lib.shade_gather(x.part, links, lit, start, x.threads, x.bar)))
end

local function compare(x, a, b, variance)
  return need(check.result(x.name, x.lib.shade_compare(x.part, a, b, variance)))
end

--- The root mean square difference of two estimates, relative to the mean of the picture.
local function difference(x, a, b)
  return x.mean > 0 and math.sqrt(compare(x, a, b).square) / x.mean or 0
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

--- Camera rays enough that edges are smooth; the mean of the picture.
local function choose_samples(x)
  while true do
    look(x)
    local a = gather(x, x.lit, direct(x, 0), 0)
    local found = compare(x, a, a)
    x.mean, x.pixels_seen = found.mean, found.pixels
    x.causes.edges = found.mean > 0 and math.sqrt(found.edges) / found.mean or 0
    if x.given.samples or x.causes.edges <= SHARE.edges * x.tolerance or x.chosen.samples >= MOST.samples then return end
    x.chosen.samples = x.chosen.samples * 4
  end
end

--- Shadow rays enough.
local function choose_light_samples(x)
  local c, aim = x.chosen, SHARE.direct * x.tolerance
  while true do
    x.direct = direct(x, 0)
    x.causes.direct = difference(x, x.direct, direct(x, 1)) / math.sqrt(2)
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
  local before = gather(x, x.lit, nil, 0)
  repeat
    local coarse = x.lit
    x.lit = light_elements(x, c.spacing / 2)
    c.spacing, c.elements = c.spacing / 2, x.lit.transfer.stats.elements
    coarse:close()
    coarse.transfer:close()
    local now = gather(x, x.lit, nil, 0)
    x.causes.elements, before = difference(x, before, now) / 2, now
  until x.causes.elements <= aim or 4 * c.elements > MOST.elements
end

--- Links enough; the picture at the pixels with them.
local function choose_links(x)
  local c, aim = x.chosen, SHARE.links * x.tolerance
  local most = math.max(4, math.min(MOST.links, 4 * math.floor(MOST.bytes / 16 / math.max(1, x.p.stats.points))))
  while true do
    x.picture = gather(x, x.lit, x.direct, 0)
    x.causes.links = difference(x, x.picture, gather(x, x.lit, x.direct, 1)) / math.sqrt(2)
    if x.causes.links <= aim or x.given.links or c.links >= most then return end
    c.links = math.min(most, more(c.links, x.causes.links, aim, 2))
  end
end

--- The squared error against the path tracer, which traces more paths until it is sure; and its standard error.
local function ask_judge(x)
  local samples, limit = JUDGE_FIRST, x.tolerance ^ 2 - x.causes.edges ^ 2
  while true do
    local mean, variance, rays = need(check.result(x.name, x.lib.shade_judge(x.part, { samples = samples, first = 1,
      last = x.bounces == "all" and -1 or x.bounces + 1, seed = x.o.seed + 101, threads = x.threads, progress = x.bar })))
    local found = compare(x, x.picture, mean, variance)
    local scale = 1 / math.max(found.mean ^ 2, 1e-300)
    local square, u = found.square * scale, found.uncertainty * scale
    x.judged.rays, x.judged.samples = x.judged.rays + rays, samples
    if u <= KNOWN * x.tolerance ^ 2 or math.abs(square - limit) > 3 * u or samples >= JUDGE_MOST then return square, u end
    samples = samples * 4
  end
end

-- The report -------------------------------------------------------------------------------

local function percent(share) return (share < 0.1 and "%.2g %%" or "%.0f %%"):format(100 * share) end

--- The largest cause and its remedy; where causes that are known are too small to be it: surfaces that gloss, or small parts.
local function cause_of(x, error)
  local c, worst, sum = x.chosen, nil, 0
  for _, name in ipairs { "elements", "links", "direct", "edges" } do
    sum = sum + (x.causes[name] or 0) ^ 2
    if x.causes[name] and (not worst or x.causes[name] > x.causes[worst]) then worst = name end
  end
  if x.bounces ~= 0 and math.sqrt(sum) < error / 2 then
    return x.p.traced.glossy > 0 and "surfaces that gloss reflect bounced light as matte ones: use scene:pathtrace"
      or "elements meet light that changes faster than they are fine: give transfer = scene:transfer { spacing = .. }"
  end
  local share = percent(x.causes[worst])
  if worst == "edges" then
    return ("%s come from edges, at %d camera rays a pixel: set samples = %d"):format(share, c.samples,
      math.min(1024, 4 * c.samples))
  elseif worst == "direct" then
    return ("%s come from %d shadow rays a point: set light_samples = %d"):format(share, c.light_samples, 4 * c.light_samples)
  elseif worst == "links" then
    return ("%s come from %d links a point: set links = %d"):format(share, c.links, math.min(4096, 4 * c.links))
  end
  return ("%s come from %d elements of spacing %.3g: give transfer = scene:transfer { spacing = %.2g }"):format(share,
    c.elements, c.spacing, c.spacing / 2)
end

--- The verdict on a picture of this squared error, known to a standard error of u.
local function verdict(x, square, u, start)
  local error = math.sqrt(math.max(0, square) + (x.causes.edges or 0) ^ 2)
  local out = { tolerance = x.tolerance, error = error, met = error <= x.tolerance, causes = x.causes,
    judged = { pixels = x.pixels_seen, samples = x.judged.samples, rays = x.judged.rays,
      uncertainty = u / math.max(2 * error, math.sqrt(u), 1e-300), seconds = core.seconds() - start } }
  if not out.met then
    out.warning = ("scene %q: tolerance %.3g is not met, the error is %.2g: %s, or set tolerance = %.2g"):format(
      x.scene.name or "?", x.tolerance, error, cause_of(x, error), error * 1.1)
  end
  return out
end

local function choose(x, start)
  x.lit = light_elements(x, x.chosen.spacing)
  choose_samples(x)
  if x.pixels_seen == 0 then return verdict(x, 0, 0, start) end
  choose_light_samples(x)
  x.picture = x.direct
  if x.lit then
    choose_elements(x)
    choose_links(x)
  end
  local square, u = ask_judge(x)
  return verdict(x, square, u, start)
end

--- Chooses what options leave open: { view, lit, verdict, chosen }; or nil, message, code. `given` are the options
-- as the caller wrote them: what stands there is kept.
function knob.choose(name, s, o, given)
  local start, chosen = core.seconds(), {}
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  for key, first in pairs(FIRST) do chosen[key] = given[key] or first end
  chosen.samples = given.samples or given.pixel_samples or chosen.samples
  if not o.transfer and s.transfer_options and s.transfer_options.spacing and (o.bounces or 0) ~= 0 then
    o.transfer, message, code = s:transfer { seed = o.seed, threads = o.threads, progress = o.progress } -- as the scene says
    if not o.transfer then return nil, message, code end
  end
  local x = { name = name, scene = s, o = o, bounces = o.bounces or 0, tolerance = o.tolerance, threads = o.threads or 0,
    bar = progress.resolve(o.progress), chosen = chosen, causes = {}, judged = { rays = 0 },
    given = { samples = given.samples or given.pixel_samples, light_samples = given.light_samples, links = given.links },
    pixels = choose_pixels(o.size[1], o.size[2], o.seed) }
  chosen.spacing = FIRST.spacing * math.max(box.diagonal(t.lo, t.hi), 1e-30)
  local ok, found = pcall(choose, x, start)
  if not ok then
    if x.view then x.view:close() end
    if type(found) == "table" and found.trial then return nil, found[1], found[2] end
    error(found, 0)
  end
  if not found.met then warning.say(s, "tolerance", "%s", found.warning) end
  return { view = x.view, lit = x.lit, verdict = found, chosen = chosen }
end

--- Completes report and metadata of a picture by its tolerance.
function knob.report(found, report, image)
  local v, c, m = found.verdict, found.chosen, image.metadata
  report.tolerance, report.met, report.error = v.tolerance, v.met, v.error
  report.chosen = { samples = c.samples, light_samples = c.light_samples, links = v.causes.links and c.links,
    spacing = v.causes.elements and c.spacing, elements = c.elements }
  report.causes, report.judged = v.causes, v.judged
  report.seconds.judge = v.judged.seconds
  report.seconds.total = report.seconds.total + v.judged.seconds
  if v.warning then report.warnings[#report.warnings + 1] = v.warning end
  m.tolerance, m.error, m.met = ("%.3g"):format(v.tolerance), ("%.3g"):format(v.error), tostring(v.met)
end

return knob
