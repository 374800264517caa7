--- Light from all around, infinitely far away: ylm.environment_light.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local pack = require "ylm.light.pack"

local environment = {}

local MOST = 2 ^ 22 -- texels

--- Which of the sources of an environment is given; fails unless there is one.
local function source_of(values, fail)
  local given = {}
  for _, name in ipairs { "radiance", "coefficients", "image", "file" } do
    if values[name] ~= nil then given[#given + 1] = name end
  end
  if #given ~= 1 then
    return fail("give one of radiance, coefficients, image and file"
      .. (given[1] and ", got " .. table.concat(given, " and ") or ""))
  end
  if values.lmax and values.image == nil and values.file == nil then return fail "lmax is for an image or a file" end
  return given[1]
end

--- Rows of coefficients as tables, one or three, and their lmax.
local function from_coefficients(values, fail)
  local c = array.rows(1, "environment_light", "coefficients", values.coefficients, nil, "double")
  local shape, _, convention = core.array_info(c)
  local lmax = require "ylm.sh.args".lmax_of(shape[#shape])
  if #shape > 2 or #shape == 2 and shape[1] ~= 1 and shape[1] ~= 3 or not lmax or lmax > 100 then
    return fail(("coefficients must be [(lmax+1)^2] or [3][(lmax+1)^2], lmax at most 100, got %s"):format(
      table.concat(shape, "x")))
  end
  if convention ~= 0 then c = require "ylm.sh.convert".convert(c, "ylm") end
  local list = core.array_totable(c)
  return #shape == 2 and list or { list }, lmax
end

--- Rows of coefficients of an image of the whole sphere, projected, and their lmax; nil, message, code.
local function from_image(values, fail)
  local image, c, message, code = values.image
  if values.file then
    if #values.file == 0 or values.file:find "%z" then return fail "file must be a file name" end
    local lib
    lib, message, code = require "ylm.image".codec()
    if not lib then return nil, message, code end
    local most = math.min(MOST, form.budget and form.budget "texels" or MOST)
    image, message, code = lib.image_read(values.file, false, 4 * most, form.budget and form.budget "file_size")
    if not image then return nil, message, code end
    if form.budget then form.budget("texels", image.size[1] * image.size[2], fail) end
  end
  if core.type(image) ~= "ylm.image" then return fail("image must be a ylm.image, got " .. check.describe(image)) end
  local lmax = values.lmax or 20
  c, message, code = require "ylm.sh.project".project(lmax, image, { mapping = values.mapping, up = values.up })
  if not c then return nil, message, code end
  local list = core.array_totable(c)
  return type(list[1]) == "table" and list or { list }, lmax
end

local function equal(a, b)
  for i = 1, #a do if a[i] ~= b[i] then return false end end
  return true
end

--- Records { colour, lmax, coefficients } of rows for one or three channels: equal channels are one record.
local function records_of(rows, lmax, scale)
  if not rows[2] or equal(rows[1], rows[2]) and equal(rows[1], rows[3]) then
    return { { { scale, scale, scale }, lmax, rows[1] } }
  end
  return { { { scale, 0, 0 }, lmax, rows[1] }, { { 0, scale, 0 }, lmax, rows[2] }, { { 0, 0, scale }, lmax, rows[3] } }
end

local function build(values, fail)
  local source, scale = source_of(values, fail), values.scale
  if source == "radiance" then
    local c = values.radiance
    values.records = { { { scale * c[1], scale * c[2], scale * c[3] }, -1, { 2 * math.sqrt(math.pi) } } }
  else
    local rows, lmax, code = (source == "coefficients" and from_coefficients or from_image)(values, fail)
    if not rows then return nil, lmax, code end
    form.take_numbers({ #rows, #rows[1] }, fail)
    values.records, values.lmax = records_of(rows, lmax, scale), lmax
  end
  local lights, message, code = pack.one("environment_light", values, fail)
  if not lights then return nil, message, code end
  values.lights = lights
  return setmetatable(values, form.defined.environment_light.metatable)
end

environment.environment_light = form.define("environment_light", {
  numbers = 256,
  about = "Light from all around, infinitely far away: the same at every point, seen where nothing is hit. Give radiance, "
    .. "coefficients, image or file. Rays see the reconstruction from the coefficients, or 0 where that is negative.",
  fields = {
    { "radiance", "colour", optional = true, unit = "W sr^-1 m^-2", about = "the same from every direction; may be negative" },
    { "coefficients", "any", optional = true, unit = "W sr^-1/2 m^-2",
      about = "[(lmax+1)^2] or [3][(lmax+1)^2], of the convention that the array says; higher degrees are refused" },
    { "image", "any", optional = true, unit = "W sr^-1 m^-2", about = "a ylm.image of the whole sphere, projected" },
    { "file", "string", optional = true, about = "an image file (.exr, .hdr, .png, .pfm) instead of image" },
    { "mapping", "choice", of = { "latlong", "angular", "cube" }, default = "latlong", about = "of the image" },
    { "up", "choice", of = { "z", "y" }, default = "z", about = "of the image: where its pole is" },
    { "lmax", "integer", min = 0, max = 100, optional = true,
      about = "of the image's coefficients, default 20; fields of higher degree are refused" },
    { "scale", "number", default = 1, about = "multiplies everything" },
  },
  build = build,
  light = {
    kind = "environment",
    record = function(l, out)
      for _, r in ipairs(l.records) do
        local n = #out
        out[n + 1], out[n + 2], out[n + 3], out[n + 4] = r[1][1], r[1][2], r[1][3], r[2]
        for i = 1, #r[3] do out[n + 4 + i] = r[3][i] end
      end
    end,
  },
  example = "environment_light { radiance = {0.5, 0.6, 0.8} }",
})

return environment
