--- Bodies that hide light: ylm.occluder.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local library = require "ylm.library"
local memory = require "ylm.memory"
local reference = require "ylm.describe"
require "ylm.grid" -- defines grid.body

local describe = reference.describe

local EXTENT = core.limits.extent

local occluder = {}

reference.object "occluder" {
  about = "The visibility around a body, a light field; from the constructor of that name.",
  fields = { { "radius", "number", "of a sphere around the body" }, { "area", "number", "the mean of its projections' areas" },
    { "rays", "integer", "of a body by rays, else nil" } },
}

local occluders = core.metatable "ylm.occluder"

--- The mesh of a mesh or a shape, else nil.
local function mesh_of(x)
  if core.type(x) == "ylm.mesh" then return x end
  local mesh = type(x) == "table" and form.kind(x) and rawget(x, "mesh")
  return core.type(mesh) == "ylm.mesh" and mesh or nil
end

--- An object that C makes for a form, or nil, message, code; fail(message) raises.
local function made(fail, object, message, code)
  if object == nil and core.status(code) == "caller" then return fail(message) end
  return object, message, code
end

local BY_RAYS = "bodies by rays need libylm_scene with Embree 3 or 4 (Debian 12 and 13: apt install libembree-dev, then make): %s"

--- { rays, near } of an occluder: rays of one that is known by rays, where the nearest receivers are; nil once closed.
local function how_of(o) return core.owned(o, "how") end

--- The object of a closed mesh: exact, or by rays.
local function build_mesh(values, mesh, fail)
  if not values.rays then return made(fail, core.occluder_solid(mesh)) end
  local tracer, message, code = library.open("scene", BY_RAYS)
  if not tracer then return nil, message, code end
  return made(fail, tracer.occlusion_create(mesh, values.rays))
end

--- The object, and where its nearest receivers are.
local function remember(values, object, message, code)
  if not object then return nil, message, code end
  core.own(object).how = { rays = values.rays, near = values.near }
  return object
end

local function build_occluder(values, fail)
  if values.rays and values.geometry == nil then return fail "rays are of geometry: a sphere is known exactly" end
  if values.geometry ~= nil then
    if values.radius then return fail "radius is of a sphere: give geometry or radius, not both" end
    if values.at then return fail "at is of a sphere: geometry is where its vertices are" end
    local mesh = mesh_of(values.geometry)
    if not mesh then return fail("geometry must be a mesh or a shape, got " .. check.describe(values.geometry)) end
    return remember(values, build_mesh(values, mesh, fail))
  end
  if not values.radius then return fail "give geometry, a closed convex mesh, or radius, of a sphere" end
  local at = values.at or { 0, 0, 0 }
  return remember(values, made(fail, core.occluder_sphere(at[1], at[2], at[3], values.radius)))
end

occluder.occluder = form.define("occluder", {
  numbers = 1e5,
  about = "The visibility around one body, as a light field: 1 from where light reaches a point, 0 from where the body "
    .. "is. Exact for spheres and convex solids, with gradients and Hessians; by rays for other closed meshes, with gradients. "
    .. "It is no light: ylm.caster puts it in the way of lights, ylm.bake remembers it. It has radius, of a sphere around the "
    .. "body, area, the mean of its projections, rays, noise() and close().",
  fields = {
    { "geometry", "any", optional = true, unit = "scene units",
      about = "a closed mesh or shape in the body's frame; without rays it is convex, of at most 4096 triangles" },
    { "radius", "number", above = 0, max = EXTENT, optional = true, unit = "scene units", about = "of a sphere instead" },
    { "at", "point", optional = true, unit = "scene units", about = "centre of the sphere, default {0, 0, 0}" },
    { "rays", "integer", min = 4, max = 1024, optional = true,
      about = "geometry of any shape, by rays: so many along a right angle, twice as many across a body that is seen within "
        .. "one; 64 is a good number. Parts that look thinner than the distance of two rays may be missed" },
    { "near", "number", above = 0, max = 1, default = 0.02, unit = "radii",
      about = "how near to the surface the places are that a bake of it serves" },
  },
  build = build_occluder,
  example = "occluder { radius = 0.5 }",
  source = "Zhou et al. 2005",
})

--- The sphere around a body and its mean area: at, radius, area; nil once closed.
local function body_of(o)
  local x, y, z, radius, area = core.occluder_body(o)
  if x then return { x, y, z }, radius, area end
end

function occluders.__index(o, key)
  if key == "radius" then return (select(2, body_of(o))) end
  if key == "area" then return (select(3, body_of(o))) end
  if key == "rays" then return (how_of(o) or {}).rays end
  return rawget(occluders, key)
end

function occluders.__tostring(o)
  local _, radius = body_of(o)
  return radius and ("ylm.occluder of radius %g"):format(radius) or "ylm.occluder (closed)"
end

-- Grids of bodies reach so many radii where nobody says; their tolerance holds at so many places. The noise of rays is
-- measured at so many, and a tolerance is so many times the noise, or more.
local REACH, PLACES, LOOKS, QUIET = 20, 20000, 16, 2

--- Places around a body, from `near` radii off its surface to a distance: float [n][3]; nil, message, code.
local function places_around(o, near, far, n)
  local _, radius = body_of(o)
  local exact = not how_of(o).rays -- near of a convex body is a part of the way from its middle to its surface
  return check.result("occluder", core.occluder_places(o, exact and near or near * radius, far, n))
end

describe "occluder:noise" {
  about = "The error of the values of a body by rays, as a part of the function 1: half of the largest distance to those by half "
    .. "of the rays, at 16 places around the body.",
  arguments = { { "lmax", "integer", "highest degree, 0 to 100" }, { "options?", "table", "see the options" } },
  options = { form.threads },
  returns = { { "noise", "number", "0 of a body that is known exactly" } },
  errors = "raises on bad arguments and a body that has been closed; nil, message, code: memory",
  example = [[
local body = ylm.occluder { geometry = ylm.box {} }
assert(body:noise(4) == 0)]],
}
function occluders.noise(o, lmax, given)
  if core.type(o) ~= "ylm.occluder" then
    return check.fail("noise: an occluder expected before the colon, got %s", check.describe(o))
  end
  check.integer(1, "noise", "lmax", lmax, 0, core.limits.sh_product_lmax)
  local options = form.options(2, "noise", { form.threads }, given)
  local _, radius = body_of(o)
  if not radius then return check.fail("noise: the occluder has been closed") end
  if not how_of(o).rays then return 0 end
  local places, message, code = places_around(o, how_of(o).near, REACH * radius, LOOKS)
  if not places then return nil, message, code end
  return check.result("noise", library.open("scene", BY_RAYS).occlusion_noise(o, lmax, places, options.threads or 0))
end

--- Refuses a tolerance that is below the noise of rays; nil, message, code.
local function check_noise(o, description)
  if not description.tolerance then return true end
  local noise, message, code = o:noise(description.lmax)
  if not noise then return nil, message, code end
  if description.tolerance >= QUIET * noise then return true end
  return check.bad(1, "bake", "tolerance %g is below the noise of rays here, %.2g: rays = %d may do, or tolerance = %.2g",
    description.tolerance, noise, math.min(1024, math.ceil(how_of(o).rays * QUIET * noise / description.tolerance)),
    QUIET * noise * 1.05)
end

--- Options of a bake of a body, for lua/ylm/grid/bake.lua: bounds and places where nobody says.
function occluders.__for_grid(o, description, given)
  local at, radius, area = body_of(o)
  if description.channels == "rgb" then
    return check.bad(1, "bake", "a visibility has no colour: channels = 'luminance' in the grid")
  end
  if not at then return check.bad(2, "bake", "the occluder has been closed") end
  local quiet, message, code = check_noise(o, description)
  if not quiet then return nil, message, code end
  local options, box = {}, description.bounds or given.bounds
  for key, value in pairs(given) do options[key] = value end
  if not box then
    local r = REACH * radius
    box = { { at[1] - r, at[2] - r, at[3] - r }, { at[1] + r, at[2] + r, at[3] + r } }
    options.bounds = box
  end
  if given.occupied == nil and given.geometry == nil and description.depth then
    local far = math.huge
    for a = 1, 3 do far = math.min(far, at[a] - box[1][a], box[2][a] - at[a]) end
    options.occupied, message, code = places_around(o, how_of(o).near, math.max(far, 2 * radius), PLACES)
    if not options.occupied then return nil, message, code end
  end
  return options, { at[1], at[2], at[3], radius, area }
end

describe "occluder:close" {
  about = "Frees the memory of a body now rather than at the next collection.",
  arguments = {}, returns = {}, errors = "raises on what is no body",
  example = "ylm.occluder({ radius = 1 }):close()",
}
function occluders.close(o)
  if core.type(o) ~= "ylm.occluder" then
    return check.fail("close: an occluder expected before the colon, got %s", check.describe(o))
  end
  check.result("close", core.occluder_close(o))
end

memory.publish(occluders)

occluder.mesh_of, occluder.made, occluder.body_of = mesh_of, made, body_of

return occluder
