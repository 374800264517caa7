--- Arithmetic of arrays: operators, comparisons, abs, sqrt, clamp.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local operand = require "ylm.array.operand"

local methods = core.metatable "ylm.array"

-- Two operands ---------------------------------------------------------------------

--- Operations that take one of two operands as weights, which have no convention.
local weighs = { multiply = true, divide = true }

--- The convention of the result of two operands' conventions (nil: a number); fail(message) raises where they are mixed.
local function convention_of(op, x, y, fail)
  if x == nil or x == y then return y end
  if y == nil then return x end
  if weighs[op] and (x == 0 or y == 0) then return x + y end
  return fail(("coefficients of '%s' and of '%s': translate one of them by ylm.sh.convert"):format(
    core.sh_convention_name(x), core.sh_convention_name(y)))
end

--- An operand as array or number, its convention and its shape (nil of a number). `other` gives tables their type.
local function settle(value, other, fail)
  if type(value) == "number" then return value end
  local dtype = core.type(other) == "ylm.array" and operand.wide[(select(2, core.array_info(other)))] or "double"
  local is_known = core.type(value) == "ylm.array" or type(value) == "table" and getmetatable(value) == nil
  if not is_known then
    return fail("a number, an array or a table of numbers expected, got " .. check.describe(value))
  end
  local a = operand.of(value, dtype, fail)
  local shape, _, convention = core.array_info(a)
  return a, convention, shape
end

--- op(x, y), broadcast; `name` stands in messages.
local function combine(op, name, x, y)
  local function fail(message) return check.fail("%s: %s", name, message) end
  local a, convention_a, shape_a = settle(x, y, fail)
  local b, convention_b, shape_b = settle(y, x, fail)
  local convention = convention_of(op, convention_a, convention_b, fail)
  if op == "power" and b == 2 then op, b = "multiply", a end
  local result, message, code = core.array_combine(op, a, b, convention)
  if result then return result end
  if message then return check.result(name, nil, message, code) end
  return fail(("arrays of %s and %s do not fit: from the last axis on, extents must be equal, or one of them 1"):format(
    operand.extents(shape_a), operand.extents(shape_b)))
end

local operators = { add = { "__add", "+" }, subtract = { "__sub", "-" }, multiply = { "__mul", "*" },
  divide = { "__div", "/" }, power = { "__pow", "^" } }

for op, words in pairs(operators) do
  local name = "array " .. words[2]
  methods[words[1]] = operand.raising(name, function(x, y) return combine(op, name, x, y) end)
end

methods.__unm = operand.raising("array -", function(a)
  operand.open(a, "array -")
  return core.array_map("negate", a)
end)

--- Lua's comparisons give true or false, never an array.
local function no_order()
  return check.fail "arrays are compared by their methods, which give arrays: a:less(b), a:equal(b)"
end
methods.__lt, methods.__le = no_order, no_order

-- Comparisons ----------------------------------------------------------------------

for _, row in ipairs { { "less", "<" }, { "less_equal", "<=" }, { "greater", ">" }, { "greater_equal", ">=" },
  { "equal", "==" }, { "not_equal", "~=" } } do
  local name, sign = row[1], row[2]
  describe("array:" .. name) {
    about = ("1 where a %s b, else 0: a mask, for products, array:select and array:sum. Shapes broadcast as in a + b; "):format(
      sign) .. "NaN is unequal to everything, and neither less nor greater.",
    arguments = { { "b", "array|table|number", "" } },
    returns = { { "mask", "array", "float, in the shape of both" } },
    errors = "raises on shapes that do not fit, mixed conventions and closed arrays; nil, message, 'ENOMEM'",
    example = ("assert(ylm.array({ 1, 2, 3 }):%s(2):sum() == %d)"):format(name,
      ({ less = 1, less_equal = 2, greater = 1, greater_equal = 2, equal = 1, not_equal = 2 })[name]),
  }
  methods[name] = function(a, b)
    operand.open(a, name)
    return combine(name, name, a, b)
  end
end

-- One operand ----------------------------------------------------------------------

for name, row in pairs { abs = { "absolute", "The numbers without their signs.", "-2", 2 },
  sqrt = { "root", "The square roots; NaN of negative numbers.", "4", 2 } } do
  describe("array:" .. name) {
    about = row[2],
    arguments = {},
    returns = { { "b", "array", "same shape and convention; of int32 double, of float16 float" } },
    errors = "raises where the array has been closed; nil, message, 'ENOMEM' where memory runs out",
    example = ("assert(ylm.array({ %s }):%s():get(1) == %d)"):format(row[3], name, row[4]),
  }
  methods[name] = function(a)
    operand.open(a, name)
    return core.array_map(row[1], a)
  end
end

describe "array:clamp" {
  about = "The numbers, those below `low` as `low` and those above `high` as `high`. NaN stays.",
  arguments = { { "low?", "number|array|table", "nil: no bound" }, { "high?", "number|array|table", "nil: no bound" } },
  returns = { { "b", "array", "the bounds broadcast as in a + b" } },
  errors = "raises on shapes that do not fit, mixed conventions and closed arrays; nil, message, 'ENOMEM'",
  example = "assert(ylm.array({ -1, 0.5, 3 }):clamp(0, 1):sum() == 1.5)",
}
function methods.clamp(a, low, high)
  local _, dtype = operand.open(a, "clamp")
  local b = a
  if low ~= nil then b = combine("maximum", "clamp", b, low) end
  if high ~= nil then b = combine("minimum", "clamp", b, high) end
  return b ~= a and b or core.array_convert(a, operand.wide[dtype])
end
