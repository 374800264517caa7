-- The NEON kernels: what they need of the core library cross-compiled for aarch64, run under qemu-user, against the
-- reference kernels.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local quote = scratch.quote

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

--- Sums of lights are compiled for degrees to this one by the generator's plans, beyond by the code of all; `make check-long`
-- compiles all plans, of which AVX-512, with as many registers, runs the others in `make test`.
local special = long(4, 10)

--- Objects of this machine's build, as the Makefile names them for NEON, that the programs need, found by their symbols.
local function objects_of(programs)
  local build = os.getenv "YLM_BUILD" or "build"
  local ladder, folders = scratch.text "csrc/README.md":match "\n    (base <.-) < codec", { quote(build) .. "/obj/rival" }
  for room in ladder:gmatch "%a+" do folders[#folders + 1] = quote(build) .. "/obj/" .. room end -- the core library's
  local files = scratch.capture(("nm -A -g $(find %s -name '*.o')"):format(table.concat(folders, " ")))
  local defined, wanted = {}, {}
  for file, kind, symbol in files:gmatch "([^\n]-%.o):[%x ]+ (%u) ([^\n]+)" do
    if kind ~= "U" then defined[symbol] = file
    else
      wanted[file] = wanted[file] or {}
      table.insert(wanted[file], symbol)
    end
  end
  local taken, list = {}, {}
  local function take(symbols)
    for _, symbol in ipairs(symbols) do
      local file = defined[symbol]
      if file and not taken[file] then
        local name = file:sub(#build + 2):gsub("%.sse2%.o$", ".neon.o"):gsub("%.avx%w+%.o$", ".neon.o")
        local plan = tonumber(name:match "/moments/gen/moments_(%d+)")
        if not taken[name] and (plan or 0) <= special then list[#list + 1] = name end -- each set of this machine has one
        taken[file], taken[name] = true, true
        take(wanted[file] or {})
      end
    end
  end
  for _, name in ipairs(programs) do
    local words = {}
    for word in scratch.text("spec/support/" .. name .. ".c"):gmatch "ylm_[%w_]+" do words[#words + 1] = word end
    take(words)
  end
  return list
end

describe("NEON kernels", function()
  local cc = "aarch64-linux-gnu-gcc"
  local folder, missing, objects
  setup(function()
    for _, program in ipairs { cc, "qemu-aarch64", "make" } do
      if not has(program) then missing = program .. " is not installed" end
    end
    if missing then return end
    -- Kept in the build folder, so that the next Lua and the next run find it made.
    folder = { path = (os.getenv "YLM_BUILD" or "build") .. "/neon" }
    -- By the Makefile itself; without optimisation, because that is compiled in seconds.
    objects = objects_of { "neon", "kernels" }
    for i, name in ipairs(objects) do objects[i] = quote(folder.path .. "/" .. name) end
    objects = table.concat(objects, " ")
    local out, status = scratch.capture(table.concat({ "env -u MAKEFLAGS -u MAKELEVEL -u LD_PRELOAD make -j2",
      "BUILD=" .. quote(folder.path), "CC=" .. cc, ("OPT='-O0 -DYLM__SPECIAL=%d'"):format(special),
      "SANITIZE= LUAS= WITH_SCENE=", objects }, " "))
    assert(status == 0 and not out:find "warning", out)
  end)

  --- Links spec/support/NAME.c with the library's objects and runs it; returns what it prints and its exit status.
  local function run(name, ...)
    local program = quote(folder.path .. "/" .. name)
    local out, status = scratch.capture(table.concat({ "env -u LD_PRELOAD", cc,
      "-std=gnu11 -O0 -Wall -Wextra -Werror -fopenmp -static -I" .. quote(folder.path .. "/include"),
      "spec/support/" .. name .. ".c", objects, "-lm -o", program }, " "))
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
