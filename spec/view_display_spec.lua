-- Where pictures are drawn: without a display, with a server of their own, by a window.

local scratch = require "spec.support.scratch"
local views = require "spec.support.views"

if not views.vtk "ylm.view without a display" then return end

local draw = views.draw

describe("ylm.view, where it draws", function()
  local lua = os.getenv "YLM_LUA" or "lua5.4"

  --- Runs a script under another environment; returns what it prints and its status.
  local function run(environment, script)
    local folder = scratch.new()
    local path = folder:write("draw.lua", script)
    local text, status = scratch.capture(environment .. " " .. lua .. " " .. scratch.quote(path))
    folder:remove()
    return text, status
  end

  local script = [[
local ylm = require "ylm"
local p, message, code = ylm.view({ sh = { { 1, 0, 0, 0 } }, size = { 64, 48 } }):pixels()
print(p and p:get(24, 32, 1) > 0.4 and "drawn" or code, message)]]

  it("needs no display", function()
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=egl", script)
    assert.equal(0, status, text)
    assert.truthy(text:find "^drawn", text)
  end)

  it("starts an X server of its own where EGL is missing, and ends it", function()
    if not scratch.shell("command -v Xvfb >/dev/null") then return pending "Xvfb is not installed" end
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=xvfb", script .. [[

local pipe = io.popen "env -u LD_PRELOAD ps -o args= -C Xvfb | wc -l"
print("servers", (pipe:read "*a"):match "%d+")
pipe:close()]])
    assert.equal(0, status, text)
    assert.truthy(text:find "^drawn", text)
  end)

  it("says what to install where there is nothing", function()
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=none", script)
    assert.equal(0, status, text)
    assert.truthy(text:find "^EMISSING.*install libegl1", text)
  end)

  it("opens no window without a display", function()
    local text, status = run("env -u DISPLAY", [[
local ok, message, code = require "ylm".view({ sh = { { 1, 0, 0, 0 } } }):show()
print(ok, code, message)]])
    assert.equal(0, status, text)
    assert.truthy(text:find "^nil%s+EMISSING%s+no display", text)
  end)

  it("opens a window on a server that ends with its last client", function()
    if not scratch.shell("command -v Xvfb >/dev/null") then return pending "Xvfb is not installed" end
    local folder = scratch.new()
    local path = folder:write("show.lua", 'print(require "ylm".view({ sh = { { 1, 0, 0, 0 } }, size = { 64, 48 } }):show())')
    local _, status = scratch.capture(([[cd %s
Xvfb -displayfd 3 -terminate -screen 0 160x120x24 3>number 2>/dev/null &
server=$!
for i in $(seq 200); do test -s number && break; sleep 0.05; done
cd - >/dev/null
DISPLAY=:$(cat %s/number) timeout 3 %s %s
status=$?
kill $server 2>/dev/null
(exit $status)]]):format(scratch.quote(folder.path), folder.path, lua, scratch.quote(path)))
    folder:remove()
    assert.equal(124, status)                                      -- the window is open until its time is over
  end)

  local has_ffi, ffi = pcall(require, "ffi")
  if has_ffi then
    it("leaves no OpenGL context current", function()
      pcall(ffi.cdef, "void *eglGetCurrentContext(void);")
      draw { sh = { { 1, 0, 0, 0 } } }
      assert(ffi.load("libEGL.so.1").eglGetCurrentContext() == nil)
    end)
  end

end)
