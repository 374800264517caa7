-- An installed ylm works from anywhere: by make install, and by luarocks make.

local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local root = scratch.capture "pwd":gsub("%s+$", "")
local clean = "env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u LUA_PATH -u LUA_CPATH "
local experiment = [[
local ylm = require "ylm"
assert(#ylm.sh.eval(2, { 0, 0, 1 }) == 9)
print(ylm.info().version)]]

--- The build that `make` makes; others (sanitizers) are not installed.
local usual = build == "build" or build == root .. "/build"

describe("what is installed", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function runs(command)
    local out, code = scratch.capture(command)
    assert(code == 0, command .. "\n" .. out)
    return out
  end

  it("by make install: library, headers, Lua files, bindings and the tool", function()
    if not usual then pending "only of the usual build" end
    local prefix = folder.path .. "/prefix"
    runs(("mkdir -p %s/share/lua/5.4/ylm && echo 'error \"older\"' > %s/share/lua/5.4/ylm/sh.lua"):format(scratch.quote(prefix),
      scratch.quote(prefix))) -- what an older ylm left there
    runs(clean .. "make -s install PREFIX=" .. scratch.quote(prefix))
    local file = scratch.quote(folder:write("experiment.lua", experiment))
    for _, lua in ipairs { "lua5.4", "luajit" } do
      if scratch.shell("command -v " .. lua .. " >/dev/null") then
        local out = runs(("cd / && %s YLM_LUA=%s %s/bin/ylm run %s"):format(clean, lua, scratch.quote(prefix), file))
        assert.truthy(out:find "^%d+%.%d+%.%d+\n", out)
      end
    end
    assert.truthy(scratch.shell("test -f " .. scratch.quote(prefix .. "/include/ylm/ylm_base.h")))
    local libraries = runs("ldd " .. scratch.quote(prefix) .. "/lib/lua/5.4/ylm/c/core.so")
    assert.truthy(libraries:find(folder.path, 1, true), libraries)
    assert.falsy(libraries:find "not found", libraries)
    for _, part in ipairs { "codec", "scene" } do
      if scratch.shell("test -f build/lib/libylm_" .. part .. ".so") then
        libraries = runs("ldd " .. scratch.quote(prefix) .. "/lib/lua/5.4/ylm/c/" .. part .. ".so")
        assert.truthy(libraries:find(folder.path .. "/prefix/lib/", 1, true), libraries)
        assert.truthy(libraries:find("libylm_" .. part, 1, true), libraries)
        assert.falsy(libraries:find "not found", libraries)
      end
    end
  end)

  it("has OpenEXRCore by pkg-config, whatever its version, and no OpenEXR that lacks it", function()
    if not scratch.shell "command -v pkg-config >/dev/null" then pending "pkg-config is not installed" end
    local function says(libs)
      folder:write("OpenEXR.pc", "Name: x\nDescription: x\nVersion: 9\nLibs: -L/opt/exr/lib " .. libs .. "\n")
      folder:write("libpng.pc", "Name: x\nDescription: x\nVersion: 9\nLibs: -lpng99\n")
      return runs(clean .. "PKG_CONFIG_PATH=" .. scratch.quote(folder.path)
        .. " make -s --eval='say: ; @echo \"$(WITH_CODEC): $(LIBS_codec)\"' say")
    end
    local libs = says "-lOpenEXR-9_7 -lOpenEXRCore-9_7 -lIex-9_7" -- and zlib, jansson where they are
    assert.truthy(libs:find "^y: %-L/opt/exr/lib %-lOpenEXRCore%-9_7 %-lpng99 ", libs)
    assert.falsy(libs:find "Iex" or libs:find "OpenEXR%-9", libs)
    assert.truthy(says "-lIlmImf-2_5":find "^: ")
  end)

  for _, version in ipairs { "5.4", "5.1" } do
    it("by luarocks make, for Lua " .. version .. ", without a network", function()
      if not usual then pending "only of the usual build" end
      if not scratch.shell "command -v luarocks >/dev/null" then pending "luarocks is not installed" end
      if not scratch.shell("command -v lua" .. version .. " >/dev/null") then pending("no lua" .. version) end
      local tree = scratch.quote(folder.path .. "/rocks" .. version)
      runs(("%s luarocks --lua-version=%s --tree %s make rockspec/ylm-scm-1.rockspec"):format(clean, version, tree))
      local file = scratch.quote(folder:write("experiment.lua", experiment))
      local out = runs(("cd / && %s %s/bin/ylm run %s"):format(clean, tree, file))
      assert.truthy(out:find "^%d+%.%d+%.%d+\n", out)
    end)
  end
end)
