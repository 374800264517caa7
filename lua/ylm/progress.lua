--- The bar that `progress = true` draws on stderr.
--
-- On a terminal it moves; in a log it is one line per stage, in tenths, however often the stage comes.
--
--     progress = progress.resolve(options.progress)   -- true -> a bar, a function -> itself, nil -> nil

local core = require "ylm.c.core"

local progress = {}

local width = 30
local unended -- the stream whose last line has no end yet
local AGAIN = 10 -- seconds

--- Seconds in words: "0:42", "1:03:20".
local function clock(seconds)
  seconds = math.floor(seconds + 0.5)
  local h, m, s = math.floor(seconds / 3600), math.floor(seconds / 60) % 60, seconds % 60
  if h > 0 then return ("%d:%02d:%02d"):format(h, m, s) end
  return ("%d:%02d"):format(m, s)
end

--- One line of a bar: "bake    [=====>         ]  34 %  0:12".
function progress.line(done, total, stage, seconds)
  local part = total > 0 and math.min(1, done / total) or 1
  local filled = math.floor(part * width)
  local bar = ("="):rep(filled) .. (filled < width and ">" or "")
  return ("%-12s [%-" .. width .. "s] %3d %%  %s"):format(stage or "", bar, math.floor(part * 100), clock(seconds))
end

--- A function(done, total, stage) that draws a bar on `stream` (stderr). One line per stage is kept.
function progress.bar(stream)
  stream = stream or io.stderr
  local stage, began, last
  return function(done, total, name)
    local now = core.seconds()
    if name ~= stage then
      stage, began, last = name, now, nil
    end
    local ended = done >= total
    if not ended and last and now - last < 0.1 then return true end
    if ended and last == math.huge then return true end
    last = ended and math.huge or now
    stream:write("\r", progress.line(done, total, stage, now - began), ended and "\n" or "")
    unended = not ended and stream or nil
    stream:flush()
    return true
  end
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
  return function(done, total, name)
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
end

--- Ends the line of a bar or a log whose work was broken off, before something else is said there.
function progress.leave()
  if unended then unended:write("\n") end
  unended = nil
end

--- A function that shows progress on stderr: a bar that moves on a terminal, else lines for a log.
function progress.shown()
  return core.is_terminal() and progress.bar() or progress.log()
end

--- The meaning of a `progress` option: true becomes a bar, a function stays, nil and false are nothing.
function progress.resolve(value)
  if value == true then return progress.shown() end
  return value or nil
end
progress.of = progress.resolve

return progress
