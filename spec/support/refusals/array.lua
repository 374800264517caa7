-- Refusals of ylm.array, ylm.zeros and the methods of arrays.

local nan, inf = 0 / 0, math.huge

local function a(ylm) return ylm.array { { 1, 2, 3 }, { 4, 5, 6 } } end

local function closed(ylm)
  local x = a(ylm)
  x:close()
  return x
end

local function itself()
  local t = {}
  t[1] = t
  return t
end

--- A method refuses another object than an array, and a closed one.
local function self_cases(name)
  return
    { call = function(ylm) a(ylm)[name](3) end, says = name .. ": an array expected .* got 3" },
    { call = function(ylm) local x = closed(ylm) x[name](x) end, says = name .. ": the array has been closed" }
end

local function cases(name, more)
  local first, second = self_cases(name)
  table.insert(more, first)
  table.insert(more, second)
  return more
end

return {
  array = {
    { call = function(ylm) ylm.array() end, says = "bad argument #1 to 'array' .*got nil" },
    { call = function(ylm) ylm.array("text") end, says = "a table of numbers or an array expected, got 'text'" },
    { call = function(ylm) ylm.array { { 1, 2 }, { 3 } } end, says = "every row must hold the same number" },
    { call = function(ylm) ylm.array { 1, "x" } end, says = "element 2 does not" },
    { call = function(ylm) ylm.array({ 1 }, "half") end, says = "dtype must be 'float', 'double', 'int32' or 'float16', got 'half'" },
    { call = function(ylm) ylm.array { { { { { { { { { 1 } } } } } } } } } end, says = "at most 8 axes, got more" },
    { call = function(ylm) ylm.array(itself()) end, says = "does the table hold itself" },
    { call = function(ylm) ylm.sh.eval(1, itself()) end, says = "does the table hold itself" },
    { call = function(ylm) ylm.array(closed(ylm)) end, says = "closed" },
    { call = function(ylm) ylm.array({ 1, 1.5 }, "int32") end, says = "int32 holds whole numbers .*; number 2 is 1.5" },
    { call = function(ylm) ylm.array({ nan }, "int32") end, says = "int32 holds whole numbers" },
    { call = function(ylm) ylm.array(ylm.array { 1, 1e5 }, "float16") end, says = "float16 holds numbers up to 65504; number 2 is" },
  },
  zeros = {
    { call = function(ylm) ylm.zeros() end, says = "a shape of 1 to 8 extents expected, got nil" },
    { call = function(ylm) ylm.zeros {} end, says = "a shape of 1 to 8 extents" },
    { call = function(ylm) ylm.zeros { 1, 1, 1, 1, 1, 1, 1, 1, 1 } end, says = "a shape of 1 to 8 extents" },
    { call = function(ylm) ylm.zeros { -1 } end, says = "extent 1 must be an integer >= 0, got %-1" },
    { call = function(ylm) ylm.zeros { 2, 0.5 } end, says = "extent 2 must be an integer" },
    { call = function(ylm) ylm.zeros { nan } end, says = "extent 1 must be an integer" },
    { call = function(ylm) ylm.zeros { inf } end, says = "extent 1 must be an integer" },
    { call = function(ylm) ylm.zeros { 2 ^ 40, 2 ^ 40 } end, says = "zeros: 1.20893e%+24 elements are more than any memory holds" },
    { call = function(ylm) ylm.zeros { 2 ^ 40, 2 ^ 40, 0 } end, says = "extents of 1.20893e%+24 beside one of 0 are too large" },
    { call = function(ylm) ylm.zeros { 1e300 } end, says = "zeros: 1e%+300 elements are more than any memory holds" },
    { call = function(ylm) ylm.zeros({ 1 }, 7) end, says = "dtype must be" },
  },
  ["array:get"] = cases("get", {
    { call = function(ylm) a(ylm):get() end, says = "get: indices from 1 to 2, 1 to 3 expected" },
    { call = function(ylm) a(ylm):get(0, 1) end, says = "get: indices" },
    { call = function(ylm) a(ylm):get(1, 4) end, says = "get: indices" },
    { call = function(ylm) a(ylm):get(1, 1.5) end, says = "get: indices" },
    { call = function(ylm) a(ylm):get(1, nan) end, says = "get: indices" },
    { call = function(ylm) a(ylm):get(1, 2, 3) end, says = "get: indices" },
    { call = function(ylm) ylm.zeros({ 0, 3 }):get(1, 1) end, says = "get: an array of 0x3 has no elements" },
  }),
  ["array:set"] = cases("set", {
    { call = function(ylm) a(ylm):set(1, 1) end, says = "set: indices .* and a number expected" },
    { call = function(ylm) a(ylm):set(3, 1, 5) end, says = "set: indices" },
    { call = function(ylm) a(ylm):set(1, 1, "x") end, says = "set: indices" },
    { call = function(ylm) ylm.zeros({ 1 }, "int32"):set(1, 2 ^ 31) end, says = "set: int32 holds whole numbers .* got 2147483648" },
  }),
  ["array:reshape"] = cases("reshape", {
    { call = function(ylm) a(ylm):reshape(6) end, says = "a table of extents expected, got 6" },
    { call = function(ylm) a(ylm):reshape { 4 } end, says = "elements in all expected" },
    { call = function(ylm) a(ylm):reshape { -2, -3 } end, says = "elements in all expected" },
    { call = function(ylm) a(ylm):reshape {} end, says = "elements in all expected" },
  }),
  ["array:slice"] = cases("slice", {
    { call = function(ylm) a(ylm):slice(3) end, says = "slice: axis 1: an index from 1 to 2, or %-1 to %-2 from the end" },
    { call = function(ylm) a(ylm)[{ first = 1, last = 1 }] = 0 end, says = "a list of indices and ranges expected" },
    { call = function(ylm) ylm.zeros({ 0, 3 }):slice({ 1, -1 }) end, says = "slice: axis 1 is empty: it has no index 1" },
    { call = function(ylm) a(ylm):slice(0) end, says = "axis 1: an index from 1 to 2" },
    { call = function(ylm) a(ylm):slice(1.5) end, says = "axis 1: an index .* got 1.5" },
    { call = function(ylm) a(ylm):slice({}, { 1, 4 }) end, says = "axis 2: an index from 1 to 3" },
    { call = function(ylm) a(ylm):slice({ 2, nan }) end, says = "axis 1: an index from 1 to 2" },
    { call = function(ylm) a(ylm):slice({ 1, 2, 0 }) end, says = "axis 1: an index, {first, last}, {first, last, step}" },
    { call = function(ylm) a(ylm):slice({ 1, 2, -1 }) end, says = "axis 1: from 1 to 2 by %-1 is no way" },
    { call = function(ylm) a(ylm):slice({ 1 }) end, says = "or {} for all of it expected, got {1}" },
    { call = function(ylm) a(ylm):slice(1, 1, 1) end, says = "slice: 3 entries for 2 axes" },
    { call = function(ylm) a(ylm):slice("x") end, says = "bad argument #1 to 'slice' %(an index" },
    { call = function(ylm) a(ylm):slice(1, nil, 2) end, says = "bad argument #2 to 'slice'" },
    { call = function(ylm) return a(ylm)[{ 1, 3 }] end, says = "array: axis 1: an index from 1 to 2" },
    { call = function(ylm) return a(ylm)[{ 1, 1, 1, 1 }] end, says = "one element is a:get%(i, j, ..%)" },
    { call = function(ylm) return a(ylm)[{ { 1, 2 }, "x" }] end, says = "axis 2: an index" },
    { call = function(ylm) return a(ylm)[setmetatable({}, {})] end, says = "a table of indices and ranges expected" },
    { call = function(ylm) a(ylm)[{ 1, 2 }] = { 1, 2 } end, says = "a part of 2x3 cannot hold an array of 2" },
    { call = function(ylm) a(ylm)[3] = 1 end, says = "axis 1: an index from 1 to 2" },
    { call = function(ylm) a(ylm)[1] = "x" end, says = "an array or a table of numbers expected, got 'x'" },
    { call = function(ylm) a(ylm)[{ {}, 1 }] = ylm.sh.convert({ 1, 2, 3, 4 }, "n3d") end,
      says = "coefficients of 'n3d' into an array of 'ylm'" },
    { call = function(ylm) ylm.zeros({ 2 }, "int32")[{ 1, 2 }] = 0.5 end, says = "int32 holds whole numbers" },
    { call = function(ylm) return closed(ylm)[{ 1, 2 }] end, says = "array: the array has been closed" },
  }),
  ["array:less"] = cases("less", {
    { call = function(ylm) return a(ylm) + nil end, says = "array %+: a number, an array or a table of numbers expected, got nil" },
    { call = function(ylm) return a(ylm) * "x" end, says = "array %*: .* got 'x'" },
    { call = function(ylm) return a(ylm) + ylm.zeros { 2 } end, says = "array %+: arrays of 2x3 and 2 do not fit" },
    { call = function(ylm) return a(ylm) / { 1, { 2 } } end, says = "array /: .*element 2 does not" },
    { call = function(ylm) return a(ylm) - closed(ylm) end, says = "array %-: the array has been closed" },
    { call = function(ylm) return -closed(ylm) end, says = "array %-: the array has been closed" },
    { call = function(ylm) return a(ylm) + ylm.scene "x" {} end, says = "array %+: a number, an array" },
    { call = function(ylm) return a(ylm) < a(ylm) end, says = "arrays are compared by their methods" },
    { call = function(ylm) return ylm.sh.convert({ 1, 2, 3, 4 }, "n3d") + ylm.zeros { 4 } end,
      says = "coefficients of 'n3d' and of 'ylm'" },
    { call = function(ylm) return ylm.sh.convert({ 1, 2, 3, 4 }, "n3d") * ylm.sh.convert({ 1, 2, 3, 4 }, "sn3d") end,
      says = "coefficients of 'n3d' and of 'sn3d'" },
    { call = function(ylm) return a(ylm):less() end, says = "less: a number, an array" },
  }),
  ["array:less_equal"] = cases("less_equal", {}),
  ["array:greater"] = cases("greater", {}),
  ["array:greater_equal"] = cases("greater_equal", {}),
  ["array:equal"] = cases("equal", {}),
  ["array:not_equal"] = cases("not_equal", {}),
  ["array:abs"] = cases("abs", {}),
  ["array:sqrt"] = cases("sqrt", {}),
  ["array:clamp"] = cases("clamp", {
    { call = function(ylm) a(ylm):clamp("x") end, says = "clamp: a number, an array" },
  }),
  ["array:sum"] = cases("sum", {
    { call = function(ylm) a(ylm):sum(3) end, says = "bad argument #1 to 'sum' %(an axis from 1 to 2, or %-1 to %-2" },
    { call = function(ylm) a(ylm):sum(0) end, says = "an axis from 1 to 2" },
    { call = function(ylm) a(ylm):sum { axis = 1.5 } end, says = "an axis .* got 1.5" },
    { call = function(ylm) a(ylm):sum { axis = { 1, -2 } } end, says = "axis 1 is named twice" },
    { call = function(ylm) a(ylm):sum { axis = {} } end, says = "the list of axes is empty" },
    { call = function(ylm) a(ylm):sum(1, 1) end, says = "axis 1 is named twice" },
    { call = function(ylm) a(ylm):sum(1, "x") end, says = "bad argument #2 to 'sum' %(axes, or one table of options expected, got 'x'" },
    { call = function(ylm) a(ylm):sum({ axis = 1 }, 2) end, says = "bad argument #1 to 'sum' %(axes, or one table" },
    { call = function(ylm) a(ylm):sum { axes = 1 } end, says = "no field 'axes' %(did you mean 'axis'%?%)" },
  }),
  ["array:mean"] = cases("mean", {
    { call = function(ylm) ylm.zeros({ 0 }):mean() end, says = "mean: an axis of an array of 0 has no numbers" },
  }),
  ["array:min"] = cases("min", {
    { call = function(ylm) ylm.zeros({ 2, 0 }):min(2) end, says = "min: an axis of an array of 2x0 has no numbers" },
  }),
  ["array:max"] = cases("max", {
    { call = function(ylm) ylm.zeros({ 0 }):max() end, says = "max: an axis of an array of 0 has no numbers" },
  }),
  ["array:select"] = cases("select", {
    { call = function(ylm) a(ylm):select({ 1 }) end, says = "mask: the first extents of 2x3 expected, got 1" },
    { call = function(ylm) a(ylm):select() end, says = "mask: an array or a table of numbers expected, got nil" },
  }),
  ["array:bytes"] = cases("bytes", {}),
  ["array.frombytes"] = {
    { call = function(ylm) ylm.array.frombytes() end, says = "a string of bytes expected, got nil" },
    { call = function(ylm) ylm.array.frombytes("abc", { 1 }, "float") end, says = "4 bytes expected for 1 elements of float, got 3" },
    { call = function(ylm) ylm.array.frombytes("", { 2 ^ 60, 2 ^ 60 }, "float") end, says = "bytes expected" },
    { call = function(ylm) ylm.array.frombytes("", {}) end, says = "a shape of 1 to 8 extents expected" },
    { call = function(ylm) ylm.array.frombytes("", { 0 }, "floaf") end, says = "did you mean 'float'" },
  },
  stack = {
    { call = function(ylm) ylm.stack() end, says = "a list of arrays expected, got nil" },
    { call = function(ylm) ylm.stack {} end, says = "a list of arrays expected" },
    { call = function(ylm) ylm.stack { a(ylm), { 1 } } end, says = "element 2: an array of 2x3 expected as before, got 1" },
    { call = function(ylm) ylm.stack { 1, 2 } end, says = "element 1: an array or a table of numbers expected, got 1" },
    { call = function(ylm) ylm.stack({ a(ylm) }, 4) end, says = "bad argument #2 to 'stack' %(an axis from 1 to 3" },
    { call = function(ylm) ylm.stack { { 1, 2, 3, 4 }, ylm.sh.convert({ 1, 2, 3, 4 }, "n3d") } end,
      says = "element 2: coefficients of 'n3d' beside those of 'ylm'" },
    { call = function(ylm) ylm.stack { ylm.zeros { 1, 1, 1, 1, 1, 1, 1, 1 } } end, says = "arrays of at most 7 axes expected" },
    { call = function(ylm) ylm.stack { closed(ylm) } end, says = "element 1: the array has been closed" },
  },
  wrap = {
    { call = function(ylm) ylm.wrap(nil, { 1 }) end, says = "a pointer expected .* got nil" },
    { call = function(ylm) ylm.wrap(0, { 1 }) end, says = "the pointer is NULL" },
    { call = function(ylm) ylm.wrap(-8, { 1 }) end, says = "the pointer is NULL, or no address" },
    { call = function(ylm) ylm.wrap(12, { 1 }) end, says = "no multiple of double's size" },
    { call = function(ylm) ylm.wrap(a(ylm), { 1 }) end, says = "a pointer expected .* got an array of 2x3" },
    { call = function(ylm) ylm.wrap(a(ylm):pointer(), { 2 ^ 60, 2 ^ 60 }) end, says = "more than any memory holds" },
    { call = function(ylm) ylm.wrap(a(ylm):pointer(), "x") end, says = "bad argument #2 to 'wrap'" },
    { call = function(ylm) ylm.wrap(a(ylm):pointer(), { 1 }, "half") end, says = "bad argument #3 to 'wrap'" },
  },
  ["array:totable"] = cases("totable", {}),
  ["array:clone"] = cases("clone", {}),
  ["array:print"] = cases("print", {}),
  ["array:same"] = cases("same", {
    { call = function(ylm) a(ylm):same(3) end, says = "bad argument #1 to 'same' .*an array or a table of numbers expected, got 3" },
    { call = function(ylm) a(ylm):same(a(ylm), -1) end, says = "bad argument #2 to 'same' .*tolerance must be a number >= 0, got %-1" },
    { call = function(ylm) a(ylm):same(closed(ylm)) end, says = "same: the array has been closed" },
  }),
  ["array:pointer"] = cases("pointer", {}),
  ["array:close"] = {
    { call = function(ylm) a(ylm).close("x") end, says = "close: an array expected, got 'x'" },
  },
}
