--- Numbers of a grid as pictures need them: cells, corner points, quantities.

local array = require "ylm.array"
local core = require "ylm.c.core"

local quantities = {}

--- Quantity -> label, unit, colour map, whether its range spans decades; and of what it is: cells, pieces of them, or points.
quantities.of = {
  error = { label = "estimated error", map = "magma", log = true, of = "cells" },
  level = { label = "level", map = "viridis", log = false, whole = true, of = "cells" },
  residual = { label = "measured relative error", map = "magma", log = true, of = "cells" },
  parts = { label = "part of a crossed leaf", map = "viridis", log = false, whole = true, of = "pieces" },
  norm = { label = "‖L‖", unit = "W m⁻² sr⁻¹ᐟ²", map = "viridis", log = true, of = "points" },
  lambda = { label = "‖λ‖", unit = "W m⁻² sr⁻¹ᐟ² per length²", map = "magma", log = true, of = "points" },
  L00 = { label = "L₀₀", unit = "W m⁻² sr⁻¹ᐟ²", map = "viridis", log = true, of = "points" },
  gradient = { label = "|∇L₀₀|", unit = "W m⁻² sr⁻¹ᐟ² per length", map = "viridis", log = true,
    of = "points" },
}
quantities.names = { "error", "level", "residual", "parts", "norm", "lambda", "L00", "gradient" }

local function doubles(a)
  if not a then return nil end
  if a.dtype == "double" then return a end
  return array.array(a, "double")
end

--- Luminance of a column of coefficient arrays: pieces of `width` numbers at coefficient 1 of each channel.
local function luminance(a, width)
  local shape = a.shape
  local n, channels, count = shape[1], shape[2], shape[3]
  local per_channel = count * width
  if channels == 1 then return core.figure_mix(a, n, { 0 }, { 1 }, width) end
  return core.figure_mix(a, n, { 0, per_channel, 2 * per_channel }, core.luminance, width)
end

--- The part of a grid that pictures are made of; arrays are fetched once, when first asked for.
function quantities.open(grid)
  local source, points = { grid = grid }, nil
  local cells = grid:cells()
  local leaf = doubles(cells.leaf)
  source.cells = {
    origin = doubles(cells.origin), size = doubles(cells.size), level = doubles(cells.level),
    leaf = leaf, occupied = doubles(cells.occupied), corner = doubles(cells.corners),
  }
  local function point(name)
    points = points or grid:points()
    return points[name]
  end

  --- The mask [n] of ghosts, of a grid with sides.
  function source.ghost() return doubles(point "ghost") end
  function source.position() return doubles(point "position") end
  function source.gradient() return luminance(point "gradient", 3) end
  --- Coefficients [n][count] of luminance.
  function source.coefficients()
    local value = point "value"
    local n, channels, count = value.shape[1], value.shape[2], value.shape[3]
    if channels == 1 then return core.figure_mix(value, n, { 0 }, { 1 }, count) end
    return core.figure_mix(value, n, { 0, count, 2 * count }, core.luminance, count)
  end
  --- Coefficients [n][channels][count], float.
  function source.coefficients_of_channels() return point "value" end
  --- [cells] or [points] numbers of a quantity.
  function source.values(quantity)
    if quantity == "error" or quantity == "residual" then return doubles(cells[quantity]) end
    if quantity == "level" then return source.cells.level end
    if quantity == "parts" then return doubles(cells.parts) end
    if quantity == "L00" then return core.array_reshape(luminance(point "value", 1), { point("value").shape[1] }) end
    if quantity == "gradient" then return core.figure_lengths(source.gradient()) end
    return doubles(point(quantity))
  end
  --- The words for a quantity: label, unit.
  function source.words(quantity)
    local q = quantities.of[quantity]
    if quantity == "error" then
      local relative = grid.metric == "relative"
      return relative and "error ‖λ‖Δ²/(2‖L‖)" or "error ‖λ‖Δ²/2", not relative
        and "W m⁻² sr⁻¹ᐟ²" or nil
    end
    return q.label, q.unit
  end

  source.bounds = core.figure_bounds(source.cells.origin, source.cells.size)
  return source
end

return quantities
