--- Files of materials: which kind a file is of, material:save.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local object = require "ylm.material.object"
local texture = require "ylm.material.texture"

local file = {}

--- The kind of material in a file, by its first 16 bytes or its name; nil: none.
function file.kind_of(path, head)
  if head:sub(1, 11) == "tensor_file" or path:lower():find "%.bsdf$" then return "rgl" end
  if head:find "^Z%z%z%zZ%z%z%z" or path:lower():find "%.binary$" then return "merl" end
end

--- The material in a file, of which ylm.file.kind_of knows that it holds one; nil, message, code.
function file.load(path)
  local head, message, code = core.file_head(path)
  if not head then return nil, message, code end
  return form.defined[file.kind_of(path, head)].construct { file = path }
end

--- The contents of a material's tables: { kind, isotropic, albedo, .. numbers }; nil, message, code.
function file.facts(m)
  local made, message, code = object.made("facts", m)
  if not made then return nil, message, code end
  local facts = core.material_facts(made)
  facts.kind, facts.isotropic = form.kind(m), core.material_isotropic(made)
  facts.albedo = { core.material_albedo(made) }
  return facts
end

describe "material:save" {
  about = "Writes an isotropic material as one of MERL's files, of 34,992,012 bytes: its f at the centres of the bins.",
  arguments = { { "path", "string", "ends in .binary" } },
  returns = { { "ok", "boolean", "true" } },
  errors = "raises on another ending, and on a material that is anisotropic or has a texture; "
    .. "nil, message, code where the file cannot be written",
  example = [[
local name = os.tmpname() .. ".binary"
assert(ylm.matte { albedo = 0.5 }:save(name))
assert(tostring(ylm.load(name)):find "^ylm%.merl ")
os.remove(name)]],
  source = "Matusik et al. 2003, A Data-Driven Reflectance Model",
}
local function save(m, path)
  if not object.is(m) then
    return check.fail("save: a material expected before the colon, got %s", check.describe(m))
  end
  if type(path) ~= "string" or not path:lower():find "%.binary$" or path:find "%z" then
    return check.bad(1, "save", "a file name that ends in .binary expected, got %s", check.describe(path))
  end
  if texture.of(m) then return check.fail("save: a texture is no part of MERL's files, and this material has one") end
  local made, message, code = object.made("save", m)
  if not made then return nil, message, code end
  return check.result("save", core.material_write(made, path))
end
object.methods.save = memory.public(save)

return file
