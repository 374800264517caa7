--- scene:lightmap: irradiance on the surfaces of a scene as a picture, with texture coordinates, and the methods of what it
-- returns.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local files = require "ylm.render.lightmap_file"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local prints = require "ylm.render.prints"
local promise = require "ylm.render.promise"
local tracing = require "ylm.trace"
local transfer = require "ylm.transfer"
local unmet = require "ylm.grid.unmet"
local unwrap = require "ylm.geometry.unwrap"
local warning = require "ylm.warning"

local lightmaps = {}

local JUDGES = 2048    -- places by which paths judge
local AIM = 0.55       -- of its tolerance, for which texels are made that paths will judge: they see the elements' error too
local MOST = 2 ^ 21    -- texels, where nobody says how many
local TOLERANCE = 0.03 -- where nobody says anything
local BYTES = 6        -- of a texel, three half floats

local methods = objects.kind("lightmap", { "stats", "scene", "quantity", "tolerance" }, function(m)
  return ("%s light, %d charts, %d x %d texels"):format(m.quantity, m.stats.charts, m.stats.width, m.stats.height)
end)

require "ylm.describe".object "lightmap" {
  about = "Irradiance on the surfaces of a scene as one picture, and the texture coordinates by which they read it "
    .. "(scene:lightmap).",
  fields = {
    { "stats", "table", "width, height; bytes: of the picture as half floats; charts, curved, degenerate, stretch, worst, share, "
      .. "density: as of mesh:unwrap; sheets: sides of meshes that have light; places whose light was asked for, rays; rounds: "
      .. "pictures that were made; noise: of the light of a place, relative; seams: edges where charts meet on smooth surfaces; "
      .. "jump: the largest difference of their sides, relative; jump_1, jump_2: at the next levels of mip maps; verified, "
      .. "failed: places that judged, and those that missed the tolerance; error: what 99 % of the surface keep, with 99 % "
      .. "confidence; rms: root mean square error over the mean, without the judges' noise; met; warning: what is not kept, or "
      .. "nil; spent: texels were not enough; stalled: more of them did not pay; misses: places that miss 0.55 of it by "
      .. "the light of the elements: edges, of light, bodies, which texels are partly under, noise; paths: what paths found, "
      .. "undecided, field_met and field_error by the light of the elements, seconds; chart_seconds, pack_seconds, "
      .. "light_seconds, fit_seconds, judge_seconds, seconds" },
    { "scene", "scene", "of what" },
    { "quantity", "string", "'direct', 'indirect' or 'all'" },
    { "tolerance", "number", "that was asked for, or nil" },
  },
}

local fields = {
  { "tolerance", "number", min = 1e-3, max = 10, optional = true,
    about = "of irradiance at 99 % of the surface by area, relative to the larger of the place's and the mean; default 0.03, "
      .. "where neither texels nor bytes are given" },
  { "texels", "integer", min = 16, max = 2 ^ 28, optional = true,
    about = "of the picture at most, gutters included: all of them without a tolerance; default with one 2097152" },
  { "bytes", "memory", optional = true, about = "of the picture at most, instead of texels: 6 a texel, 24 if directional" },
  { "quantity", "choice", of = { "direct", "indirect", "all" }, default = "all",
    about = "'all', the light of lamps and sky and what surfaces send back; 'indirect', the latter alone, for engines that draw "
      .. "lamps themselves; 'direct', the former, with shadows" },
  { "directional", "boolean", default = false,
    about = "with three more pictures, the flow of light along x, y and z, by which normals that bumps tilt read their light" },
  { "spread", "choice", of = { "light", "even" }, default = "light", shelf = "experiments",
    about = "'light': texels are dense in charts where light bends; 'even': one density, for comparison" },
  transfer.fields.bounces, transfer.fields.links,
  { "rays", "links", default = 64, shelf = "experiments",
    about = "of a place whose light is fitted, twice; four places a texel" },
  { "light_samples", "integer", min = 1, max = core.limits.transfer_links, default = options.LIGHT_SAMPLES,
    shelf = "experiments", about = "of 'direct' and 'all': shadow rays of a place, twice" },
  { "parts", "boolean", default = true, shelf = "experiments",
    about = "whether large charts are divided, so that their parts have densities of their own; of spread = 'light'" },
  { "smooth", "boolean", default = true, shelf = "experiments",
    about = "whether texels are averaged along the surface, as far as halves of their rays say that light is smooth" },
  { "judge", "choice", of = { "paths", "field" }, default = "paths", shelf = "experiments",
    about = "what a tolerance is judged by: paths, up to 16384 from each of 2048 places; or the light of the elements that was "
      .. "fitted, whose own error is not seen, with its noise" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  { "resume", "path", optional = true,
    about = "a file that gets light and texels as they are found, some 100 bytes a texel: a bake that was interrupted goes on "
      .. "where it was. The file is removed at the end" },
}
local all_options = options.list(fields, unwrap.fields, options.common)

-- Making ---------------------------------------------------------------------------------------

--- The causes of misses, by the light that texels were fitted to:
-- "of 20 places that miss 0.018 by elements 14 lie at edges of light".
local function misses_of(m, aim)
  local s, causes = m.stats.misses, {}
  local function add(n, lie) if n > 0 then causes[#causes + 1] = ("%d %s"):format(n, lie) end end
  add(s.edges, "at edges of light")
  add(s.bodies, "on texels that are partly under bodies")
  add(s.noise, "within the noise of rays")
  return ("of %d places that miss %.2g by elements %s"):format(s.edges + s.bodies + s.noise, aim, table.concat(causes, ", "))
end

--- Why a tolerance is not met, and the change that helps.
local function cause_of(m, aim)
  local s, paths = m.stats, m.stats.paths
  local looser = "set tolerance = " .. (s.error < math.huge and unmet.rounded_up(s.error) or "larger")
  if core.grid_allowed(s.verified) < 0 then
    return ("the %d places that were found open are too few to judge by"):format(s.verified)
  end
  if paths and paths.field_met then
    return (unmet.undecided(s, paths) or "the light of elements is that far from the paths: give links with less spacing")
      .. "; " .. looser
  end
  local texels = s.width * s.height
  local reached = s.spent and ("its %d texels are spent"):format(texels)
    or s.stalled and ("more texels, up to %d, do not pay"):format(texels) or ("%d pictures end above it"):format(s.rounds)
  local misses = s.misses
  local more = misses.noise > misses.edges + misses.bodies and "give more rays and light_samples, or "
    or s.spent and "allow more (texels), or " or ""
  return ("%s, %s: %s%s"):format(reached, misses_of(m, aim), more, looser)
end

--- A map's stats.
local function stats_of(lib, map)
  local s = lib.map_stats(map)
  s.misses = { edges = s.edges, bodies = s.bodies, noise = s.noisy }
  s.edges, s.bodies, s.noisy = nil, nil, nil
  return s
end

--- Has paths judge a lightmap of light `lit`. True, or nil, message, code.
local function judge(s, map, m, lit, o)
  local points, normals, E = m.lib.map_judges(map, lit, JUDGES, o.seed)
  if not points then return check.result("lightmap", points, normals, E) end
  if #points == 0 then return true end
  local said, message, code = promise.compare(s, promise.lists(points), promise.lists(normals), promise.lists(E), o.tolerance,
    o.quantity, o)
  if not said then return nil, message, code end
  local before = m.stats
  m.lib.map_verdict(map, #points, said.failed + said.undecided, said.error, said.rms)
  m.stats = stats_of(m.lib, map)
  m.stats.paths = { field_met = before.met, field_error = before.error, undecided = said.undecided, seconds = said.seconds }
  return true
end

--- The bytes of a texel.
local function bytes_of(o) return BYTES * (o.directional and 4 or 1) end

--- The texels that options allow.
local function texels_of(o)
  if o.bytes and o.texels then return check.fail "lightmap: texels or bytes, not both: each says how large the picture may be" end
  if not o.bytes then return o.texels or MOST end
  local each = bytes_of(o)
  if o.bytes < 16 * each then return check.fail("lightmap: bytes must be at least %d, %d a texel", 16 * each, each) end
  return math.floor(o.bytes / each)
end

--- The options that a bake that goes on must have in common, and the fingerprints of its scene, a line a fact.
local function words_of(traced, o, texels)
  local list = { "version and kernels " .. table.concat({ core.info() }, " ", 1, 2) }
  for _, name in ipairs { "tolerance", "quantity", "directional", "spread", "parts", "smooth", "judge", "gutter", "angle",
    "stretch", "rays", "light_samples", "seed" } do
    local x = o[name]
    list[#list + 1] = name .. " " .. (type(x) == "number" and ("%.17g"):format(x) or tostring(x))
  end
  list[#list + 1] = ("texels %d"):format(texels)
  local known = prints.of(traced, o.quantity)
  for _, part in ipairs { "geometry", "materials", "lights" } do
    if known[part] then list[#list + 1] = part .. " " .. known[part] end
  end
  return table.concat(list, "\n") .. "\n"
end

local function bake(s, traced, o, texels)
  local start = core.seconds()
  local lit, message, code = transfer.fields.radiosity("lightmap", s, o, o.seed)
  if not lit then return nil, message, code end
  local paths, map = o.tolerance and o.judge == "paths"
  map, message, code = check.result("lightmap", traced.lib.map_bake(lit, { tolerance = o.tolerance or 0, aim = paths and AIM or 1,
    texels = texels,
    even = o.spread == "even", parts = o.parts, smooth = o.smooth, directional = o.directional, gutter = o.gutter,
    angle = o.angle, stretch = o.stretch, quantity = o.quantity, indirect = not transfer.fields.is_direct(o),
    journal = o.resume, words = o.resume and words_of(traced, o, texels),
    scene = o.quantity ~= "indirect" and traced.handle or nil, links = o.rays, light_samples = o.light_samples, seed = o.seed,
    threads = o.threads, progress = progress.resolve(o.progress) }))
  if not map then return nil, message, code end
  local m = { scene = s, traced = traced, lib = traced.lib, quantity = o.quantity, tolerance = o.tolerance,
    directional = o.directional, links = lit.links,
    stats = stats_of(traced.lib, map) }
  core.own(map).made = m
  local judged = true
  if paths then judged, message, code = judge(s, map, m, lit, o) end
  if not judged then return nil, message, code end
  if o.resume then os.remove(o.resume) end
  m.stats.bytes, m.stats.seconds = bytes_of(o) * m.stats.width * m.stats.height, core.seconds() - start
  if not o.tolerance then m.stats.met, m.stats.failed = nil, nil
  elseif not m.stats.met then
    m.stats.warning = warning.say(map, "lightmap", "lightmap: tolerance %.3g is not met, 99 %% of the places keep %s: %s",
      o.tolerance, m.stats.error < math.huge and ("%.3g"):format(m.stats.error) or "no bound",
      cause_of(m, o.tolerance * (paths and AIM or 1)))
  end
  return map
end

local room = [[
local scene = ylm.scene "a room" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.1, radiance = 10 },
  links = ylm.links { spacing = 0.4, rays = 64 },
}
]]

describe "scene:lightmap" {
  about = "Finds the irradiance on the scene's surfaces as one picture, and texture coordinates for all of them, whether or not "
    .. "their meshes have any (mesh:unwrap). Each side of a mesh that has light gets charts of its own. Texels are fitted to "
    .. "places spread over the charts as bilinear look-ups read them, so that seams agree; they are dense where light bends, and "
    .. "averaged where it is smooth.",
  arguments = { { "options?", "table", "" } },
  options = all_options,
  returns = { { "light", "lightmap", "light:save 'room.glb', light:image(), light:pieces(); light.stats" } },
  errors = "raises on a bad option, where there is no geometry, and of resume on a file that is another bake's, or that one is "
    .. "writing; nil, message, code: memory, cancelled, 'ELIMIT' where the charts do not fit into the texels, 'EFORMAT' where "
    .. "resume is no such file",
  example = room .. [[
local light = scene:lightmap { texels = 256, rays = 4 }
assert(light.stats.charts >= 6 and light.stats.width * light.stats.height <= 256)]],
}
function lightmaps.lightmap(s, given)
  tracing.check_scene("lightmap", s)
  local o = form.options(1, "lightmap", all_options, given)
  o.progress = progress.long(o.progress)
  local texels = texels_of(o)
  if not (o.tolerance or o.texels or o.bytes) then o.tolerance = TOLERANCE end
  if #s.geometry == 0 then return check.fail("lightmap: scene %q has no geometry, so no surfaces", s.name or "?") end
  transfer.fields.check("lightmap", s, o)
  local traced, message, code = tracing.trace("lightmap", s)
  if not traced then return nil, message, code end
  tracing.check_bodies("lightmap", traced)
  return bake(s, traced, o, texels)
end

-- Methods --------------------------------------------------------------------------------------

local function opened(name, map) return objects.opened(name, map, "ylm.lightmap", "a lightmap") end

describe "lightmap:irradiance" {
  about = "The irradiance at places of the scene's surfaces, as a bilinear look-up in the picture has it.",
  arguments = { { "points", "array|number[][]", "[n][3], on surfaces" },
    { "normals", "array|number[][]", "[n][3], of the surface's sides" } },
  returns = { { "E", "array", "float [n][3], W m^-2, at least 0" },
    { "charts", "array", "float [n], the charts that they lie on, from 1; 0: none" } },
  errors = "raises on other shapes, and where a point lies on no surface; nil, message, code where memory runs out",
  example = room .. [[
local light = scene:lightmap { texels = 256, rays = 4 }
assert(light:irradiance({ { 0, 1, 0 } }, { { 0, -1, 0 } }):get(1, 1) > 0)]],
}
function methods.irradiance(map, points, normals)
  local m = opened("irradiance", map)
  local x, n = options.places_with_normals("irradiance", points, normals)
  return check.result("irradiance", m.lib.map_irradiance(map, x, n))
end

describe "lightmap:image" {
  about = "The picture: irradiance, and which chart each texel is read for.",
  arguments = {},
  returns = { { "image", "image", "layers irradiance, W m^-2, row 1 on top, beyond charts that of the nearest; charts, "
    .. "numbers from 1, 0 beyond them; if directional flow_x, flow_y, flow_z, W m^-2: radiance times that part of its direction, "
    .. "summed over directions above the surface. At a normal n + d the irradiance is that of the picture plus the product of "
    .. "d and the flow" } },
  errors = "raises on what is no lightmap; nil, message, code where memory runs out",
  example = room .. [[
local image = scene:lightmap({ texels = 256, rays = 4 }):image()
assert(image:layer "irradiance":get(4, 4, 1) > 0)]],
}
function methods.image(map)
  local m = opened("image", map)
  local layers = { { "irradiance", 3 }, { "charts", 1 } }
  for _, name in ipairs(m.directional and files.flow or {}) do layers[#layers + 1] = { name, 3 } end
  return files.picture(m, map, layers)
end

describe "lightmap:pieces" {
  about = "The surfaces with their texture coordinates: a piece for each side of a mesh that has light. Vertices are split where "
    .. "charts end.",
  arguments = {},
  returns = { { "pieces", "table", "a list of { mesh, uvs: float [n][2], number: place in scene.geometry, back: whether it is "
    .. "the back of it, whose triangles and normals are turned, material, name }" } },
  errors = "raises on what is no lightmap; nil, message, code where memory runs out",
  example = room .. [[
local pieces = scene:lightmap({ texels = 256, rays = 4 }):pieces()
assert(#pieces == 1 and pieces[1].back and #pieces[1].mesh >= 12)]],
}
function methods.pieces(map)
  local m = opened("pieces", map)
  local list = {}
  for i = 1, m.stats.sheets do
    local number, back = m.lib.map_sheet(map, i)
    local of = m.scene.geometry[number]
    local mesh, uvs, code = check.result("pieces", m.lib.map_split(map, i, of.mesh))
    if not mesh then return nil, uvs, code end
    list[i] = { mesh = mesh, uvs = uvs, number = number, back = back, material = of.material, name = of.name,
      occludes = of.occludes }
  end
  return list
end

describe "lightmap:save" {
  about = "Writes the picture, and the surfaces beside it. NAME.glb and NAME.gltf: glTF whose TEXCOORD_1 reads NAME.exr, with "
    .. "the lamps where quantity is 'indirect'; NAME.obj: triangles whose vt reads NAME.exr; NAME.exr, NAME.ktx2, NAME.png: the "
    .. "picture alone; NAME.html: a page with a viewer, which needs no network. .exr and .ktx2: half floats, W m^-2; with a "
    .. "directional lightmap NAME_x.exr, NAME_y.exr and NAME_z.exr beside it. .png: irradiance is range (a rgb)^2, with a and "
    .. "rgb from 0 to 1. docs/engines.md says how engines read them.",
  arguments = { { "path", "string", "ends in .glb, .gltf, .obj, .exr, .ktx2, .png or .html" }, { "options?", "table", "" } },
  options = files.options,
  returns = { { "ok", "boolean", "true" }, { "facts", "table", "files: names of all that was written; range: of a .png, W m^-2; "
    .. "bytes: of a page; exposure: stops of lit and of a page; lamps: that are left to draw" } },
  errors = "raises on another ending or a bad option; nil, message, code: files, memory",
  example = room .. [[
local light, name = scene:lightmap { texels = 256, rays = 4 }, os.tmpname()
local _, facts = assert(light:save(name .. ".glb", { embed = true }))
assert(#facts.files == 1 and facts.range > 0)
os.remove(name .. ".glb")
os.remove(name)]],
}
function methods.save(map, path, given)
  return files.save(opened("save", map), map, path, given)
end

describe "lightmap:close" {
  about = "Frees the memory of a lightmap now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no lightmap",
  example = room .. "scene:lightmap({ texels = 256, rays = 4 }):close()",
}
function methods.close(map)
  if core.type(map) ~= "ylm.lightmap" then
    return check.fail("close: a lightmap expected before the colon, got %s", check.describe(map))
  end
  objects.close(map, objects.made(map).lib.map_close)
end

memory.publish(methods)

return lightmaps
