--- A plot as lines, areas and words in pixels, from the upper left corner; as SVG.
--
-- A stroke is { points = { x1, y1, x2, y2, .. }, colour, width, dash }, an area { points, colour,
-- fill = true }, words { text, x, y, size, bold, colour }. x and y of words are the left end of the
-- line that letters stand on.

local lines = {}

local ASCENT = 0.797    -- of a line's height: what is above the line that letters stand on, of DejaVu Sans
local LEGEND = { padding = 8, symbol = 26 } -- pixels, as chart.cpp has them

-- Places -------------------------------------------------------------------------------

--- The place of a number on an axis { least, largest, log } from `first` to `last` pixels.
local function place(axis, value, first, last)
  local t
  if axis.log then t = math.log(value / axis.least) / math.log(axis.largest / axis.least)
  else t = (value - axis.least) / (axis.largest - axis.least) end
  return first + t * (last - first)
end

lines.place = place

--- The part of a segment that is inside of a box, or nil (Liang & Barsky).
local function clip(x0, y0, x1, y1, box)
  local from, to, dx, dy = 0, 1, x1 - x0, y1 - y0
  for _, side in ipairs { { -dx, x0 - box[1] }, { dx, box[3] - x0 }, { -dy, y0 - box[2] }, { dy, box[4] - y0 } } do
    local p, q = side[1], side[2]
    if p == 0 then
      if q < 0 then return nil end
    elseif p < 0 then from = math.max(from, q / p)
    else to = math.min(to, q / p) end
  end
  if from > to then return nil end
  return x0 + from * dx, y0 + from * dy, x0 + to * dx, y0 + to * dy
end

--- Polylines of what a line shows inside of the box.
local function clipped(points, box)
  local list, last = {}, nil
  for i = 1, #points - 3, 2 do
    local x0, y0, x1, y1 = clip(points[i], points[i + 1], points[i + 2], points[i + 3], box)
    if not x0 then last = nil
    else
      if not last or last[#last - 1] ~= x0 or last[#last] ~= y0 then
        last = { x0, y0 }
        list[#list + 1] = last
      end
      last[#last + 1], last[#last + 2] = x1, y1
    end
  end
  return list
end

-- Markers --------------------------------------------------------------------------------

local function ring(x, y, r, n, turn)
  local points = {}
  for i = 0, n - 1 do
    local angle = turn + 2 * math.pi * i / n
    points[#points + 1], points[#points + 2] = x + r * math.cos(angle), y + r * math.sin(angle)
  end
  return points
end

local markers = {
  circle = function(x, y, r) return ring(x, y, r, 24, 0), true end,
  square = function(x, y, r) return ring(x, y, r * math.sqrt(2), 4, math.pi / 4), true end,
  diamond = function(x, y, r) return ring(x, y, r, 4, 0), true end,
  plus = function(x, y, r) return { x - r, y, x + r, y }, false, { x, y - r, x, y + r } end,
  cross = function(x, y, r) return { x - r, y - r, x + r, y + r }, false, { x - r, y + r, x + r, y - r } end,
}

local function put_marker(put, s, x, y)
  local points, filled, more = markers[s.marker](x, y, s.marker_size / 2)
  put { points = points, fill = filled, colour = s.colour, width = 1.5 }
  if more then put { points = more, colour = s.colour, width = 1.5 } end
end

local function dash_of(s) return s.dash ~= "solid" and s.dash or nil end

--- Marks of words by their upper left corners { text, x, y, size, bold, colour }, behind others in the list.
function lines.with_words(list, words, measure)
  for _, word in ipairs(words) do
    local _, h = measure(word.text, word.size, word.bold)
    list[#list + 1] = { text = word.text, x = word.x, y = word.y + ASCENT * h, size = word.size, bold = word.bold,
      colour = word.colour }
  end
  return list
end

--- The area of a picture of `width` x `height` pixels.
function lines.background(colour, width, height)
  return { points = { 0, 0, width, 0, width, height, 0, height }, fill = true, colour = colour }
end

-- The plot -------------------------------------------------------------------------------

--- The legend of the series `named` in the corner of a box that the chart names.
local function put_legend(put, label, measure, chart, named, box)
  local fg, bg, font = chart.foreground, chart.background, chart.font
  local left, top, right, bottom = box[1], box[2], box[3], box[4]
  local widest, line = 0, font + LEGEND.padding
  for _, s in ipairs(named) do widest = math.max(widest, (measure(s.label, font))) end
  local w, h = widest + LEGEND.symbol + 2 * LEGEND.padding, #named * line + LEGEND.padding
  local x = chart.legend:find "right" and right - w or left
  local y = chart.legend:find "top" and top or bottom - h
  local frame = { x, y, x + w, y, x + w, y + h, x, y + h }
  put { points = frame, fill = true, colour = { bg[1], bg[2], bg[3], 0.85 } }
  frame[9], frame[10] = x, y
  put { points = frame, colour = { fg[1], fg[2], fg[3], 0.25 }, width = 1 }
  for i, s in ipairs(named) do
    local middle = y + LEGEND.padding / 2 + (i - 0.5) * line
    local from, to = x + LEGEND.padding, x + LEGEND.padding + LEGEND.symbol
    if s.width > 0 then
      put { points = { from, middle, to, middle }, colour = s.colour, width = s.width, dash = dash_of(s) }
    end
    if s.marker_size > 0 then put_marker(put, s, (from + to) / 2, middle) end
    label(s.label, to, middle, 0, 0.5)
  end
end

--- Strokes, areas and words of a chart of `width` x `height` pixels. measure(text, size) returns a width and a height;
-- `words` are texts around the axes, by their upper left corners.
function lines.of(chart, words, width, height, measure)
  local list = {}
  local function put(mark) list[#list + 1] = mark end
  local left, right, top, bottom = chart.left, width - chart.right, chart.top, height - chart.bottom
  local fg, bg, font = chart.foreground, chart.background, chart.font
  local faint = {}
  for i = 1, 3 do faint[i] = bg[i] + 0.1 * (fg[i] - bg[i]) end
  local function at(axis, value)
    return axis == chart.x and place(axis, value, left, right) or place(axis, value, bottom, top)
  end
  local function label(text, x, y, align, rise)
    local w, h = measure(text, font)
    put { text = text, x = x - align * w, y = y - rise * h + ASCENT * h, size = font, colour = fg }
  end
  put(lines.background(bg, width, height))
  for i, value in ipairs(chart.x.ticks) do
    local x = at(chart.x, value)
    put { points = { x, top, x, bottom }, colour = faint, width = 1 }
    put { points = { x, bottom, x, bottom + 4 }, colour = fg, width = 1.2 }
    if chart.x.labels[i] ~= "" then label(chart.x.labels[i], x, bottom + 8, 0.5, 0) end
  end
  for i, value in ipairs(chart.y.ticks) do
    local y = at(chart.y, value)
    put { points = { left, y, right, y }, colour = faint, width = 1 }
    put { points = { left - 4, y, left, y }, colour = fg, width = 1.2 }
    if chart.y.labels[i] ~= "" then label(chart.y.labels[i], left - 8, y, 1, 0.5) end
  end
  put { points = { left, top, left, bottom, right, bottom }, colour = fg, width = 1.2 }
  local box, named = { left, top, right, bottom }, {}
  for _, s in ipairs(chart.series) do
    local points = {}
    for i = 1, #s.x do points[2 * i - 1], points[2 * i] = at(chart.x, s.x[i]), at(chart.y, s.y[i]) end
    if s.width > 0 then
      for _, part in ipairs(clipped(points, box)) do
        put { points = part, colour = s.colour, width = s.width, dash = dash_of(s) }
      end
    end
    if s.marker_size > 0 then
      for i = 1, #points, 2 do
        local x, y = points[i], points[i + 1]
        if x >= left - 0.5 and x <= right + 0.5 and y >= top - 0.5 and y <= bottom + 0.5 then put_marker(put, s, x, y) end
      end
    end
    if s.label and s.label ~= "" then named[#named + 1] = s end
  end
  if chart.legend ~= "none" and #named > 0 then put_legend(put, label, measure, chart, named, box) end
  return lines.with_words(list, words, measure)
end

-- SVG --------------------------------------------------------------------------------------

local function hex(colour)
  local digits = {}
  for i = 1, 3 do digits[i] = ("%02x"):format(math.floor(math.max(0, math.min(1, colour[i])) * 255 + 0.5)) end
  return "#" .. table.concat(digits)
end

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;" }

local function number(x) return (("%.2f"):format(x):gsub("%.?0+$", "")) end

local function pairs_of(points)
  local list = {}
  for i = 1, #points, 2 do list[#list + 1] = number(points[i]) .. "," .. number(points[i + 1]) end
  return table.concat(list, " ")
end

local function opacity(kind, colour)
  return colour[4] and colour[4] < 1 and (' %s-opacity="%s"'):format(kind, number(colour[4])) or ""
end

--- The marks as an SVG of `width` x `height` pixels. Letters are DejaVu Sans, or what the reader has.
function lines.svg(marks, width, height)
  local out = { ('<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" viewBox="0 0 %d %d" '
    .. 'font-family="DejaVu Sans, Verdana, sans-serif">'):format(width, height, width, height) }
  for _, m in ipairs(marks) do
    if m.text then
      out[#out + 1] = ('<text x="%s" y="%s" font-size="%s"%s fill="%s">%s</text>'):format(number(m.x), number(m.y),
        number(m.size), m.bold and ' font-weight="bold"' or "", hex(m.colour), (m.text:gsub('[&<>"]', entities)))
    elseif m.fill then
      out[#out + 1] = ('<polygon points="%s" fill="%s"%s/>'):format(pairs_of(m.points), hex(m.colour),
        opacity("fill", m.colour))
    else
      local dash = m.dash == "dashed" and ' stroke-dasharray="8 5"' or m.dash == "dotted" and ' stroke-dasharray="2 4"' or ""
      out[#out + 1] = ('<polyline points="%s" fill="none" stroke="%s"%s stroke-width="%s"%s/>'):format(pairs_of(m.points),
        hex(m.colour), opacity("stroke", m.colour), number(m.width), dash)
    end
  end
  out[#out + 1] = "</svg>\n"
  return table.concat(out, "\n")
end

return lines
