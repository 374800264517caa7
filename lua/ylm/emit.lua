--- Virtual lights of a scene: where particles from its lamps land, surfaces send on what they reflect.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local progress = require "ylm.progress"
local tracing = require "ylm.trace"
local virtual = require "ylm.light.virtual"
local show = require "ylm.show"
local warning = require "ylm.warning"

local emit = {}

local EACH = 50 -- particles of a merged light
local COUNT = 2000
local MOST_BOUNCES, MOST, DEGREE = core.limits.emit_bounces, core.limits.emit_particles, core.limits.emit_degree
local LOUD = 0.26 -- the part of slices that lights may miss without a word
local SCALE = { density = 1.5, angle = 1, footprint = 1.5, neighbours = 1 } -- of radii, by their rule

--- { scene, bounces, radius (the median), report } of lights that scene:virtual_lights made; nil of others.
function emit.made(lights) return core.owned(lights, "emitted") end

function form.types.reflected(x)
  if x == "all" then return MOST_BOUNCES end
  if check.is_integer(x) and x >= 0 and x <= MOST_BOUNCES then return x end
  return nil, ("a number of reflections, 0 to %d, or 'all': %d"):format(MOST_BOUNCES, MOST_BOUNCES)
end

function form.types.light_radius(x)
  if SCALE[x] or check.is_number(x) and x > 0 then return x end
  return nil, "'density', 'angle', 'footprint', 'neighbours', or a length above 0"
end

function form.types.emission_degree(x)
  if x == "auto" or check.is_integer(x) and x >= 0 and x <= DEGREE then return x end
  return nil, ("'auto', or an integer from 0 to %d"):format(DEGREE)
end

function form.types.merged(x)
  if type(x) == "boolean" or check.is_integer(x) and x >= 1 and x <= MOST then return x end
  return nil, "true, false, or a number of lights"
end

--- Options that scene:virtual_lights has in common with pictures that make such lights.
emit.fields = {
  { "count", "integer", min = 1, max = MOST, optional = true,
    about = "lights, at most: of more landings so many are chosen, by power, each for the same share of it; default "
      .. COUNT .. ", or one for each landing where particles are named" },
  { "particles", "integer", min = 1, max = MOST, optional = true, about = "that are traced, at least count; default: count, "
      .. "of merged lights " .. EACH .. " times as many" },
  { "merge", "merged", default = false,
    about = "true: particles that land in one cell of a grid, on surfaces that face the same way, become one light, count of "
      .. "them at most (never below 6); power is kept, colour by colour. A number is count" },
  { "cell", "number", above = 0, optional = true, unit = "scene units",
    about = "the edge of these cells, whatever number of lights that gives: keep report.merged.cell while lamps move; default: "
      .. "the least power of 2^(1/4) that gives count lights" },
  { "radius", "light_radius", optional = true, unit = "scene units",
    about = "of a light: 'footprint', by the area that a texel covers (default of a grid); 'density' (else), by the distance to "
      .. "the tenth light of the same surface; 'angle', the paper's r2, by the way of its particle; 'neighbours', its r1, by the "
      .. "eight texels around, of a grid; or a length" },
  { "scale", "number", above = 0, optional = true,
    about = "multiplies radii; default 1.5, of 'angle' and 'neighbours' 1" },
  { "degree", "emission_degree", default = "auto",
    about = "of what glossy surfaces send, in harmonics: 0, as matte ones of their mean albedo, to 8; 'auto': the least "
      .. "of 2, 4, 8 whose slices at 45 degrees miss at most 14 %, 26 %, all (a white metal of alpha 0.5 has 2, of 0.25 4); "
      .. "matte surfaces alone have 0" },
  { "conserve", "boolean", default = true,
    about = "scales such emission, colour by colour, to the power that is reflected" },
  { "profile", "choice", of = { "gauss", "cap", "point" }, default = "gauss", about = "as in virtual_lights" },
}

local options = {}
for _, field in ipairs(emit.fields) do options[#options + 1] = field end
for _, field in ipairs {
  { "distribution", "choice", of = { "particles", "grid" }, default = "particles",
    about = "'grid': instead, the paper's picture from each spot, of which count texels in all have a light where they "
      .. "land; bounces = 1" },
  { "bounces", "reflected", default = 1, about = "reflections of a particle, each of which leaves a light; 'all': 64" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1,
    about = "of all random numbers: a particle keeps its own, whatever moves" },
  form.threads, form.progress,
} do options[#options + 1] = field end

--- The sentence about a scene that leaves no light, or nil.
local function note_of(s, o, r)
  if o.bounces == 0 then return "bounces = 0: no indirect light" end
  if r.lights > 0 then return nil end
  if #s.geometry == 0 then return "the scene has no surface: nothing reflects" end
  if #s.lights == 0 or r.rays == 0 then return "the scene has no lamps that shine: no particle set out" end
  if #r.bounces == 0 then
    return ("no particle landed on a surface (%d left the scene): are lamps inside of it?"):format(r.particles)
  end
  return "all surfaces that particles landed on are black"
end

--- Sentences for report.warnings about light that is left out.
local function shortcomings(s, o, r)
  local list, n = {}, r.glossy
  if n > 0 and o.degree == 0 then
    list[1] = warning.say(s, "gloss virtual", "scene %q: %d of its virtual lights' landings are on glossy surfaces, which "
      .. "send light on as matte ones of their mean albedo (degree = 0): no highlights, no caustics", s.name or "?", n)
  elseif r.slices.missed > LOUD then
    list[1] = warning.say(s, "slices virtual", "scene %q: virtual lights of degree %d miss %.0f %% of what glossy surfaces "
      .. "send: %s (scene:pathtrace has it all)", s.name or "?", r.degree, 100 * r.slices.missed, r.degree < DEGREE
      and "set a higher degree" or "their lobes are sharper than degree 8 has them, and come out wider")
  end
  local going, reflected = r.power.going, r.power.reflected
  local left = going[1] + going[2] + going[3]
  if o.bounces == MOST_BOUNCES and math.abs(left) > 1e-3 * math.abs(reflected[1] + reflected[2] + reflected[3]) then
    list[#list + 1] = warning.say(s, "bounces virtual", "scene %q: %g W are still under way after %d reflections, and are left "
      .. "out: surfaces reflect nearly all (albedo)", s.name or "?", left, MOST_BOUNCES)
  end
  return list
end

--- The lights of options that are settled: at, normal, radius, intensity, shift or nil, report; or nil, message, code.
local function trace(name, s, o, traced)
  local t, message, code = traced, nil, nil
  if not t then t, message, code = tracing.trace(name, s) end
  if not t then return nil, message, code end
  local points = math.max(1, t.lib.scene_points(t.handle))
  local grid = o.distribution == "grid" and math.max(1, math.floor(math.sqrt(o.count / points)))
    or nil
  o.radius = o.radius or (grid and "footprint" or "density")
  local fixed = type(o.radius) == "number" and o.radius or nil
  return check.result(name, t.lib.emit_lights(t.handle, { particles = o.particles, lights = o.count,
    bounces = math.max(1, o.bounces), radius = fixed and "fixed" or o.radius, fixed = fixed,
    scale = o.scale or SCALE[o.radius] or 1, seed = o.seed, threads = o.threads, grid = grid,
    degree = o.degree == "auto" and -1 or o.degree, conserve = o.conserve, merge = o.merge and true, cell = o.cell,
    progress = progress.resolve(o.progress) }))
end

--- Virtual lights and report by options that a form has checked, of function `name`; `traced`: lamps other than the scene's.
function emit.lights(name, s, o, traced)
  if type(o.merge) == "number" then
    if o.count then
      return check.bad(1, name, "merge = %d and count = %d say the same: merge = true merges into count", o.merge, o.count)
    end
    o.count = o.merge
  end
  if o.cell and not o.merge then return check.bad(1, name, "cell is of lights that are merged: merge = true") end
  o.count = o.count or (not o.merge and o.particles or COUNT)
  o.particles = o.particles or (o.merge and math.min(MOST, EACH * o.count) or o.count)
  if o.particles < o.count then
    return check.bad(1, name, "particles (%d) must be at least as many as count, the lights that are wanted (%d)", o.particles,
      o.count)
  end
  if o.distribution ~= "grid" and (o.radius == "footprint" or o.radius == "neighbours") then
    return check.bad(1, name, "radius = '%s' is of distribution = 'grid', whose texels have %s", o.radius,
      o.radius == "footprint" and "one" or "them")
  end
  if o.distribution == "grid" and o.bounces ~= 1 then
    return check.bad(1, name, "distribution = 'grid' has one bounce, bounces is %d", o.bounces)
  end
  if o.distribution == "grid" and o.merge then
    return check.bad(1, name, "merge is of particles: the lights of distribution = 'grid' are its texels")
  end
  local at, normal, radius, intensity, shift, report = trace(name, s, o, traced)
  if not at then return nil, normal, radius end
  if o.bounces == 0 then
    at, normal, radius, intensity, shift = core.array_zeros({ 0, 3 }, "double"), nil, 1, 0, nil
    report.lights, report.bounces, report.degree = 0, {}, 0
  end
  local lobes = report.degree > 0 and intensity or nil
  local lights = virtual.virtual_lights { at = at, normal = normal, radius = radius, emission = lobes,
    intensity = not lobes and intensity or nil, shift = shift, profile = o.profile }
  report.note = note_of(s, o, report)
  report.warnings = shortcomings(s, o, report)
  report.power.lights = lights.power
  report = show.report(report)
  core.own(lights).emitted = { scene = s, bounces = o.bounces, radius = report.radius.median, report = report }
  return lights, report
end

describe "scene:virtual_lights" {
  about = "Traces particles from the scene's lamps and skies; where they land, surfaces send on what they reflect, as virtual "
    .. "lights. These are a light field, without shadows: ylm.light_field, ylm.bake, and bounced of pictures take them.",
  arguments = { { "options?", "table", "" } },
  options = options,
  returns = {
    { "lights", "virtual_lights", "" },
    { "report", "table", "lights, particles, rays; bounces (landings of each reflection); power {r, g, b} in W: emitted = "
      .. "landed + lost (to the sky, before a first landing), reflected (at all landings), lights (what was chosen of it), going "
      .. "(under way behind the last reflection); radius = { min, median, max, cut }, cut: of those above four medians, which "
      .. "became that; turned: landings with the normal of their triangle, that of the vertices looking away; absorbed; glossy: "
      .. "those on glossy surfaces; degree, of emission; slices, of what these send: { missed: error over norm, root mean "
      .. "square by power, most, below: power below zero over all, unscaled: lights that `conserve` left as they are, their "
      .. "slices keeping less than a twentieth }; merged = { landings, cell } of merged lights; seconds = { trace, radius, "
      .. "emission, merge }; warnings; note, where it is dark" },
  },
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = [[
local scene = ylm.scene "a room" {
  geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 },
}
local lights, report = scene:virtual_lights { count = 100 }
assert(lights.count == 100 and report.power.lost[1] == 0)
local flux = 4 * math.pi ^ 2 * 0.1 ^ 2 * 10
assert(math.abs(lights.power[1] / (0.5 * flux) - 1) < 1e-5)]],
  source = "Keller 1997; Mezieres & Paulin 2022, Sec. 5; Roberts 2018",
}
function emit.of_scene(s, given)
  tracing.check_scene("virtual_lights", s)
  local o = form.options(1, "virtual_lights", options, given)
  o.progress = progress.long(o.progress)
  return emit.lights("virtual_lights", s, o)
end

-- Lights with their shadows ---------------------------------------------------------------

require "ylm.describe".object "visible" {
  about = "Virtual lights that the surfaces of a scene hide, as a light field (virtual_lights:visible).",
  fields = { { "lights", "virtual_lights", "" }, { "scene", "scene", "whose surfaces hide them" } },
}

local TYPE = "ylm.visible"
local methods = tracing.library() and core.metatable(TYPE) or {}

--- { lights, scene, traced, closed } of a field.
local function visible(field) return core.owned(field, "visible") end

function methods.__index(field, key)
  local m = visible(field)
  if m and (key == "lights" or key == "scene") then return m[key] end
  return rawget(methods, key)
end

function methods.__newindex(_, key)
  return check.fail("visible: cannot set %s: lights and scene stay as they are", check.describe(key))
end

function methods.__tostring(field)
  local m = visible(field)
  if not m or m.closed then return TYPE .. " (closed)" end
  return ("%s: %d virtual lights with the shadows of scene %q"):format(TYPE, m.lights.count, m.scene.name or "?")
end

--- The field of virtual_lights:visible, of lights and a scene that are known to be that; nil, message, code.
function virtual.with_shadows(lights, s)
  if lights.profile == "near" then
    return check.bad(1, "visible", "near parts are summed where they are needed: take the lights before they are split")
  end
  local t, message, code = tracing.trace("visible", s)
  if not t then return nil, message, code end
  local field
  field, message, code = check.result("visible", t.lib.emit_visible(t.handle, lights.lights))
  if not field then return nil, message, code end
  core.own(field).visible = { lights = lights, scene = s, traced = t }
  return field
end

describe "visible:close" {
  about = "Frees the memory of a field of lights with their shadows now rather than at the next collection.",
  arguments = {},
  returns = {},
  errors = "raises on what is no such field",
  example = [[
local scene = ylm.scene "a floor" { geometry = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } } }
ylm.virtual_lights({ at = { { 0, 0, 1 } }, radius = 0.1, intensity = 1 }):visible(scene):close()]],
}
function methods.close(field)
  if core.type(field) ~= TYPE then
    return check.fail("close: a field of visible lights expected before the colon, got %s", check.describe(field))
  end
  local m = visible(field)
  if not m.closed then check.result("close", m.traced.lib.emit_visible_close(field)) end
  m.closed, core.own(field).visible = true, m
end
memory.publish(methods)

--- Writes virtual lights, their intensities along the normal, to a PLY file: true, or nil, message, code.
function emit.write(lights, path)
  local lib, message, code = tracing.library()
  if not lib then return nil, message, code end
  return check.result("emit", lib.emit_write(path, core.lights_virtual_arrays(lights.lights)))
end

return emit
