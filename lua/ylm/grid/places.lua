--- Places of a scene's surfaces, with the irradiance that a light has there: { bounds; open(points) -> 1 where a point is in no
-- body; irradiance(points, normals) -> [n][channels] }, each or nil, message, code.

local array = require "ylm.array"
local core = require "ylm.c.core"
local field = require "ylm.field"

local places = {}

local NEAR = 1e-3 -- of the grid: a surface that another is nearer to is not looked at
local AWAY = { 1, 4, 16 } -- times that
local TRIES, MOST = 6, 32 -- draws, and places that are drawn for each that is wanted
local BURIED = 4           -- flag of samples in bodies
local BOTH = "both"

--- Meshes of a scene by the sides of theirs that reflect: { sides, meshes }, sorted.
local function meshes_by_sides(scene)
  local groups, list = {}, {}
  for _, g in ipairs(scene.geometry) do
    local sides = g.sides or BOTH
    if not groups[sides] then
      groups[sides] = { sides = sides, meshes = {} }
      list[#list + 1] = groups[sides]
    end
    table.insert(groups[sides].meshes, g.mesh)
  end
  table.sort(list, function(a, b) return a.sides < b.sides end)
  return list
end

--- Signs of the sides of n places: 1 the front, -1 the back.
local function signs(sides, n)
  local list = {}
  for i = 1, n do list[i] = (sides == "back" or sides == BOTH and i % 2 == 0) and -1 or 1 end
  return array.array(list):reshape { n, 1 }
end

--- About n random places of the meshes within bounds, by area, and normals of the sides that reflect: arrays [m][3]. Or nil,
-- message, code.
local function draw(scene, bounds, n, seed)
  local lo, hi = bounds[1], bounds[2]
  local box, total, all, groups = { lo[1], lo[2], lo[3], hi[1], hi[2], hi[3] }, 0, 0, meshes_by_sides(scene)
  for _, d in ipairs(groups) do
    local points, normals, area = core.grid_surface_points(d.meshes, box, seed, 1)
    if not points and area ~= "EDOMAIN" then return nil, normals, area end
    d.area = points and (d.sides == BOTH and 2 * area or area) or 0
    total = total + d.area
  end
  for _, d in ipairs(groups) do
    d.n = total > 0 and math.floor(n * d.area / total + 0.5) or 0
    all = all + d.n
  end
  local points, normals, first = array.zeros({ all, 3 }), array.zeros({ all, 3 }), 1
  for _, d in ipairs(groups) do
    if d.n > 0 then
      local p, q, code = core.grid_surface_points(d.meshes, box, seed, d.n)
      if not p then return nil, q, code end
      local rows = { { first, first + d.n - 1 } }
      points[rows], normals[rows] = p, q * signs(d.sides, d.n)
      first = first + d.n
    end
  end
  return points, normals
end

--- 1 of places that have nothing before them for `far`, and lie in no body there. Or nil, message, code.
local function open_at(light, points, normals, walls, far)
  local clear, message, code = core.grid_clear(walls, points, normals, far)
  if not clear then return nil, message, code end
  local open
  open, message, code = light.open(points + normals * far)
  if not open then return nil, message, code end
  return clear * open
end

--- 1 of places that are seen: no other surface is near, and they are not in a body. A grid tells bodies by pieces of a quarter of
-- a voxel, so that what is near a wall may seem to be in it: some distances are tried. Or nil, message, code.
local function seen(light, points, normals, walls, near)
  local sum
  for _, times in ipairs(AWAY) do
    local open, message, code = open_at(light, points, normals, walls, near * times)
    if not open then return nil, message, code end
    sum = sum and sum + open or open
  end
  return sum:greater(0)
end

--- The luminance [n] of irradiance [n][channels].
function places.luminance(E)
  if E.shape[2] == 1 then return E:reshape { #E } end
  return (E * array.array(core.luminance, "float")):sum(2)
end

--- At most n places of the scene's surfaces by area within a light's bounds, and what it has there: { n; points, normals
-- [n][3]; wanted [n][channels]; light [n], its luminance; mean }. Or nil, message, code; `name` stands in messages.
function places.draw(name, light, scene, n, seed)
  local walls, message, code = field.walls_of_scene(2, name, scene)
  if not walls then return nil, message, code end
  local lo, hi = light.bounds[1], light.bounds[2]
  local near = NEAR * math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3])
  local wanted = n
  for _ = 1, TRIES do
    local points, normals, why = draw(scene, light.bounds, wanted, seed)
    if not points then return nil, normals, why end
    if #points == 0 then break end
    local open
    open, message, code = seen(light, points, normals, walls, near)
    if not open then return nil, message, code end
    local kept = open:sum()
    if kept >= n / 2 or wanted >= MOST * n then
      if kept == 0 then break end
      local p = { n = kept, points = points:select(open), normals = normals:select(open) }
      p.wanted, p.variance, code = light.irradiance(p.points, p.normals)
      if not p.wanted then return nil, p.variance, code end
      p.light = places.luminance(p.wanted)
      p.mean = p.light:mean()
      return p
    end
    wanted = 2 * wanted
  end
  return nil, name .. ": no surface of the scene lies within the bounds", "EDOMAIN"
end

--- 1 of points that lie in no body, by the pieces of a grid's voxels; array [n].
function places.unburied(g, points) return core.grid_flags(g, points, "float", 0):less(BURIED) end

--- A grid as such a light.
function places.of_grid(g, scene)
  return { bounds = g.bounds,
    open = function(points) return places.unburied(g, points) end,
    irradiance = function(points, normals)
      local E, message, code = g:irradiance(points, normals, { scene = g.sides and scene or nil })
      if not E then return nil, message, code end
      return E
    end }
end

--- The places where a mask is 1; nil where it is nowhere.
function places.some(all, mask)
  local n = mask:sum()
  if n == all.n then return all end
  if n == 0 then return nil end
  return { n = n, mean = all.mean, points = all.points:select(mask), normals = all.normals:select(mask),
    wanted = all.wanted:select(mask), light = all.light:select(mask) }
end

return places
