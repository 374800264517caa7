--- Pictures by rays with a noise that is wanted: a pilot, then rays where the noise is.
--
-- The pilot has two estimates of direct light, and two of light along links. Half of their difference, over the pixels around
-- one, is its noise. Counts of rays go as the noise of a pixel over the root of what a ray costs (Neyman 1934), and are as small
-- as leaves the noise that is wanted. The picture has rays of its own, in two halves: what is known of the pilot chose their
-- number, and none of its light is in the picture, so that means stay unbiased. The halves say which noise is left.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local rounds = {}

local SET = 32                              -- links of a set
local PILOT = { rays = 8, sets = 2 }        -- of a half; of both
local MOST = { rays = 8192, sets = 512 }    -- of a half; of both
local LEAST = { rays = 2, sets = 2 }
local STEP = 1000003                        -- from one seed to the next
local AIM, SLACK = 0.95, 1.1 -- times the noise that is wanted: at which counts aim, and up to which it counts as reached
local WIDE = 60                             -- factors of counts are looked for from 2^-WIDE to 2^WIDE

rounds.fields = {
  { "noise", "number", min = 0.001, max = 1, optional = true,
    about = "by rays: the noise that the picture may have, root mean square over its pixels, each relative to the mean of 9 x 9 "
      .. "pixels around it: a pilot chooses counts of shadow rays and links pixel by pixel, and light_samples and rays are left "
      .. "out. report.noise and the layer noise say what was reached. Of matte surfaces, and bounces by links" },
  { "time_limit", "number", above = 0, optional = true, unit = "s", shelf = "experiments",
    about = "with noise, or by paths: ends after about so long, which makes results depend on it; with noise a pilot and 64 "
      .. "links a shading point are the least" },
}

--- Raises where no noise can be chosen for such a picture.
function rounds.check(name, o, given)
  if o.time_limit and not o.noise then
    return check.fail("%s: by rays, time_limit is of pictures with a noise that is wanted: give noise too", name)
  end
  if not o.noise then return end
  for _, other in ipairs { "tolerance", "light_samples", "rays", "variance" } do
    if given[other] ~= nil and given[other] ~= false then
      return check.fail("%s: noise chooses counts of rays, and %s is given: leave one out", name, other)
    end
  end
  if o.shading == "vertices" then
    return check.fail("%s: noise is of what camera rays hit: shading = 'pixel'", name)
  end
  local b = o.reflected
  if b and b.record.name ~= "links" then
    return check.fail("%s: noise is of light that bounces along links: leave bounced out, or give what scene:links or "
      .. "t:radiosity returned", name)
  end
  o.rays = b and 4 or nil -- links that are kept: sets are found beside them
end

--- Raises where surfaces of the view p shine: sets of links go as the cosine.
function rounds.check_view(name, p)
  if p.traced.glossy > 0 and p.options.gloss ~= "matte" then
    return check.fail("%s: noise is of matte surfaces, and %d meshes of scene %q are glossy: use tolerance, or by = 'paths'",
      name, p.traced.glossy, p.scene.name or "?")
  end
end

--- Arrays of zeros for points and pixels of a view.
local function room(p, o)
  local n, size = p.stats.points, o.size
  local function points(...) return assert(array.zeros({ n, ... }, "float")) end
  local function pixels(channels) return assert(array.zeros({ size[2], size[1], channels }, "float")) end
  return points, pixels
end

--- Two estimates of direct light and two along links, in `x.direct`, `x.links`; rays of a half and sets are numbers of points.
-- True, or nil, message, code.
local function estimate(x, rays, sets, round)
  local c = x.casting
  x.direct, x.links = {}, nil
  for half = 1, 2 do
    local found, count, code = check.result(x.name, x.p.lib.shade_raycast(x.p.view, { light_samples = PILOT.rays, rays = rays,
      shadows = c.shadows, seed = c.seed + STEP * (2 * round + half), threads = c.threads, progress = c.progress, lit = c.lit,
      guide = c.guide }))
    if not found then return nil, count, code end
    x.direct[half], x.report.rays.shadow = found, (x.report.rays.shadow or 0) + count
  end
  local b = x.o.reflected
  if not b then return true end
  x.links = { x.points(3), x.points(3) }
  local count, message, code = check.result(x.name, x.p.lib.shade_gather_sets(x.p.view, {
    transfer = views.made[x.p.view].links.links, lit = b.lit, sets = sets, first = x.links[1], second = x.links[2],
    seed = c.seed + STEP * (round + 7), threads = c.threads, progress = c.progress }))
  if not count then return nil, message, code end
  x.sets = (x.sets or 0) + count
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
  all = all
  local function around(pair)
    return check.result(x.name, x.p.lib.shade_noise_around(x.p.view, pair[1], pair[2], all, x.casting.threads, x.pixels(1)))
  end
  return around(d), l and around(l) or x.pixels(1)
end

--- The mean over pixels that have noise.
local function mean_of(squares, lit) return lit > 0 and squares:sum() / lit or 0 end

--- Noise and cost of counts that are `factor` times the noise of a pixel, at least and at most `bounds`.
local function weigh(x, factor)
  local function counts(noise, cost, least, most) return (noise * (factor / math.sqrt(cost))):clamp(least, most) end
  local d, l = x.noise[1], x.noise[2]
  local kd = counts(d, x.cost[1], LEAST.rays / PILOT.rays, MOST.rays / PILOT.rays)
  local kl = counts(l, x.cost[2], LEAST.sets / PILOT.sets, MOST.sets / PILOT.sets)
  local square = mean_of(d * d / kd + l * l / kl, x.lit)
  return math.sqrt(square), kd:mean() * x.cost[1] + (x.links and kl:mean() * x.cost[2] or 0)
end

--- The factor of counts: the smallest that leaves the noise that is wanted, or whose cost is at most `budget`.
local function choose(x, budget)
  local low, high = -WIDE, WIDE
  for _ = 1, 50 do
    local middle = (low + high) / 2
    local noise, cost = weigh(x, 2 ^ middle)
    if noise > AIM * x.o.noise and cost < budget then low = middle else high = middle end
  end
  return 2 ^ high
end

--- Counts of points from those of pixels.
local function spread(x, noise, cost, pilot, least, most, factor)
  return check.result(x.name, x.p.lib.shade_spread(x.p.view, noise, factor / math.sqrt(cost) * pilot, least, most, x.points()))
end

--- The cause that kept a picture from its noise, and the advice that a line gives.
local function cause_of(x, reached, seconds)
  local o = x.o
  if x.timed then
    return "time_limit", ("time_limit = %.0f would reach it"):format(math.ceil(seconds * (reached / o.noise) ^ 2))
  end
  if x.most then return "most rays", "counts of rays are at their most; more camera rays leave less" end
  return "pilot", ("the pilot met less noise than there is: noise = %.3g asks for more rays"):format(o.noise ^ 2 / reached)
end

--- One line about what was reached.
local function say(x, reached, seconds)
  local o, report = x.o, x.report
  report.noise, report.ended = reached, "noise"
  if reached <= SLACK * o.noise then return end
  local ended, advice = cause_of(x, reached, seconds)
  report.ended = ended
  report.warnings[#report.warnings + 1] = warning.say(x.p.scene, "noise", "scene %q: noise is %.1f %% of the light around a "
    .. "pixel, %.1f %% was wanted: %s", x.p.scene.name or "?", 100 * reached, 100 * o.noise, advice)
end

--- Direct light of the points of p; that of links is left in o.reflected.gathered. Or nil, message, code.
function rounds.radiance(name, p, o, report, casting)
  local start = core.seconds()
  local x = { name = name, p = p, o = o, report = report, casting = casting }
  x.casting.progress = progress.resolve(o.progress)
  x.points, x.pixels = room(p, o)
  local rays, sets = x.points(), x.points()
  rays, sets = (rays + PILOT.rays), (sets + PILOT.sets)
  local ok, message, code = estimate(x, rays, sets, 0)
  if not ok then return nil, message, code end
  local seconds = core.seconds() - start
  x.noise = { noise_of(x) }
  x.cost = { 2 * PILOT.rays, SET * PILOT.sets }
  x.lit = (x.noise[1] + x.noise[2]):not_equal(0):sum()
  local pilot = x.cost[1] + (x.links and x.cost[2] or 0)
  local left = o.time_limit and math.max(0, o.time_limit - (core.seconds() - start) - report.seconds.primary)
  local budget = left and pilot * left / math.max(seconds, 1e-3) or math.huge
  local factor = choose(x, budget)
  x.timed = left and weigh(x, factor) > o.noise
  x.most = weigh(x, 2 ^ WIDE) > o.noise
  rays = spread(x, x.noise[1], x.cost[1], PILOT.rays, LEAST.rays, MOST.rays, factor)
  sets = spread(x, x.noise[2], x.cost[2], PILOT.sets, LEAST.sets, MOST.sets, factor)
  ok, message, code = estimate(x, rays, sets, 1)
  if not ok then return nil, message, code end
  local d, l = noise_of(x)
  x.left = ((d * d + l * l) ^ 0.5)
  say(x, math.sqrt(mean_of(x.left * x.left, x.left:not_equal(0):sum())), core.seconds() - start)
  report.light_samples = 2 * rays:mean()
  if x.links then
    o.reflected.gathered = ((x.links[1] + x.links[2]) / 2)
    report.rays.sets = x.sets
  end
  o.noise_left = x.left
  return ((x.direct[1] + x.direct[2]) / 2), core.seconds() - start
end

--- Adds the layer noise.
function rounds.report(p, o, report, image)
  image:add("noise", 1)
  p.lib.path_copy(o.noise_left, image:layer "noise")
  image.metadata.noise = ("%.4g"):format(report.noise)
end

return rounds
