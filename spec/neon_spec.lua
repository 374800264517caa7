-- The NEON kernels, cross-compiled for aarch64 and run under qemu-user, against the reference kernel.

local scratch = require "spec.support.scratch"
local quote = scratch.quote

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

describe("NEON kernels", function()
  local cc = "aarch64-linux-gnu-gcc"

  it("agree with the reference kernel under qemu", function()
    for _, program in ipairs { cc, "qemu-aarch64" } do
      if not has(program) then return pending(program .. " is not installed") end
    end
    local folder = scratch.new()
    local program = folder.path .. "/neon"
    local plain = "csrc/base/*.c csrc/sh/eval.c csrc/sh/reference.c csrc/sh/compare.c"
    local kernels = "csrc/sh/eval_float.isa.c csrc/sh/eval_double.isa.c csrc/sh/low_float.isa.c csrc/sh/low_double.isa.c"
    local out, status = scratch.capture(table.concat({ cc, "-std=gnu11 -O0 -Wall -Wextra -Werror -fopenmp -static",
      "-DYLM_ISA=neon -DYLM_VECTOR_BYTES=16 -Icsrc/base -Icsrc/sh", plain, kernels, "spec/support/neon.c",
      "-lm -o", quote(program) }, " "))
    assert(status == 0, out)
    out, status = scratch.capture("qemu-aarch64 " .. quote(program))
    folder:remove()
    assert(status == 0 and out:find "ok", out)
  end)
end)
