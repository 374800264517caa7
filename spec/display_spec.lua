-- Pictures sent to an image viewer while they are made: a stand-in puts them together (spec/support/tev.c).

local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local codec = pcall(require, "ylm.c.codec")

local function room()
  return ylm.scene "a lamp" {
    camera = ylm.camera { from = { 0, 3, 4 } },
    geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
    lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
  }
end

describe("ylm.display", function()
  if not codec then
    it("sends pictures", function() pending "libylm_codec is not built" end)
    return
  end
  local folder, server
  setup(function()
    folder = scratch.new()
    server = folder.path .. "/tev"
    assert(scratch.shell(("%s -std=gnu11 -O1 -Wall -Wextra -Werror spec/support/tev.c -o %s"):format(os.getenv "CC" or "cc",
      scratch.quote(server))))
  end)
  teardown(function() folder:remove() end)

  --- Starts a viewer in a folder of its own; returns its port and a function that waits for its end.
  local function viewer(mode)
    local place = scratch.capture("mktemp -d " .. scratch.quote(folder.path .. "/XXXXXX")):gsub("%s+$", "")
    local q = scratch.quote(place)
    assert(scratch.shell(("(%s %s %s > %s/port 2> %s/errors; echo $? > %s/status) &"):format(scratch.quote(server), mode, q,
      q, q, q)))
    local port
    for _ = 1, 200 do
      local file = io.open(place .. "/port")
      port = file and file:read "*n"
      if file then file:close() end
      if port then break end
      scratch.shell "sleep 0.02"
    end
    assert(port, "the viewer has not begun")
    local function read(name)
      for _ = 1, 200 do
        local done = io.open(place .. "/status")
        local status = done and done:read "*n"
        if done then done:close() end
        if status then
          local errors = assert(io.open(place .. "/errors")):read "*a"
          assert(status == 0, errors)
          return assert(io.open(place .. "/" .. name, "rb")):read "*a"
        end
        scratch.shell "sleep 0.02"
      end
      error "the viewer does not end"
    end
    return ("127.0.0.1:%d"):format(port), read
  end

  --- The channels of what a viewer has put together, and their floats as one string.
  local function picture(read)
    local head, floats = read "picture":match "^([^\n]*)\n(.*)$"
    local words = {}
    for word in head:gmatch "%S+" do words[#words + 1] = word end
    return words, floats
  end

  --- The floats of an image's layers as a viewer holds them: all channels of a pixel side by side.
  local function floats_of(image)
    local layers, tables = image:layers(), {}
    for i, name in ipairs(layers) do tables[i] = image:layer(name):totable() end
    local list = {}
    for y = 1, image.size[2] do
      for x = 1, image.size[1] do
        for i = 1, #layers do
          for _, v in ipairs(tables[i][y][x]) do list[#list + 1] = v end
        end
      end
    end
    return ylm.array(list, "float"):bytes()
  end

  it("writes packets to the byte", function()
    local address, read = viewer "all"
    local display = assert(ylm.display(address))
    local image = ylm.image { size = { 2, 1 } }
    image:fill(1, 1, 1, 1, { 1, 2, 3 })
    assert(display:send("a", image))
    assert(display:send("a", image))                           -- nothing has changed: nothing is sent
    assert(display:drop "a")
    display:close()
    local zeros, f = ("0"):rep(24), { "0000803f", "00000040", "00004040" }
    assert.equal("1a000000" .. "04" .. "00" .. "6100" .. "02000000" .. "01000000" .. "03000000" .. "520047004200"
      .. "6a000000" .. "06" .. "00" .. "6100" .. "03000000" .. "520047004200" .. "00000000" .. "00000000" .. "02000000"
      .. "01000000" .. "0000000000000000" .. "0100000000000000" .. "0200000000000000"
      .. ("0300000000000000"):rep(3) .. table.concat(f) .. zeros
      .. "07000000" .. "02" .. "6100", read "first")
  end)

  it("sends what a picture is, to the bit, with its layers, and rows that changed alone", function()
    local address, read = viewer "all"
    local display = assert(ylm.display(address))
    local image = ylm.image { size = { 40, 70 }, layers = { { "radiance", 3 }, { "depth", 1 }, { "normal", 3 } } }
    image:fill(1, 1, 40, 70, { 0.1, 0.2, 0.3 })
    image:fill(3, 4, 5, 6, 7, { layer = "depth" })
    assert(display:send("room", image))
    image:fill(1, 65, 2, 2, { -1, 1e30, 0 })
    assert(display:send("room", image))
    display:close()
    local words, floats = picture(read)
    assert.same({ "40", "70", "7", "R", "G", "B", "depth", "normal.X", "normal.Y", "normal.Z" }, words)
    assert(floats == floats_of(image))
    local packets = {}
    for line in read "packets":gmatch "[^\n]+" do packets[#packets + 1] = line end
    assert.equal(1 + 9 + 1, #packets)                          -- 3 layers of 3 strips, then the last strip of one
    assert(packets[11]:find " 64 6$", packets[11])
  end)

  it("shows pictures while they are made, and the finished one to the bit", function()
    for _, how in ipairs { "paths", "direct", "all" } do
      local address, read = viewer "all"
      local options = { by = how == "paths" and "paths" or "rays", size = { 32, 20 }, samples = how == "paths" and 32 or 4,
        bounces = how == "direct" and 0 or nil, display = address }
      local image, report = room():render(options)
      assert(image, report)
      local _, floats = picture(read)
      assert(floats == floats_of(image), how)
      options.display = nil
      local alone = room():render(options)
      assert(floats_of(alone) == floats, how .. ": the picture is another one without a viewer")
    end
  end)

  it("shows the first part of a picture before the last is made", function()
    for _, how in ipairs { "paths", "rays", "filtered" } do
      local address, read = viewer "all"
      local first, most
      assert(room():render { by = how == "paths" and how or "rays", denoise = how == "filtered" and "auto" or nil, bounces = 0,
        size = { 64, 48 }, samples = 16, display = address, threads = 1,
        progress = function(done, total) first, most = first or done, total end }) -- a part is sent before progress is told
      assert(first < most, how)
      local parts, whole = 0, nil
      for line in read "packets":gmatch "[^\n]+" do
        local kind = line:match "^%S+ (%d+)"
        if kind == "4" then parts, whole = parts + 1, line end    -- a picture is opened: radiance alone, then all layers
      end
      assert(parts >= 2, how .. ": " .. tostring(whole))
    end
  end)

  it("takes pictures from the command line, as the file that is written", function()
    local run = tool.runner(folder)
    local scene = folder:write("s.lua", [[return scene "a lamp" {
  camera = camera { from = { 0, 3, 4 } },
  geometry = { quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
}]])
    for _, words in ipairs { "pathtrace -n 8", "render -b 0 -n 4" } do
      local address, read = viewer "all"
      local out, code, err = run(("%s %s -q -s 33x21 --display %s -o %s/s.exr"):format(words, scene, address, folder.path))
      assert.equal(0, code, out .. err)
      local names, floats = picture(read)
      local image, place = assert(ylm.load(folder.path .. "/s.exr")), {}
      for i = 4, #names do place[names[i]] = i - 3 end
      local columns = ylm.array.frombytes(floats, { 21, 33, #names - 3 }, "float")
      local function column(name) return columns[{ {}, {}, (assert(place[name], name)) }] end
      for c, name in ipairs { "R", "G", "B" } do
        assert(column(name):bytes() == image:layer()[{ {}, {}, c }]:bytes(), words .. " " .. name)
      end
      for _, name in ipairs(image:layers()) do
        if name == "normal" or name == "position" then
          for c, letter in ipairs { "X", "Y", "Z" } do
            assert(column(name .. "." .. letter):bytes() == image:layer(name)[{ {}, {}, c }]:bytes(), words .. " " .. name)
          end
        elseif place[name] then
          assert(column(name):bytes() == image:layer(name)[{ {}, {}, 1 }]:bytes(), words .. " " .. name)
        end
      end
    end
    local warning = tool.runner(folder, "YLM_WARNINGS=yes")
    local out, code, err = warning(("render %s -b 0 -n 1 -s 8x8 --display 127.0.0.1:9 -o %s/s.exr"):format(scene, folder.path))
    assert.equal(0, code, out .. err)
    assert.equal(1, select(2, err:gsub("no image viewer listens at 127.0.0.1:9", "")), err)
  end)

  local function warned(make)
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    local ok, image, report = pcall(make)
    ylm.on_warning(before)
    assert(ok and image, image)
    return said, report
  end

  it("warns once where nobody listens, and makes the picture", function()
    local said, report = warned(function() return room():render { size = { 16, 16 }, samples = 1, display = "127.0.0.1:9",
      bounces = 0 } end)
    assert.same({ "no image viewer listens at 127.0.0.1:9: the picture is made without it" }, said)
    assert.equal(said[1], report.warnings[#report.warnings])
  end)

  it("gives a viewer up that hangs up, or takes nothing for two seconds", function()
    for mode, words in pairs { close = "has gone", deaf = "takes nothing for two seconds" } do
      local address, read = viewer(mode)
      local display = assert(ylm.display(address))
      local image, ok, message, code = ylm.image { size = { 1024, 1024 } }, true, nil, nil
      for k = 1, 8 do
        image:fill(1, 1, 1024, 1024, k)
        if ok then ok, message, code = display:send("a", image) end
      end
      assert(ok == nil and code == "EIO" and message:find(words, 1, true), message)
      ok, message, code = display:send("a", image)
      assert(ok == nil and code == "EIO" and message:find "has been given up", message)
      display:close()
      read "port"
    end
  end)

  it("refuses names and addresses", function()
    for _, address in ipairs { "host:0", "host:65536", "host:", "a b:1", "", 7, {}, "1:2:3" } do
      local ok, message = pcall(ylm.display, address)
      assert(not ok and message:find "'host:port', port 1 to 65535", message)
    end
    local address, read = viewer "all"
    local display, image = assert(ylm.display(address)), ylm.image { size = { 2, 2 } }
    for _, name in ipairs { "", ("x"):rep(300), "a\nb" } do
      local ok, message = pcall(display.send, display, name, image)
      assert(not ok and message:find "a name ", message)
    end
    assert.has_error(function() display:send("a", 7) end)
    display:close()
    read "port"
    assert.has_error(function() display:send("a", image) end, "bad argument #1 to 'send' (the display has been closed)")
    assert.has_error(function() room():render { display = 7, bounces = 0 } end)
  end)
end)
