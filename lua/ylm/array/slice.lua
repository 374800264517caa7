--- Parts of arrays: a[{1, 100}], a[{ {}, 3 }], a:slice({1, 100}, 3), and writing to them.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local operand = require "ylm.array.operand"

local slice = {}

local methods = core.metatable "ylm.array"

--- An index of an axis, counted from its end where it is negative.
local function place(x, extent, axis, fail)
  if check.is_integer(x) and x ~= 0 and math.abs(x) <= extent then return x > 0 and x or extent + 1 + x end
  if extent == 0 then return fail(("axis %d is empty: it has no index %s"):format(axis, check.describe(x))) end
  return fail(("axis %d: an index from 1 to %d, or -1 to -%d from the end, expected, got %s"):format(axis, extent, extent,
    check.describe(x)))
end

--- The part of an axis that {}, {first, last} or {first, last, step} names: first, step, count.
local function range(r, extent, axis, fail)
  local step = r[3]
  if step == nil then step = 1 end
  if #r == 0 then return 1, 1, extent end
  if #r < 2 or #r > 3 or getmetatable(r) ~= nil or not check.is_integer(step) or step == 0 then
    return fail(("axis %d: an index, {first, last}, {first, last, step} or {} for all of it expected, got %s"):format(axis,
      check.describe(r)))
  end
  if step == 1 and check.is_integer(r[1]) and r[2] == r[1] - 1 and r[1] >= 1 and r[1] <= extent + 1 then return 1, 1, 0 end
  local first, last = place(r[1], extent, axis, fail), place(r[2], extent, axis, fail)
  if (last - first) * step < 0 then
    return fail(("axis %d: from %d to %d by %d is no way"):format(axis, first, last, step))
  end
  return first, step, math.floor((last - first) / step) + 1
end

--- The slices of entries, one of each axis from the first on: a list for C, the shape of what they leave, and whether
-- the last axis stays.
local function slices_of(entries, shape, fail)
  if #entries > #shape then
    return fail(("%d entries for %d ax%ss"):format(#entries, #shape, #shape == 1 and "i" or "e"))
  end
  local slices, left = {}, {}
  for k, extent in ipairs(shape) do
    local entry = entries[k]
    local first, step, count = 1, 1, extent
    if type(entry) == "table" then
      first, step, count = range(entry, extent, k, fail)
      left[#left + 1] = count
    elseif entry ~= nil then
      first, count = place(entry, extent, k, fail), 1
    else
      left[#left + 1] = extent
    end
    slices[3 * k - 2], slices[3 * k - 1], slices[3 * k] = first, step, count
  end
  return slices, left, type(entries[#shape]) == "table" or entries[#shape] == nil
end

--- The entries of a[key]: a table of two or three numbers is a range of the first axis.
local function entries_of(key, fail)
  local numbers = 0
  for i = 1, #key do if type(key[i]) == "number" then numbers = numbers + 1 end end
  if getmetatable(key) ~= nil then return fail("a table of indices and ranges expected, got " .. check.describe(key)) end
  if #key == 0 and next(key) ~= nil then
    return fail(("a list of indices and ranges expected, got a table with %s"):format(check.describe((next(key)))))
  end
  if numbers ~= #key or numbers < 2 then return key end
  if numbers > 3 then
    return fail "one element is a:get(i, j, ..); a range of the first axis is {first, last} or {first, last, step}"
  end
  return { key }
end

local function take(a, entries, fail)
  local shape, _, convention = core.array_info(a)
  local slices, left, whole_rows = slices_of(entries, shape, fail)
  if #left > 0 then return core.array_slice(a, slices, left, whole_rows and convention or 0) end
  local one = core.array_slice(a, slices, { 1 }, 0)
  return core.array_get(one, 1), false
end

--- a[key] for a key that is a table.
slice.get = operand.raising("array", function(a, key)
  operand.open(a, "array")
  local function fail(message) return check.fail("array: %s", message) end
  return (take(a, entries_of(key, fail), fail))
end)

--- a[key] = value for a key that is a table, or a row's index.
slice.set = operand.raising("array", function(a, key, value)
  local shape, dtype, convention = operand.open(a, "array")
  local function fail(message) return check.fail("array: %s", message) end
  check.result("array", core.array_is_free(a))
  local slices, left = slices_of(type(key) == "number" and { key } or entries_of(key, fail), shape, fail)
  if #left == 0 then left = { 1 } end
  local given = type(value) == "number" and core.array_zeros({ 1 }, "double"):set(1, value)
    or operand.of(value, operand.wide[dtype], fail)
  local own, own_type, own_convention = core.array_info(given)
  if type(value) ~= "number" and own_convention ~= convention then
    return fail(("coefficients of '%s' into an array of '%s'"):format(core.sh_convention_name(own_convention),
      core.sh_convention_name(convention)))
  end
  if operand.extents(own) ~= operand.extents(left) then -- as often as the part has room for it
    local room = core.array_zeros(left, own_type == "double" and "double" or operand.wide[own_type])
    given = core.array_combine("add", room, given, 0)
    if not given or operand.extents((core.array_info(given))) ~= operand.extents(left) then
      return fail(("a part of %s cannot hold an array of %s"):format(operand.extents(left), operand.extents(own)))
    end
    own_type = select(2, core.array_info(given))
  end
  if own_type ~= dtype then given = operand.convert(given, dtype, fail)
  elseif core.array_overlap(a, given) then given = core.array_convert(given, dtype) end
  core.array_put(a, slices, given)
end)

describe "array:slice" {
  about = "A part of the array: one entry for each axis, from the first on. An index takes one element of the axis, and the "
    .. "axis away; {first, last} and {first, last, step} take a range, {} takes all, as axes do that are not named. Negative "
    .. "indices count from the end. a[{1, 100}] is a:slice({1, 100}), and a[{ {1, 100}, 3 }] is a:slice({1, 100}, 3).",
  arguments = { { "...", "table|integer", "an index or a range for each axis" } },
  returns = {
    { "part", "array|number", "a view that shares its numbers with the array where these follow one another in memory: indices "
      .. "first, then one range in steps of 1, then whole axes. Else a copy: a[{ {}, 2 }] and ranges with a step, which are "
      .. "views in NumPy. A number where every axis is taken away" },
    { "shares", "boolean", "true of a view" },
  },
  errors = "raises on what leaves its axis and on closed arrays; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local a = ylm.array { { 1, 2, 3 }, { 4, 5, 6 }, { 7, 8, 9 } }
assert(a[{ 2, 3 }]:get(1, 1) == 4 and a[{ -1, -1 }]:get(1, 3) == 9)  -- rows 2 and 3, the last row
assert(a[{ {}, 2 }]:sum() == 15)                                   -- a column
a[{ { 1, 2 }, { 1, 2 } }] = 0                                      -- writing reaches the array, view or not
assert(a:sum() == 33)]],
}
function methods.slice(a, ...)
  operand.open(a, "slice")
  local function fail(message) return check.fail("slice: %s", message) end
  local entries, count = { ... }, select("#", ...)
  for i = 1, count do
    if type(entries[i]) ~= "table" and type(entries[i]) ~= "number" then
      return check.bad(i, "slice", "an index, {first, last} or {} expected, got %s", check.describe(entries[i]))
    end
  end
  return take(a, entries, fail)
end

return slice
