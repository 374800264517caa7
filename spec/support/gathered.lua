-- The layer radiance of view:gather by lights, and its report.

local with = require "spec.support.with"

return function(view, lights, options)
  local image, report = view:gather(with({ lights = lights, layers = false }, options or {}))
  return assert(image, report):layer "radiance", report
end
