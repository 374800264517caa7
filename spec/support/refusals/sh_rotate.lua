-- Refusals of rotation and conventions: see spec/refusals_spec.lua.

local nan, inf = 0 / 0, math.huge

local c = { 1, 2, 3, 4 }
local turn = { axis = { 0, 0, 1 }, angle = 1 }

local function closed(ylm)
  local a = ylm.array(c)
  a:close()
  return a
end

--- Coefficients that are none, for function `f`.
local function bad_coefficients(f)
  return
    { call = function(ylm) return f(ylm, nil) end,
      says = "coefficients: a table of numbers or an array expected, got nil" },
    { call = function(ylm) return f(ylm, { 1, 2, 3 }) end,
      says = "%(lmax%+1%)^2 coefficients expected in the last axis, got 3" },
    { call = function(ylm) return f(ylm, {}) end, says = "%(lmax%+1%)^2 coefficients expected" },
    { call = function(ylm) return f(ylm, { 1, "x", 3, 4 }) end, says = "element 2 does not" },
    { call = function(ylm) return f(ylm, closed(ylm)) end, says = "closed" }
end

local function list(...) return { ... } end

local rotate = list(bad_coefficients(function(ylm, x) return ylm.sh.rotate(x, turn) end))
for _, case in ipairs {
  { call = function(ylm) return ylm.sh.rotate({ 1, 2, nan, 4 }, turn) end, says = "row 1 is not finite" },
  { call = function(ylm) return ylm.sh.rotate(c, closed(ylm)) end, says = "3x3 rotation.* expected, got a closed array" },
  { call = function(ylm) return ylm.sh.rotate(c) end, says = "3x3 rotation, .* expected, got nil" },
  { call = function(ylm) return ylm.sh.rotate(c, "x") end, says = "3x3 rotation, .* expected, got 'x'" },
  { call = function(ylm) return ylm.sh.rotate(c, {}) end, says = "got an empty table" },
  { call = function(ylm) return ylm.sh.rotate(c, { { -1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }) end,
    says = "determinant is %-1" },
  { call = function(ylm) return ylm.sh.rotate(c, { { 1, 0.1, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }) end,
    says = "columns are not orthonormal" },
  { call = function(ylm) return ylm.sh.rotate(c, { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }) end,
    says = "columns are not orthonormal" },
  { call = function(ylm) return ylm.sh.rotate(c, { { nan, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }) end,
    says = "3x3 rotation" },
  { call = function(ylm) return ylm.sh.rotate(c, { 1, 2, 3 }) end, says = "3x3 rotation" },
  { call = function(ylm) return ylm.sh.rotate(c, { axis = { 0, 0, 0 }, angle = 1 }) end, says = "an axis .* not zero" },
  { call = function(ylm) return ylm.sh.rotate(c, { axis = { 0, 0, 1 } }) end, says = "got {axis}" },
  { call = function(ylm) return ylm.sh.rotate(c, { axis = { 0, 0, 1 }, angle = inf }) end, says = "got {angle axis}" },
  { call = function(ylm) return ylm.sh.rotate(c, { axis = { 0, 0 }, angle = 1 }) end,
    says = "finite numbers expected in {angle axis}" },
  { call = function(ylm) return ylm.sh.rotate(c, { quaternoin = { 1, 0, 0, 0 } }) end,
    says = "did you mean 'quaternion'" },
  { call = function(ylm) return ylm.sh.rotate(c, { quaternion = { 0, 0, 0, 0 } }) end, says = "not all zero" },
  { call = function(ylm) return ylm.sh.rotate(c, { zyz = { 0, 0, nan } }) end,
    says = "finite numbers expected in {zyz}" },
  { call = function(ylm) return ylm.sh.rotate(c, ylm.sh.rotation(0, turn)) end,
    says = "rotation up to lmax 0, coefficients up to 1" },
  { call = function(ylm) return ylm.sh.rotate(ylm.zeros { 130 * 130 }, turn) end,
    says = "lmax up to 128 expected, got 129" },
  { call = function(ylm) return ylm.sh.rotate(ylm.sh.convert(c, "sn3d"), turn) end,
    says = "convention 'sn3d': convert" },
  { call = function(ylm) return ylm.sh.rotate(c, turn, { thraeds = 1 }) end, says = "did you mean 'threads'" },
  { call = function(ylm) return ylm.sh.rotate(c, turn, { out = ylm.zeros { 3 } }) end,
    says = "out must be a double array of 4" },
  { call = function(ylm) return ylm.sh.rotate(c, turn, { threads = 0 }) end, says = "threads must be an integer >= 1" },
  { call = function(ylm)
    local a = ylm.array { c, c, c }
    return ylm.sh.rotate(a[2], turn, { out = ylm.array(a)[2], progress = 7 })
  end, says = "progress must be a function" },
  { call = function(ylm)
    local a = ylm.zeros { 8 }
    return ylm.sh.rotate(a:reshape { 2, 4 }, turn, { out = a:reshape { 2, 4 } })
  end, says = "out shares memory with an argument" },
  { call = function(ylm)
    return ylm.sh.rotate(c, turn, { method = "reference", out = ylm.zeros { 4 } })
  end, says = "takes no out" },
  { call = function(ylm) return ylm.sh.rotate(c, turn, { method = "slow" }) end, says = "method must be one of" },
} do rotate[#rotate + 1] = case end

local convert = {
  { call = function(ylm) return ylm.sh.convert(nil, "plain") end,
    says = "a table of numbers or an array expected, got nil" },
  { call = function(ylm) return ylm.sh.convert({ 1, 2, 3 }, "plain") end,
    says = "'ylm' wants %[..%]%[%(lmax%+1%)^2%]" },
  { call = function(ylm) return ylm.sh.convert({ 1, inf, 3, 4 }, "plain") end, says = "number 2 is not finite" },
  { call = function(ylm) return ylm.sh.convert(c) end, says = "the name of a convention expected, got nil" },
  { call = function(ylm) return ylm.sh.convert(c, "unty") end, says = "'unty' is no convention.*did you mean 'unity'" },
  { call = function(ylm) return ylm.sh.convert(c, "plain x,y,y") end, says = "'x,y,y' is no convention" },
  { call = function(ylm) return ylm.sh.convert(c, "plain plain") end, says = "'plain' is no convention" },
  { call = function(ylm) return ylm.sh.convert(c, "unity irradiance") end, says = "hold irradiance anyway" },
  { call = function(ylm) return ylm.sh.convert(c, "unity") end, says = "holds three channels" },
  { call = function(ylm) return ylm.sh.convert({ c, c, c }, "unity") end, says = "holds lmax 2, got lmax 1" },
  { call = function(ylm) return ylm.sh.convert(c, "ylm", { from = "unity" }) end,
    says = "'unity' wants %[..%]%[7%]%[4%]" },
  { call = function(ylm) return ylm.sh.convert(c, "ylm", { from = "scipy" }) end, says = "real and imaginary parts" },
  { call = function(ylm) return ylm.sh.convert(ylm.sh.convert(c, "plain"), "ylm", { from = "sn3d" }) end,
    says = "the array says it is 'plain', from says 'sn3d'" },
  { call = function(ylm) return ylm.sh.convert(ylm.zeros { 16 }, "ylm", { from = "ylm irradiance" }) end,
    says = "irradiance holds nothing of degree 3" },
  { call = function(ylm) return ylm.sh.convert(c, "plain", { form = "ylm" }) end, says = "did you mean 'from'" },
  { call = function(ylm) return ylm.sh.convert(c, "plain", { threads = 0 }) end,
    says = "threads must be an integer >= 1" },
  { call = function(ylm)
    local a = ylm.array(c)
    return ylm.sh.convert(a, "plain", { out = a })
  end, says = "out shares memory with an argument" },
}

local resize = list(bad_coefficients(function(ylm, x) return ylm.sh.resize(x, 1) end))
for _, case in ipairs {
  { call = function(ylm) return ylm.sh.resize(c, -1) end, says = "lmax must be an integer from 0" },
  { call = function(ylm) return ylm.sh.resize(c, 1e6) end, says = "lmax must be an integer from 0" },
  { call = function(ylm) return ylm.sh.resize(ylm.sh.convert(ylm.zeros { 3, 9 }, "three.js"), 1) end,
    says = "coefficients" },
} do resize[#resize + 1] = case end

return {
  ["sh.rotate"] = rotate,
  ["sh.rotation"] = {
    { call = function(ylm) return ylm.sh.rotation(-1, turn) end, says = "lmax must be an integer from 0 to 128" },
    { call = function(ylm) return ylm.sh.rotation(1e6, turn) end, says = "lmax must be an integer" },
    { call = function(ylm) return ylm.sh.rotation(2.5, turn) end, says = "lmax must be an integer" },
    { call = function(ylm) return ylm.sh.rotation(2) end, says = "3x3 rotation, .* got nil" },
    { call = function(ylm) return ylm.sh.rotation(2, { { 1, 0, 0 }, { 0, 0, 1 }, { 0, 1, 0 } }) end,
      says = "determinant is %-1" },
    { call = function(ylm) return ylm.sh.rotation(2, turn, { dtype = "half" }) end, says = "dtype must be one of" },
  },
  ["sh_rotation:block"] = {
    { call = function(ylm) return ylm.sh.rotation(2, turn):block(3) end, says = "l must be an integer from 0 to 2" },
    { call = function(ylm) return ylm.sh.rotation(2, turn):block() end, says = "l must be an integer" },
    { call = function(ylm) return ylm.sh.rotation(2, turn).block(3, 1) end,
      says = "a rotation expected before the colon" },
  },
  ["sh.convert"] = convert,
  ["sh.resize"] = resize,
}
