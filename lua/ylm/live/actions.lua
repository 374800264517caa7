--- Keys of a live window at work: functions of the state, the event and the table of what changed.

local space = require "ylm.live.space"
local undo = require "ylm.live.undo"
local vector = require "ylm.vector"

local actions = {}

--- Values that sliders and keys change.
actions.knobs = {
  { name = "tolerance", least = 1e-4, largest = 1, log = true, format = "%.2g" },
  { name = "depth", least = 1, largest = 12, whole = true, format = "%d" },
  { name = "exposure", least = -8, largest = 8, format = "%+.2f" },
  { name = "lmax", least = 0, largest = 8, whole = true, format = "%d" },
}
for _, knob in ipairs(actions.knobs) do actions.knobs[knob.name] = knob end

--- Sets a knob, within its bounds; notes what changes by that.
function actions.set(state, name, value, changed)
  local knob = actions.knobs[name]
  if knob.whole then value = math.floor(value + 0.5) end
  value = math.max(knob.least, math.min(knob.largest, value))
  if value == state.settings[name] then return end
  state.settings[name] = value
  if name == "tolerance" then state.settings.own = false end
  changed.look = true
  if name ~= "exposure" then changed.grid = true end
  if name == "lmax" then changed.views = true end
end

local function by_factor(name, factor)
  return function(state, _, changed) actions.set(state, name, state.settings[name] * factor, changed) end
end

local function by_step(name, step)
  return function(state, _, changed) actions.set(state, name, state.settings[name] + step, changed) end
end

actions.finer, actions.coarser = by_factor("tolerance", 10 ^ -0.25), by_factor("tolerance", 10 ^ 0.25)
actions.deeper, actions.shallower = by_step("depth", 1), by_step("depth", -1)
actions.brighter, actions.darker = by_step("exposure", 1 / 3), by_step("exposure", -1 / 3)

--- The word behind `word` in a list, the first behind the last.
local function following(list, word)
  for i, x in ipairs(list) do if x == word then return list[i % #list + 1] end end
  return list[1]
end

function actions.tone(state, _, changed)
  state.settings.tone, changed.look = following(state.tones, state.settings.tone), true
end

function actions.method(state, _, changed)
  state.settings.method, changed.method, changed.look = following(state.methods, state.settings.method), true, true
end

for _, name in ipairs { "levels", "lobes", "gradients", "errors", "truth" } do
  actions[name] = function(state, _, changed)
    state.settings[name] = not state.settings[name]
    changed.look, changed.method = true, name == "errors" or name == "truth" or changed.method
    if name == "errors" and state.settings.errors then state.settings.truth = false end
    if name == "truth" and state.settings.truth then state.settings.errors = false end
  end
end

function actions.panel(state, _, changed)
  state.settings.panel, changed.size, changed.look = not state.settings.panel, true, true
end

function actions.help(state, _, changed) state.help, changed.look = not state.help, true end

function actions.close(state) state.closed = true end

function actions.save(_, _, changed) changed.save = true end

-- Lamps ----------------------------------------------------------------------------------

--- The lamp's row with other fields; rows are never changed in place.
function actions.change_lamp(state, i, fields, changed)
  local row, new = state.lamps[i], {}
  for k, v in pairs(row) do new[k] = v end
  for k, v in pairs(fields) do new[k] = v end
  state.lamps[i], changed.lamps = new, true
end

--- The place p, kept where lamps may be.
function actions.held(state, p)
  local f = space.frame(state.camera, state:picture_size())
  return space.held(f, p, 1.01 * state.near, state.middle, 4 * state.diagonal)
end

function actions.move_lamp(state, i, p, changed)
  for a = 1, 3 do if p[a] ~= p[a] or math.abs(p[a]) == math.huge then return end end
  actions.change_lamp(state, i, { at = actions.held(state, p) }, changed)
end

function actions.next_lamp(state, event, changed)
  local n = #state.lamps
  if n == 0 then return end
  local step = event.shift and -1 or 1
  state.chosen = state.chosen and (state.chosen - 1 + step) % n + 1 or event.shift and n or 1
  changed.look = true
end

function actions.nudge(state, event, changed)
  local i = state.chosen
  if not i then return end
  local f, p = space.frame(state.camera, state:picture_size()), state.lamps[i].at
  local x, y, z = space.project(f, p)
  if not x then return end
  local dx = event.key == "Left" and -4 or event.key == "Right" and 4 or 0
  local dy = event.key == "Up" and -4 or event.key == "Down" and 4 or 0
  actions.move_lamp(state, i, space.at_depth(f, x + dx, y + dy, z), changed)
end

--- Moves a lamp along the line of sight by a factor of its distance.
function actions.along_sight(state, i, factor, changed)
  local from, p = state.camera.from, state.lamps[i].at
  actions.move_lamp(state, i, space.plus(from, space.minus(p, from), factor), changed)
end

function actions.push(state, event, changed)
  if state.chosen then actions.along_sight(state, state.chosen, event.key == "Page_Up" and 1.01 or 1 / 1.01, changed) end
end

function actions.resize_lamp(state, event, changed)
  if not state.chosen then return end
  local r = state.lamps[state.chosen].radius * (event.key == "bracketright" and 1.1 or 1 / 1.1)
  r = math.max(1e-4 * state.diagonal, math.min(10 * state.diagonal, r))
  actions.change_lamp(state, state.chosen, { radius = r }, changed)
end

function actions.dim_lamp(state, event, changed)
  if not state.chosen then return end
  local factor, c = event.key == "period" and 1.1 or 1 / 1.1, state.lamps[state.chosen].radiance
  local new = {}
  for a = 1, 3 do new[a] = math.max(0, math.min(1e6, c[a] * factor)) end
  actions.change_lamp(state, state.chosen, { radiance = new }, changed)
end

function actions.new_lamp(state, _, changed)
  local like = state.chosen and state.lamps[state.chosen]
  local radius = like and like.radius or 0.02 * state.diagonal
  local at
  if state.picked then at = space.plus(state.picked.position, state.picked.normal, 0.05 * state.diagonal + radius)
  else at = space.plus(state.camera.at, vector.unit(state.camera.up), 0.1 * state.diagonal) end
  state.lamps[#state.lamps + 1] = { at = actions.held(state, at), radius = radius, radiance = like and like.radiance or { 10,
    10, 10 } }
  state.chosen, changed.lamps, changed.look = #state.lamps, true, true
end

function actions.delete_lamp(state, _, changed)
  if not state.chosen then return end
  table.remove(state.lamps, state.chosen)
  state.chosen, changed.lamps, changed.look = nil, true, true
end

-- Camera ---------------------------------------------------------------------------------

function actions.look(state, camera, changed)
  if camera == state.camera then return end
  for _, v in ipairs { camera.from, camera.at } do
    for a = 1, 3 do if v[a] ~= v[a] or math.abs(v[a]) > 1e6 * (1 + state.diagonal) then return end end
  end
  local arm, up = space.minus(camera.at, camera.from), vector.unit(camera.up)
  if not (vector.length(arm) > 0) or not (vector.length(vector.cross(vector.unit(arm), up)) > 1e-6) then return end
  state.camera, changed.camera = camera, true
end

function actions.home(state, _, changed) actions.look(state, state.cameras[1], changed) end

function actions.camera(state, event, changed)
  local camera = state.cameras[tonumber(event.key)]
  if camera then actions.look(state, camera, changed) end
end

-- Undo -----------------------------------------------------------------------------------

local function step(again)
  return function(state, _, changed)
    local what = undo.step(state.history, state, again)
    for name in pairs(what or {}) do changed[name] = true end
    if state.chosen and not state.lamps[state.chosen] then state.chosen = nil end
    changed.undone = true
  end
end

actions.undo, actions.redo = step(false), step(true)

return actions
