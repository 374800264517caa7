--- Lights of any kinds as one object, "ylm.lights", and what it is asked.

local check = require "ylm.check"
local core = require "ylm.c.core"
local devices = require "ylm.device"
local form = require "ylm.form"
local warning = require "ylm.warning"

local pack = {}

--- Numbers as a double array.
local function doubles(list)
  local a = assert(core.array_zeros({ #list }, "double"))
  core.array_fill(a, list)
  return a
end

--- The kind of the records of a light that a form has built; nil: it is a set by itself, values.lights.
local function kind_of(light, value)
  if type(light.kind) == "function" then return light.kind(value) end
  return light.kind
end

--- The lights object of one value of the form `name`, so that what is wrong with it is said where it is made; fail(message)
-- raises. Or nil, message, code.
function pack.one(name, values, fail)
  local light, record = form.defined[name].light, {}
  light.record(values, record)
  local lights, message, code = core.lights_create { { kind_of(light, values), doubles(record) } }
  if lights then return lights end
  if core.status(code) == "caller" then return fail((message:gsub("^%a+ 1", "it"))) end
  return check.result(name, nil, message, code)
end

--- The value of the form `name` with the lights of pack.one; nil, message, code.
function pack.finish(name, values, fail)
  local lights, message, code = pack.one(name, values, fail)
  if not lights then return nil, message, code end
  values.lights = lights
  return setmetatable(values, form.defined[name].metatable)
end

--- The `build` of a form whose values need no other check.
function pack.build(name)
  return function(values, fail) return pack.finish(name, values, fail) end
end

--- Appends colours and points to a record.
function pack.append(record, ...)
  for _, three in ipairs { ... } do
    for i = 1, 3 do record[#record + 1] = three[i] end
  end
end

--- The `light` of the form of a value (lua/ylm/light/kinds.lua); nil: it is no light of a form.
function pack.form_of(value)
  local kind = type(value) == "table" and form.kind(value)
  return kind and form.defined[kind] and form.defined[kind].light or nil
end

--- How many lights a value counts as.
function pack.rows(value)
  local light = pack.form_of(value)
  return light and light.rows and light.rows(value) or 1
end

--- A light that is alike but for some fields, and for the field `without`, which it does not keep: what lights of forms
-- without `moved` become; nil, message, code. `name`: the form, of a row of fields.
function pack.moved(value, changes, without, name)
  local definition, given = form.defined[name or form.kind(value)], {}
  for _, field in ipairs(definition.fields) do given[field[1]] = value[field[1]] end
  if without then given[without] = nil end
  for key, x in pairs(changes) do given[key] = x end
  return definition.construct(given)
end

-- Units ---------------------------------------------------------------------------------------

--- The field of lights whose numbers may be photometric.
pack.photometric = { "photometric", "boolean", optional = true,
  about = "true: its numbers are cd/m^2, cd or lx, as those of photometric lamps, which stand in no scene with watts" }

--- The unit of a light of a form: "lm" or "W"; nil: it goes with either.
local function unit_of(value, light)
  local photometric = light.photometric
  if photometric == nil or value.of_file then return nil end
  if type(photometric) == "function" then return photometric(value) and "lm" or "W" end
  return value.photometric and "lm" or "W"
end

--- Notes the unit of light `number` of a list in `first`, a table by unit; a sentence where two meet.
local function mixed(first, number, value, light)
  local unit = unit_of(value, light)
  if not unit then return nil end
  first[unit] = first[unit] or number
  if not (first.lm and first.W) then return nil end
  return ("light %d is photometric (lm, cd), light %d is in watts: a scene has one of the two. Give the other photometric = true "
    .. "where its numbers are cd/m^2, cd or lx, or lamps efficacy = lm/W"):format(first.lm, first.W)
end

--- The sentence about a flat list in which both units meet; nil where one is.
function pack.mixed(list)
  local first = {}
  for i, value in ipairs(list) do
    local light = pack.form_of(value)
    local message = light and mixed(first, i, value, light)
    if message then return message end
  end
end

--- Ends a run of records, which becomes a source of lights_create.
local function flush(sources, run)
  if #run == 0 then return end
  sources[#sources + 1] = { run.kind, doubles(run) }
  for i = #run, 1, -1 do run[i] = nil end
end

--- The length of a list of lights; raises where it has holes, or entries with names: options that stand in the place of lights.
local function length(n, name, list)
  local largest, count = 0, 0
  for key in pairs(list) do
    if not check.is_integer(key) or key < 1 then
      return check.bad(n, name, "a list of lights has no entry %s; options are a table of their own, behind the lights",
        check.describe(key))
    end
    largest, count = math.max(largest, key), count + 1
  end
  for i = 1, count < largest and largest or 0 do
    if list[i] == nil then
      -- A constructor that could not read a file left nil, message, code here.
      local why = type(list[i + 1]) == "string" and ": " .. list[i + 1] or ""
      return check.bad(n, name, "light %d of the list is nil%s", i, why)
    end
  end
  return largest
end

--- Appends what `value` is made of to the sources: records of one kind that follow one another are one of them.
local function gather(n, name, value, sources, run, depth)
  local kind = form.kind(value)
  local light = type(value) == "table" and kind and form.defined[kind].light
  local records = light and light.record and kind_of(light, value)
  if light then
    run.lights = run.lights + 1
    local message = mixed(run.units, run.lights, value, light)
    if message then return check.bad(n, name, "%s", message) end
  end
  if records then
    if run.kind ~= records then flush(sources, run) end
    run.kind = records
    light.record(value, run)
  elseif light then
    flush(sources, run)
    sources[#sources + 1] = value.lights
  elseif kind == "ylm.lights" then
    if not core.lights_count(value) then return check.bad(n, name, "the lights have been closed") end
    flush(sources, run)
    sources[#sources + 1] = value
  elseif core.has_field(value) and kind ~= "ylm.grid" then
    if kind == "ylm.occluder" then
      return check.bad(n, name, "a visibility is no light: ylm.caster puts it in the way of lights (ylm.shadowed)")
    end
    flush(sources, run)
    sources[#sources + 1] = value
  elseif type(value) == "table" and kind == nil and depth < 32 then
    for i = 1, length(n, name, value) do gather(n, name, value[i], sources, run, depth + 1) end
  elseif type(value) == "table" and kind == nil then
    return check.bad(n, name, "lists of lights nest more than 32 deep; does a list hold itself?")
  else
    return check.bad(n, name, "a light or a list of lights expected, got %s",
      kind and not core.type(value) and ("a " .. kind) or check.describe(value))
  end
end

--- The light fields in an object "ylm.lights" that are no plain lights, as shadowed light; nil: there are none.
function pack.parts(lights) return core.owned(lights, "parts") end

--- Remembers what of the sources of `lights` is a light field of its own.
local function remember(lights, sources)
  local parts = {}
  for _, source in ipairs(sources) do
    local inner = pack.parts(source)
    for _, part in ipairs(inner or {}) do parts[#parts + 1] = part end
    if not inner and type(source) == "userdata" and core.type(source) ~= "ylm.lights" then parts[#parts + 1] = source end
  end
  if #parts > 0 then core.own(lights).parts = parts end
  return lights
end

--- Argument `n` of `name` as one object with a light field, "ylm.lights": a light, a list of them (nested fine), or a packed
-- object. An empty list is darkness. A single object with a light field of its own comes back as it is.
function pack.pack(n, name, lights)
  local sources, run = {}, { lights = 0, units = {} }
  gather(n, name, lights, sources, run, 0)
  flush(sources, run)
  if #sources == 1 and type(sources[1]) == "userdata" then return sources[1] end
  local made, message, code = check.result(name, core.lights_create(sources))
  if not made then return nil, message, code end
  return remember(made, sources)
end

--- The set of lights that an object with a light field is, or an empty one: rays see no other light fields.
function pack.set(packed)
  if core.type(packed) == "ylm.lights" then return packed end
  return assert(core.lights_create {})
end

--- Centres [n][3], radii [n] and radiances [n][3] of the spheres in what pack.pack returned, as new double arrays.
function pack.arrays(packed)
  local at, radius, radiance = check.result("lights", core.lights_surfaces(pack.set(packed), 1))
  return at, radius, radiance
end

--- Of the flat lights in what pack.pack returned: corners of triangles [t][9], disks [d][7]
-- (centre, radius, normal), radiances and horizons [t+d][6], as new double arrays. The last result
-- has the numbers of triangles of images, which stand last, at most `tiles` (8) a side. Nothing
-- where there are none.
function pack.patches(packed, tiles)
  local triangles, disks, radiances, images = select(4, check.result("lights",
    core.lights_surfaces(pack.set(packed), tiles or 8)))
  if #triangles + #disks > 0 then return triangles, disks, radiances, images end
end

--- The option `lamps` of the function `name` as a set of sphere lights: flat ones are surfaces of a scene.
function pack.lamps(name, lamps)
  local packed = pack.pack(1, name, lamps)
  local n, spheres = 0, 0
  if core.type(packed) == "ylm.lights" then n, spheres = core.lights_count(packed) end
  if n ~= spheres then
    return check.bad(1, name, "lamps: sphere lights expected; flat lights are drawn with the scene that they are prepared in")
  end
  return pack.set(packed)
end

--- Does a list hold nothing but lists of nothing? They nest no deeper than `room`.
local function is_nothing(list, room)
  if type(list) ~= "table" or form.kind(list) or room == 0 then return false end
  for _, entry in pairs(list) do
    if not is_nothing(entry, room - 1) then return false end
  end
  return true
end

--- Says, once of each function, that the lights a caller gave it are an empty list. Lists of scenes may be empty.
function pack.heed_nothing(name, lights)
  if not is_nothing(lights, 32) then return end
  warning.say(pack, name, "%s: the list of lights is empty, which is darkness: give lights", name)
end

--- Argument `n` of `name` as an open object with a light field: such an object itself, or lights packed.
function pack.field(n, name, value)
  local fault = check.grid_fault(value)
  if fault then return check.bad(n, name, fault) end
  if not devices.of(value):is_open(value) then
    return check.bad(n, name, "the lights have been closed")
  end
  if core.has_field(value) and core.type(value) ~= "ylm.lights" then
    if pcall(core.field_quantity, value) then return value end
    return check.bad(n, name, "the %s has been closed", (core.type(value):gsub("^ylm%.", "")))
  end
  pack.heed_nothing(name, value)
  return pack.pack(n, name, value)
end

--- A result of pack.field, if all of it are lights that a dynamic grid can follow; else nil.
function pack.followed(object)
  if core.type(object) ~= "ylm.lights" then return nil end
  return select(3, core.lights_count(object)) and object or nil
end

--- The words for a light field that is not of lights alone.
function pack.other(object)
  if type(object) == "function" then return "a function" end
  local virtual = core.type(object) == "ylm.lights" and core.lights_has_virtual(object)
  return virtual and "virtual lights" or "another light field"
end

return pack
