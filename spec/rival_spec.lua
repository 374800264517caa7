-- Methods that exist to be compared with: a library that is loaded when one of them is first asked for.

local scratch = require "spec.support.scratch"
local quote = scratch.quote

local build = os.getenv "YLM_BUILD" or "build"
--- The folder that holds the bindings of this Lua.
local bindings
for from in package.cpath:gmatch "([^;]+)/%?%.so" do
  if not bindings and scratch.shell("test -f " .. quote(from .. "/ylm/c/core.so")) then bindings = from end
end

--- Runs a Lua script in another process; what it prints. `from`: the folder with the bindings.
local function run(from, text)
  local out, status = scratch.capture(("LUA_CPATH=%s %s -e %s"):format(quote(from .. "/?.so"),
    os.getenv "YLM_LUA" or "lua5.4", quote(text)))
  assert(status == 0, out)
  return out
end

--- Calls that name such a method, and calls that need none.
local calls = [[
  local ylm = require "ylm"
  local up, a = { { 0.1, 0.2, 1 } }, { 1, 0.5, 0, 0.2 }
  local calls = {
    function() return ylm.sh.eval(2, up, { method = "sloan" }) end,
    function() return ylm.sh.eval(2, up, { method = "polynomial", solid = true }) end,
    function() return ylm.sh.product(a, a, { method = "fourier" }) end,
    function() return ylm.sh.product(a, a, a, { method = "recursive", inner = "brute" }) end }
  local loaded = function() return package.loaded["ylm.c.rival"] ~= nil end
  assert(ylm.sh.eval(2, up) and ylm.sh.product(a, a) and ylm.sh.product(a, a, { method = "gaunt" }) and not loaded())
]]

describe("libylm_rival", function()
  it("is loaded by the first call that names a method of it, whose bits are those of later calls", function()
    local out = run(bindings, calls .. [[
      for _, call in ipairs(calls) do
        local first = assert(call())
        assert(loaded() and require "ylm.c.core".array_distance(first, call()) == 0)
      end
      io.write "good"]])
    assert.equal("good", out)
  end)

  it("is what C is told to register", function()
    local out = run(bindings, [[
      local core = require "ylm.c.core"
      local p = core.array_zeros({ 1, 3 }, "double")
      print(core.sh_eval(0, p, { y = core.array_zeros({ 1, 1 }, "double"), method = "scd" }))
      print(core.sh_product_plan(1, 2, "fourier", "auto"))]])
    assert.equal(([[
nil	method 'scd' needs libylm_rival: call ylm_rival_register()	EMISSING
nil	method 'fourier' needs libylm_rival: call ylm_rival_register()	EMISSING
]]), out)
  end)

  describe("where it is not installed", function()
    local folder
    setup(function()
      folder = scratch.new()
      local name = quote(folder.path)
      assert(scratch.shell(("mkdir -p %s/lua/ylm/c %s/lib && ln -s \"$(readlink -f %s)\" %s/lua/ylm/c && "
        .. "ln -s \"$(readlink -f %s)\" %s/lib/libylm.so.0"):format(name, name, quote(bindings .. "/ylm/c/core.so"), name,
        quote(build .. "/lib/libylm.so"), name)))
    end)
    teardown(function() folder:remove() end)

    local missing = [[
      for _, call in ipairs(calls) do
        local result, message, code = call()
        assert(result == nil and code == "EMISSING", code)
        print(message)
      end
      assert(not loaded())]]

    it("is named by calls that need it, which say what to do", function()
      local _, count = run(folder.path .. "/lua", calls .. missing)
        :gsub("this method, kept for comparison, needs libylm_rival: run make %(or make install%) again %(module 'ylm%.c%.rival' "
          .. "not found%)\n", "")
      assert.equal(4, count)
    end)

    it("is named too where the binding alone is there", function()
      assert(scratch.shell(("ln -s \"$(readlink -f %s)\" %s/lua/ylm/c"):format(quote(bindings .. "/ylm/c/rival.so"),
        quote(folder.path))))
      local _, count = run(folder.path .. "/lua", calls .. missing)
        :gsub("this method, [^\n]* again %(libylm_rival%.so%.0: cannot open shared object file[^\n]*%)\n", "")
      assert.equal(4, count)
    end)
  end)
end)
