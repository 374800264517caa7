-- spec/run: the order of specs, and messages where it cannot work; how many processors make takes.

local scratch = require "spec.support.scratch"

describe("spec/run", function()
  it("begins with the specs that took longest, by their last whole reports", function()
    local folder = scratch.new()
    local function took(name, seconds, last)
      scratch.shell("mkdir -p " .. folder.path .. "/spec/lua5.4")
      folder:write("spec/lua5.4/" .. name .. "_spec", ("passed\t%s\tone\nskipped\t0.50\ttwo\n%s\n"):format(seconds, last))
    end
    local function order()
      return scratch.capture(("BUILD=%s YLM_SPEC= lua5.4 spec/support/run/jobs.lua 'lua5.4 luajit' spec/live_spec.lua "
        .. "spec/neon_spec.lua spec/team_spec.lua"):format(folder.path))
    end
    local files = "lua5.4 spec/%s_spec.lua\n"
    assert.equal((files:rep(2)):format("neon", "live") .. "lua5.4 spec/team_spec.lua\nluajit spec/team_spec.lua\n",
      (order()))
    took("neon", "1.00", "done")
    took("live", "90.00", "passed\t0.10\tcut short")
    took("team", "70.25", "done")
    assert.equal("lua5.4 spec/team_spec.lua\nluajit spec/team_spec.lua\n" .. (files:rep(2)):format("live", "neon"),
      (order()))
    folder:remove()
  end)

  it("says what to install where busted is missing, in one line, and runs nothing", function()
    local out, status = scratch.capture(([[LUA_INIT='package.preload["busted.runner"] = function() error "none" end' \
      SPEC_LUAS=%s spec/run spec/box_spec.lua]]):format(os.getenv "YLM_LUA" or "lua5.4"))
    assert.equal(2, status, out)
    assert.matches("^spec/run: busted is not installed for [%w.]+: 'make deps' installs it [^\n]*lua%-busted[^\n]*\n$", out)
  end)
end)

describe("spec/run with YLM_SPEC_KEEP", function()
  it("counts files that passed, and runs those that failed again", function()
    local lua, folder = os.getenv "YLM_LUA" or "lua5.4", scratch.new()
    local abi, ran = lua == "luajit" and "lua5.1" or lua, folder.path .. "/ran"
    scratch.shell(("mkdir %s/build && ln -s $(realpath %s)/%s %s/build/%s"):format(folder.path,
      os.getenv "YLM_BUILD" or "build", abi, folder.path, abi))
    local text = "io.open(%q, 'a'):write %q\ndescribe('a file', function() it('is run', function() assert(%s) end) end)\n"
    local good = folder:write("good_spec.lua", text:format(ran, "good ", "true"))
    local bad = folder:write("bad_spec.lua", text:format(ran, "bad ", "false"))
    local function run(prefix, options)
      local out, status = scratch.capture(("%s BUILD=%s/build SPEC_LUAS=%s YLM_SPEC_JOBS=1 spec/run %s %s %s"):format(prefix,
        folder.path, lua, good, bad, options or ""))
      assert.equal(1, status, out)
      assert.matches("\n1 passed, 1 failed\n$", out)
      local file = assert(io.open(ran))
      local names = file:read "*a"
      file:close()
      os.remove(ran)
      return names
    end
    local keep = ("YLM_SPEC_KEEP=%s/kept"):format(folder.path)
    assert.matches("good", run(keep))
    assert.equal("bad ", run(keep))
    assert.matches("good", run(keep, "--filter=run"))
    assert.matches("good", run "YLM_SPEC_KEEP=")
    folder:remove()
  end)
end)

describe("spec/long", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  --- Its output and status, where make is a shell's lines.
  local function long(words, make)
    folder:write("make", "#!/bin/sh\n" .. make)
    return scratch.capture(("cd %s && chmod +x make && cd - >/dev/null && BUILD=%s/build PATH=%s:$PATH FUZZ_CC=sh OTHER_CC=sh "
      .. "MAKEFLAGS=-j1 spec/long %s"):format(folder.path, folder.path, folder.path, words))
  end

  it("goes on behind a part that fails, and counts it; `rest` are those that have not passed", function()
    local out, status = long("sanitizers fuzz portability", [[
case "$*" in
  *fuzz*) echo "20 passed, 0 failed" ;;
  *asan) echo "5 passed, 2 failed, 1 skipped"; echo "make: *** [Makefile:1: asan] Error 1"; exit 1 ;;
  *) exit 2 ;;
esac]])
    assert.equal(1, status)
    assert.matches("\nsanitizers +0:00:%d%d  5 passed, 2 failed, 1 skipped.-\nfuzz +0:00:%d%d  20 passed, 0 failed.-"
      .. "\nportability +0:00:%d%d  0 passed, 1 failed[^\n]*\n25 passed, 3 failed, 1 skipped\n$", out)
    assert.matches("\nall of them\n", (long("fuzz", 'echo "${MAKEFLAGS-all of them}"'))) -- processors
    out, status = long("sanitizers fuzz", 'echo "3 passed, 0 failed"; [ "$*" != "--no-print-directory asan" ]')
    assert.equal(1, status)
    assert.matches("\nsanitizers +0:00:%d%d  0 passed, 1 failed[^\n]*\nfuzz[^\n]*\n3 passed, 1 failed\n$", out) -- it died
    for part in ("luas threads embree portable bricks long portability"):gmatch "%a+" do
      folder:write("build/long/" .. part, "1 passed, 0 failed\n3725 s\nabc\n")
    end
    out, status = long("rest", 'echo "7 passed, 0 failed"')
    assert.equal(0, status)
    assert.matches("^== sanitizers\n7 passed, 0 failed\n== all\n", out)
    assert.matches("\nluas +1:02:05  1 passed, 0 failed %(abc%)\n", out)
    assert.matches("\n17 passed, 0 failed\n$", out)
  end)

  it("goes on within a part at the same commit, and begins it anew at another", function()
    local make = [[
for word; do case $word in FUZZ_KEEP=*) kept=${word#*=} ;; esac; done
if [ -e "$kept/gltf" ]; then echo "2 passed, 0 failed"; else touch "$kept/gltf"; echo "1 passed, 1 failed"; fi]]
    local function counts(words, commit)
      folder:write("git", "#!/bin/sh\necho " .. commit .. "\n")
      scratch.shell("chmod +x " .. folder.path .. "/git")
      return (long(words, make)):match "\n([^\n]*)\n$"
    end
    scratch.shell("rm -rf " .. folder.path .. "/build/long/*")
    for part in ("luas threads sanitizers embree portable bricks long portability"):gmatch "%a+" do
      folder:write("build/long/" .. part, "1 passed, 0 failed\n1 s\nabc\n")
    end
    assert.equal("1 passed, 1 failed", counts("fuzz", "abc"))
    assert.equal("10 passed, 0 failed", counts("rest", "abc"))
    assert.equal("1 passed, 1 failed", counts("fuzz", "abc"))
    assert.equal("9 passed, 1 failed", counts("rest", "def"))
    assert.equal("10 passed, 0 failed", counts("rest", "def"))
    assert.equal("1 passed, 1 failed", counts("fuzz", "def-dirty"))
    assert.equal("9 passed, 1 failed", counts("rest", "def-dirty"))
    scratch.shell("rm " .. folder.path .. "/git")
  end)

  it("knows no other parts", function()
    local out, status = long("kills", "")
    assert.equal(2, status)
    assert.matches("^spec/long: no check 'kills' %(.-, all, rest%)\n$", out)
  end)
end)

describe("make", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  --- The -j under which a goal of make works; options: of its command line.
  local function jobs(options, environment)
    local file = folder:write("show.mk", "include Makefile\nshow: ; @echo $(filter -j%,$(MAKEFLAGS))\n")
    return (scratch.capture(("env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL %s make -s -f %s BUILD=%s %s show"):format(
      environment or "", file, scratch.quote(folder.path .. "/none"), options)):gsub("%s", ""))
  end

  --- The value of a variable of the Makefile in an empty build folder.
  local function value(name, settings, environment)
    local file = folder:write("value.mk", "include Makefile\nclean help: ; @echo '$(" .. name .. ")'\n")
    local build = scratch.quote(folder.path .. "/build")
    return (scratch.capture(("env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u KERNELS %s make -s -f %s BUILD=%s %s "
      .. "help 2>/dev/null | tail -n 1"):format(environment or "", file, build, settings)):gsub("%s+$", ""))
  end

  it("builds for Luas whose headers are there, not for an interpreter alone", function()
    local bin = folder.path .. "/luas"
    scratch.shell("mkdir " .. bin)
    for _, name in ipairs { "lua5.2", "lua5.4" } do folder:write("luas/" .. name, "#!/bin/sh\n") end
    folder:write("luas/lua5.4.pc", "Name: Lua\nDescription: Lua\nVersion: 5.4\n")
    scratch.shell("chmod +x " .. bin .. "/lua5.*")
    assert.matches("^ *lua5.4$", value("LUAS", "", ("PATH=%s:$PATH PKG_CONFIG_LIBDIR=%s"):format(bin, bin)))
  end)

  it("fuzzes each reader until FUZZ_RUNS inputs or FUZZ_MINUTES, and names those that time ended", function()
    folder:write("clang", [=[#!/bin/sh
while [ "$1" != -o ]; do shift; done
cat >"$2" <<'END'
#!/bin/sh
case $0:$* in
  */pfm:*) inputs=20000 ;;
  *-max_total_time=90\ *) inputs=1234 ;;
  *) exit 1 ;;
esac
printf 'stat::%s: %d\n' number_of_executed_units $inputs average_exec_per_sec 13 peak_rss_mb 376
END
chmod +x "$2"]=])
    scratch.shell(("chmod +x %s/clang && mkdir %s/fuzz"):format(folder.path, folder.path))
    local function fuzz(minutes)
      return scratch.capture(("env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u FUZZ_ARGS make -s fuzz FUZZ='npy pfm' FUZZ_OBJ= "
        .. "FUZZ_CC=%s/clang FUZZ_DIR=%s/fuzz FUZZ_RUNS=2e4 FUZZ_MINUTES=%s"):format(folder.path, folder.path, minutes))
    end
    local out, status = fuzz "1.5"
    assert.equal(0, status, out)
    assert.matches("== all\nnpy +1234 inputs, +13 a second, +376 MB, ended by time\npfm +20000 inputs, +13 a second, +376 MB\n"
      .. "ended by 1.5 minutes, with fewer than 20000 inputs: npy 1234 %(13 a second%)\n2 passed, 0 failed\n$", out)
    out, status = fuzz "2"
    assert.equal(2, status)
    assert.matches("== all\npfm +20000 inputs, +13 a second, +376 MB\n1 passed, 1 failed\n", out)
  end)

  it("builds all kernels of an architecture, or those of KERNELS, and tests the widest that the processor runs", function()
    local x86 = "ARCH=x86_64 CPU_FLAGS='fpu sse2 fma avx2' "
    assert.equal("sse2 avx2 avx512", value("ISAS", x86))
    assert.equal("avx2", value("ISAS", x86 .. "KERNELS=avx2"))
    assert.equal("neon", value("ISAS", "ARCH=aarch64 KERNELS='sse2 avx2'"))
    assert.equal("avx2", value("TESTED", x86))
    assert.equal("sse2", value("TESTED", "ARCH=x86_64 CPU_FLAGS='fpu sse2 avx2'"))
    assert.equal("sse2 avx2 avx512", value("TESTED", "ARCH=x86_64 CPU_FLAGS=")) -- a system that does not say
    assert.equal("no spec runs kernels for sse2 avx512: specs run the widest that this processor has; make builds all",
      value("WHY_NOT", x86))
    assert.equal("no spec runs kernels for sse2 avx2 (spec/narrow_spec.lua runs those of avx2 that sum no lights): "
      .. "specs run the widest that this processor has; make builds all",
      value("WHY_NOT", "ARCH=x86_64 CPU_FLAGS='sse2 fma avx2 avx512f avx512dq avx512vl avx512bw'"))
    scratch.shell("mkdir -p " .. scratch.quote(folder.path .. "/build/include"))
    folder:write("build/include/ylm_built_sets.h", "/* sse2 avx2 avx512 */\n")
    assert.equal("sse2 avx2 avx512", value("TESTED", x86)) -- what is built stays
    assert.equal("no spec runs kernels for avx512: this processor has none", value("WHY_NOT", x86))
  end)

  it("takes all processors for one goal, unless -j says how many", function()
    assert.equal("-j" .. scratch.capture "nproc":gsub("%s", ""), jobs "")
    assert.equal("-j1", jobs "-j1")
    assert.equal("-j3", jobs("", "MAKEFLAGS=-j3"))
    assert.equal("", jobs "show")
  end)
end)
