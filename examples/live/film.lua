-- A film of a live window from a replay: one frame for each picture of a drag, without a display.
--
--     ylm run examples/live/film.lua                            60 frames in out/, live_000.png, ...
--     ylm run examples/live/film.lua --events mine.events --scene room.lua --every 2
--
-- The lamp of examples/scenes/two_lamps.lua is carried over the table; the grid follows, its octree is drawn in the picture.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "../common.lua")
local option = common.options { out = "out", scene = here .. "../scenes/two_lamps.lua", events = here .. "drag.events", every = 1,
  rays = 64, frames = 1000 }

local file = assert(io.open(option.events))
local text = file:read "*a"
file:close()

-- A line 'picture' behind each frame's events ----------------------------------------------------

local lines, last, n = {}, nil, 0
local function shoot()
  if last and last % option.every == 0 and n < option.frames then
    lines[#lines + 1] = ("%d picture %slive_%03d.png"):format(last, option.out, n)
    n = n + 1
  end
end
for line in text:gmatch "[^\n]+" do
  local frame = tonumber(line:match "^(%d+) ")
  if frame and last and frame ~= last then shoot() end
  if frame and n >= option.frames then break end
  lines[#lines + 1], last = line, frame or last
end
shoot()

local name = os.tmpname()
local made = assert(io.open(name, "w"))
made:write(table.concat(lines, "\n"), "\n")
made:close()

local scene = assert(ylm.load_scene(option.scene))
local counted = {}
local edited, report = scene:live { events = name, hidden = true, quiet = true, light_samples = option.rays,
  on_frame = function(s)
  if s.grid then counted[#counted + 1] = s.grid.stats.points end
end }
os.remove(name)
if not edited then error(report, 0) end
print(("%d frames in %s, %d to %d probes, %.1f s"):format(#report.saved, option.out, math.min((table.unpack
  or unpack)(counted)), -- luacheck: ignore
  math.max((table.unpack or unpack)(counted)), report.seconds)) -- luacheck: ignore
