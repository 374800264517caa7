--- The bar that `progress = true` draws on stderr.
--
-- On a terminal it moves; in a log it is one line per stage, in tenths, however often the stage comes.
--
--     progress = progress.resolve(options.progress)   -- true -> a bar, a function -> itself, nil -> nil

local core = require "ylm.c.core"

local progress = {}

local width = 30
local unended -- the stream whose last line has no end yet
local shared -- names of short stages that were not written, of the bar that was used last
local AGAIN = 10 -- seconds
local SHORT = 0.5 -- seconds: stages that take less share a line
local PATIENCE = 2 -- seconds: work that takes less shows nothing, unless progress is asked for

--- Seconds in words: "0:42", "1:03:20".
local function clock(seconds)
  seconds = math.floor(seconds + 0.5)
  local h, m, s = math.floor(seconds / 3600), math.floor(seconds / 60) % 60, seconds % 60
  if h > 0 then return ("%d:%02d:%02d"):format(h, m, s) end
  return ("%d:%02d"):format(m, s)
end

progress.clock = clock

--- One line of a bar: "bake    [=====>         ]  34 %  0:12".
function progress.line(done, total, stage, seconds)
  local part = total > 0 and math.min(1, done / total) or 1
  local filled = math.floor(part * width)
  local bar = ("="):rep(filled) .. (filled < width and ">" or "")
  return ("%-12s [%-" .. width .. "s] %3d %%  %s"):format(stage or "", bar, math.floor(part * 100), clock(seconds))
end

--- Names of stages that have ended, and their seconds together: `add`, and `write`, which makes a line of them.
local function brief_stages(stream)
  local names, times, seconds = {}, {}, 0
  local brief = {}
  function brief.add(name, more)
    if not times[name] then names[#names + 1] = name end
    times[name], seconds = (times[name] or 0) + 1, seconds + more
  end
  function brief.write()
    if #names == 0 then return end
    for i, name in ipairs(names) do
      if times[name] > 1 then names[i] = ("%s (%d times)"):format(name, times[name]) end
    end
    stream:write(("%s  %s\n"):format(table.concat(names, ", "), clock(seconds)))
    names, times, seconds = {}, {}, 0
  end
  return brief
end

--- A function(done, total, stage) that draws a bar on `stream` (stderr), from `patience` seconds on: one line per stage.
-- Stages that take less than SHORT share a line, which is written before the next that takes more, or by progress.leave.
function progress.bar(stream, patience)
  stream = stream or io.stderr
  local awake, brief = core.seconds() + (patience or 0), brief_stages(stream)
  local stage, over, began, last -- over: the stage that has ended; last: when the bar was drawn
  local function show(done, total, now)
    if not last then brief.write() end
    local ended = done >= total
    stream:write("\r", progress.line(done, total, stage, now - began), ended and "\n" or "")
    stream:flush()
    last = now
    unended = not ended and stream or nil
  end
  --- The stage has ended, or another begins.
  local function close(done, total, now)
    if last or now >= awake and now - began >= SHORT then show(done, total, now) else brief.add(stage, now - began) end
    if unended == stream then stream:write "\n" end
    unended, over, stage = nil, stage, nil
  end
  local function bar(done, total, name)
    local now = core.seconds()
    name = name or ""
    shared = now >= awake and brief or shared
    if done >= total and stage == nil and name == over then return true end
    if stage and name ~= stage then close(1, 1, now) end
    if not stage then stage, began, last = name, now, nil end
    if done >= total then close(done, total, now)
    elseif now >= awake and now - began >= SHORT and now - (last or 0) >= 0.1 then show(done, total, now) end
    return true
  end
  core.own(bar).speak = function(text, seconds)
    local now = core.seconds()
    if now < awake and seconds < (patience or 0) then return end
    if stage then close(1, 1, now) end
    brief.write()
    stream:write("ylm: ", text, "\n")
    awake = 0
  end
  return bar
end

--- A function(done, total, stage) for logs: one line per stage, written in tenths as they are
-- reached, "bake         10 20 30 40 50 60 70 80 90 100 %  0:12". A stage that comes again, as levels do in
-- rounds of refinement, is told of where it lasts: from AGAIN seconds on.
function progress.log(stream)
  stream = stream or io.stderr
  local told = {} -- stages by name
  local stage, began, tenths, open -- tenths: nil where the stage has ended; open: its line has begun
  local function leave()
    if open then stream:write("\n") end -- it did not end
    open = false
  end
  local function begin(name)
    leave()
    stage, began, tenths = name, core.seconds(), 0
  end
  local function is_silent()
    return told[stage] and not open and core.seconds() - began < AGAIN
  end
  local function log(done, total, name)
    name = name or ""
    local part = total > 0 and math.min(1, done / total) or 1
    if name ~= stage or (tenths == nil and part < 1) then begin(name) end
    if tenths == nil then return true end
    if is_silent() then
      if part == 1 then tenths = nil end
      return true
    end
    if not open then stream:write(("%-12s"):format(name)) end
    open, told[name] = true, true
    for k = tenths + 1, math.floor(part * 10) do
      stream:write((" %d"):format(10 * k))
      tenths = k
    end
    if part == 1 then
      stream:write((" %%  %s\n"):format(clock(core.seconds() - began)))
      open, tenths = false, nil
    end
    unended = open and stream or nil
    stream:flush()
    return true
  end
  core.own(log).speak = function(text)
    leave()
    unended = nil
    stream:write("ylm: ", text, "\n")
  end
  return log
end

--- Ends the line of a bar or a log whose work was broken off, or is done, before something else is said there.
function progress.leave()
  if unended then unended:write("\n") end
  if shared then shared.write() end
  unended, shared = nil, nil
end

--- A function that shows progress on stderr: a bar that moves on a terminal, else lines for a log.
function progress.shown()
  return core.is_terminal() and progress.bar() or progress.log()
end

--- Whether progress may be shown where nobody asks for it.
function progress.is_wanted() return os.getenv "YLM_PROGRESS" ~= "no" end

--- The meaning of a `progress` option: true becomes a bar, a function stays, nil and false are nothing.
function progress.resolve(value)
  if value == true then return progress.shown() end
  return value or nil
end
progress.of = progress.resolve

--- The meaning of the `progress` option of work that may be long, once for all its stages: where nothing was given, and
-- stderr is a terminal, a bar that is drawn from PATIENCE seconds on; YLM_PROGRESS=no in the environment leaves it out.
function progress.long(value)
  if value == nil and progress.is_wanted() and core.is_terminal() then return progress.bar(nil, PATIENCE) end
  if value == true then return progress.shown() end
  return value
end

--- Is `bar` one that this module has made?
function progress.speaks(bar) return core.owned(bar, "speak") ~= nil end

--- Writes a line where `bar` is one that this module has made, and the work takes so many seconds.
function progress.say(bar, seconds, text, ...)
  local speak = core.owned(bar, "speak")
  if speak then speak(text:format(...), seconds) end
end

-- Stages ----------------------------------------------------------------------------------

--- Stages: their names and what they do.
progress.stages = {
  { "ambient", "rays find how open points are" },
  { "baking", "probes of a uniform grid are filled" },
  { "bounces", "light goes from element to element once more, until little is left" },
  { "bricks", "bricks of a large grid are baked, a task each" },
  { "cases", "functions of team:each run" },
  { "comparing", "an image is compared with another one" },
  { "compensation", "what clamped virtual lights miss near surfaces is found" },
  { "convert", "coefficients are brought to another convention" },
  { "direct", "light from lamps to elements, or to cells, before it bounces" },
  { "download", "probes come back from a device" },
  { "exp", "exponentials of coefficients" },
  { "exposures", "ꟻLIP compares images at one exposure after the other" },
  { "far lights", "virtual lights far from cells of a grid are summed" },
  { "gather", "elements are seen from points of a grid: the light field of bounces" },
  { "evaluating", "probes get the light of other lamps" },
  { "gathering", "pixels take the light of the elements that their links have found" },
  { "index", "the index of a large grid is written" },
  { "irradiance", "paths arrive at points: their irradiance" },
  { "joining", "bricks are joined at their borders" },
  { "level N", "cells of level N of an adaptive grid are filled, checked and split" },
  { "lightmap", "texels are lit" },
  { "lights", "the coefficients of lights are summed at points" },
  { "elements", "surfaces are cut into elements" },
  { "links", "rays find the elements that elements, or pixels, see" },
  { "matrices", "transfer matrices are made" },
  { "merge", "particles that landed close to each other become one virtual light" },
  { "near lights", "virtual lights near points are summed one by one" },
  { "plan", "lamps are moved towards the light that is asked for" },
  { "occupancy", "cells that surfaces meet are found" },
  { "particles", "particles fly from lamps, or what they left is measured" },
  { "paths", "paths of light are traced, for a picture or for judging one" },
  { "places", "paths are traced from points of a picture, as a tolerance is judged; or pixels get more places of their own" },
  { "points in lights", "probes inside of lamps get values from their neighbours" },
  { "polygons", "coefficients of flat lights are summed at points" },
  { "primary rays", "camera rays find what each pixel sees" },
  { "probes", "paths arrive at probes: their coefficients" },
  { "product", "products of coefficients" },
  { "products", "products of materials and light are kept" },
  { "project", "values are projected on spherical harmonics" },
  { "radius", "virtual lights get radii from their neighbours" },
  { "surfaces", "light on surfaces is fitted, and rectangles are halved" },
  { "rounding", "numbers of a grid are rounded for a file of few bytes, with ever better steps" },
  { "guides", "a pilot learns which lamps and parts of the sky are seen from where, and where reflected light comes from" },
  { "denoising", "light of a picture is fitted to that of points around, where it has noise" },
  { "raycast", "shadow rays go from pixels to lamps" },
  { "rays", "rays find what a body hides" },
  { "reconstruct", "coefficients are summed to values in directions" },
  { "resizing", "an image is resized" },
  { "rotate", "coefficients are rotated" },
  { "sampling", "a grid is interpolated at points" },
  { "shading", "light is asked for at the points of a picture, and reflected" },
  { "shadows", "light behind bodies that move is found" },
  { "sides", "voxels that walls cross are cut into parts" },
  { "spheres", "spheres fill a closed mesh" },
  { "spherical harmonics", "basis functions are evaluated" },
  { "table", "a material is tabulated" },
  { "texels", "texels of a lightmap are fitted, each time with another weight of smoothness" },
  { "top", "the coarse levels above bricks are baked" },
  { "transfer", "occlusion rays make transfer vectors" },
  { "unwrap", "charts of a mesh are flattened" },
  { "updating", "a grid follows lamps that have moved" },
  { "verifying", "other points than those of the bake say whether a tolerance is met" },
  { "virtual lights", "pixels take the light of virtual lights" },
}

return progress
