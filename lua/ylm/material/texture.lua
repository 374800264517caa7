--- Images as textures: numbers from 0 to 1, looked up at a mesh's texture coordinates, that multiply what a material
-- reflects.

local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"

local texture = {}

local TEXELS, BYTES = 2 ^ 26, 2 ^ 30 -- of one image, where no scene file's limits are narrower

--- A texture of the first layer of an image; nil, message, code. `wraps`: of u and of v, "repeat", "mirror" or "clamp"; or nil.
function texture.of_image(image, wraps)
  if not memory.pcall(core.image_info, image) then return nil, "the image has been closed", "ECLOSED" end
  local layer = core.image_layer(image)
  if not layer then return nil, "the image has no layers", "EINVAL" end
  return core.texture_create(layer, wraps and wraps[1], wraps and wraps[2])
end

--- A texture of an image file, and its texels count in a scene file; nil, message, code.
function texture.of_file(path, fail)
  local lib, message, code = require "ylm.image".codec()
  if not lib then return nil, message, code end
  local texels = math.min(TEXELS, form.budget and form.budget "texels" or TEXELS)
  local image
  image, message, code = lib.image_read(path, false, 4 * texels, form.budget and form.budget "file_size" or BYTES)
  if not image then return nil, message, code end
  local width, height = core.image_info(image)
  if form.budget then form.budget("texels", width * height, fail) end
  local made
  made, message, code = texture.of_image(image)
  core.image_close(image)
  if not made then return nil, path .. ": " .. message, code == "ENOMEM" and code or "EFORMAT" end
  return made
end

--- Gives a new material a texture, if there is one; passes on its other arguments, a material or nil, message, code.
function texture.attach(made, material, ...)
  if material then core.own(material).texture = made end
  return material, ...
end

--- The texture of a material, or nil.
function texture.of(material) return core.owned(material, "texture") end

--- The texture's mean, { r, g, b }; of nil 1.
function texture.mean(made)
  if not made then return { 1, 1, 1 } end
  return { core.texture_mean(made) }
end

return texture
