--- Random events for windows of scene:live, hidden: places outside, presses without release, windows of one pixel, keys in any
-- order. No event may raise, end a window, or leave a picture that cannot be drawn.
--
--     YLM_SPEC=long make asan SPEC=spec/live_spec.lua       10,000 events under AddressSanitizer and UBSan
--     build/ylm run spec/fuzz/live.lua 10000 7              events, seed; prints what was done

local bindings = require "ylm.live.bindings"
local ylm = require "ylm"

local WINDOW = 500 -- events of a window
local PIXELS = { 1, 48, 64, 300, 420 }

--- A function(n) that draws integers from 1 to n.
local function drawing(seed)
  return function(n)
    seed = (seed * 16807) % 2147483647
    return seed % n + 1
  end
end

--- Keys with their modifier, but for those that close the window and write files.
local function keys()
  local out = {}
  for _, row in ipairs(bindings.keys) do
    for _, name in ipairs(row[1]) do
      if row[2] ~= "close" and row[2] ~= "save" then out[#out + 1] = { name, row.control } end
    end
  end
  return out
end

local kinds = { "press", "release", "move", "move", "move", "wheel", "key", "key", "key", "resize", "scale" }
local buttons, modifiers = { "left", "left", "middle", "right" }, { "shift", "control" }

--- A list of n events of a replay; one of `rests` lets refinement end.
local function events_of(n, random, rests)
  local all, out = keys(), {}
  for i = 1, n do
    local kind, x, y = kinds[random(#kinds)], random(500) - 100, random(140) - 40
    local event = { i, kind, x, y, buttons[random(4)] }
    if kind == "key" then
      local k = all[random(#all)]
      event = { i, "key", k[1], control = k[2] }
    elseif kind == "wheel" then event[5] = random(40) - 20
    elseif kind == "move" then event[5] = nil
    elseif kind == "scale" then event = { i, "scale", 2 ^ (random(3) - 1) }
    elseif kind == "resize" then event = { i, "resize", PIXELS[random(5)], PIXELS[random(3)] }
    end
    local rare = kind == "resize" or kind == "scale"
    if rare and random(4) > 1 then event, rare = { i, "move", x, y }, false end
    if kind ~= "key" and not rare and random(4) == 1 then event[modifiers[random(2)]] = true end
    if random(rests) == 1 then event = { i, "rest" } end
    out[i] = event
  end
  return out
end

--- Scenes of different kinds: lamps, none, beside flat ones, without geometry, under a sky.
local function scenes()
  local lamps = { ylm.sphere_light { at = { -0.5, 0.5, 0.3 }, radius = 0.08, radiance = 30 },
    ylm.sphere_lights { at = { { 0.9, 0.6, 0.6 }, { 0.2, 1, -1 } }, radius = { 0.06, 0.05 }, radiance = 20 } }
  local flat = ylm.polygon_light { vertices = { { -1, 2, 0 }, { 1, 2, 0 }, { 0, 2, 1 } }, radiance = 2 }
  local sky = ylm.environment_light { image = ylm.image { size = { 8, 4 } } }
  local floor = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 2 } }
  local function scene(lights, geometry)
    return ylm.scene "random" { camera = ylm.camera { from = { 0, 1.4, 3.2 }, at = { 0, 0.4, 0 }, fov = 45 },
      geometry = geometry or floor, lights = lights, probes = ylm.adaptive_grid { lmax = 2, depth = 3, tolerance = 0.1 } }
  end
  return { scene(lamps), scene { lamps[1], lamps[2], flat }, scene {}, scene(lamps, {}), scene { lamps[1], sky } }
end

--- Plays n random events. Returns a table of what was done: windows, frames; or raises with the window's seed.
local function run(n, seed, rests)
  local list, done = scenes(), { events = n, windows = 0, frames = 0 }
  for first = 1, n, WINDOW do
    local own = seed + done.windows
    local events = events_of(math.min(WINDOW, n - first + 1), drawing(own), rests)
    local good, edited, report = pcall(ylm.live or list[1].live, list[done.windows % #list + 1], { events = events, hidden = true,
      quiet = true, size = { 64, 48 }, samples = 1, transfer_samples = 4, light_samples = 16, paths = 32,
      refine = { "view", "grid", "smooth" }, save = "unused/live" })
    if not good or not edited then error(("window %d, seed %d: %s"):format(done.windows + 1, own, tostring(good and report
      or edited)), 0) end
    done.windows, done.frames = done.windows + 1, done.frames + report.frames
  end
  return done
end

if arg and arg[0] and arg[0]:find "fuzz/live%.lua$" then
  local done = run(tonumber(arg[1] or 10000), tonumber(arg[2] or 20261123), 300)
  print(("%d events in %d windows, %d pictures"):format(done.events, done.windows, done.frames))
end

return run
