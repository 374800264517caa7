--- The panel of a live window, and its help, drawn on canvases.

local bindings = require "ylm.live.bindings"
local core = require "ylm.c.core"
local layout = require "ylm.live.layout"
local picture = require "ylm.picture"

local panel = {}

local theme = picture.themes.dark
local accent, track = { 0.96, 0.62, 0.20 }, { 0.25, 0.27, 0.31 }

--- A colour with its opacity.
local function full(c) return { c[1], c[2], c[3], 1 } end

--- Words on pieces of canvas, kept: letters are slow to set.
local kept, count = {}, 0

--- Draws words on the panel's background, at most `width` pixels of them; returns their width.
local function say(canvas, words, x, y, size, colour, bold, width)
  if words == "" then return 0 end
  local key = table.concat({ words, size, colour[1], colour[2], bold and 1 or 0 }, "\1")
  local piece = kept[key]
  if not piece then
    local style = { size = size, colour = colour, bold = bold }
    local w, h = picture.text(nil, words, 0, 0, style)
    piece = { w = math.max(1, w), h = math.max(1, h) }
    piece.canvas = assert(core.canvas(piece.w, piece.h, theme.background))
    picture.text(piece.canvas, words, 0, 0, style)
    if count > 500 then kept, count = {}, 0 end
    kept[key], count = piece, count + 1
  end
  local cw, ch = core.canvas_size(canvas)
  x, y = math.floor(x + 0.5), math.floor(y + 0.5)
  local w, h = math.min(piece.w, width or piece.w, cw - x), math.min(piece.h, ch - y)
  if w > 0 and h > 0 and x >= 0 and y >= 0 then
    core.canvas_copy(canvas, { x, y, w, h }, piece.canvas, { 0, 0, w, h }, true)
  end
  return piece.w
end

local function draw_knob(canvas, state, item, left)
  local value, x, y = state.settings[item.knob.name], item.x - left, item.y
  local text = item.knob.format:format(value)
  say(canvas, item.knob.name, x, y, 12, theme.dim)
  local w = picture.text(nil, text, 0, 0, { size = 12 })
  say(canvas, text, x + item.w - w, y, 12, theme.text)
  local t = layout.part(item.knob, value)
  core.canvas_rectangle(canvas, x, y + 20, item.w, 3, full(track))
  core.canvas_rectangle(canvas, x, y + 20, math.max(1, t * item.w), 3, full(accent))
  core.canvas_rectangle(canvas, x + t * (item.w - 6), y + 16, 6, 11, full(theme.text))
end

local function draw_switch(canvas, state, item, left)
  local x, y = item.x - left, item.y
  if item.value then
    say(canvas, item.label, x, y + 3, 12, theme.dim)
    say(canvas, state.settings[item.action], x + 70, y + 3, 12, theme.text, true)
  elseif item.switch then
    local on = state.settings[item.action]
    core.canvas_rectangle(canvas, x, y + 5, 11, 11, full(on and accent or track))
    say(canvas, item.label, x + 17, y + 3, 12, on and theme.text or theme.dim)
  else
    core.canvas_rectangle(canvas, x, y + 2, item.w, 18, full(track))
    core.canvas_rectangle(canvas, x + 1, y + 3, item.w - 2, 16, full(theme.background))
    say(canvas, item.label, x + 7, y + 3, 12, theme.text)
  end
  local w = picture.text(nil, item.key, 0, 0, { size = 11 })
  say(canvas, item.key, x + item.w - w - 4, y + 4, 11, theme.dim)
end

--- The panel's canvas for a state with `title` and `lines` { text, kind: nil, "dim", "bold", "warn" }, and its left edge.
function panel.draw(state, title, lines)
  local height, left = state.size[2], state.size[1] - layout.WIDTH
  local canvas = assert(core.canvas(layout.WIDTH, height, theme.background))
  say(canvas, title, layout.MARGIN, 7, 14, theme.text, true, layout.WIDTH - 2 * layout.MARGIN)
  local items, y = layout.items(state)
  for _, item in ipairs(items) do
    if item.knob then draw_knob(canvas, state, item, left) else draw_switch(canvas, state, item, left) end
  end
  for _, line in ipairs(lines) do
    local kind = line[2]
    local colour = kind == "dim" and theme.dim or kind == "warn" and accent or theme.text
    for _, part in ipairs(panel.wrap(line[1])) do
      if y + layout.LINE > height then return canvas, left end
      say(canvas, part, layout.MARGIN, y, 12, colour, kind == "bold", layout.WIDTH - layout.MARGIN)
      y = y + layout.LINE
    end
  end
  return canvas, left
end

--- Pieces of a line that fit the panel.
local broken, pieces = {}, 0
function panel.wrap(words)
  local list = broken[words]
  if list then return list end
  list = {}
  local all = picture.wrap(words, layout.WIDTH - 2 * layout.MARGIN, { size = 12 })
  for part in (all .. "\n"):gmatch "(.-)\n" do list[#list + 1] = part end
  if pieces > 500 then broken, pieces = {}, 0 end
  broken[words], pieces = list, pieces + 1
  return list
end

--- Help over the whole window.
function panel.help(state)
  local w, h = state.size[1], state.size[2]
  local canvas, lines = assert(core.canvas(w, h, theme.background)), bindings.lines()
  local pitch = math.max(9, math.min(18, math.floor((h - 40) / (#lines + 1))))
  local size = math.max(7, pitch - 5)
  local column = math.floor(math.min(270, 0.34 * w))
  say(canvas, "Keys and gestures (h closes)", 16, 8, size + 2, theme.text, true)
  for i, line in ipairs(lines) do
    local y = 14 + i * pitch + 6
    say(canvas, line[1], 16, y, size, accent, false, column - 10)
    say(canvas, line[2], 16 + column, y, size, theme.text)
  end
  return canvas
end

return panel
