--- Light fields on a device beside those of the processor.

local assert = require "luassert"
local core = require "ylm.c.core"
local ylm = require "ylm"

local fields = {}

--- The largest distance between rows of a and b, relative to the L2 norm of b's row; NaN counts.
function fields.worst(a, b)
  local largest = 0
  for i = 1, #b do
    local _, e, n = core.array_distance(a[i], b[i])
    local x = n > 0 and e / n or e
    if not (x <= largest) then largest = x end
  end
  return largest
end

--- light_field on the device and by the processor, as two lists; `o` gets the device.
function fields.both(gpu, lmax, lights, points, o)
  local plain = {}
  for k, v in pairs(o) do if k ~= "method" then plain[k] = v end end
  o.device = gpu
  local there, here = { ylm.light_field(lmax, lights, points, o) }, { ylm.light_field(lmax, lights, points, plain) }
  assert(there[1], there[2])
  return there, here
end

--- Asserts that values, derivatives and the report agree to `bound`.
function fields.agree(gpu, lmax, lights, points, o, bound)
  local there, here = fields.both(gpu, lmax, lights, points, o)
  for k = 1, (o.derivatives or 0) + 1 do
    assert.same(here[k].shape, there[k].shape)
    assert.equal(here[k].dtype, there[k].dtype)
    local w = fields.worst(there[k], here[k])
    assert(w <= bound, ("lmax %d, derivatives %d: %g"):format(lmax, k - 1, w))
  end
  for _, key in ipairs { "lambda", "norm" } do
    if o.metric then
      local a, b = there[4][key], here[4][key]
      for i = 1, #a do
        local x, y = a:get(i), b:get(i)
        assert(math.abs(x - y) <= bound * math.abs(y), ("%s of point %d: %.9g, not %.9g"):format(key, i, x, y))
      end
    end
  end
  local _, differ = core.array_distance(there[4].inside, here[4].inside)
  assert.equal(0, differ)
  assert.equal(here[4].pairs, there[4].pairs)
  return there, here
end

return fields
