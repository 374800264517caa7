-- Refusals of views, plots and figures.

local nan, inf = 0 / 0, 1 / 0
local sh = { { 1, 0, 0, 0 } }
local lattice = { values = { { { 1, 2 }, { 3, 4 } } } }

local function view(fields, says)
  return { call = function(ylm) return ylm.view(fields) end, says = says }
end

local function plot(fields, says)
  return { call = function(ylm) return ylm.plot(fields) end, says = says }
end

local function figure(fields, says)
  return { call = function(ylm) return ylm.figure(fields) end, says = says }
end

local black = { { { 0, 0, 0 } } }
local function small(ylm, fields)
  fields.size, fields.supersample = { 32, 24 }, 1
  return ylm.view(fields)
end

--- Refusals that save and pixels of every kind of picture share.
local function methods(kind, make)
  local files = ({ plot = ", %.svg or %.pdf", view = " or %.gltf" })[kind] or ""
  local wanted = "the name of a %.png" .. files .. " file expected"
  return {
    [kind .. ":save"] = {
      { call = function(ylm) return make(ylm):save() end, says = wanted .. ", got nil" },
      { call = function(ylm) return make(ylm):save "picture.jpg" end, says = wanted },
      { call = function(ylm) return make(ylm):save ".png" end, says = wanted },
      { call = function(ylm) return make(ylm):save(12) end, says = wanted },
      { call = function(ylm) return make(ylm):save "a\0.png" end, says = wanted },
      { call = function(ylm) return make(ylm).save({}, "a.png") end, says = kind .. " expected before the colon" },
      { call = function(ylm) return make(ylm):save "no/such/folder/a.png" end, says = "No such file" },
    },
    [kind .. ":pixels"] = {
      { call = function(ylm) return make(ylm).pixels() end, says = kind .. " expected before the colon" },
    },
  }
end

local cases = {
  view = {
    { call = function(ylm)
      return ylm.view { lights = { ylm.virtual_lights { at = { { 0, 0, 0 } }, radius = 0.2, intensity = 3 } } }
    end, says = "virtual lights have no body to be drawn" },
    view(nil, "a table of named fields expected, got nil"),
    view(3, "a table of named fields expected, got 3"),
    view({}, "nothing to show"),
    view({ 12 }, "the first entry must be a grid, got 12"),
    view({ quantitiy = "error" }, "did you mean 'quantity'"),
    view({ sh = sh, quantity = "eror" }, "did you mean 'error'"),
    view({ sh = sh, quantity = "error" }, "quantity is of a grid"),
    view({ sh = {} }, "sh is empty"),
    view({ sh = { { 1, 2 } } }, "%(lmax%+1%)%^2 coefficients"),
    view({ sh = { { nan } } }, "not finite"),
    view({ sh = "Y00" }, "sh must be an array or table"),
    view({ sh = sh, labels = { 1 } }, "labels must be a list"),
    view({ sh = sh, size = { 100 } }, "size must be {width, height}"),
    view({ sh = sh, size = { 100, -1 } }, "size must be a list"),
    view({ sh = sh, size = { 1e9, 1e9 } }, "size must be a list"),
    view({ sh = sh, range = { 1, 1 } }, "least < largest"),
    view({ sh = sh, range = { 0, inf } }, "least < largest"),
    view({ sh = sh, range = { 0, 1 }, log = true }, "above 0 where log"),
    view({ sh = sh, background = "drak" }, "background must be 'dark', 'white'"),
    view({ sh = sh, background = { 1, 2, 3 } }, "background must be"),
    view({ sh = sh, map = "jet" }, "map must be one of"),
    view({ sh = sh, camera = {} }, "camera must be a camera"),
    view({ sh = sh, direction = { 0, 0, 0 } }, "not all zero"),
    view({ sh = sh, supersample = 99 }, "supersample must be"),
    view({ sh = sh, size = { 8000, 8000 }, supersample = 4 }, "at most 16384 pixels"),
    { call = function(ylm)
      local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 0 },
        ylm.sphere_light { at = { 3, 3, 3 } })
      grid:close()
      return ylm.view { grid }
    end, says = "the grid has been closed" },
    view({ slices = true }, "slices needs a grid, or volume"),
    view({ levels = true }, "levels needs a grid"),
    view({ lobes = true }, "lobes needs a grid"),
    view({ boxes = true }, "boxes needs a grid"),
    view({ volume = true }, "volume needs a grid, or { values"),
    view({ glyphs = true }, "glyphs needs a grid"),
    view({ streamlines = true }, "streamlines needs a grid"),
    view({ volume = { valeus = 1 } }, "did you mean 'values'"),
    view({ volume = { values = { 1, 2 } } }, "volume: values must be numbers %[nz%]"),
    view({ volume = { values = lattice.values, bounds = { { 0, 0, 0 }, { 0, 0, 0 } } } }, "volume: bounds must be"),
    view({ volume = { values = lattice.values, density = -1 } }, "density must be a number >= 0"),
    view({ volume = { bounds = 1 } }, "volume.bounds needs volume.values"),
    view({ volume = lattice, slices = {} }, "slices: a list"),
    view({ volume = lattice, slices = { { axis = "w" } } }, "slices: entry 1 must be"),
    view({ volume = lattice, slices = { { axis = "y", at = nan } } }, "at must be a number"),
    view({ volume = lattice, slices = { { axis = "y", opacity = 2 } } }, "opacity must be a number from 0 to 1"),
    view({ volume = lattice, slices = { { axis = "y", where = 2 } } }, "no field 'where'"),
    { call = function(ylm) return small(ylm, { volume = lattice, slices = { { axis = "y", at = 9 } } }):pixels() end,
      says = "outside of the bounds" },
    view({ volume = lattice, charts = "error" }, "charts is of surfaces that are a lightmap"),
    view({ volume = lattice, isosurfaces = 0 }, "isosurfaces must be true"),
    view({ volume = lattice, isosurfaces = {} }, "isosurfaces: a list of values"),
    view({ volume = lattice, isosurfaces = { nan } }, "value 1 must be a finite number"),
    view({ glyphs = { at = { { 0, 0, 0 } } } }, "at and along belong together"),
    view({ glyphs = { at = { { 0, 0, 0 } }, along = { { 0, 0, 1 }, { 0, 0, 1 } } } }, "as many rows"),
    view({ streamlines = { along = { { { 1 } } } } }, "streamlines: along must be numbers"),
    view({ lights = true }, "lights = true shows the lights of a scene"),
    view({ lights = "all" }, "lights must be a light"),
    view({ meshes = {} }, "meshes: the list is empty"),
    view({ meshes = { 1 } }, "meshes: geometry or"),
    view({ points = { { 1, 2 } } }, "rows of 3 numbers"),
    view({ scene = 1 }, "scene must be a scene"),
    view({ scene = 1 }, "scene must be a scene"),
    { call = function(ylm)
      local ball = ylm.sphere { radius = 1, divide = { 4, 3 } }
      return small(ylm, { meshes = { { ball, colours = { { 1, 1, 1 } } } } }):pixels()
    end, says = "meshes: 1 colours for %d+ vertices" },
    { call = function(ylm) return ylm.view { meshes = { { ylm.sphere { radius = 1 }, opactiy = 1 } } } end,
      says = "no field 'opactiy'" },
    { call = function(ylm) return ylm.view { meshes = { { ylm.sphere { radius = 1 }, opacity = 2 } } } end,
      says = "opacity must be" },
  },
  ["view:bars"] = {
    { call = function(ylm) return ylm.view({ sh = sh }).bars(1) end, says = "view expected before the colon" },
  },
  ["view:window"] = {
    { call = function(ylm) return ylm.view({ sh = sh }).window(1) end, says = "view expected before the colon" },
  },
  ["view:show"] = {
    { call = function(ylm) return ylm.view({ sh = sh }).show {} end, says = "view expected before the colon" },
  },
  plot = {
    plot(nil, "a table of named fields expected"),
    plot({}, "nothing to plot"),
    plot({ x = { 1 } }, "x and y belong together"),
    plot({ x = { 1, 2 }, y = { 1 } }, "series 1: x has 2 numbers, y 1"),
    plot({ x = {}, y = {} }, "x and y are empty"),
    plot({ x = { 1 }, y = { "a" } }, "y: entry 1 must be a number"),
    plot({ x = 1, y = 2 }, "x must be a list of numbers"),
    plot({ series = { 1 } }, "series 1: a table"),
    plot({ series = { { x = { 1 }, y = { 1 }, lable = "a" } } }, "did you mean 'label'"),
    plot({ series = { { x = { 1 }, y = { 1 }, dash = "dashy" } } }, "dash must be one of"),
    plot({ series = { { x = { 1 }, y = { 1 }, colour = 3 } } }, "colour must be"),
    plot({ x = { 1 }, y = { 1 }, x_range = { 0, 1 }, log = true }, "above 0 on a logarithmic axis"),
    plot({ x = { 1 }, y = { 1 }, y_range = { 2, 1 } }, "least < largest"),
    plot({ x = { 1 }, y = { 1 }, diagonal = 4 }, "diagonal must be true or its label"),
    plot({ x = { 1 }, y = { 1 }, size = { 1, 1 } }, "size must be a list"),
    plot({ x = { 1 }, y = { 1 }, size = { 8000, 100 }, supersample = 3 }, "at most 16384 pixels"),
    { call = function(ylm) return ylm.plot({ x = { 1 }, y = { 1 }, size = { 64, 64 }, font = 90 }):pixels() end,
      says = "no room for its texts" },
  },
  ["plot:where"] = {
    { call = function(ylm) return ylm.plot({ x = { 1 }, y = { 1 } }):where("a", 1) end,
      says = "bad argument #1 to 'where'" },
    { call = function(ylm) return ylm.plot({ x = { 1 }, y = { 1 } }):where(1, nan) end,
      says = "bad argument #2 to 'where'" },
  },
  figure = {
    figure(nil, "a table of named fields expected"),
    figure({}, "field 'rows' is missing"),
    figure({ rows = {} }, "rows is empty"),
    figure({ rows = { 1 } }, "row 1 must be a list"),
    figure({ rows = { {} } }, "row 1 is empty"),
    figure({ rows = { { 1 } } }, "row 1, image 1: an image, or a table"),
    figure({ rows = { { "a.jpg" } } }, "image must be a view"),
    figure({ rows = { { {} } } }, "one of image, values and wipe expected"),
    figure({ rows = { { { imgae = 1 } } } }, "did you mean 'image'"),
    figure({ rows = { { { values = { { 1 } } } } } }, "values need a range"),
    figure({ rows = { { { values = { { 1 } }, range = { 0, 1 }, log = true } } } }, "above 0 where log"),
    figure({ rows = { { { values = 3, range = { 0, 1 } } } } }, "values must be numbers"),
    figure({ rows = { { { wipe = { "a.png" } } } } }, "at least two images"),
    figure({ rows = { { { wipe = { "a.png", "b.png" }, at = { 0.2, 0.4 } } } } }, "at: 1 numbers expected, got 2"),
    figure({ rows = { { { image = "a.png", crop = { 1, 2, 3 } } } } }, "crop must be {x, y"),
    figure({ rows = { { { image = "a.png", mark = 3 } } } }, "mark must be"),
    figure({ rows = { { { image = "a.png", tone = "filmic" } } } }, "tone must be one of"),
    figure({ rows = { { "a.png" } }, bar = {} }, "bar: field 'range' is missing"),
    figure({ rows = { { "a.png" } }, bar = { range = { 1, 0 } } }, "bar: range must be"),
    { call = function(ylm) return ylm.figure({ rows = { { "no such file.png" } } }):pixels() end,
      says = "No such file" },
    { call = function(ylm) return ylm.figure({ rows = { { ylm.zeros { 2, 2 } } } }):pixels() end,
      says = "pixels %[height%]" },
    { call = function(ylm)
      return ylm.figure({ rows = { { { image = ylm.array(black), crop = { 0, 0, 2, 2 } } } } }):pixels()
    end, says = "leaves the image" },
    { call = function(ylm)
      return ylm.figure({ rows = { { { wipe = { ylm.zeros { 2, 2, 3 }, ylm.zeros { 2, 3, 3 } } } } } }):pixels()
    end, says = "images of one size" },
  },
}

local makers = {
  view = function(ylm) return small(ylm, { sh = sh }) end,
  plot = function(ylm) return ylm.plot { x = { 1, 2 }, y = { 1, 2 }, size = { 200, 150 } } end,
  figure = function(ylm) return ylm.figure { rows = { { ylm.array(black) } } } end,
}
for kind, make in pairs(makers) do
  for name, list in pairs(methods(kind, make)) do cases[name] = list end
end

return cases
