local warning = require "ylm.warning"
local ylm = require "ylm"

describe("ylm.on_warning", function()
  local before
  before_each(function() before = ylm.on_warning(false) end)
  after_each(function() ylm.on_warning(before) end)

  it("hands lines to a function, once for each object and topic", function()
    local said, scene, grid = {}, {}, {}
    ylm.on_warning(function(message) said[#said + 1] = message end)
    assert.equal("10 % is dark", warning.say(scene, "walls", "%d %% is dark", 10))
    assert.equal("11 % is dark", warning.say(scene, "walls", "%d %% is dark", 11))
    warning.say(scene, "tolerance", "error 0.2")
    warning.say(grid, "tolerance", "error 0.3")
    assert.same({ "10 % is dark", "error 0.2", "error 0.3" }, said)
  end)

  it("returns what was chosen before, so that it can be chosen again", function()
    local function f() end
    assert.is_false(ylm.on_warning(f))
    assert.equal(f, ylm.on_warning())
    assert.is_nil(ylm.on_warning(false))
    assert.is_false(ylm.on_warning(nil))
  end)

  it("writes to stderr in a program that chooses nothing, unless YLM_WARNINGS=no", function()
    local lua = os.getenv "YLM_LUA" or "lua5.4"
    for _, case in ipairs { { "", "ylm: dim\n" }, { "no", "" } } do
      local pipe = assert(io.popen("YLM_WARNINGS=" .. case[1] .. " " .. lua
        .. [[ -e 'require("ylm.warning").say({}, "x", "dim")' 2>&1]]))
      assert.equal(case[2], pipe:read "*a")
      pipe:close()
    end
  end)
end)
