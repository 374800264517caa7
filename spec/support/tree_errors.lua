-- Fields of lights summed by a tree, beside exact sums.

local core = require "ylm.c.core"
local light = require "ylm.light"

local tree_errors = {}

local names = { "value", "gradient", "Hessian", "lambda" }

--- The field of lights by `isa`; to a tolerance where one is given.
function tree_errors.field(lmax, lights, points, o, tolerance, isa)
  local object = assert(light.within("spec", light.pack(1, "spec", lights), tolerance))
  return { light.evaluate("spec", lmax, object, points, o, isa) }
end

--- Distance of results a from b beside the norm of `whole` (b), for each of n points: lists by name, sorted.
function tree_errors.of(a, b, whole, n)
  whole = whole or b
  local out = { {}, {}, {}, {} }
  for i = 1, n or #b[1] do
    for k = 1, 3 do
      if a[k] then
        local _, d = core.array_distance(a[k][i], b[k][i])
        local _, _, norm = core.array_distance(b[k][i], whole[k][i])
        out[k][i] = d / norm
      end
    end
    if a[4].lambda then out[4][i] = math.abs(a[4].lambda[i] - b[4].lambda[i]) / whole[4].lambda[i] end
  end
  for k = 1, 4 do table.sort(out[k]) end
  return out
end

--- Fails unless the 99.9 % quantile of errors is at most the tolerance, and the largest four times it.
function tree_errors.check(e, tolerance, what)
  for k = 1, 4 do
    local n = #e[k]
    if n > 0 then
      local high, most = e[k][math.ceil(0.999 * n)] / tolerance, e[k][n] / tolerance
      assert(high <= 1, ("%s, %s: the 99.9 %% quantile is %.3g of the tolerance"):format(what, names[k], high))
      assert(most <= 4, ("%s, %s: the largest error is %.3g of the tolerance"):format(what, names[k], most))
    end
  end
end

return tree_errors
