-- The field protocol: what light fields may be asked stands in one file, and functions, lights and lists answer alike.

local field = require "ylm.field"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

--- Fields of metatables that are Lua's own, or the library's for its userdata.
local of_lua = {}
for name in ("index newindex tostring len eq gc mode metatable close add sub mul div pow unm concat call pairs name lt le")
  :gmatch "%a+" do
  of_lua["__" .. name] = true
end

describe("the field protocol", function()
  it("lists every field of metatables by which Lua asks objects", function()
    local asked = {}
    for _, path in ipairs(scratch.lines "find lua/ylm -name '*.lua' -not -path '*/gen/*'") do
      local n = 0
      for line in io.lines(path) do
        n = n + 1
        for name in line:gmatch "[%.\"](__%l[%w_]*)" do
          asked[name] = true
          assert(of_lua[name] or field.protocol[name], ("%s:%d: %s is missing in field.protocol"):format(path, n, name))
        end
      end
    end
    for name in pairs(field.protocol) do
      assert(asked[name] or name == "__field" or name == "__kind", name .. ": asked by nobody")
    end
  end)

  local lamp = ylm.sphere_light { at = { 0, 2, 0 } }

  it("wraps functions, lights and lists alike", function()
    for _, x in ipairs { lamp, { lamp, { lamp } }, function() end } do
      local f = assert(field.of(1, "spec", x))
      assert.equal("lights", (f:quantity(1, "spec")))
      assert.is_nil(f:walls())
      assert.equal(f, f:for_bake {})
      assert.is_false(f:answers "__for_grid")
      assert.is_nil(f:tally()())
    end
    assert.equal("all", (field.of(1, "spec", function() end):quantity(1, "spec", "all")))
    assert(field.of(1, "spec", lamp):followed() and not field.of(1, "spec", function() end):followed())
    assert.has_error(function() field.of(1, "spec", lamp):quantity(1, "spec", "all") end)
  end)
end)
