--- Scalar bars: how much room they need, and their drawing. A bar keeps to its room, beside the picture or below it.

local core = require "ylm.c.core"
local picture = require "ylm.picture"

local bars = {}

local LEAST_FONT = 6 -- pixels
local CLOSE = 5 -- pixels a tick: closer than these, ticks without labels are left out

--- Rows or columns of the colours of a scale on a canvas of its own.
local function colours(scale, w, h, along, theme)
  local shape = assert(core.canvas(w, h, theme.background))
  local n, at = along == "up" and h or w, {}
  for i = 1, n do at[i] = { ((along == "up" and n - i or i - 1) + 0.5) / n } end
  local values = assert(core.array_zeros({ n, 1 }, "double"))
  core.array_fill(values, at)
  local rgb = core.figure_colours(values, theme.background, scale.map, 0, 1, false)
  for i = 1, n do
    local colour = { core.array_get(rgb, i, 1), core.array_get(rgb, i, 2), core.array_get(rgb, i, 3), 1 }
    if along == "up" then core.canvas_rectangle(shape, 0, i - 1, w, 1, colour)
    else core.canvas_rectangle(shape, i - 1, 0, 1, h, colour) end
  end
  return shape
end

--- Where along a scale a number stands, 0 to 1.
local function place(scale, x)
  local lo, hi = scale.range[1], scale.range[2]
  if scale.log then return math.log(x / lo) / math.log(hi / lo) end
  return hi > lo and (x - lo) / (hi - lo) or 0.5
end

--- Label and unit, broken into lines of that width: { text, size, dim, width, height } and their height together.
local function title(scale, width, font, bare)
  local lines, height = {}, 0
  for i, words in ipairs { scale.label or "", scale.unit or "" } do
    if words ~= "" and bare == 0 then
      local size = i == 1 and font or math.max(5, font * 0.85)
      local broken = picture.wrap(words, width, { size = size })
      local w, h = picture.text(nil, broken, 0, 0, { size = size })
      lines[#lines + 1] = { text = broken, size = size, dim = i == 2, width = w, height = h }
      height = height + h + (#lines > 1 and 2 or 0)
    end
  end
  return lines, height
end

local function draw_title(canvas, lines, x, y, align, theme)
  for _, line in ipairs(lines) do
    picture.text(canvas, line.text, x, y, { size = line.size, colour = line.dim and theme.dim or theme.text, align = align })
    y = y + line.height + 2
  end
end

--- Ticks of a bar; bare 2: none of them has a label.
local function ticks(scale, most, bare)
  local places, labels = picture.ticks(scale.range[1], scale.range[2], scale.log, math.max(2, math.floor(most)), scale.whole)
  if bare == 2 then for i = 1, #labels do labels[i] = "" end end
  return places, labels
end

--- A vertical bar of that height in letters of that size: { width, height, ... }, what draw_vertical wants.
-- bare 1: without a title; 2: without labels too.
local function measure_vertical(scale, height, font, bare)
  local style, b = { size = font }, { font = font, scale = scale, height = height }
  b.thick = math.max(3, math.floor(font * 1.1))
  b.lines, b.title = title(scale, 8.5 * font, font, bare)
  local gap = b.title > 0 and math.floor(font * 0.7) or 0
  b.top, b.length = b.title + gap, math.max(0, height - b.title - gap)
  b.places, b.labels = ticks(scale, b.length / font / 2.5, bare)
  b.width = b.thick + 6
  for _, label in ipairs(b.labels) do
    if label ~= "" then b.width = math.max(b.width, b.thick + 10 + (picture.text(nil, label, 0, 0, style))) end
  end
  for _, line in ipairs(b.lines) do b.width = math.max(b.width, line.width) end
  return b
end

--- Draws a vertical bar with its upper left corner at (x, y); returns the colours' box.
local function draw_vertical(canvas, b, x, y, theme)
  local top, h, w = y + b.top, b.length, b.thick
  draw_title(canvas, b.lines, x, y, "left", theme)
  if h < 1 then return { x, top, w, 0 } end -- a picture this small has room for the title only
  core.canvas_copy(canvas, { x, top, w, h }, colours(b.scale, w, h, "up", theme), { 0, 0, w, h }, true)
  local ink, free = picture.with_alpha(theme.dim, 1), math.huge
  for i, tick in ipairs(b.places) do
    local ty, label = top + h - place(b.scale, tick) * h, b.labels[i]
    if label ~= "" or h > CLOSE * #b.places then
      core.canvas_line(canvas, x + w, ty, x + w + (label == "" and 3 or 6), ty, 1, ink)
    end
    if label ~= "" then
      local _, lh = picture.text(nil, label, 0, 0, { size = b.font })
      local ly = math.max(top - math.floor(lh / 2), math.min(top + h - math.ceil(lh / 2), math.floor(ty - lh / 2 + 0.5)))
      if ly + lh <= free then
        picture.text(canvas, label, x + w + 10, ly, { size = b.font, colour = theme.text })
        free = ly
      end
    end
  end
  return { x, top, w, h }
end

--- A horizontal bar of that width: { width, height, ... }, what draw_horizontal wants.
local function measure_horizontal(scale, width, font, bare)
  local b = { font = font, scale = scale, width = width, length = width }
  local words = scale.label or ""
  if scale.unit then words = ("%s [%s]"):format(words, scale.unit) end
  b.lines, b.title = title({ label = words }, width, font, bare)
  b.thick = math.max(3, math.floor(font * 0.8))
  b.top = b.title > 0 and b.title + math.floor(font * 0.3) or 0
  b.places, b.labels = ticks(scale, width / font / 6, bare)
  local label_height = 0
  b.left, b.right = 0, 0 -- how far the first and the last label reach beyond the colours
  for i, label in ipairs(b.labels) do
    if label ~= "" then
      local w, h = picture.text(nil, label, 0, 0, { size = font })
      local at = place(scale, b.places[i]) * width
      label_height = math.max(label_height, h)
      b.left, b.right = math.max(b.left, math.ceil(w / 2 - at)), math.max(b.right, math.ceil(at + w / 2 - width))
    end
  end
  b.height = b.top + b.thick + 8 + label_height
  return b
end

--- Draws a horizontal bar with its upper left corner at (x, y); returns the colours' box.
local function draw_horizontal(canvas, b, x, y, theme)
  x = x + b.left
  local width = math.max(1, b.length - b.left - b.right)
  local top, h, ink, free = y + b.top, b.thick, picture.with_alpha(theme.dim, 1), -math.huge
  draw_title(canvas, b.lines, math.floor(x + width / 2), y, "middle", theme)
  core.canvas_copy(canvas, { x, top, width, h }, colours(b.scale, width, h, "right", theme), { 0, 0, width, h }, true)
  for i, tick in ipairs(b.places) do
    local tx, label = x + place(b.scale, tick) * width, b.labels[i]
    if label ~= "" or width > CLOSE * #b.places then
      core.canvas_line(canvas, tx, top + h, tx, top + h + (label == "" and 3 or 6), 1, ink)
    end
    if label ~= "" then
      local w = picture.text(nil, label, 0, 0, { size = b.font })
      if tx - w / 2 >= free then
        picture.text(canvas, label, math.floor(tx + 0.5), top + h + 8,
          { size = b.font, colour = theme.text, align = "middle" })
        free = tx + w / 2 + b.font * 0.6
      end
    end
  end
  return { x, top, width, h }
end

--- Bars of a picture, measured by measure(scale, size, bare), whose room(bars) is at most `most` pixels: letters shrink; bars
-- for which the least are too large lose their titles, then their labels; nil where there is no room at all.
local function fitted(scales, font, measure, room, most)
  for attempt = 0, math.max(0, font - LEAST_FONT) + 2 do
    local size = math.max(LEAST_FONT, font - attempt)
    local list = {}
    for i, scale in ipairs(scales) do list[i] = measure(scale, size, math.max(0, attempt - font + LEAST_FONT)) end
    if room(list) <= most then return list end
  end
  return nil
end

--- Vertical bars of that height side by side, as { bars, width with a margin beside each }; nil: no room.
function bars.columns(scales, font, height, margin, most)
  local function room(list)
    local sum = 0
    for _, b in ipairs(list) do sum = sum + b.width + margin end
    return sum
  end
  local list = fitted(scales, font, function(scale, size, bare) return measure_vertical(scale, height, size, bare) end, room,
    most)
  return list and { bars = list, width = room(list), draw = draw_vertical }
end

--- Horizontal bars side by side in a row of that width, as { bars, height with a margin below }; nil: no room.
function bars.row(scales, font, width, margin, most)
  local each = math.floor((width - margin) / #scales) - margin
  if each < 24 then return nil end
  local function room(list)
    local highest = 0
    for _, b in ipairs(list) do highest = math.max(highest, b.height) end
    return highest + margin
  end
  local list = fitted(scales, font, function(scale, size, bare)
    return measure_horizontal(scale, math.min(each, 32 * font), size, bare)
  end, room, most)
  return list and { bars = list, height = room(list), each = each, draw = draw_horizontal }
end

--- A horizontal bar of that width: its height, and draw(canvas, x, y).
function bars.horizontal(scale, font, width, theme)
  local b = measure_horizontal(scale, width, font, 0)
  return b.height, function(canvas, x, y) return draw_horizontal(canvas, b, x, y, theme) end
end

return bars
