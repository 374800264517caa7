--- grid:update where memory runs out: the grid is then as it was, or says that it is spent. Every fifth request for
--- memory fails once and for good; `YLM_MEMORY=all spec/run spec/grid_update_memory_spec.lua`: every one, half a minute.

local scratch = require "spec.support.scratch"

local build, lua = os.getenv "YLM_BUILD" or "build", os.getenv "YLM_LUA" or "lua5.4"
local abi = lua == "luajit" and "lua5.1" or lua

describe("grid:update without memory", function()
  local folder, missing
  setup(function()
    folder = scratch.new()
    if (os.getenv "LD_PRELOAD" or "") ~= "" then
      missing = "another library is preloaded"
      return
    end
    local out, status = scratch.capture(("${CC:-cc} -std=gnu11 -O1 -Wall -Wextra -Werror -shared -fPIC "
      .. "$(pkg-config --cflags %s) spec/support/exhausted.c -o %s -ldl"):format(lua,
      scratch.quote(folder.path .. "/exhausted.so")))
    if status ~= 0 then missing = "spec/support/exhausted.c cannot be built: " .. out end
  end)
  teardown(function() folder:remove() end)

  it("leaves the grid as it was or spent, at whichever request memory runs out, once or for good", function()
    if missing then return pending(missing) end
    local quote = scratch.quote
    local out, status = scratch.capture(("YLM_THREADS=1 YLM_WARNINGS=no LUA_PATH='lua/?.lua;lua/?/init.lua;./?.lua;;' "
      .. "LUA_CPATH=%s LD_PRELOAD=%s %s spec/support/update_memory.lua %d"):format(
      quote(folder.path .. "/?.so;" .. build .. "/" .. abi .. "/?.so;;"), quote(folder.path .. "/exhausted.so"), lua,
      os.getenv "YLM_MEMORY" == "all" and 1 or 5))
    assert(status == 0 and out:find "\n%d+ failures, [1-9]%d* spent, 0 defects", out)
  end)
end)
