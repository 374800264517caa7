-- A grid in bricks, its bricks visible: a knot over a floor, one colour for each brick, and the light that the bricks hold there.
--
--     ylm run examples/cluster/bricks_picture.lua [--out out] [--quick]

local core = require "ylm.c.core"
local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")
local option = common.options { out = "out", quick = false }
local folder = option.out .. "bricks_picture.ylmd"

local at, radiance = common.spiral(300, 0.13, 0.08, 0.03, 9, 6)
local lamps = ylm.sphere_lights { at = at, radius = 0.03, radiance = radiance }
local fine = option.quick and 32 or 256
local low, edge = { -2.5, -0.05, -2.5 }, 5
local floor = ylm.quad { corner = { -2.4, 0, 2.4 }, u = { 4.8, 0, 0 }, v = { 0, 0, -4.8 }, divide = fine }
local knot = ylm.knot { at = { 0, 1.3, 0 }, radius = 0.75, tube = 0.22, divide = { 4 * fine, fine } }

local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { low, { low[1] + edge, low[2] + edge, low[3] + edge } }, lmax = 4,
  depth = option.quick and 5 or 6, tolerance = 0.05, bricks = 2 }, lamps,
  { geometry = { floor, knot }, folder = folder, fresh = true, brick_points = option.quick and 512 or 1024 }))
local stats = grid.stats
print(("%d points in %d bricks"):format(stats.points, stats.bricks))

-- Colours ------------------------------------------------------------------------------------

--- Bricks by their names, the octants from the root.
local bricks = {}
for i = 1, stats.bricks do bricks[core.grid_set_file(grid, i):match "([0-7]+)%.ylm$"] = i end

--- The brick of a point; nil: a voxel above the bricks holds it.
local function brick_of(p)
  local name = ""
  for level = 1, grid.depth do
    local octant = 0
    for a = 1, 3 do octant = octant + 2 ^ (a - 1) * (math.floor((p[a] - low[a]) / edge * 2 ^ level) % 2) end
    name = name .. ("%d"):format(octant)
    if bricks[name] then return bricks[name] end
  end
end

--- A colour for each number, neighbours unlike.
local function colour(i)
  if not i then return { 0.35, 0.35, 0.35 } end
  local hue, light = 2 * math.pi * 0.618 * i, 0.45 + 0.12 * (i % 3)
  return { light + 0.3 * math.cos(hue), light + 0.3 * math.cos(hue - 2.1), light + 0.3 * math.cos(hue - 4.2) }
end

local function by_brick(mesh)
  local list = {}
  for i, p in ipairs(mesh:vertices():totable()) do list[i] = colour(brick_of(p)) end
  return list
end

--- The mean radiance at vertices, from the bricks.
local function by_light(mesh)
  local list = {}
  for i, c in ipairs(grid:sample(mesh:vertices())[{ {}, {}, 1 }]:totable()) do
    for k = 1, 3 do
      local x = math.max(0, 0.9 * c[k])
      c[k] = (x / (1 + x)) ^ (1 / 2.2)
    end
    list[i] = c
  end
  return list
end

-- Pictures ----------------------------------------------------------------------------------

assert(grid:save(folder .. "/all.ylm"))
local whole = assert(ylm.load(folder .. "/all.ylm"))
local camera = ylm.camera { from = { 4.1, 3.9, 5.2 }, at = { 0, 0.35, 0.1 }, fov = 45 }
local function view(of, subject, levels)
  return assert(ylm.view { subject = subject, quantity = subject and "level", levels = levels, bar = false, frame = false,
    camera = camera, size = option.quick and { 320, 240 } or { 640, 480 },
    meshes = { { floor, colours = of(floor.mesh) }, { knot, colours = of(knot.mesh) } } }:pixels())
end
common.save(ylm.figure { rows = { {
  { image = view(by_brick, whole, { occupied = true, opacity = 0.3 }),
    caption = ("%d bricks, and the voxels of the octree"):format(stats.bricks) },
  { image = view(by_light), caption = "mean radiance, sampled from the bricks" },
} } }, option.out .. "bricks.png")
grid:close()
os.execute("rm -r '" .. folder .. "'")
