-- All that Lua keeps of an object stands in the own table of the object, and goes with it.

local core = require "ylm.c.core"
local grid_object = require "ylm.grid.object"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local lamp = ylm.sphere_light { at = { 0, 2, 0 } }

--- A small grid of that lamp.
local function bake(dynamic)
  return ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1, dynamic = dynamic }, lamp)
end

local function collect() for _ = 1, 4 do collectgarbage() end end

--- Calls f with a value whose collection shows, in a function that has returned, so that no stack holds it; returns its results,
-- behind a function that says whether that value has been collected.
local function watch(f)
  local seen = setmetatable({}, { __mode = "v" })
  local function call()
    seen[1] = ylm.zeros { 1 }
    return f(seen[1])
  end
  return function()
    collect()
    return seen[1] == nil
  end, call()
end

describe("own", function()
  local values = {
    ["an array"] = function() return ylm.zeros { 2 } end,
    ["a grid"] = bake,
    ["an image"] = function() return ylm.image { size = { 1, 1 } } end,
    ["a table"] = function() return {} end,
    ["a form"] = function() return ylm.matte { albedo = 0.5 } end,
    ["a function"] = function()
      local own = {} -- closures without values of their own are one object in Lua 5.2 and 5.3
      return function() return own end
    end,
  }

  for kind, make in pairs(values) do
    it("is one table of " .. kind .. ", which others do not share", function()
      local a, b = make(), make()
      assert.is_nil(core.owned(a, "test"))
      core.own(a).test = 1
      assert.equal(1, core.owned(a, "test"))
      assert.equal(core.own(a), core.own(a))
      assert.is_nil(core.owned(b, "test"))
      assert.is_nil(core.own(b).test)
    end)

    it("stays and goes with " .. kind, function()
      local held = {}
      local gone = watch(function(w)
        held[1] = make()
        core.own(held[1]).test = w
      end)
      assert.is_false(gone())
      held[1] = nil
      assert.is_true(gone())
    end)
  end

  it("goes with an object that it leads back to", function()
    assert.is_true(watch(function(w)
      local x, y = bake(), bake()
      core.own(x).test, core.own(y).test, core.own(x).self = { w, y }, x, x
    end)())
  end)

  it("is dropped where the object is closed", function()
    for _, kind in ipairs { "a grid", "an array", "an image" } do
      local gone, x = watch(function(w)
        local x = values[kind]()
        core.own(x).test = w
        x:close()
        return x
      end)
      assert.is_nil(core.owned(x, "test"))
      assert.is_true(gone())
    end
  end)

  it("leaves views of an array the owner of their elements", function()
    local image = ylm.image { size = { 2, 2 } }
    local a = image:layer "radiance"
    core.own(a).test = 1
    local row = a[1]
    assert.is_nil(core.owned(row, "test"))
    image, a = nil, nil -- luacheck: ignore
    collect()
    assert.equal(0, row:get(1, 1))
  end)

  it("has fields of two objects, which either of them ends", function()
    local held = { bake(), bake() }
    local gone = watch(function(w) core.between(held[1], held[2]).test = w end)
    assert.is_false(gone())
    local function look(x, y)
      assert.equal(core.between(x, y), core.between(x, y))
      assert.not_equal(core.between(x, y), core.between(y, x))
      assert.same({ y }, core.partners(x))
    end
    look(held[1], held[2])
    held[2] = nil
    assert.is_true(gone())
    assert.same({}, core.partners(held[1]))
    assert.same({}, core.partners(bake()))
    held[2] = bake()
    gone = watch(function(w) core.between(held[1], held[2]).test = w end)
    held[1] = nil
    assert.is_true(gone())
  end)

  it("is of no number, and reading makes no table", function()
    assert(not pcall(core.own, 1))
    assert(not pcall(core.own, nil))
    assert(not pcall(core.between, {}, "x"))
    assert.is_nil(core.owned(1, "x"))
    assert.is_nil(core.owned(nil, "x"))
    assert.is_nil(core.owned(io.stdout, "x"))
    core.own(io.stdout).test = 1
    assert.equal(1, core.owned(io.stdout, "test"))
    assert(io.stdout:write "")
  end)

  it("has the fields of a grid that lua/ylm/grid/object.lua lists", function()
    local dynamic = bake(true)
    dynamic:update(ylm.sphere_light { at = { 0, 3, 0 } })
    local folder = scratch.new()
    assert(dynamic:save(folder.path .. "/g.ylm"))
    local loaded, found = assert(ylm.load(folder.path .. "/g.ylm")), {}
    folder:remove()
    for _, grid in ipairs { bake(), dynamic, loaded } do
      for field in pairs(core.own(grid)) do
        assert(grid_object.own[field], field)
        found[field] = true
      end
    end
    assert(found.lights and found.path)
  end)
end)
