--- Several Lua states in the threads of one process: each gets what it gets alone.

local long = require "spec.support.long"
local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local drawn = pcall(require, "ylm.c.scene") and "[^\n]*; " or "" -- a warning of a picture, where scenes are built in

local SCENE = [[return scene "states" {
  camera = camera { from = { 0, 0.5, 2.8 }, at = { 0, 0, 0 }, fov = 45 },
  geometry = { sphere { radius = 0.4, divide = { 12, 6 }, material = ggx { f0 = 0.7, alpha = 0.3 } },
    quad { corner = { -1, -0.5, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, divide = 4, material = matte { albedo = 0.5 } } },
  lights = { sphere_light { at = { 0.2, 0.9, 0.4 }, radius = 0.1, radiance = { 9, 5, 2 } },
    photometric_light { photometry = photometry { cosine = 2, lumens = 90 }, at = { -0.4, 1, 0 }, efficacy = 179 } } }]]

describe("Lua states in threads", function()
  local folder, program
  setup(function()
    folder = scratch.new()
    folder:write("scene.lua", SCENE)
    folder:write("bad.png", "no picture")
    program = scratch.quote(folder.path .. "/states")
  end)
  teardown(function() folder:remove() end)

  --- Compiles states.c for Lua 5.4; the checker of threads has to see the program's own.
  local function compile()
    if build:find "/asan$" then return "not of AddressSanitizer's build" end
    local out, code = scratch.capture(("${CC:-cc} -std=gnu11 -O1 -g -Wall -Wextra -Werror %s spec/support/states.c -o %s "
      .. "$(pkg-config --cflags --libs lua5.4 || echo -llua5.4) -lpthread"):format(build:find "/threads$" and
      "-fsanitize=thread" or "", program))
    if code ~= 0 then return "a program with Lua 5.4 is not built: " .. out end
  end

  it("bake, bounce, draw, save, warn, fail and are cancelled in turn as one that is alone, bit for bit", function()
    local missing = compile()
    if missing then return pending(missing) end
    for _, threads in ipairs(long({ 2 }, { 2, 4, 8 })) do
      local out, code = scratch.capture(("YLM_THREADS=2 timeout %d %s spec/support/states.lua %d %d %s"):format(patience(300),
        program, threads, long(1, 5), scratch.quote(folder.path)))
      assert.equal(0, code, out)
      assert.truthy(out:find("\ncancelled\tnil, cancelled, true\n", 1, true), out)
      assert.truthy(out:find("\nwarned\t" .. drawn .. "a state warns\n"), out)
      assert.truthy(out:find(("\n%d states\n$"):format(threads * long(1, 5))), out)
    end
  end)

  it("may watch for interrupts more than once", function()
    local out, code = scratch.capture(("timeout %d ${YLM_LUA:-lua5.4} %s"):format(patience(10),
      scratch.quote(folder:write("watch.lua", [[
      local core = require "ylm.c.core"
      assert(core.process_watch())
      assert(not core.process_watch())
      local pipe = assert(io.popen "p=$PPID; (sleep 0.1; kill -INT $p) >/dev/null 2>&1 & echo")
      pipe:close()
      local ended, message = pcall(function() while true do core.seconds() end end)
      print(ended, message, core.process_interrupted())]]))))
    assert.equal(0, code, out)
    assert.truthy(out:find "^false\t[^\n]*interrupted!\ttrue", out)
  end)
end)
