--- Places that elements and lamps light, and that are no elements: links:receivers, and the methods of what it returns.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local lamplight = require "ylm.transfer.lamplight"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local progress = require "ylm.progress"
local texels = require "ylm.transfer.texels"
local vector = require "ylm.vector"

local methods = objects.kind("receivers", { "count", "left_out", "size", "points", "normals", "weights", "links" }, function(m)
  return ("%d places, %d in bodies left out"):format(m.count, m.left_out)
end)
objects.receivers = methods

local AROUND = 8 -- vertical normals of a cylindrical illuminance

require "ylm.describe".object "receivers" {
  about = "Places whose illuminance is asked for: planes of desks, points, meshes (links:receivers).",
  fields = {
    { "count", "integer", "places" },
    { "left_out", "integer", "places that are inside of bodies" },
    { "points", "array", "[n][3], scene units" },
    { "normals", "array", "[n][3]; of cylindrical ones the upright" },
    { "weights", "array", "double [n], the part of the area that each stands for: 1 together" },
    { "size", "table", "{ columns, rows } of a plane or a lightmap, else nil" },
    { "links", "links", "of which elements" },
  },
}

-- Where they are ------------------------------------------------------------------------------------------------

local plane_fields = {
  { "at", "point", unit = "scene units", about = "its middle" },
  { "size", "list", of = "number", unit = "scene units", about = "{ along x, across }: of a level plane along x and along z" },
  { "normal", "point", default = { 0, 1, 0 } },
  { "spacing", "number", above = 0, optional = true, unit = "scene units",
    about = "of places; default 0.2 x 5^(log10 d), d the longer side, 10 at most, as EN 12464-1 has it" },
}

--- Odd numbers of places along a side.
local function places_along(side, spacing)
  local n = math.max(1, math.floor(side / spacing + 0.5))
  return n % 2 == 1 and n or n + 1
end

--- Points, normals, weights and { columns, rows } of a plane.
local function of_plane(given)
  local function fail(message) return check.fail("receivers: plane: %s", message) end
  local p = form.check(plane_fields, given, fail)
  local normal = vector.unit(p.normal)
  if #p.size ~= 2 or not (p.size[1] > 0 and p.size[2] > 0) then return fail "size must be two numbers above 0" end
  if not normal or vector.length(p.normal) == 0 then return fail "normal must not be 0" end
  local u = vector.across(normal)
  local v = vector.cross(u, normal)
  local longest = math.max(p.size[1], p.size[2])
  local spacing = p.spacing or math.min(10, 0.2 * 5 ^ (math.log(longest) / math.log(10)))
  local nu, nv = places_along(p.size[1], spacing), places_along(p.size[2], spacing)
  if nu * nv > 2 ^ 20 then return fail(("%d x %d places are more than 2^20: a wider spacing"):format(nu, nv)) end
  local points, normals, weights = {}, {}, {}
  for k = 1, nv do
    for i = 1, nu do
      local s, t = p.size[1] * ((i - 0.5) / nu - 0.5), p.size[2] * ((k - 0.5) / nv - 0.5)
      local n = #points + 1
      points[n] = { p.at[1] + s * u[1] + t * v[1], p.at[2] + s * u[2] + t * v[2], p.at[3] + s * u[3] + t * v[3] }
      normals[n], weights[n] = normal, 1
    end
  end
  return points, normals, weights, { nu, nv }
end

--- Points, normals and areas of the elements of one mesh.
local function of_mesh(t, m, number)
  local elements = objects.links.elements(t)
  local centre, normal = elements.centre:totable(), elements.normal:totable()
  local area, mesh = elements.area:totable(), elements.mesh:totable()
  local points, normals, weights = {}, {}, {}
  for i = 1, #mesh do
    if mesh[i] == number and area[i] > 0 then
      points[#points + 1], normals[#normals + 1], weights[#weights + 1] = centre[i], normal[i], area[i]
    end
  end
  if #points == 0 then
    return check.fail("receivers: mesh = %d has no element; scene %q has %d pieces of geometry", number, m.scene.name or "?",
      #m.scene.geometry)
  end
  return points, normals, weights
end

--- Points, normals and areas of a mesh's texels, { columns, rows } and their numbers.
local function of_texels(m, o)
  local points, normals, areas, numbers = texels.of(m.scene, o.mesh, o.size[1], o.size[2], o.side == "back")
  return points, normals, areas, { o.size[1], o.size[2] }, numbers
end

--- Points with normals as they are given.
local function of_points(o)
  local points = array.points(1, "receivers", o.points, "double", "points"):totable()
  local weights, normals = {}, nil
  if o.normals ~= nil then normals = array.points(1, "receivers", o.normals, "double", "normals"):totable() end
  if normals and #normals ~= #points then
    return check.fail("receivers: %d points and %d normals: one of each is wanted", #points, #normals)
  end
  normals = normals or {}
  for i = 1, #points do
    local n = normals[i] or { 0, 1, 0 }
    normals[i] = vector.length(n) > 0 and vector.unit(n) or check.fail("receivers: normal %d is 0", i)
    weights[i] = 1
  end
  return points, normals, weights
end

local sources = { points = of_points, plane = true, mesh = true }

local function places_of(t, m, o)
  local given = {}
  for name in pairs(sources) do if o[name] ~= nil then given[#given + 1] = name end end
  if #given ~= 1 then return check.fail "receivers: give one of points (with normals), plane and mesh" end
  if o.size and not o.mesh then return check.fail "receivers: size is of a mesh: { width, height } of its lightmap" end
  if o.plane then return of_plane(o.plane) end
  if o.size then return of_texels(m, o) end
  if o.mesh then return of_mesh(t, m, o.mesh) end
  return of_points(o)
end

--- Upright places with AROUND level normals in place of each.
local function around(points, normals)
  local p, n = {}, {}
  for i, up in ipairs(normals) do
    local u, v = vector.frame(up)
    for k = 0, AROUND - 1 do
      local c, s = math.cos(2 * math.pi * k / AROUND), math.sin(2 * math.pi * k / AROUND)
      p[#p + 1] = points[i]
      n[#n + 1] = { c * u[1] + s * v[1], c * u[2] + s * v[2], c * u[3] + s * v[3] }
    end
  end
  return p, n
end

local function create(lib, t, points, normals, o)
  return check.result("receivers", lib.receivers_create(t, array.array(points, "double"), array.array(normals, "float"), o.rays,
    o.seed, o.threads, progress.resolve(o.progress)))
end

--- Which of the places are not inside of bodies, by the shares of their rays; `fold` of these belong to one.
local function outside(lib, handle, n, fold)
  local share, keep = lib.receivers_share(handle):totable(), {}
  for i = 1, n do
    local sum = 0
    for k = 1, fold do sum = sum + share[(i - 1) * fold + k] end
    if sum >= 0.5 * fold then keep[#keep + 1] = i end
  end
  return keep
end

local function chosen(list, keep)
  local out = {}
  for i, k in ipairs(keep) do out[i] = list[k] end
  return out
end

local options = {
  { "points", "any", optional = true, about = "places [n][3]" },
  { "normals", "any", optional = true, about = "of points [n][3]; default: up, +y" },
  { "plane", "table", optional = true, about = "{ at =, size =, normal = { 0, 1, 0 }, spacing = }: a grid of places" },
  { "mesh", "integer", min = 1, optional = true, about = "a place in scene.geometry: the middles of its elements" },
  { "size", "texels", optional = true, unit = "texels",
    about = "of a mesh with texture coordinates: { width, height } of a lightmap, whose texels' middles are then the places" },
  { "side", "choice", of = core.choices "side", default = "front", about = "of the mesh, with size" },
  { "quantity", "choice", of = { "illuminance", "cylindrical" }, default = "illuminance",
    about = "on the surface; or the mean of 8 level directions, for faces" },
  { "rays", "links", default = 256, about = "of each place, by which elements light it" },
  { "light_samples", "integer", min = 4, max = core.limits.transfer_links, optional = true,
    about = "shadow rays of each place: of derivatives to each lamp; default that of the radiosity" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all rays" },
  form.threads,
  form.progress,
}

local office = [[
local scene = ylm.scene "a room and a lamp" {
  geometry = { ylm.box { scale = 4, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.photometric_light { photometry = ylm.photometry { cosine = 1, lumens = 3000 }, at = { 0, 1.5, 0 } },
}
local t = scene:links { spacing = 1, rays = 64 }
local desk = t:receivers { plane = { at = { 0, -1, 0 }, size = { 3, 3 } } }
local lit = t:radiosity(scene.lights, { derivatives = true })
]]

describe "links:receivers" {
  about = "Places that are no elements, and the elements that each of them sees: a plane of desks, points, the middles of a "
    .. "mesh's elements, or of its lightmap's texels. Places inside of bodies are left out.",
  arguments = { { "options", "table", "one of points, plane and mesh is needed" } },
  options = options,
  returns = { { "r", "receivers", "r:illuminance(lit), r:figures(lit), r:map(lit); lit:importance { { r, weights = } }" } },
  errors = "raises on a bad option, and where all places are inside of bodies; nil, message, code: memory, cancelled",
  example = office .. [[
assert(desk.count == 49 and desk:figures(lit).uniformity < 1)]],
  source = "EN 12464-1 (spacing of planes)",
}
function objects.links.receivers(t, given)
  local m = objects.open_links("receivers", t)
  local o = form.options(1, "receivers", options, given)
  o.progress = progress.long(o.progress)
  local points, normals, weights, size, numbers = places_of(t, m, o)
  local n, fold = #points, o.quantity == "cylindrical" and AROUND or 1
  local function made(p, u)
    if fold > 1 then p, u = around(p, u) end
    return create(m.lib, t, p, u, o)
  end
  local handle, message, code = made(points, normals)
  if not handle then return nil, message, code end
  local keep = outside(m.lib, handle, n, fold)
  if #keep == 0 then return check.fail("receivers: all %d places are inside of bodies", n) end
  if #keep < n then
    points, normals, weights = chosen(points, keep), chosen(normals, keep), chosen(weights, keep)
    numbers = numbers and chosen(numbers, keep)
    handle, message, code = made(points, normals)
    if not handle then return nil, message, code end
  end
  local sum = 0
  for _, w in ipairs(weights) do sum = sum + w end
  for i, w in ipairs(weights) do weights[i] = w / sum end
  core.own(handle).made = { of = m, links = t, scene = m.scene, lib = m.lib, count = #keep, left_out = n - #keep, size = size,
    keep = numbers or keep, points = array.array(points, "double"), normals = array.array(normals, "double"),
    weights = array.array(weights, "double"), fold = fold, options = o }
  return handle
end

-- Their light ---------------------------------------------------------------------------------------------------

--- Points and normals [places x fold][3] that receivers stand for, and how many of these belong to one place.
function objects.places_of(r)
  local m = objects.made(r)
  local points, normals = m.points:totable(), m.normals:totable()
  if m.fold > 1 then points, normals = around(points, normals) end
  return array.array(points, "double"), array.array(normals, "float"), m.fold
end

--- The luminance [places] of irradiance, or of its variance, at such points.
function objects.luminance_of(E, count, fold)
  local Y = (E * core.luminance):sum(2)
  return fold > 1 and Y:reshape({ count, fold }):mean(2) or Y
end

function objects.open_receivers(name, r) return objects.opened(name, r, "ylm.receivers", "receivers") end

--- Direct light lamp by lamp at receivers for a radiosity with derivatives: made once for its lamps; or nil, message, code.
function objects.lamplight_at(name, r, lit)
  local m, of = objects.open_receivers(name, r), objects.open_radiosity(name, lit)
  if m.last and m.last.from == of.from then return m.last.lamplight end
  local o = of.options
  local samples = m.options.light_samples or o.light_samples
  samples = samples + samples % 2
  local rim = math.floor(o.rim * samples / o.light_samples / 2 + 0.5) * 2
  local made, message, code = lamplight.create(name, m, r, of.from.traced, of.from.lamps,
    { light_samples = samples, rim = rim, seed = m.options.seed + o.seed, bytes = o.bytes, threads = o.threads })
  if not made then return nil, message, code end
  m.last = { from = of.from, lamplight = made }
  return made
end

local function direct_at(name, r, m, lit, of)
  if of.from.lamps then
    local made, message, code = objects.lamplight_at(name, r, lit)
    if not made then return nil, message, code end
    return made:direct()
  end
  if not of.from.traced then
    return check.fail("%s: the radiosity's direct light is of a field without lamps, of which rays see nothing", name)
  end
  return check.result(name, m.lib.receivers_rays(r, of.from.traced.handle, m.options.light_samples or of.options.light_samples,
    m.options.seed + 1, of.options.threads))
end

--- Irradiance [places][3] before cylinders are folded; nil, message, code.
local function irradiance(name, r, lit)
  local m, of = objects.open_receivers(name, r), objects.open_radiosity(name, lit)
  if of.links ~= m.links then return check.fail("%s: the radiosity and the receivers are of different links", name) end
  local direct, message, code = direct_at(name, r, m, lit, of)
  if not direct then return nil, message, code end
  local rest
  rest, message, code = check.result(name, m.lib.receivers_indirect(r, lit, of.options.threads))
  if not rest then return nil, message, code end
  local E = direct + rest
  return m.fold > 1 and E:reshape({ m.count, m.fold, 3 }):mean(2) or E
end

--- Its luminance [places]; nil, message, code.
local function illuminance(name, r, lit)
  local E, message, code = irradiance(name, r, lit)
  if not E then return nil, message, code end
  return (E * core.luminance):sum(2)
end

describe "receivers:irradiance" {
  about = "Irradiance at the receivers: direct light, and all that elements send.",
  arguments = { { "lit", "radiosity", "of the same links" } },
  returns = { { "E", "array", "float [n][3], W m^-2, or lx in channels" } },
  errors = "raises where the radiosity is of other links, or of a field without lamps; nil, message, code: memory",
  example = office .. "assert(desk:irradiance(lit).shape[1] == desk.count)",
}
function methods.irradiance(r, lit) return irradiance("irradiance", r, lit) end

describe "receivers:illuminance" {
  about = "Illuminance at the receivers: the luminance of their irradiance, 0.2126 R + 0.7152 G + 0.0722 B.",
  arguments = { { "lit", "radiosity", "of the same links" } },
  returns = { { "E", "array", "[n], lx where lamps are photometric" } },
  errors = "as receivers:irradiance",
  example = office .. "assert(desk:illuminance(lit):min() > 0)",
}
function methods.illuminance(r, lit) return illuminance("illuminance", r, lit) end

--- Figures of illuminances [n] with weights [n].
function objects.figures(E, weights)
  local least, most, mean = E:min(), E:max(), (E * weights):sum()
  return { mean = mean, least = least, most = most, uniformity = mean > 0 and least / mean or 0,
    diversity = most > 0 and least / most or 0 }
end

describe "receivers:figures" {
  about = "Figures of the illuminance after the formulas of EN 12464-1: mean by area, least, most, uniformity (least over mean) "
    .. "and diversity (least over most).",
  arguments = { { "lit", "radiosity", "of the same links" } },
  returns = { { "figures", "table", "mean, least, most, lx; uniformity, diversity" } },
  errors = "as receivers:irradiance",
  example = office .. "assert(desk:figures(lit).mean > desk:figures(lit).least)",
}
function methods.figures(r, lit)
  local E, message, code = illuminance("figures", r, lit)
  if not E then return nil, message, code end
  return objects.figures(E, objects.made(r).weights)
end

--- Numbers of the places of a plane as rows and columns, 0 in bodies.
function objects.as_map(r, E)
  local m = objects.made(r)
  local all, values = {}, E:totable()
  for i = 1, m.size[1] * m.size[2] do all[i] = 0 end
  for i, k in ipairs(m.keep) do all[k] = values[i] end
  return array.array(all, "float"):reshape { m.size[2], m.size[1] }
end

describe "receivers:map" {
  about = "The illuminance of a plane, or of a lightmap, as rows and columns: for ylm.figure.",
  arguments = { { "lit", "radiosity", "of the same links" } },
  returns = { { "map", "array", "float [rows][columns], lx; 0 inside of bodies and beside the mesh" } },
  errors = "raises of receivers that are no plane; else as receivers:irradiance",
  example = office .. "assert(desk:map(lit).shape[1] == desk.size[2])",
}
function methods.map(r, lit)
  local m = objects.open_receivers("map", r)
  if not m.size then return check.fail "map: these receivers are no plane, and no lightmap" end
  local E, message, code = illuminance("map", r, lit)
  if not E then return nil, message, code end
  return objects.as_map(r, E)
end

describe "receivers:close" {
  about = "Frees the memory of receivers now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what are no receivers",
  example = office .. "desk:close()",
}
function methods.close(r)
  if core.type(r) ~= "ylm.receivers" then
    return check.fail("close: receivers expected before the colon, got %s", check.describe(r))
  end
  objects.close(r, objects.made(r).lib.receivers_close)
end

memory.publish(methods)

return methods
