--- Lamps that are found for light that is asked for: scene:inverse_lighting; ylm.minimise.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local lamps = require "ylm.transfer.lamps"
local minimise = require "ylm.inverse.minimise"
local objects = require "ylm.transfer.object"
local plans = require "ylm.inverse.plan"
local progress = require "ylm.progress"
local scenes = require "ylm.scene"
local show = require "ylm.show"
local targets = require "ylm.inverse.targets"
local tracing = require "ylm.trace"
local vary = require "ylm.inverse.vary"

local inverse = { minimise = minimise.minimise }

local PRICE = 1e-2                                -- of all lamps at full power, beside requirements
local MARGIN = { mean = 0.004, uniformity = 0.01 } -- that is asked for more
local ROUNDS = 3                                  -- of paths that judge, and searches after it
local FIRST = 0.6                                 -- of the evaluations, before paths judge
local FLAT = 2e-3                                 -- gains that end a search, relative
local SCALE = 15                                  -- elements along the scene's diagonal
local MOVED = 0.35                                -- of the range of a place, by further starts

local prices = {
  lumens = function(l) return l.flux end,
  watts = function(l) return l.light.photometry and l.light.photometry.watts end,
}

-- One search ------------------------------------------------------------------------------------------------------

--- Links, targets, numbers and prices of a search; nil, message, code.
local function open(s, o)
  local work = { scene = s, options = o, margin = { mean = MARGIN.mean, uniformity = MARGIN.uniformity }, evaluations = 0,
    rays = 0, trace = {} }
  local message, code
  work.plan = vary.plan(o.vary, s.lights)
  work.links = o.links
  if not work.links then
    local t
    t, message, code = tracing.trace("inverse_lighting", s)
    if not t then return nil, message, code end
    local coarse = math.max(box.diagonal(t.lo, t.hi) / SCALE, 1e-6)
    work.links, message, code = s:links { spacing = o.spacing or coarse, rays = o.rays, lmax = 0,
      seed = o.seed, threads = o.threads, progress = o.progress }
    if not work.links then return nil, message, code end
  end
  work.targets, message, code = targets.open(o.targets, work.links, o)
  if not work.targets then return nil, message, code end
  work.price, work.full = {}, 0
  if o.price then
    for k, l in ipairs(work.plan.lamps) do
      work.price[k] = prices[o.price](l)
      if not work.price[k] then
        return check.fail("inverse_lighting: price = '%s': the photometry of light %d has no %s", o.price, k, o.price)
      end
      work.full = work.full + work.price[k]
    end
  end
  return work
end

local radiosity_fields = { "light_samples", "rim", "threads", "seed" }

--- Lights the links by a list of lights: lit, or nil, message, code.
local function light(work, lights)
  local o, message, code = { derivatives = true }
  for _, name in ipairs(radiosity_fields) do o[name] = work.options[name] end
  if work.lit then work.lit, message, code = work.lit:update(lights)
  else work.lit, message, code = work.links:radiosity(lights, o) end
  if not work.lit then return nil, message, code end
  work.rays = work.rays + work.lit.stats.rays
  return work.lit
end

--- Illuminances of each target, lists; nil, message, code.
local function illuminances(work)
  local out = {}
  for i, t in ipairs(work.targets) do
    local E, message, code = t.receivers[t.coloured and "irradiance" or "illuminance"](t.receivers, work.lit)
    if not E then return nil, message, code end
    out[i] = targets.list(t, E)
  end
  return out
end

--- The value of all targets for illuminances, and its derivatives by them.
local function value_of(work, F)
  local value, weights = 0, {}
  for i, t in ipairs(work.targets) do
    local more
    more, weights[i] = targets.value(t, F[i], work.margin)
    value = value + more
  end
  return value, weights
end

--- Adds the price of the numbers x, and what lamps are too near to one another, to a value and its gradient.
local function add_price(work, x, value, gradient)
  for i, n in ipairs(work.plan.numbers) do
    for _, k in ipairs(work.full > 0 and n.shares and n.lamps or {}) do
      local slope = PRICE * n.shares[k] * work.price[k] / work.full
      value, gradient[i] = value + slope * x[i], gradient[i] + slope
    end
  end
  local apart = work.options.apart
  return apart and value + vary.crowd(work.plan, x, apart, gradient) or value
end

--- Keeps the figures at x, and the best value so far.
local function note(work, x, F, value)
  work.evaluations = work.evaluations + 1
  local entry = { value = value, targets = {} }
  for i, t in ipairs(work.targets) do entry.targets[i] = targets.figures(t, F[i]) end
  work.trace[#work.trace + 1] = entry
  work.first = work.first or F
  if not work.best or value < work.best.value then work.best = { value = value, x = x, F = F } end
end

--- Do illuminances meet what is asked, margins included?
local function is_enough(work, F)
  for i, t in ipairs(work.targets) do
    local f = targets.figures(t, F[i])
    local least = t.mean and t.mean.least
    local most = t.mean and t.mean.most
    if least and f.mean < least * (1 + work.margin.mean / 2) or most and f.mean > most then return false end
    if t.uniformity and f.uniformity < math.min(0.999, t.uniformity + work.margin.uniformity / 2) then return false end
    if t.least and f.least < t.least or t.most and f.most > t.most then return false end
  end
  return true
end

--- The value and gradient at x by light on the links.
local function by_light(work, x)
  local lights = vary.lights(work.plan, x)
  local lit, message, code = light(work, lights)
  if not lit then return nil, message, code end
  local F
  F, message, code = illuminances(work)
  if not F then return nil, message, code end
  local value, weights = value_of(work, F)
  local terms = {}
  for i, t in ipairs(work.targets) do terms[i] = { t.receivers, weights = targets.weights(t, weights[i]) } end
  local importance
  importance, message, code = lit:importance(terms)
  if not importance then return nil, message, code end
  local d
  d, message, code = importance:derivatives { threads = work.options.threads }
  if not d then return nil, message, code end
  local lists = {}
  for _, name in ipairs { "position", "direction", "turn", "dim", "colour", "channels", "factor" } do
    lists[name] = d[name]:totable()
  end
  local gradient = vary.gradient(work.plan, lists, x)
  value = add_price(work, x, value, gradient)
  note(work, x, F, value)
  work.F = F
  return value, gradient
end

-- Levels alone: light is linear -----------------------------------------------------------------------------------

--- The illuminances that each level brings at 1, and those of all that does not change; nil, message, code.
local function matrix(work)
  local numbers, varied, columns = work.plan.numbers, {}, {}
  for _, n in ipairs(numbers) do for _, k in ipairs(n.lamps) do varied[k] = true end end
  local function column(x, keep)
    local lights, chosen = vary.lights(work.plan, x), {}
    for k, l in ipairs(lights) do if keep(k) then chosen[#chosen + 1] = l end end
    if #chosen == 0 then return false end
    local lit, message, code = light(work, chosen)
    if not lit then return nil, message, code end
    return illuminances(work)
  end
  local function unit(i)
    local x = {}
    for k = 1, #numbers do x[k] = k == i and 1 or 0 end
    return x
  end
  local rest, message, code = column(unit(1), function(k) return not varied[k] end)
  if rest == nil then return nil, message, code end
  for i, n in ipairs(numbers) do
    local own = {}
    for _, k in ipairs(n.lamps) do own[k] = true end
    columns[i], message, code = column(unit(i), function(k) return own[k] end)
    if not columns[i] then return nil, message, code end
  end
  return { rest = rest, columns = columns }
end

--- The value and gradient at levels x, by their matrix.
local function by_matrix(work, x)
  local m, F, gradient = work.matrix, {}, {}
  for i = 1, #work.targets do
    F[i] = {}
    for r = 1, #m.columns[1][i] do
      local sum = m.rest and m.rest[i][r] or 0
      for k = 1, #x do sum = sum + x[k] * m.columns[k][i][r] end
      F[i][r] = sum
    end
  end
  local value, weights = value_of(work, F)
  for k = 1, #x do
    gradient[k] = 0
    for i = 1, #work.targets do
      for r = 1, #F[i] do gradient[k] = gradient[k] + weights[i][r] * m.columns[k][i][r] end
    end
  end
  value = add_price(work, x, value, gradient)
  work.F = F
  if not work.best or value < work.best.value then work.best = { value = value, x = x, F = F } end
  work.first = work.first or F
  return value, gradient
end

local function are_levels(work)
  for _, n in ipairs(work.plan.numbers) do if not n.shares then return false end end
  return true
end

-- Searches, and paths that judge them -----------------------------------------------------------------------------

--- Searches from x: where it ended, and why; or nil, message, code. `quick`: until the requirement is met.
local function search(work, x, evaluations, quick)
  local _, lower, upper = vary.starts(work.plan)
  local levels = work.matrix ~= nil
  work.best = nil -- margins and weights may have changed
  local function f(y) return (levels and by_matrix or by_light)(work, y) end
  local found, report, code = minimise.of(f, x, { lower = lower, upper = upper, evaluations = levels and 2000 or evaluations,
    tolerance = levels and 1e-9 or FLAT, step = 0.5, progress = levels and false or work.options.progress,
    enough = not levels and quick and function() return is_enough(work, work.F) end or nil })
  if not found then return nil, report, code end
  if work.best and work.best.value <= report.value then return work.best.x, report.ended end
  return found, report.ended
end

--- Figures of each target by paths under lights x, with the noise of a place, relative; nil, message, code.
local function judged(work, x, samples)
  local scene = scenes.scene(work.scene.name) { geometry = work.scene.geometry, lights = vary.lights(work.plan, x) }
  local out = {}
  for i, t in ipairs(work.targets) do
    local m = t.receivers
    local points, normals, fold = objects.places_of(m)
    local E, variance, report = scene:probe { points = points, normals = normals, samples = samples,
      seed = work.options.seed + 77, threads = work.options.threads, progress = work.options.progress }
    if not E then return nil, variance, report end
    local F = targets.folded(t, E, fold)
    out[i] = targets.figures(t, F)
    out[i].F = F
    out[i].noise = math.sqrt(objects.luminance_of(variance, t.count, fold):mean()) / math.max(1e-300, out[i].mean)
  end
  return out
end

local function all_met(list)
  for _, f in ipairs(list) do if not f.met then return false end end
  return true
end

--- Raises margins by what links said too much of, and levels by what the mean lacks; the new x.
local function corrected(work, x, by_links, by_paths)
  local factor, out = 1, {}
  for i, t in ipairs(work.targets) do
    local a, b = by_links[i], by_paths[i]
    if t.uniformity and b.uniformity < t.uniformity then
      work.margin.uniformity = work.margin.uniformity + math.max(0, a.uniformity - b.uniformity) + 0.003
    end
    if t.mean and t.mean.least and b.mean < t.mean.least * (1 + MARGIN.mean / 2) then
      factor = math.max(factor, t.mean.least * (1 + MARGIN.mean / 2) / b.mean)
      work.margin.mean = math.max(work.margin.mean, a.mean / b.mean * (1 + MARGIN.mean) - 1)
    end
    if t.least and b.least < t.least or t.most and b.most > t.most then work.margin.uniformity = work.margin.uniformity + 0.01 end
    if not b.met then t.weight = t.weight * 3 end
  end
  for i, n in ipairs(work.plan.numbers) do out[i] = n.shares and math.min(n.upper, x[i] * factor) or x[i] end
  return out, factor
end

local function figures_of(work, F)
  local out = {}
  for i, t in ipairs(work.targets) do out[i] = targets.figures(t, F[i]) end
  return out
end

--- A result by links whose levels bring the mean that is asked for, where levels vary: prices leave it a little short.
local function scaled(work, out)
  local by_links = figures_of(work, out.F)
  local x, factor = corrected(work, out.x, by_links, by_links)
  if factor == 1 then return out end
  local value, message, code = (work.matrix and by_matrix or by_light)(work, x)
  if not value then return nil, message, code end
  return { x = x, ended = out.ended, F = work.F, value = value }
end

--- A result that is met and was cut short, gone on with for a lower price while that is met too; nil, message, code.
local function cheaper(work, out)
  local o = work.options
  local left = o.evaluations - work.evaluations
  if out.ended ~= "evaluations" or left < 1 or work.full == 0 then return out end
  local found, ended, code = search(work, out.x, left)
  if not found then return nil, ended, code end
  local new = { x = found, ended = ended, F = work.best.F, value = work.best.value }
  local message
  new.judged, message, code = judged(work, found, o.judge)
  if not new.judged then return nil, message, code end
  return all_met(new.judged) and new or out
end

--- From a start: searches, judged by paths and gone on with until they meet what is wanted. { x, ended, F, judged }, or nil,
-- message, code.
local function attempt(work, x)
  local o = work.options
  local budget, out = o.evaluations, nil
  local first = targets.have_limits(work.targets) and math.ceil(FIRST * budget) or budget
  for round = 1, ROUNDS do
    local left = budget - work.evaluations
    local found, ended, code = search(work, x, math.max(1, round == 1 and first or left), round > 1)
    if not found then return nil, ended, code end
    out = { x = found, ended = ended, F = work.best.F, value = work.best.value }
    if ended == "cancelled" then return out end
    if o.judge == 0 then return scaled(work, out) end
    local message
    out.judged, message, code = judged(work, found, o.judge)
    if not out.judged then return nil, message, code end
    local factor
    if all_met(out.judged) then
      if not targets.have_limits(work.targets) then return out end
      out, message, code = cheaper(work, out)
      if not out then return nil, message, code end
      out.ended = out.ended == "evaluations" and "met" or "met and flat"
      return out
    end
    x, factor = corrected(work, found, figures_of(work, out.F), out.judged)
    if factor > 1 and not work.matrix then -- levels alone may be all that lacks
      local again
      again, message, code = judged(work, x, o.judge)
      if not again then return nil, message, code end
      if all_met(again) then
        out.x, out.judged, out.ended = x, again, "met"
        return out
      end
    end
    if not work.matrix and work.evaluations >= budget then
      out.ended = "evaluations"
      return out
    end
  end
  return out
end

-- The function ----------------------------------------------------------------------------------------------------

local function random(seed)
  local state = seed % 2147483647
  return function()
    state = (state * 16807 + 1) % 2147483647
    return state / 2147483647
  end
end

--- Bounds that hold, as sentences.
local function active(work, x)
  local list = {}
  for i, n in ipairs(work.plan.numbers) do
    local at = x[i] <= n.lower and n.lower or x[i] >= n.upper and n.upper
    if at and n.upper > n.lower then
      local k = n.lamps[1]
      local name = work.plan.lights[k].name
      list[#list + 1] = ("light %d%s: %s at %g"):format(k, name and " (" .. name .. ")" or "", n.name, at * (n.scale or 1))
    end
  end
  return list
end

--- The three darkest places of a target, relative to its mean.
local function hardest(t, F)
  local order, out, points = {}, {}, t.receivers.points:totable()
  F = targets.luminances(t, F)
  for r = 1, t.count do order[r] = r end
  table.sort(order, function(a, b) return F[a] < F[b] or F[a] == F[b] and a < b end)
  for i = 1, math.min(3, t.count) do out[i] = { at = points[order[i]], illuminance = F[order[i]] } end
  return out
end

local function sum_of(list, what)
  local sum = 0
  for _, l in ipairs(list) do
    local one = what(l)
    if one then sum = sum + one * l.dim end
  end
  return sum
end

local function report_of(work, best, started, values)
  local before, after = work.plan.lamps, lamps.list("inverse_lighting", vary.lights(work.plan, best.x))
  local by_links, first, report = figures_of(work, best.F), figures_of(work, work.first), {}
  report.targets = {}
  for i, t in ipairs(work.targets) do
    local f = best.judged and best.judged[i] or by_links[i]
    report.targets[i] = show.report { name = t.name, mean = f.mean, least = f.least, most = f.most, uniformity = f.uniformity,
      rms = f.rms, met = f.met, noise = f.noise, judged = best.judged and "paths" or "links", by_links = by_links[i],
      before = first[i], hardest = hardest(t, f.F or best.F[i]) }
  end
  report.met = all_met(report.targets)
  report.evaluations, report.ended, report.rays = work.matrix and 1 or work.evaluations, best.ended, work.rays
  report.lumens, report.lumens_before = sum_of(after, prices.lumens), sum_of(before, prices.lumens)
  report.watts = sum_of(after, prices.watts)
  report.active, report.starts = active(work, best.x), #values > 1 and values or nil
  report.elements, report.seconds = work.links.stats.elements, core.seconds() - started
  report.notes = work.links.notes
  return show.report(report)
end

local options = {
  { "vary", "table", about = "a list of { lights = name, beginning of names, number or list; position = { 'x', 'z' }, within = "
    .. "{ corner, corner }; dim = { least, most }; direction = degrees; turn, colour, temperature, size = { least, most }; "
    .. "together = true: one number for all of these }" },
  { "targets", "table", about = "a list of { plane | points | mesh | receivers; mean = { least =, most = }, uniformity, least, "
    .. "most; image: what a plane shall look like, brightness aside; wanted: [n] illuminances; colour = true: both in colour; "
    .. "weight, name }" },
  { "price", "choice", of = { "lumens", "watts", "none" }, default = "lumens", about = "what is kept small beside" },
  { "apart", "number", above = 0, optional = true, unit = "scene units",
    about = "how far lamps whose place varies are to be from one another" },
  { "evaluations", "integer", min = 1, max = 10000, default = 40, about = "of light and its derivatives, at most" },
  { "starts", "integer", min = 1, max = 100, default = 1,
    about = "how many times: further ones with places moved at random; the best is kept" },
  { "links", "object", of = "ylm.links", optional = true, about = "of the scene, instead of spacing and rays" },
  { "spacing", "number", above = 0, optional = true, unit = "scene units",
    about = "of elements that light bounces between; default: a fifteenth of the scene's diagonal" },
  { "rays", "links", default = 64, about = "of an element" },
  { "receiver_rays", "links", default = 1024, about = "of a place of targets" },
  { "light_samples", "integer", min = 4, max = 4096, default = 16, about = "rays of an element to each lamp, even" },
  { "receiver_samples", "integer", min = 4, max = 4096, default = 64, about = "rays of a place of targets to each lamp" },
  { "rim", "integer", min = 0, max = 4096, default = 8, about = "as of links:radiosity" },
  { "judge", "integer", min = 0, max = 1048576, default = 4096,
    about = "paths of each place that judge the result; 0: links do" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  form.threads,
  form.progress,
}

describe "scene:inverse_lighting" {
  about = "Looks for lamps that bring the light that is asked for: their places, directions, turns, levels, colours and sizes, "
    .. "within bounds. "
    .. "Derivatives by the lamps drive the search, and paths judge its result. Levels alone are found by a matrix "
    .. "of the light of each lamp.",
  arguments = { { "options", "table", "vary and targets are needed" } },
  options = options,
  returns = {
    { "plan", "plan", "plan.lights, plan.scene, plan.trace; plan:figure(), plan:save 'planned.lua'" },
    { "report", "table", "met: everything that is asked for, by the judge; targets[i]: mean, least, most, lx, uniformity, rms "
      .. "(of an image or of wanted, relative), met, noise (of a place, relative), by_links, before, hardest (the three darkest "
      .. "places); evaluations; ended: 'met and flat', 'met', 'evaluations', 'flat', 'no descent', 'cancelled'; lumens, "
      .. "lumens_before, watts; active: bounds that hold; starts; rays; elements; seconds; notes" },
  },
  errors = "raises on a bad option, names of no light, points whose place varies, and lights without derivatives; nil, message, "
    .. "code: memory, cancelled before the first evaluation",
  example = [[
local lamp = ylm.photometry { cosine = 1, lumens = 3000 }
local room = ylm.scene "a room" {
  geometry = { ylm.box { scale = 4, material = ylm.matte { albedo = 0.5 } } },
  lights = { ylm.photometric_light { photometry = lamp, at = { -1, 1.8, 0 } },
    ylm.photometric_light { photometry = lamp, at = { 1, 1.8, 0 } } },
}
local plan, report = room:inverse_lighting {
  vary = { { dim = { 0, 2 } } },
  targets = { { plane = { at = { 0, -1, 0 }, size = { 3, 3 } }, mean = { least = 300 } } },
  judge = 256,
}
assert(report.met and plan.lights[1].dim < 1)]],
  source = "Schoeneman et al. 1993; Smits, Arvo & Salesin 1992",
}
function inverse.inverse_lighting(s, given)
  local started = core.seconds()
  tracing.check_scene("inverse_lighting", s)
  local o = form.options(1, "inverse_lighting", options, given)
  o.progress = progress.long(o.progress)
  if o.price == "none" then o.price = nil end
  if o.light_samples % 2 == 1 or o.rim % 2 == 1 then return check.fail "inverse_lighting: light_samples and rim must be even" end
  if o.links and o.links.scene ~= s then return check.fail "inverse_lighting: the links are of another scene" end
  local work, message, code = open(s, o)
  if not work then return nil, message, code end
  if are_levels(work) then
    work.matrix, message, code = matrix(work)
    if not work.matrix then return nil, message, code end
  end
  local best, values, next_random, trace = nil, {}, random(o.seed), nil
  for start = 1, work.matrix and 1 or o.starts do
    work.trace, work.evaluations = {}, 0
    work.margin = { mean = MARGIN.mean, uniformity = MARGIN.uniformity }
    local x = vary.starts(work.plan, start > 1 and function() return MOVED * (2 * next_random() - 1) end or nil)
    local found
    found, message, code = attempt(work, x)
    if not found then return nil, message, code end
    values[start] = found.value
    local better = not best or (found.judged and all_met(found.judged) and 0 or 1) + found.value
      < (best.judged and all_met(best.judged) and 0 or 1) + best.value
    if better then best, trace = found, work.trace end
  end
  local report = report_of(work, best, started, values)
  return plans.create(work, best, trace, report), report
end

return inverse
