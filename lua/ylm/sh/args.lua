--- Checks that the toolbox of ylm.sh shares: coefficient arguments, results, element types.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local progress = require "ylm.progress"

local args = {}

--- lmax of a number of coefficients, or nil.
function args.lmax_of(count)
  local l = math.floor(math.sqrt(count) + 0.5) - 1
  if l >= 0 and l <= core.limits.sh_lmax and (l + 1) * (l + 1) == count then return l end
end

--- Argument `n` as coefficients [..][(lmax+1)^2]: array, lmax, shape, dtype, rows, convention.
-- `limit` is the highest lmax allowed; conventions are left to the caller.
function args.any_coefficients(n, name, value, limit)
  local c = array.rows(n, name, "coefficients", value)
  local shape, dtype, convention = core.array_info(c)
  local count = shape[#shape]
  local lmax = args.lmax_of(count)
  if not lmax then
    return check.bad(n, name, "(lmax+1)^2 coefficients expected in the last axis, got %d", count)
  end
  if limit and lmax > limit then
    return check.bad(n, name, "lmax up to %d expected, got %d", limit, lmax)
  end
  local rows = 1
  for i = 1, #shape - 1 do rows = rows * shape[i] end
  return c, lmax, shape, dtype, rows, convention
end

--- Are all numbers finite, and so small that sums of the products of `powers` (1) of them cannot overflow?
function args.are_small(c, dtype, powers)
  return core.array_within(c, 10 ^ ((dtype == "double" and 290 or 25) / (powers or 1)))
end

--- args.any_coefficients that also refuses other systems than ylm's (quantity and axes may be any) and numbers that are not
-- finite. The last result says whether sums of products of `powers` (1) of them stay within the range of their type.
function args.coefficients(n, name, value, limit, powers)
  local c, lmax, shape, dtype, rows, convention = args.any_coefficients(n, name, value, limit)
  if convention % 32 ~= 0 then
    return check.bad(n, name, "coefficients are of convention '%s': convert them to 'ylm' first",
      core.sh_convention_name(convention))
  end
  local small, finite, where = args.are_small(c, dtype, powers), true, nil
  if not small then finite, where = core.array_finite(c) end
  if not finite then
    return check.bad(n, name, "coefficients: row %d is not finite", math.floor((where - 1) / shape[#shape]) + 1)
  end
  return c, lmax, shape, dtype, rows, convention, small
end

local extents = require "ylm.outputs".extents

--- An array for results: `out` if it fits, else a new one. `sources` are arrays that are read while it is written.
function args.result(name, out, shape, dtype, convention, sources)
  if out == nil then
    local a, message, code = check.result(name, core.array_zeros(shape, dtype))
    if not a then return nil, message, code end
    core.array_set_convention(a, convention or 0)
    return a
  end
  if core.type(out) ~= "ylm.array" then
    return check.fail("%s: out must be an array, got %s", name, check.describe(out))
  end
  local own, own_type, _, is_open = core.array_info(out)
  if not is_open then return check.fail("%s: out: the array has been closed", name) end
  if own_type ~= dtype or extents(own) ~= extents(shape) then
    return check.fail("%s: out must be a %s array of %s, got a %s array of %s", name, dtype, extents(shape), own_type,
      extents(own))
  end
  for _, source in ipairs(sources or {}) do
    if core.array_overlap(out, source) then return check.fail("%s: out shares memory with an argument", name) end
  end
  check.result(name, core.array_is_free(out))
  core.array_set_convention(out, convention or 0)
  return out
end

--- The result `a` of the function `name`, if its element type holds all of it; `small` says that it does.
function args.held(name, a, small)
  if small then return a end
  local finite, where = core.array_finite(a)
  if finite then return a end
  local _, dtype = core.array_info(a)
  return check.fail("%s: number %d of the result is beyond the range of %s", name, where, dtype)
end

--- `a` with element type `dtype`: itself or a copy.
function args.as(a, dtype)
  local _, own = core.array_info(a)
  if own == dtype then return a end
  return core.array_convert(a, dtype)
end

--- sh.reconstruct, for a function of that name, which its messages say; options are checked.
function args.reconstruct(name, c, points, options)
  local coefficients, lmax, shape, dtype, _, _, small = args.coefficients(1, name, c)
  local one_row = #shape == 1
  if dtype == "float" and array.type_of(points) == "double" then
    dtype = "double"
    coefficients = core.array_convert(coefficients, dtype)
  end
  local p, one_point = array.points(2, name, points, dtype)
  local n = core.array_info(p)[1]
  shape[#shape] = n
  if one_point and #shape > 1 then shape[#shape] = nil end
  local out, message, code = args.result(name, options.out, shape, dtype, 0, { coefficients, p })
  if not out then return nil, message, code end
  local ok
  ok, message, code = check.result(name, core.sh_reconstruct(lmax, coefficients, p, out, options.threads,
    progress.of(options.progress)))
  if not ok then return nil, message, code end
  args.held(name, out, small)
  if one_row and one_point and options.out == nil then return out[1] end
  return out
end

args.progress = { "progress", "progress", optional = true }
args.out = { "out", "array", optional = true, about = "the array to be written and returned" }
args.dtype = { "dtype", "choice", of = core.choices "dtype", optional = true, about = "default: that of the argument" }

return args
