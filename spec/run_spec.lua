-- Messages of spec/run where it cannot work.

local scratch = require "spec.support.scratch"

describe("spec/run", function()
  it("says what to install where busted is missing, in one line, and runs nothing", function()
    local out, status = scratch.capture(([[LUA_INIT='package.preload["busted.runner"] = function() error "none" end' \
      SPEC_LUAS=%s spec/run spec/box_spec.lua]]):format(os.getenv "YLM_LUA" or "lua5.4"))
    assert.equal(2, status, out)
    assert.matches("^spec/run: busted is not installed for [%w.]+: 'make deps' installs it [^\n]*lua%-busted[^\n]*\n$", out)
  end)
end)
