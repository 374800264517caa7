--- Measured isotropic materials in MERL's files.

local core = require "ylm.c.core"
local form = require "ylm.form"
local object = require "ylm.material.object"

local merl = form.define("merl", {
  about = "A measured isotropic material (Matusik et al. 2003), from one of MERL's files, or one that material:save wrote.",
  fields = {
    { "file", "path", about = ".binary, 35 MB; ylm keeps 23 MB of memory" },
    { "interpolation", "choice", of = { "linear", "nearest" }, default = "linear",
      about = "between the centres of bins, or the bin that holds the directions, as MERL's own code looks up" },
  },
  material = function(values)
    local number = values.interpolation == "linear" and 1 or 0
    local made, message, code = core.material_read("merl", number, values.file)
    if not made then return nil, message, code end
    return { number }, made
  end,
  metatable = object.metatable(),
  build = object.builder "merl",
  example = 'merl { file = "gold-metallic-paint.binary", interpolation = "nearest" }',
})

return merl
