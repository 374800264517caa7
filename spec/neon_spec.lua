-- The NEON kernels: the core library cross-compiled for aarch64, run under qemu-user, against the reference kernels.

local scratch = require "spec.support.scratch"
local quote = scratch.quote

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

describe("NEON kernels", function()
  local cc = "aarch64-linux-gnu-gcc"
  local folder, missing
  setup(function()
    for _, program in ipairs { cc, "qemu-aarch64", "make" } do
      if not has(program) then missing = program .. " is not installed" end
    end
    if missing then return end
    -- Kept in the build folder, so that the next Lua and the next run find it made.
    folder = { path = (os.getenv "YLM_BUILD" or "build") .. "/neon" }
    -- By the Makefile itself; without optimisation, because that is compiled in seconds.
    local out, status = scratch.capture(table.concat({ "env -u MAKEFLAGS -u MAKELEVEL -u LD_PRELOAD make -j2",
      "BUILD=" .. quote(folder.path), "CC=" .. cc, "OPT=-O0 SANITIZE= LUAS= WITH_SCENE=",
      quote(folder.path .. "/lib/libylm_rival.so") }, " "))
    assert(status == 0 and not out:find "warning", out)
  end)

  --- Links spec/support/NAME.c with the library's objects and runs it; returns what it prints and its exit status.
  local function run(name, ...)
    local program = quote(folder.path .. "/" .. name)
    local out, status = scratch.capture(table.concat({ "env -u LD_PRELOAD", cc,
      "-std=gnu11 -O0 -Wall -Wextra -Werror -fopenmp -static -I" .. quote(folder.path .. "/include"),
      "spec/support/" .. name .. ".c", "$(find " .. quote(folder.path) .. "/obj -name '*.o')", "-lm -o", program }, " "))
    assert(status == 0, out)
    local words = { ... }
    -- qemu-user dies of a signal now and then on a busy machine, whatever it runs; a program's own fault comes again.
    for _ = 1, 3 do
      out, status = scratch.capture(("env -u LD_PRELOAD %s qemu-aarch64 %s %s"):format(words[1] or "", program,
        table.concat(words, " ", 2)))
      if not out:find "uncaught target signal" then break end
    end
    return out, status
  end

  it("evaluate as the reference kernel does", function()
    if missing then return pending(missing) end
    local out, status = run "neon"
    assert(status == 0 and out:find "ok", out)
  end)

  it("sum lights, sample grids, rotate and multiply as the reference kernels do", function()
    if missing then return pending(missing) end
    local results = quote(folder.path .. "/results")
    local out, status = run("kernels", "YLM_ISA=reference", results)
    assert(status == 0 and out:find "^reference\n", out)
    out, status = run("kernels", "YLM_ISA=neon", results, "compare")
    assert(status == 0 and out:find "^neon\n" and out:find "ok", out)
  end)
end)
