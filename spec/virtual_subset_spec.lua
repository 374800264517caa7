-- virtual = { subset = } of pictures by virtual lights: points that ask a part of the lights, interleaved by pixel, or by chance.

local gathered = require "spec.support.gathered"
local with = require "spec.support.with"
local refused = require "spec.support.raises"
local ylm = require "ylm"
local ways = require "spec.support.ways"

local unpack = table.unpack or unpack -- luacheck: ignore
local silent
setup(function() silent = ylm.on_warning(false) end)
teardown(function() ylm.on_warning(silent) end)

local grey = ylm.matte { albedo = 0.5 }
local lamp = ylm.sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 100 }

--- A box with a smaller one in it.
local function room()
  return ylm.scene "a room" { lights = lamp, camera = ylm.camera { from = { 0.9, 0, 0 }, at = { -1, 0, 0 }, fov = 50 },
    geometry = { ylm.box { scale = 2, material = grey }, ylm.box { at = { -0.3, -0.6, 0.2 }, scale = 0.5, material = grey } } }
end

local function ground()
  return ylm.scene "a floor" { lights = lamp, camera = ylm.camera { from = { 0, 3, 0.01 }, at = { 0, 0, 0 }, fov = 30 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = grey } }
end

describe("interleaved lights", function()
  it("are all lights where these are one light, many times: the mean over a tile of pixels", function()
    local view = ground():prepare { size = { 9, 7 }, samples = 1, share = 0 }
    local many = { at = {}, normal = {}, radius = 0.3, intensity = { 3, 2, 1 } }
    for i = 1, 45 do many.at[i], many.normal[i] = { 0.2, 1, 0.1 }, { 0.6, -0.8, 0 } end
    local lights = ylm.virtual_lights(many)
    local all = gathered(view, lights)
    local got, report = gathered(view, lights, { subset = "interleaved", tile = 3 })
    for i = 1, 7 do
      for j = 1, 9 do
        local top, left, sum = math.max(1, math.min(i - 1, 5)), math.max(1, math.min(j - 1, 7)), 0
        for y = top, top + 2 do for x = left, left + 2 do sum = sum + all:get(y, x, 1) / 9 end end
        assert.is_true(math.abs(got:get(i, j, 1) / sum - 1) < 1e-5)
      end
    end
    assert.equal(9 * 7 * 45 / 9, report.virtual.pairs)
  end)

  it("come near all lights, by any method, for a part of the pairs", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 32, 20 }, samples = 1 }, scene:virtual_lights { count = 300 }
    for _, method in ipairs { "hvl", "vpl", "vsl" } do
      local o = { method = method, samples = method == "vsl" and 4 or nil, shadows = "centre" }
      local all, ra = gathered(view, lights, o)
      local got, rb = gathered(view, lights, with(o, { subset = "interleaved", tile = 2 }))
      local off, sum = 0, 0
      for i = 1, 20 do
        for j = 1, 32 do off, sum = off + (got:get(i, j, 2) - all:get(i, j, 2)) ^ 2, sum + all:get(i, j, 2) ^ 2 end
      end
      assert.is_true(math.sqrt(off / sum) < 0.12, method .. math.sqrt(off / sum))
      assert.is_true(math.abs(rb.virtual.pairs / ra.virtual.pairs - 0.25) < 0.01)
      assert.is_true(rb.rays.virtual < 0.3 * ra.rays.virtual)
    end
  end)

  it("keep meshes apart, and normals of one mesh that differ by more than 20 degrees", function()
    local flat = { { -1, 0, 1 }, { 0, 0, 1 }, { 0, 0, -1 }, { -1, 0, -1 } }
    local wall = { { 0, 0, 1 }, { 0.3, 1, 1 }, { 0.3, 1, -1 }, { 0, 0, -1 } }
    local function mesh(v, t) return ylm.mesh { vertices = v, triangles = t, material = grey } end
    local square = { { 1, 2, 3 }, { 1, 3, 4 } }
    local both = { unpack(flat) }
    for i = 1, 4 do both[4 + i] = wall[i] end
    local lights = { at = {}, normal = {}, radius = 0.1, intensity = 1 } -- light from the right, which the wall gets none of
    for i = 1, 16 do lights.at[i], lights.normal[i] = { 3, 0.4, 0 }, { -1, 0, 0 } end
    lights = ylm.virtual_lights(lights)
    for _, geometry in ipairs { { mesh(flat, square), mesh(wall, square) },
      { mesh(both, { square[1], square[2], { 5, 6, 7 }, { 5, 7, 8 } }) } } do
      local scene = ylm.scene "a corner" { lights = lamp, geometry = geometry,
        camera = ylm.camera { from = { -2, 1.5, 0.01 }, at = { 0, 0.3, 0 }, fov = 40 } }
      local view = scene:prepare { size = { 12, 9 }, samples = 1, share = 0 }
      local all, dark = gathered(view, lights), 0
      local got = gathered(view, lights, { subset = "interleaved", tile = 4 })
      for i = 1, 9 do
        for j = 1, 12 do
          if all:get(i, j, 1) == 0 then
            dark = dark + 1
            assert.equal(0, got:get(i, j, 1))
          end
        end
      end
      assert.is_true(dark > 10 and dark < 9 * 12, dark)
    end
  end)

  it("leave glossy surfaces as they are", function()
    local scene = ylm.scene "gloss" { lights = lamp, camera = room().camera,
      geometry = ylm.box { scale = 2, material = ylm.ggx { alpha = 0.4, f0 = 0.3 } } }
    local view, lights = scene:prepare { size = { 4, 3 }, samples = 1 }, scene:virtual_lights { count = 30, degree = 2 }
    local all, got = gathered(view, lights), gathered(view, lights, { subset = "interleaved" })
    for i = 1, 3 do for j = 1, 4 do assert.is_true(math.abs(got:get(i, j, 1) / all:get(i, j, 1) - 1) < 1e-5) end end
  end)
end)

describe("stochastic lights", function()
  it("have the mean of all, by any method, over seeds", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 5, 4 }, samples = 1, share = 0 }, scene:virtual_lights { count = 120 }
    for _, method in ipairs { "hvl", "vpl", "vsl" } do
      local o = { method = method, samples = method == "vsl" and 64 or nil, shadows = "centre" }
      local all, n, z2, mean, sum = gathered(view, lights, o), 40, 0, 0, 0
      local alpha = 4 * select(2, gathered(view, lights, with(o, { subset = "stochastic" }))).virtual.alpha
      local m, s2 = {}, {}
      for seed = 1, n do
        local got, r = gathered(view, lights, with(o, { subset = "stochastic", alpha = alpha, seed = seed }))
        assert.is_true(r.virtual.kept < 60, r.virtual.kept)
        for k = 1, 20 do
          local x = got:get((k - 1) % 4 + 1, math.floor((k - 1) / 4) + 1, 2)
          m[k], s2[k] = (m[k] or 0) + x / n, (s2[k] or 0) + x * x / n
        end
      end
      for k = 1, 20 do
        local wanted = all:get((k - 1) % 4 + 1, math.floor((k - 1) / 4) + 1, 2)
        local variance = math.max((s2[k] - m[k] ^ 2) / (n - 1), 1e-12 * wanted ^ 2)
        z2, mean, sum = z2 + (m[k] - wanted) ^ 2 / variance / 20, mean + m[k], sum + wanted
      end
      -- of vsl the directions of `all` are random too
      assert.is_true(z2 < 2.2, method .. " " .. z2)
      assert.is_true(math.abs(mean / sum - 1) < 0.02, method .. " " .. mean / sum)
    end
  end)

  it("are all lights where alpha is small, and trace fewer rays where it is not", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 8, 6 }, samples = 1 }, scene:virtual_lights { count = 400 }
    local all, ra = gathered(view, lights, { shadows = "centre" })
    assert.same(all:totable(), gathered(view, lights, { shadows = "centre", subset = "stochastic", alpha = 1e-12 }):totable())
    local _, r = gathered(view, lights, { shadows = "centre", subset = "stochastic" })
    assert.is_true(r.virtual.kept > 40 and r.virtual.kept < 90, r.virtual.kept)
    assert.is_true(r.rays.virtual < 0.3 * ra.rays.virtual and r.virtual.pairs == ra.virtual.pairs and r.virtual.alpha > 0)
  end)

  it("are chosen on glossy surfaces too", function()
    local scene = ylm.scene "gloss" { lights = lamp, camera = room().camera,
      geometry = ylm.box { scale = 2, material = ylm.ggx { alpha = 0.4, f0 = 0.3 } } }
    local view, lights = scene:prepare { size = { 3, 2 }, samples = 1 }, scene:virtual_lights { count = 60, degree = 2 }
    for _, method in ipairs { "hvl", "vpl" } do
      local all, sum, mean, n = gathered(view, lights, { method = method }), 0, 0, 30
      for seed = 1, n do
        local got = gathered(view, lights, { method = method, subset = "stochastic", alpha = 1e-3, seed = seed })
        for i = 1, 2 do for j = 1, 3 do sum, mean = sum + all:get(i, j, 1) / n, mean + got:get(i, j, 1) / n end end
      end
      assert.is_true(math.abs(mean / sum - 1) < 0.03, method .. " " .. mean / sum)
    end
  end)
end)

describe("a part of the lights", function()
  it("is the same whatever the number of threads", function()
    local scene = room()
    local view, lights = scene:prepare { size = { 12, 9 }, samples = 4 }, scene:virtual_lights { count = 90 }
    for _, subset in ipairs { "interleaved", "stochastic" } do
      local first = gathered(view, lights, { subset = subset, threads = 1 }):totable()
      assert.same(first, gathered(view, lights, { subset = subset, threads = 3 }):totable())
    end
  end)

  it("is none of no lights", function()
    local none = ylm.virtual_lights { at = {}, radius = 1, intensity = 1 }
    local view = ground():prepare { size = { 3, 2 }, samples = 1 }
    for _, subset in ipairs { "interleaved", "stochastic" } do
      assert.equal(0, gathered(view, none, { subset = subset }):get(1, 1, 1))
    end
  end)

  it("refuses what does not fit", function()
    local scene = ground()
    local view, lights = scene:prepare { size = { 2, 2 }, samples = 1 }, scene:virtual_lights { count = 5 }
    local function says(pattern, o, v)
      refused(pattern, function() (v or view):render(ways.virtual(with({ lights = lights }, o))) end)
    end
    says("tile is for subset = 'interleaved', this is 'all'", { tile = 4 })
    says("alpha is for subset = 'stochastic', this is 'interleaved'", { alpha = 4, subset = "interleaved" })
    says("tile must be an integer >= 2", { tile = 1, subset = "interleaved" })
    says("alpha must be a number > 0", { alpha = 0, subset = "stochastic" })
    says("subset = 'stochastic' is of single lights", { subset = "stochastic", method = "vsgl" })
    says("subset must be one of 'all', 'interleaved', 'stochastic'", { subset = "few" })
    says("pixels are interleaved: the view has none of its own", { subset = "interleaved" },
      scene:prepare { size = { 2, 2 }, samples = 1, shading = "vertices" })
  end)
end)
