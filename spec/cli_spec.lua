-- The command-line tool: what it prints where, and its exit statuses.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

describe("the command-line tool", function()
  local folder, ylm
  setup(function()
    folder = scratch.new()
    ylm = tool.runner(folder)
  end)
  teardown(function() folder:remove() end)

  local function file(name, text) return scratch.quote(folder:write(name, text)) end

  it("lists its commands, and says so where it is used wrongly", function()
    local err, _
    local out, code = ylm "--help"
    assert.equal(0, code)
    for _, name in ipairs { "render", "bake", "view", "compare", "sh", "material", "run", "codegen", "bench", "info", "help" } do
      assert.truthy(out:find("\n  " .. name .. " ", 1, true), name)
      local usage
      usage, code = ylm(name .. " --help")
      assert.equal(0, code)
      assert.truthy(usage:find("usage: ylm " .. name, 1, true), usage)
    end
    out, code, err = ylm ""
    assert.equal(2, code)
    assert.equal("", out)
    assert.truthy(err:find "usage: ylm COMMAND")
    _, code, err = ylm "rendr x.lua"
    assert.equal(2, code)
    assert.equal("ylm: no command 'rendr' (did you mean 'render'?)\n", err)
    _, code, err = ylm "info --jsn"
    assert.equal(2, code)
    assert.truthy(err:find("no option --jsn (did you mean --json?)", 1, true), err)
    for _, words in ipairs { "info x y", "render", "render a.lua --size 3", "render a.lua --samples x", "render a.lua -o",
      "render a.lua", "bake a.lua -o b.exr", "compare a.exr", "run", "info --json=1", "render a.lua -o b.exr --by x" } do
      local _, status, text = ylm(words)
      assert.equal(2, status, words .. ": " .. text)
      assert.truthy(#text > 0)
    end
  end)

  it("prints what it is made of, as words and as JSON", function()
    local out, code, err = ylm "info"
    assert.equal(0, code)
    assert.equal("", err)
    assert.truthy(out:find("^version +%d+%.%d+%.%d+\n"))
    assert.truthy(out:find("\nparts +core"), out)
    out, code = ylm "info --json"
    assert.equal(0, code)
    assert.truthy(out:find('^{"'))
    assert.truthy(out:find('"threads":%d+'))
    assert.truthy(out:find('"kernels":%["reference"'))
  end)

  it("prints what a file holds: of a grid its header and sections, of others a few lines", function()
    local program = file("files.lua", [[
local ylm, folder = require "ylm", ...
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 1, depth = 2,
  tolerance = 0.05 }, lamp, { occupied = ylm.array { { 0.1, 0.9, 0 } } })
assert(grid:save(folder .. "/a.ylm"))
assert(ylm.zeros { 3, 2 }:save(folder .. "/a.npy"))
local picture = ylm.image { size = { 3, 2 }, layers = { { "radiance", 3 }, { "depth", 1 } } }
picture.metadata.note = "ø\27[31m\155\194\155!"
assert(picture:save(folder .. "/a.exr"))
assert(ylm.box {}.mesh:save(folder .. "/a.ply"))]])
    local folded = scratch.quote(folder.path)
    local out, code, err = ylm(("run %s %s"):format(program, folded))
    assert.equal(0, code, err)
    local function says(name, ...)
      out, code, err = ylm("info " .. scratch.quote(folder.path .. "/" .. name))
      assert.equal(0, code, err)
      for _, line in ipairs { ... } do assert.truthy(("\n" .. out):find("\n" .. line), line .. "\n" .. out) end
    end
    says("a.ylm", "kind +adaptive grid\n", "lmax +1\n", "channels +3\n", "bounds +%-1 %-1 %-1 1 1 1\n", "levels +%d\n",
      "points +%d+\n", "interpolated +%d+\n", "invalid +0\n", "tolerance +0.05\n", "error +[%d.e-]+\n", "met +true\n",
      "version +2\n", "bytes +%d+\n", "section rows +%d+ bytes\n")
    says("a.npy", "kind +array\n", "shape +3 2\n", "dtype +double\n")
    says("a.exr", "kind +image\n", "size +3 2\n", "layers +radiance %(3%) depth %(1%)\n", "metadata note +ø%?%[31m%?%?%?!\n")
    says("a.ply", "kind +mesh\n", "triangles +12\n", "area +6\n")
    out, code = ylm("info --json " .. folded .. "/a.ylm")
    assert.equal(0, code)
    assert.truthy(out:find('"sections":%[{"bytes":136,"known":true,"name":"form","offset":640'), out)
    out, code, err = ylm "info no/such/file.ylm"
    assert.equal("", out)
    assert.equal(1, code)
    assert.truthy(err:find("no/such/file.ylm: No such file", 1, true), err)
    -- the header alone is read: a grid whose rows are damaged is still described
    local text = folder:read "a.ylm"
    local damaged = file("damaged.ylm", text:sub(1, -70) .. "x" .. text:sub(-68))
    code = select(2, ylm("info " .. damaged))
    assert.equal(0, code)
    out, code, err = ylm("info " .. file("cut.ylm", text:sub(1, 700)))
    assert.equal("", out)
    assert.equal(1, code)
    assert.truthy(err:find("the grid file is damaged", 1, true), err)
  end)

  it("prints what a scene file describes, within the limits of scene files", function()
    local name = file("room.lua", [[
local white = matte { albedo = 0.5 }
return scene "a room" {
  camera = camera { from = { 1, 2, 3 }, at = { 0, 1, 0 }, fov = 50 },
  geometry = { box { material = white }, quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = white },
    sphere { at = { 0, 3, 0 }, divide = { 8, 4 }, material = ggx { alpha = 0.2 } } },
  lights = { sphere_light { at = { 0, 2, 0 } }, sphere_lights { at = { { 1, 1, 1 }, { 2, 1, 1 } } } },
  probes = adaptive_grid { lmax = 3, depth = 5, tolerance = 0.02 },
}]])
    local out, code, err = ylm("info " .. name)
    assert.equal(0, code, err)
    for _, line in ipairs { "kind +scene\n", "name +a room\n", "meshes +3\n", "triangles +62\n", "bounds +%-2 %-1 %-2 2 4 2\n",
      "materials +ggx 1, matte 1\n", "lights +sphere_light 1, sphere_lights 2\n", "camera .*fov 50, from 1 2 3",
      "probes .*depth 5, .*kind adaptive_grid, lmax 3, .*tolerance 0.02" } do
      assert.truthy(out:find("\n" .. line) or ("\n" .. out):find("\n" .. line), line .. "\n" .. out)
    end
    out, code = ylm("info --json " .. name)
    assert.equal(0, code)
    assert.truthy(out:find('"lights":{"sphere_light":1,"sphere_lights":2}', 1, true), out)
    assert.equal(5, select(2, ylm("info " .. file("endless.lua", "while true do end"))))
    out, code, err = ylm("info " .. file("wrong.lua", "return scene 'x' { camera = os.exit(0) }"))
    assert.equal("", out)
    assert.equal(3, code)
    assert.truthy(err:find("wrong.lua:1: ", 1, true), err)
  end)

  it("helps on words", function()
    local out, code = ylm "help zeros"
    assert.equal(0, code)
    assert.truthy(out:find("ylm.zeros(shape [, dtype])", 1, true))
    out, code = ylm "help scene"
    assert.equal(0, code)
    assert.truthy(out:find("background", 1, true))
    out, code = ylm "help all"
    assert.equal(0, code)
    assert.truthy(out:find("\n  sh.eval ", 1, true))
    for _, command in ipairs { "run", "bench", "codegen", "help" } do
      out, code = ylm("help " .. command)
      assert.equal(0, code)
      assert.truthy(out:find("ylm " .. command, 1, true), out)
    end
    local _, bad, err = ylm "help zerso"
    assert.equal(2, bad)
    assert.equal("ylm: no help on 'zerso' (did you mean 'zeros'?)\n", err)
  end)

  it("generates code", function()
    local out, code = ylm "codegen --lmax 2 --derivatives 1"
    assert.equal(0, code)
    assert.truthy(#out > 500)
    local glsl
    glsl, code = ylm "codegen --lmax 1 --language glsl"
    assert.equal(0, code)
    assert.truthy(glsl:find "void ", glsl)
    assert.equal(glsl, (ylm "codegen --lmax=1 --language=glsl"))
    local err = select(3, ylm "codegen --lmx 4")
    assert.truthy(err:find("unknown option --lmx (did you mean --lmax?)", 1, true), err)
    for _, words in ipairs { "", "--lmax -1", "--lmax 4 --language pascal", "--lmux 4", "--lmax 4 --unit=1" } do
      code = select(2, ylm("codegen " .. words))
      assert.equal(2, code, words)
    end
  end)

  it("runs experiments with arguments and passes their status on", function()
    local out, code = ylm("run " .. file("a.lua", [[
      local ylm = require "ylm"
      local a, b = ...
      print(arg[0]:match "[^/]*$", a, b, #arg, ylm.sh.count(4))
      return 7]]) .. " --one 'two words'")
    assert.equal("a.lua\t--one\ttwo words\t2\t25\n", out)
    assert.equal(7, code)
    local _, err
    _, code, err = ylm("run " .. file("b.lua", "\nlocal x = nil + 1"))
    assert.equal(3, code)
    assert.truthy(err:find("b.lua:2: attempt to perform arithmetic", 1, true), err)
    _, code, err = ylm("run " .. file("c.lua", "x ="))
    assert.equal(3, code)
    assert.truthy(err:find("c.lua:1:", 1, true), err)
    _, code, err = ylm "run missing.lua"
    assert.equal(1, code)
    assert.truthy(err:find("missing.lua", 1, true), err)
  end)

  it("runs words of the command line, with ylm at hand and all that follows as arguments", function()
    local out, code, err = ylm "run -e 'print(ylm.sh.count(4), arg[0], #arg, ...) return 9' --one -q -- two"
    assert.equal("25\t-e\t4\t--one\t-q\t--\ttwo\n", out .. err)
    assert.equal(9, code)
    local _
    _, code, err = ylm "run -e 'x ='"
    assert.equal(3, code)
    assert.truthy(err:find "^ylm: %-e:1: ", err)
    _, code, err = ylm "run -e"
    assert.equal(2, code)
    assert.truthy(err:find("run: -e: CODE expected", 1, true), err)
  end)

  it("passes each line of an experiment on as it is printed, though stdout is no terminal", function()
    local path = folder.path .. "/lines"
    local _, code, err = ylm(("run -e %s %s"):format(
      scratch.quote [[print "one"; io.write "two\nthr"; io.stderr:write(io.open((...)):read "*a")]], scratch.quote(path)),
      scratch.quote(path))
    assert.equal(0, code, err)
    assert.equal("one\ntwo\n", err)
    assert.equal("one\ntwo\nthr", folder:read "lines")
  end)

  it("looks at names and numbers before it works", function()
    local scene = file("early.lua", [[return scene "early" {
      camera = camera { from = { 2, 2, 3 } }, geometry = box {}, lights = sphere_light { at = { 0, 2, 0 } },
      probes = adaptive_grid { lmax = 1, depth = 1 } }]])
    for words, says in pairs {
      ["render " .. scene .. " -o x.jpg"] = "render: x.jpg: the name must end in .exr, .png, .hdr, .pfm",
      ["bake " .. scene .. " -o x.grid"] = "bake: x.grid: the name must end in .ylm, .vtu",
      ["view x.ylm -o x.exr"] = "view: x.exr: the name must end in .png",
      ["render " .. scene .. " -o x.png --size 0x9"] = "size must be { width, height }, integers from 1 to 65536",
      ["render " .. scene .. " -o x.png --samples -1"] = "samples must be an integer >= 1",
      ["bake " .. scene .. " -o x.ylm --occupied nowhere"] =
        "--occupied is surfaces, camera, vertices or everywhere, got 'nowhere'",
      ["bake " .. scene .. " -o x.ylm --size 8x8"] = "leave them out, or give --occupied camera",
      ["help --json zeros"] = "no option --json", ["bench --json"] = "no option --json",
    } do
      local _, code, err = ylm(words)
      assert.equal(2, code, words .. ": " .. err)
      assert.truthy(err:find(says, 1, true), err)
      assert.is_nil(err:find("shading", 1, true), err)
    end
  end)

  it("tries the output's folder before it works", function()
    local scene = file("slow.lua", [[return scene "slow" {
      camera = camera { from = { 2, 2, 3 } }, geometry = box {}, lights = sphere_light { at = { 0, 2, 0 } },
      probes = adaptive_grid { lmax = 1, depth = 1 } }]])
    local nowhere = " -o " .. scratch.quote(folder.path .. "/nowhere/x.")
    for words, extension in pairs { ["render " .. scene] = "exr", ["bake " .. scene] = "ylm", ["view missing.ylm"] = "png",
      ["compare missing.exr missing.exr"] = "png" } do
      local out, code, err = ylm(words .. nowhere:gsub("%.'$", "." .. extension .. "'"))
      assert.equal(1, code)
      assert.equal("", out)
      assert.truthy(err:find("nowhere/x." .. extension .. ": cannot be created: ", 1, true), err)
      assert.is_nil(err:find("missing", 1, true), err) -- what would have been found next
      assert.is_nil(err:find("\n.", 1), err) -- no progress before
    end
    local _, code, err = ylm("render missing.lua -o " .. scratch.quote(folder.path .. "/kept.png"))
    assert.equal(1, code, err)
    assert.is_nil(folder:read "kept.png") -- trying leaves nothing
    assert.equal("", (scratch.capture("ls " .. scratch.quote(folder.path) .. " | grep kept || true")))
  end)

  it("tells a missing scene from a wrong one and one that passes a limit", function()
    for command, extension in pairs { render = "exr", bake = "ylm" } do
      local output = " -o x." .. extension
      local _, code, err = ylm(command .. " missing.lua" .. output)
      assert.equal(1, code, err)
      assert.truthy(err:find("missing.lua", 1, true), err)
      _, code, err = ylm(command .. " " .. file("wrong.lua", "\nreturn scene 'x' { ligths = {} }") .. output)
      assert.equal(3, code, err)
      assert.truthy(err:find("wrong.lua:2: scene: no field 'ligths' (did you mean 'lights'?)", 1, true), err)
      _, code, err = ylm(command .. " " .. file("endless.lua", "local s = 'x' while true do s = s .. s end")
        .. output)
      assert.equal(5, code, err)
      assert.truthy(err:find("bytes of memory", 1, true), err)
    end
  end)

  it("bakes, renders, compares and views a scene file", function()
    local quote, path = scratch.quote, folder.path
    local scene = file("lamp.lua", [[
      return scene "lamp" {
        camera   = camera { from = { 2, 2, 3 }, at = { 0, 0, 0 } },
        geometry = { box {}, quad { corner = { -2, -0.5, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 8 } },
        lights   = sphere_light { at = { 0.5, 1.5, 0.5 }, radius = 0.1, radiance = 50 },
        probes   = adaptive_grid { lmax = 3, depth = 3, tolerance = 0.05 },
      }]])
    local small = " --size 48x27 --samples 2 "
    local _
    local out, code, err = ylm("bake " .. scene .. " --json -o " .. quote(path .. "/lamp.ylm"))
    assert.equal(0, code, err)
    assert.truthy(out:find '"points":%d+', out)
    for _, by in ipairs { "grid", "sum", "rays" } do
      out, code, err = ylm("render " .. scene .. small .. "--json --by " .. by .. " -o "
        .. quote(path .. "/" .. by .. ".exr"))
      assert.equal(0, code, err)
      assert.truthy(out:find '^{".*}\n$', out)
    end
    _, code, err = ylm("render " .. scene .. small .. "-q --grid " .. quote(path .. "/lamp.ylm") .. " --exposure 1 -o "
      .. quote(path .. "/again.png"))
    assert.equal(0, code, err)
    assert.equal("\137PNG", folder:read("again.png"):sub(1, 4))
    local images = quote(path .. "/grid.exr") .. " " .. quote(path .. "/sum.exr")
    out, code, err = ylm("compare " .. images .. " --difference " .. quote(path .. "/difference.pfm"))
    assert.equal(0, code, err)
    assert.truthy(out:find "^mse +%S+\nrmse", out)
    assert.truthy(folder:read "difference.pfm")
    assert.equal(4, select(2, ylm("compare " .. images .. " --max-mse 0")))
    assert.equal(4, select(2, ylm("compare " .. images .. " --min-psnr 1000")))
    assert.equal(0, select(2, ylm("compare " .. images .. " --max-mse 1e9 --min-psnr -1000")))
    for words, says in pairs { ["render " .. scene .. " -o x.png --grid " .. quote(path .. "/grid.exr")] = "not a grid",
      ["view " .. quote(path .. "/grid.exr") .. " -o x.png"] = "not a grid or SH vectors",
      ["compare " .. quote(path .. "/lamp.ylm") .. " " .. quote(path .. "/lamp.ylm")] = "not an image" } do
      out, code, err = ylm(words)
      assert.equal(1, code, err)
      assert.equal("", out)
      assert.truthy(err:find(says .. "\n$"), err)
    end
    local mesh = folder:write("tent.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    _, code, err = ylm("render " .. quote(mesh) .. " -o x.png")
    assert.equal(1, code)
    assert.truthy(err:find('tent.obj: a mesh, not a scene; a scene file names it: return scene "room"', 1, true), err)
    _, code, err = ylm("compare " .. scene .. " " .. scene)
    assert.equal(1, code)
    assert.truthy(err:find("lamp.lua: not an image", 1, true), err)
    _, code, err = ylm("render " .. scene .. small .. "-o " .. quote(path .. "/nowhere/x.exr"))
    assert.equal(1, code)
    assert.truthy(err:find("nowhere", 1, true), err)
  end)

  it("draws a grid, where VTK is built in", function()
    if not pcall(require, "ylm.c.vtk") then pending "built without VTK" end
    local picture = folder.path .. "/grid.png"
    local _, code, err = ylm("view " .. scratch.quote(folder.path .. "/lamp.ylm")
      .. " --quantity error --log --levels --size 160x90 -o " .. scratch.quote(picture))
    assert.equal(0, code, err)
    assert.equal("\137PNG", folder:read("grid.png"):sub(1, 4))
    local out
    out, code, err = ylm("view " .. scratch.quote(folder.path .. "/lamp.ylm") .. " --json --size 64x36 -o "
      .. scratch.quote(picture))
    assert.equal(0, code, err)
    assert.equal(('{"output":%q}\n'):format(picture), out)
    for words, says in pairs { ["--quantity eror"] = "did you mean 'error'", ["--range 1,0"] = "least < largest, got {1, 0}",
      ["--size 0x0"] = "got {0, 0}" } do
      _, code, err = ylm("view " .. scratch.quote(folder.path .. "/lamp.ylm") .. " " .. words .. " -o x.png")
      assert.equal(2, code, err)
      assert.truthy(err:find(says, 1, true), err)
    end
  end)

  --- Not under LuaJIT too: pictures are drawn by C.
  local drawn_once = long(os.getenv "YLM_LUA" ~= "luajit", true) and it or function() end
  drawn_once("draws every layer of a grid, a scene beside it, from where the options say", function()
    if not pcall(require, "ylm.c.vtk") then pending "built without VTK" end
    local quote, picture = scratch.quote, folder.path .. "/layers.png"
    local grid, scene = quote(folder.path .. "/lamp.ylm"), quote(folder.path .. "/lamp.lua")
    local drawn = {}
    for _, words in ipairs { " --quantity norm --iso-values 0.5,1,2", " --glyphs --count 50", " --lobes --count 50",
      " --quantity norm --iso-values 0.5,1,2 --from 5,4,6 --at 0,0,0 --up 0,0,1 --fov 30",
      " " .. scene .. " --lights --opacity 0.5 --slice y=-0.4,x --linear --no-bar" } do
      local _, code, err = ylm("view " .. grid .. words .. " --size 64x48 --supersample 1 -o " .. quote(picture))
      assert.equal(0, code, words .. ": " .. err)
      local image = folder:read "layers.png"
      assert.is_nil(drawn[image], words)
      drawn[image] = true
    end
    for words, says in pairs {
      [" --slice q"] = "--slice wants planes such as y=0.2 or x,z=1, got 'q'",
      [" --slice y=9"] = "slices: y = 9 is outside of the bounds", [" --iso-values 1,x"] = "--iso-values wants numbers",
      [" --at 1,2,3"] = "--at is of a camera: --from X,Y,Z says where it stands",
      [" --from 1,2,3 --at 1,2,3"] = "camera: from and at must be different points",
      [" --lights"] = "--lights is for scenes", [" --count 3"] = "--count is of --glyphs, --streamlines or --lobes",
      [" --log --linear"] = "--log or --linear, not both", [" --boxes --quantity norm"] = "boxes show a quantity of cells",
      [" --isosurfaces 99"] = "a number of surfaces from 1 to 16", [" --product"] = "--product is for SH vectors",
      [" " .. grid] = "one grid at a time", } do
      local _, code, err = ylm("view " .. grid .. words .. " -o x.png")
      assert.equal(2, code, words .. ": " .. err)
      assert.truthy(err:find(says, 1, true), err)
    end
    assert.truthy(ylm("view --help"):find("examples:\n\n  ylm view grid.ylm", 1, true))
  end)

  it("shows SH vectors of .npy files, their product and what a rotation makes of them", function()
    local ylm_ = require "ylm"
    local quote, path = scratch.quote, folder.path
    assert(ylm_.array({ { 1, 0, 2, 0 }, { 1, 0, 0, 0 } }):save(path .. "/two.npy"))
    assert(ylm_.array({ 0, 0, 0, 0, 0, 0, 1, 0, 0 }):save(path .. "/one.npy"))
    assert(ylm_.array({ 1, 2, 3 }):save(path .. "/bad.npy"))
    local files = quote(path .. "/two.npy") .. " " .. quote(path .. "/one.npy")
    local picture = path .. "/lobes.png"
    local drawn = pcall(require, "ylm.c.vtk")
    if drawn then
      local out, code, err = ylm("view " .. files .. " --product --rotate 1,0,0 --size 160x90 -o " .. quote(picture))
      assert.equal(0, code, err)
      assert.equal("\137PNG", folder:read("lobes.png"):sub(1, 4))
      for _, label in ipairs { "two 1: ylm, lmax 2", "two 2: ", "one: ", "product: ", "product, turned: ", "l 2 " } do
        assert.truthy(out:find(label, 1, true), out)
      end
      out, code, err = ylm("view " .. files .. " --json --size 160x90 -o " .. quote(picture))
      assert.equal(0, code, err)
      assert.truthy(out:find('"energy":[1,4,0],"label":"two 1","lmax":2', 1, true), out)
    end
    local _, code, err = ylm("view " .. quote(path .. "/bad.npy") .. " -o " .. quote(picture))
    assert.equal(1, code)
    assert.truthy(err:find("bad.npy: [..][(lmax+1)^2] coefficients expected", 1, true), err)
    _, code, err = ylm("view " .. quote(path .. "/one.npy") .. " --product -o " .. quote(picture))
    assert.equal(2, code)
    assert.truthy(err:find("--product wants 2 to 16 vectors, got 1", 1, true), err)
    _, code, err = ylm("view " .. quote(path .. "/one.npy") .. " --log -o " .. quote(picture))
    assert.equal(2, code)
    assert.truthy(err:find("--log is for grids", 1, true), err)
  end)

  it("writes JSON that escapes what it must", function()
    local json = require "ylm.cli.report".json
    assert.equal('{"a":[1,2.5,null],"b":"x\\"\\\\\\n\\u0001","c":{"d":true},"e":[]}',
      json { a = { 1, 2.5, 0 / 0 }, b = 'x"\\\n\1', c = { d = true }, e = {} })
    assert.equal("0.10000000000000001", json(0.1))
  end)

  it("prints tables by name within one line, and progress into a log as a line per stage", function()
    local out, code, err = ylm("render " .. file("log.lua", [[
      return scene "one lamp" {
        camera   = camera { from = { 2, 2, 3 }, at = { 0, 0, 0 } },
        geometry = quad { corner = { -2, -0.5, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } },
        lights   = sphere_light { at = { 0.5, 1.5, 0.5 }, radius = 0.1, radiance = 50 },
        probes   = adaptive_grid { lmax = 1, depth = 2, threshold = 1 },
      }]]) .. " -b 0 --size 16x9 --samples 1 -o " .. scratch.quote(folder.path .. "/log.pfm"))
    assert.equal(0, code, err)
    assert.truthy(out:find("^visibility +rays\n.*\nrays +occlusion 0, primary %d+, shadow %d+\n"), out)
    assert.truthy(err:find "raycast +10 20 30 40 50 60 70 80 90 100 %%  0:0%d\n", err)
    assert.is_nil(err:find "\r")
    assert.truthy(select(2, err:gsub("\n", "")) < 15, err)
  end)
end)
