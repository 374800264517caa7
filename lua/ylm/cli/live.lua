--- ylm live SCENE.lua: a window in which lamps are dragged.

local bindings = require "ylm.live.bindings"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- Keys and gestures as lines of text.
local function notes()
  local lines = { "by hand and by key:" }
  for _, line in ipairs(bindings.lines()) do lines[#lines + 1] = ("  %-34s %s"):format(line[1], line[2]) end
  return table.concat(lines, "\n")
end

return {
  summary = "a window in which lamps are dragged, while a grid follows; replays of it without a display",
  usage = "SCENE.lua [--replay FILE [--hidden]] [--picture FILE.png]",
  least = 1,
  options = {
    { "size", "-s", "WxH", "pixels of the window, default 1024x768; of a replay that its file says" },
    { "tolerance", nil, "N", "of the grid while something moves, default the larger of the probes' and 0.05; probes "
      .. "without a tolerance are as the scene says" },
    { "depth", nil, "N", "of the octree, 1 to 12" },
    { "exposure", nil, "N", "stops" },
    { "tone", nil, "NAME", "tone curve" },
    { "budget", nil, "N", "milliseconds that a picture may take while something moves, default 50" },
    { "noise", nil, "N", "of the picture by rays at rest, default 0.03 for 3 % of the light around each pixel" },
    { "light-samples", nil, "N", "of the picture by rays, instead of --noise: shadow rays of a shading point" },
    { "denoise", nil, "NAME", "of the picture by rays: auto (default) or none" },
    { "bounces", "-b", "NAME", "of the picture by rays: reflections after direct light, 0, 1 .. or all (default)" },
    { "replay", nil, "FILE", "plays a file of events, and closes" },
    { "hidden", nil, nil, "a replay without a window: no display is needed" },
    { "record", nil, "FILE", "writes a file of events" },
    { "save", nil, "PREFIX", "begins the names of what the key s writes; default: the scene's file without its ending" },
    { "picture", nil, "FILE", "a .png of the window as it was when it closed" },
    { "no-panel", nil, nil, "begins without the panel" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  examples = {
    "ylm live examples/scenes/two_lamps.lua",
    "ylm live examples/scenes/two_lamps.lua --replay examples/live/drag.events --hidden --picture live.png",
  },
  notes = notes(),
  run = function(given)
    if given.picture then status.need_output("live", given.picture, "png") end
    if given.hidden and not given.replay then status.stop(status.usage,
      "live: --hidden goes with --replay FILE: nobody could close it") end
    if given.budget and not (given.budget > 0) then status.stop(status.usage,
      "live: --budget is a number of milliseconds above 0") end
    local path = given[1]
    local scene = status.load_scene(path)
    if not scene.camera then status.stop(status.script, "%s: live: the scene has no camera", path) end
    local edited, facts = scene:live { size = given.size, tolerance = given.tolerance, depth = given.depth,
      exposure = given.exposure, tone = given.tone, budget = given.budget and given.budget / 1e3,
      noise = given.noise, light_samples = given["light-samples"], denoise = given.denoise,
      bounces = status.bounces("live", given.bounces), events = given.replay, hidden = given.hidden, record = given.record,
      save = given.save, picture = given.picture, panel = not given["no-panel"], quiet = given.quiet or given.json,
      threads = given.threads }
    status.need(edited, facts)
    if given.json then report.print(given, facts)
    else
      if facts.picture then report.say_noise(given, facts.picture) end
      for _, name in ipairs(facts.saved) do report.say(given, "%s", name) end
    end
    return status.good
  end,
}
