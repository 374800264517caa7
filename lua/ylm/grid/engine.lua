--- How engines look up light at surfaces, and numbers for them that are fitted to it.
--
-- A reader is what an engine does with the numbers of probes: { numbers: of a probe and channel; offset: cells along the normal
-- that it moves a place by; basis(normals) -> [n][numbers], whose sum with the numbers is irradiance; norm: a number's part of
-- the mean square of irradiance over normals }. A lattice is { lo, hi, cells }: equal cells of a box, with a probe in the middle
-- of each. Of several lattices an engine takes the last whose box holds the place that it looks at. Probes are
-- [n][channels][numbers] of floats, x fastest.

local array = require "ylm.array"
local core = require "ylm.c.core"
local places = require "ylm.grid.places"
local sh = require "ylm.sh"

local engine = {}

local HOLD, BURIED_HOLD = 0.03, 3e-4 -- of a probe that lies free or in a body, beside the error at surfaces
local DARK, DARKER = 0.01, 3         -- of the mean: places below weigh so much more, since light there is a leak
local MARGIN = 0.01                  -- of a cell, by which three.js' boxes are larger
local LEAST = 1e-12                  -- of a mean that is divided by

-- Readers ------------------------------------------------------------------------------------------

--- The factor of each coefficient: that of its degree in irradiance.
function engine.cosines(lmax)
  local list = {}
  for l = 0, lmax do for _ = -l, l do list[#list + 1] = core.sh_cosine_factor(l) end end
  return list
end

--- Coefficients of radiance to degree lmax, which are looked up `offset` cells off the surface.
function engine.coefficients(lmax, offset)
  local factors, norm = engine.cosines(lmax), {}
  for k, a in ipairs(factors) do norm[k] = a * a / (4 * math.pi) end
  return { numbers = #factors, offset = offset, norm = norm,
    basis = function(normals) return array.array(sh.eval(lmax, normals) * array.array(factors), "float") end }
end

--- Irradiance over pi at six faces, blended by the squares of the normal: +x, +y, +z, -x, -y, -z.
engine.cube = { numbers = 6, offset = 0, norm = {}, basis = function(normals)
  local squares, ahead = normals * normals * math.pi, normals:greater_equal(0)
  return array.array(array.stack({ squares * ahead, squares * (1 - ahead) }, 2):reshape { #normals, 6 }, "float")
end }
for k = 1, 6 do engine.cube.norm[k] = math.pi ^ 2 / 10 end

-- Lattices -------------------------------------------------------------------------------------------

local function step(lattice, a) return (lattice.hi[a] - lattice.lo[a]) / lattice.cells[a] end

--- Where an engine looks light up at places, in cells of a lattice: [n][3].
local function looked_at(lattice, reader, p)
  local scale, shift = {}, {}
  for a = 1, 3 do
    scale[a] = 1 / step(lattice, a)
    shift[a] = -lattice.lo[a] * scale[a]
  end
  return p.points * array.array(scale) + array.array(shift) + p.normals * reader.offset
end

--- 1 of the places, in cells, that a lattice holds.
local function held(lattice, at)
  local above = array.array(lattice.cells, "double") + MARGIN - at
  return (at + MARGIN):min(2):greater_equal(0) * above:min(2):greater_equal(0)
end

--- Masks of the places that each lattice answers for; the first also for those that none holds, but where these are dark.
function engine.shared_out(lattices, reader, p, dark)
  local masks, left = {}, array.zeros({ p.n }, "float") + 1
  for k = #lattices, 2, -1 do
    masks[k] = held(lattices[k], looked_at(lattices[k], reader, p)) * left
    left = left - masks[k]
  end
  masks[1] = dark and held(lattices[1], looked_at(lattices[1], reader, p)) * left or left
  return masks
end

--- The middles of a lattice's cells, x fastest: [n][3].
function engine.middles(lattice)
  local list, cells, lo = {}, lattice.cells, lattice.lo
  local hx, hy, hz = step(lattice, 1), step(lattice, 2), step(lattice, 3)
  for z = 1, cells[3] do
    for y = 1, cells[2] do
      for x = 1, cells[1] do list[#list + 1] = { lo[1] + hx * (x - 0.5), lo[2] + hy * (y - 0.5), lo[3] + hz * (z - 0.5) } end
    end
  end
  return array.array(list, "float")
end

-- Fits -----------------------------------------------------------------------------------------------

--- Places for a look-up of a reader: { cells, at, basis, threads }.
local function look_of(lattice, reader, p, threads)
  return { cells = lattice.cells, at = looked_at(lattice, reader, p), basis = reader.basis(p.normals), threads = threads }
end

--- Weights of places [n]: their squared errors are relative to the larger of their light and the mean.
function engine.weights(p)
  local light = p.light:clamp(math.max(p.mean, LEAST))
  return (p.light:less(DARK * p.mean) * (DARKER - 1) + 1) / (light * light)
end

--- Fits the numbers of a lattice's probes to places; `validity` [n] is 1 less the part of each that is in bodies, `quick` a fit
-- that is good enough to compare lattices. True, or nil, message, code.
function engine.fit(lattice, reader, probes, validity, p, threads, quick)
  local fit, n = look_of(lattice, reader, p, threads), #validity
  local hold = (validity:greater_equal(0.5) * (HOLD - BURIED_HOLD) + BURIED_HOLD) / math.max(p.mean, LEAST) ^ 2
  fit.wanted, fit.probes, fit.quick = array.array(p.wanted, "float"), probes, quick
  fit.weight, fit.hold = array.array(engine.weights(p) * (n / p.n), "float"), array.array(hold, "float")
  fit.norm = array.array(reader.norm, "float")
  return core.grid_fit(fit)
end

--- The luminance [n] of the irradiance that an engine reads at places; or nil, message, code.
function engine.look(lattice, reader, probes, p, threads)
  local fit = look_of(lattice, reader, p, threads)
  fit.probes = probes
  local read, message, code = core.grid_fit_look(fit)
  if not read then return nil, message, code end
  return places.luminance(read)
end

--- The sum over places of squared errors, as fits weigh them (default engine.weights), of what is read.
function engine.square(p, read, weights)
  local off = read - p.light
  return (off * off * (weights or engine.weights(p))):sum()
end

--- Judges what an engine reads, luminances [n], beside what is wanted: { rms over the mean; error: 99 % of places keep it,
-- relative to the larger of theirs and the mean; leak: the mean of places that are dark over that of all, nil where none is;
-- worst: { at, normal, error, wanted, read }; places }.
function engine.judge(p, read)
  local off, dark, worst = (read - p.light):abs(), p.light:less(DARK * p.mean), 1
  local errors = (off / p.light:clamp(math.max(p.mean, LEAST))):totable()
  for i = 1, p.n do if errors[i] > errors[worst] then worst = i end end
  local function row(x) return { x:get(worst, 1), x:get(worst, 2), x:get(worst, 3) } end
  local judged = { rms = math.sqrt((off * off):mean()) / math.max(p.mean, LEAST), places = p.n,
    leak = dark:sum() > 0 and (read * dark):sum() / dark:sum() / math.max(p.mean, LEAST) or nil,
    worst = { at = row(p.points), normal = row(p.normals), error = errors[worst], wanted = p.light[worst], read = read[worst] } }
  table.sort(errors)
  judged.error = errors[math.ceil(0.99 * #errors)]
  return judged
end

return engine
