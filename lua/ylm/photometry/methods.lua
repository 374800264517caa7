--- Methods and fields of photometries: intensities, flux, files.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image"
local library = require "ylm.library"
local memory = require "ylm.memory"

local methods = { list = {} }
local list = methods.list

--- C's table of a photometry, or an error of the method `name`.
local function open(name, p)
  local made = type(p) == "table" and core.owned(p, "made")
  return made or check.fail("%s: a photometry expected before the colon, got %s", name, check.describe(p))
end

methods.open = open

-- Fields ----------------------------------------------------------------------------------------

--- The angle, degrees, between the outermost directions of a plane and the opposite one that have a part of their peak.
local function width(made, plane, part)
  local step, ways = 0.25, {}
  for i = -720, 720 do
    local g, c = math.rad(i * step), math.rad(plane)
    ways[#ways + 1] = { math.sin(g) * math.cos(c), math.sin(g) * math.sin(c), math.cos(g) }
  end
  local cd = core.array_totable((core.photometry_intensity(made, array.array(ways, "double"), 0)))
  local peak, first, last = 0, nil, nil
  for _, x in ipairs(cd) do peak = math.max(peak, x) end
  if not (peak > 0) then return 0 end
  for i, x in ipairs(cd) do
    if x >= part * peak then first, last = first or i, i end
  end
  return (last - first) * step
end

--- The opening as a table { shape =, radius = | size =, height = }.
local function opening_of(facts)
  local s = facts.size
  local o = { shape = facts.opening, height = s[3] > 0 and facts.opening ~= "sphere" and s[3] or nil }
  if o.shape == "rectangle" then o.size = { s[1], s[2] }
  elseif o.shape ~= "point" then o.radius = s[1] / 2 end
  return o
end

local fields = {
  lumens = function(made) return core.photometry_flux(made, 0, 180) end,
  lumens_file = function(_, facts) return facts.lumens > 0 and facts.lumens or nil end,
  watts = function(_, facts) return facts.watts > 0 and facts.watts or nil end,
  efficacy = function(made, facts) return facts.watts > 0 and core.photometry_flux(made, 0, 180) / facts.watts or nil end,
  opening = function(_, facts) return opening_of(facts) end,
  format = function(_, facts) return facts.format end,
  peak = function(_, facts) return facts.peak end,
  text = function(_, facts) return facts.text end,
  notes = function(_, facts) return facts.notes end,
  beam = function(made) return width(made, 0, 0.5) end,
}

--- A field of a photometry: of the file, of the table, or as it was given.
function methods.field(p, key)
  local facts = core.owned(p, "facts")
  if fields[key] then return fields[key](core.owned(p, "made"), facts) end
  return core.owned(p, "values")[key]
end

require "ylm.describe".object "photometry" {
  about = "The luminous intensity of a lamp by direction. Directions stand in the lamp's frame: x is C0, y is C90, z the axis, "
    .. "gamma = 0. It does not change.",
  fields = {
    { "lumens", "number", "flux of the table, lm" },
    { "lumens_file", "number", "flux of the bare lamps as the file says, lm; nil: the file is absolute" },
    { "watts", "number", "W, or nil" },
    { "efficacy", "number", "lm/W, or nil" },
    { "opening", "table", "{ shape = 'point' | 'sphere' | 'disk' | 'rectangle', radius = | size = { along C0, along C90 }, "
      .. "height = }, m" },
    { "peak", "number", "the largest intensity, cd" },
    { "beam", "number", "the angle within which C0-C180 has half of its peak, degrees" },
    { "format", "string", "of the file" },
    { "text", "table", "words of the file by name" },
    { "notes", "string[]", "what was left out or taken another way" },
  },
  methods = list,
}

-- Intensities -------------------------------------------------------------------------------------

--- Argument 1 as unit directions, double [n][3], and whether it is a single one.
local function directions(name, value)
  local a, single = array.rows(1, name, "directions", value, 3, "double")
  local shape = core.array_info(a)
  if #shape > 2 then return check.bad(1, name, "directions [n][3] expected, got %s", check.describe(a)) end
  local rows = single and { core.array_totable(a) } or core.array_totable(a)
  for i, w in ipairs(rows) do
    local length = math.sqrt(w[1] ^ 2 + w[2] ^ 2 + w[3] ^ 2)
    if not (length > 0 and length < math.huge) then return check.bad(1, name, "direction %d has no length", i) end
    for k = 1, 3 do w[k] = w[k] / length end
  end
  if #rows == 0 then return core.array_zeros({ 0, 3 }, "double"), false end
  return array.array(rows, "double"), single
end

local intensity_options = {
  { "derivatives", "integer", min = 0, max = 2, default = 0, about = "0 intensities, 1 and gradients, 2 and Hessians" },
}

describe "photometry:intensity" {
  about = "Intensities in directions of the lamp's frame.",
  arguments = { { "directions", "array|table", "[n][3] or one, any length but 0" }, { "options?", "table", "" } },
  options = intensity_options,
  returns = { { "cd", "array|number", "double [n], cd; a number of a single direction" },
    { "gradient", "array", "double [n][3], or nil: of the function that is constant along rays, at length 1" },
    { "hessian", "array", "double [n][6], or nil: xx xy xz yy yz zz" } },
  errors = "raises on directions without length; nil, message, code: memory",
  example = [[
local p = ylm.photometry { cosine = 1 }
assert(math.abs(p:intensity { 0, 0, 1 } - 1) < 1e-12 and p:intensity { 0, 0, -1 } == 0)]],
}
function list.intensity(p, ways, given)
  local made = open("intensity", p)
  local o = form.options(2, "intensity", intensity_options, given)
  local a, single = directions("intensity", ways)
  local cd, g, h = check.result("intensity", core.photometry_intensity(made, a, o.derivatives))
  if not cd then return nil, g, h end
  if single then return cd:get(1), g and g[1], h and h[1] end
  return cd, g, h
end

local flux_options = {
  { "from", "number", min = 0, max = 180, default = 0, unit = "degrees", about = "from the axis" },
  { "to", "number", min = 0, max = 180, default = 180, unit = "degrees" },
}

describe "photometry:flux" {
  about = "The flux within a zone between two angles to the axis.",
  arguments = { { "options?", "table", "" } },
  options = flux_options,
  returns = { { "lumens", "number", "lm" } },
  errors = "raises on a bad option",
  example = [[
local p = ylm.photometry { cosine = 1, lumens = 1000 }
assert(math.abs(p:flux { to = 60 } - 750) < 1e-3)]],
}
function list.flux(p, given)
  local made = open("flux", p)
  local o = form.options(1, "flux", flux_options, given)
  return core.photometry_flux(made, o.from, o.to)
end

describe "photometry:check" {
  about = "The facts about a table, and whether it agrees with its file.",
  arguments = {},
  returns = { { "facts", "table", "lumens (of the table), lumens_file (of the bare lamps, or nil), ratio (of the two, or nil), "
    .. "watts, efficacy, peak (cd), beam and field ({C0-C180, C90-C270}: degrees within half, and a tenth, of the plane's peak), "
    .. "downward (the part of the flux below 90 degrees), clipped (the part of the sphere where the spline is negative, which "
    .. "counts as 0), angles, planes, warnings (sentences, or nil)" } },
  errors = "raises before anything but a photometry",
  example = [[
local facts = ylm.photometry { cosine = 1, lumens = 1000 }:check()
assert(facts.downward == 1 and math.abs(facts.beam[1] - 120) < 1)]],
}
function list.check(p)
  local made = open("check", p)
  local facts, lumens = core.owned(p, "facts"), core.photometry_flux(made, 0, 180)
  local out = { lumens = lumens, lumens_file = p.lumens_file, watts = p.watts, efficacy = p.efficacy, peak = facts.peak,
    beam = { width(made, 0, 0.5), width(made, 90, 0.5) }, field = { width(made, 0, 0.1), width(made, 90, 0.1) },
    downward = lumens > 0 and core.photometry_flux(made, 0, 90) / lumens or 0, clipped = facts.clipped, angles = facts.angles,
    planes = facts.planes }
  out.ratio = out.lumens_file and lumens / out.lumens_file or nil
  if out.ratio and (out.ratio < 0.2 or out.ratio > 1.1) then
    out.warnings = { ("the table has %.4g lm, %.3g of the %.4g lm of the lamps: one of the two is another lamp's"):format(lumens,
      out.ratio, out.lumens_file) }
  end
  return out
end

-- Files ---------------------------------------------------------------------------------------------

describe "photometry:save" {
  about = "Writes the table as a file: .ies is LM-63-2002 with absolute intensities, .ldt is EULUMDAT. Planes that are alike are "
    .. "written once. C0 and the opening stay where they are, whichever format the lamp came from.",
  arguments = { { "path", "string", "ends in .ies or .ldt" } },
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending, and on a table that EULUMDAT has no room for; nil, message, code where the file cannot be "
    .. "written",
  example = [[
local name = os.tmpname() .. ".ies"
assert(ylm.photometry { cosine = 1, lumens = 1000 }:save(name))
assert(math.abs(ylm.load(name).lumens - 1000) < 0.01)
os.remove(name)]],
}
function list.save(p, path)
  local made = open("save", p)
  local ending = type(path) == "string" and not path:find "%z" and path:lower():match "[^/]%.(%w+)$"
  if ending ~= "ies" and ending ~= "ldt" then
    return check.bad(1, "save", "a file name that ends in .ies or .ldt expected, got %s", check.describe(path))
  end
  local texts = {}
  for name, text in pairs(core.owned(p, "facts").text) do texts[#texts + 1] = { name, text } end
  table.sort(texts, function(a, b) return a[1] < b[1] end)
  local flat = {}
  for _, pair in ipairs(texts) do
    flat[#flat + 1], flat[#flat + 2] = tostring(pair[1]), (tostring(pair[2]):gsub("[%c]", " "))
  end
  return check.result("save", core.photometry_write(made, path, ending == "ldt", flat))
end

describe "photometry:table" {
  about = "The numbers of the table, symmetries undone.",
  arguments = {},
  returns = { { "vertical", "array", "double [v], degrees" }, { "horizontal", "array", "double [h], degrees" },
    { "candela", "array", "double [h][v], cd" } },
  errors = "nil, message, code: memory",
  example = "local v, h, cd = ylm.photometry { cosine = 2 }:table()\nassert(#v == 91 and #h == 1 and cd.shape[2] == 91)",
}
list.table = function(p) return check.result("table", core.photometry_grid(open("table", p))) end

local image_options = {
  { "size", "list", of = "integer", min = 1, max = 8192, default = { 256, 128 }, unit = "pixels", about = "{ width, height }" },
}

describe "photometry:image" {
  about = "The intensities of all directions as an image of the whole sphere, mapping 'latlong': the lamp looks down, at the "
    .. "lowest row; C0 is its middle.",
  arguments = { { "options?", "table", "" } },
  options = image_options,
  returns = { { "image", "image", "one layer, intensity, cd" } },
  errors = "raises on a bad option; nil, message, code: memory",
  example = [[
local image = ylm.photometry { cosine = 1 }:image { size = { 8, 4 } }
assert(image:layer():get(4, 1, 1) > 0.9 and image:layer():get(1, 1, 1) == 0)]],
}
function list.image(p, given)
  local made = open("image", p)
  local o = form.options(1, "image", image_options, given)
  if #o.size ~= 2 then return check.bad(1, "image", "size must be { width, height } in pixels") end
  local image, message, code = images.image { size = o.size, layers = { { "intensity", 1 } } }
  if not image then return nil, message, code end
  local ways = image:directions() * { 1, 1, -1 }
  local cd
  cd, message, code = check.result("image", core.photometry_intensity(made, ways, 0))
  if not cd then return nil, message, code end
  local layer = image:layer()
  layer[{ {}, {}, {} }] = core.array_reshape(cd, { o.size[2], o.size[1], 1 })
  return image
end

describe "photometry:plot" {
  about = "The polar curve as catalogues print it: gamma = 0 points down, rings are intensities.",
  arguments = { { "options?", "table", "see ylm help polar_plot" } },
  returns = { { "plot", "polar_plot", "with save (.png, .svg, .pdf) and pixels" } },
  errors = "raises on a bad option",
  example = "local plot = ylm.photometry { cosine = 1 }:plot { planes = { 0, 90 } }\nassert(tostring(plot):find 'polar_plot')",
}
function list.plot(p, given)
  open("plot", p)
  return library.later["ylm.plot.polar"](p, given)
end

memory.publish(list)

return methods
