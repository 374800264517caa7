--- Lights for specs, the same under every Lua.

local ylm = require "ylm"
local random = require "spec.support.random"

local lights = {}

--- n small coloured lights in a cube of that edge, some of them negative, as one object; every `dark`th of radius 0.
function lights.random(n, edge, seed, dark)
  local next, radii, colours = random.spread(seed + 1000), {}, {}
  for i = 1, n do
    radii[i] = dark and i % dark == 0 and 0 or 0.01 + 0.04 * next()
    colours[i] = { next(), next(), next() - 0.1 }
  end
  return ylm.sphere_lights { at = random.points(n, edge, seed), radius = radii, radiance = colours }
end

--- Lone lights at d/r from 1.001 to 1e4, numbers exact in float: { x, lamp, closeness = d / (d - r), ratio = d / r }.
function lights.lone(seed)
  local next, cases = random.spread(seed), {}
  local function exact(x) return math.floor(x * 1048576) / 1048576 end
  for _, ratio in ipairs { 1.001, 1.01, 1.1, 2, 10, 100, 1e4 } do
    local at = { exact(next()), exact(next()), exact(next()) }
    local x = { exact(2 + next()), exact(next() - 2), exact(next()) }
    local d = math.sqrt((x[1] - at[1]) ^ 2 + (x[2] - at[2]) ^ 2 + (x[3] - at[3]) ^ 2)
    local r = exact(d / ratio)
    cases[#cases + 1] = { x = x, closeness = d / (d - r), ratio = ratio,
      lamp = ylm.sphere_light { at = at, radius = r, radiance = 1 } }
  end
  return cases
end

return lights
