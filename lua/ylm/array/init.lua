--- Dense arrays of numbers: ylm.array, ylm.zeros and the methods of their objects.

local bytes = require "ylm.array.bytes"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local operand = require "ylm.array.operand"
local slice = require "ylm.array.slice"

require "ylm.array.arithmetic"

require "ylm.describe".object "array" {
  about = "Dense, row-major numbers. a[i] is a number, or a view that keeps its parent alive; a[{1, 100}] is a slice; #a is the "
    .. "first extent. a + b, a - b, a * b, a / b, a ^ b and -a compute element by element, with numbers, arrays or tables: "
    .. "shapes are aligned at their last axes, and extents are equal or 1 (NumPy's rule). int32 is computed with in double, "
    .. "float16 in float; other functions of ylm take them as such. Operators raise where memory runs out.",
  fields = {
    { "shape", "integer[]", "its extents" },
    { "dtype", "string", "'float', 'double', 'int32' or 'float16'" },
    { "convention", "string", "of SH coefficients: 'ylm' is ylm's own. Operators keep it; + and - refuse two, * and / take an "
      .. "array of 'ylm' as weights" },
  },
}

local array = { shape_of = operand.shape_of, stack = require "ylm.array.reduce".stack, wrap = bytes.wrap }
local AXES = core.limits.axes
local methods = core.metatable "ylm.array"
local open, shape_of = operand.open, operand.shape_of

describe "array" {
  shelf = "everyday",
  about = "Makes an array from nested tables of numbers, or converts an array to another element type.",
  arguments = {
    { "values", "table|array", "nested to the array's shape; every row of a level has the same length" },
    { "dtype?", "string", "'float', 'double', 'int32' or 'float16'; default double, or the array's own" },
  },
  returns = { { "a", "array", "a new array; a.shape, a.dtype, a.convention, #a" } },
  errors = "raises on ragged tables, on what is not a number or not one that the type holds; nil, message, 'ENOMEM' where "
    .. "memory runs out",
  example = [[
local a = ylm.array({ { 0, 0, 1 }, { 1, 0, 0 } }, "float")
assert(#a == 2 and a.shape[2] == 3 and a.dtype == "float" and a:get(1, 3) == 1)]],
}
local function make(values, dtype)
  local function fail(message) return check.bad(1, "array", "%s", message) end
  if core.type(values) == "ylm.array" then
    local _, own, _, is_open = core.array_info(values)
    if not is_open then return fail "the array has been closed" end
    return operand.convert(values, operand.dtype(2, "array", dtype, own), fail)
  end
  if type(values) ~= "table" then
    return fail("a table of numbers or an array expected, got " .. check.describe(values))
  end
  return operand.of_table(values, operand.dtype(2, "array", dtype, "double"), fail)
end

--- ylm.array is a function that has functions.
make = memory.public(make)
array.array = setmetatable({ frombytes = memory.public(bytes.frombytes) }, {
  __call = function(_, ...) return make(...) end,
  __index = function(_, name) return check.no_name("array.", name, { "frombytes" }) end,
})

describe "zeros" {
  shelf = "everyday",
  about = "Makes an array of zeros.",
  arguments = {
    { "shape", "table", "1 to 8 extents, each 0 or more" },
    { "dtype?", "string", "'float', 'double' (default), 'int32' or 'float16'" },
  },
  returns = { { "a", "array", "" } },
  errors = "raises on a bad shape or one that is too large; nil, message, 'ENOMEM' where memory runs out",
  example = "assert(#ylm.zeros({ 4, 3 }) == 4)",
}
function array.zeros(shape, dtype)
  return check.result("zeros", core.array_zeros(bytes.shape(1, "zeros", shape), operand.dtype(2, "zeros", dtype, "double")))
end

-- Methods ------------------------------------------------------------------------

local function index_text(name, shape, behind)
  local out = {}
  for i, extent in ipairs(shape) do
    if extent == 0 then return ("%s: an array of %s has no elements"):format(name, operand.extents(shape)) end
    out[i] = ("1 to %d"):format(extent)
  end
  return ("%s: indices from %s%s expected"):format(name, table.concat(out, ", "), behind)
end

describe "array:get" {
  shelf = "everyday",
  about = "One element.",
  arguments = { { "...", "integer", "one index per axis, from 1" } },
  returns = { { "x", "number", "" } },
  errors = "raises on a wrong number of indices and outside of the shape",
  example = "assert(ylm.array({ { 1, 2 }, { 3, 4 } }):get(2, 1) == 3)",
}
function methods.get(a, ...)
  local shape = open(a, "get")
  local x = core.array_get(a, ...)
  if x == nil then return check.fail(index_text("get", shape, "")) end
  return x
end

describe "array:set" {
  shelf = "everyday",
  about = "Changes one element.",
  arguments = { { "...", "number", "one index per axis, from 1, then the number" } },
  returns = { { "a", "array", "the array itself" } },
  errors = "raises on a wrong number of indices and outside of the shape",
  example = "assert(ylm.zeros({ 2, 2 }):set(2, 1, 5):get(2, 1) == 5)",
}
function methods.set(a, ...)
  local shape, dtype = open(a, "set")
  local ok = core.array_set(a, ...)
  if ok then return a end
  if ok == nil then return check.fail(index_text("set", shape, " and a number")) end
  return check.fail("set: %s", operand.misfit(dtype, (select(select("#", ...), ...))))
end

describe "array:totable" {
  shelf = "everyday",
  about = "The numbers as nested tables.",
  arguments = {},
  returns = { { "t", "table", "" } },
  errors = "raises where the array has been closed",
  example = "assert(ylm.array({ { 1, 2 } }):totable()[1][2] == 2)",
}
function methods.totable(a)
  open(a, "totable")
  return core.array_totable(a)
end

describe "array:clone" {
  shelf = "everyday",
  about = "A copy with numbers of its own.",
  arguments = {},
  returns = { { "b", "array", "same shape, element type and convention" } },
  errors = "raises where the array has been closed; nil, message, 'ENOMEM' where memory runs out",
  example = [[
local a = ylm.array { 1, 2 }
a:clone():set(1, 5)
assert(a:get(1) == 1)]],
}
function methods.clone(a)
  local _, dtype = open(a, "clone")
  return core.array_convert(a, dtype)
end

describe "array:reshape" {
  about = "A view of the same numbers in another shape.",
  arguments = { { "shape", "table", "1 to 8 extents whose product is the number of elements" } },
  returns = { { "view", "array", "shares its numbers with the array" } },
  errors = "raises where the number of elements would change",
  example = "assert(ylm.array({ { 1, 2 }, { 3, 4 } }):reshape({ 4 }):get(3) == 3)",
}
function methods.reshape(a, shape)
  open(a, "reshape")
  if type(shape) ~= "table" then
    return check.bad(1, "reshape", "a table of extents expected, got %s", check.describe(shape))
  end
  local view = core.array_reshape(a, shape)
  if not view then
    return check.bad(1, "reshape", "extents with %s elements in all expected", tostring(#a))
  end
  return view
end

describe "array:pointer" {
  about = "The address of the first element; it is valid while the array is reachable and open. With LuaJIT: "
    .. "ffi.cast(\"double *\", a:pointer()).",
  arguments = {},
  returns = { { "address", "lightuserdata", "" } },
  errors = "raises where the array has been closed",
  example = "assert(type(ylm.zeros({ 2 }):pointer()) == \"userdata\")",
}
function methods.pointer(a)
  open(a, "pointer")
  return core.array_pointer(a)
end

describe "array:close" {
  about = "Frees the memory now rather than at the next collection (once no view uses it).",
  arguments = {},
  returns = {},
  errors = "raises on what is no array; closing twice does nothing",
  example = [[
local a = ylm.zeros { 1000 }
a:close()
assert(not pcall(a.get, a, 1))]],
}
function methods.close(a)
  if core.type(a) ~= "ylm.array" then return check.fail("close: an array expected, got %s", check.describe(a)) end
  check.result("close", core.array_close(a))
end

describe "array:save" {
  shelf = "everyday",
  about = "Writes the array as .npy (NumPy's format, version 1), float32, float64, int32 or float16, C order. Nothing is "
    .. "lost: the convention of coefficients stands in a comment of the header, which NumPy reads over and ylm.load heeds.",
  arguments = { { "path", "string", "ends in .npy" } },
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending; nil, message, code where the file cannot be written",
  example = [[
local name = os.tmpname()
assert(ylm.zeros { 4, 3 }:save(name .. ".npy"))
os.remove(name .. ".npy")
os.remove(name)]],
}
function methods.save(a, path)
  if core.type(a) ~= "ylm.array" then
    return check.fail("save: an array expected before the colon, got %s", check.describe(a))
  end
  if not select(4, core.array_info(a)) then return check.fail("save: the array has been closed") end
  if type(path) ~= "string" or not path:lower():find("%.npy$") or path:find("%z") then
    return check.bad(1, "save", "a file name that ends in .npy expected, got %s", check.describe(path))
  end
  return check.result("save", core.array_write(a, path))
end

methods.__len = function(a) return open(a, "#")[1] end

describe "array:to" {
  about = "Copies the array to a device's memory.",
  arguments = { { "gpu", "gpu", "of ylm.vulkan.open" } },
  returns = { { "copy", "gpu_array", "or nil, message, code: 'ENOMEM', 'ELIMIT', 'EDEVICE'" } },
  errors = "raises where the array or the device has been closed",
  example = [[
local gpu = ylm.vulkan.open()
if gpu then
  local there = ylm.zeros({ 100, 3 }, "float"):to(gpu)
  assert(there.shape[1] == 100 and there.seconds >= 0)
end]],
}
function methods.to(a, gpu)
  open(a, "to")
  return check.device(1, "to", gpu):array(a)
end

methods.__index = function(a, key)
  if type(key) == "number" then
    local shape = open(a, "array")
    if #shape == 1 then return core.array_get(a, key) end
    return core.array_view(a, key)
  end
  if type(key) == "table" then return slice.get(a, key) end
  if key == "shape" then return (core.array_info(a)) end
  if key == "dtype" then return (select(2, core.array_info(a))) end
  if key == "convention" then return array.convention_name((select(3, core.array_info(a)))) end
  return rawget(methods, key)
end

methods.__newindex = function(a, key, value)
  local shape, dtype = open(a, "array")
  if type(key) == "table" then return slice.set(a, key, value) end
  if type(key) == "number" then
    if #shape > 1 then return slice.set(a, key, value) end
    local ok = core.array_set(a, key, value)
    if ok then return end
    if ok == false then return check.fail("array: %s", operand.misfit(dtype, value)) end
  end
  return check.fail("array: cannot set %s of an array of %s", check.describe(key), table.concat(shape, "x"))
end

local SHOWN, WHOLE = 8, 36 -- numbers: of a large array, and of one that is shown whole, 6 x 6

--- The first numbers, rows apart: "1 2 3; 4 5 6; ..."; all where they are at most `whole`.
local function first_numbers(a, shape, whole)
  local words, row, count = {}, shape[#shape], 1
  for _, extent in ipairs(shape) do count = count * extent end
  local most = count <= whole and count or SHOWN
  for i, x in ipairs(core.array_head(a, most + 1)) do
    if i > most then return table.concat(words) .. " ..." end
    words[i] = (i == 1 and "" or (i - 1) % row == 0 and "; " or " ") .. check.number_text(x, "%.6g")
  end
  return table.concat(words)
end

methods.__tostring = function(a)
  local shape, dtype, convention, is_open = core.array_info(a)
  if not is_open then return "ylm.array (closed)" end
  return (("ylm.array %s [%s]%s: %s"):format(dtype, table.concat(shape, "]["),
    convention ~= 0 and ", " .. array.convention_name(convention) or "", first_numbers(a, shape, WHOLE)):gsub(": $", ""))
end

describe "array:print" {
  shelf = "everyday",
  about = "Prints type, shape and all numbers, a line for each row; tostring shows arrays of at most 36 numbers whole.",
  arguments = {},
  returns = {},
  errors = "raises on a closed array",
  example = "assert(type(ylm.array({ { 1, 2 }, { 3, 4 } }).print) == 'function')   -- a:print(): two lines of two numbers",
}
function methods.print(a)
  local shape, dtype, convention = open(a, "print")
  local row, count = shape[#shape], 1
  for _, extent in ipairs(shape) do count = count * extent end
  io.stdout:write(("ylm.array %s [%s]%s\n"):format(dtype, table.concat(shape, "]["),
    convention ~= 0 and ", " .. array.convention_name(convention) or ""))
  local words = {}
  for i, x in ipairs(count > 0 and core.array_head(a, count) or {}) do
    words[#words + 1] = check.number_text(x, "%.6g")
    if i % row == 0 then
      io.stdout:write(table.concat(words, " "), "\n")
      words = {}
    end
  end
end

describe "array:same" {
  about = "Whether another array has the same shape, and numbers that differ by at most a tolerance. NaN is no number's equal.",
  arguments = { { "b", "array|table", "arrays of other types are compared as numbers" },
    { "tolerance?", "number", "0 or more, of the difference of two numbers; default 0" } },
  returns = { { "same", "boolean", "" }, { "largest", "number", "the largest difference, where the shapes are the same" } },
  errors = "raises on what is no array, and a tolerance below 0",
  example = [[
local a = ylm.array { 1, 2, 3 }
assert(a:same { 1, 2, 3 } and not a:same { 1, 2, 4 } and a:same({ 1, 2, 3.01 }, 0.1))]],
}
function methods.same(a, b, tolerance)
  local shape = open(a, "same")
  if tolerance ~= nil and not (type(tolerance) == "number" and tolerance >= 0) then
    return check.bad(2, "same", "tolerance must be a number >= 0, got %s", check.describe(tolerance))
  end
  if core.type(b) == "ylm.array" then open(b, "same")
  elseif type(b) == "table" then b = make(b)
  else return check.bad(1, "same", "an array or a table of numbers expected, got %s", check.describe(b)) end
  local other = core.array_info(b)
  if #shape ~= #other then return false end
  for i = 1, #shape do if shape[i] ~= other[i] then return false end end
  local largest = core.array_distance(a, b)
  return largest <= (tolerance or 0), largest
end

--- The name of a convention number.
function array.convention_name(number)
  return core.sh_convention_name(number) or tostring(number)
end

-- Numbers are read and written without memory, and often.
memory.publish(methods, { get = true, set = true, pointer = true, close = true })

-- For the other modules --------------------------------------------------------------

--- Argument `n` of `name` as an array whose last axis has `width` numbers (nil: any).
-- Tables become arrays of `dtype` (default double). Returns the array and whether it was one row.
function array.rows(n, name, what, value, width, dtype)
  local a = value
  if core.type(a) ~= "ylm.array" then
    if type(a) ~= "table" or core.type(a) then
      return check.bad(n, name, "%s: a table of numbers or an array expected, got %s", what, check.describe(value))
    end
    if #a == 0 then a = core.array_zeros({ 0, width or 0 }, dtype or "double")
    else
      local shape = shape_of(a)
      if #shape > AXES then
        return check.bad(n, name, "%s: at most %d axes, got more; does the table hold itself?", what, AXES)
      end
      if width and shape[#shape] ~= width then
        return check.bad(n, name, "%s: rows of %d numbers expected, got an array of %s", what, width, table.concat(shape, "x"))
      end
      form.take_numbers(shape, function(message) return check.bad(n, name, "%s: %s", what, message) end)
      a = core.array_zeros(shape, dtype or "double")
      local ok, where = core.array_fill(a, value)
      if not ok then
        return check.bad(n, name, "%s: every row must hold the same number of numbers; element %d does not",
          what, where)
      end
    end
  end
  local shape, own, _, is_open = core.array_info(a)
  if not is_open then return check.bad(n, name, "%s: the array has been closed", what) end
  if width and shape[#shape] ~= width then
    return check.bad(n, name, "%s: rows of %d numbers expected, got %s", what, width, check.describe(a))
  end
  dtype = dtype or operand.wide[own]
  if own ~= dtype then a = core.array_convert(a, dtype) end
  return a, #shape == 1
end

--- The element type in which an array is computed with; of anything else `default`.
function array.type_of(value, default)
  return core.type(value) == "ylm.array" and operand.wide[(select(2, core.array_info(value)))] or default
end

--- Points [n][3] for argument `n`: rows of three finite numbers. Returns array [n][3], whether one row.
function array.points(n, name, value, dtype, what)
  what = what or "points"
  local a, single = array.rows(n, name, what, value, 3, dtype)
  local finite, where = core.array_finite(a)
  if not finite then
    local whole = core.array_finite((array.rows(n, name, what, value, 3, "double")))
    return check.bad(n, name, "%s: row %d is %s", what, math.floor((where - 1) / 3) + 1,
      whole and "more than a float holds, 3.4e38" or "not finite")
  end
  local shape = core.array_info(a)
  if #shape ~= 2 then
    local count = 1
    for i = 1, #shape - 1 do count = count * shape[i] end
    a = core.array_reshape(a, { count, 3 })
  end
  return a, single
end

--- Points for libraries that hold them in float relative to an origin of theirs: double, none beyond float's range.
function array.places(n, name, value)
  array.points(n, name, value, "float")
  return array.points(n, name, value, "double")
end

return array
