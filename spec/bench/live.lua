-- A live window: what a picture takes while a lamp is dragged, and how soon an event is answered while the picture is refined.
--
--     make bench BENCH=live
--
-- Hidden windows (EGL): no X server counts. Medians over the drag, milliseconds.

local core = require "ylm.c.core"
local sessions = require "ylm.live.session"
local ylm = require "ylm"
local vtk = require "ylm.c.vtk"

local quick = os.getenv "BENCH" == "quick"

local function median(list, part)
  table.sort(list)
  return list[math.max(1, math.ceil((part or 0.5) * #list))] or 0 / 0
end

local function options(size)
  return { size = size, refine = { "view", "grid", "smooth", "rays" }, samples = 4, transfer_samples = quick and 16 or 64,
    noise = 0.03, denoise = "auto", bounces = "all", paths = 32, exposure = 0, tone = "srgb", budget = math.huge, quiet = true,
    panel = true, events = {} }
end

--- A session of a scene in a hidden window; it has to be closed.
local function open(file, size)
  local scene = assert(ylm.load(file))
  local window = assert(vtk.live(size[1], size[2], "bench", true))
  local me = sessions.new(scene, window, options(size))
  me.fixed = 1
  assert(me:begin())
  return me, window
end

local never = function() return false end

print "| scene | window | points | probes | update | render | present | a picture: median | 95 % |"
print "| --- | --- | --: | --: | --: | --: | --: | --: | --: |"
for _, case in ipairs { { "two_lamps", { 640, 480 }, 1 }, { "two_lamps", { 320, 240 }, 1 }, { "floor_lights", { 640, 480 },
  2 } } do
  local size = quick and { 160, 120 } or case[2]
  local me, window = open(("examples/scenes/%s.lua"):format(case[1]), size)
  while me:rest(never) do if me.refine.done.shown then break end end
  local s, f = me.state, me.follow
  s.chosen = case[3]
  local update, render, present, all = {}, {}, {}, {}
  for i = 1, quick and 3 or 40 do
    local start = core.seconds()
    assert(me:handle({ { kind = "key", key = i % 20 < 10 and "Right" or "Left", x = 0, y = 0 } }, i / 30))
    all[#all + 1] = core.seconds() - start
    if i > 1 then update[#update + 1], render[#render + 1] = f.seconds.update, f.seconds.render end
    present[#present + 1] = f.seconds.present
  end
  print(("| %s | %dx%d | %d | %d | %.1f | %.1f | %.1f | %.1f | %.1f |"):format(case[1], size[1], size[2],
    me.shown.view.view.stats.points, me.shown.grid.stats.points, 1e3 * median(update), 1e3 * median(render),
    1e3 * median(present), 1e3 * median(all), 1e3 * median(all, 0.95)))
  window:close()
end

print "\nMilliseconds between two looks at the window while two_lamps is refined, 640x480; and the pictures themselves.\n"
print "| step | looks | median | 95 % | worst |"
print "| --- | --: | --: | --: | --: |"
local me, window = open("examples/scenes/two_lamps.lua", quick and { 160, 120 } or { 640, 480 })
for _ = 1, 40 do
  local last, gaps = core.seconds(), {}
  local name = me:rest(function()
    local now = core.seconds()
    gaps[#gaps + 1], last = now - last, now
    return false
  end)
  if not name then break end
  gaps[#gaps + 1] = core.seconds() - last
  print(("| %s | %d | %.0f | %.0f | %.0f |"):format(name, #gaps, 1e3 * median(gaps), 1e3 * median(gaps, 0.95),
    1e3 * median(gaps, 1)))
end
window:close()
