-- Limits of a scene file from a stranger.

local core = require "ylm.c.core"
local ylm = require "ylm"
local scratch = require "spec.support.scratch"

local small = { instructions = 2e6, memory = 2 ^ 24, time_limit = 20 }

describe("the sandbox of scene files", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  --- Loads a file with this text; returns what ylm.load returns.
  local function try(text, limits, name)
    local path = folder:write(name or "attack.lua", text)
    return ylm.load(path, limits or small)
  end

  --- The file is refused with this code and a message that matches `says`.
  local function refuses(code, says, text, limits)
    local scene, message, got = try(text, limits)
    assert.is_nil(scene, text)
    assert.truthy(message:find(says), message .. "\ndoes not match " .. says)
    assert.equal(code, got, message)
    assert.truthy(message:find("attack.lua", 1, true), message)
  end

  it("runs a scene that only describes, and gives the same scene twice", function()
    local text = [[
      local sum = 0
      for i = 1, 10 do sum = sum + math.random() + math.random(1, 6) end
      local list = {}
      table.insert(list, "b") table.insert(list, 1, "a") list[#list + 1] = "c"
      table.sort(list, function(x, y) return x > y end)
      assert(table.concat(list, ",") == "c,b,a" and table.remove(list) == "a" and #list == 2)
      assert(select("#", unpack { 1, 2, 3 }) == 3 and type(math.sin(1)) == "number")
      return scene(tostring(sum)) { background = { 0, 0.5, 1 } }]]
    local first = assert(try(text))
    local second = assert(try(text))
    assert.equal(first.name, second.name)
    assert.same({ 0, 0.5, 1 }, first.background)
  end)

  it("accepts a first line for the shell and keeps line numbers", function()
    assert(try "#!/usr/bin/env ylm\nreturn scene 'x' {}")
    refuses("EFORMAT", "^[^:]*attack.lua:2: there is no 'prinf'", "#!/usr/bin/env ylm\nprinf()")
  end)

  it("leaves strings that outlive the call", function()
    local t = {}
    for i = 1, 400 do t[i] = "0123456789" end
    local made = {}
    assert(core.bounded_call(function() -- Lua 5.5 frees what table.concat returns by the allocator that it was made by
      for i = 1, 20 do made[i] = table.concat(t) end
    end, 1e6, 2 ^ 22, 20, tostring))
    made = #made[20]
    local function below(depth) -- where the call's variables were on the stack
      if depth > 0 then pcall(below, depth - 1) end
      collectgarbage()
    end
    below(20)
    assert.equal(4000, made)
  end)

  it("names the line of a mistake and guesses what was meant", function()
    refuses("EFORMAT", "attack.lua:2: there is no 'scen' in a scene file %(did you mean 'scene'%?%)",
      "\nreturn scen 'x' {}")
    refuses("EFORMAT", "attack.lua:2: scene: no field 'lihgts' %(did you mean 'lights'%?%)",
      "\nreturn scene 'x' { lihgts = {} }")
    refuses("EFORMAT", "attack.lua:1:", "return return")
    refuses("EFORMAT", "must return a scene", "return 3")
    refuses("EFORMAT", "must return a scene", "")
    refuses("EFORMAT", "must return a scene", "return {}")
    refuses("EFORMAT", "raised a table", "error({})")
  end)

  it("has nothing but the allow-list", function()
    for _, name in ipairs { "io", "os", "debug", "package", "require", "load", "loadstring", "loadfile", "dofile",
      "pcall", "xpcall", "coroutine", "string", "utf8", "setmetatable", "getmetatable", "rawset", "rawget",
      "rawequal", "rawlen", "collectgarbage", "print", "setfenv", "getfenv", "newproxy", "module", "jit", "ffi",
      "bit", "bit32", "_G", "ylm" } do
      refuses("EFORMAT", "attack.lua:1: there is no '" .. name .. "'", "local x = " .. name .. " return scene 'x' {}")
    end
  end)

  it("has no string methods, and strings have them again afterwards", function()
    refuses("EFORMAT", "no string methods", "local s = ('x'):rep(2^30)")
    refuses("EFORMAT", "no string methods", "local s = ('').format")
    refuses("EFORMAT", "no string methods", "local s = (('x'))['gsub']")
    refuses("EFORMAT", "no string methods", "local s = 'x' for i, v in ipairs(s.len) do end")
    refuses("EFORMAT", ".", "local f = function(s) return s.dump end f(math.pi .. '')(f)")
    refuses("ELIMIT", "instructions", "while true do end")
    assert.equal("xx", ("x"):rep(2))
  end)

  it("leaves the host as it was: hooks, strings, math, tables", function()
    local sort, random, hook = table.sort, math.random, debug.gethook()
    try "math.sin = nil table.sort = nil math.random(3) scene = nil assert = nil return 1"
    assert.equal(sort, table.sort)
    assert.equal(random, math.random)
    assert.equal(hook, (debug.gethook()))
    assert.truthy(math.sin)
    assert.truthy(try "return scene 'x' {}")
  end)

  it("accepts text only", function()
    local code = string.dump(assert((loadstring or load)("return 1")))
    refuses("EFORMAT", "compiled Lua", code)
    refuses("EFORMAT", "compiled Lua", "#\n" .. code)
    refuses("EFORMAT", "compiled Lua", "\239\187\191" .. code)
    refuses("EFORMAT", "compiled Lua", "# x\n\27LJ\2")
  end)

  it("ends endless loops, however they are written", function()
    for _, text in ipairs {
      "while true do end",
      "repeat until false",
      "for i = 1, math.huge do end",
      "local function f() return f() end f()",
      "local t = {} for i = 1, 1e9 do t[1] = i end",
      "table.sort({3, 2, 1}, function() while true do end end)",
      "local t = {} for i = 1, 1e9 do table.insert(t, 1, i) t[2] = nil end",
      "for _ in next, {1}, nil do while true do local x = math.sin(1) end end",
      "local a = {} for i = 1, 24 do a = { a, a } end return scene 'x' { geometry = a }",
    } do
      local _, message, code = try(text)
      assert.equal("ELIMIT", code, text .. ": " .. tostring(message))
    end
  end)

  it("ends deep recursion", function()
    for _, text in ipairs {
      "local function f(n) return 1 + f(n + 1) end f(1)",
      "local function f(...) return 1 + f(1, ...) end f()",
      "local t = {} for i = 1, 1e5 do t = { t } end return scene 'x' { geometry = t }",
      "local t = {} t[1] = t return scene 'x' { geometry = t }",
      "return " .. ("("):rep(1e5) .. "1" .. (")"):rep(1e5),
      "return " .. ("{"):rep(1e5) .. ("}"):rep(1e5),
      "return " .. ("- "):rep(1e5) .. "1",
      "return " .. ("1 .. "):rep(1e5) .. "1",
    } do
      local scene, message, code = try(text)
      assert.is_nil(scene)
      assert.truthy(code == "EFORMAT" or code == "ELIMIT", message)
    end
  end)

  it("bounds memory, one block of it, and how much is copied", function()
    for _, text in ipairs {
      "local s = 'x' while true do s = s .. s end",
      "local t = {} for i = 1, 1e9 do t[i] = i end",
      "local t = {} while true do t = { t, {}, {} } end",
      "local t = {} for i = 1, 1e7 do t[i] = 'x' .. i end",
      "local s = 'x' for i = 1, 21 do s = s .. s end for i = 1, 1e6 do local t = s .. i end",
      "local s = 'x' for i = 1, 20 do s = s .. s end table.concat({ s, s, s, s, s, s, s, s, s, s, s, s, s })",
    } do
      local _, message, code = try(text)
      assert.equal("ELIMIT", code, text .. ": " .. tostring(message))
    end
    refuses("ELIMIT", "16777216 bytes of memory", "local s = 'x' while true do s = s .. s end")
    collectgarbage()
    collectgarbage()
    assert.truthy(try "return scene 'x' {}")
  end)

  it("bounds processor time, where single instructions are slow", function()
    local began = os.clock()
    refuses("ELIMIT", "seconds of processor time", [[
      local s = "x" for i = 1, 21 do s = s .. s end
      local a, b = s .. "1", s .. "2"
      local n = 0
      for i = 1, 1e9 do if a < b then n = n + 1 end end]], { time_limit = 0.3, instructions = 1e12 })
    assert.truthy(os.clock() - began < 5)
  end)

  it("keeps descriptions opaque, so that no object of the library can be reached", function()
    refuses("EFORMAT", "attack.lua:2: a scene is a description: its field '__index' cannot be read",
      "local s = scene 'x' {}\nlocal m = s.__index")
    refuses("EFORMAT", "make another instead", "local s = scene 'x' {} s.name = 'y' return s")
    refuses("EFORMAT", "cannot be part of a description", "return scene 'x' { background = function() end }")
    refuses("EFORMAT", "cannot be part of a description", "return scene 'x' { lights = { next } }")
    refuses("EFORMAT", "cannot be a key", "return scene 'x' { [{}] = 1 }")
    refuses("EFORMAT", "cannot be a key", "return scene 'x' { [true] = 1 }")
    refuses("EFORMAT", "a box is a description: its field 'mesh' cannot be read", "local m = box {}.mesh")
    refuses("EFORMAT", "a sphere_light is a description", "local l = sphere_light { at = { 0, 0, 0 } } l.radius = 1")
    refuses("EFORMAT", "a table of named fields expected, got a", "sphere_light(sphere_light { at = { 0, 0, 0 } })")
    refuses("EFORMAT", "attack.lua:2: tables nested more than 64 deep",
      "local t = {} for i = 1, 70 do t = { t } end\nreturn scene 'x' { geometry = t }")
    refuses("EFORMAT", "attack.lua:1: scene: geometry must be geometry.*, got a scene",
      "return scene 'x' { geometry = scene 'y' {} }")
    local scene = assert(try "local s = scene 'x' {} for k in pairs(s) do error(k) end return s")
    assert.equal("x", scene.name)
  end)

  it("is not fooled by changes to a table after it was described", function()
    local scene = assert(try [[
      local colour = { 1, 2, 3 }
      local s = scene 'x' { background = colour }
      colour[1] = "not a number"
      return s]])
    assert.same({ 1, 2, 3 }, scene.background)
  end)

  it("bounds what is described, before it is built", function()
    refuses("ELIMIT", "attack.lua:1: knot: more than 20000000 triangles", "knot { divide = { 1e6, 1e6 } }")
    refuses("ELIMIT", "attack.lua:1: box: more than 20000000 triangles", "box { divide = 1e5 }")
    refuses("ELIMIT", "sphere: more than 100000 triangles",
      "for i = 1, 1000 do sphere { divide = { 100, 10 } } end", { triangles = 1e5 })
    refuses("ELIMIT", "uniform_grid: more than 16777216 cells", "uniform_grid { cells = 400 }")
    refuses("ELIMIT", "adaptive_grid: lmax at most 8 in a scene file, got 9",
      "adaptive_grid { lmax = 9 }", { lmax = 8 })
    refuses("ELIMIT", "adaptive_grid: depth at most 12 in a scene file, got 16", "adaptive_grid { depth = 16 }")
    refuses("ELIMIT", "torus: more than 100 triangles", "torus {}", { triangles = 100 })
    assert(try("return scene 'x' { geometry = knot { divide = { 300, 8 } } }"))
    local lights = "local at = {} for i = 1, %d do at[i] = { 0, 1, i } end\n"
      .. "local l = virtual_lights { at = at, radius = 1, intensity = 1 } return scene 'x' { lights = %s }"
    assert.equal(10000, assert(try(lights:format(10000, "l"))).lights[1].count)
    refuses("ELIMIT", "attack.lua:2: virtual_lights: more than 10000 virtual_lights in one scene file", lights:format(10001, "l"))
    refuses("ELIMIT", "more than 10000 virtual_lights", lights:format(6000, "{ l, l }"))
    refuses("ELIMIT", "more than 12 virtual_lights", lights:format(13, "l"), { virtual_lights = 12 })
    assert.equal(20000, assert(try(lights:format(20000, "l"), { virtual_lights = 20000 })).lights[1].count)
  end)

  it("reads files only by relative names inside the scene's folder", function()
    scratch.shell("cd " .. scratch.quote(folder.path)
      .. " && mkdir -p in/side && ln -sf /etc in/etc && ln -sf ../out.obj in/link.obj && mkfifo in/pipe")
    local triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    folder:write("out.obj", triangle)
    folder:write("in/here.obj", triangle)
    folder:write("in/side/there.obj", triangle)
    local function mesh(name)
      return try(("return scene 'x' { geometry = mesh { file = %q } }"):format(name), nil, "in/attack.lua")
    end
    for _, name in ipairs { "here.obj", "side/there.obj", "./here.obj" } do
      local scene = assert(mesh(name))
      assert.equal(1, #scene.geometry[1].mesh:triangles())
    end
    for name, says in pairs {
      ["../out.obj"] = "relative, without '..'", ["side/../here.obj"] = "without '..'", ["/etc/passwd"] = "relative",
      [folder.path .. "/in/here.obj"] = "relative", ["etc/passwd"] = "link that leads out",
      ["link.obj"] = "link that leads out", ["side"] = "a folder, not a file", ["pipe"] = "not a regular file",
      [""] = "relative", ["missing.obj"] = "no such file", ["here.obj/"] = "relative", ["side//there.obj"] = "relative",
      ["here.obj\0.png"] = "relative", ["attack.lua"] = "attack.lua",
    } do
      local scene, message, code = mesh(name)
      assert.is_nil(scene, name)
      assert.truthy(message:find(says, 1, true), name .. ": " .. message)
      assert.truthy(message:find("in/attack.lua:1: mesh: ", 1, true), name .. ": " .. message)
      assert.truthy(code == "EFORMAT" or code == "EIO", code)
    end
    local path = folder:write("in/attack.lua", "return scene 'x' { geometry = mesh { file = 'here.obj' } }")
    local _, message, code = ylm.load(path, { file_size = 10 })
    assert.equal("ELIMIT", code, message)
  end)

  --- Images in the folder `pictures` and out of it, good ones, links and files whose headers lie.
  local function write_pictures()
    scratch.shell("cd " .. scratch.quote(folder.path) .. " && mkdir -p pictures && cd pictures && ln -sf /etc/passwd link.png"
      .. " && ln -sf ../outside.exr out.exr && rm -f pipe.png && mkfifo pipe.png && mkdir -p folder.png")
    local function image(w, h)
      local x = ylm.image { size = { w, h }, layers = { { "radiance", 3 } } }
      x:fill(1, 1, w, h, { 1, 2, 3 })
      return x
    end
    assert(image(4, 2):save(folder.path .. "/outside.exr"))
    for _, name in ipairs { "here.exr", "here.hdr", "here.png", "here.pfm" } do
      assert(image(4, 2):save(folder.path .. "/pictures/" .. name))
    end
    assert(image(64, 64):save(folder.path .. "/pictures/large.png"))
    local many = {}
    for i = 1, 12 do many[i] = { "layer" .. i, 4 } end
    assert(ylm.image { size = { 64, 64 }, layers = many }:save(folder.path .. "/pictures/many.exr"))
    local nan = image(4, 2)
    nan:layer():set(2, 2, 3, 0 / 0)
    assert(nan:save(folder.path .. "/pictures/nan.exr"))
    local whole = io.open(folder.path .. "/pictures/large.png", "rb"):read "*a"
    folder:write("pictures/cut.png", whole:sub(1, #whole - 40))
    -- headers that promise much more than there is: 20000 x 20000 in every format
    folder:write("pictures/bomb.png", whole:sub(1, 16) .. "\0\0\78\32\0\0\78\32\8\2\0\0\0\108\18\209\110" .. whole:sub(34))
    folder:write("pictures/bomb.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 20000\n" .. ("\2"):rep(999))
    folder:write("pictures/bomb.pfm", "PF\n20000 20000\n-1.0\n" .. ("\0"):rep(999))
    local exr = io.open(folder.path .. "/pictures/here.exr", "rb"):read "*a"
    local at = exr:find("dataWindow", 1, true) + #"dataWindow\0box2i\0" + 4
    folder:write("pictures/bomb.exr", exr:sub(1, at + 7) .. "\31\78\0\0\31\78\0\0" .. exr:sub(at + 16))
  end

  it("reads textures so too, and no more texels than are allowed, whatever their headers say", function()
    write_pictures()
    local function panel(fields, limits)
      return try(("\nreturn scene 'x' { lights = textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, "
        .. "%s } }"):format(fields), limits, "pictures/attack.lua")
    end
    for _, name in ipairs { "here.exr", "here.hdr", "here.png", "here.pfm", "./here.png" } do
      local scene = assert(panel(("file = %q"):format(name)))
      assert.equal(4, scene.lights[1].texels.shape[2], name)
    end
    for name, says in pairs {
      ["../outside.exr"] = "without '..'", ["/etc/passwd"] = "relative", ["out.exr"] = "link that leads out",
      ["link.png"] = "link that leads out", ["pipe.png"] = "not a regular file", ["folder.png"] = "a folder, not a file",
      [""] = "relative", ["missing.png"] = "no such file", ["here.png\0"] = "relative", ["attack.lua"] = "not an image",
      ["nan.exr"] = "image must be finite", ["cut.png"] = "cut.png: ", ["bomb.png"] = "numbers", ["bomb.hdr"] = "numbers",
      ["bomb.pfm"] = "numbers", ["bomb.exr"] = "bomb.exr: ",
    } do
      local scene, message, code = panel(("file = %q"):format(name))
      assert.is_nil(scene, name)
      assert.truthy(message:find(says, 1, true), name .. ": " .. message)
      assert.truthy(message:find("pictures/attack.lua:2: textured_light: ", 1, true), name .. ": " .. message)
      assert.truthy(code == "EFORMAT" or code == "EIO" or code == "ELIMIT", code)
    end
    for _, case in ipairs {
      { "file = 'large.png'", { texels = 64 * 64 - 1 }, "more than" },
      { "file = 'many.exr'", { texels = 64 * 64 }, "more than 16384 numbers" },
      { "file = 'many.exr'", { file_size = 500 }, "more than 500 bytes" },
      { "image = { { 1, 2 }, { 3, 4 } }", { texels = 3 }, "more than 3 texels in one scene file" },
      { "image = (function() local r = {} for i = 1, 2000 do r[i] = 1 end return { r, r, r } end)()", { texels = 5999 },
        "more than 5999 texels" },
    } do
      local scene, message, code = panel(case[1], case[2])
      assert.is_nil(scene)
      assert.truthy(message:find(case[3], 1, true), message)
      assert.equal("ELIMIT", code, message)
    end
    assert(panel("file = 'large.png'", { texels = 64 * 64 }))
    -- of all together
    local two = "local function t() return textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, "
      .. "file = 'pictures/here.png' } end return scene 'x' { lights = { t(), t() } }"
    assert(try(two, { texels = 16 }))
    refuses("ELIMIT", "more than", two, { texels = 15 })
    -- what a description may not be
    for fields, says in pairs {
      ["image = function() end"] = "cannot be part of a description", ["image = scene 'y' {}"] = "got a scene",
      ["image = { { box {} } }"] = "image", ["image = { 1 }"] = "rows of texels", ["image = { {}, { 1 } }"] = "rows of texels",
      ["image = { { 1 }, nil, { 1 } }, file = 'here.png'"] = "image or file, not both",
      ["image = { { 1, 2 }, { x = 3 } }"] = "does not fit", ["image = { { 0 / 0 } }"] = "image must be finite",
      ["file = {}"] = "file must be a string", ["image = 'here.png'"] = "rows of texels",
      ["image = { { 1 } }, largest = 0"] = "largest must be",
    } do
      local scene, message, code = panel(fields)
      assert.is_nil(scene, fields)
      assert.truthy(message:find(says, 1, true), fields .. ": " .. message)
      assert.equal("EFORMAT", code, message)
    end
    local scene = assert(panel "image = { { 1 } }")
    assert.truthy(scene.lights[1].count == 1)
    refuses("EFORMAT", "a textured_light is a description: its field 'texels' cannot be read",
      "local t = textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, image = { { 1 } } }.texels")
  end)

  it("looks at shapes, and counts their numbers, before it copies rows that are shared", function()
    local wide = "local row, rows = {}, {} for i = 1, 4000 do row[i] = 0 rows[i] = row end "
    local cube = "local t = { 0, 0, 0 } for k = 1, 3 do local u = {} for i = 1, 400 do u[i] = t end t = u end "
    local began = os.clock()
    for text, says in pairs {
      [wide .. "sphere_lights { at = rows }"] = "sphere_lights: at must be %[n%]%[3%] numbers, got an array of 4000x4000",
      [wide .. "sphere_lights { at = { { 0, 0, 0 } }, radius = rows }"] = "radius must be .*, got an array of 4000x4000",
      [wide .. "sphere_lights { at = { { 0, 0, 0 } }, radiance = rows }"] = "radiance must be .*, got an array of 4000x4000",
      [wide .. "polygon_light { vertices = rows }"] = "vertices must be three or more points",
      [wide .. "mesh { vertices = rows, triangles = rows }"] = "points: rows of 3 numbers expected, got an array of 4000x4000",
      [wide .. "mesh { vertices = { { 0, 0, 0 } }, triangles = rows }"] = "triangles: rows of 3 numbers expected",
      [wide .. "mesh { vertices = { { 0, 0, 0 } }, normals = rows, triangles = { { 1, 2, 3 } } }"] = "normals: rows of 3",
    } do refuses("EFORMAT", says, text) end
    refuses("ELIMIT", "more than 8388608 numbers in one scene file", cube .. "mesh { vertices = t, triangles = {} }")
    assert.truthy(os.clock() - began < 3)
    -- what is shared counts as often as it is described
    local lights = "local p, at = { 0, 0, 0 }, {} for i = 1, 1000 do at[i] = p end "
    assert(try(lights .. "return scene 'x' { lights = sphere_lights { at = at } }", { numbers = 7002 }))
    refuses("ELIMIT", "sphere_lights: more than 7001 numbers", lights .. "sphere_lights { at = at }", { numbers = 7001 })
    refuses("ELIMIT", "points: more than 200 numbers", lights .. "mesh { vertices = at, triangles = {} }", { numbers = 200 })
  end)

  it("counts what is listed again, lights, and pieces of geometry", function()
    local again = "local t, x = {}, %s for i = 1, 100 do t[i] = x end return scene 'x' { %s = t }"
    local boxes = again:format("box { divide = 2 }", "geometry")
    assert(try(boxes, { triangles = 4800 }))
    refuses("ELIMIT", "scene: more than 4799 triangles", boxes, { triangles = 4799 })
    refuses("ELIMIT", "scene: more than 1000 numbers",
      again:format("sphere_lights { at = { { 0, 0, 0 }, { 1, 0, 0 } } }", "lights"), { numbers = 1000 })
    refuses("ELIMIT", "disk_light: more than 1000 numbers",
      "for i = 1, 4 do disk_light { at = { 0, 0, 0 }, normal = { 0, 0, 1 } } end", { numbers = 1000 })
    refuses("ELIMIT", "box: more than 1000 numbers", "for i = 1, 20 do box {} end", { numbers = 1000 })
  end)

  it("refuses a material that is none when the scene is read", function()
    refuses("EFORMAT", "attack.lua:1: box: material must be a material %(matte.*%), got 'x'", "box { material = 'x' }")
    refuses("EFORMAT", "sphere: material must be a material %(matte.*%), got a table", "sphere { material = {} }")
  end)

  it("names the file's own line where functions of the sandbox meet what they cannot use", function()
    for text, says in pairs {
      ["\nmath.atan('x')"] = "bad argument #1 to 'atan'", ["\nmath.pow({}, 2)"] = "attempt to perform arithmetic",
      ["\nlocal x = table.concat({ 1, 2 }, {})"] = "attempt to concatenate",
      ["\ntable.sort({ 1, 'a', 2 })"] = "attempt to compare",
    } do refuses("EFORMAT", "attack%.lua:2: " .. says, text) end
    for _, text in ipairs { "local function f() return 1 + f() end f()", "local t = {} t[1] = t box { bounds = t }" } do
      local _, message = try(text)
      assert.is_nil(message:gsub("attack%.lua", ""):find "%.lua")
    end
  end)

  it("shows a terminal nothing to obey", function()
    local _, message = try "error('\\27[2J\\7')"
    assert.is_nil(message:find("%c"))
    for bytes, shown in pairs {
      ["\194\155" .. "31m"] = "??31m", ["\155" .. "31m"] = "?31m", ["\226\128\174abc"] = "???abc", ["\192\155"] = "??",
      ["\195\164 \226\136\135 \240\157\145\145"] = "\195\164 \226\136\135 \240\157\145\145", ["\237\160\128"] = "???",
      ["\195"] = "?", ["\127"] = "?",
    } do
      refuses("EFORMAT", "attack.lua:1: <" .. shown:gsub("%?", "%%?") .. ">$", "error('<" .. bytes .. ">')")
      local code = select(3, try("return scene '" .. bytes .. "' {}"))
      assert.equal(shown ~= bytes and "EFORMAT" or nil, code)
      _, message = try(("mesh { file = '%s.obj' }"):format(bytes))
      assert.truthy(message:find(shown .. ".obj", 1, true), message)
    end
    assert.equal("EFORMAT", (select(3, try("return scene '" .. ("x"):rep(1e6) .. "' {}"))))
    _, message = try("error('" .. ("\195\164"):rep(1e5) .. "')")
    assert.truthy(#message < 1200)
    local out = scratch.capture((os.getenv "YLM_BUILD" or "build") .. "/ylm render -o x.png " .. scratch.quote "no\155\27[2J.lua")
    assert.truthy(out:find("no??[2J.lua", 1, true), out)
  end)

  it("ends cleanly when it is tried again and again", function()
    for _ = 1, 20 do
      try "while true do end"
      try("local s = 'x' while true do s = s .. s end", { memory = 2 ^ 20 })
      assert.truthy(try "return scene 'x' {}")
    end
    assert.is_nil((debug.gethook()))
  end)

  it("bounds ylm's own loops too, compiled or not", function()
    if jit then assert.is_true((jit.status())) end
    for _ = 1, 3 do -- so that a compiler would have compiled them
      refuses("ELIMIT", "more than 2000000 instructions",
        "local a = box {} for i = 1, 31 do a = { a, a } end return scene 'x' { geometry = a }")
    end
    if jit then assert.is_true((jit.status())) end
  end)

  it("says the limit of memory where a source is too large to be compiled, whatever the Lua", function()
    refuses("ELIMIT", "takes more than 1048576 bytes of memory",
      "local t = {" .. ("{1,2},"):rep(20000) .. "} return scene 'x' {}", { memory = 2 ^ 20 })
  end)

  it("does not run inside itself", function()
    assert.has_error(function() ylm.load(3) end)
    assert.has_error(function() ylm.load("x.lua", { instructions = 0 }) end)
    assert.has_error(function() ylm.load("x.lua", { instruction = 5 }) end)
  end)

  it("reads only regular files", function()
    local _, message, code = ylm.load(folder.path .. "/missing.lua")
    assert.equal("EIO", code, message)
    _, message, code = ylm.load(folder.path)
    assert.equal("EIO", code, message)
    _, message, code = ylm.load "/dev/zero"
    assert.equal("EIO", code, message)
    scratch.shell("mkfifo " .. folder.path .. "/pipe.lua")
    _, message, code = ylm.load(folder.path .. "/pipe.lua")
    assert.equal("EIO", code, message)
  end)
end)
