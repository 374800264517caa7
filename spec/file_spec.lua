local ylm = require "ylm"
local core = require "ylm.c.core"
local pictures = require "spec.support.pictures"
local scratch = require "spec.support.scratch"

describe("array files", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function path(name) return folder.path .. "/" .. name end

  --- An .npy file with this header text.
  local function npy(header, data, version)
    local n = #header
    local length = string.char(n % 256, math.floor(n / 256)) .. ((version or 1) > 1 and "\0\0" or "")
    return folder:write("a.npy", "\147NUMPY" .. string.char(version or 1) .. "\0" .. length .. header .. (data or ""))
  end

  it("come back as they were: shape, element type, numbers", function()
    for _, dtype in ipairs { "float", "double" } do
      for _, shape in ipairs { { 5 }, { 2, 3 }, { 0, 3 }, { 2, 1, 3, 1, 2 } } do
        local count, random, numbers = 1, pictures.random(#shape), {}
        for i = 1, #shape do count = count * shape[i] end
        for i = 1, count do numbers[i] = random() end
        local a = count == 0 and ylm.zeros(shape, dtype) or ylm.array(numbers, dtype):reshape(shape)
        assert.is_true(a:save(path "a.npy"))
        local b = assert(ylm.load(path "a.npy"))
        assert.same(shape, b.shape)
        assert.equal(dtype, b.dtype)
        assert.equal(0, (core.array_distance(a, b)))
      end
    end
  end)

  it("look to NumPy as NumPy's own do", function()
    assert.is_true(ylm.array({ { 1, 2 }, { 3, 4 } }, "float"):save(path "n.npy"))
    local text = folder:read "n.npy"
    assert.equal("\147NUMPY\1\0", text:sub(1, 8))
    assert.truthy(text:find("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }", 1, true))
    assert.equal(0, (#text - 16) % 64)
    assert.equal("\n\0\0\128\63", text:sub(#text - 16, #text - 12))
  end)

  it("keep the convention of coefficients, in a comment", function()
    local a = ylm.array { 1, 2, 3, 4 }
    core.array_set_convention(a, 5)
    assert.is_true(a:save(path "c.npy"))
    assert.equal(5, (select(3, core.array_info(ylm.load(path "c.npy")))))
  end)

  it("are read in both byte orders and all versions", function()
    local big = npy("{'shape': (2,), 'descr': '>f8', 'fortran_order': False}\n",
      "\63\248\0\0\0\0\0\0\192\0\0\0\0\0\0\0", 2)
    assert.same({ 1.5, -2 }, ylm.load(big):totable())
    local single = npy('{"shape": (), "descr": "<f4", "fortran_order": False, }\n', "\0\0\128\63", 3)
    assert.same({ 1 }, ylm.load(single):totable())
  end)

  it("are refused in words where they hold something else", function()
    for header, says in pairs {
      ["{'descr': '<i8', 'fortran_order': False, 'shape': (1,), }"] = "elements are '<i8'; only float32",
      ["{'descr': '<f4', 'fortran_order': True, 'shape': (1,), }"] = "Fortran order is not supported",
      ["{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }"] = "truncated: 4 bytes of elements",
      ["{'descr': '<f4', 'fortran_order': False, 'shape': (), 'x': 1}"] = "damaged .npy header",
      ["{'descr': '<f4', 'fortran_order': False}"] = "a key is missing",
      ["{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999, 99999999999), }"] = "too large",
      ["{'descr': '<f4', 'fortran_order': False, 'shape': (1,1,1,1,1,1,1,1,1), }"] = "more than 8 axes",
      ["{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (1,), }"] = "damaged .npy header",
    } do
      local a, message, code = ylm.load(npy(header .. "\n", "\0\0\0\0"))
      assert.is_nil(a)
      assert.truthy(message:find(says, 1, true), message)
      assert.truthy(code == "EFORMAT" or code == "ELIMIT")
    end
    assert.is_nil((ylm.load(folder:write("v.npy", "\147NUMPY\9\0\0\0\0\0"))))
  end)

  it("survive truncation (always refused) and altered bytes", function()
    assert.is_true(ylm.array({ { 1, 2, 3 }, { 4, 5, 6 } }):save(path "t.npy"))
    pictures.spoil(folder:read "t.npy", 400, 4, function(bad, what)
      local a, message = ylm.load(folder:write("bad.npy", bad))
      assert(a == nil or not what:find "truncated", what)
      assert(a or message:find("bad.npy", 1, true), message)
    end)
  end)

  it("leave an existing file as it was when the disk is full", function()
    assert.is_true(ylm.array { 1 }:save(path "kept.npy"))
    local before = folder:read "kept.npy"
    local out = pictures.on_full_disk(scratch,
      ([[print(require "ylm".zeros { 9999 }:save(%q))]]):format(path "kept.npy"))
    assert.truthy(out:find "^nil\t.*cannot be written: .*\tEIO", out)
    assert.equal(before, folder:read "kept.npy")
  end)

  it("load what they are by content, and say what is not known", function()
    assert.is_true(ylm.image { size = { 4, 4 } }:save(path "x.png"))
    assert(scratch.shell(("cp %s %s"):format(scratch.quote(path "x.png"), scratch.quote(path "x.npy"))))
    assert.equal("ylm.image", core.type(ylm.load(path "x.npy")))
    for text, code in pairs { ["hello"] = "EFORMAT", [""] = "EFORMAT", ["\0\0\0\0"] = "EFORMAT" } do
      local object, message, got = ylm.load(folder:write("unknown", text))
      assert.is_nil(object)
      assert.equal(code, got)
      assert.truthy(message:find "unknown: ", message)
    end
    assert(scratch.shell("mkfifo " .. scratch.quote(path "pipe")))
    for _, name in ipairs { "pipe", "missing", "." } do
      local object, message, got = ylm.load(path(name))
      assert.is_nil(object)
      assert.equal("EIO", got)
      assert.truthy(message:find(path(name), 1, true), message)
    end
  end)
end)
