--- Where controls of the panel stand, and which lies under a pixel. The panel is a column on the right of the window.

local actions = require "ylm.live.actions"

local layout = { WIDTH = 232, MARGIN = 12 }

local TITLE, KNOB, ROW, LINE = 30, 33, 22, 16
layout.LINE = LINE

local switches = {
  { "levels", "levels", "l" }, { "lobes", "lobes", "b" }, { "gradients", "gradients", "g" }, { "errors", "est. error", "v" },
  { "truth", "true error", "e" }, { "save", "save", "s", button = true }, { "undo", "undo", "^z", button = true },
  { "help", "help", "h", button = true },
}

--- The controls from above: { x, y, w, h, knob = | action = , label =, key =, switch =, value = }, and the row where lines of
-- text begin. Places are pixels from the window's upper left corner.
function layout.items(state)
  local left, width = state.size[1] - layout.WIDTH + layout.MARGIN, layout.WIDTH - 2 * layout.MARGIN
  local items, y = {}, TITLE
  for _, knob in ipairs(actions.knobs) do
    items[#items + 1] = { x = left, y = y, w = width, h = KNOB, knob = knob }
    y = y + KNOB
  end
  for _, name in ipairs { "method", "tone" } do
    items[#items + 1] = { x = left, y = y, w = width, h = ROW, action = name, label = name, key = name == "method" and "m" or "o",
      value = true }
    y = y + ROW
  end
  for i, switch in ipairs(switches) do
    local column = (i - 1) % 2
    items[#items + 1] = { x = left + column * (width + 6) / 2, y = y, w = (width - 6) / 2, h = ROW, action = switch[1],
      label = switch[2], key = switch[3], switch = not switch.button }
    if column == 1 or i == #switches then y = y + ROW end
  end
  return items, y + 8
end

--- The control under a pixel; nil: there is none.
function layout.under(state, x, y)
  for _, item in ipairs((layout.items(state))) do
    if x >= item.x and x < item.x + item.w and y >= item.y and y < item.y + item.h then return item end
  end
end

--- The part of a knob's way at which its value stands, 0 to 1.
function layout.part(knob, value)
  if knob.log then return math.log(value / knob.least) / math.log(knob.largest / knob.least) end
  return (value - knob.least) / (knob.largest - knob.least)
end

--- The value of a slider that is dragged to x.
function layout.value(item, x)
  local t, knob = math.max(0, math.min(1, (x - item.x) / item.w)), item.knob
  if knob.log then return knob.least * (knob.largest / knob.least) ^ t end
  return knob.least + t * (knob.largest - knob.least)
end

return layout
