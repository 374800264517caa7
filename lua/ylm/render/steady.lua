--- Light that bounces, as pictures by halves of rays have it: along links it has noise, from grids it is steady.

local steady = {}

--- The way of light that bounces along links in a picture by o; nil: there is none.
function steady.links(o) return o.reflected and o.reflected.record.name == "links" and o.reflected or nil end

--- Light that bounces from a grid, at the points of a view p; false: there is none. Or nil, message, code.
function steady.light(name, p, o)
  if not o.reflected or steady.links(o) then return false end
  return o.reflected.record.radiance(name, p, o)
end

--- As steady.light at points that are not the picture's: what is noted of the picture stays.
function steady.elsewhere(name, p, o)
  local own, b = {}, {}
  for key, value in pairs(o) do own[key] = value end
  for key, value in pairs(o.reflected or {}) do b[key] = value end
  own.reflected = o.reflected and b
  return steady.light(name, p, own)
end

return steady
