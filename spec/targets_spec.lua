--- Links that are aimed at the elements which send light.

local interiors = dofile "spec/support/interiors.lua"
local vector = require "ylm.vector"
local ylm = require "ylm"

local SIZE, SEEDS, BLOCK = { 48, 27 }, 10, 6

--- The room of a name, and its elements: made once.
local made = {}
local function room(name, spacing)
  for _, r in ipairs(made[name] and {} or interiors(ylm)) do
    if r[1] == name then
      local links = r[2]:links { lmax = 0, rays = 32, spacing = spacing or 0.1 }
      made[name] = { scene = r[2], links = links, lit = links:radiosity() }
    end
  end
  return made[name].scene, made[name].lit, made[name].links
end

local function shot(scene, lit, o)
  return assert(scene:render { size = SIZE, bounced = lit, guides = o.guides, denoise = "auto", light_samples = 16, rays = 64,
    seed = o.seed, threads = o.threads })
end

--- Luminance of blocks of a picture without a filter.
local function blocks(image)
  local out = {}
  for y, row in ipairs(image:layer("raw"):totable()) do
    for x, c in ipairs(row) do
      local k = 100 * math.floor((y - 1) / BLOCK) + math.floor((x - 1) / BLOCK)
      out[k] = (out[k] or 0) + vector.luminance(c)
    end
  end
  return out
end

--- Means of blocks over SEEDS pictures, and the variances of these means.
local function many(scene, lit, guides)
  local sum, square = {}, {}
  for seed = 1, SEEDS do
    for k, l in pairs(blocks((shot(scene, lit, { guides = guides, seed = seed })))) do
      sum[k], square[k] = (sum[k] or 0) + l, (square[k] or 0) + l * l
    end
  end
  for k, l in pairs(sum) do
    sum[k] = l / SEEDS
    square[k] = (square[k] / SEEDS - sum[k] ^ 2) / (SEEDS - 1)
  end
  return sum, square
end

describe("links that are aimed", function()
  it("leave the mean of a lamp behind its shade as it is, at a quarter of its variance", function()
    local scene, lit = room "shade"
    local a, va = many(scene, lit, false)
    local b, vb = many(scene, lit, true)
    local apart, n, before, after = 0, 0, 0, 0
    for k, l in pairs(a) do
      apart, n = apart + (l - b[k]) ^ 2 / (va[k] + vb[k]), n + 1
      before, after = before + va[k], after + vb[k]
    end
    assert.is_true(n > 30)
    assert.is_true(apart / n > 0.6 and apart / n < 1.5, apart / n)
    assert.is_true(after < before / 3, after / before)
  end)

  it("have their pilot in the report, and the same bits on one thread", function()
    local scene, lit = room "shade"
    local one, report = shot(scene, lit, { seed = 3, threads = 1 })
    local two = shot(scene, lit, { seed = 3, threads = 2 })
    assert.is_true(report.targets > 100 and report.rays.targets > 10000)
    assert.is_true(one:layer("raw"):same(two:layer("raw")))
  end)

  it("bring lightmaps the same light with less noise", function()
    local _, _, links = room "shade"
    local function look(guides)
      local lit, sum, square = links:radiosity(nil, { guides = guides, light_samples = 64 }), nil, nil
      for seed = 1, SEEDS do
        local E = lit:lightmap { mesh = 5, size = { 24, 24 }, part = "indirect", rays = 64, seed = seed }:layer "irradiance"
        sum, square = sum and sum + E or E + 0, square and square + E * E or E * E
      end
      local mean = sum / SEEDS
      return mean:sum(), (square / SEEDS - mean * mean):sum() / (SEEDS - 1)
    end
    local a, va = look(false)
    local b, vb = look(true)
    assert.is_true(a > 0 and math.abs(b / a - 1) < 0.02, b / a)
    assert.is_true(vb < va / 3, vb / va)
  end)

  it("are none where links that go as the cosine have little noise", function()
    local scene, lit = room("window", 0.2)
    local _, report = shot(scene, lit, { seed = 1 })
    assert.is_nil(report.targets)
  end)

  it("are none where nothing is lit, nor where guides are left out", function()
    local scene, _, links = room "shade"
    local lit = links:radiosity()
    local _, report = shot(scene, lit, { seed = 1, guides = false })
    assert.is_nil(report.targets)
    lit:update(ylm.sphere_light { at = { 0, -50, 0 }, radius = 0.1, radiance = 0 })
    _, report = shot(scene, lit, { seed = 1 })
    assert.is_nil(report.targets)
  end)
end)
