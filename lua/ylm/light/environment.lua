--- Light from all around, infinitely far away: ylm.environment_light.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"
local pack = require "ylm.light.pack"
local skies = require "ylm.sh.sky"

local environment = {}

local MOST, LMAX = core.limits.light_texels, core.limits.lmax

--- Which of the sources of an environment is given; fails unless there is one.
local function source_of(values, fail)
  local given = {}
  for _, name in ipairs { "radiance", "coefficients", "image", "file", "sky" } do
    if values[name] ~= nil then given[#given + 1] = name end
  end
  if #given ~= 1 then
    return fail("give one of radiance, coefficients, image, file and sky"
      .. (given[1] and ", got " .. table.concat(given, " and ") or ""))
  end
  if values.lmax and (given[1] == "radiance" or given[1] == "coefficients") then
    return fail "lmax is for an image, a file or a sky"
  end
  return given[1]
end

--- Rows of coefficients as tables, one or three, and their lmax.
local function from_coefficients(values, fail)
  local c = array.rows(1, "environment_light", "coefficients", values.coefficients, nil, "double")
  local shape, _, convention = core.array_info(c)
  local lmax = require "ylm.sh.args".lmax_of(shape[#shape])
  if #shape > 2 or #shape == 2 and shape[1] ~= 1 and shape[1] ~= 3 or not lmax or lmax > LMAX then
    return fail(("coefficients must be [(lmax+1)^2] or [3][(lmax+1)^2], lmax at most %d, got %s"):format(
      LMAX, table.concat(shape, "x")))
  end
  if convention ~= 0 then c = require "ylm.sh.convert".convert(c, "ylm") end
  local list = core.array_totable(c)
  return #shape == 2 and list or { list }, lmax
end

--- The image that is given, or read from a file; nil, message, code.
local function image_of(values, fail)
  local image, message, code = values.image
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
  if not memory.pcall(core.image_info, image) then return fail "the image has been closed" end
  return image
end

--- Rows of coefficients of an image of the whole sphere, their lmax, and what rays see, for core.lights_panorama; or nil,
-- message, code.
local function from_image(values, fail)
  local image, message, code = image_of(values, fail)
  if not image then return nil, message, code end
  local size = image.size
  local wrong = require "ylm.sh.project".misshapen(values.mapping, size[1], size[2])
  if wrong then return fail(wrong) end
  if size[1] * size[2] > MOST then
    return fail(("image must have at most %s texels, got %dx%d"):format(check.limit_text(MOST), size[1], size[2]))
  end
  local texels
  texels, message, code = core.texture_texels(core.image_layer(image))
  if not texels then return nil, message, code end
  local sound, fault = core.panorama_check(texels, values.mapping, values.up)
  if not sound then return fail("image: " .. fault) end
  local lmax, c = values.lmax or 20
  c, message, code = require "ylm.sh.project".project(lmax, image, { mapping = values.mapping, up = values.up })
  if not c then return nil, message, code end
  local list = core.array_totable(c)
  if type(list[1]) ~= "table" then list = { list } end
  return list[3] and list or { list[1] }, lmax, texels
end

--- Rows of coefficients of a sky of the CIE, their lmax, and what rays see; or nil, message, code.
local function from_sky(values, fail)
  local function wrong(message) return fail("sky: " .. message) end
  if form.kind(values.sky) then return fail("sky must be a table, got a " .. form.kind(values.sky)) end
  local sky = skies.settle(form.check(skies.scene_fields, values.sky, wrong), wrong)
  local lmax = values.lmax or 20
  local c, message, code = skies.coefficients(lmax, sky, math.max(96, 2 * lmax))
  if not c then return nil, message, code end
  return { core.array_totable(c) }, lmax, sky
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

local function uniform(values)
  local c, scale = values.radiance, values.scale
  return { { { scale * c[1], scale * c[2], scale * c[3] }, -1, { 2 * math.sqrt(math.pi) } } }
end

--- Appends the numbers of a record { colour, lmax, coefficients } to `out`.
local function append(out, r)
  local n = #out
  out[n + 1], out[n + 2], out[n + 3], out[n + 4] = r[1][1], r[1][2], r[1][3], r[2]
  for i = 1, #r[3] do out[n + 4 + i] = r[3][i] end
  return out
end

--- The lights of records that rays see otherwise; fail(message) raises; or nil, message, code.
local function panorama(values, seen, fail)
  local records = {}
  for i, r in ipairs(values.records) do records[i] = array.array(append({}, r), "double") end
  local lights, message, code = core.lights_panorama(seen, values.mapping, values.up, values.scale, records)
  if lights then return lights end
  if core.status(code) == "caller" then return fail((message:gsub("^%a+ %d+", "it"))) end
  return check.result("environment_light", nil, message, code)
end

local from = { coefficients = from_coefficients, image = from_image, file = from_image, sky = from_sky }

local function build(values, fail)
  local source = source_of(values, fail)
  if source == "radiance" then
    values.records = uniform(values)
  else
    local rows, lmax, seen = from[source](values, fail)
    if not rows then return nil, lmax, seen end
    form.take_numbers({ #rows, #rows[1] }, fail)
    values.records, values.lmax, values.seen = records_of(rows, lmax, values.scale), lmax, seen
  end
  local lights, message, code
  if values.seen then
    lights, message, code = panorama(values, values.seen, fail)
  else
    lights, message, code = pack.one("environment_light", values, fail)
  end
  if not lights then return nil, message, code end
  values.lights = lights
  return setmetatable(values, form.defined.environment_light.metatable)
end

--- Numbers of three channels, or of one, of records; their scale is the first colour's.
local function coefficients_of(l)
  local rows = {}
  for i, r in ipairs(l.records) do rows[i] = r[3] end
  return #rows == 1 and rows[1] or rows
end

--- Light from all around stands in extras.ylm of the scene, since images of EXT_lights_image_based hold 8 bits.
local function write(w, l)
  w:leave_out "skies, in extras.ylm, which other programs do not read"
  local sky = l.sky and w.object("kind", l.seen.kind, "zenith", check.plain(l.sky.zenith), "sun", check.plain(l.sky.sun),
    "luminance", l.seen.luminance)
  local coefficients = not sky and not l.radiance and coefficients_of(l) or nil
  if l.image or l.file then
    w:leave_out(("images of skies, written as their coefficients of degree %d"):format(l.lmax))
  end
  w:sky("radiance", l.radiance, "coefficients", coefficients, "sky", sky, "lmax", sky and l.lmax, "scale", l.scale)
end

environment.environment_light = form.define("environment_light", {
  shelf = "everyday",
  numbers = 256,
  about = "Light from all around, infinitely far away: the same at every point, seen where nothing is hit. Give radiance, "
    .. "coefficients, image, file or sky. Light fields have its coefficients; rays see the image or the sky itself, of "
    .. "coefficients the reconstruction, or 0 where that is negative.",
  fields = {
    { "radiance", "colour", optional = true, unit = "W sr^-1 m^-2", about = "the same from every direction; may be negative" },
    { "coefficients", "any", optional = true, unit = "W sr^-1/2 m^-2",
      about = "[(lmax+1)^2] or [3][(lmax+1)^2], of the convention that the array says; higher degrees are refused" },
    { "image", "any", optional = true, unit = "W sr^-1 m^-2",
      about = "a ylm.image of the whole sphere, whose first layer is radiance, not negative" },
    { "file", "string", optional = true, about = "an image file (.exr, .hdr, .png, .pfm) instead of image" },
    { "sky", "table", optional = true, unit = "W sr^-1 m^-2",
      about = "a sky of the CIE: { kind =, zenith =, sun =, luminance = } as ylm.sh.sky takes them, but for the zenith, by "
        .. "default { 0, 1, 0 }: scenes' up is y" },
    { "mapping", "choice", of = core.choices "mapping", default = "latlong", about = "of the image" },
    { "up", "choice", of = core.choices "up", default = "z", about = "of the image: where its pole is" },
    { "lmax", "integer", min = 0, max = LMAX, optional = true,
      about = "of the coefficients of an image or a sky, default 20; fields of higher degree are refused" },
    { "scale", "number", default = 1, about = "multiplies everything" },
    pack.photometric,
  },
  build = build,
  light = {
    photometric = true,
    kind = function(l) return not l.seen and "environment" or nil end,
    record = function(l, out)
      for _, r in ipairs(l.records) do append(out, r) end
    end,
    moved = function(l, changes) return pack.moved(l, changes, l.coefficients and "lmax") end, -- they have their own
    gltf = write,
  },
  example = "environment_light { radiance = {0.5, 0.6, 0.8} }",
})

return environment
