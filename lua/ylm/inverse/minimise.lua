--- The least value of a function of bounded numbers: ylm.minimise.
--
-- Quasi-Newton steps of limited memory on the numbers that no bound holds, along their path projected into the bounds.

local check = require "ylm.check"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local progress = require "ylm.progress"
local show = require "ylm.show"

local minimise = {}

local ARMIJO, HALVINGS, CURVATURE = 1e-4, 16, 1e-12

-- Vectors ---------------------------------------------------------------------------------------------------------

local function dot(a, b)
  local sum = 0
  for i = 1, #a do sum = sum + a[i] * b[i] end
  return sum
end

local function clamped(x, o)
  local out = {}
  for i = 1, #x do out[i] = math.max(o.lower[i], math.min(o.upper[i], x[i])) end
  return out
end

--- Is number i held by a bound: at it, and the value falls beyond?
local function is_held(x, g, i, o) return x[i] <= o.lower[i] and g[i] > 0 or x[i] >= o.upper[i] and g[i] < 0 end

--- The gradient without the numbers that bounds hold.
local function free_part(x, g, o)
  local out = {}
  for i = 1, #x do out[i] = is_held(x, g, i, o) and 0 or g[i] end
  return out
end

-- Steps -----------------------------------------------------------------------------------------------------------

--- The direction of the inverse Hessian that the last steps tell, on free numbers (two loops).
local function direction(free, pairs_of)
  local q, a = {}, {}
  for i = 1, #free do q[i] = free[i] end
  local function masked(v)
    local out = {}
    for i = 1, #v do out[i] = free[i] == 0 and 0 or v[i] end
    return out
  end
  local used = {}
  for k = #pairs_of, 1, -1 do
    local s, y = masked(pairs_of[k].s), masked(pairs_of[k].y)
    local sy = dot(s, y)
    if sy > CURVATURE * dot(y, y) then
      used[#used + 1] = { s = s, y = y, sy = sy }
      local u = used[#used]
      u.a = dot(s, q) / sy
      for i = 1, #q do q[i] = q[i] - u.a * y[i] end
    end
  end
  local scale = used[1] and used[1].sy / dot(used[1].y, used[1].y) or 1
  for i = 1, #q do q[i] = q[i] * scale end
  for k = #used, 1, -1 do
    local u = used[k]
    local b = dot(u.y, q) / u.sy
    for i = 1, #q do q[i] = q[i] + (u.a - b) * u.s[i] end
  end
  for i = 1, #q do a[i] = -q[i] end
  return a, #used
end

--- f at x: value and gradient as lists of numbers; nil, message where it fails or gives what is no number.
local function evaluate(f, x, state)
  local value, gradient, code = f(x)
  if value == nil then return nil, gradient, code end
  if not check.is_number(value) then
    return check.fail("minimise: the value is %s, a finite number is wanted", check.describe(value))
  end
  gradient = check.plain(gradient)
  if type(gradient) ~= "table" or #gradient ~= #x then
    return check.fail("minimise: the gradient must be %d numbers, got %s", #x, check.describe(gradient))
  end
  for i = 1, #x do
    if not check.is_number(gradient[i]) then
      return check.fail("minimise: number %d of the gradient is %s", i, check.describe(gradient[i]))
    end
  end
  state.evaluations = state.evaluations + 1
  state.trace[#state.trace + 1] = value
  return value, gradient
end

--- A step that lowers the value by as much as its slope lets expect: x, value, gradient, "stuck" where there is none, or nil,
-- message, code.
local function search(f, at, way, o, state)
  local t = 1
  for _ = 1, HALVINGS do
    if state.evaluations >= o.evaluations then return "spent" end
    local x, fall = {}, 0
    for i = 1, #way do x[i] = at.x[i] + t * way[i] end
    x = clamped(x, o)
    for i = 1, #x do fall = fall + at.gradient[i] * (x[i] - at.x[i]) end
    local value, gradient, code = evaluate(f, x, state)
    if value == nil then return nil, gradient, code end
    if state.report and state.report(state.evaluations, o.evaluations) == false then return "cancelled" end
    if value <= at.value + ARMIJO * fall + o.noise then return { x = x, value = value, gradient = gradient } end
    local bend = value - at.value - fall -- of a parabola through both values and the slope
    t = t * math.max(0.1, math.min(0.5, bend > 0 and -fall / (2 * bend) or 0.5))
  end
  return "stuck"
end

local function remember(list, at, new, o)
  local s, y = {}, {}
  for i = 1, #at.x do s[i], y[i] = new.x[i] - at.x[i], new.gradient[i] - at.gradient[i] end
  list[#list + 1] = { s = s, y = y }
  if #list > o.memory then table.remove(list, 1) end
end

--- Steps from `at` until there are no more: the last place, and why; or nil, message, code.
local function walk(f, at, o, state)
  local list, best, flat = {}, at, 0
  while true do
    local free = free_part(at.x, at.gradient, o)
    local size = math.sqrt(dot(free, free))
    state.slope = size
    if size <= o.slope then return best, "flat" end
    local way, used = direction(free, list)
    if used == 0 then
      local first = math.min(1, o.step / size)
      for i = 1, #way do way[i] = -first * free[i] end
    end
    local fall = -dot(way, at.gradient)
    if fall <= 0 then list = {} end
    if fall > 0 then
      local new, message, code = search(f, at, way, o, state)
      if new == nil then return nil, message, code end
      if new == "spent" then return best, "evaluations" end
      if new == "cancelled" then return best, "cancelled" end
      if new == "stuck" and used == 0 then return best, "no descent" end
      if new == "stuck" then list = {}
      else
        remember(list, at, new, o)
        flat = at.value - new.value <= o.tolerance * math.max(1e-300, math.abs(new.value)) + o.noise and flat + 1 or 0
        at = new
        if at.value < best.value then best = at end
        if flat >= 3 then return best, "flat" end
        if o.enough and o.enough(at.x, at.value) then return at, "enough" end
      end
    end
  end
end

local options = {
  { "lower", "any", optional = true, about = "a number, or one for each; default: no bound" },
  { "upper", "any", optional = true, about = "as lower" },
  { "evaluations", "integer", min = 1, max = 1e6, default = 200, about = "of value and gradient, at most" },
  { "memory", "integer", min = 1, max = 100, default = 10, about = "steps that curvature is known from" },
  { "tolerance", "number", min = 0, default = 1e-10, about = "three steps that lower the value by less, relative, are the last" },
  { "slope", "number", min = 0, default = 1e-9, about = "a gradient of this length, bounds aside, ends the search" },
  { "noise", "number", min = 0, default = 0, about = "of the value: steps may raise it by as much" },
  { "step", "number", above = 0, default = 1, about = "the longest first step" },
  { "enough", "function", optional = true, about = "enough(x, value) is true where the search may end" },
  form.progress,
}

--- A bound for each of n numbers.
local function bounds(name, given, n, default)
  local list = {}
  given = check.plain(given)
  for i = 1, n do
    local b = default
    if type(given) == "table" then b = given[i] elseif given ~= nil then b = given end
    if type(b) ~= "number" or b ~= b then
      return check.fail("minimise: %s must be a number, or %d of them, got %s", name, n, check.describe(given))
    end
    list[i] = b
  end
  return list
end

describe "minimise" {
  about = "Looks for numbers x within bounds that make a value least, by its gradient: projected quasi-Newton steps of limited "
    .. "memory. The value may be noisy.",
  arguments = {
    { "f", "function", "f(x) returns the value and its gradient, a list; x is a list of numbers. nil, message, code ends the "
      .. "search" },
    { "x", "number[]", "where it starts; clamped to the bounds" },
    { "options?", "table", "" },
  },
  options = options,
  returns = { { "x", "number[]", "the best that was found" }, { "report", "table", "value; evaluations; ended: 'flat' (gradient "
    .. "or gains), 'evaluations', 'no descent', 'enough', 'cancelled'; slope; trace: the value of each evaluation" } },
  errors = "raises on a bad option, lower above upper, and a value or gradient that is no finite number; nil, message, "
    .. "code: f's own",
  example = [[
local x, report = ylm.minimise(function(x)
  return (x[1] - 3) ^ 2 + (x[2] + 1) ^ 2, { 2 * (x[1] - 3), 2 * (x[2] + 1) }
end, { 0, 0 }, { upper = { 2, 5 }, lower = -4 })
assert(x[1] == 2 and math.abs(x[2] + 1) < 1e-6 and report.ended == "flat")]],
  source = "Byrd et al. 1995; Bertsekas 1982",
}
function minimise.minimise(f, x, given)
  if type(f) ~= "function" then return check.bad(1, "minimise", "a function expected, got %s", check.describe(f)) end
  return minimise.of(memory.users(f), x, given)
end

--- ylm.minimise for functions of ylm itself.
function minimise.of(f, x, given)
  x = check.plain(x)
  if type(x) ~= "table" or #x == 0 then
    return check.bad(2, "minimise", "a list of numbers expected, got %s", check.describe(x))
  end
  for i = 1, #x do
    if not check.is_number(x[i]) then return check.fail("minimise: number %d of x is %s", i, check.describe(x[i])) end
  end
  local o = form.options(3, "minimise", options, given)
  if o.enough then o.enough = memory.users(o.enough) end
  o.lower, o.upper = bounds("lower", o.lower, #x, -math.huge), bounds("upper", o.upper, #x, math.huge)
  for i = 1, #x do
    if o.lower[i] > o.upper[i] then
      return check.fail("minimise: lower %g is above upper %g at number %d", o.lower[i], o.upper[i], i)
    end
  end
  local show_progress = progress.resolve(o.progress)
  local state = { evaluations = 0, trace = {},
    report = show_progress and function(done, total) return show_progress(done, total, "plan") end }
  local start = clamped(x, o)
  local value, gradient, code = evaluate(f, start, state)
  if value == nil then return nil, gradient, code end
  local best, ended
  best, ended, code = walk(f, { x = start, value = value, gradient = gradient }, o, state)
  if best == nil then return nil, ended, code end
  return best.x, show.report { value = best.value, evaluations = state.evaluations, ended = ended, slope = state.slope,
    trace = state.trace }
end

return minimise
