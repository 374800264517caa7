--- scene:surface_grid: irradiance on the surfaces of a scene, to a tolerance, and the methods of what it returns.

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
local NOISY = 2     -- times what paths do not refute, from which the error that they promise is noise
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
      .. "not enough; paths: what paths found, undecided, least: the smallest tolerance that they do not refute, field_met and "
      .. "field_error of the light that was fitted, paths: how many there were, seconds; bytes, seconds" },
    { "scene", "scene", "of what" },
    { "quantity", "string", "'direct', 'indirect' or 'all'" },
    { "tolerance", "number", "that was asked for" },
  },
}

local fields = {
  { "tolerance", "number", min = 1e-3, max = 10, default = 0.1,
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
    about = "what the tolerance is judged by: paths, up to 65536 from each of 2048 places; or the light of the elements that was "
      .. "fitted, whose own error is not seen" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  { "file", "path", optional = true,
    about = "reads a file of surface_grid:save instead, of a scene with the same meshes; other options are the file's" },
}
local all_options = options.list(fields, options.common)

-- Making ---------------------------------------------------------------------------------------

--- Is the paths' noise most of the error that they promise?
local function is_noisy(s) return s.paths ~= nil and s.error > NOISY * s.paths.least end

--- The words for what 99 % of the places keep.
local function kept(s)
  if is_noisy(s) then
    return ("%.2g by the elements' light; paths are too noisy to say more than %s"):format(s.paths.field_error,
      s.error < math.huge and unmet.rounded_up(s.error) or "that")
  end
  return s.error < math.huge and ("%.3g"):format(s.error) or "no bound"
end

--- Why a tolerance is not met, and what to change.
local function cause_of(m)
  local s, paths = m.stats, m.stats.paths
  local looser = "set tolerance = " .. (s.error < math.huge and unmet.rounded_up(s.error) or "larger")
  if is_noisy(s) then looser = "set a larger tolerance" end
  if (paths and promise.allowed or core.grid_allowed)(s.verified) < 0 then
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
    m.tolerance, kept(m.stats), cause_of(m))
  return g
end

--- Has paths judge a surface grid of light `lit`. True, or nil, message, code.
local function judge(s, g, m, lit, o)
  local points, normals, E = m.lib.surface_judges(g, lit, JUDGES, o.seed, o.threads or 0)
  if not points then return check.result("surface_grid", points, normals, E) end
  if #points == 0 then return true end
  local said, message, code = promise.compare(s, promise.lists(points), promise.lists(normals), promise.lists(E),
    o.tolerance, o.quantity, o)
  if not said then return nil, message, code end
  local paths = { field_met = m.stats.error <= o.tolerance, field_error = m.stats.error, undecided = said.undecided,
    least = said.least, paths = said.paths, seconds = said.seconds }
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

--- A surface grid of the light `lit`, of the lamps and materials of `lamps`, a traced scene; `like`: one whose rectangles it has.
-- Or nil, message, code.
local function fit(name, lit, lamps, o, like)
  return check.result(name, lamps.lib.surface_bake(lit, { tolerance = o.tolerance, aim = o.judge == "paths" and AIM or 1,
    quantity = o.quantity, lit = lamps.handle, corners = o.corners or 0, like = like,
    indirect = not transfer.fields.is_direct(o), scene = o.quantity ~= "indirect" and lamps.handle or nil, links = o.rays,
    light_samples = o.light_samples, seed = o.seed, threads = o.threads, progress = progress.resolve(o.progress) }))
end

--- The surface grid `g` of light `lit` with all that Lua keeps of it, and the verdict of its judge. Or nil, message, code.
local function judged(g, s, traced, o, lit)
  local m = remember(g, s, traced, o, lit.links)
  if o.judge ~= "paths" then return g end
  local done, message, code = judge(s, g, m, lit, o)
  if not done then return nil, message, code end
  return g
end

local function bake(s, traced, o)
  local lit, message, code = transfer.fields.radiosity("surface_grid", s, o, o.seed)
  if not lit then return nil, message, code end
  local g
  g, message, code = fit("surface_grid", lit, traced, o)
  if g then g, message, code = judged(g, s, traced, o, lit) end
  if not g then return nil, message, code end
  return say(g, objects.made(g))
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
  links = ylm.links { spacing = 0.4, rays = 64 },
}
]]

--- A coarse one, in a third of the time.
local coarse = room .. [[
local light = scene:surface_grid { tolerance = 0.5, corners = 100, judge = "field", rays = 16 }
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
local light = scene:surface_grid { tolerance = 0.3 }
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
  example = coarse .. [[
assert(light:irradiance({ { 0, 1, 0 } }, { { 0, -1, 0 } }):get(1, 1) > 0)]],
}
function methods.irradiance(g, points, normals)
  local m = opened("irradiance", g)
  local x, n = options.places_with_normals("irradiance", points, normals)
  return check.result("irradiance", m.lib.surface_irradiance(g, x, n, m.options.threads or 0))
end

local update_options = { form.threads, form.progress }

describe "surface_grid:update" {
  about = "Brings other light to a surface grid: lamps that moved, changed, appeared or vanished. Its rectangles stay, in "
    .. "another order; light is found anew at places spread over them and fitted, and fresh places judge. Links are those that "
    .. "it was made with. Where the light bends elsewhere now, the tolerance may be missed: stats.met and a warning say so, and "
    .. "scene:surface_grid makes other rectangles. Paths judge light of the scene's own lights; light of others is judged by "
    .. "that of the elements.",
  arguments = {
    { "lights?", "light|list", "all lights as they are now; default: the scene's lights as they are now" },
    { "options?", "table", "threads, progress" },
  },
  options = update_options,
  returns = { { "report", "table", "light.stats of the new light" } },
  errors = "raises on bad arguments and where the scene has other meshes now; nil, message, code: memory, cancelled; the grid is "
    .. "then as it was",
  example = coarse .. [[
local before = light:irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 } }):get(1, 1)
local report = light:update(ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.1, radiance = 20 })
local after = light:irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 } }):get(1, 1)
assert(math.abs(after / before - 2) < 0.1 and report.rectangles > 0)]],
}
function methods.update(g, lights, given)
  local m = opened("update", g)
  local o = form.options(2, "update", update_options, given)
  for key, value in pairs(m.options) do if o[key] == nil then o[key] = value end end
  o.progress = progress.long(given and given.progress)
  o.quantity, o.tolerance, o.links, o.judge = m.quantity, m.tolerance, m.links, lights and "field" or o.judge
  local traced, message, code = tracing.trace("update", m.scene)
  if not traced then return nil, message, code end
  if not objects.alike(traced, m.traced) then
    return check.fail("update: scene %q has other meshes now: make another surface grid (scene:surface_grid)",
      m.scene.name or "?")
  end
  local lamps, lit, new = traced, nil, nil
  if lights then lamps, message, code = tracing.relight("update", traced, lights) end
  if lamps then lit, message, code = transfer.fields.radiosity("update", m.scene, o, o.seed, lights) end
  if lit then new, message, code = fit("update", lit, lamps, o, g) end
  if new then new, message, code = judged(new, m.scene, traced, o, lit) end
  local taken
  if new then taken, message, code = check.result("update", m.lib.surface_take(g, new)) end
  if not taken then return nil, message, code end
  core.own(g).made = objects.made(new)
  m.lib.surface_close(new)
  say(g, objects.made(g))
  return g.stats
end

describe "surface_grid:rectangles" {
  about = "The rectangles, for drawing them and for programs of your own.",
  arguments = {},
  returns = { { "corners", "array", "float [n][4][3], relative to the scene's origin: (0, 0), (1, 0), (0, 1), (1, 1)" },
    { "irradiance", "array", "float [n][4][3], W m^-2, at these; between them it is bilinear" } },
  errors = "raises on what is no surface grid; nil, message, code where memory runs out",
  example = coarse .. [[
assert(light:rectangles().shape[1] == light.stats.rectangles)]],
}
function methods.rectangles(g)
  local m = opened("rectangles", g)
  return m.lib.surface_rectangles(g)
end

local of_grids = { html = true, ylm = true, vtu = true, ylmd = true } -- endings of files

describe "surface_grid:save" {
  about = "Writes a file that scene:surface_grid { file = } reads, of a scene with the same meshes.",
  arguments = { { "path", "string", "the file, by custom NAME.surfaces" } },
  returns = { { "ok", "boolean", "true, or nil, message, 'EIO'" } },
  errors = "raises on what is no file name; nil, message, code: files, memory",
  example = coarse .. [[
local name = os.tmpname()
assert(light:save(name))
assert(scene:surface_grid({ file = name }).stats.corners == light.stats.corners)
os.remove(name)]],
}
function methods.save(g, path)
  local m = opened("save", g)
  if type(path) ~= "string" or path == "" or path:find("%z") then
    return check.bad(1, "save", "the name of a file expected, got %s", check.describe(path))
  end
  local ending = path:lower():match "%.(%w+)$"
  if of_grids[ending] then
    return check.bad(1, "save", "%s: .%s is of grids (scene:bake { probes = adaptive_grid { ... } }); light on surfaces is "
      .. "NAME.surfaces", path, ending)
  end
  return check.result("save", m.lib.surface_write(g, path))
end

--- Methods of grids that light on surfaces has in another way.
local otherwise = {
  export = "engines read grids (scene:bake { probes = adaptive_grid { ... } }) and pictures of the same light (scene:lightmap)",
  sample = "it has irradiance alone, light:irradiance(points, normals): points in space take grids (scene:bake { probes = "
    .. "adaptive_grid { ... } })",
}

describe "surface_grid:close" {
  about = "Frees the memory of a surface grid now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no surface grid",
  example = coarse .. "light:close()",
}
function methods.close(g)
  if core.type(g) ~= "ylm.surface_grid" then
    return check.fail("close: a surface grid expected before the colon, got %s", check.describe(g))
  end
  objects.close(g, objects.made(g).lib.surface_close)
end

memory.publish(methods)

local index = methods.__index
methods.__index = function(g, key)
  if not otherwise[key] then return index(g, key) end
  return check.fail("%s: not of light on surfaces: %s", key, otherwise[key])
end

return surfaces
