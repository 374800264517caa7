--- ylm info FILE: what a file holds. Of a grid, what its header says: rows are not read.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local form = { "quantity", "lmax", "channels", "bounds", "resolution", "depth", "continuous", "metric", "metric_channels",
  "tolerance", "measure", "threshold", "bias", "floor", "body" }
local stats = { "points", "interpolated", "invalid", "tested", "cells", "leaves", "occupied", "levels", "continuity", "pairs",
  "outside", "error", "largest_error", "met", "limited", "verified" }

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
  local model = status.need(require "ylm".load_gltf(path))
  local results, order = { kind = "glTF" }, { "kind" }
  add(results, order, model.report, { "nodes", "pieces", "triangles", "materials", "lights", "cameras", "notes" })
  for i, note in ipairs(results.notes) do results.notes[i] = plain(note) end
  return results, order
end

function kinds.material(path) return require "ylm.cli.material".look(path) end

--- Prints what the file given[1] holds.
return function(given)
  local kind = status.need(require("ylm.file").kind_of(given[1]))
  report.print(given, kinds[kind](given[1], given))
end
