--- Scenes: a camera, geometry, lights, probes; and scene files.
--
-- A scene only describes. Its methods bake, prepare, render, pathtrace and probe are
-- those of lua/ylm/render/init.lua.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local gltf = require "ylm.gltf"
local gltf_write = require "ylm.gltf.write"
local library = require "ylm.library"
local like = require "ylm.scene.like"
local memory = require "ylm.memory"
local pack = require "ylm.light.pack"
local polygon = require "ylm.light.polygon"
local sandbox = require "ylm.sandbox"
local text = require "ylm.text"
local tracing = require "ylm.trace"
require "ylm.transfer.form" -- a field of scenes
local vector = require "ylm.vector"
local virtual = require "ylm.light.virtual"

local scene = {}

-- Lists that may nest ---------------------------------------------------------

--- How deep lists may nest; a list that contains itself is deeper than that.
local deepest = 32

local is_part = {
  geometry = function(x)
    return type(x) == "table" and form.kind(x) and form.kind(x.mesh) == "ylm.mesh"
  end,
  lights = function(x)
    local kind = form.kind(x)
    return kind and (kind == "ylm.lights" or type(x) == "table" and form.defined[kind].light) and true
  end,
}

local constructors = {}
for _, kind in ipairs(require "ylm.light.kinds") do
  for i = 2, #kind do constructors[#constructors + 1] = kind[i] end
end

local wanted_part = {
  geometry = "geometry (a quad, sphere, box, torus, knot or mesh)",
  lights = "a light (" .. table.concat(constructors, ", ") .. ")",
}

function form.types.parts(x)
  if type(x) == "table" or form.kind(x) then return x end
  return nil, "a list"
end

local function kind_text(x)
  local kind = type(x) == "table" and form.kind(x)
  return kind and "a " .. kind or check.describe(x)
end

--- Takes what a part that is listed again describes once more from what a scene file may.
local function take_again(x, fail)
  if core.type(x) ~= nil then return form.budget("numbers", 1, fail) end
  if x.mesh then return form.budget("triangles", #x.mesh, fail) end
  if form.kind(x) == "virtual_lights" then form.budget("virtual_lights", x.count, fail) end
  return form.budget("numbers", (x.count or 1) * (form.defined[form.kind(x)].numbers or 7), fail)
end

--- Appends to `out`, which has the set `listed` of them, the parts of `field` found in `x`, in order; fail(message) names
-- the place.
local function flatten(field, x, out, place, depth, fail)
  if is_part[field](x) then
    if form.budget and out.listed[x] then take_again(x, fail) end
    out.listed[x] = true
    for _, part in ipairs(type(x) == "table" and x.parts or { x }) do out[#out + 1] = part end
    if type(x) == "table" and (x.notes or x.emitters) then out.files[#out.files + 1] = x end
    return
  end
  if type(x) ~= "table" or form.kind(x) then
    return fail(("%s must be %s, got %s"):format(place, wanted_part[field], kind_text(x)))
  end
  if depth > deepest then
    return fail(("%s: lists nested more than %d deep"):format(field, deepest))
  end
  local n, largest = 0, 0
  for key in pairs(x) do
    if not check.is_integer(key) or key < 1 then
      return fail(("%s: unexpected entry %s in a list; %s expected"):format(place, check.describe(key),
        wanted_part[field]))
    end
    n, largest = n + 1, math.max(largest, key)
  end
  if largest ~= n then
    for i = 1, largest do
      if x[i] == nil then
        -- A constructor that could not read a file left nil, message, code here.
        local why = type(x[i + 1]) == "string" and ": " .. x[i + 1] or ""
        return fail(("%s[%d] is nil%s"):format(place, i, why))
      end
    end
  end
  for i = 1, n do flatten(field, x[i], out, ("%s[%d]"):format(place, i), depth + 1, fail) end
end

--- Adds the triangles of a mesh as polygon lights to a list; those without an area emit nothing.
local function add_emitter(list, part)
  local vertices, triangles = core.array_totable(part.mesh:vertices()), core.array_totable(part.mesh:triangles())
  for _, t in ipairs(triangles) do
    local a, b, c = vertices[t[1]], vertices[t[2]], vertices[t[3]]
    local u, v = { b[1] - a[1], b[2] - a[2], b[3] - a[3] }, { c[1] - a[1], c[2] - a[2], c[3] - a[3] }
    local size = 0
    for i = 1, 3 do size = math.max(size, math.abs(u[i]), math.abs(v[i])) end
    if vector.length(vector.cross(u, v)) > 2e-12 * size * size then -- polygons of less are refused
      list[#list + 1] = polygon.polygon_light { vertices = { a, b, c }, radiance = part.emission }
      list[#list].of_file = true
    end
  end
end

--- Adds what files bring beside surfaces: lights of emitting materials, and notes.
local function add_files(values, files)
  local notes, said = {}, {}
  local function note(sentence)
    if not said[sentence] then notes[#notes + 1] = sentence end
    said[sentence] = true
  end
  for _, sentence in ipairs(values.notes or {}) do note(sentence) end
  for _, entry in ipairs(files) do
    local first = #values.lights + 1
    for _, part in ipairs(entry.emitters or {}) do add_emitter(values.lights, part) end
    for i = first, #values.lights do core.between(values, values.lights[i]).from_file = true end
    for _, sentence in ipairs(entry.notes or {}) do note(sentence) end
  end
  values.notes = #notes > 0 and notes or nil
end

require "ylm.describe".object "scene" {
  about = "A camera, geometry, lights and probes: all that a picture is made of.",
  fields = {
    { "name", "string", "" },
    { "camera", "camera", "or nil" },
    { "cameras", "table", "all of a glTF file that the scene is like, by number and by name; or nil" },
    { "geometry", "table", "a flat list" },
    { "lights", "table", "a flat list" },
    { "probes", "table", "the grid's description, or nil" },
    { "background", "number[]", "{r, g, b}" },
    { "link_options", "table", "the form links, or nil" },
    { "inverse_options", "table", "options of scene:inverse_lighting that a scene file asks for, or nil" },
    { "notes", "string[]", "about files: materials that are not there, lights that Ke made; or nil" },
  },
}

-- Scenes that are like others -----------------------------------------------------

--- The lights of a list that geometry brought to the scene `values`, or the others.
local function lights_of(values, file, list)
  local out = {}
  for _, light in ipairs(list) do
    if (core.between(values, light).from_file or false) == file then out[#out + 1] = light end
  end
  return out
end

--- The lights of the scene `other` as `values` change them, with those that `values` add; or nil, message, code. Lights that
-- geometry brought stay with that geometry.
local function take_lights(values, other, fail)
  local list = other.lights
  for _, light in ipairs(core.partners(other)) do
    core.between(values, light).from_file = core.between(other, light).from_file
  end
  if values.moved or values.removed then
    local message, code
    list, message, code = like.lights(list, values, ("%q"):format(other.name), fail)
    if not list then return nil, message, code end
  end
  if values.lights then list = { values.lights, lights_of(values, true, list) } end
  if values.geometry then list = values.lights or lights_of(values, false, list) end
  local added = { listed = {}, files = {} }
  flatten("lights", values.added or {}, added, "added", 0, fail)
  added.listed, added.files = nil, nil
  return { list, added }
end

--- Takes what is not given from the scene `values.like`; true, or nil, message, code.
local function take_after(values, fail)
  local other = values.like and like.scene_of(values.like)
  local changes = values.moved and "moved" or values.removed and "removed" or values.added and "added"
  if not other then
    return not changes or fail(changes .. " changes the lights of another scene, which like names")
  end
  if values.lights and changes then
    return fail(("give lights, or changes to those of the other scene (%s), not both"):format(changes))
  end
  local lights, message, code = take_lights(values, other, fail)
  if not lights then return nil, message, code end
  values.notes = not values.geometry and other.notes or nil
  values.lights, values.geometry = lights, values.geometry or other.geometry
  values.cameras = other.cameras
  values.camera, values.probes = values.camera or other.camera, values.probes or other.probes
  values.links = values.links or other.link_options
  if not values.background and not other.sky_is_seen then values.background = other.background end
  return true
end

-- Light that is asked for -----------------------------------------------------------------

local ASKED = { vary = true, targets = true, price = true, evaluations = true, starts = true, spacing = true, rays = true,
  judge = true, seed = true, light_samples = true, rim = true }

--- Raises where inverse_lighting has fields that a scene does not keep, or a scene file names a picture by a file.
local function check_asked(asked, fail)
  for key in pairs(asked or {}) do
    if not ASKED[key] then return fail(("inverse_lighting: no field %s here"):format(check.describe(key))) end
  end
  if not asked or not form.locate or type(asked.targets) ~= "table" then return end
  for i, t in ipairs(asked.targets) do
    if type(t) == "table" and type(t.image) == "string" then
      return fail(("inverse_lighting: targets[%d]: in a scene file an image is numbers [rows][columns]"):format(i))
    end
  end
end

-- The form ---------------------------------------------------------------------

--- The methods are those of lua/ylm/render/init.lua, loaded when one is first called.
local methods = {}
for _, name in ipairs { "bake", "surface_grid", "lightmap", "prepare", "render", "pathtrace", "probe", "judge" } do
  methods[name] = function(...) return require("ylm.render")[name](...) end
end
function methods.inverse_lighting(...) return library.later["ylm.inverse"](...) end
function methods.live(...) return library.later["ylm.live"](...) end
function methods.links(...) return require("ylm.transfer").of_scene(...) end
function methods.field(...) return require("ylm.transfer").field_of(...) end
function methods.virtual_lights(...) return require("ylm.emit").of_scene(...) end
--- Of virtual_lights:visible: lua/ylm/emit.lua is loaded, and takes its place.
virtual.with_shadows = virtual.with_shadows or function(...)
  require "ylm.emit"
  return virtual.with_shadows(...)
end

describe "scene:save" {
  shelf = "everyday",
  about = "Writes the scene as glTF 2.0: geometry, materials, lamps, cameras. Numbers that glTF lacks stand in extras.ylm, by "
    .. "which ylm.load reads its own lamps, skies and materials exactly. Disks become polygons, textures their mean, phong "
    .. "its nearest ggx; images and virtual lights are left out. A line on the terminal (ylm.on_warning) names what is.",
  arguments = { { "path", "string", "ends in .glb, or .gltf" }, { "options?", "table", "" } },
  options = gltf_write.options,
  returns = { { "ok", "boolean", "true" }, { "notes", "string[]", "what is left out or simpler, with counts" } },
  errors = "raises on another ending; nil, message, code where the file cannot be written, 'ELIMIT' above 20,000 lamps, and with "
    .. "strict where anything would be left out",
  example = [[
local name = os.tmpname()
local s = ylm.scene "one" { geometry = ylm.box {}, lights = ylm.sphere_light { at = { 0, 2, 0 } } }
assert(s:save(name .. ".glb"))
os.remove(name .. ".glb")
os.remove(name)]],
}
function methods.save(s, path, options)
  if form.kind(s) ~= "scene" then return check.fail("save: a scene expected before the colon, got %s", check.describe(s)) end
  return gltf_write.save(s, path, options)
end
memory.publish(methods)

local metatable = {
  __index = methods,
  __walls = function(s, name) return tracing.walls(name, s) end,
  __tostring = function(s)
    return ("scene %q: %d pieces of geometry, %d lights"):format(s.name, #s.geometry, #s.lights)
  end,
}

local construct = form.define("scene", {
  shelf = "everyday",
  about = "A camera, geometry, lights and probes of a picture. Lists may nest, so that plain Lua loops build them: "
    .. "scene \"name\" { ... }.",
  fields = {
    { "like", "like", optional = true,
      about = "another scene, or the file of one (in a scene file: in its folder), or a glTF file; fields that are given "
        .. "replace that scene's" },
    { "camera", "object", of = "camera", optional = true, about = "needed by prepare, render and pathtrace" },
    { "geometry", "parts", optional = true, about = "surfaces: one, or a list that may nest" },
    { "lights", "parts", optional = true, about = "lights: one, or a list that may nest" },
    { "moved", "table", optional = true,
      about = "with like: fields of lights by their number in its list, { [2] = { at = {0, 1, 0} } }; each sphere of "
        .. "sphere_lights has a number" },
    { "removed", "table", optional = true, about = "with like: a list of numbers, as they are in the other scene" },
    { "added", "parts", optional = true, about = "with like: further lights, behind the others" },
    { "probes", "object", of = core.choices "grid_form", optional = true,
      about = "the grid that bake fills" },
    { "links", "object", of = "links", optional = true,
      about = "how surfaces are cut where light bounces; in the scene it is link_options" },
    { "inverse_lighting", "table", optional = true,
      about = "{ vary =, targets = }: what `ylm inverse_lighting` plans; in the scene it is inverse_options" },
    { "background", "colour", min = 0, optional = true, unit = "W sr^-1 m^-2",
      about = "radiance where nothing is hit; default: what distant lights send from there, else 0" },
  },
  metatable = metatable,
  build = function(values, fail)
    local taken, message, code = take_after(values, fail)
    if not taken then return nil, message, code end
    local files
    for field in pairs(is_part) do
      local parts = { listed = {}, files = {} }
      flatten(field, values[field] or {}, parts, field, 0, fail)
      files = field == "geometry" and parts.files or files
      parts.listed, parts.files = nil, nil
      values[field] = parts
    end
    add_files(values, files)
    message = pack.mixed(values.lights)
    if message then return fail(message) end
    values.like, values.moved, values.removed, values.added = nil, nil, nil, nil
    values.sky_is_seen = values.background == nil
    values.link_options, values.links = values.links, nil -- the methods have these names
    check_asked(values.inverse_lighting, fail)
    values.inverse_options, values.inverse_lighting = values.inverse_lighting, nil
    values.background = values.background or { 0, 0, 0 }
    return setmetatable(values, metatable)
  end,
  example = [[
local s = scene "one lamp" {
  camera   = camera { from = { 3, 2, 3 }, at = { 0, 0, 0 } },
  geometry = { box {}, quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights   = sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 5 },
  probes   = adaptive_grid { lmax = 4, depth = 6, tolerance = 0.01 },
}
assert(s.name == "one lamp" and #s.geometry == 2 and #s.lights == 1)]],
})

describe "scene" {
  shelf = "everyday",
  about = "Makes a scene: ylm.scene \"name\" { camera = , geometry = , lights = , probes = , background = }. "
    .. "Methods: bake, prepare, render, pathtrace, probe.",
  arguments = { { "name", "string", "what pictures are titled with" } },
  returns = { { "fields", "function", "takes the table of fields, see the form 'scene', and returns the scene" } },
  errors = "raises at the caller's line on missing, misspelt or wrong fields",
  example = [[
local s = ylm.scene "nothing" {}
assert(s.name == "nothing" and #s.geometry == 0)]],
}
function scene.scene(name)
  --- True, and the fields with the other scene in place of its file's name; or nil, message, code.
  local function with_other(given, where)
    if type(given) ~= "table" or type(given.like) ~= "string" or not form.types.path(given.like) then
      return true, given
    end
    local copy = {}
    for key, value in pairs(given) do copy[key] = value end
    local other, message, code = like.open(given.like, where, function(path) return like.load(path, scene.scene) end)
    copy.like = other
    if not other then return nil, message, code end
    return true, copy
  end
  if type(name) ~= "string" then
    return check.bad(1, "scene", "the scene's name comes first: scene \"name\" { ... }; got %s", check.describe(name))
  end
  if #name > 200 or text.shown(name) ~= name then
    return check.bad(1, "scene", "a name of at most 200 characters of UTF-8, none of them for control, expected")
  end
  -- `return scene "name" { ... }` is a tail call: remember the line while it is on the stack.
  local where = check.position()
  return memory.public(function(given)
    local found, copy, code = with_other(given, where)
    if not found then return nil, copy, code end
    local ok, s, message
    ok, s, message, code = memory.pcall(construct, copy)
    if not ok then error(where .. tostring(s):gsub("^.-(scene: )", "%1"), 0) end
    if not s then return nil, message, code end
    s.name = name
    return s
  end)
end
form.defined.scene.construct = scene.scene

--- The scene of a scene file, for ylm.load. Or nil, message, code.
function scene.of_file(path, limits) return sandbox.run(path, limits, scene.scene) end

--- The scene of a glTF file, for ylm.load; its report says what the file holds. Or nil, message, code.
function scene.of_gltf(path, options)
  local model, message, code = gltf.load(path, options)
  if not model then return nil, message, code end
  local made = scene.scene(text.shown(path:match "[^/]*$"):sub(1, 200)) { like = model }
  made.file, made.report = path, model.report
  return made
end

return scene
