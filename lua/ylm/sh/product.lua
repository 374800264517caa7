--- ylm.sh.product, ylm.sh.product_matrix and ylm.sh.apply.

local args = require "ylm.sh.args"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local library = require "ylm.library"
local progress = require "ylm.progress"

local product = {}

--- The most factors of a product by a rule that is given: they are arguments of a call.
local MOST_FACTORS = 200

--- Tables of rules, by lmax and degree; the latest are kept while the state lives.
local rules, rules_order = {}, {}

--- The nodes of a rule; nil, message, code.
function product.nodes(lmax, degree)
  local key = ("%d %d"):format(lmax, degree)
  if not rules[key] then
    local n, message, code = core.sh_nodes(lmax, degree)
    if not n then return nil, message, code end
    rules[key] = n
    rules_order[#rules_order + 1] = key
    if #rules_order > 16 then rules[table.remove(rules_order, 1)] = nil end
  end
  return rules[key]
end

-- Plans are immutable and depend on these four alone; the latest are kept while the state lives.
local plans, order = {}, {}

--- A plan, the method it uses and its number of integrals; nil, message, code.
local function plan(lmax, factors, method, inner)
  local key = ("%d %d %s %s"):format(lmax, factors, method, inner)
  local known = plans[key]
  if not known then
    local p, used, integrals = library.rival(core.sh_product_plan, lmax, factors, method, inner)
    if not p then return nil, used, integrals end
    known = { p, used, integrals }
    plans[key] = known
    order[#order + 1] = key
    if #order > 64 then plans[table.remove(order, 1)] = nil end
  end
  return known[1], known[2], known[3]
end

local methods = { "auto", "gaunt", "fourier", "quadrature", "brute", "list", "recursive" }

local product_options = {
  { "method", "choice", shelf = "comparison", of = methods, default = "auto",
    about = "auto: the fastest for the size. All are exact but 'recursive', which cuts off after every multiplication. "
      .. "'fourier', 'brute' and 'list' (two factors) are kept for comparison, in libylm_rival. "
      .. "'gaunt': (k+1)/2 lmax, rounded down to a multiple of lmax, is at most 30 for k factors" },
  { "inner", "choice", of = { "auto", "gaunt", "fourier", "quadrature", "brute", "list" }, default = "auto",
    about = "what the steps of 'recursive' are done by" },
  { "rule", "number", min = 1, max = 18, optional = true,
    about = "degree of the quadrature, times lmax: 3 serves any number of factors with an error that falls with lmax, k+1 is "
      .. "exact for k factors. Default: exact, for 16 factors at most" },
  { "stages", "boolean", default = false,
    about = "also return the seconds of transform, multiplication, transform back" },
  args.dtype, form.threads, args.out, args.progress,
}

--- The shape that all factors broadcast to: the largest number of rows, others have as many or one.
local function broadcast(list)
  local shape, rows = list[1].shape, list[1].rows
  for _, c in ipairs(list) do
    if c.rows > rows or (c.rows == rows and #c.shape > #shape) then shape, rows = c.shape, c.rows end
  end
  for i, c in ipairs(list) do
    if c.rows ~= rows and c.rows ~= 1 then
      return check.bad(i, "product", "%d rows do not fit to %d rows of another factor", c.rows, rows)
    end
  end
  return shape
end

--- Raises where a rule is given with options of other methods.
local function check_rule(o)
  if not o.rule then return end
  if o.method ~= "auto" and o.method ~= "quadrature" then
    return check.fail("product: rule is of method 'quadrature', not of '%s': leave one out", o.method)
  end
  if o.stages then return check.fail "product: stages are of a rule that is exact: leave rule out" end
end

describe "sh.product" {
  shelf = "everyday",
  about = "The coefficients of the product of two or more functions, cut off at the lmax of the factors.\n"
    .. "A factor of one row multiplies every row of the others.",
  arguments = {
    { "a", "array|table", "[..][(lmax+1)^2]" }, { "b", "array|table", "the same lmax" },
    { "...", "array|table", "more factors, 16 at most (with rule 200); then options" },
  },
  options = product_options,
  returns = { { "c", "array", "[..][(lmax+1)^2]" },
    { "seconds", "table", "with stages = true: {transform, multiplication, transform back}" } },
  errors = "raises where lmax, conventions or rows do not fit together, or a method does not do the size",
  example = [[
local z = { 0, 0, math.sqrt(4 * math.pi / 3), 0 }           -- the function z
local zz = ylm.sh.product(ylm.sh.resize(z, 2), ylm.sh.resize(z, 2))
assert(math.abs(ylm.sh.reconstruct(zz, { 0, 0.6, 0.8 }) - 0.64) < 1e-14)]],
  source = "Xin et al. 2021; docs/math.md \"Products\"",
}
function product.product(...)
  local n = select("#", ...)
  local given = { ... }
  local options = {}
  while n > 2 and given[n] == nil do n = n - 1 end -- results of a call may end in nils
  local last = given[n]
  if n > 0 and type(last) == "table" and not form.kind(last) and last[1] == nil and next(last) ~= nil then
    options, n = last, n - 1
  end
  options = form.options(n + 1, "product", product_options, options)
  local most = options.rule and MOST_FACTORS or core.limits.sh_product_factors
  if n < 2 or n > most then
    return check.fail("product: 2 to %d factors expected, got %d%s", most, n,
      n > most and not options.rule and (" (rule = 3 takes %d)"):format(MOST_FACTORS) or "")
  end
  check_rule(options)
  local list, dtype, all_small = {}, nil, options.dtype ~= "float"
  for i = 1, n do
    local c, lmax, shape, own, rows, convention, small = args.coefficients(i, "product", given[i], core.limits.sh_product_lmax, n)
    all_small = all_small and small
    list[i] = { c = c, lmax = lmax, shape = shape, rows = rows, convention = convention }
    if lmax ~= list[1].lmax then
      return check.bad(i, "product", "lmax %d does not fit to lmax %d of factor 1 (sh.resize cuts or extends)", lmax,
        list[1].lmax)
    end
    if convention ~= list[1].convention then
      return check.bad(i, "product", "convention '%s' does not fit to '%s' of factor 1: convert one",
        core.sh_convention_name(convention), core.sh_convention_name(list[1].convention))
    end
    if own == "double" or not dtype then dtype = own end
  end
  dtype = options.dtype or dtype
  local shape = broadcast(list)
  local lmax = list[1].lmax
  local p, message, code
  if options.rule then p, message, code = product.nodes(lmax, math.ceil(options.rule * lmax))
  else p, message, code = plan(lmax, n, options.method, options.inner) end
  if not p then return check.result("product", nil, message, code == "ELIMIT" and "EINVAL" or code) end
  local arrays = {}
  for i, c in ipairs(list) do arrays[i] = args.as(c.c, dtype) end
  local out
  out, message, code = args.result("product", options.out, shape, dtype, list[1].convention, arrays)
  if not out then return nil, message, code end
  local a, b, c
  if options.rule then a, b, c = core.sh_nodes_product(p, arrays, out, options.threads, progress.of(options.progress))
  else a, b, c = core.sh_product(p, arrays, out, options.threads, options.stages, progress.of(options.progress)) end
  if not a then return check.result("product", nil, b, c) end
  args.held("product", out, all_small)
  if options.stages then return out, { a, b, c } end
  return out
end

describe "sh.product_method" {
  about = "Says which method 'auto' stands for at a size, and for 'gaunt' the number of integrals that are not zero.",
  arguments = {
    { "lmax", "integer", "from 0 to 100" }, { "factors", "integer", "2 to 16" },
    { "method?", "string", "default 'auto'" },
  },
  returns = { { "method", "string", "" },
    { "integrals", "integer", "of Y_i Y_j Y_k with i <= j, any k, that the method's table holds; 0 if it uses none" } },
  errors = "raises where the sizes are out of range, or the method does not do them",
  example = [[
local method, integrals = ylm.sh.product_method(2, 2, "gaunt")
assert(method == "gaunt" and integrals == 52)]],
}
function product.product_method(lmax, factors, method)
  check.integer(1, "product_method", "lmax", lmax, 0, core.limits.sh_product_lmax)
  check.integer(2, "product_method", "factors", factors, 2, core.limits.sh_product_factors)
  method = method == nil and "auto" or method
  local known = false
  for _, name in ipairs(methods) do known = known or name == method end
  if not known then
    return check.bad(3, "product_method", "one of '%s' expected, got %s", table.concat(methods, "', '"),
      check.describe(method))
  end
  local p, used, integrals = plan(lmax, factors, method, "auto")
  if not p then return check.result("product_method", nil, used, integrals == "ELIMIT" and "EINVAL" or integrals) end
  return used, integrals
end

local matrix_options = { { "dtype", "choice", of = core.choices "dtype", default = "double",
  about = "of the matrix" } }

describe "sh.product_matrix" {
  about = "The matrix that multiplies coefficients by a function: M a are the coefficients of the product, M_ij = the "
    .. "integral of b Y_i Y_j. A shadow, a mask; apply it with sh.apply.",
  arguments = {
    { "b", "array|table", "[(blmax+1)^2], the function; degrees above 2 lmax have no effect" },
    { "lmax", "integer", "of the vectors that it multiplies, from 0 to 50" },
    { "options?", "table", "see the options" },
  },
  options = matrix_options,
  returns = { { "M", "array", "[(lmax+1)^2][(lmax+1)^2], symmetric" } },
  errors = "raises where b is no single vector or lmax is out of range",
  example = [[
local M = ylm.sh.product_matrix({ math.sqrt(4 * math.pi) }, 1)   -- multiplies by 1
assert(math.abs(M:get(2, 2) - 1) < 1e-15 and math.abs(M:get(1, 2)) < 1e-15)]],
  source = "Green 2003, Eqs. 8, 9",
}
function product.product_matrix(b, lmax, options)
  options = form.options(3, "product_matrix", matrix_options, options)
  local c, clmax, _, _, rows, convention = args.coefficients(1, "product_matrix", b)
  if rows ~= 1 then return check.bad(1, "product_matrix", "one vector of coefficients expected, got %d", rows) end
  check.integer(2, "product_matrix", "lmax", lmax, 0, core.limits.sh_product_lmax / 2)
  local n = (lmax + 1) * (lmax + 1)
  local M, message, code = args.result("product_matrix", nil, { n, n }, "double", convention)
  if not M then return nil, message, code end
  local ok
  ok, message, code = core.sh_product_matrix(args.as(c, "double"), clmax, lmax, M)
  if not ok then return check.result("product_matrix", nil, message, code) end
  local result = args.as(M, options.dtype)
  core.array_set_convention(result, 0) -- a matrix, no coefficients
  return args.held("product_matrix", result)
end

local apply_options = { form.threads, args.out, args.progress }

--- How matrices of this shape meet coefficients of that one: the period of ylm_sh_matrices_apply, the shape of the result. Nil:
-- they do not.
local function meeting(size, shape)
  local n, m, c = size[1], #size, #shape
  if m < 2 or m > 4 or size[m] ~= shape[c] then return nil end
  local out = {}
  for i = 1, m - 1 do out[i] = size[i] end
  if m == 2 then
    for i = 1, c - 1 do out[i] = shape[i] end
    out[c] = size[1]
    return 1, out
  end
  if c == 1 then return 1, out end
  if m == 3 and c == 2 and shape[1] == n then return n, out end
  if m == 3 and c == 3 and shape[1] == n then return n, { n, shape[2], size[2] } end
  if m == 4 and c == 2 and shape[1] == size[2] then return size[2], out end
  if m == 4 and c == 3 and shape[1] == n and shape[2] == size[2] then return n * size[2], out end
end

local fits = "[a][b] with c [..][b], [n][a][b] with c [b], [n][b] or [n][k][b], [n][k][a][b] with c [b], [k][b] or [n][k][b]"

describe "sh.apply" {
  about = "Applies a matrix of a product (from sh.product_matrix) to vectors of coefficients, or one of its own to each of n "
    .. "(from view:matrices). The matrices may be " .. fits .. ".",
  arguments = {
    { "M", "array", "[a][b], [n][a][b] or [n][k][a][b]; b as many as coefficients of c" },
    { "c", "array|table", "[..][(lmax+1)^2]" },
    { "options?", "table", "see the options" },
  },
  options = apply_options,
  returns = { { "c", "array", "of the shape of c with a for b, [n][a], or [n][k][a]" } },
  errors = "raises where the sizes do not fit",
  example = [[
local M = ylm.sh.product_matrix({ 1, 0.5, 0, 0.2 }, 2)
local a = { 1, 2, 3, 4, 5, 6, 7, 8, 9 }
local b = ylm.sh.resize({ 1, 0.5, 0, 0.2 }, 2)
assert(math.abs(ylm.sh.apply(M, a)[5] - ylm.sh.product(a, b)[5]) < 1e-14)]],
  source = "Green 2003, Eq. 9",
}
function product.apply(M, c, options)
  options = form.options(3, "apply", apply_options, options)
  local a, _, shape, dtype, _, convention = args.coefficients(2, "apply", c)
  local size = core.type(M) == "ylm.array" and M.shape or {}
  local period, result = meeting(size, shape)
  if not period then
    local stack = #size > 2 and (", or a stack of them that fits c of %s (%s)"):format(table.concat(shape, "x"), fits) or ""
    return check.bad(1, "apply", "a matrix of %dx%d expected%s, got %s", shape[#shape], shape[#shape], stack,
      check.describe(M))
  end
  M = args.as(M, dtype)
  local out, message, code = args.result("apply", options.out, result, dtype, convention, { a, M })
  if not out then return nil, message, code end
  local ok
  if #size == 2 and core.sh_symmetric(M) then
    ok, message, code = core.sh_apply(M, a, out, options.threads, progress.of(options.progress))
  else
    ok, message, code = core.sh_matrices_apply(M, a, out, period, options.threads, progress.of(options.progress))
  end
  if not ok then return check.result("apply", nil, message, code) end
  return args.held("apply", out)
end

return product
