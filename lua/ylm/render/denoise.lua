--- Light of pictures by rays without most of its noise, and what that changed, as rays of their own find.

local check = require "ylm.check"
local core = require "ylm.c.core"
local array = require "ylm.array"
local steady = require "ylm.render.steady"
local vector = require "ylm.vector"
local views = require "ylm.render.view"

local denoise = {}

local ELEMENTS = { pixels = 1024, sets = 16, links = 32 } -- by which the noise of elements is told; sets of both halves
local JUDGED = { pixels = 1024, rays = 64, sets = 4, links = 32 } -- rays are those of a half, sets of both
local FINER = 4 -- times less noise than is wanted is filtered for: blotches of it would be seen
local APART = 90001 -- from the seed of a picture to that of its judge

--- Filters the halves of direct light and of links of x; the raw light of points. Or nil, message, code.
function denoise.filter(x)
  local start, kinds = core.seconds(), { x.direct, x.links }
  local all = (x.direct[1] + x.direct[2]) / 2
  if x.links then all = all + (x.links[1] + x.links[2]) / 2 end
  if x.steady then all = all + x.steady end
  for k, halves in ipairs(kinds) do
    local ok, message, code = check.result(x.name, x.p.lib.shade_denoise(x.p.view, { first = halves[1], second = halves[2],
      all = all, bounced = k == 2, noise = x.wanted / FINER, threads = x.casting.threads, progress = x.casting.progress }))
    if not ok then return nil, message, code end
  end
  x.report.seconds.denoise = (x.report.seconds.denoise or 0) + core.seconds() - start
  return all
end

--- Numbers of pixels spread over a picture, in rising order, from 0.
local function draw(size, seed, count)
  local n, seen, list = size[1] * size[2], {}, {}
  for k = 1, math.min(count, n) do
    local i = math.floor((k * 0.6180339887498949 + seed * 0.7548776662466927) % 1 * n)
    if not seen[i] then list[#list + 1], seen[i] = i, true end
  end
  table.sort(list)
  return list
end

--- The prepared view of some pixels of a picture; or nil, message, code.
local function view_of(x, list)
  local o = {}
  for key, value in pairs(x.p.options) do o[key] = value end
  o.pixels, o.threads, o.gloss, o.progress = list, x.casting.threads, x.o.gloss, false
  return views.prepare(x.name, x.p.scene, o)
end

--- Two halves of the light of links at points of a view p, as `how` says (JUDGED or ELEMENTS), and from how many points it was
-- gathered; or nil, message, code. `apart`: the noise of elements alone.
local function gathered(x, p, how, seed, apart)
  local b, c, n = steady.links(x.o), x.casting, p.stats.points
  local function points(...) return assert(array.zeros({ n, ... }, "float")) end
  local halves = { points(3), points(3) }
  if not b then return halves, 0 end
  local count, message, code = check.result(x.name, p.lib.shade_gather_sets(p.view, { transfer = b.lit.links, lit = b.lit,
    targets = x.targets, links = how.links, sets = points() + how.sets, all = x.p.options.gloss == "matte", apart = apart,
    first = halves[1], second = halves[2], seed = seed, threads = c.threads, progress = x.interrupts }))
  if not count then return nil, message, code end
  return halves, count
end

--- Two estimates of all light at points of a view p of some pixels, as resolved pixels; or nil, message, code.
local function ask(x, p)
  local c, halves, direct = x.casting, {}, {}
  local links, reason, failure = gathered(x, p, JUDGED, c.seed + 3 * APART)
  if not links then return nil, reason, failure end
  local still, why, kind = steady.elsewhere(x.name, p, x.o)
  if still == nil then return nil, why, kind end
  for half = 1, 2 do
    local found, message, code = check.result(x.name, p.lib.shade_raycast(p.view, { light_samples = JUDGED.rays,
      shadows = c.shadows, spread = true, seed = c.seed + half * APART, threads = c.threads, lit = c.lit, guide = c.guide,
      progress = x.interrupts }))
    if not found then return nil, message, code end
    local all = found + links[half]
    if still then all = all + still end
    halves[half], message, code = check.result(x.name, p.lib.shade_resolve(p.view, all, nil, false, c.threads))
    if not halves[half] then return nil, message, code end
    direct[half] = assert(check.result(x.name, p.lib.shade_resolve(p.view, found, nil, false, c.threads)))
  end
  return { all = halves, direct = direct }
end

--- Luminance of pixel i of an array [h][w][3], i from 0.
local function luminance(a, width, i)
  local y, x = math.floor(i / width) + 1, i % width + 1
  return vector.luminance { a:get(y, x, 1), a:get(y, x, 2), a:get(y, x, 3) }
end

--- Pixel i of an array [h][w][1], i from 0.
local function at(a, width, i) return a:get(math.floor(i / width) + 1, i % width + 1, 1) end

--- The light around each pixel that noise is relative to, inverted: [h][w][1].
local function scale_of(x, filtered)
  local size = x.p.options.size
  local one = array.zeros({ size[2], size[1], 3 }, "float") + 1
  return check.result(x.name, x.p.lib.shade_noise_around(x.p.view, one, -one, filtered, x.casting.threads,
    array.zeros({ size[2], size[1], 1 }, "float")))
end

--- The squared noise that halves do not see: means over pixels of `found` and `seen` by n pixels, and of the squared difference.
-- The part that chance would show is left out (James and Stein's factor).
local function unseen(found, seen, square, n)
  local more = found - seen
  if n < 2 or more <= 0 then return 0 end
  return math.max(0, more - math.max(0, square - more ^ 2) / (n - 1) / more)
end

--- The noise of direct light that halves of a filter do not see, relative to the light around: the part of what two other
-- estimates of pixels find beyond it.
local function unseen_of(x, list, filtered, halves)
  local width, noise, scale = x.p.options.size[1], x.noise[1], scale_of(x, filtered.all)
  local found, seen, square, n = 0, 0, 0, 0
  for k, i in ipairs(list) do
    local f, part = luminance(filtered.direct, width, i), at(noise, width, i) ^ 2
    if at(x.left, width, i) > 0 then
      local a, b = luminance(halves[1], 1, k - 1), luminance(halves[2], 1, k - 1)
      local product = (f - a) * (f - b) * at(scale, width, i) ^ 2
      found, seen, square, n = found + product, seen + part, square + (product - part) ^ 2, n + 1
    end
  end
  n = math.max(1, n)
  return math.sqrt(unseen(found / n, seen / n, square / n, n))
end

--- The verdict on pixels of a picture, `filtered`, whose noise relative to its light is `noise`, by two estimates of these.
local function verdict(x, list, filtered, halves, noise)
  local width, n = x.p.options.size[1], #list
  local sum, square, mean, own, theirs = 0, 0, 0, 0, 0
  for k, i in ipairs(list) do
    local a, b = luminance(halves[1], 1, k - 1), luminance(halves[2], 1, k - 1)
    local f = luminance(filtered, width, i)
    local apart = f - (a + b) / 2
    sum, square, mean, theirs = sum + apart, square + apart * apart, mean + (a + b) / 2, theirs + (a - b) ^ 2 / 4
    own = own + (at(noise, width, i) * f) ^ 2
  end
  local out = { pixels = n, z2 = own + theirs > 0 and square / (own + theirs) or 0, bias = mean > 0 and sum / mean or 0,
    uncertainty = mean > 0 and math.sqrt(math.max(0, square - sum * sum / n)) / mean or 0 }
  return out
end

--- Has rays of their own judge the light `found` of the points of x, which was filtered: report.denoise. The noise that
-- its halves do not see; or nil, message, code.
function denoise.judge(x, found)
  local start, p = core.seconds(), x.p
  local list = draw(p.options.size, x.casting.seed, JUDGED.pixels)
  local view, message, code = view_of(x, list)
  if not view then return nil, message, code end
  local some = views.open(x.name, view)
  local halves, filtered
  halves, message, code = ask(x, some)
  if halves then
    filtered, message, code = check.result(x.name, p.lib.shade_resolve(p.view, found, nil, false, x.casting.threads))
  end
  view:close()
  if not filtered then return nil, message, code end
  local direct = assert(check.result(x.name, p.lib.shade_resolve(p.view, (x.direct[1] + x.direct[2]) / 2, nil, false,
    x.casting.threads)))
  local report = verdict(x, list, filtered, halves.all, x.left)
  report.unseen = unseen_of(x, list, { all = filtered, direct = direct }, halves.direct)
  report.seconds = core.seconds() - start
  x.report.denoise = report
  return report.unseen
end

--- Two estimates of the light that a sample of the noise of elements brings to pixels of a view p; false: there is none; or nil,
-- message, code.
local function bring(x, p)
  local c, halves = x.casting, {}
  local links, count, code = gathered(x, p, ELEMENTS, c.seed + 5 * APART, true)
  if not links then return nil, count, code end
  local message
  if count == 0 then return false end
  for half = 1, 2 do
    halves[half], message, code = check.result(x.name, p.lib.shade_resolve(p.view, links[half], nil, false, c.threads))
    if not halves[half] then return nil, message, code end
  end
  return halves
end

--- The noise that direct light on elements leaves in the picture `found` of x, relative to the light around pixels; false: it is
-- not known; or nil, message, code. Links of two halves meet one sample of it: the product of both holds no noise of links.
function denoise.of_elements(x, found)
  local width, list = x.p.options.size[1], draw(x.p.options.size, x.casting.seed + 1, ELEMENTS.pixels)
  local view, message, code = view_of(x, list)
  if not view then return nil, message, code end
  local halves
  halves, message, code = bring(x, views.open(x.name, view))
  view:close()
  if not halves then return halves, message, code end
  local scale, sum, n = scale_of(x, assert(check.result(x.name, x.p.lib.shade_resolve(x.p.view, found, nil, false,
    x.casting.threads)))), 0, 0
  for k, i in ipairs(list) do
    local each = at(scale, width, i)
    if each > 0 then
      sum, n = sum + luminance(halves[1], 1, k - 1) * luminance(halves[2], 1, k - 1) * each ^ 2, n + 1
    end
  end
  return math.sqrt(math.max(0, sum / math.max(1, n)))
end

return denoise
