--- scene:surface_grid: irradiance on the surfaces of a scene, to a tolerance, and the methods of what it returns.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local options = require "ylm.render.options"
local prints = require "ylm.render.prints"
local progress = require "ylm.progress"
local promise = require "ylm.render.promise"
local tracing = require "ylm.trace"
local transfer = require "ylm.transfer"
local unmet = require "ylm.grid.unmet"
local warning = require "ylm.warning"

local surfaces = {}

local JUDGES = 2048 -- places by which paths judge
local AIM = 0.6     -- of its tolerance, for which light is fitted that paths will judge: they see the elements' error too
local LEAST_SPACING = 0.35 -- of the links' spacing, the least that a warning names

local methods = objects.kind("surface_grid", { "stats", "scene", "quantity", "tolerance" }, function(m)
  return ("%s light, %d rectangles, %d corners"):format(m.quantity, m.stats.rectangles, m.stats.corners)
end)

require "ylm.describe".object "surface_grid" {
  about = "Irradiance on the surfaces of a scene, between the corners of rectangles (scene:surface_grid).",
  fields = {
    { "stats", "table", "corners: numbers a channel that were fitted; rectangles; charts: planes and maps that these lie on; "
      .. "rows: corners with those that hang on longer edges; places whose light was asked for, rays, rounds; verified, failed: "
      .. "places that judged, and those that missed the tolerance; error: what 99 % of the surface keep, with 99 % confidence; "
      .. "rms: root mean square error over the mean, without noise; met; warning: what is not kept, or nil; spent: corners were "
      .. "not enough; paths: what paths found, undecided, field_met and field_error of the light that was fitted, seconds; "
      .. "bytes, seconds" },
    { "scene", "scene", "of what" },
    { "quantity", "string", "'direct', 'indirect' or 'all'" },
    { "tolerance", "number", "that was asked for" },
  },
}

local fields = {
  { "tolerance", "number", min = 1e-3, max = 10, default = 0.05,
    about = "of irradiance at 99 % of the surface by area, relative to the larger of the place's and the mean" },
  { "quantity", "choice", of = { "direct", "indirect", "all" }, default = "indirect",
    about = "'indirect', what surfaces send back; 'direct', light of lamps and sky with shadows; 'all', both. Edges of shadows "
      .. "take many rectangles" },
  { "corners", "integer", min = 16, max = 2 ^ 24, optional = true,
    about = "at most about so many numbers a channel: a budget, which ends refinement before the tolerance" },
  transfer.fields.bounces, transfer.fields.links,
  { "rays", "links", default = 64, shelf = "experiments", about = "of a place whose light is fitted, twice" },
  { "light_samples", "integer", min = 1, max = core.limits.transfer_links, default = options.LIGHT_SAMPLES,
    shelf = "experiments", about = "of 'direct' and 'all': shadow rays of a place, twice" },
  { "judge", "choice", of = { "paths", "field" }, default = "paths", shelf = "experiments",
    about = "what the tolerance is judged by: paths, up to 16384 from each of 2048 places; or the light of the elements that was "
      .. "fitted, whose own error is not seen" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  { "file", "path", optional = true,
    about = "reads a file of surface_grid:save instead, of a scene with the same meshes; other options are the file's" },
}
local all_options = options.list(fields, options.common)

-- Making ---------------------------------------------------------------------------------------

--- Why a tolerance is not met, and what to change.
local function cause_of(m)
  local s, paths = m.stats, m.stats.paths
  local looser = "set tolerance = " .. (s.error < math.huge and unmet.rounded_up(s.error) or "larger")
  if core.grid_allowed(s.verified) < 0 then
    return ("the %d places that were found open are too few to judge by: all other surface is in bodies, or covered by surfaces "
      .. "nearby"):format(s.verified)
  end
  if s.spent then return "its corners are spent; leave corners out, or " .. looser end
  if paths and paths.field_met then
    local undecided = unmet.undecided(s, paths)
    if undecided then return undecided .. "; " .. looser end
    return ("the light of elements is that far from the paths; give links = scene:links { spacing = %.2g }, or %s"):format(
      math.max(LEAST_SPACING, m.tolerance / s.error) * m.links.stats.spacing, looser)
  end
  return ("%d rounds of refinement end above it; %s"):format(s.rounds, looser)
end

--- Completes the stats with what is not kept, and says it.
local function say(g, m)
  if m.stats.met then return g end
  m.stats.warning = warning.say(g, "surface grid", "surface_grid: tolerance %.3g is not met, 99 %% of the places keep %s: %s",
    m.tolerance, m.stats.error < math.huge and ("%.3g"):format(m.stats.error) or "no bound", cause_of(m))
  return g
end

--- The rows of an array as lists.
local function lists(a)
  local rows = {}
  for i = 1, #a do rows[i] = { a:get(i, 1), a:get(i, 2), a:get(i, 3) } end
  return rows
end

--- Has paths judge a surface grid of light `lit`. True, or nil, message, code.
local function judge(s, g, m, lit, o)
  local points, normals, E = m.lib.surface_judges(g, lit, JUDGES, o.seed, o.threads or 0)
  if not points then return check.result("surface_grid", points, normals, E) end
  if #points == 0 then return true end
  local said, message, code = promise.compare(s, lists(points), lists(normals), lists(E), o.tolerance, o.quantity, o)
  if not said then return nil, message, code end
  local paths = { field_met = m.stats.met, field_error = m.stats.error, undecided = said.undecided, seconds = said.seconds }
  m.lib.surface_verdict(g, #points, said.failed + said.undecided, said.error, said.rms)
  m.stats = m.lib.surface_stats(g)
  m.stats.paths = paths
  return true
end

--- All that Lua keeps of a surface grid; `links`: those whose scene it is of, or nil.
local function remember(g, s, traced, o, links)
  local stats, known, tolerance, quantity = traced.lib.surface_stats(g)
  local m = { scene = s, traced = traced, lib = traced.lib, quantity = quantity, tolerance = tolerance, options = o,
    links = links, prints = prints.needed(known, quantity), stats = stats }
  core.own(g).made = m
  return m
end

local function bake(s, traced, o)
  local lit, message, code = transfer.fields.radiosity("surface_grid", s, o, o.seed)
  if not lit then return nil, message, code end
  local direct, by_paths, g = o.quantity ~= "indirect", o.judge == "paths"
  g, message, code = check.result("surface_grid", traced.lib.surface_bake(lit, { tolerance = o.tolerance,
    aim = by_paths and AIM or 1, quantity = o.quantity, lit = traced.handle, corners = o.corners or 0,
    indirect = not transfer.fields.is_direct(o), scene = direct and traced.handle or nil, links = o.rays,
    light_samples = o.light_samples, seed = o.seed, threads = o.threads, progress = progress.resolve(o.progress) }))
  if not g then return nil, message, code end
  local m = remember(g, s, traced, o, lit.links)
  if by_paths then
    local done
    done, message, code = judge(s, g, m, lit, o)
    if not done then return nil, message, code end
  end
  return say(g, m)
end

local function from_file(s, traced, o, given)
  for key in pairs(given) do
    if key ~= "file" and key ~= "threads" and key ~= "progress" then
      return check.fail("surface_grid: %s is the file's: leave it out beside file", tostring(key))
    end
  end
  local g, message, code = check.result("surface_grid", traced.lib.surface_read(traced.handle, o.file))
  if not g then return nil, message, code end
  remember(g, s, traced, o)
  return g
end

local room = [[
local scene = ylm.scene "a room" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.1, radiance = 10 },
}
]]

describe "scene:surface_grid" {
  shelf = "everyday",
  about = "Finds the irradiance on the scene's surfaces to a tolerance, and keeps it in few numbers: rectangles that are halved "
    .. "where light bends, continuous on a surface, apart where walls part them. Look-ups trace no ray. Pictures take it as "
    .. "bounced. It needs no texture coordinates.",
  arguments = { { "options?", "table", "" } },
  options = all_options,
  returns = { { "light", "surface_grid", "light:irradiance(points, normals); light.stats" } },
  errors = "raises on a bad option, where there is no geometry, and on a file of another scene; nil, message, code: files, "
    .. "memory, cancelled",
  example = room .. [[
local light = scene:surface_grid { tolerance = 0.1 }
assert(light.stats.met and light.stats.corners < 1000)
local E = light:irradiance({ { 0, -1, 0 }, { 0.5, -1, 0.2 } }, { { 0, 1, 0 }, { 0, 1, 0 } })
assert(E:get(1, 1) > E:get(2, 1))]],
}
function surfaces.surface_grid(s, given)
  tracing.check_scene("surface_grid", s)
  local o = form.options(1, "surface_grid", all_options, given)
  o.progress = progress.long(o.progress)
  if #s.geometry == 0 then
    return check.fail("surface_grid: scene %q has no geometry, so no surfaces", s.name or "?")
  end
  transfer.fields.check("surface_grid", s, o)
  local traced, message, code = tracing.trace("surface_grid", s)
  if not traced then return nil, message, code end
  if o.file then return from_file(s, traced, o, given) end
  return bake(s, traced, o)
end

-- Methods --------------------------------------------------------------------------------------

local function opened(name, g) return objects.opened(name, g, "ylm.surface_grid", "a surface grid") end
surfaces.opened = opened

describe "surface_grid:irradiance" {
  about = "The irradiance at places of the scene's surfaces, on the side that the normal is of. No ray is traced.",
  arguments = { { "points", "array|number[][]", "[n][3], on surfaces" },
    { "normals", "array|number[][]", "[n][3], of the surface's sides" } },
  returns = { { "E", "array", "float [n][3], W m^-2, at least 0" }, { "numbers", "array", "float [n], the rectangles that they "
    .. "lie on, from 1; 0: none" } },
  errors = "raises on other shapes, and where a point lies on no surface; nil, message, code where memory runs out",
  example = room .. [[
local light = scene:surface_grid { tolerance = 0.2 }
assert(light:irradiance({ { 0, 1, 0 } }, { { 0, -1, 0 } }):get(1, 1) > 0)]],
}
function methods.irradiance(g, points, normals)
  local m = opened("irradiance", g)
  local x = array.places(1, "irradiance", points)
  local n = array.points(2, "irradiance", normals, "float", "normals")
  if #x ~= #n then
    return check.bad(2, "irradiance", "%d normals expected, one a point, got %d", #x, #n)
  end
  return check.result("irradiance", m.lib.surface_irradiance(g, x, n, m.options.threads or 0))
end

describe "surface_grid:rectangles" {
  about = "The rectangles, for drawing them and for programs of your own.",
  arguments = {},
  returns = { { "corners", "array", "float [n][4][3], relative to the scene's origin: (0, 0), (1, 0), (0, 1), (1, 1)" },
    { "irradiance", "array", "float [n][4][3], W m^-2, at these; between them it is bilinear" } },
  errors = "raises on what is no surface grid; nil, message, code where memory runs out",
  example = room .. [[
local light = scene:surface_grid { tolerance = 0.2 }
assert(light:rectangles().shape[1] == light.stats.rectangles)]],
}
function methods.rectangles(g)
  local m = opened("rectangles", g)
  return m.lib.surface_rectangles(g)
end

describe "surface_grid:save" {
  about = "Writes a file that scene:surface_grid { file = } reads, of a scene with the same meshes.",
  arguments = { { "path", "string", "the file, by custom NAME.surfaces" } },
  returns = { { "ok", "boolean", "true, or nil, message, 'EIO'" } },
  errors = "raises on what is no file name; nil, message, code: files, memory",
  example = room .. [[
local light, name = scene:surface_grid { tolerance = 0.2 }, os.tmpname()
assert(light:save(name))
assert(scene:surface_grid({ file = name }).stats.corners == light.stats.corners)
os.remove(name)]],
}
function methods.save(g, path)
  local m = opened("save", g)
  if type(path) ~= "string" or path == "" or path:find("%z") then
    return check.bad(1, "save", "the name of a file expected, got %s", check.describe(path))
  end
  return check.result("save", m.lib.surface_write(g, path))
end

describe "surface_grid:close" {
  about = "Frees the memory of a surface grid now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no surface grid",
  example = room .. "scene:surface_grid({ tolerance = 0.5 }):close()",
}
function methods.close(g)
  if core.type(g) ~= "ylm.surface_grid" then
    return check.fail("close: a surface grid expected before the colon, got %s", check.describe(g))
  end
  objects.close(g, objects.made(g).lib.surface_close)
end

memory.publish(methods)

return surfaces
