--- ylm compare a.exr b.exr

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local order = { "mse", "rmse", "psnr", "peak", "mae", "mape", "relmse", "ssim", "flip", "range", "max", "z2", "z2_block" }

--- How flip is to look at the images: as they are shown where all are .png, else as radiance.
local function range_of(given)
  local range = given.flip
  if range == nil then
    for i = 1, 2 do if not given[i]:lower():find "%.png$" then return "hdr" end end
    return "ldr"
  end
  if range ~= "hdr" and range ~= "ldr" and range ~= "no" then
    status.stop(status.usage, "compare: --flip is hdr, ldr or no, got %s", range)
  end
  return range
end

return {
  summary = "compares two images: mse, psnr, mape, ssim, flip ...; --difference writes a picture of it",
  usage = "IMAGE IMAGE [--max-mse N] [--difference FILE]",
  least = 2,
  options = {
    { "difference", "-o", "FILE", "writes the difference image" },
    { "scale", nil, "N", "of the difference image, default 1" },
    { "flip", nil, "RANGE", "how flip looks at images: hdr (several exposures), ldr (as shown; default of two .png), no" },
    { "flip-map", nil, "FILE", "writes flip as an image, magma from 0 to 1" },
    { "variance", nil, nil, "also z2: 1 where two noisy images agree, by their layers variance" },
    { "max-mse", nil, "N", "exit status 4 where the mse is larger" },
    { "min-psnr", nil, "N", "exit status 4 where the psnr is smaller" },
  },
  run = function(given)
    local ylm = require "ylm"
    local range, images = range_of(given), {}
    if given.scale and not given.difference then
      status.stop(status.usage, "compare: --scale is of the difference image: --difference FILE is missing")
    end
    if given["flip-map"] and range == "no" then
      status.stop(status.usage, "compare: --flip-map needs flip, and --flip no leaves it out")
    end
    for _, name in ipairs { "difference", "flip-map" } do
      if given[name] then status.need_output("compare", given[name], "exr", "png", "hdr", "pfm") end
    end
    for i = 1, 2 do
      images[i] = status.need_kind("ylm.image", "an image", given[i], ylm.load(given[i]))
    end
    local metrics, map = status.need(images[1]:compare(images[2], { variance = given.variance })), nil
    if range ~= "no" then
      local look
      map, look = status.need(images[1]:flip(images[2], { range = range }))
      metrics.flip, metrics.range = look.mean, range
    end
    report.print(given, metrics, not given.json and order or nil)
    if given.difference then
      local difference = status.need(images[1]:difference(images[2], { scale = given.scale }))
      status.need(difference:save(given.difference))
    end
    if given["flip-map"] then
      status.need(map:colours({ map = "magma", range = { 0, 1 } }):save(given["flip-map"]))
    end
    local within = (not given["max-mse"] or metrics.mse <= given["max-mse"])
      and (not given["min-psnr"] or metrics.psnr >= given["min-psnr"])
    return within and status.good or status.beyond -- a mse that is no number is beyond every bound
  end,
}
