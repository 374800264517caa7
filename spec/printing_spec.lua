-- Objects as print shows them: reports, stats, forms, arrays.

local scratch = require "spec.support.scratch"
local ylm = require "ylm"

describe("printing", function()
  it("of a report shows each field in a line", function()
    local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 1 }, lamp)
    local text = "\n" .. tostring(grid.stats) .. "\n"
    for name, value in pairs(grid.stats) do
      assert.truthy(text:find("\n" .. name .. " +%S"), name .. " is missing in" .. text)
      if type(value) == "boolean" then assert.truthy(text:find("\n" .. name .. " +" .. tostring(value) .. "\n"), text) end
    end
    assert.truthy(text:find "\npoints +8\n", text)
    local _, _, _, facts = ylm.light_field(1, lamp, { 0, 0, 0 })
    assert.truthy(tostring(facts):find "^inside +.+\npairs +1$", tostring(facts))
    local a = ylm.image { size = { 4, 4 } }
    assert.truthy(("\n" .. tostring(a:compare(a))):find "\nrmse +0\n")
    local s = ylm.scene "s" { geometry = ylm.box {}, lights = lamp }
    assert.truthy(tostring(s:links({ spacing = 0.5, rays = 4 }).stats):find "elements +%d+\n")
    local nested = require "ylm.show".report { rays = { primary = 3, shadow = 4 }, notes = { "a\27[31m" }, x = 0 / 0 }
    assert.equal("notes  {a?[31m}\nrays   { primary = 3, shadow = 4 }\nx      nan", tostring(nested))
  end)

  it("of forms and shapes shows the fields that they have", function()
    assert.equal("sphere_light { at = {0, 2, 0}, radius = 0.1, radiance = {5, 5, 5} }",
      tostring(ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 5 }))
    assert.matches("^camera { from = {1, 2, 3}, at = {0, 0, 0}", tostring(ylm.camera { from = { 1, 2, 3 } }))
    assert.matches("^adaptive_grid { .*lmax = 3", tostring(ylm.adaptive_grid { lmax = 3, depth = 2, tolerance = 0.1 }))
    assert.matches("^box { mesh = ylm.mesh %d+ vertices, 12 triangles, material = ylm.matte { albedo = {0.5, 0.5, 0.5} }",
      (tostring(ylm.box { material = ylm.matte { albedo = 0.5 } })))
  end)

  it("of arrays shows up to 36 numbers whole, and array:print all", function()
    local list = {}
    for i = 1, 36 do list[i] = i end
    local a = ylm.array(list):reshape { 6, 6 }
    assert.matches("1 2 3 4 5 6; 7 8 .*; 31 32 33 34 35 36$", tostring(a))
    assert.matches(": 0 0 0 0 0 0 0; 0 %.%.%.$", tostring(ylm.zeros { 6, 7 }))
    local out = scratch.capture((os.getenv "YLM_LUA" or "lua5.4")
      .. [[ -e 'local y = require "ylm" y.array({{1,2.5},{3,4}}):print() y.zeros{2,3,2}:print() y.zeros{0,3}:print()']])
    assert.equal("ylm.array double [2][2]\n1 2.5\n3 4\nylm.array double [2][3][2]\n" .. ("0 0\n"):rep(6)
      .. "ylm.array double [0][3]\n", out)
  end)

  it("has array:same for what is compared", function()
    local a, nan = ylm.array { { 1, 2 }, { 3, 4 } }, 0 / 0
    assert.is_true((a:same(a)))
    assert.is_true((a:same({ { 1, 2 }, { 3, 4 } })))
    assert.is_true((a:same(ylm.array(a, "float"))))
    assert.is_false((a:same { 1, 2, 3, 4 }))
    assert.is_false((a:same { { 1, 2, 3, 4 } }))
    local same, largest = a:same({ { 1, 2.25 }, { 3, 4 } }, 0.2)
    assert.is_false(same)
    assert.equal(0.25, largest)
    assert.is_true((a:same({ { 1, 2.25 }, { 3, 4 } }, 0.25)))
    assert.is_false((ylm.array { nan, 1 }:same({ nan, 1 }, 9)))
    assert.is_true((ylm.zeros { 0, 3 }:same(ylm.zeros { 0, 3 })))
  end)
end)
