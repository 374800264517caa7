--- ylm.sh.project: coefficients of functions, images and samples.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local progress = require "ylm.progress"

local project = {}

local project_options = {
  { "method", "choice", of = { "quadrature", "montecarlo" }, default = "quadrature",
    about = "quadrature: Gauss-Legendre x azimuth; montecarlo: jittered samples (Green 2003)" },
  { "samples", "integer", min = 1, max = 1e8, optional = true,
    about = "about how many evaluations; default: 2 (4 lmax + 16)^2, or 10000 for montecarlo. A quadrature takes 2 n^2 "
      .. "with an even n of 4 or more, so that no node lies on a coordinate plane, where a function may have a horizon" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of montecarlo" },
  { "mapping", "choice", of = core.choices "mapping", default = "latlong", about = "of an image" },
  { "up", "choice", of = core.choices "up", default = "z", about = "of an image: where its pole is" },
  { "layer", "string", optional = true, about = "of an image; default: the first" },
  { "dtype", "choice", of = core.choices "dtype", default = "double", about = "of the result" },
  form.threads, args.out, args.progress,
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
  ok, message, code = core.sh_project(lmax, { directions = directions, weights = weights, values = values, out = out,
    squares = square, threads = threads, progress = progress_ })
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

--- The even number from n on, at least `least`: with an odd one, nodes lie on the equator and azimuths on the plane x = 0,
-- where functions with a horizon jump.
local function even(n, least)
  n = math.max(least, math.floor(n))
  return n + n % 2
end

--- By the product rule; its error is estimated by a rule of about half as many points.
local function by_quadrature(lmax, f, o)
  local nodes = o.samples and even(math.sqrt(o.samples / 2), 4) or 4 * lmax + 16
  local fewer = even(nodes * 0.7, 2)
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
  local ok, c, about, code = memory.pcall(by, lmax, f, o)
  if ok then return c, about, code end
  if c == cancelled then return nil, "cancelled", "ECANCELLED" end
  error(c, 0)
end

local shapes = {
  latlong = "twice as wide as high",
  angular = "as wide as high",
  cube = "six times as high as wide, its faces one above the other",
}

--- The fault of the size of an image for a mapping, or nil.
local function misshapen(mapping, w, h)
  if core.mapping_fits(mapping, w, h) then return nil end
  return ("an image for mapping '%s' is %s, got %dx%d"):format(mapping, shapes[mapping], w, h)
end

--- Of an image of the whole sphere: every pixel with its solid angle. The error is that of taking a pixel's direction
-- for its whole area, which falls with the square of its size: a third of what blocks of 2 x 2 pixels differ by.
local function of_image(lmax, image, o)
  local size = image.size
  local wrong = misshapen(o.mapping, size[1], size[2])
  if wrong then return check.bad(2, "project", "%s", wrong) end
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
  check.integer(1, "project", "lmax", lmax, 0, core.limits.sh_lmax)
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
  c = args.held("project", args.as(c, o.dtype))
  if not o.out then return c, about end
  local shape = core.array_info(c)
  local out = args.result("project", o.out, shape, o.dtype)
  assert(core.sh_resize(lmax, lmax, #shape == 1 and 1 or shape[1], c, out))
  return out, about
end

project.of_samples, project.distance = of_samples, distance -- sh/sky.lua
project.misshapen = misshapen -- light/environment.lua

return project
