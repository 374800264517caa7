--- Arrays as bytes, and arrays over memory of others.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local operand = require "ylm.array.operand"

local bytes = {}

local AXES = core.limits.axes
local methods = core.metatable "ylm.array"

--- Argument `n` of `name` as a list of extents.
function bytes.shape(n, name, shape)
  if check.is_integer(shape) then shape = { shape } end
  if type(shape) ~= "table" or #shape < 1 or #shape > AXES then
    return check.bad(n, name, "a shape of 1 to %d extents expected, got %s", AXES, check.describe(shape))
  end
  for i = 1, #shape do
    if not check.is_integer(shape[i]) or shape[i] < 0 then
      return check.bad(n, name, "extent %d must be an integer >= 0, got %s", i, check.describe(shape[i]))
    end
  end
  return shape
end

describe "array:bytes" {
  about = "The elements as a string of bytes, row-major, in the machine's byte order: for files and sockets of others.",
  arguments = {},
  returns = { { "bytes", "string", "2 bytes an element of float16, 4 of float and int32, 8 of double" } },
  errors = "raises where the array has been closed; nil, message, 'ENOMEM' where memory runs out",
  example = "assert(#ylm.zeros({ 5, 3 }, \"float\"):bytes() == 60)",
}
function methods.bytes(a)
  operand.open(a, "bytes")
  return core.array_bytes(a)
end

describe "array.frombytes" {
  about = "The array whose elements are these bytes, row-major, in the machine's byte order; array:bytes undone.",
  arguments = {
    { "bytes", "string", "" },
    { "shape", "table", "1 to 8 extents" },
    { "dtype?", "string", "'float', 'double' (default), 'int32' or 'float16'" },
  },
  returns = { { "a", "array", "with memory of its own" } },
  errors = "raises on another number of bytes than the shape has, and on a bad shape; nil, message, 'ENOMEM'",
  example = [[
local a = ylm.array({ { 1, 2 }, { 3, 4 } }, "float16")
assert(ylm.array.frombytes(a:bytes(), { 2, 2 }, "float16"):get(2, 1) == 3)]],
}
function bytes.frombytes(text, shape, dtype)
  if type(text) ~= "string" then
    return check.bad(1, "frombytes", "a string of bytes expected, got %s", check.describe(text))
  end
  shape, dtype = bytes.shape(2, "frombytes", shape), operand.dtype(3, "frombytes", dtype, "double")
  local size, wanted = { float16 = 2, float = 4, int32 = 4, double = 8 }, 1
  for _, extent in ipairs(shape) do wanted = wanted * extent end
  if wanted * size[dtype] ~= #text then
    return check.bad(1, "frombytes", "%.14g bytes expected for %s elements of %s, got %d", wanted * size[dtype],
      operand.extents(shape), dtype, #text)
  end
  local a, message, code = check.result("frombytes", core.array_zeros(shape, dtype))
  if not a then return nil, message, code end
  core.array_set_bytes(a, text)
  return a
end

describe "wrap" {
  about = "An array over memory that somebody else owns: of LuaJIT's FFI, of another library, of a host program. Nothing is "
    .. "copied. The caller vouches for a pointer: the elements are there, and stay as long as the array, its views and arrays "
    .. "made of them without a copy. array:pointer is the way back.",
  arguments = {
    { "pointer", "userdata|number", "light userdata, a pointer or an array of LuaJIT's FFI, or the address as a number" },
    { "shape", "table", "1 to 8 extents" },
    { "dtype?", "string", "'float', 'double' (default), 'int32' or 'float16'" },
    { "keep?", "any", "a value that owns the memory: not collected before the array and all its views; default: the pointer" },
  },
  returns = { { "a", "array", "shares its numbers with the memory; closing it frees nothing" } },
  errors = "raises on NULL, an address that is no multiple of the element's size, and a bad shape; nil, message, 'ENOMEM'",
  example = [[
local owner = ylm.array({ { 1, 2, 3 }, { 4, 5, 6 } }, "float")
local a = ylm.wrap(owner:pointer(), { 2, 3 }, "float", owner)
a:set(2, 1, 7)
assert(owner:get(2, 1) == 7)]],
}
function bytes.wrap(pointer, shape, dtype, keep)
  shape, dtype = bytes.shape(2, "wrap", shape), operand.dtype(3, "wrap", dtype, "double")
  if keep == nil then keep = pointer end
  local kind, address = type(pointer), pointer
  if kind == "cdata" then
    local ffi = require "ffi"
    local ok, place = pcall(ffi.cast, "const void *", pointer)
    if ok then address = tonumber(ffi.cast("intptr_t", place)) end
    local is_pointer = ok and (tostring(ffi.typeof(pointer)):find "%*" or tostring(ffi.typeof(pointer)):find "%[")
    if not is_pointer then kind = "cdata that is no pointer" end
  elseif core.type(pointer) or io.type(pointer) or (kind ~= "userdata" and not check.is_integer(pointer)) then
    kind = "value"
  end
  if kind ~= "cdata" and kind ~= "userdata" and kind ~= "number" then
    return check.bad(1, "wrap", "a pointer expected (light userdata, a pointer of FFI, an address), got %s",
      kind == "value" and check.describe(pointer) or "a " .. kind)
  end
  local a, fault, code = core.array_wrap(address, shape, dtype, keep)
  if a then return a end
  if fault == "null" then return check.bad(1, "wrap", "the pointer is NULL, or no address") end
  if fault == "aligned" then
    return check.bad(1, "wrap", "the address is no multiple of %s's size", dtype)
  end
  return check.result("wrap", nil, fault, code)
end

return bytes
