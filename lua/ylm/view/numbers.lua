--- The numbers of a view: what is coloured, its scales, and lattices that carry it.

local charts = require "ylm.view.charts"
local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local quantities = require "ylm.grid.quantities"

local numbers = {}

--- Fills in what the user left open of a scale, from the data's least, largest, least positive.
local function make_scale(v, quantity, defaults, least, largest, positive, takes_fields)
  local own = takes_fields and v or {}
  local scale = { quantity = quantity, map = own.map or defaults.map, log = defaults.log, whole = defaults.whole }
  if own.log_given ~= nil then scale.log = own.log_given end
  if scale.log and not (own.range and own.range[1] > 0) and not positive then scale.log = false end
  local label, unit = own.label or defaults.label or "", own.unit or (not own.label and defaults.unit) or nil
  scale.label, scale.unit = label, unit
  if own.range then scale.range = { own.range[1], own.range[2] }
  else
    least, largest = least or 0, largest or 1
    if scale.log then least = math.max(positive, largest * 1e-4) end
    if largest <= least then
      largest = scale.log and least * 10 or least + math.max(1, math.abs(least)) * 1e-6
    end
    scale.range = { least, largest }
  end
  if scale.log and scale.range[1] <= 0 then scale.log = false end
  v.scales[#v.scales + 1] = scale
  return scale
end

--- A scale as C takes it: colour map, least, largest, logarithmic?
function numbers.scale_of(scale) return scale.map, scale.range[1], scale.range[2], scale.log end

--- Cells of a grid that colours show: leaves, or those of `drawn`. With corners: all of them, parents first, so that
-- a leaf without data shows its nearest ancestor's, as sampling does.
function numbers.cells_args(source, drawn, with_corners)
  local c = source.cells
  if with_corners then return c.origin, c.size, c.level, drawn, c.corner end
  return c.origin, c.size, c.level, drawn or c.leaf
end

--- The mask of what is in mask a and in mask b.
function numbers.both(a, b)
  local n = a.shape[1]
  local product = core.figure_mix(a, n, { 0 }, { 1 }, 1)
  local list, other = core.array_totable(product), core.array_totable(b)
  for i = 1, n do list[i] = (list[i][1] ~= 0 and other[i] ~= 0) and 1 or 0 end
  local mask = core.array_zeros({ n }, "double")
  core.array_fill(mask, list)
  return mask
end

--- Computes the view's numbers and scales once. Returns true, or nil, message, code.
function numbers.prepare(v)
  if v.scales then return true end
  v.scales = {}
  if v.subject then v.source = quantities.open(v.subject) end
  local coloured = v.volume or v.slices or v.boxes or v.isosurfaces or (v.levels and v.quantity == "level")
  if v.lattice then
    local l = v.lattice
    local volume, message, code = core.volume(l.bounds, l.size, 1)
    if not volume then return nil, message, code end
    core.volume_set(volume, l.values)
    l.volume = volume
    local least, largest, positive = core.volume_range(volume)
    v.scale = make_scale(v, "values", { map = "viridis", log = false }, least, largest, positive, true)
  elseif v.source and coloured then
    v.values = v.source.values(v.quantity)
    local q = quantities.of[v.quantity]
    if not v.values then
      return nil, ("quantity: parts are of a grid with sides, this one of '%s' light has none"):format(v.subject.quantity),
        "EINVAL"
    end
    local of = q.of ~= "points" and core.figure_pick(v.values, v.source.cells.leaf) or v.values
    local least, largest, positive = core.figure_range(of)
    if q.of == "pieces" then least = largest and largest > 0 and 1 or nil end
    if not least then
      return nil, ("the grid holds no '%s' anywhere"):format(v.quantity), "EFORMAT"
    end
    local label, unit = v.source.words(v.quantity)
    v.scale = make_scale(v, v.quantity, { map = q.map, log = q.log, whole = q.whole, label = label,
      unit = unit }, least, largest,
      positive, true)
  end
  if v.charts and v.charts ~= "number" then
    local values, least, most, words = charts.numbers(v)
    v.charts_values = values
    v.charts_scale = make_scale(v, v.charts, words, least, most, least, not v.scale)
  end
  if v.glyphs or v.streamlines then
    local lengths
    if v.arrows then lengths = core.figure_lengths(v.arrows.along)
    elseif v.flow then
      local n = v.flow.size[1] * v.flow.size[2] * v.flow.size[3]
      lengths = core.figure_lengths(core.array_reshape(core.array_convert(v.flow.values, "double"), { n, 3 }))
    else
      v.gradient = v.source.gradient()
      lengths = core.figure_lengths(v.gradient)
    end
    local q = quantities.of.gradient
    local given = v.arrows or v.flow
    local least, largest, positive = core.figure_range(lengths)
    -- A few arrows beside lamps must not decide the colours of all others.
    if not given and positive then
      positive, largest = core.figure_quantiles(lengths, 0.02, 0.99)
      least = positive
    end
    v.vector_scale = make_scale(v, "gradient", { map = q.map, log = q.log and not given, label = not given
      and q.label or "",
      unit = not given and q.unit or nil }, least, largest, positive, not v.scale)
  end
  return true
end

--- Voxels along each axis, `most` along the longest.
function numbers.voxels(b, most)
  local longest, size = math.max(b[4] - b[1], b[5] - b[2], b[6] - b[3]), {}
  for a = 1, 3 do size[a] = math.max(1, math.floor((b[a + 3] - b[a]) / longest * most + 0.5)) end
  return size
end

--- Fills a volume from values of a grid's cells, or of its points: those of a leaf with sides part by part.
function numbers.fill(volume, v, values, pointwise)
  drawing.run(core.volume_fill(volume, values, pointwise, numbers.cells_args(v.source, nil, pointwise)))
  if pointwise and v.subject.sides then drawing.run(core.volume_fill_parts(volume, v.subject, values)) end
end

--- The quantity on a lattice that fills `b`.
function numbers.sampled(v, b, size)
  local volume = assert(core.volume(b, size, 1))
  if v.lattice then drawing.run(core.volume_resample(volume, v.lattice.volume))
  else
    local of = quantities.of[v.quantity].of
    if of == "pieces" then drawing.run(core.volume_fill_parts(volume, v.subject))
    else numbers.fill(volume, v, v.values, of == "points") end
  end
  return volume
end

--- Is what colours show known at points, not of cells?
function numbers.pointwise(v) return v.lattice or quantities.of[v.quantity].of == "points" end

--- The bounds of the grid or the lattice that is shown; nil without either.
function numbers.bounds(v) return v.source and v.source.bounds or v.lattice and v.lattice.bounds end

return numbers
