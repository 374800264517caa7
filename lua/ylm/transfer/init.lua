--- Light from surface to surface: scene:links, and the methods of what it returns.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local cut = require "ylm.transfer.form"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"

local transfer, methods = { links = cut.links }, objects.links

require "ylm.describe".object "links" {
  about = "The surfaces of a scene in elements, and the elements that each of them sees (scene:links).",
  fields = {
    { "stats", "table", "elements (sides counted); spacing, links, lmax: those in use; closed, rooms: closed meshes, and "
      .. "those whose "
      .. "inner side reflects; degenerate: triangles without area; dead: elements inside of bodies; rays; escaped: links to "
      .. "nothing; "
      .. "buried: rays that begin inside of a body; lost: rays to triangles without elements; seconds, bytes" },
    { "scene", "scene", "of what" },
    { "notes", "string[]", "what is known to be missed, or nil" },
  },
}

local options = {}
for _, field in ipairs(cut.fields) do
  local copy = {}
  for key, value in pairs(field) do copy[key] = value end
  copy.default, copy.optional = nil, true -- those of the scene's `links`, else those of the form
  options[#options + 1] = copy
end
options[#options + 1] = { "inside", "any", optional = true,
  about = "places [n][3] from which rooms are seen, besides lamps and the camera: array or list" }
options[#options + 1] = { "file", "path", optional = true,
  about = "reads a file of t:save instead, of a scene with the same meshes; all other options are the file's" }
options[#options + 1] = form.threads
options[#options + 1] = form.progress

--- The scene's own `links` stand for options that are not given.
local function settled(s, o)
  for _, field in ipairs(cut.fields) do
    local name = field[1]
    if o[name] == nil and s.link_options then o[name] = s.link_options[name] end
    if o[name] == nil then o[name] = field.default end
  end
  return o
end

--- Places from which rooms are seen, float [n][3], or nil.
local function places_inside(s, given)
  local list = {}
  if given ~= nil then
    local a = array.points(1, "links", given, "float", "inside")
    for _, p in ipairs(core.array_totable(a)) do list[#list + 1] = p end
  end
  if s.camera then list[#list + 1] = s.camera.from end
  if #list > 0 then return array.array(list, "float") end
end

--- The sides of all meshes, as C names them.
local function sides_of(s, default)
  local sides = {}
  for i, g in ipairs(s.geometry) do sides[i] = g.sides or default end
  return sides
end

--- The sentences about light that bounces of which links know nothing; or nil.
local function notes_of(s, traced)
  if traced.glossy == 0 then return nil end
  return { ("scene %q: %d of %d meshes gloss; they reflect to others as matte ones of their mean albedo: no highlights, no "
    .. "caustics"):format(
    s.name or "?", traced.glossy, #s.geometry) }
end

--- The links of a file, whose options are those that it was made with.
local function from_file(traced, o, given)
  for key in pairs(given) do
    if key ~= "file" and key ~= "threads" and key ~= "progress" then
      return check.fail("links: %s is the file's: leave out file, or %s", key, key)
    end
  end
  return check.result("links", traced.lib.transfer_read(traced.handle, o.file))
end

--- Links of `handle`; what they were made of is remembered.
local function remember(s, traced, handle)
  core.own(handle).made = { scene = s, traced = traced, lib = traced.lib, stats = traced.lib.transfer_stats(handle),
    notes = notes_of(s, traced) }
  return handle
end

describe "scene:links" {
  about = "Cuts the surfaces of a scene into elements and finds, by rays, the elements that each of them sees: links. Once made, "
    .. "bounces of any light are sums over links.",
  arguments = { { "options?", "table", "default: those of the scene's `links`" } },
  options = options,
  returns = { { "t", "links", "t:radiosity(lights), t:vectors(), t:elements(), t:save(file); t.stats" } },
  errors = "raises on a bad option; nil, message, code: too many elements (ELIMIT), memory, cancelled",
  example = [[
local scene = ylm.scene "a box and a lamp" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
}
local t = scene:links { spacing = 0.5, rays = 64 }
assert(t.stats.rooms == 1 and t.stats.escaped == 0)]],
  source = "Goral et al. 1984",
}
function transfer.of_scene(s, given)
  tracing.check_scene("links", s)
  local o = form.options(1, "links", options, given)
  o.progress = progress.long(o.progress)
  local traced, message, code = tracing.trace("links", s)
  if not traced then return nil, message, code end
  local handle
  if o.file then
    handle, message, code = from_file(traced, o, given)
    if not handle then return nil, message, code end
    return remember(s, traced, handle)
  end
  settled(s, o)
  handle, message, code = check.result("links", traced.lib.transfer_create(traced.handle, {
    spacing = o.spacing or 0, max_elements = o.max_elements, links = o.rays, lmax = o.lmax, sides = sides_of(s, o.sides),
    inside = places_inside(s, o.inside), seed = o.seed, threads = o.threads, progress = progress.resolve(o.progress) }))
  if not handle then return nil, message, code end
  return remember(s, traced, handle)
end

describe "links:elements" {
  about = "The elements: pieces of triangles on which light is constant.",
  arguments = {},
  returns = { { "elements", "table", "centre [n][3], normal [n][3], albedo [n][3] (mean albedo times tint), area [n] (of the "
    .. "part that is "
    .. "not inside of a body), mesh [n]: place in scene.geometry" } },
  errors = "raises on what are no links; nil, message, code where memory runs out",
  example = [[
local scene = ylm.scene "a floor" { geometry = { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } } }
local elements = scene:links({ spacing = 0.75, sides = "front" }):elements()
assert(elements.centre.shape[1] == 8 and elements.mesh:get(1) == 1)]],
}
function methods.elements(t)
  local m = objects.open_links("elements", t)
  local centre, normal, albedo, area, mesh = m.lib.transfer_elements(t)
  return { centre = centre, normal = normal, albedo = albedo, area = area, mesh = mesh }
end

describe "links:hits" {
  about = "The numbers of the elements that rays of each element hit.",
  arguments = {},
  returns = { { "hits", "array", "double [n][rays], in order of their numbers, which begin at 1; n + 1 is nothing" } },
  errors = "raises on what are no links; nil, message, code where memory runs out",
  example = [[
local scene = ylm.scene "a floor" { geometry = { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } } }
local t = scene:links { rays = 16, spacing = 2 }
assert(t:hits():get(1, 1) == t.stats.elements + 1) -- a floor sees nothing]],
}
function methods.hits(t)
  local m = objects.open_links("hits", t)
  return check.result("hits", m.lib.transfer_links(t))
end

describe "links:save" {
  about = "Writes elements and links to a file, which scene:links { file = } reads where the scene has the same meshes.",
  arguments = { { "path", "string", "the file, by custom NAME.links" } },
  returns = { { "ok", "boolean", "true, or nil, message, 'EIO'" } },
  errors = "raises on what is no file name; nil, message, code: files, memory",
  example = [[
local scene = ylm.scene "a floor" { geometry = { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } } }
local name = os.tmpname()
assert(scene:links({ rays = 16, spacing = 2 }):save(name))
assert(scene:links({ file = name }).stats.links == 16)
os.remove(name)]],
}
function methods.save(t, path)
  local m = objects.open_links("save", t)
  if type(path) ~= "string" or path == "" or path:find("%z") then
    return check.bad(1, "save", "the name of a file expected, got %s", check.describe(path))
  end
  return check.result("save", m.lib.transfer_write(t, path))
end

describe "links:close" {
  about = "Frees the memory of links now, or with the last radiosity of it, rather than at a collection.",
  arguments = {},
  returns = {},
  errors = "raises on what are no links",
  example = [[
local scene = ylm.scene "a floor" { geometry = { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } } }
scene:links({ rays = 4, spacing = 2 }):close()]],
}
function methods.close(t)
  if core.type(t) ~= "ylm.links" then
    return check.fail("close: links expected before the colon, got %s", check.describe(t))
  end
  objects.close(t, objects.made(t).lib.transfer_close)
end

require "ylm.transfer.radiosity"
require "ylm.transfer.receivers"
require "ylm.transfer.importance"
require "ylm.transfer.field"
require "ylm.transfer.vectors"
local fields = require "ylm.transfer.scene"
transfer.fields, transfer.field_of = fields, fields.of_scene
memory.publish(methods)

return transfer
