--- ylm info FILE: what a file holds. Of a grid, what its header says: rows are not read. Of a scene file, what it describes.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local form = { "quantity", "lmax", "channels", "bounds", "resolution", "depth", "continuous", "metric", "metric_channels",
  "tolerance", "measure", "threshold", "sides", "floor", "body", "prints" }
local stats = { "points", "interpolated", "invalid", "tested", "cells", "leaves", "occupied", "levels", "continuity", "pairs",
  "outside", "error", "largest_error", "met", "limited", "verified" }

local of_small = { "before", "rounding", "largest", "judged", "step" }
local of_surfaces = { "error", "met", "rms", "corners", "rectangles", "rows", "charts", "places", "rounds", "rays", "verified",
  "failed", "seconds", "bytes" }

--- Adds fields of a table to the results, in an order.
local function add(results, order, from, names)
  for _, name in ipairs(names) do
    results[name] = from[name]
    order[#order + 1] = name
  end
end

local sequences = { "^[\32-\126]+", "^\194[\160-\191]", "^[\195-\223][\128-\191]", "^[\224-\239][\128-\191][\128-\191]",
  "^[\240-\244][\128-\191][\128-\191][\128-\191]" }

--- Text of a file for a terminal: control characters, and bytes that are no UTF-8, become question marks.
local function plain(text)
  local out, at = {}, 1
  while at <= #text do
    local found
    for _, sequence in ipairs(sequences) do found = found or text:sub(at):match(sequence) end
    out[#out + 1] = found or "?"
    at = at + #(found or "?")
  end
  return table.concat(out)
end

local kinds = {}

function kinds.grid(path, given)
  local look = status.need(require("ylm.grid.file").look(path))
  local results, order = { kind = look.form.kind .. " grid" }, { "kind" }
  add(results, order, look.form, form)
  add(results, order, look.stats, stats)
  add(results, order, look, { "version", "bytes" })
  if look.small then add(results, order, look.small, of_small) end
  if given.json then
    results.sections = look.sections
    return results
  end
  for _, s in ipairs(look.sections) do
    local name = "section " .. s.name
    results[name] = ("%.0f bytes%s"):format(s.bytes, s.known and "" or ", not known to this ylm")
    order[#order + 1] = name
  end
  return results, order
end

function kinds.grid_set(path)
  local set = status.need(require "ylm".load(path))
  local results, order, of = { kind = "adaptive grid in bricks" }, { "kind" }, set.stats
  for _, name in ipairs(form) do results[name], order[#order + 1] = set[name], name end
  add(results, order, of, stats)
  add(results, order, of, { "bricks", "brick_level", "file_bytes" })
  if set.small then add(results, order, set.small, of_small) end
  return results, order
end

function kinds.surface_grid(path)
  local lib = status.need(require("ylm.trace").library())
  local of, known, tolerance, quantity = status.need(lib.surface_inspect(path))
  local results = { kind = "light on surfaces", quantity = quantity, tolerance = tolerance, prints = known }
  local order = { "kind", "quantity", "tolerance" }
  add(results, order, of, of_surfaces)
  order[#order + 1] = "prints"
  return results, order
end

function kinds.array(path)
  local a = status.need(require "ylm".load(path))
  return { kind = "array", shape = a.shape, dtype = a.dtype, convention = a.convention },
    { "kind", "shape", "dtype", "convention" }
end

function kinds.image(path, given)
  local x = status.need(require "ylm".load(path))
  local results, order = { kind = "image", size = x.size, layers = {} }, { "kind", "size", "layers" }
  local names, channels = x:layers()
  for i, name in ipairs(names) do results.layers[i] = { name = name, channels = channels[name] } end
  local metadata, keys = x.metadata(), {}
  if given.json then
    results.metadata = metadata
    return results
  end
  for i, layer in ipairs(results.layers) do results.layers[i] = ("%s (%d)"):format(plain(layer.name), layer.channels) end
  for key in pairs(metadata) do keys[#keys + 1] = key end
  table.sort(keys)
  for _, key in ipairs(keys) do
    local name = "metadata " .. plain(key)
    results[name], order[#order + 1] = plain(metadata[key]), name
  end
  return results, order
end

function kinds.mesh(path)
  require "ylm.geometry" -- its methods
  local m = status.need(require "ylm".load(path))
  return { kind = "mesh", vertices = #m:vertices(), triangles = #m, bounds = m.bounds, area = m.area },
    { "kind", "vertices", "triangles", "bounds", "area" }
end

function kinds.gltf(path)
  local model = status.load(path)
  local results, order = { kind = "glTF" }, { "kind" }
  add(results, order, model.report, { "nodes", "pieces", "triangles", "materials", "lights", "cameras", "notes" })
  for i, note in ipairs(results.notes) do results.notes[i] = plain(note) end
  return results, order
end

function kinds.material(path) return require "ylm.cli.material".look(path) end
function kinds.photometry(path) return require "ylm.cli.photometry".look(status.need(require "ylm".load(path))) end

--- Fields of an object that a form has built which are numbers, words or lists of numbers, with its kind; nil of nil.
local function described(x)
  if x == nil then return nil end
  local forms = require "ylm.form"
  local kind = forms.kind(x)
  local out = { kind = kind }
  for _, field in ipairs(forms.defined[kind].fields) do
    local value = x[field[1]]
    if type(value) ~= "table" or value[1] ~= nil and forms.kind(value) == nil then out[field[1]] = value end
  end
  return out
end

--- Kind -> how many there are, of different objects: one that is listed twice counts once.
local function counts(list, kind_of, number_of)
  local out, seen = {}, {}
  for _, x in ipairs(list) do
    if not seen[x] then
      local kind = kind_of(x)
      out[kind], seen[x] = (out[kind] or 0) + number_of(x), true
    end
  end
  return out
end

--- The box around all geometry of a scene; nil where there is none.
local function bounds_of(geometry)
  local lo, hi
  for _, piece in ipairs(geometry) do
    local b = #piece.mesh > 0 and piece.mesh.bounds
    if b then
      lo, hi = lo or { b[1][1], b[1][2], b[1][3] }, hi or { b[2][1], b[2][2], b[2][3] }
      for a = 1, 3 do lo[a], hi[a] = math.min(lo[a], b[1][a]), math.max(hi[a], b[2][a]) end
    end
  end
  return lo and { lo, hi }
end

--- A scene file runs within the limits of ylm.load.
function kinds.scene(path)
  local forms, materials, triangles = require "ylm.form", require "ylm.material", 0
  local s = status.load(path)
  local used = {}
  for i, piece in ipairs(s.geometry) do
    triangles, used[i] = triangles + #piece.mesh, piece.material or materials.default
  end
  local function one() return 1 end
  local function kind(x) return (forms.kind(x):gsub("^ylm%.", "")) end
  local results = { kind = "scene", name = s.name, meshes = #s.geometry, triangles = triangles, bounds = bounds_of(s.geometry),
    materials = counts(used, kind, one),
    lights = counts(s.lights, kind, function(l) return type(l) == "table" and l.count or 1 end),
    camera = described(s.camera), probes = described(s.probes), links = described(s.link_options),
    background = not s.sky_is_seen and s.background or nil, notes = s.notes }
  if results.camera then results.camera.kind = nil end
  for i, note in ipairs(results.notes or {}) do results.notes[i] = plain(note) end
  return results, { "kind", "name", "meshes", "triangles", "bounds", "materials", "lights", "camera", "probes", "links",
    "background", "notes" }
end

--- Prints what the file given[1] holds.
return function(given)
  local kind = status.need(require("ylm.file").kind_of(given[1]))
  report.print(given, kinds[kind](given[1], given))
end
