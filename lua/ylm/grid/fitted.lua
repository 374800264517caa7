--- Probes of a grid that are fitted to the surfaces of a scene, on one lattice or on several that walls part.

local array = require "ylm.array"
local engine = require "ylm.grid.engine"
local places = require "ylm.grid.places"

local fitted = {}

local LEAST_PLACES, MOST_PLACES, PLACES_A_PROBE = 8192, 2 ^ 18, 8 -- that probes are fitted to
local HELD_OUT = 4096     -- places that the error is measured at
local QUICK = 6000        -- places by which lattices are compared
local PLANES = 6          -- that a box is tried to be cut at
local GAIN = 0.95         -- of the error that is left: a cut that leaves more is not made
local STRAIGHT = 0.999    -- of a normal along an axis
local THICK = 0.6         -- of a cell: walls up to it are parted
local AREA = 0.01         -- of a box's places, on each side of a wall
local NOTHING = 1e-3      -- of a cell

-- One lattice --------------------------------------------------------------------------------------

--- Cells for a box so that probes are about `spacing` apart, two at least.
local function cells_for(lo, hi, spacing)
  local cells = {}
  for a = 1, 3 do cells[a] = math.max(2, math.floor((hi[a] - lo[a]) / spacing[a] + 0.5)) end
  return cells
end

--- A lattice of a part of the bounds, wider where places of its outer sides are looked at beyond it.
local function lattice_of(make, part, cells, p)
  local l = { lo = { part.lo[1], part.lo[2], part.lo[3] }, hi = { part.hi[1], part.hi[2], part.hi[3] }, cells = cells }
  local offset, h = make.reader.offset, {}
  for a = 1, 3 do h[a] = (l.hi[a] - l.lo[a]) / cells[a] end
  local at = p.points + p.normals * (array.array(h) * offset)
  local least, most = at:min(1), at:max(1)
  for a = 1, offset > 0 and 3 or 0 do
    local below = part.lo[a] == make.lo[a] and least[a] < make.lo[a] - NOTHING * h[a] and 1 or 0
    local above = part.hi[a] == make.hi[a] and most[a] > make.hi[a] + NOTHING * h[a] and 1 or 0
    local more = (l.hi[a] - l.lo[a]) / (1 - (below + above) * offset / cells[a]) * offset / cells[a]
    l.lo[a], l.hi[a] = l.lo[a] - below * more, l.hi[a] + above * more
  end
  return l
end

--- Probes of a lattice, sampled at the middles and fitted to places: [n][channels][numbers], validity. Or nil, message, code.
local function probes_of(make, lattice, p, quick)
  local probes, validity, code = make.sample(lattice)
  if not probes then return nil, validity, code end
  if not p then return probes, validity end
  local ok, message
  ok, message, code = engine.fit(lattice, make.reader, probes, validity, p, make.threads, quick)
  if not ok then return nil, message, code end
  return probes, validity
end

-- Several ------------------------------------------------------------------------------------------

--- Coordinates along axis a at which places have normals along it: { up, down }, lists of { at, n }, of as many places at least.
local function faces(p, rows, a, least)
  local counts = { {}, {} }
  for _, i in ipairs(rows) do
    local n = p.lists.normals[i][a]
    local side = n > STRAIGHT and 1 or n < -STRAIGHT and 2
    if side then
      local key = math.floor(p.lists.points[i][a] * 1e4 + 0.5)
      counts[side][key] = (counts[side][key] or 0) + 1
    end
  end
  local lists = { {}, {} }
  for side = 1, 2 do
    for key, n in pairs(counts[side]) do if n >= least then table.insert(lists[side], { at = key / 1e4, n = n }) end end
    table.sort(lists[side], function(x, y) return x.at < y.at end)
  end
  return lists[1], lists[2]
end

--- Planes in the middle of walls within a part: { axis, at, n }, those with the largest faces first.
local function planes(p, part, spacing)
  local list = {}
  for a = 1, 3 do
    local up, down = faces(p, part.rows, a, math.max(4, AREA * #part.rows))
    for _, u in ipairs(up) do
      for _, d in ipairs(down) do
        local thick, at = u.at - d.at, (u.at + d.at) / 2
        if thick >= 0 and thick <= THICK * spacing[a] and at > part.lo[a] + spacing[a] and at < part.hi[a] - spacing[a] then
          list[#list + 1] = { axis = a, at = at, n = math.min(u.n, d.n) }
        end
      end
    end
  end
  table.sort(list, function(x, y)
    if x.n ~= y.n then return x.n > y.n end
    return x.axis < y.axis or x.axis == y.axis and x.at < y.at
  end)
  return list
end

local function copy(v) return { v[1], v[2], v[3] } end

--- The mask of a list of rows.
local function mask_of(rows, n)
  local mask = {}
  for i = 1, n do mask[i] = 0 end
  for _, i in ipairs(rows) do mask[i] = 1 end
  return array.array(mask, "float")
end

--- A part's error with a lattice of its own, in part.square. True, or nil, message, code.
local function judge_part(make, part, p, spacing)
  local own = places.some(p, mask_of(part.rows, p.n))
  part.square = 0
  if not own then return true end
  local lattice = lattice_of(make, part, cells_for(part.lo, part.hi, spacing), own)
  local probes, message, code = probes_of(make, lattice, own, true)
  if not probes then return nil, message, code end
  local read
  read, message, code = engine.look(lattice, make.reader, probes, own, make.threads)
  if not read then return nil, message, code end
  part.square = engine.square(own, read)
  return true
end

--- The two parts of a part that a plane makes, judged. Or nil, message, code.
local function halves(make, part, plane, p, spacing)
  local a = plane.axis
  local low, high = { lo = part.lo, hi = copy(part.hi), rows = {} }, { lo = copy(part.lo), hi = part.hi, rows = {} }
  low.hi[a], high.lo[a] = plane.at, plane.at
  for _, i in ipairs(part.rows) do
    local x = p.lists.points[i][a] + make.reader.offset * spacing[a] * p.lists.normals[i][a]
    table.insert((x < plane.at and low or high).rows, i)
  end
  for _, half in ipairs { low, high } do
    local ok, message, code = judge_part(make, half, p, spacing)
    if not ok then return nil, message, code end
  end
  return { low, high }
end

--- The best cut of a part: { low, high }, nil where none gains enough; or nil, message, code.
local function cut(make, part, p, spacing)
  local best, list = nil, planes(p, part, spacing)
  for k = 1, math.min(PLANES, #list) do
    local two, message, code = halves(make, part, list[k], p, spacing)
    if not two then return nil, message, code end
    local square = two[1].square + two[2].square
    if not best or square < best.square then best = { square = square, two = two } end
  end
  return best and best.square < GAIN * part.square and best.two or nil
end

--- Parts of the bounds, `most` of them, which walls part: { lo, hi }. Or nil, message, code.
local function parts_of(make, cells, most)
  local whole = { lo = make.lo, hi = make.hi, rows = {} }
  local p, message, code = make.places(QUICK)
  if not p then return nil, message, code end
  local spacing = {}
  for a = 1, 3 do spacing[a] = (make.hi[a] - make.lo[a]) / cells[a] end
  for i = 1, p.n do whole.rows[i] = i end
  p.lists = { points = p.points:totable(), normals = p.normals:totable() }
  local judged
  judged, message, code = judge_part(make, whole, p, spacing)
  if not judged then return nil, message, code end
  local parts, whole_ones = { whole }, {}
  while #parts < most do
    local worst
    for _, part in ipairs(parts) do
      if not whole_ones[part] and (not worst or part.square > worst.square) then worst = part end
    end
    if not worst then break end
    local two, why, failed = cut(make, worst, p, spacing)
    if why then return nil, why, failed end
    if two then
      for k, part in ipairs(parts) do if part == worst then parts[k] = two[1] end end
      parts[#parts + 1] = two[2]
    else whole_ones[worst] = true end
  end
  return parts, spacing
end

-- All of it ----------------------------------------------------------------------------------------

--- The lattices of a number of cells along the axes. Or nil, message, code.
local function lattices_of(make, cells, p)
  if make.most == 1 then return { lattice_of(make, { lo = make.lo, hi = make.hi }, cells, p) } end
  local parts, spacing, code = parts_of(make, cells, make.most)
  if not parts then return nil, spacing, code end
  local list = {}
  for k, part in ipairs(parts) do
    list[k] = lattice_of(make, part, #parts == 1 and cells or cells_for(part.lo, part.hi, spacing), p)
  end
  return list
end

--- The luminances [n] that an engine reads at places of several lattices. Or nil, message, code.
local function read_all(make, lattices, grids, p)
  local light = array.zeros({ p.n }, "float")
  for k, mask in ipairs(engine.shared_out(lattices, make.reader, p)) do
    if mask:sum() > 0 then
      local read, message, code = engine.look(lattices[k], make.reader, grids[k].probes, p, make.threads)
      if not read then return nil, message, code end
      light = light + read * mask
    end
  end
  return light
end

--- An exporter: made(cells) -> { grids: { lattice, probes, validity }, judged }, each once; or nil, message, code. `make` is {
-- lo, hi, reader, most: lattices, threads, sample(lattice) -> probes, validity; places(n, seed); rounded(probes): as files have
-- them }.
function fitted.maker(make)
  local known, drawn, held = {}, {}, nil
  local draw = make.places
  --- Places that are fitted to, a power of two.
  function make.places(n)
    local message, code
    if not drawn[n] then drawn[n], message, code = draw(n, 1) end
    return drawn[n], message, code
  end
  local function places_for(probes)
    local n = LEAST_PLACES
    while n < PLACES_A_PROBE * probes and n < MOST_PLACES do n = 2 * n end
    return make.places(n)
  end
  return function(cells)
    local key = table.concat(cells, " ")
    if known[key] then return known[key] end
    local message, code, p, lattices
    if not held then held, message, code = draw(HELD_OUT, 1000) end
    if not held then return nil, message, code end
    p, message, code = places_for(cells[1] * cells[2] * cells[3])
    if not p then return nil, message, code end
    lattices, message, code = lattices_of(make, cells, p)
    if not lattices then return nil, message, code end
    local grids = {}
    for k, mask in ipairs(engine.shared_out(lattices, make.reader, p)) do
      local probes, validity
      probes, validity, code = probes_of(make, lattices[k], places.some(p, mask))
      if not probes then return nil, validity, code end
      grids[k] = { lattice = lattices[k], probes = make.rounded(probes), validity = validity }
    end
    local light
    light, message, code = read_all(make, lattices, grids, held)
    if not light then return nil, message, code end
    known[key] = { grids = grids, judged = engine.judge(held, light) }
    return known[key]
  end
end

--- Numbers as a file of halves has them.
function fitted.halved(probes) return array.array(array.array(probes, "float16"), "float") end

return fitted
