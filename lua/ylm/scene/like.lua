--- Scenes that are like others: what they keep, and changes to the other's list of lights.
--
-- Lights have numbers: places in that list, where each sphere of `sphere_lights` counts as one light.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local gltf = require "ylm.gltf"
local sandbox = require "ylm.sandbox"

local like = {}

-- The other scene ------------------------------------------------------------------------

function form.types.like(x)
  local kind = form.kind(x)
  if kind == "scene" or kind == "gltf" then return x end
  return form.types.path(x) or nil, "the name of a scene file or of a glTF file, a scene or a gltf"
end

--- The scene, or the glTF model, that the field `like` names. `where`: the line that names it, "file:line: ", for a scene file's
-- messages. Or nil, message, code.
function like.open(value, where, load)
  if type(value) ~= "string" then return value end
  if gltf.is_name(value) then return gltf.gltf { file = value } end
  if form.like then return form.like(value, where) end
  return load(value)
end

--- Loads a scene file for a script; nil, message, code.
function like.load(path, scene)
  return sandbox.run(path, form.options(2, "scene", sandbox.limits), scene)
end

--- A scene, or a glTF model, as a table with a scene's fields.
function like.scene_of(other)
  if form.kind(other) == "scene" then return other end
  return { name = other.file:match "[^/]*$", camera = other.camera, cameras = other.cameras, geometry = other.geometry,
    lights = other.lights, notes = other.notes,
    sky_is_seen = not other.background, background = other.background }
end

-- Lights by number -------------------------------------------------------------------------

--- Kinds of lights whose fields are gone once they are made.
local whole = { textured_light = true, virtual_lights = true }

--- The number of lights that a part of a scene counts as.
local function count_of(light)
  return form.kind(light) == "sphere_lights" and light.count or 1
end

--- The light of form `name` with the fields of `old` and, over them, those of `changes`; or nil, message, code.
local function changed(name, old, changes, place, fail)
  local fields, given = form.defined[name].fields, {}
  for _, field in ipairs(fields) do given[field[1]] = old[field[1]] end
  if given.coefficients then given.lmax = nil end -- they have their own
  for key, value in pairs(changes) do given[key] = value end
  local ok, light, message, code = pcall(form.defined[name].construct, given)
  if ok then return light, message, code end
  if type(light) ~= "string" or not light:find(name .. ": ", 1, true) then error(light, 0) end
  return fail(("%s: %s"):format(place, light:match("^.-(" .. name .. ": .*)$")))
end

--- One light, changed; or nil, message, code.
local function change(light, changes, place, fail)
  local kind = form.kind(light)
  if type(light) ~= "table" or whole[kind] then
    return fail(("%s: the fields of %s are not kept; remove it, and add another"):format(place,
      kind == "ylm.lights" and "packed lights" or "a " .. kind))
  end
  return changed(kind, light, changes, place, fail)
end

--- Arrays of spheres with the changes, by row, and without the rows that are removed; or nil, message, code. Nothing (false)
-- where no row is left.
local function change_rows(light, first, moved, removed, fail)
  local at, radius, radiance = check.result("scene", core.lights_surfaces(light.lights, 1))
  if not at then return nil, radius, radiance end
  at, radius, radiance = core.array_totable(at), core.array_totable(radius), core.array_totable(radiance)
  local rows = { at = {}, radius = {}, radiance = {} }
  for i = 1, light.count do
    local number = first + i - 1
    local row = { at = at[i], radius = radius[i], radiance = radiance[i] }
    if moved[number] then
      local message, code
      row, message, code = changed("sphere_light", row, moved[number], ("moved[%d]"):format(number), fail)
      if not row then return nil, message, code end
    end
    if not removed[number] then
      local n = #rows.at + 1
      rows.at[n], rows.radius[n], rows.radiance[n] = row.at, row.radius, row.radiance
    end
  end
  if #rows.at == 0 then return false end
  return form.defined.sphere_lights.construct(rows)
end

--- The numbers of `removed` as a set, once they and those of `moved` are numbers of lights.
local function numbers_of(values, n, name, fail)
  local function number(place, i)
    if check.is_integer(i) and i >= 1 and i <= n then return end
    return fail(("%s: a number of one of the %s of %s expected, got %s"):format(place, n == 1 and "1 light" or n .. " lights",
      name, check.describe(i)))
  end
  for i, changes in pairs(values.moved or {}) do
    number("moved", i)
    if type(changes) ~= "table" or form.kind(changes) then
      return fail(("moved[%d]: a table of the light's fields expected, got %s"):format(i, check.describe(changes)))
    end
  end
  local removed, given = {}, values.removed or {}
  local length = 0
  for _ in pairs(given) do length = length + 1 end
  if length ~= #given then return fail "removed: a list of numbers of lights expected" end
  for _, i in ipairs(given) do
    number("removed", i)
    removed[i] = true
  end
  return removed
end

--- Does a number of the set lie in first .. last?
local function any(set, first, last)
  if last == first then return set[first] ~= nil end
  for number in pairs(set) do if number >= first and number <= last then return true end end
  return false
end

--- The list `lights` of the scene `name` after `values.moved` and `values.removed`; successors of lights that
-- geometry brought are such lights. Or nil, message, code.
function like.lights(lights, values, name, fail)
  local moved, total, out = values.moved or {}, 0, {}
  for _, light in ipairs(lights) do total = total + count_of(light) end
  local removed = numbers_of(values, total, name, fail)
  local first = 1
  for _, light in ipairs(lights) do
    local last, new, message, code = first + count_of(light) - 1, light, nil, nil
    if any(moved, first, last) or any(removed, first, last) then
      if form.kind(light) == "sphere_lights" then
        new, message, code = change_rows(light, first, moved, removed, fail)
      elseif removed[first] then new = false
      else new, message, code = change(light, moved[first], ("moved[%d]"):format(first), fail) end
    end
    if new == nil then return nil, message, code end
    if new then out[#out + 1] = new end
    if new then core.between(values, new).from_file = core.between(values, light).from_file end
    first = last + 1
  end
  return out
end

return like
