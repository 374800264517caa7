--- Files of grids: grid:save, and what ylm.load uses.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"

local grid_file = {}

local methods, open = grid_object.methods, grid_object.open

describe "grid:save" {
  about = "Writes the grid; the ending chooses the format. An existing file is replaced whole or not at all. Equal grids "
    .. "are equal bytes: times are not in the file.",
  arguments = {
    { "path", "string", ".ylm (everything, checksummed; ylm.load reads it), .vtu (for ParaView)" },
  },
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending; nil, message, code where the file cannot be written",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 } }
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, lamp)
local name = os.tmpname() .. ".ylm"
assert(grid:save(name))
os.remove(name)]],
}
function methods.save(g, path, given)
  open(g, "save")
  if type(path) ~= "string" or path == "" or path:find("%z") then
    return check.bad(1, "save", "a path expected, got %s", check.describe(path))
  end
  if given ~= nil then form.options(2, "save", {}, given) end
  local ending = path:lower():match("%.(%w+)$")
  if ending == "ylm" then return check.result("save", core.grid_write(g, path)) end
  if ending == "vtu" then return require "ylm.grid.vtu".save(g, path) end
  return check.bad(1, "save", "a path ending in .ylm or .vtu expected, got %s", check.describe(path))
end

--- The first bytes of a grid file.
grid_file.magic = "\137YLMgrid"

--- A grid from a file: nil, message, code where it cannot be read.
function grid_file.load(path)
  return check.result("load", core.grid_read(path))
end

--- The contents of a grid file without its rows: { version, bytes, form, stats, sections }, where form has the fields
-- of a grid and a section { name, offset, bytes, record, required, known }; nil, message, code.
function grid_file.look(path)
  return check.result("info", core.grid_file_look(path))
end

return grid_file
