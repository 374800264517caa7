-- Refusals of products and their matrices: see spec/refusals_spec.lua.

local c = { 1, 2, 3, 4 }
local nine = { 1, 2, 3, 4, 5, 6, 7, 8, 9 }

return {
  ["sh.product"] = {
    { call = function(ylm) return ylm.sh.product() end, says = "2 to 16 factors expected, got 0" },
    { call = function(ylm) return ylm.sh.product(c) end, says = "2 to 16 factors expected, got 1" },
    { call = function(ylm) return ylm.sh.product(c, nil) end, says = "bad argument #2 to 'product' .*got nil" },
    { call = function(ylm) return ylm.sh.product(c, { 1, 2 }) end,
      says = "coefficients expected in the last axis, got 2" },
    { call = function(ylm) return ylm.sh.product(c, { 1, 2, 0 / 0, 4 }) end, says = "row 1 is not finite" },
    { call = function(ylm) return ylm.sh.product(c, nine) end, says = "lmax 2 does not fit to lmax 1 of factor 1" },
    { call = function(ylm) return ylm.sh.product({ c, c }, { c, c, c }) end, says = "2 rows do not fit to 3 rows" },
    { call = function(ylm) return ylm.sh.product(c, ylm.sh.convert(c, "plain")) end,
      says = "convention 'plain': convert" },
    { call = function(ylm) return ylm.sh.product(c, ylm.sh.convert(c, "ylm irradiance")) end,
      says = "'ylm irradiance' does not fit to 'ylm'" },
    { call = function(ylm) return ylm.sh.product(c, c, { method = "fft" }) end, says = "method must be one of" },
    { call = function(ylm) return ylm.sh.product(c, c, { metod = "auto" }) end, says = "did you mean 'method'" },
    { call = function(ylm)
      local wide = ylm.zeros { 17 ^ 2 }
      return ylm.sh.product(wide, wide, wide, { method = "gaunt" })
    end, says = "up to degree 30, needed is 32" },
    { call = function(ylm)
      local big = ylm.zeros { 400 }
      return ylm.sh.product(big, big, big, { method = "brute" })
    end, says = "too many combinations" },
    { call = function(ylm)
      local big = ylm.zeros { 102 * 102 }
      return ylm.sh.product(big, big)
    end, says = "lmax up to 100 expected, got 101" },
    { call = function(ylm)
      local a = ylm.array(c)
      return ylm.sh.product(a, a, { out = a })
    end, says = "out shares memory with an argument" },
    { call = function(ylm)
      local a = ylm.zeros { 2, 4 }
      return ylm.sh.product(a, c, { out = a[1]:reshape { 4 } })
    end, says = "out must be a double array of 2x4" },
    { call = function(ylm)
      local a = ylm.array { c, c }
      return ylm.sh.product(a[1], c, { out = a[1] })
    end, says = "out shares memory with an argument" },
    { call = function(ylm) return ylm.sh.product(c, c, { threads = 0 }) end, says = "threads must be an integer >= 1" },
    { call = function(ylm) return ylm.sh.product(c, c, { progress = 1 }) end, says = "progress must be a function" },
  },
  ["sh.product_method"] = {
    { call = function(ylm) return ylm.sh.product_method(-1, 2) end, says = "lmax must be an integer from 0 to 100" },
    { call = function(ylm) return ylm.sh.product_method(1e6, 2) end, says = "lmax must be an integer" },
    { call = function(ylm) return ylm.sh.product_method(2, 17) end, says = "factors must be an integer from 2 to 16" },
    { call = function(ylm) return ylm.sh.product_method(2, 2, "x") end, says = "one of 'auto'.*got 'x'" },
    { call = function(ylm) return ylm.sh.product_method(40, 2, "gaunt") end, says = "up to degree 30, needed is 40" },
  },
  ["sh.product_matrix"] = {
    { call = function(ylm) return ylm.sh.product_matrix(nil, 2) end, says = "got nil" },
    { call = function(ylm) return ylm.sh.product_matrix({ c, c }, 2) end,
      says = "one vector of coefficients expected, got 2" },
    { call = function(ylm) return ylm.sh.product_matrix(c) end, says = "lmax must be an integer from 0 to 50, got nil" },
    { call = function(ylm) return ylm.sh.product_matrix(c, 51) end, says = "lmax must be an integer from 0 to 50" },
    { call = function(ylm) return ylm.sh.product_matrix(ylm.sh.convert(c, "sn3d"), 1) end, says = "convention 'sn3d'" },
  },
  ["sh.apply"] = {
    { call = function(ylm) return ylm.sh.apply(nil, c) end, says = "a matrix of 4x4 expected, got nil" },
    { call = function(ylm) return ylm.sh.apply(ylm.zeros { 9, 9 }, c) end, says = "a matrix of 4x4 expected" },
    { call = function(ylm) return ylm.sh.apply(ylm.zeros { 3, 4, 4 }, { c, c }) end,
      says = "or a stack of them that fits c of 2x4 .*got .*3x4x4" },
    { call = function(ylm) return ylm.sh.apply(ylm.zeros { 3, 3, 4, 4 }, { c, c }) end, says = "that fits c of 2x4" },
    { call = function(ylm) return ylm.sh.apply(ylm.zeros { 4, 4 }, { 1, 2 }) end,
      says = "coefficients expected" },
  },
  ["sh.exp"] = {
    { call = function(ylm) ylm.sh.exp({ 1, 2 }) end, says = "coefficients expected in the last axis, got 2" },
    { call = function(ylm) ylm.sh.exp({ 0, 1e3, 0, 0 }) end, says = "row 1: the series diverges" },
    { call = function(ylm) ylm.sh.exp({ 1 }, { terms = 65 }) end, says = "terms must be" },
  },
  ["sh.circle_log"] = {
    { call = function(ylm) ylm.sh.circle_log(3, { 0, 0, 1 }, 4) end, says = "angle must be a number >= 0 and <= pi, got 4" },
    { call = function(ylm) ylm.sh.circle_log(3, { 0, 0, 0 }, 1) end, says = "direction must be" },
    { call = function(ylm) ylm.sh.circle_log(3, { 0, 0, 1 }, math.pi) end, says = "leaves nothing open" },
    { call = function(ylm) ylm.sh.circle_log(3, { 0, 0, 1 }, 1, { epsilon = 0 }) end, says = "epsilon must be" },
    { call = function(ylm) ylm.sh.circle_log(101, { 0, 0, 1 }, 1) end, says = "lmax must be" },
  },
  ["sh.log"] = {
    { call = function(ylm) ylm.sh.log({ -1, 0, 0, 0 }) end, says = "row 1: there is no logarithm" },
    { call = function(ylm) ylm.sh.log({ 1 }, { epsilon = 2 }) end, says = "epsilon must be" },
  },
}
