-- The gathered field on two scenes, a furnished room and an open yard: how well grids of it interpolate at equal rays.
-- Gradients are by the borders of cells, by hit points less the mean light, or there are none. Then a grid that
-- refines itself beside a uniform one of as many rays, both judged by a field of many rays.
--
--     build/ylm run spec/bench/gathered.lua

local ylm = require "ylm"

local LMAX, LEVELS_OF_RAYS, EDGES, SEEDS, TRUTH = 4, { 768, 3072 }, { 0.8, 0.4, 0.2 }, 3, 27648

local function matte(r, g, b) return ylm.matte { albedo = { r, g or r, b or r } } end

local function block(x, y, z, w, h, d, material)
  return ylm.box { at = { x, y + h / 2, z }, scale = { w, h, d }, material = material }
end

--- A table with four legs.
local function table_at(list, x, z, w, h, d, material)
  list[#list + 1] = block(x, h - 0.04, z, w, 0.04, d, material)
  for _, i in ipairs { -1, 1 } do
    for _, k in ipairs { -1, 1 } do
      list[#list + 1] = block(x + i * (w / 2 - 0.04), 0, z + k * (d / 2 - 0.04), 0.05, h - 0.04, 0.05, material)
    end
  end
end

--- 5 x 2.6 x 4: a table with chairs, a shelf with books, a sofa, a lamp under the ceiling and one beside the sofa.
local function room()
  local wood, white, red, dark = matte(0.5, 0.33, 0.18), matte(0.75, 0.73, 0.7), matte(0.6, 0.12, 0.1), matte(0.2, 0.22, 0.28)
  local list = { ylm.box { at = { 0, 1.3, 0 }, scale = { 5, 2.6, 4 }, sides = "back", material = white } }
  table_at(list, 0.9, 0.3, 1.4, 0.75, 0.8, wood)
  for _, x in ipairs { 0.5, 1.3 } do
    for _, z in ipairs { -0.35, 0.95 } do
      table_at(list, x, z, 0.42, 0.45, 0.42, wood)
      list[#list + 1] = block(x, 0.45, z + (z > 0 and 0.19 or -0.19), 0.42, 0.5, 0.04, wood)
    end
  end
  for i = 0, 4 do list[#list + 1] = block(-1, 0.35 + 0.4 * i, -1.82, 1.6, 0.03, 0.3, wood) end
  for _, x in ipairs { -1.8, -0.2 } do list[#list + 1] = block(x, 0, -1.82, 0.03, 2, 0.3, wood) end
  for i = 0, 23 do
    list[#list + 1] = block(-1.7 + 0.25 * (i % 6), 0.38 + 0.4 * math.floor(i / 6), -1.82, 0.08 + 0.02 * (i % 3),
      0.22 + 0.03 * (i % 4), 0.2, i % 3 == 0 and red or i % 3 == 1 and dark or wood)
  end
  list[#list + 1] = block(-1.9, 0, 0.5, 0.8, 0.42, 1.8, red)
  list[#list + 1] = block(-2.25, 0.42, 0.5, 0.15, 0.4, 1.8, red)
  return ylm.scene "a furnished room" { geometry = list, lights = {
    ylm.sphere_light { at = { 0.9, 2.1, 0.3 }, radius = 0.12, radiance = { 60, 52, 40 } },
    ylm.sphere_light { at = { -2.1, 1.3, 1.7 }, radius = 0.1, radiance = { 40, 26, 14 } },
  } }, { { -1.3, 1, -1.4 }, { 0.3, 1.8, 1 } }
end

--- Ground, a house, walls, a row of pillars and a bush of balls, under sky and sun.
local function yard()
  local grass, stone, brick, leaf = matte(0.2, 0.3, 0.1), matte(0.6, 0.58, 0.5), matte(0.55, 0.25, 0.18), matte(0.12, 0.32, 0.08)
  local list = { ylm.quad { corner = { -8, 0, 8 }, u = { 16, 0, 0 }, v = { 0, 0, -16 }, material = grass, sides = "front" },
    block(0, 0, -4.2, 8, 3.5, 1, brick), block(-4, 0, 0, 0.25, 1.8, 8, stone), block(4, 0, -1, 0.25, 1.2, 6, stone),
    block(1.6, 0, 1.8, 1.2, 0.45, 0.4, stone) }
  for i = 0, 4 do list[#list + 1] = block(-2.8 + 1.4 * i, 0, -2.2, 0.28, 2.4, 0.28, stone) end
  list[#list + 1] = block(0, 2.4, -2.9, 6.4, 0.15, 1.8, stone)
  for i = 0, 15 do
    list[#list + 1] = ylm.sphere { at = { -2.2 + 0.35 * math.sin(5 * i), 0.3 + 0.06 * i, 1.4 + 0.35 * math.cos(3 * i) },
      radius = 0.22, divide = { 16, 8 }, material = leaf }
  end
  return ylm.scene "an open yard" { geometry = list, lights = {
    ylm.environment_light { radiance = { 0.5, 0.7, 1 } },
    ylm.sun_light { direction = { 0.6, 1, 0.5 }, angle = 2, irradiance = { 9, 8.4, 7 } },
  } }, { { -1.8, 0.6, -1.6 }, { 1.8, 2.2, 2 } }
end

--- The numbers of an array as a list of doubles.
local function flat(a)
  local n = 1
  for _, extent in ipairs(a.shape) do n = n * extent end
  return ylm.array(a, "double"):reshape { n }
end

--- The root of the mean over points of squared errors, over that of the truth's norms.
local function apart(a, b) return math.sqrt(((a - b) ^ 2):sum() / (b ^ 2):sum()) end

local function random_points(box, n, seed)
  local state, points = seed, {}
  local function random()
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
  for i = 1, n do
    points[i] = {}
    for a = 1, 3 do points[i][a] = box[1][a] + (box[2][a] - box[1][a]) * random() end
  end
  return points
end

--- One voxel about a point, and places in it that do not lie in bodies.
local function errors(lit, truth, at, edge, rays, seed)
  local low, high = {}, {}
  for a = 1, 3 do low[a], high[a] = at[a] - edge / 2, at[a] + edge / 2 end
  local points, sums = random_points({ low, high }, 6, 1000 * seed + 7), {}
  local right = flat(ylm.light_field(LMAX, truth, points))
  for _, by in ipairs { "cells", "points" } do
    local field = lit:field { rays = rays, derivatives = by }
    local grid = assert(ylm.bake(ylm.uniform_grid { bounds = { low, high }, cells = 1, lmax = LMAX, bias = 0 }, field))
    if grid.stats.invalid > 0 then return nil end
    sums[by] = apart(flat((grid:sample(points))), right)
    sums.linear = apart(flat((grid:sample(points, { interpolation = "linear" }))), right)
    sums.rays = field.stats.rays / field.stats.points
    field:close()
  end
  return sums
end

local function mean_square(list)
  local sum = 0
  for _, x in ipairs(list) do sum = sum + x * x end
  return math.sqrt(sum / #list)
end

--- The largest error of 99 % of the points, relative to the light there.
local function quantile(a, b, width)
  local list = {}
  for i = 1, #b / width do
    local d, n = 0, 0
    for k = (i - 1) * width + 1, i * width do d, n = d + (a[k] - b[k]) ^ 2, n + b[k] ^ 2 end
    list[i] = math.sqrt(d / n)
  end
  table.sort(list)
  return list[math.ceil(0.99 * #list)]
end

--- An adaptive grid to 0.03 and a uniform one of about as many points, by the same field, at points that neither has seen.
local function compare_grids(lit, truth, box)
  local occupied, held = random_points(box, 2000, 11), random_points(box, 400, 97)
  local o = { occupied = occupied }
  local ok, grid = pcall(ylm.bake, ylm.adaptive_grid { bounds = box, lmax = 2, depth = 6, tolerance = 0.03 }, lit, o)
  if not ok then return print("  adaptive grid: " .. tostring(grid)) end
  local s, cells = grid.stats, {}
  local step = ((box[2][1] - box[1][1]) * (box[2][2] - box[1][2]) * (box[2][3] - box[1][3]) / s.points) ^ (1 / 3)
  for a = 1, 3 do cells[a] = math.max(1, math.floor((box[2][a] - box[1][a]) / step + 0.5)) end
  local uniform = ylm.bake(ylm.uniform_grid { bounds = box, lmax = 2, cells = cells }, lit:field { rays = 6912 })
  local right = flat(ylm.light_field(2, truth, held))
  local fine, coarse = flat((grid:sample(held))), flat((uniform:sample(held)))
  print(("  adaptive grid, tolerance 0.03, lmax 2: %d points, met %s, by its own check %.4f; by a field of %d rays at %d other "
    .. "points 99 %% within %.4f"):format(s.points, tostring(s.met), s.error, TRUTH, #held, quantile(fine, right, 27)))
  print(("  uniform grid, %d points: 99 %% within %.4f; relative errors %.5f and %.5f: the adaptive one is better by %.1f dB")
    :format(uniform.stats.points, quantile(coarse, right, 27), apart(fine, right), apart(coarse, right),
    20 * math.log(apart(coarse, right) / apart(fine, right)) / math.log(10)))
end

for _, make in ipairs { room, yard } do
  local scene, box = make()
  local t = assert(scene:links { spacing = 0.06, rays = 128 })
  local lit = t:radiosity()
  local truth = lit:field { rays = TRUTH, contrast = 0.1 }
  print(("%s: %d elements; error of interpolated coefficients, lmax %d, beside a field of %d rays"):format(scene.name,
    t.stats.elements, LMAX, TRUTH))
  print(("  %6s  %6s  %9s  %9s  %9s  %s"):format("edge", "rays", "cells", "points", "linear", "cells are better than points by"))
  for _, edge in ipairs(EDGES) do
    for _, rays in ipairs(LEVELS_OF_RAYS) do
      local all = { cells = {}, points = {}, linear = {}, rays = {} }
      for seed = 1, SEEDS do
        for _, at in ipairs(random_points(box, 8, 31 * seed)) do
          local e = errors(lit, truth, at, edge, rays, seed)
          for key, list in pairs(all) do list[#list + 1] = e and e[key] end
        end
      end
      local cells, points = mean_square(all.cells), mean_square(all.points)
      print(("  %6.1f  %6.0f  %9.4f  %9.4f  %9.4f  %5.1f %%  (%d voxels)"):format(edge, mean_square(all.rays), cells, points,
        mean_square(all.linear), 100 * (1 - cells / points), #all.cells))
    end
  end
  local noise = lit:field({ rays = 3072 }):noise { points = random_points(box, 64, 5), lmax = LMAX }
  print(("  noise at 3072: %.4f"):format(noise))
  compare_grids(lit, truth, box)
end
