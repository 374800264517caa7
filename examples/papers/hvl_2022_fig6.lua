-- Mezieres & Paulin 2022 (harmonics virtual lights), Fig. 6: arithmetic operations for the zonal coefficients of a cap of half-
-- angle a, by number of bands: Eq. 14's recurrence, Sloan's polynomials (2008), ylm's recurrence, and the heat kernel of profile
-- "gauss".
--
--     lua examples/papers/hvl_2022_fig6.lua [--out out] [--quick]
--
-- Writes hvl_2022_fig6.png. Each is source that a program writes with its loop unrolled, as the figure counts: constants of a
-- band are one multiplication. The source runs once with numbers that count, and then with plain ones for its time; results are
-- compared with ylm.sh.cap. "digits" are those that are right at a = 0.01, as the worst of its bands has them.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { out = "out", scene = "", quick = false }
rooms.no_scene(option.scene, "operations are counted here, and no scene is lit: hvl_2022_table1 takes one")
local quick = option.quick
local clock = require "ylm.c.core".seconds
local compile = loadstring or load -- luacheck: ignore

local function number(x) return ("%.17g"):format(x) end

--- Coefficients of the derivative of P_l by powers of x: t[k+1] belongs to x^k.
local function legendre(l)
  local before, p = { 1 }, { 0, 1 }
  if l == 0 then return before end
  for k = 1, l - 1 do
    local q = {}
    for i = 1, k + 2 do
      q[i] = ((2 * k + 1) * (p[i - 1] or 0) - k * (before[i] or 0)) / (k + 1)
    end
    before, p = p, q
  end
  return p
end

-- Sources -------------------------------------------------------------------------------------

local K0 = "local z0 = 1.7724538509055159 * (1 - c)"

local make = {}

--- Eq. 14: P by its recurrence, differences of two.
make["Eq. 14"] = function(bands)
  local s = { K0, "local p0, p1 = 1, c" }
  for l = 1, bands - 1 do
    s[#s + 1] = l == 1 and "local p2 = 1.5 * c * c - 0.5" or ("local p%d = %s * c * p%d - %s * p%d"):format(l + 1,
      number((2 * l + 1) / (l + 1)), l, number(l / (l + 1)), l - 1)
    s[#s + 1] = ("local z%d = %s * (p%d - p%d)"):format(l, number(math.sqrt(math.pi / (2 * l + 1))), l - 1, l + 1)
  end
  return s
end

--- Sloan 2008: each band's polynomial by itself: a constant, (1 - c)(1 + c), and one in c^2 by Horner, times c of even bands.
make.Sloan = function(bands)
  local s = { K0 }
  for l = 1, bands - 1 do
    local p = legendre(l) -- K_l = sqrt(pi / (2l+1)) (2l+1)/(l(l+1)) (1 - c^2) P_l'
    local derivative = {}
    for k = 1, #p - 1 do derivative[k] = k * p[k + 1] end
    local factor = math.sqrt(math.pi / (2 * l + 1)) * (2 * l + 1) / (l * (l + 1))
    local lead = derivative[#derivative]
    if l > 2 then -- the polynomial divided by its leading number, which the constant takes
      local text = "q"
      local k = #derivative - 2
      while k >= 1 do
        text = ("(%s + %s)"):format(text, number(derivative[k] / lead))
        if k > 2 then text = text .. " * q" end
        k = k - 2
      end
      text = " * " .. text
      s[#s + 1] = ("local z%d"):format(l)
      s[#s + 1] = ("do local q = c * c z%d = %s%s * (1 - c) * (1 + c)%s end"):format(l, number(factor * lead),
        l % 2 == 0 and " * c" or "", text)
    else
      s[#s + 1] = ("local z%d = %s%s * (1 - c) * (1 + c)"):format(l, number(factor * lead), l % 2 == 0 and " * c" or "")
    end
  end
  return s
end

--- ylm: sin^2 a taken as it is known, (r/d)^2, times P_l', whose recurrence needs P_l: no differences of like numbers.
make.ylm = function(bands)
  local s = { "local z0 = 1.7724538509055159 * s2 / (1 + c)", "local p0, p1 = 1, c", "local d1 = 1" }
  for l = 1, bands - 1 do
    if l > 1 then
      s[#s + 1] = l == 2 and "local d2 = 3 * c" or ("local d%d = d%d + %d * p%d"):format(l, l - 2, 2 * l - 1, l - 1)
    end
    local factor = number(math.sqrt(math.pi / (2 * l + 1)) * (2 * l + 1) / (l * (l + 1)))
    s[#s + 1] = l == 1 and ("local z1 = %s * s2"):format(factor) or ("local z%d = %s * s2 * d%d"):format(l, factor, l)
    if l > 1 and l < bands - 2 or l == 1 and bands > 3 then
      s[#s + 1] = l == 1 and "local p2 = 1.5 * c * c - 0.5" or ("local p%d = %s * c * p%d - %s * p%d"):format(l + 1,
        number((2 * l + 1) / (l + 1)), l, number(l / (l + 1)), l - 1)
    end
  end
  return s
end

--- The heat kernel on the sphere: A_l = A_(l-1) A^l of one exponential; t = (r/2d)^2, factors 1/d^2 aside.
make["heat kernel"] = function(bands)
  local s = { "local z0 = 1.7724538509055159 * (1 - c)" }
  if bands > 1 then s[2] = "local a1 = exp(-t)" end -- exp(-l(l+1) t/2): A_1 = e^-t, A_l = A_(l-1) e^(-l t)
  for l = 1, bands - 1 do
    if l > 1 then s[#s + 1] = ("local a%d = a%d * a1"):format(l, l - 1) end
    s[#s + 1] = ("local z%d = z%d * a%d"):format(l, l - 1, l)
  end
  return s
end

--- The source of a function of c = cos a, s2 = sin^2 a and t that returns the coefficients, joined by `how`.
local function source(name, bands, how)
  local s = make[name](bands)
  local names = {}
  for l = 0, bands - 1 do names[l + 1] = "z" .. l end
  s[#s + 1] = "return " .. table.concat(names, how)
  return "local exp = ...\nreturn function(c, s2, t)\n" .. table.concat(s, "\n") .. "\nend"
end

-- Counting --------------------------------------------------------------------------------------

local operations
local counting = {}
local function plain(x) return type(x) == "table" and x.value or x end
local function counted(f)
  return function(a, b)
    operations = operations + 1
    return setmetatable({ value = f(plain(a), plain(b)) }, counting)
  end
end
counting.__add, counting.__sub = counted(function(a, b) return a + b end), counted(function(a, b) return a - b end)
counting.__mul, counting.__div = counted(function(a, b) return a * b end), counted(function(a, b) return a / b end)
counting.__unm = function(a) return setmetatable({ value = -plain(a) }, counting) end -- a sign costs nothing

--- Operations of a source, its result at half-angle a, and nanoseconds of a run.
local function measure(name, bands, a)
  local text = source(name, bands, ", ")
  operations = 0
  local function counter(x) return setmetatable({ value = x }, counting) end
  local c, s2, t = math.cos(a), math.sin(a) ^ 2, math.tan(a) ^ 2 / 4
  local f = assert(compile(text))(function(x)
    operations = operations + 1
    return counter(math.exp(plain(x)))
  end)
  local z = { f(counter(c), counter(s2), counter(t)) }
  for l = 1, #z do z[l] = plain(z[l]) end
  local n, fast = operations, assert(compile(source(name, bands, " + ")))(math.exp)
  local times = quick and 100 or 400000
  local least = common.best(clock, quick and 1 or 5, function()
    local sum, x, y = 0, c, t
    for _ = 1, times do
      sum, x, y = sum + fast(x, s2, y), x - 1e-9, y + 1e-9
    end
    assert(sum == sum)
  end)
  return n, z, 1e6 * least / times
end

-- Tables ------------------------------------------------------------------------------------------

local names = { "Sloan", "Eq. 14", "ylm", "heat kernel" }
local columns = { { "bands", "%5d" } }
for _, name in ipairs(names) do columns[#columns + 1] = { name, "%5d" } end
for _, name in ipairs(names) do columns[#columns + 1] = { name .. ", ns", "%6.1f" } end
local row = common.table(columns)
local counts, less = {}, nil
for i = 1, #names do counts[i] = { x = {}, y = {}, label = names[i] } end
for bands = 1, quick and 6 or 12 do
  local cells, wanted = { bands }, select(2, ylm.sh.cap(bands - 1, { 0, 0, 1 }, 0.3))
  for i, name in ipairs(names) do
    local n, z, ns = measure(name, bands, 0.3)
    cells[i + 1], cells[#names + i + 1] = n, ns
    counts[i].x[bands], counts[i].y[bands] = bands, n
    for l = 0, name == "heat kernel" and -1 or bands - 1 do
      local truth = wanted:get(l + 1)
      assert(math.abs(z[l + 1] - truth) < 1e-12, name)
    end
  end
  less = less or cells[3] < cells[2] and bands or nil
  row(cells)
end
print(("Eq. 14 has fewer operations than the polynomials from %d bands on (the paper: beyond 5)"):format(less or 0))
local _, zonal = ylm.sh.cap(8, { 0, 0, 1 }, 0.01)
for i = 1, 3 do
  local _, z = measure(names[i], 9, 0.01)
  local worst = 0
  for l = 0, 8 do worst = math.max(worst, math.abs(z[l + 1] / zonal:get(l + 1) - 1)) end
  print(("%-8s %4.1f digits of 16 at a = 0.01, 9 bands"):format(names[i], math.min(16, -math.log(worst + 1e-17) / math.log(10))))
end
print "Why: Eq. 14 takes differences of numbers that are near 1, so that floats have nothing left of lights at 100 radii; ylm's"
print "recurrence costs two operations a band more and keeps all. The heat kernel is one exponential and two products a band. An"
print "exponential of the C library costs as much as 20 products, so that the kernel is the cheapest from 12 bands on where Lua"
print "is compiled; ylm's kernels have a polynomial of degree 6 for 4 to 16 points at once. ns: of this source with a sum of its"
print "coefficients, run by this Lua: LuaJIT compiles it, others interpret it."
common.save(ylm.plot { title = "Operations for zonal coefficients of a cap", series = counts, x_label = "bands",
  y_label = "operations",
  caption = "Mezieres & Paulin 2022, Fig. 6. Loops unrolled, constants folded; an exponential counts as one." },
  option.out .. "hvl_2022_fig6.png")
