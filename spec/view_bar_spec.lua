-- Scalar bars of views: beside the picture, in one style; and how much of its height a picture uses.

local colours = require "spec.support.pixels"
local picture = require "ylm.picture"
local views = require "spec.support.views"
local ylm = require "ylm"

if not views.vtk "bars" then return end

local difference, draw = colours.difference, views.draw

local function log10(x) return math.log(x) / math.log(10) end

--- The labels of ticks that have one.
local function labels(...)
  local named = {}
  for _, label in ipairs((select(2, picture.ticks(...)))) do
    if label ~= "" then named[#named + 1] = label end
  end
  return named
end

describe("ticks", function()
  it("of logarithmic bars are powers of ten, minor ones have no labels", function()
    local places, all = picture.ticks(2e-4, 3, true, 6)
    for i, x in ipairs(places) do
      assert.is_true(x >= 2e-4 and x <= 3)
      assert.equal(all[i] ~= "", math.abs(log10(x) - math.floor(log10(x) + 0.5)) < 1e-9)
    end
    assert.same({ "10⁻³", "10⁻²", "10⁻¹", "10⁰" }, labels(2e-4, 3, true, 6))
    assert.same({ "10⁻²⁰", "10⁻¹⁶", "10⁻¹²", "10⁻⁸", "10⁻⁴", "10⁰" }, labels(1e-20, 1e3, true, 6))
  end)

  it("of less than two powers of ten are all plain, or all with a power", function()
    assert.same({ "5", "10", "20" }, labels(3.3, 24, true, 6))
    assert.same({ "0.5", "1", "2", "5" }, labels(0.3, 5, true, 6))
    assert.same({ "2·10⁻⁶", "3·10⁻⁶", "4·10⁻⁶" }, labels(2e-6, 4e-6, true, 4))
    assert.same({ "0.32", "0.34", "0.36", "0.38", "0.40", "0.42" }, labels(0.31, 0.42, true, 6))
  end)

  it("of linear bars have as many digits each", function()
    assert.same({ "0.0", "0.5", "1.0" }, labels(0, 1, false, 3))
    assert.same({ "−3", "−2", "−1", "0", "1", "2", "3" }, labels(-3, 3, false, 6))
    assert.same({ "0", "5000", "10000", "15000" }, labels(0, 15000, false, 4))
    assert.same({ "0", "1·10⁵", "2·10⁵", "3·10⁵", "4·10⁵" }, labels(0, 4e5, false, 6))
    assert.same({ "0", "0.5·10⁻⁵", "1.0·10⁻⁵" }, labels(0, 1e-5, false, 3))
    assert.same({ "0.60006", "0.60008", "0.60010" }, labels(0.60006, 0.6001, false, 3)) -- near together, not small
    assert.same({ "2", "3", "4" }, labels(2, 4, false, 9, true))
  end)
end)

describe("texts", function()
  it("set super- and subscripts above and below the line", function()
    local core = require "ylm.c.core"
    --- First and last row with ink, in the columns from x on.
    local function ink(words, from)
      local canvas = core.canvas(200, 60, { 1, 1, 1 })
      picture.text(canvas, words, 0, 10, { size = 30, colour = { 0, 0, 0 } })
      local first, last
      for row, line in ipairs(core.canvas_pixels(canvas):totable()) do
        for x = from + 1, 200 do
          if line[x][1] < 0.5 then first, last = first or row, row end
        end
      end
      return first, last
    end
    local width = picture.text(nil, "L", 0, 0, { size = 30 })
    local top, bottom = ink("L", 0)
    local up, up_end = ink("L²", width)
    local down, down_end = ink("L₀", width)
    assert.is_true(up <= top + 1 and up_end < bottom - 6, ("%d %d beside %d %d"):format(up, up_end, top, bottom))
    assert.is_true(down > top + 6 and down_end > bottom + 1, ("%d %d beside %d %d"):format(down, down_end, top, bottom))
    local _, one = picture.text(nil, "10⁻³", 0, 0, { size = 30 })
    assert.equal(select(2, picture.text(nil, "10", 0, 0, { size = 30 })), one)
  end)
end)

--- Is the box a = {x, y, w, h} in the box b?
local function within(a, b)
  return a[1] >= b[1] and a[2] >= b[2] and a[1] + a[3] <= b[1] + b[3] and a[2] + a[4] <= b[2] + b[4]
end

describe("scalar bars", function()
  local g = views.adaptive()

  it("say what they show as a formula", function()
    local function words(quantity)
      local bar = select(2, draw { g, quantity = quantity, slices = true }):bars()[1]
      return bar.unit and bar.label .. " [" .. bar.unit .. "]" or bar.label
    end
    assert.equal("error ‖λ‖Δ²/(2‖L‖)", words "error")
    assert.equal("‖λ‖ [W m⁻² sr⁻¹ᐟ² per length²]", words "lambda")
    assert.equal("|∇L₀₀| [W m⁻² sr⁻¹ᐟ² per length]", words "gradient")
  end)

  it("never lie over the picture, at any size, one or two of them", function()
    -- A wall that fills every window; what is not of its colour is no picture.
    local wall = { ylm.quad { corner = { -50, -50, -3 }, u = { 100, 0, 0 }, v = { 0, 100, 0 } }, colour = { 1, 0, 0 } }
    local function is_wall(c) return c[1] > 0.4 and c[2] < 0.2 and c[3] < 0.2 end
    for _, size in ipairs { { 160, 120 }, { 120, 240 }, { 64, 48 }, { 16, 90 } } do
      for _, two in ipairs { false, true } do
        local what = table.concat(size, "x") .. (two and ", two" or ", one")
        local pixels, v = draw { g, quantity = "lambda", slices = true, glyphs = two and { count = 5 }, meshes = { wall },
          size = size, camera = views.camera, frame = false, title = two and "t" or nil }
        local window, rows = v:window(), pixels:totable()
        assert.equal(two and 2 or 1, #v:bars())
        for i, bar in ipairs(v:bars()) do
          local r, b = bar.room, bar.box
          if r[3] > 0 then
            assert.is_true(r[1] >= window[1] + window[3] or r[2] >= window[2] + window[4], what)
            assert.is_true(within(r, { 0, 0, size[1], size[2] }) and within(b, r), what)
            local before = i > 1 and v:bars()[i - 1].room or { -1, 0, 0, 0 }
            assert.is_true(before[1] + before[3] <= r[1], what)
            local walls = 0
            for y = r[2] + 1, r[2] + r[4] do
              for x = r[1] + 1, r[1] + r[3] do if is_wall(rows[y][x]) then walls = walls + 1 end end
            end
            assert.equal(0, walls, what)
          end
        end
        if size[1] >= 120 then assert.is_true(v:bars()[1].room[3] > 0, what) end
        -- The window is full of the wall and of what stands before it: its edges say where it ends.
        local lowest = rows[window[2] + window[4]]
        assert.is_true(is_wall(lowest[window[1] + 1]) and is_wall(lowest[window[1] + window[3]]), what)
      end
    end
  end)
end)

--- Parts of a picture's rows and columns that something is drawn in.
local function used(pixels)
  local rows, columns, list = 0, {}, pixels:totable()
  for _, row in ipairs(list) do
    local any = false
    for x, p in ipairs(row) do
      if difference(p, views.dark) > 0.03 then any, columns[x] = true, true end
    end
    if any then rows = rows + 1 end
  end
  local count = 0
  for _ in pairs(columns) do count = count + 1 end
  return rows / #list, count / #list[1]
end

describe("pictures", function()
  it("of 4:3 use their height, of flat boxes too", function()
    local lamp = { views.lamp }
    local function box(lo, hi)
      return assert(ylm.bake(ylm.uniform_grid { bounds = { lo, hi }, cells = 2, lmax = 1 }, lamp))
    end
    for name, grid in pairs { cube = views.uniform(), room = box({ -3, -0.1, -3 }, { 3, 2.6, 3 }),
      flat = box({ -3, 0, -3 }, { 3, 1, 3 }) } do
      local rows = used((draw { grid, quantity = "norm", slices = true, size = { 320, 240 } }))
      assert.is_true(rows > (name == "flat" and 0.7 or 0.8), ("%s: %.2f of the rows"):format(name, rows))
    end
  end)

  it("of bodies are as large as their points allow, not as the box around these", function()
    local ball = ylm.sphere { at = { 0, 0, 0 }, radius = 1 }
    for _, size in ipairs { { 160, 120 }, { 120, 160 } } do
      local rows, columns = used((draw { meshes = { ball }, size = size }))
      local most = math.max(rows, columns)
      assert.is_true(most > 0.88 and most < 0.97, ("%.2f of the rows, %.2f of the columns"):format(rows, columns))
    end
  end)
end)
