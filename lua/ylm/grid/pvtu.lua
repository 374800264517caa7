--- Grids in bricks as .pvtu files, for ParaView: .vtu files with a piece for each brick, of which every process of a team writes
-- its share, and one file that names them.

local check = require "ylm.check"
local core = require "ylm.c.core"
local vtu = require "ylm.grid.vtu"

local pvtu = {}

-- More bricks than these make another file: ParaView reads a file whole, on one of its processes.
local FILE_BRICKS = 64

--- The place of a voxel of a level among those of its level, as a word.
local function place(bounds, level, origin)
  local word = { level }
  for a = 1, 3 do
    word[a + 1] = math.floor((origin[a] - bounds[1][a]) / (bounds[2][a] - bounds[1][a]) * 2 ^ level + 0.5)
  end
  return table.concat(word, " ")
end

--- The place of the brick whose file has this name: its digits are octants from the root, x lowest.
local function place_of_file(path)
  local digits, at = path:match "([0-7]*)%.ylm$", { 0, 0, 0 }
  for digit in digits:gmatch "." do
    for a = 1, 3 do at[a] = 2 * at[a] + math.floor(tonumber(digit) / 2 ^ (a - 1)) % 2 end
  end
  return table.concat({ #digits, at[1], at[2], at[3] }, " "), digits
end

--- A function that says whether a leaf of the top is one of the bricks.
local function brick_at(set, n)
  local bounds, places = set.bounds, {}
  for i = 1, n do places[place_of_file(core.grid_set_file(set, i))] = true end
  return function(level, origin) return places[place(bounds, level, origin)] end
end

--- Adds one brick to a file of pieces; true, or nil, message, code.
local function add_piece(set, i, n, pieces, o)
  local grid, message, code = check.result("save", core.grid_read(core.grid_set_file(set, i)))
  if not grid then return nil, message, code end
  local ok
  ok, message, code = vtu.add(pieces, grid, o, i > n and brick_at(set, n) or nil)
  grid:close()
  return ok, message, code
end

--- The sections of a piece's header as the file that names pieces has them.
local function declared(head)
  local out = {}
  for _, section in ipairs { "PointData", "CellData", "Points" } do
    local body = head:match("<" .. section .. ">(.-)</" .. section .. ">") or ""
    out[#out + 1] = "<P" .. section .. ">"
    for tag in body:gmatch "<DataArray (.-) format=" do out[#out + 1] = "<PDataArray " .. tag .. "/>" end
    out[#out + 1] = "</P" .. section .. ">"
  end
  return table.concat(out, "\n")
end

--- Writes the file that names the pieces; true, or nil, message, code.
local function save_list(path, names)
  local file, why = io.open(names[1], "rb")
  if not file then return nil, tostring(why), "EIO" end
  local head = file:read(65536)
  file:close()
  local order = head:match 'byte_order="(%a+)"'
  local out = { '<?xml version="1.0"?>', ('<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="%s" '
    .. 'header_type="UInt64">'):format(order), '<PUnstructuredGrid GhostLevel="0">', declared(head) }
  for _, name in ipairs(names) do
    local source = name:match "[^/]*$":gsub("&", "&amp;"):gsub('"', "&quot;"):gsub("<", "&lt;")
    out[#out + 1] = ('<Piece Source="%s"/>'):format(source)
  end
  out[#out + 1] = "</PUnstructuredGrid>\n</VTKFile>\n"
  return core.file_save(path, table.concat(out, "\n"))
end

--- The files that `size` processes write pieces 1 .. n to: names; the first piece of each, then n + 1; files of a process.
local function divide(stem, n, size)
  local writers = math.min(size, n)
  local each = math.ceil(n / (writers * FILE_BRICKS))
  local names, first, count = {}, {}, writers * each
  for f = 1, count do
    names[f], first[f] = ("%s-%d-of-%d.vtu"):format(stem, f, count), math.floor((f - 1) * n / count) + 1
  end
  first[count + 1] = n + 1
  return names, first, each
end

--- Writes one file; true, or nil, message, code; false where another process has failed. ask(): whether none has. o: options of
-- vtu.
local function save_file(set, path, first, behind, ask, o)
  local pieces, message, code = check.result("save", core.figure_pieces(path, behind - first))
  if not pieces then return nil, message, code end
  for i = first, behind - 1 do
    local ok
    ok, message, code = ask()
    if ok then ok, message, code = add_piece(set, i, set.stats.bricks, pieces, o) end
    if not ok then
      core.figure_pieces_discard(pieces)
      return ok, message, code
    end
  end
  return check.result("save", core.figure_pieces_end(pieces))
end

--- Writes NAME.pvtu and NAME-K-of-N.vtu beside it; true, or nil, message, code. `handle`: the team's; o: options of
-- vtu.
function pvtu.save(set, path, handle, o)
  local n = set.stats.bricks + 1
  local rank, size = core.team_info(handle)
  local names, first, each = divide(path:gsub("%.[^.]*$", ""), n, size)
  -- A task is handed out for each piece. Its number means nothing: a process that gets none hears that another has failed.
  local job, ok, message, code = core.team_job(handle), true, nil, nil
  local function ask() return core.team_next(handle, job, n) end
  for f = (rank - 1) * each + 1, math.min(rank * each, #names) do
    ok, message, code = save_file(set, names[f], first[f], first[f + 1], ask, o)
    if not ok then break end
  end
  if ok == nil then core.team_stop(handle, job) end
  ok, message, code = core.team_agree(handle, ok == nil and code or nil, message)
  if not ok then return nil, message, code end
  ok, message, code = ask() -- none is left
  if ok == false and rank == 1 then ok, message, code = save_list(path, names) end
  return core.team_agree(handle, ok == nil and code or nil, message)
end

return pvtu
