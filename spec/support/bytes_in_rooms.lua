--- The indirect light of two rooms and a door in few bytes beside regular lattices, judged by paths, for spec/bench/bytes.lua.

local lattices = require "spec.support.regular_lattices"
local places = require "spec.support.surface_places"
local ylm = require "ylm"

local PLACES, SAMPLES, RAYS, SEED = 1000, 16384, 1728, 1

local function scene_of(name)
  for _, entry in ipairs(require "spec.support.bounce_scenes") do if entry.name == name then return entry.make(ylm) end end
end

--- Of each place the largest error of a channel, over the larger of the light there and the mean light; the 99 % quantile.
local function quantile(E, truth)
  local mean, list = { 0, 0, 0 }, {}
  for _, e in ipairs(truth) do for c = 1, 3 do mean[c] = mean[c] + e[c] / #truth end end
  for i, e in ipairs(truth) do
    list[i] = 0
    for c = 1, 3 do list[i] = math.max(list[i], math.abs(E[i][c] - e[c]) / math.max(e[c], mean[c])) end
  end
  table.sort(list)
  return list[math.ceil(0.99 * #list)]
end

--- Irradiance by paths at places, and the 99 % quantile of its noise: that of two halves' distance, over 2.
local function paths(scene, points, normals)
  local halves, E = {}, {}
  for h = 1, 2 do
    local e = assert(scene:probe { points = points, normals = normals, samples = SAMPLES / 2, reflections = { 1, "all" },
      progress = false, seed = 100 * SEED + h })
    halves[h] = {}
    for i = 1, #points do halves[h][i] = { e:get(i, 1), e:get(i, 2), e:get(i, 3) } end
  end
  for i = 1, #points do
    E[i] = {}
    for c = 1, 3 do E[i][c] = (halves[1][i][c] + halves[2][i][c]) / 2 end
  end
  return E, quantile(halves[1], halves[2]) / 2
end

return function()
  ylm.on_warning(false)
  local scene = scene_of "two rooms and a door"
  local lit = assert(assert(scene:links { rays = 256, seed = SEED }):radiosity(nil, { light_samples = 64, seed = SEED }))
  local field = assert(lit:field { rays = RAYS, quantity = "indirect" })
  local points, normals = places.draw(scene, assert(lit:field { rays = RAYS, quantity = "indirect" }), PLACES, SEED)
  local truth, noise = paths(scene, points, normals)
  print(("two rooms and a door, indirect light, L2, RGB: bytes, and the error of irradiance that 99 %% of %d places keep against "
    .. "%d paths each, whose own noise is %.3f"):format(PLACES, SAMPLES, noise))
  local function row(name, bytes, E)
    print(("  %-58s %9d  %.3f"):format(name, bytes, quantile(E, truth)))
    io.stdout:flush()
  end
  local function by(value)
    return lattices.irradiance(function(i, c, k) return value:get(i, c, k) end, normals)
  end
  print(("  %-58s %9s  %.3f"):format(("the field itself, %d rays"):format(RAYS), "", quantile(by(assert(ylm.light_field(2, field,
    points))), truth)))
  local path = os.tmpname() .. ".ylm"
  for _, one in ipairs { { "few bytes, tolerance 0.1, step 0.02", ylm.adaptive_grid { lmax = 2, tolerance = 0.1 }, 0.02 },
    { "few bytes, tolerance 0.1, step 0.05", ylm.adaptive_grid { lmax = 2, tolerance = 0.1 }, 0.05 } } do
    local grid = assert(ylm.bake(one[2], field, { geometry = scene.geometry, occupied = "surfaces", progress = false }))
    local _, report = assert(grid:save(path, { step = one[3] }))
    local read = assert(ylm.load(path))
    row(("%s (%d points with sides)"):format(one[1], grid.stats.points), report.bytes,
      by(assert(read:sample(points, read.sides and { normals = normals } or nil))))
    read:close()
    grid:close()
  end
  os.remove(path)
  local box = places.box_of(scene)
  for _, spacing in ipairs { 0.25, 0.18, 0.12 } do
    local lattice = lattices.of(field, box, spacing)
    for _, layout in ipairs(lattices.layouts) do
      row(("regular, spacing %.2f (%d points), %s"):format(spacing, #lattice.rows, layout[1]), #lattice.rows * layout[2],
        lattices.look(lattice, layout, points, normals))
    end
  end
end
