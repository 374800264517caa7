--- The numbers of a page as sections of one blob, and its facts as JSON.

local core = require "ylm.c.core"
local geometry = require "ylm.geometry"
local json = require "ylm.json"
local library = require "ylm.library"
local material = require "ylm.material"

local pack = {}

-- JSON within HTML -----------------------------------------------------------------------

--- Characters that end a script of HTML, or a line of JavaScript, are written as numbers.
local function quoted(s)
  s = json.quoted(s):gsub("[<>&]", function(c) return ("\\u%04x"):format(c:byte()) end)
  return (s:gsub("\226\128\168", "\\u2028"):gsub("\226\128\169", "\\u2029"))
end

local function number(x)
  if x ~= x or x == math.huge or x == -math.huge then return "null" end
  return x == math.floor(x) and math.abs(x) < 2 ^ 53 and ("%.0f"):format(x) or ("%.9g"):format(x)
end

--- JSON of numbers, strings, booleans, lists and tables with string keys (sorted); a number that is not finite is null.
function pack.json(x) return json.write(x, number, quoted) end

-- Sections ---------------------------------------------------------------------------------

local size_of = { u8 = 1, i8 = 1, u16 = 2, i16 = 2, f16 = 2, u32 = 4, f32 = 4 }

--- A blob in the making.
function pack.blob()
  local codec = library.open("codec", "%s")
  local blob = { sections = {}, parts = {}, bytes = 0, by_name = {} }

  --- Adds the numbers of `bytes`, of a type and shape; delta: as differences between rows.
  function blob.add(name, kind, shape, bytes, delta)
    local columns = 1
    for i = 2, #shape do columns = columns * shape[i] end
    local packed = core.page_planes(bytes, size_of[kind], delta and columns or 0)
    local coding = (delta and "delta+" or "") .. "planes"
    if codec then
      local deflated = codec.deflate(packed) -- nothing without zlib, and of more than 2 GiB
      if deflated then packed, coding = deflated, coding .. "+zlib" end
    end
    blob.sections[#blob.sections + 1] = { name = name, type = kind, shape = { shape[1], columns }, coding = coding,
      bytes = #packed }
    blob.parts[#blob.parts + 1] = packed
    blob.bytes = blob.bytes + #packed
    blob.by_name[name] = #packed
  end

  function blob.base64() return core.page_base64(table.concat(blob.parts)) end

  return blob
end

local parts_of_few = { "head", "tree", "bases", "tables", "points", "numbers", "bits" }

--- The streams of a grid in few bytes.
local function add_few(blob, grid, parts)
  for _, name in ipairs(parts_of_few) do blob.add(name, "u8", { #parts[name] }, parts[name]) end
  local frame = core.page_frame(grid)
  blob.add("frame", "u8", { #frame }, frame)
end

--- Cells, sides and rows of a grid; facts: those of core.page_facts by name; made: as of few.of, nil: of another precision.
function pack.grid(blob, grid, facts, precision, made)
  blob.add("cells", "u32", { facts.cells + facts.parts, 12 }, core.page_cells(grid, made and made.errors))
  if facts.sides > 0 and not made then blob.add("sides", "u32", { facts.sides, 29 }, core.page_sides(grid)) end
  if grid.kind == "uniform" then
    local n = grid.resolution
    blob.add("table", "u32", { n[1] * n[2] * n[3] }, core.page_table(grid))
  end
  if made then return add_few(blob, grid, made.parts) end
  blob.add("flags", "u8", { facts.evaluated }, core.page_flags(grid))
  local width = facts.channels * facts.count
  local rows, slopes, scales = core.page_rows(grid, facts.exponent, precision)
  if precision == "byte" then
    blob.add("values", "f16", { facts.evaluated, width }, rows)
    blob.add("slopes", "i8", { facts.evaluated, 3 * width }, slopes)
    blob.add("scales", "f32", { facts.evaluated, 3 }, scales)
  else blob.add("rows", precision == "half" and "f16" or "f32", { facts.evaluated, 4 * width }, rows) end
end

-- Meshes -------------------------------------------------------------------------------------

local function floats(n, values)
  local a = core.array_zeros({ n, 3 }, "float")
  core.array_fill(a, values)
  return a
end

--- The albedo of the n vertices of a mesh, float [n][3], of the material of an entry; or nil, message, code.
function pack.albedo(entry, mesh, n)
  local m = entry.material or material.default
  local varied, message, code = material.at_vertices("save", m, mesh)
  if varied or message then return varied, message, code end
  local one
  one, message, code = material.albedo("save", m)
  if not one then return nil, message, code end
  local list = {}
  for i = 1, n do list[i] = one end
  return floats(n, list)
end

--- The scene's geometry; returns { lowest, step } of its positions, the numbers of vertices and triangles, and the number of
-- glossy surfaces; nil where there is none; nil, message, code.
function pack.meshes(blob, scene)
  local lo, hi = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  local list, glossy = {}, 0
  for i, entry in ipairs(scene.geometry) do
    local mesh, message, code = geometry.plain(entry)
    if not mesh then return nil, message, code end
    list[i] = mesh
    if entry.material and material.glossy(entry.material) then glossy = glossy + 1 end
    local bounds = mesh.bounds
    for a = 1, 3 do lo[a], hi[a] = math.min(lo[a], bounds[1][a]), math.max(hi[a], bounds[2][a]) end
  end
  if #list == 0 then return nil end
  local step, zero, unit = {}, { 0, 0, 0 }, { 1 / 65535, 1 / 65535, 1 / 65535 }
  for a = 1, 3 do step[a] = (hi[a] - lo[a]) / 65535 end
  local positions, normals, albedos, triangles, vertices, faces = {}, {}, {}, {}, 0, 0
  for i, mesh in ipairs(list) do
    local points, from = mesh:vertices(), lo
    local n = #points
    if points.dtype == "double" then points, from = core.array_convert(points - lo, "float"), zero end -- far from 0
    local albedo, message, code = pack.albedo(scene.geometry[i], mesh, n)
    if not albedo then return nil, message, code end
    positions[i], normals[i] = core.page_positions(points, from, step), core.page_normals(mesh:normals())
    albedos[i] = core.page_positions(albedo, zero, unit)
    triangles[i] = core.page_triangles(mesh:triangles(), vertices)
    vertices, faces = vertices + n, faces + #mesh
  end
  blob.add("positions", "u16", { vertices, 3 }, table.concat(positions), true)
  blob.add("normals", "i16", { vertices, 2 }, table.concat(normals), true)
  blob.add("albedo", "u16", { vertices, 3 }, table.concat(albedos), true)
  blob.add("triangles", "u32", { faces, 3 }, table.concat(triangles), true)
  return { lowest = lo, step = step }, { vertices = vertices, triangles = faces, glossy = glossy }
end

return pack
