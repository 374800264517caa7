--- What the layers of a view draw with: surfaces, lines, bounds; failures passed on.

local core = require "ylm.c.core"

local drawing = {}

--- A layer's own table; empty where it is only asked for by `true`.
function drawing.options(value) return type(value) == "table" and value or {} end

--- Takes box b into the bounds of what is drawn.
function drawing.grow(stage, b)
  if not b then return end
  local all = stage.bounds
  if not all then
    stage.bounds = { b[1], b[2], b[3], b[4], b[5], b[6] }
    return
  end
  for a = 1, 3 do all[a], all[a + 3] = math.min(all[a], b[a]), math.max(all[a + 3], b[a + 3]) end
end

--- The length of a box's diagonal.
function drawing.diagonal(b)
  return math.sqrt((b[4] - b[1]) ^ 2 + (b[5] - b[2]) ^ 2 + (b[6] - b[3]) ^ 2)
end

--- Passes on the failure of a C call that returns nothing when it succeeds.
function drawing.run(...)
  local _, message, code = ...
  if message then error({ message, code }, 0) end
end

--- Lit surfaces, flat lines.
function drawing.surface(stage, shape, style)
  style = style or {}
  local _, _, b = core.shape_info(shape)
  drawing.grow(stage, b)
  drawing.run(stage.vtk.scene_shape(stage.scene, shape, style.ambient or 0.28, style.diffuse or 0.72,
    style.specular or 0.12, 1, style.opacity or 1, style.flat or false, false))
end

function drawing.lines(stage, shape, width)
  drawing.run(stage.vtk.scene_shape(stage.scene, shape, 1, 0, 0, width or 1, 1, false, false))
end

--- At most `count` of the points, spread evenly: their mask and their distance.
function drawing.spread(points, bounds, count)
  local n = points.shape[1]
  local spacing = math.max(drawing.diagonal(bounds), 1e-30) / (2 * count ^ (1 / 3))
  for _ = 1, 12 do
    local mask, kept = core.figure_thin(points, spacing, math.huge)
    if kept <= count or n == 0 then return mask, spacing end
    spacing = spacing * 1.12 * math.min(1.6, (kept / count) ^ (1 / 3))
  end
  return core.figure_thin(points, spacing, count), spacing
end

--- n times the number x.
function drawing.constant(n, x)
  local a, list = core.array_zeros({ n }, "double"), {}
  for i = 1, n do list[i] = x end
  core.array_fill(a, list)
  return a
end

return drawing
