--- Grids as .vtu files, for ParaView: cells with level and error, points with what pictures show and their irradiance.

local check = require "ylm.check"
local core = require "ylm.c.core"
local quantities = require "ylm.grid.quantities"
local sh = require "ylm.sh"

local vtu = {}

--- Options of files.
vtu.options = {
  { "coefficients", "boolean", default = false,
    about = ".vtu, .pvtu: also all coefficients of points, channel by channel: (lmax+1)^2 numbers each" },
}

--- Name and normal of the surfaces whose irradiance is in files, in their order.
local normals = { { "+x", { 1, 0, 0 } }, { "-x", { -1, 0, 0 } }, { "+y", { 0, 1, 0 } }, { "-y", { 0, -1, 0 } },
  { "+z", { 0, 0, 1 } }, { "-z", { 0, 0, -1 } } }

--- Leaves that have all eight corners: a mask. but(level, origin): those that are left out.
local function complete(cells, but)
  local corner = core.array_totable(cells.corner)
  local leaf, list = core.array_totable(cells.leaf), {}
  for i = 1, #leaf do
    list[i] = leaf[i] ~= 0 and 1 or 0
    for k = 1, 8 do if corner[i][k] < 1 then list[i] = 0 end end
    if but and list[i] == 1 and but(cells.level[i], core.array_totable(cells.origin[i])) then list[i] = 0 end
  end
  local mask = core.array_zeros({ #list }, "double")
  core.array_fill(mask, list)
  return mask
end

--- How each point came to its numbers: 0 evaluated, 1 interpolated for continuity, 2 in a light, filled from neighbours, 3 a
-- ghost of a grid with sides.
local function states(source)
  local interpolated, invalid = core.array_totable(source.values "interpolated"), core.array_totable(source.values "invalid")
  local ghost, list = source.ghost(), {}
  ghost = ghost and core.array_totable(ghost)
  for i = 1, #invalid do
    list[i] = interpolated[i] ~= 0 and 1 or invalid[i] ~= 0 and 2 or ghost and ghost[i] ~= 0 and 3 or 0
  end
  local state = core.array_zeros({ #list }, "float")
  core.array_fill(state, list)
  return state
end

--- Appends the irradiance of points by six normals, [n][channels] each, and where it is wanted all coefficients.
local function add_light(list, value, o)
  for _, n in ipairs(normals) do list[#list + 1] = { "irradiance " .. n[1], (sh.irradiance(value, n[2])) } end
  if o.coefficients then list[#list + 1] = { "coefficients", value } end
end

--- The leaves of a grid, but those for which but(level, origin), as files have them: points, corners, numbers of both.
local function leaves(grid, o, but)
  local source = quantities.open(grid)
  local mask = complete(source.cells, but)
  local function cells(a) return core.figure_pick(a, mask) end
  local point_data = {
    { "L00", source.values "L00" }, { "gradient L00", source.gradient() },
    { "lambda", source.values "lambda" }, { "norm", source.values "norm" }, { "state", states(source) },
  }
  add_light(point_data, source.coefficients_of_channels(), o)
  local cell_data = { { "level", cells(source.cells.level) }, { "error", cells(source.values "error") },
    { "occupied", cells(source.cells.occupied) } }
  local parts = source.values "parts"
  if parts then cell_data[#cell_data + 1] = { "parts", cells(parts) } end
  return source.position(), cells(source.cells.corner), point_data, cell_data
end

--- Writes the leaves of a grid. Returns true, or nil, message, code.
function vtu.save(grid, path, o) return check.result("save", core.figure_save_cells(path, leaves(grid, o))) end

--- Adds the leaves of a grid, but those for which but(level, origin), to a file of pieces. True, or nil, message, code.
function vtu.add(pieces, grid, o, but) return check.result("save", core.figure_pieces_add(pieces, leaves(grid, o, but))) end

return vtu
