--- Boxes {lo, hi}, each corner {x, y, z}.

local box = {}

--- The length of a box's diagonal.
function box.diagonal(lo, hi)
  local d = 0
  for i = 1, 3 do d = d + (hi[i] - lo[i]) ^ 2 end
  return math.sqrt(d)
end

--- The box of geometry, a little larger, so that no rounded point is outside and none is flat.
function box.padded(lo, hi)
  local pad, from, to = 1e-4 * box.diagonal(lo, hi), {}, {}
  if pad == 0 then pad = 1 end
  for i = 1, 3 do from[i], to[i] = lo[i] - pad, hi[i] + pad end
  return { from, to }
end

return box
