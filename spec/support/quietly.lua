--- The results of f(), without its warnings.

local ylm = require "ylm"

return function(f)
  local before = ylm.on_warning(false)
  local results = { f() }
  ylm.on_warning(before)
  return results[1], results[2], results[3]
end
