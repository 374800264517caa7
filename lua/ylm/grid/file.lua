--- Files of grids: grid:save, and what ylm.load uses.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local grid_object = require "ylm.grid.object"
local library = require "ylm.library"
local small = require "ylm.grid.small"
local vtu = require "ylm.grid.vtu"

local grid_file = {}

--- Options of pages, lua/ylm/page.
grid_file.page_options = {
  { "scene", "any", optional = true, about = ".html: the scene whose geometry, lamps and camera the page shows" },
  { "light", "any", optional = true, about = ".html, with scene: a grid of the scene's light (scene:bake, "
    .. "quantity = 'all'), which the page shows at first, in at most 64 KiB as .ylmp has it" },
  { "title", "string", optional = true, about = ".html: default the scene's name" },
  { "precision", "choice", of = core.choices "precision", optional = true,
    about = ".html: of the numbers at probes; 'few' (default, but of grids that follow lights): rounded and "
      .. "counted, as .ylm of few bytes, a fifteenth of the size or less; else 'half' (default), 'float', or 'byte': slopes "
      .. "in bytes, 0.63 of the size" },
  small.options[1],
  { "exposure", "number", min = -20, max = 20, default = 0, unit = "stops", about = ".html: at first" },
  { "tone", "choice", of = core.choices "tone", default = "srgb", about = ".html: tone curve at first" },
  { "lamps", "boolean", default = true, about = ".html: whether the page has the scene's sphere lights" },
  { "poster", "any", optional = true,
    about = ".html: an image that is seen where the page cannot be drawn; default: rendered from the scene's camera; "
      .. "false: none" },
  { "size", "image_size", default = { 960, 540 }, unit = "pixels", about = ".html: of the poster that is rendered" },
  { "dering", "dering", optional = true,
    about = ".html: window against light below zero, as of scene:render, chosen from the scene's camera; false: none" },
  { "limit", "number", above = 0, default = 32e6, unit = "bytes", about = ".html: of the file; a larger one is refused" },
  form.threads,
}

local ylm_options = {}
for _, field in ipairs(small.options) do ylm_options[#ylm_options + 1] = field end
for _, field in ipairs { form.threads, form.progress } do ylm_options[#ylm_options + 1] = field end

local save_options = { vtu.options[1] }
for _, field in ipairs(small.options) do save_options[#save_options + 1] = field end
for _, field in ipairs(grid_file.page_options) do
  if field ~= small.options[1] then save_options[#save_options + 1] = field end
end

local methods, open = grid_object.methods, grid_object.open

describe "grid:save" {
  shelf = "everyday",
  about = "Writes the grid; the ending chooses the format. An existing file is replaced whole or not at all. Equal grids "
    .. "are equal bytes: times are not in the file. With tolerance, bytes or step a .ylm file takes few bytes, and is measured "
    .. "as it will be decoded (docs/grids.md); without, it has all numbers as they are.",
  arguments = {
    { "path", "string", ".ylm (everything, checksummed; ylm.load reads it), .vtu (for ParaView: of points also the irradiance by "
      .. "six normals, one array each), .html (a page that browsers "
      .. "show without a network: docs/page.md)" },
    { "options?", "table", "of .html, .vtu and .ylm" },
  },
  options = save_options,
  returns = { { "ok", "boolean", "true" }, { "report", "table", ".ylm of few bytes: bytes, points, bytes_per_point, error in all "
    .. "with its confidence, before: the grid's own error, rounding (99 %), largest, median, places: looked at, judged: "
    .. "whether these are the bake's own held-out ones, else error is the sum of before and largest; step; "
    .. "sections: bytes by name. .html: bytes of the file, poster, sections: bytes by name, triangles, warnings: what the page "
    .. "does not show, dering as of scene:render; few: of precision 'few' the report of few bytes; light: of light bytes, error "
    .. "and rms at surfaces, as grid:export of .ylmp" } },
  errors = "raises on another ending and bad options; nil, message, code where the file cannot be written, and of .html 'ELIMIT' "
    .. "where it would be too large, 'EDOMAIN' where a number of the grid is not finite; of few bytes 'ELIMIT' where the "
    .. "grid itself errs by more than the tolerance, or bytes are too few; nothing is written then",
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
  local ending = path:lower():match("%.(%w+)$")
  if ending == "html" then return library.later["ylm.page"](g, path, given) end
  if ending == "vtu" then return vtu.save(g, path, form.options(2, "save", vtu.options, given)) end
  local o = form.options(2, "save", ending == "ylm" and ylm_options or {}, given)
  if ending == "ylm" then
    if small.is_asked(2, "save", o) then return small.save("save", g, path, o) end
    local few = small.file_of(g)
    if few then return check.result("save", core.file_save(path, few)) end
    return check.result("save", core.grid_write(g, path))
  end
  return check.bad(1, "save", "a path ending in .ylm, .vtu or .html expected, got %s", check.describe(path))
end

--- The first bytes of a grid file.
grid_file.magic = "\137YLMgrid"

--- A grid from a file: nil, message, code where it cannot be read.
function grid_file.load(path)
  local g, message, code = check.result("load", core.grid_read(path))
  if not g then return nil, message, code end
  core.own(g).path = path
  return g
end

--- The contents of a grid file without its rows: { version, bytes, form, stats, sections, small }, where form has the fields
-- of a grid, a section { name, offset, bytes, record, required, known }, and small is the report of a file of few bytes; nil,
-- message, code.
function grid_file.look(path)
  return check.result("info", core.grid_file_look(path))
end

return grid_file
