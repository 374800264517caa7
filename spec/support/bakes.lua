--- Grids baked in two ways, compared: on a device and by the processor.

local assert = require "luassert"
local core = require "ylm.c.core"
local ylm = require "ylm"
local grid_bytes = require "spec.support.grid_bytes"
local random = require "spec.support.random"
local with = require "spec.support.with"

local bakes = { box = { { -1, -1, -1 }, { 1, 1, 1 } } }

--- n shading points near the floor of the box.
function bakes.floor(n, seed)
  return random.points_in(n, { -1, -1, -1 }, { 1, -0.9, 1 }, seed or 7)
end

--- n sphere lights of many sizes in a cube twice as large as {-1, 1}^3. `o`: size (0.2, of the largest), dark (true: one
-- in nine has radius 0), bright (factor of radiance), floor (true: the first stands on a floor at -0.9, radius 0.3), corner
-- (true: the first is about a corner of the box, radius 0.1).
function bakes.lamps(n, o)
  local r, at, radii, colours = random.minimal(91), {}, {}, {}
  local size, bright = o.size or 0.2, o.bright or 1
  for i = 1, n do
    at[i] = { 4 * r() - 2, 4 * r() - 2, 4 * r() - 2 }
    radii[i] = o.dark and i % 9 == 5 and 0 or size * (0.1 + r() ^ 4)
    colours[i] = { r() * bright, r() * bright, r() * bright }
  end
  if o.floor then at[1], radii[1] = { 0.1, -0.9, 0.2 }, 0.3 end
  if o.corner then at[1], radii[1] = { -1, -1, -1 }, 0.1 end
  return ylm.sphere_lights { at = at, radius = radii, radiance = colours }
end

--- The grid of a description by the processor and on a device, with these options of ylm.bake. `stage`, where it is given,
-- is one that the device must have taken.
function bakes.both(description, lights, o, gpu, stage)
  local here = assert(ylm.bake(description, lights, o))
  local there = assert(ylm.bake(description, lights, with(o or {}, { device = gpu })))
  assert(not stage or there.stats.stages[stage], "no stage of the device: " .. tostring(stage))
  return here, there
end

--- Cells by "x y z level": { leaf, error, size }.
local function cells_of(grid)
  local cells, out, n = grid:cells(), {}, 0
  local size, origin, level = cells.size:totable(), cells.origin:totable(), cells.level:totable()
  local leaf, metric = cells.leaf:totable(), cells.error:totable()
  for i = 1, #origin do
    local o = origin[i]
    local key = ("%.9g %.9g %.9g %d"):format(o[1], o[2], o[3], level[i])
    out[key] = { leaf = leaf[i] == 1, error = metric[i], size = size[i] }
    n = n + 1
  end
  return out, n
end
bakes.cells_of = cells_of

--- Asserts that cells which both grids have are split in both or in neither, unless their error is within 1e-4 of the
-- threshold. Errors have to agree within twice the bound (1e-5) of points. Returns the number of cells compared, and of
-- those that may differ.
function bakes.same_cells(here, there, threshold, bound)
  local a, b = cells_of(here), cells_of(there)
  local n, close = 0, 0
  for key, x in pairs(a) do
    local y = b[key]
    if y then
      n = n + 1
      if x.error == x.error then
        assert(math.abs(x.error - y.error) <= 2 * (bound or 1e-5) * math.abs(x.error),
          ("%s: %.9g, not %.9g"):format(key, y.error, x.error))
      else assert(y.error ~= y.error, key) end
      if x.leaf ~= y.leaf then
        close = close + 1
        assert(threshold and math.abs(x.error - threshold) < 1e-4 * threshold,
          ("cell %s: error %.9g, %s"):format(key, x.error,
            x.leaf and "split on the device alone" or "not split on the device"))
      end
    end
  end
  return n, close
end

--- Asserts that evaluated points which both grids have hold the same, relative to the norm of a row.
function bakes.same_points(here, there, bound)
  local a, b = here:points(), there:points()
  local row = {}
  for i, p in ipairs(b.position:totable()) do row[("%.9g %.9g %.9g"):format(p[1], p[2], p[3])] = i end
  local n = 0
  for i, p in ipairs(a.position:totable()) do
    local k = row[("%.9g %.9g %.9g"):format(p[1], p[2], p[3])]
    if k and a.interpolated:get(i) == 0 then
      n = n + 1
      for _, key in ipairs { "value", "gradient" } do
        local _, e, norm = core.array_distance(b[key][k], a[key][i])
        assert(e <= bound * norm, ("%s of point %d: %g"):format(key, i, e / norm))
      end
      assert.equal(a.invalid:get(i), b.invalid:get(k))
    end
  end
  return n
end

local CELLS = { "origin", "size", "level", "leaf", "occupied", "baked", "crossed", "added", "corners" }
local POINTS = { "position", "invalid", "interpolated" }
local COUNTS = { "points", "cells", "leaves", "occupied", "levels", "continuity", "interpolated", "pairs", "invalid",
  "outside" }

--- Asserts that two grids hold the same cells and points in the same order. Their numbers have to agree within the bound (1e-5)
-- that agreement with the processor has.
function bakes.same(here, there, bound)
  for _, key in ipairs(COUNTS) do assert.equal(here.stats[key], there.stats[key], key) end
  local a, b = here:cells { added = true }, there:cells { added = true }
  for _, key in ipairs(CELLS) do assert.equal(0, (select(2, core.array_distance(b[key], a[key]))), key) end
  bakes.same_cells(here, there, nil, bound)
  a, b = here:points(), there:points()
  for _, key in ipairs(POINTS) do assert.equal(0, (select(2, core.array_distance(b[key], a[key]))), key) end
  bakes.same_points(here, there, bound or 1e-5)
end

--- Do two grids hold the same cells and points, to the bit? Evaluated points as files of them: the sections behind form and
-- stats; interpolated ones, which files leave out, as arrays.
function bakes.identical(one, other)
  local function body(grid)
    local text = core.grid_encode(grid)
    return text:sub(assert(grid_bytes.open(text).section.cells.offset) + 1)
  end
  local a, b = one:points(), other:points()
  for _, name in ipairs { "value", "gradient" } do
    if core.array_distance(a[name], b[name]) ~= 0 then return false end
  end
  return body(one) == body(other)
end

return bakes
