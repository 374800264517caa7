--- Probes as files of engines: ambient cubes in KTX2 (Bevy), three.js' atlas of probes in JSON.
--
-- A grid is { lattice: of ylm.grid.engine; probes [n][channels][numbers], x fastest; validity [n] }.

local array = require "ylm.array"
local core = require "ylm.c.core"
local ktx2 = require "ylm.image.ktx2"
local sh = require "ylm.sh"

local files = {}

local function halves(list) return array.array(list, "float16"):bytes() end

local function numbers(list)
  local words = {}
  for i, x in ipairs(list) do words[i] = ("%.9g"):format(x) end
  return table.concat(words, ",")
end

--- Ambient cubes as Bevy reads them: (nx, 2 ny, 3 nz) texels; alpha is validity.
function files.cubes(grid)
  local rows, cells, validity, list = grid.probes:totable(), grid.lattice.cells, grid.validity, {}
  for axis = 1, 3 do
    for z = 1, cells[3] do
      for side = 0, 1 do                                          -- faces that look along the axis first
        for y = 1, cells[2] do
          for x = 1, cells[1] do
            local i = ((z - 1) * cells[2] + y - 1) * cells[1] + x
            for channel = 1, 3 do list[#list + 1] = (rows[i][channel] or rows[i][1])[axis + 3 * side] end
            list[#list + 1] = validity[i]
          end
        end
      end
    end
  end
  return ktx2.file(cells[1], 2 * cells[2], 3 * cells[3], halves(list), {
    { "KTXwriter", "ylm " .. (core.info()) },
    { "ylm.bounds", numbers(grid.lattice.lo) .. "," .. numbers(grid.lattice.hi) } })
end

--- The atlas of three.js' LightProbeGrid: seven volumes of four numbers above each other, each with a copy of its first and
-- last slice.
local function atlas(grid)
  local c, cells, validity = grid.probes, grid.lattice.cells, grid.validity
  if c.shape[2] == 1 then c = array.stack({ c, c, c }, 2):reshape { #c, 3, c.shape[3] } end
  local rows, list = sh.convert(c, "three.js"):totable(), {}
  for volume = 0, 6 do
    for slice = 0, cells[3] + 1 do
      local z = math.max(1, math.min(cells[3], slice))
      for y = 1, cells[2] do
        for x = 1, cells[1] do
          local row = rows[((z - 1) * cells[2] + y - 1) * cells[1] + x]
          for k = 4 * volume, 4 * volume + 3 do
            list[#list + 1] = k < 27 and row[math.floor(k / 3) + 1][k % 3 + 1] or 0
          end
        end
      end
    end
  end
  local bytes = {}
  for i = 1, #validity do bytes[i] = string.char(math.floor(255 * math.max(0, math.min(1, validity[i])) + 0.5)) end
  return ('{"type":"LightProbeGrid","generator":"ylm %s","convention":"three.js","min":[%s],"max":[%s],'
    .. '"resolution":[%s],"atlas":{"width":%d,"height":%d,"depth":%d,"format":"RGBA","numbers":"half","data":"%s"},'
    .. '"validity":"%s"}'):format((core.info()), numbers(grid.lattice.lo), numbers(grid.lattice.hi), numbers(cells), cells[1],
    cells[2], 7 * (cells[3] + 2), core.page_base64(halves(list)), core.page_base64(table.concat(bytes)))
end

--- One grid of three.js as it is, several as a list.
function files.three(grids)
  local list = {}
  for k, grid in ipairs(grids) do list[k] = atlas(grid) end
  return #list == 1 and list[1] .. "\n" or '{"type":"LightProbeGrids","grids":[' .. table.concat(list, ",\n") .. "]}\n"
end

return files
