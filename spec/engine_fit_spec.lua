--- Probes for engines that are fitted to the surfaces of a scene, and the irradiance of grids.

local core = require "ylm.c.core"
local long = require "spec.support.long"
local random = require "spec.support.random"
local reader = require "spec.support.engine_reader"
local scratch = require "spec.support.scratch"
local three_page = require "spec.support.three_page"
local ylm = require "ylm"

local function within(n, lo, hi, seed) return random.points_in(n, lo, hi, seed):totable() end

local function luminance(c) return 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end

--- Two rooms with a closed wall of 8 cm between them; a lamp is in the left one.
local function rooms()
  local grey = ylm.matte { albedo = 0.6 }
  return ylm.scene "rooms" {
    geometry = { ylm.box { bounds = { { -2, 0, -1 }, { 2, 2, 1 } }, sides = "back", material = grey },
      ylm.box { bounds = { { 0.1, 0.001, -0.999 }, { 0.18, 1.999, 0.999 } }, sides = "front", material = grey },
      ylm.box { bounds = { { -1.4, 0.001, -0.5 }, { -0.9, 0.6, 0 } }, sides = "front", material = grey } },
    lights = { ylm.sphere_light { at = { -0.8, 1.5, 0.2 }, radius = 0.1, radiance = { 30, 28, 25 } } },
    links = ylm.links { spacing = 0.3, rays = 64 }, camera = ylm.camera { from = { -1.8, 1, 0.8 }, at = { 0, 1, 0 } } }
end

--- Places on the walls of both rooms: points, normals.
local function on_walls(n)
  local points, normals = {}, {}
  for i, p in ipairs(within(n, { -1.95, 0.05, -0.95 }, { 1.95, 1.95, 0.95 }, 5)) do
    local axis, up = i % 3 + 1, i % 2
    if not (p[1] > 0 and p[1] < 0.3) and not (p[1] < -0.8 and p[1] > -1.5) then
      local lo, hi = { p[1] < 0.1 and -2 or 0.18, 0, -1 }, { p[1] < 0.1 and 0.1 or 2, 2, 1 }
      p[axis] = up == 1 and hi[axis] or lo[axis]
      local normal = { 0, 0, 0 }
      normal[axis] = up == 1 and -1 or 1
      points[#points + 1], normals[#normals + 1] = p, normal
    end
  end
  return points, normals
end

describe("grid:irradiance", function()
  it("is that of its coefficients and normals, and not below 0", function()
    local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = { 10, 20, 30 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 3, lmax = 3 }, lamp)
    local points = within(20, { -0.9, -0.9, -0.9 }, { 0.9, 0.9, 0.9 }, 1)
    local normals, least = within(20, { -1, -1, -1 }, { 1, 1, 1 }, 2), 0
    local E = grid:irradiance(points, normals)
    for i, p in ipairs(points) do
      local wanted = ylm.sh.irradiance(grid:sample(p), normals[i])
      for c = 1, 3 do
        local w = wanted:get(c)
        least = math.min(least, w)
        assert.near(math.max(0, w), E:get(i, c), 1e-5 * math.abs(w) + 1e-6)
      end
    end
    assert(least < 0)                                             -- or nothing of that was shown
    assert.has_error(function() grid:irradiance(points, { { 0, 1, 0 } }) end)
  end)
end)

describe("fits of probes", function()
  it("find the numbers that an engine reads, where there are such", function()
    local cells, n, k = { 3, 2, 4 }, 1500, 9
    local draw = within(n, { 0, 0, 0 }, { 3, 2, 4 }, 3)
    local basis, wanted, truth = {}, {}, {}
    for i, p in ipairs(within(24 * k, { 0, 0, 0 }, { 1, 1, 1 }, 4)) do truth[i] = p[1] + 0.2 end
    for i, d in ipairs(within(3 * n, { -1, -1, -1 }, { 1, 1, 1 }, 6)) do
      local row = math.floor((i - 1) / 3) + 1
      basis[row] = basis[row] or {}
      for a = 1, 3 do table.insert(basis[row], d[a]) end
    end
    for i, p in ipairs(draw) do
      local sum, low, part = 0, {}, {}
      for a = 1, 3 do
        local x = math.max(0, math.min(cells[a] - 1, p[a] - 0.5))
        low[a] = math.min(cells[a] - 2, math.floor(x))
        part[a] = x - low[a]
      end
      for corner = 0, 7 do
        local w, probe, stride = 1, 0, 1
        for a = 1, 3 do
          local up = math.floor(corner / 2 ^ (a - 1)) % 2
          w, probe, stride = w * (up == 1 and part[a] or 1 - part[a]), probe + stride * (low[a] + up), stride * cells[a]
        end
        for j = 1, k do sum = sum + w * basis[i][j] * truth[probe * k + j] end
      end
      wanted[i] = { sum + 40 }                                    -- none is dark
      basis[i][k + 1] = 1
    end
    local ones = {}
    for i = 1, n do ones[i] = 1 end
    local function solve(threads)
      local probes = ylm.zeros({ 24, 1, k + 1 }, "float")
      assert(core.grid_fit { cells = cells, at = ylm.array(draw, "double"), basis = ylm.array(basis, "float"),
        wanted = ylm.array(wanted, "float"), weight = ylm.array(ones, "float"),
        hold = ylm.zeros({ 24 }, "float"), norm = ylm.zeros({ k + 1 }, "float"), probes = probes, threads = threads })
      return probes
    end
    local probes = solve(1)
    local read = core.grid_fit_look { cells = cells, at = ylm.array(draw, "double"), basis = ylm.array(basis, "float"),
      probes = probes, threads = 1 }
    for i = 1, n do assert.near(wanted[i][1], read:get(i, 1), 0.1) end
    assert(probes:same(solve(2)))
  end)

  describe("of two rooms", function()
    local folder, scene, grid, points, normals, truth, mean
    setup(function()
      folder, scene = scratch.new(), rooms()
      grid = assert(scene:bake { quantity = "indirect", progress = false, -- along the scene's links
        probes = ylm.uniform_grid { lmax = 2, cells = { 16, 8, 8 } } })
      points, normals = on_walls(1200)
      truth, mean = grid:irradiance(points, normals, { scene = scene }):totable(), 0
      for _, E in ipairs(truth) do mean = mean + luminance(E) / #truth end
    end)
    teardown(function() folder:remove() end)

    --- Judges what an engine reads from the file beside the grid: { rms, error, leak } over the mean.
    local function judged(path)
      local E, square, errors, leak, dark = reader.of(path).read(points, normals), 0, {}, 0, 0
      for i, e in ipairs(E) do
        local off = luminance(e) - luminance(truth[i])
        square = square + (off / mean) ^ 2 / #E
        errors[i] = math.abs(off) / math.max(mean, luminance(truth[i]))
        if points[i][1] > 0.15 then leak, dark = leak + math.abs(off) / mean, dark + 1 end
      end
      table.sort(errors)
      return { rms = math.sqrt(square), error = errors[math.ceil(0.99 * #errors)], leak = leak / dark }
    end

    it("err less and leak less than sampled ones, and the report says by how much", function()
      local cells, path = { 8, 4, 4 }, folder.path .. "/a.three.json"
      assert(grid:export(path, { cells = cells }))
      local sampled = judged(path)
      local report = assert(grid:export(path, { cells = cells, scene = scene, grids = 1 }))
      local one = judged(path)
      assert(#report.grids == 1 and one.rms < 0.8 * sampled.rms, one.rms .. " " .. sampled.rms)
      report = assert(grid:export(path, { cells = cells, scene = scene }))
      local parted = judged(path)
      assert(#report.grids >= 2 and parted.rms < 0.5 * sampled.rms, parted.rms .. " " .. sampled.rms)
      assert(parted.leak < math.max(1e-5, 0.5 * sampled.leak), parted.leak .. " " .. sampled.leak) -- the grid is dark there
      local at = report.grids[1].bounds[2][1]
      assert(math.abs(at - 0.14) < 1e-3, at)                      -- in the middle of the wall
      local s = report.surfaces
      assert.equal(report.error, s.error)
      assert(math.abs(parted.rms / s.rms - 1) < 0.4 and s.places > 3000, s.rms .. " " .. parted.rms)
      assert(s.worst.error >= s.error and #s.worst.at == 3)
      assert(report.bytes == reader.of(path).bytes)
    end)

    it("are read by three.js as here", function()
      if not three_page.there() then pending "YLM_NODE_MODULES with three, and chromium, are wanted" end
      assert(grid:export(folder.path .. "/three.three.json", { cells = { 8, 4, 4 }, scene = scene }))
      local at, facing, centres = {}, {}, {}
      for i = 1, 12 do
        local p = points[37 * i]
        local c = { p[1] * 0.9, 0.1 + 0.9 * p[2], p[3] * 0.9 }
        centres[i] = c
        for _, n in ipairs(three_page.normals) do
          at[#at + 1] = { c[1] + three_page.radius * n[1], c[2] + three_page.radius * n[2], c[3] + three_page.radius * n[3] }
          facing[#facing + 1] = n
        end
      end
      local E = reader.of(folder.path .. "/three.three.json").read(at, facing)
      for i, row in ipairs(three_page.irradiance(folder, folder:read "three.three.json", centres)) do
        for c = 1, 3 do assert.near(E[i][c] / math.pi, row[c], 0.02 * E[i][c] + 2e-3 * mean) end
      end
    end)

    it("take as many bytes as there are, or as the tolerance asks for", function()
      local path = folder.path .. "/b.three.json"
      local report = assert(grid:export(path, { bytes = 20000, scene = scene }))
      assert(report.bytes <= 20000 and report.bytes > 10000, report.bytes)
      local better = assert(grid:export(path, { bytes = 50000, scene = scene }))
      assert(better.bytes <= 50000 and better.error < report.error, better.error .. " " .. report.error)
      local met = assert(grid:export(path, { tolerance = report.error, scene = scene }))
      assert(met.met and met.error <= report.error)
      local none, message, code = grid:export(path, { tolerance = 1e-4, bytes = 15000, scene = scene })
      assert(none == nil and code == "ELIMIT" and message:find "not met", message)
    end)

    it("are those of cubes and of coefficients, too", function()
      local cells = { 10, 5, 5 }
      for name, least in pairs { ["c.ktx2"] = 0.9, ["c.npy"] = 0.9 } do
        local report = assert(grid:export(folder.path .. "/" .. name, { cells = cells, scene = scene }))
        assert(#report.grids == 1 and report.surfaces.rms < least, name .. " " .. report.surfaces.rms)
      end
      local path = folder.path .. "/d.npy"
      local off = assert(grid:export(path, { cells = cells, scene = scene, offset = 0.5 }))
      local on = assert(grid:export(path, { cells = cells, scene = scene }))
      assert(off.surfaces.rms < on.surfaces.rms)
    end)

    it("are judged by scene:judge as by a reader of its own", function()
      local path, o = folder.path .. "/f.three.json", { cells = { 8, 4, 4 }, scene = scene }
      assert(grid:export(path, o))
      local report = assert(scene:judge(path, { places = 200, samples = 128, progress = false }))
      local parted = judged(path)
      assert(report.rms > 0.5 * parted.rms and report.rms < 3 * parted.rms + 2 * report.noise, report.rms .. " " .. parted.rms)
      assert(report.bytes == #folder:read "f.three.json" and #report.worst.at == 3 and report.noise > 0)
      assert(grid:export(folder.path .. "/f.npy", { cells = { 8, 4, 4 }, scene = scene, dtype = "float16" }))
      local box = { bounds = grid.bounds, places = 200, samples = 128, progress = false }
      local plain = assert(scene:judge(folder.path .. "/f.npy", box))
      assert(grid:export(folder.path .. "/f.ktx2", { cells = { 8, 4, 4 }, scene = scene }))
      local cubes = assert(scene:judge(folder.path .. "/f.ktx2", box))
      for _, r in ipairs { plain, cubes } do assert(r.rms > 0.01 and r.rms < 0.6, r.rms) end
      local own = assert(scene:judge(grid, { places = 200, samples = 128, progress = false }))
      assert(own.rms < report.rms)
      -- files of strangers
      local good = folder:read "f.three.json"
      for k, text in ipairs { "", good:sub(1, 2000), good:gsub('"resolution":%[%d+', '"resolution":[4096', 1),
        good:gsub('"min":%[[^,]+', '"min":[nan', 1), good:gsub('"data":"....', '"data":"!!!!', 1),
        (good:gsub('"data":"' .. ("."):rep(3200), '"data":"' .. ("//////9/"):rep(400), 1)) } do
        folder:write("bad.three.json", text)
        local none, message, code = scene:judge(folder.path .. "/bad.three.json", { places = 100, samples = 64 })
        assert(none == nil and code == "EFORMAT" and message:find "bad.three.json", k .. tostring(message))
      end
      local ktx2 = folder:read "f.ktx2"
      for n = 0, #ktx2 - 1, long(5009, 1009) do
        folder:write("bad.ktx2", ktx2:sub(1, n))
        local none, _, code = scene:judge(folder.path .. "/bad.ktx2", { places = 100, samples = 64 })
        assert(none == nil and code == "EFORMAT")
      end
    end)

    it("refuse what they cannot use", function()
      local path = folder.path .. "/e.npy"
      for _, bad in ipairs { { scene = 1 }, { scene = scene, dering = true }, { scene = scene, points = points }, { offset = 1 },
        { scene = scene, grids = 2 } } do
        assert.has_error(function() grid:export(path, bad) end)
      end
      local far = ylm.scene "far" { geometry = { ylm.sphere { at = { 30, 0, 0 } } }, lights = scene.lights }
      local none, message, code = grid:export(path, { scene = far })
      assert(none == nil and code == "EDOMAIN" and message:find "no surface", message)
      assert.is_nil(io.open(path))
    end)
  end)
end)
