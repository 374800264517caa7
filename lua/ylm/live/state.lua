--- The state of a live window, and what events make of it. Nothing is drawn here, and no light computed.
--
-- state:take(events) returns what changed, a set of words: camera, lamps, grid (its tolerance, depth or lmax), views (their
-- lmax),
-- method, look (what is shown changes, no light), size (of the picture), save, picked, moving (a pointer is dragging).

local actions = require "ylm.live.actions"
local bindings = require "ylm.live.bindings"
local layout = require "ylm.live.layout"
local space = require "ylm.live.space"
local undo = require "ylm.live.undo"

local state = {}
local methods = {}

local CLICK = 3      -- pixels that a pointer may move between press and release of a click
local DOUBLE = 0.4   -- seconds between clicks of a double one
local REACH = 6      -- pixels around a lamp in which it can be taken
local LEAST = 400    -- pixels of width that a window has for a panel to be shown

--- A state: from = { size, camera, cameras, lamps, settings, tones, methods, diagonal, middle, near, surface_at(x, y),
-- lamp_at(x, y, reach) }.
function state.new(from)
  local s = setmetatable({}, { __index = methods })
  for k, v in pairs(from) do s[k] = v end
  s.now = 0
  s.history = undo.new(s)
  return s
end

--- Is the panel shown?
function methods.has_panel(s) return s.settings.panel and s.size[1] >= LEAST end

--- Width and height of the picture: the window without the panel.
function methods.picture_size(s)
  local w = s:has_panel() and s.size[1] - layout.WIDTH or s.size[1]
  return math.max(1, w), math.max(1, s.size[2])
end

--- Is that place of the window in the picture?
local function in_picture(s, x, y)
  local w, h = s:picture_size()
  return x >= 0 and y >= 0 and x < w and y < h
end

-- Pressing, dragging, letting go -----------------------------------------------------------

local function begin_lamp(s, i, event, changed)
  local f = space.frame(s.camera, s:picture_size())
  local x, y = space.project(f, s.lamps[i].at)
  s.chosen, changed.look = i, true
  s.drag = { kind = "lamp", lamp = i, dx = event.x - (x or event.x), dy = event.y - (y or event.y), x = event.x, y = event.y }
end

local function press_panel(s, event, changed)
  local item = layout.under(s, event.x, event.y)
  if not item or event.button ~= "left" then
    s.drag = { kind = "nothing" }
  elseif item.knob then
    s.drag = { kind = "slider", item = item }
    actions.set(s, item.knob.name, layout.value(item, event.x), changed)
  elseif item.action then
    s.drag = { kind = "nothing" }
    actions[item.action](s, event, changed)
    undo.commit(s.history, s, nil, s.now)
  end
end

local function press(s, event, changed)
  if s.drag then return end -- a second button
  if s.help then
    s.help, changed.look, s.drag = false, true, { kind = "nothing" }
  elseif not in_picture(s, event.x, event.y) then press_panel(s, event, changed)
  else
    local i = event.button == "left" and s.lamp_at(event.x, event.y, REACH)
    if i and s.lamps[i] then begin_lamp(s, i, event, changed)
    else s.drag = { kind = "camera", x = event.x, y = event.y, x0 = event.x, y0 = event.y, still = true,
      button = event.button } end
  end
  if s.drag then s.drag.button = event.button end
end

local function move_lamp(s, event, changed)
  local d = s.drag
  local row = s.lamps[d.lamp]
  if not row then return end
  local f = space.frame(s.camera, s:picture_size())
  local way = event.control and "across" or event.shift and "along" or "facing"
  local p = space.dragged(f, way, row.at, s.camera.up, event.x - d.dx, event.y - d.dy)
  if p then actions.move_lamp(s, d.lamp, p, changed) end
end

local function move(s, event, changed)
  local d = s.drag
  if not d then return end
  changed.moving = true
  if d.kind == "lamp" then move_lamp(s, event, changed)
  elseif d.kind == "slider" then actions.set(s, d.item.knob.name, layout.value(d.item, event.x), changed)
  elseif d.kind == "camera" then
    if d.still and math.abs(event.x - d.x0) <= CLICK and math.abs(event.y - d.y0) <= CLICK then return end
    d.still = false
    local w, h = s:picture_size()
    local dx, dy = event.x - d.x, event.y - d.y
    d.x, d.y = event.x, event.y
    local camera = d.button == "left" and space.turned(s.camera, dx, dy, h) or space.shifted(s.camera, dx, dy, w, h)
    actions.look(s, camera, changed)
  end
end

--- A click on the picture: the surface there is picked; the second of two looks at it.
local function click(s, event, changed)
  local last = s.clicked
  s.clicked = { x = event.x, y = event.y, time = s.now }
  local hit = s.surface_at(event.x, event.y)
  if not hit then
    s.picked, changed.look = nil, true
    return
  end
  s.picked, changed.picked, changed.look = hit, true, true
  local double = last and s.now - last.time <= DOUBLE and math.abs(last.x - event.x) <= CLICK
    and math.abs(last.y - event.y) <= CLICK
  if double then
    actions.look(s, space.looking_at(s.camera, hit.position), changed)
    s.clicked = nil
  end
end

local function release(s, event, changed)
  local d = s.drag
  if not d or d.button ~= event.button then return end
  move(s, event, changed)
  s.drag, changed.moving, changed.released = nil, nil, true
  if d.kind == "camera" and d.still and d.button == "left" then click(s, event, changed) end
  if d.kind == "slider" and d.item.knob.name ~= "exposure" then changed.grid = true end
  undo.commit(s.history, s, nil, s.now)
end

local function wheel(s, event, changed)
  local n = math.max(-20, math.min(20, event.notches or 0))
  if s.drag and s.drag.kind == "lamp" then
    if s.lamps[s.drag.lamp] then
      actions.along_sight(s, s.drag.lamp, 1.05 ^ n, changed)
      local x, y = space.project(space.frame(s.camera, s:picture_size()), s.lamps[s.drag.lamp].at)
      if x then s.drag.dx, s.drag.dy = event.x - x, event.y - y end
    end
  elseif not s.drag and in_picture(s, event.x, event.y) then
    actions.look(s, space.nearer(s.camera, n, 1e-3 * s.diagonal, 1e3 * s.diagonal), changed)
    undo.commit(s.history, s, "wheel", s.now)
  end
end

local function key(s, event, changed)
  local row = bindings.of(event)
  if not row then return end
  if s.help and row[2] ~= "help" and row[2] ~= "close" then s.help, changed.look = false, true end
  local before = #s.history.undone
  actions[row[2]](s, event, changed)
  if row[2] ~= "undo" and row[2] ~= "redo" and not s.drag then undo.commit(s.history, s, row[2], s.now) end
  return before
end

local function resize(s, event, changed)
  if event.x < 1 or event.y < 1 then return end
  s.size, changed.size, changed.look = { event.x, event.y }, true, true
end

local kinds = { press = press, move = move, release = release, wheel = wheel, key = key, resize = resize,
  close = function(s) s.closed = true end }

--- Takes a list of events; returns what changed. `now`: seconds.
function methods.take(s, events, now)
  local changed = {}
  s.now = now or s.now
  for _, event in ipairs(events) do kinds[event.kind](s, event, changed) end
  if s.drag and s.drag.kind ~= "nothing" then changed.held = true end
  return changed
end

--- A knob to a value, as a slider that is let go sets it.
function methods.set(s, name, value)
  local changed = {}
  actions.set(s, name, value, changed)
  undo.commit(s.history, s, nil, s.now)
  return changed
end

return state
