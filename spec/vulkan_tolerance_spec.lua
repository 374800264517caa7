-- Grids with a tolerance, whose points' rows stay on a device while the processor refines them: against those whose rows
-- are its own. On Mesa's lavapipe, where there is no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local long = require "spec.support.long"
local with = require "spec.support.with"

local box, floor = bakes.box, bakes.floor(3000)

local lamps = bakes.lamps(40, { floor = true })

describe("a grid with a tolerance, its rows on a device", function()
  local gpu = device.here()
  if not gpu then return end

  local function description(o)
    return ylm.adaptive_grid(with({ bounds = box, lmax = 2, depth = 4, tolerance = 0.02 }, o))
  end

  --- The grid by the processor and on the device. A decision compares residuals, quantiles and held-out errors: cells may
  -- differ where they stand on a cut-off, one in a hundred at most; the promise does not.
  local function both(o, lights, occupied)
    local here, there = bakes.both(description(o), lights, { occupied = occupied }, gpu, "residuals")
    local a, b, n, differ = bakes.cells_of(here), bakes.cells_of(there), 0, 0
    for key, x in pairs(a) do
      n = n + 1
      if not b[key] or b[key].leaf ~= x.leaf then differ = differ + 1 end
    end
    assert(differ <= 0.01 * n, ("%d of %d cells differ"):format(differ, n))
    assert(bakes.same_points(here, there, 1e-5) > 0.98 * here.stats.points)
    for _, key in ipairs { "met", "limited", "rounds" } do assert.equal(here.stats[key], there.stats[key], key) end
    assert(math.abs(here.stats.error - there.stats.error) <= 0.02 * here.stats.error + 1e-6)
    if differ == 0 then
      for _, key in ipairs { "points", "tested", "pairs", "invalid", "verified", "interpolated" } do
        assert.equal(here.stats[key], there.stats[key], key)
      end
    end
    return here, there
  end

  describe("has the processor's cells, points and errors", function()
    for _, lmax in ipairs { 0, 4, 10 } do
      it("at lmax " .. lmax, function() both({ lmax = lmax, depth = 3 }, lamps, floor) end)
    end

    it("with points in lights, of which rows are filled from neighbours", function()
      local here = both({ tolerance = 0.05 }, lamps, floor)
      assert(here.stats.invalid > 3)
    end)

    it("where every voxel is occupied, in luminance, not continuous, of the metric of rgb", function()
      both({ depth = 3 }, lamps)
      both({ channels = "luminance" }, lamps, floor)
      both({ continuous = false }, lamps, floor)
      both({ metric_channels = "rgb", metric = "absolute" }, lamps, floor)
    end)

    it("of numbers whose squares are no floats", function()
      both({ depth = 3 }, bakes.lamps(40, { floor = true, bright = 1e25 }), floor)
      both({ depth = 3 }, bakes.lamps(40, { floor = true, bright = 1e-25 }), floor)
    end)

    it("under no light at all", function()
      both({}, ylm.sphere_light { at = { 0, 0, 0 }, radius = 0 }, floor)
    end)

    it("where few points are occupied", function() both({}, lamps, { { 0.3, 0.1, 0.2 }, { -0.9, 0.5, 0.5 } }) end)
  end)

  it("keeps its promise at points that nobody has held out", function()
    local grid = assert(ylm.bake(description { tolerance = 0.01, depth = 6 }, lamps, { occupied = floor, device = gpu }))
    assert(grid.stats.met and grid.stats.error <= 0.01 and grid.stats.verified > 1000)
    local others = bakes.floor(2000, 8)
    local exact, sampled = ylm.light_field(2, lamps, others), grid:sample(others, { device = gpu })
    local errors = {}
    for i = 1, 2000 do
      local _, e, norm = core.array_distance(sampled[i], exact[i])
      local p = others[i]:totable()
      local inside = (p[1] - 0.1) ^ 2 + (p[2] + 0.9) ^ 2 + (p[3] - 0.2) ^ 2 <= 0.09
      if not inside then errors[#errors + 1] = e / norm end
    end
    table.sort(errors)
    assert(#errors > 1500 and errors[math.ceil(0.98 * #errors)] <= 0.01, errors[math.ceil(0.98 * #errors)])
  end)

  it("is the same to the bit each time, in small passes too", function()
    local d = description {}
    local first = assert(ylm.bake(d, lamps, { occupied = floor, device = gpu }))
    assert(bakes.identical(first, assert(ylm.bake(d, lamps, { occupied = floor, device = gpu }))))
    local own = device.open()
    require "ylm.c.vulkan".gpu_shrink(own, 0, 400 * 1024, 0)
    assert(bakes.identical(first, assert(ylm.bake(d, lamps, { occupied = floor, device = own }))))
    own:close()
  end)

  describe("brings its rows to the host when the device has no room for them", function()
    local shrink = require "ylm.c.vulkan".gpu_shrink

    --- A bake of rows of so many bytes, of which a device's kernels see a part, makes the same grid, and leaves nothing.
    local function leaves(d, row, part, occupied)
      local own = device.open { validate = true }
      local here = assert(ylm.bake(d, lamps, { occupied = occupied }))
      shrink(own, 0, math.floor(part * here.stats.points * row / 4), 0)
      local there = assert(ylm.bake(d, lamps, { occupied = occupied, device = own }))
      assert(math.abs(here.stats.points - there.stats.points) <= 0.01 * here.stats.points)
      -- voxels of depth 7 end next to a light: there float is 1.5e-7 d/(d - r) off, on either
      assert(bakes.same_points(here, there, 1e-4) > 0.98 * here.stats.points)
      assert.equal(here.stats.met, there.stats.met)
      collectgarbage()
      collectgarbage()
      assert.equal(0, own.stats.arrays)
      device.close_silent(own)
    end

    it("at any point of a bake with a tolerance", function()
      for _, part in ipairs(long({ 0.6 }, { 0.3, 0.6, 0.95 })) do
        leaves(description { depth = 7, tolerance = 0.001 }, 4 * 32 * 4, part, floor)
      end
    end)

    it("of a uniform grid", function()
      leaves(ylm.uniform_grid { bounds = box, cells = 8, lmax = 4 }, 4 * 80 * 4, 0.9)
    end)

    it("for want of memory says so, or goes on, and gives back what it took", function()
      local own, codes, good = device.open { validate = true }, {}, 0
      local here = ylm.bake(description {}, lamps, { occupied = floor })
      for k = 8, 24, 2 do
        shrink(own, 2 ^ k, 0, 0)
        local grid, message, code = ylm.bake(description {}, lamps, { occupied = floor, device = own })
        if grid then
          good = good + 1
          assert(math.abs(here.stats.points - grid.stats.points) <= 0.01 * here.stats.points)
          grid:close()
        else codes[code] = message end
        collectgarbage()
        collectgarbage()
        assert.equal(0, own.stats.arrays)
      end
      assert(good >= 1 and codes.ENOMEM and next(codes) == "ENOMEM" and next(codes, "ENOMEM") == nil)
      device.close_silent(own)
    end)
  end)

  it("is cancelled in whatever stage progress says so, and says that the device was lost", function()
    local stages, last = {}, nil
    local d = description {}
    assert(ylm.bake(d, lamps, { occupied = floor, device = gpu, progress = function(done, total, stage)
      assert(done <= total)
      if stage ~= last then stages[#stages + 1], last = stage, stage end
    end }))
    local seen = table.concat(stages, " ")
    assert(seen:find("level 0") and seen:find("level 3") and seen:find("verifying"), seen)
    for _, where in ipairs { "level 0", "level 2", "verifying" } do
      local none, message, code = ylm.bake(d, lamps, { occupied = floor, device = gpu,
        progress = function(_, _, stage) return stage ~= where end })
      assert.same({ nil, "cancelled", "ECANCELLED" }, { none, message, code }, where)
    end
    local own, n = device.open(), 0
    local none, message, code = ylm.bake(d, lamps, { occupied = floor, device = own, progress = function()
      n = n + 1
      if n == 3 then require "ylm.c.vulkan".gpu_lose(own) end
    end })
    assert(none == nil and code == "EDEVICE" and message:find("was lost"), message)
    own:close()
  end)

  it("refuses what lights on a device are refused", function()
    local ok, message = pcall(function()
      return (ylm.bake(description { lmax = 11 }, gpu:lights(lamps, { method = "forward" }), { occupied = floor }))
    end)
    assert(not ok and message:find("^spec/vulkan_tolerance_spec.lua:%d+: bake: lmax must be 0 .. 8 "), message)
    local there = gpu:lights(lamps)
    ok, message = pcall(ylm.bake, description {}, there, { occupied = floor, progress = function() there:close() end })
    assert(not ok and tostring(message):find("in use by a call that has not returned"), message)
    ok, message = pcall(ylm.bake, description {}, there, { occupied = floor, progress = function() gpu:close() end })
    assert(not ok and tostring(message):find("in use by a call that has not returned"), message)
  end)

  it("says where the field is not finite, as the processor says it", function()
    local bright = ylm.sphere_light { at = { 0.3, 0.2, -1.2 }, radius = 0.2, radiance = 3e38 }
    local d = ylm.uniform_grid { bounds = box, cells = 2, lmax = 1 }
    local function says(o)
      local ok, message = pcall(ylm.bake, d, { bright, bright, bright, bright }, o)
      assert.is_false(ok)
      assert.truthy(message:find "is beyond the range of float", message)
      return message
    end
    assert.equal(says {}, says { device = gpu })
  end)

  it("is refined without a device's rows where kernels see few buffers", function()
    local own = device.open()
    require "ylm.c.vulkan".gpu_shrink(own, 0, 0, 8)
    local grid = assert(ylm.bake(description {}, lamps, { occupied = floor, device = own }))
    assert(grid.stats.stages.lights and not grid.stats.stages.residuals)
    own:close()
  end)
end)
