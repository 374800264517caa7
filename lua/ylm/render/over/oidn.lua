--- A finished picture without its noise by Intel's Open Image Denoise, which is opened at run time: denoise = "oidn".

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"

local oidn = { name = "oidn", called = 'denoise = "oidn"', options = {} }

function oidn.wants(o) return o.denoise == "oidn" end

function oidn.prepare() return true end

--- Filters the radiance of an image; what it was becomes the layer raw. True, or nil, message, code.
function oidn.report(p, _, report, image)
  local start, _, known = core.seconds(), image:layers()
  local radiance = image:layer "radiance"
  local filtered = assert(array.zeros(radiance.shape, "float"))
  local ok, message, code = check.result("render", p.lib.shade_oidn(radiance, known.albedo and image:layer "albedo" or nil,
    known.normal and image:layer "normal" or nil, filtered))
  if not ok then return nil, message, code end
  image:add("raw", 3)
  p.lib.path_copy(radiance, image:layer "raw")
  p.lib.path_copy(filtered, radiance)
  image.metadata.denoise = "oidn"
  report.seconds.denoise = core.seconds() - start
  report.seconds.total = report.seconds.total + report.seconds.denoise
  return true
end

return oidn
