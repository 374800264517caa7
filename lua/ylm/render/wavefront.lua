--- Surfaces with texture coordinates as Wavefront OBJ text: lightmap:save "room.obj".

local check = require "ylm.check"
local core = require "ylm.c.core"
local text = require "ylm.text"

local wavefront = {}

--- Adds a line for each row of an array: its word and its numbers.
local function add_rows(lines, word, rows, width)
  for _, row in ipairs(rows:totable()) do
    for k = 1, width do row[k] = ("%.9g"):format(row[k]) end
    lines[#lines + 1] = word .. " " .. table.concat(row, " ", 1, width)
  end
end

--- The name of a piece as one word.
local function name_of(piece, number)
  local name = text.shown(piece.name or "piece " .. piece.number):gsub("%s", "_")
  return ("o %s_%d"):format(name, number)
end

--- Saves pieces { mesh, uvs, number, name }; true, or nil, message, code.
function wavefront.save(pieces, path)
  local lines, before = { "# ylm" }, 0
  for i, piece in ipairs(pieces) do
    lines[#lines + 1] = name_of(piece, i)
    add_rows(lines, "v", piece.mesh:vertices(), 3)
    add_rows(lines, "vt", piece.uvs, 2)
    add_rows(lines, "vn", piece.mesh:normals(), 3)
    for _, t in ipairs(piece.mesh:triangles():totable()) do
      local a, b, c = t[1] + before, t[2] + before, t[3] + before
      lines[#lines + 1] = ("f %d/%d/%d %d/%d/%d %d/%d/%d"):format(a, a, a, b, b, b, c, c, c)
    end
    before = before + #piece.uvs
  end
  lines[#lines + 1] = ""
  return check.result("save", core.file_save(path, table.concat(lines, "\n")))
end

return wavefront
