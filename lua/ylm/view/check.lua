--- Checks of a view's description: the parts that its form cannot check.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local form = require "ylm.form"
local memory = require "ylm.memory"

--- An optional field: a number from 0 on, or another type.
local function number(name) return { name, "number", min = 0, optional = true } end
local function optional(name, kind) return { name, kind, optional = true } end

--- Fields of layers' own tables.
local layer_fields = {
  volume = { optional("bounds", "any"), number "density", optional("smooth", "boolean"), optional("values", "any") },
  levels = { number "from", optional("occupied", "boolean"), number "opacity", number "width" },
  boxes = { optional("occupied", "boolean"), number "opacity", number "shrink" },
  glyphs = { optional("along", "any"), optional("at", "any"), number "count", number "length" },
  streamlines = { optional("along", "any"), optional("bounds", "any"), number "count", number "width" },
  lobes = { number "count", number "size" },
}

local function check_layers(values, fail)
  for name, fields in pairs(layer_fields) do
    if type(values[name]) == "table" then
      form.check(fields, values[name], function(message) return fail(name .. ": " .. message) end)
    end
  end
end

--- An array field of `width` columns as doubles [n][width], finite.
local function rows(what, value, width, fail)
  local a = value
  if core.type(a) ~= "ylm.array" then
    if type(a) ~= "table" or form.kind(a) then
      return fail(("%s must be an array or table of numbers, got %s"):format(what, check.describe(value)))
    end
    if #a == 0 then return fail(what .. " is empty") end
    if type(a[1]) ~= "table" and core.type(a[1]) ~= "ylm.array" then a = { a } end
    local ok, made = memory.pcall(array.array, a, "double")
    if not ok then return fail(("%s must hold numbers, as many in each row"):format(what)) end
    a = made
  end
  local shape, dtype, _, open = core.array_info(a)
  if not open then return fail(what .. ": the array has been closed") end
  if width and shape[#shape] ~= width then
    return fail(("%s must have rows of %d numbers, got %s"):format(what, width, check.describe(a)))
  end
  if #shape == 1 then a, shape = core.array_reshape(a, { 1, shape[1] }), { 1, shape[1] } end
  if dtype ~= "double" then a = core.array_convert(a, "double") end
  local finite, where = core.array_finite(a)
  if not finite then return fail(("%s: number %d is not finite"):format(what, where)) end
  if shape[1] == 0 then return fail(what .. " is empty") end
  return a
end

--- Bounds {min, max} as six numbers; nil: as many units as there are numbers along each axis.
local function bounds_of(value, size, what, fail)
  if value == nil then return { 0, 0, 0, size[1], size[2], size[3] } end
  local b, wanted = form.types.bounds(value)
  if not b then return fail(("%s: bounds must be %s, got %s"):format(what, wanted, check.describe(value))) end
  return { b[1][1], b[1][2], b[1][3], b[2][1], b[2][2], b[2][3] }
end

--- A lattice of numbers [nz][ny][nx] (or [nz][ny][nx][components]) as { array, size, bounds }.
local function lattice(what, value, bounds, components, fail)
  local a = value
  if core.type(a) ~= "ylm.array" then
    local ok, made = memory.pcall(array.array, a, "float")
    if not ok or type(a) ~= "table" then return fail(("%s must be numbers [nz][ny][nx]%s, got %s"):format(what,
      components > 1 and "[" .. components .. "]" or "", check.describe(value))) end
    a = made
  end
  local shape, _, _, open = core.array_info(a)
  if not open then return fail(what .. ": the array has been closed") end
  local axes = components > 1 and 4 or 3
  if #shape ~= axes or components > 1 and shape[4] ~= components or shape[1] * shape[2] * shape[3] == 0 then
    return fail(("%s must be numbers [nz][ny][nx]%s, got %s"):format(what,
      components > 1 and "[" .. components .. "]" or "", check.describe(a)))
  end
  local size = { shape[3], shape[2], shape[1] }
  return { values = a, size = size, bounds = bounds_of(bounds, size, what:match("^[^:]+"), fail),
    components = components }
end

local axes = { x = true, y = true, z = true }

local function check_slices(values, fail)
  if type(values.slices) ~= "table" then return end
  local list = values.slices
  if list.axis ~= nil or list.at ~= nil then list = { list } end
  if #list == 0 then return fail "slices: a list of { axis = \"y\", at = 0.2 } expected, got an empty table" end
  for i, slice in ipairs(list) do
    if type(slice) ~= "table" or not axes[slice.axis] then
      return fail(("slices: entry %d must be { axis = \"x\", \"y\" or \"z\", at = number }"):format(i))
    end
    if slice.at ~= nil and not check.is_number(slice.at) then
      return fail(("slices: at must be a number, got %s"):format(check.describe(slice.at)))
    end
    local o = slice.opacity
    if o ~= nil and not (check.is_number(o) and o >= 0 and o <= 1) then
      return fail(("slices: opacity must be a number from 0 to 1, got %s"):format(check.describe(o)))
    end
    for key in pairs(slice) do
      if key ~= "axis" and key ~= "at" and key ~= "opacity" then
        return fail(("slices: no field '%s'; fields are axis, at, opacity"):format(tostring(key)))
      end
    end
  end
  values.slices = list
end

local function check_isosurfaces(values, fail)
  local x = values.isosurfaces
  if type(x) == "number" and (not check.is_integer(x) or x < 1 or x > 16) then
    return fail(("isosurfaces must be true, a number of surfaces from 1 to 16, or a list of values, got %s")
      :format(check.describe(x)))
  end
  if type(x) ~= "table" then return end
  if #x == 0 then return fail "isosurfaces: a list of values expected, got an empty table" end
  for i = 1, #x do
    if not check.is_number(x[i]) then
      return fail(("isosurfaces: value %d must be a finite number, got %s"):format(i, check.describe(x[i])))
    end
  end
end

local function one_mesh(entry, fail)
  local kind = form.kind(entry)
  local out = {}
  if kind == "ylm.mesh" then out.mesh = entry
  elseif type(entry) == "table" and form.kind(entry.mesh) == "ylm.mesh" then
    out.mesh = entry.mesh
    if kind then out.material = entry.material end
  elseif type(entry) == "table" and not kind and entry[1] ~= nil then
    out = one_mesh(entry[1], fail)
    for key, value in pairs(entry) do
      if key == "colour" then
        local c = form.types.colour(value, { min = 0, max = 1 })
        if not c then
          return fail(("meshes: colour must be a number or {r, g, b} from 0 to 1, got %s"):format(
            check.describe(value)))
        end
        out.colour = c
      elseif key == "colours" then out.colours = rows("meshes: colours", value, 3, fail)
      elseif key == "opacity" then
        if not check.is_number(value) or value < 0 or value > 1 then
          return fail(("meshes: opacity must be a number from 0 to 1, got %s"):format(check.describe(value)))
        end
        out.opacity = value
      elseif key ~= 1 then
        return fail(("meshes: no field '%s'; fields are colour, colours, opacity"):format(tostring(key)))
      end
    end
  else
    return fail(("meshes: geometry or { geometry, colour = , opacity = } expected, got %s"):format(
      check.describe(entry)))
  end
  return out
end

local function check_meshes(values, fail)
  local x = values.meshes
  if x == nil then return end
  if type(x) ~= "table" and form.kind(x) ~= "ylm.mesh" then return one_mesh(x, fail) end
  local single = form.kind(x) or (type(x) == "table" and (x.colour or x.colours or x.opacity or form.kind(x.mesh)))
  local list = {}
  for _, entry in ipairs(single and { x } or x) do
    local parts = type(entry) == "table" and form.kind(entry) and entry.parts or { entry }
    for _, part in ipairs(parts) do list[#list + 1] = one_mesh(part, fail) end
  end
  if #list == 0 then return fail "meshes: the list is empty" end
  values.meshes = list
end

local function check_lights(values, fail)
  local x = values.lights
  if x == nil or x == false then return end
  if x == true then
    local lights = not values.scene and core.grid_is_open(values.subject)
      and require "ylm.grid".lights_of(values.subject)
    if lights then
      values.lights = lights
      return
    end
    if not values.scene then
      return fail("lights = true shows the lights of a scene, or those that this program baked the grid from: "
        .. "give scene = , or the lights themselves")
    end
    x = #values.scene.lights > 0 and values.scene.lights or false
    values.lights = x
    if not x then return end
  end
  if type(x) ~= "table" and form.kind(x) ~= "ylm.lights" then
    return fail(("lights must be a light, a list of lights, or true, got %s"):format(check.describe(x)))
  end
  local ok, packed = memory.pcall(require("ylm.light").pack, 1, "view", x)
  if not ok then return fail((tostring(packed):gsub("^.-bad argument #1 to 'view' ", "lights: "))) end
  if core.type(packed) == "ylm.lights" and core.lights_has_virtual(packed) then
    return fail "virtual lights have no body to be drawn: show their places as points (lights:arrays().at)"
  end
  values.lights = packed
end

local function check_surfaces(values, fail)
  local kind = values.surfaces ~= nil and core.type(values.surfaces)
  if values.charts and kind ~= "ylm.lightmap" then return fail "charts is of surfaces that are a lightmap" end
  if values.surfaces == nil then return end
  if kind ~= "ylm.surface_grid" and kind ~= "ylm.lightmap" then
    return fail(("surfaces must be a surface grid (scene:surface_grid) or a lightmap (scene:lightmap), got %s"):format(
      check.describe(values.surfaces)))
  end
  if tostring(values.surfaces):find("(closed)", 1, true) then return fail "surfaces: the light has been closed" end
end

--- Numbers and arrows that a view is given without a grid: values.lattice, .arrows, .flow.
local function take_own_numbers(values, fail)
  local options = drawing.options
  local volume, glyphs, stream = options(values.volume), options(values.glyphs), options(values.streamlines)
  if volume.values then
    if values.subject then return fail "give a grid or volume.values, not both" end
    values.lattice = lattice("volume: values", volume.values, volume.bounds, 1, fail)
  elseif volume.bounds then return fail "volume.bounds needs volume.values" end
  if (glyphs.at == nil) ~= (glyphs.along == nil) then return fail "glyphs: at and along belong together" end
  if glyphs.at then
    values.arrows = { at = rows("glyphs: at", glyphs.at, 3, fail),
      along = rows("glyphs: along", glyphs.along, 3, fail) }
    if #values.arrows.at ~= #values.arrows.along then return fail "glyphs: at and along must have as many rows" end
  end
  if stream.along then values.flow = lattice("streamlines: along", stream.along, stream.bounds, 3, fail) end
end

--- SH vectors as [n][count] doubles, and their lmax.
local function check_sh(values, fail)
  if values.sh == nil then return end
  values.sh = rows("sh", values.sh, nil, fail)
  local shape = values.sh.shape
  local count, n = shape[#shape], 1
  local lmax = math.floor(math.sqrt(count) + 0.5) - 1
  if (lmax + 1) ^ 2 ~= count then
    return fail(("sh: rows of (lmax+1)^2 coefficients expected, got %d"):format(count))
  end
  for i = 1, #shape - 1 do n = n * shape[i] end
  values.sh, values.lmax = core.array_reshape(values.sh, { n, count }), lmax
end

--- Layer -> what it may be made from instead of a grid, and the words for that; in the order of complaints.
local needs = {
  { "levels", nil, "a grid: ylm.view { grid, ... }" },
  { "boxes", nil, "a grid: ylm.view { grid, ... }" },
  { "lobes", nil, "a grid: ylm.view { grid, ... }" },
  { "slices", "lattice", "a grid, or volume = { values = }" },
  { "isosurfaces", "lattice", "a grid, or volume = { values = }" },
  { "volume", "lattice", "a grid, or { values = }" },
  { "glyphs", "arrows", "a grid, or { at = , along = }" },
  { "streamlines", "flow", "a grid, or { along = }" },
}

--- Raises where a layer lacks what it shows, or there is nothing to show.
local function check_needs(values, fail)
  for _, need in ipairs(needs) do
    local layer, instead, words = need[1], need[2], need[3]
    if values[layer] and not values.subject and not (instead and values[instead]) then
      return fail(layer .. " needs " .. words)
    end
  end
  if values.quantity and not values.subject then return fail "quantity is of a grid: ylm.view { grid, ... }" end
  if not (values.subject or values.lattice or values.sh or values.scene or values.meshes or values.arrows or values.flow
      or values.points or values.lights or values.surfaces) then
    return fail "nothing to show: give a grid, a scene, sh, meshes, or another layer"
  end
end

--- Chooses what a grid shows where nothing is chosen: its levels; of a quantity, or of what is said about colours, a cloud.
local function choose_layers(values)
  if not values.subject then return end
  local plain = not values.quantity
  for _, name in ipairs { "range", "log", "map", "label", "unit" } do plain = plain and values[name] == nil end
  values.quantity = values.quantity or "error"
  if not (values.volume or values.slices or values.levels or values.boxes or values.isosurfaces or values.glyphs
      or values.streamlines or values.lobes) then
    values.volume, values.levels = not plain or nil, true
    if plain then values.quantity = "level" end
  end
end

--- From where a view looks where nothing is chosen.
local function choose_camera(values)
  local alone = values.sh and not (values.subject or values.scene or values.meshes or values.lattice)
  values.directions = { values.direction or (alone and { 0.12, -1, 0.22 } or { 0.55, 0.42, 0.8 }) }
  if not (values.direction or values.up or alone) then -- from higher above, where that fills the window's height
    for _, y in ipairs { 0.56, 0.73, 0.94 } do values.directions[#values.directions + 1] = { 0.55, y, 0.8 } end
  end
  values.up = values.up or (alone and { 0, 0, 1 } or { 0, 1, 0 })
  values.fov = alone and 10 or 28
end

--- Checks everything of a view that its form cannot.
local function check_view(values, fail)
  check_layers(values, fail)
  check_slices(values, fail)
  check_isosurfaces(values, fail)
  check_meshes(values, fail)
  check_lights(values, fail)
  check_surfaces(values, fail)
  take_own_numbers(values, fail)
  check_sh(values, fail)
  if values.points ~= nil then values.points = rows("points", values.points, 3, fail) end
  local fault = values.subject and check.grid_fault(values.subject)
  if fault then return fail(fault) end
  if math.max(values.size[1], values.size[2]) * values.supersample > 16384 then
    return fail "size times supersample must be at most 16384 pixels"
  end
  check_needs(values, fail)
  choose_layers(values)
  values.log_given = values.log
  if values.log and values.range and values.range[1] <= 0 then return fail "range must be above 0 where log is true" end
  choose_camera(values)
end

return check_view
