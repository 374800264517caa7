--- Two images: their metrics and their difference.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image.check"
local progress = require "ylm.progress"
local show = require "ylm.show"

local methods = core.metatable "ylm.image"

local layer_option = { "layer", "string", optional = true, about = "which layer; default the first" }

--- The start of a method that compares an image with a reference: its options, and the layer or nil.
local function compared(name, x, reference, options, given)
  images.open(x, name)
  images.other(1, name, reference)
  local o = form.options(2, name, options, given)
  return o, o.layer and images.layer(name, x, o.layer)
end

local PIXELS = 67.02 -- per degree, as the papers of flip have it

--- The flip of two images by checked options: map, report; nil, message, code.
local function flip(name, x, reference, o)
  return check.result(name, core.image_flip(x, reference, { layer = o.layer, mask = o.mask, hdr = o.range == "hdr",
    pixels_per_degree = o.pixels_per_degree, start = o.start, stop = o.stop, threads = o.threads,
    progress = progress.of(o.progress) }))
end

local compare_options = {
  layer_option,
  { "mask", "any", optional = true, about = "array [h][w] or image of one channel; only pixels that are not 0 count" },
  { "peak", "number", above = 0, optional = true, about = "what psnr refers to; default the largest reference value" },
  { "floor", "number", above = 0, optional = true,
    about = "least divisor of mape, of the reference's unit; default peak / 1000" },
  { "epsilon", "number", above = 0, default = 0.01, about = "of relmse, of the reference's unit squared" },
  { "flip", "choice", of = { "hdr", "ldr" }, optional = true, about = "also flip, the mean of image:flip with this range" },
  { "variance", "boolean", default = false,
    about = "also z2 and z2_block, from the layers variance of both images; one that has none is taken as exact" },
  images.threads,
  images.progress,
}

describe "image:compare" {
  about = "How far the image is from a reference, over all channels of a layer. mse and rmse; psnr in dB of peak;"
    .. " mae and max, the mean and largest absolute difference; mape in percent of the reference, where that is"
    .. " above floor; relmse, the mean of (a - b)^2 / (b^2 + epsilon);"
    .. " ssim, the mean structural similarity (Gaussian window, sigma 1.5, dynamic range = peak);"
    .. " and pixels, the number of pixels that counted. With variance = true z2, the sum of squared differences over the sum"
    .. " of both variances, whose expectation is 1 where two noisy images agree; z2_block, the largest such ratio over blocks"
    .. " of 16 x 9 pixels, and block, the left and top pixel of that one.",
  arguments = { { "reference", "image", "the truth" }, { "options?", "table", "" } },
  options = compare_options,
  returns = { { "metrics", "table", "{ mse, rmse, psnr, peak, mae, mape, floor, relmse, epsilon, ssim, max, pixels, flip, z2, "
    .. "z2_block, block }" } },
  errors = "raises where sizes or channels differ, the mask is empty, or a pixel that counts is not finite; nil, message, "
    .. "code where memory runs out or progress cancels",
  example = [[
local a, b = ylm.image { size = { 8, 8 } }, ylm.image { size = { 8, 8 } }
b:fill(1, 1, 8, 8, 1)
local m = a:compare(b)
assert(m.mse == 1 and m.psnr == 0 and m.peak == 1)]],
  source = "Wang, Bovik, Sheikh, Simoncelli 2004 (ssim); Rousselle, Knaus, Zwicker 2011 (relmse)",
}
function methods.compare(x, reference, options)
  local o, layer = compared("compare", x, reference, compare_options, options)
  local mask = images.mask("compare", x, o.mask)
  local metrics, message, code = check.result("compare", core.image_compare(x, reference, { layer = layer, mask = mask,
    peak = o.peak, floor = o.floor, epsilon = o.epsilon, threads = o.threads, progress = progress.of(o.progress) }))
  if not metrics then return nil, message, code end
  if o.flip then
    local map, report
    map, report, code = flip("compare", x, reference, { layer = layer, mask = mask, range = o.flip, pixels_per_degree = PIXELS,
      threads = o.threads, progress = o.progress })
    if not map then return nil, report, code end
    map:close()
    metrics.flip = report.mean
  end
  if o.variance then
    local z2, block, left, top = check.result("compare", core.image_agree(x, reference, layer, mask))
    metrics.z2, metrics.z2_block, metrics.block = z2, block, { left, top }
  end
  return show.report(metrics)
end

local flip_options = {
  layer_option,
  { "range", "choice", of = { "hdr", "ldr" }, default = "hdr",
    about = "hdr: pictures of radiance, under several exposures; ldr: as they are shown, linear, cut to 0 .. 1" },
  { "pixels_per_degree", "number", above = 0, max = 3700, default = PIXELS,
    about = "of a viewer's sight; default: 0.7 m before a screen 0.7 m wide with 3840 pixels" },
  { "start", "number", min = -100, max = 100, optional = true, unit = "stops",
    about = "first exposure of hdr; default: where the reference's brightest pixel becomes 0.85" },
  { "stop", "number", min = -100, max = 100, optional = true, unit = "stops",
    about = "last exposure of hdr; default: where the reference's median luminance becomes 0.85" },
  { "mask", "any", optional = true, about = "array [h][w] or image of one channel; only pixels that are not 0 count" },
  images.threads,
  images.progress,
}

describe "image:flip" {
  about = "FLIP: how different the image and a reference look to an eye before a screen that alternates between them. Of "
    .. "radiance (hdr), the largest difference under exposures from start to stop, at least two, one a stop, with the ACES "
    .. "curve; negative numbers count as 0. map:colours { map = 'magma', range = {0, 1} } is the papers' picture of it.",
  arguments = { { "reference", "image", "the truth" }, { "options?", "table", "" } },
  options = flip_options,
  returns = {
    { "map", "image", "one layer 'flip', 0 (alike) to 1; 0 where the mask is" },
    { "report", "table", "{ mean, max, start, stop, exposures }" },
  },
  errors = "raises where sizes or channels differ, the mask is empty, or a pixel that counts is not finite; nil, message, "
    .. "code where memory runs out or progress cancels",
  example = [[
local a, b = ylm.image { size = { 8, 8 } }, ylm.image { size = { 8, 8 } }
b:fill(1, 1, 8, 8, 1)
local map, report = a:flip(b, { range = "ldr" })
assert(report.mean > 0.9 and map:layer():get(1, 1, 1) > 0.9 and b:flip(b).size[1] == 8)]],
  source = "Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020; Andersson, Nilsson, Shirley, "
    .. "Akenine-Moller 2021 (hdr)",
}
function methods.flip(x, reference, options)
  local o, layer = compared("flip", x, reference, flip_options, options)
  o.layer, o.mask = layer, images.mask("flip", x, o.mask)
  return flip("flip", x, reference, o)
end

local difference_options = {
  layer_option,
  { "scale", "number", default = 1, about = "differences are multiplied by this" },
  { "kind", "choice", of = core.choices "difference", default = "absolute",
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
  local o, layer = compared("difference", x, reference, difference_options, options)
  return check.result("difference", core.image_difference(x, reference, layer, o.kind, o.scale, o.floor))
end
