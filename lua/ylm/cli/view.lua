--- ylm view grid.ylm --quantity error, ylm view a.npy b.npy --product

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"
local view_sh = require "ylm.cli.view_sh"
local view_things = require "ylm.cli.view_things"

local TEXELS = 65536 -- of the lightmap whose charts are seen

local of_grids = { "quantity", "range", "log", "linear", "map", "volume", "slices", "slice", "levels", "boxes", "isosurfaces",
  "iso-values", "glyphs", "streamlines", "lobes", "count", "label", "unit", "no-bar", "no-frame", "resolution" }
local of_scenes = { "lights", "opacity" }
local of_vectors = { "product", "rotate", "angle" }

--- Ends the command where an option was given that this kind of file has no use for.
local function refuse(given, names, what)
  for _, name in ipairs(names) do
    if given[name] ~= nil then status.stop(status.usage, "view: --%s is for %s", name, what) end
  end
end

--- Reads light on surfaces, which needs its scene: found.surfaces.
local function load_surfaces(found, path)
  if found.grid or found.arrays[1] then
    status.stop(status.usage, "view: light on surfaces is seen alone: %s, and no grid or SH vectors", path)
  end
  if not found.scene then
    status.stop(status.usage, "view: %s: light on surfaces is seen on its scene: name the scene's file too", path)
  end
  found.surfaces = status.need(found.scene:surface_grid { file = path })
end

--- Bakes a lightmap of the scene, whose charts are seen: found.surfaces, found.charts.
local function bake_charts(given, found)
  if not found.scene or found.grid or found.surfaces then
    status.stop(status.usage, "view: --charts bakes a lightmap of a scene: name the file of one alone")
  end
  if given.charts ~= "number" and given.charts ~= "density" and given.charts ~= "error" then
    status.stop(status.usage, "view: --charts is number, density or error, got '%s'", given.charts)
  end
  found.surfaces = status.need(found.scene:lightmap { texels = given.texels or TEXELS, progress = report.progress(given) })
  found.charts = given.charts
end

--- Contents of the files, sorted: { arrays = {}, grid = , scene = , meshes = {}, surfaces = }.
local function load(given)
  local core, form = require "ylm.c.core", require "ylm.form"
  local found, paths, last = { arrays = {}, meshes = {} }, {}, nil
  for _, path in ipairs(given) do
    if require "ylm.file".kind_of(path) ~= "surface_grid" then paths[#paths + 1] = path
    elseif last then status.stop(status.usage, "view: one file of light on surfaces at a time, %s is the second", path)
    else last = path end
  end
  for i, path in ipairs(paths) do
    local thing = status.load(path)
    local kind = core.type(thing) == "ylm.array" and "array" or form.kind(thing):gsub("^ylm%.", "")
    if kind == "array" then found.arrays[i] = thing
    elseif kind == "mesh" then found.meshes[#found.meshes + 1] = thing
    elseif kind == "grid_set" then
      status.stop(status.failed, "%s: a grid in bricks: ylm pack makes one file of it, for ylm view", path)
    elseif kind ~= "grid" and kind ~= "scene" then
      status.stop(status.failed, "%s: neither a scene nor a mesh, not a grid or SH vectors", path)
    elseif found[kind] then status.stop(status.usage, "view: one %s at a time, %s is the second", kind, path)
    else found[kind] = thing end
    if next(found.arrays) and #found.arrays < i then
      status.stop(status.usage, "view: several files must all hold SH vectors, %s does not", paths[#found.arrays + 1])
    end
  end
  if last then load_surfaces(found, last) end
  if given.charts then bake_charts(given, found)
  elseif given.texels then status.stop(status.usage, "view: --texels is of --charts") end
  return found
end

--- Calls f(...); what a view refuses stood on the command line.
local function try(f, ...)
  local good, first, message, code = pcall(f, ...)
  if good then return first, message, code end
  if tostring(first):find "^view: " then status.stop(status.usage, "%s", first) end
  error(first, 0)
end

--- The view of what the files hold; and the summaries of SH vectors.
local function view_of(ylm, given, found)
  if #found.arrays > 0 then
    refuse(given, of_grids, "grids")
    refuse(given, of_scenes, "scenes")
    return try(view_sh.view, ylm, given, found.arrays, given)
  end
  refuse(given, of_vectors, "SH vectors")
  if not found.grid then refuse(given, of_grids, "grids") end
  if not found.scene then refuse(given, of_scenes, "scenes: name the file of one too") end
  local fields = view_things.fields(ylm, given, found.grid, found.scene, found.meshes)
  fields.surfaces, fields.charts = found.surfaces, found.charts
  return try(ylm.view, fields)
end

return {
  summary = "a picture of a grid, a scene and meshes, or of SH vectors as lobes: to a file with -o, else in a window",
  usage = "GRID.ylm [SCENE.lua] [MESH.obj ..] [--quantity NAME] [-o PICTURE.png]\n"
    .. "       ylm view SCENE.lua LIGHT.surfaces [-o PICTURE.png]\n"
    .. "       ylm view C.npy [MORE.npy ..] [--product] [--rotate X,Y,Z [--angle N]] [-o PICTURE.png]",
  least = 1,
  most = 16,
  options = {
    { "output", "-o", "FILE", "a .png; without it a window opens" },
    { "quantity", nil, "NAME", "error, lambda, norm, ...: see ylm help view" },
    { "range", nil, "A,B", "of the colours" },
    { "log", nil, nil, "logarithmic colours; default by quantity" },
    { "linear", nil, nil, "linear colours" },
    { "map", nil, "NAME", "colour map; default by quantity" },
    { "volume", nil, nil, "the quantity as a cloud; with --levels where a quantity is named and no layer" },
    { "slices", nil, nil, "a plane across y, where most leaves are" },
    { "slice", nil, "PLANES", "planes such as y=0.2 or x,z=1; an axis alone: where most leaves are" },
    { "levels", nil, nil, "the wireframe of the levels; alone where neither a quantity nor a layer is named" },
    { "boxes", nil, nil, "leaves as coloured boxes" },
    { "isosurfaces", nil, "N", "that many surfaces where the quantity has a value" },
    { "iso-values", nil, "LIST", "surfaces where it has these values: 0.5,1,2" },
    { "glyphs", nil, nil, "arrows of the gradient of L00" },
    { "streamlines", nil, nil, "lines along the gradient of L00" },
    { "lobes", nil, nil, "SH lobes of the grid's points" },
    { "count", nil, "N", "about how many arrows, lines or lobes" },
    { "lights", nil, nil, "the lights of the scene" },
    { "opacity", nil, "N", "of the scene's geometry, 0 to 1" },
    { "charts", nil, "NAME", "bakes a lightmap of the scene: the colours of its charts by number, density (texels), or error" },
    { "texels", nil, "N", "of --charts, default 65536" },
    { "product", nil, nil, "SH vectors: show their product beside them" },
    { "rotate", nil, "X,Y,Z", "SH vectors: show them turned about this axis beside them" },
    { "angle", nil, "N", "of --rotate, degrees, default 90" },
    { "from", nil, "X,Y,Z", "where the camera stands; default: the scene's, else one that sees everything" },
    { "at", nil, "X,Y,Z", "what it looks at; default: the grid's middle" },
    { "up", nil, "X,Y,Z", "what is up in the picture, default 0,1,0; of SH vectors 0,0,1" },
    { "fov", nil, "N", "angle that the picture's height spans, degrees, default 45" },
    { "direction", nil, "X,Y,Z", "from where everything is seen, if there is no camera" },
    { "title", nil, "TEXT", "above the picture" },
    { "caption", nil, "TEXT", "below it" },
    { "label", nil, "TEXT", "of the scalar bar; default: the quantity's" },
    { "unit", nil, "TEXT", "below the label" },
    { "no-bar", nil, nil, "no scalar bars" },
    { "no-frame", nil, nil, "no edges of the bounds" },
    { "background", nil, "NAME", "dark (default) or white" },
    { "size", "-s", "WxH", "pixels" },
    { "font", nil, "N", "pixels that letters are high" },
    { "resolution", nil, "N", "voxels along the longest axis" },
    { "supersample", nil, "N", "anti-aliasing, 1 to 4" },
  },
  examples = {
    "ylm view grid.ylm --quantity norm --iso-values 0.5,1,2 --range 0.3,5 -o surfaces.png",
    "ylm view grid.ylm scene.lua --glyphs --count 800 --lights --opacity 0.3 -o gradients.png",
    "ylm view grid.ylm --slice y=0,x --log --from 3,2,4 --at 0,0.5,0 --fov 40 -s 1024x768 -o slices.png",
    "ylm view grid.ylm --lobes --background white",
    "ylm view light.npy mask.npy --product -o lobes.png",
  },
  run = function(given)
    local ylm = require "ylm"
    if given.output then status.need_output("view", given.output, "png") end
    if given.json and not given.output then status.stop(status.usage, "view: --json goes with -o FILE, not with a window") end
    if given.angle and not given.rotate then status.stop(status.usage, "view: --angle goes with --rotate X,Y,Z") end
    local picture, summaries = view_of(ylm, given, load(given))
    if given.output then
      status.need(try(picture.save, picture, given.output))
      if given.json then report.print(given, { output = given.output, vectors = summaries })
      else report.say(given, "%s", given.output) end
    else
      status.need(try(picture.show, picture))
    end
  end,
}
