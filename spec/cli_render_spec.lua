-- `ylm render` and `ylm bake`: which options each method takes, warnings, --strict.

local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local api = require "ylm"

describe("the command-line tool's renderings", function()
  local folder, scene, ylm -- its warnings on
  setup(function()
    folder = scratch.new()
    ylm = tool.runner(folder, "YLM_WARNINGS=")
    scene = scratch.quote(folder:write("scene.lua", [[
      return scene "under a shelf" {
        camera   = camera { from = { 2, 2, 3 }, at = { 0, 0, 0 } },
        geometry = { quad { corner = { -2, -0.5, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 8 },
                     quad { corner = { -1, 1, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
        lights   = sphere_light { at = { 0.5, 1.5, 0.5 }, radius = 0.1, radiance = 50 },
        probes   = adaptive_grid { lmax = 2, depth = 1, tolerance = 0.001 },
      }]]))
  end)
  teardown(function() folder:remove() end)

  local function to(name) return " -o " .. scratch.quote(folder.path .. "/" .. name) end

  --- The lines of stderr that begin with "ylm: ".
  local function warnings(err)
    local lines = {}
    for line in err:gmatch "[^\n]+" do lines[#lines + 1] = line:match "^ylm: (.*)" end
    return lines
  end

  it("shade glossy surfaces as --gloss says", function()
    local ball = scratch.quote(folder:write("ball.lua", [[
      return scene "a ball" {
        camera   = camera { from = { 0, 0, 4 }, at = { 0, 0, 0 } },
        geometry = { sphere { material = ggx { alpha = 0.2, f0 = 0.9 }, divide = { 16, 8 } } },
        lights   = sphere_light { at = { 2, 3, 3 }, radius = 0.5, radiance = 50 },
      }]]))
    for words, says in pairs { [""] = '"gloss":"auto"', [" --gloss rays --light-samples 16"] = '"gloss":"rays"',
      [" --gloss auto --gloss-error 0.5,0.9"] = '"gloss":"auto"', [" --gloss matte"] = '"gloss":"matte"' } do
      local out, code, err = ylm("render " .. ball .. " --by sum -s 16x9 -n 1" .. words .. to "ball.exr" .. " --json")
      assert.equal(0, code, err)
      assert.truthy(out:find(says, 1, true), out)
    end
  end)

  it("take --samples as camera rays and --light-samples as shadow rays", function()
    local out, code, err = ylm("render " .. scene .. " -b 0 -s 16x9 -n 3 --light-samples 5" .. to "rays.exr" .. " --json")
    assert.equal(0, code, err)
    assert.truthy(out:find('"primary":' .. 16 * 9 * 3, 1, true), out)
    local points, shadow = tonumber(out:match '"points":(%d+)'), tonumber(out:match '"shadow":(%d+)')
    assert.is_true(shadow > 0 and shadow <= 5 * points, out)
    assert.truthy(out:find('"warnings":[]', 1, true), out)
    local usage = ylm "render --help"
    assert.truthy(usage:find("%-n, %-%-samples N +camera rays per pixel, default 16; more of them multiply rays to lamps and "
      .. "links too\n"), usage)
    assert.truthy(usage:find "%-%-light%-samples N +by rays: shadow rays per shading point, default 32\n", usage)
  end)

  it("trace paths, go on from their file, and say whether two images agree", function()
    local out, code, err = ylm("pathtrace " .. scene .. " -s 16x9 -n 32 -b 1 --json" .. to "a.exr")
    assert.equal(0, code, err)
    assert.truthy(out:find('"samples":32', 1, true) and out:find '"noise":0', out)
    local resume = " --resume " .. scratch.quote(folder.path .. "/a.exr")
    out, code, err = ylm("pathtrace " .. scene .. " -s 16x9 -n 64 -b 1 --json" .. resume .. to "b.exr")
    assert.equal(0, code, err)
    assert.truthy(out:find('"samples":64', 1, true), out)
    out, code, err = ylm("compare --variance --json " .. scratch.quote(folder.path .. "/a.exr") .. " "
      .. scratch.quote(folder.path .. "/b.exr"))
    assert.equal(0, code, err)
    assert.truthy(out:find '"z2":[01]%.', out)
    for words, says in pairs {
      ["-b some -n 2"] = "%-%-bounces is a number from 0 on, or all, got 'some'",
      ["-b 0 -n 0"] = "samples must be an integer >= 1",
      ["-b 2 -s 16x9" .. resume] = "resume: the image's reflections is '0 2', this is '0 3'",
    } do
      out, code, err = ylm("pathtrace " .. scene .. " " .. words .. to "c.exr")
      assert.is_true(code ~= 0 and out == "" and err:find(says) ~= nil, words .. ": " .. err)
    end
  end)

  it("write virtual lights, and take their options for bounces", function()
    local out, code, err = ylm("emit " .. scene .. " --merge -n 40 --cell 0.5 --json" .. to "lights.ply")
    assert.equal(0, code, err)
    assert.truthy(out:find('"cell":0.5', 1, true), out)
    for words, says in pairs {
      ["--cell 1"] = "--cell is of lights that are merged",
      ["--radius wide"] = "--radius must be 'density', 'angle', ",
      ["--degree 9"] = "--degree must be 'auto', or an integer from 0 to 8, got 9",
      ["--distribution heap"] = "--distribution must be one of 'particles', 'grid'",
    } do
      out, code, err = ylm("emit " .. scene .. " " .. words .. to "no.ply")
      assert.equal(2, code, err)
      assert.truthy(out == "" and err:find(says, 1, true), err)
    end
    out, code, err = ylm("render " .. scene .. " -s 16x9 -n 1 --json --bounced virtual -b 1 --count 40 --merge --shadows centre"
      .. to "x.exr")
    assert.equal(0, code, err)
    assert.truthy(out:find('"particles":2000', 1, true), out)
  end)

  it("refuse options that a method would not use, before they work", function()
    for words, says in pairs {
      ["render --shading vertex"] = "--shading is pixel or vertices, got 'vertex'",
      ["render --by rays --sums-tolerance 0.1"] = "--sums-tolerance is for --by grid and sum, this is by rays: leave it out",
      ["render --by sum --interpolation linear"] = "--interpolation is for --by grid, this is by sum",
      ["render --by sum --grid x.ylm"] = "--grid is for --by grid, this is by sum",
      ["render --by sum --light-samples 4"] = "--light-samples is for pictures by rays to the lamps (--by rays)",
      ["render --by grid --light-samples 4"] = "--light-samples is for pictures by rays to the lamps (--by rays)",
      ["render --by paths"] = "--by is rays, grid or sum, got 'paths'",
      ["render --visibility transfer --light-samples 4"] = "--light-samples is for pictures by rays to the lamps",
      ["render --grid x.ylm --light-samples 4"] = "--light-samples is for pictures by rays to the lamps",
      ["render --interpolation linear"] = "--interpolation is for --by grid, this is by rays: leave it out",
      ["render --grid x.ylm --tolerance 0.1"] = "--tolerance is for --by rays, this is by grid",
      ["render --visibility tansfer"] = "--visibility is rays, transfer, none or self, got 'tansfer' (did you mean transfer?)",
      ["render --by sum --visibility rays"] = "--visibility rays is not of pictures by sum: leave one out",
      ["render --by rays --visibility transfer"] = "--visibility transfer is not of pictures by rays: leave one out",
      ["render --grid x.ylm --sums-tolerance 0.1"] = "--sums-tolerance is for baking the scene's probes, --grid is baked",
      ["bake --occupied vertices --size 16x9"] = "--size and --samples are of the camera's view, --occupied is vertices",
      ["bake --quantity shadows"] = "--quantity is lights, direct, indirect or all, got 'shadows'",
      ["bake --quantity direct --bounces 2"] = "--bounces is for --quantity indirect or all: leave it out, or name one",
      ["bake --bounces 2"] = "--bounces is for --quantity indirect or all: leave it out, or name one",
      ["bake --quantity all --bounces some"] = "--bounces is a number from 0 on, or all, got 'some'",
      ["bake --quantity all --sums-tolerance 0.1"] = "--sums-tolerance is for --quantity lights, this is all: leave it out",
      ["bake --occupied everywhere -n 2"] = "--size and --samples are of the camera's view, --occupied is everywhere",
      ["render --gloss reys"] = "--gloss is matte, sh, auto or rays, got 'reys' (did you mean rays?)",
      ["render --gloss sh"] = "--gloss sh is for grids (--grid FILE, or --by grid): rays know materials",
      ["render --by sum --gloss sh --gloss-error 0.1,0.2"] = "--gloss-error is for --gloss auto, this is sh: leave one out",
      ["render --by sum --gloss-error 0.2,0.1"] = "--gloss-error is two numbers such as 0.01,0.03",
      ["render --merge"] = "--merge is for --bounced virtual: leave it out, or ask for that",
      ["render --exposure 1e300"] = "--exposure is from -60 to 60 stops, got 1e+300",
      ["render --exposure -61"] = "--exposure is from -60 to 60 stops, got -61",
    } do
      local command, rest = words:match "^(%a+)(.*)"
      local out, code, err = ylm(command .. " missing.lua" .. rest .. to(command == "bake" and "x.ylm" or "x.png"))
      assert.equal(2, code, err)
      assert.equal("", out)
      assert.truthy(err:find("ylm: " .. command .. ": " .. says, 1, true), err)
    end
    local _, code, err = ylm("render missing.lua --exposure 1" .. to "x.exr")
    assert.equal(2, code)
    assert.truthy(err:find("render: --exposure is of a .png: ", 1, true), err)
    assert.equal(0, select(2, ylm("render " .. scene .. " -q --by sum --shading vertices -s 16x9 -n 1" .. to "x.exr")))
  end)

  it("say what falls short in a line each, and end with status 6 under --strict", function()
    local out, code, err = ylm("bake " .. scene .. " --occupied camera -s 16x9 -n 1" .. to "grid.ylm")
    assert.equal(0, code, err)
    assert.truthy(out:find "^met +false\nerror +%d%.%d+\n", out)
    assert.is_nil(out:find "warning", out)
    local said = warnings(err)
    assert.equal(1, #said, err)
    assert.truthy(said[1]:find("^bake: tolerance 0.001 is not met, .*: voxels end at depth 1; set depth = "), err)
    out, code, err = ylm("bake " .. scene .. " --occupied camera -s 16x9 -n 1 --strict --json" .. to "strict.ylm")
    assert.equal(6, code, err)
    assert.equal(folder:read "grid.ylm":sub(1, 8), folder:read "strict.ylm":sub(1, 8)) -- it is written
    assert.truthy(out:find('"warning":"' .. said[1]:sub(1, 30), 1, true), out)

    local small = " -s 16x9 -n 2" .. to "x.exr"
    out, code, err = ylm("render " .. scene .. small .. " --grid " .. scratch.quote(folder.path .. "/grid.ylm"))
    assert.equal(0, code, err)
    assert.truthy(out:find "\nocclusion +missing ", out)
    said = warnings(err)
    assert.equal(3, #said, err)
    assert.truthy(said[1]:find('^scene "under a shelf": %d+ %% of the picture\'s light passes through occluders'), err)
    assert.truthy(said[2]:find("^bake: tolerance "), err)
    assert.truthy(said[3]:find('^scene "under a shelf": %S+ %% of the picture\'s light was below zero'), err)
    out, code, err = ylm("render " .. scene .. small .. " --visibility transfer --strict --json -q")
    assert.equal(6, code, err)
    assert.equal("", err)
    assert.truthy(out:find('"warnings":["scene \\"under a shelf\\": ', 1, true), out)
    -- a grid that holds its shadows
    local glow = function(points) return api.zeros({ #points, 3, 1 }, "double"), api.zeros({ #points, 3, 1, 3 }, "double") end
    local box = { { -3, -1, -3 }, { 3, 2, 3 } }
    assert(api.bake(api.uniform_grid { bounds = box, cells = 1, lmax = 0, metric_channels = "none" }, glow,
      { quantity = "direct" }):save(folder.path .. "/direct.ylm"))
    local direct = " --strict --grid " .. scratch.quote(folder.path .. "/direct.ylm")
    out, code, err = ylm("render " .. scene .. small .. direct)
    assert.equal(0, code, err)
    assert.truthy(out:find "^visibility +grid\n", out)
    assert.is_nil(out:find "occlusion +missing", out)
    assert.equal(0, select(2, ylm("render " .. scene .. small .. " --by rays -b 0 --strict")))
    assert.equal(0, select(2, ylm("render " .. scene .. small .. " --visibility rays -b 0 --strict"))) -- by rays
    assert.truthy((ylm "--help"):find("6 a warning was given and --strict asked for", 1, true))
  end)
end)
