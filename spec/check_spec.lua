-- make check refuses what would undo the architecture: each check is given a small tree that is good, and bad ones.

local scratch = require "spec.support.scratch"

local README = [[
# The ladder

    base < sh < light < { vulkan | rival } < lua

| folder | headers | not installed |
| --- | --- | --- |
| base | `ylm_pace.h` for pacing | `ylm_simd.h` |

**base** - the ground.

**light** - lights. Rooms: `tree/` (many).

**lua** - the binding: `core/`.

]]

--- A tree without fault: path -> text.
local GOOD = {
  ["csrc/README.md"] = README,
  ["csrc/base/ylm_base.h"] = "int ylm_base(void);\n",
  ["csrc/base/ylm_pace.h"] = "int ylm_pace(void);\n",
  ["csrc/base/ylm_simd.h"] = "/* lanes */\n",
  ["csrc/base/own.h"] = "/* of base alone */\n",
  ["csrc/base/base.c"] = '#include "own.h"\n#include <math.h>\n#include "ylm_base.h"\n',
  ["csrc/light/tree/far.h"] = "/* of a room */\n",
  ["csrc/light/tree/far.c"] = '#include "far.h"\n#include "../light.h"\n#include "ylm_base.h"\n',
  ["csrc/light/light.h"] = "\n",
  ["csrc/lua/binding_own.c"] = 'lua_setfield(L, -2, "__mode");\n',
  ["csrc/lua/binding_choices.h"] = '#define X(name, ...) #name\nX(dash, "solid", \\\n  "dotted") \\\n',
  ["csrc/lua/core/light.c"] = 'static const char *const methods[] = {"merged", "forward", NULL};\n',
  ["lua/ylm/light.lua"] = 'local methods = core.light_methods()\nlocal names = { "merged", "other" } -- __mode\n',
}

--- A declaration, and so many lines in all.
local function c_function(lines) return "int f(int a,\n      int b) {\n" .. ("  a += b;\n"):rep(lines - 3) .. "}\n" end
local function lua_function(lines) return "local function f(a)\n" .. ("  if a then a = -a end\n"):rep(lines - 2) .. "end\n" end

--- Check -> bad trees: what a file has instead, and the complaint.
local BAD = {
  rooms = {
    { "csrc/other/a.c", "\n", "csrc/other/a.c:1: its folder is not on the ladder of csrc/README.md" },
    { "csrc/light/shade/a.c", "\n", "csrc/light/shade/a.c:1: not in a room that csrc/README.md names of light" },
    { "csrc/light/tree/ylm_far.h", "\n", "csrc/light/tree/ylm_far.h:1: not in a room that csrc/README.md names of light" },
    { "csrc/README.md", README:gsub("Rooms: ", "Rooms: `flat/`, "), "csrc/README.md:1: the room light/flat has no files" },
  },
  headers = {
    { "csrc/light/ylm_light_sky.h", "\n", "csrc/light/ylm_light_sky.h:1: no header of light in csrc/README.md" },
    { "csrc/sh/ylm_pace.h", "\n", "csrc/sh/ylm_pace.h:1: no header of sh in csrc/README.md" },
    { "csrc/README.md", README:gsub("`ylm_pace.h`", "%0, `ylm_gone.h`"), "csrc/README.md:1: ylm_gone.h of base is not there" },
  },
  includes = {
    { "csrc/light/a.c", '#include "own.h"\n', "csrc/light/a.c:1: own.h is no public header" },
    { "csrc/light/a.c", '\n#include "../base/own.h"\n', "csrc/light/a.c:2: ../base/own.h is no public header" },
    { "csrc/light/a.c", '#include "base/own.h"\n', "csrc/light/a.c:1: base/own.h is no public header" },
    { "csrc/base/a.c", '#include "ylm_light.h"\n', "csrc/base/a.c:1: base includes ylm_light.h of light, which is not below it",
      "csrc/light/ylm_light.h" },
    { "csrc/rival/a.c", '#include "ylm_vulkan.h"\n',
      "csrc/rival/a.c:1: rival includes ylm_vulkan.h of vulkan, which is not below it", "csrc/vulkan/ylm_vulkan.h" },
  },
  functions = {
    { "csrc/sh/a.c", "#define F(x) {\n" .. c_function(71), "csrc/sh/a.c:2: f has 71 lines; at most 70" },
    { "csrc/vtk/a.cpp", "class a {\n" .. ("  int b() {\n  }\n"):rep(40) .. "};\n" .. c_function(80),
      "csrc/vtk/a.cpp:83: f has 80 lines; at most 70" },
    { "lua/ylm/a.lua", "local x = function() return 1 end\n" .. lua_function(71), "lua/ylm/a.lua:2: f has 71 lines; at most 70" },
    { "spec/a_spec.lua", 'describe("a", function()\n' .. ("  it(function()\n  end)\n"):rep(40) .. '  it("is", function()\n'
      .. ("    b()\n"):rep(70) .. "  end)\nend)\n", "spec/a_spec.lua:82: a function has 72 lines; at most 70" },
  },
  state = {
    { "lua/ylm/grid.lua", '\nlocal stages_of = setmetatable({}, { __mode = "k" })\n',
      "lua/ylm/grid.lua:2: a weak table: what belongs to an object stands in its own table" },
    { "csrc/lua/core/grid.c", 'lua_setfield(L, -2, "__mode");\n',
      "csrc/lua/core/grid.c:1: a weak table: what belongs to an object stands in its own table" },
  },
  choices = {
    { "lua/ylm/light.lua", '\nlocal o = { { "method", "choice", of = { "forward", "merged" } } }\n',
      "lua/ylm/light.lua:2: { forward, merged } are typed in csrc/lua/core/light.c:1 too" },
    { "lua/ylm/plot.lua", 'local o = { of = { "solid", "dotted" } }\n',
      "lua/ylm/plot.lua:1: { dotted, solid } are typed in csrc/lua/binding_choices.h:2 too" },
    { "lua/ylm/light.lua", "local METHODS = { merged = 0,\n  forward = 1 }\n",
      "lua/ylm/light.lua:1: { forward, merged } are typed in csrc/lua/core/light.c:1 too" },
  },
}

describe("make check", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function() folder:remove() end)

  local function write(path, text)
    assert(scratch.shell(("mkdir -p %s"):format(scratch.quote(folder.path .. "/" .. path:match "^(.*)/"))))
    folder:write(path, text)
  end

  local function good()
    for path, text in pairs(GOOD) do write(path, text) end
  end

  for _, check in ipairs(require "spec.check.all") do
    local name, complaints = check[1], check[2]

    it("has nothing against a tree without fault: " .. name, function()
      good()
      write("csrc/sh/long.c", c_function(70) .. "static const int x[] = {\n" .. ("  1,\n"):rep(100) .. "};\n")
      write("csrc/sh/gen/long.h", c_function(100))
      write("lua/ylm/long.lua", lua_function(70) .. "local x = {\n" .. ("  1,\n"):rep(100) .. "}\n")
      assert.same({}, complaints(folder.path))
    end)

    for i, bad in ipairs(BAD[name]) do
      it(("refuses a tree with a fault: %s %d"):format(name, i), function()
        good()
        if bad[4] then
          write(bad[4], "\n")
          assert.same({}, complaints(folder.path))
        end
        write(bad[1], bad[2])
        assert.same({ bad[3] }, complaints(folder.path))
      end)
    end
  end

  it("fails, says how many faults of a kind there are, and looks for those that are named", function()
    good()
    for _, list in pairs(BAD) do write(list[1][1], list[1][2]) end
    local command = ("LUA_PATH='./?.lua' %s spec/check/main.lua %s"):format(os.getenv "YLM_LUA" or "lua5.4", folder.path)
    local out, status = scratch.capture(command .. " functions state")
    assert.equal(1, status, out)
    assert.equal(table.concat({ BAD.functions[1][3], "functions: 1", BAD.state[1][3], "state: 1", "" }, "\n"), out)
    out, status = scratch.capture(command)
    assert.equal(1, status)
    for name, list in pairs(BAD) do assert.truthy(out:find(list[1][3], 1, true) and out:find("\n" .. name .. ": 1\n"), name) end
  end)
end)

describe("this tree", function()
  local held = { rooms = true, headers = true, includes = true, state = true, functions = true, choices = true }
  for _, check in ipairs(require "spec.check.all") do
    if held[check[1]] then
      it("passes the check of " .. check[1], function() assert.equal("", table.concat(check[2] ".", "\n")) end)
    end
  end
end)
