-- Skies that rays see as they are: images and skies of the CIE, sampled by their pixels, and their harmonics.

local core = require "ylm.c.core"
local lib = require "ylm.c.scene"
local ylm = require "ylm"
local tracing = require "ylm.trace"
local relative = require "spec.support.vectors".relative
local scratch = require "spec.support.scratch"
local spread = require("spec.support.random").spread
local ways = require "spec.support.ways"

local up, here = { 0, 1, 0 }, { 0, 0, 0 }

--- An image of w x h pixels f(x, y), counted from 1 at the top left.
local function image(w, h, f)
  local made, rows = ylm.image { size = { w, h } }, {}
  for y = 1, h do
    rows[y] = {}
    for x = 1, w do rows[y][x] = { f(x, y) } end
  end
  core.array_fill(made:layer(), rows)
  return made
end

local function patchy(x, y)
  local v = math.max(0, math.sin(5 * x + 3 * y) + 0.3)
  return v, v * v, 0.5 * v
end

local function black() return 0, 0, 0 end

--- Black but for one pixel.
local function spot(w, h, at, value)
  return image(w, h, function(x, y)
    local v = x == at[1] and y == at[2] and value or 0
    return v, v, v
  end)
end

--- A white floor under lights, seen from above.
local function floor_under(lights)
  return ylm.scene "floor" {
    camera = ylm.camera { from = { 0, 5, 0.01 }, at = { 0, 0, 0 }, up = { 0, 0, -1 }, fov = 20 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = ylm.matte { albedo = 1 } },
    lights = lights,
  }
end

--- Mean and relative deviation of the middle of a picture, channel 1.
local function middle(picture)
  local rows = picture:layer():totable()
  local n, sum, squares = 0, 0, 0
  for y = math.floor(#rows / 4) + 1, math.floor(3 * #rows / 4) do
    for x = math.floor(#rows / 4) + 1, math.floor(3 * #rows / 4) do
      n, sum, squares = n + 1, sum + rows[y][x][1], squares + rows[y][x][1] ^ 2
    end
  end
  return sum / n, math.sqrt(math.max(0, squares / n - (sum / n) ^ 2)) / (sum / n)
end

local function handle(lights) return tracing.trace("spec", floor_under(lights)).handle end

local function uniforms(n, seed)
  local random, rows = spread(seed), {}
  for i = 1, n do rows[i] = { random(), random(), random() } end
  return ylm.array(rows, "double")
end

--- The skies that are looked at, each with an image whose pixels are whole parts of its own.
local skies = {
  { "latlong, y up", { image = image(16, 8, patchy), up = "y" }, "latlong", "y", { 16, 8 }, 1e-6 },
  { "latlong, z up", { image = image(4, 2, patchy), up = "z" }, "latlong", "z", { 16, 8 }, 1e-6 },
  -- a part of the pixels along the rim lies outside of the disc, and rays to it are lost
  { "angular", { image = image(15, 15, patchy), mapping = "angular" }, "angular", "z", { 120, 120 }, 1e-2 },
  { "cube", { image = image(6, 36, patchy), mapping = "cube" }, "cube", "z", { 24, 144 }, 2e-3 },
  { "CIE", { sky = { kind = "clear", zenith = up, sun = { 1, 1, 0 }, luminance = 3 } }, "latlong", "z", { 128, 64 }, 1e-6 },
  { "coefficients", { coefficients = { 1, 0.8, -0.3, 0.6 } }, "latlong", "z", { 128, 64 }, 1e-6 },
  { "radiance", { radiance = { 1, 2, 3 } }, "latlong", "y", { 64, 32 }, 2e-3 },
}

--- Directions of the fine image of such a row, their solid angles, density and radiance as tables.
local function looked_at(row, scene, normal)
  local fine = ylm.image { size = row[5] }
  local d, w = fine:directions { mapping = row[3], up = row[4] }
  local inside, angles = {}, {}
  for i, v in ipairs(core.array_totable(d)) do
    if v[1] ~= 0 or v[2] ~= 0 or v[3] ~= 0 then inside[#inside + 1], angles[#angles + 1] = v, w[i] end
  end
  return inside, angles, lib.chooser_sky(scene, here, normal, ylm.array(inside, "float")):totable()
end

describe("a sky that rays are aimed at", function()
  for _, row in ipairs(skies) do
    it("has a density that integrates to 1: " .. row[1], function()
      local scene = handle(ylm.environment_light(row[2]))
      for _, normal in ipairs { up, { 0.6, -0.8, 0 }, false } do
        local _, angles, seen = looked_at(row, scene, normal or nil)
        local sum = 0
        for i, s in ipairs(seen) do sum = sum + s[1] * angles[i] end
        assert.is_near(1, sum, row[6])
      end
    end)

    it("is sampled as that density says (chi squared over 32 parts of the image): " .. row[1], function()
      local scene = handle(ylm.environment_light(row[2]))
      local normal = row[4] == "y" and up or { 0, 0, 1 }
      local directions, angles, seen = looked_at(row, scene, normal)
      local fine, o, n = ylm.image { size = row[5] }, { mapping = row[3], up = row[4] }, 16384
      --- Counts weights of those directions of a list that are above the horizon.
      local function counted(list, weight)
        local parts = {}
        for k = 0, 31 do parts[k] = 0 end
        for i, at in ipairs(fine:positions(list, o):totable()) do
          local d = list[i]
          if normal[2] * d[2] + normal[3] * d[3] > 0 then
            local k = math.floor(8 * at[1] / row[5][1]) % 8 + 8 * (math.floor(4 * at[2] / row[5][2]) % 4)
            parts[k] = parts[k] + weight(i)
          end
        end
        return parts
      end
      local expected = counted(directions, function(i) return n * seen[i][1] * angles[i] end)
      local rays = {}
      for _, s in ipairs(lib.chooser_sample(scene, here, normal, uniforms(n, 7)):totable()) do
        if s[4] > 0 then rays[#rays + 1] = { s[1], s[2], s[3] } end
      end
      local found, chi, freedom = counted(rays, function() return 1 end), 0, -1
      for k = 0, 31 do
        if expected[k] > 8 then
          chi, freedom = chi + (found[k] - expected[k]) ^ 2 / expected[k], freedom + 1
        else
          assert(found[k] < 30)
        end
      end
      assert(freedom > 5 and chi < freedom + 4.5 * math.sqrt(2 * freedom), ("%g of %d"):format(chi, freedom))
    end)

    it("brings the irradiance that a quadrature finds, within four standard errors: " .. row[1], function()
      local scene = handle(ylm.environment_light(row[2]))
      local normal, n = row[4] == "y" and up or { 0, 0, 1 }, 8192
      local directions, angles, seen = looked_at(row, scene, normal)
      local truth, sum, squares = 0, 0, 0
      for i, d in ipairs(directions) do
        truth = truth + seen[i][2] * angles[i] * math.max(0, normal[2] * d[2] + normal[3] * d[3])
      end
      for _, s in ipairs(lib.chooser_sample(scene, here, normal, uniforms(n, 23)):totable()) do
        local x = s[4] > 0 and s[5] * math.max(0, normal[2] * s[2] + normal[3] * s[3]) / s[4] or 0
        sum, squares = sum + x / n, squares + x * x / n
      end
      local noise = math.sqrt(math.max(0, squares - sum * sum) / n)
      assert(noise < 0.01 * truth, noise / truth)
      assert.is_near(truth, sum, 4 * noise + 3e-3 * truth)
    end)

    it("returns with a ray the density and the radiance of its direction: " .. row[1], function()
      local scene = handle(ylm.environment_light(row[2]))
      local samples = lib.chooser_sample(scene, here, up, uniforms(2000, 3)):totable()
      local directions, same = {}, 0
      for i, s in ipairs(samples) do directions[i] = { s[1], s[2], s[3] } end
      for i, t in ipairs(lib.chooser_sky(scene, here, up, ylm.array(directions, "float")):totable()) do
        local s = samples[i]
        if s[4] == 0 then t[1], t[2] = 0, s[5] end
        if math.abs(s[4] - t[1]) <= 1e-4 * t[1] and math.abs(s[5] - t[2]) <= 1e-4 * t[2] then same = same + 1 end
      end
      assert(same >= 1998, same) -- rounding to float may carry one over an edge
    end)
  end

  it("never sends a ray to a dark pixel, or below the horizon of an upper half", function()
    local scene = handle(ylm.environment_light { image = spot(64, 32, { 40, 9 }, 5), up = "y" })
    for _, s in ipairs(lib.chooser_sample(scene, here, up, uniforms(1000, 5)):totable()) do
      assert(s[4] > 0 and s[5] == 5)
    end
  end)

  it("with one bright pixel brings the closed form, far less noisily than directions by the cosine", function()
    local w, h, x, y, value = 64, 32, 33, 10, 1000
    local a, b = math.pi * (y - 1) / h, math.pi * y / h
    local truth = value * 2 * math.pi / w * (math.sin(b) ^ 2 - math.sin(a) ^ 2) / 2 / math.pi
    local sky = ylm.environment_light { image = spot(w, h, { x, y }, value), up = "y" }
    local mean, deviation = middle(floor_under(sky):render { bounces = 0, size = { 32, 32 }, samples = 1, light_samples = 16 })
    assert.is_near(truth, mean, 1e-3 * truth)
    -- by the cosine a share p = truth/value of rays meets the pixel: the deviation of 16 is sqrt((1/p - 1)/16)
    local by_cosine = math.sqrt((value / truth - 1) / 16)
    assert(by_cosine / deviation > 300, by_cosine / deviation)
  end)

  it("of the CIE is less noisy by its table than by the cosine", function()
    for _, kind in ipairs { "overcast", "clear", "partly cloudy" } do
      local sky = { kind = kind, zenith = up, sun = { 1, 0.5, 0 } }
      local scene, rays = handle(ylm.environment_light { sky = sky }), uniforms(4096, 11)
      local by_table, by_cosine = { 0, 0 }, { 0, 0 }
      local function add(to, x) to[1], to[2] = to[1] + x / 4096, to[2] + x * x / 4096 end
      for _, s in ipairs(lib.chooser_sample(scene, here, up, rays):totable()) do
        add(by_table, s[4] > 0 and s[5] * math.max(0, s[2]) / s[4] or 0)
      end
      local cosine = {}
      for i, u in ipairs(rays:totable()) do
        local r = math.sqrt(u[2])
        cosine[i] = { r * math.cos(2 * math.pi * u[3]), math.sqrt(1 - u[2]), r * math.sin(2 * math.pi * u[3]) }
      end
      for _, t in ipairs(lib.chooser_sky(scene, here, up, ylm.array(cosine, "float")):totable()) do
        add(by_cosine, math.pi * t[2])
      end
      assert.is_near(by_cosine[1], by_table[1], 0.03 * by_cosine[1])
      local ratio = (by_cosine[2] - by_cosine[1] ^ 2) / (by_table[2] - by_table[1] ^ 2)
      assert(ratio > (kind == "overcast" and 1.3 or 5), ("%s: %g"):format(kind, ratio))
    end
  end)
end)

describe("ylm.environment_light { image }", function()
  it("is seen as its pixels are", function()
    local sky = ylm.environment_light { image = image(16, 8, patchy), up = "y", scale = 2 }
    local scene = ylm.scene "seen" { lights = sky,
      camera = ylm.camera { from = { 0, 0, 0 }, at = { 0, 0, -1 }, up = up, fov = 40 } }
    local seen = scene:render { bounces = 0, size = { 16, 16 }, samples = 1, light_samples = 1 }:layer():totable()
    local directions = image(16, 8, black):positions({ { 0.02, -0.1, -1 } }, { up = "y" }):totable()[1]
    local at = { math.floor(directions[1]) + 1, math.floor(directions[2]) + 1 }
    local found = {}
    for y = 1, 16 do
      for x = 1, 16 do
        for k = at[1] - 2, at[1] + 1 do
          for j = at[2] - 2, at[2] + 1 do
            if math.abs(seen[y][x][2] - 2 * select(2, patchy(k, j))) < 1e-5 then found[y * 16 + x] = true end
          end
        end
        assert.is_true(found[y * 16 + x])
      end
    end
  end)

  it("of one value is like a radiance: in harmonics, seen, and by rays", function()
    local flat = ylm.environment_light { image = image(64, 32, function() return 0.7, 0.5, 0.25 end), up = "y" }
    local same = ylm.environment_light { radiance = { 0.7, 0.5, 0.25 } }
    local L = ylm.light_field(4, flat, { here }, { dtype = "double" })
    assert(relative(L, ylm.light_field(4, same, { here }, { dtype = "double" })) < 2e-3) -- pixels stand at their middle
    local by_image = middle(floor_under(flat):render { bounces = 0, size = { 32, 32 }, samples = 1, light_samples = 64 })
    local by_radiance, deviation = middle(floor_under(same):render { bounces = 0, size = { 32, 32 }, samples = 1,
      light_samples = 64 })
    assert.is_near(0.7, by_radiance, 1e-6)
    assert(deviation < 1e-5, deviation)
    assert.is_near(0.7, by_image, 2e-3)
  end)

  it("adds to other skies, suns and lamps", function()
    local parts = { ylm.environment_light { image = image(16, 8, patchy), up = "y" },
      ylm.environment_light { sky = { zenith = up } }, ylm.environment_light { radiance = 0.4 },
      ylm.sun_light { direction = { 1, 2, 0 }, angle = 5, irradiance = 2 },
      ylm.sphere_light { at = { 2, 2, 0 }, radius = 0.3, radiance = 8 } }
    local o, sum = { size = { 24, 24 }, samples = 1, light_samples = 256 }, 0
    for _, part in ipairs(parts) do sum = sum + middle(floor_under(part):render(ways.rays(o))) end
    assert.is_near(sum, (middle(floor_under(parts):render(ways.rays(o)))), 4e-3 * sum)
  end)

  it("that is black is darkness", function()
    local sky = ylm.environment_light { image = image(8, 4, black) }
    assert.equal(0, (middle(floor_under(sky):render { bounces = 0, size = { 8, 8 }, samples = 1, light_samples = 16 })))
    local L = ylm.light_field(2, sky, { here })
    assert.equal(0, (select(3, core.array_distance(L, L))))
  end)

  it("is followed by grids like any environment", function()
    local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 2, channels = "rgb",
      dynamic = true }
    local first = ylm.environment_light { image = image(16, 8, patchy), up = "y", lmax = 2 }
    local second = ylm.environment_light { sky = { zenith = up, luminance = 2 } }
    local grid = ylm.bake(form, first)
    assert(grid:update({ second }, { tolerance = 0 }).lights > 0)
    assert(relative(grid:sample { here }, ylm.bake(form, second):sample { here }) < 2e-6)
  end)

  it("refuses pixels and shapes that are none of a sky, and degrees that it was not projected to", function()
    local function refused(message, fields)
      local ok, why = pcall(ylm.environment_light, fields)
      assert.is_false(ok)
      assert.truthy(why:find("environment_light: " .. message, 1, true), why)
    end
    local function with(value)
      return image(8, 4, function(x, y) return x == 3 and y == 2 and value or 1, 1, 1 end)
    end
    refused("image: pixel (3, 2) is negative", { image = with(-1e-3) })
    refused("image: pixel (3, 2) is not finite", { image = with(0 / 0) })
    refused("image: pixel (3, 2) is not finite", { image = with(math.huge) })
    refused("an image for mapping 'latlong' is twice as wide as high, got 8x5", { image = image(8, 5, black) })
    refused("an image for mapping 'cube' is six times as high as wide", { image = image(8, 4, black), mapping = "cube" })
    refused("image must be a ylm.image, got", { image = { { 1 } } })
    refused("give one of radiance, coefficients, image, file and sky, got image and sky",
      { image = image(8, 4, black), sky = {} })
    refused("sky: a clear sky needs sun = {x, y, z}", { sky = { kind = "clear" } })
    refused("sky: the sun must be above the horizon", { sky = { kind = "clear", sun = { 0, 0, -1 } } })
    refused("sky: no field 'knd' (did you mean 'kind'?)", { sky = { knd = "clear" } })
    refused("lmax is for an image, a file or a sky", { radiance = 1, lmax = 3 })
    local low = ylm.environment_light { image = image(8, 4, patchy), lmax = 3 }
    local ok, why = pcall(ylm.light_field, 4, low, { here })
    assert.is_false(ok)
    assert.truthy(why:find("projected to lmax 3 (lmax = in environment_light), and asked for at lmax 4", 1, true), why)
    local closed = image(8, 4, black)
    closed:close()
    refused("the image has been closed", { image = closed })
  end)
end)

describe("ylm.environment_light { sky }", function()
  it("has the coefficients of ylm.sh.sky, and its luminance in pictures", function()
    for _, kind in ipairs { "overcast", "clear", "partly cloudy" } do
      local options = { kind = kind, zenith = up, sun = { 1, 1, 0.5 }, luminance = 2 }
      local sky = ylm.environment_light { sky = options, scale = 1.5 }
      local c, f = ylm.sh.sky(6, options)
      local L = ylm.light_field(6, sky, { here }, { dtype = "double" })
      for k = 1, 49 do assert.is_near(1.5 * c[k], L:get(1, 2, k), 1e-12) end
      local directions = { { 0.6, 0.64, 0.48 }, { 0, 1, 0 }, { 0.8, -0.6, 0 } }
      local seen = lib.chooser_sky(handle(sky), here, nil, ylm.array(directions, "float")):totable()
      for i, d in ipairs(directions) do assert.is_near(1.5 * f(d[1], d[2], d[3]), seen[i][2], 1e-5) end
    end
  end)

  it("lights a floor: 7/9 of the zenith where it is overcast", function()
    local sky = ylm.environment_light { sky = { luminance = 9 } } -- up is y
    local scene = floor_under(sky)
    assert.is_near(7, (middle(scene:render { bounces = 0, size = { 32, 32 }, samples = 1, light_samples = 256 })), 7 * 2e-3)
    assert.is_near(7, (middle(scene:render { by = "sum", size = { 8, 8 }, samples = 1, visibility = "none", lmax = 8 })), 7e-3)
  end)

  it("may stand in a scene file", function()
    local folder = scratch.new()
    folder:write("sky.lua", [[return scene "sky" { lights = environment_light { sky = { kind = "clear", sun = { 0, 1, 1 } } } }]])
    local scene, why = ylm.load(folder.path .. "/sky.lua")
    folder:remove()
    assert.equal(1, scene and #scene.lights, why)
  end)
end)
