--- Files of events: "ylm events 1 WIDTH HEIGHT", then a line for each event, which begins with the frame it arrives at.

local check = require "ylm.check"

local replay = {}

local buttons = { left = true, middle = true, right = true }

--- The parts of a line behind an event's word: places are numbers, words are words, more may be shift and control.
local forms = {
  move = { "x", "y" }, press = { "x", "y", "button" }, release = { "x", "y", "button" }, wheel = { "x", "y", "notches" },
  key = { "key" }, resize = { "x", "y" }, rest = {}, picture = { "file" }, scale = { "scale" }, close = {},
}
local words = { "move", "press", "release", "wheel", "key", "resize", "rest", "picture", "scale", "close" }

local PIXELS = 1e6 -- a place lies within so many

local function number(text)
  local n = tonumber(text) or tonumber((text:gsub("%.", ","))) -- under a locale whose decimals begin with a comma
  return n and n == n and math.abs(n) <= PIXELS and n
end

--- One event of a line's words behind its frame; nil, message.
local function event_of(kind, rest)
  local form = forms[kind]
  if not form then
    local guess = check.guess(kind, words)
    return nil, ("no event %s%s"):format(check.describe(kind), guess and (" (did you mean '%s'?)"):format(guess) or "")
  end
  local event = { kind = kind, x = 0, y = 0 }
  for i, name in ipairs(form) do
    local word = rest[i]
    if word == nil then return nil, ("%s: its %s is missing"):format(kind, name) end
    if name == "key" or name == "file" then event[name] = word
    elseif name == "button" then
      if not buttons[word] then return nil, ("%s: a button is left, middle or right, got %s"):format(kind,
        check.describe(word)) end
      event.button = word
    else
      event[name] = number(word)
      if not event[name] then return nil, ("%s: %s must be a number, got %s"):format(kind, name, check.describe(word)) end
    end
  end
  for i = #form + 1, #rest do
    if rest[i] ~= "shift" and rest[i] ~= "control" then
      return nil, ("%s: 'shift' or 'control' expected, got %s"):format(kind, check.describe(rest[i]))
    end
    event[rest[i]] = true
  end
  if kind == "scale" and event.scale ~= 1 and event.scale ~= 2 and event.scale ~= 4 then
    return nil, ("scale: 1, 2 or 4 expected, got %s"):format(check.describe(rest[1]))
  end
  if kind == "resize" and (event.x < 1 or event.y < 1 or event.x > 8192 or event.y > 8192) then
    return nil, "resize: sides are 1 to 8192 pixels"
  end
  return event
end

--- Events of a file's text: a list in order, each with its `frame`, and { width, height }; or nil, message with file and line.
function replay.parse(text, name)
  local events, size, last, n = {}, nil, 0, 0
  for line in (text .. "\n"):gmatch "(.-)\r?\n" do
    n = n + 1
    local function bad(message, ...) return nil, ("%s:%d: "):format(name, n) .. message:format(...) end
    local parts = {}
    for word in line:gsub("#.*", ""):gmatch "%S+" do parts[#parts + 1] = word end
    if not size then
      if #parts > 0 then
        local w, h = tonumber(parts[4]), tonumber(parts[5])
        if parts[1] ~= "ylm" or parts[2] ~= "events"
          then return bad "a file of events begins with 'ylm events 1 WIDTH HEIGHT'" end
        if parts[3] ~= "1" then return bad("version 1 of events is known, got %s", check.describe(parts[3])) end
        if not check.is_integer(w) or not check.is_integer(h) or w < 1 or h < 1 or w > 8192 or h > 8192 then
          return bad "the window's width and height are integers from 1 to 8192"
        end
        size = { w, h }
      end
    elseif #parts > 0 then
      local frame = tonumber(parts[1])
      if not check.is_integer(frame) or frame < 0 then return bad("a frame's number expected first, got %s",
        check.describe(parts[1])) end
      if frame < last then return bad("frame %d comes after frame %d", frame, last) end
      if frame > 1e6 then return bad "more than a million frames" end
      if not parts[2] then return bad "an event expected behind the frame" end
      local event, message = event_of(parts[2], { select(3, (table.unpack or unpack)(parts)) }) -- luacheck: ignore
      if not event then return bad("%s", message) end
      event.frame, last = frame, frame
      events[#events + 1] = event
    end
  end
  if not size then return nil, ("%s: no 'ylm events 1 WIDTH HEIGHT'"):format(name) end
  return events, size
end

--- Events given as a list of tables { frame, kind, ... }, checked as lines are; or nil, message.
function replay.check(list)
  local events, last = {}, 0
  for i, given in ipairs(list) do
    local function bad(message, ...) return nil, ("events[%d]: "):format(i) .. message:format(...) end
    if type(given) ~= "table" then return bad("a table { frame, kind, ... } expected, got %s", check.describe(given)) end
    local frame, rest = given[1] or given.frame or last, {}
    if not check.is_integer(frame) or frame < 0 or frame > 1e6 then return bad("a frame's number expected, got %s",
      check.describe(frame)) end
    if frame < last then return bad("frame %d comes after frame %d", frame, last) end
    local kind = given[2] or given.kind
    if given[2] then
      for k = 3, #given do rest[#rest + 1] = tostring(given[k]) end
    else
      for k, name in ipairs(forms[kind] or {}) do rest[k] = given[name] ~= nil and tostring(given[name]) or nil end
    end
    for _, name in ipairs { "shift", "control" } do
      if given[name] then rest[#rest + 1] = name end
    end
    local event, message = event_of(kind, rest)
    if not event then return bad("%s", message) end
    event.frame, last = frame, frame
    events[#events + 1] = event
  end
  return events
end

--- A number as files of events have it, whatever the locale.
local function number_text(x)
  if x == math.floor(x) then return ("%d"):format(x) end
  return (("%.17g"):format(x):gsub(",", "."))
end

--- A line of a file of events.
function replay.line(frame, event)
  local parts = { ("%d"):format(frame), event.kind }
  for _, name in ipairs(forms[event.kind]) do
    local value = event[name]
    parts[#parts + 1] = type(value) == "number" and number_text(value) or tostring(value)
  end
  if event.shift then parts[#parts + 1] = "shift" end
  if event.control then parts[#parts + 1] = "control" end
  return table.concat(parts, " ")
end

--- The first line of a file.
function replay.head(size) return ("ylm events 1 %d %d"):format(size[1], size[2]) end

return replay
