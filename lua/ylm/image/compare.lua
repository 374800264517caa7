--- Two images: their metrics and their difference.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image.check"
local progress = require "ylm.progress"

local methods = core.metatable "ylm.image"

local layer_option = { "layer", "string", optional = true, about = "which layer; default the first" }

--- The start of a method that compares an image with a reference: its options, and the layer or nil.
local function compared(name, x, reference, options, given)
  images.open(x, name)
  images.other(1, name, reference)
  local o = form.options(2, name, options, given)
  return o, o.layer and images.layer(name, x, o.layer)
end

local compare_options = {
  layer_option,
  { "mask", "any", optional = true, about = "array [h][w] or image of one channel; only pixels that are not 0 count" },
  { "peak", "number", above = 0, optional = true, about = "what psnr refers to; default the largest reference value" },
  { "floor", "number", above = 0, optional = true,
    about = "least divisor of mape, of the reference's unit; default peak / 1000" },
  { "variance", "boolean", default = false,
    about = "also z2 and z2_block, from the layers variance of both images; one that has none is taken as exact" },
  images.threads,
  images.progress,
}

describe "image:compare" {
  about = "How far the image is from a reference, over all channels of a layer. mse and rmse; psnr in dB of peak;"
    .. " mae and max, the mean and largest absolute difference; mape in percent of the reference, where that is"
    .. " above floor; ssim, the mean structural similarity (Gaussian window, sigma 1.5, dynamic range = peak);"
    .. " and pixels, the number of pixels that counted. With variance = true z2, the sum of squared differences over the sum"
    .. " of both variances, whose expectation is 1 where two noisy images agree; z2_block, the largest such ratio over blocks"
    .. " of 16 x 9 pixels, and block, the left and top pixel of that one.",
  arguments = { { "reference", "image", "the truth" }, { "options?", "table", "" } },
  options = compare_options,
  returns = { { "metrics", "table", "{ mse, rmse, psnr, peak, mae, mape, floor, ssim, max, pixels, z2, z2_block, block }" } },
  errors = "raises where sizes or channels differ, the mask is empty, or a pixel that counts is not finite; nil, message, "
    .. "code where memory runs out or progress cancels",
  example = [[
local a, b = ylm.image { size = { 8, 8 } }, ylm.image { size = { 8, 8 } }
b:fill(1, 1, 8, 8, 1)
local m = a:compare(b)
assert(m.mse == 1 and m.psnr == 0 and m.peak == 1)]],
  source = "Wang, Bovik, Sheikh, Simoncelli 2004 (ssim)",
}
function methods.compare(x, reference, options)
  local o, layer = compared("compare", x, reference, compare_options, options)
  local mask = images.mask("compare", x, o.mask)
  local metrics, message, code = check.result("compare", core.image_compare(x, reference, { layer = layer, mask = mask,
    peak = o.peak, floor = o.floor, threads = o.threads, progress = progress.of(o.progress) }))
  if not metrics then return nil, message, code end
  if o.variance then
    local z2, block, left, top = check.result("compare", core.image_agree(x, reference, layer, mask))
    metrics.z2, metrics.z2_block, metrics.block = z2, block, { left, top }
  end
  return metrics
end

local difference_options = {
  layer_option,
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
  local o, layer = compared("difference", x, reference, difference_options, options)
  return check.result("difference", core.image_difference(x, reference, layer, o.kind, o.scale, o.floor))
end
