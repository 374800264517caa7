--- ylm.sh.project, .cap, .sky, .zonal, .convolve, .irradiance, .zonal_irradiance.

local args = require "ylm.sh_args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.reference".describe
local form = require "ylm.form"
local progress = require "ylm.progress"

local project = {}

local pi = math.pi

-- Projection -----------------------------------------------------------------------------

local project_options = {
  { "method", "choice", of = { "quadrature", "montecarlo" }, default = "quadrature",
    about = "quadrature: Gauss-Legendre x azimuth; montecarlo: jittered samples (Green 2003)" },
  { "samples", "integer", min = 1, max = 1e8, optional = true,
    about = "about how many evaluations; default: 2 (4 lmax + 16)^2, or 10000 for montecarlo" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of montecarlo" },
  { "mapping", "choice", of = { "latlong", "angular", "cube" }, default = "latlong", about = "of an image" },
  { "up", "choice", of = { "z", "y" }, default = "z", about = "of an image: where its pole is" },
  { "layer", "string", optional = true, about = "of an image; default: the first" },
  { "dtype", "choice", of = { "float", "double" }, default = "double", about = "of the result" },
  args.threads, args.out, args.progress,
}

local cancelled = {}

--- Reports progress of work done in Lua; where it wants no more, raises `cancelled`, which sh.project catches.
local function report(o, done, total)
  if o.progress and o.progress(done, total, "evaluate") == false then error(cancelled, 0) end
end

--- Values of a Lua function at directions [n][3]: array [n][channels]. `before` evaluations were done of `total`.
local function evaluate(f, directions, o, before, total)
  local d = core.array_totable(directions)
  local values, channels = {}, nil
  for i, v in ipairs(d) do
    if i % 1000 == 0 then report(o, before + i, total) end
    local r, g, b = f(v[1], v[2], v[3])
    local width = b ~= nil and 3 or 1
    channels = channels or width
    if not check.is_number(r) or width ~= channels or (width == 3 and not (check.is_number(g)
      and check.is_number(b))) then
      return check.bad(2, "project", "the function must return a finite number, or r, g, b everywhere; "
        .. "at (%g, %g, %g) it returned %s", v[1], v[2], v[3],
        width == 3 and table.concat({ tostring(r), tostring(g), tostring(b) }, ", ") or check.describe(r))
    end
    if channels == 1 then values[i] = { r } else values[i] = { r, g, b } end
  end
  return (array.array(values)), channels
end

--- Coefficients [channels][count] of weighted samples, and their terms' squares if wanted; nil, message, code.
local function of_samples(lmax, directions, weights, values, threads, progress_, squares)
  local shape = core.array_info(values)
  local channels = #shape == 1 and 1 or shape[2]
  local out, message, code = core.array_zeros({ channels, (lmax + 1) ^ 2 }, "double")
  if not out then return nil, message, code end
  local square
  if squares then
    square, message, code = core.array_zeros({ channels, (lmax + 1) ^ 2 }, "double")
    if not square then return nil, message, code end
  end
  local ok
  ok, message, code = core.sh_project(lmax, directions, weights, values, out, threads, progress_, square)
  if not ok then return check.result("project", nil, message, code) end
  return out, square
end

--- The difference's norm, channel by channel the largest.
local function distance(a, b)
  local worst = 0
  for i = 1, a.shape[1] do
    local _, d = core.array_distance(a[i], b[i])
    worst = math.max(worst, d)
  end
  return worst
end

--- By the product rule; its error is estimated by a rule of about half as many points.
local function by_quadrature(lmax, f, o)
  local nodes = o.samples and math.max(1, math.floor(math.sqrt(o.samples / 2))) or 4 * lmax + 16
  local fewer = math.max(1, math.floor(nodes * 0.7))
  local total = 2 * nodes ^ 2 + 2 * fewer ^ 2
  local function rule(n, before)
    local d, w = core.sh_rule(n, 2 * n, -1, 1)
    if not d then return check.result("project", nil, w, "ENOMEM") end
    return of_samples(lmax, d, w, evaluate(f, d, o, before, total), o.threads)
  end
  local c, message, code = rule(nodes, 0)
  if not c then return nil, message, code end
  local rough
  rough, message, code = rule(fewer, 2 * nodes ^ 2)
  report(o, total, total)
  if not rough then return nil, message, code end
  return c, { method = "quadrature", samples = 2 * nodes * nodes, error = distance(c, rough) }
end

local REPLICATES = 8

--- By independent sets of jittered samples, whose spread is the standard error.
local function by_montecarlo(lmax, f, o)
  local side = math.max(1, math.floor(math.sqrt((o.samples or 10000) / REPLICATES) + 0.5))
  local sum, squares
  for k = 1, REPLICATES do
    local d, message, code = core.sh_samples(side, o.seed, k)
    if not d then return nil, message, code end
    local c
    c, message, code = of_samples(lmax, d, nil, evaluate(f, d, o, (k - 1) * side ^ 2, REPLICATES * side ^ 2), o.threads)
    if not c then return nil, message, code end
    local t = core.array_totable(c)
    sum, squares = sum or {}, squares or {}
    for ch, row in ipairs(t) do
      sum[ch], squares[ch] = sum[ch] or {}, squares[ch] or {}
      for i, x in ipairs(row) do
        sum[ch][i] = (sum[ch][i] or 0) + x
        squares[ch][i] = (squares[ch][i] or 0) + x * x
      end
    end
  end
  report(o, REPLICATES * side ^ 2, REPLICATES * side ^ 2)
  local mean, standard, worst = {}, {}, 0
  for ch, row in ipairs(sum) do
    mean[ch], standard[ch] = {}, {}
    local norm = 0
    for i, x in ipairs(row) do
      local m = x / REPLICATES
      local variance = math.max(0, squares[ch][i] / REPLICATES - m * m) / (REPLICATES - 1)
      mean[ch][i], standard[ch][i] = m, math.sqrt(variance)
      norm = norm + variance
    end
    worst = math.max(worst, math.sqrt(norm))
  end
  return (array.array(mean)), { method = "montecarlo", samples = REPLICATES * side * side, error = worst,
    standard_error = #standard == 1 and (array.array(standard[1])) or (array.array(standard)) }
end

--- Of a Lua function; what it raises passes.
local function of_function(lmax, f, o)
  local by = o.method == "montecarlo" and by_montecarlo or by_quadrature
  if not o.progress then return by(lmax, f, o) end
  local ok, c, about, code = pcall(by, lmax, f, o)
  if ok then return c, about, code end
  if c == cancelled then return nil, "cancelled", "ECANCELLED" end
  error(c, 0)
end

local shapes = {
  latlong = { function(w, h) return w == 2 * h end, "twice as wide as high" },
  angular = { function(w, h) return w == h end, "as wide as high" },
  cube = { function(w, h) return h == 6 * w end, "six times as high as wide, its faces one above the other" },
}

--- Of an image of the whole sphere: every pixel with its solid angle. The error is that of taking a pixel's direction
-- for its whole area, which falls with the square of its size: a third of what blocks of 2 x 2 pixels differ by.
local function of_image(lmax, image, o)
  local size = image.size
  if not shapes[o.mapping][1](size[1], size[2]) then
    return check.bad(2, "project", "an image for mapping '%s' is %s, got %dx%d", o.mapping, shapes[o.mapping][2], size[1],
      size[2])
  end
  local directions, angles, code = image:directions { mapping = o.mapping, up = o.up }
  if not directions then return nil, angles, code end
  local layer = image:layer(o.layer)
  local shape = core.array_info(layer)
  local n, channels = shape[1] * shape[2], shape[3] or 1
  local values = core.array_reshape(core.array_convert(layer, "double"), { n, channels })
  local finite, where = core.array_finite(values)
  if not finite then
    local pixel = math.floor((where - 1) / channels)
    return check.bad(2, "project", "the image is not finite at pixel (%d, %d)", pixel % shape[2] + 1,
      math.floor(pixel / shape[2]) + 1)
  end
  local c, message
  c, message, code = of_samples(lmax, directions, angles, values, o.threads, o.progress)
  if not c then return nil, message, code end
  local d2, w2, v2 = core.sh_halve(shape[2], shape[1], o.mapping == "cube" and 6 or 1, directions, angles, values)
  if not d2 then return nil, w2, v2 end
  local rough
  rough, message, code = of_samples(lmax, d2, w2, v2, o.threads)
  if not rough then return nil, message, code end
  return c, { method = "pixels", samples = n, error = distance(c, rough) / 3 }
end

--- Of { directions =, values =, weights = }.
local function of_table(lmax, t, o)
  for key in pairs(t) do
    if key ~= "directions" and key ~= "values" and key ~= "weights" then
      return check.bad(2, "project", "samples are { directions =, values =, weights = }, got a field %s",
        check.describe(key))
    end
  end
  local d = array.points(2, "project", t.directions, "double")
  local n = core.array_info(d)[1]
  local v = array.rows(2, "project", "values", t.values, nil, "double")
  local shape = core.array_info(v)
  if n == 0 or #shape > 2 or shape[1] ~= n then
    return check.bad(2, "project",
      "values: one number, or one row of channels, for each of %d directions expected, got %s",
      n, check.describe(v))
  end
  if #shape == 1 then v = core.array_reshape(v, { n, 1 }) end
  local w
  if t.weights ~= nil then
    w = array.rows(2, "project", "weights", t.weights, n, "double")
    if #core.array_info(w) ~= 1 then
      return check.bad(2, "project", "weights: one number for each of %d directions expected", n)
    end
  end
  for _, a in ipairs { v, w } do
    local finite, where = core.array_finite(a)
    if not finite then return check.bad(2, "project", "samples: number %d of values or weights is not finite",
      where) end
  end
  local c, square, code = of_samples(lmax, d, w, v, o.threads, o.progress, true)
  if not c then return nil, square, code end
  if n < 2 then return c, { method = "samples", samples = n } end
  local sums, squares, standard, worst = core.array_totable(c), core.array_totable(square), {}, 0
  for ch, row in ipairs(sums) do
    local norm = 0
    standard[ch] = {}
    for i, sum in ipairs(row) do
      local variance = math.max(0, squares[ch][i] - sum * sum / n) * n / (n - 1)
      standard[ch][i] = math.sqrt(variance)
      norm = norm + variance
    end
    worst = math.max(worst, math.sqrt(norm))
  end
  return c, { method = "samples", samples = n, error = worst,
    standard_error = #standard == 1 and (array.array(standard[1])) or (array.array(standard)) }
end

describe "sh.project" {
  about = "The coefficients of a function on the sphere: of a Lua function f(x, y, z) that returns a number or r, g, b; "
    .. "of an image of the whole sphere; of samples { directions = [n][3], values = [n] or [n][channels], "
    .. "weights = [n] in sr, default 4 pi / n }.",
  arguments = {
    { "lmax", "integer", "highest degree, from 0 to 1000" },
    { "f", "function|image|table", "what is projected" },
    { "options?", "table", "see the options" },
  },
  options = project_options,
  returns = {
    { "c", "array", "[(lmax+1)^2], or [channels][(lmax+1)^2]" },
    { "report", "table", "method, samples; error: an estimate of the norm of what is wrong, of the worst channel: by a "
      .. "rule of half as many points (quadrature), the spread of 8 sets (montecarlo), blocks of 2 x 2 pixels (images), "
      .. "or as if samples were independent at random, an upper bound for others (samples); "
      .. "standard_error: of each coefficient (montecarlo, samples)" },
  },
  errors = "raises where the function returns something else, shapes do not fit (a latitude-longitude image is twice as "
    .. "wide as high), or a number is not finite; nil, 'cancelled', 'ECANCELLED' where progress returns false",
  example = [[
local c, report = ylm.sh.project(2, function(x, y, z) return z * z end)
assert(math.abs(ylm.sh.reconstruct(c, { 0, 0.6, 0.8 }) - 0.64) < 1e-13 and report.error < 1e-13)]],
  source = "Green 2003, \"SH Projection\"",
}
function project.project(lmax, f, options)
  check.integer(1, "project", "lmax", lmax, 0, core.sh_lmax)
  local o = form.options(3, "project", project_options, options)
  o.progress = progress.of(o.progress)
  local c, about, code
  if type(f) == "function" then c, about, code = of_function(lmax, f, o)
  elseif core.type(f) == "ylm.image" then c, about, code = of_image(lmax, f, o)
  elseif type(f) == "table" and not form.kind(f) then c, about, code = of_table(lmax, f, o)
  else
    return check.bad(2, "project", "a function, an image or { directions =, values = } expected, got %s",
      check.describe(f))
  end
  if not c then return nil, about, code end
  if core.array_info(c)[1] == 1 then c = core.array_reshape(c, { (lmax + 1) ^ 2 }) end
  c = args.as(c, o.dtype)
  if not o.out then return c, about end
  local shape = core.array_info(c)
  local out = args.result("project", o.out, shape, o.dtype)
  assert(core.sh_resize(lmax, lmax, #shape == 1 and 1 or shape[1], c, out))
  return out, about
end

-- Zonal functions ----------------------------------------------------------------------------

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
function project.zonal(z, direction)
  local list = zonal_of(1, "zonal", z)
  local d = direction_of(2, "zonal", "direction", direction)
  local lmax = #list - 1
  check.integer(1, "zonal", "lmax", lmax, 0, core.sh_lmax)
  local Y = require("ylm.sh").eval(lmax, d)
  local factors = {}
  for l = 0, lmax do factors[l + 1] = math.sqrt(4 * pi / (2 * l + 1)) * list[l + 1] end
  assert(core.sh_degree_scale(Y, Y, lmax, factors))
  return Y
end

describe "sh.convolve" {
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
function project.convolve(c, zonal)
  local a, lmax, shape, dtype, _, convention = args.coefficients(1, "convolve", c)
  local list = zonal_of(2, "convolve", zonal)
  local factors = {}
  for l = 0, lmax do factors[l + 1] = math.sqrt(4 * pi / (2 * l + 1)) * (list[l + 1] or 0) end
  local out, message, code = args.result("convolve", nil, shape, dtype, convention)
  if not out then return nil, message, code end
  assert(core.sh_degree_scale(a, out, lmax, factors))
  return out
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
function project.cap(lmax, direction, angle)
  check.integer(1, "cap", "lmax", lmax, 0, core.sh_lmax - 1)
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
  return project.zonal(z, d), (array.array(z))
end

-- Irradiance -----------------------------------------------------------------------------------

local irradiance_options = {
  { "method", "choice", of = { "full", "quadratic" }, default = "full",
    about = "quadratic: the polynomial of Ramamoorthi & Hanrahan 2001, degrees to 2" },
  args.threads,
}

describe "sh.irradiance" {
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
function project.irradiance(c, normals, options)
  local o = form.options(3, "irradiance", irradiance_options, options)
  local a, lmax, shape, dtype, _, convention = args.coefficients(1, "irradiance", c)
  if convention ~= 0 then
    return check.bad(1, "irradiance", "coefficients are of convention '%s': convert them to 'ylm' first",
      core.sh_convention_name(convention))
  end
  if o.method == "quadratic" and lmax > 2 then
    a = require "ylm.sh".resize(a, 2)
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
function project.zonal_irradiance(zonal, cosine)
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

-- Skies -------------------------------------------------------------------------------------------

local sky_options = {
  { "kind", "choice", of = { "overcast", "clear", "partly cloudy" }, default = "overcast", about = "CIE standard sky" },
  { "zenith", "vector", default = { 0, 0, 1 }, about = "up" },
  { "sun", "vector", optional = true,
    about = "towards the sun; 'clear' and 'partly cloudy' need it, above the horizon" },
  { "luminance", "number", min = 0, default = 1, about = "at the zenith" },
  { "nodes", "integer", min = 4, max = 2000, default = 96,
    about = "of the quadrature over the upper half; overcast skies need none" },
}

local function unit(v)
  local n = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
  return { v[1] / n, v[2] / n, v[3] / n }
end

--- The luminance of a sky as a function of direction, relative to the zenith's.
local function sky_function(o, zenith, sun)
  local function dot(a, x, y, z) return a[1] * x + a[2] * y + a[3] * z end
  if o.kind == "overcast" then
    return function(x, y, z)
      local c = dot(zenith, x, y, z)
      return c > 0 and o.luminance * (1 + 2 * c) / 3 or 0
    end
  end
  local clear = o.kind == "clear"
  local a, b, k, scattering, e = 0.526, 5, -1.5, 0, -0.8
  if clear then a, b, k, scattering, e = 0.91, 10, -3, 0.45, -0.32 end
  local S = math.acos(math.max(-1, math.min(1, dot(zenith, sun[1], sun[2], sun[3]))))
  local function glow(g) return a + b * math.exp(k * g) + scattering * math.cos(g) ^ 2 end
  local scale = o.luminance / (glow(S) * (1 - math.exp(e)))
  return function(x, y, z)
    local c = dot(zenith, x, y, z)
    if c <= 0 then return 0 end
    local g = math.acos(math.max(-1, math.min(1, dot(sun, x, y, z))))
    return scale * glow(g) * (1 - math.exp(e / c))
  end
end

--- Coefficients [1][count] of what shines from above the horizon alone, by a rule for that half.
local function above(lmax, f, zenith, nodes)
  local d, w = core.sh_rule(nodes, 2 * nodes, 0, 1)
  if not d then return check.result("sky", nil, w, "ENOMEM") end
  -- the half above z, turned so that z is the zenith (a reflection serves as well)
  local h = { zenith[1], zenith[2], zenith[3] - 1 }
  local hh = h[1] ^ 2 + h[2] ^ 2 + h[3] ^ 2
  local directions, values = core.array_totable(d), {}
  for i, v in ipairs(directions) do
    if hh > 0 then
      local t = 2 * (v[1] * h[1] + v[2] * h[2] + v[3] * h[3]) / hh
      v[1], v[2], v[3] = v[1] - t * h[1], v[2] - t * h[2], v[3] - t * h[3]
    end
    values[i] = { f(v[1], v[2], v[3]) }
  end
  return of_samples(lmax, (array.array(directions)), w, (array.array(values)))
end

--- Zonal coefficients of (1 + 2 cos theta)/3 above the horizon: integrals of P_l and of t P_l over 0 .. 1.
local function overcast(lmax, luminance)
  local p, z = legendre(lmax, 0), {}
  for l = 0, lmax do
    local mean = l == 0 and 1 or (p[l - 1] - p[l + 1]) / (2 * l + 1)
    z[l + 1] = luminance * math.sqrt(pi * (2 * l + 1)) / 3 * (mean + core.sh_cosine_factor(l) / pi)
  end
  return z
end

describe "sh.sky" {
  about = "The coefficients of a CIE sky over the horizon: overcast, clear or partly cloudy, with the position of the sun.",
  arguments = { { "lmax", "integer", "highest degree" }, { "options?", "table", "see the options" } },
  options = sky_options,
  returns = {
    { "c", "array", "[(lmax+1)^2], in the unit of the zenith's luminance" },
    { "sky", "function", "the luminance itself, f(x, y, z) of a unit direction" },
    { "report", "table", "method: 'closed form' (overcast) or 'quadrature', whose error is estimated by a rule of half as "
      .. "many points: samples, error (of the norm)" },
  },
  errors = "raises where a sky needs a sun above the horizon and has none",
  example = [[
local c, sky = ylm.sh.sky(4, { kind = "clear", zenith = { 0, 1, 0 }, sun = { 1, 1, 0 }, luminance = 8 })
assert(math.abs(sky(0, 1, 0) - 8) < 1e-12 and sky(0, -1, 0) == 0 and #c == 25)]],
  source = "Green 2003, \"Creating Light Sources\" (skies of the CIE; cos theta in 'partly cloudy', misprinted there)",
}
function project.sky(lmax, options)
  check.integer(1, "sky", "lmax", lmax, 0, core.sh_lmax)
  local o = form.options(2, "sky", sky_options, options)
  local zenith, sun = unit(o.zenith), o.sun and unit(o.sun)
  if o.kind ~= "overcast" then
    if not sun then return check.bad(2, "sky", "a %s sky needs sun = {x, y, z}", o.kind) end
    if sun[1] * zenith[1] + sun[2] * zenith[2] + sun[3] * zenith[3] <= 0 then
      return check.bad(2, "sky", "the sun must be above the horizon")
    end
  end
  local f = sky_function(o, zenith, sun)
  if o.kind == "overcast" then return project.zonal(overcast(lmax, o.luminance), zenith), f, { method = "closed form" } end
  local c, message, code = above(lmax, f, zenith, o.nodes)
  if not c then return nil, message, code end
  local rough
  rough, message, code = above(lmax, f, zenith, math.floor(0.7 * o.nodes))
  if not rough then return nil, message, code end
  return core.array_reshape(c, { (lmax + 1) ^ 2 }), f,
    { method = "quadrature", samples = 2 * o.nodes ^ 2, error = distance(c, rough) }
end

return project
