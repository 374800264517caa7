--- The layers of a view that show fields: volumes, slices, isosurfaces, cells, arrows, streamlines.

local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local numbers = require "ylm.view.numbers"
local quantities = require "ylm.grid.quantities"

local axis_number = { x = 1, y = 2, z = 3 }

local fill = {}

function fill.volume(stage, v)
  local o, b = drawing.options(v.volume), numbers.bounds(v)
  if v.lattice and not (o.density or o.smooth or not (v.slices or v.isosurfaces)) then return end
  local volume = v.lattice and v.lattice.volume or numbers.sampled(v, b, numbers.voxels(b, v.resolution))
  local density, list = o.density or 1, {}
  for i = 0, 255 do list[i + 1] = { math.max(0, (i - 1) / 254) } end
  local at = core.array_zeros({ 256, 1 }, "double")
  core.array_fill(at, list)
  local rgb = core.array_totable(core.figure_colours(at, { 0, 0, 0 }, v.scale.map, 0, 1, false))
  for i = 1, 256 do
    local t = list[i][1]
    rgb[i][4] = math.min(1, density * (0.006 + 0.5 * t ^ 2.2))
  end
  local table4 = core.array_zeros({ 256, 4 }, "double")
  core.array_fill(table4, rgb)
  local smooth = o.smooth
  if smooth == nil then smooth = numbers.pointwise(v) and true or false end
  drawing.run(stage.vtk.scene_volume(stage.scene, volume, table4, drawing.diagonal(b) / 40, smooth, numbers.scale_of(v.scale)))
  drawing.grow(stage, b)
end

--- Where along axis `a` most of what a grid holds is: the median of its occupied leaves' middles.
local function median_place(v, a)
  local b = numbers.bounds(v)
  if not v.source then return (b[a] + b[a + 3]) / 2 end
  local cells = v.source.cells
  local drawn = numbers.both(cells.leaf, cells.occupied)
  local origin, size = core.figure_pick(cells.origin, drawn), core.figure_pick(cells.size, drawn)
  local n = origin.shape[1]
  if n == 0 then return (b[a] + b[a + 3]) / 2 end
  local middles = {}
  for i = 1, n do middles[i] = core.array_get(origin, i, a) + core.array_get(size, i, a) / 2 end
  table.sort(middles)
  return middles[math.ceil(n / 2)]
end

function fill.slices(stage, v)
  local b = numbers.bounds(v)
  for _, slice in ipairs(type(v.slices) == "table" and v.slices or { { axis = "y" } }) do
    local a = axis_number[slice.axis]
    local flat = { b[1], b[2], b[3], b[4], b[5], b[6] }
    local at = slice.at or median_place(v, a)
    if at < b[a] or at > b[a + 3] then
      error({ ("slices: %s = %g is outside of the bounds, %g to %g"):format(slice.axis, at, b[a], b[a + 3]),
        "ERANGE" }, 0)
    end
    flat[a], flat[a + 3] = at, at
    local size = numbers.voxels(flat, 512)
    size[a] = 1
    local smooth = numbers.pointwise(v) and true or false
    drawing.run(stage.vtk.scene_slice(stage.scene, numbers.sampled(v, flat, size), slice.opacity or 1, smooth,
      numbers.scale_of(v.scale)))
    drawing.grow(stage, flat)
  end
end

function fill.isosurfaces(stage, v)
  local b = numbers.bounds(v)
  if v.quantity == "parts" then
    error({ "isosurfaces: numbers of parts have no order; slices or volume show them", "EINVAL" }, 0)
  end
  local volume = v.lattice and v.lattice.volume or numbers.sampled(v, b, numbers.voxels(b, v.resolution))
  if not numbers.pointwise(v) then drawing.run(core.volume_smooth(volume, 2)) end
  local wanted, values = v.isosurfaces, {}
  if type(wanted) == "table" then values = wanted
  else
    local n, lo, hi = wanted == true and 3 or wanted, v.scale.range[1], v.scale.range[2]
    for i = 1, n do
      local t = (i - 0.35) / (n + 0.3)
      values[i] = v.scale.log and lo * (hi / lo) ^ t or lo + (hi - lo) * t
    end
  end
  local n, list = #values, {}
  local at = core.array_zeros({ n }, "double")
  core.array_fill(at, values)
  local rgb = core.array_totable(core.figure_colours(at, { 0.5, 0.5, 0.5 }, numbers.scale_of(v.scale)))
  for i = 1, n do
    local opacity = n == 1 and 1 or 0.35 + 0.65 * (i - 1) / (n - 1)
    list[i] = { rgb[i][1], rgb[i][2], rgb[i][3], opacity }
  end
  local colours = core.array_zeros({ n, 4 }, "double")
  core.array_fill(colours, list)
  drawing.run(stage.vtk.scene_isosurfaces(stage.scene, volume, at, colours))
  drawing.grow(stage, b)
end

--- Colours [levels][4] of the edges of cells, by level.
local function level_colours(v, theme, opacity)
  local list, by_level = {}, v.quantity == "level" and v.scale
  local _, deepest = core.figure_range(v.source.cells.level)
  for l = 0, deepest do list[l + 1] = { l } end
  local at = core.array_zeros({ #list, 1 }, "double")
  core.array_fill(at, list)
  local rgb = by_level and core.array_totable(core.figure_colours(at, theme.text, numbers.scale_of(v.scale)))
  for l = 0, deepest do
    local c = rgb and rgb[l + 1] or theme.text
    -- Fine cells are many: their edges are fainter.
    local alpha = opacity * (by_level and 1 or math.max(0.06, 0.5 * 0.66 ^ l))
    list[l + 1] = { c[1], c[2], c[3], math.min(1, alpha) }
  end
  local colours = core.array_zeros({ #list, 4 }, "double")
  core.array_fill(colours, list)
  return colours
end

local function chosen_cells(v, o)
  local drawn = v.source.cells.leaf
  if o.occupied then drawn = numbers.both(drawn, v.source.cells.occupied) end
  if o.from then
    local level, list = core.array_totable(v.source.cells.level), core.array_totable(drawn)
    for i = 1, #list do if level[i] < o.from then list[i] = 0 end end
    drawn = core.array_zeros({ #list }, "double")
    core.array_fill(drawn, list)
  end
  return drawn
end

function fill.levels(stage, v)
  local o = drawing.options(v.levels)
  local shape = core.shape(2)
  drawing.run(core.shape_edges(shape, level_colours(v, stage.theme, o.opacity or 1),
    numbers.cells_args(v.source, chosen_cells(v, o))))
  drawing.lines(stage, shape, o.width or 1)
end

function fill.boxes(stage, v)
  local o = drawing.options(v.boxes)
  local values = v.values
  if quantities.of[v.quantity].of ~= "cells" then
    error({ "boxes show a quantity of cells: error, level or residual", "EINVAL" }, 0)
  end
  local drawn = chosen_cells(v, o)
  local colours = core.figure_colours(values, stage.theme.dim, numbers.scale_of(v.scale))
  local shape = core.shape(3)
  drawing.run(core.shape_boxes(shape, colours, o.shrink or 0.12, o.opacity or 1, numbers.cells_args(v.source, drawn)))
  drawing.surface(stage, shape)
end

function fill.glyphs(stage, v)
  local o = drawing.options(v.glyphs)
  local shape = core.shape(3)
  local at, along, spacing
  if v.arrows then at, along = v.arrows.at, v.arrows.along
  else
    local position = v.source.position()
    local mask
    mask, spacing = drawing.spread(position, v.source.bounds, o.count or 1500, v.source.ghost())
    at, along = core.figure_pick(position, mask), core.figure_pick(v.gradient, mask)
  end
  local lengths = core.figure_lengths(along)
  local colours = core.figure_colours(lengths, stage.theme.dim, numbers.scale_of(v.vector_scale))
  if spacing then
    -- Lengths between a third and the whole of the distance of neighbours: directions stay legible.
    local list, lo, hi = core.array_totable(lengths), v.vector_scale.range[1], v.vector_scale.range[2]
    for i, x in ipairs(list) do
      local t = v.vector_scale.log and math.log(math.max(x, lo) / lo) / math.log(hi / lo) or (x - lo) / (hi - lo)
      t = math.max(0, math.min(1, t))
      list[i] = x > 0 and (o.length or 1) * spacing * (0.35 + 0.75 * t) / x or 0
    end
    local factor = core.array_zeros({ #list }, "double")
    core.array_fill(factor, list)
    along = core.figure_scaled(along, factor)
  end
  drawing.run(core.shape_arrows(shape, at, along, colours))
  drawing.surface(stage, shape, { ambient = 0.45, diffuse = 0.65, specular = 0.05 })
end

--- Seeds on a lattice of about `count` points inside the bounds, jittered always the same way.
local function seeds(b, count)
  local step = ((b[4] - b[1]) * (b[5] - b[2]) * (b[6] - b[3]) / count) ^ (1 / 3)
  local list, state = {}, 12345
  local function jitter()
    state = (state * 16807) % 2147483647
    return state / 2147483647 - 0.5
  end
  local n = {}
  for a = 1, 3 do n[a] = math.max(1, math.floor((b[a + 3] - b[a]) / step + 0.5)) end
  for z = 1, n[3] do for y = 1, n[2] do for x = 1, n[1] do
    local i, p = { x, y, z }, {}
    for a = 1, 3 do p[a] = b[a] + (i[a] - 0.5 + 0.8 * jitter()) / n[a] * (b[a + 3] - b[a]) end
    list[#list + 1] = p
  end end end
  local out = core.array_zeros({ #list, 3 }, "double")
  core.array_fill(out, list)
  return out
end

function fill.streamlines(stage, v)
  local o = drawing.options(v.streamlines)
  local b = v.flow and v.flow.bounds or v.source.bounds
  local volume
  if v.flow then
    volume = assert(core.volume(b, v.flow.size, 3))
    drawing.run(core.volume_set(volume, v.flow.values))
  else
    volume = assert(core.volume(b, numbers.voxels(b, v.resolution), 3))
    numbers.fill(volume, v, v.gradient, true)
  end
  local shape, reach = core.shape(3), drawing.diagonal(b)
  drawing.run(core.shape_streamlines(shape, volume, { seeds = seeds(b, o.count or 150), step = reach / 400, room = 600,
    fewest = 12, radius = reach * 0.0016 * (o.width or 1) }, numbers.scale_of(v.vector_scale)))
  drawing.surface(stage, shape, { ambient = 0.45, diffuse = 0.65, specular = 0.05 })
end

return fill
