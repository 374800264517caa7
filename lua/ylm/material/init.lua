--- Materials: data only, no scene knows them and they know no scene.
--
-- A kind has a form in a file of its name; the form's field `material` returns the numbers that describe one, as the C file
-- of that name (csrc/material) takes them.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"

local material = {}

--- The names of all kinds.
material.kinds = core.material_kinds()
for _, name in ipairs(material.kinds) do material[name] = require("ylm.material." .. name) end

--- The material of geometry that names none.
material.default = material.matte {}

--- The numbers that describe a material.
function material.numbers(m) return form.defined[form.kind(m)].material(m) end

--- The material as C asks it what it does with light; nil, message, code. `name`: the function that raises.
function material.object(name, m)
  return check.result(name, core.material_create(form.kind(m), material.numbers(m)))
end

--- The part of light from everywhere that it reflects, { r, g, b }; nil, message, code.
function material.albedo(name, m)
  local object, message, code = material.object(name, m)
  if not object then return nil, message, code end
  return { core.material_albedo(object) }
end

return material
