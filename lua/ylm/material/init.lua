--- Materials: data only, no scene knows them and they know no scene.
--
-- A kind has a form in a file of its name; the form's field `material` returns the numbers that describe one, as the C file
-- of that name (csrc/material) takes them.

local core = require "ylm.c.core"
local form = require "ylm.form"
local object = require "ylm.material.object"
local texture = require "ylm.material.texture"

require "ylm.material.methods"
require "ylm.material.shape"
require "ylm.material.table"

require "ylm.memory".publish(object.methods)

local material = {}

--- The names of all kinds.
material.kinds = core.material_kinds()
for _, name in ipairs(material.kinds) do material[name] = require("ylm.material." .. name) end

require "ylm.material.file" -- material:save

--- The material of geometry that names none.
material.default = material.matte {}

--- The numbers that describe a material.
material.numbers = object.numbers

--- The material as C asks it what it does with light; nil, message, code. `name`: the function that raises.
material.object = object.made

--- Does it send more light into some directions than into others?
function material.glossy(m) return form.kind(m) ~= "matte" end

--- The words for what makes a material, with its object, look different when it is turned about the normal; nil: nothing.
function material.direction(m, made)
  if core.material_isotropic(made) then return nil end
  local kind = form.kind(m)
  return form.defined[kind].directed or "an anisotropic " .. kind
end

--- The part of light from everywhere that it reflects, { r, g, b }, of a texture its mean; nil, message, code.
function material.albedo(name, m)
  local made, message, code = object.made(name, m)
  if not made then return nil, message, code end
  local c, mean = { core.material_albedo(made) }, texture.mean(texture.of(m))
  return { c[1] * mean[1], c[2] * mean[2], c[3] * mean[3] }
end

--- The albedo at a mesh's vertices, float [n][3], where a texture or colours vary it; nothing where it is the same
-- everywhere; nil, message, code. `m`: nil for the material of geometry that names none.
function material.at_vertices(name, m, mesh)
  m = m or material.default
  local made, message, code = object.made(name, m)
  if not made then return nil, message, code end
  return core.mesh_albedo(mesh, texture.of(m) or false, core.material_albedo(made))
end

--- The texture that multiplies what a material reflects, or nil.
material.texture = texture.of

return material
