--- ylm.sh.convert, ylm.sh.resize: what coefficients mean, and the way between conventions.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local progress = require "ylm.progress"

local convert = {}

local packed = { unity = { 7, 4 }, ["three.js"] = { 9, 3 }, filament = { 9, 3 } }

--- Systems of even degrees only: (lmax+1)(lmax+2)/2 numbers.
local even = { mrtrix = true, dipy = true }

--- Every name of a system, other names of some included.
convert.systems = { "ylm", "plain", "sphericart", "n3d", "sn3d", "scipy", "sph_harm_y", "unity", "three.js", "filament", "lovr",
  "e3nn", "e3nn-component", "e3nn-norm", "3dgs", "mrtrix", "dipy" }

--- The highest degree of that many even coefficients, or nil.
local function even_lmax(count)
  local l = math.floor((math.sqrt(8 * count + 1) - 3) / 2 + 0.5)
  if l >= 0 and l % 2 == 0 and l <= core.limits.sh_lmax and (l + 1) * (l + 2) / 2 == count then return l end
end

--- A convention argument as number and system name.
local function convention_of(n, name, value)
  if type(value) ~= "string" then
    return check.bad(n, name, "the name of a convention expected, got %s", check.describe(value))
  end
  local number, message = core.sh_convention(value)
  if not number then
    local guess = check.guess(value:match "^%S*", convert.systems)
    return check.bad(n, name, "%s%s", message, guess and guess ~= value
      and (" (did you mean '%s'?)"):format(guess) or "")
  end
  return number, core.sh_convention_name(number):match("^%S+")
end

--- The leading extents, rows and lmax of an array of that system's shape.
local function measure(n, name, a, system)
  local shape = core.array_info(a)
  local tail = packed[system]
  local function bad(what) return check.bad(n, name, "'%s' wants %s, got %s", system, what, check.describe(a)) end
  local lead, rows, lmax = {}, 1
  if tail then
    local wanted = ("[..][%d][%d]"):format(tail[1], tail[2])
    if #shape < 2 or shape[#shape - 1] ~= tail[1] or shape[#shape] ~= tail[2] then return bad(wanted) end
    for i = 1, #shape - 2 do lead[i] = shape[i] end
    lead[#lead + 1] = 3
    lmax = 2
  elseif system == "scipy" or system == "3dgs" then
    local width = system == "scipy" and 2 or 3
    lmax = #shape > 1 and shape[#shape] == width and args.lmax_of(shape[#shape - 1])
    if not lmax then
      return bad(width == 2 and "[..][(lmax+1)^2][2], real and imaginary parts" or "[..][(lmax+1)^2][3]")
    end
    for i = 1, #shape - 2 do lead[i] = shape[i] end
    if width == 3 then lead[#lead + 1] = 3 end
  elseif even[system] then
    lmax = even_lmax(shape[#shape])
    if not lmax then return bad "[..][(lmax+1)(lmax+2)/2], even degrees" end
    for i = 1, #shape - 1 do lead[i] = shape[i] end
  else
    lmax = args.lmax_of(shape[#shape])
    if not lmax then return bad "[..][(lmax+1)^2]" end
    for i = 1, #shape - 1 do lead[i] = shape[i] end
  end
  for _, extent in ipairs(lead) do rows = rows * extent end
  return lead, rows, lmax
end

--- The shape that `system` gives to vectors with these leading extents.
local function shape_in(n, name, lead, lmax, system)
  local shape, tail = {}, packed[system]
  for i, extent in ipairs(lead) do shape[i] = extent end
  if tail then
    if shape[#shape] ~= 3 then
      return check.bad(n, name, "'%s' holds three channels: [..][3][(lmax+1)^2] expected", system)
    end
    shape[#shape], shape[#shape + 1] = tail[1], tail[2]
  elseif system == "3dgs" then
    if shape[#shape] ~= 3 then
      return check.bad(n, name, "'3dgs' holds three channels: [..][3][(lmax+1)^2] expected")
    end
    shape[#shape], shape[#shape + 1] = (lmax + 1) * (lmax + 1), 3
  elseif even[system] then
    shape[#shape + 1] = (lmax + 1) * (lmax + 2) / 2
  else
    shape[#shape + 1] = (lmax + 1) * (lmax + 1)
    if system == "scipy" then shape[#shape + 1] = 2 end
  end
  return shape
end

local convert_options = {
  { "from", "string", optional = true,
    about = "what the coefficients are, where they do not say so themselves; default: 'ylm'" },
  form.threads, args.out, args.progress,
}

describe "sh.convert" {
  shelf = "everyday",
  about = "Translates coefficients between conventions: 'ylm', 'plain' (no Condon-Shortley phase; also 'sphericart'), "
    .. "'n3d' and 'sn3d' (ambisonics, ACN order), 'scipy' (complex; also 'sph_harm_y'), 'unity' (SHAr .. SHC), 'three.js', "
    .. "'filament' (also 'lovr'), 'e3nn', 'e3nn-component', 'e3nn-norm' (polar axis y), '3dgs' (Gaussian splats), 'mrtrix' and "
    .. "'dipy' (even degrees, odd ones are left out); "
    .. "'irradiance' behind it where it is not radiance, and axes like 'x,z,-y' where its x, y, z point elsewhere.",
  arguments = {
    { "c", "array|table",
      "[..][(lmax+1)^2]; scipy [..][(lmax+1)^2][2]; three.js, filament [..][9][3]; unity [..][7][4]; 3dgs [..][(lmax+1)^2][3]; "
        .. "mrtrix, dipy [..][(lmax+1)(lmax+2)/2]" },
    { "to", "string", "the convention that is wanted" },
    { "options?", "table", "see the options" },
  },
  options = convert_options,
  returns = { { "c", "array", "in the new convention's shape; it remembers the convention" } },
  errors = "raises on names that are none, shapes that do not fit, arrays that say to be of another convention than "
    .. "`from`, and irradiance to radiance above lmax 2",
  example = [[
local c = ylm.sh.convert({ 1, 2, 3, 4 }, "plain")
assert(c[2] == -2 and c[3] == 3 and c[4] == -4 and c.convention == "plain")
assert(ylm.sh.convert(c, "ylm")[2] == 2)]],
  source = "docs/conventions.md; Sloan 2008, appendix A10",
}
function convert.convert(c, to, options)
  options = form.options(3, "convert", convert_options, options)
  local a = array.rows(1, "convert", "coefficients", c)
  local _, dtype, own = core.array_info(a)
  local target, target_system = convention_of(2, "convert", to)
  local source, source_system = own, core.sh_convention_name(own):match("^%S+")
  if options.from then
    local number, system = convention_of(3, "convert", options.from)
    if own ~= 0 and own ~= number then
      return check.fail("convert: the array says it is '%s', from says '%s'", core.sh_convention_name(own),
        core.sh_convention_name(number))
    end
    source, source_system = number, system
  end
  local small, finite, where = args.are_small(a, dtype), true, nil
  if not small then finite, where = core.array_finite(a) end
  if not finite then return check.bad(1, "convert", "coefficients: number %d is not finite", where) end
  local lead, rows, lmax = measure(1, "convert", a, source_system)
  local shape = shape_in(1, "convert", lead, lmax, target_system)
  local out, message, code = args.result("convert", options.out, shape, dtype, target, { a })
  if not out then return nil, message, code end
  local ok
  ok, message, code = check.result("convert", core.sh_convert(a, out, { from = source, to = target, lmax = lmax, rows = rows,
    threads = options.threads, progress = progress.of(options.progress) }))
  if not ok then return nil, message, code end
  return args.held("convert", out, small)
end

describe "sh.resize" {
  about = "Cuts coefficients off above lmax, or extends them by zeros.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2]" }, { "lmax", "integer", "the degree that is wanted" } },
  returns = { { "c", "array", "[..][(lmax+1)^2]" } },
  errors = "raises where the number of coefficients is no square",
  example = "assert(#ylm.sh.resize({ 1, 2, 3, 4 }, 2) == 9 and #ylm.sh.resize({ 1, 2, 3, 4 }, 0) == 1)",
}
function convert.resize(c, lmax)
  local given = array.rows(1, "resize", "coefficients", c)
  check.integer(2, "resize", "lmax", lmax, 0, core.limits.sh_lmax)
  local system = core.sh_convention_name((select(3, core.array_info(given)))):match("^%S+")
  if packed[system] or even[system] or system == "scipy" or system == "3dgs" then
    return check.bad(1, "resize", "coefficients are of convention '%s': convert them to 'ylm' first", system)
  end
  local a, own, shape, dtype, rows, convention = args.any_coefficients(1, "resize", given)
  local new = {}
  for i, extent in ipairs(shape) do new[i] = extent end
  new[#new] = (lmax + 1) * (lmax + 1)
  local out, message, code = args.result("resize", nil, new, dtype, convention)
  if not out then return nil, message, code end
  local ok
  ok, message, code = check.result("resize", core.sh_resize(own, lmax, rows, a, out))
  if not ok then return nil, message, code end
  return out
end

return convert
