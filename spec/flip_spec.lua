-- FLIP: against its formulas, convolved one by one in two dimensions; against its authors' program; HDR; refusals.

local core = require "ylm.c.core"
local ylm = require "ylm"

local function decode(v) return v <= 0.04045 and v / 12.92 or ((v + 0.055) / 1.055) ^ 2.4 end

--- An image of w x h pixels f(x, y) -> r, g, b, x and y from 1.
local function image(w, h, f)
  local made, rows = ylm.image { size = { w, h } }, {}
  for y = 1, h do
    rows[y] = {}
    for x = 1, w do rows[y][x] = { f(x, y) } end
  end
  core.array_fill(made:layer(), rows)
  return made
end

--- Eight bits of sRGB, so that a PNG file has them exactly: a picture, and one that differs from it here and there.
local function picture(x, y)
  return decode((5 * x + 3 * y) % 256 / 255), decode((x * y + 40) % 256 / 255), decode((7 * y + x) % 200 / 255)
end
local function other(x, y)
  local a = (x * 31 + y * 17) % 23 - 11
  local function moved(v) return decode(math.min(255, math.max(0, v + a)) / 255) end
  return moved((5 * x + 3 * y) % 256), moved((x * y + 40) % 256), decode((7 * y + x + (y > 10 and 6 or 0)) % 200 / 255)
end

-- The definition, without separable filters and tables. -------------------------------------------

local M = { { 0.4123865632529917, 0.3575914909206253, 0.18045049120356368 },
  { 0.21263682167732384, 0.7151829818412506, 0.07218019648142547 },
  { 0.019330620152483987, 0.11919716364020845, 0.9503725870054354 } }
local I = { { 3.2410032329763587, -1.5373989694887855, -0.4986158819963629 },
  { -0.9692242522025166, 1.875929983695176, 0.041554226340084724 },
  { 0.055639419851975444, -0.20401120612390993, 1.0571489771875333 } }
local white = {}
for i = 1, 3 do white[i] = M[i][1] + M[i][2] + M[i][3] end

local function times(m, a, b, c)
  local out = {}
  for i = 1, 3 do out[i] = m[i][1] * a + m[i][2] * b + m[i][3] * c end
  return out
end

local function opponent(r, g, b)
  local t = times(M, r, g, b)
  local x, y, z = t[1] / white[1], t[2] / white[2], t[3] / white[3]
  return { 116 * y - 16, 500 * (x - y), 200 * (y - z) }
end

local function hunted_lab(c)
  local t = times(M, c[1], c[2], c[3])
  for i = 1, 3 do
    local v = t[i] / white[i]
    t[i] = v > (6 / 29) ^ 3 and v ^ (1 / 3) or v / (3 * (6 / 29) ^ 2) + 4 / 29
  end
  local L = 116 * t[2] - 16
  return { L, 0.01 * L * 500 * (t[1] - t[2]), 0.01 * L * 200 * (t[2] - t[3]) }
end

local function hyab(a, b)
  return (math.abs(a[1] - b[1]) + math.sqrt((a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)) ^ 0.7
end

local largest = hyab(hunted_lab { 0, 1, 0 }, hunted_lab { 0, 0, 1 })

--- Weights [dy][dx] of f(x, y) over a square, positive ones summing to 1, negative ones to -1.
local function kernel(radius, f)
  local w, plus, minus = {}, 0, 0
  for dy = -radius, radius do
    w[dy] = {}
    for dx = -radius, radius do
      local v = f(dx, dy)
      w[dy][dx] = v
      if v > 0 then plus = plus + v else minus = minus - v end
    end
  end
  for dy = -radius, radius do
    for dx = -radius, radius do
      local v = w[dy][dx]
      w[dy][dx] = v > 0 and v / plus or v < 0 and v / minus or 0
    end
  end
  return w
end

local function convolve(plane, w, h, x, y, channel, weights, radius)
  local sum = 0
  for dy = -radius, radius do
    local row = plane[math.min(h, math.max(1, y + dy))]
    for dx = -radius, radius do sum = sum + weights[dy][dx] * row[math.min(w, math.max(1, x + dx))][channel] end
  end
  return sum
end

--- The FLIP of two lists of rows of linear colours of 0 .. 1, as rows of numbers.
local function direct(test, reference, ppd)
  local w, h, pi = #test[1], #test, math.pi
  local eye, feature = math.ceil(3 * math.sqrt(0.04 / (2 * pi ^ 2)) * ppd), math.ceil(3 * 0.5 * 0.082 * ppd)
  local function sensitivity(a1, b1, a2, b2)
    return kernel(eye, function(x, y)
      local r2 = (x * x + y * y) / ppd ^ 2
      return a1 * math.sqrt(pi / b1) * math.exp(-pi ^ 2 * r2 / b1) + a2 * math.sqrt(pi / b2) * math.exp(-pi ^ 2 * r2 / b2)
    end)
  end
  local seen = { sensitivity(1, 0.0047, 0, 1e-5), sensitivity(1, 0.0053, 0, 1e-5), sensitivity(34.1, 0.04, 13.5, 0.025) }
  local s2 = (0.5 * 0.082 * ppd) ^ 2
  local function gauss(x, y) return math.exp(-(x * x + y * y) / (2 * s2)) end
  local features = {
    kernel(feature, function(x, y) return -x * gauss(x, y) end), kernel(feature, function(x, y) return -y * gauss(x, y) end),
    kernel(feature, function(x, y) return (x * x / s2 - 1) * gauss(x, y) end),
    kernel(feature, function(x, y) return (y * y / s2 - 1) * gauss(x, y) end),
  }
  local planes = {}
  for side, rows in ipairs { test, reference } do
    planes[side] = {}
    for y = 1, h do
      planes[side][y] = {}
      for x = 1, w do planes[side][y][x] = opponent(rows[y][x][1], rows[y][x][2], rows[y][x][3]) end
    end
  end
  local out = {}
  for y = 1, h do
    out[y] = {}
    for x = 1, w do
      local lab, edge, point = {}, {}, {}
      for side = 1, 2 do
        local v, f = {}, {}
        for c = 1, 3 do v[c] = convolve(planes[side], w, h, x, y, c, seen[c], eye) end
        for k = 1, 4 do f[k] = convolve(planes[side], w, h, x, y, 1, features[k], feature) / 116 end
        local Y = (v[1] + 16) / 116
        local rgb = times(I, (Y + v[2] / 500) * white[1], Y * white[2], (Y - v[3] / 200) * white[3])
        for c = 1, 3 do rgb[c] = math.min(1, math.max(0, rgb[c])) end
        lab[side] = hunted_lab(rgb)
        edge[side], point[side] = math.sqrt(f[1] ^ 2 + f[2] ^ 2), math.sqrt(f[3] ^ 2 + f[4] ^ 2)
      end
      local d, bend = hyab(lab[1], lab[2]), 0.4 * largest
      d = d < bend and 0.95 * d / bend or 0.95 + 0.05 * (d - bend) / (largest - bend)
      local features_differ = (math.max(math.abs(edge[1] - edge[2]), math.abs(point[1] - point[2])) / math.sqrt(2)) ^ 0.5
      out[y][x] = d ^ (1 - features_differ)
    end
  end
  return out
end

--- The largest difference of a map from rows.
local function apart(map, rows)
  local worst, got = 0, map:layer():totable()
  for y, row in ipairs(rows) do
    for x, v in ipairs(row) do
      local g = got[y][x]
      worst = math.max(worst, math.abs(v - (type(g) == "table" and g[1] or g)))
    end
  end
  return worst
end

describe("image:flip", function()
  it("is 0 of equal images, and 1 of green against blue", function()
    local a = image(24, 18, picture)
    for _, range in ipairs { "ldr", "hdr" } do
      local map, report = a:flip(a, { range = range })
      assert.equal(0, report.mean)
      assert.equal(0, report.max)
      assert.same({ 24, 18 }, map.size)
    end
    local green, blue = image(16, 16, function() return 0, 1, 0 end), image(16, 16, function() return 0, 0, 1 end)
    assert.is_near(1, (select(2, green:flip(blue, { range = "ldr" }))).mean, 1e-6)
  end)

  for _, case in ipairs { { 15, 11, 67.02 }, { 16, 12, 30 }, { 9, 20, 12.5 } } do
    it(("agrees with its definition, convolved pixel by pixel (%dx%d, %g pixels per degree)"):format(
      case[1], case[2], case[3]), function()
      local w, h, ppd = case[1], case[2], case[3]
      local test, truth = image(w, h, other), image(w, h, picture)
      local map, report = test:flip(truth, { range = "ldr", pixels_per_degree = ppd })
      local rows = direct(test:layer():totable(), truth:layer():totable(), ppd)
      assert(apart(map, rows) < 1e-5, apart(map, rows))
      assert(report.mean > 0.02)
    end)
  end

  it("is the largest under exposures, from the brightest pixel's to the median's", function()
    local w, h = 14, 10
    local function bright(f, x, y, k)
      local r, g, b = f(x, y)
      local scale = k * math.exp(3 * math.sin(x) * math.cos(y))
      return r * scale, g * scale, b * scale
    end
    local truth = image(w, h, function(x, y) return bright(picture, x, y, 4) end)
    local test = image(w, h, function(x, y) return bright(other, x, y, 4) end)
    local map, report = test:flip(truth, { pixels_per_degree = 20 })
    -- the curve of Narkowicz 2015 with the exposure of 0.6, and where it is 0.85
    local A, B, D, E, F = 0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14
    local function tone(v) return math.min(1, math.max(0, v * (A * v + B) / (v * (D * v + E) + F))) end
    local p, q = (B - 0.85 * E) / (A - 0.85 * D), -0.85 * F / (A - 0.85 * D)
    local x85 = -p / 2 + math.sqrt(p * p / 4 - q)
    assert.is_near(0.85, tone(x85), 1e-12)
    local luminances = {}
    for _, row in ipairs(truth:layer():totable()) do
      for _, c in ipairs(row) do luminances[#luminances + 1] = 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end
    end
    table.sort(luminances)
    local start, stop = math.log(x85 / luminances[w * h]) / math.log(2), math.log(x85 / luminances[w * h / 2 + 1]) / math.log(2)
    assert.is_near(start, report.start, 1e-6)
    assert.is_near(stop, report.stop, 1e-6)
    assert.equal(math.max(2, math.ceil(stop - start)), report.exposures)
    local worst
    for i = 0, report.exposures - 1 do
      local gain = 2 ^ (start + (stop - start) * i / (report.exposures - 1))
      local shown = {}
      for side, of in ipairs { test, truth } do
        shown[side] = of:layer():totable()
        for _, row in ipairs(shown[side]) do
          for _, c in ipairs(row) do for k = 1, 3 do c[k] = tone(gain * c[k]) end end
        end
      end
      local rows = direct(shown[1], shown[2], 20)
      for y = 1, h do
        for x = 1, w do rows[y][x] = math.max(rows[y][x], worst and worst[y][x] or 0) end
      end
      worst = rows
    end
    assert(apart(map, worst) < 1e-5, apart(map, worst))
  end)

  it("agrees with the program of its authors (NVlabs/flip, C++, commit 1eb247c) to 1e-4", function()
    local function close(wanted, test, truth, o)
      local report = select(2, test:flip(truth, o))
      assert.is_near(wanted[1], report.mean, 1e-4)
      assert.is_near(wanted[2], report.max, 1e-4)
    end
    local test, truth = image(64, 48, other), image(64, 48, picture)
    close({ 0.102107, 0.507683 }, test, truth, { range = "ldr" })
    close({ 0.155124, 0.718970 }, test, truth, { range = "ldr", pixels_per_degree = 30 })
    -- powers of two times numbers of eight bits: a file holds them exactly
    local function hdr(x, y) return 2 ^ (x % 13 - 6) * (1 + y / 64), 2 ^ (y % 7 - 3), 2 ^ ((x + y) % 9 - 4) end
    local bright = image(64, 48, hdr)
    local off = image(64, 48, function(x, y)
      local r, g, b = hdr(x, y)
      local k = 1 + ((x * 5 + y * 3) % 8 - 4) / 32
      return r * k, g * k, b * (y > 24 and 1.125 or 1)
    end)
    close({ 0.074340, 0.181442 }, off, bright, {})
    close({ 0.102688, 0.222765 }, off, bright, { pixels_per_degree = 30, start = -2, stop = 3 })
  end)

  it("is the same whatever the number of threads, and takes the mean over a mask", function()
    local test, truth = image(40, 50, other), image(40, 50, picture)
    local one, report = test:flip(truth, { threads = 1 })
    local five, same = test:flip(truth, { threads = 5 })
    assert.equal(0, (core.array_distance(one:layer(), five:layer())))
    assert.same(report, same)
    local rows = {}
    for y = 1, 50 do
      rows[y] = {}
      for x = 1, 40 do rows[y][x] = y <= 10 and 1 or 0 end
    end
    local map, part = test:flip(truth, { mask = ylm.array(rows), start = report.start, stop = report.stop })
    local sum = 0
    for y = 1, 10 do for x = 1, 40 do sum = sum + one:layer():get(y, x, 1) end end
    assert.is_near(sum / 400, part.mean, 1e-6)
    assert.equal(0, map:layer():get(11, 1, 1))
  end)

  it("sees grey as grey, and nothing at all as alike", function()
    local function value(x, y) return (x * 3 + y) % 7 / 7 end
    local colour = image(12, 9, function(x, y) return value(x, y), value(x, y), value(x, y) end)
    local grey = ylm.image { size = { 12, 9 }, layers = { { "radiance", 1 } } }
    local rows = {}
    for y = 1, 9 do
      rows[y] = {}
      for x = 1, 12 do rows[y][x] = { value(x, y) } end
    end
    core.array_fill(grey:layer(), rows)
    local dark = ylm.image { size = { 12, 9 }, layers = { { "radiance", 1 } } }
    local black = ylm.image { size = { 12, 9 } }
    assert.same(select(2, black:flip(colour)), (select(2, dark:flip(grey))))
    local report = select(2, black:flip(black))
    assert.equal(0, report.mean)
    assert.equal(0, report.start)
  end)

  it("stands in image:compare, with relmse beside it", function()
    local test, truth = image(16, 12, other), image(16, 12, picture)
    local m = test:compare(truth, { flip = "ldr" })
    assert.equal((select(2, test:flip(truth, { range = "ldr" }))).mean, m.flip)
    assert.is_nil(test:compare(truth).flip)
    local sum, p, q = 0, test:layer():totable(), truth:layer():totable()
    for y = 1, 12 do
      for x = 1, 16 do for c = 1, 3 do sum = sum + (p[y][x][c] - q[y][x][c]) ^ 2 / (q[y][x][c] ^ 2 + 0.25) end end
    end
    assert.is_near(sum / (16 * 12 * 3), test:compare(truth, { epsilon = 0.25 }).relmse, 1e-12)
    assert.equal(0.01, m.epsilon)
  end)

  it("refuses what cannot be compared", function()
    local a = image(8, 6, picture)
    local function refused(message, f, ...)
      local ok, why = pcall(f, ...)
      assert.is_false(ok)
      assert.truthy(tostring(why):find(message, 1, true), tostring(why))
    end
    refused("sizes differ: 8 x 6 and 9 x 6", a.flip, a, image(9, 6, picture))
    local bad = image(8, 6, picture)
    bad:layer():set(3, 2, 1, 0 / 0)
    refused("pixel (2, 3) is not finite", a.flip, a, bad)
    refused("pixel (2, 3) is not finite", bad.flip, bad, a)
    refused("the mask leaves no pixel", a.flip, a, a, { mask = ylm.zeros { 6, 8 } })
    refused("the first exposure, 3 stops, is above the last, -1", a.flip, a, a, { start = 3, stop = -1 })
    refused("pixels_per_degree must be a number > 0 and <= 3700", a.flip, a, a, { pixels_per_degree = 0 })
    refused("did you mean 'hdr'", a.flip, a, a, { range = "hdrr" })
    local masked = {}
    for y = 1, 6 do
      masked[y] = {}
      for x = 1, 8 do masked[y][x] = (x == 2 and y == 3) and 0 or 1 end
    end
    assert(select(2, bad:flip(a, { mask = ylm.array(masked) })).mean >= 0)
    assert.same({ nil, "cancelled", "ECANCELLED" }, { a:flip(a, { progress = function() return false end }) })
  end)
end)
