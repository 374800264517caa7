--- Light that is asked for at receivers, as a number that is 0 where it is there, and its derivatives by illuminances.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local image = require "ylm.image"
local objects = require "ylm.transfer.object"
local vector = require "ylm.vector"

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
  { "colour", "boolean", default = false,
    about = "image and wanted count by channel: wanted is [n][3] irradiances, numbers of image are [rows][columns][3]" },
  { "weight", "number", above = 0, default = 1 },
}

--- A list of rows of an image's layer [h][w] or [h][w][3]: of its luminance, or of its channels, which are three such lists.
local function channels_of(layer, in_colour)
  local h, w = layer.shape[1], layer.shape[2]
  if layer.shape[3] ~= 3 then
    local rows = layer:reshape({ h, w }):totable()
    return in_colour and { rows, rows, rows } or { rows }
  end
  if not in_colour then return { (layer * core.luminance):sum(3):totable() } end
  local out = {}
  for c = 1, 3 do
    local one = { 0, 0, 0 }
    one[c] = 1
    out[c] = (layer * one):sum(3):totable()
  end
  return out
end

--- The rows of an image, a list of them for each channel that counts.
local function rows_of(given, in_colour, fail)
  if type(given) == "string" then
    local loaded, message = image.image { file = given }
    if not loaded then return fail(message) end
    given = loaded
  end
  if core.type(given) == "ylm.image" then
    return channels_of(given:layer(given.layers[1].name or given.layers[1][1]), in_colour)
  end
  local ok, a = pcall(array.array, given, "double")
  local depth = ok and (#a.shape == 2 and 1 or #a.shape == 3 and a.shape[3])
  if depth ~= 1 and not (in_colour and depth == 3) then
    return fail(in_colour and "image must be an image, a file of one, or numbers [rows][columns][3]"
      or "image must be an image, a file of one, or numbers [rows][columns]")
  end
  return channels_of(a, in_colour)
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
  local out, h, w = {}, #rows[1], #rows[1][1]
  for _, place in ipairs(m.keep) do
    local column, row = (place - 1) % m.size[1], math.floor((place - 1) / m.size[1])
    for c = 1, #rows do
      out[#out + 1] = targets.between(rows[c], (column + 0.5) / m.size[1] * w + 0.5, (row + 0.5) / m.size[2] * h + 0.5)
    end
  end
  return out
end

--- The light [n][3] or [n] of a target as the list that it is judged by: of colours three numbers for each place.
function targets.list(t, E)
  local rows = E:totable()
  if not t.coloured then return rows end
  local out = {}
  for _, row in ipairs(rows) do for c = 1, 3 do out[#out + 1] = row[c] end end
  return out
end

--- Such a list out of irradiances [places][3] of which `fold` belong to one place.
function targets.folded(t, E, fold)
  if not t.coloured then return objects.luminance_of(E, t.count, fold):totable() end
  return targets.list(t, fold > 1 and E:reshape({ t.count, fold, 3 }):mean(2) or E)
end

--- The illuminances of such a list.
function targets.luminances(t, F)
  if not t.coloured then return F end
  local out = {}
  for r = 1, t.count do out[r] = vector.luminance { F[3 * r - 2], F[3 * r - 1], F[3 * r] } end
  return out
end

--- Derivatives by such a list as weights of importances: [n], or [n][3].
function targets.weights(t, w)
  if not t.coloured then return w end
  local rows = {}
  for r = 1, t.count do rows[r] = { w[3 * r - 2], w[3 * r - 1], w[3 * r] } end
  return rows
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

--- The part of the area of each number of a target's list.
local function parts_of(t)
  if not t.coloured then return t.areas end
  local out = {}
  for r = 1, t.count do for c = 1, 3 do out[3 * r - 3 + c] = t.areas[r] / 3 end end
  return out
end

--- One target with its receivers; nil, message, code.
local function open(given, i, links, o)
  local function fail(message) return check.fail("inverse_lighting: targets[%d]: %s", i, message) end
  if type(given) ~= "table" then return fail(("a table expected, got %s"):format(check.describe(given))) end
  if given.glare ~= nil then return fail "glare is no target: its derivatives by lamps are not known" end
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
  t.coloured = t.colour
  if t.colour and not (t.image or t.wanted) then return fail "colour is of image and of wanted: give one" end
  t.parts = parts_of(t)
  if t.image then
    t.shape = at_places(rows_of(t.image, t.colour, fail), m, fail)
    local sum = 0
    for k, v in ipairs(t.shape) do sum = sum + t.parts[k] * v end
    if not (sum > 0) then return fail "image is dark where the receivers are" end
  end
  if t.wanted ~= nil then
    local ok, a = pcall(array.array, t.wanted, "double")
    local deep = ok and (#a.shape == 1 and not t.colour or #a.shape == 2 and t.colour and a.shape[2] == 3)
    if not deep or a.shape[1] ~= m.count then
      return fail(("wanted must be %d numbers%s"):format(m.count, t.colour and " for each of three channels, [n][3]" or ""))
    end
    t.wanted = targets.list(t, a)
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
  local off, all, n = 0, 0, #F
  for r = 1, n do off, all = off + t.parts[r] * (F[r] - T[r]) ^ 2, all + t.parts[r] * T[r] ^ 2 end
  for r = 1, w and n or 0 do w[r] = w[r] + 2 * t.weight * t.parts[r] * (F[r] - T[r]) / all end
  return t.weight * off / all
end

--- 1 less the square of the cosine between F and the image: 0 where F is the image times a number.
local function unlike(t, F, w)
  local ff, ft, tt, n = 0, 0, 0, #F
  for r = 1, n do
    local a, T = t.parts[r], t.shape[r]
    ff, ft, tt = ff + a * F[r] ^ 2, ft + a * F[r] * T, tt + a * T * T
  end
  if not (ff > 0) then return t.weight end
  for r = 1, w and n or 0 do
    w[r] = w[r] + t.weight * t.parts[r] * (2 * ft * ft * F[r] / (ff * ff * tt) - 2 * ft * t.shape[r] / (ff * tt))
  end
  return t.weight * (1 - ft * ft / (ff * tt))
end

--- The value of a target's limits for illuminances F, and its derivatives by them.
local function limits(t, F, margin)
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
  return value, w
end

--- The value of a target for its light F, a list (targets.list), and its derivatives by it; `margin`: how much more is asked of
-- the mean and of places.
function targets.value(t, F, margin)
  local value, w = limits(t, targets.luminances(t, F), margin)
  if t.coloured then
    local by_channel = {}
    for r = 1, t.count do for c = 1, 3 do by_channel[3 * r - 3 + c] = w[r] * core.luminance[c] end end
    w = by_channel
  end
  if t.shape then value = value + unlike(t, F, w) end
  if t.wanted then value = value + distance(t, F, t.wanted, w) end
  return value, w
end

--- Figures of a target: mean, least, most, uniformity; rms of an image or of illuminances that are wanted, relative; met.
function targets.figures(t, F)
  local f = objects.figures(array.array(targets.luminances(t, F), "double"), array.array(t.areas, "double"))
  f.met = not (t.mean and (t.mean.least and f.mean < t.mean.least or t.mean.most and f.mean > t.mean.most)
    or t.uniformity and f.uniformity < t.uniformity or t.least and f.least < t.least or t.most and f.most > t.most)
  if t.shape then f.rms = math.sqrt(math.max(0, (unlike(t, F)))) / math.sqrt(t.weight) end
  if t.wanted then f.rms = math.sqrt(distance(t, F, t.wanted) / t.weight) end
  return f
end

return targets
