--- Text on canvases: super- and subscripts are set as such, whatever the font makes of them.

local text = {}

local up = { ["⁰"] = "0", ["¹"] = "1", ["²"] = "2", ["³"] = "3", ["⁴"] = "4", ["⁵"] = "5", ["⁶"] = "6", ["⁷"] = "7",
  ["⁸"] = "8", ["⁹"] = "9", ["⁻"] = "−", ["⁺"] = "+", ["ᐟ"] = "/" }
local down = { ["₀"] = "0", ["₁"] = "1", ["₂"] = "2", ["₃"] = "3", ["₄"] = "4", ["₅"] = "5", ["₆"] = "6", ["₇"] = "7",
  ["₈"] = "8", ["₉"] = "9", ["₋"] = "−", ["₊"] = "+" }

-- Of scripts, in sizes of the letters: their own size, and how far below the top of the line theirs is.
local SMALL, UP, DOWN = 0.7, -0.06, 0.4
local SPACING = 1.15 -- of lines

--- The parts of a line that are set alike: { text, shift } with the shift of scripts, nil for the line itself.
local function runs(line)
  local list = {}
  for letter in line:gmatch "[%z\1-\127\194-\244][\128-\191]*" do
    local shift = up[letter] and UP or down[letter] and DOWN or nil
    local last = list[#list]
    if not last or last.shift ~= shift then
      last = { text = "", shift = shift }
      list[#list + 1] = last
    end
    last.text = last.text .. (up[letter] or down[letter] or letter)
  end
  return list
end

--- Draws one line whose upper left corner is (x, y), or only measures it; returns width and height. A table as canvas
-- takes notes of the words instead, for pictures of lines.
local function set_line(vtk, canvas, line, x, y, style, align)
  local list, width, height = runs(line), 0, 0
  local function set(run, at, onto)
    local size = run.shift and math.max(5, style.size * SMALL) or style.size
    local row = y + math.floor((run.shift or 0) * style.size + 0.5)
    local bold, colour = style.bold or false, style.colour or { 1, 1, 1 }
    if type(onto) ~= "table" then return assert(vtk.text(onto, run.text, at, row, size, bold, colour)) end
    onto[#onto + 1] = { text = run.text, x = at, y = row, size = size, bold = bold, colour = colour }
  end
  for _, run in ipairs(list) do
    local w, h = set(run, 0, nil)
    run.at, width = width, width + w
    if not run.shift then height = math.max(height, h) end
  end
  if height == 0 then height = math.floor(style.size + 0.5) end
  if not canvas then return width, height end
  local left = x - (align == "middle" and math.floor(width / 2) or align == "right" and width or 0)
  for _, run in ipairs(list) do set(run, left + run.at, canvas) end
  return width, height
end

--- Draws text on a canvas (nil: only measures); returns width and height. (x, y) is the upper left corner, the
-- upper middle or the upper right one, as style.align says.
function text.set(vtk, canvas, words, x, y, style)
  local width, top, height = 0, 0, 0
  for line in (words .. "\n"):gmatch "(.-)\n" do
    local w, h = set_line(vtk, canvas, line, x, y + top, style, style.align)
    width, height = math.max(width, w), top + h
    top = top + math.floor(style.size * SPACING + 0.5)
  end
  return width, height
end

return text
