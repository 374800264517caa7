--- Grids in bricks as .pvtu files, for ParaView: a .vtu for each brick, shared among the processes of a team, and one file that
-- names them.

local check = require "ylm.check"
local core = require "ylm.c.core"
local vtu = require "ylm.grid.vtu"

local pvtu = {}

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

--- Writes one piece; true, or nil, message, code.
local function save_piece(set, i, n, path)
  local file = core.grid_set_file(set, i)
  local grid, message, code = check.result("save", core.grid_read(file))
  if not grid then return nil, message, code end
  local ok
  ok, message, code = vtu.save(grid, path, i > n and brick_at(set, n) or nil)
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
local function save_list(path, names, first)
  local file, why = io.open(first, "rb")
  if not file then return nil, tostring(why), "EIO" end
  local head = file:read(65536)
  file:close()
  local order = head:match 'byte_order="(%a+)"'
  local out = { '<?xml version="1.0"?>', ('<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="%s" '
    .. 'header_type="UInt64">'):format(order), '<PUnstructuredGrid GhostLevel="0">', declared(head) }
  for _, name in ipairs(names) do
    out[#out + 1] = ('<Piece Source="%s"/>'):format((name:gsub("&", "&amp;"):gsub('"', "&quot;"):gsub("<", "&lt;")))
  end
  out[#out + 1] = "</PUnstructuredGrid>\n</VTKFile>\n"
  return core.file_save(path, table.concat(out, "\n"))
end

--- Writes NAME.pvtu and NAME-CODE.vtu beside it; true, or nil, message, code. `handle`: the team's.
function pvtu.save(set, path, handle)
  local n, stem, names = set.stats.bricks, path:gsub("%.[^.]*$", ""), {}
  local function piece(i)
    local _, digits = place_of_file(core.grid_set_file(set, i))
    return ("%s-%s.vtu"):format(stem, i > n and "top" or digits)
  end
  for i = 1, n + 1 do names[i] = piece(i):match "[^/]*$" end
  local job, ok, message, code = core.team_job(handle), true, nil, nil
  while ok do
    local i
    i, message, code = core.team_next(handle, job, n + 1)
    if i == false then break end
    ok = i
    if i then ok, message, code = save_piece(set, i, n, piece(i)) end
    if not ok then core.team_stop(handle, job) end
  end
  ok, message, code = core.team_agree(handle, not ok and code or nil, message)
  if not ok then return nil, message, code end
  if core.team_info(handle) == 1 then ok, message, code = save_list(path, names, piece(n + 1)) end
  return core.team_agree(handle, not ok and code or nil, message)
end

return pvtu
