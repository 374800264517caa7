-- Memory that runs out, wherever it is asked for: nil, message, "ENOMEM", and everything goes on afterwards.
--
-- Every call of spec/support/memory/calls.lua is made while one of the requests for memory that it makes fails, by a
-- library that is preloaded. The specs let every 24th fail, of few requests every one (of slow calls every 120th, of pictures
-- every 300th, of a live window every 15000th); `YLM_MEMORY=all spec/run spec/memory_spec.lua spec/memory_picture_spec.lua` all
-- some 5,000, and every 40th of a live window: seven minutes, where pictures are drawn without a GPU.

local core = require "ylm.c.core"
local form = require "ylm.form"
local library = require "ylm.library"
local memory = require "ylm.memory"
local preload = require "spec.support.memory.preload"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

describe("memory that runs out", function()
  local folder, program, missing
  setup(function()
    folder = scratch.new()
    program, missing = preload.new(folder)
  end)
  teardown(function() folder:remove() end)

  it("is said in calls of every kind, which can be made again", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^[^:]*$", 24)
    assert(status == 0 and out:find "\n%d+ calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said in calls that take longer", function()
    if missing then return pending(missing) end
    local out, status = preload.sweep(program, folder, "^slow: ", 120)
    assert(status == 0 and out:find "\n2 calls, %d+ requests, %d+ failures, 0 defects", out)
  end)

  it("is said where Lua's own runs out", function()
    local f = memory.public(function() error("not enough memory", 0) end)
    assert.same({ nil, "memory ran out", "ENOMEM" }, { f() })
  end)

  it("is said by the outermost of public functions that call one another, and by those that a user's function calls",
    function()
      local raised = function() error("not enough memory", 0) end
      local inner, went_on = memory.public(raised), false
      local outer = memory.public(function() inner() went_on = true end)
      assert.equal("ENOMEM", (select(3, outer())))
      assert.is_false(went_on)
      local code
      outer = memory.public(function(progress) progress() return 5 end)
      assert.equal(5, outer(memory.users(function() code = select(3, inner()) end)))
      assert.equal("ENOMEM", code)
    end)

  it("leaves other errors as they are", function()
    local raised = {}
    local ok, got = pcall(memory.public(function() error(raised, 0) end))
    assert.is_false(ok)
    assert.equal(raised, got)
    assert.is_nil(core.no_memory(raised))
    assert.is_nil(core.no_memory "memory ran out")
  end)

  it("is told from a library that is not installed", function()
    local reasons = {
      ["error loading module 'ylm.c.short' from file 'x.so':\n\tx.so: failed to map segment from shared object"]
        = { "libylm_short cannot be loaded: memory ran out (x.so: failed to map segment from shared object)", "ENOMEM" },
      ["error loading module 'ylm.c.short' from file 'x.so':\n\tliby.so.3: cannot open shared object file"]
        = { "install liby (liby.so.3: cannot open shared object file)", "EMISSING" },
    }
    for raised, says in pairs(reasons) do
      package.preload["ylm.c.short"] = function() error(raised, 0) end
      assert.same({ nil, says[1], says[2] }, { library.open("short", "install liby (%s)") })
    end
    package.preload["ylm.c.short"] = nil
  end)

  it("lets files of ylm that were loaded in part be loaded again", function()
    local before, names = package.loaded["ylm.camera"] or require "ylm.camera", #form.names
    package.loaded["ylm.camera"] = nil
    assert.not_equal(before, require "ylm.camera")
    assert.equal(names, #form.names)
    assert.has_error(function() form.define("camera", { fields = {} }) end)
    package.loaded["ylm.camera"] = before
  end)

  it("is no failure of a limit that a scene file has passed", function()
    local path = folder:write("s.lua", "local s = 'x' while true do s = s .. s end")
    assert.equal("ELIMIT", (select(3, ylm.load(path, { memory = 2 ^ 20 }))))
  end)
end)
