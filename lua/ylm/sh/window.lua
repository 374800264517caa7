--- ylm.sh.window, ylm.sh.dering, ylm.sh.summary.

local args = require "ylm.sh.args"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"

local window = {}

local pi = math.pi

--- The factor of degree l: each window is 1 at l = 0 and falls with l; the first three end at the width.
local shapes = {
  hann = function(l, w) return l < w and 0.5 * (1 + math.cos(pi * l / w)) or 0 end,
  lanczos = function(l, w)
    if l == 0 then return 1 end
    return l < w and math.sin(pi * l / w) / (pi * l / w) or 0
  end,
  sinc = function(l, w)
    if l == 0 then return 1 end
    return l < w and (math.sin(pi * l / w) / (pi * l / w)) ^ 4 or 0
  end,
  gaussian = function(l, w) return math.exp(-0.5 * (pi * l / w) ^ 2) end,
}
local names = { "hann", "lanczos", "sinc", "gaussian" }

--- A window's name, checked.
local function shape_of(n, name, value)
  if shapes[value] then return shapes[value] end
  local guess = type(value) == "string" and check.guess(value, names)
  return check.bad(n, name, "one of '%s' expected, got %s%s", table.concat(names, "', '"), check.describe(value),
    guess and (" (did you mean '%s'?)"):format(guess) or "")
end

local function factors_of(shape, width, lmax)
  local f = {}
  for l = 0, lmax do f[l + 1] = shape(l, width) end
  return f
end

--- The names of all windows, and the factors of degrees 0 to lmax of one of them.
window.names = names
function window.factors(name, width, lmax) return factors_of(shapes[name], width, lmax) end

describe "sh.window" {
  about = "Damps high degrees against ringing. Degree l is multiplied by\n"
    .. "hann: (1 + cos(pi l/w))/2; lanczos: s = sin(pi l/w)/(pi l/w); sinc: s^4; all 0 from l = w on; "
    .. "gaussian: exp(-(pi l/w)^2/2).",
  arguments = {
    { "c", "array|table", "[..][(lmax+1)^2]" }, { "name", "string", "'hann', 'lanczos', 'sinc' or 'gaussian'" },
    { "width?", "number", "w, in degrees, above 0; default lmax + 1" },
  },
  returns = { { "c", "array", "of the same shape, type and convention" } },
  errors = "raises on a name that is none and on a width that is not above 0",
  example = [[
local c = ylm.sh.window({ 1, 1, 1, 1 }, "hann", 2)
assert(c[1] == 1 and math.abs(c[2] - 0.5) < 1e-15)]],
  source = "Sloan 2008, \"Stupid SH Tricks\"; sinc as in Filament's cmgen",
}
function window.window(c, name, width)
  local a, lmax, shape, dtype, _, convention = args.coefficients(1, "window", c)
  local f = shape_of(2, "window", name)
  if width == nil then width = lmax + 1 end
  if not check.is_number(width) or width <= 0 then
    return check.bad(3, "window", "a width > 0 expected, got %s", check.describe(width))
  end
  local out, message, code = args.result("window", nil, shape, dtype, convention)
  if not out then return nil, message, code end
  assert(core.sh_degree_scale(a, out, lmax, factors_of(f, width, lmax)))
  return args.held("window", out)
end

-- Deringing ---------------------------------------------------------------------------------------

local dering_options = {
  { "window", "choice", of = names, default = "hann" },
  { "minimum", "number", default = 0, about = "what no direction may fall below" },
  { "nodes", "integer", min = 8, max = 1000, optional = true,
    about = "of the directions that are looked at, nodes x 2 nodes; default 6 lmax + 12" },
}

local function energy(a)
  local _, _, norm = core.array_distance(a, a)
  if not (norm * norm < math.huge) then return check.fail "dering: the sum of squares is beyond the range of double" end
  return norm * norm
end

--- The parts of each degree of each row at the directions, [rows][lmax+1][n]: a window only scales these.
local function parts_of(plain, rows, lmax, directions)
  local count = (lmax + 1) ^ 2
  local alone, message, code = core.array_zeros({ rows, lmax + 1, count }, "double")
  if not alone then return nil, message, code end
  local flat, list = core.array_totable(core.array_reshape(plain, { rows, count })), {}
  for r = 1, rows do
    list[r] = {}
    for l = 0, lmax do
      local row = {}
      for k = 1, count do row[k] = k > l * l and k <= (l + 1) ^ 2 and flat[r][k] or 0 end
      list[r][l + 1] = row
    end
  end
  core.array_fill(alone, list)
  return args.reconstruct("reconstruct", alone, directions, {})
end

describe "sh.dering" {
  about = "The widest window that leaves no direction below a minimum, and what it costs.\n"
    .. "All rows (the channels of a colour) get the same window. A minimum a little below 0 costs far less than 0.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2]" }, { "options?", "table", "see the options" } },
  options = dering_options,
  returns = {
    { "c", "array", "of the same shape, type and convention" },
    { "report", "table", "width (nil: no window was needed), reached; minimum and maximum; before: those before; "
      .. "energy_lost and contrast_lost: the fractions of the squared norm and of maximum - minimum" },
  },
  errors = "raises as sh.window",
  example = [[
local c = ylm.sh.cap(6, { 0, 0, 1 }, 0.5)
local smooth, report = ylm.sh.dering(c, { minimum = -0.012 })
assert(report.before.minimum < -0.04 and report.reached and report.contrast_lost < 0.3)]],
  source = "Sloan 2017, \"Deringing Spherical Harmonics\"",
}
function window.dering(c, options)
  local o = form.options(2, "dering", dering_options, options)
  local a, lmax, shape, dtype, rows, convention = args.coefficients(1, "dering", c)
  local nodes = o.nodes or 6 * lmax + 12
  local directions, weights = core.sh_rule(nodes, 2 * nodes, -1, 1)
  if not directions then return check.result("dering", nil, weights, "ENOMEM") end
  local plain = core.array_convert(a, "double")
  core.array_set_convention(plain, 0)
  local out, message, code = args.result("dering", nil, shape, "double")
  if not out then return nil, message, code end
  local f = shapes[o.window]
  local parts
  parts, message, code = parts_of(plain, rows, lmax, directions)
  if not parts then return nil, message, code end
  local function range(width)
    return core.sh_windowed_range(parts, factors_of(width and f or function() return 1 end, width, lmax))
  end
  local before, top = range(nil)
  local report = { before = { minimum = before, maximum = top } }
  local width
  if before < o.minimum then
    -- the minimum is no monotone function of the width: the widest of a scan that serves, then bisection
    local wide, narrow = 8 * (lmax + 1), nil
    while wide > 0.25 and not narrow do
      local next_width = wide * 0.9
      if range(next_width) >= o.minimum then narrow = next_width else wide = next_width end
    end
    narrow = narrow or 0.25
    for _ = 1, 30 do
      local middle = 0.5 * (narrow + wide)
      if range(middle) >= o.minimum then narrow = middle else wide = middle end
    end
    width = narrow
  end
  local lo, hi = range(width)
  if width then assert(core.sh_degree_scale(plain, out, lmax, factors_of(f, width, lmax))) end
  report.width, report.minimum, report.maximum, report.reached = width, lo, hi, lo >= o.minimum
  local kept = width and energy(out) or energy(plain)
  local all = energy(plain)
  report.energy_lost = all > 0 and 1 - kept / all or 0
  report.contrast_lost = top > before and 1 - (hi - lo) / (top - before) or 0
  local result = args.as(width and out or plain, dtype)
  core.array_set_convention(result, convention)
  return result, report
end

-- For experiments ---------------------------------------------------------------------------------

local random_options = {
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1 },
  { "low", "number", default = -1, about = "the least number" },
  { "high", "number", default = 1, about = "what numbers stay below" },
  { "dtype", "choice", of = core.choices "dtype", default = "double" },
}

describe "sh.random" {
  about = "Random coefficients, uniform from low to high: the same for the same seed everywhere.",
  arguments = { { "rows", "integer", "how many vectors" }, { "lmax", "integer", "" }, { "options?", "table", "" } },
  options = random_options,
  returns = { { "c", "array", "[rows][(lmax+1)^2]" } },
  errors = "raises on sizes that are none",
  example = [[
local a, b = ylm.sh.random(2, 3), ylm.sh.random(2, 3)
assert(a:get(2, 16) == b:get(2, 16) and a:get(1, 1) ~= a:get(2, 1))]],
}
function window.random(rows, lmax, options)
  check.integer(1, "random", "rows", rows, 0, 2 ^ 40)
  check.integer(2, "random", "lmax", lmax, 0, core.limits.sh_lmax)
  local o = form.options(3, "random", random_options, options)
  local out, message, code = args.result("random", nil, { rows, (lmax + 1) ^ 2 }, o.dtype)
  if not out then return nil, message, code end
  core.sh_random(out, o.seed, o.low, o.high)
  return args.held("random", out)
end

describe "sh.relative_error" {
  about = "How far rows are from those of a reference: the L2 norm of the difference over that of the reference.",
  arguments = { { "a", "array|table", "[n][..]" }, { "b", "array|table", "[n][..], the reference" } },
  returns = { { "e", "array", "[n]" }, { "norms", "array", "[n]: of the reference's rows" } },
  errors = "raises where the shapes differ",
  example = "assert(ylm.sh.relative_error({ { 3, 5 } }, { { 3, 4 } })[1] == 0.2)",
}
function window.relative_error(a, b)
  local array = require "ylm.array"
  local x = array.rows(1, "relative_error", "numbers", a, nil, "double")
  local y = array.rows(2, "relative_error", "numbers", b, nil, "double")
  local sx, sy = core.array_info(x), core.array_info(y)
  if #sx < 2 or table.concat(sx, "x") ~= table.concat(sy, "x") then
    return check.bad(2, "relative_error", "rows like those of the first argument expected: %s, got %s",
      check.describe(x),
      check.describe(y))
  end
  local out, message, code = args.result("relative_error", nil, { sy[1] }, "double")
  if not out then return nil, message, code end
  local norms
  norms, message, code = args.result("relative_error", nil, { sy[1] }, "double")
  if not norms then return nil, message, code end
  assert(core.sh_relative_error(x, y, out, norms))
  args.held("relative_error", norms)
  return out, norms
end

-- In words ------------------------------------------------------------------------------------------

describe "sh.summary" {
  about = "Coefficients in words: convention, lmax, the first of them, and the energy of each degree.",
  arguments = { { "c", "array|table", "[..][(lmax+1)^2], ylm's own system" } },
  returns = {
    { "text", "string", "a few lines, for the REPL" },
    { "energy", "table", "of each degree from 0 on: the sum of squares over m and rows" },
  },
  errors = "raises where c is no coefficients",
  example = [[
local text, energy = ylm.sh.summary({ 1, 0, 2, 0 })
assert(text:find("lmax 1") and energy[2] == 4)]],
}
function window.summary(c)
  local a, lmax, shape, dtype, rows, convention = args.coefficients(1, "summary", c)
  local flat = core.array_totable(core.array_reshape(a, { rows, (lmax + 1) ^ 2 }))
  local energies, total = {}, 0
  for l = 0, lmax do
    local sum = 0
    for _, row in ipairs(flat) do
      for k = l * l + 1, (l + 1) ^ 2 do sum = sum + row[k] ^ 2 end
    end
    energies[l + 1] = sum
    total = total + sum
    if not (total < math.huge) then return check.fail "summary: the sum of squares is beyond the range of double" end
  end
  local lines = { ("%s, lmax %d, [%s] %s"):format(core.sh_convention_name(convention), lmax,
    table.concat(shape, "]["):gsub("%.0", ""), dtype) }
  for i = 1, math.min(rows, 3) do
    local first = {}
    for k = 1, math.min(9, #flat[i]) do first[k] = ("%.4g"):format(flat[i][k] + 0) end -- no -0
    lines[#lines + 1] = "  " .. table.concat(first, " ") .. (#flat[i] > 9 and " .." or "")
  end
  if rows > 3 then lines[#lines + 1] = ("  .. %d rows"):format(rows) end
  for l = 0, lmax do
    if l == 10 then
      lines[#lines + 1] = "  .."
      break
    end
    local part = total > 0 and energies[l + 1] / total or 0
    lines[#lines + 1] = ("  l %d  %5.1f %%  %s"):format(l, 100 * part, ("#"):rep(math.floor(40 * part + 0.5)))
  end
  return table.concat(lines, "\n"), energies
end

return window
