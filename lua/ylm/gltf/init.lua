--- glTF 2.0: the form gltf, and what ylm.load uses.
--
-- The reader (csrc/codec/gltf) returns meshes in world coordinates, factors of materials, lamps and cameras; the files
-- of this room make ylm's of them.

local camera = require "ylm.camera"
local check = require "ylm.check"
local core = require "ylm.c.core"
local emitters = require "ylm.gltf.emitters"
local form = require "ylm.form"
require "ylm.geometry" -- the form mesh
local json = require "ylm.gltf.json"
local library = require "ylm.library"
local lights = require "ylm.gltf.lights"
local material = require "ylm.gltf.material"
local text = require "ylm.text"
local texture = require "ylm.material.texture"
local show = require "ylm.show"
local vector = require "ylm.vector"

local gltf = {}

local TRIANGLES, TEXELS, BYTES = 2e7, 2 ^ 26, 2 ^ 30 -- where no limits of a scene file or of ylm.load are narrower

--- Is it the name of a glTF file?
function gltf.is_name(path)
  return type(path) == "string" and (path:lower():find "%.gltf$" or path:lower():find "%.glb$") ~= nil
end

--- The smallest of the limits: `most`, the caller's, a scene file's.
local function left(what, most, limits)
  most = math.min(most, limits and limits[what] or most)
  return math.min(most, form.budget and form.budget(what) or most)
end

local GROUPS = 256 -- YLM_GLTF_GROUPS

--- "image", "mean", or the most groups of triangles.
form.types.gltf_textures = function(x)
  if x == "image" or x == "mean" then return x end
  if form.types.number(x, {}) and x >= 1 and x <= GROUPS and x % 1 == 0 then return x end
  return nil, "'image', 'mean' or an integer from 1 to " .. GROUPS
end

local fields = {
  { "lamp_radius", "number", above = 0, max = 1e6, default = 0.05, unit = "scene units",
    about = "of spheres in place of lamps without a size" },
  { "light_scale", "number", min = 0, max = 1e6, default = 1, unit = "W/lm",
    about = "multiplies intensities: 1 candela counts as this many W sr^-1" },
  { "spots", "choice", of = { "spot", "sphere" }, default = "spot",
    about = "spot: spot_light, which has no light field; sphere: as a point that shines all around" },
  { "emitters", "integer", min = 0, max = 1e5, default = 256,
    about = "most polygon lights that surfaces that emit become; 0: they do not emit" },
  { "textures", "gltf_textures", default = "image",
    about = "image: base colours vary over the surface; mean: each surface has the mean of its texels, weighted by area; "
      .. "n: its triangles in at most n groups of one colour" },
  { "scene", "integer", min = 1, optional = true, about = "which scene of the file, by its place; default: the file's choice" },
}

local sides = { auto = true, both = true, front = true, back = true }

--- One surface; `m`: what material.convert made of its material.
local function surface(piece, m, extras)
  local made = m.material
  if piece.tint then made = m.tinted(piece.tint)
  elseif made and texture.of(made) and not core.mesh_uvs(piece.mesh) then made = m.plain() end
  return setmetatable({ mesh = piece.mesh, name = piece.name ~= "" and piece.name or nil, material = made,
    occludes = m.occludes(piece.alpha) and extras.occludes ~= false,
    sides = m.both_sides and "both" or sides[extras.sides] and extras.sides or nil }, form.defined.mesh.metatable)
end

--- Surfaces: a list of geometry; those that emit go to `lamps`. note(sentence, ...) takes what is lost. Second, the part of
-- the emitted power that is lost; or nil, message, code.
local function surfaces(file, materials, lamps, o, note)
  local out, glowing, left_out, lost = {}, {}, 0, 0
  for _, piece in ipairs(file.pieces) do
    local m, extras = materials[piece.material] or material.none, piece.extras and json.read(piece.extras) or {}
    local lamp = lights.of_piece(piece, extras, m.emission, o)
    if lamp then lamps[#lamps + 1] = lamp
    elseif m.left_out then left_out = left_out + 1
    else
      local one = surface(piece, m, extras)
      if m.emission and math.max(m.emission[1], m.emission[2], m.emission[3]) > 0 and o.emitters > 0 then
        glowing[#glowing + 1] = { piece = one, m = m, wraps = m.emission_wrap, image = m.shares_uvs
          and m.emission_image and file.images[m.emission_image] or nil }
      else out[#out + 1] = one end
    end
  end
  if left_out > 0 then note("pieces left out, because their alpha is below the cutoff: %d", left_out) end
  if #glowing > 0 then
    local made, stay, share = emitters.convert(glowing, o.emitters, o.light_scale, note)
    if not made then return nil, stay, share end
    for _, l in ipairs(made) do lamps[#lamps + 1] = l end
    for _, piece in ipairs(stay) do out[#out + 1] = piece end
    lost = share
  end
  return out, lost
end

--- Fields that ylm has written of a camera, while it looks where it did.
local function as_written(c)
  local extras = c.extras and json.read(c.extras) or {}
  local at, up, fov = form.types.point(extras.at) and extras.at, form.types.vector(extras.up) and extras.up, extras.fov
  if not at or not up or type(fov) ~= "number" or math.abs(math.rad(fov) - c.yfov) > 1e-9 then return {} end
  local d = { at[1] - c.from[1], at[2] - c.from[2], at[3] - c.from[3] }
  local length, across = vector.length(d), vector.length(vector.cross(d, c.forward))
  if not (across <= 1e-6 * length and vector.length(vector.cross(vector.unit(up), c.up)) < 1) then return {} end
  return { at = at, up = up, fov = fov }
end

--- Cameras by number and by name.
local function cameras(file, note)
  local out, flat = {}, 0
  for _, c in ipairs(file.cameras) do
    if c.yfov == 0 then flat = flat + 1
    else
      local from, d, written = c.from, c.forward, as_written(c)
      local ok, made = pcall(camera.camera, { from = from,
        at = written.at or { from[1] + d[1], from[2] + d[2], from[3] + d[3] }, up = written.up or c.up,
        fov = written.fov or math.min(179, math.deg(c.yfov)) })
      if ok then
        out[#out + 1] = made
        if c.name ~= "" and not out[c.name] then out[c.name] = made end
      end
    end
  end
  if flat > 0 then note("orthographic cameras left out: %d", flat) end
  return out
end

--- The file as lib.gltf_read returns it. `limits`: of ylm.load, or nil.
local function read(values, limits)
  local lib, message, code = library.open("codec", "glTF needs libylm_codec (Debian: libopenexr-dev libpng-dev "
    .. "libjansson-dev, then make): %s")
  if not lib then return nil, message, code end
  local triangles, texels = left("triangles", TRIANGLES, limits), left("texels", TEXELS, limits)
  local file
  file, message, code = lib.gltf_read { path = values.file, file_size = left("file_size", BYTES, limits),
    triangles = math.max(1, triangles), texels = math.max(1, texels),
    scene = math.min(values.scene or 0, 2 ^ 31 - 1), images = texels >= 1,
    groups = values.textures == "mean" and 1 or values.textures ~= "image" and values.textures or 0 }
  if file and file.triangles > triangles then return nil, values.file .. ": more than 0 triangles", "ELIMIT" end
  return file, message, code
end

--- Takes what the file describes from what a scene file may.
local function take(file, fail)
  if not form.budget then return end
  form.budget("triangles", file.triangles, fail)
  form.budget("numbers", 64 * #file.pieces + 7 * #file.lamps + 640 * #file.materials, fail)
  for _, image in ipairs(file.images) do
    if image then form.budget("texels", image.size[1] * image.size[2], fail) end
  end
end

local function build(values, fail, limits)
  if #values.file == 0 or values.file:find "%z" then return fail "file must be a file name" end
  local began = os.clock()
  local file, message, code = check.result("gltf", read(values, limits))
  if not file then return nil, message, code end
  take(file, fail)
  local notes = file.notes
  local function note(sentence, ...) notes[#notes + 1] = sentence:format(...) end
  local materials, lamps
  materials, message, code = material.convert(file, values, note)
  if not materials then return nil, message, code end
  lamps, message, code = lights.convert(file, values, note)
  if not lamps then return nil, message, code end
  local model = { file = values.file, cameras = cameras(file, note), lights = lamps }
  model.camera = model.cameras[1]
  local lost
  model.geometry, lost, code = surfaces(file, materials, lamps, values, note)
  if not model.geometry then return nil, lost, code end
  for _, image in ipairs(file.images) do
    if image then core.image_close(image) end
  end
  local extras = file.extras and json.read(file.extras) or {}
  for _, sky in ipairs(lights.skies(extras.skies, values, note)) do lamps[#lamps + 1] = sky end
  model.background = form.types.colour(extras.background, { min = 0 }) or nil
  for i, sentence in ipairs(notes) do
    notes[i] = text.shown(("%s: %s"):format(values.file:match "[^/]*$", sentence))
  end
  model.notes = #notes > 0 and notes or nil
  model.report = show.report { nodes = file.nodes, pieces = #model.geometry, triangles = file.triangles,
    materials = #file.materials, lights = #lamps, cameras = #model.cameras, lost = lost, notes = notes,
    seconds = os.clock() - began }
  return setmetatable(model, form.defined.gltf.metatable)
end

local form_fields = { { "file", "string", about = ".gltf or .glb, recognised by content" } }
for _, field in ipairs(fields) do form_fields[#form_fields + 1] = field end

gltf.gltf = form.define("gltf", {
  about = "A glTF 2.0 file: geometry, lights, camera, cameras by number and name, report (counts, and notes: "
    .. "sentences about what was left out). A scene takes it by like = gltf { file = }.",
  fields = form_fields,
  build = build,
  metatable = { __tostring = function(m)
    return ("gltf %s: %d pieces of geometry, %d lights"):format(m.file, #m.geometry, #m.lights)
  end },
  example = 'local model = gltf { file = "room.glb", lamp_radius = 0.02 }',
})

require "ylm.describe".object "gltf" {
  about = "Geometry, lights and cameras of a glTF file.",
  fields = {
    { "geometry", "table", "a flat list" },
    { "lights", "table", "a flat list" },
    { "camera", "camera", "the first, or nil" },
    { "cameras", "table", "by number and by name" },
    { "background", "number[]", "of a file that ylm wrote, or nil" },
    { "report", "table", "nodes, pieces, triangles, materials, lights, cameras, seconds, notes; lost: the part of the emitted "
      .. "power that is left out" },
  },
}

--- The options of ylm.load of a glTF file: those of the form, and limits.
gltf.load_options = {
  { "triangles", "number", min = 0, default = TRIANGLES, about = "of the file" },
  { "texels", "number", min = 0, default = TEXELS, about = "of all images together" },
  { "file_size", "number", min = 0, default = BYTES, unit = "bytes", about = "of the file and of each that it names" },
}
for i, field in ipairs(fields) do table.insert(gltf.load_options, i, field) end

--- The model of a file for ylm.load. Or nil, message, code.
function gltf.load(path, options)
  options.file = path
  return build(options, check.fail, options)
end

return gltf
