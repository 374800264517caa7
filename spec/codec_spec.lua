local ylm = require "ylm"
local core = require "ylm.c.core"
local pictures = require "spec.support.pictures"
local scratch = require "spec.support.scratch"

local function distance(a, b, name) return (core.array_distance(a:layer(name), b:layer(name))) end

describe("image files", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function path(name) return folder.path .. "/" .. name end

  --- Whether the folder holds nothing that begins with `name` but `name` itself.
  local function no_leftovers(name)
    local list = ("ls -A %s | grep -F %s | grep -vx %s"):format(scratch.quote(folder.path), name, name)
    return (scratch.capture(list)) == ""
  end

  it(".exr keeps layers in order, their numbers and the metadata", function()
    local a = ylm.image {
      size = { 37, 19 },
      layers = { { "radiance", 3 }, { "normal", 3 }, { "depth", 1 }, { "grid.level", 1 }, { "flow", 2 }, { "ids", 4 } },
      metadata = { lmax = 4, convention = "ylm", ["a rather long name of more than thirty-one bytes"] = "x",
        version = "0.1", type = "a", channels = "b", name = "c", ylmLayers = "d", ["ylm.x"] = "e" },  -- names of OpenEXR's
    }
    local noise = pictures.noise(ylm, 37, 19, 4, 5, -100, 100)
    a:paste(noise:crop(1, 1, 37, 19), 1, 1, { layer = "ids" })
    a:layer("depth"):set(19, 37, 1, math.huge)
    a:layer("normal"):set(2, 5, 3, -1)
    a:fill(3, 3, 7, 9, { 1, 2, 3 })
    assert.is_true(a:save(path "a.exr"))
    local b = assert(ylm.load(path "a.exr"))
    assert.same({ a:layers() }, { b:layers() })
    assert.same(a.metadata(), b.metadata())
    for _, name in ipairs { "radiance", "normal", "grid.level", "flow", "ids" } do
      assert.equal(0, distance(a, b, name))
    end
    assert.equal(math.huge, b:layer "depth":get(19, 37, 1))
  end)

  it(".exr with half precision rounds to 11 bits and saturates", function()
    local a = pictures.noise(ylm, 33, 17, 3, 6, 0.5, 1)
    a:layer():set(1, 1, 1, 1e9)
    assert.is_true(a:save(path "h.exr", { bits = 16 }))
    local b = assert(ylm.load(path "h.exr"))
    assert.equal(65504, b:layer():get(1, 1, 1))
    b:layer():set(1, 1, 1, 1e9)
    assert.is_true(distance(a, b) <= 2 ^ -12)
    assert.is_true(distance(a, b) > 2 ^ -14)
  end)

  it(".pfm keeps every bit, and reads both byte orders", function()
    local a = pictures.noise(ylm, 5, 3, 3, 7, -1e20, 1e20)
    assert.is_true(a:save(path "a.pfm"))
    assert.equal(0, distance(a, assert(ylm.load(path "a.pfm"))))
    local big = folder:write("big.pfm", "Pf\n2 1\n1.0\n\63\128\0\0\64\0\0\0")
    assert.same({ { { 1 }, { 2 } } }, ylm.load(big):layer():totable())
  end)

  it(".hdr keeps seven bits of the brightest channel, in old and new runs", function()
    for _, w in ipairs { 5, 40 } do
      local a = pictures.noise(ylm, w, 9, 3, 8, 0, 4)
      a:fill(2, 2, w - 2, 3, { 0.25, 0, 3 })
      assert.is_true(a:save(path "a.hdr"))
      local b = assert(ylm.load(path "a.hdr"))
      assert.is_true(distance(a, b) <= 4 / 256 + 1e-6, tostring(distance(a, b)))
    end
    local old = folder:write("old.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 1 -Y 5\n"
      .. "\128\64\0\129\1\1\1\3\0\0\0\0")
    local rows = ylm.load(old):layer():totable()
    assert.equal(5, #rows)
    assert.near(1, rows[4][1][1], 0.01)
    assert.near(0.5, rows[4][1][2], 0.01)
    assert.equal(0, rows[5][1][1])
  end)

  it(".png goes through exposure and the curve that is named, in 8 and 16 bits", function()
    local function srgb(x) return x <= 0.0031308 and 12.92 * x or 1.055 * x ^ (1 / 2.4) - 0.055 end
    local function hable(x)
      return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3
    end
    local curves = {
      linear = function(x) return math.min(x, 1) end,
      srgb = function(x) return srgb(math.min(x, 1)) end,
      hable = function(x) return srgb(math.min(1, hable(2 * x) / hable(11.2))) end,
      aces = function(x) return srgb(math.min(1, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14))) end,
      reinhard = function(x) return srgb(x / (1 + x)) end,
    }
    for name, curve in pairs(curves) do
      for _, bits in ipairs { 8, 16 } do
        local a = pictures.noise(ylm, 16, 16, 3, 9, 0, 1.5)
        assert.is_true(a:save(path "a.png", { tone = name, exposure = 1, bits = bits }))
        local b = assert(ylm.load(path "a.png", { raw = true }))
        local p, q = a:layer():totable(), b:layer():totable()
        for y = 1, 16 do
          for x = 1, 16 do
            assert.near(curve(2 * p[y][x][1]), q[y][x][1], 0.51 / (2 ^ bits - 1) + 1e-6, name)
          end
        end
      end
    end
  end)

  it(".png of 1 to 4 channels comes back linear, alpha untouched", function()
    for channels = 1, 4 do
      local a = pictures.noise(ylm, 21, 10, channels, 10 + channels)
      assert.is_true(a:save(path "c.png", { bits = 16 }))
      local b = assert(ylm.load(path "c.png"))
      assert.same({ 10, 21, channels }, b:layer().shape)
      assert.is_true(distance(a, b) < 3e-5)
    end
  end)

  it("shows nothing but numbers in the range: NaN and negative are black, infinity is white", function()
    local a = pictures.image(ylm, { { { 0 / 0 }, { -1 }, { math.huge }, { 1e30 } } })
    for _, tone in ipairs { "linear", "srgb", "hable", "aces", "reinhard" } do
      assert.is_true(a:save(path "n.png", { tone = tone }))
      assert.same({ { { 0 }, { 0 }, { 1 }, { 1 } } }, ylm.load(path "n.png", { raw = true }):layer():totable())
    end
  end)

  it("survive truncation and altered bytes: an error that names the file, or an image", function()
    local a = pictures.noise(ylm, 12, 20, 3, 11)
    for _, format in ipairs { "exr", "png", "hdr", "pfm" } do
      assert.is_true(a:save(path("good." .. format)))
      local text, refused = folder:read("good." .. format), 0
      local name = path("bad." .. format)
      pictures.spoil(text, 150, 12, function(bad, what)
        folder:write("bad." .. format, bad)
        local image, message, code = ylm.load(name)
        if image then
          assert(not what:find "truncated" or format == "png", format .. " " .. what .. " was accepted")
        else
          refused = refused + 1
          assert(message:sub(1, #name) == name and (code == "EFORMAT" or code == "ELIMIT"), message)
        end
      end)
      assert.is_true(refused >= 130, format .. ": " .. refused)
    end
  end)

  it("refuse sizes that the file cannot hold before memory is taken", function()
    for name, text in pairs {
      ["huge.pfm"] = "PF\n60000 8000\n-1.0\n",
      ["huge2.pfm"] = "PF\n999999999 999999999\n-1.0\n",
      ["huge.hdr"] = "#?RADIANCE\n\n-Y 60000 +X 8000\n\2\2",
    } do
      local image, message = ylm.load(folder:write(name, text))
      assert.is_nil(image)
      assert.truthy(message:find "truncated" or message:find "limited", message)
    end
  end)

  it("refuse an .exr whose header claims more pixels than its compression packs into so few bytes", function()
    assert.is_true(pictures.noise(ylm, 8, 8, 4, 1):save(path "small.exr"))
    local text, box = folder:read "small.exr", ("\0"):rep(8) .. "\255\39\0\0\255\15\0\0" -- 10240 x 4096 pixels
    for code, says in pairs { [3] = "truncated", [4] = "truncated", [8] = "DWA compression is read by" } do
      local bad = text:gsub("(compression%zcompression%z....).", function(head) return head .. string.char(code) end)
      bad = bad:gsub("(dataWindow%zbox2i%z....)................", function(head) return head .. box end)
      local image, message = ylm.load(folder:write("bomb.exr", bad .. ("\0"):rep(65536)))
      assert.is_nil(image)
      -- OpenEXR 3.2 and later reads DWA, which packs as many
      assert(message:find("OpenEXR: " .. says, 1, true) or code == 8 and not message:find "truncated", message)
    end
  end)

  it("leave an existing file as it was when the disk is full", function()
    for _, format in ipairs { "exr", "png", "hdr", "pfm" } do
      local name = "kept." .. format
      assert.is_true(pictures.noise(ylm, 4, 4, 3, 1):save(path(name)))
      local before = folder:read(name)
      local out = pictures.on_full_disk(scratch, ([[
        local ylm, pictures = require "ylm", require "spec.support.pictures"
        print(pictures.noise(ylm, 90, 90, 3, 2):save(%q))]]):format(path(name)))
      assert.truthy(out:find("^nil\t.*" .. name .. ": cannot be written: .*\tEIO"), format .. ": " .. out)
      assert.equal(before, folder:read(name))
      assert.is_true(no_leftovers(name), format)
    end
  end)

  it("end, wherever in a file of many layers the disk is full", function()
    local name = path "layers.exr"
    for _, blocks in ipairs { 0, 1, 40, 80, 120, 160 } do
      local out = pictures.on_full_disk(scratch, ([[
        local ylm, pictures = require "ylm", require "spec.support.pictures"
        local image = pictures.noise(ylm, 90, 90, 3, 2)
        for i = 1, 5 do image:add(("layer%%d"):format(i), 3) end
        for i = 1, 5 do
          local from, to = image:layer(), image:layer(("layer%%d"):format(i))
          for y = 1, 90 do for x = 1, 90 do to:set(y, x, 1, from:get(y, x, 2)) end end
        end
        print(image:save(%q))]]):format(name), blocks)
      assert.truthy(out:find("^nil\t.*layers.exr: cannot be .*: .*\tEIO"), blocks .. ": " .. out)
      assert.is_true(no_leftovers "layers.exr")
    end
  end)

  it("fail with the system's words where a folder is missing or is no folder", function()
    local a = ylm.image { size = { 4, 4 } }
    folder:write("file", "x")
    for name, says in pairs { ["none/a.png"] = "No such file", ["file/a.exr"] = "Not a directory" } do
      local ok, message, code = a:save(path(name))
      assert.is_nil(ok)
      assert.equal("EIO", code)
      assert.truthy(message:find(says), message)
    end
    assert(scratch.shell("mkdir " .. scratch.quote(path "folder.png")))
    assert.is_nil((a:save(path "folder.png")))
    assert.is_nil((ylm.load(path "folder.png")))
    assert.is_nil((ylm.load(path "missing.exr")))
  end)

  it("are written and read where Embree is missing", function()
    local loaded, preload = package.loaded["ylm.c.scene"], package.preload["ylm.c.scene"]
    package.loaded["ylm.c.scene"] = nil
    package.preload["ylm.c.scene"] = function() error("libembree3.so.3: cannot open shared object file") end
    local a = ylm.image { size = { 4, 4 } }:fill(1, 1, 4, 4, 1)
    local saved, b = a:save(path "n.exr"), ylm.load(path "n.exr")
    local none, message, code = ylm.scene "none" { camera = ylm.camera { from = { 0, 0, 1 } } }:render { by = "sum" }
    package.loaded["ylm.c.scene"], package.preload["ylm.c.scene"] = loaded, preload
    assert.is_true(saved)
    assert.equal(0, a:compare(b).mse)
    assert.same({ nil, "EMISSING" }, { none, code })
    assert.truthy(message:find "libylm_scene.*Embree", message)
  end)

  it("say what to install where the library is missing, and leave the rest working", function()
    local loaded, preload = package.loaded["ylm.c.codec"], package.preload["ylm.c.codec"]
    package.loaded["ylm.c.codec"] = nil
    package.preload["ylm.c.codec"] = function() error("libylm_codec.so: cannot open shared object file") end
    local a = ylm.image { size = { 4, 4 } }:fill(1, 1, 4, 4, 1)
    local ok, message, code = a:save(path "m.png")
    local mse = a:compare(a).mse
    package.loaded["ylm.c.codec"], package.preload["ylm.c.codec"] = loaded, preload
    assert.is_nil(ok)
    assert.equal("EMISSING", code)
    assert.truthy(message:find "libylm_codec.*libpng", message)
    assert.equal(0, mse)
  end)
end)
