-- The NEON kernels: what they need of the core library cross-compiled for aarch64, run under qemu-user, against the
-- reference kernels; by `make check-long` those of lights, grids, rotations and products too, as this machine has them.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local quote = scratch.quote
local build = os.getenv "YLM_BUILD" or "build"

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

--- The programs that are run; the others' kernels are the same code with as many registers as AVX-512, which `make test` runs.
local programs = long({ "neon" }, { "neon", "kernels" })

--- Rooms that the programs' code refers to and never enters: they are only parsed, in a tenth of the time. A program that enters
--- one after all jumps to address 0, and fails.
local parsed = { "light/virtual", "light/flat", "light/photometric", "light/image", "light/distant", "image" }

local function is_parsed(object)
  for _, room in ipairs(parsed) do if object:find("obj/" .. room .. "/", 1, true) then return true end end
end

--- Objects of this machine's build, as the Makefile names them for NEON, that `programs` need, found by their symbols.
local function objects_of()
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
        if not taken[name] then list[#list + 1] = name end -- each set of this machine has one
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

  --- Has the Makefile itself make objects, without optimisation, because that is compiled in seconds.
  local function make(path, how, names)
    local list = {}
    for i, name in ipairs(names) do list[i] = quote(path .. "/" .. name) end
    local out, status = scratch.capture(table.concat({ "env -u MAKEFLAGS -u MAKELEVEL -u LD_PRELOAD make -j2",
      "BUILD=" .. quote(path), "CC=" .. cc, ("OPT='-O0%s'"):format(how),
      "SANITIZE= LUAS= WITH_SCENE=", table.concat(list, " ") }, " "))
    assert(status == 0 and not out:find "warning", out)
    return table.concat(list, " ")
  end

  setup(function()
    for _, program in ipairs { cc, "qemu-aarch64", "make" } do
      if not has(program) then missing = program .. " is not installed" end
    end
    if missing then return end
    -- Kept in the build folder, so that the next Lua and the next run find it made.
    folder = { path = build .. "/neon" }
    local compiled, others = {}, {}
    for _, name in ipairs(objects_of()) do
      local list = is_parsed(name) and others or compiled
      list[#list + 1] = name
    end
    objects = make(folder.path, "", compiled)
    if others[1] then make(folder.path .. "/parsed", " -fsyntax-only", others) end
  end)

  --- Compiles spec/support/NAME.c: the path of the program.
  local function compiled(name, compiler, with)
    local program = quote(folder.path .. "/" .. name .. "-" .. compiler)
    local out, status = scratch.capture(table.concat({ "env -u LD_PRELOAD", compiler,
      "-std=gnu11 -O0 -Wall -Wextra -Werror -fopenmp", "spec/support/" .. name .. ".c", with, "-lm -o", program }, " "))
    assert(status == 0, out)
    return program
  end

  --- Links spec/support/NAME.c with the library's objects and runs it; returns what it prints and its exit status.
  local function run(name, ...)
    local program = compiled(name, cc, ("-I%s/include -static -Wl,--unresolved-symbols=ignore-all %s"):format(
      quote(folder.path), objects))
    local words = { ... }
    local out, status
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

  if long(false, true) then it("sum lights, sample grids, rotate and multiply as the reference kernels do", function()
    if missing then return pending(missing) end
    local results, own = quote(folder.path .. "/results"), quote(build)
    local here = compiled("kernels", "cc", ("-I%s/include -L%s/lib -lylm_rival -lylm"):format(own, own))
    local out, status = scratch.capture(("LD_LIBRARY_PATH=%s/lib YLM_ISA=reference %s %s"):format(own, here, results))
    assert(status == 0 and out:find "^reference\n", out)
    out, status = run("kernels", "YLM_ISA=neon", results, "compare")
    assert(status == 0 and out:find "^neon\n" and out:find "ok", out)
  end) end
end)
