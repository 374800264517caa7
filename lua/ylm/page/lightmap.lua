--- Pages of lightmaps: the surfaces, the picture that lights them, and a viewer in one HTML file, for lightmap:save.

local box = require "ylm.box"
local check = require "ylm.check"
local core = require "ylm.c.core"
local library = require "ylm.library"
local pack = require "ylm.page.pack"
local text = require "ylm.text"
local vector = require "ylm.vector"
local viewer = require "ylm.page.viewer"

local page = {}

local PALETTE = 16
local RATIO = 1e-3 -- of the largest error of a chart, which colours begin at

--- The box of all pieces: its corners, and its diagonal.
local function bounds_of(pieces)
  local lo, hi = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  for _, piece in ipairs(pieces) do
    local b = piece.mesh.bounds
    for a = 1, 3 do lo[a], hi[a] = math.min(lo[a], b[1][a]), math.max(hi[a], b[2][a]) end
  end
  return lo, hi, box.diagonal(lo, hi)
end

--- The scene's camera, or one that sees everything, relative to `lo`: from, at, up, angle.
local function camera_of(scene, lo, hi, extent)
  local c = scene.camera
  if not c then
    local at, from, d = {}, {}, { 0.6, 0.4, 0.7 }
    for a = 1, 3 do
      at[a] = (lo[a] + hi[a]) / 2
      from[a] = at[a] + 1.4 * extent * d[a]
    end
    c = { from = from, at = at, up = { 0, 1, 0 }, fov = 40 }
  end
  local up, out = vector.unit(c.up), {}
  for a = 1, 3 do out[a], out[3 + a], out[6 + a] = c.from[a] - lo[a], c.at[a] - lo[a], up[a] end
  out[10] = c.fov
  return out
end

--- Adds the pieces; true, or nil, message, code.
local function add_pieces(blob, pieces, lo)
  local positions, uvs, albedos, triangles, vertices, faces = {}, {}, {}, {}, 0, 0
  for i, piece in ipairs(pieces) do
    local albedo, message, code = pack.albedo(piece, piece.mesh, #piece.uvs)
    if not albedo then return nil, message, code end
    positions[i] = core.array_convert(piece.mesh:vertices() - lo, "float"):bytes()
    uvs[i] = piece.uvs:bytes()
    albedos[i] = core.page_positions(albedo, { 0, 0, 0 }, { 1 / 65535, 1 / 65535, 1 / 65535 })
    triangles[i] = core.page_triangles(piece.mesh:triangles(), vertices)
    vertices, faces = vertices + #piece.uvs, faces + #piece.mesh
  end
  blob.add("positions", "f32", { vertices, 3 }, table.concat(positions))
  blob.add("uvs", "f32", { vertices, 2 }, table.concat(uvs))
  blob.add("albedo", "u16", { vertices, 3 }, table.concat(albedos))
  blob.add("triangles", "u32", { faces, 3 }, table.concat(triangles))
  return true
end

--- Least and largest of numbers above 0, apart from each other, for colours.
local function range_of(list, ratio)
  local least, most = math.huge, 0
  for i = 1, #list do if list[i] > 0 then least, most = math.min(least, list[i]), math.max(most, list[i]) end end
  if most == 0 then return { 1e-3, 1 } end
  return { math.min(math.max(least, ratio * most), most / 1.01), most }
end

local function palette()
  local list = {}
  for i = 1, PALETTE do list[i] = { core.colourmap_at("viridis", (i - 1) / (PALETTE - 1)) } end
  return list
end

local entities = { ["<"] = "&lt;", [">"] = "&gt;", ["&"] = "&amp;", ['"'] = "&quot;" }

local function html(sources, meta, data)
  local words = { VERSION = meta.version, TITLE = (meta.title:gsub('[<>&"]', entities)), STYLE = sources["style.css"],
    META = pack.json(meta), DATA = data, SCRIPT = sources["lightmap.js"] }
  return (sources["lightmap.html"]:gsub("@([%u_]+)@", function(word) return words[word] end))
end

local function words_of(m)
  local s = m.stats
  return ("%s light, %d x %d texels, %d charts, error %.2g"):format(m.quantity, s.width, s.height, s.charts, s.error)
end

--- Writes a page of a lightmap. light: { pieces, charts = image layer, picture = bytes of a .png, range, errors, densities };
-- o: title, exposure in stops of radiance, limit. The bytes of the file; or nil, message, code.
function page.save(m, path, light, o)
  local sources, message, code = viewer.sources { "lightmap.html", "lightmap.js", "style.css" }
  if not sources then return nil, message, code end
  local ok
  ok, message, code = library.open("codec", "pages need libylm_codec")
  if not ok then return nil, message, code end
  local lo, hi, extent = bounds_of(light.pieces)
  local blob = pack.blob()
  ok, message, code = add_pieces(blob, light.pieces, lo)
  if not ok then return nil, message, code end
  local s, scene = m.stats, m.scene
  blob.add("charts", "u32", { s.width * s.height, 1 }, core.array_convert(light.charts, "int32"):bytes())
  blob.add("errors", "f32", { s.charts, 1 }, light.errors:bytes())
  blob.add("densities", "f32", { s.charts, 1 }, light.densities:bytes())
  blob.add("picture", "u8", { #light.picture, 1 }, light.picture)
  local meta = { version = (core.info()), title = text.shown(o.title or scene.name or "Lightmap"), size = { s.width, s.height },
    range = light.range, exposure = o.exposure, camera = camera_of(scene, lo, hi, extent), lowest = lo, extent = extent,
    background = scene.background or { 0.02, 0.02, 0.02 }, density = range_of(light.densities, RATIO),
    errors = range_of(light.errors, RATIO), palette = palette(), sections = blob.sections, words = words_of(m) }
  local bytes = html(sources, meta, blob.base64())
  if #bytes > o.limit then
    return nil, ("page: %.1f MB, the limit is %.1f MB: fewer texels, or raise limit"):format(#bytes / 1e6, o.limit / 1e6),
      "ELIMIT"
  end
  ok, message, code = check.result("save", core.file_save(path, bytes))
  if not ok then return nil, message, code end
  return #bytes
end

return page
