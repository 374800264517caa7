--- Grids in few bytes: grid:save with tolerance, bytes or step, and bakes for a number of bytes or points.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bytes = require "spec.support.grid_bytes"
local grids = require "spec.support.grids"
local long = require "spec.support.long"
local promise = require "spec.support.surface_promise"
local random = require "spec.support.random"
local shell = require "spec.support.scratch"

local box, lamps, occupied = grids.box, grids.lamps, grids.occupied
local inside = random.points_in(4000, { -0.95, -0.95, -0.95 }, { 0.95, 0.95, 0.95 }, 3)

local function baked(form, light, options)
  local bounds = form.bounds or box
  form.bounds = bounds
  return assert(ylm.bake((form.cells and ylm.uniform_grid or ylm.adaptive_grid)(form), light or lamps,
    options or { occupied = occupied }))
end

--- Raises where more of n places fail than a share of 1 % allows (Clopper & Pearson 1934), with a confidence of 99 %.
local function holds(failed, n, what)
  assert(failed <= promise.allowed(n, 0.01), ("%s: %d of %d fail"):format(what, failed, n))
end

--- How many errors, of one list, are above a tolerance.
local function above(errors, tolerance)
  local failed = 0
  for i = 1, #errors do failed = failed + (errors[i] > tolerance and 1 or 0) end
  return failed
end

--- A grid of light that jumps at a wall, z = 0.1: values alone, with sides. And its scene.
local function of_walls(form)
  local scene = ylm.scene "wall" {
    geometry = { ylm.quad { corner = { -1, -1, 0.1 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, divide = 4 },
      ylm.quad { corner = { -1, -1, 1 }, u = { 0, 2, 0 }, v = { 2, 0, 0 } } },
    lights = { ylm.sphere_light { at = { 0.3, 0.2, 0.6 }, radius = 0.05, radiance = { 90, 60, 30 } } },
  }
  return assert(scene:bake { probes = ylm.adaptive_grid(form), quantity = "direct", judge = "field", progress = false }), scene
end

--- A grid as readers have it, its file, and the report.
local function through(grid, how)
  local path = os.tmpname() .. ".ylm"
  local ok, report = assert(grid:save(path, how))
  assert.is_true(ok)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  local read = assert(ylm.load(path))
  os.remove(path)
  return read, text, report
end

--- The largest distance of samples, relative to the largest norm.
local function distance(a, b)
  local most, _, norm = core.array_distance(a:sample(inside), b:sample(inside))
  return most / (norm / math.sqrt(4000))
end

local plain = baked { lmax = 2, depth = 5, tolerance = 0.02 }

describe("grids in few bytes", function()
  for name, make in pairs {
    ["of an octree"] = function() return plain end,
    ["without continuity"] = function() return baked { lmax = 1, depth = 5, tolerance = 0.03, continuous = false } end,
    ["of the mean alone"] = function() return baked { lmax = 0, depth = 4, tolerance = 0.02, channels = "luminance" } end,
    ["of nine bands"] = function() return baked { lmax = 9, depth = 2, threshold = 0.5 } end,
    ["of 43 bands"] = function() return baked { lmax = 42, cells = { 1, 2, 1 }, channels = "luminance" } end,
    ["of 21 bands"] = function() return baked { lmax = 20, cells = { 9, 8, 9 } } end,
    ["of a lattice"] = function() return baked { lmax = 3, cells = { 5, 3, 7 } } end,
    ["with sides"] = function() return of_walls { lmax = 2, depth = 4, tolerance = 0.1 } end,
  } do
    it(name .. " are what they were as the step of rounding falls", function()
      local grid = make()
      local fine, coarse = through(grid, { step = 1e-6 }), through(grid, { step = 0.01 })
      assert.equal(grid.stats.leaves, fine.stats.leaves)
      assert(distance(grid, fine) < 4e-5, distance(grid, fine))
      assert(distance(grid, coarse) > 1e-5 and distance(grid, coarse) < 0.2, distance(grid, coarse))
      assert.equal(grid.quantity, fine.quantity)
      assert.equal(grid.sides, fine.sides)
    end)
  end

  it("keep a tolerance in all, which fresh places of the exact light confirm", function()
    for _, t in ipairs { 0.025, 0.06 } do
      local read, text, report = through(plain, { tolerance = t })
      assert(report.error <= t and report.error > 0.9 * t and report.confidence == 0.99, report.error)
      assert.is_true(report.judged)
      assert.equal(#text, report.bytes)
      assert(report.sections.small_numbers > 0 and report.sections.small_tree > 0)
      assert.is_true(read.stats.met)
      assert.equal(report.error, read.stats.error)
      assert.equal(report.step, read.small.step)
      local path = os.tmpname()
      local file = assert(io.open(path, "wb"))
      file:write(text)
      file:close()
      local look = assert(core.grid_file_look(path))
      os.remove(path)
      assert.equal(report.rounding, look.small.rounding)
      local failed = 0
      local value, exact = read:sample(occupied), ylm.light_field(2, lamps, occupied, { dtype = "float" })
      for i = 1, #occupied do
        local _, d, norm = core.array_distance(value[i], exact[i])
        if d > t * norm then failed = failed + 1 end
      end
      assert(failed <= 0.015 * #occupied, failed)
    end
  end)

  it("keep it in scenes of random lamps, at fresh places", function()
    local next = random.from(77)
    for scene = 1, long(2, 50) do
      local lamps_of = {}
      for i = 1, 1 + math.floor(6 * next()) do
        lamps_of[i] = ylm.sphere_light { at = { 2 * next() - 1, 0.05 + next(), 2 * next() - 1 }, radius = 0.01 + 0.1 * next(),
          radiance = { 9 * next(), 9 * next(), 9 * next() } }
      end
      local lmax, t = math.floor(7 * next()), 0.006 * 10 ^ next()
      local ground = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } }
      local before = ylm.on_warning(false)
      local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1.1, -0.1, -1.1 }, { 1.1, 1.1, 1.1 } }, lmax = lmax,
        depth = 8, tolerance = 0.6 * t, channels = scene % 3 == 0 and "luminance" or "rgb" }, lamps_of, { geometry = ground }))
      ylm.on_warning(before)
      if grid.stats.error < t then
        local read, _, report = through(grid, { tolerance = t })
        assert(report.error <= t and report.judged)
        local places = {}
        for i = 1, 4096 do places[i] = { 2 * next() - 1, 0, 2 * next() - 1 } end
        places = ylm.array(places, "double")
        local e = grids.errors(read:sample(places), ylm.light_field(lmax, lamps_of, places, { dtype = "float",
          channels = scene % 3 == 0 and "luminance" or "rgb" }))
        holds(above(e, t), #e, "scene " .. scene)
      end
    end
  end)

  it("keep it at fresh places after they were loaded, and round no more than they say after a refresh", function()
    local loaded = core.grid_decode(core.grid_encode(plain))
    local read, _, report = through(loaded, { tolerance = 0.05 })
    holds(above(grids.errors(read:sample(occupied), ylm.light_field(2, lamps, occupied, { dtype = "float" })), 0.05), #occupied,
      "loaded")
    holds(above(grids.errors(read:sample(occupied), loaded:sample(occupied)), report.largest), #occupied, "its rounding")
    local other = ylm.sphere_light { at = { 0.5, 0.9, 0.2 }, radius = 0.1, radiance = { 3, 2, 1 } }
    for name, grid in pairs { refreshed = read, updated = core.grid_decode(core.grid_encode(plain)) } do
      assert(grid:update(other))
      local again, _, said = through(grid, { tolerance = 0.05 })
      assert(said.error ~= said.error and said.confidence == 0 and said.largest <= 0.05, name) -- the grid's own error is unknown
      holds(above(grids.errors(again:sample(occupied), grid:sample(occupied)), said.largest), #occupied, name)
    end
  end)

  it("keep it on both sides of a wall, where paths judge", function()
    local grid, scene = of_walls { lmax = 2, depth = 4, tolerance = 0.1 }
    local points, normals, off, n = {}, {}, {}, long(1024, 4096)
    for i = 1, n do
      local u, v, side, z = i * 0.618034 % 1, i * 0.754878 % 1, i % 2 == 0 and 1 or -1, i % 4 == 1 and 1 or 0.1
      points[i], normals[i], off[i] = { 2 * u - 1, 2 * v - 1, z }, { 0, 0, side }, { 2 * u - 1, 2 * v - 1, z + 1e-4 * side }
    end
    local exact = assert(scene:probe { points = off, normals = normals, samples = 64, reflections = { 0, 0 }, seed = 3 })
    for _, tolerance in ipairs { 0.12, 0.3 } do
      local read, _, report = through(grid, { tolerance = tolerance })
      local E, mean, failed, dark = read:irradiance(points, normals), 0, 0, 0
      for i = 1, n do mean = mean + exact:get(i, 1) / n end
      for i = 1, n do
        local wanted = exact:get(i, 1)
        failed = failed + (math.abs(E:get(i, 1) - wanted) > tolerance * math.max(wanted, mean) and 1 or 0)
        if wanted == 0 then dark = math.max(dark, E:get(i, 1) / mean) end
      end
      assert(report.error <= tolerance and read.stats.met)
      holds(failed, n, tolerance)
      assert(dark < 1e-4, dark) -- behind the wall
    end
  end)

  it("add both errors where nobody knows the exact light", function()
    local loaded = core.grid_decode(core.grid_encode(plain))
    local _, _, report = through(loaded, { tolerance = 0.06 })
    assert.is_false(report.judged)
    assert(math.abs(report.error - report.before - report.largest) < 1e-12)
    assert(report.error <= 0.06)
  end)

  it("take at most the bytes that are asked for, and nearly these", function()
    for _, size in ipairs { 12000, 30000 } do
      local _, text, report = through(plain, { bytes = size })
      assert(#text <= size and #text > 0.95 * size, #text)
      assert(report.error > 0.8 * plain.stats.error and report.error < 0.2)
    end
    local _, text = through(plain, { bytes = "20 KB" })
    assert(#text <= 20 * 1024)
  end)

  it("are fewer than a tenth of the numbers at an error that is seen by nobody", function()
    local _, text = through(plain, { tolerance = 0.03 })
    assert(#text < #core.grid_encode(plain) / 20, #text)
  end)

  it("refuse what cannot be, and write nothing then", function()
    local path = os.tmpname() .. ".ylm"
    local ok, message, code = plain:save(path, { tolerance = plain.stats.error / 2 })
    assert.is_nil(ok)
    assert.equal("ELIMIT", code)
    assert.matches("errs by", message)
    ok, message, code = plain:save(path, { bytes = 1000 })
    assert.is_nil(ok)
    assert.equal("ELIMIT", code)
    assert.matches("takes %d+ at the coarsest", message)
    local said = 0
    ok, message, code = plain:save(path, { tolerance = 0.06, progress = function(done, total)
      said = math.max(said, done / total)
      return said == 0
    end })
    assert.is_nil(ok)
    assert.equal("cancelled ECANCELLED", message .. " " .. code)
    assert(said < 0.2, said) -- within the first step that is tried
    local moving = baked { lmax = 1, depth = 3, tolerance = 0.1, dynamic = true }
    assert.has_error(function() moving:save(path, { step = 0.01 }) end)
    assert.is_nil(io.open(path))
  end)

  it("are the same rows under every kernel set and number of threads", function()
    local folder = shell.new()
    finally(function() folder:remove() end)
    local read, text = through(plain, { step = 0.01 })
    for threads = 1, 3 do
      assert(text == core.grid_encode_small(plain, 0, 0, 0.01, threads), threads)
    end
    local program = folder:write("load.lua", [[
local folder = ...
local grid = assert(require "ylm".load(folder .. "/grid.ylm"))
assert(require "ylm".info().kernel == "reference")
assert(grid:points().value:save(folder .. "/value.npy"))]])
    folder:write("grid.ylm", text)
    local out, code = shell.capture(("YLM_ISA=reference YLM_LUA=%s LUA_PATH= LUA_CPATH= %s run %s %s"):format(
      os.getenv "YLM_LUA" or "lua5.4", shell.quote((os.getenv "YLM_BUILD" or "build") .. "/ylm"), shell.quote(program),
      shell.quote(folder.path)))
    assert.equal(0, code, out)
    local here, there = read:points().value, assert(ylm.load(folder.path .. "/value.npy"))
    for i = 1, read.stats.points do assert.equal(0, core.array_distance(here[i], there[i])) end
  end)

  it("can be saved as they are, refreshed and saved again", function()
    local read = through(plain, { step = 0.02 })
    local again = core.grid_decode(core.grid_encode(read))
    assert.equal(0, (core.array_distance(read:sample(inside), again:sample(inside))))
    assert(read:update { ylm.sphere_light { at = { 0.5, 0.9, 0.2 }, radius = 0.1, radiance = 3 } })
    assert.is_nil(read.small)
    local other = through(read, { step = 1e-5 })
    assert(distance(read, other) < 1e-3)
    local sided = of_walls { lmax = 2, depth = 4, tolerance = 0.1 }
    local packed = through(sided, { step = 1e-6 })
    local lamp = ylm.sphere_light { at = { 0.3, 0.2, 0.6 }, radius = 0.05, radiance = { 50, 60, 30 } }
    assert(sided:update(lamp) and packed:update(lamp))
    assert(distance(sided, packed) < 0.02, distance(sided, packed)) -- ghosts ask within 0.01 of their leaf's edge
  end)

  it("are refused when damaged, at each bit and each end", function()
    local tiny = baked { lmax = 0, depth = 1, tolerance = 0.3, channels = "luminance" }
    local _, text = through(tiny, { step = 0.1 })
    assert.equal(0, core.grid_accepted_damage(text))
  end)

  it("are refused or finite when forged", function()
    local _, text = through(baked { lmax = 1, depth = 3, tolerance = 0.1 }, { step = 0.02 })
    local rng = random.minimal(5)
    local accepted, refused = 0, 0
    local names = { "form", "small", "small_tree", "small_bases", "small_tables", "small_points", "small_numbers", "small_bits" }
    for i = 1, 600 do
      local file = bytes.open(text)
      local name = names[i % #names + 1]
      local s = file.section[name]
      if s and #s.data > 0 then
        local at = math.floor(rng() * #s.data)
        file:put(name, at, string.char(math.floor(rng() * 256)))
        local grid, message, code = core.grid_decode(file:seal())
        if grid then
          accepted = accepted + 1
          local value = grid:sample { { 0.1, 0.2, 0.3 } }
          for k = 1, value.shape[3] do assert(value:get(1, 1, k) == value:get(1, 1, k)) end
        else
          refused = refused + 1
          assert(code == "EFORMAT" or code == "EVERSION", ("%s %s: %s"):format(name, code, message))
        end
      end
    end
    assert(refused > 100, refused)
    assert(accepted + refused > 400)
  end)

  it("of grids with sides are refused where a piece is of a part that its leaf has not", function()
    local grid, message, code = ylm.load "spec/data/forged_pieces.ylm" -- found by make fuzz-storm
    assert(grid == nil and code == "EFORMAT" and message:find "the part of a piece", message)
  end)
end)

describe("bakes for a number of bytes or points", function()
  local function light_box(form)
    form.bounds = box
    return form
  end

  it("end with the least error that fits", function()
    local grid = assert(ylm.bake(ylm.adaptive_grid(light_box { lmax = 2, depth = 6, bytes = 30000 }), lamps,
      { occupied = occupied }))
    local report = grid.small
    assert(report.error > 0 and report.judged)
    for _, tolerance in ipairs { 0.01, 0.03 } do
      local _, other = core.grid_encode_small(baked { lmax = 2, depth = 6, tolerance = tolerance }, 0, 30000, 0, 1)
      assert(report.error <= 1.1 * other.error, ("%g %g"):format(report.error, other.error))
    end
    local path = os.tmpname() .. ".ylm"
    assert(grid:save(path)) -- as it is: the file that was asked for
    local read = assert(ylm.load(path))
    os.remove(path)
    assert.equal(0, (core.array_distance(grid:sample(inside), read:sample(inside))))
    assert.equal(grid.stats.error, read.stats.error)
  end)

  it("end at so many points", function()
    local grid = assert(ylm.bake(ylm.adaptive_grid(light_box { lmax = 2, depth = 6, points = 900 }), lamps,
      { occupied = occupied }))
    assert(grid.stats.points <= 900 and grid.stats.points > 400, grid.stats.points)
  end)

  it("say that so few bytes do not do", function()
    local grid, message, code = ylm.bake(ylm.adaptive_grid(light_box { lmax = 2, depth = 6, bytes = 900 }), lamps,
      { occupied = occupied })
    assert.is_nil(grid)
    assert.equal("ELIMIT", code)
    assert.matches("bytes = 900", message)
  end)
end)
