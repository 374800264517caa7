--- csrc/sh/gen/sh_plain.h, sh_stable.h: unrolled functions for values, gradients, Hessians, one for every lmax as far as
-- unrolling pays: beyond, loops (eval/sh_kernel.h) are smaller and faster. A form's functions have one block a degree.

local source = require "ylm.codegen.source"

--- The highest lmax for values, gradients, Hessians; csrc/sh/eval/low_kernel.h has the same. From lmax 5 on, `stable` keeps
-- float's digits near the poles.
local highest = {
  plain = { [0] = 4, 4, 4 },
  stable = { [0] = 12, 10, 6 },
}

--- "plain" or "stable" -> the file's text.
return function(form)
  local requests = {}
  for derivatives = 0, 2 do
    requests[#requests + 1] = { lmax = highest[form][derivatives], derivatives = derivatives, any = true,
      name = ("sh_%s_%d"):format(form, derivatives), stable = form == "stable" }
  end
  return source.file(requests, "c")
end
