--- A call that raises, and the pattern that its message matches.

local assert = require "luassert"

return function(pattern, f)
  local ok, message = pcall(f)
  assert.is_false(ok)
  assert.matches(pattern, message)
end
