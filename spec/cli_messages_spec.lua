-- Messages of the command-line tool about searches, misspellings and options without a meaning.

local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

describe("the command-line tool's messages", function()
  local folder, ylm
  setup(function()
    folder = scratch.new()
    ylm = tool.runner(folder)
  end)
  teardown(function() folder:remove() end)

  --- The first line of stderr of a command that is used wrongly.
  local function refused(words)
    local out, code, err = ylm(words)
    assert.equal(2, code, words .. ": " .. err)
    assert.equal("", out)
    return err:match "^[^\n]*"
  end

  it("find a word by a part of a name and in texts, commands' too", function()
    for word, names in pairs { polygon = { "polygon_light" }, disk = { "disk_light" }, texture = { "textured_light" },
      tolerance = { "adaptive_grid", "ylm bake", "scene:bake" }, POLYGON = { "polygon_light" } } do
      local out, code = ylm("help " .. word)
      assert.equal(0, code)
      for _, name in ipairs(names) do assert.truthy(out:find("\n  " .. name .. " ", 1, true), word .. ": " .. out) end
    end
    assert.equal("ylm: no help on 'zerso' (did you mean 'zeros'?)", refused "help zerso")
    assert.equal("ylm: no help on ' '", refused "help ' '")
  end)

  it("take a value that stands at a letter, and say a mistake in three lines", function()
    local out, code = ylm "render -j1 --help"
    assert.equal(0, code, out)
    local _, status, err = ylm "render -q9 x.lua"
    assert.equal(2, status)
    assert.equal("ylm: render: no option -q9", err:match "^[^\n(]*":gsub(" $", ""))
    assert.equal(3, select(2, err:gsub("\n", "")), err)
    assert.matches("ylm help render names its options", err)
  end)

  it("show a command before functions of its name, and run none", function()
    local out, code = ylm "help render"
    assert.equal(0, code)
    assert.truthy(out:find "^usage: ylm render .*\nscene:render%(")
    assert.equal(out, (ylm "--help render"))
    for _, word in ipairs { "view_sh", "../check" } do assert.equal(2, select(2, ylm("help " .. word)), word) end
    assert.equal((ylm "help"), (ylm "--help"))
  end)

  it("guess nothing of names of 300 letters, and cut them", function()
    local long = ("x"):rep(300)
    for words, says in pairs { [long] = "no command", ["help " .. long] = "no help on", ["info --" .. long] = "no option",
      ["codegen --" .. long] = "unknown option", ["bench " .. long] = "unexpected" } do
      local said = refused(words)
      assert.truthy(said:find(says, 1, true), said)
      assert.is_nil(said:find("did you mean", 1, true), said)
      assert.truthy(#said < 120, said)
    end
  end)

  it("name the option whose value is refused", function()
    local scene = scratch.quote(folder:write("s.lua", [[return scene "s" { camera = camera { from = { 2, 2, 3 } },
      geometry = box {}, lights = sphere_light { at = { 0, 2, 0 } }, probes = adaptive_grid { lmax = 1, depth = 1 } }]]))
    for words, says in pairs {
      ["render " .. scene .. " -o x.png -j 1.5"] = "ylm: render: --threads must be an integer >= 1 and <= 1024, got 1.5",
      ["render " .. scene .. " -o x.png -j 1e999"] = "ylm: render: -j: a number expected, got '1e999'",
      ["render " .. scene .. " -o x.png -s 64x64x64"] = "ylm: render: -s: a size such as 640x360 expected, got '64x64x64'",
      ["render " .. scene .. " -o x.png --light-samples 0"] = "ylm: render: --light-samples must be an integer >= 1 and "
        .. "<= 65536, got 0",
      ["bake " .. scene .. " -o x.ylm --sums_tolerance 5"] = "ylm: bake: --sums-tolerance must be a number >= 1e-06 and "
        .. "<= 0.5, got 5",
      ["view x.ylm -o x.png --range 1,1e999"] = "ylm: view: --range: two numbers such as 1e-4,1 expected, got '1,1e999'",
    } do assert.equal(says, refused(words)) end
  end)

  it("spell options with hyphens; names of Lua, with underscores, mean the same", function()
    for _, name in ipairs(require "ylm.cli.commands") do
      local usage = name ~= "help" and ylm(name .. " --help") or ""
      for option in usage:gmatch "%-%-[%a_%-]+" do assert.is_nil(option:find "_", name .. ": " .. option) end
    end
    assert.equal("ylm: bake: no option --sums_toleranc (did you mean --sums-tolerance?)",
      refused "bake s.lua --sums_toleranc 1")
    assert.equal("ylm: render: --gloss_error: two numbers such as 1e-4,1 expected, got '1'",
      refused "render s.lua --gloss_error 1")
  end)

  it("refuse options that would be ignored", function()
    for words, says in pairs {
      ["bake s.lua -o x.ylm --coefficients"] = "bake: --coefficients is of .vtu files: give -o NAME.vtu",
      ["compare a.exr b.exr --scale 2"] = "compare: --scale is of the difference image: --difference FILE is missing",
      ["view a.ylm --json"] = "view: --json goes with -o FILE",
      ["view a.npy -o x.png --angle 30"] = "view: --angle goes with --rotate X,Y,Z",
      ["codegen --lmax 2 --check"] = "--lmax has no meaning with --check",
      ["codegen --count --solid"] = "--solid has no meaning with --count",
      ["codegen --lmax 2 --root ."] = "--root has no meaning with --lmax",
      ["codegen --write --count"] = "--count has no meaning with --write",
      ["codegen --lmax 2 --solid --unit"] = "--unit has no meaning with --solid",
      ["codegen --lmax 2 --method scd --unit"] = "--unit has no meaning with --method scd",
      ["run --json x.lua"] = "no option --json", ["help a b"] = "unexpected 'b'",
    } do
      local said = refused(words)
      assert.truthy(said:find(says, 1, true), said)
    end
  end)

  it("say what --lmax of codegen may be, and what it was", function()
    for words, says in pairs { ["--lmax 9999"] = "from 0 to 150, got 9999", ["--lmax 4.5"] = "from 0 to 150, got '4.5'",
      ["--lmax 101 --language glsl"] = "from 0 to 100 for glsl, whose numbers are floats, got 101",
      ["--count --lmax 31"] = "from 0 to 30 with --count, got 31" } do
      assert.truthy(refused("codegen " .. words):find("--lmax must be an integer " .. says, 1, true))
    end
    local out, code = ylm "codegen --lmax 2 --help"
    assert.equal(0, code)
    assert.truthy(out:find "^usage: ylm codegen")
  end)

  it("say that a scene's file is a folder", function()
    local scene = scratch.quote(folder:write("f.lua", 'return scene "f" { geometry = mesh { file = "." } }'))
    local _, code, err = ylm("render " .. scene .. " -o " .. scratch.quote(folder.path .. "/x.png"))
    assert.equal(1, code)
    assert.truthy(err:find("f.lua:1: mesh: file: .: a folder, not a file", 1, true), err)
  end)

  it("say that YLM_LUA names no interpreter", function()
    local out, code = scratch.capture("YLM_LUA=nolua " .. tool.path .. " info")
    assert.equal(1, code)
    assert.equal("ylm: no Lua called 'nolua'; set YLM_LUA to luajit or lua5.1 to lua5.5\n", out)
  end)

  it("begin on a line of their own where progress was broken off", function()
    local progress = require "ylm.progress"
    local text = ""
    local stream = { write = function(_, ...) text = text .. table.concat { ... } end, flush = function() end }
    progress.log(stream)(1, 2, "baking")
    progress.leave()
    progress.leave()
    assert.equal("baking       10 20 30 40 50\n", text)
  end)
end)
