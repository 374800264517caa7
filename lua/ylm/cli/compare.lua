--- ylm compare a.exr b.exr

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local order = { "mse", "rmse", "psnr", "peak", "mae", "mape", "ssim", "max", "z2", "z2_block" }

return {
  summary = "compares two images: mse, psnr, mape, ssim ...; --difference writes a picture of it",
  usage = "IMAGE IMAGE [--max-mse N] [--difference FILE]",
  least = 2,
  options = {
    { "difference", "-o", "FILE", "writes the difference image" },
    { "scale", nil, "N", "of the difference image, default 1" },
    { "variance", nil, nil, "also z2: 1 where two noisy images agree, by their layers variance" },
    { "max-mse", nil, "N", "exit status 4 where the mse is larger" },
    { "min-psnr", nil, "N", "exit status 4 where the psnr is smaller" },
  },
  run = function(given)
    local ylm = require "ylm"
    if given.scale and not given.difference then
      status.stop(status.usage, "compare: --scale is of the difference image: --difference FILE is missing")
    end
    if given.difference then
      status.need_output("compare", given.difference, "exr", "png", "hdr", "pfm")
    end
    local images = {}
    for i = 1, 2 do
      images[i] = status.need_kind("ylm.image", "an image", given[i], ylm.load(given[i]))
    end
    local metrics = status.need(images[1]:compare(images[2], { variance = given.variance }))
    report.print(given, metrics, not given.json and order or nil)
    if given.difference then
      local difference = status.need(images[1]:difference(images[2], { scale = given.scale }))
      status.need(difference:save(given.difference))
    end
    local within = (not given["max-mse"] or metrics.mse <= given["max-mse"])
      and (not given["min-psnr"] or metrics.psnr >= given["min-psnr"])
    return within and status.good or status.beyond -- a mse that is no number is beyond every bound
  end,
}
