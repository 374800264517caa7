--- ylm.sh.exp, ylm.sh.log and ylm.sh.circle_log: exponentials and logarithms of functions given by coefficients.

local args = require "ylm.sh.args"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local progress = require "ylm.progress"
local zonal = require "ylm.sh.zonal"

local exponential = {}

--- Coefficients c through f(c, lmax, parameter, out, threads, progress), a function of core.
local function apply(name, c, limit, f, parameter, o)
  local a, lmax, shape, own, _, convention = args.coefficients(1, name, c, limit)
  local dtype = o.dtype or own
  a = args.as(a, dtype)
  local out, message, code = args.result(name, o.out, shape, dtype, convention, { a })
  if not out then return nil, message, code end
  local ok
  ok, message, code = check.result(name, f(a, lmax, parameter, out, o.threads, progress.of(o.progress)))
  if not ok then return nil, message, code end
  return args.held(name, out)
end

local exp_options = {
  { "method", "choice", of = core.choices "sh_exp", default = "PS",
    about = "'PS': the series of exp; 'OL': a line of the function, the same for all that have as large coefficients, right for "
      .. "circles; 'HYB': the line of a part, squared until it is the whole. lmax of OL and HYB is at most 20" },
  { "terms", "integer", min = 1, max = core.limits.sh_exp_terms, optional = true,
    about = "of PS: powers of the function without its mean that are added up, default 9" },
  args.dtype, form.threads, args.out, args.progress,
}

describe "sh.exp" {
  about = "The coefficients of the exponential of a function: e^(c(0,0)/sqrt(4 pi)) times the series of what is left, each of "
    .. "whose products is cut off at lmax. Sums of logarithms (sh.log) become products.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2], lmax at most 100" }, { "options?", "table", "see the options" } },
  options = exp_options,
  returns = { { "exp", "array", "of the same shape, type and convention" } },
  errors = "raises where the series diverges, naming the row (OL and HYB do not), or the result is beyond the range of its type",
  example = [[
local one = math.sqrt(4 * math.pi)                  -- the function 1
local e = ylm.sh.exp { one, 0, 0, 0 }
assert(math.abs(e[1] - one * math.exp(1)) < 1e-14)]],
  source = "Ren et al. 2006; docs/shadow_fields.md",
}
function exponential.exp(c, given)
  local o = form.options(2, "exp", exp_options, given)
  if o.method == "PS" then return apply("exp", c, core.limits.sh_product_lmax, core.sh_exp, o.terms or 9, o) end
  if o.terms then return check.bad(2, "exp", "terms are of method 'PS': leave them out") end
  return apply("exp", c, core.limits.sh_log_lmax, core.sh_exponential, o.method, o)
end

local log_options = {
  { "epsilon", "number", above = 0, max = 0.5, default = 0.02,
    about = "values of the function below this times its largest count as this much: a visibility has zeros" },
  args.dtype, form.threads, args.out, args.progress,
}

describe "sh.log" {
  about = "The coefficients of the logarithm of a function, so that sh.exp gives the function back: by the eigenvalues of the "
    .. "matrix that multiplies by it.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2], lmax at most 20" }, { "options?", "table", "see the options" } },
  options = log_options,
  returns = { { "log", "array", "of the same shape, type and convention" } },
  errors = "raises where a function is nowhere positive, naming the row",
  example = [[
local f = { math.sqrt(4 * math.pi), 0.2, -0.1, 0.3 }
local again = ylm.sh.exp(ylm.sh.log(f), { terms = 20 })
for i = 1, 4 do assert(math.abs(again[i] - f[i]) < 0.01) end]],
  source = "Ren et al. 2006; docs/shadow_fields.md",
}
function exponential.log(c, given)
  local o = form.options(2, "log", log_options, given)
  return apply("log", c, core.limits.sh_log_lmax, core.sh_log, o.epsilon, o)
end

local circle_options = {
  { "epsilon", "number", above = 0, max = 0.5, default = 0.02, about = "as of sh.log" },
}

describe "sh.circle_log" {
  about = "The logarithm of what a circle leaves open, 0 inside of it and 1 outside: of a sphere that hides light. It is that "
    .. "of sh.log, at the cost of the third power of lmax, since the function is symmetric about the circle's middle.",
  arguments = {
    { "lmax", "integer", "at most 100" }, { "direction", "table", "{x, y, z} of the middle, any length but 0" },
    { "angle", "number", "half the angle of the circle, 0 to pi, radians" }, { "options?", "table", "see the options" },
  },
  options = circle_options,
  returns = { { "log", "array", "[(lmax+1)^2]" }, { "zonal", "array", "[lmax+1]: of a circle about z" } },
  errors = "raises on an angle or a direction that is none, and where the circle leaves nothing open",
  example = [[
local log = ylm.sh.circle_log(3, { 0, 0, 1 }, math.pi / 4)
local open = ylm.sh.exp(log, { method = "OL" })          -- a line is exact for circles
assert(math.abs(open[1] / math.sqrt(4 * math.pi) - (1 + math.cos(math.pi / 4)) / 2) < 1e-3)]],
  source = "Ren et al. 2006; docs/shadow_fields.md",
}
function exponential.circle_log(lmax, direction, angle, given)
  check.integer(1, "circle_log", "lmax", lmax, 0, core.limits.sh_product_lmax)
  if not check.is_number(angle) or not (angle >= 0 and angle <= math.pi) then
    return check.bad(3, "circle_log", "angle must be a number >= 0 and <= pi, got %s", check.describe(angle))
  end
  local o = form.options(4, "circle_log", circle_options, given)
  local good, wanted = form.types.vector(direction)
  if not good then
    return check.bad(2, "circle_log", "direction must be %s, got %s", wanted, check.describe(direction))
  end
  local z, message, code = check.result("circle_log", core.sh_circle_log(lmax, angle, o.epsilon))
  if not z then return nil, message, code end
  return zonal.zonal(z, good), z
end

return exponential
