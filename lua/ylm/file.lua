--- ylm.load: grids, arrays, images, meshes, glTF and measured materials, by content.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"

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
  return nil, path
    .. ": not a file that ylm knows (grid, .npy, .exr, .png, .jpg, .hdr, .pfm, .obj, .ply, .glb, .gltf, .binary, "
    .. ".bsdf)", "EFORMAT"
end

local readers = {
  array = function(path) return core.array_read(path) end,
  image = function(path, options) return require("ylm.image").read(path, options.raw) end,
  mesh = function(path, options)
    if options.materials then return require "ylm.geometry".mesh { file = path } end
    return core.mesh_read(path)
  end,
  gltf = function(path) return require "ylm.gltf".load_gltf(path) end,
  grid = function(path) return require("ylm.grid").load(path) end,
  grid_set = function(path, options)
    require "ylm.grid" -- its methods
    return require("ylm.grid.set").open(path, options.cache)
  end,
  material = function(path)
    require "ylm.material" -- the forms
    return require("ylm.material.file").load(path)
  end,
}

local load_options = {
  { "raw", "boolean", default = false, about = ".png, .jpg: numbers as they stand instead of decoded from sRGB" },
  { "cache", "memory", optional = true, about = ".ylmd: memory of bricks that were used last; default 256 MB" },
  { "materials", "boolean", default = false,
    about = ".obj, .ply: geometry as ylm.mesh { file = } makes it, with the materials of the file, instead of a mesh" },
}

describe "load" {
  about = "Reads a file by its content: a grid, an array (.npy), an image (.exr, .png, .jpg, .hdr, .pfm), a mesh (.obj, .ply), "
    .. "a glTF file (.glb, .gltf) or a measured material (.binary of MERL, .bsdf of RGL); or a grid in bricks, a folder "
    .. "name.ylmd.",
  arguments = { { "path", "string", "a regular file, or a folder name.ylmd" }, { "options?", "table", "" } },
  options = load_options,
  returns = { { "object", "grid|grid_set|array|image|mesh|geometry|gltf|material", "what the file holds" } },
  errors = "nil, message, code where the file is missing, damaged or of another kind; raises on a wrong argument",
  example = [[
local name = os.tmpname()
assert(ylm.array({ { 1, 2 }, { 3, 4 } }, "float"):save(name .. ".npy"))
assert(ylm.load(name .. ".npy"):get(2, 1) == 3)
os.remove(name .. ".npy")
os.remove(name)]],
}
function file.load(path, options)
  if type(path) ~= "string" or #path == 0 or path:find("%z") then
    return check.bad(1, "load", "a file name expected, got %s", check.describe(path))
  end
  options = form.options(2, "load", load_options, options)
  local kind, message, code = file.kind_of(path)
  if not kind then return nil, message, code end
  return readers[kind](path, options)
end

return file
