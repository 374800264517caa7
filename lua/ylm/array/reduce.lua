--- Sums, means, least and largest numbers along axes; parts by masks; arrays side by side.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local operand = require "ylm.array.operand"

local reduce = {}

local methods = core.metatable "ylm.array"

local fields = {
  { "axis", "any", optional = true, about = "an axis from 1, or from the last one from -1; or a list of them; default: all" },
  { "keep", "boolean", default = false, about = "the axes stay, with extents of 1: the result broadcasts with the array" },
}

--- The axes that `value` names among `count`, sorted, each once.
local function axes_of(value, count, fail)
  local is_gone, list = {}, {}
  for _, x in ipairs(type(value) == "table" and value or { value }) do
    local axis = operand.axis(x, count, fail)
    if is_gone[axis] then return fail(("axis %d is named twice"):format(axis)) end
    is_gone[axis] = true
  end
  for axis = 1, count do
    if value == nil or is_gone[axis] then list[#list + 1] = axis end
  end
  if not list[1] then return fail "the list of axes is empty" end
  return list
end

--- The options that a:sum(1), a:sum(1, 2) and a:sum { axis = 1 } give.
local function options_of(op, ...)
  local list, count = { ... }, select("#", ...)
  while count > 0 and list[count] == nil do count = count - 1 end
  if count < 2 and not check.is_integer(list[1]) then return list[1] end
  for i = 1, count do
    if not check.is_integer(list[i]) then
      return check.bad(i, op, "axes, or one table of options expected, got %s", check.describe(list[i]))
    end
  end
  return { axis = list }
end

local function reduced(op, a, ...)
  local shape = operand.open(a, op)
  local options = options_of(op, ...)
  local o = form.options(1, op, fields, options)
  local axes = axes_of(o.axis, #shape, function(message) return check.bad(1, op, "%s", message) end)
  local last = #axes
  while last > 0 do -- neighbours at once, the last ones first
    local first = last
    while first > 1 and axes[first - 1] == axes[first] - 1 do first = first - 1 end
    local result, message, code = core.array_reduce(op, a, axes[first], last - first + 1, o.keep)
    if result == nil then
      if message then return check.result(op, nil, message, code) end
      return check.fail("%s: an axis of %s has no numbers", op, check.describe(a))
    end
    a, last = result, first - 1
  end
  return a
end

for op, row in pairs {
  sum = { "The sum, compensated: to a few roundings, however many numbers there are. No numbers have the sum 0.", 10 },
  mean = { "The mean.", 2.5 },
  min = { "The least number; NaN where one is there.", 1 },
  max = { "The largest number; NaN where one is there.", 4 },
} do
  describe("array:" .. op) {
    about = row[1] .. (" Of all numbers, or along axes: a:OP(), a:OP(2), a:OP(1, 2), a:OP { axis = -1, keep = true }.")
      :gsub("OP", op),
    arguments = { { "options?", "table|integer", "the options, or an axis" }, { "...", "integer", "more axes" } },
    options = fields,
    returns = { { "x", "number|array", "a number where no axis is left; else an array of the type that computes: int32 "
      .. "gives double, float16 float. The convention stays unless the last axis goes" } },
    errors = "raises on axes that are none" .. (op == "sum" and "" or ", an axis without numbers")
      .. " and closed arrays; nil, message, 'ENOMEM'",
    example = ("assert(ylm.array({ { 1, 2 }, { 3, 4 } }):%s() == %s)"):format(op, row[2]),
    source = op == "sum" and "Neumaier 1974; Ogita, Rump & Oishi 2005" or nil,
  }
  methods[op] = function(a, ...) return reduced(op, a, ...) end
end

describe "array:select" {
  about = "The parts of the array where a mask is not 0, in order: rows, pixels or numbers, as the mask has axes.",
  arguments = { { "mask", "array|table", "numbers, in the shape of the array's first axes; an extent of 1 may stand behind" } },
  returns = { { "parts", "array", "[n][..], the axes behind those of the mask; a copy" } },
  errors = "raises on a mask of another shape and closed arrays; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local a = ylm.array { { 1, 2 }, { 3, 4 }, { 5, 6 } }
assert(a:select({ 1, 0, 1 }):get(2, 1) == 5)
assert(a:select(a:greater(3)):sum() == 15)]],
}
function methods.select(a, mask)
  local shape = operand.open(a, "select")
  local function fail(message) return check.bad(1, "select", "mask: %s", message) end
  mask = operand.of(mask, "float", fail)
  local own, dtype = core.array_info(mask)
  local many = #own
  if many > 1 and own[many] == 1 and (many > #shape or shape[many] ~= 1) then many = many - 1 end
  local fits = many <= #shape
  for i = 1, fits and many or 0 do fits = fits and own[i] == shape[i] end
  if not fits then
    return fail(("the first extents of %s expected, got %s"):format(operand.extents(shape), operand.extents(own)))
  end
  if dtype ~= "float" then mask = mask:not_equal(0) end
  return core.array_select(a, mask, many)
end

describe "stack" {
  about = "Arrays of one shape side by side, along a new axis.",
  arguments = {
    { "list", "table", "arrays or tables of numbers, one or more" },
    { "axis?", "integer", "of the result: from 1 (default), or from the last one from -1" },
  },
  returns = { { "a", "array", "one axis more; the element type of all, else the wider of those that compute" } },
  errors = "raises on shapes that differ, mixed conventions and closed arrays; nil, message, 'ENOMEM'",
  example = [[
local a, b = ylm.array { 1, 2, 3 }, ylm.array { 4, 5, 6 }
assert(ylm.stack({ a, b }).shape[1] == 2 and ylm.stack({ a, b }, 2):get(3, 2) == 6)]],
}
function reduce.stack(list, axis)
  if type(list) ~= "table" or getmetatable(list) ~= nil or #list == 0 then
    return check.bad(1, "stack", "a list of arrays expected, got %s", check.describe(list))
  end
  local parts, shape, dtype, convention = {}, nil, nil, nil
  for i = 1, #list do
    local function fail(message) return check.bad(1, "stack", "element %d: %s", i, message) end
    parts[i] = operand.of(list[i], "double", fail)
    local own, own_type, own_convention = core.array_info(parts[i])
    shape, dtype, convention = shape or own, dtype or own_type, convention or own_convention
    if operand.extents(own) ~= operand.extents(shape) then
      return fail(("an array of %s expected as before, got %s"):format(operand.extents(shape), operand.extents(own)))
    end
    if own_convention ~= convention then
      return fail(("coefficients of '%s' beside those of '%s'"):format(core.sh_convention_name(own_convention),
        core.sh_convention_name(convention)))
    end
    if own_type ~= dtype then
      dtype = (operand.wide[own_type] == "double" or operand.wide[dtype] == "double") and "double" or "float"
    end
  end
  if #shape == core.limits.axes then
    return check.bad(1, "stack", "arrays of at most %d axes expected, since the result has one more, got %s",
      core.limits.axes - 1, operand.extents(shape))
  end
  axis = operand.axis(axis == nil and 1 or axis, #shape + 1, function(message) return check.bad(2, "stack", "%s", message) end)
  table.insert(shape, axis, #parts)
  local result, message, code = check.result("stack", core.array_zeros(shape, dtype))
  if not result then return nil, message, code end
  local slices = {}
  for k, extent in ipairs(shape) do slices[3 * k - 2], slices[3 * k - 1], slices[3 * k] = 1, 1, extent end
  for i, part in ipairs(parts) do
    slices[3 * axis - 2], slices[3 * axis] = i, 1
    core.array_put(result, slices, select(2, core.array_info(part)) == dtype and part or core.array_convert(part, dtype))
  end
  core.array_set_convention(result, axis < #shape and convention or 0)
  return result
end

return reduce
