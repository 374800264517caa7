--- Grids in bricks as folders of few bytes: bricks read alone, equal bits on their borders, tolerances and bytes, refusals.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local random = require "spec.support.random"
local scratch = require "spec.support.scratch"

local lamps, occupied = grids.lamps, grids.occupied
local inside = random.points_in(2000, { -0.95, -0.95, -0.95 }, { 0.95, 0.95, 0.95 }, 3)

--- The largest distance of samples, relative to the largest norm.
local function distance(a, b)
  local most, _, norm = core.array_distance(a:sample(inside), b:sample(inside))
  return most / (norm / math.sqrt(2000))
end

--- The rows of a grid's evaluated points, by their places.
local function rows_of(grid)
  local p, rows = grid:points(), {}
  for i = 1, grid.stats.points do
    local row, at = {}, p.position[i]
    for c = 1, grid.channels do
      for k = 1, (grid.lmax + 1) ^ 2 do
        row[#row + 1] = p.value:get(i, c, k)
        for a = 1, 3 do row[#row + 1] = p.gradient:get(i, c, k, a) end
      end
    end
    rows[("%.17g %.17g %.17g"):format(at:get(1), at:get(2), at:get(3))] = table.concat(row, " ")
  end
  return rows
end

describe("a grid in bricks, in few bytes", function()
  local folder = scratch.new "/dev/shm"
  local function to(name) return folder.path .. "/" .. name end
  local described = ylm.adaptive_grid { bounds = grids.box, lmax = 1, depth = 6, tolerance = 0.01, bricks = 1 }
  local set = assert(ylm.bake(described, lamps, { occupied = occupied, folder = to "grid.ylmd", brick_points = 512 }))

  it("is what it was as the step of rounding falls", function()
    local ok, report = assert(set:save(to "fine.ylmd", { step = 1e-6 }))
    assert.is_true(ok)
    local fine = assert(ylm.load(to "fine.ylmd"))
    assert(distance(set, fine) < 4e-5, distance(set, fine))
    assert.equal(set.stats.bricks, fine.stats.bricks)
    assert.equal(set.stats.points, fine.stats.points)
    assert.equal(report.error, fine.small.error)
    assert.is_nil(set.small)
  end)

  it("has equal bits wherever two bricks, or a brick and the top, have a point, and each is read alone", function()
    assert(set:save(to "coarse.ylmd", { step = 0.01 }))
    local coarse, rows, again = assert(ylm.load(to "coarse.ylmd")), {}, 0
    assert(distance(set, coarse) > 1e-5 and distance(set, coarse) < 0.2, distance(set, coarse))
    local levels = {}
    for i = 1, coarse.stats.bricks + 1 do
      local brick = assert(ylm.load(core.grid_set_file(coarse, i)))
      levels[#core.grid_set_file(coarse, i):match "([^/]*)%.ylm$"] = true
      for place, row in pairs(rows_of(brick)) do
        if rows[place] then
          again = again + 1
          assert(rows[place] == row, place)
        end
        rows[place] = row
      end
    end
    assert(again > 300, again)
    assert(levels[1] and levels[2], "bricks of two levels")
  end)

  it("keeps a tolerance, the sum of its own error and of the largest rounding", function()
    local _, report = assert(set:save(to "tolerance.ylmd", { tolerance = 0.06 }))
    assert(report.error <= 0.06 and report.error > 0.04, report.error)
    assert(math.abs(report.error - report.before - report.largest) < 1e-12)
    local read = assert(ylm.load(to "tolerance.ylmd"))
    assert.equal(report.error, read.stats.error)
    assert.is_true(read.stats.met)
    local failed, e = 0, grids.errors(read:sample(occupied), ylm.light_field(1, lamps, occupied, { dtype = "float" }))
    for i = 1, #e do failed = failed + (e[i] > 0.06 and 1 or 0) end
    assert(failed < 0.01 * #e, failed)
  end)

  it("takes at most the bytes that are asked for, the same files for any number of threads", function()
    local _, report = assert(set:save(to "one.ylmd", { bytes = 60000, threads = 1 }))
    assert(report.bytes <= 60000 and report.bytes > 50000, report.bytes)
    assert(set:save(to "two.ylmd", { bytes = 60000, threads = 2 }))
    local out, code = scratch.capture(("diff -r %s %s"):format(scratch.quote(to "one.ylmd"), scratch.quote(to "two.ylmd")))
    assert.equal(0, code, out)
    local bytes = tonumber((scratch.capture(("find %s -type f -exec cat {} + | wc -c"):format(scratch.quote(to "one.ylmd")))))
    assert(bytes - report.bytes > 0 and bytes - report.bytes < 100, bytes) -- the text that no bake goes on with
  end)

  it("is a grid to go on with: it is packed, saved again and sampled as a whole", function()
    local read = assert(ylm.load(to "coarse.ylmd"))
    assert(read:save(to "whole.ylm"))
    assert.equal(0, (core.array_distance(read:sample(inside), assert(ylm.load(to "whole.ylm")):sample(inside))))
    assert(read:save(to "again.ylmd", { step = 1e-6 }))
    assert(distance(read, assert(ylm.load(to "again.ylmd"))) < 4e-5)
  end)

  it("is refused where it cannot be, and nothing is left then", function()
    local function refused(words, code, name, o)
      local ok, message, got = set:save(to(name), o)
      assert.is_nil(ok)
      assert.equal(code, got)
      assert.matches(words, message)
    end
    refused("errs by", "ELIMIT", "no.ylmd", { tolerance = set.stats.error / 2 })
    refused("at the coarsest", "ELIMIT", "no.ylmd", { bytes = 3000 })
    refused("cancelled", "ECANCELLED", "no.ylmd", { step = 0.01, progress = function(done) return done < 3 end })
    assert.is_nil(io.open(to "no.ylmd"))
    local fine, why = pcall(set.save, set, to "no.ylmd")
    assert.is_false(fine)
    assert.matches("few bytes: tolerance, bytes or step expected", why)
    assert.has_error(function() set:save(to "grid.ylmd", { step = 0.01 }) end)
    assert(io.open(to "grid.ylmd/index")):close()
    local small = assert(ylm.load(to "coarse.ylmd"))
    assert.has_error(function() small:save(to "coarse.ylmd/", { step = 0.01 }) end)
    assert(io.open(to "coarse.ylmd/index")):close()
    local ok, message = pcall(ylm.bake, described, lamps, { occupied = occupied, folder = to "coarse.ylmd" })
    assert.is_false(ok)
    assert.matches("another bake", message)
  end)

  it("is made by ylm pack", function()
    local ylm_ = scratch.quote((os.getenv "YLM_BUILD" or "build") .. "/ylm")
    local out, code = scratch.capture(("%s pack %s -o %s --tolerance 0.06"):format(ylm_, scratch.quote(to "grid.ylmd"),
      scratch.quote(to "packed.ylmd")))
    assert.equal(0, code, out)
    out, code = scratch.capture(("diff -r %s %s && %s info %s"):format(scratch.quote(to "packed.ylmd"),
      scratch.quote(to "tolerance.ylmd"), ylm_, scratch.quote(to "packed.ylmd")))
    assert.equal(0, code, out)
    assert.matches("rounding", out)
    out, code = scratch.capture(("%s pack %s -o %s --tolerance 0.06 && %s pack %s -o - --tolerance 0.06 | cmp - %s"):format(ylm_,
      scratch.quote(to "grid.ylmd"), scratch.quote(to "packed.ylm"), ylm_, scratch.quote(to "grid.ylmd"),
      scratch.quote(to "packed.ylm")))
    assert.equal(0, code, out)
    folder:remove()
  end)
end)
