-- Exact polygons and disks on a device, against those of the processor. On Mesa's lavapipe, where there is no other device.

local core = require "ylm.c.core"
local ylm = require "ylm"
local bakes = require "spec.support.bakes"
local device = require "spec.support.gpu"
local fields = require "spec.support.fields"
local long = require "spec.support.long"
local numbers = require "spec.support.random"

local next = numbers.spread(77)

local function place(edge) return { (next() - 0.5) * edge, (next() - 0.5) * edge, (next() - 0.5) * edge } end

--- n polygons of so many sides, about `size` across, in a cube of edge 4; some negative.
local function polygons(n, size, sides, horizon)
  local list = {}
  for i = 1, n do
    local c, u, v, vertices = place(4), place(2), place(2), {}
    for k = 1, sides do
      local p = 2 * math.pi * k / sides
      vertices[k] = {}
      for a = 1, 3 do vertices[k][a] = c[a] + size / 2 * (u[a] * math.cos(p) + v[a] * math.sin(p)) end
    end
    list[i] = ylm.polygon_light { vertices = vertices, radiance = { next(), next(), next() - 0.2 }, horizon = horizon }
  end
  return list
end

local function disks(n, size, horizon)
  local list = {}
  for i = 1, n do
    list[i] = ylm.disk_light { at = place(4), normal = place(1), radius = size * (0.1 + next()), horizon = horizon,
      radiance = { next(), next(), next() - 0.2 } }
  end
  return list
end

describe("exact flat lights on a device", function()
  local gpu = device.here()
  if not gpu then return end
  if not gpu.limits.float64 then
    it("are refused where it does not compute in double", function()
      local lights, message, code = gpu:lights(disks(1, 1))
      assert(lights == nil and code == "EMISSING" and message:find "method = \"sphere\"", message)
    end)
    return
  end

  local function agree(...) return fields.agree(gpu, ...) end

  local points = numbers.points(37, 3, 6)
  local few = { points[1], points[2], points[3] }

  for _, lmax in ipairs(long({ 4, 10 }, { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 })) do
    it(("agree to 1e-5 in float, with Hessians and the metric, at lmax %d"):format(lmax), function()
      local lights = { polygons(23, 0.6, 3), polygons(5, 1, 5), disks(9, 0.5) }
      agree(lmax, lights, points, { derivatives = 2, channels = "luminance", metric = "luminance" }, 1e-5)
    end)
  end

  it("agree to 1e-12 in double", function()
    local lights = { polygons(23, 0.6, 3), disks(9, 0.5) }
    if long(false, true) then agree(0, lights, points, { derivatives = 2, dtype = "double" }, 1e-12) end
    agree(5, lights, points, { derivatives = 2, metric = "rgb", dtype = "double" }, 1e-12)
  end)

  it("agree where values alone, gradients, or only the metric are asked for, of rgb and of luminance", function()
    local lights = { polygons(7, 1, 4), disks(3, 0.5) }
    for _, channels in ipairs(long({ "rgb" }, { "rgb", "luminance" })) do
      if long(channels == "rgb", true) then agree(4, lights, points, { channels = channels }, 1e-5) end
      if long(channels ~= "rgb", true) then agree(4, lights, points, { channels = channels, derivatives = 1 }, 1e-5) end
    end
    if long(false, true) then agree(4, lights, points, { derivatives = 1, metric = "luminance" }, 1e-5) end
    if long(false, true) then agree(4, lights, points, { channels = "luminance", metric = "rgb" }, 1e-5) end
  end)

  it("agree at lmax 11 (make check-long: and 60), in slices of harmonics, and beyond that they are refused", function()
    local lights = { polygons(2, 1, 3), disks(1, 0.5), polygons(1, 1, 3, { 1, 2, 3 }) }
    agree(11, lights, few, { derivatives = 2, channels = "luminance" }, 1e-5)
    if long(false, true) then agree(60, lights, few, { derivatives = 1, channels = "luminance" }, 1e-5) end
    local ok, message = pcall(ylm.light_field, 61, lights, few, { device = gpu })
    assert(not ok and message:find("lmax must be .* 60"), message)
  end)

  it("agree of one light at one point, of many at many, of polygons with 64 sides", function()
    local all = { derivatives = 2, channels = "luminance", metric = "luminance" } -- compiled above
    agree(4, polygons(1, 1, 3), { { 0.3, 0.2, 0.1 } }, all, 1e-5)
    agree(4, disks(1, 1), { { 0.3, 0.2, 0.1 } }, all, 1e-5)
    agree(3, polygons(long(200, 1500), 0.05, 3), numbers.points(65, 3, 8), all, 1e-5)
    agree(3, polygons(3, 2, 64), points, all, 1e-5)
  end)

  it("agree where they are beside spheres, flat lights that spheres stand for, and exact textures", function()
    local spheres = bakes.lamps(40, {})
    local near = ylm.disk_light { at = { 0.5, 0.25, -0.5 }, normal = { 0, 1, 2 }, radius = 0.3, method = "sphere" }
    local texture = ylm.textured_light { corner = { -1, 1, -1 }, u = { 2, 0, 0 }, v = { 0, 0.3, 2 }, method = "exact",
      image = { { 1, 2, 3 }, { 4, 0, 6 } } }
    local exact = { polygons(7, 0.6, 3), disks(3, 0.5), texture, polygons(3, 1, 4, { 0, 1, 0 }) }
    agree(4, { exact, spheres }, points, { derivatives = 2, metric = "luminance" }, 1e-5)
    if long(true, false) then return end
    agree(2, { exact, near, spheres }, points, { derivatives = 2, dtype = "double" }, 1e-12)
    agree(4, { exact, near }, points, { derivatives = 2, channels = "luminance" }, 1e-5)
    agree(12, { exact, spheres }, few, { derivatives = 1, channels = "luminance" }, 1e-5)
    agree(4, texture, points, { derivatives = 1 }, 1e-5)
  end)

  it("agree on them, at their vertices and edges, in their planes and next to these", function()
    local square = ylm.polygon_light { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } }, radiance = { 1, 2, 3 } }
    local disk = ylm.disk_light { at = { 0.5, 0.5, 0 }, normal = { 0, 0, 1 }, radius = 0.5, radiance = { 1, 2, 3 } }
    local where = { { 0, 0, 0 }, { 0.5, 0, 0 }, { 0.25, 0.5, 0 }, { 0.5, 0.5, 0 }, { 1, 0.5, 0 }, -- on them
      { 2, 0, 0 }, { -0.5, 0.25, 0 }, { 3, 3, 0 } } -- beside them
    for _, light in ipairs { square, disk } do
      local there = agree(3, light, where, { derivatives = 2 }, 1e-5)
      local report = there[4].inside:totable()
      assert.same({ 1, 1, 0, 0, 0 }, { report[3], report[4], report[6], report[7], report[8] })
      local close = {}
      local function near(h) for _, x in ipairs(where) do close[#close + 1] = { x[1] + h / 3, x[2], h } end end
      for _, h in ipairs { 0.1, 1e-2, -1e-3, 1e-4 } do near(h) end
      agree(3, light, ylm.array(close, "double"), { derivatives = 2, dtype = "double" }, 1e-9) -- 1e-14 lmax/|cos gamma|
      near(1e-8)
      agree(3, light, close, { derivatives = 2 }, 1e-5)
    end
  end)

  it("agree where they are small and far, and where the point is in their midst", function()
    for _, size in ipairs { 1e-1, 1e-2, 1e-3, 1e-5 } do
      agree(6, polygons(1, size, 3), few, { derivatives = 2 }, 1e-5)
      agree(6, disks(1, size), few, { derivatives = 2 }, 1e-5)
    end
    agree(4, polygons(1, 100, 4), points, { derivatives = 2 }, 1e-5)
    agree(4, disks(1, 100), points, { derivatives = 2 }, 1e-5)
  end)

  it("agree along a disk's rim, by panels", function()
    local disk, close = ylm.disk_light { at = { 0, 0, 0 }, normal = { 1, 2, 3 }, radius = 1, radiance = 2 }, {}
    local u, n = { 2 / math.sqrt(5), -1 / math.sqrt(5), 0 }, { 1 / math.sqrt(14), 2 / math.sqrt(14), 3 / math.sqrt(14) }
    for _, r in ipairs { 0.5, 0.9, 0.999, 1, 1.001, 1.2 } do
      for _, h in ipairs { 0.3, 1e-2, -1e-4 } do
        close[#close + 1] = { r * u[1] + h * n[1], r * u[2] + h * n[2], r * u[3] + h * n[3] }
      end
    end
    agree(5, disk, ylm.array(close, "double"), { derivatives = 2, dtype = "double" }, 1e-11)
    agree(5, disk, close, { derivatives = 2 }, 1e-5)
  end)

  describe("cut by a horizon", function()
    local up = { 0.3, 1, -0.2 }
    for _, lmax in ipairs(long({ 3 }, { 0, 3, 9 })) do
      it(("agree to 1e-5 in float and 1e-12 in double, Hessians too, at lmax %d"):format(lmax), function()
        local lights = { polygons(11, 1.5, 3, up), polygons(5, 1, 6, up), disks(9, 1, up) }
        agree(lmax, lights, points, { derivatives = 2, channels = "luminance" }, 1e-5)
        agree(lmax, lights, few, { derivatives = 2, channels = "luminance", dtype = "double" }, 1e-12)
      end)
    end

    it("agree where all or nothing is above, where it meets a vertex, and of several horizons", function()
      local function triangle(horizon, z)
        return ylm.polygon_light { vertices = { { -1, 0, z }, { 1, 0, z }, { 0, 1, z } }, radiance = 1, horizon = horizon }
      end
      local where = { { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0.5, 0 }, { 0, -1, 0.5 }, { 0, 2, 0.5 }, { 0.5, 0.25, 3 } }
      for _, horizon in ipairs { { 0, 1, 0 }, { 0.1, -1, 0 }, { 1, 0, 0 }, { 0, 0, 1 } } do
        agree(4, triangle(horizon, 1), where, { derivatives = 2 }, 1e-5)
        agree(4, ylm.disk_light { at = { 0, 0.5, 1 }, normal = { 0, 0, 1 }, radius = 0.5, horizon = horizon }, where,
          { derivatives = 2 }, 1e-5)
      end
      agree(4, { triangle({ 0, 1, 0 }, 1), triangle({ 0, -1, 0 }, 1), triangle(nil, 2) }, where, { derivatives = 2 }, 1e-5)
    end)
  end)

  describe("bake", function()
    local box = { { -1, -1, -1 }, { 1, 1, 1 } }
    local floor = numbers.points_in(long(80, 300), { -1, -1, -1 }, { 1, -0.9, 1 }, 7)
    -- no vertex nor plane in a plane of the lattice: where derivatives jump, rounding decides
    -- a horizon makes three kernels more, of seconds each
    local lights = { polygons(9, 0.7, 3), disks(3, 0.3), bakes.lamps(12, {}),
      polygons(2, 0.9, 4, long(nil, { 0.1, 1, 0.2 })) }

    it("the processor's uniform grids", function()
      local form = ylm.uniform_grid { bounds = box, cells = { 3, 4, 2 }, lmax = 2 }
      local there, here = assert(ylm.bake(form, lights, { device = gpu })), ylm.bake(form, lights)
      assert.equal(here.stats.pairs, there.stats.pairs)
      assert(bakes.same_points(here, there, 1e-5) == 60)
      local a, b = there:sample(floor, { device = gpu }), here:sample(floor)
      assert(fields.worst(a, b) <= 1e-5)
    end)

    it("its adaptive grids with a threshold, whose voxels are tested against the lights", function()
      local form = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, threshold = 0.5 }
      local here, there = ylm.bake(form, lights, { occupied = floor }),
        assert(ylm.bake(form, lights, { occupied = floor, device = gpu }))
      local n, close = bakes.same_cells(here, there, 0.5)
      assert(n > 60 and n == here.stats.cells and close == 0, n)
      assert(bakes.same_points(here, there, 1e-5) > 60)
      assert.equal(0, (select(2, core.array_distance(there:cells().crossed, here:cells().crossed))))
      assert(there.stats.stages.subdivide)
    end)

    it("its adaptive grids with a tolerance", function()
      local form = ylm.adaptive_grid { bounds = box, lmax = 2, depth = 4, tolerance = 0.02 }
      local here, there = ylm.bake(form, lights, { occupied = floor }),
        assert(ylm.bake(form, lights, { occupied = floor, device = gpu }))
      assert(there.stats.met == here.stats.met and math.abs(there.stats.cells - here.stats.cells) <= here.stats.cells / 100)
      assert(bakes.same_points(here, there, 1e-5) > 60)
    end)
  end)

  it("report progress, and can be cancelled", function()
    local lights, where, last = gpu:lights { polygons(12, 0.1, 3), disks(2, 0.3) }, numbers.points(300, 2, 9), 0
    assert(ylm.light_field(4, lights, { { 0, 0, 0 } }, { derivatives = 1 })) -- a driver may compile at the first dispatch
    assert(ylm.light_field(4, lights, where, { derivatives = 1, progress = function(done) last = done end }))
    assert.equal(300, last)
    local none, message = ylm.light_field(4, lights, where, { progress = function() return false end })
    assert(none == nil and message == "cancelled")
    assert.equal(14, lights.count)
    lights:close()
  end)

  it("go with a tolerance, as all lights on a device do: it sums all of them", function()
    local lights = { polygons(5, 0.6, 3), bakes.lamps(300, {}) }
    local exact = ylm.light_field(3, lights, points, { device = gpu })
    local there = assert(ylm.light_field(3, lights, points, { device = gpu, tolerance = 0.05 }))
    local _, e = core.array_distance(there, exact)
    assert.equal(0, e)
    local copied = gpu:lights(lights)
    _, e = core.array_distance(assert(ylm.light_field(3, copied, points, { tolerance = 0.05 })), exact)
    assert.equal(0, e)
    local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }
    for _, o in ipairs { { lights, gpu }, { copied } } do
      local plain = ylm.bake(form, o[1], { device = o[2] })
      local grid = assert(ylm.bake(form, o[1], { device = o[2], sums_tolerance = 0.05 }))
      local _, apart = core.array_distance(grid:points().value, plain:points().value)
      assert.equal(0, apart)
      local ok, message = pcall(ylm.bake, form, o[1], { device = o[2], sums_tolerance = 2 })
      assert(not ok and message:find "sums_tolerance must be a number", message)
    end
    local ok, message = pcall(ylm.light_field, 3, lights, points, { device = gpu, tolerance = 0 })
    assert(not ok and message:find "tolerance must be a number", message)
    copied:close()
  end)

  it("have no product rule, which is refused", function()
    for _, method in ipairs { "forward", "reversed" } do
      local ok, message = pcall(gpu.lights, gpu, disks(1, 1), { method = method })
      assert(not ok and message:find "method must be \"merged\"", message)
    end
  end)
end)
