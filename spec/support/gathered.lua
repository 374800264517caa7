-- The layer radiance of pictures of virtual lights by lights, and its report.

local with = require "spec.support.with"
local ways = require "spec.support.ways"

return function(view, lights, options)
  local image, report = view:render(ways.virtual(with({ lights = lights, layers = false }, options or {})))
  return assert(image, report):layer "radiance", report
end
