--- scene:live: a window in which lamps are dragged and grids follow. Events are polled, and replayed the same.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local sphere = require "ylm.light.sphere"
local noises = require "ylm.render.noise"
local picture = require "ylm.picture"
require "ylm.render.options" -- the type image_size
local replay = require "ylm.live.replay"
local scenes = require "ylm.scene"
local sessions = require "ylm.live.session"
local tracing = require "ylm.trace"
local camera_form = require "ylm.camera"

local live = { bindings = require "ylm.live.bindings" }

local AGAIN = 0.3         -- seconds of rest before what was broken off begins anew
local FRAME = 1 / 30      -- seconds of a frame of a replay
local LONG = 10000        -- lights that are written one by one into the scene that is returned

local steps = { view = true, grid = true, smooth = true, reference = true, rays = true, path = true }

function form.types.refine(x)
  local wanted = 'a list of "view", "grid", "smooth", "reference", "rays", "path"'
  if type(x) ~= "table" then return nil, wanted end
  local out = {}
  for i, name in ipairs(x) do
    if not steps[name] then return nil, wanted end
    out[i] = name
  end
  return out
end

--- Seconds above 0, infinity included.
function form.types.budget(x)
  if type(x) == "number" and x > 0 then return x end
  return nil, "a number > 0 (math.huge: full resolution always)"
end

local live_options = {
  { "size", "image_size", default = { 1024, 768 }, unit = "pixels", about = "of the window; of a replay that its file says" },
  { "tolerance", "number", min = 1e-4, max = 1, optional = true,
    about = "of the grid while something moves; default: the larger of the probes' and 0.05; probes without a tolerance are as "
      .. "the scene says" },
  { "depth", "integer", min = 1, max = 12, optional = true, about = "of the octree; default: the probes', or 6" },
  { "budget", "budget", default = 0.05, unit = "seconds",
    about = "that a picture may take while something moves: its resolution adapts; of a replay it has no effect" },
  { "samples", "integer", min = 1, max = 256, default = 4, about = "camera rays per pixel at rest" },
  { "transfer_samples", "integer", min = 1, max = 2048, default = 64, about = "occlusion rays per transfer vector at rest" },
  { "noise", "number", min = 0.001, max = 1, optional = true,
    about = "of the picture by rays at rest, as of scene:render: a pilot, then rays where noise is; default 0.03" },
  { "light_samples", "integer", min = 1, max = 65536, optional = true,
    about = "of the picture by rays, instead of noise: shadow rays of a shading point" },
  { "denoise", "choice", of = { "auto", "none" }, default = "auto", about = "of the picture by rays, as of scene:render" },
  { "bounces", "bounces", default = "all",
    about = "of the picture by rays: reflections after direct light, 0, 1, 2 .. or 'all'" },
  { "paths", "integer", min = 32, max = 65536, default = 1024, about = "paths per pixel at rest, where passes end" },
  { "exposure", "number", min = -8, max = 8, default = 0, unit = "stops" },
  { "tone", "choice", of = core.choices "tone", default = "srgb", about = "tone curve" },
  { "refine", "refine", default = { "view", "grid", "smooth", "rays" },
    about = "at rest: a view of full size, the grid by the probes' own tolerance, samples of the options; the last of reference, "
      .. "rays, path is the method that is shown at rest first" },
  { "panel", "boolean", default = true, about = "false: the window begins without its panel" },
  { "save", "path", optional = true, about = "begins the names of what s writes; default: the scene's file without its ending" },
  { "events", "any", optional = true,
    about = "a replay: a file, or a list of tables { frame, kind, ... }; the window closes behind it" },
  { "keep", "boolean", default = false, about = "true: the window stays open behind the replay" },
  { "record", "path", optional = true, about = "file that events are written to" },
  { "picture", "path", optional = true, about = ".png file of the window as it was when it closed" },
  { "hidden", "boolean", default = false, about = "true: no display is needed; needs events" },
  { "quiet", "boolean", default = false, about = "true: what is picked is not printed" },
  { "on_frame", "function", optional = true,
    about = "called as f(state) for each picture: frame, lamps, camera, settings, grid, image, "
      .. "noise (of rays or paths), seconds; false closes the window" },
  form.threads,
}

--- The table that on_frame is given.
local function told(me)
  local s, f, shown = me.state, me.follow, me.shown or {}
  return { frame = me.frames, lamps = s.lamps, camera = s.camera, settings = s.settings, chosen = s.chosen,
    grid = f.fine or f.grid, image = shown.image, method = shown.method, scale = me.scale, seconds = f.seconds,
    noise = shown.noise, relative = shown.relative, psnr = shown.psnr, depth = shown.depth, note = me.note, saved = me.saved }
end

--- Calls on_frame after a picture; false where it closes the window.
local function after(me)
  if me.o.on_frame and me.o.on_frame(told(me)) == false then me.state.closed = true end
  return not me.state.closed
end

local function record(me, frame, events)
  if not me.o.record then return end
  for _, event in ipairs(events) do me.record[#me.record + 1] = replay.line(frame, event) end
end

-- Where events come from -------------------------------------------------------------------------

--- Until the window is closed: true, or nil, message, code.
local function by_hand(me)
  local again, s = 0, me.state
  local function waiting() return me:waiting() end
  while not s.closed do
    local now, work = core.seconds(), me.refine:next(s) ~= nil
    local events, message, code = me:poll(work and math.max(0, again - now) or 0.25)
    if not events then return nil, message, code end
    now = core.seconds()
    if #events > 0 then
      record(me, me.frame, events)
      local ok
      ok, message, code = me:handle(events, now)
      if not ok then return nil, message, code end
      local last = events[#events]
      if me.changed.lamps and last.age then me.latency[#me.latency + 1] = last.age + core.seconds() - now end
      if next(me.changed) then
        me.timing = ("%.0f ms a picture"):format(1e3 * (core.seconds() - now))
        if not after(me) then break end
      end
    elseif work and now >= again then
      local name, done, code2 = me:rest(waiting, after)
      if name == false then return nil, done, code2 end
      if name and not done then again = core.seconds() + AGAIN end
      if name and done and not after(me) then break end
    end
  end
  return true
end

local commands = {}

function commands.rest(me)
  while true do
    local name, done, code = me:rest(function() return me.state.closed end, after)
    if name == false then return nil, done, code end
    if not name or me.state.closed then break end
  end
  local ok, message, code = me:present()
  if not ok then return nil, message, code end
  after(me)
  return true
end

function commands.picture(me, event)
  local ok, message, code = me:save_png(event.file)
  if not ok then return nil, message, code end
  me.saved[#me.saved + 1] = event.file
  return true
end

function commands.scale(me, event)
  me.fixed, me.scale = event.scale, event.scale
  me.follow:drop_views()
  me.refine.done = {}
  return me:handle({ { kind = "resize", x = me.state.size[1], y = me.state.size[2] } }, me.state.now)
end

function commands.close(me)
  me.state.closed = true
  return true
end

--- Plays events to their end: true, or nil, message, code.
local function by_replay(me, events)
  local i, s = 1, me.state
  while i <= #events and not s.closed do
    local frame, batch = events[i].frame, {}
    while events[i] and events[i].frame == frame and not commands[events[i].kind] do
      local event = {}
      for k, v in pairs(events[i]) do event[k] = v end
      batch[#batch + 1], i = event, i + 1
    end
    local ok, message, code
    if #batch > 0 then
      for _, event in ipairs(batch) do
        if event.kind == "resize" then
          local _, why, status = me.window:resize(event.x, event.y)
          if why then return nil, why, status end
        end
      end
      record(me, frame, batch)
      ok, message, code = me:handle(batch, frame * FRAME)
      if not ok then return nil, message, code end
      after(me)
    end
    while events[i] and events[i].frame == frame and commands[events[i].kind] and not s.closed do
      record(me, frame, { events[i] })
      ok, message, code = commands[events[i].kind](me, events[i])
      i = i + 1
      if not ok then return nil, message, code end
    end
    if not me.o.hidden then
      local polled, why, status = me.window:poll(0)
      if not polled then return nil, why, status end
      for _, event in ipairs(polled) do if event.kind == "close" then s.closed = true end end
    end
  end
  return true
end

-- Opening and closing ----------------------------------------------------------------------------

--- The events that options give: a list and a size, or nil; raises on what is no list of events.
local function events_of(o)
  local given = o.events
  if given == nil then return nil end
  if type(given) == "string" then
    local text, message, code = core.read_file(given, 2 ^ 26)
    if not text then return nil, message, code end
    local events, size = replay.parse(text, given)
    if not events then return nil, size, "EFORMAT" end
    return events, size
  end
  if type(given) ~= "table" then
    return check.bad(1, "live", "events: a file's name or a list of tables expected, got %s", check.describe(given))
  end
  local events, message = replay.check(given)
  if not events then return check.bad(1, "live", "%s", message) end
  return events
end

--- The scene with what was changed.
local function edited(me)
  local s, scene, lights = me.state, me.scene, {}
  if #s.lamps <= LONG then
    for i, row in ipairs(s.lamps) do
      lights[i] = sphere.sphere_light { at = row.at, radius = row.radius, radiance = row.radiance }
    end
  else lights[1] = me.follow.cache:light(s.lamps) end
  for _, l in ipairs(me.follow.others) do lights[#lights + 1] = l end
  local probes, now, first = scene.probes, s.settings, s.first
  if now.tolerance ~= first.tolerance or now.depth ~= first.depth or now.lmax ~= first.lmax or not probes then
    probes = me.follow:probes(now, now.tolerance ~= first.tolerance and now.tolerance or nil, probes and probes.dynamic or false)
  end
  local c = s.camera
  return scenes.scene(scene.name or "scene") { geometry = scene.geometry, lights = lights, probes = probes,
    camera = c == s.cameras[1] and scene.camera or camera_form.camera { from = c.from, at = c.at, up = c.up, fov = c.fov },
    links = scene.link_options, background = not scene.sky_is_seen and scene.background or nil }
end

local function report_of(me, seconds)
  local sorted, latency = {}, nil
  for i, x in ipairs(me.latency) do sorted[i] = x end
  table.sort(sorted)
  if #sorted > 0 then
    latency = { median = sorted[math.ceil(#sorted / 2)], p95 = sorted[math.ceil(0.95 * #sorted)], worst = sorted[#sorted],
      moves = #sorted }
  end
  return { frames = me.frames, seconds = seconds, latency = latency, saved = me.saved, cancelled = me.refine.cancelled,
    note = me.note, picture = me.follow.rays and me.follow.rays.report }
end

--- Runs a session: true, or nil, message, code.
local function run(me, events)
  local ok, message, code = me:begin()
  if not ok then return nil, message, code end
  after(me)
  if events then
    ok, message, code = by_replay(me, events)
    if ok and me.o.keep and not me.o.hidden and not me.state.closed then
      me.fixed = nil
      ok, message, code = by_hand(me)
    end
  elseif not me.state.closed then ok, message, code = by_hand(me) end
  if not ok then return nil, message, code end
  if me.o.picture then
    ok, message, code = me:save_png(me.o.picture)
    if not ok then return nil, message, code end
    me.saved[#me.saved + 1] = me.o.picture
  end
  return true
end

local function checked(s, given)
  tracing.check_scene("live", s)
  local o = form.options(1, "live", live_options, given)
  if not s.camera then return check.fail("live: scene %q has no camera", s.name or "?") end
  if o.hidden and o.events == nil then return check.fail "live: hidden needs events: nobody could close it" end
  if o.keep and o.hidden then return check.fail "live: keep is for windows that are seen: leave keep or hidden out" end
  if o.picture and not o.picture:lower():find "%.png$" then
    return check.bad(1, "live", "picture must end in .png, got %s", check.describe(o.picture))
  end
  o.save = o.save or s.file and (s.file:gsub("%.%w+$", "")) or "scene"
  if o.noise and o.light_samples then
    return check.fail "live: noise chooses counts of rays, and light_samples is given: leave one out"
  end
  if not o.light_samples then o.noise = o.noise or noises.WANTED end
  return o
end

describe "scene:live" {
  shelf = "everyday",
  about = "Opens a window in which lamps are dragged, and returns when it is closed. A grid follows the lamps within a tolerance "
    .. "(visibility = 'transfer'); at rest the picture is refined, at last by rays with all light that bounces, as "
    .. "scene:render makes it: the panel says which, and its noise. The key h shows all keys. A replay of events needs no "
    .. "display.",
  arguments = { { "options?", "table", "" } },
  options = live_options,
  returns = { { "edited", "scene", "the scene with what was changed" },
    { "report", "table", "frames, seconds, latency = { median, p95, worst, moves } in seconds, of lamps that were dragged in a "
      .. "window; saved: names of files; cancelled: pieces of work that an event broke off; picture: the report of the picture "
      .. "by rays that was made last" } },
  errors = "raises on a bad option, a scene without camera, a second window, and what on_frame raises; nil, message, code: "
    .. "EMISSING without a display, EDEVICE where it goes away (PREFIX-autosave.lua has the scene), EIO, EFORMAT: a "
    .. "file of events",
  example = [[
local scene = ylm.scene "one lamp" {
  camera = ylm.camera { from = { 0, 3, 4 } },
  geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
}
local edited, report = scene:live { size = { 64, 48 }, hidden = true, events = {
  { 0, "key", "Tab" }, { 1, "key", "Right" }, { 2, "close" } } }      -- or: without a display by hand
assert(edited == nil and report or edited.lights[1].at[1] > 0)]],
}
function live.live(s, given)
  local o = checked(s, given)
  local events, size, code = events_of(o)
  if o.events ~= nil and not events then return nil, size, code end
  if size then o.size = size end
  local vtk, message
  vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  for _, path in ipairs { o.record or false, o.picture or false } do
    if path then
      local ok
      ok, message, code = core.file_probe(path)
      if not ok then return nil, message, code end
    end
  end
  local start = core.seconds()
  local window, me
  local function work()
    me = sessions.new(s, window, o)
    me.record, me.fixed = { replay.head(o.size) }, events and 1 or nil
    return run(me, events)
  end
  window, message, code = check.result("live", vtk.live(o.size[1], o.size[2], s.name or "ylm", o.hidden))
  if not window then return nil, message, code end
  local good, ok, why, status = pcall(work)
  window:close() -- whatever was raised, memory that ran out included
  if me and o.record then check.result("live", core.file_save(o.record, table.concat(me.record, "\n") .. "\n")) end
  if not good then error(ok, 0) end
  if not ok then return nil, why, status end
  return edited(me), report_of(me, core.seconds() - start)
end

return live
