--- Pictures from pictures: crops, other sizes, one in another, colours, letters.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image.check"
local progress = require "ylm.progress"

local methods = core.metatable "ylm.image"

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
  images.open(x, "crop")
  check_place("crop", left, top)
  check.integer(3, "crop", "width", width, 1)
  check.integer(4, "crop", "height", height, 1)
  return check.result("crop", core.image_crop(x, left - 1, top - 1, width, height))
end

local resize_options = {
  { "filter", "choice", of = core.choices "filter", default = "box",
    about = "shrinking: all average; enlarging: box repeats pixels" },
  images.threads,
  images.progress,
}

describe "image:resize" {
  about = "The image at another size, with every layer and the metadata.",
  arguments = { { "size", "table", "{ width, height }" }, { "options?", "table", "" } },
  options = resize_options,
  returns = { { "resized", "image", "" } },
  errors = "raises on a bad size; nil, message, code where memory runs out or progress cancels",
  example = "assert(ylm.image { size = { 8, 4 } }:resize({ 4, 2 }).size[1] == 4)",
}
function methods.resize(x, size, options)
  images.open(x, "resize")
  if type(size) ~= "table" or core.type(size) or not check.is_integer(size[1]) or not check.is_integer(size[2]) then
    return check.bad(1, "resize", "a size { width, height } expected, got %s", check.describe(size))
  end
  options = form.options(2, "resize", resize_options, options)
  return check.result("resize", core.image_resize(x, size[1], size[2], options.filter, options.threads,
    progress.of(options.progress)))
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
  images.open(x, "paste")
  images.other(1, "paste", other)
  check.integer(2, "paste", "x", left, -1000000, 1000000)
  check.integer(3, "paste", "y", top, -1000000, 1000000)
  options = form.options(4, "paste", paste_options, options)
  local to = options.layer and images.layer("paste", x, options.layer)
  local from = options.from and images.layer("paste", other, options.from)
  local mask = images.mask("paste", other, options.mask)
  local ok, message, code = check.result("paste", core.image_paste(x, to, left - 1, top - 1, other, from, mask))
  if not ok then return nil, message, code end
  return x
end

--- Argument `n` as numbers for each channel of a layer: a number, or a list.
local function check_colour(n, fn, x, layer, colour)
  local _, channels = methods.layers(x)
  local count = channels[images.layer(fn, x, layer)]
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
  images.open(x, "fill")
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
  images.open(x, "text")
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
  { "map", "choice", of = core.choices "colourmap", default = "viridis", about = "coolwarm diverges" },
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
  images.open(x, "colours")
  options = form.options(1, "colours", colours_options, options)
  local layer = options.layer and images.layer("colours", x, options.layer)
  return check.result("colours",
    core.image_colours(x, layer, options.map, options.range[1], options.range[2], options.log))
end
