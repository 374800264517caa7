--- The option `out` of functions on points: arrays that take the results instead of new ones.

local check = require "ylm.check"
local core = require "ylm.c.core"

local outputs = {}

--- "5x3x25", whether the extents are integers or floats of Lua 5.3 and later.
local function extents(shape)
  local words = {}
  for i, extent in ipairs(shape) do words[i] = ("%d"):format(extent) end
  return table.concat(words, "x")
end
outputs.extents = extents

--- The option `out` (nil, an array, or a list of them) of argument `n` of `name`, as one array or nil for each
-- of `shapes`. Raises unless all are open, of `dtype` and of their shape. Raises where two share
-- memory, or one shares it with what a call uses whose progress function runs. Raises where one
-- shares memory with `points` (if that is an array): the work would overwrite the points while it
-- still reads them.
function outputs.of(n, name, out, dtype, shapes, points)
  if out == nil then return end
  if core.type(out) == "ylm.array" then out = { out } end
  if type(out) ~= "table" or core.type(out) then
    return check.bad(n, name, "out must be an array, or a list of up to %d arrays, got %s", #shapes,
      check.describe(out))
  end
  local last = 0
  for i in pairs(out) do
    if not check.is_integer(i) or i < 1 or i > #shapes then
      return check.bad(n, name, "out takes %d array%s (see derivatives), got an entry %s", #shapes,
        #shapes == 1 and "" or "s", check.describe(i))
    end
    last = math.max(last, i)
  end
  for i = 1, last do
    local a, shape = out[i], shapes[i]
    if a ~= nil then
      if core.type(a) ~= "ylm.array" then
        return check.bad(n, name, "out[%d] must be an array, got %s", i, check.describe(a))
      end
      local own, own_type, _, is_open = core.array_info(a)
      if not is_open then return check.bad(n, name, "out[%d]: the array has been closed", i) end
      if own_type ~= dtype or extents(own) ~= extents(shape) then
        return check.bad(n, name, "out[%d] must be a %s array of %s, got a %s array of %s", i, dtype, extents(shape),
          own_type, extents(own))
      end
      if core.type(points) == "ylm.array" and core.array_overlap(a, points) then
        return check.bad(n, name, "out[%d] shares memory with the points", i)
      end
      for k = 1, i - 1 do
        if out[k] and core.array_overlap(a, out[k]) then
          return check.bad(n, name, "out[%d] shares memory with out[%d]", i, k)
        end
      end
    end
  end
  for i = 1, last do
    if out[i] then
      check.result(name, core.array_is_free(out[i]))
      core.array_set_convention(out[i], 0)
    end
  end
  return out[1], out[2], out[3]
end

return outputs
