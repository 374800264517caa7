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
    { call = function(ylm) ylm.array({ 1 }, "half") end, says = "dtype must be 'float' or 'double', got 'half'" },
    { call = function(ylm) ylm.array { { { { { { { { { 1 } } } } } } } } } end, says = "at most 8 axes, got more" },
    { call = function(ylm) ylm.array(itself()) end, says = "does the table hold itself" },
    { call = function(ylm) ylm.sh.eval(1, itself()) end, says = "does the table hold itself" },
    { call = function(ylm) ylm.array(closed(ylm)) end, says = "closed" },
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
  }),
  ["array:set"] = cases("set", {
    { call = function(ylm) a(ylm):set(1, 1) end, says = "set: indices .* and a number expected" },
    { call = function(ylm) a(ylm):set(3, 1, 5) end, says = "set: indices" },
    { call = function(ylm) a(ylm):set(1, 1, "x") end, says = "set: indices" },
  }),
  ["array:reshape"] = cases("reshape", {
    { call = function(ylm) a(ylm):reshape(6) end, says = "a table of extents expected, got 6" },
    { call = function(ylm) a(ylm):reshape { 4 } end, says = "elements in all expected" },
    { call = function(ylm) a(ylm):reshape { -2, -3 } end, says = "elements in all expected" },
    { call = function(ylm) a(ylm):reshape {} end, says = "elements in all expected" },
  }),
  ["array:totable"] = cases("totable", {}),
  ["array:clone"] = cases("clone", {}),
  ["array:pointer"] = cases("pointer", {}),
  ["array:close"] = {
    { call = function(ylm) a(ylm).close("x") end, says = "close: an array expected, got 'x'" },
  },
}
