local progress = require "ylm.progress"

describe("progress bars", function()
  it("are made of true only; functions stay what they are", function()
    local f = function() end
    assert.equal(f, progress.resolve(f))
    assert.is_nil(progress.resolve(nil))
    assert.is_nil(progress.resolve(false))
    assert.equal("function", type(progress.resolve(true)))
  end)

  it("show how much is done, and keep one line per stage", function()
    local out = {}
    local stream = { write = function(_, ...) for _, s in ipairs { ... } do out[#out + 1] = s end end,
      flush = function() end }
    local bar = progress.bar(stream)
    for i = 0, 10 do assert.is_true(bar(i, 10, "bake")) end
    bar(10, 10, "bake")
    bar(0, 0, "empty")
    local text = table.concat(out)
    assert.truthy(text:find("bake         %[" .. ("="):rep(30) .. "%] 100 %%  0:00\n"), text)
    assert.equal(2, select(2, text:gsub("\n", "")))
    assert.equal("x            [===============>              ]  50 %  1:01:01", progress.line(5, 10, "x", 3661))
  end)
end)
