--- Measured materials in RGL's files, isotropic and anisotropic.

local core = require "ylm.c.core"
local form = require "ylm.form"
local object = require "ylm.material.object"

local rgl = form.define("rgl", {
  about = "A measured material (Dupuy & Jakob 2018), from one of RGL's files of three colours. "
    .. "Files of anisotropic materials need surfaces with texture coordinates.",
  fields = {
    { "file", "path", about = "*_rgb.bsdf" },
    { "rotate", "number", default = 0, unit = "degrees", about = "turns an anisotropic material about the normal" },
  },
  material = function(values)
    local made, message, code = core.material_read("rgl", values.rotate, values.file)
    if not made then return nil, message, code end
    return { values.rotate }, made
  end,
  metatable = object.metatable(),
  build = object.builder "rgl",
  example = 'rgl { file = "satin_gold_rgb.bsdf", rotate = 90 }',
})

return rgl
