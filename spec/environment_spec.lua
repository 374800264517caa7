-- Values of the environment's YLM_ISA and YLM_THREADS, and the messages about wrong ones; in processes of their own.

local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local lua = os.getenv "YLM_LUA" or "lua5.4"
local ylm = require "ylm"

describe("the environment", function()
  local folder
  setup(function()
    folder = scratch.new()
    folder:write("look.lua", 'local ylm = require "ylm"\nlocal i = ylm.info()\nprint(i.kernel, i.threads)\n')
    folder:write("c.lua", 'print(require "ylm.c.core".info())\n') -- no check: what C falls back to
  end)
  teardown(function() folder:remove() end)

  --- Runs a script with `settings`; returns all that it prints and its exit status.
  local function run(settings, script)
    return scratch.capture(("%s %s %s 2>&1"):format(settings, lua, scratch.quote(folder.path .. "/" .. script)))
  end

  it("is obeyed", function()
    for _, kernel in ipairs(ylm.info().kernels) do
      assert.equal(kernel .. "\t3\n", (run("YLM_ISA=" .. kernel .. " YLM_THREADS=3", "look.lua")))
    end
    local out, code = run("YLM_ISA= YLM_THREADS=", "look.lua") -- empty is unset
    assert.equal(0, code, out)
    assert.truthy(run("YLM_THREADS=1024", "look.lua"):find "\t1024\n")
  end)

  it("is refused by require at the caller's line, naming the variable and what it may be", function()
    for _, threads in ipairs { "1e9", "0", "-1", "1025", "99999999999999999999", "4 ", "2.0", "all" } do
      local out, code = run(("YLM_THREADS='%s'"):format(threads), "look.lua")
      assert.equal(1, code)
      assert.truthy(out:find("look.lua:1: YLM_THREADS is '" .. threads .. "' in the environment: "
        .. "an integer from 1 to 1024 expected", 1, true), out)
    end
    local list = table.concat(ylm.info().kernels, ", ")
    for _, isa in ipairs { "avx1024", "AVX2", list:find "neon" and "sse2" or "neon" } do -- the last is not of this processor
      local out, code = run("YLM_ISA=" .. isa, "look.lua")
      assert.equal(1, code)
      assert.truthy(out:find("look.lua:1: YLM_ISA is '" .. isa .. "' in the environment: one of " .. list .. " expected",
        1, true), out)
    end
  end)

  it("makes the command-line tool end with status 2 before any work", function()
    for _, words in ipairs { "info", "render no.lua -o x.png", "codegen --lmax 2" } do
      local out, code = scratch.capture(("YLM_LUA=%s YLM_THREADS=1e9 LUA_PATH= LUA_CPATH= %s %s 2>&1"):format(lua,
        scratch.quote(build .. "/ylm"), words))
      assert.equal(2, code)
      assert.equal("ylm: YLM_THREADS is '1e9' in the environment: an integer from 1 to 1024 expected\n", out)
    end
  end)

  it("leaves the C library silent, with the best kernels and all cores", function()
    local best = run("YLM_ISA= YLM_THREADS=", "c.lua"):gsub("table: %S+", "")
    local out = run("YLM_ISA=none YLM_THREADS=1e9", "c.lua"):gsub("table: %S+", "")
    assert.equal(best, out)
  end)
end)
