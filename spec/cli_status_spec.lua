-- How the command-line tool ends: full disks, what experiments return and raise, interrupts.

local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

describe("the command-line tool's exit status", function()
  local folder, start
  setup(function()
    folder = scratch.new()
    start = tool.runner(folder)
  end)
  teardown(function() folder:remove() end)

  --- Runs `ylm words`; returns its status and stderr.
  local function ylm(words, to)
    local _, code, err = start(words, to or "/dev/null")
    return code, err
  end

  --- Exit status and output of an experiment of this text.
  local function run(text) return ylm("run " .. scratch.quote(folder:write("e.lua", text))) end

  it("is 1 where standard output does not take all that a command says", function()
    if not scratch.shell "test -c /dev/full" then return pending "without /dev/full" end
    local ylm_ = require "ylm"
    assert(ylm_.image { size = { 4, 4 } }:save(folder.path .. "/a.pfm"))
    local image = scratch.quote(folder.path .. "/a.pfm")
    local hello = scratch.quote(folder:write("hello.lua", "print 'hello'"))
    for _, words in ipairs { "info", "info --json", "help", "help all", "help zeros", "--help", "bake --help", "codegen --lmax 1",
      "codegen --lmax 9", "codegen --count --lmax 1", "compare " .. image .. " " .. image, "run " .. hello } do
      local code, err = ylm(words, "/dev/full")
      assert.equal(1, code, words .. ": " .. err)
      assert.truthy(err:find "^ylm: standard output cannot be written: ", words .. ": " .. err)
    end
    assert.equal(1, (ylm("info", "&-")))
    assert.equal(4, (ylm("compare --min-psnr 1e9 --max-mse -1 " .. image .. " " .. image, "/dev/full")))
  end)

  it("of an experiment is its own from 7 to 125, 0 where it returns nothing wrong", function()
    for text, expected in pairs { ["return"] = 0, ["return 0"] = 0, ["return true"] = 0, ["return {}"] = 0, ["return 'x'"] = 0,
      ["return 7"] = 7, ["return 125"] = 125 } do
      local code, err = run(text)
      assert.equal(expected, code, text)
      assert.equal("", err)
    end
    for _, text in ipairs { "5", "1", "6", "126", "130", "256", "-1", "7.5", "0/0", "1/0", "false" } do
      local code, err = run("return " .. text)
      assert.equal(3, code, text)
      assert.truthy(err:find("returned %S+: an experiment returns nothing or 0 where it is good, else a status of its own "
        .. "from 7 to 125"), err)
    end
    local code, err = run "return nil, 'out.exr: no room', 'EIO'"
    assert.equal(1, code)
    assert.equal("ylm: out.exr: no room\n", err)
  end)

  it("of an experiment that raises is 3, with what it raised in words", function()
    for text, says in pairs { ["\nerror {}"] = "e.lua:2: an error was raised that is no message but a table",
      ["error()"] = "e.lua:1: an error was raised that is no message but nil",
      ["error(print)"] = "no message but a function", ["error { status = 0, message = 'x' }"] = "no message but a table",
      ["error(setmetatable({}, { __tostring = function() return 'mine' end }))"] = "ylm: mine\n",
      ["error(setmetatable({}, { __metatable = 1 }))"] = "no message but a table",
      ["error(setmetatable({}, { __tostring = error }))"] = "no message but a table",
      ["error 'interrupted!'"] = "e.lua:1: interrupted!",
      ["error('bad argument #1 to f', 0)"] = "ylm: bad argument #1 to f\n" } do
      local code, err = run(text)
      assert.equal(3, code, text .. ": " .. err)
      assert.truthy(err:find(says, 1, true), err)
    end
    assert.equal(1, (ylm "run ."))
  end)

  it("is 130 soon after an interrupt, with and without progress, whatever is at work", function()
    local work = folder:write("work.lua", [[
      local ylm = require "ylm"
      local at, points = {}, ylm.zeros({ 100000, 3 }, "float")
      for i = 1, 100000 do at[i] = { i % 7, i % 11, 3 + i % 5 } end
      local lights = ylm.sphere_lights { at = at, radius = 0.1, radiance = 1 }
      print(io.open(arg[1], "w"):close())
      ylm.light_field(4, lights, points, { threads = 1 })]])
    local scene = folder:write("scene.lua", [[return scene "long" { camera = camera { from = { 2, 2, 3 } }, geometry = box {},
      lights = sphere_light { at = { 0, 2, 0 } }, probes = adaptive_grid { lmax = 1, depth = 1 } }]])
    local begun, timed = scratch.quote(folder.path .. "/begun"), "s=$(date +%s%N); kill -INT $p; wait $p; c=$?; "
      .. "echo $c $((($(date +%s%N) - s) / 1000000))"
    local quoted = { work = scratch.quote(work), scene = scratch.quote(scene), out = scratch.quote(folder.path .. "/o.exr") }
    local waits = { ["run work " .. begun] = "while [ ! -e " .. begun .. " ]; do sleep 0.02; done; sleep 0.1" }
    if pcall(require, "ylm.c.scene") then waits["render scene -q -s 1920x1080 -n 64 -o out"] = "sleep 0.5" end
    for pattern, wait in pairs(waits) do
      local words = pattern:gsub("%l+", quoted)
      local out = scratch.capture(("%s %s >/dev/null 2>&1 & p=$!; %s; %s"):format(tool.command, words, wait, timed))
      local code, ms = out:match "(%d+) (%d+)%s*$"
      assert.equal("130", code, words .. ": " .. out)
      assert.truthy(tonumber(ms) < 5000, words .. ": " .. ms .. " ms") -- the work takes longer, also on a busy machine
    end
  end)

  it("keeps the paths so far at an interrupt, for --resume, and says their noise", function()
    local scene = scratch.quote(folder:write("paths.lua", [[return scene "long" { camera = camera { from = { 2, 2, 3 } },
      geometry = box {}, lights = sphere_light { at = { 0, 2, 0 } } }]]))
    local out = scratch.quote(folder.path .. "/p.exr")
    local text = scratch.capture(("%s pathtrace %s -n 100000000 -s 16x9 -o %s 2>&1 & p=$!; sleep 2; kill -INT $p; wait $p; "
      .. "echo status $?"):format(tool.command, scene, out))
    assert.truthy(text:find "noise is [%d.]+ %% after %d+ paths a pixel; interrupted" and text:find "status 130", text)
    local kept = assert(require "ylm".load(folder.path .. "/p.exr"))
    assert.is_true(kept:layer("samples"):get(1, 1, 1) >= 32 and kept:layer("radiance"):max() > 0)
  end)
end)
