--- Undo of a live window: what lamps, camera and settings were before and after each change.
--
-- Rows of lamps, cameras and tables of settings are never changed in place, so that an entry holds references. Of lamps it
-- holds the rows that differ, or where their number changed both lists.

local undo = {}

local MOST = 200    -- entries
local TOGETHER = 1  -- seconds within which changes by equal keys are one

local function copied(t)
  local out = {}
  for k, v in pairs(t) do out[k] = v end
  return out
end

local function alike(a, b)
  for k, v in pairs(a) do if b[k] ~= v then return false end end
  for k, v in pairs(b) do if a[k] ~= v then return false end end
  return true
end

--- A history that begins with what `state` is.
function undo.new(state)
  return { done = {}, undone = {}, lamps = copied(state.lamps), camera = state.camera, settings = copied(state.settings) }
end

--- The difference of two lists of rows: { [place] = { before, after } }, or both lists; nil where there is none.
local function rows_between(a, b)
  if #a ~= #b then return { before = a, after = copied(b) } end
  local rows
  for i = 1, #a do
    if a[i] ~= b[i] then
      rows = rows or {}
      rows[i] = { a[i], b[i] }
    end
  end
  return rows and { rows = rows }
end

--- The difference that has the first one's past and the second one's present; nil where they cannot be one.
local function joined(first, second)
  if not first or not second then return first or second end
  if not first.rows or not second.rows then return nil end
  local rows = copied(first.rows)
  for i, pair in pairs(second.rows) do rows[i] = { rows[i] and rows[i][1] or pair[1], pair[2] } end
  return { rows = rows }
end

--- Notes what has changed since the last call as one entry. `kind`: of a key; entries of one kind that follow one another
-- within a second are one. Returns true where there was a change.
function undo.commit(history, state, kind, now)
  local lamps = rows_between(history.lamps, state.lamps)
  local entry = { kind = kind, time = now, lamps = lamps,
    camera = { history.camera, state.camera }, settings = { history.settings, copied(state.settings) } }
  if not lamps and entry.camera[1] == entry.camera[2] and alike(entry.settings[1], entry.settings[2]) then return false end
  local done = history.done
  local last = done[#done]
  local both = last and kind and last.kind == kind and now - last.time <= TOGETHER and (lamps == nil and last.lamps == nil
    or joined(last.lamps, lamps))
  if both then
    last.lamps = both ~= true and both or nil
    last.camera[2], last.settings[2], last.time = entry.camera[2], entry.settings[2], now
  else
    done[#done + 1] = entry
    if #done > MOST then table.remove(done, 1) end
  end
  history.undone = {}
  history.lamps, history.camera, history.settings = copied(state.lamps), state.camera, entry.settings[2]
  return true
end

--- Makes `state` what it was before (which = 1) or after (2) the entry; returns what changed.
local function apply(history, state, entry, which)
  local changed = { look = true }
  if entry.lamps then
    changed.lamps = true
    if entry.lamps.rows then
      for i, pair in pairs(entry.lamps.rows) do state.lamps[i] = pair[which] end
    else
      state.lamps = copied(which == 1 and entry.lamps.before or entry.lamps.after)
    end
  end
  if entry.camera[1] ~= entry.camera[2] then
    state.camera, changed.camera = entry.camera[which], true
  end
  local before, after = state.settings, entry.settings[which]
  for _, name in ipairs { "tolerance", "depth", "lmax" } do
    if before[name] ~= after[name] then changed.grid = true end
  end
  if before.lmax ~= after.lmax then changed.views = true end
  if before.panel ~= after.panel then changed.size = true end
  if before.method ~= after.method then changed.method = true end
  state.settings = copied(after)
  history.lamps, history.camera, history.settings = copied(state.lamps), state.camera, after
  return changed
end

--- Takes the last change back, or with `again` the last one that was taken back; returns what changed, nil where there is
-- nothing left.
function undo.step(history, state, again)
  local from, to = history.done, history.undone
  if again then from, to = to, from end
  local entry = table.remove(from)
  if not entry then return nil end
  to[#to + 1] = entry
  entry.kind = nil -- later keys begin an entry of their own
  return apply(history, state, entry, again and 2 or 1)
end

return undo
