--- Materials of glTF files as materials of ylm.

local form = require "ylm.form"
local ggx = require "ylm.material.ggx"
local json = require "ylm.gltf.json"
local matte = require "ylm.material.matte"
local texture = require "ylm.material.texture"

local material = { none = { occludes = function() return true end } } -- of pieces without one

local function mix(a, b, t) return a + (b - a) * t end

--- The form of a material by the factors that the file gives.
local function by_factors(m)
  local base, metal, dull = { m.base[1], m.base[2], m.base[3] }, m.metallic, m.roughness
  if m.unlit or metal == 0 and dull == 1 then return matte { albedo = base } end
  local f0, below, alpha = {}, {}, math.max(1e-3, dull * dull)
  for i = 1, 3 do
    f0[i] = math.min(1, mix(m.f0, base[i], metal))
    below[i] = (1 - metal) * base[i]
  end
  return ggx { alpha = alpha, f0 = f0, base = below }
end

--- Equal as 32-bit floats?
local function near(a, b) return math.abs(a - b) <= 1e-6 * math.max(1, math.abs(b)) end

--- The material that ylm has written into the file, where the factors are still those that it wrote; else nil.
local function by_extras(m)
  local extras = m.extras and json.read(m.extras)
  local definition = type(extras) == "table" and type(extras.kind) == "string" and form.defined[extras.kind]
  if not definition or not definition.material or definition.trusted then return nil end
  for i, key in ipairs { "r", "g", "b" } do
    if not near(m.base[i], tonumber(extras[key]) or -1) then return nil end
  end
  local given = {}
  for _, field in ipairs(definition.fields) do
    if field[1] ~= "file" then given[field[1]] = extras[field[1]] end
  end
  local ok, made = pcall(definition.construct, given)
  return ok and made or nil
end

--- The texture of the image of a material; each image becomes one texture for each way in which it goes on. Or nil,
-- message, code.
local function texture_of(m, images, textures)
  local image = m.base_image and images[m.base_image]
  if not image then return nil end
  local key = ("%d %s %s"):format(m.base_image, m.base_wrap[1], m.base_wrap[2])
  if not textures[key] then
    local made, message, code = texture.of_image(image, m.base_wrap)
    if not made then return nil, message, code end
    textures[key] = made
  end
  return textures[key]
end

--- f(tint) -> the material of factors times a colour, the same one for the same colour.
local function tinter(m)
  local made = {}
  return function(tint)
    local key = ("%.9g %.9g %.9g"):format(tint[1], tint[2], tint[3])
    if not made[key] then
      local copy = {}
      for name, x in pairs(m) do copy[name] = x end
      copy.base = { m.base[1] * tint[1], m.base[2] * tint[2], m.base[3] * tint[3], m.base[4] }
      made[key] = by_factors(copy)
    end
    return made[key]
  end
end

--- Materials of the file: a list of { material =, emission =, left_out = }, occludes(alpha of the piece), plain() and
-- tinted(colour), its material without and instead of its texture; note(sentence, ...) takes what is
-- lost. Or nil, message, code.
function material.convert(file, o, note)
  local out, textures, unlit, tinted = {}, {}, 0, 0
  for i, m in ipairs(file.materials) do
    local image, message, code
    if o.textures == "image" then image, message, code = texture_of(m, file.images, textures) end
    if message then return nil, message, code end
    local made
    made, message, code = by_extras(m)
    if not made then made, message, code = by_factors(m) end
    if not made then return nil, message, code end
    texture.attach(image, made)
    if m.unlit then unlit = unlit + 1 end
    if image and form.kind(made) == "ggx" and m.metallic < 1 then tinted = tinted + 1 end
    out[i] = { material = made, emission = m.emission, both_sides = m.both_sides,
      plain = function() return by_factors(m) end, -- for meshes without texture coordinates
      tinted = tinter(m), emission_image = m.emission_image, emission_wrap = m.emission_wrap,
      shares_uvs = not m.base_image or m.emission_uvs,
      occludes = function(alpha) return not (m.alpha == "blend" and m.base[4] * alpha < 0.5) end,
      left_out = m.alpha == "mask" and m.base[4] < m.cutoff }
  end
  if unlit > 0 then note("unlit materials that became matte: %d", unlit) end
  if tinted > 0 then note("textures of coats, which colour their highlights too: %d", tinted) end
  return out
end

return material
