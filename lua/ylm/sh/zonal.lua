--- ylm.sh.zonal, .convolve, .cap, .irradiance, .zonal_irradiance: functions that are symmetric about an axis.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local convert = require "ylm.sh.convert"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local eval = require "ylm.sh.eval"
local form = require "ylm.form"

local axial = {}

local pi = math.pi

--- Argument `n` as a list of lmax+1 finite zonal coefficients.
local function zonal_of(n, name, z)
  local a = array.rows(n, name, "zonal coefficients", z, nil, "double")
  local shape = core.array_info(a)
  if #shape ~= 1 or shape[1] < 1 then
    return check.bad(n, name, "a list of lmax+1 zonal coefficients expected, got %s", check.describe(a))
  end
  if not core.array_finite(a) then return check.bad(n, name, "zonal coefficients must be finite") end
  return core.array_totable(a)
end

--- A direction argument as a table of three numbers.
local function direction_of(n, name, what, d)
  local good, wanted = form.types.vector(d)
  if not good then return check.bad(n, name, "%s must be %s, got %s", what, wanted, check.describe(d)) end
  return good
end

describe "sh.zonal" {
  about = "Turns a function that is symmetric about z, given by its coefficients Y(l, 0), to look along a direction.",
  arguments = {
    { "z", "array|table", "[lmax+1]" }, { "direction", "table", "{x, y, z}, any length but 0" },
  },
  returns = { { "c", "array", "[(lmax+1)^2]: sqrt(4 pi / (2l+1)) z_l Y_lm(direction)" } },
  errors = "raises on a zero direction and on what is no list of numbers",
  example = "assert(math.abs(ylm.sh.zonal({ 0, 1 }, { 0, 1, 0 })[2] + 1) < 1e-15)",
  source = "Mezieres et al. 2022, Eq. 11",
}
function axial.zonal(z, direction)
  local list = zonal_of(1, "zonal", z)
  local d = direction_of(2, "zonal", "direction", direction)
  local lmax = #list - 1
  check.integer(1, "zonal", "lmax", lmax, 0, core.limits.sh_lmax)
  local Y = eval.eval(lmax, d)
  local factors = {}
  for l = 0, lmax do factors[l + 1] = math.sqrt(4 * pi / (2 * l + 1)) * list[l + 1] end
  assert(core.sh_degree_scale(Y, Y, lmax, factors))
  return args.held("zonal", Y)
end

describe "sh.convolve" {
  shelf = "everyday",
  about = "Convolves functions with a kernel that is symmetric about z: c_lm times sqrt(4 pi / (2l+1)) z_l.",
  arguments = {
    { "c", "array|table", "[..][(lmax+1)^2]" },
    { "zonal", "array|table", "[lmax+1]: coefficients Y(l, 0) of the kernel; missing ones are 0" },
  },
  returns = { { "c", "array", "of the same shape, type and convention" } },
  errors = "raises where the shapes do not fit",
  example = [[
local c = ylm.sh.convolve({ 1, 2, 3, 4 }, { math.sqrt(1 / (4 * math.pi)), 0 })   -- keeps the mean
assert(math.abs(c[1] - 1) < 1e-15 and c[3] == 0)]],
  source = "Green 2003; Ramamoorthi & Hanrahan 2001",
}
function axial.convolve(c, zonal)
  local a, lmax, shape, dtype, _, convention = args.coefficients(1, "convolve", c)
  local list = zonal_of(2, "convolve", zonal)
  local factors = {}
  for l = 0, lmax do factors[l + 1] = math.sqrt(4 * pi / (2 * l + 1)) * (list[l + 1] or 0) end
  local out, message, code = args.result("convolve", nil, shape, dtype, convention)
  if not out then return nil, message, code end
  assert(core.sh_degree_scale(a, out, lmax, factors))
  return args.held("convolve", out)
end

--- P_l(x) for l = 0 .. lmax+1.
local function legendre(lmax, x)
  local p = { [0] = 1, [1] = x }
  for l = 1, lmax do p[l + 1] = ((2 * l + 1) * x * p[l] - l * p[l - 1]) / (l + 1) end
  return p
end

describe "sh.cap" {
  about = "The coefficients of a cap: 1 within an angle of a direction, else 0. A disc-shaped light far away.",
  arguments = {
    { "lmax", "integer", "" }, { "direction", "table", "{x, y, z}, any length but 0" },
    { "angle", "number", "half-angle, from 0 to pi, radians" },
  },
  returns = { { "c", "array", "[(lmax+1)^2]" }, { "zonal", "array", "[lmax+1]: of the cap about z" } },
  errors = "raises on an angle or a direction that is none",
  example = [[
local c = ylm.sh.cap(3, { 0, 0, 1 }, math.pi)          -- everything
assert(math.abs(c[1] - math.sqrt(4 * math.pi)) < 1e-14 and math.abs(c[3]) < 1e-14)]],
  source = "Green 2003, \"synth_light\"; Mezieres et al. 2022, Eq. 9",
}
function axial.cap(lmax, direction, angle)
  check.integer(1, "cap", "lmax", lmax, 0, core.limits.sh_lmax - 1)
  local d = direction_of(2, "cap", "direction", direction)
  if not check.is_number(angle) or angle < 0 or angle > pi then
    return check.bad(3, "cap", "angle must be a number >= 0 and <= pi, got %s", check.describe(angle))
  end
  -- P(l-1) - P(l+1) = (2l+1)/(l(l+1)) sin^2 P_l', without cancellation; P_l' by its recurrence
  local x, s = math.cos(angle), math.sin(angle)
  local p = legendre(lmax, x)
  local z, before, derivative = { math.sqrt(pi) * 2 * math.sin(angle / 2) ^ 2 }, 0, 1
  for l = 1, lmax do
    z[l + 1] = math.sqrt(pi / (2 * l + 1)) * (2 * l + 1) / (l * (l + 1)) * s * s * derivative
    before, derivative = derivative, before + (2 * l + 1) * p[l]
  end
  return axial.zonal(z, d), (array.array(z))
end

-- Irradiance -----------------------------------------------------------------------------------

local irradiance_options = {
  { "method", "choice", shelf = "comparison", of = { "full", "quadratic" }, default = "full",
    about = "quadratic: the polynomial of Ramamoorthi & Hanrahan 2001, degrees to 2" },
  form.threads,
}

describe "sh.irradiance" {
  shelf = "everyday",
  about = "The irradiance of surfaces under radiance given by coefficients, by their normals.",
  arguments = {
    { "c", "array|table", "[..][(lmax+1)^2], radiance" },
    { "normals", "array|table", "[m][3] or one; of any length but 0" },
    { "options?", "table", "see the options" },
  },
  options = irradiance_options,
  returns = { { "E", "array|number", "[..][m], as sh.reconstruct gives" } },
  errors = "raises where c is irradiance already, or of another system; on a zero normal",
  example = [[
local E = ylm.sh.irradiance({ math.sqrt(4 * math.pi) }, { 0, 1, 0 })   -- radiance 1 from everywhere
assert(math.abs(E - math.pi) < 1e-14)]],
  source = "Ramamoorthi & Hanrahan 2001, Eqs. 11-13",
}
function axial.irradiance(c, normals, options)
  local o = form.options(3, "irradiance", irradiance_options, options)
  local a, lmax, shape, dtype, _, convention = args.coefficients(1, "irradiance", c)
  if convention ~= 0 then
    return check.bad(1, "irradiance", "coefficients are of convention '%s': convert them to 'ylm' first",
      core.sh_convention_name(convention))
  end
  if o.method == "quadratic" and lmax > 2 then
    a = convert.resize(a, 2)
    lmax, shape = 2, core.array_info(a)
  end
  local factors = {}
  for l = 0, lmax do factors[l + 1] = core.sh_cosine_factor(l) end
  local e, message, code = args.result("irradiance", nil, shape, dtype)
  if not e then return nil, message, code end
  assert(core.sh_degree_scale(a, e, lmax, factors))
  return args.reconstruct("irradiance", e, normals, o)
end

describe "sh.zonal_irradiance" {
  about = "The irradiance under radiance that is symmetric about a direction, by the cosine between it and the normal: "
    .. "c3 L2 z^2 + 2 c2 L1 z + c4 L0 - c5 L2, degrees to 2.",
  arguments = {
    { "zonal", "array|table", "[3 or more]: coefficients Y(l, 0) of the radiance" },
    { "cosine", "number|table", "one cosine, or a list of them" },
  },
  returns = { { "E", "number|table", "one number, or a list" } },
  errors = "raises where there are fewer than three coefficients or a cosine is beyond 1",
  example = [[
local c, zonal = ylm.sh.cap(2, { 0, 0, 1 }, 0.5)
local E = ylm.sh.irradiance(c, { 0, 0.6, 0.8 })
assert(math.abs(ylm.sh.zonal_irradiance(zonal, 0.8) - E) < 1e-14)]],
  source = "Mezieres et al. 2022 (virtual lights), appendix B",
}
function axial.zonal_irradiance(zonal, cosine)
  local z = zonal_of(1, "zonal_irradiance", zonal)
  if #z < 3 then return check.bad(1, "zonal_irradiance", "three zonal coefficients or more expected, got %d", #z) end
  -- A_1 sqrt(3/4pi)/2, A_2 sqrt(5/4pi) 3/2, A_0 sqrt(1/4pi), A_2 sqrt(5/4pi)/2
  local c2, c3 = math.sqrt(pi / 12), 3 * math.sqrt(5 * pi) / 16
  local c4, c5 = pi * math.sqrt(1 / (4 * pi)), math.sqrt(5 * pi) / 16
  local function one(x)
    if not check.is_number(x) or x < -1 or x > 1 then
      return check.bad(2, "zonal_irradiance", "a cosine from -1 to 1 expected, got %s", check.describe(x))
    end
    return c3 * z[3] * x * x + 2 * c2 * z[2] * x + c4 * z[1] - c5 * z[3]
  end
  if type(cosine) ~= "table" then return one(cosine) end
  local list = {}
  for i, x in ipairs(cosine) do list[i] = one(x) end
  return list
end

axial.legendre = legendre -- sh/sky.lua

return axial
