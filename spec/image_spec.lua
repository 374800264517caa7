local ylm = require "ylm"
local core = require "ylm.c.core"
local pictures = require "spec.support.pictures"

local function grey(rows)
  local nested = {}
  for y, row in ipairs(rows) do
    nested[y] = {}
    for x, v in ipairs(row) do nested[y][x] = { v } end
  end
  return pictures.image(ylm, nested)
end

describe("image", function()
  it("has named layers whose first row is the top", function()
    local picture = ylm.image { size = { 3, 2 }, layers = { { "radiance", 3 }, { "depth", 1 } } }
    local names, channels = picture:layers()
    assert.same({ "radiance", "depth" }, names)
    assert.same({ radiance = 3, depth = 1 }, channels)
    assert.same({ 2, 3, 3 }, picture:layer().shape)
    picture:fill(3, 1, 1, 1, { 1, 2, 3 })
    assert.same({ { { 0, 0, 0 }, { 0, 0, 0 }, { 1, 2, 3 } }, { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } } },
      picture:layer():totable())
  end)

  it("says what it is, closed too", function()
    local picture = ylm.image { size = { 3, 2 } }
    assert.equal("ylm.image 3x2 radiance:3", tostring(picture))
    picture:close()
    assert.equal("ylm.image (closed)", tostring(picture))
  end)

  it("keeps a layer's numbers alive after the image is gone", function()
    local layer = ylm.image { size = { 64, 64 } }:fill(1, 1, 64, 64, 3):layer()
    collectgarbage()
    collectgarbage()
    assert.equal(3, layer:get(64, 64, 3))
    local picture = ylm.image { size = { 4, 4 } }:fill(1, 1, 4, 4, 2)
    layer = picture:layer()
    picture:close()
    assert.equal(2, layer:get(4, 4, 1))
    assert.has_error(function() picture:layer() end)
  end)

  it("keeps metadata as strings, in a table of its own", function()
    local picture = ylm.image { size = { 2, 2 }, metadata = { lmax = 4 } }
    picture.metadata.seconds = 0.1
    picture.metadata.convention = "ylm"
    assert.equal(0.1, tonumber(picture.metadata.seconds))
    assert.same({ lmax = "4", seconds = picture.metadata.seconds, convention = "ylm" }, picture.metadata())
    picture.metadata.lmax = nil
    assert.is_nil(picture.metadata.lmax)
  end)
end)

describe("image:compare", function()
  local a, b = grey { { 1, 2 }, { 3, 4 } }, grey { { 1, 3 }, { 3, 8 } }

  it("computes what a hand computes", function()
    local m = a:compare(b)
    assert.near(17 / 4, m.mse, 1e-12)
    assert.near(math.sqrt(17 / 4), m.rmse, 1e-12)
    assert.equal(8, m.peak)
    assert.near(10 * math.log(64 / 4.25) / math.log(10), m.psnr, 1e-12)
    assert.near(5 / 4, m.mae, 1e-12)
    assert.near(100 * (1 / 3 + 1 / 2) / 4, m.mape, 1e-9)
    assert.equal(4, m.max)
    assert.equal(4, m.pixels)
    assert.near(0.008, m.floor, 1e-12)
  end)

  it("counts only pixels of the mask, and refers to the peak and the floor it is given", function()
    local m = a:compare(b, { mask = ylm.array { { 1, 1 }, { 1, 0 } }, peak = 10, floor = 6 })
    assert.near(1 / 3, m.mse, 1e-12)
    assert.equal(3, m.pixels)
    assert.near(10 * math.log(300) / math.log(10), m.psnr, 1e-12)
    assert.near(100 / 6 / 3, m.mape, 1e-9)
    assert.equal(1, m.max)
  end)

  it("finds no difference between equal images", function()
    local m = b:compare(b)
    assert.equal(0, m.mse)
    assert.equal(math.huge, m.psnr)
    assert.near(1, m.ssim, 1e-12)
    local black = ylm.image { size = { 3, 3 } }
    m = black:compare(black)
    assert.equal(1, m.ssim)
    assert.equal(0, m.mape)
  end)

  it("knows the similarity of two constants: (2ab + C1) / (a^2 + b^2 + C1)", function()
    local one = ylm.image { size = { 20, 15 } }:fill(1, 1, 20, 15, 1)
    local two = ylm.image { size = { 20, 15 } }:fill(1, 1, 20, 15, 2)
    assert.near(4.0004 / 5.0004, one:compare(two).ssim, 1e-9)
  end)

  it("agrees with the definition of ssim, window by window", function()
    local w, h, seed = 14, 13, 7
    local x, y = pictures.noise(ylm, w, h, 1, seed), pictures.noise(ylm, w, h, 1, seed + 1)
    local p, q, total = x:layer():totable(), y:layer():totable(), 0
    local peak = x:compare(y).peak
    for j = 1, h do
      for i = 1, w do
        local s = { 0, 0, 0, 0, 0, 0 }
        for jj = math.max(1, j - 5), math.min(h, j + 5) do
          for ii = math.max(1, i - 5), math.min(w, i + 5) do
            local g = math.exp(-((ii - i) ^ 2 + (jj - j) ^ 2) / 4.5)
            local u, v = p[jj][ii][1], q[jj][ii][1]
            for k, term in ipairs { 1, u, v, u * u, v * v, u * v } do s[k] = s[k] + g * term end
          end
        end
        local ma, mb = s[2] / s[1], s[3] / s[1]
        local va, vb, cov = s[4] / s[1] - ma ^ 2, s[5] / s[1] - mb ^ 2, s[6] / s[1] - ma * mb
        local c1, c2 = (0.01 * peak) ^ 2, (0.03 * peak) ^ 2
        total = total + (2 * ma * mb + c1) * (2 * cov + c2) / ((ma ^ 2 + mb ^ 2 + c1) * (va + vb + c2))
      end
    end
    assert.near(total / (w * h), x:compare(y).ssim, 1e-10)
  end)

  it("gives the same numbers whatever the number of threads", function()
    local x, y = pictures.noise(ylm, 40, 70, 3, 1), pictures.noise(ylm, 40, 70, 3, 2)
    assert.same(x:compare(y, { threads = 1 }), x:compare(y, { threads = 5 }))
    local p = x:resize({ 17, 90 }, { threads = 1, filter = "lanczos" })
    local q = x:resize({ 17, 90 }, { threads = 5, filter = "lanczos" })
    assert.equal(0, (core.array_distance(p:layer(), q:layer())))
  end)

  it("leaves numbers that are not finite to the mask", function()
    local x = grey { { 1, math.huge } }
    local ok, message = pcall(x.compare, x, x)
    assert.is_false(ok)
    assert.truthy(message:find("pixel %(2, 1%) is not finite"), message)
    assert.equal(0, x:compare(x, { mask = ylm.array { { 1, 0 } } }).mse)
  end)
end)

describe("image:difference", function()
  it("is absolute, signed or relative, and scaled", function()
    local a, b = grey { { 1, 2 } }, grey { { 2, 0.5 } }
    assert.same({ { { 10 }, { 15 } } }, a:difference(b, { scale = 10 }):layer():totable())
    assert.same({ { { -10 }, { 15 } } }, a:difference(b, { scale = 10, kind = "signed" }):layer():totable())
    assert.same({ { { 0.5 }, { 3 } } }, a:difference(b, { kind = "relative" }):layer():totable())
  end)
end)

describe("pictures from pictures", function()
  it("crop takes every layer from where it says", function()
    local a = pictures.noise(ylm, 9, 7, 3, 3)
    a:add("depth", 1)
    a:layer("depth"):set(4, 3, 1, 5)
    a.metadata.name = "x"
    local part = a:crop(3, 4, 2, 3)
    assert.same({ 2, 3 }, part.size)
    assert.equal(5, part:layer "depth":get(1, 1, 1))
    assert.equal(a:layer():get(6, 4, 2), part:layer():get(3, 2, 2))
    assert.equal("x", part.metadata.name)
  end)

  it("resize averages when it shrinks and keeps constants", function()
    local a = grey { { 1, 3, 0, 0 }, { 5, 7, 0, 8 } }
    assert.same({ { { 4 }, { 2 } } }, a:resize { 2, 1 }:layer():totable())
    for _, filter in ipairs { "box", "linear", "lanczos" } do
      local flat = ylm.image { size = { 13, 7 } }:fill(1, 1, 13, 7, 0.7)
      local other = flat:resize({ 29, 3 }, { filter = filter })
      local same = ylm.image { size = { 29, 3 } }:fill(1, 1, 29, 3, 0.7)
      assert.near(0, (core.array_distance(other:layer(), same:layer())), 1e-6)
    end
    assert.same({ { { 1 }, { 1 }, { 3 }, { 3 } } }, grey { { 1, 3 } }:resize { 4, 1 }:layer():totable())
  end)

  it("paste cuts off, mixes by a mask, and spreads one channel over many", function()
    local a = ylm.image { size = { 3, 2 } }
    a:paste(grey { { 1, 2 }, { 3, 4 } }, 3, 0)
    assert.same({ { { 0, 0, 0 }, { 0, 0, 0 }, { 3, 3, 3 } }, { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } } },
      a:layer():totable())
    local b = grey { { 4, 4, 4 } }
    b:paste(grey { { 8, 8, 8 } }, 1, 1, { mask = ylm.array { { 0, 0.5, 1 } } })
    assert.same({ { { 4 }, { 6 }, { 8 } } }, b:layer():totable())
    a:paste(a, -100000, 5)
  end)

  it("writes text where it says, cut at the edges", function()
    local a = ylm.image { size = { 12, 9 }, layers = { { "radiance", 1 } } }
    local w, h = a:text(1, 1, "I", { scale = 1 })
    assert.same({ 6, 9 }, { w, h })
    assert.equal(1, a:layer():get(2, 3, 1)) -- the stem
    assert.equal(0, a:layer():get(2, 1, 1))
    a:text(10, -3, "W\n\1\255", { scale = 3 })
    local empty = ylm.image { size = { 4, 4 } }
    empty:text(-500, -500, "nothing here")
    empty:text(100, 100, "nor here")
    assert.near(0, (select(3, core.array_distance(empty:layer(), empty:layer()))), 0)
  end)
end)

describe("colours", function()
  it("begin and end as the maps do, and diverge symmetrically in lightness", function()
    local function near(map, t, rgb)
      local c = { ylm.colour(map, t) }
      for k = 1, 3 do assert.near(rgb[k], c[k], 0.005) end
    end
    near("viridis", 0, { 0.267, 0.005, 0.329 })
    near("viridis", 1, { 0.993, 0.906, 0.144 })
    near("viridis", 100 / 255, { 0.1666, 0.4637, 0.5581 }) -- between nodes
    near("viridis", 200 / 255, { 0.4404, 0.8111, 0.3410 })
    near("magma", 120 / 255, { 0.6650, 0.1981, 0.4888 })
    near("grey", 7, { 1, 1, 1 })
    near("viridis", -3, { 0.267, 0.005, 0.329 })
    local r, g, b = ylm.colour("coolwarm", 0.5)
    assert.is_true(math.abs(r - g) < 0.03 and math.abs(g - b) < 0.03 and g > 0.85)
  end)

  it("map a layer linearly and logarithmically; magenta is not a number", function()
    local a = grey { { 1, 10, 100, 0 / 0, -5 } }
    local linear = a:colours { map = "grey", range = { 0, 100 } }:layer()
    assert.near(1, linear:get(1, 3, 1), 1e-6)
    assert.near(((0.1 + 0.055) / 1.055) ^ 2.4, linear:get(1, 2, 1), 2e-4)
    local log = a:colours { map = "grey", range = { 1, 100 }, log = true }:layer()
    assert.near(((0.5 + 0.055) / 1.055) ^ 2.4, log:get(1, 2, 2), 1e-3)
    assert.equal(0, log:get(1, 5, 2))
    assert.same({ 1, 0, 1 }, { log:get(1, 4, 1), log:get(1, 4, 2), log:get(1, 4, 3) })
  end)
end)

describe("images of the sphere", function()
  local cases = {
    { "latlong", "z", { 16, 8 }, 1e-12 }, { "latlong", "y", { 16, 8 }, 1e-12 },
    { "cube", "z", { 5, 30 }, 1e-12 }, { "angular", "z", { 128, 128 }, 2e-2 },
  }

  it("look along +x with z up, along -z with y up, and turn right to the right", function()
    local image = ylm.image { size = { 8, 4 } }
    local function at(d, up, x, y)
      local p = image:positions({ d }, { up = up })
      assert.near(x, p:get(1, 1), 1e-12)
      assert.near(y, p:get(1, 2), 1e-12)
    end
    at({ 1, 0, 0 }, "z", 4, 2)
    at({ 0, -2, 0 }, "z", 6, 2)
    at({ 0, 0, -1 }, "y", 4, 2)
    at({ 3, 0, 0 }, "y", 6, 2)
    at({ 0, 1, 0 }, "y", 4, 0)
    local cube = ylm.image { size = { 4, 24 } }
    local p = cube:positions({ { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } },
      { mapping = "cube" })
    for face = 1, 6 do
      assert.equal(2, p:get(face, 1))
      assert.equal(4 * face - 2, p:get(face, 2))
    end
  end)

  for _, case in ipairs(cases) do
    it(("cover 4 pi and invert: %s, %s up"):format(case[1], case[2]), function()
      local image = ylm.image { size = case[3] }
      local options = { mapping = case[1], up = case[2] }
      local d, angles = image:directions(options)
      local sum, kept, where = 0, {}, {}
      for i, angle in ipairs(angles:totable()) do
        sum = sum + angle
        if angle > 0 then
          local v = d[i]:totable()
          assert.near(1, v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2, 1e-12)
          kept[#kept + 1] = v
          where[#where + 1] = { (i - 1) % case[3][1] + 0.5, math.floor((i - 1) / case[3][1]) + 0.5 }
        end
      end
      assert.near(4 * math.pi, sum, case[4])
      assert.near(0, (core.array_distance(image:positions(kept, options), ylm.array(where))), 1e-9)
    end)
  end
end)
