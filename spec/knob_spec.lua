-- The knob of pictures, scene:render { tolerance = }: the pixels that it judges, its promise where few pixels have most of the
-- error, and what it says before it works.

local long = require "spec.support.long"
local spots = require "spec.support.spots"
local tracing = require "ylm.trace"
local ylm = require "ylm"

local lib = tracing.library()

if not lib then
  describe("the knob", function() it("needs scenes", function() pending "scenes are not built in" end) end)
  return
end

--- A picture of 1 with four bright pixels in a row.
local function spotted()
  local picture = ylm.zeros({ 48, 64, 3 }, "float")
  for y = 1, 48 do
    for x = 1, 64 do
      for c = 1, 3 do picture:set(y, x, c, y == 20 and x > 30 and x <= 34 and 50 or 1) end
    end
  end
  return picture
end

describe("pixels that are judged", function()
  local picture = spotted()

  it("are those that are bright, for certain, and others all over the picture, none of much weight", function()
    local pixels, weights = lib.shade_draw(picture, nil, 300, 7)
    local weight, all, once = {}, 0, true
    for i, p in ipairs(pixels) do
      once = once and weight[p] == nil
      weight[p], all = weights[i], all + weights[i]
      assert.is_true(weights[i] >= 1 and weights[i] <= 2 * 48 * 64 / 299)
    end
    assert.is_true(once and #pixels >= 299)
    for x = 30, 33 do assert.equal(1, weight[19 * 64 + x]) end
    assert.near(1, all / (48 * 64), 0.1)
    local quarters = { 0, 0, 0, 0 }
    for _, p in ipairs(pixels) do
      local q = 1 + math.floor(p % 64 / 32) + 2 * math.floor(p / 64 / 24)
      quarters[q] = quarters[q] + 1
    end
    for _, n in ipairs(quarters) do assert.is_true(n > 40, table.concat(quarters, " ")) end
  end)

  it("say the sum over the picture without bias, and follow a second picture", function()
    local other, sum = spotted(), 0
    other:set(5, 5, 1, 9)
    local function value(p) return 1 + (p * 37 % 101) / 50 end
    local all = 0
    for p = 0, 48 * 64 - 1 do all = all + value(p) end
    for seed = 1, 40 do
      local pixels, weights = lib.shade_draw(picture, other, 200, seed)
      local found
      for i, p in ipairs(pixels) do
        sum = sum + weights[i] * value(p) / 40
        found = found or p == 4 * 64 + 4
      end
      assert.is_true(found)
    end
    assert.near(1, sum / all, 0.02)
  end)

  it("are all where there are few, and evenly chosen in the dark", function()
    local pixels, weights = lib.shade_draw(ylm.zeros({ 3, 5, 3 }, "float"), nil, 20, 1)
    assert.equal(15, #pixels)
    for i = 1, 15 do assert.equal(1, weights[i]) end
    pixels, weights = lib.shade_draw(ylm.zeros({ 30, 50, 3 }, "float"), nil, 20, 1)
    assert.is_true(#pixels >= 19)
    for i = 1, #pixels do assert.near(75, weights[i], 1e-9) end
  end)
end)

describe("the judge of pixels", function()
  local views = require "ylm.render.view"

  --- The view of a square whose corners have colours; its edges cross pixels.
  local function view(share)
    local mesh = ylm.mesh { vertices = { { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 }, { -1, 1, 0 } },
      triangles = { { 1, 2, 3 }, { 1, 3, 4 } }, colours = { { 1, 0.2, 0.1 }, { 0.1, 0.9, 0.3 }, { 0.2, 0.1, 0.8 },
        { 0.9, 0.9, 0.2 } }, material = ylm.matte { albedo = 0.8 } }
    local scene = ylm.scene "a coloured square" { geometry = mesh, camera = ylm.camera { from = { 0, 0, 3 }, at = { 0, 0, 0 },
      fov = 50 }, lights = ylm.sphere_light { at = { 0.5, 0.4, 1 }, radius = 0.1, radiance = 50 } }
    return views.open("spec", assert(views.prepare("spec", scene, { size = { 8, 6 }, samples = 32, share = share, seed = 3,
      shading = "pixel", visibility = "rays", lmax = 0 }))).view
  end

  it("finds the light of their points, by their shares of the pixel, and nothing where no surface is", function()
    local v, o = view(0), { samples = 1024, first = 1, last = 1, seed = 5 }
    local points = assert(lib.shade_judge(v, { samples = 64, first = 1, last = 1, seed = 5 }))
    local there, here = lib.shade_resolve(v, points, nil, false, 0):reshape { 48, 3 }, assert(lib.shade_judge_pixels(v, o))
    assert.same({ 48, 3 }, here.shape)
    local dark = 0
    for i = 1, 48 do
      for c = 1, 3 do
        local truth = there:get(i, c)
        if truth == 0 then dark = dark + 1 end
        assert.near(truth, here:get(i, c), 0.02 * truth)
      end
    end
    assert.is_true(dark > 0 and dark < 100)
  end)

  it("knows the variance of its noise", function()
    local v, off, variance = view(0), 0, 0
    for seed = 1, 40, 2 do
      local a, va = lib.shade_judge_pixels(v, { samples = 64, first = 1, last = 2, seed = seed })
      local b, vb = lib.shade_judge_pixels(v, { samples = 64, first = 1, last = 2, seed = seed + 1 })
      off, variance = off + ((a - b) ^ 2):sum(), variance + va:sum() + vb:sum()
    end
    assert.near(1, off / variance, 0.15)
  end)

  it("needs a shading point of each camera ray", function()
    local ok, message = lib.shade_judge_pixels(view(1.5), { samples = 16, first = 1, last = 1, seed = 1 })
    assert.is_nil(ok)
    assert.matches("camera rays that are not grouped", message)
  end)
end)

describe("a tolerance of a picture with a bright spot", function()
  local before
  setup(function() before = ylm.on_warning(false) end)
  teardown(function() ylm.on_warning(before) end)

  --- The squared error of a picture by the knob, that less two standard errors and its report.
  local function judged(number, o, samples)
    local scene = spots.scene(number)
    o.bounces = number % 2 == 1 and "all" or 0
    local image, report = assert(scene:render(o))
    local truth = assert(scene:pathtrace { size = o.size, samples = samples, layers = false,
      reflections = { 1, o.bounces == 0 and 1 or "all" } })
    local square, u = spots.error(image, truth)
    return square, square - 2 * u, report
  end

  it("knows the error of few pixels, or says by how much it may be larger", function()
    local size, outside, pictures = long({ 48, 27 }, { 96, 54 }), {}, 0
    for number = long(26, 1), long(26, 40) do
      local square, least, report = judged(number, { size = size, tolerance = 0.03, samples = 4, share = 1.5,
        light_samples = 16 }, long(128, 1024))
      pictures = pictures + 1
      if least > report.judged.most ^ 2 then outside[#outside + 1] = number end
      assert.near(1, report.error / math.sqrt(square), 0.25)
    end
    assert.is_true(#outside <= 0.05 * pictures, table.concat(outside, " "))
  end)

  if long(false, true) then it("is kept in 95 % of those of which the knob is sure", function()
    local broken, sure, pictures = {}, 0, 0
    for number = 1, 40 do
      local _, least, report = judged(number, { size = { 96, 54 }, tolerance = 0.03 }, 512)
      pictures = pictures + 1
      if report.met and report.judged.sure then
        sure = sure + 1
        if least > 0.03 ^ 2 then broken[#broken + 1] = number end
      end
    end
    assert.is_true(#broken <= 0.05 * sure, table.concat(broken, " "))
    assert.is_true(sure >= 0.5 * pictures, sure)
  end) end
end)

describe("a tolerance", function()
  it("says what it chose and how long that takes, before it does it", function()
    local said, stderr = {}, io.stderr
    finally(function() rawset(io, "stderr", stderr) end)
    rawset(io, "stderr", { flush = function() end, write = function(_, ...)
      for _, s in ipairs { ... } do said[#said + 1] = s end
    end })
    local scene = spots.scene(3)
    local _, report = scene:render { size = { 8, 5 }, tolerance = 0.5, samples = 1, share = 1.5, progress = true, bounces = 0 }
    rawset(io, "stderr", stderr)
    local text = table.concat(said)
    local rays, shadow, at = text:match("ylm: tolerance 0.5 chooses (%d+) camera rays a pixel %(share 1.5%), (%d+) shadow "
      .. "rays; ()")
    assert.equal(report.chosen.samples, tonumber(rays))
    assert.equal(report.chosen.light_samples, tonumber(shadow))
    assert.truthy(text:find("^the picture takes about %d+:%d%d, to judge it %d+:%d%d to %d+:%d%d\n", at), text)
  end)
end)

describe("the error of elements", function()
  local function lit(scene, spacing)
    return scene:links({ spacing = spacing, rays = 128, lmax = 0 }):radiosity(nil, { light_samples = 64 })
  end

  it("is that of the light that they send to pixels, within a factor, and falls with the spacing", function()
    local box = ylm.box { bounds = { { -0.6, 0, -0.6 }, { -0.1, 0.8, -0.1 } }, material = ylm.matte { albedo = 0.5 } }
    local scene = require "spec.support.elements".room(0.6, box)
    scene.camera = ylm.camera { from = { 0.7, 1.2, 0.9 }, at = { 0, 0.6, -0.4 }, fov = 70 }
    local view = scene:prepare { size = { 18, 12 }, samples = 4, share = 0 }
    local function picture(from)
      local image = view:render { bounced = from, rays = 256, light_samples = 1, layers = false }
      return ylm.array(image:layer "radiance", "double")
    end
    local direct = ylm.array(view:render({ light_samples = 1, layers = false }):layer "radiance", "double")
    local truth, last = picture(lit(scene, 0.1)), math.huge
    for _, spacing in ipairs { 0.4, 0.2 } do
      local one = lit(scene, spacing)
      local is = math.sqrt(((picture(one) - truth) ^ 2):mean()) / (truth - direct):mean()
      local says = one.stats.elements_error
      assert.is_true(says > 0.5 * is and says < 4 * is, ("%g: says %g, is %g"):format(spacing, says, is))
      assert.is_true(says < last)
      last = says
    end
  end)

  it("stays that of the making while lamps move, and stands in the report", function()
    local scene = spots.scene(1)
    local one = lit(scene, 0.4)
    local known = one.stats.elements_error
    one:update { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.2, radiance = 4 } }
    assert.equal(known, one.stats.elements_error)
    local _, report = scene:render { size = { 8, 6 }, samples = 1, rays = 256, bounced = one }
    assert.equal(known, report.elements_error)
    local _, judged = scene:render { size = { 4, 3 }, tolerance = 0.5, bounces = "all", bounced = one.links,
      samples = 1, share = 1.5 }
    assert.is_true(judged.causes.elements > 0)
  end)
end)
