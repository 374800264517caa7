-- A film of a live window from a replay: one frame for each picture of a drag, without a display.
--
--     ylm run examples/live/film.lua                            62 frames in out/, live_000.png, ..., and live_sheet.png
--     ylm run examples/live/film.lua --events mine.events --scene room.lua --every 2
--
-- The lamp of examples/scenes/two_lamps.lua is carried over the table; the grid follows, its octree is drawn in the picture. The
-- last frame is refined by rays. live_sheet.png shows six of them. A film of it all, where ffmpeg is installed:
--
--     ffmpeg -framerate 20 -i out/live_%03d.png -pix_fmt yuv420p out/live.mp4

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

local scene = assert(ylm.load(option.scene))
local counted = {}
local edited, report = scene:live { events = name, hidden = true, quiet = true, light_samples = option.rays,
  on_frame = function(s)
  if s.grid then counted[#counted + 1] = s.grid.stats.points end
end }
os.remove(name)
if not edited then error(report, 0) end
table.sort(counted)
print(("%d frames in %s, %d to %d probes, %.1f s"):format(#report.saved, option.out, counted[1], counted[#counted],
  report.seconds))

-- Six frames on a sheet ---------------------------------------------------------------------------

local columns, rows, gap, part = 3, 2, 4, 0.5
local sheet, size
for k = 0, math.min(columns * rows, #report.saved) - 1 do
  local at = #report.saved > 1 and math.floor(k * (#report.saved - 1) / (columns * rows - 1) + 0.5) or 0
  local frame = assert(ylm.load(report.saved[math.min(at + 1, #report.saved)]))
  size = size or { math.floor(frame.size[1] * part), math.floor(frame.size[2] * part) }
  if not sheet then
    sheet = ylm.image { size = { columns * (size[1] + gap) - gap, rows * (size[2] + gap) - gap } }
    sheet:fill(1, 1, sheet.size[1], sheet.size[2], { 0.02, 0.02, 0.02 })
  end
  local x, y = k % columns * (size[1] + gap) + 1, math.floor(k / columns) * (size[2] + gap) + 1
  sheet:paste(assert(frame:resize(size)), x, y)
  sheet:text(x + 8, y + size[2] - 22, ("picture %d of %d"):format(at + 1, #report.saved), { scale = 2 })
end
if sheet then
  assert(sheet:save(option.out .. "live_sheet.png"))
  print(option.out .. "live_sheet.png")
end
