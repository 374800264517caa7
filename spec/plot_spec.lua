-- Line plots and figures made of pictures.

local core = require "ylm.c.core"
local picture = require "ylm.picture"
local colours = require "spec.support.pixels"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

if not picture.vtk() then
  describe("ylm.plot", function() it("draws", function() pending "VTK is not built in" end) end)
  return
end

local pixel, difference = colours.at, colours.difference

local function flat(h, w, rgb)
  local t = {}
  for i = 1, h do
    t[i] = {}
    for j = 1, w do t[i][j] = { rgb[1], rgb[2], rgb[3] } end
  end
  return ylm.array(t, "float")
end

describe("ylm.plot", function()
  it("draws points where its axes say: linear", function()
    local p = ylm.plot { size = { 320, 240 }, series = { { x = { 0, 1, 2 }, y = { 0, 4, 1 }, colour = { 1, 0, 0 },
      width = 4 } } }
    local pixels = assert(p:pixels())
    for _, q in ipairs { { 0, 0 }, { 1, 4 }, { 2, 1 }, { 0.5, 2 }, { 1.5, 2.5 } } do
      local c = pixel(pixels, p:where(q[1], q[2]))
      assert(difference(c, { 1, 0, 0 }) < 0.1, ("(%g, %g) is (%.2f %.2f %.2f)"):format(q[1], q[2], c[1], c[2], c[3]))
    end
    assert(difference(pixel(pixels, p:where(0.5, 3.6)), { 1, 1, 1 }) < 0.15)
  end)

  it("draws points where its axes say: logarithmic, a power law is a straight line", function()
    local p = ylm.plot { size = { 320, 240 }, log = true, legend = "none",
      series = { { x = { 1, 1000 }, y = { 1e-4, 1e2 }, colour = { 0, 0, 1 }, width = 4, marker = "none" } } }
    local pixels = assert(p:pixels())
    for _, q in ipairs { { 2, 4e-4 }, { 10, 1e-2 }, { 100, 1 }, { 500, 25 } } do
      assert(difference(pixel(pixels, p:where(q[1], q[2])), { 0, 0, 1 }) < 0.15, q[1])
    end
  end)

  it("draws lines whose numbers hardly differ, and flat ones where they differ by rounding alone", function()
    for _, log in ipairs { false, true } do
      local p = ylm.plot { size = { 300, 200 }, y_log = log,
        series = { { x = { 1, 2, 3 }, y = { 500, 500.001, 500.0002 }, colour = { 1, 0, 0 }, marker = "none", width = 4 } } }
      local pixels = assert(p:pixels())
      for _, q in ipairs { { 1.5, 500.0005 }, { 2.5, 500.0006 } } do
        assert(difference(pixel(pixels, p:where(q[1], q[2])), { 1, 0, 0 }) < 0.2, q[1])
      end
      p = ylm.plot { size = { 300, 200 }, y_log = log,
        series = { { x = { 1, 2, 3 }, y = { 500, 500 * (1 + 1e-12), 500 }, colour = { 1, 0, 0 }, marker = "none", width = 4 } } }
      pixels = assert(p:pixels())
      for _, x in ipairs { 1.2, 2, 2.8 } do
        local c = pixel(pixels, p:where(x, 500))
        assert(difference(c, { 1, 0, 0 }) < 0.3, ("%g is (%.2f %.2f %.2f)"):format(x, c[1], c[2], c[3]))
      end
    end
  end)

  it("leaves out what a logarithmic axis cannot show, and NaN", function()
    local p = ylm.plot { size = { 200, 150 }, log = true, x = { -1, 0, 1, 10, 0 / 0 }, y = { 1, 1, 1, 10, 1 } }
    assert(p:pixels())
    assert(p.axes.x[1] > 0.5 and p.axes.x[2] < 20)
    assert(ylm.plot({ size = { 200, 150 }, log = true, x = { -1 }, y = { -1 } }):pixels())
  end)

  it("marks a series of one point", function()
    local p = ylm.plot { size = { 200, 150 }, series = { { x = { 1, 2, 3 }, y = { 0 / 0, 3, 0 / 0 },
      colour = { 1, 0, 0 } } } }
    local pixels = assert(p:pixels())
    assert(difference(pixel(pixels, p:where(2, 3)), { 1, 0, 0 }) < 0.1)
  end)

  it("writes nothing between integers where all numbers are integers", function()
    local p = ylm.plot { size = { 480, 240 }, x = { 1, 2, 3 }, y = { 0.5, 1, 2 } }
    assert(p:pixels())
    assert.same({ "1", "2", "3" }, p.axes.labels.x)
    p = ylm.plot { size = { 480, 240 }, x = { 1, 2.5, 3 }, y = { 0.5, 1, 2 } }
    assert(p:pixels())
    assert.is_true(#p.axes.labels.x > 3)
    p = ylm.plot { size = { 480, 240 }, x = { 1, 2 }, x_range = { 1, 1.5 }, y = { 0.5, 1 } }
    assert(p:pixels())
    assert.is_true(#p.axes.labels.x > 1)
  end)

  it("dashes the diagonal: some pixels on it, some not", function()
    local p = ylm.plot { size = { 320, 240 }, log = true, diagonal = true, x = { 1e-3, 1 }, y = { 1e-4, 1e-4 },
      x_range = { 1e-3, 1 }, y_range = { 1e-4, 1 } }
    local pixels, on, off = assert(p:pixels()), 0, 0
    for i = 1, 200 do
      local v = 10 ^ (-2.9 + 2.8 * i / 200)
      local c = pixel(pixels, p:where(v, v))
      if c[1] < 0.75 then on = on + 1 else off = off + 1 end
    end
    assert(on > 40 and off > 40, ("%d dark, %d light"):format(on, off))
  end)

  it("shows titles, labels, legends in both themes", function()
    for _, background in ipairs { "dark", "white" } do
      local bare = ylm.plot { size = { 320, 240 }, x = { 1, 2 }, y = { 1, 2 }, background = background }
      local full = ylm.plot { size = { 320, 240 }, background = background, title = "T", x_label = "x [m]",
        y_label = "y [s]",
        caption = "c", series = { { x = { 1, 2 }, y = { 1, 2 }, label = "series" }, { x = { 1, 2 }, y = { 2, 1 } } } }
      local distance = core.array_distance(assert(bare:pixels()), assert(full:pixels()))
      assert(distance > 0.5)
      assert(difference(pixel(full:pixels(), 1, 1), picture.themes[background].background) < 0.01)
    end
  end)
end)

describe("ylm.figure", function()
  it("is as wide as its title and the words of its captions need", function()
    local small = { image = flat(8, 8, { 1, 0, 0 }), caption = "polynomials" }
    local bare = assert(ylm.figure({ rows = { { { image = small.image }, { image = small.image } } } }):pixels())
    local titled = assert(ylm.figure({ rows = { { small, small } }, title = "A title of a figure" }):pixels())
    local width = picture.text(nil, "polynomials", 0, 0, { size = 11 })
    assert.equal(160, bare.shape[2])
    assert.is_true(titled.shape[2] >= 2 * width + 48, titled.shape[2])
    assert.is_true(titled.shape[2] >= picture.text(nil, "A title of a figure", 0, 0, { size = 14, bold = true }) + 48)
  end)

  local red, green, blue = { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }

  it("places images at their own size, row by row", function()
    local f = ylm.figure { rows = { { flat(20, 60, red), flat(20, 30, green) }, { flat(10, 100, blue) } }, margin = 5,
      gap = 10 }
    local pixels = assert(f:pixels())
    assert.equal(160, pixels.shape[2])
    f = ylm.figure { rows = { { flat(100, 300, red), flat(100, 100, green) }, { flat(10, 410, blue) } }, margin = 5,
      gap = 10 }
    pixels = assert(f:pixels())
    assert.same({ 5 + 100 + 10 + 10 + 5, 420, 3 }, pixels.shape)
    assert.same(red, pixel(pixels, 5, 5))
    assert.same(red, pixel(pixels, 304, 104))
    assert.same({ 1, 1, 1 }, pixel(pixels, 306, 50))
    assert.same(green, pixel(pixels, 315, 5))
    assert.same(blue, pixel(pixels, 200, 118))
  end)

  it("wipes from left to right at the places asked for", function()
    local f = ylm.figure { margin = 0, rows = { { { wipe = { flat(100, 200, red), flat(100, 200, green),
      flat(100, 200, blue) },
      at = { 0.25, 0.75 }, labels = { "a", "b", "c" } } } } }
    local pixels = assert(f:pixels())
    assert.same({ 100, 200, 3 }, pixels.shape)
    assert.same(red, pixel(pixels, 40, 90))
    assert.same(green, pixel(pixels, 60, 90))
    assert.same(green, pixel(pixels, 140, 90))
    assert.same(blue, pixel(pixels, 160, 90))
    assert(difference(pixel(pixels, 50, 90), { 1, 1, 1 }) < 0.2, "the edge is white")
  end)

  it("crops exactly, enlarges by repeating pixels", function()
    local t = {}
    for y = 1, 8 do t[y] = {} for x = 1, 8 do t[y][x] = { x / 8, y / 8, 0 } end end
    local f = ylm.figure { margin = 0, width = 200, rows = { { { image = ylm.array(t), crop = { 2, 4, 2, 2 } } } } }
    local pixels = assert(f:pixels())
    assert.same({ 200, 200, 3 }, pixels.shape)
    for _, q in ipairs { { 1, 1, 3, 5 }, { 98, 98, 3, 5 }, { 102, 1, 4, 5 }, { 198, 198, 4, 6 } } do
      assert(difference({ q[3] / 8, q[4] / 8, 0 }, pixel(pixels, q[1], q[2])) < 0.003, q[1])
    end
  end)

  it("shrinks by averages", function()
    local t = {}
    for y = 1, 128 do t[y] = {} for x = 1, 128 do local v = (x + y) % 2 t[y][x] = { v, v, v } end end
    local pixels = assert(ylm.figure({ margin = 0, width = 64, rows = { { ylm.array(t) } } }):pixels())
    assert(difference(pixel(pixels, 32, 32), { 0.5, 0.5, 0.5 }) < 0.01)
  end)

  it("colours numbers by its bar", function()
    local values = {}
    for y = 1, 64 do values[y] = {} for x = 1, 64 do values[y][x] = x <= 32 and 1e-3 or 1 end end
    local f = ylm.figure { margin = 0, width = 400, bar = { range = { 1e-3, 1 }, log = true, map = "viridis",
      label = "error", unit = "1" },
      rows = { { { values = values, caption = "errors" } } } }
    local pixels = assert(f:pixels())
    local ends = core.figure_colours(ylm.array { { 0 }, { 1 } }, { 0, 0, 0 }, "viridis", 0, 1, false):totable()
    assert(difference(pixel(pixels, 10, 10), ends[1]) < 0.01)
    assert(difference(pixel(pixels, 390, 10), ends[2]) < 0.01)
    assert(pixels.shape[1] > 430)
  end)

  it("takes views, plots, figures, images and files", function()
    local folder = scratch.new()
    local path = folder.path .. "/a.png"
    local image = ylm.image { size = { 64, 48 }, layers = { { "radiance", 3 } } }
    local inner = ylm.figure { rows = { { flat(48, 64, red) } }, margin = 0 }
    assert(inner:save(path))
    local f = ylm.figure { margin = 0, gap = 0, rows = { {
      path, image, inner, ylm.plot { x = { 1, 2 }, y = { 1, 2 }, size = { 160, 120 } },
      ylm.view { sh = { { 1, 0, 0, 0 } }, size = { 64, 48 } } } } }
    local pixels = assert(f:pixels())
    assert.same(red, pixel(pixels, 3, 3))
    folder:remove()
  end)

  it("writes files that come back as they were, and none where it cannot", function()
    local folder = scratch.new()
    local path = folder:write("a.png", "old")
    local f = ylm.figure { rows = { { flat(48, 64, green) } }, margin = 8, title = "T" }
    assert(f:save(path))
    local back = ylm.figure { rows = { { path } }, margin = 0 }
    assert.equal(0, (core.array_distance(assert(f:pixels()), assert(back:pixels()))))
    local good = folder:read "a.png"
    for _, damaged in ipairs { "not a picture", good:sub(1, -20), good:sub(1, 40) .. "?" .. good:sub(42) } do
      folder:write("a.png", damaged)
      local pixels, message, code = back:pixels()
      assert(pixels == nil and code == "EFORMAT", message)
    end
    folder:remove()
  end)
end)
