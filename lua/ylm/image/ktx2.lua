--- Textures as KTX 2.0: halves of red, green, blue and alpha.

local ktx2 = {}

local HEADER, INDEX = 80, 24 -- bytes of the header, and of an entry of the index of levels

--- Bytes of an unsigned integer, the least first.
local function little(x, bytes)
  local list = {}
  for i = 1, bytes do
    list[i] = string.char(x % 256)
    x = math.floor(x / 256)
  end
  return table.concat(list)
end

--- Khronos' basic descriptor: four halves, BT.709, linear, straight alpha.
local function descriptor()
  local samples = {}
  for i, channel in ipairs { 0, 1, 2, 15 } do                     -- signed floats from -1 to 1 and beyond
    samples[i] = little(16 * (i - 1), 2) .. string.char(15, channel + 0xC0) .. little(0, 4) .. little(0xBF800000, 4)
      .. little(0x3F800000, 4)
  end
  local block = little(0, 4) .. little(2, 2) .. little(24 + 16 * 4, 2) .. string.char(1, 1, 1, 0) .. little(0, 4)
    .. string.char(8, 0, 0, 0, 0, 0, 0, 0) .. table.concat(samples)
  return little(4 + #block, 4) .. block
end

--- Pairs of words, sorted by their first.
local function dictionary(pairs_of_words)
  local words = {}
  for i, pair in ipairs(pairs_of_words) do
    local text = pair[1] .. "\0" .. pair[2] .. "\0"
    words[i] = little(#text, 4) .. text .. ("\0"):rep(-#text % 4)
  end
  return table.concat(words)
end

--- The bytes of a file with one level of a texture. `data` is its texels, row 1 on top; depth 0: no volume; `pairs_of_words` are
-- sorted by key.
function ktx2.file(width, height, depth, data, pairs_of_words)
  local about, words = descriptor(), dictionary(pairs_of_words)
  local first = HEADER + INDEX
  local gap = -(first + #about + #words) % 8
  local at = first + #about + #words + gap
  return "\171KTX 20\187\r\n\26\n" .. little(97, 4) .. little(2, 4)   -- R16G16B16A16_SFLOAT, two bytes a number
    .. little(width, 4) .. little(height, 4) .. little(depth, 4) .. little(0, 4) .. little(1, 4) .. little(1, 4) .. little(0, 4)
    .. little(first, 4) .. little(#about, 4) .. little(first + #about, 4) .. little(#words, 4) .. little(0, 8)
    .. little(0, 8) .. little(at, 8) .. little(#data, 8) .. little(#data, 8) .. about .. words .. ("\0"):rep(gap) .. data
end

return ktx2
