--- Keys and gestures of a live window: one list, of which help, docs and specs are made.
--
-- A row has what is pressed, the action in lua/ylm/live/actions.lua, and a sentence. Gestures have no action: they are in
-- lua/ylm/live/state.lua.

local bindings = {}

bindings.gestures = {
  { "drag a lamp", "in the plane through it that faces the camera; with Shift along `up`, with Control across `up`" },
  { "wheel while a lamp is dragged", "move it along the line of sight, 5 % per notch" },
  { "drag elsewhere", "turn the camera; with the right button shift it" },
  { "wheel", "move the camera nearer or farther" },
  { "click on a lamp", "choose it" },
  { "click on a surface", "print the grid's cell at that place, its error and the true error; show the cell and its lobes" },
  { "double click on a surface", "look at it" },
  { "drag a slider", "change tolerance, depth, exposure or lmax" },
}

bindings.keys = {
  { { "t" }, "finer", "tolerance finer by 10^(1/4)" },
  { { "T" }, "coarser", "tolerance coarser" },
  { { "d" }, "deeper", "depth + 1" },
  { { "D" }, "shallower", "depth - 1" },
  { { "plus", "equal" }, "brighter", "exposure + 1/3 stop", shown = "+" },
  { { "minus" }, "darker", "exposure - 1/3 stop", shown = "-" },
  { { "o" }, "tone", "next tone curve" },
  { { "m" }, "method", "next method: grid, reference, rays, path" },
  { { "Tab" }, "next_lamp", "next lamp; with Shift the one before" },
  { { "Left", "Right", "Up", "Down" }, "nudge", "move the lamp by 4 pixels", shown = "arrows" },
  { { "Page_Up", "Page_Down" }, "push", "move the lamp along sight by 1 %", shown = "Page Up, Down" },
  { { "bracketleft", "bracketright" }, "resize_lamp", "radius by 10 %", shown = "[ ]" },
  { { "comma", "period" }, "dim_lamp", "radiance by 10 %", shown = ", ." },
  { { "n" }, "new_lamp", "new lamp over the place that was clicked" },
  { { "Delete", "BackSpace" }, "delete_lamp", "take the lamp out", shown = "Delete" },
  { { "l" }, "levels", "levels: edges of the octree" },
  { { "b" }, "lobes", "lobes at the 256 nearest probes" },
  { { "g" }, "gradients", "gradients as arrows" },
  { { "v" }, "errors", "estimated error of cells as colours" },
  { { "e" }, "truth", "true error x 100: grid against method shown" },
  { { "z" }, "undo", "undo; with Shift redo", control = true, shown = "Control z" },
  { { "Z" }, "redo", "redo", control = true, shown = "Control Shift z" },
  { { "s" }, "save", "save scene and pictures" },
  { { "Home" }, "home", "the scene's camera" },
  { { "1", "2", "3", "4", "5", "6", "7", "8", "9" }, "camera", "camera of that number in the file", shown = "1 .. 9" },
  { { "p" }, "panel", "panel on, off" },
  { { "h", "F1" }, "help", "this help", shown = "h, F1" },
  { { "q", "Escape" }, "close", "close the window", shown = "q, Escape" },
}

--- The row of a key event; nil where the key does nothing.
function bindings.of(event)
  for _, row in ipairs(bindings.keys) do
    for _, key in ipairs(row[1]) do
      if key == event.key and (row.control or false) == (event.control or false) then return row end
    end
  end
end

--- The name of a row's keys for people.
function bindings.name(row) return row.shown or table.concat(row[1], ", ") end

--- All of it as lines { keys or gesture, sentence }.
function bindings.lines()
  local out = {}
  for _, g in ipairs(bindings.gestures) do out[#out + 1] = { g[1], g[2] } end
  for _, row in ipairs(bindings.keys) do out[#out + 1] = { bindings.name(row), row[3] } end
  return out
end

return bindings
