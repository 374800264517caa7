-- Seams of '.ylmp': how much light jumps on surfaces where the leaf changes, in the scenes of spec/bench/rivals.
--
--     make bench BENCH=seams      build/ylm run spec/bench/seams.lua [scene: a pattern] [folder]
--
-- Places of surfaces within a tenth of a leaf of one of its faces are moved onto that face along the surface, and read on both of
-- its sides, a thousandth of the leaf apart. A jump is relative to the larger of the light there and the mean. Grids are those
-- that BENCH=rivals leaves in the folder, or are baked.

local places = require "ylm.grid.places"
local probe_reader = require "spec.support.probe_reader"
local ylm = require "ylm"

local pattern, folder = arg[1] or "", arg[2] or "out/rivals"
local TOLERANCE, BYTES, PLACES = 0.1, 14000, 4000
local NEAR, APART, ALONG = 0.1, 0.001, 0.02 -- of a leaf, and of a normal

ylm.on_warning(false)
os.execute("mkdir -p '" .. folder:gsub("'", "'\\''") .. "'")

local function luminance(E) return 0.2126 * E[1] + 0.7152 * E[2] + 0.0722 * E[3] end

local function quantiles(list)
  table.sort(list)
  if #list == 0 then return "none" end
  return ("%d: median %.2f %%, 90 %% %.2f %%, 99 %% %.2f %%"):format(#list, 100 * list[math.ceil(0.5 * #list)],
    100 * list[math.ceil(0.9 * #list)], 100 * list[math.ceil(0.99 * #list)])
end

--- Adds jumps around a place to the lists of equal leaves and of leaves of other sizes.
local function look_around(look, grid, p, n, mean, equal, other)
  local _, here = look(p, n)
  for a = 1, 3 do
    local t = (here.at[a] - here.low[a]) / here.edge
    local way = t < NEAR and -1 or t > 1 - NEAR and 1
    if way and math.abs(n[a]) < ALONG then
      local unit = here.edge * (grid.bounds[2][a] - grid.bounds[1][a]) / here.roots[a]
      local inner, outer = { p[1], p[2], p[3] }, { p[1], p[2], p[3] }
      local face = p[a] + ((way > 0 and 1 or 0) - t) * unit
      inner[a], outer[a] = face - way * APART / 2 * unit, face + way * APART / 2 * unit
      local E, within = look(inner, n)
      local F, beyond = look(outer, n)
      if within.cell == here.cell and beyond.cell ~= here.cell then
        E, F = luminance(E), luminance(F)
        table.insert(within.edge == beyond.edge and equal or other, math.abs(E - F) / math.max(E, F, mean))
      end
    end
  end
end

for _, entry in ipairs(require "spec.bench.rivals.scenes") do
  if entry.name:find(pattern) then
    local scene, path = entry.make(ylm), folder .. "/" .. entry.name .. ".ylm"
    local grid = ylm.load(path) or assert(scene:bake { quantity = entry.quantity, progress = false,
      probes = ylm.adaptive_grid { lmax = 2, tolerance = TOLERANCE, bounds = entry.box } })
    local name = os.tmpname()
    local report = assert(grid:export(name .. ".ylmp", { scene = scene, bytes = BYTES }))
    local file = assert(io.open(name .. ".ylmp", "rb"))
    local look = probe_reader.of(file:read "*a")
    file:close()
    os.remove(name .. ".ylmp")
    os.remove(name)
    local drawn = assert(places.draw("seams", places.of_grid(grid, scene), scene, PLACES, 77))
    local at, normals, equal, other = drawn.points:totable(), drawn.normals:totable(), {}, {}
    for i = 1, drawn.n do look_around(look, grid, at[i], normals[i], drawn.mean, equal, other) end
    print(("%s, %d bytes, %d bricks, %d points; rms %.1f %%, 99 %% %.1f %%, leak %s"):format(entry.name, report.bytes,
      report.bricks, report.probes, 100 * report.surfaces.rms, 100 * report.error,
      report.surfaces.leak and ("%.3f %%"):format(100 * report.surfaces.leak) or "none"))
    print("  leaves of equal size " .. quantiles(equal))
    print("  leaves of other size " .. quantiles(other))
    io.stdout:flush()
  end
end
