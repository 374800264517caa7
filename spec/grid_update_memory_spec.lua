--- grid:update where memory runs out: the grid is then as it was, or says that it is spent. Every fifth request for
--- memory fails once and for good; `YLM_MEMORY=all spec/run spec/grid_update_memory_spec.lua`: every one, half a minute.

local preload = require "spec.support.memory.preload"
local scratch = require "spec.support.scratch"

describe("grid:update without memory", function()
  local folder, program, missing
  setup(function()
    folder = scratch.new()
    program, missing = preload.new(folder)
  end)
  teardown(function() folder:remove() end)

  it("leaves the grid as it was or spent, at whichever request memory runs out, once or for good", function()
    if missing then return pending(missing) end
    local out, status = program("spec/support/update_memory.lua " .. (os.getenv "YLM_MEMORY" == "all" and 1 or 5))
    assert(status == 0 and out:find "\n%d+ failures, [1-9]%d* spent, 0 defects", out)
  end)
end)
