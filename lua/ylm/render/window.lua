--- Windows of harmonics as options of pictures.

local array = require "ylm.array"
local check = require "ylm.check"
local window = require "ylm.sh.window"

local windows = {}

--- The factors by degree of o.window, { name, width } of sh.window, to o.lmax; or nil, where there is none.
function windows.factors(name, o)
  local w = o.window
  if w == nil then return nil end
  if type(w) == "string" then w = { w } end
  if type(w) ~= "table" or type(w[1]) ~= "string" then
    return check.bad(1, name, "virtual: window: { name, width } of sh.window expected, got %s", check.describe(o.window))
  end
  local ones, list = {}, {}
  for k = 1, (o.lmax + 1) ^ 2 do ones[k] = 1 end
  local c = window.window(array.array(ones, "double"), w[1], w[2])
  for l = 0, o.lmax do list[l + 1] = c:get(l * l + l + 1) end
  return list
end

return windows
