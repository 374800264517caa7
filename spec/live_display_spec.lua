-- ylm live in a real window: Xvfb, a synthesised pointer (spec/support/pointer.c), a server that goes away.

local scratch = require "spec.support.scratch"
local views = require "spec.support.views"

if not views.vtk "ylm live in a window" then return end

local quote = scratch.quote

local build = os.getenv "YLM_BUILD" or "build"
if build:sub(1, 1) ~= "/" then build = scratch.capture("pwd"):gsub("%s+$", "") .. "/" .. build end

--- Seconds that a machine beside other work may take.
local PATIENCE = require "spec.support.patience" (100)

describe("ylm live in a window", function()
  local folder, why
  setup(function()
    folder = scratch.new()
    if not scratch.shell "command -v Xvfb >/dev/null" then why = "Xvfb is not installed"
    elseif not scratch.shell(("${CC:-cc} -O1 -o %s/pointer spec/support/pointer.c -lX11 -ldl 2>/dev/null"):format(
      quote(folder.path))) then why = "no headers of X11"
    elseif not scratch.shell "ldconfig -p 2>/dev/null | grep -q libXtst.so.6" then why = "libXtst is not installed" end
    folder:write("room.lua", [[
return scene "room" {
  camera = camera { from = { 0, 1.4, 3.2 }, at = { 0, 0.4, 0 } },
  geometry = { quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 8 } },
  lights = { sphere_light { at = { 0, 0.5, 0 }, radius = 0.2, radiance = 30 } },
  probes = adaptive_grid { lmax = 2, depth = 3, tolerance = 0.1 },
}]])
  end)
  teardown(function() folder:remove() end)

  --- Runs `ylm live` with a pointer that does `commands`, then shell lines `after`; returns status and output.
  local function live(commands, after, size)
    local text, status = scratch.capture(([[cd %s
rm -f number out status
Xvfb -displayfd 3 -screen 0 1000x800x24 -nolisten tcp -noreset 3>number >/dev/null 2>&1 &
server=$!
trap 'kill $server $tool 2>/dev/null' EXIT
for i in $(seq 400); do test -s number && break; sleep 0.05; done
export DISPLAY=:$(cat number)
( timeout %d %s/ylm live room.lua -s %s --light-samples 16 --json >out 2>&1; echo $? >status ) &
tool=$!
printf '%%b' %s | timeout %d ./pointer || echo "pointer: $?"
%s
for i in $(seq 1000); do test -s status && break; sleep 0.1; done
cat out]]):format(quote(folder.path), PATIENCE, quote(build), size or "320x240",
      quote(commands), PATIENCE, after or ""))
    local ended = tonumber(folder:read "status")
    return ended, text, status
  end

  it("drags a lamp, resizes, answers keys, and closes by its button", function()
    if why then return pending(why) end
    local status, text = live("wait\nsleep 1500\ndrag 160 118 220 100 40 800\nresize 200 160\nsleep 400\nresize 500 400\n"
      .. "sleep 400\nkey t\nkey l\nsleep 500\nclose\n")
    assert.equal(0, status, text)
    local moves = tonumber(text:match '"moves":(%d+)')
    local median = tonumber(text:match '"median":([%d.e+-]+)')
    assert(moves and moves >= 1 and median and median > 0 and median < 5, text)
    local saved = assert(folder:read "room-autosave.lua")
    assert(saved:find "moved    = {\n    %[1%] = { at = ", saved)
    assert(tonumber(text:match '"frames":(%d+)') > 2, text)
  end)

  it("ends by the key q", function()
    if why then return pending(why) end
    local status, text = live("wait\nsleep 800\nmove 30 20\nkey q\n", nil, "64x48")
    assert.equal(0, status, text)
  end)

  it("says that the display has gone, and leaves the scene", function()
    if why then return pending(why) end
    local status, text = live("wait\nsleep 1500\ndrag 160 118 200 110 10 300\nsleep 700\n", "kill -9 $server")
    assert.equal(1, status, text)
    assert(text:find "the display has gone", text)
    assert(folder:read "room-autosave.lua")
  end)
end)
