--- Fields of lights that are arrays.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"

--- A field's value as a double array, and its shape, once that fits(shape); `wanted` says which do, for the message.
-- fail(message) raises.
local function numbers(name, value, wanted, fits, fail)
  if check.is_number(value) then value = { value } end
  local shape, dtype, is_open, _
  if core.type(value) == "ylm.array" then
    shape, dtype, _, is_open = core.array_info(value)
    if not is_open then return fail(name .. ": the array has been closed") end
  elseif type(value) == "table" then
    shape = array.shape_of(value)
  end
  if not shape or not fits(shape) then
    local got = shape and "an array of " .. table.concat(shape, "x")
    return fail(("%s must be %s, got %s"):format(name, wanted, got or check.describe(value)))
  end
  if dtype then return dtype == "double" and value or core.array_convert(value, "double"), shape end
  form.take_numbers(shape, fail)
  local a = core.array_zeros(shape, "double")
  local ok, where = core.array_fill(a, value)
  if not ok then return fail(("%s must be %s; element %d does not fit"):format(name, wanted, where)) end
  return a, shape
end

return numbers
