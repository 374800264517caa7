--- Images: named float layers of one size, with metadata, metrics and files.

require "ylm.array" -- its methods
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.reference".describe
local form = require "ylm.form"

local image = {}
local methods = core.metatable "ylm.image"

--- The image before the colon of method `name`, checked; returns what core.image_info does.
local function open(x, name)
  if core.type(x) ~= "ylm.image" then
    return check.fail("%s: an image expected before the colon, got %s", name, check.describe(x))
  end
  local is_open, w, h, names, channels = pcall(core.image_info, x)
  if not is_open then return check.fail("%s: the image has been closed", name) end
  return w, h, names, channels
end

--- The library of file formats, or nil, message, "EMISSING": the core works without it.
local function codec()
  local ok, scene = pcall(require, "ylm.c.scene")
  if ok then return scene end
  return nil, "image files need libylm_scene with OpenEXR and libpng (Debian: libopenexr-dev libpng-dev "
    .. "libembree-dev, then make): " .. tostring(scene):match("^[^\n]*"), "EMISSING"
end

local function check_path(n, name, path)
  if type(path) == "string" and #path > 0 and not path:find("%z") then return path end
  return check.bad(n, name, "a file name expected, got %s", check.describe(path))
end

image.image = form.define("image", {
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
      if size[i] < 1 or size[i] > 65536 then
        return fail(("image size %.0f x %.0f: sides must be 1 .. 65536"):format(size[1], size[2]))
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

require "ylm.reference".object "image" {
  about = "Named layers of linear 32-bit floats; the first, \"radiance\", is the picture.",
  fields = {
    { "size", "integer[]", "{ width, height }" },
    { "metadata", "table", "text by name: image.metadata.author = \"me\"" },
  },
}

-- Metadata --------------------------------------------------------------------------

local owner_of = setmetatable({}, { __mode = "k" })

local metadata = {}

metadata.__index = function(proxy, key)
  if type(key) ~= "string" then return nil end
  return (core.image_get_text(owner_of[proxy], key))
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
  check.result("metadata", core.image_set_text(owner_of[proxy], key, value))
end

--- All entries as a plain table.
metadata.__call = function(proxy)
  local all = {}
  for _, key in ipairs(core.image_texts(owner_of[proxy])) do
    all[key] = core.image_get_text(owner_of[proxy], key)
  end
  return all
end

-- Methods ------------------------------------------------------------------------------

methods.__index = function(x, key)
  if key == "size" then
    local w, h = open(x, "size")
    return { w, h }
  elseif key == "metadata" then
    open(x, "metadata")
    local proxy = setmetatable({}, metadata)
    owner_of[proxy] = x
    return proxy
  end
  return rawget(methods, key)
end

methods.__newindex = function(_, key)
  return check.fail("image: cannot set %s (metadata: image.metadata.name = value)", check.describe(key))
end

methods.__tostring = function(x)
  local is_open, w, h, names, channels = pcall(core.image_info, x)
  if not is_open then return "ylm.image (closed)" end
  for i = 1, #names do names[i] = names[i] .. ":" .. channels[i] end
  return ("ylm.image %dx%d %s"):format(w, h, table.concat(names, " "))
end

describe "image:layers" {
  about = "The names of the layers, in order, and how many channels each has.",
  arguments = {},
  returns = { { "names", "table", "list of strings" }, { "channels", "table", "number of channels by name" } },
  errors = "raises on what is not an image",
  example = [[
local names, channels = ylm.image { size = { 4, 2 } }:layers()
assert(names[1] == "radiance" and channels.radiance == 3)]],
}
function methods.layers(x)
  local _, _, names, counts = open(x, "layers")
  local channels = {}
  for i = 1, #names do channels[names[i]] = counts[i] end
  return names, channels
end

--- Raises unless the image has layer `name` (nil: the first).
local function check_layer(fn, x, name)
  local _, _, names = open(x, fn)
  if name == nil then return names[1] end
  for i = 1, #names do if names[i] == name then return name end end
  local guess = type(name) == "string" and check.guess(name, names)
  return check.fail("%s: no layer %s%s", fn, check.describe(name), guess and (" (did you mean '%s'?)"):format(guess)
    or ("; layers are " .. table.concat(names, ", ")))
end

describe "image:layer" {
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
  check_layer("layer", x, name)
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
  open(x, "add")
  if type(name) ~= "string" then return check.bad(1, "add", "a name expected, got %s", check.describe(name)) end
  check.integer(2, "add", "channels", channels, 1, 4)
  local ok, message, code = check.result("add", core.image_add(x, name, channels))
  if not ok then return nil, message, code end
  return (core.image_layer(x, name))
end

local save_options = {
  { "layer", "string", optional = true, about = "which layer (.png, .hdr, .pfm); default the first" },
  { "bits", "choice", of = { 8, 16, 32 }, optional = true,
      about = ".png 8 (default) or 16; .exr 16 (half) or 32 (default)" },
  { "exposure", "number", min = -60, max = 60, default = 0, unit = "stops",
      about = ".png: pixels are multiplied by 2^exposure" },
  { "tone", "choice", of = core.image_tones(), default = "srgb",
      about = ".png: tone curve; hable and aces are filmic" },
}

describe "image:save" {
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
  open(x, "save")
  check_path(1, "save", path)
  options = form.options(2, "save", save_options, options)
  if options.layer then check_layer("save", x, options.layer) end
  local lib, message, code = codec()
  if not lib then return nil, message, code end
  return check.result("save", lib.image_write(x, path,
    options.layer, options.bits or 0, options.tone, options.exposure))
end

describe "image:close" {
  about = "Frees the memory now rather than at the next collection (arrays over layers keep theirs).",
  arguments = {},
  returns = {},
  errors = "raises on what is not an image",
  example = "ylm.image { size = { 4, 2 } }:close()",
}
function methods.close(x)
  if core.type(x) ~= "ylm.image" then open(x, "close") end
  if pcall(core.image_info, x) then core.image_close(x) end
end

--- An image from a file; raw leaves PNG numbers as they stand. Used by ylm.load.
function image.read(path, raw)
  local lib, message, code = codec()
  if not lib then return nil, message, code end
  return lib.image_read(path, raw)
end

-- Metrics ----------------------------------------------------------------------------------

--- Argument `n` of method `fn` as another image.
local function check_other(n, fn, other)
  if core.type(other) == "ylm.image" then
    if pcall(core.image_info, other) then return other end
    return check.bad(n, fn, "the image has been closed")
  end
  return check.bad(n, fn, "an image expected, got %s", check.describe(other))
end

--- A mask for the pixels of image x, as a float array: an array [h][w] or an image of one channel.
local function check_mask(fn, x, mask)
  if mask == nil then return nil end
  local w, h = core.image_info(x)
  if core.type(mask) == "ylm.image" then mask = core.image_layer(check_other(0, fn, mask)) end
  if core.type(mask) == "ylm.array" then
    local shape, dtype, _, is_open = core.array_info(mask)
    if is_open and shape[1] == h and shape[2] == w and (#shape == 2 or (#shape == 3 and shape[3] == 1)) then
      return dtype == "float" and mask or core.array_convert(mask, "float")
    end
  end
  return check.fail("%s: mask must be an array of %dx%d or an image of one channel and that size, got %s",
    fn, h, w, check.describe(mask))
end

local threads_field = { "threads", "integer", min = 0, max = 1024, default = 0, about = "0: YLM_THREADS or all cores" }

local compare_options = {
  { "layer", "string", optional = true, about = "which layer; default the first" },
  { "mask", "any", optional = true, about = "array [h][w] or image of one channel; only pixels that are not 0 count" },
  { "peak", "number", above = 0, optional = true, about = "what psnr refers to; default the largest reference value" },
  { "floor", "number", above = 0, optional = true,
    about = "least divisor of mape, of the reference's unit; default peak / 1000" },
  threads_field,
}

describe "image:compare" {
  about = "How far the image is from a reference, over all channels of a layer. mse and rmse; psnr in dB of peak;"
    .. " mae and max, the mean and largest absolute difference; mape in percent of the reference, where that is"
    .. " above floor; ssim, the mean structural similarity (Gaussian window, sigma 1.5, dynamic range = peak);"
    .. " and pixels, the number of pixels that counted.",
  arguments = { { "reference", "image", "the truth" }, { "options?", "table", "" } },
  options = compare_options,
  returns = { { "metrics", "table", "{ mse, rmse, psnr, peak, mae, mape, floor, ssim, max, pixels }" } },
  errors = "raises where sizes or channels differ, the mask is empty, or a pixel that counts is not finite",
  example = [[
local a, b = ylm.image { size = { 8, 8 } }, ylm.image { size = { 8, 8 } }
b:fill(1, 1, 8, 8, 1)
local m = a:compare(b)
assert(m.mse == 1 and m.psnr == 0 and m.peak == 1)]],
  source = "Wang, Bovik, Sheikh, Simoncelli 2004 (ssim)",
}
function methods.compare(x, reference, options)
  open(x, "compare")
  check_other(1, "compare", reference)
  options = form.options(2, "compare", compare_options, options)
  local layer = options.layer and check_layer("compare", x, options.layer)
  return check.result("compare", core.image_compare(x, reference, layer, check_mask("compare", x, options.mask),
    options.peak or 0, options.floor or 0, options.threads))
end

local difference_options = {
  { "layer", "string", optional = true, about = "which layer; default the first" },
  { "scale", "number", default = 1, about = "differences are multiplied by this" },
  { "kind", "choice", of = { "absolute", "signed", "relative" }, default = "absolute",
    about = "|a - b|, a - b, or |a - b| / max(|b|, floor)" },
  { "floor", "number", above = 0, default = 1e-3, about = "least divisor of relative differences" },
}

describe "image:difference" {
  about = "The difference from a reference as an image of one layer.",
  arguments = { { "reference", "image", "the truth" }, { "options?", "table", "" } },
  options = difference_options,
  returns = { { "difference", "image", "with the layer's name" } },
  errors = "raises where sizes or channels differ",
  example = [[
local a, b = ylm.image { size = { 8, 8 } }, ylm.image { size = { 8, 8 } }
b:fill(1, 1, 8, 8, 0.25)
assert(a:difference(b, { scale = 100 }):layer():get(1, 1, 1) == 25)]],
}
function methods.difference(x, reference, options)
  open(x, "difference")
  check_other(1, "difference", reference)
  options = form.options(2, "difference", difference_options, options)
  local layer = options.layer and check_layer("difference", x, options.layer)
  return check.result("difference",
    core.image_difference(x, reference, layer, options.kind, options.scale, options.floor))
end

-- Pictures from pictures ----------------------------------------------------------------------

local function check_place(fn, x, y)
  check.integer(1, fn, "x", x, -1000000, 1000000)
  check.integer(2, fn, "y", y, -1000000, 1000000)
end

describe "image:crop" {
  about = "A rectangle of the image, with every layer and the metadata.",
  arguments = {
    { "x", "integer", "left column, from 1" }, { "y", "integer", "top row, from 1" },
    { "width", "integer", "" }, { "height", "integer", "" },
  },
  returns = { { "part", "image", "" } },
  errors = "raises where the rectangle leaves the image",
  example = "assert(ylm.image { size = { 8, 4 } }:crop(5, 1, 4, 4).size[1] == 4)",
}
function methods.crop(x, left, top, width, height)
  open(x, "crop")
  check_place("crop", left, top)
  check.integer(3, "crop", "width", width, 1)
  check.integer(4, "crop", "height", height, 1)
  return check.result("crop", core.image_crop(x, left - 1, top - 1, width, height))
end

local resize_options = {
  { "filter", "choice", of = { "box", "linear", "lanczos" }, default = "box",
    about = "shrinking: all average; enlarging: box repeats pixels" },
  threads_field,
}

describe "image:resize" {
  about = "The image at another size, with every layer and the metadata.",
  arguments = { { "size", "table", "{ width, height }" }, { "options?", "table", "" } },
  options = resize_options,
  returns = { { "resized", "image", "" } },
  errors = "raises on a bad size",
  example = "assert(ylm.image { size = { 8, 4 } }:resize({ 4, 2 }).size[1] == 4)",
}
function methods.resize(x, size, options)
  open(x, "resize")
  if type(size) ~= "table" or core.type(size) or not check.is_integer(size[1]) or not check.is_integer(size[2]) then
    return check.bad(1, "resize", "a size { width, height } expected, got %s", check.describe(size))
  end
  options = form.options(2, "resize", resize_options, options)
  return check.result("resize", core.image_resize(x, size[1], size[2], options.filter, options.threads))
end

local paste_options = {
  { "layer", "string", optional = true, about = "of this image; default the first" },
  { "from", "string", optional = true, about = "of the other image; default the first" },
  { "mask", "any", optional = true,
    about = "array [h][w] or image of the other's size: 0 keeps, 1 replaces, between mixes" },
}

describe "image:paste" {
  about = "Copies another image's layer into this one; what leaves the image is cut off.",
  arguments = {
    { "other", "image", "" }, { "x", "integer", "where its left column goes, from 1" },
    { "y", "integer", "where its top row goes, from 1" }, { "options?", "table", "" },
  },
  options = paste_options,
  returns = { { "self", "image", "" } },
  errors = "raises where channels differ (one may go to many)",
  example = [[
local picture, part = ylm.image { size = { 8, 8 } }, ylm.image { size = { 2, 2 } }
part:fill(1, 1, 2, 2, { 1, 0, 0 })
assert(picture:paste(part, 7, 7):layer():get(8, 8, 1) == 1)]],
}
function methods.paste(x, other, left, top, options)
  open(x, "paste")
  check_other(1, "paste", other)
  check.integer(2, "paste", "x", left, -1000000, 1000000)
  check.integer(3, "paste", "y", top, -1000000, 1000000)
  options = form.options(4, "paste", paste_options, options)
  local to = options.layer and check_layer("paste", x, options.layer)
  local from = options.from and check_layer("paste", other, options.from)
  local mask = check_mask("paste", other, options.mask)
  local ok, message, code = check.result("paste", core.image_paste(x, to, left - 1, top - 1, other, from, mask))
  if not ok then return nil, message, code end
  return x
end

--- Argument `n` as numbers for each channel of a layer: a number, or a list.
local function check_colour(n, fn, x, layer, colour)
  local _, channels = methods.layers(x)
  local count = channels[check_layer(fn, x, layer)]
  if check.is_number(colour) then return { colour, colour, colour, colour } end
  local good = type(colour) == "table" and #colour == count
  for i = 1, good and count or 0 do good = good and check.is_number(colour[i]) end
  if good then return colour end
  return check.bad(n, fn, "a colour expected: a number, or %d of them, finite; got %s", count, check.describe(colour))
end

local layer_options = { { "layer", "string", optional = true, about = "default the first" } }

describe "image:fill" {
  about = "Fills a rectangle (cut to the image) of a layer.",
  arguments = {
    { "x", "integer", "left column, from 1" }, { "y", "integer", "top row, from 1" },
    { "width", "integer", "" }, { "height", "integer", "" },
    { "colour", "number|table", "one number, or one for each channel" }, { "options?", "table", "" },
  },
  options = layer_options,
  returns = { { "self", "image", "" } },
  errors = "raises on a colour of another number of channels",
  example = "assert(ylm.image { size = { 8, 4 } }:fill(1, 1, 8, 4, { 1, 0.5, 0 }):layer():get(4, 8, 2) == 0.5)",
}
function methods.fill(x, left, top, width, height, colour, options)
  open(x, "fill")
  check_place("fill", left, top)
  check.integer(3, "fill", "width", width, 0)
  check.integer(4, "fill", "height", height, 0)
  options = form.options(6, "fill", layer_options, options)
  colour = check_colour(5, "fill", x, options.layer, colour)
  check.result("fill", core.image_fill(x, options.layer, left - 1, top - 1, width, height, colour))
  return x
end

local text_options = {
  { "scale", "integer", min = 1, max = 100, default = 1, about = "a character cell is 6 x 9 pixels times this" },
  { "colour", "any", default = 1, about = "a number, or one for each channel" },
  { "layer", "string", optional = true, about = "default the first" },
}

describe "image:text" {
  about = "Writes ASCII text in a small built-in font, for captions where VTK is not wanted.",
  arguments = {
    { "x", "integer", "left column, from 1" }, { "y", "integer", "top row, from 1" },
    { "text", "string", "lines end with '\\n'" }, { "options?", "table", "" },
  },
  options = text_options,
  returns = { { "width", "integer", "pixels" }, { "height", "integer", "pixels" } },
  errors = "raises on a bad scale or colour",
  example = [[assert(ylm.image { size = { 64, 16 } }:text(2, 2, "32 dB") == 30)]],
}
function methods.text(x, left, top, text, options)
  open(x, "text")
  check_place("text", left, top)
  if type(text) ~= "string" then return check.bad(3, "text", "a string expected, got %s", check.describe(text)) end
  options = form.options(4, "text", text_options, options)
  local colour = check_colour(4, "text", x, options.layer, options.colour)
  return check.result("text", core.image_text(x, options.layer, left - 1, top - 1, options.scale, text, colour))
end

local function types_range(v)
  if type(v) == "table" and #v == 2 and check.is_number(v[1]) and check.is_number(v[2]) and v[1] < v[2] then
    return v
  end
  return nil, "two numbers { lo, hi }, lo < hi"
end
form.types.rising = types_range

local colours_options = {
  { "layer", "string", optional = true, about = "which layer; default the first" },
  { "map", "choice", of = core.colourmaps(), default = "viridis", about = "coolwarm diverges" },
  { "range", "rising", about = "the numbers at both ends of the map" },
  { "log", "boolean", default = false, about = "a logarithmic scale; the range is then above 0" },
}

describe "image:colours" {
  about = "A layer's numbers as colours, in linear rgb: saved with the tone curve srgb they are the map's own."
    .. " Layers of 3 or 4 channels count by their luminance.",
  arguments = { { "options", "table", "" } },
  options = colours_options,
  returns = { { "picture", "image", "one layer, radiance" } },
  errors = "raises on a range that does not rise",
  example = [[
local depth = ylm.image { size = { 8, 8 }, layers = { { "depth", 1 } } }
assert(depth:colours { range = { 0, 10 } }:layers()[1] == "radiance")]],
}
function methods.colours(x, options)
  open(x, "colours")
  options = form.options(1, "colours", colours_options, options)
  local layer = options.layer and check_layer("colours", x, options.layer)
  return check.result("colours",
    core.image_colours(x, layer, options.map, options.range[1], options.range[2], options.log))
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
  local good, wanted = form.types.choice(map, { of = core.colourmaps() })
  if not good then return check.bad(1, "colour", "%s expected, got %s", wanted, check.describe(map)) end
  if not check.is_number(t) then return check.bad(2, "colour", "a number expected, got %s", check.describe(t)) end
  return core.colourmap_at(map, t)
end

-- Images of the sphere ------------------------------------------------------------------------

local mapping_options = {
  { "mapping", "choice", of = { "latlong", "angular", "cube" }, default = "latlong",
    about = "cube: six faces in a column, +x -x +y -y +z -z" },
  { "up", "choice", of = { "z", "y" }, default = "z",
    about = "the pole; the middle of the image is +x, or -z where y is up" },
}

describe "image:directions" {
  about = "The direction and the solid angle of every pixel of an image of the whole sphere, row by row.",
  arguments = { { "options?", "table", "" } },
  options = mapping_options,
  returns = {
    { "directions", "array", "double [height*width][3], unit; zeros outside of an angular map's disc" },
    { "solid_angles", "array", "double [height*width], sr; their sum is 4 pi" },
  },
  errors = "raises on a cube map whose height is not six times its width",
  example = [[
local d = ylm.image { size = { 2, 1 } }:directions()
assert(math.abs(d:get(1, 2) - 1) < 1e-15)           -- the left half of the equator is +y]],
}
function methods.directions(x, options)
  local w, h = open(x, "directions")
  options = form.options(1, "directions", mapping_options, options)
  local d, angles, code = core.mapping_pixels(options.mapping, options.up, w, h)
  if not d and code == "ESHAPE" then
    return check.fail("directions: a cube map is six times as high as wide, not %dx%d", w, h)
  end
  return check.result("directions", d, angles, code)
end

describe "image:positions" {
  about = "Where directions fall on an image of the whole sphere: the inverse of image:directions.",
  arguments = { { "directions", "array|table", "[n][3], any length but 0" }, { "options?", "table", "" } },
  options = mapping_options,
  returns = { { "positions", "array",
    "double [n][2]: x from the left, y from the top; a pixel's middle is at k - 0.5" } },
  errors = "raises on a zero direction, naming the row",
  example = [[
local p = ylm.image { size = { 8, 4 } }:positions { { 1, 0, 0 } }
assert(p:get(1, 1) == 4 and p:get(1, 2) == 2)]],
}
function methods.positions(x, directions, options)
  local w, h = open(x, "positions")
  local d = require("ylm.array").points(1, "positions", directions, "double")
  options = form.options(2, "positions", mapping_options, options)
  return check.result("positions", core.mapping_positions(options.mapping, options.up, w, h, d))
end

image.codec, image.check_mask = codec, check_mask

return image
