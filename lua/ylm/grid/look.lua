--- Looking inside of a grid: grid:points, grid:cells, grid:locate.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"

local methods, open = grid_object.methods, grid_object.open

describe "grid:points" {
  shelf = "everyday",
  about = "Everything that the grid keeps at its points, as arrays: evaluated points first, then those that only "
    .. "continuity needs.",
  arguments = {},
  returns = { { "points", "table", "position [n][3], value [n][channels][count], gradient [n][channels][count][3], "
    .. "lambda [n], norm [n], invalid [n] (1: in a light or a body, filled from neighbours), validity [n] (1 less the share of "
    .. "directions that see sides of surfaces that are not used, below 0.5 in a body; of a field that knows of no bodies "
    .. "1, in lights 0), interpolated [n]; of a grid with sides ghost [n] (1: stands for a corner that its parts do not see)" } },
  errors = "raises on a closed grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local points = grid:points()
assert(#points.position == 27 and points.value.shape[3] == 4)]],
}
function methods.points(g)
  return core.grid_points(open(g, "points"))
end

local cells_options = {
  { "added", "boolean", default = false, about = "also the cells that only continuity needs, after the others" },
}

describe "grid:cells" {
  shelf = "everyday",
  about = "The voxels as arrays: parents before children, eight children in a row.",
  arguments = { { "options?", "table", "see the options" } },
  options = cells_options,
  returns = { { "cells", "table", "origin [n][3], size [n][3], level [n] (0 is the root), error [n] (the metric; NaN "
    .. "where unknown), residual [n] (relative error measured at the centre; NaN where not), leaf [n], occupied [n], "
    .. "baked [n], crossed [n] (by a light's surface, in a grid with sides by any), added [n], corners [n][8] (rows of "
    .. "points(); 0: none); of a grid with sides parts [n], of leaves that surfaces cross" } },
  errors = "raises on a closed grid",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
assert(#grid:cells().origin == 8 and grid.resolution[1] == 2)]],
}
function methods.cells(g, given)
  open(g, "cells")
  local o = form.options(1, "cells", cells_options, given)
  return core.grid_cells(g, o.added)
end

describe "grid:locate" {
  about = "The cell that holds a point, with everything it knows. Cells are half-open, the last ones closed.",
  arguments = { { "p", "table|array", "{x, y, z}, scene units" } },
  returns = { { "cell", "table",
    "index (a row of cells()), origin, size, level, error, residual, leaf, occupied, baked, "
    .. "crossed, outside (p is outside of the bounds: the cell of the nearest point inside), corners (rows of "
    .. "points()); nil where a uniform grid has no data" } },
  errors = "raises on what is not a point",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local cell = grid:locate { 0.5, 0.5, 0.5 }
assert(cell.index == 8 and cell.origin[1] == 0 and not cell.outside)]],
}
function methods.locate(g, p)
  open(g, "locate")
  local point, wanted = form.types.point(p)
  if not point then return check.bad(1, "locate", "%s expected, got %s", wanted, check.describe(p)) end
  return core.grid_locate(g, point[1], point[2], point[3], false)
end
