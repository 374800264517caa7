--- Intensities of lamps by direction: ylm.photometry, from IES LM-63 and EULUMDAT files, tables and functions.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local methods = require "ylm.photometry.methods"
local show = require "ylm.show"

local photometry = {}

-- Where intensities come from -----------------------------------------------------------------

local FUNCTION_ANGLES, FUNCTION_PLANES = 181, 72 -- that a function is asked for
local COSINE_STEP = 1                            -- degrees

--- A power of the cosine, as long lists: vertical angles, horizontal ones, intensities.
local function of_cosine(values)
  local vertical, row = {}, {}
  for i = 0, 90 / COSINE_STEP do
    vertical[i + 1] = i * COSINE_STEP
    row[i + 1] = math.cos(math.rad(i * COSINE_STEP)) ^ values.cosine
  end
  row[#row] = values.cosine == 0 and 1 or 0
  return vertical, { 0 }, { row }
end

--- A function of gamma and C, radians.
local function of_function(values, fail)
  local vertical, horizontal, rows = {}, {}, {}
  for i = 1, FUNCTION_ANGLES do vertical[i] = 180 * (i - 1) / (FUNCTION_ANGLES - 1) end
  for k = 1, FUNCTION_PLANES do
    horizontal[k], rows[k] = 360 * (k - 1) / FUNCTION_PLANES, {}
    for i = 1, FUNCTION_ANGLES do
      local cd = values.intensity(math.rad(vertical[i]), math.rad(horizontal[k]))
      if not check.is_number(cd) then
        return fail(("intensity must return a number, got %s at gamma %g, C %g degrees"):format(check.describe(cd), vertical[i],
          horizontal[k]))
      end
      rows[k][i] = cd
    end
  end
  return vertical, horizontal, rows
end

--- A field as a double array of `axes` axes; fails.
local function numbers(values, name, axes, fail)
  local value = values[name]
  if value == nil then return fail(("%s is missing: vertical, horizontal and candela belong together"):format(name)) end
  local shape = core.type(value) == "ylm.array" and core.array_info(value) or type(value) == "table" and array.shape_of(value)
  if not shape or #shape ~= axes then
    return fail(("%s must be numbers [%s], got %s"):format(name, axes == 1 and "n" or "h][v", check.describe(value)))
  end
  form.take_numbers(shape, fail)
  return array.array(value, "double"), shape
end

--- The table of vertical, horizontal and candela.
local function of_table(values, fail)
  local v, sv = numbers(values, "vertical", 1, fail)
  local h, sh = numbers(values, "horizontal", 1, fail)
  local c, sc = numbers(values, "candela", 2, fail)
  if sc[1] ~= sh[1] or sc[2] ~= sv[1] then
    return fail(("candela must be [%d][%d], horizontal by vertical angles, got [%d][%d]"):format(sh[1], sv[1], sc[1], sc[2]))
  end
  return v, h, c
end

local sources = { cosine = of_cosine, intensity = of_function, candela = of_table }

--- The path of the file of tilt factors that another names: in its folder, whoever asks.
local function locate(path, name, fail)
  local folder = path:match "^(.*)/[^/]*$" or "."
  if folder == "" then folder = "/" end
  name = name:gsub("\\", "/")
  local real, message = (form.locate or core.resolve_inside)(folder, name)
  return real or fail(("%s: TILT=%s: %s"):format(path, name, message))
end

local function from_file(values, fail)
  local given = { path = values.file, lamps = values.lamps, tilt = values.tilt, lumens = values.lumens,
    linear = values.interpolation == "linear" }
  local made, message, code = core.photometry_read(given)
  local wanted = made and values.tilt and core.photometry_facts(made).tilt_file
  if wanted then
    given.factors = locate(values.file, wanted, fail)
    made, message, code = core.photometry_read(given)
  end
  if made and form.budget then form.budget("numbers", 4 * core.photometry_facts(made).angles * core.photometry_facts(made).planes,
    fail) end
  return made, message, code
end

local opening_fields = {
  { "shape", "choice", of = core.choices "opening" },
  { "radius", "number", above = 0, max = 50, optional = true, unit = "m" },
  { "size", "list", of = "number", optional = true, unit = "m", about = "of a rectangle along C0, along C90" },
  { "height", "number", min = 0, max = 100, default = 0, unit = "m", about = "of luminous sides" },
}

--- An opening { shape =, radius = | size = } as a word and three sizes along C0, along C90 and up; fails. `what` names it.
function photometry.opening(what, given, fail)
  local function wrong(message) return fail(what .. ": " .. message) end
  local o = form.check(opening_fields, given, wrong)
  local rectangle = o.shape == "rectangle"
  if o.shape == "point" then return o.shape, { 0, 0, 0 } end
  if rectangle ~= (o.size ~= nil) or rectangle == (o.radius ~= nil) then
    return wrong(rectangle and "a rectangle has size = { along C0, along C90 }" or ("a %s has a radius"):format(o.shape))
  end
  local size = o.size or { 2 * o.radius, 2 * o.radius }
  if #size ~= 2 or not (size[1] > 0 and size[2] > 0 and size[1] <= 100 and size[2] <= 100) then
    return wrong "size must be two numbers above 0, at most 100"
  end
  return o.shape, { size[1], size[2], o.height }
end

local function from_numbers(values, source, fail)
  local vertical, horizontal, candela = sources[source](values, fail)
  local shape, size = "point", { 0, 0, 0 }
  if values.opening then shape, size = photometry.opening("opening", values.opening, fail) end
  local made, message, code = core.photometry_create { vertical = array.array(vertical, "double"),
    horizontal = array.array(horizontal, "double"), candela = array.array(candela, "double"), lumens = values.lumens,
    watts = values.watts or 0, opening = shape, size = size, linear = values.interpolation == "linear" }
  return made, message, code
end

--- The source that is given; fails unless there is one.
local function source_of(values, fail)
  local given = {}
  for _, name in ipairs { "file", "intensity", "cosine", "candela" } do
    if values[name] ~= nil then given[#given + 1] = name end
  end
  if #given ~= 1 then
    return fail("give one of file, candela (with vertical and horizontal), cosine and intensity"
      .. (given[1] and ", got " .. table.concat(given, " and ") or ""))
  end
  local file = given[1] == "file"
  for name, of_file in pairs { lamps = true, tilt = true, opening = false, watts = false, text = false } do
    if values[name] ~= nil and of_file ~= file then
      return fail(("%s is for %s"):format(name, of_file and "a file" or "tables, cosines and functions; a file has its own"))
    end
  end
  return given[1]
end

-- The object ------------------------------------------------------------------------------------

local metatable = {
  __index = function(p, key)
    local method = methods.list[key]
    if method ~= nil then return method end
    return methods.field(p, key)
  end,
  __newindex = function(_, key)
    return check.fail("photometry: cannot set %s: a photometry does not change, make another", check.describe(key))
  end,
  __tostring = function(p)
    return show.form("ylm.photometry", form.defined.photometry.fields, function(name) return core.owned(p, "values")[name] end)
  end,
}

--- A photometry of checked fields and C's table.
local function wrap(values, made)
  local p = setmetatable({}, metatable)
  local own = core.own(p)
  own.values, own.made, own.facts = values, made, core.photometry_facts(made)
  for name, text in pairs(values.text or {}) do own.facts.text[name] = text end
  return p
end

local function build(values, fail)
  local source = source_of(values, fail)
  if source ~= "file" then values.lamps, values.tilt = nil, nil end
  values.lamps = values.lamps or 1
  local made, message, code
  if source == "file" then made, message, code = from_file(values, fail)
  else made, message, code = from_numbers(values, source, fail) end
  if not made then
    if core.status(code) == "caller" then return fail(message) end
    return nil, message, code
  end
  return wrap(values, made)
end

--- The photometry of the bytes of a file; nil, message, code. `name`: for messages.
function photometry.of_bytes(name, bytes)
  if bytes:find "%z" then return nil, name .. ": a zero byte: not a photometric file", "EFORMAT" end
  local made, message, code = core.photometry_read { path = name, bytes = bytes, lamps = 1, linear = false }
  if not made then return nil, message, code end
  return wrap({ lamps = 1, interpolation = "spline" }, made)
end

photometry.photometry = form.define("photometry", {
  shelf = "everyday",
  about = "The luminous intensity of a lamp by direction, cd, from an IES LM-63 file (.ies, 1986 to 2019), a EULUMDAT file "
    .. "(.ldt), a table, a cosine or a function. ylm.photometric_light shines so. It does not change.",
  fields = {
    { "file", "path", optional = true, about = ".ies or .ldt, told apart by content" },
    { "vertical", "any", optional = true, unit = "degrees", about = "[v] angles gamma from the axis, increasing, 0 to 180" },
    { "horizontal", "any", optional = true, unit = "degrees",
      about = "[h] angles C around it, increasing, from 0, below 360; one: the same all around" },
    { "candela", "any", optional = true, unit = "cd", about = "[h][v]" },
    { "cosine", "number", min = 0, max = 1000, optional = true,
      about = "n: the intensity is cos^n of the angle to the axis, below the lamp" },
    { "intensity", "function", optional = true, unit = "cd",
      about = "f(gamma, c), radians; asked at 181 angles of 72 planes. Not in scene files" },
    { "lumens", "number", above = 0, max = 1e12, optional = true, unit = "lm",
      about = "scales to this flux; default: intensities stay as they are" },
    { "lamps", "integer", min = 1, max = 20, optional = true,
      about = "of an .ldt with several sets of lamps: which one, default 1" },
    { "tilt", "number", min = -180, max = 180, optional = true, unit = "degrees",
      about = "at which the lamp hangs: multiplies by the factor of the file's TILT table" },
    { "interpolation", "choice", of = { "spline", "linear" }, default = "spline",
      about = "between angles; linear compares with other programs" },
    { "opening", "table", optional = true,
      about = "of tables, cosines and functions, for files: { shape = 'disk', radius = }, { shape = 'rectangle', size = }" },
    { "watts", "number", min = 0, max = 1e9, optional = true, unit = "W", about = "of tables, cosines and functions" },
    { "text", "table", optional = true,
      about = "of tables, cosines and functions: words for files by name, { luminaire =, company =, lamp = }" },
  },
  build = build,
  metatable = metatable,
  example = 'photometry { cosine = 1, lumens = 3600 }',
})

return photometry
