--- Pictures of grids, fields, SH vectors and scenes: ylm.view. Nothing opens before save or show.

local bars = require "ylm.picture.bar"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local drawing = require "ylm.view.drawing"
local form = require "ylm.form"
local layers = require "ylm.view.layers"
local memory = require "ylm.memory"
local picture = require "ylm.picture"
local view_camera = require "ylm.view.camera"
local quantities = require "ylm.grid.quantities"
local shown = require "ylm.text".shown
local warning = require "ylm.warning"

local view = {}

-- Drawing --------------------------------------------------------------------------

--- Title and caption on the canvas; what is between them is from l.top to l.bottom.
local function place_words(v, width, height)
  local font, margin = v.font or picture.font(width, height), math.floor(picture.font(width, height) * 1.2)
  local l = { font = font, margin = margin, top = 0, bottom = height }
  if v.title then
    local _, h = picture.text(nil, v.title, 0, 0, { size = math.floor(font * 1.35), bold = true })
    l.title, l.top = margin, margin + h
  end
  if v.caption then
    l.caption_text = picture.wrap(v.caption, width - 2 * margin, { size = font })
    local _, h = picture.text(nil, l.caption_text, 0, 0, { size = font })
    l.caption, l.bottom = height - margin - h, height - margin - h
  end
  return l
end

--- Scalar bars on the right of a window, or nil where they have no room: { window = {x, y, w, h}, rooms, drawn }.
local function bars_beside(v, l, width, height, top, bottom)
  local room = l.bottom - l.top - 2 * l.margin
  local long = math.floor(math.min(room, math.max(height * 0.62, 120)))
  local column = bars.columns(v.scales, l.font, long, l.margin, math.floor(0.45 * width))
  if not column or long < 8 then return nil end
  local x, y, rooms = width - column.width, math.floor(l.top + l.margin + (room - long) / 2), {}
  for i, b in ipairs(column.bars) do
    rooms[i] = { x, y, b.width, long }
    x = x + b.width + l.margin
  end
  return { window = { 0, top, width - column.width - l.margin, bottom - top }, rooms = rooms, bars = column }
end

--- Scalar bars below a window, in a row; nil where there is no room.
local function bars_below(v, l, width, top)
  local row = bars.row(v.scales, l.font, width, l.margin, math.floor(0.4 * (l.bottom - l.top)))
  if not row then return nil end
  local y, rooms, each = l.bottom - row.height, {}, row.each + l.margin
  for i, b in ipairs(row.bars) do
    rooms[i] = { math.floor(l.margin + (i - 1) * each + (row.each - b.width) / 2), y, b.width, b.height }
  end
  return { window = { 0, top, width, y - l.margin - top }, rooms = rooms, bars = row }
end

--- Where things stand on the canvas: the window of the scene with its camera, title, caption, bars. A camera of the
-- user's own sees the whole picture but for the bars; else title and caption are beside the window too, and the bars
-- stand where the larger picture is left.
local function layout(v, stage, width, height)
  local l = place_words(v, width, height)
  local top, bottom = v.camera and 0 or l.top, v.camera and height or l.bottom
  local function reach(directions) return drawing.reach(stage, directions) end
  local choices = {}
  if v.bar and #v.scales > 0 then
    choices = { bars_beside(v, l, width, height, top, bottom) }
    choices[#choices + 1] = bars_below(v, l, width, top)
  end
  if #choices == 0 then choices[1] = { window = { 0, top, width, bottom - top }, rooms = {} } end
  local best
  for i, choice in ipairs(choices) do
    local w = choice.window
    w[3], w[4] = math.max(1, w[3]), math.max(1, w[4])
    choice.camera, choice.scale = v.camera, w[3] * w[4]
    if not v.camera then
      choice.camera, choice.scale = view_camera.choose(reach, w[3], w[4], v.directions, v.up, v.fov)
    end
    if i == 1 or choice.scale > 1.1 * best.scale then best = choice end
  end
  l.window, l.rooms, l.bars, stage.camera = best.window, best.rooms, best.bars, best.camera
  return l
end

--- Words on the picture; where the scene may lie behind them, on a plate of the background's colour.
local function words(v, canvas, text, x, y, style)
  if v.camera then
    local w, h = picture.text(nil, text, 0, 0, style)
    local pad, c = math.floor(style.size * 0.4), v.theme.background
    core.canvas_rectangle(canvas, x - pad, y - pad, w + 2 * pad, h + 2 * pad, { c[1], c[2], c[3], 0.7 })
  end
  picture.text(canvas, text, x, y, style)
end

--- Titles, captions, bars and labels over a drawn scene.
local function annotate(v, canvas, l, without_caption)
  if l.title then
    words(v, canvas, v.title, l.margin, l.title, { size = math.floor(l.font * 1.35), bold = true,
      colour = v.theme.text })
  end
  if l.caption and not without_caption then
    words(v, canvas, l.caption_text, l.margin, l.caption, { size = l.font, colour = v.theme.dim })
  end
  v.drawn_bars, v.drawn_window = {}, l.window
  for i, scale in ipairs(v.bar and v.scales or {}) do
    local room = l.rooms[i]
    v.drawn_bars[i] = { quantity = scale.quantity, label = scale.label, unit = scale.unit,
      range = { scale.range[1], scale.range[2] },
      log = scale.log, map = scale.map, room = room or { 0, 0, 0, 0 },
      box = room and l.bars.draw(canvas, l.bars.bars[i], room[1], room[2], v.theme) or { 0, 0, 0, 0 } }
  end
end

--- Fills a VTK scene with the view's layers and sets its camera for a picture of that size: stage, layout.
local function build(v, vtk, width, height)
  local scene, message, code = vtk.scene()
  if not scene then return nil, message, code end
  local stage = { vtk = vtk, scene = scene, view = v, theme = v.theme }
  local ok, l
  ok, message, code = layers.fill(stage)
  if not ok then return nil, message, code end
  ok, message, code = layers.try(function() l = layout(v, stage, width, height) end)
  if not ok then return nil, message, code end
  local camera = stage.camera
  vtk.scene_camera(scene, camera.from, camera.at, camera.up, camera.fov)
  return stage, l
end

--- Labels beside things in the scene, where the camera shows them.
local function label(stage, canvas, window, font)
  local x, y, width, height = window[1], window[2], window[3], window[4]
  for _, entry in ipairs(stage.labels or {}) do
    local px, py = view_camera.project(stage.camera, width, height, entry.at)
    if px then
      picture.text(canvas, entry.text, math.floor(x + px), math.floor(y + py),
        { size = font, colour = stage.theme.text, align = "middle" })
    end
  end
end

local function draw(v)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local width, height = v.size[1], v.size[2]
  local canvas = assert(core.canvas(width, height, v.theme.background))
  local prepared
  prepared, message, code = layers.prepare(v)
  if not prepared then return nil, message, code end
  local stage, l
  stage, l, code = build(v, vtk, width, height)
  if not stage then return nil, l, code end
  local x, y, w, h = l.window[1], l.window[2], l.window[3], l.window[4]
  local part = (w == width and h == height) and canvas or assert(core.canvas(w, h, v.theme.background))
  local _, failed, status = vtk.scene_render(stage.scene, part, v.supersample, v.theme.background)
  if failed then return nil, failed, status end
  if part ~= canvas then core.canvas_copy(canvas, { x, y, w, h }, part, { 0, 0, w, h }, true) end
  label(stage, canvas, l.window, l.font)
  annotate(v, canvas, l)
  return canvas
end

--- The shapes as a .gltf file; true and what is left out, a sentence each; or nil, message, code.
local function save_shapes(v, path)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local ok
  ok, message, code = layers.prepare(v)
  if not ok then return nil, message, code end
  local stage
  stage, message, code = build(v, vtk, v.size[1], v.size[2])
  if not stage then return nil, message, code end
  ok, message, code = vtk.scene_save(stage.scene, path, v.size[1], v.size[2])
  if not ok then return nil, message, code end
  if not v.volume then return true, {} end
  warning.say(v, "save", "%s lacks the cloud of the picture, which has no surface: slices and isosurfaces have one", shown(path))
  return true, { "clouds have no surface, left out: 1" }
end

local methods = picture.methods("view", draw,
  'ylm.view { sh = { { 0, 0, 1, 0 } }, size = { 80, 60 }, supersample = 1 }',
  { endings = { "gltf" }, save = save_shapes, returns = ", and of .gltf a list of sentences: what is left out",
    about = "its triangles, lines and slices with the camera as a .gltf file, without words, bars and clouds." })

describe "view:bars" {
  about = "The scalar bars of the last picture drawn: what they show and where.",
  arguments = {},
  returns = { { "bars", "table", "a list of { quantity, label, unit, range = {least, largest}, log, map, "
    .. "box = {x, y, w, h} of the colours, room of all of the bar }, pixels from the top left; none of the picture is in a "
    .. "room" } },
  errors = "draws the picture if it was not drawn yet; nil, message, code as for save",
  example = [[
local v = ylm.view { volume = { values = { { { 1, 2 }, { 3, 4 } } } }, slices = true, size = { 200, 150 } }
assert(v:bars()[1].range[2] == 4)]],
}
function methods.bars(self)
  picture.is_one(self, "view", "bars")
  if not self.drawn_bars then
    local canvas, message, code = picture.draw(self, draw)
    if not canvas then return nil, message, code end
  end
  return self.drawn_bars
end

describe "view:window" {
  about = "The part of the last picture drawn that the camera sees: what title, caption and bars leave.",
  arguments = {},
  returns = { { "window", "table", "{x, y, w, h}, pixels from the top left" } },
  errors = "draws the picture if it was not drawn yet; nil, message, code as for save",
  example = [[
local v = ylm.view { volume = { values = { { { 1, 2 }, { 3, 4 } } } }, slices = true, size = { 200, 150 } }
local window = v:window()
assert(window[1] + window[3] <= v:bars()[1].room[1])]],
}
function methods.window(self)
  picture.is_one(self, "view", "window")
  if not self.drawn_window then
    local canvas, message, code = picture.draw(self, draw)
    if not canvas then return nil, message, code end
  end
  return self.drawn_window
end

--- The text about a picked point in a window's corner.
local function describe_point(v, x, y, z)
  local text = ("(%.4g, %.4g, %.4g)"):format(x, y, z)
  local grid = v.subject and form.kind(v.subject) == "ylm.grid" and v.subject
  if not grid then return text end
  local ok, cell = memory.pcall(grid.locate, grid, { x, y, z })
  if not ok or type(cell) ~= "table" then return text end
  local names, parts = {}, {}
  for name, value in pairs(cell) do
    if type(value) == "number" or type(value) == "boolean" then names[#names + 1] = name end
  end
  table.sort(names)
  for i, name in ipairs(names) do
    local value = cell[name]
    parts[i] = name .. " " .. (type(value) == "number" and ("%.4g"):format(value) or tostring(value))
  end
  print(text .. "  " .. table.concat(parts, "  "))
  return text .. "\n" .. table.concat(parts, "   ")
end

describe "view:show" {
  about = "Opens a window to look around in and returns when it is closed. 'p' prints what is under the mouse: "
    .. "the point, and grid:locate of it.",
  arguments = {},
  returns = { { "ok", "boolean", "true; or nil, message, 'EMISSING' where there is no display" } },
  errors = "the world's failures are returned",
  example = [[
local v = ylm.view { sh = { { 0, 0, 1, 0 } }, size = { 80, 60 } }
assert(type(v.show) == "function")]],
}
function methods.show(self)
  picture.is_one(self, "view", "show")
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local width, height = self.size[1], self.size[2]
  local prepared
  prepared, message, code = layers.prepare(self)
  if not prepared then return nil, message, code end
  local stage
  local l
  stage, l, code = build(self, vtk, width, height)
  if not stage then return nil, l, code end
  -- All texts on black and on white: where the two agree, the texts are opaque.
  local black = assert(core.canvas(width, height, { 0, 0, 0 }))
  local white = assert(core.canvas(width, height, { 1, 1, 1 }))
  annotate(self, black, l, true)
  annotate(self, white, l, true)
  return check.result("show", vtk.show(stage.scene, self.theme.background, black, white, self.title or "ylm",
    function(x, y, z) return describe_point(self, x, y, z) end))
end

-- The form -----------------------------------------------------------------------

--- A boolean or a table of that layer's own options.
form.types.layer = function(x, field)
  if x == nil or type(x) == "boolean" then return x end
  if field.takes and field.takes[type(x)] then return x end
  if type(x) == "table" and not form.kind(x) then return x end
  return nil, "true, false" .. (field.takes and field.takes.number and ", a number" or "") .. " or a table"
end

local fields = {
  { "subject", "any", optional = true, about = "a grid; may be given without a name, first" },
  { "quantity", "choice", of = quantities.names, optional = true,
    about = "what of the grid colours show; default error, with glyphs or streamlines alone gradient. A grid of which neither "
      .. "a layer nor a quantity is named shows its levels, before the geometry of scene where that is given" },
  { "volume", "layer", shelf = "experiments", optional = true,
    about = "a cloud of the quantity: true or { density = 1, smooth = true }; without a grid: "
      .. "{ values = [nz][ny][nx], bounds = } is the subject itself" },
  { "slices", "layer", optional = true,
    about = "coloured planes: true (where most leaves are), or a list of { axis = \"y\", at = 0.2, opacity = 1 }" },
  { "levels", "layer", optional = true,
    about = "edges of the grid's cells: true or { opacity = , width = , occupied = true, from = level }" },
  { "boxes", "layer", shelf = "experiments", optional = true,
    about = "leaves as coloured boxes: true or { shrink = 0.1, opacity = 1, occupied = }" },
  { "isosurfaces", "layer", shelf = "experiments", takes = { number = true }, optional = true,
    about = "surfaces where the quantity has a value: true, their number, or a list of values" },
  { "glyphs", "layer", shelf = "experiments", optional = true,
    about = "arrows of the gradient of L00: true or { count = 1500, length = 1 }" },
  { "streamlines", "layer", shelf = "experiments", optional = true,
    about = "lines along the gradient of L00: true or { count = 150, width = 1 }" },
  { "lobes", "layer", optional = true, about = "SH lobes of the grid's points: true or { count = 300, size = 1 }" },
  { "sh", "any", shelf = "experiments", optional = true, about = "SH vectors [n][(lmax+1)^2] as lobes beside each other" },
  { "labels", "list", of = "string", optional = true, about = "below the lobes of sh" },
  { "lights", "any", optional = true, about = "lights as small spheres: lights, or true: those of the scene or the bake" },
  { "meshes", "any", optional = true,
    about = "geometry, or a list of geometry or { mesh, colour = , colours = [n][3], opacity = }" },
  { "scene", "object", of = "scene", optional = true, about = "draws its geometry, takes its camera" },
  { "opacity", "number", shelf = "experiments", min = 0, max = 1, default = 1, about = "of the scene's geometry" },
  { "surfaces", "any", optional = true,
    about = "a surface grid (scene:surface_grid) or a lightmap: its scene's surfaces in the colours of its rectangles or charts, "
      .. "by its camera" },
  { "charts", "choice", of = { "number", "density", "error" }, optional = true,
    about = "of a lightmap: which colours its charts have: by number (default), by their texels a scene unit, or by their error, "
      .. "root mean square" },
  { "points", "any", optional = true, about = "[n][3] points drawn as dots" },
  { "range", "any", optional = true, about = "{least, largest} of the colours; default: of the data" },
  { "log", "boolean", optional = true, about = "logarithmic colours; default by quantity" },
  { "map", "choice", of = core.figure_map_names(), optional = true, about = "colour map; default by quantity" },
  { "label", "string", optional = true, about = "over the scalar bar; default: the quantity's name" },
  { "unit", "string", optional = true, about = "below the label" },
  { "bar", "boolean", default = true, about = "draw scalar bars" },
  { "frame", "boolean", default = true, about = "edges of the bounds, where levels are not drawn" },
  { "title", "string", optional = true },
  { "caption", "string", optional = true, about = "below the picture; broken into lines" },
  { "size", "list", of = "integer", min = 16, max = 8192, default = { 1280, 720 }, unit = "pixels" },
  { "camera", "object", of = "camera", optional = true,
    about = "exactly this view, over the whole picture but for the bars; default: the scene's, else one that sees everything" },
  { "direction", "vector", shelf = "experiments", optional = true,
    about = "from where, if there is no camera; default {0.55, 0.42, 0.8}, higher where that fills the picture's height" },
  { "up", "vector", shelf = "experiments", optional = true, about = "default {0, 1, 0}; {0, 0, 1} with sh" },
  { "background", "any", shelf = "experiments", default = "dark", about = "\"dark\", \"white\" or {r, g, b}, 0 to 1" },
  { "supersample", "integer", shelf = "experiments", min = 1, max = 4, default = 2,
    about = "anti-aliasing; 1 is four samples per pixel" },
  { "resolution", "integer", shelf = "experiments", min = 2, max = 512, default = 96, about = "voxels along the longest axis" },
  { "font", "integer", shelf = "experiments", min = 6, max = 200, optional = true, unit = "pixels", about = "size of letters" },
}

local function check_range(values, fail)
  local r = values.range
  if r == nil then return end
  r = check.plain(r)
  if type(r) ~= "table" or #r ~= 2 or not check.is_number(r[1]) or not check.is_number(r[2]) or r[1] >= r[2] then
    return fail(("range must be {least, largest} with least < largest, got %s"):format(check.describe(values.range)))
  end
  values.range = { r[1], r[2] }
end

local function check_subject(values, fail)
  local kind = values.subject ~= nil and form.kind(values.subject)
  if values.subject ~= nil and kind ~= "ylm.grid" then
    return fail(("the first entry must be a grid, got %s"):format(check.describe(values.subject)))
  end
end

local function build_view(values, fail)
  picture.size(values.size, fail)
  values.theme = picture.theme(values.background, fail)
  check_range(values, fail)
  check_subject(values, fail)
  layers.check(values, fail)
  local scene = values.scene or values.surfaces and values.surfaces.scene
  if values.camera == nil and scene then values.camera = scene.camera end
  return setmetatable(values, form.defined.view.metatable)
end

local construct = form.define("view", {
  shelf = "everyday",
  about = "A picture in three dimensions: of a grid, of numbers on a lattice, of SH vectors, of a scene. "
    .. "Methods: save, show, pixels, bars, window.",
  fields = fields,
  metatable = { __index = methods },
  build = build_view,
  example = [[
view { volume = { values = { { { 0, 1 }, { 2, 3 } } }, bounds = { { 0, 0, 0 }, { 1, 1, 1 } } }, slices = true }]],
})

--- The grid may stand first, without a name.
local function named(given, fail)
  if type(given) ~= "table" or form.kind(given) or given[1] == nil then return given end
  local copy = {}
  for key, value in pairs(given) do copy[key] = value end
  if copy.subject ~= nil then return fail "view: the grid is given twice, first and as subject" end
  copy.subject, copy[1] = copy[1], nil
  return copy
end

describe "view" {
  about = "Makes a picture in three dimensions; see the form 'view'. Nothing is drawn before save, pixels or show.",
  arguments = { { "fields", "table", "the grid first, if there is one, then named fields" } },
  returns = { { "v", "view", "" } },
  errors = "raises on missing, misspelt or wrong fields",
  example = [[
local v = ylm.view { sh = { { 1, 0, 0, 0 }, { 0, 0, 1, 0 } }, labels = { "Y00", "Y10" }, size = { 160, 90 } }
assert(v:pixels().shape[2] == 160)]],
}
function view.view(given)
  return construct(named(given, check.fail))
end
form.defined.view.construct = view.view

memory.publish(methods)

return view
