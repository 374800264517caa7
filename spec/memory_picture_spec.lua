-- Memory that runs out while a picture is drawn; memory_spec.lua has the rest.

local preload = require "spec.support.memory.preload"
local scratch = require "spec.support.scratch"

describe("memory that runs out", function()
  local folder, program, missing
  setup(function()
    folder = scratch.new()
    program, missing = preload.new(folder)
  end)
  teardown(function() folder:remove() end)

  it("is said in pictures, which can be made again", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^picture: ", 300)
    assert(status == 0 and out:find "\n%d+ calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said while probes are written for engines, and read", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^probes: ", 400, 20)
    assert(status == 0 and out:find "\n1 calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said while light is found on surfaces", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^surface: ", 40000, 150)
    assert(status == 0 and out:find "\n1 calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said while a lightmap is made and saved", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^lightmap: ", 40000, 150)
    assert(status == 0 and out:find "\n1 calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said by a live window, which is closed, so that another one can be opened", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^picture live: ", 15000, 40)
    assert(status == 0 and out:find "\n1 calls, %d+ requests, %d+ failures, 0 defects", out)
  end)
end)
