--- Colours of pictures, arrays [h][w][3].

local pixels = {}

--- The colour of the pixel that holds (x, y), from the left and the top.
function pixels.at(picture, x, y)
  local r, c = math.floor(y) + 1, math.floor(x) + 1
  return { picture:get(r, c, 1), picture:get(r, c, 2), picture:get(r, c, 3) }
end

--- The largest difference of two colours' channels.
function pixels.difference(a, b)
  return math.max(math.abs(a[1] - b[1]), math.abs(a[2] - b[2]), math.abs(a[3] - b[3]))
end

return pixels
