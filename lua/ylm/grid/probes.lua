--- Probes for engines at run time, '.ylmp': bricks of a grid's leaves, fitted to surfaces, in as few points as bytes allow.
--
-- A topology is { grid, cuts }: whose leaves become bricks, and how often those are halved whose points have slopes. Points of a
-- brick that may be one are joined, those first that cost least; a finer topology with fewer points is better than a coarse one
-- with all of its points.

local array = require "ylm.array"
local bake = require "ylm.grid.bake"
local check = require "ylm.check"
local core = require "ylm.c.core"
local engine = require "ylm.grid.engine"
local field = require "ylm.field"
local form = require "ylm.form"
local places = require "ylm.grid.places"
local warning = require "ylm.warning"

local probes = {}

local LMAX, BITS = 2, 10
local LEAST_PLACES, MOST_PLACES, PLACES_A_POINT = 16384, 2 ^ 17, 8 -- that numbers are fitted to
local HELD_OUT = 4096               -- places that the error is measured at
local HOLD, GHOSTS_HOLD = 0.03, 3e-4 -- of a point, and of one that no surface sees, beside the error at surfaces
local UNIFORM = { 2, 3, 4, 6, 8, 12, 16 } -- cells along the longest axis of coarser topologies
local BUDGETS = { 1000, 2000, 3000, 4000, 5500, 7000, 12000, 30000 } -- points of adaptive ones
local ADAPTIVE, DEPTH = 0.05, 6           -- their tolerance and depth
local POINTS_A_BYTE = 0.4           -- of the adaptive topology that is looked at first
local FEWEST = 0.06                 -- points of each brick: with fewer, a coarser topology is better
local WORSE = 3                     -- topologies after the best, from the finest that fits on
local ROUGH = 0.1                   -- an error above which more of them are tried
local FINE = 0.002                  -- an error below which no more of them are tried
local HALVED = 0.5                  -- of the points are left between two fits
local LEAST = 1e-12                 -- of a mean that is divided by
local MOST_CUTS, MOST_POINTS = 3, 2 ^ 20
local STEPS, FIRST_BYTES, NEAR = 5, 8192, 1.2 -- of the search for the fewest bytes of a tolerance

-- Places ---------------------------------------------------------------------------------------------

--- Irradiance of three channels.
local function coloured(E)
  if E.shape[2] == 3 then return E end
  return array.stack({ E, E, E }, 2):reshape { #E, 3 }
end

--- Weights of places [n]: those of other exports, times the larger of their light and the mean, so that what is far brighter than
-- the mean counts.
local function weights(p)
  local mean = math.max(p.mean, LEAST)
  return engine.weights(p) * p.light:clamp(mean) / mean
end

--- Places as core takes them; `points` are those of the probes.
local function rows_of(p, points, threads)
  local square = math.max(p.mean, 1e-12) ^ 2
  return { points = array.array(p.points, "double"), normals = array.array(p.normals, "float"),
    wanted = array.array(coloured(p.wanted), "float"), weight = array.array(weights(p) * (points / p.n), "float"),
    hold = HOLD / square, hold_ghosts = GHOSTS_HOLD / square, threads = threads }
end

--- The light that readers of a file have: luminances [n] at places.
local function read_at(file, p)
  return places.luminance(core.probes_irradiance(file, array.array(p.points, "double"), array.array(p.normals, "float")))
end
probes.read_at = read_at

-- Topologies -------------------------------------------------------------------------------------------

local Maker = {}
Maker.__index = Maker

--- Places to which so many points are fitted; or nil, message, code.
function Maker:places_for(points)
  local n = LEAST_PLACES
  while not self.few and n < PLACES_A_POINT * points and n < MOST_PLACES do n = 2 * n end
  if not self.drawn[n] then
    local p, message, code = places.draw("export", self.light, self.scene, n, 1)
    if not p then return nil, message, code end
    self.drawn[n] = p
  end
  return self.drawn[n]
end

--- The probes of a topology as the grid has them, which nobody changes; or nil, message, code.
function Maker:raw(topology)
  if topology.made then return topology.made end
  local rows
  if self.scene then
    local p, message, code = self:places_for(core.grid_stats(topology.grid).points)
    if not p then return nil, message, code end
    rows = rows_of(p, 1, self.threads)
  end
  local message, code
  topology.made, message, code = check.result("export",
    core.probes_make(topology.grid, self.lmax, topology.cuts, self.walls, rows))
  return topology.made, message, code
end

-- Fits of probes, each in turn: quick ones of halves of the points, and a last one. `stages` keeps the quick ones, since those of
-- other bytes begin with them.
local Fit = {}
Fit.__index = Fit

--- Changes the probes by how(file, rows, n), or a copy of theirs where others have them too: true, or nil, message, code.
function Fit:change(how, quick)
  local message, code
  if self.shared then
    self.file, message, code = core.probes_copy(self.file)
    if not self.file then return nil, message, code end
    self.shared = false
  end
  local rows = rows_of(self.places, self.n, self.maker.threads)
  rows.quick = quick
  local ok
  ok, message, code = check.result("export", how(self.file, rows, self.n))
  if not ok then return nil, message, code end
  self.size, message, code = check.result("export", core.probes_size(self.file, self.maker.bits))
  return self.size and true, message, code
end

--- Joins points until n are left, but for the first step, and fits these. True, or nil, message, code.
function Fit:step(k)
  local known = self.stages and self.stages[k]
  if known and self.halved and known.size_before.points > self.most(known.size_before) then
    self.file, self.size, self.shared = known.file, known.size, true
    return true
  end
  local ok, message, code
  if k > 1 then
    ok, message, code = self:change(core.probes_thin)
    if not ok then return nil, message, code end
  end
  local before = self.size
  local quick = before.points > self.most(before)
  ok, message, code = self:change(core.probes_fit, quick)
  if not ok then return nil, message, code end
  self.halved = self.halved and quick
  if self.stages and self.halved then
    self.stages[k], self.shared = { size_before = before, file = self.file, size = self.size }, true
  end
  return true
end

--- Copies of probes whose numbers are fitted to surfaces, with at most `most(size)` points; or nil, message, code. `stages`, or
-- nil: the list of the quick fits of these probes, which grows.
function Maker:fit(made, most, stages)
  local size, message, code = check.result("export", core.probes_size(made, self.bits))
  if not size then return nil, message, code end
  local fit = setmetatable({ maker = self, file = made, shared = true, size = size, n = size.points, most = most,
    stages = stages, halved = true }, Fit)
  fit.places, message, code = self:places_for(fit.n)
  if not fit.places then return nil, message, code end
  local ok
  ok, message, code = fit:step(1)
  local k = 1
  while ok and fit.size.points > most(fit.size) do -- points that are joined need fewer names: more fit then
    local half = math.floor(HALVED * fit.n)
    k, fit.n = k + 1, math.max(most(fit.size), half)
    fit.halved = fit.halved and fit.n == half
    ok, message, code = fit:step(k)
    if ok and fit.size.points > fit.n then break end -- nothing is left to be joined
  end
  if not ok then return nil, message, code end
  return fit.file
end

--- The points with which probes take at most so many bytes.
function Maker:points_within(size, bytes)
  local point = math.ceil((16 + 3 * (size.lmax + 1) ^ 2 * self.bits) / 8)
  local most = 0
  for name = 1, 24 do                                         -- bits of a name
    local n = math.floor((bytes - size.rest - math.ceil(name * size.names / 8) - 7) / point)
    most = math.max(most, math.min(2 ^ name - 2 - size.means, n))
  end
  return most
end

--- Judges probes as their readers have them; or nil, message, code.
function Maker:judge(made)
  local bytes, message, code = core.probes_encode(made, self.bits)
  if not bytes then return nil, message, code end
  local file
  file, message, code = core.probes_decode(bytes, "probes")
  if not file then return nil, message, code end
  local read = read_at(file, self.held)
  local judged = engine.judge(self.held, read)
  judged.square = engine.square(self.held, read, weights(self.held))
  return judged
end

--- The description of topology k of a kind; nil: it is the grid's own, or there is none.
local function described(g, kind, k)
  local channels = g.channels == 3 and "rgb" or "luminance"
  if kind ~= "uniform" then
    return BUDGETS[k] and form.defined.adaptive_grid.construct({ lmax = g.lmax, channels = channels, bounds = g.bounds,
      tolerance = g.sides and ADAPTIVE or nil, depth = DEPTH, points = BUDGETS[k] })
  end
  if not UNIFORM[k] then return nil end
  local lo, hi = g.bounds[1], g.bounds[2]
  local longest, cells = math.max(hi[1] - lo[1], hi[2] - lo[2], hi[3] - lo[3]), {}
  for a = 1, 3 do cells[a] = math.max(1, math.floor(UNIFORM[k] * (hi[a] - lo[a]) / longest + 0.5)) end
  return form.defined.uniform_grid.construct({ lmax = g.lmax, channels = channels, bounds = g.bounds, cells = cells })
end

--- Topology k of a kind, "uniform", "clipped" or "squares", from coarse to fine: { grid, cuts }, or nil where there is none; or
-- nil, message, code. The last of those whose leaves differ is the grid's own.
function Maker:topology(kind, k)
  local g, known = self.grid, self.topologies[kind]
  if known[k] then return known[k] end
  local description = described(g, kind, k)
  if description then
    local o = { scene = self.scene, progress = false, threads = self.threads,
      geometry = kind ~= "uniform" and self.meshes or nil }
    local coarse, message, code = bake.of_scene(description, g, o, nil, nil, kind)
    if not coarse then return nil, message, code end
    known[k] = { grid = coarse, cuts = 0 }
  elseif kind == "clipped" and k == #BUDGETS + 1 then known[k] = { grid = g, cuts = 0 } end
  return known[k]
end

--- Topology k of a kind where its probes may be fitted in so many bytes; false: it is too fine; nil: there is none; or nil,
-- message, code.
function Maker:coarse(kind, k, bytes)
  local topology, message, code = self:topology(kind, k)
  if not topology then return nil, message, code end
  local made, size
  made, message, code = self:raw(topology)
  if not made then return nil, message, code end
  size, message, code = core.probes_size(made, self.bits)
  if not size then return nil, message, code end
  local most = self:points_within(size, bytes)
  return most >= math.max(1, math.min(size.points, FEWEST * size.bricks)) and topology
end

--- The better of `best`, or nil, and of a topology's probes that are fitted in so many bytes; or nil, message, code.
function Maker:better(best, topology, bytes)
  if self.several then topology.stages = topology.stages or {} end
  local made, message, code = self:fit(topology.made, function(size) return self:points_within(size, bytes) end, topology.stages)
  if not made then return nil, message, code end
  local judged, size
  judged, message, code = self:judge(made)
  if not judged then return nil, message, code end
  size, message, code = core.probes_size(made, self.bits)
  if not size then return nil, message, code end
  if size.bytes <= bytes and not (best and best.judged.square <= judged.square) then return { made = made, judged = judged } end
  return best
end

--- The number of the finest topology of a kind whose probes may be fitted in so many bytes, 0 where there is none; those that are
-- far coarser are not made. Or nil, message, code.
function Maker:finest(kind, bytes)
  local low, high = 0, kind == "uniform" and #UNIFORM + 1 or #BUDGETS + 2 -- those that fit, and are too fine
  local k = 1
  if kind == "clipped" then
    while BUDGETS[k + 1] and BUDGETS[k + 1] <= POINTS_A_BYTE * bytes do k = k + 1 end
  end
  while low + 1 < high do
    local topology, message, code = self:coarse(kind, k, bytes)
    if message then return nil, message, code end
    if topology then low, k = k, k + 1 else high, k = k, k - 1 end
  end
  return low
end

--- The best probes of at most so many bytes, or the first that have the error `enough`: { made, judged }; nil: there are none; or
-- nil, message, code. Uniform leaves are tried after those that refine, where the best may be among them. Where all are rough,
-- leaves that refine by squares are tried too, from one step finer than the finest of the others that fits.
function Maker:within(bytes, enough)
  local best, worse = nil, 0
  --- Tries topologies from fine to coarse, of(i), until so many were worse than the best; or nil, message, code.
  local function try(n, of)
    for i = n, 1, -1 do
      if worse == WORSE or best and best.judged.error <= enough then break end
      local topology, message, code = of(i)
      if message then return nil, message, code end
      if topology then
        local better
        better, message, code = self:better(best, topology, bytes)
        if message then return nil, message, code end
        worse = better == best and worse + 1 or 0
        best = better
      end
    end
    return true
  end
  local least, message, code = self:coarse("uniform", 1, bytes)
  if not least then return nil, message, code end
  local finest = 0
  for _, kind in ipairs { "clipped", "uniform" } do
    local n, ok
    if worse == WORSE or best and best.judged.error <= enough then break end
    n, message, code = self:finest(kind, bytes)
    if not n then return nil, message, code end
    finest = math.max(finest, kind == "clipped" and n or 0)
    ok, message, code = try(n, function(i) return self:coarse(kind, i, bytes) end)
    if not ok then return nil, message, code end
  end
  if not best or best.judged.error <= math.max(ROUGH, enough) then return best end
  worse = 0
  local ok
  ok, message, code = try(math.min(finest + 1, #BUDGETS), function(i) return self:coarse("squares", i, bytes) end)
  if not ok then return nil, message, code end
  return best
end

-- Searches ----------------------------------------------------------------------------------------------

--- Probes as they are, or, where there is a scene and its surfaces have less error so, fitted to it; or nil, message, code.
function Maker:fitted(own)
  if not self.scene then return own end
  local file, message, code = self:fit(own.made, function() return math.huge end)
  if not file then return nil, message, code end
  local judged
  judged, message, code = self:judge(file)
  if not judged then return nil, message, code end
  return judged.square < own.judged.square and { made = file, judged = judged, bytes = own.bytes } or own
end

--- The grid's own leaves, halved until a tolerance is kept or bytes are spent: { made, judged }; or nil, message, code.
function Maker:own(tolerance, bytes)
  local best
  for cuts = 0, self.grid.sides and 0 or MOST_CUTS do
    local made, message, code = self:raw { grid = self.grid, cuts = cuts }
    if not made then return nil, message, code end
    local size, judged
    size, message, code = core.probes_size(made, self.bits)
    if not size then return nil, message, code end
    if best and (size.points > MOST_POINTS or bytes and size.bytes > bytes) then break end
    judged, message, code = self:judge(made)
    if not judged then return nil, message, code end
    best, message, code = self:fitted { made = made, judged = judged, bytes = size.bytes }
    if not best then return nil, message, code end
    if tolerance and best.judged.error <= tolerance then break end
  end
  return best
end

--- The probes of few bytes that keep a tolerance, of at most `bytes`; where none keep it, the grid's own: { made, judged }. Or
-- nil, message, code.
function Maker:keeping(tolerance, bytes)
  local own, message, code = self:raw { grid = self.grid, cuts = 0 }
  if not own then return nil, message, code end
  local size
  size, message, code = core.probes_size(own, self.bits)
  if not size then return nil, message, code end
  local most = math.min(size.bytes, bytes or math.huge)
  local best, low, high = nil, 0, FIRST_BYTES
  self.several = true
  for _ = 1, STEPS do
    if low >= most or best and high < NEAR * low then break end
    local bytes_now = best and math.sqrt(math.max(low, high / 16) * high) or math.min(high, most)
    local found
    found, message, code = self:within(bytes_now, tolerance)
    if message then return nil, message, code end
    local kept = found and found.judged.error <= tolerance
    if kept then best, high = found, bytes_now else low = bytes_now end
    if not best then high = 4 * low end
  end
  if best then return best end
  return self:own(tolerance, bytes)
end

--- { made, judged } of the options; or nil, message, code.
function Maker:wanted(o)
  if not self.scene then
    local own, message, code = self:own(not o.bytes and (o.tolerance or self.tolerance) or o.tolerance, o.bytes)
    if own and o.bytes and own.bytes > o.bytes then
      return nil, ("export: the grid's bricks take %.0f bytes, and bytes = %.0f: give more, or a scene, to whose surfaces fewer "
        .. "points are fitted"):format(own.bytes, o.bytes), "ELIMIT"
    end
    return own, message, code
  end
  if o.tolerance then return self:keeping(o.tolerance, o.bytes) end
  if not o.bytes then return self:own(self.tolerance) end
  local found, message, code = self:within(o.bytes, FINE)
  if message then return nil, message, code end
  if found then return found end
  return nil, ("export: bytes = %.0f are too few for the probes of this scene: give more"):format(o.bytes), "ELIMIT"
end

--- Places without surfaces: points, and directions that are spread evenly.
local function in_space(g, points)
  local n, normals = #points, {}
  for i = 1, n do
    local z, phi = 1 - (2 * i - 1) / n, i * math.pi * (3 - math.sqrt(5))
    local r = math.sqrt(1 - z * z)
    normals[i] = { r * math.cos(phi), r * math.sin(phi), z }
  end
  local p = { n = n, points = points, normals = array.array(normals, "float") }
  local message, code
  p.wanted, message, code = g:irradiance(points, p.normals)
  if not p.wanted then return nil, message, code end
  p.light = places.luminance(p.wanted)
  p.mean = p.light:mean()
  return p
end

--- Refuses options that are of other files; the options.
function probes.check(o)
  for _, name in ipairs { "cells", "grids", "offset", "dering", "dtype" } do
    if o[name] and not (name == "dtype" and o.dtype == "float") then
      return check.fail("export: %s is of other files than .ylmp: leave it out", name)
    end
  end
  if o.lmax and (o.lmax < 1 or o.lmax > 2) then return check.fail "export: lmax of .ylmp is 1 or 2" end
  if o.scene ~= nil and o.points then
    return check.fail "export: with a scene, places are those of its surfaces: leave points out"
  end
  return o
end

--- The bytes of a file of a grid's probes, and the report of grid:export; o: its options, `points()` where the error is measured
-- without a scene, `default`: the tolerance of points with slopes. Or nil, message, code.
function probes.encode(g, o, points, default)
  local few = o.scene ~= nil and (o.bytes or o.tolerance)
  local make = setmetatable({ grid = g, scene = o.scene, bits = o.bits or BITS, lmax = o.lmax or few and 1 or LMAX,
    threads = o.threads, drawn = {}, topologies = { uniform = {}, clipped = {}, squares = {} }, few = few,
    tolerance = default }, Maker)
  local message, code
  if o.scene ~= nil then
    make.light, make.meshes = places.of_grid(g, o.scene), {}
    for i, shape in ipairs(o.scene.geometry) do make.meshes[i] = shape.mesh end
    make.walls, message, code = field.walls_of_scene(2, "export", o.scene)
    if not make.walls then return nil, message, code end
    make.held, message, code = places.draw("export", make.light, o.scene, HELD_OUT, 1000)
  else make.held, message, code = in_space(g, points()) end
  if not make.held then return nil, message, code end
  local found
  found, message, code = make:wanted(o)
  if not found then return nil, message, code end
  local size
  size, message, code = core.probes_size(found.made, make.bits)
  if not size then return nil, message, code end
  local report = { error = found.judged.error, surfaces = o.scene ~= nil and found.judged or nil, probes = size.points,
    bricks = size.bricks, lmax = make.lmax, bits = make.bits, grids = { { bounds = size.bounds, cells = size.roots } } }
  found.judged.square = nil
  local tolerance = o.tolerance or o.scene == nil and not o.bytes and not g.sides and default or nil
  if tolerance then
    report.met = report.error <= tolerance
    local sentence = not report.met and ("export: tolerance %g is not met by the grid's %d bricks, 99 %% of the places keep "
      .. "%.3g: bake a finer grid, or set tolerance = %.2g"):format(tolerance, size.bricks, report.error, 1.05 * report.error)
    if sentence and not o.anyway then return nil, sentence .. ", or anyway = true to write it; nothing was written", "ELIMIT" end
    report.warning = sentence and warning.say(g, "export", "%s", sentence) or nil
  end
  local bytes
  bytes, message, code = core.probes_encode(found.made, make.bits)
  if not bytes then return nil, message, code end
  report.bytes = #bytes
  return bytes, report
end

--- Writes a grid's probes, as of probes.encode: the report, or nil, message, code.
function probes.export(g, path, o, points, default)
  local bytes, report, code = probes.encode(g, o, points, default)
  if not bytes then return nil, report, code end
  local ok, message
  ok, message, code = core.file_save(path, bytes)
  if not ok then return nil, message, code end
  return report
end

return probes
