--- ylm.load: scenes, grids, arrays, images, meshes, measured materials and photometry, by content.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local gltf = require "ylm.gltf"
local sandbox = require "ylm.sandbox"

local file = {}

--- The kind of a file, by its first bytes; nil, message, code where it cannot be read.
function file.kind_of(path)
  if path:lower():find("%.ylmd/*$") then return "grid_set" end
  local head, message, code = core.file_head(path)
  if not head then return nil, message, code end
  if head:sub(1, 6) == "\147NUMPY" then return "array" end
  if head:sub(1, 4) == "\118\47\49\1" or head:sub(1, 8) == "\137PNG\r\n\26\n" or head:sub(1, 2) == "#?"
    or head:sub(1, 3) == "\255\216\255"
    or head:find("^P[Ff][\r\n ]") then
    return "image"
  end
  if head:find("^ply[\r\n]") or path:lower():find("%.obj$") then return "mesh" end
  if head:sub(1, 4) == "glTF" or path:lower():find("%.gltf$") then return "gltf" end
  if head:sub(1, 8) == require("ylm.grid").magic then return "grid" end
  if require("ylm.material.file").kind_of(path, head) then return "material" end
  if path:lower():find("%.lua$") then return "scene" end
  if core.photometry_kind(path) then return "photometry" end
  if head:sub(1, 8) == "\137YLMsurf" then return "surface_grid" end
  return nil, path
    .. ": not a file that ylm knows (scene .lua, .glb, .gltf, grid, .npy, .exr, .png, .jpg, .hdr, .pfm, .obj, .ply, .binary, "
    .. ".bsdf, .ies, .ldt)", "EFORMAT"
end

--- The kinds of files that options are for, as a refusal names them.
local of_kind = { array = "arrays", image = "images", mesh = "meshes", gltf = "glTF files", grid = "grids",
  grid_set = "grids in bricks", material = "materials", photometry = "photometric files", scene = "scene files",
  surface_grid = "light on surfaces" }

--- Kind -> options, and read(path, options).
local readers = {
  array = { options = {}, read = function(path) return core.array_read(path) end },
  image = {
    options = {
      { "raw", "boolean", default = false, about = ".png, .jpg: numbers as they stand instead of decoded from sRGB" },
    },
    read = function(path, o) return require("ylm.image").read(path, o.raw) end,
  },
  mesh = {
    options = {
      { "materials", "boolean", default = false,
        about = ".obj, .ply: geometry as ylm.mesh { file = } makes it, with the materials of the file, instead of a mesh" },
    },
    read = function(path, o)
      if o.materials then return require "ylm.geometry".mesh { file = path } end
      return core.mesh_read(path)
    end,
  },
  surface_grid = { options = {}, read = function(path)
    return nil, path .. ": light on surfaces is read with its scene: scene:surface_grid { file = }", "EFORMAT"
  end },
  grid = { options = {}, read = function(path) return require("ylm.grid").load(path) end },
  grid_set = {
    options = { { "cache", "memory", optional = true, about = ".ylmd: memory of bricks that were used last; default 256 MB" } },
    read = function(path, o)
      require "ylm.grid" -- its methods
      return require("ylm.grid.set").open(path, o.cache)
    end,
  },
  material = { options = {}, read = function(path)
    require "ylm.material" -- the forms
    return require("ylm.material.file").load(path)
  end },
  photometry = { options = {}, read = function(path) return require("ylm.photometry").photometry { file = path } end },
  gltf = { options = gltf.load_options, read = function(path, o) return require("ylm.scene").of_gltf(path, o) end },
  scene = { options = sandbox.limits, read = function(path, o) return require("ylm.scene").of_file(path, o) end },
}

--- The options of all kinds, without defaults: name -> the kinds that have it, and a list for help.
local takers, load_options = {}, {}
for _, kind in ipairs { "scene", "gltf", "mesh", "image", "grid_set", "array", "grid", "material" } do
  for _, option in ipairs(readers[kind].options) do
    local name = option[1]
    if not takers[name] then
      takers[name] = {}
      load_options[#load_options + 1] = option
    end
    table.insert(takers[name], kind)
  end
end

describe "load" {
  shelf = "everyday",
  about = "Reads a file by its content: a scene (.lua, .glb, .gltf), a grid, an array (.npy), an image (.exr, .png, .jpg, .hdr, "
    .. ".pfm), a mesh (.obj, .ply), a measured material (.binary of MERL, .bsdf of RGL) or a lamp's photometry (.ies, .ldt); "
    .. "or a grid in bricks, a folder name.ylmd. A scene file may come from a stranger: it sees numbers, tables, math and the "
    .. "constructors, and is bounded in instructions, memory and described size; other files are looked for in its folder only.",
  arguments = { { "path", "string", "a regular file, or a folder name.ylmd" },
    { "options?", "table", "limits of a scene file, and what else the kind of file has" } },
  options = load_options,
  returns = { { "object", "scene|grid|grid_set|array|image|mesh|geometry|material|photometry", "what the file holds; the scene "
    .. "of a glTF file has its cameras by number and name, and report: counts, and notes about what was left out" } },
  errors = "nil, message, code where the file is missing, damaged or of another kind, 'ELIMIT' beyond a limit; raises on a wrong "
    .. "argument",
  example = [[
local name = os.tmpname()
assert(ylm.array({ { 1, 2 }, { 3, 4 } }, "float"):save(name .. ".npy"))
assert(ylm.load(name .. ".npy"):get(2, 1) == 3)
os.remove(name .. ".npy")
os.remove(name)
local scene, message, code = ylm.load "no such file.lua"
assert(scene == nil and code == "EIO", message)]],
}
function file.load(path, options)
  if type(path) ~= "string" or #path == 0 or path:find("%z") then
    return check.bad(1, "load", "a file name expected, got %s", check.describe(path))
  end
  form.options(2, "load", load_options, options)
  local kind, message, code = file.kind_of(path)
  if not kind then return nil, message, code end
  local own = {}
  for _, option in ipairs(readers[kind].options) do own[option[1]] = true end
  for name in pairs(options or own) do
    if not own[name] then
      return check.bad(2, "load", "%s is for %s, not for %s: leave it out", name, of_kind[takers[name][1]], of_kind[kind])
    end
  end
  return readers[kind].read(path, form.options(2, "load", readers[kind].options, options))
end

return file
