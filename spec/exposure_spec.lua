--- The exposure under which pictures are seen well, and pictures that are mostly black or white.

local ylm = require "ylm"

local SIZE = { 16, 8 }

local function picture(value)
  local x = ylm.image { size = SIZE }
  x:fill(1, 1, SIZE[1], SIZE[2], value)
  return x
end

describe("image:exposure", function()
  it("makes the middle of a picture grey, whatever it is", function()
    for _, stops in ipairs { -20, -3, 0, 5.5, 20 } do
      local found, shown = picture(0.18 * 2 ^ -stops):exposure()
      assert.near(stops, found, 1e-4)
      assert.are.same({ 0, 0 }, { shown.black, shown.white })
    end
  end)

  it("leaves out what is black, what is 16 times as bright, and lamps", function()
    local x = picture(0.18)
    x:fill(1, 1, 4, 8, 0)
    x:fill(5, 1, 4, 8, 1000)
    local stops, shown = x:exposure()
    assert.near(0, stops, 1e-4)
    assert.are.same({ 0.25, 0.25 }, { shown.black, shown.white })
    x = picture(0.18)
    x:add("emitter", 1)
    x:fill(1, 1, 8, 8, 1, { layer = "emitter" })
    x:fill(1, 1, 8, 8, 1)
    assert.near(0, (x:exposure()), 1e-4)
  end)

  it("is 0 of a picture without light, which is black", function()
    local stops, shown = picture(0):exposure()
    assert.are.same({ 0, 1, 0 }, { stops, shown.black, shown.white })
  end)

  it("tells black and white under another exposure, and of another layer", function()
    local x = picture(0.18)
    local _, shown = x:exposure { stops = -10 }
    assert.are.same({ 1, 0 }, { shown.black, shown.white })
    _, shown = x:exposure { stops = 5 }
    assert.are.same({ 0, 1 }, { shown.black, shown.white })
    x:add("depth", 1)
    x:fill(1, 1, SIZE[1], SIZE[2], 0.09, { layer = "depth" })
    assert.near(1, (x:exposure { layer = "depth" }), 1e-4)
  end)

  it("is what a .png is saved under, if it is asked for", function()
    local name = os.tmpname() .. ".png"
    assert(picture(0.18 / 32):save(name, { exposure = "auto" }))
    local grey = assert(ylm.load(name)):layer():get(1, 1, 1)
    os.remove(name)
    assert.near(0.18, grey, 0.005)
  end)

  it("refuses other words, and layers that are not there", function()
    for text, f in pairs {
      ["exposure must be a number from -60 to 60, or 'auto'"] = function() picture(1):save("a.png", { exposure = "best" }) end,
      ["no layer 'glow'"] = function() picture(1):exposure { layer = "glow" } end,
      ["stops must be"] = function() picture(1):exposure { stops = 100 } end,
    } do
      local ok, message = pcall(f)
      assert.is_false(ok)
      assert.is_truthy(tostring(message):find(text, 1, true), tostring(message))
    end
  end)
end)
