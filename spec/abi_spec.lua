-- One C source serves every Lua; an object built for another Lua is an error, not a crash.

local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local abis = { "lua5.1", "lua5.2", "lua5.3", "lua5.4", "lua5.5" }
local interpreters = { luajit = "lua5.1" }
for _, abi in ipairs(abis) do interpreters[abi] = abi end

--- Is this Lua here, and what is built for it?
local function present(lua, abi)
  return scratch.shell(("command -v %s >/dev/null && test -e %s/%s/ylm/c/core.so"):format(lua, scratch.quote(build), abi))
end

--- Runs `text` under `lua` with the bindings of `abi`; returns output, exit status.
local function run(lua, abi, text)
  return scratch.capture(("env -u LUA_PATH_5_2 -u LUA_PATH_5_3 -u LUA_PATH_5_4 -u LUA_PATH_5_5 "
    .. "-u LUA_CPATH_5_2 -u LUA_CPATH_5_3 -u LUA_CPATH_5_4 -u LUA_CPATH_5_5 "
    .. "LUA_PATH='lua/?.lua;lua/?/init.lua' LUA_CPATH=%s %s -e %s"):format(
    scratch.quote(build .. "/" .. abi .. "/?.so"), lua, scratch.quote(text)))
end

describe("the binding", function()
  it("is for the versions of Lua that the rockspec names", function()
    local file = assert(io.open "rockspec/ylm-scm-1.rockspec")
    local least, below = file:read "*a":match 'dependencies = { "lua >= 5%.(%d), < 5%.(%d)" }'
    file:close()
    local named = {}
    for minor = least, below - 1 do named[#named + 1] = ("lua5.%d"):format(minor) end
    assert.same(abis, named)
  end)

  for lua, abi in pairs(interpreters) do
    it("works under " .. lua, function()
      if not present(lua, abi) then pending(lua .. " is not installed") end
      local out, code = run(lua, abi, [[
        local ylm = require "ylm"
        local a = ylm.array({ { 0, 0, 1 }, { 1, 2, 3 } })
        local Y = ylm.sh.eval(4, a)
        assert(#Y == 2 and Y.shape[2] == 25 and math.abs(Y:get(1, 1) - 0.28209479177388) < 1e-14)
        local s = ylm.scene "x" { background = 2 }
        assert(s.background[3] == 2)
        assert(not pcall(ylm.zeros, { -1 }))
        for _, name in ipairs(ylm.names()) do assert(ylm[name], name) end
        for i = 1, 50 do ylm.zeros { 1000, 100 } end
        -- counts read "27", never "27.0"
        local g = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 },
          ylm.sphere_light { at = { 0, 2, 0 } })
        local _, _, report = g:sample { 9, 9, 9 }
        local _, _, _, facts = ylm.light_field(1, g, { 0, 0, 0 })
        local words = { g.stats.points, g.lmax, g:locate { 0, 0, 0 }.index, report.outside, facts.pairs,
          ylm.info().threads > 0 and 1 }
        assert(table.concat(words, " "):find "^27 1 8 1 %d+ 1$", table.concat(words, " "))
        collectgarbage() collectgarbage()
        io.write "good"]])
      assert.equal("good", out)
      assert.equal(0, code)
    end)

    for _, other in ipairs(abis) do
      if other ~= abi then
        it(("refuses the objects of %s under %s"):format(other, lua), function()
          if not present(lua, abi) then pending(lua .. " is not installed") end
          if not present(other, other) then pending(other .. " is not installed") end
          local out, code = run(lua, other, 'require "ylm.c.core"')
          assert.equal(1, code, out)
          assert.truthy(out:find("version mismatch") or out:find("undefined symbol") or out:find("LUA_CPATH")
            or out:find("core not compatible"), out)
        end)
      end
    end
  end
end)
