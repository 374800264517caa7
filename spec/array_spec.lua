local ylm = require "ylm"

describe("ylm.array", function()
  it("keeps shape, element type and numbers of nested tables", function()
    local a = ylm.array({ { 1, 2, 3 }, { 4, 5, 6 } }, "float")
    assert.same({ 2, 3 }, a.shape)
    assert.equal("float", a.dtype)
    assert.equal(2, #a)
    assert.same({ { 1, 2, 3 }, { 4, 5, 6 } }, a:totable())
  end)

  it("gives views that share numbers with their parent and outlive it", function()
    local a = ylm.array { { 1, 2 }, { 3, 4 } }
    local row = a[2]
    row[1] = 7
    assert.equal(7, a:get(2, 1))
    a:close()
    a = nil -- luacheck: ignore 311
    collectgarbage()
    collectgarbage()
    assert.same({ 7, 4 }, row:totable())
  end)

  it("converts between element types", function()
    local a = ylm.array(ylm.array({ 0.5, 0.25 }, "double"), "float")
    assert.equal("float", a.dtype)
    assert.same({ 0.5, 0.25 }, a:totable())
  end)

  it("refuses bad tables at the caller's line", function()
    local ok, message = pcall(function() ylm.array { { 1, 2 }, { 3 } } end)
    assert.is_false(ok)
    assert.truthy(message:find("array_spec.lua:%d+: bad argument #1 to 'array'"), message)
    assert.has_error(function() ylm.zeros { -1 } end)
    assert.has_error(function() ylm.zeros { 2 ^ 40, 2 ^ 40 } end)
    assert.has_error(function() ylm.array { { 1 } }:get(2, 1) end)
  end)

  it("take pointers and arrays of LuaJIT's FFI", function()
    local ok, ffi = pcall(require, "ffi")
    if not ok then return end
    local memory = ffi.new("float[6]", 1, 2, 3, 4, 5, 6)
    local a = ylm.wrap(memory, { 2, 3 }, "float")
    a:set(2, 1, 9)
    assert.equal(9, memory[3])
    assert.same({ 2, 3 }, ylm.wrap(ffi.cast("float *", memory) + 1, { 2 }, "float", memory):totable())
    memory = nil -- luacheck: ignore 311
    collectgarbage()
    collectgarbage()
    assert.equal(26, a:sum())
    assert.has_error(function() ylm.wrap(ffi.new("int64_t", 16), { 1 }) end)
    assert.has_error(function() ylm.wrap(ffi.cast("float *", nil), { 1 }) end)
  end)
end)
