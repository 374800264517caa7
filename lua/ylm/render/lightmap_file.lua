--- Files of lightmaps: the picture as .exr, .ktx2 or .png, and the surfaces that read it as glTF or OBJ. For lightmap:save.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local gltf_write = require "ylm.gltf.write"
local image = require "ylm.image"
local ktx2 = require "ylm.image.ktx2"
local library = require "ylm.library"
local wavefront = require "ylm.render.wavefront"

local files = {}

local CLIPPED = 0.02 -- of the picture's texels, at most, are brighter than lit shows
local PI_STOPS = math.log(math.pi) / math.log(2) -- from irradiance to the radiance of white
local KINDS = { exr = true, ktx2 = true, png = true } -- of pictures

--- Endings of files, as messages list them.
files.endings = { "glb", "gltf", "obj", "exr", "ktx2", "png", "html" }

--- Layers of the flow of light along x, y and z.
files.flow = { "flow_x", "flow_y", "flow_z" }

files.options = {
  { "picture", "choice", of = { "exr", "ktx2", "png" }, optional = true,
    about = "beside .glb, .gltf and .obj: half floats ('exr', 'ktx2') or 8 bits and a range; default 'exr', with embed 'png'" },
  { "embed", "boolean", default = false, about = ".glb, .gltf: the picture is in the file, as an image of glTF" },
  { "lit", "boolean", default = false,
    about = ".glb, .gltf: any viewer shows the light: materials are albedo times a further picture of 8 bits in the file "
      .. "(KHR_materials_unlit)" },
  { "exposure", "exposure", default = "auto", unit = "stops", about = "of lit and .html; 'auto': as image:exposure has it, or "
    .. "less, until at most 2 % of the picture are white" },
  { "title", "string", optional = true, about = ".html; default the scene's name" },
  { "limit", "number", min = 1, default = 32e6, unit = "bytes", about = ".html: a larger file is refused" },
}

-- Pictures ---------------------------------------------------------------------------------------

--- An image of the picture with these layers, of irradiance, charts and the flow. Or nil, message, code.
function files.picture(m, map, layers)
  local out, message, code = image.image { size = { m.stats.width, m.stats.height }, layers = layers }
  if not out then return nil, message, code end
  local has = {}
  for _, layer in ipairs(layers) do has[layer[1]] = true end
  local done
  done, message, code = check.result("image", m.lib.map_picture(map, out:layer "irradiance",
    has.charts and out:layer "charts" or nil))
  if not done then return nil, message, code end
  for axis, name in ipairs(files.flow) do if has[name] then m.lib.map_flow(map, axis, out:layer(name)) end end
  return out
end

--- The bytes of a .png of the picture, and its range; or nil, message, code.
local function rgbm_of(m, map)
  local codec, message, code = image.codec()
  if not codec then return nil, message, code end
  local out
  out, message, code = image.image { size = { m.stats.width, m.stats.height }, layers = { { "rgbm", 4 } } }
  if not out then return nil, message, code end
  local range = m.lib.map_rgbm(map, out:layer "rgbm")
  local bytes
  bytes, message, code = codec.image_png(out, "linear", 0)
  if not bytes then return nil, message, code end
  return bytes, range
end

--- Stops under which a picture of irradiance is shown, of albedos about a half; `asked` are those of radiance.
local function stops_of(picture, asked)
  if asked ~= "auto" then return asked - PI_STOPS end
  local stops = picture:exposure() + 1
  while select(2, picture:exposure { stops = stops }).white > CLIPPED do stops = stops - 0.25 end
  return stops
end

--- The bytes of a .png of the light as it is shown, and the stops of radiance; or nil, message, code.
local function shown_of(m, map, o)
  local codec, message, code = image.codec()
  if not codec then return nil, message, code end
  local picture
  picture, message, code = files.picture(m, map, { { "irradiance", 3 } })
  if not picture then return nil, message, code end
  local stops = stops_of(picture, o.exposure)
  local bytes
  bytes, message, code = codec.image_png(picture, "srgb", stops)
  if not bytes then return nil, message, code end
  return bytes, stops + PI_STOPS
end

--- Saves a picture of irradiance as KTX 2.0; true, or nil, message, code.
local function save_ktx2(picture, path)
  local E, size, channels = picture:layer "irradiance", picture.size, {}
  for c = 1, 3 do channels[c] = E[{ {}, {}, c }] end
  channels[4] = array.zeros({ size[2], size[1] }, "float") + 1
  local data = core.array_convert(array.stack(channels, 3), "float16"):bytes()
  local bytes = ktx2.file(size[1], size[2], 0, data, { { "KTXwriter", "ylm " .. (core.info()) } })
  return check.result("save", core.file_save(path, bytes))
end

--- Writes the picture as STEM.exr or STEM.ktx2, with the flow beside it, or STEM.png, and adds their names to facts. True; or
-- nil, message, code.
local function save_picture(m, map, stem, kind, facts)
  local function add(name) facts.files[#facts.files + 1] = name:match "[^/]*$" end
  if kind == "png" then
    local bytes, range, code = rgbm_of(m, map)
    if not bytes then return nil, range, code end
    facts.range = range
    add(stem .. ".png")
    return check.result("save", core.file_save(stem .. ".png", bytes))
  end
  for i, suffix in ipairs(m.directional and { "", "_x", "_y", "_z" } or { "" }) do
    local picture, message, code = files.picture(m, map, { { "irradiance", 3 } })
    if picture and i > 1 then m.lib.map_flow(map, i - 1, picture:layer "irradiance") end
    local path, done = stem .. suffix .. "." .. kind, picture
    if picture and kind == "ktx2" then done, message, code = save_ktx2(picture, path)
    elseif picture then done, message, code = picture:save(path, { bits = 16 }) end
    if not done then return nil, message, code end
    add(path)
  end
  return true
end

-- glTF -------------------------------------------------------------------------------------------

--- Saves a scene of the pieces; lamps stay where an engine is to draw them.
local function save_gltf(m, map, pieces, path, o, facts)
  local second, inside = {}, {}
  for _, piece in ipairs(pieces) do
    piece.sides, second[piece] = "front", piece.uvs
  end
  local lights = m.quantity == "indirect" and m.scene.lights or {}
  facts.lamps = #lights
  if o.embed then
    local bytes, range, code = rgbm_of(m, map)
    if not bytes then return nil, range, code end
    inside.map, facts.range = bytes, range
  end
  if o.lit then
    local bytes, stops, code = shown_of(m, map, o)
    if not bytes then return nil, stops, code end
    inside.shown, facts.exposure = bytes, stops
  end
  local scene = { name = m.scene.name, camera = m.scene.camera, cameras = m.scene.cameras, background = m.scene.background,
    sky_is_seen = m.scene.sky_is_seen, geometry = pieces, lights = lights }
  local about = { "quantity", m.quantity, "unit", "W m^-2", "coordinates", 1 }
  local function say(key, x) if x then about[#about + 1], about[#about + 2] = key, x end end
  say("file", facts.files[1])
  say("flow", m.directional and { facts.files[2], facts.files[3], facts.files[4] })
  say("range", facts.range)
  say("exposure", facts.exposure)
  local ok, message, code = gltf_write.save(scene, path, nil, { second = second, about = about, inside = inside })
  if not ok then return nil, message, code end
  table.insert(facts.files, 1, path:match "[^/]*$")
  return true
end

-- Pages ------------------------------------------------------------------------------------------

--- Saves a page; true, or nil, message, code.
local function save_page(m, map, path, o, facts)
  local picture, message, code = files.picture(m, map, { { "irradiance", 3 }, { "charts", 1 } })
  if not picture then return nil, message, code end
  local light = { charts = picture:layer "charts" }
  light.picture, light.range, code = rgbm_of(m, map)
  if not light.picture then return nil, light.range, code end
  light.errors, light.densities, code = check.result("save", m.lib.map_charts(map))
  if not light.errors then return nil, light.densities, code end
  light.pieces, message, code = map:pieces()
  if not light.pieces then return nil, message, code end
  facts.range, facts.exposure = light.range, stops_of(picture, o.exposure) + PI_STOPS
  facts.bytes, message, code = library.later["ylm.page.lightmap"](m, path, light,
    { title = o.title, exposure = facts.exposure, limit = o.limit })
  if not facts.bytes then return nil, message, code end
  facts.files[1] = path:match "[^/]*$"
  return true
end

-- The whole --------------------------------------------------------------------------------------

--- The ending of a path, in small letters, if there are files with it.
local function ending_of(path)
  local ending = type(path) == "string" and not path:find "%z" and path:lower():match "%.(%w+)$"
  for _, known in ipairs(files.endings) do if ending == known then return ending end end
end

--- The kind of the picture of a file with this ending and options; or nil and why they do not go together. spelt(name, value): an
-- option as its user writes it.
function files.kind(ending, o, directional, spelt)
  if o.picture and not KINDS[o.picture] then
    return nil, ("%s is exr, ktx2 or png, got '%s'"):format(spelt "picture", o.picture)
  end
  if (o.embed or o.lit) and ending ~= "glb" and ending ~= "gltf" then
    return nil, ("%s is of .glb and .gltf files, not of .%s"):format(spelt(o.embed and "embed" or "lit"), ending)
  end
  if o.embed and o.picture and o.picture ~= "png" then
    return nil, ("%s wants %s: glTF holds no pictures of floats"):format(spelt "embed", spelt("picture", "png"))
  end
  local kind = KINDS[ending] and ending or o.picture or o.embed and "png" or "exr"
  if directional and kind == "png" then
    return nil, ("%s wants %s: the flow of light has signs, and .png none"):format(spelt "directional", spelt("picture", "exr"))
  end
  return kind
end

local function as_field(name, value) return value and ("%s = '%s'"):format(name, value) or name end

--- Raises where a path and options do not go together; the ending and the kind of the picture.
local function settle(m, path, o)
  local ending = ending_of(path)
  if not ending then
    return check.bad(1, "save", "a file name that ends in .glb, .gltf, .obj, .exr, .ktx2, .png or .html expected, got %s",
      check.describe(path))
  end
  local kind, why = files.kind(ending, o, m.directional, as_field)
  if not kind then return check.bad(2, "save", "%s", why) end
  return ending, kind
end

--- lightmap:save.
function files.save(m, map, path, given)
  local o = form.options(2, "save", files.options, given)
  local ending, kind = settle(m, path, o)
  local stem, facts = path:gsub("%.%w+$", ""), { files = {} }
  local done, message, code
  if ending == "html" then
    done, message, code = save_page(m, map, path, o, facts)
    if not done then return nil, message, code end
    return true, facts
  end
  if not o.embed then
    done, message, code = save_picture(m, map, stem, kind, facts)
    if not done then return nil, message, code end
    if ending == kind then return true, facts end
  end
  local pieces
  pieces, message, code = map:pieces()
  if not pieces then return nil, message, code end
  if ending == "obj" then
    done, message, code = wavefront.save(pieces, path)
    if done then table.insert(facts.files, 1, path:match "[^/]*$") end
  else
    done, message, code = save_gltf(m, map, pieces, path, o, facts)
  end
  if not done then return nil, message, code end
  return true, facts
end

return files
