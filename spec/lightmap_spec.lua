-- Irradiance as files: a lightmap per texel, a PLY per element.

local elements = require "spec.support.elements"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local pi = math.pi

local function near(x, truth, tolerance, what)
  assert.is_true(math.abs(x - truth) <= tolerance * math.abs(truth), ("%s: %.6g, not %.6g"):format(what, x, truth))
end

local white = ylm.matte { albedo = 0.5 }

describe("radiosity:lightmap", function()
  it("finds the light in a sphere around a lamp, which is the same everywhere", function()
    local t = ylm.scene "globe" {
      geometry = { ylm.sphere { radius = 1, divide = { 64, 32 }, material = white } },
      lights = { ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1, radiance = 10 } },
    }:links { spacing = 0.3, rays = 64 }
    local image, report = t:radiosity():lightmap { mesh = 1, size = { 32, 16 }, rays = 64, light_samples = 4 }
    local E, coverage = image:layer "irradiance", image:layer "coverage"
    local truth = pi * 10 * 0.1 ^ 2 / (1 - 0.5)
    assert.same({ 32 * 16, 0 }, { report.texels, report.overlaps })
    for i = 1, 16, 3 do
      for k = 1, 32, 5 do
        assert.equal(1, coverage:get(i, k, 1))
        near(E:get(i, k, 1), truth, 0.02, "texel " .. i .. " " .. k)
      end
    end
  end)

  it("stands upright: v grows upwards, u to the right; direct light is that of each texel", function()
    local at = { 0.75, 0.5, -0.75 }
    local t = ylm.scene "floor" {
      geometry = { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 }, material = white } },
      lights = { ylm.sphere_light { at = at, radius = 0.05, radiance = 100 } },
    }:links { spacing = 1, rays = 8, sides = "front" }
    local E = t:radiosity():lightmap({ mesh = 1, size = { 8, 8 }, rays = 4 }):layer "irradiance"
    for i = 1, 8 do
      for k = 1, 8 do
        local x, z = (k - 0.5) / 8, -(1 - (i - 0.5) / 8)
        local d2 = (x - at[1]) ^ 2 + at[2] ^ 2 + (z - at[3]) ^ 2
        near(E:get(i, k, 1), pi * 100 * 0.05 ^ 2 / d2 * at[2] / math.sqrt(d2), 5e-3, "texel " .. i .. " " .. k)
      end
    end
  end)

  it("adds what links bring to direct light, whatever the number of threads", function()
    local room = elements.room(0.5, ylm.box { bounds = { { -0.3, 0, -0.3 }, { 0.3, 0.6, 0.3 } }, material = white })
    local lit = room:links({ spacing = 0.5, rays = 32 }):radiosity()
    local function map(part, threads)
      return lit:lightmap({ mesh = 1, size = { 12, 12 }, rays = 16, part = part,
        threads = threads }):layer("irradiance"):totable()
    end
    local all, direct, indirect = map "all", map "direct", map "indirect"
    assert.same(all, map("all", 1))
    assert.same(all, map("all", 7))
    for i = 1, 12 do
      for k = 1, 12 do near(direct[i][k][1] + indirect[i][k][1], all[i][k][1], 1e-5, "texel") end
    end
    assert.is_true(indirect[2][2][1] > 0.05 * direct[2][2][1])
    local image, report = lit:lightmap { mesh = 1, size = { 20, 20 }, rays = 16, gutter = 1 }
    assert.equal(400 - 36, report.texels) -- 6 x 6 of them are under the box
    assert.is_true(image:layer "irradiance":get(8, 8, 1) > 0 and image:layer "irradiance":get(10, 10, 1) < 1e-6)
  end)

  it("fills a gutter around its texels, and counts those of several triangles", function()
    local function half(uvs)
      return ylm.scene "half" {
        geometry = { ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 0, -1 }, { 0, 0, -1 } }, material = white,
          triangles = { { 1, 2, 3 }, { 1, 3, 4 } }, uvs = uvs } },
        lights = ylm.sphere_light { at = { 0.5, 5, -0.5 }, radius = 0.1, radiance = 10 },
      }:links({ spacing = 2, rays = 4 }):radiosity()
    end
    local lit = half { { 0, 0 }, { 0.5, 0 }, { 0.5, 1 }, { 0, 1 } }
    local image, report = lit:lightmap { mesh = 1, size = { 8, 4 }, gutter = 2, rays = 4 }
    local E, coverage = image:layer "irradiance", image:layer "coverage"
    assert.same({ 16, 0 }, { report.texels, report.overlaps })
    assert.same({ 1, 0 }, { coverage:get(2, 4, 1), coverage:get(2, 5, 1) })
    assert.is_true(E:get(2, 5, 1) > 0.9 * E:get(2, 4, 1) and E:get(2, 6, 1) > 0)
    assert.equal(0, E:get(2, 7, 1))
    local twice = half { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 1, 0 } }
    assert.is_true(select(2, twice:lightmap { mesh = 1, size = { 8, 8 }, rays = 4 }).overlaps > 10)
  end)
end)

describe("radiosity:save", function()
  it("writes a PLY whose triangles are the elements, with their light", function()
    local folder = scratch.new()
    local t = elements.room({ 0.5, 0.2, 0.1 }):links { spacing = 1, rays = 16, sides = "front" }
    local lit, path = t:radiosity(), folder.path .. "/room.ply"
    assert(lit:save(path))
    local mesh = ylm.mesh({ file = path }).mesh
    assert.equal(t.stats.elements, #mesh)
    for i, corner in ipairs { { -1, 0, -1 }, { 1, 2, 1 } } do
      for a = 1, 3 do assert.is_true(math.abs(mesh.bounds[i][a] - corner[a]) < 1e-6) end
    end
    local bytes = folder:read "room.ply"
    local head = bytes:match "^.-end_header\n"
    assert.equal(#head + t.stats.elements * (3 * 27 + 37), #bytes)
    -- The faces' first numbers are irradiances: of element 1, float little-endian.
    local function float(at)
      local a, b, c, d = bytes:byte(at, at + 3)
      local exponent, fraction = (d % 128) * 2 + math.floor(c / 128), (c % 128) * 65536 + b * 256 + a
      return (1 + fraction / 2 ^ 23) * 2 ^ (exponent - 127)
    end
    local face = #head + t.stats.elements * 3 * 27
    for i = 1, t.stats.elements, 7 do
      near(float(face + (i - 1) * 37 + 14), lit:irradiance():get(i, 1), 1e-6, "irradiance")
      near(float(face + (i - 1) * 37 + 26), lit:irradiance "direct":get(i, 1), 1e-6, "direct")
    end
    folder:remove()
  end)
end)
