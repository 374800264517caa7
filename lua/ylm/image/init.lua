--- Images: named float layers of one size, with metadata, metrics and files.

require "ylm.array" -- its methods
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image.check"
local library = require "ylm.library"
local memory = require "ylm.memory"

local image = {}
local methods = core.metatable "ylm.image"

--- The library of file formats, or nil, message, "EMISSING" | "ENOMEM": the core works without it.
local function codec()
  return library.open("codec", "image files need libylm_codec with OpenEXR and libpng (Debian: libopenexr-dev libpng-dev, "
    .. "then make): %s")
end

local function check_path(n, name, path)
  if type(path) == "string" and #path > 0 and not path:find("%z") then return path end
  return check.bad(n, name, "a file name expected, got %s", check.describe(path))
end

image.image = form.define("image", {
  shelf = "everyday",
  about = "A raster of named layers of 32-bit floats, all zero; pixels are linear.",
  fields = {
    { "size", "list", of = "integer", unit = "pixels", about = "{ width, height }" },
    { "layers", "table", default = { { "radiance", 3 } },
      about = "list of { name, channels }; the first is the picture" },
    { "metadata", "table", default = {}, about = "strings or numbers by name" },
  },
  build = function(values, fail)
    local size = values.size
    if #size ~= 2 then return fail "size must be { width, height }" end
    for i = 1, 2 do
      if size[i] < 1 or size[i] > core.limits.image_side then
        return fail(("image size %.0f x %.0f: sides must be 1 .. %d"):format(size[1], size[2], core.limits.image_side))
      end
    end
    local new = check.result("image", core.image_new(size[1], size[2]))
    if #values.layers == 0 then return fail "layers must be a list of { name, channels }, not an empty one" end
    for i = 1, #values.layers do
      local layer = values.layers[i]
      if type(layer) ~= "table" or type(layer[1]) ~= "string" or not check.is_integer(layer[2]) then
        return fail(("layers: element %d must be { name, channels }"):format(i))
      end
      if layer[1]:find "%z" then return fail(("layers: the name of element %d holds a zero byte"):format(i)) end
      local ok, message, code = check.result("image", core.image_add(new, layer[1], layer[2]))
      if not ok then return nil, message, code end
    end
    for key, value in pairs(values.metadata) do new.metadata[key] = value end
    return new
  end,
  example = 'image { size = { 64, 32 }, layers = { { "radiance", 3 }, { "depth", 1 } } }',
})

require "ylm.describe".object "image" {
  about = "Named layers of linear 32-bit floats; the first, \"radiance\", is the picture.",
  fields = {
    { "size", "integer[]", "{ width, height }" },
    { "metadata", "table", "text by name: image.metadata.author = \"me\"" },
  },
}

-- Metadata --------------------------------------------------------------------------

--- The image that a table of metadata is of.
local function owner_of(proxy) return core.owned(proxy, "image") end

local metadata = {}

metadata.__index = function(proxy, key)
  if type(key) ~= "string" then return nil end
  return (core.image_get_text(owner_of(proxy), key))
end

metadata.__newindex = function(proxy, key, value)
  if type(key) ~= "string" or #key < 1 or #key > 255 or key:find("%z") then
    return check.fail("metadata: a name of 1 to 255 bytes expected, got %s", check.describe(key))
  end
  local t = type(value)
  if t == "number" then value = ("%.17g"):format(value)
  elseif t == "boolean" then value = tostring(value)
  elseif t ~= "nil" and (t ~= "string" or value:find("%z")) then
    return check.fail("metadata: '%s' must be a string, a number or true or false, got %s", key, check.describe(value))
  end
  check.result("metadata", core.image_set_text(owner_of(proxy), key, value))
end

--- All entries as a plain table.
metadata.__call = function(proxy)
  local all = {}
  for _, key in ipairs(core.image_texts(owner_of(proxy))) do
    all[key] = core.image_get_text(owner_of(proxy), key)
  end
  return all
end

-- Methods ------------------------------------------------------------------------------

methods.__index = function(x, key)
  if key == "size" then
    local w, h = images.open(x, "size")
    return { w, h }
  elseif key == "metadata" then
    images.open(x, "metadata")
    local proxy = setmetatable({}, metadata)
    core.own(proxy).image = x
    return proxy
  end
  return rawget(methods, key)
end

methods.__newindex = function(_, key)
  return check.fail("image: cannot set %s (metadata: image.metadata.name = value)", check.describe(key))
end

methods.__tostring = function(x)
  local is_open, w, h, names, channels = memory.pcall(core.image_info, x)
  if not is_open then return "ylm.image (closed)" end
  for i = 1, #names do names[i] = names[i] .. ":" .. channels[i] end
  return ("ylm.image %dx%d %s"):format(w, h, table.concat(names, " "))
end

describe "image:layers" {
  shelf = "everyday",
  about = "The names of the layers, in order, and how many channels each has.",
  arguments = {},
  returns = { { "names", "table", "list of strings" }, { "channels", "table", "number of channels by name" } },
  errors = "raises on what is not an image",
  example = [[
local names, channels = ylm.image { size = { 4, 2 } }:layers()
assert(names[1] == "radiance" and channels.radiance == 3)]],
}
function methods.layers(x)
  local _, _, names, counts = images.open(x, "layers")
  local channels = {}
  for i = 1, #names do channels[names[i]] = counts[i] end
  return names, channels
end

describe "image:layer" {
  shelf = "everyday",
  about = "A layer's pixels as an array that shares their memory: row 1 is the top.",
  arguments = { { "name?", "string", "default: the first layer" } },
  returns = { { "pixels", "array", "float [height][width][channels]" } },
  errors = "raises where there is no such layer",
  example = [[
local picture = ylm.image { size = { 4, 2 } }
picture:layer "radiance":set(1, 4, 2, 0.5)          -- green of the top right pixel
assert(picture:layer():get(1, 4, 2) == 0.5)]],
}
function methods.layer(x, name)
  images.layer("layer", x, name)
  return (core.image_layer(x, name))
end

describe "image:add" {
  about = "Adds a layer of zeros.",
  arguments = { { "name", "string", "letters, digits, '_', '-', '.'" }, { "channels", "integer", "1 to 4" } },
  returns = { { "pixels", "array", "float [height][width][channels]" } },
  errors = "raises where the name is taken or no name",
  example = 'assert(#ylm.image { size = { 4, 2 } }:add("depth", 1) == 2)',
}
function methods.add(x, name, channels)
  images.open(x, "add")
  if type(name) ~= "string" then return check.bad(1, "add", "a name expected, got %s", check.describe(name)) end
  check.integer(2, "add", "channels", channels, 1, 4)
  return check.result("add", core.image_add(x, name, channels))
end

--- Stops of an exposure, or "auto".
function form.types.exposure(x)
  if x == "auto" or type(x) == "number" and x >= -60 and x <= 60 then return x end
  return nil, "a number from -60 to 60, or 'auto'"
end

local save_options = {
  { "layer", "string", optional = true, about = "which layer (.png, .hdr, .pfm); default the first" },
  { "bits", "choice", of = { 8, 16, 32 }, optional = true,
      about = ".png 8 (default) or 16; .exr 16 (half) or 32 (default)" },
  { "exposure", "exposure", default = 0, unit = "stops",
      about = ".png: pixels are multiplied by 2^exposure; 'auto': as image:exposure has it" },
  { "tone", "choice", of = core.choices "tone", default = "srgb",
      about = ".png: tone curve; hable and aces are filmic" },
}

local exposure_options = {
  { "layer", "string", optional = true, about = "which layer; default the first" },
  { "stops", "number", min = -60, max = 60, optional = true, about = "asks about this exposure instead" },
}

describe "image:exposure" {
  about = "The exposure under which a picture is seen well: the mean logarithm of its luminance becomes that of a grey card. "
    .. "Black pixels, lamps (layer emitter) and what is 16 times as bright as the rest are left out.",
  arguments = { { "options?", "table", "" } },
  options = exposure_options,
  returns = { { "stops", "number", "pixels are multiplied by 2^stops" },
    { "shown", "table", "{ black, white }: parts of pixels that are shown as black, and as white" } },
  errors = "raises on a bad option, and where there is no such layer",
  example = [[
local picture = ylm.image { size = { 4, 2 } }
picture:fill(1, 1, 4, 2, 0.18 / 8)
local stops, shown = picture:exposure()
assert(math.abs(stops - 3) < 1e-5 and shown.black == 0)]],
  source = "Reinhard et al. 2002",
}
function methods.exposure(x, options)
  images.open(x, "exposure")
  options = form.options(1, "exposure", exposure_options, options)
  local layer = images.layer("exposure", x, options.layer)
  local stops, black, white = check.result("exposure", core.image_expose(x, layer, options.stops))
  if not stops then return nil, black, white end
  return stops, { black = black, white = white }
end

describe "image:save" {
  shelf = "everyday",
  about = "Writes the image; the ending chooses the format. An existing file is replaced whole or not at all.",
  arguments = {
    { "path", "string", ".exr (all layers, metadata), .png (one layer through exposure and tone curve), .hdr, .pfm" },
    { "options?", "table", "" },
  },
  options = save_options,
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on a bad option or ending; nil, message, code where the file cannot be written",
  example = [[
local picture = ylm.image { size = { 4, 2 } }
local name = os.tmpname() .. ".png"
assert(picture:save(name, { exposure = 1, tone = "aces" }))
os.remove(name)]],
}
function methods.save(x, path, options)
  images.open(x, "save")
  check_path(1, "save", path)
  options = form.options(2, "save", save_options, options)
  if options.layer then images.layer("save", x, options.layer) end
  local lib, message, code = codec()
  if not lib then return nil, message, code end
  local stops = options.exposure
  if stops == "auto" then stops = methods.exposure(x, { layer = options.layer }) end
  return check.result("save", lib.image_write(x, path, options.layer, options.bits or 0, options.tone, stops))
end

describe "image:close" {
  about = "Frees the memory now rather than at the next collection (arrays over layers keep theirs).",
  arguments = {},
  returns = {},
  errors = "raises on what is not an image",
  example = "ylm.image { size = { 4, 2 } }:close()",
}
function methods.close(x)
  if core.type(x) ~= "ylm.image" then images.open(x, "close") end
  if memory.pcall(core.image_info, x) then core.image_close(x) end
end

--- An image from a file; raw leaves PNG numbers as they stand. Used by ylm.load.
function image.read(path, raw)
  local lib, message, code = codec()
  if not lib then return nil, message, code end
  return lib.image_read(path, raw)
end

describe "colour" {
  about = "A colour map's colour.",
  arguments = {
    { "map", "string", "'viridis', 'magma', 'coolwarm' (diverging), 'grey'" },
    { "t", "number", "0 to 1; beyond, the ends" },
  },
  returns = {
    { "r", "number", "0 to 1, sRGB-encoded" }, { "g", "number", "" }, { "b", "number", "" },
  },
  errors = "raises on another map's name",
  example = [[
local r, g, b = ylm.colour("grey", 0.5)
assert(r == 0.5 and g == 0.5 and b == 0.5)]],
}
function image.colour(map, t)
  local good, wanted = form.types.choice(map, { of = core.choices "colourmap" })
  if not good then return check.bad(1, "colour", "%s expected, got %s", wanted, check.describe(map)) end
  if not check.is_number(t) then return check.bad(2, "colour", "a number expected, got %s", check.describe(t)) end
  return core.colourmap_at(map, t)
end

require "ylm.image.compare" -- methods, like those below
require "ylm.image.draw"
require "ylm.image.sphere"

memory.publish(methods)

image.codec, image.check_mask = codec, images.mask

return image
