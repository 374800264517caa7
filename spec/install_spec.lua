-- An installed ylm works from anywhere: by make install, and by luarocks make.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local root = scratch.capture "pwd":gsub("%s+$", "")
local clean = "env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u LUA_PATH -u LUA_CPATH "
local experiment = [[
local ylm = require "ylm"
assert(#ylm.sh.eval(2, { 0, 0, 1 }) == 9)
local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 1 },
  ylm.sphere_light { at = { 0, 2, 0 } }))
assert(grid:save(arg[1]))
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
    local said = runs(clean .. "make -s install PREFIX=" .. scratch.quote(prefix))
    for _, words in ipairs { "export PATH=%s/bin:", "export PKG_CONFIG_PATH=%s/lib/pkgconfig ",
      "LUA_PATH='%s/share/lua/5.4/?.lua;" } do
      assert.truthy(said:find(words:format(prefix), 1, true), said)
    end
    local file = scratch.quote(folder:write("experiment.lua", experiment))
    local page = folder.path .. "/page.html"
    runs(("build/ylm run %s %s"):format(file, scratch.quote(page)))
    local written = scratch.text(page)
    for _, lua in ipairs { "lua5.4", "luajit", "lua5.1" } do
      if scratch.shell("command -v " .. lua .. " >/dev/null") then
        os.remove(page)
        local out = runs(("cd / && %s YLM_LUA=%s %s/bin/ylm run %s %s"):format(clean, lua, scratch.quote(prefix), file,
          scratch.quote(page)))
        assert.truthy(out:find "^%d+%.%d+%.%d+\n", out)
        assert(scratch.text(page) == written, "the page of an installed ylm has other bytes under " .. lua)
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

  --- Is there text in the files of a folder `share` that are made of the texts beside the code?
  local function has_texts(share)
    local texts = {}
    for name, path in pairs { man = "man/man1/ylm.1", bash = "bash-completion/completions/ylm", zsh = "zsh/site-functions/_ylm",
      fish = "fish/vendor_completions.d/ylm.fish", meta = "ylm/ylm.meta.lua" } do
      texts[name] = scratch.text(share .. "/" .. path)
    end
    assert.truthy(texts.meta:find("\nfunction ylm.sh.eval(", 1, true))
    for _, name in ipairs { "render", "codegen", "help" } do
      assert.truthy(texts.man:find('.SS "ylm ' .. name .. '"', 1, true), name)
      assert.truthy(texts.bash:find("\n    " .. name .. ")\n", 1, true), name)
      assert.truthy(texts.zsh:find("\n    " .. name .. ")\n", 1, true), name)
      assert.truthy(texts.fish:find("__fish_seen_subcommand_from " .. name, 1, true), name)
    end
  end

  it("by make install: a page's viewer, of which a missing file is named", function()
    if not usual then pending "only of the usual build" end
    local lua = folder.path .. "/lua"
    runs(("mkdir %s && cp -r lua/ylm %s && rm %s/ylm/page/viewer/viewer.js"):format(lua, lua, lua))
    local command = ("LUA_PATH='%s/?.lua;%s/?/init.lua' LUA_CPATH='build/lua5.4/?.so' lua5.4 %s %s"):format(lua, lua,
      scratch.quote(folder:write("experiment.lua", experiment)), scratch.quote(folder.path .. "/none.html"))
    local out, code = scratch.capture(command)
    assert.equal(1, code, out)
    assert.truthy(out:find("page: the viewer is incomplete: " .. lua .. "/ylm/page/viewer/viewer.js: ", 1, true), out)
  end)

  it("by make install: a man page, completions, annotations", function()
    if not usual then pending "only of the usual build" end
    has_texts(folder.path .. "/prefix/share")
  end)

  it("says what is not found without being told, and no more", function()
    local out = runs("env PATH=/opt/y/bin:$PATH PKG_CONFIG_PATH=/opt/y/lib/pkgconfig LD_LIBRARY_PATH=/opt/y/lib "
      .. "package/paths /opt/y")
    assert.matches("^ylm is in /opt/y%. To find it:\n  %. /opt/y/share/bash%-completion/completions/ylm [^\n]*\n$", out)
    out = runs "env PATH=/usr/bin:/bin package/paths /usr/local"
    assert.truthy(out:find("export PATH=/usr/local/bin:", 1, true) and out:find("\n  ldconfig ", 1, true), out)
    assert.falsy(out:find "LD_LIBRARY_PATH")
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

  for _, version in ipairs(long({ "5.4" }, { "5.4", "5.1" })) do
    it("by luarocks make, for Lua " .. version .. ", without a network", function()
      if not usual then pending "only of the usual build" end
      if not scratch.shell "command -v luarocks >/dev/null" then pending "luarocks is not installed" end
      if not scratch.shell("command -v lua" .. version .. " >/dev/null") then pending("no lua" .. version) end
      local tree = scratch.quote(folder.path .. "/rocks" .. version)
      runs(("%s luarocks --lua-version=%s --tree %s make rockspec/ylm-scm-1.rockspec"):format(clean, version, tree))
      local file = scratch.quote(folder:write("experiment.lua", experiment))
      local out = runs(("cd / && %s %s/bin/ylm run %s %s"):format(clean, tree, file, scratch.quote(folder.path .. "/rock.html")))
      assert.truthy(out:find "^%d+%.%d+%.%d+\n", out)
      has_texts(("%s/rocks%s/lib/luarocks/rocks-%s/ylm/scm-1/share"):format(folder.path, version, version))
    end)
  end
end)
