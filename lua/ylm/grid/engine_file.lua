--- Probes as files of engines: ambient cubes in KTX2 (Bevy), three.js' atlas of probes in JSON.
--
-- A grid is { lattice: of ylm.grid.engine; probes [n][channels][numbers], x fastest; validity [n] }.

local array = require "ylm.array"
local core = require "ylm.c.core"
local sh = require "ylm.sh"

local files = {}

--- Bytes of an unsigned integer, the least first.
local function little(x, bytes)
  local list = {}
  for i = 1, bytes do
    list[i] = string.char(x % 256)
    x = math.floor(x / 256)
  end
  return table.concat(list)
end

local function halves(list) return array.array(list, "float16"):bytes() end

--- One level of a texture of halves, red green blue alpha, as KTX 2.0. `data` is its texels; `pairs` are sorted by key.
local function ktx2(width, height, depth, data, pairs_of_words)
  local samples = {}
  for i, channel in ipairs { 0, 1, 2, 15 } do                     -- signed floats from -1 to 1 and beyond
    samples[i] = little(16 * (i - 1), 2) .. string.char(15, channel + 0xC0) .. little(0, 4) .. little(0xBF800000, 4)
      .. little(0x3F800000, 4)
  end
  local block = little(0, 4) .. little(2, 2) .. little(24 + 16 * 4, 2)  -- Khronos' basic descriptor
    .. string.char(1, 1, 1, 0)                                    -- RGBA, BT.709, linear, straight alpha
    .. little(0, 4) .. string.char(8, 0, 0, 0, 0, 0, 0, 0) .. table.concat(samples)
  local descriptor = little(4 + #block, 4) .. block
  local words = {}
  for i, pair in ipairs(pairs_of_words) do
    local text = pair[1] .. "\0" .. pair[2] .. "\0"
    words[i] = little(#text, 4) .. text .. ("\0"):rep(-#text % 4)
  end
  words = table.concat(words)
  local first = 80 + 24                                           -- header and index, one level
  local gap = -(first + #descriptor + #words) % 8
  local at = first + #descriptor + #words + gap
  return "\171KTX 20\187\r\n\26\n" .. little(97, 4) .. little(2, 4)   -- R16G16B16A16_SFLOAT, two bytes a number
    .. little(width, 4) .. little(height, 4) .. little(depth, 4) .. little(0, 4) .. little(1, 4) .. little(1, 4) .. little(0, 4)
    .. little(first, 4) .. little(#descriptor, 4) .. little(first + #descriptor, 4) .. little(#words, 4) .. little(0, 8)
    .. little(0, 8) .. little(at, 8) .. little(#data, 8) .. little(#data, 8) .. descriptor .. words .. ("\0"):rep(gap) .. data
end

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
  return ktx2(cells[1], 2 * cells[2], 3 * cells[3], halves(list), {
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
