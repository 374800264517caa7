-- Messages of spec/run where it cannot work.

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
