--- Scenes as glTF files: scene:save.
--
-- JSON with keys in a fixed order, and one buffer. `extras.ylm` of lights, materials and nodes keeps what glTF lacks; the
-- reader believes it where what glTF says is still the same.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local json = require "ylm.gltf.json"
local material = require "ylm.material"
local pack = require "ylm.light.pack"
local text = require "ylm.text"
local vector = require "ylm.vector"
local warning = require "ylm.warning"

local write = {}

local LAMPS = 20000
local SAMPLER = json.object("magFilter", 9729, "minFilter", 9729, "wrapS", 33071, "wrapT", 33071) -- linear, to the edge

-- The file while it is written -------------------------------------------------------------

local function new()
  return { data = {}, size = 0, views = {}, accessors = {}, meshes = {}, nodes = {}, materials = {}, lights = {}, cameras = {},
    made = {}, used = {}, left_out = {}, skies = {}, second = {}, images = {}, textures = {} }
end

local function add(list, x)
  list[#list + 1] = x
  return #list - 1
end

--- Counts what is left out or simpler, for the notes.
local function leave_out(w, what)
  if not w.left_out[what] then w.left_out[#w.left_out + 1] = what end
  w.left_out[what] = (w.left_out[what] or 0) + 1
end

local function extras(...)
  local object = json.object(...)
  return #object.keys > 0 and json.object("ylm", object) or nil
end

--- The number of a view of these bytes, aligned to 4.
local function view(w, bytes, target)
  local n = add(w.views, json.object("buffer", 0, "byteOffset", w.size, "byteLength", #bytes, "target", target))
  local pad = ("\0"):rep(-#bytes % 4)
  w.data[#w.data + 1] = bytes .. pad
  w.size = w.size + #bytes + #pad
  return n
end

--- The number of an accessor of the rows of an array.
local function accessor(w, array, kind, component, target, lo, hi)
  return add(w.accessors, json.object("bufferView", view(w, array:bytes(), target), "componentType", component, "count",
    kind == "SCALAR" and #array * 3 or #array, "type", kind, "min", lo, "max", hi))
end

-- Materials ------------------------------------------------------------------------------------

local function pbr(base, metallic, roughness)
  return json.object("baseColorFactor", { base[1], base[2], base[3], 1 }, "metallicFactor", metallic,
    "roughnessFactor", roughness)
end

--- Base colour and metallic of a ggx: f0 = 0.04 (1 - m) + m b, base = (1 - m) b, by the channel with the largest base.
local function ggx_factors(m)
  local most = 1
  for i = 2, 3 do if m.base[i] > m.base[most] then most = i end end
  if m.base[most] == 0 then return { m.f0[1], m.f0[2], m.f0[3] }, 1 end
  local sum, base = m.f0[most] + m.base[most], m.base[most]
  local x = (sum - math.sqrt(math.max(0, sum * sum - 0.16 * base))) / 0.08
  x = math.max(0, math.min(1, x))
  local b = {}
  for i = 1, 3 do b[i] = math.max(0, math.min(1, m.f0[i] + m.base[i] - 0.04 * x)) end
  return b, 1 - x
end

--- The roughness alpha of GGX microfacets nearest to Phong's lobe of exponent n. The half vector turns by half of what the
-- mirror direction does, so alpha^2 is about 1 / (2 n) of the 2 / (n + 2) of Walter et al. 2007 for the lobe of half vectors;
-- 2.5 is the factor of n at which the lobes times the cosine differ least (root mean square over directions, at 0, 30, 45 and
-- 60 degrees): by 0.40 to 0.43 of the lobe from n = 5 on, with factor 1 by 0.60.
local function phong_alpha(n) return math.sqrt(2 / (2.5 * n + 2)) end

--- Plain values of a material's fields, to be read back.
local function fields_of(m, kind, base)
  local list = { "kind", kind, "r", base[1], "g", base[2], "b", base[3] }
  for _, field in ipairs(form.defined[kind].fields) do
    local x = m[field[1]]
    if type(x) == "table" and type(x[1]) == "number" then
      local plain = {}
      for i = 1, #x do plain[i] = x[i] end
      x = plain
    end
    if type(x) == "number" or type(x) == "boolean" or type(x) == "string" or type(x) == "table" and #x > 0 then
      list[#list + 1], list[#list + 2] = field[1], x
    end
  end
  return extras((table.unpack or unpack)(list)) -- luacheck: ignore 113
end

--- The object of a material, without what pieces decide; or nil, message, code.
local function describe_material(w, m)
  local kind = form.kind(m)
  local mean, message, code = material.albedo("save", m)
  if not mean then return nil, message, code end
  if material.texture(m) then leave_out(w, "textures, written as their mean") end
  if kind == "matte" then return { pbr(mean, 0, 1) } end
  if kind == "ggx" then
    local base, metallic = ggx_factors(m)
    local alpha = type(m.alpha) == "table" and (m.alpha[1] + m.alpha[2]) / 2 or m.alpha
    return { pbr(base, metallic, math.sqrt(alpha)), fields_of(m, kind, base) }
  end
  if kind == "phong" then
    leave_out(w, "materials of kind phong, written as their nearest ggx")
    local base, metallic = ggx_factors { f0 = m.specular, base = m.base }
    return { pbr(base, metallic, math.sqrt(phong_alpha(m.exponent))), fields_of(m, kind, base) }
  end
  leave_out(w, ("materials of kind %s, written as matte"):format(kind))
  return { pbr(mean, 0, 1), not form.defined[kind].trusted and fields_of(m, kind, mean) or nil }
end

--- A material that shows its albedo times the light of a picture, which its second coordinates read.
local function lit_material(w, m, both)
  local mean, message, code = { 0.5, 0.5, 0.5 }, nil, nil
  if m then mean, message, code = material.albedo("save", m) end
  if not mean then return nil, message, code end
  w.used.KHR_materials_unlit = true
  return json.object("pbrMetallicRoughness", json.object("baseColorFactor", { mean[1], mean[2], mean[3], 1 },
    "baseColorTexture", json.object("index", w.shown, "texCoord", 1), "metallicFactor", 0, "roughnessFactor", 1),
    "doubleSided", both or nil, "extensions", json.object("KHR_materials_unlit", json.object()))
end

--- The number of the material of a piece; nil for none; or nil, message, code.
local function material_of(w, m, both)
  if not m and not w.shown then return nil end
  local made = w.made[m or w] or {}
  w.made[m or w] = made
  if made[both] then return made[both] end
  if w.shown then
    local lit, message, code = lit_material(w, m, both)
    if not lit then return nil, message, code end
    made[both] = add(w.materials, lit)
    return made[both]
  end
  local one, message, code = describe_material(w, m)
  if not one then return nil, message, code end
  made[both] = add(w.materials, json.object("pbrMetallicRoughness", one[1], "doubleSided", both or nil, "extras", one[2]))
  return made[both]
end

--- The number of a new material that emits.
local function emitter(w, radiance, more)
  local strength = math.max(radiance[1], radiance[2], radiance[3])
  w.used.KHR_materials_emissive_strength = true
  local c = { 0, 0, 0 }
  for i = 1, 3 do c[i] = strength > 0 and radiance[i] / strength or 0 end
  return add(w.materials, json.object("pbrMetallicRoughness", pbr({ 0, 0, 0 }, 0, 1), "emissiveFactor", c, "doubleSided", true,
    "extensions", json.object("KHR_materials_emissive_strength", json.object("emissiveStrength", strength)), "extras", more))
end

-- Surfaces --------------------------------------------------------------------------------------

--- The number of a mesh of arrays; `second`: texture coordinates beside the first.
local function add_mesh(w, positions, normals, uvs, colours, triangles, bounds, number, second)
  local attributes = json.object("POSITION", accessor(w, positions, "VEC3", 5126, 34962, bounds[1], bounds[2]),
    "NORMAL", normals and accessor(w, normals, "VEC3", 5126, 34962),
    "TEXCOORD_0", uvs and accessor(w, uvs, "VEC2", 5126, 34962),
    "TEXCOORD_1", second and accessor(w, second, "VEC2", 5126, 34962),
    "COLOR_0", colours and accessor(w, colours, "VEC3", 5126, 34962))
  local indices = accessor(w, triangles, "SCALAR", 5125, 34963)
  return add(w.meshes, json.object("primitives", { json.object("attributes", attributes, "indices", indices, "material",
    number) }))
end

--- Texture coordinates as glTF has them: v downwards.
local function downwards(uvs) return uvs and core.array_convert(uvs * { 1, -1 } + { 0, 1 }, "float") end

local function add_piece(w, piece)
  local mesh = piece.mesh
  if #mesh == 0 then return true end
  local number, message, code = material_of(w, piece.material, piece.sides == "both")
  if message then return nil, message, code end
  local uvs, second = downwards(mesh:uvs()), downwards(w.second[piece])
  if second and not uvs then uvs = second end -- glTF numbers them without gaps
  local positions, bounds, origin = mesh:vertices(), mesh.bounds, nil
  if positions.dtype == "double" then -- far from 0: relative to the lower corner, which the node has
    origin = bounds[1]
    positions = core.array_convert(positions - origin, "float")
    bounds = { { 0, 0, 0 }, positions:max(1):totable() }
  end
  local made = add_mesh(w, positions, mesh:normals(), uvs, mesh:colours(),
    core.array_convert(mesh:triangles() - 1, "int32"), bounds, number, second)
  local occludes
  if piece.occludes == false then occludes = false end
  add(w.nodes, json.object("name", piece.name, "translation", origin, "mesh", made, "extras",
    extras("occludes", occludes, "sides", piece.sides ~= "both" and piece.sides or nil)))
  return true
end

-- Lamps ------------------------------------------------------------------------------------------

--- Largest channel, and the colour that it multiplies; nothing where a channel is negative.
local function split(c)
  local most = math.max(c[1], c[2], c[3])
  if math.min(c[1], c[2], c[3]) < 0 then return nil end
  if most == 0 then return 0, { 1, 1, 1 } end
  return most, { c[1] / most, c[2] / most, c[3] / most }
end

--- The quaternion of the rotation that turns the axes x, y, z into these unit vectors.
local function quaternion(x, y, z)
  local trace = x[1] + y[2] + z[3]
  local s
  if trace > 0 then
    s = 2 * math.sqrt(1 + trace)
    return { (y[3] - z[2]) / s, (z[1] - x[3]) / s, (x[2] - y[1]) / s, s / 4 }
  elseif x[1] > y[2] and x[1] > z[3] then
    s = 2 * math.sqrt(1 + x[1] - y[2] - z[3])
    return { s / 4, (x[2] + y[1]) / s, (z[1] + x[3]) / s, (y[3] - z[2]) / s }
  elseif y[2] > z[3] then
    s = 2 * math.sqrt(1 + y[2] - x[1] - z[3])
    return { (x[2] + y[1]) / s, s / 4, (y[3] + z[2]) / s, (z[1] - x[3]) / s }
  end
  s = 2 * math.sqrt(1 + z[3] - x[1] - y[2])
  return { (z[1] + x[3]) / s, (y[3] + z[2]) / s, s / 4, (x[2] - y[1]) / s }
end

--- The rotation after which -z points along `d`, and y towards `up` as far as it can.
local function rotation_of(d, up)
  local z = vector.unit { -d[1], -d[2], -d[3] }
  up = up or (math.abs(z[2]) < 0.9 and { 0, 1, 0 } or { 1, 0, 0 })
  local x = vector.unit(vector.cross(up, z))
  return quaternion(x, vector.cross(z, x), z)
end

local function fan(n)
  local list = {}
  for i = 1, n - 2 do list[i] = { 0, i, i + 1 } end
  return list
end

--- Methods of the file that forms of lights write themselves with: `gltf(w, l)`.
local lamps = { leave_out = leave_out, object = json.object }
lamps.__index = lamps

--- A lamp of KHR_lights_punctual: { type =, at = nil or a place, along = nil or its axis, light = colour, scale = 1: of it,
-- cone = nil or { inner, outer } in radians, extras = { name, value, .. } }. Or nothing, where its light is negative.
function lamps.punctual(w, lamp)
  local most, colour = split(lamp.light)
  if not most then return leave_out(w, "lamps of negative radiance, left out") end
  local cone = lamp.cone and json.object("innerConeAngle", lamp.cone[1], "outerConeAngle", lamp.cone[2])
  w.used.KHR_lights_punctual = true
  local n = add(w.lights, json.object("type", lamp.type, "color", colour, "intensity", (lamp.scale or 1) * most, "spot", cone,
    "extras", extras((table.unpack or unpack)(lamp.extras)))) -- luacheck: ignore 113
  add(w.nodes, json.object("translation", lamp.at, "rotation", lamp.along and rotation_of(lamp.along), "extensions",
    json.object("KHR_lights_punctual", json.object("light", n))))
end

--- A sphere { at =, radius =, radiance = }, as a point of its intensity.
function lamps.sphere(w, l)
  local most = split(l.radiance)
  if most and (most == 0 or l.radius == 0) then return leave_out(w, "dark lamps, left out") end
  lamps.punctual(w, { type = "point", at = l.at, light = l.radiance, scale = math.pi * l.radius * l.radius,
    extras = { "radius", l.radius, "radiance", l.radiance } })
end

--- A flat light of these corners as a surface that emits; its fields are in extras.
function lamps.flat(w, l, vertices)
  if not split(l.radiance) then return leave_out(w, "lamps of negative radiance, left out") end
  local kind, number = form.kind(l), emitter(w, l.radiance)
  local positions = require "ylm.array".array(vertices, "float")
  local lo, hi = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  for i = 1, #vertices do
    for a = 1, 3 do
      local x = positions:get(i, a)
      lo[a], hi[a] = math.min(lo[a], x), math.max(hi[a], x)
    end
  end
  local triangles = require "ylm.array".array(fan(#vertices), "int32")
  local mesh = add_mesh(w, positions, nil, nil, nil, triangles, { lo, hi }, number)
  local list = { "light", kind }
  for _, field in ipairs(form.defined[kind].fields) do
    if l[field[1]] ~= nil then list[#list + 1], list[#list + 2] = field[1], l[field[1]] end
  end
  add(w.nodes, json.object("mesh", mesh, "extras", extras((table.unpack or unpack)(list)))) -- luacheck: ignore 113
end

--- Light from all around, in extras.ylm of the scene: names and values.
function lamps.sky(w, ...) w.skies[#w.skies + 1] = json.object(...) end

--- The number of a texture of these bytes of a .png.
local function texture(w, bytes, name)
  local source = add(w.images, json.object("name", name, "mimeType", "image/png", "bufferView", view(w, bytes)))
  return add(w.textures, json.object("sampler", 0, "source", source))
end

--- Takes what a lightmap adds to the file.
local function take_lightmap(w, lightmap)
  local about, inside = lightmap.about, lightmap.inside
  w.second = lightmap.second
  if inside.map then about[#about + 1], about[#about + 2] = "texture", texture(w, inside.map, "lightmap") end
  if inside.shown then
    w.shown = texture(w, inside.shown, "light as it is shown")
    about[#about + 1], about[#about + 2] = "shown", w.shown
  end
  w.lightmap = json.object((table.unpack or unpack)(about)) -- luacheck: ignore 113
end

-- The whole -------------------------------------------------------------------------------------

local function add_camera(w, c, name)
  local d = { c.at[1] - c.from[1], c.at[2] - c.from[2], c.at[3] - c.from[3] }
  local n = add(w.cameras, json.object("name", name, "type", "perspective", "perspective",
    json.object("yfov", math.rad(c.fov), "znear", 0.01), "extras", extras("at", c.at, "up", c.up, "fov", c.fov)))
  add(w.nodes, json.object("camera", n, "translation", c.from, "rotation", rotation_of(d, c.up)))
end

local function list_of(x) return #x > 0 and x or nil end

--- The JSON; `uri` of the buffer, or nil.
local function text_of(w, scene, uri)
  local used, roots = {}, {}
  for _, name in ipairs { "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit" } do
    if w.used[name] then used[#used + 1] = name end
  end
  for i = 1, #w.nodes do roots[i] = i - 1 end
  local background = not scene.sky_is_seen and scene.background or nil
  return json.write(json.object("asset", json.object("version", "2.0", "generator", "ylm"), "extensionsUsed", list_of(used),
    "extensions", list_of(w.lights) and json.object("KHR_lights_punctual", json.object("lights", w.lights)),
    "scene", 0, "scenes", { json.object("name", scene.name ~= "" and scene.name or nil, "nodes", list_of(roots), "extras",
      extras("background", background, "skies", list_of(w.skies), "lightmap", w.lightmap)) },
    "nodes", list_of(w.nodes), "cameras", list_of(w.cameras), "materials", list_of(w.materials), "textures",
    list_of(w.textures), "images", list_of(w.images), "samplers", #w.textures > 0 and { SAMPLER } or nil,
    "meshes", list_of(w.meshes),
    "accessors", list_of(w.accessors), "bufferViews", list_of(w.views),
    "buffers", w.size > 0 and { json.object("uri", uri, "byteLength", w.size) } or nil))
end

--- An integer of four bytes, little-endian.
local function word(x)
  return string.char(x % 256, math.floor(x / 256) % 256, math.floor(x / 65536) % 256, math.floor(x / 16777216) % 256)
end

--- The bytes of a .glb file; nil, message, code where they are more than the format can say.
local function container(head, data)
  head = head .. (" "):rep(-#head % 4)
  local size = 12 + 8 + #head + (#data > 0 and 8 + #data or 0)
  if size >= 2 ^ 32 then return nil, "a .glb file has at most 4 GiB: save .gltf with separate = true", "ELIMIT" end
  return "glTF" .. word(2) .. word(size) .. word(#head) .. "JSON" .. head .. (#data > 0 and word(#data) .. "BIN\0" .. data or "")
end

local function fill(w, scene)
  local count = 0
  for _, l in ipairs(scene.lights) do count = count + pack.rows(l) end
  if count > LAMPS then
    return nil, ("glTF has a node for each lamp: %d lamps, at most %d are written"):format(count, LAMPS), "ELIMIT"
  end
  for _, piece in ipairs(scene.geometry) do
    local ok, message, code = add_piece(w, piece)
    if not ok then return nil, message, code end
  end
  for _, l in ipairs(scene.lights) do
    local as_light = pack.form_of(l)
    if as_light and as_light.gltf then
      local _, message, code = as_light.gltf(w, l)
      if message then return nil, message, code end
    else
      leave_out(w, ("lights of kind %s, left out"):format((form.kind(l):gsub("^ylm%.", ""))))
    end
  end
  if scene.camera then add_camera(w, scene.camera) end
  for _, c in ipairs(scene.cameras or {}) do if c ~= scene.camera then add_camera(w, c) end end
  return true
end

local options = {
  { "separate", "boolean", default = false, about = ".gltf: the buffer in a file of its own, .bin, instead of base64" },
  { "strict", "boolean", default = false, about = "where anything would be left out or simpler nothing is written: nil, message, "
    .. "'ELIMIT'" },
}
write.options = options

--- A sentence for each kind of thing that is left out or simpler.
local function notes_of(w)
  local notes = {}
  for i, what in ipairs(w.left_out) do notes[i] = ("%s: %d"):format(what, w.left_out[what]) end
  return notes
end

--- Says in a line what the file lacks, of a scene once.
local function tell(scene, path, notes)
  if #notes == 0 then return end
  local line = table.concat(notes, "; ")
  warning.say(scene, "save " .. line, "%s, glTF of scene %q, lacks or simplifies: %s; strict = true refuses instead",
    text.shown(path), scene.name or "?", line)
end

--- Saves a scene; true and what glTF lacks, a sentence each; or nil, message, code. `lightmap`: { second = texture coordinates
-- by piece, about = keys and values about the picture, inside = { map =, shown = bytes of pictures, or nil } } or nil.
function write.save(scene, path, given, lightmap)
  local ending = type(path) == "string" and not path:find "%z" and path:lower():match "%.(%w+)$"
  if ending ~= "glb" and ending ~= "gltf" then
    return check.bad(1, "save", "a file name that ends in .glb or .gltf expected, got %s", check.describe(path))
  end
  local o = form.options(2, "save", options, given)
  if o.separate and ending == "glb" then return check.bad(2, "save", "separate is for .gltf: a .glb file is one file") end
  local w = setmetatable(new(), lamps)
  if lightmap then take_lightmap(w, lightmap) end
  local ok, message, code = fill(w, scene)
  if not ok then return nil, message, code end
  local notes = notes_of(w)
  if #notes > 0 and o.strict then
    return nil, ("%s is not written, since glTF would lack (strict): %s"):format(path, table.concat(notes, "; ")), "ELIMIT"
  end
  local data = table.concat(w.data)
  local bytes
  if ending == "glb" then
    bytes, message, code = container(text_of(w, scene), data)
    if not bytes then return nil, message, code end
  elseif o.separate and #data > 0 then
    local name = path:gsub("%.%w+$", "") .. ".bin"
    ok, message, code = check.result("save", core.file_save(name, data))
    if not ok then return nil, message, code end
    bytes = text_of(w, scene, (name:match "[^/]*$":gsub("[^%w%-_.~]", function(c) return ("%%%02X"):format(c:byte()) end)))
  else
    bytes = text_of(w, scene, #data > 0 and "data:application/octet-stream;base64," .. core.page_base64(data) or nil)
  end
  ok, message, code = check.result("save", core.file_save(path, bytes))
  if not ok then return nil, message, code end
  tell(scene, path, notes)
  return true, notes
end

return write
