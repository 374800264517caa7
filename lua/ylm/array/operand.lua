--- Shared by the files of ylm.array: open arrays, element types, operands that are tables.

local check = require "ylm.check"
local core = require "ylm.c.core"
local memory = require "ylm.memory"

local operand = {}

local AXES = core.limits.axes

--- The element types, and those in which their numbers are computed with.
operand.dtypes = { "float", "double", "int32", "float16" }
operand.wide = { float = "float", double = "double", int32 = "double", float16 = "float" }

--- The numbers that a type holds, where these are not those of Lua.
local holds = {
  int32 = "int32 holds whole numbers from -2147483648 to 2147483647",
  float16 = "float16 holds numbers up to 65504",
}

--- The element type that is argument `n` of `name`; nil: the default.
function operand.dtype(n, name, dtype, default)
  if dtype == nil then return default end
  if operand.wide[dtype] then return dtype end
  local guess = type(dtype) == "string" and check.guess(dtype, operand.dtypes)
  return check.bad(n, name, "dtype must be 'float', 'double', 'int32' or 'float16', got %s%s", check.describe(dtype),
    guess and (" (did you mean '%s'?)"):format(guess) or "")
end

--- The array before the colon of method `name`: shape, dtype, convention number.
function operand.open(a, name)
  if core.type(a) ~= "ylm.array" then
    return check.fail("%s: an array expected before the colon, got %s", name, check.describe(a))
  end
  local shape, dtype, convention, is_open = core.array_info(a)
  if not is_open then return check.fail("%s: the array has been closed", name) end
  return shape, dtype, convention
end

--- `f` as an operator, which has one result: it raises a sentence where memory runs out.
function operand.raising(name, f)
  f = memory.public(f)
  return function(...)
    local result, message = f(...)
    if message then return check.fail("%s: %s", name, message) end
    return result
  end
end

--- A copy of `a` with element type `dtype`; fail(message) raises where that does not hold its numbers.
function operand.convert(a, dtype, fail)
  local b, where, x = core.array_convert(a, dtype)
  if b then return b end
  return fail(("%s; number %d is %s"):format(holds[dtype], where, check.number_text(x, "%.14g")))
end

--- A sentence for a number x that `dtype` does not hold.
function operand.misfit(dtype, x)
  return ("%s, got %s"):format(holds[dtype] or dtype, check.number_text(x, "%.14g"))
end

--- The shape of a nested table, taken along its first elements; one axis too many is enough to know (a table may
-- hold itself).
function operand.shape_of(t)
  local shape = {}
  while type(t) == "table" and #shape <= AXES do
    shape[#shape + 1] = #t
    t = t[1]
  end
  return shape
end

--- A nested table of numbers as an array; fail(message) raises.
function operand.of_table(t, dtype, fail)
  local shape = operand.shape_of(t)
  if #shape > AXES then return fail(("at most %d axes, got more; does the table hold itself?"):format(AXES)) end
  local a, message, code = check.result("array", core.array_zeros(shape, operand.wide[dtype] == dtype and dtype or "double"))
  if not a then return nil, message, code end
  local ok, where = core.array_fill(a, t)
  if not ok then
    return fail(("every row must hold the same number of numbers; element %d does not"):format(where))
  end
  return operand.wide[dtype] == dtype and a or operand.convert(a, dtype, fail)
end

--- An array, or a table of numbers as one; fail(message) raises.
function operand.of(value, dtype, fail)
  if core.type(value) == "ylm.array" then
    if not select(4, core.array_info(value)) then return fail "the array has been closed" end
    return value
  end
  if type(value) ~= "table" or getmetatable(value) ~= nil then
    return fail("an array or a table of numbers expected, got " .. check.describe(value))
  end
  return operand.of_table(value, dtype, fail)
end

--- "2x3".
function operand.extents(shape)
  local words = {}
  for i, extent in ipairs(shape) do words[i] = ("%d"):format(extent) end
  return table.concat(words, "x")
end

--- The axis that argument `x` names among `axes`, from 1 or, from the end, from -1; fail(message) raises.
function operand.axis(x, axes, fail)
  if check.is_integer(x) and x ~= 0 and math.abs(x) <= axes then return x > 0 and x or axes + 1 + x end
  return fail(("an axis from 1 to %d, or -1 to -%d from the last one, expected, got %s"):format(axes, axes,
    check.describe(x)))
end

return operand
