--- Matte surfaces.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local object = require "ylm.material.object"
local texture = require "ylm.material.texture"

--- A colour, or an image.
function form.types.albedo(x, field)
  if core.type(x) == "ylm.image" then return x end
  local good, wanted = form.types.colour(x, field)
  if good then return good end
  return nil, wanted .. ", or a ylm.image"
end

--- The texture that a matte surface is given, or nothing; fails, or nil, message, code.
local function texture_of(values, fail)
  local given, made, message, code = core.type(values.albedo) == "ylm.image"
  if given and values.file then return fail "give an image as albedo, or file, not both" end
  if given then
    made, message, code = texture.of_image(values.albedo)
    if not made and code ~= "ENOMEM" then return fail("albedo: " .. message) end
  elseif values.file then
    if #values.file == 0 or values.file:find "%z" then return fail "file must be a file name" end
    made, message, code = texture.of_file(values.file, fail)
  end
  return made, message, code
end

local build = object.builder "matte"

local matte = form.define("matte", {
  shelf = "everyday",
  about = "A matte (Lambertian) surface: light leaves it alike in every direction. An image is a texture: the mesh needs "
    .. "texture coordinates, at which it is looked up.",
  fields = {
    { "albedo", "albedo", min = 0, max = 1, optional = true,
      about = "reflected over incident flux: a number or linear Rec. 709 {r, g, b} (default 0.5, with file 1), or a ylm.image "
        .. "of numbers from 0 to 1" },
    { "file", "string", optional = true, about = "an image file (.png, .exr, .hdr, .pfm), which albedo multiplies" },
  },
  build = function(values, fail)
    local made, message, code = texture_of(values, fail)
    if message then return check.result("matte", nil, message, code) end
    if core.type(values.albedo) == "ylm.image" then values.albedo = { 1, 1, 1 } end
    values.albedo = values.albedo or (made and { 1, 1, 1 } or { 0.5, 0.5, 0.5 })
    return texture.attach(made, build(values, fail))
  end,
  material = function(m) return m.albedo end,
  metatable = object.metatable(),
  example = "matte { albedo = { 0.63, 0.06, 0.05 } }",
})

return matte
