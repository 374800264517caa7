--- Light that is asked for at receivers, as a number that is 0 where it is there, and its derivatives by illuminances.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local image = require "ylm.image"
local objects = require "ylm.transfer.object"

local targets = {}

local EACH = 4 -- how much more than its area each place counts as

local fields = {
  { "name", "string", optional = true },
  { "plane", "table", optional = true, about = "as of links:receivers" },
  { "points", "any", optional = true },
  { "normals", "any", optional = true },
  { "mesh", "integer", min = 1, optional = true },
  { "size", "texels", optional = true, about = "of a mesh: { width, height } of its lightmap" },
  { "quantity", "choice", of = { "illuminance", "cylindrical" }, default = "illuminance" },
  { "receivers", "object", of = "ylm.receivers", optional = true, about = "instead: of the links that are given" },
  { "mean", "any", optional = true, about = "{ least =, most = }, lx" },
  { "uniformity", "number", above = 0, max = 0.999, optional = true, about = "least over mean" },
  { "least", "number", above = 0, optional = true, about = "at every place" },
  { "most", "number", above = 0, optional = true, about = "at every place" },
  { "image", "any", optional = true,
    about = "what a plane shall look like, brightness aside: an image, its file, or [rows][columns] numbers, the top row first" },
  { "wanted", "any", optional = true, about = "[n] illuminances, one of each place" },
  { "weight", "number", above = 0, default = 1 },
}

--- An image's luminance, [rows][columns], as a list of rows.
local function rows_of(given, fail)
  if type(given) == "string" then
    local loaded, message = image.image { file = given }
    if not loaded then return fail(message) end
    given = loaded
  end
  if core.type(given) == "ylm.image" then
    local layer = given:layer(given.layers[1].name or given.layers[1][1])
    if layer.shape[3] == 3 then layer = (layer * core.luminance):sum(3)
    else layer = layer:reshape { layer.shape[1], layer.shape[2] } end
    return layer:totable()
  end
  local ok, a = pcall(array.array, given, "double")
  if not ok or #a.shape ~= 2 then return fail "image must be an image, a file of one, or numbers [rows][columns]" end
  return a:totable()
end

--- Rows of numbers at column x and row y, whose middles are whole numbers, between these linear.
function targets.between(rows, x, y)
  local h, w = #rows, #rows[1]
  local c, r = math.floor(x), math.floor(y)
  local s, t = x - c, y - r
  local function pixel(i, k) return rows[math.max(1, math.min(h, i))][math.max(1, math.min(w, k))] end
  return (1 - t) * ((1 - s) * pixel(r, c) + s * pixel(r, c + 1)) + t * ((1 - s) * pixel(r + 1, c) + s * pixel(r + 1, c + 1))
end

--- The image's values at places of a plane.
local function at_places(rows, m, fail)
  if not m.size then return fail "image is for a plane, or a mesh with size" end
  local out, h, w = {}, #rows, #rows[1]
  for i, place in ipairs(m.keep) do
    local column, row = (place - 1) % m.size[1], math.floor((place - 1) / m.size[1])
    out[i] = targets.between(rows, (column + 0.5) / m.size[1] * w + 0.5, (row + 0.5) / m.size[2] * h + 0.5)
  end
  return out
end

local function check_mean(t, fail)
  if t.mean == nil then return end
  if check.is_number(t.mean) then t.mean = { least = t.mean } end
  local least, most
  if type(t.mean) == "table" then least, most = t.mean.least, t.mean.most end
  if not (least or most) or least and not (check.is_number(least) and least > 0)
    or most and not (check.is_number(most) and most > 0) then
    return fail "mean must be { least =, most = }, lx above 0"
  end
  if least and most and least > most then return fail(("mean: least %g is above most %g"):format(least, most)) end
end

--- One target with its receivers; nil, message, code.
local function open(given, i, links, o)
  local function fail(message) return check.fail("inverse_lighting: targets[%d]: %s", i, message) end
  if type(given) ~= "table" then return fail(("a table expected, got %s"):format(check.describe(given))) end
  local t = form.check(fields, given, fail)
  check_mean(t, fail)
  if t.least and t.most and t.least > t.most then return fail(("least %g is above most %g"):format(t.least, t.most)) end
  if not (t.mean or t.uniformity or t.least or t.most or t.image or t.wanted) then
    return fail "nothing is wanted: give mean, uniformity, least, most, image or wanted"
  end
  local r, message, code = t.receivers
  if not r then
    r, message, code = links:receivers { plane = t.plane, points = t.points, normals = t.normals, mesh = t.mesh, size = t.size,
      quantity = t.quantity, rays = o.receiver_rays, light_samples = o.receiver_samples, seed = o.seed, threads = o.threads }
    if not r then return nil, message, code end
  end
  local m = objects.open_receivers("inverse_lighting", r)
  if m.links ~= links then return fail "receivers are of other links" end
  t.receivers, t.count, t.areas, t.plane = r, m.count, m.weights:totable(), m.options.plane
  if t.image then
    t.shape = at_places(rows_of(t.image, fail), m, fail)
    local sum = 0
    for k, v in ipairs(t.shape) do sum = sum + t.areas[k] * v end
    if not (sum > 0) then return fail "image is dark where the receivers are" end
  end
  if t.wanted ~= nil then
    local ok, a = pcall(array.array, t.wanted, "double")
    if not ok or #a.shape ~= 1 or a.shape[1] ~= m.count then return fail(("wanted must be %d numbers"):format(m.count)) end
    t.wanted = a:totable()
  end
  return t
end

--- The targets of a list; nil, message, code.
function targets.open(list, links, o)
  if type(list) ~= "table" or #list == 0 then return check.fail "inverse_lighting: targets is empty: what is wanted?" end
  local out = {}
  for i, given in ipairs(list) do
    local t, message, code = open(given, i, links, o)
    if not t then return nil, message, code end
    out[i] = t
  end
  return out
end

--- Has any target a limit that is met or not?
function targets.have_limits(list)
  for _, t in ipairs(list) do if t.mean or t.uniformity or t.least or t.most then return true end end
  return false
end

-- The objective -----------------------------------------------------------------------------------------------------

--- Adds a hinge on each place to w, the derivatives by illuminances: EACH n a (over(F))^2, over's slope with it; the sum.
local function each_place(t, F, w, over)
  local sum, factor = 0, t.weight * EACH * t.count
  for r = 1, t.count do
    local h, slope = over(F[r])
    if h > 0 then
      sum = sum + factor * t.areas[r] * h * h
      w[r] = w[r] + 2 * factor * t.areas[r] * h * slope
    end
  end
  return sum
end

--- The sum of squares of F - T over that of T.
local function distance(t, F, T, w)
  local off, all = 0, 0
  for r = 1, t.count do off, all = off + t.areas[r] * (F[r] - T[r]) ^ 2, all + t.areas[r] * T[r] ^ 2 end
  for r = 1, w and t.count or 0 do w[r] = w[r] + 2 * t.weight * t.areas[r] * (F[r] - T[r]) / all end
  return t.weight * off / all
end

--- 1 less the square of the cosine between F and the image: 0 where F is the image times a number.
local function unlike(t, F, w)
  local ff, ft, tt = 0, 0, 0
  for r = 1, t.count do
    local a, T = t.areas[r], t.shape[r]
    ff, ft, tt = ff + a * F[r] ^ 2, ft + a * F[r] * T, tt + a * T * T
  end
  if not (ff > 0) then return t.weight end
  for r = 1, w and t.count or 0 do
    w[r] = w[r] + t.weight * t.areas[r] * (2 * ft * ft * F[r] / (ff * ff * tt) - 2 * ft * t.shape[r] / (ff * tt))
  end
  return t.weight * (1 - ft * ft / (ff * tt))
end

--- The value of a target for illuminances F, a list, and its derivatives by them; `margin`: how much more is asked of the mean
-- and of places.
function targets.value(t, F, margin)
  local w, mean, by_mean, value = {}, 0, 0, 0
  for r = 1, t.count do w[r], mean = 0, mean + t.areas[r] * F[r] end
  local function hinge(h, slope)
    if h <= 0 then return end
    value, by_mean = value + t.weight * h * h, by_mean + 2 * t.weight * h * slope
  end
  if t.mean and t.mean.least then
    local E = t.mean.least * (1 + margin.mean)
    hinge(1 - mean / E, -1 / E)
  end
  if t.mean and t.mean.most then hinge(mean / t.mean.most - 1, 1 / t.mean.most) end
  if t.uniformity and mean > 0 then
    local u = math.min(0.999, t.uniformity + margin.uniformity)
    local factor = t.weight * EACH * t.count
    value = value + each_place(t, F, w, function(x) return u - x / mean, -1 / mean end)
    for r = 1, t.count do
      local h = u - F[r] / mean
      if h > 0 then by_mean = by_mean + 2 * factor * t.areas[r] * h * F[r] / mean ^ 2 end
    end
  end
  if t.least then
    local least = t.least * (1 + margin.uniformity)
    value = value + each_place(t, F, w, function(x) return 1 - x / least, -1 / least end)
  end
  if t.most then
    local most = t.most * (1 - margin.uniformity)
    value = value + each_place(t, F, w, function(x) return x / most - 1, 1 / most end)
  end
  for r = 1, t.count do w[r] = w[r] + t.areas[r] * by_mean end
  if t.shape then value = value + unlike(t, F, w) end
  if t.wanted then value = value + distance(t, F, t.wanted, w) end
  return value, w
end

--- Figures of a target: mean, least, most, uniformity; rms of an image or of illuminances that are wanted, relative; met.
function targets.figures(t, F)
  local f = objects.figures(array.array(F, "double"), array.array(t.areas, "double"))
  f.met = not (t.mean and (t.mean.least and f.mean < t.mean.least or t.mean.most and f.mean > t.mean.most)
    or t.uniformity and f.uniformity < t.uniformity or t.least and f.least < t.least or t.most and f.most > t.most)
  if t.shape then f.rms = math.sqrt(math.max(0, (unlike(t, F)))) / math.sqrt(t.weight) end
  if t.wanted then f.rms = math.sqrt(distance(t, F, t.wanted) / t.weight) end
  return f
end

return targets
