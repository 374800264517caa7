--- ylm.sh.exp and ylm.sh.log: exponentials and logarithms of functions given by coefficients.

local args = require "ylm.sh.args"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local progress = require "ylm.progress"

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
  { "terms", "integer", min = 1, max = core.limits.sh_exp_terms, default = 9,
    about = "powers of the function without its mean that are added up: the series of exp" },
  args.dtype, form.threads, args.out, args.progress,
}

describe "sh.exp" {
  about = "The coefficients of the exponential of a function: e^(c(0,0)/sqrt(4 pi)) times the series of what is left, each of "
    .. "whose products is cut off at lmax. Sums of logarithms (sh.log) become products.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2], lmax at most 100" }, { "options?", "table", "see the options" } },
  options = exp_options,
  returns = { { "exp", "array", "of the same shape, type and convention" } },
  errors = "raises where the series diverges, naming the row, or the result is beyond the range of its type",
  example = [[
local one = math.sqrt(4 * math.pi)                  -- the function 1
local e = ylm.sh.exp { one, 0, 0, 0 }
assert(math.abs(e[1] - one * math.exp(1)) < 1e-14)]],
  source = "Ren et al. 2006; docs/shadow_fields.md",
}
function exponential.exp(c, given)
  local o = form.options(2, "exp", exp_options, given)
  return apply("exp", c, core.limits.sh_product_lmax, core.sh_exp, o.terms, o)
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

return exponential
