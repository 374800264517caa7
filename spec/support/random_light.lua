--- Light and harmonics of random settings by the kernels of this process. It prints, for each result, how many numbers it has,
-- how far off they may be, and the numbers over the largest of them. spec/kernels_spec.lua compares those of all kernel sets:
-- it writes a line `local SEED = 1` before this.

local unpack = table.unpack or unpack -- luacheck: ignore
local generators = require "spec.support.random"
local ylm = require "ylm"

local random = generators.minimal(SEED * 7919 + 13) -- luacheck: ignore 113
local function integer(a, b) return a + math.floor(random() * (b - a + 1)) end
local function one_of(list) return list[integer(1, #list)] end
local function times(n, f) local list = {} for i = 1, n do list[i] = f() end return list end

local function places(n, radius) return generators.around(random, n, 0, radius) end
local function place(distance) return generators.around(random, 1, distance, distance)[1] end
local function direction() return place(1) end

local function flat(t, out)
  for _, x in ipairs(t) do if type(x) == "table" then flat(x, out) else out[#out + 1] = x end end
  return out
end

local function show(bound, ...)
  for k = 1, select("#", ...) do
    local array = select(k, ...)
    if type(array) == "userdata" then
      local list, most = flat(array:totable(), {}), 0
      for _, x in ipairs(list) do most = math.max(most, math.abs(x)) end
      io.write(#list, " ", bound)
      for _, x in ipairs(list) do io.write((" %.12g"):format(most > 0 and x / most or x)) end
      io.write "\n"
    end
  end
end

local kinds = {
  function(at)
    return ylm.sphere_light { at = at, radius = 0.05 + 0.3 * random(), radiance = { random(), random(), random() } }
  end,
  function(at) return ylm.disk_light { at = at, normal = direction(), radius = 0.1 + 0.4 * random(), radiance = random() } end,
  function(at)
    return ylm.polygon_light { vertices = { at, { at[1] + 0.4, at[2], at[3] }, { at[1], at[2] + 0.3, at[3] + 0.1 } } }
  end,
}
local function lights(n, highest)
  return times(n, function() return kinds[integer(1, highest)](place(2.2 + random())) end)
end

local BOUND = { float = 5e-6, double = 1e-10 }

local function harmonics()
  local t = one_of { "float", "double" }
  show(BOUND[t], ylm.sh.eval(integer(0, 22), ylm.array(places(integer(1, 37), 2), t),
    { derivatives = integer(0, 2), solid = random() < 0.3 }))
end

local function sums(highest)
  local t = one_of { "float", "double" }
  show(BOUND[t], ylm.light_field(integer(0, highest > 1 and 9 or 14), lights(integer(1, highest > 1 and 5 or 40), highest),
    ylm.array(places(integer(1, 19), 1), t), { derivatives = integer(0, 2) }))
end

local function virtual()
  local n = one_of { 1, 3, 17, 60 }
  local set = ylm.virtual_lights { at = times(n, function() return place(1.5 + 2 * random()) end), normal = times(n, direction),
    radius = 0.05 + 0.2 * random(), profile = one_of { "gauss", "cap", "point" },
    intensity = times(n, function() return { random(), random(), random() } end) }
  show(BOUND.float, ylm.light_field(integer(0, 9), set, places(integer(1, 19), 1), { derivatives = integer(0, 1) }))
end

local function bodies()
  local casters = times(integer(1, 4), function()
    return ylm.caster { hides = ylm.occluder { radius = 0.1 + 0.2 * random() }, at = place(1.4) }
  end)
  casters[#casters + 1] = ylm.sphere_casters { at = times(3, function() return place(1.5) end), radius = { 0.1, 0.2, 0.15 } }
  show(2e-5, ylm.light_field(integer(1, 6), ylm.shadowed { lights = lights(integer(1, 5), 3), casters = casters },
    ylm.array(places(integer(1, 19), 0.8), one_of { "float", "double" })))
end

local function grids()
  local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = integer(1, 3), lmax = integer(0, 9),
    channels = one_of { "rgb", "luminance" } }, lights(integer(1, 9), 1))
  for _, n in ipairs { 1, 2, 3, 4, 5, 7, 23 } do
    show(BOUND.float, grid:sample(places(n, 0.99), { interpolation = one_of { "hermite", "taylor", "linear" },
      derivatives = integer(0, 1), dtype = one_of { "float", "double" } }))
  end
  local at, normals = places(9, 0.99), times(9, direction)
  for i = 1, 9 do -- one of both sides faces a lamp: the largest number is no remainder of others
    local x, y, z = unpack(normals[i])
    at[9 + i], normals[9 + i] = at[i], { -x, -y, -z }
  end
  show(BOUND.float, grid:irradiance(at, normals))
end

for _ = 1, 5 do
  harmonics()
  sums(1)
  sums(3)
  virtual()
  bodies()
  grids()
end
