--- ylm.sh: spherical harmonics. Indices are here, the toolbox in `parts`.
--
-- Real, orthonormal, with the Condon-Shortley phase; indices are one-based, index(l, m) = l(l+1) + m + 1.

local args = require "ylm.sh.args"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local memory = require "ylm.memory"

local sh = {}

--- Modules that add functions to ylm.sh, loaded when one of their names is first used.
local parts = {
  { "ylm.sh.eval", "eval", "reconstruct" },
  { "ylm.sh.rotate", "rotate", "rotation" },
  { "ylm.sh.convert", "convert", "resize" },
  { "ylm.sh.product", "product", "product_method", "product_matrix", "apply" },
  { "ylm.sh.exponential", "exp", "log", "circle_log" },
  { "ylm.sh.project", "project" },
  { "ylm.sh.zonal", "zonal", "convolve", "cap", "irradiance", "zonal_irradiance" },
  { "ylm.sh.sky", "sky" },
  { "ylm.sh.window", "window", "dering", "summary", "random", "relative_error" },
}

local home = {}
for _, part in ipairs(parts) do
  for i = 2, #part do home[part[i]] = part[1] end
end

--- Every name of the table, sorted, those not loaded yet included.
local function listed()
  local names = {}
  for name in pairs(home) do names[#names + 1] = name end
  for name in pairs(sh) do if not home[name] then names[#names + 1] = name end end
  table.sort(names)
  return names
end

setmetatable(sh, {
  __index = function(t, name)
    if not home[name] then return check.no_name("sh.", name, listed()) end
    local value = memory.public(require(home[name])[name])
    rawset(t, name, value)
    return value
  end,
  __names = listed,
})

-- Indices -------------------------------------------------------------------------

describe "sh.count" {
  about = "The number of coefficients of all degrees up to lmax.",
  arguments = { { "lmax", "integer", "highest degree, from 0 to 1000" } },
  returns = { { "count", "integer", "(lmax+1)^2" } },
  errors = "raises where lmax is no such integer",
  example = "assert(ylm.sh.count(4) == 25)",
}
function sh.count(lmax)
  check.integer(1, "count", "lmax", lmax, 0, core.limits.sh_lmax)
  return (lmax + 1) * (lmax + 1)
end

describe "sh.index" {
  about = "The one-based index of the coefficient of degree l and order m.",
  arguments = { { "l", "integer", "degree, from 0 to 1000" }, { "m", "integer", "from -l to l" } },
  returns = { { "index", "integer", "l(l+1) + m + 1" } },
  errors = "raises where l or m is out of range",
  example = "assert(ylm.sh.index(0, 0) == 1 and ylm.sh.index(2, -2) == 5)",
}
function sh.index(l, m)
  check.integer(1, "index", "l", l, 0, core.limits.sh_lmax)
  check.integer(2, "index", "m", m, -l, l)
  return l * (l + 1) + m + 1
end

describe "sh.degree" {
  about = "The degree and the order of a one-based index; the inverse of sh.index.",
  arguments = { { "index", "integer", "1 or more" } },
  returns = { { "l", "integer", "degree" }, { "m", "integer", "order" } },
  errors = "raises where the index is no such integer",
  example = [[
local l, m = ylm.sh.degree(5)
assert(l == 2 and m == -2)]],
}
function sh.degree(index)
  check.integer(1, "degree", "index", index, 1, (core.limits.sh_lmax + 1) ^ 2)
  local l = math.floor(math.sqrt(index - 1))
  return l, index - 1 - l * (l + 1)
end

local lmax_of = args.lmax_of

describe "sh.lmax" {
  about = "The highest degree of a number of coefficients; the inverse of sh.count.",
  arguments = { { "count", "integer", "" } },
  returns = { { "lmax", "integer|nil", "nil where the number is no (lmax+1)^2" } },
  errors = "raises where count is no positive integer",
  example = "assert(ylm.sh.lmax(25) == 4 and ylm.sh.lmax(24) == nil)",
}
function sh.lmax(count)
  check.integer(1, "lmax", "count", count, 1)
  return lmax_of(count)
end

return memory.publish(sh)
