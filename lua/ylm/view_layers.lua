--- The layers of a view: what each needs, its numbers, and how it gets into the scene.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local picture = require "ylm.picture"
local view_grid = require "ylm.view_grid"

local layers = {}

local function options(value) return type(value) == "table" and value or {} end

--- Fields of a layer's own table; fail(message) raises.
local known = {
  volume = { density = "number", smooth = "boolean", values = "any", bounds = "any" },
  levels = { opacity = "number", width = "number", occupied = "boolean", from = "number" },
  boxes = { shrink = "number", opacity = "number", occupied = "boolean" },
  glyphs = { count = "number", length = "number", at = "any", along = "any" },
  streamlines = { count = "number", width = "number", along = "any", bounds = "any" },
  lobes = { count = "number", size = "number" },
}

local function check_layer(name, value, fail)
  if type(value) ~= "table" then return end
  local names = {}
  for key in pairs(known[name]) do names[#names + 1] = key end
  table.sort(names)
  for key, x in pairs(value) do
    local wanted = known[name][key]
    if not wanted then
      local guess = type(key) == "string" and check.guess(key, names)
      return fail(("%s: no field '%s'%s"):format(name, tostring(key), guess and (" (did you mean '%s'?)"):format(guess)
        or ("; fields are " .. table.concat(names, ", "))))
    end
    local good = wanted == "any" or type(x) == wanted
    if wanted == "number" then good = check.is_number(x) and x >= 0 end
    if not good then
      return fail(("%s: %s must be a %s, got %s"):format(name, key, wanted == "number" and "number >= 0" or wanted,
        check.describe(x)))
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
    local ok, made = pcall(array.array, a, "double")
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
    local ok, made = pcall(array.array, a, "float")
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

local axis_number = { x = 1, y = 2, z = 3 }

local function check_slices(values, fail)
  if type(values.slices) ~= "table" then return end
  local list = values.slices
  if list.axis ~= nil or list.at ~= nil then list = { list } end
  if #list == 0 then return fail "slices: a list of { axis = \"y\", at = 0.2 } expected, got an empty table" end
  for i, slice in ipairs(list) do
    if type(slice) ~= "table" or not axis_number[slice.axis] then
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
  for i, entry in ipairs(single and { x } or x) do list[i] = one_mesh(entry, fail) end
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
    values.lights = #values.scene.lights > 0 and values.scene.lights or false
    return
  end
  if type(x) ~= "table" and form.kind(x) ~= "ylm.lights" then
    return fail(("lights must be a light, a list of lights, or true, got %s"):format(check.describe(x)))
  end
  local ok, packed = pcall(require("ylm.light").pack, 1, "view", x)
  if not ok then return fail((tostring(packed):gsub("^.-bad argument #1 to 'view' ", "lights: "))) end
  values.lights = packed
end

local needs_grid = { "levels", "boxes", "lobes" }
local needs_numbers = { "slices", "isosurfaces" }

--- Checks everything of a view that its form cannot.
function layers.check(values, fail)
  for name in pairs(known) do check_layer(name, values[name], fail) end
  check_slices(values, fail)
  check_isosurfaces(values, fail)
  check_meshes(values, fail)
  check_lights(values, fail)
  local volume, glyphs, stream = options(values.volume), options(values.glyphs), options(values.streamlines)
  if volume.values then
    if values.subject then return fail "give a grid or volume.values, not both" end
    values.lattice = lattice("volume: values", volume.values, volume.bounds, 1, fail)
  elseif volume.bounds then return fail "volume: bounds are those of values, which are missing" end
  if (glyphs.at == nil) ~= (glyphs.along == nil) then return fail "glyphs: at and along belong together" end
  if glyphs.at then
    values.arrows = { at = rows("glyphs: at", glyphs.at, 3, fail),
      along = rows("glyphs: along", glyphs.along, 3, fail) }
    if #values.arrows.at ~= #values.arrows.along then return fail "glyphs: at and along must have as many rows" end
  end
  if stream.along then values.flow = lattice("streamlines: along", stream.along, stream.bounds, 3, fail) end
  if values.sh ~= nil then
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
  if values.points ~= nil then values.points = rows("points", values.points, 3, fail) end
  for _, name in ipairs(needs_grid) do
    if values[name] and not values.subject then return fail(name .. " needs a grid: ylm.view { grid, ... }") end
  end
  for _, name in ipairs(needs_numbers) do
    if values[name] and not values.subject and not values.lattice then
      return fail(name .. " needs a grid, or volume = { values = }")
    end
  end
  if values.subject and not core.grid_is_open(values.subject) then return fail "the grid has been closed" end
  if math.max(values.size[1], values.size[2]) * values.supersample > 16384 then
    return fail "size times supersample must be at most 16384 pixels"
  end
  if values.volume and not (values.subject or values.lattice) then
    return fail "volume needs a grid, or { values = }"
  end
  if values.glyphs and not (values.subject or values.arrows) then
    return fail "glyphs needs a grid, or { at = , along = }"
  end
  if values.streamlines and not values.subject and not values.flow then
    return fail "streamlines needs a grid, or { along = }"
  end
  if values.quantity and not values.subject then return fail "quantity is of a grid: ylm.view { grid, ... }" end
  if not values.quantity and values.subject then values.quantity = "error" end
  if values.subject and not (values.volume or values.slices or values.levels or values.boxes or values.isosurfaces
      or values.glyphs or values.streamlines or values.lobes) then
    values.volume, values.levels = true, true
  end
  if not (values.subject or values.lattice or values.sh or values.scene or values.meshes or values.arrows or values.flow
      or values.points or values.lights) then
    return fail "nothing to show: give a grid, a scene, sh, meshes, or another layer"
  end
  values.log_given = values.log
  if values.log and values.range and values.range[1] <= 0 then return fail "range must be above 0 where log is true" end
  local alone = values.sh and not (values.subject or values.scene or values.meshes or values.lattice)
  values.up = values.up or (alone and { 0, 0, 1 } or { 0, 1, 0 })
  values.fov = alone and 10 or 28
  values.direction = values.direction or (alone and { 0.12, -1, 0.22 } or { 0.55, 0.42, 0.8 })
end

-- Numbers ------------------------------------------------------------------------

--- Fills in what the user left open of a scale, from the data's least, largest, least positive.
local function make_scale(v, quantity, defaults, least, largest, positive, takes_fields)
  local own = takes_fields and v or {}
  local scale = { quantity = quantity, map = own.map or defaults.map, log = defaults.log, whole = defaults.whole }
  if own.log_given ~= nil then scale.log = own.log_given end
  if scale.log and not (own.range and own.range[1] > 0) and not positive then scale.log = false end
  local label, unit = own.label or defaults.label or "", own.unit or (not own.label and defaults.unit) or nil
  scale.label, scale.unit = label, unit
  if own.range then scale.range = { own.range[1], own.range[2] }
  else
    least, largest = least or 0, largest or 1
    if scale.log then least = math.max(positive, largest * 1e-4) end
    if largest <= least then
      largest = scale.log and least * 10 or least + math.max(1, math.abs(least)) * 1e-6
    end
    scale.range = { least, largest }
  end
  if scale.log and scale.range[1] <= 0 then scale.log = false end
  v.scales[#v.scales + 1] = scale
  return scale
end

local function scale_of(scale) return scale.map, scale.range[1], scale.range[2], scale.log end

--- Cells of a grid that colours show: leaves, or those of `drawn`. With corners: all of them, parents first, so that
-- a leaf without data shows its nearest ancestor's, as sampling does.
local function cells_args(source, drawn, with_corners)
  local c = source.cells
  if with_corners then return c.origin, c.size, c.level, drawn, c.corner end
  return c.origin, c.size, c.level, drawn or c.leaf
end

local function both(a, b)
  local n = a.shape[1]
  local product = core.figure_mix(a, n, { 0 }, { 1 }, 1)
  local list, other = core.array_totable(product), core.array_totable(b)
  for i = 1, n do list[i] = (list[i][1] ~= 0 and other[i] ~= 0) and 1 or 0 end
  local mask = core.array_zeros({ n }, "double")
  core.array_fill(mask, list)
  return mask
end

--- Computes the view's numbers and scales once. Returns true, or nil, message, code.
function layers.prepare(v)
  if v.scales then return true end
  v.scales = {}
  if v.subject then v.source = view_grid.open(v.subject) end
  local coloured = v.volume or v.slices or v.boxes or v.isosurfaces or (v.levels and v.quantity == "level")
  if v.lattice then
    local l = v.lattice
    local volume, message, code = core.volume(l.bounds, l.size, 1)
    if not volume then return nil, message, code end
    core.volume_set(volume, l.values)
    l.volume = volume
    local least, largest, positive = core.volume_range(volume)
    v.scale = make_scale(v, "values", { map = "viridis", log = false }, least, largest, positive, true)
  elseif v.source and coloured then
    v.values = v.source.values(v.quantity)
    local q = view_grid.quantities[v.quantity]
    local of = q.of == "cells" and core.figure_pick(v.values, v.source.cells.leaf) or v.values
    local least, largest, positive = core.figure_range(of)
    if not least then
      return nil, ("the grid holds no '%s' anywhere"):format(v.quantity), "EFORMAT"
    end
    local label, unit = v.source.words(v.quantity)
    v.scale = make_scale(v, v.quantity, { map = q.map, log = q.log, whole = q.whole, label = label,
      unit = unit }, least, largest,
      positive, true)
  end
  if v.glyphs or v.streamlines then
    local lengths
    if v.arrows then lengths = core.figure_lengths(v.arrows.along)
    elseif v.flow then
      local n = v.flow.size[1] * v.flow.size[2] * v.flow.size[3]
      lengths = core.figure_lengths(core.array_reshape(core.array_convert(v.flow.values, "double"), { n, 3 }))
    else
      v.gradient = v.source.gradient()
      lengths = core.figure_lengths(v.gradient)
    end
    local q = view_grid.quantities.gradient
    local given = v.arrows or v.flow
    local least, largest, positive = core.figure_range(lengths)
    -- A few arrows beside lamps must not decide the colours of all others.
    if not given and positive then
      positive, largest = core.figure_quantiles(lengths, 0.02, 0.99)
      least = positive
    end
    v.vector_scale = make_scale(v, "gradient", { map = q.map, log = q.log and not given, label = not given
      and q.label or "",
      unit = not given and q.unit or nil }, least, largest, positive, not v.scale)
  end
  return true
end

-- Layers --------------------------------------------------------------------------

local function grow(stage, b)
  if not b then return end
  local all = stage.bounds
  if not all then
    stage.bounds = { b[1], b[2], b[3], b[4], b[5], b[6] }
    return
  end
  for a = 1, 3 do all[a], all[a + 3] = math.min(all[a], b[a]), math.max(all[a + 3], b[a + 3]) end
end

local function diagonal(b)
  return math.sqrt((b[4] - b[1]) ^ 2 + (b[5] - b[2]) ^ 2 + (b[6] - b[3]) ^ 2)
end

--- Passes on the failure of a C call that returns nothing when it succeeds.
local function run(...)
  local _, message, code = ...
  if message then error({ message, code }, 0) end
end

--- Lit surfaces, flat lines.
local function add_surface(stage, shape, style)
  style = style or {}
  local _, _, b = core.shape_info(shape)
  grow(stage, b)
  run(stage.vtk.scene_shape(stage.scene, shape, style.ambient or 0.28, style.diffuse or 0.72, style.specular or 0.12, 1,
    style.opacity or 1, style.flat or false, false))
end

local function add_lines(stage, shape, width)
  run(stage.vtk.scene_shape(stage.scene, shape, 1, 0, 0, width or 1, 1, false, false))
end

--- Voxels along each axis, `most` along the longest.
local function voxels(b, most)
  local longest, size = math.max(b[4] - b[1], b[5] - b[2], b[6] - b[3]), {}
  for a = 1, 3 do size[a] = math.max(1, math.floor((b[a + 3] - b[a]) / longest * most + 0.5)) end
  return size
end

--- The quantity on a lattice that fills `b`.
local function sampled(v, b, size)
  local volume = assert(core.volume(b, size, 1))
  if v.lattice then run(core.volume_resample(volume, v.lattice.volume))
  else
    local pointwise = view_grid.quantities[v.quantity].of == "points"
    run(core.volume_fill(volume, v.values, pointwise, cells_args(v.source, nil, pointwise)))
  end
  return volume
end

local function is_pointwise(v) return v.lattice or view_grid.quantities[v.quantity].of == "points" end

local function subject_bounds(v) return v.source and v.source.bounds or v.lattice and v.lattice.bounds end

local fill = {}

function fill.volume(stage, v)
  local o, b = options(v.volume), subject_bounds(v)
  if v.lattice and not (o.density or o.smooth or not (v.slices or v.isosurfaces)) then return end
  local volume = v.lattice and v.lattice.volume or sampled(v, b, voxels(b, v.resolution))
  local density, list = o.density or 1, {}
  for i = 0, 255 do list[i + 1] = { math.max(0, (i - 1) / 254) } end
  local at = core.array_zeros({ 256, 1 }, "double")
  core.array_fill(at, list)
  local rgb = core.array_totable(core.figure_colours(at, { 0, 0, 0 }, v.scale.map, 0, 1, false))
  for i = 1, 256 do
    local t = list[i][1]
    rgb[i][4] = math.min(1, density * (0.006 + 0.5 * t ^ 2.2))
  end
  local table4 = core.array_zeros({ 256, 4 }, "double")
  core.array_fill(table4, rgb)
  local smooth = o.smooth
  if smooth == nil then smooth = is_pointwise(v) and true or false end
  run(stage.vtk.scene_volume(stage.scene, volume, table4, diagonal(b) / 40, smooth, scale_of(v.scale)))
  grow(stage, b)
end

--- Where along axis `a` most of what a grid holds is: the median of its occupied leaves' middles.
local function median_place(v, a)
  local b = subject_bounds(v)
  if not v.source then return (b[a] + b[a + 3]) / 2 end
  local cells = v.source.cells
  local drawn = both(cells.leaf, cells.occupied)
  local origin, size = core.figure_pick(cells.origin, drawn), core.figure_pick(cells.size, drawn)
  local n = origin.shape[1]
  if n == 0 then return (b[a] + b[a + 3]) / 2 end
  local middles = {}
  for i = 1, n do middles[i] = core.array_get(origin, i, a) + core.array_get(size, i, a) / 2 end
  table.sort(middles)
  return middles[math.ceil(n / 2)]
end

function fill.slices(stage, v)
  local b = subject_bounds(v)
  for _, slice in ipairs(type(v.slices) == "table" and v.slices or { { axis = "y" } }) do
    local a = axis_number[slice.axis]
    local flat = { b[1], b[2], b[3], b[4], b[5], b[6] }
    local at = slice.at or median_place(v, a)
    if at < b[a] or at > b[a + 3] then
      error({ ("slices: %s = %g is outside of the bounds, %g to %g"):format(slice.axis, at, b[a], b[a + 3]),
        "ERANGE" }, 0)
    end
    flat[a], flat[a + 3] = at, at
    local size = voxels(flat, 512)
    size[a] = 1
    local smooth = is_pointwise(v) and true or false
    run(stage.vtk.scene_slice(stage.scene, sampled(v, flat, size), slice.opacity or 1, smooth, scale_of(v.scale)))
  end
  grow(stage, b)
end

function fill.isosurfaces(stage, v)
  local b = subject_bounds(v)
  local volume = v.lattice and v.lattice.volume or sampled(v, b, voxels(b, v.resolution))
  if not is_pointwise(v) then run(core.volume_smooth(volume, 2)) end
  local wanted, values = v.isosurfaces, {}
  if type(wanted) == "table" then values = wanted
  else
    local n, lo, hi = wanted == true and 3 or wanted, v.scale.range[1], v.scale.range[2]
    for i = 1, n do
      local t = (i - 0.35) / (n + 0.3)
      values[i] = v.scale.log and lo * (hi / lo) ^ t or lo + (hi - lo) * t
    end
  end
  local n, list = #values, {}
  local at = core.array_zeros({ n }, "double")
  core.array_fill(at, values)
  local rgb = core.array_totable(core.figure_colours(at, { 0.5, 0.5, 0.5 }, scale_of(v.scale)))
  for i = 1, n do
    local opacity = n == 1 and 1 or 0.35 + 0.65 * (i - 1) / (n - 1)
    list[i] = { rgb[i][1], rgb[i][2], rgb[i][3], opacity }
  end
  local colours = core.array_zeros({ n, 4 }, "double")
  core.array_fill(colours, list)
  run(stage.vtk.scene_isosurfaces(stage.scene, volume, at, colours))
  grow(stage, b)
end

--- Colours [levels][4] of the edges of cells, by level.
local function level_colours(v, theme, opacity)
  local list, by_level = {}, v.quantity == "level" and v.scale
  local _, deepest = core.figure_range(v.source.cells.level)
  for l = 0, deepest do list[l + 1] = { l } end
  local at = core.array_zeros({ #list, 1 }, "double")
  core.array_fill(at, list)
  local rgb = by_level and core.array_totable(core.figure_colours(at, theme.text, scale_of(v.scale)))
  for l = 0, deepest do
    local c = rgb and rgb[l + 1] or theme.text
    -- Fine cells are many: their edges are fainter.
    local alpha = opacity * (by_level and 1 or math.max(0.06, 0.5 * 0.66 ^ l))
    list[l + 1] = { c[1], c[2], c[3], math.min(1, alpha) }
  end
  local colours = core.array_zeros({ #list, 4 }, "double")
  core.array_fill(colours, list)
  return colours
end

local function chosen_cells(v, o)
  local drawn = v.source.cells.leaf
  if o.occupied then drawn = both(drawn, v.source.cells.occupied) end
  if o.from then
    local level, list = core.array_totable(v.source.cells.level), core.array_totable(drawn)
    for i = 1, #list do if level[i] < o.from then list[i] = 0 end end
    drawn = core.array_zeros({ #list }, "double")
    core.array_fill(drawn, list)
  end
  return drawn
end

function fill.levels(stage, v)
  local o = options(v.levels)
  local shape = core.shape(2)
  run(core.shape_edges(shape, level_colours(v, stage.theme, o.opacity or 1), cells_args(v.source, chosen_cells(v, o))))
  add_lines(stage, shape, o.width or 1)
  grow(stage, v.source.bounds)
end

function fill.boxes(stage, v)
  local o = options(v.boxes)
  local values = v.values
  if view_grid.quantities[v.quantity].of == "points" then
    error({ "boxes show a quantity of cells: error, level or residual", "EINVAL" }, 0)
  end
  local drawn = chosen_cells(v, o)
  local colours = core.figure_colours(values, stage.theme.dim, scale_of(v.scale))
  local shape = core.shape(3)
  run(core.shape_boxes(shape, colours, o.shrink or 0.12, o.opacity or 1, cells_args(v.source, drawn)))
  add_surface(stage, shape)
  grow(stage, v.source.bounds)
end

--- At most `count` of the points, spread evenly: their mask and their distance.
local function spread(points, bounds, count)
  local n = points.shape[1]
  local spacing = math.max(diagonal(bounds), 1e-30) / (2 * count ^ (1 / 3))
  for _ = 1, 12 do
    local mask, kept = core.figure_thin(points, spacing, math.huge)
    if kept <= count or n == 0 then return mask, spacing end
    spacing = spacing * 1.12 * math.min(1.6, (kept / count) ^ (1 / 3))
  end
  return core.figure_thin(points, spacing, count), spacing
end

function fill.glyphs(stage, v)
  local o = options(v.glyphs)
  local shape = core.shape(3)
  local at, along, spacing
  if v.arrows then at, along = v.arrows.at, v.arrows.along
  else
    local position = v.source.position()
    local mask
    mask, spacing = spread(position, v.source.bounds, o.count or 1500)
    at, along = core.figure_pick(position, mask), core.figure_pick(v.gradient, mask)
  end
  local lengths = core.figure_lengths(along)
  local colours = core.figure_colours(lengths, stage.theme.dim, scale_of(v.vector_scale))
  if spacing then
    -- Lengths between a third and the whole of the distance of neighbours: directions stay legible.
    local list, lo, hi = core.array_totable(lengths), v.vector_scale.range[1], v.vector_scale.range[2]
    for i, x in ipairs(list) do
      local t = v.vector_scale.log and math.log(math.max(x, lo) / lo) / math.log(hi / lo) or (x - lo) / (hi - lo)
      t = math.max(0, math.min(1, t))
      list[i] = x > 0 and (o.length or 1) * spacing * (0.35 + 0.75 * t) / x or 0
    end
    local factor = core.array_zeros({ #list }, "double")
    core.array_fill(factor, list)
    along = core.figure_scaled(along, factor)
  end
  run(core.shape_arrows(shape, at, along, colours))
  add_surface(stage, shape, { ambient = 0.45, diffuse = 0.65, specular = 0.05 })
  if v.source then grow(stage, v.source.bounds) end
end

--- Seeds on a lattice of about `count` points inside the bounds, jittered always the same way.
local function seeds(b, count)
  local step = ((b[4] - b[1]) * (b[5] - b[2]) * (b[6] - b[3]) / count) ^ (1 / 3)
  local list, state = {}, 12345
  local function jitter()
    state = (state * 16807) % 2147483647
    return state / 2147483647 - 0.5
  end
  local n = {}
  for a = 1, 3 do n[a] = math.max(1, math.floor((b[a + 3] - b[a]) / step + 0.5)) end
  for z = 1, n[3] do for y = 1, n[2] do for x = 1, n[1] do
    local i, p = { x, y, z }, {}
    for a = 1, 3 do p[a] = b[a] + (i[a] - 0.5 + 0.8 * jitter()) / n[a] * (b[a + 3] - b[a]) end
    list[#list + 1] = p
  end end end
  local out = core.array_zeros({ #list, 3 }, "double")
  core.array_fill(out, list)
  return out
end

function fill.streamlines(stage, v)
  local o = options(v.streamlines)
  local b = v.flow and v.flow.bounds or v.source.bounds
  local volume
  if v.flow then
    volume = assert(core.volume(b, v.flow.size, 3))
    run(core.volume_set(volume, v.flow.values))
  else
    volume = assert(core.volume(b, voxels(b, v.resolution), 3))
    run(core.volume_fill(volume, v.gradient, true, cells_args(v.source, nil, true)))
  end
  local shape, reach = core.shape(3), diagonal(b)
  run(core.shape_streamlines(shape, volume, seeds(b, o.count or 150), reach / 400, 600, 12,
    reach * 0.0016 * (o.width or 1), scale_of(v.vector_scale)))
  add_surface(stage, shape, { ambient = 0.45, diffuse = 0.65, specular = 0.05 })
  grow(stage, b)
end

-- Warm where the function is positive, cool where it is negative.
local positive, negative = { 0.96, 0.55, 0.16 }, { 0.16, 0.48, 0.86 }

local function add_lobes(stage, coefficients, lmax, centres, sizes, detail, fit)
  local directions = core.figure_sphere(detail)
  local basis = require("ylm.sh").eval(lmax, directions, { dtype = "double" })
  local shape = core.shape(3)
  run(core.shape_lobes(shape, coefficients, centres, sizes, positive, negative, detail, basis, fit))
  add_surface(stage, shape, { specular = 0.2 })
end

local function constant(n, x)
  local a, list = core.array_zeros({ n }, "double"), {}
  for i = 1, n do list[i] = x end
  core.array_fill(a, list)
  return a
end

function fill.lobes(stage, v)
  local o = options(v.lobes)
  local position = v.source.position()
  local mask, spacing = spread(position, v.source.bounds, o.count or 300)
  local centres = core.figure_pick(position, mask)
  local coefficients = core.figure_pick(v.source.coefficients(), mask)
  local n, count = centres.shape[1], coefficients.shape[2]
  add_lobes(stage, coefficients, math.floor(math.sqrt(count) + 0.5) - 1, centres,
    constant(n, 0.42 * spacing * (o.size or 1)), n > 600 and 3 or 4, true)
  grow(stage, v.source.bounds)
end

--- SH vectors side by side, in rows of at most eight, seen from -y: x to the right, z up.
function fill.sh(stage, v)
  local n, list = v.sh.shape[1], {}
  local columns = math.min(n, math.max(1, math.ceil(math.sqrt(n * 1.8))))
  stage.labels = {}
  for i = 1, n do
    local column, row = (i - 1) % columns, math.floor((i - 1) / columns)
    list[i] = { 2.2 * column, 0, -2.6 * row }
    if v.labels and v.labels[i] then
      stage.labels[#stage.labels + 1] = { text = v.labels[i], at = { 2.2 * column, 0, -2.6 * row - 1.08 } }
    end
  end
  local centres = core.array_zeros({ n, 3 }, "double")
  core.array_fill(centres, list)
  add_lobes(stage, v.sh, v.lmax, centres, constant(n, 1), 6, true)
  local lowest = -2.6 * math.floor((n - 1) / columns) - (v.labels and 1.35 or 1)
  grow(stage, { -1, -1, lowest, 2.2 * (columns - 1) + 1, 1, 1 })
end

--- Linear light as a colour on the screen.
local function encode(x)
  x = math.max(0, math.min(1, x))
  return x <= 0.0031308 and 12.92 * x or 1.055 * x ^ (1 / 2.4) - 0.055
end

--- The colour of a light on the screen; a little white keeps saturated ones visible.
local function lit(rgb)
  local most = math.max(rgb[1], rgb[2], rgb[3], 1e-30)
  for a = 1, 3 do rgb[a] = 0.15 + 0.85 * encode(math.max(0, rgb[a]) / most) end
  return rgb
end

--- Triangles [t][9], and disks [d][7] as 48-gons, in the colours of radiance [t+d][3].
local function add_flat_lights(stage, triangles, disks, radiance)
  local position, colour, index = {}, {}, {} -- three rows to a triangle, no corner shared
  local rgb, list = core.array_totable(radiance), core.array_totable(triangles)
  local function corner(x, y, z, c)
    position[#position + 1], colour[#colour + 1] = { x, y, z }, c
    if #position % 3 == 0 then index[#index + 1] = { #position - 2, #position - 1, #position } end
  end
  for i, t in ipairs(list) do
    local c = lit(rgb[i])
    for k = 0, 2 do corner(t[3 * k + 1], t[3 * k + 2], t[3 * k + 3], c) end
  end
  for i, d in ipairs(core.array_totable(disks)) do
    local c = lit(rgb[#list + i])
    local u, w = require "ylm.light_polygon".frame { d[5], d[6], d[7] }
    local function rim(k)
      local a, b = d[4] * math.cos(math.pi * k / 24), d[4] * math.sin(math.pi * k / 24)
      corner(d[1] + a * u[1] + b * w[1], d[2] + a * u[2] + b * w[2], d[3] + a * u[3] + b * w[3], c)
    end
    for k = 0, 47 do
      corner(d[1], d[2], d[3], c)
      rim(k)
      rim(k + 1)
    end
  end
  local function numbers(threes)
    local a = assert(core.array_zeros({ #threes, 3 }, "double"))
    core.array_fill(a, threes)
    return a
  end
  local shape = core.shape(3)
  run(core.shape_mesh(shape, numbers(position), nil, numbers(colour), numbers(index), 1))
  add_surface(stage, shape, { ambient = 1, diffuse = 0, specular = 0 })
end

function fill.lights(stage, v)
  local light = require "ylm.light"
  local packed = core.has_field(v.lights) and v.lights or light.pack(1, "view", v.lights)
  local triangles, disks, flat = light.patches(packed)
  if triangles then add_flat_lights(stage, triangles, disks, flat) end
  local at, radius, radiance = light.arrays(packed)
  local c, r = core.array_totable(radiance), core.array_totable(radius)
  local least = stage.bounds and diagonal(stage.bounds) * 0.0022 or 0
  for i, rgb in ipairs(c) do
    lit(rgb)
    r[i] = math.max(r[i], least)
  end
  if #r == 0 then return end
  core.array_fill(radiance, c)
  core.array_fill(radius, r)
  local shape = core.shape(3)
  run(core.shape_spheres(shape, at, radius, radiance, #r > 3000 and 2 or #r > 50 and 3 or 5))
  add_surface(stage, shape, { ambient = 1, diffuse = 0, specular = 0 })
end

local function add_mesh(stage, m, opacity)
  local mesh = m.mesh
  local position = core.array_convert(mesh:vertices(), "double")
  local normals = mesh:normals()
  normals = normals and core.array_convert(normals, "double")
  local colour = m.colours
  if colour and #colour ~= #position then
    error({ ("meshes: %d colours for %d vertices"):format(#colour, #position), "ESHAPE" }, 0)
  end
  if not colour then
    local c = m.colour
    local albedo = not c and m.material and m.material.albedo
    if type(albedo) == "number" then albedo = { albedo, albedo, albedo } end
    if not c and type(albedo) == "table" then c = { encode(albedo[1]), encode(albedo[2]), encode(albedo[3]) } end
    c = c or { 0.66, 0.67, 0.69 }
    colour = core.array_zeros({ 1, 3 }, "double")
    core.array_fill(colour, { c })
  end
  local shape = core.shape(3)
  run(core.shape_mesh(shape, position, normals, colour, mesh:triangles(), 1))
  add_surface(stage, shape, { opacity = opacity or m.opacity or 1, specular = 0.1 })
end

function fill.meshes(stage, v)
  for _, m in ipairs(v.meshes) do add_mesh(stage, m) end
end

function fill.scene(stage, v)
  for _, part in ipairs(v.scene.geometry) do
    add_mesh(stage, { mesh = part.mesh, material = part.material }, v.opacity)
  end
end

function fill.points(stage, v)
  local n = v.points.shape[1]
  local b = core.figure_bounds(v.points)
  local colours, list = core.array_zeros({ n, 3 }, "double"), {}
  for i = 1, n do list[i] = stage.theme.text end
  core.array_fill(colours, list)
  local reach = stage.bounds and diagonal(stage.bounds) or diagonal(b)
  local shape = core.shape(3)
  run(core.shape_spheres(shape, v.points, constant(n, math.max(reach, 1e-6) * 0.003), colours, n > 2000 and 1 or 2))
  add_surface(stage, shape)
end

--- The edges of the bounds, where no cells are drawn.
local function add_frame(stage, v)
  local b = subject_bounds(v) or v.flow and v.flow.bounds
  if not b or not v.frame or v.levels then return end
  local origin, size = core.array_zeros({ 1, 3 }, "double"), core.array_zeros({ 1, 3 }, "double")
  core.array_fill(origin, { { b[1], b[2], b[3] } })
  core.array_fill(size, { { b[4] - b[1], b[5] - b[2], b[6] - b[3] } })
  local colour = core.array_zeros({ 1, 4 }, "double")
  core.array_fill(colour, { picture.with_alpha(stage.theme.dim, 0.8) })
  local shape = core.shape(2)
  run(core.shape_edges(shape, colour, origin, size))
  add_lines(stage, shape, 1)
  grow(stage, b)
end

local order = { "scene", "meshes", "boxes", "slices", "isosurfaces", "glyphs", "streamlines", "lobes", "sh", "volume",
  "levels", "lights", "points" }

--- Puts all layers of stage.view into stage.scene. Returns true, or nil, message, code.
function layers.fill(stage)
  local v = stage.view
  local ok, problem = pcall(function()
    for _, name in ipairs(order) do if v[name] then fill[name](stage, v) end end
    add_frame(stage, v)
  end)
  if ok then
    stage.bounds = stage.bounds or { -1, -1, -1, 1, 1, 1 }
    return true
  end
  if type(problem) == "table" then
    if core.status(problem[2]) == "caller" then return check.fail("view: %s", problem[1]) end
    return nil, problem[1], problem[2]
  end
  error(problem, 0)
end

return layers
