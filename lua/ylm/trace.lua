--- Scenes as the library that traces rays wants them: traced once, as long as they are unchanged.

local boxes = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local library = require "ylm.library"
local light = require "ylm.light"
local material = require "ylm.material"
local text = require "ylm.text"
local warning = require "ylm.warning"

local tracing = {}

local GROUND_MARGIN = 0.02 -- of the diagonal of what stands on grounds
local LEAST, MOST = 3e-8, 6e9 -- of a scene's diagonal: squares of the areas of larger triangles are no floats

local MISSING = "rendering needs libylm_scene with Embree 3 or 4 (Debian 12 and 13: apt install libembree-dev, then make): %s"

--- The library that traces rays, or nil, message, "EMISSING" | "ENOMEM".
function tracing.library()
  return library.open("scene", MISSING)
end

function tracing.check_scene(name, s)
  if form.kind(s) == "scene" then return s end
  return check.fail("%s: a scene expected before the colon, got %s", name, check.describe(s))
end

--- Do two lists hold the same things?
local function same(a, b)
  if #a ~= #b then return false end
  for i = 1, #a do if a[i] ~= b[i] then return false end end
  return true
end

--- Flat list of all that meshes of a traced scene depend on.
local function shapes_of(s)
  local parts = {}
  for _, g in ipairs(s.geometry) do
    parts[#parts + 1] = g.mesh
    parts[#parts + 1] = g.occludes ~= false
    parts[#parts + 1] = g.material or material.default -- materials do not change
  end
  return parts
end

--- Flat list of all that its lamps depend on.
local function lamps_of(s)
  local parts = { s.sky_is_seen or false }
  for _, l in ipairs(s.lights) do
    parts[#parts + 1] = l
    local as_light = type(l) == "table" and form.defined[form.kind(l)].light
    if as_light and as_light.record then as_light.record(l, parts) end
  end
  return parts
end

--- The words for piece i of a scene's geometry: its number, and the name that its file gives it.
function tracing.mesh_text(s, i)
  local name = s.geometry[i] and s.geometry[i].name
  if not name then return ("mesh %d"):format(i) end
  return ("mesh %d, '%s'"):format(i, text.shown(check.short(name)))
end

--- A message of C that begins with the number of a mesh, with its name.
local function with_name(s, message)
  return type(message) == "string" and message:gsub("^mesh (%d+)", function(i) return tracing.mesh_text(s, tonumber(i)) end)
    or message
end

--- Arguments of scene_create about geometry, and the number of glossy meshes; nil, message, code.
local function surfaces(name, s)
  local meshes, materials, occludes, textures, glossy = {}, {}, {}, {}, 0
  for i, g in ipairs(s.geometry) do
    local m, message, code = g.material or material.default
    meshes[i], occludes[i], textures[i] = g.mesh, g.occludes ~= false, material.texture(m) or false
    materials[i], message, code = material.object(name, m)
    if not materials[i] then return nil, message, code end
    if material.glossy(m) then glossy = glossy + 1 end
    local direction = material.direction(m, materials[i])
    if direction and not core.mesh_uvs(g.mesh) then
      return check.fail("%s: %s needs uvs: %s has none", name, direction, tracing.mesh_text(s, i))
    end
  end
  return { meshes, materials, occludes, textures, glossy = glossy }
end

--- Says where a scene is so large or so small that rays in floats lose its light; returns the sentence or nil.
local function say_extent(s, lo, hi)
  local d = boxes.diagonal(lo, hi)
  if d >= LEAST and d <= MOST or d == 0 or d ~= d then return nil end
  return warning.say(s, "extent", "scene %q: its geometry is %.2g across, and rays lose light %s %.0e: %s its lengths",
    s.name or "?", d, d > MOST and "above" or "below", d > MOST and MOST or LEAST, d > MOST and "divide" or "multiply")
end

--- { handle, lights, bounds, glossy: the number of such meshes, seconds, shortfall: a sentence or nil } of a scene; nil,
-- message, code. Where lights alone have changed since the last call, meshes are shared with what was made then.
function tracing.trace(name, s)
  local lib, message, code = tracing.library()
  if not lib then return nil, message, code end
  local shapes, lamps, known = shapes_of(s), lamps_of(s), core.owned(s, "traced")
  local alike = known and same(known.shapes, shapes)
  if alike and same(known.lamps, lamps) then
    if known.shortfall then say_extent(s, known.lo, known.hi) end -- it may have been traced where nothing is said
    return known
  end
  local start, made = core.seconds(), nil
  if not alike then
    made, message, code = surfaces(name, s)
    if not made then return nil, message, code end
  end
  local lights
  lights, message, code = light.pack(1, name, s.lights)
  if not lights then return nil, message, code end
  local handle
  if alike then
    handle, message, code = lib.scene_relight(known.handle, light.set(lights), s.sky_is_seen)
  else
    handle, message, code = lib.scene_create(made[1], made[2], made[3], light.set(lights), s.sky_is_seen, made[4])
  end
  handle, message, code = check.result(name, handle, with_name(s, message), code)
  if not handle then return nil, message, code end
  local lo, hi = lib.scene_bounds(handle)
  local new = { shapes = shapes, lamps = lamps, handle = handle, lights = lights, lo = lo, hi = hi, lib = lib,
    glossy = alike and known.glossy or made.glossy, seconds = core.seconds() - start, shortfall = say_extent(s, lo, hi) }
  core.own(s).traced = new
  return new
end

--- The box of what stands on a scene's grounds, a little larger, where its camera is in that; nil where there is no ground, or
-- nil, message, code. And the box of all.
function tracing.without_grounds(name, s)
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  local from = s.camera and s.camera.from
  if not from then return nil end
  local lo, hi, why = check.result(name, t.lib.scene_core(t.handle, from[1], from[2], from[3]))
  if not lo then return nil, hi, why end
  if boxes.diagonal(lo, hi) >= boxes.diagonal(t.lo, t.hi) then return nil end
  local within, margin = { {}, {} }, GROUND_MARGIN * boxes.diagonal(lo, hi)
  for k = 1, 3 do within[1][k], within[2][k] = lo[k] - margin, hi[k] + margin end
  return within, { t.lo, t.hi }
end

--- The surfaces of a scene that hide light, as core's bakes and look-ups take them; nil, message, code.
function tracing.walls(name, s)
  local t, message, code = tracing.trace(name, s)
  if not t then return nil, message, code end
  if not t.walls then
    local object, bytes, why = t.lib.scene_walls(t.handle)
    object, bytes, code = check.result(name, object, bytes, why)
    if not object then return nil, bytes, code end
    t.walls = { object = object, bytes = bytes }
  end
  return t.walls.bytes
end

--- Raises where lights, or a list among them, hold light of which rays see nothing: a light field without lamps. pack.pack
-- refuses grids.
local function check_rays(name, lights, depth)
  local kind = core.type(lights)
  if kind and kind ~= "ylm.lights" and kind ~= "ylm.grid" and core.has_field(lights) then
    return check.fail("%s: lights shine by rays, which see nothing of a %s: give lamps and skies", name, kind)
  elseif depth > 32 then return check.fail("%s: lists of lights nest more than 32 deep; does a list hold itself?", name)
  elseif type(lights) == "table" and not form.kind(lights) then
    for i = 1, #lights do check_rays(name, lights[i], depth + 1) end
  end
end

--- Raises where a traced scene has lights that rays see nothing of. `remedy`: what else to do.
function tracing.check_bodies(name, t, remedy)
  if core.type(t.lights) ~= "ylm.lights" or not core.lights_has_virtual(t.lights) then return end
  return check.fail("%s: virtual lights have no body, so rays see nothing of them: %s", name,
    remedy or 'bake them, or take visibility = "transfer", or give them as bounced')
end

--- A traced scene with other lights, which are those of the scene no more: as tracing.trace returns it; nil, message, code.
function tracing.relight(name, t, lights)
  local start = core.seconds()
  check_rays(name, lights, 0)
  light.heed_nothing(name, lights)
  local packed, message, code = light.pack(1, name, lights)
  if not packed then return nil, message, code end
  local handle
  handle, message, code = check.result(name, t.lib.scene_relight(t.handle, light.set(packed), true))
  if not handle then return nil, message, code end
  return { shapes = t.shapes, lamps = false, handle = handle, lights = packed, lo = t.lo, hi = t.hi, lib = t.lib,
    glossy = t.glossy, seconds = core.seconds() - start }
end

return tracing
