--- Tools that the layers of a view draw with: surfaces, lines, bounds; failures passed on.

local box = require "ylm.box"
local core = require "ylm.c.core"

local drawing = {}

--- A layer's own table; empty where it is only asked for by `true`.
function drawing.options(value) return type(value) == "table" and value or {} end

--- Takes box b into the bounds of what is drawn.
local function enlarge(stage, b)
  local all = stage.bounds
  if not all then
    stage.bounds = { b[1], b[2], b[3], b[4], b[5], b[6] }
    return
  end
  for a = 1, 3 do all[a], all[a + 3] = math.min(all[a], b[a]), math.max(all[a + 3], b[a + 3]) end
end

--- Takes box b into what the camera is to see.
function drawing.grow(stage, b)
  stage.boxes[#stage.boxes + 1] = b
  enlarge(stage, b)
end

--- Takes a shape into what the camera is to see.
local function grow_shape(stage, shape)
  local _, _, b = core.shape_info(shape)
  if not b then return end
  stage.shapes[#stage.shapes + 1] = shape
  enlarge(stage, b)
end

--- For each direction the largest product with a point of what the camera is to see.
function drawing.reach(stage, directions)
  local rows, message, code = core.array_zeros({ #directions, 3 }, "double")
  drawing.run(rows, message, code)
  core.array_fill(rows, directions)
  local most = {}
  local boxes = #stage.boxes + #stage.shapes > 0 and stage.boxes or { { -1, -1, -1, 1, 1, 1 } }
  for k, d in ipairs(directions) do
    most[k] = -math.huge
    for _, b in ipairs(boxes) do
      local sum = 0
      for a = 1, 3 do sum = sum + math.max(d[a] * b[a], d[a] * b[a + 3]) end
      most[k] = math.max(most[k], sum)
    end
  end
  for _, shape in ipairs(stage.shapes) do
    local reach, failed, status = core.shape_reach(shape, rows)
    drawing.run(reach, failed, status)
    for k, x in ipairs(reach) do most[k] = math.max(most[k], x) end
  end
  return most
end

--- The length of a box's diagonal.
function drawing.diagonal(b)
  return box.diagonal(b, { b[4], b[5], b[6] })
end

--- Passes on the failure of a C call that returns nothing when it succeeds.
function drawing.run(...)
  local _, message, code = ...
  if message then error({ message, code }, 0) end
end

--- Lit surfaces, flat lines.
function drawing.surface(stage, shape, style)
  style = style or {}
  grow_shape(stage, shape)
  drawing.run(stage.vtk.scene_shape(stage.scene, shape, { ambient = style.ambient or 0.28, diffuse = style.diffuse or 0.72,
    specular = style.specular or 0.12, line_width = 1, opacity = style.opacity or 1, flat = style.flat }))
end

function drawing.lines(stage, shape, width)
  grow_shape(stage, shape)
  drawing.run(stage.vtk.scene_shape(stage.scene, shape, { ambient = 1, diffuse = 0, specular = 0, line_width = width or 1,
    opacity = 1 }))
end

--- At most `count` of points, spread evenly: their mask and their distance.
local function thinned(points, bounds, count)
  local n = points.shape[1]
  local spacing = math.max(drawing.diagonal(bounds), 1e-30) / (2 * count ^ (1 / 3))
  for _ = 1, 12 do
    local mask, kept = core.figure_thin(points, spacing, math.huge)
    if kept <= count or n == 0 then return mask, spacing end
    spacing = spacing * 1.12 * math.min(1.6, (kept / count) ^ (1 / 3))
  end
  return core.figure_thin(points, spacing, count), spacing
end

--- The mask [n] of what is 0 in `without`; with `kept`, of that what is in a mask of these alone.
local function mask_without(without, kept)
  local list, other, k = core.array_totable(without), kept and core.array_totable(kept), 0
  for i, x in ipairs(list) do
    local there = x == 0
    if there then k = k + 1 end
    list[i] = there and (not other or other[k] ~= 0) and 1 or 0
  end
  local mask = core.array_zeros({ #list }, "double")
  core.array_fill(mask, list)
  return mask
end

--- At most `count` of the points, of those that are no ghosts where there is such a mask, spread evenly: their mask and their
-- distance.
function drawing.spread(points, bounds, count, ghost)
  if not ghost then return thinned(points, bounds, count) end
  local mask, spacing = thinned(core.figure_pick(points, mask_without(ghost)), bounds, count)
  return mask_without(ghost, mask), spacing
end

--- n times the number x.
function drawing.constant(n, x)
  local a, list = core.array_zeros({ n }, "double"), {}
  for i = 1, n do list[i] = x end
  core.array_fill(a, list)
  return a
end

return drawing
