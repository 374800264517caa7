-- Arithmetic of arrays, their parts, their sums, their bytes.

local ylm = require "ylm"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"

local inf, nan = math.huge, 0 / 0

--- An array of that shape whose numbers tell their places.
local function counted(shape, dtype)
  local n = 1
  for _, extent in ipairs(shape) do n = n * extent end
  local list = {}
  for i = 1, n do list[i] = i end
  return ylm.array(list, dtype):reshape(shape)
end

describe("arithmetic of arrays", function()
  it("has the operators of Lua, with numbers and tables on either side", function()
    local a = ylm.array({ { 1, 2, 3 }, { 4, 5, 6 } }, "float")
    assert.same({ { 2, 4, 6 }, { 8, 10, 12 } }, (a + a):totable())
    assert.same({ { 9, 8, 7 }, { 6, 5, 4 } }, (10 - a):totable())
    assert.same({ { 2, 4, 6 }, { 8, 10, 12 } }, (2 * a):totable())
    assert.same({ { 1, 1, 1 }, { 4, 2.5, 2 } }, (a / { 1, 2, 3 }):totable())
    assert.same({ { 1, 4, 9 }, { 16, 25, 36 } }, (a ^ 2):totable())
    assert.same({ { 2, 4, 8 }, { 16, 32, 64 } }, (2 ^ a):totable())
    assert.same({ { -1, -2, -3 }, { -4, -5, -6 } }, (-a):totable())
    assert.same({ 0, 1, 2 }, (a[1] - { 1, 1, 1 }):totable())
    assert.equal("float", (2.5 * a).dtype)
    assert.same({ 1, 2, 3 }, a[1]:totable()) -- operands stay
  end)

  it("broadcasts as NumPy does: aligned at the last axes, extents equal or 1", function()
    local seed = 1
    local function random(n)
      seed = seed * 16807 % 2147483647
      return seed % n
    end
    --- Number of `a` at the indices of a shape that it broadcasts to.
    local function at(a, index)
      local own, own_index = a.shape, {}
      for k = 1, #own do
        local i = index[#index - #own + k]
        own_index[k] = own[k] == 1 and 1 or i
      end
      return a:get((table.unpack or unpack)(own_index)) -- luacheck: ignore 113
    end
    for _ = 1, long(40, 2000) do
      local axes, shape, sa, sb = 1 + random(4), {}, {}, {}
      for k = 1, axes do
        shape[k] = 1 + random(3)
        sa[k], sb[k] = random(3) == 0 and 1 or shape[k], random(3) == 0 and 1 or shape[k]
      end
      for _ = 1, random(axes) do table.remove(sa, 1) end
      local types = { "float", "double", "int32", "float16" }
      local a, b = counted(sa, types[1 + random(4)]), counted(sb, types[1 + random(4)])
      local c = a * 10 + b
      local index = {}
      local function walk(k)
        if k > #c.shape then
          assert.equal(at(a, index) * 10 + at(b, index), c:get((table.unpack or unpack)(index))) -- luacheck: ignore 113
          return
        end
        for i = 1, c.shape[k] do
          index[k] = i
          walk(k + 1)
        end
        index[k] = nil
      end
      walk(1)
    end
    local wide = counted({ 1000, 3 }) + counted { 3 } -- more than one chunk, and a period that does not divide it
    assert.equal(1 + 1, wide:get(1, 1))
    assert.equal(3000 + 3, wide:get(1000, 3))
    local tall = counted({ 700, 5 }) * counted { 700, 1 }
    assert.equal(3496 * 700, tall:get(700, 1))
    assert.same({ 0, 3 }, (ylm.zeros { 0, 1 } + { 1, 2, 3 }).shape)
  end)

  it("is the same for many threads and few", function()
    local n = 2 ^ 19 + 17
    local a = counted { n }
    local b = a * a - a
    assert.equal(n * n - n, b:get(n))
    assert.equal(0, (b - a * (a - 1)):abs():max())
  end)

  it("computes int32 in double and float16 in float", function()
    local i, h = ylm.array({ 2147483647, -7 }, "int32"), ylm.array({ 0.5, 65504 }, "float16")
    assert.equal("double", (i + i).dtype)
    assert.equal(4294967294, (i + i):get(1))
    assert.equal("float", (h * 2).dtype)
    assert.equal(131008, (h * 2):get(2))
    assert.equal("double", (h + i).dtype)
    assert.same({ 7, 2 }, ylm.array(ylm.array { 7, 2 }, "int32"):totable())
    assert.same({ -0.5, -65504 }, (-h):totable())
    assert.equal(65504.5, h:sum())
    assert.equal("double", ylm.sh.eval(1, ylm.array({ { 0, 0, 1 } }, "int32")).dtype)
  end)

  it("says where memory runs out: operators raise, methods return nil, message, code", function()
    local a, b = ylm.zeros { 2 ^ 22, 1 }, ylm.zeros { 2 ^ 22 } -- 2^47 bytes of both
    local ok, message = pcall(function() return a + b end)
    assert.is_false(ok)
    assert.truthy(message:find("array_math_spec.lua:%d+: array %+: memory ran out"), message)
    local mask, why, code = a:less(b)
    assert.is_nil(mask)
    assert.equal("memory ran out", why)
    assert.equal("ENOMEM", code)
  end)

  it("compares by methods, with masks as results", function()
    local a = ylm.array { 1, 2, 3, nan }
    assert.same({ 1, 0, 0, 0 }, a:less(2):totable())
    assert.same({ 1, 1, 0, 0 }, a:less_equal(2):totable())
    assert.same({ 0, 0, 1, 0 }, a:greater({ 2, 2, 2, 2 }):totable())
    assert.same({ 0, 1, 1, 0 }, a:greater_equal(2):totable())
    assert.same({ 0, 1, 0, 0 }, a:equal(2):totable())
    assert.same({ 1, 0, 1, 1 }, a:not_equal(2):totable())
    assert.equal("float", a:less(2).dtype)
    assert.same({ 1, 3 }, a:select(a:less(4) * a:not_equal(2)):totable())
    local image = counted { 2, 2, 3 }
    assert.same({ { 4, 5, 6 }, { 7, 8, 9 } }, image:select(ylm.array { { { 0 }, { 1 } }, { { 1 }, { 0 } } }):totable())
    assert.same({ 0, 3 }, image:select({ { 0, 0 }, { 0, 0 } }).shape)
  end)

  it("bounds, takes roots and drops signs", function()
    local a = ylm.array({ -4, 0, 9, 100 }, "float")
    assert.same({ 0, 0, 9, 10 }, a:clamp(0, 10):totable())
    assert.same({ -4, 0, 9, 50 }, a:clamp(nil, 50):totable())
    assert.same({ 4, 0, 9, 100 }, a:abs():totable())
    local root = a:sqrt()
    assert.is_true(root:get(1) ~= root:get(1) and root:get(3) == 3)
    local clamped = ylm.array({ nan }):clamp(0, 1):get(1)
    assert.is_true(clamped ~= clamped)
  end)
end)

describe("arrays with a convention", function()
  local n3d = ylm.sh.convert({ 1, 2, 3, 4 }, "n3d")

  it("keep it through operators, slices of rows and sums over rows", function()
    for _, c in ipairs { n3d * 2, n3d + n3d, -n3d, 1 - n3d, n3d:abs(), n3d:clamp(0), n3d * { 1, 0, 0, 0 }, { 1, 1, 1, 1 } * n3d,
      ylm.stack({ n3d, n3d })[1], ylm.stack({ n3d, n3d }):sum(1), ylm.stack({ n3d, n3d })[{ 1, 1 }] } do
      assert.equal("n3d", c.convention)
    end
    assert.equal("ylm", n3d:less(1).convention)
    assert.equal("ylm", ylm.stack({ n3d, n3d }):sum(2).convention)
    assert.equal("ylm", ylm.stack({ n3d, n3d })[{ {}, 1 }].convention)
  end)
end)

describe("sums along axes", function()
  it("are of all numbers, of an axis, of several", function()
    local a = counted { 2, 3, 4 }
    assert.equal(300, a:sum())
    assert.equal(12.5, a:mean())
    assert.equal(1, a:min())
    assert.equal(24, a:max())
    assert.same({ { 14, 16, 18, 20 }, { 22, 24, 26, 28 }, { 30, 32, 34, 36 } }, a:sum(1):totable())
    assert.same({ { 5, 6, 7, 8 }, { 17, 18, 19, 20 } }, a:mean(2):totable())
    assert.same({ { 4, 8, 12 }, { 16, 20, 24 } }, a:max(-1):totable())
    assert.same({ 66, 72, 78, 84 }, a:sum { axis = { 1, 2 } }:totable())
    assert.same({ 68, 100, 132 }, a:sum { axis = { 3, 1 } }:totable())
    assert.same({ 66, 72, 78, 84 }, a:sum(1, 2):totable())
    assert.same({ 8.5, 12.5, 16.5 }, a:mean(-1, 1):totable())
    assert.same({ 2, 1, 1 }, a:sum({ axis = { 2, 3 }, keep = true }).shape)
    assert.same({ 1, 1, 1 }, a:sum({ keep = true }).shape)
    assert.same({ { 1, 13 } }, (a:min { axis = { 2, 3 }, keep = true }):reshape({ 1, 2 }):totable())
    assert.equal(0, (a / a:sum { axis = -1, keep = true }):sum(-1):reshape({ 6 }):sum() - 6)
    assert.equal(6, ylm.array({ 1, 2, 3 }):sum(1))
    assert.same({ 0, 0 }, ylm.zeros({ 3, 0, 2 }):sum { axis = { 1, 2 } }:totable())
    local many = counted { 3, 700 } -- wider than the tile of sums over rows
    assert.equal(700 + 1400 + 2100, many:sum(1):get(700))
    assert.equal(2100, many:max(1):get(700))
  end)

  it("lose nothing that a double holds", function()
    assert.equal(2, ylm.array({ 1, 1e100, 1, -1e100 }):sum())
    assert.same({ 2, 2 }, ylm.stack({ { 1, 1 }, { 1e100, 1e100 }, { 1, 1 }, { -1e100, -1e100 } }):sum(1):totable())
    local tenth = ylm.zeros({ 100003 }, "float") + 0.1
    assert.equal(0, tenth:mean() - tenth:get(1))
    assert.equal(inf, ylm.array({ 1, inf }):sum())
  end)

  it("give NaN where one is there", function()
    local a = ylm.array { { 1, nan, 3 }, { 4, 5, 6 } }
    for _, x in ipairs { a:min(), a:max(), a:sum(), a:max(2):get(1), a:min(1):get(2) } do assert.is_true(x ~= x) end
    assert.equal(6, a:max(2):get(2))
  end)
end)

describe("parts of arrays", function()
  it("are views where their numbers lie together", function()
    local a = counted { 4, 3 }
    local part, shares = a:slice({ 2, 3 })
    assert.is_true(shares)
    part[1] = { 0, 0, 0 }
    assert.equal(0, a:get(2, 3))
    assert.same({ { 7, 8, 9 }, { 10, 11, 12 } }, a[{ -2, -1 }]:totable())
    assert.is_true(select(2, a:slice(4, { 1, 2 })))
    assert.same({ 12, false }, { a:slice(-1, -1) })
    a = a:slice({ 3, 4 }) -- the parent is collected
    collectgarbage()
    collectgarbage()
    assert.same({ { 7, 8, 9 }, { 10, 11, 12 } }, a:totable())
  end)

  it("are copies elsewhere", function()
    local a = counted { 4, 3 }
    local column, shares = a:slice({}, 2)
    assert.is_false(shares)
    assert.same({ 2, 5, 8, 11 }, column:totable())
    assert.same({ { 1, 3 }, { 7, 9 } }, a[{ { 1, 4, 2 }, { 1, 3, 2 } }]:totable())
    assert.same({ { 12, 11, 10 } }, a[{ { -1, -1 }, { 3, 1, -1 } }]:totable())
    assert.same({ 0, 3 }, a[{ 3, 2 }].shape)
    assert.same({ { 10, 11, 12 }, { 7, 8, 9 } }, a[{ 4, 3, -1 }]:totable())
    local h = ylm.array(counted { 3, 2 }, "float16")
    assert.same({ 2, 4, 6 }, h[{ {}, 2 }]:totable())
    assert.equal("float16", h[{ {}, 2 }].dtype)
  end)

  it("are written to, view or not", function()
    local a = counted({ 3, 4 }, "float")
    a[{ {}, 2 }] = { -1, -2, -3 }
    a[{ { 1, 2 }, { 3, 4 } }] = 0
    a[3] = ylm.array({ 9, 9, 9, 9 }, "int32")
    assert.same({ { 1, -1, 0, 0 }, { 5, -2, 0, 0 }, { 9, 9, 9, 9 } }, a:totable())
    a[{ {}, { 4, 1, -1 } }] = a -- the source shares its memory
    assert.same({ { 0, 0, -1, 1 }, { 0, 0, -2, 5 }, { 9, 9, 9, 9 } }, a:totable())
    local i = ylm.zeros({ 3 }, "int32")
    i[{ 1, 2 }] = 5
    i[3] = 6
    assert.same({ 5, 5, 6 }, i:totable())
  end)

  it("are put side by side", function()
    local a, b = counted { 2, 3 }, counted({ 2, 3 }, "float")
    local s = ylm.stack { a, b, { { 1, 2, 3 }, { 4, 5, 6 } } }
    assert.same({ 3, 2, 3 }, s.shape)
    assert.equal("double", s.dtype)
    assert.same({ 2, 2, 3 }, ylm.stack({ b, b }, 2).shape)
    assert.same({ { 1, 1 }, { 2, 2 }, { 3, 3 } }, ylm.stack({ b, b }, -1)[1]:totable())
    assert.equal("int32", ylm.stack({ ylm.zeros({ 1 }, "int32"), ylm.zeros({ 1 }, "int32") }).dtype)
  end)
end)

describe("element types", function()
  it("of float16 round to nearest, ties to even, as IEEE 754 says", function()
    local function half(x) return ylm.array({ x }, "float16"):get(1) end
    for x, y in pairs { [1] = 1, [2049] = 2048, [2051] = 2052, [65519] = 65504, [2 ^ -24] = 2 ^ -24, [2 ^ -25] = 0,
      [3 * 2 ^ -25] = 2 ^ -23, [2 ^ -25 + 2 ^ -60] = 2 ^ -24, [1 + 2 ^ -11] = 1, [1 + 2 ^ -11 + 2 ^ -50] = 1 + 2 ^ -10,
      [1023.75 * 2 ^ -24] = 2 ^ -14, [inf] = inf, [-inf] = -inf, [-0.25] = -0.25 } do
      assert.equal(y, half(x))
    end
    local n = half(nan)
    assert.is_true(n ~= n)
    local all = {} -- every finite number of the type comes back
    for bits = 0, 31743, long(7, 1) do all[#all + 1] = string.char(bits % 256, math.floor(bits / 256)) end
    local a = ylm.array.frombytes(table.concat(all), { #all }, "float16")
    assert.equal(a:bytes(), ylm.array(ylm.array(a, "double"), "float16"):bytes())
    assert.equal(a:bytes(), ylm.array(ylm.array(a, "float"), "float16"):bytes())
  end)

  it("go to bytes and back", function()
    for _, dtype in ipairs { "float", "double", "int32", "float16" } do
      local a = counted({ 3, 5 }, dtype)
      local b = ylm.array.frombytes(a:bytes(), { 3, 5 }, dtype)
      assert.equal(dtype, b.dtype)
      assert.same(a:totable(), b:totable())
      assert.equal(a:bytes(), b:bytes())
    end
    assert.equal("", ylm.zeros({ 0 }):bytes())
  end)

  it("go to .npy and back, and to NumPy", function()
    local folder = scratch.new()
    local lines = { "import numpy as n" }
    for dtype, code in pairs { float = "f4", double = "f8", int32 = "i4", float16 = "f2" } do
      local a, name = counted({ 2, 3 }, dtype), folder.path .. "/" .. dtype .. ".npy"
      assert.is_true(a:save(name))
      local b = assert(ylm.load(name))
      assert.equal(dtype, b.dtype)
      assert.same(a:totable(), b:totable())
      lines[#lines + 1] = ("a = n.load('%s'); assert a.dtype == n.%s and a.tolist() == [[1, 2, 3], [4, 5, 6]]"):format(name,
        ({ f4 = "float32", f8 = "float64", i4 = "int32", f2 = "float16" })[code])
      lines[#lines + 1] = ("n.save('%s/big_%s.npy', a[:, ::2].astype('>%s'))"):format(folder.path, dtype, code)
    end
    local script = folder:write("try.py", table.concat(lines, "\n"))
    if not scratch.shell "python3 -c 'import numpy' 2>/dev/null" then pending "NumPy is not installed" end
    local out, status = scratch.capture("python3 " .. script)
    assert.equal(0, status, out)
    for _, dtype in ipairs { "float", "double", "int32", "float16" } do
      local b = assert(ylm.load(folder.path .. "/big_" .. dtype .. ".npy"))
      assert.equal(dtype, b.dtype)
      assert.same({ { 1, 3 }, { 4, 6 } }, b:totable())
    end
    folder:remove()
  end)
end)

describe("arrays over the memory of others", function()
  it("share it, and keep its owner until their last view is gone", function()
    local owner = ylm.array { { 1, 2 }, { 3, 4 } }
    local kept = setmetatable({ owner }, { __mode = "v" })
    local a = ylm.wrap(owner:pointer(), { 2, 2 }, "double", owner)
    a:set(1, 2, 7)
    assert.equal(7, owner:get(1, 2))
    owner = nil -- luacheck: ignore 311
    local row = a[2]:reshape { 2, 1 }
    a:close()
    a = nil -- luacheck: ignore 311
    collectgarbage()
    collectgarbage()
    assert.truthy(kept[1])
    assert.same({ { 3 }, { 4 } }, row:totable())
    row = nil -- luacheck: ignore 311
    collectgarbage()
    collectgarbage()
    assert.is_nil(kept[1])
  end)
end)

describe("arrays in words", function()
  it("are their shape and first numbers", function()
    assert.equal("ylm.array float [2][3]: 1 2 3; 4 5 6", tostring(counted({ 2, 3 }, "float")))
    assert.equal("ylm.array double [100]: 1 2 3 4 5 6 7 8 ...", tostring(counted { 100 }))
    assert.equal("ylm.array float [4]: nan nan inf -inf", tostring(ylm.array({ nan, -nan, inf, -inf }, "float")))
    assert.equal("ylm.array int32 [0][3]", tostring(ylm.zeros({ 0, 3 }, "int32")))
    assert.equal("ylm.array double [4], n3d: 3.54491 -0 0 -0", tostring(ylm.sh.convert({ 1, 0, 0, 0 }, "n3d")))
  end)

  it("stay out of scene files, whose tables are counted instead", function()
    local folder = scratch.new()
    for _, text in ipairs { "ylm", "array {1}", "zeros {1}", "wrap(8, {1})", "stack {}" } do
      local scene, message = ylm.load(folder:write("s.lua", ("local a = %s\nreturn scene 'x' {}"):format(text)))
      assert.is_nil(scene)
      assert.truthy(message:find("there is no '", 1, true), message)
    end
    folder:remove()
  end)
end)
