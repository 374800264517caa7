--- csrc/sh/gen/sh_<lmax>.h: the unrolled functions of one lmax, for values, gradients, Hessians
-- as far as unrolling pays: beyond, loops (eval/sh_kernel.h) are smaller and faster.

local source = require "ylm.codegen.source"

--- The highest lmax for values, gradients, Hessians. csrc/sh/eval/low_kernel.h lists the same.
local highest = { [0] = 12, [1] = 10, [2] = 6 }

--- From this lmax on, the form that keeps float's digits near the poles.
local stable_from = 5

return function(lmax)
  local requests = {}
  for derivatives = 0, 2 do
    if lmax <= highest[derivatives] then
      local name = ("sh_%d_%d"):format(lmax, derivatives)
      requests[#requests + 1] = { lmax = lmax, derivatives = derivatives, name = name,
        stable = lmax >= stable_from }
    end
  end
  return source.file(requests, "c")
end
