-- Refusals of counting, evaluation and reconstruction: see spec/refusals_spec.lua.

local nan, inf = 0 / 0, math.huge

local up = { 0, 0, 1 }

local function closed(ylm)
  local a = ylm.array({ up })
  a:close()
  return a
end

local rows = require "spec.support.refused"

return {
  ["sh.count"] = rows(
    function(ylm) return ylm.sh.count() end, "lmax must be an integer from 0 to 1000, got nil",
    function(ylm) return ylm.sh.count(-1) end, "got %-1",
    function(ylm) return ylm.sh.count(1e6) end, "from 0 to 1000",
    function(ylm) return ylm.sh.count(1.5) end, "integer",
    function(ylm) return ylm.sh.count(nan) end, "integer",
    function(ylm) return ylm.sh.count("4") end, "got '4'"),
  ["sh.index"] = rows(
    function(ylm) return ylm.sh.index(2, 3) end, "m must be an integer from %-2 to 2, got 3",
    function(ylm) return ylm.sh.index(-1, 0) end, "l must be an integer from 0",
    function(ylm) return ylm.sh.index(2) end, "m must be",
    function(ylm) return ylm.sh.index(inf, 0) end, "l must be",
    function(ylm) return ylm.sh.index({}, 0) end, "got a table"),
  ["sh.degree"] = rows(
    function(ylm) return ylm.sh.degree(0) end, "index must be an integer",
    function(ylm) return ylm.sh.degree(nan) end, "index must be",
    function(ylm) return ylm.sh.degree(1e18) end, "index must be",
    function(ylm) return ylm.sh.degree("a") end, "got 'a'"),
  ["sh.lmax"] = rows(
    function(ylm) return ylm.sh.lmax(0) end, "count must be an integer",
    function(ylm) return ylm.sh.lmax(2.5) end, "count must be",
    function(ylm) return ylm.sh.lmax() end, "got nil"),
  ["sh.eval"] = rows(
    function(ylm) return ylm.sh.eval(-1, up) end, "lmax must be an integer from 0 to 1000, got %-1",
    function(ylm) return ylm.sh.eval(1e6, up) end, "lmax must be",
    function(ylm) return ylm.sh.eval("x", up) end, "got 'x'",
    function(ylm) return ylm.sh.eval(2) end, "a table of numbers or an array expected, got nil",
    function(ylm) return ylm.sh.eval(2, { 1, 2 }) end, "rows of 3 numbers expected",
    function(ylm) return ylm.sh.eval(2, { { 1, 2, 3 }, { 1, 2 } }) end, "element 4 does not",
    function(ylm) return ylm.sh.eval(2, { "a", "b", "c" }) end, "element 1 does not",
    function(ylm) return ylm.sh.eval(2, closed(ylm)) end, "closed",
    function(ylm) return ylm.sh.eval(2, { up, { 0, 0, 0 } }) end, "point 2 is zero",
    function(ylm) return ylm.sh.eval(2, { up, { 0, nan, 0 } }) end, "row 2 is not finite",
    function(ylm) return ylm.sh.eval(2, { up, up, { inf, 0, 0 } }) end, "row 3 is not finite",
    function(ylm) return ylm.sh.eval(2, up, { derivatives = 3 }) end,
    "derivatives must be an integer >= 0 and <= 2",
    function(ylm) return ylm.sh.eval(2, up, { derivative = 1 }) end, "did you mean 'derivatives'",
    function(ylm) return ylm.sh.eval(2, up, { dtype = "half" }) end, "dtype must be one of",
    function(ylm) return ylm.sh.eval(2, up, { method = "magic" }) end, "method must be one of",
    function(ylm) return ylm.sh.eval(2, up, { kernel = "mmx" }) end, "kernel must be one of",
    function(ylm) return ylm.sh.eval(2, up, { threads = -1 }) end, "threads must be",
    function(ylm) return ylm.sh.eval(2, up, { threads = 0 }) end, "threads must be an integer >= 1",
    function(ylm)
      local both = ylm.zeros { 4, 3 }
      for i = 1, 4 do both:set(i, 1, 1) end
      return ylm.sh.eval(1, both, { derivatives = 1, out = { nil, both } })
    end, "out%[2%] must be a double array of 4x4x3",
    function(ylm)
      local p = ylm.array { { 1, 2, 3 } }
      return ylm.sh.eval(0, p, { out = p[1] })
    end, "out%[1%] must be a double array of 1x1",
    function(ylm) return ylm.sh.eval(2, up, { progress = 3 }) end, "progress must be",
    function(ylm) return ylm.sh.eval(2, up, 7) end, "a table of options expected",
    function(ylm) return ylm.sh.eval(2, up, { out = ylm.zeros({ 8 }) }) end,
    "out%[1%] must be a double array of 9",
    function(ylm) return ylm.sh.eval(2, up, { out = 5 }) end, "out must be an array",
    function(ylm) return ylm.sh.eval(2, up, { out = { ylm.zeros({ 9 }), up }, derivatives = 1 }) end,
    "out%[2%] must be an array",
    function(ylm) return ylm.sh.eval(7, up, { method = "polynomial" }) end, "method 'polynomial' goes to lmax 6",
    function(ylm) return ylm.sh.eval(2, up, { method = "sloan", derivatives = 2 }) end, "no second derivatives",
    function(ylm) return ylm.sh.eval(2, up, { method = "scd", solid = true }) end, "has no solid harmonics",
    function(ylm) return ylm.sh.eval(60, { 1e30, 0, 0 }, { solid = true }) end, "point 1 is too long",
    function(ylm) return ylm.sh.eval(2, { up, { 1e-30, 0, 0 } }, { dtype = "float", derivatives = 2 }) end,
    "point 2 is too short"),
  ["sh.reconstruct"] = rows(
    function(ylm) return ylm.sh.reconstruct() end, "coefficients: a table of numbers or an array expected",
    function(ylm) return ylm.sh.reconstruct({ 1, 2, 3 }, up) end,
    "%(lmax%+1%)^2 coefficients expected in the last axis, got 3",
    function(ylm) return ylm.sh.reconstruct({}, up) end, "coefficients expected in the last axis",
    function(ylm) return ylm.sh.reconstruct({ 1 }, { 0, 0, 0 }) end, "point 1 is zero",
    function(ylm) return ylm.sh.reconstruct({ 1 }, { nan, 0, 0 }) end, "row 1 is not finite",
    function(ylm) return ylm.sh.reconstruct({ 1 }, up, { thread = 1 }) end, "did you mean 'threads'",
    function(ylm) return ylm.sh.reconstruct({ 1 }, { up, up }, { out = ylm.zeros(3) }) end, "out must be a double array of 2",
    function(ylm) return ylm.sh.reconstruct({ 1 }, up, { threads = 0 }) end, "threads must be an integer >= 1",
    function(ylm)
      local p = ylm.array { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }
      return ylm.sh.reconstruct({ { 1 }, { 2 }, { 3 } }, p, { out = p })
    end, "out shares memory with an argument"),
}
